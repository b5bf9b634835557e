//! Every key of the parameter table changes a drawing, at every word it takes and at both ends of its range.
#![cfg(feature = "files")]

use dotwork::ink::{Kind, PARAMS, Param, Role};
use dotwork::{
    Artist, Format, Loaded, Object, Page, Raster, Rasterizer, RawMesh, Scene, Stipples, Style, Volume,
    VolumeInput, Warnings, encode_drawing,
};

/// A place to look for the effect of a key: a shape, and settings that bring the effect out.
struct Setting {
    shape: fn(&Style) -> Scene,
    camera: &'static str,
    zoom: f32,
    keys: &'static [(&'static str, &'static str)],
}

/// The papers' bake and all factors but the one that empties the rest.
const PAPERS: &[(&str, &str)] = &[
    ("factors", "papers"),
    ("bake", "voxel"),
    ("distance", "1"),
    ("size_max", "1%"),
    ("visibility", "through"),
    ("fade", "off"),
];

/// As [`PAPERS`], with the factors that are off there.
const INTERIOR: &[(&str, &str)] = &[
    ("factors", "papers"),
    ("bake", "voxel"),
    ("interior", "true"),
    ("lighting", "false"),
    ("visibility", "through"),
];

/// The curves of voxels.
const CURVES: &[(&str, &str)] = &[
    ("factors", "papers"),
    ("bake", "voxel"),
    ("k_max", "0.01"),
    ("curves", "true"),
    ("visibility", "through"),
];

const SETTINGS: &[Setting] = &[
    Setting { shape: torus, camera: "20,35", zoom: 1.0, keys: &[] },
    // Tones up to black.
    Setting { shape: torus, camera: "20,35", zoom: 1.0, keys: &[("base", "1"), ("dot_size", "3px")] },
    // Back faces: what an open surface shows from within, and what a closed one hides.
    Setting { shape: tube, camera: "0,60", zoom: 1.0, keys: &[] },
    Setting { shape: torus, camera: "20,35", zoom: 1.0, keys: &[("visibility", "facing")] },
    // Among others: a context before it, a focus behind it.
    Setting { shape: between, camera: "0,0", zoom: 1.0, keys: &[] },
    Setting { shape: between, camera: "0,0", zoom: 1.0, keys: &[("role", "context"), ("dot_size", "3px")] },
    // Near and far, under a uniform tone.
    Setting { shape: torus, camera: "0,10,1.5", zoom: 1.0, keys: &[("base", "0.3"), ("light", "0")] },
    Setting { shape: cube, camera: "30,30", zoom: 1.0, keys: &[] },
    Setting { shape: coloured, camera: "20,35", zoom: 1.0, keys: &[] },
    Setting { shape: torus, camera: "20,35", zoom: 1.0, keys: &[("coloring", "both")] },
    Setting { shape: coloured, camera: "20,35", zoom: 1.0, keys: &[("fill", "own")] },
    Setting { shape: volume, camera: "30,30", zoom: 1.0, keys: &[] },
    // Short outlines.
    Setting { shape: torus, camera: "20,35", zoom: 0.1, keys: &[] },
    // Small, so that voxels hold few stipples.
    Setting { shape: volume, camera: "30,30", zoom: 0.2, keys: CURVES },
    Setting { shape: volume, camera: "30,30", zoom: 0.2, keys: PAPERS },
    Setting { shape: volume, camera: "30,30", zoom: 0.2, keys: INTERIOR },
    // The papers' bakes of surfaces.
    Setting { shape: torus, camera: "20,35", zoom: 1.0, keys: &[("factors", "papers"), ("bake", "face")] },
    Setting { shape: torus, camera: "20,35", zoom: 1.0, keys: &[("bake", "hierarchy")] },
];

/// A volume with a dense core, a speck, noise, and a block that the box cuts off.
fn volume(style: &Style) -> Scene {
    let at = |x: usize, y: usize, z: usize| {
        let from = |c: [usize; 3]| {
            [x, y, z].iter().zip(c).map(|(a, b)| a.abs_diff(b).pow(2) as f32).sum::<f32>().sqrt()
        };
        let ball = from([12, 12, 12]);
        let speck = from([3, 20, 20]) < 1.5;
        let block = y < 4 && x.abs_diff(12) < 6 && z.abs_diff(12) < 6;
        let noise = (dotwork::drawing::hash::hash2((x + 24 * y) as u32, z as u32) >> 24) as f32 / 255.0;
        let value = match ball {
            ..4.0 => 200.0,
            ..8.0 => 100.0,
            _ if speck || block => 100.0,
            _ => 0.0,
        };
        value + 12.0 * noise
    };
    let samples: Vec<f32> = (0..24 * 24 * 24).map(|i| at(i % 24, i / 24 % 24, i / 576)).collect();
    let volume = Volume::from_vec([24; 3], [1.0; 3], samples).unwrap();
    let input = VolumeInput::new("v", "v", volume);
    let mut scene = Scene::default();
    let mut warnings = Warnings::new();
    for mesh in Loaded::Volume(Box::new(input)).into_meshes(style, None, &mut warnings).unwrap() {
        let style = mesh.style(style.clone());
        scene.add(mesh.into_object(style, &mut warnings).unwrap());
    }
    scene
}

