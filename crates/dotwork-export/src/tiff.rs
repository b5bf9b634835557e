//! TIFF for the press: bilevel plates in Group 4, grey and colour in deflate, with their resolution and settings.
//!
//! TIFF 6.0, little-endian, one directory before the strips. Strips are coded side by side; each is small enough that
//! a reader needs little memory. The settings are the `ImageDescription`, in UTF-8.

mod g4;

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;

use crate::bilevel::Bilevel;
use crate::png::RasterView;

/// A strip has about this many bytes before it is coded.
const STRIP_BYTES: usize = 1 << 18;

/// Level of deflate: above it time grows faster than files shrink.
const DEFLATE_LEVEL: u32 = 4;

/// Numbers of tags, TIFF 6.0 (and Adobe's supplement 2 for deflate).
mod tag {
    pub const WIDTH: u16 = 256;
    pub const HEIGHT: u16 = 257;
    pub const BITS_PER_SAMPLE: u16 = 258;
    pub const COMPRESSION: u16 = 259;
    pub const PHOTOMETRIC: u16 = 262;
    pub const IMAGE_DESCRIPTION: u16 = 270;
    pub const STRIP_OFFSETS: u16 = 273;
    pub const SAMPLES_PER_PIXEL: u16 = 277;
    pub const ROWS_PER_STRIP: u16 = 278;
    pub const STRIP_BYTE_COUNTS: u16 = 279;
    pub const X_RESOLUTION: u16 = 282;
    pub const Y_RESOLUTION: u16 = 283;
    pub const RESOLUTION_UNIT: u16 = 296;
    pub const SOFTWARE: u16 = 305;
    pub const PREDICTOR: u16 = 317;
}

/// Writes a raster as TIFF, deflated, with `dpi` pixels an inch and the settings that made it.
///
/// # Errors
/// What the writer refuses; [`io::ErrorKind::InvalidInput`] if the slice does not hold `width · height` pixels, a side
/// is 0, the settings hold a zero byte, or the file would be larger than 4 GiB.
pub fn write_tiff<W: Write>(
    writer: W,
    raster: &RasterView<'_>,
    dpi: f32,
    settings: Option<&str>,
) -> io::Result<()> {
    let RasterView { width, height, .. } = *raster;
    let (samples, bytes) = raster.samples()?;
    if samples > 3 {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "a TIFF of transparent pixels is not written",
        ));
    }
    let row_bytes = width as usize * samples;
    let strips = Strips::new(bytes, row_bytes, |rows| {
        let mut zlib = ZlibEncoder::new(Vec::with_capacity(rows.len() / 4), Compression::new(DEFLATE_LEVEL));
        let mut line = vec![0; row_bytes];
        for row in rows.chunks_exact(row_bytes) {
            // Predictor 2: each sample as its difference from the one to its left.
            line[..samples].copy_from_slice(&row[..samples]);
            for i in samples..row_bytes {
                line[i] = row[i].wrapping_sub(row[i - samples]);
            }
            // A vector takes everything.
            let _ = zlib.write_all(&line);
        }
        zlib.finish().unwrap_or_default()
    });
    let photometric = if samples == 1 { 1 } else { 2 };
    let mut file = Directory::new(width, height, dpi, settings, &strips)?;
    file.shorts(tag::BITS_PER_SAMPLE, &[8, 8, 8][..samples]);
    file.shorts(tag::COMPRESSION, &[8]);
    file.shorts(tag::PHOTOMETRIC, &[photometric]);
    file.shorts(tag::SAMPLES_PER_PIXEL, &[samples as u16]);
    file.shorts(tag::PREDICTOR, &[2]);
    file.write(writer, &strips)
}

