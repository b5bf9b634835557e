//! The figure as data: which kind of plate a file is, and the settings that it carries.

use crate::pdf::{is_pdf, pdf_metadata};
use crate::png::{SETTINGS_KEYWORD, png_text};
use crate::svg::svg_metadata;
use crate::tiff::tiff_metadata;

/// The kind of file by its first bytes: `"SVG"`, `"PNG"`, `"PDF"` or `"TIFF"`, the kinds that can carry settings;
/// `None` for all others.
pub fn is_plate(bytes: &[u8]) -> Option<&'static str> {
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        Some("PNG")
    } else if bytes.starts_with(b"II*\0") || bytes.starts_with(b"MM\0*") {
        Some("TIFF")
    } else if is_svg(bytes) {
        Some("SVG")
    } else if is_pdf(bytes) {
        Some("PDF")
    } else {
        None
    }
}

/// The settings that a plate carries; `None` if the bytes are no plate or one without settings.
///
/// Reads SVG, PNG, PDF and TIFF files of this crate. Never panics, whatever the bytes.
pub fn embedded_settings(bytes: &[u8]) -> Option<String> {
    match is_plate(bytes)? {
        "PNG" => png_text(bytes, SETTINGS_KEYWORD),
        "TIFF" => tiff_metadata(bytes),
        "PDF" => pdf_metadata(bytes),
        _ => svg_metadata(bytes),
    }
}

/// True if the first element is `svg`, after a byte-order mark, white space, declaration, comments and document type.
fn is_svg(bytes: &[u8]) -> bool {
    let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    loop {
        rest = rest.trim_ascii_start();
        // What may stand before the element ends where it says.
        let end: &[u8] = if rest.starts_with(b"<?") {
            b"?>"
        } else if rest.starts_with(b"<!--") {
            b"-->"
        } else if rest.starts_with(b"<!") {
            // A document type may declare entities of its own in brackets.
            let declares = rest.iter().find(|b| matches!(b, b'[' | b'>')) == Some(&b'[');
            if declares { b"]>" } else { b">" }
        } else {
            let name = rest.strip_prefix(b"<svg:svg").or(rest.strip_prefix(b"<svg"));
            return name
                .and_then(|r| r.first())
                .is_some_and(|b| b.is_ascii_whitespace() || matches!(b, b'>' | b'/'));
        };
        match rest.windows(end.len()).position(|w| w == end) {
            Some(at) => rest = &rest[at + end.len()..],
            None => return false,
        }
    }
}

#[cfg(test)]
mod tests;
