//! From a path to a mesh.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use dotwork_drawing::Warnings;
use dotwork_mesh::RawMesh;

use crate::error::{ReadError, ReadErrorKind};
use crate::format::{MeshFormat, Sniffed, sniff};
use crate::{gzip, obj, ply};

/// What is read at most from pipes and devices, which do not say how much they hold.
const STREAM_LIMIT: u64 = 1 << 30;

/// Reads a whole file into memory.
///
/// # Errors
/// A missing file, a directory, an empty file, or what the system says; a pipe or device that gives over 1 GiB.
pub fn read_file(path: &Path) -> Result<Vec<u8>, ReadError> {
    read_bytes(path).map_err(|kind| ReadError { path: path.to_path_buf(), kind })
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

/// Reads a PLY or OBJ mesh, gzipped or not.
///
/// Polygons are cut into fans; coordinates far from zero are brought near it by [`RawMesh::origin`]; normals, texture
/// coordinates, colours, groups and materials are not kept. What was dropped on the way is said in `warnings`.
///
/// # Errors
/// [`ReadError`], with file, place and reason.
pub fn read_mesh(path: &Path, warnings: &mut Warnings) -> Result<RawMesh, ReadError> {
    let bytes = read_file(path)?;
    read_mesh_bytes(path, &bytes, warnings)
}

/// Reads a mesh from the bytes of a file; `name` appears in messages, and decides where the content does not.
///
/// # Errors
/// As [`read_mesh`].
pub fn read_mesh_bytes(name: &Path, bytes: &[u8], warnings: &mut Warnings) -> Result<RawMesh, ReadError> {
    parse(name, bytes, warnings).map_err(|kind| ReadError { path: name.to_path_buf(), kind })
}

fn parse(name: &Path, bytes: &[u8], warnings: &mut Warnings) -> Result<RawMesh, ReadErrorKind> {
    if bytes.is_empty() {
        return Err(ReadErrorKind::Empty);
    }
    let bytes = if gzip::is_gzip(bytes) {
        let limit = gzip::limit(bytes.len()).min(bytes.len() as u64 * gzip::DEFLATE_RATIO);
        Cow::Owned(gzip::unpack(bytes, warnings, |start| match sniff(name, start, false) {
            Sniffed::Other(error) => Err(error),
            Sniffed::Mesh(MeshFormat::Ply) => ply::check_declared_size(start, limit),
            _ => Ok(()),
        })?)
    } else {
        Cow::Borrowed(bytes)
    };
    match sniff(name, &bytes, true) {
        Sniffed::Mesh(MeshFormat::Ply) => ply::read(&bytes, warnings),
        Sniffed::Mesh(MeshFormat::Obj) => obj::read(&bytes, warnings),
        Sniffed::Other(error) => Err(error),
        Sniffed::Undecided => Err(ReadErrorKind::NoFaces),
    }
}
