//! The header of a PLY file: which elements follow, and what each is made of.

use crate::error::{ReadErrorKind, quote};

/// How numbers are stored after the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &[u8]) -> Option<Scalar> {
        Some(match name {
            b"char" | b"int8" => Scalar::I8,
            b"uchar" | b"uint8" => Scalar::U8,
            b"short" | b"int16" => Scalar::I16,
            b"ushort" | b"uint16" => Scalar::U16,
            b"int" | b"int32" => Scalar::I32,
            b"uint" | b"uint32" => Scalar::U32,
            // Not in the original description, but written by some tools.
            b"long" | b"int64" => Scalar::I64,
            b"ulong" | b"uint64" => Scalar::U64,
            b"float" | b"float32" => Scalar::F32,
            b"double" | b"float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }

    /// The number that stands for the whole of a colour channel; `None` for fractions, of which some files have 0…1
    /// and some 0…255.
    pub(super) fn full(self) -> Option<f32> {
        Some(match self {
            Scalar::F32 | Scalar::F64 => return None,
            Scalar::I8 => i8::MAX.into(),
            Scalar::U8 => u8::MAX.into(),
            Scalar::I16 => i16::MAX.into(),
            Scalar::U16 => u16::MAX.into(),
            // Wide integers hold 0…255 as well: wide types are carelessness, not precision.
            Scalar::I32 | Scalar::U32 | Scalar::I64 | Scalar::U64 => u8::MAX.into(),
        })
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Scalar::F32 | Scalar::F64)
    }
}

/// What one property holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    line: u64,
}

impl Element {
    /// The fewest bytes one row takes in a binary file: its lists empty.
    pub(super) fn least_size(&self) -> usize {
        let size = |p: &Property| match p.kind {
            Kind::Scalar(scalar) => scalar.size(),
            Kind::List { count, .. } => count.size(),
        };
        self.properties.iter().map(size).sum()
    }

    /// Bytes of every row in a binary file, if there are no lists.
    pub(super) fn stride(&self) -> Option<usize> {
        let fixed = self.properties.iter().all(|p| matches!(p.kind, Kind::Scalar(_)));
        fixed.then(|| self.least_size())
    }

    /// Which properties are x, y and z.
    pub(super) fn xyz(&self) -> Result<[usize; 3], ReadErrorKind> {
        let mut found = [0; 3];
        for (slot, name) in found.iter_mut().zip(["x", "y", "z"]) {
            let at = self.properties.iter().position(|p| p.name == name);
            match at.map(|i| (i, self.properties[i].kind)) {
                Some((i, Kind::Scalar(_))) => *slot = i,
                Some(_) => return Err(self.error(format!("the vertex property {name} is a list"))),
                None => return Err(self.error(format!("the element vertex has no property {name}"))),
            }
        }
        Ok(found)
    }

    /// The type of the colour of the rows, and which properties are red, green, blue and perhaps opacity.
    pub(super) fn color(&self) -> Option<(Scalar, [Option<usize>; 4])> {
        let scalar = |name: &str| {
            let at = self.properties.iter().position(|p| p.name == name)?;
            match self.properties[at].kind {
                Kind::Scalar(scalar) => Some((at, scalar)),
                Kind::List { .. } => None,
            }
        };
        const NAMES: [[&str; 4]; 3] = [
            ["red", "green", "blue", "alpha"],
            ["diffuse_red", "diffuse_green", "diffuse_blue", "diffuse_alpha"],
            ["r", "g", "b", "a"],
        ];
        NAMES.iter().find_map(|names| {
            let [r, g, b, a] = names.map(scalar);
            let (red, kind) = r?;
            let same = |other: Option<(usize, Scalar)>| other.filter(|o| o.1 == kind).map(|o| o.0);
            Some((kind, [Some(red), Some(same(g)?), Some(same(b)?), same(a)]))
        })
    }

