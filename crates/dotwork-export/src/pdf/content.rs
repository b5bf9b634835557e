//! Marks as PDF operators.
//!
//! A dot is a line of no length with round caps: two points and one operator, where a circle takes four Bézier curves,
//! and still a disc that every program edits as a stroke. (`m h`, a closed path of one point, would be shorter;
//! viewers on an HTML canvas draw nothing for it.)
//!
//! Within a layer order does not matter: solid marks cover their union and partial ones multiply what shows through. So
//! dots are sorted by strength and diameter, and `w` and the opacity change seldom. Coordinates are integers in small
//! units, which are shorter than decimals and deflate well.

use std::collections::BTreeSet;
use std::ops::Range;

use dotwork_drawing::{Color, Dots, Layer, Page, Strokes};

use super::syntax::{integer, real};
use crate::opacity::opacity;

/// Content is cut into streams of about this size, which are deflated side by side.
const STREAM_BYTES: usize = 1 << 18;

/// Dots in one path. A path covers its union exactly, where dots painted one after the other leave their shared edge
/// pixels too light; but viewers slow down on long ones.
const DOTS_A_PATH: usize = 256;

/// Pixels from the first dot of a path down to the last: MuPDF takes 17 times as long for paths that span the page.
const PATH_PX: f32 = 4.0;

/// Neighbouring classes of diameters differ by this share. A class is written with its root mean square, so that its
/// area is exact and no dot's area is off by more than twice this share.
const DIAMETER_STEP: f64 = 0.0009;

/// A stroke of varying width is drawn in runs of one width; this share of a width is not seen as a step.
const WIDTH_STEP: f32 = 0.04;

/// Nor is this much of an opacity; finer steps have more seams, where viewers smooth the edges of both runs.
const OPACITY_STEP: f32 = 0.05;

/// Parts into which a single tapering segment is cut at most.
const MOST_PARTS: f32 = 64.0;

/// Places further out than this many pixels count as not finite: they are far from every page, and all coordinates
/// stay within the range of readers.
const FARTHEST_PX: f32 = 1e6;

/// The units of the content.
#[derive(Clone, Copy)]
pub(super) struct Units {
    /// Units a pixel.
    pub per_px: f64,
    /// Units an inch.
    pub per_inch: f64,
}

impl Units {
    /// The power of ten of a millimetre of which a pixel holds 20 to 200: micrometres from 130 to 1270 dpi.
    pub(super) fn of(page: &Page) -> Units {
        let mm_per_px = 25.4 / f64::from(page.dpi);
        let mut per_mm = 1.0;
        while mm_per_px * per_mm < 20.0 {
            per_mm *= 10.0;
        }
        // A pixel has an inch at most.
        Units { per_px: mm_per_px * per_mm, per_inch: 25.4 * per_mm }
    }
}

/// Content streams in the making.
pub(super) struct Content {
    /// The units of its coordinates.
    pub units: Units,
    text: Vec<u8>,
    /// The finished streams.
    pub streams: Vec<Vec<u8>>,
    /// Opacities in use, in thousandths.
    pub opacities: BTreeSet<u16>,
    state: State,
}

/// What the graphics state holds; `None` where it must be set.
#[derive(Default)]
struct State {
    width: Option<u64>,
    opacity: Option<u16>,
    butt: bool,
}

/// Opaque, in thousandths.
const OPAQUE: u16 = 1000;

impl Content {
    pub(super) fn new(units: Units) -> Content {
        Content {
            units,
            text: Vec::with_capacity(STREAM_BYTES + 4096),
            streams: Vec::new(),
            opacities: BTreeSet::new(),
            state: State::default(),
        }
    }

    /// Appends operators.
    pub(super) fn operators(&mut self, text: impl AsRef<[u8]>) {
        self.text.extend_from_slice(text.as_ref());
    }

    /// Appends a number of the content's units for a length in pixels.
    pub(super) fn length(&mut self, px: f32) {
        real(&mut self.text, f64::from(px) * self.units.per_px, 2);
        self.text.push(b' ');
    }

    /// Ends the last stream.
    pub(super) fn finish(&mut self) {
        let next = Vec::with_capacity(STREAM_BYTES + 4096);
        self.streams.push(std::mem::replace(&mut self.text, next));
    }

    /// The marks of a layer; what is not finite, empty or off the page is left out.
    pub(super) fn marks(&mut self, layer: &Layer, paper: Color, page: &Page) {
        self.state = State { opacity: Some(OPAQUE), ..State::default() };
        self.operators(color_operator(layer.color, Paint::Stroke));
        // As viewers blend. Presses agree with them rather than with linear light: printed dots grow by about as
        // much.
        let opacity = |strength: f32| opacity(strength, layer.color, paper);
        self.dots(&layer.dots, page, &opacity);
        self.strokes(&layer.strokes, &opacity);
    }

