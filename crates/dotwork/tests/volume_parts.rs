//! Segmentations and transfer functions: an object for each of their parts, drawn again from a plate.
#![cfg(all(feature = "files", feature = "nrrd"))]

use std::path::{Path, PathBuf};

use dotwork::{
    Color, Format, LoadOptions, Loaded, Page, Scene, Stipples, Style, Warnings, load_with, settings_text,
};

/// Two balls of 1 and 2 in a box of 0, and a speck of 7, in a grid of 40 x 24 x 24; with a table if there are `keys`.
fn segmentation(folder: &Path, keys: &str) -> PathBuf {
    let mut voxels = Vec::new();
    for z in 0..24i32 {
        for y in 0..24i32 {
            for x in 0..40i32 {
                let ball = |cx: i32| (x - cx).pow(2) + (y - 12).pow(2) + (z - 12).pow(2) <= 64;
                let speck = (x - 20).pow(2) + (y - 3).pow(2) + (z - 3).pow(2) <= 4;
                voxels.push(if ball(10) {
                    1u8
                } else if ball(30) {
                    2
                } else if speck {
                    7
                } else {
                    0
                });
            }
        }
    }
    let mut bytes = format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 40 24 24\n\
         space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n{keys}\n"
    )
    .into_bytes();
    bytes.extend(voxels);
    let path = folder.join("two.seg.nrrd");
    std::fs::write(&path, bytes).unwrap();
    path
}

const KEYS: &str = "Segment0_ID:=a\nSegment0_Name:=left lung\nSegment0_Color:=1 0 0\nSegment0_LabelValue:=1\n\
                    Segment1_ID:=b\nSegment1_Name:=right lung\nSegment1_Color:=0 0 0.5\nSegment1_LabelValue:=2\n";

fn scene(path: &Path, options: &LoadOptions, style: &Style) -> Result<Scene, String> {
    let mut warnings = Warnings::new();
    let loaded = load_with(path, options, &mut warnings).map_err(|e| e.to_string())?;
    let mut scene =
        Scene { page: Page::pixels(160, 120).unwrap(), stipples: Stipples::Count(3000), ..Scene::default() };
    for part in loaded.into_meshes(style, None, &mut warnings).map_err(|e| e.to_string())? {
        let style = part.style(style.clone());
        scene.add(part.into_object(style, &mut warnings).map_err(|e| e.to_string())?);
    }
    Ok(scene)
}

fn names(scene: &Scene) -> Vec<&str> {
    scene.objects.iter().map(|o| o.name.as_str()).collect()
}

#[test]
fn a_segmentation_is_an_object_for_each_label_named_and_coloured_by_its_table() {
    let folder = tempfile::tempdir().unwrap();
    let path = segmentation(folder.path(), KEYS);
    let mut all = scene(&path, &LoadOptions::default(), &Style::default()).unwrap();
    assert_eq!(names(&all), ["left lung", "right lung", "label-7"]);
    // Red is darkened until it makes tones on paper; dark blue stays.
    let colors: Vec<Color> = all.objects.iter().map(|o| o.style.color).collect();
    assert_eq!(colors[1..], [Color { r: 0, g: 0, b: 128 }, Color::BLACK]);
    assert!(colors[0].r > 200 && colors[0].g == 0 && colors[0].b == 0, "{:?}", colors[0]);
    // Each where its voxels are, and as large.
    for (object, x) in all.objects.iter().zip([10.0, 30.0]) {
        let center = object.mesh.bounds().center() + glam_of(object.mesh.origin);
        assert!((center.x - x).abs() < 0.1, "{}: {center}", object.name);
        // As many cubes as the ball has voxels.
        let volume = object.mesh.volume();
        assert!((volume / 2109.0 - 1.0).abs() < 0.03, "{}: {volume}", object.name);
    }
    // A colour that the user chose is kept.
    let green = Style { color: Color { r: 0, g: 99, b: 0 }, ..Style::default() };
    let chosen = scene(&path, &LoadOptions::default(), &green).unwrap();
    assert!(chosen.objects.iter().all(|o| o.style.color == green.color));

    let drawing = all.draw();
    let plate = folder.path().join("plate.svg");
    dotwork::write_drawing(&plate, Format::Svg, &drawing, &all, &mut Warnings::new()).unwrap();
    let Loaded::Plate(again) = load_with(&plate, &LoadOptions::default(), &mut Warnings::new()).unwrap()
    else {
        panic!("a plate")
    };
    let mut again = again.scene(&mut Warnings::new()).unwrap();
    assert_eq!(settings_text(&again), settings_text(&all));
    assert_eq!(again.draw(), drawing);
}

