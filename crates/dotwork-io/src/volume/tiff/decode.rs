//! From the strips or tiles of a page to rows of samples in this machine's byte order.

use bytemuck::allocation::try_zeroed_vec;
use weezl::decode::Configuration;
use weezl::{BitOrder, LzwStatus};

use crate::error::ReadErrorKind;
use crate::volume::fill::swap_bytes;
use crate::volume::stream::{Packing, Stream};
use crate::volume::tiff::directory::Tiff;
use crate::volume::tiff::page::{Compression, Page, Predictor};

/// Decodes `page` into `out`, which has just its size, the components of a pixel side by side.
pub(super) fn page(
    tiff: &Tiff,
    page: &Page,
    out: &mut [u8],
    scratch: &mut Vec<u8>,
) -> Result<(), ReadErrorKind> {
    let sample = page.sample.bytes();
    let out_row = page.width * page.components * sample;
    if out.len() != out_row.saturating_mul(page.height) {
        return Err(ReadErrorKind::Refused("has pages of unequal size".into()));
    }
    let (across, down) = (page.chunks_across(), page.chunks_down());
    for (i, chunk) in page.chunks.iter().enumerate() {
        let plane = i / (across * down);
        let (column, row) = (i % across, i / across % down);
        // Bounds were checked when the page was read.
        let packed = tiff.bytes.get(chunk.at as usize..).and_then(|b| b.get(..chunk.packed as usize));
        let packed = packed.unwrap_or_default();
        let bytes = page.chunk_bytes(i) as usize;
        if scratch.len() < bytes {
            // Zeros from the system take no memory until something is unpacked to them.
            *scratch = try_zeroed_vec(bytes).map_err(|()| {
                ReadErrorKind::TooLarge(format!("there is no memory for {bytes} bytes of a page"))
            })?;
        }
        let scratch = &mut scratch[..bytes];
        let got = unpack(page.compression, packed, scratch).map_err(|reason| {
            ReadErrorKind::at_byte(chunk.at as usize, format!("{} data: {reason}", page.compression.name()))
        })?;
        if got < bytes {
            return Err(ReadErrorKind::at_byte(
                chunk.at as usize,
                format!("strip or tile {} unpacks to {got} of {bytes} bytes", i + 1),
            ));
        }
        restore(page, tiff.big_endian, scratch);

        let pixel = page.chunk_components() * sample;
        let chunk_row = page.chunk_width * pixel;
        let from_x = column * page.chunk_width;
        let pixels = page.chunk_width.min(page.width - from_x);
        let from_y = row * page.chunk_height;
        let rows = page.chunk_rows(i).min(page.height - from_y);
        for (y, source) in scratch.chunks_exact(chunk_row).take(rows).enumerate() {
            let target = &mut out[(from_y + y) * out_row..][..out_row];
            let target = &mut target[from_x * page.components * sample..];
            if page.planar {
                let targets = target.chunks_exact_mut(page.components * sample);
                for (target, source) in targets.zip(source.chunks_exact(sample)).take(pixels) {
                    target[plane * sample..][..sample].copy_from_slice(source);
                }
            } else {
                target[..pixels * pixel].copy_from_slice(&source[..pixels * pixel]);
            }
        }
    }
    Ok(())
}

/// Unpacks into `out` and returns how many bytes there were.
fn unpack(compression: Compression, packed: &[u8], out: &mut [u8]) -> Result<usize, String> {
    match compression {
        Compression::None => {
            let n = packed.len().min(out.len());
            out[..n].copy_from_slice(&packed[..n]);
            Ok(n)
        }
        Compression::Deflate => Stream::new(packed, Packing::Zlib).read(out).map_err(|e| e.to_string()),
        Compression::Lzw => unpack_lzw(packed, out),
        Compression::PackBits => Ok(unpack_packbits(packed, out)),
    }
}

