//! Volumes: scalar samples on a regular grid, in the type in which they were stored, and one affine to the world.
//!
//! [`Volume`] is what readers hand over. This crate knows nothing of ink, files or devices.

mod affine;
mod samples;
mod volume;

pub use affine::{Affine, Space, Unit};
pub use samples::{Sample, SampleType, Samples};
pub use volume::{Scaling, Volume, VolumeError};
