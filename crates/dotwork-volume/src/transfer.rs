//! Transfer functions: opacity and colour over the value, and the surfaces that they mean.
//!
//! Direct volume rendering gives each value an opacity and a colour, and the length of the gradient a factor of the
//! opacity (Marc Levoy, *Display of Surfaces from Volume Data*, 1988). All three are piecewise linear between points,
//! and constant beyond the first and the last. Two points of one value are a step: the second counts from that value on.
//!
//! Stipples sit on surfaces: [`TransferFunction::surfaces`] says which ones a transfer function shows.

use thiserror::Error;

/// Segments less steep than this, in whole opacity changes over the range of values, are flat.
const FLAT: f64 = 0.1;

/// Flanks below this part of the highest opacity show nothing.
const SMALLEST: f64 = 0.02;

/// A rising and a falling flank closer than this part of the range are one peak.
const PEAK: f64 = 0.1;

/// Surfaces closer than this part of the range are one.
const CLOSE: f64 = 0.01;

/// Opacity and colour over the value, and a factor of the opacity over the length of the gradient.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferFunction {
    /// Values in ascending order, each with the opacity there, 0 to 1.
    pub opacity: Vec<(f64, f64)>,
    /// Values in ascending order, each with the colour there, sRGB, 0 to 1; empty for black.
    pub color: Vec<(f64, [f32; 3])>,
    /// Lengths of the gradient (values per world unit) in ascending order, each with a factor, 0 to 1; empty for 1.
    pub gradient: Vec<(f64, f64)>,
}

/// Why points are no transfer function. The text reads well after the name of the file and a colon.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{curve}{}: {reason}", point_text(*point))]
pub struct TransferError {
    /// `opacity`, `color` or `gradient`.
    pub curve: &'static str,
    /// Which of its points, counted from 0; `None` for the whole.
    pub point: Option<usize>,
    /// What is wrong.
    pub reason: String,
}

fn point_text(point: Option<usize>) -> String {
    point.map(|i| format!(", point {}", i + 1)).unwrap_or_default()
}

/// A surface that a transfer function shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferSurface {
    /// The value whose isosurface it is.
    pub value: f64,
    /// How opaque, 0 to 1.
    pub opacity: f64,
    /// Its colour, sRGB, 0 to 1.
    pub color: [f32; 3],
    /// True if what has larger values is the more opaque side.
    pub rising: bool,
}

impl TransferFunction {
    /// The most points that a curve has.
    pub const MAX_POINTS: usize = 65_536;

    /// A transfer function of these points.
    ///
    /// # Errors
    /// As [`TransferFunction::check`].
    pub fn new(
        opacity: Vec<(f64, f64)>,
        color: Vec<(f64, [f32; 3])>,
        gradient: Vec<(f64, f64)>,
    ) -> Result<TransferFunction, TransferError> {
        let function = TransferFunction { opacity, color, gradient };
        function.check()?;
        Ok(function)
    }

    /// Checks the points.
    ///
    /// # Errors
    /// [`TransferError`] with the first point that is not finite, lies before the one in front of it, or has an opacity,
    /// colour or factor outside 0 to 1; a curve of opacity without points, or of more than [`TransferFunction::MAX_POINTS`].
    pub fn check(&self) -> Result<(), TransferError> {
        if self.opacity.is_empty() {
            return Err(TransferError { curve: "opacity", point: None, reason: "has no points".into() });
        }
        check_curve("opacity", self.opacity.iter().map(|&(v, o)| (v, [o])))?;
        check_curve("color", self.color.iter().map(|&(v, c)| (v, c.map(f64::from))))?;
        check_curve("gradient", self.gradient.iter().map(|&(g, o)| (g, [o])))
    }

    /// The opacity of a value, 0 to 1; 0 without points.
    pub fn opacity(&self, value: f64) -> f64 {
        interpolated(&self.opacity, value, |a, b, t| a + t * (b - a)).unwrap_or(0.0)
    }

    /// The colour of a value, sRGB, interpolated in sRGB as volume renderers do; black without points.
    pub fn color(&self, value: f64) -> [f32; 3] {
        let mixed = |a: [f32; 3], b: [f32; 3], t: f64| [0, 1, 2].map(|c| a[c] + t as f32 * (b[c] - a[c]));
        interpolated(&self.color, value, mixed).unwrap_or_default()
    }

