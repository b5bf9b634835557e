//! Colour spaces in which colours are mixed: HLS and OKLCH, both cylinders of a hue round an axis of greys.
//!
//! HLS (hue, lightness, saturation) is the model in which Lu et al. 2003, section 5.7, blend warm and cool colours; it
//! is a change of coordinates of the encoded sRGB cube (Foley et al., *Computer Graphics: Principles and Practice*,
//! 13.3.5), and equal steps in it are not equal to the eye. OKLCH is the cylinder of OKLab (Ottosson 2020, *A perceptual
//! color space for image processing*), in which they nearly are.

use std::fmt;
use std::str::FromStr;

use crate::color::{Color, linear_to_srgb};

/// A space in which colours are mixed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColorSpace {
    /// Hue, lightness and saturation of encoded sRGB.
    Hls,
    /// Lightness, chroma and hue of OKLab.
    #[default]
    Oklch,
}

impl ColorSpace {
    /// The words that name the spaces.
    pub const WORDS: &'static [&'static str] = &["hls", "oklch"];
}

impl fmt::Display for ColorSpace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ColorSpace::Hls => "hls",
            ColorSpace::Oklch => "oklch",
        })
    }
}

impl FromStr for ColorSpace {
    type Err = String;

    /// Reads `hls` or `oklch`.
    fn from_str(s: &str) -> Result<ColorSpace, String> {
        match s {
            "hls" => Ok(ColorSpace::Hls),
            "oklch" => Ok(ColorSpace::Oklch),
            _ => Err(format!("'{s}' is no colour space; write hls or oklch")),
        }
    }
}

/// A colour as hue, lightness and saturation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hls {
    /// Degrees, 0…360, red at 0 and green at 120; 0 for greys.
    pub hue: f64,
    /// 0 black … 1 white; the mean of the largest and the smallest channel.
    pub lightness: f64,
    /// 0 grey … 1 as vivid as the lightness allows.
    pub saturation: f64,
}

/// A colour as perceived lightness, chroma and hue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Oklch {
    /// 0 black … 1 white.
    pub lightness: f64,
    /// Distance from grey, 0…0.33 in sRGB.
    pub chroma: f64,
    /// Degrees, 0…360, red near 29; of no meaning for greys.
    pub hue: f64,
}

impl From<Color> for Hls {
    fn from(color: Color) -> Hls {
        let [r, g, b] = [color.r, color.g, color.b].map(|c| f64::from(c) / 255.0);
        let (most, least) = (r.max(g).max(b), r.min(g).min(b));
        let (sum, range) = (most + least, most - least);
        let lightness = 0.5 * sum;
        if range == 0.0 {
            return Hls { hue: 0.0, lightness, saturation: 0.0 };
        }
        let saturation = range / if lightness <= 0.5 { sum } else { 2.0 - sum };
        let sixth = if r == most {
            (g - b) / range
        } else if g == most {
            2.0 + (b - r) / range
        } else {
            4.0 + (r - g) / range
        };
        Hls { hue: (60.0 * sixth).rem_euclid(360.0), lightness, saturation }
    }
}

impl From<Hls> for Color {
    /// The nearest 8-bit colour; hues repeat every 360 degrees, what lies outside of 0…1 is clamped.
    fn from(hls: Hls) -> Color {
        let (l, s) = (hls.lightness.clamp(0.0, 1.0), hls.saturation.clamp(0.0, 1.0));
        let most = if l <= 0.5 { l * (1.0 + s) } else { l + s - l * s };
        let least = 2.0 * l - most;
        let channel = |shift: f64| {
            let hue = (hls.hue + shift).rem_euclid(360.0);
            let share = match hue {
                ..60.0 => hue / 60.0,
                ..180.0 => 1.0,
                ..240.0 => (240.0 - hue) / 60.0,
                _ => 0.0,
            };
            (255.0 * (least + (most - least) * share)).round() as u8
        };
        Color { r: channel(120.0), g: channel(0.0), b: channel(-120.0) }
    }
}

impl From<Color> for Oklch {
    fn from(color: Color) -> Oklch {
        let [r, g, b] = color.to_linear().map(f64::from);
        let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
        let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
        let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
        let lightness = 0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s;
        let a = 1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s;
        let b = 0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s;
        Oklch { lightness, chroma: a.hypot(b), hue: b.atan2(a).to_degrees().rem_euclid(360.0) }
    }
}

