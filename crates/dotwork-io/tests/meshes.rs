//! What the readers make of good files.

mod common;

use common::*;
use dotwork_drawing::hash::{hash2, unit};
use dotwork_io::{
    MeshFormat, mesh_format_name, mesh_format_of, mesh_formats, read_mesh, write_obj, write_ply,
};
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

/// A triangle in PLY whose vertices have colours of that type; `values` are what the file says, vertex by vertex.
fn colored_ply(big: Option<bool>, kind: &str, names: [&str; 4], values: [[f64; 4]; 3]) -> Vec<u8> {
    let encoding = match big {
        None => "ascii",
        Some(false) => "binary_little_endian",
        Some(true) => "binary_big_endian",
    };
    let names: Vec<&str> = names.into_iter().filter(|n| !n.is_empty()).collect();
    let properties: String = names.iter().map(|n| format!("property {kind} {n}\n")).collect();
    let mut file = format!(
        "ply\nformat {encoding} 1.0\nelement vertex 3\nproperty float x\n{properties}property float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let numbers = |v: usize| {
        let [x, y, z] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]][v];
        let color = values[v][..names.len()].iter().map(|&c| (kind, c));
        [("float", x)].into_iter().chain(color).chain([("float", y), ("float", z)]).collect::<Vec<_>>()
    };
    for (kind, value) in (0..3).flat_map(numbers) {
        let Some(big) = big else {
            file.extend(format!("{value} ").bytes());
            continue;
        };
        let bytes = match kind {
            "uchar" => vec![value as u8],
            "ushort" => (value as u16).to_le_bytes().to_vec(),
            "float" => (value as f32).to_le_bytes().to_vec(),
            _ => value.to_le_bytes().to_vec(),
        };
        if big { file.extend(bytes.iter().rev()) } else { file.extend(bytes) }
    }
    match big {
        // One row a line.
        None => {
            let start = file.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
            let words: Vec<String> =
                String::from_utf8(file.split_off(start)).unwrap().split(' ').map(str::to_owned).collect();
            for row in words.chunks(3 + names.len()).take(3) {
                file.extend((row.join(" ") + "\n").bytes());
            }
            file.extend(b"3 0 1 2\n");
        }
        Some(big) => {
            file.push(3);
            (0..3u32).for_each(|i| file.extend(if big { i.to_be_bytes() } else { i.to_le_bytes() }));
        }
    }
    file
}

#[test]
fn colours_of_ply_vertices_are_kept() {
    const RGB: [&str; 4] = ["red", "green", "blue", ""];
    const RGBA: [&str; 4] = ["red", "green", "blue", "alpha"];
    const DIFFUSE: [&str; 4] = ["diffuse_red", "diffuse_green", "diffuse_blue", ""];
    let bytes = [[255.0, 0.0, 1.0, 0.0], [0.0, 51.0, 0.0, 51.0], [1.0, 1.0, 1.0, 255.0]];
    let scaled = |full: f64| bytes.map(|c| c.map(|v| v / 255.0 * full));
    let opaque = bytes.map(|[r, g, b, _]| [r as u8, g as u8, b as u8, 255]);
    let clear = bytes.map(|c| c.map(|v| v as u8));
    for big in [None, Some(false), Some(true)] {
        for (kind, names, values, colors) in [
            ("uchar", RGB, bytes, opaque),
            ("uchar", RGBA, bytes, clear),
            ("uchar", DIFFUSE, bytes, opaque),
            ("ushort", RGBA, scaled(65535.0), clear),
            ("float", RGB, scaled(1.0), opaque),
            ("float", RGBA, scaled(1.0), clear),
            ("double", RGBA, bytes, clear),
            ("float", ["r", "g", "b", "a"], scaled(1.0), clear),
        ] {
            let mesh = read("c.ply", &colored_ply(big, kind, names, values)).unwrap();
            assert_eq!(mesh.colors, colors, "{big:?} {kind} {names:?}");
            assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        }
        // All white counts as colour, the least number of a byte too; two channels do not.
        let ones = [[1.0; 4]; 3];
        assert_eq!(read("c.ply", &colored_ply(big, "uchar", RGB, ones)).unwrap().colors, [[1, 1, 1, 255]; 3]);
        assert_eq!(read("c.ply", &colored_ply(big, "float", RGB, ones)).unwrap().colors, [[255; 4]; 3]);
        let two = colored_ply(big, "uchar", ["red", "green", "", ""], ones);
        assert_eq!(read("c.ply", &two).unwrap().colors, [[0; 4]; 0]);
    }
}

