//! Where the samples of the result lie: crop, padding, and finer steps along coarse axes.

use dotwork_drawing::Warnings;

use super::{Preparation, PrepareError};
use crate::affine::Affine;
use crate::volume::Volume;

/// Voxels of the source by which a volume is padded on each side, as fine voxels where an axis is resampled.
const PAD: usize = 3;

/// An axis that is coarser by no more than this is left as it is: the blur of resampling would cost more.
const NEAR: f64 = 1.1;

/// A result of this many voxels (256 MB) is no burden, whatever the size of the source.
const FREE: u128 = 1 << 27;

/// A result may have this many times the voxels of the source …
const GROWTH: u128 = 4;

/// … and for no other reason than padding, this many times.
const PADDED_GROWTH: u128 = 8;

/// Resampling never makes more voxels than this.
const MOST: u128 = 1 << 31;

/// One axis of the result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    /// The first source voxel that is kept.
    pub from: usize,
    /// Source voxels that are kept.
    pub kept: usize,
    /// Result voxels before the first and after the last that is kept.
    pub pad: usize,
    /// Result voxels.
    pub len: usize,
    /// Result steps are `num / den` source steps long. Whole numbers, so that phases repeat exactly.
    pub num: i64,
    pub den: i64,
}

impl Axis {
    fn new(kept: std::ops::Range<usize>, steps: usize, cap: bool) -> Axis {
        let n = kept.len();
        // Result steps between the first and the last voxel that is kept.
        let (num, den) = if steps > n - 1 { (n - 1, steps) } else { (1, 1) };
        let pad = if cap { (PAD * den).div_ceil(num) } else { 0 };
        let len = steps.max(n - 1) + 1 + 2 * pad;
        Axis { from: kept.start, kept: n, pad, len, num: num as i64, den: den as i64 }
    }

    /// Length of a result step, source steps.
    pub(super) fn step(&self) -> f64 {
        self.num as f64 / self.den as f64
    }

    /// True if results lie on source samples, step by step.
    pub(super) fn is_unresampled(&self) -> bool {
        self.num == self.den
    }

    /// The source sample, counted from the first kept, at or before result voxel `k`, and how far it lies beyond, 0…1.
    pub(super) fn source(&self, k: i64) -> (i64, f64) {
        let at = (k - self.pad as i64) * self.num;
        (at.div_euclid(self.den), at.rem_euclid(self.den) as f64 / self.den as f64)
    }
}

/// The result's axes x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid(pub [Axis; 3]);

impl Grid {
    pub(super) fn new(
        volume: &Volume,
        preparation: &Preparation,
        warnings: &mut Warnings,
    ) -> Result<Grid, PrepareError> {
        let kept = kept(volume.dims(), preparation.crop)?;
        let spacing = volume.spacing();
        // The thickness of a single slice says nothing about the distance of samples.
        let thick = |axis: &usize| kept[*axis].len() > 1;
        let finest = (0..3).filter(thick).map(|a| spacing[a]).fold(f64::INFINITY, f64::min);
        let coarsest = (0..3).filter(thick).map(|a| spacing[a]).fold(0.0, f64::max);
        let grid = |target: f64| {
            let axis = |a: usize| {
                let n = kept[a].len();
                let ratio = spacing[a] / target;
                // Beyond any number that memory holds, it is as good as infinite.
                let steps = ((n - 1) as f64 * ratio).round().min(1e15) as usize;
                Axis::new(kept[a].clone(), if ratio > NEAR { steps } else { 0 }, preparation.cap)
            };
            Grid([axis(0), axis(1), axis(2)])
        };
        let source: u128 = kept.iter().map(|k| k.len() as u128).product();

        let plain = grid(f64::INFINITY);
        if plain.voxels() > FREE.max(PADDED_GROWTH * source) {
            return Err(PrepareError::TooLarge { dims: plain.dims() });
        }
        let wanted = preparation.isotropic.is_some_and(|most| coarsest > most * finest);
        if !wanted {
            return Ok(plain);
        }
        let limit = FREE.max(GROWTH * source).min(MOST).max(plain.voxels());
        let best = grid(finest);
        if best.voxels() <= limit {
            return Ok(best);
        }
        // The smallest step that stays within the limit; infinitely coarse does.
        let (mut low, mut high) = (finest, coarsest);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if grid(middle).voxels() > limit { low = middle } else { high = middle }
        }
        let coarser = grid(high);
        let unit = volume.affine().unit;
        let [x, y, z] = coarser.dims();
        warnings.say(format!(
            "resampled to steps of {high:.4} {unit}, not {finest:.4}, which would take {:.1} times the voxels \
             of the file; it has {x} x {y} x {z} now",
            best.voxels() as f64 / source as f64
        ));
        Ok(coarser)
    }

    pub(super) fn dims(&self) -> [usize; 3] {
        self.0.map(|axis| axis.len)
    }

    fn voxels(&self) -> u128 {
        self.0.iter().map(|axis| axis.len as u128).product()
    }

    /// Where the result lies in the world.
    pub(super) fn affine(&self, source: &Affine) -> Affine {
        let [x, y, z] = self.0;
        let first = |axis: Axis| axis.from as f64 - axis.pad as f64 * axis.step();
        let mut affine = *source;
        affine.origin = source.point([first(x), first(y), first(z)]);
        affine.linear.x_axis *= x.step();
        affine.linear.y_axis *= y.step();
        affine.linear.z_axis *= z.step();
        affine
    }
}

