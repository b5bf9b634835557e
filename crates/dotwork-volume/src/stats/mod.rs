//! What the values of a volume are like: range, mean, spread, percentiles, histogram.
//!
//! Everything is exact up to rounding, percentiles too, and the same on any number of threads. Types of up to 16 bits
//! are counted once, and the rest follows from the counts (`count`); wider ones take one pass for the range, one for
//! the moments (`survey`), and two to four for the percentiles.

mod count;
mod survey;

use crate::samples::Ordered;
use crate::volume::{Scaling, Volume};
use count::{DIGIT, KeyCounts};
use survey::survey;

/// Facts about the finite values of a volume. Infinities and NaN are counted and otherwise left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeStats {
    /// Values that are finite.
    pub count: u64,
    /// Values that are NaN.
    pub nans: u64,
    /// Values that are ∞ or −∞.
    pub infinities: u64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
    /// The mean.
    pub mean: f64,
    /// The standard deviation (the root of the mean squared distance from the mean).
    pub deviation: f64,
    /// The 0.1 % percentile: the value at rank `round(0.001 (count − 1))`.
    pub low: f64,
    /// The median, in the same sense.
    pub median: f64,
    /// The 99.9 % percentile, in the same sense.
    pub high: f64,
}

/// How often values occur, in bins of equal width.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// The lower edge of the first bin.
    pub min: f64,
    /// The upper edge of the last bin.
    pub max: f64,
    /// Values in each bin, ascending. A value between two bins belongs to one of them, the same for equal values.
    pub counts: Vec<u64>,
}

impl Histogram {
    /// The width of a bin; 0 if all values of a float volume are equal.
    pub fn width(&self) -> f64 {
        (self.max - self.min) / self.counts.len() as f64
    }
}

impl Volume {
    /// Facts about the finite values; `None` if there are none.
    pub fn stats(&self) -> Option<VolumeStats> {
        with_samples!(self.samples(), samples => stats(samples, self.scaling()))
    }

    /// The smallest and the largest finite value; `None` if there are none.
    pub fn value_range(&self) -> Option<(f64, f64)> {
        let range = with_samples!(self.samples(), samples => survey(samples).values())?;
        let [a, b] = range.map(|s| self.scaling().value(s));
        Some((a.min(b), a.max(b)))
    }

    /// How often finite values occur, in at most `bins` bins (at least 1) from the smallest to the largest; `None` if
    /// there are none.
    ///
    /// Floats have exactly `bins` bins, or 1 if all values are equal. For integers every bin spans the same whole
    /// number of stored integers, with its edges half-way between them, so no bin is favoured; there may be fewer
    /// bins, and the last may reach beyond the largest value.
    pub fn histogram(&self, bins: usize) -> Option<Histogram> {
        with_samples!(self.samples(), samples => histogram(samples, self.scaling(), bins.max(1)))
    }
}

fn stats<T: Ordered>(samples: &[T], scaling: Scaling) -> Option<VolumeStats> {
    // Values descend where the slope is negative.
    let rising = scaling.slope > 0.0;
    let ranks = |count: u64| {
        let ranks = [0.001, 0.5, 0.999].map(|share| ((count - 1) as f64 * share).round() as u64);
        if rising { ranks } else { [ranks[2], ranks[1], ranks[0]].map(|rank| count - 1 - rank) }
    };
    let (min, max, mean, deviation, percentiles);
    let (mut count, mut nans, mut infinities) = (samples.len() as u64, 0, 0);
    if T::KEY_BITS <= DIGIT {
        let counts = KeyCounts::new(samples);
        (min, max) = counts.range::<T>()?;
        (mean, deviation) = counts.moments::<T>();
        percentiles = ranks(count).map(|rank| counts.at_rank::<T>(rank));
    } else {
        let found = survey(samples);
        (min, max) = found.range?;
        (mean, deviation) = survey::moments(samples, &found);
        let [below, above] = found.infinite;
        (count, nans, infinities) = (found.finite(samples.len()), found.nans, below + above);
        percentiles = count::select(samples, ranks(count).map(|rank| below + rank));
    }

    let mut ordered = [min, percentiles[0], percentiles[1], percentiles[2], max];
    if !rising {
        ordered.reverse();
    }
    let [min, low, median, high, max] = ordered.map(|s| scaling.value(s.to_f64()));
    Some(VolumeStats {
        count,
        nans,
        infinities,
        min,
        max,
        mean: scaling.value(mean),
        deviation: scaling.slope.abs() * deviation,
        low,
        median,
        high,
    })
}

fn histogram<T: Ordered>(samples: &[T], scaling: Scaling, bins: usize) -> Option<Histogram> {
    let (edges, mut counts) = if T::FLOAT {
        float_histogram(samples, bins)?
    } else if T::KEY_BITS <= DIGIT {
        let keys = KeyCounts::new(samples);
        let bins = IntegerBins::new::<T>(keys.range()?, bins);
        let mut counts = vec![0; bins.count];
        keys.present().for_each(|(key, n)| counts[bins.of(key)] += n);
        (bins.edges, counts)
    } else {
        let bins = IntegerBins::new::<T>(survey(samples).range?, bins);
        (bins.edges, count::tally(samples, bins.count, |s| Some(bins.of(s.key()))))
    };
    let [mut min, mut max] = edges.map(|s| scaling.value(s));
    if scaling.slope < 0.0 {
        (min, max) = (max, min);
        counts.reverse();
    }
    Some(Histogram { min, max, counts })
}

/// Edges and counts of `bins` bins over the range of finite samples.
fn float_histogram<T: Ordered>(samples: &[T], bins: usize) -> Option<([f64; 2], Vec<u64>)> {
    let [low, high] = survey(samples).values()?;
    // Halves, so that the range of the largest floats does not overflow.
    let reach = high / 2.0 - low / 2.0;
    let bins = if reach > 0.0 { bins } else { 1 };
    let scale = bins as f64 / reach.max(f64::MIN_POSITIVE);
    let bin = |s: T| (((s.to_f64() / 2.0 - low / 2.0) * scale) as usize).min(bins - 1);
    Some(([low, high], count::tally(samples, bins, |s| s.is_finite().then(|| bin(s)))))
}

/// Bins of the same whole number of integers each.
struct IntegerBins {
    count: usize,
    /// The key of the smallest sample.
    first: u64,
    /// Integers in a bin.
    width: u64,
    /// Lower edge of the first and upper edge of the last.
    edges: [f64; 2],
}

impl IntegerBins {
    /// At most `most` bins from `min` to `max`.
    fn new<T: Ordered>((min, max): (T, T), most: usize) -> IntegerBins {
        let span = u128::from(max.key() - min.key()) + 1;
        let width = span.div_ceil(most as u128);
        let count = span.div_ceil(width) as usize;
        let low = min.to_f64() - 0.5;
        IntegerBins {
            count,
            first: min.key(),
            // A width of 2^64 has one bin.
            width: u64::try_from(width).unwrap_or(u64::MAX),
            edges: [low, low + (width * count as u128) as f64],
        }
    }

    fn of(&self, key: u64) -> usize {
        (((key - self.first) / self.width) as usize).min(self.count - 1)
    }
}
