//! Labels of volumes made of known shapes: what is counted, and where the smooth surfaces lie.

mod common;

use std::f64::consts::PI;

use common::{hash, mesh_of, open_edges};
use dotwork_mesh::RawMesh;
use dotwork_volume::{Affine, Label, LabelError, LabelOptions, MAX_LABELS, Samples, Scaling, Volume, labels};
use glam::{DMat3, DVec3};

/// Labels of a function of voxel indices.
fn voxels(dims: [usize; 3], affine: Affine, label: impl Fn([f64; 3]) -> u8) -> Volume {
    let [nx, ny, nz] = dims;
    let at = |i: usize| [i % nx, i / nx % ny, i / nx / ny].map(|v| v as f64);
    let samples = (0..nx * ny * nz).map(|i| label(at(i))).collect();
    Volume::new(dims, Samples::U8(samples), Scaling::default(), affine).unwrap()
}

fn label(volume: &Volume, value: i64) -> Label {
    labels(volume).unwrap().into_iter().find(|l| l.value == value).unwrap()
}

fn surface(volume: &Volume, value: i64) -> RawMesh {
    let mesh = volume.label_surface(&[label(volume, value)], &LabelOptions::default()).unwrap();
    assert_eq!(open_edges(&mesh.triangles), (vec![], 0));
    mesh
}

fn places(mesh: &RawMesh) -> impl Iterator<Item = (DVec3, DVec3)> {
    let origin = DVec3::from_array(mesh.origin);
    let wide = |v: &[f32; 3]| DVec3::from_array(v.map(f64::from));
    mesh.positions.iter().zip(&mesh.normals).map(move |(p, n)| (wide(p) + origin, wide(n)))
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0), |(sum, n), v| (sum + v * v, n + 1));
    (sum / f64::from(n)).sqrt()
}

/// Volume, RMS and largest radial error, and RMS and largest error of normals (degrees) of a voxelised sphere's surface.
fn sphere_errors(spacing: [f64; 3], radius: f64, shift: [f64; 3], options: &LabelOptions) -> [f64; 5] {
    let dims = spacing.map(|s| (2.0 * radius / s) as usize + 5);
    let affine = Affine::from_spacing(spacing);
    let middle = affine.point([0, 1, 2].map(|a| (dims[a] as f64 - 1.0) / 2.0 + shift[a]));
    let volume = voxels(dims, affine, |i| u8::from(affine.point(i).distance(middle) <= radius));
    let mesh = volume.label_surface(&[label(&volume, 1)], options).unwrap();
    assert_eq!(open_edges(&mesh.triangles), (vec![], 0));
    let off = |p: DVec3, n: DVec3| n.angle_between(p - middle).to_degrees();
    let radial = rms(places(&mesh).map(|(p, _)| p.distance(middle) - radius));
    let worst = places(&mesh).map(|(p, _)| (p.distance(middle) - radius).abs()).fold(0.0, f64::max);
    let turned = rms(places(&mesh).map(|(p, n)| off(p, n)));
    let most = places(&mesh).map(|(p, n)| off(p, n)).fold(0.0, f64::max);
    let volume = mesh_of(mesh).stats().volume / (4.0 / 3.0 * PI * radius.powi(3));
    [volume, radial, worst, turned, most]
}

#[test]
fn a_sphere_of_voxels_becomes_a_sphere() {
    let staircase = LabelOptions { wavelength: 0.0 };
    for shift in [[0.0; 3], [0.3, 0.1, 0.45], [0.5; 3]] {
        let [_, rough, _, rough_turned, _] = sphere_errors([1.0; 3], 20.0, shift, &staircase);
        let [volume, radial, worst, turned, _] =
            sphere_errors([1.0; 3], 20.0, shift, &LabelOptions::default());
        assert!((volume - 1.0).abs() < 0.01, "volume {volume}");
        assert!(radial < 0.07 && worst < 0.35, "radius off by {radial}, {worst}");
        assert!(turned < 2.0, "normals off by {turned}");
        // The test can fail: the staircase itself would.
        assert!(rough > 2.5 * radial && rough_turned > 7.0 * turned);
    }
}

#[test]
fn small_spheres_do_not_shrink() {
    for (radius, share, radial_most) in [(8.0, 0.02, 0.075), (5.0, 0.03, 0.1), (3.0, 0.07, 0.18)] {
        for shift in [[0.0; 3], [0.3, 0.1, 0.45], [0.5; 3]] {
            let [staircase, ..] = sphere_errors([1.0; 3], radius, shift, &LabelOptions { wavelength: 0.0 });
            let [volume, radial, ..] = sphere_errors([1.0; 3], radius, shift, &LabelOptions::default());
            assert!((volume / staircase - 1.0).abs() < share, "{radius}: {volume}, {staircase}");
            assert!(radial < radial_most, "{radius}: {radial}");
        }
    }
}

