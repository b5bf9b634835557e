//! The value window: which values the 16 bits of a prepared volume span.

use super::PrepareError;
use crate::samples::{Ordered, Samples};
use crate::volume::{Scaling, Volume};

/// What a window of 0…1 becomes.
pub(super) const STEPS: f64 = 65535.0;

/// Bins of the histogram: one for each sample of a 16-bit type.
const BINS: usize = 1 << 16;

/// Bins of the coarse histogram in which the air is sought.
const COARSE: usize = 256;

/// Air is at least this share of the values.
const AIR_SHARE: f64 = 0.1;

/// Its peak is this many times as high as the histogram is on average.
const AIR_HEIGHT: u64 = 4;

/// The peak of the air ends where the histogram has fallen to this share of its height, or rises again.
const AIR_FOOT: f64 = 0.01;

/// The window of a volume: as asked for, or found.
///
/// The upper end is the 99.9 % percentile of the values above the air, so that a small thing in much air is not cut
/// off. The lower end is the air itself, since the face between it and the object is what gets drawn: the most common
/// value there, so that noise below and fill values of scanners (−3024) count as air. Without air it is the
/// 0.1 % percentile.
pub(super) fn window(volume: &Volume, wanted: Option<[f64; 2]>) -> Result<[f64; 2], PrepareError> {
    let (min, max) = volume.value_range().ok_or(PrepareError::NoValues)?;
    if min == max {
        return Err(PrepareError::Flat { value: min });
    }
    let [low, high] = match wanted {
        Some(window) => window,
        None => found(volume, [min, max]),
    };
    let slope = high / STEPS - low / STEPS;
    if !(low < high && (high - low).is_finite() && slope > 0.0 && low < max && high > min) {
        return Err(PrepareError::Window { low, high, min, max });
    }
    Ok([low, high])
}

fn found(volume: &Volume, [min, max]: [f64; 2]) -> [f64; 2] {
    let Some(histogram) = volume.histogram(BINS) else { return [min, max] };
    let counts = &histogram.counts;
    // Integers stand at the middle of bins one integer wide. Values of wider bins are taken at their lower and upper
    // edges, so that nothing is cut off.
    let integers = !matches!(volume.samples(), Samples::F32(_) | Samples::F64(_));
    let exact = integers && (histogram.width() / volume.scaling().slope.abs() - 1.0).abs() < 1e-6;
    let edge = |bin: usize, side: f64| {
        let side = if exact { 0.5 } else { side };
        (histogram.min + (bin as f64 + side) * histogram.width()).clamp(min, max)
    };
    let (first, last) = percentiles(counts, 0);
    // Outliers may have squeezed the rest into a few bins.
    if !exact && last - first < COARSE {
        return match volume.stats() {
            Some(stats) if stats.low < stats.high => [stats.low, stats.high],
            _ => [min, max],
        };
    }
    let mut ends = [edge(first, 0.0), edge(last, 1.0)];
    if let Some(air) = air(&counts[first..=last]) {
        let (_, top) = percentiles(counts, first + air.end);
        ends = [edge(first + air.level, 0.5), edge(top, 1.0)];
    }
    if ends[0] < ends[1] { ends } else { [min, max] }
}

/// The bins of the 0.1 % and the 99.9 % percentile of what lies in bins `from..`.
fn percentiles(counts: &[u64], from: usize) -> (usize, usize) {
    let all: u64 = counts[from..].iter().sum();
    let at = |share: f64| {
        let rank = (all.saturating_sub(1) as f64 * share).round() as u64;
        let mut up_to = 0;
        let found = counts[from..].iter().position(|n| {
            up_to += n;
            up_to > rank
        });
        from + found.unwrap_or(0)
    };
    (at(0.001), at(0.999))
}

/// The peak of the air, in bins.
struct Air {
    /// The most common value.
    level: usize,
    /// The first bin above the peak.
    end: usize,
}

