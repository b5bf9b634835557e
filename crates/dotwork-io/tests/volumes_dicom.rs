//! DICOM: series of real files, files made by independent programs, and small ones made here.
#![cfg(feature = "dicom")]

#[path = "common/mutate.rs"]
mod mutate;
mod volume_common;

use std::path::{Path, PathBuf};

use dotwork_drawing::Warnings;
use dotwork_io::volume::{VolumeFile, VolumeFormat, VolumeOptions, read_volume, volume_format_of};
use dotwork_io::{ReadError, checksum};
use dotwork_volume::{SampleType, Samples, Scaling, Space, Unit};
use volume_common::{close, columns, fact, gzip, numbers, read, read_among, read_quietly, refusal};

fn shared(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name)
}

fn kept(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/dicom")).join(name)).unwrap()
}

/// Reads a file or a folder; says what warnings there were.
fn read_path(path: &Path) -> (Result<VolumeFile, ReadError>, Vec<String>) {
    let mut warnings = Warnings::new();
    let read = read_volume(path, &VolumeOptions::default(), &mut warnings);
    (read, warnings.iter().map(ToString::to_string).collect())
}

fn series_of(path: &Path, series: &str) -> (Result<VolumeFile, ReadError>, Vec<String>) {
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
struct Set(Vec<(u32, &'static str, Value)>);

#[derive(Clone)]
enum Value {
    Bytes(Vec<u8>),
    /// Items, with their lengths or with delimiters.
    Items(Vec<Set>, bool),
}

/// How a set is written.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    Explicit,
    Implicit,
    BigEndian,
}

impl Set {
    fn put(mut self, tag: u32, vr: &'static str, value: Value) -> Set {
        self.0.retain(|e| e.0 != tag);
        self.0.push((tag, vr, value));
        self
    }

    fn text(self, tag: u32, vr: &'static str, text: &str) -> Set {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize(bytes.len().next_multiple_of(2), b' ');
        self.put(tag, vr, Value::Bytes(bytes))
    }

    /// A binary number, little endian here and turned when written.
    fn short(self, tag: u32, number: u16) -> Set {
        self.put(tag, "US", Value::Bytes(number.to_le_bytes().to_vec()))
    }

    fn without(mut self, tag: u32) -> Set {
        self.0.retain(|e| e.0 != tag);
        self
    }

    fn items(self, tag: u32, items: Vec<Set>, delimited: bool) -> Set {
        self.put(tag, "SQ", Value::Items(items, delimited))
    }

    fn bytes(&self, form: Form) -> Vec<u8> {
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
    fn file_as(&self, form: Form, uid: &str) -> Vec<u8> {
        let meta = Set::default().text(0x0002_0010, "UI", uid).bytes(Form::Explicit);
        let length =
            Set::default().put(0x0002_0000, "UL", Value::Bytes((meta.len() as u32).to_le_bytes().to_vec()));
        [&[0; 128][..], b"DICM", &length.bytes(Form::Explicit), &meta, &self.bytes(form)].concat()
    }

    fn file(&self) -> Vec<u8> {
        self.file_as(Form::Explicit, EXPLICIT)
    }
}

const EXPLICIT: &str = "1.2.840.10008.1.2.1";
const POSITION: u32 = 0x0020_0032;
const ORIENTATION: u32 = 0x0020_0037;
const SERIES: u32 = 0x0020_000e;
const NUMBER: u32 = 0x0020_0011;
const INSTANCE: u32 = 0x0020_0013;
const DESCRIPTION: u32 = 0x0008_103e;
const FRAMES: u32 = 0x0028_0008;
const SLOPE: u32 = 0x0028_1053;
const INTERCEPT: u32 = 0x0028_1052;
const PADDING: u32 = 0x0028_0120;
const PHOTOMETRIC: u32 = 0x0028_0004;
const PIXELS: u32 = 0x7fe0_0010;
const DISTANCE: u32 = 0x0018_0088;

fn words(samples: &[i16]) -> Value {
    Value::Bytes(samples.iter().flat_map(|s| s.to_le_bytes()).collect())
}

/// A slice of 3 x 2 signed 16-bit samples: `first`, `first + 1`, …
fn slice(z: f64, first: i16) -> Set {
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
fn folder(files: &[(&str, Vec<u8>)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

/// A folder of slices, named so that names are in no order of any use.
fn series(slices: &[Set]) -> tempfile::TempDir {
    let files: Vec<(String, Vec<u8>)> = slices
        .iter()
        .enumerate()
        .map(|(i, s)| (format!("{}", (i * 7 + 3) % 11 * 100 + i), s.file()))
        .collect();
    let files: Vec<(&str, Vec<u8>)> = files.iter().map(|(n, b)| (n.as_str(), b.clone())).collect();
    folder(&files)
}

/// The first sample of each slice.
fn firsts(file: &VolumeFile) -> Vec<f64> {
    let [x, y, z] = file.volume.dims();
    (0..z).map(|k| file.volume.samples().get(k * x * y)).collect()
}

#[test]
fn slices_are_sorted_by_position() {
    let slices: Vec<Set> = [2.0, -3.0, 7.0, 4.5, -0.5].iter().map(|&z| slice(z, (z * 10.0) as i16)).collect();
    let folder = series(&slices);
    assert_eq!(volume_format_of(folder.path(), &[]), Some(VolumeFormat::Dicom));
    let (file, warnings) = read_path(folder.path());
    let file = file.unwrap();
    assert_eq!(warnings, [""; 0]);
    assert_eq!(file.volume.dims(), [3, 2, 5]);
    assert_eq!(firsts(&file), [-30.0, -5.0, 20.0, 45.0, 70.0]);
    let expected = [[0.75, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 2.5], [10.0, 20.0, -3.0]];
    assert!(close(columns(&file), expected), "{:?}", columns(&file));
    let affine = file.volume.affine();
    assert_eq!((affine.space, affine.unit), (Space::Patient, Unit::Millimetre));
    assert_eq!(file.format, "folder of DICOM, explicit little endian");
    assert_eq!(fact(&file, "slices"), Some("5, 2.5 mm apart"));
    assert_eq!(fact(&file, "modality"), Some("CT"));
    let in_order: Vec<Vec<u8>> = [1, 4, 0, 3, 2].map(|i: usize| slices[i].file()).to_vec();
    assert_eq!(file.checksum, checksum(&in_order.concat()));
    // Nothing of the patient.
    assert!(!format!("{:?}{}", file.facts, file.format).contains("Doe"), "{:?}", file.facts);
    assert!(!format!("{:?}", file.facts).contains("SECRET"));
}

#[test]
fn an_oblique_stack_runs_along_its_normal() {
    // Coronal, seen from the front: rows to the left, columns down; the normal leads to the back.
    let at = |y: f64| {
        slice(0.0, y as i16).text(POSITION, "DS", &format!("1\\{y}\\5")).text(
            ORIENTATION,
            "DS",
            "1\\0\\0\\0\\0\\-1",
        )
    };
    let (file, warnings) = read_path(series(&[at(8.0), at(2.0), at(5.0)]).path());
    let file = file.unwrap();
    assert_eq!((warnings, firsts(&file)), (vec![], vec![2.0, 5.0, 8.0]));
    let expected = [[0.75, 0.0, 0.0], [0.0, 0.0, -0.5], [0.0, 3.0, 0.0], [1.0, 2.0, 5.0]];
    assert!(close(columns(&file), expected), "{:?}", columns(&file));
    assert!(!file.volume.affine().is_mirrored());
    assert_eq!(file.volume.affine().orientation(), Some(['L', 'I', 'P']));
}

#[test]
fn a_missing_slice_is_interpolated_and_said() {
    let slices: Vec<Set> = [0.0, 2.0, 6.0, 8.0, 10.0].iter().map(|&z| slice(z, z as i16 * 10)).collect();
    let (file, warnings) = read_path(series(&slices).path());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
    assert_eq!(file.volume.spacing(), [0.75, 0.5, 2.0]);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("slice is missing: interpolated between its neighbours (after "));
    assert_eq!(fact(&file, "missing slices"), Some("1"));
}

#[test]
fn uneven_slices_are_resampled_and_said() {
    // Samples are linear in z, so that interpolation gives them back.
    let z = [0.0, 2.0, 4.0, 7.0, 9.0, 11.0, 14.0];
    let slices: Vec<Set> = z.iter().map(|&z| slice(z, z as i16 * 100)).collect();
    let (file, warnings) = read_path(series(&slices).path());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [0.0, 200.0, 400.0, 600.0, 800.0, 1000.0, 1200.0, 1400.0]);
    assert_eq!(file.volume.spacing()[2], 2.0);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("vary from 2 to 3 mm: interpolated to even ones of 2 mm"), "{warnings:?}");
}

#[test]
fn a_gap_too_wide_ends_the_stack() {
    let z = [0.0, 50.0, 52.0, 54.0, 56.0];
    let slices: Vec<Set> = z.iter().map(|&z| slice(z, z as i16)).collect();
    let (file, warnings) = read_path(series(&slices).path());
    assert_eq!(firsts(&file.unwrap()), [50.0, 52.0, 54.0, 56.0]);
    let expected = "DICOM slices beyond a gap of 50 mm (where 2 mm is typical) left out (the gap after ";
    assert!(warnings.len() == 1 && warnings[0].starts_with(expected), "{warnings:?}");
}

#[test]
fn a_tilted_gantry_is_kept_as_shear() {
    // A gantry tilted by 15°: planes lean, while the table moves along z.
    let (sin, cos) = 15f64.to_radians().sin_cos();
    let at = |k: i16| {
        slice(0.0, k).text(POSITION, "DS", &format!("0\\0\\{}", 3 * k)).text(
            ORIENTATION,
            "DS",
            &format!("1\\0\\0\\0\\{cos:.9}\\{sin:.9}"),
        )
    };
    let (file, warnings) = read_path(series(&[at(2), at(0), at(1), at(3)]).path());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [0.0, 1.0, 2.0, 3.0]);
    let expected = [[0.75, 0.0, 0.0], [0.0, 0.5 * cos, 0.5 * sin], [0.0, 0.0, 3.0], [0.0; 3]];
    assert!(close(columns(&file), expected), "{:?}", columns(&file));
    assert!((file.volume.affine().shear_deg() - 15.0).abs() < 1e-3);
    let expected = "the slices are stacked 15.0° off their normal (a tilted gantry): kept as a sheared grid";
    assert_eq!(warnings, [expected]);
}

#[test]
fn of_several_series_one_is_read() {
    let other = |z: f64| {
        slice(z, 900).text(SERIES, "UI", "1.2.9").text(NUMBER, "IS", "7").text(
            DESCRIPTION,
            "LO",
            "Chest lung",
        )
    };
    let mut all: Vec<Set> = [0.0, 1.0, 2.0].iter().map(|&z| slice(z, z as i16)).collect();
    all.extend([other(0.0), other(2.0)]);
    let folder = series(&all);
    let (file, warnings) = read_path(folder.path());
    assert_eq!(firsts(&file.unwrap()), [0.0, 1.0, 2.0]);
    let expected =
        "of 2 DICOM series, CT 4 'head' (3 images) is read; not read: CT 7 'Chest lung' (2 images)";
    assert_eq!(warnings, [expected]);
    for name in ["1.2.9", "7", "chest LUNG"] {
        let (file, warnings) = series_of(folder.path(), name);
        assert_eq!(firsts(&file.unwrap()), [900.0, 900.0], "{name}");
        assert!(warnings[0].starts_with("of 2 DICOM series, CT 7 'Chest lung' (2 images) is read"));
    }
    let message = series_of(folder.path(), "spine").0.unwrap_err().to_string();
    let expected =
        "has no DICOM series 'spine'; there are: CT 4 'head' (3 images), CT 7 'Chest lung' (2 images)";
    assert!(message.ends_with(expected), "{message}");
}

#[test]
fn what_does_not_fit_is_left_out_and_said() {
    let mut all: Vec<Set> = [0.0, 1.0, 2.0].iter().map(|&z| slice(z, z as i16)).collect();
    all.push(slice(0.0, 7).text(ORIENTATION, "DS", "0\\1\\0\\0\\0\\-1"));
    all.push(slice(3.0, 7).short(0x0028_0010, 3).short(0x0028_0011, 2));
    all.push(slice(3.0, 7).short(0x0028_0103, 0));
    all.push(slice(3.0, 7).text(0x0028_0030, "DS", "1\\1"));
    all.push(slice(3.0, 7).without(POSITION));
    let (file, warnings) = read_path(series(&all).path());
    assert_eq!(firsts(&file.unwrap()), [0.0, 1.0, 2.0]);
    let mut what: Vec<&str> = warnings.iter().map(|w| w.split(" (").next().unwrap()).collect();
    what.sort_unstable();
    assert_eq!(
        what,
        [
            "DICOM images of another orientation left out",
            "DICOM images of another pixel spacing left out",
            "DICOM images of another size",
            "DICOM images of other samples",
            "DICOM images without a position left out",
        ]
    );
}

#[test]
fn of_slices_at_one_place_one_kind_is_taken() {
    // Two echoes, the second with one slice more; instance numbers alternate.
    let echo = |z: f64, echo: &str, first: i16| {
        slice(z, first).text(0x0018_0081, "DS", echo).text(INSTANCE, "IS", &format!("{}", first % 100))
    };
    let all = [
        echo(0.0, "30", 100),
        echo(0.0, "90", 201),
        echo(1.0, "30", 102),
        echo(1.0, "90", 203),
        echo(2.0, "90", 205),
    ];
    let (file, warnings) = read_path(series(&all).path());
    assert_eq!(firsts(&file.unwrap()), [201.0, 203.0, 205.0]);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].starts_with("2 DICOM slices at the places of others"), "{warnings:?}");
}

