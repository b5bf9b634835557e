//! The files that make one volume: the named one and those it names.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};

use crate::checksum::Checksum;
use crate::error::{ReadError, ReadErrorKind, shortened};

/// Bytes that are read from files that were read before. Nobody packs a volume by naming a slice again and again,
/// but a header of a few hundred kilobytes could make one of many gigabytes that way, of itself even.
const MOST_REPEATED: u64 = 64 << 20;

/// Gives the bytes of a file beside the named one.
pub(crate) type Sibling<'a> = dyn FnMut(&Path) -> Result<Vec<u8>, ReadError> + 'a;

/// Opens the files of a volume and sums their bytes in reading order.
pub(crate) struct Files<'a> {
    /// The file that was asked for.
    pub(crate) name: &'a Path,
    sibling: &'a mut Sibling<'a>,
    sum: Checksum,
    /// The files that were read, each spelled in one way.
    seen: HashSet<PathBuf>,
    /// Bytes of files that were read before.
    repeated: u64,
}

impl<'a> Files<'a> {
    pub(crate) fn new(name: &'a Path, sibling: &'a mut Sibling<'a>) -> Self {
        Files { name, sibling, sum: Checksum::new(), seen: HashSet::from([plain(name)]), repeated: 0 }
    }

    /// Counts `bytes` as read.
    pub(crate) fn count(&mut self, bytes: &[u8]) {
        self.sum.update(bytes);
    }

    /// The checksum of everything read so far.
    pub(crate) fn checksum(&self) -> u64 {
        self.sum.finish()
    }

    /// Where a file lies that the named one calls `file`.
    pub(crate) fn path(&self, file: &str) -> PathBuf {
        self.name.parent().unwrap_or(Path::new("")).join(file)
    }

    /// Looks at another file, which is read again if it is of the volume.
    #[cfg(feature = "dicom")]
    pub(crate) fn look(&mut self, path: &Path) -> Result<Vec<u8>, ReadErrorKind> {
        (self.sibling)(path).map_err(|e| ReadErrorKind::DataFile { file: e.path, kind: Box::new(e.kind) })
    }

    /// Reads another file.
    pub(crate) fn open(&mut self, path: &Path) -> Result<Vec<u8>, ReadErrorKind> {
        let bytes = (self.sibling)(path)
            .map_err(|e| ReadErrorKind::DataFile { file: e.path, kind: Box::new(e.kind) })?;
        if !self.seen.insert(plain(path)) {
            self.repeated += bytes.len() as u64;
            if self.repeated > MOST_REPEATED {
                return Err(ReadErrorKind::TooLarge(format!(
                    "names the same files again and again ({})",
                    shortened(&path.to_string_lossy())
                )));
            }
        }
        self.count(&bytes);
        Ok(bytes)
    }
}

/// A path without `.` and `..`, as far as its text tells.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(plain.components().next_back(), Some(Component::Normal(_))) => {
                plain.pop();
            }
            other => plain.push(other),
        }
    }
    plain
}

/// Names the file in which an error lies.
pub(crate) fn in_file<T>(path: &Path, result: Result<T, ReadErrorKind>) -> Result<T, ReadErrorKind> {
    result.map_err(|kind| ReadErrorKind::DataFile { file: path.to_path_buf(), kind: Box::new(kind) })
}

/// Names of data files in few words.
#[cfg(any(feature = "nrrd", feature = "metaimage"))]
pub(crate) fn listing(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => shortened(one),
        [first, .., last] => format!("{}: {} to {}", names.len(), shortened(first), shortened(last)),
    }
}

/// More data files than any volume has.
#[cfg(any(feature = "nrrd", feature = "metaimage"))]
const MOST_FILES: u64 = 100_000;

/// The longest pattern: as long as names of files may be, for it is written out for every number.
#[cfg(any(feature = "nrrd", feature = "metaimage"))]
const LONGEST_PATTERN: usize = 255;

/// File names by a pattern as of C's `printf` ("slice%03d.raw") for the numbers from `first` to `last` by `step`.
///
/// # Errors
/// A pattern without exactly one integer conversion, or numbers that do not count; the text says what.
#[cfg(any(feature = "nrrd", feature = "metaimage"))]
pub(crate) fn numbered(pattern: &str, first: i64, last: i64, step: i64) -> Result<Vec<String>, String> {
    let wrong = || format!("'{}' is no file name with one number, as in 'slice%03d.raw'", shortened(pattern));
    if pattern.len() > LONGEST_PATTERN {
        return Err(wrong());
    }
    let (before, rest) = pattern.split_once('%').ok_or_else(wrong)?;
    let end = rest.find(|c: char| !c.is_ascii_digit()).ok_or_else(wrong)?;
    let (width, after) = rest.split_at(end);
    let zeros = width.starts_with('0');
    let after = after.strip_prefix(['d', 'i', 'u']).filter(|a| !a.contains('%')).ok_or_else(wrong)?;
    let width: usize = if width.is_empty() { 0 } else { width.parse().map_err(|_| wrong())? };
    let count = if step == 0 { None } else { last.checked_sub(first).and_then(|d| d.checked_div(step)) };
    let count = count.and_then(|n| u64::try_from(n).ok()).filter(|&n| n < MOST_FILES && width < 64);
    let count = count.ok_or_else(|| format!("no files are numbered from {first} to {last} by {step}"))?;
    let name = |i: i64| {
        let number = first + i * step;
        if zeros {
            format!("{before}{number:0width$}{after}")
        } else {
            format!("{before}{number:width$}{after}")
        }
    };
    Ok((0..=count as i64).map(name).collect())
}

#[cfg(all(test, any(feature = "nrrd", feature = "metaimage")))]
mod tests {
    use super::*;

    #[test]
    fn names_are_numbered() {
        assert_eq!(numbered("a%03d.raw", 9, 11, 1).unwrap(), ["a009.raw", "a010.raw", "a011.raw"]);
        assert_eq!(numbered("%d", 5, 1, -2).unwrap(), ["5", "3", "1"]);
        assert_eq!(numbered("x%2i", 1, 2, 5).unwrap(), ["x 1"]);
        for (pattern, first, last, step) in [
            ("a.raw", 1, 2, 1),
            ("a%s", 1, 2, 1),
            ("a%d%d", 1, 2, 1),
            ("a%", 1, 2, 1),
            ("a%d", 1, 2, 0),
            ("a%d", 2, 1, 1),
            ("a%d", 0, i64::MAX, 1),
            ("a%d", i64::MIN, i64::MAX, 1),
            ("a%d", i64::MIN, 0, -1),
            ("a%999d", 1, 2, 1),
        ] {
            assert!(numbered(pattern, first, last, step).is_err(), "{pattern} {first} {last} {step}");
        }
    }

    #[test]
    fn a_long_pattern_is_not_written_out_for_every_number() {
        let long = format!("{}%d", "a".repeat(200_000));
        let error = numbered(&long, 0, 99_999, 1).unwrap_err();
        assert!(error.contains("aaa…aaa") && error.len() < 400, "{error}");
    }

    #[test]
    fn paths_are_compared_however_they_are_spelled() {
        for path in ["a/b", "./a/b", "a//b/", "a/./b", "a/c/../b", "c/../a/b"] {
            assert_eq!(plain(Path::new(path)), Path::new("a/b"), "{path}");
        }
        assert_eq!(plain(Path::new("../../a")), Path::new("../../a"));
        assert_eq!(plain(Path::new("/a/../../b")), Path::new("/../b"));
    }
}
