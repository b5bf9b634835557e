//! Small double-precision helpers: products of `f32` coordinates neither overflow nor vanish in `f64`.

use glam::{DVec3, Vec3};

/// Triangles or vertices handled by one task: large enough to hide the cost of a task, small enough to balance.
pub(crate) const GRAIN: usize = 4096;

/// The corners of a triangle in double precision.
#[inline]
pub(crate) fn corners(positions: &[Vec3], triangle: [u32; 3]) -> [DVec3; 3] {
    triangle.map(|v| positions[v as usize].as_dvec3())
}

/// The vector area: along the facet normal, as long as the area.
#[inline]
pub(crate) fn vector_area([a, b, c]: [DVec3; 3]) -> DVec3 {
    0.5 * (b - a).cross(c - a)
}
