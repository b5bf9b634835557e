//! Finding the DICOM files of a folder or of a DICOMDIR, and what each holds.
//!
//! Of a file in a folder only the beginning is read at first, up to its pixels.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use dotwork_drawing::Warnings;

use crate::error::ReadErrorKind;
use crate::file::read_bytes;
use crate::volume::dicom::image::Image;
use crate::volume::dicom::series::Scan;
use crate::volume::dicom::set::{self, Set};
use crate::volume::dicom::tags;
use crate::volume::facts::short;
use crate::volume::files::Files;

/// Folders within folders.
const DEEPEST: usize = 8;
/// More files than any study has.
const MOST_FILES: usize = 200_000;
/// Files looked at to know whether a folder holds DICOM.
const MOST_PROBED: usize = 2000;
/// Bytes that hold all but the pixels of most files.
const BEGINNING: u64 = 64 << 10;

/// The files of a folder and the folders in it, in the order of their names; hidden ones are left out, links to
/// folders are not followed.
fn files_of(folder: &Path, most: usize) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = vec![(folder.to_path_buf(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        let mut entries = std::fs::read_dir(&folder)?.collect::<io::Result<Vec<_>>>()?;
        entries.sort_by_key(std::fs::DirEntry::file_name);
        let mut within = Vec::new();
        for entry in entries {
            if entry.file_name().to_string_lossy().starts_with('.') {
                continue;
            }
            if entry.file_type()?.is_dir() {
                if depth < DEEPEST {
                    within.push((entry.path(), depth + 1));
                }
            } else if entry.path().is_file() {
                files.push(entry.path());
                if files.len() > most {
                    return Ok(files);
                }
            }
        }
        folders.extend(within.into_iter().rev());
    }
    Ok(files)
}

fn beginning(path: &Path, bytes: u64) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    File::open(path)?.take(bytes).read_to_end(&mut head)?;
    Ok(head)
}

/// True if a folder, or one in it, holds a DICOM file.
pub(super) fn holds_dicom(folder: &Path) -> bool {
    // Files by the names of other formats are not opened.
    let others = ["tif", "tiff", "png", "jpg", "txt", "nrrd", "nii", "gz", "json", "toml"];
    let is_other = |path: &Path| {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        others.contains(&extension.as_str())
    };
    let files = files_of(folder, MOST_PROBED).unwrap_or_default();
    files.iter().filter(|f| !is_other(f)).any(|f| beginning(f, 132).is_ok_and(|b| set::has_magic(&b)))
}

/// What was passed over, for warnings.
#[derive(Default)]
struct Skipped {
    /// No DICOM, and the first of them.
    foreign: (u64, Option<String>),
    /// DICOM without an image.
    imageless: (u64, Option<String>),
    /// What cannot be read, and why the first.
    unread: (u64, Option<String>),
}

impl Skipped {
    fn count(kind: &mut (u64, Option<String>), text: String) {
        kind.0 += 1;
        kind.1.get_or_insert(text);
    }

    /// Puts a file that makes no scan where it belongs.
    fn add(&mut self, path: &Path, error: &ReadErrorKind, imageless: bool) {
        let name = short(&path.file_name().unwrap_or_default().to_string_lossy());
        if imageless {
            Skipped::count(&mut self.imageless, name);
        } else {
            Skipped::count(&mut self.unread, format!("{name}: {error}"));
        }
    }

    fn say(self, warnings: &mut Warnings) {
        for (what, (count, first)) in [
            ("files that are no DICOM skipped", self.foreign),
            ("DICOM files without an image skipped", self.imageless),
            ("DICOM files that cannot be read skipped", self.unread),
        ] {
            // "1 files" reads badly, and a count of 1 is not shown.
            let what = if count == 1 {
                what.replace("files", "file").replacen("that are", "that is", 1)
            } else {
                what.into()
            };
            let what = if count == 1 { format!("1 {what}") } else { what };
            warnings.counted(what, count, first);
        }
    }
}

/// An image, or why there is none, and whether that is because the file holds something else.
fn scan_bytes(path: &Path, bytes: &[u8], length: u64) -> Result<Scan, (ReadErrorKind, bool)> {
    let damaged = |e| (e, false);
    let opened = set::open(bytes, bytes.len() as u64 == length).map_err(damaged)?;
    let parsed = opened.parse().map_err(damaged)?;
    let imageless = parsed.pixels.is_none();
    // Of a deflated file, what counts is what it unpacks to.
    let there = if opened.syntax.deflated { opened.bytes.len() as u64 } else { length };
    let image = Image::of(&opened, &parsed, there).map_err(|e| (e, imageless))?;
    Ok(Scan { path: path.to_path_buf(), length, image })
}

