//! Films: coherence and tone while surfaces deform, camera and light move, and the camera comes close.

use std::fs;
use std::path::{Path, PathBuf};

use dotwork::mesh::{RawMesh, shapes};

use crate::gltf::morphing_text;
use crate::measure::{Folder, FrameDots, Ink, Table, all_frame_dots, animate, evenness, popping};

/// Writes a glTF file in which `mesh` becomes `moved` within `seconds`, evenly.
fn morphing(
    folder: &Folder,
    name: &str,
    mesh: &RawMesh,
    moved: impl Fn([f32; 3]) -> [f32; 3],
    seconds: f32,
) -> PathBuf {
    let path = folder.path(name);
    fs::write(&path, morphing_text(mesh, moved, seconds)).unwrap();
    path
}

/// A square from −1 to 1.
fn square() -> RawMesh {
    let mut plate = shapes::plate(8, 8);
    plate.positions.iter_mut().for_each(|p| *p = [2.0 * p[0] - 1.0, 2.0 * p[1] - 1.0, p[2]]);
    let [low, high] =
        plate.positions.iter().fold([f32::MAX, f32::MIN], |[l, h], p| [l.min(p[0]), h.max(p[0])]);
    plate.positions.iter_mut().for_each(|p| {
        for c in &mut p[..2] {
            *c -= 0.5 * (low + high);
        }
    });
    plate
}

/// Aim: with `keep` the ink of a patch that is stretched to twice its length, or its area to four times, stays within
/// ± 5 %; with `follow` it thins, and the very same dots are there before and after.
#[test]
fn a_stretched_patch_keeps_its_ink_or_its_dots() {
    let folder = Folder::new();
    let flat = "--style flat --set tone=0.3 --set dot_size=3px --camera 0,0 --ortho --size 1000 --fps 4";
    for (name, stretch) in [("long", [2.0, 1.0]), ("large", [2.0, 2.0])] {
        let moved = |[x, y, z]: [f32; 3]| [stretch[0] * x, stretch[1] * y, z];
        let film = morphing(&folder, &format!("{name}.gltf"), &square(), moved, 1.0);
        // The sphere around all frames fills 90 % of the page.
        let reach = f64::from(stretch[0]).hypot(f64::from(stretch[1]));
        let scale = 0.45 * 1000.0 / reach;
        let patch = |x: f64, y: f64| (x - 500.0).abs() < 0.9 * scale && (y - 500.0).abs() < 0.9 * scale;
        let inks = |density: &str| -> Vec<f64> {
            animate(&format!("{flat} --frames 0..5 --density {density}"), &film, &folder.path("f-%d.png"));
            (0..5).map(|n| Ink::read(&folder.path(&format!("f-{n}.png"))).mean(patch)).collect()
        };
        let (kept, followed) = (inks("keep"), inks("follow"));
        println!("{name}: ink of a stretched patch, keep {kept:.4?}, follow {followed:.4?}");
        assert!(kept.iter().all(|ink| (ink / 0.3 - 1.0).abs() < 0.05), "{kept:?}");
        // Of so many times the area, the same dots.
        let thinned = 0.3 / f64::from(stretch[0] * stretch[1]);
        assert!((followed[0] / 0.3 - 1.0).abs() < 0.05 && (followed[4] / thinned - 1.0).abs() < 0.08);
        let csv = folder.path("f.csv");
        animate(&format!("{flat} --frames 0..5 --density follow"), &film, &csv);
        let frames = all_frame_dots(&csv);
        let ids = |f: &FrameDots| {
            let mut ids: Vec<u64> = f.keys().copied().collect();
            ids.sort_unstable();
            ids
        };
        assert!(frames[0].len() > 1000 && ids(&frames[0]) == ids(&frames[4]), "the same dots");
    }
}

