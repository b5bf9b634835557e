//! Poses of animated glTF files against an evaluator that shares nothing with this one: `poses/evaluate.py`, which wrote
//! `poses/poses.json`.
#![cfg(feature = "gltf")]
#![allow(clippy::print_stderr, reason = "the figure is for reading: run with --nocapture")]

use std::path::Path;

use dotwork_drawing::Warnings;
use dotwork_io::{read_file, read_model};
use dotwork_mesh::{Mesh, MeshOptions};
use serde_json::Value;

/// Aim: vertices lie where the other evaluator has them, to within 1e-5 of the size of the pose.
#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn poses_are_those_of_another_evaluator() {
    let text = include_str!("poses/poses.json");
    let poses: Vec<Value> = serde_json::from_str(text).unwrap();
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/animated"));
    let (mut compared, mut worst) = (0, 0.0f64);
    for pose in &poses {
        let path = folder.join(pose["file"].as_str().unwrap());
        let bytes = read_file(&path).unwrap();
        let model = read_model(&path, &bytes, &mut Warnings::new()).unwrap();
        let motion = model.motion.expect("it moves");
        let (clip, time) = (pose["clip"].as_u64().unwrap() as usize, pose["time"].as_f64().unwrap());
        let mut positions = Vec::new();
        motion.place(Some(clip), time, &mut positions);
        assert_eq!(positions.len() as u64, pose["vertices"].as_u64().unwrap());
        assert_eq!(positions.len(), model.mesh.positions.len());
        let size = pose["size"].as_f64().unwrap();
        for (vertex, place) in pose["places"].as_object().unwrap() {
            let found = positions[vertex.parse::<usize>().unwrap()];
            for k in 0..3 {
                let expected = place[k].as_f64().unwrap();
                let off = (f64::from(found[k]) + model.mesh.origin[k] - expected).abs() / size;
                assert!(off <= 1e-5, "{} at {time} s: vertex {vertex} is off by {off:e}", path.display());
                worst = worst.max(off);
                compared += 1;
            }
        }
    }
    eprintln!("{} poses, {compared} coordinates, worst {worst:.1e} of the size", poses.len());
    assert!(poses.len() >= 50 && compared > 5000);
}

/// Aim: seams whose vertices list the same joints in another order are closed. This tube has 448 places; 64 of them, at one
/// ring, have two vertices whose weights truly differ.
#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn seams_that_move_alike_are_closed() {
    let path =
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/animated/riggedsimple.glb"));
    let bytes = read_file(path).unwrap();
    let model = read_model(path, &bytes, &mut Warnings::new()).unwrap();
    let mesh = Mesh::build(model.mesh, &MeshOptions::default(), &mut Warnings::new()).unwrap();
    assert_eq!((mesh.positions.len(), mesh.topology().boundary_edges()), (448 + 64, 128));
}
