//! The mesh type, and the order of work that makes it from what a reader found.

use std::sync::Arc;

use dotwork_drawing::Warnings;
use glam::Vec3;
use rayon::prelude::*;
use thiserror::Error;

use crate::clean::{self, Cleaned};
use crate::{Paint, Topology, normals, winding};

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
    /// Colours of the vertices, sRGB and opacity, 0…255; empty if the file has none, otherwise one for each position.
    pub colors: Vec<[u8; 4]>,
    /// Unit normals of the vertices where the source knows them better than the triangles do (an isosurface has its
    /// field's gradient); empty otherwise. Normals that files carry are not kept: dotwork computes its own.
    pub normals: Vec<[f32; 3]>,
    /// What its maker vouches for; `None` for what comes from elsewhere, or was changed.
    pub in_order: Option<InOrder>,
    /// What colours the triangles, one entry for each; multiplied with `colors`.
    pub paint: Option<Paint>,
    /// How each vertex moves, as a number: vertices at the same place are one only if these are the same too, so that a
    /// surface that opens as it moves is open from the start. Empty where nothing moves.
    pub tracks: Vec<u64>,
}

/// The word of whoever made a mesh that there is nothing to clean: all vertices differ and are used, every triangle has
/// an area and differs from all others, and faces that share an edge agree in winding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InOrder {
    /// Every edge has exactly two faces.
    pub closed: bool,
}

/// How a mesh is put in order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshOptions {
    /// Merge vertices with bit-identical positions (soups from STL, seams from OBJ).
    pub weld: bool,
    /// Edges whose faces meet at more than this angle in degrees split the normals; 180 keeps every normal smooth.
    pub crease_angle: f32,
    /// Make neighbours agree in winding and enclosing surfaces face outwards; false where the source knows better, as
    /// an isosurface does: the wall of a cavity faces into it, also where it is cut open.
    pub orient: bool,
}

impl Default for MeshOptions {
    fn default() -> Self {
        MeshOptions { weld: true, crease_angle: 180.0, orient: true }
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
    /// Colours of the vertices, sRGB and opacity, 0…255: one for each position, or empty if the source has none.
    pub colors: Vec<[u8; 4]>,
    /// What colours the triangles, one entry for each; multiplied with `colors`. Shared by all poses.
    pub paint: Option<Arc<Paint>>,
}

/// Why a mesh cannot be used. Each text reads well after the name of the file and a colon.
///
/// Vertices and triangles are numbered from 0, as in the [`RawMesh`].
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MeshError {
    /// There is nothing to draw on: a point cloud, or an empty file.
    #[error("no triangles")]
    NoTriangles,
    /// Indices of corners and edges are 32-bit numbers.
    #[error("{triangles} triangles are more than the {limit} that a mesh can hold")]
    TooManyTriangles {
        /// Triangles found.
        triangles: usize,
        /// The most that fit.
        limit: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error(
        "triangle {triangle} refers to vertex {vertex}, but there are {vertices} vertices (counted from 0)"
    )]
    IndexOutOfRange {
        /// The first such triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// Vertices in the file.
        vertices: usize,
    },
    /// A vertex that a triangle uses has a coordinate that is infinite or no number.
    #[error("vertex {vertex}, used by triangle {triangle}, has a coordinate that is not a finite number")]
    NotFinite {
        /// The vertex.
        vertex: u32,
        /// The first triangle with such a vertex.
        triangle: usize,
    },
    /// Nothing is left once degenerate triangles are gone.
    #[error("the surface has no area: all triangles ({triangles}) are degenerate")]
    NoArea {
        /// Triangles in the file.
        triangles: usize,
    },
    /// Squares of lengths would overflow or vanish in single precision.
    #[error("the surface measures {extent:e} units across; sizes from {min:e} to {max:e} can be drawn")]
    Size {
        /// The largest absolute coordinate if that is too large, otherwise the longest side of the bounding box.
        extent: f32,
        /// The smallest size that can be drawn.
        min: f32,
        /// The largest size that can be drawn.
        max: f32,
    },
}

impl Mesh {
    /// Puts a raw mesh in order:
    ///
    /// 1. indices and coordinates are checked;
    /// 2. vertices with bit-identical positions become one (`options.weld`; −0 equals 0), with the colour and the
    ///    given normal of the first;
    /// 3. triangles without area (a corner twice, or a height under 10⁻⁷ of the longest edge) and repeated
    ///    triangles (the same three vertices in any order) are dropped, then vertices that no triangle uses;
    /// 4. neighbours are made to agree in winding, and surfaces that enclose something to face outwards
    ///    (`options.orient`);
    /// 5. normals are the facet normals around a vertex weighted by the angle each face has there, split where faces
    ///    meet at more than `options.crease_angle`. Where nothing is split (180), [`RawMesh::normals`] are used
    ///    instead if they are given, brought to unit length; they turn with their faces, and computed ones stand in
    ///    for those that are zero or not finite.
    ///
    /// Colours or normals that are not one for each position, and paint that is not for each triangle, are ignored with
    /// a warning. What remains keeps its order,
    /// so a clean mesh keeps its indices. Every change adds a warning.
    ///
    /// # Winding
    ///
    /// A component is what manifold edges connect. If its faces disagree, those with the smaller total area are
    /// turned (a Möbius strip cannot agree: it stays open). A component *encloses* if it is closed, or if its holes
    /// are small: the holes' vector area is at most a tenth of the area, and the volume about the centroid at least a
    /// twentieth of that of the ball with the same area, which no open sheet reaches. An enclosing component with
    /// negative volume is turned outwards, unless its bounding box lies inside that of another one: then it may be
    /// the wall of a cavity, which rightly faces the other way, and it is turned only together with the component
    /// around it. Other open components (sheets, cups, rooms seen from inside) stay as they are.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`]; `warnings` then holds nothing new.
    pub fn build(raw: RawMesh, options: &MeshOptions, warnings: &mut Warnings) -> Result<Mesh, MeshError> {
        Mesh::build_tracked(raw, options, warnings).map(|(mesh, _)| mesh)
    }