impl Oklch {
    /// Red, green and blue in linear light; outside of 0…1 for colours that sRGB does not have.
    fn to_linear(self) -> [f64; 3] {
        let (sin, cos) = self.hue.to_radians().sin_cos();
        let (a, b) = (self.chroma * cos, self.chroma * sin);
        let l = (self.lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
        let m = (self.lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
        let s = (self.lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
        [
            4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
            -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
            -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
        ]
    }
}

impl From<Oklch> for Color {
    /// The nearest 8-bit colour. What sRGB does not have keeps lightness and hue and loses chroma.
    fn from(color: Oklch) -> Color {
        // As much as rounding to 8 bits hides.
        let inside = |linear: &[f64; 3]| linear.iter().all(|c| (-1e-4..=1.0001).contains(c));
        let color = Oklch { lightness: color.lightness.clamp(0.0, 1.0), ..color };
        let mut linear = color.to_linear();
        if !inside(&linear) {
            let (mut low, mut high) = (0.0, color.chroma);
            for _ in 0..24 {
                let chroma = 0.5 * (low + high);
                let reduced = Oklch { chroma, ..color }.to_linear();
                if inside(&reduced) {
                    (low, linear) = (chroma, reduced);
                } else {
                    high = chroma;
                }
            }
            linear = if low > 0.0 { linear } else { Oklch { chroma: 0.0, ..color }.to_linear() };
        }
        let [r, g, b] = linear.map(|c| linear_to_srgb(c as f32));
        Color { r, g, b }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn color(s: &str) -> Color {
        s.parse().unwrap()
    }

    /// Every fifteenth value of each channel, the ends included.
    fn cube() -> impl Iterator<Item = Color> {
        let steps = || (0..=255u8).step_by(15);
        steps().flat_map(move |r| steps().flat_map(move |g| steps().map(move |b| Color { r, g, b })))
    }

    #[test]
    fn hls_of_known_colours() {
        // Foley et al., and the definitions of CSS Color 4, section 7, for named colours.
        for (name, hue, lightness, saturation) in [
            ("#ff0000", 0.0, 0.5, 1.0),
            ("#ffff00", 60.0, 0.5, 1.0),
            ("#00ff00", 120.0, 0.5, 1.0),
            ("#00ffff", 180.0, 0.5, 1.0),
            ("#0000ff", 240.0, 0.5, 1.0),
            ("#ff00ff", 300.0, 0.5, 1.0),
            ("#ffa500", 38.8235, 0.5, 1.0),
            ("#800000", 0.0, 0.25098, 1.0),
            ("#663399", 270.0, 0.4, 0.5),
            ("#000000", 0.0, 0.0, 0.0),
            ("#ffffff", 0.0, 1.0, 0.0),
            ("#808080", 0.0, 0.50196, 0.0),
        ] {
            let hls = Hls::from(color(name));
            let off = [hls.hue - hue, hls.lightness - lightness, hls.saturation - saturation];
            assert!(off.iter().all(|d| d.abs() < 1e-4), "{name}: {hls:?}");
        }
    }

    #[test]
    fn oklch_of_known_colours() {
        // CSS Color 4 and Ottosson's page give these, to the digits shown.
        for (name, lightness, chroma, hue) in [
            ("#ff0000", 0.62796, 0.25768, Some(29.234)),
            ("#00ff00", 0.86644, 0.29483, Some(142.495)),
            ("#0000ff", 0.45201, 0.31321, Some(264.052)),
            ("#ffff00", 0.96798, 0.21101, Some(109.769)),
            ("#ffffff", 1.0, 0.0, None),
            ("#000000", 0.0, 0.0, None),
            ("#808080", 0.59987, 0.0, None),
        ] {
            let lch = Oklch::from(color(name));
            let hue_off = hue.map_or(0.0, |hue| lch.hue - hue);
            assert!((lch.lightness - lightness).abs() < 1e-4, "{name}: {lch:?}");
            assert!((lch.chroma - chroma).abs() < 1e-4 && hue_off.abs() < 0.02, "{name}: {lch:?}");
        }
    }

    #[test]
    fn colours_survive_both_spaces() {
        for c in cube() {
            assert_eq!(Color::from(Hls::from(c)), c, "{c}");
            assert_eq!(Color::from(Oklch::from(c)), c, "{c}");
        }
    }

    #[test]
    fn colours_that_srgb_lacks_keep_lightness_and_hue() {
        for hue in (0..360).step_by(15).map(f64::from) {
            for lightness in [0.3, 0.5, 0.7, 0.9] {
                let wanted = Oklch { lightness, chroma: 0.5, hue };
                let found = Oklch::from(Color::from(wanted));
                assert!((found.lightness - lightness).abs() < 0.01, "{wanted:?}: {found:?}");
                assert!(found.chroma > 0.02 && found.chroma < 0.34, "{wanted:?}: {found:?}");
                let turn = (found.hue - hue + 180.0).rem_euclid(360.0) - 180.0;
                // A channel step is worth more degrees where chroma is small.
                assert!(turn.abs() * found.chroma < 0.4, "{wanted:?}: {found:?}");
            }
        }
        for (lightness, expected) in [(2.0, Color::WHITE), (-1.0, Color::BLACK)] {
            assert_eq!(Color::from(Oklch { lightness, chroma: 0.1, hue: 30.0 }), expected);
        }
    }

    #[test]
    fn names_read_back() {
        for space in [ColorSpace::Hls, ColorSpace::Oklch] {
            assert_eq!(space.to_string().parse(), Ok(space));
        }
        assert!("rgb".parse::<ColorSpace>().is_err());
    }
}
