//! The bake `hierarchy`: evenness as the papers' bakes have it, and tone by both of its drawing tests.

use dotwork::mesh::shapes;

use crate::measure::{Folder, Ink, dotwork, evenness, rms_and_worst};
use crate::surfaces::{plate_dots, spectral_peak};

/// Aim: at every tone nearest-neighbour distances of mean ≥ 0.65 and minimum ≥ 0.3 of the hexagonal spacing, and no peaks
/// in the spectrum, whatever the triangles.
#[test]
fn evenness_of_a_hierarchy() {
    let folder = Folder::new();
    for (name, mesh) in [
        ("two.obj", shapes::plate(1, 1)),
        ("fine.obj", shapes::plate(180, 180)),
        ("irregular.obj", shapes::plate_irregular(40, 3)),
    ] {
        let mesh = folder.mesh(name, &mesh);
        for tone in [0.05, 0.1, 0.2, 0.4] {
            let options = format!(
                "--bake hierarchy --stipples 150000 --set tone={tone} --set fade=off --set dot_size=3px"
            );
            let dots = plate_dots(&folder, &mesh, &options);
            let (n, min, mean) = evenness(&dots, [0.03; 2], [0.97; 2]);
            let peak = spectral_peak(&dots);
            println!(
                "{name} at {tone}: {n} dots, min {min:.3} mean {mean:.3}, strongest frequency {peak:.1}"
            );
            assert!(n > 500 && min >= 0.3 && mean >= 0.65, "{name} at {tone}: min {min} mean {mean}");
            assert!(peak < 18.0, "{name} at {tone}: a frequency {peak} times its ring's mean");
        }
    }
}

/// Aim: both tests give the tone that is asked for, on tilted plates too: the radius as other bakes do; the edges, whose
/// lengths scatter and of which only the mean shortening is known, to 0.045.
#[test]
fn tone_by_radius_and_by_edges() {
    let folder = Folder::new();
    let (mesh, png) = (folder.mesh("plate.obj", &shapes::plate(60, 60)), folder.path("plate.png"));
    for (relevance, most) in [("radius", 0.02), ("edges", 0.045)] {
        let mut errors = Vec::new();
        for tilt in [0.0f64, 45.0, 60.0, 75.0] {
            for tone in [0.1, 0.3, 0.5, 0.7, 0.9] {
                let options = format!(
                    "--bake hierarchy --set relevance={relevance} --style flat --set tone={tone} --camera {tilt},0 --ortho \
                     --size 1024x1024 --set dot_size=2px"
                );
                dotwork(&options, &mesh, &png);
                let half = 0.45 * 1024.0 / 0.5f64.sqrt() * 0.5 * 0.9;
                let half_x = half * tilt.to_radians().cos();
                let ink = Ink::read(&png).mean(|x, y| (x - 512.0).abs() < half_x && (y - 512.0).abs() < half);
                errors.push(ink - tone);
            }
        }
        let (rms, worst) = rms_and_worst(&errors);
        println!("{relevance}: rms {rms:.4} worst {worst:+.4}: {errors:.3?}");
        assert!(worst.abs() <= most, "{relevance}: worst {worst}");
    }
}
