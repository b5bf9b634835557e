//! From voxel indices to the world: spacing, orientation, origin and units in one affine.

use glam::{DMat3, DVec3};

/// What the world's axes mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Space {
    /// Nobody said.
    #[default]
    Unknown,
    /// The patient's: +x left, +y posterior, +z superior (LPS, as in DICOM). Readers of RAS formats turn the affine.
    /// Seen with z up from the front (the eye on −y) this is the anterior view.
    Patient,
}

/// The unit of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Nobody said.
    #[default]
    Unknown,
    /// Metres.
    Metre,
    /// Millimetres.
    Millimetre,
    /// Micrometres.
    Micrometre,
    /// Nanometres.
    Nanometre,
}

/// `world = linear · index + origin`; the centre of voxel (0, 0, 0) lies at `origin`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Its columns are the steps from one voxel to the next along x, y and z, world units.
    pub linear: DMat3,
    /// The centre of the first voxel, world units.
    pub origin: DVec3,
    /// What the world's axes mean.
    pub space: Space,
    /// Unit of the world.
    pub unit: Unit,
}

impl Affine {
    /// Voxels `spacing` apart along the axes, the first at 0.
    pub fn from_spacing(spacing: [f64; 3]) -> Affine {
        Affine {
            linear: DMat3::from_diagonal(DVec3::from_array(spacing)),
            origin: DVec3::ZERO,
            space: Space::Unknown,
            unit: Unit::Unknown,
        }
    }

    /// Lengths of the three steps, world units.
    pub fn spacing(&self) -> [f64; 3] {
        [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis].map(DVec3::length)
    }
}
