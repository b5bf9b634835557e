//! The depth prepass: which surface is nearest at each pixel centre.
//!
//! The buffer stores *nearness*, a quantity that is linear over the page for every plane and grows towards the eye:
//! `1 / depth` under perspective, `−depth` in parallel projection. A place on a surface is compared with what its own
//! tangent plane says at the pixel's centre, so slopes need no large bias.

use dotwork_drawing::{Projection, View};
use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

use crate::bands::{BAND_ROWS, Bins};

/// Nearest surfaces of a frame, one value a pixel.
#[derive(Default)]
pub struct DepthBuffer {
    width: usize,
    height: usize,
    /// Nearness of the nearest surface, −∞ where there is none; row by row.
    nearness: Vec<f32>,
    /// Projected vertices of the mesh at work: x, y in pixels, nearness.
    projected: Vec<[f32; 3]>,
    bins: Bins,
}

/// Nearness of a depth.
#[inline(always)]
fn nearness(view: &View, depth: f32) -> f32 {
    match view.projection {
        Projection::Perspective { .. } => 1.0 / depth,
        Projection::Parallel { .. } => -depth,
    }
}

impl DepthBuffer {
    /// Empties the buffer for a page of `width` × `height` pixels; memory is kept.
    pub fn clear(&mut self, width: u32, height: u32) {
        (self.width, self.height) = (width as usize, height as usize);
        self.nearness.clear();
        self.nearness.resize(self.width * self.height, f32::NEG_INFINITY);
    }

    /// Draws a mesh. `cull_back` leaves out triangles that face away, which a closed surface never shows.
    ///
    /// The eye lies outside the bounding sphere ([`dotwork_drawing::Camera`] sees to it), so nothing is clipped at
    /// the eye plane.
    pub fn draw(&mut self, mesh: &Mesh, view: &View, cull_back: bool) {
        mesh.positions
            .par_iter()
            .with_min_len(4096)
            .map(|&p| {
                let (x, y, depth) = view.project(p);
                [x, y, nearness(view, depth)]
            })
            .collect_into_vec(&mut self.projected);
        let (width, height) = (self.width, self.height);
        let projected = &self.projected;
        let corners = |t: usize| mesh.triangles[t].map(|v| projected[v as usize]);
        let bands = height.div_ceil(BAND_ROWS);
        self.bins.fill(mesh.triangles.len(), bands, |t| {
            let [a, b, c] = corners(t);
            // y points down: counter-clockwise triangles have negative area here.
            let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            if area == 0.0 || (cull_back && area > 0.0) {
                return None;
            }
            let (first, last) = centers(a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1]), height)?;
            centers(a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]), width)?;
            Some((first, last))
        });
        let bins = &self.bins;
        self.nearness.par_chunks_mut(width * BAND_ROWS).enumerate().for_each(|(band, rows)| {
            let top = band * BAND_ROWS;
            for t in bins.band(band) {
                fill_triangle(corners(t), rows, width, top);
            }
        });
    }

    /// True if a place on a surface is hidden by something nearer.
    ///
    /// `x`, `y`, `depth`: the place as projected; `normal`: the unit normal of its facet, towards the eye;
    /// `from_eye`: the place minus the eye. A place off the page is not hidden.
    #[inline]
    pub fn hides(&self, view: &View, x: f32, y: f32, depth: f32, normal: Vec3, from_eye: Vec3) -> bool {
        let (px, py) = (x.floor(), y.floor());
        if !(px >= 0.0 && py >= 0.0 && px < self.width as f32 && py < self.height as f32) {
            return false;
        }
        let at = self.nearness[py as usize * self.width + px as usize];
        // From the place to the centre of its pixel.
        let (dx, dy) = (px + 0.5 - x, py + 0.5 - y);
        let (right, up) = (normal.dot(view.right), normal.dot(view.up));
        // The tangent plane's nearness at the centre, and what an object unit of depth is worth there.
        let (plane, unit, px_per_unit, along) = match view.projection {
            Projection::Perspective { focal_px } => {
                let q = 1.0 / depth;
                let k = normal.dot(from_eye);
                (q + (dx * right - dy * up) / (focal_px * k), q * q, focal_px * q, -k * q)
            }
            Projection::Parallel { px_per_unit } => {
                let back = normal.dot(view.back);
                (-depth - (dx * right - dy * up) / (px_per_unit * back), 1.0, px_per_unit, back)
            }
        };
        // Curvature within a pixel: a share of a pixel's width, more where the surface is steep.
        let slope = ((1.0 - along * along).max(0.0).sqrt() / along.max(1e-3)).min(6.0);
        let bias = (0.25 + 0.35 * slope) * unit / px_per_unit;
        at > plane + bias
    }
}

/// First and last pixel of `0..size` whose centre lies in `low..=high`.
#[inline(always)]
fn centers(low: f32, high: f32, size: usize) -> Option<(usize, usize)> {
    let first = (low - 0.5).ceil().max(0.0);
    let last = (high - 0.5).floor().min(size as f32 - 1.0);
    (first <= last).then_some((first as usize, last as usize))
}

/// Raises `rows` (whose first is row `top` of the page) to a triangle's nearness wherever it covers a pixel's centre.
fn fill_triangle([a, b, c]: [[f32; 3]; 3], rows: &mut [f32], width: usize, top: usize) {
    let height = top + rows.len() / width;
    let Some((y0, y1)) = centers(a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1]), height) else { return };
    let Some((x0, x1)) = centers(a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]), width) else { return };
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let inverse = 1.0 / area;
    // Weights of b and c at a page position, as linear functions relative to a.
    let (bx, by) = ((c[1] - a[1]) * inverse, (a[0] - c[0]) * inverse);
    let (cx, cy) = ((a[1] - b[1]) * inverse, (b[0] - a[0]) * inverse);
    let (qb, qc) = (b[2] - a[2], c[2] - a[2]);
    for y in y0.max(top)..=y1 {
        let dy = y as f32 + 0.5 - a[1];
        let row = &mut rows[(y - top) * width..][x0..=x1];
        let dx0 = x0 as f32 + 0.5 - a[0];
        let (wb0, wc0) = (bx * dx0 + by * dy, cx * dx0 + cy * dy);
        for (i, q) in row.iter_mut().enumerate() {
            let wb = wb0 + bx * i as f32;
            let wc = wc0 + cx * i as f32;
            // Edges belong to both of their triangles, with a little to spare for rounding: no gaps between them.
            if wb >= -1e-5 && wc >= -1e-5 && wb + wc <= 1.00002 {
                let nearness = a[2] + wb * qb + wc * qc;
                if nearness > *q {
                    *q = nearness;
                }
            }
        }
    }
}
