//! Which voxels lie on boundaries: a threshold for the gradient with two levels, found from its histogram.
//!
//! Nobuyuki Otsu (*A Threshold Selection Method from Gray-Level Histograms*, 1979) splits a histogram in two classes
//! so that the variance between them is largest. On the lengths of gradients that keeps the strong boundaries and
//! loses weak ones (leaves, thin bone); on their logarithms it keeps those and haze with them. So, as in John Canny
//! (*A Computational Approach to Edge Detection*, 1986), a voxel above the low level counts if it is connected to one
//! above the high level: high is Otsu's threshold, low the geometric mean of that and Otsu's on the logarithms. Pieces
//! of few voxels are specks of noise and are dropped.
//!
//! Masks have one bit a voxel. Pieces are found from the runs of set bits along x (`runs`), in time linear in the
//! rows and runs.

use rayon::prelude::*;

use crate::gradient::Regression;
use crate::runs::{LayerRuns, Run, Runs};
use crate::volume::VolumeError;

/// Bits in a word.
const WORD: usize = u64::BITS as usize;

/// Pieces must have more voxels than this.
pub const MIN_PIECE: u64 = 300;

/// Gradients below 2⁻²⁰ of the range for a voxel step are none: rounding, or matter set to one value.
const FAINTEST: f32 = 1.0 / 1048576.0;

/// Mantissa bits that a bin keeps: 128 bins for a factor of two.
const BIN_BITS: u32 = 7;

/// Bins: from the faintest to 64 times the range a step.
const BINS: usize = 26 << BIN_BITS;

/// How strong a gradient must be, values per world unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientThreshold {
    /// What is connected to something strong enough may be this weak.
    pub low: f64,
    /// Strong enough by itself.
    pub high: f64,
}

/// How often lengths of gradients occur, in logarithmic bins of 0.8 %.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lengths {
    counts: Vec<u64>,
}

/// The bin of a length; `None` for next to nothing and NaN.
#[inline]
fn bin(length: f32) -> Option<usize> {
    // The bits of a positive float ascend with it, and the upper ones are its logarithm.
    let key = |x: f32| x.to_bits() >> (f32::MANTISSA_DIGITS - 1 - BIN_BITS);
    (length >= FAINTEST).then(|| ((key(length) - key(FAINTEST)) as usize).min(BINS - 1))
}

/// The length in the middle of a bin.
fn middle(bin: usize) -> f64 {
    let octave = (bin >> BIN_BITS) as i32;
    let within = (bin & ((1 << BIN_BITS) - 1)) as f64 + 0.5;
    f64::from(FAINTEST) * 2f64.powi(octave) * (1.0 + within / f64::from(1u32 << BIN_BITS))
}

impl Lengths {
    pub(crate) fn new(regression: &Regression<'_>) -> Lengths {
        let [nx, _, nz] = regression.volume().dims();
        let layers = regression.layers(
            0..nz,
            |_| (vec![0u32; BINS], vec![0.0; nx]),
            |(counts, lengths), row| {
                regression.magnitudes(&row, lengths);
                lengths.iter().filter_map(|&l| bin(l)).for_each(|bin| counts[bin] += 1);
            },
        );
        let mut counts = vec![0; BINS];
        for (layer, _) in layers {
            counts.iter_mut().zip(layer).for_each(|(sum, n)| *sum += u64::from(n));
        }
        Lengths { counts }
    }

    /// Low and high level as [`Regression::magnitudes`] gives lengths; `None` if there are no gradients.
    pub(crate) fn levels(&self) -> Option<[f64; 2]> {
        let linear = otsu(&self.counts, middle)?;
        let logarithmic = otsu(&self.counts, |bin| middle(bin).ln())?.exp();
        Some([(linear * logarithmic).sqrt().min(linear), linear])
    }
}

