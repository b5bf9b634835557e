//! Strokes as open paths: one each, cut only where width or darkness changes.
//!
//! SVG has one width a path. A stroke that swells is cut into runs whose width varies by at most a tenth, each drawn in
//! its mean width; runs share their end points, and round caps close the steps. Runs of partial strength that were cut
//! have flat ends, because round ones would darken the joints.

use std::io::{self, Write};
use std::ops::Range;

use dotwork_drawing::Strokes;

use super::{OPACITY_STEPS, Sheet, Touch, write_opacity};
use crate::opacity::opacity;
use crate::text::TextWriter;

/// Widths within a run differ at most by this factor…
const WIDTH_RATIO: f64 = 1.1;

/// …or are below this many micrometres, which no press or pen shows.
const HAIR_UM: f64 = 5.0;

/// A segment whose width or darkness changes much is cut into at most this many pieces.
const MAX_PIECES: f64 = 64.0;

/// A point of a stroke as it is drawn.
#[derive(Clone, Copy, PartialEq)]
struct Point {
    /// Micrometres.
    x: f64,
    y: f64,
    /// Micrometres, at least [`HAIR_UM`].
    width: f64,
    /// Opacity in [`OPACITY_STEPS`].
    level: f32,
}

pub(super) fn write_strokes<W: Write>(
    text: &mut TextWriter<W>,
    sheet: &Sheet<'_>,
    strokes: &Strokes,
) -> io::Result<()> {
    let mut points = Vec::new();
    for k in 0..strokes.len() {
        let class = strokes.kind[k].name();
        // What is not finite or has no width cuts the stroke.
        let all = strokes.points(k);
        let mut rest = all.clone();
        while let Some(start) = rest.find(|&i| drawable(sheet, strokes, i)) {
            let end = (start + 1..all.end).find(|&i| !drawable(sheet, strokes, i)).unwrap_or(all.end);
            rest = end..all.end;
            // Ends may taper to nothing, but something must be left.
            if (start..end).all(|i| strokes.width[i] == 0.0 || strokes.darkness[i] == 0.0) {
                continue;
            }
            collect(sheet, strokes, start..end, &mut points);
            if sheet.options.plotter {
                write_whole(text, sheet, class, &points);
            } else {
                write_runs(text, class, &points);
            }
            text.pass_on()?;
        }
    }
    Ok(())
}

fn drawable(sheet: &Sheet<'_>, strokes: &Strokes, i: usize) -> bool {
    let (x, y, width) = (sheet.um(strokes.x[i]), sheet.um(strokes.y[i]), sheet.um(strokes.width[i]));
    // A stroke may leave the page and come back, but not go to where numbers lose their decimals.
    let far = 10.0 * sheet.size_um[0].max(sheet.size_um[1]);
    (0.0..1e8).contains(&width) && strokes.darkness[i] >= 0.0 && sheet.touches(x, y, far)
}

/// The points `range` in micrometres, segments cut where width or opacity changes much.
fn collect(sheet: &Sheet<'_>, strokes: &Strokes, range: Range<usize>, points: &mut Vec<Point>) {
    points.clear();
    for i in range {
        let level = opacity(strokes.darkness[i].min(1.0), sheet.color, sheet.paper) * OPACITY_STEPS;
        let to = Point {
            x: sheet.um(strokes.x[i]),
            y: sheet.um(strokes.y[i]),
            width: sheet.um(strokes.width[i]).max(HAIR_UM),
            level,
        };
        if let Some(&from) = points.last().filter(|_| !sheet.options.plotter) {
            let ratio = (to.width / from.width).ln().abs() / WIDTH_RATIO.ln();
            let levels = f64::from((to.level - from.level).abs()) / 2.0;
            let pieces = ratio.max(levels).ceil().clamp(1.0, MAX_PIECES);
            for piece in 1..pieces as u32 {
                let t = f64::from(piece) / pieces;
                points.push(Point {
                    x: from.x + (to.x - from.x) * t,
                    y: from.y + (to.y - from.y) * t,
                    // Widths change by equal factors.
                    width: from.width * (to.width / from.width).powf(t),
                    level: from.level + (to.level - from.level) * t as f32,
                });
            }
        }
        points.push(to);
    }
}

/// The whole stroke in one width, as a pen draws it.
fn write_whole<W: Write>(text: &mut TextWriter<W>, sheet: &Sheet<'_>, class: &str, points: &[Point]) {
    let mean = points.iter().map(|p| p.width).sum::<f64>() / points.len() as f64;
    let width = sheet.pen_mm.map_or(mean, |mm| f64::from(mm) * 1e3);
    write_path(text, class, width, OPACITY_STEPS as u64, false, sheet.options.touch, points);
}

fn write_runs<W: Write>(text: &mut TextWriter<W>, class: &str, points: &[Point]) {
    let mut start = 0;
    while start + 1 < points.len() || (start == 0 && points.len() == 1) {
        let first = points[start];
        let (mut low, mut high) = (first.width, first.width);
        let (mut dim, mut dark) = (first.level, first.level);
        // A run has one segment at least.
        let mut end = start + 1;
        while end < points.len() {
            let p = points[end];
            (low, high) = (low.min(p.width), high.max(p.width));
            (dim, dark) = (dim.min(p.level), dark.max(p.level));
            if end > start + 1 && (high > low * WIDTH_RATIO || dark - dim > 2.0) {
                break;
            }
            end += 1;
        }
        let run = &points[start..end];
        let count = run.len() as f64;
        let width = run.iter().map(|p| p.width).sum::<f64>() / count;
        let level = (run.iter().map(|p| f64::from(p.level)).sum::<f64>() / count).round() as u64;
        let cut = run.len() < points.len() && level < OPACITY_STEPS as u64;
        if level > 0 {
            write_path(text, class, width, level, cut, Touch::Dot, run);
        }
        start = end - 1;
        if run.len() == 1 {
            break;
        }
    }
}

fn write_path<W: Write>(
    text: &mut TextWriter<W>,
    class: &str,
    width: f64,
    level: u64,
    flat: bool,
    touch: Touch,
    points: &[Point],
) {
    text.bytes(b"<path class=\"");
    text.bytes(class.as_bytes());
    text.bytes(b"\" stroke-width=\"");
    text.thousandths((width.round() as i64).max(1));
    text.bytes(b"\"");
    write_opacity(text, level);
    if flat {
        text.bytes(b" stroke-linecap=\"butt\"");
    }
    text.bytes(b" d=\"M");
    let mut last = None;
    let mut drawn = 0;
    for p in points {
        let at = [p.x.round() as i64, p.y.round() as i64];
        // Points that fall together after rounding are one.
        if last.replace(at) == Some(at) {
            continue;
        }
        text.bytes(match drawn {
            0 => b"",
            1 => b"L",
            _ => b" ",
        });
        text.thousandths(at[0]);
        text.bytes(b" ");
        text.thousandths(at[1]);
        drawn += 1;
    }
    if drawn == 1 {
        text.bytes(if touch == Touch::Tick { b"h0.001" } else { b"h0" });
    }
    text.bytes(b"\"/>\n");
}