#[test]
fn files_that_are_no_slices_are_counted() {
    let report = Set::default().text(0x0008_0060, "CS", "SR").file();
    let whole = slice(2.0, 20).file();
    let unread = slice(3.0, 30).file_as(Form::Explicit, "1.2.840.10008.1.2.4.80");
    let folder = folder(&[
        ("a/1", slice(0.0, 0).file()),
        ("a/b/2", slice(1.0, 10).file()),
        ("a/3", whole.clone()),
        ("4", whole[..whole.len() - 3].to_vec()),
        ("5.dcm", unread),
        ("6.dcm", b"no DICOM at all, whatever its name says".to_vec()),
        ("notes.txt", b"x".to_vec()),
        ("more.txt", b"y".to_vec()),
        ("report", report),
        (".hidden", b"x".to_vec()),
        ("DICOMDIR", b"x".to_vec()),
    ]);
    let (file, warnings) = read_path(folder.path());
    assert_eq!(firsts(&file.unwrap()), [0.0, 10.0, 20.0]);
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert_eq!(warnings[0], "2 files that are no DICOM skipped, first at more.txt");
    assert_eq!(warnings[1], "1 DICOM file without an image skipped (report)");
    assert!(warnings[2].starts_with("3 DICOM files that cannot be read skipped, first at 4: byte "));
    assert!(
        warnings[2].contains("the DICOM pixel data end too early: 9 of 12 bytes are there"),
        "{}",
        warnings[2]
    );
}

