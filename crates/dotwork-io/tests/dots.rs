//! The `.dots` container.

use std::path::Path;

use dotwork_drawing::hash::{hash2, unit};
use dotwork_io::checksum;
use dotwork_io::dots::{DotsError, Kind, MAGIC, Reader, Writer, is_dots, is_dots_file};

fn sample() -> Vec<u8> {
    let floats: Vec<f32> =
        (0..700).map(|i| unit(hash2(i, 1))).chain([f32::NAN, -0.0, f32::INFINITY]).collect();
    Writer::new()
        .text("style", "papers, größer")
        .section_f32("x", &floats)
        .section_u32("triangle", &[1, 2, u32::MAX])
        .section_u64("id", &[u64::MAX, 0])
        .section("options", vec![0, 255, 10])
        .section_f32("none", &[])
        .finish()
}

fn open(bytes: Vec<u8>) -> Result<Reader, DotsError> {
    Reader::from_bytes(Path::new("x.dots"), bytes)
}

fn refusal(bytes: &[u8]) -> String {
    open(bytes.to_vec()).expect_err("should be refused").to_string()
}

#[test]
fn everything_comes_back_bit_by_bit() {
    let reader = open(sample()).unwrap();
    assert_eq!(reader.names().collect::<Vec<_>>(), ["style", "x", "triangle", "id", "options", "none"]);
    assert_eq!(reader.text("style").unwrap(), "papers, größer");
    let floats = reader.f32s("x").unwrap();
    assert!(floats.len() == 703 && floats[700].is_nan() && floats[701].to_bits() == 1 << 31);
    assert!((0..700).all(|i| floats[i as usize] == unit(hash2(i, 1))));
    assert_eq!(reader.u32s("triangle").unwrap(), [1, 2, u32::MAX]);
    assert_eq!(reader.u64s("id").unwrap(), [u64::MAX, 0]);
    assert_eq!(reader.bytes("options").unwrap(), [0, 255, 10]);
    assert_eq!(reader.f32s("none").unwrap(), [0.0f32; 0]);
    assert_eq!(reader.describe("x").unwrap(), (Kind::F32, 703));
    assert!(reader.has("id") && !reader.has("ID"));
    assert_eq!(open(Writer::new().finish()).unwrap().names().count(), 0);
}

#[test]
fn files_are_recognised() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.dots");
    std::fs::write(&path, sample()).unwrap();
    assert!(is_dots_file(&path) && is_dots(&sample()));
    assert_eq!(Reader::open(&path).unwrap().u32s("triangle").unwrap(), [1, 2, u32::MAX]);
    std::fs::write(&path, &sample()[..7]).unwrap();
    assert!(!is_dots_file(&path) && !is_dots_file(&folder.path().join("no")) && !is_dots(b"ply\n"));
}

#[test]
fn what_is_asked_for_must_be_there() {
    let reader = open(sample()).unwrap();
    for (result, expected) in [
        (reader.text("title").map(drop), "has no section 'title'"),
        (reader.f32s("triangle").map(drop), "section 'triangle' holds u32, not f32"),
        (reader.bytes("style").map(drop), "section 'style' holds text, not bytes"),
        (reader.expect_length("id", 3), "section 'id' holds 2 elements, not 3"),
        (Err(reader.invalid("no stipples")), "is not valid: no stipples"),
    ] {
        assert_eq!(result.unwrap_err().to_string(), format!("x.dots: {expected}"));
    }
    reader.expect_length("id", 2).unwrap();
}

