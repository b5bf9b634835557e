//! Surfaces: tone, evenness, coherence, scale.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use dotwork::mesh::{RawMesh, shapes};

use crate::measure::{Folder, FrameDots, Ink, Table, dotwork, evenness, frame_dots, popping, rms_and_worst};

/// Aim: over bins of the target tone RMS ≤ 0.008, worst ≤ 0.02, the limb included, and monotone.
#[test]
fn tone_of_a_lit_sphere() {
    let folder = Folder::new();
    let (mesh, png) = (folder.mesh("sphere.obj", &shapes::sphere(7)), folder.path("sphere.png"));
    let tone = 0.9;
    for options in ["", "--set grow=0", "--set fade=off"] {
        let camera = "--camera 0,0 --ortho --light=-40,40 --size 2048x2048";
        dotwork(&format!("--style lambert --set tone={tone} {camera} {options}"), &mesh, &png);
        let ink = Ink::read(&png);
        let radius = 0.45 * 2048.0;
        let (sin_az, cos_az) = (-40f64).to_radians().sin_cos();
        let (sin_el, cos_el) = 40f64.to_radians().sin_cos();
        let light = [sin_az * cos_el, sin_el, cos_az * cos_el];
        // By bin of the target tone and by limb or not: sum of the errors, sum of the ink, pixels.
        let mut bins: BTreeMap<(bool, usize), (f64, f64, f64)> = BTreeMap::new();
        for (i, v) in ink.ink.iter().enumerate() {
            let x = ((i % 2048) as f64 + 0.5 - 1024.0) / radius;
            let y = -((i / 2048) as f64 + 0.5 - 1024.0) / radius;
            let z2 = 1.0 - x * x - y * y;
            // Below a cosine of 0.05 no dots are drawn, by design.
            if z2 <= 0.08f64.powi(2) {
                continue;
            }
            let z = z2.sqrt();
            let target = (tone * (1.0 - (x * light[0] + y * light[1] + z * light[2]).max(0.0))).min(0.95);
            let bin = bins.entry((z < 0.3, (target * 20.0) as usize)).or_default();
            *bin = (bin.0 + v - target, bin.1 + v, bin.2 + 1.0);
        }
        bins.retain(|_, b| b.2 > 3000.0);
        for limb in [false, true] {
            let of: Vec<_> = bins.iter().filter(|((l, _), _)| *l == limb).map(|(_, b)| b).collect();
            let (rms, worst) = rms_and_worst(&of.iter().map(|b| b.0 / b.2).collect::<Vec<_>>());
            println!(
                "sphere {options:16} limb {limb:5}: rms {rms:.4} worst {worst:+.4} in {} bins",
                of.len()
            );
            assert!(
                of.len() > 8 && rms <= 0.008 && worst.abs() <= 0.02,
                "{options}: rms {rms} worst {worst}"
            );
            let inks: Vec<f64> = of.iter().map(|b| b.1 / b.2).collect();
            assert!(inks.is_sorted(), "tone is monotone: {inks:?}");
        }
    }
}

/// Aim: plates tilted 0, 45, 60, 75° at tones 0.1–0.9: RMS ≤ 0.008, worst ≤ 0.02.
#[test]
fn tone_of_tilted_plates() {
    let folder = Folder::new();
    let (mesh, png) = (folder.mesh("plate.obj", &shapes::plate(8, 8)), folder.path("plate.png"));
    let mut errors = Vec::new();
    for tilt in [0.0f64, 45.0, 60.0, 75.0] {
        for tenth in 1..=9 {
            let tone = f64::from(tenth) / 10.0;
            dotwork(
                &format!(
                    "--style flat --set tone={tone} --camera {tilt},0 --ortho --size 1024x1024 --set dot_size=2px"
                ),
                &mesh,
                &png,
            );
            // The unit square's bounding sphere has the radius √½ and fills 90 % of the page.
            let half = 0.45 * 1024.0 / 0.5f64.sqrt() * 0.5 * 0.9;
            let half_x = half * tilt.to_radians().cos();
            let ink = Ink::read(&png).mean(|x, y| (x - 512.0).abs() < half_x && (y - 512.0).abs() < half);
            errors.push(ink - tone);
        }
        let (rms, worst) = rms_and_worst(&errors[errors.len() - 9..]);
        println!("plate tilted {tilt:2}: rms {rms:.4} worst {worst:+.4}");
    }
    let (rms, worst) = rms_and_worst(&errors);
    assert!(rms <= 0.008 && worst.abs() <= 0.02, "rms {rms} worst {worst}: {errors:.4?}");
}

