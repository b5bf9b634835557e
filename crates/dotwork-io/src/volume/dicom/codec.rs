//! Frames out of packed bytes: RLE by hand, JPEG and JPEG 2000 by their decoders; JPEG-LS is in [`super::jpeg_ls`].
//!
//! A decoder is only asked for a frame once its header has been found to declare what the data set declares, and the
//! caller has found that little enough for the bytes at hand.

use hayro_jpeg2000::{DecodeSettings, DecoderContext, Image};
use jpeg_decoder::{ColorTransform, Decoder, PixelFormat};

use crate::volume::dicom::image::{Color, Layout};

/// What is wrong with a frame.
pub(super) type Damage = String;

/// Puts samples into memory of samples of `width` bytes, in this machine's byte order.
fn put(out: &mut [u8], width: usize, samples: impl Iterator<Item = i64>) {
    match width {
        1 => out.iter_mut().zip(samples).for_each(|(o, s)| *o = s as u8),
        2 => put_words(out.as_chunks_mut::<2>().0, samples, |s| (s as u16).to_ne_bytes()),
        _ => put_words(out.as_chunks_mut::<4>().0, samples, |s| (s as u32).to_ne_bytes()),
    }
}

fn put_words<const N: usize>(
    out: &mut [[u8; N]],
    samples: impl Iterator<Item = i64>,
    word: impl Fn(i64) -> [u8; N],
) {
    out.iter_mut().zip(samples).for_each(|(o, s)| *o = word(s));
}

/// Puts one sample into memory of samples of `width` bytes, in this machine's byte order.
pub(super) fn put_at(out: &mut [u8], width: usize, place: usize, sample: i64) {
    put(&mut out[place * width..][..width], width, std::iter::once(sample));
}

/// Unpacks an RLE frame (PS3.5, annex G): a segment for each byte of a sample, the highest first, and each component,
/// plane after plane.
pub(super) fn rle(data: &[u8], layout: &Layout, out: &mut [u8]) -> Result<(), Damage> {
    let (pixels, width) = (layout.pixels(), layout.sample.bytes());
    let long = |i: usize| {
        data.get(4 * i..).and_then(|d| d.first_chunk::<4>()).map(|b| u32::from_le_bytes(*b) as usize)
    };
    let segments = width * layout.components;
    if long(0) != Some(segments) || data.len() < 64 {
        return Err(format!("an RLE frame without its {segments} segments"));
    }
    let mut plane = Vec::new();
    for segment in 0..segments {
        let from = long(1 + segment).unwrap_or(usize::MAX);
        let until = if segment + 1 < segments { long(2 + segment) } else { None };
        let packed = data
            .get(from.max(64)..until.unwrap_or(data.len()).min(data.len()))
            .ok_or_else(|| format!("RLE segment {} lies outside its frame", segment + 1))?;
        plane.clear();
        unpack_bits(packed, pixels, &mut plane);
        if plane.len() < pixels {
            return Err(format!("RLE segment {} holds {} of {pixels} bytes", segment + 1, plane.len()));
        }
        let (component, weight) = (segment / width, width - 1 - segment % width);
        let place = if cfg!(target_endian = "big") { width - 1 - weight } else { weight };
        let target = &mut out[component * pixels * width..(component + 1) * pixels * width];
        for (sample, &byte) in target.chunks_exact_mut(width).zip(&plane) {
            sample[place] = byte;
        }
    }
    Ok(())
}

/// Unpacks up to `most` bytes.
fn unpack_bits(mut packed: &[u8], most: usize, into: &mut Vec<u8>) {
    while let [control, rest @ ..] = packed {
        let room = most - into.len();
        if room == 0 {
            return;
        }
        packed = match *control as i8 {
            n @ 0.. => {
                let (literal, after) = rest.split_at(rest.len().min(n as usize + 1));
                into.extend(&literal[..literal.len().min(room)]);
                after
            }
            -128 => rest,
            n => {
                let [byte, after @ ..] = rest else { return };
                into.resize(into.len() + (1 - n as isize as i64).min(room as i64) as usize, *byte);
                after
            }
        };
    }
}

