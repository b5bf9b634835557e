//! Numbers as text, fast and without surprises: no `-0`, no exponent for ordinary sizes, trailing zeros trimmed.
//!
//! A drawing table holds millions of numbers with a few digits each. A number is scaled by a power of ten, rounded to
//! an integer in double precision (exact enough: an `f32` has 24 bits) and its digits are written
//! backwards, two at a time.

use std::io::{self, Write};

/// Text is handed on in blocks of about this size.
const BLOCK_BYTES: usize = 1 << 16;

/// 10⁰…10¹⁵, all exact.
const POW10: [f64; 16] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// No scaled number is longer than 20 digits, a point and a sign.
const LONGEST: usize = 24;

/// `00`…`99`.
const PAIRS: [[u8; 2]; 100] = {
    let mut pairs = [[0; 2]; 100];
    let mut i = 0;
    while i < 100 {
        pairs[i] = [b'0' + (i / 10) as u8, b'0' + (i % 10) as u8];
        i += 1;
    }
    pairs
};

/// Collects text and hands it to a writer in blocks.
pub(crate) struct TextWriter<W: Write> {
    inner: W,
    block: Vec<u8>,
}

impl<W: Write> TextWriter<W> {
    pub(crate) fn new(inner: W) -> TextWriter<W> {
        TextWriter { inner, block: Vec::with_capacity(BLOCK_BYTES + 4096) }
    }