/// The dots of a face-on unit square drawn at a tone, in units of the square.
pub fn plate_dots(folder: &Folder, mesh: &Path, options: &str) -> Vec<[f64; 2]> {
    let csv = folder.path("plate.csv");
    dotwork(&format!("--style flat --camera 0,0 --ortho --size 2048x2048 {options}"), mesh, &csv);
    let table = Table::read(&csv);
    let scale = 0.45 * 2048.0 / 0.5f64.sqrt();
    table
        .column("x_px")
        .iter()
        .zip(table.column("y_px"))
        .map(|(x, y)| [(x - 1024.0) / scale + 0.5, 0.5 - (y - 1024.0) / scale])
        .collect()
}

/// Aim: at every tone nearest-neighbour distances of mean ≥ 0.785 and minimum ≥ 0.67 of the hexagonal spacing, from
/// one bake; no peaks in the spectrum.
#[test]
fn evenness_at_every_tone() {
    let folder = Folder::new();
    let mesh = folder.mesh("plate.obj", &shapes::plate(1, 1));
    for tone in [0.05, 0.1, 0.2, 0.4] {
        let dots = plate_dots(
            &folder,
            &mesh,
            &format!("--stipples 150000 --set tone={tone} --set fade=off --set dot_size=3px"),
        );
        let (n, min, mean) = evenness(&dots, [0.03; 2], [0.97; 2]);
        println!("evenness at {tone}: {n} dots, min {min:.3} mean {mean:.3}");
        assert!(n > 500 && min >= 0.67 && mean >= 0.785, "tone {tone}: min {min} mean {mean}");
        let peak = spectral_peak(&dots);
        println!("spectrum at {tone}: strongest frequency {peak:.1} x the mean of its ring");
        // The largest of some 5,000 exponential variates is 8.5 in the mean; a lattice gives hundreds.
        assert!(peak < 18.0, "tone {tone}: a frequency {peak} times its ring's mean");
    }
}

/// The strongest single frequency over the mean of its ring, for frequencies up to 1.6 over the hexagonal spacing.
pub fn spectral_peak(points: &[[f64; 2]]) -> f64 {
    // A window of the square's middle keeps its edges out of the spectrum; 2,500 dots are enough.
    let side = (2500.0 / points.len() as f64).sqrt().min(0.9);
    let low = 0.5 - side / 2.0;
    let window: Vec<[f64; 2]> = points
        .iter()
        .map(|p| [(p[0] - low) / side, (p[1] - low) / side])
        .filter(|p| p.iter().all(|v| (0.0..1.0).contains(v)))
        .collect();
    let top = (1.6 * (3f64.sqrt() / 2.0 * window.len() as f64).sqrt()) as i32;
    let mut rings: BTreeMap<i32, Vec<f64>> = BTreeMap::new();
    for fy in 0..=top {
        for fx in -top..=top {
            let f = f64::from(fx).hypot(f64::from(fy));
            // Low frequencies carry the window's own edges.
            if f < 4.0 || f > f64::from(top) {
                continue;
            }
            let (mut re, mut im) = (0.0, 0.0);
            for p in &window {
                // A Hann window in both directions.
                let weight =
                    (std::f64::consts::PI * p[0]).sin().powi(2) * (std::f64::consts::PI * p[1]).sin().powi(2);
                let (s, c) =
                    (std::f64::consts::TAU * (f64::from(fx) * p[0] + f64::from(fy) * p[1])).sin_cos();
                re += weight * c;
                im += weight * s;
            }
            rings.entry((f / 2.0) as i32).or_default().push(re * re + im * im);
        }
    }
    rings
        .values()
        .filter(|r| r.len() > 12)
        .map(|r| r.iter().copied().fold(0.0, f64::max) / (r.iter().sum::<f64>() / r.len() as f64))
        .fold(0.0, f64::max)
}

