//! What the readers say of bad files: never a panic, always the file, the place and the reason.

mod common;

use common::*;
use dotwork_drawing::Warnings;
use dotwork_drawing::hash::hash2;
use dotwork_io::dots::{Reader, Writer};
use dotwork_io::{read_file, read_mesh};

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

#[test]
fn files_that_are_no_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("empty.ply"), b"").unwrap();
    std::fs::create_dir(at("series")).unwrap();
    for (name, reason) in [
        ("missing.ply", "no such file"),
        ("empty.ply", "the file is empty"),
        ("series", "is a directory (DICOM and TIFF series are not read yet)"),
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
    let mut stl = [0; 84 + 100];
    stl[80] = 2;
    let empty_dots = Writer::new().finish();
    for (name, content, expected) in [
        ("x", &b"solid cube\n facet normal"[..], "is an STL file, which is not read yet; PLY and OBJ are"),
        ("x", &stl[..], "is an STL file, which is not read yet; PLY and OBJ are"),
        ("x.ply", b"OFF\n3 1 0\n", "is an OFF file, which is not read yet; PLY and OBJ are"),
        ("x", b"glTF\x02\0\0\0", "is a glTF binary (GLB), which is not read yet; PLY and OBJ are"),
        ("x.gltf", b"{ \"asset\": {} }", "is a glTF file, which is not read yet; PLY and OBJ are"),
        ("x", b"NRRD0004\n", "is an NRRD volume, which is not read yet; PLY and OBJ are"),
        ("x", &dicom, "is a DICOM file, which is not read yet; PLY and OBJ are"),
        ("x", &nifti, "is a NIfTI volume, which is not read yet; PLY and OBJ are"),
        ("x.vm", b"_0 var-x\n", "is an implicit model, which is not read yet; PLY and OBJ are"),
        ("x", &empty_dots, "is a .dots file, not a mesh"),
        ("x.ply", b"hello world\n", "is neither PLY nor OBJ (begins with 'hello world')"),
        ("x.obj", b"\x00\x01\xff\x80", "is neither PLY nor OBJ (begins with bytes 00 01 ff 80)"),
        ("x.obj", b"# only a comment\n", "has no faces"),
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
    assert!(refusal("x.ply.gz", &gzip(&garbage)).contains("is neither PLY nor OBJ"));
}

#[test]
fn truncated_at_every_byte() {
    for (name, bytes) in samples() {
        for cut in 0..bytes.len() {
            let result = read(name, &bytes[..cut]);
            // An OBJ cut between statements is a smaller OBJ; a PLY declares its size.
            if name.ends_with("ply") && cut + 1 < bytes.len() {
                assert!(result.is_err(), "{name} cut at {cut}");
            }
        }
    }
}

#[test]
fn random_bytes_under_any_name() {
    for i in 0..200 {
        let bytes: Vec<u8> = (0..hash2(i, 1) % 3000).map(|k| hash2(k, i + 2) as u8).collect();
        for name in ["x.ply", "x.obj", "x"] {
            assert!(read(name, &bytes).is_err());
            assert!(read(name, &[b"ply\n", &bytes[..]].concat()).is_err());
        }
    }
}

/// One of: cut, some bytes changed, a number made absurd, a piece repeated.
fn mutate(sample: &[u8], seed: u32) -> Vec<u8> {
    let random = |k: u32| hash2(k, seed) as usize;
    let mut bytes = sample.to_vec();
    match random(0) % 4 {
        0 => bytes.truncate(random(1) % sample.len()),
        1 => {
            for k in 0..1 + random(2) as u32 % 6 {
                bytes[random(10 + k) % sample.len()] = random(20 + k) as u8;
            }
        }
        2 => {
            const ABSURD: [&[u8]; 8] = [
                b"4294967295",
                b"99999999999999999999",
                b"-1",
                b"1e309",
                b"nan",
                b"18446744073709551615",
                b"0",
                b"\xff\xff\xff\xff",
            ];
            let digits: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
            let at = digits[random(3) % digits.len()];
            bytes.splice(at..at + 1, ABSURD[random(4) % ABSURD.len()].iter().copied());
        }
        _ => {
            let from = random(5) % sample.len();
            let to = sample.len().min(from + random(6) % 40);
            let at = random(7) % sample.len();
            bytes.splice(at..at, sample[from..to].to_vec());
        }
    }
    bytes
}

#[test]
fn three_thousand_mutations_of_each_sample_do_not_panic() {
    for (name, sample) in samples() {
        let mut accepted = 0;
        for seed in 0..3000 {
            let bytes = mutate(&sample, seed);
            match read(name, &bytes) {
                Ok(mesh) => {
                    accepted += 1;
                    let n = mesh.positions.len() as u32;
                    assert!(mesh.triangles.iter().flatten().all(|&i| i < n), "{name}, seed {seed}");
                    assert!(mesh.positions.iter().flatten().all(|v| v.is_finite()), "{name}, seed {seed}");
                }
                Err(e) => assert!(!e.to_string().contains('\n'), "{name}, seed {seed}"),
            }
            if seed % 10 == 0 {
                let _ = read(name, &mutate(&gzip(&sample), seed + 1_000_000));
            }
        }
        // The mutations reach past the header: some leave a readable mesh, many do not.
        assert!((30..2900).contains(&accepted), "{name}: {accepted} of 3000 accepted");
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn the_collected_bad_files_give_an_error_or_a_mesh() {
    let mut seen = 0;
    for entry in std::fs::read_dir(shared_data().join("malformed/mesh")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let result = read_mesh(&path, &mut Warnings::new());
        if !(name.ends_with(".ply") || name.ends_with(".obj")) {
            assert!(result.is_err(), "{name} is not read yet");
            continue;
        }
        seen += 1;
        let found = match result {
            Ok(mesh) => format!("{} v {} t", mesh.positions.len(), mesh.triangles.len()),
            Err(e) => e.to_string().rsplit_once(&format!("{name}: ")).unwrap().1.to_owned(),
        };
        let expected = match name.as_str() {
            "crash-30d6d0f7.ply" => "line 7: the file ends in the middle of the header (no end_header)",
            "empty.obj" | "empty.ply" => "the file is empty",
            "ply_empty_header.ply" | "ply_points_ascii.ply" | "points_emptyface.ply" => "has no faces",
            "invalid-face-definition.obj" => "has no faces",
            "issue-140-zero-face-idx.obj" => "line 16: face 1: index 0 (OBJ counts from 1)",
            "issue-295-trianguation-failure.obj" => "16 v 28 t",
            "issue-319-002.obj" => "20 v 14 t",
            "malformed.obj" => "line 28: face 6: index 0 (OBJ counts from 1)",
            "mni_format_not_wavefront.obj" => {
                "is neither PLY nor OBJ (begins with 'P 0.3 0.3 0.4 10 1 1558')"
            }
            "nancolor.obj" => "8 v 12 t",
            "notenoughindices.obj" => "3 v 1 t",
            "test-nan.obj" => "line 12: vertex 1: x is NaN",
            _ => "this file has no line in the test",
        };
        assert_eq!(found, expected, "{name}");
    }
    assert!(seen >= 15);
}