#[test]
fn a_folder_without_a_readable_image_says_why() {
    let unread = slice(3.0, 30).file_as(Form::Explicit, "1.2.840.10008.1.2.4.80");
    let error = read_path(folder(&[("x", unread)]).path()).0.unwrap_err().to_string();
    assert!(
        error.contains("x: is DICOM whose pixels are packed as JPEG-LS (1.2.840.10008.1.2.4.80)"),
        "{error}"
    );
}

#[test]
fn every_form_of_data_set_gives_the_same() {
    let one = slice(4.0, -2)
        .items(0x0008_1140, vec![Set::default().text(0x0008_1150, "UI", "1.2"); 2], false)
        .items(0x0040_0275, vec![Set::default().items(0x0040_0008, vec![Set::default()], true)], true)
        .text(0x0009_0010, "LO", "private")
        .items(0x0009_1001, vec![Set::default().text(0x0009_1002, "LO", "x")], true);
    let explicit = read_quietly("a.dcm", &one.file());
    assert_eq!(numbers(&explicit), [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0]);
    // A single slice is as thick as it says.
    assert_eq!(explicit.volume.spacing(), [0.75, 0.5, 9.0]);
    let implicit = one.file_as(Form::Implicit, "1.2.840.10008.1.2");
    let big = one.file_as(Form::BigEndian, "1.2.840.10008.1.2.2");
    let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::default());
    std::io::Write::write_all(&mut encoder, &one.bytes(Form::Explicit)).unwrap();
    let mut deflated = Set::default().file_as(Form::Explicit, "1.2.840.10008.1.2.1.99");
    deflated.extend(encoder.finish().unwrap());
    // Without preamble and meta information.
    let bare = one.bytes(Form::Implicit);
    for bytes in [implicit, big, deflated, bare, gzip(&one.file()), one.bytes(Form::Explicit)] {
        let other = read_quietly("a.dcm", &bytes);
        assert_eq!(other.volume, explicit.volume);
        assert_eq!(other.checksum, checksum(&bytes));
    }
    assert_eq!(volume_format_of(Path::new("x"), &one.file()), Some(VolumeFormat::Dicom));
}

