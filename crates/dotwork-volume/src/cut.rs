//! Cut faces: the planar faces that close an object which clipping opened, with the values that the cut lays bare.
//!
//! An isosurface without what lies in a [`ClipRegion`] is an open shell. For each plane of the region, the part of the
//! plane that bounds the region, lies in the volume and has `value >= iso` is the missing face: the volume is sampled
//! on a grid in the plane, half a voxel apart, and marching squares (the planar case of Lorensen and Cline 1987) with
//! interpolated crossings finds the rim (`squares`). Where the plane runs along the voxels, the grid's lines are theirs,
//! so the rim is where the isosurface's is. Borders by other planes and by the volume are clipped exactly.
//!
//! Inside, a voxel becomes two triangles; only voxels at the rim are cut into four squares.

mod sampler;
mod squares;

use std::ops::Range;

use dotwork_mesh::{ClipPlane, ClipRegion, ClipRule, RawMesh, clip};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::samples::Ordered;
use crate::volume::Volume;
use sampler::Sampler;

/// Grid points of a face, at most; beyond that the grid becomes coarser. That is a face of 1448 x 1448 voxels.
const MAX_POINTS: f64 = (1 << 23) as f64;

/// Lengths below this part of the volume's size are none.
const NOTHING: f64 = 1e-9;

/// Vertices in one task.
const GRAIN: usize = 4096;

/// The faces that close a cut; see [`cut_faces`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutFace {
    /// All faces, one after another; they share no vertices. Normals are flat.
    pub mesh: RawMesh,
    /// For each vertex the volume's value there, trilinear; finite.
    pub values: Vec<f32>,
    /// The faces that are not empty, in the order of the region's planes.
    pub faces: Vec<CutPlane>,
}

/// One of the faces.
#[derive(Clone, Debug, PartialEq)]
pub struct CutPlane {
    /// Its plane; the normal is that of the face, out of what remains.
    pub plane: ClipPlane,
    /// Its vertices in the mesh.
    pub vertices: Range<usize>,
    /// Its triangles in the mesh.
    pub triangles: Range<usize>,
}

impl CutFace {
    /// The values between which most of the cut lies: its 2nd and 98th percentile by area. `None` if it has no area.
    pub fn range(&self) -> Option<[f64; 2]> {
        let (order, weights) = self.by_value();
        let total: f64 = order.iter().map(|&v| weights[v]).sum();
        let at = |share: f64| {
            let mut sum = 0.0;
            let reached = |&&v: &&usize| {
                sum += weights[v];
                sum >= share * total
            };
            order.iter().find(reached).or(order.last()).map(|&v| f64::from(self.values[v]))
        };
        if total > 0.0 { Some([at(0.02)?, at(0.98)?]) } else { None }
    }

    /// For each vertex the share of the cut's area, 0…1, that has lower values; of what has the same value, half
    /// counts. All 0 if the cut has no area.
    pub fn ranks(&self) -> Vec<f32> {
        let (order, weights) = self.by_value();
        let total: f64 = order.iter().map(|&v| weights[v]).sum();
        let mut ranks = vec![0.0; order.len()];
        let mut below = 0.0;
        for same in order.chunk_by(|&a, &b| self.values[a].total_cmp(&self.values[b]).is_eq()) {
            let here: f64 = same.iter().map(|&v| weights[v]).sum();
            let rank = if total > 0.0 { ((below + 0.5 * here) / total).clamp(0.0, 1.0) as f32 } else { 0.0 };
            same.iter().for_each(|&v| ranks[v] = rank);
            below += here;
        }
        ranks
    }

    /// The vertices by ascending value, and for each vertex the area of the triangles that have it, up to a factor.
    fn by_value(&self) -> (Vec<usize>, Vec<f64>) {
        let mut weights = vec![0.0; self.values.len()];
        for t in &self.mesh.triangles {
            let [a, b, c] = t.map(|v| DVec3::from_array(self.mesh.positions[v as usize].map(f64::from)));
            let area = (b - a).cross(c - a).length();
            t.iter().for_each(|&v| weights[v as usize] += area);
        }
        let mut order: Vec<usize> = (0..weights.len()).collect();
        order.sort_by(|&a, &b| self.values[a].total_cmp(&self.values[b]));
        (order, weights)
    }
}

