//! The picture of a layer in 8 bits, for viewers that blend encoded sRGB.

use dotwork_drawing::{Color, Image};
use rayon::prelude::*;

use crate::opacity::encode as encoded;

/// An image as 8-bit samples.
pub(crate) struct Encoded {
    /// 1 (grey) or 3 bytes a sample.
    pub channels: usize,
    /// sRGB.
    pub colors: Vec<u8>,
    /// Opacities; `None` if all are full.
    pub mask: Option<Vec<u8>>,
}

/// Steps of the table from linear light to sRGB.
const STEPS: usize = 1 << 12;

/// Turns samples of linear light, premultiplied, into colours and opacities that look right over `paper`.
///
/// Viewers blend encoded sRGB. So each sample gets the colour that gives over bare paper what linear light gives there,
/// with more opacity where no colour could; over marks of lower layers that is an approximation, and opaque and empty
/// samples are exact everywhere.
pub(crate) fn encode(image: &Image, paper: Color) -> Encoded {
    let table: Vec<f32> = (0..=STEPS).map(|i| encoded(i as f32 / STEPS as f32)).collect();
    let encode = |linear: f32| {
        // Between the entries by lines: the darkest tones rise steeply.
        let at = linear.clamp(0.0, 1.0) * STEPS as f32;
        let i = (at as usize).min(STEPS - 1);
        table[i] + (table[i + 1] - table[i]) * (at - i as f32)
    };
    let linear = paper.to_linear();
    let bare = [paper.r, paper.g, paper.b].map(|c| f32::from(c) / 255.0);
    let one = |sample: &[f32; 4]| {
        // Not a number becomes nothing.
        let alpha = if sample[3].is_nan() { 0.0 } else { sample[3].clamp(0.0, 1.0) };
        // Encoded, so that what lies below shows through as it does in linear light (see `opacity`).
        let mut opacity = 1.0 - encode(1.0 - alpha);
        let target: [f32; 3] = std::array::from_fn(|c| {
            let light = sample[c].max(0.0) + linear[c] * (1.0 - alpha);
            let target = encode(light);
            let room = if target < bare[c] { bare[c] } else { 1.0 - bare[c] };
            if room > 0.0 {
                opacity = opacity.max(((target - bare[c]) / room).abs().min(1.0));
            }
            target
        });
        let byte = |v: f32| (v * 255.0 + 0.5) as u8;
        let mask = byte(opacity);
        if mask == 0 {
            return [0, 0, 0, 0];
        }
        // With the opacity as it is written.
        let opacity = f32::from(mask) / 255.0;
        let [r, g, b] =
            std::array::from_fn(|c| byte((bare[c] + (target[c] - bare[c]) / opacity).clamp(0.0, 1.0)));
        [r, g, b, mask]
    };
    let samples: Vec<[u8; 4]> = image.samples.par_iter().map(one).collect();
    let grey = samples.par_iter().all(|s| s[0] == s[1] && s[1] == s[2]);
    let channels = if grey { 1 } else { 3 };
    let colors = samples.iter().flat_map(|s| &s[..channels]).copied().collect();
    let mask = samples.par_iter().any(|s| s[3] < 255).then(|| samples.iter().map(|s| s[3]).collect());
    Encoded { channels, colors, mask }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::color::linear_to_srgb;

    #[test]
    fn over_bare_paper_samples_look_as_in_linear_light() {
        for paper in
            [Color::WHITE, Color::BLACK, Color { r: 250, g: 240, b: 200 }, Color { r: 30, g: 90, b: 160 }]
        {
            let samples: Vec<[f32; 4]> = (0..=10)
                .flat_map(|a| (0..27).map(move |c| (a as f32 / 10.0, c)))
                .map(|(a, c)| [(c % 3) as f32, (c / 3 % 3) as f32, (c / 9) as f32, 2.0].map(|v| v * 0.5 * a))
                .collect();
            let image = Image { width: 27, height: 11, place: [0.0, 0.0, 1.0, 1.0], samples };
            let Encoded { channels, colors, mask } = encode(&image, paper);
            assert_eq!(channels, 3);
            let mask = mask.unwrap();
            let (linear, bare) = (paper.to_linear(), [paper.r, paper.g, paper.b]);
            for (i, sample) in image.samples.iter().enumerate() {
                let a = f32::from(mask[i]) / 255.0;
                for c in 0..3 {
                    let shown = f32::from(bare[c]) * (1.0 - a) + f32::from(colors[3 * i + c]) * a;
                    let expected = linear_to_srgb(sample[c] + linear[c] * (1.0 - sample[3]));
                    assert!(
                        (shown - f32::from(expected)).abs() < 1.6,
                        "{paper} {sample:?}: {shown} {expected}"
                    );
                }
                if sample[3] == 1.0 {
                    assert_eq!(mask[i], 255);
                }
            }
        }
    }

    #[test]
    fn hostile_samples_and_places() {
        let samples = vec![[f32::NAN; 4], [f32::INFINITY; 4], [-1.0; 4], [9.0, 0.0, 0.0, 9.0]];
        let image = Image { width: 2, height: 2, place: [0.0, 0.0, 1.0, 1.0], samples };
        assert!(image.is_drawable());
        assert_eq!(encode(&image, Color::WHITE).mask.unwrap()[2..], [0, 255]);
        assert!(!Image { place: [0.0, 0.0, f32::NAN, 1.0], ..image.clone() }.is_drawable());
        assert!(!Image { place: [0.0, 0.0, 0.0, 1.0], ..image.clone() }.is_drawable());
        assert!(!Image { width: u32::MAX, height: u32::MAX, ..image }.is_drawable());
    }
}
