//! The density table of a bake: how much ink a spacing gives, counted from the bake's own radii.
//!
//! `density(d) = Σ sizeᵢ² / A` over the stipples that a spacing `d` draws, arrival included. No formula stands in for
//! it: the count of a blue-noise order ripples by 4 % around `κ/d²`.

use crate::params::{Fade, Style};
use crate::stock::Baked;

/// How a dot arrives as its spacing falls below its radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Grow, strengthen or appear.
    pub fade: Fade,
    /// Share of the spacing over which it arrives.
    pub width: f32,
    /// Smallest arrival that is drawn.
    pub min: f32,
}

impl Arrival {
    /// The arrival that a style asks for.
    pub fn of(style: &Style) -> Arrival {
        Arrival { fade: style.fade, width: style.fade_width, min: style.min_size }
    }

    /// How far a stipple of `radius` has arrived at `spacing`: 0 (not drawn) to 1.
    #[inline(always)]
    pub fn at(&self, radius: f32, spacing: f32) -> f32 {
        if self.fade == Fade::Off {
            return if radius >= spacing { 1.0 } else { 0.0 };
        }
        let a = ((radius - spacing) / (self.width * spacing)).min(1.0);
        if a >= self.min && a > 0.0 { a } else { 0.0 }
    }
}

impl Arrival {
    /// The share of the dots drawn at a spacing that have arrived, in whole dots, for an order whose count goes with
    /// `1 / spacing²`: the integral of arrival (of its square where dots grow) over such an order.
    pub fn share(&self) -> f32 {
        let (w, f) = (f64::from(self.width), 1.0 + f64::from(self.width));
        // In u = (radius / spacing)^-2: whole below 1/f², then (1/√u − 1) / w.
        let partial = match self.fade {
            Fade::Off => return 1.0,
            Fade::Ink => (1.0 - (2.0 * f - 1.0) / (f * f)) / w,
            Fade::Size => (2.0 * f.ln() - 4.0 * (1.0 - 1.0 / f) + 1.0 - 1.0 / (f * f)) / (w * w),
        };
        (1.0 / (f * f) + partial) as f32
    }
}

/// Spacing against ink density, for one bake and one way of arriving.
#[derive(Clone, Debug, PartialEq)]
pub struct DensityTable {
    /// Spacings, falling by a constant factor, object units.
    spacing: Vec<f32>,
    /// Full-dot equivalents for each area at each spacing, rising, per object unit squared.
    density: Vec<f64>,
}

/// Steps of the table: the spacing falls by 1 % or less from one to the next.
const STEPS: usize = 1024;

impl DensityTable {
    /// Counts the table from a bake's radii, which fall.
    pub fn new(baked: &Baked, arrival: Arrival) -> DensityTable {
        DensityTable::counted(&baked.radius, baked.area, arrival)
    }

    /// Counts the table from the distances, falling, at which stipples enter on a surface of this area.
    pub fn counted(radii: &[f32], area: f64, arrival: Arrival) -> DensityTable {
        let n = radii.len();
        // Running sums of r and r², so that each step is two searches.
        let mut sums = Vec::with_capacity(n + 1);
        sums.push((0.0f64, 0.0f64));
        let (mut s1, mut s2) = (0.0, 0.0);
        for &r in radii {
            s1 += f64::from(r);
            s2 += f64::from(r).powi(2);
            sums.push((s1, s2));
        }
        let (Some(&first), Some(&last)) = (radii.first(), radii.last()) else {
            return DensityTable { spacing: vec![1.0], density: vec![0.0] };
        };
        let width = f64::from(arrival.width);
        // From a spacing that draws nothing to one at which every stipple has fully arrived.
        let from = f64::from(first) * 1.01;
        let to = f64::from(last) / (1.0 + width) * 0.999;
        let step = (to / from).powf(1.0 / (STEPS - 1) as f64);
        let count = |r: f64| radii.partition_point(|&v| f64::from(v) >= r);
        let mut spacing = Vec::with_capacity(STEPS);
        let mut density = Vec::with_capacity(STEPS);
        for i in 0..STEPS {
            let d = from * step.powi(i as i32);
            let ink = if arrival.fade == Fade::Off {
                count(d) as f64
            } else {
                let full = count(d * (1.0 + width));
                let drawn = count(d * (1.0 + width * f64::from(arrival.min))).max(full);
                let (n, r1, r2) =
                    ((drawn - full) as f64, sums[drawn].0 - sums[full].0, sums[drawn].1 - sums[full].1);
                let partial = match arrival.fade {
                    Fade::Size => (r2 - 2.0 * d * r1 + n * d * d) / (width * d).powi(2),
                    _ => (r1 - n * d) / (width * d),
                };
                full as f64 + partial
            };
            spacing.push(d as f32);
            // Subtraction can leave −1e-12 where nothing is drawn.
            density.push((ink.max(0.0) / area).max(density.last().copied().unwrap_or(0.0)));
        }
        DensityTable { spacing, density }
    }

