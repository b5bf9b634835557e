//! Ridges of the gradient: boundaries whose place is known, and which an isosurface misses.

mod common;

use common::{Field, hash, iso, mesh_of, open_edges};
use dotwork_mesh::{ClipRegion, RawMesh};
use dotwork_volume::{Affine, RidgeReport, Samples, Scaling, Space, Unit, Volume};
use glam::{DMat3, DVec3};

const MIDDLE: DVec3 = DVec3::new(1.0, -2.0, 3.0);
const RADIUS: f64 = 20.0;

/// An affine that puts the middle of a grid of `n`³ voxels at [`MIDDLE`].
fn centered(n: usize, linear: DMat3) -> Affine {
    let origin = MIDDLE - linear * DVec3::splat((n - 1) as f64 / 2.0);
    Affine { linear, origin, space: Space::Unknown, unit: Unit::Unknown }
}

/// How much of an edge that a Gaussian of `sigma` has blurred is inside, `depth` within it: 0 to 1 (to 1.5e-7;
/// Abramowitz and Stegun, 7.1.26).
fn blurred(depth: f64, sigma: f64) -> f64 {
    let x = depth / (sigma * 2f64.sqrt());
    let t = 1.0 / (1.0 + 0.3275911 * x.abs());
    let terms = [0.254829592, -0.284496736, 1.421413741, -1.453152027, 1.061405429];
    let sum = terms.iter().rev().fold(0.0, |sum, c| (sum + c) * t);
    0.5 * (1.0 + (1.0 - sum * (-x * x).exp()).copysign(x))
}

/// A ball of [`RADIUS`] voxels with a blurred edge, 200 in its middle and `bias` times as bright at one end as at the
/// other.
fn biased_ball(sigma: f64, bias: f64, affine: Affine) -> Volume {
    let inverse = affine.linear.inverse();
    Field::new([64; 3], affine).volume(|p| {
        let p = inverse * (p - MIDDLE);
        let inside = 200.0 * (1.0 + p.x / RADIUS * (bias - 1.0) / (bias + 1.0));
        (inside * blurred(RADIUS - p.length(), sigma)) as f32
    })
}

/// The surface before and after it was moved.
fn snapped(volume: &Volume, at: f64) -> ([RawMesh; 2], RidgeReport) {
    let before = iso(volume, at);
    let mut after = before.clone();
    let report = volume.snap_to_ridge(&mut after, None);
    ([before, after], report)
}

fn vector(p: &[f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

/// Root mean square of what is wrong with the radii, voxels of 1.
fn radius_error(raw: &RawMesh) -> f64 {
    let squares = raw.positions.iter().map(|p| ((vector(p) - MIDDLE).length() - RADIUS).powi(2));
    (squares.sum::<f64>() / raw.positions.len() as f64).sqrt()
}

/// The longest way that a vertex went, world units.
fn longest_move([before, after]: &[RawMesh; 2]) -> f64 {
    let ways = before.positions.iter().zip(&after.positions);
    ways.map(|(a, b)| vector(a).distance(vector(b))).fold(0.0, f64::max)
}

/// That it is the same surface with vertices elsewhere: none of its triangles is turned over, and its normals are unit
/// vectors on their side.
fn assert_same_surface([before, after]: &[RawMesh; 2]) {
    assert_eq!(before.triangles, after.triangles);
    assert_eq!((before.in_order, before.origin), (after.in_order, after.origin));
    let facet = |raw: &RawMesh, t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| vector(&raw.positions[v as usize]));
        (b - a).cross(c - a)
    };
    assert!(after.triangles.iter().all(|t| facet(after, t).dot(facet(before, t)) > 0.0));
    for (a, b) in before.normals.iter().zip(&after.normals) {
        assert!((vector(b).length() - 1.0).abs() < 1e-5 && vector(a).dot(vector(b)) > 0.0);
    }
    let (a, b) = (mesh_of(before.clone()), mesh_of(after.clone()));
    assert_eq!((a.closed, a.triangles.len()), (b.closed, b.triangles.len()));
}

