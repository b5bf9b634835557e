//! Points sorted into cells of a uniform grid, for neighbour queries within one cell size.
//!
//! Blocks of 4 × 4 × 4 cells are hashed, so memory follows the number of points and not the size of the bounding box;
//! inside a block cells keep their order, so neighbours in space are neighbours in memory. Two blocks that share a
//! place in the table cost time and never correctness: every user tests distances, and meeting a point twice changes
//! nothing.

use glam::Vec3;

/// A point as neighbour searches want it: position and normal in 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Site {
    pub position: [f32; 3],
    /// Unit normal as three signed bytes, ×127.
    pub normal: [i8; 4],
}

impl Site {
    #[inline(always)]
    pub fn new(position: Vec3, normal: Vec3) -> Site {
        let n = normal * 127.0;
        Site { position: position.to_array(), normal: [n.x as i8, n.y as i8, n.z as i8, 0] }
    }

    #[inline(always)]
    pub fn distance_squared(&self, p: [f32; 3]) -> f32 {
        let [x, y, z] = self.position;
        let (dx, dy, dz) = (x - p[0], y - p[1], z - p[2]);
        dx * dx + dy * dy + dz * dz
    }

    /// True if two places see each other: the two sides of a thin sheet (cosine of the normals ≤ −0.3) do not, the
    /// two sides of a box's edge (cosine 0) do.
    #[inline(always)]
    pub fn compatible(&self, n: [i8; 4]) -> bool {
        let dot = i32::from(self.normal[0]) * i32::from(n[0])
            + i32::from(self.normal[1]) * i32::from(n[1])
            + i32::from(self.normal[2]) * i32::from(n[2]);
        // −0.3 · 127²
        dot > -4839
    }
}

/// Cells a side of a block, as a power of two.
const BLOCK_BITS: i32 = 2;
const BLOCK_MASK: i32 = (1 << BLOCK_BITS) - 1;
/// Cells of a block.
pub(super) const BLOCK_CELLS: u32 = 1 << (3 * BLOCK_BITS);

/// The grid: where a place falls, and which bucket that is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    min: Vec3,
    inverse_cell: f32,
    block_mask: u32,
}

impl Grid {
    /// A grid of cells of side `cell` for about `points` points.
    pub fn new(min: Vec3, cell: f32, points: usize) -> Grid {
        // A block of a surface holds some twenty cells and more points: a table of points / 8 blocks is sparse.
        let block_mask = (points.max(4096) / 8).next_power_of_two().min(1 << 24) as u32 - 1;
        Grid { min, inverse_cell: 1.0 / cell, block_mask }
    }

    #[inline(always)]
    pub fn cell(&self, p: [f32; 3]) -> [i32; 3] {
        // Casts saturate: a place outside the box or a NaN lands in some cell.
        [
            ((p[0] - self.min.x) * self.inverse_cell) as i32,
            ((p[1] - self.min.y) * self.inverse_cell) as i32,
            ((p[2] - self.min.z) * self.inverse_cell) as i32,
        ]
    }

    /// The share that block coordinate `v` along `axis` has in the block's hash.
    #[inline(always)]
    fn part(axis: usize, v: i32) -> u32 {
        const FACTORS: [u32; 3] = [0x8da6_b343, 0xd816_3841, 0xcb1a_b31f];
        ((v >> BLOCK_BITS) as u32).wrapping_mul(FACTORS[axis])
    }

    /// First bucket of the block whose parts combine to `h`.
    #[inline(always)]
    fn block(&self, h: u32) -> u32 {
        ((h ^ (h >> 15)) & self.block_mask) * BLOCK_CELLS
    }

    /// The cell's number inside its block, below [`BLOCK_CELLS`].
    #[inline(always)]
    pub fn inside([x, y, z]: [i32; 3]) -> u32 {
        ((x & BLOCK_MASK) | (y & BLOCK_MASK) << BLOCK_BITS | (z & BLOCK_MASK) << (2 * BLOCK_BITS)) as u32
    }

    #[inline(always)]
    pub fn bucket(&self, [x, y, z]: [i32; 3]) -> u32 {
        self.block(Self::part(0, x) ^ Self::part(1, y) ^ Self::part(2, z)) + Self::inside([x, y, z])
    }

    pub fn bucket_count(&self) -> usize {
        (self.block_mask as usize + 1) * BLOCK_CELLS as usize
    }
}

/// Where each bucket's points begin in an array sorted by bucket.
#[derive(Default)]
pub(super) struct Starts(Vec<u32>);

