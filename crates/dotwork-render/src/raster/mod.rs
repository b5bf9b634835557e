//! A drawing as pixels: anti-aliased discs and lines, composited in linear light.
//!
//! Tone is covered area, and in half-tones and darks dots touch and overlap: what counts is the area of their *union*.
//! So each pixel keeps a mask of 16 × 4 samples, solid dots set the samples they cover, and the pixel's coverage is the
//! share of samples set. (Multiplying what each dot leaves clear, the usual way, treats dots that share a pixel as
//! independent; blue-noise dots avoid each other, and tones of 0.7 came out 0.04 too light.) Dots of partial strength
//! do multiply, by a ramp one pixel wide whose summed coverage is exactly the disc's area. Solid strokes set samples
//! as dots do; of strokes of partial strength the strongest at a pixel counts, so that joints and crossings are not
//! darker than the line.

use dotwork_drawing::color::{linear_to_srgb, srgb_to_linear};
use dotwork_drawing::{Color, Dots, Drawing, Layer};
use rayon::prelude::*;

use crate::bands::{BAND_ROWS, Bins, centers};
use disc::{Disc, cover, stamp};
use line::Segments;

mod disc;
mod line;
mod picture;

/// An 8-bit picture, sRGB-encoded, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Raster {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// 1 (grey) or 3 (red, green, blue) bytes a pixel.
    pub channels: usize,
    /// The samples.
    pub samples: Vec<u8>,
}

/// Turns drawings into rasters and keeps its memory from frame to frame.
#[derive(Default)]
pub struct Rasterizer {
    bins: Vec<Bins>,
    lines: Vec<Segments>,
    encoder: Encoder,
    scratch: Vec<Band>,
}

/// Steps of the table from linear light to sRGB: fine enough that no step of the darkest tones is skipped.
const ENCODE_STEPS: usize = 1 << 14;

impl Rasterizer {
    /// A rasteriser with nothing drawn yet.
    pub fn new() -> Rasterizer {
        Rasterizer::default()
    }

    /// Draws `drawing` into `raster`: grey if paper and inks are, colour otherwise. Marks and pictures that are not
    /// finite are left out.
    ///
    /// # Panics
    /// If the arrays of a layer's dots or strokes differ in length.
    pub fn draw(&mut self, drawing: &Drawing, raster: &mut Raster) {
        let (width, height) = (drawing.page.width as usize, drawing.page.height as usize);
        let grey = drawing.paper.is_grey() && drawing.layers.iter().all(is_grey);
        raster.width = drawing.page.width;
        raster.height = drawing.page.height;
        raster.channels = if grey { 1 } else { 3 };
        raster.samples.resize(width * height * raster.channels, 0);
        let bands = height.div_ceil(BAND_ROWS);
        self.bins.resize_with(drawing.layers.len().max(self.bins.len()), Bins::default);
        for (layer, bins) in drawing.layers.iter().zip(&mut self.bins) {
            let dots = &layer.dots;
            bins.fill(dots.len(), bands, |i| {
                if !((0.0..f32::INFINITY).contains(&dots.radius[i]) && dots.ink[i] > 0.0) {
                    return None;
                }
                let reach =
                    if dots.ink[i] >= 1.0 { dots.radius[i] + 0.5 } else { Disc::new(dots.radius[i]).reach };
                centers(dots.y[i] - reach, dots.y[i] + reach, height)
            });
        }
        self.lines.resize_with(drawing.layers.len().max(self.lines.len()), Segments::default);
        for (layer, lines) in drawing.layers.iter().zip(&mut self.lines) {
            lines.fill(&layer.strokes, bands, height);
        }
        let (bins, lines, channels) = (&self.bins, &self.lines, raster.channels);
        let encoder = &self.encoder;
        // A few groups of bands for each thread, each with memory of its own that stays from frame to frame.
        let groups = bands.min(4 * rayon::current_num_threads()).max(1);
        let bands_each = bands.div_ceil(groups);
        self.scratch.resize_with(groups.max(self.scratch.len()), Band::default);
        let band_bytes = width * BAND_ROWS * channels;
        raster.samples.par_chunks_mut(band_bytes * bands_each).zip(&mut self.scratch).enumerate().for_each(
            |(group, (rows, band))| {
                for (k, out) in rows.chunks_mut(band_bytes).enumerate() {
                    band.draw(drawing, bins, lines, group * bands_each + k, out, channels, encoder);
                }
            },
        );
    }
}

fn is_grey(layer: &Layer) -> bool {
    let grey = |s: &[f32; 4]| s[0] == s[1] && s[1] == s[2];
    layer.color.is_grey() && layer.image.as_ref().is_none_or(|i| i.samples.iter().all(grey))
}

/// Linear light to sRGB by table.
struct Encoder(Vec<u8>);

