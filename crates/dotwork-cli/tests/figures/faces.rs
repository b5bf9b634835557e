//! Lists of faces (Lu et al. 2003): evenness and ink whatever the tessellation.

use dotwork::mesh::shapes;

use crate::measure::{Folder, Ink, dotwork, evenness};
use crate::surfaces::plate_dots;

/// Aim of the papers' bakes: mean ≥ 0.65 and minimum ≥ 0.3 of the hexagonal spacing at 5, 10, 20 and 40 %, from one number
/// of stipples; the ink of the tone within 0.01, in the papers' factors and in a sum of ink, and no tessellation to be seen
/// in the number of dots.
#[test]
fn plates_by_faces_are_even_and_keep_their_tone() {
    let folder = Folder::new();
    let (png, scale) = (folder.path("plate.png"), 0.45 * 2048.0 / 0.5f64.sqrt());
    let meshes = [
        ("two.obj", shapes::plate(1, 1)),
        ("fine.obj", shapes::plate(100, 100)),
        ("irregular.obj", shapes::plate_irregular(120, 3)),
    ];
    let mut numbers = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];
    for (name, mesh) in meshes {
        let mesh = folder.mesh(name, &mesh);
        for (k, tone) in [0.05, 0.1, 0.2, 0.4].into_iter().enumerate() {
            let options = format!("--bake face --stipples 150000 --set tone={tone} --set dot_size=3px");
            let dots = plate_dots(&folder, &mesh, &format!("{options} --set fade=off"));
            let (n, min, mean) = evenness(&dots, [0.03; 2], [0.97; 2]);
            let flat = "--style flat --ortho --size 2048x2048";
            dotwork(&format!("{flat} --camera 0,0 {options}"), &mesh, &png);
            let half = 0.45 * scale;
            let face_on = Ink::read(&png).mean(|x, y| (x - 1024.0).abs() < half && (y - 1024.0).abs() < half);
            dotwork(&format!("{flat} --camera 60,0 {options}"), &mesh, &png);
            let tilted =
                Ink::read(&png).mean(|x, y| (x - 1024.0).abs() < 0.5 * half && (y - 1024.0).abs() < half);
            println!(
                "{name} by faces at {tone}: {n} dots, min {min:.3} mean {mean:.3}, ink {face_on:.4}, tilted by 60 {tilted:.4}"
            );
            assert!(mean >= 0.65 && min >= 0.3, "{name} at {tone}: min {min} mean {mean}");
            assert!(
                (face_on - tone).abs() < 0.01 && (tilted - tone).abs() < 0.02,
                "{name} {tone}: {face_on} {tilted}"
            );
            numbers[k].push(n as f64);
        }
    }
    for n in numbers {
        assert!(n[1..].iter().all(|m| (m / n[0] - 1.0).abs() < 0.02), "{n:?}");
    }
}
