//! From an array of numbers to a vector plate with a scale bar: `cargo run --example array_to_svg -- OUT.svg`.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program, not a library")]

use std::error::Error;
use std::path::Path;

use dotwork::volume::{IsoOptions, Unit};
use dotwork::{Camera, Format, Object, Page, ScaleBar, Scene, Volume, Warnings, preset, write_drawing};

fn main() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1).ok_or("where to? array_to_svg OUT.svg")?;
    // 64 x 64 x 64 values, x fastest, as numpy lays out an array of shape (z, y, x): Schoen's gyroid, within a ball.
    let n = 64;
    let at = |i: usize| (i as f32 - 31.5) / 31.5;
    let gyroid = |[x, y, z]: [f32; 3]| x.sin() * y.cos() + y.sin() * z.cos() + z.sin() * x.cos();
    let samples: Vec<f32> = (0..n * n * n)
        .map(|i| [at(i % n), at(i / n % n), at(i / n / n)])
        .map(|p| (0.6 - gyroid(p.map(|v| 7.0 * v)).abs()).min(0.9 - p.iter().map(|v| v * v).sum::<f32>()))
        .collect();
    let dots = array_to_svg(&samples, [n, n, n], [0.25, 0.25, 0.25], 0.0, Path::new(&output))?;
    println!("{output}: {dots} dots");
    Ok(())
}

/// Draws the surface where `samples` have the value `iso`; `spacing_mm` is the distance of voxels along x, y and z.
pub fn array_to_svg(
    samples: &[f32],
    dims: [usize; 3],
    spacing_mm: [f64; 3],
    iso: f64,
    output: &Path,
) -> Result<usize, Box<dyn Error>> {
    // What a step had to change or leave out comes as a warning; libraries print nothing.
    let mut warnings = Warnings::new();
    // Any of ten types will do: u8, i16, f64, …. The values are taken as they are.
    let volume = Volume::from_slice(dims, spacing_mm, samples)?;
    // Values of `iso` and above are inside; `cap` closes the surface where it meets the border.
    let surface = volume.isosurface(iso, &IsoOptions { cap: true }, &mut warnings)?;
    let style = preset("soft").ok_or("no such preset")?;
    let mut object = Object::new("gyroid", surface, style, &mut warnings)?;
    // The array does not know its unit; the scale bar wants to.
    object.world.unit = Unit::Millimetre;
    // A parallel view, 80 mm square at 300 dpi, with a bar of a round length.
    let mut scene = Scene::of(object);
    scene.page = Page::millimetres(80.0, 80.0, 300.0)?;
    scene.camera = Camera { ortho: true, ..Camera::default() };
    scene.scale_bar = Some(ScaleBar::default());
    // Drawing bakes first: as many stipples as this page needs.
    let drawing = scene.draw();
    write_drawing(output, Format::Svg, &drawing, &scene, &mut warnings)?;
    warnings.iter().for_each(|w| eprintln!("{w}"));
    Ok(drawing.dot_count())
}
