//! Mutations of files, a pure function of a seed: what transport, other programs and malice do to them.
//!
//! A fuzz binary may include this file (`#[path]`) and feed the results to any reader.

use dotwork_drawing::hash::hash2;

/// Numbers that no reader should believe.
const ABSURD: [&[u8]; 14] = [
    b"4294967295",
    b"2147483648",
    b"99999999999999999999",
    b"18446744073709551615",
    b"1000000000000",
    b"-1",
    b"0",
    b"65536",
    b"1e309",
    b"1e38",
    b"nan",
    b"\xff\xff\xff\xff",
    b"\xff\xff\xff\x7f",
    b"\0\0\0\x80",
];

/// One or several of: cut, bytes changed, a number made absurd, a piece repeated, removed or moved, a line doubled.
pub fn mutate(sample: &[u8], seed: u32) -> Vec<u8> {
    let mut bytes = sample.to_vec();
    // Mostly one: several at once seldom get past the header.
    let steps = 1 + hash2(0, seed) % 4 / 3;
    for step in 0..steps {
        if bytes.is_empty() {
            break;
        }
        mutate_once(&mut bytes, hash2(step + 1, seed));
    }
    bytes
}

fn mutate_once(bytes: &mut Vec<u8>, seed: u32) {
    let random = |k: u32| hash2(k, seed) as usize;
    let length = bytes.len();
    let (from, at) = (random(1) % length, random(2) % length);
    let near = length.min(from + 1 + random(3) % 40);
    match random(0) % 8 {
        0 => bytes.truncate(from),
        1 => {
            for k in 0..1 + random(4) as u32 % 6 {
                bytes[random(10 + k) % length] = random(20 + k) as u8;
            }
        }
        // A single bit.
        2 => bytes[from] ^= 1 << (random(4) % 8),
        // A number in text, whole or in part.
        3 | 4 => {
            let digits: Vec<usize> = (0..length).filter(|&i| bytes[i].is_ascii_digit()).collect();
            if let Some(&at) = digits.get(random(5) % digits.len().max(1)) {
                let run = bytes[at..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
                let end = if random(6) % 2 == 0 { at + run } else { at + 1 };
                bytes.splice(at..end, ABSURD[random(7) % ABSURD.len()].iter().copied());
            }
        }
        // Four bytes that may be a size.
        5 => {
            let absurd = [u32::MAX, 0x7fff_ffff, 0x8000_0000, 0x0100_0000, 0, length as u32][random(8) % 6];
            for (slot, byte) in bytes[from..].iter_mut().zip(absurd.to_le_bytes()) {
                *slot = byte;
            }
        }
        6 => {
            let piece = bytes[from..near].to_vec();
            bytes.splice(at..at, piece);
        }
        _ => {
            bytes.drain(from..near);
        }
    }
}