fn unpack_lzw(packed: &[u8], out: &mut [u8]) -> Result<usize, String> {
    // The bytes 0, 1 begin streams of the first LZW writers, whose bits run the other way.
    if matches!(packed, [0, second, ..] if second & 1 == 1) {
        return Err("old-style LZW is not read".into());
    }
    let mut decoder = Configuration::with_tiff_size_switch(BitOrder::Msb, 8).build();
    let (mut read, mut written) = (0, 0);
    while written < out.len() {
        let result = decoder.decode_bytes(&packed[read..], &mut out[written..]);
        read += result.consumed_in;
        written += result.consumed_out;
        match result.status {
            Ok(LzwStatus::Ok) if result.consumed_in + result.consumed_out > 0 => {}
            Ok(_) => break,
            Err(e) => return Err(format!("damaged after {written} unpacked bytes ({e})")),
        }
    }
    Ok(written)
}

/// Runs of literal bytes and of repeated ones (TIFF 6.0, section 9).
fn unpack_packbits(mut packed: &[u8], out: &mut [u8]) -> usize {
    let mut written = 0;
    while written < out.len()
        && let [head, rest @ ..] = packed
    {
        packed = rest;
        let room = &mut out[written..];
        match *head as i8 {
            -128 => {}
            n @ 0.. => {
                let n = (n as usize + 1).min(packed.len());
                let taken = n.min(room.len());
                room[..taken].copy_from_slice(&packed[..taken]);
                packed = &packed[n..];
                written += taken;
            }
            n => {
                let [byte, rest @ ..] = packed else { break };
                packed = rest;
                let taken = (1 - isize::from(n)).unsigned_abs().min(room.len());
                room[..taken].fill(*byte);
                written += taken;
            }
        }
    }
    written
}

/// Undoes byte order and prediction, row by row.
fn restore(page: &Page, big_endian: bool, bytes: &mut [u8]) {
    let sample = page.sample.bytes();
    let components = page.chunk_components();
    if page.predictor == Predictor::Float {
        let row_bytes = page.chunk_width * components * sample;
        let mut row = vec![0; row_bytes];
        for bytes in bytes.chunks_exact_mut(row_bytes) {
            restore_floats(bytes, &mut row, sample, components);
        }
        return;
    }
    if big_endian != cfg!(target_endian = "big") {
        swap_bytes(bytes, sample);
    }
    if page.predictor == Predictor::Horizontal {
        for row in bytes.chunks_exact_mut(page.chunk_width * components * sample) {
            match sample {
                1 => add_up::<1>(row, components, |a, b| [a[0].wrapping_add(b[0])]),
                2 => add_up::<2>(row, components, |a, b| {
                    u16::from_ne_bytes(a).wrapping_add(u16::from_ne_bytes(b)).to_ne_bytes()
                }),
                4 => add_up::<4>(row, components, |a, b| {
                    u32::from_ne_bytes(a).wrapping_add(u32::from_ne_bytes(b)).to_ne_bytes()
                }),
                _ => add_up::<8>(row, components, |a, b| {
                    u64::from_ne_bytes(a).wrapping_add(u64::from_ne_bytes(b)).to_ne_bytes()
                }),
            }
        }
    }
}

/// Adds to each sample the one `components` before it.
#[inline]
fn add_up<const N: usize>(row: &mut [u8], components: usize, add: impl Fn([u8; N], [u8; N]) -> [u8; N]) {
    let samples = row.as_chunks_mut::<N>().0;
    for i in components..samples.len() {
        samples[i] = add(samples[i], samples[i - components]);
    }
}

/// Floats are stored as differences of bytes, most significant bytes of the whole row first.
fn restore_floats(bytes: &mut [u8], row: &mut [u8], sample: usize, components: usize) {
    for i in components..bytes.len() {
        bytes[i] = bytes[i].wrapping_add(bytes[i - components]);
    }
    row.copy_from_slice(bytes);
    let count = row.len() / sample;
    for (i, value) in bytes.chunks_exact_mut(sample).enumerate() {
        for (b, byte) in value.iter_mut().enumerate() {
            *byte = row[b * count + i];
        }
        if cfg!(target_endian = "little") {
            value.reverse();
        }
    }
}
