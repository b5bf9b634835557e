//! From a path to a mesh.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use dotwork_drawing::Warnings;
use dotwork_mesh::{Motion, RawMesh};

use crate::checksum::Checksum;
use crate::error::{ReadError, ReadErrorKind};
use crate::format::{MeshFormat, Sniffed, sniff};
use crate::gzip;

/// What is read at most from pipes and devices, which do not say how much they hold.
const STREAM_LIMIT: u64 = 1 << 30;

/// Reads a whole file into memory.
///
/// # Errors
/// A missing file, a directory, an empty file, or what the system says; a pipe or device that gives over 1 GiB.
pub fn read_file(path: &Path) -> Result<Vec<u8>, ReadError> {
    read_bytes(path).map_err(|kind| ReadError { path: path.to_path_buf(), kind })
}

/// Reads a file that another one names, as [`read_file`]. It must be a regular file: a pipe or device would block or
/// never end.
///
/// # Errors
/// As [`read_file`]; a pipe or device.
pub fn read_regular_file(path: &Path) -> Result<Vec<u8>, ReadError> {
    match std::fs::metadata(path) {
        Ok(found) if !found.is_file() && !found.is_dir() => {
            let kind = ReadErrorKind::Io(io::Error::other("is no regular file"));
            Err(ReadError { path: path.to_path_buf(), kind })
        }
        _ => read_file(path),
    }
}

pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadErrorKind> {
    let from_io = |e: io::Error| match e.kind() {
        io::ErrorKind::NotFound => ReadErrorKind::Missing,
        io::ErrorKind::IsADirectory => ReadErrorKind::Directory,
        _ => ReadErrorKind::Io(e),
    };
    let metadata = std::fs::metadata(path).map_err(from_io)?;
    if metadata.is_dir() {
        return Err(ReadErrorKind::Directory);
    }
    let bytes = if metadata.is_file() {
        std::fs::read(path).map_err(from_io)?
    } else {
        let mut bytes = Vec::new();
        let file = File::open(path).map_err(from_io)?;
        file.take(STREAM_LIMIT + 1).read_to_end(&mut bytes).map_err(from_io)?;
        if bytes.len() as u64 > STREAM_LIMIT {
            return Err(ReadErrorKind::TooLarge("is no regular file and gives more than 1 GiB".into()));
        }
        bytes
    };
    if bytes.is_empty() {
        return Err(ReadErrorKind::Empty);
    }
    Ok(bytes)
}

/// Reads a mesh: PLY, OBJ, STL, OFF or glTF (each if its feature is on), gzipped or not.
///
/// Polygons are cut into fans; coordinates far from zero are brought near it by [`RawMesh::origin`]; colours of
/// vertices are kept; normals, texture coordinates, groups and materials are not. A glTF scene becomes one mesh in its
/// rest pose, in the space of the scene. What was dropped on the way is said in `warnings`.
///
/// # Errors
/// [`ReadError`], with file, place and reason.
pub fn read_mesh(path: &Path, warnings: &mut Warnings) -> Result<RawMesh, ReadError> {
    let bytes = read_file(path)?;
    read_mesh_bytes(path, &bytes, warnings)
}

/// Reads a mesh from the bytes of a file; `name` appears in messages, and decides where the content does not. The
/// buffers of a glTF file that lie in files of their own are looked for in the folder of `name`.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_bytes(name: &Path, bytes: &[u8], warnings: &mut Warnings) -> Result<RawMesh, ReadError> {
    read_mesh_checked(name, bytes, warnings).map(|(mesh, _)| mesh)
}

/// As [`read_mesh_bytes`], with the checksum of all the files that the mesh is made from: [`checksum`](crate::checksum)
/// of `bytes` alone, unless it is glTF with buffers in files of their own.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_checked(
    name: &Path,
    bytes: &[u8],
    warnings: &mut Warnings,
) -> Result<(RawMesh, u64), ReadError> {
    read_model(name, bytes, warnings).map(|model| (model.mesh, model.checksum))
}

/// A mesh file, with all that it says about how its mesh moves.
#[derive(Clone, Debug)]
pub struct Model {
    /// The mesh at rest.
    pub mesh: RawMesh,
    /// As in [`read_mesh_checked`].
    pub checksum: u64,
    /// What moves its vertices, and its cameras; `None` if it has neither animations nor cameras.
    pub motion: Option<Arc<dyn Motion>>,
}

/// As [`read_mesh_checked`], with what moves the mesh. Animations that are damaged are left out, which is said in
/// `warnings`.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_model(name: &Path, bytes: &[u8], warnings: &mut Warnings) -> Result<Model, ReadError> {
    let mut sum = Checksum::new();
    sum.update(bytes);
    let (mesh, motion) = parse(name, bytes, &mut sum, warnings)
        .map_err(|kind| ReadError { path: name.to_path_buf(), kind })?;
    Ok(Model { mesh, checksum: sum.finish(), motion })
}

/// What a reader finds.
type Found = (RawMesh, Option<Arc<dyn Motion>>);

