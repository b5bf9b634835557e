//! The whole drawing as JSON: page, paper, and each layer's dots as structure of arrays.
//!
//! ```json
//! {"format":"dotwork-drawing","version":1,
//! "page":{"width_px":1024,"height_px":1024,"dpi":300,"width_mm":86.6987,"height_mm":86.6987,"margin_px":0},
//! "paper":"#ffffff",
//! "layers":[
//! {"object":"bunny","color":"#000000","dots":{
//! "id":[7],
//! "x_px":[512.25],
//! "y_px":[300],
//! "depth":[3.141593],
//! "radius_px":[0.75],
//! "size":[1],
//! "ink":[1]},
//! "strokes":[
//! {"id":3,"kind":"silhouette",
//! "x_px":[10,20.5],
//! "y_px":[10,10],
//! "depth":[3.1,3.2],
//! "width_px":[1.5,1.25],
//! "darkness":[1,1]}]}
//! ]}
//! ```
//!
//! A layer that one pen draws has `"pen_mm"` after its colour; strokes are open lines, their arrays one entry a point; a
//! layer with a picture under its marks has `"image":{"width":W,"height":H,"place_px":[left,top,right,bottom]}`, without
//! its samples. Numbers have the precision of the drawing table (4 decimals; `depth` and the resolution 7 significant
//! digits); what is not finite is `null`.

use std::io::{self, Write};

use dotwork_drawing::{Dots, Drawing, Layer, Strokes};

use crate::text::TextWriter;

/// Writes a drawing as JSON.
///
/// # Errors
/// What the writer refuses.
pub fn write_json<W: Write>(writer: W, drawing: &Drawing) -> io::Result<()> {
    let mut text = TextWriter::new(writer);
    let page = &drawing.page;
    let mm = |px: u32| (f64::from(px) * 25.4 / f64::from(page.dpi)) as f32;
    text.bytes(b"{\"format\":\"dotwork-drawing\",\"version\":1,\n\"page\":{\"width_px\":");
    text.integer(page.width.into());
    text.bytes(b",\"height_px\":");
    text.integer(page.height.into());
    text.bytes(b",\"dpi\":");
    number(&mut text, page.dpi, TextWriter::digits7);
    for (key, value) in [
        (",\"width_mm\":", mm(page.width)),
        (",\"height_mm\":", mm(page.height)),
        (",\"margin_px\":", page.margin_px),
    ] {
        text.bytes(key.as_bytes());
        number(&mut text, value, TextWriter::decimals4);
    }
    text.bytes(format!("}},\n\"paper\":\"{}\",\n\"layers\":[", drawing.paper).as_bytes());
    for (i, one) in drawing.layers.iter().enumerate() {
        text.bytes(if i == 0 { b"\n" } else { b",\n" });
        layer(&mut text, one)?;
    }
    text.bytes(b"\n]}\n");
    text.pass_all_on()
}

fn layer<W: Write>(text: &mut TextWriter<W>, layer: &Layer) -> io::Result<()> {
    text.bytes(b"{\"object\":");
    string(text, &layer.object);
    text.bytes(format!(",\"color\":\"{}\"", layer.color).as_bytes());
    if let Some(pen) = layer.pen_mm {
        text.bytes(b",\"pen_mm\":");
        number(text, pen, TextWriter::decimals4);
    }
    if let Some(image) = &layer.image {
        text.bytes(format!(",\"image\":{{\"width\":{},\"height\":{},", image.width, image.height).as_bytes());
        array(text, "place_px", &image.place, |text, v| number(text, v, TextWriter::decimals4))?;
        text.bytes(b"}");
    }
    text.bytes(b",\"dots\":{\n");
    let Dots { x, y, depth, radius, size, ink, id, stipple: _ } = &layer.dots;
    array(text, "id", id, TextWriter::integer)?;
    points(text, &[("x_px", x), ("y_px", y)], depth, &[("radius_px", radius), ("size", size), ("ink", ink)])?;
    text.bytes(b"},\n\"strokes\":[");
    for k in 0..layer.strokes.len() {
        text.bytes(if k == 0 { b"\n" } else { b",\n" });
        stroke(text, &layer.strokes, k)?;
    }
    text.bytes(b"]}");
    Ok(())
}

