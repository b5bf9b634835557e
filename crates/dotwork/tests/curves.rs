//! Silhouette curves from voxels: where they lie beside curves that are known, and that files keep them.
#![cfg(feature = "files")]

use std::collections::HashSet;
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use dotwork::drawing::{Projection, StrokeKind, Strokes, View};
use dotwork::ink::CurvesMethod;
use dotwork::volume::{Volume, phantom};
use dotwork::{
    Artist, Drawing, Format, Loaded, Object, Page, Scene, Stipples, Style, VolumeInput, Warnings,
    encode_dots, encode_drawing, open, preset, save_dots,
};
use glam::Vec3;

const SIDE: u32 = 600;

fn curved() -> Style {
    Style { curves: true, t_eye: 0.15, k_max: 0.01, ..preset("papers").unwrap() }
}

fn scene_of(volume: Volume, style: &Style) -> Scene {
    let input = VolumeInput::new("v", "v", volume);
    let mut warnings = Warnings::new();
    let mut scene = Scene { page: Page::pixels(SIDE, SIDE).unwrap(), ..Scene::default() };
    scene.stipples = Stipples::Count(1000);
    scene.camera.set_direction("25,35").unwrap();
    let meshes = Loaded::Volume(Box::new(input)).into_meshes(style, None, &mut warnings).unwrap();
    for mesh in meshes {
        scene.add(mesh.into_object(style.clone(), &mut warnings).unwrap());
    }
    scene
}

/// Four spheres about the origin.
fn shells(style: &Style) -> Scene {
    let mut scene = scene_of(phantom::phantom("shells").unwrap(), style);
    scene.bake(|_| ());
    scene
}

fn draw(scene: &Scene) -> Drawing {
    Artist::new().draw(scene)
}

fn strokes(scene: &Scene) -> Strokes {
    draw(scene).layers.remove(0).strokes
}

fn ids(scene: &Scene) -> HashSet<u64> {
    strokes(scene).id.iter().copied().collect()
}

fn bytes(scene: &Scene, format: Format) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode_drawing(&mut bytes, format, false, &draw(scene), scene, &mut Warnings::new()).unwrap();
    bytes
}

/// Where the outline of a sphere about the centre of the view is on the page: its radius, pixels.
fn outline(view: &View, radius: f32) -> f32 {
    match view.projection {
        Projection::Parallel { px_per_unit } => radius * px_per_unit,
        // Along the tangents from the eye.
        Projection::Perspective { focal_px } => {
            focal_px * radius / (view.distance * view.distance - radius * radius).sqrt()
        }
    }
}

/// How far strokes lie from the nearest of these circles about the page's centre, voxels; how much they are turned from
/// it, degrees; and the largest arc of each circle without a stroke, degrees.
fn compare(view: &View, strokes: &Strokes, circles: &[f32]) -> (f32, Vec<f32>, Vec<f32>) {
    let voxel = view.px_per_unit(view.distance);
    let (mut farthest, mut turns) = (0.0f32, Vec::new());
    let mut arcs: Vec<Vec<f32>> = vec![Vec::new(); circles.len()];
    for k in 0..strokes.len() {
        let points: Vec<[f32; 2]> =
            strokes.points(k).map(|i| [strokes.x[i] - view.cx, strokes.y[i] - view.cy]).collect();
        let [[ax, ay], [bx, by]] = points[..] else { panic!("a curve's stroke has two ends") };
        let [x, y] = [0.5 * (ax + bx), 0.5 * (ay + by)];
        let off = |c: &f32| (x.hypot(y) - c).abs();
        let nearest =
            (0..circles.len()).min_by(|&a, &b| off(&circles[a]).total_cmp(&off(&circles[b]))).unwrap();
        farthest = farthest.max(off(&circles[nearest]) / voxel);
        let along = ((bx - ax) * -y + (by - ay) * x) / ((bx - ax).hypot(by - ay) * x.hypot(y));
        turns.push(along.abs().min(1.0).acos().to_degrees());
        arcs[nearest].push(y.atan2(x));
    }
    turns.sort_by(f32::total_cmp);
    let gaps = arcs.into_iter().map(|mut arc| {
        arc.sort_by(f32::total_cmp);
        let around = arc.first().map_or(PI, |first| first + TAU);
        let next = arc.iter().skip(1).chain(std::iter::once(&around));
        arc.iter()
            .zip(next)
            .map(|(a, b)| b - a)
            .fold(if arc.is_empty() { TAU } else { 0.0 }, f32::max)
            .to_degrees()
    });
    let gaps = gaps.collect();
    (farthest, turns, gaps)
}

