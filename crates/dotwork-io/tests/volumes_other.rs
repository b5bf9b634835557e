//! MetaImage, VTK and raw volumes that the tests make, and how formats are told apart.
#![cfg(all(feature = "metaimage", feature = "vtk"))]

mod volume_common;

use std::path::Path;

use dotwork_io::volume::{RawLayout, VolumeFormat, VolumeOptions, volume_format_of};
use dotwork_volume::{SampleType, Scaling, Space, Unit};
use volume_common::{
    columns, counting, fact, gzip, int16, numbers, read, read_among, read_quietly, refusal, refusal_among,
    refused_with, zlib,
};

/// 2 x 3 x 4 int16 in MetaImage, with further lines before the last one.
fn mha(fields: &str, file: &str, data: &[u8]) -> Vec<u8> {
    let header = format!(
        "ObjectType = Image\nNDims = 3\n{fields}DimSize = 2 3 4\nElementType = MET_SHORT\nElementDataFile = {file}\n"
    );
    [header.as_bytes(), data].concat()
}

const SPACED: &str = "ElementSpacing = 1 2 3\n";

#[test]
fn metaimages_attached_detached_and_packed() {
    let data = int16(false);
    let text: Vec<String> = (0..24).map(|i| i.to_string()).collect();
    for (fields, data) in [
        ("", data.clone()),
        ("BinaryDataByteOrderMSB = True\n", int16(true)),
        ("ElementByteOrderMSB = True\n", int16(true)),
        ("CompressedData = True\n", zlib(&data)),
        ("CompressedData = True\n", gzip(&data)),
        ("BinaryData = False\n", text.join(" ").into_bytes()),
        ("HeaderSize = -1\n", [b"junk", &data[..]].concat()),
    ] {
        let file = read_quietly("a.mha", &mha(&format!("{SPACED}{fields}"), "LOCAL", &data));
        assert_eq!(numbers(&file), counting(), "{fields}");
        assert_eq!(file.volume.affine().spacing(), [1.0, 2.0, 3.0]);
    }
    let options = VolumeOptions::default();
    let slices: Vec<&[u8]> = data.chunks(12).collect();
    let packed = zlib(&data);
    let headed = [b"headr", &data[..]].concat();
    let four = [("d/s1", slices[0]), ("d/s2", slices[1]), ("d/s3", slices[2]), ("d/s4", slices[3])];
    for (fields, file, others) in [
        ("", "a b.raw", &[("d/a b.raw", &data[..])][..]),
        ("CompressedData = True\n", "a.zraw", &[("d/a.zraw", &packed[..])]),
        ("HeaderSize = 5\n", "a.raw", &[("d/a.raw", &headed[..])]),
        ("HeaderSize = -1\n", "a.raw", &[("d/a.raw", &headed[..])]),
        ("", "LIST\ns1\ns2\ns3\ns4", &four),
        ("", "LIST 2D\ns1\ns2\ns3\ns4", &four),
        ("", "s%d 1 4 1", &four),
    ] {
        let bytes = mha(&format!("{SPACED}{fields}"), file, b"");
        let (read, warnings) = read_among("d/a.mhd", &bytes, others, &options);
        assert_eq!(numbers(&read.unwrap_or_else(|e| panic!("{e}"))), counting(), "{file}");
        assert_eq!(warnings, [""; 0]);
    }
    let message = refusal_among("d/a.mhd", &mha(SPACED, "no.raw", b""), &four);
    assert_eq!(message, "d/a.mhd: data file d/no.raw: no such file");
}

