//! The syntax of PDF: numbers, strings, numbered objects and the table of their places.

use std::io::{self, Write};

/// Appends an integer.
#[inline]
pub(super) fn integer(out: &mut Vec<u8>, n: i64) {
    let mut digits = [0; 20];
    let mut at = digits.len();
    let mut rest = n.unsigned_abs();
    loop {
        at -= 1;
        digits[at] = b'0' + (rest % 10) as u8;
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    if n < 0 {
        out.push(b'-');
    }
    out.extend_from_slice(&digits[at..]);
}

/// Appends a finite number of ordinary size, rounded to at most `decimals` (up to 10) decimals.
pub(super) fn real(out: &mut Vec<u8>, v: f64, decimals: u32) {
    let one = 10i64.pow(decimals);
    // The cast saturates; nothing that a page holds comes near.
    let scaled = (v * one as f64).round() as i64;
    if scaled < 0 {
        out.push(b'-');
    }
    let (whole, mut fraction) = (scaled.unsigned_abs() / one as u64, scaled.unsigned_abs() % one as u64);
    integer(out, whole as i64);
    if fraction == 0 {
        return;
    }
    let mut places = decimals as usize;
    while fraction % 10 == 0 {
        fraction /= 10;
        places -= 1;
    }
    out.push(b'.');
    let text = fraction.to_string();
    out.extend(std::iter::repeat_n(b'0', places - text.len()));
    out.extend_from_slice(text.as_bytes());
}

/// Appends a text string: literal where printable ASCII suffices, UTF-16 in hexadecimal elsewhere.
pub(super) fn text_string(out: &mut Vec<u8>, text: &str) {
    if text.bytes().all(|b| matches!(b, b' '..=b'~')) {
        out.push(b'(');
        for b in text.bytes() {
            if matches!(b, b'(' | b')' | b'\\') {
                out.push(b'\\');
            }
            out.push(b);
        }
        out.push(b')');
    } else {
        out.extend_from_slice(b"<FEFF");
        for unit in text.encode_utf16() {
            out.extend_from_slice(format!("{unit:04X}").as_bytes());
        }
        out.push(b'>');
    }
}

/// The number of an object.
pub(super) type Id = usize;

/// A file in the making: its objects and their places.
pub(super) struct Objects<W: Write> {
    inner: W,
    at: u64,
    /// Where object `id` begins, at `id − 1`; 0 until it is written.
    places: Vec<u64>,
}

impl<W: Write> Objects<W> {
    /// Writes the header.
    pub(super) fn new(inner: W) -> io::Result<Objects<W>> {
        let mut objects = Objects { inner, at: 0, places: Vec::new() };
        // Bytes above 127 in the second line tell transfer programs that the file is not text.
        objects.bytes(b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n")?;
        Ok(objects)
    }

    fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.at += bytes.len() as u64;
        self.inner.write_all(bytes)
    }

    /// A number for an object that is written later.
    pub(super) fn reserve(&mut self) -> Id {
        self.places.push(0);
        self.places.len()
    }

    /// Writes an object.
    pub(super) fn object(&mut self, id: Id, body: impl AsRef<[u8]>) -> io::Result<()> {
        self.places[id - 1] = self.at;
        self.bytes(format!("{id} 0 obj\n").as_bytes())?;
        self.bytes(body.as_ref())?;
        self.bytes(b"\nendobj\n")
    }

    /// Writes a stream with the entries `entries` in its dictionary besides its length.
    pub(super) fn stream(&mut self, id: Id, entries: &str, data: &[u8]) -> io::Result<()> {
        self.places[id - 1] = self.at;
        let gap = if entries.is_empty() { "" } else { " " };
        let head = format!("{id} 0 obj\n<< /Length {}{gap}{entries} >>\nstream\n", data.len());
        self.bytes(head.as_bytes())?;
        self.bytes(data)?;
        self.bytes(b"\nendstream\nendobj\n")
    }

    /// Writes the table of places and the end of the file.
    pub(super) fn finish(mut self, root: Id, info: Id) -> io::Result<()> {
        debug_assert!(self.places.iter().all(|&p| p > 0), "every reserved object is written");
        let start = self.at;
        let count = self.places.len() + 1;
        let mut table = format!("xref\n0 {count}\n0000000000 65535 f \n");
        for place in &self.places {
            table.push_str(&format!("{place:010} 00000 n \n"));
        }
        table.push_str(&format!(
            "trailer\n<< /Size {count} /Root {root} 0 R /Info {info} 0 R >>\nstartxref\n{start}\n%%EOF\n"
        ));
        self.bytes(table.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(write: impl FnOnce(&mut Vec<u8>)) -> String {
        let mut out = Vec::new();
        write(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn numbers() {
        for n in [0, 7, -7, 10, 1_234_567_890_123, i64::MIN, i64::MAX] {
            assert_eq!(text(|out| integer(out, n)), n.to_string());
        }
        for (v, decimals, expected) in [
            (0.0, 5, "0"),
            (-0.0, 5, "0"),
            (-0.000_001, 5, "0"),
            (245.76, 5, "245.76"),
            (0.05, 4, "0.05"),
            (-12.5, 0, "-13"),
            (99.999_99, 3, "100"),
            (1.200_3, 4, "1.2003"),
        ] {
            assert_eq!(text(|out| real(out, v, decimals)), expected, "{v}");
        }
    }

    #[test]
    fn strings() {
        assert_eq!(text(|out| text_string(out, "a (b) \\c")), r"(a \(b\) \\c)");
        assert_eq!(text(|out| text_string(out, "ä😀")), "<FEFF00E4D83DDE00>");
        assert_eq!(text(|out| text_string(out, "a\nb")), "<FEFF0061000A0062>");
    }
}
