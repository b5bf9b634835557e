//! Files that were damaged in thousands of ways: every reader says what is wrong, or reads what can be read.
//!
//! Memory: the readers reserve by the bytes that are there (see the `most` in each of them), which the absurd sizes
//! among the mutations would otherwise turn into an abort of this very test.

mod common;
#[path = "common/mutate.rs"]
mod mutate;

use common::*;
use dotwork_io::{mesh_facts, mesh_format_name};
use mutate::mutate;
use std::path::{Path, PathBuf};

/// Reads a damaged file; true if a mesh came out of it. Whatever comes out must be sound.
fn survives(name: &str, bytes: &[u8], what: &str) -> bool {
    let _ = mesh_format_name(Path::new(name), bytes);
    assert!(!mesh_facts(Path::new(name), bytes).iter().any(|(_, text)| text.contains('\n')), "{what}");
    match read(name, bytes) {
        Ok(mesh) => {
            let n = mesh.positions.len();
            assert!(!mesh.triangles.is_empty(), "{what}");
            assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < n), "{what}");
            assert!(mesh.positions.iter().flatten().all(|v| v.is_finite()), "{what}");
            assert!(mesh.colors.is_empty() || mesh.colors.len() == n, "{what}");
            true
        }
        Err(e) => {
            let message = e.to_string();
            assert!(!message.contains('\n') && message.len() < 1000, "{what}: {message:?}");
            false
        }
    }
}

#[test]
fn three_thousand_mutations_of_each_sample() {
    for (name, sample) in all_samples() {
        assert!(survives(name, &sample, name), "{name} itself");
        let mut accepted = 0;
        for seed in 0..3000 {
            let what = format!("{name}, seed {seed}");
            accepted += usize::from(survives(name, &mutate(&sample, seed), &what));
            if seed % 10 == 0 {
                survives(name, &mutate(&gzip(&sample), seed + 1_000_000), &what);
                survives("no_name", &mutate(&sample, seed + 2_000_000), &what);
            }
        }
        // The mutations reach past the header: some leave a readable mesh, many do not.
        assert!((30..2900).contains(&accepted), "{name}: {accepted} of 3000 accepted");
    }
}

#[test]
fn truncated_at_every_byte() {
    for (name, bytes) in all_samples() {
        for cut in 0..bytes.len() {
            let read = survives(name, &bytes[..cut], &format!("{name} cut at {cut}"));
            // OBJ and text STL cut between statements are smaller ones; the others declare their size.
            let declared = !name.ends_with("obj") && name != "text.stl";
            // The last byte may be a line end, the opacity of a colour or a digit of an index.
            assert!(!(declared && read && cut + 4 < bytes.len()), "{name} cut at {cut}");
        }
    }
}

/// The meshes of the shared data, folder by folder, that are small enough.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    const LARGEST: u64 = 300_000;
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files(&path, found);
        } else if path.metadata().unwrap().len() < LARGEST
            && !matches!(path.extension().and_then(|e| e.to_str()), Some("bin" | "jpg"))
        {
            found.push(path);
        }
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn mutations_of_real_files() {
    let mut found = Vec::new();
    for folder in ["meshes", "animated", "malformed/mesh", "malformed/gltf"] {
        files(&shared_data().join(folder), &mut found);
    }
    let mut accepted = 0;
    for path in &found {
        let (name, bytes) = (path.to_str().unwrap(), std::fs::read(path).unwrap());
        if bytes.is_empty() {
            continue;
        }
        // As many for each as take about the same time.
        let count = (3_000_000 / bytes.len() as u32).clamp(20, 150);
        for seed in 0..count {
            accepted += usize::from(survives(name, &mutate(&bytes, seed), &format!("{name}, seed {seed}")));
        }
        for part in 1..16 {
            let cut = bytes.len() * part / 16;
            survives(name, &bytes[..cut], &format!("{name} cut at {cut}"));
        }
    }
    assert!(found.len() > 55 && accepted > 200, "{} files, {accepted} accepted", found.len());
}