/// Slices three times as far apart as pixels: terraces up to some ten pixels wide.
#[test]
fn terraces_go() {
    let spacing = [1.0, 1.0, 3.0];
    let shift = [0.3, 0.1, 0.45];
    let [_, rough, _, rough_turned, _] =
        sphere_errors(spacing, 60.0, shift, &LabelOptions { wavelength: 0.0 });
    let [volume, radial, _, turned, _] = sphere_errors(spacing, 60.0, shift, &LabelOptions::default());
    assert!((volume - 1.0).abs() < 0.01);
    assert!(rough > 0.45 && radial < 0.12, "{rough}, {radial}");
    assert!(rough_turned > 20.0 && turned < 2.2, "{rough_turned}, {turned}");
}

#[test]
fn slabs_keep_their_thickness() {
    let affine = Affine::from_spacing([1.0; 3]);
    for (half, normal) in [
        (1.5, DVec3::Z),
        (1.5, DVec3::new(1.0, 2.0, 3.0)),
        (1.5, DVec3::new(0.0, 1.0, 5.0)),
        // Lattice planes are 1/√3 apart there: half-way between the fifth and the sixth.
        (5.5 / 3f64.sqrt(), DVec3::new(1.0, 1.0, 1.0)),
    ] {
        let (n, middle) = (normal.normalize(), DVec3::splat(20.0));
        let away = |p: DVec3| (p - middle).dot(n);
        let volume = voxels([41; 3], affine, |i| u8::from(away(affine.point(i)).abs() < half - 1e-9));
        let mesh = surface(&volume, 1);
        // Far from where the volume cuts it off.
        let inner: Vec<(f64, f64)> = places(&mesh)
            .filter(|(p, _)| (*p - middle).abs().max_element() < 10.0)
            .map(|(p, normal)| (away(p), normal.dot(n).abs()))
            .collect();
        assert!(inner.len() > 500);
        let half_thickness = inner.iter().map(|(a, _)| a.abs()).sum::<f64>() / inner.len() as f64;
        assert!((2.0 * (half_thickness - half)).abs() < 0.15, "{normal}: {half_thickness}");
        assert!(rms(inner.iter().map(|(a, _)| a.abs() - half)) < 0.15, "{normal}");
        assert!(inner.iter().all(|(_, along)| *along > 0.9), "{normal}");
    }
}

#[test]
fn matter_one_voxel_thick_stays() {
    let affine = Affine::from_spacing([1.0; 3]);
    let one = voxels([5; 3], affine, |i| u8::from(i == [2.0; 3]));
    let rod = voxels([20, 5, 5], affine, |[x, y, z]| u8::from(x > 1.0 && x < 18.0 && y == 2.0 && z == 2.0));
    let sheet = voxels([20, 20, 5], affine, |[_, _, z]| u8::from(z == 2.0));
    for (volume, across) in [(one, 2), (rod, 2), (sheet, 2)] {
        let mesh = surface(&volume, 1);
        let reach = places(&mesh).map(|(p, _)| (p[across] - 2.0).abs()).fold(0.0, f64::max);
        let mean = places(&mesh).map(|(p, _)| (p[across] - 2.0).abs()).sum::<f64>();
        assert!((0.39..=0.99).contains(&reach) && mean > 0.0, "{reach}");
        assert!(places(&mesh).all(|(_, n)| (n.length() - 1.0).abs() < 1e-5));
        assert!(mesh_of(mesh).stats().volume > 0.0);
    }
}

/// Two labels with a wavy contact: vertices of the one lie near the surface of the other.
#[test]
fn neighbours_keep_together() {
    let affine = Affine::from_spacing([1.0; 3]);
    let contact = |y: f64, z: f64| 14.0 + 3.0 * (y / 4.0).sin() + 0.4 * z;
    let volume = voxels([32; 3], affine, |[x, y, z]| if x < contact(y, z) { 1 } else { 2 });
    let [one, two] = [1, 2].map(|value| surface(&volume, value));
    let inner = |p: &DVec3| (p.y - 15.5).abs().max((p.z - 15.5).abs()) < 11.0;
    let others: Vec<DVec3> = places(&two).map(|(p, _)| p).collect();
    let mut near = 0;
    for (p, _) in places(&one).filter(|(p, _)| inner(p) && p.x > 3.0) {
        let nearest = others.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.5, "{p}: {nearest}");
        near += 1;
    }
    assert!(near > 400);
}

#[test]
fn turned_and_mirrored_grids_give_outward_normals_at_the_right_place() {
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 2.0);
    for mirror in [1.0, -1.0] {
        let linear = turn * DMat3::from_diagonal(DVec3::new(0.5 * mirror, 0.5, 1.0));
        let affine = Affine { linear, origin: DVec3::new(1e5, -2e5, 50.0), ..Affine::from_spacing([1.0; 3]) };
        let dims = [44, 44, 24];
        let middle = affine.point([21.4, 21.7, 11.3]);
        let volume = voxels(dims, affine, |i| if affine.point(i).distance(middle) < 9.0 { 5 } else { 0 });
        let mesh = surface(&volume, 5);
        assert_ne!(mesh.origin, [0.0; 3]);
        for (p, n) in places(&mesh) {
            assert!((p.distance(middle) - 9.0).abs() < 0.6);
            assert!(n.angle_between(p - middle).to_degrees() < 25.0);
        }
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| DVec3::from_array(mesh.positions[v as usize].map(f64::from)));
            let out = a + DVec3::from_array(mesh.origin) - middle;
            assert!((b - a).cross(c - a).dot(out) > 0.0);
        }
    }
}