fn stroke<W: Write>(text: &mut TextWriter<W>, strokes: &Strokes, k: usize) -> io::Result<()> {
    let Strokes { x, y, depth, width, darkness, end: _, id, kind } = strokes;
    text.bytes(b"{\"id\":");
    text.integer(id[k]);
    text.bytes(format!(",\"kind\":\"{}\"", kind[k].name()).as_bytes());
    let part = strokes.points(k);
    points(
        text,
        &[("x_px", &x[part.clone()]), ("y_px", &y[part.clone()])],
        &depth[part.clone()],
        &[("width_px", &width[part.clone()]), ("darkness", &darkness[part])],
    )?;
    text.bytes(b"}");
    Ok(())
}

/// Arrays with one entry a dot or a point: places, depth, and what else there is.
fn points<W: Write>(
    text: &mut TextWriter<W>,
    places: &[(&str, &[f32])],
    depth: &[f32],
    others: &[(&str, &[f32])],
) -> io::Result<()> {
    for (key, values) in places {
        text.bytes(b",\n");
        array(text, key, values, |text, v| number(text, v, TextWriter::decimals4))?;
    }
    text.bytes(b",\n");
    array(text, "depth", depth, |text, v| number(text, v, TextWriter::digits7))?;
    for (key, values) in others {
        text.bytes(b",\n");
        array(text, key, values, |text, v| number(text, v, TextWriter::decimals4))?;
    }
    Ok(())
}

fn array<W: Write, T: Copy>(
    text: &mut TextWriter<W>,
    key: &str,
    values: &[T],
    write: impl Fn(&mut TextWriter<W>, T),
) -> io::Result<()> {
    text.bytes(b"\"");
    text.bytes(key.as_bytes());
    text.bytes(b"\":[");
    for (i, &value) in values.iter().enumerate() {
        if i > 0 {
            text.bytes(b",");
        }
        write(text, value);
        text.pass_on()?;
    }
    text.bytes(b"]");
    Ok(())
}

#[inline]
fn number<W: Write>(text: &mut TextWriter<W>, value: f32, write: impl FnOnce(&mut TextWriter<W>, f32)) {
    if value.is_finite() { write(text, value) } else { text.bytes(b"null") }
}

