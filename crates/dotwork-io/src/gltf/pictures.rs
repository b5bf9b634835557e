//! Pictures of textures: PNG and JPEG, in the file or beside it.
//!
//! What a picture declares is charged before it is unpacked, on an account of its own: one that is too large, damaged or
//! missing is left out with a warning, and the surface is drawn without it.

use std::collections::HashMap;
use std::io::Cursor;
use std::rc::Rc;
use std::sync::Arc;

use dotwork_drawing::Warnings;
use dotwork_mesh::Picture;

use super::Document;
use super::budget::{Budget, PIXEL};
use crate::error::one_line;

/// The longest side of a picture, pixels, and the longest file.
const LONGEST_SIDE: u32 = 1 << 14;
const LONGEST_FILE: u64 = 1 << 28;

/// The longest report of a picture that cannot be read, in characters.
const LONGEST_REPORT: usize = 160;

/// The pictures of a document, each read when a material first needs it.
pub(super) struct Pictures<'d, 'a> {
    document: &'d Document<'a>,
    read: HashMap<u32, Option<Arc<Picture>>>,
    budget: Budget,
}

impl<'d, 'a> Pictures<'d, 'a> {
    pub(super) fn new(document: &'d Document<'a>) -> Self {
        Pictures { document, read: HashMap::new(), budget: Budget::default() }
    }

    /// The picture of that number; `None` with a warning if it cannot be read.
    pub(super) fn get(&mut self, index: u32, warnings: &mut Warnings) -> Option<Arc<Picture>> {
        if let Some(known) = self.read.get(&index) {
            return known.clone();
        }
        let picture = self.read(index).map(Arc::new).map_err(|reason| {
            let reason: String = one_line(&reason).chars().take(LONGEST_REPORT).collect();
            warnings.say(format!("picture {index} left out: {reason}"));
        });
        self.read.insert(index, picture.as_ref().ok().cloned());
        picture.ok()
    }

    fn read(&mut self, index: u32) -> Result<Picture, String> {
        let json = &self.document.json;
        let count = json.images.len();
        let image = json.images.get(index as usize).ok_or(format!("does not exist ({count} pictures)"))?;
        let held: Rc<[u8]>;
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                held = self.document.buffers.picture(json, &uri.0, LONGEST_FILE)?;
                &held[..]
            }
            (None, Some(view)) => self.document.view(view).map_err(|e| e.to_string())?,
            (None, None) => return Err("has no content".into()),
        };
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => self.png(bytes),
            [0xff, 0xd8, 0xff, ..] => self.jpeg(bytes),
            _ => Err("is neither PNG nor JPEG".into()),
        }
    }

    /// Charges a picture of a declared size; returns its pixels.
    fn charge(&mut self, width: u32, height: u32) -> Result<usize, String> {
        if width == 0 || height == 0 || width.max(height) > LONGEST_SIDE {
            return Err(format!("{width} x {height} pixels; sides of 1 to {LONGEST_SIDE} are read"));
        }
        // Within 2²⁸.
        let pixels = width as usize * height as usize;
        let charged = self.budget.charge(self.document, pixels, PIXEL);
        charged
            .map_err(|_| format!("{width} x {height} pixels are more than a file of its size may mean"))?;
        Ok(pixels)
    }

    fn png(&mut self, bytes: &[u8]) -> Result<Picture, String> {
        let damage = |e: png::DecodingError| format!("PNG: {e}");
        // Enough for its profile and texts; the pixels are ours, and charged below.
        let limits = png::Limits { bytes: 1 << 22 };
        let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        decoder.set_ignore_text_chunk(true);
        let (width, height) = decoder.read_header_info().map_err(damage)?.size();
        let pixels = self.charge(width, height)?;
        let mut reader = decoder.read_info().map_err(damage)?;
        let (color, _) = reader.output_color_type();
        let samples = color.samples();
        let length = reader.output_buffer_size().filter(|&n| n == pixels * samples);
        let mut unpacked = vec![0; length.ok_or("PNG: of a strange depth")?];
        reader.next_frame(&mut unpacked).map_err(damage)?;
        picture(width, height, &unpacked, samples)
    }

    fn jpeg(&mut self, bytes: &[u8]) -> Result<Picture, String> {
        let damage = |e: jpeg_decoder::Error| format!("JPEG: {e}");
        let mut decoder = jpeg_decoder::Decoder::new(bytes);
        decoder.read_info().map_err(damage)?;
        let info = decoder.info().ok_or("JPEG: without a header")?;
        let samples = match info.pixel_format {
            jpeg_decoder::PixelFormat::L8 => 1,
            jpeg_decoder::PixelFormat::RGB24 => 3,
            other => return Err(format!("JPEG: {other:?} is not read")),
        };
        let (width, height) = (u32::from(info.width), u32::from(info.height));
        let pixels = self.charge(width, height)?;
        decoder.set_max_decoding_buffer_size(pixels * samples);
        let unpacked = decoder.decode().map_err(damage)?;
        picture(width, height, &unpacked, samples)
    }
}

/// A picture of `samples` bytes a pixel: grey, grey and opacity, colour, colour and opacity.
fn picture(width: u32, height: u32, bytes: &[u8], samples: usize) -> Result<Picture, String> {
    let pixel = |p: &[u8]| match *p {
        [v] => [v, v, v, 255],
        [v, a] => [v, v, v, a],
        [r, g, b] => [r, g, b, 255],
        [r, g, b, a] => [r, g, b, a],
        _ => [255; 4],
    };
    let pixels = bytes.chunks_exact(samples).map(pixel).collect();
    Picture::new(width as usize, height as usize, pixels).ok_or_else(|| "ends too early".into())
}
