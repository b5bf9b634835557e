//! Outlines: contours of a surface as strokes, without what is hidden.
//!
//! The contour is exact to the mesh's normals, but what hides it is known at pixel centres only, and right at an
//! outline the surface that hides and the paper are neighbours. So a place of the line is hidden only if *all* pixels
//! around it show something nearer; then short gaps are closed and short remains dropped ("noise tolerant"), lines are
//! smoothed by about two pixels, and points are left out that a straight line explains.
//!
//! The outline of a smooth form runs, on the page, at right angles to the form's normals. Where a mesh is coarse, that
//! gives the points of its contour tangents, and cubics between them the curve.
//!
//! Before a focus the lines of a context keep the share of their ink that its dots keep: half of the loss is width,
//! half is darkness.

use dotwork_drawing::camera::FIT;
use dotwork_drawing::hash::hash3;
use dotwork_drawing::{Page, Projection, StrokeKind, Strokes, View};
use dotwork_ink::Style;
use dotwork_ink::lines::{Chains, Contours, Eye, SurfaceLines};
use dotwork_mesh::Mesh;
use glam::{Vec2, Vec3};
use rayon::prelude::*;

mod image;
mod kept;
mod path;
mod sheet;
mod taken;
mod voxels;

pub(crate) use kept::LineDrawer;

use crate::covered::Covered;
use crate::hiding::Hidden;
use crate::outline::path::{
    FADE, GAP, STEP, Sample, close_gaps, resample, shortened, simplify, smooth, taper,
};
use crate::outline::sheet::{Place, Sheet, Stops};
use crate::outline::taken::Taken;

/// Lines behind translucent matter are drawn down to this transmittance.
const FAINTEST: f32 = 0.35;

/// Points of chains that a task draws.
const POINTS: usize = 2048;

/// A line is at most this many times as long as the straight lines between its points: [`hermite`] leaves out tangents
/// that turn away from the way by over 37°, and with those that stay the way grows by a factor of 1.36 at most.
const DETOUR: f32 = 1.5;

/// Rounds of smoothing with weights 1 2 1: a Gaussian of 2 pixels at points 1.5 pixels apart.
const SMOOTHING: usize = 4;

/// Marks the ids of borders, above the numbers of vertices and triangles.
const BORDERS: u64 = 1 << 33;

/// Marks the ids of creases.
const CREASES: u64 = 1 << 34;

/// A name for a chain of contour that the chain in the next frame, a little to the side, most likely has too: of the cubes
/// that it passes, as large as itself, the one whose number comes first in an order that has been shuffled.
fn name(points: &[Vec3]) -> u32 {
    let low = points.iter().fold(Vec3::INFINITY, |low, &p| low.min(p));
    let high = points.iter().fold(Vec3::NEG_INFINITY, |high, &p| high.max(p));
    let level = (high - low).max_element().max(f32::MIN_POSITIVE).log2().ceil() as i32;
    let cell = 2f32.powi(level);
    let number = |p: &Vec3| {
        let [x, y, z] = (*p / cell).floor().to_array().map(|v| v as i32 as u32);
        hash3(hash3(x, y, z), level as u32, 0)
    };
    points.iter().map(number).min().unwrap_or(0)
}

/// The width of lines at the depth of the centre, pixels. Seen from afar an object has thinner lines, as far as
/// `outline_thin` says: its bounding sphere on the page tells how far.
fn line_width(style: &Style, view: &View, page: &Page) -> f32 {
    let width = style.outline.to_px(page);
    if style.outline_thin == 0.0 {
        return width;
    }
    let on_page = match view.projection {
        Projection::Parallel { px_per_unit } => px_per_unit * view.radius,
        // The tangent from the eye to the sphere, as in the view that fits it.
        Projection::Perspective { focal_px } => {
            let share = (view.radius / view.distance).min(0.999);
            focal_px * share / (1.0 - share * share).sqrt()
        }
    };
    let fitting = 0.5 * FIT * page.short_side_px();
    width * (on_page / fitting).powf(style.outline_thin).clamp(0.02, 20.0)
}

