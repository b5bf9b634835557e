//! The Laplacian of Gaussian: where a smoothed volume bends.
//!
//! Its zero crossings are edges (David Marr and Ellen Hildreth, *Theory of Edge Detection*, 1980), and the papers take
//! a voxel near one of them for part of a silhouette. The filter is a sum of three products of one-dimensional ones,
//! a second derivative along one axis and Gaussians along the others:
//!
//! ```text
//! LoG v = (h_x g_y g_z + g_x h_y g_z + g_x g_y h_z) ∗ v
//! ```
//!
//! Taken in the order z, y, x that is 2 + 3 + 2 one-dimensional sums a voxel, of pairs of samples at the same
//! distance, instead of nine. For each row the first two steps need few rows, which stay in the nearest cache, so no
//! intermediate array is kept, and layers are independent of each other.
//!
//! `g` is the Gaussian at whole steps up to 4 sigma, with sum 1. `h ∝ (k² − m₂) g`, with `m₂ = Σ k² g`, is scaled so
//! that it is exact on quadratic fields: near the Gaussian's second derivative for sigma over half a step, and the
//! second difference for less. Beyond the border the samples are mirrored (`d c b a | a b c d`). A NaN spreads as far
//! as the filter reaches. Sheared axes are taken as if they were at right angles.

use std::ops::Range;

use multiversion::multiversion;
use rayon::prelude::*;

use crate::gradient::{Lift, finite_range};
use crate::samples::Ordered;
use crate::volume::{Volume, VolumeError};

/// Where the Gaussian is cut off, in sigmas.
const REACH: f64 = 4.0;

/// The farthest that the filter looks, in voxels along an axis.
const MAX_RADIUS: usize = 256;

/// Taps for distances 0 to the radius along one axis.
#[derive(Clone, Debug, PartialEq)]
struct Taps {
    /// The Gaussian.
    g: Vec<f32>,
    /// The second derivative, times a factor.
    h: Vec<f32>,
}

impl Taps {
    /// For a sigma in voxel steps.
    fn new(sigma: f64, factor: f64) -> Taps {
        let radius = ((REACH * sigma).round() as usize).clamp(1, MAX_RADIUS);
        let raw = |k: usize| (-0.5 * (k as f64 / sigma).powi(2)).exp();
        let both = |k: usize| if k == 0 { 1.0 } else { 2.0 };
        // A floor keeps the second derivative defined where the Gaussian is a single tap.
        let raw: Vec<f64> = (0..=radius).map(|k| raw(k).max(if k == 1 { 1e-12 } else { 0.0 })).collect();
        let sum: f64 = raw.iter().enumerate().map(|(k, g)| both(k) * g).sum();
        let g: Vec<f64> = raw.iter().map(|g| g / sum).collect();
        let moment = |power: i32| -> f64 {
            g.iter().enumerate().map(|(k, g)| both(k) * (k as f64).powi(power) * g).sum()
        };
        let (second, fourth) = (moment(2), moment(4));
        let scale = 2.0 * factor / (fourth - second * second);
        let h = |(k, g): (usize, &f64)| (scale * ((k * k) as f64 - second) * g) as f32;
        Taps { h: g.iter().enumerate().map(h).collect(), g: g.iter().map(|&g| g as f32).collect() }
    }

    fn radius(&self) -> usize {
        self.g.len() - 1
    }
}

/// A Laplacian of Gaussian about to be taken.
#[derive(Clone, Debug)]
pub struct LaplacianOfGaussian<'a> {
    volume: &'a Volume,
    taps: [Taps; 3],
    /// Values per world unit squared for a sum of 1.
    unit: f64,
}

impl Volume {
    /// Prepares the Laplacian of this volume smoothed by a Gaussian of standard deviation `sigma`, world units; `None`
    /// if sigma is not positive and finite. For voxels, multiply by [`Volume::spacing`].
    ///
    /// Along an axis the filter reaches at most 256 voxels.
    pub fn laplacian_of_gaussian(&self, sigma: f64) -> Option<LaplacianOfGaussian<'_>> {
        if !(sigma > 0.0 && sigma.is_finite()) {
            return None;
        }
        let spacing = self.spacing();
        let smallest = spacing.into_iter().fold(f64::INFINITY, f64::min);
        let taps = spacing.map(|s| Taps::new((sigma / s).max(1e-3), (smallest / s).powi(2)));
        Some(LaplacianOfGaussian { volume: self, taps, unit: self.scaling().slope / (smallest * smallest) })
    }
}