/// Aim: two triangles, a fine grid and an irregular triangulation give the same statistics at ink 0.5.
#[test]
fn tessellation_does_not_show() {
    let folder = Folder::new();
    let mut measured = Vec::new();
    for (name, mesh) in [
        ("two.obj", shapes::plate(1, 1)),
        ("fine.obj", shapes::plate(90, 110)),
        ("irregular.obj", shapes::plate_irregular(40, 3)),
    ] {
        let mesh = folder.mesh(name, &mesh);
        let options = "--set tone=0.5 --set dot_size=3px --stipples 150000 --set fade=off";
        let dots = plate_dots(&folder, &mesh, options);
        let png = folder.path("plate.png");
        dotwork(&format!("--style flat --camera 0,0 --ortho --size 2048x2048 {options}"), &mesh, &png);
        let half = 0.45 * 2048.0 / 0.5f64.sqrt() * 0.45;
        let ink = Ink::read(&png).mean(|x, y| (x - 1024.0).abs() < half && (y - 1024.0).abs() < half);
        let (n, min, mean) = evenness(&dots, [0.03; 2], [0.97; 2]);
        // Counts in a 10 × 10 grid, over their mean.
        let mut counts = [0.0; 100];
        for p in &dots {
            let cell = |v: f64| (v * 10.0).clamp(0.0, 9.0) as usize;
            counts[cell(p[0]) + 10 * cell(p[1])] += 100.0 / dots.len() as f64;
        }
        let (spread, _) = rms_and_worst(&counts.map(|c| c - 1.0));
        println!(
            "{name}: {n} dots, ink {ink:.4}, min {min:.3} mean {mean:.3}, local density rms {spread:.4}"
        );
        assert!((ink - 0.5).abs() < 0.01 && min >= 0.67 && mean >= 0.785 && spread < 0.03, "{name}");
        measured.push((n as f64, ink, mean));
    }
    for m in &measured[1..] {
        assert!((m.0 / measured[0].0 - 1.0).abs() < 0.01, "{measured:?}");
        assert!((m.1 - measured[0].1).abs() < 0.005 && (m.2 - measured[0].2).abs() < 0.01, "{measured:?}");
    }
}

/// Aim: the two sides of a thin sheet do not thin each other out.
#[test]
fn a_thin_sheet_keeps_its_density_on_both_sides() {
    let folder = Folder::new();
    let options = "--style flat --set tone=0.4 --ortho --size 1024x1024 --set dot_size=3px --set fade=off";
    let count = |name: &str, mesh: &RawMesh, camera: &str, stipples: usize| {
        let (mesh, csv) = (folder.mesh(name, mesh), folder.path("sheet.csv"));
        dotwork(&format!("{options} --camera {camera} --stipples {stipples}"), &mesh, &csv);
        let table = Table::read(&csv);
        let dots: Vec<[f64; 2]> =
            table.column("x_px").into_iter().zip(table.column("y_px")).map(|(x, y)| [x, y]).collect();
        let half = 0.45 * 1024.0 / 0.5f64.sqrt() * 0.45;
        evenness(&dots, [512.0 - half; 2], [512.0 + half; 2])
    };
    let (alone, ..) = count("plate.obj", &shapes::plate(4, 4), "0,0", 60_000);
    for camera in ["0,0", "180,0"] {
        // Half the thickness of a dot's spacing: positions alone would thin one side out.
        let (n, min, mean) = count("sheet.obj", &shapes::sheet(0.001, 4), camera, 120_000);
        println!("sheet from {camera}: {n} dots against {alone} on a plate, min {min:.3} mean {mean:.3}");
        assert!((n as f64 / alone as f64 - 1.0).abs() < 0.02, "{n} against {alone}");
        assert!(min >= 0.65 && mean >= 0.78, "min {min} mean {mean}");
    }
}

