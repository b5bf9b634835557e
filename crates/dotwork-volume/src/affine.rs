//! From voxel indices to the world: spacing, orientation, origin and units in one affine.

use std::fmt;

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

impl Unit {
    /// Its symbol: `mm`; `units` if nobody said.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Unknown => "units",
            Unit::Metre => "m",
            Unit::Millimetre => "mm",
            Unit::Micrometre => "µm",
            Unit::Nanometre => "nm",
        }
    }

    /// Its length in millimetres, if it is known.
    pub fn millimetres(self) -> Option<f64> {
        match self {
            Unit::Unknown => None,
            Unit::Metre => Some(1e3),
            Unit::Millimetre => Some(1.0),
            Unit::Micrometre => Some(1e-3),
            Unit::Nanometre => Some(1e-6),
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

/// The angle between a voxel axis and the nearest world axis from which a volume counts as oblique, degrees: headers
/// with few digits stay below it.
const OBLIQUE_DEG: f64 = 0.5;

/// Voxels flatter than this (their volume over that of the box with the same edges) cannot be told from flat ones.
const MIN_FLATNESS: f64 = 1e-6;

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
    /// Voxels `spacing` apart along the axes, the first at 0. A negative spacing lets the index run against the axis.
    pub fn from_spacing(spacing: [f64; 3]) -> Affine {
        Affine {
            linear: DMat3::from_diagonal(DVec3::from_array(spacing)),
            origin: DVec3::ZERO,
            space: Space::Unknown,
            unit: Unit::Unknown,
        }
    }

    /// The three steps, world units.
    fn steps(&self) -> [DVec3; 3] {
        [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis]
    }

    /// Lengths of the three steps, world units.
    pub fn spacing(&self) -> [f64; 3] {
        self.steps().map(DVec3::length)
    }

    /// The largest spacing over the smallest, at least 1.
    pub fn anisotropy(&self) -> f64 {
        let [x, y, z] = self.spacing();
        x.max(y).max(z) / x.min(y).min(z)
    }

    /// Where the voxel index `index` lies in the world; whole numbers are the centres of voxels.
    pub fn point(&self, index: [f64; 3]) -> DVec3 {
        self.linear * DVec3::from_array(index) + self.origin
    }

    /// True if the voxel axes form a left-handed frame in the world: the picture in index space is a mirror image.
    pub fn is_mirrored(&self) -> bool {
        let [x, y, z] = self.directions();
        x.cross(y).dot(z) < 0.0
    }

    /// Unit steps. Their products neither overflow nor vanish, whatever the unit of the world.
    fn directions(&self) -> [DVec3; 3] {
        self.steps().map(DVec3::normalize_or_zero)
    }

    /// For each voxel axis the world axis (0, 1, 2) that it follows most closely, and 1 or −1 for the direction along
    /// it. Each world axis is given once: of the six assignments, the one with the largest sum of cosines.
    pub fn closest_axes(&self) -> [(usize, f64); 3] {
        const ASSIGNMENTS: [[usize; 3]; 6] =
            [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let directions = self.directions();
        let score =
            |axes: [usize; 3]| -> f64 { (0..3).map(|voxel| directions[voxel][axes[voxel]].abs()).sum() };
        let mut best = ASSIGNMENTS[0];
        for axes in ASSIGNMENTS {
            if score(axes) > score(best) {
                best = axes;
            }
        }
        [0, 1, 2].map(|voxel| (best[voxel], directions[voxel][best[voxel]].signum()))
    }

    /// The letters of the sides towards which the three indices grow, such as `RAS` or `LPS`: Left, Right, Anterior,
    /// Posterior, Superior, Inferior, all of them the patient's. `None` outside [`Space::Patient`].
    ///
    /// An oblique volume has the letters of the closest axes.
    ///
    /// ```
    /// use dotwork_volume::{Affine, Space};
    ///
    /// let mut affine = Affine::from_spacing([-1.0, -1.0, 2.5]);
    /// assert_eq!(affine.orientation(), None);
    /// affine.space = Space::Patient;
    /// assert_eq!(affine.orientation(), Some(['R', 'A', 'S']));
    /// ```
    pub fn orientation(&self) -> Option<[char; 3]> {
        const SIDES: [[char; 2]; 3] = [['L', 'R'], ['P', 'A'], ['S', 'I']];
        match self.space {
            Space::Unknown => None,
            Space::Patient => {
                Some(self.closest_axes().map(|(axis, sign)| SIDES[axis][usize::from(sign < 0.0)]))
            }
        }
    }

    /// The largest angle between a voxel axis and the world axis that it follows, degrees: 0 for a volume scanned
    /// along the axes.
    pub fn obliquity_deg(&self) -> f64 {
        let directions = self.directions();
        let closest = self.closest_axes();
        let angle = |voxel: usize| {
            let (axis, sign) = closest[voxel];
            directions[voxel].angle_between(DVec3::AXES[axis] * sign).to_degrees()
        };
        angle(0).max(angle(1)).max(angle(2))
    }

    /// True if a voxel axis is more than half a degree away from the world axis that it follows.
    pub fn is_oblique(&self) -> bool {
        self.obliquity_deg() > OBLIQUE_DEG
    }

    /// How far the voxel axes are from right angles, degrees: the tilt of a gantry, 0 for boxes.
    pub fn shear_deg(&self) -> f64 {
        let [x, y, z] = self.directions();
        let off = |a: DVec3, b: DVec3| (a.angle_between(b).to_degrees() - 90.0).abs();
        off(x, y).max(off(y, z)).max(off(z, x))
    }

    /// Says what is wrong with it: a number that is not finite, or voxels without volume.
    pub(crate) fn check(&self) -> Result<(), String> {
        if !self.linear.is_finite() || !self.origin.is_finite() {
            return Err("its spacing or origin is not a finite number".into());
        }
        for (axis, step) in ["x", "y", "z"].into_iter().zip(self.steps()) {
            // Written so that lengths whose squares overflow or vanish fail as well.
            if !(step.length() > 0.0 && step.length().is_finite()) {
                return Err(format!("no voxels are {:e} apart along {axis}", step.length()));
            }
        }
        let [x, y, z] = self.directions();
        if x.cross(y).dot(z).abs() < MIN_FLATNESS {
            return Err("its three axes lie in a plane".into());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patient(x: [f64; 3], y: [f64; 3], z: [f64; 3]) -> Affine {
        Affine {
            linear: DMat3::from_cols(x.into(), y.into(), z.into()),
            space: Space::Patient,
            ..Affine::from_spacing([1.0; 3])
        }
    }

    fn letters(affine: &Affine) -> String {
        affine.orientation().unwrap().iter().collect()
    }

    #[test]
    fn letters_name_the_side_to_which_the_index_grows() {
        assert_eq!(letters(&patient([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0])), "LPS");
        assert_eq!(letters(&patient([-2.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 3.0])), "RAS");
        // A sagittal stack: x runs backwards, y down, z to the left.
        let sagittal = patient([0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
        assert_eq!(letters(&sagittal), "PIL");
        assert!(sagittal.is_mirrored());
    }

    #[test]
    fn every_assignment_and_sign_is_recovered_under_small_turns() {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.2, -0.3, 0.25);
        let mut seen = std::collections::HashSet::new();
        for axes in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            for signs in 0..8 {
                let column = |i: usize| {
                    DVec3::AXES[axes[i]] * if signs >> i & 1 == 1 { -1.0 } else { 1.0 } * [0.5, 1.0, 7.0][i]
                };
                let linear = DMat3::from_cols(column(0), column(1), column(2));
                let straight = Affine { linear, space: Space::Patient, ..Affine::from_spacing([1.0; 3]) };
                let turned = Affine { linear: turn * linear, ..straight };
                assert_eq!(letters(&straight), letters(&turned));
                assert_eq!(straight.is_mirrored(), linear.determinant() < 0.0);
                assert_eq!(turned.is_mirrored(), straight.is_mirrored());
                assert!(straight.obliquity_deg() < 1e-6 && !straight.is_oblique());
                assert!(turned.is_oblique() && turned.shear_deg() < 1e-5);
                assert!((turned.anisotropy() - 14.0).abs() < 1e-9);
                seen.insert(letters(&turned));
            }
        }
        assert_eq!(seen.len(), 48);
    }

    #[test]
    fn two_axes_near_one_world_axis_still_get_one_each() {
        // Both x and y lean towards world x; a greedy choice would give it twice.
        let a = patient([1.0, 0.1, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(letters(&a), "LPS");
        assert!((a.obliquity_deg() - (0.6f64).acos().to_degrees()).abs() < 1e-9);
    }

    #[test]
    fn obliquity_and_shear_are_the_angles_put_in() {
        let (s, c) = 17f64.to_radians().sin_cos();
        let tilted = patient([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, s, c]);
        assert!((tilted.shear_deg() - 17.0).abs() < 1e-9 && (tilted.obliquity_deg() - 17.0).abs() < 1e-9);
        let (s, c) = 0.4f64.to_radians().sin_cos();
        assert!(!patient([c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]).is_oblique());
    }

    #[test]
    fn the_unit_of_the_world_does_not_matter() {
        for scale in [1e-120, 1e-9, 1e9, 1e120] {
            let mut a = patient([scale, 0.0, 0.0], [0.0, scale, 0.0], [0.0, 0.0, -scale]);
            assert!(a.check().is_ok() && a.is_mirrored() && a.obliquity_deg() < 1e-6);
            a.linear.y_axis = a.linear.x_axis * 0.5;
            assert!(a.check().is_err());
        }
    }

    #[test]
    fn points_are_voxel_centres() {
        let mut a = Affine::from_spacing([0.5, 2.0, -3.0]);
        a.origin = DVec3::new(10.0, 20.0, 30.0);
        assert_eq!(a.point([0.0; 3]), a.origin);
        assert_eq!(a.point([2.0, 1.5, 1.0]), DVec3::new(11.0, 23.0, 27.0));
        assert_eq!(a.spacing(), [0.5, 2.0, 3.0]);
    }
}
