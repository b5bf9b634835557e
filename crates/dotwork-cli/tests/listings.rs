//! What is printed: lists, facts, the manual.

mod common;

use common::{Place, box_obj, ply};

#[test]
fn styles_list_every_preset_and_every_key() {
    let place = Place::new();
    let list = place.run("styles").ok().stdout;
    for preset in dotwork::ink::PRESETS {
        assert!(list.contains(preset.name) && list.contains(preset.summary));
    }
    let reference = place.run("styles --keys").ok().stdout;
    for param in dotwork::ink::PARAMS {
        assert!(reference.contains(&format!("\n  {} = {}", param.name, param.default())), "{}", param.name);
    }
    assert!(reference.lines().all(|l| l.chars().count() <= 80));
    let json = place.run("styles --json").ok().json();
    let keys = json["keys"].as_array().unwrap();
    assert_eq!(keys.len(), dotwork::ink::PARAMS.len());
    assert_eq!(json["styles"].as_array().unwrap().len(), dotwork::ink::PRESETS.len());
    let gamma = keys.iter().find(|k| k["key"] == "gamma").unwrap();
    assert_eq!(gamma["range"], serde_json::json!([0.1, 8.0]));
    assert_eq!(gamma["value"], gamma["default"]);
}

#[test]
fn styles_show_one_style_or_a_file() {
    let place = Place::new();
    let night = place.run("styles night --json").ok().json();
    let value = |json: &serde_json::Value, key: &str| {
        json["keys"].as_array().unwrap().iter().find(|k| k["key"] == key).unwrap()["value"].clone()
    };
    assert_eq!((&night["name"], value(&night, "inked")), (&"night".into(), "light".into()));
    place.write("mine.toml", "extends = 'night'\ngamma = 3\ndescription = 'Stars'\n");
    let mine = place.run("styles mine.toml --json").ok().json();
    assert_eq!((&mine["summary"], value(&mine, "gamma")), (&"Stars".into(), 3.0.into()));
    assert_eq!(value(&mine, "inked"), "light");
    assert!(place.run("styles mine.toml").ok().stdout.contains("gamma = 3 "));
}

#[test]
fn info_tells_the_facts_of_a_box() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0, 2.0, 3.0]));
    let info = place.run("info box.obj --json").ok().json();
    let surface = &info["surface"];
    assert_eq!(info["format"], "OBJ");
    assert_eq!((&info["in_file"]["polygons"], &info["in_file"]["triangles"]), (&6.into(), &12.into()));
    for (key, value) in
        [("vertices", 8), ("triangles", 12), ("edges", 18), ("components", 1), ("boundary_edges", 0)]
    {
        assert_eq!(surface[key], value, "{key}");
    }
    assert_eq!((&surface["closed"], &surface["euler_characteristic"]), (&true.into(), &2.into()));
    assert_eq!((&surface["area"], &surface["volume"]), (&22.0.into(), &6.0.into()));
    assert_eq!(surface["bounds"]["max"], serde_json::json!([1.0, 2.0, 3.0]));
    let words = place.run("info box.obj").ok().stdout;
    for part in ["OBJ", "checksum", "closed", "22", "units"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    place.write("open.ply", ply(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]));
    let open = place.run("info open.ply --json").ok().json();
    assert_eq!((&open["format"], &open["surface"]["closed"]), (&"PLY, text".into(), &false.into()));
    assert_eq!(open["surface"]["boundary_edges"], 3);
}

#[test]
fn info_keeps_quiet_about_nothing() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0; 3]) + "v 5 5 5\n");
    let info = place.run("info box.obj --json").ok().json();
    assert_eq!(info["warnings"].as_array().unwrap().len(), 1);
    assert!(info["warnings"][0].as_str().unwrap().contains("unused"));
}

