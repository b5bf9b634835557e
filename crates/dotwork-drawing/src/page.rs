//! The page: its size in pixels and millimetres, and lengths that hold at every resolution.

use std::fmt;
use std::str::FromStr;

/// The largest page side in pixels; larger requests are refused before anything is allocated.
pub const MAX_SIDE_PX: u32 = 32_768;

/// The largest page area in pixels.
pub const MAX_AREA_PX: u64 = 1 << 29;

/// Millimetres in an inch.
pub const MM_PER_INCH: f32 = 25.4;

/// A page: a raster size, its physical resolution and a margin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Page {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Physical resolution, pixels an inch.
    pub dpi: f32,
    /// Margin on all four sides in pixels: the view is fitted inside it and no dot is drawn in it.
    pub margin_px: f32,
}

impl Default for Page {
    /// 1024 × 1024 pixels at 300 dpi (86.7 mm), no margin.
    fn default() -> Self {
        Page { width: 1024, height: 1024, dpi: 300.0, margin_px: 0.0 }
    }
}

impl Page {
    /// A page of `width` × `height` pixels at 300 dpi.
    ///
    /// # Errors
    /// Says so when a side is 0 or the page exceeds [`MAX_SIDE_PX`] or [`MAX_AREA_PX`].
    pub fn pixels(width: u32, height: u32) -> Result<Page, String> {
        Page { width, height, ..Page::default() }.checked()
    }

    /// A page of `width_mm` × `height_mm` at `dpi` pixels an inch, sides rounded to whole pixels.
    ///
    /// # Errors
    /// As [`Page::pixels`], and for sizes that are not positive and finite.
    pub fn millimetres(width_mm: f32, height_mm: f32, dpi: f32) -> Result<Page, String> {
        if !(width_mm > 0.0 && height_mm > 0.0 && dpi > 0.0 && (width_mm * height_mm * dpi).is_finite()) {
            return Err(format!("a page of {width_mm} x {height_mm} mm at {dpi} dpi cannot be drawn"));
        }
        let px = |mm: f32| (f64::from(mm) * f64::from(dpi) / f64::from(MM_PER_INCH)).round().min(4e9) as u32;
        Page { width: px(width_mm), height: px(height_mm), dpi, margin_px: 0.0 }.checked()
    }

    /// This page if it can be drawn.
    ///
    /// # Errors
    /// Names the limit that is exceeded.
    pub fn checked(self) -> Result<Page, String> {
        let Page { width, height, dpi, margin_px } = self;
        if width == 0 || height == 0 {
            return Err(format!("a page of {width} x {height} pixels has no area"));
        }
        if width > MAX_SIDE_PX || height > MAX_SIDE_PX || u64::from(width) * u64::from(height) > MAX_AREA_PX {
            return Err(format!(
                "a page of {width} x {height} pixels is too large (at most {MAX_SIDE_PX} a side and {MAX_AREA_PX} in all)"
            ));
        }
        if !(dpi.is_finite() && (1.0..=20_000.0).contains(&dpi)) {
            return Err(format!("{dpi} dpi is not a resolution between 1 and 20000"));
        }
        if !(margin_px >= 0.0 && 2.0 * margin_px < width.min(height) as f32) {
            return Err(format!(
                "a margin of {:.1} mm leaves nothing of the page",
                margin_px * self.mm_per_px()
            ));
        }
        Ok(self)
    }

    /// Millimetres a pixel.
    pub fn mm_per_px(&self) -> f32 {
        MM_PER_INCH / self.dpi
    }

    /// The shorter side inside the margins, in pixels.
    pub fn short_side_px(&self) -> f32 {
        self.width.min(self.height) as f32 - 2.0 * self.margin_px
    }

    /// The longer side of the whole page, in pixels.
    pub fn long_side_px(&self) -> u32 {
        self.width.max(self.height)
    }

    /// The centre of the page in pixels, the origin at the top left.
    pub fn center_px(&self) -> (f32, f32) {
        (self.width as f32 * 0.5, self.height as f32 * 0.5)
    }
}

