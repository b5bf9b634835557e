//! Which format a file has: by content first, by its name second.

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;

use crate::error::{ReadErrorKind, quote};
use crate::gzip;

/// A mesh format that dotwork knows. All are read (each behind the feature of its name), PLY and OBJ are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MeshFormat {
    /// Polygon File Format (Stanford).
    Ply,
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography, text or binary.
    Stl,
    /// Object File Format (Geomview) and its variants COFF, NOFF, STOFF.
    Off,
    /// glTF 2.0, the text form.
    Gltf,
    /// glTF 2.0, the binary container.
    Glb,
}

/// The formats that this build reads, as messages name them.
const READ: &[&str] = &[
    #[cfg(feature = "ply")]
    "PLY",
    #[cfg(feature = "obj")]
    "OBJ",
    #[cfg(feature = "stl")]
    "STL",
    #[cfg(feature = "off")]
    "OFF",
    #[cfg(feature = "gltf")]
    "glTF",
];

/// The mesh formats that this build reads, as a list for messages: "PLY, OBJ, STL, OFF and glTF".
pub fn mesh_formats() -> String {
    match READ {
        [] => "no mesh formats".into(),
        [only] => (*only).into(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// The mesh format that a file to be written has by its name (`.ply`, `.obj`, upper case too); `None` for any other.
pub fn mesh_format_of(path: &Path) -> Option<MeshFormat> {
    match extension(path)?.as_str() {
        "ply" => Some(MeshFormat::Ply),
        "obj" => Some(MeshFormat::Obj),
        _ => None,
    }
}

/// The format of a mesh file in words, such as "PLY, binary big endian", "STL, text", "COFF", "glTF binary (GLB)" or
/// "OBJ, gzipped"; `None` if `bytes`, the file's content, are no mesh that dotwork knows.
pub fn mesh_format_name(path: &Path, bytes: &[u8]) -> Option<String> {
    if !gzip::is_gzip(bytes) {
        return name_of(path, bytes, true);
    }
    let mut start = Vec::new();
    // What unpacks before the damage, if there is any, is enough to tell.
    let _ = flate2::read::MultiGzDecoder::new(bytes).take(gzip::PREFIX as u64).read_to_end(&mut start);
    let name = name_of(path, &start, start.len() < gzip::PREFIX)?;
    Some(format!("{name}, gzipped"))
}

fn name_of(path: &Path, bytes: &[u8], whole: bool) -> Option<String> {
    let format = match sniff(path, bytes, whole) {
        Sniffed::Mesh(format) => format,
        Sniffed::Undecided => match meant_extension(path)?.as_str() {
            "obj" => MeshFormat::Obj,
            "stl" => MeshFormat::Stl,
            "gltf" => MeshFormat::Gltf,
            _ => return None,
        },
        Sniffed::Other(_) => return None,
    };
    Some(match format {
        MeshFormat::Ply => ply_name(bytes).into(),
        MeshFormat::Obj => "OBJ".into(),
        MeshFormat::Stl if is_text_stl(bytes, whole) => "STL, text".into(),
        MeshFormat::Stl => "STL, binary".into(),
        MeshFormat::Off => {
            let keyword = off_keyword(bytes).map(|k| String::from_utf8_lossy(k).to_uppercase());
            keyword.unwrap_or_else(|| "OFF".into())
        }
        MeshFormat::Gltf => "glTF".into(),
        MeshFormat::Glb => "glTF binary (GLB)".into(),
    })
}

fn ply_name(bytes: &[u8]) -> &'static str {
    let near = &bytes[..bytes.len().min(4096)];
    let mut lines = near.split(|&b| b == b'\n' || b == b'\r').map(<[u8]>::trim_ascii);
    match lines.find_map(|l| l.strip_prefix(b"format ")).map(<[u8]>::trim_ascii) {
        Some(f) if f.starts_with(b"ascii") => "PLY, text",
        Some(f) if f.starts_with(b"binary_little_endian") => "PLY, binary little endian",
        Some(f) if f.starts_with(b"binary_big_endian") => "PLY, binary big endian",
        _ => "PLY",
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
    /// Only comments or nothing so far, or something that only the rest can explain.
    Undecided,
}

/// Looks at the beginning of a file's (unpacked) content; `whole` if it is all there is.
pub(crate) fn sniff(name: &Path, bytes: &[u8], whole: bool) -> Sniffed {
    let meant = meant_extension(name).unwrap_or_default();
    if matches!(bytes, [b'p', b'l', b'y', b'\n' | b'\r' | b' ' | b'\t', ..]) {
        return Sniffed::Mesh(MeshFormat::Ply);
    }
    if bytes.starts_with(b"glTF") {
        return Sniffed::Mesh(MeshFormat::Glb);
    }
    if bytes.starts_with(&crate::dots::MAGIC) {
        return Sniffed::Other(ReadErrorKind::Dots);
    }
    if let Some(error) = foreign_content(bytes) {
        return Sniffed::Other(error);
    }
    if is_binary_stl(bytes, whole) || is_text_stl(bytes, whole) {
        return Sniffed::Mesh(MeshFormat::Stl);
    }
    if off_keyword(bytes).is_some() {
        return Sniffed::Mesh(MeshFormat::Off);
    }
    if let Some(found) = json(bytes, &meant, whole) {
        return found;
    }
    match looks_like_obj(bytes) {
        Some(true) => Sniffed::Mesh(MeshFormat::Obj),
        None if !whole || meant == "obj" => Sniffed::Undecided,
        None => Sniffed::Other(by_name(&meant, bytes)),
        Some(false) => match meant.as_str() {
            // No keyword: the counts come first.
            "off" if first_statement(bytes).is_some_and(|s| s[0].is_ascii_digit()) => {
                Sniffed::Mesh(MeshFormat::Off)
            }
            // A binary file of another length than it declares.
            "stl" if bytes.len() >= 84 && bytes[..bytes.len().min(512)].contains(&0) => {
                Sniffed::Mesh(MeshFormat::Stl)
            }
            _ if !whole && stl_length(bytes).is_some_and(|n| n >= bytes.len() as u64 && n < 1 << 33) => {
                Sniffed::Undecided
            }
            _ => Sniffed::Other(by_name(&meant, bytes)),
        },
    }
}

/// The first line that holds more than a comment.
fn first_statement(bytes: &[u8]) -> Option<&[u8]> {
    statements(bytes).next()
}

fn statements(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes
        .split(|&b| b == b'\n' || b == b'\r')
        .map(<[u8]>::trim_ascii)
        .filter(|line| !line.is_empty() && line[0] != b'#')
}

fn first_word(line: &[u8]) -> &[u8] {
    line.split(u8::is_ascii_whitespace).next().unwrap_or(line)
}

/// How much of a file is searched for signs.
const WINDOW: usize = 64 * 1024;

/// The first statement decides. Some exporters begin with a private one: then a vertex among the first lines does.
/// `None` if there are only comments and blank lines.
fn looks_like_obj(bytes: &[u8]) -> Option<bool> {
    let keyword = first_word(first_statement(bytes)?);
    const KEYWORDS: [&[u8]; 13] =
        [b"v", b"vt", b"vn", b"vp", b"f", b"o", b"g", b"s", b"l", b"p", b"mtllib", b"usemtl", b"cstype"];
    if KEYWORDS.contains(&keyword) {
        return Some(true);
    }
    let near = &bytes[..bytes.len().min(WINDOW)];
    Some(near.split(|&b| b == b'\n').any(|line| line.starts_with(b"v ")))
}

/// The keyword of an OFF file: `OFF` behind letters that say what a vertex holds.
pub(crate) fn off_keyword(bytes: &[u8]) -> Option<&[u8]> {
    let word = first_word(first_statement(bytes)?);
    let letters = word.strip_suffix(b"OFF").or_else(|| word.strip_suffix(b"off"))?;
    let known = |letters: &[u8]| letters.iter().all(|b| b"STCN4nc".contains(b));
    (letters.len() <= 6 && known(letters)).then_some(word)
}

/// The length that a binary STL file has by its triangle count: header, count, 50 bytes each.
pub(crate) fn stl_length(bytes: &[u8]) -> Option<u64> {
    let count = u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?);
    Some(u64::from(count) * 50 + 84)
}

/// Binary STL has no magic: its triangle count must explain the length exactly. It may begin with `solid` all the same.
fn is_binary_stl(bytes: &[u8], whole: bool) -> bool {
    whole && stl_length(bytes) == Some(bytes.len() as u64)
}

/// Text STL begins with `solid`; so do binary files, but those hold zeros among their first bytes.
pub(crate) fn is_text_stl(bytes: &[u8], whole: bool) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let solid = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let ends = text.get(5).is_none_or(u8::is_ascii_whitespace);
    solid && ends && !is_binary_stl(bytes, whole) && !bytes[..bytes.len().min(512)].contains(&0)
}

/// JSON is glTF if its name or its members say so.
fn json(bytes: &[u8], meant: &str, whole: bool) -> Option<Sniffed> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if text.first() != Some(&b'{') {
        return None;
    }
    if meant == "gltf" || text.windows(7).any(|w| w == b"\"asset\"") {
        return Some(Sniffed::Mesh(MeshFormat::Gltf));
    }
    // The member may come late, behind embedded buffers.
    (!whole).then_some(Sniffed::Undecided)
}

