//! Bakes: who makes the order of the stipples.

mod blue_noise;
mod buckets;
mod hierarchy;
mod voxel;

pub use blue_noise::{BakeSettings, MAX_STIPPLES, blue_noise};
pub use hierarchy::{HierarchySettings, hierarchy};
pub use voxel::{
    MAX_IN_VOXEL, MIN_VOXEL_PX, VoxelSettings, Voxels, box_filter, box_filter_level, n_max, rank_of,
    reference_scale, spacing_of, voxel,
};