impl Default for Encoder {
    fn default() -> Encoder {
        Encoder((0..=ENCODE_STEPS).map(|i| linear_to_srgb(i as f32 / ENCODE_STEPS as f32)).collect())
    }
}

impl Encoder {
    #[inline(always)]
    fn encode(&self, linear: f32) -> u8 {
        self.0[(linear * ENCODE_STEPS as f32 + 0.5) as usize]
    }
}

/// One task's memory: a band of the page.
#[derive(Default)]
struct Band {
    /// Samples covered by the solid dots of the current layer.
    masks: Vec<u64>,
    /// Share that shows through its other dots and strokes.
    clear: Vec<f32>,
    /// Strength of its strokes of partial strength.
    strength: Vec<f32>,
    /// The page so far in linear light: red, green and blue planes (grey uses the first).
    light: [Vec<f32>; 3],
}

impl Band {
    fn draw(
        &mut self,
        drawing: &Drawing,
        bins: &[Bins],
        lines: &[Segments],
        k: usize,
        out: &mut [u8],
        channels: usize,
        encoder: &Encoder,
    ) {
        let width = drawing.page.width as usize;
        let pixels = out.len() / channels;
        let top = k * BAND_ROWS;
        let linear = |c: Color| [c.r, c.g, c.b].map(srgb_to_linear);
        let paper = linear(drawing.paper);
        if let [layer] = &drawing.layers[..]
            && layer.image.is_none()
            && self.cover_all(&layer.dots, &bins[0], k, width, pixels)
            && lines[0].cover(&layer.strokes, k, &mut self.masks, width)
        {
            // One ink on paper: a pixel's colour depends on its samples alone.
            let ink = linear(layer.color);
            let colors: [[u8; 3]; 65] = std::array::from_fn(|n| {
                let t = 1.0 - n as f32 / 64.0;
                [0, 1, 2].map(|c| encoder.encode(ink[c] + (paper[c] - ink[c]) * t))
            });
            for (o, mask) in out.chunks_exact_mut(channels).zip(&self.masks) {
                // Most of the page is bare: counting bits takes longer than asking.
                let color = if *mask == 0 { &colors[0] } else { &colors[mask.count_ones() as usize] };
                o.copy_from_slice(&color[..channels]);
            }
            return;
        }
        for (plane, light) in self.light.iter_mut().zip(paper).take(channels) {
            plane.clear();
            plane.resize(pixels, light);
        }
        for ((layer, bins), lines) in drawing.layers.iter().zip(bins).zip(lines) {
            if let Some(image) = &layer.image {
                picture::blend(image, &mut self.light[..channels], width, top);
            }
            self.clear.clear();
            self.clear.resize(pixels, 1.0);
            if !self.cover_all(&layer.dots, bins, k, width, pixels) {
                for i in bins.band(k).filter(|&i| layer.dots.ink[i] < 1.0) {
                    stamp(&layer.dots, i, &mut self.clear, width, top);
                }
            }
            if !lines.cover(&layer.strokes, k, &mut self.masks, width) {
                self.strength.clear();
                self.strength.resize(pixels, 0.0);
                lines.stamp(&layer.strokes, k, &mut self.strength, width);
                for (t, s) in self.clear.iter_mut().zip(&self.strength) {
                    *t *= 1.0 - s;
                }
            }
            for (t, mask) in self.clear.iter_mut().zip(&self.masks) {
                if *mask != 0 {
                    *t *= 1.0 - mask.count_ones() as f32 * (1.0 / 64.0);
                }
            }
            for (plane, ink) in self.light.iter_mut().zip(linear(layer.color)).take(channels) {
                for (p, t) in plane.iter_mut().zip(&self.clear) {
                    *p = ink + (*p - ink) * t;
                }
            }
        }
        for (i, o) in out.chunks_exact_mut(channels).enumerate() {
            for (sample, plane) in o.iter_mut().zip(&self.light) {
                *sample = encoder.encode(plane[i]);
            }
        }
    }