/// Aim: while a surface deforms, as on a turntable: fewer than 0.02 % of the dots a frame appear or vanish at more than
/// 30 % of full size; each dot that stays rides on its place of the surface.
#[test]
fn coherence_while_a_surface_deforms() {
    let folder = Folder::new();
    let bent = |[x, y, z]: [f32; 3]| {
        let (s, c) = (0.6 * y).sin_cos();
        [1.6 * (c * x - s * z), 0.8 * y, s * x + c * z]
    };
    let film = morphing(&folder, "bent.gltf", &shapes::sphere(5), bent, 2.0);
    let csv = folder.path("f.csv");
    animate("--set visibility=facing --fps 30 --frames 20..32 --ortho --camera 10,5 --csv full", &film, &csv);
    let frames = all_frame_dots(&csv);
    let frames = &frames[20..];
    let pops: Vec<f64> = frames.windows(2).map(|w| popping(&w[0], &w[1])).collect();
    let mean = pops.iter().sum::<f64>() / pops.len() as f64;
    println!("deforming: {} dots, {:.4} % pop in a frame", frames[0].len(), 100.0 * mean);
    assert!(frames[0].len() > 10_000 && mean < 0.0002, "{pops:?}");
    // Where a stipple lies in the film's first frame says where it must lie in the next: places are the sphere's,
    // moved by a known share.
    let table = Table::read(&csv);
    let column = |name: &str| table.columns[name];
    let share = |frame: f64| frame / 60.0;
    let mut worst = 0.0f64;
    for row in &table.rows {
        let [x, y, z] = ["x", "y", "z"].map(|c| row[column(c)]);
        // Undone: y first, which the rest depends on.
        let t = share(row[column("frame")]);
        let y0 = y / (1.0 - t + 0.8 * t);
        let (s, c) = (0.6 * y0).sin_cos();
        let (a, b) = (1.0 - t + 1.6 * t * c, -1.6 * t * s);
        let (d, e) = (t * s, 1.0 - t + t * c);
        let det = a * e - b * d;
        let (x0, z0) = ((e * x - b * z) / det, (a * z - d * x) / det);
        worst = worst.max((1.0 - (x0 * x0 + y0 * y0 + z0 * z0).sqrt()).abs());
    }
    // A flat facet of this sphere lies up to 0.0015 below it; as it bends, facets cut corners.
    println!("dots lie within {worst:.4} radii of the deformed sphere");
    assert!(worst < 0.004, "{worst}");
}

/// Aim: the same for a character whose skin moves, camera and light moving too.
#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn coherence_of_a_character_under_moving_camera_and_light() {
    let folder = Folder::new();
    let man = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/animated/cesiumman.glb"));
    let scene = folder.path("scene.toml");
    // Half a degree a frame of the camera, a degree of the light.
    fs::write(
        &scene,
        format!(
            "[[object]]\nfile = \"{}\"\n[[camera.keys]]\ntime = 0\nazimuth = 20\nelevation = 10\n\
             [[camera.keys]]\ntime = 0.1\nazimuth = 32\nelevation = 10\n\
             [[light.keys]]\ntime = 0\nazimuth = -40\nelevation = 40\n\
             [[light.keys]]\ntime = 0.1\nazimuth = -16\nelevation = 40\n",
            man.display()
        ),
    )
    .unwrap();
    let csv = folder.path("f.csv");
    animate("--set visibility=facing --set dot_size=1px --fps 240 --frames 0..24", &scene, &csv);
    let frames = all_frame_dots(&csv);
    let pops: Vec<f64> = frames.windows(2).map(|w| popping(&w[0], &w[1])).collect();
    let mean = pops.iter().sum::<f64>() / pops.len() as f64;
    println!("character: {} dots, {:.4} % pop in a frame", frames[0].len(), 100.0 * mean);
    assert!(frames[0].len() > 20_000 && mean < 0.0002, "{pops:?}");
}

/// Aim: a zoom film from 1× to 64× keeps the ink of the middle within ± 5 % and the dots even: nothing runs out.
#[test]
fn a_zoom_does_not_run_out() {
    let folder = Folder::new();
    let mesh = folder.mesh("plate.obj", &square());
    let scene = folder.path("scene.toml");
    fs::write(
        &scene,
        "[[object]]\nfile = \"plate.obj\"\n[camera]\ndirection = \"0,0\"\northo = true\n\
         [[camera.keys]]\ntime = 0\nzoom = 1\n[[camera.keys]]\ntime = 6\nzoom = 64\n",
    )
    .unwrap();
    let _ = mesh;
    let options = "--style flat --set tone=0.3 --set dot_size=3px --size 800 --fps 1 --frames 0..7";
    animate(options, &scene, &folder.path("f-%d.png"));
    animate(options, &scene, &folder.path("f.csv"));
    let table = Table::read(&folder.path("f.csv"));
    for n in 0..7 {
        let patch = |x: f64, y: f64| (x - 400.0).abs() < 180.0 && (y - 400.0).abs() < 180.0;
        let ink = Ink::read(&folder.path(&format!("f-{n}.png"))).mean(patch);
        let column = |name: &str| table.columns[name];
        let dots: Vec<[f64; 2]> = table
            .rows
            .iter()
            .filter(|r| r[column("frame")] == f64::from(n))
            .map(|r| [r[column("x_px")], r[column("y_px")]])
            .collect();
        let (count, min, mean) = evenness(&dots, [220.0; 2], [580.0; 2]);
        println!("zoom {}: ink {ink:.4}, {count} dots, min {min:.3} mean {mean:.3}", 1 << n);
        assert!((ink / 0.3 - 1.0).abs() < 0.05 && mean > 0.7, "zoom {}: {ink} {mean}", 1 << n);
    }
}
