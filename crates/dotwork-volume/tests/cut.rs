//! Cut faces of fields whose sections are known, and that they fit the clipped isosurface.

mod common;

use std::collections::HashMap;
use std::f64::consts::PI;

use common::{Field, iso, iso_capped, mesh_of, open_edges};
use dotwork_mesh::{ClipBox, ClipPlane, ClipRegion, RawMesh, clip};
use dotwork_volume::{Affine, CutFace, Space, Unit, Volume, cut_faces};
use glam::{DMat3, DVec3};

const RADIUS: f64 = 10.0;
/// Not on the grid.
const CENTER: DVec3 = DVec3::new(1.1, 2.3, 3.2);

/// A sphere in voxels of half a unit or so, through `linear`, well within the volume.
fn sphere(linear: DMat3) -> Volume {
    // As many voxels as the steps need.
    let dims = [0, 1, 2].map(|a| (26.0 / linear.col(a).length()) as usize);
    let middle = linear * DVec3::from_array(dims.map(|n| (n - 1) as f64 / 2.0));
    let origin = DVec3::new(1.0, 2.0, 3.0) - middle;
    let affine = Affine { linear, origin, space: Space::Unknown, unit: Unit::Unknown };
    Field::new(dims, affine).volume(|p| (RADIUS - p.distance(CENTER)) as f32)
}

fn half() -> DMat3 {
    DMat3::from_diagonal(DVec3::splat(0.5))
}

/// A plane at height `h` over the sphere's centre.
fn plane(normal: DVec3, h: f64) -> ClipPlane {
    let normal = normal.normalize();
    ClipPlane::new(normal, normal.dot(CENTER) + h).unwrap()
}

fn points(raw: &RawMesh) -> Vec<DVec3> {
    let origin = DVec3::from_array(raw.origin);
    raw.positions.iter().map(|p| DVec3::from_array(p.map(f64::from)) + origin).collect()
}

/// Vector areas of all triangles.
fn areas(raw: &RawMesh) -> Vec<DVec3> {
    let p = points(raw);
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| p[v as usize]);
        (b - a).cross(c - a) / 2.0
    };
    raw.triangles.iter().map(of).collect()
}

fn area(raw: &RawMesh) -> f64 {
    areas(raw).iter().map(|a| a.length()).sum()
}

/// The rim as segments; asserts that it consists of closed lines and that winding agrees inside.
fn rim(raw: &RawMesh) -> Vec<[DVec3; 2]> {
    let (open, odd) = open_edges(&raw.triangles);
    assert_eq!(odd, 0);
    let mut uses: HashMap<u32, usize> = HashMap::new();
    open.iter().flatten().for_each(|&v| *uses.entry(v).or_default() += 1);
    assert!(uses.values().all(|n| n % 2 == 0));
    let p = points(raw);
    open.iter().map(|e| e.map(|v| p[v as usize])).collect()
}

/// The largest distance of the ends of `from` from the segments `to`.
fn apart(from: &[[DVec3; 2]], to: &[[DVec3; 2]]) -> f64 {
    let distance = |p: DVec3, [a, b]: [DVec3; 2]| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a.lerp(b, t))
    };
    let closest = |&p: &DVec3| to.iter().map(|&s| distance(p, s)).fold(f64::INFINITY, f64::min);
    from.iter().flatten().map(closest).fold(0.0, f64::max)
}

/// What holds for every cut: faces in their planes, facing the removed side, one value a vertex.
fn assert_sound(cut: &CutFace) {
    let p = points(&cut.mesh);
    assert_eq!((cut.values.len(), cut.mesh.normals.len()), (p.len(), p.len()));
    assert!(cut.values.iter().all(|v| v.is_finite()));
    let all = areas(&cut.mesh);
    let (mut vertices, mut triangles) = (0, 0);
    for face in &cut.faces {
        assert_eq!((face.vertices.start, face.triangles.start), (vertices, triangles));
        (vertices, triangles) = (face.vertices.end, face.triangles.end);
        for v in face.vertices.clone() {
            assert!(face.plane.distance(p[v]).abs() < 1e-5, "{} off the plane", face.plane.distance(p[v]));
            assert_eq!(cut.mesh.normals[v], face.plane.normal.as_vec3().to_array());
        }
        for t in face.triangles.clone() {
            assert!(all[t].dot(face.plane.normal) > 0.0, "{:?}", all[t]);
            assert!(cut.mesh.triangles[t].iter().all(|&v| face.vertices.contains(&(v as usize))));
        }
    }
    assert_eq!((vertices, triangles), (p.len(), cut.mesh.triangles.len()));
    assert_eq!(cut.mesh.polygons, triangles);
}