#[test]
fn a_ball_that_is_brighter_at_one_end_is_round() {
    let affine = centered(64, DMat3::IDENTITY);
    // Where nothing is wrong with the isosurface nothing may become wrong either.
    for (sigma, bias, off, on) in [(1.0, 2.0, 0.25, 0.05), (0.7, 3.0, 0.25, 0.08), (0.8, 1.0, 0.0, 0.025)] {
        let (meshes, report) = snapped(&biased_ball(sigma, bias, affine), 100.0);
        let errors = meshes.each_ref().map(radius_error);
        assert!(errors[0] >= off && errors[1] < on, "{sigma} {bias}: {errors:?}");
        assert!(report.found == report.vertices && report.held * 1000 < report.vertices, "{report:?}");
        assert_same_surface(&meshes);
        assert!(
            meshes[1]
                .normals
                .iter()
                .zip(&meshes[1].positions)
                .all(|(n, p)| { vector(n).angle_between(vector(p) - MIDDLE).to_degrees() < 4.0 })
        );
        assert!(mesh_of(meshes[1].clone()).closed);
    }
}

/// An anisotropic, turned and mirrored grid, and values that fall where samples rise.
#[test]
fn the_ridge_is_found_in_the_world() {
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 2.0);
    let affine = centered(64, turn * DMat3::from_diagonal(DVec3::new(0.5, -0.5, 0.6)));
    let volume = biased_ball(1.0, 2.0, affine);
    let Samples::F32(samples) = volume.samples() else { unreachable!() };
    let falling = Samples::F32(samples.iter().map(|s| (s - 50.0) / -4.0).collect());
    let falling = Volume::new([64; 3], falling, Scaling { slope: -4.0, intercept: 50.0 }, affine).unwrap();
    for volume in [volume, falling] {
        let (meshes, _) = snapped(&volume, 100.0);
        // A ball in voxels is an ellipsoid in the world.
        let inverse = affine.linear.inverse();
        let error = |raw: &RawMesh| {
            let radius = |p: &[f32; 3]| (inverse * (vector(p) - MIDDLE)).length() - RADIUS;
            let squares: f64 = raw.positions.iter().map(|p| radius(p).powi(2)).sum();
            (squares / raw.positions.len() as f64).sqrt()
        };
        let [off, on] = meshes.each_ref().map(error);
        assert!(off > 0.25 && on < 0.06, "{off} {on}");
        assert_same_surface(&meshes);
    }
}

#[test]
fn faces_along_the_voxels_stay_flat() {
    let half = 10.5;
    let affine = centered(40, DMat3::IDENTITY);
    for sigma in [0.5, 1.0] {
        let box_of = |p: DVec3| {
            let inside = (p - MIDDLE).to_array().map(|d| blurred(half - d.abs(), sigma));
            (200.0 * inside.iter().product::<f64>()) as f32
        };
        // At less than a third of the height the isosurface lies well outside.
        let (meshes, report) = snapped(&Field::new([40; 3], affine).volume(box_of), 60.0);
        let off_faces = |raw: &RawMesh| {
            let off = |p: &[f32; 3]| {
                let mut d = (vector(p) - MIDDLE).abs().to_array();
                d.sort_by(f64::total_cmp);
                // Away from the edges.
                (d[1] < 7.5).then_some(d[2] - half)
            };
            let off: Vec<f64> = raw.positions.iter().filter_map(off).collect();
            let [low, high] = [f64::min, f64::max].map(|f| off.iter().copied().reduce(f).unwrap());
            (off.len(), low, high)
        };
        let (_, low, _) = off_faces(&meshes[0]);
        assert!(low > 0.4);
        let (count, low, high) = off_faces(&meshes[1]);
        assert!(count > 1000 && low > -0.02 && high < 0.02, "{sigma}: {low} to {high}");
        assert_eq!(report.held, 0);
        assert_same_surface(&meshes);
    }
}

