//! What can be wrong with a file, and where.

use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a file cannot be read. Displays as `FILE: place: reason` on one line, the path as it was given.
#[derive(Debug, thiserror::Error)]
#[error("{}: {kind}", one_line(&path.to_string_lossy()))]
pub struct ReadError {
    /// The file, as the caller named it.
    pub path: PathBuf,
    /// What is wrong with it.
    pub kind: ReadErrorKind,
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadErrorKind {
    /// There is no such file.
    #[error("no such file")]
    Missing,
    /// The path is a directory.
    #[error("is a directory without TIFF pages (series of other files are not read yet)")]
    Directory,
    /// The system refuses to open or read it.
    #[error("cannot be read: {0}")]
    Io(io::Error),
    /// Not a single byte.
    #[error("the file is empty")]
    Empty,
    /// A known format that has no reader; the text names it.
    #[error("is {0}, which is not read yet; {list} are", list = crate::format::mesh_formats())]
    NotReadYet(&'static str),
    /// A `.dots` file where a mesh was expected.
    #[error("is a .dots file, not a mesh")]
    Dots,
    /// None of the known formats; the text says what was seen instead.
    #[error("is none of {list} ({0})", list = crate::format::mesh_formats())]
    Unknown(String),
    /// More of something than dotwork can hold.
    #[error("{0}")]
    TooLarge(String),
    /// The gzip wrapping is damaged.
    #[error("gzip data: {0}")]
    Gzip(String),
    /// A readable file without surface.
    #[error("has no faces")]
    NoFaces,
    /// The content breaks the rules of its format.
    #[error("{place}: {reason}")]
    Malformed {
        /// Where.
        place: Place,
        /// What was expected and what was found.
        reason: String,
    },
    /// A volume or an image where a mesh was expected; the text names it.
    #[error("is {0}, not a mesh")]
    Volume(&'static str),
    /// The file needs an extension of its format that is not read; the text says which.
    #[error("needs the extension {0}, which is not read")]
    Extension(String),
    /// The file is understood and yet cannot be read as it is; the text says why.
    #[error("{0}")]
    Refused(String),
    /// Another file, which this one names, cannot be read.
    #[error("data file {}: {kind}", shortened(&file.to_string_lossy()))]
    DataFile {
        /// The other file.
        file: PathBuf,
        /// What is wrong with it.
        kind: Box<ReadErrorKind>,
    },
}

#[cfg_attr(
    not(all(feature = "ply", feature = "gltf")),
    allow(dead_code, reason = "formats left out leave helpers unused")
)]
impl ReadErrorKind {
    /// An error on a line of a text file, counted from 1.
    pub(crate) fn at_line(line: u64, reason: impl Into<String>) -> Self {
        ReadErrorKind::Malformed { place: Place::Line(line), reason: reason.into() }
    }

    /// An error at a byte of a binary file, counted from 0.
    pub(crate) fn at_byte(byte: usize, reason: impl Into<String>) -> Self {
        ReadErrorKind::Malformed { place: Place::Byte(byte as u64), reason: reason.into() }
    }

    /// An error in an object of a structured file.
    pub(crate) fn at_item(kind: &'static str, number: usize, reason: impl Into<String>) -> Self {
        ReadErrorKind::Malformed { place: Place::Item(kind, number as u64), reason: reason.into() }
    }
}

/// A place in a file; in a gzipped file, a place in what was unpacked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line, counted from 1.
    Line(u64),
    /// A byte, counted from 0.
    Byte(u64),
    /// An object of a structured file, by its kind and its number in its list, counted from 0 ("accessor 3").
    Item(&'static str, u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line(n) => write!(f, "line {n}"),
            Place::Byte(n) => write!(f, "byte {n}"),
            Place::Item(kind, n) => write!(f, "{kind} {n}"),
        }
    }
}

/// Text with its control characters escaped, so that no file name breaks the one line of a message.
pub(crate) fn one_line(text: &str) -> String {
    text.chars().flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] }).collect()
}

/// One line of text that a file names another by: its beginning and its end, where it is longer than names are.
pub(crate) fn shortened(text: &str) -> String {
    const END: usize = 120;
    let (mut rest, count) = (text.chars(), text.chars().count());
    if count <= 2 * END {
        return one_line(text);
    }
    let start: String = rest.by_ref().take(END).collect();
    let end: String = rest.skip(count - 2 * END).collect();
    format!("{}…{}", one_line(&start), one_line(&end))
}

/// A short, printable quotation of a file's content, for messages.
pub(crate) fn quote(token: &[u8]) -> String {
    const LONGEST: usize = 24;
    let shown = one_line(&String::from_utf8_lossy(&token[..token.len().min(LONGEST)]));
    let more = if token.len() > LONGEST { "…" } else { "" };
    format!("'{shown}{more}'")
}
