//! What the readers say of bad files: never a panic, always the file, the place and the reason.

mod common;

use common::*;
use dotwork_drawing::Warnings;
use dotwork_drawing::hash::hash2;
use dotwork_io::dots::{Reader, Writer};
use dotwork_io::{read_file, read_mesh};
use std::path::Path;

fn ply(encoding: &str, vertices: &str, faces: &str, body: &[u8]) -> Vec<u8> {
    let header = format!(
        "ply\nformat {encoding} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    );
    [header.as_bytes(), body].concat()
}

fn ascii(body: &str) -> Vec<u8> {
    ply("ascii", "3", "1", body.as_bytes())
}

/// Three vertices, then `faces` in little-endian.
fn binary(corner_count: u8, corners: &[i32]) -> Vec<u8> {
    let mut body: Vec<u8> =
        [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    body.push(corner_count);
    body.extend(corners.iter().flat_map(|c| c.to_le_bytes()));
    ply("binary_little_endian", "3", "1", &body)
}

/// Found by a fuzzer: an element without properties was stepped over, and the faces referred to vertices that were not
/// there.
#[test]
fn ply_vertices_without_any_property() {
    let file =
        b"ply\nformat ascii 1.0\nelement vertex 3\nelement face 1\nproperty list uchar int vertex_indices\n\
        end_header\n3 0 1 2\n";
    assert_eq!(refusal("x.ply", file), "x.ply: line 3: the element vertex has no property x");
}

#[test]
fn files_that_are_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("empty.ply"), b"").unwrap();
    std::fs::create_dir(at("series")).unwrap();
    for (name, reason) in [
        ("missing.ply", "no such file"),
        ("empty.ply", "the file is empty"),
        ("series", "is a directory without TIFF pages (series of other files are not read yet)"),
    ] {
        let expected = format!("{}: {reason}", at(name).display());
        assert_eq!(read_mesh(&at(name), &mut Warnings::new()).unwrap_err().to_string(), expected);
        assert_eq!(read_file(&at(name)).unwrap_err().to_string(), expected);
        assert_eq!(Reader::open(at(name)).unwrap_err().to_string(), expected);
    }
    assert_eq!(refusal("bad\nname.ply", b""), "bad\\nname.ply: the file is empty");
}

#[test]
fn other_formats_are_named() {
    let mut dicom = vec![0; 200];
    dicom[128..132].copy_from_slice(b"DICM");
    let mut nifti = vec![0; 352];
    nifti[344..348].copy_from_slice(b"n+1\0");
    let empty_dots = Writer::new().finish();
    let not_yet = |what: &str| format!("is {what}, which is not read yet; PLY, OBJ, STL, OFF and glTF are");
    let none = |begins: &str| format!("is none of PLY, OBJ, STL, OFF and glTF (begins with {begins})");
    for (name, content, expected) in [
        ("x", &b"NRRD0004\n"[..], "is an NRRD volume, not a mesh".into()),
        ("x", &dicom, "is a DICOM file, not a mesh".into()),
        ("x", &nifti, "is a NIfTI volume, not a mesh".into()),
        ("x.mhd", b"NDims = 3\n", "is a MetaImage volume, not a mesh".into()),
        ("x", b"II*\0\x08\0\0\0", "is a TIFF image, not a mesh".into()),
        (
            "x.ply",
            b"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\n",
            "is a VTK volume, not a mesh".into(),
        ),
        ("x", b"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\n", not_yet("a VTK file")),
        ("x", b"Kaydara FBX Binary  \0", not_yet("an FBX file")),
        ("x.dae", b"<?xml version=\"1.0\"?>", not_yet("a COLLADA file")),
        ("x.vm", b"_0 var-x\n", not_yet("an implicit model")),
        ("x", &empty_dots, "is a .dots file, not a mesh".into()),
        ("x.ply", b"hello world\n", none("'hello world'")),
        ("x.stl", b"hello world\n", none("'hello world'")),
        ("x.off", b"hello world\n", none("'hello world'")),
        ("x.glb", b"hello world\n", none("'hello world'")),
        ("x.json", b"{ \"a\": 1 }\n", none("'{ \"a\": 1 }'")),
        ("x.obj", b"\x00\x01\xff\x80", none("bytes 00 01 ff 80")),
        ("x.obj", b"# only a comment\n", "has no faces".into()),
    ] {
        assert_eq!(refusal(name, content), format!("{name}: {expected}"));
        let packed = format!("{name}.gz");
        assert_eq!(refusal(&packed, &gzip(content)), format!("{packed}: {expected}"));
    }
}