/// Values that rise everywhere alike have no boundary; a little noise on them makes none.
#[test]
fn without_a_ridge_nothing_moves() {
    for (noise, most) in [(0.0, 0.0), (1.0, 0.02), (3.0, 0.3)] {
        let ramp = |p: DVec3| {
            let voxel = (p.x + 40.0 * (p.y + 40.0 * p.z)) as u64;
            let random = (hash(7, voxel) >> 40) as f64 / f64::from(1 << 24) - 0.5;
            (5.0 * p.z + noise * random) as f32
        };
        let volume = Field::new([40; 3], Affine::from_spacing([1.0; 3])).volume(ramp);
        let (meshes, report) = snapped(&volume, 97.0);
        assert!(longest_move(&meshes) <= most, "noise {noise}: {} voxels", longest_move(&meshes));
        assert_same_surface(&meshes);
        assert_eq!(open_edges(&meshes[0].triangles).0.len(), 4 * 39);
        assert!(noise > 0.0 || report.found == 0);
    }
}

/// Noise all over and nothing else: surfaces are rough, and must stay in one piece and within reach.
#[test]
fn noise_folds_nothing() {
    let value = |p: DVec3| (hash(3, (p.x + 32.0 * (p.y + 32.0 * p.z)) as u64) >> 56) as u8;
    let volume = Field::new([32; 3], Affine::from_spacing([1.0; 3])).volume(value);
    let before = iso(&volume, 100.5);
    let mut after = before.clone();
    let report = volume.snap_to_ridge(&mut after, None);
    assert!(report.held > 0, "too tame to say anything");
    assert!(longest_move(&[before.clone(), after.clone()]) <= 1.5 + 1e-5);
    assert_eq!(before.triangles, after.triangles);
    let mesh = mesh_of(after);
    assert_eq!(mesh.triangles.len(), before.triangles.len());
}

#[test]
fn samples_that_are_no_numbers_are_no_ridge() {
    let affine = centered(64, DMat3::IDENTITY);
    let Samples::F32(mut samples) = biased_ball(1.0, 2.0, affine).samples().clone() else { unreachable!() };
    // A slice through the ball.
    for i in 0..64 * 64 {
        samples[64 * 64 * 20 + i] = f32::NAN;
    }
    let volume = Volume::new([64; 3], Samples::F32(samples), Scaling::default(), affine).unwrap();
    let mut raw = volume.isosurface(100.0, &Default::default(), &mut Default::default()).unwrap();
    let report = volume.snap_to_ridge(&mut raw, None);
    assert!(report.found > 0 && report.found < report.vertices);
    assert!(raw.positions.iter().chain(&raw.normals).flatten().all(|v| v.is_finite()));
}

#[test]
fn beside_a_cut_nothing_moves() {
    let volume = biased_ball(1.0, 2.0, centered(64, DMat3::IDENTITY));
    let bounds = volume.bounds();
    // Removed is what both say; the plane of z alone cuts nothing where x < 0.5.
    let region = ClipRegion::parse("x>0.5;z>0.5", bounds).unwrap();
    let before = iso(&volume, 60.0);
    let mut after = before.clone();
    volume.snap_to_ridge(&mut after, Some(&region));
    let mut free = before.clone();
    volume.snap_to_ridge(&mut free, None);
    let (mut beside, mut away) = (0, 0);
    for ((b, a), f) in before.positions.iter().zip(&after.positions).zip(&free.positions) {
        let p = vector(b) - MIDDLE;
        let within = p.x.min(p.z);
        if within.abs() < 2.0 {
            assert_eq!(a, b, "{p}");
            beside += 1;
        } else if within.abs() > 6.0 {
            assert_eq!(a, f, "{p}");
            away += 1;
        }
    }
    assert!(beside > 300 && away > 1000);
}

#[test]
fn any_number_of_threads_gives_the_same_surface() {
    let volume = biased_ball(1.0, 2.0, centered(64, DMat3::IDENTITY));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| snapped(&volume, 100.0))
    };
    assert!(with(1) == with(2) && with(1) == with(5));
}
