//! From vertices and triangles to a plate for one pen: `cargo run --example mesh_to_svg -- OUT.svg`.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program, not a library")]

use std::error::Error;

use dotwork::{Format, Length, Object, Page, RawMesh, Scene, Warnings, preset, write_drawing};

fn main() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1).ok_or("where to? mesh_to_svg OUT.svg")?;
    // A torus of 96 x 48 vertices, 2 and 0.8 its radii; each quadrilateral is two triangles.
    let turn = |k: u32, of: u32| (std::f32::consts::TAU * k as f32 / of as f32).sin_cos();
    let point = |(s, c), (t, d)| [(2.0 + 0.8 * d) * c, 0.8 * t, (2.0 + 0.8 * d) * s];
    let positions: Vec<[f32; 3]> = (0..96 * 48).map(|k| point(turn(k / 48, 96), turn(k % 48, 48))).collect();
    let vertex = |i: u32, j: u32| (i % 96) * 48 + j % 48;
    let quad = |i, j| [vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    let triangles: Vec<[u32; 3]> = (0..96 * 48).flat_map(|k| halves(quad(k / 48, k % 48))).collect();
    let dots = mesh_to_svg(&positions, &triangles, &output)?;
    println!("{output}: {dots} dots");
    Ok(())
}

/// Draws a mesh on A5 for a pen of 0.25 mm, in the order in which a plotter draws it.
pub fn mesh_to_svg(
    positions: &[[f32; 3]],
    triangles: &[[u32; 3]],
    output: &str,
) -> Result<usize, Box<dyn Error>> {
    // What is put in order on the way comes as a warning; libraries print nothing.
    let mut warnings = Warnings::new();
    let raw = RawMesh { positions: positions.to_vec(), triangles: triangles.to_vec(), ..RawMesh::default() };
    // Every dot has the pen's diameter, so tone comes from their number alone.
    let mut style = preset("hard").ok_or("no such preset")?;
    style.use_pen(Length::mm(0.25));
    let mut scene = Scene::of(Object::new("torus", raw, style, &mut warnings)?);
    // The margin is in pixels of the page, like everything that is drawn.
    scene.page = Page::millimetres(148.0, 210.0, 300.0)?;
    scene.page.margin_px = Length::mm(10.0).to_px(&scene.page);
    scene.camera.set_direction("20,35")?;
    let drawing = scene.draw();
    // SvgPlot puts the dots into one layer a pen and shortens the pen's way; Svg keeps the drawing's order.
    write_drawing(output, Format::SvgPlot, &drawing, &scene, &mut warnings)?;
    warnings.iter().for_each(|w| eprintln!("{w}"));
    Ok(drawing.dot_count())
}