    fn dots(&mut self, dots: &Dots, page: &Page, opacity: &dyn Fn(f32) -> f32) {
        let per_px = self.units.per_px;
        let (width, height) = (page.width as f32, page.height as f32);
        let count = dots.len();
        let (x, y) = (&dots.x[..count], &dots.y[..count]);
        let (radius, ink) = (&dots.radius[..count], &dots.ink[..count]);
        let mut order: Vec<(u64, u32)> = Vec::with_capacity(count);
        for i in 0..count {
            let (x, y, r) = (x[i], y[i], radius[i]);
            let strength = step(ink[i]);
            // Comparisons with what is no number are false.
            let seen = x + r > 0.0 && y + r > 0.0 && x - r < width && y - r < height;
            if seen
                && r > 0.0
                && r < FARTHEST_PX
                && x.abs() < FARTHEST_PX
                && y.abs() < FARTHEST_PX
                && strength > 0
            {
                let class = (f64::from(r) * 2.0 * per_px).ln() / DIAMETER_STEP;
                // Diameters lie between e^±60 units.
                let class = (class.round() as i64 + (1 << 17)) as u64;
                // Strength first, the solid ones before all others; in a class from the top down, which deflates best.
                let row = (y.max(0.0) * per_px as f32) as u64;
                order.push((
                    (255 - u64::from(strength)) << 56 | class << 36 | row.min((1 << 36) - 1),
                    i as u32,
                ));
            }
        }
        order.sort_unstable();
        for class in order.chunk_by(|a, b| a.0 >> 36 == b.0 >> 36) {
            let mean = class.iter().map(|&(_, i)| f64::from(radius[i as usize]).powi(2)).sum::<f64>()
                / class.len() as f64;
            let strength = 255 - (class[0].0 >> 56) as u8;
            self.opacity(thousandths(opacity(f32::from(strength) / 255.0)));
            self.width(2.0 * mean.sqrt() * per_px);
            // Where partial dots overlap, each takes its share: they are painted one by one.
            let most = if strength == 255 { DOTS_A_PATH } else { 1 };
            let (mut count, mut top) = (0, 0.0);
            for &(_, i) in class {
                let (x, y) = (x[i as usize], y[i as usize]);
                if count == most || y - top > PATH_PX {
                    self.end_path(count);
                    count = 0;
                }
                if count == 0 {
                    top = y;
                }
                let start = self.text.len();
                self.point(x, y);
                let end = self.text.len();
                self.text.extend_from_slice(b"m ");
                self.text.extend_from_within(start..end);
                self.text.extend_from_slice(b"l\n");
                count += 1;
            }
            self.end_path(count);
        }
    }

    /// Paints the path in the making, if there is one.
    fn end_path(&mut self, parts: usize) {
        if parts > 0 {
            self.text.extend_from_slice(b"S\n");
            self.pass_on();
        }
    }

    fn strokes(&mut self, strokes: &Strokes, opacity: &dyn Fn(f32) -> f32) {
        let near = |v: f32| v.abs() < FARTHEST_PX;
        let drawable = |&i: &usize| {
            near(strokes.x[i])
                && near(strokes.y[i])
                && near(strokes.width[i])
                && strokes.darkness[i].is_finite()
        };
        let mut runs = Runs::default();
        for k in 0..strokes.len() {
            // A point that is not finite breaks the line in two.
            let Range { start: mut from, end } = strokes.points(k);
            while from < end {
                let to = (from..end).find(|i| !drawable(i)).unwrap_or(end);
                if from < to {
                    runs.cut(strokes, from..to, opacity);
                    self.runs(&runs);
                }
                from = to + 1;
            }
        }
    }

    fn runs(&mut self, runs: &Runs) {
        let whole = runs.list.len() == 1;
        for run in &runs.list {
            let opacity = thousandths(run.opacity);
            let width = f64::from(run.width) * self.units.per_px;
            // A width of 0 would be the thinnest line there is.
            if opacity == 0 || width < 0.01 {
                continue;
            }
            // Caps of partial runs would show as beads where one run overlaps the next.
            self.caps(!whole && opacity < OPAQUE);
            self.opacity(opacity);
            self.width(width);
            let points = &runs.points[run.start..run.end];
            let closed = whole && points.len() > 3 && points.first() == points.last();
            let drawn = if closed { &points[..points.len() - 1] } else { points };
            for (n, &[x, y]) in drawn.iter().enumerate() {
                self.point(x, y);
                self.text.extend_from_slice(if n == 0 { b"m\n" } else { b"l\n" });
            }
            self.text.extend_from_slice(if closed { b"s\n" } else { b"S\n" });
            self.pass_on();
        }
    }

    fn point(&mut self, x: f32, y: f32) {
        for v in [x, y] {
            integer(&mut self.text, (f64::from(v) * self.units.per_px).round() as i64);
            self.text.push(b' ');
        }
    }

    fn width(&mut self, units: f64) {
        let thousandths = (units * 1000.0).round().max(1.0) as u64;
        if self.state.width.replace(thousandths) != Some(thousandths) {
            real(&mut self.text, thousandths as f64 / 1000.0, 3);
            self.text.extend_from_slice(b" w\n");
        }
    }

    fn opacity(&mut self, opacity: u16) {
        if self.state.opacity.replace(opacity) != Some(opacity) {
            self.opacities.insert(opacity);
            self.text.extend_from_slice(format!("/A{opacity} gs\n").as_bytes());
        }
    }

