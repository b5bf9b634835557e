//! How far the pen goes, drawing and in the air.

use std::fmt;

use dotwork_drawing::{Color, Drawing, Layer};

/// The way of the pen over one layer, from the page's top left corner to its last mark.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerTravel {
    /// The layer's objects.
    pub object: String,
    /// The layer's colour.
    pub color: Color,
    /// The layer's pen, its diameter in millimetres.
    pub pen_mm: Option<f32>,
    /// Dots: one touch of the pen each.
    pub touches: usize,
    /// Strokes.
    pub strokes: usize,
    /// Length of all strokes in millimetres.
    pub drawn_mm: f64,
    /// Way in the air in millimetres: from the corner to the first mark and from mark to mark.
    pub lifted_mm: f64,
    /// The share of `lifted_mm` from the corner to the first mark, which some programs do not count.
    pub approach_mm: f64,
    /// Way in the air in millimetres before the marks were ordered.
    pub unordered_mm: f64,
}

/// The way of the pens over a drawing: one pen after the other, each from the page's top left corner; ways back are not
/// counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Travel {
    /// The layers that have marks, from bottom to top.
    pub layers: Vec<LayerTravel>,
}

impl Travel {
    /// Length of all strokes in millimetres.
    pub fn drawn_mm(&self) -> f64 {
        self.layers.iter().map(|l| l.drawn_mm).sum()
    }

    /// Way in the air in millimetres.
    pub fn lifted_mm(&self) -> f64 {
        self.layers.iter().map(|l| l.lifted_mm).sum()
    }

    /// Way in the air in millimetres before the marks were ordered.
    pub fn unordered_mm(&self) -> f64 {
        self.layers.iter().map(|l| l.unordered_mm).sum()
    }

    /// How often a pen is lifted: once after each mark.
    pub fn lifts(&self) -> usize {
        self.layers.iter().map(|l| l.touches + l.strokes).sum()
    }
}

/// One line: `pen 0.25 mm #000000: 50,000 touches, 12.2 m in the air and 0.10 m to the first (unordered 812 m)`.
impl fmt::Display for LayerTravel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.pen_mm {
            Some(mm) => write!(f, "pen {mm} mm {}:", self.color)?,
            None => write!(f, "pen {}:", self.color)?,
        }
        let plural = |n: usize| if n == 1 { "" } else { "s" };
        if self.touches > 0 || self.strokes == 0 {
            let es = if self.touches == 1 { "" } else { "es" };
            write!(f, " {} touch{es},", Grouped(self.touches))?;
        }
        if self.strokes > 0 {
            let n = self.strokes;
            write!(f, " {} stroke{} of {} in all,", Grouped(n), plural(n), Metres(self.drawn_mm))?;
        }
        let between = Metres(self.lifted_mm - self.approach_mm);
        let (approach, unordered) = (Metres(self.approach_mm), Metres(self.unordered_mm));
        write!(f, " {between} in the air and {approach} to the first (unordered {unordered})")
    }
}

/// A line for each layer.
impl fmt::Display for Travel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, layer) in self.layers.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            write!(f, "{layer}")?;
        }
        Ok(())
    }
}

/// A whole number with its thousands grouped.
struct Grouped(usize);

impl fmt::Display for Grouped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = self.0.to_string();
        for (i, digit) in digits.chars().enumerate() {
            if i > 0 && (digits.len() - i).is_multiple_of(3) {
                f.write_str(",")?;
            }
            write!(f, "{digit}")?;
        }
        Ok(())
    }
}

/// Millimetres, written as metres to three digits.
struct Metres(f64);

impl fmt::Display for Metres {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let metres = self.0 * 1e-3;
        match metres {
            100.0.. => write!(f, "{metres:.0} m"),
            10.0.. => write!(f, "{metres:.1} m"),
            _ => write!(f, "{metres:.2} m"),
        }
    }
}

/// Drawn way, way in the air and approach of `layer` in its present order, millimetres. Marks that are not finite are
/// passed over, as they are when written.
pub(super) fn measure(drawing: &Drawing, layer: &Layer) -> [f64; 3] {
    let mm_per_px = f64::from(drawing.page.mm_per_px());
    let mut pen = [0.0f64; 2];
    let (mut drawn, mut lifted, mut approach) = (0.0, 0.0, None);
    let mut go = |to: [f64; 2], down: bool| {
        let length = (to[0] - pen[0]).hypot(to[1] - pen[1]);
        pen = to;
        if down {
            drawn += length;
        } else {
            approach.get_or_insert(length);
            lifted += length;
        }
    };
    for (&x, &y) in layer.dots.x.iter().zip(&layer.dots.y) {
        if super::order::placeable([x, y]) {
            go([f64::from(x), f64::from(y)], false);
        }
    }
    let strokes = &layer.strokes;
    for k in 0..strokes.len() {
        let mut down = false;
        for i in strokes.points(k) {
            let point = [strokes.x[i], strokes.y[i]];
            if super::order::placeable(point) {
                go(point.map(f64::from), down);
                down = true;
            }
        }
    }
    [drawn, lifted, approach.unwrap_or(0.0)].map(|px| px * mm_per_px)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::{Page, StrokeKind};

    #[test]
    fn a_way_that_can_be_added_up() {
        let page = Page { width: 100, height: 100, dpi: 25.4, margin_px: 0.0 };
        let mut drawing = Drawing::new(page, Color::WHITE);
        let mut layer = Layer { dots: crate::testing::dots(3), ..Layer::default() };
        layer.dots.x.copy_from_slice(&[3.0, f32::NAN, 3.0]);
        layer.dots.y.copy_from_slice(&[4.0, 7.0, 10.0]);
        layer.strokes.push_line(StrokeKind::Crease, 1, 1.0, [[3.0, 12.0], [6.0, 16.0], [6.0, 17.0]]);
        drawing.layers.push(layer);
        let [drawn, lifted, approach] = measure(&drawing, &drawing.layers[0]);
        assert!((drawn - 6.0).abs() < 1e-6 && (lifted - 13.0).abs() < 1e-6 && (approach - 5.0).abs() < 1e-6);
    }

    #[test]
    fn words() {
        let layer = LayerTravel {
            object: "bunny".into(),
            color: Color::BLACK,
            pen_mm: Some(0.25),
            touches: 50_000,
            strokes: 0,
            drawn_mm: 0.0,
            lifted_mm: 12_345.0,
            approach_mm: 123.0,
            unordered_mm: 812_345.0,
        };
        let one = "pen 0.25 mm #000000: 50,000 touches, 12.2 m in the air and 0.12 m to the first (unordered 812 m)";
        assert_eq!(layer.to_string(), one);
        let strokes = LayerTravel { pen_mm: None, touches: 0, strokes: 1, drawn_mm: 1234.0, ..layer.clone() };
        let two = "pen #000000: 1 stroke of 1.23 m in all, 12.2 m in the air and 0.12 m to the first (unordered 812 m)";
        assert_eq!(strokes.to_string(), two);
        let travel = Travel { layers: vec![layer, strokes] };
        assert_eq!(travel.to_string(), format!("{one}\n{two}"));
        assert_eq!((travel.lifts(), travel.lifted_mm(), travel.drawn_mm()), (50_001, 24_690.0, 1234.0));
    }
}
