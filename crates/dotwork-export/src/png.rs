//! PNG files that know how large they are on paper.
//!
//! Dot drawings are flat paper with small, similar discs: runs and repeats of whole bytes, which deflate finds best
//! unfiltered. Filters, made for photographs, turn equal dots on unequal rows into unequal bytes. Measured on stipple
//! drawings of 1024² pixels, 1.5 px dots, png 0.18 (time, file; grey and RGB; one core of a shared 2-core machine):
//!
//! | filter, level | grey | RGB |
//! |---|---|---|
//! | `Compression::Fast` (adaptive, fdeflate) | 3 ms, 479 kB | 8 ms, 1251 kB |
//! | `Compression::Balanced` (adaptive, 6) | 65 ms, 410 kB | 82 ms, 804 kB |
//! | none, 1 | 8 ms, 365 kB | 17 ms, 592 kB |
//! | **none, 2** | 17 ms, 331 kB | 29 ms, 500 kB |
//! | none, 4 | 29 ms, 318 kB | 46 ms, 493 kB |
//! | none, 6 | 52 ms, 315 kB | 68 ms, 489 kB |

use std::io::{self, Write};

use png::{BitDepth, ColorType, DeflateCompression, Encoder, Filter, PixelDimensions, Unit};

use crate::bilevel::Bilevel;

/// The last level before time grows faster than files shrink; see the table above.
pub(crate) const DEFLATE_LEVEL: u8 = 2;

/// The same for plates of one bit a pixel. 200,000 dots on A4 at 1200 dpi, 17 MB, one core (ms, MB): level 1: 103, 6.5;
/// 2: 202, 4.4; 4: 359, 4.1; 6: 791, 3.9.
const BILEVEL_DEFLATE_LEVEL: u8 = 4;

/// The samples of a raster, 8-bit sRGB, rows from top to bottom without gaps.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'a> {
    /// One byte a pixel.
    Grey(&'a [u8]),
    /// Three bytes a pixel: red, green, blue.
    Rgb(&'a [u8]),
    /// Four bytes a pixel: red, green, blue, opacity; the colours are not multiplied by it.
    Rgba(&'a [u8]),
}

/// A raster to be written.
#[derive(Clone, Copy, Debug)]
pub struct RasterView<'a> {
    /// Width in pixels, at least 1.
    pub width: u32,
    /// Height in pixels, at least 1.
    pub height: u32,
    /// `width · height` pixels.
    pub pixels: Pixels<'a>,
}

/// Pixels a metre at `dpi` pixels an inch, as `pHYs` counts them.
pub fn pixels_per_metre(dpi: f32) -> u32 {
    // The cast clamps to u32 and takes NaN to 0.
    (f64::from(dpi) / 0.0254).round() as u32
}

impl<'a> RasterView<'a> {
    /// Bytes a pixel, and the bytes.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidInput`] if they are not `width · height` pixels, or a side is 0.
    pub(crate) fn samples(&self) -> io::Result<(usize, &'a [u8])> {
        let RasterView { width, height, pixels } = *self;
        let (samples, bytes) = match pixels {
            Pixels::Grey(bytes) => (1, bytes),
            Pixels::Rgb(bytes) => (3, bytes),
            Pixels::Rgba(bytes) => (4, bytes),
        };
        let expected = u128::from(width) * u128::from(height) * samples as u128;
        if expected == 0 || expected != bytes.len() as u128 {
            return Err(invalid(format!(
                "a raster of {width} x {height} pixels needs {expected} bytes, not {}",
                bytes.len()
            )));
        }
        Ok((samples, bytes))
    }
}

/// Writes a raster as PNG with its physical resolution and `text`, pairs of a keyword and a value.
///
/// `ppm` is the resolution in pixels a metre ([`pixels_per_metre`]) for the `pHYs` chunk; 0 leaves the chunk out.
/// Values go into `tEXt` if Latin-1 can hold them, into `iTXt` otherwise; [`png_text`] reads them back. `text` comes
/// before the pixels, so that a reader finds it without decoding them.
///
/// # Errors
/// What the writer refuses; [`io::ErrorKind::InvalidInput`] if the slice does not hold `width · height` pixels, a side
/// is 0, a keyword is not 1 to 79 Latin-1 characters, or a value holds a zero byte.
pub fn write_png<W: Write>(
    writer: W,
    raster: &RasterView<'_>,
    ppm: u32,
    text: &[(&str, &str)],
) -> io::Result<()> {
    let (samples, bytes) = raster.samples()?;
    let mut keeper = Keeper { inner: writer, error: None };
    let mut encoder = Encoder::new(&mut keeper, raster.width, raster.height);
    encoder.set_color(match samples {
        1 => ColorType::Grayscale,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    });
    encoder.set_depth(BitDepth::Eight);
    encoder.set_deflate_compression(DeflateCompression::Level(DEFLATE_LEVEL));
    let result = finish(encoder, ppm, text, bytes);
    keeper.or_its_error(result)
}

/// Writes a plate as PNG, one bit a pixel, with its physical resolution and `text` as [`write_png`] takes them.
///
/// # Errors
/// As [`write_png`].
pub fn write_png_bilevel<W: Write>(
    writer: W,
    plate: &Bilevel,
    ppm: u32,
    text: &[(&str, &str)],
) -> io::Result<()> {
    plate.check()?;
    // PNG's 1 is white.
    let bytes: Vec<u8> = plate.rows.iter().map(|b| !b).collect();
    let mut keeper = Keeper { inner: writer, error: None };
    let mut encoder = Encoder::new(&mut keeper, plate.width, plate.height);
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::One);
    encoder.set_deflate_compression(DeflateCompression::Level(BILEVEL_DEFLATE_LEVEL));
    let result = finish(encoder, ppm, text, &bytes);
    keeper.or_its_error(result)
}

