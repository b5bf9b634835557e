//! STL, text and binary, as real programs write it.
#![cfg(feature = "stl")]

mod common;

use common::*;
use dotwork_io::mesh_format_name;
use dotwork_mesh::{Mesh, MeshOptions};
use std::path::Path;

#[test]
fn both_forms_weld_to_the_pyramid() {
    for (name, bytes) in [("text.stl", stl_text()), ("binary.stl", stl_binary())] {
        for name in [name, "no_suffix", "lying.obj"] {
            for packed in [bytes.clone(), gzip(&bytes)] {
                let (mesh, warnings) = read_with_warnings(name, &packed);
                assert_eq!(warnings, [""; 0], "{name}");
                assert_eq!((mesh.positions.len(), mesh.triangles.len(), mesh.polygons), (18, 6, 6));
                let built = Mesh::build(mesh, &MeshOptions::default(), &mut Default::default()).unwrap();
                assert!(built.closed && built.positions.len() == 5, "{name}");
                let mut positions: Vec<[f32; 3]> = built.positions.iter().map(|p| p.to_array()).collect();
                let mut expected = POSITIONS.to_vec();
                positions.sort_by(|a, b| a.partial_cmp(b).unwrap());
                expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
                assert_eq!(positions, expected, "{name}");
            }
        }
    }
}

#[test]
fn solid_begins_binary_files_too() {
    let mut bytes = stl_binary();
    bytes[..20].copy_from_slice(b"solid exported by CA");
    assert_eq!(read("x", &bytes).unwrap().triangles.len(), 6);
    assert_eq!(mesh_format_name(Path::new("x"), &bytes).as_deref(), Some("STL, binary"));
    // Blanks instead of zeros in the header, as some programs have it: the count explains the length.
    bytes[..80].fill(b' ');
    bytes[..5].copy_from_slice(b"solid");
    assert_eq!(read("x", &bytes).unwrap().triangles.len(), 6);
    let text = stl_text();
    assert_eq!(mesh_format_name(Path::new("x"), &text).as_deref(), Some("STL, text"));
    assert_eq!(mesh_format_name(Path::new("x"), &gzip(&text)).as_deref(), Some("STL, text, gzipped"));
}

#[test]
fn large_binary_files_may_be_gzipped_without_a_name() {
    // Longer than what is looked at before the rest is unpacked.
    let one = &stl_binary()[84..134];
    let n = 2000u32;
    let mut bytes = vec![7; 80];
    bytes.extend(n.to_le_bytes());
    (0..n).for_each(|_| bytes.extend(one));
    assert_eq!(read("x", &gzip(&bytes)).unwrap().triangles.len(), 2000);
}

#[test]
fn text_in_the_styles_of_exporters() {
    let plain = String::from_utf8(stl_text()).unwrap();
    let expected = read("x.stl", plain.as_bytes()).unwrap();
    for (what, text) in [
        ("upper case", plain.to_uppercase()),
        ("CRLF", plain.replace('\n', "\r\n")),
        ("lone CR", plain.replace('\n', "\r")),
        ("tabs", plain.replace("  ", "\t")),
        ("leading space", format!("\n  {plain}")),
        ("byte order mark", format!("\u{feff}{plain}")),
        ("no name", plain.replacen("solid a pyramid", "solid", 1)),
        ("all in one line", plain.replacen('\n', "@", 1).replace('\n', " ").replace('@', "\n")),
        ("odd normals", plain.replace("normal 0 0 1", "normal nan -nan(ind) 1.#QNAN")),
        ("no end", plain[..plain.rfind("endsolid").unwrap()].to_owned()),
    ] {
        assert_eq!(read("x.stl", text.as_bytes()).unwrap(), expected, "{what}");
    }
    let twice = format!("{plain}{}", plain.replace("pyramid", "second one\\"));
    assert_eq!(read("x.stl", twice.as_bytes()).unwrap().triangles.len(), 12);
    let quad = "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let (mesh, warnings) = read_with_warnings("x.stl", format!("{quad}color 1 0 0\n").as_bytes());
    assert_eq!((mesh.triangles.as_slice(), mesh.polygons), (&[[0, 1, 2], [0, 2, 3]][..], 1));
    assert_eq!(warnings, ["the file ends without endsolid", "unknown statements ignored (line 10)"]);
}

#[test]
fn refusals_name_the_place() {
    let text = |body: &str| format!("solid\n facet normal 0 0 1\n  outer loop\n{body}").into_bytes();
    let binary = stl_binary();
    let mut nan = binary.clone();
    nan[84 + 50 + 12 + 12 + 4..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let mut huge = binary.clone();
    huge[80..84].copy_from_slice(&4_000_000_000u32.to_le_bytes());
    for (bytes, expected) in [
        (binary[..200].to_vec(), "byte 200: the file ends in the middle of triangle 3 of 6"),
        (binary[..184].to_vec(), "byte 184: the file ends before triangle 3 of 6"),
        (huge, "byte 384: the file ends before triangle 7 of 4000000000"),
        (nan, "byte 158: triangle 2: y is NaN"),
        (text("vertex 0 0\n"), "line 4: expected 3 coordinates, found 2"),
        (text("vertex 0 0 zero\n"), "line 4: 'zero' is not a number"),
        (text("vertex 0 0 1e999\n"), "line 4: facet 1: z is inf"),
        (text("vertex 0 0 0\n"), "line 5: the file ends in the middle of facet 1"),
        (b"solid\nvertex 0 0 0\n".to_vec(), "line 2: a vertex outside of a facet"),
        (text("endloop\nendfacet\nendsolid\n"), "has no faces"),
        (text(&"vertex 0 0 0\n".repeat(100)), "line 104: the file ends in the middle of facet 1"),
        (text(&format!("{}endfacet", "vertex 0 0 0\n".repeat(100))), "line 104: facet 1 has 100 vertices"),
        (b"solid Empty\nendsolid Empty".to_vec(), "has no faces"),
        (vec![0; 84], "has no faces"),
    ] {
        assert_eq!(refusal("x.stl", &bytes), format!("x.stl: {expected}"));
    }
    let mut longer = binary;
    longer.extend([1; 9]);
    let (mesh, warnings) = read_with_warnings("x.stl", &longer);
    assert_eq!((mesh.triangles.len(), warnings), (6, vec!["9 bytes after the last triangle ignored".into()]));
}

#[test]
fn far_coordinates_keep_their_detail() {
    let text = "solid\nfacet normal 0 0 0\nouter loop\nvertex 4321034.515625 512011.25 10\n\
        vertex 4321035.515625 512011.25 10\nvertex 4321034.515625 512012.3125 10.5\nendloop\nendfacet\nendsolid\n";
    let mesh = read("far.stl", text.as_bytes()).unwrap();
    assert_eq!(mesh.origin, [4_321_035.0, 512_012.0, 10.0]);
    assert_eq!(mesh.positions[2], [-0.484_375, 0.3125, 0.5]);
}
