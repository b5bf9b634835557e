//! The numbers of faces: which of them shows a dot first where each asks for less than one.

use dotwork_drawing::hash::{hash2, unit};
use rayon::prelude::*;

use super::Lists;
use crate::tone::random_of;

/// Numbers without any order, the papers' own.
pub(super) fn random(faces: usize) -> Vec<f32> {
    (0..faces).into_par_iter().map(random_of).collect()
}

/// Numbers 0 ≤ u < 1, uniform among faces of like areas, of which the largest are evenly spread over the mesh.
///
/// A face is reached when the order's `i`-th point is the first on it: `c = A (i + ½) / whole` points of its own would have
/// fallen on it by then. Small ones are as even as the order, since hardly any face is reached twice, and late ones take
/// what is left. Ranks within an octave of areas make the numbers uniform, so that no size of faces is too dark.
/// `density` is that of all points of the order; faces that none of them reaches get later, random ones.
pub(super) fn even(area: &[f32], lists: &Lists, density: f32, whole: f64, seed: u32) -> Vec<f32> {
    let [late, within] = [hash2(5, seed), hash2(6, seed)];
    let mut keyed: Vec<(u64, u32)> = (0..area.len())
        .into_par_iter()
        .map(|e| {
            let a = area[e];
            let reached = match lists.of_face(e).first() {
                Some(&i) => (f64::from(a) * (f64::from(i) + 0.5) / whole) as f32,
                // As if the order went on at random.
                None => a * density - (1.0 - unit(hash2(e as u32, late))).ln(),
            };
            // Positive floats are ordered as their bits; the exponent is the octave.
            let octave = u64::from(a.to_bits() >> 23);
            (octave << 32 | u64::from(reached.max(0.0).to_bits()), e as u32)
        })
        .collect();
    keyed.par_sort_unstable();
    let mut numbers = vec![0.0; area.len()];
    for octave in keyed.chunk_by(|a, b| a.0 >> 32 == b.0 >> 32) {
        let step = 1.0 / octave.len() as f32;
        for (rank, &(_, e)) in octave.iter().enumerate() {
            let number = 1.0 - (rank as f32 + unit(hash2(e, within))) * step;
            numbers[e as usize] = number.clamp(0.0, MOST);
        }
    }
    numbers
}

/// The largest number below 1: a face's first stipple has a radius.
const MOST: f32 = 1.0 - 1.0 / (1 << 20) as f32;
