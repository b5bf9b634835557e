//! Every well-formed volume of the shared test data, against what other readers (pynrrd, nibabel, SimpleITK, tifffile)
//! found in it.
#![cfg(all(
    feature = "nrrd",
    feature = "bzip2",
    feature = "nifti",
    feature = "metaimage",
    feature = "vtk",
    feature = "tiff"
))]

mod volume_common;

use std::path::PathBuf;

use dotwork_drawing::Warnings;
use dotwork_io::volume::{VolumeFile, VolumeOptions, read_volume};
use dotwork_io::{ReadErrorKind, checksum};
use dotwork_volume::{SampleType, Space, Unit};
use volume_common::{close, columns, fact, numbers};

fn path(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")).join(name)
}

fn read(name: &str) -> (VolumeFile, Vec<String>) {
    let mut warnings = Warnings::new();
    let file = read_volume(&path("volumes").join(name), &VolumeOptions::default(), &mut warnings);
    (file.unwrap_or_else(|e| panic!("{e}")), warnings.iter().map(ToString::to_string).collect())
}

/// Lowest and highest sample, and their sum.
fn statistics(file: &VolumeFile) -> [f64; 3] {
    numbers(file).iter().fold([f64::INFINITY, f64::NEG_INFINITY, 0.0], |[low, high, sum], v| {
        [low.min(*v), high.max(*v), sum + v]
    })
}

use SampleType::{F32, F64, I16, U8, U16};