/// A string in quotes, escaped as RFC 8259 says.
fn string<W: Write>(text: &mut TextWriter<W>, s: &str) {
    text.bytes(b"\"");
    for c in s.chars() {
        match c {
            '"' => text.bytes(b"\\\""),
            '\\' => text.bytes(b"\\\\"),
            '\n' => text.bytes(b"\\n"),
            '\r' => text.bytes(b"\\r"),
            '\t' => text.bytes(b"\\t"),
            c if c < ' ' => text.bytes(format!("\\u{:04x}", c as u32).as_bytes()),
            c => text.bytes(c.encode_utf8(&mut [0; 4]).as_bytes()),
        }
    }
    text.bytes(b"\"");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{dots, drawing};
    use dotwork_drawing::{Color, Image, Page, StrokeKind};
    use serde_json::Value;

    fn json(drawing: &Drawing) -> (String, Value) {
        let mut out = Vec::new();
        write_json(&mut out, drawing).unwrap();
        let text = String::from_utf8(out).unwrap();
        let value = serde_json::from_str(&text).unwrap();
        (text, value)
    }

    #[test]
    fn drawings_parse_back() {
        let mut drawing = drawing();
        drawing.page = Page { margin_px: 12.5, ..Page::millimetres(148.0, 210.0, 600.0).unwrap() };
        drawing.paper = Color { r: 255, g: 250, b: 0xe1 };
        let (text, value) = json(&drawing);
        assert_eq!(text, json(&drawing).0, "the same bytes every time");
        assert_eq!(value["format"], "dotwork-drawing");
        assert_eq!(value["version"], 1);
        let page = &value["page"];
        assert_eq!([&page["width_px"], &page["height_px"], &page["dpi"]], [3496, 4961, 600]);
        assert!((page["width_mm"].as_f64().unwrap() - 148.0).abs() < 0.03);
        assert!((page["height_mm"].as_f64().unwrap() - 210.0).abs() < 0.03);
        assert_eq!(page["margin_px"], 12.5);
        assert_eq!(value["paper"], "#fffae1");
        let layers = value["layers"].as_array().unwrap();
        assert_eq!(layers.len(), drawing.layers.len());
        for (read, layer) in layers.iter().zip(&drawing.layers) {
            assert_eq!(read["object"], *layer.object);
            assert_eq!(read["color"], layer.color.to_string());
            let d = &layer.dots;
            let ids: Vec<u64> = serde_json::from_value(read["dots"]["id"].clone()).unwrap();
            assert_eq!(ids, d.id);
            for (key, written) in [
                ("x_px", &d.x),
                ("y_px", &d.y),
                ("depth", &d.depth),
                ("radius_px", &d.radius),
                ("size", &d.size),
                ("ink", &d.ink),
            ] {
                let values: Vec<f64> = serde_json::from_value(read["dots"][key].clone()).unwrap();
                assert_eq!(values.len(), written.len(), "{key}");
                for (a, b) in values.iter().zip(written) {
                    assert!((a - f64::from(*b)).abs() <= 0.500_001e-4, "{key}: {b} as {a}");
                }
            }
        }
    }

    #[test]
    fn strokes_pens_and_images_are_there() {
        let mut strokes = Strokes::default();
        strokes.push_line(StrokeKind::Silhouette, 3, 1.5, [[10.0, 10.0], [20.5, 10.0], [21.0, 12.0]]);
        strokes.push_line(StrokeKind::Annotation, 4, 2.0, [[1.0, 2.0]]);
        let image = Image { width: 1, height: 1, place: [0.0, 1.0, 2.0, 3.5], samples: vec![[0.0; 4]] };
        let layer = Layer { pen_mm: Some(0.25), image: Some(image), strokes, ..Layer::default() };
        let drawing = Drawing { layers: vec![layer], ..Drawing::new(Page::default(), Color::WHITE) };
        let (_, value) = json(&drawing);
        let layer = &value["layers"][0];
        assert_eq!(layer["pen_mm"], 0.25);
        assert_eq!(layer["image"], serde_json::json!({"width": 1, "height": 1, "place_px": [0, 1, 2, 3.5]}));
        assert_eq!(layer["dots"]["id"], Value::Array(Vec::new()));
        let strokes = layer["strokes"].as_array().unwrap();
        assert_eq!(strokes.len(), 2);
        assert_eq!((&strokes[0]["id"], &strokes[0]["kind"]), (&3.into(), &"silhouette".into()));
        assert_eq!(strokes[0]["x_px"], serde_json::json!([10, 20.5, 21]));
        assert_eq!(strokes[0]["width_px"], serde_json::json!([1.5, 1.5, 1.5]));
        assert_eq!(strokes[1]["y_px"], serde_json::json!([2]));
        assert_eq!(strokes[1]["darkness"], serde_json::json!([1]));
    }

    #[test]
    fn an_empty_drawing_is_valid() {
        let (_, value) = json(&Drawing::new(Page::default(), Color::WHITE));
        assert_eq!(value["layers"], Value::Array(Vec::new()));
    }

    #[test]
    fn hostile_names_and_numbers_stay_valid() {
        let object: String = (0..0x300)
            .filter_map(char::from_u32)
            .chain(['\u{2028}', '\u{fffd}', '😀', '\u{10ffff}'])
            .collect();
        let mut drawing = Drawing::new(Page { dpi: f32::NAN, ..Page::default() }, Color::WHITE);
        let mut dots = dots(4);
        dots.x.copy_from_slice(&[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX]);
        dots.depth.copy_from_slice(&[f32::NAN, f32::MIN_POSITIVE, -1e-30, f32::MAX]);
        drawing.layers.push(Layer { object: object.clone(), color: Color::BLACK, dots, ..Layer::default() });
        let (_, value) = json(&drawing);
        assert!(value["page"]["dpi"].is_null() && value["page"]["width_mm"].is_null());
        let layer = &value["layers"][0];
        assert_eq!(layer["object"], object);
        let x = layer["dots"]["x_px"].as_array().unwrap();
        assert!(x[..3].iter().all(Value::is_null));
        assert_eq!(x[3].as_f64().unwrap() as f32, f32::MAX);
        assert!(layer["dots"]["depth"][0].is_null());
    }
}
