//! Filled surfaces: what is seen of an object as a picture under its dots and lines.
//!
//! The page is looked at with 16 samples a pixel, in bands of rows, each with a buffer of its own: at every sample the
//! nearest triangle of all that hides. Triangles are drawn in their order and a later one must be nearer, so the result
//! does not depend on threads. A pixel's colour is the mean of its samples', its opacity their number.
//!
//! Pictures lie one upon the other, and where two objects meet in a pixel the lower one must give what the upper one
//! leaves of it: with the shares `c` of a pixel and opacities `o`, a picture has the opacity `o c / (1 - sum of o c above)`
//! there, and together they are the mean of what the samples show. No paper shines through the seam.

use std::ops::Range;

use dotwork_drawing::{Image, Projection, View};
use dotwork_ink::{Fill, Role, Style, Visibility};
use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

use crate::backend::{Frame, Subject};
use crate::select::two_sided;

/// Samples along a side of a pixel.
const SIDE: usize = 4;
const EACH: f32 = 1.0 / (SIDE * SIDE) as f32;

/// Rows of pixels in a band.
const ROWS: usize = 16;

/// What surfaces are filled with that have no colours, where the ink is black: light grey, linear.
const PLAIN: f32 = 0.6;

/// The pictures of the subjects that are filled, by their numbers, from bottom to top.
pub(crate) fn fills(frame: &Frame) -> Vec<(usize, Image)> {
    let filled = |s: &Subject| s.style.fill != Fill::None && s.style.fill_opacity > 0.0;
    if !frame.subjects.iter().any(filled) {
        return Vec::new();
    }
    // What hides takes part in one picture of all; each of the others has one of its own above, and is hidden by it.
    let hides = |s: &Subject| {
        s.style.visibility == Visibility::Solid && s.style.occlusion >= 1.0 && s.style.role != Role::Context
    };
    let all = || 0..frame.subjects.len();
    let opaque: Vec<usize> = all().filter(|&k| hides(&frame.subjects[k])).collect();
    let mut pictures = Scan::new(frame, &opaque).pictures(|k| filled(&frame.subjects[k]));
    let mut others: Vec<usize> =
        all().filter(|&k| filled(&frame.subjects[k]) && !hides(&frame.subjects[k])).collect();
    // The farthest first.
    let depth = |&k: &usize| {
        let center = frame.subjects[k].mesh.bounding_sphere().0;
        (center - frame.view.eye).dot(-frame.view.back)
    };
    others.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
    for k in others {
        let with = [&opaque[..], &[k]].concat();
        pictures.extend(Scan::new(frame, &with).pictures(|other| other == k));
    }
    pictures
}

/// A projected corner.
#[derive(Clone, Copy)]
struct Corner {
    x: f32,
    y: f32,
    nearness: f32,
}

/// Surfaces, ready to be drawn.
struct Scan<'a> {
    frame: &'a Frame<'a>,
    surfaces: Vec<Surface<'a>>,
    /// For each band, the triangles that reach it: surface and number.
    bands: Vec<Vec<(u32, u32)>>,
}

struct Surface<'a> {
    subject: usize,
    mesh: &'a Mesh,
    corners: Vec<Corner>,
}

/// The samples of a band.
struct Samples {
    nearness: Vec<f32>,
    /// Surface and triangle.
    seen: Vec<(u32, u32)>,
}

/// The nearest surface at a sample; none.
const NOTHING: (u32, u32) = (u32::MAX, 0);

