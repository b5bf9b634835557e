//! The papers' bake of a volume, from a scene to dots.
#![cfg(feature = "files")]

use std::sync::Arc;

use dotwork::ink::{BakeMethod, Stock, Visibility};
use dotwork::volume::{Volume, phantom};
use dotwork::{
    Artist, Drawing, Format, Loaded, Object, Page, Scene, Stipples, Style, VolumeInput, Warnings,
    encode_dots, encode_drawing, load, open, preset, save_dots, settings_text,
};
use glam::Vec3;

const SIDE: f32 = 240.0;

fn page() -> Page {
    Page::pixels(SIDE as u32, SIDE as u32).unwrap()
}

/// Nested spheres, a demo of the command's.
fn shells(style: Style) -> Scene {
    let input = VolumeInput::new("shells", "demo:shells", phantom::phantom("shells").unwrap());
    let mut warnings = Warnings::new();
    let meshes = Loaded::Volume(Box::new(input)).into_meshes(&style, None, &mut warnings).unwrap();
    let mut scene = Scene { page: page(), ..Scene::default() };
    scene.camera.zoom = 0.5;
    for mesh in meshes {
        scene.add(mesh.into_object(style.clone(), &mut warnings).unwrap());
    }
    scene
}

/// The preset, with few stipples.
fn papers() -> Style {
    Style { k_max: 0.1, ..preset("papers").unwrap() }
}

fn baked(style: Style) -> Scene {
    let mut scene = shells(style);
    scene.bake(|_| ());
    scene
}

fn draw(scene: &Scene) -> Drawing {
    Artist::new().draw(scene)
}

fn bytes(scene: &Scene, format: Format) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode_drawing(&mut bytes, format, false, &draw(scene), scene, &mut Warnings::new()).unwrap();
    bytes
}

fn stock(scene: &Scene) -> &Arc<Stock> {
    scene.objects[0].stock.as_ref().unwrap()
}

/// Places of the dots in object space, from the centre of the scene.
fn places(scene: &Scene) -> Vec<Vec3> {
    let center = scene.bounding_sphere().0;
    let drawing = draw(scene);
    drawing.layers[0].dots.stipple.iter().map(|&i| stock(scene).position.at(i as usize) - center).collect()
}

/// How many of the places lie within `reach` of the sphere of this radius.
fn near(places: &[Vec3], radius: f32, reach: f32) -> usize {
    places.iter().filter(|p| (p.length() - radius).abs() < reach).count()
}

#[test]
fn every_shell_is_drawn_and_nothing_else() {
    let scene = baked(papers());
    assert_eq!(scene.objects[0].style.visibility, Visibility::Through);
    let elements = stock(&scene).elements.as_ref().unwrap();
    let (places, reach) = (places(&scene), 2.5 * elements.reach);
    assert!(places.len() > 2000, "{}", places.len());
    let mut shelled = 0;
    for (radius, _) in phantom::SHELLS {
        let count = near(&places, radius, reach);
        assert!(count > 100, "{count} dots about the shell of radius {radius}");
        shelled += count;
    }
    assert!(
        shelled >= places.len() - places.len() / 100,
        "dots lie between the shells: {shelled} of {}",
        places.len()
    );

    // In the projection of the largest.
    let view = scene.view();
    let largest = phantom::SHELLS.iter().map(|s| s.0).fold(0.0, f32::max) + reach;
    let scale = view.px_per_unit(view.distance - largest);
    for layer in &draw(&scene).layers {
        for (x, y) in layer.dots.x.iter().zip(&layer.dots.y) {
            let away = (x - 0.5 * SIDE).hypot(y - 0.5 * SIDE);
            assert!(away < largest * scale, "a dot lies {away} px from the middle");
        }
    }

    let mut solid = papers();
    solid.visibility = Visibility::Solid;
    let scene = baked(solid);
    let places = self::places(&scene);
    let outer = phantom::SHELLS.iter().map(|s| s.0).fold(0.0, f32::max);
    assert!(near(&places, outer, reach) > 100);
    // What lies within is hidden.
    assert!(near(&places, outer, reach) > places.len() - places.len() / 50, "{}", places.len());
}

#[test]
fn the_same_scene_gives_the_same_bytes_and_counts_do_not_matter() {
    let scene = baked(papers());
    let first = bytes(&scene, Format::Csv);
    assert!(first == bytes(&baked(papers()), Format::Csv));
    for stipples in [Stipples::Auto, Stipples::Count(77)] {
        let mut other = shells(papers());
        other.stipples = stipples;
        other.bake(|_| ());
        assert!(first == bytes(&other, Format::Csv), "{stipples}");
    }
    // As a plate is drawn again.
    let mut again = shells(papers());
    again.bake_counts(&[stock(&scene).len()], |_| ());
    assert!(first == bytes(&again, Format::Csv));
    let mut other = shells(papers());
    other.seed = 5;
    other.bake(|_| ());
    assert!(first != bytes(&other, Format::Csv));
}