/// Draws outlines. Memory is kept from frame to frame.
#[derive(Default)]
pub(crate) struct Outliner {
    contours: Contours,
    covered: Covered,
    /// For each task the chains that it draws.
    shares: Vec<std::ops::Range<usize>>,
    pens: Vec<Pen>,
    taken: Taken,
}

/// Draws one line after the other.
#[derive(Default)]
struct Pen {
    stops: Stops,
    /// The points of the chain at work.
    line: Vec<Sample>,
    /// Points of the stretch at work, before and after a round of smoothing.
    points: Vec<Sample>,
    smoothed: Vec<Sample>,
    kept: Vec<bool>,
    stack: Vec<(usize, usize)>,
    piece: Vec<Sample>,
    /// What it has drawn.
    strokes: Strokes,
}

impl Outliner {
    /// Appends the outline and the `lines` of a mesh to `strokes`, without what `hidden` hides and thinned as it
    /// says. Ids are `id_base` and the name of an outline, the vertex with which a border or the edge
    /// with which a crease does.
    pub fn draw(
        &mut self,
        mesh: &Mesh,
        lines: &SurfaceLines,
        style: &Style,
        view: &View,
        page: &Page,
        hidden: Hidden,
        id_base: u64,
        strokes: &mut Strokes,
    ) {
        let eye = match view.projection {
            Projection::Perspective { .. } => Eye::At(view.eye),
            Projection::Parallel { .. } => Eye::Towards(view.back),
        };
        let sheet = Sheet { view, page, hidden, width: line_width(style, view, page) };
        let shortest = style.outline_min.to_px(page);
        let mut contours = std::mem::take(&mut self.contours);
        // A place of a line is seen if one of nine pixels shows it. Where a line bridges a gap, no place in there is
        // farther than half of that from what is seen; where a focus thins it, its ink changes over a stretch.
        let reach = if hidden.focus.is_some() { FADE } else { 0.5 * (GAP + STEP) };
        let margin = reach + STEP;
        if let Some(depth) = hidden.depth {
            self.covered.look(depth, margin);
        }
        let covered = hidden.depth.map(|_| &self.covered);
        let chains = contours.trace(mesh, &lines.creases, eye, |corners| {
            covered.is_some_and(|covered| covered.hides(view, corners))
        });
        self.outlines(chains, &sheet, shortest, id_base, strokes);
        let pen = &mut self.pens[0];
        let place = |v: u32| Place::on_edge(mesh.positions[v as usize]);
        for border in &lines.borders {
            let closed = border.len() > 3 && border.first() == border.last();
            sheet.line(border.iter().copied().map(place), &mut pen.stops, &mut pen.line);
            let id = id_base | BORDERS | u64::from(border[0]);
            pen.stretches(StrokeKind::Border, closed, [false; 2], shortest, id, strokes);
        }
        if style.creases {
            // What is outline in this view has been drawn as that.
            let turned = |&(edge, _): &(u32, bool)| contours.turned()[edge as usize];
            for piece in lines.chains.iter().flat_map(|chain| chain.split(turned)) {
                let Some(&(first, _)) = piece.first() else { continue };
                let ends = |&(edge, reversed): &(u32, bool)| {
                    let [a, b] = lines.creases.edges[edge as usize].ends;
                    if reversed { [b, a] } else { [a, b] }
                };
                let vertices = std::iter::once(ends(&piece[0])[0]).chain(piece.iter().map(|e| ends(e)[1]));
                let closed = piece.len() > 2 && ends(&piece[0])[0] == ends(&piece[piece.len() - 1])[1];
                let joined = [ends(&piece[0])[0], ends(&piece[piece.len() - 1])[1]]
                    .map(|v| lines.joints.binary_search(&v).is_ok());
                sheet.line(vertices.map(place), &mut pen.stops, &mut pen.line);
                pen.stretches(
                    StrokeKind::Crease,
                    closed,
                    joined,
                    shortest,
                    id_base | CREASES | u64::from(first),
                    strokes,
                );
            }
        }
        self.contours = contours;
        if style.creases && !lines.ridges.end.is_empty() {
            self.ridges(lines, &sheet, shortest, id_base, strokes);
        }
    }

