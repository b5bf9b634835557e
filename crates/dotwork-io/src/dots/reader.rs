//! Reading `.dots`.

use std::collections::HashSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::block::{self, Encoding};
use super::{DotsError, DotsErrorKind, Kind, MAGIC, VERSION};
use crate::checksum::checksum;
use crate::error::quote;
use crate::gzip;

/// What a file of any size may unpack to: less than a mesh file, as what is read becomes four times that in a scene.
const SMALLEST_LIMIT: u64 = 32 << 20;

/// An opened `.dots` file whose checksums all hold; sections are unpacked when they are asked for.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    bytes: Vec<u8>,
    sections: Vec<Section>,
}

#[derive(Debug)]
struct Section {
    name: String,
    kind: Kind,
    encoding: Encoding,
    raw_length: u64,
    stored: Range<usize>,
}

impl Reader {
    /// Opens a file.
    ///
    /// # Errors
    /// What [`crate::read_file`] refuses, another format or version, truncation, damage.
    pub fn open(path: impl AsRef<Path>) -> Result<Reader, DotsError> {
        let path = path.as_ref();
        match crate::file::read_bytes(path) {
            Ok(bytes) => Reader::from_bytes(path, bytes),
            Err(e) => Err(DotsError { path: path.to_path_buf(), kind: DotsErrorKind::File(e) }),
        }
    }

    /// Opens the bytes of a file; `name` appears in messages.
    ///
    /// # Errors
    /// Another format or version, truncation, damage.
    pub fn from_bytes(name: &Path, bytes: Vec<u8>) -> Result<Reader, DotsError> {
        match parse(&bytes) {
            Ok(sections) => Ok(Reader { path: name.to_path_buf(), bytes, sections }),
            Err(kind) => Err(DotsError { path: name.to_path_buf(), kind }),
        }
    }

    /// Bytes of the file.
    pub fn length(&self) -> usize {
        self.bytes.len()
    }

    /// The names of the sections, in the order in which they were written.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.sections.iter().map(|s| s.name.as_str())
    }

    /// True if there is a section of that name.
    pub fn has(&self, name: &str) -> bool {
        self.sections.iter().any(|s| s.name == name)
    }

    /// What a section holds, and how many elements.
    ///
    /// # Errors
    /// A missing section.
    pub fn describe(&self, name: &str) -> Result<(Kind, u64), DotsError> {
        self.section(name).map(|s| (s.kind, s.raw_length / s.kind.width() as u64))
    }

    /// A section of bytes.
    ///
    /// # Errors
    /// A missing section, one of another kind, one that does not unpack; so for all other sections.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>, DotsError> {
        self.raw(name, Kind::Bytes)
    }

    /// A section of text.
    ///
    /// # Errors
    /// As [`Reader::bytes`], and text that is not UTF-8.
    pub fn text(&self, name: &str) -> Result<String, DotsError> {
        String::from_utf8(self.raw(name, Kind::Text)?)
            .map_err(|_| self.error(DotsErrorKind::Invalid(format!("section '{name}' is not UTF-8"))))
    }

    /// A section of `f32`.
    ///
    /// # Errors
    /// As [`Reader::bytes`].
    pub fn f32s(&self, name: &str) -> Result<Vec<f32>, DotsError> {
        Ok(words(&self.raw(name, Kind::F32)?, f32::from_le_bytes))
    }

    /// A section of `u32`.
    ///
    /// # Errors
    /// As [`Reader::bytes`].
    pub fn u32s(&self, name: &str) -> Result<Vec<u32>, DotsError> {
        Ok(words(&self.raw(name, Kind::U32)?, u32::from_le_bytes))
    }

    /// A section of `u64`.
    ///
    /// # Errors
    /// As [`Reader::bytes`].
    pub fn u64s(&self, name: &str) -> Result<Vec<u64>, DotsError> {
        Ok(words(&self.raw(name, Kind::U64)?, u64::from_le_bytes))
    }

    /// Checks that a section has `expected` elements, before it is unpacked.
    ///
    /// # Errors
    /// A missing section or another length.
    pub fn expect_length(&self, name: &str, expected: usize) -> Result<(), DotsError> {
        let (_, found) = self.describe(name)?;
        if found == expected as u64 {
            return Ok(());
        }
        Err(self.error(DotsErrorKind::WrongLength { name: name.into(), expected: expected as u64, found }))
    }

    /// An error of this file, for the owner of its sections: "is not valid: `reason`".
    pub fn invalid(&self, reason: impl Into<String>) -> DotsError {
        self.error(DotsErrorKind::Invalid(reason.into()))
    }

    fn error(&self, kind: DotsErrorKind) -> DotsError {
        DotsError { path: self.path.clone(), kind }
    }

    fn section(&self, name: &str) -> Result<&Section, DotsError> {
        let found = self.sections.iter().find(|s| s.name == name);
        found.ok_or_else(|| self.error(DotsErrorKind::Missing(name.into())))
    }

    fn raw(&self, name: &str, kind: Kind) -> Result<Vec<u8>, DotsError> {
        let section = self.section(name)?;
        if section.kind != kind {
            let (expected, found) = (kind.name(), section.kind.name());
            return Err(self.error(DotsErrorKind::WrongKind { name: name.into(), expected, found }));
        }
        let stored = &self.bytes[section.stored.clone()];
        block::decode(section.encoding, stored, section.raw_length, kind.width())
            .map_err(|reason| self.error(DotsErrorKind::Invalid(format!("section '{name}': {reason}"))))
    }
}