#[test]
fn metaimages_lie_where_simpleitk_puts_them() {
    // Expected: SimpleITK 2.5; the rows of the file's matrix are the directions of the axes.
    let turned = "TransformMatrix = 0 1 0 0 0 1 1 0 0\nOffset = 1 2 3\nElementSpacing = 2 3 4\n";
    let expected = [[0.0, 2.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 0.0], [1.0, 2.0, 3.0]];
    for (fields, columns_expected, space, unit) in [
        (turned.to_string(), expected, Space::Patient, Unit::Unknown),
        (
            turned.replace("TransformMatrix", "Rotation").replace("Offset", "Position"),
            expected,
            Space::Patient,
            Unit::Unknown,
        ),
        (format!("{turned}DistanceUnits = um\n"), expected, Space::Patient, Unit::Micrometre),
        (
            "ElementSize = 2 3 4\nOrigin = 1 2 3\n".into(),
            [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0], [1.0, 2.0, 3.0]],
            Space::Unknown,
            Unit::Unknown,
        ),
        (
            "ElementSpacing = 2 3 4\nDistanceUnits = cm\n".into(),
            [[20.0, 0.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, 40.0], [0.0; 3]],
            Space::Unknown,
            Unit::Millimetre,
        ),
        // Letters name where an axis comes from.
        (
            "ElementSpacing = 2 3 4\nAnatomicalOrientation = PIR\n".into(),
            [[0.0, -2.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 0.0], [0.0; 3]],
            Space::Patient,
            Unit::Unknown,
        ),
        (
            "ElementSpacing = 2 3 -4\nAnatomicalOrientation = ???\n".into(),
            [[2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, -4.0], [0.0; 3]],
            Space::Unknown,
            Unit::Unknown,
        ),
    ] {
        let file = read_quietly("a.mha", &mha(&fields, "LOCAL", &int16(false)));
        assert_eq!(columns(&file), columns_expected, "{fields}");
        assert_eq!((file.volume.affine().space, file.volume.affine().unit), (space, unit), "{fields}");
    }
}

#[test]
fn metaimages_of_other_dimensions_and_channels() {
    let bytes: Vec<u8> = (0..24).collect();
    let file = |fields: &str| {
        [fields.as_bytes(), b"ElementType = MET_UCHAR\nElementDataFile = LOCAL\n", &bytes[..]].concat()
    };
    let (two, warnings) = read(
        "a.mha",
        &file("NDims = 2\nDimSize = 6 4\nElementSpacing = 2 3\nTransformMatrix = 0 1 1 0\nOffset = 5 6\n"),
    );
    assert_eq!(two.volume.dims(), [6, 4, 1]);
    assert_eq!(columns(&two), [[0.0, 2.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.0, -1.0], [5.0, 6.0, 0.0]]);
    assert_eq!(warnings, [""; 0]);
    let (four, warnings) = read("a.mha", &file("NDims = 4\nDimSize = 2 3 2 2\nElementSpacing = 1 1 1 9\n"));
    assert_eq!(four.volume.dims(), [2, 3, 2]);
    assert_eq!(warnings, ["the first of 2 volumes is taken"]);
    assert_eq!(fact(&four, "axes"), Some("2 x 3 x 2 x 2"));
    let rgb = "NDims = 3\nDimSize = 2 2 2\nElementSpacing = 1 1 1\nElementNumberOfChannels = 3\n";
    let (rgb, warnings) = read("a.mha", &file(rgb));
    assert_eq!(numbers(&rgb), [1.0, 4.0, 7.0, 10.0, 13.0, 16.0, 19.0, 22.0]);
    assert_eq!(warnings, ["3 colours a voxel: their luminance is taken"]);
    let vector = "NDims = 3\nDimSize = 2 3 2\nElementSpacing = 1 1 1\nElementNumberOfChannels = 2\n";
    let (vector, warnings) = read("a.mha", &file(vector));
    assert_eq!(numbers(&vector), (0..12).map(|i| f64::from(2 * i)).collect::<Vec<_>>());
    assert_eq!(warnings, ["2 values a voxel: the first is taken"]);
    let fields =
        format!("{SPACED}ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -3\n");
    let scaled = read_quietly("a.mha", &mha(&fields, "LOCAL", &int16(false)));
    assert_eq!(scaled.volume.scaling(), Scaling { slope: 2.0, intercept: -3.0 });
}

#[test]
fn metaimages_that_break_the_rules_are_refused() {
    let cases = [
        ("MET_SHORT", "MET_STRING", "line 5: ElementType: samples of type 'MET_STRING' are not read"),
        ("NDims = 3", "NDims = 0", "line 2: NDims: '0' is no number of axes"),
        ("NDims = 3", "NDims = 2", "line 6: 3 sizes for 2 axes"),
        ("DimSize = 2 3 4\n", "", "line 5: the header has no DimSize"),
        ("DimSize = 2 3 4", "DimSize = 2 0 4", "line 4: DimSize: '2 0 4' are no sizes"),
        ("NDims = 3", "HeaderSize = 9", "line 6: HeaderSize 9 is no place after the header"),
        ("NDims = 3", "HeaderSize = -2", "line 2: HeaderSize: -2; -1 and more are allowed"),
        ("NDims = 3", "junk", "line 2: 'junk' is not 'Key = value'"),
        (
            "NDims = 3",
            "CompressedData = perhaps",
            "line 2: CompressedData: 'perhaps' is neither True nor False",
        ),
        ("DimSize = 2 3 4", "DimSize = 9999999999 9999999999 4", "declares more samples than can be counted"),
    ];
    refused_with("a.mha", &mha(SPACED, "LOCAL", &int16(false)), &cases);
    let message = refusal("a.mha", b"NDims = 3\nDimSize = 2 3 4\n");
    assert_eq!(message, "a.mha: line 2: the header has no ElementDataFile");
}