/// The voxels that the crop keeps: those whose centres lie in it, and at least one along each axis.
fn kept(dims: [usize; 3], crop: Option<[[f64; 2]; 3]>) -> Result<[std::ops::Range<usize>; 3], PrepareError> {
    let Some(crop) = crop else { return Ok(dims.map(|n| 0..n)) };
    let mut kept = dims.map(|n| 0..n);
    for (axis, [low, high]) in crop.into_iter().enumerate() {
        if !(0.0..1.0).contains(&low) || high > 1.0 || high.is_nan() || high <= low {
            return Err(PrepareError::Crop { axis: ["x", "y", "z"][axis], low, high });
        }
        // The box of voxel i is i/n … (i + 1)/n.
        let n = dims[axis];
        let first = ((low * n as f64 - 0.5).ceil().max(0.0) as usize).min(n - 1);
        let end = ((high * n as f64 - 0.5).floor() as usize + 1).min(n);
        kept[axis] = if high * (n as f64) < 0.5 || end <= first {
            // None has its centre there: the one in which the middle of the crop lies.
            let middle = ((0.5 * (low + high) * n as f64) as usize).min(n - 1);
            middle..middle + 1
        } else {
            first..end
        };
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_keep_the_voxels_whose_centres_lie_in_them() {
        let x = |low, high| kept([10, 3, 1], Some([[low, high], [0.0, 1.0], [0.0, 1.0]])).map(|[x, _, _]| x);
        assert_eq!(x(0.0, 1.0).unwrap(), 0..10);
        assert_eq!(x(0.5, 1.0).unwrap(), 5..10);
        assert_eq!(x(0.0, 0.5).unwrap(), 0..5);
        assert_eq!(x(0.24, 0.26).unwrap(), 2..3);
        assert_eq!(x(0.0, 0.01).unwrap(), 0..1);
        assert_eq!(x(0.19, 0.21).unwrap(), 2..3);
        assert_eq!(x(0.99, 1.0).unwrap(), 9..10);
        for (low, high) in [(0.5, 0.5), (0.6, 0.5), (-0.1, 0.5), (0.5, 1.1), (f64::NAN, 1.0), (0.0, f64::NAN)]
        {
            assert!(matches!(x(low, high), Err(PrepareError::Crop { axis: "x", .. })), "{low} {high}");
        }
    }

    #[test]
    fn both_ends_stay_where_they_are() {
        for (n, steps, cap) in [(20, 26, false), (113, 224, true), (2, 7, true), (5, 0, true), (1, 0, true)] {
            let axis = Axis::new(4..4 + n, steps, cap);
            assert_eq!(axis.source(axis.pad as i64), (0, 0.0));
            assert_eq!(axis.source((axis.len - 1 - axis.pad) as i64), (n as i64 - 1, 0.0));
            let reach = axis.pad as f64 * axis.step();
            assert!(if cap { (3.0..4.0).contains(&reach) } else { reach == 0.0 }, "{reach}");
        }
    }
}
