//! NIfTI files that the tests make.
#![cfg(feature = "nifti")]

mod volume_common;

use dotwork_io::volume::VolumeOptions;
use dotwork_volume::{SampleType, Scaling, Space, Unit};
use volume_common::{
    Nifti, close, columns, counting, fact, gzip, int16, numbers, read, read_among, read_quietly, refusal,
    refusal_among,
};

#[test]
fn both_versions_byte_orders_and_wrappings() {
    for second in [false, true] {
        for big_endian in [false, true] {
            let nifti = Nifti { second, big_endian, ..Nifti::default() };
            let file = nifti.file(&int16(big_endian));
            let version = if second { "NIfTI-2" } else { "NIfTI-1" };
            let order = if big_endian { "big endian" } else { "little endian" };
            let plain = read_quietly("a.nii", &file);
            assert_eq!(plain.volume.dims(), [2, 3, 4]);
            assert_eq!(numbers(&plain), counting(), "{version} {order}");
            assert_eq!(plain.format, format!("{version}, {order}"));
            assert_eq!(
                columns(&plain),
                [[-0.5, 0.0, 0.0], [0.0, -0.75, 0.0], [0.0, 0.0, 2.5], [-1.0, -2.0, 3.0]]
            );
            let affine = plain.volume.affine();
            assert_eq!((affine.space, affine.unit), (Space::Patient, Unit::Millimetre));
            assert_eq!(fact(&plain, "description"), Some("made by a test"));

            let packed = read_quietly("a.nii.gz", &gzip(&file));
            assert_eq!(packed.volume, plain.volume);
            assert_eq!(packed.format, format!("{version}, gzip, {order}"));

            let pair = Nifti { single: false, ..nifti };
            let (header, data) = (pair.header(), int16(big_endian));
            let (packed, options) = (gzip(&data), VolumeOptions::default());
            for (name, bytes, other, other_bytes) in [
                ("d/a.hdr", &header, "d/a.img", &data),
                ("d/a.hdr", &header, "d/a.img.gz", &packed),
                ("d/a.img", &data, "d/a.hdr", &header),
                ("d/a.img.gz", &packed, "d/a.hdr", &header),
                ("d/a.HDR", &header, "d/a.IMG", &data),
                ("a.b.hdr", &header, "a.b.img", &data),
            ] {
                let (read, warnings) = read_among(name, bytes, &[(other, other_bytes)], &options);
                let read = read.unwrap_or_else(|e| panic!("{e}"));
                assert_eq!(read.volume, plain.volume, "{name}");
                assert_eq!(warnings, [""; 0]);
            }
        }
    }
}

#[test]
fn the_qform_is_a_quaternion() {
    // Expected: nibabel 5.4 get_qform, rows x and y turned.
    for (pixdim0, quaternion, expected) in [
        (
            -1.0,
            [0.1, -0.3, 0.5, 10.0, -20.0, 30.5],
            [
                [-0.159_999_992_8, -0.373_112_883_5, 0.291_867_741_4],
                [0.649_669_330_1, -0.359_999_999_6, -0.104_066_141_6],
                [-0.959_338_699_6, -1.153_112_920_9, -1.999_999_962_7],
                [-10.0, 20.0, 30.5],
            ],
        ),
        (
            // A half turn: the squares sum to a little more than 1 in single precision.
            1.0,
            [0.6, 0.0, 0.8, 10.0, -20.0, 30.5],
            [
                [0.139_999_988_6, 0.0, 0.480_000_003_3],
                [0.0, 0.75, 0.0],
                [-2.400_000_016_7, 0.0, 0.699_999_942_8],
                [-10.0, 20.0, 30.5],
            ],
        ),
    ] {
        let mut nifti = Nifti { codes: [1, 0], quaternion, ..Nifti::default() };
        nifti.pixdim[0] = pixdim0;
        let file = read_quietly("a.nii", &nifti.file(&int16(false)));
        assert!(close(columns(&file), expected), "{:?}", columns(&file));
        assert_eq!(fact(&file, "space"), Some("qform, scanner"));
    }
}