/// Numbers of `N` bytes; the length was checked to be a multiple.
fn words<T, const N: usize>(raw: &[u8], from: impl Fn([u8; N]) -> T) -> Vec<T> {
    raw.as_chunks::<N>().0.iter().map(|&b| from(b)).collect()
}

/// Reads the table and checks everything that does not need unpacking.
fn parse(bytes: &[u8]) -> Result<Vec<Section>, DotsErrorKind> {
    let truncated = || DotsErrorKind::Truncated("it ends before its table does".into());
    let invalid = |reason: &str| DotsErrorKind::Invalid(reason.into());
    let mut rest = match bytes.split_first_chunk::<8>() {
        Some((magic, rest)) if *magic == MAGIC => rest,
        None if !bytes.is_empty() && MAGIC.starts_with(bytes) => return Err(truncated()),
        _ => return Err(DotsErrorKind::NotDots),
    };
    let version = u32::from_le_bytes(take(&mut rest).ok_or_else(truncated)?);
    if version != VERSION {
        return Err(DotsErrorKind::Version(version));
    }
    let count = u32::from_le_bytes(take(&mut rest).ok_or_else(truncated)?);
    let table_length = u64::from_le_bytes(take(&mut rest).ok_or_else(truncated)?);
    let header = bytes.len() - rest.len();
    // Compared before anything is added to it: the declared length may be anything.
    if table_length > rest.len() as u64 {
        return Err(truncated());
    }
    let (mut table, mut rest) = rest.split_at(table_length as usize);
    let declared = u64::from_le_bytes(take(&mut rest).ok_or_else(truncated)?);
    if checksum(&bytes[..header + table.len()]) != declared {
        return Err(DotsErrorKind::Checksum("its table".into()));
    }
    let mut sections = Vec::new();
    let mut names = HashSet::new();
    let mut at = bytes.len() - rest.len();
    for _ in 0..count {
        let entry = entry(&mut table).ok_or_else(|| invalid("its table is broken"))?;
        let end = usize::try_from(entry.stored_length).ok().and_then(|length| at.checked_add(length));
        let Some(end) = end.filter(|&end| end <= bytes.len()) else {
            let left = bytes.len() - at;
            let (name, length) = (quote(entry.name.as_bytes()), entry.stored_length);
            return Err(DotsErrorKind::Truncated(format!("section {name} has {left} bytes of {length}")));
        };
        if checksum(&bytes[at..end]) != entry.checksum {
            return Err(DotsErrorKind::Checksum(format!("section {}", quote(entry.name.as_bytes()))));
        }
        block::check_lengths(entry.encoding, entry.stored_length, entry.raw_length, entry.kind.width())
            .map_err(|reason| invalid(&format!("section {}: {reason}", quote(entry.name.as_bytes()))))?;
        if !names.insert(entry.name.clone()) {
            return Err(invalid(&format!("section {} is there twice", quote(entry.name.as_bytes()))));
        }
        let Entry { name, kind, encoding, raw_length, .. } = entry;
        sections.push(Section { name, kind, encoding, raw_length, stored: at..end });
        at = end;
    }
    if !table.is_empty() {
        return Err(invalid("its table is longer than its sections"));
    }
    let unpacked = sections.iter().fold(0u64, |sum, s| sum.saturating_add(s.raw_length));
    let limit = gzip::limit_of(bytes.len(), SMALLEST_LIMIT);
    if unpacked > limit {
        return Err(invalid(&format!(
            "it unpacks to {unpacked} bytes, more than the {} MiB of any scene of its size",
            limit >> 20
        )));
    }
    if at < bytes.len() {
        return Err(invalid(&format!("{} bytes follow the last section", bytes.len() - at)));
    }
    Ok(sections)
}

struct Entry {
    name: String,
    kind: Kind,
    encoding: Encoding,
    raw_length: u64,
    stored_length: u64,
    checksum: u64,
}

/// The next entry of the table; `None` if it is broken.
fn entry(table: &mut &[u8]) -> Option<Entry> {
    let [name_length] = take(table)?;
    let (name, after) = table.split_at_checked(name_length.into())?;
    *table = after;
    let [kind, encoding] = take(table)?;
    Some(Entry {
        name: String::from_utf8(name.to_vec()).ok()?,
        kind: *Kind::ALL.get(usize::from(kind))?,
        encoding: *Encoding::ALL.get(usize::from(encoding))?,
        raw_length: u64::from_le_bytes(take(table)?),
        stored_length: u64::from_le_bytes(take(table)?),
        checksum: u64::from_le_bytes(take(table)?),
    })
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (head, rest) = bytes.split_first_chunk::<N>()?;
    *bytes = rest;
    Some(*head)
}
