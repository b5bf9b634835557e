//! The data set of a DICOM file (PS3.5, chapter 7): elements, each with a tag, a length and a value.
//!
//! Only the elements that [`tags`] names are kept, as slices of the file; the others are stepped over unread, names
//! of patients among them. The walk ends at the pixel data, whose place alone is noted: the beginning of a file is
//! enough to know an image.

use std::borrow::Cow;
use std::io::Read;

use crate::error::ReadErrorKind;
use crate::gzip;
use crate::volume::dicom::syntax::Syntax;
use crate::volume::dicom::tags;

/// Sequences within sequences: real files have five.
const DEEPEST: usize = 16;

/// Bytes of a text that are looked at, and numbers in it: a text is asked for again for every frame, and of those
/// that somebody asks for the longest (the names of a file within its folders) has 135.
const LONGEST_TEXT: usize = 1024;
const MOST_NUMBERS: usize = 8;

/// The length of a value that ends with a delimiter.
const UNDEFINED: u32 = u32::MAX;

/// A value: bytes, or the items of a sequence.
#[derive(Debug)]
enum Value<'a> {
    Bytes(&'a [u8]),
    Items(Vec<Set<'a>>),
}

/// The kept elements of a data set or an item.
#[derive(Debug, Default)]
pub(super) struct Set<'a> {
    elements: Vec<(u32, Value<'a>)>,
    big_endian: bool,
}

/// Where the pixel data stand.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelElement {
    pub(super) tag: u32,
    /// 16-bit words rather than bytes.
    pub(super) words: bool,
    /// The first byte of the value.
    pub(super) at: usize,
    /// Its length; `None` for encapsulated data.
    pub(super) length: Option<u32>,
}

/// A file with its data set unpacked, if that is deflated.
pub(super) struct Opened<'a> {
    pub(super) bytes: Cow<'a, [u8]>,
    pub(super) syntax: Syntax,
    /// The syntax as the file names it; empty if it does not.
    pub(super) uid: String,
    start: usize,
}

/// An opened file and what is kept of it.
pub(super) struct Parsed<'a> {
    pub(super) set: Set<'a>,
    pub(super) pixels: Option<PixelElement>,
}

/// True if the file says that it is DICOM.
pub(super) fn has_magic(head: &[u8]) -> bool {
    head.get(128..132) == Some(b"DICM")
}

/// Reads the file meta information and finds the data set. `whole` says that `bytes` are not just the beginning.
pub(super) fn open(bytes: &[u8], whole: bool) -> Result<Opened<'_>, ReadErrorKind> {
    let mut walker = Walker {
        bytes,
        at: if has_magic(bytes) { 132 } else { 0 },
        explicit: true,
        big_endian: false,
        depth: 0,
    };
    let mut uid = String::new();
    // Always little endian with explicit types, whatever follows; its own length is not believed.
    while walker.group() == Some(2) {
        let head = walker.head()?;
        let value = walker.value(&head)?;
        if head.tag == tags::TRANSFER_SYNTAX {
            uid = text_of(value);
        }
    }
    let start = walker.at;
    let syntax = if uid.is_empty() { guess(&bytes[start..]) } else { Syntax::of(&uid) };
    let mut opened = Opened { bytes: Cow::Borrowed(bytes), syntax, uid, start };
    if syntax.deflated {
        if !whole {
            return Err(ReadErrorKind::Refused("is deflated as a whole".into()));
        }
        opened.bytes = Cow::Owned(inflate(&bytes[start..])?);
        opened.start = 0;
    }
    Ok(opened)
}

/// The syntax of a data set without meta information: types are capital letters, and group 8 comes first.
fn guess(set: &[u8]) -> Syntax {
    let explicit = matches!(set.get(4..6), Some([b'A'..=b'Z', b'A'..=b'Z']));
    let big_endian = set.first() == Some(&0) && set.get(1).is_some_and(|&b| b != 0);
    Syntax::of(match (explicit, big_endian) {
        (true, true) => "1.2.840.10008.1.2.2",
        (true, false) => "1.2.840.10008.1.2.1",
        _ => "1.2.840.10008.1.2",
    })
}

fn inflate(packed: &[u8]) -> Result<Vec<u8>, ReadErrorKind> {
    let limit = gzip::limit(packed.len());
    let mut unpacked = Vec::new();
    flate2::read::DeflateDecoder::new(packed)
        .take(limit + 1)
        .read_to_end(&mut unpacked)
        .map_err(|e| ReadErrorKind::Refused(format!("deflated data set: is damaged ({e})")))?;
    if unpacked.len() as u64 > limit {
        return Err(ReadErrorKind::TooLarge(format!(
            "its data set unpacks to more than {} MiB",
            limit >> 20
        )));
    }
    Ok(unpacked)
}

