//! From the pixel element to the samples of a frame.

use std::borrow::Cow;

use bytemuck::cast_slice_mut;
use dotwork_volume::{SampleType, Samples};

use crate::error::ReadErrorKind;
use crate::volume::dicom::codec;
use crate::volume::dicom::image::{Color, Layout};
use crate::volume::dicom::jpeg_ls::jpeg_ls;
use crate::volume::dicom::set::PixelElement;
use crate::volume::dicom::syntax::{Codec, Syntax};
use crate::volume::fill::{as_bytes_mut, swap_bytes, zeroed};
use crate::volume::reduce::{Reduction, reduce};

/// The pixel data of a file, frame by frame.
pub(super) struct Pixels<'a> {
    bytes: &'a [u8],
    element: PixelElement,
    syntax: Syntax,
    layout: Layout,
    /// Of encapsulated data: the fragments of each frame.
    frames: Vec<Vec<&'a [u8]>>,
}

impl<'a> Pixels<'a> {
    /// Finds the frames, of which there are `count`.
    pub(super) fn of(
        bytes: &'a [u8],
        element: PixelElement,
        syntax: Syntax,
        layout: Layout,
        count: usize,
    ) -> Result<Pixels<'a>, ReadErrorKind> {
        let frames = match (element.length, syntax.codec) {
            (None, Codec::Native) => {
                return Err(ReadErrorKind::at_byte(
                    element.at,
                    "DICOM pixel data in fragments, but not packed",
                ));
            }
            (None, _) => encapsulated(bytes, element.at, count)?,
            (Some(_), Codec::Native) => Vec::new(),
            (Some(_), _) => {
                return Err(ReadErrorKind::at_byte(element.at, "packed DICOM pixel data without fragments"));
            }
        };
        Ok(Pixels { bytes, element, syntax, layout, frames })
    }

    /// Decodes a frame into the memory of its samples, one a pixel.
    pub(super) fn decode(&self, frame: usize, out: &mut [u8]) -> Result<(), ReadErrorKind> {
        let layout = &self.layout;
        if layout.components == 1 {
            self.unpack(frame, out)?;
            mend(layout, out);
            return Ok(());
        }
        let mut samples = zeroed(layout.sample, layout.pixels() * layout.components)?;
        let all = as_bytes_mut(&mut samples);
        self.unpack(frame, all)?;
        mend(layout, all);
        // Packed luminance and colour differences were turned into RGB; of others the luminance comes first.
        let plain = matches!(self.syntax.codec, Codec::Native | Codec::Rle | Codec::JpegLs);
        let how = match layout.color {
            Color::Ybr if plain => Reduction::First,
            _ => Reduction::Luminance,
        };
        let planes = self.syntax.codec == Codec::Rle || (self.syntax.codec == Codec::Native && layout.planar);
        reduce(&mut samples, if planes { layout.pixels() } else { 1 }, layout.components, how);
        let reduced: &mut Samples = &mut samples;
        out.copy_from_slice(as_bytes_mut(reduced));
        Ok(())
    }

    fn unpack(&self, frame: usize, out: &mut [u8]) -> Result<(), ReadErrorKind> {
        if self.syntax.codec == Codec::Native {
            return self.copy(frame, out);
        }
        let fragments = self.frames.get(frame).map(Vec::as_slice).unwrap_or_default();
        let data = match fragments {
            [one] => Cow::Borrowed(*one),
            many => Cow::Owned(many.concat()),
        };
        let decode = match self.syntax.codec {
            Codec::Rle => codec::rle,
            Codec::Jpeg => codec::jpeg,
            Codec::JpegLs => jpeg_ls,
            Codec::HighThroughput => codec::high_throughput,
            _ => codec::jpeg2000,
        };
        decode(&data, &self.layout, out)
            .map_err(|damage| ReadErrorKind::at_item("DICOM frame", frame + 1, damage))
    }

    fn copy(&self, frame: usize, out: &mut [u8]) -> Result<(), ReadErrorKind> {
        let data = &self.bytes[self.element.at..];
        let bits = self.layout.frame_bits();
        let short = || ReadErrorKind::at_byte(self.bytes.len(), "the DICOM pixel data end too early");
        let first_bit = bits * frame as u64;
        let from = usize::try_from(first_bit / 8).map_err(|_| short())?;
        if self.layout.allocated == 1 {
            // Frames follow each other without a gap; the lowest bit is the first pixel.
            let data = data.get(from..).ok_or_else(short)?;
            let skip = (first_bit % 8) as usize;
            if data.len() * 8 < skip + out.len() {
                return Err(short());
            }
            for (i, o) in out.iter_mut().enumerate() {
                *o = data[(skip + i) / 8] >> ((skip + i) % 8) & 1;
            }
            return Ok(());
        }
        let bytes = data.get(from..).and_then(|d| d.get(..out.len()));
        let swap = self.syntax.big_endian != cfg!(target_endian = "big");
        let width = self.layout.sample.bytes();
        if width == 1 && self.syntax.big_endian && self.element.words {
            // Bytes were written as words: the second comes first.
            for (i, o) in out.iter_mut().enumerate() {
                *o = *data.get((from + i) ^ 1).ok_or_else(short)?;
            }
            return Ok(());
        }
        out.copy_from_slice(bytes.ok_or_else(short)?);
        if swap {
            swap_bytes(out, width);
        }
        Ok(())
    }
}