#[test]
fn the_bake_depends_neither_on_the_side_seen_nor_on_the_page_s_pixels() {
    let one = baked(papers());
    let mut turned = shells(papers());
    turned.camera.set_direction("70,-20").unwrap();
    turned.page = Page::pixels(2 * SIDE as u32, 2 * SIDE as u32).unwrap();
    turned.bake(|_| ());
    let [a, b] = [&one, &turned].map(|scene| stock(scene).elements.as_ref().unwrap());
    assert_eq!(a.len(), b.len());
    assert!((a.n_max / b.n_max - 1.0).abs() < 1e-3, "{} {}", a.n_max, b.n_max);

    // Nearer, voxels are finer, up to those of the volume.
    let mut near = shells(papers());
    near.camera.zoom = 1.0;
    near.bake(|_| ());
    let near = stock(&near).elements.as_ref().unwrap();
    assert!(near.len() > 2 * a.len() && near.reach < 0.6 * a.reach, "{} {}", near.len(), a.len());
}

#[test]
fn a_plate_is_drawn_again() {
    let style = papers();
    let mut scene = open("demo:shells", &style, &mut Warnings::new()).unwrap();
    scene.page = page();
    scene.camera.set_direction("30,20").unwrap();
    scene.camera.zoom = 0.5;
    scene.bake(|_| ());
    let first = bytes(&scene, Format::Png);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shells.png");
    std::fs::write(&path, &first).unwrap();
    let Loaded::Plate(plate) = load(&path, &mut Warnings::new()).unwrap() else { panic!("it is a plate") };
    let again = plate.scene(&mut Warnings::new()).unwrap();
    assert!(first == bytes(&again, Format::Png));
}

#[test]
fn where_no_voxel_carries_a_stipple_the_surface_does() {
    let mut scene = shells(papers());
    scene.objects[0].volume = Some(Arc::new(Volume::from_slice([4; 3], [1.0; 3], &[7u8; 64]).unwrap()));
    scene.stipples = Stipples::Count(500);
    scene.bake(|_| ());
    assert!(stock(&scene).elements.is_none() && stock(&scene).len() == 500, "{}", stock(&scene).len());
    let said = scene.bake_warnings();
    assert!(said.iter().any(|w| w.to_string().contains("no voxels for bake=voxel")), "{said:?}");
}

#[test]
fn restyling_drops_the_bake_that_is_no_longer_the_style_s() {
    let scene = baked(papers());
    let restyled = |key: &str, value: &str| {
        let mut object = scene.objects[0].clone();
        let mut style = object.style.clone();
        style.set(key, value).unwrap();
        object.restyle(style).unwrap();
        object
    };
    for (key, value) in [
        ("k_max", "0.07"),
        ("slab", "1"),
        ("gradient_min", "0.2"),
        ("bake", "blue-noise"),
        ("factors", "sum"),
    ] {
        assert!(restyled(key, value).stock.is_none(), "{key}");
    }
    for (key, value) in [("k_gs", "2"), ("tone", "0.4"), ("crease_angle", "20")] {
        let object = restyled(key, value);
        assert!(object.stock.is_some_and(|s| Arc::ptr_eq(&s, stock(&scene))), "{key}");
    }
    // The next bake gives what a fresh one gives.
    let mut again = Scene { objects: vec![restyled("k_max", "0.07")], page: page(), ..Scene::default() };
    again.camera.zoom = 0.5;
    again.bake(|_| ());
    let mut style = papers();
    style.k_max = 0.07;
    assert!(bytes(&again, Format::Csv) == bytes(&baked(style), Format::Csv));
    assert!(stock(&again).len() < stock(&scene).len());

    let blue = restyled("bake", "blue-noise");
    let mut blue = Scene { objects: vec![blue], page: page(), ..Scene::default() };
    blue.bake(|_| ());
    assert!(stock(&blue).elements.is_none() && blue.bake_warnings().is_empty());
}

