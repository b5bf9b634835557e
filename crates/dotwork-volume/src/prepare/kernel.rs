//! Resampling and smoothing along one axis, as one sparse matrix.
//!
//! Both steps are linear and separable, so that their product along an axis is a short list of weights for each
//! result sample, borders included:
//!
//! * Between samples the field is what cubic convolution says (Robert G. Keys, *Cubic Convolution Interpolation for
//!   Digital Image Processing*, 1981, with a = −1/2): it meets the samples, reproduces quadratics, and needs 4 of them.
//! * Smoothing takes a sampled Gaussian whose variance is made to be σ² exactly. Sampled as it stands it is 14 % short
//!   of that at σ = ½, and cutting the tails takes more.

use super::grid::Axis;

/// The share of the Gaussian that may be cut off, both ends together.
const TAIL: f64 = 1.0 / 1024.0;

/// Gaussians narrower than this are no more than rounding.
const NARROW: f64 = 1e-2;

/// For each result sample along an axis the weights of consecutive source samples.
pub(super) struct Weights {
    /// The first source sample that counts.
    first: Vec<usize>,
    /// Where the weights of a result sample begin; one more entry at the end.
    start: Vec<usize>,
    values: Vec<f32>,
    /// The Gaussian alone, an odd number of weights about its middle.
    pub gaussian: Vec<f32>,
}

impl Weights {
    /// Cubic convolution from the source to the result, then a Gaussian of `sigma` result voxels.
    ///
    /// Beyond the border the source is 0 if `zero_outside`, and its last sample if not.
    pub(super) fn new(axis: &Axis, sigma: f64, zero_outside: bool) -> Weights {
        let gaussian = gaussian(sigma);
        let reach = gaussian.len() as i64 / 2;
        let last = axis.kept as i64 - 1;
        let mut weights = Weights {
            first: Vec::with_capacity(axis.len),
            start: vec![0],
            values: Vec::new(),
            gaussian: gaussian.iter().map(|&w| w as f32).collect(),
        };
        // Cubic convolution looks one sample back and two ahead. Lists are as long as that may be, zeros and all: their
        // first and last samples then ascend.
        let (back, ahead) = if axis.is_unresampled() { (0, 0) } else { (1, 2) };
        let mut sums: Vec<f64> = Vec::new();
        for k in 0..axis.len as i64 {
            let (lowest, highest) = (axis.source(k - reach).0 - back, axis.source(k + reach).0 + ahead);
            let (from, to) = if zero_outside {
                (lowest.max(0), highest.min(last))
            } else {
                (lowest.clamp(0, last), highest.clamp(0, last))
            };
            if from > to {
                weights.first.push(0);
                weights.start.push(weights.values.len());
                continue;
            }
            sums.clear();
            sums.resize((to - from + 1) as usize, 0.0);
            for (t, g) in (-reach..=reach).zip(&gaussian) {
                let (base, fraction) = axis.source(k + t);
                for (at, w) in (base - 1..).zip(keys(fraction)).filter(|(_, w)| *w != 0.0) {
                    let inside = at.clamp(0, last);
                    if at == inside || !zero_outside {
                        sums[(inside - from) as usize] += g * w;
                    }
                }
            }
            weights.first.push(from as usize);
            weights.values.extend(sums.iter().map(|&w| w as f32));
            weights.start.push(weights.values.len());
        }
        weights
    }

    /// The first source sample of result sample `k`, and the weights from there on; none where the result is 0.
    pub(super) fn of(&self, k: usize) -> (usize, &[f32]) {
        (self.first[k], &self.values[self.start[k]..self.start[k + 1]])
    }

    /// The source samples that some of the result samples `from..to` need.
    pub(super) fn span(&self, from: usize, to: usize) -> std::ops::Range<usize> {
        // First and last source samples ascend with the result.
        let used = |&k: &usize| self.start[k] < self.start[k + 1];
        match ((from..to).find(used), (from..to).rfind(used)) {
            (Some(first), Some(last)) => self.first[first]..self.first[last] + self.of(last).1.len(),
            _ => 0..0,
        }
    }

    /// The longest list.
    pub(super) fn longest(&self) -> usize {
        self.start.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0)
    }
}

/// Keys' cubic at `f` in 0…1 from the second of four samples towards the third.
fn keys(f: f64) -> [f64; 4] {
    let (f2, f3) = (f * f, f * f * f);
    [-0.5 * f + f2 - 0.5 * f3, 1.0 - 2.5 * f2 + 1.5 * f3, 0.5 * f + 2.0 * f2 - 1.5 * f3, -0.5 * f2 + 0.5 * f3]
}

