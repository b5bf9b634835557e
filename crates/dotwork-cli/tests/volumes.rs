//! Volumes through the command: what is in them, and their isosurfaces.

mod common;

use common::{Place, Table, data};

/// A ball of radius 9 in 24³ voxels, brighter inside, as bytes.
fn ball() -> Vec<u8> {
    let at = |i: usize| i as f64 - 11.5;
    (0..24 * 24 * 24)
        .map(|i| {
            let (x, y, z) = (at(i % 24), at(i / 24 % 24), at(i / 576));
            (128.0 + 12.0 * (9.0 - (x * x + y * y + z * z).sqrt())).clamp(0.0, 255.0) as u8
        })
        .collect()
}

fn nrrd(fields: &str) -> Vec<u8> {
    let mut file =
        format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 24 24\nencoding: raw\n{fields}\n\n")
            .into_bytes();
    file.extend(ball());
    file
}

const PATIENT: &str = "space: right-anterior-superior\nspace directions: (-2,0,0) (0,-2,0) (0,0,2)\n\
                       space origin: (100,50,-20)\nspace units: \"mm\" \"mm\" \"mm\"";

#[test]
fn info_tells_grid_place_and_values() {
    let place = Place::new();
    place.write("ball.nrrd", nrrd(PATIENT));
    let words = place.run("info ball.nrrd").ok().stdout;
    for part in ["24 x 24 x 24", "uint8", "2 x 2 x 2 mm", "LPS", "0 to 2", "histogram", "####"] {
        assert!(words.contains(part), "{part}: {words}");
    }
    let value = place.run("info ball.nrrd --json").ok().json();
    assert_eq!(value["dimensions"], serde_json::json!([24, 24, 24]));
    assert_eq!(value["orientation"], "LPS");
    assert_eq!(value["units"], "mm");
    // The world is the patient's: left, posterior, superior.
    assert_eq!(value["affine"][3], serde_json::json!([-100.0, -50.0, -20.0]));
    let counts: Vec<u64> = serde_json::from_value(value["histogram"]["counts"].clone()).unwrap();
    assert_eq!(counts.iter().sum::<u64>(), 24 * 24 * 24);
}

#[cfg(unix)]
#[test]
fn a_pipe_gives_its_bytes_once() {
    let place = Place::new();
    place.write("ball.nrrd", nrrd(PATIENT));
    let (reader, mut writer) = std::io::pipe().unwrap();
    let bytes = place.read("ball.nrrd");
    let writing = std::thread::spawn(move || std::io::Write::write_all(&mut writer, &bytes));
    let output = place.command().args(["info", "--json", "/dev/stdin"]).stdin(reader).output().unwrap();
    writing.join().unwrap().unwrap();
    let piped = common::Done::of(output, "info /dev/stdin").ok().json();
    let value = place.run("info ball.nrrd --json").ok().json();
    assert_eq!((&piped["checksum"], &piped["values"]), (&value["checksum"], &value["values"]));
}

#[test]
fn the_isosurface_of_a_ball_is_a_sphere() {
    let place = Place::new();
    place.write("ball.raw", ball());
    place.run("render ball.raw --raw 24x24x24:u8:1,1,2 --iso 128 --set smooth=0 -o ball.csv --csv full --stipples 3000 --quiet").ok();
    let t = Table::read(&place.text("ball.csv"));
    let (x, y, z) = (t.numbers("x"), t.numbers("y"), t.numbers("z"));
    let (nx, nz) = (t.numbers("nx"), t.numbers("nz"));
    assert!(x.len() > 300);
    for i in 0..x.len() {
        let (x, y, z) = (x[i] - 11.5, y[i] - 11.5, z[i] / 2.0 - 11.5);
        let r = (x * x + y * y + z * z).sqrt();
        assert!((r - 9.0).abs() < 0.1, "{r}");
        // An ellipsoid twice as long along z.
        let n = [x, y, z / 2.0].map(|v| v / (x * x + y * y + z * z / 4.0).sqrt());
        assert!((nx[i] - n[0]).abs() < 0.1 && (nz[i] - n[2]).abs() < 0.1);
    }
}

