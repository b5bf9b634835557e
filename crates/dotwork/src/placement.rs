//! Where an object is put in its scene: scaled, turned and moved.

use std::fmt;
use std::str::FromStr;

use dotwork_mesh::{ClipPlane, ClipRegion, RawMesh};
use glam::{DMat3, DQuat, DVec3, EulerRot, Mat3, Vec3};

/// A similarity: `world = rotate · (scale · own) + translate`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Factor on all lengths, above 0.
    pub scale: f64,
    /// Degrees about the x axis, then about the y axis, then about the z axis.
    pub rotate: [f64; 3],
    /// Object units.
    pub translate: [f64; 3],
}

impl Default for Placement {
    /// Where the file says.
    fn default() -> Self {
        Placement { scale: 1.0, rotate: [0.0; 3], translate: [0.0; 3] }
    }
}

impl Placement {
    /// Largest and smallest scale.
    pub const SCALES: (f64, f64) = (1e-9, 1e9);

    /// The linear part and the shift.
    pub fn parts(&self) -> (DMat3, DVec3) {
        let [x, y, z] = self.rotate.map(f64::to_radians);
        // Extrinsic x, y, z is intrinsic z, y, x.
        let turn = DMat3::from_quat(DQuat::from_euler(EulerRot::ZYX, z, y, x));
        (turn * self.scale, DVec3::from_array(self.translate))
    }

    /// Puts what half-spaces have in common in its place; `None` if it lies too far away to be told.
    pub(crate) fn region(&self, region: &ClipRegion) -> Option<ClipRegion> {
        let (linear, shift) = self.parts();
        let normals = linear.inverse().transpose();
        let plane = |plane: &ClipPlane| {
            let normal = normals * plane.normal;
            ClipPlane::new(normal, plane.offset + normal.dot(shift)).ok()
        };
        let planes: Option<Vec<ClipPlane>> = region.planes().iter().map(plane).collect();
        ClipRegion::common(&planes?).ok()
    }

    /// Puts a mesh in its place.
    pub fn apply(&self, raw: &mut RawMesh) {
        if *self == Placement::default() {
            return;
        }
        let (linear, shift) = self.parts();
        raw.origin = (linear * DVec3::from_array(raw.origin) + shift).to_array();
        let near: Mat3 = linear.as_mat3();
        for p in &mut raw.positions {
            *p = (near * Vec3::from_array(*p)).to_array();
        }
        let turn = near * (1.0 / self.scale as f32);
        for n in &mut raw.normals {
            *n = (turn * Vec3::from_array(*n)).to_array();
        }
    }
}

impl fmt::Display for Placement {
    /// `scale 2 rotate 0,0,90 translate 1,2,3`, as [`Placement::from_str`] reads it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b, c] = self.rotate;
        let [x, y, z] = self.translate;
        write!(f, "scale {} rotate {a},{b},{c} translate {x},{y},{z}", self.scale)
    }
}

impl FromStr for Placement {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let error = || format!("'{s}' is not a placement (scale S rotate X,Y,Z translate X,Y,Z)");
        let words: Vec<&str> = s.split_whitespace().collect();
        let ["scale", scale, "rotate", rotate, "translate", translate] = words[..] else {
            return Err(error());
        };
        let three = |s: &str| {
            let all: Option<Vec<f64>> =
                s.split(',').map(|v| v.parse().ok().filter(|v: &f64| v.is_finite())).collect();
            all.and_then(|v| <[f64; 3]>::try_from(v).ok()).ok_or_else(error)
        };
        let (low, high) = Placement::SCALES;
        let scale = scale.parse().ok().filter(|s| (low..=high).contains(s)).ok_or_else(error)?;
        Ok(Placement { scale, rotate: three(rotate)?, translate: three(translate)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_then_turned_then_moved() {
        let mut raw = RawMesh {
            positions: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            normals: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            origin: [10.0, 0.0, 0.0],
            ..RawMesh::default()
        };
        // About x: y to z; then about z: x to y.
        let placement = Placement { scale: 2.0, rotate: [90.0, 0.0, 90.0], translate: [0.0, 0.0, 5.0] };
        placement.apply(&mut raw);
        let close = |a: [f32; 3], b: [f32; 3]| Vec3::from_array(a).distance(Vec3::from_array(b)) < 1e-5;
        assert!(close(raw.positions[0], [0.0, 2.0, 0.0]), "{:?}", raw.positions);
        assert!(close(raw.positions[1], [0.0, 0.0, 2.0]), "{:?}", raw.positions);
        assert!(close(raw.positions[2], [2.0, 0.0, 0.0]), "{:?}", raw.positions);
        assert!(close(raw.normals[1], [0.0, 0.0, 1.0]), "{:?}", raw.normals);
        assert!(DVec3::from_array(raw.origin).distance(DVec3::new(0.0, 20.0, 5.0)) < 1e-9);
        assert_eq!(placement.to_string().parse(), Ok(placement));
        // What is cut away of it goes with it: x becomes y, y becomes z, z becomes x.
        let region = ClipRegion::parse("x>0.5;z<0.25", [DVec3::ZERO, DVec3::splat(4.0)]).unwrap();
        let placed = placement.region(&region).unwrap();
        for (own, world) in [
            ([3.0, 0.5, 0.5], [1.0, 6.0, 6.0]),
            ([1.0, 0.5, 0.5], [1.0, 2.0, 6.0]),
            ([3.0, 0.5, 1.5], [3.0, 6.0, 6.0]),
        ] {
            let [own, world] = [own, world].map(DVec3::from_array);
            let (linear, shift) = placement.parts();
            assert!((linear * own + shift).distance(world) < 1e-9);
            assert_eq!(placed.removes(world), region.removes(own), "{own}");
        }
        for bad in [
            "",
            "scale 0 rotate 0,0,0 translate 0,0,0",
            "scale 1 rotate 0,0 translate 0,0,0",
            "scale nan rotate 0,0,0 translate 0,0,0",
        ] {
            assert!(bad.parse::<Placement>().is_err(), "{bad}");
        }
    }
}
