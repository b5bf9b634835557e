//! Bad inputs and bad outputs: one clear line that names the file, exit code 1, nothing left behind.

mod common;

use common::{Place, box_obj, data, ply};

const SQUARE: &[[f64; 3]] = &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
const TWO: &[[i64; 3]] = &[[0, 1, 2], [0, 2, 3]];

/// Bytes without any order, the same every time.
fn noise(n: u32) -> Vec<u8> {
    (0..n).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8 ^ i as u8).collect()
}

fn declaring(vertices: &str, faces: &str) -> String {
    format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\nabcdefgh"
    )
}

/// Every command that reads, on one bad input.
#[track_caller]
fn refused(place: &Place, input: &str, parts: &[&str]) {
    let before = place.names();
    let parts = [&[input][..], parts].concat();
    // A gibibyte of address space: nothing may be allocated for what a header merely claims.
    let limit = if cfg!(target_os = "linux") { "ulimit -v 1048576" } else { ":" };
    for line in [
        format!("render {input} -o out.png"),
        format!("render {input} -o out.csv --csv full"),
        format!("bake {input} -o out.dots"),
        format!("info {input}"),
        format!("bench {input}"),
    ] {
        place.run_after(limit, &format!("{line} --threads 2")).failed(1, &parts);
        assert_eq!(place.names(), before, "{line} left something behind");
    }
}

#[test]
fn bad_meshes_are_refused() {
    let good = ply(SQUARE, TWO);
    let nan = good.replace("1 1 0\n", "1 nan 0\n");
    let infinite = good.replace("1 1 0\n", "1 inf 0\n");
    let flat = ply(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], &[[0, 1, 2]]);
    let cases: Vec<(&str, Vec<u8>, &[&str])> = vec![
        ("empty.ply", Vec::new(), &["empty"]),
        ("noise.ply", noise(5000), &[]),
        ("noise.obj", noise(5000), &[]),
        ("short.ply", good.as_bytes()[..good.len() - 12].to_vec(), &[]),
        ("claims.ply", declaring("1000000000000", "1").into(), &[]),
        ("claims-faces.ply", declaring("0", "1000000000000").into(), &[]),
        ("claims-more.ply", declaring("99999999999999999999999", "1").into(), &[]),
        ("index.ply", ply(SQUARE, &[[0, 1, 2], [0, 2, 4]]).into(), &["4"]),
        ("negative.ply", ply(SQUARE, &[[0, 1, -2]]).into(), &["-2"]),
        ("nan.ply", nan.into(), &[]),
        ("infinite.ply", infinite.into(), &[]),
        ("flat.ply", flat.into(), &["area"]),
        ("points.ply", ply(SQUARE, &[]).into(), &[]),
        ("far.obj", "v 1 0 9\nf 1 2 3\n".into(), &["line 2"]),
        ("prose.txt", "Once upon a time there was a mesh.\n".into(), &[]),
    ];
    for (name, content, parts) in cases {
        let place = Place::new();
        place.write(name, content);
        refused(&place, name, parts);
    }
}

