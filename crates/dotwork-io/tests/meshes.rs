//! What the readers make of good files.

mod common;

use common::*;
use dotwork_drawing::hash::{hash2, unit};
use dotwork_io::{MeshFormat, mesh_format_of, read_mesh, write_obj, write_ply};
use dotwork_mesh::RawMesh;

/// The mesh as PLY and as OBJ.
fn written(mesh: &RawMesh) -> [Vec<u8>; 2] {
    let (mut ply, mut obj) = (Vec::new(), Vec::new());
    write_ply(mesh, &mut ply).unwrap();
    write_obj(mesh, &mut obj).unwrap();
    [ply, obj]
}

#[test]
fn all_forms_of_a_pyramid_are_equal() {
    for (name, bytes) in samples() {
        assert_eq!(read(name, &bytes).unwrap(), pyramid(), "{name}");
        assert_eq!(read("no.suffix", &bytes).unwrap(), pyramid(), "{name} without its name");
        assert_eq!(read("lying.stl", &bytes).unwrap(), pyramid(), "{name} under a wrong name");
        assert_eq!(read(name, &gzip(&bytes)).unwrap(), pyramid(), "{name} gzipped");
        let crlf = String::from_utf8(bytes).map(|s| s.replace("\r\n", "\n").replace('\n', "\r\n"));
        if let Ok(crlf) = crlf {
            assert_eq!(read(name, crlf.as_bytes()).unwrap(), pyramid(), "{name} with CRLF");
        }
    }
}

#[test]
fn macintosh_line_ends_and_a_byte_order_mark() {
    let ply = String::from_utf8(ply_ascii()).unwrap().replace('\n', "\r");
    assert_eq!(read("mac.ply", ply.as_bytes()).unwrap(), pyramid());
    let obj = "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r";
    assert_eq!(read("mac.obj", obj.as_bytes()).unwrap().triangles, [[0, 1, 2]]);
    assert_eq!(read("bom.obj", &[b"\xef\xbb\xbf", obj.as_bytes()].concat()).unwrap().triangles, [[0, 1, 2]]);
}

#[test]
fn binary_ply_with_a_crlf_header() {
    let bytes = ply_binary(false);
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = String::from_utf8(bytes[..end].to_vec()).unwrap().replace('\n', "\r\n");
    assert_eq!(read("crlf.ply", &[header.as_bytes(), &bytes[end..]].concat()).unwrap(), pyramid());
}

/// One triangle at (1, 2, 3), (4, 2, 3), (1, 9, 3) with coordinates, counts and indices of the given types.
fn typed(big: bool, coordinate: &str, count: &str, index: &str) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut file = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty {coordinate} z\nproperty {coordinate} y\n\
         property {coordinate} x\nelement face 1\nproperty list {count} {index} vertex_index\nend_header\n"
    )
    .into_bytes();
    let mut put = |kind: &str, value: i8| {
        let bytes: Vec<u8> = match kind {
            "char" | "int8" | "uchar" | "uint8" => vec![value as u8],
            "short" | "int16" | "ushort" | "uint16" => i16::from(value).to_le_bytes().to_vec(),
            "int" | "int32" | "uint" | "uint32" => i32::from(value).to_le_bytes().to_vec(),
            "int64" | "uint64" => i64::from(value).to_le_bytes().to_vec(),
            "float" | "float32" => f32::from(value).to_le_bytes().to_vec(),
            _ => f64::from(value).to_le_bytes().to_vec(),
        };
        if big { file.extend(bytes.iter().rev()) } else { file.extend(bytes) }
    };
    for [x, y, z] in [[1, 2, 3], [4, 2, 3], [1, 9, 3]] {
        [z, y, x].iter().for_each(|&v| put(coordinate, v));
    }
    put(count, 3);
    (0..3).for_each(|i| put(index, i));
    file
}

#[test]
fn every_number_type_of_ply() {
    let integers = [
        "char", "uchar", "short", "ushort", "int", "uint", "int8", "uint8", "int16", "uint16", "int32",
        "uint32", "int64", "uint64",
    ];
    let expected = RawMesh {
        positions: vec![[1.0, 2.0, 3.0], [4.0, 2.0, 3.0], [1.0, 9.0, 3.0]],
        triangles: vec![[0, 1, 2]],
        polygons: 1,
        ..RawMesh::default()
    };
    for big in [false, true] {
        for coordinate in integers.iter().chain(&["float", "double", "float32", "float64"]) {
            assert_eq!(
                read("t.ply", &typed(big, coordinate, "uchar", "int")).unwrap(),
                expected,
                "{coordinate}"
            );
        }
        for count in integers {
            for index in integers {
                assert_eq!(
                    read("t.ply", &typed(big, "float", count, index)).unwrap(),
                    expected,
                    "{count} {index}"
                );
            }
        }
    }
}

