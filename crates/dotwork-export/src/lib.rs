//! Writes a drawing to files: PNG, CSV and JSON, atomically.
//!
//! * [`write_atomic`] and [`check_writable`]: an output exists whole or not at all;
//! * [`write_png`]: a raster with its physical resolution and text;
//! * [`CsvWriter`]: the drawing table, one row a dot;
//! * [`write_json`]: the whole drawing as structure-of-arrays JSON.
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
mod csv;
mod error;
mod json;
mod png;
#[cfg(test)]
mod testing;
mod text;

pub use self::atomic::{check_writable, write_atomic};
pub use self::csv::{CsvWriter, Places};
pub use self::error::ExportError;
pub use self::json::write_json;
pub use self::png::{Pixels, RasterView, pixels_per_metre, write_png};