    /// Which property lists the corners of a face or the vertices of a strip.
    pub(super) fn corner_list(&self) -> Result<usize, ReadErrorKind> {
        let at = self.properties.iter().position(|p| p.name == "vertex_indices" || p.name == "vertex_index");
        let Some(at) = at else {
            let name = &self.name;
            return Err(
                self.error(format!("the element {name} has no property vertex_indices or vertex_index"))
            );
        };
        match self.properties[at].kind {
            Kind::List { item, .. } if item.is_integer() => Ok(at),
            Kind::List { .. } => {
                Err(self.error(format!("the {} property vertex_indices does not hold integers", self.name)))
            }
            Kind::Scalar(_) => {
                Err(self.error(format!("the {} property vertex_indices is not a list", self.name)))
            }
        }
    }

    fn error(&self, reason: impl Into<String>) -> ReadErrorKind {
        ReadErrorKind::at_line(self.line, reason)
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Bytes of the header, its last line end included.
    pub(super) length: usize,
    /// Lines of the header.
    pub(super) lines: u64,
    /// Lines end with a lone `\r` (old Macintosh files).
    pub(super) lone_cr: bool,
}

impl Header {
    /// The element of that name.
    pub(super) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|e| e.name == name)
    }

    pub(super) fn parse(bytes: &[u8]) -> Result<Header, ReadErrorKind> {
        let first_end = bytes.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(bytes.len());
        // Only the first line end tells: in a binary file the byte after the header may be anything.
        let lone_cr = bytes.get(first_end) == Some(&b'\r') && bytes.get(first_end + 1) != Some(&b'\n');
        let newline = if lone_cr { b'\r' } else { b'\n' };
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut at = 0;
        let mut line = 0;
        loop {
            let Some(length) = bytes[at..].iter().position(|&b| b == newline) else {
                return last_line(&bytes[at..], line + 1, bytes.len(), lone_cr, encoding, elements);
            };
            let text = &bytes[at..at + length];
            at += length + 1;
            line += 1;
            if line > 1 && statement(text, line, &mut encoding, &mut elements)? {
                return finished(at, line, lone_cr, encoding, elements);
            }
        }
    }
}

/// A header may end the file without a line end (no data at all); anything else is cut off.
fn last_line(
    text: &[u8],
    line: u64,
    length: usize,
    lone_cr: bool,
    mut encoding: Option<Encoding>,
    mut elements: Vec<Element>,
) -> Result<Header, ReadErrorKind> {
    if text.trim_ascii() == b"end_header" && statement(text, line, &mut encoding, &mut elements)? {
        return finished(length, line, lone_cr, encoding, elements);
    }
    Err(ReadErrorKind::at_line(line, "the file ends in the middle of the header (no end_header)"))
}

fn finished(
    length: usize,
    lines: u64,
    lone_cr: bool,
    encoding: Option<Encoding>,
    elements: Vec<Element>,
) -> Result<Header, ReadErrorKind> {
    match encoding {
        Some(encoding) => Ok(Header { encoding, elements, length, lines, lone_cr }),
        None => Err(ReadErrorKind::at_line(lines, "the header has no format line")),
    }
}

/// Elements beyond this number are a broken header, not a mesh.
const MOST_ELEMENTS: usize = 1000;

/// Reads one line of the header; true if it was the last.
fn statement(
    text: &[u8],
    line: u64,
    encoding: &mut Option<Encoding>,
    elements: &mut Vec<Element>,
) -> Result<bool, ReadErrorKind> {
    let error = |reason: String| ReadErrorKind::at_line(line, reason);
    let mut words = text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    match words.next().unwrap_or_default() {
        b"" | b"comment" | b"obj_info" => {}
        b"end_header" => return Ok(true),
        b"format" => *encoding = Some(format(&mut words).map_err(error)?),
        b"element" => {
            let element = element(&mut words, line).map_err(error)?;
            if elements.iter().any(|e| e.name == element.name) {
                return Err(error(format!(
                    "the element {} is declared twice",
                    quote(element.name.as_bytes())
                )));
            }
            if elements.len() == MOST_ELEMENTS {
                return Err(error(format!("more than {MOST_ELEMENTS} elements")));
            }
            elements.push(element);
        }
        b"property" => {
            let property = property(&mut words).map_err(error)?;
            match elements.last_mut() {
                Some(element) => element.properties.push(property),
                None => return Err(error("a property comes before the first element".into())),
            }
        }
        other => return Err(error(format!("{} is not a PLY header keyword", quote(other)))),
    }
    Ok(false)
}

