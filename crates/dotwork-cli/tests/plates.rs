//! Plates: vectors and print pixels, pens and plots, scale bars, and pictures drawn again from what they carry.

mod common;

use common::{Place, Table, box_obj};

/// A folder with an input below it.
fn place() -> Place {
    let place = Place::new();
    std::fs::create_dir(place.path("in")).unwrap();
    place.write("in/box.obj", box_obj([0.0; 3], [40.0, 30.0, 20.0]));
    place
}

#[test]
fn every_plate_is_drawn_again_to_the_byte() {
    let place = place();
    let scene = "in/box.obj demo:torus --style sepia --set gamma=1.3 --page 60x50mm --margin 4mm --ortho --seed 9 \
                 --scale-bar 10mm --camera 33,12 --light=-20,50 --stipples 3000";
    for (out, options) in [
        ("svg", ""),
        ("svg", "--pens 0.2,0.4 --plot"),
        ("pdf", ""),
        ("png", ""),
        ("png", "--bilevel --dpi 600"),
        ("tif", "--pens 0.3"),
        ("tif", "--bilevel"),
    ] {
        place.run(&format!("render {scene} -o plate.{out} {options} --quiet")).ok();
        // Pens, pages and stipples are settings; what a file is made into is said again.
        let kind: Vec<&str> = ["--plot", "--bilevel"].into_iter().filter(|o| options.contains(o)).collect();
        let kind = kind.join(" ");
        place.run(&format!("render plate.{out} -o again.{out} {kind} --quiet")).ok();
        assert!(
            place.read(&format!("plate.{out}")) == place.read(&format!("again.{out}")),
            "{out} {options}"
        );
    }
    // From one kind to another, through the same dots.
    place.run(&format!("render {scene} -o one.csv --quiet")).ok();
    place.run(&format!("render {scene} -o plate.svg --quiet")).ok();
    place.run("render plate.svg -o two.csv --quiet").ok();
    assert_eq!(place.text("one.csv"), place.text("two.csv"));
}

#[test]
fn options_lie_over_what_a_plate_holds() {
    let place = place();
    place.run("render in/box.obj -o plate.svg --style hard --size 200 --set dot_size=3px").ok();
    place.run("render plate.svg -o large.csv --size 400").ok();
    place.run("render in/box.obj -o expected.csv --style hard --size 400 --set dot_size=3px").ok();
    assert_eq!(place.text("large.csv"), place.text("expected.csv"));
    place.run("render plate.svg -o blue.csv --set color=#0000ff").ok();
    assert!(Table::read(&place.text("blue.csv")).words("b").iter().all(|b| *b == "255"));
    // Another light asks for other stipples.
    place.run("render in/box.obj -o light.csv --style hard --size 200 --set dot_size=3px --light=100,0").ok();
    place.run("render plate.svg -o again.csv --light=100,0").ok();
    assert_eq!(place.text("again.csv"), place.text("light.csv"));
    place.run("render plate.svg demo:torus -o both.csv").failed(2, &["plate.svg", "alone"]);
}

#[test]
fn a_plate_of_baked_stipples_has_as_many_when_it_is_drawn_again() {
    let place = place();
    // Baked for one view, drawn from another: auto alone would bake another number.
    place.run("bake in/box.obj -o box.dots --size 100").ok();
    place.run("render box.dots -o plate.svg --camera 80,60 --size 300 --quiet").ok();
    place.run("render plate.svg -o again.svg --quiet").ok();
    assert!(place.read("plate.svg") == place.read("again.svg"));
}