/// One face alone.
fn face(cut: &CutFace, i: usize) -> RawMesh {
    let face = &cut.faces[i];
    RawMesh {
        positions: cut.mesh.positions[face.vertices.clone()].to_vec(),
        triangles: cut.mesh.triangles[face.triangles.clone()]
            .iter()
            .map(|t| t.map(|v| v - face.vertices.start as u32))
            .collect(),
        origin: cut.mesh.origin,
        ..RawMesh::default()
    }
}

/// A sphere cut at some heights: area of the disc and of what remains, and how well the rims fit, in units.
fn assert_cap(volume: &Volume, normal: DVec3, fit: f64) {
    let surface = iso(volume, 0.0);
    for h in [-6.3, -0.4, 3.0, 8.05] {
        let region = ClipRegion::common(&[plane(normal, h)]).unwrap();
        let cut = cut_faces(volume, 0.0, &region);
        assert_sound(&cut);
        assert_eq!((cut.faces.len(), cut.mesh.origin), (1, surface.origin));
        let disc = PI * (RADIUS * RADIUS - h * h);
        assert!((area(&cut.mesh) / disc - 1.0).abs() < 0.01, "{normal} {h}: {} {disc}", area(&cut.mesh));
        let rest = clip(&surface, &region);
        let zone = 2.0 * PI * RADIUS * (RADIUS + h);
        assert!((area(&rest) / zone - 1.0).abs() < 0.01, "{normal} {h}: {} {zone}", area(&rest));
        let [of_rest, of_cut] = [rim(&rest), rim(&cut.mesh)];
        assert!(of_rest.len() > 40 && of_cut.len() > 40);
        let gap = apart(&of_rest, &of_cut).max(apart(&of_cut, &of_rest));
        assert!(gap < fit, "{normal} {h}: rims are {gap} apart");
        // Values are those of the field: the distance from the sphere.
        for (p, v) in points(&cut.mesh).iter().zip(&cut.values) {
            assert!((RADIUS - p.distance(CENTER) - f64::from(*v)).abs() < 0.2);
        }
    }
}

#[test]
fn a_plane_through_a_sphere_bares_a_disc_that_fits() {
    let volume = sphere(half());
    for normal in [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0), DVec3::new(-0.3, 0.8, 2.0)] {
        assert_cap(&volume, normal, 0.02);
    }
}

#[test]
fn so_on_uneven_turned_sheared_and_mirrored_grids() {
    assert_cap(&sphere(DMat3::from_diagonal(DVec3::new(0.4, 0.5, 1.0))), DVec3::new(0.2, 1.0, 0.3), 0.05);
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 2.0);
    let shear =
        DMat3::from_cols(DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.1, 0.5, 0.0), DVec3::new(0.0, -0.15, 0.45));
    assert_cap(&sphere(turn * shear), DVec3::X, 0.03);
}

#[test]
fn an_octant_taken_from_a_sphere_leaves_three_quarter_discs() {
    let volume = sphere(half());
    let planes = [plane(DVec3::X, 0.0), plane(DVec3::NEG_Y, 0.0), plane(DVec3::Z, 0.0)];
    let region = ClipRegion::common(&planes).unwrap();
    let cut = cut_faces(&volume, 0.0, &region);
    assert_sound(&cut);
    assert_eq!(cut.faces.iter().map(|f| f.plane).collect::<Vec<_>>(), planes);
    let quarter = PI * RADIUS * RADIUS / 4.0;
    let rest = clip(&iso(&volume, 0.0), &region);
    let mut rims = Vec::new();
    for i in 0..3 {
        let face = face(&cut, i);
        assert!((area(&face) / quarter - 1.0).abs() < 0.01, "{}", area(&face));
        rims.extend(rim(&face));
        // Within the closure of what is removed.
        assert!(points(&face).iter().all(|p| planes.iter().all(|k| k.distance(*p) > -1e-5)));
    }
    assert!(apart(&rim(&rest), &rims) < 0.02);
    // The three straight edges meet: each rim lies on the surface's rim or on that of another face.
    let vector: DVec3 = areas(&rest).into_iter().chain(areas(&cut.mesh)).sum();
    assert!(vector.length() < 0.01 * quarter, "closed surfaces have no vector area: {vector}");
    assert!((area(&rest) / (3.5 * PI * RADIUS * RADIUS) - 1.0).abs() < 0.01);

    // What the octant's planes remove together leaves the opposite octant.
    let flipped: Vec<ClipPlane> = planes.iter().map(ClipPlane::flipped).collect();
    let kept = cut_faces(&volume, 0.0, &ClipRegion::union(&flipped).unwrap());
    assert_sound(&kept);
    assert!((area(&kept.mesh) - area(&cut.mesh)).abs() < 1e-3 * quarter);
}

