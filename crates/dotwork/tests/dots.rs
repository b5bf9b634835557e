//! `.dots` files: they come back as they were, and hostile ones are refused.
#![cfg(feature = "files")]

use std::path::Path;
use std::sync::Arc;

use dotwork::ink::Vectors;
use dotwork::ink::bake::{VoxelSettings, Voxels, voxel};
use dotwork::io::dots::{Kind, Reader, Writer};
use dotwork::volume::{IsoOptions, Space, Unit, Volume};
use dotwork::{
    Format, LightFrame, Object, Page, Scene, Source, Stipples, Style, UpAxis, Warnings, World, encode_dots,
    encode_drawing, load, mesh, open, preset, save_dots, settings_text,
};
use glam::Vec3;

/// Two baked objects and no setting at its default.
fn scene() -> Scene {
    let mut warnings = Warnings::new();
    let mut creased = preset("sepia").unwrap();
    creased.set("crease_angle", "20").unwrap();
    let mut teapot = mesh::shapes::demo("teapot").unwrap();
    teapot.colors = (0..teapot.positions.len()).map(|i| [i as u8, (i / 256) as u8, 7, 255]).collect();
    let mut object = Object::new("teapot", teapot, creased, &mut warnings).unwrap();
    object.world = World { space: Space::Patient, unit: Unit::Micrometre };
    object.source = Some(Source {
        pose: None,
        baked_at: None,
        file: "there/teapot.raw".into(),
        checksum: Some(0xfedc_ba98_7654_3210),
        raw: Some("2x2x2:u8".into()),
        iso: Some(-0.1),
        series: Some("3".into()),
        cut: Some(2),
        label: Some(-3),
        placement: "scale 0.5 rotate 0,0,90 translate 1,2,3".parse().unwrap(),
    });
    let mut scene = Scene::of(object);
    scene.scale_bar = Some("0.5um".parse().unwrap());
    scene.pens = vec![0.18, 0.25];
    scene.add(open("demo:torus", &Style::default(), &mut warnings).unwrap().objects.remove(0));
    scene.stipples = Stipples::Count(3000);
    scene.seed = 7;
    scene.page = Page { dpi: 123.4, margin_px: 3.3, ..Page::pixels(200, 150).unwrap() };
    scene.camera.set_direction("-33.3,12.1,7.7").unwrap();
    (scene.camera.ortho, scene.camera.zoom, scene.camera.up) = (true, 1.1, UpAxis::Z);
    (scene.light.azimuth, scene.light.elevation, scene.light.frame) = (0.1, -0.2, LightFrame::Object);
    scene.bake(|_| ());
    scene
}

fn drawn(scene: &mut Scene, format: Format) -> Vec<u8> {
    let drawing = scene.draw();
    let mut bytes = Vec::new();
    encode_drawing(&mut bytes, format, false, &drawing, scene, &mut Warnings::new()).unwrap();
    bytes
}

#[test]
fn a_scene_comes_back_whole() {
    let mut before = scene();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.dots");
    save_dots(&path, &before).unwrap();
    let mut after = open(&path, &Style::default(), &mut Warnings::new()).unwrap();
    assert_eq!(settings_text(&before), settings_text(&after));
    assert_eq!((before.camera, before.light, before.page), (after.camera, after.light, after.page));
    assert_eq!((before.seed, before.stipples), (after.seed, after.stipples));
    assert_eq!((before.scale_bar, &before.pens), (after.scale_bar, &after.pens));
    assert_eq!(after.objects[0].mesh.colors.len(), after.objects[0].mesh.positions.len());
    for (a, b) in before.objects.iter().zip(&after.objects) {
        assert_eq!((&a.name, &a.source, &a.style, a.world), (&b.name, &b.source, &b.style, b.world));
        assert_eq!(a.mesh, b.mesh);
        assert_eq!(a.stock, b.stock);
    }
    let formats = [Format::Png, Format::Svg, Format::Pdf, Format::TiffBilevel, Format::CsvFull, Format::Json];
    for format in formats {
        assert!(drawn(&mut before, format) == drawn(&mut after, format), "{format:?}");
    }
    assert_eq!(encode_dots(&before), encode_dots(&after), "a file of a file is the same file");
}