#[test]
fn inputs_that_changed_or_went_are_named() {
    let place = place();
    place.run("render in/box.obj -o plate.pdf --size 100").ok();
    // Beside the plate it is found too.
    std::fs::rename(place.path("in/box.obj"), place.path("box.obj")).unwrap();
    place.run("render plate.pdf -o again.pdf").ok();
    assert!(place.read("plate.pdf") == place.read("again.pdf"));
    place.write("box.obj", box_obj([0.0; 3], [41.0, 30.0, 20.0]));
    place.run("render plate.pdf -o x.png").failed(1, &["plate.pdf", "box.obj", "has changed", "checksum"]);
    std::fs::remove_file(place.path("box.obj")).unwrap();
    place.run("render plate.pdf -o x.png").failed(1, &["plate.pdf", "in/box.obj", "is gone"]);
    assert!(!place.names().contains(&"x.png".to_string()));
    // What it holds can still be told.
    let words = place.run("info plate.pdf").ok().stdout;
    assert!(words.contains("in/box.obj") && words.contains("dotwork"), "{words}");
    assert_eq!(place.run("info plate.pdf --json").ok().json()["objects"][0]["source"], "in/box.obj");
}

#[test]
fn an_input_of_a_plate_is_not_overwritten() {
    let place = place();
    // A mesh whatever its name: content decides.
    let mesh = common::ply(
        &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    );
    place.write("mesh.csv", &mesh);
    place.run("render mesh.csv -o plate.svg --size 100").ok();
    place.run("render plate.svg -o ./mesh.csv").failed(2, &["mesh.csv", "overwrite"]);
    assert_eq!(place.text("mesh.csv"), mesh);
    // A picture among the pages of a folder would be one of them.
    std::fs::create_dir(place.path("pages")).unwrap();
    place.run("render pages -o pages/9.tif --iso 1").failed(2, &["pages/9.tif", "a page of the input pages"]);
}

#[test]
fn warnings_about_inputs_of_a_plate_name_them() {
    let place = place();
    place.write("in/a.obj", box_obj([0.0; 3], [1.0; 3]) + "v 5 5 5\n");
    place
        .run("render in/a.obj in/box.obj -o plate.svg --size 100")
        .warned(&["warning: in/a.obj: ", "unused"]);
    place.run("render plate.svg -o again.svg").warned(&["plate.svg: its input in/a.obj: ", "unused"]);
}

#[test]
fn pictures_of_others_are_no_plates() {
    let place = place();
    place.write("other.svg", "<?xml version='1.0'?><svg xmlns='http://www.w3.org/2000/svg'/>");
    place.run("render other.svg -o x.png").failed(1, &["other.svg", "without dotwork's settings"]);
    place.run("render in/box.obj -o plate.svg --size 100").ok();
    let broken = place.text("plate.svg").replace("gamma", "gama");
    place.write("broken.svg", broken);
    place.run("render broken.svg -o x.png").failed(1, &["broken.svg", "gama"]);
    assert!(!place.names().contains(&"x.png".to_string()));
}

#[test]
fn scale_bars_hold_only_in_parallel_views() {
    let place = place();
    place
        .run("render in/box.obj -o x.png --scale-bar auto")
        .failed(2, &["--scale-bar", "parallel", "--ortho"]);
    place
        .run("render in/box.obj -o x.png --ortho --scale-bar 500")
        .failed(2, &["--scale-bar", "does not fit"]);
    place.run("render in/box.obj -o x.png --scale-bar long").failed(2, &["--scale-bar", "20mm"]);
    assert_eq!(place.names(), ["in"]);
    // The box is 40 long, seen from the front; the bar's line is as long as half of it.
    place.run("render in/box.obj -o bar.json --ortho --camera front --scale-bar 20mm --size 500").ok();
    let drawing: serde_json::Value = serde_json::from_str(&place.text("bar.json")).unwrap();
    let layer = &drawing["layers"][1];
    assert_eq!((&layer["object"], &layer["strokes"][0]["kind"]), (&"scale bar".into(), &"annotation".into()));
    let x: Vec<f64> = serde_json::from_value(layer["strokes"][0]["x_px"].clone()).unwrap();
    let px: Vec<f64> = serde_json::from_value(drawing["layers"][0]["dots"]["x_px"].clone()).unwrap();
    let (low, high) = px.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
    assert!(((x[2] - x[1]) / ((high - low) / 2.0) - 1.0).abs() < 0.02, "{x:?} {low} {high}");
}

