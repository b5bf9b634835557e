//! Colours: 8-bit sRGB outside, linear light inside.

use std::fmt;
use std::str::FromStr;

/// An opaque colour, 8-bit sRGB; black by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Color {
    /// Red, 0…255.
    pub r: u8,
    /// Green, 0…255.
    pub g: u8,
    /// Blue, 0…255.
    pub b: u8,
}

impl Color {
    /// Black ink.
    pub const BLACK: Color = Color { r: 0, g: 0, b: 0 };
    /// White paper.
    pub const WHITE: Color = Color { r: 255, g: 255, b: 255 };

    /// The three channels in linear light, 0…1.
    pub fn to_linear(self) -> [f32; 3] {
        [self.r, self.g, self.b].map(srgb_to_linear)
    }

    /// True if the three channels agree.
    pub fn is_grey(self) -> bool {
        self.r == self.g && self.g == self.b
    }
}

/// Decodes one sRGB channel to linear light (IEC 61966-2-1).
pub fn srgb_to_linear(c: u8) -> f32 {
    let c = f32::from(c) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// Encodes linear light (clamped to 0…1) as one sRGB channel, rounded to nearest.
pub fn linear_to_srgb(c: f32) -> u8 {
    let c = c.clamp(0.0, 1.0);
    let s = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (s * 255.0 + 0.5) as u8
}

impl fmt::Display for Color {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{:02x}{:02x}{:02x}", self.r, self.g, self.b)
    }
}

impl FromStr for Color {
    type Err = String;

    /// Reads `#rrggbb`, `#rgb` (with or without the `#`), `black` or `white`.
    fn from_str(s: &str) -> Result<Self, String> {
        let error = || format!("'{s}' is not a colour; write #rrggbb, for example #1a2b3c");
        match s {
            "black" => return Ok(Color::BLACK),
            "white" => return Ok(Color::WHITE),
            _ => {}
        }
        let hex = s.strip_prefix('#').unwrap_or(s);
        if !hex.bytes().all(|b| b.is_ascii_hexdigit()) {
            return Err(error());
        }
        let n = u32::from_str_radix(hex, 16).map_err(|_| error())?;
        match hex.len() {
            6 => Ok(Color { r: (n >> 16) as u8, g: (n >> 8) as u8, b: n as u8 }),
            3 => {
                let digit = |shift: u32| ((n >> shift) & 15) as u8 * 17;
                Ok(Color { r: digit(8), g: digit(4), b: digit(0) })
            }
            _ => Err(error()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_round_trips() {
        for c in 0..=255 {
            assert_eq!(linear_to_srgb(srgb_to_linear(c)), c);
        }
    }

    #[test]
    fn parses_and_prints() {
        assert_eq!("#1a2b3c".parse::<Color>().unwrap().to_string(), "#1a2b3c");
        assert_eq!("fff".parse::<Color>().unwrap(), Color::WHITE);
        assert_eq!("black".parse::<Color>().unwrap(), Color::BLACK);
        for bad in ["", "#12345", "#1234567", "red?", "#gg0000", "+12345"] {
            assert!(bad.parse::<Color>().is_err(), "{bad}");
        }
    }
}