#[test]
fn curves_of_spheres_are_their_outlines() {
    for method in [CurvesMethod::Segment, CurvesMethod::Search] {
        for ortho in [true, false] {
            let mut scene = shells(&Style { curves_method: method, ..curved() });
            scene.camera.ortho = ortho;
            let view = scene.view();
            assert!(view.center.length() < 0.1, "the spheres lie about the centre");
            let circles = phantom::SHELLS.map(|(radius, _)| outline(&view, radius));
            let strokes = strokes(&scene);
            assert!(strokes.len() > 3000, "{}", strokes.len());
            assert!(strokes.kind.iter().all(|&kind| kind == StrokeKind::Silhouette));
            assert!(strokes.darkness.iter().all(|&d| d == 1.0));
            let unique: HashSet<u64> = strokes.id.iter().copied().collect();
            assert_eq!(unique.len(), strokes.len());
            let (farthest, turns, gaps) = compare(&view, &strokes, &circles);
            // Lines from centre to centre have the grid's directions: they are right on the average alone.
            let most = if method == CurvesMethod::Segment { 2.0 } else { 15.0 };
            let middle = turns[turns.len() / 2];
            assert!(farthest < 1.5, "{method:?}: {farthest} voxels");
            assert!(middle < most, "{method:?}: {middle} degrees");
            assert!(gaps.iter().all(|&gap| gap < 5.0), "{method:?}: {gaps:?}");
        }
    }
}

#[test]
fn what_is_solid_hides_the_curves_within() {
    for method in [CurvesMethod::Segment, CurvesMethod::Search] {
        let style = Style { curves_method: method, ..curved() };
        let scene = shells(&Style { visibility: dotwork::ink::Visibility::Solid, ..style.clone() });
        let (view, all) = (scene.view(), ids(&shells(&style)));
        let outer = outline(&view, phantom::SHELLS[0].0);
        let (farthest, _, gaps) = compare(&view, &strokes(&scene), &[outer]);
        assert!(farthest < 1.5 && gaps[0] < 5.0, "{method:?}: {farthest} voxels, {gaps:?}");
        let seen = ids(&scene);
        assert!(seen.is_subset(&all) && seen.len() < all.len());
    }
}

#[test]
fn criteria_are_monotone_and_strict_ones_need_no_bake() {
    let keys: [(&str, [&str; 4]); 3] = [
        ("t_eye", ["0.02", "0.1", "0.3", "0.7"]),
        ("t_log", ["0", "0.5", "0.7", "1"]),
        ("t_grad", ["0.95", "0.9", "0.85", "0.8"]),
    ];
    for method in [CurvesMethod::Segment, CurvesMethod::Search] {
        for (key, values) in keys {
            let style = |value: &str| {
                let mut style = Style { curves_method: method, ..curved() };
                style.set(key, value).unwrap();
                style
            };
            let mut scene = shells(&style(values[0]));
            let mut before: HashSet<u64> = HashSet::new();
            for value in values {
                // A looser criterion is another bake, but for the eye's.
                let curves = scene.objects[0].curves.clone().unwrap();
                scene.objects[0].restyle(style(value)).unwrap();
                assert_eq!(scene.objects[0].curves.is_some(), key == "t_eye" || value == values[0]);
                scene.bake(|_| ());
                let now = ids(&scene);
                assert!(now.is_superset(&before), "{key}={value}");
                assert!(value == values[0] || now.len() > before.len(), "{key}={value}: {}", now.len());
                let kept = Arc::ptr_eq(&curves, scene.objects[0].curves.as_ref().unwrap());
                assert_eq!(kept, key == "t_eye" || value == values[0]);
                before = now;
            }
            // Back to the strictest: the voxels are there, and the drawing is that of a bake of its own.
            let curves = scene.objects[0].curves.clone().unwrap();
            scene.objects[0].restyle(style(values[0])).unwrap();
            scene.bake(|_| ());
            assert!(Arc::ptr_eq(&curves, scene.objects[0].curves.as_ref().unwrap()));
            assert_eq!(strokes(&scene), strokes(&shells(&style(values[0]))));
        }
    }
}

#[test]
fn curves_take_the_place_of_outlines_and_only_where_they_are_asked_for() {
    let style = |curves: bool, outlines: bool| Style { curves, outlines, ..curved() };
    let both = shells(&style(true, true));
    assert_eq!(strokes(&both), strokes(&shells(&style(true, false))));
    let outlined = shells(&style(false, true));
    assert!(outlined.objects[0].curves.is_none() && !strokes(&outlined).is_empty());
    assert!(strokes(&shells(&style(false, false))).is_empty());
    // The sum of ink has none, and a mesh has no voxels.
    let mut soft = style(true, true);
    soft.factors = dotwork::ink::Factors::Sum;
    assert_eq!(strokes(&shells(&soft)).len(), strokes(&outlined).len());
    let mut torus = open("demo:torus", &style(true, true), &mut Warnings::new()).unwrap();
    torus.stipples = Stipples::Count(1000);
    torus.bake(|_| ());
    assert!(!strokes(&torus).is_empty());
    assert!(torus.bake_warnings().iter().any(|w| w.to_string().contains("no voxels for curves")));
    assert!(!both.bake_warnings().iter().any(|w| w.to_string().contains("curves")));
}

