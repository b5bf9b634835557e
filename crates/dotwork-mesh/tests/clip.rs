//! Clipping shapes whose areas, volumes and rims are known.

use std::collections::HashMap;
use std::f64::consts::PI;

use dotwork_drawing::Warnings;
use dotwork_mesh::{ClipBox, ClipError, ClipPlane, ClipRegion, Mesh, MeshOptions, RawMesh, clip, shapes};
use glam::DVec3;

const UNIT: [DVec3; 2] = [DVec3::NEG_ONE, DVec3::ONE];

fn region(text: &str) -> ClipRegion {
    ClipRegion::parse(text, UNIT).unwrap()
}

fn positions(raw: &RawMesh) -> Vec<DVec3> {
    let origin = DVec3::from_array(raw.origin);
    raw.positions.iter().map(|p| DVec3::from_array(p.map(f64::from)) + origin).collect()
}

fn area(raw: &RawMesh) -> f64 {
    vector_areas(raw).iter().map(|(_, a)| a.length()).sum()
}

/// Centroid and vector area of each triangle.
fn vector_areas(raw: &RawMesh) -> Vec<(DVec3, DVec3)> {
    let p = positions(raw);
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| p[v as usize]);
        ((a + b + c) / 3.0, (b - a).cross(c - a) / 2.0)
    };
    raw.triangles.iter().map(of).collect()
}

/// The ends of edges that one triangle has, each as often as it occurs; asserts that no edge has more than two.
fn rim(raw: &RawMesh) -> Vec<[DVec3; 2]> {
    let mut edges: HashMap<[u32; 2], usize> = HashMap::new();
    for &[a, b, c] in &raw.triangles {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            *edges.entry([p.min(q), p.max(q)]).or_default() += 1;
        }
    }
    assert!(edges.values().all(|&n| n <= 2));
    let p = positions(raw);
    edges.iter().filter(|(_, n)| **n == 1).map(|(e, _)| e.map(|v| p[v as usize])).collect()
}

/// Every rim vertex lies on the boundary of the region, and none has an edge to nowhere.
fn assert_rim_on(raw: &RawMesh, region: &ClipRegion, tolerance: f64) {
    for p in rim(raw).into_iter().flatten() {
        let closest = region.planes().iter().map(|k| k.distance(p).abs()).fold(f64::INFINITY, f64::min);
        assert!(closest < tolerance, "{p} is {closest} from every plane");
        // Removed by none if it is moved out a little; within the closure of the region.
        let inside = region.planes().iter().all(|k| k.distance(p) > -tolerance);
        assert!(region.rule() == dotwork_mesh::ClipRule::Any || inside, "{p}");
    }
}