/// Writes a plate as TIFF, one bit a pixel in CCITT Group 4, with `dpi` pixels an inch and the settings that made it.
///
/// # Errors
/// As [`write_tiff`].
pub fn write_tiff_bilevel<W: Write>(
    writer: W,
    plate: &Bilevel,
    dpi: f32,
    settings: Option<&str>,
) -> io::Result<()> {
    plate.check()?;
    let Bilevel { width, height, ref rows } = *plate;
    let row_bytes = plate.row_bytes();
    let strips = Strips::new(rows, row_bytes, |rows| g4::encode(rows, width as usize, row_bytes));
    let mut file = Directory::new(width, height, dpi, settings, &strips)?;
    file.shorts(tag::BITS_PER_SAMPLE, &[1]);
    file.shorts(tag::COMPRESSION, &[4]);
    // 0 is white, as in a fax.
    file.shorts(tag::PHOTOMETRIC, &[0]);
    file.shorts(tag::SAMPLES_PER_PIXEL, &[1]);
    file.write(writer, &strips)
}

/// Coded strips.
struct Strips {
    rows_each: usize,
    coded: Vec<Vec<u8>>,
}

impl Strips {
    fn new(bytes: &[u8], row_bytes: usize, code: impl Fn(&[u8]) -> Vec<u8> + Send + Sync) -> Strips {
        let rows_each = (STRIP_BYTES / row_bytes).max(1);
        let coded = bytes.par_chunks(rows_each * row_bytes).map(code).collect();
        Strips { rows_each, coded }
    }
}

/// A directory in the making: tags with their type, count and value.
struct Directory {
    entries: Vec<(u16, u16, u32, Vec<u8>)>,
}

impl Directory {
    fn new(
        width: u32,
        height: u32,
        dpi: f32,
        settings: Option<&str>,
        strips: &Strips,
    ) -> io::Result<Directory> {
        let mut file = Directory { entries: Vec::new() };
        file.longs(tag::WIDTH, &[width]);
        file.longs(tag::HEIGHT, &[height]);
        file.longs(tag::ROWS_PER_STRIP, &[u32::try_from(strips.rows_each).unwrap_or(u32::MAX).min(height)]);
        // Ten-thousandths only where they are needed.
        let dpi = if dpi.is_finite() { f64::from(dpi).clamp(0.0, 400_000.0) } else { 0.0 };
        let ratio = if dpi.fract() == 0.0 { [dpi as u32, 1] } else { [(dpi * 1e4).round() as u32, 10_000] };
        for tag in [tag::X_RESOLUTION, tag::Y_RESOLUTION] {
            let bytes = ratio.iter().flat_map(|n| n.to_le_bytes()).collect();
            file.entries.push((tag, 5, 1, bytes));
        }
        file.shorts(tag::RESOLUTION_UNIT, &[2]);
        file.text(tag::SOFTWARE, crate::SOFTWARE);
        if let Some(settings) = settings {
            if settings.contains('\0') {
                return Err(invalid("the settings hold a zero byte"));
            }
            file.text(tag::IMAGE_DESCRIPTION, settings);
        }
        Ok(file)
    }

    fn shorts(&mut self, tag: u16, values: &[u16]) {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.entries.push((tag, 3, values.len() as u32, bytes));
    }

    fn longs(&mut self, tag: u16, values: &[u32]) {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.entries.push((tag, 4, values.len() as u32, bytes));
    }

    fn text(&mut self, tag: u16, text: &str) {
        let bytes = [text.as_bytes(), b"\0"].concat();
        self.entries.push((tag, 2, bytes.len() as u32, bytes));
    }

