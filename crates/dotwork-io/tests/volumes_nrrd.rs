//! NRRD files that the tests make.
#![cfg(all(feature = "nrrd", feature = "bzip2"))]

mod volume_common;

use std::io::Write;

use dotwork_io::volume::VolumeOptions;
use dotwork_volume::{SampleType, Space, Unit};
use volume_common::{
    columns, counting, fact, gzip, int16, nrrd, nrrd_int16, numbers, read, read_among, read_quietly, refusal,
    refusal_among, refused_with,
};

fn bzip2(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

const SPACED: &str = "spacings: 1 2 3\n";

#[test]
fn every_encoding_gives_the_same_samples() {
    let data = int16(false);
    let text: Vec<String> = (0..24).map(|i| i.to_string()).collect();
    let hex: String = data.iter().map(|b| format!("{b:02x}")).collect();
    for (encoding, data) in [
        ("raw", data.clone()),
        ("gzip", gzip(&data)),
        ("GZ", [gzip(&data[..10]), gzip(&data[10..])].concat()),
        ("bzip2", bzip2(&data)),
        ("bz2", [bzip2(&data[..11]), bzip2(&data[11..])].concat()),
        ("ascii", text.join(" ").into_bytes()),
        ("text", text.join(",\n").into_bytes()),
        ("txt", format!("{}\n", text.join("\r\n")).into_bytes()),
        ("hex", hex.into_bytes()),
    ] {
        let file = read_quietly("a.nrrd", &nrrd_int16(&format!("{SPACED}encoding: {encoding}\n"), &data));
        assert_eq!(file.volume.dims(), [2, 3, 4]);
        assert_eq!(file.volume.samples().sample_type(), SampleType::I16);
        assert_eq!(numbers(&file), counting(), "{encoding}");
        assert_eq!(file.volume.affine().spacing(), [1.0, 2.0, 3.0]);
    }
    let whole = gzip(&nrrd_int16(&format!("{SPACED}encoding: raw\n"), &int16(false)));
    assert_eq!(numbers(&read_quietly("a.nrrd.gz", &whole)), counting());
}

#[test]
fn every_type_has_many_names_and_both_byte_orders() {
    for (names, sample) in [
        ("signed char, int8, int8_t", SampleType::I8),
        ("uchar, unsigned char, uint8, uint8_t", SampleType::U8),
        ("short, short int, signed short, signed short int, int16, int16_t", SampleType::I16),
        ("ushort, unsigned short, unsigned short int, uint16, uint16_t", SampleType::U16),
        ("int, signed int, int32, int32_t", SampleType::I32),
        ("uint, unsigned int, uint32, uint32_t", SampleType::U32),
        (
            "longlong, long long, long long int, signed long long, signed long long int, int64",
            SampleType::I64,
        ),
        ("ulonglong, unsigned long long, unsigned long long int, uint64, uint64_t", SampleType::U64),
        ("float, FLOAT", SampleType::F32),
        ("double", SampleType::F64),
    ] {
        for name in names.split(", ") {
            for (endian, big) in [("little", false), ("big", true)] {
                let value = |i: u8| {
                    let mut bytes = match sample {
                        SampleType::F32 => f32::from(i).to_le_bytes().to_vec(),
                        SampleType::F64 => f64::from(i).to_le_bytes().to_vec(),
                        _ => u64::from(i).to_le_bytes()[..sample.bytes()].to_vec(),
                    };
                    if big {
                        bytes.reverse();
                    }
                    bytes
                };
                let data: Vec<u8> = (0..6).flat_map(value).collect();
                let fields = format!(
                    "type: {name}\ndimension: 3\nsizes: 1 2 3\nspacings: 1 1 1\nendian: {endian}\nencoding: raw\n"
                );
                let file = read_quietly("a.nrrd", &nrrd(&fields, &data));
                assert_eq!(file.volume.samples().sample_type(), sample, "{name}");
                assert_eq!(numbers(&file), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0], "{name} {endian}");
            }
        }
    }
}

