//! From an array of numbers to a vector plate with a scale bar: `cargo run --example array_to_svg -- OUT.svg`.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program, not a library")]

use std::error::Error;

use dotwork::volume::{IsoOptions, Unit};
use dotwork::{Format, Object, Page, ScaleBar, Scene, Style, Volume, Warnings, write_drawing};

fn main() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1).ok_or("where to? array_to_svg OUT.svg")?;
    // 64 x 64 x 64 values, x fastest, as numpy lays out an array of shape (z, y, x): a tangle cube.
    let term = |v: f32| 5.0 * v.powi(2) - v.powi(4);
    let along = |i: usize| term(0.09 * (i as f32 - 31.5));
    let samples: Vec<f32> =
        (0..64 * 64 * 64).map(|i| along(i % 64) + along(i / 64 % 64) + along(i / 4096)).collect();
    let dots = array_to_svg(&samples, [64; 3], [0.5; 3], 11.8, &output)?;
    println!("{output}: {dots} dots");
    Ok(())
}

/// Draws the surface where `samples` have the value `iso`; `spacing_mm` is the distance of voxels along x, y and z.
pub fn array_to_svg(
    samples: &[f32],
    dims: [usize; 3],
    spacing_mm: [f64; 3],
    iso: f64,
    output: &str,
) -> Result<usize, Box<dyn Error>> {
    // What a step changes or leaves out comes as a warning; libraries print nothing.
    let mut warnings = Warnings::new();
    // Any of ten types will do, u8 and f64 too. The values are taken as they are.
    let volume = Volume::from_slice(dims, spacing_mm, samples)?;
    // Values of `iso` and above are inside; `cap` closes the surface where it meets the border.
    let surface = volume.isosurface(iso, &IsoOptions { cap: true }, &mut warnings)?;
    let mut object = Object::new("array", surface, Style::default(), &mut warnings)?;
    // An array knows no unit; the scale bar names one.
    object.world.unit = Unit::Millimetre;
    // A parallel view, 80 mm square at 300 dpi, with a bar of a round length.
    let mut scene = Scene::of(object);
    scene.page = Page::millimetres(80.0, 80.0, 300.0)?;
    scene.camera.ortho = true;
    scene.scale_bar = Some(ScaleBar::default());
    // Drawing bakes first: as many stipples as this page needs.
    let drawing = scene.draw();
    write_drawing(output, Format::Svg, &drawing, &scene, &mut warnings)?;
    warnings.iter().for_each(|w| eprintln!("{w}"));
    Ok(drawing.dot_count())
}
