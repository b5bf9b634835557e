//! Gzip with a limit, since a few hundred kilobytes of it can unpack to gigabytes.
//!
//! Real meshes pack 2 to 20 times, the most regular ones perhaps 50 times; deflate reaches 1032. What is unpacked may
//! grow to 64 MiB or 100 times the packed size, whichever is more, and never beyond 8 GiB. Within that, the beginning
//! is looked at before the rest is unpacked: a file of another format, or a header that declares more than could
//! follow, is refused after [`PREFIX`] bytes.

use std::io::Read;

use dotwork_drawing::Warnings;
use flate2::bufread::GzDecoder;

use crate::error::ReadErrorKind;

/// Bytes unpacked before the content is looked at.
pub(crate) const PREFIX: usize = 64 * 1024;

const SMALLEST_LIMIT: u64 = 64 << 20;
const LARGEST_LIMIT: u64 = 8 << 30;
const RATIO_LIMIT: u64 = 100;
/// What deflate can reach at most: 258 bytes from 2 bits.
pub(crate) const DEFLATE_RATIO: u64 = 1032;

/// True if `bytes` are gzip data.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x1f\x8b")
}

/// How far `packed` bytes may unpack.
pub(crate) fn limit(packed: usize) -> u64 {
    limit_of(packed, SMALLEST_LIMIT)
}

/// As [`limit`], with another limit for what is small.
pub(crate) fn limit_of(packed: usize, smallest: u64) -> u64 {
    (packed as u64).saturating_mul(RATIO_LIMIT).clamp(smallest, LARGEST_LIMIT)
}

/// Unpacks all members of gzip data; `look` sees the first [`PREFIX`] bytes, if there are so many, and may refuse.
pub(crate) fn unpack(
    packed: &[u8],
    warnings: &mut Warnings,
    look: impl FnOnce(&[u8]) -> Result<(), ReadErrorKind>,
) -> Result<Vec<u8>, ReadErrorKind> {
    let limit = limit(packed.len());
    // The trailer holds the length modulo 2³²: a hint for the allocation, believed as far as deflate could reach.
    let hint = packed.last_chunk::<4>().map_or(0, |b| u64::from(u32::from_le_bytes(*b)));
    let capacity = hint.min(limit).min(packed.len() as u64 * DEFLATE_RATIO);
    let mut unpacked = Vec::with_capacity(capacity as usize);
    let mut look = Some(look);
    let mut rest = packed;
    while is_gzip(rest) {
        let mut decoder = GzDecoder::new(rest);
        if look.is_some() {
            pour(&mut decoder, &mut unpacked, PREFIX as u64)?;
            if unpacked.len() >= PREFIX
                && let Some(look) = look.take()
            {
                look(&unpacked)?;
            }
        }
        pour(&mut decoder, &mut unpacked, limit + 1)?;
        if unpacked.len() as u64 > limit {
            return Err(ReadErrorKind::TooLarge(format!(
                "unpacks to more than {} MiB, over {RATIO_LIMIT} times its size; if that is meant, unpack it first",
                limit >> 20
            )));
        }
        rest = decoder.into_inner();
    }
    if rest.iter().any(|&b| b != 0) {
        warnings.say(format!("{} bytes after the gzip data ignored", rest.len()));
    }
    if unpacked.is_empty() {
        return Err(ReadErrorKind::Gzip("is empty once unpacked".into()));
    }
    Ok(unpacked)
}

/// Unpacks until `into` holds `until` bytes or the member ends.
fn pour(decoder: &mut impl Read, into: &mut Vec<u8>, until: u64) -> Result<(), ReadErrorKind> {
    let room = until.saturating_sub(into.len() as u64);
    match decoder.take(room).read_to_end(into) {
        Ok(_) => Ok(()),
        Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            Err(ReadErrorKind::Gzip(format!("ends early, after {} unpacked bytes", into.len())))
        }
        Err(e) => Err(ReadErrorKind::Gzip(format!("is damaged after {} unpacked bytes ({e})", into.len()))),
    }
}