#[test]
fn any_truncation_and_any_flipped_byte_is_detected() {
    let bytes = sample();
    for cut in 0..bytes.len() {
        let message = refusal(&bytes[..cut]);
        let expected = if cut == 0 { "is not a .dots file" } else { "is truncated" };
        assert!(message.contains(expected), "{cut}: {message}");
    }
    for i in 0..bytes.len() {
        for bit in [1, 16, 128] {
            let mut flipped = bytes.clone();
            flipped[i] ^= bit;
            let message = refusal(&flipped);
            if i < 8 {
                assert_eq!(message, "x.dots: is not a .dots file");
            }
        }
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert_eq!(refusal(&longer), "x.dots: is not valid: 1 bytes follow the last section");
    let mut damaged = bytes.clone();
    *damaged.last_mut().unwrap() ^= 1;
    assert_eq!(refusal(&damaged), "x.dots: is damaged: the checksum of section 'options' does not match");
}

#[test]
fn other_files_and_versions() {
    let mut bytes = sample();
    bytes[8] = 9;
    assert_eq!(refusal(&bytes), "x.dots: is a .dots file of version 9; this dotwork reads version 1");
    assert_eq!(refusal(b"ply\nformat ascii 1.0\n"), "x.dots: is not a .dots file");
    assert_eq!(refusal(b""), "x.dots: is not a .dots file");
}

/// A file with one section whose table entry is as told, its checksums right.
fn forged(kind: u8, encoding: u8, raw: u64, stored: &[u8], count: u32) -> Vec<u8> {
    let mut table = vec![1, b'x', kind, encoding];
    table.extend(raw.to_le_bytes());
    table.extend((stored.len() as u64).to_le_bytes());
    table.extend(checksum(stored).to_le_bytes());
    let mut file = MAGIC.to_vec();
    file.extend(1u32.to_le_bytes());
    file.extend(count.to_le_bytes());
    file.extend((table.len() as u64).to_le_bytes());
    file.extend(table);
    let sum = checksum(&file);
    file.extend(sum.to_le_bytes());
    file.extend(stored);
    file
}

#[test]
fn forged_tables_are_refused_before_memory_is_taken() {
    let stream = |bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), bytes].concat();
    assert_eq!(open(forged(2, 0, 8, &stream(&[0; 8]), 1)).unwrap().f32s("x").unwrap(), [0.0, 0.0]);
    for (file, expected) in [
        (
            forged(2, 0, u64::MAX, &[0; 12], 1),
            "is not valid: section 'x': 18446744073709551615 bytes are not whole numbers of 4",
        ),
        (
            forged(0, 0, 1 << 40, &[0; 12], 1),
            "is not valid: section 'x': 12 stored bytes cannot hold 1099511627776",
        ),
        (forged(4, 1, 16, &[0; 12], 1), "is not valid: section 'x': 12 stored bytes cannot hold 16"),
        (
            forged(2, 0, 6, &stream(&[0; 6]), 1),
            "is not valid: section 'x': 6 bytes are not whole numbers of 4",
        ),
        (forged(9, 0, 8, &stream(&[0; 8]), 1), "is not valid: its table is broken"),
        (forged(2, 7, 8, &stream(&[0; 8]), 1), "is not valid: its table is broken"),
        (forged(2, 0, 8, &stream(&[0; 8]), u32::MAX), "is not valid: its table is broken"),
        (forged(2, 0, 8, &stream(&[0; 8]), 0), "is not valid: its table is longer than its sections"),
    ] {
        assert_eq!(refusal(&file), format!("x.dots: {expected}"));
    }
    for stored in [stream(&[1; 9]), stream(&[7; 7]), vec![255; 12], [stream(&[0; 8]), vec![0]].concat()] {
        let reader = open(forged(2, 0, 8, &stored, 1)).unwrap();
        assert!(reader.f32s("x").unwrap_err().to_string().starts_with("x.dots: is not valid: section 'x': "));
    }
    let text = open(forged(1, 0, 2, &stream(b"\xff\xfe"), 1)).unwrap();
    assert_eq!(text.text("x").unwrap_err().to_string(), "x.dots: is not valid: section 'x' is not UTF-8");
}

#[test]
fn mutations_do_not_panic() {
    let sample = sample();
    for seed in 0..3000u32 {
        let mut bytes = sample.clone();
        for k in 0..1 + hash2(0, seed) % 4 {
            // Half of them in the header and the table.
            let reach = if k % 2 == 0 { sample.len() } else { 200 };
            bytes[hash2(k + 1, seed) as usize % reach] = hash2(k + 9, seed) as u8;
        }
        if seed % 2 == 0 {
            // A forger repairs the table's checksum, to reach what lies behind it.
            let length = u64::from_le_bytes(bytes[16..24].try_into().unwrap());
            if let Some(end) = usize::try_from(length).ok().and_then(|n| n.checked_add(24))
                && end + 8 <= bytes.len()
            {
                let sum = checksum(&bytes[..end]);
                bytes[end..end + 8].copy_from_slice(&sum.to_le_bytes());
            }
        }
        if let Ok(reader) = open(bytes) {
            for name in reader.names() {
                let _ = (
                    reader.text(name),
                    reader.f32s(name),
                    reader.u32s(name),
                    reader.u64s(name),
                    reader.bytes(name),
                );
            }
        }
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let floats: Vec<f32> = (0..600_000).map(|i| unit(hash2(i, 1)) * 30.0).collect();
    let ids: Vec<u64> = (0..300_000).map(|i| u64::from(hash2(i, 2)) << 12).collect();
    let write = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Writer::new().section_f32("x", &floats).section_u64("id", &ids).finish())
    };
    let one = write(1);
    assert_eq!(one, write(4));
    let reader = open(one).unwrap();
    assert_eq!((reader.f32s("x").unwrap(), reader.u64s("id").unwrap()), (floats, ids));
}

#[test]
#[should_panic(expected = "written twice")]
fn a_name_is_used_once() {
    Writer::new().text("a", "").text("a", "");
}

/// Found by a hostile run: a table could declare a thousand times the file, and memory was taken for it.
#[test]
fn what_unpacks_to_a_hundred_times_its_size_is_refused() {
    let bytes = Writer::new().section("zeros", vec![0; 33 << 20]).finish();
    let message = refusal(&bytes);
    assert!(message.contains("unpacks to 34603008 bytes, more than the 32 MiB"), "{message}");
    let bytes = Writer::new().section("zeros", vec![0; 20 << 20]).finish();
    assert_eq!(open(bytes).unwrap().describe("zeros").unwrap(), (Kind::Bytes, 20 << 20));
}
