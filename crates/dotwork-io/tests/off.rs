//! OFF and its variants.
#![cfg(feature = "off")]

mod common;

use common::*;
use dotwork_io::mesh_format_name;
use dotwork_mesh::RawMesh;
use std::path::Path;

fn triangle(colors: &[[u8; 4]]) -> RawMesh {
    RawMesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        polygons: 1,
        colors: colors.to_vec(),
        ..RawMesh::default()
    }
}

#[test]
fn the_pyramid_in_many_dresses() {
    let plain = String::from_utf8(off()).unwrap();
    for (what, text) in [
        ("plain", plain.clone()),
        ("CRLF", plain.replace('\n', "\r\n")),
        ("lone CR", plain.replace('\n', "\r")),
        ("tabs and leading spaces", plain.replace(' ', "\t").replace('\n', "\n \t ")),
        ("blank lines", plain.replace('\n', "\n\n")),
        ("comments", plain.replace('\n', " # said\n# more\n").replacen("OFF", "# first\nOFF", 1)),
        ("counts beside the keyword", plain.replacen("OFF\n", "OFF ", 1)),
        ("no edges", plain.replacen("5 5 8", "5 5", 1)),
        ("lower case", plain.replacen("OFF", "off", 1)),
        ("face colours", plain.replace("0 1 4\n", "0 1 4 0.5 0.25 1 1\n")),
        ("byte order mark", format!("\u{feff}{plain}")),
    ] {
        assert_eq!(read("x", text.as_bytes()).unwrap(), pyramid(), "{what}");
        assert_eq!(read("x.off.gz", &gzip(text.as_bytes())).unwrap(), pyramid(), "{what}");
        assert_eq!(mesh_format_name(Path::new("x"), text.as_bytes()).as_deref(), Some("OFF"), "{what}");
    }
    assert_eq!(read("x.off", plain.replacen("OFF\n", "", 1).as_bytes()).unwrap(), pyramid(), "no keyword");
}

#[test]
fn colours_of_vertices_are_kept() {
    let of = |keyword: &str, tails: [&str; 3]| {
        let [a, b, c] = tails;
        let text = format!("{keyword}\n3 1 0\n0 0 0{a}\n1 0 0{b}\n0 1 0{c}\n3 0 1 2\n");
        assert_eq!(mesh_format_name(Path::new("x"), text.as_bytes()).as_deref(), Some(keyword));
        read("x", text.as_bytes()).unwrap()
    };
    let [red, grey, white] = [[255, 0, 0, 255], [51, 51, 51, 255], [255, 255, 255, 255]];
    let clear = [51, 51, 51, 0];
    for (keyword, tails, colors) in [
        ("COFF", [" 1 0 0", " .2 .2 .2", " 1.0 1 1"], vec![red, grey, white]),
        ("COFF", [" 1 0 0 1", " .2 .2 .2 0", " 1 1 1 1 "], vec![red, clear, white]),
        ("COFF", [" 255 0 0 255", " 51 51 51 0", " 255 255 255 255"], vec![red, clear, white]),
        ("COFF", [" 255 0 0", " 51 51 51 # grey", ""], vec![red, grey, white]),
        ("CNOFF", [" 0 0 1 255 0 0", " 0 0 1 51 51 51", " 0 0 1 255 255 255"], vec![red, grey, white]),
        (
            "STCNOFF",
            [" 9 9 9 1 0 0 1 8 8", " 9 9 9 .2 .2 .2 1 8 8", " 9 9 9 1 1 1 1 8 8"],
            vec![red, grey, white],
        ),
        ("STCOFF", [" 255 0 0 8 8", " 51 51 51 8 8", " 255 255 255 8 8"], vec![red, grey, white]),
        ("NOFF", [" 0 0 1", " 0 0 1", " 0 0 1"], vec![]),
        ("STOFF", [" 0 0", " 0 1", " 1 0"], vec![]),
        ("OFF", [" 255 0 0", " 51 51 51", " 255 255 255"], vec![]),
        ("COFF", ["", "", ""], vec![]),
    ] {
        assert_eq!(of(keyword, tails), triangle(&colors), "{keyword} {tails:?}");
    }
}

#[test]
fn refusals_name_the_line() {
    let body = "3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
    for (text, expected) in [
        ("OFF BINARY\n\0\0\0\x03".to_owned(), "line 1: the binary form of OFF is not read"),
        (format!("4OFF\n{body}"), "line 1: '4OFF': only OFF in three dimensions is read"),
        (format!("nOFF\n3\n{body}"), "line 1: 'nOFF': only OFF in three dimensions is read"),
        ("OFF\n".into(), "line 2: the file ends before the number of vertices"),
        ("OFF\n3\n".into(), "line 3: the file ends before the number of faces"),
        ("OFF\n-3 1 0\n".into(), "line 2: -3 is not a number of vertices"),
        ("OFF\n3 many 0\n".into(), "line 2: 'many' is not an integer"),
        ("OFF\n99999999999999999999 1 0\n".into(), "line 2: '99999999999999999999' is not an integer"),
        ("OFF\n353535235358 6 0\n".into(), "declares 353535235358 vertices; at most 4294967295 can be read"),
        ("OFF\n4000000000 1 0\n0 0 0\n".into(), "line 4: the file ends before vertex 2 of 4000000000"),
        (
            format!("OFF\n{}", body.replace("3 1 0", "3 900000000000 0")),
            "line 6: the file ends before face 1 of 900000000000",
        ),
        (format!("OFF\n{body}"), "line 6: the file ends before face 1 of 1"),
        (format!("OFF\n{body}3 0 1\n"), "line 6: face 1 of 1: expected 3 indices, found 2"),
        (format!("OFF\n{body}3 0 1 # 2\n"), "line 6: face 1 of 1: expected 3 indices, found 2"),
        (format!("OFF\n{body}3 0 1 3\n"), "line 6: face 1 of 1: index 3 is out of range (3 vertices)"),
        (format!("OFF\n{body}3 0 1 -1\n"), "line 6: face 1 of 1: index -1 is out of range (3 vertices)"),
        (format!("OFF\n{body}-3 0 1 2\n"), "line 6: face 1 of 1: -3 corners"),
        (format!("OFF\n{body}2 0 1\n"), "has no faces"),
        ("OFF\n3 1 0\n0 0\n".into(), "line 3: expected 3 coordinates, found 2"),
        ("OFF\n3 1 0\n0 0 nan\n".into(), "line 3: vertex 1: z is NaN"),
        // One vertex more than declared reads as a face without corners; one less takes the face for a vertex.
        (format!("OFF\n{}3 0 1 2\n", body.replacen('3', "2", 1)), "has no faces"),
        (format!("OFF\n{}3 0 1 2\n", body.replacen('3', "4", 1)), "line 7: the file ends before face 1 of 1"),
        ("OFF\n0 0 0\n".into(), "has no faces"),
    ] {
        assert_eq!(refusal("x.off", text.as_bytes()), format!("x.off: {expected}"));
    }
    let (_, warnings) = read_with_warnings("x.off", format!("OFF\n{body}3 0 1 2\n3 2 1 0\n").as_bytes());
    assert_eq!(warnings, ["text after the last face ignored, from line 7"]);
}
