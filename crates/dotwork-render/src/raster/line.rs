//! Strokes: each segment is the convex hull of the discs at its ends, so joints and caps are round.

use dotwork_drawing::Strokes;

use super::disc::{ROWS, span};
use crate::bands::{BAND_ROWS, Bins, centers};

/// Narrower strokes, in pixels, are drawn by the ramp: four rows of samples a pixel would be too few for them.
const THINNEST_SAMPLED: f32 = 2.0;

/// The segments of a layer's strokes, sorted into bands.
#[derive(Default)]
pub(super) struct Segments {
    /// First and last point of each segment; a stroke of one point is a segment from it to itself.
    ends: Vec<[u32; 2]>,
    bins: Bins,
}

/// One segment in pixels, relative to the band's first row.
struct Segment {
    a: [f32; 2],
    b: [f32; 2],
    ra: f32,
    rb: f32,
}

impl Segments {
    /// Finds the segments with finite ends and the bands that they touch; `height` is the page's in pixels.
    pub fn fill(&mut self, strokes: &Strokes, bands: usize, height: usize) {
        self.ends.clear();
        let drawn = |&[a, b]: &[u32; 2]| {
            [a, b].map(|p| p as usize).iter().all(|&p| {
                let placed = strokes.x[p].is_finite() && strokes.y[p].is_finite();
                placed && (0.0..f32::INFINITY).contains(&strokes.width[p]) && strokes.darkness[p] >= 0.0
            })
        };
        for k in 0..strokes.len() {
            let points = strokes.points(k);
            // A point alone is joined to itself.
            let first = points.start + usize::from(points.len() > 1);
            let segments = (first..points.end).map(|i| [i.max(points.start + 1) - 1, i].map(|p| p as u32));
            self.ends.extend(segments.filter(drawn));
        }
        let ends = &self.ends;
        self.bins.fill(ends.len(), bands, |i| {
            let reach = |p: u32| 0.5 * strokes.width[p as usize] + 0.5;
            let [a, b] = ends[i];
            let (ya, yb) = (strokes.y[a as usize], strokes.y[b as usize]);
            // Pixels that the ramp of a partial stroke reaches, not only those with their centre inside.
            centers(
                (ya - reach(a)).min(yb - reach(b)) - 0.5,
                (ya + reach(a)).max(yb + reach(b)) + 0.5,
                height,
            )
        });
    }

    /// Sets the samples of the solid segments of band `k`; false if there are others too.
    pub fn cover(&self, strokes: &Strokes, k: usize, masks: &mut [u64], width: usize) -> bool {
        let mut solid = true;
        for i in self.bins.band(k) {
            if self.is_solid(strokes, i) {
                self.segment(strokes, i, k).cover(masks, width);
            } else {
                solid = false;
            }
        }
        solid
    }

    /// Raises the strength of each pixel to that of the thin and partial segments that cover it.
    pub fn stamp(&self, strokes: &Strokes, k: usize, strength: &mut [f32], width: usize) {
        for i in self.bins.band(k).filter(|&i| !self.is_solid(strokes, i)) {
            let [a, b] = self.ends[i].map(|p| strokes.darkness[p as usize]);
            self.segment(strokes, i, k).stamp(a, b, strength, width);
        }
    }

    fn is_solid(&self, strokes: &Strokes, i: usize) -> bool {
        self.ends[i]
            .iter()
            .all(|&p| strokes.darkness[p as usize] >= 1.0 && strokes.width[p as usize] >= THINNEST_SAMPLED)
    }

    fn segment(&self, strokes: &Strokes, i: usize, k: usize) -> Segment {
        let [a, b] = self.ends[i].map(|p| p as usize);
        let top = (k * BAND_ROWS) as f32;
        Segment {
            a: [strokes.x[a], strokes.y[a] - top],
            b: [strokes.x[b], strokes.y[b] - top],
            ra: 0.5 * strokes.width[a],
            rb: 0.5 * strokes.width[b],
        }
    }
}

impl Segment {
    /// Sets the samples inside.
    fn cover(&self, masks: &mut [u64], width: usize) {
        let Segment { a, b, ra, rb } = *self;
        let rows = masks.len() / width * ROWS as usize;
        let (low, high) = ((a[1] - ra).min(b[1] - rb), (a[1] + ra).max(b[1] + rb));
        let Some((s0, s1)) = centers(low * ROWS as f32, high * ROWS as f32, rows) else { return };
        let hull = self.tangents();
        for s in s0..=s1 {
            let y = (s as f32 + 0.5) * (1.0 / ROWS as f32);
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for (c, r) in [(a, ra), (b, rb)] {
                let dy = y - c[1];
                if dy.abs() <= r {
                    let half = (r * r - dy * dy).max(0.0).sqrt();
                    (low, high) = (low.min(c[0] - half), high.max(c[0] + half));
                }
            }
            // Where the line crosses an edge of the quadrilateral between the discs.
            for [p, q] in hull.iter().flatten() {
                if (p[1] - y) * (q[1] - y) <= 0.0 && p[1] != q[1] {
                    let x = p[0] + (q[0] - p[0]) * ((y - p[1]) / (q[1] - p[1]));
                    (low, high) = (low.min(x), high.max(x));
                }
            }
            if low <= high {
                span(low, high, s, masks, width);
            }
        }
    }

