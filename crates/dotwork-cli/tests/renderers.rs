//! Vectors drawn by programs that are not ours agree with our pixels.

#![allow(clippy::print_stdout, reason = "the figures are for reading: run with --nocapture")]

mod common;

use std::process::Command;

use common::Place;

/// The ink of a picture, row by row, as whatever its blocks are averaged from.
struct Ink {
    width: usize,
    height: usize,
    values: Vec<f64>,
}

/// A grey PNG or PGM; `linear` decodes shades to light, otherwise a pixel is ink if it is darker than half way.
///
/// Viewers smooth edges in their own ways, most of them without regard to gamma. At eight times the resolution their
/// pixels are nearly all black or white, and which they are is what the file says.
fn ink(bytes: &[u8], linear: bool) -> Ink {
    let (width, height, samples) = if bytes.starts_with(b"P5") {
        let mut parts = bytes.splitn(4, |b| b.is_ascii_whitespace());
        let mut number = || std::str::from_utf8(parts.nth(1).unwrap()).unwrap().parse::<usize>().unwrap();
        let width = number();
        let rest = bytes.splitn(5, |b| b.is_ascii_whitespace()).collect::<Vec<_>>();
        let height: usize = std::str::from_utf8(rest[2]).unwrap().parse().unwrap();
        (width, height, rest[4].to_vec())
    } else {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let channels = info.color_type.samples();
        let samples = pixels.chunks_exact(channels).map(|p| p[0]).collect();
        (info.width as usize, info.height as usize, samples)
    };
    let values = samples.iter().map(|&c| match linear {
        true => 1.0 - f64::from(dotwork::drawing::color::srgb_to_linear(c)),
        false => f64::from(u8::from(c < 128)),
    });
    Ink { width, height, values: values.collect() }
}

impl Ink {
    fn block(&self, x: usize, y: usize, side: usize) -> f64 {
        let rows = y * side..(y + 1) * side;
        let sum: f64 =
            rows.map(|r| self.values[r * self.width + x * side..][..side].iter().sum::<f64>()).sum();
        sum / (side * side) as f64
    }
}

/// Draws the teapot as pixels and as `out`, the latter by `program`, and compares blocks of 2.7 mm.
fn agrees(out: &str, program: &str, args: &[&str], drawn: &str) {
    const TIMES: usize = 8;
    const SIDE: usize = 32;
    let place = Place::new();
    for options in ["--pen 0.3mm", "--style hard --set dot_size=0.3mm --scale-bar auto --ortho"] {
        let line = format!("demo:teapot --page 43.35x32.51mm --dpi 300 {options}");
        place.draw(&format!("{line} -o ours.png"));
        place.draw(&format!("{line} -o {out}"));
        let done = Command::new(program).args(args).current_dir(place.path("")).output().unwrap();
        assert!(done.status.success(), "{program}: {}", String::from_utf8_lossy(&done.stderr));
        let (ours, theirs) = (ink(&place.read("ours.png"), true), ink(&place.read(drawn), false));
        assert_eq!((ours.width, ours.height), (512, 384));
        assert!(theirs.width.abs_diff(TIMES * ours.width) <= TIMES, "{} {}", theirs.width, theirs.height);
        let (mut worst, mut sum, mut darkest) = (0.0f64, 0.0, 0.0f64);
        let (columns, rows) = (ours.width / SIDE, ours.height / SIDE - 1);
        for y in 0..rows {
            for x in 0..columns {
                let (a, b) = (ours.block(x, y, SIDE), theirs.block(x, y, TIMES * SIDE));
                worst = worst.max((a - b).abs());
                darkest = darkest.max(a);
                sum += b - a;
            }
        }
        let mean = sum / (columns * rows) as f64;
        println!("{program} {options}: worst block {worst:.4}, mean {mean:+.4}, darkest {darkest:.3}");
        assert!(darkest > 0.3, "there is something to compare: {darkest}");
        assert!(worst <= 0.02 && mean.abs() <= 0.004, "{options}: worst {worst}, mean {mean}");
    }
}

#[test]
#[cfg_attr(no_rsvg, ignore = "rsvg-convert is not installed")]
fn librsvg_draws_what_we_draw() {
    agrees(
        "plate.svg",
        "rsvg-convert",
        &["-z", "8", "-d", "300", "-p", "300", "-b", "white", "plate.svg", "-o", "theirs.png"],
        "theirs.png",
    );
}

#[test]
#[cfg_attr(no_poppler, ignore = "pdftoppm is not installed")]
fn poppler_draws_what_we_draw() {
    agrees(
        "plate.pdf",
        "pdftoppm",
        &["-r", "2400", "-gray", "-singlefile", "plate.pdf", "theirs"],
        "theirs.pgm",
    );
}
