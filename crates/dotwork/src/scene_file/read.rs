//! Reading a scene file: TOML to [`SceneFile`], each error with its line.

use std::path::{Path, PathBuf};

use dotwork_drawing::page::parse_paper_mm;
use dotwork_drawing::{Length, LightFrame, Page, UpAxis};
use dotwork_ink::{Style, find_param, preset};
use dotwork_io::volume::RawLayout;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{SceneFile, SceneObject};
use crate::files::{FileError, LoadOptions, Watch};
use crate::placement::Placement;
use crate::scene::{Stipples, ZOOM};
use crate::settings::Settings;
use crate::style_file::{preset_names, read_style, text_of, with_palette};
use crate::timeline::{Timeline, Track};

/// Scene files that include each other to more than this depth.
const DEEPEST: usize = 16;

/// Most objects of a scene: the ids of stipples have room for no more.
const MOST_OBJECTS: usize = 1 << 15;

/// Reads a scene file, and those that it includes; the files of its objects are not opened.
///
/// # Errors
/// [`FileError::Read`] if it, or one that it includes, cannot be read; [`FileError::Scene`] with the line if it cannot
/// be understood; what [`read_style`] says of a style file that it names.
pub fn read_scene_file(path: impl AsRef<Path>) -> Result<SceneFile, FileError> {
    let path = path.as_ref();
    let mut scene = SceneFile {
        path: path.to_path_buf(),
        objects: Vec::new(),
        settings: Settings::default(),
        watch: Watch::default(),
    };
    let mut chain = Vec::new();
    read_into(path, &mut scene, &mut None, &mut chain)?;
    if scene.objects.is_empty() {
        let reason = "has no [[object]] to draw; a style file is given with --style".into();
        return Err(FileError::Scene { path: path.to_path_buf(), line: 1, reason });
    }
    Ok(scene)
}

type Entry<'a, 'b> = (&'a str, &'a Spanned<DeValue<'b>>, usize);

/// One file of a scene, for its errors and the files that it names.
struct Source<'a> {
    path: &'a Path,
    bytes: &'a [u8],
}

impl Source<'_> {
    fn line(&self, at: usize) -> usize {
        self.bytes[..at.min(self.bytes.len())].iter().filter(|&&b| b == b'\n').count() + 1
    }

    fn error(&self, at: usize, reason: impl Into<String>) -> FileError {
        FileError::Scene { path: self.path.to_path_buf(), line: self.line(at), reason: reason.into() }
    }

    /// A file that this one names.
    fn beside(&self, name: &str) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(name)
    }

    /// Keys, values and where the keys stand, in the order of the file.
    fn entries<'a, 'b>(&self, table: &'a DeTable<'b>) -> Vec<Entry<'a, 'b>> {
        let mut entries: Vec<Entry> =
            table.iter().map(|(key, value)| (key.get_ref().as_ref(), value, key.span().start)).collect();
        entries.sort_by_key(|(_, _, at)| *at);
        entries
    }

    fn table<'a, 'b>(
        &self,
        key: &str,
        value: &'a Spanned<DeValue<'b>>,
    ) -> Result<Vec<Entry<'a, 'b>>, FileError> {
        match value.get_ref() {
            DeValue::Table(table) => Ok(self.entries(table)),
            _ => Err(self.error(value.span().start, format!("{key} is a table: write [{key}]"))),
        }
    }

    fn text(&self, key: &str, value: &Spanned<DeValue>) -> Result<String, FileError> {
        text_of(value.get_ref()).map_err(|e| self.error(value.span().start, format!("{key}: {e}")))
    }

    /// A value that is read from text as `T` is.
    fn parsed<T>(
        &self,
        key: &str,
        value: &Spanned<DeValue>,
        parse: impl FnOnce(&str) -> Result<T, String>,
    ) -> Result<T, FileError> {
        let text = self.text(key, value)?;
        parse(&text).map_err(|e| self.error(value.span().start, format!("{key}: {e}")))
    }

    fn number(&self, key: &str, value: &Spanned<DeValue>, low: f64, high: f64) -> Result<f64, FileError> {
        self.parsed(key, value, |s| {
            let number = s.parse().ok().filter(|v| (low..=high).contains(v));
            number.ok_or_else(|| format!("takes a number from {low} to {high}, not '{s}'"))
        })
    }

    fn numbers<const N: usize>(&self, key: &str, value: &Spanned<DeValue>) -> Result<[f64; N], FileError> {
        let wrong = || self.error(value.span().start, format!("{key} takes {N} numbers, as [1, 2.5]"));
        let DeValue::Array(array) = value.get_ref() else { return Err(wrong()) };
        let all: Result<Vec<f64>, FileError> =
            array.iter().map(|v| self.number(key, v, -1e15, 1e15)).collect();
        <[f64; N]>::try_from(all?).map_err(|_| wrong())
    }

    fn texts(&self, key: &str, value: &Spanned<DeValue>) -> Result<Vec<(String, usize)>, FileError> {
        let DeValue::Array(array) = value.get_ref() else {
            return Err(self.error(value.span().start, format!("{key} takes a list, as [\"a\", \"b\"]")));
        };
        array.iter().map(|v| Ok((self.text(key, v)?, v.span().start))).collect()
    }

    fn unknown(&self, key: &str, at: usize, of: &str, known: &[&str]) -> FileError {
        self.error(at, format!("{of} has no '{key}'; it takes {}", known.join(", ")))
    }

    fn style(&self, value: &Spanned<DeValue>) -> Result<Style, FileError> {
        let name = self.text("style", value)?;
        if let Some(style) = preset(&name) {
            return Ok(style);
        }
        if name.to_ascii_lowercase().ends_with(".toml") {
            return Ok(read_style(self.beside(&name))?.style);
        }
        let reason =
            format!("there is no style '{name}'; the styles are {}, or a style file", preset_names());
        Err(self.error(value.span().start, reason))
    }
}

