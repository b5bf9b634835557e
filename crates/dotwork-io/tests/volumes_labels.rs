//! Label tables, in files of their own and in the headers of segmentations.
#![cfg(all(feature = "nrrd", feature = "bzip2"))]

mod volume_common;

use std::path::Path;

use dotwork_drawing::Warnings;
use dotwork_io::volume::{LabelEntry, LabelTable, label_table_from_bytes, read_label_table};
use volume_common::{nrrd, numbers, read, read_quietly, refusal};

fn table(text: &str) -> (LabelTable, Vec<String>) {
    let mut warnings = Warnings::new();
    let table = label_table_from_bytes(Path::new("a.txt"), text.as_bytes(), &mut warnings);
    (table.unwrap_or_else(|e| panic!("{e}")), warnings.iter().map(ToString::to_string).collect())
}

fn no_table(bytes: &[u8]) -> String {
    let error = label_table_from_bytes(Path::new("a.txt"), bytes, &mut Warnings::new()).unwrap_err();
    let message = error.to_string();
    assert!(!message.contains('\n') && message.len() < 200, "{message:?}");
    message
}

fn entry(value: i64, name: &str, color: [u8; 3], visible: bool) -> LabelEntry {
    LabelEntry { value, name: name.into(), color, visible }
}

#[test]
fn label_descriptions_of_itk_snap() {
    let text = "################\n# ITK-SnAP Label Description File\n# IDX   -R-  -G-  -B-  -A--  VIS MSH  LABEL\n\
        \x20   0     0    0    0        0  0  0    \"Clear Label\"\n\
        \x20   1   255    0    0        1  1  1    \"Left \\ lung, \"upper\"\"\r\n\
        \x20  12     0  255    0      0.5  0  1    \"\"\n";
    let (table, warnings) = table(text);
    let expected = [
        entry(0, "Clear Label", [0, 0, 0], false),
        entry(1, "Left \\ lung, \"upper\"", [255, 0, 0], true),
        entry(12, "", [0, 255, 0], false),
    ];
    assert_eq!(table.entries, expected);
    assert_eq!(table.find(12), Some(&expected[2]));
    assert_eq!(table.find(2), None);
    assert!(warnings.is_empty());
}

#[test]
fn colour_tables_of_slicer_and_freesurfer() {
    let slicer = "# Color table file GenericColors.txt\n# 3 values\n0 Background 0 0 0 0\n1 soft_tissue 128 174 128 255\n7 Left Lobe 3 1 2 3 255\n";
    let expected = [
        entry(0, "Background", [0, 0, 0], false),
        entry(1, "soft_tissue", [128, 174, 128], true),
        entry(7, "Left Lobe 3", [1, 2, 3], true),
    ];
    assert_eq!(table(slicer).0.entries, expected);
    // Old Macintosh lines, and a mark at the start.
    assert_eq!(table(&format!("\u{feff}{}", slicer.replace('\n', "\r"))).0.entries, expected);

    let freesurfer = "#$Id: FreeSurferColorLUT.txt\n\n#No. Label Name:     R   G   B   A\n\n0   Unknown    0 0 0 0\n2   Left-Cerebral-White-Matter  245 245 245 0\n2   Twice 1 1 1 0\n-5 WM 1 2 3\n";
    let (found, warnings) = table(freesurfer);
    // Opacity is 0 throughout there, and hides nothing.
    let expected = [
        entry(0, "Unknown", [0, 0, 0], true),
        entry(2, "Left-Cerebral-White-Matter", [245, 245, 245], true),
        entry(-5, "WM", [1, 2, 3], true),
    ];
    assert_eq!(found.entries, expected);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("2 on line 7"), "{warnings:?}");
}

#[test]
fn what_is_no_table_is_refused_with_its_line() {
    for (text, reason) in [
        ("", "is no label table: it has no labels"),
        ("# only\n\n", "is no label table: it has no labels"),
        (
            "\n1 bone 1 2\n",
            "line 2: '1 bone 1 2' is no line of a label table (index name r g b a, or IDX R G B A VIS MSH \"LABEL\")",
        ),
        ("1 bone 1 2 256 0\n", "line 1: the colour '256' is not within 0 to 255"),
        ("x bone 1 2 25 0\n", "line 1: the label 'x' is not a whole number"),
        (
            "99999999999999999999 bone 1 2 25\n",
            "line 1: the label '99999999999999999999' is not a whole number",
        ),
        ("1 2 3 4 1 1 1 \"a\n", "line 1: '1 2 3 4 1 1 1 \"a' has no closing quotation mark"),
        ("1 2 3 4 1 1 \"a\"\n", "line 1: 6 columns before the name; IDX R G B A VIS MSH are expected"),
        ("1 2 3 4 2 1 1 \"a\"\n", "line 1: the opacity '2' is not within 0 to 1"),
        ("1 2 3 4 1 yes 1 \"a\"\n", "line 1: the visibility 'yes' is neither 0 nor 1"),
    ] {
        assert_eq!(no_table(text.as_bytes()), format!("a.txt: {reason}"));
    }
    no_table(&[0xff, 0, 7, b'\n', 0xfe]);
    let many: String = (0..=65_536).map(|i| format!("{i} a 1 2 3\n")).collect();
    assert_eq!(no_table(many.as_bytes()), "a.txt: line 65537: more than 65536 labels");
    let large = [b"# ".as_slice(), &vec![b'#'; 17 << 20]].concat();
    assert_eq!(no_table(&large), "a.txt: is over 16 MiB: no label table");
    let missing = read_label_table(Path::new("nowhere.ctbl"), &mut Warnings::new()).unwrap_err();
    assert_eq!(missing.to_string(), "nowhere.ctbl: no such file");
}