/// A legacy VTK file of 2 x 3 x 4 points.
fn vtk(kind: &str, attributes: &str, data: &[u8]) -> Vec<u8> {
    let header = format!(
        "# vtk DataFile Version 3.0\na test\n{kind}\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 3 4\nORIGIN 10 20 30\n\
         SPACING 1 2 3\n{attributes}"
    );
    [header.as_bytes(), data].concat()
}

#[test]
fn vtk_arrays_in_text_and_binary() {
    let text: Vec<String> = (0..24).map(|i| i.to_string()).collect();
    let text = text.join("\n");
    let bytes: Vec<u8> = (0..24).collect();
    let floats: Vec<u8> = (0..24u8).flat_map(|i| f32::from(i).to_be_bytes()).collect();
    let longs: Vec<u8> = (0..24i64).flat_map(i64::to_be_bytes).collect();
    for (kind, attributes, data, sample) in [
        ("ASCII", "POINT_DATA 24\nSCALARS a float\nLOOKUP_TABLE default\n", text.as_bytes(), SampleType::F32),
        (
            "ASCII",
            "\nPOINT_DATA 24\nSCALARS a int 1\nLOOKUP_TABLE default\n",
            text.as_bytes(),
            SampleType::I32,
        ),
        (
            "ASCII",
            "POINT_DATA 24\nFIELD FieldData 1\na 1 24 unsigned_short\n",
            text.as_bytes(),
            SampleType::U16,
        ),
        ("BINARY", "POINT_DATA 24\nSCALARS a unsigned_char\nLOOKUP_TABLE default\n", &bytes, SampleType::U8),
        ("binary", "POINT_DATA 24\nSCALARS a short\nLOOKUP_TABLE default\n", &int16(true), SampleType::I16),
        ("BINARY", "POINT_DATA 24\nSCALARS a float\n", &floats, SampleType::F32),
        ("BINARY", "POINT_DATA 24\nFIELD FieldData 1\na 1 24 vtktypeint64\n", &longs, SampleType::I64),
    ] {
        let file = read_quietly("a.vtk", &vtk(kind, attributes, data));
        assert_eq!(file.volume.dims(), [2, 3, 4]);
        assert_eq!(file.volume.samples().sample_type(), sample);
        assert_eq!(numbers(&file), counting(), "{kind} {attributes}");
        assert_eq!(columns(&file), [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0], [10.0, 20.0, 30.0]]);
        assert_eq!(fact(&file, "array"), Some("a"));
        assert_eq!(fact(&file, "title"), Some("a test"));
    }
}

#[test]
fn vtk_cells_colours_and_further_arrays() {
    let cells = "CELL_DATA 6\nSCALARS a unsigned_char\nLOOKUP_TABLE default\n";
    let file = read_quietly("a.vtk", &vtk("BINARY", cells, &[0, 1, 2, 3, 4, 5]));
    assert_eq!(file.volume.dims(), [1, 2, 3]);
    assert_eq!(file.volume.affine().origin.to_array(), [10.5, 21.0, 31.5]);

    // The cells of a flat grid lie in its plane.
    let flat = vtk("BINARY", "CELL_DATA 2\nSCALARS a unsigned_char\nLOOKUP_TABLE default\n", &[7, 8]);
    let flat = String::from_utf8(flat).unwrap().replace("DIMENSIONS 2 3 4", "DIMENSIONS 2 3 1");
    let file = read_quietly("a.vtk", flat.as_bytes());
    assert_eq!(file.volume.dims(), [1, 2, 1]);
    assert_eq!(file.volume.affine().origin.to_array(), [10.5, 21.0, 30.0]);

    let rgb: Vec<u8> = (0..72).collect();
    let colours = "POINT_DATA 24\nCOLOR_SCALARS c 3\n";
    let (file, warnings) = read("a.vtk", &vtk("BINARY", colours, &rgb));
    assert_eq!(numbers(&file)[..3], [1.0, 4.0, 7.0]);
    assert_eq!(warnings, ["3 colours a voxel: their luminance is taken"]);

    let first = "POINT_DATA 24\nSCALARS a%20b unsigned_char\nLOOKUP_TABLE default\n";
    let more =
        [&(0..24).collect::<Vec<u8>>()[..], b"\nMETADATA\nINFORMATION 0\n\nSCALARS second char\n"].concat();
    let (file, warnings) = read("a.vtk", &vtk("BINARY", first, &more));
    assert_eq!(numbers(&file), counting());
    assert_eq!(warnings, ["the file holds several arrays: the first, 'a b', is taken"]);
    let vectors = "POINT_DATA 24\nVECTORS v unsigned_char\n";
    let (file, warnings) = read("a.vtk", &vtk("BINARY", vectors, &rgb));
    assert_eq!(numbers(&file)[..3], [0.0, 3.0, 6.0]);
    assert_eq!(warnings, ["3 values a voxel: the first is taken"]);
}

