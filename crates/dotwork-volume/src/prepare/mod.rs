//! The preparation of a volume for drawing: one pass that turns whatever was scanned into a clean, isotropic, 16-bit
//! volume whose values are still those of the source.
//!
//! 1. A **window** of values is what the 16 bits span (`window`).
//! 2. **Padding** with the low value closes the faces that the border of the scan cuts open (`grid`).
//! 3. Axes with coarse steps are **resampled** to the finest one by cubic convolution, which removes the terraces of
//!    thick slices; nothing is ever sampled down (`grid`, `kernel`).
//! 4. A small **Gaussian** takes the noise of single voxels (`kernel`).
//!
//! Steps 2 to 4 are linear along each axis, so they are one sparse matrix per axis, and all of it is one pass over the
//! volume in jobs that fit a cache (`filter`). Memory is that of source and result and a few hundred kilobytes a
//! thread.
//!
//! What is left of the surroundings (table, holder, specks) is taken away by components (`components`).

mod components;
mod filter;
mod grid;
mod kernel;
mod window;

use dotwork_drawing::Warnings;
use rayon::prelude::*;
use thiserror::Error;

use crate::samples::{Ordered, Samples};
use crate::volume::{Scaling, Volume, VolumeError};
use filter::Filter;
use grid::Grid;
use kernel::Weights;
use window::{STEPS, ToUnit, window};

pub use components::{ComponentsReport, Keep, keep_components};

/// The widest Gaussian, in the same unit as [`Preparation::smooth`].
const SMOOTHEST: f64 = 8.0;

/// The Gaussian of [`Preparation::smooth`] does not grow with a spacing beyond this many times the finest.
const THICKEST: f64 = 4.0;

/// Smoothing if nothing is said.
const SMOOTH: f64 = 0.5;

/// How a volume is prepared for drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preparation {
    /// The values that become 0 and 65535 of the result; what is beyond is clamped. `None`: from the most common value
    /// of the air (without air: the 0.1 % percentile) to the 99.9 % percentile of the values above the air, of the
    /// whole volume whatever the crop.
    pub window: Option<[f64; 2]>,
    /// Pad by 3 source voxels of the low value all round, which closes the faces that the border cuts open, those of
    /// the crop as well; on by default.
    pub cap: bool,
    /// Resample to the finest spacing where the largest spacing is more than this many times the smallest; 1.3 by
    /// default, `None`: never.
    pub isotropic: Option<f64>,
    /// The standard deviation of the Gaussian, in units of the source's largest spacing (of 4 times its smallest, if
    /// that is less), 0…8; the same in all directions of the world. `None`: 0.5. 0: off. The thickness of a single
    /// slice is not among the spacings, and across a slice nothing is smoothed.
    pub smooth: Option<f64>,
    /// The part to keep, in shares 0…1 of the box of voxels along x, y and z (the file's, x fastest): voxels with
    /// their centres in it, at least one. `None`: all.
    pub crop: Option<[[f64; 2]; 3]>,
}

impl Default for Preparation {
    fn default() -> Self {
        Preparation { window: None, cap: true, isotropic: Some(1.3), smooth: None, crop: None }
    }
}

/// Why a volume cannot be prepared. Each text reads well after the name of the file and a colon.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PrepareError {
    /// Every finite value is the same.
    #[error("all values are {value}: there is nothing to draw")]
    Flat {
        /// That value.
        value: f64,
    },
    /// Every sample is NaN or infinite.
    #[error("none of the samples is a finite number: there is nothing to draw")]
    NoValues,
    /// The window is empty, not finite, or beyond all values.
    #[error("the window {low} to {high} shows nothing of values from {min} to {max}")]
    Window {
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
        /// The smallest finite value.
        min: f64,
        /// The largest finite value.
        max: f64,
    },
    /// The crop is no interval within 0…1.
    #[error("a crop along {axis} from {low} to {high} is no part of 0 to 1")]
    Crop {
        /// `x`, `y` or `z`.
        axis: &'static str,
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
    },
    /// A parameter is out of its range.
    #[error("{name} is {value}, and must be {range}")]
    Parameter {
        /// Its name in [`Preparation`].
        name: &'static str,
        /// What was asked for.
        value: f64,
        /// What may be asked for.
        range: &'static str,
    },
    /// Padding multiplies the voxels of a thin volume, or there is no memory for the result.
    #[error("there is no room for {} x {} x {} prepared voxels; crop the volume or leave the cap", dims[0], dims[1], dims[2])]
    TooLarge {
        /// Voxels of the result.
        dims: [usize; 3],
    },
    /// Components are those of a prepared volume.
    #[error("the volume is not prepared")]
    Unprepared,
    /// The steps of the result are too small to be numbers.
    #[error(transparent)]
    Volume(#[from] VolumeError),
}