    /// The factor of the opacity where the gradient has this length; 1 without points.
    pub fn gradient_opacity(&self, magnitude: f64) -> f64 {
        interpolated(&self.gradient, magnitude, |a, b, t| a + t * (b - a)).unwrap_or(1.0)
    }

    /// The surfaces that it shows, by value. None if the opacity is constant.
    ///
    /// 1. A *flank* is a stretch over which the opacity only rises or only falls. A segment less than a tenth as steep
    ///    as a ramp from the lowest to the highest opacity over the whole range of the points is flat: it belongs to a
    ///    plateau, and so ends a flank. Flanks that change the opacity by less than 2 % of the highest are dropped.
    /// 2. A flank gives an isosurface where the opacity passes half of its change. Its opacity is that of the higher end
    ///    (the plateau that the flank leads to or comes from), its colour the one at its value.
    /// 3. A rising flank and the falling one behind it that are less than 10 % of the range apart are a *peak*: what a
    ///    person draws to show one surface. It gives the surface of its rising half alone.
    /// 4. Of surfaces closer together than 1 % of the range the one of higher opacity stays, of equal ones the first.
    ///
    /// ```
    /// use dotwork_volume::TransferFunction;
    ///
    /// // Faint skin, opaque bone.
    /// let opacity = vec![(-500.0, 0.0), (-300.0, 0.1), (200.0, 0.1), (400.0, 0.9), (3000.0, 0.9)];
    /// let surfaces = TransferFunction::new(opacity, vec![], vec![])?.surfaces();
    /// let found: Vec<_> = surfaces.iter().map(|s| (s.value.round(), s.opacity)).collect();
    /// assert_eq!(found, [(-400.0, 0.1), (300.0, 0.9)]);
    /// # Ok::<(), dotwork_volume::TransferError>(())
    /// ```
    pub fn surfaces(&self) -> Vec<TransferSurface> {
        let points = &self.opacity;
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
        let range = last.0 - first.0;
        let highest = points.iter().fold(0.0, |m: f64, p| m.max(p.1));
        let lowest = points.iter().fold(highest, |m: f64, p| m.min(p.1));
        let steepness = (highest - lowest) / range;
        // Direction of each segment: 0 if flat.
        let direction = |pair: &[(f64, f64)]| {
            let (width, change) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            let flat = change == 0.0 || change.abs() < FLAT * steepness * width;
            if flat { 0.0 } else { change.signum() }
        };
        let directions: Vec<f64> = points.windows(2).map(direction).collect();
        let mut found: Vec<TransferSurface> = Vec::new();
        let mut at = 0;
        while at < directions.len() {
            let same = directions[at..].iter().take_while(|d| **d == directions[at]).count();
            let run = &points[at..=at + same];
            let sign = directions[at];
            at += same;
            let (from, to) = (run[0].1, run[run.len() - 1].1);
            if sign == 0.0 || (to - from).abs() < SMALLEST * highest {
                continue;
            }
            let value = passing(run, from / 2.0 + to / 2.0);
            let surface = TransferSurface {
                value,
                opacity: from.max(to),
                color: self.color(value),
                rising: sign > 0.0,
            };
            let Some(before) = found.last_mut() else {
                found.push(surface);
                continue;
            };
            let apart = value - before.value;
            if before.rising && !surface.rising && apart < PEAK * range {
                before.opacity = before.opacity.max(surface.opacity);
            } else if apart < CLOSE * range {
                if surface.opacity > before.opacity {
                    *before = surface;
                }
            } else {
                found.push(surface);
            }
        }
        found
    }
}

/// Where a monotone run of points passes an opacity between those of its ends.
fn passing(run: &[(f64, f64)], opacity: f64) -> f64 {
    let rising = run[run.len() - 1].1 > run[0].1;
    let reached = |p: &(f64, f64)| if rising { p.1 >= opacity } else { p.1 <= opacity };
    let end = run.iter().position(reached).unwrap_or(run.len() - 1).max(1);
    let (a, b) = (run[end - 1], run[end]);
    let t = ((opacity - a.1) / (b.1 - a.1)).clamp(0.0, 1.0);
    a.0 + t * (b.0 - a.0)
}

