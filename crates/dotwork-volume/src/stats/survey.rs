//! Range and gaps of wide types in one pass, their moments in another.
//!
//! Sums are taken over blocks of a fixed size, in lanes side by side, and then over the blocks in order: the result
//! does not depend on the number of threads.

use rayon::prelude::*;

use crate::samples::Ordered;

/// Samples in a block of work.
const BLOCK: usize = 1 << 14;

/// Minima, maxima and sums side by side, so that none waits for the one before.
const LANES: usize = 16;

/// What one pass over the samples finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Survey<T> {
    /// Smallest and largest finite sample.
    pub range: Option<(T, T)>,
    pub nans: u64,
    /// Samples of −∞, and of ∞.
    pub infinite: [u64; 2],
}

/// One pass for range and gaps.
pub(super) fn survey<T: Ordered>(samples: &[T]) -> Survey<T> {
    let nothing = || Survey { range: None, nans: 0, infinite: [0; 2] };
    samples.par_chunks(BLOCK).map(Survey::of).reduce(nothing, Survey::and)
}

fn lesser<T: PartialOrd>(a: T, b: T) -> T {
    if b < a { b } else { a }
}

fn greater<T: PartialOrd>(a: T, b: T) -> T {
    if b > a { b } else { a }
}

impl<T: Ordered> Survey<T> {
    fn of(block: &[T]) -> Survey<T> {
        let mut survey = Survey { range: None, nans: 0, infinite: [0; 2] };
        let Some(&first) = block.first() else { return survey };
        if !T::FLOAT {
            // The compiler finds the lanes: the order of integer minima does not matter.
            let min = block.iter().copied().fold(first, lesser);
            survey.range = Some((min, block.iter().copied().fold(first, greater)));
            return survey;
        }
        let (groups, rest) = block.as_chunks::<LANES>();
        if groups.iter().all(|group| group.iter().fold(true, |all, s| all & s.is_finite())) {
            if let Some(&first) = groups.first() {
                let (mut min, mut max) = (first, first);
                for group in groups {
                    for i in 0..LANES {
                        min[i] = lesser(min[i], group[i]);
                        max[i] = greater(max[i], group[i]);
                    }
                }
                let min = min.into_iter().fold(first[0], lesser);
                survey.range = Some((min, max.into_iter().fold(first[0], greater)));
            }
            rest.iter().for_each(|&s| survey.add(s));
        } else {
            block.iter().for_each(|&s| survey.add(s));
        }
        survey
    }

    fn add(&mut self, s: T) {
        if s.is_finite() {
            let (min, max) = self.range.unwrap_or((s, s));
            self.range = Some((lesser(min, s), greater(max, s)));
        } else if s.is_nan() {
            self.nans += 1;
        } else {
            self.infinite[usize::from(s.to_f64() > 0.0)] += 1;
        }
    }

    fn and(self, other: Survey<T>) -> Survey<T> {
        let range = match (self.range, other.range) {
            (Some((a, b)), Some((c, d))) => Some((lesser(a, c), greater(b, d))),
            (a, b) => a.or(b),
        };
        Survey {
            range,
            nans: self.nans + other.nans,
            infinite: [0, 1].map(|i| self.infinite[i] + other.infinite[i]),
        }
    }

    /// The range as numbers.
    pub(super) fn values(&self) -> Option<[f64; 2]> {
        self.range.map(|(min, max)| [min.to_f64(), max.to_f64()])
    }

    /// Samples that are finite, of `all`.
    pub(super) fn finite(&self, all: usize) -> u64 {
        all as u64 - self.nans - self.infinite[0] - self.infinite[1]
    }
}

/// Mean and standard deviation of the finite samples.
pub(super) fn moments<T: Ordered>(samples: &[T], survey: &Survey<T>) -> (f64, f64) {
    let Some([min, max]) = survey.values().filter(|[min, max]| min < max) else {
        return (survey.values().map_or(f64::NAN, |[min, _]| min), 0.0);
    };
    // In units of half the range about its middle, all samples are in −1…1: nothing overflows, and what cancels in
    // the difference below is small against the range. Halves first: the range may be twice the largest float.
    let (middle, reach) = (min / 2.0 + max / 2.0, max / 2.0 - min / 2.0);
    let scale = (reach / 2.0).max(f64::MIN_POSITIVE).recip();
    let all_finite = survey.finite(samples.len()) == samples.len() as u64;
    let scaled = |s: T| {
        let x = (s.to_f64() * 0.5 - middle * 0.5) * scale;
        if all_finite || s.is_finite() { x } else { 0.0 }
    };
    let blocks: Vec<[f64; 2]> = samples
        .par_chunks(BLOCK)
        .map(|block| {
            let (groups, rest) = block.as_chunks::<LANES>();
            let (mut sum, mut squares) = ([0.0; LANES], [0.0; LANES]);
            for group in groups {
                for i in 0..LANES {
                    let x = scaled(group[i]);
                    sum[i] += x;
                    squares[i] += x * x;
                }
            }
            let of_rest = |f: fn(f64) -> f64| rest.iter().map(|&s| f(scaled(s))).sum::<f64>();
            [sum.iter().sum::<f64>() + of_rest(|x| x), squares.iter().sum::<f64>() + of_rest(|x| x * x)]
        })
        .collect();
    let n = survey.finite(samples.len()) as f64;
    let [mean, square] = [0, 1].map(|i| blocks.iter().map(|b| b[i]).sum::<f64>() / n);
    (middle + mean * reach, (square - mean * mean).max(0.0).sqrt() * reach)
}
