//! The volume type.

use thiserror::Error;

use crate::affine::Affine;
use crate::samples::{Sample, Samples};

/// From a stored sample to its value: `value = slope · sample + intercept` (NIfTI's scl_slope, DICOM's rescale).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// Factor.
    pub slope: f64,
    /// Summand.
    pub intercept: f64,
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
}

/// Scalar samples on a regular grid.
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
    /// [`VolumeError`]: a side is 0, the number of samples is wrong, the affine is singular or not finite.
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
        Ok(Volume { dims, samples, scaling, affine })
    }

    /// A volume of `dims` voxels, x fastest, `spacing` apart in world units.
    ///
    /// # Errors
    /// As [`Volume::new`].
    pub fn from_slice<T: Sample>(
        dims: [usize; 3],
        spacing: [f64; 3],
        samples: &[T],
    ) -> Result<Volume, VolumeError> {
        Volume::new(dims, T::wrap(samples.to_vec()), Scaling::default(), Affine::from_spacing(spacing))
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// The samples, x fastest, then y, then z.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// From samples to values.
    pub fn scaling(&self) -> Scaling {
        self.scaling
    }

    /// From voxel indices to the world.
    pub fn affine(&self) -> &Affine {
        &self.affine
    }
}
