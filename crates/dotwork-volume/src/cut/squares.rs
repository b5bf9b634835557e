//! Marching squares in blocks of 2 x 2 cells: what lies inside becomes triangles, large ones where the whole block does.

use dotwork_mesh::RawMesh;

/// As for isosurfaces, crossings keep this distance from both ends of their edge, in edge lengths.
const MARGIN: f64 = 1.0 / 1024.0;

/// No vertex yet.
const NONE: u32 = u32::MAX;

/// Corners of a cell or a block, counter-clockwise.
const CORNERS: [[usize; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];

#[derive(Clone, Copy, PartialEq)]
enum Block {
    Outside,
    Rim,
    Inside,
}

struct Squares<'a, P> {
    heights: &'a [f32],
    points: [usize; 2],
    place: P,
    blocks: Vec<Block>,
    mesh: RawMesh,
    /// Vertices at grid points, and on the edges that start there along both axes.
    at_point: Vec<u32>,
    on_edge: [Vec<u32>; 2],
}

/// The part of a grid with heights of at least 0, as triangles. Heights are in rows of `points[0]`; NaN counts as −∞.
/// Both numbers of points are odd. `place` gives positions, which only vertices that are used get. The result shares
/// vertices and has no cracks.
pub(super) fn march<P: Fn(f64, f64) -> [f32; 3]>(heights: &[f32], points: [usize; 2], place: P) -> RawMesh {
    let [nu, nv] = points;
    let blocks = [nu / 2, nv / 2];
    let none = || vec![NONE; heights.len()];
    let mut squares = Squares {
        heights,
        points,
        place,
        blocks: Vec::with_capacity(blocks[0] * blocks[1]),
        mesh: RawMesh::default(),
        at_point: none(),
        on_edge: [none(), none()],
    };
    for j in 0..blocks[1] {
        for i in 0..blocks[0] {
            let inside = (0..9).filter(|n| squares.is_inside(2 * i + n % 3, 2 * j + n / 3)).count();
            squares.blocks.push(match inside {
                0 => Block::Outside,
                9 => Block::Inside,
                _ => Block::Rim,
            });
        }
    }
    for j in 0..blocks[1] {
        for i in 0..blocks[0] {
            match squares.blocks[i + blocks[0] * j] {
                Block::Outside => {}
                Block::Inside => squares.whole(i, j),
                Block::Rim => CORNERS.iter().for_each(|[di, dj]| squares.cell(2 * i + di, 2 * j + dj)),
            }
        }
    }
    squares.mesh
}

impl<P: Fn(f64, f64) -> [f32; 3]> Squares<'_, P> {
    fn height(&self, i: usize, j: usize) -> f64 {
        self.heights[i + self.points[0] * j].into()
    }

    fn is_inside(&self, i: usize, j: usize) -> bool {
        self.height(i, j) >= 0.0
    }

    fn push(&mut self, i: f64, j: f64) -> u32 {
        self.mesh.positions.push((self.place)(i, j));
        self.mesh.positions.len() as u32 - 1
    }

    /// The vertex at a grid point.
    fn point(&mut self, i: usize, j: usize) -> u32 {
        let at = i + self.points[0] * j;
        if self.at_point[at] == NONE {
            self.at_point[at] = self.push(i as f64, j as f64);
        }
        self.at_point[at]
    }

    /// The vertex on the edge between two neighbouring grid points, one of which is inside.
    fn crossing(&mut self, a: [usize; 2], b: [usize; 2]) -> u32 {
        let ([i, j], end) = if a < b { (a, b) } else { (b, a) };
        let axis = usize::from(end[1] != j);
        let at = i + self.points[0] * j;
        if self.on_edge[axis][at] == NONE {
            let (low, high) = (self.height(i, j), self.height(end[0], end[1]));
            let low_is_inside = low >= 0.0;
            let (inner, outer) = if low_is_inside { (low, high) } else { (high, low) };
            // As isosurfaces do: −∞ and NaN outside pull it to the inner end, ∞ inside pushes it to the outer one.
            let out = match (inner.is_finite(), outer.is_finite()) {
                (true, true) if inner > outer => (inner / (inner - outer)).clamp(MARGIN, 1.0 - MARGIN),
                (false, true) => 1.0 - MARGIN,
                _ => MARGIN,
            };
            let share = if low_is_inside { out } else { 1.0 - out };
            let (di, dj) = if axis == 0 { (share, 0.0) } else { (0.0, share) };
            self.on_edge[axis][at] = self.push(i as f64 + di, j as f64 + dj);
        }
        self.on_edge[axis][at]
    }

    /// A block that is inside: two triangles, or a fan about its middle if a neighbour needs the middles of its sides.
    fn whole(&mut self, i: usize, j: usize) {
        let blocks = [self.points[0] / 2, self.points[1] / 2];
        // A neighbour of an inner block has three points inside, so it is inside too or at the rim.
        let is_rim = |di: isize, dj: isize| match (i.checked_add_signed(di), j.checked_add_signed(dj)) {
            (Some(i), Some(j)) if i < blocks[0] && j < blocks[1] => {
                self.blocks[i + blocks[0] * j] == Block::Rim
            }
            _ => false,
        };
        let rims = [is_rim(0, -1), is_rim(1, 0), is_rim(0, 1), is_rim(-1, 0)];
        let (i, j) = (2 * i, 2 * j);
        let corners = CORNERS.map(|[di, dj]| self.point(i + 2 * di, j + 2 * dj));
        if rims == [false; 4] {
            let [a, b, c, d] = corners;
            self.mesh.triangles.extend([[a, b, c], [a, c, d]]);
            return;
        }
        let middle = self.point(i + 1, j + 1);
        let middles = [[1, 0], [2, 1], [1, 2], [0, 1]];
        for side in 0..4 {
            let (from, to) = (corners[side], corners[(side + 1) % 4]);
            if rims[side] {
                let [di, dj] = middles[side];
                let between = self.point(i + di, j + dj);
                self.mesh.triangles.extend([[middle, from, between], [middle, between, to]]);
            } else {
                self.mesh.triangles.push([middle, from, to]);
            }
        }
    }

    /// A cell at the rim, or beside it.
    fn cell(&mut self, i: usize, j: usize) {
        let corners = CORNERS.map(|[di, dj]| [i + di, j + dj]);
        let inside = corners.map(|[i, j]| self.is_inside(i, j));
        let opposite = inside[0] == inside[2] && inside[1] == inside[3] && inside[0] != inside[1];
        if opposite {
            // The middle of the cell decides whether its two inner corners are joined.
            let sum: f64 = corners.iter().map(|&[i, j]| self.height(i, j)).sum();
            if sum.is_nan() || sum < 0.0 {
                for k in (0..4).filter(|&k| inside[k]) {
                    let [before, at, after] = [corners[(k + 3) % 4], corners[k], corners[(k + 1) % 4]];
                    let triangle =
                        [self.point(at[0], at[1]), self.crossing(at, after), self.crossing(before, at)];
                    self.mesh.triangles.push(triangle);
                }
                return;
            }
        }
        let (mut ring, mut n) = ([0; 6], 0);
        for k in 0..4 {
            let (at, after) = (corners[k], corners[(k + 1) % 4]);
            if inside[k] {
                ring[n] = self.point(at[0], at[1]);
                n += 1;
            }
            if inside[k] != inside[(k + 1) % 4] {
                ring[n] = self.crossing(at, after);
                n += 1;
            }
        }
        for k in 2..n {
            self.mesh.triangles.push([ring[0], ring[k - 1], ring[k]]);
        }
    }
}
