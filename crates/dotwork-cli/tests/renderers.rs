//! Vectors drawn by programs that are not ours agree with our pixels.

#![allow(clippy::print_stdout, reason = "the figures are for reading: run with --nocapture")]

mod common;

use std::process::Command;

use common::Place;

/// A grey picture and what each of its shades counts as ink.
struct Ink {
    width: usize,
    height: usize,
    shades: Vec<u8>,
    table: [f64; 256],
}

/// Reads a PNG or a PGM; of a grey or colour PNG the first channel.
fn ink(bytes: &[u8], table: [f64; 256]) -> Ink {
    if bytes.starts_with(b"P5") {
        let parts = bytes.splitn(5, |b| b.is_ascii_whitespace()).collect::<Vec<_>>();
        let [width, height] =
            [1, 2].map(|k| std::str::from_utf8(parts[k]).unwrap().parse::<usize>().unwrap());
        return Ink { width, height, shades: parts[4].to_vec(), table };
    }
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let shades = pixels.chunks_exact(info.color_type.samples()).map(|p| p[0]).collect();
    Ink { width: info.width as usize, height: info.height as usize, shades, table }
}

/// Ours: the shades are encoded light.
fn light() -> [f64; 256] {
    std::array::from_fn(|c| 1.0 - f64::from(dotwork::drawing::color::srgb_to_linear(c as u8)))
}

/// Theirs: a pixel is ink if more than half of it is covered, which is when it is darker than `dark`.
///
/// Viewers smooth edges in their own ways, most of them without regard to gamma. At many times the resolution their
/// pixels are nearly all black or white, and which they are is what the file says.
fn covered(dark: f64) -> [f64; 256] {
    std::array::from_fn(|c| f64::from(u8::from(1.0 - c as f64 / 255.0 > dark)))
}

impl Ink {
    fn block(&self, x: usize, y: usize, side: usize) -> f64 {
        let rows = y * side..(y + 1) * side;
        let row = |r: usize| &self.shades[r * self.width + x * side..][..side];
        let sum: f64 = rows.flat_map(row).map(|&c| self.table[usize::from(c)]).sum();
        sum / (side * side) as f64
    }
}

/// A program that draws plates.
struct Viewer {
    plate: &'static str,
    program: &'static str,
    args: &'static [&'static str],
    drawn: &'static str,
    /// Its pixels for one of ours.
    times: usize,
    /// How dark it makes a pixel that is half covered.
    half: f64,
}

impl Viewer {
    /// Draws the teapot as pixels and as a plate, the latter by the program, and compares blocks of 2.7 mm.
    fn agrees(&self) {
        const SIDE: usize = 32;
        let &Viewer { plate, program, args, drawn, times, half } = self;
        let place = Place::new();
        for options in [
            "--pen 0.3mm",
            "--style hard --set dot_size=0.3mm --scale-bar auto --ortho",
            "--style soft --pen 0.14mm",
            "--style engraving --set dot_size=0.1mm",
        ] {
            let line = format!("demo:teapot --page 43.35x32.51mm --dpi 300 {options}");
            place.draw(&format!("{line} -o ours.png"));
            place.draw(&format!("{line} -o {plate}"));
            let done = Command::new(program).args(args).current_dir(place.path("")).output().unwrap();
            assert!(done.status.success(), "{program}: {}", String::from_utf8_lossy(&done.stderr));
            let (ours, theirs) =
                (ink(&place.read("ours.png"), light()), ink(&place.read(drawn), covered(half)));
            assert_eq!((ours.width, ours.height), (512, 384));
            let width = times * ours.width;
            assert!(theirs.width.abs_diff(width) <= times, "{} {}", theirs.width, theirs.height);
            let (mut worst, mut sum, mut darkest) = (0.0f64, 0.0, 0.0f64);
            let (columns, rows) = (ours.width / SIDE, ours.height / SIDE - 1);
            for y in 0..rows {
                for x in 0..columns {
                    let (a, b) = (ours.block(x, y, SIDE), theirs.block(x, y, times * SIDE));
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
}

#[test]
#[cfg_attr(no_rsvg, ignore = "rsvg-convert is not installed")]
fn librsvg_draws_what_we_draw() {
    Viewer {
        plate: "plate.svg",
        program: "rsvg-convert",
        args: &["-z", "8", "-d", "300", "-p", "300", "-b", "white", "plate.svg", "-o", "theirs.png"],
        drawn: "theirs.png",
        times: 8,
        half: 0.5,
    }
    .agrees();
}

#[test]
#[cfg_attr(no_poppler, ignore = "pdftoppm is not installed")]
fn poppler_draws_what_we_draw() {
    Viewer {
        plate: "plate.pdf",
        program: "pdftoppm",
        args: &["-r", "4800", "-gray", "-singlefile", "plate.pdf", "theirs"],
        drawn: "theirs.pgm",
        // It turns circles into polygons, fewer-sided the fewer pixels they have: at eight times the resolution dots
        // of 0.14 mm are 13 pixels wide and blocks differ by up to 0.023 for that alone, at sixteen by 0.010.
        times: 16,
        // It paints an edge pixel with its coverage to the power of 1.5.
        half: 0.353_553,
    }
    .agrees();
}
