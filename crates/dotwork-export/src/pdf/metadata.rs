//! The settings inside a PDF: an XMP packet, stored uncompressed so that they are found without reading the file's
//! structure.
//!
//! Adobe XMP specification, parts 1 and 3. The settings are the text of the property `dotwork:settings`.

use std::io::Read;

use flate2::read::ZlibDecoder;

use crate::xml::{escaped, unescaped};

/// The property that holds the settings.
const PROPERTY: &str = "dotwork:settings";

/// The name space of that property.
const NAMESPACE: &str = "urn:dotwork:settings#";

/// No settings text comes near; more is not inflated when a program has compressed the packet.
const PACKET_BYTES: u64 = 16 << 20;

/// Files of ours have some dozens of streams and one packet: hostile ones are not searched for hours.
const STREAMS: usize = 4096;
const PACKETS: usize = 4;

/// The XMP packet of a file. Characters that XML cannot hold become U+FFFD.
pub(super) fn packet(software: &str, title: Option<&str>, settings: Option<&str>) -> String {
    // The packet's beginning and end are fixed; its identifier is the specification's.
    let mut out = String::from("<?xpacket begin=\"\u{feff}\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n");
    out.push_str("<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n");
    out.push_str("<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n");
    out.push_str("<rdf:Description rdf:about=\"\" xmlns:dc=\"http://purl.org/dc/elements/1.1/\"");
    out.push_str(" xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\" xmlns:pdf=\"http://ns.adobe.com/pdf/1.3/\"");
    out.push_str(&format!(" xmlns:dotwork=\"{NAMESPACE}\">\n"));
    if let Some(title) = title {
        let title = escaped(title, false);
        out.push_str(&format!(
            "<dc:title><rdf:Alt><rdf:li xml:lang=\"x-default\">{title}</rdf:li></rdf:Alt></dc:title>\n"
        ));
    }
    let software = escaped(software, false);
    out.push_str(&format!("<xmp:CreatorTool>{software}</xmp:CreatorTool>\n"));
    out.push_str(&format!("<pdf:Producer>{software}</pdf:Producer>\n"));
    if let Some(settings) = settings {
        out.push_str(&format!("<{PROPERTY}>{}</{PROPERTY}>\n", escaped(settings, false)));
    }
    out.push_str("</rdf:Description>\n</rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"w\"?>");
    out
}

/// The settings that [`write_pdf`](crate::write_pdf) put into a PDF; `None` if the bytes are no PDF or hold none.
///
/// The property is looked for as text, so files that another program has saved again are read as well if it kept
/// the packet, compressed or not. Never panics, whatever the bytes.
pub fn pdf_metadata(bytes: &[u8]) -> Option<String> {
    if !is_pdf(bytes) {
        return None;
    }
    settings_in(bytes)
        .or_else(|| compressed_packets(bytes).take(PACKETS).find_map(|packet| settings_in(&packet)))
}

/// True if the file's mark is in the first kilobyte, where readers look for it.
pub(crate) fn is_pdf(bytes: &[u8]) -> bool {
    find(&bytes[..bytes.len().min(1024)], b"%PDF-").is_some()
}

/// The value of the property, written as an element or as an attribute.
fn settings_in(bytes: &[u8]) -> Option<String> {
    let mut rest = bytes;
    while let Some(at) = find(rest, PROPERTY.as_bytes()) {
        let before = at.checked_sub(1).map(|i| rest[i]);
        rest = &rest[at + PROPERTY.len()..];
        let (value, end) = match (before, rest) {
            (Some(b'<'), [b'>', value @ ..]) => (value, b'<'),
            (Some(b' ' | b'\n' | b'\r' | b'\t'), [b'=', quote @ (b'"' | b'\''), value @ ..]) => {
                (value, *quote)
            }
            _ => continue,
        };
        let end = value.iter().position(|&b| b == end)?;
        return Some(unescaped(std::str::from_utf8(&value[..end]).ok()?));
    }
    None
}