    /// Writes header, directory, values and strips.
    fn write<W: Write>(mut self, mut writer: W, strips: &Strips) -> io::Result<()> {
        let counts: Vec<u32> = strips.coded.iter().map(|s| s.len() as u32).collect();
        self.longs(tag::STRIP_BYTE_COUNTS, &counts);
        self.longs(tag::STRIP_OFFSETS, &counts);
        self.entries.sort_by_key(|e| e.0);
        // Header, count of entries, entries of 12 bytes, place of the next directory; then what exceeds 4 bytes.
        let values_at = 8 + 2 + 12 * self.entries.len() + 4;
        let padded = |n: usize| n.next_multiple_of(2);
        let strips_at = values_at
            + self.entries.iter().filter(|e| e.3.len() > 4).map(|e| padded(e.3.len())).sum::<usize>();
        let end = strips_at as u64 + strips.coded.iter().map(|s| padded(s.len()) as u64).sum::<u64>();
        if end > u64::from(u32::MAX) {
            return Err(invalid("a TIFF file cannot be larger than 4 GiB"));
        }
        let mut at = strips_at;
        if let Some(offsets) = self.entries.iter_mut().find(|e| e.0 == tag::STRIP_OFFSETS) {
            offsets.3.clear();
            for strip in &strips.coded {
                offsets.3.extend_from_slice(&(at as u32).to_le_bytes());
                at += padded(strip.len());
            }
        }
        let mut head = b"II*\0\x08\0\0\0".to_vec();
        head.extend_from_slice(&(self.entries.len() as u16).to_le_bytes());
        let mut values = Vec::new();
        for (tag, kind, count, bytes) in &self.entries {
            head.extend_from_slice(&tag.to_le_bytes());
            head.extend_from_slice(&kind.to_le_bytes());
            head.extend_from_slice(&count.to_le_bytes());
            if bytes.len() <= 4 {
                let mut field = [0; 4];
                field[..bytes.len()].copy_from_slice(bytes);
                head.extend_from_slice(&field);
            } else {
                head.extend_from_slice(&((values_at + values.len()) as u32).to_le_bytes());
                values.extend_from_slice(bytes);
                values.resize(padded(values.len()), 0);
            }
        }
        head.extend_from_slice(&[0; 4]);
        writer.write_all(&head)?;
        writer.write_all(&values)?;
        for strip in &strips.coded {
            writer.write_all(strip)?;
            if strip.len() % 2 == 1 {
                writer.write_all(&[0])?;
            }
        }
        Ok(())
    }
}

fn invalid(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what)
}

/// The settings that [`write_tiff`] or [`write_tiff_bilevel`] put into a TIFF; `None` if the bytes are no TIFF or hold
/// none of ours (the `Software` of the file must be dotwork).
///
/// Never panics, whatever the bytes.
pub fn tiff_metadata(bytes: &[u8]) -> Option<String> {
    let big_endian = match bytes.get(..4)? {
        b"II*\0" => false,
        b"MM\0*" => true,
        _ => return None,
    };
    let file = Fields { bytes, big_endian };
    let directory = file.long(4)?;
    let entries = (0..file.short(directory)?).map(|k| directory + 2 + 12 * usize::from(k));
    let text = |wanted: u16| {
        let at =
            entries.clone().find(|&at| file.short(at) == Some(wanted) && file.short(at + 2) == Some(2))?;
        let count = file.long(at + 4)?;
        let from = if count <= 4 { at + 8 } else { file.long(at + 8)? };
        let text = bytes.get(from..from.checked_add(count)?)?;
        let end = text.iter().position(|&b| b == 0).unwrap_or(text.len());
        std::str::from_utf8(&text[..end]).ok()
    };
    text(tag::SOFTWARE).filter(|s| s.starts_with("dotwork"))?;
    text(tag::IMAGE_DESCRIPTION).map(str::to_owned)
}

/// Numbers of a file in its byte order; `None` beyond its end.
struct Fields<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl Fields<'_> {
    fn array<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        self.bytes.get(at..at.checked_add(N)?)?.try_into().ok()
    }

    fn short(&self, at: usize) -> Option<u16> {
        let bytes = self.array(at)?;
        Some(if self.big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    }

    fn long(&self, at: usize) -> Option<usize> {
        let bytes = self.array(at)?;
        usize::try_from(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
            .ok()
    }
}

#[cfg(test)]
mod tests;
