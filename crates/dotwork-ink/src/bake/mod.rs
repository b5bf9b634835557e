//! Bakes: who makes the order of the stipples.

mod blue_noise;
mod buckets;

pub use blue_noise::{BakeSettings, MAX_STIPPLES, blue_noise};
