//! The `.dots` container: named arrays in one checked, compressed file.
//!
//! What the arrays mean is their owner's business; here is only the box. All numbers are little-endian.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | magic `89 44 4F 54 53 0D 0A 1A`: the high byte and the line ends reveal a transfer that was not binary |
//! | 4 | version of the container, [`VERSION`] |
//! | 4 | number of sections |
//! | 8 | length of the table |
//! | … | the table: per section the length of its name (1), its name, its [`Kind`] (1), its encoding (1), its raw length (8), its stored length (8), the [`checksum`](crate::checksum()) of its stored bytes (8) |
//! | 8 | checksum of everything above |
//! | … | the stored bytes of the sections, in the order of the table, to the end of the file |
//!
//! Every byte is under one checksum and every length is known, so that any flipped byte and any truncation is
//! detected on opening.
//!
//! The raw bytes of a section are cut into blocks of 1 MiB. Encoding 0: each block is one stream; encoding 1: each
//! block is as many streams as its numbers have bytes, the first bytes of all numbers, then the second ones, and so on
//! (the writer takes what makes a sample of the section smaller). The stored bytes are the stored length of every
//! stream (4 each), then the streams; one as long as its raw bytes is plain, a shorter one is raw deflate. Blocks are
//! packed and unpacked in parallel; the same sections give the same bytes on any number of threads.

mod block;
mod reader;
mod writer;

use std::path::{Path, PathBuf};

use crate::error::{ReadErrorKind, one_line};

pub use reader::Reader;
pub use writer::Writer;

/// The first eight bytes of every `.dots` file.
pub const MAGIC: [u8; 8] = *b"\x89DOTS\r\n\x1a";

/// The version of the container that this crate writes and reads.
pub const VERSION: u32 = 1;

/// True if a file that begins with `prefix` (8 bytes or more) is a `.dots` file, of whatever version.
pub fn is_dots(prefix: &[u8]) -> bool {
    prefix.starts_with(&MAGIC)
}

/// True if the file at `path` can be opened and begins as a `.dots` file.
pub fn is_dots_file(path: &Path) -> bool {
    use std::io::Read;
    let mut prefix = [0; 8];
    std::fs::File::open(path).and_then(|mut f| f.read_exact(&mut prefix)).is_ok() && is_dots(&prefix)
}

/// What a section holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Bytes of any meaning.
    Bytes,
    /// UTF-8 text.
    Text,
    /// `f32` numbers.
    F32,
    /// `u32` numbers.
    U32,
    /// `u64` numbers.
    U64,
}

impl Kind {
    const ALL: [Kind; 5] = [Kind::Bytes, Kind::Text, Kind::F32, Kind::U32, Kind::U64];

    /// Bytes of one element.
    pub fn width(self) -> usize {
        match self {
            Kind::Bytes | Kind::Text => 1,
            Kind::F32 | Kind::U32 => 4,
            Kind::U64 => 8,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Kind::Bytes => "bytes",
            Kind::Text => "text",
            Kind::F32 => "f32",
            Kind::U32 => "u32",
            Kind::U64 => "u64",
        }
    }
}

/// Why a `.dots` file cannot be read. Displays as `FILE: reason` on one line, the path as it was given.
#[derive(Debug, thiserror::Error)]
#[error("{}: {kind}", one_line(&path.to_string_lossy()))]
pub struct DotsError {
    /// The file, as the caller named it.
    pub path: PathBuf,
    /// What is wrong with it.
    pub kind: DotsErrorKind,
}

/// What is wrong with a `.dots` file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DotsErrorKind {
    /// The file cannot be read at all.
    #[error("{0}")]
    File(ReadErrorKind),
    /// The magic is missing.
    #[error("is not a .dots file")]
    NotDots,
    /// A version that this crate does not know.
    #[error("is a .dots file of version {0}; this dotwork reads version {VERSION}")]
    Version(u32),
    /// The file ends early; the text says where.
    #[error("is truncated: {0}")]
    Truncated(String),
    /// Bytes changed since the file was written; the text names the part.
    #[error("is damaged: the checksum of {0} does not match")]
    Checksum(String),
    /// The checksums hold, but the content makes no sense.
    #[error("is not valid: {0}")]
    Invalid(String),
    /// There is no section of that name.
    #[error("has no section '{0}'")]
    Missing(String),
    /// A section holds something else than was asked for.
    #[error("section '{name}' holds {found}, not {expected}")]
    WrongKind {
        /// The section.
        name: String,
        /// What was asked for.
        expected: &'static str,
        /// What it holds.
        found: &'static str,
    },
    /// A section has another length than its neighbours demand.
    #[error("section '{name}' holds {found} elements, not {expected}")]
    WrongLength {
        /// The section.
        name: String,
        /// Elements asked for.
        expected: u64,
        /// Elements it holds.
        found: u64,
    },
}