/// Otsu's threshold of a histogram whose bins stand at `at`, ascending: the middle of the bins that do best. `None` if
/// all counts are 0.
pub(crate) fn otsu(counts: &[u64], at: impl Fn(usize) -> f64) -> Option<f64> {
    let weight = |bin: usize| counts[bin] as f64;
    let total: f64 = (0..counts.len()).map(weight).sum();
    let mean = (0..counts.len()).map(|bin| weight(bin) * at(bin)).sum::<f64>() / total;
    let (mut below, mut moment) = (0.0, 0.0);
    let mut best: Option<(f64, f64, f64)> = None;
    for bin in 0..counts.len() {
        below += weight(bin);
        moment += weight(bin) * (at(bin) - mean);
        let above = total - below;
        if below <= 0.0 || above <= 0.0 {
            continue;
        }
        // Means differ by moment (1/below + 1/above); the variance between is below · above · that squared / total².
        let between = moment * moment / (below * above);
        let edge = (at(bin) + at(bin + 1)) / 2.0;
        // Empty bins between two classes are equally good: the middle of them.
        match &mut best {
            Some((most, _, last)) if between == *most => *last = edge,
            Some((most, ..)) if between < *most => {}
            _ => best = Some((between, edge, edge)),
        }
    }
    match best {
        Some((_, first, last)) => Some((first + last) / 2.0),
        // One bin holds everything.
        None => (0..counts.len()).find(|&bin| counts[bin] > 0).map(at),
    }
}

impl Regression<'_> {
    /// Low and high level of the gradient; `None` if the volume has none. See the text of the module for the method;
    /// voxels next to which nothing changes take no part.
    pub fn threshold(&self) -> Option<GradientThreshold> {
        let [low, high] = Lengths::new(self).levels()?.map(|length| self.slope(length));
        Some(GradientThreshold { low, high })
    }

    /// The voxels above the low level in 26-connected pieces of more than `min_piece` voxels that reach the high level
    /// ([`MIN_PIECE`] by default).
    ///
    /// # Errors
    /// [`VolumeError::Size`] if there is no memory for two bits a voxel, or there are 2³² runs of voxels.
    pub fn boundaries(&self, threshold: GradientThreshold, min_piece: u64) -> Result<Mask, VolumeError> {
        let [low, high] = [threshold.low, threshold.high].map(|slope| (slope / self.slope(1.0)) as f32);
        let dims = self.volume().dims();
        let words = dims[0].div_ceil(WORD);
        let nz = dims[2];
        let rows = self.layers(
            0..nz,
            |_| (Vec::with_capacity(2 * words * dims[1]), vec![0.0; dims[0]]),
            |(bits, lengths), row| {
                self.magnitudes(&row, lengths);
                bits.extend(lengths.chunks(WORD).map(|chunk| word(chunk, low)));
                bits.extend(lengths.chunks(WORD).map(|chunk| word(chunk, high)));
            },
        );
        let mut mask = Mask::new(dims)?;
        pieces(dims, |z| &rows[z].0, min_piece, &mut mask)?;
        Ok(mask)
    }
}

/// A bit for each length that reaches the level.
#[inline]
fn word(lengths: &[f32], level: f32) -> u64 {
    lengths.iter().rev().fold(0, |word, &l| word << 1 | u64::from(l >= level))
}

/// A set of voxels, one bit each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    dims: [usize; 3],
    words: Vec<u64>,
}

impl Mask {
    fn new(dims: [usize; 3]) -> Result<Mask, VolumeError> {
        let [nx, ny, nz] = dims;
        let mut words: Vec<u64> = Vec::new();
        let len = nx.div_ceil(WORD) * ny * nz;
        words.try_reserve_exact(len).map_err(|_| VolumeError::Size(nx, ny, nz))?;
        words.resize(len, 0);
        Ok(Mask { dims, words })
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The voxels of a row along x, the first in the lowest bit of the first word; bits beyond the row are 0.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, y: usize, z: usize) -> &[u64] {
        let [nx, ny, nz] = self.dims;
        assert!(y < ny && z < nz, "row {y}, {z} of {ny} x {nz}");
        &self.words[nx.div_ceil(WORD) * (y + ny * z)..][..nx.div_ceil(WORD)]
    }

