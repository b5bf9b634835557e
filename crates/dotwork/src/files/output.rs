//! From a drawing to a file.

use std::io::{self, Write};
use std::path::Path;

use dotwork_drawing::{Drawing, Warnings};
use dotwork_export::plot::{Travel, order_for_plotter, plotter_layers};
use dotwork_export::{
    CsvWriter, PdfOptions, SETTINGS_KEYWORD, SvgOptions, assign_pens, bilevel, pixels_per_metre,
    write_atomic, write_json, write_pdf, write_png, write_png_bilevel, write_svg, write_tiff,
    write_tiff_bilevel,
};
use dotwork_ink::Stock;
use dotwork_render::Rasterizer;

use super::FileError;
use super::film::{rasterize, view};
use crate::dots_file::settings_text;
use crate::scene::Scene;

/// What wrote a file.
pub(super) const SOFTWARE: &str = concat!("dotwork ", env!("CARGO_PKG_VERSION"));

/// A format that a drawing is written in. All but the tables carry the scene's settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Pixels, with their physical resolution.
    Png,
    /// Pixels of one bit.
    PngBilevel,
    /// Vectors in millimetres.
    Svg,
    /// Vectors for a pen plotter: one layer a pen, marks in the order of the shortest way.
    SvgPlot,
    /// Vectors on a page in millimetres.
    Pdf,
    /// Pixels, with their physical resolution.
    Tiff,
    /// Pixels of one bit, as a fax has them.
    TiffBilevel,
    /// The drawing table, one row a dot.
    Csv,
    /// The drawing table with places and normals.
    CsvFull,
    /// The whole drawing.
    Json,
}

impl Format {
    /// The names of all formats by extension, as a list for messages.
    pub const NAMES: &str = "png, svg, pdf, tif, csv, json";

    /// The format that a file has by its extension.
    pub fn of(path: &Path) -> Option<Format> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Some(Format::Png),
            "svg" => Some(Format::Svg),
            "pdf" => Some(Format::Pdf),
            "tif" | "tiff" => Some(Format::Tiff),
            "csv" => Some(Format::Csv),
            "json" => Some(Format::Json),
            _ => None,
        }
    }
}

/// What a format makes of a drawing before it is written: dots get the scene's pens, and a plotter's marks their order,
/// with the way that the pen goes. Pens that cannot be used are left out, which is said in `warnings`.
pub fn prepare(
    drawing: Drawing,
    format: Format,
    scene: &Scene,
    warnings: &mut Warnings,
) -> (Drawing, Option<Travel>) {
    let mut drawing = drawing;
    if !scene.pens.is_empty() {
        match assign_pens(&drawing, &scene.pens) {
            Ok((with_pens, said)) => {
                drawing = with_pens;
                warnings.append(said);
            }
            Err(e) => warnings.say(format!("drawn without pens: {e}")),
        }
    }
    if format != Format::SvgPlot {
        return (drawing, None);
    }
    let (mut drawing, said) = plotter_layers(&drawing);
    warnings.append(said);
    let travel = order_for_plotter(&mut drawing);
    (drawing, Some(travel))
}

/// Writes `drawing`, which was drawn from `scene`, to a file: all of it or nothing. What a format cannot show is said in
/// `warnings`.
///
/// # Errors
/// [`FileError::Write`]: what the system refuses.
pub fn write_drawing(
    path: impl AsRef<Path>,
    format: Format,
    drawing: &Drawing,
    scene: &Scene,
    warnings: &mut Warnings,
) -> Result<(), FileError> {
    let (drawing, _) = prepare(drawing.clone(), format, scene, warnings);
    Ok(write_atomic(path.as_ref(), |w| encode_drawing(w, format, false, &drawing, scene, warnings))?)
}

/// Writes a drawing that was [prepared](prepare) as the bytes of a file; with `clear`, the paper of a PNG is
/// transparent. What the format cannot show is said in `warnings`.
///
/// # Errors
/// What the writer refuses.
pub fn encode_drawing(
    w: impl Write,
    format: Format,
    clear: bool,
    drawing: &Drawing,
    scene: &Scene,
    warnings: &mut Warnings,
) -> io::Result<()> {
    encode_with(&mut Rasterizer::new(), w, format, clear, drawing, scene, warnings)
}

/// As [`encode_drawing`], with a rasteriser that is used again.
pub(super) fn encode_with(
    rasterizer: &mut Rasterizer,
    w: impl Write,
    format: Format,
    clear: bool,
    drawing: &Drawing,
    scene: &Scene,
    warnings: &mut Warnings,
) -> io::Result<()> {
    let title: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    let (title, settings) = (title.join(", "), settings_text(scene));
    let (title, metadata) = (Some(title.as_str()), Some(settings.as_str()));
    let ppm = pixels_per_metre(drawing.page.dpi);
    let text = [("Software", SOFTWARE), (SETTINGS_KEYWORD, settings.as_str())];
    match format {
        Format::Png => write_png(w, &view(&rasterize(rasterizer, drawing, clear)), ppm, &text),
        Format::Tiff => {
            write_tiff(w, &view(&rasterize(rasterizer, drawing, false)), drawing.page.dpi, metadata)
        }
        Format::PngBilevel => write_png_bilevel(w, &bilevel(drawing, warnings), ppm, &text),
        Format::TiffBilevel => write_tiff_bilevel(w, &bilevel(drawing, warnings), drawing.page.dpi, metadata),
        Format::Svg => write_svg(w, drawing, &SvgOptions { metadata, title, ..SvgOptions::default() }),
        Format::SvgPlot => {
            write_svg(w, drawing, &SvgOptions { metadata, title, ..SvgOptions::for_plotter() })
        }
        Format::Pdf => write_pdf(w, drawing, &PdfOptions { metadata, title }),
        Format::Csv => CsvWriter::new(w, false)?.frame(0, drawing, None),
        Format::CsvFull => CsvWriter::new(w, true)?.frame(0, drawing, Some(&places_of(scene, drawing))),
        Format::Json => write_json(w, drawing),
    }
}

/// Where the stipples of a drawing of a scene lie.
pub(super) fn places_of<'a>(
    scene: &'a Scene,
    drawing: &'a Drawing,
) -> impl Fn(usize, u32) -> ([f32; 3], [f32; 3]) + 'a {
    |layer, stipple| place(scene, &drawing.layers[layer].object, stipple)
}

/// Position, in the coordinates of the file, and smooth normal of a stipple of the object of this name.
fn place(scene: &Scene, object: &str, stipple: u32) -> ([f32; 3], [f32; 3]) {
    let stock = |o: &'_ crate::Object| o.shown.clone().or_else(|| o.stock.clone());
    let found = scene.objects.iter().find(|o| o.name == object).and_then(|o| Some((o, stock(o)?)));
    let baked = found.as_ref().map(|(object, stock)| (*object, &**stock));
    let at = |(object, stock): (&crate::Object, &Stock)| {
        let i = stipple as usize;
        let (p, n) = (i < stock.len()).then(|| (stock.position.at(i), stock.normal.at(i)))?;
        let origin = object.mesh.origin;
        Some(([0, 1, 2].map(|k| (f64::from(p[k]) + origin[k]) as f32), n.to_array()))
    };
    baked.and_then(at).unwrap_or(([f32::NAN; 3], [f32::NAN; 3]))
}
