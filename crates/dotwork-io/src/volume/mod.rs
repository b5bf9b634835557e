//! Volumes from files: NRRD, NIfTI, MetaImage, legacy VTK, TIFF stacks, DICOM series, and raw samples by option.
//!
//! [`read_volume`] decides by content what a file is, reads its header, and unpacks the samples straight into the
//! vector that the [`Volume`] keeps, in the type in which they are stored. Where a file declares an anatomical space,
//! the affine leads to the patient's (LPS; steps and origins of RAS files are turned); where it does not, the space is
//! unknown, and nothing is guessed without a warning. Of data with more than three axes the first volume is taken, of
//! colours the luminance, of vectors the first component, of complex numbers the magnitude: each is said.
//!
//! Nothing in a header is believed before it is checked: sizes are multiplied with care and compared with the bytes
//! that are there (or, for packed data, with what these can unpack to) before memory is taken.
//!
//! ```
//! use dotwork_drawing::Warnings;
//! use dotwork_io::volume::{VolumeOptions, read_volume_bytes};
//! use std::path::Path;
//!
//! let options = VolumeOptions { raw: Some("2x2x1:u16:be:0.5,0.5,2".parse()?), ..VolumeOptions::default() };
//! let bytes = [0, 1, 0, 2, 0, 3, 1, 0];
//! let mut no_other_files = dotwork_io::read_regular_file;
//! let mut warnings = Warnings::new();
//! let file =
//!     read_volume_bytes(Path::new("scan.raw"), &bytes, &options, &mut no_other_files, &mut warnings)?;
//! assert_eq!(file.volume.dims(), [2, 2, 1]);
//! assert_eq!(file.volume.affine().spacing(), [0.5, 0.5, 2.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(
    not(all(
        feature = "bzip2",
        feature = "nifti",
        feature = "metaimage",
        feature = "vtk",
        feature = "tiff",
        feature = "dicom"
    )),
    allow(dead_code, reason = "each reader uses its share")
)]

#[cfg(any(feature = "nrrd", feature = "metaimage", feature = "vtk"))]
mod ascii;
mod data;
#[cfg(feature = "dicom")]
mod dicom;
mod facts;
mod files;
mod fill;
mod format;
mod grid;
mod label_table;
#[cfg(feature = "metaimage")]
mod metaimage;
#[cfg(feature = "nifti")]
mod nifti;
#[cfg(feature = "nrrd")]
mod nrrd;
mod raw;
mod reduce;
#[cfg(feature = "tiff")]
mod stack;
mod stream;
#[cfg(feature = "tiff")]
mod tiff;
#[cfg(feature = "vtk")]
mod vtk;

use std::borrow::Cow;
use std::path::Path;

use dotwork_drawing::Warnings;
use dotwork_volume::{Affine, Samples, Scaling, Volume};

use crate::error::{ReadError, ReadErrorKind};
use crate::file::{read_bytes, read_regular_file};
use crate::gzip;
use crate::volume::facts::Facts;
use crate::volume::files::Files;

pub use format::{VolumeFormat, volume_format_of};
pub use label_table::{LabelEntry, LabelTable, label_table_from_bytes, read_label_table};
#[cfg(feature = "nrrd")]
pub use nrrd::write_nrrd;
pub use raw::{RawLayout, RawLayoutError};

/// A volume and what its file says beyond it.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeFile {
    /// The samples and where they lie.
    pub volume: Volume,
    /// The format in words: "NRRD, gzip, big endian".
    pub format: String,
    /// What a person wants to know of the file and [`Volume`] does not hold (content, space as declared, further
    /// axes, intent, description, data files, pages, …): names and short texts of one line, in file order.
    pub facts: Vec<(String, String)>,
    /// Names and colours of its values, if it is a segmentation that brings them (NRRD with Slicer's segments). Segments
    /// in several layers have become one volume, whose values these are.
    pub labels: Option<LabelTable>,
    /// XXH64 (seed 0) over the bytes of all files of the volume in reading order: for one file, [`crate::checksum`].
    pub checksum: u64,
}

/// How volumes are read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VolumeOptions {
    /// The file holds samples without a header, in this layout; its content is not asked what it is.
    pub raw: Option<RawLayout>,
    /// Which series of DICOM files is read: its UID, its number, or its description; of several that are called so,
    /// the largest. `None`: the one that makes the largest volume.
    pub series: Option<String>,
}

/// What a reader of one format hands over.
struct Found {
    dims: [usize; 3],
    samples: Samples,
    scaling: Scaling,
    affine: Affine,
    format: String,
    facts: Facts,
}

/// Reads a volume: NRRD (attached or detached), NIfTI-1 and -2 (`.nii`, `.nii.gz`, `.hdr` or `.img` of a pair),
/// MetaImage, legacy VTK structured points, TIFF (a file of pages, or a folder of one-page files in natural order), or
/// raw samples where `options` say so; DICOM (a file, a folder with folders in it, or a DICOMDIR), of several series
/// the largest. A single file of any of them may be gzipped as a whole. What was left out, assumed or converted is
/// said in `warnings`.
///
/// # Errors
/// [`ReadError`], with file, place and reason; for trouble in a data file that a header names, with both files.
pub fn read_volume(
    path: &Path,
    options: &VolumeOptions,
    warnings: &mut Warnings,
) -> Result<VolumeFile, ReadError> {
    let in_path = |kind| ReadError { path: path.to_path_buf(), kind };
    if path.is_dir() {
        return read_folder(path, options, warnings).map_err(in_path);
    }
    let bytes = read_bytes(path).map_err(in_path)?;
    read_volume_bytes(path, &bytes, options, &mut read_regular_file, warnings)
}

