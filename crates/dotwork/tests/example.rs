//! The examples do what they say.
#![cfg(feature = "files")]

use dotwork::{Loaded, Warnings, load};

#[allow(dead_code, reason = "its main is not called here")]
#[path = "../examples/array_to_svg.rs"]
mod array_to_svg;
#[allow(dead_code, reason = "its main is not called here")]
#[path = "../examples/mesh_to_dots.rs"]
mod mesh_to_dots;
#[allow(dead_code, reason = "its main is not called here")]
#[path = "../examples/mesh_to_svg.rs"]
mod mesh_to_svg;

#[test]
fn mesh_to_dots_writes_a_row_for_each_dot() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("dots.csv");
    let mut warnings = Warnings::new();
    let dots = mesh_to_dots::mesh_to_dots("demo:torus", table.to_str(), &mut warnings).unwrap();
    assert!(dots > 1000 && warnings.is_empty());
    assert_eq!(std::fs::read_to_string(table).unwrap().lines().count(), dots + 1);
}

#[test]
fn array_to_svg_draws_the_surface_of_an_array_with_its_scale() {
    let folder = tempfile::tempdir().unwrap();
    let plate = folder.path().join("ball.svg");
    // Distances from the middle of 24 x 24 x 24 voxels, half a millimetre apart: a ball of 8 mm across.
    let away = |i: usize| (i as f32 - 11.5).powi(2);
    let samples: Vec<f32> =
        (0..24 * 24 * 24).map(|i| -(away(i % 24) + away(i / 24 % 24) + away(i / 576)).sqrt()).collect();
    let dots =
        array_to_svg::array_to_svg(&samples, [24; 3], [0.5; 3], -8.0, plate.to_str().unwrap()).unwrap();
    let text = std::fs::read_to_string(&plate).unwrap();
    assert!(dots > 1000);
    // All but those that are less than a micrometre wide at the rim.
    let drawn = touches(&text, "h0");
    assert!(drawn <= dots && 1000 * drawn > 999 * dots, "{drawn} of {dots}");
    assert!(text.contains("inkscape:label=\"scale bar") && text.contains("class=\"annotation\""));
    // The settings are those of the scene.
    let Loaded::Plate(plate) = load(&plate, &mut Warnings::new()).unwrap() else { panic!("no plate") };
    assert!(plate.settings().camera.ortho && plate.settings().scale_bar.is_some());
    assert_eq!(plate.objects()[0].world.unit, dotwork::volume::Unit::Millimetre);
    assert!(
        array_to_svg::array_to_svg(&samples, [24; 3], [0.5; 3], 1.0, "x.svg").is_err(),
        "beyond all values"
    );
}

#[test]
fn mesh_to_svg_touches_the_page_once_a_dot_with_one_pen() {
    let folder = tempfile::tempdir().unwrap();
    let plate = folder.path().join("tetrahedron.svg");
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let dots = mesh_to_svg::mesh_to_svg(&corners, &triangles, plate.to_str().unwrap()).unwrap();
    let text = std::fs::read_to_string(&plate).unwrap();
    assert!(dots > 1000);
    assert_eq!(touches(&text, "h0.001"), dots);
    assert_eq!(text.matches("inkscape:groupmode=\"layer\"").count(), 1);
    assert!(text.contains("stroke-width=\"0.25\""));
    assert!(mesh_to_svg::mesh_to_svg(&corners, &[[0, 1, 4]], "x.svg").is_err(), "there is no vertex 4");
}

/// Dots of a path that end like this.
fn touches(svg: &str, end: &str) -> usize {
    let paths =
        svg.split("class=\"dots\"").skip(1).filter_map(|p| p.split(" d=\"").nth(1)?.split('"').next());
    paths.map(|d| d.split('M').filter(|dot| dot.trim_end().ends_with(end)).count()).sum()
}