#[test]
fn vertices_with_lists_faces_first_and_several_lists() {
    let mut file = b"ply\nformat binary_little_endian 1.0\nelement face 2\nproperty list uchar float texcoord\n\
        property list uchar ushort vertex_indices\nelement vertex 4\nproperty double x\nproperty list int uchar tags\n\
        property double y\nproperty double z\nelement nothing 12345678901234\nelement material 1\nproperty int a\nend_header\n"
        .to_vec();
    for (texcoords, corners) in [(6, vec![0u16, 1, 2, 3]), (0, vec![0, 1, 2])] {
        file.push(texcoords);
        (0..texcoords).for_each(|_| file.extend(0.5f32.to_le_bytes()));
        file.push(corners.len() as u8);
        corners.iter().for_each(|c| file.extend(c.to_le_bytes()));
    }
    for [x, y, z] in [[0.0f64, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
        file.extend(x.to_le_bytes());
        file.extend(2i32.to_le_bytes());
        file.extend([7, 7]);
        file.extend(y.to_le_bytes());
        file.extend(z.to_le_bytes());
    }
    file.extend(5i32.to_le_bytes());
    let mesh = read("lists.ply", &file).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    assert_eq!(mesh.positions, [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(mesh.polygons, 2);
}

#[test]
fn what_is_dropped_is_counted() {
    let (mesh, warnings) = read_with_warnings(
        "w.obj",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1\nf 1 2 3\nf 2 3\nl 1 2\nfancy 1\nfancy 2\n",
    );
    assert_eq!((mesh.triangles.len(), mesh.polygons), (1, 1));
    assert_eq!(
        warnings,
        [
            "points, lines and free-form curves or surfaces ignored (line 7)",
            "2 unknown statements ignored, first at line 8",
            "2 faces with fewer than three corners dropped, first at line 4",
        ]
    );
    let mut ascii = ply_ascii();
    ascii.extend(b"and more\n");
    let (_, warnings) = read_with_warnings("w.ply", &ascii);
    assert_eq!(warnings, ["text after the last element ignored, from line 27"]);
    let mut binary = ply_binary(true);
    binary.extend([0; 7]);
    let (mesh, warnings) = read_with_warnings("w.ply", &binary);
    assert_eq!((mesh, warnings), (pyramid(), vec!["7 bytes after the last element ignored".into()]));
    let mut packed = gzip(&ply_ascii());
    packed.extend(b"junk");
    let (mesh, warnings) = read_with_warnings("w.ply.gz", &packed);
    assert_eq!((mesh, warnings), (pyramid(), vec!["4 bytes after the gzip data ignored".into()]));
}

#[test]
fn faces_may_come_before_their_vertices() {
    let mesh = read("early.obj", b"f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
}

#[test]
fn a_gzip_of_several_members_is_one_file() {
    let bytes = obj();
    let (a, b) = bytes.split_at(50);
    let mut packed = gzip(a);
    packed.extend(gzip(b));
    packed.extend([0; 512]);
    let (mesh, warnings) = read_with_warnings("members.obj.gz", &packed);
    assert_eq!((mesh, warnings), (pyramid(), vec![]));
}

#[test]
fn coordinates_far_from_zero_keep_their_detail() {
    let obj = "v 4321034.515625 512011.25 10\nv 4321035.515625 512011.25 10\nv 4321034.515625 512012.3125 10.5\nf 1 2 3\n";
    let mesh = read("far.obj", obj.as_bytes()).unwrap();
    assert_eq!(mesh.origin, [4_321_035.0, 512_012.0, 10.0]);
    assert_eq!(mesh.positions[0], [-0.484_375, -0.75, 0.0]);
    assert_eq!(mesh.positions[2], [-0.484_375, 0.3125, 0.5]);
    for file in written(&mesh) {
        assert_eq!(read("again", &file).unwrap(), mesh);
    }
}

#[test]
fn writers_round_trip_bit_by_bit() {
    let mut positions: Vec<[f32; 3]> = (0..3000u32)
        .map(|i| [0, 1, 2].map(|k| (unit(hash2(i, k)) - 0.5) * 10f32.powi((hash2(i, 7) % 9) as i32 - 6)))
        .collect();
    positions[0] = [f32::MAX, f32::MIN, f32::MIN_POSITIVE];
    positions[1] = [-0.0, 1e-45, 16_777_217.0];
    let n = positions.len() as u32;
    let triangles: Vec<[u32; 3]> = (0..5000).map(|i| [1, 2, 3].map(|k| hash2(i, k) % n)).collect();
    let mesh = RawMesh { positions, polygons: triangles.len(), triangles, ..RawMesh::default() };
    for file in written(&mesh) {
        let again = read("again", &file).unwrap();
        let bits = |m: &RawMesh| m.positions.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&again), bits(&mesh));
        assert_eq!(again.triangles, mesh.triangles);
    }
}

#[test]
fn formats_of_names() {
    for (name, format) in [
        ("a.ply", Some(MeshFormat::Ply)),
        ("dir.obj/A.PLY", Some(MeshFormat::Ply)),
        ("b.Obj", Some(MeshFormat::Obj)),
        ("c.stl", None),
        ("ply", None),
    ] {
        assert_eq!(mesh_format_of(name.as_ref()), format, "{name}");
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn real_meshes_have_the_counts_that_other_readers_found() {
    for (name, vertices, triangles) in [
        ("dragon_full.ply.gz", 437_645, 871_414),
        ("dragon_res4_bigendian.ply", 5_205, 11_102),
        ("bunny.ply", 35_947, 69_451),
        ("skull_ct.ply", 24_878, 49_999),
        ("brain_pial_left.ply", 10_242, 20_480),
        ("footbones_ascii.ply", 2_154, 4_204),
        ("spot.obj", 2_930, 5_856),
        ("teapot.obj", 3_644, 6_320),
    ] {
        let mut warnings = dotwork_drawing::Warnings::new();
        let mesh = read_mesh(&shared_data().join("meshes").join(name), &mut warnings).unwrap();
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (vertices, triangles), "{name}");
        assert_eq!(mesh.origin, [0.0; 3], "{name}");
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn every_mesh_of_the_shared_data_is_listed_above() {
    let listed = include_str!("meshes.rs");
    for entry in std::fs::read_dir(shared_data().join("meshes")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name.contains(".ply") || name.ends_with(".obj") {
            assert!(listed.contains(&format!("(\"{name}\"")), "{name} has no line in the table");
        }
    }
}
