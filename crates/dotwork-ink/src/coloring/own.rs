//! The surface's own colours in few: cut into boxes (Heckbert, "Color image quantization for frame buffer display",
//! SIGGRAPH 1982), here at the mean, which parts what differs rather than what is frequent.

use dotwork_drawing::Color;
use dotwork_drawing::color::srgb_to_linear;

/// Stipples whose colours are looked at: the stock's order makes any first part even.
pub(super) const SAMPLE: usize = 16_384;

/// Steps of each channel in the table of nearest colours.
const STEPS: usize = 32;

/// The step of a colour in the table of nearest colours.
#[inline(always)]
pub(super) fn step(tint: [u8; 3]) -> usize {
    let [r, g, b] = tint.map(|c| usize::from(c) / (256 / STEPS));
    (r * STEPS + g) * STEPS + b
}

/// Where a box varies most: its channel, and the sum of squares about its mean there.
fn spread(tints: &[[u8; 3]]) -> (usize, f64, [f64; 3]) {
    let n = tints.len() as f64;
    let mut sums = [0.0f64; 3];
    let mut squares = [0.0f64; 3];
    for tint in tints {
        for c in 0..3 {
            let v = f64::from(tint[c]);
            sums[c] += v;
            squares[c] += v * v;
        }
    }
    let varies = |c: usize| squares[c] - sums[c] * sums[c] / n;
    let widest = (0..3).fold(0, |best, c| if varies(c) > varies(best) { c } else { best });
    (widest, varies(widest), sums.map(|s| s / n))
}

/// At most `most` colours that stand for these, all different, from light to dark.
pub(super) fn cut(tints: &[[u8; 3]], most: usize) -> Vec<Color> {
    let mut boxes = vec![tints.to_vec()];
    let mut spreads = vec![spread(tints)];
    while boxes.len() < most {
        let widest =
            (0..boxes.len()).fold(0, |best, k| if spreads[k].1 > spreads[best].1 { k } else { best });
        let (channel, varies, mean) = spreads[widest];
        // Below a level's rounding there is nothing to part.
        if varies < 0.5 {
            break;
        }
        let (low, high): (Vec<_>, Vec<_>) =
            boxes[widest].iter().partition(|tint| f64::from(tint[channel]) <= mean[channel]);
        spreads[widest] = spread(&low);
        spreads.push(spread(&high));
        boxes[widest] = low;
        boxes.push(high);
    }
    let color = |(_, _, mean): &(usize, f64, [f64; 3])| {
        let [r, g, b] = mean.map(|c| c.round() as u8);
        Color { r, g, b }
    };
    let mut colors: Vec<Color> = spreads.iter().map(color).collect();
    let light = |c: &Color| {
        let [r, g, b] = [c.r, c.g, c.b].map(srgb_to_linear);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    colors.sort_by(|a, b| light(b).total_cmp(&light(a)).then((a.r, a.g, a.b).cmp(&(b.r, b.g, b.b))));
    colors.dedup();
    colors
}

/// The nearest of `colors` for the middle of each step.
pub(super) fn nearest(colors: &[Color]) -> Vec<u8> {
    let middle = |s: usize| (s * (256 / STEPS) + 128 / STEPS) as i32;
    let all =
        (0..STEPS * STEPS * STEPS).map(|k| [k / (STEPS * STEPS), k / STEPS % STEPS, k % STEPS].map(middle));
    let entry = |[r, g, b]: [i32; 3]| {
        // The eye tells greens apart best.
        let off = |c: &Color| {
            let d = [i32::from(c.r) - r, i32::from(c.g) - g, i32::from(c.b) - b];
            2 * d[0] * d[0] + 4 * d[1] * d[1] + 3 * d[2] * d[2]
        };
        (0..colors.len()).min_by_key(|&k| off(&colors[k])).unwrap_or(0) as u8
    };
    all.map(entry).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_and_many_cut() {
        let red = [200, 10, 10];
        let blue = [10, 10, 200];
        let tints: Vec<[u8; 3]> = (0..100).map(|i| if i % 5 == 0 { red } else { blue }).collect();
        let colors = cut(&tints, 64);
        assert_eq!(colors, [Color { r: 200, g: 10, b: 10 }, Color { r: 10, g: 10, b: 200 }]);
        let table = nearest(&colors);
        assert_eq!([table[step(red)], table[step(blue)], table[step([180, 40, 20])]], [0, 1, 0]);
        // A cube of colours in 8 steps: each lies within an eighth of what stands for it.
        let cube: Vec<[u8; 3]> =
            (0..4096).map(|k| [k / 256, k / 16 % 16, k % 16].map(|c: i32| (c * 17) as u8)).collect();
        let colors = cut(&cube, 8);
        assert_eq!(colors.len(), 8);
        let table = nearest(&colors);
        for tint in cube {
            let c = colors[usize::from(table[step(tint)])];
            let off = [(c.r, tint[0]), (c.g, tint[1]), (c.b, tint[2])];
            assert!(off.iter().all(|(a, b)| a.abs_diff(*b) <= 72), "{tint:?} {c}");
        }
        assert_eq!(cut(&[[7, 8, 9]], 5), [Color { r: 7, g: 8, b: 9 }]);
    }
}