#[test]
fn volumes_ask_for_what_they_need() {
    let place = Place::new();
    place.write("ball.nrrd", nrrd("spacings: 1 1 1"));
    place.write("ball.raw", ball());
    place
        .run("render ball.nrrd -o x.png --set feature=99")
        .failed(1, &["ball.nrrd", "no feature 99", "1 (outer, at"]);
    place.run("render ball.nrrd -o x.png --set feature=huge").failed(2, &["feature", "auto | outer"]);
    place
        .run("render ball.nrrd -o x.png --set window=900,901")
        .failed(1, &["ball.nrrd", "window 900 to 901"]);
    place.run("render ball.nrrd -o x.png --set clip=x>2").failed(1, &["ball.nrrd", "clip=x>2"]);
    place.run("render ball.nrrd -o x.png --set clip=x>0.5;y<0.5;w").failed(1, &["ball.nrrd", "clip="]);
    place.run("render ball.nrrd -o x.png --iso 300").failed(1, &["ball.nrrd", "no surface at 300"]);
    place
        .run("render ball.nrrd -o x.png --iso 128 --camera anterior")
        .failed(2, &["anterior", "orientation"]);
    place
        .run("render ball.raw -o x.png --iso 128 --raw 24x24x25:u8")
        .failed(1, &["ball.raw", "14400", "13824"]);
    place.run("render ball.raw -o x.png --iso 128 --raw 24x24x24").failed(2, &["--raw"]);
    assert_eq!(place.names(), ["ball.nrrd", "ball.raw"]);
}

