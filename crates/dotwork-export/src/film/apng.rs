//! Animated PNG (the PNG specification, third edition, 2025): an ordinary PNG to programs that know no films.

use std::io::{self, Write};

use flate2::write::ZlibEncoder;
use flate2::{Compression, Crc};

use super::ticks;
use crate::png::{DEFLATE_LEVEL, Pixels, RasterView};

/// Frames are timed in thousandths of a second.
const RATE: f64 = 1000.0;

/// A frame, packed.
pub struct ApngFrame {
    width: u32,
    height: u32,
    color: u8,
    zlib: Vec<u8>,
}

/// Packs a picture as a frame.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] if the raster is not what it says.
pub fn apng_frame(raster: &RasterView<'_>) -> io::Result<ApngFrame> {
    let (samples, bytes) = raster.samples()?;
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(DEFLATE_LEVEL.into()));
    for row in bytes.chunks_exact(raster.width as usize * samples) {
        // No filter, as in stills.
        encoder.write_all(&[0])?;
        encoder.write_all(row)?;
    }
    let color = match raster.pixels {
        Pixels::Grey(_) => 0,
        Pixels::Rgb(_) => 2,
        Pixels::Rgba(_) => 6,
    };
    Ok(ApngFrame { width: raster.width, height: raster.height, color, zlib: encoder.finish()? })
}

/// Writes a film that begins anew when it ends.
pub struct ApngWriter<W: Write> {
    writer: W,
    frames: u32,
    written: u32,
    /// Of the chunks that a film has beyond a still.
    sequence: u32,
    size: Option<(u32, u32, u8)>,
    ppm: u32,
    text: Vec<(String, String)>,
}

impl<W: Write> ApngWriter<W> {
    /// A film of so many frames, with its resolution in pixels a metre (0: unknown) and `text` as
    /// [`write_png`](crate::write_png) takes them.
    pub fn new(writer: W, frames: u32, ppm: u32, text: &[(&str, &str)]) -> ApngWriter<W> {
        let text = text.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect();
        ApngWriter { writer, frames, written: 0, sequence: 0, size: None, ppm, text }
    }

    /// Writes a frame that is shown from `start` to `end` seconds.
    ///
    /// # Errors
    /// What the writer refuses; [`io::ErrorKind::InvalidInput`] for a frame of another size or kind than the first, or one
    /// too many.
    pub fn frame(&mut self, frame: ApngFrame, start: f64, end: f64) -> io::Result<()> {
        let ApngFrame { width, height, color, zlib } = frame;
        let size = (width, height, color);
        if *self.size.get_or_insert(size) != size || self.written == self.frames {
            let what = "a frame unlike the first, or one too many";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        if self.written == 0 {
            self.begin(size)?;
        }
        let mut control = Vec::with_capacity(26);
        for number in [self.sequence, width, height, 0, 0] {
            control.extend(number.to_be_bytes());
        }
        control.extend(ticks(start, end, RATE).to_be_bytes());
        control.extend((RATE as u16).to_be_bytes());
        // Neither cleared nor blended: each frame is whole.
        control.extend([0, 0]);
        self.sequence += 1;
        self.chunk(b"fcTL", &[&control])?;
        if self.written == 0 {
            self.chunk(b"IDAT", &[&zlib])?;
        } else {
            let number = self.sequence.to_be_bytes();
            self.sequence += 1;
            self.chunk(b"fdAT", &[&number, &zlib])?;
        }
        self.written += 1;
        Ok(())
    }

    /// Writes the end.
    ///
    /// # Errors
    /// What the writer refuses; [`io::ErrorKind::InvalidInput`] if frames are missing.
    pub fn finish(mut self) -> io::Result<()> {
        if self.written != self.frames {
            let what = format!("{} frames of {}", self.written, self.frames);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        self.chunk(b"IEND", &[])?;
        self.writer.flush()
    }

    fn begin(&mut self, (width, height, color): (u32, u32, u8)) -> io::Result<()> {
        self.writer.write_all(b"\x89PNG\r\n\x1a\n")?;
        let mut header = Vec::new();
        header.extend(width.to_be_bytes());
        header.extend(height.to_be_bytes());
        header.extend([8, color, 0, 0, 0]);
        self.chunk(b"IHDR", &[&header])?;
        // Without end.
        self.chunk(b"acTL", &[&self.frames.to_be_bytes(), &0u32.to_be_bytes()])?;
        if self.ppm > 0 {
            let ppm = self.ppm.to_be_bytes();
            self.chunk(b"pHYs", &[&ppm, &ppm, &[1]])?;
        }
        for (keyword, value) in std::mem::take(&mut self.text) {
            // International text, not compressed, in no language.
            self.chunk(b"iTXt", &[keyword.as_bytes(), &[0, 0, 0, 0, 0], value.as_bytes()])?;
        }
        Ok(())
    }

    fn chunk(&mut self, kind: &[u8; 4], data: &[&[u8]]) -> io::Result<()> {
        let length: usize = data.iter().map(|d| d.len()).sum();
        let length = u32::try_from(length).ok().filter(|&l| l < 1 << 31);
        let length =
            length.ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "a frame over 2 GiB"))?;
        let mut crc = Crc::new();
        crc.update(kind);
        self.writer.write_all(&length.to_be_bytes())?;
        self.writer.write_all(kind)?;
        for part in data {
            crc.update(part);
            self.writer.write_all(part)?;
        }
        self.writer.write_all(&crc.sum().to_be_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_reads_back() {
        let rows: Vec<Vec<u8>> = (0..3u8).map(|k| (0..48).map(|i| i * 5 + k).collect()).collect();
        let view = |k: usize| RasterView { width: 4, height: 4, pixels: Pixels::Rgb(&rows[k]) };
        let mut file = Vec::new();
        let mut film = ApngWriter::new(&mut file, 3, 3937, &[("Software", "dotwork")]);
        for k in 0..3 {
            let (start, end) = (k as f64 / 24.0, (k + 1) as f64 / 24.0);
            film.frame(apng_frame(&view(k)).unwrap(), start, end).unwrap();
        }
        assert!(film.frame(apng_frame(&view(0)).unwrap(), 0.0, 1.0).is_err(), "one too many");
        film.finish().unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(&file)).read_info().unwrap();
        assert_eq!(reader.info().animation_control.map(|a| (a.num_frames, a.num_plays)), Some((3, 0)));
        assert_eq!(crate::png_text(&file, "Software").as_deref(), Some("dotwork"));
        let mut delays = Vec::new();
        for row in &rows {
            let mut pixels = vec![0; 48];
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(&pixels, row);
            delays.push(reader.info().frame_control.unwrap().delay_num);
        }
        assert_eq!(delays, [42, 41, 42]);
    }

    #[test]
    fn frames_must_be_alike_and_complete() {
        let bytes = [0; 16];
        let grey = RasterView { width: 4, height: 4, pixels: Pixels::Grey(&bytes) };
        let smaller = RasterView { width: 2, height: 4, pixels: Pixels::Grey(&bytes[..8]) };
        let mut film = ApngWriter::new(Vec::new(), 2, 0, &[]);
        film.frame(apng_frame(&grey).unwrap(), 0.0, 0.1).unwrap();
        assert!(film.frame(apng_frame(&smaller).unwrap(), 0.1, 0.2).is_err());
        assert!(film.finish().is_err());
    }
}