/// The curve at `x`; `None` without points or for NaN.
fn interpolated<T: Copy>(points: &[(f64, T)], x: f64, mix: impl Fn(T, T, f64) -> T) -> Option<T> {
    if x.is_nan() {
        return None;
    }
    let after = points.partition_point(|p| p.0 <= x);
    let Some(a) = after.checked_sub(1).map(|i| points[i]) else { return points.first().map(|p| p.1) };
    let Some(b) = points.get(after) else { return Some(a.1) };
    // Halves first: ends near the limits of f64 are finite, their distance may not be.
    let t = (x / 2.0 - a.0 / 2.0) / (b.0 / 2.0 - a.0 / 2.0);
    Some(mix(a.1, b.1, t))
}

fn check_curve<const N: usize>(
    curve: &'static str,
    points: impl ExactSizeIterator<Item = (f64, [f64; N])>,
) -> Result<(), TransferError> {
    let wrong = |point, reason: String| Err(TransferError { curve, point, reason });
    let most = TransferFunction::MAX_POINTS;
    if points.len() > most {
        return wrong(None, format!("has {} points; {most} are allowed", points.len()));
    }
    let mut before = f64::NEG_INFINITY;
    for (i, (x, ys)) in points.enumerate() {
        // Ranges of values must not overflow either.
        if !(x.is_finite() && x.abs() <= f64::MAX / 4.0) {
            return wrong(Some(i), format!("{x} is not a finite number"));
        }
        if x < before {
            return wrong(Some(i), format!("{x} stands behind {before}; values must ascend"));
        }
        if let Some(y) = ys.iter().find(|y| !(0.0..=1.0).contains(*y)) {
            return wrong(Some(i), format!("{y} is not within 0 to 1"));
        }
        before = x;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(opacity: &[(f64, f64)]) -> TransferFunction {
        TransferFunction::new(opacity.to_vec(), vec![], vec![]).unwrap()
    }

    fn found(opacity: &[(f64, f64)]) -> Vec<(f64, f64, bool)> {
        let places = |s: &TransferSurface| ((s.value * 1e6).round() / 1e6, s.opacity, s.rising);
        function(opacity).surfaces().iter().map(places).collect()
    }

    #[test]
    fn curves_are_linear_between_points_and_constant_beyond() {
        let f = TransferFunction::new(
            vec![(0.0, 0.2), (10.0, 0.6), (10.0, 1.0), (20.0, 0.0)],
            vec![(0.0, [0.0, 0.5, 1.0]), (4.0, [1.0, 0.5, 0.0])],
            vec![(1.0, 0.0), (3.0, 1.0)],
        )
        .unwrap();
        // Against the formula, written out.
        for i in -20..60 {
            let v = f64::from(i) / 2.0;
            let expected = match v {
                v if v < 0.0 => 0.2,
                v if v < 10.0 => 0.2 + 0.04 * v,
                v if v < 20.0 => 1.0 - 0.1 * (v - 10.0),
                _ => 0.0,
            };
            assert!((f.opacity(v) - expected).abs() < 1e-12, "{v}");
        }
        assert_eq!(f.color(1.0), [0.25, 0.5, 0.75]);
        assert_eq!((f.color(-1.0), f.color(9.0)), ([0.0, 0.5, 1.0], [1.0, 0.5, 0.0]));
        assert_eq!([0.0, 1.0, 2.5, 9.0].map(|g| f.gradient_opacity(g)), [0.0, 0.0, 0.75, 1.0]);
        assert_eq!(f.opacity(f64::NAN), 0.0);
        let plain = function(&[(5.0, 0.5)]);
        assert_eq!(
            (plain.opacity(-1e300), plain.color(5.0), plain.gradient_opacity(7.0)),
            (0.5, [0.0; 3], 1.0)
        );
    }

    #[test]
    fn each_flank_is_a_surface_where_half_of_it_is_passed() {
        // A plateau with both flanks; a ramp in two pieces is one flank, of which half is reached in the second.
        let window = [(0.0, 0.0), (20.0, 0.0), (30.0, 0.8), (60.0, 0.8), (64.0, 0.0), (100.0, 0.0)];
        assert_eq!(found(&window), [(25.0, 0.8, true), (62.0, 0.8, false)]);
        let bent = [(0.0, 0.0), (10.0, 0.0), (20.0, 0.2), (30.0, 1.0), (100.0, 1.0)];
        assert_eq!(found(&bent), [(23.75, 1.0, true)]);
        // Two steps with a plateau between, the second a jump.
        let steps = [(0.0, 0.0), (10.0, 0.1), (50.0, 0.1), (50.0, 0.9), (100.0, 0.9)];
        assert_eq!(found(&steps), [(5.0, 0.1, true), (50.0, 0.9, true)]);
        // A plateau that is not quite flat.
        let bone = [(-3024.0, 0.0), (-16.0, 0.0), (640.0, 0.72), (3071.0, 0.71)];
        assert_eq!(found(&bone), [(312.0, 0.72, true)]);
        assert_eq!(found(&[(0.0, 0.0), (255.0, 1.0)]), [(127.5, 1.0, true)]);
    }

    #[test]
    fn a_narrow_peak_is_one_surface_and_a_wide_one_two() {
        let tent =
            |half: f64| [(0.0, 0.0), (50.0 - half, 0.0), (50.0, 0.6), (50.0 + half, 0.0), (100.0, 0.0)];
        assert_eq!(found(&tent(4.0)), [(48.0, 0.6, true)]);
        assert_eq!(found(&tent(20.0)), [(40.0, 0.6, true), (60.0, 0.6, false)]);
        // Two peaks stay two.
        let twins = [
            (0.0, 0.0),
            (20.0, 0.0),
            (22.0, 0.5),
            (24.0, 0.0),
            (70.0, 0.0),
            (72.0, 0.3),
            (74.0, 0.0),
            (100.0, 0.0),
        ];
        assert_eq!(found(&twins), [(21.0, 0.5, true), (71.0, 0.3, true)]);
    }

    #[test]
    fn surfaces_that_are_close_are_merged_and_faint_ones_dropped() {
        let close = [(0.0, 0.0), (50.0, 0.0), (50.2, 0.3), (50.5, 0.3), (50.7, 0.9), (100.0, 0.9)];
        assert_eq!(found(&close), [(50.6, 0.9, true)]);
        let faint = [(0.0, 0.0), (10.0, 0.01), (50.0, 0.01), (60.0, 1.0), (100.0, 1.0)];
        assert_eq!(found(&faint).len(), 1);
        assert_eq!(found(&[(0.0, 0.4), (100.0, 0.4)]), []);
        assert_eq!(found(&[(7.0, 1.0)]), []);
        assert_eq!(found(&[(7.0, 0.0), (7.0, 1.0)]), [(7.0, 1.0, true)]);
    }

    /// Scaling the values scales the surfaces, and a mirror image turns them round.
    #[test]
    fn surfaces_do_not_depend_on_the_scale_of_values() {
        let window = [(0.0, 0.0), (20.0, 0.0), (30.0, 0.8), (60.0, 0.8), (72.0, 0.1), (100.0, 0.1)];
        let scaled = window.map(|(v, o)| (v * 1e6 - 5e7, o));
        let mut mirrored = window.map(|(v, o)| (-v, o));
        mirrored.reverse();
        let plain = found(&window);
        let of_scaled: Vec<_> = plain.iter().map(|s| (s.0 * 1e6 - 5e7, s.1, s.2)).collect();
        let of_mirrored: Vec<_> = plain.iter().rev().map(|s| (-s.0, s.1, !s.2)).collect();
        assert_eq!((found(&scaled), found(&mirrored)), (of_scaled, of_mirrored));
    }

    #[test]
    fn points_that_make_no_curve_are_refused() {
        let no = |opacity: &[(f64, f64)]| {
            TransferFunction::new(opacity.to_vec(), vec![], vec![]).unwrap_err().to_string()
        };
        assert_eq!(no(&[]), "opacity: has no points");
        assert_eq!(no(&[(0.0, 0.0), (f64::NAN, 1.0)]), "opacity, point 2: NaN is not a finite number");
        assert_eq!(
            no(&[(0.0, 0.0), (-1.0, 1.0)]),
            "opacity, point 2: -1 stands behind 0; values must ascend"
        );
        assert_eq!(no(&[(0.0, 1.5)]), "opacity, point 1: 1.5 is not within 0 to 1");
        let color = TransferFunction::new(vec![(0.0, 1.0)], vec![(0.0, [0.0, f32::NAN, 0.0])], vec![]);
        assert_eq!(color.unwrap_err().curve, "color");
        let gradient = TransferFunction::new(vec![(0.0, 1.0)], vec![], vec![(0.0, -0.1)]);
        assert_eq!(gradient.unwrap_err().curve, "gradient");
    }
}
