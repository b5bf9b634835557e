//! Real scans. The readers live in another crate; what is needed of PLY and OBJ here is a few lines.

use std::path::Path;

use dotwork_drawing::Warnings;
use dotwork_mesh::{Mesh, MeshOptions, RawMesh, shapes};
use glam::Vec3;

fn data(name: &str) -> Vec<u8> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/meshes"));
    std::fs::read(folder.join(name)).expect("shared data")
}

/// A little-endian PLY with three floats a vertex and triangles counted by a byte.
fn ply(name: &str) -> RawMesh {
    let bytes = data(name);
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
    let header = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let count = |element: &str| -> usize {
        let line =
            header.lines().find_map(|l| l.strip_prefix(&format!("element {element} "))).expect("counted");
        line.parse().expect("a number")
    };
    let word = |at: usize| -> [u8; 4] { bytes[at..at + 4].try_into().expect("four bytes") };
    let (vertices, faces) = (count("vertex"), count("face"));
    let positions =
        (0..vertices).map(|v| [0, 4, 8].map(|o| f32::from_le_bytes(word(end + 12 * v + o)))).collect();
    let start = end + 12 * vertices;
    let triangles =
        (0..faces).map(|t| [1, 5, 9].map(|o| u32::from_le_bytes(word(start + 13 * t + o)))).collect();
    RawMesh { positions, triangles, polygons: faces, ..RawMesh::default() }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn the_bunny_is_turned_outwards_though_it_has_holes() {
    let mut warnings = Warnings::new();
    let mesh = Mesh::build(ply("bunny.ply"), &MeshOptions::default(), &mut warnings).expect("sound");
    let lines: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        lines,
        ["1113 unused vertices dropped, first at vertex 8", "winding turned: the surface faced inwards"]
    );
    let stats = mesh.stats();
    assert_eq!((stats.triangles, stats.boundary_edges, stats.closed), (69451, 223, false));
    assert!(stats.volume > 0.0);
    // The tips of the ears face up.
    let top =
        mesh.positions.iter().zip(&mesh.normals).max_by(|a, b| a.0.y.total_cmp(&b.0.y)).expect("vertices");
    assert!(top.1.y > 0.5);
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn the_teapot_has_the_proportions_of_the_one_in_the_library() {
    let text = String::from_utf8(data("teapot.obj")).expect("text");
    let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for line in text.lines().filter_map(|l| l.strip_prefix("v ")) {
        let mut c = line.split_whitespace().map(|c| c.parse::<f32>().expect("a number"));
        let p = Vec3::from_array([(); 3].map(|()| c.next().expect("three coordinates")));
        (min, max) = (min.min(p), max.max(p));
    }
    let ours =
        Mesh::build(shapes::teapot(), &MeshOptions::default(), &mut Warnings::new()).expect("sound").bounds();
    assert!((ours.min - min).abs().max_element() < 0.02, "{ours:?}, {min} {max}");
    assert!((ours.max - max).abs().max_element() < 0.02, "{ours:?}, {min} {max}");
}
