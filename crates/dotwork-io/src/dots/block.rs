//! Packing and unpacking of one section.
//!
//! A section is cut into blocks of 1 MiB, and a block into *streams*: one, or one per byte of its numbers (a byte
//! shuffle: all first bytes, then all second ones, …). A stream is deflated, or plain where that does not help: the
//! low bytes of coordinates are noise, on which deflate would spend most of its time for nothing.
//!
//! Measured on a million random stipples (x of positions and normals, `f32`): one deflated stream packs to 92 % at
//! 30 MB/s; deflated shuffled bytes to 84 % at 35 MB/s; with noise left plain to 84 % at four times that.

use std::io::Write;

use flate2::write::DeflateEncoder;
use flate2::{Compression, Decompress, FlushDecompress, Status};
use rayon::prelude::*;

use crate::gzip::DEFLATE_RATIO;

/// Raw bytes of a block; a multiple of every width.
const BLOCK: usize = 1 << 20;

/// Bytes that are packed on trial, to choose between the encodings and to recognise noise.
const SAMPLE: usize = 16 * 1024;

/// The lowest level of zlib-rs that fits its Huffman codes to the data well; higher ones save under 1 % more.
const LEVEL: u32 = 3;

/// How a section's bytes are arranged in streams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// One stream a block.
    Whole,
    /// One stream a block for each byte of its numbers.
    Shuffled,
}

impl Encoding {
    pub(super) const ALL: [Encoding; 2] = [Encoding::Whole, Encoding::Shuffled];

    /// Streams of a block.
    fn streams(self, width: usize) -> usize {
        if self == Encoding::Shuffled { width } else { 1 }
    }
}

/// Packs a section of whole numbers of `width` bytes.
pub(super) fn encode(raw: &[u8], width: usize) -> (Encoding, Vec<u8>) {
    let encoding = choose(raw, width);
    let streams: Vec<Vec<Vec<u8>>> =
        raw.par_chunks(BLOCK).map(|block| pack(block, encoding.streams(width))).collect();
    let mut stored = Vec::with_capacity(streams.iter().flatten().map(|s| s.len() + 4).sum());
    for stream in streams.iter().flatten() {
        // No longer than its raw bytes, so under 1 MiB.
        stored.extend_from_slice(&(stream.len() as u32).to_le_bytes());
    }
    streams.iter().flatten().for_each(|stream| stored.extend_from_slice(stream));
    (encoding, stored)
}

/// A section as it is, in the form of a packed one.
pub(super) fn plain(raw: &[u8]) -> (Encoding, Vec<u8>) {
    let lengths = raw.chunks(BLOCK).flat_map(|block| (block.len() as u32).to_le_bytes());
    (Encoding::Whole, lengths.chain(raw.iter().copied()).collect())
}

/// Packs a sample from the middle both ways.
fn choose(raw: &[u8], width: usize) -> Encoding {
    let sample = middle(raw, SAMPLE * width, width);
    let size = |streams| pack(sample, streams).iter().map(Vec::len).sum::<usize>();
    if width > 1 && size(width) < size(1) { Encoding::Shuffled } else { Encoding::Whole }
}

/// At most `length` bytes from the middle, beginning with a whole number.
fn middle(bytes: &[u8], length: usize, width: usize) -> &[u8] {
    let start = bytes.len().saturating_sub(length) / 2 / width * width;
    &bytes[start..bytes.len().min(start + length)]
}

/// The streams of a block.
fn pack(block: &[u8], streams: usize) -> Vec<Vec<u8>> {
    if streams == 1 {
        return vec![pack_stream(block)];
    }
    let mut plane = Vec::with_capacity(block.len() / streams);
    (0..streams)
        .map(|k| {
            plane.clear();
            plane.extend(block.chunks_exact(streams).map(|number| number[k]));
            pack_stream(&plane)
        })
        .collect()
}

/// The deflated bytes, or the bytes themselves where deflate does not make them fewer.
fn pack_stream(bytes: &[u8]) -> Vec<u8> {
    let sample = middle(bytes, SAMPLE, 1);
    let noise = sample.len() < bytes.len() && deflate(sample).len() * 100 > sample.len() * 97;
    if !noise {
        let deflated = deflate(bytes);
        if deflated.len() < bytes.len() {
            return deflated;
        }
    }
    bytes.to_vec()
}

fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::with_capacity(bytes.len() / 2), Compression::new(LEVEL));
    // Writing to a vector does not fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// Refuses lengths that cannot be true, before memory is taken.
pub(super) fn check_lengths(encoding: Encoding, stored: u64, raw: u64, width: usize) -> Result<(), String> {
    let table = raw.div_ceil(BLOCK as u64).saturating_mul(4 * encoding.streams(width) as u64);
    if !raw.is_multiple_of(width as u64) {
        return Err(format!("{raw} bytes are not whole numbers of {width}"));
    }
    if table > stored || raw > (stored - table).saturating_mul(DEFLATE_RATIO) {
        return Err(format!("{stored} stored bytes cannot hold {raw}"));
    }
    Ok(())
}

