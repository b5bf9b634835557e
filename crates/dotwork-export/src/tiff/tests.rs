use std::io::Cursor;

use dotwork_drawing::hash::{hash2, unit};
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

use super::*;
use crate::png::Pixels;

fn noise(len: usize, stream: u32) -> Vec<u8> {
    (0..len as u32).map(|i| (hash2(i, stream) >> 24) as u8).collect()
}

fn decode(file: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut decoder = Decoder::new(Cursor::new(file)).unwrap();
    let (width, height) = decoder.dimensions().unwrap();
    match decoder.read_image().unwrap() {
        DecodingResult::U8(samples) => (width, height, samples),
        _ => panic!("not bytes"),
    }
}

#[test]
fn rasters_decode_to_the_same_bytes() {
    // The last has several strips.
    for (width, height) in [(1, 1), (7, 5), (300, 2), (2, 300), (700, 900)] {
        for channels in [1, 3] {
            let bytes = noise(width * height * channels, 1);
            let pixels = if channels == 1 { Pixels::Grey(&bytes) } else { Pixels::Rgb(&bytes) };
            let raster = RasterView { width: width as u32, height: height as u32, pixels };
            let mut file = Vec::new();
            write_tiff(&mut file, &raster, 300.0, None).unwrap();
            assert_eq!(decode(&file), (width as u32, height as u32, bytes.clone()));
            assert_eq!(tiff_metadata(&file), None);
        }
    }
}

/// A plate of one pixel for each bit that `black` gives.
fn plate(width: u32, height: u32, black: impl Fn(u32, u32) -> bool) -> Bilevel {
    let row_bytes = width.div_ceil(8);
    let byte =
        |y: u32, b: u32| (0..8).fold(0, |v, k| v << 1 | u8::from(b * 8 + k < width && black(b * 8 + k, y)));
    let rows =
        (0..height).flat_map(|y| (0..row_bytes).map(move |b| (y, b))).map(|(y, b)| byte(y, b)).collect();
    Bilevel { width, height, rows }
}

#[test]
fn plates_decode_to_the_same_bits() {
    let random = |x: u32, y: u32| unit(hash2(x, y));
    let mut checked = 0;
    for width in [1, 2, 7, 8, 9, 63, 64, 65, 100, 2559, 2560, 2561, 2623, 2624, 5120, 5121, 6000] {
        let patterns: [&dyn Fn(u32, u32) -> bool; 9] = [
            &|_, _| false,
            &|_, _| true,
            &|x, y| random(x, y) < 0.5,
            &|x, y| random(x, y) < 0.01,
            &|x, y| random(x / 9, y / 4) < 0.3,
            // Slow slopes take vertical codes, steep ones pass and horizontal ones.
            &|x, y| (x + y) % 40 < 12,
            &|x, y| (x + 3 * y) % 64 < 7 || (x + 5999 - (3 * y) % 5999) % 97 < 3,
            &|x, y| x < 2600 && y % 2 == 0,
            &|x, y| x == width - 1 || (x == 0 && y % 3 == 0),
        ];
        for pattern in patterns {
            let plate = plate(width, 40, pattern);
            let mut file = Vec::new();
            write_tiff_bilevel(&mut file, &plate, 1200.0, None).unwrap();
            let (w, h, bits) = decode(&file);
            assert_eq!((w, h), (width, 40));
            // The decoder gives 1 for white.
            let read: Vec<u8> = bits.iter().map(|b| !b).collect();
            let row_bytes = plate.row_bytes();
            let unused = 0xff << (row_bytes as u32 * 8 - width) & 0xff;
            for (a, b) in read.chunks(row_bytes).zip(plate.rows.chunks(row_bytes)) {
                assert_eq!(a[..row_bytes - 1], b[..row_bytes - 1], "width {width}");
                assert_eq!(a[row_bytes - 1] & unused as u8, b[row_bytes - 1], "width {width}");
            }
            checked += 1;
        }
    }
    assert_eq!(checked, 17 * 9);
}