#[test]
fn bad_files_of_every_format_are_refused() {
    let stl = [&[0; 80][..], &u32::MAX.to_le_bytes(), &[0; 100]].concat();
    let mut nifti = vec![0; 400];
    nifti[..4].copy_from_slice(&348i32.to_le_bytes());
    for (k, v) in [3i16, 30_000, 30_000, 30_000].into_iter().enumerate() {
        nifti[40 + 2 * k..][..2].copy_from_slice(&v.to_le_bytes());
    }
    nifti[70..74].copy_from_slice(&[2, 0, 8, 0]);
    nifti[108..112].copy_from_slice(&352f32.to_le_bytes());
    nifti[344..348].copy_from_slice(b"n+1\0");
    let nrrd = |fields: &str| format!("NRRD0004\n{fields}\n\nabc");
    let huge = "type: double\ndimension: 3\nsizes: 1000000 1000000 1000000";
    let mha = "ObjectType = Image\nNDims = 3\nDimSize = 90000 90000 90000\nElementType = MET_FLOAT\n\
               ElementDataFile = LOCAL\n";
    let vtk = "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 90000 90000 90000\n\
               ORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 729000000000000\nSCALARS v float\nLOOKUP_TABLE default\n";
    let gltf = |body: &str| format!("{{\"asset\":{{\"version\":\"2.0\"}},{body}}}");
    let cases: Vec<(&str, Vec<u8>, &[&str])> = vec![
        ("claims.stl", stl, &[]),
        ("cut.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0".into(), &["line 4"]),
        ("claims.off", "OFF\n99999999999 1 0\n0 0 0\n".into(), &[]),
        ("index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n".into(), &["line 6", "3"]),
        ("cut.gltf", "{\"asset\":{\"version\":".into(), &[]),
        (
            "loop.gltf",
            gltf("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"children\":[0]}]").into(),
            &["node 0"],
        ),
        ("draco.gltf", gltf("\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]").into(), &["draco"]),
        ("future.gltf", "{\"asset\":{\"version\":\"9.0\"}}".into(), &["another version"]),
        ("cut.glb", b"glTF\x02\0\0\0\xff\xff\xff\x7f".to_vec(), &[]),
        ("claims.nrrd", nrrd(&format!("{huge}\nencoding: raw")).into(), &[]),
        ("packed.nrrd", nrrd(&format!("{huge}\nencoding: gzip")).into(), &[]),
        ("type.nrrd", nrrd("type: quaternion\ndimension: 1\nsizes: 3\nencoding: raw").into(), &["line 2"]),
        (
            "apart.nhdr",
            nrrd("type: uchar\ndimension: 1\nsizes: 3\nencoding: raw\ndata file: no.raw").into(),
            &["no.raw"],
        ),
        ("claims.nii", nifti, &[]),
        ("claims.mha", mha.into(), &[]),
        ("claims.vtk", vtk.into(), &[]),
        ("mesh.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n".into(), &["POLYDATA"]),
        ("cut.tif", b"II*\0\xff\xff\xff\x7f".to_vec(), &[]),
        ("other.png", b"\x89PNG\r\n\x1a\n".to_vec(), &["settings"]),
        ("other.pdf", b"%PDF-1.7\n".to_vec(), &["settings"]),
        ("scan.dcm", [&[0; 128][..], b"DICM"].concat(), &["DICOM"]),
        ("both.dcm", [&b"II*\0"[..], &[0; 124], b"DICM"].concat(), &["DICOM"]),
    ];
    for (name, content, parts) in cases {
        let place = Place::new();
        place.write(name, content);
        refused(&place, name, parts);
    }
}

#[test]
fn what_is_no_file_is_refused() {
    let place = Place::new();
    refused(&place, "missing.ply", &["no such file"]);
    std::fs::create_dir(place.path("folder.ply")).unwrap();
    refused(&place, "folder.ply", &["directory"]);
}

#[test]
fn bad_dots_files_are_refused() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0; 3]));
    place.run("bake box.obj -o good.dots --stipples 2000").ok();
    let good = place.read("good.dots");
    let with = |at: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[at] ^= value;
        bytes
    };
    place.write("version.dots", with(8, 2));
    place.write("table.dots", with(40, 1));
    place.write("flipped.dots", with(good.len() / 2, 64));
    place.write("last.dots", with(good.len() - 1, 1));
    place.write("half.dots", &good[..good.len() / 2]);
    place.write("head.dots", &good[..6]);
    place.write("longer.dots", [&good[..], b"more"].concat());
    place.write("foreign.dots", box_obj([0.0; 3], [1.0; 3]));
    place.write("noise.dots", noise(3000));
    place.write("empty.dots", "");
    for (name, reason) in [
        ("version.dots", "version 3"),
        ("table.dots", "checksum"),
        ("flipped.dots", "checksum"),
        ("last.dots", "checksum"),
        ("half.dots", "truncated"),
        ("head.dots", "truncated"),
        ("longer.dots", "valid"),
        ("foreign.dots", "not a .dots file"),
        ("noise.dots", "not a .dots file"),
        ("empty.dots", "empty"),
    ] {
        refused(&place, name, &[reason]);
    }
}

#[test]
fn names_that_break_lines_do_not_break_the_message() {
    let place = Place::new();
    place.write("a\nb.ply", "ply\n");
    let output = place.command().args(["info", "a\nb.ply"]).output().unwrap();
    common::Done::of(output, "info a\\nb.ply").failed(1, &["a\\nb.ply"]);
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_the_work() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0; 3]));
    std::fs::create_dir(place.path("folder.png")).unwrap();
    let before = place.names();
    // The input is missing, but what is said is about the output: it is looked at first.
    place.run("render missing.obj -o folder.png").failed(1, &["folder.png", "folder"]);
    place.run("render missing.obj -o no/such.png").failed(1, &["no/such.png", "does not exist"]);
    place.run("bake missing.obj -o no/such.dots").failed(1, &["no/such.dots", "does not exist"]);
    place.run("demo torus -o no/such.ply").failed(1, &["no/such.ply", "does not exist"]);
    if cfg!(target_os = "linux") {
        place.run("render missing.obj -o /proc/such.png").failed(1, &["/proc/such.png"]);
    }
    assert_eq!(place.names(), before);
}