#[test]
fn a_new_crease_angle_gives_what_the_source_gives() {
    let style = |angle: &str| {
        let mut style = Style::default();
        style.set("crease_angle", angle).unwrap();
        style
    };
    let bake = |angle: &str| {
        let mut scene = open("demo:teapot", &style(angle), &mut Warnings::new()).unwrap();
        scene.stipples = Stipples::Count(3000);
        scene.bake(|_| ());
        scene
    };
    let (mut smooth, mut creased) = (bake("180"), bake("15"));
    assert!(drawn(&mut smooth, Format::Csv) != drawn(&mut creased, Format::Csv));
    smooth.objects[0].restyle(style("15")).unwrap();
    assert!(drawn(&mut smooth, Format::Csv) == drawn(&mut creased, Format::Csv));
}

/// A change of one section of a good file.
enum Change {
    Drop,
    Text(&'static str, &'static str),
    F32(fn(&mut Vec<f32>)),
    U32(fn(&mut Vec<u32>)),
    U64(fn(&mut Vec<u64>)),
    /// Floats become whole numbers, as many.
    Kind,
}

/// The file again with sections changed, all checksums in order.
fn forge(file: &Reader, at: &str, change: &Change) -> Vec<u8> {
    let mut writer = Writer::new();
    for name in file.names() {
        let (kind, _) = file.describe(name).unwrap();
        let hit = name == at;
        match (kind, change) {
            (_, Change::Drop) if hit => {}
            (Kind::Text, _) => {
                let mut text = file.text(name).unwrap();
                if let (true, Change::Text(from, to)) = (hit, change) {
                    assert!(text.contains(from), "{text} has no {from}");
                    text = text.replacen(from, to, 1);
                }
                writer.text(name, &text);
            }
            (Kind::F32, _) => {
                let mut v = file.f32s(name).unwrap();
                match (hit, change) {
                    (true, Change::F32(f)) => f(&mut v),
                    (true, Change::Kind) => {
                        writer.section_u32(name, &vec![0; v.len()]);
                        continue;
                    }
                    _ => {}
                }
                writer.section_f32(name, &v);
            }
            (Kind::U32, _) => {
                let mut v = file.u32s(name).unwrap();
                if let (true, Change::U32(f)) = (hit, change) {
                    f(&mut v);
                }
                writer.section_u32(name, &v);
            }
            (Kind::U64, _) => {
                let mut v = file.u64s(name).unwrap();
                if let (true, Change::U64(f)) = (hit, change) {
                    f(&mut v);
                }
                writer.section_u64(name, &v);
            }
            (Kind::Bytes, _) => panic!("{name} is made of bytes"),
        }
    }
    writer.finish()
}