    /// Draws the outlines along `chains`, side by side.
    fn outlines(
        &mut self,
        chains: &Chains,
        sheet: &Sheet,
        shortest: f32,
        id_base: u64,
        strokes: &mut Strokes,
    ) {
        self.shares.clear();
        let mut from = 0;
        for k in 0..chains.len() {
            if k + 1 == chains.len() || chains.points(k).end - chains.points(from).start >= POINTS {
                self.shares.push(from..k + 1);
                from = k + 1;
            }
        }
        let count = self.shares.len();
        self.pens.resize_with(count.max(self.pens.len()).max(1), Pen::default);
        self.pens[..count].par_iter_mut().zip(&self.shares).for_each(|(pen, share)| {
            pen.strokes.clear();
            for k in share.clone() {
                pen.outline(chains, k, sheet, shortest, id_base);
            }
        });
        self.pens[..count].iter().for_each(|pen| strokes.extend_from(&pen.strokes));
    }

    /// Draws the creases of a surface whose edges are rounded, where they do not run along its outline: seen from the
    /// side, a rounded edge turns away within its radius.
    fn ridges(
        &mut self,
        lines: &SurfaceLines,
        sheet: &Sheet,
        shortest: f32,
        id_base: u64,
        strokes: &mut Strokes,
    ) {
        let scale = sheet.view.px_per_unit(sheet.view.distance);
        let reach = (lines.radius * scale).max(2.0 * sheet.width);
        self.taken.clear(sheet.page, reach);
        for k in 0..strokes.len() {
            // Strokes of other objects have other numbers.
            if strokes.kind[k] == StrokeKind::Silhouette && strokes.id[k] >= id_base {
                for i in strokes.points(k).skip(1) {
                    let at = |i: usize| Vec2::new(strokes.x[i], strokes.y[i]);
                    self.taken.mark(at(i - 1), at(i));
                }
            }
        }
        let pen = &mut self.pens[0];
        for k in 0..lines.ridges.end.len() {
            let points = lines.ridges.points(k);
            let closed = points.len() > 3 && points.first() == points.last();
            sheet.line(points.iter().copied().map(Place::on_edge), &mut pen.stops, &mut pen.line);
            for p in &mut pen.line {
                p.corner = false;
                p.visible &= !self.taken.near(p.at);
            }
            pen.stretches(
                StrokeKind::Crease,
                closed,
                [false; 2],
                shortest,
                id_base | CREASES | k as u64,
                strokes,
            );
        }
    }
}

impl Pen {
    /// Draws the outline along chain `k`.
    fn outline(&mut self, chains: &Chains, k: usize, sheet: &Sheet, shortest: f32, id_base: u64) {
        let range = chains.points(k);
        // Noise makes many chains that are too short whatever hides them.
        let on_page = |i: usize| {
            let (x, y, _) = sheet.view.project(chains.point[i]);
            Vec2::new(x, y)
        };
        let (mut length, mut last) = (0.0, on_page(range.start));
        for i in range.clone().skip(1) {
            let here = on_page(i);
            length += (here - last).length();
            last = here;
        }
        if length * DETOUR < shortest {
            return;
        }
        let closed = range.len() > 3 && chains.point[range.start] == chains.point[range.end - 1];
        let id = id_base | u64::from(name(&chains.point[range.clone()]));
        let points = range.map(|i| Place {
            point: chains.point[i],
            bulge: chains.bulge[i],
            normal: chains.normal[i],
            edge: chains.edge[i],
            open: chains.open[i],
        });
        sheet.line(points, &mut self.stops, &mut self.line);
        let mut strokes = std::mem::take(&mut self.strokes);
        self.stretches(StrokeKind::Silhouette, closed, [false; 2], shortest, id, &mut strokes);
        self.strokes = strokes;
    }

