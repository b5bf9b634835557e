//! A plate: the marks as black and white pixels at print resolution, no grey between.
//!
//! A pixel belongs to a mark if its centre lies inside. A centre is inside a dot with a probability that is the dot's
//! area in pixels, however small the dot: single dots come out larger or smaller, or vanish, but the mean over dots at
//! places of any phase is exact, and so is the tone. Colours are ignored, for a plate has one ink; only which is darker,
//! paper or ink, decides what is black.
//!
//! Marks of partial strength cannot be grey. A dot is drawn or not by a hash of its identity, with its strength as
//! probability; a stroke becomes thinner, its width times its strength. Pictures have no marks and are left out.
//!
//! Rows are drawn in bands side by side; besides the bits, memory is some bytes a mark.

use std::io;

use dotwork_drawing::color::srgb_to_linear;
use dotwork_drawing::hash::{hash3, unit};
use dotwork_drawing::{Color, Drawing, Layer, Warnings};
use rayon::prelude::*;

/// A black-and-white picture, one bit a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bilevel {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Rows from top to bottom, each of [`Bilevel::row_bytes`]; the leftmost pixel is a byte's highest bit, 1 is black,
    /// and the unused bits at a row's end are 0.
    pub rows: Vec<u8>,
}

impl Bilevel {
    /// Bytes a row takes: an eighth of the width, rounded up.
    pub fn row_bytes(&self) -> usize {
        (self.width as usize).div_ceil(8)
    }

    /// # Errors
    /// [`io::ErrorKind::InvalidInput`] if `rows` does not have the size of the plate, or a side is 0.
    pub(crate) fn check(&self) -> io::Result<()> {
        let Bilevel { width, height, ref rows } = *self;
        let expected = self.row_bytes() as u128 * u128::from(height);
        if expected == 0 || expected != rows.len() as u128 {
            let what =
                format!("a plate of {width} x {height} pixels needs {expected} bytes, not {}", rows.len());
            return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
        }
        Ok(())
    }

    /// True if the pixel in column `x` of row `y` is black.
    ///
    /// # Panics
    /// If there is no such pixel.
    pub fn is_black(&self, x: u32, y: u32) -> bool {
        assert!(x < self.width, "column {x} of {}", self.width);
        self.rows[y as usize * self.row_bytes() + x as usize / 8] & 0x80 >> (x % 8) != 0
    }
}

/// Rows of a band.
const BAND_ROWS: usize = 64;

/// Marks that touch more bands than this are offered to all of them instead of being listed in each.
const MANY_BANDS: usize = 8;

/// The stream of hashes that decide about dots of partial strength.
const STREAM: u32 = 0x0b11_e7e1;

/// Draws the dots and strokes of a drawing as black and white pixels at the page's own resolution.
///
/// Paper is white and ink black. If the paper is darker than the ink of most marks, paper is black and ink white: the
/// picture reads the same. A layer whose ink lies on the other side of the paper than most, or equals it, takes away.
/// Marks that are not finite are left out. `warnings` says what a plate cannot show.
///
/// # Panics
/// If the arrays of a layer's dots or strokes differ in length.
pub fn bilevel(drawing: &Drawing, warnings: &mut Warnings) -> Bilevel {
    let (width, height) = (drawing.page.width as usize, drawing.page.height as usize);
    let pictures = drawing.layers.iter().filter(|l| l.image.is_some());
    let first = pictures.clone().next().map(|l| l.object.clone());
    warnings.counted("pictures left out of a black-and-white plate", pictures.count() as u64, first);
    let (paper, inks) = sides(drawing);
    let bands = height.div_ceil(BAND_ROWS);
    let bins: Vec<Bins> = drawing.layers.par_iter().map(|layer| Bins::new(layer, bands)).collect();
    let row_bytes = width.div_ceil(8);
    let mut rows = vec![if paper { 0xff } else { 0 }; row_bytes * height];
    if row_bytes > 0 {
        rows.par_chunks_mut(row_bytes * BAND_ROWS).enumerate().for_each(|(k, rows)| {
            let mut band = Band { top: (k * BAND_ROWS) as f64, width, row_bytes, rows, black: true };
            for ((layer, bins), &black) in drawing.layers.iter().zip(&bins).zip(&inks) {
                band.black = black;
                for item in bins.of(k) {
                    band.fill(&mark(layer, item));
                }
            }
            band.clear_ends();
        });
    }
    Bilevel { width: drawing.page.width, height: drawing.page.height, rows }
}

