//! Measures of a mesh: bounds, area, volume, and the facts that `dotwork info` prints.
//!
//! Sums run in double precision over runs of fixed length, added in order: the same on any number of threads.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::Mesh;
use crate::geometry::{GRAIN, corners, vector_area};

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The lowest coordinates, object units.
    pub min: Vec3,
    /// The highest coordinates, object units.
    pub max: Vec3,
}

impl Bounds {
    /// The middle of the box.
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// The lengths of the sides.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }
}

/// What can be said of a mesh in numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshStats {
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Connected components, by shared vertices.
    pub components: usize,
    /// Edges.
    pub edges: usize,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Edges with more than two faces.
    pub non_manifold_edges: usize,
    /// True if every edge has exactly two faces that agree in winding.
    pub closed: bool,
    /// Vertices − edges + triangles.
    pub euler_characteristic: i64,
    /// Area, object units squared.
    pub area: f64,
    /// Signed volume, object units cubed; means little unless `closed`.
    pub volume: f64,
    /// The bounding box.
    pub bounds: Bounds,
}

impl Mesh {
    /// The smallest axis-aligned box around all vertices.
    pub fn bounds(&self) -> Bounds {
        let empty = || (Vec3::INFINITY, Vec3::NEG_INFINITY);
        // Minima and maxima do not depend on the order.
        let (min, max) = self
            .positions
            .par_iter()
            .with_min_len(GRAIN)
            .fold(empty, |(min, max), &p| (min.min(p), max.max(p)))
            .reduce(empty, |a, b| (a.0.min(b.0), a.1.max(b.1)));
        Bounds { min, max }
    }

    /// A sphere around all vertices: the centre of [`Mesh::bounds`], and the distance to the farthest vertex.
    pub fn bounding_sphere(&self) -> (Vec3, f32) {
        let center = self.bounds().center();
        (center, self.farthest_from(center))
    }

    /// The distance from `center` to the farthest vertex, object units.
    pub fn farthest_from(&self, center: Vec3) -> f32 {
        let squares = self.positions.par_iter().with_min_len(GRAIN).map(|p| p.distance_squared(center));
        squares.reduce(|| 0.0, f32::max).sqrt()
    }

    /// The corners of triangle `t`.
    ///
    /// # Panics
    ///
    /// If there is no triangle `t`.
    #[inline]
    pub fn triangle(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|v| self.positions[v as usize])
    }

    /// The unit normal of triangle `t`, outwards.
    ///
    /// # Panics
    ///
    /// If there is no triangle `t`.
    pub fn facet_normal(&self, t: usize) -> Vec3 {
        vector_area(corners(&self.positions, self.triangles[t])).normalize_or(DVec3::Z).as_vec3()
    }

    /// The area, object units squared.
    pub fn area(&self) -> f64 {
        self.sum(|c| vector_area(c).length())
    }

    /// The signed volume, object units cubed: positive for a closed mesh that faces outwards. Of an open mesh it is
    /// the volume of the cone over it from the centre of its bounding box.
    pub fn volume(&self) -> f64 {
        let center = self.bounds().center().as_dvec3();
        self.sum(|c| (c[0] - center).dot(vector_area(c)) / 3.0)
    }

    /// Everything [`MeshStats`] lists; finds the topology anew.
    pub fn stats(&self) -> MeshStats {
        let topology = self.topology();
        MeshStats {
            vertices: self.positions.len(),
            triangles: self.triangles.len(),
            components: topology.components(&self.triangles).count,
            edges: topology.edges(),
            boundary_edges: topology.boundary_edges(),
            non_manifold_edges: topology.non_manifold_edges(),
            closed: topology.is_closed(),
            euler_characteristic: topology.euler_characteristic(),
            area: self.area(),
            volume: self.volume(),
            bounds: self.bounds(),
        }
    }

    fn sum(&self, of: impl Fn([DVec3; 3]) -> f64 + Sync) -> f64 {
        let run = |run: &[[u32; 3]]| run.iter().map(|&t| of(corners(&self.positions, t))).sum::<f64>();
        self.triangles.par_chunks(GRAIN).map(run).collect::<Vec<f64>>().iter().sum()
    }
}
