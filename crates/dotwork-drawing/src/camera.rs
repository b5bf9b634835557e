//! The camera: where the eye stands, and the projection onto the page that follows.
//!
//! Conventions: azimuth and elevation in degrees; `0,0` is the front; azimuth turns the eye towards +right,
//! elevation towards +up; distances in bounding radii from the centre. Pixel origin top left, y down; depth is the
//! distance along the view axis in object units, growing away from the eye.

use std::fmt;
use std::str::FromStr;

use glam::{DVec3, Vec3};

use crate::page::Page;

/// Vertical field of view of the perspective camera, in degrees.
pub const FIELD_OF_VIEW_DEG: f32 = 30.0;

/// Share of the page's shorter side (inside the margins) that the bounding sphere fills.
pub const FIT: f32 = 0.9;

/// Which axis of the data points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// +x up, +z right, the front eye on +y.
    X,
    /// +y up, +x right, the front eye on +z.
    #[default]
    Y,
    /// +z up, +x right, the front eye on −y.
    Z,
    /// As [`UpAxis::X`], turned by half a turn before the front eye: −x up.
    NegX,
    /// As [`UpAxis::Y`], turned by half a turn before the front eye: −y up.
    NegY,
    /// As [`UpAxis::Z`], turned by half a turn before the front eye: −z up, as in scans that begin at the crown.
    NegZ,
}

/// The axes by name.
const UP_AXES: [(UpAxis, &str); 6] = [
    (UpAxis::X, "x"),
    (UpAxis::Y, "y"),
    (UpAxis::Z, "z"),
    (UpAxis::NegX, "-x"),
    (UpAxis::NegY, "-y"),
    (UpAxis::NegZ, "-z"),
];

impl UpAxis {
    /// The right, up and front (towards the front eye) axes of the data.
    pub fn axes(self) -> [Vec3; 3] {
        match self {
            UpAxis::X => [Vec3::Z, Vec3::X, Vec3::Y],
            UpAxis::Y => [Vec3::X, Vec3::Y, Vec3::Z],
            UpAxis::Z => [Vec3::X, Vec3::Z, Vec3::NEG_Y],
            UpAxis::NegX => [Vec3::NEG_Z, Vec3::NEG_X, Vec3::Y],
            UpAxis::NegY => [Vec3::NEG_X, Vec3::NEG_Y, Vec3::Z],
            UpAxis::NegZ => [Vec3::NEG_X, Vec3::NEG_Z, Vec3::NEG_Y],
        }
    }
}

impl FromStr for UpAxis {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let named = UP_AXES.iter().find(|(_, name)| *name == s);
        named
            .map(|(axis, _)| *axis)
            .ok_or_else(|| format!("'{s}' is not an axis; write x, y, z, -x, -y or -z"))
    }
}

impl fmt::Display for UpAxis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = UP_AXES.iter().find(|(axis, _)| axis == self);
        f.write_str(named.map_or("", |(_, name)| name))
    }
}

/// Where the eye stands, before the object and the page are known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Azimuth in degrees; positive turns the eye towards the data's right.
    pub azimuth: f32,
    /// Elevation in degrees, −90…90; positive raises the eye.
    pub elevation: f32,
    /// Distance of the eye in bounding radii from the centre; `None` fits the bounding sphere to the page.
    pub distance: Option<f32>,
    /// Parallel projection instead of perspective.
    pub ortho: bool,
    /// Scales the image plane about the page centre, after fitting.
    pub zoom: f32,
    /// Which axis points up.
    pub up: UpAxis,
}

impl Default for Camera {
    /// Azimuth 20°, elevation 15°, perspective, fitted.
    fn default() -> Self {
        Camera { azimuth: 20.0, elevation: 15.0, distance: None, ortho: false, zoom: 1.0, up: UpAxis::Y }
    }
}

