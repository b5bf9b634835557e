//! Colours follow the light and the depth, and change nothing else.
#![cfg(feature = "files")]

use std::collections::BTreeMap;

use dotwork::drawing::color_space::{Hls, Oklch};
use dotwork::ink::{ColorTable, Coloring};
use dotwork::{Artist, Color, Drawing, Object, Page, Scene, Stipples, Style, Warnings};

/// A sphere of radius 1 round the origin.
fn sphere(keys: &[(&str, &str)]) -> Scene {
    let mut style = Style::default();
    for (key, value) in keys {
        style.set(key, value).unwrap();
    }
    let raw = dotwork::mesh::shapes::sphere(5);
    let object = Object::new("ball", raw, style, &mut Warnings::new()).unwrap();
    let mut scene = Scene { page: Page::pixels(400, 400).unwrap(), ..Scene::of(object) };
    scene.stipples = Stipples::Count(20_000);
    scene.camera.set_direction("-30,20").unwrap();
    scene.bake(|_| ());
    scene
}

/// Even ink, so that dots lie everywhere.
const EVEN: [(&str, &str); 3] = [("base", "0.2"), ("light", "0"), ("silhouette", "0")];

fn with(more: &[(&'static str, &'static str)]) -> Vec<(&'static str, &'static str)> {
    EVEN.iter().chain(more).copied().collect()
}

/// The dots by id: place, size and ink, bit by bit.
fn dots(drawing: &Drawing) -> BTreeMap<u64, [u32; 6]> {
    let mut all = BTreeMap::new();
    for d in drawing.layers.iter().map(|l| &l.dots) {
        for i in 0..d.len() {
            let row = [d.x[i], d.y[i], d.depth[i], d.radius[i], d.size[i], d.ink[i]].map(f32::to_bits);
            assert!(all.insert(d.id[i], row).is_none(), "every dot is drawn once");
        }
    }
    all
}

#[test]
fn colours_leave_the_dots_where_they_are() {
    let plain = Artist::new().draw(&sphere(&[]));
    assert_eq!(plain.layers.len(), 1);
    assert!(plain.dot_count() > 3000 && plain.stroke_count() > 0);
    for by in ["light", "depth", "both"] {
        let drawn = Artist::new().draw(&sphere(&[("coloring", by)]));
        assert!(dots(&drawn) == dots(&plain), "{by}");
        let lines: Vec<_> = drawn.layers.iter().filter(|l| !l.strokes.is_empty()).collect();
        assert!(lines.len() == 1 && lines[0].strokes == plain.layers[0].strokes);
        assert_eq!(lines[0].color, Color::BLACK);
        assert!(std::ptr::eq(lines[0], drawn.layers.last().unwrap()) && lines[0].dots.is_empty());
        let used = &drawn.layers[..drawn.layers.len() - 1];
        assert!(used.len() > 8 && used.len() <= ColorTable::MOST, "{by}: {}", used.len());
        assert!(used.iter().all(|l| l.object == "ball" && !l.dots.is_empty()));
        let mut colors: Vec<_> = used.iter().map(|l| l.color.to_string()).collect();
        colors.sort();
        colors.dedup();
        assert_eq!(colors.len(), used.len(), "one layer for each colour");
        // Ids rise along the order of a bake's stages no less than before: the order of dots within a layer is kept.
        let order: BTreeMap<u64, usize> =
            plain.layers[0].dots.id.iter().enumerate().map(|(i, id)| (*id, i)).collect();
        assert!(used.iter().all(|l| l.dots.id.iter().map(|id| order[id]).is_sorted()));
    }
}

#[test]
fn keys_of_colour_change_nothing_without_coloring() {
    let plain = Artist::new().draw(&sphere(&[]));
    let keys = [("warm", "#123456"), ("cool", "#654321"), ("far", "#abcdef"), ("palette", "sunset")];
    assert_eq!(Artist::new().draw(&sphere(&keys)), plain);
    // Lines with the colour of the ink need no layer of their own.
    assert_eq!(Artist::new().draw(&sphere(&[("outline_color", "#000000")])), plain);
    let parted = Artist::new().draw(&sphere(&[("outline_color", "#ff8000")]));
    assert_eq!(parted.layers.len(), 2);
    assert_eq!(
        (&parted.layers[0].dots, &parted.layers[1].strokes),
        (&plain.layers[0].dots, &plain.layers[0].strokes)
    );
    assert!(parted.layers[0].strokes.is_empty() && parted.layers[1].dots.is_empty());
    assert_eq!(parted.layers[1].color.to_string(), "#ff8000");
}

#[test]
fn the_lit_side_is_warm_and_the_shade_cool() {
    for space in ["oklch", "hls"] {
        let keys = with(&[("coloring", "light"), ("color_space", space)]);
        let scene = sphere(&keys);
        let light = scene.light.direction(&scene.view(), scene.camera.up);
        let stock = scene.objects[0].stock.clone().unwrap();
        let drawing = Artist::new().draw(&scene);
        let style = &scene.objects[0].style;
        let mut before = -1.0f32;
        let mut seen = 0;
        // Layers go from cool to warm: their ranges of n.L follow each other and do not overlap.
        for layer in drawing.layers.iter().filter(|l| !l.dots.is_empty()) {
            // The normal of a sphere is its place.
            let lit = |s: &u32| stock.position.at(*s as usize).normalize().dot(light);
            let least = layer.dots.stipple.iter().map(lit).fold(f32::INFINITY, f32::min);
            let most = layer.dots.stipple.iter().map(lit).fold(f32::NEG_INFINITY, f32::max);
            // Facets bend the normals of the mesh by less than this.
            assert!(
                least > before - 0.01 && most - least < 2.0 / 63.0 + 0.02,
                "{space}: {least} {most} {before}"
            );
            before = most;
            let middle = 0.5 * f64::from(least + most);
            let expected =
                dotwork::drawing::palette::mix(style.cool, style.warm, 0.5 + 0.5 * middle, style.color_space);
            let off = |a: u8, b: u8| a.abs_diff(b) <= 14;
            let c = layer.color;
            assert!(off(c.r, expected.r) && off(c.g, expected.g) && off(c.b, expected.b), "{c} {expected}");
            seen += 1;
        }
        assert!(seen > 40 && before > 0.9, "{space}: {seen} {before}");
        let drawn: Vec<Color> =
            drawing.layers.iter().filter(|l| !l.dots.is_empty()).map(|l| l.color).collect();
        let [cool, warm] = [drawn[0], drawn[seen - 1]];
        assert!(cool.b > cool.r && warm.r > warm.b, "{cool} {warm}");
        assert!(Hls::from(cool).hue > 200.0 && Oklch::from(warm).hue < 70.0, "{cool} {warm}");
    }
}

