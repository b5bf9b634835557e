//! DICOM: which images make the volume, and where its slices lie.
#![cfg(feature = "dicom")]

mod dicom_common;
mod volume_common;

use dicom_common::{
    DESCRIPTION, Form, INSTANCE, NUMBER, ORIENTATION, POSITION, SERIES, Set, firsts, folder, read_path,
    series, series_of, shared, slice,
};
use dotwork_io::checksum;
use dotwork_io::volume::{VolumeFormat, VolumeOptions, volume_format_of};
use dotwork_volume::{Scaling, Space, Unit};
use volume_common::{close, columns, fact, numbers, read_among};

#[test]
fn slices_are_sorted_by_position() {
    let slices: Vec<Set> = [2.0, -3.0, 7.0, 4.5, -0.5].iter().map(|&z| slice(z, (z * 10.0) as i16)).collect();
    let folder = series(&slices);
    assert_eq!(volume_format_of(folder.path(), &[]), Some(VolumeFormat::Dicom));
    let (file, warnings) = read_path(folder.path());
    let file = file.unwrap();
    assert_eq!(warnings, [""; 0]);
    assert_eq!(file.volume.dims(), [3, 2, 5]);
    assert_eq!(firsts(&file), [-30.0, -5.0, 20.0, 45.0, 70.0]);
    let expected = [[0.75, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 2.5], [10.0, 20.0, -3.0]];
    assert!(close(columns(&file), expected), "{:?}", columns(&file));
    let affine = file.volume.affine();
    assert_eq!((affine.space, affine.unit), (Space::Patient, Unit::Millimetre));
    assert_eq!(file.format, "folder of DICOM, explicit little endian");
    assert_eq!(fact(&file, "slices"), Some("5, 2.5 mm apart"));
    assert_eq!(fact(&file, "modality"), Some("CT"));
    let in_order: Vec<Vec<u8>> = [1, 4, 0, 3, 2].map(|i: usize| slices[i].file()).to_vec();
    assert_eq!(file.checksum, checksum(&in_order.concat()));
    // Nothing of the patient.
    assert!(!format!("{:?}{}", file.facts, file.format).contains("Doe"), "{:?}", file.facts);
    assert!(!format!("{:?}", file.facts).contains("SECRET"));
}

#[test]
fn an_oblique_stack_runs_along_its_normal() {
    // Coronal, seen from the front: rows to the left, columns down; the normal leads to the back.
    let at = |y: f64| {
        slice(0.0, y as i16).text(POSITION, "DS", &format!("1\\{y}\\5")).text(
            ORIENTATION,
            "DS",
            "1\\0\\0\\0\\0\\-1",
        )
    };
    let (file, warnings) = read_path(series(&[at(8.0), at(2.0), at(5.0)]).path());
    let file = file.unwrap();
    assert_eq!((warnings, firsts(&file)), (vec![], vec![2.0, 5.0, 8.0]));
    let expected = [[0.75, 0.0, 0.0], [0.0, 0.0, -0.5], [0.0, 3.0, 0.0], [1.0, 2.0, 5.0]];
    assert!(close(columns(&file), expected), "{:?}", columns(&file));
    assert!(!file.volume.affine().is_mirrored());
    assert_eq!(file.volume.affine().orientation(), Some(['L', 'I', 'P']));
}

#[test]
fn a_missing_slice_is_interpolated_and_said() {
    let slices: Vec<Set> = [0.0, 2.0, 6.0, 8.0, 10.0].iter().map(|&z| slice(z, z as i16 * 10)).collect();
    let (file, warnings) = read_path(series(&slices).path());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0]);
    assert_eq!(file.volume.spacing(), [0.75, 0.5, 2.0]);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].starts_with("slice is missing: interpolated between its neighbours (after "));
    assert_eq!(fact(&file, "missing slices"), Some("1"));
}

#[test]
fn uneven_slices_are_resampled_and_said() {
    // Samples are linear in z, so that interpolation gives them back.
    let z = [0.0, 2.0, 4.0, 7.0, 9.0, 11.0, 14.0];
    let slices: Vec<Set> = z.iter().map(|&z| slice(z, z as i16 * 100)).collect();
    let (file, warnings) = read_path(series(&slices).path());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [0.0, 200.0, 400.0, 600.0, 800.0, 1000.0, 1200.0, 1400.0]);
    assert_eq!(file.volume.spacing()[2], 2.0);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("vary from 2 to 3 mm: interpolated to even ones of 2 mm"), "{warnings:?}");
}

