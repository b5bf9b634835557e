//! What is drawn: conventions of camera and light, columns, pages, and the same bytes every time.

mod common;

use std::collections::HashSet;

use common::{Place, Table, box_obj};

/// A wide box and where its stipples lie, as the table has it.
fn table(options: &str) -> Table {
    let place = Place::new();
    place.write("box.obj", box_obj([-1.0, -0.5, -0.25], [1.0, 0.5, 0.25]));
    place.draw(&format!("box.obj -o t.csv --csv full --stipples 4000 --size 400 {options}"));
    Table::read(&place.text("t.csv"))
}

/// The factor between the columns `of` and `against`, which must be proportional but for an offset.
fn slope(t: &Table, of: &str, against: &str) -> f64 {
    let (y, x) = (t.numbers(of), t.numbers(against));
    let (my, mx) = (t.mean(of), t.mean(against));
    let sxy: f64 = y.iter().zip(&x).map(|(y, x)| (y - my) * (x - mx)).sum();
    let sxx: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
    let k = sxy / sxx;
    let worst = y.iter().zip(&x).map(|(y, x)| (y - my - k * (x - mx)).abs()).fold(0.0, f64::max);
    assert!(worst < 2e-3 * k.abs().max(1.0), "{of} is not proportional to {against}: {worst}");
    k
}

/// Pixels for an object unit: the bounding sphere fills 90 % of 400 pixels.
fn scale() -> f64 {
    180.0 / (1.0f64 + 0.25 + 0.0625).sqrt()
}

#[test]
fn cameras_follow_the_conventions() {
    // camera, then which coordinate grows to the right, upwards, and away from the eye; and the sign
    for (camera, right, up, away) in [
        ("--camera 0,0", ("x", 1.0), ("y", 1.0), ("z", -1.0)),
        ("--camera front", ("x", 1.0), ("y", 1.0), ("z", -1.0)),
        ("--camera 90,0", ("z", -1.0), ("y", 1.0), ("x", -1.0)),
        ("--camera right", ("z", -1.0), ("y", 1.0), ("x", -1.0)),
        ("--camera -90,0", ("z", 1.0), ("y", 1.0), ("x", 1.0)),
        ("--camera left", ("z", 1.0), ("y", 1.0), ("x", 1.0)),
        ("--camera back", ("x", -1.0), ("y", 1.0), ("z", 1.0)),
        ("--camera top", ("x", 1.0), ("z", -1.0), ("y", -1.0)),
        ("--camera bottom", ("x", 1.0), ("z", 1.0), ("y", 1.0)),
        ("--camera 0,0 --up z", ("x", 1.0), ("z", 1.0), ("y", 1.0)),
        ("--camera right --up z", ("y", 1.0), ("z", 1.0), ("x", -1.0)),
        ("--camera 0,0 --up -z", ("x", -1.0), ("z", -1.0), ("y", 1.0)),
        ("--camera right --up=-y", ("z", -1.0), ("y", -1.0), ("x", 1.0)),
    ] {
        // Every side is inked, and nothing hides: all three directions are spanned.
        let t = table(&format!("{camera} --ortho --style flat --set visibility=through"));
        let near = |k: f64, expected: f64| (k / expected - 1.0).abs() < 1e-3;
        assert!(near(slope(&t, "x_px", right.0), scale() * right.1), "{camera}: right");
        assert!(near(slope(&t, "y_px", up.0), -scale() * up.1), "{camera}: up");
        // Seen face on, `through` leaves the sides out; depth then takes two values.
        let depths =
            t.numbers("depth").iter().zip(t.numbers(away.0)).map(|(d, a)| d - a * away.1).collect::<Vec<_>>();
        let spread =
            depths.iter().fold(f64::MIN, |m, &v| m.max(v)) - depths.iter().fold(f64::MAX, |m, &v| m.min(v));
        assert!(spread < 1e-3, "{camera}: depth spreads by {spread}");
    }
}