/// Unpacks a JPEG frame, samples of a pixel side by side.
pub(super) fn jpeg(data: &[u8], layout: &Layout, out: &mut [u8]) -> Result<(), Damage> {
    let mut decoder = Decoder::new(data);
    let damage = |e: jpeg_decoder::Error| match e {
        jpeg_decoder::Error::Unsupported(feature) => format!("JPEG with {feature:?}, which is not read"),
        e => format!("JPEG data: {e}"),
    };
    decoder.read_info().map_err(damage)?;
    let info = decoder.info().ok_or("JPEG data without a header")?;
    let (components, width) = match info.pixel_format {
        PixelFormat::L8 => (1, 1),
        PixelFormat::L16 => (1, 2),
        PixelFormat::RGB24 => (3, 1),
        PixelFormat::CMYK32 => return Err("JPEG data in CMYK".into()),
    };
    check(layout, [info.width.into(), info.height.into()], components, "JPEG")?;
    // Without a marker the decoder guesses by the names of the components.
    if layout.components == 3 && layout.color == Color::Rgb {
        decoder.set_color_transform(ColorTransform::RGB);
    }
    decoder.set_max_decoding_buffer_size(layout.pixels() * components * width);
    let samples = decoder.decode().map_err(damage)?;
    let wanted = layout.pixels() * components;
    if samples.len() < wanted * width {
        return Err(format!("JPEG data: {} of {wanted} samples are there", samples.len() / width));
    }
    let bytes = layout.sample.bytes();
    if width == 2 {
        // In this machine's byte order.
        let words = samples.as_chunks::<2>().0;
        put(out, bytes, words.iter().map(|w| i64::from(u16::from_ne_bytes(*w))));
    } else {
        put(out, bytes, samples.iter().map(|&s| i64::from(s)));
    }
    Ok(())
}

/// A JPEG 2000 code stream whose header declares what the data set declares.
struct CodeStream<'a> {
    bytes: &'a [u8],
    /// Of each component, whether it is signed, and its bits.
    components: Vec<(bool, u32)>,
}

