//! Commands that are not understood: exit code 2, one line, nothing written.

mod common;

use common::{Place, box_obj};

#[test]
fn bad_options_are_usage_errors() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0; 3]));
    place.write("x.toml", "gamma = 2\n");
    let before = place.names();
    for (options, part) in [
        ("--camera abc", "not a camera"),
        ("--camera 0,91", "elevation"),
        ("--camera 0,0,0.5", "distance"),
        ("--light 3", "AZ,EL"),
        ("--light nan,0", "AZ,EL"),
        ("--light-frame sun", "viewer or object"),
        ("--up w", "x, y, z, -x, -y or -z"),
        ("--set tone", "key=value"),
        ("--set tone=2", "0 to 1"),
        ("--set gama=2", "did you mean 'gamma'"),
        ("--style nope", "the styles are soft"),
        ("--bake splats", "blue-noise"),
        ("--stipples 0", "auto"),
        ("--stipples some", "auto"),
        ("--backend gpu", "auto, cpu"),
        ("--size 0", "no area"),
        ("--size 100000", "too large"),
        ("--size 3y4", "WIDTHxHEIGHT"),
        ("--size 64 --page A5", "cannot be used with"),
        ("--page A99", "A0 to A8"),
        ("--page A0 --dpi 5000", "too large"),
        ("--page A5 --margin 80mm", "margin"),
        ("--margin 1024px", "margin"),
        ("--margin=-1mm", "not a length"),
        ("--dpi 0", "dpi"),
        ("--pen 0", "width"),
        ("--pen thick", "length"),
        ("--paper grue", "#rrggbb"),
        ("--zoom 0", "--zoom"),
        ("--zoom nan", "--zoom"),
        ("--seed=-1", "--seed"),
        ("--threads 0", "1 to 1024"),
        ("--csv full", ".csv"),
        ("--frobnicate", "--frobnicate"),
    ] {
        place.run(&format!("render box.obj -o out.png {options}")).failed(2, &[part]);
        assert_eq!(place.names(), before, "{options}");
    }
}

#[test]
fn unknown_formats_are_usage_errors_that_list_the_known_ones() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0; 3]));
    for out in ["x.bmp", "x.eps", "x", "x.dots", "png"] {
        let names = "png, svg, pdf, tif, csv, json";
        place.run(&format!("render box.obj -o {out}")).failed(2, &[out, names]);
    }
    place.run("bake box.obj -o x.png").failed(2, &["x.png", ".dots"]);
    place.run("demo torus -o x.stl").failed(2, &["x.stl", ".ply or .obj"]);
    assert_eq!(place.names(), ["box.obj"]);
}

#[test]
fn unknown_names_and_missing_arguments_are_usage_errors() {
    let place = Place::new();
    for (line, part) in [
        ("", "--help"),
        ("frob", "frob"),
        ("render", "--output"),
        ("render demo:torus", "--output"),
        ("render demo:nope -o x.png", "ribbon, teapot"),
        ("demo nope -o x.ply", "ribbon, teapot"),
        ("demo torus", "--output"),
        ("styles nope", "soft"),
        ("completions nope", "bash"),
        ("man nope", "nope"),
        ("info", "INPUT"),
    ] {
        place.run(line).failed(2, &[part]);
    }
    assert!(place.names().is_empty());
}

#[test]
fn style_file_errors_name_file_and_line() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0; 3]));
    for (text, parts) in [
        ("extends = \"hard\"\ngama = 2\n", ["bad.toml:2: ", "did you mean 'gamma'"]),
        ("gamma = 1\n\n\ntone = 7\n", ["bad.toml:4: ", "0 to 1"]),
        ("gamma = 1\nextends = \"nope\"\n", ["bad.toml:2: ", "the presets are soft"]),
        ("gamma =\n", ["bad.toml:1: ", ""]),
    ] {
        place.write("bad.toml", text);
        place.run("render box.obj -o out.png --style bad.toml").failed(1, &parts);
        place.run("styles bad.toml").failed(1, &parts);
    }
    place.run("render box.obj -o out.png --style none.toml").failed(1, &["none.toml", "no such file"]);
    assert_eq!(place.names(), ["bad.toml", "box.obj"]);
}
