//! What a page is: its size, samples, colours, and the strips or tiles in which they lie.

use dotwork_volume::SampleType;

use crate::error::ReadErrorKind;
use crate::volume::tiff::directory::{Directory, Tag, Tiff};

/// More samples a pixel than any volume has.
const MOST_COMPONENTS: u64 = 64;

/// How strips or tiles are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Lzw,
    Deflate,
    PackBits,
}

impl Compression {
    pub(super) fn name(self) -> &'static str {
        match self {
            Compression::None => "uncompressed",
            Compression::Lzw => "LZW",
            Compression::Deflate => "deflate",
            Compression::PackBits => "PackBits",
        }
    }

    /// How many bytes `packed` bytes can unpack to at most.
    fn most(self, packed: u64) -> u64 {
        let ratio = match self {
            Compression::None => return packed,
            _ if packed == 0 => return 0,
            // A code of 12 bits stands for at most 4096 bytes.
            Compression::Lzw => 2731,
            Compression::Deflate => crate::gzip::DEFLATE_RATIO,
            // Two bytes stand for 128.
            Compression::PackBits => 64,
        };
        packed.saturating_mul(ratio).saturating_add(4096)
    }
}

/// How samples are predicted from their neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Predictor {
    None,
    Horizontal,
    Float,
}

/// What the samples of a pixel mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Color {
    Gray,
    WhiteIsZero,
    Rgb,
    Palette,
}

/// One packed strip or tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chunk {
    pub(super) at: u64,
    pub(super) packed: u64,
}

#[derive(Debug)]
pub(super) struct Page {
    /// Where its directory stands.
    pub(super) at: usize,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) sample: SampleType,
    pub(super) components: usize,
    pub(super) color: Color,
    /// 1 if rows run down and columns to the right (TIFF 6.0, section 8).
    pub(super) orientation: u64,
    pub(super) compression: Compression,
    pub(super) predictor: Predictor,
    /// Components lie in planes of their own.
    pub(super) planar: bool,
    /// Strips are padded at the bottom only by leaving rows out; tiles are always whole.
    pub(super) tiled: bool,
    pub(super) chunk_width: usize,
    pub(super) chunk_height: usize,
    pub(super) chunks: Vec<Chunk>,
}

impl Page {
    pub(super) fn of(tiff: &Tiff, directory: &Directory) -> Result<Page, ReadErrorKind> {
        let wrong = |reason: String| ReadErrorKind::at_byte(directory.at, reason);
        let integer = |tag: Tag, default: u64| tiff.integer(directory, tag, default);
        let side = |tag: Tag, default: u64| {
            let n = integer(tag, default)?;
            // The format's own limit of 32 bits keeps the products of sides in 64.
            u32::try_from(n)
                .ok()
                .filter(|&n| n > 0)
                .map(|n| n as usize)
                .ok_or_else(|| wrong(format!("{tag:?} is {n}")))
        };
        let (width, height) = (side(Tag::Width, 0)?, side(Tag::Height, 0)?);
        let components = side(Tag::SamplesPerPixel, 1)?;
        if components as u64 > MOST_COMPONENTS {
            return Err(wrong(format!("{components} samples a pixel; up to {MOST_COMPONENTS} are read")));
        }
        let sample = sample_type(tiff, directory).map_err(|e| e.unwrap_or_else(wrong))?;
        let color = match (integer(Tag::Photometric, 1)?, components) {
            (0, _) => Color::WhiteIsZero,
            (1 | 4, _) => Color::Gray,
            (2, 3..) => Color::Rgb,
            (2, n) => return Err(wrong(format!("RGB with {n} samples a pixel"))),
            (3, _) => Color::Palette,
            (5, _) => return Err(wrong("CMYK colours are not read".into())),
            (6, _) => return Err(wrong("YCbCr colours are not read".into())),
            (8..=10, _) => return Err(wrong("L*a*b* colours are not read".into())),
            (other, _) => return Err(wrong(format!("colours of kind {other} are not read"))),
        };
        let compression = compression(integer(Tag::Compression, 1)?).map_err(wrong)?;
        if integer(Tag::FillOrder, 1)? == 2 {
            return Err(wrong("bits in reversed order are not read".into()));
        }
        let predictor = match integer(Tag::Predictor, 1)? {
            1 => Predictor::None,
            // Without compression nothing is predicted.
            _ if !matches!(compression, Compression::Lzw | Compression::Deflate) => Predictor::None,
            2 => Predictor::Horizontal,
            3 if matches!(sample, SampleType::F32 | SampleType::F64) => Predictor::Float,
            other => return Err(wrong(format!("predictor {other} for {} samples", sample.name()))),
        };
        let planar = components > 1 && integer(Tag::PlanarConfiguration, 1)? == 2;
        let tiled = tiff.count(directory, Tag::TileOffsets) > 0;
        let (chunk_width, chunk_height) = if tiled {
            (side(Tag::TileWidth, 0)?, side(Tag::TileHeight, 0)?)
        } else {
            // "All rows in one strip" is written as 2³² − 1.
            let rows = integer(Tag::RowsPerStrip, height as u64)?.min(height as u64);
            (
                width,
                usize::try_from(rows)
                    .ok()
                    .filter(|&n| n > 0)
                    .ok_or_else(|| wrong("RowsPerStrip is 0".into()))?,
            )
        };
        let mut page = Page {
            at: directory.at,
            width,
            height,
            sample,
            components,
            color,
            orientation: integer(Tag::Orientation, 1)?,
            compression,
            predictor,
            planar,
            tiled,
            chunk_width,
            chunk_height,
            chunks: Vec::new(),
        };
        page.chunks = page.find_chunks(tiff, directory)?;
        Ok(page)
    }

