//! Samples written as text: numbers parted by white space or commas, or bytes as pairs of hexadecimal digits.

use bytemuck::{AnyBitPattern, NoUninit};
use dotwork_volume::{Sample, SampleType};

use crate::error::{ReadErrorKind, quote};
use crate::number;
use crate::volume::fill::Fill;

/// A sample that text can give.
trait FromText: Sample + NoUninit + AnyBitPattern {
    /// The number that fills `token`; `None` if it is none of this type.
    fn from_text(token: &[u8]) -> Option<Self>;
}

macro_rules! integers_from_text {
    ($($type:ident)*) => {
        $(impl FromText for $type {
            #[inline]
            fn from_text(token: &[u8]) -> Option<Self> {
                match number::integer(token) {
                    Some((value, length)) if length == token.len() => $type::try_from(value).ok(),
                    _ => $type::try_from(long_integer(token)?).ok(),
                }
            }
        })*
    };
}

integers_from_text!(u8 i8 u16 i16 u32 i32 u64 i64);

impl FromText for f32 {
    #[inline]
    fn from_text(token: &[u8]) -> Option<f32> {
        f64::from_text(token).map(|v| v as f32)
    }
}

impl FromText for f64 {
    #[inline]
    fn from_text(token: &[u8]) -> Option<f64> {
        number::float(token).filter(|&(_, length)| length == token.len()).map(|(value, _)| value)
    }
}

/// An integer of up to 38 digits, or one that is written as a float ("12.0", "1e3").
#[cold]
fn long_integer(token: &[u8]) -> Option<i128> {
    if let Some(value) = std::str::from_utf8(token).ok().and_then(|t| t.parse().ok()) {
        return Some(value);
    }
    let value = f64::from_text(token)?;
    (value.fract() == 0.0 && value.abs() < 1e30).then_some(value as i128)
}

#[inline]
fn parts_numbers(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0x0b || byte == b','
}

/// Reads `count` numbers from the start of `text`, which begins on line `line`; returns how many bytes they took.
///
/// # Errors
/// Fewer numbers, or something that is none of the type.
pub(crate) fn read_numbers(
    fill: &mut Fill,
    text: &[u8],
    line: u64,
    count: usize,
) -> Result<usize, ReadErrorKind> {
    // A number takes a digit and, but for the last, something that parts it from the next.
    if count > text.len() / 2 + 1 {
        return Err(ReadErrorKind::at_line(
            line,
            format!("declares {count} samples, but only {} bytes follow", text.len()),
        ));
    }
    match fill.sample {
        SampleType::U8 => read_typed::<u8>(fill, text, line, count),
        SampleType::I8 => read_typed::<i8>(fill, text, line, count),
        SampleType::U16 => read_typed::<u16>(fill, text, line, count),
        SampleType::I16 => read_typed::<i16>(fill, text, line, count),
        SampleType::U32 => read_typed::<u32>(fill, text, line, count),
        SampleType::I32 => read_typed::<i32>(fill, text, line, count),
        SampleType::U64 => read_typed::<u64>(fill, text, line, count),
        SampleType::I64 => read_typed::<i64>(fill, text, line, count),
        SampleType::F32 => read_typed::<f32>(fill, text, line, count),
        SampleType::F64 => read_typed::<f64>(fill, text, line, count),
    }
}

fn read_typed<T: FromText>(
    fill: &mut Fill,
    text: &[u8],
    line: u64,
    count: usize,
) -> Result<usize, ReadErrorKind> {
    let mut at = 0;
    // Lines are only counted for a message.
    let line_at = |at: usize| line + text[..at].iter().filter(|&&b| b == b'\n').count() as u64;
    for (i, sample) in fill.typed::<T>(count)?.iter_mut().enumerate() {
        while at < text.len() && parts_numbers(text[at]) {
            at += 1;
        }
        let rest = &text[at..];
        let length = rest.iter().position(|&b| parts_numbers(b)).unwrap_or(rest.len());
        if length == 0 {
            return Err(ReadErrorKind::at_line(
                line_at(at),
                format!("the data end too early: {i} of {count} samples are there"),
            ));
        }
        *sample = T::from_text(&rest[..length]).ok_or_else(|| {
            ReadErrorKind::at_line(
                line_at(at),
                format!("{} is no {} sample", quote(&rest[..length]), T::TYPE.name()),
            )
        })?;
        at += length;
    }
    Ok(at)
}

