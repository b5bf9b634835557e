//! The light: one direction, relative to the viewer or fixed to the object.

use std::str::FromStr;

use glam::Vec3;

use crate::camera::{UpAxis, View, parse_numbers};

/// What the light's angles are measured against.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightFrame {
    /// The viewer: the light turns with the eye.
    #[default]
    Viewer,
    /// The object's front view (camera `0,0`): the light stays on the object.
    Object,
}

impl FromStr for LightFrame {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "viewer" => Ok(LightFrame::Viewer),
            "object" => Ok(LightFrame::Object),
            _ => Err(format!("'{s}' is not a light frame; write viewer or object")),
        }
    }
}

/// A distant light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Degrees to the right of the eye (or of the front view); negative from the left.
    pub azimuth: f32,
    /// Degrees above.
    pub elevation: f32,
    /// What the angles are measured against.
    pub frame: LightFrame,
}

impl Default for Light {
    /// From the upper left of the viewer: −40°, 40°.
    fn default() -> Self {
        Light { azimuth: -40.0, elevation: 40.0, frame: LightFrame::Viewer }
    }
}

impl Light {
    /// Reads `AZ,EL` in degrees; the frame becomes the viewer's.
    ///
    /// # Errors
    /// Says what is understood.
    pub fn parse(s: &str) -> Result<Light, String> {
        match parse_numbers(s).as_deref() {
            Some(&[azimuth, elevation]) => Ok(Light { azimuth, elevation, frame: LightFrame::Viewer }),
            _ => Err(format!("'{s}' is not a light; write AZ,EL in degrees, for example --light=-40,40")),
        }
    }

    /// Unit vector from the object towards the light, in object space.
    pub fn direction(&self, view: &View, up: UpAxis) -> Vec3 {
        let [right, above, front] = match self.frame {
            LightFrame::Viewer => [view.right, view.up, view.back],
            LightFrame::Object => up.axes(),
        };
        let (sa, ca) = self.azimuth.to_radians().sin_cos();
        let (se, ce) = self.elevation.to_radians().sin_cos();
        (right * (sa * ce) + above * se + front * (ca * ce)).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Page};

    #[test]
    fn zero_is_the_eye_and_positive_is_right_and_above() {
        let view = Camera::default().view(Vec3::ZERO, 1.0, &Page::default());
        let at = |s: &str| Light::parse(s).unwrap().direction(&view, UpAxis::Y);
        assert!((at("0,0") - view.back).length() < 1e-6);
        assert!((at("90,0") - view.right).length() < 1e-6);
        assert!((at("0,90") - view.up).length() < 1e-6);
        let fixed = Light { azimuth: 90.0, elevation: 0.0, frame: LightFrame::Object };
        assert!((fixed.direction(&view, UpAxis::Z) - Vec3::X).length() < 1e-6);
        assert!(Light::parse("1").is_err() && Light::parse("1,x").is_err());
    }
}