/// The air, if there is any: the highest peak lies low, holds many values, and most others lie above. The zeros of a
/// signed field are no air.
fn air(counts: &[u64]) -> Option<Air> {
    let width = counts.len().div_ceil(COARSE);
    let coarse: Vec<u64> = counts.chunks(width).map(|bins| bins.iter().sum()).collect();
    let all: u64 = coarse.iter().sum();
    let highest = |counts: &[u64]| -> Option<usize> {
        let most = counts.iter().max()?;
        counts.iter().position(|n| n == most)
    };
    let peak = highest(&coarse)?;
    // Three bins at a time: where the next count is the higher one by chance, the peak has not ended.
    let around = |i: usize| coarse[i - 1..coarse.len().min(i + 2)].iter().sum::<u64>();
    let foot = AIR_FOOT * coarse[peak] as f64;
    let falls = |i: usize| coarse[i] as f64 > foot && (i == peak + 1 || around(i) <= around(i - 1));
    let end = (peak + 1..coarse.len()).find(|&i| !falls(i))?;
    let begin = (0..peak).rev().find(|&i| coarse[i] as f64 <= foot).map_or(0, |i| i + 1);
    let sum = |range: std::ops::Range<usize>| coarse[range].iter().sum::<u64>();
    // Below air there is nothing but the scanner's fill value, which is the first of all.
    let below = sum(begin.min(1)..begin);
    let above = sum(end..coarse.len());
    let is_low = 3 * peak < 2 * coarse.len() && 4 * below < above;
    let is_peak = coarse[peak] * coarse.len() as u64 >= AIR_HEIGHT * all;
    if !is_low || !is_peak || (sum(begin..end) as f64) < AIR_SHARE * all as f64 {
        return None;
    }
    let fine = &counts[peak * width..counts.len().min((peak + 1) * width)];
    Some(Air { level: peak * width + highest(fine)?, end: (end * width).min(counts.len()) })
}

/// From stored samples to 0…65535 of the window.
#[derive(Clone, Copy)]
pub(super) struct ToUnit {
    /// The sample that becomes 0.
    zero: f64,
    /// Negative where values fall as samples rise.
    factor: f64,
}

impl ToUnit {
    pub(super) fn new(scaling: Scaling, [low, high]: [f64; 2]) -> ToUnit {
        let zero = scaling.sample(low);
        ToUnit { zero, factor: STEPS / (scaling.sample(high) - zero) }
    }

