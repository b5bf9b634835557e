//! Lines on the page: from samples that are seen or not to strokes.

use glam::Vec2;

/// Ways shorter than this are straight, pixels.
const SHORT: f32 = 2.0;

/// Distance between the points at which a line is looked at, pixels.
pub(super) const STEP: f32 = 1.5;

/// Hidden stretches up to this length are drawn through, pixels.
pub(super) const GAP: f32 = 4.0;

/// A point is left out where the line without it is off by no more than this, pixels.
const TOLERANCE: f32 = 0.06;

/// Lines that go behind something are seen up to twice this far behind it, pixels.
const BEYOND: f32 = 0.5;

/// The ink of a line changes over this length to either side of where it should, pixels.
pub(super) const FADE: f32 = 9.0;

/// Less than this share of its ink is no line.
const GONE: f32 = 0.01;

/// Lines end in a point over this many of their widths.
const TAPER: f32 = 5.0;

/// A way is round if the line turns by as much over no less than this share of its length, both before and after it.
const EVEN: f32 = 0.45;

/// It is flat if that is no more than this share before or after it.
const SUDDEN: f32 = 0.25;

/// A point of a line on the page.
#[derive(Clone, Copy, Default)]
pub(super) struct Sample {
    pub at: Vec2,
    pub depth: f32,
    /// Full width of the line, pixels.
    pub width: f32,
    /// Direction on the page in which the surface ends.
    pub outwards: Vec2,
    /// How far outwards the mesh may end, pixels.
    pub reach: f32,
    pub visible: bool,
    /// The line turns here and is meant to.
    pub corner: bool,
    /// Strength of the ink, 0…1.
    pub darkness: f32,
}

impl Sample {
    pub fn mix(a: Sample, b: Sample, t: f32) -> Sample {
        let (at, depth) = (a.at.lerp(b.at, t), a.depth + (b.depth - a.depth) * t);
        // A place on an edge has no outward direction, and needs none.
        Sample { at, depth, corner: false, ..if t < 0.5 { a } else { b } }
    }
}

/// The place at the share `t` of the way between two points of a line: as far as it is `round`, on the cubic whose
/// tangents are at right angles to the outward directions there, or on the straight line where those do not agree with
/// the way.
pub(super) fn hermite(a: Sample, b: Sample, round: f32, t: f32) -> Vec2 {
    let way = b.at - a.at;
    let straight = a.at.lerp(b.at, t);
    let tangent = |outwards: Vec2| {
        let along = Vec2::new(-outwards.y, outwards.x);
        along * along.dot(way)
    };
    let (from, to) = (tangent(a.outwards), tangent(b.outwards));
    // Tangents that leave by over 37° belong to a cusp, or to no smooth outline.
    let square = way.length_squared();
    let agrees = |tangent: Vec2| tangent.dot(way) > 0.64 * square;
    if square < SHORT * SHORT || a.outwards.dot(b.outwards) < 0.5 || !agrees(from) || !agrees(to) {
        return straight;
    }
    let (u, v) = (t * (1.0 - t) * (1.0 - t), t * t * (1.0 - t));
    straight + ((from - way) * u - (to - way) * v) * round
}

/// How round each way from a point of a line to the next is, 0…1, into `round`.
///
/// Where a smooth form has been sampled coarsely, it turns over the next stretch about as fast as here. A long flat side
/// between bevels seems to turn too, since the normals at its ends are means that lean over the bevels; but at its ends
/// the line turns many times as fast. Such sides are flat.
pub(super) fn roundness(line: &[Sample], round: &mut Vec<f32>) {
    let n = line.len();
    let closed = n > 3 && line[0].at == line[n - 1].at;
    round.clear();
    round.extend((1..n).map(|i| {
        let (a, b) = (&line[i - 1], &line[i]);
        let length = (b.at - a.at).length();
        if length < SHORT || a.outwards == Vec2::ZERO || b.outwards == Vec2::ZERO {
            return 1.0;
        }
        let turned = a.outwards.angle_to(b.outwards).abs();
        if turned < 1e-3 {
            return 1.0;
        }
        // The way to either side over which the line turns by as much: its length where it is even.
        let walk = |reversed: bool| {
            let (mut walked, mut angle) = (0.0, 0.0);
            let mut k = if reversed { i - 1 } else { i };
            while walked < EVEN * length {
                let next = match (reversed, closed) {
                    (false, false) if k + 1 == n => break,
                    (true, false) if k == 0 => break,
                    (false, _) if k + 1 >= n => 1,
                    (false, _) => k + 1,
                    (true, _) if k == 0 => n - 2,
                    (true, _) => k - 1,
                };
                let (p, q) = (&line[k], &line[next]);
                if p.outwards == Vec2::ZERO || q.outwards == Vec2::ZERO {
                    break;
                }
                let (way, turn) = ((q.at - p.at).length(), p.outwards.angle_to(q.outwards).abs());
                if angle + turn >= turned {
                    return walked + way * (turned - angle) / turn.max(1e-6);
                }
                (walked, angle, k) = (walked + way, angle + turn, next);
            }
            length
        };
        ((walk(false).min(walk(true)) / length - SUDDEN) / (EVEN - SUDDEN)).clamp(0.0, 1.0)
    }));
}

