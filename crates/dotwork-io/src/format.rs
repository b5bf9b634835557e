//! Which format a file has: by content first, by its name second.

use std::path::Path;

use crate::error::{ReadErrorKind, quote};

/// A mesh format that dotwork reads and writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MeshFormat {
    /// Polygon File Format (Stanford).
    Ply,
    /// Wavefront OBJ.
    Obj,
}

/// The mesh format that a file to be written has by its name (`.ply`, `.obj`, upper case too); `None` for any other.
pub fn mesh_format_of(path: &Path) -> Option<MeshFormat> {
    match extension(path)?.as_str() {
        "ply" => Some(MeshFormat::Ply),
        "obj" => Some(MeshFormat::Obj),
        _ => None,
    }
}

fn extension(path: &Path) -> Option<String> {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase())
}

/// The extension that a `.gz` may hide.
fn meant_extension(path: &Path) -> Option<String> {
    match extension(path)?.as_str() {
        "gz" => extension(Path::new(path.file_stem()?)),
        other => Some(other.into()),
    }
}

/// What the first bytes of a file tell.
pub(crate) enum Sniffed {
    Mesh(MeshFormat),
    Other(ReadErrorKind),
    /// Only comments or nothing so far.
    Undecided,
}

/// Looks at the beginning of a file's (unpacked) content; `whole` if it is all there is.
pub(crate) fn sniff(name: &Path, bytes: &[u8], whole: bool) -> Sniffed {
    if matches!(bytes, [b'p', b'l', b'y', b'\n' | b'\r' | b' ' | b'\t', ..]) {
        return Sniffed::Mesh(MeshFormat::Ply);
    }
    if bytes.starts_with(&crate::dots::MAGIC) {
        return Sniffed::Other(ReadErrorKind::Dots);
    }
    if let Some(format) = foreign_content(bytes, whole) {
        return Sniffed::Other(ReadErrorKind::NotReadYet(format));
    }
    match looks_like_obj(bytes) {
        Some(true) => Sniffed::Mesh(MeshFormat::Obj),
        None if !whole || meant_extension(name).as_deref() == Some("obj") => Sniffed::Undecided,
        _ => Sniffed::Other(by_name(name, bytes)),
    }
}

/// The first statement decides. Some exporters begin with a private one: then a vertex among the first lines does.
/// `None` if there are only comments and blank lines.
fn looks_like_obj(bytes: &[u8]) -> Option<bool> {
    const WINDOW: usize = 64 * 1024;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut statements = bytes
        .split(|&b| b == b'\n' || b == b'\r')
        .map(<[u8]>::trim_ascii)
        .filter(|line| !line.is_empty() && line[0] != b'#');
    let first = statements.next()?;
    let keyword = first.split(u8::is_ascii_whitespace).next().unwrap_or(first);
    const KEYWORDS: [&[u8]; 13] =
        [b"v", b"vt", b"vn", b"vp", b"f", b"o", b"g", b"s", b"l", b"p", b"mtllib", b"usemtl", b"cstype"];
    if KEYWORDS.contains(&keyword) {
        return Some(true);
    }
    let near = &bytes[..bytes.len().min(WINDOW)];
    Some(near.split(|&b| b == b'\n').any(|line| line.starts_with(b"v ")))
}

/// Formats that announce themselves.
fn foreign_content(bytes: &[u8], whole: bool) -> Option<&'static str> {
    const MAGICS: [(&[u8], &str); 24] = [
        (b"glTF", "a glTF binary (GLB)"),
        (b"NRRD000", "an NRRD volume"),
        (b"OFF\n", OFF),
        (b"OFF\r", OFF),
        (b"OFF ", OFF),
        (b"COFF", OFF),
        (b"NOFF", OFF),
        (b"CNOFF", OFF),
        (b"STOFF", OFF),
        (b"4OFF", OFF),
        (b"# vtk DataFile", "a VTK file"),
        (b"<VTKFile", "a VTK file"),
        (b"ObjectType =", "a MetaImage volume"),
        (b"II*\0", "a TIFF image"),
        (b"MM\0*", "a TIFF image"),
        (b"\x89PNG", "a PNG image"),
        (b"Kaydara FBX Binary", "an FBX file"),
        (b"BLENDER", "a Blender file"),
        (b"PK\x03\x04", "a ZIP archive (or 3MF)"),
        (b"BZh", "a bzip2 archive"),
        (b"\xfd7zXZ\0", "an xz archive"),
        (b"\x28\xb5\x2f\xfd", "a Zstandard archive"),
        (b"\x1f\x8b", "gzip within gzip"),
        (b"solid ", STL),
    ];
    if let Some((_, format)) = MAGICS.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Some(format);
    }
    if bytes.get(128..132) == Some(b"DICM") {
        return Some("a DICOM file");
    }
    let nifti = |at: usize| matches!(bytes.get(at..at + 3), Some(b"n+1" | b"ni1" | b"n+2" | b"ni2"));
    if nifti(344) || nifti(4) {
        return Some(NIFTI);
    }
    // Binary STL has no magic: its triangle count must explain the length exactly.
    let count = bytes.get(80..84).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    if whole && count.is_some_and(|n| u64::from(n) * 50 + 84 == bytes.len() as u64) {
        return Some(STL);
    }
    None
}

const OFF: &str = "an OFF file";
const STL: &str = "an STL file";
const NIFTI: &str = "a NIfTI volume";

/// The refusal of content that nobody recognised: the name may still say what it is meant to be.
fn by_name(name: &Path, bytes: &[u8]) -> ReadErrorKind {
    let format = match meant_extension(name).as_deref().unwrap_or_default() {
        "stl" => STL,
        "off" => OFF,
        "gltf" => "a glTF file",
        "glb" => "a glTF binary (GLB)",
        "fbx" => "an FBX file",
        "dae" => "a COLLADA file",
        "3mf" => "a 3MF file",
        "vtk" | "vti" | "vtp" | "vtu" => "a VTK file",
        "nrrd" | "nhdr" => "an NRRD volume",
        "nii" | "hdr" | "img" => NIFTI,
        "mhd" | "mha" => "a MetaImage volume",
        "dcm" => "a DICOM file",
        "tif" | "tiff" => "a TIFF image",
        "raw" => "a raw volume",
        "vm" => "an implicit model",
        "toml" => "a scene file",
        _ => {
            let start = &bytes[..bytes.len().min(8)];
            let text = start.iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace());
            let seen = if text {
                let line = bytes.trim_ascii_start();
                let end = line.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(line.len());
                quote(&line[..end])
            } else {
                let bytes: Vec<String> = start.iter().map(|b| format!("{b:02x}")).collect();
                format!("bytes {}", bytes.join(" "))
            };
            return ReadErrorKind::Unknown(format!("begins with {seen}"));
        }
    };
    ReadErrorKind::NotReadYet(format)
}
