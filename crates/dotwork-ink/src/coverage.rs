//! The universal coverage table: how much of the page dots cover, against the ink area that they bring.
//!
//! `F(x, c)` is the covered share of the page for dots whose areas sum to `x` per page area, placed by a blue-noise
//! order on a surface that is foreshortened by `c = |n·E|`: while dots do not meet, `F = x`; where they overlap,
//! less. It is dimensionless, so it serves every dot size, scale and bake, and a foreshortened dot radius as well
//! (what counts is the radius on the page). It depends a little on how dots arrive and on how even the order is; the
//! four tables in `coverage_table.rs` are blended. They were measured by `examples/measure_coverage.rs`, and a test
//! measures some of their entries again.

use crate::coverage_table::{COVERAGE, COVERAGE_COSINES, COVERAGE_INKS, COVERAGE_WIDTH};
use crate::params::{BakeMethod, Fade, Style};

/// Columns of the inverse table: ink 0…1.
const INKS: usize = 128;
/// Rows of the inverse table: cosine 0…1.
const COSINES: usize = 32;

/// The inverse of the coverage table for one style: ink and cosine to ink area per page area.
#[derive(Clone, Debug)]
pub struct Coverage {
    /// `INKS + 2` columns for each of `COSINES + 2` rows; the extra ones repeat the last, for interpolation.
    inverse: Vec<f32>,
}

/// The regularity whose dots overlap as those of a hierarchy do: measured on plates at tones from 0.5 to 0.9.
const HIERARCHY: f32 = 0.67;

/// The covered share of the page for ink area `x` per page area at cosine `c`, for dots that arrive over `width` of
/// the spacing and an order of the given regularity.
pub fn covered(x: f32, c: f32, width: f32, regularity: f32) -> f32 {
    let (i, s) = locate(&COVERAGE_INKS, x);
    let (j, t) = locate(&COVERAGE_COSINES, c);
    let cell = |table: usize, i: usize, j: usize| COVERAGE[table][j][i];
    let w = (width / COVERAGE_WIDTH).clamp(0.0, 1.0);
    let blend = |i: usize, j: usize| {
        let loose = cell(0, i, j) * (1.0 - w) + cell(1, i, j) * w;
        let even = cell(2, i, j) * (1.0 - w) + cell(3, i, j) * w;
        loose * (1.0 - regularity) + even * regularity
    };
    let row = |j: usize| blend(i, j) * (1.0 - s) + blend(i + 1, j) * s;
    row(j) * (1.0 - t) + row(j + 1) * t
}

/// The interval of a rising grid that holds `v`, and the place in it, 0…1.
fn locate(grid: &[f32], v: f32) -> (usize, f32) {
    let i = grid.partition_point(|&g| g <= v).clamp(1, grid.len() - 1) - 1;
    (i, ((v - grid[i]) / (grid[i + 1] - grid[i])).clamp(0.0, 1.0))
}

impl Coverage {
    /// Inverts the table for a style.
    pub fn new(style: &Style) -> Coverage {
        let width = if style.fade == Fade::Off { 0.0 } else { style.fade_width };
        let regularity = match style.bake {
            BakeMethod::Hierarchy => HIERARCHY,
            _ => style.regularity,
        };
        let mut inverse = Vec::with_capacity((INKS + 2) * (COSINES + 2));
        for j in 0..COSINES + 2 {
            let c = (j as f32 / COSINES as f32).min(1.0);
            for i in 0..INKS + 2 {
                let ink = (i as f32 / INKS as f32).min(1.0);
                // Bisection: the table rises with x.
                let (mut low, mut high) = (0.0f32, COVERAGE_INKS[COVERAGE_INKS.len() - 1]);
                for _ in 0..30 {
                    let middle = 0.5 * (low + high);
                    if covered(middle, c, width, regularity) < ink {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                inverse.push(high);
            }
        }
        // No ink is no dots, to the last bit.
        for row in inverse.chunks_mut(INKS + 2) {
            row[0] = 0.0;
        }
        Coverage { inverse }
    }

    /// The ink area per page area that covers the share `ink` of the page at cosine `c`.
    #[inline(always)]
    pub fn area(&self, ink: f32, c: f32) -> f32 {
        let x = ink.clamp(0.0, 1.0) * INKS as f32;
        let y = c.clamp(0.0, 1.0) * COSINES as f32;
        let (i, j) = (x as usize, y as usize);
        let (s, t) = (x - i as f32, y - j as f32);
        let at = j * (INKS + 2) + i;
        let top = self.inverse[at] + (self.inverse[at + 1] - self.inverse[at]) * s;
        let below = at + INKS + 2;
        let bottom = self.inverse[below] + (self.inverse[below + 1] - self.inverse[below]) * s;
        top + (bottom - top) * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Plate;

    #[test]
    fn the_table_is_what_a_plate_shows() {
        // Another seed and another number of stipples than the table was measured with.
        let plate = Plate::new(12_000, 1.0, 99);
        for (x, c, width) in [
            (0.2, 1.0, 0.0),
            (0.48, 1.0, 0.0),
            (0.9, 1.0, 0.3),
            (1.5, 0.5, 0.15),
            (0.6, 0.25, 0.15),
            (2.5, 0.1, 0.3),
        ] {
            let (measured, table) = (plate.covered(x, c, width), covered(x, c, width, 1.0));
            assert!((measured - table).abs() < 0.008, "x {x} c {c} width {width}: {measured} {table}");
        }
        let loose = Plate::new(12_000, 0.0, 99);
        let (measured, table) = (loose.covered(0.9, 1.0, 0.0), covered(0.9, 1.0, 0.0, 0.0));
        assert!((measured - table).abs() < 0.012, "{measured} {table}");
    }

    #[test]
    fn light_tones_cover_what_they_bring_and_none_brings_none() {
        let coverage = Coverage::new(&Style::default());
        for c in [0.1, 0.5, 1.0] {
            assert_eq!(coverage.area(0.0, c), 0.0);
        }
        assert!((coverage.area(0.2, 1.0) - 0.2).abs() < 0.002);
    }

    #[test]
    fn area_inverts_coverage() {
        let style = Style { regularity: 0.6, fade_width: 0.2, ..Style::default() };
        let coverage = Coverage::new(&style);
        for i in 1..20 {
            for c in [0.06, 0.13, 0.4, 0.77, 1.0] {
                let ink = i as f32 / 20.0;
                let back = covered(coverage.area(ink, c), c, 0.2, 0.6);
                assert!((back - ink).abs() < 0.006, "ink {ink} c {c}: {back}");
            }
        }
    }
}
