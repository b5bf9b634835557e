//! Outlines: contours of a surface as strokes, without what is hidden.
//!
//! The contour is exact to the mesh's normals, but what hides it is known at pixel centres only, and right at an
//! outline the surface that hides and the paper are neighbours. So a place of the line is hidden only if *all* pixels
//! around it show something nearer; then short gaps are closed and short remains dropped ("noise tolerant"), lines are
//! smoothed by about two pixels, and points are left out that a straight line explains.

use dotwork_drawing::{Page, Projection, StrokeKind, Strokes, View};
use dotwork_ink::Style;
use dotwork_ink::lines::{Contours, Eye};
use dotwork_mesh::Mesh;
use glam::{Vec2, Vec3};

use crate::depth::DepthBuffer;
use crate::veil::Veil;

/// The outline of a coarse mesh lies outside the contour by up to this share of an edge: an arc of 100° and its chord.
const SAGITTA: f32 = 0.2;

/// But no further than this is looked for it, pixels.
const FARTHEST: f32 = 12.0;

/// Lines behind translucent matter are drawn down to this transmittance.
const FAINTEST: f32 = 0.35;

/// Distance between the points at which a line is looked at, pixels.
const STEP: f32 = 1.5;

/// Hidden stretches up to this length are drawn through, pixels.
const GAP: f32 = 4.0;

/// Rounds of smoothing with weights 1 2 1: a Gaussian of 2 pixels at points 1.5 pixels apart.
const SMOOTHING: usize = 4;

/// A point is left out where the line without it is off by no more than this, pixels.
const TOLERANCE: f32 = 0.06;

/// Marks the ids of borders, above the numbers of vertices and triangles.
const BORDERS: u64 = 1 << 33;

/// Lines end in a point over this many of their widths.
const TAPER: f32 = 5.0;

/// Draws outlines. Memory is kept from frame to frame.
#[derive(Default)]
pub(crate) struct Outliner {
    contours: Contours,
    /// The points of the chain at work.
    line: Vec<Sample>,
    /// Points of the stretch at work, before and after a round of smoothing.
    points: Vec<Sample>,
    smoothed: Vec<Sample>,
    kept: Vec<bool>,
    stack: Vec<(usize, usize)>,
}

/// A point of a line on the page.
#[derive(Clone, Copy, Default)]
struct Sample {
    at: Vec2,
    depth: f32,
    /// Full width of the line, pixels.
    width: f32,
    /// Direction on the page in which the surface ends.
    outwards: Vec2,
    /// How far outwards the mesh may end, pixels.
    reach: f32,
    visible: bool,
}

impl Sample {
    fn mix(a: Sample, b: Sample, t: f32) -> Sample {
        Sample { at: a.at.lerp(b.at, t), depth: a.depth + (b.depth - a.depth) * t, ..a }
    }
}

impl Outliner {
    /// Appends the outline and the `borders` of a mesh to `strokes`. `depth` holds what hides; ids are `id_base` and the
    /// triangle in which an outline begins, or the vertex with which a border does.
    pub fn draw(
        &mut self,
        mesh: &Mesh,
        borders: &[Vec<u32>],
        style: &Style,
        view: &View,
        page: &Page,
        depth: Option<&DepthBuffer>,
        veil: Option<&Veil>,
        id_base: u64,
        strokes: &mut Strokes,
    ) {
        let eye = match view.projection {
            Projection::Perspective { .. } => Eye::At(view.eye),
            Projection::Parallel { .. } => Eye::Towards(view.back),
        };
        let sheet = Sheet { view, page, depth, veil, width: style.outline.to_px(page) };
        let shortest = style.outline_min.to_px(page);
        let mut contours = std::mem::take(&mut self.contours);
        let chains = contours.trace(mesh, eye);
        for k in 0..chains.len() {
            let range = chains.points(k);
            let closed = range.len() > 3 && chains.point[range.start] == chains.point[range.end - 1];
            let id = id_base | u64::from(chains.triangle[k]);
            let points = range.map(|i| Place {
                point: chains.point[i],
                normal: chains.normal[i],
                edge: chains.edge[i],
                open: chains.open[i],
            });
            sheet.line(points, &mut self.line);
            self.stretches(StrokeKind::Silhouette, closed, shortest, id, strokes);
        }
        self.contours = contours;
        for border in borders {
            let closed = border.len() > 3 && border.first() == border.last();
            let place = |&v: &u32| Place {
                point: mesh.positions[v as usize],
                normal: Vec3::ZERO,
                edge: 0.0,
                open: true,
            };
            sheet.line(border.iter().map(place), &mut self.line);
            let id = id_base | BORDERS | u64::from(border[0]);
            self.stretches(StrokeKind::Border, closed, shortest, id, strokes);
        }
    }