#[test]
fn the_same_curves_on_any_number_of_threads() {
    let make = || {
        [CurvesMethod::Segment, CurvesMethod::Search].map(|curves_method| {
            let style = Style { curves_method, visibility: dotwork::ink::Visibility::Solid, ..curved() };
            strokes(&shells(&style))
        })
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(make), make());
}

#[test]
fn a_file_without_the_volume_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("curves.dots");
    for curves_method in [CurvesMethod::Segment, CurvesMethod::Search] {
        let before = shells(&Style { curves_method, ..curved() });
        save_dots(&path, &before).unwrap();
        let mut after = open(&path, &Style::default(), &mut Warnings::new()).unwrap();
        assert!(after.objects[0].volume.is_none());
        assert_eq!(before.objects[0].curves, after.objects[0].curves);
        for format in [Format::Png, Format::Svg, Format::Csv, Format::Json] {
            assert!(bytes(&before, format) == bytes(&after, format), "{format:?}");
        }
        assert!(encode_dots(&before) == encode_dots(&after));
        assert!(after.bake_warnings().is_empty());
        // What the file does not have it cannot show, and says so.
        let looser = Style { t_log: 0.5, curves_method, ..curved() };
        after.objects[0].restyle(looser).unwrap();
        after.bake(|_| ());
        assert_eq!(ids(&after), ids(&before));
        assert!(after.bake_warnings().iter().any(|w| w.to_string().contains("t_log")));
    }
}

#[test]
fn curves_move_with_their_object() {
    let samples = |i: usize| {
        let p = Vec3::new((i % 32) as f32, (i / 32 % 32) as f32, (i / 1024) as f32);
        (12.0 - p.distance(Vec3::splat(15.5))).clamp(0.0, 1.5)
    };
    let volume =
        || Volume::from_vec([32; 3], [1.0; 3], (0..32768).map(samples).collect::<Vec<f32>>()).unwrap();
    let alone = {
        let mut scene = scene_of(volume(), &curved());
        scene.bake(|_| ());
        scene
    };
    let mut raw = dotwork::mesh::shapes::torus(20.0, 5.0, 24, 12);
    raw.origin = [7.0, -3.0, 2.5];
    let torus = Object::new("torus", raw, Style::default(), &mut Warnings::new()).unwrap();
    let mut scene = Scene { stipples: Stipples::Count(1000), ..Scene::of(torus) };
    let first = scene.objects[0].mesh.origin;
    assert_ne!(first, alone.objects[0].mesh.origin);
    assert!(scene.add(alone.objects[0].clone()));
    scene.bake(|_| ());
    let curves = scene.objects[1].curves.as_ref().unwrap();
    let center = Vec3::from_array(first.map(|c| (15.5 - c) as f32));
    assert!(curves.len() > 500);
    for i in 0..curves.len() {
        assert!((curves.position.at(i).distance(center) - 11.25).abs() < 1.5);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.dots");
    save_dots(&path, &scene).unwrap();
    let after = open(&path, &Style::default(), &mut Warnings::new()).unwrap();
    assert!(bytes(&scene, Format::Csv) == bytes(&after, Format::Csv));
}

#[test]
fn curves_end_where_the_volume_is_clipped() {
    let clip = |text: &str| Style { clip: dotwork::ink::Clip::Planes(text.into()), ..curved() };
    let scene_of = |style: &Style| {
        let mut scene = scene_of(phantom::phantom("shells").unwrap(), style);
        scene.camera.set_direction("front").unwrap();
        scene.camera.ortho = true;
        scene.bake(|_| ());
        scene
    };
    let (whole, cut) = (scene_of(&clip("")), scene_of(&clip("x>0.5")));
    assert!(cut.bake_warnings().is_empty(), "{:?}", cut.bake_warnings());
    // Ends of strokes right and left of the plane in the middle, farther than a voxel and a piece.
    let sides = |scene: &Scene| {
        let object = &scene.objects[0];
        let [low, high] = object.whole.unwrap();
        let middle =
            Vec3::from_array([0, 1, 2].map(|k| (0.5 * (low[k] + high[k]) - object.mesh.origin[k]) as f32));
        let view = scene.view();
        let (x, ..) = view.project(middle);
        let voxel = view.px_per_unit(view.distance) * object.curves.as_ref().unwrap().lattice.edge();
        let strokes = strokes(scene);
        let count = |side: f32| strokes.x.iter().filter(|&&at| (at - x) * side > 1.5 * voxel).count();
        [count(-1.0), count(1.0)]
    };
    let (before, after) = (sides(&whole), sides(&cut));
    assert!(before.iter().all(|&n| n > 200) && after[0] > 200, "{before:?} {after:?}");
    assert_eq!(after[1], 0);
    let mut again = cut.clone();
    again.objects[0].restyle(clip("x<0.5")).unwrap();
    again.bake(|_| ());
    let again = sides(&again);
    assert!(again[0] == 0 && again[1] > 200, "{again:?}");
}
