//! glTF and GLB: the scene at rest as one mesh.
#![cfg(feature = "gltf")]

mod common;

use common::*;
use dotwork_drawing::Warnings;
use dotwork_drawing::color::linear_to_srgb;
use dotwork_io::{checksum, mesh_facts, mesh_format_name, read_mesh, read_mesh_checked};
use dotwork_mesh::{Mesh, MeshOptions, RawMesh};
use serde_json::{Value, json};
use std::path::Path;

/// Numbers one after the other.
fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// One triangle in a mesh at node 0, nothing else.
fn triangle() -> (Value, Vec<u8>) {
    let json = json!({
        "asset": { "version": "2.0" },
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36 }],
    });
    (json, floats(&TRIANGLE))
}

/// Adds an accessor of its own view for `bytes`; its number.
fn add(
    json: &mut Value,
    buffer: &mut Vec<u8>,
    bytes: &[u8],
    component: u32,
    shape: &str,
    count: usize,
) -> usize {
    let view = json["bufferViews"].as_array().unwrap().len();
    json["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "buffer": 0, "byteOffset": buffer.len(), "byteLength": bytes.len() }));
    buffer.extend(bytes);
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    json["buffers"][0]["byteLength"] = buffer.len().into();
    let accessors = json["accessors"].as_array_mut().unwrap();
    accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": shape }));
    accessors.len() - 1
}

/// The positions of the triangle, which must be one, in the scene.
fn placed(json: &Value, buffer: &[u8]) -> RawMesh {
    let (mesh, warnings) = read_with_warnings("t.glb", &glb(json, buffer));
    assert_eq!(warnings, [""; 0]);
    assert_eq!(read("t.gltf", &gltf(json, buffer)).unwrap(), mesh, "the text form gives the same");
    mesh
}

fn close(found: &[[f32; 3]], expected: &[[f32; 3]]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((f - e).abs() < 1e-5, "{found:?} is not {expected:?}");
    }
}

#[test]
fn the_pyramid_in_both_forms() {
    let (json, buffer) = gltf_parts();
    let colors = (0..5).map(|v| [linear_to_srgb((v * 1000) as f32 / 65535.0), 255, 0, 128]).collect();
    let mut triangles = TRIANGLES.to_vec();
    triangles.splice(4.., [[3, 2, 0], [0, 2, 1]]);
    let expected = RawMesh { polygons: 6, triangles, colors, ..pyramid() };
    let (text, binary) = (gltf(&json, &buffer), glb(&json, &buffer));
    for (bytes, format) in [(&text, "glTF"), (&binary, "glTF binary (GLB)")] {
        for name in ["x.glb", "x.gltf", "x", "x.obj"] {
            assert_eq!(read_with_warnings(name, bytes), (expected.clone(), vec![]), "{format} as {name}");
            assert_eq!(read(name, &gzip(bytes)).unwrap(), expected);
        }
        assert_eq!(mesh_format_name(Path::new("x"), bytes).as_deref(), Some(format));
    }
    let spaced = [b"\xef\xbb\xbf\r\n ", &text[..]].concat();
    assert_eq!(read("x.gltf", &spaced).unwrap(), expected);
}

#[test]
fn buffers_beside_the_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("models")).unwrap();
    let (mut json, buffer) = triangle();
    let expected = placed(&json, &buffer);
    // A longer file than declared is fine.
    std::fs::write(folder.path().join("a bin.dat"), [&buffer[..], b"more"].concat()).unwrap();
    std::fs::write(folder.path().join("models/short.bin"), b"short").unwrap();
    let path = folder.path().join("models/t.gltf");
    let mut with = |uri: &str| {
        json["buffers"][0]["uri"] = uri.into();
        std::fs::write(&path, json.to_string()).unwrap();
        read_mesh(&path, &mut Warnings::new()).map_err(|e| e.to_string())
    };
    assert_eq!(with("../a%20bin.dat"), Ok(expected.clone()));
    assert_eq!(with("../a bin.dat"), Ok(expected));
    for (uri, reason) in [
        ("missing.bin", "'missing.bin': no such file"),
        ("short.bin", "'short.bin': 36 bytes declared, but the file has 5"),
        ("..", "'..': is not a regular file"),
        (
            "https://x.org/a.bin",
            "'https://x.org/a.bin' is not relative to the file; other places are not read",
        ),
        ("file:///etc/passwd", "'file:///etc/passwd' is not relative to the file; other places are not read"),
        ("/etc/passwd", "'/etc/passwd' is an absolute path; only files relative to this one are read"),
        ("%2fetc/passwd", "'%2fetc/passwd' is an absolute path; only files relative to this one are read"),
        ("a%2", "'a%2' has a broken percent escape"),
        ("data:;base64,AAA", "declares 36 bytes, but 2 are there"),
        ("data:;base64,A*A=", "its data URI is not base64"),
        ("data:nothing", "its data URI has no comma"),
    ] {
        assert_eq!(with(uri), Err(format!("{}: buffer 0: {reason}", path.display())), "{uri}");
    }
    // A buffer that nothing drawn needs may be missing.
    let (mut json, buffer) = triangle();
    json["buffers"].as_array_mut().unwrap().push(json!({ "uri": "texture.bin", "byteLength": 1u64 << 40 }));
    assert!(read("t.glb", &glb(&json, &buffer)).is_ok());
}