/// Reads one file over what has been read. `style` is that of objects that name none.
fn read_into(
    path: &Path,
    scene: &mut SceneFile,
    style: &mut Option<Style>,
    chain: &mut Vec<PathBuf>,
) -> Result<(), FileError> {
    let bytes = dotwork_io::read_file(path)?;
    let source = Source { path, bytes: &bytes };
    // The same file by two names is caught by the depth.
    if chain.len() >= DEEPEST || chain.iter().any(|p| p == path) {
        return Err(source.error(0, "includes itself"));
    }
    let text = std::str::from_utf8(&bytes).map_err(|e| source.error(e.valid_up_to(), "is not UTF-8"))?;
    let table = DeTable::parse(text).map_err(|e| {
        let reason = e.message().split('\n').collect::<Vec<_>>().join("; ");
        source.error(e.span().map_or(0, |s| s.start), reason)
    })?;
    let mut entries = source.entries(table.get_ref());
    // What is included lies below, and objects ask for the style.
    let rank = |key: &str| ["include", "style"].iter().position(|k| *k == key).unwrap_or(2);
    entries.sort_by_key(|(key, _, at)| (rank(key), *at));
    let settings = |scene: &mut SceneFile| std::mem::take(&mut scene.settings);
    for (key, value, at) in entries {
        match key {
            "include" => {
                chain.push(path.to_path_buf());
                for (name, _) in source.texts(key, value)? {
                    read_into(&source.beside(&name), scene, style, chain)?;
                }
                chain.pop();
            }
            "style" => *style = Some(source.style(value)?),
            "camera" => {
                let mut all = settings(scene);
                camera(&source, source.table(key, value)?, &mut all)?;
                scene.settings = all;
            }
            "light" => {
                let mut all = settings(scene);
                light(&source, source.table(key, value)?, &mut all)?;
                scene.settings = all;
            }
            "page" => {
                let mut all = settings(scene);
                page(&source, source.table(key, value)?, &mut all)?;
                scene.settings = all;
            }
            "seed" => {
                let seed = source.parsed(key, value, |s| {
                    s.parse::<u32>()
                        .map_err(|_| format!("takes a whole number from 0 to {}, not '{s}'", u32::MAX))
                })?;
                scene.settings.seed = Some(seed);
            }
            "stipples" => {
                scene.settings.stipples = Some(source.parsed(key, value, str::parse::<Stipples>)?)
            }
            "scale_bar" => scene.settings.scale_bar = Some(source.parsed(key, value, str::parse)?),
            "pens_mm" => {
                let DeValue::Array(pens) = value.get_ref() else {
                    return Err(source.error(value.span().start, "pens_mm takes a list, as [0.18, 0.35]"));
                };
                let pens: Result<Vec<f32>, FileError> =
                    pens.iter().map(|v| Ok(source.number(key, v, 0.01, 20.0)? as f32)).collect();
                scene.settings.pens_mm = Some(pens?);
            }
            "object" => {
                let wrong = || source.error(value.span().start, "objects are written as [[object]]");
                let DeValue::Array(objects) = value.get_ref() else { return Err(wrong()) };
                for entry in objects.iter() {
                    let DeValue::Table(table) = entry.get_ref() else { return Err(wrong()) };
                    let entries = source.entries(table);
                    let at = entries.first().map_or(entry.span().start, |e| e.2);
                    scene.objects.extend(object(&source, entries, at, style.as_ref())?);
                    if scene.objects.len() > MOST_OBJECTS {
                        return Err(source.error(at, format!("has more than {MOST_OBJECTS} objects")));
                    }
                }
            }
            _ => {
                const KNOWN: [&str; 10] = [
                    "include",
                    "style",
                    "object",
                    "camera",
                    "light",
                    "page",
                    "seed",
                    "stipples",
                    "scale_bar",
                    "pens_mm",
                ];
                return Err(source.unknown(key, at, "a scene", &KNOWN));
            }
        }
    }
    Ok(())
}