#[test]
fn plates_of_several_strips() {
    let plate = plate(5000, 1200, |x, y| unit(hash2(x / 11, y / 11)) < 0.2);
    let mut file = Vec::new();
    write_tiff_bilevel(&mut file, &plate, 1200.0, Some("tone = 0.3")).unwrap();
    let mut decoder = Decoder::new(Cursor::new(&file)).unwrap();
    assert!(decoder.get_tag_u32_vec(Tag::StripOffsets).unwrap().len() > 2);
    let (_, _, bits) = decode(&file);
    assert!(bits.iter().map(|b| !b).eq(plate.rows.iter().copied()));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let mut again = Vec::new();
    pool.install(|| write_tiff_bilevel(&mut again, &plate, 1200.0, Some("tone = 0.3"))).unwrap();
    assert_eq!(file, again);
}

#[test]
fn files_say_how_large_they_are_and_what_made_them() {
    let settings = "tone = 0.3\nname = \"Möbius 点\"\n";
    let plate = plate(9, 3, |x, _| x == 3);
    for (dpi, ratio) in [(600.0, [600, 1]), (254.5, [2_545_000, 10_000]), (f32::NAN, [0, 1])] {
        let mut one = Vec::new();
        write_tiff_bilevel(&mut one, &plate, dpi, Some(settings)).unwrap();
        let mut other = Vec::new();
        let raster = RasterView { width: 1, height: 1, pixels: Pixels::Grey(&[7]) };
        write_tiff(&mut other, &raster, dpi, Some(settings)).unwrap();
        for (file, compression, photometric) in [(&one, 4, 0), (&other, 8, 1)] {
            assert_eq!(tiff_metadata(file).as_deref(), Some(settings));
            let mut decoder = Decoder::new(Cursor::new(file)).unwrap();
            for tag in [Tag::XResolution, Tag::YResolution] {
                assert_eq!(decoder.get_tag_u32_vec(tag).unwrap(), ratio);
            }
            assert_eq!(decoder.get_tag_u32(Tag::ResolutionUnit).unwrap(), 2);
            assert_eq!(decoder.get_tag_u32(Tag::Compression).unwrap(), compression);
            assert_eq!(decoder.get_tag_u32(Tag::PhotometricInterpretation).unwrap(), photometric);
            assert_eq!(decoder.get_tag_ascii_string(Tag::Software).unwrap(), crate::SOFTWARE);
        }
    }
}

#[test]
fn what_is_no_picture_is_refused() {
    let refused =
        |result: io::Result<()>| assert_eq!(result.unwrap_err().kind(), io::ErrorKind::InvalidInput);
    let raster = RasterView { width: 2, height: 1, pixels: Pixels::Grey(&[7]) };
    refused(write_tiff(Vec::new(), &raster, 300.0, None));
    refused(write_tiff(Vec::new(), &RasterView { width: 0, ..raster }, 300.0, None));
    refused(write_tiff(Vec::new(), &RasterView { width: 1, ..raster }, 300.0, Some("a\0b")));
    let plate = Bilevel { width: 9, height: 1, rows: vec![0] };
    refused(write_tiff_bilevel(Vec::new(), &plate, 300.0, None));
    refused(write_tiff_bilevel(Vec::new(), &Bilevel { width: 0, rows: Vec::new(), ..plate }, 300.0, None));
}

#[test]
fn files_of_either_byte_order_are_read() {
    let fields: [(u16, u16, u32, u32); 3] = [(305, 2, 8, 60), (270, 2, 3, 0x6162_0000), (256, 3, 1, 1 << 16)];
    let mut file = b"MM\0*\0\0\0\x08\0\x03".to_vec();
    for (tag, kind, count, value) in fields {
        file.extend(tag.to_be_bytes());
        file.extend(kind.to_be_bytes());
        file.extend(count.to_be_bytes());
        file.extend(value.to_be_bytes());
    }
    file.resize(60, 0);
    file.extend(b"dotwork\0");
    assert_eq!(tiff_metadata(&file).as_deref(), Some("ab"));
    file[60] = b'D';
    assert_eq!(tiff_metadata(&file), None, "not ours");
}