/// What a mesh file holds besides its mesh, gzipped or not, as names and values for people: of glTF its nodes, skins,
/// animations and so on; of the other formats nothing. Empty for what cannot be read.
#[cfg_attr(not(feature = "gltf"), allow(unused_variables, reason = "only glTF has more to tell"))]
pub fn mesh_facts(name: &Path, bytes: &[u8]) -> Vec<(String, String)> {
    #[cfg(feature = "gltf")]
    if let Ok(bytes) = unpacked(bytes, &mut Warnings::new(), |start| may_be_gltf(name, start))
        && is_gltf(&sniff(name, &bytes, true))
    {
        return crate::gltf::facts(&bytes);
    }
    Vec::new()
}

#[cfg(feature = "gltf")]
fn is_gltf(sniffed: &Sniffed) -> bool {
    matches!(sniffed, Sniffed::Mesh(MeshFormat::Gltf | MeshFormat::Glb))
}

/// Refuses a beginning that is of another format: nothing will be told of it, so the rest need not be unpacked.
#[cfg(feature = "gltf")]
fn may_be_gltf(name: &Path, start: &[u8]) -> Result<(), ReadErrorKind> {
    match sniff(name, start, false) {
        Sniffed::Undecided => Ok(()),
        sniffed if is_gltf(&sniffed) => Ok(()),
        _ => Err(ReadErrorKind::NoFaces),
    }
}

/// The content of a file that may be gzipped; `look` sees its beginning, if it is, and may refuse.
fn unpacked<'a>(
    bytes: &'a [u8],
    warnings: &mut Warnings,
    look: impl FnOnce(&[u8]) -> Result<(), ReadErrorKind>,
) -> Result<Cow<'a, [u8]>, ReadErrorKind> {
    if gzip::is_gzip(bytes) {
        return gzip::unpack(bytes, warnings, look).map(Cow::Owned);
    }
    Ok(Cow::Borrowed(bytes))
}

fn parse(
    name: &Path,
    bytes: &[u8],
    sum: &mut Checksum,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    if bytes.is_empty() {
        return Err(ReadErrorKind::Empty);
    }
    let file_length = bytes.len();
    let bytes = &unpacked(bytes, warnings, |start| look(name, start, file_length))?;
    match sniff(name, bytes, true) {
        Sniffed::Mesh(format) => read_format(format, Input { name, bytes, file_length }, sum, warnings),
        Sniffed::Other(error) => Err(error),
        Sniffed::Undecided => Err(ReadErrorKind::NoFaces),
    }
}

/// What a reader is given.
#[cfg_attr(
    not(feature = "gltf"),
    allow(dead_code, reason = "only glTF looks for other files, and measures what it draws by its own")
)]
pub(crate) struct Input<'a> {
    /// The path of the file.
    pub(crate) name: &'a Path,
    /// Its bytes, unpacked.
    pub(crate) bytes: &'a [u8],
    /// How long it is, gzipped if it is.
    pub(crate) file_length: usize,
}

/// Refuses the beginning of what `packed` bytes hold, if it is no mesh or declares more than could follow.
#[cfg_attr(not(feature = "ply"), allow(unused_variables, reason = "only PLY declares its size up front"))]
fn look(name: &Path, start: &[u8], packed: usize) -> Result<(), ReadErrorKind> {
    match sniff(name, start, false) {
        Sniffed::Other(error) => Err(error),
        #[cfg(feature = "ply")]
        Sniffed::Mesh(MeshFormat::Ply) => {
            let limit = gzip::limit(packed).min(packed as u64 * gzip::DEFLATE_RATIO);
            crate::ply::check_declared_size(start, limit)
        }
        _ => Ok(()),
    }
}

#[cfg_attr(
    not(all(feature = "ply", feature = "gltf")),
    allow(unused_variables, reason = "formats left out leave arguments unused")
)]
fn read_format(
    format: MeshFormat,
    input: Input,
    sum: &mut Checksum,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    let still = |mesh| (mesh, None);
    match format {
        #[cfg(feature = "ply")]
        MeshFormat::Ply => crate::ply::read(input.bytes, warnings).map(still),
        #[cfg(feature = "obj")]
        MeshFormat::Obj => crate::obj::read(input.bytes, warnings).map(still),
        #[cfg(feature = "stl")]
        MeshFormat::Stl => crate::stl::read(input.bytes, warnings).map(still),
        #[cfg(feature = "off")]
        MeshFormat::Off => crate::off::read(input.bytes, warnings).map(still),
        #[cfg(feature = "gltf")]
        MeshFormat::Gltf | MeshFormat::Glb => crate::gltf::read(input, sum, warnings),
        #[allow(unreachable_patterns, reason = "with every feature on")]
        _ => Err(ReadErrorKind::NotReadYet(match format {
            MeshFormat::Ply => "a PLY file",
            MeshFormat::Obj => "an OBJ file",
            MeshFormat::Stl => "an STL file",
            MeshFormat::Off => "an OFF file",
            MeshFormat::Gltf | MeshFormat::Glb => "a glTF file",
        })),
    }
}
