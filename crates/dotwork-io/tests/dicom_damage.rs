//! DICOM: what cannot be read is refused, and what is damaged gives volumes or errors, never a panic.
#![cfg(feature = "dicom")]

mod dicom_common;
#[path = "common/mutate.rs"]
mod mutate;
mod volume_common;

use dicom_common::{FRAMES, Form, PADDING, PIXELS, POSITION, Set, kept, read_path, shared, slice, words};
use dotwork_drawing::hash::hash2;
use dotwork_io::volume::VolumeOptions;
use volume_common::{reads_soundly, refusal};

#[test]
fn what_cannot_be_unpacked_is_refused_by_name() {
    for (uid, name) in [
        ("1.2.840.10008.1.2.4.100", "MPEG-2 video"),
        ("1.2.840.10008.1.2.4.110", "JPEG XL"),
        ("1.2.840.10008.1.2.4.112", "JPEG XL"),
        ("1.2.840.10008.1.2.4.55", "a retired kind of JPEG"),
        ("1.2.840.113619.5.2", "a private kind"),
        ("1.2.840.10008.1.2.77", "an unknown kind"),
    ] {
        let message = refusal("x.dcm", &slice(0.0, 0).file_as(Form::Explicit, uid));
        assert!(message.contains(&format!("packed as {name} ({uid}), which is not read")), "{message}");
    }
}

/// Where the JPEG 2000 code stream of a file begins.
fn start_of_stream(file: &[u8]) -> usize {
    file.windows(4).position(|w| w == [0xff, 0x4f, 0xff, 0x51]).unwrap()
}

#[test]
fn declared_sizes_are_not_believed() {
    let huge = slice(0.0, 0).short(0x0028_0010, 65535).short(0x0028_0011, 65535);
    let message = refusal("x.dcm", &huge.file());
    assert!(
        message.contains("the DICOM pixel data end too early: 12 of 8589672450 bytes are there"),
        "{message}"
    );
    for frames in ["2000000000", "0", "-1", "1A", "99999999999999999999"] {
        let message = refusal("x.dcm", &slice(0.0, 0).text(FRAMES, "IS", frames).file());
        assert!(message.contains(&format!("with '{frames}' frames")), "{message}");
    }
    let message = refusal("x.dcm", &slice(0.0, 0).text(FRAMES, "IS", "60000").file());
    assert!(message.contains("end too early"), "{message}");
    // Packed: the header of the stream says what the data set says, and both lie. Of colours the samples are few
    // enough, and what their decoder takes is not.
    for (name, side) in [("j2k_uint12.dcm", 60_000u16), ("j2k_colour.dcm", 2300)] {
        let mut packed = kept(name);
        let rows = packed.windows(8).position(|w| w == [0x28, 0, 0x10, 0, b'U', b'S', 2, 0]).unwrap() + 8;
        packed[rows..rows + 2].copy_from_slice(&side.to_le_bytes());
        packed[rows + 10..rows + 12].copy_from_slice(&side.to_le_bytes());
        let stream = start_of_stream(&packed);
        for at in [8, 12, 24, 28] {
            packed[stream + at..stream + at + 4].copy_from_slice(&u32::from(side).to_be_bytes());
        }
        let message = refusal("x.dcm", &packed);
        assert!(message.contains("many times the size of its files"), "{name}: {message}");
    }
    // Found by hand: precincts of one pixel in a file of a kilobyte, for each of which a decoder takes memory.
    for name in ["j2k_uint12.dcm", "htj2k_int16.dcm"] {
        let mut fine = kept(name);
        let [rows, columns] = [0x10u8, 0x11].map(|element| {
            fine.windows(8).position(|w| w == [0x28, 0, element, 0, b'U', b'S', 2, 0]).unwrap() + 8
        });
        let stream = start_of_stream(&fine);
        for at in [rows, columns] {
            fine[at..at + 2].copy_from_slice(&1400u16.to_le_bytes());
        }
        for at in [8, 12, 24, 28] {
            fine[stream + at..stream + at + 4].copy_from_slice(&1400u32.to_be_bytes());
        }
        // The style of coding, with sizes of precincts in place of what follows it.
        let style = stream + fine[stream..].windows(2).position(|w| w == [0xff, 0x52]).unwrap();
        let levels = fine[style + 9];
        fine[style + 3] = 13 + levels;
        fine[style + 4] |= 1;
        fine[style + 14..][..1 + usize::from(levels)].fill(0);
        let message = refusal("x.dcm", &fine);
        assert_eq!(message, "x.dcm: DICOM frame 1: JPEG 2000 data with more precincts than bytes");
    }
    // The stream alone lies: of its width, its components, its bits.
    for name in ["j2k_uint12.dcm", "htj2k_int16.dcm"] {
        for (at, bytes, reason) in [
            (8, &60000u32.to_be_bytes()[..], "JPEG 2000 data of 60000 x 36 pixels"),
            (41, &[3], "JPEG 2000 data of 40 x 36 pixels with 3 samples, where 40 x 36 with 1 are declared"),
            (42, &[19], "JPEG 2000 data of 20 bits, where"),
        ] {
            let mut stream_lies = kept(name);
            let at = start_of_stream(&stream_lies) + at;
            stream_lies[at..at + bytes.len()].copy_from_slice(bytes);
            let message = refusal("x.dcm", &stream_lies);
            assert!(message.starts_with("x.dcm: DICOM frame 1: ") && message.contains(reason), "{message}");
        }
    }
    // Sequences in sequences.
    let mut deep = Set::default();
    for _ in 0..2000 {
        deep = Set::default().items(0x0040_0275, vec![deep], true);
    }
    let message = refusal("x.dcm", &deep.file());
    assert!(message.contains("nested too deeply"), "{message}");
}