#[test]
fn transforms_nest_and_mirrors_turn_triangles() {
    let (mut json, buffer) = triangle();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // A quarter turn about z, then twice as large in x and a step along y; the quaternion is not of unit length.
    json["nodes"] = json!([
        { "mesh": 0, "rotation": [0, 0, 3.0 * half, 3.0 * half] },
        { "children": [0], "scale": [2, 1, 1], "translation": [0, 5, 0] },
    ]);
    let mesh = placed(&json, &buffer);
    close(&mesh.positions, &[[0.0, 5.0, 0.0], [0.0, 6.0, 0.0], [-2.0, 5.0, 0.0]]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    // Columns: x to z, y to x, z to y mirrored, a step along z.
    json["nodes"] = json!([{ "mesh": 0, "matrix": [0, 0, 1, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 7, 1] }]);
    let mesh = placed(&json, &buffer);
    close(&mesh.positions, &[[0.0, 0.0, 7.0], [0.0, 0.0, 8.0], [1.0, 0.0, 7.0]]);
    assert_eq!(mesh.triangles, [[0, 2, 1]]);
    // Far from zero the detail stays.
    json["nodes"] = json!([{ "mesh": 0, "translation": [4_321_034.25, 0, 0] }]);
    let mesh = placed(&json, &buffer);
    assert_eq!(mesh.origin[0], 4_321_035.0);
    assert_eq!([mesh.positions[0][0], mesh.positions[1][0]], [-0.75, 0.25]);
}

#[test]
fn the_default_scene_or_all_roots() {
    let (mut json, buffer) = triangle();
    json["nodes"] = json!([
        { "mesh": 0 }, { "mesh": 0, "translation": [5, 0, 0] }, { "mesh": 0, "translation": [9, 0, 0] }, { "children": [2] },
    ]);
    let first = |json: &Value| {
        let mesh = read("t.glb", &glb(json, &buffer)).unwrap();
        mesh.positions.iter().step_by(3).map(|p| p[0]).collect::<Vec<_>>()
    };
    assert_eq!(first(&json), [0.0, 5.0, 9.0]);
    json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [3, 1, 2] }, {}]);
    assert_eq!(first(&json), [0.0, 5.0, 9.0], "no scene is the default");
    json["scene"] = 1.into();
    assert_eq!(first(&json), [9.0, 5.0]);
    let (_, warnings) = read_with_warnings("t.glb", &glb(&json, &buffer));
    assert_eq!(warnings, ["2 scenes beside the default one not drawn"]);
}

#[test]
fn modes_of_primitives() {
    let (mut json, mut buffer) = triangle();
    let positions = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0]);
    let five = add(&mut json, &mut buffer, &positions, 5126, "VEC3", 5);
    let mut mode = |mode: u32| {
        json["meshes"][0]["primitives"] = json!([{ "attributes": { "POSITION": five }, "mode": mode }]);
        glb(&json, &buffer)
    };
    assert_eq!(read("t", &mode(5)).unwrap().triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
    assert_eq!(read("t", &mode(6)).unwrap().triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    let (mesh, warnings) = read_with_warnings("t", &mode(4));
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(warnings, ["2 corners beyond the last whole triangle ignored"]);
    for lines in 0..4 {
        assert_eq!(refusal("t", &mode(lines)), "t: has no faces");
    }
    assert_eq!(refusal("t", &mode(7)), "t: mesh 0: primitive 0: 7 is no mode");
    json["meshes"][0]["primitives"] = json!([
        { "attributes": { "POSITION": five }, "mode": 0 },
        { "attributes": { "POSITION": 0 } },
        { "attributes": {} },
        { "attributes": { "POSITION": five }, "mode": 3 },
    ]);
    let (mesh, warnings) = read_with_warnings("t", &glb(&json, &buffer));
    assert_eq!(mesh.triangles.len(), 1);
    assert_eq!(warnings, ["2 primitives of points or lines ignored, first at mesh 0, primitive 0"]);
}

#[test]
fn every_component_type() {
    let indices: [(u32, Vec<u8>); 3] = [
        (5121, vec![2, 1, 0]),
        (5123, [2u16, 1, 0].iter().flat_map(|i| i.to_le_bytes()).collect()),
        (5125, [2u32, 1, 0].iter().flat_map(|i| i.to_le_bytes()).collect()),
    ];
    for (component, bytes) in indices {
        let (mut json, mut buffer) = triangle();
        let accessor = add(&mut json, &mut buffer, &bytes, component, "SCALAR", 3);
        json["meshes"][0]["primitives"][0]["indices"] = accessor.into();
        assert_eq!(placed(&json, &buffer).triangles, [[2, 1, 0]], "{component}");
    }
    // KHR_mesh_quantization: three numbers and one byte or two that nothing means.
    let corners: [[i16; 3]; 3] = [[-127, 0, 64], [127, 0, 0], [0, 100, 127]];
    let wide = [[-32767, 0, 16384], [32767, 0, 0], [0, 3, 32767]];
    let bytes8: Vec<u8> = corners.iter().flat_map(|c| [c[0] as u8, c[1] as u8, c[2] as u8, 99]).collect();
    let bytes16: Vec<u8> =
        wide.iter().flat_map(|c| [c[0], c[1], c[2], 99]).flat_map(|c: i16| c.to_le_bytes()).collect();
    for (component, bytes, stride, values, full) in
        [(5120, &bytes8, 4, corners, 127.0f32), (5122, &bytes16, 8, wide, 32767.0)]
    {
        for normalized in [false, true] {
            let (mut json, mut buffer) = triangle();
            let accessor = add(&mut json, &mut buffer, bytes, component, "VEC3", 3);
            json["accessors"][accessor]["normalized"] = normalized.into();
            json["bufferViews"][1]["byteStride"] = stride.into();
            json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = accessor.into();
            json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            let scale = if normalized { full } else { 1.0 };
            close(&placed(&json, &buffer).positions, &values.map(|c| c.map(|v| f32::from(v) / scale)));
        }
    }
}

#[test]
fn colours_of_some_primitives() {
    let (mut json, mut buffer) = triangle();
    let rgb = add(
        &mut json,
        &mut buffer,
        &floats(&[1.0, 0.5, 0.0, 0.0, 0.0, 1.0, 2.0, -1.0, 0.2]),
        5126,
        "VEC3",
        3,
    );
    let rgba =
        add(&mut json, &mut buffer, &[255, 0, 128, 51, 0, 0, 0, 0, 255, 255, 255, 255], 5121, "VEC4", 3);
    json["accessors"][rgba]["normalized"] = true.into();
    json["meshes"][0]["primitives"] = json!([
        { "attributes": { "POSITION": 0 } },
        { "attributes": { "POSITION": 0, "COLOR_0": rgb } },
        { "attributes": { "POSITION": 0, "COLOR_0": rgba } },
        { "attributes": { "POSITION": 0 } },
    ]);
    let white = [255; 4];
    let mesh = placed(&json, &buffer);
    // The first and the last primitive share their vertices.
    assert_eq!(mesh.positions.len(), 9);
    assert_eq!(mesh.triangles[0], mesh.triangles[3]);
    let srgb = linear_to_srgb;
    let half = srgb(128.0 / 255.0);
    assert_eq!(
        mesh.colors,
        [
            white,
            white,
            white,
            [255, srgb(0.5), 0, 255],
            [0, 0, 255, 255],
            [255, 0, srgb(0.2), 255],
            [255, 0, half, 51],
            [0; 4],
            white,
        ]
    );
}

#[test]
fn morph_targets_with_their_default_weights() {
    let (mut json, mut buffer) = triangle();
    let up =
        add(&mut json, &mut buffer, &floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0]), 5126, "VEC3", 3);
    // Sparse over nothing: only vertex 1 moves along y.
    let which = add(&mut json, &mut buffer, &[1], 5121, "SCALAR", 1);
    let by = add(&mut json, &mut buffer, &floats(&[0.0, 4.0, 0.0]), 5126, "VEC3", 1);
    let sparse = json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": { "count": 1,
        "indices": { "bufferView": which, "componentType": 5121 }, "values": { "bufferView": by } } });
    json["accessors"].as_array_mut().unwrap().push(sparse);
    let targets = json!([{ "POSITION": up, "NORMAL": 77 }, { "POSITION": 4 }, {}]);
    json["meshes"][0]["primitives"][0]["targets"] = targets;
    let at = |json: &Value| placed(json, &buffer).positions;
    close(&at(&json), &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    json["meshes"][0]["weights"] = json!([0.5, 0.25, 1]);
    close(&at(&json), &[[0.0, 0.0, 0.5], [1.0, 1.0, 1.0], [0.0, 1.0, 1.5]]);
    json["nodes"][0]["weights"] = json!([0, -1, 0]);
    close(&at(&json), &[[0.0, 0.0, 0.0], [1.0, -4.0, 0.0], [0.0, 1.0, 0.0]]);
    // A sparse accessor over values of its own.
    json["accessors"][4]["bufferView"] = up.into();
    close(&at(&json), &[[0.0, 0.0, -1.0], [1.0, -4.0, 0.0], [0.0, 1.0, -3.0]]);
    json["accessors"][4]["count"] = 2.into();
    assert_eq!(refusal("t", &glb(&json, &buffer)), "t: accessor 4: has 2 elements, but 3 are needed here");
}