/// Whether the paper is black, and whether each layer's ink is.
fn sides(drawing: &Drawing) -> (bool, Vec<bool>) {
    let luminance =
        |c: Color| 0.2126 * srgb_to_linear(c.r) + 0.7152 * srgb_to_linear(c.g) + 0.0722 * srgb_to_linear(c.b);
    let paper = luminance(drawing.paper);
    let (mut darker, mut lighter) = (0, 0);
    for layer in &drawing.layers {
        let ink = luminance(layer.color);
        let marks = layer.dots.len() + layer.strokes.x.len();
        darker += if ink < paper { marks } else { 0 };
        lighter += if ink > paper { marks } else { 0 };
    }
    let black_paper = lighter > darker;
    let ink = |layer: &Layer| {
        let ink = luminance(layer.color);
        if ink == paper { black_paper } else { ink < paper }
    };
    (black_paper, drawing.layers.iter().map(ink).collect())
}

/// The convex hull of two discs: a dot or a stroke's single point, where they are one, or a segment of a stroke.
#[derive(Clone, Copy)]
struct Mark {
    ends: [[f64; 2]; 2],
    radii: [f64; 2],
}

impl Mark {
    /// True if all is finite and there is something to draw.
    fn drawable(&self) -> bool {
        let finite = self.ends.iter().flatten().chain(&self.radii).all(|v| v.is_finite());
        finite && self.radii.iter().all(|&r| r >= 0.0) && self.radii[0].max(self.radii[1]) > 0.0
    }

    /// Top and bottom edge.
    fn rows(&self) -> (f64, f64) {
        let [a, b] = self.ends;
        let [r, s] = self.radii;
        ((a[1] - r).min(b[1] - s), (a[1] + r).max(b[1] + s))
    }
}

/// Mark number `item` of a layer: its dots, then its strokes point by point, each point with the one before it; a stroke
/// of one point is a disc.
fn mark(layer: &Layer, item: u32) -> Mark {
    let (dots, strokes) = (&layer.dots, &layer.strokes);
    let i = item as usize;
    if i < dots.len() {
        let (center, radius) = ([dots.x[i], dots.y[i]].map(f64::from), f64::from(dots.radius[i]));
        return Mark { ends: [center; 2], radii: [radius; 2] };
    }
    let at = |i: usize| {
        let thinned = 0.5 * strokes.width[i] * strokes.darkness[i].clamp(0.0, 1.0);
        ([strokes.x[i], strokes.y[i]].map(f64::from), f64::from(thinned))
    };
    let i = i - dots.len();
    // No point lies before one that begins a stroke; it is asked for only where it stands alone.
    let begins = i == 0 || strokes.end.binary_search(&(i as u32)).is_ok();
    let ((a, r), (b, s)) = (at(i - usize::from(!begins)), at(i));
    Mark { ends: [a, b], radii: [r, s] }
}

/// The marks that each band is to look at, in the order of the layer.
struct Bins {
    /// Marks of band `k` from `start[k]` to `start[k + 1]`.
    start: Vec<usize>,
    items: Vec<u32>,
    /// Marks of many bands.
    large: Vec<u32>,
}

impl Bins {
    fn new(layer: &Layer, bands: usize) -> Bins {
        let mut bins = Bins { start: vec![0; bands + 1], items: Vec::new(), large: Vec::new() };
        let mut large = Vec::new();
        each_mark(layer, bands, |item, first, last| {
            if last - first > MANY_BANDS {
                large.push(item);
            } else {
                bins.start[first + 1..=last + 1].iter_mut().for_each(|n| *n += 1);
            }
        });
        for k in 0..bands {
            bins.start[k + 1] += bins.start[k];
        }
        let mut next = bins.start.clone();
        bins.items.resize(bins.start[bands], 0);
        each_mark(layer, bands, |item, first, last| {
            if last - first <= MANY_BANDS {
                for at in &mut next[first..=last] {
                    bins.items[*at] = item;
                    *at += 1;
                }
            }
        });
        bins.large = large;
        bins
    }

