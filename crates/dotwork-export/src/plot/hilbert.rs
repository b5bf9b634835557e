//! Places along a Hilbert curve: near in number, near on the page.
//!
//! D. Hilbert (1891), by the bit-twiddling of J. Skilling ("Programming the Hilbert curve", 2004) in two dimensions.

/// Bits a coordinate.
const BITS: u32 = 16;

/// The number of the cell (`x`, `y`), each below 2¹⁶, along the curve that starts at the origin.
fn cell_number(x: u32, y: u32) -> u32 {
    let (mut x, mut y) = (x, y);
    let mut number = 0;
    for bit in (0..BITS).rev() {
        let (right, down) = (x >> bit & 1, y >> bit & 1);
        number = number << 2 | ((3 * right) ^ down);
        // Turn the quadrant so that its curve runs from the origin along x.
        if down == 0 {
            if right == 1 {
                (x, y) = (!x, !y);
            }
            (x, y) = (y, x);
        }
    }
    number
}

/// The indices of finite `points` along a Hilbert curve over their bounding square, from the corner with the smallest
/// coordinates. Points of one cell stay in order of index.
pub(super) fn along_hilbert_curve(points: &[[f32; 2]]) -> Vec<u32> {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for point in points {
        for axis in 0..2 {
            low[axis] = low[axis].min(f64::from(point[axis]));
            high[axis] = high[axis].max(f64::from(point[axis]));
        }
    }
    let side = (high[0] - low[0]).max(high[1] - low[1]).max(f64::MIN_POSITIVE);
    let cells = f64::from((1 << BITS) - 1) / side;
    let cell = |point: &[f32; 2], axis: usize| ((f64::from(point[axis]) - low[axis]) * cells) as u32;
    let mut keys: Vec<(u32, u32)> =
        points.iter().enumerate().map(|(i, p)| (cell_number(cell(p, 0), cell(p, 1)), i as u32)).collect();
    keys.sort_unstable();
    keys.into_iter().map(|(_, i)| i).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn consecutive_cells_touch_and_none_is_missed() {
        // A grid of 64 × 64 cells of 1024: the curve of order 6 sampled from the one of order 16.
        let points: Vec<[f32; 2]> = (0..64 * 64).map(|i| [(i % 64) as f32, (i / 64) as f32]).collect();
        let order = along_hilbert_curve(&points);
        let mut seen = order.clone();
        seen.sort_unstable();
        assert!(seen.iter().enumerate().all(|(i, &s)| s == i as u32));
        assert_eq!(points[order[0] as usize], [0.0, 0.0]);
        for pair in order.windows(2) {
            let [a, b] = [points[pair[0] as usize], points[pair[1] as usize]];
            assert_eq!((a[0] - b[0]).abs() + (a[1] - b[1]).abs(), 1.0, "{a:?} {b:?}");
        }
    }

    #[test]
    fn points_that_span_nothing() {
        assert!(along_hilbert_curve(&[]).is_empty());
        assert_eq!(along_hilbert_curve(&[[5.0, 5.0]; 3]), [0, 1, 2]);
        assert_eq!(along_hilbert_curve(&[[1.0, 0.0], [0.0, 0.0]]), [1, 0]);
        assert_eq!(along_hilbert_curve(&[[f32::MAX, 0.0], [f32::MIN, 0.0]]), [1, 0]);
    }
}