#[test]
fn an_input_is_not_overwritten() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0; 3]));
    place.run("bake box.obj -o box.dots --stipples 1000").ok();
    let before = place.read("box.dots");
    place.run("bake box.dots -o box.dots").failed(2, &["box.dots", "overwrite"]);
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("box.dots", place.path("link.dots")).unwrap();
        place.run("bake box.dots -o ./link.dots").failed(2, &["overwrite"]);
    }
    assert_eq!(place.read("box.dots"), before);
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_one_line_and_leaves_nothing() {
    let place = Place::new();
    place.write("box.obj", box_obj([0.0; 3], [1.0; 3]));
    place.write("old.png", "old");
    let before = place.names();
    for (limit, line, name) in [
        ("ulimit -f 8", "render box.obj -o new.png --stipples 5000", "new.png"),
        ("ulimit -f 8", "render box.obj -o old.png --stipples 5000", "old.png"),
        ("ulimit -f 8", "render box.obj -o new.csv --stipples 5000", "new.csv"),
        ("ulimit -f 8", "bake box.obj -o new.dots --stipples 5000", "new.dots"),
        ("ulimit -f 8", "demo teapot -o new.ply", "new.ply"),
    ] {
        place.run_after(limit, line).failed(1, &[name, "larger than"]);
        assert_eq!(place.names(), before, "{line}");
    }
    assert_eq!(place.text("old.png"), "old");
    if cfg!(target_os = "linux") {
        std::os::unix::fs::symlink("/dev/full", place.path("full.png")).unwrap();
        place.run("render box.obj -o full.png --stipples 500").failed(1, &["full.png", "disk is full"]);
    }
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_gone_is_no_error() {
    let place = Place::new();
    for line in
        ["styles --keys", "styles --json", "man", "completions bash", "demo", "--help", "info demo:sphere"]
    {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = place.command().args(line.split(' ')).stdout(writer).output().unwrap();
        common::Done::of(output, line).ok();
    }
}

#[cfg(unix)]
#[test]
fn a_signal_while_writing_leaves_nothing() {
    use std::os::unix::process::ExitStatusExt;

    let place = Place::new();
    // The reader of this pipe stops reading, so that the command is still writing when the signal comes.
    let made = std::process::Command::new("mkfifo").arg(place.path("pipe.csv")).status().unwrap();
    assert!(made.success());
    let line = "render demo:sphere -o pipe.csv --stipples 30000 --threads 1";
    let mut child = place.command().args(line.split(' ')).spawn().unwrap();
    let mut pipe = std::fs::File::open(place.path("pipe.csv")).unwrap();
    let mut first = [0; 64];
    std::io::Read::read_exact(&mut pipe, &mut first).unwrap();
    let killed =
        std::process::Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    drop(pipe);
    assert_eq!(child.wait().unwrap().signal(), Some(15));
    assert_eq!(place.names(), ["pipe.csv"]);
}

#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
#[test]
fn malformed_files_of_others_never_panic() {
    let place = Place::new();
    let mut seen = 0;
    let folders = ["mesh", "gltf", "volume"].map(|f| data().join("malformed").join(f));
    for entry in folders.iter().flat_map(|f| std::fs::read_dir(f).unwrap()) {
        let path = entry.unwrap().path();
        let output = place.command().arg("info").arg(&path).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}: {stderr}", path.display());
        assert!(stderr.lines().all(|l| l.starts_with("dotwork: ")), "{}: {stderr}", path.display());
        assert_eq!(output.status.success(), !output.stdout.is_empty(), "{}", path.display());
        seen += 1;
    }
    assert!(seen > 50);
}

/// Meshes that others found to break programs, where they can be read at all, and slivers: drawn by lists of faces.
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
#[test]
fn faces_of_malformed_meshes_never_panic() {
    let place = Place::new();
    let corners: Vec<[f64; 3]> = (0..12)
        .flat_map(|i| {
            [[f64::from(i), 0.0, 0.0], [f64::from(i) + 1e-6, 10f64.powi(-i), 1.0], [0.0, 1e3, 1e-7]]
        })
        .collect();
    let slivers: Vec<[i64; 3]> = (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    place.write("slivers.ply", ply(&corners, &slivers));
    let mut paths = vec![place.path("slivers.ply")];
    let folder = std::fs::read_dir(data().join("malformed/mesh")).unwrap();
    paths.extend(folder.map(|entry| entry.unwrap().path()));
    let mut drawn = 0;
    for path in paths {
        for style in ["papers-surface", "soft"] {
            let options =
                ["--bake", "face", "--style", style, "--size", "100", "--stipples", "2000", "-o", "o.csv"];
            let output = place.command().arg("render").arg(&path).args(options).output().unwrap();
            let stderr = String::from_utf8(output.stderr).unwrap();
            assert!(matches!(output.status.code(), Some(0 | 1)), "{}: {stderr}", path.display());
            assert!(stderr.lines().all(|l| l.starts_with("dotwork: ")), "{}: {stderr}", path.display());
            drawn += usize::from(output.status.success());
        }
    }
    assert!(drawn > 4, "{drawn}");
}