impl Opened<'_> {
    /// Walks the data set up to its pixel data.
    pub(super) fn parse(&self) -> Result<Parsed<'_>, ReadErrorKind> {
        let Syntax { explicit, big_endian, .. } = self.syntax;
        let mut walker = Walker { bytes: &self.bytes, at: self.start, explicit, big_endian, depth: 0 };
        let mut set = Set { elements: Vec::new(), big_endian };
        let pixels = walker.walk(Some(&mut set), true)?;
        Ok(Parsed { set, pixels })
    }
}

struct Head {
    tag: u32,
    vr: [u8; 2],
    length: u32,
    /// Where the element begins.
    at: usize,
}

struct Walker<'a> {
    /// The file up to the end of what is walked: within an item nothing lies beyond the item. Otherwise the next item
    /// could be walked again, and what is in it twice as often as that.
    bytes: &'a [u8],
    at: usize,
    explicit: bool,
    big_endian: bool,
    depth: usize,
}

impl<'a> Walker<'a> {
    fn u16_at(&self, at: usize) -> Option<u16> {
        let bytes = self.bytes.get(at..)?.first_chunk::<2>()?;
        Some(if self.big_endian { u16::from_be_bytes(*bytes) } else { u16::from_le_bytes(*bytes) })
    }

    fn u32_at(&self, at: usize) -> Option<u32> {
        let bytes = self.bytes.get(at..)?.first_chunk::<4>()?;
        Some(if self.big_endian { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) })
    }

    /// The group of the next element.
    fn group(&self) -> Option<u16> {
        self.u16_at(self.at)
    }

    fn ends_early(&self) -> ReadErrorKind {
        ReadErrorKind::at_byte(self.bytes.len(), "the DICOM data set ends within an element")
    }

    /// Steps over tag, type and length.
    fn head(&mut self) -> Result<Head, ReadErrorKind> {
        self.next_head().ok_or_else(|| self.ends_early())
    }

    fn next_head(&mut self) -> Option<Head> {
        let at = self.at;
        let tag = u32::from(self.u16_at(at)?) << 16 | u32::from(self.u16_at(at + 2)?);
        let vr = *self.bytes.get(at + 4..)?.first_chunk::<2>()?;
        // Items have no type, and an element whose type is no capital letters was written as if it had none.
        let typed = self.explicit && tag >> 16 != 0xfffe && vr.iter().all(u8::is_ascii_uppercase);
        const LONG: [&[u8; 2]; 13] =
            [b"OB", b"OD", b"OF", b"OL", b"OV", b"OW", b"SQ", b"SV", b"UC", b"UN", b"UR", b"UT", b"UV"];
        let (length, size) = if !typed {
            (self.u32_at(at + 4)?, 8)
        } else if LONG.contains(&&vr) {
            (self.u32_at(at + 8)?, 12)
        } else {
            (u32::from(self.u16_at(at + 6)?), 8)
        };
        self.at = at + size;
        Some(Head { tag, vr: if typed { vr } else { *b"  " }, length, at })
    }

    /// Steps over a value of known length.
    fn value(&mut self, head: &Head) -> Result<&'a [u8], ReadErrorKind> {
        let rest = &self.bytes[self.at..];
        let value = rest.get(..head.length as usize).ok_or_else(|| {
            let (group, element) = (head.tag >> 16, head.tag & 0xffff);
            ReadErrorKind::at_byte(
                head.at,
                format!(
                    "DICOM element ({group:04x},{element:04x}) of {} bytes ends beyond what holds it",
                    head.length
                ),
            )
        })?;
        self.at += value.len();
        Ok(value)
    }

    /// Walks elements until the end or an item's delimiter, keeping those with a meaning in `set`. Of the outermost
    /// set, the walk ends at the pixel data.
    fn walk(
        &mut self,
        mut set: Option<&mut Set<'a>>,
        outermost: bool,
    ) -> Result<Option<PixelElement>, ReadErrorKind> {
        // Less than an element is padding.
        while self.at + 8 <= self.bytes.len() {
            let head = self.head()?;
            if head.tag == tags::ITEM_END {
                break;
            }
            if outermost && matches!(head.tag, tags::PIXELS | tags::FLOAT_PIXELS | tags::DOUBLE_PIXELS) {
                return Ok(Some(PixelElement {
                    tag: head.tag,
                    words: head.vr != *b"OB",
                    at: self.at,
                    length: (head.length != UNDEFINED).then_some(head.length),
                }));
            }
            let is_sequence = head.vr == *b"SQ"
                || head.length == UNDEFINED
                || (!self.explicit && tags::SEQUENCES.contains(&head.tag));
            let wanted = set.is_some() && tags::is_kept(head.tag);
            if !is_sequence {
                let value = self.value(&head)?;
                if let Some(set) = set.as_deref_mut().filter(|_| wanted) {
                    set.keep(head.tag, Value::Bytes(value));
                }
            } else if head.length == UNDEFINED || wanted {
                let items = self.items(&head, wanted)?;
                if let Some(set) = set.as_deref_mut().filter(|_| wanted) {
                    set.keep(head.tag, Value::Items(items));
                }
            } else {
                self.value(&head)?;
            }
        }
        Ok(None)
    }

    /// Walks the items of a sequence.
    fn items(&mut self, head: &Head, wanted: bool) -> Result<Vec<Set<'a>>, ReadErrorKind> {
        let mut items = Vec::new();
        let outside = self.bytes;
        if head.length != UNDEFINED {
            let start = self.at;
            self.value(head)?;
            self.bytes = &outside[..self.at];
            self.at = start;
        }
        if self.depth == DEEPEST {
            return Err(ReadErrorKind::at_byte(head.at, "DICOM sequences are nested too deeply"));
        }
        self.depth += 1;
        let (explicit, big_endian) = (self.explicit, self.big_endian);
        // What nobody knew the type of keeps the form without types (PS3.5, 6.2.2, note 5).
        if head.vr == *b"UN" {
            (self.explicit, self.big_endian) = (false, false);
        }
        while self.at < self.bytes.len() {
            let item = self.head()?;
            match item.tag {
                tags::SEQUENCE_END => break,
                tags::ITEM if matches!(&head.vr, b"OB" | b"OW") => {
                    self.value(&item)?;
                }
                tags::ITEM => {
                    let sequence = self.bytes;
                    if item.length != UNDEFINED {
                        let until = self.at.checked_add(item.length as usize);
                        let within = until.and_then(|until| sequence.get(..until));
                        self.bytes = within.ok_or_else(|| self.ends_early())?;
                    }
                    if wanted {
                        let mut set = Set { elements: Vec::new(), big_endian: self.big_endian };
                        self.walk(Some(&mut set), false)?;
                        items.push(set);
                    } else {
                        self.walk(None, false)?;
                    }
                    if item.length != UNDEFINED {
                        // Less than an element may be left.
                        self.at = self.bytes.len();
                    }
                    self.bytes = sequence;
                }
                _ => return Err(ReadErrorKind::at_byte(item.at, "something else where a DICOM item begins")),
            }
        }
        (self.explicit, self.big_endian) = (explicit, big_endian);
        self.bytes = outside;
        self.depth -= 1;
        Ok(items)
    }
}

