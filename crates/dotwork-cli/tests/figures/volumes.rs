//! Volumes: the phantoms' known forms, the two bakes against each other, and coherence with everything on.

use std::path::{Path, PathBuf};
use std::process::Command;

use dotwork::io::volume::write_nrrd;
use dotwork::volume::phantom::{BOX_HALF, box_phantom};
use dotwork::volume::{Affine, Samples, Scaling, Volume};

use crate::measure::{Folder, FrameDots, Ink, Table, dotwork, evenness, frame_dots, popping, rms_and_worst};

fn nrrd(folder: &Folder, name: &str, volume: &Volume) -> PathBuf {
    let path = folder.path(name);
    write_nrrd(volume, std::fs::File::create(&path).unwrap()).unwrap();
    path
}

fn places(path: &Path) -> Vec<[f64; 2]> {
    let table = Table::read(path);
    table.column("x_px").into_iter().zip(table.column("y_px")).map(|(x, y)| [x, y]).collect()
}

/// Aim: on the isosurface of a plane that lies along no axis, seen face on, the evenness of a plate.
#[test]
fn a_plane_in_a_volume_is_as_even_as_a_plate() {
    let folder = Folder::new();
    let csv = folder.path("plane.csv");
    for tone in [0.05, 0.1, 0.2, 0.4] {
        // The eye on the plane's normal, (1, 2, 2) / 3.
        let options = format!(
            "--camera 26.5651,41.8103 --ortho --size 2048x2048 --style flat --stipples 150000 --set tone={tone} \
             --set fade=off --set dot_size=3px --set cap=false"
        );
        dotwork(&options, Path::new("demo:plane"), &csv);
        let dots = places(&csv);
        let (n, min, mean) = evenness(&dots, [624.0; 2], [1424.0; 2]);
        println!("plane phantom at {tone}: {n} dots, min {min:.3} mean {mean:.3}");
        assert!(n > 500 && min >= 0.67 && mean >= 0.785, "tone {tone}: min {min} mean {mean}");
    }
}

/// Aim: on a face of a box, along the grid and off it, the density within ± 10 % everywhere: no torn patches.
#[test]
fn the_face_of_a_box_has_one_density_along_the_grid_and_off_it() {
    let folder = Folder::new();
    let csv = folder.path("box.csv");
    for angle in [0.0f32, 33.0] {
        let volume = nrrd(&folder, "box.nrrd", &box_phantom(angle));
        let turn = glam::Quat::from_axis_angle(glam::Vec3::ONE.normalize(), angle.to_radians());
        let normal = turn * glam::Vec3::Z;
        let (azimuth, elevation) = (normal.x.atan2(normal.z).to_degrees(), normal.y.asin().to_degrees());
        let options = format!(
            "--camera={azimuth},{elevation} --ortho --size 1600x1600 --style flat --stipples 300000 --up y \
             --set tone=0.3 --set fade=off --set dot_size=3px --set outlines=false"
        );
        dotwork(&options, &volume, &csv);
        // A circle on the face whose radius is nine tenths of the shorter half side.
        let scale = 0.45 * 1600.0 / f64::from(glam::Vec3::from_array(BOX_HALF).length());
        let half = 0.9 * f64::from(BOX_HALF[1]) * scale / 2f64.sqrt();
        let (low, side) = (800.0 - half, 2.0 * half / 5.0);
        let mut counts = vec![0.0; 25];
        for [x, y] in places(&csv) {
            let (i, j) = (((x - low) / side).floor(), ((y - low) / side).floor());
            if (0.0..5.0).contains(&i) && (0.0..5.0).contains(&j) {
                counts[i as usize + 5 * j as usize] += 1.0;
            }
        }
        let mean = counts.iter().sum::<f64>() / 25.0;
        let worst = counts.iter().map(|c| (c / mean - 1.0).abs()).fold(0.0, f64::max);
        println!("box turned by {angle}: {mean:.0} dots a block, worst block off by {:.1} %", 100.0 * worst);
        assert!(mean > 300.0 && worst <= 0.10, "{angle}: {counts:?}");
    }
}

