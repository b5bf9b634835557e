use std::collections::HashMap;
use std::io::Read;

use dotwork_drawing::hash::{hash2, unit};
use dotwork_drawing::{Dots, StrokeKind, Strokes};
use flate2::read::ZlibDecoder;

use super::*;
use crate::testing;

fn encode(drawing: &Drawing, options: &PdfOptions<'_>) -> Vec<u8> {
    let mut out = Vec::new();
    write_pdf(&mut out, drawing, options).unwrap();
    out
}

/// A file read back by its table of places.
struct PdfFile {
    /// Dictionary, or whole body, and inflated stream of each object.
    objects: HashMap<usize, (String, Vec<u8>)>,
    trailer: String,
}

impl PdfFile {
    fn new(bytes: &[u8]) -> PdfFile {
        let text = String::from_utf8_lossy(&bytes[bytes.len() - 60..]).into_owned();
        assert!(text.ends_with("\n%%EOF\n"));
        let start: usize = text.split("startxref\n").nth(1).unwrap().lines().next().unwrap().parse().unwrap();
        let table = std::str::from_utf8(&bytes[start..]).unwrap();
        let mut lines = table.split_inclusive('\n');
        assert_eq!(lines.next(), Some("xref\n"));
        let count: usize = lines.next().unwrap().trim().strip_prefix("0 ").unwrap().parse().unwrap();
        assert_eq!(lines.next(), Some("0000000000 65535 f \n"));
        let mut objects = HashMap::new();
        for id in 1..count {
            let line = lines.next().unwrap();
            assert!(line.len() == 20 && line.ends_with(" 00000 n \n"), "{line}");
            let at: usize = line[..10].parse().unwrap();
            let head = format!("{id} 0 obj\n");
            assert!(bytes[at..].starts_with(head.as_bytes()), "object {id}");
            let body = &bytes[at + head.len()..];
            let find = |what: &[u8]| body.windows(what.len()).position(|w| w == what).unwrap();
            let end = find(b"\nendobj\n");
            let (dictionary, data) = if body.starts_with(b"<< /Length ") {
                let from = find(b"\nstream\n") + 8;
                let dictionary = std::str::from_utf8(&body[..from - 8]).unwrap();
                let length: usize = word_after(dictionary, "/Length").parse().unwrap();
                assert!(body[from + length..].starts_with(b"\nendstream\nendobj\n"));
                let mut data = body[from..from + length].to_vec();
                if dictionary.contains("/FlateDecode") {
                    data.clear();
                    ZlibDecoder::new(&body[from..from + length]).read_to_end(&mut data).unwrap();
                }
                (dictionary.to_owned(), data)
            } else {
                (std::str::from_utf8(&body[..end]).unwrap().to_owned(), Vec::new())
            };
            objects.insert(id, (dictionary, data));
        }
        let trailer = lines.collect();
        PdfFile { objects, trailer }
    }

    fn of_type(&self, kind: &str) -> Vec<&(String, Vec<u8>)> {
        let mut found: Vec<_> = self.objects.iter().filter(|(_, o)| o.0.contains(kind)).collect();
        found.sort_by_key(|(id, _)| **id);
        found.into_iter().map(|(_, o)| o).collect()
    }

    fn page(&self) -> &str {
        let pages = self.of_type("/Type /Page ");
        assert_eq!(pages.len(), 1);
        &pages[0].0
    }

    fn content(&self) -> String {
        let ids = self.page().split("/Contents [").nth(1).unwrap().split(']').next().unwrap();
        let mut text = String::new();
        for id in ids.split(" 0 R ").filter(|id| !id.is_empty()) {
            text.push_str(std::str::from_utf8(&self.objects[&id.parse::<usize>().unwrap()].1).unwrap());
            // A reader may put white space between streams.
            text.push('\n');
        }
        text
    }
}

fn word_after<'a>(text: &'a str, key: &str) -> &'a str {
    text.split(key).nth(1).unwrap().split_whitespace().next().unwrap()
}