#[test]
fn skins_at_rest() {
    let (mut json, mut buffer) = triangle();
    let joints = add(&mut json, &mut buffer, &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 9, 9], 5121, "VEC4", 3);
    // The last vertex belongs to both joints alike, with weights that do not add up to 1.
    let weights = add(
        &mut json,
        &mut buffer,
        &floats(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 2.0, 0.0, 0.0]),
        5126,
        "VEC4",
        3,
    );
    // Joint 1 was bound a step along x.
    let mut binds = [0.0f32; 32];
    (0..8).for_each(|k| binds[k / 4 * 16 + k % 4 * 5] = 1.0);
    binds[16 + 12] = -1.0;
    let binds = add(&mut json, &mut buffer, &floats(&binds), 5126, "MAT4", 2);
    json["meshes"][0]["primitives"][0]["attributes"] =
        json!({ "POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights });
    // The transform of the node with the mesh must not matter.
    json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "translation": [100, 100, 100], "scale": [-1, 1, 1] },
        { "translation": [0, 0, 10], "children": [2] },
        { "translation": [1, 0, 0], "scale": [2, 2, 2] },
    ]);
    json["skins"] = json!([{ "joints": [1, 2], "inverseBindMatrices": binds }]);
    let mesh = placed(&json, &buffer);
    // Joint 0: +10 z. Joint 1: 2 (v − x) + x + 10 z.
    close(&mesh.positions, &[[0.0, 0.0, 10.0], [1.0, 0.0, 10.0], [-0.5, 1.5, 10.0]]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    let mirrored = {
        let mut j = json.clone();
        j["nodes"][1]["scale"] = json!([-1, 1, 1]);
        placed(&j, &buffer)
    };
    assert_eq!(mirrored.triangles, [[0, 2, 1]]);
    let unbound = {
        let mut j = json.clone();
        j["skins"] = json!([{ "joints": [1, 2] }]);
        placed(&j, &buffer)
    };
    close(&unbound.positions, &[[0.0, 0.0, 10.0], [3.0, 0.0, 10.0], [0.5, 1.5, 10.0]]);

    let refused = |path: &[&str], value: Value| {
        let mut json = json.clone();
        let slot = path.iter().fold(&mut json, |v, key| match key.parse::<usize>() {
            Ok(index) => &mut v[index],
            Err(_) => &mut v[*key],
        });
        *slot = value;
        refusal("t", &glb(&json, &buffer))
    };
    assert_eq!(
        refused(&["skins", "0", "joints"], json!([1])),
        "t: accessor 1: vertex 1: a joint out of range (1 joints)"
    );
    assert_eq!(
        refused(&["skins", "0", "joints"], json!([1, 9])),
        "t: skin 0: node 9 does not exist (3 are there)"
    );
    assert_eq!(
        refused(&["skins", "0", "joints"], json!([1, 2, 2])),
        "t: skin 0: 2 inverse bind matrices for 3 joints"
    );
    assert_eq!(refused(&["nodes", "0", "skin"], json!(3)), "t: skin 3: does not exist (1 skins)");
}

