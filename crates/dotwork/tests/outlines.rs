//! Outlines of shapes whose outlines are known: how far strokes lie from the exact curves, and what of those is missing.
//!
//! The exact curve of a parametric surface is the zero set of n · (eye − p), found by bisection in double precision along
//! dense lines of one parameter; what hides it is found by marching from it to the eye through the surface's distance.

#![allow(clippy::print_stdout, reason = "the figures are for reading: run with --nocapture")]

use std::collections::BTreeMap;

use dotwork::drawing::{Drawing, Projection, StrokeKind, View};
use dotwork::{Artist, Object, Page, RawMesh, Scene, Stipples, Style, Warnings};
use glam::{DVec3, Vec3};

const SIZE: u32 = 800;

/// A surface: places and normals by two parameters 0…1, and its distance (of the right sign, never too long).
struct Shape {
    at: Box<dyn Fn(f64, f64) -> DVec3>,
    normal: Box<dyn Fn(f64, f64) -> DVec3>,
    distance: Box<dyn Fn(DVec3) -> f64>,
    mesh: RawMesh,
}

/// A grid over both parameters; the second one is closed if `closed`, otherwise its ends are points.
fn mesh(at: &dyn Fn(f64, f64) -> DVec3, [nu, nv]: [usize; 2], closed: bool) -> RawMesh {
    let rows = if closed { nv } else { nv + 1 };
    let place = |i: usize| at((i % nu) as f64 / nu as f64, (i / nu) as f64 / nv as f64).as_vec3().to_array();
    let index = |u: usize, v: usize| match (u % nu, if closed { v % nv } else { v }) {
        (_, 0) if !closed => 0,
        (_, v) if !closed && v == nv => (nv * nu) as u32,
        (u, v) => (v * nu + u) as u32,
    };
    let mut triangles = Vec::new();
    for v in 0..nv {
        for u in 0..nu {
            let [a, b, c, d] = [index(u, v), index(u + 1, v), index(u + 1, v + 1), index(u, v + 1)];
            triangles.extend(
                [[a, b, c], [a, c, d]].into_iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2]),
            );
        }
    }
    RawMesh { positions: (0..rows * nu).map(place).collect(), triangles, ..RawMesh::default() }
}

/// A circle of angle `u` about the y axis.
fn around(u: f64) -> DVec3 {
    let (s, c) = (std::f64::consts::TAU * u).sin_cos();
    DVec3::new(c, 0.0, s)
}

/// A half circle from −y to +y.
fn up(v: f64) -> (f64, f64) {
    let (s, c) = (std::f64::consts::PI * (v - 0.5)).sin_cos();
    (c, s)
}

fn ellipsoid(axes: DVec3, cells: [usize; 2]) -> Shape {
    let unit = |u: f64, v: f64| around(u) * up(v).0 + DVec3::Y * up(v).1;
    let at = move |u: f64, v: f64| unit(u, v) * axes;
    Shape {
        mesh: mesh(&at, cells, false),
        at: Box::new(at),
        normal: Box::new(move |u, v| (unit(u, v) / axes).normalize()),
        distance: Box::new(move |p| ((p / axes).length() - 1.0) * axes.min_element()),
    }
}

/// Two half spheres and a cylinder between them.
fn capsule(cells: [usize; 2]) -> Shape {
    const HALF: f64 = 0.6;
    let split = |v: f64| match v {
        v if v < 0.4 => (0.5 * v / 0.4, -HALF),
        v if v > 0.6 => (0.5 + 0.5 * (v - 0.6) / 0.4, HALF),
        v => (0.5, (v - 0.5) * 10.0 * HALF),
    };
    let unit = |u: f64, v: f64| around(u) * up(v).0 + DVec3::Y * up(v).1;
    let at = move |u: f64, v: f64| unit(u, split(v).0) * 0.5 + DVec3::Y * split(v).1;
    Shape {
        mesh: mesh(&at, cells, false),
        at: Box::new(at),
        normal: Box::new(move |u, v| unit(u, split(v).0)),
        distance: Box::new(|p| (p - DVec3::Y * p.y.clamp(-HALF, HALF)).length() - 0.5),
    }
}

fn torus(cells: [usize; 2]) -> Shape {
    let normal = |u: f64, v: f64| {
        let (s, c) = (std::f64::consts::TAU * v).sin_cos();
        around(u) * c + DVec3::Y * s
    };
    let at = move |u: f64, v: f64| around(u) + normal(u, v) * 0.4;
    Shape {
        mesh: mesh(&at, cells, true),
        at: Box::new(at),
        normal: Box::new(normal),
        distance: Box::new(|p| (DVec3::new(p.x, 0.0, p.z).length() - 1.0).hypot(p.y) - 0.4),
    }
}

