//! Transfer functions in TOML and in Slicer's formats.
#![cfg(feature = "transfer")]

use std::path::Path;

use dotwork_io::transfer::{
    TransferFile, read_transfer, transfer_from_bytes, transfer_names, write_transfer,
};
use dotwork_volume::TransferFunction;

fn read(text: &str) -> TransferFile {
    transfer_from_bytes(Path::new("a"), text.as_bytes(), None).unwrap_or_else(|e| panic!("{e}"))
}

fn refused(bytes: &[u8], preset: Option<&str>) -> String {
    let message = transfer_from_bytes(Path::new("a"), bytes, preset).unwrap_err().to_string();
    assert!(!message.contains('\n') && message.len() < 1500, "{message:?}");
    message
}

#[test]
fn toml_that_a_person_writes() {
    let file = read(
        "# bone\nname = \"bone\"\nopacity = [\n  [-1000, 0.0],\n  [300, 0.1], # plateau\n  [1_200.5, 1],\n]\n\
         color = [[-1000, \"#000000\"], [300, \"#ff8000\"]]\ngradient = [[0, 0], [1e2, 1]]\n",
    );
    assert_eq!(file.name, "bone");
    assert_eq!(file.function.opacity, [(-1000.0, 0.0), (300.0, 0.1), (1200.5, 1.0)]);
    assert_eq!(file.function.color, [(-1000.0, [0.0; 3]), (300.0, [1.0, 128.0 / 255.0, 0.0])]);
    assert_eq!(file.function.gradient, [(0.0, 0.0), (100.0, 1.0)]);
    assert_eq!(read("opacity = [[0, 1]]").function.opacity, [(0.0, 1.0)]);
}

#[test]
fn what_is_written_is_read_again() {
    let colors = (0..256).map(|i| (f64::from(i), [i, 255 - i, 7].map(|c| c as f32 / 255.0))).collect();
    let opacity = vec![(-1e300, 0.0), (-0.1, 1.0 / 3.0), (1e-7, 0.5), (1e22, 1.0), (1e22, 0.25)];
    let function = TransferFunction::new(opacity, colors, vec![(0.5, 0.0)]).unwrap();
    for name in ["", "a \"quoted\" \\ naïve name"] {
        let file = TransferFile { name: name.into(), function: function.clone() };
        let mut bytes = Vec::new();
        write_transfer(&file, &mut bytes).unwrap();
        assert_eq!(read(std::str::from_utf8(&bytes).unwrap()), file);
    }
}

#[test]
fn toml_that_is_none_is_refused_with_its_line() {
    for (text, reason) in [
        ("\nopacity = [[0, 0], [5, 2]]", "line 2: opacity, point 2: 2 is not within 0 to 1"),
        (
            "opacity = [\n[0, 0],\n[-5, 1]]",
            "line 3: opacity, point 2: -5 stands behind 0; values must ascend",
        ),
        ("opacity = [[0, nan]]", "line 1: opacity, point 1: NaN is not within 0 to 1"),
        (
            "opacity = [[0, 1]]\ncolor = [[0, \"red\"]]",
            "line 2: color, point 1: 'red' is no colour \"#rrggbb\"",
        ),
        ("opacity = [[0, 1]]\ncolor = [[0, 1]]", "line 2: color, point 1: a colour \"#rrggbb\" was expected"),
        ("opacity = [[0, \"1\"]]", "line 1: opacity, point 1: a number was expected"),
        ("opacity = [[0, 1, 2]]", "line 1: opacity: a point is a list of two, [x, y]"),
        ("opacity = 3", "line 1: opacity: takes a list of points [x, y]"),
        ("\n\nopazity = []", "line 3: 'opazity' is none of name, opacity, color, gradient"),
        ("name = 1", "line 1: name: takes a string"),
        ("name = \"x\"", "line 1: opacity: has no points"),
    ] {
        assert_eq!(refused(text.as_bytes(), None), format!("a: {reason}"));
    }
    assert!(refused(b"opacity = [[0, 1]\n", None).starts_with("a: line "));
    assert_eq!(refused(b"opacity = [\n\xff", None), "a: line 2: is not UTF-8");
    refused("[".repeat(100_000).as_bytes(), None);
    refused(format!("opacity = {}", "[".repeat(100_000)).as_bytes(), None);
    assert_eq!(refused(&vec![b'#'; 17 << 20], None), "a: is over 16 MiB: no transfer function");
    assert_eq!(refused(b"name = \"x\"\nopacity = [[0, 1]]", Some("y")), "a: has no preset 'y'; there are x");
    let missing = read_transfer(Path::new("nowhere.toml"), None).unwrap_err();
    assert_eq!(missing.to_string(), "nowhere.toml: no such file");
}