#[test]
fn a_gap_too_wide_ends_the_stack() {
    let z = [0.0, 50.0, 52.0, 54.0, 56.0];
    let slices: Vec<Set> = z.iter().map(|&z| slice(z, z as i16)).collect();
    let (file, warnings) = read_path(series(&slices).path());
    assert_eq!(firsts(&file.unwrap()), [50.0, 52.0, 54.0, 56.0]);
    let expected = "DICOM slices beyond a gap of 50 mm (where 2 mm is typical) left out (the gap after ";
    assert!(warnings.len() == 1 && warnings[0].starts_with(expected), "{warnings:?}");
}

#[test]
fn a_tilted_gantry_is_kept_as_shear() {
    // A gantry tilted by 15°: planes lean, while the table moves along z.
    let (sin, cos) = 15f64.to_radians().sin_cos();
    let at = |k: i16| {
        slice(0.0, k).text(POSITION, "DS", &format!("0\\0\\{}", 3 * k)).text(
            ORIENTATION,
            "DS",
            &format!("1\\0\\0\\0\\{cos:.9}\\{sin:.9}"),
        )
    };
    let (file, warnings) = read_path(series(&[at(2), at(0), at(1), at(3)]).path());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [0.0, 1.0, 2.0, 3.0]);
    let expected = [[0.75, 0.0, 0.0], [0.0, 0.5 * cos, 0.5 * sin], [0.0, 0.0, 3.0], [0.0; 3]];
    assert!(close(columns(&file), expected), "{:?}", columns(&file));
    assert!((file.volume.affine().shear_deg() - 15.0).abs() < 1e-3);
    let expected = "the slices are stacked 15.0° off their normal (a tilted gantry): kept as a sheared grid";
    assert_eq!(warnings, [expected]);
}

#[test]
fn of_several_series_one_is_read() {
    let other = |z: f64| {
        slice(z, 900).text(SERIES, "UI", "1.2.9").text(NUMBER, "IS", "7").text(
            DESCRIPTION,
            "LO",
            "Chest lung",
        )
    };
    let mut all: Vec<Set> = [0.0, 1.0, 2.0].iter().map(|&z| slice(z, z as i16)).collect();
    all.extend([other(0.0), other(2.0)]);
    let folder = series(&all);
    let (file, warnings) = read_path(folder.path());
    assert_eq!(firsts(&file.unwrap()), [0.0, 1.0, 2.0]);
    let expected =
        "of 2 DICOM series, CT 4 'head' (3 images) is read; not read: CT 7 'Chest lung' (2 images)";
    assert_eq!(warnings, [expected]);
    for name in ["1.2.9", "7", "chest LUNG"] {
        let (file, warnings) = series_of(folder.path(), name);
        assert_eq!(firsts(&file.unwrap()), [900.0, 900.0], "{name}");
        assert!(warnings[0].starts_with("of 2 DICOM series, CT 7 'Chest lung' (2 images) is read"));
    }
    let message = series_of(folder.path(), "spine").0.unwrap_err().to_string();
    let expected =
        "has no DICOM series 'spine'; there are: CT 4 'head' (3 images), CT 7 'Chest lung' (2 images)";
    assert!(message.ends_with(expected), "{message}");
}

#[test]
fn what_does_not_fit_is_left_out_and_said() {
    let mut all: Vec<Set> = [0.0, 1.0, 2.0].iter().map(|&z| slice(z, z as i16)).collect();
    all.push(slice(0.0, 7).text(ORIENTATION, "DS", "0\\1\\0\\0\\0\\-1"));
    all.push(slice(3.0, 7).short(0x0028_0010, 3).short(0x0028_0011, 2));
    all.push(slice(3.0, 7).short(0x0028_0103, 0));
    all.push(slice(3.0, 7).text(0x0028_0030, "DS", "1\\1"));
    all.push(slice(3.0, 7).without(POSITION));
    let (file, warnings) = read_path(series(&all).path());
    assert_eq!(firsts(&file.unwrap()), [0.0, 1.0, 2.0]);
    let mut what: Vec<&str> = warnings.iter().map(|w| w.split(" (").next().unwrap()).collect();
    what.sort_unstable();
    assert_eq!(
        what,
        [
            "DICOM images of another orientation left out",
            "DICOM images of another pixel spacing left out",
            "DICOM images of another size",
            "DICOM images of other samples",
            "DICOM images without a position left out",
        ]
    );
}

