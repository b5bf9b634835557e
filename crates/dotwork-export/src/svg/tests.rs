use super::*;
use crate::testing::{dots, drawing};
use dotwork_drawing::hash::{hash2, unit};
use dotwork_drawing::{Dots, Image, Page, StrokeKind};
use roxmltree::{Document, Node};

pub(crate) fn svg(drawing: &Drawing, options: &SvgOptions<'_>) -> String {
    let mut out = Vec::new();
    write_svg(&mut out, drawing, options).unwrap();
    let mut again = Vec::new();
    write_svg(&mut again, drawing, options).unwrap();
    assert!(out == again, "the same bytes every time");
    String::from_utf8(out).unwrap()
}

const INKSCAPE: &str = "http://www.inkscape.org/namespaces/inkscape";

/// A dot as a file says it: millimetres, opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Found {
    x: f64,
    y: f64,
    diameter: f64,
    opacity: f64,
    tick: bool,
}

fn layers<'a>(document: &'a Document<'_>) -> Vec<Node<'a, 'a>> {
    let layer = |n: &Node<'_, '_>| n.attribute((INKSCAPE, "groupmode")) == Some("layer");
    document.descendants().filter(layer).collect()
}

fn number(node: Node<'_, '_>, name: &str, default: f64) -> f64 {
    node.attribute(name).map_or(default, |v| v.parse().unwrap())
}

fn found_dots(layer: Node<'_, '_>) -> Vec<Found> {
    let mut found = Vec::new();
    for node in layer.descendants() {
        if node.has_tag_name(("http://www.w3.org/2000/svg", "circle")) {
            let value = |name| number(node, name, f64::NAN);
            let opacity = number(node, "opacity", 1.0);
            let diameter = 2.0 * value("r");
            found.push(Found { x: value("cx"), y: value("cy"), diameter, opacity, tick: false });
        }
        if node.attribute("class") != Some("dots")
            || !node.has_tag_name(("http://www.w3.org/2000/svg", "path"))
        {
            continue;
        }
        let diameter = number(node, "stroke-width", f64::NAN);
        let opacity = number(node, "stroke-opacity", 1.0);
        for dot in node.attribute("d").unwrap().split('M').skip(1) {
            let (place, length) = dot.trim().split_once('h').unwrap();
            let (x, y) = place.split_once(' ').unwrap();
            let tick = match length {
                "0" => false,
                "0.001" => true,
                other => panic!("{other}"),
            };
            found.push(Found { x: x.parse().unwrap(), y: y.parse().unwrap(), diameter, opacity, tick });
        }
    }
    found
}

/// A page of 210 × 297 mm at 300 dpi with `n` dots of diameters 0.1 to 0.3 mm.
fn plate(n: usize) -> Drawing {
    let mut drawing = Drawing::new(Page::millimetres(210.0, 297.0, 300.0).unwrap(), Color::WHITE);
    let px = 1.0 / drawing.page.mm_per_px();
    let mut all = dots(n);
    for i in 0..n {
        let random = |stream| unit(hash2(i as u32, stream));
        all.x[i] = (1.0 + 208.0 * random(1)) * px;
        all.y[i] = (1.0 + 295.0 * random(2)) * px;
        all.radius[i] = (0.05 + 0.1 * random(3)) * px;
    }
    all.ink.fill(1.0);
    drawing.layers.push(Layer { object: "bunny".into(), dots: all, ..Layer::default() });
    drawing
}

