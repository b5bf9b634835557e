//! The binary header, of either version and byte order.

use crate::error::ReadErrorKind;

/// Bytes of a NIfTI-1 header.
const FIRST: usize = 348;
/// Bytes of a NIfTI-2 header.
const SECOND: usize = 540;
/// Bytes of the longer header.
pub(super) const LONGEST: usize = SECOND;

/// The fields that matter, widened.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) second: bool,
    pub(super) big_endian: bool,
    /// Header and samples are in one file.
    pub(super) single: bool,
    pub(super) dim: [i64; 8],
    pub(super) datatype: i16,
    /// Where the datatype stands, for messages.
    pub(super) datatype_at: usize,
    pub(super) bitpix: i16,
    pub(super) pixdim: [f64; 8],
    pub(super) vox_offset: f64,
    /// Slope and intercept.
    pub(super) scaling: [f64; 2],
    /// cal_min and cal_max.
    pub(super) display: [f64; 2],
    pub(super) units: i64,
    pub(super) qform_code: i64,
    pub(super) sform_code: i64,
    /// b, c, d of the quaternion, then the offset.
    pub(super) quaternion: [f64; 3],
    pub(super) offset: [f64; 3],
    /// Rows of the sform.
    pub(super) rows: [[f64; 4]; 3],
    pub(super) intent: i64,
    pub(super) intent_name: String,
    pub(super) description: String,
    pub(super) auxiliary: String,
}

/// Numbers at places of a header that is known to be long enough.
struct Bytes<'a> {
    bytes: &'a [u8],
    second: bool,
    big_endian: bool,
}

impl Bytes<'_> {
    fn array<const N: usize>(&self, at: usize) -> [u8; N] {
        let mut word = [0; N];
        // The caller has checked the length of the header; zeros stand for what would lie beyond.
        if let Some(bytes) = self.bytes.get(at..at + N) {
            word.copy_from_slice(bytes);
        }
        if self.big_endian {
            word.reverse();
        }
        word
    }

    fn i16(&self, at: usize) -> i16 {
        i16::from_le_bytes(self.array(at))
    }

    fn i32(&self, at: usize) -> i32 {
        i32::from_le_bytes(self.array(at))
    }

    fn i64(&self, at: usize) -> i64 {
        i64::from_le_bytes(self.array(at))
    }

    /// A code: 16 bits in NIfTI-1, 32 in NIfTI-2.
    fn code(&self, at: usize) -> i64 {
        if self.second { self.i32(at).into() } else { self.i16(at).into() }
    }

    /// A float: single in NIfTI-1, double in NIfTI-2.
    fn float(&self, at: usize) -> f64 {
        if self.second {
            f64::from_le_bytes(self.array(at))
        } else {
            f32::from_le_bytes(self.array(at)).into()
        }
    }

    fn floats<const N: usize>(&self, at: usize) -> [f64; N] {
        let width = if self.second { 8 } else { 4 };
        std::array::from_fn(|i| self.float(at + width * i))
    }

    fn text(&self, at: usize, length: usize) -> String {
        let bytes = self.bytes.get(at..at + length).unwrap_or_default();
        let end = bytes.iter().position(|&b| b == 0).unwrap_or(length);
        String::from_utf8_lossy(&bytes[..end]).into_owned()
    }
}

/// Reads the header at the start of a file.
pub(super) fn parse(bytes: &[u8]) -> Result<Header, ReadErrorKind> {
    let wrong = |at: usize, reason: &str| Err(ReadErrorKind::at_byte(at, reason));
    let Some(size) = bytes.first_chunk::<4>() else {
        return wrong(bytes.len(), "the file ends within the size of its NIfTI header");
    };
    let (length, big_endian) = match (i32::from_le_bytes(*size), i32::from_be_bytes(*size)) {
        (348, _) => (FIRST, false),
        (_, 348) => (FIRST, true),
        (540, _) => (SECOND, false),
        (_, 540) => (SECOND, true),
        _ => return wrong(0, "is no NIfTI header: it does not begin with its size, 348 or 540"),
    };
    if bytes.len() < length {
        return wrong(bytes.len(), &format!("the file ends within the {length} bytes of its NIfTI header"));
    }
    let second = length == SECOND;
    let b = Bytes { bytes: &bytes[..length], second, big_endian };
    let magic_at = if second { 4 } else { 344 };
    let single = match (&b.bytes[magic_at..magic_at + 4], second) {
        (b"n+1\0", false) | (b"n+2\0", true) => true,
        (b"ni1\0", false) | (b"ni2\0", true) => false,
        ([0, ..], false) => {
            return wrong(344, "is an ANALYZE 7.5 header, which says nothing of sides; convert it to NIfTI");
        }
        _ => return wrong(magic_at, "is no NIfTI header: its mark is none of n+1, ni1, n+2, ni2"),
    };
    Ok(fields(&b, single))
}