#[test]
fn of_slices_at_one_place_one_kind_is_taken() {
    // Two echoes, the second with one slice more; instance numbers alternate.
    let echo = |z: f64, echo: &str, first: i16| {
        slice(z, first).text(0x0018_0081, "DS", echo).text(INSTANCE, "IS", &format!("{}", first % 100))
    };
    let all = [
        echo(0.0, "30", 100),
        echo(0.0, "90", 201),
        echo(1.0, "30", 102),
        echo(1.0, "90", 203),
        echo(2.0, "90", 205),
    ];
    let (file, warnings) = read_path(series(&all).path());
    assert_eq!(firsts(&file.unwrap()), [201.0, 203.0, 205.0]);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].starts_with("2 DICOM slices at the places of others"), "{warnings:?}");
}

#[test]
fn files_that_are_no_slices_are_counted() {
    let report = Set::default().text(0x0008_0060, "CS", "SR").file();
    let whole = slice(2.0, 20).file();
    let unread = slice(3.0, 30).file_as(Form::Explicit, "1.2.840.10008.1.2.4.110");
    let folder = folder(&[
        ("a/1", slice(0.0, 0).file()),
        ("a/b/2", slice(1.0, 10).file()),
        ("a/3", whole.clone()),
        ("4", whole[..whole.len() - 3].to_vec()),
        ("5.dcm", unread),
        ("6.dcm", b"no DICOM at all, whatever its name says".to_vec()),
        ("notes.txt", b"x".to_vec()),
        ("more.txt", b"y".to_vec()),
        ("report", report),
        (".hidden", b"x".to_vec()),
        ("DICOMDIR", b"x".to_vec()),
    ]);
    let (file, warnings) = read_path(folder.path());
    assert_eq!(firsts(&file.unwrap()), [0.0, 10.0, 20.0]);
    assert_eq!(warnings.len(), 3, "{warnings:?}");
    assert_eq!(warnings[0], "2 files that are no DICOM skipped, first at more.txt");
    assert_eq!(warnings[1], "1 DICOM file without an image skipped (report)");
    assert!(warnings[2].starts_with("3 DICOM files that cannot be read skipped, first at 4: byte "));
    assert!(
        warnings[2].contains("the DICOM pixel data end too early: 9 of 12 bytes are there"),
        "{}",
        warnings[2]
    );
}

#[test]
fn a_folder_without_a_readable_image_says_why() {
    let unread = slice(3.0, 30).file_as(Form::Explicit, "1.2.840.10008.1.2.4.110");
    let error = read_path(folder(&[("x", unread)]).path()).0.unwrap_err().to_string();
    assert!(
        error.contains("x: is DICOM whose pixels are packed as JPEG XL (1.2.840.10008.1.2.4.110)"),
        "{error}"
    );
}

#[test]
fn images_without_a_place_are_in_order_of_their_numbers() {
    let at = |number: &str, first| {
        slice(0.0, first).without(POSITION).without(ORIENTATION).text(INSTANCE, "IS", number)
    };
    let (file, warnings) = read_path(series(&[at("10", 10), at("9", 9), at("11", 11)]).path());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [9.0, 10.0, 11.0]);
    assert_eq!(file.volume.affine().space, Space::Unknown);
    assert_eq!(
        warnings,
        ["the DICOM images have no position: in the order of their numbers, 9 mm apart assumed"]
    );
}