    /// The two straight edges of the hull; `None` where one disc holds the other.
    fn tangents(&self) -> Option<[[[f32; 2]; 2]; 2]> {
        let Segment { a, b, ra, rb } = *self;
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = dx.hypot(dy);
        if length <= (ra - rb).abs() {
            return None;
        }
        // Both discs touch the tangent where their normal n has n · d = (ra − rb) / length.
        let (ux, uy) = (dx / length, dy / length);
        let along = (ra - rb) / length;
        let across = (1.0 - along * along).max(0.0).sqrt();
        Some([1.0f32, -1.0].map(|side| {
            let n = [ux * along - side * uy * across, uy * along + side * ux * across];
            [[a[0] + ra * n[0], a[1] + ra * n[1]], [b[0] + rb * n[0], b[1] + rb * n[1]]]
        }))
    }

    /// Raises strengths by a ramp one pixel wide, darkness `da` and `db` at the ends.
    fn stamp(&self, da: f32, db: f32, strength: &mut [f32], width: usize) {
        let Segment { a, b, ra, rb } = *self;
        let rows = strength.len() / width;
        let reach = ra.max(rb) + 0.5;
        let Some((x0, x1)) = centers(a[0].min(b[0]) - reach, a[0].max(b[0]) + reach, width) else { return };
        let Some((y0, y1)) = centers(a[1].min(b[1]) - reach, a[1].max(b[1]) + reach, rows) else { return };
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let squared = dx * dx + dy * dy;
        let scale = if squared > 0.0 { 1.0 / squared } else { 0.0 };
        for row in y0..=y1 {
            let py = row as f32 + 0.5 - a[1];
            for (k, s) in strength[row * width + x0..=row * width + x1].iter_mut().enumerate() {
                let px = (x0 + k) as f32 + 0.5 - a[0];
                let t = ((px * dx + py * dy) * scale).clamp(0.0, 1.0);
                let distance = (px - t * dx).hypot(py - t * dy);
                let radius = ra + (rb - ra) * t;
                // A line thinner than the ramp covers only its own width of it.
                let coverage = (radius + 0.5 - distance).clamp(0.0, 1.0).min(2.0 * radius);
                *s = s.max(coverage * (da + (db - da) * t));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use dotwork_drawing::color::srgb_to_linear;
    use dotwork_drawing::{Color, Drawing, Layer, Page, StrokeKind};

    use super::*;
    use crate::{Raster, Rasterizer};

    fn ink(strokes: Strokes) -> f64 {
        let mut drawing = Drawing::new(Page::pixels(200, 200).unwrap(), Color::WHITE);
        drawing.layers.push(Layer { strokes, ..Layer::default() });
        let mut raster = Raster::default();
        Rasterizer::new().draw(&drawing, &mut raster);
        raster.samples.iter().map(|&c| 1.0 - f64::from(srgb_to_linear(c))).sum()
    }

    fn line(width: f32, points: &[[f32; 2]]) -> Strokes {
        let mut strokes = Strokes::default();
        strokes.push_line(StrokeKind::Border, 0, width, points.iter().copied());
        strokes
    }

    #[test]
    fn a_stroke_covers_its_area_in_any_direction() {
        for (x, y) in [(130.0f32, 100.0f32), (100.0, 130.0), (121.3, 157.9), (40.2, 71.7)] {
            for width in [0.6f32, 2.0, 9.0] {
                let length = f64::from((x - 100.0).hypot(y - 100.0));
                let width64 = f64::from(width);
                let area = length * width64 + std::f64::consts::PI * (0.5 * width64).powi(2);
                let got = ink(line(width, &[[100.0, 100.0], [x, y]]));
                assert!((got / area - 1.0).abs() < 0.03, "to {x},{y} width {width}: {got} {area}");
            }
        }
    }

    #[test]
    fn tapered_strokes_are_hulls_of_two_discs() {
        let mut strokes = line(1.0, &[[50.0, 100.0], [110.0, 140.0]]);
        strokes.width = vec![2.0, 30.0];
        let (d, ra, rb) = (60f64.hypot(40.0), 1.0f64, 15.0f64);
        let along = (ra - rb) / d;
        let across = (1.0 - along * along).sqrt();
        let beta = along.acos();
        // Two sectors and two trapezia.
        let area = rb * rb * beta + ra * ra * (std::f64::consts::PI - beta) + d * across * (ra + rb);
        assert!((ink(strokes) / area - 1.0).abs() < 0.01);
        // One disc inside the other.
        let mut strokes = line(1.0, &[[100.0, 100.0], [103.0, 100.0]]);
        strokes.width = vec![40.0, 10.0];
        assert!((ink(strokes) / (400.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
    }

    #[test]
    fn joints_and_crossings_are_not_darker() {
        let bent = [[40.0, 40.0], [160.0, 40.0], [100.0, 60.0], [100.0, 20.0]];
        let solid = ink(line(3.0, &bent));
        let mut pale = line(3.0, &bent);
        pale.darkness.fill(0.5);
        assert!((ink(pale) / (0.5 * solid) - 1.0).abs() < 0.02);
        assert!((ink(line(6.0, &[[100.0, 100.0]])) / (9.0 * std::f64::consts::PI) - 1.0).abs() < 0.02);
        assert_eq!(ink(line(6.0, &[])), 0.0);
    }
}