/// Weights that sum to 1 and whose variance is `sigma`² to rounding, though the tails are cut off.
fn gaussian(sigma: f64) -> Vec<f64> {
    if sigma < NARROW {
        return vec![1.0];
    }
    let mut reach = (8.0 * sigma) as usize + 8;
    let half = matched(sigma, reach);
    let mut tail = 0.0;
    while reach > 1 && tail + 2.0 * half[reach] < TAIL {
        tail += 2.0 * half[reach];
        reach -= 1;
    }
    let half = matched(sigma, reach);
    half[1..].iter().rev().chain(&half).copied().collect()
}

/// Weights 0…`reach` of the sampled Gaussian that has the variance `sigma`² when it ends there.
fn matched(sigma: f64, reach: usize) -> Vec<f64> {
    let sampled = |width: f64| -> Vec<f64> {
        let weights = (0..=reach).map(|n| (-0.5 * (n as f64 / width).powi(2)).exp());
        let half: Vec<f64> = weights.collect();
        let sum = half[0] + 2.0 * half[1..].iter().sum::<f64>();
        half.into_iter().map(|w| w / sum).collect()
    };
    let variance =
        |half: &[f64]| -> f64 { half.iter().enumerate().map(|(n, w)| 2.0 * (n * n) as f64 * w).sum() };
    let (mut low, mut high) = (0.5 * sigma, 1.5 * sigma + 0.5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if variance(&sampled(middle)) < sigma * sigma { low = middle } else { high = middle }
    }
    sampled(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(weights: &[f64], power: i32) -> f64 {
        let middle = (weights.len() / 2) as f64;
        weights.iter().enumerate().map(|(i, w)| w * (i as f64 - middle).powi(power)).sum()
    }

    #[test]
    fn gaussians_have_the_variance_asked_for() {
        for sigma in [0.02, 0.1, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0, 5.0, 32.0] {
            let g = gaussian(sigma);
            assert!((moment(&g, 0) - 1.0).abs() < 1e-12 && moment(&g, 1).abs() < 1e-12, "{sigma}");
            assert!((moment(&g, 2) / (sigma * sigma) - 1.0).abs() < 1e-9, "{sigma}: {}", moment(&g, 2));
            // Falls from the middle outwards, and is no longer than 4 sigma and a bit.
            let half = &g[g.len() / 2..];
            assert!(half.windows(2).all(|pair| pair[0] > pair[1] && pair[1] >= 0.0), "{sigma}");
            assert!(half.len() as f64 <= 4.0 * sigma + 2.0, "{sigma}: {}", g.len());
        }
        assert_eq!(gaussian(0.5).len(), 5);
        assert_eq!(gaussian(0.0), [1.0]);
    }

    #[test]
    fn cubic_convolution_reproduces_quadratics() {
        let f = |x: f64| 3.0 + 2.0 * x - 0.7 * x * x;
        for i in 0..=16 {
            let x = f64::from(i) / 16.0;
            let sum: f64 = (-1..).zip(keys(x)).map(|(at, w)| w * f(f64::from(at))).sum();
            assert!((sum - f(x)).abs() < 1e-12);
        }
    }

    /// Against the two steps one after the other, written plainly.
    #[test]
    fn the_matrix_is_interpolation_and_then_smoothing() {
        let source: Vec<f64> = (0..9).map(|i| f64::from(i * i * 37 % 23)).collect();
        for (kept, num, den, pad, len) in
            [(9, 1, 1, 0, 9), (9, 8, 20, 0, 21), (9, 8, 25, 10, 46), (1, 1, 1, 3, 7)]
        {
            let axis = Axis { from: 0, kept, pad, len, num, den };
            for (sigma, zero) in [(0.0, true), (0.5, false), (1.3, true), (1.3, false)] {
                let weights = Weights::new(&axis, sigma, zero);
                let sample = |at: i64| {
                    let inside = at.clamp(0, kept as i64 - 1);
                    if zero && at != inside { 0.0 } else { source[inside as usize] }
                };
                let fine = |k: i64| -> f64 {
                    let position = (k - pad as i64) as f64 * num as f64 / den as f64;
                    let base = (position + 1e-9).floor();
                    (base as i64 - 1..)
                        .zip(keys((position - base).max(0.0)))
                        .map(|(at, w)| w * sample(at))
                        .sum()
                };
                let g = gaussian(sigma);
                for k in 0..len {
                    let expected: f64 =
                        (k as i64 - g.len() as i64 / 2..).zip(&g).map(|(at, w)| w * fine(at)).sum();
                    let (first, row) = weights.of(k);
                    let got: f64 = source[first..].iter().zip(row).map(|(s, w)| s * f64::from(*w)).sum();
                    assert!(
                        (got - expected).abs() < 1e-5,
                        "{kept} {den} {sigma} {zero} at {k}: {got} {expected}"
                    );
                }
                assert!(weights.span(0, len).end <= kept);
                let ends: Vec<_> =
                    (0..len).map(|k| weights.span(k, k + 1)).filter(|s| !s.is_empty()).collect();
                assert!(ends.is_sorted_by(|a, b| a.start <= b.start && a.end <= b.end));
            }
        }
    }
}