fn scene(raw: RawMesh, ortho: bool) -> Scene {
    let style = dotwork::ink::preset("outline").unwrap();
    let mut scene = Scene::of(Object::new("o", raw, style, &mut Warnings::new()).unwrap());
    scene.page = Page::pixels(SIZE, SIZE).unwrap();
    scene.stipples = Stipples::Count(100);
    scene.camera.set_direction("20,35").unwrap();
    scene.camera.ortho = ortho;
    scene
}

fn draw(scene: &mut Scene) -> Drawing {
    scene.bake(|_| ());
    let drawing = Artist::new().draw(scene);
    assert!(drawing.layers[0].dots.is_empty());
    drawing
}

/// Points along the strokes of one of these kinds, at most half a pixel apart.
fn drawn(drawing: &Drawing, kinds: &[StrokeKind]) -> Vec<[f64; 2]> {
    let strokes = &drawing.layers[0].strokes;
    let mut points = Vec::new();
    for k in (0..strokes.len()).filter(|&k| kinds.contains(&strokes.kind[k])) {
        let range = strokes.points(k);
        let at = |i: usize| [f64::from(strokes.x[i]), f64::from(strokes.y[i])];
        for i in range.start..range.end - 1 {
            points.extend(between(at(i), at(i + 1)));
        }
    }
    points
}

/// Points from one to another, at most half a pixel apart.
fn between(a: [f64; 2], b: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let steps = ((b[0] - a[0]).hypot(b[1] - a[1]) / 0.5).ceil().max(1.0) as usize;
    (0..=steps).map(move |s| [0, 1].map(|k| a[k] + (b[k] - a[k]) * s as f64 / steps as f64))
}