    /// The table of an endless bake, of which `baked` holds every stipple of at least the radius `complete`: what comes
    /// after, down to `last`, is like what was before, half as dense at √2 times the spacing. (So it is to within 0.5 %
    /// where the stock has some 60,000 stipples on a smooth surface, 2 % on a very folded one.)
    pub fn extended(baked: &Baked, arrival: Arrival, complete: f32, last: f32) -> DensityTable {
        let mut table = DensityTable::new(baked, arrival);
        let known = table.spacing.partition_point(|&d| d >= complete).max(2).min(table.spacing.len());
        table.spacing.truncate(known);
        table.density.truncate(known);
        let Some(&[before, end]) = table.spacing.last_chunk::<2>() else { return table };
        let step = f64::from(end) / f64::from(before);
        let mut spacing = f64::from(end);
        while spacing > f64::from(last) && step < 1.0 {
            spacing *= step;
            let density = 2.0 * table.density((spacing * std::f64::consts::SQRT_2) as f32);
            table.spacing.push(spacing as f32);
            table.density.push(density.max(table.max_density()));
        }
        table
    }

    /// The density at the end of the stock, per object unit squared.
    pub fn max_density(&self) -> f64 {
        self.density.last().copied().unwrap_or(0.0)
    }

    /// The density that a spacing gives.
    pub fn density(&self, spacing: f32) -> f64 {
        let i = self.spacing.partition_point(|&d| d >= spacing);
        if i == 0 {
            return self.density[0];
        }
        let Some(&next) = self.spacing.get(i) else { return self.max_density() };
        let (d0, d1) = (self.spacing[i - 1], next);
        let t = f64::from((d0 - spacing) / (d0 - d1));
        self.density[i - 1] + (self.density[i] - self.density[i - 1]) * t
    }

    /// The spacing that gives a density; beyond the stock's end, the last spacing.
    pub fn spacing(&self, density: f64) -> f32 {
        let i = self.density.partition_point(|&v| v <= density);
        if i == 0 {
            return self.spacing[0];
        }
        let Some(&next) = self.density.get(i) else { return self.spacing[self.spacing.len() - 1] };
        let t = ((density - self.density[i - 1]) / (next - self.density[i - 1])) as f32;
        self.spacing[i - 1] + (self.spacing[i] - self.spacing[i - 1]) * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn baked(n: usize) -> Baked {
        Baked {
            radius: (0..n).map(|i| (0.5 / (i + 1) as f32).sqrt()).collect(),
            id: (0..n as u64).collect(),
            element: vec![0; n],
            weights: vec![[0.0; 2]; n],
            neighbours: Vec::new(),
            area: 2.0,
        }
    }

    #[test]
    fn the_table_counts_what_would_be_drawn() {
        let baked = baked(20_000);
        for fade in [Fade::Size, Fade::Ink, Fade::Off] {
            let arrival = Arrival { fade, width: 0.2, min: 0.25 };
            let table = DensityTable::new(&baked, arrival);
            for d in [0.3f32, 0.1, 0.03, 0.011, 0.006] {
                let ink: f64 = baked
                    .radius
                    .iter()
                    .map(|&r| f64::from(arrival.at(r, d)))
                    .map(|a| if fade == Fade::Size { a * a } else { a })
                    .sum();
                let (counted, table) = (ink / 2.0, table.density(d));
                assert!((counted - table).abs() < 0.02 * counted + 1.0, "{fade:?} {d}: {counted} {table}");
            }
        }
    }

    #[test]
    fn the_share_that_has_arrived_is_what_is_counted() {
        let baked = baked(50_000);
        for fade in [Fade::Size, Fade::Ink, Fade::Off] {
            for width in [0.05, 0.15, 0.6] {
                let arrival = Arrival { fade, width, min: 0.0 };
                let arrived = baked.radius.iter().map(|&r| f64::from(arrival.at(r, 0.005)));
                let drawn = baked.radius.iter().filter(|r| **r >= 0.005).count() as f64;
                let whole: f64 = arrived.map(|a| if fade == Fade::Size { a * a } else { a }).sum();
                let share = f64::from(arrival.share());
                assert!((whole / drawn - share).abs() < 2e-3, "{fade:?} {width}: {} {share}", whole / drawn);
            }
        }
    }

    #[test]
    fn spacing_inverts_density() {
        let table = DensityTable::new(&baked(5000), Arrival { fade: Fade::Size, width: 0.15, min: 0.0 });
        for density in [5.0, 50.0, 500.0, 2400.0] {
            let back = table.density(table.spacing(density));
            assert!((back / density - 1.0).abs() < 0.01, "{density} {back}");
        }
        assert_eq!(table.max_density(), 2500.0);
        assert_eq!(table.density(table.spacing(1e9)), 2500.0);
    }

    #[test]
    fn an_endless_table_goes_on_as_a_larger_bake_does() {
        let (small, large) = (baked(4000), baked(200_000));
        let arrival = Arrival { fade: Fade::Size, width: 0.15, min: 0.0 };
        let complete = small.radius[3999];
        let (extended, whole) = (
            DensityTable::extended(&small, arrival, complete, 0.25 * complete),
            DensityTable::new(&large, arrival),
        );
        for d in [4.0, 1.5, 1.0, 0.9, 0.6, 0.45, 0.3, 0.25] {
            let (a, b) = (extended.density(d * complete), whole.density(d * complete));
            assert!((a / b - 1.0).abs() < 0.01, "{d}: {a} {b}");
            let back = extended.spacing(a);
            assert!((back / (d * complete) - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn an_empty_bake_gives_no_ink() {
        let table = DensityTable::new(&Baked::default(), Arrival { fade: Fade::Off, width: 0.1, min: 0.0 });
        assert_eq!(table.max_density(), 0.0);
    }
}
