//! Scale bars: a line of known length and the words for it, drawn as strokes like everything else.

use std::fmt;
use std::str::FromStr;

use dotwork_drawing::lettering::{text_width, write_text};
use dotwork_drawing::{Page, Projection, StrokeKind, Strokes, View};
use dotwork_volume::Unit;

/// The longest bar that is chosen, as a share of the page's width inside the margins.
const LONGEST: f64 = 0.25;

/// Distance from the margin, height of the digits, and width of the line, as shares of the page's shorter side.
const INSET: f32 = 0.03;
const TEXT: f32 = 0.022;
const LINE: f32 = 0.003;

/// A scale bar that is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScaleBar {
    /// Its length in `unit`; `None` takes a round one of up to a quarter of the page.
    pub length: Option<f64>,
    /// The unit of `length`, which is also taken as the objects' where their file gives none. Unknown: the objects'.
    pub unit: Unit,
}

impl FromStr for ScaleBar {
    type Err = String;

    /// Reads `auto`, a length in the objects' own units (`50`), or one with a unit (`20mm`, `5um`, `1.5 m`).
    fn from_str(s: &str) -> Result<Self, String> {
        let s = s.trim();
        if s == "auto" {
            return Ok(ScaleBar::default());
        }
        let end = s.trim_end_matches(|c: char| c.is_alphabetic()).len();
        let (number, symbol) = s.split_at(end);
        let unit = if symbol.is_empty() { Some((Unit::Unknown, 1.0)) } else { unit_of(symbol) };
        let length = number.trim().parse::<f64>().ok().filter(|v| *v > 0.0 && v.is_finite());
        match (length, unit) {
            (Some(length), Some((unit, factor))) => Ok(ScaleBar { length: Some(length * factor), unit }),
            _ => Err(format!(
                "'{s}' is not a scale bar; write auto, or a length such as 50, 20mm, 100um, 1cm or 2m"
            )),
        }
    }
}

impl fmt::Display for ScaleBar {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.length {
            None => f.write_str("auto"),
            Some(length) if self.unit == Unit::Unknown => write!(f, "{length}"),
            Some(length) => write!(f, "{length}{}", self.unit),
        }
    }
}

/// The unit that a symbol stands for, and how many of it the symbol means.
fn unit_of(symbol: &str) -> Option<(Unit, f64)> {
    Some(match symbol {
        "m" => (Unit::Metre, 1.0),
        "cm" => (Unit::Millimetre, 10.0),
        "mm" => (Unit::Millimetre, 1.0),
        "um" | "µm" | "μm" => (Unit::Micrometre, 1.0),
        "nm" => (Unit::Nanometre, 1.0),
        _ => return None,
    })
}

/// Metres in a unit; nobody's unit counts as one.
fn metres(unit: Unit) -> f64 {
    unit.millimetres().map_or(1.0, |mm| 1e-3 * mm)
}

impl ScaleBar {
    /// The strokes of the bar at the lower left of `page`; `unit` is the objects'.
    ///
    /// # Errors
    /// In perspective, where the scale changes with the depth; a bar that is longer than the page, or too short to be
    /// seen.
    pub fn strokes(&self, view: &View, page: &Page, unit: Unit) -> Result<Strokes, String> {
        let Projection::Parallel { px_per_unit } = view.projection else {
            return Err(
                "a scale bar holds only in a parallel view: in perspective the scale changes with the depth \
                 (add --ortho)"
                    .into(),
            );
        };
        let px_per_unit = f64::from(px_per_unit);
        let short = page.short_side_px();
        let inner = f64::from(page.width as f32 - 2.0 * page.margin_px);
        let own = if unit == Unit::Unknown { self.unit } else { unit };
        let length = match self.length {
            Some(length) if self.unit == Unit::Unknown => length,
            Some(length) => length * metres(self.unit) / metres(own),
            None => round_down(LONGEST * inner / px_per_unit),
        };
        let px = length * px_per_unit;
        let line = LINE * short;
        if !(px.is_finite() && px <= inner - f64::from(2.0 * INSET * short)) {
            return Err(format!("a scale bar of {} does not fit on the page", words(length, own)));
        }
        if px < f64::from(4.0 * line) {
            return Err(format!("a scale bar of {} is too short to be seen", words(length, own)));
        }
        let label = words(length, own);
        let x = page.margin_px + INSET * short;
        let y = page.height as f32 - page.margin_px - INSET * short;
        let px = px as f32;
        let tick = 0.4 * TEXT * short;
        let mut strokes = Strokes::default();
        let bar = [[x, y - tick], [x, y], [x + px, y], [x + px, y - tick]];
        strokes.push_line(StrokeKind::Annotation, 0, line, bar);
        let height = TEXT * short;
        // Centred over the bar, unless that would leave the page.
        let left = (x + 0.5 * (px - text_width(&label, height))).max(x);
        write_text(&mut strokes, &label, [left, y - 0.6 * height], height, 0.7 * line, 1);
        Ok(strokes)
    }
}