    fn of(&self, band: usize) -> impl Iterator<Item = u32> + '_ {
        self.items[self.start[band]..self.start[band + 1]].iter().chain(&self.large).copied()
    }
}

/// Calls `each` with every mark that is drawn, its first and its last band.
fn each_mark(layer: &Layer, bands: usize, mut each: impl FnMut(u32, usize, usize)) {
    let mut offer = |item: usize| {
        let mark = mark(layer, item as u32);
        let (top, bottom) = mark.rows();
        if mark.drawable()
            && let Some((first, last)) = centers(top, bottom, bands * BAND_ROWS)
        {
            each(item as u32, first / BAND_ROWS, last / BAND_ROWS);
        }
    };
    let dots = &layer.dots;
    for (i, (&ink, &id)) in dots.ink.iter().zip(&dots.id).enumerate() {
        if ink >= 1.0 || unit(hash3(id as u32, (id >> 32) as u32, STREAM)) < ink {
            offer(i);
        }
    }
    for k in 0..layer.strokes.len() {
        let points = layer.strokes.points(k);
        let first = points.start + usize::from(points.len() > 1);
        for i in first..points.end {
            offer(dots.len() + i);
        }
    }
}

/// First and last of the pixels `0..size` whose centres lie in `low..=high`.
fn centers(low: f64, high: f64, size: usize) -> Option<(usize, usize)> {
    let first = (low - 0.5).ceil().max(0.0);
    let last = (high - 0.5).floor().min(size as f64 - 1.0);
    (first <= last).then_some((first as usize, last as usize))
}

/// Some rows of the plate.
struct Band<'a> {
    top: f64,
    width: usize,
    row_bytes: usize,
    rows: &'a mut [u8],
    /// What marks set.
    black: bool,
}

impl Band<'_> {
    /// Draws a mark: its rows are intervals, since it is convex.
    fn fill(&mut self, mark: &Mark) {
        let (top, bottom) = mark.rows();
        let count = self.rows.len() / self.row_bytes;
        let Some((first, last)) = centers(top - self.top, bottom - self.top, count) else { return };
        let [a, b] = mark.ends;
        let [r, s] = mark.radii;
        let sides = if a == b { None } else { tangents(mark) };
        for row in first..=last {
            let y = self.top + row as f64 + 0.5;
            let mut span = (f64::INFINITY, f64::NEG_INFINITY);
            let mut widen = |low: f64, high: f64| span = (span.0.min(low), span.1.max(high));
            for ([cx, cy], r) in [(a, r), (b, s)] {
                let half = r * r - (y - cy) * (y - cy);
                if half >= 0.0 {
                    let half = half.sqrt();
                    widen(cx - half, cx + half);
                }
            }
            for [[x0, y0], [x1, y1]] in sides.into_iter().flatten() {
                if (y0 <= y && y <= y1) || (y1 <= y && y <= y0) {
                    let x = if y0 == y1 { x0 } else { x0 + (x1 - x0) * ((y - y0) / (y1 - y0)) };
                    widen(x, x);
                }
            }
            if let Some((from, to)) = centers(span.0, span.1, self.width) {
                self.span(row, from, to);
            }
        }
    }

    /// Sets or clears the pixels `from..=to` of a row.
    fn span(&mut self, row: usize, from: usize, to: usize) {
        let row = &mut self.rows[row * self.row_bytes..][..self.row_bytes];
        let (first, last) = (from / 8, to / 8);
        let (head, tail) = (0xff_u8 >> (from % 8), 0xff_u8 << (7 - to % 8));
        let mut set = |byte: usize, mask: u8| {
            if self.black {
                row[byte] |= mask;
            } else {
                row[byte] &= !mask;
            }
        };
        if first == last {
            set(first, head & tail);
        } else {
            set(first, head);
            set(last, tail);
            row[first + 1..last].fill(if self.black { 0xff } else { 0 });
        }
    }

    /// Clears the bits beyond the last column.
    fn clear_ends(&mut self) {
        let unused = self.row_bytes * 8 - self.width;
        for row in self.rows.chunks_exact_mut(self.row_bytes) {
            row[self.row_bytes - 1] &= 0xff << unused;
        }
    }
}