/// A painted path.
#[derive(Debug)]
struct Painted {
    layer: usize,
    /// Points of each subpath, pixels from the top left.
    parts: Vec<Vec<[f64; 2]>>,
    /// Pixels.
    width: f64,
    opacity: f64,
    color: Vec<f64>,
    round: bool,
    closed: bool,
}

/// What an interpreter of the content paints; and the marks on the way are checked for balance.
fn interpret(content: &str, page: &Page) -> Vec<Painted> {
    #[derive(Clone)]
    struct State {
        scale: f64,
        width: f64,
        opacity: f64,
        color: Vec<f64>,
        round: bool,
    }
    let mut state = State { scale: 1.0, width: 1.0, opacity: 1.0, color: vec![0.0], round: false };
    let points = f64::from(page.width.max(page.height)) / f64::from(page.dpi) * 72.0;
    let user_unit = (points / 14_400.0).ceil();
    let px_per_point = f64::from(page.dpi) / 72.0 * user_unit;
    let (mut stack, mut open, mut layer) = (Vec::new(), 0, 0);
    let (mut operands, mut parts, mut out) = (Vec::<&str>::new(), Vec::<Vec<[f64; 2]>>::new(), Vec::new());
    for word in content.split_whitespace() {
        let number = |i: usize| operands[i].parse::<f64>().unwrap();
        match word {
            "q" => stack.push(state.clone()),
            "Q" => state = stack.pop().expect("as many q as Q"),
            "BDC" => {
                assert_eq!(operands[0], "/OC");
                layer = operands[1].strip_prefix("/L").unwrap().parse().unwrap();
                open += 1;
            }
            "EMC" => open -= 1,
            "cm" if operands[0] == "1" => {}
            "cm" => {
                assert_eq!((number(0), number(1), number(2)), (-number(3), 0.0, 0.0));
                state.scale = number(0);
            }
            "w" => state.width = number(0),
            "J" => state.round = operands[0] == "1",
            "j" => assert_eq!(operands[0], "1"),
            "G" | "RG" => state.color = (0..operands.len()).map(number).collect(),
            "gs" => {
                state.opacity = operands[0].strip_prefix("/A").unwrap().parse::<f64>().unwrap() / 1000.0;
            }
            "m" | "l" => {
                let point = [0, 1].map(|k| number(k) * state.scale * px_per_point);
                if word == "m" {
                    parts.push(Vec::new());
                }
                parts.last_mut().unwrap().push(point);
            }
            "S" | "s" => out.push(Painted {
                layer,
                parts: std::mem::take(&mut parts),
                width: state.width * state.scale * px_per_point,
                opacity: state.opacity,
                color: state.color.clone(),
                round: state.round,
                closed: word == "s",
            }),
            "g" | "rg" | "re" | "f" => {}
            "Do" => {}
            operand => {
                operands.push(operand);
                continue;
            }
        }
        operands.clear();
    }
    assert!(stack.is_empty() && open == 0 && parts.is_empty() && operands.is_empty());
    out
}

