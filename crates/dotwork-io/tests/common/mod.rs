//! Small files of every kind for the tests.

#![allow(dead_code, reason = "each test file uses its share")]

use std::io::Write;
use std::path::{Path, PathBuf};

use dotwork_drawing::Warnings;
use dotwork_io::{ReadError, read_mesh_bytes};
use dotwork_mesh::RawMesh;

/// Reads `bytes` as a file of that name.
pub fn read(name: &str, bytes: &[u8]) -> Result<RawMesh, ReadError> {
    read_mesh_bytes(Path::new(name), bytes, &mut Warnings::new())
}

/// The mesh and the warnings as lines.
pub fn read_with_warnings(name: &str, bytes: &[u8]) -> (RawMesh, Vec<String>) {
    let mut warnings = Warnings::new();
    let mesh = read_mesh_bytes(Path::new(name), bytes, &mut warnings).unwrap();
    (mesh, warnings.iter().map(ToString::to_string).collect())
}

/// The message of the refusal.
pub fn refusal(name: &str, bytes: &[u8]) -> String {
    let message = read(name, bytes).expect_err("should be refused").to_string();
    assert!(!message.contains('\n'), "{message:?}");
    message
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// A square pyramid: five vertices, four triangles and a quad.
pub const POSITIONS: [[f32; 3]; 5] =
    [[-1.0, -1.0, 0.25], [1.0, -1.0, 0.25], [1.0, 1.0, 0.25], [-1.0, 1.0, 0.25], [0.125, 0.1, 1.7]];
pub const FACES: [&[u32]; 5] = [&[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4], &[3, 2, 1, 0]];
pub const TRIANGLES: [[u32; 3]; 6] = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [3, 2, 1], [3, 1, 0]];

pub fn pyramid() -> RawMesh {
    RawMesh {
        positions: POSITIONS.to_vec(),
        triangles: TRIANGLES.to_vec(),
        polygons: 5,
        ..RawMesh::default()
    }
}

/// The pyramid as ascii PLY, with a vertex property and an element that nobody asked for.
pub fn ply_ascii() -> Vec<u8> {
    let mut s = String::from(
        "ply\nformat ascii 1.0\ncomment a pyramid\nobj_info none\nelement vertex 5\nproperty float x\n\
         property float y\nproperty float z\nproperty uchar red\nelement edge 1\nproperty int vertex1\n\
         property list uchar float weights\nelement face 5\nproperty list uchar int vertex_indices\nend_header\n",
    );
    for p in POSITIONS {
        s += &format!("{} {} {} 255\n", p[0], p[1], p[2]);
    }
    s += "7 2 0.5 0.25\n";
    for face in FACES {
        s += &face.len().to_string();
        face.iter().for_each(|i| s += &format!(" {i}"));
        s += "\n";
    }
    s.into_bytes()
}

/// The pyramid as binary PLY; extra properties before and after, and an element with a list between.
pub fn ply_binary(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut b = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 5\nproperty uchar red\nproperty float x\n\
         property float y\nproperty float z\nelement edge 2\nproperty short a\nproperty list uchar double weights\n\
         element face 5\nproperty short flags\nproperty list uchar int vertex_indices\nproperty uchar red\nend_header\n"
    )
    .into_bytes();
    let mut put = |bytes: &[u8]| match big {
        true => b.extend(bytes.iter().rev()),
        false => b.extend(bytes),
    };
    for p in POSITIONS {
        put(&[200]);
        p.iter().for_each(|v| put(&v.to_le_bytes()));
    }
    for n in 0..2u8 {
        put(&(-5i16).to_le_bytes());
        put(&[n]);
        (0..n).for_each(|_| put(&0.5f64.to_le_bytes()));
    }
    for face in FACES {
        put(&(-1i16).to_le_bytes());
        put(&[face.len() as u8]);
        face.iter().for_each(|i| put(&i.to_le_bytes()));
        put(&[9]);
    }
    b
}

/// The pyramid as OBJ with all that readers must step over.
pub fn obj() -> Vec<u8> {
    b"# a pyramid\nmtllib C:\\models\\\ng base\nv -1 -1 .25 0.5 0.5 0.5\nv 1 -1.0 2.5e-1\nv +1 1 0.25 1.0\r\n\
      v \\\n -1 1 \\\r\n 0.25\nvt 0 0\nvn 0 0 1\n\nv 0.125 0.1 1.7\nusemtl red\ns off\no top\n\
      f 1/1/1 2/1/1 5/1/1\nf 2/1 3/1 5/1\nf 3//1 \\\n 4//1 5//1 # tail\nf -2 -5 -1\n\tf 4 3 2 1"
        .to_vec()
}

/// All the samples with a name that fits.
pub fn samples() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("ascii.ply", ply_ascii()),
        ("little.ply", ply_binary(false)),
        ("big.ply", ply_binary(true)),
        ("pyramid.obj", obj()),
    ]
}

/// The shared test data beside the repository.
pub fn shared_data() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"))
}
