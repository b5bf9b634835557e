//! The surface's colour under the dots, and in them.
#![cfg(feature = "files")]

use std::sync::Arc;

use dotwork::drawing::Image;
use dotwork::mesh::{Material, Paint, Picture};
use dotwork::{
    Artist, Color, Drawing, Format, Light, Object, Page, Raster, Rasterizer, RawMesh, Scene, Stipples, Style,
    Warnings, encode_drawing,
};
use glam::{DVec3, Vec3};

const NONE: [f32; 4] = [0.0; 4];

fn style(keys: &[(&str, &str)]) -> Style {
    let mut style = Style { dots: false, outlines: false, ..Style::default() };
    for (key, value) in keys {
        style.set(key, value).unwrap();
    }
    style
}

/// A square in a plane z, from its lower left corner and its side.
fn square([x, y]: [f32; 2], side: f32, z: f32) -> RawMesh {
    let corner = |i: u8| [x + side * f32::from(i & 1), y + side * f32::from(i >> 1), z];
    RawMesh {
        positions: (0..4).map(corner).collect(),
        triangles: vec![[0, 1, 3], [0, 3, 2]],
        polygons: 1,
        ..RawMesh::default()
    }
}

/// Objects seen along -z in parallel, on a page of 100 by 100 pixels.
fn seen(objects: Vec<(RawMesh, Style)>) -> Scene {
    let mut scene = Scene { page: Page::pixels(100, 100).unwrap(), ..Scene::default() };
    for (k, (raw, style)) in objects.into_iter().enumerate() {
        scene.add(Object::new(format!("o{k}"), raw, style, &mut Warnings::new()).unwrap());
    }
    scene.stipples = Stipples::Count(2000);
    scene.camera.set_direction("0,0").unwrap();
    scene.camera.ortho = true;
    scene.bake(|_| ());
    scene
}

/// The picture of an object.
fn picture<'a>(drawing: &'a Drawing, name: &str) -> Option<&'a Image> {
    drawing.layers.iter().filter(|l| l.object == name).find_map(|l| l.image.as_ref())
}

/// The sample of a picture over a pixel of the page; clear beside it.
fn at(image: &Image, x: usize, y: usize) -> [f32; 4] {
    let [left, top, right, bottom] = image.place.map(|v| v as usize);
    if !(left..right).contains(&x) || !(top..bottom).contains(&y) {
        return NONE;
    }
    image.samples[(y - top) * (right - left) + x - left]
}

