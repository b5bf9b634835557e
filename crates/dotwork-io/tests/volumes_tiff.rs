//! TIFF stacks: files that tifffile wrote (`tests/data/tiff`), files that the tests make, and folders.
#![cfg(feature = "tiff")]

mod volume_common;

use std::path::Path;

use dotwork_drawing::Warnings;
use dotwork_io::checksum;
use dotwork_io::volume::{VolumeFile, VolumeFormat, VolumeOptions, read_volume, volume_format_of};
use dotwork_volume::{SampleType, Unit};
use volume_common::{TiffPage, fact, gray_page, numbers, read, read_quietly, refusal, tiff_file};

const NO_SPACING: &str = "no spacing in the file: 1 x 1 x 1 assumed";

fn made_by_tifffile(name: &str) -> (VolumeFile, Vec<String>) {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/tiff")).join(name);
    let mut warnings = Warnings::new();
    let file = read_volume(&path, &VolumeOptions::default(), &mut warnings).unwrap_or_else(|e| panic!("{e}"));
    (file, warnings.iter().map(ToString::to_string).collect())
}

/// Compares each voxel with a formula of its index.
fn check(file: &VolumeFile, dims: [usize; 3], value: impl Fn(f64, f64, f64) -> f64) {
    assert_eq!(file.volume.dims(), dims);
    let found = numbers(file);
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let expected = value(x as f64, y as f64, z as f64);
                assert_eq!(found[(z * dims[1] + y) * dims[0] + x], expected, "{x} {y} {z}");
            }
        }
    }
}

#[test]
fn packings_predictors_tiles_and_byte_orders() {
    let (file, warnings) = made_by_tifffile("float32_predictor_big_endian.tif");
    check(&file, [20, 17, 2], |x, y, z| x / 8.0 - y * 3.5 + z * 1000.0);
    assert_eq!(file.volume.samples().sample_type(), SampleType::F32);
    assert_eq!(file.format, "TIFF, deflate, big endian");
    assert_eq!(warnings, [NO_SPACING]);
    let (file, _) = made_by_tifffile("uint16_lzw_tiles_big_endian.tif");
    check(&file, [20, 17, 3], |x, y, z| x + 10.0 * y + 100.0 * z);
    let (file, _) = made_by_tifffile("int16_packbits_big_endian.tif");
    check(&file, [20, 17, 2], |x, y, z| (x / 5.0).floor() * 100.0 - y * 1000.0 + z);
    let (file, _) = made_by_tifffile("float64_bigtiff.tif");
    check(&file, [20, 17, 2], |x, y, z| x / 3.0 + y + z);
    assert_eq!(file.format, "BigTIFF, deflate");
    let (file, warnings) = made_by_tifffile("rgb_planar_tiles.tif");
    check(&file, [20, 17, 1], |x, y, _| (0.2126 * x * 12.0 + 0.7152 * y * 15.0 + 0.0722 * (x + y)).round());
    assert_eq!(warnings, ["RGB samples: their luminance (Rec. 709) is taken", NO_SPACING]);
}

#[test]
fn imagej_and_ome_say_what_pages_are() {
    for name in ["imagej_hyperstack.tif", "ome.tif"] {
        let (file, warnings) = made_by_tifffile(name);
        check(&file, [7, 5, 3], |x, y, z| x + 10.0 * y + 100.0 * z);
        assert_eq!(warnings, ["the first of 2 channels is taken", "the first of 2 frames is taken"]);
        assert_eq!(file.volume.affine().unit, Unit::Micrometre);
        assert_eq!(fact(&file, "pages"), Some("12"));
    }
    let (file, _) = made_by_tifffile("imagej_hyperstack.tif");
    assert_eq!(file.volume.affine().spacing(), [0.25, 0.2, 2.5]);
    let (file, _) = made_by_tifffile("ome.tif");
    assert_eq!(file.volume.affine().spacing(), [0.25, 0.5, 2.0]);

    // Large stacks of ImageJ have one page, and the other slices behind it.
    let mut bytes =
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/tiff/imagej_one_page.tif")).unwrap();
    let (whole, _) = read("a.tif", &bytes);
    check(&whole, [7, 5, 3], |x, y, z| x + 10.0 * y + 100.0 * z);
    let first = u32::from_le_bytes(bytes[4..8].try_into().unwrap()) as usize;
    let entries = usize::from(u16::from_le_bytes([bytes[first], bytes[first + 1]]));
    let next = first + 2 + 12 * entries;
    bytes[next..next + 4].fill(0);
    let (file, warnings) = read("a.tif", &bytes);
    assert_eq!(warnings, [""; 0]);
    assert_eq!(file.volume, whole.volume);
    assert_eq!(file.volume.affine().unit, Unit::Millimetre);
    // Cut within its third slice, which no page announces.
    let slice: Vec<u8> = numbers(&whole)[70..].iter().flat_map(|v| (*v as u16).to_le_bytes()).collect();
    let third = bytes.windows(slice.len()).position(|w| w == slice).unwrap();
    let message = refusal("a.tif", &bytes[..third + 20]);
    assert!(message.ends_with("the file ends within slice 3 of the 3 its description declares"), "{message}");
}