/// Aim: slices three times as far apart as pixels leave no terraces in the tone.
#[test]
fn thick_slices_shade_as_thin_ones() {
    let folder = Folder::new();
    let (radius, size) = (40.0f64, [96, 96, 32]);
    let sample = |i: usize| {
        let at = |k: usize, axis: usize, step: f64| (k as f64 - (size[axis] as f64 - 1.0) / 2.0) * step;
        let [x, y, z] = [i % 96, i / 96 % 96, i / (96 * 96)];
        let r = (at(x, 0, 1.0).powi(2) + at(y, 1, 1.0).powi(2) + at(z, 2, 3.0).powi(2)).sqrt();
        // A scanner's soft edge, as wide as a slice is thick.
        (1000.0 / (1.0 + ((r - radius) / 0.9).exp())) as f32
    };
    let samples = Samples::F32((0..size.iter().product()).map(sample).collect());
    let affine = Affine::from_spacing([1.0, 1.0, 3.0]);
    let volume = Volume::new(size, samples, Scaling::default(), affine).unwrap();
    let path = nrrd(&folder, "thick.nrrd", &volume);
    let png = folder.path("thick.png");
    let options =
        "--style lambert --ortho --camera 40,20 --light=-40,40 --size 1024x1024 --stipples 700000 --iso 500";
    dotwork(options, &path, &png);
    let ink = Ink::read(&png);
    let light = {
        let (azimuth, elevation) = (-40f64.to_radians(), 40f64.to_radians());
        [azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos()]
    };
    let (scale, block) = (0.45 * 1024.0, 32);
    let mut errors = Vec::new();
    for by in 0..1024 / block {
        for bx in 0..1024 / block {
            let (mut wanted, mut found) = (0.0, 0.0);
            let mut inside = true;
            for y in by * block..(by + 1) * block {
                for x in bx * block..(bx + 1) * block {
                    let (nx, ny) = ((x as f64 + 0.5 - 512.0) / scale, (512.0 - y as f64 - 0.5) / scale);
                    let square = nx * nx + ny * ny;
                    inside &= square < 0.9;
                    let nz = (1.0 - square).max(0.0).sqrt();
                    // The style's own tone.
                    wanted += 0.8 * (1.0 - (nx * light[0] + ny * light[1] + nz * light[2]).max(0.0));
                    found += ink.ink[y * 1024 + x];
                }
            }
            let pixels = (block * block) as f64;
            if inside {
                errors.push((found - wanted) / pixels);
            }
        }
    }
    let (rms, worst) = rms_and_worst(&errors);
    println!("1:1:3 sphere: {} blocks of {block} px, ink rms {rms:.4} worst {worst:.4}", errors.len());
    assert!(errors.len() > 300 && rms <= 0.02 && worst.abs() <= 0.06, "rms {rms} worst {worst}");
}

/// Correlation of the ink of two pictures by blocks of 64 pixels in which either has 3 % or more.
fn correlation(a: &Ink, b: &Ink) -> (usize, f64) {
    let blocks = |ink: &Ink| -> Vec<f64> {
        let n = ink.width / 64;
        let mean = |i: usize| {
            let rows = (i / n * 64..i / n * 64 + 64).map(|y| y * ink.width + i % n * 64);
            rows.map(|at| ink.ink[at..at + 64].iter().sum::<f64>()).sum::<f64>() / 4096.0
        };
        (0..n * (ink.ink.len() / ink.width / 64)).map(mean).collect()
    };
    let (a, b) = (blocks(a), blocks(b));
    let pairs: Vec<(f64, f64)> = a.into_iter().zip(b).filter(|(a, b)| a.max(*b) >= 0.03).collect();
    let n = pairs.len() as f64;
    let (ma, mb) = (pairs.iter().map(|p| p.0).sum::<f64>() / n, pairs.iter().map(|p| p.1).sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|p| f(p.0 - ma, p.1 - mb)).sum::<f64>();
    (pairs.len(), sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt())
}