/// Finds the fragments of each frame (PS3.5, annex A.4).
fn encapsulated(bytes: &[u8], start: usize, count: usize) -> Result<Vec<Vec<&[u8]>>, ReadErrorKind> {
    const ITEM: [u8; 4] = [0xfe, 0xff, 0x00, 0xe0];
    const END: [u8; 4] = [0xfe, 0xff, 0xdd, 0xe0];
    let mut at = start;
    let mut fragments: Vec<(usize, &[u8])> = Vec::new();
    let mut table: Option<&[u8]> = None;
    // Some files end without the delimiter.
    while let Some(head) = bytes.get(at..).and_then(|b| b.first_chunk::<8>()) {
        let [a, b, c, d, length @ ..] = *head;
        if [a, b, c, d] == END {
            break;
        }
        if [a, b, c, d] != ITEM {
            return Err(ReadErrorKind::at_byte(at, "something else where a DICOM fragment begins"));
        }
        let length = u32::from_le_bytes(length) as usize;
        let data = bytes[at + 8..].get(..length).ok_or_else(|| {
            let there = bytes.len() - at - 8;
            let number = fragments.len() + 1;
            ReadErrorKind::at_byte(
                bytes.len(),
                format!("DICOM fragment {number} ends too early: {there} of {length} bytes are there"),
            )
        })?;
        match table {
            None => table = Some(data),
            Some(_) => fragments.push((at, data)),
        }
        at += 8 + length;
    }
    let first = fragments.first().map_or(at, |f| f.0);
    let wrong = || {
        ReadErrorKind::at_byte(
            start,
            format!("{} DICOM fragments that do not make {count} frames", fragments.len()),
        )
    };
    if fragments.len() < count {
        return Err(wrong());
    }
    if count == 1 {
        return Ok(vec![fragments.iter().map(|f| f.1).collect()]);
    }
    if fragments.len() == count {
        return Ok(fragments.iter().map(|f| vec![f.1]).collect());
    }
    // Several fragments a frame: the table says where frames begin, or the mark of the packed data does.
    let table = table.unwrap_or_default().as_chunks::<4>().0;
    let offsets: Vec<usize> = table.iter().map(|b| u32::from_le_bytes(*b) as usize + first).collect();
    let begins = |(at, data): &(usize, &[u8])| match offsets.len() {
        n if n == count => offsets.binary_search(at).is_ok(),
        _ => data.starts_with(b"\xff\xd8\xff") || data.starts_with(b"\xff\x4f\xff\x51"),
    };
    let mut frames: Vec<Vec<&[u8]>> = Vec::new();
    for fragment in &fragments {
        if begins(fragment) {
            frames.push(Vec::new());
        }
        frames.last_mut().ok_or_else(wrong)?.push(fragment.1);
    }
    if frames.len() != count { Err(wrong()) } else { Ok(frames) }
}

/// Leaves of each sample the bits that count, with its sign: others may hold overlays or anything.
fn mend(layout: &Layout, out: &mut [u8]) {
    if layout.allocated == 1 || layout.stored == layout.allocated {
        return;
    }
    let (above, unused) = (layout.allocated - 1 - layout.high, layout.allocated - layout.stored);
    macro_rules! mend {
        ($type:ident) => {
            // The shift to the right drags the sign along, if the type has one.
            cast_slice_mut::<u8, $type>(out).iter_mut().for_each(|s| *s = *s << above >> unused)
        };
    }
    match layout.sample {
        SampleType::U8 => mend!(u8),
        SampleType::I8 => mend!(i8),
        SampleType::U16 => mend!(u16),
        SampleType::I16 => mend!(i16),
        SampleType::U32 => mend!(u32),
        SampleType::I32 => mend!(i32),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_stored_bits_count() {
        let layout = Layout {
            rows: 1,
            columns: 3,
            components: 1,
            color: Color::Gray,
            planar: false,
            sample: SampleType::I16,
            allocated: 16,
            stored: 12,
            high: 11,
        };
        let mut samples = vec![0x1fffu16 as i16, 0x0800, 0x07ff];
        mend(&layout, cast_slice_mut(&mut samples));
        assert_eq!(samples, [-1, -2048, 2047]);
        let layout = Layout { sample: SampleType::U16, stored: 10, high: 13, ..layout };
        let mut samples = vec![0xffffu16, 0x4010, 0x2010];
        mend(&layout, cast_slice_mut(&mut samples));
        assert_eq!(samples, [1023, 1, 513]);
    }
}