    /// True if the voxel is in the set.
    ///
    /// # Panics
    /// If there is no such voxel.
    pub fn contains(&self, x: usize, y: usize, z: usize) -> bool {
        assert!(x < self.dims[0], "voxel {x} of {}", self.dims[0]);
        self.row(y, z)[x / WORD] >> (x % WORD) & 1 == 1
    }

    /// How many voxels there are in the set.
    pub fn count(&self) -> u64 {
        self.words.iter().map(|w| u64::from(w.count_ones())).sum()
    }
}

/// Appends the runs of set bits in a row.
fn row_runs(row: &[u64], runs: &mut Vec<Run>) {
    let mut open: Option<u32> = None;
    for (w, &word) in row.iter().enumerate() {
        let base = (w * WORD) as u32;
        let mut at = 0;
        while at < 64 {
            // Bits of no interest are skipped in one step: zeros outside a run, ones within.
            let rest = if open.is_some() { !word } else { word } >> at;
            if rest == 0 {
                break;
            }
            at += rest.trailing_zeros();
            match open.take() {
                Some(start) => runs.push(Run { start, end: base + at }),
                None => open = Some(base + at),
            }
        }
    }
    if let Some(start) = open {
        runs.push(Run { start, end: (row.len() * WORD) as u32 });
    }
}

