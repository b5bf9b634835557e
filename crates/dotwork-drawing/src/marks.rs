//! Marks and drawings: what every output is made from.

use std::ops::Range;

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

/// What a stroke stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StrokeKind {
    /// The outline: where the surface turns away from the eye.
    Silhouette,
    /// The edge of an open surface.
    Border,
    /// A sharp edge.
    Crease,
    /// A suggestive contour.
    Suggestive,
    /// A line that explains the picture and belongs to no object: a scale bar and its text.
    Annotation,
}

impl StrokeKind {
    /// Its name in files: lower case, one word.
    pub fn name(self) -> &'static str {
        match self {
            StrokeKind::Silhouette => "silhouette",
            StrokeKind::Border => "border",
            StrokeKind::Crease => "crease",
            StrokeKind::Suggestive => "suggestive",
            StrokeKind::Annotation => "annotation",
        }
    }
}

/// Strokes in structure-of-arrays form: open polylines with round caps and joins; a stroke of one point is a disc.
///
/// Stroke `k` has the points `points(k)`; `x`, `y`, `depth`, `width` and `darkness` have one entry a point, `id` and
/// `kind` one a stroke. A closed line repeats its first point at the end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strokes {
    /// Pixels from the left.
    pub x: Vec<f32>,
    /// Pixels from the top.
    pub y: Vec<f32>,
    /// Distance along the view axis, object units, growing away from the eye.
    pub depth: Vec<f32>,
    /// Full width in pixels.
    pub width: Vec<f32>,
    /// Strength of the ink, 0…1.
    pub darkness: Vec<f32>,
    /// One past the last point of each stroke.
    pub end: Vec<u32>,
    /// Stable identity of each stroke, < 2⁵³.
    pub id: Vec<u64>,
    /// What each stroke stands for.
    pub kind: Vec<StrokeKind>,
}

impl Strokes {
    /// Number of strokes.
    pub fn len(&self) -> usize {
        self.end.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.end.is_empty()
    }

    /// Forgets all strokes and keeps the memory.
    pub fn clear(&mut self) {
        for array in [&mut self.x, &mut self.y, &mut self.depth, &mut self.width, &mut self.darkness] {
            array.clear();
        }
        self.end.clear();
        self.id.clear();
        self.kind.clear();
    }

    /// The points of stroke `k`, as a range of the arrays with one entry a point.
    pub fn points(&self, k: usize) -> Range<usize> {
        let start = if k == 0 { 0 } else { self.end[k - 1] as usize };
        start..self.end[k] as usize
    }

    /// Appends all of `other`.
    pub fn extend_from(&mut self, other: &Strokes) {
        let base = self.x.len() as u32;
        self.x.extend_from_slice(&other.x);
        self.y.extend_from_slice(&other.y);
        self.depth.extend_from_slice(&other.depth);
        self.width.extend_from_slice(&other.width);
        self.darkness.extend_from_slice(&other.darkness);
        self.end.extend(other.end.iter().map(|end| base + end));
        self.id.extend_from_slice(&other.id);
        self.kind.extend_from_slice(&other.kind);
    }

    /// Appends a stroke of one width and full strength through `points` (pixels).
    pub fn push_line(
        &mut self,
        kind: StrokeKind,
        id: u64,
        width: f32,
        points: impl IntoIterator<Item = [f32; 2]>,
    ) {
        for [x, y] in points {
            self.x.push(x);
            self.y.push(y);
            self.depth.push(0.0);
            self.width.push(width);
            self.darkness.push(1.0);
        }
        self.end.push(self.x.len() as u32);
        self.id.push(id);
        self.kind.push(kind);
    }
}

/// A picture placed on the page: a shaded or transparent surface, or what has no marks.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Samples a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Left, top, right and bottom edge on the page, pixels.
    pub place: [f32; 4],
    /// Red, green, blue and opacity of each sample, row by row from the top: linear light, premultiplied, 0…1.
    pub samples: Vec<[f32; 4]>,
}

impl Image {
    /// True if the picture can be drawn: it has as many samples as it says, at least one, and a place with an area, no
    /// further than a million pixels from the page's corner. Outputs leave out all others.
    pub fn is_drawable(&self) -> bool {
        let [left, top, right, bottom] = self.place;
        let near = self.place.iter().all(|edge| edge.abs() < 1e6);
        let count = u64::from(self.width) * u64::from(self.height);
        near && left < right && top < bottom && count > 0 && self.samples.len() as u64 == count
    }
}

/// One layer of a drawing: what one object (or one pen) puts on the page in one colour.
///
/// Drawn in the order image, dots, strokes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// The object that made the marks.
    pub object: String,
    /// Colour of the ink.
    pub color: Color,
    /// The pen that draws this layer, its diameter in millimetres; `None` where sizes are free.
    pub pen_mm: Option<f32>,
    /// A picture under the marks.
    pub image: Option<Image>,
    /// The dots, in drawing order.
    pub dots: Dots,
    /// The strokes, in drawing order.
    pub strokes: Strokes,
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

    /// Number of strokes on all layers.
    pub fn stroke_count(&self) -> usize {
        self.layers.iter().map(|l| l.strokes.len()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_that_are_appended_keep_their_points() {
        let mut one = Strokes::default();
        one.push_line(StrokeKind::Crease, 1, 2.0, [[1.0, 2.0], [3.0, 4.0]]);
        let mut two = Strokes::default();
        two.push_line(StrokeKind::Border, 2, 3.0, [[5.0, 6.0]]);
        two.push_line(StrokeKind::Silhouette, 3, 4.0, [[7.0, 8.0], [9.0, 10.0]]);
        let mut both = one.clone();
        both.push_line(StrokeKind::Border, 2, 3.0, [[5.0, 6.0]]);
        both.push_line(StrokeKind::Silhouette, 3, 4.0, [[7.0, 8.0], [9.0, 10.0]]);
        one.extend_from(&two);
        assert_eq!(one, both);
        assert_eq!((one.points(1), one.points(2)), (2..3, 3..5));
    }

    #[test]
    fn pictures_that_cannot_be_drawn() {
        let image = Image { width: 2, height: 1, place: [0.0, -1.0, 2.0, 3.0], samples: vec![[0.0; 4]; 2] };
        assert!(image.is_drawable());
        for place in
            [[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 1.0, 0.0], [f32::NAN, 0.0, 1.0, 1.0], [0.0, 0.0, 1e9, 1.0]]
        {
            assert!(!Image { place, ..image.clone() }.is_drawable(), "{place:?}");
        }
        assert!(!Image { height: 2, ..image.clone() }.is_drawable());
        assert!(!Image { height: 0, samples: Vec::new(), ..image.clone() }.is_drawable());
        assert!(!Image { width: u32::MAX, height: u32::MAX, ..image }.is_drawable());
    }
}
