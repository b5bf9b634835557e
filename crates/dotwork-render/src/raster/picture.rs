//! Image layers: a picture placed on the page, blended in linear light.

use dotwork_drawing::Image;

use crate::bands::centers;

/// Blends `image` over the planes of a band that begins at row `top`; a grey page has one plane.
pub(super) fn blend(image: &Image, light: &mut [Vec<f32>], width: usize, top: usize) {
    if !image.is_drawable() {
        return;
    }
    let [left, upper, right, lower] = image.place;
    let (columns, rows) = (image.width as usize, image.height as usize);
    let height = light[0].len() / width;
    let Some((x0, x1)) = centers(left, right, width) else { return };
    let Some((y0, y1)) = centers(upper - top as f32, lower - top as f32, height) else { return };
    let (sx, sy) = (columns as f32 / (right - left), rows as f32 / (lower - upper));
    for row in y0..=y1 {
        let (v, wv) = between(((top + row) as f32 + 0.5 - upper) * sy, rows);
        for x in x0..=x1 {
            let (u, wu) = between((x as f32 + 0.5 - left) * sx, columns);
            let sample = |u: usize, v: usize| image.samples[v * columns + u];
            let mix = |a: [f32; 4], b: [f32; 4], w: f32| -> [f32; 4] {
                std::array::from_fn(|c| a[c] + (b[c] - a[c]) * w)
            };
            let (u1, v1) = ((u + 1).min(columns - 1), (v + 1).min(rows - 1));
            let color = mix(mix(sample(u, v), sample(u1, v), wu), mix(sample(u, v1), sample(u1, v1), wu), wv);
            for (c, plane) in light.iter_mut().enumerate() {
                let p = &mut plane[row * width + x];
                *p = (color[c] + *p * (1.0 - color[3])).clamp(0.0, 1.0);
            }
        }
    }
}

/// The sample before a place and the share of the next one; samples lie at the centres of their cells.
fn between(place: f32, count: usize) -> (usize, f32) {
    let place = (place - 0.5).clamp(0.0, (count - 1) as f32);
    let before = place as usize;
    (before, place - before as f32)
}

#[cfg(test)]
mod tests {
    use dotwork_drawing::{Color, Drawing, Image, Layer, Page};

    use crate::{Raster, Rasterizer};

    fn drawn(image: Image) -> Raster {
        let mut drawing = Drawing::new(Page::pixels(40, 50).unwrap(), Color::WHITE);
        drawing.layers.push(Layer { image: Some(image), ..Layer::default() });
        let mut raster = Raster::default();
        Rasterizer::new().draw(&drawing, &mut raster);
        raster
    }

    #[test]
    fn a_picture_at_the_resolution_of_the_page_is_copied() {
        let samples =
            vec![[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5]];
        let image = Image { width: 2, height: 2, place: [10.0, 20.0, 12.0, 22.0], samples };
        let raster = drawn(image);
        assert_eq!(raster.channels, 3);
        let pixel = |x: usize, y: usize| &raster.samples[(y * 40 + x) * 3..][..3];
        assert_eq!(pixel(10, 20), [0, 0, 0]);
        assert_eq!(pixel(11, 20), [255, 0, 0]);
        // Clear shows the paper, half white over white is white.
        assert_eq!((pixel(10, 21), pixel(11, 21)), (&[255; 3][..], &[255; 3][..]));
        assert_eq!((pixel(9, 20), pixel(12, 21)), (&[255; 3][..], &[255; 3][..]));
    }

    #[test]
    fn grey_pictures_keep_the_page_grey() {
        let image = Image {
            width: 1,
            height: 1,
            place: [-5.0, -5.0, 99.0, 99.0],
            samples: vec![[0.0, 0.0, 0.0, 1.0]],
        };
        let raster = drawn(image);
        assert_eq!(raster.channels, 1);
        assert!(raster.samples.iter().all(|&c| c == 0));
    }

    #[test]
    fn pictures_without_samples_or_place_are_left_out() {
        let black = vec![[0.0, 0.0, 0.0, 1.0]];
        let whole = [0.0, 0.0, 40.0, 50.0];
        for (width, height, samples, place) in [
            (0, 0, vec![], whole),
            (1, 0, vec![], whole),
            (0, 1, vec![], whole),
            (2, 1, black.clone(), whole),
            (1, 1, black.clone(), [40.0, 0.0, 0.0, 50.0]),
            (1, 1, black.clone(), [f32::NAN, 0.0, 40.0, 50.0]),
            (1, 1, black.clone(), [f32::NEG_INFINITY, 0.0, f32::INFINITY, 50.0]),
            (1, 1, black, [f32::MAX, 0.0, f32::INFINITY, 50.0]),
        ] {
            let raster = drawn(Image { width, height, place, samples });
            assert!(raster.samples.iter().all(|&c| c == 255), "{width} x {height} at {place:?}");
        }
    }
}