#[test]
fn data_files_are_found_by_name_list_and_pattern() {
    let data = int16(false);
    let slices: Vec<&[u8]> = data.chunks(12).collect();
    let header = |fields: &str| nrrd_int16(&format!("{SPACED}encoding: raw\n{fields}"), b"");
    let options = VolumeOptions::default();
    let four = [("d/s1", slices[0]), ("d/s2", slices[1]), ("d/s3", slices[2]), ("d/s4", slices[3])];
    let padded = [("d/s 01.raw", &data[..24]), ("d/s 02.raw", &data[24..])];
    for (fields, others) in [
        ("data file: all.raw\n", &[("d/all.raw", &data[..])][..]),
        ("datafile: ./sub/a b.raw\n", &[("d/./sub/a b.raw", &data[..])]),
        ("data file: LIST\ns1\ns2\ns3\ns4\n", &four),
        ("data file: LIST 2\ns1\r\ns2\r\ns3\r\ns4", &four),
        ("data file: s%d 1 4 1\n", &four),
        ("data file: s%d 1 4 1 2\n", &four),
        ("data file: s %02d.raw 1 2 1 3\n", &padded),
    ] {
        // A list needs no blank line behind it, and here gets none.
        let bytes = header(fields);
        let bytes = bytes.strip_suffix(b"\n").unwrap();
        let (file, warnings) = read_among("d/a.nhdr", bytes, others, &options);
        assert_eq!(numbers(&file.unwrap_or_else(|e| panic!("{e}"))), counting(), "{fields}");
        assert_eq!(warnings, [""; 0]);
    }
    let reverse = header("data file: LIST\ns4\ns3\ns2\ns1\n");
    let (file, _) = read_among("d/a.nhdr", &reverse, &four, &options);
    let file = file.unwrap();
    assert_eq!(numbers(&file)[..6], [18.0, 19.0, 20.0, 21.0, 22.0, 23.0]);
    assert_eq!(fact(&file, "data files"), Some("4: s4 to s1"));
    let read_order = [&reverse[..], slices[3], slices[2], slices[1], slices[0]].concat();
    assert_eq!(file.checksum, dotwork_io::checksum(&read_order));

    let missing = refusal_among("d/a.nhdr", &header("data file: LIST\ns1\nno\ns3\ns4\n"), &four);
    assert_eq!(missing, "d/a.nhdr: data file d/no: no such file");
    let short = refusal_among("d/a.nhdr", &header("data file: s1\n"), &four);
    assert_eq!(
        short,
        "d/a.nhdr: data file d/s1: byte 12: the data end too early: 12 of 48 bytes are there \
         (6 of 24 int16 samples)"
    );
    for (fields, reason) in [
        (
            "data file: LIST 1\ns1\ns2\ns3\ns4\n",
            "4 data files of 1 axes each do not make what the sizes declare",
        ),
        ("data file: LIST\ns1\ns2\ns3\ns4\ns1\n", "5 data files cannot share 48 bytes of samples evenly"),
        ("data file: LIST\n", "no data file is named"),
        ("data file: s%d 1 999999999999 1\n", "no files are numbered from 1 to 999999999999 by 1"),
    ] {
        let message = refusal_among("d/a.nhdr", &header(fields), &four);
        assert_eq!(message, format!("d/a.nhdr: line 9: {reason}"));
    }
}