impl LaplacianOfGaussian<'_> {
    /// Calls `row(state, y, z, values)` for each row of `layers`, after `start` for its layer, and gives what the
    /// layers made, in order. Values are per world unit squared.
    ///
    /// # Panics
    /// If `layers` goes beyond the volume.
    pub fn layers<A: Send>(
        &self,
        layers: Range<usize>,
        start: impl Fn(usize) -> A + Sync,
        row: impl Fn(&mut A, usize, usize, &[f32]) + Sync,
    ) -> Vec<A> {
        with_samples!(self.volume.samples(), samples => {
            let ends = finite_range(samples);
            layers.into_par_iter().map_init(
                || Scratch::new(self),
                |scratch, z| {
                    let mut state = start(z);
                    // Without a finite sample there is no finite result either.
                    if let Some([min, max]) = ends {
                        self.layer(samples, Lift::new(min, max), scratch, z, |y, values| row(&mut state, y, z, values));
                    } else {
                        let nx = self.volume.dims()[0];
                        scratch.out.iter_mut().for_each(|v| *v = f32::NAN);
                        (0..self.volume.dims()[1]).for_each(|y| row(&mut state, y, z, &scratch.out[..nx]));
                    }
                    state
                },
            ).collect()
        })
    }

    /// All of it, x fastest, values per world unit squared: 4 bytes a voxel.
    ///
    /// # Errors
    /// [`VolumeError::Size`] if there is no memory for it.
    pub fn field(&self) -> Result<Vec<f32>, VolumeError> {
        let [nx, ny, nz] = self.volume.dims();
        let mut field: Vec<f32> = Vec::new();
        field.try_reserve_exact(nx * ny * nz).map_err(|_| VolumeError::Size(nx, ny, nz))?;
        field.resize(nx * ny * nz, 0.0);
        self.field_into(&mut field);
        Ok(field)
    }

    /// As [`LaplacianOfGaussian::field`], into memory that is there.
    ///
    /// # Panics
    /// If `field` does not have a place for each voxel.
    pub fn field_into(&self, field: &mut [f32]) {
        let [nx, ny, nz] = self.volume.dims();
        assert_eq!(field.len(), nx * ny * nz, "a place for each voxel");
        with_samples!(self.volume.samples(), samples => {
            let Some([min, max]) = finite_range(samples) else {
                field.fill(f32::NAN);
                return;
            };
            field.par_chunks_exact_mut(nx * ny).enumerate().for_each_init(
                || Scratch::new(self),
                |scratch, (z, layer)| {
                    self.layer(samples, Lift::new(min, max), scratch, z, |y, values| {
                        layer[nx * y..][..nx].copy_from_slice(values);
                    });
                },
            );
        });
    }

    fn layer<T: Ordered>(
        &self,
        samples: &[T],
        lift: Lift<T>,
        scratch: &mut Scratch,
        z: usize,
        mut sink: impl FnMut(usize, &[f32]),
    ) {
        let [nx, ny, nz] = self.volume.dims();
        let [tx, ty, tz] = &self.taps;
        let (rx, ry) = (tx.radius(), ty.radius());
        // A lane of 1 is this many values.
        let unit = (self.unit * lift.step()) as f32;
        let slots = 2 * ry + 1;
        let mut next = 0;
        for y in 0..ny {
            while next <= (y + ry).min(ny - 1) {
                let row = |k: isize| &samples[nx * (next + ny * mirrored(z as isize + k, nz))..][..nx];
                let slot = next % slots;
                along_z(row, lift, tz, &mut scratch.smooth[slot], &mut scratch.bent[slot]);
                next += 1;
            }
            let slot = |k: isize| mirrored(y as isize + k, ny) % slots;
            along_y(scratch, slot, ty, rx, nx);
            for row in [&mut scratch.flat, &mut scratch.curved] {
                for k in 1..=rx {
                    row[rx - k] = row[rx + mirrored(-(k as isize), nx)];
                    row[rx + nx - 1 + k] = row[rx + mirrored((nx - 1 + k) as isize, nx)];
                }
            }
            along_x(&scratch.flat, &scratch.curved, tx, unit, &mut scratch.out);
            sink(y, &scratch.out);
        }
    }
}

/// The index of the sample that stands for `i` where samples are mirrored at both ends.
fn mirrored(i: isize, n: usize) -> usize {
    let n = n as isize;
    let i = i.rem_euclid(2 * n);
    (if i < n { i } else { 2 * n - 1 - i }) as usize
}

/// Buffers of a thread.
struct Scratch {
    /// Rows smoothed along z, and rows bent along z: a ring for the rows that one row needs.
    smooth: Vec<Vec<f32>>,
    bent: Vec<Vec<f32>>,
    /// A row smoothed along z and y, and the sum of those bent along one and smoothed along the other, with room for
    /// the mirrored ends.
    flat: Vec<f32>,
    curved: Vec<f32>,
    out: Vec<f32>,
}

impl Scratch {
    fn new(of: &LaplacianOfGaussian<'_>) -> Scratch {
        let [nx, _, _] = of.volume.dims();
        let [rx, ry, _] = of.taps.each_ref().map(Taps::radius);
        let ring = || vec![vec![0.0; nx]; 2 * ry + 1];
        let wide = || vec![0.0; nx + 2 * rx];
        Scratch { smooth: ring(), bent: ring(), flat: wide(), curved: wide(), out: vec![0.0; nx] }
    }
}

