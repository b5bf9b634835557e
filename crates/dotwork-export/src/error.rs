//! Why a file could not be written: one line, the path first.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why an output was not written. `Display` is one line, `PATH: reason`.
#[derive(Debug, Error)]
pub enum ExportError {
    /// The target is a folder, or is written like one (`drawing/`).
    #[error("{}: is a folder, not a file", one_line(path))]
    IsFolder {
        /// The target.
        path: PathBuf,
    },
    /// The folder of the target does not exist.
    #[error("{}: the folder {} does not exist", one_line(path), one_line(folder))]
    NoFolder {
        /// The target.
        path: PathBuf,
        /// Its missing folder.
        folder: PathBuf,
    },
    /// The operating system refused, or the encoder did.
    #[error("{}: {}", one_line(path), reason(source))]
    Io {
        /// The target.
        path: PathBuf,
        /// What was refused; its kind tells a closed pipe from a full disk.
        source: io::Error,
    },
}

impl ExportError {
    /// The file that was to be written.
    pub fn path(&self) -> &Path {
        match self {
            ExportError::IsFolder { path }
            | ExportError::NoFolder { path, .. }
            | ExportError::Io { path, .. } => path,
        }
    }

    /// The kind of refusal: [`io::ErrorKind::BrokenPipe`] is no error for a program that writes to standard output.
    pub fn kind(&self) -> io::ErrorKind {
        match self {
            ExportError::IsFolder { .. } => io::ErrorKind::IsADirectory,
            ExportError::NoFolder { .. } => io::ErrorKind::NotFound,
            ExportError::Io { source, .. } => source.kind(),
        }
    }
}

/// A path on one line: file names may hold line breaks.
fn one_line(path: &Path) -> String {
    escape_breaks(&path.display().to_string())
}

/// What the operating system says, without its error number.
fn reason(source: &io::Error) -> String {
    match source.kind() {
        io::ErrorKind::PermissionDenied => "no permission to write here".into(),
        io::ErrorKind::ReadOnlyFilesystem => "the file system is read-only".into(),
        io::ErrorKind::StorageFull => "the disk is full".into(),
        io::ErrorKind::QuotaExceeded => "the disk quota is used up".into(),
        io::ErrorKind::FileTooLarge => "the file is larger than the system or its limits allow".into(),
        _ => {
            let text = source.to_string();
            let text = match text.rfind(" (os error ") {
                Some(end) if source.raw_os_error().is_some() => &text[..end],
                _ => &text,
            };
            escape_breaks(text)
        }
    }
}

fn escape_breaks(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() { line.extend(c.escape_default()) } else { line.push(c) }
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_error_is_one_line_that_begins_with_the_path() {
        let path = PathBuf::from("a\nb.png");
        let other = || io::Error::other("two\r\nlines");
        let errors = [
            (ExportError::IsFolder { path: path.clone() }, "a\\nb.png: is a folder, not a file"),
            (
                ExportError::NoFolder { path: path.clone(), folder: "x\ty".into() },
                "a\\nb.png: the folder x\\ty does not exist",
            ),
            (ExportError::Io { path: path.clone(), source: other() }, "a\\nb.png: two\\r\\nlines"),
        ];
        for (error, line) in errors {
            assert_eq!(error.to_string(), line);
            assert_eq!(error.path(), path);
        }
    }

    #[cfg(unix)]
    #[test]
    fn error_numbers_of_the_system_are_left_out() {
        let source = io::Error::from_raw_os_error(32); // EPIPE
        let error = ExportError::Io { path: "out.csv".into(), source };
        assert_eq!(error.to_string(), "out.csv: Broken pipe");
        assert_eq!(error.kind(), io::ErrorKind::BrokenPipe);
    }
}
