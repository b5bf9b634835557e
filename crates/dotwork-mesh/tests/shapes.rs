//! The built-in shapes against what is known of them in closed form.

use std::f64::consts::PI;

use dotwork_drawing::Warnings;
use dotwork_mesh::{Mesh, MeshOptions, RawMesh, shapes};
use glam::{Vec2, Vec3};

/// Builds a shape, which must need no cleaning.
fn build(raw: RawMesh) -> Mesh {
    let mut warnings = Warnings::new();
    let mesh = Mesh::build(raw, &MeshOptions::default(), &mut warnings).expect("a sound shape");
    assert!(warnings.is_empty(), "{warnings:?}");
    mesh
}

fn close(value: f64, expected: f64, tolerance: f64) {
    assert!((value / expected - 1.0).abs() < tolerance, "{value}, not {expected}");
}

#[test]
fn a_sphere_has_its_area_volume_and_normals() {
    let mesh = build(shapes::sphere(5));
    assert!(mesh.closed);
    assert_eq!(mesh.triangles.len(), 20 * 4usize.pow(5));
    assert_eq!(mesh.stats().euler_characteristic, 2);
    close(mesh.area(), 4.0 * PI, 1e-3);
    close(mesh.volume(), 4.0 / 3.0 * PI, 2e-3);
    assert!(mesh.positions.iter().zip(&mesh.normals).all(|(p, n)| p.distance(*n) < 2e-3));
    let (center, radius) = mesh.bounding_sphere();
    assert!(center.length() < 1e-6 && (radius - 1.0).abs() < 1e-6);
}

#[test]
fn a_torus_has_its_area_volume_and_hole() {
    let mesh = build(shapes::torus(1.0, 0.4, 200, 100));
    let stats = mesh.stats();
    assert_eq!((stats.euler_characteristic, stats.components, stats.closed), (0, 1, true));
    close(stats.area, 4.0 * PI * PI * 0.4, 2e-3);
    close(stats.volume, 2.0 * PI * PI * 0.16, 2e-3);
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        let ring = Vec3::new(p.x, 0.0, p.z).normalize();
        assert!(n.distance((*p - ring).normalize()) < 2e-3);
    }
}

#[test]
fn closed_boxes_and_cylinders() {
    let sheet = build(shapes::sheet(0.02, 8)).stats();
    assert_eq!((sheet.euler_characteristic, sheet.closed), (2, true));
    close(sheet.volume, 0.02, 1e-5);
    close(sheet.area, 2.08, 1e-5);
    let cylinder = build(shapes::cylinder(0.5, 3.0, 256, 4)).stats();
    assert_eq!((cylinder.euler_characteristic, cylinder.closed), (2, true));
    close(cylinder.volume, PI * 0.75, 1e-3);
    close(cylinder.area, PI * 3.5, 1e-3);
}

#[test]
fn plates_cover_the_square_once_and_face_the_viewer() {
    let mut plates = vec![shapes::plate(7, 3), shapes::plate_irregular(1, 0)];
    plates.extend((0..20).map(|seed| shapes::plate_irregular(40, seed)));
    for plate in plates {
        let mesh = build(plate);
        close(mesh.area(), 1.0, 1e-5);
        assert!((0..mesh.triangles.len()).all(|t| mesh.facet_normal(t) == Vec3::Z));
        assert!(mesh.normals.iter().all(|n| *n == Vec3::Z));
        let (bounds, stats) = (mesh.bounds(), mesh.stats());
        assert_eq!((bounds.min.truncate(), bounds.max.truncate()), (Vec2::splat(-0.5), Vec2::splat(0.5)));
        assert_eq!((stats.euler_characteristic, stats.components), (1, 1));
    }
}

#[test]
fn an_irregular_plate_is_irregular_and_follows_its_seed() {
    let plate = shapes::plate_irregular(40, 1);
    assert_eq!(plate, shapes::plate_irregular(40, 1));
    assert_ne!(plate, shapes::plate_irregular(40, 2));
    let mesh = build(plate);
    let area = |t: usize| {
        let [a, b, c] = mesh.triangle(t);
        0.5 * (b - a).cross(c - a).length()
    };
    let mut areas: Vec<f32> = (0..mesh.triangles.len()).map(area).collect();
    areas.sort_by(f32::total_cmp);
    assert!(areas[areas.len() * 95 / 100] > 30.0 * areas[areas.len() * 5 / 100]);
}

#[test]
fn every_demo_is_there_and_faces_outwards() {
    for demo in shapes::DEMOS {
        let mesh = build(shapes::demo(demo.name).expect("listed"));
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5), "{}", demo.name);
        assert!(mesh.volume() > -1e-6, "{}", demo.name);
    }
    assert_eq!(shapes::demo("no such demo"), None);
}

#[test]
fn the_ribbon_is_closed_smooth_and_pierced() {
    let mesh = build(shapes::ribbon());
    let stats = mesh.stats();
    assert!(stats.closed && stats.components == 1);
    assert_eq!(stats.euler_characteristic, 2 - 2 * shapes::RIBBON_GENUS);
    assert!((150_000..300_000).contains(&stats.triangles), "{}", stats.triangles);
    // Smooth: facets agree with the normals of their corners, but for a few at the tightest curves.
    let rough = (0..mesh.triangles.len()).filter(|&t| {
        let facet = mesh.facet_normal(t);
        mesh.triangles[t].iter().any(|&v| mesh.normals[v as usize].dot(facet) < 0.8)
    });
    let rough = rough.count();
    assert!(rough * 1000 < mesh.triangles.len(), "{rough} facets stick out");
}

#[test]
fn the_teapot_has_its_proportions_and_no_open_seams() {
    let mesh = build(shapes::teapot());
    let stats = mesh.stats();
    assert!((50_000..80_000).contains(&stats.triangles), "{}", stats.triangles);
    // The body's rim and the lid's: 144 edges each; both ends of the handle and the spout: 40 each.
    assert_eq!((stats.boundary_edges, stats.non_manifold_edges), (2 * 144 + 4 * 40, 0));
    let size = stats.bounds.size();
    assert!((size - Vec3::new(6.434, 3.15, 4.0)).abs().max_element() < 0.01, "{size}");
    // Nothing stands upside down: the lowest and the highest facets face down and up.
    let facing = |y: f32| {
        (0..mesh.triangles.len())
            .filter(|&t| mesh.triangle(t).iter().all(|p| (p.y - y).abs() < 0.01))
            .map(|t| mesh.facet_normal(t).y)
            .collect::<Vec<_>>()
    };
    assert!(!facing(0.0).is_empty() && facing(0.0).iter().all(|&y| y < 0.0));
    assert!(!facing(3.15).is_empty() && facing(3.15).iter().all(|&y| y > 0.0));
}
