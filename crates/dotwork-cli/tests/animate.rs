//! `dotwork animate`: files, options and failures.

#[path = "common/mod.rs"]
mod common;
#[path = "common/gltf.rs"]
mod gltf;

use std::fs;
use std::os::unix::fs::PermissionsExt;

use common::Place;
use dotwork::mesh::shapes;

/// A folder with a ball that grows long within half a second, `ball.gltf`: 12 frames.
fn place() -> Place {
    let place = Place::new();
    let text = gltf::morphing_text(&shapes::sphere(3), |[x, y, z]| [x, 2.0 * y, z], 0.5);
    place.write("ball.gltf", text);
    place
}

const SMALL: &str = "--size 96 --stipples 3000 --quiet";

#[test]
fn a_film_comes_in_every_form() {
    let place = place();
    for (file, beginning) in [("f.gif", &b"GIF89a"[..]), ("f.png", b"\x89PNG"), ("f.csv", b"frame,id,")] {
        place.run(&format!("animate ball.gltf -o {file} {SMALL}")).ok();
        assert!(place.read(file).starts_with(beginning), "{file}");
    }
    let film = place.read("f.png");
    let frames = png::Decoder::new(std::io::Cursor::new(&film)).read_info().unwrap();
    assert_eq!(frames.info().animation_control.map(|a| a.num_frames), Some(12));
    let numbers = |table: &str| -> Vec<u32> {
        let mut all: Vec<u32> =
            table.lines().skip(1).map(|l| l.split(',').next().unwrap().parse().unwrap()).collect();
        all.dedup();
        all
    };
    assert_eq!(numbers(&place.text("f.csv")), (0..12).collect::<Vec<_>>());
    // Numbers are those of the frames.
    place.run(&format!("animate ball.gltf -o f.csv --csv full --frames 3..6 {SMALL}")).ok();
    let table = place.text("f.csv");
    assert!(table.lines().next().unwrap().ends_with(",x,y,z,nx,ny,nz"));
    assert_eq!(numbers(&table), [3, 4, 5]);
    fs::create_dir(place.path("d")).unwrap();
    for ending in ["svg", "pdf", "tif", "json"] {
        place.run(&format!("animate ball.gltf -o d/f-%03d.{ending} --frames 4..6 {SMALL}")).ok();
        assert!(place.path(&format!("d/f-004.{ending}")).is_file());
        assert!(place.path(&format!("d/f-005.{ending}")).is_file());
    }
    assert_eq!(fs::read_dir(place.path("d")).unwrap().count(), 8);
}

#[test]
fn threads_do_not_matter_and_frames_are_those_of_a_film() {
    let place = place();
    for threads in [1, 3] {
        let options = format!("{SMALL} --threads {threads}");
        place.run(&format!("animate ball.gltf -o f{threads}.gif {options}")).ok();
        place.run(&format!("animate ball.gltf -o f{threads}.csv {options}")).ok();
    }
    assert_eq!(place.read("f1.gif"), place.read("f3.gif"));
    assert_eq!(place.read("f1.csv"), place.read("f3.csv"));
}

#[test]
fn a_frame_is_a_plate() {
    let place = place();
    place.run(&format!("animate ball.gltf -o f-%d.png --frames 0..12 {SMALL}")).ok();
    for n in [0, 7, 11] {
        place.draw(&format!("f-{n}.png -o again.png"));
        assert_eq!(place.read("again.png"), place.read(&format!("f-{n}.png")), "{n}");
    }
    // A pose is drawn by itself, too, and comes back from its plate.
    place.run(&format!("render ball.gltf -o pose.svg --clip move --time 0.3 {SMALL}")).ok();
    place.draw("pose.svg -o again.svg");
    assert_eq!(place.read("again.svg"), place.read("pose.svg"));
    place.run(&format!("render ball.gltf -o rest.svg {SMALL}")).ok();
    assert_ne!(place.read("rest.svg"), place.read("pose.svg"));
}

#[test]
fn drawings_are_held() {
    let place = place();
    place.run(&format!("animate ball.gltf -o f-%d.png --frames 0..6 --on-twos 2 {SMALL}")).ok();
    let frame = |n: u32| place.read(&format!("f-{n}.png"));
    assert!(frame(0) == frame(1) && frame(2) == frame(3) && frame(4) == frame(5));
    assert!(frame(1) != frame(2) && frame(3) != frame(4));
    // Held frames are one of a film, shown as long.
    place.run(&format!("animate ball.gltf -o f.png --on-twos 3 {SMALL}")).ok();
    let film = place.read("f.png");
    let frames = png::Decoder::new(std::io::Cursor::new(&film)).read_info().unwrap();
    assert_eq!(frames.info().animation_control.map(|a| a.num_frames), Some(4));
    assert_eq!(frames.info().frame_control.map(|c| c.delay_num), Some(125));
}

#[test]
fn a_film_is_taken_up_again() {
    let place = place();
    let line = format!("animate ball.gltf -o f-%d.png --frames 0..5 {SMALL}");
    place.run(&line).ok();
    let whole: Vec<Vec<u8>> = (0..5).map(|n| place.read(&format!("f-{n}.png"))).collect();
    fs::remove_file(place.path("f-2.png")).unwrap();
    // A frame of another film is drawn again; one that is there is not touched.
    place.write("f-3.png", &whole[1]);
    let touched = |n: u32| fs::metadata(place.path(&format!("f-{n}.png"))).unwrap().modified().unwrap();
    let before = [touched(0), touched(1), touched(4)];
    place.run(&format!("{line} --resume")).ok();
    assert_eq!(before, [touched(0), touched(1), touched(4)]);
    let after: Vec<Vec<u8>> = (0..5).map(|n| place.read(&format!("f-{n}.png"))).collect();
    assert!(after == whole);
    // Other settings make another film.
    place.run(&format!("{line} --resume --set gamma=2")).ok();
    assert!((0..5).all(|n| place.read(&format!("f-{n}.png")) != whole[n as usize]));
    place
        .run("animate ball.gltf -o f.gif --resume")
        .failed(2, &["--resume is for frames in files of their own"]);
}