/// Adds resolution and text, then writes the pixels.
fn finish<W: Write>(
    mut encoder: Encoder<'_, W>,
    ppm: u32,
    text: &[(&str, &str)],
    bytes: &[u8],
) -> io::Result<()> {
    encoder.set_filter(Filter::NoFilter);
    if ppm > 0 {
        encoder.set_pixel_dims(Some(PixelDimensions { xppu: ppm, yppu: ppm, unit: Unit::Meter }));
    }
    for &(keyword, value) in text {
        check_keyword(keyword)?;
        if value.contains('\0') {
            return Err(invalid(format!("the text for {keyword} holds a zero byte")));
        }
        // PNG's Latin-1 leaves out the control characters, save the line feed.
        let latin1 = |c: char| matches!(c, '\n' | ' '..='~' | '\u{a0}'..='\u{ff}');
        if value.chars().all(latin1) {
            encoder.add_text_chunk(keyword.into(), value.into())?;
        } else {
            encoder.add_itxt_chunk(keyword.into(), value.into())?;
        }
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    Ok(())
}

/// Keeps the error of a writer, of which the encoder would pass on no kind.
struct Keeper<W> {
    inner: W,
    error: Option<io::Error>,
}

impl<W> Keeper<W> {
    fn or_its_error(self, result: io::Result<()>) -> io::Result<()> {
        result.map_err(|e| self.error.unwrap_or(e))
    }

    fn keep<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        result.map_err(|e| {
            let kind = e.kind();
            // An interrupted call is made again.
            if kind != io::ErrorKind::Interrupted {
                self.error.get_or_insert(e);
            }
            kind.into()
        })
    }
}

impl<W: Write> Write for Keeper<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let result = self.inner.write(bytes);
        self.keep(result)
    }

    fn flush(&mut self) -> io::Result<()> {
        let result = self.inner.flush();
        self.keep(result)
    }
}

/// The keyword under which a PNG carries the settings that made it.
pub const SETTINGS_KEYWORD: &str = "dotwork settings";

/// The first text under `keyword` in a PNG, from a `tEXt` or uncompressed `iTXt` chunk as [`write_png`] writes them;
/// `None` if the bytes are no PNG or hold none before the first pixels.
///
/// Checksums are not verified. Never panics, whatever the bytes.
pub fn png_text(bytes: &[u8], keyword: &str) -> Option<String> {
    let mut rest = bytes.strip_prefix(b"\x89PNG\r\n\x1a\n")?;
    loop {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (kind, after) = after.split_first_chunk::<4>()?;
        let (data, after) = after.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        rest = after.get(4..)?;
        let value = match kind {
            b"IDAT" | b"IEND" => return None,
            b"tEXt" | b"iTXt" => data.iter().position(|&b| b == 0).map(|end| data.split_at(end)),
            _ => None,
        };
        let Some((name, [0, value @ ..])) = value else { continue };
        if !name.iter().map(|&b| char::from(b)).eq(keyword.chars()) {
            continue;
        }
        if kind == b"tEXt" {
            return Some(value.iter().map(|&b| char::from(b)).collect());
        }
        // Not compressed; then language and translated keyword, each up to a zero.
        let Some(value) = value.strip_prefix(&[0, 0]) else { continue };
        let mut parts = value.splitn(3, |&b| b == 0);
        if let (Some(_), Some(_), Some(text)) = (parts.next(), parts.next(), parts.next()) {
            return String::from_utf8(text.to_vec()).ok();
        }
    }
}

