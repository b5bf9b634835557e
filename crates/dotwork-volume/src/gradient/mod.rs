//! Gradients by four-dimensional linear regression.
//!
//! Around each voxel a hyperplane `v ≈ A x + B y + C z + D` is fitted to the 3 × 3 × 3 neighbourhood by weighted least
//! squares (László Neumann, Balázs Csébfalvi, Andreas König and Eduard Gröller, *Gradient Estimation in Volume Data
//! using 4D Linear Regression*, 2000). `D` is a smoothed value and `(A, B, C)` the gradient that belongs to it; with
//! weights that are even in each offset the normal equations are diagonal:
//!
//! ```text
//! D = Σ w v / Σ w,   A = Σ w x v / Σ w x²,   B = Σ w y v / Σ w y²,   C = Σ w z v / Σ w z²
//! ```
//!
//! The paper lets weights fall with the inverse distance, which is infinite in the centre; here they are
//! `12 / (1 + d)`, with d the distance in units of the smallest spacing, rounded to whole numbers: 12, 6, 5, 4 for the
//! centre, faces, edges and corners of a cubic grid. Every such choice is exact on linear fields. Whole weights keep
//! sums of samples of up to 16 bits exact: 8-bit volumes are summed in 16-bit integers, all others in `f32`.
//!
//! The fit is made per voxel step and mapped to the world by the inverse transpose of the affine, which is the same as
//! a fit in the world with those weights: lines stay lines. Where axes are sheared, the weights' distances are taken
//! as if they were at right angles.
//!
//! At the border the outermost sample is repeated; the gradient across the border is then a one-sided difference,
//! still exact on linear fields, while the value leans inwards by up to a third of a step. A voxel next to NaN or an
//! infinity has no gradient.
//!
//! [`Regression::layers`] streams rows through a function, so that statistics need no array of the volume's size;
//! [`Regression::field`] keeps everything in 8 bytes a voxel.

mod field;
mod kernel;
mod source;

pub use field::GradientField;
pub(crate) use source::{Lift, finite_range};

use std::array;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::samples::{Ordered, Sample, Samples};
use crate::volume::Volume;
use kernel::{LANES, Scratch};

/// The weight of the centre.
const CENTRE: f64 = 12.0;

/// One row of the regression, in units that do not depend on the file's.
#[derive(Clone, Copy, Debug)]
pub struct RegressionRow<'a> {
    /// Its place along y.
    pub y: usize,
    /// Its layer.
    pub z: usize,
    /// Smoothed values: 0 is the smallest value of the volume, 1 the largest.
    pub value: &'a [f32],
    /// Gradients by index: change of that value for one voxel step along x, y and z.
    pub gradient: [&'a [f32]; 3],
}