#[test]
fn paper_can_be_left_out() {
    let place = place();
    place
        .run(&format!("animate ball.gltf -o f-%d.png --frames 0..1 --alpha --set dot_size=4px {SMALL}"))
        .ok();
    let film = place.read("f-0.png");
    let mut frame = png::Decoder::new(std::io::Cursor::new(&film)).read_info().unwrap();
    let mut pixels = vec![0; frame.output_buffer_size().unwrap()];
    let info = frame.next_frame(&mut pixels).unwrap();
    assert_eq!(info.color_type, png::ColorType::Rgba);
    assert_eq!(pixels[..4], [0, 0, 0, 0], "the corner is clear");
    assert!(pixels.chunks(4).any(|p| p == [0, 0, 0, 255]), "ink is not");
    place.run(&format!("animate ball.gltf -o f.gif --frames 0..2 --alpha {SMALL}")).ok();
    place.run("animate ball.gltf -o f.mp4 --alpha").failed(2, &["--alpha is for png, gif and webm"]);
}

#[test]
fn a_turntable_turns_what_stands_still() {
    let place = Place::new();
    place.run(&format!("animate demo:torus -o f-%d.png --turntable 8 {SMALL}")).ok();
    // A quarter of a turn is what a camera there would see.
    place.run(&format!("render demo:torus -o quarter.csv --camera 110,15 {SMALL}")).ok();
    place.run(&format!("animate demo:torus -o f.csv --turntable 8 --frames 2..3 {SMALL}")).ok();
    let rows = |name: &str| -> Vec<String> {
        let rows = |t: String| t.lines().skip(1).map(|l| l.split_once(',').unwrap().1.to_string()).collect();
        rows(place.text(name))
    };
    assert_eq!(rows("quarter.csv"), rows("f.csv"));
    assert_eq!(place.names().iter().filter(|n| n.starts_with("f-")).count(), 8);
}

#[test]
fn failures_say_what_is_there() {
    let place = place();
    place
        .run("animate ball.gltf -o f.gif --clip run")
        .failed(1, &["ball.gltf: ball: there is no animation 'run'; it has move"]);
    place
        .run("animate demo:torus -o f.gif --clip run")
        .failed(1, &["demo:torus: there is no animation 'run'"]);
    place.run("animate demo:torus -o f.gif").failed(1, &["demo:torus: nothing moves"]);
    place.run("animate ball.gltf -o f.gif --film-camera").failed(1, &["ball.gltf: no input has a camera"]);
    place
        .run("animate ball.gltf -o f.svg")
        .failed(2, &["f.svg: a film of svg files has the number of the frame"]);
    place.run("animate ball.gltf -o f.avi").failed(2, &["f.avi: the output of a film ends in"]);
    place.run("animate ball.gltf -o f-%x.png").failed(2, &["f-%x.png: the name of a frame has its number"]);
    place.run("animate ball.gltf -o f.gif --frames 5..5").failed(2, &["write A..B"]);
    place.run("animate ball.gltf -o f.gif --turntable 0").failed(2, &["--turntable"]);
    place.run("animate ball.gltf -o no/f-%d.png").failed(1, &["no/f-0.png"]);
    place
        .run("render ball.gltf -o f.png --clip run")
        .failed(1, &["ball.gltf: there is no animation 'run'; it has move"]);
    place.run("render demo:torus -o f.png --time 1").failed(1, &["no input has an animation"]);
    assert_eq!(place.names(), ["ball.gltf"]);
}

#[test]
fn films_are_packed_by_ffmpeg() {
    let place = place();
    // No ffmpeg on an empty path.
    let mut command = place.command();
    command.env("PATH", "").args(["animate", "ball.gltf", "-o", "f.mp4"]);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("ffmpeg, which packs .mp4 and .webm, is not installed"), "{said}");
    // One that keeps the pixels that it is given.
    let script =
        "#!/bin/sh\nif [ \"$1\" = -version ]; then exit 0; fi\nfor last; do :; done\ncat > \"$last\"\n";
    let program = place.path("bin/ffmpeg");
    fs::create_dir(place.path("bin")).unwrap();
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:/bin:/usr/bin", place.path("bin").display());
    let film = |words: &str| {
        let mut command = place.command();
        command.env("PATH", &path).args(words.split_whitespace()).output().unwrap()
    };
    let done = film(&format!("animate ball.gltf -o f.webm --on-twos 2 {SMALL}"));
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let pixels = place.read("f.webm");
    assert_eq!(pixels.len(), 12 * 96 * 96 * 3);
    let frame = |n: usize| &pixels[n * 96 * 96 * 3..(n + 1) * 96 * 96 * 3];
    assert!(frame(0) == frame(1) && frame(1) != frame(2));
    // One that fails: nothing is left behind.
    fs::write(&program, "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\necho no such codec >&2\nexit 3\n")
        .unwrap();
    let failed = film(&format!("animate ball.gltf -o g.mp4 {SMALL}"));
    assert_eq!(failed.status.code(), Some(1));
    let said = String::from_utf8_lossy(&failed.stderr);
    assert!(said.contains("g.mp4: ffmpeg failed: no such codec"), "{said}");
    assert_eq!(place.names(), ["ball.gltf", "bin", "f.webm"]);
}
