//! The ribbon: a sculptural form made for drawing, with folds, openings and every kind of curvature.
//!
//! A thick band runs once around an upright ring and makes three half turns on the way, as in Max Bill's "Endless
//! Ribbon": its edge is a trefoil knot, and it has one side only (the skin around its thickness is an ordinary closed
//! surface). Flutes run along the band and calm down towards two openings with raised lips. It is heavier below.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use glam::DVec3;

use super::implicit::{Grid, polygonise};
use super::raw;
use crate::RawMesh;

/// Handles of [`ribbon`]: the ring itself and two openings. Its Euler characteristic is 2 − 2 · 3 = −4.
pub const RIBBON_GENUS: i64 = 3;

/// The radius of the ring, and how much higher it is than wide.
const RING: f64 = 0.72;
const STRETCH: f64 = 1.12;

/// Half the width and half the thickness of the band, and what is added below and taken away above.
const WIDTH: [f64; 2] = [0.36, 0.09];
const THICKNESS: [f64; 2] = [0.07, 0.02];

/// How round the edges of the band are.
const ROUNDING: f64 = 0.055;

/// Depth of the flutes from their mean, and how many half waves there are from the middle to the edge: an odd number,
/// so that the edge ends in a valley.
const FLUTE_DEPTH: f64 = 0.03;
const FLUTE_WAVES: f64 = 5.0;

/// Height of the lips.
const LIP: f64 = 0.03;

/// The openings: where on the ring (radians from +x towards +y), half length along it, half width across.
const OPENINGS: [[f64; 3]; 2] = [[-0.62 * PI, 0.30, 0.17], [0.36 * PI, 0.24, 0.13]];

/// The ribbon: closed, smooth, of genus [`RIBBON_GENUS`], about 230,000 triangles, 2.2 units high, +y up, to be seen
/// from +z.
pub fn ribbon() -> RawMesh {
    let step = 0.0125;
    let min = DVec3::new(-1.15, -1.15, -0.53);
    let cells = [2.3, 2.35, 1.06].map(|side: f64| (side / step).ceil() as usize);
    let (positions, triangles) = polygonise(&Grid { min, step, cells }, 1.5, &band);
    raw(positions.into_iter().map(|p| p.as_vec3().to_array()).collect(), triangles)
}

/// Negative inside the ribbon, and about a distance near it.
fn band(p: DVec3) -> f64 {
    let y = p.y / STRETCH;
    let around = y.atan2(p.x);
    let low = -(around + 0.3).sin();
    // Across the band and through it. Turning by half the whole angle more than once around exchanges the sides, so
    // everything below is even in both.
    let (sin, cos) = (1.5 * around + FRAC_PI_4).sin_cos();
    let out = p.x.hypot(y) - RING;
    let across = cos * out + sin * p.z;
    let through = cos * p.z - sin * out;

    let width = WIDTH[0] + WIDTH[1] * low;
    let openings = OPENINGS.map(|[at, length, width]| {
        let along = around - at;
        let along = RING * (along - TAU * (along / TAU).round());
        ((along / length).hypot(across / width) - 1.0) * width
    });
    let nearest = openings[0].min(openings[1]);
    let lip = LIP * (1.0 - smooth_step(0.02, 0.12, nearest));
    let part = across / width;
    let flutes = FLUTE_DEPTH * (FLUTE_WAVES * PI * part).cos() * (1.0 - part.powi(4)).max(0.0);
    let thickness = THICKNESS[0] + THICKNESS[1] * low + flutes * smooth_step(0.03, 0.16, nearest) + lip;

    let beside = across.abs() - width + ROUNDING;
    let above = through.abs() - thickness + ROUNDING;
    let corner = beside.max(0.0).hypot(above.max(0.0)) - ROUNDING;
    let solid = corner + smooth_max(beside, above, 0.04).min(0.0);
    // The twist makes the function steeper than a distance.
    0.6 * openings.into_iter().fold(solid, |solid, opening| smooth_max(solid, -opening, 0.08))
}

/// The larger of both, with the edge between them rounded over the width `k` (I. Quilez, "Smooth minimum", cubic).
fn smooth_max(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.max(b) + h * h * h * k / 6.0
}

/// 0 below `from`, 1 above `to`, smooth between.
fn smooth_step(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
