//! The settings of a scene as TOML: what `.dots` files and plates carry about how they were made.

use dotwork_drawing::{Camera, Lens, Light, LightFrame, Page, Standpoint, UpAxis};
use dotwork_ink::{MAX_STIPPLES, PARAMS, Style};
use dotwork_volume::{Space, Unit};
use glam::DVec3;
use toml::{Table, Value};

use crate::files::one_line;
use crate::moving::{Density, Pose};
use crate::placement::Placement;
use crate::scene::{Scene, Source, World, ZOOM};
use crate::timeline::Timeline;

/// How long a text may be, and how much longer for each byte of its file: while it is understood, a byte may take two
/// hundred, and long texts pack a thousand times.
const LONGEST_TEXT: usize = 512 << 10;
pub(super) const TEXT_PER_BYTE: usize = 2;

/// Characters of an error at most.
const LONGEST_ERROR: usize = 300;

/// Units by their names in files.
const UNITS: [(Unit, &str); 4] =
    [(Unit::Metre, "m"), (Unit::Millimetre, "mm"), (Unit::Micrometre, "um"), (Unit::Nanometre, "nm")];

/// An object as the settings of a picture describe it.
#[derive(Clone, Debug)]
pub struct Described {
    /// Its name.
    pub name: String,
    /// Where it came from.
    pub source: Option<Source>,
    /// What is known about the space in which it lies.
    pub world: World,
    /// How it is drawn.
    pub style: Style,
    /// How many stipples it has; 0 if the settings do not say.
    pub stipples: usize,
}