    /// Draws the visible stretches of the line in `line`.
    fn stretches(&mut self, kind: StrokeKind, closed: bool, shortest: f32, id: u64, strokes: &mut Strokes) {
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
            self.stroke(kind, true, shortest, id, strokes);
        } else {
            close_gaps(&mut line);
            let mut from = 0;
            while let Some(start) = line[from..].iter().position(|p| p.visible).map(|i| from + i) {
                let end = line[start..].iter().position(|p| !p.visible).map_or(line.len(), |i| start + i);
                self.points.clear();
                self.points.extend_from_slice(&line[start..end]);
                self.stroke(kind, false, shortest, id, strokes);
                from = end;
            }
        }
        self.line = line;
    }

    /// Draws the stretch in `points`.
    fn stroke(&mut self, kind: StrokeKind, closed: bool, shortest: f32, id: u64, strokes: &mut Strokes) {
        let points = &mut self.points;
        let length: f32 = points.windows(2).map(|w| (w[1].at - w[0].at).length()).sum();
        if points.len() < 3 || length < shortest {
            return;
        }
        resample(points, &mut self.smoothed, length, closed);
        for _ in 0..SMOOTHING {
            smooth(points, &mut self.smoothed, closed);
        }
        if closed {
            points.push(points[0]);
        } else {
            taper(points);
        }
        simplify(points, &mut self.kept, &mut self.stack);
        for (p, _) in points.iter().zip(&self.kept).filter(|&(_, &kept)| kept) {
            strokes.x.push(p.at.x);
            strokes.y.push(p.at.y);
            strokes.depth.push(p.depth);
            strokes.width.push(p.width);
            strokes.darkness.push(1.0);
        }
        strokes.end.push(strokes.x.len() as u32);
        strokes.id.push(id);
        strokes.kind.push(kind);
    }
}

/// A place of a line in space.
struct Place {
    point: Vec3,
    /// The surface's normal; zero if the line has no outer side.
    normal: Vec3,
    /// Length of the mesh's edges there.
    edge: f32,
    /// The surface itself does not hide it.
    open: bool,
}

/// What lines are drawn on.
struct Sheet<'a> {
    view: &'a View,
    page: &'a Page,
    depth: Option<&'a DepthBuffer>,
    veil: Option<&'a Veil>,
    /// Width of a line at the depth of the centre, pixels.
    width: f32,
}

impl Sheet<'_> {
    /// Replaces `line` by samples of a line in space, at most [`STEP`] apart.
    fn line(&self, places: impl Iterator<Item = Place>, line: &mut Vec<Sample>) {
        let Sheet { view, page, depth, veil, width } = *self;
        line.clear();
        let mut last: Option<Sample> = None;
        for Place { point, normal, edge, open } in places {
            let (x, y, depth) = view.project(point);
            let here = Sample {
                at: Vec2::new(x, y),
                depth,
                // A nearer line is a bolder one, within reason.
                width: width * if view.is_parallel() { 1.0 } else { (view.distance / depth).clamp(0.5, 2.0) },
                outwards: Vec2::new(normal.dot(view.right), -normal.dot(view.up)).normalize_or_zero(),
                reach: (SAGITTA * edge * view.px_per_unit(depth)).min(FARTHEST),
                visible: open,
            };
            let before = last.replace(here).unwrap_or(here);
            let steps = ((here.at - before.at).length() / STEP).ceil().clamp(1.0, 4096.0) as u32;
            for s in 1..=steps {
                let t = s as f32 / steps as f32;
                let visible = if t < 0.5 { before.visible } else { here.visible };
                line.push(Sample { visible, ..Sample::mix(before, here, t) });
            }
        }
        let margin = page.margin_px;
        let (right, bottom) = (page.width as f32 - margin, page.height as f32 - margin);
        for p in line {
            let on_page = p.at.x >= margin && p.at.y >= margin && p.at.x <= right && p.at.y <= bottom;
            // Lines do not thin: they end where little comes through.
            let veiled = |v: &Veil| {
                let at = p.at + p.outwards * 2.0;
                v.transmittance(at.x, at.y, p.depth) < FAINTEST
            };
            p.visible &= on_page
                && !veil.is_some_and(veiled)
                && !depth
                    .is_some_and(|d| d.hides_line(view, p.at.into(), p.depth, p.outwards.into(), p.reach));
        }
    }
}