fn of(raw: RawMesh, style: &Style) -> Scene {
    Scene::of(Object::new("o", raw, style.clone(), &mut Warnings::new()).unwrap())
}

fn ring() -> RawMesh {
    dotwork::mesh::shapes::torus(1.0, 0.4, 48, 24)
}

fn torus(style: &Style) -> Scene {
    of(ring(), style)
}

fn coloured(style: &Style) -> Scene {
    let mut raw = ring();
    raw.colors = (0..raw.positions.len()).map(|i| [(i % 256) as u8, 90, 7, 255]).collect();
    of(raw, style)
}

fn tube(style: &Style) -> Scene {
    let mut raw = ring();
    // Half of a torus is a tube that is open at both ends.
    let positions = raw.positions.clone();
    raw.triangles.retain(|t| t.iter().all(|&v| positions[v as usize][0] >= -1e-3));
    of(raw, style)
}

/// A ball in the style, a larger one before it that is a context, a smaller one behind it that is a focus.
fn between(style: &Style) -> Scene {
    let ball = |radius: f32, [x, z]: [f32; 2], style: &Style| {
        let mut raw = dotwork::mesh::shapes::sphere(4);
        raw.positions.iter_mut().for_each(|p| *p = [radius * p[0] + x, radius * p[1], radius * p[2] + z]);
        Object::new("o", raw, style.clone(), &mut Warnings::new()).unwrap()
    };
    let mut scene = Scene::of(ball(1.0, [0.0; 2], style));
    // Side by side, so that the former does not hide what lies before the latter.
    for (radius, place, role) in [(1.5, [1.8, 4.0], Role::Context), (0.5, [-0.4, -4.0], Role::Focus)] {
        scene.add(ball(radius, place, &Style { role, ..Style::default() }));
    }
    scene
}

fn cube(style: &Style) -> Scene {
    let positions = (0..8u8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f32::from)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    of(RawMesh { positions, triangles, polygons: 6, ..RawMesh::default() }, style)
}

/// The drawing table and the pixels (the bytes of a PNG would differ by the settings it carries).
fn draw(setting: &Setting, change: Option<(&str, &str)>) -> (Vec<u8>, Vec<u8>) {
    let mut style = Style::default();
    for &(key, value) in setting.keys.iter().chain(change.as_ref()) {
        style.set(key, value).unwrap_or_else(|e| panic!("{e}"));
    }
    let mut scene = (setting.shape)(&style);
    scene.page = Page::pixels(160, 160).unwrap();
    scene.stipples = Stipples::Count(12_000);
    scene.camera.set_direction(setting.camera).unwrap();
    scene.camera.zoom = setting.zoom;
    scene.bake(|_| ());
    let drawing = Artist::new().draw(&scene);
    let (mut table, mut raster) = (Vec::new(), Raster::default());
    encode_drawing(&mut table, Format::Csv, false, &drawing, &scene, &mut Warnings::new()).unwrap();
    Rasterizer::new().draw(&drawing, &mut raster);
    (table, raster.samples)
}

/// Values to try: both ends of a range, every word, and for colours and lengths something else than the default.
fn values(param: &Param) -> Vec<String> {
    let all = match param.kind {
        Kind::Number { min, max } => vec![min.to_string(), max.to_string()],
        Kind::Switch => vec!["true".into(), "false".into()],
        Kind::Choice(words) => words.iter().map(|w| w.to_string()).collect(),
        Kind::Color => vec!["#804020".into()],
        Kind::Length => vec!["30px".into(), "60px".into()],
        Kind::Text(_) => texts(param.name).iter().map(|w| w.to_string()).collect(),
    };
    all.into_iter().filter(|v| *v != param.default()).collect()
}

/// Values of the keys that take texts.
fn texts(name: &str) -> &'static [&'static str] {
    match name {
        "feature" => &["dense", "2", "60,300"],
        "window" => &["20,90"],
        "keep" => &["all", "1"],
        "crop" => &["0,0.5,0,1,0,1"],
        "clip" => &["x>0.5", "x>0.5;z>0.6"],
        "outline_color" => &["#804020"],
        "fill" => &["own", "#804020"],
        "palette" => {
            &["blue-orange", "aerial", "sunset", "ocean", "earth", "viridis", "#102030,#a0b0c0,#ff8000"]
        }
        "size_max" => &["2%", "0.3mm"],
        "gradient_min" => &["0.1", "0.6"],
        _ => panic!("{name} needs values to try"),
    }
}

#[test]
fn every_key_changes_a_drawing() {
    let before: Vec<_> = SETTINGS.iter().map(|s| draw(s, None)).collect();
    // A comparison that finds a difference everywhere would prove nothing.
    for (setting, before) in SETTINGS.iter().zip(&before) {
        assert!(draw(setting, None) == *before);
    }
    let mut idle = Vec::new();
    for param in PARAMS {
        let values = values(param);
        assert!(!values.is_empty(), "{}", param.name);
        for value in values {
            let change = Some((param.name, value.as_str()));
            let mut places: Vec<_> = SETTINGS.iter().zip(&before).collect();
            if param.group == "Papers" {
                // Theirs come last.
                places.reverse();
            }
            if !places.into_iter().any(|(s, before)| draw(s, change) != *before) {
                idle.push(format!("{}={value}", param.name));
            }
        }
    }
    assert!(idle.is_empty(), "these change nothing: {}", idle.join(", "));
}