    /// Converts a row; what is outside of the window becomes its end, NaN becomes 0.
    pub(super) fn convert<T: Ordered>(self, samples: &[T], out: &mut [f32]) {
        let clamped = |x: f32| {
            // NaN fails the first comparison.
            let x = if x > 0.0 { x } else { 0.0 };
            if x < STEPS as f32 { x } else { STEPS as f32 }
        };
        if T::KEY_BITS <= 16 {
            // Single precision holds the samples exactly, and the window's end to 1/256 of one.
            let (zero, factor) = (self.zero as f32, self.factor as f32);
            for (out, s) in out.iter_mut().zip(samples) {
                *out = clamped((s.to_f64() as f32 - zero) * factor);
            }
        } else {
            for (out, s) in out.iter_mut().zip(samples) {
                *out = clamped((s.minus_real(self.zero) * self.factor) as f32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affine::Affine;

    fn volume_of(counts: &[(i16, usize)], scaling: Scaling) -> Volume {
        let samples: Vec<i16> = counts.iter().flat_map(|&(v, n)| std::iter::repeat_n(v, n)).collect();
        let affine = Affine::from_spacing([1.0; 3]);
        Volume::new([samples.len(), 1, 1], Samples::I16(samples), scaling, affine).unwrap()
    }

    /// A scan: fill value, noisy air, tissue, and a bone that is a thousandth of the tissue.
    fn scan() -> Vec<(i16, usize)> {
        let peak = |at: i16, half: i16, n: usize| {
            (-half..=half).map(move |d| (at + d, n * usize::from((half + 1 - d.abs()) as u16)))
        };
        let mut counts = vec![(-3024, 4000)];
        counts.extend(peak(-1000, 30, 30));
        counts.extend(peak(40, 50, 5));
        counts.extend(peak(1500, 5, 1));
        counts
    }

    #[test]
    fn the_window_begins_in_the_air_and_ends_with_the_object() {
        let [low, high] = window(&volume_of(&scan(), Scaling::default()), None).unwrap();
        assert!((low + 1000.0).abs() <= 1.0 && (1494.0..=1505.0).contains(&high), "{low} {high}");
        // The same turned round and scaled: samples fall where values rise.
        let scaling = Scaling { slope: -0.5, intercept: 7.0 };
        let turned: Vec<(i16, usize)> = scan().into_iter().map(|(v, n)| (-v, n)).collect();
        let [turned_low, turned_high] = window(&volume_of(&turned, scaling), None).unwrap();
        assert!(
            (turned_low - (0.5 * low + 7.0)).abs() <= 1.0 && (turned_high - (0.5 * high + 7.0)).abs() <= 1.0
        );
    }

    #[test]
    fn masks_and_sparse_things_are_not_cut_off() {
        for n in [1, 100, 900] {
            let mask = volume_of(&[(0, 1000), (1, n)], Scaling::default());
            assert_eq!(window(&mask, None).unwrap(), [0.0, 1.0]);
            let labels = volume_of(&[(0, 1000), (100, n), (101, n)], Scaling::default());
            assert_eq!(window(&labels, None).unwrap(), [0.0, 101.0]);
        }
    }

    #[test]
    fn without_air_the_window_is_the_percentiles() {
        let even: Vec<(i16, usize)> = (0..2000).map(|v| (v, 5)).collect();
        assert_eq!(window(&volume_of(&even, Scaling::default()), None).unwrap(), [2.0, 1997.0]);
        let noise: Vec<(i16, usize)> = (0..2000).map(|v| (v, 3 + (v as usize * 7919) % 5)).collect();
        let [low, high] = window(&volume_of(&noise, Scaling::default()), None).unwrap();
        assert!(low < 5.0 && high > 1995.0, "{low} {high}");
        // Bright surround: the most common value is no air.
        let inverted = volume_of(&[(0, 50), (10, 500), (200, 5000)], Scaling::default());
        assert_eq!(window(&inverted, None).unwrap(), [0.0, 200.0]);
        let mut signed: Vec<(i16, usize)> = (-1000..=1000).map(|v| (v, 5)).collect();
        signed.push((0, 50_000));
        let [low, high] = window(&volume_of(&signed, Scaling::default()), None).unwrap();
        assert!(low < -980.0 && high > 980.0, "{low} {high}");
    }

    #[test]
    fn windows_that_hold_nothing_are_refused() {
        let ramp: Vec<(i16, usize)> = (0..100).map(|v| (v, 1)).collect();
        let ramp = volume_of(&ramp, Scaling::default());
        for wanted in
            [[5.0, 5.0], [6.0, 5.0], [f64::NAN, 1.0], [0.0, f64::INFINITY], [99.0, 200.0], [-5.0, 0.0]]
        {
            assert!(matches!(window(&ramp, Some(wanted)), Err(PrepareError::Window { .. })), "{wanted:?}");
        }
        assert_eq!(window(&ramp, Some([-10.0, 50.0])).unwrap(), [-10.0, 50.0]);
        let flat = volume_of(&[(3, 10)], Scaling { slope: 2.0, intercept: 1.0 });
        assert_eq!(window(&flat, Some([0.0, 50.0])), Err(PrepareError::Flat { value: 7.0 }));
    }

    #[test]
    fn wide_types_with_outliers_keep_their_bulk() {
        let mut samples: Vec<f32> = (0..100_000).map(|i| (i % 1000) as f32 * 1e-3).collect();
        samples[77] = 1e30;
        samples[78] = -1e30;
        let volume = Volume::from_slice([1000, 100, 1], [1.0; 3], &samples).unwrap();
        let [low, high] = window(&volume, None).unwrap();
        assert!(low.abs() < 0.01 && (high - 1.0).abs() < 0.01, "{low} {high}");
    }
}