/// The distance from each of some points to the nearest of others, sorted.
fn distances(from: &[[f64; 2]], to: &[[f64; 2]]) -> Vec<f64> {
    let mut sorted: Vec<[f64; 2]> = to.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let nearest = |p: &[f64; 2]| {
        let start = sorted.partition_point(|q| q[0] < p[0]);
        let mut best = f64::INFINITY;
        for q in &sorted[start..] {
            if q[0] - p[0] >= best {
                break;
            }
            best = best.min((q[0] - p[0]).hypot(q[1] - p[1]));
        }
        for q in sorted[..start].iter().rev() {
            if p[0] - q[0] >= best {
                break;
            }
            best = best.min((q[0] - p[0]).hypot(q[1] - p[1]));
        }
        best
    };
    let mut all: Vec<f64> = from.iter().map(nearest).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// The visible points of the exact outline, on the page.
fn exact(shape: &Shape, view: &View, origin: DVec3) -> Vec<[f64; 2]> {
    let to_eye = |p: DVec3| match view.projection {
        Projection::Perspective { .. } => view.eye.as_dvec3() + origin - p,
        Projection::Parallel { .. } => view.back.as_dvec3() * 10.0,
    };
    let g = |u: f64, v: f64| (shape.normal)(u, v).dot(to_eye((shape.at)(u, v)));
    let mut points = Vec::new();
    let mut root = |at: &dyn Fn(f64) -> (f64, f64), mut from: f64, mut to: f64| {
        let value = |t: f64| g(at(t).0, at(t).1);
        if (value(from) >= 0.0) == (value(to) >= 0.0) {
            return;
        }
        for _ in 0..40 {
            let middle = 0.5 * (from + to);
            match (value(middle) >= 0.0) == (value(from) >= 0.0) {
                true => from = middle,
                false => to = middle,
            }
        }
        let p = (shape.at)(at(from).0, at(from).1);
        let sight = to_eye(p);
        let length = sight.length();
        // From a little way off, since the line of sight touches the surface.
        let mut walked = 1e-3;
        while walked < length {
            let d = (shape.distance)(p + sight * (walked / length));
            if d < -1e-6 {
                return;
            }
            walked += d.max(2e-3);
        }
        let (x, y, _) = view.project((p - origin).as_vec3());
        points.push([f64::from(x), f64::from(y)]);
    };
    let (fine, coarse) = (3000, 400);
    for i in 0..fine {
        let fixed = (f64::from(i) + 0.5) / f64::from(fine);
        for k in 0..coarse {
            let (from, to) = (f64::from(k) / f64::from(coarse), f64::from(k + 1) / f64::from(coarse));
            root(&|t| (fixed, t), from, to);
            root(&|t| (t, fixed), from, to);
        }
    }
    points
}

#[test]
fn outlines_of_smooth_shapes_are_the_exact_curves() {
    type Make = fn() -> Shape;
    let shapes: [(&str, Make); 6] = [
        ("sphere", || ellipsoid(DVec3::ONE, [96, 48])),
        ("coarse sphere", || ellipsoid(DVec3::ONE, [24, 12])),
        ("torus", || torus([128, 64])),
        ("coarse torus", || torus([40, 20])),
        ("capsule", || capsule([96, 60])),
        ("ellipsoid", || ellipsoid(DVec3::new(1.0, 0.7, 0.45), [96, 48])),
    ];
    let mut failed = Vec::new();
    for (name, make) in shapes {
        for ortho in [false, true] {
            let shape = make();
            let mut scene = scene(shape.mesh.clone(), ortho);
            let view = scene.view();
            let exact = exact(&shape, &view, DVec3::from_array(scene.objects[0].mesh.origin));
            let drawing = draw(&mut scene);
            let drawn = drawn(&drawing, &[StrokeKind::Silhouette]);
            let off = distances(&drawn, &exact);
            let missing = distances(&exact, &drawn).into_iter().filter(|&d| d > 1.0).count();
            let (median, most) = (off[off.len() / 2], off[off.len() - 1]);
            let strokes = drawing.layers[0].strokes.len();
            println!(
                "{name}, ortho {ortho}: median {median:.3} px, most {most:.3} px, {missing} of {} missing, {strokes} strokes",
                exact.len()
            );
            // A line that goes behind another at a small angle is seen until it is a pixel behind.
            let most_max = if name == "torus" { 1.1 } else { 1.0 };
            if median > 0.25 || most > most_max || missing > 0 {
                failed.push(format!("{name}, ortho {ortho}"));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

fn cube() -> RawMesh {
    let positions = (0..8u8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f32::from)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    RawMesh { positions, triangles, polygons: 6, ..RawMesh::default() }
}

#[test]
fn a_cube_is_drawn_by_its_edges() {
    for ortho in [false, true] {
        let mut scene = scene(cube(), ortho);
        let view = scene.view();
        let origin = DVec3::from_array(scene.objects[0].mesh.origin).as_vec3();
        // Each edge has two faces; how many of them face the eye says what it is.
        let (mut rim, mut inner) = (Vec::new(), Vec::new());
        for axis in 0..3 {
            for corner in 0..4 {
                let mut p = Vec3::ZERO;
                let others = [(axis + 1) % 3, (axis + 2) % 3];
                p[others[0]] = (corner & 1) as f32;
                p[others[1]] = (corner >> 1) as f32;
                let facing = others
                    .iter()
                    .filter(|&&k| {
                        let mut normal = Vec3::ZERO;
                        normal[k] = 2.0 * p[k] - 1.0;
                        normal.dot(view.to_eye(p - origin)) > 0.0
                    })
                    .count();
                let mut q = p;
                q[axis] = 1.0;
                let ends = [p, q].map(|p| {
                    let (x, y, _) = view.project(p - origin);
                    [f64::from(x), f64::from(y)]
                });
                match facing {
                    2 => inner.extend(between(ends[0], ends[1])),
                    1 => rim.extend(between(ends[0], ends[1])),
                    _ => (),
                }
            }
        }
        let drawing = draw(&mut scene);
        let strokes = &drawing.layers[0].strokes;
        for (kind, exact, count) in [(StrokeKind::Silhouette, &rim, 1), (StrokeKind::Crease, &inner, 3)] {
            let drawn = drawn(&drawing, &[kind]);
            let off = distances(&drawn, exact);
            let missing = distances(exact, &drawn);
            let (median, most) = (off[off.len() / 2], off[off.len() - 1]);
            println!(
                "cube, {}, ortho {ortho}: median {median:.3} px, most {most:.3} px, farthest missing {:.3} px",
                kind.name(),
                missing[missing.len() - 1]
            );
            assert!(median <= 0.25 && most <= 1.0, "{median} {most}");
            assert!(missing[missing.len() - 1] <= 1.0, "{}", missing[missing.len() - 1]);
            assert_eq!(strokes.kind.iter().filter(|&&k| k == kind).count(), count, "{}", kind.name());
        }
    }
}

#[test]
fn creases_and_dots_can_be_left_out() {
    let of = |keys: &[(&str, &str)]| {
        let mut scene = scene(cube(), true);
        let mut style: Style = scene.objects[0].style.clone();
        keys.iter().for_each(|(key, value)| style.set(key, value).unwrap());
        scene.objects[0].restyle(style).unwrap();
        scene.bake(|_| ());
        let drawing = Artist::new().draw(&scene);
        let count = |kind| drawing.layers[0].strokes.kind.iter().filter(|&&k| k == kind).count();
        (count(StrokeKind::Silhouette), count(StrokeKind::Crease), drawing.layers[0].dots.len())
    };
    assert_eq!(of(&[]), (1, 3, 0));
    assert_eq!(of(&[("creases", "false")]), (1, 0, 0));
    assert_eq!(of(&[("crease_min", "120"), ("creases", "true")]).1, 0, "an angle of 90 degrees is no crease");
    assert!(of(&[("dots", "true")]).2 > 0);
}

/// The length of each stroke, by its id.
fn lengths(drawing: &Drawing) -> BTreeMap<u64, f64> {
    let strokes = &drawing.layers[0].strokes;
    let mut lengths = BTreeMap::new();
    for k in 0..strokes.len() {
        let length: f32 = strokes
            .points(k)
            .skip(1)
            .map(|i| (strokes.x[i] - strokes.x[i - 1]).hypot(strokes.y[i] - strokes.y[i - 1]))
            .sum();
        *lengths.entry(strokes.id[k]).or_default() += f64::from(length);
    }
    lengths
}

#[test]
fn strokes_stay_over_a_turntable_and_are_few_and_long() {
    // Shares of the length of all strokes, and the least mean length in pixels.
    for (name, most_gone, least_mean) in [("teapot", 0.01, 150.0), ("torus", 0.01, 500.0)] {
        let mut scene = scene(dotwork::mesh::shapes::demo(name).unwrap(), false);
        scene.bake(|_| ());
        let mut artist = Artist::new();
        let (mut gone, mut all, mut strokes) = (0.0, 0.0, 0);
        let mut last: Option<BTreeMap<u64, f64>> = None;
        for frame in 0..48 {
            scene.camera.azimuth = 20.0 + 0.5 * frame as f32;
            let drawing = artist.draw(&scene);
            let here = lengths(&drawing);
            strokes += drawing.layers[0].strokes.len();
            all += here.values().sum::<f64>();
            if let Some(last) = last.replace(here.clone()) {
                gone += last
                    .iter()
                    .filter(|(id, _)| !here.contains_key(id))
                    .map(|(_, length)| length)
                    .sum::<f64>();
            }
        }
        let mean = all / strokes as f64;
        println!(
            "{name}: {:.1} strokes a frame of {mean:.0} px; {:.2} % of their length gone in the next frame",
            strokes as f64 / 48.0,
            100.0 * gone / all
        );
        assert!(gone < most_gone * all, "{name}: {gone} of {all}");
        assert!(mean > least_mean, "{name}: {mean}");
    }
}

#[test]
fn silhouettes_in_image_space_are_a_picture_of_one_width() {
    let mut scene = scene(ellipsoid(DVec3::ONE, [96, 48]).mesh, true);
    let set = |scene: &mut Scene, keys: &[(&str, &str)]| {
        let mut style = scene.objects[0].style.clone();
        keys.iter().for_each(|(key, value)| style.set(key, value).unwrap());
        scene.objects[0].restyle(style).unwrap();
        draw(scene)
    };
    let drawing = set(&mut scene, &[("lines", "image"), ("outline", "4px")]);
    let layer = &drawing.layers[0];
    assert!(layer.strokes.is_empty());
    let image = layer.image.as_ref().unwrap();
    assert!(image.is_drawable());
    // A circle, whose area is its length times its width, but for what facets near the rim add.
    let ink = |image: &dotwork::drawing::Image| image.samples.iter().map(|s| f64::from(s[3])).sum::<f64>();
    let radius = 0.45 * f64::from(SIZE);
    let thickness = ink(image) / (std::f64::consts::TAU * radius);
    println!("a line of 4 px is {thickness:.2} px wide");
    assert!((3.7..5.5).contains(&thickness), "{thickness}");
    // Half as large, thinned to half the width.
    scene.camera.zoom = 0.5;
    let drawing = set(&mut scene, &[("outline_thin", "1")]);
    let half = ink(drawing.layers[0].image.as_ref().unwrap()) / (0.5 * std::f64::consts::TAU * radius);
    assert!((half / thickness - 0.5).abs() < 0.1, "{half}");
    // And as strokes too.
    let drawing = set(&mut scene, &[("lines", "vector")]);
    let layer = &drawing.layers[0];
    assert!(layer.image.is_none());
    assert!(layer.strokes.width.iter().all(|w| (w - 2.0).abs() < 0.02), "{:?}", &layer.strokes.width[..2]);
}