impl<'a> Set<'a> {
    /// Of several elements with one tag the first counts; so there are never more than there are tags.
    fn keep(&mut self, tag: u32, value: Value<'a>) {
        if !self.has(tag) {
            self.elements.push((tag, value));
        }
    }

    fn bytes(&self, tag: u32) -> Option<&'a [u8]> {
        self.elements.iter().find(|(t, _)| *t == tag).and_then(|(_, value)| match value {
            Value::Bytes(bytes) => Some(*bytes),
            Value::Items(_) => None,
        })
    }

    /// True if there is such an element.
    pub(super) fn has(&self, tag: u32) -> bool {
        self.elements.iter().any(|(t, _)| *t == tag)
    }

    /// The items of a sequence; none if it is missing.
    pub(super) fn items(&self, tag: u32) -> &[Set<'a>] {
        self.elements
            .iter()
            .find(|(t, _)| *t == tag)
            .and_then(|(_, value)| match value {
                Value::Items(items) => Some(items.as_slice()),
                Value::Bytes(_) => None,
            })
            .unwrap_or_default()
    }

    /// The first item of a sequence.
    pub(super) fn item(&self, tag: u32) -> Option<&Set<'a>> {
        self.items(tag).first()
    }

    /// A text without the padding, or the beginning of a very long one; `None` if it is empty.
    pub(super) fn text(&self, tag: u32) -> Option<String> {
        let beginning = |bytes: &'a [u8]| text_of(&bytes[..bytes.len().min(LONGEST_TEXT)]);
        self.bytes(tag).map(beginning).filter(|text| !text.is_empty())
    }

    /// The first few numbers of a text (DS, IS), as far as they are finite numbers.
    pub(super) fn numbers(&self, tag: u32) -> Vec<f64> {
        numbers_of(&self.text(tag).unwrap_or_default(), MOST_NUMBERS)
    }

    /// As [`Set::numbers`], of a text with a number for each of `count` frames. To be asked for once.
    pub(super) fn numbers_of_frames(&self, tag: u32, count: usize) -> Vec<f64> {
        numbers_of(&self.bytes(tag).map(text_of).unwrap_or_default(), count)
    }

    /// The first number of a text.
    pub(super) fn number(&self, tag: u32) -> Option<f64> {
        self.numbers(tag).first().copied()
    }

    /// A binary 16-bit number (US).
    pub(super) fn short(&self, tag: u32) -> Option<u16> {
        let bytes = *self.bytes(tag)?.first_chunk::<2>()?;
        Some(if self.big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) })
    }

    /// A binary 64-bit number (FD), if it is finite.
    pub(super) fn double(&self, tag: u32) -> Option<f64> {
        let bytes = *self.bytes(tag)?.first_chunk::<8>()?;
        let number = if self.big_endian { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) };
        number.is_finite().then_some(number)
    }

    /// A binary 32-bit number (UL).
    pub(super) fn long(&self, tag: u32) -> Option<u32> {
        let bytes = *self.bytes(tag)?.first_chunk::<4>()?;
        Some(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }
}

