//! The files that make one volume: the named one and those it names.

use std::path::{Path, PathBuf};

use crate::checksum::Checksum;
use crate::error::{ReadError, ReadErrorKind};

/// Gives the bytes of a file beside the named one.
pub(crate) type Sibling<'a> = dyn FnMut(&Path) -> Result<Vec<u8>, ReadError> + 'a;

/// Opens the files of a volume and sums their bytes in reading order.
pub(crate) struct Files<'a> {
    /// The file that was asked for.
    pub(crate) name: &'a Path,
    sibling: &'a mut Sibling<'a>,
    sum: Checksum,
}

impl<'a> Files<'a> {
    pub(crate) fn new(name: &'a Path, sibling: &'a mut Sibling<'a>) -> Self {
        Files { name, sibling, sum: Checksum::new() }
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

    /// Reads another file.
    pub(crate) fn open(&mut self, path: &Path) -> Result<Vec<u8>, ReadErrorKind> {
        let bytes = (self.sibling)(path)
            .map_err(|e| ReadErrorKind::DataFile { file: e.path, kind: Box::new(e.kind) })?;
        self.count(&bytes);
        Ok(bytes)
    }
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
        [one] => one.clone(),
        [first, .., last] => format!("{}: {first} to {last}", names.len()),
    }
}

/// More data files than any volume has.
#[cfg(any(feature = "nrrd", feature = "metaimage"))]
const MOST_FILES: u64 = 100_000;

/// File names by a pattern as of C's `printf` ("slice%03d.raw") for the numbers from `first` to `last` by `step`.
///
/// # Errors
/// A pattern without exactly one integer conversion, or numbers that do not count; the text says what.
#[cfg(any(feature = "nrrd", feature = "metaimage"))]
pub(crate) fn numbered(pattern: &str, first: i64, last: i64, step: i64) -> Result<Vec<String>, String> {
    let wrong = || format!("'{pattern}' is no file name with one number, as in 'slice%03d.raw'");
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
}