#[test]
fn page_paper_and_layers() {
    let paper = Color { r: 250, g: 240, b: 230 };
    let red = Color { r: 200, g: 16, b: 0 };
    let mut drawing = plate(3);
    drawing.paper = paper;
    drawing.layers.push(Layer { object: "empty".into(), ..Layer::default() });
    let mut second = drawing.layers[0].clone();
    (second.color, second.pen_mm, second.object) = (red, Some(0.25), "Schädel \"<&\u{1}".into());
    drawing.layers.push(second);
    let options = SvgOptions { title: Some("a < b"), metadata: Some("x = 1"), ..SvgOptions::default() };
    let text = svg(&drawing, &options);
    let document = Document::parse(&text).unwrap();
    let root = document.root_element();
    let mm = |attribute: &str| {
        root.attribute(attribute).unwrap().strip_suffix("mm").unwrap().parse::<f64>().unwrap()
    };
    assert!((mm("width") - 210.0).abs() < 0.05 && (mm("height") - 297.0).abs() < 0.05);
    assert_eq!(root.attribute("viewBox"), Some(format!("0 0 {} {}", mm("width"), mm("height")).as_str()));
    let rect = document.descendants().find(|n| n.attribute("id") == Some("paper")).unwrap();
    assert_eq!(rect.attribute("fill"), Some("#faf0e6"));
    assert_eq!(number(rect, "width", 0.0), mm("width"));
    let title = root.first_element_child().unwrap();
    assert_eq!((title.tag_name().name(), title.text()), ("title", Some("a < b")));
    let layers = layers(&document);
    let labels: Vec<_> = layers.iter().map(|l| l.attribute((INKSCAPE, "label")).unwrap()).collect();
    assert_eq!(labels, ["bunny #000000", "Schädel \"<&\u{fffd} #c81000 0.25 mm"]);
    assert_eq!(layers.iter().map(|l| l.attribute("id").unwrap()).collect::<Vec<_>>(), ["layer1", "layer2"]);
    assert_eq!(layers[1].attribute("stroke"), Some("#c81000"));

    let text = svg(&drawing, &SvgOptions::for_plotter());
    let document = Document::parse(&text).unwrap();
    assert!(document.descendants().all(|n| !n.has_tag_name("rect")));
    let labels: Vec<_> =
        self::layers(&document).iter().map(|l| l.attribute((INKSCAPE, "label")).unwrap()).collect();
    assert_eq!(labels, ["1 #000000 bunny", "2 0.25 mm #c81000 Schädel \"<&\u{fffd}"]);
}

#[test]
fn dots_come_back_in_place_and_size() {
    let drawing = plate(3000);
    let mm_per_px = 25.4 / f64::from(drawing.page.dpi);
    let from = &drawing.layers[0].dots;
    for touch in [Touch::Dot, Touch::Tick, Touch::Circle] {
        let text = svg(&drawing, &SvgOptions { touch, ..SvgOptions::default() });
        let document = Document::parse(&text).unwrap();
        let mut found = found_dots(layers(&document)[0]);
        assert_eq!(found.len(), from.len());
        assert!(found.iter().all(|d| d.tick == (touch == Touch::Tick) && d.opacity == 1.0));
        // Matched by place: no two dots are that near.
        let mut rows: Vec<usize> = (0..from.len()).collect();
        rows.sort_by_key(|&i| ((f64::from(from.x[i]) * mm_per_px * 1e3).round() as i64, i));
        found.sort_by_key(|d| (d.x * 1e3).round() as i64);
        let mut area = [0.0, 0.0];
        for (&i, dot) in rows.iter().zip(&found) {
            let wanted = [from.x[i], from.y[i], 2.0 * from.radius[i]].map(|px| f64::from(px) * mm_per_px);
            assert!((dot.x - wanted[0]).abs() < 0.000_51, "{dot:?}");
            let near = found
                .iter()
                .any(|d| (d.x - wanted[0]).abs() < 0.000_51 && (d.y - wanted[1]).abs() < 0.000_51);
            assert!(near, "{wanted:?}");
            area[0] += wanted[2] * wanted[2];
            // A tick is longer than a disc by its length.
            let tick = if dot.tick { 0.001 * 4.0 / std::f64::consts::PI } else { 0.0 };
            area[1] += dot.diameter * (dot.diameter + tick);
            let step = if touch == Touch::Circle { 0.002 } else { 0.001 };
            let same: Vec<_> = found.iter().filter(|d| (d.x - dot.x).abs() < 1e-9).collect();
            assert!(same.len() > 1 || (dot.diameter - wanted[2]).abs() < step + 0.0007, "{dot:?} {wanted:?}");
        }
        assert!((area[1] / area[0] - 1.0).abs() < 1e-5, "{touch:?}: {area:?}");
    }
}

