//! Counting samples by the digits of their keys, and finding the sample at a rank that way.
//!
//! Keys have the order of the samples. Samples are counted by the first digit of their keys, then those with the right
//! first digit by the next, and so on: one pass for 8- and 16-bit types, two for 32-bit and four for 64-bit ones. The
//! sample found is exact.

use rayon::prelude::*;

use crate::samples::Ordered;

/// Bits in a digit of wide types; 8-bit types have one of 8.
pub(super) const DIGIT: u32 = 16;

/// Samples that one job counts, in tables of its own.
const JOB: usize = 1 << 20;

/// Tables that a job fills in turn: background is one sample over and over, and would wait for one counter.
const TABLES: usize = 4;

/// How often each key occurs; for integers of at most [`DIGIT`] bits.
pub(super) struct KeyCounts(Vec<u64>);

impl KeyCounts {
    pub(super) fn new<T: Ordered>(samples: &[T]) -> KeyCounts {
        let digit = DIGIT.min(T::KEY_BITS);
        let mask = (1 << digit) - 1;
        KeyCounts(tally(samples, 1 << digit, |s| Some((s.key() & mask) as usize)))
    }

    /// The keys that occur, ascending, and how often.
    pub(super) fn present(&self) -> impl DoubleEndedIterator<Item = (u64, u64)> {
        self.0.iter().enumerate().filter(|(_, n)| **n > 0).map(|(key, &n)| (key as u64, n))
    }

    /// The smallest and the largest sample, if there are any.
    pub(super) fn range<T: Ordered>(&self) -> Option<(T, T)> {
        let (first, _) = self.present().next()?;
        let (last, _) = self.present().next_back()?;
        Some((T::from_key(first), T::from_key(last)))
    }

    /// The sample at a rank, which is below their number.
    pub(super) fn at_rank<T: Ordered>(&self, rank: u64) -> T {
        let mut up_to = 0;
        let mut keys = self.present().skip_while(|&(_, n)| {
            up_to += n;
            up_to <= rank
        });
        T::from_key(keys.next().map_or(0, |(key, _)| key))
    }

    /// Mean and standard deviation of the samples.
    pub(super) fn moments<T: Ordered>(&self) -> (f64, f64) {
        let average = |term: &dyn Fn(f64) -> f64| {
            let sum: f64 = self.present().map(|(key, n)| n as f64 * term(T::from_key(key).to_f64())).sum();
            sum / self.0.iter().sum::<u64>() as f64
        };
        let mean = average(&|s| s);
        (mean, average(&|s| (s - mean).powi(2)).sqrt())
    }
}

/// Finds the samples at `ranks`, which ascend, in ascending order (NaN last).
///
/// # Panics
/// If a rank is not below the number of samples.
pub(super) fn select<T: Ordered, const N: usize>(samples: &[T], ranks: [u64; N]) -> [T; N] {
    let digit = DIGIT.min(T::KEY_BITS);
    let mask = (1u64 << digit) - 1;
    let mut prefixes = [0u64; N];
    let mut remaining = ranks;
    for shift in (0..T::KEY_BITS).step_by(digit as usize).rev() {
        // Ranks with a common prefix share a table. The first pass has one and need not compare.
        let mut distinct = prefixes.to_vec();
        distinct.dedup();
        let tables = if shift + digit == T::KEY_BITS {
            tally(samples, 1 << digit, |s| Some((s.key() >> shift & mask) as usize))
        } else {
            tally(samples, distinct.len() << digit, |s| {
                let key = s.key() >> shift;
                let table = distinct.iter().position(|&p| p == key >> digit)?;
                Some(table << digit | (key & mask) as usize)
            })
        };
        for (prefix, rank) in prefixes.iter_mut().zip(&mut remaining) {
            let table = distinct.iter().position(|p| p == prefix).expect("it is among them");
            let mut next = 0;
            while *rank >= tables[table << digit | next] {
                *rank -= tables[table << digit | next];
                next += 1;
            }
            *prefix = *prefix << digit | next as u64;
        }
    }
    prefixes.map(T::from_key)
}

/// Counts samples by `place`, which is below `places`; `None` leaves a sample out.
pub(super) fn tally<T: Ordered>(
    samples: &[T],
    places: usize,
    place: impl Fn(T) -> Option<usize> + Sync,
) -> Vec<u64> {
    let zero = || vec![0u64; places];
    let count = |mut counts: Vec<u64>, job: &[T]| {
        let mut tables = vec![0u32; TABLES * places];
        let (groups, rest) = job.as_chunks::<TABLES>();
        for group in groups {
            for (table, &s) in group.iter().enumerate() {
                if let Some(place) = place(s) {
                    tables[table * places + place] += 1;
                }
            }
        }
        for place in rest.iter().filter_map(|&s| place(s)) {
            tables[place] += 1;
        }
        for table in tables.chunks_exact(places) {
            counts.iter_mut().zip(table).for_each(|(count, &n)| *count += u64::from(n));
        }
        counts
    };
    samples.par_chunks(JOB).fold(zero, count).reduce(zero, |mut a, b| {
        a.iter_mut().zip(&b).for_each(|(a, b)| *a += b);
        a
    })
}
