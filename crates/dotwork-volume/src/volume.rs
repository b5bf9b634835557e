//! The volume type.

use glam::DVec3;
use thiserror::Error;

use crate::affine::Affine;
use crate::samples::{Sample, Samples};

/// From a stored sample to its value: `value = slope · sample + intercept` (NIfTI's scl_slope, DICOM's rescale).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// Factor, not 0.
    pub slope: f64,
    /// Summand.
    pub intercept: f64,
}

impl Scaling {
    /// The value of a sample.
    pub fn value(&self, sample: f64) -> f64 {
        self.slope * sample + self.intercept
    }

    /// The sample that would have this value.
    pub fn sample(&self, value: f64) -> f64 {
        (value - self.intercept) / self.slope
    }

    /// True if values are the samples themselves.
    pub fn is_identity(&self) -> bool {
        *self == Scaling::default()
    }
}

impl Default for Scaling {
    fn default() -> Self {
        Scaling { slope: 1.0, intercept: 0.0 }
    }
}

/// Why samples do not make a volume. Each text reads well after the name of the file and a colon.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum VolumeError {
    /// A side of 0, or more voxels than can be addressed.
    #[error("{0} x {1} x {2} voxels cannot be held")]
    Size(usize, usize, usize),
    /// The number of samples is not the number of voxels.
    #[error("{found} samples for {expected} voxels")]
    Count {
        /// Voxels.
        expected: usize,
        /// Samples.
        found: usize,
    },
    /// The voxels have no volume, or a step is not a finite number.
    #[error("the voxel grid is degenerate: {0}")]
    Degenerate(String),
    /// Slope or intercept are not finite, or the slope is 0.
    #[error("samples cannot be scaled by {slope} and shifted by {intercept}")]
    Scaling {
        /// Factor.
        slope: f64,
        /// Summand.
        intercept: f64,
    },
}

/// Scalar samples on a regular grid.
///
/// Samples stand at the centres of voxels, x fastest, then y, then z. They keep their stored type; a *value* is a
/// sample under the [`Scaling`]. A single slice (a side of 1) is a volume too.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    dims: [usize; 3],
    samples: Samples,
    scaling: Scaling,
    affine: Affine,
}

impl Volume {
    /// A volume of `dims` voxels, x fastest, in the world that `affine` says.
    ///
    /// # Errors
    /// [`VolumeError`]: a side is 0, the number of samples is wrong, the affine is singular or not finite, the
    /// scaling is not finite or maps everything to one value.
    pub fn new(
        dims: [usize; 3],
        samples: Samples,
        scaling: Scaling,
        affine: Affine,
    ) -> Result<Volume, VolumeError> {
        let [x, y, z] = dims;
        let size = || VolumeError::Size(x, y, z);
        let expected =
            x.checked_mul(y).and_then(|xy| xy.checked_mul(z)).filter(|&n| n > 0).ok_or_else(size)?;
        if samples.len() != expected {
            return Err(VolumeError::Count { expected, found: samples.len() });
        }
        affine.check().map_err(VolumeError::Degenerate)?;
        let Scaling { slope, intercept } = scaling;
        if !slope.is_finite() || slope == 0.0 || !intercept.is_finite() {
            return Err(VolumeError::Scaling { slope, intercept });
        }
        Ok(Volume { dims, samples, scaling, affine })
    }

    /// A volume of `dims` voxels, x fastest, `spacing` apart in world units; the samples are copied.
    ///
    /// # Errors
    /// As [`Volume::new`].
    pub fn from_slice<T: Sample>(
        dims: [usize; 3],
        spacing: [f64; 3],
        samples: &[T],
    ) -> Result<Volume, VolumeError> {
        Volume::from_vec(dims, spacing, samples.to_vec())
    }

