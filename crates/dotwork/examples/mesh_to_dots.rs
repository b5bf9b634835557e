//! From a mesh to a table of dots: `cargo run --example mesh_to_dots -- [MESH [OUT.csv]]`.
//!
//! Without arguments it draws a built-in teapot and prints how many of its stipples are dots in this view.

#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program, not a library")]

use std::error::Error;

use dotwork::{Format, Stipples, Warnings, open, preset, write_drawing};

/// Stipples to bake.
const STIPPLES: usize = 50_000;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let input = arguments.next().unwrap_or_else(|| "demo:teapot".into());
    let output = arguments.next();
    let mut warnings = Warnings::new();
    let dots = mesh_to_dots(&input, output.as_deref(), &mut warnings)?;
    warnings.iter().for_each(|w| eprintln!("{input}: {w}"));
    println!("{dots} of {STIPPLES} stipples are dots in this view");
    Ok(())
}

/// Draws a mesh, writes the table if there is an output, and returns the number of dots.
pub fn mesh_to_dots(
    input: &str,
    output: Option<&str>,
    warnings: &mut Warnings,
) -> Result<usize, Box<dyn Error>> {
    // A style says how much ink each place asks for; the mesh is put in order on the way in.
    let style = preset("soft").ok_or("no such preset")?;
    let mut scene = open(input, &style, warnings)?;

    // The bake is the expensive half, done once; any number of views can be drawn from it.
    scene.stipples = Stipples::Count(STIPPLES);
    scene.bake(|_| ());

    scene.camera.set_direction("30,20")?;
    let drawing = scene.draw();
    if let Some(path) = output {
        write_drawing(path, Format::CsvFull, &drawing, &scene, warnings)?;
    }
    Ok(drawing.dot_count())
}