#[test]
fn pages_of_either_byte_order() {
    let little: Vec<u8> = (0..12i16).flat_map(|i| (i - 3).to_le_bytes()).collect();
    let big: Vec<u8> = (0..12i16).flat_map(|i| (i - 3).to_be_bytes()).collect();
    for (big_endian, data) in [(false, little), (true, big)] {
        let pages: Vec<TiffPage> = data
            .chunks(12)
            .map(|slice| {
                let mut page = gray_page(3, 2, 16, slice);
                page.tags.push((339, 2));
                page
            })
            .collect();
        let (file, _) = read("a.tif", &tiff_file(big_endian, &pages));
        assert_eq!(file.volume.dims(), [3, 2, 2]);
        assert_eq!(numbers(&file), (-3..9).map(f64::from).collect::<Vec<_>>());
    }
}

#[test]
fn thumbnails_are_left_out_and_unequal_pages_refused() {
    let (data, small) = ([7; 6], [1; 1]);
    let mut thumbnail = gray_page(1, 1, 8, &small);
    thumbnail.tags.push((254, 1));
    let pages = [gray_page(3, 2, 8, &data), thumbnail, gray_page(3, 2, 8, &data)];
    let (file, warnings) = read("a.tif", &tiff_file(false, &pages));
    assert_eq!(file.volume.dims(), [3, 2, 2]);
    assert_eq!(warnings, ["1 pages of reduced size left out", NO_SPACING]);
    let unequal = tiff_file(false, &[gray_page(3, 2, 8, &data), gray_page(2, 3, 8, &data)]);
    let message = refusal("a.tif", &unequal);
    assert!(message.ends_with("page 2 is 2 x 3 uint8, page 1 is 3 x 2 uint8"), "{message}");
}

#[test]
fn what_is_not_read_is_named() {
    let data = [0; 64];
    let with = |tags: &[(u16, u32)]| {
        let mut page = gray_page(4, 2, 8, &data);
        for &(tag, value) in tags {
            page.tags.retain(|t| t.0 != tag);
            page.tags.push((tag, value));
        }
        tiff_file(false, &[page])
    };
    for (tags, reason) in [
        (&[(258, 12)][..], "samples of 12 bits are not read; 8, 16, 32 and 64 are"),
        (&[(258, 1)], "samples of 1 bits are not read; 8, 16, 32 and 64 are"),
        (&[(258, 16), (339, 3)], "floats of 16 bits are not read; 32 and 64 are"),
        (&[(259, 7)], "JPEG compression is not read"),
        (&[(259, 50000)], "Zstandard compression is not read"),
        (&[(259, 4)], "fax compression is not read"),
        (&[(262, 6), (277, 3)], "YCbCr colours are not read"),
        (&[(262, 2)], "RGB with 1 samples a pixel"),
        (&[(256, 0)], "Width is 0"),
        (&[(278, 0)], "RowsPerStrip is 0"),
        (&[(278, 1)], "1 strips or tiles where 2 are needed"),
        (&[(257, 4_000_000_000)], "1 strips or tiles where 2000000000 are needed"),
        (
            &[(256, 4_000_000_000), (259, 8)],
            "strip or tile 1 of 64 bytes cannot hold the 8000000000 bytes declared",
        ),
        (&[(273, 4_000_000_000)], "strip or tile 1 lies beyond the file's end"),
        (&[(277, 99)], "99 samples a pixel; up to 64 are read"),
        (&[(259, 8), (317, 3)], "predictor 3 for uint8 samples"),
        (&[(259, 8)], "deflate data: "),
    ] {
        let message = refusal("a.tif", &with(tags));
        assert!(message.contains(reason), "{message}");
    }
    // Planar tiles, a predictor of floats for bytes, and planes times rows beyond 32 bits.
    for tags in [
        &[(277, 3), (284, 2), (262, 2), (322, 16), (323, 16), (324, 8), (325, 64)][..],
        &[(259, 8), (317, 3), (339, 3)],
        &[(257, u32::MAX), (278, 1), (277, 60), (284, 2)],
    ] {
        refusal("a.tif", &with(tags));
    }
    // Pages in a circle.
    let mut bytes = with(&[]);
    let first = u32::from_le_bytes(bytes[4..8].try_into().unwrap());
    let end = bytes.len() - 4;
    bytes[end..].copy_from_slice(&first.to_le_bytes());
    assert!(refusal("a.tif", &bytes).ends_with("its pages follow each other in a circle"));
}

