//! Decimal numbers from bytes: fast where that is exact, `str::parse` elsewhere.
//!
//! A decimal `m · 10ᵉ` with `m < 2⁵³` and `|e| ≤ 22` is one exact integer multiplied or divided by one exact power of
//! ten, so that a single IEEE operation rounds correctly (William D. Clinger, "How to read floating point numbers
//! accurately", 1990). Nearly every coordinate in nearly every file is of this kind; the rest (17 digits and more,
//! extreme exponents, `nan`, `inf`) goes through `str::parse`, which is correctly rounded too.

/// Powers of ten that are exact in `f64`.
const TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// True for what ends a token: white space, or the backslash of a continued line.
#[inline(always)]
pub(crate) fn ends_token(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | b'\\')
}

/// The token at the start of `bytes`.
pub(crate) fn token(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().position(|&b| ends_token(b)).unwrap_or(bytes.len());
    &bytes[..end]
}

/// The number at the start of `bytes`, correctly rounded, and its length; `None` if the token is no number.
/// `nan` and `inf` count as numbers.
#[inline]
pub(crate) fn float(bytes: &[u8]) -> Option<(f64, usize)> {
    match short_decimal(bytes) {
        Some(found) => Some(found),
        None => long_decimal(bytes),
    }
}

/// The exact fast path; `None` means "hard", not "wrong".
#[inline]
fn short_decimal(bytes: &[u8]) -> Option<(f64, usize)> {
    let at = |i: usize| bytes.get(i).copied().unwrap_or(b' ');
    let negative = at(0) == b'-';
    let mut i = usize::from(negative || at(0) == b'+');
    let first = i;
    let mut mantissa = 0u64;
    // 19 digits cannot overflow 64 bits; longer runs are rejected below, after the wrapping did no harm.
    let mut digit = at(i).wrapping_sub(b'0');
    while digit < 10 {
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        i += 1;
        digit = at(i).wrapping_sub(b'0');
    }
    let mut digits = i - first;
    let mut exponent = 0i64;
    if at(i) == b'.' {
        i += 1;
        let point = i;
        let mut digit = at(i).wrapping_sub(b'0');
        while digit < 10 {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            i += 1;
            digit = at(i).wrapping_sub(b'0');
        }
        digits += i - point;
        exponent = -((i - point) as i64);
    }
    if digits == 0 || digits > 19 || mantissa > 1 << 53 {
        return None;
    }
    if at(i) | 0x20 == b'e' {
        i += 1;
        let below_one = at(i) == b'-';
        i += usize::from(below_one || at(i) == b'+');
        let start = i;
        let mut power = 0i64;
        while at(i).wrapping_sub(b'0') < 10 && i - start < 5 {
            power = power * 10 + i64::from(at(i) - b'0');
            i += 1;
        }
        if i == start {
            return None;
        }
        exponent += if below_one { -power } else { power };
    }
    if !ends_token(at(i)) {
        return None;
    }
    let scale = TENS.get(exponent.unsigned_abs() as usize)?;
    let magnitude = if exponent < 0 { mantissa as f64 / scale } else { mantissa as f64 * scale };
    Some((if negative { -magnitude } else { magnitude }, i))
}

#[cold]
fn long_decimal(bytes: &[u8]) -> Option<(f64, usize)> {
    let token = token(bytes);
    let value = std::str::from_utf8(token).ok()?.parse().ok()?;
    Some((value, token.len()))
}

/// The integer at the start of `bytes` (a sign allowed) and its length, whatever follows it; `None` if there is none
/// or it needs more than 18 digits.
#[inline]
pub(crate) fn integer(bytes: &[u8]) -> Option<(i64, usize)> {
    let at = |i: usize| bytes.get(i).copied().unwrap_or(b' ');
    let negative = at(0) == b'-';
    let start = usize::from(negative || at(0) == b'+');
    let mut i = start;
    let mut value = 0i64;
    let mut digit = at(i).wrapping_sub(b'0');
    while digit < 10 {
        if i - start == 18 {
            return None;
        }
        value = value * 10 + i64::from(digit);
        i += 1;
        digit = at(i).wrapping_sub(b'0');
    }
    (i > start).then_some((if negative { -value } else { value }, i))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::hash::hash2;

    #[test]
    fn every_float_is_correctly_rounded() {
        let mut texts: Vec<String> = [
            "0",
            "-0",
            "0.0",
            "1",
            "+1",
            "1.",
            ".5",
            "-.5",
            "1e5",
            "1E+5",
            "1e-5",
            "123456789012345678",
            "9007199254740993",
            "9007199254740992",
            "0.1",
            "1e22",
            "1e23",
            "1e-22",
            "1e-23",
            "1e400",
            "1e-400",
            "4.9e-324",
            "2.2250738585072011e-308",
            "179769313486231580000000000000000000000",
            "1e00000000000000001",
            "0.000000000000000000000000000001",
            "00000000000000000000000000001.5",
            "inf",
            "-inf",
            "infinity",
            "8.41e21",
            "6.0221e23",
            "1e99999999999999999999",
        ]
        .map(String::from)
        .to_vec();
        for i in 0..40_000 {
            let bits = u64::from(hash2(i, 1)) << 32 | u64::from(hash2(i, 2));
            let wide = f64::from_bits(bits);
            let near = (hash2(i, 3) as f64 - 2e9) / 10f64.powi((hash2(i, 4) % 12) as i32);
            for value in [wide, near, f64::from(f32::from_bits(hash2(i, 5)))] {
                if value.is_finite() {
                    texts.extend([format!("{value}"), format!("{value:e}"), format!("{value:.6}")]);
                }
            }
        }
        for text in &texts {
            let expected: f64 = text.parse().unwrap();
            for (tail, tailed) in
                [("", text.clone()), (" 7", format!("{text} 7")), ("\r\n", format!("{text}\r\n"))]
            {
                let (value, length) = float(tailed.as_bytes()).unwrap_or_else(|| panic!("{text:?}"));
                assert_eq!(value.to_bits(), expected.to_bits(), "{text:?} before {tail:?}");
                assert_eq!(length, text.len(), "{text:?}");
            }
        }
        assert!(float(b"nan").unwrap().0.is_nan());
    }

    #[test]
    fn what_is_no_float_is_none() {
        for bad in [
            "", " 1", "-", ".", "+.", "e5", "1e", "1e+", "1,5", "1.#INF", "0x10", "1..2", "--1", "1f", "abc",
            "1_0",
        ] {
            assert_eq!(float(bad.as_bytes()), None, "{bad:?}");
        }
    }

    #[test]
    fn integers() {
        assert_eq!(integer(b"12/3"), Some((12, 2)));
        assert_eq!(integer(b"-7 "), Some((-7, 2)));
        assert_eq!(integer(b"+7"), Some((7, 2)));
        assert_eq!(integer(b"999999999999999999"), Some((999_999_999_999_999_999, 18)));
        for bad in ["", "-", "x", "/1", "9999999999999999999"] {
            assert_eq!(integer(bad.as_bytes()), None, "{bad:?}");
        }
    }
}
