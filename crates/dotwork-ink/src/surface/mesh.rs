//! A triangle mesh as a carrier of stipples.
//!
//! One curve runs through the whole surface: through the triangles in Morton order of their centroids, and through
//! each triangle along Sierpiński's curve (repeated bisection). Candidate `i` of `M` sits where the area passed is
//! `(i + h(i))/M · A`. Candidates are thereby uniform by area and stratified, they do not know the tessellation, and
//! those that follow each other are neighbours in space, which is what makes their neighbour searches cheap.

use std::ops::{Deref, Range};

use dotwork_drawing::hash::{mix, unit};
use dotwork_mesh::Mesh;
use glam::{BVec4A, Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use super::{Place, StageDraw, Surface, hash_of};

/// A mesh, borrowed or shared, with its triangles in Morton order and the running sum of their areas.
pub struct MeshSurface<M> {
    mesh: M,
    /// Triangles in Morton order of their centroids.
    order: Vec<u32>,
    /// `cumulative[k]` is the area of the first `k` triangles of `order`; one longer than `order`.
    cumulative: Vec<f64>,
    min: Vec3,
    /// Boxes of each [`RUN`] triangles of `order`.
    boxes: Vec<[Vec3; 2]>,
}

/// Triangles that share a box: what lies elsewhere is passed over at once.
const RUN: usize = 32;

/// A piece of a triangle with no more candidates than this is not parted further to find those in a box.
const FEW: f64 = 24.0;

impl<M: Deref<Target = Mesh>> MeshSurface<M> {
    /// Sorts the triangles of `carrier` and sums their areas.
    pub fn new(carrier: M) -> MeshSurface<M> {
        let mesh: &Mesh = &carrier;
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
        let boxes = order
            .par_chunks(RUN)
            .map(|run| {
                let corners = run.iter().flat_map(|&t| mesh.triangles[t as usize]);
                let places = corners.map(|v| mesh.positions[v as usize]);
                places.fold([Vec3::MAX, Vec3::MIN], |[low, high], p| [low.min(p), high.max(p)])
            })
            .collect();
        MeshSurface { mesh: carrier, order, cumulative, min, boxes }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
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
        let levels = if area > 0.0 { ((area / step) as u64).checked_ilog2().map_or(1, |l| l + 2) } else { 0 };
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
        let mut bisect = |half: usize| {
            let middle = (ends + ends.zwxy()) * 0.5;
            // The first half runs from the begin to the apex, the second from the apex to the end. The bits are
            // random: selecting beats branching.
            ends = Vec4::select(HALVES[half], apex, ends);
            apex = middle;
        };
        let way = ((s - self.start) * self.inverse_area).clamp(0.0, 1.0);
        if self.levels <= 31 {
            // 31 bits of the way through the triangle; each chooses a half.
            let mut bits = (way * 2_147_483_647.0) as u32;
            for _ in 0..self.levels {
                bisect((bits >> 30 & 1) as usize);
                bits <<= 1;
            }
        } else {
            let mut bits = (way * (1u64 << 48) as f64) as u64;
            for _ in 0..self.levels.min(48) {
                bisect((bits >> 47 & 1) as usize);
                bits <<= 1;
            }
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

impl<M: Deref<Target = Mesh> + Sync> Surface for MeshSurface<M> {
    fn area(&self) -> f64 {
        self.cumulative[self.order.len()]
    }

    fn min_corner(&self) -> Vec3 {
        self.min
    }

    fn ranges_near(&self, draw: StageDraw, [low, high]: [Vec3; 2]) -> Vec<Range<u64>> {
        let meets = |[a, b]: [Vec3; 2]| a.cmple(high).all() && b.cmpge(low).all();
        let step = self.area() / draw.count as f64;
        let mut ranges: Vec<Range<u64>> = Vec::new();
        let mut add = |from: f64, to: f64| {
            // A candidate lies up to one step behind its number.
            let first = ((from / step).floor() - 1.0).max(0.0) as u64;
            let last = ((to / step).ceil() as u64).min(draw.count);
            match ranges.last_mut() {
                Some(before) if before.end >= first => before.end = before.end.max(last),
                _ => ranges.push(first..last),
            }
        };
        let mut stack = Vec::new();
        for (run, _) in self.boxes.iter().enumerate().filter(|(_, b)| meets(**b)) {
            for k in run * RUN..((run + 1) * RUN).min(self.order.len()) {
                let (from, to) = (self.cumulative[k], self.cumulative[k + 1]);
                let leg = self.leg(k, step);
                let place = |w: [f32; 2]| leg.a + leg.ab * w[0] + leg.ac * w[1];
                stack.push((leg.path.map(place), from, to));
                while let Some(([p, q, r], from, to)) = stack.pop() {
                    if !meets([p.min(q).min(r), p.max(q).max(r)]) {
                        continue;
                    }
                    if to - from <= FEW * step {
                        add(from, to);
                        continue;
                    }
                    let (middle, half) = ((p + r) * 0.5, 0.5 * (from + to));
                    // The first half is to come first.
                    stack.push(([q, middle, r], half, to));
                    stack.push(([p, middle, q], from, half));
                }
            }
        }
        ranges
    }

    fn visit(&self, draw: StageDraw, range: Range<u64>, sink: &mut impl FnMut(u64, Place)) {
        if range.is_empty() {
            return;
        }
        let step = self.area() / draw.count as f64;
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
            let [v, w] = leg.weights(s, hash_of(i, draw.seed ^ 0x5bd1_e995));
            let position = leg.a + leg.ab * v + leg.ac * w;
            sink(i, Place { position, normal, element: leg.element, weights: [v, w] });
        }
    }
}

/// The area that the curve has passed at candidate `index`.
#[inline(always)]
fn passed(draw: StageDraw, index: u64, step: f64) -> f64 {
    (index as f64 + f64::from(unit(hash_of(index, draw.seed)))) * step
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
    fn ranges_hold_all_candidates_of_a_box_and_few_others() {
        let mesh = square();
        let surface = MeshSurface::new(&mesh);
        // Far more than a number of 32 bits in the last case, of which few are looked at.
        for (count, corners) in [
            (40_000u64, [Vec3::new(0.05, 0.2, -0.1), Vec3::new(0.3, 0.45, 0.1)]),
            (40_000, [Vec3::new(2.0, 0.0, 0.0), Vec3::new(3.0, 1.0, 1.0)]),
            (9_000_000_000, [Vec3::new(0.5, 0.5, -0.1), Vec3::new(0.5005, 0.5005, 0.1)]),
        ] {
            let draw = StageDraw { count, seed: 3 };
            let ranges = surface.ranges_near(draw, corners);
            assert!(
                ranges.windows(2).all(|w| w[0].end < w[1].start) && ranges.iter().all(|r| r.end <= count)
            );
            let within = |p: Vec3| p.cmpge(corners[0]).all() && p.cmple(corners[1]).all();
            let mut inside = 0u64;
            for range in ranges.clone() {
                surface.visit(draw, range, &mut |_, p| inside += u64::from(within(p.position)));
            }
            let looked_at: u64 = ranges.iter().map(|r| r.end - r.start).sum();
            let size = corners[1] - corners[0];
            let expected =
                count as f64 * f64::from(size.x * size.y) * f64::from(u8::from(corners[0].x < 1.0));
            assert!((inside as f64 - expected).abs() <= 0.03 * expected, "{inside} of {expected}");
            assert!(looked_at as f64 <= 1.5 * expected + 100.0, "{looked_at} for {inside}");
            if count < 100_000 {
                let mut all = 0;
                surface.visit(draw, 0..count, &mut |_, p| all += u64::from(within(p.position)));
                assert_eq!(inside, all);
            }
        }
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
