//! The structure of a TIFF file: a chain of directories, each a list of tagged values.

use std::collections::BTreeSet;

use crate::error::ReadErrorKind;

/// More pages than any stack has.
const MOST_PAGES: usize = 1 << 20;

/// A TIFF file, as bytes and the way to read numbers from them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiff<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) big_endian: bool,
    /// BigTIFF: offsets and counts of 64 bits.
    pub(super) big: bool,
}

/// A directory: one page.
#[derive(Debug)]
pub(super) struct Directory {
    /// Where it stands.
    pub(super) at: usize,
    entries: Vec<Entry>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    tag: u16,
    kind: u16,
    count: u64,
    /// Where the values stand.
    values: u64,
}

/// The tags that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub(super) enum Tag {
    NewSubfileType = 254,
    SubfileType = 255,
    Width = 256,
    Height = 257,
    BitsPerSample = 258,
    Compression = 259,
    Photometric = 262,
    FillOrder = 266,
    Description = 270,
    StripOffsets = 273,
    Orientation = 274,
    SamplesPerPixel = 277,
    RowsPerStrip = 278,
    StripByteCounts = 279,
    XResolution = 282,
    YResolution = 283,
    PlanarConfiguration = 284,
    Software = 305,
    Predictor = 317,
    TileWidth = 322,
    TileHeight = 323,
    TileOffsets = 324,
    TileByteCounts = 325,
    SampleFormat = 339,
}

