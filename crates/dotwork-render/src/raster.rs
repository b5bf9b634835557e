//! A drawing as pixels: analytic anti-aliased discs, composited in linear light.
//!
//! A disc's coverage of a pixel is approximated by a ramp one pixel wide across its edge. The ramp's radius is chosen
//! so that the *summed* coverage is exactly the disc's area at every size, because tone is summed coverage: a plain
//! ramp around the true radius puts `π/12` of a pixel too much on each dot.

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
                let reach = Disc::new(dots.radius[i]).reach;
                centers(dots.y[i] - reach, dots.y[i] + reach, height)
            });
        }
        let bins = &self.bins;
        let encoder = &self.encoder;
        let band_bytes = width * BAND_ROWS * raster.channels;
        raster.samples.par_chunks_mut(band_bytes).enumerate().for_each_init(
            || Band::new(width),
            |band, (k, out)| band.draw(drawing, bins, k, out, encoder),
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

/// One thread's scratch: a band of the page in linear light.
struct Band {
    width: usize,
    /// Share of the paper that still shows through the current layer.
    clear: Vec<f32>,
    /// The page so far, red, green and blue planes (grey uses the first).
    light: [Vec<f32>; 3],
}

impl Band {
    fn new(width: usize) -> Band {
        let plane = || vec![0.0; width * BAND_ROWS];
        Band { width, clear: plane(), light: [plane(), plane(), plane()] }
    }

    fn draw(&mut self, drawing: &Drawing, bins: &[Bins], k: usize, out: &mut [u8], encoder: &Encoder) {
        let channels = if out.len() > self.width * BAND_ROWS { 3 } else { self.channels_of(drawing) };
        let pixels = out.len() / channels;
        let top = k * BAND_ROWS;
        let linear = |c: Color| [c.r, c.g, c.b].map(srgb_to_linear);
        let paper = linear(drawing.paper);
        for (plane, light) in self.light.iter_mut().zip(paper).take(channels) {
            plane[..pixels].fill(light);
        }
        for (layer, bins) in drawing.layers.iter().zip(bins) {
            let clear = &mut self.clear[..pixels];
            clear.fill(1.0);
            for i in bins.band(k) {
                stamp(&layer.dots, i, clear, self.width, top);
            }
            for (plane, ink) in self.light.iter_mut().zip(linear(layer.color)).take(channels) {
                for (p, t) in plane.iter_mut().zip(clear.iter()) {
                    *p = ink + (*p - ink) * t;
                }
            }
        }
        if channels == 1 {
            for (o, l) in out.iter_mut().zip(&self.light[0]) {
                *o = encoder.encode(*l);
            }
        } else {
            for (i, o) in out.chunks_exact_mut(3).enumerate() {
                for (sample, plane) in o.iter_mut().zip(&self.light) {
                    *sample = encoder.encode(plane[i]);
                }
            }
        }
    }

    fn channels_of(&self, drawing: &Drawing) -> usize {
        if drawing.paper.is_grey() && drawing.layers.iter().all(|l| l.color.is_grey()) { 1 } else { 3 }
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

/// Multiplies what shows through by what dot `i` leaves clear.
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