impl<'a> CodeStream<'a> {
    /// Finds the stream; size, precision and sign stand first (ISO 15444-1, A.5.1).
    fn of(data: &'a [u8], layout: &Layout) -> Result<CodeStream<'a>, Damage> {
        // DICOM holds code streams; a file around one (a box format) is passed over.
        const START: &[u8] = b"\xff\x4f\xff\x51";
        let start = data.windows(START.len()).position(|w| w == START);
        let bytes = &data[start.ok_or("JPEG 2000 data without a code stream")?..];
        let long = |at: usize| {
            bytes
                .get(at..)
                .and_then(|d| d.first_chunk::<4>())
                .map_or(0, |b| u64::from(u32::from_be_bytes(*b)))
        };
        let size = [long(8).saturating_sub(long(16)), long(12).saturating_sub(long(20))];
        let components = bytes.get(40..42).map_or(0, |b| usize::from(b[0]) << 8 | usize::from(b[1]));
        check(layout, size, components, "JPEG 2000")?;
        let tiles =
            |axis: usize| long(8 + 4 * axis).saturating_sub(long(32 + 4 * axis)) / long(24 + 4 * axis).max(1);
        if tiles(0).saturating_mul(tiles(1)) > bytes.len() as u64 {
            return Err("JPEG 2000 data with more tiles than bytes".into());
        }
        // Decoders take some hundred bytes for each precinct, of which a packet tells in a byte or more.
        if most_precincts(bytes, size) > bytes.len() as u64 {
            return Err("JPEG 2000 data with more precincts than bytes".into());
        }
        let component = |c: usize| {
            let precision = bytes.get(42 + 3 * c).copied().unwrap_or_default();
            (precision & 0x80 != 0, u32::from(precision & 0x7f) + 1)
        };
        let components: Vec<(bool, u32)> = (0..components).map(component).collect();
        if let Some((_, bits)) = components.iter().find(|c| c.1 > layout.allocated) {
            return Err(format!(
                "JPEG 2000 data of {bits} bits, where {} of {} are declared",
                layout.stored, layout.allocated
            ));
        }
        Ok(CodeStream { bytes, components })
    }

    /// What the decoders add to the samples of a component of `bits`: they shift all to be positive, signed ones too.
    fn shift(&self, component: usize, bits: u32) -> i64 {
        if self.components[component].0 { 1 << (bits.clamp(1, 38) - 1) } else { 0 }
    }
}

/// The most precincts that a segment of the headers of a code stream divides a component of `size` into, tiles apart
/// (ISO 15444-1, A.6.1, A.6.2, B.6).
fn most_precincts(stream: &[u8], size: [u64; 2]) -> u64 {
    let word =
        |at: usize| stream.get(at..).and_then(|d| d.first_chunk::<2>()).map(|b| u16::from_be_bytes(*b));
    let (mut at, mut most, mut tile_end) = (2, 0, None);
    while let (Some(marker), Some(length)) = (word(at), word(at + 2)) {
        let segment = stream.get(at + 4..at + 2 + usize::from(length)).unwrap_or_default();
        match marker {
            // Where this part of a tile ends.
            0xff90 => {
                let bytes = segment.get(2..).and_then(|s| s.first_chunk::<4>());
                let length = bytes.map_or(0, |b| u32::from_be_bytes(*b) as usize);
                tile_end = at.checked_add(length).filter(|_| length > 12);
            }
            // The samples of this part.
            0xff93 => match tile_end.take() {
                Some(end) if end > at => {
                    at = end;
                    continue;
                }
                _ => break,
            },
            0xff52 => most = most.max(precincts(segment.first(), segment.get(5..), size)),
            0xff53 => most = most.max(precincts(segment.get(1), segment.get(2..), size)),
            _ => {}
        }
        at += 2 + usize::from(length.max(2));
    }
    most
}

/// The precincts of a component whose coding has this style and these parameters.
fn precincts(style: Option<&u8>, parameters: Option<&[u8]>, size: [u64; 2]) -> u64 {
    let parameters = parameters.unwrap_or_default();
    // Else they are larger than any image.
    if style.is_none_or(|s| s & 1 == 0) || parameters.len() < 5 {
        return 0;
    }
    let levels = u32::from(parameters[0].min(32));
    let along = |axis: usize, shift: u32| size[axis].div_ceil(1 << shift);
    let of = |(resolution, exponents): (u32, &u8)| {
        let shift = levels.saturating_sub(resolution);
        along(0, shift + u32::from(exponents & 15)) * along(1, shift + u32::from(exponents >> 4))
    };
    (0..=levels).zip(&parameters[5..]).map(of).sum()
}

/// Unpacks a JPEG 2000 frame, samples of a pixel side by side.
pub(super) fn jpeg2000(data: &[u8], layout: &Layout, out: &mut [u8]) -> Result<(), Damage> {
    let stream = CodeStream::of(data, layout)?;
    let damage = |e: &dyn std::fmt::Display| format!("JPEG 2000 data: {e}");
    let image = Image::new(stream.bytes, &DecodeSettings::default()).map_err(|e| damage(&e))?;
    if [image.width() as usize, image.height() as usize] != [layout.columns, layout.rows] {
        return Err("JPEG 2000 data of another size than they declare".into());
    }
    let mut context = DecoderContext::default();
    let decoded = image.decode(&mut context).map_err(|e| damage(&e))?;
    let planes = decoded.components();
    let components = layout.components;
    if planes.len() != components || planes.iter().any(|p| p.samples().len() < layout.pixels()) {
        return Err("JPEG 2000 data: samples are missing".into());
    }
    let bytes = layout.sample.bytes();
    let sample = |component: usize, value: f32| {
        value.round() as i64 - stream.shift(component, planes[component].bit_depth().into())
    };
    if components == 1 {
        put(out, bytes, planes[0].samples().iter().map(|&v| sample(0, v)));
    } else {
        let side_by_side = (0..layout.pixels() * components).map(|i| {
            let (pixel, component) = (i / components, i % components);
            sample(component, planes[component].samples()[pixel])
        });
        put(out, bytes, side_by_side);
    }
    Ok(())
}

/// Unpacks a frame of JPEG 2000 with high throughput (ISO 15444-15), samples of a pixel side by side.
///
/// Of lossy ones the decoder takes the lower end of each step of the quantiser, where others take its middle: coefficients
/// are up to a step too small, which ISO 15444-1, annex E, leaves to decoders.
pub(super) fn high_throughput(data: &[u8], layout: &Layout, out: &mut [u8]) -> Result<(), Damage> {
    let stream = CodeStream::of(data, layout)?;
    let bits = stream.components[0].1;
    // The decoder takes the precision of the first for that of all, and writes words.
    if bits > 16 || stream.components.iter().any(|c| c.1 != bits) {
        return Err(
            "high-throughput JPEG 2000 of more than 16 bits, or of several precisions, which is not read"
                .into(),
        );
    }
    let damage = |e: &dyn std::fmt::Display| format!("high-throughput JPEG 2000 data: {e}");
    let settings = dicom_toolkit_jpeg2000::DecodeSettings::default();
    let image = dicom_toolkit_jpeg2000::Image::new(stream.bytes, &settings).map_err(|e| damage(&e))?;
    if [image.width() as usize, image.height() as usize] != [layout.columns, layout.rows] {
        return Err("JPEG 2000 data of another size than they declare".into());
    }
    let decoded = image.decode_native().map_err(|e| damage(&e))?;
    let (wanted, width) = (layout.pixels() * layout.components, usize::from(decoded.bytes_per_sample));
    if usize::from(decoded.num_components) != layout.components || decoded.data.len() != wanted * width {
        return Err("JPEG 2000 data: samples are missing".into());
    }
    let shift = |i: usize| stream.shift(i % layout.components, bits);
    let bytes = layout.sample.bytes();
    if width == 2 {
        let words = decoded.data.as_chunks::<2>().0.iter().map(|w| i64::from(u16::from_le_bytes(*w)));
        put(out, bytes, words.enumerate().map(|(i, s)| s - shift(i)));
    } else {
        put(out, bytes, decoded.data.iter().enumerate().map(|(i, &s)| i64::from(s) - shift(i)));
    }
    Ok(())
}

/// Compares what packed data declare with what the data set declares.
pub(super) fn check(layout: &Layout, size: [u64; 2], components: usize, name: &str) -> Result<(), Damage> {
    let declared = [layout.columns as u64, layout.rows as u64];
    if size != declared || components != layout.components {
        return Err(format!(
            "{name} data of {} x {} pixels with {components} samples, where {} x {} with {} are declared",
            size[0], size[1], declared[0], declared[1], layout.components
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_and_literals_unpack() {
        let mut into = Vec::new();
        unpack_bits(&[2, 1, 2, 3, 0x80, 0xfe, 9, 0, 7], 100, &mut into);
        assert_eq!(into, [1, 2, 3, 9, 9, 9, 7]);
        for (packed, most, expected) in [
            (&[0x81, 5][..], 4, &[5; 4][..]),
            (&[5, 1, 2], 9, &[1, 2]),
            (&[0xff], 9, &[]),
            (&[3, 1, 2, 3, 4], 2, &[1, 2]),
        ] {
            into.clear();
            unpack_bits(packed, most, &mut into);
            assert_eq!(into, expected);
        }
    }
}