/// Formats that announce themselves and are no meshes for us.
fn foreign_content(bytes: &[u8]) -> Option<ReadErrorKind> {
    const VOLUMES: [(&[u8], &str); 5] = [
        (b"NRRD000", "an NRRD volume"),
        (b"ObjectType =", "a MetaImage volume"),
        (b"II*\0", TIFF),
        (b"MM\0*", TIFF),
        (b"\x89PNG", "a PNG image"),
    ];
    const OTHERS: [(&[u8], &str); 8] = [
        (b"<VTKFile", VTK),
        (b"Kaydara FBX Binary", "an FBX file"),
        (b"BLENDER", "a Blender file"),
        (b"PK\x03\x04", "a ZIP archive (or 3MF)"),
        (b"BZh", "a bzip2 archive"),
        (b"\xfd7zXZ\0", "an xz archive"),
        (b"\x28\xb5\x2f\xfd", "a Zstandard archive"),
        (b"\x1f\x8b", "gzip within gzip"),
    ];
    // Before TIFF: a DICOM file may begin like one, so that both kinds of program open it.
    if bytes.get(128..132) == Some(b"DICM") {
        return Some(ReadErrorKind::Volume(DICOM));
    }
    let starts = |&&(magic, _): &&(&[u8], _)| bytes.starts_with(magic);
    if let Some((_, volume)) = VOLUMES.iter().find(starts) {
        return Some(ReadErrorKind::Volume(volume));
    }
    if let Some((_, format)) = OTHERS.iter().find(starts) {
        return Some(ReadErrorKind::NotReadYet(format));
    }
    if bytes.starts_with(b"# vtk DataFile") {
        let near = &bytes[..bytes.len().min(1024)];
        let points = near.windows(17).any(|w| w == b"STRUCTURED_POINTS");
        return Some(if points {
            ReadErrorKind::Volume("a VTK volume")
        } else {
            ReadErrorKind::NotReadYet(VTK)
        });
    }
    let nifti = |at: usize| matches!(bytes.get(at..at + 3), Some(b"n+1" | b"ni1" | b"n+2" | b"ni2"));
    (nifti(344) || nifti(4)).then_some(ReadErrorKind::Volume(NIFTI))
}