#[test]
fn hostile_files_are_refused() {
    use Change::{Drop, F32, Text, U32, U64};
    let file = Reader::from_bytes(Path::new("x.dots"), encode_dots(&scene())).unwrap();
    let cases: Vec<(&str, Change, &str)> = vec![
        ("settings", Drop, "settings"),
        ("settings", Text("azimuth = ", "azimuth = = "), "not TOML"),
        ("settings", Text("elevation = 12.1", "elevation = 91.0"), "elevation"),
        ("settings", Text("elevation = 12.1", "elevation = nan"), "elevation"),
        ("settings", Text("zoom = 1.1", "zoom = 0.0"), "zoom"),
        ("settings", Text("width_px = 200", "width_px = 2000000"), "too large"),
        ("settings", Text("width_px = 200", "width_px = -1"), "width_px"),
        ("settings", Text("dpi = ", "dpi = -"), "dpi"),
        ("settings", Text("stipples = \"3000\"", "stipples = \"many\""), "neither auto"),
        ("settings", Text("seed = 7", "seed = 7000000000"), "seed"),
        ("settings", Text("gamma = \"", "gamma = \"x"), "gamma"),
        ("settings", Text("gamma = ", "gama = "), "gama"),
        ("settings", Text("[[object]]", "[[thing]]"), "not TOML"),
        ("settings", Text("gamma = ", "\"a\\nb\" = 3\ngamma = "), "a\\nb is not a text"),
        ("surfaces", Drop, "surfaces"),
        ("surfaces", Text("[[object]]", "[[thing]]"), "surfaces"),
        ("surfaces", Text("area = ", "area = -"), "area"),
        ("surfaces", Text("origin = [", "origin = [1.0, "), "origin"),
        ("surfaces", Text("closed = ", "close = "), "closed"),
        ("0/positions", Drop, "0/positions"),
        ("0/positions", F32(|v| v.truncate(4)), "triples"),
        ("0/positions", F32(|v| v.truncate(300)), "not there"),
        ("0/positions", F32(|v| v[5] = f32::NAN), "coordinate"),
        ("0/positions", F32(|v| v[5] = 1e30), "coordinate"),
        ("0/positions", F32(|v| v.fill(1.0)), "no size"),
        ("0/normals", F32(|v| v[5] = f32::INFINITY), "normal"),
        ("0/normals", F32(|v| v[5] = 3.0), "normal"),
        ("0/normals", F32(|v| v.truncate(3)), "not there"),
        ("0/triangles", U32(|v| v[100] = u32::MAX), "not there"),
        ("0/triangles", U32(Vec::clear), "triangles"),
        ("0/corner_normals", U32(|v| v[0] = u32::MAX), "not there"),
        ("0/corner_normals", U32(|v| v.truncate(30)), "differ in number"),
        ("0/colors", U32(|v| v.truncate(30)), "differ in number"),
        ("settings", Text("scale_bar = \"0.5", "scale_bar = \"x"), "not a scale bar"),
        ("settings", Text("pens_mm = [0.18", "pens_mm = [-0.18"), "pen"),
        ("settings", Text("iso = -0.1", "iso = \"x\""), "iso"),
        ("settings", Text("stipples = 3000", "stipples = 4000000000"), "stipples"),
        ("0/radius", F32(|v| v[10] = f32::NAN), "radii"),
        ("0/radius", F32(|v| v[0] = f32::INFINITY), "radii"),
        ("0/radius", F32(|v| v.reverse()), "radii"),
        ("0/radius", F32(|v| *v.last_mut().unwrap() = 0.0), "radii"),
        ("0/radius", F32(|v| v.truncate(10)), "elements"),
        ("0/id", U64(|v| v[3] = 1 << 60), "ids"),
        ("0/id", U64(|v| v[3] = v[4]), "ids"),
        ("0/id", Drop, "0/id"),
        ("0/element", U32(|v| v[3] = u32::MAX), "triangle"),
        ("0/element", U32(|v| v.truncate(10)), "elements"),
        ("0/weights", F32(|v| v[3] = -0.5), "outside"),
        ("0/weights", F32(|v| v[3] = f32::NAN), "outside"),
        ("0/weights", F32(|v| v[3] = 1.5), "outside"),
        ("1/weights", F32(|v| v.truncate(10)), "elements"),
    ];
    refuse_all(&file, cases);
}

/// What a short file may not ask for, a scene may: its file is made longer.
#[test]
fn a_file_is_as_long_as_its_scene_needs() {
    let length = |scene: &Scene| {
        let bytes = encode_dots(scene);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.dots");
        std::fs::write(&path, &bytes).unwrap();
        let after = open(&path, &Style::default(), &mut Warnings::new()).unwrap();
        assert_eq!(settings_text(scene), settings_text(&after));
        assert!(scene.objects[0].stock == after.objects[0].stock);
        assert!(encode_dots(&after) == bytes);
        bytes.len()
    };
    let mut warnings = Warnings::new();
    let mut scene = open("demo:plate", &Style::default(), &mut warnings).unwrap();
    scene.stipples = Stipples::Count(10);
    scene.bake(|_| ());
    assert!(length(&scene) < 10_000);

    let mut named = scene.clone();
    named.objects[0].name = "x".repeat(600 << 10);
    // Stored as it is: packed it would be too short to be believed.
    assert!((600 << 10..2 << 20).contains(&length(&named)));

    let count = 360_000;
    let up = || Vectors { x: vec![0.0; count], y: vec![0.0; count], z: vec![1.0; count] };
    let voxels = Voxels {
        position: up(),
        normal: up(),
        magnitude: vec![1.0; count],
        value: vec![1.0; count],
        edges: [Vec3::X, Vec3::Y, Vec3::Z],
    };
    for (n_max, expected) in [(2.0, 0..100_000), (3.0, 32 * count..37 * count)] {
        let stock = voxel(&voxels, &VoxelSettings { n_max, ..VoxelSettings::default() }, &mut warnings);
        scene.objects[0].stock = Some(Arc::new(stock));
        assert!(expected.contains(&length(&scene)), "{n_max}");
    }
}

