//! Small volume files for the tests.

#![allow(dead_code, reason = "each test file uses its share")]

use std::io::Write;
use std::path::{Path, PathBuf};

use dotwork_drawing::Warnings;
use dotwork_io::volume::{VolumeFile, VolumeOptions, read_volume_bytes};
use dotwork_io::{ReadError, ReadErrorKind};

/// Reads `bytes` as a file of that name, beside which lie `others`.
pub fn read_among(
    name: &str,
    bytes: &[u8],
    others: &[(&str, &[u8])],
    options: &VolumeOptions,
) -> (Result<VolumeFile, ReadError>, Vec<String>) {
    let mut warnings = Warnings::new();
    let mut sibling = |path: &Path| {
        let found = others.iter().find(|(name, _)| Path::new(name) == path);
        found
            .map(|(_, bytes)| bytes.to_vec())
            .ok_or(ReadError { path: PathBuf::from(path), kind: ReadErrorKind::Missing })
    };
    let read = read_volume_bytes(Path::new(name), bytes, options, &mut sibling, &mut warnings);
    (read, warnings.iter().map(ToString::to_string).collect())
}

/// Reads `bytes` as a file of that name; says what warnings there were.
pub fn read(name: &str, bytes: &[u8]) -> (VolumeFile, Vec<String>) {
    let (read, warnings) = read_among(name, bytes, &[], &VolumeOptions::default());
    (read.unwrap_or_else(|e| panic!("{e}")), warnings)
}

/// Reads what must be read without a warning.
pub fn read_quietly(name: &str, bytes: &[u8]) -> VolumeFile {
    let (file, warnings) = read(name, bytes);
    assert_eq!(warnings, [""; 0], "{name}");
    file
}

/// The message of the refusal.
pub fn refusal(name: &str, bytes: &[u8]) -> String {
    refusal_among(name, bytes, &[])
}

pub fn refusal_among(name: &str, bytes: &[u8], others: &[(&str, &[u8])]) -> String {
    let (read, _) = read_among(name, bytes, others, &VolumeOptions::default());
    let message = read.expect_err("should be refused").to_string();
    assert!(!message.contains('\n'), "{message:?}");
    message
}

/// Reads a file that may be damaged; what comes must be a whole volume or an error on one line. True for a volume.
pub fn reads_soundly(name: &str, bytes: &[u8], others: &[(&str, &[u8])], options: &VolumeOptions) -> bool {
    let (read, warnings) = read_among(name, bytes, others, options);
    assert!(warnings.iter().all(|w| !w.contains('\n')), "{name}: {warnings:?}");
    match read {
        Ok(file) => {
            assert_eq!(file.volume.samples().len(), file.volume.dims().iter().product::<usize>());
            assert!(
                file.facts.iter().all(|(n, t)| !n.contains('\n') && !t.contains('\n')),
                "{:?}",
                file.facts
            );
            true
        }
        Err(e) => {
            assert!(!e.to_string().contains('\n'), "{e}");
            false
        }
    }
}

/// A good file is refused once one thing in it is replaced: `cases` say what, by what, and for which reason.
pub fn refused_with(name: &str, good: &[u8], cases: &[(&str, &str, &str)]) {
    let good = std::str::from_utf8(good).expect("samples that are text");
    assert!(read_among(name, good.as_bytes(), &[], &VolumeOptions::default()).0.is_ok());
    for (from, to, reason) in cases {
        assert!(good.contains(from), "{from}");
        let message = refusal(name, good.replacen(from, to, 1).as_bytes());
        assert_eq!(message, format!("{name}: {reason}"));
    }
}

/// The samples as numbers.
pub fn numbers(file: &VolumeFile) -> Vec<f64> {
    let samples = file.volume.samples();
    (0..samples.len()).map(|i| samples.get(i)).collect()
}

/// The matrix of the affine by columns, then the origin.
pub fn columns(file: &VolumeFile) -> [[f64; 3]; 4] {
    let a = file.volume.affine();
    [a.linear.x_axis, a.linear.y_axis, a.linear.z_axis, a.origin].map(|v| v.to_array())
}

pub fn close(a: [[f64; 3]; 4], b: [[f64; 3]; 4]) -> bool {
    a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-6)
}

pub fn fact<'a>(file: &'a VolumeFile, name: &str) -> Option<&'a str> {
    file.facts.iter().find(|(n, _)| n == name).map(|(_, text)| text.as_str())
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// The numbers 0 to 23 as int16 of either byte order.
pub fn int16(big_endian: bool) -> Vec<u8> {
    (0..24i16).flat_map(|i| if big_endian { i.to_be_bytes() } else { i.to_le_bytes() }).collect()
}

/// What the samples of [`int16`] are.
pub fn counting() -> Vec<f64> {
    (0..24).map(f64::from).collect()
}

/// The header of an attached NRRD file, with further lines.
pub fn nrrd(fields: &str, data: &[u8]) -> Vec<u8> {
    [b"NRRD0005\n# made by a test\n", fields.as_bytes(), b"\n", data].concat()
}

/// 2 x 3 x 4 int16 in NRRD, with further lines.
pub fn nrrd_int16(fields: &str, data: &[u8]) -> Vec<u8> {
    nrrd(&format!("type: short\ndimension: 3\nsizes: 2 3 4\nendian: little\n{fields}"), data)
}

/// The fields of a NIfTI header that the tests change.
#[derive(Clone)]
pub struct Nifti {
    pub second: bool,
    pub big_endian: bool,
    pub single: bool,
    pub dim: [i64; 8],
    pub datatype: i16,
    pub bitpix: i16,
    pub pixdim: [f64; 8],
    pub vox_offset: f64,
    pub scaling: [f64; 2],
    pub units: u8,
    pub codes: [i16; 2],
    pub quaternion: [f64; 6],
    pub rows: [[f64; 4]; 3],
    pub intent: i16,
    pub description: &'static str,
}

