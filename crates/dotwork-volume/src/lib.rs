//! Volumes: scalar samples on a regular grid, in the type in which they were stored, and one affine to the world.
//!
//! [`Volume`] is what readers hand over: [`Samples`] of one of ten types, a [`Scaling`] to values, and an [`Affine`]
//! that carries spacing, orientation, origin and unit. [`Volume::stats`] and [`Volume::histogram`] say what the values
//! are like, [`Volume::isosurface`] makes a surface of one value a mesh. This crate knows nothing of ink, files or
//! devices.
//!
//! ```
//! use dotwork_drawing::Warnings;
//! use dotwork_mesh::{Mesh, MeshOptions};
//! use dotwork_volume::{IsoOptions, Volume};
//!
//! // The distance from the middle of a grid: its isosurfaces are spheres.
//! let n = 32;
//! let away = |i: usize| (i as f32 - 15.5).powi(2);
//! let samples: Vec<f32> =
//!     (0..n * n * n).map(|i| -(away(i % n) + away(i / n % n) + away(i / n / n)).sqrt()).collect();
//! let volume = Volume::from_slice([n, n, n], [0.5, 0.5, 0.5], &samples)?;
//!
//! let mut warnings = Warnings::new();
//! let raw = volume.isosurface(-12.0, &IsoOptions::default(), &mut warnings)?;
//! assert_eq!(raw.normals.len(), raw.positions.len());
//!
//! let sphere = Mesh::build(raw, &MeshOptions::default(), &mut warnings)?;
//! assert!(sphere.closed && warnings.is_empty());
//! assert!((sphere.area() / (4.0 * std::f64::consts::PI * 6.0 * 6.0) - 1.0).abs() < 0.01);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// First, for its macro.
#[macro_use]
mod samples;

mod affine;
mod cut;
mod features;
mod gradient;
mod isosurface;
mod labels;
mod laplacian;
mod neighbours;
pub mod phantom;
mod prepare;
mod ridge;
mod runs;
mod stats;
mod threshold;
mod transfer;
mod volume;

pub use affine::{Affine, Space, Unit};
pub use cut::{CutFace, CutPlane, cut_faces};
pub use features::{Feature, FeatureError, Features, find_features};
pub use gradient::{GradientField, Regression, RegressionRow};
pub use isosurface::{IsoError, IsoOptions};
pub use labels::{Label, LabelError, LabelOptions, MAX_LABELS, labels};
pub use laplacian::LaplacianOfGaussian;
pub use prepare::{ComponentsReport, Keep, Preparation, PrepareError, keep_components, prepare};
pub use ridge::RidgeReport;
pub use samples::{Sample, SampleType, Samples};
pub use stats::{Histogram, VolumeStats};
pub use threshold::{GradientThreshold, MIN_PIECE, Mask};
pub use transfer::{TransferError, TransferFunction, TransferSurface};
pub use volume::{Scaling, Volume, VolumeError};