#[test]
fn a_vtk_field_before_the_points_is_passed_over() {
    let text: Vec<String> = (0..24).map(|i| i.to_string()).collect();
    let about = "METADATA\nINFORMATION 1\nNAME UNITS LOCATION vtkDataArray\nDATA s\n\n";
    let with = |kind: &str, field: &[u8], data: &[u8]| {
        let file = vtk(kind, "POINT_DATA 24\nSCALARS a unsigned_char\nLOOKUP_TABLE default\n", data);
        let at = file.windows(10).position(|w| w == b"DIMENSIONS").unwrap();
        [&file[..at], field, &file[at..]].concat()
    };
    let ascii =
        format!("FIELD FieldData 2\nTIME 1 1 double\n0.5\n{about}step 2 3 int\n1 2 3\n4 5 6\n{about}");
    let file = read_quietly("a.vtk", &with("ASCII", ascii.as_bytes(), text.join(" ").as_bytes()));
    assert_eq!(numbers(&file), counting());
    let binary = [
        b"FIELD FieldData 2\nTIME 1 1 double\n",
        // Bytes that look like line ends and words are values.
        &b"\nORIGIN\n"[..],
        format!("\n{about}step 1 2 short\n").as_bytes(),
        &[10, 10, 10, 10, 10],
    ]
    .concat();
    let bytes: Vec<u8> = (0..24).collect();
    let file = read_quietly("a.vtk", &with("BINARY", &binary, &bytes));
    assert_eq!(numbers(&file), counting());
    assert_eq!(file.volume.affine().origin.to_array(), [10.0, 20.0, 30.0]);

    for (field, reason) in [
        ("FIELD f 1\nname 1 1 string\nabc\n", "line 6: arrays of type string are not read"),
        ("FIELD f 1\na 99 9999999 int\n1\n", "line 6: a field of 989999901 values, which are not there"),
        ("FIELD f 99999999999\n", "line 6: '4' is no sample type of VTK"),
    ] {
        let message = refusal("a.vtk", &with("ASCII", field.as_bytes(), text.join(" ").as_bytes()));
        assert_eq!(message, format!("a.vtk: {reason}"));
    }
}

#[test]
fn other_vtk_files_are_refused_by_name() {
    let points = "POINT_DATA 24\nSCALARS a unsigned_char\nLOOKUP_TABLE default\n";
    let cases = [
        (
            "STRUCTURED_POINTS",
            "POLYDATA",
            "line 4: holds POLYDATA, a mesh; of VTK's data sets only STRUCTURED_POINTS are read",
        ),
        (
            "STRUCTURED_POINTS",
            "RECTILINEAR_GRID",
            "line 4: holds a RECTILINEAR_GRID; of VTK's data sets only STRUCTURED_POINTS are read",
        ),
        ("BINARY", "BINAR", "line 3: 'BINAR' is neither ASCII nor BINARY"),
        ("POINT_DATA 24", "POINT_DATA 25", "line 8: 25 values for 2 x 3 x 4 voxels"),
        ("DIMENSIONS 2 3 4", "DIMENSIONS 2 3", "line 5: '' is not the number expected"),
        ("DIMENSIONS 2 3 4", "DIMENSIONS 2 0 4", "line 5: a side of 0"),
        ("unsigned_char", "bit", "line 9: samples of 1 bit are not read"),
        ("unsigned_char", "str", "line 9: 'str' is no sample type of VTK"),
        ("SCALARS a", "TENSORS a", "line 9: begins with 'TENSORS', of which no volume is made"),
        (
            "unsigned_char",
            "double",
            "byte 190: the data end too early: 24 of 192 bytes are there (3 of 24 float64 samples)",
        ),
    ];
    refused_with("a.vtk", &vtk("BINARY", points, &[7; 24]), &cases);
    let xml = b"<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"0.1\">\n";
    assert!(refusal("a.vti", xml).starts_with("a.vti: is an XML file of VTK (.vti), which is not read"));
}

