//! Writing `.dots`.

use rayon::prelude::*;

use super::block::{self, Encoding};
use super::{Kind, MAGIC, VERSION};
use crate::checksum::checksum;

/// Collects sections and packs them.
///
/// ```
/// use dotwork_io::dots::{Reader, Writer};
///
/// let bytes = Writer::new().text("style", "papers").section_f32("x", &[0.5, 0.25]).finish();
/// let reader = Reader::from_bytes("test.dots".as_ref(), bytes)?;
/// assert_eq!(reader.f32s("x")?, [0.5, 0.25]);
/// # Ok::<(), dotwork_io::dots::DotsError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Writer {
    sections: Vec<Section>,
}

#[derive(Clone, Debug)]
struct Section {
    name: String,
    kind: Kind,
    raw: Vec<u8>,
}

impl Writer {
    /// A file without sections.
    pub fn new() -> Writer {
        Writer::default()
    }

    /// Adds a section of bytes.
    ///
    /// # Panics
    /// If the name is taken, or longer than 255 bytes; so do all other ways to add a section.
    pub fn section(&mut self, name: &str, bytes: Vec<u8>) -> &mut Self {
        self.add(name, Kind::Bytes, bytes)
    }

    /// Adds a section of text.
    pub fn text(&mut self, name: &str, text: &str) -> &mut Self {
        self.add(name, Kind::Text, text.as_bytes().to_vec())
    }

    /// Adds a section of `f32`, kept bit by bit.
    pub fn section_f32(&mut self, name: &str, values: &[f32]) -> &mut Self {
        self.add(name, Kind::F32, values.iter().flat_map(|v| v.to_le_bytes()).collect())
    }

    /// Adds a section of `u32`.
    pub fn section_u32(&mut self, name: &str, values: &[u32]) -> &mut Self {
        self.add(name, Kind::U32, values.iter().flat_map(|v| v.to_le_bytes()).collect())
    }

    /// Adds a section of `u64`.
    pub fn section_u64(&mut self, name: &str, values: &[u64]) -> &mut Self {
        self.add(name, Kind::U64, values.iter().flat_map(|v| v.to_le_bytes()).collect())
    }

    fn add(&mut self, name: &str, kind: Kind, raw: Vec<u8>) -> &mut Self {
        assert!(name.len() <= 255, "the section name '{name}' is longer than 255 bytes");
        assert!(self.sections.iter().all(|s| s.name != name), "the section '{name}' is written twice");
        self.sections.push(Section { name: name.into(), kind, raw });
        self
    }

    /// The bytes of the file; sections in the order in which they were added.
    pub fn finish(&self) -> Vec<u8> {
        self.assemble(block::encode)
    }

    /// As [`Writer::finish`], with every section as it is: readers that let a file ask for no more than its length allows
    /// then let it ask for the most.
    pub fn finish_plain(&self) -> Vec<u8> {
        self.assemble(|raw, _| block::plain(raw))
    }

    fn assemble(&self, encode: impl Fn(&[u8], usize) -> (Encoding, Vec<u8>) + Sync) -> Vec<u8> {
        let packed: Vec<_> = self.sections.par_iter().map(|s| encode(&s.raw, s.kind.width())).collect();
        let mut table = Vec::new();
        for (section, (encoding, stored)) in self.sections.iter().zip(&packed) {
            table.push(section.name.len() as u8);
            table.extend_from_slice(section.name.as_bytes());
            table.push(section.kind as u8);
            table.push(*encoding as u8);
            table.extend_from_slice(&(section.raw.len() as u64).to_le_bytes());
            table.extend_from_slice(&(stored.len() as u64).to_le_bytes());
            table.extend_from_slice(&checksum(stored).to_le_bytes());
        }
        let body: usize = packed.iter().map(|(_, stored)| stored.len()).sum();
        let mut file = Vec::with_capacity(32 + table.len() + body);
        file.extend_from_slice(&MAGIC);
        file.extend_from_slice(&VERSION.to_le_bytes());
        file.extend_from_slice(&(self.sections.len() as u32).to_le_bytes());
        file.extend_from_slice(&(table.len() as u64).to_le_bytes());
        file.extend_from_slice(&table);
        file.extend_from_slice(&checksum(&file).to_le_bytes());
        packed.iter().for_each(|(_, stored)| file.extend_from_slice(stored));
        file
    }
}