/// The PNG specification, 11.3.3.1.
fn check_keyword(keyword: &str) -> io::Result<()> {
    let count = keyword.chars().count();
    let printable = keyword.chars().all(|c| matches!(c, ' '..='~' | '\u{a1}'..='\u{ff}'));
    let spaces = keyword.starts_with(' ') || keyword.ends_with(' ') || keyword.contains("  ");
    if (1..=79).contains(&count) && printable && !spaces {
        Ok(())
    } else {
        Err(invalid(format!("'{}' cannot be a keyword of a PNG text", keyword.escape_debug())))
    }
}

fn invalid(what: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, what)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn encode(raster: &RasterView<'_>, ppm: u32, text: &[(&str, &str)]) -> Vec<u8> {
        let mut out = Vec::new();
        write_png(&mut out, raster, ppm, text).unwrap();
        out
    }

    fn noise(len: usize) -> Vec<u8> {
        (0..len as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect()
    }

    #[test]
    fn rasters_decode_to_the_same_bytes() {
        for (width, height) in [(1, 1), (7, 5), (300, 2), (2, 300), (256, 256)] {
            let grey = noise(width * height);
            let flat = vec![255; width * height * 3];
            let rgb = noise(width * height * 3);
            for (pixels, bytes, color) in [
                (Pixels::Grey(&grey), &grey, ColorType::Grayscale),
                (Pixels::Rgb(&rgb), &rgb, ColorType::Rgb),
                (Pixels::Rgb(&flat), &flat, ColorType::Rgb),
            ] {
                let raster = RasterView { width: width as u32, height: height as u32, pixels };
                let file = encode(&raster, 11_811, &[]);
                assert_eq!(file, encode(&raster, 11_811, &[]), "the same bytes every time");
                let mut reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
                let mut decoded = vec![0; reader.output_buffer_size().unwrap()];
                let info = reader.next_frame(&mut decoded).unwrap();
                assert_eq!((info.width, info.height), (raster.width, raster.height));
                assert_eq!((info.color_type, info.bit_depth), (color, BitDepth::Eight));
                assert_eq!(&decoded, bytes);
            }
        }
    }

    #[test]
    fn the_resolution_is_in_pixels_a_metre() {
        for (dpi, ppm) in [(72.0, 2835), (300.0, 11_811), (600.0, 23_622), (f32::NAN, 0)] {
            assert_eq!(pixels_per_metre(dpi), ppm);
        }
        let file = encode(&RasterView { width: 1, height: 1, pixels: Pixels::Grey(&[9]) }, 11_811, &[]);
        let at = file.windows(4).position(|w| w == b"pHYs").unwrap();
        assert_eq!(file[at + 4..at + 13], [0, 0, 0x2e, 0x23, 0, 0, 0x2e, 0x23, 1]);
    }

    #[test]
    fn text_comes_back() {
        let text = [
            ("Software", "dotwork 0.1.0"),
            ("dotwork", "tone = 0.3\nname = \"Möbius\""),
            ("Title", "点描 😀"),
        ];
        let file = encode(&RasterView { width: 1, height: 1, pixels: Pixels::Rgb(&[1, 2, 3]) }, 2835, &text);
        // Before the pixels are read.
        let reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
        let info = reader.info();
        let latin1 = &info.uncompressed_latin1_text;
        assert_eq!(latin1.len(), 2);
        for (chunk, (keyword, value)) in latin1.iter().zip(text) {
            assert_eq!((&*chunk.keyword, &*chunk.text), (keyword, value));
        }
        assert_eq!(info.utf8_text.len(), 1);
        assert_eq!(info.utf8_text[0].keyword, "Title");
        assert_eq!(info.utf8_text[0].get_text().unwrap(), "点描 😀");
    }

    #[test]
    fn what_is_no_raster_is_refused() {
        let one = RasterView { width: 1, height: 1, pixels: Pixels::Grey(&[0]) };
        let long = "k".repeat(80);
        let refused = |raster: &RasterView<'_>, text: &[(&str, &str)]| {
            let mut out = Vec::new();
            assert_eq!(write_png(&mut out, raster, 1, text).unwrap_err().kind(), io::ErrorKind::InvalidInput);
            assert!(out.is_empty());
        };
        refused(&RasterView { width: 0, ..one }, &[]);
        refused(&RasterView { width: 2, ..one }, &[]);
        refused(&RasterView { pixels: Pixels::Rgb(&[0]), ..one }, &[]);
        refused(&RasterView { width: u32::MAX, height: u32::MAX, ..one }, &[]);
        for keyword in ["", " x", "x ", "a  b", "a\nb", "点", &long] {
            refused(&one, &[(keyword, "value")]);
        }
        refused(&one, &[("key", "a\0b")]);
    }

    #[test]
    fn plates_decode_to_the_same_bits() {
        for width in [1usize, 7, 8, 9, 300] {
            let row_bytes = width.div_ceil(8);
            let mut plate = Bilevel { width: width as u32, height: 5, rows: noise(row_bytes * 5) };
            for row in plate.rows.chunks_mut(row_bytes) {
                row[row_bytes - 1] &= 0xff << (row_bytes * 8 - width);
            }
            let mut file = Vec::new();
            write_png_bilevel(&mut file, &plate, 47_244, &[(SETTINGS_KEYWORD, "a")]).unwrap();
            let mut decoder = png::Decoder::new(Cursor::new(&file));
            decoder.set_transformations(png::Transformations::EXPAND);
            let mut reader = decoder.read_info().unwrap();
            let info = reader.info();
            assert_eq!((info.bit_depth, info.color_type), (BitDepth::One, ColorType::Grayscale));
            assert_eq!(info.pixel_dims.unwrap().xppu, 47_244);
            let mut decoded = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut decoded).unwrap();
            assert_eq!(decoded.len(), width * 5);
            for (i, grey) in decoded.into_iter().enumerate() {
                let black = plate.is_black((i % width) as u32, (i / width) as u32);
                assert_eq!(grey, if black { 0 } else { 255 });
            }
        }
        let short = Bilevel { width: 9, height: 1, rows: vec![0] };
        let error = write_png_bilevel(Vec::new(), &short, 1, &[]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    }

    #[test]
    fn text_is_found_without_decoding() {
        let text =
            [("Software", "dotwork"), ("naïve", "Möbius\n\u{a0}"), ("Title", "点描 😀\r\n"), ("empty", "")];
        let file = encode(&RasterView { width: 1, height: 1, pixels: Pixels::Grey(&[9]) }, 2835, &text);
        for (keyword, value) in text {
            assert_eq!(png_text(&file, keyword).as_deref(), Some(value));
        }
        assert_eq!(png_text(&file, "Soft"), None);
        assert_eq!(png_text(&file[1..], "Title"), None);
        // A compressed text, which we do not write, is passed over.
        let at = file.windows(6).position(|w| w == b"Title\0").unwrap();
        let mut compressed = file.clone();
        compressed[at + 6] = 1;
        assert_eq!(png_text(&compressed, "Title"), None);
        assert_eq!(png_text(&compressed, "empty").as_deref(), Some(""));
    }

    #[test]
    fn the_writers_own_error_comes_back() {
        struct Fails(usize);
        impl Write for Fails {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                let taken = bytes.len().min(self.0);
                self.0 -= taken;
                // As a full disk says it, with the number of the system.
                if taken == 0 { Err(io::Error::from_raw_os_error(28)) } else { Ok(taken) }
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let expected = io::Error::from_raw_os_error(28);
        for room in [0, 5, 40, 60] {
            let raster = RasterView { width: 1, height: 1, pixels: Pixels::Grey(&[9]) };
            let error = write_png(Fails(room), &raster, 2835, &[]).unwrap_err();
            assert_eq!((error.kind(), error.raw_os_error()), (expected.kind(), expected.raw_os_error()));
        }
    }
}
