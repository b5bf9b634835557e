//! Damaged volumes: whatever happens to a file, reading it gives a volume or an error, never a panic.
#![cfg(all(
    feature = "nrrd",
    feature = "bzip2",
    feature = "nifti",
    feature = "metaimage",
    feature = "vtk",
    feature = "tiff"
))]

#[path = "common/mutate.rs"]
mod mutate;
mod volume_common;

use std::path::Path;

use dotwork_io::volume::VolumeOptions;
use volume_common::{Nifti, gray_page, gzip, int16, nrrd, nrrd_int16, reads_soundly, tiff_file, zlib};

/// A name and the bytes of a small file of each kind.
fn samples() -> Vec<(String, Vec<u8>)> {
    let data = int16(false);
    let numbers = "0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23";
    let place = "space: RAS\nspace directions: (1,0,0) (0,2,0) (0,0,3)\nspace origin: (1,2,3)\n";
    let colours =
        "type: uchar\ndimension: 4\nsizes: 3 2 2 4\nkinds: RGB-color domain domain domain\nencoding: raw\n";
    let mha = |fields: &str, data: &[u8]| {
        let header = format!(
            "NDims = 3\n{fields}DimSize = 2 3 4\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nElementSpacing = 1 2 3\n\
             ElementType = MET_SHORT\nElementDataFile = LOCAL\n"
        );
        [header.as_bytes(), data].concat()
    };
    let vtk = |kind: &str, data: &[u8]| {
        let header = format!(
            "# vtk DataFile Version 3.0\nt\n{kind}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 3 4\nSPACING 1 2 3\n\
             ORIGIN 0 0 0\nPOINT_DATA 24\nSCALARS a short 1\nLOOKUP_TABLE default\n"
        );
        [header.as_bytes(), data].concat()
    };
    let fields = vtk("ASCII", numbers.as_bytes());
    let at = fields.windows(10).position(|w| w == b"DIMENSIONS").unwrap();
    let mut tiled = gray_page(20, 17, 8, &[3; 4 * 256]);
    tiled.tags.retain(|t| t.0 != 278);
    tiled.tags.extend([(322, 32), (323, 32), (324, 8), (325, 1024)]);
    let packed = zlib(&[5; 40]);
    let mut deflated = gray_page(5, 8, 8, &packed);
    deflated.tags.retain(|t| t.0 != 259);
    deflated.tags.extend([(259, 8), (317, 2)]);
    let mut samples = vec![
        ("raw.nrrd".into(), nrrd_int16(&format!("{place}encoding: raw\n"), &data)),
        ("gz.nrrd".into(), nrrd_int16(&format!("{place}encoding: gzip\nbyte skip: -1\n"), &gzip(&data))),
        (
            "ascii.nrrd".into(),
            nrrd_int16("axis mins: 0 0 0\naxis maxs: 4 5 6\nencoding: ascii\n", numbers.as_bytes()),
        ),
        (
            "hex.nrrd".into(),
            nrrd_int16("encoding: hex\nline skip: 1\n", &[b"x\n", &b"0a"[..].repeat(48)[..]].concat()),
        ),
        ("rgb.nrrd".into(), nrrd(colours, &[9; 48])),
        ("list.nhdr".into(), nrrd_int16("encoding: raw\ndata file: LIST\nraw\nraw\n", b"")),
        ("pattern.nhdr".into(), nrrd_int16("encoding: raw\ndata file: r%dw 1 4 1 2\n", b"")),
        ("one.nii".into(), Nifti::default().file(&data)),
        ("two.nii".into(), Nifti { second: true, big_endian: true, ..Nifti::default() }.file(&int16(true))),
        ("q.nii".into(), Nifti { codes: [1, 0], quaternion: [0.5; 6], ..Nifti::default() }.file(&data)),
        ("complex.nii".into(), Nifti { datatype: 32, bitpix: 64, ..Nifti::default() }.file(&[1; 192])),
        ("a.nii.gz".into(), gzip(&Nifti::default().file(&data))),
        ("raw.hdr".into(), Nifti { single: false, ..Nifti::default() }.header()),
        ("a.mha".into(), mha("BinaryDataByteOrderMSB = True\n", &data)),
        ("z.mha".into(), mha("CompressedData = True\nCompressedDataSize = 40\n", &zlib(&data))),
        ("t.mha".into(), mha("BinaryData = False\nHeaderSize = -1\n", numbers.as_bytes())),
        ("a.vtk".into(), vtk("BINARY", &data)),
        ("t.vtk".into(), vtk("ASCII", numbers.as_bytes())),
        (
            "field.vtk".into(),
            [&fields[..at], b"FIELD f 2\nt 1 1 int\n7\nv 2 2 float\n1 2 3 4\n", &fields[at..]].concat(),
        ),
        (
            "a.tif".into(),
            tiff_file(true, &[gray_page(3, 4, 16, &data[..24]), gray_page(3, 4, 16, &data[24..])]),
        ),
        ("d.tif".into(), tiff_file(false, &[deflated])),
        ("tiles.tif".into(), tiff_file(false, &[tiled])),
    ];
    for name in [
        "float32_predictor_big_endian.tif",
        "float64_bigtiff.tif",
        "imagej_hyperstack.tif",
        "imagej_one_page.tif",
        "int16_packbits_big_endian.tif",
        "ome.tif",
        "rgb_planar_tiles.tif",
        "uint16_lzw_tiles_big_endian.tif",
    ] {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/tiff")).join(name);
        samples.push((name.into(), std::fs::read(path).unwrap()));
    }
    samples
}

