//! `dotwork info`: what is in a file.

mod volume;

use std::path::Path;

use dotwork::drawing::{Drawing, LightFrame};
use dotwork::export::{Pixels, RasterView, write_png};
use dotwork::mesh::MeshStats;
use dotwork::volume::Unit;
use dotwork::{
    LoadOptions, Loaded, Object, Plate, Raster, Rasterizer, RawMesh, Scene, SceneFile, Source, Style,
    Warnings, load_with, preset,
};
use serde_json::{Value, json};

use crate::args::InfoArgs;
use crate::options::chosen_style_over;
use crate::output;
use crate::report::{self, Failure, Report};
use crate::words::{grouped, list, number};

/// Describes an input.
pub fn run(args: &InfoArgs, report: &mut Report) -> Result<(), Failure> {
    if let Some(sheet) = &args.sheet {
        if !sheet.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            let sheet = sheet.display();
            return Err(Failure::Usage(format!(
                "{sheet}: a contact sheet is written to a file that ends in .png"
            )));
        }
        output::check(sheet, std::slice::from_ref(&args.input))?;
    }
    let mut warnings = Warnings::new();
    let options = LoadOptions {
        raw: args.raw.clone(),
        series: args.series.clone(),
        watch: report.watch(),
        ..LoadOptions::default()
    };
    let (words, mut value) = match load_with(&args.input, &options, &mut warnings)? {
        Loaded::Mesh(_) | Loaded::Scene { .. } | Loaded::Plate(_) | Loaded::SceneFile(_)
            if args.sheet.is_some() =>
        {
            let input = args.input.display();
            return Err(Failure::Usage(format!("{input}: only volumes have features for a contact sheet")));
        }
        Loaded::Mesh(file) => {
            let (format, facts) = (file.format.clone(), file.facts.clone());
            let found = InFile::of(&file.raw);
            let object = file.into_object(Style::default(), &mut warnings)?;
            describe_mesh(&args.input, format, &facts, &found, &object)
        }
        Loaded::Volume(mut input) => {
            // Each tile of the sheet is a surface of the same prepared volume.
            input.keep_prepared(args.sheet.is_some());
            let features = input.features(&Style::default(), &mut warnings);
            if let Some(path) = &args.sheet {
                let features = match &features {
                    Ok(features) => features,
                    Err(error) => return Err(Failure::Run(error.to_string())),
                };
                let drawing = volume::sheet(&input, features, &mut warnings)?;
                write_sheet(path, &drawing)?;
            }
            let (words, mut value) = volume::describe(&input, &features);
            if args.json && features.is_ok() {
                let style = match args.style.style {
                    None => preset("papers").unwrap_or_default(),
                    Some(_) => Style::default(),
                };
                value["factors"] =
                    volume::factors(*input, chosen_style_over(&args.style, style)?, &mut Warnings::new())?;
            }
            (words, value)
        }
        Loaded::Scene { scene, .. } => describe_dots(&args.input, &scene),
        Loaded::Plate(plate) => describe_plate(&args.input, &plate),
        Loaded::SceneFile(file) => describe_scene_file(&args.input, &file)?,
    };
    report.rest();
    value["warnings"] = warnings.iter().map(|w| json!(w.to_string())).collect();
    if args.json {
        return report::print(&format!("{value:#}\n"));
    }
    report::print(&words)?;
    report.warn(Some(&args.input), &warnings);
    Ok(())
}

/// Writes a contact sheet: a picture without settings, since none draw it again.
fn write_sheet(path: &Path, sheet: &Drawing) -> Result<(), Failure> {
    let mut raster = Raster::default();
    Rasterizer::new().draw(sheet, &mut raster);
    let (width, height) = (raster.width, raster.height);
    let pixels = match raster.channels {
        1 => Pixels::Grey(&raster.samples),
        _ => Pixels::Rgb(&raster.samples),
    };
    output::write(path, |w| write_png(w, &RasterView { width, height, pixels }, 0, &[]))
}

/// What the file itself says, before cleaning.
struct InFile {
    vertices: usize,
    polygons: usize,
    triangles: usize,
}