impl Starts {
    /// Counts `buckets` (one entry a point) and returns for each point its place in the sorted array. Points of one
    /// bucket keep their order.
    pub fn sort(grid: &Grid, buckets: &[u32]) -> (Starts, Vec<u32>) {
        let n = grid.bucket_count();
        let mut starts = vec![0u32; n + 1];
        for &b in buckets {
            starts[b as usize] += 1;
        }
        let mut sum = 0;
        for c in &mut starts {
            sum += std::mem::replace(c, sum);
        }
        let places = buckets
            .iter()
            .map(|&b| {
                let place = starts[b as usize];
                starts[b as usize] += 1;
                place
            })
            .collect();
        // The starts have moved to the ends: shift them back by one bucket.
        starts.copy_within(0..n, 1);
        starts[0] = 0;
        (Starts(starts), places)
    }

    /// The points of one bucket.
    #[inline(always)]
    pub fn bucket(&self, b: u32) -> std::ops::Range<usize> {
        self.0[b as usize] as usize..self.0[b as usize + 1] as usize
    }

    /// Calls `f` with each run of points in the 27 cells around `cell`; stops when `f` returns false.
    #[inline(always)]
    pub fn around(
        &self,
        grid: &Grid,
        [x, y, z]: [i32; 3],
        mut f: impl FnMut(std::ops::Range<usize>) -> bool,
    ) -> bool {
        // The own row first: it holds the nearest points.
        const ROWS: [(usize, usize); 9] =
            [(1, 1), (0, 1), (2, 1), (1, 0), (1, 2), (0, 0), (2, 0), (0, 2), (2, 2)];
        // A row of three cells is one run of buckets, or two where it leaves the block.
        let low = x - 1;
        let split = BLOCK_MASK - (low & BLOCK_MASK);
        let (first_part, second_part) = (Grid::part(0, low), Grid::part(0, x + 1));
        let ys = [y - 1, y, y + 1].map(|y| (Grid::part(1, y), Grid::inside([0, y, 0])));
        let zs = [z - 1, z, z + 1].map(|z| (Grid::part(2, z), Grid::inside([0, 0, z])));
        for (j, k) in ROWS {
            let (parts, inside) = (ys[j].0 ^ zs[k].0, ys[j].1 | zs[k].1);
            let bucket = grid.block(first_part ^ parts) + inside + (low & BLOCK_MASK) as u32;
            let first = self.run(bucket, split.min(2) as u32);
            if !first.is_empty() && !f(first) {
                return false;
            }
            if split < 2 {
                let second = self.run(grid.block(second_part ^ parts) + inside, 1 - split as u32);
                if !second.is_empty() && !f(second) {
                    return false;
                }
            }
        }
        true
    }

    /// The points of `bucket` and of the `more` buckets after it.
    #[inline(always)]
    fn run(&self, bucket: u32, more: u32) -> std::ops::Range<usize> {
        self.0[bucket as usize] as usize..self.0[(bucket + more) as usize + 1] as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::hash::{hash2, unit};

    #[test]
    fn neighbours_agree_with_brute_force() {
        let n = 3000u32;
        let points: Vec<[f32; 3]> =
            (0..n).map(|i| [0, 1, 2].map(|k| unit(hash2(i, k)) * if k == 2 { 0.2 } else { 1.0 })).collect();
        let cell = 0.05;
        let grid = Grid::new(Vec3::ZERO, cell, points.len());
        let buckets: Vec<u32> = points.iter().map(|p| grid.bucket(grid.cell(*p))).collect();
        let (starts, places) = Starts::sort(&grid, &buckets);
        let mut sorted = vec![[0.0f32; 3]; points.len()];
        for (p, &at) in points.iter().zip(&places) {
            sorted[at as usize] = *p;
        }
        let distance = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt();
        for p in points.iter().step_by(17) {
            let mut found = std::collections::BTreeSet::new();
            starts.around(&grid, grid.cell(*p), |run| {
                for j in run {
                    if distance(sorted[j], *p) < cell {
                        found.insert(j);
                    }
                }
                true
            });
            let expected = (0..sorted.len()).filter(|&j| distance(sorted[j], *p) < cell).collect();
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn sheets_do_not_see_each_other_but_box_edges_do() {
        let up = Site::new(Vec3::ZERO, Vec3::Z);
        assert!(!up.compatible(Site::new(Vec3::ZERO, Vec3::NEG_Z).normal));
        assert!(up.compatible(Site::new(Vec3::ZERO, Vec3::X).normal));
        assert!(up.compatible(up.normal));
    }
}
