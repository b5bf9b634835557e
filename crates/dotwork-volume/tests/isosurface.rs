//! Isosurfaces of fields whose surfaces are known, and of fields that have every case a cell can have.

mod common;

use std::f64::consts::PI;

use common::{Field, hash, iso, iso_capped, mesh_of, open_edges};
use dotwork_drawing::Warnings;
use dotwork_mesh::RawMesh;
use dotwork_volume::{Affine, IsoError, IsoOptions, Sample, Samples, Scaling, Space, Unit, Volume};
use glam::{DMat3, DVec3};

/// A sphere of radius 10 about (1, 2, 3) in world units, sampled through `affine`.
fn sphere(dims: [usize; 3], affine: Affine) -> Volume {
    let center = DVec3::new(1.0, 2.0, 3.0);
    Field::new(dims, affine).volume(|p| (10.0 - p.distance(center)) as f32)
}

/// An affine that puts the middle of `dims` voxels with these steps at (1, 2, 3).
fn centered(dims: [usize; 3], linear: DMat3) -> Affine {
    let middle = linear * DVec3::from_array(dims.map(|n| (n - 1) as f64 / 2.0));
    Affine { linear, origin: DVec3::new(1.0, 2.0, 3.0) - middle, space: Space::Unknown, unit: Unit::Unknown }
}

/// The sphere of [`sphere`] within these tolerances: distance of vertices, area and volume in shares, normals in
/// degrees.
fn assert_sphere(raw: RawMesh, distance: f64, area: f64, degrees: f64) {
    let center = DVec3::new(1.0, 2.0, 3.0) - DVec3::from_array(raw.origin);
    for (p, n) in raw.positions.iter().zip(&raw.normals) {
        let [p, n] = [p, n].map(|v| DVec3::from_array(v.map(f64::from)));
        let out = p - center;
        assert!((out.length() - 10.0).abs() < distance, "{} from the centre", out.length());
        assert!((n.length() - 1.0).abs() < 1e-5);
        let off = n.angle_between(out).to_degrees();
        assert!(off < degrees, "normal off by {off} degrees at {p}");
    }
    // Facets agree with the normals: counter-clockwise from outside.
    for t in &raw.triangles {
        let [a, b, c] = t.map(|v| DVec3::from_array(raw.positions[v as usize].map(f64::from)));
        assert!((b - a).cross(c - a).dot(a - center) > 0.0);
    }
    let mesh = mesh_of(raw);
    let stats = mesh.stats();
    assert!(mesh.closed);
    assert_eq!((stats.components, stats.euler_characteristic), (1, 2));
    assert!((stats.area / (400.0 * PI) - 1.0).abs() < area, "area {}", stats.area);
    assert!((stats.volume / (4000.0 * PI / 3.0) - 1.0).abs() < area, "volume {}", stats.volume);
}

#[test]
fn a_sphere_is_a_sphere() {
    let dims = [50, 50, 50];
    let volume = sphere(dims, centered(dims, DMat3::from_diagonal(DVec3::splat(0.5))));
    assert_sphere(iso(&volume, 0.0), 0.004, 0.002, 0.2);
}

#[test]
fn physical_spacing_counts_in_positions_and_normals() {
    let dims = [100, 50, 26];
    let volume = sphere(dims, centered(dims, DMat3::from_diagonal(DVec3::new(0.25, 0.5, 1.0))));
    assert_sphere(iso(&volume, 0.0), 0.014, 0.004, 0.8);
}

#[test]
fn sheared_turned_and_mirrored_grids_give_the_same_sphere() {
    let dims = [60, 60, 60];
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 2.0);
    let shear =
        DMat3::from_cols(DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.1, 0.5, 0.0), DVec3::new(0.0, -0.15, 0.45));
    for mirror in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, -1.0), -DVec3::ONE] {
        let affine = centered(dims, turn * DMat3::from_diagonal(mirror) * shear);
        assert_eq!(affine.is_mirrored(), mirror.x * mirror.y * mirror.z < 0.0);
        assert_sphere(iso(&sphere(dims, affine), 0.0), 0.006, 0.002, 0.4);
    }
}

/// The same voxels under a falling scaling: dense matter has small samples.
#[test]
fn negative_slopes_turn_the_inside_but_not_the_surface() {
    let dims = [50, 50, 50];
    let affine = centered(dims, DMat3::from_diagonal(DVec3::splat(0.5)));
    let volume = sphere(dims, affine);
    let Samples::F32(samples) = volume.samples() else { unreachable!() };
    let falling = Samples::F32(samples.iter().map(|s| (s - 50.0) / -4.0).collect());
    let falling = Volume::new(dims, falling, Scaling { slope: -4.0, intercept: 50.0 }, affine).unwrap();
    assert_sphere(iso(&falling, 0.0), 0.004, 0.002, 0.2);
    assert_eq!(iso(&falling, 0.0).triangles, iso(&volume, 0.0).triangles);
}