#[test]
fn a_label_at_the_border_is_closed_half_a_voxel_outside() {
    let volume = Volume::from_vec([6, 5, 1], [1.0, 1.0, 2.0], vec![3i16; 30]).unwrap();
    let mesh = volume.label_surface(&labels(&volume).unwrap(), &LabelOptions { wavelength: 0.0 }).unwrap();
    assert_eq!(open_edges(&mesh.triangles), (vec![], 0));
    let reach = |axis: usize| places(&mesh).map(|(p, _)| p[axis]).fold(f64::NEG_INFINITY, f64::max);
    assert_eq!([reach(0), reach(1), reach(2)], [5.5, 4.5, 1.0]);
}

#[test]
fn the_same_on_any_number_of_threads() {
    let affine = Affine::from_spacing([1.0, 0.8, 2.5]);
    let volume = voxels([40, 37, 23], affine, |[x, y, z]| {
        let wave = (x / 5.0).sin() + (y / 4.0).cos() + (z / 3.0).sin();
        u8::from(wave > 0.3) + u8::from(wave > 1.0)
    });
    let with_threads = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| (labels(&volume).unwrap(), surface(&volume, 1), surface(&volume, 2)))
    };
    let (found, one, two) = with_threads(1);
    assert_eq!(with_threads(3), (found.clone(), one, two));
    // Both together have no wall between them.
    let both = volume.label_surface(&found[1..], &LabelOptions::default()).unwrap();
    let united = voxels([40, 37, 23], affine, |[x, y, z]| {
        u8::from((x / 5.0).sin() + (y / 4.0).cos() + (z / 3.0).sin() > 0.3)
    });
    assert_eq!(both, surface(&united, 1));
}

#[test]
fn labels_are_counted_with_their_boxes() {
    let dims = [13, 7, 9];
    let samples: Vec<f32> = (0..13 * 7 * 9).map(|i| (hash(1, i) % 11) as f32).collect();
    let scaling = Scaling { slope: -2.0, intercept: 5.0 };
    let affine = Affine::from_spacing([1.0; 3]);
    let volume = Volume::new(dims, Samples::F32(samples), scaling, affine).unwrap();
    let found = labels(&volume).unwrap();
    assert_eq!(found.len(), 11);
    assert!(found.is_sorted_by_key(|l| l.value));
    for l in &found {
        let (mut count, mut low, mut high) = (0, [usize::MAX; 3], [0; 3]);
        for i in 0..13 * 7 * 9 {
            let at = [i % 13, i / 13 % 7, i / 91];
            if volume.value_at(at[0], at[1], at[2]) == l.value as f64 {
                count += 1;
                low = std::array::from_fn(|a| low[a].min(at[a]));
                high = std::array::from_fn(|a| high[a].max(at[a]));
            }
        }
        assert_eq!((l.voxels, l.bounds), (count, [low, high]));
    }
}

#[test]
fn what_is_no_label_volume_is_refused() {
    let mut samples = vec![1.0f32; 24];
    samples[17] = 2.5;
    let no =
        |samples: &[f32]| labels(&Volume::from_slice([2, 3, 4], [1.0; 3], samples).unwrap()).unwrap_err();
    assert_eq!(no(&samples), LabelError::NotWhole { voxel: [1, 2, 2], value: 2.5 });
    assert_eq!(no(&samples).to_string(), "is no label volume: voxel 1, 2, 2 has the value 2.5");
    for bad in [f32::NAN, f32::INFINITY, 1e20] {
        samples[17] = bad;
        assert!(matches!(no(&samples), LabelError::NotWhole { voxel: [1, 2, 2], .. }));
    }
    let many: Vec<u16> = (0..=MAX_LABELS as u16).collect();
    let volume = |n: usize| Volume::from_slice([n, 1, 1], [1.0; 3], &many[..n]).unwrap();
    assert_eq!(labels(&volume(MAX_LABELS)).unwrap().len(), MAX_LABELS);
    assert_eq!(labels(&volume(MAX_LABELS + 1)), Err(LabelError::TooMany));

    let volume = Volume::from_slice([2, 2, 2], [1.0; 3], &[0u8; 8]).unwrap();
    let far = Label { value: 3, voxels: 1, bounds: [[5, 0, 0], [usize::MAX; 3]] };
    for asked in [far, Label { bounds: [[0; 3], [1; 3]], ..far }] {
        let error = volume.label_surface(&[asked], &LabelOptions::default()).unwrap_err();
        assert_eq!(error.to_string(), "no voxel has the label 3");
    }
    for wavelength in [-1.0, f64::NAN, 1e9] {
        let options = LabelOptions { wavelength };
        let refused = volume.label_surface(&labels(&volume).unwrap(), &options);
        assert!(matches!(refused, Err(LabelError::Wavelength(_))));
    }
}