impl<'a> Scan<'a> {
    fn new(frame: &'a Frame, subjects: &[usize]) -> Scan<'a> {
        let view = frame.view;
        let corner = |&p: &Vec3| {
            let (x, y, depth) = view.project(p);
            let nearness = match view.projection {
                Projection::Perspective { .. } => 1.0 / depth,
                Projection::Parallel { .. } => view.distance + 2.0 * view.radius - depth,
            };
            Corner { x, y, nearness }
        };
        let surfaces: Vec<Surface> = subjects
            .iter()
            .map(|&subject| {
                let mesh = &**frame.subjects[subject].mesh;
                Surface { subject, mesh, corners: mesh.positions.par_iter().map(corner).collect() }
            })
            .collect();
        let height = frame.page.height as usize;
        let mut bands = vec![Vec::new(); height.div_ceil(ROWS)];
        for (s, surface) in surfaces.iter().enumerate() {
            let subject = &frame.subjects[surface.subject];
            let culled = surface.mesh.closed && !two_sided(subject.style, true);
            for t in 0..surface.mesh.triangles.len() {
                let [a, b, c] = surface.triangle(t);
                let area = area(a, b, c);
                let finite = area.is_finite() && [a, b, c].iter().all(|c| c.nearness.is_finite());
                // On the page y points down: triangles that face the eye have a negative area.
                if !finite || area == 0.0 || (culled && area > 0.0) {
                    continue;
                }
                let (top, bottom) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
                if bottom < 0.0 || top >= height as f32 {
                    continue;
                }
                let last = (bottom as usize / ROWS).min(bands.len() - 1);
                for band in &mut bands[top.max(0.0) as usize / ROWS..=last] {
                    band.push((s as u32, t as u32));
                }
            }
        }
        Scan { frame, surfaces, bands }
    }

    /// The pictures of the subjects that `filled` names.
    fn pictures(&self, filled: impl Fn(usize) -> bool) -> Vec<(usize, Image)> {
        let (width, height) = (self.frame.page.width as usize, self.frame.page.height as usize);
        let painted: Vec<usize> =
            (0..self.surfaces.len()).filter(|&s| filled(self.surfaces[s].subject)).collect();
        let mut planes: Vec<Plane> =
            painted.iter().map(|&s| Plane::around(&self.surfaces[s].corners, width, height)).collect();
        let mut bands: Vec<Vec<Part>> = self.bands.iter().map(|_| Vec::new()).collect();
        for plane in &mut planes {
            let Plane { columns, rows, samples } = plane;
            let mut rest = &mut samples[..];
            for (k, band) in bands.iter_mut().enumerate() {
                let rows =
                    (k * ROWS).clamp(rows.start, rows.end)..((k + 1) * ROWS).clamp(rows.start, rows.end);
                let (part, after) = rest.split_at_mut(rows.len() * columns.len());
                rest = after;
                band.push(Part { columns: columns.clone(), rows, samples: part });
            }
        }
        bands.par_iter_mut().enumerate().for_each(|(band, planes)| {
            if !self.bands[band].is_empty() {
                self.resolve(band, &painted, planes);
            }
        });
        let margin = self.frame.page.margin_px;
        let image = |(plane, s): (Plane, &usize)| {
            Some((self.surfaces[*s].subject, plane.cropped(width, height, margin)?))
        };
        planes.into_iter().zip(&painted).filter_map(image).collect()
    }

    /// Draws a band, and puts what is seen of the surfaces `painted` into its rows of their planes.
    fn resolve(&self, band: usize, painted: &[usize], planes: &mut [Part]) {
        let [width, height] = [self.frame.page.width, self.frame.page.height].map(|v| v as usize);
        let rows = (height - band * ROWS).min(ROWS);
        let row = SIDE * width;
        let mut samples =
            Samples { nearness: vec![0.0; row * rows * SIDE], seen: vec![NOTHING; row * rows * SIDE] };
        let top = band * ROWS;
        for &(s, t) in &self.bands[band] {
            samples.draw(self.surfaces[s as usize].triangle(t as usize), (s, t), row, top * SIDE);
        }
        let plane_of: Vec<Option<usize>> =
            (0..self.surfaces.len()).map(|s| painted.iter().position(|&p| p == s)).collect();
        // The sum of a pixel's samples, for each plane; opacity stands last.
        let mut sums = vec![[0.0f32; 4]; painted.len()];
        for y in 0..rows {
            for x in 0..width {
                let mut any = false;
                for k in 0..SIDE * SIDE {
                    let (i, j) = (SIDE * x + k % SIDE, SIDE * y + k / SIDE);
                    let (s, t) = samples.seen[j * row + i];
                    if s == u32::MAX {
                        continue;
                    }
                    if let Some(plane) = plane_of[s as usize] {
                        let color = self.color(s as usize, t as usize, [i, j + top * SIDE]);
                        (0..4).for_each(|c| sums[plane][c] += EACH * color[c]);
                        any = true;
                    }
                }
                if !any {
                    continue;
                }
                let mut above = 0.0;
                for (plane, sum) in planes.iter_mut().zip(&mut sums).rev() {
                    let left: f32 = 1.0 - above;
                    above += sum[3];
                    if sum[3] > 0.0 {
                        let scale = if left > 1e-4 { 1.0 / left } else { 1.0 };
                        plane.set(x, top + y, sum.map(|c| (c * scale).min(1.0)));
                        *sum = [0.0; 4];
                    }
                }
            }
        }
    }

    /// The colour of a triangle at a sample of the page, linear and premultiplied.
    #[inline]
    fn color(&self, s: usize, t: usize, [i, j]: [usize; 2]) -> [f32; 4] {
        let surface = &self.surfaces[s];
        let Subject { style, mesh, .. } = &self.frame.subjects[surface.subject];
        let corners = surface.triangle(t);
        let [_, v, w] = weights(self.frame.view, corners, sample_at(i, j));
        let mut color = base(style, mesh, t, [v, w]);
        if style.fill_shade > 0.0 {
            let [a, b, c] = mesh.corner_normals[t].map(|n| mesh.normals[n as usize]);
            let normal = (a * (1.0 - v - w) + b * v + c * w).normalize_or_zero();
            // What is seen from behind is lit there.
            let front = area(corners[0], corners[1], corners[2]) < 0.0;
            let n_dot_l = if front { normal } else { -normal }.dot(self.frame.light);
            let lit = ((n_dot_l + style.wrap) / (1.0 + style.wrap)).clamp(0.0, 1.0);
            let share = 1.0 - style.fill_shade * (1.0 - lit);
            (0..3).for_each(|k| color[k] *= share);
        }
        let opacity = color[3] * style.fill_opacity;
        [color[0] * opacity, color[1] * opacity, color[2] * opacity, opacity]
    }
}

/// The colour that a surface is filled with at a place, before it is shaded: linear, not premultiplied.
fn base(style: &Style, mesh: &Mesh, triangle: usize, weights: [f32; 2]) -> [f32; 4] {
    let flat = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
    match style.fill {
        Fill::Color(color) => flat(color.to_linear()),
        _ if mesh.is_colored() => mesh.color_at(triangle, weights),
        _ if style.color != dotwork_drawing::Color::BLACK => flat(style.color.to_linear()),
        _ => flat([PLAIN; 3]),
    }
}

impl Surface<'_> {
    #[inline(always)]
    fn triangle(&self, t: usize) -> [Corner; 3] {
        self.mesh.triangles[t].map(|v| self.corners[v as usize])
    }
}

