//! Small DICOM files for the tests, and where the real ones are.

#![allow(dead_code, reason = "each test file uses its share")]

use std::path::{Path, PathBuf};

use dotwork_drawing::Warnings;
use dotwork_io::ReadError;
use dotwork_io::volume::{VolumeFile, VolumeOptions, read_volume};

pub fn shared(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name)
}

pub fn kept(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/dicom")).join(name)).unwrap()
}

/// Reads a file or a folder; says what warnings there were.
pub fn read_path(path: &Path) -> (Result<VolumeFile, ReadError>, Vec<String>) {
    let mut warnings = Warnings::new();
    let read = read_volume(path, &VolumeOptions::default(), &mut warnings);
    (read, warnings.iter().map(ToString::to_string).collect())
}

pub fn series_of(path: &Path, series: &str) -> (Result<VolumeFile, ReadError>, Vec<String>) {
    let mut warnings = Warnings::new();
    let read = read_volume(
        path,
        &VolumeOptions { series: Some(series.into()), ..VolumeOptions::default() },
        &mut warnings,
    );
    (read, warnings.iter().map(ToString::to_string).collect())
}

/// Data sets for the tests: elements with a type, in any order of making, sorted when written.
#[derive(Clone, Default)]
pub struct Set(Vec<(u32, &'static str, Value)>);

#[derive(Clone)]
pub enum Value {
    Bytes(Vec<u8>),
    /// Items, with their lengths or with delimiters.
    Items(Vec<Set>, bool),
}

/// How a set is written.
#[derive(Clone, Copy, PartialEq)]
pub enum Form {
    Explicit,
    Implicit,
    BigEndian,
}

impl Set {
    pub fn put(mut self, tag: u32, vr: &'static str, value: Value) -> Set {
        self.0.retain(|e| e.0 != tag);
        self.0.push((tag, vr, value));
        self
    }

    pub fn text(self, tag: u32, vr: &'static str, text: &str) -> Set {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize(bytes.len().next_multiple_of(2), b' ');
        self.put(tag, vr, Value::Bytes(bytes))
    }

    /// A binary number, little endian here and turned when written.
    pub fn short(self, tag: u32, number: u16) -> Set {
        self.put(tag, "US", Value::Bytes(number.to_le_bytes().to_vec()))
    }

    pub fn without(mut self, tag: u32) -> Set {
        self.0.retain(|e| e.0 != tag);
        self
    }

    pub fn items(self, tag: u32, items: Vec<Set>, delimited: bool) -> Set {
        self.put(tag, "SQ", Value::Items(items, delimited))
    }

    pub fn bytes(&self, form: Form) -> Vec<u8> {
        let u16 = |v: u16| if form == Form::BigEndian { v.to_be_bytes() } else { v.to_le_bytes() };
        let u32 = |v: u32| if form == Form::BigEndian { v.to_be_bytes() } else { v.to_le_bytes() };
        let tag_of = |t: u32| [u16((t >> 16) as u16), u16(t as u16)].concat();
        let mut elements = self.0.clone();
        elements.sort_by_key(|e| e.0);
        let mut out = Vec::new();
        for (tag, vr, value) in elements {
            let (value, length) = match value {
                Value::Bytes(mut bytes) => {
                    if form == Form::BigEndian && matches!(vr, "US" | "SS" | "OW") {
                        bytes.as_chunks_mut::<2>().0.iter_mut().for_each(|w| w.reverse());
                    }
                    let length = bytes.len() as u32;
                    (bytes, length)
                }
                Value::Items(items, delimited) => {
                    let mut value = Vec::new();
                    for item in items {
                        let item = item.bytes(form);
                        value.extend(tag_of(0xfffe_e000));
                        value.extend(u32(if delimited { u32::MAX } else { item.len() as u32 }));
                        value.extend(item);
                        if delimited {
                            value.extend([tag_of(0xfffe_e00d), u32(0).to_vec()].concat());
                        }
                    }
                    if delimited {
                        value.extend([tag_of(0xfffe_e0dd), u32(0).to_vec()].concat());
                    }
                    let length = if delimited { u32::MAX } else { value.len() as u32 };
                    (value, length)
                }
            };
            out.extend(tag_of(tag));
            match (form, vr) {
                (Form::Implicit, _) => out.extend(u32(length)),
                (_, "OB" | "OW" | "OF" | "SQ" | "UN" | "UT") => {
                    out.extend(vr.as_bytes());
                    out.extend([0, 0]);
                    out.extend(u32(length));
                }
                _ => {
                    out.extend(vr.as_bytes());
                    out.extend(u16(length as u16));
                }
            }
            out.extend(value);
        }
        out
    }

    /// A file: preamble, meta information, this set.
    pub fn file_as(&self, form: Form, uid: &str) -> Vec<u8> {
        let meta = Set::default().text(0x0002_0010, "UI", uid).bytes(Form::Explicit);
        let length =
            Set::default().put(0x0002_0000, "UL", Value::Bytes((meta.len() as u32).to_le_bytes().to_vec()));
        [&[0; 128][..], b"DICM", &length.bytes(Form::Explicit), &meta, &self.bytes(form)].concat()
    }

    pub fn file(&self) -> Vec<u8> {
        self.file_as(Form::Explicit, EXPLICIT)
    }
}

pub const EXPLICIT: &str = "1.2.840.10008.1.2.1";
pub const POSITION: u32 = 0x0020_0032;
pub const ORIENTATION: u32 = 0x0020_0037;
pub const SERIES: u32 = 0x0020_000e;
pub const NUMBER: u32 = 0x0020_0011;
pub const INSTANCE: u32 = 0x0020_0013;
pub const DESCRIPTION: u32 = 0x0008_103e;
pub const FRAMES: u32 = 0x0028_0008;
pub const SLOPE: u32 = 0x0028_1053;
pub const INTERCEPT: u32 = 0x0028_1052;
pub const PADDING: u32 = 0x0028_0120;
pub const PHOTOMETRIC: u32 = 0x0028_0004;
pub const PIXELS: u32 = 0x7fe0_0010;
pub const DISTANCE: u32 = 0x0018_0088;

pub fn words(samples: &[i16]) -> Value {
    Value::Bytes(samples.iter().flat_map(|s| s.to_le_bytes()).collect())
}

/// A slice of 3 x 2 signed 16-bit samples: `first`, `first + 1`, …
pub fn slice(z: f64, first: i16) -> Set {
    let samples: Vec<i16> = (first..first + 6).collect();
    Set::default()
        .text(0x0008_0060, "CS", "CT")
        .text(0x0008_0070, "LO", "nobody")
        .text(0x0010_0010, "PN", "Doe^Jane")
        .text(0x0010_0020, "LO", "SECRET-7")
        .text(DESCRIPTION, "LO", "head")
        .text(0x0018_0050, "DS", "9")
        .text(SERIES, "UI", "1.2.3")
        .text(NUMBER, "IS", "4")
        .text(INSTANCE, "IS", "1")
        .text(POSITION, "DS", &format!("10\\20\\{z}"))
        .text(ORIENTATION, "DS", "1\\0\\0\\0\\1\\0")
        .short(0x0028_0002, 1)
        .text(PHOTOMETRIC, "CS", "MONOCHROME2")
        .short(0x0028_0010, 2)
        .short(0x0028_0011, 3)
        .text(0x0028_0030, "DS", "0.5\\0.75")
        .short(0x0028_0100, 16)
        .short(0x0028_0101, 16)
        .short(0x0028_0102, 15)
        .short(0x0028_0103, 1)
        .put(PIXELS, "OW", words(&samples))
}

/// A folder with these files.
pub fn folder(files: &[(&str, Vec<u8>)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

/// A folder of slices, named so that names are in no order of any use.
pub fn series(slices: &[Set]) -> tempfile::TempDir {
    let files: Vec<(String, Vec<u8>)> = slices
        .iter()
        .enumerate()
        .map(|(i, s)| (format!("{}", (i * 7 + 3) % 11 * 100 + i), s.file()))
        .collect();
    let files: Vec<(&str, Vec<u8>)> = files.iter().map(|(n, b)| (n.as_str(), b.clone())).collect();
    folder(&files)
}

/// The first sample of each slice.
pub fn firsts(file: &VolumeFile) -> Vec<f64> {
    let [x, y, z] = file.volume.dims();
    (0..z).map(|k| file.volume.samples().get(k * x * y)).collect()
}
