//! The 256 cases of a cell, worked out from one rule instead of copied from a table.
//!
//! A cell is a cube of eight samples; corner `c` stands at x = c & 1, y = c >> 1 & 1, z = c >> 2. A corner is *inside*
//! if its value reaches the iso value, and each of the twelve edges between an inside and an outside corner carries
//! one vertex of the surface.
//!
//! On a face of the cube, the surface runs along segments between the vertices on its rim. Two vertices: one
//! segment. Four vertices (the inside corners of the face lie on a diagonal) can be joined in two ways. Here **each
//! inside corner is cut off alone, so outside corners on a diagonal are connected**, as in VTK. The rule looks at
//! nothing but the four corners of the face, so both cells at a face choose the same segments: the surface has no
//! cracks. (The asymptotic decider would follow the trilinear field more closely, at the price of a different table
//! for each combination of faces; on measured data ambiguous faces are few.)
//!
//! Each vertex lies on two faces, so the segments of all six form closed loops. A loop of n vertices becomes n − 2
//! triangles, chosen by dynamic programming: never with a diagonal that lies in a face of the cube (the neighbouring
//! cell might have the same one, and the edge would have four triangles), and among those that are left with the
//! smallest sum of squared diagonals (vertices taken at the middles of their edges), the first in index order.

use std::sync::LazyLock;

/// The most triangles that a cell has; a test compares.
const MAX_TRIANGLES: usize = 5;

/// The triangles of one case. Corners are edge numbers; counter-clockwise seen from outside (the low side) in a
/// right-handed frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Case {
    count: u8,
    triangles: [[u8; 3]; MAX_TRIANGLES],
}

impl Case {
    pub(super) fn triangles(&self) -> &[[u8; 3]] {
        &self.triangles[..usize::from(self.count)]
    }
}

/// All cases; bit c of the index says that corner c is inside.
pub(super) static CASES: LazyLock<[Case; 256]> =
    LazyLock::new(|| std::array::from_fn(|inside| case(inside as u8)));

/// The twelve edges. Edge 4a + k runs along axis a; bit 0 of k is its place along the lower of the other two axes,
/// bit 1 along the higher.
pub(super) const EDGES: usize = 12;

/// The lower and the upper corner of an edge.
fn edge_corners(edge: usize) -> (usize, usize) {
    let axis = edge / 4;
    let (low, high) = ([1, 0, 0][axis], [2, 2, 1][axis]);
    let from = (edge & 1) << low | (edge >> 1 & 1) << high;
    (from, from | 1 << axis)
}

/// The edge between two neighbouring corners.
fn edge_between(a: usize, b: usize) -> usize {
    (0..EDGES).find(|&e| edge_corners(e) == (a.min(b), a.max(b))).expect("corners are neighbours")
}

/// The corners of the face at the low (`side` 0) or high end of `axis`, counter-clockwise seen from outside the cube.
fn face_corners(axis: usize, side: usize) -> [usize; 4] {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let base = side << axis;
    let mut corners = [base, base | 1 << u, base | 1 << u | 1 << v, base | 1 << v];
    if side == 0 {
        corners.reverse();
    }
    corners
}

/// The middle of an edge, in half cell sides.
fn middle(edge: usize) -> [i32; 3] {
    let (a, b) = edge_corners(edge);
    [0, 1, 2].map(|axis| ((a >> axis & 1) + (b >> axis & 1)) as i32)
}

/// True if both edges lie in one face of the cube.
fn in_one_face(a: usize, b: usize) -> bool {
    let (a, b) = (middle(a), middle(b));
    (0..3).any(|axis| a[axis] == b[axis] && a[axis] != 1)
}

fn case(inside: u8) -> Case {
    let mut case = Case::default();
    for cycle in loops(inside) {
        for triangle in triangulate(&cycle) {
            case.triangles[usize::from(case.count)] = triangle.map(|e| e as u8);
            case.count += 1;
        }
    }
    case
}

