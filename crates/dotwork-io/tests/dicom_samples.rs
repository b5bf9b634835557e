//! DICOM: every way to write samples, and what they mean.
#![cfg(feature = "dicom")]

mod dicom_common;
mod volume_common;

use std::path::Path;

use dicom_common::{
    DISTANCE, FRAMES, Form, INTERCEPT, ORIENTATION, PADDING, PHOTOMETRIC, PIXELS, POSITION, SLOPE, Set,
    Value, firsts, kept, read_path, series, shared, slice, words,
};
use dotwork_io::checksum;
use dotwork_io::volume::{VolumeFormat, volume_format_of};
use dotwork_volume::{SampleType, Samples, Scaling};
use volume_common::{close, columns, gzip, numbers, read, read_quietly, refusal};

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
        ("htj2k_int16.dcm", &i16, "high-throughput JPEG 2000"),
        ("jpeg_lossless_int16.dcm", &i16, "JPEG lossless"),
        ("jpeg_ls.dcm", &u8, "JPEG-LS"),
        ("jls_int16.dcm", &i16, "JPEG-LS"),
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
    for name in
        ["rle_colour.dcm", "htj2k_colour.dcm", "j2k_colour.dcm", "jls_colour.dcm", "jls_colour_lines.dcm"]
    {
        let (file, warnings) = read(name, &kept(name));
        assert_eq!(numbers(&file), luminance, "{name}");
        assert_eq!(warnings, ["the luminance of colours is taken"]);
    }
    // Lossy, with colour differences of half the resolution.
    let (file, _) = read("c", &kept("jpeg_baseline_colour.dcm"));
    let error = numbers(&file).iter().zip(&luminance).map(|(a, b)| (a - b).abs()).sum::<f64>() / 1440.0;
    assert!(error < 6.0, "{error}");
}

/// Samples of both sorts of JPEG-LS coding: runs within flat areas, and the sawtooth of [`pattern`] between them.
fn blocks() -> Vec<i64> {
    let sawtooth = &pattern()[0];
    let sample = |i: usize| match (i % 40, i / 40) {
        (x, y) if (x / 8 + y / 6) % 3 == 0 => sawtooth[i] / 4,
        (x, y) => 100 * (x / 20 + y / 18) as i64,
    };
    (0..1440).map(sample).collect()
}

#[test]
fn jpeg_ls_with_runs_presets_and_restarts() {
    let blocks = blocks();
    let found = |name: &str| -> Vec<i64> {
        numbers(&read_quietly(name, &kept(name))).iter().map(|&v| v as i64).collect()
    };
    assert_eq!(found("jls_restarts_uint10.dcm"), blocks);
    // Two frames of two fragments each, without a table that says which is whose.
    let upside_down: Vec<i64> = blocks.chunks(40).rev().flatten().copied().collect();
    assert_eq!(found("jls_frames_uint10.dcm"), [blocks, upside_down].concat());
}

#[test]
fn nearly_lossless_jpeg_ls() {
    let file = read_quietly("near", &kept("jls_near_uint12.dcm"));
    assert_eq!(file.format, "DICOM, JPEG-LS near-lossless");
    let samples: Vec<i64> = numbers(&file).iter().map(|&v| v as i64).collect();
    assert!(samples.iter().zip(&pattern()[0]).all(|(a, b)| (a - b).abs() <= 3));
    // An independent decoder's samples, summed up with weights.
    let sum: i64 = samples.iter().enumerate().map(|(i, s)| s * (i as i64 % 97 + 1)).sum();
    assert_eq!(sum, 136_246_589);
}

#[test]
fn lossy_high_throughput_jpeg_2000() {
    let samples = numbers(&read_quietly("lossy", &kept("htj2k_lossy_uint8.dcm")));
    let errors: Vec<f64> = samples.iter().zip(&pattern()[2]).map(|(a, &b)| (a - b as f64).abs()).collect();
    // Its steps are of 2.6; OpenJPH, which takes the middle of a step, is up to 2 off and 0.47 on average.
    assert!(errors.iter().all(|&e| e <= 5.0));
    assert!(errors.iter().sum::<f64>() / 1440.0 < 0.8, "{}", errors.iter().sum::<f64>() / 1440.0);
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
