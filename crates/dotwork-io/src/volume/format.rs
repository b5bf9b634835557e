//! Which volume format a file has: by content first, by its name second.

use std::path::Path;

use crate::gzip::is_gzip;
use crate::volume::stream::{Packing, Stream};

/// A format of volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum VolumeFormat {
    /// NRRD, attached or detached.
    Nrrd,
    /// NIfTI-1 or NIfTI-2, in one file or two.
    Nifti,
    /// MetaImage.
    MetaImage,
    /// Legacy VTK structured points. XML image data (`.vti`) count as this too, and are refused by name.
    Vtk,
    /// A TIFF file of one or several pages, or a folder of such files.
    Tiff,
    /// DICOM: a file, a DICOMDIR, or a folder of files.
    Dicom,
    /// Samples without a header: read only by [`VolumeOptions::raw`](super::VolumeOptions::raw).
    Raw,
}

/// Unpacked bytes that tell a format.
const HEAD: usize = 1024;

/// The volume format of a file, given its path and its first bytes (1 KiB is enough, gzipped or not; fewer if the file
/// is shorter); `None` if it is no volume. The content decides; where it does not say, the name does (`.nrrd`,
/// `.nii.gz`, `.img`, `.raw`, …). A folder is [`VolumeFormat::Dicom`] if it or a folder in it holds DICOM files, otherwise
/// [`VolumeFormat::Tiff`] if it holds TIFF files.
pub fn volume_format_of(path: &Path, head: &[u8]) -> Option<VolumeFormat> {
    if head.is_empty() && path.is_dir() {
        if super::holds_dicom_files(path) {
            return Some(VolumeFormat::Dicom);
        }
        return super::holds_tiff_files(path).then_some(VolumeFormat::Tiff);
    }
    by_content(head).or_else(|| by_name(path, head))
}

/// What the content says, also inside gzip.
pub(crate) fn by_content(head: &[u8]) -> Option<VolumeFormat> {
    if !is_gzip(head) {
        return by_plain_content(head);
    }
    let mut start = [0; HEAD];
    let got = Stream::new(head, Packing::Gzip).read(&mut start).ok()?;
    by_plain_content(&start[..got])
}

fn by_plain_content(head: &[u8]) -> Option<VolumeFormat> {
    let nifti = |at: usize, version: u8| {
        head.get(at..at + 4)
            .is_some_and(|m| m[0] == b'n' && matches!(m[1], b'+' | b'i') && m[2..] == [version, 0])
    };
    // DICOM files may begin like TIFF, so that both kinds of program open them.
    if head.get(128..132) == Some(b"DICM") {
        Some(VolumeFormat::Dicom)
    } else if head.starts_with(b"NRRD0") {
        Some(VolumeFormat::Nrrd)
    } else if nifti(344, b'1') || nifti(4, b'2') {
        Some(VolumeFormat::Nifti)
    } else if head.starts_with(b"# vtk DataFile") || is_vtk_xml_image(head) {
        Some(VolumeFormat::Vtk)
    } else if matches!(head, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..]) {
        Some(VolumeFormat::Tiff)
    } else if is_metaimage(head) {
        Some(VolumeFormat::MetaImage)
    } else {
        None
    }
}

/// True for the beginning of an XML file of VTK that holds image data.
pub(crate) fn is_vtk_xml_image(head: &[u8]) -> bool {
    let head = &head[..head.len().min(HEAD)];
    let holds = |text: &[u8]| head.windows(text.len()).any(|w| w == text);
    matches!(head.trim_ascii_start(), [b'<', ..]) && holds(b"<VTKFile") && holds(b"ImageData")
}

/// The first statement of a MetaImage is one of these.
fn is_metaimage(head: &[u8]) -> bool {
    const KEYS: [&[u8]; 9] = [
        b"objecttype",
        b"objectsubtype",
        b"ndims",
        b"comment",
        b"binarydata",
        b"name",
        b"id",
        b"transformtype",
        b"dimsize",
    ];
    let line = head.trim_ascii_start().split(|&b| b == b'\n').next().unwrap_or_default();
    let Some(equals) = line.iter().position(|&b| b == b'=') else { return false };
    let key = line[..equals].trim_ascii().to_ascii_lowercase();
    KEYS.contains(&key.as_slice())
        && (key != b"objecttype" || line[equals + 1..].trim_ascii().eq_ignore_ascii_case(b"image"))
        && (matches!(key.as_slice(), b"ndims" | b"objecttype" | b"dimsize")
            || head.windows(5).any(|w| w.eq_ignore_ascii_case(b"ndims")))
}

fn by_name(path: &Path, head: &[u8]) -> Option<VolumeFormat> {
    Some(match extension(path).as_str() {
        "nrrd" | "nhdr" => VolumeFormat::Nrrd,
        "nii" | "img" => VolumeFormat::Nifti,
        // Other programs use the name as well.
        "hdr" if !head.starts_with(b"#?") && !head.starts_with(b"ENVI") => VolumeFormat::Nifti,
        "mha" | "mhd" => VolumeFormat::MetaImage,
        "vti" => VolumeFormat::Vtk,
        "tif" | "tiff" => VolumeFormat::Tiff,
        "dcm" | "dicom" | "ima" => VolumeFormat::Dicom,
        "raw" => VolumeFormat::Raw,
        _ => return None,
    })
}

/// The extension in lower case; of `x.nii.gz`, `nii`.
pub(crate) fn extension(path: &Path) -> String {
    let of = |p: &Path| p.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match of(path).as_str() {
        "gz" => of(Path::new(path.file_stem().unwrap_or_default())),
        other => other.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_decides_then_the_name() {
        for (name, head, expected) in [
            ("x.raw", &b"NRRD0004\ntype: short\n"[..], Some(VolumeFormat::Nrrd)),
            ("x", b"NDims = 3\nDimSize = 1 2 3\n", Some(VolumeFormat::MetaImage)),
            ("x", b"ObjectType = Image\nNDims = 3\n", Some(VolumeFormat::MetaImage)),
            ("x", b"ObjectType = Scene\nNDims = 3\n", None),
            ("x.toml", b"name = \"x\"\n", None),
            ("x", b"Comment = hand made\nNDims = 2\n", Some(VolumeFormat::MetaImage)),
            ("x", b"# vtk DataFile Version 3.0\n", Some(VolumeFormat::Vtk)),
            ("x", b"<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\">", Some(VolumeFormat::Vtk)),
            ("x.vtp", b"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">", None),
            ("x.ply", b"ply\nformat ascii 1.0\n", None),
            ("x", b"MM\0\x2b\0\x08\0\0", Some(VolumeFormat::Tiff)),
            ("x.IMG.gz", b"\x1f\x8b\x08", Some(VolumeFormat::Nifti)),
            ("x.hdr", b"#?RADIANCE\n", None),
            ("scan.raw", b"\0\0\0\0", Some(VolumeFormat::Raw)),
            ("x.obj", b"v 1 2 3\n", None),
        ] {
            assert_eq!(volume_format_of(Path::new(name), head), expected, "{name} {head:?}");
        }
    }
}