    /// As [`Volume::from_slice`], but takes the samples as they are.
    ///
    /// # Errors
    /// As [`Volume::new`].
    pub fn from_vec<T: Sample>(
        dims: [usize; 3],
        spacing: [f64; 3],
        samples: Vec<T>,
    ) -> Result<Volume, VolumeError> {
        Volume::new(dims, T::wrap(samples), Scaling::default(), Affine::from_spacing(spacing))
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The samples, x fastest, then y, then z.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// The samples, to be changed in place.
    pub(crate) fn samples_mut(&mut self) -> &mut Samples {
        &mut self.samples
    }

    /// From samples to values.
    pub fn scaling(&self) -> Scaling {
        self.scaling
    }

    /// From voxel indices to the world.
    pub fn affine(&self) -> &Affine {
        &self.affine
    }

    /// This volume in another place.
    pub fn with_affine(self, affine: Affine) -> Volume {
        Volume { affine, ..self }
    }

    /// Distances between neighbouring voxels along x, y and z, world units.
    pub fn spacing(&self) -> [f64; 3] {
        self.affine.spacing()
    }

    /// The value of a voxel: its sample under the scaling.
    ///
    /// # Panics
    /// If there is no such voxel.
    pub fn value_at(&self, x: usize, y: usize, z: usize) -> f64 {
        let [nx, ny, nz] = self.dims;
        assert!(x < nx && y < ny && z < nz, "voxel {x}, {y}, {z} of {nx} x {ny} x {nz}");
        self.scaling.value(self.samples.get(x + nx * (y + ny * z)))
    }

    /// The corners of the smallest box along the world's axes around all voxel *centres*: where samples, and
    /// therefore surfaces, can lie. Flat for a single slice.
    pub fn bounds(&self) -> [DVec3; 2] {
        let last = self.dims.map(|n| (n - 1) as f64);
        let corner = |c: usize| {
            self.affine.point([0, 1, 2].map(|axis| if c >> axis & 1 == 1 { last[axis] } else { 0.0 }))
        };
        (1..8).fold([corner(0); 2], |[min, max], c| [min.min(corner(c)), max.max(corner(c))])
    }

    /// The world point in the middle of the volume.
    pub fn center(&self) -> DVec3 {
        self.affine.point(self.dims.map(|n| (n - 1) as f64 / 2.0))
    }

    /// How long the sides are with whole voxels, `dims · spacing`, world units.
    pub fn extent(&self) -> [f64; 3] {
        let spacing = self.spacing();
        [0, 1, 2].map(|axis| self.dims[axis] as f64 * spacing[axis])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    #[test]
    fn refuses_what_is_no_volume() {
        let new = |dims, spacing| Volume::from_slice(dims, spacing, &[1u8, 2, 3, 4, 5, 6]);
        assert_eq!(new([1, 2, 0], [1.0; 3]), Err(VolumeError::Size(1, 2, 0)));
        assert_eq!(new([usize::MAX, 2, 3], [1.0; 3]), Err(VolumeError::Size(usize::MAX, 2, 3)));
        assert_eq!(new([2, 2, 2], [1.0; 3]), Err(VolumeError::Count { expected: 8, found: 6 }));
        for bad in [0.0, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
            assert!(matches!(new([1, 2, 3], [1.0, bad, 1.0]), Err(VolumeError::Degenerate(_))), "{bad}");
        }
        assert!(new([1, 2, 3], [1.0, -2.0, 0.5]).is_ok());
        assert!(new([6, 1, 1], [1.0; 3]).is_ok());

        let scaled = |slope, intercept| {
            let affine = Affine::from_spacing([1.0; 3]);
            Volume::new([1, 1, 1], Samples::U8(vec![1]), Scaling { slope, intercept }, affine)
        };
        assert!(scaled(-2.0, 5.0).is_ok());
        for (slope, intercept) in [(0.0, 1.0), (f64::NAN, 0.0), (1.0, f64::INFINITY)] {
            assert!(matches!(scaled(slope, intercept), Err(VolumeError::Scaling { .. })));
        }
    }

    #[test]
    fn values_are_scaled_samples_with_x_fastest() {
        let affine = Affine::from_spacing([1.0; 3]);
        let scaling = Scaling { slope: 0.5, intercept: -1024.0 };
        let samples = Samples::I16((0..24).collect());
        let v = Volume::new([2, 3, 4], samples, scaling, affine).unwrap();
        assert_eq!(v.value_at(1, 2, 3), 23.0 * 0.5 - 1024.0);
        assert_eq!(v.value_at(1, 0, 0), 0.5 - 1024.0);
        assert_eq!(v.value_at(0, 1, 0), 1.0 - 1024.0);
        assert_eq!(scaling.sample(scaling.value(17.0)), 17.0);
    }

    #[test]
    fn bounds_hold_every_corner_of_a_sheared_mirrored_grid() {
        let mut affine = Affine::from_spacing([1.0; 3]);
        affine.linear = DMat3::from_cols_array(&[-1.0, 0.0, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0, 3.0]);
        affine.origin = DVec3::new(100.0, 0.0, 0.0);
        let v = Volume::new([3, 5, 2], Samples::F32(vec![0.0; 30]), Scaling::default(), affine).unwrap();
        assert_eq!(v.bounds(), [DVec3::new(98.0, 0.0, 0.0), DVec3::new(102.0, 8.0, 3.0)]);
        assert_eq!(v.center(), DVec3::new(100.0, 4.0, 1.5));
        assert_eq!(v.extent(), [3.0, 5.0 * 4.25f64.sqrt(), 6.0]);
    }
}