    /// Sets the samples of a layer's solid dots; false if there are dots of partial strength too.
    fn cover_all(&mut self, dots: &Dots, bins: &Bins, k: usize, width: usize, pixels: usize) -> bool {
        self.masks.clear();
        self.masks.resize(pixels, 0);
        let top = (k * BAND_ROWS) as f32;
        let mut solid = true;
        for i in bins.band(k) {
            if dots.ink[i] >= 1.0 {
                cover(dots.x[i], dots.y[i] - top, dots.radius[i], &mut self.masks, width);
            } else {
                solid = false;
            }
        }
        solid
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::hash::{hash2, unit};
    use dotwork_drawing::{Layer, Page};

    fn dots(n: u32, side: f32, radius: f32, ink: f32) -> Dots {
        let mut dots = Dots::default();
        for i in 0..n {
            // Ten radii from the edges, so that every dot lies whole on the page.
            dots.x.push(10.0 + unit(hash2(i, 1)) * (side - 20.0));
            dots.y.push(10.0 + unit(hash2(i, 2)) * (side - 20.0));
            dots.depth.push(1.0);
            dots.radius.push(radius);
            dots.size.push(1.0);
            dots.ink.push(ink);
            dots.id.push(u64::from(i));
            dots.stipple.push(i);
        }
        dots
    }

    fn total_ink(dots: Dots, side: u32) -> f64 {
        let mut drawing = Drawing::new(Page::pixels(side, side).unwrap(), Color::WHITE);
        drawing.layers.push(Layer { object: "o".into(), color: Color::BLACK, dots, ..Layer::default() });
        let mut raster = Raster::default();
        Rasterizer::new().draw(&drawing, &mut raster);
        assert_eq!((raster.channels, raster.samples.len()), (1, (side * side) as usize));
        raster.samples.iter().map(|&c| 1.0 - f64::from(srgb_to_linear(c))).sum()
    }

    #[test]
    fn lonely_dots_carry_exactly_their_area() {
        // 60 dots on a large page hardly meet.
        for radius in [0.3f32, 0.6, 1.0, 1.7, 3.0] {
            for (ink, tolerance) in [(1.0f32, 0.03), (0.5, 0.03)] {
                let n = 60;
                let expected =
                    std::f64::consts::PI * f64::from(radius).powi(2) * f64::from(ink) * f64::from(n);
                let got = total_ink(dots(n, 1000.0, radius, ink), 1000);
                assert!(
                    (got / expected - 1.0).abs() < tolerance,
                    "radius {radius} ink {ink}: {got} {expected}"
                );
            }
        }
    }

    #[test]
    fn overlapping_dots_cover_their_union() {
        let mut two = dots(1, 100.0, 5.0, 1.0);
        let one = total_ink(two.clone(), 100);
        two.extend_from(&two.clone());
        assert_eq!(total_ink(two, 100), one);
    }

    #[test]
    fn colour_pictures_have_three_channels() {
        let red = Color { r: 200, g: 0, b: 0 };
        let mut drawing = Drawing::new(Page::pixels(64, 40).unwrap(), Color::WHITE);
        drawing.layers.push(Layer {
            object: "o".into(),
            color: red,
            dots: dots(1, 40.0, 9.0, 1.0),
            ..Layer::default()
        });
        let mut raster = Raster::default();
        Rasterizer::new().draw(&drawing, &mut raster);
        assert_eq!((raster.channels, raster.samples.len()), (3, 64 * 40 * 3));
        let (x, y) = (drawing.layers[0].dots.x[0] as usize, drawing.layers[0].dots.y[0] as usize);
        assert_eq!(raster.samples[(y * 64 + x) * 3..][..3], [200, 0, 0]);
        assert_eq!(raster.samples[..3], [255, 255, 255]);
    }

    #[test]
    fn marks_that_are_not_finite_or_far_away_leave_the_page_bare() {
        use dotwork_drawing::{StrokeKind, Strokes};
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e12, -1e12, f32::MAX, f32::MIN] {
            let mut layer = Layer::default();
            for ink in [1.0, 0.5] {
                let at = |x: f32, y: f32, radius: f32| {
                    let one = dots(1, 40.0, radius, ink);
                    Dots { x: vec![x], y: vec![y], ..one }
                };
                layer.dots.extend_from(&at(bad, 20.0, 2.0));
                layer.dots.extend_from(&at(20.0, bad, 2.0));
                if !(bad > 0.0 && bad.is_finite()) {
                    layer.dots.extend_from(&at(20.0, 20.0, bad));
                }
                layer.dots.extend_from(&Dots { ink: vec![f32::NAN], ..at(20.0, 20.0, 2.0) });
                for width in [1.0, 3.0] {
                    let mut strokes = Strokes::default();
                    strokes.push_line(StrokeKind::Crease, 0, width, [[bad, 20.0]]);
                    strokes.push_line(StrokeKind::Crease, 1, width, [[20.0, bad], [30.0, bad]]);
                    strokes.push_line(StrokeKind::Crease, 2, width, [[bad, bad], [bad, 20.0]]);
                    strokes.darkness.fill(ink);
                    layer.strokes.extend_from(&strokes);
                }
                if !(bad > 0.0 && bad.is_finite()) {
                    layer.strokes.push_line(StrokeKind::Crease, 3, bad, [[5.0, 5.0], [9.0, 9.0]]);
                }
            }
            let mut drawing = Drawing::new(Page::pixels(40, 70).unwrap(), Color::WHITE);
            drawing.layers.push(layer);
            let mut raster = Raster::default();
            Rasterizer::new().draw(&drawing, &mut raster);
            assert!(raster.samples.iter().all(|&c| c == 255), "{bad}");
        }
    }
}
