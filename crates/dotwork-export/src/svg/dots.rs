//! Dots as few paths: one for each width and opacity.
//!
//! An element a dot would be 200,000 elements, 7 MB and an editor that hangs; a stroke width for each dot is the same.
//! Widths rounded to a micrometre fall into a few hundred classes, and the dots of a class are subpaths of one path. The
//! rounding goes up or down so that the running sum of the areas is kept (error diffusion): dots of 42.3 µm become
//! 42 µm and 43 µm in the right proportion, and tones stay exact. A pen's dots all have its diameter.

use std::io::{self, Write};

use dotwork_drawing::Dots;

use super::{OPACITY_STEPS, Sheet, Touch, write_opacity};
use crate::opacity::opacity;
use crate::text::TextWriter;

/// Dots in one path. XML parsers refuse attributes over 10 MB, and editors redraw by element.
const DOTS_A_PATH: usize = 10_000;

/// Dots in a line of text.
const DOTS_A_LINE: usize = 8;

/// More paths than this are avoided by rounding widths more coarsely.
const MAX_CLASSES: usize = 4096;

/// Length of a [`Touch::Tick`] in micrometres.
const TICK_UM: f64 = 1.0;

/// Bits of a key that hold the width in micrometres: up to 67 m.
const WIDTH_BITS: u32 = 26;

/// A dot as it is written: opacity level, width and place in micrometres.
struct Spot {
    level: u64,
    /// What the stroke width should be, micrometres.
    width: f64,
    x: i64,
    y: i64,
}

pub(super) fn write_dots<W: Write>(
    text: &mut TextWriter<W>,
    sheet: &Sheet<'_>,
    dots: &Dots,
) -> io::Result<()> {
    let spots = spots(sheet, dots);
    let circles = sheet.options.touch == Touch::Circle;
    let keys = if sheet.options.plotter { one_class(sheet, &spots) } else { classes(sheet, &spots) };
    if circles && !keys.is_empty() {
        text.bytes(format!("<g class=\"dots\" fill=\"{}\" stroke=\"none\">\n", sheet.color).as_bytes());
    }
    for class in keys.chunk_by(|a, b| a.0 == b.0) {
        let (level, width) = (class[0].0 >> WIDTH_BITS, class[0].0 & ((1 << WIDTH_BITS) - 1));
        let members = class.iter().map(|key| &spots[key.1 as usize]);
        if circles {
            write_circles(text, level, width, members)?;
            continue;
        }
        let touch: &[u8] = if sheet.options.touch == Touch::Tick { b"h0.001" } else { b"h0" };
        for (i, spot) in members.enumerate() {
            if i % DOTS_A_PATH == 0 {
                text.bytes(if i == 0 { b"" } else { b"\"/>\n" });
                text.bytes(b"<path class=\"dots\" stroke-width=\"");
                text.thousandths(width as i64);
                text.bytes(b"\"");
                write_opacity(text, level);
                text.bytes(b" d=\"");
            } else if i % DOTS_A_LINE == 0 {
                text.bytes(b"\n");
            }
            text.bytes(b"M");
            text.thousandths(spot.x);
            text.bytes(b" ");
            text.thousandths(spot.y);
            text.bytes(touch);
            text.pass_on()?;
        }
        text.bytes(b"\"/>\n");
    }
    if circles && !keys.is_empty() {
        text.bytes(b"</g>\n");
    }
    Ok(())
}

fn write_circles<'a, W: Write>(
    text: &mut TextWriter<W>,
    level: u64,
    width: u64,
    members: impl Iterator<Item = &'a Spot>,
) -> io::Result<()> {
    for spot in members {
        text.bytes(b"<circle cx=\"");
        text.thousandths(spot.x);
        text.bytes(b"\" cy=\"");
        text.thousandths(spot.y);
        text.bytes(b"\" r=\"");
        text.thousandths((width / 2) as i64);
        text.bytes(b"\"");
        if level < OPACITY_STEPS as u64 {
            text.bytes(b" opacity=\"");
            text.thousandths((level * (1000 / OPACITY_STEPS as u64)) as i64);
            text.bytes(b"\"");
        }
        text.bytes(b"/>\n");
        text.pass_on()?;
    }
    Ok(())
}

