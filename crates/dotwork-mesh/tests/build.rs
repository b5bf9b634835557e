//! What `Mesh::build` refuses, drops, turns and makes of normals.

use std::f32::consts::FRAC_1_SQRT_2;

use dotwork_drawing::Warnings;
use dotwork_mesh::{Mesh, MeshError, MeshOptions, RawMesh, shapes};
use glam::Vec3;

fn raw(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> RawMesh {
    RawMesh {
        positions: positions.to_vec(),
        triangles: triangles.to_vec(),
        polygons: triangles.len(),
        ..RawMesh::default()
    }
}

fn build_with(raw: RawMesh, options: MeshOptions) -> (Result<Mesh, MeshError>, Vec<String>) {
    let mut warnings = Warnings::new();
    let mesh = Mesh::build(raw, &options, &mut warnings);
    (mesh, warnings.iter().map(ToString::to_string).collect())
}

fn build(raw: RawMesh) -> (Mesh, Vec<String>) {
    let (mesh, warnings) = build_with(raw, MeshOptions::default());
    (mesh.expect("the mesh is sound"), warnings)
}

fn refusal(raw: RawMesh) -> MeshError {
    let (mesh, warnings) = build_with(raw, MeshOptions::default());
    assert!(warnings.is_empty(), "{warnings:?}");
    mesh.expect_err("the mesh is unusable")
}

fn creased(crease_angle: f32) -> MeshOptions {
    MeshOptions { crease_angle, ..MeshOptions::default() }
}

/// A cube of side 2 about the origin, 8 vertices.
fn cube() -> RawMesh {
    let positions: Vec<[f32; 3]> =
        (0..8).map(|c| [c & 1, c >> 1 & 1, c >> 2].map(|b| 2.0 * b as f32 - 1.0)).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    raw(&positions, &triangles)
}

fn turned(mut raw: RawMesh) -> RawMesh {
    raw.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    raw
}

fn scaled(mut raw: RawMesh, scale: f32, shift: [f32; 3]) -> RawMesh {
    for p in &mut raw.positions {
        *p = std::array::from_fn(|i| p[i] * scale + shift[i]);
    }
    raw
}

fn joined(mut a: RawMesh, b: RawMesh) -> RawMesh {
    let base = a.positions.len() as u32;
    a.positions.extend(b.positions);
    a.triangles.extend(b.triangles.iter().map(|t| t.map(|v| v + base)));
    a
}

/// Each triangle with vertices of its own, as in STL.
fn soup(raw: &RawMesh) -> RawMesh {
    let positions = raw.triangles.iter().flatten().map(|&v| raw.positions[v as usize]).collect();
    let triangles = (0..raw.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    RawMesh { positions, triangles, ..raw.clone() }
}

#[test]
fn a_clean_mesh_keeps_its_indices_and_says_nothing() {
    let cube = cube();
    let (mesh, warnings) = build(cube.clone());
    assert!(warnings.is_empty(), "{warnings:?}");
    assert!(mesh.closed);
    assert_eq!(mesh.triangles, cube.triangles);
    assert_eq!(mesh.positions, cube.positions.iter().map(|&p| Vec3::from(p)).collect::<Vec<_>>());
    assert!((mesh.area() - 24.0).abs() < 1e-12 && (mesh.volume() - 8.0).abs() < 1e-12);
    let (center, radius) = mesh.bounding_sphere();
    assert!(center.length() < 1e-6 && (radius - 3f32.sqrt()).abs() < 1e-6);
    assert_eq!(mesh.facet_normal(0), -Vec3::X);
}

#[test]
fn refusals_name_the_place() {
    let text = |raw| refusal(raw).to_string();
    assert_eq!(text(RawMesh::default()), "no triangles");
    let mut bad = cube();
    bad.triangles[5][1] = 99;
    assert_eq!(text(bad), "triangle 5 refers to vertex 99, but there are 8 vertices (counted from 0)");
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut bad = cube();
        bad.positions[3][1] = value;
        let first = bad.triangles.iter().position(|t| t.contains(&3)).expect("in use");
        assert_eq!(refusal(bad), MeshError::NotFinite { vertex: 3, triangle: first });
    }
    let line = raw(&[[0.0; 3], [1.0; 3], [2.0; 3]], &[[0, 1, 2], [0, 1, 1]]);
    assert_eq!(text(line), "the surface has no area: all triangles (2) are degenerate");
    assert!(matches!(refusal(scaled(cube(), 1e20, [0.0; 3])), MeshError::Size { .. }));
    assert!(matches!(refusal(scaled(cube(), 1e-20, [0.0; 3])), MeshError::Size { .. }));
}

#[test]
fn a_vertex_that_nothing_uses_may_hold_anything() {
    let mut spare = cube();
    spare.positions.insert(0, [f32::NAN; 3]);
    spare.positions.push([1e30; 3]);
    spare.triangles.iter_mut().for_each(|t| *t = t.map(|v| v + 1));
    let (mesh, warnings) = build(spare);
    assert_eq!(warnings, ["2 unused vertices dropped, first at vertex 0"]);
    assert_eq!((mesh.triangles, mesh.positions.len()), (cube().triangles, 8));
}

#[test]
fn a_soup_is_welded_to_the_mesh_it_came_from() {
    let sphere = shapes::sphere(3);
    let (mesh, warnings) = build(soup(&sphere));
    assert!(warnings.is_empty(), "{warnings:?}");
    assert!(mesh.closed);
    assert_eq!(mesh.positions.len(), sphere.positions.len());
    let (loose, _) = build_with(soup(&sphere), MeshOptions { weld: false, ..MeshOptions::default() });
    let loose = loose.expect("sound");
    assert!(!loose.closed);
    assert_eq!(loose.positions.len(), 3 * sphere.triangles.len());
}

#[test]
fn negative_zero_is_zero() {
    let (mesh, _) = build(raw(
        &[
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [-0.0, 0.0, -0.0],
            [-1.0, 0.0, 0.0],
            [-0.0, 1.0, 0.0],
        ],
        &[[0, 1, 2], [3, 5, 4]],
    ));
    assert_eq!(mesh.positions.len(), 4);
    assert!(mesh.positions.iter().flat_map(|p| p.to_array()).all(|c| c.to_bits() != (-0.0f32).to_bits()));
}

#[test]
fn degenerate_triangles_go_and_slivers_stay() {
    let mut flawed = cube();
    flawed.triangles.insert(2, [0, 0, 1]);
    // An edge's own middle: no height.
    flawed.positions.push([0.0, -1.0, -1.0]);
    flawed.triangles.push([0, 8, 1]);
    let (mesh, warnings) = build(flawed);
    assert_eq!(warnings, ["2 degenerate triangles dropped, first at triangle 2"]);
    assert_eq!((mesh.triangles, mesh.closed, mesh.positions.len()), (cube().triangles, true, 8));

    let sliver = raw(&[[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-5, 0.0]], &[[0, 1, 2]]);
    let (mesh, warnings) = build(sliver);
    assert!(warnings.is_empty());
    assert_eq!(mesh.normals, [Vec3::Z; 3]);
}

#[test]
fn duplicates_go_in_any_rotation_or_orientation() {
    let mut doubled = cube();
    let [a, b, c] = doubled.triangles[4];
    doubled.triangles.extend([[b, c, a], [c, b, a], [a, b, c]]);
    let (mesh, warnings) = build(doubled);
    assert_eq!(warnings, ["3 duplicate triangles dropped, first at triangle 12"]);
    assert_eq!((mesh.triangles, mesh.closed), (cube().triangles, true));
}

#[test]
fn an_inward_sphere_is_turned() {
    let (mesh, warnings) = build(turned(shapes::sphere(3)));
    assert_eq!(warnings, ["winding turned: the surface faced inwards"]);
    assert!(mesh.closed && mesh.volume() > 0.0);
    assert!(mesh.positions.iter().zip(&mesh.normals).all(|(p, n)| p.dot(*n) > 0.99));
}

#[test]
fn a_sphere_with_a_small_hole_is_turned_and_a_bowl_is_not() {
    let mut holed = turned(shapes::sphere(3));
    holed.triangles.drain(100..108);
    let (mesh, warnings) = build(holed);
    assert!(warnings.contains(&"winding turned: the surface faced inwards".to_string()), "{warnings:?}");
    assert!(!mesh.closed && mesh.volume() > 0.0);

    let mut bowl = turned(shapes::sphere(3));
    let positions = bowl.positions.clone();
    bowl.triangles.retain(|t| t.iter().all(|&v| positions[v as usize][1] < 0.1));
    let (mesh, warnings) = build(bowl);
    assert!(warnings.iter().all(|w| w.contains("unused")), "{warnings:?}");
    assert!(mesh.facet_normal(0).dot(mesh.triangle(0)[0]) < 0.0);
}

#[test]
fn faces_against_their_neighbours_are_turned() {
    let mut mixed = shapes::sphere(2);
    let triangles = mixed.triangles.len();
    for t in (0..triangles).step_by(3) {
        mixed.triangles[t].swap(1, 2);
    }
    let turns = triangles.div_ceil(3);
    let (mesh, warnings) = build(mixed);
    assert_eq!(
        warnings,
        [format!("{turns} triangles turned to agree with their neighbours, first at triangle 0")]
    );
    assert!(mesh.closed);
    let sphere = build(shapes::sphere(2)).0;
    for t in 0..triangles {
        assert!(mesh.facet_normal(t).dot(sphere.facet_normal(t)) > 0.99);
    }
}

#[test]
fn components_are_turned_one_by_one_and_cavities_respected() {
    let small = |turn: bool, shift: f32| {
        let ball = scaled(shapes::sphere(2), 0.5, [shift, 0.0, 0.0]);
        if turn { turned(ball) } else { ball }
    };
    // Side by side: the inward one is turned.
    let (mesh, warnings) = build(joined(shapes::sphere(2), small(true, 3.0)));
    assert_eq!(warnings, ["inward-facing components turned outwards (triangle 320)"]);
    assert_eq!(mesh.stats().components, 2);
    let ball = build(shapes::sphere(2)).0.volume();
    assert!((mesh.volume() / ball - 1.125).abs() < 1e-4);
    // One inside the other: the wall of a cavity stays, and so does a separate thing.
    for (turn, volume) in [(true, 0.875), (false, 1.125)] {
        let (mesh, warnings) = build(joined(shapes::sphere(2), small(turn, 0.1)));
        assert!(warnings.is_empty(), "{warnings:?}");
        assert!((mesh.volume() / ball - volume).abs() < 1e-4);
        // Everything the wrong way round: both are turned, whichever comes first in the file.
        for order in [true, false] {
            let (big, inner) = (turned(shapes::sphere(2)), turned(small(turn, 0.1)));
            let (mesh, warnings) = build(if order { joined(big, inner) } else { joined(inner, big) });
            assert_eq!(warnings, ["winding turned: the surface faced inwards"]);
            assert!((mesh.volume() / ball - volume).abs() < 1e-4);
        }
    }
}

#[test]
fn a_moebius_strip_is_left_open() {
    let n = 60;
    let mut strip = RawMesh::default();
    for i in 0..n {
        let angle = std::f32::consts::TAU * i as f32 / n as f32;
        for side in [-0.3, 0.3] {
            let r = 1.0 + side * (0.5 * angle).cos();
            strip.positions.push([r * angle.cos(), r * angle.sin(), side * (0.5 * angle).sin()]);
        }
        let (a, b) = (2 * i, 2 * i + 1);
        // After one turn the sides have changed places.
        let (c, d) = if i + 1 < n { (2 * i + 2, 2 * i + 3) } else { (1, 0) };
        strip.triangles.extend([[a, c, b], [b, c, d]]);
    }
    let (mesh, warnings) = build(strip);
    let stats = mesh.stats();
    assert_eq!((stats.boundary_edges, stats.euler_characteristic, stats.closed), (n as usize * 2, 0, false));
    assert!(warnings.iter().any(|w| w.contains("one-sided")), "{warnings:?}");
    assert!(mesh.topology().conflicting_edges() > 0 && !mesh.closed);
    assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
}

#[test]
fn a_cube_is_creased_below_its_angle_and_smooth_above() {
    let (smooth, _) = build(cube());
    assert_eq!(smooth.normals.len(), 8);
    assert_eq!(smooth.corner_normals, smooth.triangles);
    for (p, n) in smooth.positions.iter().zip(&smooth.normals) {
        assert!(n.distance(p.normalize()) < 1e-6, "{p} {n}: the weights must not depend on the diagonals");
    }
    // Faces that meet at exactly the angle stay together.
    for angle in [90.0, f32::NAN] {
        let (mesh, _) = build_with(cube(), creased(angle));
        assert_eq!(mesh.expect("sound").normals.len(), 8);
    }
    for angle in [30.0, 0.0, -1.0] {
        let (mesh, _) = build_with(cube(), creased(angle));
        let mesh = mesh.expect("sound");
        assert_eq!(mesh.normals.len(), 24);
        for (t, corners) in mesh.corner_normals.iter().enumerate() {
            for &n in corners {
                assert!(mesh.normals[n as usize].distance(mesh.facet_normal(t)) < 1e-6);
            }
        }
    }
}

#[test]
fn one_sharp_edge_splits_only_itself() {
    // A tent of two squares, each cut in two by n rows, folded by 90° along the y axis.
    let mut tent = RawMesh::default();
    let n = 4;
    for j in 0..=n {
        for (x, z) in [(-1.0, -1.0), (0.0, 0.0), (1.0, -1.0)] {
            tent.positions.push([x, j as f32, z]);
        }
    }
    for j in 0..n {
        for i in 0..2 {
            let [a, b, c, d] = [3 * j + i, 3 * j + i + 1, 3 * j + i + 4, 3 * j + i + 3];
            tent.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let (mesh, _) = build_with(tent, creased(60.0));
    let mesh = mesh.expect("sound");
    assert_eq!(mesh.normals.len(), 15 + 5);
    for (t, corners) in mesh.corner_normals.iter().enumerate() {
        let slope = if mesh.facet_normal(t).x < 0.0 { -1.0 } else { 1.0 };
        let expected = Vec3::new(slope, 0.0, 1.0) * FRAC_1_SQRT_2;
        assert!(corners.iter().all(|&n| mesh.normals[n as usize].distance(expected) < 1e-6));
    }
}

#[test]
fn non_manifold_edges_and_vertices_have_unit_normals() {
    // Three pages at one edge.
    let pages = raw(
        &[[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0]],
        &[[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    );
    for angle in [30.0, 180.0] {
        let (mesh, _) = build_with(pages.clone(), creased(angle));
        let mesh = mesh.expect("sound");
        let stats = mesh.stats();
        assert_eq!((stats.non_manifold_edges, stats.boundary_edges, stats.components), (1, 6, 1));
        assert_eq!(stats.euler_characteristic, 5 - 7 + 3);
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
        let topology = mesh.topology();
        assert_eq!(topology.edge_faces(&mesh.triangles, 1, 0).collect::<Vec<_>>(), [0, 1, 2]);
        assert!(topology.neighbours().as_flattened().iter().all(|&n| n == dotwork_mesh::topology::NONE));
    }
    // Two cones tip to tip: facets cancel at the shared vertex, and each cone gets its own normal if creased.
    let mut cones = RawMesh::default();
    cones.positions.push([0.0; 3]);
    for (side, flip) in [(1.0, false), (-1.0, true)] {
        let base = cones.positions.len() as u32;
        for k in 0..4 {
            let (s, c) = (std::f32::consts::FRAC_PI_2 * k as f32).sin_cos();
            cones.positions.push([c, s, side]);
            let (a, b) = (base + k, base + (k + 1) % 4);
            cones.triangles.push(if flip { [0, b, a] } else { [0, a, b] });
        }
    }
    let (mesh, _) = build(cones.clone());
    assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
    assert_eq!(mesh.stats().components, 1);
    let (mesh, _) = build_with(cones, creased(150.0));
    let mesh = mesh.expect("sound");
    assert_eq!(mesh.normals.len(), 10);
    assert!((mesh.normals[0] - Vec3::Z).length() < 1e-5 && (mesh.normals[9] + Vec3::Z).length() < 1e-5);
}

#[test]
fn a_hub_with_many_faces_is_no_trouble() {
    let (mesh, _) = build_with(shapes::cylinder(1.0, 1.0, 50_000, 1), creased(0.0));
    let mesh = mesh.expect("sound");
    assert!(mesh.closed);
    assert_eq!(mesh.stats().euler_characteristic, 2);
}

#[test]
fn threads_do_not_show() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let (mesh, _) = build_with(soup(&shapes::demo("ribbon").expect("a demo")), creased(25.0));
            let mesh = mesh.expect("sound");
            let (area, volume) = (mesh.area(), mesh.volume());
            (mesh, area, volume)
        })
    };
    assert!(on(1) == on(3));
}

/// The mesh with a colour of its own and a normal from the origin, not of unit length, at each vertex.
fn coloured(mut raw: RawMesh) -> RawMesh {
    let n = raw.positions.len();
    raw.colors = (0..n).map(|v| [v as u8, 7, 9, 255]).collect();
    raw.normals = raw.positions.iter().map(|&p| (3.0 * Vec3::from_array(p)).to_array()).collect();
    raw
}

#[test]
fn colours_and_given_normals_stay_with_their_vertices() {
    let sphere = shapes::sphere(4);
    let raw = coloured(sphere.clone());
    let (mesh, warnings) = build(raw.clone());
    assert_eq!((mesh.colors.as_slice(), warnings.len()), (raw.colors.as_slice(), 0));
    for (n, p) in mesh.normals.iter().zip(&mesh.positions) {
        assert!(n.distance(p.normalize()) < 1e-6, "{n} at {p}");
    }
    assert_eq!(mesh.corner_normals, mesh.triangles);

    // Below 180° the computed ones count.
    let (split, _) = build_with(raw.clone(), creased(170.0));
    let (plain, _) = build_with(sphere, creased(170.0));
    assert_eq!(split.unwrap().normals, plain.unwrap().normals);

    // An unused vertex before the others, and a soup whose first copies hold the colours.
    let mut shifted = raw.clone();
    shifted.positions.insert(0, [9.0; 3]);
    shifted.colors.insert(0, [99; 4]);
    shifted.normals.insert(0, [0.0; 3]);
    shifted.triangles.iter_mut().flatten().for_each(|v| *v += 1);
    let (compacted, _) = build(shifted);
    assert_eq!((&compacted.colors, &compacted.normals), (&mesh.colors, &mesh.normals));
    let corners = || raw.triangles.iter().flatten().map(|&v| v as usize);
    let soup = RawMesh {
        colors: corners().enumerate().map(|(k, v)| [v as u8, 7, 9, k as u8]).collect(),
        normals: corners().map(|v| raw.normals[v]).collect(),
        ..soup(&raw)
    };
    let (welded, _) = build(soup.clone());
    assert_eq!(welded.positions.len(), welded.colors.len());
    for (position, color) in welded.positions.iter().zip(&welded.colors) {
        let first = soup.positions.iter().position(|&p| Vec3::from_array(p) == *position).unwrap();
        assert_eq!(*color, soup.colors[first]);
    }
}

#[test]
fn given_normals_turn_with_their_faces() {
    let sphere = shapes::sphere(3);
    let inward = coloured(turned(sphere.clone()));
    // The normals agree with the inward faces.
    let normals = inward.normals.iter().map(|n| n.map(|c| -c)).collect();
    let (mesh, warnings) = build(RawMesh { normals, ..inward });
    assert_eq!(warnings, ["winding turned: the surface faced inwards"]);
    for (n, p) in mesh.normals.iter().zip(&mesh.positions) {
        assert!(n.dot(p.normalize()) > 0.999);
    }
    // Of two spheres the one that faces inwards.
    let far = scaled(sphere.clone(), 1.0, [5.0, 0.0, 0.0]);
    let mut two = joined(turned(sphere.clone()), far);
    let outward = |p: &[f32; 3]| Vec3::from_array(*p) - if p[0] > 2.0 { 5.0 * Vec3::X } else { Vec3::ZERO };
    let first = sphere.positions.len();
    two.normals = two.positions.iter().map(|p| outward(p).to_array()).collect();
    two.normals[..first].iter_mut().for_each(|n| *n = n.map(|c| -c));
    let (mesh, _) = build(two);
    for (n, p) in mesh.normals.iter().zip(&mesh.positions) {
        assert!(n.dot(outward(&p.to_array())) > 0.999, "{n} at {p}");
    }
}

#[test]
fn odd_colours_and_normals_are_said() {
    let mut raw = coloured(cube());
    raw.normals[2] = [0.0, f32::NAN, 0.0];
    raw.normals[5] = [0.0; 3];
    raw.normals[6] = [1e-30, 0.0, 0.0];
    let (mesh, warnings) = build(raw);
    assert_eq!(warnings, ["2 given normals without direction replaced by computed ones, first at vertex 2"]);
    let (computed, _) = build(cube());
    assert_eq!((mesh.normals[2], mesh.normals[5]), (computed.normals[2], computed.normals[5]));
    assert_eq!(mesh.normals[6], Vec3::X);

    let mut raw = coloured(cube());
    raw.colors.pop();
    raw.normals.pop();
    let (mesh, warnings) = build(raw);
    assert_eq!(
        warnings,
        [
            "colours of the vertices ignored: 7 for 8 vertices",
            "normals of the vertices ignored: 7 for 8 vertices"
        ]
    );
    assert_eq!((mesh.colors.len(), mesh.normals), (0, computed.normals));
}

#[test]
fn slices_make_the_mesh_that_build_makes() {
    let raw = cube();
    let mesh = Mesh::from_slices(&raw.positions, &raw.triangles).unwrap();
    assert_eq!(mesh, build(raw.clone()).0);
    assert_eq!(Mesh::from_slices(&raw.positions, &[]), Err(MeshError::NoTriangles));
    assert!(matches!(
        Mesh::from_slices(&raw.positions, &[[0, 1, 8]]),
        Err(MeshError::IndexOutOfRange { vertex: 8, .. })
    ));
}

#[test]
fn what_is_oriented_already_stays_as_it_is() {
    let mut raw = shapes::demo("sphere").unwrap();
    raw.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let build = |orient: bool| {
        let options = MeshOptions { orient, ..MeshOptions::default() };
        let mut warnings = Warnings::new();
        let mesh = Mesh::build(raw.clone(), &options, &mut warnings).unwrap();
        (mesh.volume() > 0.0, warnings.is_empty())
    };
    assert_eq!((build(true), build(false)), ((true, false), (false, true)));
}