#[test]
fn bytes_written_as_big_endian_words_are_turned() {
    let eight = slice(0.0, 0)
        .short(0x0028_0100, 8)
        .short(0x0028_0101, 8)
        .short(0x0028_0102, 7)
        .short(0x0028_0103, 0)
        .put(PIXELS, "OW", Value::Bytes(vec![1, 2, 3, 4, 5, 255]));
    let little = read_quietly("a", &eight.file());
    assert_eq!(*little.volume.samples(), Samples::U8(vec![1, 2, 3, 4, 5, 255]));
    let big = read_quietly("a", &eight.file_as(Form::BigEndian, "1.2.840.10008.1.2.2"));
    assert_eq!(big.volume, little.volume);
}

#[test]
fn enhanced_frames_lie_where_their_groups_say() {
    let frames = [3.0, 1.0, 2.0, 0.0];
    let groups: Vec<Set> = frames
        .iter()
        .map(|z| {
            let place = Set::default().text(POSITION, "DS", &format!("-5\\6\\{}", 4.0 * z));
            let value = Set::default().text(INTERCEPT, "DS", "-1000").text(SLOPE, "DS", "0.5");
            Set::default().items(0x0020_9113, vec![place], true).items(0x0028_9145, vec![value], false)
        })
        .collect();
    let measures = Set::default().text(0x0028_0030, "DS", "2\\3").text(DISTANCE, "DS", "4");
    let axes = Set::default().text(ORIENTATION, "DS", "0\\1\\0\\0\\0\\-1");
    let shared = Set::default().items(0x0028_9110, vec![measures], true).items(0x0020_9116, vec![axes], true);
    let across = |z: f64| format!("{}\\6\\-5", -4.0 * z);
    let groups: Vec<Set> = groups
        .into_iter()
        .zip(frames)
        .map(|(g, z)| g.items(0x0020_9113, vec![Set::default().text(POSITION, "DS", &across(z))], true))
        .collect();
    let samples: Vec<i16> = frames.iter().flat_map(|&z| (0..6).map(move |i| 100 * z as i16 + i)).collect();
    let enhanced = slice(0.0, 0)
        .without(POSITION)
        .without(ORIENTATION)
        .without(0x0028_0030)
        .text(FRAMES, "IS", "4")
        .items(0x5200_9229, vec![shared], true)
        .items(0x5200_9230, groups, true)
        .put(PIXELS, "OW", words(&samples));
    for bytes in [enhanced.file(), enhanced.file_as(Form::Implicit, "1.2.840.10008.1.2")] {
        let file = read_quietly("a", &bytes);
        assert_eq!(file.volume.dims(), [3, 2, 4]);
        assert_eq!(firsts(&file), [0.0, 100.0, 200.0, 300.0]);
        assert_eq!(file.volume.scaling(), Scaling { slope: 0.5, intercept: -1000.0 });
        let expected = [[0.0, 3.0, 0.0], [0.0, 0.0, -2.0], [-4.0, 0.0, 0.0], [0.0, 6.0, -5.0]];
        assert!(close(columns(&file), expected), "{:?}", columns(&file));
    }
}

#[test]
fn frames_without_groups_follow_the_normal() {
    let frames = slice(1.0, 0).text(FRAMES, "IS", "2").put(PIXELS, "OW", words(&(0..12).collect::<Vec<_>>()));
    let spaced = read_quietly("a", &frames.clone().text(DISTANCE, "DS", "2.5").file());
    assert_eq!((firsts(&spaced), spaced.volume.spacing()[2]), (vec![0.0, 6.0], 2.5));
    let offsets = frames.text(0x3004_000c, "DS", "0\\-3");
    let offset = read_quietly("a", &offsets.file());
    assert_eq!((firsts(&offset), offset.volume.spacing()[2]), (vec![6.0, 0.0], 3.0));
    assert!((offset.volume.affine().origin.z + 2.0).abs() < 1e-9);
}

#[test]
fn images_without_a_place_are_in_order_of_their_numbers() {
    let at = |number: &str, first| {
        slice(0.0, first).without(POSITION).without(ORIENTATION).text(INSTANCE, "IS", number)
    };
    let (file, warnings) = read_path(series(&[at("10", 10), at("9", 9), at("11", 11)]).path());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [9.0, 10.0, 11.0]);
    assert_eq!(file.volume.affine().space, Space::Unknown);
    assert_eq!(
        warnings,
        ["the DICOM images have no position: in the order of their numbers, 9 mm apart assumed"]
    );
}

#[test]
fn only_stored_bits_count() {
    // An overlay in bit 12, samples of 12 bits with a sign below.
    let masked = slice(0.0, 0).short(0x0028_0101, 12).short(0x0028_0102, 11);
    let file = masked.put(PIXELS, "OW", words(&[0x1fff, 0x0800, 0x07ff, 0x1000, 5, 0x0ffe])).file();
    assert_eq!(numbers(&read_quietly("a", &file)), [-1.0, -2048.0, 2047.0, 0.0, 5.0, -2.0]);

    let bits = slice(0.0, 0)
        .short(0x0028_0100, 1)
        .short(0x0028_0101, 1)
        .short(0x0028_0102, 0)
        .short(0x0028_0103, 0)
        .text(FRAMES, "IS", "2")
        .text(DISTANCE, "DS", "1")
        .put(PIXELS, "OB", Value::Bytes(vec![0b1100_1101, 0b0000_1010]));
    let expected = [1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 1.0];
    assert_eq!(numbers(&read_quietly("a", &bits.file())), expected);
}

