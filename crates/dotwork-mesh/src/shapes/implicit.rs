//! The surface where a function of space is zero, as triangles.
//!
//! Marching cubes (W. E. Lorensen and H. E. Cline, 1987) without its table of cases: on each face of a cell every run of
//! inner corners, taken around the face, is cut off by one segment; the segments of a cell close into loops, and the
//! loops are filled. Since both cells at a face see the same segments, and no two loops share a chord, the mesh is a
//! closed manifold whatever the samples are. (Surface nets give more even triangles, but are pinched wherever a saddle
//! touches a grid plane: nine edges of four faces on the ribbon.)
//!
//! Then vertices move on to the surface by Newton steps and are evened out along it. The function must be negative
//! inside and change sign on the surface only.

use glam::DVec3;
use rayon::prelude::*;

/// The base of the differences that stand for the gradient.
const GRADIENT_STEP: f64 = 1e-4;

/// Steps along the surface that even out the triangles.
const RELAXATIONS: usize = 3;

/// Corners on each side of a block of samples that is skipped as a whole where the surface is far.
const BLOCK: usize = 8;

/// A grid of cubic cells from `min`; `cells` of them each way.
pub(super) struct Grid {
    pub(super) min: DVec3,
    pub(super) step: f64,
    pub(super) cells: [usize; 3],
}

/// Vertices and triangles of {f = 0}, triangles counter-clockwise seen from outside. The surface must not leave the
/// grid, and `f` must not change by more than `slope` per unit length where it is near the surface.
pub(super) fn polygonise(
    grid: &Grid,
    slope: f64,
    f: &(impl Fn(DVec3) -> f64 + Sync),
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let values = sample(grid, slope, f);
    let (mut positions, triangles) = Cells::new(grid, &values).surface();
    // Gradients hold for the small moves between; only the last step needs them anew.
    let mut steps = newton_steps(&positions, f);
    for _ in 0..RELAXATIONS {
        relax(&mut positions, &triangles);
        let moves = positions.par_iter_mut().zip(&steps);
        moves.for_each(|(p, step)| *p -= (f(*p) * *step).clamp_length_max(grid.step));
    }
    steps = newton_steps(&positions, f);
    let moves = positions.par_iter_mut().zip(&steps);
    moves.for_each(|(p, step)| *p -= (f(*p) * *step).clamp_length_max(grid.step));
    (positions, triangles)
}

impl Grid {
    /// Corners each way.
    fn corners(&self) -> [usize; 3] {
        self.cells.map(|n| n + 1)
    }

    fn point(&self, [i, j, k]: [usize; 3]) -> DVec3 {
        self.min + self.step * DVec3::new(i as f64, j as f64, k as f64)
    }
}

/// The function at the corners of the cells; far from the surface only its sign is right.
fn sample(grid: &Grid, slope: f64, f: &(impl Fn(DVec3) -> f64 + Sync)) -> Vec<f32> {
    let [nx, ny, nz] = grid.corners();
    let mut values = vec![0f32; nx * ny * nz];
    let half = 0.5 * (BLOCK - 1) as f64 * grid.step;
    let far = slope * half * 3f64.sqrt();
    values.par_chunks_mut(nx * ny * BLOCK).enumerate().for_each(|(slab, values)| {
        let depth = values.len() / (nx * ny);
        for (j0, i0) in (0..ny).step_by(BLOCK).flat_map(|j| (0..nx).step_by(BLOCK).map(move |i| (j, i))) {
            let middle = f(grid.point([i0, j0, slab * BLOCK]) + DVec3::splat(half));
            for k in 0..depth {
                for j in j0..(j0 + BLOCK).min(ny) {
                    for i in i0..(i0 + BLOCK).min(nx) {
                        let value =
                            if middle.abs() > far { middle } else { f(grid.point([i, j, slab * BLOCK + k])) };
                        values[(k * ny + j) * nx + i] = value as f32;
                    }
                }
            }
        }
    });
    values
}

/// Rings of vertices, one after another.
#[derive(Default)]
struct Loops {
    vertices: Vec<u32>,
    /// Where each loop ends.
    ends: Vec<usize>,
}

impl Loops {
    /// Ends a loop, unless nothing has been added since the last.
    fn close(&mut self) {
        if self.ends.last().copied().unwrap_or(0) < self.vertices.len() {
            self.ends.push(self.vertices.len());
        }
    }

    fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.ends.iter().scan(0, |start, &end| Some(&self.vertices[std::mem::replace(start, end)..end]))
    }
}

/// No vertex on this edge of the grid.
const EMPTY: u32 = u32::MAX;

/// The corners of a cell's faces, counter-clockwise seen from outside; bit 0 of a corner is x, bit 1 y, bit 2 z.
const FACES: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// A sampled grid and the vertices on its edges.
struct Cells<'a> {
    grid: &'a Grid,
    values: &'a [f32],
    positions: Vec<DVec3>,
    /// For each corner the vertices on the edges from it along x, y and z.
    vertices: Vec<[u32; 3]>,
}