/// Twice the area on the page.
#[inline(always)]
fn area(a: Corner, b: Corner, c: Corner) -> f32 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Where a sample lies, pixels.
#[inline(always)]
fn sample_at(i: usize, j: usize) -> [f32; 2] {
    [i, j].map(|k| (k as f32 + 0.5) / SIDE as f32)
}

/// Weights of the corners on the surface at a place of the page.
#[inline]
fn weights(view: &View, [a, b, c]: [Corner; 3], [x, y]: [f32; 2]) -> [f32; 3] {
    let inverse = 1.0 / area(a, b, c);
    let p = Corner { x, y, nearness: 0.0 };
    // A sample at an edge may lie outside by rounding.
    let (v, w) = ((area(a, p, c) * inverse).clamp(0.0, 1.0), (area(a, b, p) * inverse).clamp(0.0, 1.0));
    let u = (1.0 - v - w).max(0.0);
    let weights = match view.projection {
        Projection::Parallel { .. } => [u, v, w],
        // On the page the weights over depth are linear.
        Projection::Perspective { .. } => [u * a.nearness, v * b.nearness, w * c.nearness],
    };
    let sum: f32 = weights.iter().sum();
    weights.map(|k| k / sum)
}

impl Samples {
    /// Draws a triangle into rows of `row` samples, the first of which is row `top` of the page.
    fn draw(&mut self, [a, b, c]: [Corner; 3], which: (u32, u32), row: usize, top: usize) {
        let rows = self.nearness.len() / row;
        let inverse = 1.0 / area(a, b, c);
        let (bx, by) = ((c.y - a.y) * inverse, (a.x - c.x) * inverse);
        let (cx, cy) = ((a.y - b.y) * inverse, (b.x - a.x) * inverse);
        let cells = |low: f32, high: f32, from: usize, count: usize| {
            // Casts leave what is outside at the ends.
            let at =
                |v: f32| ((v * SIDE as f32 - 0.5).ceil().max(0.0) as usize).saturating_sub(from).min(count);
            (at(low), (at(high) + 1).min(count))
        };
        let (x0, x1) = cells(a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x), 0, row);
        let (y0, y1) = cells(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y), top, rows);
        for j in y0..y1 {
            for i in x0..x1 {
                let [x, y] = sample_at(i, j + top);
                let (dx, dy) = (x - a.x, y - a.y);
                let (v, w) = (bx * dx + by * dy, cx * dx + cy * dy);
                // Edges belong to both of their triangles, with a little to spare for rounding: no gaps.
                if v >= -1e-5 && w >= -1e-5 && v + w <= 1.00002 {
                    let nearness = a.nearness + v * (b.nearness - a.nearness) + w * (c.nearness - a.nearness);
                    if nearness > self.nearness[j * row + i] {
                        self.nearness[j * row + i] = nearness;
                        self.seen[j * row + i] = which;
                    }
                }
            }
        }
    }
}