/// The dots that are drawn, in drawing order.
fn spots(sheet: &Sheet<'_>, dots: &Dots) -> Vec<Spot> {
    let n = dots.len();
    let (x, y, radius, ink) = (&dots.x[..n], &dots.y[..n], &dots.radius[..n], &dots.ink[..n]);
    let full = OPACITY_STEPS as u64;
    // Opacity that rounding to levels still owes to the dots that follow.
    let mut owed = 0.0;
    let mut spots = Vec::with_capacity(n);
    for i in 0..n {
        let (x, y, diameter) = (sheet.um(x[i]), sheet.um(y[i]), 2.0 * sheet.um(radius[i]));
        let drawable = diameter > 0.0 && diameter < f64::from(1 << WIDTH_BITS) - 2.0 && ink[i] > 0.0;
        if !(drawable && sheet.touches(x, y, 0.5 * diameter)) {
            continue;
        }
        let level = if ink[i] >= 1.0 || sheet.options.plotter {
            full
        } else {
            let wanted = opacity(ink[i], sheet.color, sheet.paper) * OPACITY_STEPS + owed;
            let level = wanted.round().clamp(0.0, OPACITY_STEPS);
            owed = (wanted - level).clamp(-0.5, 0.5);
            level as u64
        };
        let width = match sheet.options.touch {
            // A tick's length adds to its area.
            Touch::Tick => {
                let extra = 2.0 / std::f64::consts::PI * TICK_UM;
                (diameter * diameter + extra * extra).sqrt() - extra
            }
            Touch::Dot | Touch::Circle => diameter,
        };
        if level > 0 {
            spots.push(Spot { level, width, x: x.round() as i64, y: y.round() as i64 });
        }
    }
    spots
}

/// A key for each spot, all the same, in drawing order: what a plotter draws with the one pen of the layer.
fn one_class(sheet: &Sheet<'_>, spots: &[Spot]) -> Vec<(u64, u32)> {
    let width = match sheet.pen_mm {
        Some(mm) => f64::from(mm) * 1e3,
        None => (spots.iter().map(|s| s.width * s.width).sum::<f64>() / spots.len().max(1) as f64).sqrt(),
    };
    let width = (width.round() as u64).clamp(1, (1 << WIDTH_BITS) - 1);
    let key = (OPACITY_STEPS as u64) << WIDTH_BITS | width;
    (0..spots.len() as u32).map(|i| (key, i)).collect()
}

/// Opacity and width of each spot as a key, and its index, sorted.
fn classes(sheet: &Sheet<'_>, spots: &[Spot]) -> Vec<(u64, u32)> {
    let mut keys = Vec::with_capacity(spots.len());
    // A circle's radius has 3 decimals: its diameter is even.
    let mut step = if sheet.options.touch == Touch::Circle { 2.0 } else { 1.0 };
    loop {
        keys.clear();
        // The area that rounding still owes, in squared diameters.
        let mut owed = 0.0;
        for (i, spot) in spots.iter().enumerate() {
            let key = |width: f64| spot.level << WIDTH_BITS | width as u64;
            if let Some(mm) = sheet.pen_mm {
                // A pen has one size. Where dots differ from it, they are drawn as they are.
                let (pen, width) = (f64::from(mm) * 1e3, spot.width);
                let width = if (width - pen).abs() <= PEN_SLACK_UM { pen } else { width };
                keys.push((key(round_to(width, step).max(step)), i as u32));
                continue;
            }
            let low = (spot.width / step).floor() * step;
            let high = low + step;
            let wanted = spot.width * spot.width + owed;
            let width = if wanted - low * low < high * high - wanted { low } else { high };
            owed = wanted - width * width;
            if width > 0.0 {
                keys.push((key(width), i as u32));
            }
        }
        keys.sort_unstable();
        // Circles are elements whatever their size.
        if sheet.options.touch == Touch::Circle || distinct(&keys) <= MAX_CLASSES {
            return keys;
        }
        step *= 2.0;
    }
}

/// How far a dot's width may be from its pen's and still be taken for it: a tick's share, and the last place of `f32`.
const PEN_SLACK_UM: f64 = 1.0;

fn round_to(width: f64, step: f64) -> f64 {
    (width / step).round() * step
}

fn distinct(keys: &[(u64, u32)]) -> usize {
    keys.chunk_by(|a, b| a.0 == b.0).count()
}
