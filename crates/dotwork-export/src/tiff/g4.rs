//! CCITT Group 4: each row as its differences from the row above (ITU-T T.6; run codes from T.4, tables 2 and 3).
//!
//! A row is coded by the places where its colour changes. Rows are read in words, so that blank paper, which is most of
//! a plate, costs a comparison a word; coding is proportional to the number of changes.

/// Codes rows of `width` pixels (highest bit leftmost, 1 black) as one block with its end mark.
pub(super) fn encode(rows: &[u8], width: usize, row_bytes: usize) -> Vec<u8> {
    let mut bits = Bits::default();
    let (mut above, mut row) = (Vec::new(), Vec::new());
    changes(&[], width, &mut above);
    for bytes in rows.chunks_exact(row_bytes) {
        changes(bytes, width, &mut row);
        encode_row(&above, &row, width, &mut bits);
        std::mem::swap(&mut above, &mut row);
    }
    // Two end-of-line codes end a block.
    bits.put(1, 12);
    bits.put(1, 12);
    bits.finish()
}

/// The columns in which a row's colour changes, starting from white, and four times its width.
fn changes(bytes: &[u8], width: usize, out: &mut Vec<usize>) {
    out.clear();
    let mut black = false;
    for (k, chunk) in bytes.chunks(8).enumerate() {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        let word = u64::from_be_bytes(word);
        // Bits that differ from their left neighbour.
        let mut edges = word ^ (word >> 1 | u64::from(black) << 63);
        while edges != 0 {
            let at = edges.leading_zeros();
            out.push(k * 64 + at as usize);
            edges &= !(1 << 63 >> at);
        }
        black = word & 1 != 0;
    }
    // The padding is white: a change at the width or in a word's unused end is none.
    while out.last().is_some_and(|&x| x >= width) {
        out.pop();
    }
    out.extend([width; 4]);
}

fn encode_row(above: &[usize], row: &[usize], width: usize, bits: &mut Bits) {
    // Before the first pixel stands an imaginary white one: a change may lie in column 0.
    let mut from = 0;
    let mut started = false;
    let mut black = false;
    let (mut next, mut reference) = (0, 0);
    while from < width {
        // The first change above, right of here, to the colour that is not the present one: even places turn black.
        while (above[reference] < from || above[reference] == from && started) && above[reference] < width {
            reference += 2;
        }
        let (b1, b2) = (above[reference], above[reference + 1]);
        let a1 = row[next];
        if b2 < a1 {
            bits.put(0b0001, 4);
            from = b2;
        } else if let Some(&(code, length)) = (a1 + 3).checked_sub(b1).and_then(|d| VERTICAL.get(d)) {
            bits.put(code, length);
            from = a1;
            black = !black;
            next += 1;
            // Left of the next change above of the other colour may lie one that is still right of here.
            reference = if reference > 0 { reference - 1 } else { reference + 1 };
        } else {
            let a2 = row[next + 1];
            bits.put(0b001, 3);
            bits.run(black, a1 - from);
            bits.run(!black, a2 - a1);
            from = a2;
            next += 2;
        }
        started = true;
    }
}

/// Codes for a change three columns left of the one above to three columns right of it.
const VERTICAL: [(u16, u8); 7] =
    [(0b000_0010, 7), (0b00_0010, 6), (0b010, 3), (0b1, 1), (0b011, 3), (0b00_0011, 6), (0b000_0011, 7)];

/// Codes of white runs and their lengths in bits: 0 to 63 pixels, then 64 to 2560 in steps of 64.
#[rustfmt::skip]
const WHITE: [(u16, u8); 104] = [
    (0x35, 8), (0x7, 6), (0x7, 4), (0x8, 4), (0xb, 4), (0xc, 4), (0xe, 4), (0xf, 4),
    (0x13, 5), (0x14, 5), (0x7, 5), (0x8, 5), (0x8, 6), (0x3, 6), (0x34, 6), (0x35, 6),
    (0x2a, 6), (0x2b, 6), (0x27, 7), (0xc, 7), (0x8, 7), (0x17, 7), (0x3, 7), (0x4, 7),
    (0x28, 7), (0x2b, 7), (0x13, 7), (0x24, 7), (0x18, 7), (0x2, 8), (0x3, 8), (0x1a, 8),
    (0x1b, 8), (0x12, 8), (0x13, 8), (0x14, 8), (0x15, 8), (0x16, 8), (0x17, 8), (0x28, 8),
    (0x29, 8), (0x2a, 8), (0x2b, 8), (0x2c, 8), (0x2d, 8), (0x4, 8), (0x5, 8), (0xa, 8),
    (0xb, 8), (0x52, 8), (0x53, 8), (0x54, 8), (0x55, 8), (0x24, 8), (0x25, 8), (0x58, 8),
    (0x59, 8), (0x5a, 8), (0x5b, 8), (0x4a, 8), (0x4b, 8), (0x32, 8), (0x33, 8), (0x34, 8),
    (0x1b, 5), (0x12, 5), (0x17, 6), (0x37, 7), (0x36, 8), (0x37, 8), (0x64, 8), (0x65, 8),
    (0x68, 8), (0x67, 8), (0xcc, 9), (0xcd, 9), (0xd2, 9), (0xd3, 9), (0xd4, 9), (0xd5, 9),
    (0xd6, 9), (0xd7, 9), (0xd8, 9), (0xd9, 9), (0xda, 9), (0xdb, 9), (0x98, 9), (0x99, 9),
    (0x9a, 9), (0x18, 6), (0x9b, 9), (0x8, 11), (0xc, 11), (0xd, 11), (0x12, 12), (0x13, 12),
    (0x14, 12), (0x15, 12), (0x16, 12), (0x17, 12), (0x1c, 12), (0x1d, 12), (0x1e, 12), (0x1f, 12),
];

