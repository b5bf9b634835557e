//! Statistics against sorted samples, and histograms against counts by hand.

mod common;

use common::hash;
use dotwork_volume::{Affine, Sample, Scaling, Volume};

const DIMS: [usize; 3] = [41, 37, 83];

fn count() -> usize {
    DIMS.iter().product()
}

fn scaled<T: Sample>(samples: &[T], slope: f64, intercept: f64) -> Volume {
    let affine = Affine::from_spacing([1.0; 3]);
    Volume::new(DIMS, T::wrap(samples.to_vec()), Scaling { slope, intercept }, affine).unwrap()
}

/// Compares with what sorting and plain sums give.
fn check<T: Sample>(samples: &[T], slope: f64, intercept: f64) {
    let stats = scaled(samples, slope, intercept).stats().unwrap();
    let mut values: Vec<f64> = samples.iter().map(|s| slope * s.to_f64() + intercept).collect();
    let all = values.len();
    let nans = values.iter().filter(|v| v.is_nan()).count();
    values.retain(|v| v.is_finite());
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let rank = |share: f64| values[((n - 1) as f64 * share).round() as usize];
    let name = T::TYPE.name();
    assert_eq!((stats.count, stats.nans), (n as u64, nans as u64), "{name}");
    assert_eq!(stats.infinities, (all - nans - n) as u64, "{name}");
    assert_eq!((stats.min, stats.max), (values[0], values[n - 1]), "{name}");
    assert_eq!([stats.low, stats.median, stats.high], [rank(0.001), rank(0.5), rank(0.999)], "{name}");
    let mean = values.iter().map(|v| v / n as f64).sum::<f64>();
    let deviation = values.iter().map(|v| (v - mean).powi(2) / n as f64).sum::<f64>().sqrt();
    let range = stats.max - stats.min;
    assert!((stats.mean - mean).abs() < 1e-12 * range, "{name}: {} {mean}", stats.mean);
    assert!((stats.deviation - deviation).abs() < 1e-9 * deviation, "{name}: {}", stats.deviation);
    assert_eq!(scaled(samples, slope, intercept).value_range(), Some((stats.min, stats.max)));
}

fn noise<T>(seed: u64, from: impl Fn(u64) -> T) -> Vec<T> {
    (0..count() as u64).map(|i| from(hash(seed, i))).collect()
}

#[test]
fn statistics_are_those_of_the_sorted_values() {
    check(&noise(1, |h| (h % 256) as u8), 1.0, 0.0);
    check(&noise(2, |h| (h % 100) as i8 - 60), 0.5, 3.0);
    check(&noise(3, |h| (h % 65536) as u16), -1.0, 0.0);
    check(&noise(4, |h| (h % 4096) as i16 - 1024), 2.0, -1000.0);
    check(&noise(5, |h| (h >> 32) as u32), 1.0, 0.0);
    check(&noise(6, |h| (h >> 40) as i32 - 5_000_000), -0.25, 17.0);
    check(&noise(7, |h| h >> 12), 1.0, 0.0);
    check(&noise(8, |h| h as i64 >> 14), -1.0, 0.0);
    let unit = |h: u64| (h >> 11) as f64 / (1u64 << 53) as f64;
    check(&noise(9, |h| (unit(h) * unit(h) - 0.3) as f32), 1.0, 0.0);
    check(&noise(10, |h| (unit(h) * 40.0 - 20.0).exp()), 1.0, 0.0);
    check(&noise(11, |h| -unit(h).sqrt()), -3.0, 1.0);
}

#[test]
fn gaps_are_counted_and_left_out() {
    let gaps = |h: u64, value: f64| match h % 11 {
        0 => f64::NAN,
        1 => -f64::NAN,
        2 => f64::INFINITY,
        3 | 4 => f64::NEG_INFINITY,
        _ => value,
    };
    check(&noise(1, |h| gaps(h, (h >> 40) as f64) as f32), 1.0, 0.0);
    check(&noise(2, |h| gaps(h, (h >> 20) as f64 - 1e12)), -1.0, 0.0);
    let empty =
        Volume::from_slice([2, 2, 1], [1.0; 3], &[f32::NAN, f32::INFINITY, f32::NAN, f32::NAN]).unwrap();
    assert_eq!((empty.stats(), empty.value_range(), empty.histogram(8)), (None, None, None));
}

