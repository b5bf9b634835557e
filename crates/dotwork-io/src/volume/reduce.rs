//! From voxels of several numbers to voxels of one: a luminance, a magnitude, or the first of them.

use dotwork_volume::{Sample, Samples, with_samples};

/// What becomes of the numbers of a voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reduction {
    /// The first is taken.
    First,
    /// Red, green, blue (and what follows) become 0.2126 R + 0.7152 G + 0.0722 B (Rec. 709) of the stored numbers.
    Luminance,
    /// Real and imaginary part become the length of the complex number.
    Magnitude,
}

/// A sample that can be averaged.
pub(crate) trait FromF64: Sample {
    /// The nearest sample.
    fn from_f64(value: f64) -> Self;
}

macro_rules! from_f64 {
    ($($integer:ident)*; $($float:ident)*) => {
        // `as` saturates.
        $(impl FromF64 for $integer {
            fn from_f64(value: f64) -> Self { value.round() as $integer }
        })*
        $(impl FromF64 for $float {
            fn from_f64(value: f64) -> Self { value as $float }
        })*
    };
}

from_f64!(u8 i8 u16 i16 u32 i32 u64 i64; f32 f64);

/// Reduces, in place, blocks of `components` runs of `inner` samples to one run each: `inner` is 1 where the
/// components of a voxel lie side by side, and the number of voxels where they lie plane after plane.
pub(crate) fn reduce(samples: &mut Samples, inner: usize, components: usize, reduction: Reduction) {
    with_samples!(samples, v => reduce_typed(v, inner, components, reduction));
}

fn reduce_typed<T: FromF64>(v: &mut Vec<T>, inner: usize, components: usize, reduction: Reduction) {
    let block = inner * components;
    if components < 2 || block == 0 {
        return;
    }
    let blocks = v.len() / block;
    for b in 0..blocks {
        for i in 0..inner {
            // No write reaches a sample that is still to be read: what is written lies at or before what is read.
            let part = |c: usize| v[b * block + c * inner + i].to_f64();
            v[b * inner + i] = match reduction {
                Reduction::Luminance if components >= 3 => {
                    T::from_f64(0.2126 * part(0) + 0.7152 * part(1) + 0.0722 * part(2))
                }
                Reduction::Magnitude if components == 2 => T::from_f64(part(0).hypot(part(1))),
                _ => v[b * block + i],
            };
        }
    }
    v.truncate(blocks * inner);
    v.shrink_to_fit();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interleaved_planar_and_between() {
        let rgb = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 9, 9]];
        let expected = Samples::U8(vec![54, 182, 18, 9]);
        let mut side_by_side = Samples::U8(rgb.concat());
        reduce(&mut side_by_side, 1, 3, Reduction::Luminance);
        assert_eq!(side_by_side, expected);

        let mut planes = Samples::U8((0..3).flat_map(|c| rgb.map(|p| p[c])).collect());
        reduce(&mut planes, 4, 3, Reduction::Luminance);
        assert_eq!(planes, expected);

        let mut rows =
            Samples::U8(rgb.chunks(2).flat_map(|row| (0..3).flat_map(|c| [row[0][c], row[1][c]])).collect());
        reduce(&mut rows, 2, 3, Reduction::Luminance);
        assert_eq!(rows, expected);
    }

    #[test]
    fn first_and_magnitude() {
        let mut samples = Samples::I16((0..12).collect());
        reduce(&mut samples, 2, 3, Reduction::First);
        assert_eq!(samples, Samples::I16(vec![0, 1, 6, 7]));
        let mut complex = Samples::F32(vec![3.0, -4.0, 0.0, 2.0]);
        reduce(&mut complex, 1, 2, Reduction::Magnitude);
        assert_eq!(complex, Samples::F32(vec![5.0, 2.0]));
    }
}