#[test]
fn the_sform_goes_before_the_qform_and_disagreement_is_said() {
    let agreeing = Nifti { codes: [1, 4], quaternion: [0.0, 0.0, 0.0, 1.0, 2.0, 3.0], ..Nifti::default() };
    let file = read_quietly("a.nii", &agreeing.file(&int16(false)));
    assert_eq!(fact(&file, "space"), Some("sform, MNI 152"));

    let apart = Nifti { quaternion: [0.0, 0.0, 0.0, 1.0, 2.0, 8.0], ..agreeing.clone() };
    let (file, warnings) = read("a.nii", &apart.file(&int16(false)));
    assert_eq!(columns(&file)[3], [-1.0, -2.0, 3.0]);
    assert_eq!(
        warnings,
        ["sform (MNI 152) and qform (scanner) place the volume up to 5.000 apart; the sform is taken"]
    );

    let degenerate = Nifti { rows: [[0.0; 4]; 3], ..agreeing };
    let (file, warnings) = read("a.nii", &degenerate.file(&int16(false)));
    assert_eq!(warnings, ["the sform is degenerate and is ignored"]);
    assert_eq!(columns(&file), [[-0.5, 0.0, 0.0], [0.0, -0.75, 0.0], [0.0, 0.0, 2.5], [-1.0, -2.0, 3.0]]);
}