#[test]
fn dots_are_discs_of_their_area_in_their_place() {
    for dpi in [1.0, 72.0, 300.0, 1200.0, 20_000.0] {
        let mut drawing = testing::drawing();
        drawing.page.dpi = dpi;
        let file = PdfFile::new(&encode(&drawing, &PdfOptions::default()));
        let painted = interpret(&file.content(), &drawing.page);
        let mut layers = vec![Vec::new(); 2];
        for path in &painted {
            assert!(path.round && !path.closed);
            assert!(path.opacity == 1.0 || path.parts.len() == 1, "partial dots multiply");
            for part in &path.parts {
                assert!(part.len() == 2 && part[0] == part[1]);
                layers[path.layer].push((part[0], path.width, path.opacity, &path.color));
            }
        }
        let full: Vec<&Layer> = drawing.layers.iter().filter(|l| !l.dots.is_empty()).collect();
        for (layer, mut read) in full.into_iter().zip(layers) {
            let dots = &layer.dots;
            let expected: Vec<usize> = (0..dots.len())
                .filter(|&i| {
                    let (x, y, r) = (dots.x[i], dots.y[i], dots.radius[i]);
                    let on = x + r > 0.0 && x - r < 1024.0 && y + r > 0.0 && y - r < 1024.0;
                    on && r > 0.0 && (dots.ink[i] * 255.0).round() > 0.0
                })
                .collect();
            assert!(expected.len() > 10);
            assert_eq!(read.len(), expected.len());
            for i in expected {
                let distance =
                    |p: &[f64; 2]| (p[0] - f64::from(dots.x[i])).hypot(p[1] - f64::from(dots.y[i]));
                let nearest =
                    (0..read.len()).min_by(|&a, &b| distance(&read[a].0).total_cmp(&distance(&read[b].0)));
                let (place, width, opacity, color) = read.swap_remove(nearest.unwrap());
                assert!((place[0] - f64::from(dots.x[i])).abs() < 0.03, "{dpi}: {place:?} {}", dots.x[i]);
                assert!((place[1] - f64::from(dots.y[i])).abs() < 0.03);
                let area = (width / (2.0 * f64::from(dots.radius[i]))).powi(2);
                assert!((area - 1.0).abs() < 0.002, "{dpi}: {} becomes {width}", dots.radius[i]);
                let wanted = crate::opacity::opacity(dots.ink[i], layer.color, drawing.paper);
                // Half a step of 1/255 of strength is much opacity where ink is nearly full.
                let room = 0.001 + 0.5 / 255.0 * 13.0 * f64::from(dots.ink[i]).powi(6) + 0.004;
                assert!((opacity - f64::from(wanted)).abs() < room, "{} as {opacity}", dots.ink[i]);
                let c = layer.color;
                if c.is_grey() {
                    assert_eq!(color, &[f64::from(c.r) / 255.0]);
                } else {
                    for (read, c) in color.iter().zip([c.r, c.g, c.b]) {
                        assert_eq!((read * 255.0).round(), f64::from(c));
                    }
                }
            }
        }
    }
}

#[test]
fn the_page_has_its_size_and_paper() {
    for (width, height, dpi, expected) in [
        (1024, 1024, 300.0, "[0 0 245.76 245.76]\n"),
        (3496, 4961, 600.0, "[0 0 419.52 595.32]\n"),
        // Readers take 14,400 units: here a unit is 164 points.
        (32_768, 16_384, 1.0, "[0 0 14385.95122 7192.97561] /UserUnit 164\n"),
    ] {
        let page = Page { width, height, dpi, margin_px: 0.0 };
        let mut drawing = Drawing::new(page, Color::WHITE);
        let file = PdfFile::new(&encode(&drawing, &PdfOptions::default()));
        assert!(file.page().contains(&format!("/MediaBox {expected}")), "{}", file.page());
        assert!(!file.content().contains("re"), "white paper is none");
        assert!(!file.objects.values().any(|o| o.0.contains("OCProperties")));
        drawing.paper = Color { r: 255, g: 0, b: 51 };
        let content = PdfFile::new(&encode(&drawing, &PdfOptions::default())).content();
        let size = expected[5..].split(']').next().unwrap();
        assert!(content.contains(&format!("1 0 0.2 rg\n0 0 {size} re f\n")), "{content}");
    }
    let page = Page { dpi: f32::NAN, ..Page::default() };
    let error = write_pdf(Vec::new(), &Drawing::new(page, Color::WHITE), &PdfOptions::default()).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
}