#[test]
fn a_directory_file_names_the_others() {
    let slices: Vec<Vec<u8>> = [2.0, 0.0, 1.0].iter().map(|&z| slice(z, z as i16).file()).collect();
    let record = |name: &str| Set::default().text(0x0004_1500, "CS", name);
    let records = ["D\\A", "D\\B", "D\\C", "D\\MISSING", "..\\SECRET", "D\\A", "D \\ A"].map(record).to_vec();
    let records = [vec![Set::default().text(0x0004_1430, "CS", "PATIENT")], records].concat();
    let directory = Set::default().items(0x0004_1220, records, false).file();
    let others: Vec<(&str, &[u8])> =
        ["D/A", "D/B", "D/C"].into_iter().zip(slices.iter().map(Vec::as_slice)).collect();
    let (file, warnings) = read_among("DICOMDIR", &directory, &others, &VolumeOptions::default());
    let file = file.unwrap();
    assert_eq!(firsts(&file), [0.0, 1.0, 2.0]);
    assert_eq!(file.format, "DICOMDIR of DICOM, explicit little endian");
    assert_eq!(
        file.checksum,
        checksum(&[&directory, &slices[1], &slices[2], &slices[0]].map(Vec::as_slice).concat())
    );
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("that cannot be read skipped (MISSING"), "{warnings:?}");
    let (none, _) = read_among("DICOMDIR", &directory, &[], &VolumeOptions::default());
    assert!(none.unwrap_err().to_string().contains("no such file"));
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn a_pet_series_is_in_slice_order() {
    let (file, warnings) = read_path(&shared("volumes/dicom_pet"));
    let file = file.unwrap();
    assert_eq!(warnings, [""; 0]);
    let volume = &file.volume;
    assert_eq!(volume.dims(), [128, 128, 28]);
    assert_eq!(volume.scaling(), Scaling { slope: 2.0222414, intercept: 0.0 });
    let place =
        [[3.5378182, 0.0, 0.0], [0.0, 3.5378182, 0.0], [0.0, 0.0, 3.375], [-226.13246, -425.88375, -344.834]];
    assert!(close(columns(&file), place), "{:?}", columns(&file));
    // Sums of the slices from the feet up, and two voxels, from pydicom.
    let samples = numbers(&file);
    let sums: Vec<f64> = samples.chunks(128 * 128).map(|s| s.iter().sum()).collect();
    let expected = [
        6802239, 7226221, 7805904, 8626292, 9671403, 10444708, 10785162, 10922592, 11073192, 11212815,
        11477950, 11959745, 12496494, 12869003, 12895706, 12538337, 12122395, 11696549, 11395949, 11241555,
        11329473, 11323046, 11123734, 10608101, 9873603, 9281195, 8769038, 8253815,
    ];
    assert_eq!(sums, expected.map(f64::from));
    assert_eq!(volume.value_at(64, 60, 5), 3925.0 * 2.0222414);
    assert_eq!(volume.value_at(50, 70, 20), 8571.0 * 2.0222414);
    assert_eq!(fact(&file, "modality"), Some("PT"));
    assert_eq!(fact(&file, "description"), Some("PET WB_0"));
    assert_eq!(fact(&file, "manufacturer"), Some("CPS 1023"));
    assert_eq!(volume.affine().orientation(), Some(['L', 'P', 'S']));
}

#[test]
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
fn a_study_of_many_series() {
    let folder = shared("volumes/dicom_tiny");
    let (file, warnings) = read_path(&folder);
    let file = file.unwrap();
    // Seven images of another series have seven orientations; five of this one make a stack.
    assert_eq!(file.volume.dims(), [16, 16, 5]);
    assert!(
        (file.volume.spacing()[2] - 2.5).abs() < 1e-9
            && (file.volume.affine().origin.z + 1.2375).abs() < 1e-9
    );
    assert_eq!(fact(&file, "description"), Some("SmartScore - Gated 0.5 sec"));
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let start = "of 13 DICOM series, CT 5 'SmartScore - Gated 0.5 sec' (5 images) is read; not read: ";
    assert!(warnings[0].starts_with(start), "{warnings:?}");
    assert!(warnings[0].contains("CT 2 'Routine Brain' (4 images), "), "{warnings:?}");
    let (directory, same_warnings) = read_path(&folder.join("DICOMDIR"));
    let directory = directory.unwrap();
    assert_eq!(directory.volume, file.volume);
    assert_eq!(same_warnings, warnings);

    let (brain, warnings) = series_of(&folder, "routine brain");
    assert_eq!(brain.unwrap().volume.dims(), [16, 16, 3]);
    assert!(
        warnings[1].contains("beyond a gap of 202.5 mm (where 1.25 mm is typical) left out"),
        "{warnings:?}"
    );
    let (angio, warnings) = series_of(&folder.join("DICOMDIR"), "700");
    assert_eq!(angio.unwrap().volume.dims(), [16, 16, 1]);
    assert!(warnings[1].starts_with("6 DICOM images of another orientation left out"), "{warnings:?}");
}
