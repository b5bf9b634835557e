//! Silhouettes in image space, as the paper draws them (Lu et al. 2003, section 5.6, after Raskar and Cohen 1999).
//!
//! Front faces go to the depth buffer. Then the edges of back faces are drawn, all of one width, where they are as near
//! as what the buffer shows: a front and a back face are equally near where they share an edge, which is the outline of
//! the facets. So only edges are looked at whose ends front faces have too, and each step of an edge is seen unless all
//! pixels around it show something nearer by more than the offset, a few pixels' widths of depth.

use dotwork_drawing::{Color, Image, Page, Projection, View};
use dotwork_mesh::Mesh;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::FAINTEST;
use crate::depth::DepthBuffer;
use crate::hiding::Hidden;

/// Back faces a task looks at.
const CHUNK: usize = 4096;

/// Length of a step along an edge, pixels.
const STEP: f32 = 1.0;

/// Draws silhouettes into pictures. Memory is kept from frame to frame.
#[derive(Default)]
pub(super) struct ImageDrawer {
    /// The front faces, where no buffer of the frame has them.
    front: DepthBuffer,
    /// For each vertex its place on the page and its depth.
    projected: Vec<Vec3>,
    /// For each vertex whether a front face has it.
    fronts: Vec<bool>,
    /// Whether each triangle faces the eye.
    faces: Vec<bool>,
    chunks: Vec<Vec<Piece>>,
}

/// A visible step of an edge.
#[derive(Clone, Copy)]
struct Piece {
    from: Vec2,
    to: Vec2,
    /// Opacity.
    ink: f32,
}

impl ImageDrawer {
    /// The silhouettes of a mesh in lines of this colour and width in pixels; `None` if none is seen.
    pub fn draw(
        &mut self,
        mesh: &Mesh,
        (color, width): (Color, f32),
        (view, page): (&View, &Page),
        hidden: Hidden,
    ) -> Option<Image> {
        let depth = match hidden.depth {
            Some(depth) => depth,
            None => {
                self.front.clear(page.width, page.height);
                self.front.draw(mesh, view, true);
                &self.front
            }
        };
        mesh.positions
            .par_iter()
            .with_min_len(CHUNK)
            .map(|&p| Vec3::from(view.project(p)))
            .collect_into_vec(&mut self.projected);
        let projected = &self.projected;
        let facing = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|v| projected[v as usize].truncate());
            // The page's y points down.
            (b - a).perp_dot(c - a) < 0.0
        };
        mesh.triangles.par_iter().with_min_len(CHUNK).map(facing).collect_into_vec(&mut self.faces);
        self.fronts.clear();
        self.fronts.resize(mesh.positions.len(), false);
        for (triangle, _) in mesh.triangles.iter().zip(&self.faces).filter(|&(_, &faces)| faces) {
            triangle.iter().for_each(|&v| self.fronts[v as usize] = true);
        }
        let (faces, fronts) = (&self.faces, &self.fronts);
        let sheet = Sheet { view, page, depth, hidden };
        let count = mesh.triangles.len().div_ceil(CHUNK);
        self.chunks.resize_with(count.max(self.chunks.len()), Vec::new);
        let look = |(k, triangles): (usize, &[[u32; 3]]), pieces: &mut Vec<Piece>| {
            pieces.clear();
            for (i, triangle) in triangles.iter().enumerate() {
                if faces[k * CHUNK + i] {
                    continue;
                }
                for e in 0..3 {
                    let ends = [triangle[e], triangle[(e + 1) % 3]];
                    if ends.iter().all(|&v| fronts[v as usize]) {
                        // From the smaller vertex on, so that both faces of an edge draw the same.
                        let [a, b] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                        sheet.edge(projected[a as usize], projected[b as usize], pieces);
                    }
                }
            }
        };
        mesh.triangles
            .par_chunks(CHUNK)
            .enumerate()
            .zip(&mut self.chunks)
            .for_each(|(chunk, pieces)| look(chunk, pieces));
        picture(&self.chunks[..count], color, width, page)
    }
}