/// A file with its JPEG-LS stream changed; its frame header begins at byte 2.
fn with_stream(name: &str, change: impl Fn(&mut [u8])) -> Vec<u8> {
    let mut file = kept(name);
    let start = file.windows(4).position(|w| w == [0xff, 0xd8, 0xff, 0xf7]).unwrap();
    change(&mut file[start..]);
    file
}

#[test]
fn jpeg_ls_streams_that_lie_are_refused() {
    // Where in a stream which bytes make it say what.
    let cases: [(&str, usize, &[u8], &str); 14] = [
        ("jpeg_ls.dcm", 7, &[0xff, 0xff, 0xff, 0xff], "data of 65535 x 65535 pixels with 1 samples"),
        ("jpeg_ls.dcm", 8, &[37], "of 40 x 37 pixels with 1 samples, where 40 x 36 with 1"),
        ("jpeg_ls.dcm", 6, &[12], "JPEG-LS data of 12 bits, where 8 of 8 are declared"),
        ("jpeg_ls.dcm", 6, &[1], "JPEG-LS data of 1 bits"),
        ("jls_int16.dcm", 6, &[12], "JPEG-LS data of 12 bits, where 16 of 16 are declared"),
        ("jpeg_ls.dcm", 11, &[3], "of 40 x 36 pixels with 3 samples, where 40 x 36 with 1"),
        ("jls_colour.dcm", 11, &[1], "of 40 x 36 pixels with 1 samples, where 40 x 36 with 3"),
        ("jls_colour.dcm", 16, &[0x21], "components of different resolution, which is not read"),
        ("jpeg_ls.dcm", 3, &[0xc0], "JPEG of another kind (marker c0) where JPEG-LS is declared"),
        ("jls_int16.dcm", 0, &[0; 4], "JPEG-LS data without their mark"),
        ("jpeg_ls.dcm", 22, &[200], "JPEG-LS data with parameters that contradict each other"),
        ("jpeg_ls.dcm", 23, &[7; 2], "JPEG-LS with a point transform, which is not read"),
        ("jpeg_ls.dcm", 21, &[1], "JPEG-LS with a mapping table, which is not read"),
        ("jpeg_ls.dcm", 40, &[0xff, 0xd9], "the JPEG-LS data end too early"),
    ];
    for (name, at, bytes, reason) in cases {
        let message =
            refusal("x.dcm", &with_stream(name, |s| s[at..at + bytes.len()].copy_from_slice(bytes)));
        assert!(message.starts_with("x.dcm: DICOM frame 1: "), "{message}");
        assert!(message.contains(reason) && !message.contains('\n'), "{message}");
    }
    // Noise or nothing instead of samples.
    let with_samples = |name: &str, sample: &dyn Fn(usize) -> u8| {
        with_stream(name, |s| {
            let scan = s.windows(2).position(|w| w == [0xff, 0xda]).unwrap();
            let (start, end) = (scan + 2 + usize::from(s[scan + 3]), s.len() - 8);
            s[start..end].iter_mut().enumerate().for_each(|(i, b)| *b = sample(i));
        })
    };
    let names = ["jpeg_ls.dcm", "jls_int16.dcm", "jls_near_uint12.dcm", "jls_colour.dcm"];
    for name in names {
        for seed in 0..200 {
            sound(name, &with_samples(name, &|i| (hash2(i as u32, seed) >> 9) as u8));
        }
        let message = refusal("x.dcm", &with_samples(name, &|_| 0));
        assert_eq!(message, "x.dcm: DICOM frame 1: the JPEG-LS data are damaged");
    }
    // Both headers lie, and a run would fill any size with few bytes.
    let mut packed = kept("jpeg_ls.dcm");
    let rows = packed.windows(8).position(|w| w == [0x28, 0, 0x10, 0, b'U', b'S', 2, 0]).unwrap() + 8;
    for at in [rows, rows + 10] {
        packed[at..at + 2].copy_from_slice(&u16::MAX.to_le_bytes());
    }
    let message = refusal("x.dcm", &packed);
    assert!(message.contains("many times the size of its files"), "{message}");
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn malformed_files_are_refused() {
    for (name, reason) in [
        ("mr_truncated.dcm", "the DICOM pixel data end too early: 8130 of 8192 bytes are there"),
        ("badvr.dcm", "is DICOM with '1A' frames"),
        ("meta_missing_tsyntax.dcm", "is DICOM whose image has 0 x 0 pixels"),
        ("no_meta_group_length.dcm", "is DICOM without an image"),
    ] {
        let error = read_path(&shared("malformed/volume").join(name)).0.unwrap_err().to_string();
        assert!(error.contains(reason) && !error.contains('\n'), "{error}");
    }
    // A folder of nothing else says why the first of them cannot be read.
    let error = read_path(&shared("malformed/volume")).0.unwrap_err().to_string();
    assert!(error.contains("badvr.dcm: is DICOM with '1A' frames"), "{error}");
}

/// A name and the bytes of a small file of each kind.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let one = slice(4.0, -2);
    let group = |z: f64| {
        let place = Set::default().text(POSITION, "DS", &format!("0\\0\\{z}"));
        Set::default().items(0x0020_9113, vec![place], true)
    };
    let enhanced = one
        .clone()
        .text(FRAMES, "IS", "4")
        .items(0x5200_9230, [0.0, 1.0, 3.0, 2.5].map(group).to_vec(), true)
        .put(PIXELS, "OW", words(&(0..24).collect::<Vec<_>>()))
        .put(PADDING, "SS", words(&[3]));
    let mut samples = vec![
        ("explicit", one.file()),
        ("implicit", one.file_as(Form::Implicit, "1.2.840.10008.1.2")),
        ("big", one.file_as(Form::BigEndian, "1.2.840.10008.1.2.2")),
        ("enhanced", enhanced.file()),
        ("enhanced implicit", enhanced.file_as(Form::Implicit, "1.2.840.10008.1.2")),
        ("bare.dcm", one.bytes(Form::Implicit)),
    ];
    for name in [
        "deflated_int16.dcm",
        "htj2k_colour.dcm",
        "htj2k_int16.dcm",
        "htj2k_lossy_uint8.dcm",
        "j2k_colour.dcm",
        "j2k_int16.dcm",
        "j2k_uint12.dcm",
        "jls_colour.dcm",
        "jls_colour_lines.dcm",
        "jls_frames_uint10.dcm",
        "jls_int16.dcm",
        "jls_near_uint12.dcm",
        "jls_restarts_uint10.dcm",
        "jpeg_baseline_colour.dcm",
        "jpeg_baseline_frames.dcm",
        "jpeg_lossless_int16.dcm",
        "jpeg_ls.dcm",
        "rle_colour.dcm",
    ] {
        samples.push((name, kept(name)));
    }
    samples
}