#[test]
fn layers_settings_and_title_are_named() {
    let mut drawing = testing::drawing();
    drawing.layers[0].object = r"a (b) \c".into();
    drawing.layers[0].pen_mm = Some(0.25);
    drawing.layers[2].object = String::new();
    let settings = "tone = 0.3\nname = \"<Schädel> & ]]> (1) \\ %\"\n";
    let options = PdfOptions { metadata: Some(settings), title: Some("Schädel (1)") };
    let bytes = encode(&drawing, &options);
    assert_eq!(pdf_metadata(&bytes).as_deref(), Some(settings));
    let file = PdfFile::new(&bytes);
    let groups: Vec<&str> = file.of_type("/Type /OCG ").iter().map(|o| &*o.0).collect();
    assert_eq!(
        groups,
        [
            r"<< /Type /OCG /Name (a \(b\) \\c, #c80011, 0.25 mm) >>",
            "<< /Type /OCG /Name (layer 3, #000000) >>"
        ]
    );
    let info: usize = word_after(&file.trailer, "/Info").parse().unwrap();
    let utf16: String = "Schädel (1)".encode_utf16().map(|u| format!("{u:04X}")).collect();
    let software = crate::SOFTWARE;
    assert_eq!(
        file.objects[&info].0,
        format!("<< /Title <FEFF{utf16}> /Creator ({software}) /Producer ({software}) >>")
    );
    assert_eq!(pdf_metadata(&encode(&drawing, &PdfOptions::default())), None);
    assert_eq!(bytes, encode(&drawing, &options), "the same bytes every time");
}

/// `n` solid dots without neighbours of their own size.
fn many(n: u32) -> Dots {
    let mut dots = testing::dots(n as usize);
    dots.ink.fill(1.0);
    for (i, (x, r)) in dots.x.iter_mut().zip(&mut dots.radius).enumerate() {
        *x = 1024.0 * unit(hash2(i as u32, 77));
        *r = 0.8 + 1.2 * unit(hash2(i as u32, 78));
    }
    dots
}

#[test]
fn files_are_small_and_the_same_at_any_thread_count() {
    let mut drawing = Drawing::new(Page::default(), Color::WHITE);
    drawing.layers.push(Layer { dots: many(60_000), ..Layer::default() });
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| encode(&drawing, &PdfOptions::default()))
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(3));
    // 3 MB for 200,000 dots.
    assert!(one.len() < 60_000 * 15, "{} bytes", one.len());
    let file = PdfFile::new(&one);
    assert!(file.page().split("/Contents").nth(1).unwrap().matches(" R").count() > 2, "several streams");
    let painted = interpret(&file.content(), &drawing.page);
    assert_eq!(painted.iter().map(|p| p.parts.len()).sum::<usize>(), 60_000);
    let changes = painted.windows(2).filter(|w| w[0].width != w[1].width).count();
    assert!(changes < 1100, "{changes} changes of width");
}

