//! The pass over the volume: window, three axes, 16 bits.
//!
//! The result is cut into jobs: a band of rows by a slab of layers. A job walks through the source layers that it
//! needs. Each row becomes numbers 0…65535 of the window and is filtered along x; the rows of a band are filtered along
//! y into a ring of as many layers as the filter along z is long; and when the ring holds what a result layer needs,
//! its rows are filtered along z and rounded. All of it stays in the second-level cache, the source is read and the
//! result written about once. Each result sample is the same sum in the same order whatever job makes it.

use std::sync::Mutex;

use rayon::prelude::*;

use super::grid::{Axis, Grid};
use super::kernel::Weights;
use super::window::ToUnit;
use crate::samples::Ordered;

/// Rows of a job.
const BAND: usize = 32;

/// Layers of a job: what is done twice at the seams is a small part.
const SLAB: usize = 96;

/// Numbers in a block: what the registers of any processor hold.
const BLOCK: usize = 16;

/// What filters the volume.
pub(super) struct Filter<'a, T> {
    pub samples: &'a [T],
    /// Voxels of the source.
    pub dims: [usize; 3],
    pub grid: &'a Grid,
    pub weights: [Weights; 3],
    /// What lies beyond the border along x: 0, or the last sample.
    pub zero_outside: bool,
    pub unit: ToUnit,
}

/// The part of the result that a job fills.
struct Job<'a> {
    y: usize,
    z: usize,
    /// For each layer the rows of the band.
    layers: Vec<&'a mut [u16]>,
}

/// What a job computes with.
struct Scratch {
    /// A source row in units of the window, with room for what lies beyond its ends.
    row: Vec<f32>,
    /// Rows of one source layer, filtered along x.
    rows: Vec<f32>,
    /// Source layers, filtered along x and y.
    ring: Vec<f32>,
    /// Where the numbers to be summed begin.
    starts: Vec<usize>,
}

impl<T: Ordered> Filter<'_, T> {
    /// Fills `result`, which has the voxels of the grid. `progress` hears shares in ascending order.
    pub(super) fn run(&self, result: &mut [u16], progress: &(dyn Fn(f32) + Sync)) {
        let [nx, ny, nz] = self.grid.dims();
        let bands = ny.div_ceil(BAND);
        let mut jobs: Vec<Job<'_>> = Vec::with_capacity(bands * nz.div_ceil(SLAB));
        for (slab, layers) in result.chunks_mut(nx * ny * SLAB).enumerate() {
            let first = jobs.len();
            let of_band = |band| Job { y: band * BAND, z: slab * SLAB, layers: Vec::with_capacity(SLAB) };
            jobs.extend((0..bands).map(of_band));
            for layer in layers.chunks_mut(nx * ny) {
                for (job, rows) in jobs[first..].iter_mut().zip(layer.chunks_mut(nx * BAND)) {
                    job.layers.push(rows);
                }
            }
        }
        let all = jobs.len();
        let done = Mutex::new(0usize);
        jobs.into_par_iter().for_each_init(
            || self.scratch(),
            |scratch, job| {
                self.work(job, scratch);
                // A poisoned lock means that `progress` panicked elsewhere, which rayon passes on.
                if let Ok(mut done) = done.lock() {
                    *done += 1;
                    progress(*done as f32 / all as f32);
                }
            },
        );
    }

    /// Rows are stored in whole blocks.
    fn stride(&self) -> usize {
        self.grid.0[0].len.next_multiple_of(BLOCK)
    }

    fn scratch(&self) -> Scratch {
        let [_, ny, _] = self.grid.dims();
        let stride = self.stride();
        let [wx, wy, wz] = &self.weights;
        let longest = (0..ny).step_by(BAND).map(|y| wy.span(y, ny.min(y + BAND)).len()).max();
        Scratch {
            row: vec![0.0; self.grid.0[0].kept.max(stride) + wx.gaussian.len() + BLOCK],
            rows: vec![0.0; longest.unwrap_or(0) * stride],
            ring: vec![0.0; wz.longest() * BAND * stride],
            starts: Vec::new(),
        }
    }

    fn work(&self, job: Job<'_>, scratch: &mut Scratch) {
        let [nx, ny, _] = self.grid.dims();
        let [_, _, wz] = &self.weights;
        let stride = self.stride();
        let y = job.y..ny.min(job.y + BAND);
        let slots = wz.longest();
        // The next source layer that is not in the ring. A ring slot is free once no later result needs its layer:
        // first layers ascend.
        let mut next = 0;
        for (k, out) in (job.z..).zip(job.layers) {
            let (first, weights) = wz.of(k);
            if weights.is_empty() {
                // The padding, which is 0 from the beginning.
                continue;
            }
            for layer in first.max(next)..first + weights.len() {
                self.layer(layer, y.clone(), layer % slots, scratch);
            }
            next = next.max(first + weights.len());
            let Scratch { ring, starts, .. } = &mut *scratch;
            for (row, out) in out.chunks_exact_mut(nx).enumerate() {
                starts.clear();
                starts.extend(
                    (first..first + weights.len()).map(|layer| (layer % slots * BAND + row) * stride),
                );
                sum_u16(ring, starts, weights, out);
            }
        }
    }

    /// Filters the rows of one source layer along x and y into a slot of the ring.
    fn layer(&self, layer: usize, y: std::ops::Range<usize>, slot: usize, scratch: &mut Scratch) {
        let [_, wy, _] = &self.weights;
        let stride = self.stride();
        let needed = wy.span(y.start, y.end);
        let Scratch { row, rows, ring, starts } = scratch;
        for (source, out) in needed.clone().zip(rows.chunks_exact_mut(stride)) {
            self.row(source, layer, row, starts, out);
        }
        for (k, out) in y.zip(ring[slot * BAND * stride..].chunks_exact_mut(stride)) {
            let (first, weights) = wy.of(k);
            if weights.is_empty() {
                out.fill(0.0);
                continue;
            }
            starts.clear();
            starts.extend((0..weights.len()).map(|t| (first + t - needed.start) * stride));
            sum_f32(rows, starts, weights, out);
        }
    }

    /// Brings one source row into units of the window and filters it along x.
    fn row(&self, y: usize, z: usize, row: &mut [f32], starts: &mut Vec<usize>, out: &mut [f32]) {
        let [x_axis, y_axis, z_axis] = &self.grid.0;
        let [nx, ny, _] = self.dims;
        let begin = x_axis.from + nx * (y + y_axis.from + ny * (z + z_axis.from));
        let samples = &self.samples[begin..begin + x_axis.kept];
        if x_axis.is_unresampled() {
            self.unresampled_row(x_axis, samples, row, starts, out);
        } else {
            self.unit.convert(samples, &mut row[..x_axis.kept]);
            for (k, out) in out[..x_axis.len].iter_mut().enumerate() {
                let (first, weights) = self.weights[0].of(k);
                *out = row[first..first + weights.len()].iter().zip(weights).map(|(v, w)| v * w).sum();
            }
        }
    }

    /// The same weights everywhere: the row, shifted, is summed as other axes sum rows.
    fn unresampled_row(
        &self,
        axis: &Axis,
        samples: &[T],
        row: &mut [f32],
        starts: &mut Vec<usize>,
        out: &mut [f32],
    ) {
        let gaussian = &self.weights[0].gaussian;
        let before = axis.pad + gaussian.len() / 2;
        let end = before + axis.kept;
        self.unit.convert(samples, &mut row[before..end]);
        let [low, high] = if self.zero_outside { [0.0; 2] } else { [row[before], row[end - 1]] };
        row[..before].fill(low);
        row[end..].fill(high);
        starts.clear();
        starts.extend(0..gaussian.len());
        sum_f32(row, starts, gaussian, out);
    }
}