#[test]
fn sizes_between_micrometres_keep_their_area() {
    let mut drawing = plate(1000);
    drawing.layers[0].dots.radius.fill(0.5 * 0.0423 / drawing.page.mm_per_px());
    let text = svg(&drawing, &SvgOptions::default());
    let document = Document::parse(&text).unwrap();
    let found = found_dots(layers(&document)[0]);
    let area: f64 = found.iter().map(|d| d.diameter * d.diameter).sum();
    assert!((area / 1000.0 / 0.0423f64.powi(2) - 1.0).abs() < 1e-4);
    assert_eq!(text.matches("<path").count(), 2);
    // A pen's dots have one size.
    drawing.layers[0].pen_mm = Some(0.042);
    drawing.layers[0].dots.radius.fill(0.5 * 0.042 / drawing.page.mm_per_px());
    for options in [SvgOptions::default(), SvgOptions::for_plotter()] {
        let text = svg(&drawing, &options);
        assert_eq!((text.matches("<path").count(), text.matches("stroke-width=\"0.042\"").count()), (1, 1));
    }
}

#[test]
fn a_large_plate_is_small_and_has_few_elements() {
    let drawing = plate(200_000);
    for (touch, bytes_a_dot) in [(Touch::Dot, 18), (Touch::Tick, 22), (Touch::Circle, 46)] {
        let text = svg(&drawing, &SvgOptions { touch, ..SvgOptions::default() });
        assert!(text.len() < bytes_a_dot * 200_000, "{touch:?}: {}", text.len());
        let elements = text.matches("<path").count();
        assert!(elements < 300, "{elements}");
        // At most 3 decimals.
        let long = text
            .split(|c: char| c != '.' && !c.is_ascii_digit())
            .find(|number| number.split_once('.').is_some_and(|(_, decimals)| decimals.len() > 3));
        assert_eq!(long, None);
        // No attribute comes near the 10 MB that XML parsers refuse.
        assert!(text.split('"').all(|part| touch == Touch::Circle || part.len() < 300_000));
    }
}

#[test]
fn very_many_sizes_and_strengths_still_make_few_elements() {
    let mut drawing = plate(100_000);
    for i in 0..100_000 {
        let d = &mut drawing.layers[0].dots;
        d.ink[i] = unit(hash2(i as u32, 8));
        d.radius[i] *= 1.0 + 10.0 * unit(hash2(i as u32, 9));
    }
    let text = svg(&drawing, &SvgOptions::default());
    let elements = text.matches("<path").count();
    assert!((1000..4200).contains(&elements), "{elements}");
    let document = Document::parse(&text).unwrap();
    let found = found_dots(layers(&document)[0]);
    let mm_per_px = 25.4 / f64::from(drawing.page.dpi);
    let (mut wanted, mut got) = (0.0, 0.0);
    let d = &drawing.layers[0].dots;
    for i in 0..d.len() {
        let ink = f64::from(crate::opacity::opacity(d.ink[i], Color::BLACK, Color::WHITE));
        wanted += (2.0 * f64::from(d.radius[i]) * mm_per_px).powi(2) * ink;
    }
    for dot in found {
        got += dot.diameter * dot.diameter * dot.opacity;
    }
    assert!((got / wanted - 1.0).abs() < 0.002, "{got} {wanted}");
}

#[test]
fn a_plotter_keeps_the_order_and_one_width() {
    let mut drawing = plate(20_500);
    drawing.layers[0].dots.ink.fill(0.5);
    drawing.layers[0].strokes.push_line(
        StrokeKind::Crease,
        1,
        3.0,
        [[10.0, 10.0], [50.0, 10.0], [60.0, 90.0]],
    );
    drawing.layers[0].strokes.width[0] = 30.0;
    drawing.layers[0].image =
        Some(Image { width: 1, height: 1, place: [0.0, 0.0, 9.0, 9.0], samples: vec![[0.5; 4]] });
    drawing.layers[0].pen_mm = Some(0.2);
    let text = svg(&drawing, &SvgOptions::for_plotter());
    let document = Document::parse(&text).unwrap();
    let found = found_dots(layers(&document)[0]);
    let from = &drawing.layers[0].dots;
    assert_eq!(found.len(), from.len());
    let mm_per_px = 25.4 / f64::from(drawing.page.dpi);
    for (i, dot) in found.iter().enumerate() {
        assert!((dot.x - f64::from(from.x[i]) * mm_per_px).abs() < 0.000_51);
        assert!((dot.y - f64::from(from.y[i]) * mm_per_px).abs() < 0.000_51);
        assert_eq!((dot.diameter, dot.opacity, dot.tick), (0.2, 1.0, true));
    }
    assert_eq!(text.matches("class=\"dots\"").count(), 3, "10,000 dots a path");
    assert_eq!(text.matches("class=\"crease\" stroke-width=\"0.2\" d=\"M0.847 0.847L4.233").count(), 1);
    assert!(!text.contains("<image"));
}