#[test]
fn inputs_far_from_zero_lie_where_their_files_say() {
    let place = Place::new();
    // Readers bring each near zero by an origin of its own.
    place.write("a.obj", box_obj([1e6, 0.0, 0.0], [1e6 + 1.0, 1.0, 1.0]));
    place.write("b.obj", box_obj([1e6 + 4.0, 0.0, 0.0], [1e6 + 5.0, 1.0, 1.0]));
    place
        .draw("a.obj b.obj -o t.csv --csv full --stipples 1000 --size 300 --camera 0,0 --ortho --style flat");
    let t = Table::read(&place.text("t.csv"));
    let objects = t.words("object");
    let of = |name: &str, fold: fn(f64, f64) -> f64, start: f64| {
        let x = t.numbers("x_px");
        x.into_iter().zip(&objects).filter(|(_, o)| **o == name).map(|(x, _)| x).fold(start, fold)
    };
    // A unit and three units of the same line.
    let [a, b] = ["a", "b"].map(|o| (of(o, f64::min, f64::MAX), of(o, f64::max, f64::MIN)));
    let unit = a.1 - a.0;
    assert!(((b.1 - b.0) / unit - 1.0).abs() < 0.05 && ((b.0 - a.1) / unit - 3.0).abs() < 0.1, "{a:?} {b:?}");
    place.draw("a.obj b.obj -o plate.svg --stipples 1000 --size 200");
    place.draw("plate.svg -o again.svg");
    assert!(place.read("plate.svg") == place.read("again.svg"));
    place.write("c.obj", box_obj([0.0; 3], [1.0; 3]));
    place.run("render c.obj a.obj -o c.csv --size 100").warned(&["a.obj: lies so far from the first input"]);
}

#[test]
fn zoom_and_distance_enlarge() {
    let base = "--camera 0,0 --ortho --style flat";
    let once = slope(&table(base), "x_px", "x");
    let twice = slope(&table(&format!("{base} --zoom 2")), "x_px", "x");
    assert!((twice / once - 2.0).abs() < 1e-3);
    let width = |options: &str| {
        let x = table(&format!("--style flat {options}")).numbers("x_px");
        x.iter().fold(f64::MIN, |m, &v| m.max(v)) - x.iter().fold(f64::MAX, |m, &v| m.min(v))
    };
    let (fitted, near, far) = (width("--camera 0,0"), width("--camera 0,0,5"), width("--camera 0,0,10"));
    assert!(near > 1.8 * far && fitted > far, "{fitted} {near} {far}");
}

#[test]
fn light_comes_from_where_it_is_said() {
    let place = Place::new();
    // Where the ink of a sphere lies, relative to its middle: right and up, in radii.
    let ink = |options: &str| {
        let line = "demo:sphere -o t.csv --style lambert --set dot_size=3px --size 400 --ortho --camera";
        place.draw(&format!("{line} {options}"));
        let t = Table::read(&place.text("t.csv"));
        let area: Vec<f64> = t.numbers("radius_px").iter().map(|r| r * r).collect();
        let whole: f64 = area.iter().sum();
        let at = |name: &str| t.numbers(name).iter().zip(&area).map(|(v, a)| v * a).sum::<f64>() / whole;
        [(at("x_px") - 200.0) / 180.0, (200.0 - at("y_px")) / 180.0]
    };
    let close = |[x, y]: [f64; 2], right: f64, up: f64| {
        // Shade lies opposite the light, and evenly to both sides of that direction.
        let shade = |v: f64, light: f64| if light == 0.0 { v.abs() < 0.03 } else { v * light < -0.05 };
        assert!(shade(x, right) && shade(y, up), "ink at {x:.3},{y:.3} with the light at {right},{up}");
    };
    close(ink("0,0 --light 0,0"), 0.0, 0.0);
    close(ink("0,0 --light 90,0"), 1.0, 0.0);
    close(ink("0,0 --light=-90,0"), -1.0, 0.0);
    close(ink("0,0 --light 0,90"), 0.0, 1.0);
    close(ink("0,0 --light 0,-90"), 0.0, -1.0);
    // The default comes from the upper left, whatever the camera.
    close(ink("70,-20"), -1.0, 1.0);
    // Seen from behind, the object's right is the page's left.
    close(ink("180,0 --light 90,0"), 1.0, 0.0);
    close(ink("180,0 --light 90,0 --light-frame object"), -1.0, 0.0);
}

