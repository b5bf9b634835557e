//! Animated GIF.
//!
//! A drawing in one ink on grey paper has at most 256 tones, which a palette holds exactly; so has any picture with no
//! more colours than that. Others are reduced to the most frequent ones: a drawing in few inks has paper and inks, which
//! stay exact, and mixtures of them along few lines, which lie close together. Transparency is all or nothing.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::{self, Write};

use gif::{DisposalMethod, Encoder, Frame, Repeat};

use super::ticks;
use crate::png::{Pixels, RasterView};

/// Colours that differ in fewer than this many low bits of each channel are taken for one, where there are too many.
const LOW_BITS: u32 = 3;

/// Opacity from which a pixel is drawn.
const OPAQUE: u8 = 128;

/// A frame, packed.
pub struct GifFrame(Frame<'static>);

/// Packs a picture as a frame. Pixels that are more than half transparent become clear.
///
/// # Errors
/// [`io::ErrorKind::InvalidInput`] if the raster is not what it says, or wider or higher than 65,535 pixels.
pub fn gif_frame(raster: &RasterView<'_>) -> io::Result<GifFrame> {
    let (samples, bytes) = raster.samples()?;
    let (Ok(width), Ok(height)) = (u16::try_from(raster.width), u16::try_from(raster.height)) else {
        let what = format!("a GIF is at most 65535 pixels a side, not {} x {}", raster.width, raster.height);
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    };
    let clear = matches!(raster.pixels, Pixels::Rgba(_));
    let color = |p: &[u8]| match *p {
        [grey] => Some([grey; 3]),
        [r, g, b] => Some([r, g, b]),
        [r, g, b, a] => (a >= OPAQUE).then_some([r, g, b]),
        _ => None,
    };
    let indexed = exact(bytes, samples, color).unwrap_or_else(|| reduced(bytes, samples, color));
    let (indices, palette, transparent) = indexed;
    let mut frame = Frame {
        width,
        height,
        buffer: Cow::Owned(indices),
        palette: Some(palette),
        transparent,
        ..Frame::default()
    };
    // What was clear must not show the frame before.
    frame.dispose = if clear { DisposalMethod::Background } else { DisposalMethod::Keep };
    frame.make_lzw_pre_encoded();
    Ok(GifFrame(frame))
}

/// Indices into a palette, the palette, and the index of what is clear.
type Indexed = (Vec<u8>, Vec<u8>, Option<u8>);

/// Indices into a palette of the colours that are most frequent; the others take the nearest of these.
fn reduced(bytes: &[u8], samples: usize, color: impl Fn(&[u8]) -> Option<[u8; 3]>) -> Indexed {
    let mut counts: HashMap<[u8; 3], u32> = HashMap::new();
    for pixel in bytes.chunks_exact(samples) {
        if let Some(color) = color(pixel) {
            *counts.entry(color).or_default() += 1;
        }
    }
    // Of each cell of near colours: how many pixels it has, and its most frequent colour with their number.
    let cell = |c: [u8; 3]| c.map(|v| v >> LOW_BITS);
    let mut cells: HashMap<[u8; 3], (u32, u32, [u8; 3])> = HashMap::new();
    for (&color, &count) in &counts {
        let found = cells.entry(cell(color)).or_default();
        found.0 += count;
        if (count, color) > (found.1, found.2) {
            (found.1, found.2) = (count, color);
        }
    }
    let mut frequent: Vec<(u32, [u8; 3])> = cells.values().map(|&(all, _, color)| (all, color)).collect();
    frequent.sort_unstable_by(|a, b| b.cmp(a));
    // One is kept for what is clear.
    let chosen: Vec<[u8; 3]> = frequent.iter().take(255).map(|f| f.1).collect();
    let distance =
        |a: [u8; 3], b: [u8; 3]| -> i32 { (0..3).map(|k| (i32::from(a[k]) - i32::from(b[k])).pow(2)).sum() };
    let nearest =
        |c: [u8; 3]| (0..chosen.len()).min_by_key(|&k| (distance(chosen[k], c), k)).unwrap_or(0) as u8;
    let index: HashMap<[u8; 3], u8> = counts.keys().map(|&c| (c, nearest(c))).collect();
    let clear = chosen.len() as u8;
    let indices = bytes.chunks_exact(samples).map(|p| color(p).map_or(clear, |c| index[&c])).collect();
    let mut palette = chosen.concat();
    palette.extend([255; 3]);
    (indices, palette, Some(clear))
}

/// Indices into a palette that holds every colour; `None` if there are more than 256.
fn exact(bytes: &[u8], samples: usize, color: impl Fn(&[u8]) -> Option<[u8; 3]>) -> Option<Indexed> {
    let mut known: HashMap<Option<[u8; 3]>, u8> = HashMap::new();
    let mut palette = Vec::new();
    let mut indices = Vec::with_capacity(bytes.len() / samples);
    let mut last = None;
    for pixel in bytes.chunks_exact(samples) {
        let color = color(pixel);
        // Paper runs long.
        let index = match last {
            Some((same, index)) if same == color => index,
            _ => match known.get(&color) {
                Some(&index) => index,
                None => {
                    let index = u8::try_from(known.len()).ok()?;
                    known.insert(color, index);
                    palette.extend(color.unwrap_or([255; 3]));
                    index
                }
            },
        };
        last = Some((color, index));
        indices.push(index);
    }
    Some((indices, palette, known.get(&None).copied()))
}

/// Writes a film that begins anew when it ends.
pub struct GifWriter<W: Write> {
    encoder: Encoder<W>,
}

impl<W: Write> GifWriter<W> {
    /// Writes the header of a film of this size in pixels.
    ///
    /// # Errors
    /// What the writer refuses; [`io::ErrorKind::InvalidInput`] for more than 65,535 pixels a side.
    pub fn new(writer: W, width: u32, height: u32) -> io::Result<GifWriter<W>> {
        let side = |n: u32| u16::try_from(n).map_err(|e| io::Error::new(io::ErrorKind::InvalidInput, e));
        let mut encoder = Encoder::new(writer, side(width)?, side(height)?, &[]).map_err(refused)?;
        encoder.set_repeat(Repeat::Infinite).map_err(refused)?;
        Ok(GifWriter { encoder })
    }

    /// Writes a frame that is shown from `start` to `end` seconds. A GIF counts hundredths of a second.
    ///
    /// # Errors
    /// What the writer refuses.
    pub fn frame(&mut self, frame: GifFrame, start: f64, end: f64) -> io::Result<()> {
        let mut frame = frame.0;
        frame.delay = ticks(start, end, 100.0);
        self.encoder.write_lzw_pre_encoded_frame(&frame).map_err(refused)
    }

    /// Writes the end.
    ///
    /// # Errors
    /// What the writer refuses.
    pub fn finish(self) -> io::Result<()> {
        self.encoder.into_inner().map_err(refused)?.flush()
    }
}

fn refused(error: gif::EncodingError) -> io::Error {
    match error {
        gif::EncodingError::Io(e) => e,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(bytes: &[u8]) -> Vec<(u16, Vec<u8>)> {
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(bytes).unwrap();
        let mut frames = Vec::new();
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            frames.push((frame.delay, frame.buffer.to_vec()));
        }
        frames
    }

    #[test]
    fn greys_are_exact() {
        let grey: Vec<u8> = (0..=255).collect();
        let raster = RasterView { width: 16, height: 16, pixels: Pixels::Grey(&grey) };
        let mut file = Vec::new();
        let mut film = GifWriter::new(&mut file, 16, 16).unwrap();
        for n in 0..3 {
            let (start, end) = (f64::from(n) / 24.0, f64::from(n + 1) / 24.0);
            film.frame(gif_frame(&raster).unwrap(), start, end).unwrap();
        }
        film.finish().unwrap();
        let frames = decode(&file);
        assert_eq!(frames.iter().map(|f| f.0).collect::<Vec<_>>(), [4, 4, 5]);
        for (_, pixels) in frames {
            let greys: Vec<u8> = pixels.chunks(4).map(|p| p[0]).collect();
            assert_eq!(greys, grey);
            assert!(pixels.chunks(4).all(|p| p[0] == p[1] && p[1] == p[2] && p[3] == 255));
        }
        assert_eq!(*file.last().unwrap(), b';', "the trailer");
    }

    #[test]
    fn many_colours_are_reduced_and_clear_stays_clear() {
        let many: Vec<u8> = (0..32 * 32u32)
            .flat_map(|i| {
                let (x, y) = (i % 32, i / 32);
                // More than half is paper.
                let (r, g) = if y < 20 { (250, 251) } else { (x * 8 + y % 3, y * 8) };
                [r, g, 128, if x < 16 || y < 20 { 255 } else { 0 }].map(|v| v as u8)
            })
            .collect();
        let raster = RasterView { width: 32, height: 32, pixels: Pixels::Rgba(&many) };
        let mut file = Vec::new();
        let mut film = GifWriter::new(&mut file, 32, 32).unwrap();
        film.frame(gif_frame(&raster).unwrap(), 0.0, 1.0).unwrap();
        film.finish().unwrap();
        let frames = decode(&file);
        for (k, (p, was)) in frames[0].1.chunks(4).zip(many.chunks(4)).enumerate() {
            assert_eq!(p[3], was[3]);
            let near = (0..3).all(|c| p[c].abs_diff(was[c]) <= 8);
            assert!(p[3] == 0 || near, "{k}: {p:?} for {was:?}");
            assert!(k >= 20 * 32 || p == was, "paper stays exact");
        }
    }

    #[test]
    fn what_is_too_large_is_refused() {
        let row = vec![0; 70_000];
        let raster = RasterView { width: 70_000, height: 1, pixels: Pixels::Grey(&row) };
        assert_eq!(gif_frame(&raster).err().unwrap().kind(), io::ErrorKind::InvalidInput);
        assert!(GifWriter::new(Vec::new(), 70_000, 1).is_err());
    }
}