fn one_stroke(width: &[f32], darkness: &[f32]) -> Vec<(f64, f64, Vec<[f64; 2]>, bool)> {
    let page = Page { width: 100, height: 100, dpi: 25.4, margin_px: 0.0 };
    let mut drawing = Drawing::new(page, Color::WHITE);
    let mut layer = Layer::default();
    let n = width.len();
    let points = (0..n).map(|i| [1.0 + 90.0 * i as f32 / n as f32, 2.0 + (i % 2) as f32]);
    layer.strokes.push_line(StrokeKind::Suggestive, 1, 1.0, points);
    layer.strokes.width.copy_from_slice(width);
    layer.strokes.darkness.copy_from_slice(darkness);
    drawing.layers.push(layer);
    let text = svg(&drawing, &SvgOptions::default());
    let document = Document::parse(&text).unwrap();
    let paths = document.descendants().filter(|n| n.attribute("class") == Some("suggestive"));
    paths
        .map(|path| {
            let d = path.attribute("d").unwrap().replace(['M', 'L'], " ");
            let numbers: Vec<f64> = d.split_whitespace().map(|v| v.parse().unwrap()).collect();
            let points = numbers.chunks(2).map(|p| [p[0], p[1]]).collect();
            let flat = path.attribute("stroke-linecap") == Some("butt");
            (number(path, "stroke-width", 0.0), number(path, "stroke-opacity", 1.0), points, flat)
        })
        .collect()
}

#[test]
fn a_stroke_of_one_width_is_one_path() {
    let paths = one_stroke(&[0.5; 40], &[1.0; 40]);
    let [(width, opacity, points, flat)] = &paths[..] else { panic!("{paths:?}") };
    assert_eq!((*width, *opacity, *flat, points.len()), (0.5, 1.0, false, 40));
    for (i, p) in points.iter().enumerate() {
        assert!((p[0] - (1.0 + 90.0 * i as f64 / 40.0)).abs() < 0.000_51);
        assert_eq!(p[1], 2.0 + (i % 2) as f64);
    }
}

#[test]
fn a_stroke_that_swells_is_cut_into_runs_that_join() {
    let widths: Vec<f32> = (0..60).map(|i| 0.1 + 0.9 * i as f32 / 59.0).collect();
    for widths in [&widths[..], &[0.1, 1.0]] {
        let paths = one_stroke(widths, &vec![1.0; widths.len()]);
        assert!((15..40).contains(&paths.len()), "{}", paths.len());
        for pair in paths.windows(2) {
            assert_eq!(pair[0].2.last(), pair[1].2.first(), "runs share their ends");
            assert!(pair[1].0 > pair[0].0 && pair[1].0 < pair[0].0 * 1.22);
        }
        assert!(paths[0].0 < 0.112 && paths.last().unwrap().0 > 0.9);
        assert_eq!(paths[0].2[0], [1.0, 2.0]);
    }
}

#[test]
fn a_stroke_that_fades() {
    let darkness: Vec<f32> = (0..30).map(|i| 1.0 - i as f32 / 29.0).collect();
    let paths = one_stroke(&[0.5; 30], &darkness);
    assert!(paths.len() > 10);
    assert!(paths.windows(2).all(|p| p[1].1 < p[0].1 && p[0].2.last() == p[1].2.first()));
    assert!(paths.iter().all(|p| p.3 == (p.1 < 1.0)), "cut runs of partial strength have flat ends");
    let opacity = f64::from(crate::opacity::opacity(0.5, Color::BLACK, Color::WHITE));
    let paths = one_stroke(&[0.5; 3], &[0.5; 3]);
    assert!(paths.len() == 1 && !paths[0].3 && (paths[0].1 - opacity).abs() <= 0.0101);
}

