//! Flat squares: the shape on which the spacing of dots is measured.

use dotwork_drawing::hash::{hash3, unit};

use super::raw;
use crate::RawMesh;

/// A square of side 1 in the xy plane, centred on the origin, facing +z: `nx` × `ny` cells of two triangles (at least
/// one each way).
pub fn plate(nx: usize, ny: usize) -> RawMesh {
    let even = |n: usize| (0..=n).map(|i| (i as f64 / n as f64 - 0.5) as f32).collect::<Vec<f32>>();
    let (xs, ys) = (even(nx.max(1)), even(ny.max(1)));
    lattice(&xs, &ys, |i, j| [xs[i], ys[j], 0.0], |_, _| true)
}

/// The square of [`plate`] with an uneven triangulation of `n` × `n` cells (at least one each way): rows and columns
/// whose widths differ up to thirtyfold, inner vertices moved by up to 0.3 of a cell, diagonals drawn by lot. Nothing
/// of it must show in a drawing. The same `seed` gives the same mesh.
pub fn plate_irregular(n: usize, seed: u32) -> RawMesh {
    let n = n.max(1);
    let draw =
        |i: usize, j: usize, stream: u32| unit(hash3(i as u32, j as u32, seed.wrapping_mul(8) + stream));
    let uneven = |stream: u32| {
        // Widths from 1 to 30, evenly spread in the logarithm.
        let widths: Vec<f32> = (0..n).map(|i| 30f32.powf(draw(i, 0, stream))).collect();
        let total: f32 = widths.iter().sum();
        let mut edge = 0.0;
        let mut edges = vec![-0.5];
        for w in &widths[..n - 1] {
            edge += w;
            edges.push(edge / total - 0.5);
        }
        edges.push(0.5);
        edges
    };
    let (xs, ys) = (uneven(0), uneven(1));
    let moved = |at: &[f32], i: usize, shift: f32| {
        if i == 0 || i == n {
            return at[i];
        }
        // A cell keeps its shape convex enough for either diagonal while both sides move by under half of it.
        let room = if shift < 0.0 { at[i] - at[i - 1] } else { at[i + 1] - at[i] };
        at[i] + 0.3 * shift * room
    };
    let point = |i: usize, j: usize| {
        let (dx, dy) = (2.0 * draw(i, j, 2) - 1.0, 2.0 * draw(i, j, 3) - 1.0);
        [moved(&xs, i, dx), moved(&ys, j, dy), 0.0]
    };
    // Of a quad that is no longer convex only one diagonal lies inside.
    let turns =
        |a: [f32; 3], b: [f32; 3], c: [f32; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let rising = |i: usize, j: usize| {
        let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
        let rising_worst = turns(a, b, c).min(turns(a, c, d));
        let falling_worst = turns(a, b, d).min(turns(b, c, d));
        let area = turns(a, b, c) + turns(a, c, d);
        if rising_worst.min(falling_worst) < 0.02 * area {
            rising_worst > falling_worst
        } else {
            draw(i, j, 4) < 0.5
        }
    };
    lattice(&xs, &ys, point, rising)
}

/// Triangles over a lattice; `rising(i, j)` says whether the diagonal of a cell rises to the right.
fn lattice(
    xs: &[f32],
    ys: &[f32],
    point: impl Fn(usize, usize) -> [f32; 3],
    rising: impl Fn(usize, usize) -> bool,
) -> RawMesh {
    let positions = (0..ys.len()).flat_map(|j| (0..xs.len()).map(move |i| (i, j))).map(|(i, j)| point(i, j));
    let at = |i: usize, j: usize| (j * xs.len() + i) as u32;
    let mut triangles = Vec::with_capacity(2 * xs.len() * ys.len());
    for j in 0..ys.len() - 1 {
        for i in 0..xs.len() - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend(if rising(i, j) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    raw(positions.collect(), triangles)
}
