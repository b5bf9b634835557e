//! Work sorted into horizontal bands of the page, so that threads draw side by side and never into the same row.

use rayon::prelude::*;

/// Rows of a band.
pub(crate) const BAND_ROWS: usize = 32;

/// Items a chunk sorts at a time.
const CHUNK: usize = 8192;

/// First and last of the pixels `0..size` whose centres lie in `low..=high`, in pixels; `None` if there are none, or if
/// a bound is no number.
///
/// Without `floor` and `ceil`, which are calls on processors that the compiler may not assume more of.
#[inline(always)]
pub(crate) fn centers(low: f32, high: f32, size: usize) -> Option<(usize, usize)> {
    // Casts truncate towards zero, and saturated ones could not be stepped on from: so the bounds are cut to the page
    // first, in an order in which what is no number becomes an empty range.
    let low = (low - 0.5).min(size as f32).max(-0.5);
    let high = (high - 0.5).max(-1.0).min(size as f32 - 1.0);
    let first = low as i32;
    let first = first + i32::from(low > first as f32);
    let last = high as i32;
    let last = last - i32::from(high < last as f32);
    (first <= last).then_some((first as usize, last as usize))
}

/// For each band the items that touch it, in item order; memory is kept from frame to frame.
#[derive(Default)]
pub(crate) struct Bins {
    /// One entry a chunk: for each band its items.
    chunks: Vec<Vec<Vec<u32>>>,
    used: usize,
}

impl Bins {
    /// Sorts the items `0..count` into `bands` bands; `rows(i)` gives the first and last row that item `i` touches,
    /// or `None` if it touches none.
    pub fn fill(
        &mut self,
        count: usize,
        bands: usize,
        rows: impl Fn(usize) -> Option<(usize, usize)> + Sync,
    ) {
        self.used = count.div_ceil(CHUNK);
        if self.chunks.len() < self.used {
            self.chunks.resize_with(self.used, Vec::new);
        }
        self.chunks[..self.used].par_iter_mut().enumerate().for_each(|(k, bins)| {
            bins.resize_with(bands.max(bins.len()), Vec::new);
            bins.iter_mut().for_each(Vec::clear);
            for i in k * CHUNK..((k + 1) * CHUNK).min(count) {
                if let Some((first, last)) = rows(i) {
                    for bin in &mut bins[first / BAND_ROWS..=(last / BAND_ROWS).min(bands - 1)] {
                        bin.push(i as u32);
                    }
                }
            }
        });
    }

    /// The items of one band, in order.
    pub fn band(&self, band: usize) -> impl Iterator<Item = usize> + '_ {
        self.chunks[..self.used].iter().flat_map(move |bins| bins[band].iter().map(|&i| i as usize))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centers_are_those_between() {
        assert_eq!(centers(0.2, 0.4, 10), None);
        assert_eq!(centers(0.5, 0.5, 10), Some((0, 0)));
        assert_eq!(centers(-50.0, 3.4, 10), Some((0, 2)));
        assert_eq!(centers(-50.0, -3.0, 10), None);
        assert_eq!(centers(8.6, 99.0, 10), Some((9, 9)));
        assert_eq!(centers(9.6, 99.0, 10), None);
        assert_eq!(centers(f32::NEG_INFINITY, f32::INFINITY, 10), Some((0, 9)));
        for far in [1e12, f32::MAX, f32::INFINITY, f32::NAN] {
            assert_eq!((centers(far, far, 10), centers(-far, -far, 10)), (None, None), "{far}");
        }
        assert_eq!((centers(f32::NAN, 5.0, 10), centers(0.0, f32::NAN, 10)), (None, None));
        assert_eq!(centers(-1.0, 1.0, 0), None);
    }

    #[test]
    fn every_item_is_in_each_of_its_bands_in_order() {
        let mut bins = Bins::default();
        for _ in 0..2 {
            bins.fill(20_000, 4, |i| (i % 3 != 0).then_some((i % 100, (i % 100 + 20).min(127))));
            for band in 0..4 {
                let expected: Vec<usize> = (0..20_000)
                    .filter(|i| i % 3 != 0 && i % 100 / 32 <= band && (i % 100 + 20).min(127) / 32 >= band)
                    .collect();
                assert_eq!(bins.band(band).collect::<Vec<_>>(), expected);
            }
        }
    }
}