#[test]
fn a_patient_opens_at_the_anterior_view_and_left_is_the_patients() {
    let place = Place::new();
    place.write("p.nrrd", nrrd(PATIENT));
    let draw = |options: &str| {
        place.run(&format!("render p.nrrd --iso 128 -o p.csv --stipples 2000 --quiet {options}")).ok();
        place.text("p.csv")
    };
    assert_eq!(draw(""), draw("--camera anterior"));
    assert_eq!(draw("--camera 0,0 --up z"), draw("--camera anterior"));
    assert_eq!(draw("--camera left"), draw("--camera 90,0"));
    assert_ne!(draw("--camera left"), draw("--camera right"));
    // A plate of it holds the view.
    place.draw("p.nrrd --iso 128 -o p.svg --stipples 2000 --camera superior --ortho --scale-bar auto");
    place.draw("p.svg -o again.svg");
    assert_eq!(place.text("p.svg"), place.text("again.svg"));
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn five_containers_give_the_same_picture() {
    let place = Place::new();
    let volumes = data().join("volumes");
    let mut pictures = Vec::new();
    for name in ["headmr.mhd", "headmr_zlib.mha", "headmr.nrrd", "headmr.nii.gz", "headmr_stack.tif"] {
        let input = volumes.join(name).display().to_string();
        // The stack of images has no spacing and takes 1; the others 4 in every direction.
        place
            .run(&format!(
                "render {input} --iso 40 -o h.csv --up z --camera 15,10 --size 400 --stipples 20000 --quiet"
            ))
            .ok();
        let table = Table::read(&place.text("h.csv"));
        pictures.push([table.words("id"), table.words("x_px"), table.words("y_px")].concat().join(" "));
    }
    assert!(pictures.iter().all(|p| *p == pictures[0]));
}

#[test]
fn volumes_without_anything_to_draw_say_so() {
    let place = Place::new();
    place.write("flat.raw", [7; 512]);
    place.run("render flat.raw --raw 8x8x8:u8 -o x.png").failed(1, &["flat.raw", "all values are 7"]);
    place.write("nan.raw", f32::NAN.to_le_bytes().repeat(512));
    place.run("render nan.raw --raw 8x8x8:f32 -o x.png").failed(1, &["nan.raw", "finite number"]);
    place.run("info nan.raw --raw 8x8x8:f32").ok();
    place.run("info flat.raw --raw 8x8x8:u8 --sheet s.png").failed(1, &["flat.raw", "all values are 7"]);
    place.run("info flat.raw --raw 8x8x8:u8 --sheet s.jpg").failed(2, &["s.jpg", ".png"]);
    place.run("info demo:torus --sheet s.png").failed(2, &["demo:torus", "only volumes"]);
    assert_eq!(place.names(), ["flat.raw", "nan.raw"]);
    // A contact sheet never takes the place of its volume.
    place.write("v.png", nrrd("spacings: 1 1 1"));
    place.run("info v.png --sheet v.png").failed(2, &["v.png", "overwrite"]);
    assert_eq!(place.read("v.png"), nrrd("spacings: 1 1 1"));
}

#[test]
fn a_volume_is_drawn_by_its_feature_and_cut_open() {
    let place = Place::new();
    let value = place.run("info demo:shells --json").ok().json();
    let features = value["features"].as_array().unwrap();
    assert_eq!(features.len(), 4, "{features:?}");
    assert!((1..=4).contains(&value["default_feature"].as_u64().unwrap()));
    place.run("info demo:shells --sheet s.png").ok();
    assert!(place.names().contains(&"s.png".to_owned()));
    // The spheres lie in each other: each is smaller than the one before.
    let radius = |n: usize| {
        place.draw(&format!(
            "demo:shells --set feature={n} -o a.csv --csv full --stipples 4000 --ortho --camera front"
        ));
        let t = Table::read(&place.text("a.csv"));
        let x = t.numbers("x");
        0.5 * (x.iter().copied().fold(f64::MIN, f64::max) - x.iter().copied().fold(f64::MAX, f64::min))
    };
    let radii: Vec<f64> = (1..=4).map(radius).collect();
    assert!(radii.windows(2).all(|w| w[0] > w[1] + 3.0), "{radii:?}");
    // Cut in the middle: nothing of the object is left on one side, and the cut is an object of its own.
    place.draw(
        "demo:shells --set feature=1 --set clip=x>0.5 -o c.csv --csv full --stipples 20000 --camera 60,10",
    );
    let t = Table::read(&place.text("c.csv"));
    let middle = 0.5 * (t.numbers("x").iter().copied().fold(f64::MIN, f64::max) * 2.0);
    let (x, object) = (t.numbers("x"), t.words("object"));
    let cut: Vec<f64> = x.iter().zip(&object).filter(|(_, o)| **o == "shells-cut").map(|(x, _)| *x).collect();
    assert!(cut.len() > 300 && cut.iter().all(|x| (x - middle).abs() < 1e-3), "the cut is plane");
    assert!(x.iter().all(|x| *x <= middle + 1e-3));
    assert!(object.contains(&"shells"));
    // A plate of it is drawn again to the byte.
    place.draw("demo:shells --set feature=1 --set clip=x>0.5 -o c.svg --camera 60,10");
    place.draw("c.svg -o again.svg");
    assert_eq!(place.text("c.svg"), place.text("again.svg"));
}

#[test]
fn a_slice_opens_face_on_with_its_values() {
    let place = Place::new();
    // A disc, less dense on the left of the image.
    let value = |i: usize| {
        let (x, y) = ((i % 64) as f64 - 31.5, (i / 64) as f64 - 31.5);
        if x.hypot(y) > 24.0 {
            0
        } else if x < 0.0 {
            120
        } else {
            200
        }
    };
    place.write("slice.raw", (0..64 * 64).map(value).collect::<Vec<u8>>());
    let draw = |options: &str| {
        place
            .run(&format!(
                "render slice.raw --raw 64x64x1:u8 -o s.csv --size 400 --stipples 60000 --quiet {options}"
            ))
            .ok();
        Table::read(&place.text("s.csv"))
    };
    let t = draw("");
    let cut = |t: &Table| t.words("object").iter().filter(|o| **o == "slice-cut").count();
    assert!(cut(&t) > 500, "its values are drawn");
    // The page's middle is the image's; what is less dense is darker, and on the left as in the image.
    let middle = 200.0;
    let left = t.numbers("x_px").iter().filter(|x| **x < middle).count();
    assert!(left * 2 > t.words("id").len() * 3 / 2, "{left} of {}", t.words("id").len());
    assert_eq!(t.words("id"), draw("--up -y --camera 180,0").words("id"));
    assert_eq!(cut(&draw("--set clip=none")), 0);
    place.draw("slice.raw --raw 64x64x1:u8 -o s.svg --stipples 6000");
    place.draw("s.svg -o again.svg");
    assert_eq!(place.text("s.svg"), place.text("again.svg"));
}

#[test]
fn what_lies_within_a_translucent_body_is_seen() {
    let place = Place::new();
    let count = |options: &str| {
        place.draw(&format!(
            "demo:vessels -o v.csv --stipples 20000 --set outlines=false --size 300x300 {options}"
        ));
        place.text("v.csv").lines().count()
    };
    let (opaque, ghost, clear) = (count(""), count("--set occlusion=0.3"), count("--set occlusion=0"));
    assert!(opaque < ghost && ghost < clear, "{opaque} {ghost} {clear}");
}

/// An element of explicit little endian DICOM.
fn element(tag: [u16; 2], vr: &str, mut value: Vec<u8>) -> Vec<u8> {
    if value.len() % 2 == 1 {
        value.push(if vr == "UI" { 0 } else { b' ' });
    }
    let mut bytes: Vec<u8> = tag.iter().flat_map(|t| t.to_le_bytes()).collect();
    bytes.extend(vr.bytes());
    match vr {
        "OW" | "OB" => bytes.extend([0, 0].into_iter().chain((value.len() as u32).to_le_bytes())),
        _ => bytes.extend((value.len() as u16).to_le_bytes()),
    }
    bytes.extend(value);
    bytes
}

/// Slice `z` of a ball of 24³ bytes, in series `number`.
fn dicom_slice(number: &str, z: usize) -> Vec<u8> {
    let text = |tag, vr, text: &str| element(tag, vr, text.as_bytes().to_vec());
    let short = |tag, value: u16| element(tag, "US", value.to_le_bytes().to_vec());
    let syntax = text([2, 0x10], "UI", "1.2.840.10008.1.2.1");
    let meta = element([2, 0], "UL", (syntax.len() as u32).to_le_bytes().to_vec());
    let samples = ball()[576 * z..576 * (z + 1)].to_vec();
    let parts = [
        vec![0; 128],
        b"DICM".to_vec(),
        meta,
        syntax,
        text([0x0008, 0x0060], "CS", "CT"),
        text([0x0020, 0x000e], "UI", &format!("1.2.{number}")),
        text([0x0020, 0x0011], "IS", number),
        text([0x0020, 0x0032], "DS", &format!("0\\0\\{z}")),
        text([0x0020, 0x0037], "DS", "1\\0\\0\\0\\1\\0"),
        short([0x0028, 0x0002], 1),
        text([0x0028, 0x0004], "CS", "MONOCHROME2"),
        short([0x0028, 0x0010], 24),
        short([0x0028, 0x0011], 24),
        text([0x0028, 0x0030], "DS", "1\\1"),
        short([0x0028, 0x0100], 8),
        short([0x0028, 0x0101], 8),
        short([0x0028, 0x0102], 7),
        short([0x0028, 0x0103], 0),
        element([0x7fe0, 0x0010], "OW", samples),
    ];
    parts.concat()
}

#[test]
fn folders_of_dicom_say_what_is_wrong_with_them() {
    let place = Place::new();
    let folder = |name: &str, files: &[(String, Vec<u8>)]| {
        std::fs::create_dir(place.path(name)).unwrap();
        files.iter().for_each(|(file, bytes)| place.write(&format!("{name}/{file}"), bytes));
    };
    let series = |number: &str, slices: std::ops::Range<usize>| -> Vec<(String, Vec<u8>)> {
        slices.map(|z| (format!("{number}-{z:02}"), dicom_slice(number, z))).collect()
    };
    let drawn = |name: &str, more: &str| {
        let line = format!("render {name} -o d.csv --csv full --stipples 3000 {more}");
        let warning = "the stock of";
        let done = place.command().args(line.split_whitespace()).output().unwrap();
        assert!(done.status.success(), "{line}: {}", String::from_utf8_lossy(&done.stderr));
        let said = String::from_utf8(done.stderr).unwrap();
        let said: Vec<String> = said.lines().filter(|l| !l.contains(warning)).map(Into::into).collect();
        (said, Table::read(&place.text("d.csv")).numbers("x").len())
    };

    // Whole: nothing to say, and something to see.
    folder("whole", &series("4", 0..24));
    let (said, dots) = drawn("whole", "");
    assert!(said.is_empty() && dots > 300, "{said:?} {dots}");

    // Two series: the larger one, or the one that is asked for.
    folder("two", &[series("4", 0..24), series("7", 4..20)].concat());
    let (said, _) = drawn("two", "");
    let [line] = &said[..] else { panic!("{said:?}") };
    assert!(
        line.contains("of 2 DICOM series, CT 4 (24 images) is read; not read: CT 7 (16 images)"),
        "{line}"
    );
    let (said, _) = drawn("two", "--series 7");
    assert!(said[0].contains("of 2 DICOM series, CT 7 (16 images) is read"), "{said:?}");
    place
        .run("render two -o x.png --series spine")
        .failed(1, &["two: ", "'spine'", "CT 4 (24 images), CT 7 (16 images)"]);

    // A slice is missing.
    let mut gap = series("4", 0..24);
    gap.remove(11);
    folder("gap", &gap);
    let (said, _) = drawn("gap", "");
    let [line] = &said[..] else { panic!("{said:?}") };
    assert!(line.contains("gap: ") && line.contains("missing: interpolated"), "{line}");

    // Files that are no DICOM, among slices and alone.
    let notes = [("notes.txt".to_owned(), b"hello".to_vec()), ("cover.png".to_owned(), vec![0; 300])];
    folder("mixed", &[series("4", 0..24), notes.to_vec()].concat());
    let (said, _) = drawn("mixed", "");
    let [line] = &said[..] else { panic!("{said:?}") };
    assert!(line.contains("mixed: 2 files that are no DICOM skipped"), "{line}");
    folder("none", &notes);
    place.run("render none -o x.png").failed(1, &["none: "]);

    // Pixels that end too early: one of many slices is left out by name, alone it is refused.
    let cut = |z: usize| {
        let whole = dicom_slice("4", z);
        whole[..whole.len() - 100].to_vec()
    };
    let mut short = series("4", 0..24);
    short[23].1 = cut(23);
    folder("short", &short);
    let (said, _) = drawn("short", "");
    let [line] = &said[..] else { panic!("{said:?}") };
    assert!(line.contains("4-23") && line.contains("end too early: 476 of 576 bytes"), "{line}");
    folder("shortest", &[("a".to_owned(), cut(3))]);
    place.run("render shortest -o x.png").failed(1, &["shortest", "end too early: 476 of 576 bytes"]);
    place.write("one.dcm", cut(3));
    place.run("render one.dcm -o x.png").failed(1, &["one.dcm: ", "end too early: 476 of 576 bytes"]);
    assert!(!place.path("x.png").exists());
}

#[test]
fn a_segmentation_is_an_input_and_no_table_of_another_volume() {
    let place = Place::new();
    place.write("ball.nrrd", nrrd("spacings: 1 1 1"));
    // Labels of another shape than the volume: there is nothing to pair them with, whatever their shape.
    let mut labels = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 8\nencoding: raw\n\n".to_vec();
    labels.extend((0..512).map(|i| u8::from([i % 8, i / 8 % 8, i / 64].iter().all(|c| (2..6).contains(c)))));
    place.write("labels.nrrd", labels);
    place.run("render ball.nrrd -o x.png --labels labels.nrrd").failed(1, &["labels.nrrd:"]);
    let scene = "[[object]]\nfile = 'ball.nrrd'\nlabels = 'labels.nrrd'\n";
    place.write("scene.toml", scene);
    place.run("render scene.toml -o x.png").failed(1, &["scene.toml:2: ", "labels.nrrd:"]);
    // As an object of its own it lies beside the volume.
    place.write(
        "both.toml",
        "[[object]]\nfile = 'ball.nrrd'\n[[object]]\nfile = 'labels.nrrd'\nlabels = 'auto'\n",
    );
    place.draw("both.toml -o both.csv --stipples 2000 --set occlusion=0");
    let objects = Table::read(&place.text("both.csv"));
    let objects = objects.words("object");
    assert!(objects.contains(&"ball") && objects.contains(&"label-1"), "{objects:?}");
    assert!(!place.path("x.png").exists());
}
