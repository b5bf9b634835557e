//! Clipping: a mesh without the part that lies in a region bounded by planes.
//!
//! A [`ClipRegion`] is what half-spaces have in common (a cutaway: an octant, the inside of a box) or what they cover
//! together (a crop). Where the removed part is convex, one pass does it, whatever the number of planes: each triangle
//! loses a convex polygon (`triangle`), each edge one interval, and edges that lose nothing stay whole. Where the part
//! that is *kept* is convex, half-spaces are removed one after another.
//!
//! 1. Each vertex gets two bits a plane: not on its removed side, and on the plane. Vertices within rounding of a plane
//!    count as on it, and stay what they are, so no slivers arise there.
//! 2. Triangles whose vertices share one of the first bits stay whole; those without any go; the few others are cut.
//! 3. New vertices of shared edges become one, in the order in which they are met.
//! 4. Everything is put in its place, which the counts of the chunks say: the result does not depend on threads.

mod region;
mod triangle;

use std::borrow::Cow;
use std::collections::HashMap;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::GRAIN;
use crate::{RawMesh, paint};
pub use region::{ClipBox, ClipError, ClipPlane, ClipRegion, ClipRule};
use triangle::{Cut, EdgeKey, NEW};

/// Vertices closer to a plane than this part of the largest coordinate are on it: that is the rounding of `f32`.
const ON_PLANE: f64 = 1.0 / (1 << 23) as f64;

/// The mesh without what lies in `region`; planes are in world units, [`RawMesh::origin`] counts.
///
/// Triangles are cut at the planes, to the rounding of `f32`: new vertices are interpolated along the edges of the
/// mesh, positions linearly, normals linearly and brought to unit length, colours linearly in sRGB. Neighbours share
/// them, triangles that are no neighbours by index but have an edge in the same place get them with the same bits.
/// Winding and order are kept, the pieces of a triangle stand in its place. A surface that closes the cut is not made.
///
/// Triangles that lie in a plane stay where they bound what is kept (they face the removed side) and go where they
/// bounded what is removed. Vertices without a finite distance count as on the plane. If nothing is removed, the mesh
/// is the same bit for bit; so is one that [`crate::Mesh::build`] refuses because of its indices.
///
/// ```
/// use dotwork_mesh::{ClipRegion, Mesh, MeshOptions, clip, shapes};
/// use glam::DVec3;
///
/// let half = ClipRegion::parse("x>0.5", [DVec3::NEG_ONE, DVec3::ONE])?;
/// let raw = clip(&shapes::sphere(5), &half);
/// assert!(raw.positions.iter().all(|p| p[0] <= 0.0));
/// let mesh = Mesh::build(raw, &MeshOptions::default(), &mut Default::default())?;
/// assert!((mesh.area() / (2.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn clip(raw: &RawMesh, region: &ClipRegion) -> RawMesh {
    let out_of_range = |t: &[u32; 3]| t.iter().any(|&v| v as usize >= raw.positions.len());
    if region.planes().is_empty() || raw.triangles.par_iter().with_min_len(GRAIN).any(out_of_range) {
        return raw.clone();
    }
    let mut mesh = Cow::Borrowed(raw);
    match region.rule() {
        ClipRule::All => {
            if let Some(cut) = Cutter::new(&mesh, region.planes()).cut() {
                mesh = Cow::Owned(cut);
            }
        }
        ClipRule::Any => {
            for plane in region.planes() {
                if let Some(cut) = Cutter::new(&mesh, std::slice::from_ref(plane)).cut() {
                    mesh = Cow::Owned(cut);
                }
            }
        }
    }
    mesh.into_owned()
}

/// A mesh, and what is to be removed from it: the common part of up to 32 half-spaces.
struct Cutter<'a> {
    raw: &'a RawMesh,
    /// Normals and offsets, relative to the mesh's origin.
    planes: Vec<(DVec3, f64)>,
    /// Distances up to this are 0.
    on_plane: f64,
}

/// What happens to a triangle.
enum Fate {
    Whole,
    Gone,
    /// It is cut by the planes whose bits are set.
    Cut(u32),
}

/// What a run of triangles becomes.
#[derive(Default)]
struct Chunk {
    cut: Cut,
    /// For each triangle that is cut, how many pieces there are.
    pieces: Vec<u32>,
    /// Triangles that come out.
    triangles: usize,
    changed: bool,
}

