//! Where the numbers lie: the chunk of a GLB file, base64 in the JSON, or a file beside it.
//!
//! A buffer is fetched when something drawn first needs it, so that buffers for pictures or animations may be missing.

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::json::{Buffer, Json};
use crate::checksum::Checksum;
use crate::error::{ReadErrorKind, quote};

/// The buffers of a document.
pub(super) struct Buffers<'a> {
    folder: PathBuf,
    chunk: Option<&'a [u8]>,
    fetched: Vec<OnceCell<Content<'a>>>,
    /// Files read, by their resolved paths: a hostile file may name one a thousand times, in as many ways.
    files: RefCell<HashMap<PathBuf, Rc<[u8]>>>,
    /// Pictures that were read from files, in the order in which they were asked for.
    pictures: RefCell<Vec<Rc<[u8]>>>,
    /// Bytes in `files`.
    bytes_read: Cell<u64>,
}

enum Content<'a> {
    Chunk(&'a [u8]),
    Own(Vec<u8>),
    /// The first so many bytes of a file.
    File(Rc<[u8]>, usize),
}

impl<'a> Buffers<'a> {
    /// Buffers that are yet to be fetched: `chunk` is that of the GLB file.
    pub(super) fn new(folder: &Path, chunk: Option<&'a [u8]>, count: usize) -> Self {
        let fetched = (0..count).map(|_| OnceCell::new()).collect();
        let (files, pictures, bytes_read) = Default::default();
        Buffers { folder: folder.into(), chunk, fetched, files, pictures, bytes_read }
    }

    /// The content of a buffer, of its declared length.
    pub(super) fn get(&self, json: &Json, index: usize) -> Result<&[u8], ReadErrorKind> {
        let (Some(buffer), Some(cell)) = (json.buffers.get(index), self.fetched.get(index)) else {
            let count = json.buffers.len();
            return Err(ReadErrorKind::at_item("buffer", index, format!("does not exist ({count} buffers)")));
        };
        let content = match cell.get() {
            Some(content) => content,
            None => {
                let content = self
                    .fetch(json, buffer, index)
                    .map_err(|reason| ReadErrorKind::at_item("buffer", index, reason))?;
                cell.get_or_init(|| content)
            }
        };
        Ok(match content {
            Content::Chunk(bytes) => bytes,
            Content::Own(bytes) => bytes,
            Content::File(bytes, length) => &bytes[..*length],
        })
    }

    /// Bytes read from files beside the document so far.
    pub(super) fn bytes_read(&self) -> u64 {
        self.bytes_read.get()
    }

    /// Adds the buffers that were read from files, in their order, each file once.
    pub(super) fn add_to(&self, sum: &mut Checksum) {
        let mut seen = HashSet::new();
        let pictures = self.pictures.borrow();
        for content in self.fetched.iter().filter_map(OnceCell::get) {
            if let Content::File(bytes, _) = content
                && seen.insert(bytes.as_ptr())
            {
                sum.update(bytes);
            }
        }
        for bytes in pictures.iter().filter(|bytes| seen.insert(bytes.as_ptr())) {
            sum.update(bytes);
        }
    }

    /// What a URI holds: a whole file beside the document of at most `most` bytes, or what stands in the URI itself.
    pub(super) fn picture(&self, json: &Json, uri: &str, most: u64) -> Result<Rc<[u8]>, String> {
        if let Some(data) = uri.get(..5).filter(|s| s.eq_ignore_ascii_case("data:")).map(|_| &uri[5..]) {
            return data_uri(data).map(Rc::from);
        }
        let quoted = quote(uri.as_bytes());
        let path = relative_path(uri).map_err(|reason| format!("{quoted} {reason}"))?;
        let path = self.folder.join(path);
        let length = std::fs::metadata(&path).map_or(0, |m| m.len());
        if length > most {
            return Err(format!("{quoted}: {length} bytes are too many"));
        }
        match self.file(json, &path, length).map_err(|reason| format!("{quoted}: {reason}"))? {
            Content::File(bytes, _) => {
                self.pictures.borrow_mut().push(Rc::clone(&bytes));
                Ok(bytes)
            }
            _ => Err("has no content".into()),
        }
    }

    fn fetch(&self, json: &Json, buffer: &Buffer, index: usize) -> Result<Content<'a>, String> {
        let declared = buffer.byte_length;
        let cut = |there: usize| match usize::try_from(declared) {
            Ok(length) if length <= there => Ok(length),
            _ => Err(format!("declares {declared} bytes, but {there} are there")),
        };
        let Some(uri) = &buffer.uri else {
            return match self.chunk {
                Some(chunk) if index == 0 => Ok(Content::Chunk(&chunk[..cut(chunk.len())?])),
                _ => Err("has no content".into()),
            };
        };
        if let Some(data) = uri.0.get(..5).filter(|s| s.eq_ignore_ascii_case("data:")).map(|_| &uri.0[5..]) {
            let mut bytes = data_uri(data)?;
            bytes.truncate(cut(bytes.len())?);
            return Ok(Content::Own(bytes));
        }
        let quoted = quote(uri.0.as_bytes());
        let path = relative_path(&uri.0).map_err(|reason| format!("{quoted} {reason}"))?;
        self.file(json, &self.folder.join(path), declared).map_err(|reason| format!("{quoted}: {reason}"))
    }

    /// The first `declared` bytes of a file that holds at least so many.
    fn file(&self, json: &Json, path: &Path, declared: u64) -> Result<Content<'a>, String> {
        let said = |e: io::Error| match e.kind() {
            io::ErrorKind::NotFound => "no such file".to_owned(),
            _ => format!("cannot be read: {e}"),
        };
        let path = std::fs::canonicalize(path).map_err(said)?;
        let metadata = std::fs::metadata(&path).map_err(said)?;
        if !metadata.is_file() {
            return Err("is not a regular file".into());
        }
        let there = metadata.len();
        if there < declared {
            return Err(format!("{declared} bytes declared, but the file has {there}"));
        }
        let mut files = self.files.borrow_mut();
        if let Some(bytes) = files.get(&path).filter(|bytes| bytes.len() as u64 >= declared) {
            return Ok(Content::File(Rc::clone(bytes), declared as usize));
        }
        // As much as any buffer may want of it, so that once is enough.
        let wanted = json.buffers.iter().map(|b| b.byte_length).filter(|&length| length <= there).max();
        let wanted = wanted.unwrap_or(declared).max(declared);
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(wanted as usize).map_err(|_| format!("{wanted} bytes are too many"))?;
        File::open(&path).map_err(said)?.take(wanted).read_to_end(&mut bytes).map_err(said)?;
        if bytes.len() as u64 != wanted {
            return Err("became shorter while it was read".into());
        }
        let bytes: Rc<[u8]> = bytes.into();
        self.bytes_read.set(self.bytes_read.get() + wanted);
        files.insert(path, Rc::clone(&bytes));
        Ok(Content::File(bytes, declared as usize))
    }
}

