//! The bake `hierarchy` on real and on hostile meshes.

mod common;

use std::path::PathBuf;

use common::Place;

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(folder);
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn hierarchies_of_other_peoples_files_never_panic() {
    let place = Place::new();
    for folder in ["malformed/mesh", "meshes"] {
        for file in files(folder) {
            // Its size is for the benchmark.
            if file.ends_with("dragon_full.ply.gz") {
                continue;
            }
            let mut command = place.command();
            command.args(["render", "-o", "out.png", "--bake", "hierarchy", "--quiet"]);
            let output = command.args(["--stipples", "9000", "--size", "64"]).arg(&file).output().unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr);
            // The real ones are drawn; the others may be refused, in one line.
            let refused = folder == "malformed/mesh" && output.status.code() == Some(1);
            assert!(output.status.success() || refused, "{}: {stderr}", file.display());
            assert!(stderr.lines().all(|l| l.starts_with("dotwork: ")), "{}: {stderr}", file.display());
        }
    }
}