impl<'a> Cutter<'a> {
    fn new(raw: &'a RawMesh, planes: &[ClipPlane]) -> Cutter<'a> {
        let origin = DVec3::from_array(raw.origin);
        let planes = planes.iter().map(|p| (p.normal, p.offset - p.normal.dot(origin))).collect();
        let largest = |p: &[f32; 3]| p.iter().map(|c| c.abs()).filter(|c| c.is_finite()).fold(0.0, f32::max);
        let reach = raw.positions.par_iter().with_min_len(GRAIN).map(largest).reduce(|| 0.0, f32::max);
        Cutter { raw, planes, on_plane: ON_PLANE * f64::from(reach) }
    }

    /// How far vertex `v` lies on the removed side of plane `plane`; 0 if it is on it, or nowhere.
    #[inline]
    fn distance(&self, plane: usize, v: u32) -> f64 {
        self.distance_of(plane, self.raw.positions[v as usize])
    }

    #[inline]
    fn distance_of(&self, plane: usize, position: [f32; 3]) -> f64 {
        let (normal, offset) = self.planes[plane];
        let distance = normal.dot(DVec3::from_array(position.map(f64::from))) - offset;
        // Not the negation of the opposite: NaN is on the plane.
        if distance.abs() > self.on_plane && distance.is_finite() { distance } else { 0.0 }
    }

    /// Bit k: not on the removed side of plane k. Bit 32 + k: on it.
    fn sides(&self, position: [f32; 3]) -> u64 {
        let mut sides = 0;
        for k in 0..self.planes.len() {
            let distance = self.distance_of(k, position);
            sides |= u64::from(distance <= 0.0) << k | u64::from(distance == 0.0) << (32 + k);
        }
        sides
    }

    #[inline]
    fn fate(&self, sides: &[u64], triangle: [u32; 3]) -> Fate {
        let [a, b, c] = triangle.map(|v| sides[v as usize]);
        let (kept, on) = ((a & b & c) as u32, ((a & b & c) >> 32) as u32);
        if kept & !on != 0 {
            return Fate::Whole;
        }
        let mut active = ((1u64 << self.planes.len()) - 1) as u32;
        if on != 0 {
            if !self.bounds_the_removed(triangle, on) {
                return Fate::Whole;
            }
            active &= !on;
        }
        if (a | b | c) as u32 & active == 0 { Fate::Gone } else { Fate::Cut(active) }
    }

    /// True if the triangle, which lies in the planes whose bits are set in `on`, faces away from the removed side of
    /// each: the matter behind it is removed.
    #[cold]
    fn bounds_the_removed(&self, triangle: [u32; 3], on: u32) -> bool {
        let [a, b, c] = triangle.map(|v| DVec3::from_array(self.raw.positions[v as usize].map(f64::from)));
        let normal = (b - a).cross(c - a);
        (0..self.planes.len()).filter(|k| on >> k & 1 == 1).all(|k| self.planes[k].0.dot(normal) < 0.0)
    }

    /// The mesh without the common part of the half-spaces; `None` if that is the mesh itself.
    fn cut(&self) -> Option<RawMesh> {
        let sides: Vec<u64> =
            self.raw.positions.par_iter().with_min_len(GRAIN).map(|&p| self.sides(p)).collect();
        let chunks: Vec<Chunk> =
            self.raw.triangles.par_chunks(GRAIN).map(|run| self.cut_run(&sides, run)).collect();
        if !chunks.iter().any(|c| c.changed) {
            return None;
        }
        let kept = self.kept_vertices(&sides, &chunks);
        let mut mesh = RawMesh { origin: self.raw.origin, ..RawMesh::default() };
        mesh.positions = gather(&self.raw.positions, &kept);
        let has = |len: usize| len == self.raw.positions.len();
        let (has_normals, has_colors) = (has(self.raw.normals.len()), has(self.raw.colors.len()));
        if has_normals {
            mesh.normals = gather(&self.raw.normals, &kept);
        }
        if has_colors {
            mesh.colors = gather(&self.raw.colors, &kept);
        }

        // Numbers of the new vertices of each chunk: in the order met, those of shared edges once.
        let mut seen: HashMap<EdgeKey, u32> = HashMap::new();
        let mut numbers = Vec::with_capacity(chunks.len());
        for chunk in &chunks {
            let mut of_chunk = Vec::with_capacity(chunk.cut.vertices.len());
            for vertex in &chunk.cut.vertices {
                let next = mesh.positions.len() as u32;
                let number = vertex.key.map_or(next, |key| *seen.entry(key).or_insert(next));
                of_chunk.push(number);
                if number == next {
                    mesh.positions.push(vertex.position);
                    if has_normals {
                        mesh.normals.push(vertex.normal);
                    }
                    if has_colors {
                        mesh.colors.push(vertex.color);
                    }
                }
            }
            numbers.push(of_chunk);
        }

        let mut renumbered = Vec::with_capacity(kept.len());
        let mut next = 0;
        for &keep in &kept {
            renumbered.push(next);
            next += u32::from(keep);
        }
        let total = chunks.iter().map(|c| c.triangles).sum();
        mesh.triangles = vec![[0; 3]; total];
        mesh.polygons = total;
        let mut rest = &mut mesh.triangles[..];
        let mut outputs = Vec::with_capacity(chunks.len());
        for chunk in &chunks {
            let (output, after) = rest.split_at_mut(chunk.triangles);
            outputs.push(output);
            rest = after;
        }
        let runs = self.raw.triangles.par_chunks(GRAIN).zip(&chunks).zip(&numbers).zip(outputs);
        runs.for_each(|(((run, chunk), numbers), output)| {
            let mut output = output.iter_mut();
            self.each_kept(&sides, run, chunk, |corners| {
                let number = |v: u64| match v.checked_sub(NEW) {
                    Some(new) => numbers[new as usize],
                    None => renumbered[v as usize],
                };
                if let Some(triangle) = output.next() {
                    *triangle = corners.map(number);
                }
            });
        });
        mesh.paint = self.raw.paint.as_ref().filter(|p| p.fits(self.raw.triangles.len())).map(|paint| {
            let mut pieces = Vec::with_capacity(total);
            for (k, ((run, chunk), numbers)) in
                self.raw.triangles.chunks(GRAIN).zip(&chunks).zip(&numbers).enumerate()
            {
                self.each_piece(&sides, run, chunk, |t, corners| {
                    let whole = run[t];
                    let place = |v: u64| match v.checked_sub(NEW) {
                        Some(new) => mesh.positions[numbers[new as usize] as usize],
                        None => self.raw.positions[v as usize],
                    };
                    let weights = || {
                        let of = whole.map(|v| Vec3::from_array(self.raw.positions[v as usize]));
                        corners.map(|v| paint::weights_at(of, Vec3::from_array(place(v))))
                    };
                    let cut = corners != whole.map(u64::from);
                    pieces.push(((k * GRAIN + t) as u32, cut.then(weights)));
                });
            }
            paint.cut(&pieces)
        });
        Some(mesh)
    }

    fn cut_run(&self, sides: &[u64], run: &[[u32; 3]]) -> Chunk {
        let mut chunk = Chunk::default();
        for &triangle in run {
            match self.fate(sides, triangle) {
                Fate::Whole => chunk.triangles += 1,
                Fate::Gone => chunk.changed = true,
                Fate::Cut(planes) => {
                    let before = chunk.cut.corners.len();
                    chunk.changed |= chunk.cut.add(self, triangle, planes);
                    let pieces = chunk.cut.corners.len() - before;
                    chunk.pieces.push(pieces as u32);
                    chunk.triangles += pieces;
                }
            }
        }
        chunk
    }

    /// Calls `visit` with the corners of each triangle that comes out of a run, in order; see [`Cut::corners`].
    fn each_kept(&self, sides: &[u64], run: &[[u32; 3]], chunk: &Chunk, mut visit: impl FnMut([u64; 3])) {
        self.each_piece(sides, run, chunk, |_, corners| visit(corners));
    }

    /// As [`Cutter::each_kept`], with the place in the run of the triangle that each is of.
    fn each_piece(
        &self,
        sides: &[u64],
        run: &[[u32; 3]],
        chunk: &Chunk,
        mut visit: impl FnMut(usize, [u64; 3]),
    ) {
        let (mut pieces, mut corners) = (chunk.pieces.iter(), chunk.cut.corners.iter());
        for (t, &triangle) in run.iter().enumerate() {
            match self.fate(sides, triangle) {
                Fate::Whole => visit(t, triangle.map(u64::from)),
                Fate::Gone => {}
                Fate::Cut(_) => {
                    let count = pieces.next().copied().unwrap_or_default() as usize;
                    corners.by_ref().take(count).for_each(|&c| visit(t, c));
                }
            }
        }
    }

    /// Which vertices stay: those clearly on the kept side of a plane, and those on a plane that something uses.
    fn kept_vertices(&self, sides: &[u64], chunks: &[Chunk]) -> Vec<bool> {
        let off_plane = |s: u64| s as u32 & !(s >> 32) as u32 != 0;
        let mut kept: Vec<bool> = sides.iter().map(|&s| off_plane(s)).collect();
        if sides.iter().any(|&s| s >> 32 != 0 && !off_plane(s)) {
            for (run, chunk) in self.raw.triangles.chunks(GRAIN).zip(chunks) {
                self.each_kept(sides, run, chunk, |corners| {
                    for v in corners.into_iter().filter(|&v| v < NEW) {
                        kept[v as usize] = true;
                    }
                });
            }
        }
        kept
    }
}

/// The values of the vertices that are kept.
fn gather<T: Copy>(values: &[T], kept: &[bool]) -> Vec<T> {
    values.iter().zip(kept).filter(|(_, keep)| **keep).map(|(&v, _)| v).collect()
}