/// The path that a relative URI names.
fn relative_path(uri: &str) -> Result<PathBuf, &'static str> {
    let letters = uri.bytes().take_while(|b| b.is_ascii_alphanumeric() || b"+-.".contains(b)).count();
    if uri.as_bytes().get(letters) == Some(&b':') {
        return Err("is not relative to the file; other places are not read");
    }
    let decoded = percent_decoded(uri).ok_or("has a broken percent escape")?;
    let path = String::from_utf8(decoded).map_err(|_| "is not UTF-8 once decoded")?;
    // Escapes may hide what the test above looks for.
    let path = Path::new(&path);
    if path.is_absolute() || path.has_root() || uri.starts_with('\\') {
        return Err("is an absolute path; only files relative to this one are read");
    }
    Ok(path.to_path_buf())
}

fn percent_decoded(text: &str) -> Option<Vec<u8>> {
    let mut decoded = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        rest = after;
        if byte != b'%' {
            decoded.push(byte);
            continue;
        }
        let digit = |b: u8| char::from(b).to_digit(16).map(|d| d as u8);
        let (&[high, low], after) = rest.split_first_chunk()?;
        decoded.push(digit(high)? << 4 | digit(low)?);
        rest = after;
    }
    Some(decoded)
}

/// What a data URI holds, given what follows `data:`.
fn data_uri(data: &str) -> Result<Vec<u8>, String> {
    let Some((kind, content)) = data.split_once(',') else {
        return Err("its data URI has no comma".into());
    };
    let content_is_base64 =
        kind.len() >= 7 && kind.as_bytes()[kind.len() - 7..].eq_ignore_ascii_case(b";base64");
    if content_is_base64 {
        return base64(content.as_bytes()).ok_or_else(|| "its data URI is not base64".into());
    }
    percent_decoded(content).ok_or_else(|| "its data URI has a broken percent escape".into())
}

/// Base64 with or without its padding (RFC 4648, both alphabets).
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    const NOT: u8 = 0xff;
    const SIX_BITS: [u8; 256] = {
        let mut table = [NOT; 256];
        let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let mut i = 0;
        while i < 64 {
            table[alphabet[i] as usize] = i as u8;
            i += 1;
        }
        table[b'-' as usize] = 62;
        table[b'_' as usize] = 63;
        table
    };
    let padding = text.iter().rev().take(2).take_while(|&&b| b == b'=').count();
    let text = &text[..text.len() - padding];
    let (groups, rest) = text.as_chunks::<4>();
    let mut bytes = Vec::with_capacity(groups.len() * 3 + 2);
    let mut all = 0;
    for group in groups {
        let [a, b, c, d] = group.map(|b| SIX_BITS[b as usize]);
        // Only what is not in the alphabet has the top bit.
        all |= a | b | c | d;
        bytes.extend_from_slice(&[a << 2 | b >> 4, b << 4 | c >> 2, c << 6 | d]);
    }
    let mut last = [0; 3];
    for (slot, &b) in last.iter_mut().zip(rest) {
        *slot = SIX_BITS[b as usize];
        all |= *slot;
    }
    match rest.len() {
        0 => {}
        1 => return None,
        2 => bytes.push(last[0] << 2 | last[1] >> 4),
        _ => bytes.extend_from_slice(&[last[0] << 2 | last[1] >> 4, last[1] << 4 | last[2] >> 2]),
    }
    (all & 0x80 == 0).then_some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_rfc_and_of_every_byte() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9vYmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
            ("Zm9vYmE", "fooba"),
        ] {
            assert_eq!(base64(text.as_bytes()).as_deref(), Some(bytes.as_bytes()), "{text}");
        }
        assert_eq!(base64(b"-_+/"), Some(vec![0xfb, 0xff, 0xbf]));
        for bad in ["Z", "Zm9v!", "Zg=a", "Zm 9v", "=", "====", "Z\u{e9}=="] {
            assert_eq!(base64(bad.as_bytes()).filter(|b| !b.is_empty()), None, "{bad}");
        }
    }

    #[test]
    fn only_relative_paths() {
        assert_eq!(relative_path("a%20b/c%2ebin"), Ok("a b/c.bin".into()));
        assert_eq!(relative_path("../x.bin"), Ok("../x.bin".into()));
        for bad in
            ["http://x/y", "file:///etc/passwd", "C:\\x.bin", "/etc/passwd", "%2Fetc/passwd", "a%2", "%zz"]
        {
            assert!(relative_path(bad).is_err(), "{bad}");
        }
    }
}
