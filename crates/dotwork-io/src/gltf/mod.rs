//! glTF 2.0, text and binary (The Khronos Group, "glTF 2.0 Specification", 2021): the scene as one mesh, and how it moves.
//!
//! A [`Document`] is the parsed JSON with its buffers, its accessors and the tree of its nodes; it knows nothing of time.
//! A [`Pose`](nodes::Pose) says where every node stands and how far every morph target is applied: at rest, as the nodes
//! themselves say, or at a time of an animation ([`clips`]). [`geometry`] draws a document at rest and keeps what places
//! its vertices in any other pose, a [`Rig`].
//!
//! Read are nested nodes with matrices or translation, rotation and scale; triangles, strips and fans, indexed or not;
//! every component type, stride, normalized integers (`KHR_mesh_quantization`) and sparse accessors; buffers in the
//! file, in the JSON as base64, or beside the file; `COLOR_0`, converted from linear light to sRGB; morph targets with
//! their default weights; base colours of materials and their pictures (PNG, JPEG), which a surface's paint keeps; skins of one or two sets of joints, which alone place the vertices; animations of nodes and
//! weights in steps, lines and cubic splines; cameras. A mirroring transform turns its triangles over.
//! The default scene is drawn, or all root nodes where there is none.
//!
//! Nothing is believed: every index, offset and length is checked in 64 bits before it is used, nodes are walked
//! without recursion, and what instances and shared accessors may expand to is limited (see [`budget`]).
//! Limits: Draco and meshopt compression, and every other required extension that changes geometry, are refused by
//! name; points and lines are counted and skipped; of materials only
//! the base colour is read. Pictures that cannot be read are left out with a warning.

mod accessor;
mod budget;
mod buffers;
mod clips;
mod container;
mod extensions;
mod facts;
mod geometry;
mod json;
mod materials;
mod nodes;
mod pictures;
mod rig;
mod skin;

use std::path::Path;
use std::sync::Arc;

use dotwork_drawing::Warnings;
use dotwork_mesh::{Motion, RawMesh};

use crate::checksum::Checksum;
use crate::error::ReadErrorKind;
use crate::file::Input;
use buffers::Buffers;
pub(crate) use facts::facts;
use json::Json;
use nodes::Tree;
use rig::Rig;

/// Reads a glTF file of either form, with what moves its mesh; buffers that are files are looked for in its folder and
/// added to `sum`.
pub(crate) fn read(
    input: Input,
    sum: &mut Checksum,
    warnings: &mut Warnings,
) -> Result<(RawMesh, Option<Arc<dyn Motion>>), ReadErrorKind> {
    let document = Document::parse(&input, warnings)?;
    let (mesh, rig) = geometry::draw(&document, warnings)?;
    document.buffers.add_to(sum);
    Ok((mesh, rig.map(|rig: Rig| Arc::new(rig) as Arc<dyn Motion>)))
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