#[test]
fn lines_and_bytes_are_skipped() {
    let data = int16(false);
    let lines = &b"one\ntwo\n"[..];
    for (fields, data) in [
        ("encoding: raw\nline skip: 2\n", [lines, &data[..]].concat()),
        ("encoding: raw\nline skip: 2\nbyte skip: 3\n", [lines, &b"abc"[..], &data[..]].concat()),
        ("encoding: raw\nbyteskip: -1\n", [lines, &data[..]].concat()),
        ("encoding: gzip\nline skip: 2\n", [lines, &gzip(&data)[..]].concat()),
        ("encoding: gzip\nbyte skip: 3\n", gzip(&[&b"abc"[..], &data[..]].concat())),
        ("encoding: gzip\nbyte skip: -1\n", gzip(&[&b"abc"[..], &data[..]].concat())),
        ("encoding: bzip2\nbyte skip: -1\n", bzip2(&[&b"abcd"[..], &data[..]].concat())),
        (
            "encoding: ascii\nline skip: 1\nbyte skip: 4\n",
            b"one\ntwo 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23".to_vec(),
        ),
    ] {
        let file = read_quietly("a.nrrd", &nrrd_int16(&format!("{SPACED}{fields}"), &data));
        assert_eq!(numbers(&file), counting(), "{fields}");
    }
    let (_, warnings) =
        read("a.nrrd", &nrrd_int16(&format!("{SPACED}encoding: raw\n"), &[&data[..], b"!"].concat()));
    assert_eq!(warnings, ["1 byte after the samples ignored"]);
}

#[test]
fn spaces_and_directions_lead_to_lps() {
    let place = "space directions: (0,2,0) (0,0,-3) (4,0,0)\nspace origin: (10,20,30)\nspace units: \"mm\" \"mm\" \"mm\"\n";
    let lps = [[0.0, 2.0, 0.0], [0.0, 0.0, -3.0], [4.0, 0.0, 0.0], [10.0, 20.0, 30.0]];
    let ras = [[0.0, -2.0, 0.0], [0.0, 0.0, -3.0], [-4.0, 0.0, 0.0], [-10.0, -20.0, 30.0]];
    let las = [[0.0, -2.0, 0.0], [0.0, 0.0, -3.0], [4.0, 0.0, 0.0], [10.0, -20.0, 30.0]];
    for (space, anatomy, expected) in [
        ("left-posterior-superior", Space::Patient, lps),
        ("LPS", Space::Patient, lps),
        ("Left-Posterior-Superior-Time", Space::Patient, lps),
        ("right-anterior-superior", Space::Patient, ras),
        ("RAS", Space::Patient, ras),
        ("RAST", Space::Patient, ras),
        ("left-anterior-superior", Space::Patient, las),
        ("LAS", Space::Patient, las),
        ("scanner-xyz", Space::Unknown, lps),
        ("3D-right-handed", Space::Unknown, lps),
        ("3D-left-handed-time", Space::Unknown, lps),
    ] {
        let fields = format!("space: {space}\n{place}encoding: raw\n");
        let file = read_quietly("a.nrrd", &nrrd_int16(&fields, &int16(false)));
        assert_eq!(columns(&file), expected, "{space}");
        assert_eq!(file.volume.affine().space, anatomy, "{space}");
        assert_eq!(file.volume.affine().unit, Unit::Millimetre);
        assert_eq!(fact(&file, "space"), Some(space));
    }
    let fields = format!("space dimension: 3\n{place}encoding: raw\n");
    let file = read_quietly("a.nrrd", &nrrd_int16(&fields, &int16(false)));
    assert_eq!((columns(&file), file.volume.affine().space), (lps, Space::Unknown));
}