/// Reads `bytes` bytes written as hexadecimal digits; white space between digits is ignored. Returns how many bytes
/// of `text` they took.
///
/// # Errors
/// Fewer digits, or something that is none.
pub(crate) fn read_hex(
    fill: &mut Fill,
    text: &[u8],
    line: u64,
    bytes: usize,
) -> Result<usize, ReadErrorKind> {
    if bytes > text.len() / 2 {
        return Err(ReadErrorKind::at_line(
            line,
            format!("declares {bytes} bytes, but only {} characters follow", text.len()),
        ));
    }
    let line_at = |at: usize| line + text[..at].iter().filter(|&&b| b == b'\n').count() as u64;
    let mut at = 0;
    let mut digit = || {
        while text.get(at).is_some_and(u8::is_ascii_whitespace) {
            at += 1;
        }
        let Some(&byte) = text.get(at) else {
            return Err(ReadErrorKind::at_line(line_at(at), "the hexadecimal digits end too early"));
        };
        let value = char::from(byte).to_digit(16).ok_or_else(|| {
            ReadErrorKind::at_line(line_at(at), format!("{} is no hexadecimal digit", quote(&[byte])))
        })?;
        at += 1;
        Ok(value as u8)
    };
    for byte in fill.room(bytes)? {
        *byte = digit()? << 4 | digit()?;
    }
    Ok(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_volume::Samples;

    fn numbers(sample: SampleType, text: &str, count: usize) -> Result<Samples, String> {
        let mut fill = Fill::new(sample, count as u64).unwrap();
        let read = read_numbers(&mut fill, text.as_bytes(), 5, count).map_err(|e| e.to_string())?;
        assert!(read <= text.len());
        Ok(fill.finish(cfg!(target_endian = "big")))
    }

    #[test]
    fn numbers_of_each_kind() {
        assert_eq!(numbers(SampleType::U8, " 1,2\n255\t7.0", 4), Ok(Samples::U8(vec![1, 2, 255, 7])));
        let wide = format!("{} {} 1e3", u64::MAX, i64::MAX);
        let expected = Samples::U64(vec![u64::MAX, i64::MAX as u64, 1000]);
        assert_eq!(numbers(SampleType::U64, &wide, 3), Ok(expected));
        assert_eq!(
            numbers(SampleType::F32, "0.1 -inf 3e38", 3),
            Ok(Samples::F32(vec![0.1, f32::NEG_INFINITY, 3e38]))
        );
    }

    #[test]
    fn what_is_no_sample_is_named() {
        for (sample, text, count, expected) in [
            (SampleType::U8, "1\n2\n256", 3, "line 7: '256' is no uint8 sample"),
            (SampleType::I8, "1.5 2", 2, "line 5: '1.5' is no int8 sample"),
            (SampleType::U16, "nan 2", 2, "line 5: 'nan' is no uint16 sample"),
            (SampleType::F64, "1 two", 2, "line 5: 'two' is no float64 sample"),
            (SampleType::U8, "1 2       ", 3, "line 5: the data end too early: 2 of 3 samples are there"),
            (SampleType::U8, "1 2", 3_000_000, "line 5: declares 3000000 samples, but only 3 bytes follow"),
        ] {
            assert_eq!(numbers(sample, text, count), Err(expected.into()));
        }
    }

    #[test]
    fn hexadecimal_digits() {
        let mut fill = Fill::new(SampleType::U16, 2).unwrap();
        assert_eq!(read_hex(&mut fill, b"0102 \n fFe 0!", 1, 4).unwrap(), 12);
        assert_eq!(fill.finish(true), Samples::U16(vec![0x0102, 0xffe0]));
        let mut fill = Fill::new(SampleType::U8, 2).unwrap();
        let error = read_hex(&mut fill, b"01\n0x22", 1, 2).unwrap_err();
        assert_eq!(error.to_string(), "line 2: 'x' is no hexadecimal digit");
    }
}
