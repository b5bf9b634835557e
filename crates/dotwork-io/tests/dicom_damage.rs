//! DICOM: what cannot be read is refused, and what is damaged gives volumes or errors, never a panic.
#![cfg(feature = "dicom")]

mod dicom_common;
#[path = "common/mutate.rs"]
mod mutate;
mod volume_common;

use dicom_common::{FRAMES, Form, PADDING, PIXELS, POSITION, Set, kept, read_path, shared, slice, words};
use dotwork_io::volume::VolumeOptions;
use volume_common::{reads_soundly, refusal};

#[test]
fn what_cannot_be_unpacked_is_refused_by_name() {
    let message = refusal("x.dcm", &kept("jpeg_ls.dcm"));
    assert!(message.contains("packed as JPEG-LS (1.2.840.10008.1.2.4.80), which is not read"), "{message}");
    for (uid, name) in [
        ("1.2.840.10008.1.2.4.100", "MPEG-2 video"),
        ("1.2.840.10008.1.2.4.110", "JPEG XL"),
        ("1.2.840.10008.1.2.4.201", "high-throughput JPEG 2000"),
        ("1.2.840.10008.1.2.4.55", "a retired kind of JPEG"),
        ("1.2.840.113619.5.2", "a private kind"),
        ("1.2.840.10008.1.2.77", "an unknown kind"),
    ] {
        let message = refusal("x.dcm", &slice(0.0, 0).file_as(Form::Explicit, uid));
        assert!(message.contains(&format!("packed as {name} ({uid})")), "{message}");
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
    // The stream alone lies.
    let mut stream_lies = kept("j2k_uint12.dcm");
    let stream = start_of_stream(&stream_lies);
    stream_lies[stream + 8..stream + 12].copy_from_slice(&60000u32.to_be_bytes());
    let message = refusal("x.dcm", &stream_lies);
    assert!(message.contains("JPEG 2000 data of 60000 x 36 pixels"), "{message}");
    // Sequences in sequences.
    let mut deep = Set::default();
    for _ in 0..2000 {
        deep = Set::default().items(0x0040_0275, vec![deep], true);
    }
    let message = refusal("x.dcm", &deep.file());
    assert!(message.contains("nested too deeply"), "{message}");
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
        "j2k_colour.dcm",
        "j2k_int16.dcm",
        "j2k_uint12.dcm",
        "jpeg_baseline_colour.dcm",
        "jpeg_baseline_frames.dcm",
        "jpeg_lossless_int16.dcm",
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