#[test]
fn volumes_far_from_the_origin_keep_their_precision() {
    let dims = [50, 50, 50];
    let mut affine = centered(dims, DMat3::from_diagonal(DVec3::splat(0.5)));
    let near = iso(&sphere(dims, affine), 0.0);
    assert_eq!(near.origin, [0.0; 3]);
    let volume = sphere(dims, affine);
    affine.origin += DVec3::new(4e6, -3e6, 0.0);
    let far = Volume::new(dims, volume.samples().clone(), Scaling::default(), affine).unwrap();
    let raw = iso(&far, 0.0);
    assert_eq!(raw.origin, [4_000_001.0, -2_999_998.0, 3.0]);
    for (far, near) in raw.positions.iter().zip(&near.positions) {
        let difference = DVec3::from_array(far.map(f64::from)) + DVec3::new(1.0, 2.0, 3.0)
            - DVec3::from_array(near.map(f64::from));
        assert!(difference.length() < 1e-5);
    }
}

#[test]
fn a_torus_has_a_hole() {
    let field = Field::new([64, 60, 30], Affine::from_spacing([1.0; 3]));
    let volume = field.volume(|p| {
        let p = p - DVec3::new(31.5, 29.5, 14.5);
        6.0 - (p.truncate().length() - 20.0).hypot(p.z)
    });
    let mesh = mesh_of(iso(&volume, 0.0));
    let stats = mesh.stats();
    assert!(mesh.closed);
    assert_eq!((stats.components, stats.euler_characteristic), (1, 0));
    assert!((stats.area / (4.0 * PI * PI * 20.0 * 6.0) - 1.0).abs() < 0.005);
    let share = stats.volume / (2.0 * PI * PI * 20.0 * 36.0);
    assert!((share - 1.0).abs() < 0.01, "{share}");
}

/// A linear field is reproduced to rounding, up to and on the border.
#[test]
fn a_plane_is_flat_with_one_normal() {
    let slope = DVec3::new(0.3, -0.7, 1.1);
    let affine = Affine::from_spacing([1.0, 2.0, 0.5]);
    let volume = Field::new([20, 12, 40], affine).volume(|p| slope.dot(p));
    let raw = iso(&volume, 4.123);
    assert!(raw.positions.len() > 300);
    let down = -slope.normalize();
    for (p, n) in raw.positions.iter().zip(&raw.normals) {
        let [p, n] = [p, n].map(|v| DVec3::from_array(v.map(f64::from)));
        assert!((slope.dot(p) - 4.123).abs() < 1e-5, "{p}");
        assert!(n.distance(down) < 1e-5, "{n}");
    }
    // Open where it meets the border, and nowhere else; closed with caps.
    let (open, conflicts) = open_edges(&raw.triangles);
    assert_eq!(conflicts, 0);
    assert!(!open.is_empty());
    let [low, high] = volume.bounds();
    for v in open.iter().flatten() {
        let p = DVec3::from_array(raw.positions[*v as usize].map(f64::from));
        let depth = (p - low).min(high - p).min_element();
        assert!(depth.abs() < 1e-5, "an open edge at {p}");
    }
    assert_eq!(open_edges(&iso_capped(&volume, 4.123).triangles), (vec![], 0));
}

/// Caps lie at the centres of the border voxels and face outwards.
#[test]
fn caps_are_flat_and_close_the_surface() {
    let volume = Field::new([12, 9, 7], Affine::from_spacing([1.0, 2.0, 3.0])).volume(|p| p.x - 4.5);
    let raw = iso_capped(&volume, 0.0);
    let mesh = mesh_of(raw.clone());
    assert!(mesh.closed);
    assert_eq!(mesh.stats().euler_characteristic, 2);
    // From x = 4.5 to the last voxel at 11, in y to 16, in z to 18.
    assert!((mesh.volume() / (6.5 * 16.0 * 18.0) - 1.0).abs() < 0.002, "{}", mesh.volume());
    let mut caps = 0;
    for (p, n) in raw.positions.iter().zip(&raw.normals) {
        let [x, y, z] = *p;
        let near = |a: f32, b: f32| (a - b).abs() < 0.01;
        if near(x, 11.0) && !near(y, 0.0) && !near(y, 16.0) && !near(z, 0.0) && !near(z, 18.0) {
            assert_eq!(*n, [1.0, 0.0, 0.0]);
            assert!(x > 11.0);
            caps += 1;
        }
    }
    assert_eq!(caps, 7 * 5);
    assert!(!mesh_of(iso(&volume, 0.0)).closed);
}