#[test]
fn a_dots_file_gives_the_bytes_of_its_source() {
    let mut scene = shells(papers());
    // With an object beside it, which moves its origin.
    let mut ball = open("demo:sphere", &Style::default(), &mut Warnings::new()).unwrap().objects.remove(0);
    Arc::make_mut(&mut ball.mesh).origin = [0.3, 0.7, 1e3];
    let other = scene.objects.remove(0);
    scene.add(ball);
    scene.add(other);
    scene.stipples = Stipples::Count(2000);
    scene.bake(|_| ());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shells.dots");
    save_dots(&path, &scene).unwrap();
    let mut after = open(&path, &Style::default(), &mut Warnings::new()).unwrap();
    assert_eq!(settings_text(&scene), settings_text(&after));
    assert!(scene.objects[1].stock == after.objects[1].stock);
    for format in [Format::Png, Format::CsvFull] {
        assert!(bytes(&scene, format) == bytes(&after, format), "{format:?}");
    }
    assert_eq!(encode_dots(&scene), encode_dots(&after));

    // Without the volume there is no other bake to be had.
    let mut style = after.objects[1].style.clone();
    style.k_max = 0.07;
    after.objects[1].restyle(style).unwrap();
    assert!(after.objects[1].stock.is_some());

    // Moved after it was baked, a file gives the same still.
    let mut moved = Scene { page: page(), ..Scene::default() };
    let mut first = after.objects[0].clone();
    Arc::make_mut(&mut first.mesh).origin = [100.1, 0.0, 0.0];
    moved.add(first);
    assert!(moved.add(after.objects.remove(1)));
    save_dots(&path, &moved).unwrap();
    let again = open(&path, &Style::default(), &mut Warnings::new()).unwrap();
    assert!(moved.objects[1].stock == again.objects[1].stock);
    assert!(bytes(&moved, Format::Png) == bytes(&again, Format::Png));
}

#[test]
fn what_is_doubtful_is_said() {
    let said =
        |scene: &Scene| scene.bake_warnings().iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    let mut scene = baked(papers());
    assert_eq!(said(&scene), "");
    scene.camera.zoom = 0.9;
    assert_eq!(said(&scene), "");
    scene.camera.zoom = 1.25;
    assert!(said(&scene).contains("2.50 times"), "{}", said(&scene));
    scene.camera.zoom = 0.2;
    assert!(said(&scene).contains("0.40 times"), "{}", said(&scene));

    // With a sum of ink there is no meaning that voxels could have for a mesh.
    let raw = dotwork::mesh::shapes::demo("torus").unwrap();
    let style = Style { bake: BakeMethod::Voxel, ..Style::default() };
    let mut mesh = Scene::of(Object::new("torus", raw, style, &mut Warnings::new()).unwrap());
    (mesh.page, mesh.stipples) = (page(), Stipples::Count(3000));
    mesh.bake(|_| ());
    assert!(stock(&mesh).elements.is_none() && draw(&mesh).dot_count() > 100);
    assert!(said(&mesh).contains("no voxels for bake=voxel"), "{}", said(&mesh));
}

#[test]
fn voxels_that_are_clipped_away_carry_no_dots() {
    let clip = |text: &str| Style { clip: dotwork::ink::Clip::Planes(text.into()), k_max: 0.3, ..papers() };
    let scene_of = |style: Style| {
        let mut scene = shells(style);
        scene.camera.set_direction("front").unwrap();
        scene.camera.ortho = true;
        scene.bake(|_| ());
        scene
    };
    let (whole, cut) = (scene_of(clip("")), scene_of(clip("x>0.5")));
    assert!(cut.bake_warnings().is_empty(), "{:?}", cut.bake_warnings());
    // Places across the plane in the middle, object units; a list fills its voxel, whose centre counts.
    let across = |scene: &Scene| -> Vec<f32> {
        let object = &scene.objects[0];
        let [low, high] = object.whole.unwrap();
        let middle = (0.5 * (low.x + high.x) - object.mesh.origin[0]) as f32;
        let dots = &draw(scene).layers[0].dots;
        dots.stipple.iter().map(|&i| stock(scene).position.at(i as usize).x - middle).collect()
    };
    let edge = stock(&cut).elements.as_ref().unwrap().recipe().unwrap().0.edges[0].length();
    let beyond = |places: &[f32]| places.iter().filter(|&&x| x > 0.75 * edge).count();
    let before = |places: &[f32]| places.iter().filter(|&&x| x < -0.75 * edge).count();
    let (whole_places, cut_places) = (across(&whole), across(&cut));
    assert!(beyond(&whole_places) > 500 && before(&cut_places) > 500, "{} dots", cut_places.len());
    assert_eq!(beyond(&cut_places), 0);
    // Another clip is another bake.
    let mut again = cut.clone();
    again.objects[0].restyle(clip("x<0.5")).unwrap();
    assert!(again.objects[0].stock.is_none());
    again.bake(|_| ());
    let places = across(&again);
    assert!(beyond(&places) > 500);
    assert_eq!(before(&places), 0);
}