impl<'a> Cells<'a> {
    fn new(grid: &'a Grid, values: &'a [f32]) -> Self {
        let [nx, ny, nz] = grid.corners();
        let strides = [1, nx, nx * ny];
        let mut positions = Vec::new();
        let mut vertices = vec![[EMPTY; 3]; values.len()];
        for (k, j, i) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
            let corner = (k * ny + j) * nx + i;
            for axis in 0..3 {
                if [i + 1 == nx, j + 1 == ny, k + 1 == nz][axis] {
                    continue;
                }
                let (a, b) = (values[corner], values[corner + strides[axis]]);
                if (a < 0.0) != (b < 0.0) {
                    vertices[corner][axis] = positions.len() as u32;
                    let along = f64::from(a / (a - b)) * grid.step;
                    positions.push(grid.point([i, j, k]) + along * DVec3::AXES[axis]);
                }
            }
        }
        Cells { grid, values, positions, vertices }
    }

    fn surface(mut self) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let [cx, cy, cz] = self.grid.cells;
        let slabs: Vec<Loops> = (0..cz)
            .into_par_iter()
            .map(|k| {
                let mut loops = Loops::default();
                for (j, i) in (0..cy).flat_map(|j| (0..cx).map(move |i| (j, i))) {
                    self.loops([i, j, k], &mut loops);
                }
                loops
            })
            .collect();
        let mut triangles = Vec::with_capacity(2 * self.positions.len());
        for around in slabs.iter().flat_map(Loops::iter) {
            match *around {
                [a, b, c] => triangles.push([a, b, c]),
                [a, b, c, d] => triangles.extend([[a, b, c], [a, c, d]]),
                // A chord of a longer loop may lie in a face of the cell, where the next cell may have one too.
                _ => {
                    let sum: DVec3 = around.iter().map(|&v| self.positions[v as usize]).sum();
                    let middle = self.positions.len() as u32;
                    self.positions.push(sum / around.len() as f64);
                    let next = around.iter().cycle().skip(1);
                    triangles.extend(around.iter().zip(next).map(|(&a, &b)| [a, b, middle]));
                }
            }
        }
        (self.positions, triangles)
    }

    /// Adds the loops of vertices around the pieces of the surface in one cell.
    fn loops(&self, [i, j, k]: [usize; 3], loops: &mut Loops) {
        let [nx, ny, _] = self.grid.corners();
        let corner: [usize; 8] =
            std::array::from_fn(|c| ((k + (c >> 2)) * ny + j + (c >> 1 & 1)) * nx + i + (c & 1));
        let inside = corner.map(|c| self.values[c] < 0.0);
        if inside == [inside[0]; 8] {
            return;
        }
        // Edges are numbered by axis and lower corner; from each that is cut the segments lead to the next.
        let edge = |a: usize, b: usize| 8 * (a ^ b).trailing_zeros() as usize + a.min(b);
        let mut next = [usize::MAX; 24];
        for face in FACES {
            for start in 0..4 {
                if inside[face[start]] || !inside[face[(start + 1) % 4]] {
                    continue;
                }
                let end = (1..4).find(|&n| !inside[face[(start + n + 1) % 4]]).unwrap_or(1);
                let exit = edge(face[(start + end) % 4], face[(start + end + 1) % 4]);
                next[edge(face[start], face[(start + 1) % 4])] = exit;
            }
        }
        for first in 0..24 {
            let mut at = first;
            while next[at] != usize::MAX {
                loops.vertices.push(self.vertices[corner[at % 8]][at / 8]);
                at = std::mem::replace(&mut next[at], usize::MAX);
            }
            loops.close();
        }
    }
}

/// For each point the gradient over its squared length: times f, the step to {f = 0}.
fn newton_steps(positions: &[DVec3], f: &(impl Fn(DVec3) -> f64 + Sync)) -> Vec<DVec3> {
    let step = |&p: &DVec3| {
        let here = f(p);
        let slope = |axis: DVec3| (f(p + GRADIENT_STEP * axis) - here) / GRADIENT_STEP;
        let gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
        gradient / gradient.length_squared().max(1e-12)
    };
    positions.par_iter().map(step).collect()
}

/// Moves each vertex half-way to the mean of its neighbours (of each twice, once per triangle at the edge).
fn relax(positions: &mut [DVec3], triangles: &[[u32; 3]]) {
    let mut sums = vec![(DVec3::ZERO, 0.0); positions.len()];
    for &[a, b, c] in triangles {
        for (v, p, q) in [(a, b, c), (b, c, a), (c, a, b)] {
            let (sum, count) = &mut sums[v as usize];
            *sum += positions[p as usize] + positions[q as usize];
            *count += 2.0;
        }
    }
    for (p, (sum, count)) in positions.iter_mut().zip(sums) {
        *p = p.lerp(sum / count, 0.5);
    }
}