/// Reads a volume from the bytes of a file. `name` appears in messages, decides where the content does not, and is
/// where data files are looked for; `sibling` gives their bytes.
///
/// # Errors
/// As [`read_volume`].
pub fn read_volume_bytes<'a>(
    name: &'a Path,
    bytes: &[u8],
    options: &VolumeOptions,
    sibling: &'a mut (dyn FnMut(&Path) -> Result<Vec<u8>, ReadError> + 'a),
    warnings: &mut Warnings,
) -> Result<VolumeFile, ReadError> {
    let mut files = Files::new(name, sibling);
    read(&mut files, bytes, options, warnings)
        .and_then(|found| finish(found, files.checksum()))
        .map_err(|kind| ReadError { path: name.to_path_buf(), kind })
}

fn finish(found: Found, checksum: u64) -> Result<VolumeFile, ReadErrorKind> {
    let Found { dims, samples, scaling, affine, format, facts } = found;
    let volume =
        Volume::new(dims, samples, scaling, affine).map_err(|e| ReadErrorKind::Refused(e.to_string()))?;
    Ok(VolumeFile { volume, format, facts: facts.list, labels: facts.labels, checksum })
}

fn read(
    files: &mut Files,
    bytes: &[u8],
    options: &VolumeOptions,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    if bytes.is_empty() {
        return Err(ReadErrorKind::Empty);
    }
    if let Some(layout) = &options.raw {
        files.count(bytes);
        return raw::read(bytes, layout, warnings);
    }
    let format = volume_format_of(files.name, bytes);
    match format {
        // Gzipped by custom, and unpacked by its reader straight into the samples.
        #[cfg(feature = "nifti")]
        Some(VolumeFormat::Nifti) => nifti::read(files, bytes, warnings),
        #[cfg(feature = "nrrd")]
        Some(VolumeFormat::Nrrd) => {
            files.count(bytes);
            nrrd::read(files, &unpacked(bytes, warnings)?, warnings)
        }
        #[cfg(feature = "metaimage")]
        Some(VolumeFormat::MetaImage) => {
            files.count(bytes);
            metaimage::read(files, &unpacked(bytes, warnings)?, warnings)
        }
        #[cfg(feature = "vtk")]
        Some(VolumeFormat::Vtk) => {
            files.count(bytes);
            vtk::read(&unpacked(bytes, warnings)?, warnings)
        }
        #[cfg(feature = "tiff")]
        Some(VolumeFormat::Tiff) => {
            files.count(bytes);
            tiff::read(&unpacked(bytes, warnings)?, warnings)
        }
        #[cfg(feature = "dicom")]
        Some(VolumeFormat::Dicom) => {
            files.count(bytes);
            dicom::read(files, &unpacked(bytes, warnings)?, options.series.as_deref(), warnings)
        }
        Some(VolumeFormat::Raw) => Err(ReadErrorKind::Refused(format!(
            "has no header: say with --raw how its {} bytes lie, as in --raw 256x256x128:u16:le",
            bytes.len()
        ))),
        None => Err(unknown()),
        #[allow(unreachable_patterns, reason = "with all formats nothing is left")]
        Some(format) => Err(ReadErrorKind::Refused(format!(
            "is a volume of a kind ({format:?}) that this build of dotwork does not read"
        ))),
    }
}

/// The content of a file that may be gzipped as a whole.
fn unpacked<'a>(bytes: &'a [u8], warnings: &mut Warnings) -> Result<Cow<'a, [u8]>, ReadErrorKind> {
    if !gzip::is_gzip(bytes) {
        return Ok(Cow::Borrowed(bytes));
    }
    gzip::unpack(bytes, warnings, |_| Ok(())).map(Cow::Owned)
}

fn unknown() -> ReadErrorKind {
    ReadErrorKind::Refused(
        "is no volume that dotwork reads (NRRD, NIfTI, MetaImage, legacy VTK, TIFF, DICOM, raw by option)"
            .into(),
    )
}

fn read_folder(
    path: &Path,
    options: &VolumeOptions,
    warnings: &mut Warnings,
) -> Result<VolumeFile, ReadErrorKind> {
    let mut sibling = read_regular_file;
    let mut files = Files::new(path, &mut sibling);
    let found = read_files_of_folder(&mut files, options, warnings)?;
    finish(found, files.checksum())
}

#[cfg_attr(
    not(any(feature = "dicom", feature = "tiff")),
    allow(unused_variables, reason = "no reader of folders is in this build")
)]
fn read_files_of_folder(
    files: &mut Files,
    options: &VolumeOptions,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    #[cfg(feature = "dicom")]
    if holds_dicom_files(files.name) {
        return dicom::read_folder(files, options.series.as_deref(), warnings);
    }
    #[cfg(feature = "tiff")]
    return stack::read(files, warnings);
    #[cfg(not(feature = "tiff"))]
    Err(ReadErrorKind::Refused("is a directory that this build of dotwork does not read".into()))
}

#[cfg(feature = "dicom")]
fn holds_dicom_files(folder: &Path) -> bool {
    dicom::holds_dicom_files(folder)
}

#[cfg(not(feature = "dicom"))]
fn holds_dicom_files(_: &Path) -> bool {
    false
}

#[cfg(feature = "tiff")]
fn holds_tiff_files(folder: &Path) -> bool {
    stack::tiff_files(folder).is_ok_and(|files| !files.is_empty())
}

#[cfg(not(feature = "tiff"))]
fn holds_tiff_files(_: &Path) -> bool {
    false
}