/// The closed loops of segments, each as its edges in order, counter-clockwise seen from the low side.
fn loops(inside: u8) -> Vec<Vec<usize>> {
    let is_inside = |corner: usize| inside >> corner & 1 == 1;
    // Going round a face counter-clockwise, the rim enters the inside at some edges and leaves it at others. An edge
    // that leaves in one face enters in the other, so segments from entering to leaving edges follow one another.
    let mut next = [None; EDGES];
    for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
        let corners = face_corners(axis, side);
        let corner = |i: usize| corners[i % 4];
        for i in 0..4 {
            if is_inside(corner(i)) || !is_inside(corner(i + 1)) {
                continue;
            }
            // The inside corners from here on are cut off: the segment ends where the rim leaves them.
            let leaves = (i + 1..i + 4).find(|&k| !is_inside(corner(k + 1))).expect("the rim comes back");
            next[edge_between(corner(i), corner(i + 1))] =
                Some(edge_between(corner(leaves), corner(leaves + 1)));
        }
    }
    let mut loops = Vec::new();
    for start in 0..EDGES {
        let mut cycle = Vec::new();
        let mut edge = start;
        while let Some(to) = next[edge].take() {
            cycle.push(edge);
            edge = to;
        }
        if !cycle.is_empty() {
            loops.push(cycle);
        }
    }
    loops
}

/// Cuts a loop into triangles; see the module's text for which.
fn triangulate(cycle: &[usize]) -> Vec<[usize; 3]> {
    /// More than any sum of squared diagonals.
    const FORBIDDEN: i32 = 10_000;
    let n = cycle.len();
    let price = |i: usize, j: usize| {
        if j - i == 1 || j - i == n - 1 {
            0
        } else if in_one_face(cycle[i], cycle[j]) {
            FORBIDDEN
        } else {
            let (a, b) = (middle(cycle[i]), middle(cycle[j]));
            (0..3).map(|axis| (a[axis] - b[axis]).pow(2)).sum()
        }
    };
    // best[i][j]: the price of the part i..=j, and the third corner of the triangle on its chord.
    let mut best = vec![vec![(0, 0); n]; n];
    for length in 2..n {
        for i in 0..n - length {
            let j = i + length;
            best[i][j] = (i + 1..j)
                .map(|k| (best[i][k].0 + best[k][j].0 + price(i, k) + price(k, j), k))
                .min()
                .expect("a triangle has a third corner");
        }
    }
    let mut triangles = Vec::new();
    let mut parts = vec![(0, n - 1)];
    while let Some((i, j)) = parts.pop() {
        if j - i >= 2 {
            let k = best[i][j].1;
            triangles.push([cycle[i], cycle[k], cycle[j]]);
            parts.extend([(i, k), (k, j)]);
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The vertices of every case are its crossed edges, and no diagonal lies in a face.
    #[test]
    fn loops_use_every_crossed_edge_once_and_diagonals_stay_inside() {
        for inside in 0..=255u8 {
            let crossed = |e: usize| {
                let (a, b) = edge_corners(e);
                (inside >> a ^ inside >> b) & 1 == 1
            };
            let cycles = loops(inside);
            let mut used: Vec<usize> = cycles.concat();
            used.sort_unstable();
            assert_eq!(used, (0..EDGES).filter(|&e| crossed(e)).collect::<Vec<_>>(), "case {inside:08b}");
            for cycle in &cycles {
                let n = cycle.len();
                let on_rim = |a: usize, b: usize| {
                    (0..n).any(|i| {
                        [(cycle[i], cycle[(i + 1) % n]), (cycle[(i + 1) % n], cycle[i])].contains(&(a, b))
                    })
                };
                let triangles = triangulate(cycle);
                assert_eq!(triangles.len(), n - 2);
                for [a, b, c] in triangles {
                    for (p, q) in [(a, b), (b, c), (c, a)] {
                        assert!(on_rim(p, q) || !in_one_face(p, q), "case {inside:08b}: {cycle:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_table_is_as_large_as_it_must_be() {
        let most = CASES.iter().map(|c| c.triangles().len()).max();
        assert_eq!(most, Some(MAX_TRIANGLES));
        assert!(CASES[0].triangles().is_empty() && CASES[255].triangles().is_empty());
    }

    /// A single inside corner: the triangle looks away from it. A single outside corner: towards it.
    #[test]
    fn triangles_face_the_low_side() {
        for corner in 0..8 {
            let at = [0, 1, 2].map(|axis| 2 * (corner >> axis & 1));
            for (case, sign) in [(1u8 << corner, 1), (!(1u8 << corner), -1)] {
                let &[[a, b, c]] = CASES[usize::from(case)].triangles() else { panic!("one triangle") };
                let [a, b, c] = [a, b, c].map(|e| middle(usize::from(e)));
                let [u, v, w] = [(b, a), (c, a), (a, at)]
                    .map(|(p, q): ([i32; 3], [i32; 3])| [p[0] - q[0], p[1] - q[1], p[2] - q[2]]);
                let normal =
                    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                let out = sign * (0..3).map(|i| normal[i] * w[i]).sum::<i32>();
                assert!(out > 0, "corner {corner}, case {case:08b}");
            }
        }
    }
}