impl Camera {
    /// As [`Camera::set_direction`] for the patient's space (+x left, +y posterior, +z superior, z up): takes
    /// `anterior posterior superior inferior` too, and `left` and `right` are the patient's.
    ///
    /// # Errors
    /// As [`Camera::set_direction`].
    pub fn set_patient_direction(&mut self, s: &str) -> Result<(), String> {
        self.set_direction(match s {
            "anterior" => "front",
            "posterior" => "back",
            "superior" => "top",
            "inferior" => "bottom",
            // The eye on the patient's left is on +x.
            "left" => "right",
            "right" => "left",
            _ => s,
        })
    }

    /// Reads `AZ,EL[,DIST]` or a name (`front back left right top bottom`; `left`: the eye on the data's left) into
    /// this camera's direction and distance.
    ///
    /// # Errors
    /// Says what is understood.
    pub fn set_direction(&mut self, s: &str) -> Result<(), String> {
        let named = match s {
            "front" => Some((0.0, 0.0)),
            "back" => Some((180.0, 0.0)),
            "left" => Some((-90.0, 0.0)),
            "right" => Some((90.0, 0.0)),
            "top" => Some((0.0, 90.0)),
            "bottom" => Some((0.0, -90.0)),
            _ => None,
        };
        if let Some((azimuth, elevation)) = named {
            (self.azimuth, self.elevation, self.distance) = (azimuth, elevation, None);
            return Ok(());
        }
        let error = || {
            format!(
                "'{s}' is not a camera; write AZ,EL or AZ,EL,DIST in degrees and bounding radii \
                 (for example 20,15), or front, back, left, right, top, bottom"
            )
        };
        let numbers = parse_numbers(s).ok_or_else(error)?;
        let (azimuth, elevation, distance) = match numbers[..] {
            [a, e] => (a, e, None),
            [a, e, d] => (a, e, Some(d)),
            _ => return Err(error()),
        };
        if !(-90.0..=90.0).contains(&elevation) {
            return Err(format!("elevation {elevation} is outside -90 to 90 degrees"));
        }
        if let Some(d) = distance
            && !(d > 1.0 && d <= 1e6)
        {
            return Err(format!(
                "distance {d} is not between 1 (the bounding sphere's surface) and 1e6 bounding radii"
            ));
        }
        (self.azimuth, self.elevation, self.distance) = (azimuth, elevation, distance);
        Ok(())
    }

    /// Turns the eye to this direction from the object, a unit vector: azimuth and elevation in degrees.
    pub fn face(&mut self, direction: Vec3) {
        let [x, y, z] = self.up.axes();
        let (right, up, front) = (direction.dot(x), direction.dot(y), direction.dot(z));
        self.azimuth = if up.abs() > 0.99999 { 0.0 } else { right.atan2(front).to_degrees() };
        self.elevation = up.clamp(-1.0, 1.0).asin().to_degrees();
    }

    /// Turns as far as flat sides with these unit normals ask for, so that each is seen: as it stands where they face
    /// the eye already, towards them all where that is possible, and not at all where two are opposite.
    pub fn turn_towards(&mut self, sides: &[Vec3]) {
        /// Cosine at which a side is seen well enough.
        const WELL: f32 = 0.35;
        let [x, y, z] = self.up.axes();
        let (sa, ca) = sin_cos_deg(self.azimuth);
        let (se, ce) = sin_cos_deg(self.elevation);
        let back = (x * sa + z * ca) * ce + y * se;
        let seen = |from: Vec3| sides.iter().all(|side| side.dot(from) > WELL);
        let sum: Vec3 = sides.iter().sum();
        // From above or below a form is less itself than from the side.
        let sum = sum - y * (0.35 * sum.dot(y));
        let towards = |k: i32| (back + sum * (0.15 * k as f32)).normalize_or(back);
        if seen(back) {
            return;
        }
        let Some(direction) = (1..40).map(towards).find(|&d| seen(d)) else { return };
        self.face(direction);
        (self.azimuth, self.elevation) = (self.azimuth.round(), self.elevation.round());
    }