    /// Appends bytes as they are.
    #[inline]
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.block.extend_from_slice(bytes);
    }

    /// Appends an integer.
    #[inline]
    pub(crate) fn integer(&mut self, n: u64) {
        self.scaled::<0>(n, false);
    }

    /// Appends `n / 1000` in full.
    #[inline]
    pub(crate) fn thousandths(&mut self, n: i64) {
        self.scaled::<3>(n.unsigned_abs(), n < 0);
    }

    /// Appends a finite number rounded to at most 4 decimals.
    #[inline]
    pub(crate) fn decimals4(&mut self, v: f32) {
        let a = f64::from(v.abs()) * 1e4;
        if a < 9e18 {
            self.scaled::<4>((a + 0.5) as u64, v < 0.0);
        } else {
            // `Display` writes all digits and no exponent.
            self.format(format_args!("{v}"));
        }
    }

    /// Appends a finite number rounded to 7 significant digits (whole numbers in full); below 1e-9 and from 1e15 on
    /// with an exponent.
    #[inline]
    pub(crate) fn digits7(&mut self, v: f32) {
        let a = f64::from(v.abs());
        if (1e-3..1e7).contains(&a) {
            // The common sizes, each with its divisor known to the compiler.
            let negative = v < 0.0;
            let round = |scale: f64| (a * scale + 0.5) as u64;
            match a {
                1e6.. => self.scaled::<0>(round(1e0), negative),
                1e5.. => self.scaled::<1>(round(1e1), negative),
                1e4.. => self.scaled::<2>(round(1e2), negative),
                1e3.. => self.scaled::<3>(round(1e3), negative),
                1e2.. => self.scaled::<4>(round(1e4), negative),
                1e1.. => self.scaled::<5>(round(1e5), negative),
                1e0.. => self.scaled::<6>(round(1e6), negative),
                1e-1.. => self.scaled::<7>(round(1e7), negative),
                1e-2.. => self.scaled::<8>(round(1e8), negative),
                _ => self.scaled::<9>(round(1e9), negative),
            }
        } else if a == 0.0 {
            self.block.push(b'0');
        } else if (1e7..1e15).contains(&a) {
            self.scaled::<0>((a + 0.5) as u64, v < 0.0);
        } else if (1e-9..1e-3).contains(&a) {
            self.small(a, v < 0.0);
        } else {
            self.format(format_args!("{v:.6e}"));
        }
    }

    /// 1e-9 ≤ a < 1e-3 with 10 to 15 decimals.
    #[cold]
    fn small(&mut self, a: f64, negative: bool) {
        let decimals = (10..15).find(|&d| a * POW10[d] >= 1e6).unwrap_or(15);
        let n = (a * POW10[decimals] + 0.5) as u64;
        // More zeros on the right cost nothing: they are trimmed.
        self.scaled::<15>(n * 10u64.pow(15 - decimals as u32), negative);
    }

    #[cold]
    fn format(&mut self, text: std::fmt::Arguments<'_>) {
        // A vector takes everything.
        let _ = self.block.write_fmt(text);
    }

    /// Appends `n / 10^D` without trailing zeros.
    #[inline]
    fn scaled<const D: usize>(&mut self, n: u64, negative: bool) {
        // Digits are written backwards from the middle; what follows pads the copy below.
        let mut text = [0u8; 2 * LONGEST];
        let mut at = LONGEST;
        let mut end = LONGEST;
        let one = const { 10u64.pow(D as u32) };
        let mut rest = n / one;
        let mut fraction = n % one;
        if fraction != 0 {
            let point = LONGEST - D - 1;
            while at > point + 2 {
                at -= 2;
                text[at..at + 2].copy_from_slice(&PAIRS[(fraction % 100) as usize]);
                fraction /= 100;
            }
            if at > point + 1 {
                text[at - 1] = b'0' + fraction as u8;
            }
            while text[end - 1] == b'0' {
                end -= 1;
            }
            at = point;
            text[at] = b'.';
        }
        while rest >= 100 {
            at -= 2;
            text[at..at + 2].copy_from_slice(&PAIRS[(rest % 100) as usize]);
            rest /= 100;
        }
        if rest >= 10 {
            at -= 2;
            text[at..at + 2].copy_from_slice(&PAIRS[rest as usize]);
        } else {
            at -= 1;
            text[at] = b'0' + rest as u8;
        }
        if negative && n != 0 {
            at -= 1;
            text[at] = b'-';
        }
        // A copy of known length and a cut are cheaper than a copy of unknown length.
        let length = self.block.len() + end - at;
        self.block.extend_from_slice(&text[at..at + LONGEST]);
        self.block.truncate(length);
    }

    /// Hands the block on if it is full.
    #[inline]
    pub(crate) fn pass_on(&mut self) -> io::Result<()> {
        if self.block.len() >= BLOCK_BYTES { self.pass_all_on() } else { Ok(()) }
    }

    /// The writer below, for bytes that need no block; hand everything on first.
    pub(crate) fn writer(&mut self) -> &mut W {
        &mut self.inner
    }

    /// Hands everything on (and does not flush the writer below).
    pub(crate) fn pass_all_on(&mut self) -> io::Result<()> {
        self.inner.write_all(&self.block)?;
        self.block.clear();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(write: impl FnOnce(&mut TextWriter<Vec<u8>>)) -> String {
        let mut w = TextWriter::new(Vec::new());
        write(&mut w);
        w.pass_all_on().unwrap();
        String::from_utf8(w.inner).unwrap()
    }

    #[test]
    fn known_numbers() {
        for (v, four, seven) in [
            (0.0, "0", "0"),
            (-0.0, "0", "0"),
            (1.0, "1", "1"),
            (-2.5, "-2.5", "-2.5"),
            (0.1, "0.1", "0.1"),
            (-0.00004, "0", "-0.00004"),
            (0.03125, "0.0313", "0.03125"),
            (1023.99999, "1024", "1024"),
            (123.456_79, "123.4568", "123.4568"),
            (9.999_999, "10", "9.999999"),
            (1.0e-7, "0", "0.0000001"),
            (-4.371_139e-8, "0", "-0.00000004371139"),
            (2.0e-9, "0", "0.000000002"),
            (16_777_216.0, "16777216", "16777216"),
            (1.0e-12, "0", "1.000000e-12"),
            (-1.0e20, "-100000000000000000000", "-1.000000e20"),
        ] {
            assert_eq!(text(|w| w.decimals4(v)), four, "{v}");
            assert_eq!(text(|w| w.digits7(v)), seven, "{v}");
        }
        assert_eq!(text(|w| w.integer(0)), "0");
        assert_eq!(text(|w| w.integer(u64::MAX)), u64::MAX.to_string());
        for (n, thousandths) in [(0, "0"), (-7, "-0.007"), (1200, "1.2"), (i64::MIN, "-9223372036854775.808")]
        {
            assert_eq!(text(|w| w.thousandths(n)), thousandths);
        }
    }

    /// Values of every size, both signs, and the neighbours of powers of ten.
    fn samples() -> impl Iterator<Item = f32> {
        let spread = (0..200_000u32).map(|i| f32::from_bits(i.wrapping_mul(2_654_435_761)));
        let near = (-30..30).flat_map(|e| {
            let p = 10f64.powi(e) as f32;
            (-3i32..=3).flat_map(move |ulps| {
                let v = f32::from_bits(p.to_bits().wrapping_add_signed(ulps));
                [v, -v]
            })
        });
        spread.chain(near).chain([f32::MIN_POSITIVE, f32::MAX, f32::from_bits(1)]).filter(|v| v.is_finite())
    }

    #[test]
    fn numbers_come_back_within_the_stated_precision() {
        let mut checked = 0;
        for v in samples() {
            let exact = f64::from(v);
            let (four, seven) = (text(|w| w.decimals4(v)), text(|w| w.digits7(v)));
            let (a, b): (f64, f64) = (four.parse().unwrap(), seven.parse().unwrap());
            assert!((a - exact).abs() <= 0.5e-4 + exact.abs() * 1e-7, "{v:e} as {four}");
            // Half a unit of the 7th digit is at most 5e-7 of the number.
            assert!((b - exact).abs() <= exact.abs() * 5.000_001e-7, "{v:e} as {seven}");
            for number in [&four, &seven] {
                assert!(number != "-0" && !number.ends_with('.'), "{v:e} as {number}");
                assert!(
                    !(number.contains('.') && number.ends_with('0') && !number.contains('e')),
                    "{number}"
                );
            }
            assert!(!four.contains('e'));
            if (1e-9..1e15).contains(&exact.abs()) {
                assert!(!seven.contains('e'));
                let digits = seven.trim_start_matches(['-', '0', '.']).replace('.', "");
                assert!(digits.len() <= 7 || !seven.contains('.'), "{v:e} as {seven}");
            }
            checked += 1;
        }
        assert!(checked > 190_000);
    }
}
