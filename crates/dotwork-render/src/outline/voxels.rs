//! The papers' silhouette curves: one short stroke for each voxel of a silhouette, or for each two.
//!
//! Which voxels and which strokes is said by [`VoxelCurves`]; here they are put on the page, hidden and drawn. A stroke is
//! about as long as a voxel, so it is seen as a whole or not at all: as its middle is. A voxel's centre lies up to the
//! criteria's width within the form's outline, where the form itself may be nearer; so, as with other outlines, it is
//! hidden only by what also hides the places outwards of it, two voxels far.

use dotwork_drawing::{Page, Projection, StrokeKind, Strokes, View};
use dotwork_ink::Style;
use dotwork_ink::lines::{Chosen, Criteria, Eye, MAX_PIECE_ID, Piece, VoxelCurves};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::{FAINTEST, line_width};
use crate::hiding::Hidden;

/// Voxels a task draws.
const CHUNK: usize = 2048;

/// How far outwards of a stroke's middle is looked, in voxels, and at most in pixels.
const REACH: f32 = 2.0;
const FARTHEST: f32 = 64.0;

/// Marks the ids of these strokes, above those of outlines, borders and creases.
const CURVES: u64 = MAX_PIECE_ID;

/// Draws curves. Memory is kept from frame to frame.
#[derive(Default)]
pub(crate) struct CurveDrawer {
    chosen: Chosen,
    chunks: Vec<Strokes>,
}

impl CurveDrawer {
    /// Appends the curves of an object to `strokes`.
    pub fn draw(
        &mut self,
        curves: &VoxelCurves,
        style: &Style,
        (view, page): (&View, &Page),
        hidden: Hidden,
        id_base: u64,
        strokes: &mut Strokes,
    ) {
        let eye = match view.projection {
            Projection::Perspective { .. } => Eye::At(view.eye),
            Projection::Parallel { .. } => Eye::Towards(view.back),
        };
        let sheet = Sheet {
            view,
            page,
            hidden,
            width: line_width(style, view, page),
            reach: REACH * curves.lattice.edge(),
            id_base: id_base | CURVES,
        };
        let chosen = self.chosen.find(curves, &Criteria::of(style), eye);
        let count = chosen.len().div_ceil(CHUNK);
        self.chunks.resize_with(count.max(self.chunks.len()), Strokes::default);
        self.chunks[..count].par_iter_mut().enumerate().for_each(|(c, strokes)| {
            strokes.clear();
            let part = c * CHUNK..((c + 1) * CHUNK).min(chosen.len());
            curves.pieces(style.curves_method, eye, chosen, part, |piece| sheet.draw(piece, strokes));
        });
        self.chunks[..count].iter().for_each(|chunk| strokes.extend_from(chunk));
    }
}

/// What curves are drawn on.
struct Sheet<'a> {
    view: &'a View,
    page: &'a Page,
    hidden: Hidden<'a>,
    /// Width of a line at the depth of the centre, pixels.
    width: f32,
    /// How far outwards is looked, object units.
    reach: f32,
    id_base: u64,
}

impl Sheet<'_> {
    /// Appends a piece if it is seen.
    #[inline]
    fn draw(&self, piece: Piece, strokes: &mut Strokes) {
        let view = self.view;
        let ends = piece.ends.map(|p| view.project(p));
        let margin = self.page.margin_px;
        let (right, bottom) = (self.page.width as f32 - margin, self.page.height as f32 - margin);
        let on_page = |&(x, y, _): &(f32, f32, f32)| x >= margin && y >= margin && x <= right && y <= bottom;
        if !ends.iter().all(on_page) || self.hides(piece) {
            return;
        }
        for (x, y, depth) in ends {
            strokes.x.push(x);
            strokes.y.push(y);
            strokes.depth.push(depth);
            // A nearer line is a bolder one, within reason.
            let nearer = if view.is_parallel() { 1.0 } else { (view.distance / depth).clamp(0.5, 2.0) };
            let left = self.hidden.before_focus(view, x, y, depth).sqrt();
            strokes.width.push(self.width * nearer * left);
            strokes.darkness.push(left);
        }
        strokes.end.push(strokes.x.len() as u32);
        strokes.id.push(self.id_base | piece.id);
        strokes.kind.push(StrokeKind::Silhouette);
    }

    /// Whether the middle of a piece is hidden.
    fn hides(&self, Piece { ends: [a, b], normal, .. }: Piece) -> bool {
        let Hidden { depth, veil, .. } = self.hidden;
        if depth.is_none() && veil.is_none() {
            return false;
        }
        let view = self.view;
        let middle: Vec3 = (a + b) * 0.5;
        let (x, y, away) = view.project(middle);
        let outwards = Vec2::new(normal.dot(view.right), -normal.dot(view.up)).normalize_or_zero();
        let reach = (self.reach * view.px_per_unit(away)).min(FARTHEST);
        let beyond = Vec2::new(x, y) + outwards * reach;
        veil.is_some_and(|v| v.transmittance(beyond.x, beyond.y, away) < FAINTEST)
            || depth.is_some_and(|d| d.hides_line(view, [x, y], away, outwards.into(), reach))
    }
}