/// The packets among a file's compressed streams.
fn compressed_packets(bytes: &[u8]) -> impl Iterator<Item = Vec<u8>> + '_ {
    let mut rest = bytes;
    let mut streams = 0;
    std::iter::from_fn(move || {
        while streams < STREAMS
            && let Some(at) = find(rest, b"stream")
        {
            rest = &rest[at + b"stream".len()..];
            let data = rest.strip_prefix(b"\r\n").or(rest.strip_prefix(b"\n")).unwrap_or(b"");
            // The two bytes of a zlib header: method 8, divisible by 31. All else costs no inflating.
            let zlib =
                matches!(data, [a, b, ..] if a & 15 == 8 && (u16::from(*a) << 8 | u16::from(*b)) % 31 == 0);
            let mut start = [0; 16];
            streams += usize::from(zlib);
            if zlib
                && ZlibDecoder::new(data).read_exact(&mut start).is_ok()
                && find(&start, b"<?xpacket").is_some()
            {
                let mut packet = Vec::new();
                // What was inflated before an error is looked at all the same.
                let _ = ZlibDecoder::new(data).take(PACKET_BYTES).read_to_end(&mut packet);
                return Some(packet);
            }
        }
        None
    })
}

/// Where `needle` first lies in `bytes`.
fn find(bytes: &[u8], needle: &[u8]) -> Option<usize> {
    // Looking for the first byte alone is fast, and settings lie near the beginning of our files.
    let mut from = 0;
    while let Some(at) = bytes[from..].iter().position(|&b| b == needle[0]) {
        from += at;
        if bytes[from..].starts_with(needle) {
            return Some(from);
        }
        from += 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;
    use std::io::Write;

    const HOSTILE: &str =
        "a = \"<tag> & 'quotes' ]]> &amp;\"\r\nb = \"</dotwork:settings>\"\n\tc = 'Schädel 😀 \u{2028}'\n";

    fn file(packet: &[u8]) -> Vec<u8> {
        [b"%PDF-1.7\n1 0 obj\n<< /Length 1 >>\nstream\n", packet, b"\nendstream\nendobj\n"].concat()
    }

    #[test]
    fn settings_come_back() {
        let packet = packet("dotwork & Co", Some("<dotwork:settings>no</dotwork:settings>"), Some(HOSTILE));
        assert_eq!(pdf_metadata(&file(packet.as_bytes())).as_deref(), Some(HOSTILE));
        assert_eq!(pdf_metadata(packet.as_bytes()), None, "no PDF");
        let without = super::packet("dotwork", None, None);
        assert_eq!(pdf_metadata(&file(without.as_bytes())), None);
    }

    #[test]
    fn packets_rewritten_by_others_are_read() {
        let attribute =
            "<?xpacket begin=''?><rdf:Description dotwork:settings='a &#x3D; &#34;1&quot;&#xA;'/>";
        assert_eq!(pdf_metadata(&file(attribute.as_bytes())).as_deref(), Some("a = \"1\"\n"));
        let mut zlib = ZlibEncoder::new(Vec::new(), Compression::default());
        zlib.write_all(packet("dotwork", None, Some(HOSTILE)).as_bytes()).unwrap();
        let mut compressed = file(&zlib.finish().unwrap());
        assert_eq!(pdf_metadata(&compressed).as_deref(), Some(HOSTILE));
        compressed.truncate(60);
        assert_eq!(pdf_metadata(&compressed), None);
    }

    #[test]
    fn what_xml_cannot_hold_is_replaced() {
        let packet = packet("dotwork", None, Some("a\u{0}b\u{1b}c\u{ffff}d"));
        let read = pdf_metadata(&file(packet.as_bytes()));
        assert_eq!(read.as_deref(), Some("a\u{fffd}b\u{fffd}c\u{fffd}d"));
    }
}