/// Prepares a volume: window, padding, resampling along coarse axes, smoothing.
///
/// The result has [`Samples::U16`] and a [`Scaling`] under which its *values* are the source's: sample 0 is the low end
/// of the window, 65535 the high end. Statistics, isosurfaces and the meaning of an iso value stay what they were, and
/// its affine places it exactly where the source lies. Without padding its first and last voxels along each axis are
/// those of the (cropped) source.
///
/// A NaN counts as the low value and is warned of; −∞ and ∞ are the ends of the window. Where resampling to the finest
/// spacing would make more than 4 times the voxels (and more than 2²⁷), the step is coarser, and a warning says so.
/// `progress` is called with ascending shares 0…1, one call at a time, from any thread. The result is the same on any
/// number of threads.
///
/// # Errors
/// [`PrepareError`].
///
/// ```
/// use dotwork_drawing::Warnings;
/// use dotwork_volume::{Preparation, Volume, prepare};
///
/// // A bright block that the scan cuts off, in slices 3 units thick.
/// let samples: Vec<u8> = (0..10 * 10 * 10).map(|i| if i % 10 < 6 { 10 } else { 200 }).collect();
/// let volume = Volume::from_vec([10, 10, 10], [1.0, 1.0, 3.0], samples)?;
/// let prepared = prepare(&volume, &Preparation::default(), &|_| {}, &mut Warnings::new())?;
/// assert_eq!(prepared.spacing(), [1.0; 3]);
/// assert_eq!(prepared.dims(), [16, 16, 46]);
/// // Values keep their meaning.
/// assert!((prepared.value_at(3, 8, 23) - 10.0).abs() < 0.01);
/// assert!((prepared.value_at(0, 8, 23) - 10.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn prepare(
    volume: &Volume,
    preparation: &Preparation,
    progress: &(dyn Fn(f32) + Sync),
    warnings: &mut Warnings,
) -> Result<Volume, PrepareError> {
    let smooth = preparation.smooth.unwrap_or(SMOOTH);
    if !(0.0..=SMOOTHEST).contains(&smooth) {
        return Err(PrepareError::Parameter { name: "smooth", value: smooth, range: "from 0 to 8" });
    }
    if let Some(value) = preparation.isotropic.filter(|ratio| ratio.is_nan() || *ratio < 1.0) {
        return Err(PrepareError::Parameter { name: "isotropic", value, range: "at least 1" });
    }
    let [low, high] = window(volume, preparation.window)?;
    let mut said = Warnings::new();
    let grid = Grid::new(volume, preparation, &mut said)?;
    let affine = grid.affine(volume.affine());
    let sigma = smooth * smoothing_unit(volume);
    let spacing = affine.spacing();
    let weights = [0, 1, 2].map(|a| {
        let axis = &grid.0[a];
        // A slice may be said to be so thin that the Gaussian across it would never end.
        let sigma = if axis.kept > 1 { sigma / spacing[a] } else { 0.0 };
        Weights::new(axis, sigma, preparation.cap)
    });
    let scaling = Scaling { slope: high / STEPS - low / STEPS, intercept: low };

    let mut result = zeros(grid.dims())?;
    let nans = with_samples!(volume.samples(), samples => {
        let filter = Filter {
            samples,
            dims: volume.dims(),
            grid: &grid,
            weights,
            zero_outside: preparation.cap,
            unit: ToUnit::new(volume.scaling(), [low, high]),
        };
        filter.run(&mut result, progress);
        nans(samples)
    });
    let place = |i: usize| {
        let [nx, ny, _] = volume.dims();
        format!("voxel {}, {}, {}", i % nx, i / nx % ny, i / (nx * ny))
    };
    warnings.append(said);
    warnings.counted(
        "voxels whose value is not a number (NaN), taken as the low value",
        nans.0,
        nans.1.map(place),
    );
    Ok(Volume::new(grid.dims(), Samples::U16(result), scaling, affine)?)
}

/// The unit of [`Preparation::smooth`], world units.
fn smoothing_unit(volume: &Volume) -> f64 {
    let spacing = volume.spacing();
    let thick = |axis: &usize| volume.dims()[*axis] > 1;
    let finest = (0..3).filter(thick).map(|a| spacing[a]).fold(f64::INFINITY, f64::min);
    let coarsest = (0..3).filter(thick).map(|a| spacing[a]).fold(0.0, f64::max);
    coarsest.min(THICKEST * finest)
}

/// Room for the result. Pages are taken as they are written, by the threads that write them.
fn zeros(dims: [usize; 3]) -> Result<Vec<u16>, PrepareError> {
    let too_large = || PrepareError::TooLarge { dims };
    let [x, y, z] = dims;
    let voxels = x.checked_mul(y).and_then(|xy| xy.checked_mul(z)).ok_or_else(too_large)?;
    // Zeroed memory comes without a way to fail, so it is asked for twice.
    Vec::<u16>::new().try_reserve_exact(voxels).map_err(|_| too_large())?;
    Ok(vec![0; voxels])
}

/// How many samples are NaN, and the first of them.
fn nans<T: Ordered>(samples: &[T]) -> (u64, Option<usize>) {
    if !T::FLOAT {
        return (0, None);
    }
    let count =
        samples.par_chunks(1 << 16).map(|s| s.iter().map(|s| u64::from(s.is_nan())).sum::<u64>()).sum();
    (count, if count > 0 { samples.iter().position(|s| s.is_nan()) } else { None })
}