/// Each of the 256 cases alone, in a cell among samples below.
#[test]
fn every_single_cell_is_a_closed_surface() {
    for inside in 0..=255u8 {
        let mut samples = vec![0u8; 64];
        for corner in 0..8 {
            if inside >> corner & 1 == 1 {
                samples[(1 + (corner & 1)) + 4 * ((1 + (corner >> 1 & 1)) + 4 * (1 + (corner >> 2)))] = 10;
            }
        }
        let volume = Volume::from_vec([4, 4, 4], [1.0; 3], samples).unwrap();
        let surface = volume.isosurface(3.0, &IsoOptions::default(), &mut Warnings::new());
        if inside == 0 {
            assert_eq!(surface, Err(IsoError::NoSurface { iso: 3.0, min: 0.0, max: 0.0 }));
            continue;
        }
        let raw = surface.unwrap();
        assert_eq!(open_edges(&raw.triangles), (vec![], 0), "case {inside:08b}");
        assert!(mesh_of(raw).closed, "case {inside:08b}");
    }
}

/// Noise has every pair of cases side by side. Samples that equal the iso value are frequent.
#[test]
fn noise_is_closed_by_caps_and_winds_consistently() {
    for (seed, levels, threshold) in [(1, 2, 1.0), (2, 3, 1.0), (3, 5, 2.0), (4, 255, 127.5), (5, 4, 3.0)] {
        let dims = [67, 21, 19];
        let samples: Vec<u8> =
            (0..dims.iter().product::<usize>() as u64).map(|i| (hash(seed, i) % levels) as u8).collect();
        let volume = Volume::from_vec(dims, [1.0, 1.0, 2.0], samples).unwrap();
        let raw = iso_capped(&volume, threshold);
        assert_eq!(open_edges(&raw.triangles), (vec![], 0), "seed {seed}");
        let triangles = raw.triangles.len();
        let mut used = vec![false; raw.positions.len()];
        raw.triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
        assert!(used.iter().all(|&u| u));
        // No two vertices coincide and no triangle collapses: cleaning finds nothing to do.
        let mesh = mesh_of(raw);
        assert!(mesh.closed);
        assert_eq!(mesh.triangles.len(), triangles);

        // Without caps the same surface ends at the border only.
        let open = iso(&volume, threshold);
        let (edges, conflicts) = open_edges(&open.triangles);
        assert_eq!(conflicts, 0);
        let [low, high] = volume.bounds();
        for v in edges.iter().flatten() {
            let p = DVec3::from_array(open.positions[*v as usize].map(f64::from));
            assert_eq!((p - low).min(high - p).min_element(), 0.0);
        }
    }
}

/// One voxel inside, at the end of rows of all lengths around a word of 64.
#[test]
fn rows_of_any_length_keep_their_last_cells() {
    for nx in [2, 3, 62, 63, 64, 65, 66, 127, 128, 129, 130] {
        for x in [0, nx / 2, nx - 1] {
            let mut samples = vec![0u16; nx * 3 * 3];
            samples[x + nx * 4] = 2;
            let volume = Volume::from_vec([nx, 3, 3], [1.0; 3], samples).unwrap();
            let raw = iso_capped(&volume, 1.0);
            assert_eq!((raw.positions.len(), raw.triangles.len()), (6, 8), "{x} of {nx}");
            assert_eq!(open_edges(&raw.triangles), (vec![], 0));
            let open = iso(&volume, 1.0);
            let inner = 6 - usize::from(x == 0) - usize::from(x == nx - 1);
            assert_eq!(open.positions.len(), inner);
        }
    }
}