#[test]
fn floats_are_read() {
    let values = [0.5f32, -1.0, 3.25, 1e-9, 7.0, 2.0];
    let floats = slice(0.0, 0).without(PIXELS).short(0x0028_0100, 32).put(
        0x7fe0_0008,
        "OF",
        Value::Bytes(values.iter().flat_map(|v| v.to_le_bytes()).collect()),
    );
    let floats = floats.without(0x0028_0101).without(0x0028_0102).without(0x0028_0103);
    assert_eq!(*read_quietly("a", &floats.file()).volume.samples(), Samples::F32(values.to_vec()));
}

#[test]
fn scalings_that_differ_make_floats() {
    let scaled = |z: f64, slope: &str| slice(z, 10).text(SLOPE, "DS", slope).text(INTERCEPT, "DS", "1");
    let same = [scaled(0.0, "2"), scaled(1.0, "2")];
    let (file, warnings) = read_path(series(&same).path());
    let file = file.unwrap();
    assert_eq!(file.volume.samples().sample_type(), SampleType::I16);
    assert_eq!((file.volume.scaling(), warnings), (Scaling { slope: 2.0, intercept: 1.0 }, vec![]));

    let (file, warnings) = read_path(series(&[scaled(0.0, "2"), scaled(1.0, "0.5")]).path());
    let file = file.unwrap();
    assert_eq!(file.volume.samples().sample_type(), SampleType::F32);
    assert_eq!(firsts(&file), [21.0, 6.0]);
    assert!(file.volume.scaling().is_identity());
    assert_eq!(warnings, ["the scaling differs from slice to slice: values stored as float32"]);
}

#[test]
fn padding_is_as_low_as_the_rest() {
    let padded = |z: f64, slope: &str| {
        slice(z, 0)
            .put(PIXELS, "OW", words(&[-2000, 5, 9, -2000, 7, -3]))
            .put(PADDING, "SS", words(&[-2000]))
            .text(SLOPE, "DS", slope)
    };
    let (file, warnings) = read("a", &padded(0.0, "1").file());
    assert_eq!(numbers(&file), [-3.0, 5.0, 9.0, -3.0, 7.0, -3.0]);
    assert_eq!(warnings, ["2 voxels of padding set to the lowest value of the others"]);
    let (file, _) = read("a", &padded(0.0, "-1").file());
    assert_eq!(numbers(&file), [9.0, 5.0, 9.0, 9.0, 7.0, -3.0]);
    let (file, warnings) = read_path(series(&[padded(0.0, "1"), padded(1.0, "2")]).path());
    let expected = [-6.0, 5.0, 9.0, -6.0, 7.0, -3.0, -6.0, 10.0, 18.0, -6.0, 14.0, -6.0];
    assert_eq!(numbers(&file.unwrap()), expected);
    assert!(warnings.contains(&"4 voxels of padding set to the lowest value of the others".into()));
}

#[test]
fn white_at_the_low_end_is_turned_round() {
    let white = slice(0.0, 0).text(PHOTOMETRIC, "CS", "MONOCHROME1").short(0x0028_0103, 0);
    let white = white.short(0x0028_0101, 10).short(0x0028_0102, 9);
    let (file, warnings) = read("a", &white.file());
    assert_eq!(numbers(&file), [1023.0, 1022.0, 1021.0, 1020.0, 1019.0, 1018.0]);
    assert_eq!(warnings, ["white is 0 in this DICOM (MONOCHROME1): turned round"]);
    // A measurement stays what it is.
    let measured = read_quietly("a", &white.text(SLOPE, "DS", "2").file());
    assert_eq!(numbers(&measured), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
}

#[test]
fn colours_become_luminance() {
    let colour = |planar: u16, photometric: &str, bytes: &[u8]| {
        let set = slice(0.0, 0).short(0x0028_0002, 3).short(0x0028_0006, planar).text(
            PHOTOMETRIC,
            "CS",
            photometric,
        );
        let set = set.short(0x0028_0100, 8).short(0x0028_0101, 8).short(0x0028_0102, 7).short(0x0028_0103, 0);
        set.put(PIXELS, "OB", Value::Bytes(bytes.to_vec())).file()
    };
    let rgb = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 9, 9], [0; 3], [255; 3]];
    let planes: Vec<u8> = (0..3).flat_map(|c| rgb.map(|p| p[c])).collect();
    for bytes in [colour(0, "RGB", &rgb.concat()), colour(1, "RGB", &planes)] {
        let (file, warnings) = read("a", &bytes);
        assert_eq!(numbers(&file), [54.0, 182.0, 18.0, 9.0, 0.0, 255.0]);
        assert_eq!(warnings, ["the luminance of colours is taken"]);
    }
    let (file, _) = read("a", &colour(0, "YBR_FULL", &rgb.concat()));
    assert_eq!(numbers(&file), [255.0, 0.0, 0.0, 9.0, 0.0, 255.0]);
    let message = refusal("a", &colour(0, "HSV", &rgb.concat()));
    assert!(message.contains("in colours (HSV, 3 samples a pixel) that are not read"), "{message}");
}