#[test]
fn demos_are_written_and_read_back() {
    let place = Place::new();
    let list = place.run("demo").ok().stdout;
    for demo in dotwork::mesh::shapes::DEMOS {
        assert!(list.contains(demo.name));
    }
    for file in ["torus.ply", "torus.obj"] {
        place.run(&format!("demo torus -o {file}")).ok();
        place.draw(&format!("{file} -o a.csv --stipples 2000 --size 200"));
        place.draw("demo:torus -o b.csv --stipples 2000 --size 200");
        assert!(place.read("a.csv") == place.read("b.csv"), "{file}");
    }
}

#[test]
fn bench_measures() {
    let place = Place::new();
    let line = "bench demo:torus --stipples 2000 --size 64 --size 80x40";
    let json = place.run(&format!("{line} --json --threads 2")).ok().json();
    assert_eq!(json["threads"], 2);
    let input = &json["inputs"][0];
    assert_eq!((&input["input"], &input["stipples"]), (&"demo:torus".into(), &2000.into()));
    for step in ["load", "clean", "bake"] {
        assert!(input[step]["wall_s"].as_f64().unwrap() > 0.0 && input[step]["cpu_s"].is_number(), "{step}");
    }
    assert_eq!(input["frames"].as_array().unwrap().len(), 2);
    assert!(input["frames"][1]["next_frame"]["raster"]["wall_s"].as_f64().unwrap() > 0.0);
    let dots = |options: &str| {
        let json = place.run(&format!("{line} --json {options}")).ok().json();
        json["inputs"][0]["frames"][0]["dots"].as_u64().unwrap()
    };
    assert!(dots("--style hard") < dots("") && dots("--set tone=0") < dots(""));
    place.run(&format!("{line} --style nihgt")).failed(2, &["nihgt"]);
    let table = place.run(line).ok().stdout;
    assert!(table.contains("80 x 40 pixels") && table.contains("stipples a second"), "{table}");
}

#[test]
fn bench_shows_the_papers_table() {
    let place = Place::new();
    for (input, style) in [("demo:torus", "soft"), ("demo:shells", "papers")] {
        let line = format!("bench {input} --stipples 2000 --size 64 --rates --style {style}");
        let json = place.run(&format!("{line} --json")).ok().json();
        let rates = json["inputs"][0]["frames"][0]["rates"].as_array().unwrap().clone();
        let names: Vec<&str> = rates.iter().map(|r| r["drawn"].as_str().unwrap()).collect();
        assert_eq!(names, ["stipples", "everything"], "{input}");
        for rate in &rates {
            for view in ["view_standing", "view_turning"] {
                assert!(rate[view]["frames_per_s"].as_f64().unwrap() > 0.0, "{input} {view}");
            }
        }
        let strokes = |k: usize| rates[k]["strokes"].as_u64().unwrap();
        assert!(strokes(0) == 0 && strokes(1) > 0, "{input}: lines are in the second only");
        let table = place.run(&line).ok().stdout;
        assert!(table.contains("stipples alone: frames a second, view standing"), "{table}");
    }
}

#[test]
fn manual_pages_and_completions_are_made() {
    let place = Place::new();
    assert!(place.run("man").ok().stdout.starts_with(".ie"));
    for command in ["render", "bake", "info", "styles", "demo", "bench", "completions", "man"] {
        let page = place.run(&format!("man {command}")).ok().stdout;
        assert!(page.contains(&format!(".TH dotwork-{command} 1")), "{page}");
    }
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        assert!(place.run(&format!("completions {shell}")).ok().stdout.contains("render"), "{shell}");
    }
}

#[test]
fn help_teaches_by_example() {
    let place = Place::new();
    for command in ["", "render", "bake", "info", "styles", "demo", "bench"] {
        let help = place.run(&format!("{command} --help")).ok().stdout;
        assert!(help.contains("Examples:") && help.contains("  dotwork "), "{help}");
        assert_eq!(help, place.run(&format!("{command} -h")).ok().stdout);
    }
    assert_eq!(place.run("--version").ok().stdout, format!("dotwork {}\n", env!("CARGO_PKG_VERSION")));
}