const NIFTI: &str = "a NIfTI volume";
const DICOM: &str = "a DICOM file";
const TIFF: &str = "a TIFF image";
const VTK: &str = "a VTK file";

/// The refusal of content that nobody recognised: the name may still say what it is meant to be.
fn by_name(meant: &str, bytes: &[u8]) -> ReadErrorKind {
    match meant {
        "nrrd" | "nhdr" => ReadErrorKind::Volume("an NRRD volume"),
        "nii" | "hdr" | "img" => ReadErrorKind::Volume(NIFTI),
        "mhd" | "mha" => ReadErrorKind::Volume("a MetaImage volume"),
        "dcm" => ReadErrorKind::Volume(DICOM),
        "tif" | "tiff" => ReadErrorKind::Volume(TIFF),
        "raw" => ReadErrorKind::Volume("a raw volume"),
        "fbx" => ReadErrorKind::NotReadYet("an FBX file"),
        "dae" => ReadErrorKind::NotReadYet("a COLLADA file"),
        "3mf" => ReadErrorKind::NotReadYet("a 3MF file"),
        "vtk" | "vti" | "vtp" | "vtu" => ReadErrorKind::NotReadYet(VTK),
        "vm" => ReadErrorKind::NotReadYet("an implicit model"),
        "toml" => ReadErrorKind::NotReadYet("a scene file"),
        _ => ReadErrorKind::Unknown(format!("begins with {}", beginning(bytes))),
    }
}

/// The first line of a text, or the first bytes of anything else.
fn beginning(bytes: &[u8]) -> Cow<'static, str> {
    let start = &bytes[..bytes.len().min(8)];
    if start.iter().all(|b| b.is_ascii_graphic() || b.is_ascii_whitespace()) {
        let line = bytes.trim_ascii_start();
        let end = line.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(line.len());
        return quote(&line[..end]).into();
    }
    let bytes: Vec<String> = start.iter().map(|b| format!("{b:02x}")).collect();
    format!("bytes {}", bytes.join(" ")).into()
}