/// The samples of the files that `tests/data/dicom/README.md` describes.
fn pattern() -> [Vec<i64>; 3] {
    let at = |f: &dyn Fn(i64, i64) -> i64| (0..36 * 40).map(|i| f(i % 40, i / 40)).collect::<Vec<i64>>();
    let u12 = |x: i64, y: i64| (x * x * 7 + y * 31 * x + y * y) % 4096;
    [at(&u12), at(&|x, y| u12(x, y) * 8 - 16384 + x * 3), at(&|x, y| (x * 5 + y * 9) % 256)]
}

#[test]
fn lossless_codecs_give_the_samples() {
    let [u12, i16, u8] = pattern();
    for (name, expected, format) in [
        ("j2k_uint12.dcm", &u12, "JPEG 2000"),
        ("j2k_int16.dcm", &i16, "JPEG 2000"),
        ("jpeg_lossless_int16.dcm", &i16, "JPEG lossless"),
        ("deflated_int16.dcm", &i16, "deflated"),
    ] {
        let file = read_quietly(name, &kept(name));
        let found: Vec<i64> = numbers(&file).iter().map(|&v| v as i64).collect();
        assert!(found == *expected, "{name}: {:?} {:?}", &found[..9], &expected[..9]);
        assert_eq!(file.format, format!("DICOM, {format}"));
        let place = [[0.75, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 2.0], [1.0, 2.0, 3.0]];
        assert!(close(columns(&file), place), "{name}");
    }
    let luminance: Vec<f64> = (0..36 * 40)
        .map(|i| {
            let (x, y) = (i % 40, i / 40);
            let (r, g, b) = (u8[i as usize] as f64, (x * 8 % 256) as f64, ((255 - y * 8) & 255) as f64);
            (0.2126 * r + 0.7152 * g + 0.0722 * b).round()
        })
        .collect();
    for name in ["rle_colour.dcm", "j2k_colour.dcm"] {
        let (file, warnings) = read(name, &kept(name));
        assert_eq!(numbers(&file), luminance, "{name}");
        assert_eq!(warnings, ["the luminance of colours is taken"]);
    }
    // Lossy, with colour differences of half the resolution.
    let (file, _) = read("c", &kept("jpeg_baseline_colour.dcm"));
    let error = numbers(&file).iter().zip(&luminance).map(|(a, b)| (a - b).abs()).sum::<f64>() / 1440.0;
    assert!(error < 6.0, "{error}");
}

#[test]
fn frames_of_several_fragments_are_put_together() {
    let u8 = &pattern()[2];
    let file = read_quietly("frames", &kept("jpeg_baseline_frames.dcm"));
    assert_eq!(file.volume.dims(), [40, 36, 2]);
    assert_eq!(file.volume.spacing()[2], 2.5);
    let samples = numbers(&file);
    let mean_error = |frame: usize, expected: &dyn Fn(usize) -> i64| {
        (0..1440).map(|i| (samples[frame * 1440 + i] - expected(i) as f64).abs()).sum::<f64>() / 1440.0
    };
    // The sawtooth of the pattern is hard on JPEG.
    assert!(mean_error(0, &|i| u8[i]) < 4.0, "{}", mean_error(0, &|i| u8[i]));
    assert!(mean_error(1, &|i| u8[(35 - i / 40) * 40 + i % 40]) < 4.0);
    // An independent decoder's sum over both frames.
    assert!((samples.iter().sum::<f64>() - 366_895.0).abs() < 300.0, "{}", samples.iter().sum::<f64>());
}

#[test]
fn what_cannot_be_unpacked_is_refused_by_name() {
    let message = refusal("x.dcm", &kept("jpeg_ls.dcm"));
    assert!(message.contains("packed as JPEG-LS (1.2.840.10008.1.2.4.80), which is not read"), "{message}");
    for (uid, name) in [
        ("1.2.840.10008.1.2.4.100", "MPEG-2 video"),
        ("1.2.840.10008.1.2.4.110", "JPEG XL"),
        ("1.2.840.10008.1.2.4.201", "high-throughput JPEG 2000"),
        ("1.2.840.10008.1.2.4.55", "a retired kind of JPEG"),
        ("1.2.840.113619.5.2", "a private kind"),
        ("1.2.840.10008.1.2.77", "an unknown kind"),
    ] {
        let message = refusal("x.dcm", &slice(0.0, 0).file_as(Form::Explicit, uid));
        assert!(message.contains(&format!("packed as {name} ({uid})")), "{message}");
    }
}

#[test]
fn declared_sizes_are_not_believed() {
    let huge = slice(0.0, 0).short(0x0028_0010, 65535).short(0x0028_0011, 65535);
    let message = refusal("x.dcm", &huge.file());
    assert!(
        message.contains("the DICOM pixel data end too early: 12 of 8589672450 bytes are there"),
        "{message}"
    );
    for frames in ["2000000000", "0", "-1", "1A", "99999999999999999999"] {
        let message = refusal("x.dcm", &slice(0.0, 0).text(FRAMES, "IS", frames).file());
        assert!(message.contains(&format!("with '{frames}' frames")), "{message}");
    }
    let message = refusal("x.dcm", &slice(0.0, 0).text(FRAMES, "IS", "60000").file());
    assert!(message.contains("end too early"), "{message}");
    // Packed: the header of the stream says what the data set says, and both lie.
    let mut packed = kept("j2k_uint12.dcm");
    let rows = packed.windows(8).position(|w| w == [0x28, 0, 0x10, 0, b'U', b'S', 2, 0]).unwrap() + 8;
    packed[rows..rows + 2].copy_from_slice(&60000u16.to_le_bytes());
    packed[rows + 10..rows + 12].copy_from_slice(&60000u16.to_le_bytes());
    let stream = packed.windows(4).position(|w| w == [0xff, 0x4f, 0xff, 0x51]).unwrap();
    for at in [8, 12, 24, 28] {
        packed[stream + at..stream + at + 4].copy_from_slice(&60000u32.to_be_bytes());
    }
    let message = refusal("x.dcm", &packed);
    assert!(message.contains("many times the size of its files"), "{message}");
    // The stream alone lies.
    let mut stream_lies = kept("j2k_uint12.dcm");
    stream_lies[stream + 8..stream + 12].copy_from_slice(&60000u32.to_be_bytes());
    let message = refusal("x.dcm", &stream_lies);
    assert!(message.contains("JPEG 2000 data of 60000 x 36 pixels"), "{message}");
    // Sequences in sequences.
    let mut deep = Set::default();
    for _ in 0..2000 {
        deep = Set::default().items(0x0040_0275, vec![deep], true);
    }
    let message = refusal("x.dcm", &deep.file());
    assert!(message.contains("nested too deeply"), "{message}");
}

