//! Silhouette curves from the voxels of a volume, without a surface.
//!
//! Lu et al., "Non-photorealistic volume rendering using stippling techniques" (2002, section 5.6): a Laplacian of
//! Gaussian is taken once, and in each frame a voxel belongs to a silhouette if it satisfies three criteria,
//!
//! ```text
//! |LoG| ≤ t_log,   |n·E| < t_eye,   |G| > t_grad
//! ```
//!
//! with the gradient G, its direction n and the eye vector E. Where the sign of the Laplacian changes between
//! neighbours, the zero lies between their centres and the values at these say little: the nearer of the two counts as
//! 0, so that curves have no gaps however small `t_log` is. A larger one makes them thicker.
//!
//! What is drawn is, by [`CurvesMethod::Segment`], a line through the voxel's centre along `G × E`, one edge long;
//! or by [`CurvesMethod::Search`], after the paper's exhaustive search of the 3 × 3 × 3 neighbourhood, lines from centre
//! to centre of neighbours that satisfy the criteria both. The paper says no more about it; where a silhouette is
//! several voxels wide all such lines are a net, and only those are taken here that run along the curve: within 45° of
//! `G × E` on the page.
//!
//! All that does not depend on the eye is in [`VoxelCurves`], so that another view, `t_eye`, or stricter values of the
//! others cost a pass over its arrays.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::lines::Eye;
use crate::params::{CurvesMethod, Style};
use crate::stock::Vectors;

/// Voxels a task looks at.
const CHUNK: usize = 8192;

/// Voxels that are looked at together.
const BLOCK: usize = 64;

/// Least cosine between a line of a search and the curve: 45°. A row of voxels steps by as much from one column to the
/// next, and less would leave gaps there.
const ALONG: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// Bits of a piece's id below the voxel's number.
const PIECE_BITS: u32 = 4;

/// Ids of pieces are less than this.
pub const MAX_PIECE_ID: u64 = 1 << (u32::BITS + PIECE_BITS);

/// The grid of a volume in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Voxels along the three axes, 2³² in all at most.
    pub dims: [u32; 3],
    /// Centre of the first voxel, object units.
    pub origin: DVec3,
    /// From a voxel to the next along each axis, object units.
    pub edges: [DVec3; 3],
}

impl Lattice {
    /// Number of voxels; `None` beyond 2³².
    pub fn voxels(&self) -> Option<u64> {
        let [x, y, z] = self.dims.map(u64::from);
        x.checked_mul(y)?.checked_mul(z).filter(|&n| n <= 1 << u32::BITS)
    }

    /// The place along the three axes of a voxel's number, which counts along x first.
    #[inline(always)]
    fn cell(&self, voxel: u32) -> [u32; 3] {
        let [nx, ny, _] = self.dims.map(|n| n.max(1));
        let row = voxel / nx;
        [voxel % nx, row % ny, row / ny]
    }

    /// Centre of a voxel, object units.
    pub fn place(&self, voxel: u32) -> Vec3 {
        let [x, y, z] = self.cell(voxel).map(f64::from);
        let [a, b, c] = self.edges;
        (self.origin + a * x + b * y + c * z).as_vec3()
    }

    /// The mean edge: that of a cube of a voxel's volume, object units.
    pub fn edge(&self) -> f32 {
        let [a, b, c] = self.edges;
        a.cross(b).dot(c).abs().cbrt() as f32
    }
}

/// What does not depend on the eye: the voxels that may be part of a silhouette, in structure-of-arrays form.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelCurves {
    /// Where voxels are.
    pub lattice: Lattice,
    /// Numbers of the voxels, rising; see [`Lattice::place`].
    pub voxel: Vec<u32>,
    /// Their centres, object units.
    pub position: Vectors,
    /// Unit normals, against the gradient.
    pub normal: Vectors,
    /// Lengths of the gradients over that of the volume's longest, 0…1.
    pub magnitude: Vec<f32>,
    /// Absolute values of the Laplacian over the volume's largest, 0…1; 0 where it changes its sign.
    pub laplacian: Vec<f32>,
    /// The voxels are all of those with these or stricter criteria,
    pub t_log: f32,
    /// as here.
    pub t_grad: f32,
    /// But gradients up to this length are left out, 0…1: more than `t_grad` if there were too many voxels.
    pub least: f32,
}

