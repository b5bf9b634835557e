//! Samples in their stored type.
//!
//! Nothing here converts a volume: `uint8` stays one byte a voxel. Where one computes, [`with_samples!`](crate::with_samples) picks the
//! typed vector once and the loop below it is compiled for that type.

use std::fmt;

/// A type that a sample can have.
pub trait Sample: Copy + Send + Sync + 'static {
    /// Its name for messages and `info`.
    const TYPE: SampleType;
    /// The number it stands for; 64-bit integers are rounded to the nearest `f64`.
    fn to_f64(self) -> f64;
    /// Wraps samples of this type.
    fn wrap(samples: Vec<Self>) -> Samples;
}

/// Arithmetic on samples that loses nothing that matters: differences of 64-bit integers near 2⁶³ are taken before
/// they are rounded, and the order of a type can be searched and counted by digits.
pub(crate) trait Ordered: Sample + PartialOrd {
    /// Bits in a key.
    const KEY_BITS: u32 = 8 * size_of::<Self>() as u32;
    /// True if there are fractions, NaN and infinities.
    const FLOAT: bool;

    /// Keys, read as unsigned numbers, have the order of the samples: −∞ is below every finite number, ∞ above, and
    /// NaN above that. The keys of integers have no gaps.
    fn key(self) -> u64;
    /// The inverse of [`Ordered::key`].
    fn from_key(key: u64) -> Self;
    /// Keys of the smallest and the largest sample of the type, infinities included.
    fn key_range() -> (u64, u64);
    /// `self − other`, rounded once.
    fn minus(self, other: Self) -> f64;
    /// `self − other` for gradients; beyond the range of `f32` it is infinite or 0.
    fn minus_f32(self, other: Self) -> f32;
    /// `self − real`, rounded once (integers beyond 2⁵³) or twice.
    fn minus_real(self, real: f64) -> f64;
    /// False for NaN and infinities.
    fn is_finite(self) -> bool;
    /// True for NaN.
    fn is_nan(self) -> bool;
}

macro_rules! sample_types {
    ($($variant:ident $type:ident $name:literal $bytes:literal,)*) => {
        /// The type of a sample.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum SampleType {
            $(#[doc = $name] $variant,)*
        }

        impl SampleType {
            /// Every type.
            pub const ALL: &[SampleType] = &[$(SampleType::$variant),*];

            /// Its name: `uint8`, `float32`, ….
            pub fn name(self) -> &'static str {
                match self { $(SampleType::$variant => $name,)* }
            }

            /// Bytes a sample.
            pub fn bytes(self) -> usize {
                match self { $(SampleType::$variant => $bytes,)* }
            }
        }

        impl fmt::Display for SampleType {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }

        /// Samples of one type, x fastest, then y, then z.
        #[derive(Clone, Debug, PartialEq)]
        pub enum Samples {
            $(#[doc = $name] $variant(Vec<$type>),)*
        }

        impl Samples {
            /// Their type.
            pub fn sample_type(&self) -> SampleType {
                match self { $(Samples::$variant(_) => SampleType::$variant,)* }
            }

            /// How many there are.
            pub fn len(&self) -> usize {
                match self { $(Samples::$variant(v) => v.len(),)* }
            }

            /// True if there are none.
            pub fn is_empty(&self) -> bool {
                self.len() == 0
            }

            /// The number that sample `i` stands for.
            ///
            /// # Panics
            /// If there is no sample `i`.
            pub fn get(&self, i: usize) -> f64 {
                match self { $(Samples::$variant(v) => v[i].to_f64(),)* }
            }
        }

        $(impl Sample for $type {
            const TYPE: SampleType = SampleType::$variant;
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn wrap(samples: Vec<Self>) -> Samples {
                Samples::$variant(samples)
            }
        })*

        /// Runs `$body` with `$v` bound to the typed vector of a [`Samples`], whatever its type.
        #[macro_export]
        macro_rules! with_samples {
            ($samples:expr, $v:ident => $body:expr) => {
                match $samples { $($crate::Samples::$variant($v) => $body,)* }
            };
        }
    };
}

sample_types! {
    U8 u8 "uint8" 1,
    I8 i8 "int8" 1,
    U16 u16 "uint16" 2,
    I16 i16 "int16" 2,
    U32 u32 "uint32" 4,
    I32 i32 "int32" 4,
    U64 u64 "uint64" 8,
    I64 i64 "int64" 8,
    F32 f32 "float32" 4,
    F64 f64 "float64" 8,
}