#[test]
fn places_and_reasons() {
    let far = "f 1 2 9\n";
    let obj = |tail: &str| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{tail}").into_bytes();
    let header = binary(3, &[0, 1, 2]).len() - 13 - 36;
    let mut nan = binary(3, &[0, 1, 2]);
    nan[header + 16..header + 20].copy_from_slice(&f32::NAN.to_le_bytes());
    for (name, bytes, expected) in [
        ("a.ply", ascii("0 0 0\n1 0\n0 1 0\n3 0 1 2\n"), "line 11: expected 3 coordinates, found 2".into()),
        ("a.ply", ascii("0 0 0\n1 0 x\n"), "line 11: 'x' is not a number".into()),
        ("a.ply", ascii("0 0 0\n1 nan 0\n"), "line 11: vertex 2: y is NaN".into()),
        ("a.ply", ascii("0 0 0\n1 0 -inf\n"), "line 11: vertex 2: z is -inf".into()),
        ("a.ply", ascii("0 0 0\n1 1 1e999\n"), "line 11: vertex 2: z is inf".into()),
        ("a.ply", ascii("0 0 0\n\n1 0 0\n"), "line 13: the file ends before vertex 3 of 3".into()),
        ("a.ply", ascii("0 0 0\n1 0 0\n0 1 0\n"), "line 13: the file ends before face 1 of 1".into()),
        (
            "a.ply",
            ascii("0 0 0\n1 0 0\n0 1 0\n3 0 1\n"),
            "line 13: face 1 of 1: expected 3 indices, found 2".into(),
        ),
        (
            "a.ply",
            ascii("0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n"),
            "line 13: face 1 of 1: a list of -3 items".into(),
        ),
        (
            "a.ply",
            ascii("0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n"),
            "line 13: face 1 of 1: expected 4000000000 indices, found 3".into(),
        ),
        (
            "a.ply",
            ascii("0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "line 13: face 1 of 1: index 3 is out of range (3 vertices)".into(),
        ),
        (
            "a.ply",
            ascii("0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
            "line 13: face 1 of 1: index -1 is out of range (3 vertices)".into(),
        ),
        ("a.ply", ascii("0 0 0\n1 0 0\n0 1 0\n3 0 1 2.5\n"), "line 13: '2.5' is not an integer".into()),
        ("a.ply", ascii("0 0 0\n1 0 0\n0 1 0\n2 0 1\n"), "has no faces".into()),
        ("p.ply", ply("ascii", "3", "0", b"0 0 0\n1 0 0\n0 1 0\n"), "has no faces".into()),
        ("e.ply", b"ply\nformat ascii 1.0\nend_header\n".to_vec(), "has no faces".into()),
        ("n.ply", ply("ascii", "-3", "1", b""), "line 3: '-3' is not a count of elements 'vertex'".into()),
        ("n.ply", ply("ascii", "3", "many", b""), "line 7: 'many' is not a count of elements 'face'".into()),
        (
            "x.ply",
            b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nelement face 1\nend_header\n0\n"
                .to_vec(),
            "line 3: the element vertex has no property y".into(),
        ),
        (
            "b.ply",
            binary(3, &[0, 1, 3]),
            format!("byte {}: face 1 of 1: index 3 is out of range (3 vertices)", header + 36),
        ),
        (
            "b.ply",
            binary(3, &[0, 1, -1]),
            format!("byte {}: face 1 of 1: index -1 is out of range (3 vertices)", header + 36),
        ),
        (
            "b.ply",
            binary(3, &[0, 1]),
            format!("byte {}: the file ends in the middle of face 1 of 1", header + 45),
        ),
        (
            "b.ply",
            binary(3, &[0, 1, 2])[..header + 36].to_vec(),
            format!("byte {}: the file ends before face 1 of 1", header + 36),
        ),
        (
            "b.ply",
            binary(3, &[0, 1, 2])[..header + 30].to_vec(),
            format!("byte {}: the file ends in the middle of vertex 3 of 3", header + 30),
        ),
        ("b.ply", binary(2, &[0, 1]), "has no faces".into()),
        ("b.ply", nan, format!("byte {}: vertex 2: y is NaN", header + 12)),
        ("o.obj", obj(far), "line 4: face 1: index 9 is out of range (3 vertices)".into()),
        ("o.obj", obj("f 1 2 3\nf -4 1 2\n"), "line 5: face 2: index -4 is out of range (3 vertices)".into()),
        ("o.obj", obj("f 0 1 2\n"), "line 4: face 1: index 0 (OBJ counts from 1)".into()),
        ("o.obj", obj("f 1 2 x\n"), "line 4: face 1: 'x' is not an index".into()),
        ("o.obj", obj("f 1 2 3x\n"), "line 4: face 1: the index 3 runs on into other characters".into()),
        (
            "o.obj",
            obj("f 1 2 99999999999999999999\n"),
            "line 4: face 1: '99999999999999999999' is not an index".into(),
        ),
        ("o.obj", obj("v 1 2\n"), "line 4: expected 3 coordinates, found 2".into()),
        ("o.obj", obj("v 1 2 1.#INF\n"), "line 4: '1.#INF' is not a number".into()),
        ("o.obj", obj("v 1 2 inf\n"), "line 4: vertex 4: z is inf".into()),
        (
            "o.obj",
            obj("v 1 2 1e39\nf 1 2 3\n"),
            "has z from 0e0 to 1e39, beyond the range of single precision".into(),
        ),
        ("o.obj", obj(""), "has no faces".into()),
        ("o.obj", obj("f 1 2\n"), "has no faces".into()),
    ] {
        assert_eq!(refusal(name, &bytes), format!("{name}: {expected}"));
    }
}

#[test]
fn absurd_sizes_are_refused_without_taking_memory() {
    let trillion = "1000000000000";
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let expected = "x.ply: declares 1000000000000 vertices; at most 4294967295 can be read";
        assert_eq!(refusal("x.ply", &ply(encoding, trillion, "1", b"0 0 0\n")), expected);
        // Within 32 bits the bytes that are there decide.
        assert!(refusal("x.ply", &ply(encoding, "4000000000", "1", b"0 0 0\n")).contains("of 4000000000"));
        let body = if encoding == "ascii" { &b"0 0 0\n0 0 0\n0 0 0\n"[..] } else { &[0; 36] };
        let message = refusal("x.ply", &ply(encoding, "3", trillion, body));
        assert!(message.ends_with("the file ends before face 1 of 1000000000000"), "{message}");
        let packed = refusal("x.ply.gz", &gzip(&ply(encoding, "3", trillion, &[b' '; 100_000])));
        assert!(
            packed.contains("the PLY header declares at least") && packed.contains("unpacks to"),
            "{packed}"
        );
    }
    // A list of four thousand million.
    let mut file =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty char x\nproperty char y\n\
        property char z\nelement face 1\nproperty list uint uint vertex_indices\nend_header\n\0\0\0"
            .to_vec();
    file.extend(4_000_000_000u32.to_le_bytes());
    file.extend([0; 12]);
    assert!(
        refusal("x.ply", &file).ends_with("face 1 of 1: a list of 4000000000 items, but 12 bytes follow")
    );
}

#[test]
fn gzip_that_unpacks_beyond_reason_is_refused() {
    let mut bomb = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec();
    bomb.resize(80 << 20, b'\n');
    let packed = gzip(&bomb);
    assert!(packed.len() < 100_000);
    assert_eq!(
        refusal("x.obj.gz", &packed),
        "x.obj.gz: unpacks to more than 64 MiB, over 100 times its size; if that is meant, unpack it first"
    );
}

#[test]
fn damaged_gzip() {
    let whole = gzip(&ply_ascii());
    for cut in 2..whole.len() {
        assert!(refusal("x.ply.gz", &whole[..cut]).starts_with("x.ply.gz: gzip data: "), "{cut}");
    }
    // Past the gzip header a single bit is padding at most in the last byte of the deflate data.
    let mut unnoticed = 0;
    for i in 10..whole.len() {
        let mut flipped = whole.clone();
        flipped[i] ^= 0x10;
        if let Ok(mesh) = read("x.ply.gz", &flipped) {
            assert_eq!(mesh, pyramid(), "byte {i} of {}", whole.len());
            unnoticed += 1;
        }
    }
    assert!(unnoticed <= 1, "{unnoticed} flipped bytes went unnoticed");
    let garbage: Vec<u8> = (0..1000).map(|i| hash2(i, 1) as u8).collect();
    assert!(read("x.ply.gz", &[&b"\x1f\x8b"[..], &garbage].concat()).is_err());
    assert!(refusal("x.gz", &gzip(&gzip(b"v 0 0 0"))).contains("gzip within gzip"));
    assert_eq!(refusal("x.obj.gz", &gzip(b"")), "x.obj.gz: gzip data: is empty once unpacked");
    assert!(refusal("x.ply.gz", &gzip(&garbage)).contains("is none of PLY, OBJ"));
}

#[test]
fn random_bytes_under_any_name() {
    for i in 0..200 {
        let bytes: Vec<u8> = (0..hash2(i, 1) % 3000).map(|k| hash2(k, i + 2) as u8).collect();
        for name in ["x.ply", "x.obj", "x.stl", "x.off", "x.gltf", "x.glb", "x"] {
            assert!(read(name, &bytes).is_err());
            for start in [&b"ply\n"[..], b"OFF\n", b"solid\n", b"glTF\x02\0\0\0", b"{\"asset\":"] {
                assert!(read(name, &[start, &bytes].concat()).is_err());
            }
        }
    }
}

/// What the file gives: the counts and the warnings, or the message without the path.
fn outcome(path: &Path) -> String {
    let mut warnings = Warnings::new();
    match read_mesh(path, &mut warnings) {
        Ok(mesh) => {
            let said: Vec<String> = warnings.iter().map(|w| format!("; {w}")).collect();
            format!("{} v {} t{}", mesh.positions.len(), mesh.triangles.len(), said.concat())
        }
        Err(e) => {
            let message = e.to_string();
            message.strip_prefix(&format!("{}: ", path.display())).unwrap_or(&message).to_owned()
        }
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn the_collected_bad_files_give_an_error_or_a_mesh() {
    let mut seen = 0;
    for folder in ["malformed/mesh", "malformed/gltf"] {
        for entry in std::fs::read_dir(shared_data().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            if name.ends_with(".bin") {
                continue;
            }
            seen += 1;
            assert_eq!(outcome(&path), expected(&name), "{name}");
        }
    }
    assert_eq!(seen, 47);
}

fn expected(name: &str) -> &'static str {
    match name {
        "crash-30d6d0f7.ply" => "line 7: the file ends in the middle of the header (no end_header)",
        "empty.obj" | "empty.ply" | "validator_empty_file.glb" => "the file is empty",
        "ply_empty_header.ply" | "ply_points_ascii.ply" | "points_emptyface.ply" => "has no faces",
        "empty.stl" | "stl_empty_bin.stl" | "invalid-face-definition.obj" => "has no faces",
        "issue-140-zero-face-idx.obj" => "line 16: face 1: index 0 (OBJ counts from 1)",
        "issue-295-trianguation-failure.obj" => "16 v 28 t",
        "issue-319-002.obj" => "20 v 14 t",
        "malformed.obj" => "line 28: face 6: index 0 (OBJ counts from 1)",
        "mni_format_not_wavefront.obj" => {
            "is none of PLY, OBJ, STL, OFF and glTF (begins with 'P 0.3 0.3 0.4 10 1 1558')"
        }
        "nancolor.obj" => "8 v 12 t; colours that are not numbers replaced by white (vertex 7)",
        "notenoughindices.obj" => "3 v 1 t; faces with fewer than three corners dropped (line 9)",
        "test-nan.obj" => "line 12: vertex 1: x is NaN",
        "degtri_sliding.off" => "8 v 8 t",
        "in.off" => "4 v 2 t",
        "invalid.off" => "line 7: face 2 of 4: index 20 is out of range (3 vertices)",
        "negative.off" => "7 v 6 t",
        "out_of_memory.off" => "declares 353535235358 vertices; at most 4294967295 can be read",
        "quads_to_stitch.off" => "20 v 16 t",
        "tetra_intersected_by_triangle.off" => "7 v 5 t",
        "IndexOutOfRange.gltf" => "mesh 0: primitive 0: index 255 is out of range (24 vertices)",
        // The bad number is in a member that nothing here reads, the missing buffer has been supplied.
        "bad_number.gltf" | "missing_bin.gltf" => {
            "24 v 12 t; picture 0 left out: 'CesiumLogoFlat.png': no such file"
        }
        "box_with_infinites.glb" => "mesh 0: primitive 0: vertex 0: x is -inf",
        "no_scene.gltf" => "scene 0: does not exist (0 scenes)",
        "recursive_nodes.gltf" => "node 0: is below itself: its children form a cycle",
        "validator_chunk_too_big.glb" | "validator_truncated_chunk_header.glb" => {
            "byte 13: the file ends before or in the head of a chunk"
        }
        "validator_only_header.glb" => "byte 12: the file ends before or in the head of a chunk",
        "validator_invalid_json_chunk.glb" => "byte 21: JSON: key must be a string",
        "validator_invalid_magic.glb" => {
            "is none of PLY, OBJ, STL, OFF and glTF (begins with bytes 00 00 00 00 00 00 00 00)"
        }
        "validator_no_header.glb" => "is none of PLY, OBJ, STL, OFF and glTF (begins with bytes 00)",
        "validator_length_mismatch.glb" => "byte 8: the GLB header declares 49 bytes of 48",
        "validator_truncated_chunk_data.glb" => "byte 8: the GLB header declares 48 bytes of 47",
        "validator_invalid_uri_data_bytelength.gltf" => "line 12: JSON: missing field `byteLength`",
        // Broken accessors and samplers that no mesh uses.
        "validator_invalid_elements_float.gltf"
        | "validator_invalid_length.gltf"
        | "validator_invalid_sparse_count_and_stride.gltf"
        | "validator_out_of_range_elements_float.gltf"
        | "validator_sampler_output_count_invalid.gltf"
        | "validator_unresolved_sampler_input.gltf"
        | "validator_wrong_bytelength.glb" => "has no faces",
        _ => "this file has no line in the test",
    }
}
