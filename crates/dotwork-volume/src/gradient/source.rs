//! Samples as the lanes of a filter: from 0, the smallest, upwards.

use rayon::prelude::*;

use crate::samples::Ordered;

/// Samples in a block of work.
const BLOCK: usize = 1 << 15;

/// Numbers that are compared together.
const LANES: usize = 16;

/// The smallest and the largest finite sample; `None` if there are none.
pub(crate) fn finite_range<T: Ordered>(samples: &[T]) -> Option<[T; 2]> {
    let wider =
        |a: [T; 2], b: [T; 2]| [if b[0] < a[0] { b[0] } else { a[0] }, if b[1] > a[1] { b[1] } else { a[1] }];
    let of = |block: &[T]| {
        let first = block.iter().copied().find(|s| s.is_finite())?;
        // Minima side by side, so that none waits for the one before.
        let (mut min, mut max) = ([first; LANES], [first; LANES]);
        let (groups, rest) = block.as_chunks::<LANES>();
        for group in groups {
            for i in 0..LANES {
                let s = if group[i].is_finite() { group[i] } else { first };
                min[i] = if s < min[i] { s } else { min[i] };
                max[i] = if s > max[i] { s } else { max[i] };
            }
        }
        let rest = rest.iter().filter(|s| s.is_finite()).map(|&s| [s, s]);
        Some(min.into_iter().zip(max).map(|(a, b)| [a, b]).chain(rest).fold([first; 2], wider))
    };
    samples.par_chunks(BLOCK).filter_map(of).reduce_with(wider)
}

/// The sample of a key, in the type of `samples`.
pub(super) fn from_key<T: Ordered>(_samples: &[T], key: u64) -> T {
    T::from_key(key)
}

/// The lift of samples whose smallest and largest have these keys.
pub(super) fn lift<T: Ordered>(_samples: &[T], keys: [u64; 2]) -> Lift<T> {
    let [min, max] = keys.map(T::from_key);
    Lift::new(min, max)
}

/// Samples as `f32` from 0 to `top`.
///
/// Types of up to 16 bits are exact: `top` is a whole number below 2¹⁶. Wider ones are scaled to 0…1, after the
/// smallest was subtracted in a type that loses nothing.
#[derive(Clone, Copy)]
pub(crate) struct Lift<T> {
    base: T,
    top: f32,
    inverse: f64,
}

impl<T: Ordered> Lift<T> {
    /// From the smallest to the largest finite sample.
    pub(crate) fn new(min: T, max: T) -> Lift<T> {
        if T::KEY_BITS <= 16 {
            return Lift { base: min, top: max.minus_f32(min).max(1.0), inverse: 1.0 };
        }
        let range = max.minus(min);
        Lift { base: min, top: 1.0, inverse: if range > 0.0 { range.recip() } else { 1.0 } }
    }

    /// What the largest sample becomes (1 if all are equal).
    pub(crate) fn top(&self) -> f32 {
        self.top
    }

    /// Samples for a lane of 1.
    pub(crate) fn step(&self) -> f64 {
        self.inverse.recip()
    }

    /// The sample as a lane; NaN and infinities stay what they are.
    #[inline]
    pub(crate) fn lane(&self, sample: T) -> f32 {
        if T::KEY_BITS <= 16 {
            sample.minus_f32(self.base)
        } else if T::FLOAT && T::KEY_BITS == 32 {
            sample.minus_f32(self.base) * self.inverse as f32
        } else {
            (sample.minus(self.base) * self.inverse) as f32
        }
    }
}