#[test]
fn refusals_name_the_place() {
    let (json, buffer) = triangle();
    let with = |path: &str, value: Value| {
        let mut json = json.clone();
        let slot = path.split('.').fold(&mut json, |v, key| match key.parse::<usize>() {
            Ok(index) => &mut v[index],
            Err(_) => &mut v[key],
        });
        *slot = value;
        refusal("t.glb", &glb(&json, &buffer)).strip_prefix("t.glb: ").unwrap().to_owned()
    };
    let huge = json!(u64::MAX);
    for (path, value, expected) in [
        (
            "extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "needs the extension KHR_draco_mesh_compression (Draco compression), which is not read",
        ),
        (
            "extensionsRequired",
            json!(["KHR_materials_unlit", "EXT_meshopt_compression"]),
            "needs the extension EXT_meshopt_compression (meshopt compression), which is not read",
        ),
        (
            "extensionsRequired",
            json!(["ACME\nrockets"]),
            "needs the extension ACME\\nrockets, which is not read",
        ),
        (
            "asset.version",
            json!("1.0"),
            "is a glTF file of another version than 2, which is not read yet; PLY, OBJ, STL, OFF and glTF are",
        ),
        ("scene", json!(0), "scene 0: does not exist (0 scenes)"),
        ("nodes.0.mesh", json!(1), "node 0: mesh 1 does not exist (1 are there)"),
        ("nodes.0.children", json!([1]), "node 0: child 1 does not exist (1 are there)"),
        ("nodes.0.children", json!([0]), "node 0: is below itself: its children form a cycle"),
        ("nodes", json!([{ "children": [1, 1] }, {}]), "node 1: is a child of node 0 and again of node 0"),
        ("meshes.0.primitives.0.attributes.POSITION", json!(5), "accessor 5: does not exist (1 accessors)"),
        (
            "meshes.0.primitives.0.indices",
            json!(0),
            "accessor 0: its type is Vec3, but Scalar is needed here",
        ),
        ("accessors.0.type", json!("VEC2"), "accessor 0: its type is Vec2, but Vec3 is needed here"),
        ("accessors.0.componentType", json!(5124), "accessor 0: 5124 is no component type"),
        (
            "accessors.0.count",
            json!(4),
            "accessor 0: 4 elements of 12 bytes, 12 apart from byte 0, leave the 36 bytes of buffer view 0",
        ),
        (
            "accessors.0.count",
            huge.clone(),
            "accessor 0: 18446744073709551615 elements of 12 bytes, 12 apart from byte 0, leave the 36 bytes of buffer view 0",
        ),
        (
            "accessors.0.byteOffset",
            huge.clone(),
            "accessor 0: 3 elements of 12 bytes, 12 apart from byte 18446744073709551615, leave the 36 bytes of buffer view 0",
        ),
        (
            "accessors.0",
            json!({ "componentType": 5126, "count": 1u64 << 40, "type": "VEC3" }),
            "accessor 0: 1099511627776 elements without a buffer view",
        ),
        ("accessors.0.bufferView", json!(2), "accessor 0: buffer view 2 does not exist (1 views)"),
        (
            "accessors.0.sparse",
            json!({ "count": 4, "indices": { "bufferView": 0, "componentType": 5121 }, "values": { "bufferView": 0 } }),
            "accessor 0: 4 sparse elements of 3",
        ),
        (
            "accessors.0.sparse",
            json!({ "count": 3, "indices": { "bufferView": 0, "componentType": 5121, "byteOffset": 13 }, "values": { "bufferView": 0 } }),
            "accessor 0: sparse index 128 of 3 elements",
        ),
        (
            "accessors.0.sparse",
            json!({ "count": 1, "indices": { "bufferView": 0, "componentType": 5126 }, "values": { "bufferView": 0 } }),
            "accessor 0: 5126 is no type for sparse indices",
        ),
        (
            "bufferViews.0.byteLength",
            huge.clone(),
            "buffer view 0: 18446744073709551615 bytes from byte 0, but the buffer has 36",
        ),
        (
            "bufferViews.0.byteOffset",
            huge.clone(),
            "buffer view 0: 36 bytes from byte 18446744073709551615, but the buffer has 36",
        ),
        (
            "bufferViews.0.byteStride",
            json!(8),
            "buffer view 0: byteStride 8 is less than the 12 bytes of an element",
        ),
        (
            "bufferViews.0.byteStride",
            huge.clone(),
            "accessor 0: 3 elements of 12 bytes, 18446744073709551615 apart from byte 0, leave the 36 bytes of buffer view 0",
        ),
        ("bufferViews.0.buffer", json!(1), "buffer 1: does not exist (1 buffers)"),
        ("buffers.0.byteLength", json!(40), "buffer 0: declares 40 bytes, but 36 are there"),
        (
            "nodes.0.scale",
            json!([1e200, 1e200, 1e200]),
            "has x from 0e0 to 1e200, beyond the range of single precision",
        ),
        (
            "nodes",
            json!([{ "mesh": 0, "scale": [1e200, 1, 1] }, { "scale": [1e200, 1, 1], "children": [0] }]),
            "mesh 0: primitive 0: vertex 0: x is NaN",
        ),
    ] {
        assert_eq!(with(path, value.clone()), expected, "{path} = {value}");
    }
    let mut nan = buffer.clone();
    nan[16..20].copy_from_slice(&f32::INFINITY.to_le_bytes());
    assert_eq!(refusal("t", &glb(&json, &nan)), "t: mesh 0: primitive 0: vertex 1: y is inf");
    assert_eq!(
        refusal("t.gltf", b"{\n  \"asset\": {\n  \"version\": 2 }\n}"),
        "t.gltf: line 3: JSON: invalid type: integer `2`, expected a text"
    );
    assert_eq!(refusal("t.gltf", b"{ \"asset\""), "t.gltf: line 1: JSON: EOF while parsing an object");
    let nested = format!("{{\"asset\": {}", "[".repeat(100_000));
    assert!(refusal("t.gltf", nested.as_bytes()).contains("JSON: "));
}