const ONE_LAYER: &str = "type: uchar\ndimension: 3\nsizes: 2 2 1\nspace: left-posterior-superior\n\
    space directions: (1,0,0) (0,1,0) (0,0,1)\nkinds: domain domain domain\nencoding: raw\n";

#[test]
fn a_segmentation_brings_its_table() {
    let keys = "Segment0_Color:=1 0 0.501961\nSegment0_ColorAutoGenerated:=1\nSegment0_Extent:=0 1 0 1 0 0\n\
        Segment0_ID:=Segment_1\nSegment0_LabelValue:=3\nSegment0_Layer:=0\nSegment0_Name:=tumor: core\n\
        Segment0_Tags:=Segmentation.Status:inprogress|TerminologyEntry: x~y^\n\
        Segment1_ID:=Segment_2\nSegment1_LabelValue:=1\nSegment1_Layer:=0\nSegmentation_MasterRepresentation:=Binary labelmap\n";
    let file = read_quietly("a.seg.nrrd", &nrrd(&format!("{ONE_LAYER}{keys}"), &[0, 1, 3, 3]));
    assert_eq!(numbers(&file), [0.0, 1.0, 3.0, 3.0]);
    let expected =
        [entry(3, "tumor: core", [255, 0, 128], true), entry(1, "Segment_2", [128, 128, 128], true)];
    assert_eq!(file.labels.unwrap().entries, expected);
    // Not as facts too.
    assert!(file.facts.iter().all(|(name, _)| !name.starts_with("Segment0")));
    assert_eq!(read_quietly("a.nrrd", &nrrd(ONE_LAYER, &[0, 1, 3, 3])).labels, None);
}

fn layered(layers: usize, keys: &str, data: &[u8]) -> Vec<u8> {
    let fields = format!(
        "type: uchar\ndimension: 4\nsizes: {layers} 3 2 1\nspace: left-posterior-superior\n\
         space directions: none (1,0,0) (0,1,0) (0,0,1)\nkinds: list domain domain domain\nencoding: raw\n"
    );
    nrrd(&format!("{fields}{keys}"), data)
}

#[test]
fn layers_become_one_volume() {
    // Values that differ are kept; of two segments in a voxel the later layer counts.
    let keys = "Segment0_LabelValue:=5\nSegment0_Layer:=0\nSegment1_LabelValue:=2\nSegment1_Layer:=1\n";
    let data = [0, 0, 5, 0, 0, 2, 5, 2, 9, 0, 0, 9];
    let (file, warnings) = read("a.seg.nrrd", &layered(2, keys, &data));
    assert_eq!(numbers(&file), [0.0, 5.0, 2.0, 2.0, 0.0, 0.0]);
    assert_eq!(file.labels.unwrap().entries.iter().map(|e| e.value).collect::<Vec<_>>(), [5, 2]);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("voxels in several segments: the last is taken"), "{warnings:?}");

    // Older files: a layer of ones for each segment, and no keys for either.
    let keys = "Segment0_Name:=a\nSegment1_Name:=b\nSegment2_Name:=c\n";
    let data = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    let file = read_quietly("a.seg.nrrd", &layered(3, keys, &data));
    assert_eq!(numbers(&file), [1.0, 2.0, 3.0, 0.0, 1.0, 3.0]);
    let labels = file.labels.unwrap();
    assert_eq!(
        labels.entries.iter().map(|e| (e.value, e.name.as_str())).collect::<Vec<_>>(),
        [(1, "a"), (2, "b"), (3, "c")]
    );

    // A list of one layer is that layer.
    let file = read_quietly("a.seg.nrrd", &layered(1, "Segment0_LabelValue:=4\n", &[0, 4, 4, 0, 0, 0]));
    assert_eq!(numbers(&file), [0.0, 4.0, 4.0, 0.0, 0.0, 0.0]);
}

#[test]
fn segments_that_make_no_sense() {
    let no = |keys: &str| refusal("a.seg.nrrd", &nrrd(&format!("{ONE_LAYER}{keys}"), &[0; 4]));
    // Two lines of the helper come first, then seven fields.
    for (keys, reason) in [
        ("Segment0_LabelValue:=x\n", "Segment0_LabelValue: 'x' is not a whole number"),
        ("Segment0_Layer:=-1\n", "Segment0_Layer: '-1' is no layer"),
        ("Segment0_Color:=1 2 0\n", "Segment0_Color: '1 2 0' is not three numbers within 0 to 1"),
        ("Segment0_Color:=1 0\n", "Segment0_Color: '1 0' is not three numbers within 0 to 1"),
        ("Segment99999999999_Name:=a\n", "Segment99999999999_Name: the number is too large"),
    ] {
        assert_eq!(no(keys), format!("a.seg.nrrd: line 10: {reason}"));
    }
    let many: String = (0..5000).map(|i| format!("Segment{i}_Name:=a\n")).collect();
    assert!(no(&many).ends_with("more than 4096 segments"));
    let keys = "Segment0_Layer:=7\nSegment1_LabelValue:=1\nSegment2_LabelValue:=1\n";
    let (file, warnings) = read("a.seg.nrrd", &nrrd(&format!("{ONE_LAYER}{keys}"), &[0, 1, 0, 0]));
    assert_eq!(file.labels.unwrap().entries.len(), 1);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
}