/// Sums of a row in one of their two types.
enum Sums<'a> {
    Whole([&'a [u16]; 4]),
    Real([&'a [f32]; 4]),
}

/// Buffers of a thread, made when they are first needed.
#[derive(Default)]
pub(crate) struct RowScratch {
    whole: Option<Scratch<u16>>,
    real: Option<Scratch<f32>>,
}

/// Rows for value and gradient of `nx` voxels, in whole vectors.
pub(crate) fn rows(nx: usize) -> [Vec<f32>; 4] {
    array::from_fn(|_| vec![0.0; nx.next_multiple_of(LANES)])
}

/// A volume about to be fitted; see the text of the module for the method.
#[derive(Clone, Debug)]
pub struct Regression<'a> {
    volume: &'a Volume,
    /// Smallest and largest value.
    range: [f64; 2],
    /// Keys of the smallest and the largest finite sample.
    keys: [u64; 2],
    /// By absolute offset, x the lowest bit.
    weights: [f64; 8],
    /// Sums of the weights, and of the weights times the squared offset.
    norms: [f64; 4],
    /// From gradients by index to gradients in the world.
    to_world: DMat3,
    /// The metric of gradients by index, in units of the smallest spacing: xx, yy, zz, 2xy, 2yz, 2zx.
    metric: [f32; 6],
    smallest_spacing: f64,
}

impl Volume {
    /// Prepares the regression; `None` if no value is finite. Costs a pass over the samples for their range.
    pub fn regression(&self) -> Option<Regression<'_>> {
        let keys = with_samples!(self.samples(), samples => {
            finite_range(samples).map(|ends| ends.map(Ordered::key))
        })?;
        let ends =
            with_samples!(self.samples(), samples => keys.map(|k| source::from_key(samples, k).to_f64()));
        let [a, b] = ends.map(|s| self.scaling().value(s));
        let spacing = self.spacing();
        let smallest = spacing.into_iter().fold(f64::INFINITY, f64::min);
        let offset = |class: usize, axis: usize| (class >> axis & 1) as f64;
        let weights = array::from_fn(|class| {
            let d = DVec3::from_array(array::from_fn(|axis| offset(class, axis) * spacing[axis] / smallest));
            (CENTRE / (1.0 + d.length())).round().max(1.0)
        });
        // How many neighbours share a weight: one in the centre, eight corners.
        let times = |class: usize| f64::from(1u32 << class.count_ones());
        let sum =
            |of: &dyn Fn(usize) -> f64| (0..8).map(|class| times(class) * weights[class] * of(class)).sum();
        let norms =
            array::from_fn(|i| if i == 0 { sum(&|_| 1.0) } else { sum(&|class| offset(class, i - 1)) });
        // In units of the smallest spacing, so that squares neither overflow nor vanish.
        let linear = self.affine().linear * smallest.recip();
        let covector = linear.inverse().transpose();
        let metric = covector.transpose() * covector;
        let entry = |row: usize, column: usize| metric.col(column)[row] as f32;
        Some(Regression {
            volume: self,
            range: [a.min(b), a.max(b)],
            keys,
            weights,
            norms,
            to_world: covector * smallest.recip(),
            metric: [
                entry(0, 0),
                entry(1, 1),
                entry(2, 2),
                2.0 * entry(0, 1),
                2.0 * entry(1, 2),
                2.0 * entry(2, 0),
            ],
            smallest_spacing: smallest,
        })
    }
}

impl<'a> Regression<'a> {
    /// The volume.
    pub fn volume(&self) -> &'a Volume {
        self.volume
    }

    /// The value for which rows have `unit`.
    pub fn value(&self, unit: f64) -> f64 {
        let [min, max] = self.range;
        min + unit * (max - min)
    }

    /// The number that rows have for a value; the inverse of [`Regression::value`].
    pub fn unit(&self, value: f64) -> f64 {
        (value - self.range[0]) / self.span()
    }

    /// The largest value less the smallest, 1 if they are equal.
    pub fn span(&self) -> f64 {
        let span = self.range[1] - self.range[0];
        if span > 0.0 { span } else { 1.0 }
    }

    /// The gradient in the world for one in a row: values per world unit.
    pub fn gradient(&self, by_index: [f32; 3]) -> DVec3 {
        self.to_world * DVec3::from_array(by_index.map(f64::from)) * self.span()
    }

    /// Writes the lengths of a row's gradients in the world, as share of the range for one step of the smallest
    /// spacing. [`Regression::slope`] makes them values per world unit.
    ///
    /// # Panics
    /// If `lengths` is shorter than the row.
    pub fn magnitudes(&self, row: &RegressionRow<'_>, lengths: &mut [f32]) {
        let [xx, yy, zz, xy, yz, zx] = self.metric;
        let n = row.value.len();
        let lengths = &mut lengths[..n];
        let [gx, gy, gz] = row.gradient.map(|g| &g[..n]);
        for i in 0..n {
            let (x, y, z) = (gx[i], gy[i], gz[i]);
            let squares = x * x * xx + y * y * yy + z * z * zz;
            // Rounding must not make a root of a negative number.
            lengths[i] = (squares + (x * y * xy + y * z * yz + z * x * zx)).max(0.0).sqrt();
        }
    }

    /// Values per world unit for a length that [`Regression::magnitudes`] gives.
    pub fn slope(&self, length: f64) -> f64 {
        length * self.span() / self.smallest_spacing
    }

    /// The direction in which the value rises fastest in the world, as voxel steps (not of unit length).
    pub(crate) fn steepest(&self, g: [f32; 3]) -> [f32; 3] {
        let [xx, yy, zz, xy, yz, zx] = self.metric;
        let [x, y, z] = g;
        [xx * x + 0.5 * (xy * y + zx * z), yy * y + 0.5 * (xy * x + yz * z), zz * z + 0.5 * (zx * x + yz * y)]
    }

    /// Calls `row` with the rows of each of `layers` in order, and `start` before each layer; gives what the layers
    /// made, in order. Layers are fitted in parallel. Voxels next to a NaN have NaN for value and gradient.
    ///
    /// # Panics
    /// If `layers` goes beyond the volume.
    pub fn layers<A: Send>(
        &self,
        layers: std::ops::Range<usize>,
        start: impl Fn(usize) -> A + Sync,
        row: impl Fn(&mut A, RegressionRow<'_>) + Sync,
    ) -> Vec<A> {
        let nx = self.volume.dims()[0];
        let work = |scratch: &mut (RowScratch, [Vec<f32>; 4]), z: usize| {
            let mut state = start(z);
            self.layer(&mut scratch.0, &mut scratch.1, z, |y, value, gradient| {
                row(&mut state, RegressionRow { y, z, value, gradient });
            });
            state
        };
        layers.into_par_iter().map_init(|| (RowScratch::default(), rows(nx)), work).collect()
    }

    /// One layer, on this thread.
    pub(crate) fn layer(
        &self,
        scratch: &mut RowScratch,
        out: &mut [Vec<f32>; 4],
        z: usize,
        mut row: impl FnMut(usize, &[f32], [&[f32]; 3]),
    ) {
        let nx = self.volume.dims()[0];
        self.sums(scratch, z, |y, top, sums| {
            let sign = self.volume.scaling().slope.signum();
            for (i, out) in out.iter_mut().enumerate() {
                let factor = (sign / (self.norms[i] * f64::from(top))) as f32;
                // Values descend from 1 where the slope is negative.
                let offset = if i == 0 && sign < 0.0 { 1.0 } else { 0.0 };
                match sums {
                    Sums::Whole(sums) if i == 0 => lift_row(sums[i], out, |s| f32::from(s) * factor + offset),
                    Sums::Whole(sums) => lift_row(sums[i], out, |s| f32::from(s as i16) * factor),
                    Sums::Real(sums) => lift_row(sums[i], out, |s| s * factor + offset),
                }
            }
            let [v, gx, gy, gz] = out.each_ref().map(|out| &out[..nx]);
            row(y, v, [gx, gy, gz]);
        });
    }

    /// Calls `sink` for each row of a layer with what the largest sample became, and the sums.
    fn sums(&self, scratch: &mut RowScratch, z: usize, mut sink: impl FnMut(usize, f32, Sums<'_>)) {
        let dims = self.volume.dims();
        let nx = dims[0];
        if let Samples::U8(samples) = self.volume.samples() {
            let [min, max] = self.keys.map(|key| key as u8);
            let top = f32::from(max - min).max(1.0);
            let weights = self.weights.map(|w| w as u16);
            let scratch = scratch.whole.get_or_insert_with(|| Scratch::new(nx));
            let lane = |s: u8| u16::from(s) - u16::from(min);
            scratch.layer(dims, z, &weights, samples, lane, |y, sums| sink(y, top, Sums::Whole(sums)));
        } else {
            let weights = self.weights.map(|w| w as f32);
            let scratch = scratch.real.get_or_insert_with(|| Scratch::new(nx));
            with_samples!(self.volume.samples(), samples => {
                let lift = source::lift(samples, self.keys);
                let sink = |y: usize, sums: [&[f32]; 4]| sink(y, lift.top(), Sums::Real(sums));
                scratch.layer(dims, z, &weights, samples, |s| lift.lane(s), sink);
            });
        }
    }
}

/// Writes what `of` makes of a row.
#[inline(never)]
fn lift_row<L: Copy>(row: &[L], out: &mut [f32], of: impl Fn(L) -> f32) {
    for (out, &s) in out.iter_mut().zip(row) {
        *out = of(s);
    }
}