#[test]
fn images_are_embedded_and_placed() {
    let mut drawing =
        Drawing::new(Page { width: 100, height: 100, dpi: 254.0, margin_px: 0.0 }, Color::WHITE);
    let samples = vec![[0.25, 0.25, 0.25, 1.0]; 6];
    let image = Image { width: 3, height: 2, place: [10.0, 20.0, 40.0, 40.0], samples };
    drawing.layers.push(Layer { image: Some(image), ..Layer::default() });
    let text = svg(&drawing, &SvgOptions::default());
    let document = Document::parse(&text).unwrap();
    let node = document.descendants().find(|n| n.tag_name().name() == "image").unwrap();
    let place = ["x", "y", "width", "height"].map(|name| number(node, name, f64::NAN));
    assert_eq!(place, [1.0, 2.0, 3.0, 2.0]);
    let href = node.attribute(("http://www.w3.org/1999/xlink", "href")).unwrap();
    // The signature of a PNG.
    assert!(href.starts_with("data:image/png;base64,iVBORw0KGgo"));
    for broken in [0, 1] {
        let image = drawing.layers[0].image.as_mut().unwrap();
        if broken == 0 {
            image.place[2] = f32::NAN
        } else {
            image.place[2] = 40.0
        }
        image.samples.truncate(6 - broken);
        assert!(!svg(&drawing, &SvgOptions::default()).contains("<image"));
    }
}

#[test]
fn hostile_drawings_are_still_well_formed() {
    let mut drawing = drawing();
    for (i, bad) in
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, f32::MIN_POSITIVE].into_iter().enumerate()
    {
        let layer = &mut drawing.layers[0];
        let Dots { x, y, radius, ink, .. } = &mut layer.dots;
        (x[i], y[i + 10], radius[i + 20], ink[i + 30]) = (bad, bad, bad, bad);
        let line = [[5.0, 5.0], [10.0, 5.0], [bad, 7.0], [20.0, 20.0], [30.0, bad], [7.0, 7.0]];
        layer.strokes.push_line(StrokeKind::Border, 1, 1.0, line);
        layer.strokes.push_line(StrokeKind::Border, 1, bad, [[5.0, 5.0], [10.0, 5.0]]);
        layer.strokes.push_line(StrokeKind::Border, 1, 1.0, [[5.0, 5.0], [10.0, 5.0]]);
        let n = layer.strokes.darkness.len();
        layer.strokes.darkness[n - 1] = bad;
        layer.strokes.push_line(StrokeKind::Border, 1, 1.0, []);
        layer.strokes.push_line(StrokeKind::Border, 1, 1.0, [[3.0, 3.0]]);
        layer.strokes.push_line(StrokeKind::Border, 1, 0.0, [[3.0, 3.0], [9.0, 3.0]]);
    }
    drawing.layers[0].object = "\0\u{7}\"'<&>]]>\u{fffe}\u{202e}\n".into();
    let options = SvgOptions { title: Some("\0<"), metadata: Some("\u{b}&\r"), ..SvgOptions::default() };
    for touch in [Touch::Dot, Touch::Tick, Touch::Circle] {
        for plotter in [false, true] {
            for pen_mm in [None, Some(0.1), Some(f32::NAN), Some(-1.0)] {
                drawing.layers[0].pen_mm = pen_mm;
                let text = svg(&drawing, &SvgOptions { touch, plotter, ..options });
                let document = Document::parse(&text).unwrap();
                for bad in ["inf", "-0 ", "e+", "e-"] {
                    let numbers = text.split("<g ").skip(1);
                    let numbers = numbers.flat_map(|g| g.split(">\n").skip(1)).collect::<String>();
                    assert!(!numbers.replace("stroke-", "").contains(bad), "{bad}");
                }
                assert!(!text.contains("NaN\"") && !text.contains("NaN "));
                assert!(
                    document.descendants().filter(|n| n.attribute("class") == Some("border")).count() > 20
                );
            }
        }
    }
}

#[test]
fn an_empty_drawing_is_a_page() {
    let text = svg(&Drawing::new(Page::default(), Color::WHITE), &SvgOptions::default());
    let document = Document::parse(&text).unwrap();
    assert_eq!(
        document.root_element().children().filter(Node::is_element).count(),
        1,
        "only the description"
    );
}

#[test]
fn what_lies_off_the_page_is_left_out() {
    let mut drawing = plate(4);
    let (width, d) = (drawing.page.width as f32, &mut drawing.layers[0].dots);
    d.radius.fill(2.0);
    d.x.copy_from_slice(&[-3.0, -1.0, width + 1.0, width + 3.0]);
    let text = svg(&drawing, &SvgOptions::default());
    assert_eq!(found_dots(layers(&Document::parse(&text).unwrap())[0]).len(), 2);
}