    fn caps(&mut self, butt: bool) {
        if std::mem::replace(&mut self.state.butt, butt) != butt {
            self.text.extend_from_slice(if butt { b"0 J\n" } else { b"1 J\n" });
        }
    }

    fn pass_on(&mut self) {
        if self.text.len() >= STREAM_BYTES {
            self.finish();
        }
    }
}

/// An opacity in thousandths.
fn thousandths(opacity: f32) -> u16 {
    (opacity * f32::from(OPAQUE) + 0.5) as u16
}

/// A strength in steps of 1/255; 0 for what is no number.
fn step(strength: f32) -> u8 {
    (strength * 255.0 + 0.5) as u8
}

/// A stroke cut into runs that are drawn with one width and one strength each; neighbours share a point.
#[derive(Default)]
struct Runs {
    points: Vec<[f32; 2]>,
    list: Vec<Run>,
}

struct Run {
    start: usize,
    end: usize,
    width: f32,
    opacity: f32,
}

impl Runs {
    /// Cuts the line through the points `piece`, at least one.
    fn cut(&mut self, strokes: &Strokes, piece: Range<usize>, opacity: &dyn Fn(f32) -> f32) {
        let at = |i: usize| [strokes.x[i], strokes.y[i]];
        let state = |i: usize| [strokes.width[i].max(0.0), strokes.darkness[i].clamp(0.0, 1.0)];
        self.points.clear();
        self.list.clear();
        self.points.push(at(piece.start));
        // Sums of the present run: length, and width and opacity weighted by it; and how the run began.
        let (mut sums, mut first) = ([0.0f32; 3], [0.0; 2]);
        let mut start = 0;
        if piece.len() == 1 {
            // A line of no length, which round caps make a disc: the points of a label.
            let [width, darkness] = state(piece.start);
            self.points.push(at(piece.start));
            self.list.push(Run { start, end: 2, width, opacity: opacity(darkness) });
            return;
        }
        let mut end_run = |points: &[[f32; 2]], start: usize, sums: &[f32; 3], first: [f32; 2]| {
            let mean = if sums[0] > 0.0 { [sums[1] / sums[0], sums[2] / sums[0]] } else { first };
            self.list.push(Run { start, end: points.len(), width: mean[0], opacity: mean[1] });
        };
        for i in piece.start + 1..piece.end {
            let ([from, to], [a, b]) = ([at(i - 1), at(i)], [state(i - 1), state(i)]);
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            let taper = (b[0] - a[0]).abs() / (2.0 * WIDTH_STEP * a[0].max(b[0])).max(f32::MIN_POSITIVE);
            // Opacity is steep at the dark end.
            let fade = (opacity(b[1]) - opacity(a[1])).abs() / OPACITY_STEP;
            // No part is shorter than half a pixel.
            let parts = taper.max(fade).min(2.0 * length).clamp(1.0, MOST_PARTS).ceil() as u32;
            for part in 0..parts {
                let middle = (part as f32 + 0.5) / parts as f32;
                let [width, darkness] = [0, 1].map(|k| a[k] + (b[k] - a[k]) * middle);
                let now = [width, opacity(darkness)];
                if self.points.len() == start + 1 {
                    first = now;
                } else if (now[0] - first[0]).abs() > WIDTH_STEP * first[0]
                    || (now[1] - first[1]).abs() > OPACITY_STEP
                {
                    end_run(&self.points, start, &sums, first);
                    let shared = self.points[self.points.len() - 1];
                    start = self.points.len();
                    self.points.push(shared);
                    (sums, first) = ([0.0; 3], now);
                }
                let t = (part + 1) as f32 / parts as f32;
                self.points.push(if part + 1 == parts {
                    to
                } else {
                    [0, 1].map(|k| from[k] + (to[k] - from[k]) * t)
                });
                let share = length / parts as f32;
                for (sum, v) in sums.iter_mut().zip([1.0, now[0], now[1]]) {
                    *sum += v * share;
                }
            }
        }
        end_run(&self.points, start, &sums, first);
    }
}

/// What a colour is set for.
#[derive(Clone, Copy)]
pub(super) enum Paint {
    Stroke,
    Fill,
}

/// The operator that sets a colour. Greys stay grey, so that black ink is printed with black alone.
pub(super) fn color_operator(color: Color, paint: Paint) -> Vec<u8> {
    let mut out = Vec::new();
    let stroke = matches!(paint, Paint::Stroke);
    let (channels, operator): (&[u8], &[u8]) = match (color.is_grey(), stroke) {
        (true, true) => (&[color.r], b"G\n"),
        (true, false) => (&[color.r], b"g\n"),
        (false, true) => (&[color.r, color.g, color.b], b"RG\n"),
        (false, false) => (&[color.r, color.g, color.b], b"rg\n"),
    };
    for &c in channels {
        real(&mut out, f64::from(c) / 255.0, 4);
        out.push(b' ');
    }
    out.extend_from_slice(operator);
    out
}