/// Width and height in millimetres of a named paper size (`A5`, `A4-landscape`, …) or of `WxHmm`.
///
/// # Errors
/// Lists what is understood.
pub fn parse_paper_mm(s: &str) -> Result<(f32, f32), String> {
    let error = || {
        format!(
            "'{s}' is not a page; write A0 to A8, Letter, these with -landscape, or a size such as 120x80mm"
        )
    };
    let lower = s.trim().to_ascii_lowercase();
    if let Some(size) = lower.strip_suffix("mm") {
        let (w, h) = size.split_once('x').ok_or_else(error)?;
        let parse = |t: &str| {
            t.trim().trim_end_matches("mm").parse::<f32>().ok().filter(|v| *v > 0.0 && v.is_finite())
        };
        return Ok((parse(w).ok_or_else(error)?, parse(h).ok_or_else(error)?));
    }
    let (name, landscape) = match lower.strip_suffix("-landscape") {
        Some(name) => (name, true),
        None => (lower.strip_suffix("-portrait").unwrap_or(&lower), false),
    };
    let (w, h) = match name {
        "a0" => (841.0, 1189.0),
        "a1" => (594.0, 841.0),
        "a2" => (420.0, 594.0),
        "a3" => (297.0, 420.0),
        "a4" => (210.0, 297.0),
        "a5" => (148.0, 210.0),
        "a6" => (105.0, 148.0),
        "a7" => (74.0, 105.0),
        "a8" => (52.0, 74.0),
        "letter" => (215.9, 279.4),
        _ => return Err(error()),
    };
    Ok(if landscape { (h, w) } else { (w, h) })
}

/// The unit of a [`Length`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Pixels of the page.
    Px,
    /// Millimetres on the page.
    Mm,
    /// Hundredths of the page's shorter side inside the margins: the same picture at every resolution.
    Percent,
}

/// A length on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Length {
    /// The number, in `unit`.
    pub value: f32,
    /// The unit.
    pub unit: Unit,
}

impl Length {
    /// A length in pixels.
    pub const fn px(value: f32) -> Length {
        Length { value, unit: Unit::Px }
    }

    /// A length in millimetres.
    pub const fn mm(value: f32) -> Length {
        Length { value, unit: Unit::Mm }
    }

    /// A length in percent of the page's shorter side.
    pub const fn percent(value: f32) -> Length {
        Length { value, unit: Unit::Percent }
    }

    /// This length in pixels of `page`.
    pub fn to_px(self, page: &Page) -> f32 {
        match self.unit {
            Unit::Px => self.value,
            Unit::Mm => self.value / page.mm_per_px(),
            Unit::Percent => self.value * 0.01 * page.short_side_px(),
        }
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = match self.unit {
            Unit::Px => "px",
            Unit::Mm => "mm",
            Unit::Percent => "%",
        };
        write!(f, "{}{unit}", self.value)
    }
}

impl FromStr for Length {
    type Err = String;

    /// Reads `1.5px`, `0.25mm`, `0.2%`, or a bare number of pixels. The value must be finite and not negative.
    fn from_str(s: &str) -> Result<Self, String> {
        let t = s.trim();
        let (number, unit) = if let Some(n) = t.strip_suffix("px") {
            (n, Unit::Px)
        } else if let Some(n) = t.strip_suffix("mm") {
            (n, Unit::Mm)
        } else if let Some(n) = t.strip_suffix('%') {
            (n, Unit::Percent)
        } else {
            (t, Unit::Px)
        };
        match number.trim().parse::<f32>() {
            Ok(value) if value.is_finite() && value >= 0.0 => Ok(Length { value, unit }),
            _ => Err(format!("'{s}' is not a length; write for example 1.5px, 0.25mm or 0.2%")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_sizes() {
        assert_eq!(parse_paper_mm("A5").unwrap(), (148.0, 210.0));
        assert_eq!(parse_paper_mm("A5-landscape").unwrap(), (210.0, 148.0));
        assert_eq!(parse_paper_mm("120x80mm").unwrap(), (120.0, 80.0));
        for bad in ["A9", "0x10mm", "x", "120x80", "nanxnanmm", "-1x5mm"] {
            assert!(parse_paper_mm(bad).is_err(), "{bad}");
        }
        let page = Page::millimetres(148.0, 210.0, 600.0).unwrap();
        assert_eq!((page.width, page.height), (3496, 4961));
    }

    #[test]
    fn absurd_pages_are_refused() {
        assert!(Page::pixels(0, 5).is_err());
        assert!(Page::pixels(1_000_000, 10).is_err());
        assert!(Page::pixels(32_000, 32_000).is_err());
        assert!(Page::millimetres(1e9, 1e9, 600.0).is_err());
        assert!(Page { margin_px: 600.0, ..Page::default() }.checked().is_err());
    }

    #[test]
    fn lengths_in_every_unit() {
        let page = Page { dpi: 254.0, ..Page::pixels(2000, 1000).unwrap() };
        for (text, px) in [("1.5px", 1.5), ("2", 2.0), ("0.25mm", 2.5), ("0.2%", 2.0)] {
            let length: Length = text.parse().unwrap();
            assert!((length.to_px(&page) - px).abs() < 1e-5, "{text}");
        }
        assert!("-1px".parse::<Length>().is_err());
        assert!("nan".parse::<Length>().is_err());
    }
}
