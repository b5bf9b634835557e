//! Files in and out: what a scene is read from, and what a drawing is written to.

mod clip;
mod film;
mod input;
mod outlook;
mod output;
mod parts;
mod plate;
mod sequence;
mod volume;
mod watch;

use std::path::PathBuf;

use dotwork_export::ExportError;
use dotwork_io::ReadError;
use dotwork_io::dots::DotsError;
use dotwork_mesh::MeshError;
use dotwork_mesh::shapes::DEMOS;
use dotwork_volume::phantom::PHANTOMS;

pub use film::{FilmFormat, FilmPath, draw_film, encode_film, encode_frames, rasterize};
pub use input::{LoadOptions, Loaded, MeshFile, load, load_with, open};
pub use outlook::Outlook;
pub use output::{Format, encode_drawing, prepare, write_drawing};
pub use parts::{Look, Meaning};
pub use plate::Plate;
pub use volume::VolumeInput;
pub(crate) use volume::preparation;
pub use watch::{Stage, Watch};

/// Why a file was not read or written. Displays as one line, `FILE: place: reason`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// A mesh file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A mesh was read and cannot be used.
    #[error("{}: {source}", one_line(input))]
    Mesh {
        /// The file or `demo:NAME`.
        input: String,
        /// What is wrong with the mesh.
        source: MeshError,
    },
    /// A volume was read and cannot be drawn.
    #[error("{}: {reason}", one_line(input))]
    Volume {
        /// The file.
        input: String,
        /// Why.
        reason: String,
    },
    /// A clip cannot be understood, or leaves nothing.
    #[error("{}: clip={clip}: {reason}", one_line(input))]
    Clip {
        /// The file.
        input: String,
        /// The clip.
        clip: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A pose is asked for that the input cannot take.
    #[error("{}: {reason}", one_line(input))]
    Pose {
        /// The file.
        input: String,
        /// Why not.
        reason: String,
    },
    /// A surface is asked for, and the input is a whole scene: a `.dots` file or a plate.
    #[error("{}: is a whole scene, not a surface", one_line(input))]
    WholeScene {
        /// The file.
        input: String,
    },
    /// A picture cannot be drawn again.
    #[error("{}: {reason}", one_line(&path.to_string_lossy()))]
    Plate {
        /// The picture.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A `.dots` file cannot be read.
    #[error(transparent)]
    Dots(#[from] DotsError),
    /// There is no such demo.
    #[error("demo:{}: there is no such demo; the demos are {}", one_line(name), demo_names())]
    UnknownDemo {
        /// The name after `demo:`.
        name: String,
    },
    /// A style file cannot be understood.
    #[error("{}:{line}: {}", one_line(&path.to_string_lossy()), one_line(reason))]
    Style {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What was expected.
        reason: String,
    },
    /// A scene file cannot be understood, or one of its objects not drawn.
    #[error("{}:{line}: {}", one_line(&path.to_string_lossy()), one_line(reason))]
    Scene {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is wrong there.
        reason: String,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] ExportError),
}

fn demo_names() -> String {
    let shapes = DEMOS.iter().map(|d| d.name);
    shapes.chain(PHANTOMS.iter().map(|(name, _)| *name)).collect::<Vec<_>>().join(", ")
}

/// Text with its control characters escaped: file names may hold line breaks.
pub(crate) fn one_line(text: &str) -> String {
    text.chars().flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] }).collect()
}