/// Two times a distance with its weights: rows on one side, rows on the other, weights for smoothing, for bending.
struct Pair<R> {
    a: [R; 2],
    b: [R; 2],
    g: [f32; 2],
    h: [f32; 2],
}

impl Taps {
    /// Distances by twos; an odd one out is paired with itself at weight 0. `row` finds the rows at a distance, one on
    /// each side.
    fn pairs<R: Copy>(&self, row: impl Fn(isize) -> R) -> impl Iterator<Item = Pair<R>> {
        (1..=self.radius()).step_by(2).map(move |k| {
            let next = (k + 1).min(self.radius());
            let weights = |w: &[f32]| [w[k], if next > k { w[next] } else { 0.0 }];
            let [near, far] = [k as isize, next as isize];
            Pair {
                a: [row(-near), row(-far)],
                b: [row(near), row(far)],
                g: weights(&self.g),
                h: weights(&self.h),
            }
        })
    }
}

/// Smooths and bends rows along z; `row` finds them by distance.
fn along_z<'a, T: Ordered>(
    row: impl Fn(isize) -> &'a [T],
    lift: Lift<T>,
    taps: &Taps,
    smooth: &mut [f32],
    bent: &mut [f32],
) {
    for ((g, h), &s) in smooth.iter_mut().zip(&mut *bent).zip(row(0)) {
        let v = lift.lane(s);
        (*g, *h) = (taps.g[0] * v, taps.h[0] * v);
    }
    for Pair { a, b, g, h } in taps.pairs(row) {
        both(a[0], b[0], a[1], b[1], |s| lift.lane(s), [g, h], smooth, bent);
    }
}

/// Smooths along y what was smoothed along z; bends it, and smooths what was bent. `slot` finds the row at a distance.
fn along_y(scratch: &mut Scratch, slot: impl Fn(isize) -> usize, taps: &Taps, start: usize, nx: usize) {
    let Scratch { smooth, bent, flat, curved, .. } = scratch;
    let (flat, curved) = (&mut flat[start..start + nx], &mut curved[start..start + nx]);
    let (s, b) = (&smooth[slot(0)], &bent[slot(0)]);
    for (((flat, curved), s), b) in flat.iter_mut().zip(&mut *curved).zip(s).zip(b) {
        (*flat, *curved) = (taps.g[0] * s, taps.h[0] * s + taps.g[0] * b);
    }
    for Pair { a, b, g, h } in taps.pairs(slot) {
        both(&smooth[a[0]], &smooth[b[0]], &smooth[a[1]], &smooth[b[1]], |s| s, [g, h], flat, curved);
        one(&bent[a[0]], &bent[b[0]], &bent[a[1]], &bent[b[1]], g, curved);
    }
}

/// Bends along x what is flat, smooths what is curved. Both begin a radius before the row.
fn along_x(flat: &[f32], curved: &[f32], taps: &Taps, unit: f32, out: &mut [f32]) {
    let (r, n) = (taps.radius(), out.len());
    for ((out, flat), curved) in out.iter_mut().zip(&flat[r..]).zip(&curved[r..]) {
        *out = taps.h[0] * flat + taps.g[0] * curved;
    }
    for Pair { a, b, h, .. } in taps.pairs(|k| &flat[r.wrapping_add_signed(k)..][..n]) {
        one(a[0], b[0], a[1], b[1], h, out);
    }
    for Pair { a, b, g, .. } in taps.pairs(|k| &curved[r.wrapping_add_signed(k)..][..n]) {
        one(a[0], b[0], a[1], b[1], g, out);
    }
    out.iter_mut().for_each(|v| *v *= unit);
}

// The two loops below are functions of their own: arguments that cannot overlap become vector code without tests at run
// time, and there is a version for processors with vectors of 256 bits. Both versions round alike: products and sums are
// not fused.

/// Adds two weighted pairs of rows to a row.
#[multiversion(targets("x86_64+avx2"))]
fn one(a: &[f32], b: &[f32], c: &[f32], d: &[f32], w: [f32; 2], out: &mut [f32]) {
    let n = out.len();
    let (a, b, c, d) = (&a[..n], &b[..n], &c[..n], &d[..n]);
    for i in 0..n {
        out[i] += w[0] * (a[i] + b[i]) + w[1] * (c[i] + d[i]);
    }
}

/// Adds two pairs of rows, weighted by one set and by another, to two rows.
#[multiversion(targets("x86_64+avx2"))]
fn both<T: Copy>(
    a: &[T],
    b: &[T],
    c: &[T],
    d: &[T],
    lane: impl Fn(T) -> f32,
    [g, h]: [[f32; 2]; 2],
    smooth: &mut [f32],
    bent: &mut [f32],
) {
    let n = smooth.len();
    let (a, b, c, d, bent) = (&a[..n], &b[..n], &c[..n], &d[..n], &mut bent[..n]);
    for i in 0..n {
        let (near, far) = (lane(a[i]) + lane(b[i]), lane(c[i]) + lane(d[i]));
        smooth[i] += g[0] * near + g[1] * far;
        bent[i] += h[0] * near + h[1] * far;
    }
}
