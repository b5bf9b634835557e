//! Work sorted into horizontal bands of the page, so that threads draw side by side and never into the same row.

use rayon::prelude::*;

/// Rows of a band.
pub(crate) const BAND_ROWS: usize = 32;

/// Items a chunk sorts at a time.
const CHUNK: usize = 8192;

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
    pub fn fill(&mut self, count: usize, bands: usize, rows: impl Fn(usize) -> Option<(usize, usize)> + Sync) {
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
