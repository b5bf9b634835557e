//! Samples without a header, in a layout that a person says.

use std::fmt;
use std::str::FromStr;

use dotwork_drawing::Warnings;
use dotwork_volume::{Affine, SampleType, Scaling};

use crate::error::ReadErrorKind;
use crate::gzip;
use crate::volume::Found;
use crate::volume::data::{After, Part, Skip, byte_count, pour};
use crate::volume::facts::Facts;
use crate::volume::fill::Fill;
use crate::volume::stream::{Packing, Stream};

/// How samples without a header lie in a file.
///
/// As text: `256x256x128:u8`, then in any order and each after a colon: the byte order (`le`, which is meant if
/// nothing is said, or `be`), the spacing (`1,1,1.4`, or one number for all axes), and how many bytes come before the
/// samples (`header=512`). Types are `u8 i8 u16 i16 u32 i32 u64 i64 f32 f64`, or their names (`uint8`, `float32`, …).
///
/// ```
/// use dotwork_io::volume::RawLayout;
///
/// let layout: RawLayout = "64x64x93:u16:be:3.2,3.2,1.5".parse()?;
/// assert_eq!(layout.dims, [64, 64, 93]);
/// assert_eq!(layout.to_string().parse(), Ok(layout));
/// # Ok::<(), dotwork_io::volume::RawLayoutError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RawLayout {
    /// Voxels along x (fastest), y and z; none is 0.
    pub dims: [usize; 3],
    /// Type of the samples.
    pub sample: SampleType,
    /// True if the first byte of a sample is the most significant one.
    pub big_endian: bool,
    /// Distances of voxels along x, y and z.
    pub spacing: [f64; 3],
    /// Bytes before the samples.
    pub header: u64,
}

/// What is wrong with the text of a [`RawLayout`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct RawLayoutError(String);

impl FromStr for RawLayout {
    type Err = RawLayoutError;

    fn from_str(text: &str) -> Result<Self, RawLayoutError> {
        let wrong = |reason: String| RawLayoutError(format!("'{text}': {reason}"));
        let mut parts = text.trim().split(':').map(str::trim);
        let sizes = parts.next().unwrap_or_default();
        let dims: Vec<usize> =
            sizes.split(['x', 'X', '×']).map(|n| n.trim().parse().unwrap_or_default()).collect();
        let dims = <[usize; 3]>::try_from(dims)
            .ok()
            .filter(|d| !d.contains(&0))
            .ok_or_else(|| wrong(format!("'{sizes}' is not WIDTHxHEIGHTxDEPTH, as in 256x256x128")))?;
        let Some(name) = parts.next().filter(|n| !n.is_empty()) else {
            return Err(wrong("the sample type is missing, as in 256x256x128:u8".into()));
        };
        let sample = type_named(name).ok_or_else(|| {
            wrong(format!("'{name}' is no sample type (u8 i8 u16 i16 u32 i32 u64 i64 f32 f64)"))
        })?;
        let mut layout = RawLayout { dims, sample, big_endian: false, spacing: [1.0; 3], header: 0 };
        let mut seen = [false; 3];
        for part in parts {
            let kind = if part == "le" || part == "be" {
                layout.big_endian = part == "be";
                0
            } else if let Some(header) = part.strip_prefix("header=") {
                layout.header = header
                    .parse()
                    .map_err(|_| wrong(format!("'{header}' is no number of bytes before the samples")))?;
                1
            } else {
                layout.spacing = spacing(part).ok_or_else(|| {
                    wrong(format!(
                        "'{part}' is neither le, be, header=BYTES nor three positive spacings, as in 1,1,1.4"
                    ))
                })?;
                2
            };
            if std::mem::replace(&mut seen[kind], true) {
                return Err(wrong(format!("'{part}' says a second time what was said")));
            }
        }
        Ok(layout)
    }
}

fn spacing(text: &str) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|n| n.trim().parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite())).collect();
    match numbers?[..] {
        [x, y, z] => Some([x, y, z]),
        [all] => Some([all; 3]),
        _ => None,
    }
}

fn type_named(name: &str) -> Option<SampleType> {
    let name = name.to_ascii_lowercase();
    SampleType::ALL.iter().copied().find(|t| t.name() == name || short_name(*t) == name)
}

fn short_name(sample: SampleType) -> &'static str {
    match sample {
        SampleType::U8 => "u8",
        SampleType::I8 => "i8",
        SampleType::U16 => "u16",
        SampleType::I16 => "i16",
        SampleType::U32 => "u32",
        SampleType::I32 => "i32",
        SampleType::U64 => "u64",
        SampleType::I64 => "i64",
        SampleType::F32 => "f32",
        SampleType::F64 => "f64",
    }
}

impl fmt::Display for RawLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.dims;
        write!(f, "{x}x{y}x{z}:{}", short_name(self.sample))?;
        if self.sample.bytes() > 1 || self.big_endian {
            f.write_str(if self.big_endian { ":be" } else { ":le" })?;
        }
        if self.spacing != [1.0; 3] {
            let [x, y, z] = self.spacing;
            write!(f, ":{x},{y},{z}")?;
        }
        if self.header > 0 {
            write!(f, ":header={}", self.header)?;
        }
        Ok(())
    }
}

