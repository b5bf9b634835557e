//! From vertices and triangles to a plate for one pen: `cargo run --example mesh_to_svg -- OUT.svg`.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program, not a library")]

use std::error::Error;
use std::path::Path;

use dotwork::{Format, Length, Object, Page, RawMesh, Scene, Warnings, preset, write_drawing};

fn main() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1).ok_or("where to? mesh_to_svg OUT.svg")?;
    // A torus, 96 x 48 vertices: the distance of the tube's axis is 2, its radius 0.8.
    let (m, n) = (96, 48);
    let angle = |k: u32, of: u32| std::f32::consts::TAU * k as f32 / of as f32;
    let point = |(s, c): (f32, f32), (t, d): (f32, f32)| [(2.0 + 0.8 * d) * c, 0.8 * t, (2.0 + 0.8 * d) * s];
    let positions: Vec<[f32; 3]> =
        (0..m * n).map(|k| point(angle(k / n, m).sin_cos(), angle(k % n, n).sin_cos())).collect();
    let corner = |i: u32, j: u32| (i % m) * n + j % n;
    let quad = |i, j| [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
    let triangles: Vec<[u32; 3]> =
        (0..m * n).map(|k| quad(k / n, k % n)).flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let dots = mesh_to_svg(&positions, &triangles, Path::new(&output))?;
    println!("{output}: {dots} dots");
    Ok(())
}

/// Draws a mesh on A5 for a pen of 0.25 mm, in the order in which a plotter draws it.
pub fn mesh_to_svg(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    output: &Path,
) -> Result<usize, Box<dyn Error>> {
    // What was put in order on the way comes as a warning; libraries print nothing.
    let mut warnings = Warnings::new();
    let raw = RawMesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..RawMesh::default() };
    // Every dot has the pen's diameter, so tone comes from their number alone.
    let mut style = preset("hard").ok_or("no such preset")?;
    style.use_pen(Length::mm(0.25));
    let mut scene = Scene::of(Object::new("torus", raw, style, &mut warnings)?);
    // The margin is in pixels of the page, like everything that is drawn.
    scene.page = Page::millimetres(148.0, 210.0, 600.0)?;
    scene.page.margin_px = Length::mm(10.0).to_px(&scene.page);
    scene.camera.set_direction("20,35")?;
    let drawing = scene.draw();
    // SvgPlot puts the dots into one layer a pen and shortens the pen's way; Svg keeps the drawing's order.
    write_drawing(output, Format::SvgPlot, &drawing, &scene, &mut warnings)?;
    warnings.iter().for_each(|w| eprintln!("{w}"));
    Ok(drawing.dot_count())
}
