//! What a bake asks of a surface: candidates, uniform by area, each a pure function of integers.

mod mesh;

pub use mesh::MeshSurface;

use std::ops::Range;

use dotwork_drawing::hash::hash2;
use glam::Vec3;

/// One stage of a bake: how many candidates it has and the seed of its random stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageDraw {
    /// Number of candidates of the whole surface at this stage.
    pub count: u64,
    /// Seed of the stage's stream; differs from stage to stage.
    pub seed: u32,
}

/// A place on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Position, object units.
    pub position: Vec3,
    /// Unit normal of the facet or of the surface there, pointing outwards.
    pub normal: Vec3,
    /// The element (triangle, cell, surfel) that carries the place.
    pub element: u32,
    /// Barycentric coordinates of the element's second and third vertex.
    pub weights: [f32; 2],
}

/// A surface that stipples can be baked on.
///
/// The contract: `visit` offers candidate `i` of `draw.count` at a place that depends only on the surface, on
/// `draw` and on `i` — not on the range asked for, nor on threads — and all candidates together are uniform by area.
/// It is cheap, allocates nothing and is called from many threads.
pub trait Surface: Sync {
    /// Total area, object units squared; positive and finite.
    fn area(&self) -> f64;

    /// Smallest corner of the bounding box.
    fn min_corner(&self) -> Vec3;

    /// Calls `sink(index, place)` for every candidate in `range`, in order.
    fn visit(&self, draw: StageDraw, range: Range<u64>, sink: &mut impl FnMut(u64, Place));

    /// Ranges of candidates, rising, with all those that lie in the box between two corners, and few others.
    fn ranges_near(&self, draw: StageDraw, corners: [Vec3; 2]) -> Vec<Range<u64>>;
}

/// A hash of candidate `index` within a stream: below 2³², where nearly all are, of two integers.
#[inline(always)]
pub(crate) fn hash_of(index: u64, stream: u32) -> u32 {
    let high = (index >> 32) as u32;
    hash2(index as u32, if high == 0 { stream } else { hash2(high, stream) })
}