/// Unpacks a section; the error says what is wrong with it.
pub(super) fn decode(
    encoding: Encoding,
    stored: &[u8],
    raw_length: u64,
    width: usize,
) -> Result<Vec<u8>, String> {
    check_lengths(encoding, stored.len() as u64, raw_length, width)?;
    // Checked: at most 1032 times what is in memory already.
    let raw_length = raw_length as usize;
    let streams = encoding.streams(width);
    let (table, mut rest) = stored.split_at(raw_length.div_ceil(BLOCK) * streams * 4);
    let mut packed = Vec::with_capacity(table.len() / 4);
    for length in table.as_chunks::<4>().0 {
        let length = u32::from_le_bytes(*length) as usize;
        let (stream, after) = rest.split_at_checked(length).ok_or("a stream is longer than its section")?;
        packed.push(stream);
        rest = after;
    }
    if !rest.is_empty() {
        return Err("bytes are left after its last stream".into());
    }
    let mut raw = vec![0; raw_length];
    raw.par_chunks_mut(BLOCK).zip(packed.par_chunks(streams)).try_for_each(
        |(block, packed)| match packed {
            [stream] => unpack_stream(stream, block),
            _ => {
                let mut plane = vec![0; block.len() / streams];
                packed.iter().enumerate().try_for_each(|(k, stream)| {
                    unpack_stream(stream, &mut plane)?;
                    for (number, &byte) in block.chunks_exact_mut(streams).zip(&plane) {
                        number[k] = byte;
                    }
                    Ok(())
                })
            }
        },
    )?;
    Ok(raw)
}

fn unpack_stream(stream: &[u8], raw: &mut [u8]) -> Result<(), String> {
    if stream.len() == raw.len() {
        raw.copy_from_slice(stream);
        return Ok(());
    }
    let mut state = Decompress::new(false);
    let status = state.decompress(stream, raw, FlushDecompress::Finish);
    let whole = state.total_out() == raw.len() as u64 && state.total_in() == stream.len() as u64;
    match status {
        Ok(Status::StreamEnd) if whole => Ok(()),
        _ => Err("a stream does not unpack to its length".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::hash::{hash2, unit};

    #[test]
    fn every_length_and_encoding_round_trips() {
        for length in [0, 8, 16, 24, 1000, SAMPLE + 8, BLOCK - 8, BLOCK, BLOCK + 8, 2 * BLOCK + 104] {
            // Low bytes of noise, high bytes of little: what shuffling is for.
            let noisy: Vec<u8> =
                (0..length as u32).map(|i| if i % 4 < 2 { hash2(i, 1) as u8 } else { 7 }).collect();
            let random: Vec<u8> = (0..length as u32).map(|i| hash2(i, 2) as u8).collect();
            for raw in [vec![0; length], noisy, random] {
                for width in [1, 4, 8] {
                    let (encoding, stored) = encode(&raw, width);
                    assert!(stored.len() <= raw.len() + raw.len().div_ceil(BLOCK) * 4 * width);
                    assert_eq!(decode(encoding, &stored, raw.len() as u64, width).unwrap(), raw);
                }
            }
        }
    }

    #[test]
    fn the_sample_chooses() {
        let numbers: Vec<u8> = (0..100_000).flat_map(|i| (1.0 + unit(hash2(i, 3))).to_le_bytes()).collect();
        let (encoding, stored) = encode(&numbers, 4);
        assert_eq!(encoding, Encoding::Shuffled);
        assert!(stored.len() < numbers.len() * 8 / 10);
        // Few different numbers: deflate finds them whole, and not their shuffled bytes.
        let repeats: Vec<u8> = (0..100_000).flat_map(|i| hash2(hash2(i, 4) % 50, 5).to_le_bytes()).collect();
        assert_eq!(encode(&repeats, 4).0, Encoding::Whole);
    }

    #[test]
    fn absurd_lengths_are_refused() {
        for (encoding, stored, raw) in [
            (Encoding::Whole, 10, 6200),
            (Encoding::Whole, 10, u64::MAX - 7),
            (Encoding::Shuffled, 7, 1_048_584),
            (Encoding::Whole, 10, 7),
        ] {
            assert!(check_lengths(encoding, stored, raw, 8).is_err());
        }
        let (encoding, stored) = encode(&[0; 1000], 1);
        for raw in [0, 1, 999, 1001, 10_000] {
            assert!(decode(encoding, &stored, raw, 1).is_err(), "{raw}");
        }
        for cut in 0..stored.len() {
            assert!(decode(encoding, &stored[..cut], 1000, 1).is_err(), "{cut}");
        }
    }
}
