//! A picture inside an SVG: an embedded PNG, stretched over its place on the page.

use std::io::{self, Write};

use dotwork_drawing::{Color, Drawing, Image};

use crate::base64::write_base64;
use crate::samples::{Encoded, encode};
use crate::text::TextWriter;

/// Writes `image` as an element; nothing if it cannot be drawn.
pub(super) fn write_image<W: Write>(
    text: &mut TextWriter<W>,
    drawing: &Drawing,
    image: &Image,
) -> io::Result<()> {
    if !image.is_drawable() {
        return Ok(());
    }
    let [left, top, right, bottom] =
        image.place.map(|edge| f64::from(edge) * 25.4 / f64::from(drawing.page.dpi));
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

/// The samples as an 8-bit sRGB PNG, grey or in colour, with straight opacity where it is needed.
fn png(image: &Image, paper: Color) -> io::Result<Vec<u8>> {
    let Encoded { channels, colors, mask } = encode(image, paper);
    let kind = match (channels, &mask) {
        (1, None) => png::ColorType::Grayscale,
        (1, Some(_)) => png::ColorType::GrayscaleAlpha,
        (_, None) => png::ColorType::Rgb,
        (_, Some(_)) => png::ColorType::Rgba,
    };
    let bytes = match mask {
        None => colors,
        Some(mask) => colors
            .chunks_exact(channels)
            .zip(&mask)
            .flat_map(|(color, mask)| color.iter().chain(std::iter::once(mask)))
            .copied()
            .collect(),
    };
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.width, image.height);
    encoder.set_color(kind);
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
    use std::io::Cursor;

    fn decoded(samples: &[[f32; 4]]) -> (png::ColorType, Vec<u8>) {
        let place = [0.0, 0.0, 1.0, 1.0];
        let image = Image { width: samples.len() as u32, height: 1, place, samples: samples.to_vec() };
        let mut reader =
            png::Decoder::new(Cursor::new(png(&image, Color::WHITE).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        (info.color_type, bytes)
    }

    #[test]
    fn channels_are_those_that_are_needed() {
        let half = [0.0, 0.0, 0.0, 0.5];
        let red = [1.0, 0.0, 0.0, 1.0];
        assert_eq!(decoded(&[[1.0; 4], [0.0, 0.0, 0.0, 1.0]]), (png::ColorType::Grayscale, vec![255, 0]));
        assert_eq!(decoded(&[red]), (png::ColorType::Rgb, vec![255, 0, 0]));
        let (kind, bytes) = decoded(&[half, [0.0; 4]]);
        assert_eq!((kind, bytes[0], &bytes[2..]), (png::ColorType::GrayscaleAlpha, 0, &[0, 0][..]));
        let (kind, bytes) = decoded(&[red, half]);
        assert_eq!((kind, &bytes[..7]), (png::ColorType::Rgba, &[255, 0, 0, 255, 0, 0, 0][..]));
    }
}
