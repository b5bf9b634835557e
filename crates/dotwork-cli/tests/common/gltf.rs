//! glTF files that move, made by the tests.

use dotwork::RawMesh;

/// Bytes as base64.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |bits: u32| char::from(DIGITS[bits as usize & 63]);
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let bits = group.iter().fold(0u32, |bits, &b| bits << 8 | u32::from(b)) << (8 * (3 - group.len()));
        let all = [bits >> 18, bits >> 12, bits >> 6, bits].map(digit);
        text.extend(&all[..group.len() + 1]);
        text.extend(std::iter::repeat_n('=', 3 - group.len()));
    }
    text
}

/// A glTF file in which `mesh` becomes `moved` within `seconds`, evenly, by the animation "move".
pub fn morphing_text(mesh: &RawMesh, moved: impl Fn([f32; 3]) -> [f32; 3], seconds: f32) -> String {
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let places = floats(mesh.positions.as_flattened());
    let moves: Vec<f32> = mesh
        .positions
        .iter()
        .flat_map(|&p| {
            let to = moved(p);
            [0, 1, 2].map(|k| to[k] - p[k])
        })
        .collect();
    let moves = floats(&moves);
    let corners: Vec<u8> = mesh.triangles.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let times = floats(&[0.0, seconds]);
    let weights = floats(&[0.0, 1.0]);
    let parts = [&places, &moves, &corners, &times, &weights];
    let mut views = Vec::new();
    let mut bytes = Vec::new();
    for part in parts {
        views.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, bytes.len(), part.len()));
        bytes.extend(part);
    }
    let (vertices, indices) = (mesh.positions.len(), 3 * mesh.triangles.len());
    let accessor = |view: usize, kind: u32, count: usize, shape: &str| {
        format!(r#"{{"bufferView":{view},"componentType":{kind},"count":{count},"type":"{shape}"}}"#)
    };
    let accessors = [
        accessor(0, 5126, vertices, "VEC3"),
        accessor(1, 5126, vertices, "VEC3"),
        accessor(2, 5125, indices, "SCALAR"),
        accessor(3, 5126, 2, "SCALAR"),
        accessor(4, 5126, 2, "SCALAR"),
    ];
    format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":2,"targets":[{{"POSITION":1}}]}}]}}],
        "animations":[{{"name":"move","samplers":[{{"input":3,"output":4}}],
        "channels":[{{"sampler":0,"target":{{"node":0,"path":"weights"}}}}]}}],
        "accessors":[{}],"bufferViews":[{}],
        "buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}]}}"#,
        accessors.join(","),
        views.join(","),
        bytes.len(),
        base64(&bytes)
    )
}