impl InFile {
    fn of(raw: &RawMesh) -> InFile {
        InFile { vertices: raw.positions.len(), polygons: raw.polygons, triangles: raw.triangles.len() }
    }
}

fn describe_mesh(
    input: &Path,
    format: String,
    facts: &[(String, String)],
    found: &InFile,
    object: &Object,
) -> (String, Value) {
    let checksum = checksum_of(object);
    let mut rows = vec![("format", format.clone())];
    let mut value = json!({ "file": input.display().to_string(), "format": format });
    if let Some(checksum) = &checksum {
        rows.push(("checksum", checksum.clone()));
        value["checksum"] = json!(checksum);
    }
    rows.push((
        "in the file",
        format!("{} vertices, {} polygons", grouped(found.vertices), grouped(found.polygons)),
    ));
    value["in_file"] =
        json!({ "vertices": found.vertices, "polygons": found.polygons, "triangles": found.triangles });
    let (more, surface) = describe_surface(object);
    rows.extend(more);
    value["facts"] = facts.iter().map(|(k, v)| json!([k, v])).collect();
    value["surface"] = surface;
    value["units"] = match object.world.unit {
        Unit::Unknown => Value::Null,
        unit => json!(unit.symbol()),
    };
    let mut words = format!("{}\n{}", input.display(), list(&rows));
    if !facts.is_empty() {
        let facts: Vec<(&str, String)> = facts.iter().map(|(k, v)| (k.as_str(), v.clone())).collect();
        words += &format!("\nin the file\n{}", list(&facts));
    }
    (words, value)
}

