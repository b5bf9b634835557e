//! The Utah teapot, from the Bezier patches that Martin Newell published in 1975.
//!
//! Bodies of revolution are given by their profiles: a quarter of a circle is the cubic with control points (r, 0),
//! (r, 0.56 r), (0.56 r, r), (0, r). Handle and spout are given as one half each and mirrored. As in the original the
//! parts are open surfaces that run into each other, and there is a gap under the rim of the lid.

use super::grid::Patches;
use crate::RawMesh;

/// How far along the tangent the inner control points of a quarter circle lie, in radii.
const QUARTER: f64 = 0.56;

/// The same for the upper ring of the knob, where Newell has 0.45 for a radius of 0.8.
const KNOB_QUARTER: f64 = 0.5625;

/// Quads along a quarter circle.
const AROUND: usize = 36;

/// A profile: (radius, height) of four control points, the number of quads along it, the factor of the second ring.
type Profile = ([[f64; 2]; 4], usize, f64);

/// Profiles, ordered so that the outside is to the left of the way along them.
const PROFILES: [Profile; 6] = [
    ([[1.4, 2.4], [1.3375, 2.53125], [1.4375, 2.53125], [1.5, 2.4]], 12, QUARTER),
    ([[1.5, 2.4], [1.75, 1.875], [2.0, 1.35], [2.0, 0.9]], 44, QUARTER),
    ([[2.0, 0.9], [2.0, 0.45], [1.5, 0.225], [1.5, 0.15]], 32, QUARTER),
    ([[1.5, 0.15], [1.5, 0.075], [1.425, 0.0], [0.0, 0.0]], 28, QUARTER),
    ([[0.0, 3.15], [0.8, 3.15], [0.0, 2.85], [0.2, 2.7]], 24, KNOB_QUARTER),
    ([[0.2, 2.7], [0.4, 2.55], [1.3, 2.55], [1.3, 2.4]], 36, QUARTER),
];

/// Control points of half a patch, in four rows from one patch to the next.
type Half = [[[f64; 3]; 4]; 7];

const HANDLE: Half = [
    [[-1.6, 0.0, 2.025], [-1.6, -0.3, 2.025], [-1.5, -0.3, 2.25], [-1.5, 0.0, 2.25]],
    [[-2.3, 0.0, 2.025], [-2.3, -0.3, 2.025], [-2.5, -0.3, 2.25], [-2.5, 0.0, 2.25]],
    [[-2.7, 0.0, 2.025], [-2.7, -0.3, 2.025], [-3.0, -0.3, 2.25], [-3.0, 0.0, 2.25]],
    [[-2.7, 0.0, 1.8], [-2.7, -0.3, 1.8], [-3.0, -0.3, 1.8], [-3.0, 0.0, 1.8]],
    [[-2.7, 0.0, 1.575], [-2.7, -0.3, 1.575], [-3.0, -0.3, 1.35], [-3.0, 0.0, 1.35]],
    [[-2.5, 0.0, 1.125], [-2.5, -0.3, 1.125], [-2.65, -0.3, 0.9375], [-2.65, 0.0, 0.9375]],
    [[-2.0, 0.0, 0.9], [-2.0, -0.3, 0.9], [-1.9, -0.3, 0.6], [-1.9, 0.0, 0.6]],
];

const SPOUT: Half = [
    [[1.7, 0.0, 1.425], [1.7, -0.66, 1.425], [1.7, -0.66, 0.6], [1.7, 0.0, 0.6]],
    [[2.6, 0.0, 1.425], [2.6, -0.66, 1.425], [3.1, -0.66, 0.825], [3.1, 0.0, 0.825]],
    [[2.3, 0.0, 2.1], [2.3, -0.25, 2.1], [2.4, -0.25, 2.025], [2.4, 0.0, 2.025]],
    [[2.7, 0.0, 2.4], [2.7, -0.25, 2.4], [3.3, -0.25, 2.4], [3.3, 0.0, 2.4]],
    [[2.8, 0.0, 2.475], [2.8, -0.25, 2.475], [3.525, -0.25, 2.49375], [3.525, 0.0, 2.49375]],
    [[2.9, 0.0, 2.475], [2.9, -0.15, 2.475], [3.45, -0.15, 2.5125], [3.45, 0.0, 2.5125]],
    [[2.8, 0.0, 2.4], [2.8, -0.15, 2.4], [3.2, -0.15, 2.4], [3.2, 0.0, 2.4]],
];

/// The teapot: about 60,000 triangles, +y up, the spout towards +x, standing on y = 0.
pub fn teapot() -> RawMesh {
    let mut patches = Patches::default();
    for (profile, rows, factor) in &PROFILES {
        for quarter in 0..4 {
            patches.add(AROUND, *rows, true, |u, v| y_up(revolve(profile, *factor, quarter, u, v)));
        }
    }
    // The handle is listed from its inner side outwards, the spout from its upper side downwards: both wind alike.
    for half in [&HANDLE, &SPOUT] {
        for first in [0, 3] {
            let rows = &half[first..first + 4];
            patches.add(20, 40, false, |u, v| y_up(bicubic(rows, u, v)));
            patches.add(20, 40, true, |u, v| {
                let [x, y, z] = bicubic(rows, u, v);
                y_up([x, -y, z])
            });
        }
    }
    patches.weld()
}

/// The data have z up.
fn y_up([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, z, -y]
}

/// The weights of four control points at `t`, exact at 0 and 1 so that neighbouring patches meet bit by bit.
fn bernstein(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// A point of the given quarter of a body of revolution, counter-clockwise in `u`, along the profile in `v`.
fn revolve(profile: &[[f64; 2]; 4], factor: f64, quarter: usize, u: f64, v: f64) -> [f64; 3] {
    let (along, around) = (bernstein(v), bernstein(u));
    let weighted = |column: usize, second: f64| {
        (0..4).map(|i| along[i] * profile[i][column] * if i == 1 { second } else { 1.0 }).sum::<f64>()
    };
    let (r, inner, z) = (weighted(0, 1.0), weighted(0, factor / QUARTER) * QUARTER, weighted(1, 1.0));
    let x = r * around[0] + r * around[1] + inner * around[2];
    let y = inner * around[1] + r * around[2] + r * around[3];
    // Quarter turns without a sine, so that the quarters meet bit by bit.
    match quarter {
        0 => [x, y, z],
        1 => [-y, x, z],
        2 => [-x, -y, z],
        _ => [y, -x, z],
    }
}

/// A point of a patch: `u` within the rows, `v` from row to row.
fn bicubic(rows: &[[[f64; 3]; 4]], u: f64, v: f64) -> [f64; 3] {
    let (bu, bv) = (bernstein(u), bernstein(v));
    let mut p = [0.0; 3];
    for (row, wv) in rows.iter().zip(bv) {
        for (point, wu) in row.iter().zip(bu) {
            for (sum, c) in p.iter_mut().zip(point) {
                *sum += wu * wv * c;
            }
        }
    }
    p
}