/// The two straight sides of the hull; `None` if one disc holds the other.
fn tangents(mark: &Mark) -> Option<[[[f64; 2]; 2]; 2]> {
    let [a, b] = mark.ends;
    let [r, s] = mark.radii;
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx.hypot(dy);
    // Both tangent points of a side lie in the same direction from their centres, at this cosine to the axis.
    let cosine = (r - s) / length;
    if cosine.abs() >= 1.0 {
        return None;
    }
    let sine = (1.0 - cosine * cosine).sqrt();
    let (ux, uy) = (dx / length, dy / length);
    Some([1.0, -1.0].map(|side| {
        let n = [ux * cosine - side * uy * sine, uy * cosine + side * ux * sine];
        [[a[0] + n[0] * r, a[1] + n[1] * r], [b[0] + n[0] * s, b[1] + n[1] * s]]
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::hash::hash2;
    use dotwork_drawing::{Dots, Image, Page, StrokeKind, Strokes};

    fn drawing(width: u32, height: u32, layer: Layer) -> Drawing {
        let mut drawing = Drawing::new(Page::pixels(width, height).unwrap(), Color::WHITE);
        drawing.layers.push(layer);
        drawing
    }

    fn plate(drawing: &Drawing) -> Bilevel {
        let mut warnings = Warnings::new();
        let plate = bilevel(drawing, &mut warnings);
        assert!(warnings.is_empty());
        plate
    }

    fn black(plate: &Bilevel) -> u64 {
        plate.rows.iter().map(|b| u64::from(b.count_ones())).sum()
    }

    /// One dot in each cell of a grid, at a random place of it where it meets no other.
    fn blue(cells: u32, cell: f32, radius: impl Fn(u32) -> f32, ink: f32) -> Dots {
        let mut dots = Dots::default();
        for i in 0..cells * cells {
            let radius = radius(i);
            let at = |k: u32, n: u32| n as f32 * cell + radius + unit(hash2(i, k)) * (cell - 2.0 * radius);
            dots.x.push(at(1, i % cells));
            dots.y.push(at(2, i / cells));
            dots.radius.push(radius);
            dots.ink.push(ink);
            dots.depth.push(0.0);
            dots.size.push(1.0);
            dots.id.push(u64::from(i) << 20 | 77);
            dots.stipple.push(i);
        }
        dots
    }

    #[test]
    fn tone_is_the_area_of_the_dots() {
        for radius in [0.25f32, 0.5, 0.8, 1.5, 2.9] {
            let spread = |i: u32| radius * (0.9 + 0.2 * unit(hash2(i, 3)));
            // Cells of a broken number of pixels, so that dots have every phase.
            let dots = blue(500, 6.381_966, spread, 1.0);
            let area: f64 = dots.radius.iter().map(|&r| std::f64::consts::PI * f64::from(r).powi(2)).sum();
            let got = black(&plate(&drawing(3500, 3500, Layer { dots, ..Layer::default() }))) as f64;
            // Half of a per cent; the smallest, black or not by chance, scatter by as much.
            let room = if radius < 0.5 { 0.01 } else { 0.005 };
            assert!((got / area - 1.0).abs() < room, "radius {radius}: {got} for {area}");
        }
    }

    #[test]
    fn partial_strength_is_kept_on_average() {
        let dots = blue(300, 7.0, |_| 2.0, 0.3);
        let area = 0.3 * 90_000.0 * std::f64::consts::PI * 4.0;
        let whole = drawing(2100, 2100, Layer { dots, ..Layer::default() });
        let first = plate(&whole);
        assert!((black(&first) as f64 / area - 1.0).abs() < 0.02);
        assert_eq!(first, plate(&whole), "the same choice every time");
        // A stroke of half strength is half as wide.
        let mut strokes = Strokes::default();
        strokes.push_line(StrokeKind::Crease, 1, 6.0, [[20.0, 20.3], [80.0, 51.7]]);
        strokes.darkness.fill(0.5);
        let got = black(&plate(&drawing(100, 100, Layer { strokes, ..Layer::default() }))) as f64;
        let area = 60.0f64.hypot(31.4) * 3.0 + std::f64::consts::PI * 2.25;
        assert!((got / area - 1.0).abs() < 0.04, "{got} for {area}");
    }

    #[test]
    fn pixels_are_black_where_their_centres_are_inside() {
        // Marks larger than bands, tapering, across the edges; each pixel by the definition.
        let mut strokes = Strokes::default();
        strokes.push_line(
            StrokeKind::Silhouette,
            1,
            0.0,
            [[-5.0, 30.2], [150.0, 180.7], [90.4, 350.0], [90.4, 20.0]],
        );
        strokes.push_line(StrokeKind::Crease, 2, 0.0, [[10.0, 300.0], [60.0, 300.0], [61.0, 300.0]]);
        strokes.width.copy_from_slice(&[3.0, 20.0, 0.0, 9.0, 4.0, 4.0, 30.0]);
        let dots = Dots {
            x: vec![40.3, 199.0, 0.2, 120.0],
            y: vec![100.1, 0.0, 371.0, 200.0],
            radius: vec![17.3, 30.0, 6.0, 0.4],
            ink: vec![1.0; 4],
            depth: vec![0.0; 4],
            size: vec![1.0; 4],
            id: vec![1, 2, 3, 4],
            stipple: vec![0; 4],
        };
        let layer = Layer { dots: dots.clone(), strokes: strokes.clone(), ..Layer::default() };
        let plate = plate(&drawing(203, 371, layer));
        // Inside the hull of two discs: inside one of the discs between them.
        let inside = |p: [f64; 2], a: [f64; 2], r: f64, b: [f64; 2], s: f64| {
            (0..=2000).any(|i| {
                let t = f64::from(i) / 2000.0;
                let c = [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
                (p[0] - c[0]).hypot(p[1] - c[1]) <= r + (s - r) * t
            })
        };
        let mut marks = Vec::new();
        for i in 0..4 {
            let c = [f64::from(dots.x[i]), f64::from(dots.y[i])];
            marks.push((c, f64::from(dots.radius[i]), c, f64::from(dots.radius[i])));
        }
        for (i, j) in [(0, 1), (1, 2), (2, 3), (4, 5), (5, 6)] {
            let at =
                |i: usize| ([strokes.x[i], strokes.y[i]].map(f64::from), f64::from(strokes.width[i]) / 2.0);
            marks.push((at(i).0, at(i).1, at(j).0, at(j).1));
        }
        let (mut differ, mut all) = (0, 0);
        for y in 0..371 {
            for x in 0..203 {
                let p = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                let expected = marks.iter().any(|&(a, r, b, s)| {
                    // The sampled oracle is slow; far pixels are outside.
                    let (lx, hx) = ((a[0] - r).min(b[0] - s), (a[0] + r).max(b[0] + s));
                    let (ly, hy) = ((a[1] - r).min(b[1] - s), (a[1] + r).max(b[1] + s));
                    (lx..=hx).contains(&p[0]) && (ly..=hy).contains(&p[1]) && inside(p, a, r, b, s)
                });
                differ += usize::from(plate.is_black(x, y) != expected);
                all += usize::from(expected);
            }
        }
        assert!(all > 8000 && differ <= 2, "{differ} of {all}");
    }

    #[test]
    fn a_stroke_of_one_point_is_a_disc() {
        // The decimal point of a scale bar's label is one.
        let mut strokes = Strokes::default();
        strokes.push_line(StrokeKind::Annotation, 1, 60.0, [[50.2, 50.7]]);
        let got = black(&plate(&drawing(100, 100, Layer { strokes, ..Layer::default() }))) as f64;
        assert!((got / (900.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{got}");
    }

    #[test]
    fn light_ink_on_dark_paper_stays_light() {
        let dots = blue(10, 10.0, |_| 2.0, 1.0);
        let mut day = drawing(100, 100, Layer { dots: dots.clone(), ..Layer::default() });
        let on_white = plate(&day);
        day.paper = Color { r: 40, g: 0, b: 0 };
        day.layers[0].color = Color { r: 250, g: 230, b: 0 };
        let on_dark = plate(&day);
        assert_eq!(black(&on_dark), 10_000 - black(&on_white));
        assert!(on_dark.is_black(0, 0) != on_white.is_black(0, 0));
        // A lighter ink over grey paper takes away from a darker one.
        day.paper = Color { r: 128, g: 128, b: 128 };
        day.layers[0].color = Color::BLACK;
        day.layers.push(Layer { color: Color::WHITE, ..day.layers[0].clone() });
        day.layers[1].dots.x.iter_mut().for_each(|x| *x += 1000.0);
        day.layers[1].dots.x[0] = day.layers[0].dots.x[0];
        assert_eq!(day.layers[0].dots.y[0], day.layers[1].dots.y[0]);
        let both = plate(&day);
        let (x, y) = (dots.x[0] as u32, dots.y[0] as u32);
        assert!(on_white.is_black(x, y) && !both.is_black(x, y));
        assert!(black(&both) < black(&on_white));
    }

    #[test]
    fn hostile_marks_and_pages() {
        let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0, 0.0, 1e-30];
        let mut layer = Layer::default();
        for (i, &x) in bad.iter().enumerate() {
            for &radius in &bad {
                let dots = &mut layer.dots;
                dots.x.push(x);
                dots.y.push(bad[(i + 3) % bad.len()]);
                dots.radius.push(radius.min(3.0));
                dots.ink.push(if i % 2 == 0 { 1.0 } else { x });
                dots.depth.push(0.0);
                dots.size.push(0.0);
                dots.id.push(u64::MAX - i as u64);
                dots.stipple.push(0);
                layer.strokes.push_line(
                    StrokeKind::Crease,
                    0,
                    radius.min(3.0),
                    [[x, 5.0], [9.0, radius], [9.0, radius]],
                );
            }
        }
        layer.strokes.push_line(StrokeKind::Crease, 0, 1.0, []);
        layer.strokes.push_line(StrokeKind::Crease, 0, 1.0, [[3.0, 3.0]]);
        let got = plate(&drawing(13, 70, layer.clone()));
        assert!(got.rows.chunks(2).all(|row| row[1] & 7 == 0), "unused bits are 0");
        // A page that was not checked, and one mark larger than the page.
        let mut none = drawing(1, 1, Layer::default());
        none.page.width = 0;
        assert!(plate(&none).rows.is_empty());
        layer = Layer { dots: blue(1, 1e9, |_| 1e8, 1.0), ..Layer::default() };
        (layer.dots.x[0], layer.dots.y[0]) = (3.0, 3.0);
        assert_eq!(black(&plate(&drawing(13, 700, layer))), 13 * 700);
    }

    #[test]
    fn pictures_are_left_out_with_a_warning() {
        let image =
            Image { width: 1, height: 1, place: [0.0, 0.0, 9.0, 9.0], samples: vec![[0.0, 0.0, 0.0, 1.0]] };
        let layer = Layer { object: "skin".into(), image: Some(image), ..Layer::default() };
        let mut warnings = Warnings::new();
        let plate = bilevel(&drawing(9, 9, layer), &mut warnings);
        assert_eq!(black(&plate), 0);
        let said: Vec<String> = warnings.iter().map(|w| w.to_string()).collect();
        assert_eq!(said, ["pictures left out of a black-and-white plate (skin)"]);
    }
}