/// Codes of black runs and their lengths in bits: 0 to 63 pixels, then 64 to 2560 in steps of 64.
#[rustfmt::skip]
const BLACK: [(u16, u8); 104] = [
    (0x37, 10), (0x2, 3), (0x3, 2), (0x2, 2), (0x3, 3), (0x3, 4), (0x2, 4), (0x3, 5),
    (0x5, 6), (0x4, 6), (0x4, 7), (0x5, 7), (0x7, 7), (0x4, 8), (0x7, 8), (0x18, 9),
    (0x17, 10), (0x18, 10), (0x8, 10), (0x67, 11), (0x68, 11), (0x6c, 11), (0x37, 11), (0x28, 11),
    (0x17, 11), (0x18, 11), (0xca, 12), (0xcb, 12), (0xcc, 12), (0xcd, 12), (0x68, 12), (0x69, 12),
    (0x6a, 12), (0x6b, 12), (0xd2, 12), (0xd3, 12), (0xd4, 12), (0xd5, 12), (0xd6, 12), (0xd7, 12),
    (0x6c, 12), (0x6d, 12), (0xda, 12), (0xdb, 12), (0x54, 12), (0x55, 12), (0x56, 12), (0x57, 12),
    (0x64, 12), (0x65, 12), (0x52, 12), (0x53, 12), (0x24, 12), (0x37, 12), (0x38, 12), (0x27, 12),
    (0x28, 12), (0x58, 12), (0x59, 12), (0x2b, 12), (0x2c, 12), (0x5a, 12), (0x66, 12), (0x67, 12),
    (0xf, 10), (0xc8, 12), (0xc9, 12), (0x5b, 12), (0x33, 12), (0x34, 12), (0x35, 12), (0x6c, 13),
    (0x6d, 13), (0x4a, 13), (0x4b, 13), (0x4c, 13), (0x4d, 13), (0x72, 13), (0x73, 13), (0x74, 13),
    (0x75, 13), (0x76, 13), (0x77, 13), (0x52, 13), (0x53, 13), (0x54, 13), (0x55, 13), (0x5a, 13),
    (0x5b, 13), (0x64, 13), (0x65, 13), (0x8, 11), (0xc, 11), (0xd, 11), (0x12, 12), (0x13, 12),
    (0x14, 12), (0x15, 12), (0x16, 12), (0x17, 12), (0x1c, 12), (0x1d, 12), (0x1e, 12), (0x1f, 12),
];

/// Bits from high to low.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    /// Bits not yet in bytes, fewer than 8, at the low end.
    rest: u32,
    count: u8,
}

impl Bits {
    /// Appends the `length` low bits of `code`, at most 13.
    fn put(&mut self, code: u16, length: u8) {
        self.rest = self.rest << length | u32::from(code);
        self.count += length;
        while self.count >= 8 {
            self.count -= 8;
            self.bytes.push((self.rest >> self.count) as u8);
        }
        self.rest &= (1 << self.count) - 1;
    }

    /// Appends a run of one colour.
    fn run(&mut self, black: bool, mut length: usize) {
        let codes = if black { &BLACK } else { &WHITE };
        let mut put = |(code, bits)| self.put(code, bits);
        while length > 2560 {
            put(codes[63 + 2560 / 64]);
            length -= 2560;
        }
        if length >= 64 {
            put(codes[63 + length / 64]);
        }
        put(codes[length % 64]);
    }

    fn finish(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.put(0, 8 - self.count);
        }
        self.bytes
    }
}
