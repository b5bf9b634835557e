//! From where an input is looked at unless a camera is given.

use dotwork_drawing::{Camera, UpAxis};
use dotwork_ink::{Clip, Style};
use dotwork_volume::{Space, Volume};
use glam::{DVec3, Vec3};

/// A volume is flat if it is thinner than this share of its next larger side.
const FLAT: f64 = 0.2;

/// A flat volume of no more layers shows nothing but what is on them: it is cut open between its two sides.
const MOST_LAYERS: usize = 3;

/// From where an input wants to be looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlook {
    /// The axis that points up by the habits of its format.
    pub up: UpAxis,
    /// It is a patient, seen from the front.
    pub patient: bool,
    /// It is flat, and this unit vector points to whoever looks at it face on.
    pub flat: Option<DVec3>,
    /// It is a slice or few of them.
    pub slices: bool,
}

impl Outlook {
    /// That of a mesh.
    pub fn of_mesh(up: UpAxis) -> Outlook {
        Outlook { up, patient: false, flat: None, slices: false }
    }

    /// That of a volume: a patient stands and faces the eye; what does not say how it lies has `up` up. A flat one is seen face on: by the habits of radiology (from below, from the front, from the
    /// left), or as an image.
    pub fn of_volume(volume: &Volume, up: UpAxis) -> Outlook {
        let affine = volume.affine();
        let patient = affine.space == Space::Patient;
        let (dims, steps) = (volume.dims(), affine.linear);
        let sides: [f64; 3] = std::array::from_fn(|k| dims[k] as f64 * steps.col(k).length());
        let thin = (0..3).find(|&k| (0..3).all(|j| j == k || sides[k] < FLAT * sides[j]));
        // The two other steps span the slice, whatever the third one is.
        let across = |k: usize| steps.col((k + 1) % 3).cross(steps.col((k + 2) % 3)).normalize_or_zero();
        let towards = |n: DVec3| {
            let habits = if patient { DVec3::new(0.5, -1.0, -0.9) } else { DVec3::NEG_Z };
            if n.dot(habits) < 0.0 { -n } else { n }
        };
        // Rows of an image run down; seen so, it is not mirrored either.
        let image = thin == Some(2);
        let up = match (patient, image) {
            (true, _) => UpAxis::Z,
            (false, true) => UpAxis::NegY,
            (false, false) => up,
        };
        let flat = thin.map(across).map(towards).filter(|n| *n != DVec3::ZERO);
        let slices = thin.is_some_and(|k| dims[k] <= MOST_LAYERS);
        Outlook { up, patient, flat, slices }
    }

    /// Turns a camera so, with `up` where that is given, and then towards sides with the normals `sides`.
    pub(super) fn turn(&self, up: Option<UpAxis>, sides: &[Vec3], camera: &mut Camera) {
        camera.up = up.unwrap_or(self.up);
        match self.flat {
            Some(towards) if camera.up == self.up => camera.face(towards.as_vec3()),
            _ if self.patient => (camera.azimuth, camera.elevation) = (0.0, 0.0),
            _ => (),
        }
        camera.turn_towards(sides);
    }

    /// What `style` cuts away, as [`dotwork_mesh::ClipRegion::parse`] reads it; empty for nothing.
    pub(super) fn clip(&self, style: &Style) -> String {
        match &style.clip {
            Clip::Auto => self.cut().unwrap_or_default(),
            Clip::Planes(planes) => planes.clone(),
        }
    }

    /// The clip that cuts a slice open where it is looked at.
    fn cut(&self) -> Option<String> {
        let DVec3 { x, y, z } = self.flat.filter(|_| self.slices)?;
        // Rounding of a millionth turns by less than a pixel on any page.
        let short = |v: f64| (v * 1e6).round() / 1e6 + 0.0;
        Some(format!("plane={},{},{},0.5", short(x), short(y), short(z)))
    }
}

#[cfg(test)]
mod tests {
    use dotwork_volume::{Affine, Samples, Scaling};

    use super::*;

    fn outlook(dims: [usize; 3], spacing: [f64; 3], space: Space) -> Outlook {
        let affine = Affine { space, ..Affine::from_spacing(spacing) };
        let samples = Samples::U8(vec![0; dims.iter().product()]);
        let volume = Volume::new(dims, samples, Scaling::default(), affine).unwrap();
        Outlook::of_volume(&volume, UpAxis::NegZ)
    }

    #[test]
    fn slices_are_seen_face_on_and_cut_open() {
        let axial = outlook([64, 64, 1], [1.0, 1.0, 5.0], Space::Patient);
        assert_eq!((axial.flat, axial.slices, axial.up), (Some(DVec3::NEG_Z), true, UpAxis::Z));
        assert_eq!(axial.cut().unwrap(), "plane=0,0,-1,0.5");
        let coronal = outlook([64, 2, 64], [1.0; 3], Space::Patient);
        assert_eq!(coronal.flat, Some(DVec3::NEG_Y));
        let sagittal = outlook([1, 64, 64], [1.0; 3], Space::Patient);
        assert_eq!(sagittal.flat, Some(DVec3::X));
        let stack = outlook([64, 64, 9], [1.0; 3], Space::Unknown);
        assert_eq!((stack.flat, stack.slices, stack.up), (Some(DVec3::NEG_Z), false, UpAxis::NegY));
        assert_eq!(stack.cut(), None);
        let page = dotwork_drawing::Page::default();
        for (look, right, up) in [(axial, Vec3::X, Vec3::NEG_Y), (stack, Vec3::X, Vec3::NEG_Y)] {
            let mut camera = Camera::default();
            look.turn(None, &[], &mut camera);
            let view = camera.view(Vec3::ZERO, 1.0, &page);
            assert!((view.right - right).length() + (view.up - up).length() < 1e-5, "{view:?}");
        }
    }

    #[test]
    fn what_is_not_flat_stands() {
        let head = outlook([64, 64, 40], [1.0; 3], Space::Patient);
        assert_eq!((head.flat, head.up, head.slices), (None, UpAxis::Z, false));
        let unknown = outlook([64, 64, 40], [1.0; 3], Space::Unknown);
        assert_eq!((unknown.flat, unknown.up), (None, UpAxis::NegZ));
        // A rod is thin in two directions: it is not flat.
        assert_eq!(outlook([5, 5, 64], [1.0; 3], Space::Unknown).flat, None);
    }
}