/// An object; `None` if it is hidden.
fn object(
    source: &Source,
    entries: Vec<Entry>,
    at: usize,
    style: Option<&Style>,
) -> Result<Option<SceneObject>, FileError> {
    let mut object = SceneObject {
        name: None,
        file: PathBuf::new(),
        load: LoadOptions::default(),
        iso: None,
        style: style.cloned(),
        keys: Vec::new(),
        placement: Placement::default(),
        place: (source.path.to_path_buf(), source.line(at)),
    };
    let (mut hidden, mut shaded) = (false, false);
    for (key, value, at) in entries {
        let mut set = |key: &str, value: &str| object.keys.push((key.into(), value.into()));
        match key {
            "name" => object.name = Some(source.text(key, value)?),
            "file" => {
                let name = source.text(key, value)?;
                object.file = match name.starts_with("demo:") {
                    true => name.into(),
                    false => source.beside(&name),
                };
            }
            "raw" => {
                let raw = source.parsed(key, value, |s| s.parse::<RawLayout>().map_err(|e| e.to_string()))?;
                object.load.raw = Some(raw);
            }
            "series" => object.load.series = Some(source.text(key, value)?),
            "labels" => {
                let name = source.text(key, value)?;
                object.load.labels = Some(if name == "auto" { name.into() } else { source.beside(&name) });
            }
            "label" => {
                object.load.label = Some(source.parsed(key, value, |s| {
                    s.parse().map_err(|_| format!("takes the value of a label, not '{s}'"))
                })?);
            }
            "transfer" => object.load.transfer = Some(source.beside(&source.text(key, value)?)),
            "transfer_name" => object.load.transfer_name = Some(source.text(key, value)?),
            "clip" => object.load.pose.get_or_insert_default().clip = Some(source.text(key, value)?),
            "time" => {
                let time = source.number(key, value, 0.0, 1e6)?;
                object.load.pose.get_or_insert_default().time = Some(time);
            }
            "iso" => object.iso = Some(source.number(key, value, f64::MIN, f64::MAX)?),
            "style" => object.style = Some(source.style(value)?),
            "role" => match &*source.text(key, value)? {
                "hidden" => hidden = true,
                "ghost" => set("occlusion", "0.2"),
                role => {
                    let mut style = Style::default();
                    style.set(key, role).map_err(|_| {
                        let reason =
                            format!("role takes plain, focus, context, ghost or hidden, not '{role}'");
                        source.error(value.span().start, reason)
                    })?;
                    set(key, role);
                }
            },
            "mode" => match &*source.text(key, value)? {
                "hidden" => hidden = true,
                mode => {
                    let (dots, outlines) = match mode {
                        "stippled" => ("true", "false"),
                        "both" => ("true", "true"),
                        "outline" => ("false", "true"),
                        "shaded" => {
                            shaded = true;
                            ("false", "false")
                        }
                        _ => {
                            let reason =
                                format!("mode takes shaded, stippled, both, outline or hidden, not '{mode}'");
                            return Err(source.error(value.span().start, reason));
                        }
                    };
                    set("dots", dots);
                    set("outlines", outlines);
                }
            },
            "scale" => {
                let (low, high) = Placement::SCALES;
                object.placement.scale = source.number(key, value, low, high)?;
            }
            "rotate" => object.placement.rotate = source.numbers(key, value)?,
            "translate" => object.placement.translate = source.numbers(key, value)?,
            _ => {
                find_param(key).map_err(|e| {
                    let own = "name, file, raw, series, labels, label, transfer, transfer_name, clip, time, iso, style, role, mode, scale, rotate, translate";
                    source.error(at, format!("{e} (an object also takes {own})"))
                })?;
                // Tried out, so that the error stands here and not where the object is drawn.
                let at_value = |reason| source.error(value.span().start, reason);
                let folder = source.path.parent().unwrap_or(Path::new(""));
                let text = with_palette(folder, key, source.text(key, value)?).map_err(at_value)?;
                source.parsed(key, value, |_| Style::default().set(key, &text))?;
                set(key, &text);
            }
        }
    }
    if object.file.as_os_str().is_empty() {
        return Err(source.error(at, "an object has no file"));
    }
    if shaded {
        // Below what the object says of its fill itself. A tenth of the light falls everywhere, so that form does not end
        // where the light does.
        let keys = [("fill", "own"), ("fill_shade", "0.9")].map(|(key, value)| (key.into(), value.into()));
        object.keys.splice(..0, keys);
    }
    Ok((!hidden).then_some(object))
}