    /// Draws the visible stretches of the line in `line`. Where it is `joined` to others at its ends, it meets them in
    /// full width.
    fn stretches(
        &mut self,
        kind: StrokeKind,
        closed: bool,
        joined: [bool; 2],
        shortest: f32,
        id: u64,
        strokes: &mut Strokes,
    ) {
        let mut line = std::mem::take(&mut self.line);
        let mut whole = false;
        if closed {
            line.pop();
            // Begin where it is hidden, so that no visible stretch runs over the end.
            match line.iter().position(|p| !p.visible) {
                Some(hidden) => line.rotate_left(hidden),
                None => whole = true,
            }
        }
        if whole {
            self.points.clone_from(&line);
            self.stroke(kind, true, [true; 2], shortest, id, strokes);
        } else {
            close_gaps(&mut line);
            let mut from = 0;
            while let Some(start) = line[from..].iter().position(|p| p.visible).map(|i| from + i) {
                let end = line[start..].iter().position(|p| !p.visible).map_or(line.len(), |i| start + i);
                self.points.clear();
                self.points.extend_from_slice(&line[start..end]);
                // A line that goes behind something is seen a bit too far: as long as one pixel around shows it.
                let last = self.points.len() - 1;
                if start > 0 && last > 0 {
                    self.points[0] = shortened(self.points[0], self.points[1]);
                }
                if end < line.len() && last > 1 {
                    self.points[last] = shortened(self.points[last], self.points[last - 1]);
                }
                let joined = [joined[0] && !closed && start == 0, joined[1] && !closed && end == line.len()];
                self.stroke(kind, false, joined, shortest, id, strokes);
                from = end;
            }
        }
        self.line = line;
    }

    /// Draws the stretch in `points`.
    fn stroke(
        &mut self,
        kind: StrokeKind,
        closed: bool,
        joined: [bool; 2],
        shortest: f32,
        id: u64,
        strokes: &mut Strokes,
    ) {
        let points = &mut self.points;
        let length: f32 = points.windows(2).map(|w| (w[1].at - w[0].at).length()).sum();
        if points.len() < 3 || length < shortest {
            return;
        }
        if closed && let Some(corner) = points.iter().position(|p| p.corner) {
            points.rotate_left(corner);
            points.push(points[0]);
        } else if closed {
            let first = points[0];
            points.push(first);
        }
        // Corners stay: what lies between them is smoothed.
        let whole = closed && !points[0].corner;
        let all = std::mem::take(points);
        let mut piece = std::mem::take(&mut self.piece);
        let mut from = 0;
        while from + 1 < all.len() {
            let to = (from + 1..all.len() - 1).find(|&i| all[i].corner).unwrap_or(all.len() - 1);
            piece.clear();
            piece.extend_from_slice(&all[from..=to]);
            let length = piece.windows(2).map(|w| (w[1].at - w[0].at).length()).sum();
            resample(&mut piece, &mut self.smoothed, length, whole);
            for _ in 0..SMOOTHING {
                smooth(&mut piece, &mut self.smoothed, whole);
            }
            points.extend_from_slice(&piece[usize::from(from > 0)..]);
            from = to;
        }
        self.piece = piece;
        if whole {
            points.push(points[0]);
        } else if !closed {
            taper(points, joined);
        }
        simplify(points, &mut self.kept, &mut self.stack);
        for (p, _) in points.iter().zip(&self.kept).filter(|&(_, &kept)| kept) {
            strokes.x.push(p.at.x);
            strokes.y.push(p.at.y);
            strokes.depth.push(p.depth);
            strokes.width.push(p.width);
            strokes.darkness.push(p.darkness);
        }
        strokes.end.push(strokes.x.len() as u32);
        strokes.id.push(id);
        strokes.kind.push(kind);
    }
}
