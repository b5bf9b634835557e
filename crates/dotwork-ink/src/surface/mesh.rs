//! A triangle mesh as a carrier of stipples.
//!
//! One curve runs through the whole surface: through the triangles in Morton order of their centroids, and through
//! each triangle along Sierpiński's curve (repeated bisection). Candidate `i` of `M` sits where the area passed is
//! `(i + h(i))/M · A`. Candidates are thereby uniform by area and stratified, they do not know the tessellation, and
//! those that follow each other are neighbours in space, which is what makes their neighbour searches cheap.

use std::ops::Range;

use dotwork_drawing::hash::{hash2, mix, unit};
use dotwork_mesh::Mesh;
use glam::{BVec4A, Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use super::{Place, StageDraw, Surface};

/// A mesh with its triangles in Morton order and the running sum of their areas.
pub struct MeshSurface<'a> {
    mesh: &'a Mesh,
    /// Triangles in Morton order of their centroids.
    order: Vec<u32>,
    /// `cumulative[k]` is the area of the first `k` triangles of `order`; one longer than `order`.
    cumulative: Vec<f64>,
    min: Vec3,
}

impl<'a> MeshSurface<'a> {
    /// Sorts the triangles of `mesh` and sums their areas.
    pub fn new(mesh: &'a Mesh) -> MeshSurface<'a> {
        let (min, max) = mesh
            .positions
            .par_iter()
            .fold(|| (Vec3::MAX, Vec3::MIN), |(a, b), p| (a.min(*p), b.max(*p)))
            .reduce(|| (Vec3::MAX, Vec3::MIN), |(a, b), (c, d)| (a.min(c), b.max(d)));
        let scale = 1023.0 / (max - min).max_element().max(f32::MIN_POSITIVE);
        let mut keyed: Vec<u64> = mesh
            .triangles
            .par_iter()
            .enumerate()
            .map(|(t, tri)| {
                let [a, b, c] = tri.map(|v| mesh.positions[v as usize]);
                let cell = ((a + b + c) / 3.0 - min) * scale;
                u64::from(morton(cell.x as u32, cell.y as u32, cell.z as u32)) << 32 | t as u64
            })
            .collect();
        keyed.par_sort_unstable();
        let order: Vec<u32> = keyed.iter().map(|k| *k as u32).collect();
        let areas: Vec<f64> = order
            .par_iter()
            .map(|&t| {
                let [a, b, c] = mesh.triangles[t as usize].map(|v| mesh.positions[v as usize].as_dvec3());
                0.5 * (b - a).cross(c - a).length()
            })
            .collect();
        let mut cumulative = Vec::with_capacity(order.len() + 1);
        let mut sum = 0.0;
        cumulative.push(0.0);
        for a in areas {
            sum += a;
            cumulative.push(sum);
        }
        MeshSurface { mesh, order, cumulative, min }
    }

    /// Everything about the `k`-th triangle of the curve that its candidates need.
    #[inline]
    fn leg(&self, k: usize, step: f64) -> Leg {
        let element = self.order[k];
        let [a, b, c] = self.mesh.triangles[element as usize].map(|v| self.mesh.positions[v as usize]);
        let (ab, ac) = (b - a, c - a);
        // The curve runs along the longest side; its apex is the vertex opposite.
        let sides = [ac.length_squared(), ab.length_squared(), (c - b).length_squared()];
        const CORNERS: [[f32; 2]; 3] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let path = if sides[0] >= sides[1] && sides[0] >= sides[2] {
            [CORNERS[0], CORNERS[1], CORNERS[2]]
        } else if sides[1] >= sides[2] {
            [CORNERS[0], CORNERS[2], CORNERS[1]]
        } else {
            [CORNERS[1], CORNERS[0], CORNERS[2]]
        };
        let area = self.cumulative[k + 1] - self.cumulative[k];
        // Bisected until the pieces are about half a candidate's share.
        let levels = if area > 0.0 { ((area / step) as u32).checked_ilog2().map_or(1, |l| l + 2) } else { 0 };
        Leg {
            element,
            a,
            ab,
            ac,
            path,
            start: self.cumulative[k],
            inverse_area: 1.0 / area.max(f64::MIN_POSITIVE),
            levels,
        }
    }
}

/// The curve's way through one triangle.
struct Leg {
    element: u32,
    a: Vec3,
    ab: Vec3,
    ac: Vec3,
    /// Barycentric corners: begin, apex, end.
    path: [[f32; 2]; 3],
    start: f64,
    inverse_area: f64,
    levels: u32,
}

/// Which of begin (first two lanes) and end (last two) the apex replaces in the first and in the second half.
const HALVES: [BVec4A; 2] = [BVec4A::new(false, false, true, true), BVec4A::new(true, true, false, false)];

impl Leg {
    /// Barycentric coordinates where the area passed is `s`, spread over the last piece by the hash `h`.
    #[inline(always)]
    fn weights(&self, s: f64, h: u32) -> [f32; 2] {
        let [p, q, r] = self.path;
        // Begin and end side by side, the apex twice: a bisection is a handful of vector instructions.
        let mut ends = Vec4::new(p[0], p[1], r[0], r[1]);
        let mut apex = Vec4::new(q[0], q[1], q[0], q[1]);
        // 31 bits of the way through the triangle; each chooses a half.
        let mut bits = (((s - self.start) * self.inverse_area).clamp(0.0, 1.0) * 2_147_483_647.0) as u32;
        for _ in 0..self.levels.min(31) {
            let middle = (ends + ends.zwxy()) * 0.5;
            // The first half runs from the begin to the apex, the second from the apex to the end. The bits are
            // random: selecting beats branching.
            ends = Vec4::select(HALVES[(bits >> 30 & 1) as usize], apex, ends);
            apex = middle;
            bits <<= 1;
        }
        let (p, q, r) = ([ends.x, ends.y], [apex.x, apex.y], [ends.z, ends.w]);
        let u = unit(h).sqrt();
        let t = unit(mix(h ^ 0x68bc_21eb));
        let (wq, wr) = (u * (1.0 - t), u * t);
        [0, 1].map(|k| p[k] + (q[k] - p[k]) * wq + (r[k] - p[k]) * wr)
    }
}

/// Interleaves the low ten bits of three numbers.
fn morton(x: u32, y: u32, z: u32) -> u32 {
    let spread = |v: u32| {
        let mut v = v & 0x3ff;
        v = (v | v << 16) & 0x0300_00ff;
        v = (v | v << 8) & 0x0300_f00f;
        v = (v | v << 4) & 0x030c_30c3;
        (v | v << 2) & 0x0924_9249
    };
    spread(x) | spread(y) << 1 | spread(z) << 2
}

impl Surface for MeshSurface<'_> {
    fn area(&self) -> f64 {
        self.cumulative[self.order.len()]
    }