fn numbers_of(text: &str, most: usize) -> Vec<f64> {
    let number = |n: &str| n.trim().parse().ok().filter(|n: &f64| n.is_finite());
    text.split('\\').take(most).map_while(number).collect()
}

/// Text of whatever character set: UTF-8 if it is that, otherwise Latin-1, without padding.
fn text_of(bytes: &[u8]) -> String {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    };
    text.trim_matches(|c: char| c.is_whitespace() || c == '\0').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(tag: u32, length: u32) -> Vec<u8> {
        let [group, element] = [(tag >> 16) as u16, tag as u16].map(u16::to_le_bytes);
        [&group[..], &element, &length.to_le_bytes()].concat()
    }

    /// What a data set without types keeps.
    fn parsed(set: &[u8]) -> Result<usize, String> {
        let opened = Opened {
            bytes: Cow::Borrowed(set),
            syntax: Syntax::of("1.2.840.10008.1.2"),
            uid: String::new(),
            start: 0,
        };
        let parsed = opened.parse().map_err(|e| e.to_string())?;
        Ok(parsed.set.elements.len())
    }

    /// Elements that are repeated would be searched anew for every frame.
    #[test]
    fn of_repeated_elements_the_first_is_kept() {
        assert_eq!(parsed(&head(tags::MODALITY, 0).repeat(20_000)), Ok(1));
    }

    /// A sequence that reaches out of its item would be walked once within it and once after it, and twice as often
    /// with each more of them.
    #[test]
    fn nothing_reaches_out_of_its_item() {
        let mut set = head(tags::FRAME_GROUPS, UNDEFINED);
        for _ in 0..14 {
            set.extend(head(tags::ITEM, 8));
            set.extend(head(tags::FRAME_GROUPS, UNDEFINED));
        }
        set.extend(head(tags::ITEM, 0).repeat(1000));
        set.extend(head(tags::SEQUENCE_END, 0));
        // The inner sequences end with their items, and are empty.
        assert_eq!(parsed(&set), Ok(1));
        let value = [head(tags::FRAME_GROUPS, 24), head(tags::ITEM, 8), head(tags::MODALITY, 8)].concat();
        let error = parsed(&[value, vec![0; 16]].concat()).unwrap_err();
        assert!(error.contains("(0008,0060) of 8 bytes ends beyond what holds it"), "{error}");
    }

    #[test]
    fn of_a_long_text_the_beginning_is_looked_at() {
        let long = b"1\\2\\3\\".repeat(20_000);
        let mut set = Set::default();
        set.keep(tags::POSITION, Value::Bytes(&long));
        assert_eq!(set.numbers(tags::POSITION), [1.0, 2.0, 3.0, 1.0, 2.0, 3.0, 1.0, 2.0]);
        assert_eq!(set.text(tags::POSITION).unwrap().len(), LONGEST_TEXT);
        assert_eq!(set.numbers_of_frames(tags::POSITION, 30_000).len(), 30_000);
    }
}