impl VoxelCurves {
    /// Without voxels.
    pub fn none(lattice: Lattice, t_log: f32, t_grad: f32) -> VoxelCurves {
        VoxelCurves {
            lattice,
            voxel: Vec::new(),
            position: Vectors::default(),
            normal: Vectors::default(),
            magnitude: Vec::new(),
            laplacian: Vec::new(),
            t_log,
            t_grad,
            least: t_grad,
        }
    }

    /// Finds the positions of the voxels, as after a change of the lattice's origin.
    pub fn settle(&mut self) {
        let (lattice, voxel) = (self.lattice, &self.voxel);
        self.position = Vectors::collect(voxel.len(), |i| lattice.place(voxel[i]));
    }

    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.voxel.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.voxel.is_empty()
    }

    /// Whether what these criteria choose is all there.
    pub fn holds(&self, criteria: &Criteria) -> bool {
        criteria.t_log <= self.t_log && criteria.t_grad >= self.t_grad
    }

    /// Calls `sink` for each piece of a curve that begins at the voxels `chosen[part]`. `chosen` are places in the arrays,
    /// as from [`Chosen::find`].
    pub fn pieces(
        &self,
        method: CurvesMethod,
        eye: Eye,
        chosen: &[u32],
        part: Range<usize>,
        mut sink: impl FnMut(Piece),
    ) {
        match method {
            CurvesMethod::Segment => {
                let half = 0.5 * self.lattice.edge();
                for &i in &chosen[part] {
                    let (at, normal) = self.at(i);
                    if let Some(along) = normal.cross(eye.from(at)).try_normalize() {
                        let ends = [at - along * half, at + along * half];
                        let id = u64::from(self.voxel[i as usize]) << PIECE_BITS;
                        sink(Piece { ends, normal, id });
                    }
                }
            }
            CurvesMethod::Search => self.search(eye, chosen, part, sink),
        }
    }

    #[inline(always)]
    fn at(&self, i: u32) -> (Vec3, Vec3) {
        (self.position.at(i as usize), self.normal.at(i as usize))
    }

    /// The lines from the voxels of `part` to neighbours that come later. Those of a row lie together in `chosen`, and the
    /// rows looked at move on with the voxel: one place for each of them is remembered, and nothing is looked up.
    fn search(&self, eye: Eye, chosen: &[u32], part: Range<usize>, mut sink: impl FnMut(Piece)) {
        let [nx, ny, nz] = self.lattice.dims.map(i64::from);
        let number = |k: usize| i64::from(self.voxel[chosen[k] as usize]);
        // Steps along y and z.
        const ROWS: [[i64; 2]; 5] = [[0, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];
        let mut next = [part.start; 5];
        for k in part {
            let voxel = number(k);
            let [x, y, z] = self.lattice.cell(voxel as u32).map(i64::from);
            let (here, normal) = self.at(chosen[k]);
            let sight = eye.from(here);
            let along = normal.cross(sight).normalize_or_zero();
            for (row, [dy, dz]) in ROWS.into_iter().enumerate() {
                if y + dy < 0 || y + dy >= ny || z + dz >= nz {
                    continue;
                }
                let middle = voxel + nx * (dy + ny * dz);
                let first = if row == 0 { voxel + 1 } else { middle - i64::from(x > 0) };
                let last = middle + i64::from(x + 1 < nx);
                while next[row] < chosen.len() && number(next[row]) < first {
                    next[row] += 1;
                }
                let mut other = next[row];
                while other < chosen.len() && number(other) <= last {
                    let (there, its_normal) = self.at(chosen[other]);
                    let way = there - here;
                    // As it is seen on the page.
                    let flat = way - sight * (way.dot(sight) / sight.length_squared());
                    let runs_along = flat.dot(along).abs() >= ALONG * flat.length();
                    // The two sides of a thin wall are no neighbours.
                    if runs_along && flat != Vec3::ZERO && normal.dot(its_normal) > 0.0 {
                        let place = 3 * row as u64 + (number(other) - middle + 1) as u64;
                        let id = (voxel as u64) << PIECE_BITS | place;
                        sink(Piece { ends: [here, there], normal: normal + its_normal, id });
                    }
                    other += 1;
                }
            }
        }
    }
}

/// What a voxel must satisfy; see the text of the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criteria {
    /// Largest absolute value of the Laplacian, 0…1.
    pub t_log: f32,
    /// Largest cosine between normal and eye, not reached.
    pub t_eye: f32,
    /// Smallest length of the gradient, 0…1, not reached.
    pub t_grad: f32,
}

impl Criteria {
    /// Those of a style.
    pub fn of(style: &Style) -> Criteria {
        Criteria { t_log: style.t_log, t_eye: style.t_eye, t_grad: style.t_grad }
    }
}