pub(super) fn read(
    bytes: &[u8],
    layout: &RawLayout,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    let sides = layout.dims.map(|d| d as u64);
    let wanted = byte_count(&sides, layout.sample.bytes())?;
    let needed = wanted
        .checked_add(layout.header)
        .ok_or_else(|| ReadErrorKind::TooLarge(format!("{layout} needs more bytes than can be counted")))?;
    // Raw samples may begin with anything, the mark of gzip as well: a file that fits as it is is taken as it is.
    let packed = bytes.len() as u64 != needed && gzip::is_gzip(bytes);
    let (packing, after) =
        if packed { (Packing::Gzip, After::NothingElseWrong) } else { (Packing::None, After::Nothing) };
    if !packed && bytes.len() as u64 != needed {
        return Err(ReadErrorKind::Refused(misfit(bytes.len() as u64, needed, layout)));
    }
    let mut fill = Fill::new(layout.sample, wanted / layout.sample.bytes() as u64)?;
    let part = Part { skip: Skip::Bytes(layout.header), wanted, declared: wanted, after, one_of_many: false };
    pour(&mut fill, Stream::new(bytes, packing), 0, part, warnings)?;
    let order = match (layout.sample.bytes(), layout.big_endian) {
        (1, _) => "",
        (_, false) => ", little endian",
        (_, true) => ", big endian",
    };
    Ok(Found {
        dims: layout.dims,
        samples: fill.finish(layout.big_endian),
        scaling: Scaling::default(),
        affine: Affine::from_spacing(layout.spacing),
        format: format!("raw by option{}{order}", if packed { ", gzip" } else { "" }),
        facts: Facts::default(),
    })
}

/// What a size that does not fit would allow.
fn misfit(there: u64, needed: u64, layout: &RawLayout) -> String {
    let mut text = format!("holds {there} bytes, but {layout} needs {needed}");
    let [x, y, z] = layout.dims.map(|d| d as u64);
    let width = layout.sample.bytes() as u64;
    let slice = x * y * width;
    let mut ways = Vec::new();
    if let Some(left) = there.checked_sub(needed)
        && needed > 0
    {
        ways.push(format!("header={}", left.saturating_add(layout.header)));
    }
    if let Some(data) = there.checked_sub(layout.header)
        && data > 0
    {
        if data % slice == 0 && data / slice != z {
            ways.push(format!("{} slices of {x}x{y}", data / slice));
        }
        let voxels = x * y * z;
        if data % voxels == 0 && matches!(data / voxels, 1 | 2 | 4 | 8) && data / voxels != width {
            ways.push(format!("samples of {} bytes", data / voxels));
        }
    }
    if !ways.is_empty() {
        text.push_str(&format!("; its size would allow {}", ways.join(", or ")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_parsed_and_written() {
        for (text, written) in [
            ("256x256x128:u8", "256x256x128:u8"),
            ("2X3x4:uint16", "2x3x4:u16:le"),
            (" 2x3x4 : f64 : 0.5 : be", "2x3x4:f64:be:0.5,0.5,0.5"),
            ("2x3x4:int8:header=12:1,2,1e-3", "2x3x4:i8:1,2,0.001:header=12"),
            ("2x3x4:U8:be", "2x3x4:u8:be"),
        ] {
            let layout: RawLayout = text.parse().unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(layout.to_string(), written);
            assert_eq!(written.parse(), Ok(layout));
        }
        for &sample in SampleType::ALL {
            let layout = RawLayout {
                dims: [1, 2, 3],
                sample,
                big_endian: true,
                spacing: [0.1, 1.0 / 3.0, 7e9],
                header: u64::MAX,
            };
            assert_eq!(layout.to_string().parse(), Ok(layout));
        }
    }

    #[test]
    fn what_is_no_layout_says_why() {
        for (text, reason) in [
            ("", "'': '' is not WIDTHxHEIGHTxDEPTH, as in 256x256x128"),
            ("2x3:u8", "'2x3:u8': '2x3' is not WIDTHxHEIGHTxDEPTH, as in 256x256x128"),
            ("2x0x3:u8", "'2x0x3:u8': '2x0x3' is not WIDTHxHEIGHTxDEPTH, as in 256x256x128"),
            ("2x3x4", "'2x3x4': the sample type is missing, as in 256x256x128:u8"),
            ("2x3x4:u12", "'2x3x4:u12': 'u12' is no sample type (u8 i8 u16 i16 u32 i32 u64 i64 f32 f64)"),
            (
                "2x3x4:u8:1,2",
                "'2x3x4:u8:1,2': '1,2' is neither le, be, header=BYTES nor three positive spacings, as in 1,1,1.4",
            ),
            ("2x3x4:u8:le:be", "'2x3x4:u8:le:be': 'be' says a second time what was said"),
            ("2x3x4:u8:header=-1", "'2x3x4:u8:header=-1': '-1' is no number of bytes before the samples"),
        ] {
            assert_eq!(text.parse::<RawLayout>().unwrap_err().to_string(), reason);
        }
    }
}