const PRESETS: &str = "<?xml version=\"1.0\"?>\n<!-- presets -->\n<MRML version=\"Slicer4\" userTags=\"\">\n\
    <VolumeProperty id=\"p1\" name=\"CT-Bone\" references=\"\" interpolation=\"1\" shade=\"1\"\n\
      gradientOpacity=\"4 0 1 255 1\"\n\
      scalarOpacity=\"8 -3024 0 641.38 0.72 -16.4 0 3071 0.71\"\n\
      colorTransfer=\"8 -3024 0 0 0 3071 1 0.5 0.25\" selected=\"false\" />\n\
    <VolumeProperty name=\"MR &amp; more\" scalarOpacity=\"4 0 0 10 1\" />\n\
    <VolumeProperty name=\"bad\" scalarOpacity=\"4 0 0 10\" />\n\
    <VolumeProperty name=\"high\" scalarOpacity=\"4 0 0 10 3\" />\n</MRML>\n";

#[test]
fn presets_in_xml_are_chosen_by_name() {
    let named = |preset| transfer_from_bytes(Path::new("a"), PRESETS.as_bytes(), Some(preset)).unwrap();
    let bone = named("ct-bone");
    assert_eq!(bone.name, "CT-Bone");
    assert_eq!(bone.function.opacity, [(-3024.0, 0.0), (-16.4, 0.0), (641.38, 0.72), (3071.0, 0.71)]);
    assert_eq!(bone.function.gradient, [(0.0, 1.0), (255.0, 1.0)]);
    assert_eq!(bone.function.color, [(-3024.0, [0.0; 3]), (3071.0, [1.0, 0.5, 0.25])]);
    assert_eq!(bone.function.surfaces().len(), 1);
    assert_eq!(named("MR & more").function.color, []);
    let names = transfer_names(Path::new("a"), PRESETS.as_bytes()).unwrap();
    assert_eq!(names, ["CT-Bone", "MR & more", "bad", "high"]);

    let list = "CT-Bone, MR & more, bad, high";
    assert_eq!(
        refused(PRESETS.as_bytes(), None),
        format!("a: has 4 presets, of which one must be named: {list}")
    );
    assert_eq!(refused(PRESETS.as_bytes(), Some("x")), format!("a: has no preset 'x'; there are {list}"));
    assert_eq!(
        refused(PRESETS.as_bytes(), Some("bad")),
        "a: line 9: opacity: 4 numbers are announced, and there are 3"
    );
    assert_eq!(
        refused(PRESETS.as_bytes(), Some("high")),
        "a: line 10: opacity, point 2: 3 is not within 0 to 1"
    );
    // One alone needs no name.
    assert_eq!(read("<VolumeProperty scalarOpacity='2 5 1'/>").function.opacity, [(5.0, 1.0)]);
}

#[test]
fn hostile_xml_is_refused() {
    let laughs =
        "<!DOCTYPE l [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;&a;&a;\">]>\n<VolumeProperty name=\"&b;\"/>";
    assert!(refused(laughs.as_bytes(), None).starts_with("a: line 1: XML: "));
    assert!(refused(b"<MRML><VolumeProperty scalarOpacity='2 5 1'/>", None).contains("XML: "));
    assert_eq!(refused(b"<MRML/>", None), "a: is XML without a transfer function (VolumeProperty)");
    let many = format!("<MRML>{}</MRML>", "<VolumeProperty/>".repeat(300_000));
    assert!(refused(many.as_bytes(), None).contains("XML: "));
    let some = format!("<MRML>{}</MRML>", "<VolumeProperty name='n'/>".repeat(500));
    assert!(refused(some.as_bytes(), None).ends_with("n, n and 460 more"));
    for text in ["2", "3 0 1 2", "99999999999999999999 1", "-2 0 1", "2 0 x", "2 0 1 7", "200000000 0 1"] {
        let xml = format!("<VolumeProperty scalarOpacity=\"{text}\"/>");
        assert!(refused(xml.as_bytes(), None).starts_with("a: line 1: opacity: "), "{text}");
    }
    assert_eq!(refused(b"<VolumeProperty/>", None), "a: line 1: opacity: has no points");
    // Deeper than any scene is.
    refused("<a>".repeat(100_000).as_bytes(), None);
}

#[test]
fn vp_files_of_slicer() {
    let vp = "1\n1\n0.9\n0.1\n0.2\n10\n6 -1024 0 112.5 0 3071 0.5\n4 0 1 255 1\n8 -1024 0 0 0 3071 1 1 1\n";
    let file = read(vp);
    assert_eq!(file.function.opacity, [(-1024.0, 0.0), (112.5, 0.0), (3071.0, 0.5)]);
    assert_eq!((file.function.gradient.len(), file.function.color.len()), (2, 2));
    assert_eq!(
        refused(vp.replace("4 0 1 255 1", "4 0 1 255").as_bytes(), None),
        "a: line 8: gradient: 4 numbers are announced, and there are 3"
    );
    assert_eq!(refused(b"1\n1\n", None), "a: line 7: opacity: has no points");
}