/// The largest of 1, 2 and 5 times a power of ten that is not above `v`.
fn round_down(v: f64) -> f64 {
    let power = 10f64.powf(v.log10().floor());
    // The logarithm may round the wrong way at a power of ten.
    let steps = [10.0, 5.0, 2.0, 1.0, 0.5];
    steps.iter().map(|s| s * power).find(|&l| l <= v * (1.0 + 1e-9)).unwrap_or(v)
}

/// A length in words, in the unit that gives the shortest number where the unit is known.
fn words(length: f64, unit: Unit) -> String {
    if unit == Unit::Unknown {
        let unit = if length == 1.0 { "unit" } else { "units" };
        return format!("{} {unit}", short(length));
    }
    let m = length * metres(unit);
    let ladder = [Unit::Metre, Unit::Millimetre, Unit::Micrometre];
    let best = ladder.into_iter().find(|&u| m >= 0.999_999 * metres(u)).unwrap_or(Unit::Nanometre);
    format!("{} {}", short(m / metres(best)), best)
}

/// A number with at most six significant digits and no trailing zeros.
fn short(v: f64) -> String {
    let rounded: f64 = format!("{v:.5e}").parse().unwrap_or(v);
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::Camera;
    use glam::Vec3;

    fn view(ortho: bool) -> (View, Page) {
        let page = Page::pixels(1000, 1000).unwrap();
        (Camera { ortho, ..Camera::default() }.view(Vec3::ZERO, 45.0, &page), page)
    }

    #[test]
    fn lengths_and_words() {
        for (text, shown) in [
            ("auto", "auto"),
            ("50", "50"),
            ("20mm", "20mm"),
            ("1.5 m", "1.5m"),
            ("5um", "5µm"),
            ("2cm", "20mm"),
        ] {
            let bar: ScaleBar = text.parse().unwrap();
            assert_eq!(bar.to_string(), shown);
            assert_eq!(shown.parse::<ScaleBar>().unwrap(), bar);
        }
        for bad in ["", "0", "-1mm", "nan", "3 miles", "mm", "inf"] {
            assert!(bad.parse::<ScaleBar>().is_err(), "{bad}");
        }
        for (length, unit, text) in [
            (0.05, Unit::Millimetre, "50 µm"),
            (2000.0, Unit::Millimetre, "2 m"),
            (20.0, Unit::Millimetre, "20 mm"),
            (200.0, Unit::Nanometre, "200 nm"),
            (0.3, Unit::Unknown, "0.3 units"),
            (1.0, Unit::Unknown, "1 unit"),
        ] {
            assert_eq!(words(length, unit), text);
        }
        for (v, round) in [(26.0, 20.0), (50.0, 50.0), (0.099, 0.05), (1000.0, 1000.0), (1.9999, 1.0)] {
            assert!((round_down(v) / round - 1.0).abs() < 1e-12, "{v}");
        }
    }

    #[test]
    fn the_bar_has_its_length_on_the_page() {
        // 900 px for 90 units: 10 px a unit.
        let (view, page) = view(true);
        for (bar, unit, px) in [
            ("auto", Unit::Unknown, 200.0),
            ("30", Unit::Millimetre, 300.0),
            ("2cm", Unit::Millimetre, 200.0),
            ("40000um", Unit::Millimetre, 400.0),
            ("15mm", Unit::Unknown, 150.0),
        ] {
            let bar: ScaleBar = bar.parse().unwrap();
            let strokes = bar.strokes(&view, &page, unit).unwrap();
            let points = strokes.points(0);
            assert_eq!(points.len(), 4);
            assert!((strokes.x[2] - strokes.x[1] - px).abs() < 0.01, "{bar}");
            assert!(strokes.len() > 3, "it has words");
        }
    }

    #[test]
    fn bars_that_cannot_hold_are_refused() {
        let (parallel, page) = view(true);
        let (perspective, _) = view(false);
        let bar = ScaleBar::default();
        assert!(bar.strokes(&perspective, &page, Unit::Unknown).unwrap_err().contains("parallel"));
        for (length, word) in [("5m", "fit"), ("1um", "short")] {
            let bar: ScaleBar = length.parse().unwrap();
            let error = bar.strokes(&parallel, &page, Unit::Millimetre).unwrap_err();
            assert!(error.contains(word), "{error}");
        }
    }
}