    /// As [`Mesh::build`], with the vertex of `raw` that each vertex of the mesh was.
    ///
    /// # Errors
    ///
    /// Any [`MeshError`].
    pub(crate) fn build_tracked(
        raw: RawMesh,
        options: &MeshOptions,
        warnings: &mut Warnings,
    ) -> Result<(Mesh, Vec<u32>), MeshError> {
        let origin = raw.origin;
        // A crease angle that is no number splits nothing.
        let smooth = options.crease_angle.is_nan() || options.crease_angle >= 180.0;
        if let Some(in_order) = raw.in_order
            && smooth
            && raw.normals.len() == raw.positions.len()
        {
            let all = (0..raw.positions.len() as u32).collect();
            return Ok((Mesh { origin, ..Mesh::in_order(raw, in_order, warnings)? }, all));
        }
        let Cleaned { positions, mut triangles, colors, normals: given, sources, mut paint } =
            clean::clean(raw, options.weld, warnings)?;
        let mut topology = Topology::new(positions.len(), &triangles);
        let as_given = ((smooth && !given.is_empty()) || paint.is_some()).then(|| triangles.clone());
        if options.orient {
            winding::orient(&positions, &mut triangles, &mut topology, warnings);
        }
        if let (Some(paint), Some(before)) = (&mut paint, &as_given) {
            paint.turn(before, &triangles);
        }
        let paint = paint.map(Arc::new);
        let closed = topology.is_closed();
        let computed = || normals::normals(&positions, &triangles, &topology, options.crease_angle);
        let (normals, corner_normals) = match as_given.filter(|_| smooth && !given.is_empty()) {
            Some(before) => {
                let given = normals::turned(&given, &before, &triangles);
                (normals::completed(given, || computed().0, warnings), triangles.clone())
            }
            None => computed(),
        };
        Ok((Mesh { positions, triangles, normals, corner_normals, origin, closed, colors, paint }, sources))
    }

    /// A mesh that its maker put in order, with the normals that it brings: what [`Mesh::build`] would make of it.
    fn in_order(
        raw: RawMesh,
        InOrder { closed }: InOrder,
        warnings: &mut Warnings,
    ) -> Result<Mesh, MeshError> {
        let Cleaned { positions, triangles, colors, normals, paint, .. } = clean::trusted(raw, warnings)?;
        let given = normals.into_par_iter().map(Vec3::from_array).collect();
        let computed = || {
            let topology = Topology::new(positions.len(), &triangles);
            normals::normals(&positions, &triangles, &topology, 180.0).0
        };
        let normals = normals::completed(given, computed, warnings);
        let corner_normals = triangles.clone();
        let (origin, paint) = ([0.0; 3], paint.map(Arc::new));
        Ok(Mesh { positions, triangles, normals, corner_normals, origin, closed, colors, paint })
    }

    /// A mesh from plain arrays: vertex positions in object units, and triangles as indices into them,
    /// counter-clockwise seen from outside.
    ///
    /// The short form of [`Mesh::build`] with the default [`MeshOptions`]: cleaned in the same way, but without a
    /// word on what was changed.
    ///
    /// ```
    /// use dotwork_mesh::Mesh;
    ///
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let mesh = Mesh::from_slices(&corners, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])?;
    /// assert!(mesh.closed);
    /// assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-6);
    ///
    /// assert!(Mesh::from_slices(&corners, &[[0, 1, 4]]).is_err(), "there is no vertex 4");
    /// # Ok::<(), dotwork_mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Any [`MeshError`].
    pub fn from_slices(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Mesh, MeshError> {
        let raw = RawMesh {
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            polygons: triangles.len(),
            ..RawMesh::default()
        };
        Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new())
    }

    /// The topology of the triangles, computed anew on each call.
    pub fn topology(&self) -> Topology {
        Topology::new(self.positions.len(), &self.triangles)
    }
}