fn bakes_agree(input: &Path) {
    let folder = Folder::new();
    let [voxel, surface] = ["voxel", "blue-noise"].map(|bake| {
        let png = folder.path(&format!("{bake}.png"));
        dotwork(&format!("--bake {bake} --set outlines=false --size 832x832"), input, &png);
        Ink::read(&png)
    });
    let (blocks, correlation) = correlation(&voxel, &surface);
    println!("{}: {blocks} blocks, correlation of the two bakes' ink {correlation:.3}", input.display());
    assert!(blocks > 40 && correlation >= 0.9, "{correlation}");
}

/// Aim: the ink of `voxel` against that of `blue-noise`, by blocks of 64 pixels, correlates by 0.9 or more.
#[test]
fn both_bakes_draw_the_same_form() {
    bakes_agree(Path::new("demo:engine"));
    bakes_agree(Path::new("demo:head"));
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn both_bakes_draw_the_same_form_of_real_volumes() {
    for name in ["engine_256x256x128.nrrd", "cthead_256x256x113.nrrd"] {
        bakes_agree(&shared(name));
    }
}

fn shared(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/volumes").join(name)
}

/// Dots that pop on a turntable of half a degree a frame: of all where only facing hides, and, with hiding by depth, of
/// those that blink: gone for one frame only, or there for one only.
fn turntable(input: &Path, options: &str) -> (usize, f64, f64) {
    let folder = Folder::new();
    let (bake, csv) = (folder.path("v.dots"), folder.path("v.csv"));
    let run = Command::new(env!("CARGO_BIN_EXE_dotwork"))
        .arg("bake")
        .arg(input)
        .arg("-o")
        .arg(&bake)
        .args(["--stipples", "200000"])
        .args(options.split_whitespace())
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let frames = |more: &str| -> Vec<FrameDots> {
        (0..6)
            .map(|f| {
                dotwork(
                    &format!("--camera {},15 --size 640x640 {more}", 20.0 + 0.5 * f64::from(f)),
                    &bake,
                    &csv,
                );
                frame_dots(&csv)
            })
            .collect()
    };
    let facing = frames("--set visibility=facing");
    let pops = facing.windows(2).map(|w| popping(&w[0], &w[1])).sum::<f64>() / 5.0;
    let solid = frames("");
    let mut blinks = 0.0;
    for w in solid.windows(3) {
        let large = |d: &FrameDots, id: &u64| d.get(id).is_some_and(|d| d.0 > 0.3);
        let gone = w[0].keys().filter(|id| large(&w[0], id) && large(&w[2], id) && !w[1].contains_key(id));
        let there =
            w[1].keys().filter(|id| large(&w[1], id) && !w[0].contains_key(id) && !w[2].contains_key(id));
        blinks += (gone.count() + there.count()) as f64 / w[1].len() as f64 / 4.0;
    }
    (facing[0].len(), pops, blinks)
}

/// Aim: with every enhancement on, fewer than 0.02 % of the dots pop in a frame; hiding by depth blinks for less than
/// 0.6 %: a skull hides much of itself.
fn is_coherent(input: &Path, options: &str) {
    let (dots, pops, blinks) = turntable(input, options);
    let name = input.display();
    println!(
        "turntable of {name} {options}: {dots} dots, {:.4} % pop, {:.3} % blink",
        pops * 100.0,
        blinks * 100.0
    );
    assert!(dots > 15_000 && pops < 0.0002 && blinks < 0.006, "{name}: {pops} {blinks}");
}

/// Distance, light, silhouette and creases together.
const EVERYTHING: &str = "--set distance=0.4 --set silhouette=0.4 --set creases=true --set feature=dense";

#[test]
fn a_turntable_of_the_head_phantom_is_coherent() {
    is_coherent(Path::new("demo:head"), EVERYTHING);
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn turntables_of_real_volumes_are_coherent() {
    is_coherent(&shared("cthead_256x256x113.nrrd"), EVERYTHING);
    is_coherent(&shared("engine_256x256x128.nrrd"), EVERYTHING);
}