/// The part of the page on which a surface may be seen.
struct Plane {
    columns: Range<usize>,
    rows: Range<usize>,
    samples: Vec<[f32; 4]>,
}

/// Some rows of a plane.
struct Part<'a> {
    columns: Range<usize>,
    rows: Range<usize>,
    samples: &'a mut [[f32; 4]],
}

impl Part<'_> {
    /// Sets a pixel of the page; one outside is left out.
    #[inline]
    fn set(&mut self, x: usize, y: usize, color: [f32; 4]) {
        if self.columns.contains(&x) && self.rows.contains(&y) {
            let width = self.columns.len();
            self.samples[(y - self.rows.start) * width + x - self.columns.start] = color;
        }
    }
}

impl Plane {
    fn around(corners: &[Corner], width: usize, height: usize) -> Plane {
        let along = |at: fn(&Corner) -> f32, end: usize| {
            let (low, high) =
                corners.iter().map(at).fold((f32::INFINITY, 0.0f32), |(l, h), v| (l.min(v), h.max(v)));
            // Casts leave what is outside at the ends.
            let (low, high) =
                (((low - 1.0).floor() as usize).min(end), ((high + 1.0).ceil() as usize).min(end));
            low..high.max(low)
        };
        let (columns, rows) = (along(|c| c.x, width), along(|c| c.y, height));
        let samples = vec![[0.0; 4]; columns.len() * rows.len()];
        Plane { columns, rows, samples }
    }

    /// The part that is not clear and lies within the margins of a page; `None` if all is clear.
    fn cropped(&self, width: usize, height: usize, margin: f32) -> Option<Image> {
        let margin = margin.max(0.0).round() as usize;
        let within =
            |r: &Range<usize>, end: usize| r.start.max(margin)..r.end.min(end.saturating_sub(margin));
        let (columns, rows) = (within(&self.columns, width), within(&self.rows, height));
        let at = |x: usize, y: usize| {
            self.samples[(y - self.rows.start) * self.columns.len() + x - self.columns.start]
        };
        let (mut low, mut high) = ([usize::MAX; 2], [0usize; 2]);
        for y in rows {
            let mut seen = columns.clone().filter(|&x| at(x, y)[3] > 0.0);
            if let Some(first) = seen.next() {
                let last = seen.next_back().unwrap_or(first);
                low = [low[0].min(first), low[1].min(y)];
                high = [high[0].max(last + 1), y + 1];
            }
        }
        if low[0] >= high[0] {
            return None;
        }
        let samples = (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| at(x, y)));
        Some(Image {
            width: (high[0] - low[0]) as u32,
            height: (high[1] - low[1]) as u32,
            place: [low[0], low[1], high[0], high[1]].map(|v| v as f32),
            samples: samples.collect(),
        })
    }
}
