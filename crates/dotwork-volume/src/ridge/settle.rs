//! From the moves that vertices want to those that they make together.

use glam::DVec3;
use rayon::prelude::*;

use crate::neighbours::Neighbours;

/// How much the mean of its neighbours counts for a vertex, beside its own ridge of weight 1 at most.
const STIFFNESS: f64 = 2.0;

/// How much staying counts for a vertex without a ridge.
const STAY: f64 = 0.05;

/// Steps of the smoothing between two looks at what it makes of the surface.
const ROUNDS: usize = 12;

/// How often ridges that crumple the surface are looked for.
const PASSES: usize = 3;

/// Ridges that turn a triangle by more than this are those of something else, radians.
const LARGEST_TILT: f64 = 0.8;

/// Edges shorter than this (in voxels) bind no harder: isosurfaces have some of a thousandth.
const SHORTEST: f64 = 0.1;

/// A triangle that keeps less than this of its area, seen along its old normal, counts as turned over: what is left must
/// be told apart in single precision.
const LEAST_AREA: f64 = 0.1;

/// A vertex whose triangles are turned over is halved so often, and then stays where it was.
const HALVINGS: u8 = 5;

/// A move along the normal, and how much it is worth: 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Move {
    /// Outwards, voxels.
    pub(super) by: f64,
    /// How clear the ridge is; 0 where there is none.
    pub(super) weight: f64,
}

/// The moves that are made.
pub(super) struct Moves {
    /// Outwards, voxels.
    pub(super) by: Vec<f64>,
    /// How many were shortened so that no triangle turns over.
    pub(super) held: usize,
}

/// Smooths the moves over the surface, without the ridges that would crumple it, and shortens those that would turn a
/// triangle over. Each vertex makes its share, of `shares`, of its move.
pub(super) fn settle(
    places: &[DVec3],
    directions: &[DVec3],
    triangles: &[[u32; 3]],
    mut wanted: Vec<Move>,
    shares: &[f64],
) -> Moves {
    let weight = |v: usize, to: usize, _| (1.0 / places[v].distance(places[to]).max(SHORTEST)) as f32;
    let graph = Neighbours::new(places.len(), triangles, weight);
    let sheet = Sheet { places, directions, triangles };
    let mut by: Vec<f64> = wanted.iter().map(|m| m.by).collect();
    for _ in 0..PASSES {
        smooth(&graph, &wanted, &mut by);
        let tilted = sheet.corners(&by, |before, after| {
            after.dot(before) < LARGEST_TILT.cos() * (before.length_squared() * after.length_squared()).sqrt()
        });
        if tilted.is_empty() {
            break;
        }
        tilted.into_iter().for_each(|v| wanted[v as usize] = Move::default());
    }
    by.iter_mut().zip(shares).for_each(|(by, share)| *by *= share);
    let held = sheet.unfold(&mut by);
    Moves { by, held }
}

/// Brings the moves nearer to those wanted and to each other: each to the mean of what its vertex wants, by its weight,
/// and of the moves of its neighbours, nearer ones by more. They are lengths along the normals, not vectors, so that at
/// an edge the moves of two faces do not pull at each other.
fn smooth(graph: &Neighbours, wanted: &[Move], now: &mut Vec<f64>) {
    let mut next = now.clone();
    for _ in 0..ROUNDS {
        next.par_iter_mut().enumerate().for_each(|(v, next)| {
            let (mut sum, mut total) = (0.0, 0.0);
            for &(to, weight) in graph.of(v) {
                sum += f64::from(weight) * now[to as usize];
                total += f64::from(weight);
            }
            let (own, mean) = (wanted[v], if total > 0.0 { sum / total } else { now[v] });
            let weight = if own.weight > 0.0 { own.weight } else { STAY };
            let aim = (weight * own.by + STIFFNESS * mean) / (weight + STIFFNESS);
            // Half-way, or two vertices close to each other would change places for ever.
            *next = 0.5 * (now[v] + aim);
        });
        std::mem::swap(now, &mut next);
    }
}

/// A surface before it moves.
struct Sheet<'a> {
    places: &'a [DVec3],
    directions: &'a [DVec3],
    triangles: &'a [[u32; 3]],
}

impl Sheet<'_> {
    /// The corners, in order, of triangles that move and of whose facets before and after `wrong` says so; their lengths
    /// are twice the areas.
    fn corners(&self, by: &[f64], wrong: impl Fn(DVec3, DVec3) -> bool + Sync) -> Vec<u32> {
        let facet = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        let is_wrong = |t: &&[u32; 3]| {
            let places = t.map(|v| self.places[v as usize]);
            let moved = t.map(|v| self.places[v as usize] + by[v as usize] * self.directions[v as usize]);
            t.iter().any(|&v| by[v as usize] != 0.0) && wrong(facet(places), facet(moved))
        };
        let mut corners: Vec<u32> =
            self.triangles.par_iter().filter(is_wrong).flat_map_iter(|t| *t).collect();
        corners.sort_unstable();
        corners.dedup();
        corners
    }

    /// Shortens moves until no triangle is turned over; gives how many were.
    fn unfold(&self, by: &mut [f64]) -> usize {
        let mut halvings = vec![0u8; by.len()];
        loop {
            let folded =
                self.corners(by, |before, after| after.dot(before) < LEAST_AREA * before.length_squared());
            if folded.is_empty() {
                return halvings.iter().filter(|&&h| h > 0).count();
            }
            for v in folded.into_iter().map(|v| v as usize) {
                halvings[v] = (halvings[v] + 1).min(HALVINGS + 1);
                by[v] = if halvings[v] > HALVINGS { 0.0 } else { 0.5 * by[v] };
            }
        }
    }
}