fn camera(source: &Source, entries: Vec<Entry>, settings: &mut Settings) -> Result<(), FileError> {
    let mut angles = [None; 3];
    let mut first = 0;
    for (key, value, at) in entries {
        match key {
            "direction" => settings.camera = Some(source.text(key, value)?),
            "azimuth" => (angles[0], first) = (Some(source.number(key, value, -1e6, 1e6)?), at),
            "elevation" => (angles[1], first) = (Some(source.number(key, value, -90.0, 90.0)?), at),
            "distance" => (angles[2], first) = (Some(source.number(key, value, 1.0, 1e6)?), at),
            "ortho" => {
                settings.ortho = Some(source.parsed(key, value, |s| {
                    s.parse().map_err(|_| format!("takes true or false, not '{s}'"))
                })?);
            }
            "zoom" => settings.zoom = Some(source.number(key, value, 1e-3, 1e6)? as f32),
            "up" => settings.up = Some(source.parsed(key, value, str::parse::<UpAxis>)?),
            "keys" => camera_keys(source, value, settings.timeline.get_or_insert_default())?,
            _ => {
                const KNOWN: [&str; 8] =
                    ["direction", "azimuth", "elevation", "distance", "ortho", "zoom", "up", "keys"];
                return Err(source.unknown(key, at, "[camera]", &KNOWN));
            }
        }
    }
    match angles {
        [None, None, None] => {}
        [Some(azimuth), Some(elevation), distance] => {
            let distance = distance.map_or(String::new(), |d| format!(",{d}"));
            settings.camera = Some(format!("{azimuth},{elevation}{distance}"));
        }
        _ => return Err(source.error(first, "[camera] azimuth and elevation go together")),
    }
    Ok(())
}