/// Name, size, type, spacing, lowest and highest sample and their sum.
type Row = (&'static str, [usize; 3], SampleType, [f64; 3], [f64; 3]);

#[rustfmt::skip]
const VOLUMES: [Row; 24] = [
    ("cthead_256x256x113.nrrd", [256, 256, 113], U16, [1.0, 1.0, 2.0], [0.0, 3272.0, 2_810_724_494.0]),
    ("engine_256x256x128.nrrd", [256, 256, 128], U8, [1.0; 3], [0.0, 255.0, 187_475_057.0]),
    ("bonsai_256x256x256.nii.gz", [256, 256, 256], U8, [1.0; 3], [0.0, 255.0, 225_901_147.0]),
    ("fuel_64x33x32.nii.gz", [64, 33, 32], U8, [1.0; 3], [0.0, 255.0, 509_815.0]),
    ("neghip.nhdr", [66, 66, 66], U8, [1.0; 3], [0.0, 255.0, 4_824_177.0]),
    ("ironprot.vtk", [68, 68, 68], U8, [1.0; 3], [0.0, 255.0, 4_131_089.0]),
    ("headsq_64x64x93_bigendian.nrrd", [64, 64, 93], U16, [3.2, 3.2, 1.5], [0.0, 3926.0, 193_392_317.0]),
    ("mni152_t1.nii.gz", [197, 233, 189], U8, [1.0; 3], [0.0, 255.0, 333_468_829.0]),
    ("avf_float32.nrrd", [74, 93, 20], F32, [0.722_656_011_6, 0.722_656_011_6, 1.0], [0.0, 2_509.886_962_89, 25_368_783.287_802]),
    ("adi_slice_oblique.nrrd", [192, 192, 1], U16, [1.145_833_6, 1.145_833_3, 1.0], [0.0, 836.0, 3_454_721.0]),
    ("nrrd_variants/BallBinary30x30x30.nii.gz", [30, 30, 30], I16, [1.0; 3], [0.0, 257.0, 3_682_296.0]),
    ("nrrd_variants/test1d_ascii.nrrd", [27, 1, 1], U8, [1.0458, 1.0, 1.0], [1.0, 27.0, 378.0]),
    ("nrrd_variants/test2d_ascii.nrrd", [3, 9, 1], U16, [1.0458, 2.0, 1.0], [1.0, 27.0, 378.0]),
    ("nrrd_variants/test_customFields.nrrd", [27, 1, 1], U8, [1.0458, 1.0, 1.0], [1.0, 27.0, 378.0]),
    ("nrrd_variants/test_simple4d_raw.nrrd", [1, 1, 1], F64, [1.5, 1.5, 1.0], [0.769_034_26; 3]),
    ("nifti_variants/anatomical.nii", [33, 41, 25], I16, [2.0; 3], [-610.0, 30393.0, 284_166_082.0]),
    ("nifti_variants/zstat1.nii.gz", [64, 64, 21], F32, [4.0, 4.0, 6.0], [-8.710_750_58, 18.582_529_068, 11_648.372_022]),
    ("nifti_variants/example_nifti2.nii.gz", [32, 20, 12], I16, [2.0, 2.0, 2.199_999_09], [49.0, 742.0, 3_461_748.0]),
    ("nifti_variants/f32.nii.gz", [11, 11, 11], F32, [1.0; 3], [0.0, 1.0, 166.000_000_7]),
    ("nifti_variants/minimal.nii", [64, 64, 10], U8, [3.0; 3], [0.0, 63.0, 1_290_240.0]),
    ("nifti_variants/minimal.nii.gz", [64, 64, 10], U8, [3.0; 3], [0.0, 63.0, 1_290_240.0]),
    ("nifti_variants/minimal2.hdr", [64, 64, 10], U8, [3.0; 3], [0.0, 63.0, 1_290_240.0]),
    ("nifti_variants/minimal_extended_hdr.nii", [8, 8, 1], F64, [1.0; 3], [0.0; 3]),
    ("nifti_variants/complex_complex32.nii", [3, 3, 1], F32, [1.0; 3], [0.0, 4.242_640_495, 8.485_281_110]),
];

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn every_volume_holds_what_other_readers_find() {
    for (name, dims, sample, spacing, expected) in VOLUMES {
        let (file, _) = read(name);
        assert_eq!(file.volume.dims(), dims, "{name}");
        assert_eq!(file.volume.samples().sample_type(), sample, "{name}");
        for (found, expected) in file.volume.affine().spacing().iter().zip(spacing) {
            assert!((found - expected).abs() < 1e-6, "{name}: {found} for {expected}");
        }
        for (found, expected) in statistics(&file).iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-6 * (1.0 + expected.abs()),
                "{name}: {found} for {expected}"
            );
        }
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn five_containers_hold_one_head() {
    let (head, _) = read("headmr.mhd");
    assert_eq!(head.volume.dims(), [48, 62, 42]);
    assert_eq!(statistics(&head), [0.0, 255.0, 3_058_332.0]);
    assert_eq!(head.volume.affine().space, Space::Unknown);
    let placed = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0], [0.0; 3]];
    assert_eq!(columns(&head), placed);
    for name in ["headmr_zlib.mha", "headmr.nrrd", "headmr.nii.gz", "headmr_stack.tif"] {
        let (other, warnings) = read(name);
        assert_eq!(other.volume.samples(), head.volume.samples(), "{name}");
        if name.ends_with(".tif") {
            assert_eq!(warnings, ["no spacing in the file: 1 x 1 x 1 assumed"]);
            assert_eq!(fact(&other, "pages"), Some("42"));
            continue;
        }
        assert_eq!(warnings, [""; 0], "{name}");
        assert_eq!(columns(&other), placed, "{name}");
        assert_eq!(other.volume.affine().space, Space::Patient, "{name}");
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn a_ball_in_nine_nrrd_files() {
    let (ball, _) = read("nrrd_variants/BallBinary30x30x30.nrrd");
    assert_eq!(statistics(&ball), [0.0, 257.0, 3_682_296.0]);
    for (name, format) in [
        (".nhdr", "NRRD, detached, raw, little endian"),
        ("_bz2.nrrd", "NRRD, bzip2, little endian"),
        ("_byteskip_minus_one.nhdr", "NRRD, detached, raw, little endian"),
        ("_byteskip_minus_one_nifti.nhdr", "NRRD, detached, gzip, little endian"),
        ("_gz.nrrd", "NRRD, gzip, little endian"),
        ("_gz_byteskip_minus_one.nrrd", "NRRD, gzip, little endian"),
        ("_gz_lineskip.nrrd", "NRRD, gzip, little endian"),
    ] {
        let (other, warnings) = read(&format!("nrrd_variants/BallBinary30x30x30{name}"));
        assert_eq!(other.volume, ball.volume, "{name}");
        assert_eq!(other.format, format);
        assert_eq!(warnings, [""; 0], "{name}");
    }
    for (name, reason) in [
        ("_byteskip_minus_five.nhdr", "line 8: byte skip -5; -1 and more are allowed"),
        ("_nifti.nhdr", "gzip data: unpack to more than the 54000 bytes declared"),
    ] {
        let path = path("volumes/nrrd_variants").join(format!("BallBinary30x30x30{name}"));
        let error = read_volume(&path, &VolumeOptions::default(), &mut Warnings::new()).unwrap_err();
        assert!(error.to_string().ends_with(reason), "{error}");
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn affines_are_those_of_other_readers_in_lps() {
    // nibabel's RAS affines with the first two rows turned; pynrrd's directions as they are.
    for (name, space, unit, expected) in [
        (
            "nifti_variants/anatomical.nii",
            Space::Patient,
            Unit::Millimetre,
            [[2.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 2.0], [-32.0, 40.0, -16.0]],
        ),
        (
            "nifti_variants/example_nifti2.nii.gz",
            Space::Patient,
            Unit::Millimetre,
            [
                [2.0, 0.0, 0.0],
                [0.0, -1.973_711_490_6, 0.323_207_616_8],
                [0.0, 0.355_528_235_4, 2.171_081_781_4],
                [-117.855_102_539, 35.722_942_352, -7.248_798_370],
            ],
        ),
        (
            "nifti_variants/zstat1.nii.gz",
            Space::Patient,
            Unit::Millimetre,
            [[4.0, 0.0, 0.0], [0.0, -4.0, 0.0], [0.0, 0.0, 6.0], [0.0; 3]],
        ),
        (
            "mni152_t1.nii.gz",
            Space::Patient,
            Unit::Unknown,
            [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [98.0, 134.0, -72.0]],
        ),
        (
            "nrrd_variants/test_simple4d_raw.nrrd",
            Space::Patient,
            Unit::Unknown,
            [[-1.5, 0.0, 0.0], [0.0, -1.5, 0.0], [0.0, 0.0, 1.0], [0.0; 3]],
        ),
        (
            "adi_slice_oblique.nrrd",
            Space::Patient,
            Unit::Unknown,
            [
                [0.086_167_978, 1.142_586_031, 0.002_522_087],
                [0.030_298_986, 0.000_243_377, -1.145_432_683],
                [-0.996_817_721, 0.075_233_047, -0.026_351_837],
                [44.638_686_309, -139.689_596_474, 131.843_936_657],
            ],
        ),
        (
            "cthead_256x256x113.nrrd",
            Space::Unknown,
            Unit::Unknown,
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0], [0.0; 3]],
        ),
    ] {
        let (file, _) = read(name);
        let affine = file.volume.affine();
        assert_eq!((affine.space, affine.unit), (space, unit), "{name}");
        assert!(close(columns(&file), expected), "{name}: {:?}", columns(&file));
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn ten_sample_types_hold_the_numbers_to_26() {
    // z runs fastest through the numbers, as nibabel reads them too.
    let expected: Vec<f64> = (0..27).map(|i| f64::from(i % 3 * 9 + i / 3 % 3 * 3 + i / 9)).collect();
    for &sample in SampleType::ALL {
        let (file, warnings) = read(&format!("nifti_variants/27_{}.nii", sample.name()));
        assert_eq!(file.volume.dims(), [3, 3, 3]);
        assert_eq!(file.volume.samples().sample_type(), sample);
        assert_eq!(numbers(&file), expected, "{}", sample.name());
        assert_eq!(warnings, [""; 0]);
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn what_is_converted_or_left_out_is_said() {
    let (rgb, warnings) = read("nifti_variants/rgb_3D.nii");
    assert_eq!(warnings, ["RGB samples: their luminance (Rec. 709) is taken"]);
    // The first voxels are (55, 55, 0) at index (0, 0, 0) and (55, 0, 55) at (0, 0, 1).
    assert_eq!([rgb.volume.value_at(0, 0, 0), rgb.volume.value_at(0, 0, 1)], [51.0, 16.0]);

    let (_, warnings) = read("nifti_variants/complex_complex32.nii");
    assert_eq!(warnings, ["complex samples: their magnitude is taken"]);
    let (fourth, warnings) = read("nifti_variants/example_nifti2.nii.gz");
    assert_eq!(warnings, ["the first of 2 volumes is taken"]);
    assert_eq!(fact(&fourth, "axes"), Some("32 x 20 x 12 x 2"));
    assert_eq!(fourth.format, "NIfTI-2, gzip, little endian");
    let (plain, warnings) = read("nifti_variants/minimal.nii");
    assert_eq!(plain.volume.affine().space, Space::Unknown);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let (custom, _) = read("nrrd_variants/test_customFields.nrrd");
    assert_eq!(fact(&custom, "double vector"), Some("(100.5,200.3,-300.99)"));
    let (z, _) = read("nifti_variants/zstat1.nii.gz");
    assert_eq!(fact(&z, "intent"), Some("z score"));
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn pairs_are_read_by_either_name_and_summed_alike() {
    for [first, second] in [["minimal.hdr", "minimal.img"], ["minimal2.hdr", "minimal2.img.gz"]] {
        let (a, _) = read(&format!("nifti_variants/{first}"));
        let (b, _) = read(&format!("nifti_variants/{second}"));
        assert_eq!(a, b);
        let bytes = [first, second].map(|n| std::fs::read(path("volumes/nifti_variants").join(n)).unwrap());
        assert_eq!(a.checksum, checksum(&bytes.concat()));
    }
    let (single, _) = read("nifti_variants/minimal.nii");
    let bytes = std::fs::read(path("volumes/nifti_variants/minimal.nii")).unwrap();
    assert_eq!(single.checksum, checksum(&bytes));
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn raw_samples_are_read_by_option() {
    let (head, _) = read("headmr.mhd");
    let options =
        |layout: &str| VolumeOptions { raw: Some(layout.parse().unwrap()), ..VolumeOptions::default() };
    let mut warnings = Warnings::new();
    let raw = read_volume(&path("volumes/headmr.raw"), &options("48x62x42:u8:4,4,4"), &mut warnings).unwrap();
    assert_eq!(raw.volume, head.volume);
    assert!(warnings.is_empty());
    // The same samples behind a text header.
    let mut warnings = Warnings::new();
    let head_bytes = std::fs::metadata(path("volumes/nifti_variants/27_uint8.nii")).unwrap().len() - 27;
    let layout = format!("3x3x3:u8:header={head_bytes}");
    let raw = read_volume(&path("volumes/nifti_variants/27_uint8.nii"), &options(&layout), &mut warnings);
    assert_eq!(numbers(&raw.unwrap())[26], 26.0);
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn malformed_volumes_are_refused() {
    let options = VolumeOptions::default();
    for name in ["nifti_crash-08123ef3.nii", "nifti_crash-1.nii", "nifti_crash-98aa0543.nii"] {
        let error =
            read_volume(&path("malformed/volume").join(name), &options, &mut Warnings::new()).unwrap_err();
        assert!(matches!(error.kind, ReadErrorKind::Malformed { .. }), "{error}");
    }
    let path = path("malformed/volume/nifti1_header_only.hdr");
    let error = read_volume(&path, &options, &mut Warnings::new()).unwrap_err();
    assert!(error.to_string().ends_with("nifti1_header_only.img: no such file"), "{error}");
    let folder = path.parent().unwrap().parent().unwrap();
    for (name, reason) in [
        ("volume/badvr.dcm", "is DICOM with '1A' frames"),
        ("mesh/crash-30d6d0f7.ply", "is no volume that dotwork reads"),
        ("mesh/empty.obj", "the file is empty"),
        ("mesh", "is a directory without TIFF files"),
    ] {
        let error = read_volume(&folder.join(name), &options, &mut Warnings::new()).unwrap_err();
        assert!(error.to_string().contains(reason), "{error}");
    }
}