#[test]
fn strokes_keep_their_area_and_hang_together() {
    let mut strokes = Strokes::default();
    // A wave that swells, a line of one segment that tapers, one that fades, a ring, one with a hole in it.
    let wave = (0..300).map(|i| [10.0 + i as f32 * 3.0, 100.0 + 40.0 * (i as f32 * 0.05).sin()]);
    strokes.push_line(StrokeKind::Silhouette, 1, 2.0, wave);
    strokes.push_line(StrokeKind::Crease, 2, 1.0, [[10.0, 300.0], [900.0, 300.0]]);
    strokes.push_line(StrokeKind::Suggestive, 3, 3.0, [[10.0, 400.0], [900.0, 420.0]]);
    let ring = (0..=90).map(|i| (i % 90) as f32 * std::f32::consts::TAU / 90.0);
    strokes.push_line(
        StrokeKind::Border,
        4,
        4.0,
        ring.map(|a| [500.0 + 80.0 * a.cos(), 600.0 + 80.0 * a.sin()]),
    );
    let hole = [[10.0, 800.0], [20.0, 800.0], [f32::NAN, 800.0], [40.0, 800.0], [50.0, 800.0], [1e9, 800.0]];
    strokes.push_line(StrokeKind::Annotation, 5, 5.0, hole);
    for i in 0..300 {
        strokes.width[i] = 1.0 + 5.0 * (i as f32 / 299.0);
    }
    strokes.width[301] = 9.0;
    strokes.darkness[302] = 0.0;
    let mut drawing = Drawing::new(Page::default(), Color::WHITE);
    let layer = Layer { strokes: strokes.clone(), ..Layer::default() };
    drawing.layers.push(layer);
    let file = PdfFile::new(&encode(&drawing, &PdfOptions::default()));
    let painted = interpret(&file.content(), &drawing.page);
    let length = |part: &[[f64; 2]]| -> f64 {
        part.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum()
    };
    let rows = [(50.0, 150.0), (299.0, 301.0), (399.0, 421.0), (500.0, 700.0), (799.0, 801.0)];
    for (k, (top, bottom)) in rows.into_iter().enumerate() {
        let runs: Vec<&Painted> =
            painted.iter().filter(|p| (top..bottom).contains(&p.parts[0][0][1])).collect();
        let area: f64 = runs.iter().map(|r| length(&r.parts[0]) * r.width).sum();
        let expected: f64 = strokes
            .points(k)
            .skip(1)
            .map(|i| {
                let d = (strokes.x[i] - strokes.x[i - 1]).hypot(strokes.y[i] - strokes.y[i - 1]);
                f64::from(d * (strokes.width[i] + strokes.width[i - 1]) / 2.0)
            })
            .filter(|a| (0.0..1e6).contains(a))
            .sum();
        let round_off = if k == 3 { 1.0 / 90.0 } else { 0.0 };
        assert!((area / expected - 1.0 + round_off).abs() < 0.003, "stroke {k}: {area} for {expected}");
        match k {
            0..=2 => {
                assert!(runs.len() > 10 && runs.len() < 80, "stroke {k}: {} runs", runs.len());
                for pair in runs.windows(2) {
                    assert_eq!(pair[0].parts[0].last(), pair[1].parts[0].first());
                }
                assert!(runs.iter().all(|r| r.round == (r.opacity == 1.0)));
            }
            3 => assert!(runs.len() == 1 && runs[0].closed && runs[0].parts[0].len() == 90),
            _ => assert_eq!(runs.len(), 2),
        }
        if k == 2 {
            // The mean of the light that is left, decoded from what viewers blend, is a half.
            let light: f64 = runs
                .iter()
                .map(|r| {
                    let s = 1.0 - r.opacity;
                    let s = if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) };
                    s * length(&r.parts[0])
                })
                .sum::<f64>()
                / 890.2;
            assert!((light - 0.5).abs() < 0.01, "{light}");
        }
    }
}

#[test]
fn pictures_are_images_with_their_mask() {
    let samples = vec![
        [0.0, 0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.5],
        [1.0, 1.0, 1.0, 1.0],
        [0.0, 0.0, 1.0, 1.0],
    ];
    let image = Image { width: 3, height: 2, place: [100.0, 200.0, 400.0, 400.0], samples };
    let mut drawing = Drawing::new(Page::default(), Color::WHITE);
    let layer = |image: Image| Layer { image: Some(image), ..Layer::default() };
    drawing.layers.push(layer(image.clone()));
    drawing.layers.push(layer(Image { samples: vec![[0.2, 0.2, 0.2, 1.0]; 6], ..image.clone() }));
    drawing.layers.push(layer(Image { width: 4, ..image.clone() }));
    drawing.layers.push(layer(Image { place: [0.0, 0.0, f32::INFINITY, 1.0], ..image }));
    let file = PdfFile::new(&encode(&drawing, &PdfOptions::default()));
    let images = file.of_type("/Subtype /Image");
    assert_eq!(images.len(), 3, "mask, colours, grey");
    let unfiltered = |object: &(String, Vec<u8>), row: usize| {
        assert_eq!(object.1.len(), 2 * (row + 1));
        let mut rows = vec![0u8; row];
        let mut out = Vec::new();
        for line in object.1.chunks(row + 1) {
            assert_eq!(line[0], 2);
            rows.iter_mut().zip(&line[1..]).for_each(|(a, b)| *a = a.wrapping_add(*b));
            out.extend_from_slice(&rows);
        }
        out
    };
    // Half of the light is 188 of 255 in sRGB: 67 less.
    assert_eq!(unfiltered(images[0], 3), [255, 255, 0, 67, 255, 255]);
    let colors = unfiltered(images[1], 9);
    assert_eq!(colors[..9], [0, 0, 0, 255, 0, 0, 0, 0, 0]);
    assert_eq!(colors[9..12], [0, 0, 0]);
    assert_eq!(colors[12..], [255, 255, 255, 0, 0, 255]);
    assert!(images[1].0.contains("/ColorSpace /DeviceRGB") && images[1].0.contains("/SMask"));
    assert!(images[2].0.contains("/ColorSpace /DeviceGray") && !images[2].0.contains("/SMask"));
    // Units of a micrometre: 300 px are 25,400.
    assert!(file.content().contains("q 25400 0 0 -16933.33 8466.67 33866.67 cm /I0 Do Q\n"));
}