/// The settings of a scene's baked objects, of its camera, light and page, and the version of dotwork, as TOML.
///
/// The same scene gives the same text, whether it was read from its sources or from a `.dots` file.
pub fn settings_text(scene: &Scene) -> String {
    let mut objects = Vec::new();
    for object in scene.objects.iter().filter(|o| o.stock.is_some()) {
        let mut style = Table::new();
        for param in PARAMS {
            style.insert(param.name.into(), Value::String(param.get(&object.style)));
        }
        let mut table = Table::new();
        table.insert("name".into(), Value::String(object.name.clone()));
        if let Some(source) = &object.source {
            table.insert("source".into(), Value::String(source.file.clone()));
            if let Some(checksum) = source.checksum {
                table.insert("checksum".into(), Value::String(format!("{checksum:016x}")));
            }
            if let Some(raw) = &source.raw {
                table.insert("raw".into(), Value::String(raw.clone()));
            }
            if let Some(series) = &source.series {
                table.insert("series".into(), Value::String(series.clone()));
            }
            if let Some(iso) = source.iso {
                table.insert("iso".into(), Value::Float(iso));
            }
            if let Some(cut) = source.cut {
                table.insert("cut".into(), Value::Integer(cut.into()));
            }
            if let Some(label) = source.label {
                table.insert("label".into(), Value::Integer(label));
            }
            if source.placement != Placement::default() {
                table.insert("placement".into(), Value::String(source.placement.to_string()));
            }
            if let Some(Pose { clip, time }) = &source.pose {
                if let Some(clip) = clip {
                    table.insert("clip".into(), Value::String(clip.clone()));
                }
                if let Some(time) = time {
                    table.insert("time".into(), Value::Float(*time));
                }
            }
            if let Some(time) = source.baked_at {
                table.insert("baked_at".into(), Value::Float(time));
            }
        }
        if object.world.space == Space::Patient {
            table.insert("space".into(), Value::String("patient".into()));
        }
        if let Some((_, name)) = UNITS.iter().find(|(unit, _)| *unit == object.world.unit) {
            table.insert("unit".into(), Value::String((*name).into()));
        }
        let stipples = object.stock.as_ref().map_or(0, |s| s.len());
        table.insert("stipples".into(), Value::Integer(stipples as i64));
        table.insert("style".into(), Value::Table(style));
        objects.push(Value::Table(table));
    }
    let Camera { azimuth, elevation, distance, ortho, zoom, up } = scene.camera;
    let mut camera = Table::new();
    camera.insert("azimuth".into(), number(azimuth));
    camera.insert("elevation".into(), number(elevation));
    if let Some(distance) = distance {
        camera.insert("distance".into(), number(distance));
    }
    camera.insert("ortho".into(), Value::Boolean(ortho));
    camera.insert("zoom".into(), number(zoom));
    camera.insert("up".into(), Value::String(up.to_string()));
    let mut light = Table::new();
    light.insert("azimuth".into(), number(scene.light.azimuth));
    light.insert("elevation".into(), number(scene.light.elevation));
    let frame = match scene.light.frame {
        LightFrame::Viewer => "viewer",
        LightFrame::Object => "object",
    };
    light.insert("frame".into(), Value::String(frame.into()));
    let mut page = Table::new();
    page.insert("width_px".into(), Value::Integer(scene.page.width.into()));
    page.insert("height_px".into(), Value::Integer(scene.page.height.into()));
    page.insert("dpi".into(), number(scene.page.dpi));
    page.insert("margin_px".into(), number(scene.page.margin_px));
    let mut all = Table::new();
    all.insert("dotwork".into(), Value::String(env!("CARGO_PKG_VERSION").into()));
    all.insert("seed".into(), Value::Integer(scene.seed.into()));
    all.insert("stipples".into(), Value::String(scene.stipples.to_string()));
    all.insert("camera".into(), Value::Table(camera));
    all.insert("light".into(), Value::Table(light));
    all.insert("page".into(), Value::Table(page));
    if let Some(bar) = &scene.scale_bar {
        all.insert("scale_bar".into(), Value::String(bar.to_string()));
    }
    if !scene.pens.is_empty() {
        all.insert("pens_mm".into(), Value::Array(scene.pens.iter().map(|&p| number(p)).collect()));
    }
    if scene.density == Density::Follow {
        all.insert("density".into(), Value::String("follow".into()));
    }
    if let Some((center, radius)) = scene.sphere {
        let sphere = [center.x, center.y, center.z, radius];
        all.insert("sphere".into(), Value::Array(sphere.iter().map(|&v| Value::Float(v)).collect()));
    }
    if let Some(Standpoint { eye, back, up, lens }) = &scene.standpoint {
        let mut table = Table::new();
        let vector = |v: DVec3| Value::Array(v.to_array().iter().map(|&v| Value::Float(v)).collect());
        table.insert("eye".into(), vector(*eye));
        table.insert("back".into(), vector(back.as_dvec3()));
        table.insert("up".into(), vector(up.as_dvec3()));
        let (key, value) = match lens {
            Lens::Perspective(tangent) => ("tangent", tangent),
            Lens::Parallel(half) => ("half_height", half),
        };
        table.insert(key.into(), number(*value));
        all.insert("standpoint".into(), Value::Table(table));
    }
    all.insert("object".into(), Value::Array(objects));
    all.to_string()
}

/// The scene without its surfaces, its objects as described, and the version of dotwork that wrote this; from a file
/// of `file_length` bytes.
///
/// # Errors
/// What is missing or impossible, on one line of reasonable length: names and keys may be anything.
pub(crate) fn read(text: &str, file_length: usize) -> Result<(Scene, Vec<Described>, String), String> {
    parse(text, file_length).map_err(|e| one_line(&e).chars().take(LONGEST_ERROR).collect())
}

/// The TOML of the section `name` of a file of `file_length` bytes.
pub(super) fn toml_of(text: &str, name: &str, file_length: usize) -> Result<Table, String> {
    if text.len() > file_length.saturating_mul(TEXT_PER_BYTE).max(LONGEST_TEXT) {
        return Err(format!("section '{name}' of {} bytes is longer than that of any scene", text.len()));
    }
    text.parse().map_err(|_| format!("section '{name}' is not TOML"))
}