#[test]
fn a_directory_file_names_the_others() {
    let slices: Vec<Vec<u8>> = [2.0, 0.0, 1.0].iter().map(|&z| slice(z, z as i16).file()).collect();
    let record = |name: &str| Set::default().text(0x0004_1500, "CS", name);
    let records = ["D\\A", "D\\B", "D\\C", "D\\MISSING", "..\\SECRET", "D\\A"].map(record).to_vec();
    let records = [vec![Set::default().text(0x0004_1430, "CS", "PATIENT")], records].concat();
    let directory = Set::default().items(0x0004_1220, records, false).file();
    let others: Vec<(&str, &[u8])> =
        ["D/A", "D/B", "D/C"].into_iter().zip(slices.iter().map(Vec::as_slice)).collect();
    let (file, warnings) = read_among("DICOMDIR", &directory, &others, &VolumeOptions::default());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [0.0, 1.0, 2.0]);
    assert_eq!(file.format, "DICOMDIR of DICOM, explicit little endian");
    assert_eq!(
        file.checksum,
        checksum(&[&directory, &slices[1], &slices[2], &slices[0]].map(Vec::as_slice).concat())
    );
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("that cannot be read skipped (MISSING"), "{warnings:?}");
    let (none, _) = read_among("DICOMDIR", &directory, &[], &VolumeOptions::default());
    assert!(none.unwrap_err().to_string().contains("no such file"));
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn four_syntaxes_of_one_slice_are_equal() {
    let (first, warnings) = read_path(&shared("volumes/mr_small.dcm"));
    let first = first.unwrap();
    assert_eq!(warnings, [""; 0]);
    let samples = numbers(&first);
    // Numbers from pydicom.
    assert_eq!(first.volume.dims(), [64, 64, 1]);
    assert_eq!(samples.iter().sum::<f64>(), 2_125_338.0);
    assert_eq!((samples[0], samples[32 * 64 + 32]), (905.0, 182.0));
    assert_eq!(first.volume.spacing(), [0.3125, 0.3125, 0.8]);
    for name in ["mr_small_bigendian", "mr_small_implicit", "mr_small_rle"] {
        let (file, warnings) = read_path(&shared(&format!("volumes/{name}.dcm")));
        assert_eq!((file.unwrap().volume, warnings), (first.volume.clone(), vec![]), "{name}");
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn a_pet_series_is_in_slice_order() {
    let (file, warnings) = read_path(&shared("volumes/dicom_pet"));
    let file = file.unwrap();
    assert_eq!(warnings, [""; 0]);
    let volume = &file.volume;
    assert_eq!(volume.dims(), [128, 128, 28]);
    assert_eq!(volume.scaling(), Scaling { slope: 2.0222414, intercept: 0.0 });
    let place =
        [[3.5378182, 0.0, 0.0], [0.0, 3.5378182, 0.0], [0.0, 0.0, 3.375], [-226.13246, -425.88375, -344.834]];
    assert!(close(columns(&file), place), "{:?}", columns(&file));
    // Sums of the slices from the feet up, and two voxels, from pydicom.
    let samples = numbers(&file);
    let sums: Vec<f64> = samples.chunks(128 * 128).map(|s| s.iter().sum()).collect();
    let expected = [
        6802239, 7226221, 7805904, 8626292, 9671403, 10444708, 10785162, 10922592, 11073192, 11212815,
        11477950, 11959745, 12496494, 12869003, 12895706, 12538337, 12122395, 11696549, 11395949, 11241555,
        11329473, 11323046, 11123734, 10608101, 9873603, 9281195, 8769038, 8253815,
    ];
    assert_eq!(sums, expected.map(f64::from));
    assert_eq!(volume.value_at(64, 60, 5), 3925.0 * 2.0222414);
    assert_eq!(volume.value_at(50, 70, 20), 8571.0 * 2.0222414);
    assert_eq!(fact(&file, "modality"), Some("PT"));
    assert_eq!(fact(&file, "description"), Some("PET WB_0"));
    assert_eq!(fact(&file, "manufacturer"), Some("CPS 1023"));
    assert_eq!(volume.affine().orientation(), Some(['L', 'P', 'S']));
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn a_rescaled_slice() {
    let (file, warnings) = read_path(&shared("volumes/ct_small.dcm"));
    let file = file.unwrap();
    assert_eq!(warnings, [""; 0]);
    let samples = numbers(&file);
    assert_eq!(samples.iter().sum::<f64>(), 14_826_310.0);
    assert_eq!(file.volume.value_at(64, 64, 0), 1928.0 - 1024.0);
    assert_eq!(file.volume.value_at(20, 100, 0), 1043.0 - 1024.0);
    assert_eq!(file.volume.spacing(), [0.661468, 0.661468, 5.0]);
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn a_study_of_many_series() {
    let folder = shared("volumes/dicom_tiny");
    let (file, warnings) = read_path(&folder);
    let file = file.unwrap();
    // Seven images of another series have seven orientations; five of this one make a stack.
    assert_eq!(file.volume.dims(), [16, 16, 5]);
    assert!(
        (file.volume.spacing()[2] - 2.5).abs() < 1e-9
            && (file.volume.affine().origin.z + 1.2375).abs() < 1e-9
    );
    assert_eq!(fact(&file, "description"), Some("SmartScore - Gated 0.5 sec"));
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let start = "of 13 DICOM series, CT 5 'SmartScore - Gated 0.5 sec' (5 images) is read; not read: ";
    assert!(warnings[0].starts_with(start), "{warnings:?}");
    assert!(warnings[0].contains("CT 2 'Routine Brain' (4 images), "), "{warnings:?}");
    let (directory, same_warnings) = read_path(&folder.join("DICOMDIR"));
    let directory = directory.unwrap();
    assert_eq!(directory.volume, file.volume);
    assert_eq!(same_warnings, warnings);

    let (brain, warnings) = series_of(&folder, "routine brain");
    assert_eq!(brain.unwrap().volume.dims(), [16, 16, 3]);
    assert!(
        warnings[1].contains("beyond a gap of 202.5 mm (where 1.25 mm is typical) left out"),
        "{warnings:?}"
    );
    let (angio, warnings) = series_of(&folder.join("DICOMDIR"), "700");
    assert_eq!(angio.unwrap().volume.dims(), [16, 16, 1]);
    assert!(warnings[1].starts_with("6 DICOM images of another orientation left out"), "{warnings:?}");
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn malformed_files_are_refused() {
    for (name, reason) in [
        ("mr_truncated.dcm", "the DICOM pixel data end too early: 8130 of 8192 bytes are there"),
        ("badvr.dcm", "is DICOM with '1A' frames"),
        ("meta_missing_tsyntax.dcm", "is DICOM whose image has 0 x 0 pixels"),
        ("no_meta_group_length.dcm", "is DICOM without an image"),
    ] {
        let error = read_path(&shared("malformed/volume").join(name)).0.unwrap_err().to_string();
        assert!(error.contains(reason) && !error.contains('\n'), "{error}");
    }
    // A folder of nothing else says why the first of them cannot be read.
    let error = read_path(&shared("malformed/volume")).0.unwrap_err().to_string();
    assert!(error.contains("badvr.dcm: is DICOM with '1A' frames"), "{error}");
}

/// A name and the bytes of a small file of each kind.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let one = slice(4.0, -2);
    let group = |z: f64| {
        let place = Set::default().text(POSITION, "DS", &format!("0\\0\\{z}"));
        Set::default().items(0x0020_9113, vec![place], true)
    };
    let enhanced = one
        .clone()
        .text(FRAMES, "IS", "4")
        .items(0x5200_9230, [0.0, 1.0, 3.0, 2.5].map(group).to_vec(), true)
        .put(PIXELS, "OW", words(&(0..24).collect::<Vec<_>>()))
        .put(PADDING, "SS", words(&[3]));
    let mut samples = vec![
        ("explicit", one.file()),
        ("implicit", one.file_as(Form::Implicit, "1.2.840.10008.1.2")),
        ("big", one.file_as(Form::BigEndian, "1.2.840.10008.1.2.2")),
        ("enhanced", enhanced.file()),
        ("enhanced implicit", enhanced.file_as(Form::Implicit, "1.2.840.10008.1.2")),
        ("bare.dcm", one.bytes(Form::Implicit)),
    ];
    for name in [
        "deflated_int16.dcm",
        "j2k_colour.dcm",
        "j2k_int16.dcm",
        "j2k_uint12.dcm",
        "jpeg_baseline_colour.dcm",
        "jpeg_baseline_frames.dcm",
        "jpeg_lossless_int16.dcm",
        "rle_colour.dcm",
    ] {
        samples.push((name, kept(name)));
    }
    samples
}

/// Reads a file; what comes must be a whole volume or an error on one line.
fn read_soundly(name: &str, bytes: &[u8]) -> bool {
    let (read, warnings) = read_among(name, bytes, &[], &VolumeOptions::default());
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

#[test]
fn damaged_files_give_volumes_or_errors() {
    let (mut refused, mut total) = (0, 0);
    for (name, bytes) in samples() {
        for seed in 0..1500 {
            refused += usize::from(!read_soundly(name, &mutate::mutate(&bytes, seed)));
            total += 1;
        }
        // The pixels alone, which most mutations miss or never reach.
        let start = bytes.windows(4).position(|w| w == [0xe0, 0x7f, 0x10, 0]).unwrap_or(0);
        for seed in 0..1500 {
            let mutant = [&bytes[..start], &mutate::mutate(&bytes[start..], seed)].concat();
            read_soundly(name, &mutant);
        }
    }
    // The harness does something: many mutants are refused, and many are not.
    assert!(refused > total / 10 && refused < total * 9 / 10, "{refused} of {total}");
}

#[test]
fn files_cut_anywhere_are_refused() {
    for (name, bytes) in samples() {
        for end in (0..bytes.len()).step_by(1 + bytes.len() / 400) {
            let read = read_soundly(name, &bytes[..end]);
            // Packed streams may end before their file does, and decoders forgive much.
            assert!(!read || !matches!(name, "explicit" | "implicit" | "big" | "enhanced"), "{name} {end}");
        }
    }
}
