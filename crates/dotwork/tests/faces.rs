//! The papers' bake of a mesh, from a scene to dots.
#![cfg(feature = "files")]

use std::sync::Arc;

use dotwork::ink::{BakeMethod, Rank, Stock};
use dotwork::{
    Artist, Drawing, Format, Loaded, Object, Page, Scene, Stipples, Style, Warnings, encode_dots,
    encode_drawing, load, open, preset, save_dots, settings_text,
};

fn page() -> Page {
    Page::pixels(300, 300).unwrap()
}

/// A torus, unbaked.
fn torus(style: Style) -> Scene {
    let raw = dotwork::mesh::shapes::torus(1.0, 0.4, 60, 30);
    let object = Object::new("torus", raw, style, &mut Warnings::new()).unwrap();
    Scene { page: page(), ..Scene::of(object) }
}

fn papers() -> Style {
    Style { k_max: 0.02, ..preset("papers-surface").unwrap() }
}

/// The default style on the lists of faces.
fn soft() -> Style {
    Style { bake: BakeMethod::Face, ..Style::default() }
}

fn baked(style: Style) -> Scene {
    let mut scene = torus(style);
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

fn by_faces(scene: &Scene) -> bool {
    stock(scene).elements.as_ref().is_some_and(|elements| elements.are_faces())
}

#[test]
fn faces_are_asked_for_by_name_and_are_what_the_papers_mean_on_a_mesh() {
    for style in [papers(), soft(), Style { k_max: 0.02, ..preset("papers").unwrap() }] {
        let scene = baked(style);
        assert!(by_faces(&scene) && draw(&scene).dot_count() > 1000);
        assert!(scene.bake_warnings().is_empty(), "{:?}", scene.bake_warnings());
    }
    for style in [Style::default(), Style { bake: BakeMethod::Voxel, ..Style::default() }] {
        assert!(stock(&baked(style)).elements.is_none());
    }
}

#[test]
fn the_papers_take_their_number_from_the_view_and_a_sum_of_ink_from_the_scene() {
    let first = stock(&baked(papers())).len();
    for stipples in [Stipples::Auto, Stipples::Count(77)] {
        let mut other = torus(papers());
        (other.stipples, other.page) = (stipples, Page::pixels(900, 900).unwrap());
        other.camera.set_direction("70,-20").unwrap();
        other.bake(|_| ());
        assert_eq!(stock(&other).len(), first);
    }
    let mut near = torus(papers());
    near.camera.zoom = 2.0;
    near.bake(|_| ());
    let times = stock(&near).len() as f32 / first as f32;
    assert!((times - 4.0).abs() < 0.01, "{times}");
    let mut counted = torus(soft());
    counted.stipples = Stipples::Count(7777);
    counted.bake(|_| ());
    assert_eq!(stock(&counted).len(), 7777);
}

#[test]
fn a_plate_is_drawn_again() {
    let folder = tempfile::tempdir().unwrap();
    for (k, style) in [papers(), soft()].into_iter().enumerate() {
        let mut scene = open("demo:teapot", &style, &mut Warnings::new()).unwrap();
        scene.page = page();
        scene.bake(|_| ());
        assert!(by_faces(&scene));
        let first = bytes(&scene, Format::Png);
        let path = folder.path().join(format!("{k}.png"));
        std::fs::write(&path, &first).unwrap();
        let Loaded::Plate(plate) = load(&path, &mut Warnings::new()).unwrap() else {
            panic!("it is a plate")
        };
        let again = plate.scene(&mut Warnings::new()).unwrap();
        assert!(first == bytes(&again, Format::Png));
    }
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
    for (key, value) in [("k_max", "0.07"), ("bake", "blue-noise"), ("factors", "sum"), ("rank", "random")] {
        assert!(restyled(key, value).stock.is_none(), "{key}");
    }
    for (key, value) in [("k_le", "2"), ("tone", "0.4"), ("slab", "2"), ("bake", "voxel"), ("toon", "0.2")] {
        let object = restyled(key, value);
        assert!(object.stock.is_some_and(|s| Arc::ptr_eq(&s, stock(&scene))), "{key}");
    }
    // Creases change normals, and stipples keep their places.
    let creased = restyled("crease_angle", "5").stock.unwrap();
    assert!(creased.baked == stock(&scene).baked && creased.normal != stock(&scene).normal);
    let mut again = Scene { objects: vec![restyled("rank", "random")], page: page(), ..Scene::default() };
    again.bake(|_| ());
    let fresh = baked(Style { rank: Rank::Random, ..papers() });
    assert!(bytes(&again, Format::Csv) == bytes(&fresh, Format::Csv));
    assert!(bytes(&fresh, Format::Csv) != bytes(&scene, Format::Csv));
}

#[test]
fn a_dots_file_gives_the_bytes_of_its_source() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("torus.dots");
    for style in [papers(), soft()] {
        // Beside an object that moves its origin.
        let mut ball =
            open("demo:sphere", &Style::default(), &mut Warnings::new()).unwrap().objects.remove(0);
        Arc::make_mut(&mut ball.mesh).origin = [0.3, 0.7, 11.1];
        let mut scene = Scene { page: page(), stipples: Stipples::Count(3000), ..Scene::default() };
        scene.add(ball);
        // Baked before it is moved.
        scene.add(baked(style).objects.remove(0));
        scene.bake(|_| ());
        save_dots(&path, &scene).unwrap();
        let mut after = open(&path, &Style::default(), &mut Warnings::new()).unwrap();
        assert_eq!(settings_text(&scene), settings_text(&after));
        assert!(scene.objects[1].stock == after.objects[1].stock);
        for format in [Format::Png, Format::CsvFull] {
            assert!(bytes(&scene, format) == bytes(&after, format), "{format:?}");
        }
        assert_eq!(encode_dots(&scene), encode_dots(&after));
        // The surface is there: another bake can be had.
        let style = Style { bake: BakeMethod::BlueNoise, ..after.objects[1].style.clone() };
        after.objects[1].restyle(style).unwrap();
        assert!(after.objects[1].stock.is_none());
    }
}

#[test]
fn what_is_doubtful_is_said() {
    let said =
        |scene: &Scene| scene.bake_warnings().iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    let mut scene = baked(papers());
    scene.camera.zoom = 2.5;
    assert!(said(&scene).contains("its faces were baked for a picture of another scale"), "{}", said(&scene));
    // As if more had been asked for than is ever baked.
    let mut scene = baked(papers());
    let stock = Arc::make_mut(scene.objects[0].stock.as_mut().unwrap());
    stock.elements.as_mut().unwrap().wanted *= 4.0;
    assert!(said(&scene).contains("its faces show 25 % of the stipples"), "{}", said(&scene));
}

#[test]
fn threads_do_not_matter() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bytes(&baked(papers()), Format::Png))
    };
    assert!(run(1) == run(2));
}