fn parse(text: &str, file_length: usize) -> Result<(Scene, Vec<Described>, String), String> {
    let all = toml_of(text, "settings", file_length)?;
    let all = Settings { table: &all, of: "settings" };
    let camera = all.table("camera")?;
    let distance = camera.table.get("distance").map(|_| camera.number("distance", 1.0, 1e6)).transpose()?;
    let light = all.table("light")?;
    let page = all.table("page")?;
    let scene = Scene {
        camera: Camera {
            azimuth: camera.number("azimuth", f32::MIN, f32::MAX)?,
            elevation: camera.number("elevation", -90.0, 90.0)?,
            distance,
            ortho: camera.get("ortho")?.as_bool().ok_or("camera: ortho is not true or false")?,
            zoom: camera.number("zoom", ZOOM.0, ZOOM.1)?,
            up: camera.text("up")?.parse::<UpAxis>()?,
        },
        light: Light {
            azimuth: light.number("azimuth", f32::MIN, f32::MAX)?,
            elevation: light.number("elevation", f32::MIN, f32::MAX)?,
            frame: light.text("frame")?.parse::<LightFrame>()?,
        },
        page: Page {
            width: page.integer("width_px")?,
            height: page.integer("height_px")?,
            dpi: page.number("dpi", 0.0, f32::MAX)?,
            margin_px: page.number("margin_px", 0.0, f32::MAX)?,
        }
        .checked()?,
        stipples: all.text("stipples")?.parse()?,
        seed: all.integer("seed")?,
        scale_bar: all.optional("scale_bar")?.map(str::parse).transpose()?,
        pens: match all.table.get("pens_mm") {
            None => Vec::new(),
            Some(pens) => {
                let pens = pens.as_array().ok_or("settings: pens_mm is not a list")?;
                let pen = |p: &Value| p.as_float().map(|p| p as f32).filter(|p| *p > 0.0 && p.is_finite());
                pens.iter().map(pen).collect::<Option<_>>().ok_or("settings: a pen has no width above 0")?
            }
        },
        objects: Vec::new(),
        timeline: Timeline::default(),
        sphere: match all.table.get("sphere") {
            None => None,
            Some(sphere) => {
                let [x, y, z, r] =
                    numbers(sphere).filter(|s| s[3] > 0.0).ok_or("settings: sphere is not a sphere")?;
                Some((DVec3::new(x, y, z), r))
            }
        },
        density: match all.optional("density")? {
            None => Density::Keep,
            Some(text) => text.parse()?,
        },
        standpoint: match all.table.get("standpoint") {
            None => None,
            Some(_) => Some(standpoint(&all.table("standpoint")?)?),
        },
    };
    let objects = all.get("object")?.as_array().ok_or("settings: object is not a list")?;
    let objects = objects.iter().map(|o| described(o, &all)).collect::<Result<_, _>>()?;
    Ok((scene, objects, all.text("dotwork")?.to_string()))
}

/// As many finite numbers; `None` for anything else.
fn numbers<const N: usize>(list: &Value) -> Option<[f64; N]> {
    let list = list.as_array()?;
    let all: Option<Vec<f64>> = list.iter().map(|v| v.as_float().filter(|v| v.is_finite())).collect();
    all?.try_into().ok()
}

/// The eye of a picture, in the world.
fn standpoint(table: &Settings) -> Result<Standpoint, String> {
    let vector = |key: &str| {
        let found = numbers::<3>(table.get(key)?).map(DVec3::from_array);
        found.ok_or_else(|| format!("standpoint: {key} is not three numbers"))
    };
    let unit = |key: &str| {
        let found = vector(key)?.try_normalize().map(|v| v.as_vec3());
        found.ok_or_else(|| format!("standpoint: {key} has no direction"))
    };
    let lens = match table.table.get("tangent") {
        Some(_) => Lens::Perspective(table.number("tangent", 1e-6, 1e6)?),
        None => Lens::Parallel(table.number("half_height", f32::MIN_POSITIVE, f32::MAX)?),
    };
    Ok(Standpoint { eye: vector("eye")?, back: unit("back")?, up: unit("up")?, lens })
}