#[test]
fn raw_samples_must_fit() {
    let read_raw = |layout: &str, bytes: &[u8]| {
        let raw: RawLayout = layout.parse().unwrap();
        let (read, warnings) =
            read_among("a.raw", bytes, &[], &VolumeOptions { raw: Some(raw), ..VolumeOptions::default() });
        assert_eq!(warnings, [""; 0]);
        read.map_err(|e| e.to_string())
    };
    let data = int16(true);
    let file = read_raw("2x3x4:i16:be:0.5,1,2", &data).unwrap();
    assert_eq!(numbers(&file), counting());
    assert_eq!(file.format, "raw by option, big endian");
    let headed = [b"header", &data[..]].concat();
    assert_eq!(read_raw("2x3x4:i16:be:header=6:0.5,1,2", &headed).unwrap().volume, file.volume);
    assert_eq!(read_raw("2x3x4:i16:be:0.5,1,2", &gzip(&data)).unwrap().volume, file.volume);

    for (layout, there, reason) in [
        (
            "2x3x4:i16",
            60,
            "holds 60 bytes, but 2x3x4:i16:le needs 48; its size would allow header=12, or 5 slices of 2x3",
        ),
        (
            "2x3x4:i16",
            24,
            "holds 24 bytes, but 2x3x4:i16:le needs 48; its size would allow 2 slices of 2x3, or samples of 1 bytes",
        ),
        (
            "2x3x4:u8:header=2",
            50,
            "holds 50 bytes, but 2x3x4:u8:header=2 needs 26; its size would allow header=26, or 8 slices of 2x3, or samples of 2 bytes",
        ),
        ("2x3x4:u8", 7, "holds 7 bytes, but 2x3x4:u8 needs 24"),
        (
            "999999999x999999999x9:u8",
            7,
            "holds 7 bytes, but 999999999x999999999x9:u8 needs 8999999982000000009",
        ),
        ("9999999999x9999999999x9:u8", 7, "declares more samples than can be counted"),
    ] {
        assert_eq!(read_raw(layout, &vec![1; there]).unwrap_err(), format!("a.raw: {reason}"), "{layout}");
    }
    assert_eq!(
        refusal("a.raw", &[1, 2, 3]),
        "a.raw: has no header: say with --raw how its 3 bytes lie, as in --raw 256x256x128:u16:le"
    );
}

#[test]
fn gzip_around_any_format_and_what_is_no_volume() {
    let data = int16(false);
    let packed = gzip(&mha(SPACED, "LOCAL", &data));
    assert_eq!(volume_format_of(Path::new("a.mha.gz"), &packed), Some(VolumeFormat::MetaImage));
    assert_eq!(numbers(&read_quietly("a.mha.gz", &packed)), counting());
    for (bytes, name) in [
        (&b"v 0 0 0\n"[..], "a.obj"),
        (b"ply\nformat ascii 1.0\n", "a.ply"),
        (&gzip(b"nothing"), "a.gz"),
        (b"\x1f\x8b", "a.gz"),
        (b"plain words", "words"),
    ] {
        assert_eq!(volume_format_of(Path::new(name), bytes), None, "{name}");
        assert!(refusal(name, bytes).contains("is no volume that dotwork reads"));
    }
    assert_eq!(refusal("a.nrrd", b""), "a.nrrd: the file is empty");
}

/// Found by a fuzzer: the message quoted a name of kilobytes in full.
#[test]
fn a_message_shortens_the_name_of_a_data_file() {
    let name = "a".repeat(5000);
    let header = format!("NDims = 3\nDimSize = 2 3 4\nElementType = MET_SHORT\nElementDataFile = {name}\n");
    let message = refusal_among("x.mhd", header.as_bytes(), &[]);
    assert!(message.ends_with("aaa: no such file") && message.len() < 400, "{message}");
}
