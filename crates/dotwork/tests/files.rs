//! What reading and writing files says besides doing it, and where objects of several files lie.
#![cfg(feature = "files")]

use std::path::Path;

use dotwork::drawing::{Image, Layer};
use dotwork::{
    Drawing, Format, Object, Page, Scene, Stipples, Style, Warnings, load, mesh, open, prepare, save_dots,
    write_drawing,
};
#[cfg(feature = "dicom")]
use dotwork::{LoadOptions, load_with};

/// A small baked torus.
fn torus() -> Scene {
    let mut scene = open("demo:torus", &Style::default(), &mut Warnings::new()).unwrap();
    (scene.page, scene.stipples) = (Page::pixels(60, 60).unwrap(), Stipples::Count(500));
    scene.bake(|_| ());
    scene
}

fn lines(warnings: &Warnings) -> Vec<String> {
    warnings.iter().map(ToString::to_string).collect()
}

/// What is said while a drawing is written.
fn said(drawing: &Drawing, scene: &Scene, format: Format) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let mut warnings = Warnings::new();
    write_drawing(folder.path().join("out"), format, drawing, scene, &mut warnings).unwrap();
    lines(&warnings)
}

#[test]
fn pictures_that_one_bit_cannot_show_are_said_once() {
    let mut scene = torus();
    let mut drawing = scene.draw();
    for format in [Format::PngBilevel, Format::TiffBilevel] {
        assert_eq!(said(&drawing, &scene, format), [""; 0]);
    }
    let (place, samples) = ([10.0, 10.0, 30.0, 20.0], vec![[0.5, 0.5, 0.5, 1.0]; 2]);
    let image = Image { width: 2, height: 1, place, samples };
    drawing.layers.insert(0, Layer { object: "slice".into(), image: Some(image), ..Layer::default() });
    for format in [Format::PngBilevel, Format::TiffBilevel] {
        let said = said(&drawing, &scene, format);
        assert!(said.len() == 1 && said[0].contains("slice"), "{format:?}: {said:?}");
    }
    assert_eq!(said(&drawing, &scene, Format::Png), [""; 0]);
}

/// Found by reading: the series was passed on for folders alone, so that a DICOMDIR gave the largest.
#[test]
#[cfg(feature = "dicom")]
fn a_series_is_asked_for_in_files_too() {
    let file =
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../dotwork-io/tests/data/dicom/deflated_int16.dcm"));
    let options = LoadOptions { series: Some("77".into()), ..LoadOptions::default() };
    assert!(load(file, &mut Warnings::new()).is_ok());
    let error = load_with(file, &options, &mut Warnings::new()).err().expect("there is no such series");
    assert!(error.to_string().contains("has no DICOM series '77'"), "{error}");
}

#[test]
fn pens_that_cannot_be_used_are_said() {
    let mut scene = torus();
    let drawing = scene.draw();
    scene.pens = vec![0.001];
    let mut warnings = Warnings::new();
    let (prepared, _) = prepare(drawing.clone(), Format::Svg, &scene, &mut warnings);
    assert_eq!(prepared, drawing);
    let said = lines(&warnings);
    assert!(said.len() == 1 && said[0].contains("0.001 mm"), "{said:?}");
}

#[test]
fn a_whole_scene_is_no_surface_and_the_error_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = torus();
    let dots = folder.path().join("torus.dots");
    save_dots(&dots, &scene).unwrap();
    let plate = folder.path().join("torus.svg");
    write_drawing(&plate, Format::Svg, &scene.draw(), &scene, &mut Warnings::new()).unwrap();
    for path in [&dots, &plate] {
        let loaded = load(path, &mut Warnings::new()).unwrap();
        let Err(error) = loaded.into_meshes(&Style::default(), None, &mut Warnings::new()) else {
            panic!("it is no surface")
        };
        assert_eq!(error.to_string(), format!("{}: is a whole scene, not a surface", path.display()));
    }
}

/// A sphere about (x, 0, 0) whose reader subtracted that place.
fn ball(x: f64) -> Object {
    let mut raw = mesh::shapes::demo("sphere").unwrap();
    raw.origin = [x, 0.0, 0.0];
    Object::new("ball", raw, Style::default(), &mut Warnings::new()).unwrap()
}

#[test]
fn objects_of_far_files_lie_side_by_side() {
    let scene = |left: f64, baked: bool| {
        let mut right = Scene::of(ball(left + 4.0));
        right.stipples = Stipples::Count(800);
        if baked {
            right.bake(|_| ());
        }
        let mut scene = Scene { stipples: Stipples::Count(800), ..Scene::of(ball(left)) };
        assert!(scene.add(right.objects.remove(0)));
        scene.page = Page::pixels(200, 200).unwrap();
        scene.camera.set_direction("front").unwrap();
        scene.draw()
    };
    for (left, baked) in [(0.0, false), (0.0, true), (1e6, false), (1e6, true)] {
        let drawing = scene(left, baked);
        let range = |k: usize| {
            let x = &drawing.layers[k].dots.x;
            assert!(x.len() > 50);
            x.iter().fold((f32::MAX, f32::MIN), |(low, high), &x| (low.min(x), high.max(x)))
        };
        let ((_, high), (low, _)) = (range(0), range(1));
        assert!(high < 100.0 && low > 100.0, "{left}, {baked}: up to {high} and from {low}");
    }
    // Too far for single precision: it stays about its own middle.
    let mut scene = Scene::of(ball(0.0));
    assert!(!scene.add(ball(1e9)) && !scene.add(ball(f64::INFINITY)));
    assert_eq!(scene.objects[1].mesh.origin, [1e9, 0.0, 0.0]);
    assert_eq!(scene.objects[1].mesh.positions, scene.objects[0].mesh.positions);
}

#[cfg(unix)]
#[test]
fn a_header_that_names_a_device_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nhdr");
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: /dev/zero\n\n";
    std::fs::write(&path, header).unwrap();
    assert!(Path::new("/dev/zero").exists());
    let Err(error) = load(&path, &mut Warnings::new()) else { panic!("it was read") };
    assert!(error.to_string().contains("no regular file"), "{error}");
}
