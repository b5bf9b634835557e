//! The depth prepass: which surface is nearest at each pixel centre.
//!
//! The buffer stores *nearness*, a positive quantity that is linear over the page for every plane and grows towards
//! the eye: `1 / depth` under perspective, a constant less the depth in parallel projection. The nearest of all
//! surfaces does not depend on their order, so threads draw into one buffer by atomic maximum. A place on a surface is
//! compared with what its own tangent plane says at the pixel's centre, so slopes need no large bias.

use dotwork_drawing::{Projection, View};
use dotwork_mesh::Mesh;
use glam::Vec3;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use rayon::prelude::*;

/// Triangles a task draws.
const CHUNK: usize = 1024;

/// Nearest surfaces of a frame, one value a pixel.
#[derive(Default)]
pub struct DepthBuffer {
    width: usize,
    height: usize,
    /// Nearness of the nearest surface as the bits of an `f32`, 0 where there is none; row by row.
    nearness: Vec<AtomicU32>,
    /// Projected vertices of the mesh at work.
    projected: Vec<Vertex>,
}

/// A projected vertex, in 16 bytes.
#[derive(Clone, Copy)]
#[repr(align(16))]
struct Vertex {
    /// Pixels from the left and from the top.
    x: f32,
    y: f32,
    nearness: f32,
    /// First pixel whose centre is not left of (above) the vertex, or the page's first or one past its last.
    column: u16,
    row: u16,
}

// Sides of pages fit.
const _: () = assert!(dotwork_drawing::MAX_SIDE_PX <= u16::MAX as u32);

impl Vertex {
    #[inline(always)]
    fn new(view: &View, p: Vec3, [width, height]: [f32; 2]) -> Vertex {
        let (x, y, depth) = view.project(p);
        // `ceil(v − 0.5)` within the page, without a call; what is not a number lands at 0.
        let cell = |v: f32, last: f32| {
            let v = (v + 0.5).max(0.0).min(last);
            let i = v as i32;
            (i - i32::from(i as f32 == v)).max(0) as u16
        };
        let (column, row) = (cell(x, width + 0.5), cell(y, height + 0.5));
        Vertex { x, y, nearness: nearness(view, depth), column, row }
    }
}

/// The least and the largest.
#[inline(always)]
fn range(a: u16, b: u16, c: u16) -> [u16; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}

/// Twice the area on the page. Its y points down: triangles that face the eye have a negative one.
#[inline(always)]
fn area(a: &Vertex, b: &Vertex, c: &Vertex) -> f32 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Whether pixel centres lie between the vertices' sides, and the triangle is neither seen edge on nor left out for
/// facing away.
#[inline(always)]
fn may_cover([a, b, c]: [&Vertex; 3], cull_back: bool) -> bool {
    let [x0, x1] = range(a.column, b.column, c.column);
    let [y0, y1] = range(a.row, b.row, c.row);
    let area = area(a, b, c);
    (x0 < x1) & (y0 < y1) & ((area < 0.0) | ((area > 0.0) & !cull_back))
}

/// Nearness of a depth, and how much of it a pixel's width of depth is there.
#[inline(always)]
pub(crate) fn nearness_and_pixel(view: &View, depth: f32) -> (f32, f32) {
    match view.projection {
        Projection::Perspective { focal_px } => (1.0 / depth, 1.0 / (depth * focal_px)),
        Projection::Parallel { px_per_unit } => (nearness(view, depth), 1.0 / px_per_unit),
    }
}

/// Nearness of a depth.
#[inline(always)]
fn nearness(view: &View, depth: f32) -> f32 {
    match view.projection {
        Projection::Perspective { .. } => 1.0 / depth,
        Projection::Parallel { .. } => view.distance + 2.0 * view.radius - depth,
    }
}

impl DepthBuffer {
    /// Empties the buffer for a page of `width` × `height` pixels; memory is kept.
    pub fn clear(&mut self, width: u32, height: u32) {
        (self.width, self.height) = (width as usize, height as usize);
        self.nearness.resize_with(self.width * self.height, AtomicU32::default);
        self.nearness.par_iter_mut().with_min_len(1 << 16).for_each(|q| *q.get_mut() = 0);
    }

    /// Width and height, pixels.
    pub(crate) fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The nearness in each pixel of a row, 0 where there is no surface.
    pub(crate) fn row(&self, y: usize) -> impl Iterator<Item = f32> {
        let row = &self.nearness[y * self.width..][..self.width];
        row.iter().map(|q| f32::from_bits(q.load(Relaxed)))
    }

