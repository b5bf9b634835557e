//! GLB: a 12-byte header, then chunks with length and type; the first is the JSON, the second may be a buffer.

use dotwork_drawing::Warnings;

use crate::error::ReadErrorKind;

/// The parts of a file of either form.
pub(super) struct Parts<'a> {
    pub(super) json: &'a [u8],
    /// Where the JSON begins, in a GLB file.
    pub(super) start: Option<usize>,
    /// The chunk that is buffer 0.
    pub(super) binary: Option<&'a [u8]>,
}

/// Bytes of the header, and of the head of a chunk.
const HEADER: usize = 12;
const CHUNK_HEAD: usize = 8;

/// Takes a file apart.
pub(super) fn split<'a>(bytes: &'a [u8], warnings: &mut Warnings) -> Result<Parts<'a>, ReadErrorKind> {
    if !bytes.starts_with(b"glTF") {
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return Ok(Parts { json, start: None, binary: None });
    }
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(ReadErrorKind::at_byte(bytes.len(), "the file ends in the middle of the GLB header"));
    };
    if version != 2 {
        return Err(ReadErrorKind::at_byte(4, format!("GLB version {version}; only version 2 is read")));
    }
    let length = length as usize;
    if length > bytes.len() {
        let there = bytes.len();
        return Err(ReadErrorKind::at_byte(8, format!("the GLB header declares {length} bytes of {there}")));
    }
    if length < bytes.len() {
        warnings
            .say(format!("{} bytes after the declared end of the GLB file ignored", bytes.len() - length));
    }
    let bytes = &bytes[..length];
    let (kind, json, mut at) = chunk(bytes, HEADER)?;
    if kind != *b"JSON" {
        return Err(ReadErrorKind::at_byte(HEADER, "the first chunk is not JSON"));
    }
    let mut binary = None;
    // Chunks of other kinds are for extensions.
    while binary.is_none() && at < bytes.len() {
        let (kind, content, next) = chunk(bytes, at)?;
        if kind == *b"BIN\0" {
            binary = Some(content);
        }
        at = next;
    }
    Ok(Parts { json, start: Some(HEADER + CHUNK_HEAD), binary })
}

/// The kind and the content of the chunk at byte `at`, and where the next one begins.
fn chunk(bytes: &[u8], at: usize) -> Result<([u8; 4], &[u8], usize), ReadErrorKind> {
    let kind = at.checked_add(4).and_then(|from| bytes.get(from..)?.first_chunk::<4>());
    let (Some(length), Some(&kind)) = (u32_at(bytes, at), kind) else {
        return Err(ReadErrorKind::at_byte(bytes.len(), "the file ends before or in the head of a chunk"));
    };
    let rest = &bytes[at + CHUNK_HEAD..];
    let Some(content) = rest.get(..length as usize) else {
        let left = rest.len();
        let reason = format!("the chunk declares {length} bytes, but {left} follow");
        return Err(ReadErrorKind::at_byte(at, reason));
    };
    Ok((kind, content, at + CHUNK_HEAD + length as usize))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}
