//! A picture inside an SVG: an embedded PNG, stretched over its place on the page.

use std::io::{self, Write};

use dotwork_drawing::{Color, Drawing, Image};

use crate::base64::write_base64;
use crate::opacity::encode;
use crate::text::TextWriter;

/// Steps of the table from linear light to sRGB: fine enough that no step of the darkest tones is skipped.
const ENCODE_STEPS: usize = 1 << 14;

/// Writes `image` as an element; nothing if it has no samples or no place.
pub(super) fn write_image<W: Write>(
    text: &mut TextWriter<W>,
    drawing: &Drawing,
    image: &Image,
) -> io::Result<()> {
    let count = u64::from(image.width) * u64::from(image.height);
    let place = image.place.map(|edge| f64::from(edge) * 25.4 / f64::from(drawing.page.dpi));
    let [left, top, right, bottom] = place;
    let finite = place.iter().all(|edge| edge.abs() < 1e9);
    if count == 0 || image.samples.len() as u64 != count || !finite || left >= right || top >= bottom {
        return Ok(());
    }
    text.bytes(b"<image");
    for (key, mm) in
        [(" x=\"", left), ("\" y=\"", top), ("\" width=\"", right - left), ("\" height=\"", bottom - top)]
    {
        text.bytes(key.as_bytes());
        text.thousandths((mm * 1e3).round() as i64);
    }
    // Inkscape before 1.0 knows only the older name of the attribute; everything still reads it.
    text.bytes(b"\" preserveAspectRatio=\"none\" xlink:href=\"data:image/png;base64,");
    text.pass_all_on()?;
    write_base64(text.writer(), &png(image, drawing.paper)?)?;
    text.bytes(b"\"/>\n");
    text.pass_on()
}

/// The samples as an 8-bit sRGB PNG with straight opacity where it is needed.
fn png(image: &Image, paper: Color) -> io::Result<Vec<u8>> {
    let curve: Vec<f32> = (0..=ENCODE_STEPS).map(|i| encode(i as f32 / ENCODE_STEPS as f32)).collect();
    // Not a number becomes 0.
    let encoded =
        |linear: f32| curve[(linear * ENCODE_STEPS as f32 + 0.5).clamp(0.0, ENCODE_STEPS as f32) as usize];
    let byte = |v: f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    let opaque = image.samples.iter().all(|s| s[3] >= 1.0);
    let channels = if opaque { 3 } else { 4 };
    let linear_paper = paper.to_linear();
    let shown_paper = linear_paper.map(encoded);
    let mut bytes = Vec::with_capacity(image.samples.len() * channels);
    for &[r, g, b, a] in &image.samples {
        if opaque {
            bytes.extend([r, g, b].map(|c| byte(encoded(c))));
            continue;
        }
        // The viewer blends in sRGB: opacity and colour are such that the result on bare paper is that of blending
        // in linear light (see `opacity`).
        let a = if a.is_nan() { 0.0 } else { a.clamp(0.0, 1.0) };
        let shown = [r, g, b].map(|c| c.max(0.0));
        let shown: [f32; 3] = std::array::from_fn(|k| encoded(shown[k] + linear_paper[k] * (1.0 - a)));
        // What is brighter than the paper may need more opacity.
        let clear = (0..3).fold(encoded(1.0 - a), |clear: f32, k| {
            if shown[k] > shown_paper[k] {
                clear.min((1.0 - shown[k]) / (1.0 - shown_paper[k]))
            } else {
                clear
            }
        });
        let opacity = (1.0 - clear).max(1e-6);
        bytes.extend([0, 1, 2].map(|k| byte((shown[k] - shown_paper[k] * clear) / opacity)));
        bytes.push(byte(1.0 - clear));
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.width, image.height);
    encoder.set_color(if opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::color::linear_to_srgb;
    use std::io::Cursor;

    fn decoded(samples: &[[f32; 4]], paper: Color) -> (usize, Vec<u8>) {
        let place = [0.0, 0.0, 1.0, 1.0];
        let image = Image { width: samples.len() as u32, height: 1, place, samples: samples.to_vec() };
        let file = png(&image, paper).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        (info.color_type.samples(), bytes)
    }

    #[test]
    fn opaque_samples_are_encoded() {
        let (channels, bytes) = decoded(&[[0.0, 0.5, 1.0, 1.0], [0.2, 9.0, f32::NAN, 1.0]], Color::WHITE);
        assert_eq!(channels, 3);
        assert_eq!(bytes, [0, linear_to_srgb(0.5), 255, linear_to_srgb(0.2), 255, 0]);
    }

    #[test]
    fn on_paper_the_blend_is_that_of_linear_light() {
        for paper in [Color::WHITE, Color { r: 240, g: 225, b: 200 }] {
            for (c, a) in [(0.0f32, 0.5f32), (1.0, 0.5), (0.3, 0.25), (0.6, 0.9), (0.5, 0.0), (0.2, 1.0)] {
                // Premultiplied.
                let (channels, bytes) = decoded(&[[c * a, c * a, c * a, a], [0.0; 4]], paper);
                assert_eq!(channels, 4);
                let alpha = f32::from(bytes[3]) / 255.0;
                for (k, p) in [paper.r, paper.g, paper.b].into_iter().enumerate() {
                    let shown = f32::from(bytes[k]) * alpha + f32::from(p) * (1.0 - alpha);
                    let wanted = linear_to_srgb(c * a + paper.to_linear()[k] * (1.0 - a));
                    assert!((shown - f32::from(wanted)).abs() < 1.5, "{c} {a}: {shown} for {wanted}");
                }
                assert_eq!(bytes[7], 0, "what is empty shows nothing");
            }
        }
    }
}