fn close(a: [f32; 4], b: [f32; 4]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

/// Where a place of the plane z lies on the page.
fn on_page(scene: &Scene, [x, y, z]: [f32; 3]) -> [f32; 2] {
    let (x, y, _) = scene.view().project(Vec3::new(x, y, z));
    [x, y]
}

#[test]
fn a_square_has_its_colour_inside_and_its_share_at_the_edge() {
    let keys = [("fill", "#ff8000"), ("fill_opacity", "0.5")];
    let scene = seen(vec![(square([-1.0, -1.0], 2.0, 0.0), style(&keys))]);
    let drawing = Artist::new().draw(&scene);
    let image = picture(&drawing, "o0").unwrap();
    let [r, g, b] = Color { r: 255, g: 128, b: 0 }.to_linear();
    assert!(close(at(image, 50, 50), [0.5 * r, 0.5 * g, 0.5 * b, 0.5]));
    let ([x0, y1], [x1, y0]) = (on_page(&scene, [-1.0, -1.0, 0.0]), on_page(&scene, [1.0, 1.0, 0.0]));
    // Along an edge a pixel has the share that lies within, to a quarter of its side.
    for x in [x0, x1] {
        let share = if x == x0 { 1.0 - x.fract() } else { x.fract() };
        let found = at(image, x as usize, 50)[3] / 0.5;
        assert!((found - share).abs() <= 0.126, "{found} {share}");
    }
    let all: f32 = image.samples.iter().map(|s| s[3]).sum();
    let area = 0.5 * (x1 - x0) * (y1 - y0);
    assert!((all - area).abs() < 0.01 * area, "{all} {area}");
    // All as bright as it is opaque: no sample mixes with what is beside it.
    assert!(image.samples.iter().all(|s| (s[0] - s[3] * r).abs() < 1e-5 && (s[1] - s[3] * g).abs() < 1e-5));
    // In the raster: half white, half the colour, in linear light.
    let mut raster = Raster::default();
    Rasterizer::new().draw(&drawing, &mut raster);
    let pixel = &raster.samples[(50 * 100 + 50) * 3..][..3];
    let half = |c: f32| dotwork::drawing::color::linear_to_srgb(0.5 + 0.5 * c);
    assert_eq!(pixel, [half(r), half(g), half(b)]);
}

#[test]
fn nearer_objects_hide_farther_ones_whatever_their_order() {
    let near = || (square([0.0, -1.0], 2.0, 0.5), style(&[("fill", "#ff0000")]));
    let far = || (square([-1.0, -1.0], 2.0, 0.0), style(&[("fill", "#0000ff")]));
    for swapped in [false, true] {
        let (objects, names) = match swapped {
            false => (vec![far(), near()], ["o0", "o1"]),
            true => (vec![near(), far()], ["o1", "o0"]),
        };
        let scene = seen(objects);
        let drawing = Artist::new().draw(&scene);
        let [far, near] = names.map(|n| picture(&drawing, n).unwrap());
        let [seam, _] = on_page(&scene, [0.0, 0.0, 0.5]);
        let [left, right] = [seam as usize - 8, seam as usize + 8];
        assert!(close(at(far, left, 50), [0.0, 0.0, 1.0, 1.0]) && close(at(near, left, 50), NONE));
        assert!(close(at(near, right, 50), [1.0, 0.0, 0.0, 1.0]) && close(at(far, right, 50), NONE));
        // No paper shines through the seam: one over the other, in the order of the layers, they are opaque.
        let mut over = NONE;
        for image in drawing.layers.iter().filter_map(|l| l.image.as_ref()) {
            let top = at(image, seam as usize, 50);
            over = std::array::from_fn(|c| top[c] + over[c] * (1.0 - top[3]));
        }
        assert!((over[3] - 1.0).abs() < 1e-5 && (over[0] + over[2] - 1.0).abs() < 1e-5, "{over:?}");
    }
    // One that hides nothing is drawn above, and what it lies before is seen through it.
    let ghost = style(&[("fill", "#ff0000"), ("fill_opacity", "0.25"), ("occlusion", "0")]);
    let scene = seen(vec![(square([0.0, -1.0], 2.0, 0.5), ghost), far()]);
    let drawing = Artist::new().draw(&scene);
    let [seam, _] = on_page(&scene, [0.0, 0.0, 0.5]);
    let x = seam as usize + 8;
    assert!(close(at(picture(&drawing, "o1").unwrap(), x, 50), [0.0, 0.0, 1.0, 1.0]));
    assert!(close(at(picture(&drawing, "o0").unwrap(), x, 50), [0.25, 0.0, 0.0, 0.25]));
    let order: Vec<&str> =
        drawing.layers.iter().filter(|l| l.image.is_some()).map(|l| l.object.as_str()).collect();
    assert_eq!(order, ["o1", "o0"]);
}

#[test]
fn nothing_is_filled_unless_it_is_asked_for_and_dots_stay_where_they_are() {
    let with = |keys: &[(&str, &str)]| {
        let style = Style { dots: true, outlines: true, ..style(keys) };
        Artist::new().draw(&seen(vec![(square([-1.0, -1.0], 2.0, 0.0), style)]))
    };
    let plain = with(&[]);
    assert!(plain.layers.iter().all(|l| l.image.is_none()) && plain.dot_count() > 10);
    assert!(with(&[("fill", "#ff0000"), ("fill_opacity", "0")]) == plain);
    let filled = with(&[("fill", "#ff0000")]);
    // Under all marks.
    assert!(filled.layers[0].image.is_some() && filled.layers[0].dots.is_empty());
    assert!(filled.layers[1..] == plain.layers[..]);
}

#[test]
fn shade_is_that_of_the_light() {
    for azimuth in [0.0f32, 60.0, 120.0] {
        let keys = [("fill", "#ffffff"), ("fill_shade", "0.5"), ("wrap", "0")];
        let mut scene = seen(vec![(square([-1.0, -1.0], 2.0, 0.0), style(&keys))]);
        scene.light = Light { azimuth, elevation: 0.0, ..Light::default() };
        let drawing = Artist::new().draw(&scene);
        let found = at(picture(&drawing, "o0").unwrap(), 50, 50);
        let light = 0.5 + 0.5 * azimuth.to_radians().cos().max(0.0);
        assert!(close(found, [light, light, light, 1.0]), "{azimuth}: {found:?}");
    }
}

/// A square of which the picture's left half is red and its right half blue, in squares.
fn two_coloured() -> RawMesh {
    let picture = Picture::new(2, 1, vec![[255, 0, 0, 255], [0, 0, 255, 255]]).unwrap();
    let material = Material { picture: Some(Arc::new(picture)), nearest: true, ..Material::default() };
    let paint = Paint {
        materials: Arc::new(vec![material]),
        material: vec![0; 2],
        corners: vec![[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]], [[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]]],
    };
    RawMesh { paint: Some(paint), ..square([-1.0, -1.0], 2.0, 0.0) }
}

