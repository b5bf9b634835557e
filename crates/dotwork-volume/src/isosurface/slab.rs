//! The surface in a slab of cell layers: counted first, then made in place.
//!
//! A layer of samples owns its x- and y-edges and the z-edges up to the next layer. Vertices are numbered layer by
//! layer; within a layer row by row, the x-edges of a row before its y-edges; then the z-edges, again row by row. So
//! the number of a vertex follows from the first number of its row and the crossings before it in the row, and no map
//! from edges to vertices is kept: walking along a row of cells, eight counters follow the eight rows of edges around
//! it (four along x, two rows of y-edges, two of z-edges).

use std::ops::Range;

use super::bits::{self, Bits, WORD};
use super::cases::{CASES, EDGES};
use super::field::Field;
use crate::samples::Ordered;

/// The grid as the sweep sees it: the volume, or the volume within a layer of samples that are outside.
pub(super) struct Grid<'a, T> {
    pub field: Field<'a, T>,
    pub bits: Bits,
    /// 1 with a layer of samples around the volume, otherwise 0.
    pub pad: usize,
    /// True if triangles are turned, for left-handed voxel axes.
    pub turn: bool,
}

/// What a layer of samples, with the cells above it, adds to the mesh.
#[derive(Clone, Copy, Default)]
pub(super) struct Counts {
    pub vertices: usize,
    pub triangles: usize,
}

/// The part of the mesh that belongs to a slab.
pub(super) struct Output<'a> {
    pub positions: &'a mut [[f32; 3]],
    pub normals: &'a mut [[f32; 3]],
    pub triangles: &'a mut [[u32; 3]],
    /// Number of the first vertex in the whole mesh.
    pub first_vertex: usize,
}

/// The numbers of the first vertices in the rows of a layer.
#[derive(Default)]
struct Numbers {
    x: Vec<u32>,
    y: Vec<u32>,
    z: Vec<u32>,
}

impl Numbers {
    /// Numbers the vertices on the x- and y-edges of layer `z` from `next` on; returns the number after them.
    fn in_layer(&mut self, bits: &Bits, z: usize, mut next: usize) -> usize {
        self.x.clear();
        self.y.clear();
        for y in 0..bits.rows() {
            self.x.push(next as u32);
            next += bits.crossings::<0>(y, z);
            self.y.push(next as u32);
            next += bits.crossings::<1>(y, z);
        }
        next
    }

    /// The same for the z-edges from layer `z` to the next.
    fn above_layer(&mut self, bits: &Bits, z: usize, mut next: usize) -> usize {
        self.z.clear();
        for y in 0..bits.rows() {
            self.z.push(next as u32);
            next += bits.crossings::<2>(y, z);
        }
        next
    }
}

/// Counts what layer `z` adds.
pub(super) fn count(bits: &Bits, z: usize) -> Counts {
    let mut numbers = Numbers::default();
    let next = numbers.in_layer(bits, z, 0);
    let vertices = numbers.above_layer(bits, z, next);
    let mut triangles = 0;
    if z + 1 < bits.layers() {
        for y in 0..bits.rows() - 1 {
            for_each_cell(bits, y, z, |case| triangles += CASES[case].triangles().len());
        }
    }
    Counts { vertices, triangles }
}

/// Makes the vertices that the layers `layers` own, and the triangles of the cells above each.
pub(super) fn make<T: Ordered>(grid: &Grid<'_, T>, layers: Range<usize>, output: Output<'_>) {
    let bits = &grid.bits;
    let mut vertices = output.positions.iter_mut().zip(output.normals);
    let mut triangles = output.triangles.iter_mut();
    let (mut below, mut above) = (Numbers::default(), Numbers::default());
    let mut next = below.in_layer(bits, layers.start, output.first_vertex);
    for z in layers {
        for y in 0..bits.rows() {
            make_vertices::<T, 0>(grid, y, z, &mut vertices);
            make_vertices::<T, 1>(grid, y, z, &mut vertices);
        }
        for y in 0..bits.rows() {
            make_vertices::<T, 2>(grid, y, z, &mut vertices);
        }
        if z + 1 < bits.layers() {
            next = below.above_layer(bits, z, next);
            next = above.in_layer(bits, z + 1, next);
            for y in 0..bits.rows() - 1 {
                make_triangles(bits, y, z, &below, &above, grid.turn, &mut triangles);
            }
            std::mem::swap(&mut below, &mut above);
        }
    }
}