    /// The view of a bounding sphere on a page.
    ///
    /// With `distance: None` the sphere's outline fills [`FIT`] of the page's shorter side inside the margins; with a
    /// distance the field of view stays [`FIELD_OF_VIEW_DEG`] vertically and the object grows as the eye comes near.
    pub fn view(&self, center: Vec3, radius: f32, page: &Page) -> View {
        let [x, y, z] = self.up.axes();
        let (sa, ca) = sin_cos_deg(self.azimuth);
        let (se, ce) = sin_cos_deg(self.elevation);
        // At ±90° elevation `right` depends on the azimuth alone, which is the limit from below.
        let right = x * ca - z * sa;
        let back = (x * sa + z * ca) * ce + y * se;
        let up = y * ce - (x * sa + z * ca) * se;
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let half_fit = 0.5 * FIT * page.short_side_px();
        let (cx, cy) = page.center_px();
        // The vertical field of view spans the page's height.
        let tan_half = (0.5 * FIELD_OF_VIEW_DEG).to_radians().tan();
        let focal_px = 0.5 * page.height as f32 / tan_half;
        let distance = match self.distance {
            Some(d) => d * radius,
            // Seen from distance D a sphere of radius R has the outline tan(asin(R/D)) on the unit image plane.
            None => radius / (half_fit / focal_px).atan().sin(),
        };
        let projection = if self.ortho {
            Projection::Parallel { px_per_unit: half_fit / radius * self.zoom }
        } else {
            Projection::Perspective { focal_px: focal_px * self.zoom }
        };
        View { right, up, back, eye: center + back * distance, center, radius, distance, projection, cx, cy }
    }
}

/// An eye that a file has placed, rather than angles about the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standpoint {
    /// Where the eye is, object units, in the world.
    pub eye: DVec3,
    /// Unit vector from what it sees towards the eye.
    pub back: Vec3,
    /// Unit vector up the page, at right angles to `back`.
    pub up: Vec3,
    /// What it sees of the world.
    pub lens: Lens,
}

/// How much an eye sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Perspective: the tangent of half the vertical field of view.
    Perspective(f32),
    /// Parallel projection: half the height of what is seen, object units.
    Parallel(f32),
}

impl Standpoint {
    /// The view from here of a bounding sphere on a page, whose height the lens fills; the image is scaled by `zoom`
    /// about the page centre. The sphere and the view are relative to `origin`.
    pub fn view(&self, origin: DVec3, (center, radius): (Vec3, f32), page: &Page, zoom: f32) -> View {
        let Standpoint { back, up, lens, .. } = *self;
        let eye = (self.eye - origin).as_vec3();
        let half_height = 0.5 * page.height as f32 * zoom;
        let projection = match lens {
            Lens::Perspective(tangent) => Projection::Perspective { focal_px: half_height / tangent },
            Lens::Parallel(half) => Projection::Parallel { px_per_unit: half_height / half },
        };
        let (cx, cy) = page.center_px();
        // Depths count from the plane of the eye; where the eye has passed the centre, from just before it.
        let distance = (eye - center).dot(back).max(0.01 * radius);
        View { right: up.cross(back), up, back, eye, center, radius, distance, projection, cx, cy }
    }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90°.
fn sin_cos_deg(deg: f32) -> (f32, f32) {
    let r = deg.rem_euclid(360.0);
    match r {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => {
            let (s, c) = f64::from(deg).to_radians().sin_cos();
            (s as f32, c as f32)
        }
    }
}

/// Comma-separated finite numbers, or `None`.
pub(crate) fn parse_numbers(s: &str) -> Option<Vec<f32>> {
    s.split(',').map(|t| t.trim().parse::<f32>().ok().filter(|v| v.is_finite())).collect()
}

/// Perspective or parallel, with its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// `x_px = cx + focal_px · x / depth`.
    Perspective {
        /// Pixels on the page for one object unit at depth 1.
        focal_px: f32,
    },
    /// `x_px = cx + px_per_unit · x`.
    Parallel {
        /// Pixels on the page for one object unit at any depth.
        px_per_unit: f32,
    },
}