#[test]
fn a_plot_has_a_touch_for_each_dot_and_says_the_travel() {
    let place = place();
    let scene = "render in/box.obj --page 50x40mm --margin 4mm --set dot_size=0.4mm";
    let said = place.run(&format!("{scene} -o plot.svg --plot --pens 0.2,0.35,0.5")).stdout;
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines.iter().any(|l| l.contains("pen 0.2 mm")) && said.contains("in the air"), "{said}");
    let text = place.text("plot.svg");
    place.run(&format!("{scene} -o plot.csv --pens 0.2,0.35,0.5 --quiet")).ok();
    let dots = Table::read(&place.text("plot.csv")).rows.len();
    assert_eq!(text.matches("h0.001").count() + text.matches("h.001").count(), dots);
    assert!(text.matches("inkscape:groupmode=\"layer\"").count() >= 2);
    // Without pens each object has one, and that is said.
    place.run(&format!("{scene} -o one.svg --plot")).warned(&["box: drawn for a pen of", "--pen"]);
    // A pen that is given is the pen.
    let said = place.run(&format!("{scene} -o one.svg --plot --pen 0.3mm")).ok().stdout;
    assert!(said.starts_with("pen 0.3 mm #000000: "), "{said}");
    place.run(&format!("{scene} -o x.png --plot")).failed(2, &["--plot", ".svg"]);
    place.run(&format!("{scene} -o x.svg --bilevel")).failed(2, &["--bilevel", ".png or .tif"]);
    place.run(&format!("{scene} -o x.svg --pens 0.2,0")).failed(2, &["--pens"]);
}

#[test]
fn pens_keep_the_ink() {
    let place = place();
    let line = "render in/box.obj --page 50x40mm --dpi 600 --style hard --set dot_size=0.3mm --csv full -o";
    place.run(&format!("{line} free.csv --quiet")).ok();
    place.run(&format!("{line} pens.csv --pens 0.1,0.2,0.3,0.6 --quiet")).ok();
    let ink = |name: &str| -> f64 {
        Table::read(&place.text(name)).numbers("radius_px").iter().map(|r| r * r).sum()
    };
    assert!(
        (ink("pens.csv") / ink("free.csv") - 1.0).abs() < 0.01,
        "{} {}",
        ink("pens.csv"),
        ink("free.csv")
    );
    let table = Table::read(&place.text("pens.csv"));
    let mut sizes = table.words("radius_px");
    sizes.sort_unstable();
    sizes.dedup();
    assert!((2..=4).contains(&sizes.len()), "{sizes:?}");
    assert!(table.numbers("nx").iter().all(|n| n.is_finite()), "places are those of the object");
}

#[test]
fn killed_in_the_middle_the_old_file_is_whole() {
    let place = place();
    let line = "in/box.obj --size 900 --stipples 12000 --style engraving --quiet";
    for out in ["png", "svg", "pdf", "tif", "csv", "json", "dots"] {
        let command = if out == "dots" { "bake" } else { "render" };
        place.run(&format!("{command} {line} -o new.{out}")).ok();
        let new = place.read(&format!("new.{out}"));
        // However far it came: before, during or after the writing.
        for delay_ms in [10, 50, 100, 150] {
            let name = format!("old.{out}");
            place.write(&name, "the old file");
            let args = format!("{command} {line} -o {name}");
            let mut child = place.command().args(args.split_whitespace()).spawn().unwrap();
            std::thread::sleep(std::time::Duration::from_millis(delay_ms));
            child.kill().unwrap();
            child.wait().unwrap();
            let now = place.read(&name);
            assert!(now == b"the old file" || now == new, "{out} after {delay_ms} ms: {} bytes", now.len());
        }
    }
}