#[test]
fn tables_have_their_columns_and_ids() {
    let place = Place::new();
    place.draw("demo:torus demo:sphere demo:torus -o t.csv --stipples 3000 --size 300 --set color=#102030");
    place.draw("demo:torus demo:sphere demo:torus -o f.csv --csv full --stipples 3000 --size 300");
    let t = Table::read(&place.text("t.csv"));
    let plain = ["frame", "id", "x_px", "y_px", "depth", "radius_px", "ink", "r", "g", "b", "object", "size"];
    assert_eq!(t.columns, plain);
    assert_eq!(
        Table::read(&place.text("f.csv")).columns,
        [&plain[..], &["x", "y", "z", "nx", "ny", "nz"]].concat()
    );
    let ids: HashSet<u64> = t.words("id").iter().map(|w| w.parse().unwrap()).collect();
    assert_eq!(ids.len(), t.rows.len(), "ids are unique within a frame");
    assert!(ids.iter().all(|&id| id < 1 << 53));
    let objects: HashSet<_> = t.words("object").into_iter().collect();
    assert!(
        objects.is_subset(&HashSet::from(["torus", "sphere", "torus-2"])) && objects.len() > 1,
        "{objects:?}"
    );
    assert!(t.numbers("frame").iter().all(|&f| f == 0.0));
    for (name, low, high) in [
        ("ink", 0.0, 1.0),
        ("size", 0.0, 10.0),
        ("radius_px", 1e-3, 20.0),
        ("x_px", 0.0, 300.0),
        ("y_px", 0.0, 300.0),
        ("depth", 0.0, 1e3),
        ("r", 16.0, 16.0),
        ("g", 32.0, 32.0),
        ("b", 48.0, 48.0),
    ] {
        assert!(t.numbers(name).iter().all(|v| (low..=high).contains(v)), "{name}");
    }
}

#[test]
fn a_stipple_keeps_its_id_from_view_to_view() {
    let place = Place::new();
    let ids = |options: &str| -> HashSet<String> {
        place.draw(&format!("demo:torus -o t.csv --size 300 {options}"));
        Table::read(&place.text("t.csv")).words("id").iter().map(|w| w.to_string()).collect()
    };
    let share = |a: &HashSet<String>, b: &HashSet<String>| a.intersection(b).count() as f64 / a.len() as f64;
    let (front, turned) = (ids("--stipples 20000 --camera 0,0"), ids("--stipples 20000 --camera 2,0"));
    assert!(share(&front, &turned) > 0.8, "{}", share(&front, &turned));
    // A larger bake begins with the same stipples.
    let more = ids("--stipples 30000 --camera 0,0");
    assert!(more.len() > front.len() && share(&front, &more) > 0.99, "{}", share(&front, &more));
}

#[test]
fn full_tables_hold_places_and_unit_normals() {
    let t = table("--style flat");
    let (x, y, z) = (t.numbers("x"), t.numbers("y"), t.numbers("z"));
    let (nx, ny, nz) = (t.numbers("nx"), t.numbers("ny"), t.numbers("nz"));
    for i in 0..t.rows.len() {
        // On the box, one coordinate is at its end.
        let ends = [x[i].abs() - 1.0, y[i].abs() - 0.5, z[i].abs() - 0.25];
        assert!(ends.iter().any(|e| e.abs() < 1e-5) && ends.iter().all(|e| *e < 1e-5));
        assert!((nx[i].powi(2) + ny[i].powi(2) + nz[i].powi(2) - 1.0).abs() < 1e-4);
    }
}

#[test]
fn places_are_those_of_the_file_however_far() {
    let place = Place::new();
    place.write("far.obj", box_obj([4_000_000.0, 0.0, 0.0], [4_000_004.0, 1.0, 1.0]));
    place.draw("far.obj -o t.csv --csv full --stipples 500 --size 200");
    let t = Table::read(&place.text("t.csv"));
    assert!(t.rows.len() > 20 && t.numbers("x").iter().all(|x| (4_000_000.0..=4_000_004.0).contains(x)));
}

/// Width, height and pixels a metre.
fn png_size(bytes: &[u8]) -> (u32, u32, u32) {
    let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let info = reader.info();
    (info.width, info.height, info.pixel_dims.unwrap().xppu)
}

#[test]
fn pages_have_their_size_in_pixels_and_on_paper() {
    let place = Place::new();
    for (options, expected) in [
        ("", (1024, 1024, 11811)),
        ("--size 320x200", (320, 200, 11811)),
        ("--size 100 --dpi 600", (100, 100, 23622)),
        ("--page A8", (614, 874, 11811)),
        ("--page A8-landscape --dpi 100", (291, 205, 3937)),
        ("--page 50.8x25.4mm --dpi 200", (400, 200, 7874)),
    ] {
        place.draw(&format!("demo:torus -o t.png --stipples 20000 {options}"));
        assert_eq!(png_size(&place.read("t.png")), expected, "{options}");
    }
}

#[test]
fn margins_stay_bare() {
    let place = Place::new();
    place.draw(
        "demo:plate -o t.csv --page 60x40mm --margin 10mm --camera 0,0 --zoom 3 --stipples 9000 --style flat",
    );
    let t = Table::read(&place.text("t.csv"));
    let px = 10.0 / 25.4 * 300.0;
    assert!(t.rows.len() > 100);
    assert!(t.numbers("x_px").iter().all(|x| *x >= px && *x <= 60.0 / 25.4 * 300.0 - px + 1.0));
    assert!(t.numbers("y_px").iter().all(|y| *y >= px && *y <= 40.0 / 25.4 * 300.0 - px + 1.0));
}

