//! `dotwork info`: what is in a file.

use std::path::Path;

use dotwork::drawing::LightFrame;
use dotwork::mesh::MeshStats;
use dotwork::{Loaded, Object, RawMesh, Scene, Style, Warnings, load};
use serde_json::{Value, json};

use crate::args::InfoArgs;
use crate::report::{self, Failure, Report};
use crate::words::{grouped, list, number};

/// Describes an input.
pub fn run(args: &InfoArgs, report: &mut Report) -> Result<(), Failure> {
    let mut warnings = Warnings::new();
    let (words, value) = match load(&args.input, &mut warnings)? {
        Loaded::Mesh(file) => {
            let format = mesh_format(&args.input);
            let found = InFile::of(&file.raw);
            let object = file.into_object(Style::default(), &mut warnings)?;
            describe_mesh(&args.input, format, &found, &object, &warnings)
        }
        Loaded::Scene(scene) => describe_dots(&args.input, &scene),
    };
    if args.json {
        return report::print(&format!("{value:#}\n"));
    }
    report::print(&words)?;
    report.warn(Some(&args.input), &warnings);
    Ok(())
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

/// The format in words. Reading succeeded: what is not PLY is OBJ.
fn mesh_format(input: &Path) -> String {
    if input.to_string_lossy().starts_with("demo:") {
        return "built-in shape".into();
    }
    let mut head = vec![0; 512];
    let read = std::fs::File::open(input).and_then(|mut f| std::io::Read::read(&mut f, &mut head));
    head.truncate(read.unwrap_or(0));
    if head.starts_with(&[0x1f, 0x8b]) {
        let inner = input.file_stem().map(Path::new).and_then(dotwork::io::mesh_format_of);
        return match inner {
            Some(dotwork::io::MeshFormat::Ply) => "PLY, gzipped".into(),
            Some(dotwork::io::MeshFormat::Obj) => "OBJ, gzipped".into(),
            None => "gzipped mesh".into(),
        };
    }
    if !head.starts_with(b"ply") {
        return "OBJ".into();
    }
    let text = String::from_utf8_lossy(&head);
    let encoding = text
        .lines()
        .find_map(|l| l.trim().strip_prefix("format ")?.split_whitespace().next().map(str::to_string));
    match encoding {
        Some(encoding) => format!("PLY, {}", encoding.replace('_', " ").replace("ascii", "text")),
        None => "PLY".into(),
    }
}

fn describe_mesh(
    input: &Path,
    format: String,
    found: &InFile,
    object: &Object,
    warnings: &Warnings,
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
    value["surface"] = surface;
    value["units"] = Value::Null;
    value["warnings"] = warnings.iter().map(|w| json!(w.to_string())).collect();
    (format!("{}\n{}", input.display(), list(&rows)), value)
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
    let rows = vec![
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
        ("units", "unknown (the file does not say)".into()),
    ];
    let value = json!({
        "vertices": vertices,
        "triangles": triangles,
        "edges": edges,
        "components": components,
        "boundary_edges": boundary_edges,
        "non_manifold_edges": non_manifold_edges,
        "closed": closed,
        "euler_characteristic": euler_characteristic,
        "area": area,
        "volume": volume,
        "bounds": { "min": min, "max": max },
        "size": size,
        "bounding_sphere": { "center": place(center.to_array()), "radius": radius },
    });
    (rows, value)
}

fn describe_dots(input: &Path, scene: &Scene) -> (String, Value) {
    let page = &scene.page;
    let mm = |px: u32| (10.0 * px as f32 * page.mm_per_px()).round() / 10.0;
    let camera = &scene.camera;
    let distance = camera.distance.map_or(String::new(), |d| format!(",{d}"));
    let projection = if camera.ortho { "parallel" } else { "perspective" };
    let frame = match scene.light.frame {
        LightFrame::Viewer => "viewer",
        LightFrame::Object => "object",
    };
    let mut words = format!("{}\n", input.display());
    words += &list(&[
        ("format", "dots: a baked scene".into()),
        (
            "page",
            format!(
                "{} x {} px at {} dpi ({} x {} mm), margin {} px",
                page.width,
                page.height,
                page.dpi,
                mm(page.width),
                mm(page.height),
                page.margin_px
            ),
        ),
        (
            "camera",
            format!(
                "{},{}{distance}, {projection}, zoom {}, up {}",
                camera.azimuth, camera.elevation, camera.zoom, camera.up
            ),
        ),
        ("light", format!("{},{} from the {frame}", scene.light.azimuth, scene.light.elevation)),
        ("bake", format!("blue-noise, stipples {}, seed {}", scene.stipples, scene.seed)),
    ]);
    let mut objects = Vec::new();
    for object in &scene.objects {
        let radii = object.stock.as_ref().map(|s| &s.baked.radius[..]).unwrap_or_default();
        let (largest, smallest) =
            (radii.first().copied().unwrap_or(0.0), radii.last().copied().unwrap_or(0.0));
        let checksum = checksum_of(object);
        let source = object.source.as_ref().map(|s| s.file.clone());
        let from = match (&source, &checksum) {
            (Some(source), Some(checksum)) => format!("{source} (checksum {checksum})"),
            (Some(source), None) => source.clone(),
            _ => "unknown".into(),
        };
        let mut rows = vec![
            ("source", from),
            ("stipples", grouped(radii.len())),
            ("radii", format!("{} down to {}", number(f64::from(largest)), number(f64::from(smallest)))),
            ("style", changes(&object.style)),
        ];
        let (more, surface) = describe_surface(object);
        rows.extend(more);
        words += &format!("\nobject {}\n{}", object.name, list(&rows));
        let style: Value =
            dotwork::ink::PARAMS.iter().map(|p| (p.name.to_string(), json!(p.get(&object.style)))).collect();
        objects.push(json!({
            "name": object.name,
            "source": source,
            "checksum": checksum,
            "stipples": radii.len(),
            "radius": { "largest": largest, "smallest": smallest },
            "style": style,
            "surface": surface,
        }));
    }
    let value = json!({
        "file": input.display().to_string(),
        "format": "dots",
        "page": { "width_px": page.width, "height_px": page.height, "dpi": page.dpi, "margin_px": page.margin_px },
        "camera": {
            "azimuth": camera.azimuth, "elevation": camera.elevation, "distance": camera.distance,
            "ortho": camera.ortho, "zoom": camera.zoom, "up": camera.up.to_string(),
        },
        "light": { "azimuth": scene.light.azimuth, "elevation": scene.light.elevation, "frame": frame },
        "bake": { "method": "blue-noise", "stipples": scene.stipples.to_string(), "seed": scene.seed },
        "objects": objects,
    });
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
