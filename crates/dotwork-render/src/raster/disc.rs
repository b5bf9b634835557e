//! Discs: solid ones set samples, those of partial strength leave a share of each pixel clear.

use dotwork_drawing::Dots;

use crate::bands::centers;

/// Sample columns and rows of a pixel.
pub(super) const COLUMNS: i32 = 16;
pub(super) const ROWS: i32 = 4;

/// Sets the samples that a disc covers; `y` is relative to the band's first row.
#[inline(always)]
pub(super) fn cover(x: f32, y: f32, radius: f32, masks: &mut [u64], width: usize) {
    let height = (masks.len() / width) as i32;
    // Samples lie at the centres of their cells: sample k at (k + ½) / n.
    let Some((s0, s1)) =
        centers((y - radius) * ROWS as f32, (y + radius) * ROWS as f32, (height * ROWS) as usize)
    else {
        return;
    };
    for s in s0..=s1 {
        let dy = (s as f32 + 0.5) * (1.0 / ROWS as f32) - y;
        let half = (radius * radius - dy * dy).max(0.0).sqrt();
        span(x - half, x + half, s, masks, width);
    }
}

/// Sets the samples of sample row `s` from `low` to `high` (pixels).
#[inline(always)]
pub(super) fn span(low: f32, high: f32, s: usize, masks: &mut [u64], width: usize) {
    let Some((c0, c1)) = centers(low * COLUMNS as f32, high * COLUMNS as f32, width * COLUMNS as usize)
    else {
        return;
    };
    let row = s / ROWS as usize * width;
    let shift = s % ROWS as usize * COLUMNS as usize;
    let (first, last) = (c0 / COLUMNS as usize, c1 / COLUMNS as usize);
    let from = 0xffff_u64 << (c0 % COLUMNS as usize) & 0xffff;
    let to = 0xffff_u64 >> (COLUMNS as usize - 1 - c1 % COLUMNS as usize);
    if first == last {
        masks[row + first] |= (from & to) << shift;
    } else {
        masks[row + first] |= from << shift;
        for mask in &mut masks[row + first + 1..row + last] {
            *mask |= 0xffff << shift;
        }
        masks[row + last] |= to << shift;
    }
}

/// The ramp that stands for a disc.
pub(super) struct Disc {
    /// Distance from the centre at which coverage ends.
    pub reach: f32,
    /// Coverage at the centre if the disc is smaller than the ramp.
    peak: f32,
}

impl Disc {
    #[inline(always)]
    pub fn new(radius: f32) -> Disc {
        // ∫ clamp(R + ½ − d) over the plane is π (R² + 1/12) for R ≥ ½, and π s³/3 for a cone of reach s < 1.
        if radius * radius >= 1.0 / 3.0 {
            Disc { reach: (radius * radius - 1.0 / 12.0).sqrt() + 0.5, peak: 1.0 }
        } else {
            Disc { reach: 1.0, peak: 3.0 * radius * radius }
        }
    }
}

/// Multiplies what shows through by what dot `i`, of partial strength, leaves clear.
#[inline(always)]
pub(super) fn stamp(dots: &Dots, i: usize, clear: &mut [f32], width: usize, top: usize) {
    let (x, y) = (dots.x[i], dots.y[i] - top as f32);
    let Disc { reach, peak } = Disc::new(dots.radius[i]);
    let strength = peak * dots.ink[i];
    let rows = clear.len() / width;
    let Some((x0, x1)) = centers(x - reach, x + reach, width) else { return };
    let Some((y0, y1)) = centers(y - reach, y + reach, rows) else { return };
    let (x, y) = (x - 0.5, y - 0.5);
    for row in y0..=y1 {
        let dy = row as f32 - y;
        for (k, t) in clear[row * width + x0..=row * width + x1].iter_mut().enumerate() {
            let dx = (x0 + k) as f32 - x;
            let distance = (dx * dx + dy * dy).sqrt();
            *t *= 1.0 - strength * (reach - distance).clamp(0.0, 1.0);
        }
    }
}