    /// Draws a mesh. `cull_back` leaves out triangles that face away, which a closed surface never shows.
    ///
    /// The eye lies outside the bounding sphere ([`dotwork_drawing::Camera`] sees to it), so nothing is clipped at
    /// the eye plane.
    pub fn draw(&mut self, mesh: &Mesh, view: &View, cull_back: bool) {
        let size = [self.width as f32, self.height as f32];
        mesh.positions
            .par_iter()
            .with_min_len(4096)
            .map(|&p| Vertex::new(view, p, size))
            .collect_into_vec(&mut self.projected);
        let corners = |triangle: &[u32; 3]| triangle.map(|v| &self.projected[v as usize]);
        mesh.triangles.par_chunks(CHUNK).for_each(|triangles| {
            // Most triangles of a fine mesh lie between pixel centres or face away, in no order that could be foreseen:
            // writing each number and keeping some beats a branch.
            let mut drawn = [0u16; CHUNK + 1];
            let mut count = 0;
            for (i, triangle) in triangles.iter().enumerate() {
                drawn[count] = i as u16;
                count += usize::from(may_cover(corners(triangle), cull_back));
            }
            for &i in &drawn[..count] {
                self.fill(corners(&triangles[i as usize]));
            }
        });
    }

    /// Raises the buffer to a triangle's nearness wherever it covers a pixel's centre.
    #[inline(always)]
    fn fill(&self, [a, b, c]: [&Vertex; 3]) {
        let [x0, x1] = range(a.column, b.column, c.column).map(usize::from);
        let [y0, y1] = range(a.row, b.row, c.row).map(usize::from);
        let area = area(a, b, c);
        let inverse = 1.0 / area;
        // Weights of b and c at a page position, as linear functions relative to a.
        let (bx, by) = ((c.y - a.y) * inverse, (a.x - c.x) * inverse);
        let (cx, cy) = ((a.y - b.y) * inverse, (b.x - a.x) * inverse);
        let (qb, qc) = (b.nearness - a.nearness, c.nearness - a.nearness);
        let dx0 = x0 as f32 + 0.5 - a.x;
        for y in y0..y1 {
            let dy = y as f32 + 0.5 - a.y;
            let (wb0, wc0) = (bx * dx0 + by * dy, cx * dx0 + cy * dy);
            for (i, q) in self.nearness[y * self.width + x0..y * self.width + x1].iter().enumerate() {
                let wb = wb0 + bx * i as f32;
                let wc = wc0 + cx * i as f32;
                // Edges belong to both of their triangles, with a little to spare for rounding: no gaps.
                if wb >= -1e-5 && wc >= -1e-5 && wb + wc <= 1.00002 {
                    // Positive floats are ordered as their bits.
                    let nearness = (a.nearness + wb * qb + wc * qc).to_bits();
                    if nearness > q.load(Relaxed) {
                        q.fetch_max(nearness, Relaxed);
                    }
                }
            }
        }
    }

    /// True if a place on a surface is hidden by something nearer.
    ///
    /// `x`, `y`, `depth`: the place as projected, on the page; `facet`: the unit normal of its facet, at a cosine of at
    /// least 0.05 to the eye (in absolute value), and the place minus the eye; asked for only where they matter.
    #[inline(always)]
    pub fn hides(
        &self,
        view: &View,
        x: f32,
        y: f32,
        depth: f32,
        facet: impl FnOnce() -> (Vec3, Vec3),
    ) -> bool {
        // The four pixel centres around the place; at the page's edge some of them are the same.
        let gx = (x - 0.5).max(0.0).min(self.width as f32 - 1.0);
        let gy = (y - 0.5).max(0.0).min(self.height as f32 - 1.0);
        let (column, row) = (gx as i32 as usize, gy as i32 as usize);
        let (right, below) =
            (usize::from(column + 1 < self.width), usize::from(row + 1 < self.height) * self.width);
        let first = row * self.width + column;
        let at = [first, first + right, first + below, first + below + right]
            .map(|i| f32::from_bits(self.nearness[i].load(Relaxed)));
        // Nearness at the place, and what a pixel's width of depth is worth there.
        let (q, px) = nearness_and_pixel(view, depth);
        // No tangent plane differs by more over these pixels: what lies beyond is decided without it.
        let far = STEEPEST * px;
        let (low, high) = (at[0].min(at[1]).min(at[2].min(at[3])), at[0].max(at[1]).max(at[2].max(at[3])));
        if low > q + far || high <= q - far {
            return low > q + far;
        }
        let (normal, from_eye) = facet();
        // How the tangent plane's nearness changes over the page, and the cosine to the eye; both are the same for a
        // normal and its opposite.
        let (per_px, along) = match view.projection {
            Projection::Perspective { focal_px } => {
                let k = normal.dot(from_eye);
                (1.0 / (focal_px * k), (k * q).abs())
            }
            Projection::Parallel { px_per_unit } => {
                let back = normal.dot(view.back);
                (-1.0 / (px_per_unit * back), back.abs())
            }
        };
        let (slope_x, slope_y) = (normal.dot(view.right) * per_px, -normal.dot(view.up) * per_px);
        // Curvature within a pixel: a share of a pixel's width, more where the surface is steep.
        let slope = ((1.0 - along * along).max(0.0).sqrt() / along.max(1e-3)).min(MAX_SLOPE);
        let bias = (0.25 + 0.35 * slope) * px;
        // Weighted as by linear interpolation, so that the edge of what hides moves smoothly between the centres.
        let (dx, dy) = (column as f32 + 0.5 - x, row as f32 + 0.5 - y);
        let (tx, ty) = ((-dx).clamp(0.0, 1.0), (-dy).clamp(0.0, 1.0));
        let plane = q + bias + dx * slope_x + dy * slope_y;
        let planes = [plane, plane + slope_x, plane + slope_y, plane + slope_x + slope_y];
        let weights = [(1.0 - tx) * (1.0 - ty), tx * (1.0 - ty), (1.0 - tx) * ty, tx * ty];
        let mut hidden = 0.0;
        for k in 0..4 {
            hidden += if at[k] > planes[k] { weights[k] } else { 0.0 };
        }
        hidden > 0.5
    }

