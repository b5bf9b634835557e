use dotwork_drawing::hash::hash2;
use dotwork_drawing::{Color, Drawing, Page, Warnings};

use super::*;
use crate::png::{Pixels, RasterView, write_png, write_png_bilevel};
use crate::tiff::{write_tiff, write_tiff_bilevel};
use crate::{PdfOptions, SvgOptions, bilevel, testing, write_pdf, write_svg};

const SETTINGS: &str = "dotwork = \"0.1.0\"\nname = \"<Schädel> & 'Söhne'\"\n[camera]\nazimuth = 20.0\n";
const LATIN: &str = "tone = 0.3\n";

/// One plate of each kind: its kind, its bytes, its settings.
fn plates() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let mut drawing = testing::drawing();
    drawing.layers[0].dots = testing::dots(40);
    let mut plates = Vec::new();
    for settings in [SETTINGS, LATIN] {
        let mut file = Vec::new();
        let options = SvgOptions { metadata: Some(settings), ..SvgOptions::default() };
        write_svg(&mut file, &drawing, &options).unwrap();
        plates.push(("SVG", file, settings));
        let mut file = Vec::new();
        let options = PdfOptions { metadata: Some(settings), ..PdfOptions::default() };
        write_pdf(&mut file, &drawing, &options).unwrap();
        plates.push(("PDF", file, settings));
        let text = [("Software", "dotwork"), (SETTINGS_KEYWORD, settings)];
        let raster = RasterView { width: 2, height: 2, pixels: Pixels::Grey(&[1, 2, 3, 4]) };
        let mut file = Vec::new();
        write_png(&mut file, &raster, 2835, &text).unwrap();
        plates.push(("PNG", file, settings));
        let small = Drawing::new(Page::pixels(9, 5).unwrap(), Color::WHITE);
        let plate = bilevel(&small, &mut Warnings::new());
        let mut file = Vec::new();
        write_png_bilevel(&mut file, &plate, 2835, &text).unwrap();
        plates.push(("PNG", file, settings));
        let mut file = Vec::new();
        write_tiff(&mut file, &raster, 300.0, Some(settings)).unwrap();
        plates.push(("TIFF", file, settings));
        let mut file = Vec::new();
        write_tiff_bilevel(&mut file, &plate, 300.0, Some(settings)).unwrap();
        plates.push(("TIFF", file, settings));
    }
    plates
}

#[test]
fn every_plate_tells_its_kind_and_gives_its_settings_back() {
    let plates = plates();
    assert_eq!(plates.len(), 12);
    for (kind, bytes, settings) in plates {
        assert_eq!(is_plate(&bytes), Some(kind));
        assert_eq!(embedded_settings(&bytes).as_deref(), Some(settings), "{kind}");
    }
}

#[test]
fn other_files_are_no_plates() {
    for bytes in [
        &b""[..],
        b"ply\nformat ascii 1.0\n",
        b"<",
        b"<!--",
        b"<?xml version=\"1.0\"?><html><svg/></html>",
        b"<svgs/>",
        b"solid II*\0",
        b"\x89PNG",
        b"frame,id,x_px\n",
    ] {
        assert_eq!(is_plate(bytes), None, "{bytes:?}");
        assert_eq!(embedded_settings(bytes), None);
    }
    let svg = b"\xef\xbb\xbf <?xml version=\"1.0\"?>\n<!-- <a> -->\n<!DOCTYPE svg PUBLIC \"x\" \"y\">\n<svg>";
    assert_eq!(is_plate(svg), Some("SVG"));
    assert_eq!(embedded_settings(svg), None);
    // Entities of its own, as Adobe's programs write them.
    let svg =
        b"<!DOCTYPE svg PUBLIC \"x\" \"y\" [\n<!ENTITY ns_svg \"http://www.w3.org/2000/svg\">\n]>\n<svg>";
    assert_eq!(is_plate(svg), Some("SVG"));
    assert_eq!(is_plate(b"<!DOCTYPE svg [<!ENTITY a \"b\"><svg>"), None);
}

#[test]
fn mutated_plates_never_panic() {
    let mut random = 0;
    let mut next = |below: usize| {
        random += 1;
        hash2(random, 2024) as usize % below.max(1)
    };
    let (mut kept, mut lost) = (0, 0);
    for (kind, bytes, settings) in plates() {
        for round in 0..400 {
            let mut mutant = bytes.clone();
            // Mostly where the structure and the text are.
            let reach = if round % 2 == 0 { mutant.len() } else { mutant.len().min(900) };
            for _ in 0..=next(4) {
                let at = next(reach.min(mutant.len()));
                match next(6) {
                    0 => mutant.truncate(at.max(12)),
                    1 => mutant[at] ^= 1 << next(8),
                    2 => mutant[at] = [0, 0xff, 0x7f, 0x80, b'<', b'>', b'&', b';'][next(8)],
                    3 => mutant
                        .splice(at..at, bytes[at.min(bytes.len() - 1)..].iter().copied().take(8))
                        .for_each(drop),
                    4 => {
                        // A size made absurd.
                        let end = (at + 4).min(mutant.len());
                        mutant[at..end].fill(0xff);
                    }
                    _ => drop(mutant.drain(at..(at + next(9)).min(mutant.len()))),
                }
            }
            match embedded_settings(&mutant) {
                Some(text) if text == settings => kept += 1,
                _ => lost += 1,
            }
        }
        for end in 0..bytes.len().min(3000) {
            let read = embedded_settings(&bytes[..end]);
            assert!(read.is_none_or(|text| text == settings), "{kind} cut at {end}");
        }
    }
    assert!(kept > 500 && lost > 500, "{kept} {lost}");
}