/// A camera that has met its object and its page: everything needed to project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Unit vector to the right of the page, in object space.
    pub right: Vec3,
    /// Unit vector up the page, in object space.
    pub up: Vec3,
    /// Unit vector from the page towards the eye, in object space.
    pub back: Vec3,
    /// The eye, in object space.
    pub eye: Vec3,
    /// Centre of the bounding sphere.
    pub center: Vec3,
    /// Radius of the bounding sphere, object units.
    pub radius: f32,
    /// Distance of the eye from the centre, object units.
    pub distance: f32,
    /// The projection.
    pub projection: Projection,
    /// Page centre, pixels from the left.
    pub cx: f32,
    /// Page centre, pixels from the top.
    pub cy: f32,
}

impl View {
    /// Pixels an object unit covers at `depth`, on a plane that faces the eye.
    #[inline]
    pub fn px_per_unit(&self, depth: f32) -> f32 {
        match self.projection {
            Projection::Perspective { focal_px } => focal_px / depth,
            Projection::Parallel { px_per_unit } => px_per_unit,
        }
    }

    /// Depth of a point: its distance along the view axis from the eye plane, object units.
    #[inline]
    pub fn depth(&self, p: Vec3) -> f32 {
        (self.eye - p).dot(self.back)
    }

    /// Projects a point: x and y in pixels and the depth in object units. Under perspective a point with depth ≤ 0
    /// lies behind the eye and its pixel is meaningless.
    #[inline]
    pub fn project(&self, p: Vec3) -> (f32, f32, f32) {
        let v = p - self.eye;
        let depth = -v.dot(self.back);
        let s = self.px_per_unit(depth);
        (self.cx + v.dot(self.right) * s, self.cy - v.dot(self.up) * s, depth)
    }

    /// Unit vector from a point to the eye.
    #[inline]
    pub fn to_eye(&self, p: Vec3) -> Vec3 {
        match self.projection {
            Projection::Perspective { .. } => (self.eye - p).normalize(),
            Projection::Parallel { .. } => self.back,
        }
    }