fn glam_of(v: [f64; 3]) -> glam::Vec3 {
    glam::Vec3::from_array(v.map(|v| v as f32))
}

#[test]
fn labels_without_a_table_and_tables_beside_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = segmentation(folder.path(), "");
    let auto = LoadOptions { labels: Some("auto".into()), ..LoadOptions::default() };
    assert_eq!(names(&scene(&path, &auto, &Style::default()).unwrap()), ["label-1", "label-2", "label-7"]);
    let one = LoadOptions { label: Some(2), ..LoadOptions::default() };
    assert_eq!(names(&scene(&path, &one, &Style::default()).unwrap()), ["label-2"]);
    let table = folder.path().join("labels.txt");
    std::fs::write(
        &table,
        "0 0 0 0 0 0 0 \"Clear\"\n1 255 0 0 1 1 1 \"heart\"\n2 0 255 0 1 0 1 \"hidden\"\n",
    )
    .unwrap();
    let named = LoadOptions { labels: Some(table), ..LoadOptions::default() };
    assert_eq!(names(&scene(&path, &named, &Style::default()).unwrap()), ["heart", "label-7"]);
    // Asked for by value or by a feature, a volume is a volume again.
    let feature = Style { feature: dotwork::ink::FeatureChoice::Outer, ..Style::default() };
    assert_eq!(scene(&path, &auto, &feature).unwrap().objects.len(), 1);

    let gone = LoadOptions { label: Some(9), ..LoadOptions::default() };
    let error = scene(&path, &gone, &Style::default()).unwrap_err();
    assert!(error.contains("two.seg.nrrd: there is no label 9; its labels are 0, 1, 2, 7"), "{error}");
    let lost = LoadOptions { labels: Some(folder.path().join("lost.txt")), ..LoadOptions::default() };
    assert!(scene(&path, &lost, &Style::default()).unwrap_err().contains("lost.txt"));
}

#[test]
fn quantities_are_no_labels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.nrrd");
    let mut bytes =
        b"NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4 4\nendian: little\nencoding: raw\n\n".to_vec();
    bytes.extend((0..64).flat_map(|i| (i as f32 * 0.37).to_le_bytes()));
    std::fs::write(&path, bytes).unwrap();
    let auto = LoadOptions { labels: Some("auto".into()), ..LoadOptions::default() };
    let error = scene(&path, &auto, &Style::default()).unwrap_err();
    assert!(error.contains("t.nrrd: ") && error.contains("is no label volume"), "{error}");
}

#[test]
fn a_transfer_function_is_an_object_for_each_of_its_steps() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("skin-and-bone.toml");
    // Shells of 125, 375, 625 and 875: the surfaces lie half-way up the steps.
    std::fs::write(
        &path,
        "opacity = [[200, 0], [240, 0.2], [440, 0.2], [560, 1]]\ncolor = [[220, '#803000'], [400, '#803000'], [500, '#101010']]\n",
    )
    .unwrap();
    let options = LoadOptions { transfer: Some(path), ..LoadOptions::default() };
    let shells = scene(Path::new("demo:shells"), &options, &Style::default()).unwrap();
    let found: Vec<f64> = shells.objects.iter().map(|o| o.source.as_ref().unwrap().iso.unwrap()).collect();
    assert_eq!(found, [220.0, 500.0]);
    let occlusions: Vec<f32> = shells.objects.iter().map(|o| o.style.occlusion).collect();
    assert_eq!(occlusions, [0.2, 1.0]);
    assert_eq!(shells.objects[0].style.color, Color { r: 0x80, g: 0x30, b: 0 });
    assert_eq!(shells.objects[1].style.color, Color { r: 0x10, g: 0x10, b: 0x10 });
    let radius = |k: usize| shells.objects[k].mesh.bounding_sphere().1;
    assert!(radius(0) > 1.2 * radius(1), "{} {}", radius(0), radius(1));

    let nothing = folder.path().join("nothing.toml");
    std::fs::write(&nothing, "opacity = [[90000, 0], [90001, 1]]\n").unwrap();
    let options = LoadOptions { transfer: Some(nothing), ..LoadOptions::default() };
    let error = scene(Path::new("demo:shells"), &options, &Style::default()).unwrap_err();
    assert!(error.contains("shows none of its values"), "{error}");
}