fn format<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Result<Encoding, String> {
    match words.next().unwrap_or_default() {
        b"ascii" => Ok(Encoding::Ascii),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        other => Err(format!("{} is not a PLY format", quote(other))),
    }
}

fn element<'a>(words: &mut impl Iterator<Item = &'a [u8]>, line: u64) -> Result<Element, String> {
    let name = words.next().unwrap_or_default();
    let count = words.next().unwrap_or_default();
    match std::str::from_utf8(count).ok().and_then(|c| c.parse().ok()) {
        Some(count) => Ok(Element {
            name: String::from_utf8_lossy(name).into_owned(),
            count,
            properties: Vec::new(),
            line,
        }),
        None => Err(format!("{} is not a count of elements {}", quote(count), quote(name))),
    }
}

fn property<'a>(words: &mut impl Iterator<Item = &'a [u8]>) -> Result<Property, String> {
    let scalar = |word: &[u8]| Scalar::parse(word).ok_or_else(|| format!("{} is not a type", quote(word)));
    let mut next = || words.next().unwrap_or_default();
    let kind = match next() {
        b"list" => {
            let count = scalar(next())?;
            if !count.is_integer() {
                return Err("a list cannot have a fractional count".into());
            }
            Kind::List { count, item: scalar(next())? }
        }
        word => Kind::Scalar(scalar(word)?),
    };
    match next() {
        b"" => Err("a property without a name".into()),
        name => Ok(Property { name: String::from_utf8_lossy(name).into_owned(), kind }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_ends_of_all_three_kinds() {
        for newline in ["\n", "\r\n", "\r"] {
            let text = [
                "ply",
                "format binary_big_endian 1.0",
                "comment x",
                "element vertex 3",
                "property float x",
                "end_header",
                "\r\nbody",
            ];
            let bytes = text.join(newline);
            let header = Header::parse(bytes.as_bytes()).unwrap();
            assert_eq!(header.encoding, Encoding::BigEndian);
            assert_eq!((header.lines, header.lone_cr), (6, newline == "\r"));
            assert_eq!(&bytes[header.length..], "\r\nbody", "{newline:?}");
        }
    }

    #[test]
    fn broken_headers_name_the_line() {
        for (body, expected) in [
            (
                "format ascii 1.0\nelement vertex -3\nend_header\n",
                "line 3: '-3' is not a count of elements 'vertex'",
            ),
            ("format latin 1.0\nend_header\n", "line 2: 'latin' is not a PLY format"),
            ("end_header\n", "line 2: the header has no format line"),
            ("format ascii 1.0\nproperty float x\n", "line 3: a property comes before the first element"),
            ("format ascii 1.0\nelement vertex 1\nproperty half x\n", "line 4: 'half' is not a type"),
            ("format ascii 1.0\nelement vertex 1\nproperty float\n", "line 4: a property without a name"),
            (
                "format ascii 1.0\nelement face 1\nproperty list float int a\n",
                "line 4: a list cannot have a fractional count",
            ),
            ("format ascii 1.0\nelement a 1\nelement a 1\n", "line 4: the element 'a' is declared twice"),
            ("format ascii 1.0\nsurprise\n", "line 3: 'surprise' is not a PLY header keyword"),
            ("format ascii 1.0\n", "line 3: the file ends in the middle of the header (no end_header)"),
        ] {
            let error = Header::parse(format!("ply\n{body}").as_bytes()).unwrap_err();
            assert_eq!(error.to_string(), expected);
        }
    }
}
