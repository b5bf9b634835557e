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
    b"# a pyramid\nmtllib C:\\models\\\ng base\nv -1 -1 .25 1.0\nv 1 -1.0 2.5e-1\nv +1 1 0.25 1.0\r\n\
      v \\\n -1 1 \\\r\n 0.25\nvt 0 0\nvn 0 0 1\n\nv 0.125 0.1 1.7\nusemtl red\ns off\no top\n\
      f 1/1/1 2/1/1 5/1/1\nf 2/1 3/1 5/1\nf 3//1 \\\n 4//1 5//1 # tail\nf -2 -5 -1\n\tf 4 3 2 1"
        .to_vec()
}

/// The pyramid as text STL, in two-space steps.
pub fn stl_text() -> Vec<u8> {
    let mut s = String::from("solid a pyramid\n");
    for t in TRIANGLES {
        s += "  facet normal 0 0 1\n    outer loop\n";
        for v in t {
            let [x, y, z] = POSITIONS[v as usize];
            s += &format!("      vertex {x} {y:e} {z}\n");
        }
        s += "    endloop\n  endfacet\n";
    }
    (s + "endsolid a pyramid\n").into_bytes()
}

/// The pyramid as binary STL, with attributes.
pub fn stl_binary() -> Vec<u8> {
    let mut b = vec![0; 80];
    b.extend((TRIANGLES.len() as u32).to_le_bytes());
    for t in TRIANGLES {
        b.extend([0; 12]);
        for v in t {
            POSITIONS[v as usize].iter().for_each(|c| b.extend(c.to_le_bytes()));
        }
        b.extend([0x12, 0x80]);
    }
    b
}

/// The pyramid as OFF.
pub fn off() -> Vec<u8> {
    let mut s = String::from("OFF\n5 5 8\n");
    POSITIONS.iter().for_each(|[x, y, z]| s += &format!("{x} {y} {z}\n"));
    for face in FACES {
        s += &face.len().to_string();
        face.iter().for_each(|i| s += &format!(" {i}"));
        s += "\n";
    }
    s.into_bytes()
}

/// The pyramid as COFF.
pub fn coff() -> Vec<u8> {
    let text = String::from_utf8(off()).unwrap();
    let colored = |(n, line): (usize, &str)| match n {
        0 => "COFF\n".to_owned(),
        2..7 => format!("{line} {} 128 7 255\n", 40 * n),
        _ => format!("{line}\n"),
    };
    text.lines().enumerate().map(colored).collect::<String>().into_bytes()
}

/// The pyramid as a binary PLY of triangle strips with colours; its base is two strips of one triangle.
pub fn ply_strips() -> Vec<u8> {
    let mut b = b"ply\nformat binary_little_endian 1.0\nelement vertex 5\nproperty float x\nproperty float y\n\
        property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement tristrips 1\n\
        property list int int vertex_indices\nend_header\n"
        .to_vec();
    for (v, p) in POSITIONS.iter().enumerate() {
        p.iter().for_each(|c| b.extend(c.to_le_bytes()));
        b.extend([v as u8, 10, 20]);
    }
    let strip: [i32; 20] = [0, 1, 4, -1, 1, 2, 4, -1, 2, 3, 4, -1, 3, 0, 4, -1, 3, 2, 0, 1];
    b.extend((strip.len() as i32).to_le_bytes());
    strip.iter().for_each(|i| b.extend(i.to_le_bytes()));
    b
}

/// The pyramid as OBJ with the colours of its vertices.
pub fn obj_colored() -> Vec<u8> {
    let mut s = String::new();
    for (v, [x, y, z]) in POSITIONS.iter().enumerate() {
        s += &format!("v {x} {y} {z} 0.{v} 0.5 1\n");
    }
    for face in FACES {
        s += "f";
        face.iter().for_each(|i| s += &format!(" {}", i + 1));
        s += "\n";
    }
    s.into_bytes()
}

