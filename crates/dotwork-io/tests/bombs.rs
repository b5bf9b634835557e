//! Small glTF files that ask for much: refused, and before the memory is taken.
#![cfg(feature = "gltf")]

mod common;

use common::*;
use serde_json::{Value, json};

/// The most that a refusal may take, MiB: the process is to stay under 200.
const MOST: u64 = 180;

/// A line of what Linux tells of the memory of the process, MiB; 0 elsewhere.
fn memory(line: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix(line)).unwrap_or_default();
    line.trim().trim_end_matches("kB").trim().parse::<u64>().unwrap_or(0) / 1024
}

/// The refusal of a file, which must not take more than [`MOST`] on the way.
fn cheap_refusal(name: &str, bytes: &[u8], what: &str) -> String {
    // Making the file took some as well: its peak is forgotten, what was not given back is subtracted.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let before = memory("VmRSS:");
    let message = refusal(name, bytes);
    let taken = memory("VmHWM:").saturating_sub(before);
    assert!(taken < MOST, "{what}: {taken} MiB");
    message
}

/// A scene of one node and one mesh with these primitives. Accessor 0 is `vertices` positions of three bytes, accessor
/// 1 as many indices of one byte, all zero; accessor 2 is zeros that need no bytes.
fn scene(vertices: usize, primitives: Value) -> (Value, Vec<u8>) {
    let json = json!({
        "asset": { "version": "2.0" },
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": primitives }],
        "accessors": [
            { "bufferView": 0, "componentType": 5120, "count": vertices, "type": "VEC3" },
            { "bufferView": 0, "componentType": 5121, "count": vertices, "type": "SCALAR" },
            { "componentType": 5126, "count": 1 << 18, "type": "MAT4" },
        ],
        "bufferViews": [{ "buffer": 0, "byteLength": 3 * vertices }],
        "buffers": [{ "byteLength": 3 * vertices }],
    });
    (json, vec![0; 3 * vertices])
}

fn repeated(primitive: Value, count: usize) -> Value {
    vec![primitive; count].into()
}

/// One test, so that the peak is that of these files alone.
#[test]
fn bombs_are_refused_before_they_take_memory() {
    let mut bombs = Vec::new();
    let mut bomb = |what: &'static str, (json, buffer): &(Value, Vec<u8>)| {
        bombs.push((what, glb(json, buffer)));
    };
    // Found by hand: many primitives that all refer to the same big accessor.
    let triangles = scene(400_000, repeated(json!({ "attributes": { "POSITION": 0 } }), 1000));
    bomb("the same triangles", &triangles);
    let copies: Vec<Value> =
        (0..1000).map(|k| json!({ "attributes": { "POSITION": 0, "JOINTS_0": k } })).collect();
    bomb("the same vertices", &scene(400_000, copies.into()));
    let strip = json!({ "attributes": { "POSITION": 0 }, "indices": 1, "mode": 5 });
    bomb("strips of nothing", &scene(400_000, repeated(strip, 5000)));
    let mut instances = scene(3, repeated(json!({ "attributes": { "POSITION": 0 }, "mode": 0 }), 2000));
    instances.0["nodes"] = vec![json!({ "mesh": 0 }); 100_000].into();
    bomb("points in many places", &instances);
    let targets =
        json!([{ "attributes": { "POSITION": 0 }, "targets": vec![json!({ "POSITION": 0 }); 20_000] }]);
    let mut morphs = scene(50_000, targets);
    morphs.0["meshes"][0]["weights"] = vec![json!(1); 20_000].into();
    bomb("many morph targets", &morphs);
    let mut skins = scene(3, json!([{ "attributes": { "POSITION": 0 } }]));
    skins.0["nodes"] = (0..2000).map(|k| json!({ "mesh": 0, "skin": k })).collect();
    skins.0["skins"] = vec![json!({ "joints": [0], "inverseBindMatrices": 2 }); 2000].into();
    bomb("skins with too many matrices", &skins);
    skins.0["nodes"] = (0..3).map(|k| json!({ "mesh": 0, "skin": k })).collect();
    skins.0["skins"] = vec![json!({ "joints": vec![0; 300_000] }); 3].into();
    bomb("joints without end", &skins);

    for (what, bytes) in &bombs {
        let message = cheap_refusal("t", bytes, what);
        assert!(message.starts_with("t: what its scene draws expands to more than "), "{what}: {message}");
    }
    // What it is measured by is the file, not what it unpacks to.
    let (json, buffer) = scene(2_000_000, repeated(json!({ "attributes": { "POSITION": 0 } }), 1000));
    let packed = gzip(&glb(&json, &buffer));
    assert!(packed.len() < 100_000);
    let message = cheap_refusal("t", &packed, "gzipped");
    assert_eq!(message, "t: what its scene draws expands to more than 64 MiB");
    for list in ["scenes", "nodes", "extensionsUsed"] {
        let item = if list == "extensionsUsed" { "\"\"" } else { "{}" };
        let mut text = format!("{item},").repeat(12_000_000);
        text.insert_str(0, &format!("{{\"asset\":{{\"version\":\"2.0\"}},\"{list}\":["));
        text.push_str(&format!("{item}]}}"));
        let packed = gzip(text.as_bytes());
        drop(text);
        let message = cheap_refusal("t.gltf", &packed, list);
        assert_eq!(message, "t.gltf: line 1: JSON: a list of more than 524288 items");
    }
}