/// The same ball in every type, shifted to the ends of its range.
#[test]
fn every_type_gives_the_same_surface() {
    fn check<T: Sample>(base: f64, from: impl Fn(i32) -> T) {
        let n = 24;
        let samples: Vec<T> = (0..n * n * n)
            .map(|i| {
                let [x, y, z] = [i % n, i / n % n, i / n / n].map(|v| f64::from(v) - 11.5);
                from((100.0 - 10.0 * (x * x + y * y + z * z).sqrt()).round().max(-27.0) as i32)
            })
            .collect();
        let volume = Volume::from_vec([n as usize; 3], [1.0; 3], samples).unwrap();
        let raw = iso(&volume, base);
        let mesh = mesh_of(raw.clone());
        assert!(mesh.closed);
        for (p, n) in raw.positions.iter().zip(&raw.normals) {
            let [p, n] = [p, n].map(|v| DVec3::from_array(v.map(f64::from)));
            let out = p - DVec3::splat(11.5);
            assert!((out.length() - 10.0).abs() < 0.1, "{}: {out}", T::TYPE.name());
            assert!(n.angle_between(out).to_degrees() < 6.0, "{}", T::TYPE.name());
        }
    }
    check::<u8>(30.0, |v| (v + 30) as u8);
    check::<i8>(0.0, |v| v as i8);
    check::<u16>(65400.0, |v| (v + 65400) as u16);
    check::<i16>(-32700.0, |v| (v - 32700) as i16);
    check::<u32>(4294967000.0, |v| (4294967000 + i64::from(v)) as u32);
    check::<i32>(-2147483000.0, |v| v - 2147483000);
    // Values around 2^63 differ by less than f64 can tell there.
    check::<u64>(2f64.powi(63), |v| (1u64 << 63).wrapping_add_signed(i64::from(v)));
    check::<i64>(-(2f64.powi(62)), |v| i64::from(v) - (1 << 62));
    check::<f32>(-1e6, |v| v as f32 - 1e6);
    check::<f64>(0.0, |v| f64::from(v) * 1e300);
    check::<f64>(0.0, |v| f64::from(v) * 1e-300);
}

#[test]
fn vertices_between_the_largest_numbers_lie_where_they_cross() {
    let samples: Vec<f64> = (0..8).map(|i| if i % 2 == 0 { 1.5e308 } else { -0.5e308 }).collect();
    let raw = iso(&Volume::from_vec([2; 3], [1.0; 3], samples).unwrap(), 0.0);
    assert_eq!(raw.positions.len(), 4);
    assert!(raw.positions.iter().all(|p| (p[0] - 0.75).abs() < 1e-6), "{:?}", raw.positions);
}

#[test]
fn samples_that_are_no_numbers_are_outside_and_said_so() {
    let dims = [20, 20, 20];
    let mut samples: Vec<f32> = (0..8000)
        .map(|i| {
            let [x, y, z] = [i % 20, i / 20 % 20, i / 400].map(|v| v as f32 - 9.5);
            6.0 - (x * x + y * y + z * z).sqrt()
        })
        .collect();
    samples[9 + 20 * (9 + 20 * 9)] = f32::NAN;
    samples[0] = f32::NAN;
    samples[10 + 20 * (10 + 20 * 12)] = f32::INFINITY;
    samples[10 + 20 * (10 + 20 * 18)] = f32::NEG_INFINITY;
    let volume = Volume::from_vec(dims, [1.0; 3], samples).unwrap();
    let mut warnings = Warnings::new();
    let raw = volume.isosurface(0.0, &IsoOptions::default(), &mut warnings).unwrap();
    let text: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        text,
        ["2 voxels whose value is not a number (NaN), taken as outside, first at voxel 0, 0, 0"]
    );
    for v in raw.positions.iter().chain(&raw.normals).flatten() {
        assert!(v.is_finite());
    }
    // The ball, and a hole around the NaN in it.
    let mesh = mesh_of(raw);
    assert!(mesh.closed);
    assert_eq!(mesh.stats().components, 2);
}