/// Aim: with a pen every dot has exactly the pen's diameter, at the rim as well.
#[test]
fn a_pen_draws_one_size_of_dot() {
    let folder = Folder::new();
    let (mesh, csv) = (folder.mesh("sphere.obj", &shapes::sphere(5)), folder.path("pen.csv"));
    dotwork("--page A6 --dpi 254 --pen 0.3mm", &mesh, &csv);
    let table = Table::read(&csv);
    // 254 dpi are 10 pixels a millimetre.
    assert!(table.rows.len() > 1000 && table.column("radius_px").iter().all(|&r| r == 1.5));
    assert!(table.column("ink").iter().all(|&ink| ink == 1.0));
}

/// Aim: on a turntable at 0.5° a frame and under a moving light fewer than 0.02 % of the dots a frame appear or vanish
/// at more than 30 % of full size while not occluded; hiding by depth does not blink.
#[test]
fn coherence_of_a_turntable_and_of_a_moving_light() {
    let folder = Folder::new();
    let ribbon = folder.path("ribbon.ply");
    let run = Command::new(env!("CARGO_BIN_EXE_dotwork"))
        .args(["demo", "ribbon", "-o"])
        .arg(&ribbon)
        .output()
        .unwrap();
    assert!(run.status.success());
    let bake = folder.path("ribbon.dots");
    let run = Command::new(env!("CARGO_BIN_EXE_dotwork"))
        .arg("bake")
        .arg(&ribbon)
        .arg("-o")
        .arg(&bake)
        .args(["--stipples", "250000"])
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let csv = folder.path("frame.csv");
    let frames = |options: &dyn Fn(f64) -> String| -> Vec<FrameDots> {
        (0..9)
            .map(|f| {
                dotwork(&options(f64::from(f)), &bake, &csv);
                frame_dots(&csv)
            })
            .collect()
    };
    // Without hiding by depth whatever pops is the tone's or the rim's doing.
    let turning = frames(&|f| format!("--set visibility=facing --camera {},15", 20.0 + 0.5 * f));
    let lit = frames(&|f| format!("--set visibility=facing --light={},40", -40.0 + f));
    for (name, frames) in [("turntable", &turning), ("light", &lit)] {
        let pops: Vec<f64> = frames.windows(2).map(|w| popping(&w[0], &w[1])).collect();
        let mean = pops.iter().sum::<f64>() / pops.len() as f64;
        println!("{name}: {} dots, {:.4} % pop in a frame", frames[0].len(), mean * 100.0);
        assert!(frames[0].len() > 20_000 && mean < 0.0002, "{name}: {pops:?}");
    }
    // A sphere hides nothing of itself: with hiding by depth, too, nothing pops.
    let sphere = folder.mesh("sphere.obj", &shapes::sphere(6));
    let solid: Vec<FrameDots> = (0..5)
        .map(|f| {
            let options =
                format!("--stipples 150000 --light-frame object --camera {},15", 0.5 * f64::from(f));
            dotwork(&options, &sphere, &csv);
            frame_dots(&csv)
        })
        .collect();
    let pops = solid.windows(2).map(|w| popping(&w[0], &w[1])).sum::<f64>() / 4.0;
    println!("sphere with hiding: {} dots, {:.4} % pop in a frame", solid[0].len(), pops * 100.0);
    assert!(pops < 0.0002, "{pops}");
    // Where one part passes before another, dots within half a pixel of its edge are hidden a frame early or late: a
    // dot that is gone for one frame only, or there for one frame only, blinks.
    let solid = frames(&|f| format!("--camera {},15", 20.0 + 0.5 * f));
    let mut blinks = 0.0;
    for w in solid.windows(3) {
        let large = |d: &FrameDots, id: &u64| d.get(id).is_some_and(|d| d.0 > 0.3);
        let gone =
            w[0].keys().filter(|id| large(&w[0], id) && large(&w[2], id) && !w[1].contains_key(id)).count();
        let there = w[1]
            .keys()
            .filter(|id| large(&w[1], id) && !w[0].contains_key(id) && !w[2].contains_key(id))
            .count();
        blinks += (gone + there) as f64 / w[1].len() as f64 / (solid.len() - 2) as f64;
    }
    println!("turntable with hiding: {:.4} % blink in a frame", blinks * 100.0);
    assert!(blinks < 0.002, "{blinks}");
}