/// A ball of 16 voxels a side, baked by voxels.
fn ball(curves: bool) -> Scene {
    let value = |i: usize| {
        let [x, y, z] = [i % 16, i / 16 % 16, i / 256].map(|k| k as f32 - 7.5);
        (7.0 - (x * x + y * y + z * z).sqrt()).clamp(0.0, 3.0)
    };
    let values: Vec<f32> = (0..16 * 16 * 16).map(value).collect();
    let volume = Volume::from_slice([16; 3], [1.0; 3], &values).unwrap();
    let mut style = preset("papers").unwrap();
    style.k_max = 0.01;
    style.curves = curves;
    let mut warnings = Warnings::new();
    let raw = volume.isosurface(1.5, &IsoOptions::default(), &mut warnings).unwrap();
    let mut object = Object::new("ball", raw, style, &mut warnings).unwrap();
    object.volume = Some(Arc::new(volume));
    let mut scene = Scene::of(object);
    scene.bake(|_| ());
    scene
}

#[test]
fn hostile_faces_are_refused() {
    use Change::{Drop, F32, Kind, Text};
    let (areas, numbers) = ("0/faces/areas", "0/faces/numbers");
    let style = Style { k_max: 0.01, ..preset("papers-surface").unwrap() };
    let mut scene = open("demo:plate", &style, &mut Warnings::new()).unwrap();
    scene.bake(|_| ());
    let file = Reader::from_bytes(Path::new("x.dots"), encode_dots(&scene)).unwrap();
    let mut cases: Vec<(&str, Change, &str)> = vec![
        (areas, F32(|v| v[5] = f32::NAN), "area"),
        (areas, F32(|v| v[5] = -1.0), "area"),
        (areas, F32(|v| v[5] = f32::INFINITY), "area"),
        (numbers, F32(|v| v[5] = f32::NAN), "number"),
        (numbers, F32(|v| v[5] = -0.1), "number"),
        (numbers, F32(|v| v[5] = 1.0), "number"),
        ("surfaces", Text("n_max = ", "n_max = -"), "n_max"),
        ("surfaces", Text("n_max = ", "n_min = "), "n_max"),
        ("surfaces", Text("wanted = ", "wanted = nan # "), "wanted"),
        ("surfaces", Text("seed = ", "seed = -1 # "), "seed"),
        ("surfaces", Text("reference = ", "reference = 0.0 # "), "reference"),
        ("0/radius", F32(|v| v.reverse()), "radii"),
        ("0/element", Drop, "0/element"),
    ];
    for section in [areas, numbers] {
        cases.push((section, Drop, section));
        cases.push((section, Kind, "holds u32, not f32"));
        cases.push((section, F32(|v| v.truncate(10)), "elements"));
        cases.push((section, F32(Vec::clear), "elements"));
    }
    refuse_all(&file, cases);
}

#[test]
fn hostile_voxels_are_refused() {
    use Change::{Drop, F32, Kind, Text};
    let (positions, normals) = ("0/voxels/positions", "0/voxels/normals");
    let (magnitudes, values) = ("0/voxels/magnitudes", "0/voxels/values");
    let file = Reader::from_bytes(Path::new("x.dots"), encode_dots(&ball(false))).unwrap();
    let mut cases: Vec<(&str, Change, &str)> = vec![
        (positions, F32(|v| v[5] = f32::NAN), "place"),
        (positions, F32(|v| v[5] = 1e30), "place"),
        (normals, F32(|v| v[5] = f32::NAN), "normal"),
        (normals, F32(|v| v[5] = 3.0), "normal"),
        (normals, F32(|v| v.fill(0.0)), "no stipples"),
        (magnitudes, F32(|v| v[5] = f32::NAN), "share"),
        (magnitudes, F32(|v| v[5] = 1.5), "share"),
        (values, F32(|v| v[5] = f32::NAN), "share"),
        (values, F32(|v| v[5] = -0.5), "share"),
        ("surfaces", Text("n_max = ", "n_max = -"), "n_max"),
        ("surfaces", Text("n_max = ", "n_max = nan # "), "n_max"),
        ("surfaces", Text("n_max = ", "n_max = 1e13 # "), "n_max"),
        ("surfaces", Text("n_max = ", "n_min = "), "n_max"),
        ("surfaces", Text("slab = ", "slab = -1.0 # "), "slab"),
        ("surfaces", Text("slab = ", "slab = nan # "), "slab"),
        ("surfaces", Text("slab = ", "slab = 65.0 # "), "slab"),
        ("surfaces", Text("seed = ", "seed = -1 # "), "seed"),
        ("surfaces", Text("seed = ", "seed = 4294967296 # "), "seed"),
        ("surfaces", Text("reference = ", "reference = 0.0 # "), "reference"),
        ("surfaces", Text("reference = ", "reference = inf # "), "reference"),
        ("surfaces", Text("edges = [", "edges = [1.0, "), "edges"),
        ("surfaces", Text("edges = [1.0", "edges = [nan"), "edges"),
        ("surfaces", Text("edges = [1.0", "edges = [1e30"), "edges"),
        // Each is of reasonable size, and their product is none.
        (
            "surfaces",
            Text("edges = [", "edges = [9e14, 0.0, 0.0, 0.0, 9e14, 0.0, 0.0, 0.0, 9e14] # "),
            "edges",
        ),
        (
            "surfaces",
            Text("edges = [", "edges = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] # "),
            "stipples",
        ),
        ("surfaces", Text("[object.voxels]", "[object.voxel]"), "0/radius"),
    ];
    for section in [positions, normals, magnitudes, values] {
        cases.push((section, Drop, section));
        cases.push((section, Kind, "holds u32, not f32"));
        cases.push((section, F32(|v| v.truncate(10)), "elements"));
        cases.push((section, F32(|v| v.extend([0.5; 7])), "elements"));
        cases.push((section, F32(Vec::clear), "elements"));
    }
    refuse_all(&file, cases);
}

