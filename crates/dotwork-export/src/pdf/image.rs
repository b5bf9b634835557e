//! Image data as PDF compresses it best.

/// Rows as differences from the row above, each after the byte that says so (PNG filter 2).
pub(super) fn filtered(bytes: &[u8], row_bytes: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(bytes.len() + bytes.len() / row_bytes);
    let zeros = vec![0; row_bytes];
    let mut above = &zeros[..];
    for row in bytes.chunks_exact(row_bytes) {
        out.push(2);
        out.extend(row.iter().zip(above).map(|(a, b)| a.wrapping_sub(*b)));
        above = row;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filtered_rows_add_up_to_the_rows() {
        assert_eq!(filtered(&[1, 2, 3, 1, 0, 9], 3), [2, 1, 2, 3, 2, 0, 254, 6]);
    }
}