/// The scan of one file whose bytes are at hand.
pub(super) fn scan_file(path: &Path, bytes: &[u8]) -> Result<Scan, ReadErrorKind> {
    scan_bytes(path, bytes, bytes.len() as u64).map_err(|(e, _)| e)
}

fn scan_path(path: &Path) -> Result<Option<Scan>, (ReadErrorKind, bool)> {
    let io = |e| (ReadErrorKind::Io(e), false);
    let head = beginning(path, BEGINNING).map_err(io)?;
    if !set::has_magic(&head) && !super::is_named_dicom(path) {
        return Ok(None);
    }
    let length = std::fs::metadata(path).map_err(io)?.len();
    if length > head.len() as u64 {
        // The pixels begin within what was read, or all of it is needed.
        if let Ok(scan) = scan_bytes(path, &head, length) {
            return Ok(Some(scan));
        }
        let bytes = read_bytes(path).map_err(|e| (e, false))?;
        return scan_bytes(path, &bytes, length.max(bytes.len() as u64)).map(Some);
    }
    scan_bytes(path, &head, length).map(Some)
}

/// The images of all DICOM files of a folder and of the folders in it.
///
/// # Errors
/// There are none.
pub(super) fn scan_folder(folder: &Path, warnings: &mut Warnings) -> Result<Vec<Scan>, ReadErrorKind> {
    let paths = files_of(folder, MOST_FILES).map_err(ReadErrorKind::Io)?;
    if paths.len() > MOST_FILES {
        return Err(ReadErrorKind::TooLarge(format!("is a folder of more than {MOST_FILES} files")));
    }
    let mut scans = Vec::new();
    let mut skipped = Skipped::default();
    let mut first_error = None;
    for path in &paths {
        // It is about the others.
        if path.file_name().is_some_and(|n| n.eq_ignore_ascii_case("DICOMDIR")) {
            continue;
        }
        match scan_path(path) {
            Ok(Some(scan)) => scans.push(scan),
            Ok(None) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                Skipped::count(&mut skipped.foreign, short(&name));
            }
            Err((error, imageless)) => {
                skipped.add(path, &error, imageless);
                if !imageless && first_error.is_none() {
                    first_error = Some(ReadErrorKind::DataFile { file: path.clone(), kind: Box::new(error) });
                }
            }
        }
    }
    if scans.is_empty() {
        let none = || ReadErrorKind::Refused("is a directory without DICOM images".into());
        return Err(first_error.unwrap_or_else(none));
    }
    skipped.say(warnings);
    Ok(scans)
}

/// The images of the files that a DICOMDIR (PS3.10, chapter 8) names.
///
/// # Errors
/// There are none.
pub(super) fn scan_directory(
    directory: &Set,
    files: &mut Files,
    warnings: &mut Warnings,
) -> Result<Vec<Scan>, ReadErrorKind> {
    let mut scans = Vec::new();
    let mut skipped = Skipped::default();
    let mut first_error = None;
    let mut seen = std::collections::HashSet::new();
    for record in directory.items(tags::DIRECTORY_RECORDS) {
        let Some(name) = record.text(tags::REFERENCED_FILE) else { continue };
        let parts: Vec<&str> = name.split('\\').map(str::trim).collect();
        // Eight names at most, none of them leading out of the folder.
        let plain = |p: &&str| !p.is_empty() && *p != ".." && *p != "." && !p.contains(['/', ':', '\0']);
        if parts.len() > DEEPEST || !parts.iter().all(plain) {
            continue;
        }
        let path = files.path(&parts.join("/"));
        // One file is named in many ways: names may have spaces around them.
        if !seen.insert(path.clone()) {
            continue;
        }
        let read = files.look(&path).map_err(|e| (e, false));
        match read.and_then(|bytes| scan_bytes(&path, &bytes, bytes.len() as u64)) {
            Ok(scan) => scans.push(scan),
            Err((error, imageless)) => {
                skipped.add(&path, &error, imageless);
                first_error.get_or_insert(error);
            }
        }
    }
    if scans.is_empty() {
        let none = || ReadErrorKind::Refused("is a DICOMDIR that names no images".into());
        return Err(first_error.unwrap_or_else(none));
    }
    skipped.say(warnings);
    Ok(scans)
}