/// A field that is linear in space, all of it inside.
fn linear(dims: [usize; 3]) -> Volume {
    let mut affine = Affine::from_spacing([0.5, 0.75, 1.25]);
    affine.origin = DVec3::new(-3.0, 1.0, 2.0);
    Field::new(dims, affine).volume(slope)
}

fn slope(p: DVec3) -> f32 {
    (100.0 + p.x - 2.0 * p.y + 0.5 * p.z) as f32
}

#[test]
fn values_of_a_linear_field_are_exact_and_faces_end_with_the_volume() {
    let volume = linear([21, 17, 13]);
    let [min, max] = volume.bounds();
    let parse = |text| ClipRegion::parse(text, [min, max]).unwrap();
    let check = |cut: &CutFace, total: f64| {
        assert_sound(cut);
        assert!((area(&cut.mesh) / total - 1.0).abs() < 1e-5, "{} {total}", area(&cut.mesh));
        for (p, v) in points(&cut.mesh).iter().zip(&cut.values) {
            assert!((slope(*p) - v).abs() < 3e-5, "{p}: {v}");
        }
    };
    let size = max - min;
    check(&cut_faces(&volume, 0.0, &parse("x>0.3")), size.y * size.z);
    check(&cut_faces(&volume, 0.0, &parse("z<0.77")), size.x * size.y);
    check(&cut_faces(&volume, 0.0, &parse("x>0.5;y<0.5")), size.z * (size.x + size.y) / 2.0);
    // From edge to edge: a parallelogram.
    let diagonal = DVec3::new(size.y, size.x, 0.0);
    let region =
        ClipRegion::common(&[ClipPlane::new(diagonal, diagonal.dot(volume.center())).unwrap()]).unwrap();
    check(&cut_faces(&volume, 0.0, &region), size.x.hypot(size.y) * size.z);
    // The six faces of a box, from without and from within.
    let b = ClipBox { min: min + 0.21 * size, max: min + 0.68 * size, remove_inside: true };
    let of_box = 2.0 * 0.47 * 0.47 * (size.x * size.y + size.y * size.z + size.z * size.x);
    for remove_inside in [true, false] {
        let cut = cut_faces(&volume, 0.0, &ClipBox { remove_inside, ..b }.region().unwrap());
        assert_eq!(cut.faces.len(), 6);
        check(&cut, of_box);
        let out = cut.faces[0].plane.normal.x;
        assert_eq!(out, if remove_inside { 1.0 } else { -1.0 });
    }
    // A rectangle has two triangles a voxel.
    let cut = cut_faces(&volume, 0.0, &parse("x>0.3"));
    assert_eq!((cut.mesh.triangles.len(), cut.values.len()), (2 * 16 * 12, 17 * 13));
    // The iso value is one more straight border.
    let surface = clip(&iso_capped(&volume, 100.0), &parse("x>0.3"));
    let cut = cut_faces(&volume, 100.0, &parse("x>0.3"));
    assert_sound(&cut);
    // Crossings keep a thousandth of an edge away from samples that are the iso value.
    assert!(cut.values.iter().all(|&v| v > 100.0 - 1e-3));
    // What capping left open is covered: an isosurface with caps and a cut face are closed but for a thousandth.
    let vector: DVec3 = areas(&surface).into_iter().chain(areas(&cut.mesh)).sum();
    assert!(vector.length() < 0.005 * area(&cut.mesh), "{vector}");
}