/// Integers: the sign bit turned over makes signed order unsigned order. `$wide` holds every difference.
macro_rules! ordered_integers {
    ($($type:ident $unsigned:ident $wide:ident,)*) => {
        $(impl Ordered for $type {
            const FLOAT: bool = false;
            fn key(self) -> u64 {
                (self.wrapping_sub($type::MIN) as $unsigned).into()
            }
            fn from_key(key: u64) -> Self {
                (key as $type).wrapping_add($type::MIN)
            }
            fn key_range() -> (u64, u64) {
                (0, $unsigned::MAX.into())
            }
            fn minus(self, other: Self) -> f64 {
                ($wide::from(self) - $wide::from(other)) as f64
            }
            fn minus_f32(self, other: Self) -> f32 {
                ($wide::from(self) - $wide::from(other)) as f32
            }
            fn minus_real(self, real: f64) -> f64 {
                if Self::KEY_BITS < 64 {
                    return self as f64 - real;
                }
                // Neighbours near 2^63 are closer than f64 can tell: the whole part is subtracted as an integer.
                let whole = real.floor();
                (i128::from(self).saturating_sub(whole as i128)) as f64 - (real - whole)
            }
            fn is_finite(self) -> bool {
                true
            }
            fn is_nan(self) -> bool {
                false
            }
        })*
    };
}

ordered_integers! {
    u8 u8 i32,
    i8 u8 i32,
    u16 u16 i32,
    i16 u16 i32,
    u32 u32 i64,
    i32 u32 i64,
    u64 u64 i128,
    i64 u64 i128,
}

/// Floats: the bits of positive numbers are in order above those of negative ones, whose order is turned round.
macro_rules! ordered_floats {
    ($($type:ident $bits:ident,)*) => {
        $(impl Ordered for $type {
            const FLOAT: bool = true;
            fn key(self) -> u64 {
                if self.is_nan() {
                    return $bits::MAX.into();
                }
                let bits = self.to_bits();
                let sign = 1 << ($bits::BITS - 1);
                (if bits & sign == 0 { bits | sign } else { !bits }).into()
            }
            fn from_key(key: u64) -> Self {
                let key = key as $bits;
                let sign = 1 << ($bits::BITS - 1);
                $type::from_bits(if key & sign == 0 { !key } else { key & !sign })
            }
            fn key_range() -> (u64, u64) {
                ($type::NEG_INFINITY.key(), $type::INFINITY.key())
            }
            fn minus(self, other: Self) -> f64 {
                f64::from(self) - f64::from(other)
            }
            fn minus_f32(self, other: Self) -> f32 {
                (self - other) as f32
            }
            fn minus_real(self, real: f64) -> f64 {
                f64::from(self) - real
            }
            fn is_finite(self) -> bool {
                self.is_finite()
            }
            fn is_nan(self) -> bool {
                self.is_nan()
            }
        })*
    };
}

ordered_floats! {
    f32 u32,
    f64 u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys_ascend<T: Ordered + fmt::Debug>(samples: &[T]) {
        for pair in samples.windows(2) {
            assert!(pair[0].key() < pair[1].key(), "{pair:?}");
        }
        for &s in samples {
            assert_eq!(T::from_key(s.key()), s);
            assert!(T::KEY_BITS == 64 || s.key() >> T::KEY_BITS == 0);
        }
    }

    #[test]
    fn keys_have_the_order_of_the_samples() {
        keys_ascend(&[0u8, 1, 127, 128, 255]);
        keys_ascend(&[i8::MIN, -1, 0, 1, i8::MAX]);
        keys_ascend(&[i16::MIN, -300, 0, 300, i16::MAX]);
        keys_ascend(&[u32::MIN, 1, u32::MAX]);
        keys_ascend(&[i64::MIN, -1, 0, i64::MAX]);
        keys_ascend(&[u64::MIN, 1 << 63, u64::MAX]);
        keys_ascend(&[f32::NEG_INFINITY, f32::MIN, -1.0, -1e-45, 0.0, 1e-45, 2.5, f32::MAX, f32::INFINITY]);
        keys_ascend(&[f64::NEG_INFINITY, -1e300, -0.5, 0.0, 5e-324, 1e300, f64::INFINITY]);
        assert!(f32::NAN.key() > f32::INFINITY.key() && (-f64::NAN).key() > f64::INFINITY.key());
        assert!((-0.0f64).key() < 0.0f64.key());
    }

    #[test]
    fn differences_of_large_integers_are_not_rounded_away() {
        let big = 1u64 << 63;
        assert_eq!((big + 3).minus(big + 1), 2.0);
        assert_eq!(big.minus(big + 1), -1.0);
        assert_eq!((big + 3).minus_real(big as f64), 3.0);
        assert_eq!(i64::MAX.minus(i64::MIN), 2f64.powi(64));
        assert_eq!((-5i64).minus_real(-4.5), -0.5);
        assert_eq!(7u8.minus_real(7.25), -0.25);
        assert_eq!(u32::MIN.minus(u32::MAX), -4294967295.0);
    }
}