/// Finds the corners of lines along edges, which are exact: no smoothing may cut them.
pub(super) fn mark_corners(line: &mut [Sample]) {
    let edge = |p: &Sample| p.outwards == Vec2::ZERO;
    let n = line.len();
    let closed = n > 3 && line[0].at == line[n - 1].at;
    // Over two samples: a stretch that is shorter is noise and no edge.
    for i in 0..n {
        let at = |k: usize| match closed {
            // The last point is the first one.
            true => Some(line[(i + k + n - 3) % (n - 1)]),
            false => (i + k).checked_sub(2).and_then(|i| line.get(i)).copied(),
        };
        let (Some(a), Some(b), Some(c), Some(d)) = (at(0), at(1), at(3), at(4)) else { continue };
        let here = line[i];
        if ![a, b, here, c, d].iter().all(edge) {
            continue;
        }
        let (from, to) = ((here.at - a.at).normalize_or_zero(), (d.at - here.at).normalize_or_zero());
        let (near_from, near_to) =
            ((here.at - b.at).normalize_or_zero(), (c.at - here.at).normalize_or_zero());
        // Straight on both sides, and turned by over 40° here.
        line[i].corner = from.dot(to) < 0.77 && from.dot(near_from) > 0.98 && to.dot(near_to) > 0.98;
    }
}

/// Turns the shares of ink that are left along a line, in `darkness`, into widths and strengths whose product they are,
/// going from one to the next over a stretch of twice [`FADE`]; where nothing is left the line is not seen.
pub(super) fn fade(line: &mut [Sample]) {
    let n = line.len();
    let closed = n > 3 && line[0].at == line[n - 1].at;
    // The last point of a closed line is its first.
    let period = n - usize::from(closed);
    let reach = ((FADE / STEP) as usize).min(period / 2);
    let left: Vec<f32> = line.iter().map(|p| p.darkness).collect();
    for (i, p) in line.iter_mut().enumerate() {
        let at = |k: usize| match closed {
            true => left[(i + period + k - reach) % period],
            false => left[(i + k).saturating_sub(reach).min(n - 1)],
        };
        let mean = (0..=2 * reach).map(at).sum::<f32>() / (2 * reach + 1) as f32;
        p.darkness = mean.sqrt();
        p.width *= p.darkness;
        p.visible &= mean > GONE;
    }
}

/// The end of a line, [`BEYOND`] nearer to the point before it.
pub(super) fn shortened(end: Sample, before: Sample) -> Sample {
    let length = (end.at - before.at).length();
    let t = if length > 0.0 { (BEYOND / length).min(1.0) } else { 0.0 };
    Sample { at: end.at.lerp(before.at, t), depth: end.depth + (before.depth - end.depth) * t, ..end }
}

/// Makes short hidden stretches between visible ones visible.
pub(super) fn close_gaps(line: &mut [Sample]) {
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
pub(super) fn resample(points: &mut Vec<Sample>, from: &mut Vec<Sample>, length: f32, closed: bool) {
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
pub(super) fn smooth(points: &mut Vec<Sample>, out: &mut Vec<Sample>, closed: bool) {
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

/// Lets the ends of a line run out into points, but for those at which it is joined to others.
pub(super) fn taper(points: &mut [Sample], joined: [bool; 2]) {
    for reversed in [false, true].into_iter().filter(|&reversed| !joined[usize::from(reversed)]) {
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
pub(super) fn simplify(points: &[Sample], kept: &mut Vec<bool>, stack: &mut Vec<(usize, usize)>) {
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
