//! Base64 (RFC 4648, with padding): bytes as text inside XML.

use std::io::{self, Write};

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Input is turned into text in blocks of this many bytes: a multiple of three, so that no block is padded but the
/// last.
const BLOCK_BYTES: usize = 3 << 12;

/// Writes `bytes` as base64 without line breaks.
///
/// # Errors
/// What the writer refuses.
pub(crate) fn write_base64(w: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
    let mut text = Vec::with_capacity(BLOCK_BYTES / 3 * 4);
    for block in bytes.chunks(BLOCK_BYTES) {
        text.clear();
        for three in block.chunks(3) {
            let byte = |k: usize| u32::from(three.get(k).copied().unwrap_or(0));
            let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
            for digit in 0..4 {
                // n bytes fill n + 1 digits.
                let sextet = (bits >> (18 - 6 * digit)) & 63;
                text.push(if digit <= three.len() { ALPHABET[sextet as usize] } else { b'=' });
            }
        }
        w.write_all(&text)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> String {
        let mut out = Vec::new();
        write_base64(&mut out, bytes).unwrap();
        String::from_utf8(out).unwrap()
    }

    /// RFC 4648, section 10.
    #[test]
    fn test_vectors() {
        for (bytes, base64) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(text(bytes.as_bytes()), base64);
        }
        assert_eq!(text(&[0xfb, 0xff, 0xbf]), "+/+/");
    }

    #[test]
    fn blocks_join_without_padding_between() {
        let bytes: Vec<u8> = (0..BLOCK_BYTES + 1).map(|i| i as u8).collect();
        let whole = text(&bytes);
        assert_eq!(whole.len(), bytes.len().div_ceil(3) * 4);
        assert_eq!(whole.trim_end_matches('=').len(), (bytes.len() * 8).div_ceil(6));
        assert!(whole[..whole.len() - 4] == text(&bytes[..BLOCK_BYTES]));
    }
}