impl Default for Nifti {
    fn default() -> Self {
        Nifti {
            second: false,
            big_endian: false,
            single: true,
            dim: [3, 2, 3, 4, 1, 1, 1, 1],
            datatype: 4,
            bitpix: 16,
            pixdim: [1.0, 0.5, 0.75, 2.5, 0.0, 0.0, 0.0, 0.0],
            vox_offset: 0.0,
            scaling: [0.0, 0.0],
            units: 2,
            codes: [0, 1],
            quaternion: [0.0; 6],
            rows: [[0.5, 0.0, 0.0, 1.0], [0.0, 0.75, 0.0, 2.0], [0.0, 0.0, 2.5, 3.0]],
            intent: 0,
            description: "made by a test",
        }
    }
}

impl Nifti {
    pub fn header(&self) -> Vec<u8> {
        let mut bytes = vec![0; if self.second { 540 } else { 348 }];
        let mut put = |at: usize, number: &[u8]| {
            let mut number = number.to_vec();
            if self.big_endian {
                number.reverse();
            }
            bytes[at..at + number.len()].copy_from_slice(&number);
        };
        let float = |v: f64| {
            if self.second { v.to_le_bytes().to_vec() } else { (v as f32).to_le_bytes().to_vec() }
        };
        let width = if self.second { 8 } else { 4 };
        let [dim, datatype, pixdim, offset, slope, units, codes, quaternion, rows, intent] = if self.second {
            [16, 12, 104, 168, 176, 500, 344, 352, 400, 504]
        } else {
            [40, 70, 76, 108, 112, 123, 252, 256, 280, 68]
        };
        put(0, &(if self.second { 540i32 } else { 348 }).to_le_bytes());
        for (i, &d) in self.dim.iter().enumerate() {
            if self.second {
                put(dim + 8 * i, &d.to_le_bytes());
            } else {
                put(dim + 2 * i, &(d as i16).to_le_bytes());
            }
        }
        put(datatype, &self.datatype.to_le_bytes());
        put(datatype + 2, &self.bitpix.to_le_bytes());
        for (i, &v) in self.pixdim.iter().enumerate() {
            put(pixdim + width * i, &float(v));
        }
        if self.second {
            put(offset, &(self.vox_offset as i64).to_le_bytes());
            put(units, &i32::from(self.units).to_le_bytes());
            put(codes, &i32::from(self.codes[0]).to_le_bytes());
            put(codes + 4, &i32::from(self.codes[1]).to_le_bytes());
            put(intent, &i32::from(self.intent).to_le_bytes());
        } else {
            put(offset, &float(self.vox_offset));
            put(units, &[self.units]);
            put(codes, &self.codes[0].to_le_bytes());
            put(codes + 2, &self.codes[1].to_le_bytes());
            put(intent, &self.intent.to_le_bytes());
        }
        for (i, &v) in self.scaling.iter().enumerate() {
            put(slope + width * i, &float(v));
        }
        for (i, &v) in self.quaternion.iter().enumerate() {
            put(quaternion + width * i, &float(v));
        }
        for (r, row) in self.rows.iter().enumerate() {
            for (c, &v) in row.iter().enumerate() {
                put(rows + width * (4 * r + c), &float(v));
            }
        }
        let mark: &[u8] = match (self.second, self.single) {
            (false, true) => b"n+1\0",
            (false, false) => b"ni1\0",
            (true, true) => b"n+2\0\r\n\x1a\n",
            (true, false) => b"ni2\0\r\n\x1a\n",
        };
        let at = if self.second { 4 } else { 344 };
        bytes[at..at + mark.len()].copy_from_slice(mark);
        let at = if self.second { 240 } else { 148 };
        bytes[at..at + self.description.len()].copy_from_slice(self.description.as_bytes());
        bytes
    }

    /// One file: header, no extensions, samples.
    pub fn file(&self, data: &[u8]) -> Vec<u8> {
        [self.header(), vec![0; 4], data.to_vec()].concat()
    }
}

/// A little-endian or big-endian TIFF file of pages without compression: tags with 32-bit values, and the samples.
pub struct TiffPage<'a> {
    pub tags: Vec<(u16, u32)>,
    pub data: &'a [u8],
}

/// Tags of a gray page of `bits` bits.
pub fn gray_page(width: u32, height: u32, bits: u32, data: &[u8]) -> TiffPage<'_> {
    TiffPage {
        tags: vec![(256, width), (257, height), (258, bits), (259, 1), (262, 1), (277, 1), (278, height)],
        data,
    }
}

pub fn tiff_file(big_endian: bool, pages: &[TiffPage]) -> Vec<u8> {
    let u16 = |v: u16| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
    let u32 = |v: u32| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() };
    let mut bytes = if big_endian { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
    let mut pointer = bytes.len();
    bytes.extend(u32(0));
    for page in pages {
        let data_at = bytes.len() as u32;
        bytes.extend(page.data);
        let here = bytes.len() as u32;
        bytes[pointer..pointer + 4].copy_from_slice(&u32(here));
        let mut tags = page.tags.clone();
        for (tag, value) in [(273, data_at), (279, page.data.len() as u32)] {
            if !tags.iter().any(|t| t.0 == tag) {
                tags.push((tag, value));
            }
        }
        tags.sort_unstable();
        bytes.extend(u16(tags.len() as u16));
        for (tag, value) in tags {
            bytes.extend(u16(tag));
            bytes.extend(u16(4));
            bytes.extend(u32(1));
            bytes.extend(u32(value));
        }
        pointer = bytes.len();
        bytes.extend(u32(0));
    }
    bytes
}
