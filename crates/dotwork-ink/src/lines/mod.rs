//! Lines that follow from the form and the eye, as chains of points in space. What hides them, and how they are drawn,
//! is decided by whoever looks.

mod contour;
mod curvature;
mod surface;
mod voxel_curves;

pub use contour::{Chains, Contours, Eye};
pub use curvature::Ridges;
pub use surface::SurfaceLines;
pub use voxel_curves::{Chosen, Criteria, Lattice, MAX_PIECE_ID, Piece, VoxelCurves};
