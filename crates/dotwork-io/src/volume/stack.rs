//! A folder of TIFF files of one page each, as the slices of a volume in the natural order of their names.

use std::cmp::Ordering;
use std::io;
use std::path::{Path, PathBuf};

use dotwork_drawing::Warnings;
use dotwork_volume::Scaling;

use crate::error::ReadErrorKind;
use crate::volume::Found;
use crate::volume::data::byte_count;
use crate::volume::facts::Facts;
use crate::volume::files::{Files, in_file};
use crate::volume::fill::Fill;
use crate::volume::tiff::Pages;

/// The TIFF files of a folder by name, in natural order; hidden files are left out.
pub(super) fn tiff_files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let lower = name.to_ascii_lowercase();
        if !name.starts_with('.') && (lower.ends_with(".tif") || lower.ends_with(".tiff")) && path.is_file() {
            files.push(path);
        }
    }
    files.sort_by(|a, b| {
        let name = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
        natural(&name(a), &name(b)).then_with(|| a.cmp(b))
    });
    Ok(files)
}

/// Compares names with the numbers in them as numbers: "slice2" comes before "slice10".
fn natural(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a.as_bytes(), b.as_bytes());
    loop {
        let digits = |s: &[u8]| s.iter().take_while(|c| c.is_ascii_digit()).count();
        let (n, m) = (digits(a), digits(b));
        if n > 0 && m > 0 {
            let (x, y) = (strip_zeros(&a[..n]), strip_zeros(&b[..m]));
            let order = x.len().cmp(&y.len()).then_with(|| x.cmp(y));
            if order != Ordering::Equal {
                return order;
            }
            (a, b) = (&a[n..], &b[m..]);
            continue;
        }
        match (a, b) {
            ([], _) | (_, []) => return a.len().cmp(&b.len()),
            ([x, rest_a @ ..], [y, rest_b @ ..]) => {
                let order = x.to_ascii_lowercase().cmp(&y.to_ascii_lowercase());
                if order != Ordering::Equal {
                    return order;
                }
                (a, b) = (rest_a, rest_b);
            }
        }
    }
}

fn strip_zeros(digits: &[u8]) -> &[u8] {
    let zeros = digits.iter().take_while(|&&d| d == b'0').count();
    &digits[zeros..]
}

/// Reads the TIFF files of the folder that `files` names.
pub(super) fn read(files: &mut Files, warnings: &mut Warnings) -> Result<Found, ReadErrorKind> {
    let paths = tiff_files(files.name).map_err(ReadErrorKind::Io)?;
    let Some(first_path) = paths.first() else {
        return Err(ReadErrorKind::Refused("is a directory without TIFF files".into()));
    };
    let mut facts = Facts::default();
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let last = paths.last().unwrap_or(first_path);
    facts.add("data files", format!("{}: {} to {}", paths.len(), name(first_path), name(last)));

    let mut state = None;
    let mut scratch = Vec::new();
    for path in &paths {
        let bytes = files.open(path)?;
        let pages = in_file(path, one_page(&bytes, warnings))?;
        let (kind, fill, ..) = match &mut state {
            Some(state) => state,
            None => {
                let sides = [pages.kind.width as u64, pages.kind.height as u64, paths.len() as u64];
                let fill = Fill::new(pages.kind.sample, byte_count(&sides, 1)?)?;
                pages.describe(&mut facts, warnings);
                let affine = pages.affine(&mut facts, warnings);
                state.insert((pages.kind, fill, affine, pages.format()))
            }
        };
        if pages.kind != *kind {
            return Err(ReadErrorKind::DataFile {
                file: path.clone(),
                kind: Box::new(ReadErrorKind::Refused(format!(
                    "is {}, but {} is {kind}",
                    pages.kind,
                    name(first_path)
                ))),
            });
        }
        in_file(path, pages.decode(0, fill, &mut scratch))?;
    }
    let Some((kind, fill, affine, format)) = state else {
        return Err(ReadErrorKind::Refused("is a directory without TIFF files".into()));
    };
    Ok(Found {
        dims: [kind.width, kind.height, paths.len()],
        samples: fill.finish(cfg!(target_endian = "big")),
        scaling: Scaling::default(),
        affine,
        format: format!("folder of {format}"),
        facts,
    })
}

fn one_page<'a>(bytes: &'a [u8], warnings: &mut Warnings) -> Result<Pages<'a>, ReadErrorKind> {
    let pages = Pages::of(bytes, warnings)?;
    let slices = pages.slices();
    if slices != 1 {
        return Err(ReadErrorKind::Refused(format!(
            "holds {slices} pages; of a folder, each file is one slice"
        )));
    }
    Ok(pages)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count_as_numbers() {
        let mut names = ["s10.tif", "S2.tif", "s1.tif", "s02b.tif", "a", "s2a.tif", "s.tif", "s00010.tif"];
        names.sort_by(|a, b| natural(a, b).then_with(|| a.cmp(b)));
        assert_eq!(names, ["a", "s.tif", "s1.tif", "S2.tif", "s2a.tif", "s02b.tif", "s00010.tif", "s10.tif"]);
        assert_eq!(natural("99999999999999999999999", "100000000000000000000000"), Ordering::Less);
    }
}
