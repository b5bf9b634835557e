//! The mesh type.

use glam::Vec3;

/// Vertices and triangles as a file gives them, before any cleaning.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawMesh {
    /// Vertex positions, object units, relative to `origin`.
    pub positions: Vec<[f32; 3]>,
    /// Triangles as indices into `positions`; polygons are already cut into fans.
    pub triangles: Vec<[u32; 3]>,
    /// Subtracted from every position while reading, so that double-precision coordinates far from zero survive
    /// `f32`; zero otherwise.
    pub origin: [f64; 3],
    /// Polygons in the file before they were cut into triangles.
    pub polygons: usize,
}

/// How a mesh is put in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshOptions {
    /// Merge vertices with bit-identical positions (soups from STL, seams from OBJ).
    pub weld: bool,
    /// Edges whose faces meet at more than this angle in degrees split the normals; 180 keeps every normal smooth.
    pub crease_angle: f32,
}

impl Default for MeshOptions {
    fn default() -> Self {
        MeshOptions { weld: true, crease_angle: 180.0 }
    }
}

/// A triangle mesh in order: clean triangles, topology facts and unit normals.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Vertex positions, object units, relative to `origin`.
    pub positions: Vec<Vec3>,
    /// Triangles as indices into `positions`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals; the first `positions.len()` belong to the vertices, further ones to split corners.
    pub normals: Vec<Vec3>,
    /// For each triangle corner its normal in `normals`.
    pub corner_normals: Vec<[u32; 3]>,
    /// What readers subtracted from the coordinates of the file.
    pub origin: [f64; 3],
    /// True if every edge has exactly two faces that agree in winding.
    pub closed: bool,
}

/// Why a mesh cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshError {}
