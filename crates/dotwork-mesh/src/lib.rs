//! Triangle meshes: what readers hand over, how it is put in order, and the built-in demo shapes.
//!
//! A reader fills a [`RawMesh`]; [`Mesh::build`] cleans it (welding, degenerate and duplicate triangles, unused
//! vertices, winding), finds its topology and its normals, and says in [`dotwork_drawing::Warnings`] what it changed.
//! This crate knows nothing of ink, files or devices.

mod mesh;

pub use mesh::{Mesh, MeshError, MeshOptions, RawMesh};
