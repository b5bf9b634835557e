//! From a drawing to a file.

use std::io::{self, Write};
use std::path::Path;

use dotwork_drawing::Drawing;
use dotwork_export::{CsvWriter, Pixels, RasterView, pixels_per_metre, write_atomic, write_json, write_png};
use dotwork_ink::Stock;
use dotwork_render::{Raster, Rasterizer};

use super::FileError;
use crate::dots_file::settings_text;
use crate::scene::Scene;

/// A format that a drawing is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Pixels, with their physical resolution and the scene's settings.
    Png,
    /// The drawing table, one row a dot.
    Csv,
    /// The drawing table with places and normals.
    CsvFull,
    /// The whole drawing.
    Json,
}

impl Format {
    /// The names of all formats by extension, as a list for messages.
    pub const NAMES: &str = "png, csv, json";

    /// The format that a file has by its extension.
    pub fn of(path: &Path) -> Option<Format> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Format::Png),
            "csv" => Some(Format::Csv),
            "json" => Some(Format::Json),
            _ => None,
        }
    }
}

/// Writes `drawing`, which was drawn from `scene`, to a file: all of it or nothing.
///
/// # Errors
/// [`FileError::Write`]: what the system refuses.
pub fn write_drawing(
    path: impl AsRef<Path>,
    format: Format,
    drawing: &Drawing,
    scene: &Scene,
) -> Result<(), FileError> {
    Ok(write_atomic(path.as_ref(), |w| encode_drawing(w, format, drawing, scene))?)
}

/// Writes `drawing`, which was drawn from `scene`, as the bytes of a file.
///
/// # Errors
/// What the writer refuses.
pub fn encode_drawing(w: impl Write, format: Format, drawing: &Drawing, scene: &Scene) -> io::Result<()> {
    match format {
        Format::Png => png(w, drawing, scene),
        Format::Csv => CsvWriter::new(w, false)?.frame(0, drawing, None),
        Format::CsvFull => {
            let places = |layer: usize, stipple: u32| place(scene, layer, stipple);
            CsvWriter::new(w, true)?.frame(0, drawing, Some(&places))
        }
        Format::Json => write_json(w, drawing),
    }
}

fn png(mut w: impl Write, drawing: &Drawing, scene: &Scene) -> io::Result<()> {
    let mut raster = Raster::default();
    Rasterizer::new().draw(drawing, &mut raster);
    let pixels =
        if raster.channels == 1 { Pixels::Grey(&raster.samples) } else { Pixels::Rgb(&raster.samples) };
    let view = RasterView { width: raster.width, height: raster.height, pixels };
    let software = concat!("dotwork ", env!("CARGO_PKG_VERSION"));
    let settings = settings_text(scene);
    let text = [("Software", software), ("dotwork settings", settings.as_str())];
    // The encoder loses the kind of an error of its writer; a vector has none.
    let mut bytes = Vec::new();
    write_png(&mut bytes, &view, pixels_per_metre(drawing.page.dpi), &text)?;
    w.write_all(&bytes)
}

/// Position, in the coordinates of the file, and smooth normal of a stipple of the `layer`-th baked object.
fn place(scene: &Scene, layer: usize, stipple: u32) -> ([f32; 3], [f32; 3]) {
    let baked = scene.objects.iter().filter_map(|o| Some((o, o.stock.as_deref()?)));
    let at = |(object, stock): (&crate::Object, &Stock)| {
        let i = stipple as usize;
        let (p, n) = (i < stock.len()).then(|| (stock.position.at(i), stock.normal.at(i)))?;
        let origin = object.mesh.origin;
        Some(([0, 1, 2].map(|k| (f64::from(p[k]) + origin[k]) as f32), n.to_array()))
    };
    baked.clone().nth(layer).and_then(at).unwrap_or(([f32::NAN; 3], [f32::NAN; 3]))
}