fn described(object: &Value, all: &Settings) -> Result<Described, String> {
    let object =
        Settings { table: object.as_table().ok_or("settings: an object is not a table")?, of: "object" };
    let checksum = match object.table.get("checksum") {
        None => None,
        Some(v) => {
            let parse = v.as_str().and_then(|s| u64::from_str_radix(s, 16).ok());
            Some(parse.ok_or("object: checksum is not a hexadecimal number")?)
        }
    };
    let iso = match object.table.get("iso") {
        None => None,
        Some(v) => Some(v.as_float().ok_or("object: iso is not a number")?),
    };
    let raw = object.optional("raw")?.map(String::from);
    let cut = object.table.get("cut").map(|_| object.integer("cut")).transpose()?;
    let series = object.optional("series")?.map(String::from);
    let label = match object.table.get("label") {
        None => None,
        Some(v) => Some(v.as_integer().ok_or("object: label is not a whole number")?),
    };
    let placement = object.optional("placement")?.map_or(Ok(Placement::default()), str::parse)?;
    let time = |key: &str| match object.table.get(key) {
        None => Ok(None),
        Some(v) => {
            let time = v.as_float().filter(|t| t.is_finite());
            time.map(Some).ok_or_else(|| format!("object: {key} is not a number"))
        }
    };
    let (clip, at, baked_at) = (object.optional("clip")?, time("time")?, time("baked_at")?);
    let pose = (clip.is_some() || at.is_some()).then(|| Pose { clip: clip.map(String::from), time: at });
    let source = object.optional("source")?.map(|file| Source {
        file: file.into(),
        checksum,
        raw,
        series,
        iso,
        cut,
        label,
        placement,
        pose,
        baked_at,
    });
    let space = match object.optional("space")? {
        Some("patient") => Space::Patient,
        _ => Space::Unknown,
    };
    let unit = object.optional("unit")?;
    let unit = UNITS.iter().find(|(_, name)| Some(*name) == unit).map_or(Unit::Unknown, |(unit, _)| *unit);
    let world = World { space, unit };
    let stipples = match object.table.get("stipples") {
        None => 0,
        Some(_) => object.integer("stipples")? as usize,
    };
    if stipples > MAX_STIPPLES {
        return Err(format!("object: {stipples} is no possible number of stipples"));
    }
    let mut style = Style::default();
    for (key, value) in object.table("style")?.table {
        let set =
            value.as_str().ok_or_else(|| format!("{key} is not a text")).and_then(|v| style.set(key, v));
        set.map_err(|e| {
            format!("written by dotwork {}: style: {e}", all.text("dotwork").unwrap_or("of unknown version"))
        })?;
    }
    Ok(Described { name: object.text("name")?.into(), source, world, style, stipples })
}

/// A float that reads back as the same `f32`, short where it can be.
pub(super) fn number(v: f32) -> Value {
    let short = v.to_string().parse::<f64>().ok().filter(|d| *d as f32 == v);
    Value::Float(short.unwrap_or(f64::from(v)))
}

/// A table with its name for messages.
struct Settings<'a> {
    table: &'a Table,
    of: &'static str,
}

impl<'a> Settings<'a> {
    fn get(&self, key: &str) -> Result<&'a Value, String> {
        self.table.get(key).ok_or_else(|| format!("{}: {key} is missing", self.of))
    }

    fn table(&self, key: &'static str) -> Result<Settings<'a>, String> {
        let table = self.get(key)?.as_table().ok_or_else(|| format!("{}: {key} is not a table", self.of))?;
        Ok(Settings { table, of: key })
    }

    fn text(&self, key: &str) -> Result<&'a str, String> {
        self.get(key)?.as_str().ok_or_else(|| format!("{}: {key} is not a text", self.of))
    }

    /// A text that may be missing.
    fn optional(&self, key: &str) -> Result<Option<&'a str>, String> {
        let text = |v: &'a Value| v.as_str().ok_or_else(|| format!("{}: {key} is not a text", self.of));
        self.table.get(key).map(text).transpose()
    }

    fn number(&self, key: &str, min: f32, max: f32) -> Result<f32, String> {
        let value = self.get(key)?.as_float().map(|v| v as f32).filter(|v| (min..=max).contains(v));
        value.ok_or_else(|| format!("{}: {key} is not a number from {min} to {max}", self.of))
    }

    fn integer(&self, key: &str) -> Result<u32, String> {
        let value = self.get(key)?.as_integer().and_then(|v| u32::try_from(v).ok());
        value.ok_or_else(|| format!("{}: {key} is not a whole number below 2^32", self.of))
    }
}