#[test]
fn the_range_is_that_of_the_area() {
    let volume = Field::new([101, 41, 5], Affine::from_spacing([1.0; 3])).volume(|p| p.x as f32);
    let region = ClipRegion::parse("z>0.5", volume.bounds()).unwrap();
    let [low, high] = cut_faces(&volume, -1.0, &region).range().unwrap();
    assert!((low - 2.0).abs() <= 1.0 && (high - 98.0).abs() <= 1.0, "{low} {high}");
    // The rim's many vertices do not draw it to the iso value.
    let [low, _] = cut_faces(&volume, 50.0, &region).range().unwrap();
    assert!((low - 51.0).abs() <= 0.75, "{low}");
    assert_eq!(CutFace::default().range(), None);
}

#[test]
fn ranks_are_shares_of_the_area() {
    // A ramp over 100 units: below the value x lie x hundredths of the face.
    let volume = Field::new([101, 41, 5], Affine::from_spacing([1.0; 3])).volume(|p| p.x as f32);
    let region = ClipRegion::parse("z>0.5", volume.bounds()).unwrap();
    let cut = cut_faces(&volume, -1.0, &region);
    let ranks = cut.ranks();
    assert_eq!(ranks.len(), cut.values.len());
    for (&rank, &value) in ranks.iter().zip(&cut.values) {
        assert!((rank - value / 100.0).abs() < 0.01, "{rank} at {value}");
    }
    // Two flat halves, in ranks: half of one's own share counts. The seam is one voxel wide.
    let halves = Field::new([101, 41, 5], Affine::from_spacing([1.0; 3]));
    let halves = halves.volume(|p| if p.x < 25.0 { 3u8 } else { 4 });
    let cut = cut_faces(&halves, 0.0, &region);
    for (rank, value) in cut.ranks().into_iter().zip(&cut.values) {
        let expected = match *value {
            3.0 => 0.12,
            4.0 => 0.625,
            _ => continue,
        };
        assert!((rank - expected).abs() < 0.01, "{rank} at {value}");
    }
    assert!(CutFace::default().ranks().is_empty());
}

#[test]
fn cubes_of_whole_voxels_are_cut_into_squares() {
    let inside = |p: DVec3| p.cmpge(DVec3::splat(5.0)).all() && p.cmple(DVec3::splat(14.0)).all();
    let volume = Field::new([20, 20, 20], Affine::from_spacing([1.0; 3]))
        .volume(|p| if inside(p) { 200u8 } else { 0 });
    let region = ClipRegion::common(&[ClipPlane::new(DVec3::Y, 9.3).unwrap()]).unwrap();
    let cut = cut_faces(&volume, 100.0, &region);
    assert_sound(&cut);
    // From 4.5 to 14.5, with corners rounded by half a voxel at most.
    assert!((area(&cut.mesh) - 100.0).abs() < 0.5, "{}", area(&cut.mesh));
    let rest = clip(&iso(&volume, 100.0), &region);
    assert!(apart(&rim(&rest), &rim(&cut.mesh)) < 0.1);
    assert_eq!(cut.range().unwrap()[1], 200.0);
    // Noise: every case of a cell, and no cracks.
    let noise = Field::new([15, 14, 13], Affine::from_spacing([1.0; 3]));
    let noise = noise.volume(|p| (common::hash(1, (p.x + 100.0 * p.y + 10_000.0 * p.z) as u64) & 255) as u8);
    for (normal, offset) in [(DVec3::X, 7.0), (DVec3::Z, 6.25), (DVec3::new(1.0, 2.0, 3.0), 40.0)] {
        let cut = cut_faces(
            &noise,
            127.5,
            &ClipRegion::common(&[ClipPlane::new(normal, offset).unwrap()]).unwrap(),
        );
        assert_sound(&cut);
        assert!(rim(&cut.mesh).len() > 100);
    }
}