fn describe_surface(object: &Object) -> (Vec<(&'static str, String)>, Value) {
    let stats = object.mesh.stats();
    let MeshStats { vertices, triangles, components, edges, .. } = stats;
    let MeshStats {
        boundary_edges,
        non_manifold_edges,
        closed,
        euler_characteristic,
        area,
        volume,
        bounds,
        ..
    } = stats;
    let (center, radius) = object.mesh.bounding_sphere();
    let origin = object.mesh.origin;
    let place = |v: [f32; 3]| -> [f64; 3] { [0, 1, 2].map(|k| f64::from(v[k]) + origin[k]) };
    let (min, max) = (place(bounds.min.to_array()), place(bounds.max.to_array()));
    let size = bounds.size().to_array().map(f64::from);
    let triple = |v: [f64; 3]| v.map(number).join(", ");
    let units = match object.world.unit {
        Unit::Unknown => "unknown (the file does not say)".into(),
        unit => unit.to_string(),
    };
    let mut rows = vec![
        (
            "surface",
            format!(
                "{} vertices, {} triangles, {} edges",
                grouped(vertices),
                grouped(triangles),
                grouped(edges)
            ),
        ),
        ("components", grouped(components)),
        (
            if closed { "closed" } else { "open" },
            format!(
                "{} boundary edges, {} non-manifold edges",
                grouped(boundary_edges),
                grouped(non_manifold_edges)
            ),
        ),
        ("Euler characteristic", euler_characteristic.to_string()),
        ("area", number(area)),
        ("volume", if closed { number(volume) } else { format!("{} (the surface is open)", number(volume)) }),
        ("bounds", format!("{} to {}", triple(min), triple(max))),
        ("size", triple(size)),
        (
            "bounding radius",
            format!("{} about {}", number(f64::from(radius)), triple(place(center.to_array()))),
        ),
        ("units", units),
    ];
    if !object.mesh.colors.is_empty() {
        rows.push(("colours", "one for each vertex".into()));
    }
    let value = json!({
        "vertices": vertices,
        "triangles": triangles,
        "edges": edges,
        "components": components,
        "boundary_edges": boundary_edges,
        "non_manifold_edges": non_manifold_edges,
        "closed": closed,
        "colors": !object.mesh.colors.is_empty(),
        "euler_characteristic": euler_characteristic,
        "area": area,
        "volume": volume,
        "bounds": { "min": min, "max": max },
        "size": size,
        "bounding_sphere": { "center": place(center.to_array()), "radius": radius },
    });
    (rows, value)
}

/// The page, camera, light and bake of a scene, as rows.
fn settings_rows(scene: &Scene) -> Vec<(&'static str, String)> {
    let page = &scene.page;
    let mm = |px: u32| (10.0 * px as f32 * page.mm_per_px()).round() / 10.0;
    let camera = &scene.camera;
    let distance = camera.distance.map_or(String::new(), |d| format!(",{d}"));
    let projection = if camera.ortho { "parallel" } else { "perspective" };
    let mut rows = vec![
        (
            "page",
            format!(
                "{} x {} px at {} dpi ({} x {} mm), margin {} mm",
                page.width,
                page.height,
                page.dpi,
                mm(page.width),
                mm(page.height),
                (100.0 * page.margin_px * page.mm_per_px()).round() / 100.0
            ),
        ),
        (
            "camera",
            format!(
                "{},{}{distance}, {projection}, zoom {}, up {}",
                camera.azimuth, camera.elevation, camera.zoom, camera.up
            ),
        ),
        (
            "light",
            format!("{},{} from the {}", scene.light.azimuth, scene.light.elevation, light_frame(scene)),
        ),
        ("bake", format!("{}, stipples {}, seed {}", methods(scene), scene.stipples, scene.seed)),
    ];
    if let Some(bar) = &scene.scale_bar {
        rows.push(("scale bar", bar.to_string()));
    }
    if !scene.pens.is_empty() {
        let pens: Vec<String> = scene.pens.iter().map(ToString::to_string).collect();
        rows.push(("pens", format!("{} mm", pens.join(", "))));
    }
    rows
}

/// Who made the stipples of the objects, each maker once; of objects that are not baked, who will by default.
fn methods(scene: &Scene) -> String {
    let mut methods: Vec<&str> = Vec::new();
    for object in &scene.objects {
        let elements = object.stock.as_ref().and_then(|stock| stock.elements.as_ref());
        let method = match elements.map(|elements| elements.are_faces()) {
            None => "blue-noise",
            Some(true) => "face",
            Some(false) => "voxel",
        };
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    methods.join(", ")
}

fn light_frame(scene: &Scene) -> &'static str {
    match scene.light.frame {
        LightFrame::Viewer => "viewer",
        LightFrame::Object => "object",
    }
}

/// The same as JSON.
fn settings_json(value: &mut Value, scene: &Scene) {
    let (page, camera) = (&scene.page, &scene.camera);
    value["page"] = json!({
        "width_px": page.width, "height_px": page.height, "dpi": page.dpi, "margin_px": page.margin_px,
    });
    value["camera"] = json!({
        "azimuth": camera.azimuth, "elevation": camera.elevation, "distance": camera.distance,
        "ortho": camera.ortho, "zoom": camera.zoom, "up": camera.up.to_string(),
    });
    value["light"] = json!({
        "azimuth": scene.light.azimuth, "elevation": scene.light.elevation, "frame": light_frame(scene),
    });
    value["bake"] =
        json!({ "method": methods(scene), "stipples": scene.stipples.to_string(), "seed": scene.seed });
    value["scale_bar"] = json!(scene.scale_bar.as_ref().map(ToString::to_string));
    value["pens_mm"] = json!(scene.pens);
}

/// Where an object came from, in words.
fn origin(source: Option<&Source>) -> String {
    let Some(source) = source else { return "unknown".into() };
    let mut words = source.file.clone();
    if let Some(raw) = &source.raw {
        words += &format!(" as {raw}");
    }
    if let Some(iso) = source.iso {
        words += &format!(" at {iso}");
    }
    if let Some(checksum) = source.checksum {
        words += &format!(" (checksum {checksum:016x})");
    }
    words
}

/// A picture that dotwork drew: what it says about itself.
fn describe_plate(input: &Path, plate: &Plate) -> (String, Value) {
    let mut rows = vec![("format", "a plate: a picture that carries its settings".to_string())];
    rows.push(("drawn by", format!("dotwork {}", plate.version())));
    rows.extend(settings_rows(plate.settings()));
    let mut words = format!("{}\n{}", input.display(), list(&rows));
    let mut objects = Vec::new();
    for object in plate.objects() {
        let rows = [
            ("source", origin(object.source.as_ref())),
            ("stipples", grouped(object.stipples)),
            ("style", changes(&object.style)),
        ];
        words += &format!("\nobject {}\n{}", object.name, list(&rows));
        objects.push(json!({
            "name": object.name,
            "source": object.source.as_ref().map(|s| s.file.clone()),
            "checksum": object.source.as_ref().and_then(|s| s.checksum).map(|c| format!("{c:016x}")),
            "iso": object.source.as_ref().and_then(|s| s.iso),
            "stipples": object.stipples,
            "style": style_json(&object.style),
        }));
    }
    let mut value = json!({
        "file": input.display().to_string(), "format": "plate", "version": plate.version(), "objects": objects,
    });
    settings_json(&mut value, plate.settings());
    (words, value)
}

/// What a scene file puts together; the files of its objects are not opened.
fn describe_scene_file(input: &Path, file: &SceneFile) -> Result<(String, Value), Failure> {
    let mut settings = Scene::default();
    file.settings.apply(&mut settings).map_err(|e| Failure::Run(format!("{}: {e}", input.display())))?;
    let mut rows = vec![("format", "a scene file".to_string())];
    rows.extend(settings_rows(&settings));
    let mut words = format!("{}\n{}", input.display(), list(&rows));
    let mut objects = Vec::new();
    for object in &file.objects {
        let style = object.own_style();
        let source = object.file.display().to_string();
        let name = object.name.clone().unwrap_or_else(|| source.clone());
        words +=
            &format!("\nobject {name}\n{}", list(&[("source", source.clone()), ("style", changes(&style))]));
        objects
            .push(json!({ "name": name, "source": source, "iso": object.iso, "style": style_json(&style) }));
    }
    let mut value = json!({ "file": input.display().to_string(), "format": "scene", "objects": objects });
    settings_json(&mut value, &settings);
    Ok((words, value))
}

fn style_json(style: &Style) -> Value {
    dotwork::ink::PARAMS.iter().map(|p| (p.name.to_string(), json!(p.get(style)))).collect()
}

fn describe_dots(input: &Path, scene: &Scene) -> (String, Value) {
    let mut rows = vec![("format", "dots: a baked scene".to_string())];
    rows.extend(settings_rows(scene));
    let mut words = format!("{}\n{}", input.display(), list(&rows));
    let mut objects = Vec::new();
    for object in &scene.objects {
        let radii = object.stock.as_ref().map(|s| &s.baked.radius[..]).unwrap_or_default();
        let (largest, smallest) =
            (radii.first().copied().unwrap_or(0.0), radii.last().copied().unwrap_or(0.0));
        let checksum = checksum_of(object);
        let source = object.source.as_ref().map(|s| s.file.clone());
        let mut rows = vec![
            ("source", origin(object.source.as_ref())),
            ("stipples", grouped(radii.len())),
            ("radii", format!("{} down to {}", number(f64::from(largest)), number(f64::from(smallest)))),
            ("style", changes(&object.style)),
        ];
        let (more, surface) = describe_surface(object);
        rows.extend(more);
        words += &format!("\nobject {}\n{}", object.name, list(&rows));
        objects.push(json!({
            "name": object.name,
            "source": source,
            "checksum": checksum,
            "stipples": radii.len(),
            "radius": { "largest": largest, "smallest": smallest },
            "style": style_json(&object.style),
            "surface": surface,
        }));
    }
    let mut value = json!({ "file": input.display().to_string(), "format": "dots", "objects": objects });
    settings_json(&mut value, scene);
    (words, value)
}

/// What a style changes of the default one.
fn changes(style: &Style) -> String {
    let changed = dotwork::ink::PARAMS.iter().filter(|p| p.get(style) != p.default());
    let text = changed.map(|p| format!("{}={}", p.name, p.get(style))).collect::<Vec<_>>().join(" ");
    if text.is_empty() { "soft, the default".into() } else { text }
}

fn checksum_of(object: &Object) -> Option<String> {
    object.source.as_ref()?.checksum.map(|c| format!("{c:016x}"))
}
