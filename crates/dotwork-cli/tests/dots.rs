//! `.dots` files through the command: the same bytes as their source, options over settings.

mod common;

use common::{Place, Table, box_obj};

#[test]
fn a_dots_file_draws_what_its_source_draws() {
    let place = Place::new();
    place.write("box.obj", box_obj([-1.0, -0.5, -0.25], [1.0, 0.5, 0.25]));
    for (stored, given) in [
        ("--size 300", ""),
        ("--stipples 5000 --seed 3", ""),
        ("--stipples 5000", "--camera -50,30 --size 200x300 --light 10,20 --style hard --set tone=0.7"),
        ("--stipples 5000", "--set crease_angle=30 --ortho --zoom 1.5 --up z"),
        ("--stipples 5000", "--pen 0.3mm --page A7 --margin 5mm --paper #eeeedd"),
        ("--style sepia --camera left --page A8 --dpi 150 --margin 3mm --light-frame object", ""),
        ("--style night --ortho --size 333x222", "--set base=0.1"),
    ] {
        place.run(&format!("bake box.obj -o box.dots {stored}")).ok();
        for out in ["a.png", "a.csv", "a.json"] {
            place.draw(&format!("box.obj -o {out} {stored} {given}"));
            let source = place.read(out);
            place.draw(&format!("box.dots -o {out} {given}"));
            assert!(place.read(out) == source, "{out}: {stored} | {given}");
        }
    }
}

#[test]
fn several_objects_come_back_in_order() {
    let place = Place::new();
    let line = "demo:torus demo:sphere demo:torus --stipples 3000 --size 200";
    place.draw(&format!("{line} -o a.csv --csv full"));
    place.run(&format!("bake {line} -o all.dots")).ok();
    place.draw("all.dots -o b.csv --csv full");
    assert!(place.read("a.csv") == place.read("b.csv"));
}

#[test]
fn a_dots_file_among_other_inputs_brings_its_object_only() {
    let place = Place::new();
    place.run("bake demo:torus -o torus.dots --stipples 3000 --size 200 --camera back").ok();
    place.draw("torus.dots demo:sphere -o t.csv --stipples 3000 --size 300 --camera 0,0 --ortho");
    place.draw("demo:torus demo:sphere -o s.csv --stipples 3000 --size 300 --camera 0,0 --ortho");
    assert!(place.read("t.csv") == place.read("s.csv"));
}

#[test]
fn a_plate_of_several_inputs_has_the_seed_of_the_dots_file() {
    let place = Place::new();
    place.run("bake demo:torus -o five.dots --stipples 3000 --seed 5").ok();
    place.run("bake demo:torus -o six.dots --stipples 3000 --seed 6").ok();
    place.draw("five.dots demo:sphere -o plate.svg --stipples 3000 --size 200");
    place.draw("plate.svg -o again.svg");
    assert!(place.read("plate.svg") == place.read("again.svg"));
    let said = place.run("render five.dots six.dots -o both.csv --size 60").stderr;
    assert!(said.contains("warning: six.dots: was baked with seed 6, an input before it with 5"), "{said}");
}

#[test]
fn what_needs_another_bake_is_said() {
    let place = Place::new();
    place.run("bake demo:torus -o t.dots --stipples 3000").ok();
    place.run("render t.dots -o t.png --seed 1").failed(1, &["t.dots", "seed 0", "--seed 1", "bake"]);
    place.run("render t.dots -o t.png --stipples 9").failed(1, &["t.dots", "3000", "--stipples 9", "bake"]);
    assert_eq!(place.names(), ["t.dots"]);
    place.draw("t.dots -o t.png --seed 0 --stipples 3000 --size 100");
    let loose = place.run("render t.dots -o t.png --set regularity=0.5 --set dot_size=5px --size 100");
    loose.warned(&["t.dots", "regularity 1", "0.5", "bake"]);
    // What of a volume became a surface stays too; of a mesh only the cut is meant.
    let cut =
        place.run("render t.dots -o t.png --set clip=x>0.5 --set smooth=2 --set dot_size=5px --size 100");
    cut.warned(&["t.dots", "with clip auto and keeps it", "; clip x>0.5 needs another dotwork bake"]);
    place.run("bake demo:shells -o s.dots --stipples 3000 --set smooth=1").ok();
    let dense = "render s.dots -o t.png --style bone --set surface=ridge --set dot_size=5px --size 100";
    place.run(dense).warned(&["s.dots", "feature auto, surface iso", "feature dense, surface ridge", "bake"]);
    assert!(!place.run("render s.dots -o t.png --style night --size 100").stderr.contains("smooth"));
    // Another view asks for more than there is: it is made where that view looks, but not beyond a number asked for.
    place.run("bake demo:torus -o small.dots --size 100").ok();
    place.run("render small.dots -o t.png --zoom 9").ok();
    place.run("render t.dots -o t.png --zoom 9").warned(&["% of the picture is too light", "larger number"]);
}

#[test]
fn options_go_over_settings_one_by_one() {
    let place = Place::new();
    place.run("bake demo:torus -o t.dots --stipples 3000 --size 300x200 --camera 40,10 --style night").ok();
    let info = |line: &str| {
        place.run(&format!("bake t.dots -o u.dots {line}")).ok();
        place.run("info u.dots --json").ok().json()
    };
    let kept = info("");
    assert_eq!((&kept["page"]["width_px"], &kept["camera"]["azimuth"]), (&300.into(), &40.0.into()));
    assert_eq!(kept["objects"][0]["style"]["inked"], "light");
    let changed = info("--camera 0,5 --set gamma=3");
    assert_eq!((&changed["page"]["width_px"], &changed["camera"]["azimuth"]), (&300.into(), &0.0.into()));
    assert_eq!(changed["objects"][0]["style"]["inked"], "light", "--set goes over the stored style");
    assert_eq!(changed["objects"][0]["style"]["gamma"], "3");
    let replaced = info("--style hard");
    assert_eq!(replaced["objects"][0]["style"]["inked"], "shade", "--style replaces it");
    assert_eq!(replaced["objects"][0]["stipples"], 3000);
}

#[test]
fn the_stock_is_in_the_file() {
    let place = Place::new();
    place.run("bake demo:torus -o t.dots --stipples 4321").ok();
    place.draw("t.dots -o t.csv --size 500");
    let t = Table::read(&place.text("t.csv"));
    assert!(!t.rows.is_empty() && t.rows.len() < 4321);
    let info = place.run("info t.dots").ok().stdout;
    assert!(info.contains("4,321") && info.contains("demo:torus"), "{info}");
}