#[test]
fn triangle_strips_of_ply() {
    let mesh = read("s.ply", &ply_strips()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [3, 2, 0], [0, 2, 1]]);
    assert_eq!((mesh.positions, mesh.polygons), (POSITIONS.to_vec(), 6));
    assert_eq!(mesh.colors[3], [3, 10, 20, 255]);
    let ascii = |strip: &str| {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_index\nelement tristrips 2\n\
             property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n{strip}\n"
        );
        read("s.ply", text.as_bytes())
    };
    let mesh = ascii("7 0 1 2 3 -1 0 1\n3 3 2 1").unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 2], [2, 1, 3], [3, 2, 1]]);
    let message = |strip: &str| ascii(strip).unwrap_err().to_string();
    assert_eq!(
        message("4 0 1 2 4\n0"),
        "s.ply: line 17: tristrips 1 of 2: index 4 is out of range (4 vertices)"
    );
    assert_eq!(
        message("4 0 1 2 -2\n0"),
        "s.ply: line 17: tristrips 1 of 2: index -2 is out of range (4 vertices)"
    );
    assert_eq!(message("4 0 1 2 3"), "s.ply: line 18: the file ends before tristrips 2 of 2");
    let mut binary = ply_strips();
    let last = binary.len() - 4;
    binary[last] = 5;
    assert!(
        read("s.ply", &binary)
            .unwrap_err()
            .to_string()
            .ends_with("tristrips 1 of 1: index 5 is out of range (5 vertices)")
    );
}

#[test]
fn colours_of_obj_vertices_are_kept() {
    let of = |tails: [&str; 3]| {
        let [a, b, c] = tails;
        let text = format!("v 0 0 0{a}\nv 1 0 0{b}\nv 0 1 0{c}\nf 1 2 3\n");
        read_with_warnings("c.obj", text.as_bytes())
    };
    let white = [255; 4];
    for (tails, colors) in [
        ([" 1 0 0", " 0.2 0.2 0.2", " 0 0 1"], vec![[255, 0, 0, 255], [51, 51, 51, 255], [0, 0, 255, 255]]),
        ([" 255 0 0", " 51 51 51", " 0 0 1"], vec![[255, 0, 0, 255], [51, 51, 51, 255], [0, 0, 1, 255]]),
        ([" 1 0 0 1", " 1 0 0 0.2", " 0 0 0 0"], vec![[255, 0, 0, 255], [255, 0, 0, 51], [0; 4]]),
        (["", " 0 1 0 # green", ""], vec![white, [0, 255, 0, 255], white]),
        ([" 1.0", " 0.5", " 1"], vec![]),
        ([" # 1 1 1", " x 1 1 1", ""], vec![]),
    ] {
        let (mesh, warnings) = of(tails);
        assert_eq!((mesh.colors, warnings.len()), (colors, 0), "{tails:?}");
    }
    let (mesh, warnings) = of(["", " nan 0 0", " 0 0 0"]);
    assert_eq!(mesh.colors, [white, white, [0, 0, 0, 255]]);
    assert_eq!(warnings, ["colours that are not numbers replaced by white (vertex 2)"]);
}

#[test]
fn formats_have_names() {
    for (name, bytes, expected) in [
        ("x", ply_ascii(), Some("PLY, text")),
        ("x.obj", ply_binary(false), Some("PLY, binary little endian")),
        ("x", gzip(&ply_binary(true)), Some("PLY, binary big endian, gzipped")),
        ("x", obj(), Some("OBJ")),
        ("x.stl", gzip(&obj()), Some("OBJ, gzipped")),
        ("x", coff(), Some("COFF")),
        ("x.obj", b"hello".to_vec(), None),
        ("x", Vec::new(), None),
    ] {
        assert_eq!(mesh_format_name(name.as_ref(), &bytes).as_deref(), expected, "{name}");
    }
    assert_eq!(mesh_formats(), "PLY, OBJ, STL, OFF and glTF");
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
    let colors: Vec<[u8; 4]> = (0..n).map(|v| hash2(v, 9).to_le_bytes()).collect();
    let opaque = colors.iter().map(|&[r, g, b, _]| [r, g, b, 255]).collect();
    let mesh = RawMesh { positions, polygons: triangles.len(), triangles, ..RawMesh::default() };
    let meshes = [colors, opaque, Vec::new()].map(|colors| RawMesh { colors, ..mesh.clone() });
    for (mesh, file) in meshes.iter().flat_map(|mesh| written(mesh).map(|file| (mesh, file))) {
        let again = read("again", &file).unwrap();
        assert_eq!(again.colors, mesh.colors);
        let bits = |m: &RawMesh| m.positions.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&again), bits(mesh));
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
        ("femur.off", 3_897, 7_798),
        ("hand.off", 1_197, 2_390),
        ("cow.off", 2_904, 5_804),
        ("teapot_binary.stl", 3 * 894, 894),
        ("duck.glb", 2_399, 4_212),
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
        assert!(listed.contains(&format!("(\"{name}\"")), "{name} has no line in the table");
    }
}