impl<'a> Tiff<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, ReadErrorKind> {
        let (big_endian, version) = match bytes {
            [b'I', b'I', low, high, ..] => (false, u16::from_le_bytes([*low, *high])),
            [b'M', b'M', high, low, ..] => (true, u16::from_be_bytes([*high, *low])),
            _ => return Err(ReadErrorKind::at_byte(0, "does not begin as a TIFF file")),
        };
        if version != 42 && version != 43 {
            return Err(ReadErrorKind::at_byte(2, format!("TIFF version {version}; 42 and 43 are read")));
        }
        Ok(Tiff { bytes, big_endian, big: version == 43 })
    }

    fn number(&self, at: u64, width: usize) -> Result<u64, ReadErrorKind> {
        let found = usize::try_from(at).ok().and_then(|at| self.bytes.get(at..)?.get(..width));
        let found = found.ok_or_else(|| {
            ReadErrorKind::at_byte(self.bytes.len(), format!("the file ends before its byte {at}"))
        })?;
        let fold = |n: u64, b: &u8| n << 8 | u64::from(*b);
        Ok(if self.big_endian { found.iter().fold(0, fold) } else { found.iter().rev().fold(0, fold) })
    }

    /// Every directory of the chain, at least one.
    pub(super) fn directories(&self) -> Result<Vec<Directory>, ReadErrorKind> {
        let mut next = if self.big { self.number(8, 8)? } else { self.number(4, 4)? };
        let mut seen = BTreeSet::new();
        // Directories that overlap would make a small file large.
        let mut budget = self.bytes.len() / self.entry_bytes() as usize;
        let mut found = Vec::new();
        while next != 0 {
            if !seen.insert(next) {
                return Err(ReadErrorKind::at_byte(next as usize, "its pages follow each other in a circle"));
            }
            if found.len() == MOST_PAGES {
                return Err(ReadErrorKind::TooLarge(format!("holds more than {MOST_PAGES} pages")));
            }
            let (directory, after) = self.directory(next)?;
            budget = budget.checked_sub(directory.entries.len()).ok_or_else(|| {
                ReadErrorKind::at_byte(directory.at, "its pages declare more entries than the file holds")
            })?;
            found.push(directory);
            next = after;
        }
        if found.is_empty() {
            return Err(ReadErrorKind::at_byte(4, "holds no page"));
        }
        Ok(found)
    }

    /// Bytes of an entry of a directory.
    fn entry_bytes(&self) -> u64 {
        if self.big { 20 } else { 12 }
    }

    fn directory(&self, at: u64) -> Result<(Directory, u64), ReadErrorKind> {
        let (count_width, offset_width) = if self.big { (8, 8) } else { (2, 4) };
        let entry_bytes = self.entry_bytes();
        let count = self.number(at, count_width)?;
        // Far more than a page has, and few enough that no sum below can overflow.
        if count > 4096 || at > self.bytes.len() as u64 {
            return Err(ReadErrorKind::at_byte(at as usize, format!("a page with {count} entries")));
        }
        let start = at + count_width as u64;
        let mut entries = Vec::with_capacity(count as usize);
        for i in 0..count {
            let at = start + i * entry_bytes;
            let tag = self.number(at, 2)? as u16;
            let kind = self.number(at + 2, 2)? as u16;
            let count = self.number(at + 4, offset_width)?;
            let field = at + 4 + offset_width as u64;
            let inline = count.saturating_mul(width_of(kind) as u64) <= offset_width as u64;
            let values = if inline { field } else { self.number(field, offset_width)? };
            entries.push(Entry { tag, kind, count, values });
        }
        let next = self.number(start + count * entry_bytes, offset_width)?;
        Ok((Directory { at: at as usize, entries }, next))
    }

    fn find(&self, directory: &Directory, tag: Tag) -> Option<Entry> {
        directory.entries.iter().copied().find(|e| e.tag == tag as u16)
    }

    fn wrong(directory: &Directory, tag: Tag, reason: &str) -> ReadErrorKind {
        ReadErrorKind::at_byte(directory.at, format!("{tag:?}: {reason}"))
    }

    /// How many values a tag has.
    pub(super) fn count(&self, directory: &Directory, tag: Tag) -> u64 {
        self.find(directory, tag).map_or(0, |e| e.count)
    }

    /// The first whole numbers of a tag, up to `most`; empty if the page has none. Pages may share their lists, so that
    /// one that is read whole for each of them could take forever.
    pub(super) fn integers(
        &self,
        directory: &Directory,
        tag: Tag,
        most: u64,
    ) -> Result<Vec<u64>, ReadErrorKind> {
        let Some(entry) = self.find(directory, tag) else { return Ok(Vec::new()) };
        let width = match entry.kind {
            1 | 7 => 1,
            3 => 2,
            4 | 13 => 4,
            16 | 18 => 8,
            kind => return Err(Self::wrong(directory, tag, &format!("values of type {kind}, not integers"))),
        };
        // Whether they are there is known before memory is taken.
        let end = entry.count.checked_mul(width).and_then(|n| n.checked_add(entry.values));
        if end.is_none_or(|end| end > self.bytes.len() as u64) {
            return Err(Self::wrong(
                directory,
                tag,
                &format!("{} values beyond the file's end", entry.count),
            ));
        }
        (0..entry.count.min(most)).map(|i| self.number(entry.values + i * width, width as usize)).collect()
    }

    /// The first whole number of a tag, or `default` if the page has none.
    pub(super) fn integer(
        &self,
        directory: &Directory,
        tag: Tag,
        default: u64,
    ) -> Result<u64, ReadErrorKind> {
        Ok(self.integers(directory, tag, 1)?.first().copied().unwrap_or(default))
    }

    /// The text of a tag; empty if there is none or it cannot be read.
    pub(super) fn text(&self, directory: &Directory, tag: Tag) -> String {
        let bytes = self.find(directory, tag).filter(|e| matches!(e.kind, 1 | 2 | 7)).and_then(|e| {
            let (at, count) = (usize::try_from(e.values).ok()?, usize::try_from(e.count).ok()?);
            self.bytes.get(at..)?.get(..count)
        });
        let bytes = bytes.unwrap_or_default();
        let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
        String::from_utf8_lossy(&bytes[..end]).into_owned()
    }

    /// The first fraction of a tag.
    pub(super) fn fraction(&self, directory: &Directory, tag: Tag) -> Option<f64> {
        let entry = self.find(directory, tag).filter(|e| e.kind == 5 && e.count > 0)?;
        let above = self.number(entry.values, 4).ok()?;
        let below = self.number(entry.values.checked_add(4)?, 4).ok()?;
        (below > 0).then(|| above as f64 / below as f64)
    }

    /// True for a page that is another one at reduced size.
    pub(super) fn is_thumbnail(&self, directory: &Directory) -> Result<bool, ReadErrorKind> {
        Ok(self.integer(directory, Tag::NewSubfileType, 0)? & 1 == 1
            || self.integer(directory, Tag::SubfileType, 0)? == 2)
    }
}

/// Bytes of a value of a type.
fn width_of(kind: u16) -> usize {
    match kind {
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16..=18 => 8,
        _ => 1,
    }
}