#[test]
fn voxels_that_are_nan_are_holes() {
    let field = Field::new([20, 20, 20], Affine::from_spacing([1.0; 3]));
    let hole = DVec3::new(8.0, 9.0, 10.0);
    let volume = field.volume(|p| if p == hole { f32::NAN } else { 1.0 });
    let region = |z| ClipRegion::common(&[ClipPlane::new(DVec3::Z, z).unwrap()]).unwrap();
    for z in [9.5, 10.0, 10.25] {
        let cut = cut_faces(&volume, 0.5, &region(z));
        assert_sound(&cut);
        // A square about the NaN with its corners at its neighbours' cells: between 2 and 4 voxels' area.
        let missing = 19.0 * 19.0 - area(&cut.mesh);
        assert!(missing > 1.9 && missing < 4.1, "{z}: {missing}");
        assert!(cut.values.iter().all(|&v| v == 1.0));
    }
    assert!((area(&cut_faces(&volume, 0.5, &region(11.0)).mesh) - 361.0).abs() < 1e-3);
    let all = field.volume(|_| f64::NAN);
    assert!(cut_faces(&all, 0.5, &region(9.5)).mesh.triangles.is_empty());
    let infinite = field.volume(|p| if p == hole { f32::INFINITY } else { 1.0 });
    assert_sound(&cut_faces(&infinite, 2.0, &region(10.0)));
}

#[test]
fn where_nothing_is_cut_there_is_no_face() {
    let volume = sphere(half());
    let none = |iso: f64, region: &ClipRegion, volume: &Volume| {
        let cut = cut_faces(volume, iso, region);
        assert!(cut.faces.is_empty() && cut.mesh.positions.is_empty() && cut.values.is_empty());
    };
    let at = |h| ClipRegion::common(&[plane(DVec3::X, h)]).unwrap();
    none(0.0, &at(10.5), &volume);
    none(0.0, &at(100.0), &volume);
    none(0.0, &at(-100.0), &volume);
    none(f64::NAN, &at(0.0), &volume);
    none(f64::INFINITY, &at(0.0), &volume);
    none(11.0, &at(0.0), &volume);
    none(0.0, &ClipRegion::common(&[]).unwrap(), &volume);
    // The whole object lies beside the box, though its planes cut it.
    let b = ClipBox { min: CENTER + 7.0, max: CENTER + 8.0, remove_inside: true };
    none(0.0, &b.region().unwrap(), &volume);
    // Flush with the volume: nothing is removed, or everything is.
    let full = linear([9, 9, 9]);
    for text in ["x>1", "x>0", "y<0", "y<1"] {
        none(0.0, &ClipRegion::parse(text, full.bounds()).unwrap(), &full);
    }
    let slice = Field::new([9, 9, 1], Affine::from_spacing([1.0; 3])).volume(|_| 1u8);
    none(0.5, &ClipRegion::common(&[ClipPlane::new(DVec3::X, 4.0).unwrap()]).unwrap(), &slice);
}

#[test]
fn faces_far_from_the_origin_keep_their_precision() {
    let near = sphere(half());
    let mut affine = *near.affine();
    affine.origin += DVec3::new(4e6, -3e6, 0.0);
    let far = Volume::new(near.dims(), near.samples().clone(), near.scaling(), affine).unwrap();
    let region = ClipRegion::common(&[ClipPlane::new(DVec3::X, 4e6 + 3.25).unwrap()]).unwrap();
    let cut = cut_faces(&far, 0.0, &region);
    assert_sound(&cut);
    assert_eq!(cut.mesh.origin, iso(&far, 0.0).origin);
    let h = 3.25 - CENTER.x;
    assert!((area(&cut.mesh) / (PI * (100.0 - h * h)) - 1.0).abs() < 0.01);
    assert!(apart(&rim(&clip(&iso(&far, 0.0), &region)), &rim(&cut.mesh)) < 0.02);
}

#[test]
fn threads_do_not_matter_and_the_mesh_can_be_built() {
    let volume = sphere(half());
    let b = ClipBox { min: CENTER - 2.0, max: CENTER + 30.0, remove_inside: true };
    let region = b.region().unwrap();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| cut_faces(&volume, 0.0, &region))
    };
    let one = with(1);
    assert_eq!(one, with(3));
    assert_eq!(one.faces.len(), 3, "the other three lie outside");
    let mesh = mesh_of(one.mesh.clone());
    assert!((mesh.area() / area(&one.mesh) - 1.0).abs() < 1e-4);
}