#[test]
fn spacings_and_ends_of_axes() {
    for (fields, spacing, origin) in [
        ("spacings: 1 2 3\n", [1.0, 2.0, 3.0], [0.0; 3]),
        ("spacings: 1 2 3\naxis mins: 10 20 30\n", [1.0, 2.0, 3.0], [10.5, 21.0, 31.5]),
        (
            "spacings: 1 2 3\naxis mins: 10 nan 30\ncenterings: node cell node\n",
            [1.0, 2.0, 3.0],
            [10.0, 0.0, 30.0],
        ),
        ("axis mins: 0 0 0\naxis maxs: 4 6 8\n", [2.0, 2.0, 2.0], [1.0, 1.0, 1.0]),
        ("axis mins: 0 0 0\naxis maxs: 4 6 9\ncenters: node node node\n", [4.0, 3.0, 3.0], [0.0; 3]),
    ] {
        let file = read_quietly("a.nrrd", &nrrd_int16(&format!("{fields}encoding: raw\n"), &int16(false)));
        assert_eq!(file.volume.affine().spacing(), spacing, "{fields}");
        assert_eq!(file.volume.affine().origin.to_array(), origin, "{fields}");
    }
    let (file, warnings) = read("a.nrrd", &nrrd_int16("spacings: -1 0 nan\nencoding: raw\n", &int16(false)));
    assert_eq!(columns(&file)[..3], [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    assert_eq!(warnings, ["the spacing along y is 0: 1 assumed", "the spacing along z is NaN: 1 assumed"]);
    let (_, warnings) = read("a.nrrd", &nrrd_int16("encoding: raw\n", &int16(false)));
    assert_eq!(warnings, ["no spacing in the file: 1 x 1 x 1 assumed"]);
    // NaN says that nobody knows: the ends do.
    let ends = "spacings: nan 2 nan\naxis mins: 0 0 0\naxis maxs: 4 600 8\nencoding: raw\n";
    let file = read_quietly("a.nrrd", &nrrd_int16(ends, &int16(false)));
    assert_eq!(file.volume.affine().spacing(), [2.0, 2.0, 2.0]);
    let placed = "space: LPS\nspace origin: (1,2,3)\nspacings: 1 2 3\nencoding: raw\n";
    let (file, warnings) = read("a.nrrd", &nrrd_int16(placed, &int16(false)));
    assert_eq!(file.volume.affine().origin.to_array(), [0.0; 3]);
    assert_eq!(warnings, ["the space origin is ignored, as no axis has a direction"]);
}

#[test]
fn axes_may_differ_in_unit() {
    let directions = "space: RAS\nspace directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (1,1,1)\n";
    for (fields, unit, expected) in [
        (
            "spacings: 2 3 4\nunits: \"um\" \"um\" \"mm\"\n",
            Unit::Micrometre,
            [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4000.0], [0.0; 3]],
        ),
        (
            &format!("{directions}space units: \"cm\" \"mm\" \"m\"\n"),
            Unit::Millimetre,
            [[-20.0, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 4000.0], [-10.0, -1.0, 1000.0]],
        ),
    ] {
        let file = read_quietly("a.nrrd", &nrrd_int16(&format!("{fields}encoding: raw\n"), &int16(false)));
        assert_eq!((file.volume.affine().unit, columns(&file)), (unit, expected), "{fields}");
    }
    let odd = "spacings: 2 3 4\nunits: \"mm\" \"mm\" \"s\"\nencoding: raw\n";
    let (file, warnings) = read("a.nrrd", &nrrd_int16(odd, &int16(false)));
    assert_eq!(file.volume.affine().spacing(), [2.0, 3.0, 4.0]);
    assert_eq!(warnings, ["the axes have units that cannot be compared: the first is taken for all"]);
}

#[test]
fn axes_that_are_not_space_are_reduced_and_said() {
    let bytes: Vec<u8> = (0..24).collect();
    let fields = |sizes: &str, kinds: &str| {
        let axes = sizes.split(' ').count();
        let spacings = vec!["1"; axes].join(" ");
        format!(
            "type: uchar\ndimension: {axes}\nsizes: {sizes}\nkinds: {kinds}\nspacings: {spacings}\nencoding: raw\n"
        )
    };
    // Reds 0, 3, 6, …: their luminance is the middle of the three, as weights sum to 1.
    let green = |step: usize| {
        move |i: usize| {
            (0.2126 * i as f64 + 0.7152 * (i + step) as f64 + 0.0722 * (i + 2 * step) as f64).round()
        }
    };
    let by_side: Vec<f64> = (0..8).map(|i| green(1)(3 * i)).collect();
    let by_plane: Vec<f64> = (0..8).map(green(8)).collect();
    for (sizes, kinds, dims, expected, warning) in [
        (
            "3 2 2 2",
            "RGB-color domain domain domain",
            [2, 2, 2],
            by_side.clone(),
            "3 colours a voxel: their luminance is taken",
        ),
        (
            "3 2 2 2",
            "3-color space space space",
            [2, 2, 2],
            by_side,
            "3 colours a voxel: their luminance is taken",
        ),
        (
            "2 2 2 3",
            "domain domain domain RGB-color",
            [2, 2, 2],
            by_plane,
            "3 colours a voxel: their luminance is taken",
        ),
        (
            "3 2 2 2",
            "vector domain domain domain",
            [2, 2, 2],
            (0..8).map(|i| f64::from(3 * i)).collect(),
            "3 values a voxel (vector): the first is taken",
        ),
        (
            "2 3 2 2",
            "domain list domain domain",
            [2, 2, 2],
            vec![0.0, 1.0, 6.0, 7.0, 12.0, 13.0, 18.0, 19.0],
            "3 values a voxel (list): the first is taken",
        ),
        (
            "2 2 2 3",
            "domain domain domain list",
            [2, 2, 2],
            (0..8).map(f64::from).collect(),
            "the first of 3 volumes is taken",
        ),
        (
            "2 2 2 3",
            "domain domain domain time",
            [2, 2, 2],
            (0..8).map(f64::from).collect(),
            "the first of 3 volumes is taken",
        ),
        (
            "2 3 4",
            "complex domain domain",
            [3, 4, 1],
            (0..12).map(|i| (f64::from(2 * i)).hypot(f64::from(2 * i + 1)).round()).collect(),
            "complex samples: their magnitude is taken",
        ),
        (
            "2 3 4",
            "domain domain vector",
            [2, 3, 1],
            (0..6).map(f64::from).collect(),
            "the first of 4 volumes is taken",
        ),
    ] {
        let (file, warnings) = read("a.nrrd", &nrrd(&fields(sizes, kinds), &bytes));
        assert_eq!(file.volume.dims(), dims, "{kinds}");
        assert_eq!(numbers(&file), expected, "{kinds}");
        assert_eq!(warnings, [warning], "{kinds}");
        assert!(fact(&file, "axes").is_some());
    }
    // Without kinds, an axis without spacing before three that have one.
    let unkind = "type: uchar\ndimension: 4\nsizes: 3 2 2 2\nspacings: nan 1 2 3\nencoding: raw\n";
    let (file, warnings) = read("a.nrrd", &nrrd(unkind, &bytes));
    assert_eq!(numbers(&file), [0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0, 21.0]);
    assert_eq!(file.volume.affine().spacing(), [1.0, 2.0, 3.0]);
    assert_eq!(warnings, ["3 values a voxel: the first is taken"]);
    let none = "type: uchar\ndimension: 4\nsizes: 3 2 2 2\nspace: LPS\nspace directions: none (1,0,0) (0,1,0) (0,0,2)\n\
                kinds: list domain domain domain\nencoding: raw\n";
    let (file, warnings) = read("a.nrrd", &nrrd(none, &bytes));
    assert_eq!(numbers(&file), [0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0, 21.0]);
    assert_eq!(file.volume.affine().spacing(), [1.0, 1.0, 2.0]);
    assert_eq!(warnings, ["3 values a voxel (list): the first is taken"]);
    let flat = "type: uchar\ndimension: 2\nsizes: 6 4\nspace: RAS\nspace directions: (2,0,0) (0,0,3)\nencoding: raw\n";
    let file = read_quietly("a.nrrd", &nrrd(flat, &bytes));
    assert_eq!(file.volume.dims(), [6, 4, 1]);
    assert_eq!(columns(&file)[..3], [[-2.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.0, 1.0, 0.0]]);
}

#[test]
fn a_truncated_fourth_axis_is_a_warning() {
    let bytes = [7; 20];
    let fields = "type: uchar\ndimension: 4\nsizes: 2 2 2 3\nspacings: 1 1 1 1\nencoding: raw\n";
    let (file, warnings) = read("a.nrrd", &nrrd(fields, &bytes));
    assert_eq!(file.volume.samples().len(), 8);
    assert_eq!(
        warnings,
        [
            "the first of 3 volumes is taken",
            "the data end early: 20 of 24 bytes are there; what is taken is complete"
        ]
    );
}

#[test]
fn what_breaks_the_rules_is_refused_by_line() {
    let good = "type: short\ndimension: 3\nsizes: 2 3 4\nspacings: 1 1 1\nendian: little\nencoding: raw\n";
    let cases = [
        ("short", "block", "line 3: samples of type block are no numbers"),
        ("short", "shirt", "line 3: 'shirt' is no sample type"),
        ("type: short\n", "", "line 8: the header has no 'type'"),
        ("dimension: 3\n", "", "line 8: the header has no 'dimension'"),
        ("sizes: 2 3 4\n", "", "line 8: the header has no 'sizes'"),
        ("encoding: raw\n", "", "line 8: the header has no 'encoding'"),
        ("dimension: 3", "dimension: 99", "line 4: 99 axes; 1 to 16 are allowed"),
        ("sizes: 2 3 4", "sizes: 2 3", "line 5: 2 sizes for 3 axes"),
        ("sizes: 2 3 4", "sizes: 2 0 4", "line 5: an axis of size 0"),
        ("sizes: 2 3 4", "sizes: 2 -3 4", "line 5: '2 -3 4' is not a whole number"),
        ("sizes: 2 3 4", "sizes: 99999999 99999999 99999999", "declares more samples than can be counted"),
        (
            "sizes: 2 3 4",
            "sizes: 2 3 5",
            "byte 158: the data end too early: 48 of 60 bytes are there (24 of 30 int16 samples)",
        ),
        ("spacings: 1 1 1", "spacings: 1 1", "line 6: 2 spacings for 3 axes"),
        ("little", "middle", "line 7: 'middle' is neither little nor big"),
        ("raw", "zrl", "line 8: the encoding 'zrl' is not read"),
        ("raw", "gzip", "gzip data: damaged after 0 unpacked bytes (invalid gzip header)"),
        ("raw\n", "raw\njunk\n", "line 9: 'junk' is neither 'field: value' nor 'key:=value'"),
        ("raw\n", "raw\nline skip: 5\n", "has fewer lines than the 5 to skip before its samples"),
        ("raw\n", "raw\nspace directions: (1,2\n", "line 9: '(1,2' has no ')'"),
        ("raw\n", "raw\nspace origin: zero\n", "line 9: 'zero' is neither a vector '(x,y,z)' nor 'none'"),
    ];
    refused_with("a.nrrd", &nrrd(good, &int16(false)), &cases);
    assert_eq!(
        refusal("a.nrrd", b"NRRD0009\n"),
        "a.nrrd: line 1: NRRD version '0009' is not read; 0001 to 0005 are"
    );
}

#[test]
fn absurd_sizes_take_no_memory() {
    for encoding in ["raw", "gzip", "bzip2", "ascii", "hex"] {
        let data = match encoding {
            "gzip" => gzip(&[0; 64]),
            "bzip2" => bzip2(&[0; 64]),
            _ => b"00 00".to_vec(),
        };
        let fields = format!(
            "type: double\ndimension: 3\nsizes: 100000 100000 100000\nspacings: 1 1 1\nendian: big\nencoding: {encoding}\n"
        );
        // Refused by what it declares, not because the memory was asked for and not given.
        let message = refusal("a.nrrd", &nrrd(&fields, &data));
        assert!(!message.contains("there is no memory"), "{message}");
    }
}

#[test]
fn unknown_fields_and_a_missing_byte_order_are_said() {
    let fields = "type: short\ndimension: 3\nsizes: 2 3 4\nspacings: 1 1 1\nencoding: raw\ncolour: blue\nwho: me\n\
                  content: a test\nkey:=value\\n: more\n";
    let (file, warnings) = read("a.nrrd", &nrrd(fields, &int16(false)));
    assert_eq!(
        warnings,
        [
            "2 unknown NRRD fields ignored, first at 'colour' on line 8",
            "the header does not say the byte order: little endian assumed"
        ]
    );
    assert_eq!(fact(&file, "content"), Some("a test"));
    assert_eq!(fact(&file, "key"), Some("value\\n: more"));
}

/// Found by a hostile run: 420 kB of header that named itself as its data 60,000 times took 5.9 GB.
#[test]
fn a_header_that_names_itself_again_and_again_is_refused() {
    let fields = "type: uchar\ndimension: 3\nsizes: 1024 1024 100\nencoding: raw\ndata file: LIST\n";
    for names in ["d/../self.nhdr\n./self.nhdr\n", "slice\nslice\n"] {
        let header = nrrd(&format!("{fields}{}", names.repeat(50)), b"");
        let slice = vec![7; 1 << 20];
        let others = [("d/../self.nhdr", &slice[..]), ("./self.nhdr", &slice[..]), ("slice", &slice[..])];
        let message = refusal_among("self.nhdr", &header, &others);
        assert!(message.contains("names the same files again and again"), "{message}");
    }
}

/// Found by a hostile run: a pattern of 200 kB, written out for 100,000 numbers, took all memory.
#[test]
fn a_pattern_longer_than_a_name_is_refused() {
    let pattern = format!("{}%d", "a".repeat(200_000));
    let header = nrrd_int16(&format!("encoding: raw\ndata file: {pattern} 0 99999 1\n"), b"");
    let message = refusal_among("a.nhdr", &header, &[]);
    assert!(message.contains("is no file name with one number") && message.len() < 500, "{message}");
}

/// Found by hostile runs: 9 kB of bzip2 that unpack to 10 GB were counted for minutes, or filled as much memory.
#[test]
fn bzip2_data_that_unpack_to_gigabytes_are_refused() {
    let part = bzip2(&vec![0; 10 << 20]);
    let huge = part.repeat(15);
    let header =
        |z, more| format!("type: uchar\ndimension: 3\nsizes: 1024 1024 {z}\nencoding: bzip2\n{SPACED}{more}");
    let message = refusal("a.nrrd", &nrrd(&header(150, ""), &huge));
    assert!(message.contains("bzip2 data: the header declares more than 128 MiB"), "{message}");
    let message = refusal("a.nrrd", &nrrd(&header(1, "byte skip: -1\n"), &huge));
    assert!(message.contains("bzip2 data: they unpack to more than 128 MiB"), "{message}");
    let (file, _) = read("a.nrrd", &nrrd(&header(20, ""), &part.repeat(2)));
    assert_eq!(file.volume.samples().len(), 20 << 20);
}

/// Found by a hostile run: every empty stream of bzip2 costs megabytes of tables.
#[test]
fn thousands_of_empty_bzip2_streams_are_refused() {
    let data = [bzip2(b"").repeat(5000), bzip2(&int16(false))].concat();
    let fields = format!("encoding: bzip2\n{SPACED}");
    let message = refusal("a.nrrd", &nrrd_int16(&fields, &data));
    assert!(message.contains("thousands of streams"), "{message}");
    let data = [bzip2(b""), bzip2(&int16(false)), bzip2(b"")].concat();
    assert_eq!(numbers(&read("a.nrrd", &nrrd_int16(&fields, &data)).0), counting());
}