#[test]
fn hostile_curves_are_refused() {
    use Change::{Drop, F32, Kind, Text, U32};
    let (voxels, normals) = ("0/curves/voxels", "0/curves/normals");
    let (magnitudes, laplacians) = ("0/curves/magnitudes", "0/curves/laplacians");
    let file = Reader::from_bytes(Path::new("x.dots"), encode_dots(&ball(true))).unwrap();
    let mut cases: Vec<(&str, Change, &str)> = vec![
        (voxels, Drop, voxels),
        (voxels, U32(|v| v.truncate(10)), "elements"),
        (voxels, U32(|v| v.push(u32::MAX)), "elements"),
        (voxels, U32(|v| v.reverse()), "order"),
        (voxels, U32(|v| v[5] = v[4]), "order"),
        (voxels, U32(|v| *v.last_mut().unwrap() = 4096), "grid"),
        (voxels, U32(|v| *v = (0..262_145).collect()), "file of this size"),
        (voxels, U32(|v| *v = (0..4_194_305).collect()), "too many"),
        (normals, F32(|v| v[5] = f32::NAN), "normal"),
        (normals, F32(|v| v[5] = 3.0), "normal"),
        (magnitudes, F32(|v| v[5] = f32::NAN), "share"),
        (magnitudes, F32(|v| v[5] = 1.5), "share"),
        (laplacians, F32(|v| v[5] = f32::INFINITY), "share"),
        (laplacians, F32(|v| v[5] = -0.5), "share"),
        ("surfaces", Text("dims = [16", "dims = [16, 16"), "dims"),
        ("surfaces", Text("dims = [16", "dims = [-16"), "dims"),
        ("surfaces", Text("dims = [16", "dims = [16.0"), "dims"),
        ("surfaces", Text("dims = [16", "dims = [0"), "grid"),
        ("surfaces", Text("dims = [16", "dims = [4294967295"), "too many voxels"),
        ("surfaces", Text("edges = [1.0", "edges = [nan"), "edges"),
        ("surfaces", Text("edges = [1.0", "edges = [1e30"), "edges"),
        ("surfaces", Text("edges = [1.0", "edges = [9e14"), "too large"),
        ("surfaces", Text("edges = [1.0", "edges = [1.0, 1.0"), "edges"),
        ("surfaces", Text("t_log = ", "t_log = -1.0 # "), "t_log"),
        ("surfaces", Text("t_grad = ", "t_grad = nan # "), "t_grad"),
        ("surfaces", Text("least = ", "least = 1.5 # "), "least"),
        ("surfaces", Text("least = ", "last = "), "least"),
    ];
    for section in [normals, magnitudes, laplacians] {
        cases.push((section, Drop, section));
        cases.push((section, Kind, "holds u32, not f32"));
        cases.push((section, F32(|v| v.truncate(10)), "elements"));
        cases.push((section, F32(|v| v.extend([0.5; 7])), "elements"));
    }
    refuse_all(&file, cases);
}

/// Loads the file with each change, which must be refused for its reason.
fn refuse_all(file: &Reader, cases: Vec<(&str, Change, &str)>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("forged.dots");
    for (at, change, reason) in cases {
        std::fs::write(&path, forge(file, at, &change)).unwrap();
        let Err(error) = load(&path, &mut Warnings::new()) else { panic!("{at}: {reason}: was let pass") };
        let text = error.to_string();
        assert!(text.contains("forged.dots: ") && text.contains(reason), "{at}: {text}");
        assert!(!text.contains('\n'), "{text}");
    }
}