/// The faces that close the isosurface at `iso` of `volume` where `region` cuts it.
///
/// A face is the part of a plane of the region that bounds the region, lies between the centres of the border voxels
/// and has `value >= iso`. Triangles are counter-clockwise seen from the removed side, to which the normals point.
/// The rim follows the clipped isosurface to a small part of a voxel. Coordinates are relative to the same
/// [`RawMesh::origin`] as those of [`Volume::isosurface`].
///
/// A NaN counts as −∞: the eight cells around it have no face. Planes that do not pass through the volume, or only
/// touch its border, have no face; so has everything if `iso` is not finite, if the volume is a single slice, or if
/// the volume is too wide for single precision.
pub fn cut_faces(volume: &Volume, iso: f64, region: &ClipRegion) -> CutFace {
    let [min, max] = volume.bounds();
    let extent = (max - min).max_element();
    let too_wide = extent.is_nan() || extent > f64::from(f32::MAX) / 4.0;
    let mut cut = CutFace::default();
    cut.mesh.origin = volume.mesh_origin().to_array();
    if !iso.is_finite() || volume.dims().contains(&1) || too_wide {
        return cut;
    }
    with_samples!(volume.samples(), samples => {
        let sampler = Sampler::new(volume, samples);
        for plane in 0..region.planes().len() {
            if let Some(face) = Face::new(volume, region, plane) {
                cut.append(face.plane, face.mesh(&sampler, iso, cut.mesh.origin), &sampler);
            }
        }
    });
    cut.mesh.polygons = cut.mesh.triangles.len();
    cut
}

impl CutFace {
    fn append<T: Ordered>(&mut self, plane: ClipPlane, face: RawMesh, sampler: &Sampler<'_, T>) {
        if face.triangles.is_empty() {
            return;
        }
        let (first, first_triangle) = (self.mesh.positions.len(), self.mesh.triangles.len());
        let origin = DVec3::from_array(self.mesh.origin);
        let value = |p: &[f32; 3]| sampler.value(DVec3::from_array(p.map(f64::from)) + origin) as f32;
        self.values.par_extend(face.positions.par_iter().with_min_len(GRAIN).map(value));
        self.mesh.triangles.extend(face.triangles.iter().map(|t| t.map(|v| v + first as u32)));
        self.mesh.normals.resize(first + face.positions.len(), plane.normal.as_vec3().to_array());
        self.mesh.positions.extend(face.positions);
        self.faces.push(CutPlane {
            plane,
            vertices: first..self.mesh.positions.len(),
            triangles: first_triangle..self.mesh.triangles.len(),
        });
    }
}

/// A face before it is made: a grid in a plane that covers its part in the volume.
struct Face {
    plane: ClipPlane,
    /// Steps of the grid, world units.
    steps: [DVec3; 2],
    /// The first grid point.
    first: DVec3,
    /// Grid points along both steps: odd numbers.
    points: [usize; 2],
    /// What bounds the face: the removed sides do not belong to it. Only planes that cut the grid.
    limits: Vec<ClipPlane>,
}