/// A piece of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Its ends, object units.
    pub ends: [Vec3; 2],
    /// The direction in which the form ends, not of unit length.
    pub normal: Vec3,
    /// The same in every view and with all criteria, less than [`MAX_PIECE_ID`].
    pub id: u64,
}

/// The voxels of a silhouette. Memory is kept from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct Chosen {
    found: Vec<Vec<u32>>,
    all: Vec<u32>,
}

impl Chosen {
    /// Finds the voxels that satisfy the criteria as seen from `eye`, as places in the arrays, rising.
    pub fn find(&mut self, curves: &VoxelCurves, criteria: &Criteria, eye: Eye) -> &[u32] {
        let chunks = curves.len().div_ceil(CHUNK);
        self.found.resize_with(chunks.max(self.found.len()), Vec::new);
        self.found[..chunks].par_iter_mut().enumerate().for_each(|(c, found)| {
            found.clear();
            let end = ((c + 1) * CHUNK).min(curves.len());
            for from in (c * CHUNK..end).step_by(BLOCK) {
                choose(curves, criteria, eye, from..(from + BLOCK).min(end), found);
            }
        });
        self.all.clear();
        self.found[..chunks].iter().for_each(|found| self.all.extend_from_slice(found));
        &self.all
    }
}

/// Appends those of at most [`BLOCK`] voxels that satisfy the criteria.
#[inline]
fn choose(curves: &VoxelCurves, criteria: &Criteria, eye: Eye, block: Range<usize>, found: &mut Vec<u32>) {
    let first = block.start as u32;
    let (p, n) = (&curves.position, &curves.normal);
    let [px, py, pz] = [&p.x[block.clone()], &p.y[block.clone()], &p.z[block.clone()]];
    let [gx, gy, gz] = [&n.x[block.clone()], &n.y[block.clone()], &n.z[block.clone()]];
    let (length, bent) = (&curves.magnitude[block.clone()], &curves.laplacian[block]);
    let count = px.len();
    let most = criteria.t_eye * criteria.t_eye;
    let mut keep = [false; BLOCK];
    // Both ends of a product of squares: no root is taken.
    for i in 0..count {
        let e = eye.from(Vec3::new(px[i], py[i], pz[i]));
        let along = e.x * gx[i] + e.y * gy[i] + e.z * gz[i];
        let strict = (along * along < most * e.length_squared()) & (length[i] > criteria.t_grad);
        keep[i] = strict & (bent[i] <= criteria.t_log);
    }
    found.extend((0..count as u32).filter(|&i| keep[i as usize]).map(|i| first + i));
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::hash::{hash3, unit};
    use std::collections::HashSet;

    const DIMS: [u32; 3] = [7, 5, 6];

    /// Voxels of a small grid at random, with normals about one direction.
    fn some(seed: u32, share: f32) -> VoxelCurves {
        let lattice = Lattice {
            dims: DIMS,
            origin: DVec3::new(-3.0, 1.0, 2.0),
            edges: [DVec3::new(1.1, 0.1, 0.0), DVec3::Y, DVec3::Z * 0.9],
        };
        let mut curves = VoxelCurves::none(lattice, 1.0, 0.0);
        let random = |i: u32, k: u32| unit(hash3(i, k, seed));
        let count = lattice.voxels().unwrap() as u32;
        for i in (0..count).filter(|&i| random(i, 0) < share) {
            curves.voxel.push(i);
            let v = Vec3::new(random(i, 1) - 0.5, random(i, 2) - 0.5, random(i, 3) - 0.2).normalize();
            curves.normal.x.push(v.x);
            curves.normal.y.push(v.y);
            curves.normal.z.push(v.z);
            curves.magnitude.push(random(i, 4));
            curves.laplacian.push(random(i, 5));
        }
        curves.settle();
        curves
    }

    const EYES: [Eye; 2] = [Eye::Towards(Vec3::new(0.6, 0.0, 0.8)), Eye::At(Vec3::new(9.0, 20.0, 4.0))];

    #[test]
    fn places_follow_the_grid() {
        let curves = some(1, 1.0);
        let [nx, ny, _] = DIMS;
        let at = curves.position.at((2 + nx * (3 + ny * 4)) as usize);
        assert!(at.distance(Vec3::new(-3.0 + 2.2, 1.0 + 0.2 + 3.0, 2.0 + 3.6)) < 1e-5);
        assert!((curves.lattice.edge() - 0.99f32.cbrt()).abs() < 1e-6);
        assert_eq!(Lattice { dims: [1 << 16, 1 << 16, 2], ..curves.lattice }.voxels(), None);
    }

    #[test]
    fn chosen_is_what_satisfies_the_criteria() {
        let curves = some(2, 1.0);
        let mut chosen = Chosen::default();
        for eye in EYES {
            for (t_log, t_eye, t_grad) in [(0.5, 0.6, 0.1), (1.0, 0.1, 0.0), (0.2, 1.0, 0.9), (1.0, 1.0, 0.0)]
            {
                let expected: Vec<u32> = (0..curves.len())
                    .filter(|&i| {
                        let (at, n) = (curves.position.at(i), curves.normal.at(i));
                        n.dot(eye.from(at).normalize()).abs() < t_eye
                            && curves.laplacian[i] <= t_log
                            && curves.magnitude[i] > t_grad
                    })
                    .map(|i| i as u32)
                    .collect();
                assert_eq!(chosen.find(&curves, &Criteria { t_log, t_eye, t_grad }, eye), expected);
                assert!(!expected.is_empty());
            }
        }
    }

    #[test]
    fn segments_run_through_the_centre_across_normal_and_sight() {
        let curves = some(3, 0.5);
        let chosen: Vec<u32> = (0..curves.len() as u32).collect();
        for eye in EYES {
            let mut all = Vec::new();
            curves.pieces(CurvesMethod::Segment, eye, &chosen, 0..chosen.len(), |piece| all.push(piece));
            assert_eq!(all.len(), curves.len());
            for (i, Piece { ends: [a, b], normal, .. }) in all.iter().enumerate() {
                let at = curves.position.at(i);
                assert!((*a + *b).distance(2.0 * at) < 1e-5 && *normal == curves.normal.at(i));
                assert!(((*b - *a).length() - curves.lattice.edge()).abs() < 1e-5);
                assert!((*b - *a).dot(*normal).abs() < 1e-5);
                assert!((*b - *a).dot(eye.from(at).normalize()).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn the_search_finds_each_pair_of_neighbours_once_however_it_is_shared_out() {
        for (seed, share) in [(4, 1.0), (5, 0.5), (6, 0.1)] {
            let curves = some(seed, share);
            // Some of them.
            let chosen: Vec<u32> = (0..curves.len() as u32).filter(|i| i % 5 != 2).collect();
            for eye in EYES {
                let mut expected = Vec::new();
                for (k, &i) in chosen.iter().enumerate() {
                    for &j in &chosen[k + 1..] {
                        let [a, b] = [i, j].map(|i| curves.lattice.cell(curves.voxel[i as usize]));
                        let near = (0..3).all(|axis| a[axis].abs_diff(b[axis]) <= 1);
                        let [(p, n), (q, m)] = [i, j].map(|i| curves.at(i));
                        let sight = eye.from(p).normalize();
                        let way = (q - p) - sight * (q - p).dot(sight);
                        let cosine = way.normalize_or_zero().dot(n.cross(sight).normalize()).abs();
                        assert!((cosine - ALONG).abs() > 1e-6, "rounding decides");
                        if near && cosine >= ALONG && n.dot(m) > 0.0 {
                            expected.push([p, q]);
                        }
                    }
                }
                for size in [usize::MAX, 7] {
                    let mut all: Vec<Piece> = Vec::new();
                    for from in (0..chosen.len()).step_by(size.min(chosen.len())) {
                        let part = from..from.saturating_add(size).min(chosen.len());
                        curves.pieces(CurvesMethod::Search, eye, &chosen, part, |piece| all.push(piece));
                    }
                    let ids: HashSet<u64> = all.iter().map(|piece| piece.id).collect();
                    assert!(ids.len() == all.len() && ids.iter().all(|&id| id < MAX_PIECE_ID));
                    let key = |ends: &[Vec3; 2]| ends.map(|p| p.to_array().map(f32::to_bits));
                    let mut found: Vec<_> = all.iter().map(|piece| key(&piece.ends)).collect();
                    let mut expected: Vec<_> = expected.iter().map(key).collect();
                    found.sort();
                    expected.sort();
                    assert_eq!(found, expected);
                    assert!(found.len() > chosen.len() / 10);
                }
            }
        }
    }

    #[test]
    fn the_same_on_any_number_of_threads() {
        let curves = some(7, 1.0);
        let criteria = Criteria { t_log: 1.0, t_eye: 0.7, t_grad: 0.2 };
        let find = || Chosen::default().find(&curves, &criteria, EYES[0]).to_vec();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(pool.install(find), find());
    }
}