/// Sets in `mask` the pieces of more than `min_piece` voxels with a strong one. `layer(z)` gives for each row the words
/// of the weak voxels and then those of the strong ones.
fn pieces<'a>(
    [nx, ny, nz]: [usize; 3],
    layer: impl Fn(usize) -> &'a [u64] + Sync,
    min_piece: u64,
    mask: &mut Mask,
) -> Result<(), VolumeError> {
    let words = nx.div_ceil(WORD);
    let of_layer = |z| {
        let mut runs = LayerRuns::default();
        layer(z).chunks_exact(2 * words).for_each(|row| runs.row(|runs| row_runs(&row[..words], runs)));
        runs
    };
    let layers = (0..nz).into_par_iter().map(of_layer).collect();
    let runs = Runs::new(ny, layers).ok_or(VolumeError::Size(nx, ny, nz))?;
    let roots = runs.join();

    let mut sizes = vec![0u64; roots.len()];
    let mut strong = vec![false; roots.len()];
    for row in 0..ny * nz {
        let bits = &layer(row / ny)[2 * words * (row % ny) + words..][..words];
        for run in runs.row(row % ny, row / ny) {
            let (root, mut voxels) = (roots[run] as usize, runs.all()[run].voxels());
            sizes[root] += voxels.len() as u64;
            strong[root] |= voxels.any(|x| bits[x / WORD] >> (x % WORD) & 1 == 1);
        }
    }
    for (row, out) in mask.words.chunks_exact_mut(words).enumerate() {
        for run in runs.row(row % ny, row / ny) {
            let root = roots[run] as usize;
            if strong[root] && sizes[root] > min_piece {
                runs.all()[run].voxels().for_each(|x| out[x / WORD] |= 1 << (x % WORD));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hash(i: u64) -> u64 {
        let z = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z ^ z >> 27
    }

    /// Uniform numbers added up: nearly normal, deviation 1.
    fn normal(seed: u64) -> f64 {
        (0..12).map(|k| (hash(seed * 12 + k) >> 11) as f64 / (1u64 << 53) as f64).sum::<f64>() - 6.0
    }

    #[test]
    fn otsu_parts_two_gaussians_in_the_middle() {
        // Equal classes: the threshold lies half-way, whatever their distance.
        for apart in [4.0, 8.0, 20.0] {
            let mut counts = vec![0u64; 2000];
            for i in 0..200_000 {
                let x = 1000.0 + 20.0 * (normal(i) + if i % 2 == 0 { 0.0 } else { apart });
                counts[x as usize] += 1;
            }
            let threshold = otsu(&counts, |bin| bin as f64 + 0.5).unwrap();
            assert!((threshold - (1000.0 + 10.0 * apart)).abs() < 3.0, "{apart}: {threshold}");
        }
        assert_eq!(otsu(&[0, 0, 0], |bin| bin as f64), None);
        assert_eq!(otsu(&[0, 7, 0], |bin| bin as f64), Some(1.0));
        // An empty stretch between two peaks is cut in its middle.
        assert_eq!(otsu(&[5, 0, 0, 0, 5], |bin| bin as f64), Some(2.0));
    }

    #[test]
    fn bins_are_logarithmic_and_hold_their_middles() {
        for i in (0..BINS).step_by(37) {
            assert_eq!(bin(middle(i) as f32), Some(i));
        }
        assert_eq!((bin(0.0), bin(FAINTEST / 2.0), bin(f32::NAN)), (None, None, None));
        assert_eq!((bin(FAINTEST), bin(1e30)), (Some(0), Some(BINS - 1)));
    }

    /// Against a flood fill over single voxels.
    #[test]
    fn pieces_are_those_of_a_flood_fill() {
        for (seed, dims, fill) in
            [(1, [70, 9, 11], 9), (2, [64, 5, 4], 15), (3, [130, 7, 6], 30), (4, [3, 240, 1], 40)]
        {
            let [nx, ny, nz] = dims;
            let level = |x: usize, y: usize, z: usize| -> u8 {
                let h = hash(seed << 40 | (x + nx * (y + ny * z)) as u64) % 1000;
                u8::from(h < fill * 10) + u8::from(h < fill / 2)
            };
            let words = nx.div_ceil(WORD);
            let mut layers = vec![vec![0u64; 2 * words * ny]; nz];
            for (x, y, z) in all(dims) {
                for kind in 0..level(x, y, z) as usize {
                    layers[z][(2 * y + kind) * words + x / WORD] |= 1 << (x % WORD);
                }
            }
            let mut mask = Mask::new(dims).unwrap();
            pieces(dims, |z| &layers[z], 4, &mut mask).unwrap();

            let mut seen = vec![false; nx * ny * nz];
            let mut kept = 0;
            for (x, y, z) in all(dims) {
                if level(x, y, z) == 0 || seen[x + nx * (y + ny * z)] {
                    continue;
                }
                let (mut piece, mut next) = (vec![(x, y, z)], 0);
                seen[x + nx * (y + ny * z)] = true;
                while next < piece.len() {
                    let (x, y, z) = piece[next];
                    next += 1;
                    for (p, q, r) in all([3, 3, 3]) {
                        let (p, q, r) =
                            ((x + p).wrapping_sub(1), (y + q).wrapping_sub(1), (z + r).wrapping_sub(1));
                        if p < nx && q < ny && r < nz && level(p, q, r) > 0 {
                            let i = p + nx * (q + ny * r);
                            if !std::mem::replace(&mut seen[i], true) {
                                piece.push((p, q, r));
                            }
                        }
                    }
                }
                let keep = piece.len() > 4 && piece.iter().any(|&(x, y, z)| level(x, y, z) == 2);
                assert!(piece.iter().all(|&(x, y, z)| mask.contains(x, y, z) == keep));
                kept += u64::from(keep) * piece.len() as u64;
            }
            assert_eq!(mask.count(), kept);
            assert!(kept > 0, "the field {seed} tests nothing");
        }
    }

    fn all([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
        (0..nx * ny * nz).map(move |i| (i % nx, i / nx % ny, i / nx / ny))
    }
}
