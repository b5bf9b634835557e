//! What is hidden for certain, found at a glance: small triangles that lie behind surfaces that cover all pixels around.
//!
//! Most of the contours of a rough surface lie behind its own front. Where everything within some pixels of a triangle
//! shows something nearer, no line through it is drawn and no gap reaches into it, so tracing it is of no use. The
//! farthest of all nearest surfaces, in small squares of pixels and in the squares around, tells (a level of the
//! hierarchical depth buffer of Greene et al. 1993).

use dotwork_drawing::View;
use glam::Vec3;

use crate::depth::{DepthBuffer, LINE_BIAS, nearness_and_pixel};

/// Side of a square, pixels.
const SQUARE: usize = 2;

/// Largest distance of a triangle's corners from its centre, pixels and pixels' widths of depth.
const LARGEST: f32 = 1.5;

/// For each square of a depth buffer the farthest of all nearest surfaces around it. Memory is kept from frame to frame.
#[derive(Default)]
pub(crate) struct Covered {
    columns: usize,
    rows: usize,
    farthest: Vec<f32>,
    /// The same before looking around.
    own: Vec<f32>,
}

impl Covered {
    /// Looks at a buffer, for triangles that have to be `margin` pixels away from all that can be seen.
    pub fn look(&mut self, depth: &DepthBuffer, margin: f32) {
        let (width, height) = depth.size();
        (self.columns, self.rows) = (width.div_ceil(SQUARE), height.div_ceil(SQUARE));
        self.own.clear();
        self.own.resize(self.columns * self.rows, f32::MAX);
        for y in 0..height {
            let squares = &mut self.own[y / SQUARE * self.columns..][..self.columns];
            for (x, nearness) in depth.row(y).enumerate() {
                let square = &mut squares[x / SQUARE];
                *square = square.min(nearness);
            }
        }
        // A corner may lie LARGEST away from the centre, and the centre at its square's edge.
        let around = ((margin + LARGEST) / SQUARE as f32).ceil() as usize;
        self.farthest.clear();
        self.farthest.resize(self.own.len(), 0.0);
        // Along rows and then along columns. Beyond the page nothing is seen, so it covers.
        for y in 0..self.rows {
            let row = y * self.columns;
            for x in 0..self.columns {
                let window = x.saturating_sub(around)..(x + around + 1).min(self.columns);
                self.farthest[row + x] = self.own[row..][window].iter().copied().fold(f32::MAX, f32::min);
            }
        }
        std::mem::swap(&mut self.own, &mut self.farthest);
        for y in 0..self.rows {
            let window = y.saturating_sub(around)..(y + around + 1).min(self.rows);
            let out = &mut self.farthest[y * self.columns..][..self.columns];
            out.fill(f32::MAX);
            for other in window {
                let row = &self.own[other * self.columns..][..self.columns];
                out.iter_mut().zip(row).for_each(|(a, &b)| *a = a.min(b));
            }
        }
    }

    /// Whether a triangle is small and hidden for certain.
    #[inline(always)]
    pub fn hides(&self, view: &View, corners: [Vec3; 3]) -> bool {
        let center = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
        let (x, y, depth) = view.project(center);
        if !(x >= 0.0 && y >= 0.0) {
            return false;
        }
        let (column, row) = (x as usize / SQUARE, y as usize / SQUARE);
        if column >= self.columns || row >= self.rows {
            return false;
        }
        let (nearness, px) = nearness_and_pixel(view, depth);
        if self.farthest[row * self.columns + column] <= nearness + (LINE_BIAS + LARGEST) * px {
            return false;
        }
        let largest = LARGEST / view.px_per_unit(depth);
        corners.iter().all(|&c| (c - center).length_squared() < largest * largest)
    }
}

#[cfg(test)]
mod tests {
    use dotwork_drawing::{Camera, Page, Warnings};
    use dotwork_mesh::{Mesh, MeshOptions, shapes};

    use super::*;

    #[test]
    fn around_what_is_covered_every_line_is_hidden() {
        let torus = shapes::torus(1.0, 0.45, 900, 450);
        let mesh = Mesh::build(torus, &MeshOptions::default(), &mut Warnings::new()).unwrap();
        let page = Page::pixels(200, 150).unwrap();
        let margin = 6.0;
        for ortho in [false, true] {
            let camera = Camera { elevation: 20.0, ortho, ..Camera::default() };
            let view = camera.view(Vec3::ZERO, 1.45, &page);
            let mut depth = DepthBuffer::default();
            depth.clear(page.width, page.height);
            depth.draw(&mesh, &view, false);
            let mut covered = Covered::default();
            covered.look(&depth, margin);
            let mut hidden = 0;
            for (t, triangle) in mesh.triangles.iter().enumerate() {
                let corners = triangle.map(|v| mesh.positions[v as usize]);
                if !covered.hides(&view, corners) {
                    continue;
                }
                hidden += 1;
                if t % 16 > 0 {
                    continue;
                }
                for corner in corners {
                    let (x, y, z) = view.project(corner);
                    let steps = -margin as i32..=margin as i32;
                    for (dx, dy) in steps.clone().flat_map(|dx| steps.clone().map(move |dy| (dx, dy))) {
                        let at = [x + dx as f32, y + dy as f32];
                        assert!(depth.hides_line(&view, at, z, [0.0; 2], 0.0), "{at:?}");
                    }
                }
            }
            // About half of a torus seen aslant lies behind the other half, but for a strip along its outline.
            let share = hidden as f32 / mesh.triangles.len() as f32;
            assert!(share > 0.2 && share < 0.6, "{share}");
        }
    }
}