    /// True for parallel projection.
    pub fn is_parallel(&self) -> bool {
        matches!(self.projection, Projection::Parallel { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(direction: &str, ortho: bool, up: UpAxis) -> Camera {
        let mut c = Camera { ortho, up, ..Camera::default() };
        c.set_direction(direction).unwrap();
        c
    }

    #[test]
    fn front_views_follow_the_conventions() {
        let page = Page::default();
        // (up axis, where the eye is, what is right, what is up)
        for (up, back, right, upward) in [
            (UpAxis::Y, Vec3::Z, Vec3::X, Vec3::Y),
            (UpAxis::Z, Vec3::NEG_Y, Vec3::X, Vec3::Z),
            (UpAxis::X, Vec3::Y, Vec3::Z, Vec3::X),
            (UpAxis::NegX, Vec3::Y, Vec3::NEG_Z, Vec3::NEG_X),
            (UpAxis::NegY, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y),
            (UpAxis::NegZ, Vec3::NEG_Y, Vec3::NEG_X, Vec3::NEG_Z),
        ] {
            assert_eq!(up.to_string().parse(), Ok(up));
            let v = camera("0,0", false, up).view(Vec3::ZERO, 1.0, &page);
            assert_eq!((v.back, v.right, v.up), (back, right, upward));
            assert!((v.right.cross(v.up) - v.back).length() < 1e-6, "right-handed");
        }
        let v = camera("left", false, UpAxis::Y).view(Vec3::ZERO, 1.0, &page);
        assert_eq!(v.back, Vec3::NEG_X);
        let v = camera("top", false, UpAxis::Y).view(Vec3::ZERO, 1.0, &page);
        assert_eq!((v.back, v.right, v.up), (Vec3::Y, Vec3::X, Vec3::NEG_Z));
        let near = camera("0,89.99", false, UpAxis::Y).view(Vec3::ZERO, 1.0, &page);
        assert!((near.up - v.up).length() < 1e-3, "the top view is the limit from below");
        let v = camera("90,0", false, UpAxis::Y).view(Vec3::ZERO, 1.0, &page);
        assert_eq!(v.back, Vec3::X, "azimuth turns the eye towards +x");
    }

    #[test]
    fn the_bounding_sphere_fills_the_page() {
        for (w, h) in [(1000, 1000), (1600, 1000), (1000, 1600)] {
            let page = Page::pixels(w, h).unwrap();
            for ortho in [false, true] {
                let v = camera("33,21", ortho, UpAxis::Y).view(Vec3::new(1.0, 2.0, 3.0), 5.0, &page);
                // The outline of a sphere is widest where the line of sight touches it.
                let (mut low, mut high) = (f32::MAX, f32::MIN);
                for i in 0..2000 {
                    let a = i as f32 * std::f32::consts::TAU / 2000.0;
                    let p = v.center + 5.0 * (v.up * a.sin() + v.back * a.cos());
                    let (_, y, _) = v.project(p);
                    low = low.min(y);
                    high = high.max(y);
                }
                assert!((high - low - 900.0).abs() < 1.0, "{w}x{h} ortho {ortho}: {}", high - low);
            }
        }
    }

    #[test]
    fn projection_is_right_handed_with_y_down() {
        let v = camera("0,0", true, UpAxis::Y).view(Vec3::ZERO, 1.0, &Page::default());
        let (x, y, depth) = v.project(Vec3::new(0.5, 0.5, 0.5));
        assert!(x > v.cx && y < v.cy);
        assert!((depth - (v.distance - 0.5)).abs() < 1e-5);
    }

    #[test]
    fn sides_that_are_turned_towards_are_seen() {
        let turned = |up: UpAxis, sides: &[Vec3]| {
            let mut camera = Camera { azimuth: 0.0, elevation: 0.0, up, ..Camera::default() };
            camera.turn_towards(sides);
            camera
        };
        for up in [UpAxis::Y, UpAxis::Z, UpAxis::NegX] {
            let [x, y, z] = up.axes();
            for sides in [&[x][..], &[-x, y], &[x, y, z], &[-z], &[-y], &[(x - z).normalize(), y]] {
                let camera = turned(up, sides);
                let back = camera.view(Vec3::ZERO, 1.0, &Page::default()).back;
                assert!(sides.iter().all(|s| s.dot(back) > 0.33), "{sides:?}: {camera:?}");
            }
            // What faces the eye already stays, and so does what cannot be seen at once.
            for sides in [&[z][..], &[x, -x], &[]] {
                assert_eq!(turned(up, sides), turned(up, &[]), "{sides:?}");
            }
        }
        let quarter = turned(UpAxis::Z, &[Vec3::X, Vec3::Z]);
        assert!(quarter.azimuth > 20.0 && quarter.azimuth < 50.0 && quarter.elevation > 15.0, "{quarter:?}");
    }

    #[test]
    fn left_and_right_are_the_patients() {
        let page = Page::default();
        for (name, eye) in [
            ("anterior", Vec3::NEG_Y),
            ("posterior", Vec3::Y),
            ("left", Vec3::X),
            ("right", Vec3::NEG_X),
            ("superior", Vec3::Z),
            ("inferior", Vec3::NEG_Z),
            ("90,0", Vec3::X),
        ] {
            let mut camera = Camera { up: UpAxis::Z, ..Camera::default() };
            camera.set_patient_direction(name).unwrap();
            let view = camera.view(Vec3::ZERO, 1.0, &page);
            assert!((view.back - eye).length() < 1e-6, "{name}");
        }
        assert!(Camera::default().set_direction("anterior").is_err());
    }

    #[test]
    fn bad_cameras_are_refused() {
        for bad in ["", "1", "1,2,3,4", "a,b", "0,91", "0,0,0", "0,0,-3", "nan,0", "0,0,1"] {
            assert!(Camera::default().set_direction(bad).is_err(), "{bad}");
        }
    }
}