/// The values of one key of a table of keys, by name.
type Key<const N: usize> = [(&'static str, f64, f64); N];

/// Reads keys, tables with a time and some of the numbers that `known` gives names and ranges: for each of them the
/// times and values of the keys that have it.
fn keys<const N: usize>(
    source: &Source,
    value: &Spanned<DeValue>,
    of: &str,
    known: Key<N>,
) -> Result<[Track; N], FileError> {
    let wrong = || source.error(value.span().start, format!("keys are written as [[{of}.keys]]"));
    let DeValue::Array(array) = value.get_ref() else { return Err(wrong()) };
    let mut found: [Vec<(f64, f64)>; N] = std::array::from_fn(|_| Vec::new());
    for entry in array.iter() {
        let DeValue::Table(table) = entry.get_ref() else { return Err(wrong()) };
        let entries = source.entries(table);
        let time = entries.iter().find(|(key, ..)| *key == "time");
        let Some((key, time, _)) = time else {
            return Err(source.error(entry.span().start, format!("a key of [{of}] has no time, in seconds")));
        };
        let time = source.number(key, time, 0.0, 1e6)?;
        for (key, value, at) in entries.into_iter().filter(|(key, ..)| *key != "time") {
            let Some(k) = known.iter().position(|(name, ..)| *name == key) else {
                let names: Vec<&str> = std::iter::once("time").chain(known.iter().map(|k| k.0)).collect();
                return Err(source.unknown(key, at, &format!("a key of [{of}]"), &names));
            };
            found[k].push((time, source.number(key, value, known[k].1, known[k].2)?));
        }
    }
    let mut tracks: [Track; N] = std::array::from_fn(|_| Track::default());
    for (track, keys) in tracks.iter_mut().zip(found) {
        *track = Track::new(keys).map_err(|reason| source.error(value.span().start, reason))?;
    }
    Ok(tracks)
}

fn camera_keys(source: &Source, value: &Spanned<DeValue>, timeline: &mut Timeline) -> Result<(), FileError> {
    let known = [
        ("azimuth", -1e6, 1e6),
        ("elevation", -90.0, 90.0),
        ("distance", 1.0 + 1e-6, 1e6),
        ("zoom", f64::from(ZOOM.0), f64::from(ZOOM.1)),
    ];
    let [azimuth, elevation, distance, zoom] = keys(source, value, "camera", known)?;
    let (log_distance, log_zoom) = (distance.map(f64::ln), zoom.map(f64::ln));
    *timeline = Timeline { azimuth, elevation, log_distance, log_zoom, ..std::mem::take(timeline) };
    Ok(())
}

fn light_keys(source: &Source, value: &Spanned<DeValue>, timeline: &mut Timeline) -> Result<(), FileError> {
    let known = [("azimuth", -1e6, 1e6), ("elevation", -1e6, 1e6)];
    let [light_azimuth, light_elevation] = keys(source, value, "light", known)?;
    *timeline = Timeline { light_azimuth, light_elevation, ..std::mem::take(timeline) };
    Ok(())
}

fn light(source: &Source, entries: Vec<Entry>, settings: &mut Settings) -> Result<(), FileError> {
    let [mut azimuth, mut elevation] = settings.light.unwrap_or({
        let light = dotwork_drawing::Light::default();
        [light.azimuth, light.elevation]
    });
    for (key, value, at) in entries {
        match key {
            "azimuth" => azimuth = source.number(key, value, -1e6, 1e6)? as f32,
            "elevation" => elevation = source.number(key, value, -1e6, 1e6)? as f32,
            "frame" => settings.light_frame = Some(source.parsed(key, value, str::parse::<LightFrame>)?),
            "keys" => light_keys(source, value, settings.timeline.get_or_insert_default())?,
            _ => return Err(source.unknown(key, at, "[light]", &["azimuth", "elevation", "frame", "keys"])),
        }
    }
    settings.light = Some([azimuth, elevation]);
    Ok(())
}

fn page(source: &Source, entries: Vec<Entry>, settings: &mut Settings) -> Result<(), FileError> {
    for (key, value, at) in entries {
        match key {
            "size_px" => {
                let [width, height] = source.numbers::<2>(key, value)?;
                let page = Page::pixels(width as u32, height as u32);
                page.map_err(|e| source.error(value.span().start, format!("size_px: {e}")))?;
                settings.size_px = Some([width as u32, height as u32]);
            }
            "paper" => settings.paper_mm = Some(source.parsed(key, value, parse_paper_mm)?),
            "margin" => settings.margin = Some(source.parsed(key, value, str::parse::<Length>)?),
            "dpi" => settings.dpi = Some(source.number(key, value, 1.0, 20_000.0)? as f32),
            _ => return Err(source.unknown(key, at, "[page]", &["size_px", "paper", "margin", "dpi"])),
        }
    }
    Ok(())
}
