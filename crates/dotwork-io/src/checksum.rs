//! XXH64 with seed 0: a fast 64-bit checksum (Yann Collet, "xxHash fast digest algorithm", specification 0.1.1).
//!
//! Four lanes each eat 8 of every 32 bytes by multiply, rotate, multiply; the lanes are merged, the tail is mixed in,
//! and an avalanche spreads the bits. It detects accidents, not forgery.

const P1: u64 = 0x9E37_79B1_85EB_CA87;
const P2: u64 = 0xC2B2_AE3D_27D4_EB4F;
const P3: u64 = 0x1656_67B1_9E37_79F9;
const P4: u64 = 0x85EB_CA77_C2B2_AE63;
const P5: u64 = 0x27D4_EB2F_1656_67C5;

/// The 64-bit checksum (XXH64, seed 0) of `bytes`: the same on every machine, used to recognise files.
pub fn checksum(bytes: &[u8]) -> u64 {
    let mut sum = Checksum::new();
    sum.update(bytes);
    sum.finish()
}

/// A checksum of bytes that come in pieces.
#[derive(Clone, Debug)]
pub(crate) struct Checksum {
    lanes: [u64; 4],
    /// The beginning of a stripe that is not complete yet.
    pending: [u8; 32],
    length: u64,
}

impl Checksum {
    pub(crate) fn new() -> Self {
        Checksum { lanes: [P1.wrapping_add(P2), P2, 0, 0u64.wrapping_sub(P1)], pending: [0; 32], length: 0 }
    }

    /// Adds `bytes` to what is summed.
    pub(crate) fn update(&mut self, mut bytes: &[u8]) {
        let held = (self.length % 32) as usize;
        self.length = self.length.wrapping_add(bytes.len() as u64);
        if held > 0 {
            let taken = bytes.len().min(32 - held);
            self.pending[held..held + taken].copy_from_slice(&bytes[..taken]);
            bytes = &bytes[taken..];
            if held + taken < 32 {
                return;
            }
            let stripe = self.pending;
            self.eat(&stripe);
        }
        let (stripes, tail) = bytes.as_chunks::<32>();
        for stripe in stripes {
            self.eat(stripe);
        }
        self.pending[..tail.len()].copy_from_slice(tail);
    }

    #[inline]
    fn eat(&mut self, stripe: &[u8; 32]) {
        let (words, _) = stripe.as_chunks::<8>();
        for (lane, word) in self.lanes.iter_mut().zip(words) {
            *lane = round(*lane, u64::from_le_bytes(*word));
        }
    }

    /// The checksum of everything so far.
    pub(crate) fn finish(&self) -> u64 {
        let mut hash = if self.length < 32 {
            P5
        } else {
            let [a, b, c, d] = self.lanes;
            let merged = a
                .rotate_left(1)
                .wrapping_add(b.rotate_left(7))
                .wrapping_add(c.rotate_left(12))
                .wrapping_add(d.rotate_left(18));
            self.lanes.iter().fold(merged, |h, &lane| (h ^ round(0, lane)).wrapping_mul(P1).wrapping_add(P4))
        };
        hash = hash.wrapping_add(self.length);

        let tail = &self.pending[..(self.length % 32) as usize];
        let (words, tail) = tail.as_chunks::<8>();
        for word in words {
            hash = (hash ^ round(0, u64::from_le_bytes(*word)))
                .rotate_left(27)
                .wrapping_mul(P1)
                .wrapping_add(P4);
        }
        let (halves, tail) = tail.as_chunks::<4>();
        for half in halves {
            let value = u64::from(u32::from_le_bytes(*half));
            hash = (hash ^ value.wrapping_mul(P1)).rotate_left(23).wrapping_mul(P2).wrapping_add(P3);
        }
        for &byte in tail {
            hash = (hash ^ u64::from(byte).wrapping_mul(P5)).rotate_left(11).wrapping_mul(P1);
        }

        hash = (hash ^ (hash >> 33)).wrapping_mul(P2);
        hash = (hash ^ (hash >> 29)).wrapping_mul(P3);
        hash ^ (hash >> 32)
    }
}

#[inline]
fn round(lane: u64, word: u64) -> u64 {
    lane.wrapping_add(word.wrapping_mul(P2)).rotate_left(31).wrapping_mul(P1)
}

#[cfg(test)]
mod tests {
    use super::{Checksum, checksum};

    /// The sanity buffer of the reference implementation's own tests.
    fn sanity_buffer(length: usize) -> Vec<u8> {
        let mut state: u64 = 2_654_435_761;
        (0..length)
            .map(|_| {
                let byte = (state >> 56) as u8;
                state = state.wrapping_mul(11_400_714_785_074_694_797);
                byte
            })
            .collect()
    }

    #[test]
    fn known_answers() {
        assert_eq!(checksum(b""), 0xEF46_DB37_51D8_E999);
        assert_eq!(checksum(b"a"), 0xD24E_C4F1_A98C_6E5B);
        assert_eq!(checksum(b"abc"), 0x44BC_2CF5_AD77_0999);
        assert_eq!(checksum(b"Nobody inspects the spammish repetition"), 0xFBCE_A83C_8A37_8BF1);
        for (length, expected) in [
            (1, 0xE934_A84A_DB05_2768),
            (4, 0x9136_A0DC_A574_57EE),
            (14, 0x8282_DCC4_994E_35C8),
            (222, 0xB641_AE8C_B691_C174),
        ] {
            assert_eq!(checksum(&sanity_buffer(length)), expected, "length {length}");
        }
    }

    #[test]
    fn pieces_sum_to_the_whole() {
        let bytes = sanity_buffer(222);
        for first in [0, 1, 31, 32, 33, 64, 150, 222] {
            for second in [0, 1, 15, 40] {
                let mut sum = Checksum::new();
                let (a, rest) = bytes.split_at(first);
                let (b, c) = rest.split_at(second.min(rest.len()));
                for piece in [a, b, c] {
                    sum.update(piece);
                }
                assert_eq!(sum.finish(), checksum(&bytes), "{first} + {second}");
            }
        }
    }
}