impl Face {
    /// `None` if the plane has no part in the volume.
    fn new(volume: &Volume, region: &ClipRegion, k: usize) -> Option<Face> {
        let plane = region.planes()[k];
        let affine = volume.affine();
        let [min, max] = volume.bounds();
        let size = (max - min).length();
        let tolerance = NOTHING * size;
        let inverse = affine.linear.inverse();

        // The volume's own borders, and the other planes: a convex region is bounded where the others remove too,
        // what half-spaces cover where the others keep.
        let last = volume.dims().map(|n| (n - 1) as f64);
        let mut limits = Vec::new();
        for (axis, last) in last.into_iter().enumerate() {
            let row = inverse.row(axis);
            let offset = row.dot(affine.origin);
            limits.push(ClipPlane::new(row, last + offset).ok()?);
            limits.push(ClipPlane::new(-row, -offset).ok()?);
        }
        let corners =
            (0..8).map(|c| affine.point([0, 1, 2].map(|a| if c >> a & 1 == 1 { last[a] } else { 0.0 })));
        let (low, high) = corners
            .map(|p| plane.distance(p))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
        if low >= -tolerance || high <= tolerance {
            return None;
        }
        for other in region.planes().iter().filter(|other| **other != plane) {
            limits.push(if region.rule() == ClipRule::All { other.flipped() } else { *other });
        }

        // The grid follows the voxel axes that run along the plane most closely.
        let away = [0, 1, 2].map(|a| affine.linear.col(a).normalize_or_zero().dot(plane.normal).abs());
        let across = if away[0] >= away[1] && away[0] >= away[2] {
            0
        } else if away[1] >= away[2] {
            1
        } else {
            2
        };
        let u = affine.linear.col((across + 1) % 3);
        let u = (u - plane.normal * plane.normal.dot(u)).try_normalize()?;
        let axes = [u, plane.normal.cross(u)];
        // Half a voxel along the index that changes fastest.
        let mut steps = axes.map(|axis| 0.5 / (inverse * axis).abs().max_element());
        // Below the first voxel, so that along the axes grid points are voxels.
        let anchor = affine.origin - plane.normal * plane.distance(affine.origin);

        let domain = domain(&limits, anchor, axes, volume.center(), size, tolerance)?;
        let low = domain.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
        let high = domain.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
        let sides = high - low;
        if sides.min_element() <= tolerance {
            return None;
        }
        let count = |steps: [f64; 2]| (sides.x / steps[0] + 5.0) * (sides.y / steps[1] + 5.0);
        while count(steps) > MAX_POINTS {
            steps = steps.map(|s| 2.0 * s);
        }
        let (mut first, mut points) = (anchor, [0; 2]);
        for i in 0..2 {
            // Whole blocks of two steps: cells of the voxel lattice.
            let block = 2.0 * steps[i];
            let from = (low[i] / block + 1e-6).floor();
            let to = (high[i] / block - 1e-6).ceil().max(from + 1.0);
            first += axes[i] * (from * block);
            points[i] = 2 * (to - from) as usize + 1;
        }
        let steps = [axes[0] * steps[0], axes[1] * steps[1]];
        let mut face = Face { plane, steps, first, points, limits: Vec::new() };
        let far = [points[0] - 1, points[1] - 1];
        let corners = [[0, 0], [far[0], 0], [0, far[1]], far].map(|[i, j]| face.point(i, j));
        let cuts = |limit: &ClipPlane| corners.iter().any(|&p| limit.distance(p) > tolerance);
        face.limits = limits.into_iter().filter(cuts).collect();
        Some(face)
    }

    fn point(&self, i: usize, j: usize) -> DVec3 {
        self.first + self.steps[0] * i as f64 + self.steps[1] * j as f64
    }

    /// The triangles, relative to `origin`.
    fn mesh<T: Ordered>(&self, sampler: &Sampler<'_, T>, iso: f64, origin: [f64; 3]) -> RawMesh {
        let [nu, nv] = self.points;
        let row = |j: usize| {
            let height = move |i: usize| (sampler.strict(self.point(i, j)) - iso) as f32;
            (0..nu).into_par_iter().with_min_len(GRAIN).map(height)
        };
        let heights: Vec<f32> = (0..nv).into_par_iter().flat_map(row).collect();
        let start = self.first - DVec3::from_array(origin);
        let place = |i: f64, j: f64| (start + self.steps[0] * i + self.steps[1] * j).as_vec3().to_array();
        let mesh = RawMesh { origin, ..squares::march(&heights, self.points, place) };
        match ClipRegion::union(&self.limits) {
            Ok(outside) => clip(&mesh, &outside),
            Err(_) => RawMesh::default(),
        }
    }
}

/// The convex polygon in the plane, along `axes` from `anchor`, that all limits leave; `None` if they leave none.
fn domain(
    limits: &[ClipPlane],
    anchor: DVec3,
    axes: [DVec3; 2],
    center: DVec3,
    size: f64,
    tolerance: f64,
) -> Option<Vec<DVec2>> {
    let flat = |p: DVec3| DVec2::new(axes[0].dot(p), axes[1].dot(p));
    let middle = flat(center - anchor);
    let mut polygon: Vec<DVec2> = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|c| middle + size * DVec2::from_array(c))
        .to_vec();
    for limit in limits {
        let (slope, at_anchor) = (flat(limit.normal), limit.distance(anchor));
        let beyond = |p: DVec2| slope.dot(p) + at_anchor - tolerance;
        let mut next = Vec::with_capacity(polygon.len() + 1);
        for (i, &p) in polygon.iter().enumerate() {
            let q = polygon[(i + 1) % polygon.len()];
            let [dp, dq] = [p, q].map(beyond);
            if dp <= 0.0 {
                next.push(p);
            }
            if (dp <= 0.0) != (dq <= 0.0) {
                next.push(p.lerp(q, dp / (dp - dq)));
            }
        }
        polygon = next;
    }
    (polygon.len() >= 3).then_some(polygon)
}