#[test]
fn strips_shared_by_many_pages_do_not_make_a_bomb() {
    let data = [0; 400];
    let pages: Vec<TiffPage> = (0..50)
        .map(|_| TiffPage {
            tags: [gray_page(20, 20, 8, &[]).tags, vec![(273, 8), (279, 400)]].concat(),
            data: &[],
        })
        .collect();
    let mut bytes = tiff_file(false, &pages);
    // The samples themselves lie at the end, and the pages point to them.
    bytes.extend(data);
    let message = refusal("a.tif", &bytes);
    assert!(message.ends_with("its pages declare more data than the file holds"), "{message}");
}

/// Directories of 4,096 entries, each begun two entries behind the last: 1 MB of them would take gigabytes.
#[test]
fn directories_that_overlap_are_refused() {
    // Of each 8 bytes, 2 are the count of one directory and 4 the place of the directory behind another.
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    let count = 4096u16;
    let ends = 2 + 12 * u32::from(count);
    assert_eq!(ends % 8, 2);
    for i in 0..20_000u32 {
        let here = 8 + 8 * i;
        bytes.extend(count.to_le_bytes());
        bytes.extend((here + 8).saturating_sub(ends - 2).to_le_bytes());
        bytes.extend([0, 0]);
    }
    let message = refusal("a.tif", &bytes);
    assert!(message.ends_with("its pages declare more entries than the file holds"), "{message}");
}

#[test]
fn turned_pages_are_said() {
    let data = [7; 6];
    let mut page = gray_page(3, 2, 8, &data);
    page.tags.push((274, 4));
    let (_, warnings) = read("a.tif", &tiff_file(false, &[page]));
    let turned = "the file says that its pages are turned (orientation 4): taken as stored";
    assert_eq!(warnings, [turned, NO_SPACING]);
}

/// A page of `components` samples a pixel with a description.
fn described(components: u32, data: &[u8], description: &str) -> Vec<u8> {
    let mut page = gray_page(2, 1, 8, data);
    page.tags.retain(|t| t.0 != 277 && t.0 != 262);
    page.tags.extend([(277, components), (262, if components == 3 { 2 } else { 1 }), (270, 0)]);
    let mut bytes = tiff_file(false, &[page]);
    let entry = bytes.windows(4).position(|w| w == [14, 1, 4, 0]).unwrap();
    let at = bytes.len() as u32;
    bytes[entry + 2..entry + 4].copy_from_slice(&2u16.to_le_bytes());
    bytes[entry + 4..entry + 8].copy_from_slice(&(description.len() as u32).to_le_bytes());
    bytes[entry + 8..entry + 12].copy_from_slice(&at.to_le_bytes());
    bytes.extend(description.as_bytes());
    bytes
}

/// The same with its samples at the end, where those of further slices may follow.
fn described_before(data: &[u8], description: &str) -> Vec<u8> {
    let mut bytes = described(1, &data[..2], description);
    let entry = bytes.windows(4).position(|w| w == [17, 1, 4, 0]).unwrap();
    let at = bytes.len() as u32;
    bytes[entry + 8..entry + 12].copy_from_slice(&at.to_le_bytes());
    bytes.extend(data);
    bytes
}

