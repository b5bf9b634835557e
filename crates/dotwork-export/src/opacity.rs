//! Ink of partial strength for viewers that blend in sRGB.
//!
//! dotwork blends in linear light: ink `a` of colour `c` on paper `p` gives `c a + p (1 − a)`. SVG viewers blend the
//! encoded values. So the opacity written is the one that gives the right colour *on bare paper*; for black on white
//! `1 − f(1 − a)`, f the sRGB curve. As f is nearly a power, where such marks overlap the transparencies still
//! multiply as they should.

use dotwork_drawing::Color;
use dotwork_drawing::color::srgb_to_linear;

/// The sRGB curve from linear light (0…1), not rounded.
pub(crate) fn encode(c: f32) -> f32 {
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

/// The opacity, 0…1, that shows ink of strength `ink` (0…1) of `color` on `paper` when blended in sRGB; the best for
/// all three channels by least squares.
pub(crate) fn opacity(ink: f32, color: Color, paper: Color) -> f32 {
    if ink >= 1.0 {
        return 1.0;
    }
    let (mut above, mut below) = (0.0, 0.0);
    for (c, p) in [(color.r, paper.r), (color.g, paper.g), (color.b, paper.b)] {
        let (linear_c, linear_p) = (srgb_to_linear(c), srgb_to_linear(p));
        let shown = encode(linear_p + (linear_c - linear_p) * ink);
        let (c, p) = (f32::from(c) / 255.0, f32::from(p) / 255.0);
        above += (shown - p) * (c - p);
        below += (c - p) * (c - p);
    }
    // Ink of the paper's colour does not show, at any opacity.
    if below > 0.0 { (above / below).clamp(0.0, 1.0) } else { ink }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::color::linear_to_srgb;

    #[test]
    fn blending_in_srgb_gives_the_colour_of_blending_in_linear_light() {
        let grey = Color { r: 90, g: 90, b: 90 };
        for (color, paper) in
            [(Color::BLACK, Color::WHITE), (Color::WHITE, Color::BLACK), (grey, Color::WHITE)]
        {
            for step in 0..=10 {
                let ink = step as f32 / 10.0;
                let a = opacity(ink, color, paper);
                let shown = f32::from(paper.r) + (f32::from(color.r) - f32::from(paper.r)) * a;
                let (c, p) = (srgb_to_linear(color.r), srgb_to_linear(paper.r));
                let wanted = linear_to_srgb(p + (c - p) * ink);
                assert!((shown - f32::from(wanted)).abs() < 0.6, "{ink}: {shown} for {wanted}");
            }
        }
    }

    #[test]
    fn transparencies_multiply_where_marks_overlap() {
        let one = 1.0 - opacity(0.4, Color::BLACK, Color::WHITE);
        let two = 1.0 - opacity(1.0 - 0.6 * 0.6, Color::BLACK, Color::WHITE);
        assert!((one * one - two).abs() < 0.01, "{} {two}", one * one);
    }

    #[test]
    fn ink_of_the_papers_colour() {
        assert_eq!(opacity(0.3, Color::WHITE, Color::WHITE), 0.3);
        assert_eq!(opacity(1.0, Color::WHITE, Color::WHITE), 1.0);
    }
}