fn fields(b: &Bytes, single: bool) -> Header {
    // Where a field stands in NIfTI-1 and in NIfTI-2.
    let at = |first: usize, second: usize| if b.second { second } else { first };
    Header {
        second: b.second,
        big_endian: b.big_endian,
        single,
        dim: std::array::from_fn(|i| if b.second { b.i64(16 + 8 * i) } else { b.i16(40 + 2 * i).into() }),
        datatype: b.i16(at(70, 12)),
        datatype_at: at(70, 12),
        bitpix: b.i16(at(72, 14)),
        pixdim: b.floats(at(76, 104)),
        vox_offset: if b.second { b.i64(168) as f64 } else { b.float(108) },
        scaling: b.floats(at(112, 176)),
        display: [b.float(at(128, 200)), b.float(at(124, 192))],
        units: if b.second { b.i32(500).into() } else { b.bytes[123].into() },
        qform_code: b.code(at(252, 344)),
        sform_code: b.code(at(254, 348)),
        quaternion: b.floats(at(256, 352)),
        offset: b.floats(at(268, 376)),
        rows: [b.floats(at(280, 400)), b.floats(at(296, 432)), b.floats(at(312, 464))],
        intent: b.code(at(68, 504)),
        intent_name: b.text(at(328, 508), 16),
        description: b.text(at(148, 240), 80),
        auxiliary: b.text(at(228, 320), 24),
    }
}

impl Header {
    fn dim_at(&self, i: usize) -> usize {
        if self.second { 16 + 8 * i } else { 40 + 2 * i }
    }

    /// The sizes of the declared axes, at least three.
    pub(super) fn axes(&self) -> Result<Vec<u64>, ReadErrorKind> {
        let count = self.dim[0];
        if !(1..=7).contains(&count) {
            return Err(ReadErrorKind::at_byte(self.dim_at(0), format!("{count} axes; NIfTI has 1 to 7")));
        }
        let mut axes = Vec::new();
        for i in 1..=count as usize {
            // Some writers leave 0 for axes of time and beyond.
            let size = if i > 3 && self.dim[i] == 0 { 1 } else { self.dim[i] };
            let size = u64::try_from(size).ok().filter(|&n| n > 0);
            axes.push(size.ok_or_else(|| {
                ReadErrorKind::at_byte(self.dim_at(i), format!("axis {i} has the size {}", self.dim[i]))
            })?);
        }
        axes.resize(axes.len().max(3), 1);
        Ok(axes)
    }

    /// The first three sizes.
    pub(super) fn dims(&self, axes: &[u64]) -> Result<[usize; 3], ReadErrorKind> {
        let mut dims = [1; 3];
        for (dim, &size) in dims.iter_mut().zip(axes) {
            *dim = usize::try_from(size)
                .map_err(|_| ReadErrorKind::TooLarge(format!("declares an axis of {size} voxels")))?;
        }
        Ok(dims)
    }

    /// Where the samples begin in their file.
    pub(super) fn data_at(&self) -> Result<u64, ReadErrorKind> {
        let at = self.vox_offset;
        let place = if self.second { 168 } else { 108 };
        let wrong =
            |reason: &str| Err(ReadErrorKind::at_byte(place, format!("samples at byte {at}: {reason}")));
        let header = if self.second { SECOND } else { FIRST } as u64;
        if !(0.0..=9e15).contains(&at) || at.fract() != 0.0 {
            return wrong("that is no place in a file");
        }
        let at = at as u64;
        match (self.single, at) {
            // Header and the four bytes that announce extensions.
            (true, 0) => Ok(header + 4),
            (true, at) if at < header => wrong("that is within the header"),
            _ => Ok(at),
        }
    }
}

/// A statistical or other meaning of the samples.
pub(super) fn intent(code: i64) -> String {
    let name = match code {
        2 => "correlation",
        3 => "t test",
        4 => "F test",
        5 => "z score",
        6 => "chi squared",
        7 => "beta",
        8 => "binomial",
        22 => "p value",
        23 => "log p value",
        24 => "log10 p value",
        1001 => "estimate",
        1002 => "label",
        1003 => "NeuroNames",
        1004 => "matrix",
        1005 => "symmetric matrix",
        1006 => "displacement vector",
        1007 => "vector",
        1008 => "point set",
        1009 => "triangles",
        1010 => "quaternion",
        1011 => "dimensionless",
        2001 => "time series",
        2002 => "node index",
        2003 => "RGB",
        2004 => "RGBA",
        2005 => "shape",
        _ => return format!("code {code}"),
    };
    name.into()
}