    fn find_chunks(&self, tiff: &Tiff, directory: &Directory) -> Result<Vec<Chunk>, ReadErrorKind> {
        let wrong = |reason: String| ReadErrorKind::at_byte(directory.at, reason);
        let (offsets, counts) = if self.tiled {
            (Tag::TileOffsets, Tag::TileByteCounts)
        } else {
            (Tag::StripOffsets, Tag::StripByteCounts)
        };
        let planes = if self.planar { self.components } else { 1 };
        let across = self.chunks_across() as u64;
        let expected = across.saturating_mul(self.chunks_down() as u64).saturating_mul(planes as u64);
        let found = tiff.count(directory, offsets);
        if found != expected {
            return Err(wrong(format!("{found} strips or tiles where {expected} are needed")));
        }
        let offsets = tiff.integers(directory, offsets, expected)?;
        let mut counts = tiff.integers(directory, counts, expected)?;
        if counts.is_empty() && self.compression == Compression::None {
            // Old writers leave them out.
            counts = (0..offsets.len()).map(|i| self.chunk_bytes(i)).collect();
        }
        if counts.len() != offsets.len() {
            return Err(wrong(format!("{} strips or tiles with {} lengths", offsets.len(), counts.len())));
        }
        let mut chunks = Vec::with_capacity(offsets.len());
        for (i, (&at, &packed)) in offsets.iter().zip(&counts).enumerate() {
            if at.checked_add(packed).is_none_or(|end| end > tiff.bytes.len() as u64) {
                return Err(wrong(format!("strip or tile {} lies beyond the file's end", i + 1)));
            }
            let needed = self.chunk_bytes(i);
            if needed > self.compression.most(packed) {
                return Err(wrong(format!(
                    "strip or tile {} of {packed} bytes cannot hold the {needed} bytes declared",
                    i + 1
                )));
            }
            chunks.push(Chunk { at, packed });
        }
        Ok(chunks)
    }

    pub(super) fn chunks_across(&self) -> usize {
        self.width.div_ceil(self.chunk_width)
    }

    pub(super) fn chunks_down(&self) -> usize {
        self.height.div_ceil(self.chunk_height)
    }

    /// Components side by side in a chunk.
    pub(super) fn chunk_components(&self) -> usize {
        if self.planar { 1 } else { self.components }
    }

    /// Rows that chunk `i` holds.
    pub(super) fn chunk_rows(&self, i: usize) -> usize {
        if self.tiled {
            return self.chunk_height;
        }
        let from = (i % self.chunks_down()) * self.chunk_height;
        self.chunk_height.min(self.height - from)
    }

    /// Unpacked bytes of chunk `i`, saturating.
    pub(super) fn chunk_bytes(&self, i: usize) -> u64 {
        let row = self.chunk_width as u64 * (self.chunk_components() * self.sample.bytes()) as u64;
        row.saturating_mul(self.chunk_rows(i) as u64)
    }

    /// Bytes of all its packed chunks, saturating.
    pub(super) fn packed_bytes(&self) -> u64 {
        self.chunks.iter().fold(0, |n, c| n.saturating_add(c.packed))
    }

    pub(super) fn first_offset(&self) -> u64 {
        self.chunks.first().map_or(0, |c| c.at)
    }
}

/// The type of the samples; the error is one of the file's structure, or a reason.
fn sample_type(tiff: &Tiff, directory: &Directory) -> Result<SampleType, Result<ReadErrorKind, String>> {
    let bits = tiff.integers(directory, Tag::BitsPerSample, MOST_COMPONENTS).map_err(Ok)?;
    let formats = tiff.integers(directory, Tag::SampleFormat, MOST_COMPONENTS).map_err(Ok)?;
    let (bit, format) = (bits.first().copied().unwrap_or(1), formats.first().copied().unwrap_or(1));
    if bits.iter().any(|&b| b != bit) || formats.iter().any(|&f| f != format) {
        return Err(Err("samples of a pixel that differ in type are not read".into()));
    }
    Ok(match (format, bit) {
        (1 | 4, 8) => SampleType::U8,
        (1 | 4, 16) => SampleType::U16,
        (1 | 4, 32) => SampleType::U32,
        (1 | 4, 64) => SampleType::U64,
        (2, 8) => SampleType::I8,
        (2, 16) => SampleType::I16,
        (2, 32) => SampleType::I32,
        (2, 64) => SampleType::I64,
        (3, 32) => SampleType::F32,
        (3, 64) => SampleType::F64,
        (3, _) => return Err(Err(format!("floats of {bit} bits are not read; 32 and 64 are"))),
        (1 | 2 | 4, _) => {
            return Err(Err(format!("samples of {bit} bits are not read; 8, 16, 32 and 64 are")));
        }
        _ => return Err(Err(format!("samples of kind {format} are not read"))),
    })
}

fn compression(code: u64) -> Result<Compression, String> {
    Ok(match code {
        1 => Compression::None,
        5 => Compression::Lzw,
        8 | 32946 => Compression::Deflate,
        32773 => Compression::PackBits,
        2..=4 => return Err("fax compression is not read".into()),
        6 | 7 => return Err("JPEG compression is not read".into()),
        34712 => return Err("JPEG 2000 compression is not read".into()),
        34887 => return Err("LERC compression is not read".into()),
        34925 => return Err("LZMA compression is not read".into()),
        50000 => return Err("Zstandard compression is not read".into()),
        50001 => return Err("WebP compression is not read".into()),
        _ => return Err(format!("compression {code} is not read")),
    })
}