#[test]
fn extremes_do_not_overflow() {
    let huge = Volume::from_slice([2, 2, 1], [1.0; 3], &[f64::MAX, f64::MIN, 0.0, f64::MAX]).unwrap();
    let stats = huge.stats().unwrap();
    assert_eq!((stats.min, stats.max), (f64::MIN, f64::MAX));
    assert!((stats.mean / f64::MAX - 0.25).abs() < 1e-12);
    assert!((stats.deviation / f64::MAX - 0.6875f64.sqrt()).abs() < 1e-12);
    assert_eq!(huge.histogram(4).unwrap().counts, [1, 0, 1, 2]);

    let tiny = Volume::from_slice([2, 1, 1], [1.0; 3], &[5e-324, 1e-323]).unwrap();
    assert_eq!(tiny.stats().unwrap().median, 1e-323);
    assert_eq!(tiny.histogram(2).unwrap().counts.iter().sum::<u64>(), 2);

    let ends = Volume::from_slice([2, 1, 1], [1.0; 3], &[i64::MIN, i64::MAX]).unwrap();
    assert_eq!(ends.histogram(3).unwrap().counts, [1, 0, 1]);
    assert_eq!(ends.histogram(1).unwrap().counts, [2]);
    assert_eq!(ends.histogram(0).unwrap().counts, [2]);

    let flat = Volume::from_slice([3, 1, 1], [1.0; 3], &[2.5f32; 3]).unwrap();
    let stats = flat.stats().unwrap();
    assert_eq!((stats.min, stats.mean, stats.deviation, stats.high), (2.5, 2.5, 0.0, 2.5));
    let histogram = flat.histogram(10).unwrap();
    assert_eq!((histogram.counts.as_slice(), histogram.min, histogram.width()), (&[3][..], 2.5, 0.0));
}

/// Integers spread evenly fill whole bins evenly: no comb.
#[test]
fn integer_bins_span_whole_numbers() {
    let ramp: Vec<u8> = (0..200).map(|i| 20 + i % 100).collect();
    let ramp = Volume::from_slice([200, 1, 1], [1.0; 3], &ramp).unwrap();
    for bins in [1, 2, 3, 7, 30, 64, 99, 100, 101, 1000] {
        let h = ramp.histogram(bins).unwrap();
        let width = h.width();
        assert_eq!(width, width.round());
        assert!(h.counts.len() <= bins && h.min == 19.5 && h.max >= 119.5);
        let (last, others) = h.counts.split_last().unwrap();
        assert!(others.iter().all(|&n| n == 2 * width as u64), "{bins}: {:?}", h.counts);
        assert_eq!(last + others.iter().sum::<u64>(), 200);
    }
    // The same in a wide type, and turned round by a negative slope.
    let wide: Vec<i32> = (0..200).map(|i| -7_000_000 + i % 100).collect();
    let affine = Affine::from_spacing([1.0; 3]);
    let scaling = Scaling { slope: -2.0, intercept: 0.0 };
    let wide = Volume::new([200, 1, 1], Sample::wrap(wide), scaling, affine).unwrap();
    let h = wide.histogram(30).unwrap();
    assert_eq!((h.width(), h.counts.len(), h.max), (8.0, 25, 14_000_001.0));
    assert!(h.counts.iter().all(|&n| n == 8));
}

#[test]
fn float_bins_hold_what_lies_in_them() {
    let samples = noise(3, |h| (h >> 40) as f32 / (1 << 24) as f32);
    let volume = Volume::from_slice(DIMS, [1.0; 3], &samples).unwrap();
    let h = volume.histogram(10).unwrap();
    let (min, max) = volume.value_range().unwrap();
    assert_eq!((h.min, h.max, h.counts.len()), (min, max, 10));
    for (i, &n) in h.counts.iter().enumerate() {
        let edge = |i: usize| min + (max - min) * i as f64 / 10.0;
        let inside = |v: f64| v >= edge(i) && (v < edge(i + 1) || i == 9);
        let expected = samples.iter().filter(|&&s| inside(f64::from(s))).count() as i64;
        // A sample within rounding of an edge may fall on either side.
        assert!((n as i64 - expected).abs() <= 1, "bin {i}: {n}, not {expected}");
    }
    assert_eq!(h.counts.iter().sum::<u64>(), count() as u64);
}