/// Aim: zooming from 1× to 4× keeps the mean ink of the same patch within ± 5 %.
#[test]
fn scale_keeps_the_ink_of_a_patch() {
    let folder = Folder::new();
    let (mesh, png) = (folder.mesh("sphere.obj", &shapes::sphere(6)), folder.path("sphere.png"));
    // One bake that lasts for the largest scale.
    let bake = folder.path("sphere.dots");
    let options = "--style lambert --set tone=0.9 --set dot_size=6px --camera 0,0 --ortho --light=-50,40 --size 1024x1024";
    let run = Command::new(env!("CARGO_BIN_EXE_dotwork"))
        .arg("bake")
        .arg(&mesh)
        .arg("-o")
        .arg(&bake)
        .args(["--stipples", "1300000"])
        .args(options.split_whitespace())
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let mut inks = Vec::new();
    for zoom in [1.0, 1.4, 2.0, 2.8, 4.0] {
        dotwork(&format!("{options} --zoom {zoom}"), &bake, &png);
        let half = 0.45 * 1024.0 * zoom * 0.2;
        inks.push(Ink::read(&png).mean(|x, y| (x - 512.0).abs() < half && (y - 512.0).abs() < half));
    }
    println!("ink of a patch at zoom 1, 1.4, 2, 2.8, 4: {inks:.4?}");
    for ink in &inks {
        assert!((ink / inks[0] - 1.0).abs() < 0.05, "{inks:?}");
    }
}

/// Aim: a dot sits on its surface point to within 0.05 px, whatever the view.
#[test]
fn dots_stick_to_the_surface() {
    let folder = Folder::new();
    let (mesh, csv) = (folder.mesh("torus.obj", &shapes::torus(1.0, 0.4, 64, 32)), folder.path("torus.csv"));
    for (azimuth, elevation) in [(0.0f64, 0.0f64), (33.0, 20.0), (-120.0, -40.0)] {
        let options =
            format!("--camera={azimuth},{elevation} --ortho --csv full --stipples 50000 --size 1000x1000");
        dotwork(&options, &mesh, &csv);
        let t = Table::read(&csv);
        // The torus has its centre at the origin and a bounding radius of √(1.4² + …): its farthest vertex.
        let radius = shapes::torus(1.0, 0.4, 64, 32)
            .positions
            .iter()
            .map(|p| p.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt())
            .fold(0.0, f64::max);
        let scale = 0.45 * 1000.0 / radius;
        let ((sa, ca), (se, ce)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
        let worst = t
            .rows
            .iter()
            .map(|r| {
                let at = |c: &str| r[t.columns[c]];
                let (x, y, z) = (at("x"), at("y"), at("z"));
                let right = x * ca - z * sa;
                let up = y * ce - (x * sa + z * ca) * se;
                (at("x_px") - 500.0 - right * scale).hypot(at("y_px") - 500.0 + up * scale)
            })
            .fold(0.0, f64::max);
        println!("camera {azimuth},{elevation}: {} dots within {worst:.4} px", t.rows.len());
        assert!(t.rows.len() > 1000 && worst < 0.05, "{worst}");
    }
}