#[test]
fn small_files_do_not_grow_without_bound() {
    let (mut json, mut buffer) = triangle();
    let n = 30_000;
    let indices: Vec<u8> = (0..3 * n).map(|i| (i % 3) as u8).collect();
    let many = add(&mut json, &mut buffer, &indices, 5121, "SCALAR", 3 * n);
    json["meshes"][0]["primitives"][0]["indices"] = many.into();
    // Ten instances are what instances are for, ten thousand of ninety kilobytes are not.
    let instances = |count: usize| {
        let mut json = json.clone();
        json["nodes"] = vec![json!({ "mesh": 0 }); count].into();
        glb(&json, &buffer)
    };
    assert_eq!(read("t", &instances(10)).unwrap().triangles.len(), 10 * n);
    assert_eq!(refusal("t", &instances(10_000)), "t: what its scene draws expands to more than 64 MiB");
    let nodes = format!("{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{{}}{}]}}", ",{}".repeat(1 << 19));
    assert_eq!(refusal("t.gltf", nodes.as_bytes()), "t.gltf: line 1: JSON: a list of more than 524288 items");
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn real_files_have_the_counts_that_other_readers_found() {
    for (name, triangles) in [
        ("meshes/duck.glb", 4_212),
        ("animated/fox.glb", 576),
        ("animated/cesiumman.glb", 4_672),
        ("animated/riggedsimple.glb", 892),
        ("animated/simple_skin.gltf", 8),
        ("animated/morphstresstest.glb", 2_412),
        ("animated/animatedmorphcube/AnimatedMorphCube.gltf", 12),
        ("animated/morphprimitivestest/MorphPrimitivesTest.gltf", 32),
        ("animated/sparse_blendshape_cube.glb", 12),
    ] {
        let mut warnings = Warnings::new();
        let mesh = read_mesh(&shared_data().join(name), &mut warnings).unwrap();
        assert_eq!(mesh.triangles.len(), triangles, "{name}");
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
    }
    let duck = read_mesh(&shared_data().join("meshes/duck.glb"), &mut Warnings::new()).unwrap();
    assert_eq!(duck.positions.len(), 2_399);
    // Scaled to a hundredth by its node; as other viewers measure it.
    let highest = duck.positions.iter().fold(0.0f32, |m, p| m.max(p[1]));
    assert!((highest - 1.6397).abs() < 1e-4, "{highest}");
    // A skinned man as tall as men are, upright along y.
    let man = read_mesh(&shared_data().join("animated/cesiumman.glb"), &mut Warnings::new()).unwrap();
    let (low, high) = man.positions.iter().fold((0.0f32, 0.0f32), |(l, h), p| (l.min(p[1]), h.max(p[1])));
    assert!(low.abs() < 0.01 && (high - 1.5066).abs() < 0.01, "{low} {high}");
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn every_animated_file_of_the_shared_data_is_listed_above() {
    let listed = include_str!("gltf.rs");
    let mut folders = vec![shared_data().join("animated")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if path.is_dir() {
                folders.push(path);
            } else if name.ends_with(".glb") || name.ends_with(".gltf") {
                assert!(listed.contains(&format!("/{name}\"")), "{name} has no line in the table");
            }
        }
    }
}

#[test]
fn the_checksum_holds_the_buffers_beside_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let json = br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":36,"uri":"b.bin"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]}"#;
    let corners = |z: f32| -> Vec<u8> {
        [0.0, 0.0, z, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v: &f32| v.to_le_bytes()).collect()
    };
    let read = |z: f32| {
        std::fs::write(folder.path().join("b.bin"), corners(z)).unwrap();
        let name = folder.path().join("a.gltf");
        read_mesh_checked(&name, json, &mut Warnings::new()).unwrap().1
    };
    let first = read(0.0);
    assert_eq!(first, checksum(&[&json[..], &corners(0.0)].concat()));
    assert_ne!(first, read(0.5));
}

