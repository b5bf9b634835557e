//! glTF 2.0, text and binary (The Khronos Group, "glTF 2.0 Specification", 2021): the scene as one mesh, at rest.
//!
//! Reading has two halves. A [`Document`] is the parsed JSON with its buffers, its accessors and the tree of its nodes;
//! it knows nothing of time. A [`Pose`] says where every node stands and how far every morph target is applied; the
//! only one so far is the rest pose, made from what the file's nodes say. [`geometry`] draws a document in a pose.
//!
//! Read are nested nodes with matrices or translation, rotation and scale; triangles, strips and fans, indexed or not;
//! every component type, stride, normalized integers (`KHR_mesh_quantization`) and sparse accessors; buffers in the
//! file, in the JSON as base64, or beside the file; `COLOR_0`, converted from linear light to sRGB; morph targets with
//! their default weights; skins, whose joints alone place the vertices. A mirroring transform turns its triangles over.
//! The default scene is drawn, or all root nodes where there is none.
//!
//! Nothing is believed: every index, offset and length is checked in 64 bits before it is used, nodes are walked
//! without recursion, and what instances and shared accessors may expand to is limited (see [`budget`]).
//! Limits: Draco and meshopt compression, and every other required extension that changes geometry, are refused by
//! name; points and lines are counted and skipped; materials are not read.

mod accessor;
mod budget;
mod buffers;
mod container;
mod extensions;
mod facts;
mod geometry;
mod json;
mod nodes;
mod skin;

use std::path::Path;

use dotwork_drawing::Warnings;
use dotwork_mesh::RawMesh;

use crate::checksum::Checksum;
use crate::error::ReadErrorKind;
use crate::file::Input;
use buffers::Buffers;
pub(crate) use facts::facts;
use json::Json;
use nodes::{Pose, Tree};

/// Reads a glTF file of either form; buffers that are files are looked for in its folder and added to `sum`.
pub(crate) fn read(
    input: Input,
    sum: &mut Checksum,
    warnings: &mut Warnings,
) -> Result<RawMesh, ReadErrorKind> {
    let document = Document::parse(&input, warnings)?;
    let pose = Pose::rest(&document.json, &document.tree);
    let mesh = geometry::draw(&document, &pose, warnings)?;
    document.buffers.add_to(sum);
    Ok(mesh)
}

/// A glTF file, parsed: everything that does not change with time.
struct Document<'a> {
    json: Json<'a>,
    buffers: Buffers<'a>,
    tree: Tree,
    /// Bytes of the file, gzipped if it is.
    file_length: u64,
}

impl<'a> Document<'a> {
    fn parse(input: &Input<'a>, warnings: &mut Warnings) -> Result<Self, ReadErrorKind> {
        let parts = container::split(input.bytes, warnings)?;
        let json = json::parse(&parts)?;
        extensions::check(&json, warnings)?;
        let tree = Tree::new(&json)?;
        let folder = input.name.parent().unwrap_or(Path::new(""));
        let buffers = Buffers::new(folder, parts.binary, json.buffers.len());
        Ok(Document { json, buffers, tree, file_length: input.file_length as u64 })
    }
}
