//! Which samples are inside, one bit each.

/// Bits in a word.
pub(super) const WORD: usize = u64::BITS as usize;

/// One bit for each sample of the padded grid, set if it is inside.
pub(super) struct Bits {
    data: Vec<u64>,
    /// Samples in a row.
    columns: usize,
    /// Words in a row.
    words: usize,
    /// Rows in a layer.
    rows: usize,
    layers: usize,
}

impl Bits {
    /// No sample is inside. `None` if the grid is too large for memory.
    pub(super) fn new(size: [usize; 3]) -> Option<Bits> {
        let words = size[0].div_ceil(WORD);
        let len = words.checked_mul(size[1])?.checked_mul(size[2])?;
        Some(Bits { data: vec![0; len], columns: size[0], words, rows: size[1], layers: size[2] })
    }

    /// Words in a row.
    pub(super) fn words(&self) -> usize {
        self.words
    }

    /// Rows in a layer.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// Layers of the grid.
    pub(super) fn layers(&self) -> usize {
        self.layers
    }

    /// Row `y` of layer `z`.
    pub(super) fn row(&self, y: usize, z: usize) -> &[u64] {
        &self.data[(y + self.rows * z) * self.words..][..self.words]
    }

    /// The layers in order, each as its rows one after the other.
    pub(super) fn layers_mut(&mut self) -> std::slice::ChunksExactMut<'_, u64> {
        self.data.chunks_exact_mut(self.words * self.rows)
    }

    /// Word `w` of the cells of a row: those between a sample and the next in x.
    pub(super) fn cells(&self, w: usize) -> u64 {
        low_bits((self.columns - 1).saturating_sub(w * WORD))
    }

    /// True if all samples on the six faces of the grid are inside, or none is: then no surface ends there.
    pub(super) fn is_uniform_at_border(&self) -> bool {
        let inside = self.row(0, 0)[0] & 1;
        let last = self.columns - 1;
        (0..self.layers).all(|z| {
            (0..self.rows).all(|y| {
                let row = self.row(y, z);
                if [0, self.layers - 1].contains(&z) || [0, self.rows - 1].contains(&y) {
                    let full = |w| low_bits(self.columns - w * WORD);
                    (0..self.words).all(|w| row[w] == if inside == 1 { full(w) } else { 0 })
                } else {
                    row[0] & 1 == inside && row[last / WORD] >> (last % WORD) & 1 == inside
                }
            })
        })
    }

    /// Word `w` of the edges along `AXIS` from the samples of row `y` in layer `z`: those that are crossed.
    #[inline]
    pub(super) fn crossed<const AXIS: usize>(&self, y: usize, z: usize, w: usize) -> u64 {
        let row = self.row(y, z);
        match AXIS {
            0 => (row[w] ^ shifted(row, w)) & self.cells(w),
            1 if y + 1 < self.rows => row[w] ^ self.row(y + 1, z)[w],
            2 if z + 1 < self.layers => row[w] ^ self.row(y, z + 1)[w],
            // The last sample along an axis has no edge.
            _ => 0,
        }
    }

    /// How many edges along `AXIS` from the samples of row `y` in layer `z` are crossed.
    pub(super) fn crossings<const AXIS: usize>(&self, y: usize, z: usize) -> usize {
        let words = (0..self.words).map(|w| self.crossed::<AXIS>(y, z, w));
        words.filter(|&word| word != 0).map(|word| word.count_ones() as usize).sum()
    }
}

/// Sets the bits `shift..shift + samples.len()` of `row`, all 0 before, to what `inside` says of the samples.
pub(super) fn fill_row<T: Copy>(row: &mut [u64], shift: usize, samples: &[T], inside: impl Fn(T) -> bool) {
    debug_assert!(shift < WORD && row.len() * WORD >= shift + samples.len());
    for (w, chunk) in samples.chunks(WORD).enumerate() {
        let word = word(chunk, &inside);
        row[w] |= word << shift;
        if shift > 0 && word >> (WORD - shift) != 0 {
            row[w + 1] |= word >> (WORD - shift);
        }
    }
}

/// Bit i: `inside(samples[i])`; at most 64 samples.
fn word<T: Copy>(samples: &[T], inside: impl Fn(T) -> bool) -> u64 {
    // Two steps that vectorise: a byte a sample, then eight bytes at a time into eight bits.
    let mut flags = [0u8; WORD];
    if let Ok(samples) = <&[T; WORD]>::try_from(samples) {
        for i in 0..WORD {
            flags[i] = u8::from(inside(samples[i]));
        }
    } else {
        for (flag, &sample) in flags.iter_mut().zip(samples) {
            *flag = u8::from(inside(sample));
        }
    }
    let mut word = 0;
    for (k, eight) in flags.as_chunks::<8>().0.iter().enumerate() {
        // Byte i, times 2^(56 − 7i), becomes bit 56 + i; the other products fall on other bits.
        word |= (u64::from_le_bytes(*eight).wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * k);
    }
    word
}

/// `row` moved down by one bit: bit i is the old bit i + 1. Word `w` of it.
#[inline]
pub(super) fn shifted(row: &[u64], w: usize) -> u64 {
    row[w] >> 1 | row.get(w + 1).map_or(0, |next| next << (WORD - 1))
}

/// The indices of the bits that are set in `word`, ascending.
#[inline]
pub(super) fn ones(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let i = (word != 0).then(|| word.trailing_zeros() as usize);
        word &= word.wrapping_sub(1);
        i
    })
}

/// A word with its lowest `n` bits set; all of them from 64 on.
fn low_bits(n: usize) -> u64 {
    if n >= WORD { u64::MAX } else { (1 << n) - 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_hold_what_the_predicate_says() {
        for n in [1, 7, 63, 64, 65, 127, 128, 200] {
            for shift in [0, 1] {
                let samples: Vec<u32> = (0..n).map(|i| ((i * 2654435761u64) >> 7) as u32 % 5).collect();
                let mut row = vec![0; (samples.len() + 2 * shift).div_ceil(WORD)];
                fill_row(&mut row, shift, &samples, |s| s >= 3);
                let expected: Vec<usize> =
                    (0..samples.len()).filter(|&i| samples[i] >= 3).map(|i| i + shift).collect();
                let found: Vec<usize> =
                    (0..row.len()).flat_map(|w| ones(row[w]).map(move |i| i + w * WORD)).collect();
                assert_eq!(found, expected);
                let next: Vec<usize> =
                    (0..row.len()).flat_map(|w| ones(shifted(&row, w)).map(move |i| i + w * WORD)).collect();
                assert_eq!(next, expected.iter().filter(|&&i| i > 0).map(|i| i - 1).collect::<Vec<_>>());
            }
        }
        assert_eq!([low_bits(0), low_bits(3), low_bits(64), low_bits(99)], [0, 7, u64::MAX, u64::MAX]);
    }
}