/// Makes short hidden stretches between visible ones visible.
fn close_gaps(line: &mut [Sample]) {
    let mut last_visible = None;
    let mut hidden = 0.0;
    for i in 0..line.len() {
        if i > 0 {
            hidden += (line[i].at - line[i - 1].at).length();
        }
        if line[i].visible {
            if let Some(last) = last_visible
                && hidden <= GAP + STEP
            {
                line[last + 1..i].iter_mut().for_each(|p| p.visible = true);
            }
            (last_visible, hidden) = (Some(i), 0.0);
        }
    }
}

/// Replaces a line by points that lie evenly along it, about [`STEP`] apart.
fn resample(points: &mut Vec<Sample>, from: &mut Vec<Sample>, length: f32, closed: bool) {
    std::mem::swap(points, from);
    points.clear();
    let count = (length / STEP).round().clamp(2.0, 1e6) as usize;
    let step = length / count as f32;
    let (mut walked, mut i) = (0.0, 0);
    for k in 0..count + usize::from(!closed) {
        let wanted = k as f32 * step;
        let mut piece = (from[i + 1].at - from[i].at).length();
        while walked + piece < wanted && i + 2 < from.len() {
            walked += piece;
            i += 1;
            piece = (from[i + 1].at - from[i].at).length();
        }
        let t = if piece > 0.0 { ((wanted - walked) / piece).clamp(0.0, 1.0) } else { 0.0 };
        points.push(Sample::mix(from[i], from[i + 1], t));
    }
}

/// One round of smoothing; the ends of an open line stay.
fn smooth(points: &mut Vec<Sample>, out: &mut Vec<Sample>, closed: bool) {
    let n = points.len();
    out.clear();
    out.extend((0..n).map(|i| {
        let p = points[i];
        if !closed && (i == 0 || i == n - 1) {
            return p;
        }
        let (a, b) = (points[(i + n - 1) % n], points[(i + 1) % n]);
        Sample {
            at: (a.at + p.at * 2.0 + b.at) * 0.25,
            depth: 0.25 * (a.depth + 2.0 * p.depth + b.depth),
            ..p
        }
    }));
    std::mem::swap(points, out);
}

/// Lets both ends of a line run out into points.
fn taper(points: &mut [Sample]) {
    for reversed in [false, true] {
        let mut walked = 0.0;
        for k in 0..points.len() {
            let at = |k: usize| if reversed { points.len() - 1 - k } else { k };
            if k > 0 {
                walked += (points[at(k)].at - points[at(k - 1)].at).length();
            }
            let over = TAPER * points[at(k)].width.max(f32::MIN_POSITIVE);
            let share = walked / over;
            if share >= 1.0 {
                break;
            }
            let i = at(k);
            points[i].width *= 0.25 + 0.75 * share;
        }
    }
}

/// Marks the points that a line needs to stay within [`TOLERANCE`] of itself, in place and in width (Douglas and
/// Peucker 1973).
fn simplify(points: &[Sample], kept: &mut Vec<bool>, stack: &mut Vec<(usize, usize)>) {
    kept.clear();
    kept.resize(points.len(), false);
    let last = points.len() - 1;
    // A closed line is cut in the middle too: its ends are one point.
    let middle = last / 2;
    for i in [0, middle, last] {
        kept[i] = true;
    }
    stack.clear();
    stack.extend([(0, middle), (middle, last)]);
    while let Some((from, to)) = stack.pop() {
        let (a, b) = (points[from], points[to]);
        let along = b.at - a.at;
        let square = along.length_squared();
        let mut worst = (TOLERANCE, 0);
        for (i, p) in points.iter().enumerate().take(to).skip(from + 1) {
            let t = if square > 0.0 { ((p.at - a.at).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
            let off = (p.at - (a.at + along * t)).length();
            let off = off.max((p.width - (a.width + (b.width - a.width) * t)).abs());
            if off > worst.0 {
                worst = (off, i);
            }
        }
        if worst.1 > 0 {
            kept[worst.1] = true;
            stack.extend([(from, worst.1), (worst.1, to)]);
        }
    }
}