/// What edges are looked at on.
struct Sheet<'a> {
    view: &'a View,
    page: &'a Page,
    depth: &'a DepthBuffer,
    hidden: Hidden<'a>,
}

impl Sheet<'_> {
    /// Appends the visible steps of an edge between two projected vertices.
    fn edge(&self, a: Vec3, b: Vec3, pieces: &mut Vec<Piece>) {
        let Sheet { view, page, depth, hidden } = *self;
        let margin = page.margin_px;
        let (right, bottom) = (page.width as f32 - margin, page.height as f32 - margin);
        let steps = ((b - a).truncate().length() / STEP).ceil().clamp(1.0, 65_536.0) as u32;
        let place = |t: f32| {
            let at = a.truncate().lerp(b.truncate(), t);
            // Along a line on the page the inverse of the depth changes evenly in perspective.
            let away = match view.projection {
                Projection::Parallel { .. } => a.z + (b.z - a.z) * t,
                Projection::Perspective { .. } => 1.0 / (1.0 / a.z + (1.0 / b.z - 1.0 / a.z) * t),
            };
            (at, away)
        };
        for s in 0..steps {
            let (at, away) = place((s as f32 + 0.5) / steps as f32);
            let on_page = at.x >= margin && at.y >= margin && at.x <= right && at.y <= bottom;
            if !on_page
                || depth.hides_line(view, at.into(), away, [0.0; 2], 0.0)
                || hidden.veil.is_some_and(|v| v.transmittance(at.x, at.y, away) < FAINTEST)
            {
                continue;
            }
            let ink = hidden.before_focus(view, at.x, at.y, away);
            let ends = [s, s + 1].map(|s| place(s as f32 / steps as f32).0);
            pieces.push(Piece { from: ends[0], to: ends[1], ink });
        }
    }
}

/// The picture of pieces as lines with round ends, no larger than they are.
fn picture(chunks: &[Vec<Piece>], color: Color, width: f32, page: &Page) -> Option<Image> {
    let pieces = || chunks.iter().flatten();
    let reach = 0.5 * width + 0.5;
    let mut low = Vec2::splat(f32::INFINITY);
    let mut high = Vec2::splat(f32::NEG_INFINITY);
    for p in pieces() {
        low = low.min(p.from.min(p.to));
        high = high.max(p.from.max(p.to));
    }
    if low.x > high.x {
        return None;
    }
    let size = Vec2::new(page.width as f32, page.height as f32);
    let low = (low - reach).floor().max(Vec2::ZERO);
    let high = (high + reach).ceil().min(size).max(low + 1.0);
    let (columns, rows) = ((high.x - low.x) as usize, (high.y - low.y) as usize);
    let mut cover = vec![0.0f32; columns * rows];
    for p in pieces() {
        let (from, to) = (p.from - low, p.to - low);
        let along = to - from;
        let square = along.length_squared().max(1e-12);
        let first = (from.min(to) - reach).max(Vec2::ZERO);
        let last = from.max(to) + reach;
        for y in first.y as usize..(last.y.max(0.0) as usize + 1).min(rows) {
            for x in first.x as usize..(last.x.max(0.0) as usize + 1).min(columns) {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let t = ((at - from).dot(along) / square).clamp(0.0, 1.0);
                let off = (at - from - along * t).length();
                // A line thinner than a pixel is a weaker one.
                let inside = (reach - off).clamp(0.0, width.min(1.0)) * p.ink;
                let sample = &mut cover[y * columns + x];
                *sample = sample.max(inside);
            }
        }
    }
    let [r, g, b] = color.to_linear();
    Some(Image {
        width: columns as u32,
        height: rows as u32,
        place: [low.x, low.y, high.x, high.y],
        samples: cover.iter().map(|&a| [r * a, g * a, b * a, a]).collect(),
    })
}
