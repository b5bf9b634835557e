//! Bakes: who makes the order of the stipples.

mod blue_noise;
mod buckets;
mod face;
mod hierarchy;
mod refine;
mod voxel;

pub use blue_noise::{BakeSettings, MAX_STIPPLES, blue_noise};
pub(crate) use face::rank_mask;
pub use face::{FaceSettings, face};
pub use hierarchy::{HierarchySettings, hierarchy};
pub use refine::{Brick, Cell, Refinement};
pub(crate) use voxel::RANK_MASK;
pub use voxel::{
    MAX_IN_VOXEL, MIN_VOXEL_PX, VoxelSettings, Voxels, box_filter, box_filter_level, n_max, reference_scale,
    spacing_of, voxel,
};
