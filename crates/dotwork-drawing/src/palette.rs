//! Palettes: colours along a number, and the mixing of two.
//!
//! Lu et al. 2003, section 5.7, blend colours through a palette in HLS. Colours are mixed along the shorter way round
//! the hue; a grey has none and takes that of the other.

use std::fmt;

use crate::color::Color;
use crate::color_space::{ColorSpace, Hls, Oklch};

/// Below this chroma an OKLCH hue is rounding: greys reach 1e-4, the nearest colours to grey 1e-3.
const GREY: f64 = 5e-4;

/// The colour that lies `t` (0…1, clamped) of the way from `a` to `b` in `space`.
pub fn mix(a: Color, b: Color, t: f64, space: ColorSpace) -> Color {
    if t.is_nan() || t <= 0.0 || a == b {
        return a;
    }
    if t >= 1.0 {
        return b;
    }
    let between = |a: f64, b: f64| a + (b - a) * t;
    match space {
        ColorSpace::Hls => {
            let (a, b) = (Hls::from(a), Hls::from(b));
            let hue = hue_between([a.hue, b.hue], [a.saturation == 0.0, b.saturation == 0.0], t);
            let (lightness, saturation) =
                (between(a.lightness, b.lightness), between(a.saturation, b.saturation));
            Hls { hue, lightness, saturation }.into()
        }
        ColorSpace::Oklch => {
            let (a, b) = (Oklch::from(a), Oklch::from(b));
            let hue = hue_between([a.hue, b.hue], [a.chroma < GREY, b.chroma < GREY], t);
            let (lightness, chroma) = (between(a.lightness, b.lightness), between(a.chroma, b.chroma));
            Oklch { lightness, chroma, hue }.into()
        }
    }
}

/// The hue between two, degrees, by the shorter way; the other's where one is a grey.
fn hue_between([a, b]: [f64; 2], grey: [bool; 2], t: f64) -> f64 {
    match grey {
        [true, _] => b,
        [_, true] => a,
        _ => {
            // -180 up to 180.
            let turn = (b - a + 180.0).rem_euclid(360.0) - 180.0;
            a + turn * t
        }
    }
}

/// From 2 to 64 colours, evenly spaced along a number 0…1.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Palette {
    colors: Vec<Color>,
}

impl Palette {
    /// Most colours that a palette has.
    pub const MOST: usize = 64;

    /// A palette of these colours.
    ///
    /// # Errors
    /// Fewer than 2 colours, or more than [`Palette::MOST`].
    pub fn new(colors: Vec<Color>) -> Result<Palette, String> {
        match colors.len() {
            2..=Palette::MOST => Ok(Palette { colors }),
            n => Err(format!("a palette has from 2 to {} colours, not {n}", Palette::MOST)),
        }
    }

    /// Its colours.
    pub fn colors(&self) -> &[Color] {
        &self.colors
    }

    /// The colour at `u` (0…1, clamped; NaN is 0), mixed in `space` from the two entries next to it.
    pub fn at(&self, u: f64, space: ColorSpace) -> Color {
        // Not so for what is no number.
        let u = if u > 0.0 { u.min(1.0) } else { 0.0 };
        let place = u * (self.colors.len() - 1) as f64;
        let k = (place as usize).min(self.colors.len() - 2);
        mix(self.colors[k], self.colors[k + 1], place - k as f64, space)
    }
}

impl fmt::Display for Palette {
    /// The colours between commas.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, color) in self.colors.iter().enumerate() {
            write!(f, "{}{color}", if k == 0 { "" } else { "," })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACES: [ColorSpace; 2] = [ColorSpace::Hls, ColorSpace::Oklch];

    fn color(s: &str) -> Color {
        s.parse().unwrap()
    }

    #[test]
    fn ends_and_entries_are_exact() {
        let colors = ["#d95f02", "#010203", "#ffffff", "#2b4c9b"].map(color);
        let palette = Palette::new(colors.to_vec()).unwrap();
        for space in SPACES {
            for (k, c) in colors.iter().enumerate() {
                assert_eq!(palette.at(k as f64 / 3.0, space), *c);
            }
            for (u, c) in [(-1.0, 0), (f64::NAN, 0), (2.0, 3), (f64::INFINITY, 3)] {
                assert_eq!(palette.at(u, space), colors[c]);
            }
        }
    }

    #[test]
    fn hues_go_the_shorter_way() {
        // In HLS red to blue is 120 degrees through magenta, red to green 120 through yellow.
        assert_eq!(mix(color("#f00"), color("#00f"), 0.5, ColorSpace::Hls), color("#ff00ff"));
        assert_eq!(mix(color("#f00"), color("#0f0"), 0.5, ColorSpace::Hls), color("#ffff00"));
        // From 350 to 10 degrees over 0.
        let (a, b) = (color("#ff002b"), color("#ff2b00"));
        assert_eq!(mix(a, b, 0.5, ColorSpace::Hls), color("#ff0000"));
        for (a, b) in [("#d95f02", "#2b4c9b"), ("#00a050", "#ff8080"), ("#0000ff", "#ffff00")] {
            for t in [0.2, 0.5, 0.8] {
                let between = Oklch::from(mix(color(a), color(b), t, ColorSpace::Oklch));
                let [from, to] = [a, b].map(|c| Oklch::from(color(c)));
                let turn = |x: f64, y: f64| (y - x + 180.0).rem_euclid(360.0) - 180.0;
                let whole = turn(from.hue, to.hue);
                assert!(whole.abs() <= 180.0);
                assert!((turn(from.hue, between.hue) - t * whole).abs() < 4.0, "{a} {b} {t}: {between:?}");
                let lightness = from.lightness + t * (to.lightness - from.lightness);
                assert!((between.lightness - lightness).abs() < 0.01, "{a} {b} {t}: {between:?}");
            }
        }
    }

    #[test]
    fn greys_have_no_hue_of_their_own() {
        for space in SPACES {
            let middle = mix(Color::BLACK, Color::WHITE, 0.5, space);
            assert!(middle.is_grey(), "{space}: {middle}");
            // A vivid blue on its way to white stays blue.
            let pale = mix(color("#2040c0"), Color::WHITE, 0.6, space);
            let hue = |c| if space == ColorSpace::Hls { Hls::from(c).hue } else { Oklch::from(c).hue };
            assert!((hue(pale) - hue(color("#2040c0"))).abs() < 3.0, "{space}: {pale}");
            assert_eq!(mix(Color::WHITE, color("#2040c0"), 0.4, space), pale);
        }
    }

    #[test]
    fn sizes_are_bounded() {
        for n in [0, 1, 65, 1000] {
            assert!(Palette::new(vec![Color::BLACK; n]).unwrap_err().contains(&n.to_string()));
        }
        let two = Palette::new(vec![Color::BLACK, color("#ff8000")]).unwrap();
        assert_eq!((two.to_string(), two.colors().len()), ("#000000,#ff8000".into(), 2));
    }
}