/// `out[i] = Σ weights[t] · source[starts[t] + i]`, where `out` has whole blocks.
fn sum_f32(source: &[f32], starts: &[usize], weights: &[f32], out: &mut [f32]) {
    for (block, out) in out.as_chunks_mut::<BLOCK>().0.iter_mut().enumerate() {
        *out = sum(source, starts, weights, block * BLOCK);
    }
}

/// The same, rounded to 16 bits; `source` has whole blocks.
fn sum_u16(source: &[f32], starts: &[usize], weights: &[f32], out: &mut [u16]) {
    for (block, out) in out.chunks_mut(BLOCK).enumerate() {
        let rounded = sum(source, starts, weights, block * BLOCK).map(round);
        out.copy_from_slice(&rounded[..out.len()]);
    }
}

#[inline(always)]
fn sum(source: &[f32], starts: &[usize], weights: &[f32], at: usize) -> [f32; BLOCK] {
    let mut sum = [0.0; BLOCK];
    for (start, &weight) in starts.iter().zip(weights) {
        let values = &source[start + at..start + at + BLOCK];
        for i in 0..BLOCK {
            sum[i] += weight * values[i];
        }
    }
    sum
}

/// To the nearest of 0…65535. Added to 2²³, a number has no room for fractions: its last bits are the integer.
#[inline(always)]
fn round(x: f32) -> u16 {
    const SHIFT: f32 = (1 << 23) as f32;
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < 65535.0 { x } else { 65535.0 };
    (x + SHIFT).to_bits() as u16
}

#[cfg(test)]
mod tests {
    use super::round;

    #[test]
    fn rounding_stays_within_16_bits() {
        let cases = [(-5.0, 0), (0.4, 0), (0.6, 1), (1234.4, 1234), (65534.6, 65535), (7e4, 65535)];
        for (x, expected) in cases {
            assert_eq!(round(x), expected, "{x}");
        }
        assert_eq!((round(f32::NAN), round(f32::INFINITY), round(f32::NEG_INFINITY)), (0, 65535, 0));
    }
}
