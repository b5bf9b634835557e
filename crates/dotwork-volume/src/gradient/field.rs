//! Value and gradient of every voxel, in 8 bytes.

use std::array;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::{Regression, RowScratch, Sums};
use crate::samples::Samples;
use crate::volume::VolumeError;

/// Smoothed values and gradients of a whole volume: 16 bits each for the value and the three components by index.
///
/// Of 8-bit volumes these are the exact sums. Of all others, the value is kept to 1/65535 and the gradient to 1/32767
/// of the range of the values (of them for a voxel step).
#[derive(Clone, Debug, PartialEq)]
pub struct GradientField {
    dims: [usize; 3],
    /// Smoothed values, x fastest; see [`GradientField::value`].
    pub values: Vec<u16>,
    /// Gradients by index along x, y and z; see [`GradientField::gradient`].
    pub gradients: [Vec<i16>; 3],
    /// Value = `value_scale · stored + value_offset`.
    value_scale: f64,
    value_offset: f64,
    /// World gradient = `to_world · stored`.
    to_world: DMat3,
}

/// Adding it to a number below 2²² leaves the number, rounded to a whole one, in the low bits (two's complement); of
/// infinities it leaves 0. Vectors of the baseline processor cannot round otherwise.
const ROUNDING: f32 = 12_582_912.0;

#[inline]
fn rounded(x: f32) -> u16 {
    // A NaN would leave bits of its own, whatever they are in the file.
    let x = if x.is_nan() { 0.0 } else { x };
    (x + ROUNDING).to_bits() as u16
}

impl Regression<'_> {
    /// Value and gradient of every voxel, 8 bytes each, made in parallel.
    ///
    /// # Errors
    /// [`VolumeError::Size`] if there is no memory for them.
    pub fn field(&self) -> Result<GradientField, VolumeError> {
        let mut field = GradientField {
            dims: [0; 3],
            values: Vec::new(),
            gradients: array::from_fn(|_| Vec::new()),
            value_scale: 1.0,
            value_offset: 0.0,
            to_world: DMat3::IDENTITY,
        };
        self.field_into(&mut field)?;
        Ok(field)
    }

    /// As [`Regression::field`], into the memory of an earlier field.
    ///
    /// # Errors
    /// As [`Regression::field`].
    pub fn field_into(&self, field: &mut GradientField) -> Result<(), VolumeError> {
        let dims = self.volume.dims();
        let [nx, ny, nz] = dims;
        let none = |_| VolumeError::Size(nx, ny, nz);
        let size = nx * ny * nz;
        field.dims = dims;
        field.values.truncate(size);
        field.values.try_reserve_exact(size - field.values.len()).map_err(none)?;
        field.values.resize(size, 0);
        for g in &mut field.gradients {
            g.truncate(size);
            g.try_reserve_exact(size - g.len()).map_err(none)?;
            g.resize(size, 0);
        }
        let (value, gradient) = self.quanta();
        let sign = self.volume.scaling().slope.signum();
        field.value_scale = sign * value * self.span();
        field.value_offset = self.range[usize::from(sign < 0.0)];
        field.to_world = self.to_world * DMat3::from_diagonal(gradient * sign * self.span());

        let layer = nx * ny;
        let [gx, gy, gz] = &mut field.gradients;
        let outputs = field
            .values
            .par_chunks_exact_mut(layer)
            .zip(gx.par_chunks_exact_mut(layer))
            .zip(gy.par_chunks_exact_mut(layer))
            .zip(gz.par_chunks_exact_mut(layer));
        outputs.enumerate().for_each_init(RowScratch::default, |scratch, (z, (((v, gx), gy), gz))| {
            self.sums(scratch, z, |y, top, sums| {
                let row = nx * y..nx * (y + 1);
                let v = &mut v[row.clone()];
                let gradients = [&mut gx[row.clone()], &mut gy[row.clone()], &mut gz[row]];
                match sums {
                    Sums::Whole([s, g @ ..]) => {
                        v.copy_from_slice(&s[..nx]);
                        for (out, g) in gradients.into_iter().zip(g) {
                            out.iter_mut().zip(g).for_each(|(out, &g)| *out = g as i16);
                        }
                    }
                    Sums::Real([s, g @ ..]) => {
                        let scale = (1.0 / (value * self.norms[0] * f64::from(top))) as f32;
                        store(s, scale, v, |x| x);
                        let scales = gradient.to_array();
                        for (axis, (out, g)) in gradients.into_iter().zip(g).enumerate() {
                            let scale = (1.0 / (scales[axis] * self.norms[axis + 1] * f64::from(top))) as f32;
                            store(g, scale, out, |x| x as i16);
                        }
                    }
                }
            });
        });
        Ok(())
    }

    /// What one step of the stored numbers means, in shares of the range: value, and gradients by index.
    fn quanta(&self) -> (f64, DVec3) {
        match self.volume.samples() {
            Samples::U8(_) => {
                let top = (self.keys[1] - self.keys[0]).max(1) as f64;
                let [v, x, y, z] = self.norms.map(|n| 1.0 / (n * top));
                (v, DVec3::new(x, y, z))
            }
            // 32767 of range: one-sided differences at the border reach it.
            _ => (1.0 / f64::from(u16::MAX), DVec3::splat(1.0 / f64::from(i16::MAX))),
        }
    }
}

/// Rounds sums into a row.
#[inline(never)]
fn store<O>(sums: &[f32], scale: f32, out: &mut [O], of: impl Fn(u16) -> O) {
    for (out, &sum) in out.iter_mut().zip(sums) {
        *out = of(rounded(sum * scale));
    }
}

impl GradientField {
    /// Voxels along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The smoothed value of voxel `i`, x fastest.
    ///
    /// # Panics
    /// If there is no such voxel.
    pub fn value(&self, i: usize) -> f64 {
        self.value_scale * f64::from(self.values[i]) + self.value_offset
    }

    /// The gradient of voxel `i` in the world: values per world unit.
    ///
    /// # Panics
    /// If there is no such voxel.
    pub fn gradient(&self, i: usize) -> DVec3 {
        self.to_world * DVec3::from_array(self.gradients.each_ref().map(|g| f64::from(g[i])))
    }
}