/// A cube of side 2 about the origin, its sides cut into `n` by `n` squares; vertices are shared.
fn cube(n: usize) -> RawMesh {
    let mut ids: HashMap<[u32; 3], u32> = HashMap::new();
    let mut raw = RawMesh::default();
    let at = |i: usize| 2.0 * i as f32 / n as f32 - 1.0;
    for axis in 0..3 {
        for high in [false, true] {
            let mut corner = |i: usize, j: usize| {
                let mut p = [0.0; 3];
                p[axis] = if high { 1.0 } else { -1.0 };
                p[(axis + 1) % 3] = at(i);
                p[(axis + 2) % 3] = at(j);
                *ids.entry(p.map(f32::to_bits)).or_insert_with(|| {
                    raw.positions.push(p);
                    raw.positions.len() as u32 - 1
                })
            };
            for i in 0..n {
                for j in 0..n {
                    let [a, b, c, d] =
                        [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                    let squares = if high { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                    raw.triangles.extend(squares);
                }
            }
        }
    }
    raw.polygons = raw.triangles.len();
    raw
}

#[test]
fn a_sphere_keeps_the_zone_below_the_plane() {
    let sphere = shapes::sphere(6);
    for h in [-0.7, -0.2, 0.0, 0.31, 0.9] {
        let plane = ClipPlane::new(DVec3::new(1.0, -2.0, 0.5), h * 5.25f64.sqrt()).unwrap();
        let region = ClipRegion::common(&[plane]).unwrap();
        let cut = clip(&sphere, &region);
        assert!((area(&cut) / (2.0 * PI * (1.0 + h)) - 1.0).abs() < 0.002, "{h}: {}", area(&cut));
        assert!(positions(&cut).iter().all(|&p| plane.distance(p) < 3e-7));
        assert_rim_on(&cut, &region, 3e-7);
        let length: f64 = rim(&cut).iter().map(|[a, b]| a.distance(*b)).sum();
        assert!((length / (2.0 * PI * (1.0 - h * h).sqrt()) - 1.0).abs() < 0.002, "{h}: {length}");
        // Winding is kept: every triangle still faces outwards.
        assert!(vector_areas(&cut).iter().all(|(c, a)| c.dot(*a) > 0.0));
        let mesh = Mesh::build(cut, &MeshOptions::default(), &mut Warnings::new()).unwrap();
        assert_eq!(mesh.stats().euler_characteristic, 1, "a cap is a disc");
    }
}

#[test]
fn what_two_opposite_planes_keep_is_the_whole_area() {
    let sphere = shapes::sphere(4);
    let plane = ClipPlane::new(DVec3::new(0.3, 0.9, -0.2), 0.123).unwrap();
    let [a, b] = [plane, plane.flipped()].map(|p| clip(&sphere, &ClipRegion::common(&[p]).unwrap()));
    assert!((area(&a) + area(&b) - area(&sphere)).abs() < 1e-5);
    // The rims are the same edges, to the last bit.
    let bits = |raw: &RawMesh| {
        let mut rim: Vec<_> =
            rim(raw).into_iter().flatten().map(|p| p.to_array().map(f64::to_bits)).collect();
        rim.sort_unstable();
        rim
    };
    assert_eq!(bits(&a), bits(&b));
}

#[test]
fn an_octant_or_a_box_corner_is_cut_out_exactly() {
    let sphere = shapes::sphere(6);
    for (text, share) in [("x>0.5;y<0.5;z>0.5", 0.125), ("x>0.5;y>0.5", 0.25)] {
        let region = region(text);
        let cut = clip(&sphere, &region);
        assert!((area(&cut) / (4.0 * PI * (1.0 - share)) - 1.0).abs() < 0.001, "{text}: {}", area(&cut));
        assert_rim_on(&cut, &region, 1e-6);
        for (c, a) in vector_areas(&cut) {
            assert!(c.dot(a) > 0.0);
            assert!(a.length() < 1e-12 || !region.planes().iter().all(|p| p.distance(c) > 1e-6), "{c}");
        }
    }
    // The corner pokes through the faces of the cube: holes in the middle of two-triangle sides.
    let mut warnings = Warnings::new();
    for n in [1, 2, 7] {
        let cube = cube(n);
        let hole = ClipBox {
            min: DVec3::new(-0.4, -0.3, 0.5),
            max: DVec3::new(0.45, 0.6, 2.0),
            remove_inside: true,
        };
        let cut = clip(&cube, &hole.region().unwrap());
        assert!((area(&cut) - (24.0 - 0.85 * 0.9)).abs() < 1e-5, "{n}: {}", area(&cut));
        assert_rim_on(&cut, &hole.region().unwrap(), 1e-6);
        let length: f64 = rim(&cut).iter().map(|[a, b]| a.distance(*b)).sum();
        assert!((length - 2.0 * (0.85 + 0.9)).abs() < 1e-5, "{n}: {length}");
        let mesh = Mesh::build(cut, &MeshOptions::default(), &mut warnings).unwrap();
        assert_eq!(mesh.stats().euler_characteristic, 1, "{n}: a box with one hole");
        // The rest of the box.
        let kept = clip(&cube, &ClipBox { remove_inside: false, ..hole }.region().unwrap());
        assert!((area(&kept) - 0.85 * 0.9).abs() < 1e-5);
    }
    assert!(warnings.is_empty(), "{:?}", warnings.iter().collect::<Vec<_>>());
}

/// Boxes of every size and place against a slow reference: the same area is left, without cracks.
#[test]
fn random_regions_leave_what_sampling_says() {
    let torus = shapes::torus(0.7, 0.3, 24, 12);
    let random = |i: u64| {
        let mut z = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
    };
    let mut removed_most = 0.0f64;
    for case in 0..60 {
        let vector = |n: u64| DVec3::from_array([0, 1, 2].map(|a| random(case * 100 + n * 3 + a)));
        let planes: Vec<ClipPlane> = (0..1 + case % 5)
            .map(|n| ClipPlane::new(vector(2 * n), 0.4 * random(case * 100 + 50 + n)).unwrap())
            .collect();
        let region = ClipRegion::common(&planes).unwrap();
        let cut = clip(&torus, &region);
        assert_rim_on(&cut, &region, 1e-6);
        // Each triangle of the source in 64 x 64 small ones.
        let (p, n) = (positions(&torus), 64);
        let mut left = 0.0;
        for t in &torus.triangles {
            let [a, b, c] = t.map(|v| p[v as usize]);
            let small = (b - a).cross(c - a).length() / 2.0 / (n * n) as f64;
            for i in 0..n {
                for j in 0..n {
                    let (u, v) = ((i as f64 + 1.0 / 3.0) / n as f64, (j as f64 + 1.0 / 3.0) / n as f64);
                    let (u, v) = if i + j < n { (u, v) } else { (1.0 - v, 1.0 - u) };
                    left += if region.removes(a + (b - a) * u + (c - a) * v) { 0.0 } else { small };
                }
            }
        }
        assert!(
            (area(&cut) / area(&torus) - left / area(&torus)).abs() < 1e-3,
            "{case}: {} {left}",
            area(&cut)
        );
        removed_most = removed_most.max(1.0 - left / area(&torus));
        // Pieces face as the triangles they come from: away from the torus's circle.
        for (c, a) in vector_areas(&cut).into_iter().filter(|(_, a)| a.length() > 1e-9) {
            let ring = DVec3::new(c.x, 0.0, c.z).normalize() * 0.7;
            let ring_z = DVec3::new(c.x, c.y, 0.0).normalize() * 0.7;
            let out = if (p[0].y).abs() <= 0.3 && p.iter().all(|p| p.y.abs() < 0.31) {
                c - ring
            } else {
                c - ring_z
            };
            assert!(out.dot(a) > 0.0, "{case}: {c}");
        }
    }
    assert!(removed_most > 0.3, "the regions remove something: {removed_most}");
}

#[test]
fn cutting_away_a_box_or_its_planes_one_by_one_agrees() {
    let sphere = shapes::sphere(5);
    let b = ClipBox { min: DVec3::splat(-0.7), max: DVec3::splat(0.75), remove_inside: true };
    let outside = clip(&sphere, &b.region().unwrap());
    let inside = clip(&sphere, &ClipBox { remove_inside: false, ..b }.region().unwrap());
    assert!((area(&outside) + area(&inside) - area(&sphere)).abs() < 1e-5);
    assert!(area(&inside) > 0.1);
}

#[test]
fn planes_beside_the_object_change_no_bit() {
    let mut sphere = shapes::sphere(4);
    sphere.normals = sphere.positions.clone();
    sphere.colors = vec![[1, 2, 3, 4]; sphere.positions.len()];
    // Vertices that nothing uses stay as well.
    sphere.positions.push([0.5; 3]);
    sphere.normals.push([f32::NAN; 3]);
    sphere.colors.push([9; 4]);
    sphere.polygons = 77;
    let beside = |x: f64| ClipRegion::common(&[ClipPlane::new(DVec3::X, x).unwrap()]).unwrap();
    let same = |raw: &RawMesh| {
        assert_eq!((&raw.positions, &raw.triangles), (&sphere.positions, &sphere.triangles));
        assert_eq!((&raw.colors, raw.polygons), (&sphere.colors, 77));
        assert_eq!(raw.normals.len(), sphere.normals.len());
    };
    same(&clip(&sphere, &beside(1.0)));
    same(&clip(&sphere, &beside(5.0)));
    same(&clip(&sphere, &ClipRegion::common(&[]).unwrap()));
    // All six planes cross the sphere's box, but the box lies beside or within it.
    for center in [DVec3::splat(0.75), DVec3::ZERO] {
        let (min, max) = (center - 0.1, center + 0.1);
        same(&clip(&sphere, &ClipBox { min, max, remove_inside: true }.region().unwrap()));
    }
    assert!(clip(&sphere, &beside(-1.0)).triangles.is_empty());
    assert!(clip(&sphere, &beside(-5.0)).triangles.is_empty());
}

#[test]
fn faces_in_a_plane_stay_with_the_matter_they_bound() {
    let cube = cube(2);
    for (text, left) in [("x>0.5", 12.0), ("x<0.5", 12.0), ("x>1", 24.0), ("x<1", 0.0), ("x>0", 0.0)] {
        let cut = clip(&cube, &region(text));
        assert!((area(&cut) - left).abs() < 1e-5, "{text}: {}", area(&cut));
        assert_eq!(cut.triangles.is_empty(), left == 0.0, "{text}");
    }
    // A box flush with the sides: a notch.
    let notch = |min, max| ClipBox { min, max, remove_inside: true }.region().unwrap();
    let flush = notch(DVec3::new(0.25, 0.25, 0.25), DVec3::ONE);
    let cut = clip(&cube, &flush);
    assert!((area(&cut) - (24.0 - 3.0 * 0.75 * 0.75)).abs() < 1e-5, "{}", area(&cut));
    // The same box outside, sharing a side with the cube, takes nothing.
    let beside = notch(DVec3::new(1.0, -0.5, -0.5), DVec3::new(2.0, 0.5, 0.5));
    assert_eq!(clip(&cube, &beside), cube);
}

#[test]
fn normals_and_colours_are_interpolated_and_vertices_shared() {
    let raw = RawMesh {
        positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        normals: vec![[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        colors: vec![[0, 0, 0, 255], [200, 100, 50, 55], [100, 0, 0, 255], [0, 0, 0, 255]],
        polygons: 1,
        origin: [1e6, 0.0, 0.0],
        in_order: None,
        paint: None,
        tracks: Vec::new(),
    };
    let plane = ClipPlane::new(DVec3::X, 1e6 + 1.0).unwrap();
    let cut = clip(&raw, &ClipRegion::common(&[plane]).unwrap());
    assert_eq!(cut.origin, raw.origin);
    // 0 and 3 stay; the two sides and the diagonal have one new vertex each.
    assert_eq!((cut.positions.len(), cut.triangles.len(), cut.polygons), (5, 3, 3));
    assert_eq!(cut.positions[..2], [[0.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
    let at = cut.positions.iter().position(|p| *p == [1.0, 0.0, 0.0]).unwrap();
    let expected = glam::Vec3::new(0.25, 0.0, 0.75).normalize();
    assert!(glam::Vec3::from_array(cut.normals[at]).distance(expected) < 1e-6);
    assert_eq!(cut.colors[at], [50, 25, 13, 205]);
    assert!(cut.positions.contains(&[1.0, 1.0, 0.0]) && cut.positions.contains(&[1.0, 4.0, 0.0]));
    assert!((area(&cut) - 4.0).abs() < 1e-6);

    // A soup gets the same bits on both sides of the diagonal.
    let soup = RawMesh {
        positions: [0, 1, 2, 2, 3, 0].map(|v| raw.positions[v].map(|c| c * 0.37 + 0.1)).to_vec(),
        triangles: vec![[0, 1, 2], [3, 4, 5]],
        ..RawMesh::default()
    };
    let plane = ClipPlane::new(DVec3::new(1.0, 0.3, 0.0), 1.0).unwrap();
    let cut = clip(&soup, &ClipRegion::common(&[plane]).unwrap());
    let mesh = Mesh::build(cut, &MeshOptions::default(), &mut Warnings::new()).unwrap();
    assert_eq!(mesh.positions.len(), 5);
}

#[test]
fn broken_meshes_come_back_without_a_panic() {
    let plane = region("x>0.5;y>0.5");
    let mut sphere = shapes::sphere(2);
    sphere.positions[3] = [f32::NAN, f32::INFINITY, 0.0];
    sphere.positions[9] = [f32::MAX, -f32::MAX, 0.0];
    sphere.triangles.push([1, 1, 2]);
    sphere.triangles.push([4, 4, 4]);
    sphere.normals = vec![[0.0; 3]; 5];
    let cut = clip(&sphere, &plane);
    assert!(cut.triangles.iter().flatten().all(|&v| (v as usize) < cut.positions.len()));
    assert!(cut.normals.is_empty());
    sphere.triangles.push([0, 1, 1 << 31]);
    let same = clip(&sphere, &plane);
    assert_eq!((same.positions.len(), &same.triangles), (sphere.positions.len(), &sphere.triangles));
    assert_eq!(clip(&RawMesh::default(), &plane), RawMesh::default());
}

#[test]
fn threads_do_not_matter() {
    let torus = shapes::torus(0.7, 0.3, 400, 200);
    let region = region("x>0.5;y<0.6;plane=1,2,3,0.4");
    let with = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
            .install(|| clip(&torus, &region))
    };
    let one = with(1);
    assert!(one.triangles.len() < torus.triangles.len());
    assert_eq!(one, with(3));
}

#[test]
fn texts_name_planes_by_shares_of_the_box() {
    let bounds = [DVec3::new(10.0, 0.0, -4.0), DVec3::new(20.0, 8.0, 4.0)];
    let parse = |text| ClipRegion::parse(text, bounds);
    assert_eq!(parse("x>0.6").unwrap().planes(), [ClipPlane { normal: DVec3::X, offset: 16.0 }]);
    assert_eq!(parse(" Y < .25 ;").unwrap().planes(), [ClipPlane { normal: -DVec3::Y, offset: -2.0 }]);
    let free = parse("plane=0,0,-2,0.25").unwrap();
    assert_eq!(free.planes(), [ClipPlane { normal: -DVec3::Z, offset: -2.0 }]);
    assert!(free.removes(DVec3::new(0.0, 0.0, 1.9)) && !free.removes(DVec3::new(0.0, 0.0, 2.1)));
    assert_eq!(parse("x>0.5;x>0.5").unwrap().planes().len(), 1);
    assert!(parse("x>0.2;x<0.4").unwrap().removes(DVec3::new(13.0, 0.0, 0.0)));
    for (text, names) in [
        ("", "no clip plane"),
        ("x", "x: not a clip plane"),
        ("w>0.5", "w>0.5: not"),
        ("x>0.5;q", "q: not"),
        ("x>50", "50 is not a share"),
        ("x>nan", "\"nan\" is not a number"),
        ("x>0.2mm", "\"0.2mm\" is not a number"),
        ("plane=0,0,0,0.5", "no length"),
        ("plane=1,0.5", "2 numbers"),
        ("é>0.5", "not a clip plane"),
        ("xé5", "not a clip plane"),
        ("x>0.6;x<0.4", "removes nothing"),
    ] {
        let error = parse(text).expect_err(text);
        assert!(error.contains(names), "{text}: {error}");
    }
}

#[test]
fn regions_that_say_nothing_are_refused() {
    assert!(matches!(ClipPlane::new(DVec3::ZERO, 1.0), Err(ClipError::Plane { .. })));
    assert!(matches!(ClipPlane::new(DVec3::X, f64::NAN), Err(ClipError::Plane { .. })));
    let b = |min, max| ClipBox { min, max, remove_inside: true }.region();
    assert!(matches!(b(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0)), Err(ClipError::Box { .. })));
    assert!(matches!(b(DVec3::NEG_INFINITY, DVec3::INFINITY), Err(ClipError::Box { .. })));
    assert!(matches!(b(DVec3::NAN, DVec3::INFINITY), Err(ClipError::Box { .. })));
    assert_eq!(b(DVec3::ZERO, DVec3::INFINITY).unwrap().planes().len(), 3);
    let many: Vec<ClipPlane> = (0..33).map(|i| ClipPlane::new(DVec3::X, i.into()).unwrap()).collect();
    assert_eq!(ClipRegion::common(&many), Err(ClipError::TooManyPlanes(33)));
    assert!(ClipRegion::union(&many).is_ok());
}