#[test]
fn a_surface_shows_its_own_colours() {
    let scene = seen(vec![(two_coloured(), style(&[("fill", "own")]))]);
    let drawing = Artist::new().draw(&scene);
    let image = picture(&drawing, "o0").unwrap();
    assert!(close(at(image, 45, 50), [1.0, 0.0, 0.0, 1.0]));
    assert!(close(at(image, 55, 50), [0.0, 0.0, 1.0, 1.0]));
    // Cut to a quarter, what is left keeps its colours.
    let region = dotwork::mesh::ClipRegion::parse("x<0.25", [DVec3::NEG_ONE, DVec3::ONE]);
    let cut = dotwork::mesh::clip(&two_coloured(), &region.unwrap());
    let mut scene = seen(vec![(cut, style(&[("fill", "own")]))]);
    let drawing = scene.draw();
    let image = picture(&drawing, "o0").unwrap();
    for (x, red) in [(-0.25, true), (-0.05, true), (0.05, false), (0.75, false)] {
        let [px, _] = on_page(&scene, [x, 0.0, 0.0]);
        let found = at(image, px as usize, 50);
        assert_eq!((found[0] > 0.99, found[2] > 0.99), (red, !red), "{x}: {found:?}");
    }
}

#[test]
fn dots_take_the_colours_of_the_surface() {
    let keys = [("coloring", "own"), ("base", "0.3"), ("texture", "0")];
    let style = Style { dots: true, ..style(&keys) };
    let scene = seen(vec![(two_coloured(), style)]);
    let drawing = Artist::new().draw(&scene);
    let [red, blue] = [Color { r: 255, g: 0, b: 0 }, Color { r: 0, g: 0, b: 255 }];
    let colors: Vec<Color> = drawing.layers.iter().map(|l| l.color).collect();
    assert_eq!(colors, [red, blue]);
    for (layer, left) in drawing.layers.iter().zip([true, false]) {
        assert!(layer.dots.len() > 20);
        assert!(layer.dots.x.iter().all(|&x| (x < 50.0) == left));
    }
}

#[test]
fn tone_follows_the_picture() {
    let style = Style { dots: true, ..style(&[("texture", "1"), ("fade", "off")]) };
    let scene = seen(vec![(two_coloured(), style)]);
    let drawing = Artist::new().draw(&scene);
    let dots = |left: bool| -> f32 {
        let d = &drawing.layers[0].dots;
        (0..d.len()).filter(|&i| (d.x[i] < 50.0) == left).map(|i| d.radius[i].powi(2)).sum()
    };
    // Blue is darker than red: 1 - 0.0722 beside 1 - 0.2126.
    assert!(dots(false) > 1.05 * dots(true), "{} {}", dots(false), dots(true));
}

#[test]
fn scenes_with_pictures_come_back_from_dots_files() {
    let style = Style { dots: true, ..style(&[("fill", "own"), ("coloring", "own")]) };
    let scene = seen(vec![(two_coloured(), style)]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.dots");
    dotwork::save_dots(&path, &scene).unwrap();
    let again = dotwork::open(&path, &Style::default(), &mut Warnings::new()).unwrap();
    assert_eq!(again.objects[0].mesh, scene.objects[0].mesh);
    assert!(Artist::new().draw(&again) == Artist::new().draw(&scene));
}

#[test]
fn threads_change_nothing_and_vectors_show_it() {
    let style = style(&[("fill", "own"), ("fill_shade", "1")]);
    let drawn = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let torus = dotwork::mesh::shapes::torus(1.0, 0.4, 48, 24);
            let mut scene = seen(vec![(torus, style.clone()), (two_coloured(), style.clone())]);
            scene.camera.set_direction("30,20").unwrap();
            scene.camera.ortho = false;
            (Artist::new().draw(&scene), scene)
        })
    };
    let (one, scene) = drawn(1);
    assert!(one == drawn(3).0);
    for (format, mark) in [(Format::Svg, "<image"), (Format::Pdf, "/Image")] {
        let mut bytes = Vec::new();
        encode_drawing(&mut bytes, format, false, &one, &scene, &mut Warnings::new()).unwrap();
        let count = String::from_utf8_lossy(&bytes).matches(mark).count();
        assert!(count >= 2, "{format:?}: {count}");
    }
}

#[test]
fn shaded_objects_of_scene_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let text = "stipples = 500\n[page]\nsize_px = [60, 60]\n[[object]]\nfile = 'demo:sphere'\nmode = 'shaded'\n\
                [[object]]\nfile = 'demo:sphere'\nfill = '#ff0000'\nfill_shade = 0\nmode = 'shaded'\n";
    std::fs::write(&path, text).unwrap();
    let scene = dotwork::read_scene_file(&path).unwrap();
    let mut scene = scene.scene(None, &|_| (), &mut Warnings::new()).unwrap().0;
    let drawing = scene.draw();
    assert_eq!((drawing.dot_count(), drawing.stroke_count()), (0, 0));
    let grey = picture(&drawing, &scene.objects[0].name).unwrap();
    let lights: Vec<f32> = grey.samples.iter().filter(|s| s[3] == 1.0).map(|s| s[0]).collect();
    let (low, high) = lights.iter().fold((1.0f32, 0.0f32), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(low < 0.2 && high > 0.55, "{low} {high}");
}