/// Makes the vertices on the edges along `AXIS` from the samples of row `y` in layer `z`.
fn make_vertices<'o, T: Ordered, const AXIS: usize>(
    grid: &Grid<'_, T>,
    y: usize,
    z: usize,
    vertices: &mut impl Iterator<Item = (&'o mut [f32; 3], &'o mut [f32; 3])>,
) {
    let row = grid.bits.row(y, z);
    let edges = grid.field.edges::<AXIS>(y.wrapping_sub(grid.pad), z.wrapping_sub(grid.pad));
    for (w, inside) in row.iter().enumerate() {
        for bit in bits::ones(grid.bits.crossed::<AXIS>(y, z, w)) {
            let x = (w * WORD + bit).wrapping_sub(grid.pad);
            // The counts have made room for all of them.
            let Some((position, normal)) = vertices.next() else { return };
            (*position, *normal) = edges.vertex(x, inside >> bit & 1 == 1);
        }
    }
}

/// Calls `act` with the case of each cell of row `y` above layer `z` that the surface crosses, x ascending.
#[inline]
fn for_each_cell(bits: &Bits, y: usize, z: usize, mut act: impl FnMut(usize)) {
    let rows = [bits.row(y, z), bits.row(y + 1, z), bits.row(y, z + 1), bits.row(y + 1, z + 1)];
    for w in 0..bits.words() {
        // Corners 0, 2, 4, 6 and 1, 3, 5, 7 of 64 cells.
        let left = rows.map(|row| row[w]);
        let right = rows.map(|row| bits::shifted(row, w));
        let any = left.iter().chain(&right).fold(0, |any, word| any | word);
        let all = left.iter().chain(&right).fold(u64::MAX, |all, word| all & word);
        for bit in bits::ones(any & !all & bits.cells(w)) {
            let mut case = 0;
            for r in 0..4 {
                case |= (left[r] >> bit & 1) << (2 * r) | (right[r] >> bit & 1) << (2 * r + 1);
            }
            act(case as usize);
        }
    }
}

/// Makes the triangles of the cells of row `y` above layer `z`.
fn make_triangles<'o>(
    bits: &Bits,
    y: usize,
    z: usize,
    below: &Numbers,
    above: &Numbers,
    turn: bool,
    triangles: &mut impl Iterator<Item = &'o mut [u32; 3]>,
) {
    let cases = &*CASES;
    // The next vertex on each of the rows of edges around the cells.
    let [mut x0, mut x1, mut x2, mut x3] = [below.x[y], below.x[y + 1], above.x[y], above.x[y + 1]];
    let [mut y0, mut y1] = [below.y[y], above.y[y]];
    let [mut z0, mut z1] = [below.z[y], below.z[y + 1]];
    for_each_cell(bits, y, z, |case| {
        // 1 if the edge from `corner` along the axis is crossed.
        let along = |axis: usize, corner: usize| ((case ^ case >> (1 << axis)) >> corner & 1) as u32;
        let [y0_right, y1_right] = [y0 + along(1, 0), y1 + along(1, 4)];
        let [z0_right, z1_right] = [z0 + along(2, 0), z1 + along(2, 2)];
        let ids: [u32; EDGES] = [x0, x1, x2, x3, y0, y0_right, y1, y1_right, z0, z0_right, z1, z1_right];
        for (&[a, b, c], triangle) in cases[case].triangles().iter().zip(&mut *triangles) {
            let [a, b, c] = [a, b, c].map(|edge| ids[usize::from(edge)]);
            *triangle = if turn { [a, c, b] } else { [a, b, c] };
        }
        x0 += along(0, 0);
        x1 += along(0, 2);
        x2 += along(0, 4);
        x3 += along(0, 6);
        [y0, y1] = [y0_right, y1_right];
        [z0, z1] = [z0_right, z1_right];
    });
}