#[test]
fn a_pen_draws_one_size() {
    let t = table("--pen 0.5mm --dpi 254");
    assert!(t.rows.len() > 100);
    assert!(t.numbers("radius_px").iter().all(|r| *r == 2.5) && t.numbers("ink").iter().all(|i| *i == 1.0));
    // The pen goes over --set, wherever it stands.
    let t = table("--pen 0.5mm --dpi 254 --set foreshorten=1 --set dot_size=9px");
    assert!(t.numbers("radius_px").iter().all(|r| *r == 2.5));
}

#[test]
fn paper_and_style_files_reach_the_picture() {
    let place = Place::new();
    place.write("mine.toml", "extends = \"night\"\ncolor = \"#ff8800\"\n");
    place.draw("demo:torus -o t.png --style mine.toml --paper #204060 --size 64 --stipples 2000");
    let bytes = place.read("t.png");
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    assert_eq!(pixels[..3], [0x20, 0x40, 0x60]);
    place.draw("demo:torus -o t.csv --style mine.toml --size 64 --stipples 2000");
    let t = Table::read(&place.text("t.csv"));
    assert!(t.words("r").iter().all(|v| *v == "255") && t.words("g").iter().all(|v| *v == "136"));
}

#[test]
fn pictures_carry_their_settings() {
    let place = Place::new();
    place.draw("demo:torus -o t.png --size 64 --stipples 2000 --set gamma=2.25 --camera 12,34");
    let bytes = place.read("t.png");
    let reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let texts = &reader.info().uncompressed_latin1_text;
    let text = |keyword: &str| &texts.iter().find(|t| t.keyword == keyword).unwrap().text;
    assert_eq!(*text("Software"), format!("dotwork {}", env!("CARGO_PKG_VERSION")));
    for part in ["gamma = \"2.25\"", "azimuth = 12.0", "source = \"demo:torus\"", "stipples = \"2000\""] {
        assert!(text("dotwork settings").contains(part), "{part}: {}", text("dotwork settings"));
    }
}

#[test]
fn json_is_the_whole_drawing() {
    let place = Place::new();
    place.draw("demo:torus -o t.json --size 200 --stipples 2000");
    place.draw("demo:torus -o t.csv --size 200 --stipples 2000");
    let drawing: serde_json::Value = serde_json::from_str(&place.text("t.json")).unwrap();
    let t = Table::read(&place.text("t.csv"));
    assert_eq!(drawing["layers"][0]["dots"]["id"].as_array().unwrap().len(), t.rows.len());
    assert_eq!(drawing["layers"][0]["object"], "torus");
}

#[test]
fn the_same_bytes_on_any_number_of_threads_and_every_time() {
    let place = Place::new();
    for out in ["png", "csv", "json", "dots"] {
        let command = if out == "dots" { "bake" } else { "render" };
        let line =
            format!("{command} demo:teapot demo:sphere --stipples 20000 --size 300 --style sepia --quiet -o");
        place.run(&format!("{line} one.{out} --threads 1")).ok();
        place.run(&format!("{line} four.{out} --threads 4")).ok();
        place.run(&format!("{line} again.{out} --threads 4")).ok();
        let one = place.read(&format!("one.{out}"));
        assert!(
            one == place.read(&format!("four.{out}")) && one == place.read(&format!("again.{out}")),
            "{out}"
        );
        place.run(&format!("{line} other.{out} --seed 1")).ok();
        assert!(one != place.read(&format!("other.{out}")), "{out}: the seed changes it");
    }
}

#[test]
fn a_stock_that_is_too_small_is_said() {
    let place = Place::new();
    let line = "render demo:torus -o t.png --style flat --set tone=0.8 --stipples 500";
    place.run(line).warned(&["500 stipples", "% of the picture is too light", "--stipples auto"]);
    place.run(&format!("{line} --quiet")).ok();
    place.run("render demo:torus -o t.png --style flat --set tone=0.8 --size 200").ok();
}

#[test]
fn warnings_about_a_mesh_name_its_file_and_come_once() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0; 3]) + "v 9 9 9\n");
    place.run("render box.obj box.obj -o t.png --size 100").warned(&["box.obj: ", "unused"]);
    place.run("info box.obj").warned(&["box.obj: ", "unused"]);
    place.run("info box.obj --quiet").ok();
}
