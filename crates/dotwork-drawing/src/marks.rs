//! Marks and drawings: what every output is made from.

use crate::color::Color;
use crate::page::Page;

/// Dots in structure-of-arrays form; every array has the same length.
///
/// A dot is a disc at a place on the page. It is drawn whole: hiding was decided by its centre.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dots {
    /// Centre, pixels from the left.
    pub x: Vec<f32>,
    /// Centre, pixels from the top.
    pub y: Vec<f32>,
    /// Distance along the view axis, object units, growing away from the eye.
    pub depth: Vec<f32>,
    /// Radius in pixels.
    pub radius: Vec<f32>,
    /// Radius over the style's full dot radius (foreshortening, arrival and growth included).
    pub size: Vec<f32>,
    /// Strength of the ink, 0…1.
    pub ink: Vec<f32>,
    /// Stable identity of the stipple, < 2⁵³, unique within its object.
    pub id: Vec<u64>,
    /// Row of the stipple in its object's stock, for whoever wants its place in space.
    pub stipple: Vec<u32>,
}

impl Dots {
    /// Number of dots.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Forgets all dots and keeps the memory.
    pub fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.depth.clear();
        self.radius.clear();
        self.size.clear();
        self.ink.clear();
        self.id.clear();
        self.stipple.clear();
    }

    /// Appends all of `other`.
    pub fn extend_from(&mut self, other: &Dots) {
        self.x.extend_from_slice(&other.x);
        self.y.extend_from_slice(&other.y);
        self.depth.extend_from_slice(&other.depth);
        self.radius.extend_from_slice(&other.radius);
        self.size.extend_from_slice(&other.size);
        self.ink.extend_from_slice(&other.ink);
        self.id.extend_from_slice(&other.id);
        self.stipple.extend_from_slice(&other.stipple);
    }
}

/// One layer of a drawing: the marks of one object in one colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The object that made the marks.
    pub object: String,
    /// Colour of the ink.
    pub color: Color,
    /// The dots, in drawing order.
    pub dots: Dots,
}

/// A finished picture: a page and an ordered list of layers, the first at the bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// The page.
    pub page: Page,
    /// Colour of the paper.
    pub paper: Color,
    /// Layers from bottom to top.
    pub layers: Vec<Layer>,
}

impl Drawing {
    /// An empty drawing.
    pub fn new(page: Page, paper: Color) -> Drawing {
        Drawing { page, paper, layers: Vec::new() }
    }

    /// Number of dots on all layers.
    pub fn dot_count(&self) -> usize {
        self.layers.iter().map(|l| l.dots.len()).sum()
    }
}
