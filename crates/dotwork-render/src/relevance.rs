//! The drawing test of Meruvia Pastor et al. 2003, section V-A: a stipple is drawn where all edges to its relevant
//! neighbours, as they are projected, exceed a threshold.
//!
//! The threshold is in pixels, and has to give the tone that is asked for. Facing the eye an edge is as long as in the
//! object, so the number of stipples whose shortest edge exceeds a distance, counted once, says which distance gives a
//! density. Where the surface turns away edges shorten, the more the more they point away: with ρ the projected
//! shortest edge over the real one, and a count that goes with `1 / d²`, the same number is drawn where the threshold
//! is `d · sqrt(mean of ρ²)`. That mean is taken over the stock's own stipples.

use dotwork_ink::{Arrival, DensityTable, Stock};
use glam::Vec3;
use rayon::prelude::*;

/// Stipples, and directions for each, over which the mean is taken.
const SAMPLE: usize = 1024;
const DIRECTIONS: usize = 8;

/// Cosines at which it is taken.
const STEPS: usize = 32;

/// No neighbour.
const NONE: u32 = u32::MAX;

/// How many times more stipples a stock needs where the cosine to the eye is `c`, so that for those whose edges point
/// away there are finer ones: one over the mean of ρ² for four equal edges at right angles.
pub(crate) fn reserve(c: f32) -> f32 {
    const ALONG: f32 = 0.5 - std::f32::consts::FRAC_1_PI;
    1.0 / (ALONG + (1.0 - ALONG) * c * c)
}

/// What the test needs of a stock.
#[derive(Clone)]
pub(crate) struct Edges {
    /// Shortening of the threshold for cosines 0 … 1, one more than [`STEPS`], and the last twice.
    shortening: Vec<f32>,
}

impl Edges {
    /// The test for a stock, and the table of its shortest edges; `None` if its stipples know no neighbours.
    pub fn new(stock: &Stock, arrival: Arrival) -> Option<(Edges, DensityTable)> {
        let neighbours = &stock.baked.neighbours;
        if neighbours.is_empty() {
            return None;
        }
        let shortest = |i: usize| {
            let at = stock.position.at(i);
            let ends = neighbours[i].iter().filter(|&&n| n != NONE);
            let least =
                ends.map(|&n| at.distance(stock.position.at(n as usize))).fold(f32::INFINITY, f32::min);
            // The first of all has no neighbours.
            if least.is_finite() { least } else { stock.baked.radius[i] }
        };
        let mut least: Vec<f32> = (0..stock.len()).into_par_iter().map(shortest).collect();
        least.par_sort_unstable_by(|a, b| b.total_cmp(a));
        // Coincident stipples are never drawn together: they count for nothing.
        let smallest = least.first().copied().unwrap_or(1.0) * 1e-6;
        least.truncate(least.partition_point(|&d| d > smallest).max(1));
        let table = DensityTable::counted(&least, stock.baked.area, arrival);
        let mut shortening: Vec<f32> =
            (0..=STEPS).into_par_iter().map(|k| shortening(stock, k as f32 / STEPS as f32)).collect();
        shortening.push(1.0);
        Some((Edges { shortening }, table))
    }

    /// The factor on the threshold where the cosine to the eye is `c`.
    #[inline(always)]
    pub fn shortening(&self, c: f32) -> f32 {
        let x = c.clamp(0.0, 1.0) * STEPS as f32;
        let k = x as usize;
        self.shortening[k] + (self.shortening[k + 1] - self.shortening[k]) * (x - k as f32)
    }
}

/// The root of the mean of ρ² at cosine `c`, over stipples and directions in which their places turn away.
fn shortening(stock: &Stock, c: f32) -> f32 {
    let (mut sum, mut count) = (0.0f64, 0usize);
    let every = (stock.len() / SAMPLE).max(1);
    for i in (0..stock.len()).step_by(every) {
        let ends = || stock.baked.neighbours[i].into_iter().filter(|&n| n != NONE);
        let (at, facet) = (stock.position.at(i), stock.facet.at(i));
        let side = facet.any_orthonormal_vector();
        let other = facet.cross(side);
        let edge = |n: u32| stock.position.at(n as usize) - at;
        let real = ends().map(|n| edge(n).length()).fold(f32::INFINITY, f32::min);
        if !(real.is_finite() && real > 0.0) {
            continue;
        }
        for k in 0..DIRECTIONS {
            let (sin, cos) = (std::f32::consts::PI * k as f32 / DIRECTIONS as f32).sin_cos();
            let away: Vec3 = side * cos + other * sin;
            // Lengths within the surface, shortened along `away`.
            let seen = |e: Vec3| {
                let flat = e - facet * e.dot(facet);
                let part = flat.dot(away);
                (flat.length_squared() - part * part * (1.0 - c * c)).max(0.0).sqrt()
            };
            let least = ends().map(|n| seen(edge(n))).fold(f32::INFINITY, f32::min);
            sum += f64::from(least / real).powi(2);
            count += 1;
        }
    }
    if count == 0 { 1.0 } else { (sum / count as f64).sqrt() as f32 }
}