/// A hostile file may name one file a thousand times, in as many ways and lengths: it is read once.
#[test]
fn a_file_named_in_many_ways_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    let content = [floats(&TRIANGLE), b"more".to_vec()].concat();
    std::fs::write(folder.path().join("b.bin"), &content).unwrap();
    let (mut json, _) = triangle();
    json["buffers"] = json!([
        { "uri": "b.bin", "byteLength": 36 },
        { "uri": "sub/../b.bin", "byteLength": 38 },
        { "uri": "./b.bin", "byteLength": 1000 },
    ]);
    json["bufferViews"] = json!([{ "buffer": 0, "byteLength": 36 }, { "buffer": 1, "byteLength": 38 }, { "buffer": 2, "byteLength": 36 }]);
    let accessor =
        |view: usize| json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3" });
    json["accessors"] = json!([accessor(0), accessor(1), accessor(2)]);
    let primitive = |k: usize| json!({ "attributes": { "POSITION": k } });
    let read = |json: &Value| {
        let text = json.to_string();
        let read = read_mesh_checked(&folder.path().join("a.gltf"), text.as_bytes(), &mut Warnings::new());
        read.map(|(mesh, sum)| (mesh, sum == checksum(&[text.as_bytes(), &content[..38]].concat())))
    };
    json["meshes"][0]["primitives"] = json!([primitive(0), primitive(1)]);
    let (mesh, sum_holds_the_file_once) = read(&json).unwrap();
    assert_eq!(mesh.triangles.len(), 2);
    assert!(sum_holds_the_file_once);
    json["meshes"][0]["primitives"] = json!([primitive(0), primitive(2)]);
    let message = read(&json).unwrap_err().to_string();
    assert!(message.ends_with("buffer 2: './b.bin': 1000 bytes declared, but the file has 40"), "{message}");
}

#[test]
fn facts_of_gzipped_files_too() {
    let (json, buffer) = gltf_parts();
    for bytes in [gltf(&json, &buffer), glb(&json, &buffer)] {
        let facts = mesh_facts(Path::new("x"), &bytes);
        assert!(
            facts.contains(&("contents".into(), "1 scene, 2 nodes, 1 mesh, 2 primitives".into())),
            "{facts:?}"
        );
        assert_eq!(mesh_facts(Path::new("x.gz"), &gzip(&bytes)), facts);
    }
    for other in [ply_ascii(), gzip(&ply_ascii()), gzip(b""), vec![], b"\x1f\x8b".to_vec()] {
        assert_eq!(mesh_facts(Path::new("x.gltf"), &other), []);
    }
}

/// The triangle with an animation that moves its node along x from 0 to 4 within two seconds; the accessors of its times
/// and values.
fn moving() -> (Value, Vec<u8>, [usize; 2]) {
    let (mut json, mut buffer) = triangle();
    let times = add(&mut json, &mut buffer, &floats(&[0.0, 2.0]), 5126, "SCALAR", 2);
    let values = add(&mut json, &mut buffer, &floats(&[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]), 5126, "VEC3", 2);
    json["animations"] = json!([{
        "name": "along",
        "samplers": [{ "input": times, "output": values }],
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
    }]);
    (json, buffer, [times, values])
}

/// The model, and what was said about it.
fn model(json: &Value, buffer: &[u8]) -> (dotwork_io::Model, Vec<String>) {
    let mut warnings = Warnings::new();
    let model = dotwork_io::read_model(Path::new("t.glb"), &glb(json, buffer), &mut warnings).unwrap();
    (model, warnings.iter().map(ToString::to_string).collect())
}