fn sound(name: &str, bytes: &[u8]) -> bool {
    reads_soundly(name, bytes, &[], &VolumeOptions::default())
}

#[test]
fn damaged_files_give_volumes_or_errors() {
    let (mut refused, mut total) = (0, 0);
    for (name, bytes) in samples() {
        for seed in 0..1500 {
            refused += usize::from(!sound(name, &mutate::mutate(&bytes, seed)));
            total += 1;
        }
        // The pixels alone, which most mutations miss or never reach.
        let start = bytes.windows(4).position(|w| w == [0xe0, 0x7f, 0x10, 0]).unwrap_or(0);
        for seed in 0..1500 {
            let mutant = [&bytes[..start], &mutate::mutate(&bytes[start..], seed)].concat();
            sound(name, &mutant);
        }
    }
    // The harness does something: many mutants are refused, and many are not.
    assert!(refused > total / 10 && refused < total * 9 / 10, "{refused} of {total}");
}

#[test]
fn files_cut_anywhere_are_refused() {
    for (name, bytes) in samples() {
        for end in (0..bytes.len()).step_by(1 + bytes.len() / 400) {
            let read = sound(name, &bytes[..end]);
            // Packed streams may end before their file does, and decoders forgive much.
            assert!(!read || !matches!(name, "explicit" | "implicit" | "big" | "enhanced"), "{name} {end}");
        }
    }
}
