//! A drawing as pixels: anti-aliased discs, composited in linear light.
//!
//! Tone is covered area, and in half-tones and darks dots touch and overlap: what counts is the area of their *union*.
//! So each pixel keeps a mask of 16 × 4 samples, solid dots set the samples they cover, and the pixel's coverage is the
//! share of samples set. (Multiplying what each dot leaves clear, the usual way, treats dots that share a pixel as
//! independent; blue-noise dots avoid each other, and tones of 0.7 came out 0.04 too light.) Dots of partial strength
//! do multiply, by a ramp one pixel wide whose summed coverage is exactly the disc's area.

use dotwork_drawing::color::{linear_to_srgb, srgb_to_linear};
use dotwork_drawing::{Color, Dots, Drawing};
use rayon::prelude::*;

use crate::bands::{BAND_ROWS, Bins, centers};

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

    /// Draws `drawing` into `raster`: grey if paper and inks are, colour otherwise.
    pub fn draw(&mut self, drawing: &Drawing, raster: &mut Raster) {
        let (width, height) = (drawing.page.width as usize, drawing.page.height as usize);
        let grey = drawing.paper.is_grey() && drawing.layers.iter().all(|l| l.color.is_grey());
        raster.width = drawing.page.width;
        raster.height = drawing.page.height;
        raster.channels = if grey { 1 } else { 3 };
        raster.samples.resize(width * height * raster.channels, 0);
        let bands = height.div_ceil(BAND_ROWS);
        self.bins.resize_with(drawing.layers.len().max(self.bins.len()), Bins::default);
        for (layer, bins) in drawing.layers.iter().zip(&mut self.bins) {
            let dots = &layer.dots;
            bins.fill(dots.len(), bands, |i| {
                let reach =
                    if dots.ink[i] >= 1.0 { dots.radius[i] + 0.5 } else { Disc::new(dots.radius[i]).reach };
                centers(dots.y[i] - reach, dots.y[i] + reach, height)
            });
        }
        let (bins, channels) = (&self.bins, raster.channels);
        let encoder = &self.encoder;
        // A few groups of bands for each thread, each with memory of its own that stays from frame to frame.
        let groups = bands.min(4 * rayon::current_num_threads()).max(1);
        let bands_each = bands.div_ceil(groups);
        self.scratch.resize_with(groups.max(self.scratch.len()), Band::default);
        let band_bytes = width * BAND_ROWS * channels;
        raster.samples.par_chunks_mut(band_bytes * bands_each).zip(&mut self.scratch).enumerate().for_each(
            |(group, (rows, band))| {
                for (k, out) in rows.chunks_mut(band_bytes).enumerate() {
                    band.draw(drawing, bins, group * bands_each + k, out, channels, encoder);
                }
            },
        );
    }
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
    /// Share that shows through its other dots.
    clear: Vec<f32>,
    /// The page so far in linear light: red, green and blue planes (grey uses the first).
    light: [Vec<f32>; 3],
}

impl Band {
    fn draw(
        &mut self,
        drawing: &Drawing,
        bins: &[Bins],
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
            && self.cover_all(&layer.dots, &bins[0], k, width, pixels)
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
        for (layer, bins) in drawing.layers.iter().zip(bins) {
            self.clear.clear();
            self.clear.resize(pixels, 1.0);
            if !self.cover_all(&layer.dots, bins, k, width, pixels) {
                for i in bins.band(k).filter(|&i| layer.dots.ink[i] < 1.0) {
                    stamp(&layer.dots, i, &mut self.clear, width, top);
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

/// Sample columns and rows of a pixel.
const COLUMNS: i32 = 16;
const ROWS: i32 = 4;

/// Sets the samples that a disc covers; `y` is relative to the band's first row.
#[inline(always)]
fn cover(x: f32, y: f32, radius: f32, masks: &mut [u64], width: usize) {
    let height = (masks.len() / width) as i32;
    // Samples lie at the centres of their cells: sample k at (k + ½) / n.
    let Some((s0, s1)) =
        centers((y - radius) * ROWS as f32, (y + radius) * ROWS as f32, (height * ROWS) as usize)
    else {
        return;
    };
    for s in s0..=s1 {
        let dy = (s as f32 + 0.5) * (1.0 / ROWS as f32) - y;
        let half = (radius * radius - dy * dy).max(0.0).sqrt();
        let (low, high) = ((x - half) * COLUMNS as f32, (x + half) * COLUMNS as f32);
        let Some((c0, c1)) = centers(low, high, width * COLUMNS as usize) else { continue };
        let row = s / ROWS as usize * width;
        let shift = s % ROWS as usize * COLUMNS as usize;
        let (first, last) = (c0 / COLUMNS as usize, c1 / COLUMNS as usize);
        let from = 0xffff_u64 << (c0 % COLUMNS as usize) & 0xffff;
        let to = 0xffff_u64 >> (COLUMNS as usize - 1 - c1 % COLUMNS as usize);
        if first == last {
            masks[row + first] |= (from & to) << shift;
        } else {
            masks[row + first] |= from << shift;
            for mask in &mut masks[row + first + 1..row + last] {
                *mask |= 0xffff << shift;
            }
            masks[row + last] |= to << shift;
        }
    }
}

/// The ramp that stands for a disc.
struct Disc {
    /// Distance from the centre at which coverage ends.
    reach: f32,
    /// Coverage at the centre if the disc is smaller than the ramp.
    peak: f32,
}

impl Disc {
    #[inline(always)]
    fn new(radius: f32) -> Disc {
        // ∫ clamp(R + ½ − d) over the plane is π (R² + 1/12) for R ≥ ½, and π s³/3 for a cone of reach s < 1.
        if radius * radius >= 1.0 / 3.0 {
            Disc { reach: (radius * radius - 1.0 / 12.0).sqrt() + 0.5, peak: 1.0 }
        } else {
            Disc { reach: 1.0, peak: 3.0 * radius * radius }
        }
    }
}

/// Multiplies what shows through by what dot `i`, of partial strength, leaves clear.
#[inline(always)]
fn stamp(dots: &Dots, i: usize, clear: &mut [f32], width: usize, top: usize) {
    let (x, y) = (dots.x[i], dots.y[i] - top as f32);
    let Disc { reach, peak } = Disc::new(dots.radius[i]);
    let strength = peak * dots.ink[i];
    let rows = clear.len() / width;
    let Some((x0, x1)) = centers(x - reach, x + reach, width) else { return };
    let Some((y0, y1)) = centers(y - reach, y + reach, rows) else { return };
    let (x, y) = (x - 0.5, y - 0.5);
    for row in y0..=y1 {
        let dy = row as f32 - y;
        for (k, t) in clear[row * width + x0..=row * width + x1].iter_mut().enumerate() {
            let dx = (x0 + k) as f32 - x;
            let distance = (dx * dx + dy * dy).sqrt();
            *t *= 1.0 - strength * (reach - distance).clamp(0.0, 1.0);
        }
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
}