#[test]
fn colours_follow_depth() {
    let scene = sphere(&with(&[("coloring", "depth")]));
    let drawing = Artist::new().draw(&scene);
    let mut before = f32::INFINITY;
    let mut seen = 0usize;
    for d in drawing.layers.iter().map(|l| &l.dots).filter(|d| !d.is_empty()) {
        let least = d.depth.iter().copied().fold(f32::INFINITY, f32::min);
        let most = d.depth.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        assert!(most <= before, "{most} {before}: from far to near");
        (before, seen) = (least, seen + 1);
    }
    // The rim of a sphere lies r / d of its radius before its centre.
    let view = scene.view();
    let steps = (63.0 * 0.5 * (1.0 - view.radius / view.distance)).round() as usize + 1;
    assert!(steps > 20 && seen.abs_diff(steps) <= 1, "{seen} of {steps}");
}

#[test]
fn what_lies_far_fades() {
    let keys = with(&[("coloring", "both"), ("far", "#ffffff"), ("warm", "#000080"), ("cool", "#000080")]);
    let drawing = Artist::new().draw(&sphere(&keys));
    // One hue: what is left is the distance.
    let mean =
        |d: &dotwork::drawing::Dots| d.depth.iter().map(|v| f64::from(*v)).sum::<f64>() / d.len() as f64;
    let mut rows: Vec<(f64, f64)> = (drawing.layers.iter())
        .filter(|l| !l.dots.is_empty())
        .map(|l| (mean(&l.dots), Oklch::from(l.color).lightness))
        .collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(rows.len() >= 4 && rows.is_sorted_by(|a, b| a.1 < b.1), "{rows:?}");
}

#[test]
fn the_same_scene_gives_the_same_layers() {
    let mut scene = sphere(&[("coloring", "both"), ("palette", "sunset")]);
    let first = Artist::new().draw(&scene);
    assert_eq!(Artist::new().draw(&scene), first);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| Artist::new().draw(&scene)), first);
    // Layers of another frame, more or fewer and of other colours, leave nothing behind.
    let mut artist = Artist::new();
    let mut drawing = artist.draw(&scene);
    for (coloring, outlines) in
        [("none", true), ("light", false), ("depth", true), ("none", false), ("both", true)]
    {
        let style = &mut scene.objects[0].style;
        style.set("coloring", coloring).unwrap();
        style.outlines = outlines;
        artist.draw_into(&scene, &mut drawing);
        assert_eq!(drawing, Artist::new().draw(&scene), "{coloring}");
        assert_eq!(drawing.stroke_count() > 0, outlines);
    }
    assert_eq!(drawing, first);
}

/// The half of a sphere that lies on the far side, or on the near one, seen along `x` or whatever the front is.
fn bowl(far: bool) -> Scene {
    let mut raw = dotwork::mesh::shapes::sphere(5);
    let whole = sphere(&[]);
    let back = whole.view().back;
    let positions = raw.positions.clone();
    let side = |v: u32| {
        let [x, y, z] = positions[v as usize];
        x * back.x + y * back.y + z * back.z
    };
    raw.triangles.retain(|t| t.iter().all(|&v| if far { side(v) <= 0.0 } else { side(v) >= 0.0 }));
    let style = Style { coloring: Coloring::Light, base: 0.3, outlines: false, ..Style::default() };
    let object = Object::new("bowl", raw, style, &mut Warnings::new()).unwrap();
    let mut scene = Scene { page: Page::pixels(300, 300).unwrap(), ..Scene::of(object) };
    scene.stipples = Stipples::Count(10_000);
    scene.camera = whole.camera;
    scene.bake(|_| ());
    scene
}

#[test]
fn backs_are_lit_from_their_side() {
    // Seen into, a bowl is lit where its inside faces the light, and not where its outside does.
    for far in [true, false] {
        let scene = bowl(far);
        let light = scene.light.direction(&scene.view(), scene.camera.up);
        let stock = scene.objects[0].stock.clone().unwrap();
        let drawing = Artist::new().draw(&scene);
        assert!(drawing.dot_count() > 1000);
        let table = ColorTable::new(&scene.objects[0].style).unwrap();
        let mut wrong = 0;
        for layer in &drawing.layers {
            for &s in &layer.dots.stipple {
                let normal = stock.normal.at(s as usize);
                let seen = if far { -normal } else { normal };
                let expected = table.colors()[table.index(seen.dot(light), 0.5) as usize];
                wrong += usize::from(expected != layer.color);
            }
        }
        // Perspective shows a little of the other side at the rim.
        assert!(wrong * 50 < drawing.dot_count(), "far {far}: {wrong} of {}", drawing.dot_count());
    }
}