#[test]
fn a_node_moves_by_its_animation() {
    let (mut json, mut buffer, _) = moving();
    // A camera on a node below moves with it.
    json["nodes"] = json!([{ "mesh": 0, "children": [1] }, { "camera": 0, "translation": [0.0, 0.0, 5.0] }]);
    json["cameras"] =
        json!([{ "name": "eye", "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }]);
    let (model, said) = model(&json, &buffer);
    assert_eq!(said, [""; 0]);
    let motion = model.motion.unwrap();
    assert_eq!((motion.clips()[0].name.as_str(), motion.clips()[0].seconds), ("along", 2.0));
    let mut positions = Vec::new();
    for (clip, time, x) in [(Some(0), -1.0, 0.0), (Some(0), 0.5, 1.0), (Some(0), 9.0, 4.0), (None, 1.0, 0.0)]
    {
        motion.place(clip, time, &mut positions);
        assert!((positions[0][0] - x).abs() < 1e-6 && (positions[1][0] - x - 1.0).abs() < 1e-6, "{time}");
        let seen = motion.standpoint(0, clip, time).unwrap();
        assert!((seen.eye.x - f64::from(x)).abs() < 1e-9 && (seen.eye.z - 5.0).abs() < 1e-9);
        assert_eq!(seen.back, glam::Vec3::Z);
    }
    assert_eq!((motion.cameras(), motion.standpoint(1, None, 0.0)), (&["eye".to_string()][..], None));
    // A weight that no target has moves nothing.
    let weights = add(&mut json, &mut buffer, &floats(&[0.0, 1.0]), 5126, "SCALAR", 2);
    json["animations"][0]["samplers"][0]["output"] = weights.into();
    json["animations"][0]["channels"][0]["target"]["path"] = "weights".into();
    let (model, said) = self::model(&json, &buffer);
    assert_eq!(said, [""; 0]);
    model.motion.unwrap().place(Some(0), 1.0, &mut positions);
    assert_eq!(positions.as_flattened(), TRIANGLE);
}

#[test]
fn damaged_animations_are_left_out_by_name() {
    type Change = fn(&mut Value, &mut Vec<u8>, [usize; 2]);
    let cases: [(&str, Change); 9] = [
        ("channel 0: sampler 7 does not exist (1 are there)", |j, _, _| {
            j["animations"][0]["channels"][0]["sampler"] = 7.into();
        }),
        ("channel 0: node 9 does not exist (1 are there)", |j, _, _| {
            j["animations"][0]["channels"][0]["target"]["node"] = 9.into();
        }),
        ("accessor 99: does not exist", |j, _, _| {
            j["animations"][0]["samplers"][0]["input"] = 99.into();
        }),
        ("channel 0: its times do not rise", |j, b, _| {
            let times = add(j, b, &floats(&[2.0, 2.0]), 5126, "SCALAR", 2);
            j["animations"][0]["samplers"][0]["input"] = times.into();
        }),
        ("channel 0: its times do not rise", |j, b, _| {
            let times = add(j, b, &floats(&[0.0, f32::NAN]), 5126, "SCALAR", 2);
            j["animations"][0]["samplers"][0]["input"] = times.into();
        }),
        ("channel 0: 2 keys need 18 numbers, not 6", |j, _, _| {
            j["animations"][0]["samplers"][0]["interpolation"] = "CUBICSPLINE".into();
        }),
        ("channel 0: 'SWING' is no interpolation", |j, _, _| {
            j["animations"][0]["samplers"][0]["interpolation"] = "SWING".into();
        }),
        ("its type is Vec3, but Vec4 is needed here", |j, _, _| {
            j["animations"][0]["channels"][0]["target"]["path"] = "rotation".into();
        }),
        ("channel 0: a value is not a finite number", |j, b, _| {
            let values = [0.0, 0.0, 0.0, f32::INFINITY, 0.0, 0.0];
            let values = add(j, b, &floats(&values), 5126, "VEC3", 2);
            j["animations"][0]["samplers"][0]["output"] = values.into();
        }),
    ];
    for (reason, change) in cases {
        let (mut json, mut buffer, accessors) = moving();
        change(&mut json, &mut buffer, accessors);
        let (model, said) = model(&json, &buffer);
        let whole = said.len() == 1 && said[0].starts_with("animation 0 is left out: ");
        assert!(whole && said[0].contains(reason), "{reason}: {said:?}");
        assert!(model.motion.is_none() && model.mesh.triangles.len() == 1);
    }
}

/// A PNG of one row, red then blue, with opacity.
fn png_row(pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, pixels.len() as u32, 1);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(pixels.as_flattened()).unwrap();
    writer.finish().unwrap();
    bytes
}

const RED: [u8; 4] = [255, 0, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 128];

/// The triangle with a material whose picture lies in the buffer, its first corner on the left of the picture and its
/// others on the right.
fn textured(picture: &[u8]) -> (Value, Vec<u8>) {
    let (mut json, mut buffer) = triangle();
    let places = floats(&[0.25, 0.5, 0.75, 0.5, 0.75, 0.5]);
    let places = add(&mut json, &mut buffer, &places, 5126, "VEC2", 3);
    let primitive = &mut json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = places.into();
    primitive["material"] = 0.into();
    add(&mut json, &mut buffer, picture, 5121, "SCALAR", picture.len());
    let view = json["bufferViews"].as_array().unwrap().len() - 1;
    json["bufferViews"][view]["byteLength"] = picture.len().into();
    json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    json["textures"] = json!([{ "source": 0 }]);
    json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    (json, buffer)
}

/// The colour of a mesh's first triangle at weights of its second and third corner.
fn color_of(raw: RawMesh, weights: [f32; 2]) -> [f32; 4] {
    let mesh = Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap();
    mesh.color_at(0, weights)
}

#[test]
fn pictures_are_sampled_where_the_corners_lie() {
    let (mut json, buffer) = textured(&png_row(&[RED, BLUE]));
    let mesh = placed(&json, &buffer);
    assert_eq!(color_of(mesh.clone(), [0.0, 0.0]), [1.0, 0.0, 0.0, 1.0]);
    // Opaque is what is not said to be otherwise.
    assert_eq!(color_of(mesh.clone(), [1.0, 0.0]), [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(color_of(mesh.clone(), [0.25, 0.25]), [0.5, 0.0, 0.5, 1.0]);
    json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.5, 1.0, 0.25, 0.5]);
    json["materials"][0]["alphaMode"] = "BLEND".into();
    let color = color_of(placed(&json, &buffer), [0.0, 1.0]);
    assert_eq!(color, [0.0, 0.0, 0.25, 0.5 * 128.0 / 255.0]);
    // Turned by half a turn about the picture's middle, the first corner is on the right.
    json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "extensions": {
        "KHR_texture_transform": { "rotation": std::f32::consts::PI, "offset": [1.0, 1.0] } } } } }]);
    let turned = color_of(placed(&json, &buffer), [0.0, 0.0]);
    assert!(turned[2] > 0.999 && turned[0] < 0.001, "{turned:?}");
    // Half as wide: both lie left of the first sample's middle, which repeats to the last.
    json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "extensions": {
        "KHR_texture_transform": { "scale": [0.0, 1.0] } } } } }]);
    assert_eq!(color_of(placed(&json, &buffer), [1.0, 0.0]), [0.5, 0.0, 0.5, 1.0]);
    json["samplers"] = json!([{ "wrapS": 33071 }]);
    json["textures"][0]["sampler"] = 0.into();
    assert_eq!(color_of(placed(&json, &buffer), [1.0, 0.0]), [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn corners_keep_their_places_where_vertices_are_welded_and_triangles_turned() {
    // Two triangles of one square: a soup, the second wound the other way and sewn to the picture elsewhere.
    let (mut json, mut buffer) = textured(&png_row(&[RED, BLUE]));
    let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    let positions = add(&mut json, &mut buffer, &floats(&square), 5126, "VEC3", 6);
    let places = [0.25, 0.5, 0.25, 0.5, 0.25, 0.5, 0.75, 0.5, 0.75, 0.5, 0.25, 0.5];
    let places = add(&mut json, &mut buffer, &floats(&places), 5126, "VEC2", 6);
    json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": positions, "TEXCOORD_0": places });
    let mesh = placed(&json, &buffer);
    let mesh = Mesh::build(mesh, &MeshOptions::default(), &mut Warnings::new()).unwrap();
    assert_eq!(mesh.positions.len(), 4);
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for (&v, weights) in corners.iter().zip([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) {
            let blue = t == 1 && mesh.positions[v as usize].truncate() != glam::Vec2::ONE;
            assert_eq!(mesh.color_at(t, weights)[2], f32::from(u8::from(blue)), "{t} {v}");
        }
    }
}

#[test]
fn base_colours_without_pictures_and_without_bleeding() {
    let (mut json, buffer) = triangle();
    json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorFactor": [1.0, 0.5, 0.0, 0.25] } }]);
    // A primitive without a material is white.
    assert_eq!(color_of(placed(&json, &buffer), [0.3, 0.3]), [1.0; 4]);
    assert_eq!(placed(&json, &buffer).paint, None);
    json["meshes"][0]["primitives"][0]["material"] = 0.into();
    assert_eq!(color_of(placed(&json, &buffer), [0.3, 0.3]), [1.0, 0.5, 0.0, 1.0]);
    json["meshes"][0]["primitives"][0]["material"] = 7.into();
    assert_eq!(refusal("t", &glb(&json, &buffer)), "t: material 7: does not exist (1 materials)");
}

#[test]
fn pictures_that_cannot_be_read_are_left_out_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let good = png_row(&[RED, BLUE]);
    std::fs::write(folder.path().join("good.png"), &good).unwrap();
    let (json, buffer) = textured(&good);
    let path = folder.path().join("t.glb");
    let said = |json: &Value, buffer: &[u8]| {
        std::fs::write(&path, glb(json, buffer)).unwrap();
        let mut warnings = Warnings::new();
        let mesh = read_mesh(&path, &mut warnings).unwrap();
        let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        (mesh.paint.is_some(), warnings.join("; "))
    };
    let uri = |uri: &str| {
        let mut json = json.clone();
        json["images"] = json!([{ "uri": uri }]);
        said(&json, &buffer)
    };
    assert_eq!(uri("good.png"), (true, String::new()));
    assert_eq!(uri("missing.png"), (false, "picture 0 left out: 'missing.png': no such file".into()));
    assert!(uri("/etc/passwd").1.contains("is an absolute path"));
    assert!(uri("data:image/png;base64,AAAA").1.contains("is neither PNG nor JPEG"));
    // Every way in which the data may end or be damaged: never a panic, and a name.
    let mut left_out = 0;
    for cut in 0..good.len() {
        let (json, buffer) = textured(&good[..cut.max(1)]);
        let (painted, warnings) = said(&json, &buffer);
        assert!(painted || warnings.starts_with("picture 0 left out: "), "{cut}: {warnings}");
        left_out += usize::from(!painted);
        let mut damaged = good.clone();
        damaged[cut] ^= 0x55;
        let (json, buffer) = textured(&damaged);
        let (painted, warnings) = said(&json, &buffer);
        assert!(painted || warnings.starts_with("picture 0 left out: "), "{cut}: {warnings}");
    }
    assert!(left_out > 30, "{left_out}");
    // A JPEG that has only begun, and one of a declared size that no such file can mean.
    let jpeg = [0xff, 0xd8, 0xff, 0xc0, 0, 11, 8, 0x3f, 0xff, 0x3f, 0xff, 1, 1, 0x11, 0];
    let (json, buffer) = textured(&jpeg);
    assert!(said(&json, &buffer).1.starts_with("picture 0 left out: "));
    // The header of a PNG of a terabyte.
    let mut bomb = good.clone();
    bomb[16..24].copy_from_slice(&[0, 4, 0, 0, 0, 4, 0, 0]);
    let crc = crc32(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    let (mut json, buffer) = textured(&bomb);
    assert_eq!(
        said(&json, &buffer).1,
        "picture 0 left out: 262144 x 262144 pixels; sides of 1 to 16384 are read"
    );
    bomb[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
    let crc = crc32(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    let (large, with) = textured(&bomb);
    assert!(said(&large, &with).1.contains("16384 x 16384 pixels are more than a file of its size may mean"));
    for (key, value, reason) in [
        ("textures", json!([]), "texture 0 does not exist (0 textures): left out"),
        ("textures", json!([{}]), "texture 0 has no picture in PNG or JPEG: left out"),
        ("textures", json!([{ "source": 9 }]), "picture 9 left out: does not exist (1 pictures)"),
        ("images", json!([{}]), "picture 0 left out: has no content"),
    ] {
        let before = std::mem::replace(&mut json[key], value);
        assert_eq!(said(&json, &buffer), (false, reason.to_string()));
        json[key] = before;
    }
    json["images"][0]["bufferView"] = 99.into();
    assert!(said(&json, &buffer).1.contains("buffer view 99"));
}

/// CRC-32 as PNG has it.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    })
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn real_pictures_colour_their_surfaces() {
    let named = |name: &str| {
        let raw = read_mesh(&shared_data().join(name), &mut Warnings::new()).unwrap();
        Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap()
    };
    let mean = |mesh: &Mesh| {
        let n = mesh.triangles.len();
        let all = (0..n).map(|t| mesh.color_at(t, [1.0 / 3.0; 2]));
        let sum = all.fold([0.0; 3], |s: [f32; 3], c| [s[0] + c[0], s[1] + c[1], s[2] + c[2]]);
        sum.map(|c| c / n as f32)
    };
    // A yellow duck, a reddish fox.
    let [r, g, b] = mean(&named("meshes/duck.glb"));
    assert!(r > 0.4 && g > 0.3 && b < 0.3 * g, "{r} {g} {b}");
    let [r, g, b] = mean(&named("animated/fox.glb"));
    assert!(r > 1.5 * g && g > 1.2 * b, "{r} {g} {b}");
    assert!(named("animated/cesiumman.glb").paint.is_some());
}