/// Plateaus: no gradient on either side, but the edge still says which way is out.
#[test]
fn normals_are_finite_units_on_masks_and_checkerboards() {
    let board: Vec<u8> = (0..6 * 6 * 6).map(|i| ((i % 6 + i / 6 % 6 + i / 36) % 2) as u8).collect();
    for samples in [board, (0..216).map(|i| u8::from(i % 6 > 2)).collect()] {
        let volume = Volume::from_vec([6; 3], [1.0, 2.0, 3.0], samples).unwrap();
        for raw in [iso(&volume, 0.5), iso_capped(&volume, 0.5)] {
            for n in &raw.normals {
                let length = DVec3::from_array(n.map(f64::from)).length();
                assert!((length - 1.0).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn threads_do_not_matter() {
    let field = Field::new([70, 50, 41], Affine::from_spacing([1.0; 3]));
    let volume = field.volume(|p| (p.x * 0.3).sin() + (p.y * 0.4).cos() * (p.z * 0.2).sin());
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (iso_capped(&volume, 0.1), volume.stats(), volume.histogram(32)))
    };
    let one = run(1);
    assert!(one.0.triangles.len() > 10_000);
    assert_eq!(run(2), one);
    assert_eq!(run(7), one);
}

#[test]
fn refusals_say_why() {
    let surface = |volume: &Volume, iso, cap| {
        volume.isosurface(iso, &IsoOptions { cap }, &mut Warnings::new()).map(|m| m.triangles.len())
    };
    let volume = Volume::from_slice([2, 2, 2], [1.0; 3], &[0i16, 1, 2, 3, 4, 5, 6, 7]).unwrap();
    for bad in [-0.5, 0.0, 7.5, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        for cap in [false, true] {
            let error = surface(&volume, bad, cap).unwrap_err();
            assert_eq!(error, IsoError::NoSurface { iso: bad, min: 0.0, max: 7.0 });
        }
    }
    let error = surface(&volume, 9.25, false).unwrap_err();
    assert_eq!(error.to_string(), "no surface at 9.25: the values run from 0 to 7");
    assert!(matches!(surface(&volume, f64::NAN, false), Err(IsoError::NoSurface { .. })));
    assert_eq!(surface(&volume, 7.0, false), Ok(1));
    assert_eq!(surface(&volume, 7.0, true), Ok(8));

    let slice = Volume::from_slice([4, 2, 1], [1.0; 3], &[0u8; 8]).unwrap();
    let error = surface(&slice, 0.5, true).unwrap_err();
    assert_eq!(error.to_string(), "a surface needs at least 2 voxels each way, and there are 4 x 2 x 1");
    let empty = Volume::from_slice([2, 2, 2], [1.0; 3], &[f32::NAN; 8]).unwrap();
    assert_eq!(surface(&empty, 0.5, true), Err(IsoError::NoValues));
}

/// Found by a fuzzer: with steps of 2e52, vertices were infinite.
#[test]
fn a_volume_wider_than_single_precision_has_no_surface() {
    let samples = [0u8, 1, 0, 1, 0, 1, 0, 1];
    let volume = |step: f64| Volume::from_slice([2, 2, 2], [step, 2.0, 3.0], &samples).unwrap();
    let error = volume(2e52).isosurface(0.5, &IsoOptions { cap: true }, &mut Warnings::new()).unwrap_err();
    assert_eq!(error, IsoError::TooWide { extent: 2e52 });
    let wide = iso_capped(&volume(8e37), 0.5);
    assert!(wide.positions.as_flattened().iter().all(|v| v.is_finite()));
}

/// The word that an isosurface gives spares the cleaning of a mesh, and must change nothing.
#[test]
fn what_is_vouched_for_is_what_cleaning_makes() {
    use dotwork_mesh::{Mesh, MeshOptions};
    let dims = [31, 27, 66];
    let turned =
        DMat3::from_cols(DVec3::new(0.3, 0.2, 0.0), DVec3::new(0.2, -0.3, 0.1), DVec3::new(0.0, 0.1, 0.4));
    let mut open = 0;
    for linear in [DMat3::IDENTITY, DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 2.5)), turned] {
        for (kind, cap) in [(0, false), (0, true), (1, false), (1, true), (2, false), (2, true)] {
            let affine = centered(dims, linear);
            let samples: Vec<u8> = (0..dims.iter().product::<usize>())
                .map(|i| {
                    let at = [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]];
                    let middle = [0, 1, 2].map(|k| at[k] as f64 - dims[k] as f64 / 2.0);
                    match kind {
                        // Noise with every case a cell can have, its values often the iso value itself.
                        0 => (hash(3, i as u64) % 5) as u8,
                        // A ball within.
                        1 => (4.0 - middle.iter().map(|v| v * v).sum::<f64>().sqrt() / 3.0).max(0.0) as u8,
                        // A hollow within.
                        _ => (middle.iter().map(|v| v * v).sum::<f64>().sqrt() / 3.0) as u8,
                    }
                })
                .collect();
            let volume = Volume::new(dims, Samples::U8(samples), Scaling::default(), affine).unwrap();
            let raw = volume.isosurface(2.0, &IsoOptions { cap }, &mut Warnings::new()).unwrap();
            assert!(raw.in_order.is_some());
            let options = MeshOptions { orient: false, ..MeshOptions::default() };
            let cleaned =
                Mesh::build(RawMesh { in_order: None, ..raw.clone() }, &options, &mut Warnings::new());
            let mut warnings = Warnings::new();
            let trusted = Mesh::build(raw, &options, &mut warnings);
            assert!(trusted == cleaned, "kind {kind}, cap {cap}");
            assert_eq!(warnings.iter().count(), 0);
            open += u32::from(!trusted.unwrap().closed);
        }
    }
    // Noise without caps alone meets the border.
    assert_eq!(open, 3);
}
