//! Randomness as a pure function of integers: the same numbers on every machine, thread count and backend.
//!
//! The 32-bit mixer is `lowbias32` by Chris Wellons ("Prospecting for hash functions", 2018): two multiplications,
//! three xor-shifts, every step available in WGSL, so that a shader can draw the same numbers.

/// Mixes one 32-bit integer; a bijection with low bias.
#[inline(always)]
pub const fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// A hash of two integers, `index` within the stream `stream`.
#[inline(always)]
pub const fn hash2(index: u32, stream: u32) -> u32 {
    mix(index ^ mix(stream.wrapping_add(0x9e37_79b9)))
}

/// A hash of three integers.
#[inline(always)]
pub const fn hash3(a: u32, b: u32, c: u32) -> u32 {
    hash2(a, hash2(b, c))
}

/// Maps a hash to `[0, 1)` in steps of 2⁻²⁴, each exactly representable in `f32`.
#[inline(always)]
pub const fn unit(h: u32) -> f32 {
    (h >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values_stay_known() {
        // Files and pictures depend on these values: a change here changes every drawing.
        assert_eq!(mix(0), 0);
        assert_eq!(mix(1), 1_753_845_952);
        assert_eq!(hash2(1, 2), 587_229_646);
    }

    #[test]
    fn unit_is_uniform_in_mean_and_variance() {
        let n = 1 << 16;
        let (mut sum, mut squares) = (0.0f64, 0.0f64);
        for i in 0..n {
            let u = f64::from(unit(hash2(i, 7)));
            assert!((0.0..1.0).contains(&u));
            sum += u;
            squares += u * u;
        }
        let mean = sum / f64::from(n);
        let variance = squares / f64::from(n) - mean * mean;
        assert!((mean - 0.5).abs() < 0.004, "mean {mean}");
        assert!((variance - 1.0 / 12.0).abs() < 0.002, "variance {variance}");
    }
}
