//! Every key of the parameter table changes a drawing, at every word it takes and at both ends of its range.
#![cfg(feature = "files")]

use dotwork::ink::{Kind, PARAMS, Param};
use dotwork::{
    Artist, Format, Object, Page, Raster, Rasterizer, RawMesh, Scene, Source, Stipples, Style, Volume,
    VolumeInput, Warnings, encode_drawing,
};

/// A place to look for the effect of a key: a shape, and settings that bring the effect out.
struct Setting {
    shape: fn(&Style) -> RawMesh,
    camera: &'static str,
    keys: &'static [(&'static str, &'static str)],
}

const SETTINGS: &[Setting] = &[
    Setting { shape: torus, camera: "20,35", keys: &[] },
    // Tones up to black.
    Setting { shape: torus, camera: "20,35", keys: &[("base", "1"), ("dot_size", "3px")] },
    // Back faces: what an open surface shows from within, and what a closed one hides.
    Setting { shape: tube, camera: "0,60", keys: &[] },
    Setting { shape: torus, camera: "20,35", keys: &[("visibility", "facing")] },
    // Near and far, under a uniform tone.
    Setting { shape: torus, camera: "0,10,1.5", keys: &[("base", "0.3"), ("light", "0")] },
    Setting { shape: cube, camera: "30,30", keys: &[] },
    Setting { shape: volume, camera: "30,30", keys: &[] },
];

/// The surface of a volume with a dense core, a speck, noise, and a block that the box cuts off.
fn volume(style: &Style) -> RawMesh {
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
    let input = VolumeInput {
        name: "v".into(),
        input: "v".into(),
        format: String::new(),
        facts: Vec::new(),
        source: Source::default(),
        volume,
    };
    input.surface(style, None, &mut Warnings::new()).unwrap().raw
}

fn torus(_: &Style) -> RawMesh {
    dotwork::mesh::shapes::torus(1.0, 0.4, 48, 24)
}

fn tube(style: &Style) -> RawMesh {
    let mut raw = torus(style);
    // Half of a torus is a tube that is open at both ends.
    let positions = raw.positions.clone();
    raw.triangles.retain(|t| t.iter().all(|&v| positions[v as usize][0] >= -1e-3));
    raw
}

fn cube(_: &Style) -> RawMesh {
    let positions = (0..8u8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f32::from)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    RawMesh { positions, triangles, polygons: 6, ..RawMesh::default() }
}

/// The drawing table and the pixels (the bytes of a PNG would differ by the settings it carries).
fn draw(setting: &Setting, change: Option<(&str, &str)>) -> (Vec<u8>, Vec<u8>) {
    let mut style = Style::default();
    for &(key, value) in setting.keys.iter().chain(change.as_ref()) {
        style.set(key, value).unwrap_or_else(|e| panic!("{e}"));
    }
    let raw = (setting.shape)(&style);
    let object = Object::new("o", raw, style, &mut Warnings::new()).unwrap();
    let mut scene = Scene {
        page: Page::pixels(160, 160).unwrap(),
        stipples: Stipples::Count(12_000),
        ..Scene::of(object)
    };
    scene.camera.set_direction(setting.camera).unwrap();
    scene.bake(|_| ());
    let drawing = Artist::new().draw(&scene);
    let (mut table, mut raster) = (Vec::new(), Raster::default());
    encode_drawing(&mut table, Format::Csv, &drawing, &scene, &mut Warnings::new()).unwrap();
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
        Kind::Length => vec!["2.5px".into(), "60px".into()],
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
            if !SETTINGS.iter().zip(&before).any(|(s, before)| draw(s, change) != *before) {
                idle.push(format!("{}={value}", param.name));
            }
        }
    }
    assert!(idle.is_empty(), "these change nothing: {}", idle.join(", "));
}