    fn min_corner(&self) -> Vec3 {
        self.min
    }

    fn visit(&self, draw: StageDraw, range: Range<u32>, sink: &mut impl FnMut(u32, Place)) {
        if range.is_empty() {
            return;
        }
        let step = self.area() / f64::from(draw.count);
        let last = self.order.len() - 1;
        let first = passed(draw, range.start, step);
        let mut k = self.cumulative.partition_point(|&c| c <= first).saturating_sub(1).min(last);
        let mut leg = self.leg(k, step);
        let mut normal = leg.ab.cross(leg.ac).normalize_or_zero();
        for i in range {
            let s = passed(draw, i, step);
            if k < last && self.cumulative[k + 1] <= s {
                while k < last && self.cumulative[k + 1] <= s {
                    k += 1;
                }
                leg = self.leg(k, step);
                normal = leg.ab.cross(leg.ac).normalize_or_zero();
            }
            let [v, w] = leg.weights(s, hash2(i, draw.seed ^ 0x5bd1_e995));
            let position = leg.a + leg.ab * v + leg.ac * w;
            sink(i, Place { position, normal, element: leg.element, weights: [v, w] });
        }
    }
}

/// The area that the curve has passed at candidate `index`.
#[inline(always)]
fn passed(draw: StageDraw, index: u32, step: f64) -> f64 {
    (f64::from(index) + f64::from(unit(hash2(index, draw.seed)))) * step
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::Warnings;
    use dotwork_mesh::{MeshOptions, RawMesh};

    /// A unit square as one small and one large triangle strip, so that areas are uneven.
    fn square() -> Mesh {
        let raw = RawMesh {
            positions: vec![
                [0.0, 0.0, 0.0],
                [0.1, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.1, 1.0, 0.0],
                [0.0, 1.0, 0.0],
            ],
            triangles: vec![[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]],
            ..RawMesh::default()
        };
        Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap()
    }

    #[test]
    fn candidates_are_uniform_by_area_and_independent_of_ranges() {
        let mesh = square();
        let surface = MeshSurface::new(&mesh);
        assert!((surface.area() - 1.0).abs() < 1e-6);
        let draw = StageDraw { count: 40_000, seed: 3 };
        let mut whole = Vec::new();
        surface.visit(draw, 0..draw.count, &mut |i, p| whole.push((i, p)));
        let mut parts = Vec::new();
        for start in (0..draw.count).step_by(7777) {
            surface.visit(draw, start..(start + 7777).min(draw.count), &mut |i, p| parts.push((i, p)));
        }
        assert_eq!(whole, parts);
        // Counts in a 5 × 5 grid: 1600 each; stratified sampling spreads less than Poisson's 40.
        let mut counts = [0i32; 25];
        for (_, p) in &whole {
            counts[(p.position.x * 5.0).min(4.0) as usize + 5 * (p.position.y * 5.0).min(4.0) as usize] += 1;
        }
        for c in counts {
            assert!((c - 1600).abs() < 160, "{counts:?}");
        }
    }
}
