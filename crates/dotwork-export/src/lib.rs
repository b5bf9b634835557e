//! Writes a drawing to files: SVG, PDF, PNG, TIFF, CSV and JSON, atomically.
//!
//! * [`write_atomic`] and [`check_writable`]: an output exists whole or not at all;
//! * [`write_png`] and [`write_tiff`]: a raster with its physical resolution and text;
//! * [`bilevel()`], [`write_png_bilevel`] and [`write_tiff_bilevel`]: a black-and-white plate for the press;
//! * [`write_pdf`]: the page in its size, editable marks, layers;
//! * [`embedded_settings`] and [`is_plate`]: the settings that any of these carries;
//! * [`CsvWriter`]: the drawing table, one row a dot;
//! * [`GifWriter`] and [`ApngWriter`]: films;
//! * [`write_json`]: the whole drawing as structure-of-arrays JSON;
//! * [`write_svg`] and [`svg_metadata`]: vectors in millimetres with the settings inside, and those read back;
//! * [`assign_pens`] and [`plot`]: what each pen draws, and in which order a plotter draws it.
//!
//! The encoders turn a picture into bytes for any [`std::io::Write`] and never open files; [`write_atomic`] opens
//! files and knows no format. The same drawing gives the same bytes everywhere.
//!
//! ```
//! use dotwork_drawing::{Color, Drawing, Page};
//! use dotwork_export::{check_writable, write_atomic, write_json};
//!
//! # let folder = tempfile::tempdir()?;
//! let path = folder.path().join("drawing.json");
//! check_writable(&path)?; // before the long work
//! let drawing = Drawing::new(Page::default(), Color::WHITE);
//! write_atomic(&path, |w| write_json(w, &drawing))?;
//! # assert!(std::fs::read_to_string(&path)?.starts_with('{'));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod atomic;
mod base64;
mod bilevel;
mod csv;
mod error;
mod film;
mod json;
mod opacity;
mod pdf;
mod pens;
pub mod plot;
mod png;
mod record;
mod samples;
mod svg;
#[cfg(test)]
mod testing;
mod text;
mod tiff;
mod xml;

pub use self::atomic::{check_writable, write_atomic};
pub use self::bilevel::{Bilevel, bilevel};
pub use self::csv::{CsvWriter, Places};
pub use self::error::ExportError;
pub use self::film::{ApngFrame, ApngWriter, GifFrame, GifWriter, apng_frame, gif_frame};
pub use self::json::write_json;
pub use self::pdf::{PdfOptions, pdf_metadata, write_pdf};
pub use self::pens::{PenError, assign_pens};
pub use self::png::{
    Pixels, RasterView, SETTINGS_KEYWORD, pixels_per_metre, png_text, write_png, write_png_bilevel,
};
pub use self::record::{embedded_settings, is_plate};
pub use self::svg::{SvgOptions, Touch, svg_metadata, write_svg};
pub use self::tiff::{tiff_metadata, write_tiff, write_tiff_bilevel};

/// What files name as the program that wrote them.
const SOFTWARE: &str = concat!("dotwork ", env!("CARGO_PKG_VERSION"));