/// A GLB file of that JSON and buffer.
pub fn glb(json: &serde_json::Value, binary: &[u8]) -> Vec<u8> {
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut b = b"glTF\x02\0\0\0".to_vec();
    let chunk =
        |kind: &[u8; 4], content: &[u8]| [&(content.len() as u32).to_le_bytes(), &kind[..], content].concat();
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &binary)].concat();
    b.extend((12 + chunks.len() as u32).to_le_bytes());
    b.extend(chunks);
    b
}

/// The same as text, the buffer embedded.
pub fn gltf(json: &serde_json::Value, binary: &[u8]) -> Vec<u8> {
    let mut json = json.clone();
    json["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{}", base64(binary)).into();
    serde_json::to_string_pretty(&json).unwrap().into_bytes()
}

fn base64(bytes: &[u8]) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().fold(0u32, |bits, &b| bits << 8 | u32::from(b)) << (8 * (3 - group.len()));
        for k in 0..4 {
            let digit = (bits >> (18 - 6 * k)) as usize & 63;
            text.push(if k <= group.len() { ALPHABET[digit].into() } else { '=' });
        }
    }
    text
}

/// The pyramid as glTF: JSON and buffer. Two primitives share the vertices: the sides as indexed triangles, the base
/// as a strip; a node halves it, one below it doubles it; colours, a morph target of weight zero, and a sparse one.
pub fn gltf_parts() -> (serde_json::Value, Vec<u8>) {
    let mut b: Vec<u8> = POSITIONS.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    (0..5u16).for_each(|v| [v * 1000, 65535, 0, 32768].iter().for_each(|c| b.extend(c.to_le_bytes())));
    TRIANGLES[..4].iter().flatten().for_each(|i| b.extend((*i as u16).to_le_bytes()));
    b.extend([3, 2, 0, 1]);
    b.extend([1, 4, 0, 0]);
    [0.5f32; 6].iter().for_each(|c| b.extend(c.to_le_bytes()));
    let json = serde_json::json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "children": [1], "scale": [0.5, 0.5, 0.5] }, { "mesh": 0, "matrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1] }],
        "meshes": [{ "weights": [0, 0], "primitives": [
            { "attributes": { "POSITION": 0, "COLOR_0": 1 }, "indices": 2, "targets": [{ "POSITION": 0 }, { "POSITION": 4 }] },
            { "attributes": { "POSITION": 0, "COLOR_0": 1 }, "indices": 3, "mode": 5, "targets": [{ "POSITION": 0 }, { "POSITION": 4 }] },
        ] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "normalized": true, "count": 5, "type": "VEC4" },
            { "bufferView": 2, "componentType": 5123, "count": 12, "type": "SCALAR" },
            { "bufferView": 3, "componentType": 5121, "count": 4, "type": "SCALAR" },
            { "componentType": 5126, "count": 5, "type": "VEC3", "sparse": { "count": 2,
                "indices": { "bufferView": 4, "componentType": 5121 }, "values": { "bufferView": 5 } } },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 60, "byteStride": 12 },
            { "buffer": 0, "byteOffset": 60, "byteLength": 40, "byteStride": 8 },
            { "buffer": 0, "byteOffset": 100, "byteLength": 24 },
            { "buffer": 0, "byteOffset": 124, "byteLength": 4 },
            { "buffer": 0, "byteOffset": 128, "byteLength": 2 },
            { "buffer": 0, "byteOffset": 132, "byteLength": 24 },
        ],
        "buffers": [{ "byteLength": b.len() }],
    });
    (json, b)
}

/// Samples of all the formats and of their rarer sides, for mutation.
pub fn all_samples() -> Vec<(&'static str, Vec<u8>)> {
    let (json, buffer) = gltf_parts();
    let mut samples = samples();
    samples.extend([
        ("strips.ply", ply_strips()),
        ("colored.obj", obj_colored()),
        ("text.stl", stl_text()),
        ("binary.stl", stl_binary()),
        ("plain.off", off()),
        ("colored.off", coff()),
        ("text.gltf", gltf(&json, &buffer)),
        ("binary.glb", glb(&json, &buffer)),
    ]);
    samples
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
