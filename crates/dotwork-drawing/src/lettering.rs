//! Letters of a single stroke, for the few words that a drawing carries: a pen plotter draws them like any other line.
//!
//! Glyphs lie on a grid 4 wide and 6 high; digits, the letters of units of length, and a little punctuation.

use crate::marks::{StrokeKind, Strokes};

/// Height of the grid from the baseline to the top of digits.
const HEIGHT: f32 = 6.0;

/// Space between two glyphs, grid units.
const GAP: f32 = 1.6;

/// Width and lines of a glyph, `x,y` pairs with y up from the baseline; lines are apart by `;`.
fn glyph(c: char) -> (f32, &'static str) {
    match c {
        '0' => (4.0, "1,0 0,1 0,5 1,6 3,6 4,5 4,1 3,0 1,0"),
        '1' => (2.0, "0,4.6 1.5,6 1.5,0"),
        '2' => (4.0, "0,5 1,6 3,6 4,5 4,4 0,0 4,0"),
        '3' => (4.0, "0,5.2 1,6 3,6 4,5 4,4.2 3,3.2 1.6,3.2;3,3.2 4,2.2 4,1 3,0 1,0 0,0.8"),
        '4' => (4.0, "3,0 3,6 0,1.6 4,1.6"),
        '5' => (4.0, "3.8,6 0.4,6 0,3.2 1,3.8 3,3.8 4,2.8 4,1 3,0 1,0 0,0.8"),
        '6' => (4.0, "3.6,5.6 3,6 1.4,6 0,4.4 0,1 1,0 3,0 4,1 4,2.6 3,3.6 1,3.6 0,2.6"),
        '7' => (4.0, "0,6 4,6 1.4,0"),
        '8' => (4.0, "1,3.2 0,4.2 0,5 1,6 3,6 4,5 4,4.2 3,3.2 1,3.2 0,2.2 0,1 1,0 3,0 4,1 4,2.2 3,3.2"),
        '9' => (4.0, "0.4,0.4 1,0 2.6,0 4,1.6 4,5 3,6 1,6 0,5 0,3.4 1,2.4 3,2.4 4,3.4"),
        '.' => (0.4, "0.2,0"),
        '-' => (3.0, "0,3 3,3"),
        'c' => (3.0, "3,3.4 2.4,4 0.8,4 0,3.2 0,0.8 0.8,0 2.4,0 3,0.6"),
        'i' => (0.4, "0.2,0 0.2,4;0.2,5.6"),
        'k' => (3.0, "0,0 0,6;2.8,4 0,1.6;1,2.5 3,0"),
        'm' => (5.0, "0,0 0,4;0,3.2 0.8,4 1.8,4 2.5,3.2 2.5,0;2.5,3.2 3.3,4 4.3,4 5,3.2 5,0"),
        'n' => (3.0, "0,0 0,4;0,3.1 0.9,4 2.2,4 3,3.2 3,0"),
        's' => (3.0, "3,3.5 2.3,4 0.7,4 0,3.4 0,2.7 0.6,2.2 2.4,1.9 3,1.3 3,0.6 2.3,0 0.7,0 0,0.5"),
        't' => (2.4, "1,5.6 1,0.8 1.6,0 2.4,0;0,4 2.2,4"),
        'u' => (3.0, "0,4 0,0.8 0.8,0 2.1,0 3,0.9;3,4 3,0"),
        'µ' => (3.0, "0,4 0,-1.6;0,0.8 0.8,0 2.1,0 3,0.9;3,4 3,0"),
        _ => (2.0, ""),
    }
}

/// Width in pixels of `text` with digits `height` pixels high.
pub fn text_width(text: &str, height: f32) -> f32 {
    let glyphs: f32 = text.chars().map(|c| glyph(c).0 + GAP).sum();
    (glyphs - GAP).max(0.0) * height / HEIGHT
}

/// Writes `text` with its baseline beginning at `x`, `y` (pixels), digits `height` pixels high, in strokes `width`
/// pixels wide with ids from `id` on. Characters without a glyph leave a space.
pub fn write_text(strokes: &mut Strokes, text: &str, [x, y]: [f32; 2], height: f32, width: f32, mut id: u64) {
    let scale = height / HEIGHT;
    let mut pen = x;
    for c in text.chars() {
        let (advance, lines) = glyph(c);
        for line in lines.split(';').filter(|l| !l.is_empty()) {
            let points = line.split(' ').filter_map(|p| {
                let (u, v) = p.split_once(',')?;
                Some([pen + u.parse::<f32>().ok()? * scale, y - v.parse::<f32>().ok()? * scale])
            });
            strokes.push_line(StrokeKind::Annotation, id, width, points);
            id += 1;
        }
        pen += (advance + GAP) * scale;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_glyph_parses_and_stays_in_its_box() {
        for c in "0123456789.-ciknmstuµ".chars() {
            let mut strokes = Strokes::default();
            write_text(&mut strokes, &c.to_string(), [100.0, 200.0], 60.0, 3.0, 7);
            let (advance, lines) = glyph(c);
            assert_eq!(strokes.len(), lines.split(';').count(), "{c}");
            assert_eq!(strokes.x.len(), lines.matches(',').count(), "{c}");
            assert!(strokes.x.iter().all(|&x| (100.0..=100.01 + advance * 10.0).contains(&x)), "{c}");
            assert!(strokes.y.iter().all(|&y| (140.0..=216.1).contains(&y)), "{c}");
            assert!((text_width(&c.to_string(), 60.0) - advance * 10.0).abs() < 1e-3);
        }
    }

    #[test]
    fn text_runs_to_the_right() {
        let mut strokes = Strokes::default();
        write_text(&mut strokes, "1 m?", [0.0, 0.0], 6.0, 1.0, 0);
        assert_eq!(strokes.id, [0, 1, 2, 3]);
        assert_eq!(strokes.x[strokes.points(1).start], 2.0 + 2.0 + 2.0 * GAP);
        assert!(text_width("", 6.0) == 0.0);
    }
}