    /// The share of the four pixel centres around a place, as by linear interpolation, at which a surface lies behind it.
    #[inline]
    pub fn covers_behind(&self, view: &View, x: f32, y: f32, depth: f32) -> f32 {
        let gx = (x - 0.5).max(0.0).min(self.width as f32 - 1.0);
        let gy = (y - 0.5).max(0.0).min(self.height as f32 - 1.0);
        let (column, row) = (gx as usize, gy as usize);
        let (tx, ty) = (gx - column as f32, gy - row as f32);
        let (right, below) = ((column + 1).min(self.width - 1), (row + 1).min(self.height - 1));
        let near = nearness(view, depth);
        let behind = |c: usize, r: usize| {
            let q = f32::from_bits(self.nearness[r * self.width + c].load(Relaxed));
            if q > 0.0 && q < near { 1.0 } else { 0.0 }
        };
        let top = behind(column, row) * (1.0 - tx) + behind(right, row) * tx;
        let bottom = behind(column, below) * (1.0 - tx) + behind(right, below) * tx;
        top * (1.0 - ty) + bottom * ty
    }

    /// True if a place on an outline is hidden: if there is something nearer at all nine pixel centres around it and
    /// at all pixels up to `reach` pixels `outwards`, a direction on the page. Along an outline the pixels on its one
    /// side show the line's own surface and on the other what lies behind; where the mesh is coarse, a bit further out.
    #[inline]
    pub fn hides_line(
        &self,
        view: &View,
        [x, y]: [f32; 2],
        depth: f32,
        outwards: [f32; 2],
        reach: f32,
    ) -> bool {
        let (w, h) = (self.width as i32, self.height as i32);
        let at = |c: i32, r: i32| f32::from_bits(self.nearness[(r * w + c) as usize].load(Relaxed));
        let (q, px) = nearness_and_pixel(view, depth);
        let nearest = q + LINE_BIAS * px;
        let (column, row) = (x as i32, y as i32);
        for r in (row - 1).max(0)..(row + 2).min(h) {
            for c in (column - 1).max(0)..(column + 2).min(w) {
                if at(c, r) <= nearest {
                    return false;
                }
            }
        }
        // What lies beyond the page hides nothing.
        (2..=reach as i32).map(|k| k as f32).all(|k| {
            let (c, r) = ((x + outwards[0] * k).floor() as i32, (y + outwards[1] * k).floor() as i32);
            c >= 0 && c < w && r >= 0 && r < h && at(c, r) > nearest
        })
    }
}

/// How much nearer than a line a surface has to be to hide it, in pixels' widths of depth: more than the line's own
/// surface is off between pixel centres.
pub(crate) const LINE_BIAS: f32 = 3.0;

/// Below this cosine to the eye no dots are drawn: the outline carries the rim.
pub(crate) const GRAZING: f32 = 0.05;

/// Slope beyond which the bias does not grow: it is meant for curvature within a pixel.
const MAX_SLOPE: f32 = 6.0;