/// [`reads_soundly`] beside the files that the samples name.
fn read(name: &str, bytes: &[u8], options: &VolumeOptions) -> bool {
    let data = int16(false);
    let others = [("raw", &data[..24]), ("r1w", &data[..12]), ("r2w", &data[12..24]), ("raw.img", &data[..])];
    reads_soundly(name, bytes, &others, options)
}

#[test]
fn damaged_files_give_volumes_or_errors() {
    let raw = VolumeOptions { raw: Some("2x3x4:i16:be".parse().unwrap()), ..VolumeOptions::default() };
    let (mut refused, mut total) = (0, 0);
    for (name, bytes) in samples() {
        for seed in 0..1500 {
            let mutant = mutate::mutate(&bytes, seed);
            refused += usize::from(!read(&name, &mutant, &VolumeOptions::default()));
            total += 1;
            if seed % 50 == 0 {
                read(&name, &mutant, &raw);
            }
        }
    }
    // The harness does something: many mutants are refused, and many are not.
    assert!(refused > total / 10 && refused < total * 9 / 10, "{refused} of {total}");
}

#[test]
fn files_cut_anywhere_give_volumes_or_errors() {
    for (name, bytes) in samples() {
        for end in (0..bytes.len()).step_by(1 + bytes.len() / 400) {
            read(&name, &bytes[..end], &VolumeOptions::default());
        }
    }
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn damaged_real_files_give_volumes_or_errors() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/volumes"));
    for name in [
        "nrrd_variants/BallBinary30x30x30_bz2.nrrd",
        "nrrd_variants/BallBinary30x30x30_gz_lineskip.nrrd",
        "nrrd_variants/test_customFields.nrrd",
        "nrrd_variants/test_simple4d_raw.nrrd",
        "nrrd_variants/BallBinary30x30x30.nii.gz",
        "nifti_variants/27_float32.nii",
        "nifti_variants/minimal.nii.gz",
        "nifti_variants/minimal_extended_hdr.nii",
        "nifti_variants/rgb_3D.nii",
        "headmr_stack.tif",
        "headmr_zlib.mha",
    ] {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        for seed in 0..200 {
            read(name, &mutate::mutate(&bytes, seed), &VolumeOptions::default());
        }
    }
}
