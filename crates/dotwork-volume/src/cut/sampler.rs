//! Values between the voxels.

use glam::{DMat3, DVec3};

use crate::samples::Ordered;
use crate::volume::{Scaling, Volume};

/// Indices closer to a whole number than this are meant to be it: rounding must not give a NaN next door a weight.
const SNAP: f64 = 1e-6;

/// Trilinear interpolation in a volume, constant beyond the centres of its border voxels.
pub(super) struct Sampler<'a, T> {
    samples: &'a [T],
    dims: [usize; 3],
    scaling: Scaling,
    /// From the world to indices.
    inverse: DMat3,
    origin: DVec3,
}

impl<'a, T: Ordered> Sampler<'a, T> {
    pub(super) fn new(volume: &Volume, samples: &'a [T]) -> Sampler<'a, T> {
        let affine = volume.affine();
        Sampler {
            samples,
            dims: volume.dims(),
            scaling: volume.scaling(),
            inverse: affine.linear.inverse(),
            origin: affine.origin,
        }
    }

    /// Calls `visit` with the samples around a world point that have a weight, and their weights, which add up to 1.
    #[inline]
    fn around(&self, point: DVec3, mut visit: impl FnMut(f64, f64)) {
        let index = (self.inverse * (point - self.origin)).to_array();
        let (mut base, mut step, mut share) = (0, [0; 3], [0.0; 3]);
        let mut stride = 1;
        for a in 0..3 {
            let whole = index[a].round();
            let at = if (index[a] - whole).abs() < SNAP { whole } else { index[a] };
            let at = at.clamp(0.0, (self.dims[a] - 1) as f64);
            let low = at.floor();
            share[a] = at - low;
            // Without a share there may be no neighbour.
            step[a] = if share[a] > 0.0 { stride } else { 0 };
            base += low as usize * stride;
            stride *= self.dims[a];
        }
        for corner in 0..8 {
            let (mut i, mut weight) = (base, 1.0);
            for a in 0..3 {
                let high = corner >> a & 1 == 1;
                i += if high { step[a] } else { 0 };
                weight *= if high { share[a] } else { 1.0 - share[a] };
            }
            if weight > 0.0 {
                visit(self.samples[i].to_f64(), weight);
            }
        }
    }

    /// The value; NaN beside a NaN.
    pub(super) fn strict(&self, point: DVec3) -> f64 {
        let mut sum = 0.0;
        self.around(point, |sample, weight| sum += weight * sample);
        self.scaling.value(sum)
    }

    /// The value from the finite samples around the point alone; 0 if there is none.
    pub(super) fn value(&self, point: DVec3) -> f64 {
        let (mut sum, mut total) = (0.0, 0.0);
        self.around(point, |sample, weight| {
            if sample.is_finite() {
                sum += weight * sample;
                total += weight;
            }
        });
        if total > 0.0 { self.scaling.value(sum / total) } else { 0.0 }
    }
}