/// Largest difference, in pixels' widths of depth, between a place and its tangent plane at a neighbouring pixel's
/// centre, bias included: a slope of 1/[`GRAZING`] along a pixel's diagonal, and a fifth for perspective.
const STEEPEST: f32 = 1.2 * 1.415 / GRAZING + 0.25 + 0.35 * MAX_SLOPE;

#[cfg(test)]
mod tests {
    use dotwork_drawing::hash::{hash3, unit};
    use dotwork_drawing::{Camera, Page};

    use super::*;

    /// [`DepthBuffer::hides`] for a place whose four pixel centres are all on the page, always by the tangent plane;
    /// `None` where rounding decides.
    fn hidden_by_plane(
        view: &View,
        [x, y, depth]: [f32; 3],
        normal: Vec3,
        from_eye: Vec3,
        at: [f32; 4],
    ) -> Option<bool> {
        let (column, row) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (tx, ty) = (x - 0.5 - column, y - 0.5 - row);
        let along =
            if view.is_parallel() { normal.dot(view.back) } else { normal.dot(from_eye) / depth }.abs();
        let bias = 0.25 + 0.35 * ((1.0 - along * along).max(0.0).sqrt() / along).min(6.0);
        let (mut least, mut most) = (0.0, 0.0);
        for (k, at) in at.into_iter().enumerate() {
            let (right, below) = ((k % 2) as f32, (k / 2) as f32);
            let center = [column + right + 0.5, row + below + 0.5];
            // Where the line of sight through the centre meets the plane.
            let unit = view.px_per_unit(1.0);
            let on_image =
                view.right * ((center[0] - view.cx) / unit) - view.up * ((center[1] - view.cy) / unit);
            let there = if view.is_parallel() {
                let off = on_image - view.right * from_eye.dot(view.right) - view.up * from_eye.dot(view.up);
                nearness(view, depth + off.dot(normal) / view.back.dot(normal))
            } else {
                (on_image - view.back).dot(normal) / from_eye.dot(normal)
            };
            let px = if view.is_parallel() { 1.0 / unit } else { 1.0 / (depth * unit) };
            let weight = if k % 2 == 1 { tx } else { 1.0 - tx } * if k / 2 == 1 { ty } else { 1.0 - ty };
            least += if at > there + (bias + 0.01) * px { weight } else { 0.0 };
            most += if at > there + (bias - 0.01) * px { weight } else { 0.0 };
        }
        if least > 0.501 {
            Some(true)
        } else if most < 0.499 {
            Some(false)
        } else {
            None
        }
    }

    #[test]
    fn early_decisions_are_those_of_the_tangent_plane() {
        let page = Page::pixels(200, 200).unwrap();
        let (mut certain, mut hidden, mut tried) = (0, 0, 0);
        for ortho in [false, true] {
            let view = Camera { ortho, ..Camera::default() }.view(Vec3::ZERO, 1.0, &page);
            let mut buffer = DepthBuffer::default();
            buffer.clear(page.width, page.height);
            for i in 0..20_000u32 {
                let random = |k: u32| unit(hash3(i, k, 7)) * 2.0 - 1.0;
                let normal = Vec3::new(random(0), random(1), random(2)).normalize_or(Vec3::X);
                let p = Vec3::new(random(3), random(4), random(5)) * 0.5;
                let (x, y, depth) = view.project(p);
                if normal.dot(view.to_eye(p)).abs() < GRAZING {
                    continue;
                }
                let first = (y - 0.5) as usize * 200 + (x - 0.5) as usize;
                let px = 1.0 / view.px_per_unit(depth);
                // From within the bias to far beyond any slope.
                let reach = px * [1.0, 20.0, 100.0][i as usize % 3];
                let at = [0, 1, 200, 201].map(|k| nearness(&view, depth + reach * random(6 + k)));
                for (k, at) in [0, 1, 200, 201].into_iter().zip(at) {
                    *buffer.nearness[first + k].get_mut() = at.to_bits();
                }
                let expected = hidden_by_plane(&view, [x, y, depth], normal, p - view.eye, at);
                let got = buffer.hides(&view, x, y, depth, || (normal, p - view.eye));
                if let Some(expected) = expected {
                    assert_eq!(got, expected, "place {i}, ortho {ortho}");
                    certain += 1;
                }
                hidden += usize::from(got);
                tried += 1;
            }
        }
        assert!(tried > 30_000 && certain > tried * 9 / 10, "{certain} of {tried}");
        assert!(hidden > tried / 8 && hidden < tried / 2, "{hidden} of {tried}");
    }
}