/// A list of as many slices as were declared, made before they were looked for, ended the program.
#[test]
fn absurd_numbers_of_slices_are_refused() {
    let file = |images: &str, data: &[u8]| described_before(data, &format!("ImageJ=1.54\nimages={images}\n"));
    let (whole, _) = read("a.tif", &file("3", &[1, 2, 3, 4, 5, 6]));
    assert_eq!(numbers(&whole), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    for images in ["3", "999999999999", "18446744073709551615"] {
        let message = refusal("a.tif", &file(images, &[1, 2, 3, 4, 5]));
        let reason = format!("the file ends within slice 3 of the {images} its description declares");
        assert!(message.ends_with(&reason), "{message}");
    }
}

/// What a program keeps of ImageJ's description when it cuts a slice out: the bytes behind are no slices.
#[test]
fn a_directory_behind_the_samples_is_no_slice() {
    let (file, warnings) = read("a.tif", &described(1, &[1, 2], "ImageJ=1.54\nimages=3\n"));
    assert_eq!(file.volume.dims(), [2, 1, 1]);
    assert_eq!(warnings, ["the description declares 3 images, but the file holds 1", NO_SPACING]);
}

#[test]
fn ome_units_may_differ_and_colours_share_a_page() {
    let xml = "<OME><Pixels SizeC=\"1\" SizeT=\"1\" SizeZ=\"1\" PhysicalSizeX=\"500\" PhysicalSizeXUnit=\"nm\" \
               PhysicalSizeY=\"0.25\" PhysicalSizeZ=\"0.002\" PhysicalSizeZUnit=\"mm\"/></OME>";
    let file = read_quietly("a.tif", &described(1, &[1, 2], xml));
    assert_eq!(file.volume.affine().unit, Unit::Nanometre);
    for (found, expected) in file.volume.affine().spacing().iter().zip([500.0, 250.0, 2000.0]) {
        assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
    }
    let rgb = xml.replace("SizeC=\"1\"", "SizeC=\"3\"");
    let (file, warnings) = read("a.tif", &described(3, &[9; 6], &rgb));
    assert_eq!(numbers(&file), [9.0, 9.0]);
    assert_eq!(warnings, ["RGB samples: their luminance (Rec. 709) is taken"]);
}

#[test]
fn a_folder_is_a_stack_in_natural_order() {
    let folder = tempfile::tempdir().unwrap();
    let slice = |i: u8| tiff_file(false, &[gray_page(3, 2, 8, &[i; 6])]);
    for i in [1u8, 2, 9, 10, 11] {
        std::fs::write(folder.path().join(format!("slice{i}.tif")), slice(i)).unwrap();
    }
    std::fs::write(folder.path().join("notes.txt"), "no slice").unwrap();
    std::fs::write(folder.path().join(".hidden.tif"), "no slice").unwrap();
    assert_eq!(volume_format_of(folder.path(), &[]), Some(VolumeFormat::Tiff));

    let mut warnings = Warnings::new();
    let file = read_volume(folder.path(), &VolumeOptions::default(), &mut warnings).unwrap();
    check(&file, [3, 2, 5], |_, _, z| [1.0, 2.0, 9.0, 10.0, 11.0][z as usize]);
    assert_eq!(file.format, "folder of TIFF, uncompressed");
    assert_eq!(fact(&file, "data files"), Some("5: slice1.tif to slice11.tif"));
    assert_eq!(file.checksum, checksum(&[1, 2, 9, 10, 11].map(slice).concat()));
    assert_eq!(warnings.iter().map(ToString::to_string).collect::<Vec<_>>(), [NO_SPACING]);

    let refuse = || {
        let error = read_volume(folder.path(), &VolumeOptions::default(), &mut Warnings::new()).unwrap_err();
        error.to_string()
    };
    let odd = folder.path().join("slice3.tif");
    std::fs::write(&odd, tiff_file(false, &[gray_page(2, 3, 8, &[0; 6])])).unwrap();
    assert!(refuse().ends_with("slice3.tif: is 2 x 3 uint8, but slice1.tif is 3 x 2 uint8"), "{}", refuse());
    std::fs::write(&odd, tiff_file(false, &[gray_page(3, 2, 8, &[0; 6]), gray_page(3, 2, 8, &[0; 6])]))
        .unwrap();
    assert!(
        refuse().ends_with("slice3.tif: holds 2 pages; of a folder, each file is one slice"),
        "{}",
        refuse()
    );
    // One page, behind whose samples two more slices follow: none of them may be lost in silence.
    std::fs::write(&odd, described_before(&[1; 6], "ImageJ=1.54\nimages=3\n")).unwrap();
    assert!(
        refuse().ends_with("slice3.tif: holds 3 pages; of a folder, each file is one slice"),
        "{}",
        refuse()
    );
    std::fs::write(&odd, "II*\0").unwrap();
    assert!(refuse().contains("slice3.tif: byte 4:"), "{}", refuse());

    let empty = tempfile::tempdir().unwrap();
    let error = read_volume(empty.path(), &VolumeOptions::default(), &mut Warnings::new()).unwrap_err();
    assert!(error.to_string().ends_with("is a directory without TIFF files"));
    assert_eq!(volume_format_of(empty.path(), &[]), None);
}