#[test]
fn a_stroke_of_one_point_is_a_disc() {
    let mut strokes = Strokes::default();
    strokes.push_line(StrokeKind::Annotation, 0, 5.0, [[30.0, 40.0]]);
    // A point between two that are not finite is one too.
    strokes.push_line(StrokeKind::Annotation, 1, 4.0, [[f32::NAN; 2], [60.0, 70.0], [f32::NAN; 2]]);
    let mut drawing = Drawing::new(Page::default(), Color::WHITE);
    drawing.layers.push(Layer { strokes, ..Layer::default() });
    let content = PdfFile::new(&encode(&drawing, &PdfOptions::default())).content();
    // Units of a micrometre: a pixel at 300 dpi has 84.667.
    for point in ["2540 3387", "5080 5927"] {
        assert!(content.contains(&format!("{point} m\n{point} l\nS\n")), "{point}: {content}");
    }
}

#[test]
fn hostile_drawings_are_files() {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE, -1.0, 0.0];
    let mut dots = testing::dots(7 * 7 * 7);
    let mut strokes = Strokes::default();
    for i in 0..dots.len() {
        (dots.x[i], dots.radius[i], dots.ink[i]) = (bad[i % 7], bad[i / 7 % 7], bad[i / 49]);
        strokes.push_line(
            StrokeKind::Crease,
            0,
            bad[i % 7],
            [[bad[i / 7 % 7], 5.0], [9.0, bad[i / 49]], [9.0, 9.0]],
        );
        strokes.darkness[3 * i + 1] = bad[i / 7 % 7];
    }
    strokes.push_line(StrokeKind::Crease, 0, 1.0, []);
    strokes.push_line(StrokeKind::Crease, 0, 1.0, [[1.0, 1.0]]);
    let mut drawing = Drawing::new(Page::default(), Color::WHITE);
    let object = "\0\n()\\<>%/[]{}\u{ffff}".to_owned();
    drawing.layers.push(Layer { object: object.clone(), dots, strokes, ..Layer::default() });
    let options = PdfOptions { metadata: Some(&object), title: Some(&object) };
    let file = PdfFile::new(&encode(&drawing, &options));
    let painted = interpret(&file.content(), &drawing.page);
    assert!(painted.iter().all(|p| p.width > 0.0 && p.width.is_finite() && p.opacity > 0.0));
    // The numbers stay in the range that readers have.
    let numbers = file.content();
    assert!(numbers.split_whitespace().filter_map(|w| w.parse::<f64>().ok()).all(|v| v.abs() < 2e9));
}

#[test]
fn a_writer_that_fails_gives_its_error() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let error = write_pdf(Full, &testing::drawing(), &PdfOptions::default()).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
}