#[test]
fn without_a_transform_only_the_spacing_is_taken() {
    let said = "the header gives no orientation (sform and qform codes are 0): only its spacing is taken";
    let nifti = Nifti { codes: [0, 0], ..Nifti::default() };
    let (file, warnings) = read("a.nii", &nifti.file(&int16(false)));
    assert_eq!(columns(&file), [[0.5, 0.0, 0.0], [0.0, 0.75, 0.0], [0.0, 0.0, 2.5], [0.0; 3]]);
    assert_eq!(file.volume.affine().space, Space::Unknown);
    assert_eq!(warnings, [said]);

    let mut odd = nifti;
    odd.pixdim = [1.0, -2.0, f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (file, warnings) = read("a.nii", &odd.file(&int16(false)));
    assert_eq!(file.volume.affine().spacing(), [2.0, 1.0, 1.0]);
    assert_eq!(
        warnings,
        [
            said,
            "the spacing along x is negative: its size is taken",
            "the spacing along y is NaN: 1 assumed",
            "the spacing along z is 0: 1 assumed"
        ]
    );
}

#[test]
fn every_datatype_is_read_or_named() {
    let types = [
        (2, 8, SampleType::U8),
        (4, 16, SampleType::I16),
        (8, 32, SampleType::I32),
        (16, 32, SampleType::F32),
        (64, 64, SampleType::F64),
        (256, 8, SampleType::I8),
        (512, 16, SampleType::U16),
        (768, 32, SampleType::U32),
        (1024, 64, SampleType::I64),
        (1280, 64, SampleType::U64),
    ];
    for (datatype, bitpix, sample) in types {
        let nifti = Nifti { datatype, bitpix, ..Nifti::default() };
        let file = read_quietly("a.nii", &nifti.file(&vec![0; 24 * sample.bytes()]));
        assert_eq!(file.volume.samples().sample_type(), sample);
    }
    for (datatype, reason) in [
        (1, "samples of 1 bit are not read"),
        (1536, "128-bit floats are not read"),
        (2048, "128-bit floats are not read"),
        (7, "datatype 7 is none of NIfTI's"),
    ] {
        let nifti = Nifti { datatype, ..Nifti::default() };
        assert_eq!(refusal("a.nii", &nifti.file(&[0; 999])), format!("a.nii: byte 70: {reason}"));
    }
}

#[test]
fn colours_and_complex_numbers() {
    let small = Nifti { dim: [3, 2, 1, 1, 1, 1, 1, 1], ..Nifti::default() };
    let rgb = Nifti { datatype: 128, bitpix: 24, scaling: [2.0, 1.0], ..small.clone() };
    let (file, warnings) = read("a.nii", &rgb.file(&[255, 0, 0, 10, 20, 30]));
    assert_eq!(numbers(&file), [54.0, 19.0]);
    assert_eq!(warnings, ["RGB samples: their luminance (Rec. 709) is taken"]);
    assert_eq!(file.volume.scaling(), Scaling::default());
    let rgba = Nifti { datatype: 2304, bitpix: 32, ..small.clone() };
    assert_eq!(numbers(&read("a.nii", &rgba.file(&[255, 0, 0, 1, 10, 20, 30, 2])).0), [54.0, 19.0]);

    let complex = Nifti { datatype: 32, bitpix: 64, big_endian: true, ..small.clone() };
    let data: Vec<u8> = [3.0f32, -4.0, 0.0, 2.0].iter().flat_map(|v| v.to_be_bytes()).collect();
    let (file, warnings) = read("a.nii", &complex.file(&data));
    assert_eq!(numbers(&file), [5.0, 2.0]);
    assert_eq!(warnings, ["complex samples: their magnitude is taken"]);
    let complex = Nifti { datatype: 1792, bitpix: 128, ..small };
    let data: Vec<u8> = [3.0f64, -4.0, 0.0, 2.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    assert_eq!(numbers(&read("a.nii", &complex.file(&data)).0), [5.0, 2.0]);
}

#[test]
fn scaling_is_kept_apart_from_the_samples() {
    for (scaling, expected) in [
        ([2.5, -10.0], Scaling { slope: 2.5, intercept: -10.0 }),
        ([-1.0, 0.0], Scaling { slope: -1.0, intercept: 0.0 }),
        ([0.0, 7.0], Scaling::default()),
        ([f64::NAN, 7.0], Scaling::default()),
        ([2.0, f64::NAN], Scaling { slope: 2.0, intercept: 0.0 }),
    ] {
        let file = read_quietly("a.nii", &Nifti { scaling, ..Nifti::default() }.file(&int16(false)));
        assert_eq!(file.volume.scaling(), expected);
        assert_eq!(numbers(&file), counting());
    }
    let (file, warnings) =
        read("a.nii", &Nifti { scaling: [f64::INFINITY, 0.0], ..Nifti::default() }.file(&int16(false)));
    assert_eq!(file.volume.scaling(), Scaling::default());
    assert_eq!(warnings, ["the scaling inf x + 0 is not finite and is ignored"]);
}

#[test]
fn fewer_and_more_axes() {
    for (dim, dims, warning) in [
        ([1, 24, 0, 0, 0, 0, 0, 0], [24, 1, 1], None),
        ([2, 6, 4, 0, 0, 0, 0, 0], [6, 4, 1], None),
        ([4, 2, 3, 2, 2, 1, 1, 1], [2, 3, 2], Some("the first of 2 volumes is taken")),
        ([7, 2, 3, 1, 2, 1, 2, 0], [2, 3, 1], Some("the first of 4 volumes is taken")),
        ([4, 2, 3, 4, 0, 0, 0, 0], [2, 3, 4], None),
    ] {
        let (file, warnings) = read("a.nii", &Nifti { dim, ..Nifti::default() }.file(&int16(false)));
        assert_eq!(file.volume.dims(), dims);
        assert_eq!(numbers(&file)[..], counting()[..dims.iter().product()]);
        assert_eq!(warnings, warning.map(String::from).into_iter().collect::<Vec<_>>());
    }
}

#[test]
fn offsets_extensions_units_and_tails() {
    let data = int16(false);
    let extended = Nifti { vox_offset: 384.0, units: 2 | 8, ..Nifti::default() };
    let bytes = [extended.header(), vec![1, 0, 0, 0], vec![9; 32], data.clone()].concat();
    assert_eq!(numbers(&read_quietly("a.nii", &bytes)), counting());
    let packed = read_quietly("a.nii.gz", &gzip(&bytes));
    assert_eq!(numbers(&packed), counting());

    let (_, warnings) = read("a.nii", &[&Nifti::default().file(&data)[..], b"tail"].concat());
    assert_eq!(warnings, ["4 bytes after the samples ignored"]);
    let (_, warnings) = read("a.nii.gz", &gzip(&[&Nifti::default().file(&data)[..], b"tail"].concat()));
    assert_eq!(warnings, ["more gzip data after the samples ignored"]);
    for (units, expected) in [
        (0, Unit::Unknown),
        (1, Unit::Metre),
        (2, Unit::Millimetre),
        (3, Unit::Micrometre),
        (19, Unit::Micrometre),
    ] {
        let file = read_quietly("a.nii", &Nifti { units, ..Nifti::default() }.file(&data));
        assert_eq!(file.volume.affine().unit, expected);
    }
}

#[test]
fn what_breaks_the_rules_is_refused() {
    let data = int16(false);
    let file = |nifti: Nifti| nifti.file(&data);
    let dim = |dim: [i64; 8]| file(Nifti { dim, ..Nifti::default() });
    let offset = |vox_offset: f64| file(Nifti { vox_offset, ..Nifti::default() });
    for (bytes, reason) in [
        (dim([0, 2, 3, 4, 1, 1, 1, 1]), "byte 40: 0 axes; NIfTI has 1 to 7"),
        (dim([9, 2, 3, 4, 1, 1, 1, 1]), "byte 40: 9 axes; NIfTI has 1 to 7"),
        (dim([3, 2, -3, 4, 1, 1, 1, 1]), "byte 44: axis 2 has the size -3"),
        (
            dim([3, 2, 3, 5, 1, 1, 1, 1]),
            "byte 400: the data end too early: 48 of 60 bytes are there (24 of 30 int16 samples)",
        ),
        (offset(100.0), "byte 108: samples at byte 100: that is within the header"),
        (offset(-5.0), "byte 108: samples at byte -5: that is no place in a file"),
        (offset(352.5), "byte 108: samples at byte 352.5: that is no place in a file"),
        (offset(1e6), "byte 400: the data end too early: 0 of 48 bytes are there (0 of 24 int16 samples)"),
        (
            Nifti::default().header()[..200].to_vec(),
            "byte 200: the file ends within the 348 bytes of its NIfTI header",
        ),
        (vec![0; 400], "byte 0: is no NIfTI header: it does not begin with its size, 348 or 540"),
    ] {
        assert_eq!(refusal("a.nii", &bytes), format!("a.nii: {reason}"));
    }
    let mut analyze = Nifti::default().header();
    analyze[344..348].fill(0);
    assert_eq!(
        refusal("a.hdr", &analyze),
        "a.hdr: byte 344: is an ANALYZE 7.5 header, which says nothing of sides; convert it to NIfTI"
    );
    let huge = Nifti { second: true, dim: [7, i64::MAX, i64::MAX, 4, 1, 1, 1, 1], ..Nifti::default() };
    assert_eq!(refusal("a.nii", &file(huge)), "a.nii: declares more samples than can be counted");
    let large = Nifti { second: true, dim: [3, 1 << 20, 1 << 20, 4, 1, 1, 1, 1], ..Nifti::default() };
    assert_eq!(
        refusal("a.nii.gz", &gzip(&file(large))),
        "a.nii.gz: declares 8796093022208 bytes of samples, more than its gzip data can unpack to"
    );
    let pair = Nifti { single: false, ..Nifti::default() };
    assert_eq!(refusal("d/a.hdr", &pair.header()), "d/a.hdr: data file d/a.img: no such file");
    assert_eq!(refusal("d/a.img", &data), "d/a.img: data file d/a.hdr: no such file");
    let short = refusal_among("d/a.hdr", &pair.header(), &[("d/a.img", &data[..40])]);
    assert_eq!(
        short,
        "d/a.hdr: data file d/a.img: byte 40: the data end too early: 40 of 48 bytes are there \
         (20 of 24 int16 samples)"
    );
}
