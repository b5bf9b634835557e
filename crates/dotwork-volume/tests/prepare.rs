//! The preparation of volumes against closed forms and a slow, plain reference.

mod common;

use std::sync::Mutex;

use common::{Field, hash, iso, mesh_of, open_edges};
use dotwork_drawing::Warnings;
use dotwork_volume::{
    Affine, Keep, Preparation, PrepareError, Sample, Samples, Scaling, Volume, keep_components, prepare,
};
use glam::{DMat3, DVec3};

/// As the file is: no padding, no smoothing, no resampling.
const PLAIN: Preparation =
    Preparation { window: None, cap: false, isotropic: None, smooth: Some(0.0), crop: None };

/// The prepared volume, with no warning.
fn prepared(volume: &Volume, preparation: &Preparation) -> Volume {
    let mut warnings = Warnings::new();
    let result = prepare(volume, preparation, &|_| {}, &mut warnings).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    result
}

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// Calls `see` with the index of each voxel.
fn each_voxel(dims: [usize; 3], mut see: impl FnMut([usize; 3])) {
    for i in 0..dims.iter().product() {
        see([i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]]);
    }
}

/// An oblique, mirrored, sheared frame far from the origin.
fn crooked(spacing: [f64; 3]) -> Affine {
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.4, -0.3, 1.1);
    let [x, y, z] = spacing;
    let shear = DMat3::from_cols(
        DVec3::new(-x, 0.0, 0.0),
        DVec3::new(0.0, y, 0.0),
        DVec3::new(0.0, 0.6 * z, 0.8 * z),
    );
    Affine { linear: turn * shear, origin: DVec3::new(1e4, -500.0, 3.0), ..Affine::from_spacing([1.0; 3]) }
}

#[test]
fn values_and_places_are_those_of_the_source() {
    fn check<T: Sample>(scaling: Scaling, sample: impl Fn(u64) -> T) {
        let dims = [37, 41, 45];
        let count = dims.iter().product::<usize>() as u64;
        let samples: Vec<T> = (0..count).map(|i| sample(hash(9, i))).collect();
        let volume = Volume::new(dims, T::wrap(samples), scaling, crooked([1.0; 3])).unwrap();
        let (min, max) = volume.value_range().unwrap();
        let result = prepared(&volume, &Preparation { window: Some([min, max]), ..PLAIN });
        assert_eq!((result.dims(), result.affine()), (dims, volume.affine()));
        let step = (max - min) / 65535.0;
        each_voxel(dims, |[x, y, z]| {
            let off = (result.value_at(x, y, z) - volume.value_at(x, y, z)).abs();
            assert!(off < 0.51 * step, "{} {x} {y} {z}: {off} of {step}", T::TYPE);
        });
    }
    let real = |h: u64| (h >> 11) as f64 / (1u64 << 53) as f64;
    check(Scaling::default(), |h| h as u8);
    check(Scaling { slope: -2.0, intercept: 100.0 }, |h| h as i8);
    check(Scaling { slope: -0.25, intercept: -1024.0 }, |h| (h % 60000) as i16);
    check(Scaling::default(), |h| (h % 5000) as u16 + 60000);
    check(Scaling { slope: 3.0, intercept: 0.0 }, |h| h as i32);
    check(Scaling::default(), |h| (h % 1000) as u32 + 4_000_000_000);
    check(Scaling::default(), |h| (h % 100_000) as i64 + (1 << 40));
    check(Scaling { slope: 1e-3, intercept: 0.0 }, |h| h >> 1);
    check(Scaling { slope: -1.0, intercept: 0.0 }, |h| 1e6 + real(h) as f32);
    check(Scaling::default(), |h| 1e200 * (real(h) - 0.5));
}

/// A straight ramp is the one field that neither interpolation nor smoothing changes.
#[test]
fn ramps_stay_ramps() {
    for spacing in [[1.0, 1.0, 1.0], [1.0, 1.0, 2.0], [3.0, 1.0, 1.0], [1.0, 2.7, 1.4], [0.5, 4.0, 2.0]] {
        let affine = crooked(spacing);
        // Across the volume in every axis, in index space.
        let value = |p: DVec3| {
            let index = affine.linear.inverse() * (p - affine.origin);
            (20.0 + 3.0 * index.x - 2.0 * index.y + 1.5 * index.z) as f32
        };
        let volume = Field::new([29, 25, 27], affine).volume(value);
        for (cap, smooth) in [(false, 0.0), (false, 0.5), (true, 0.5), (true, 0.3)] {
            let preparation = Preparation {
                window: Some([-200.0, 300.0]),
                cap,
                smooth: Some(smooth),
                ..Preparation::default()
            };
            let result = prepared(&volume, &preparation);
            assert!(result.affine().anisotropy() < 1.1, "{:?}", result.spacing());
            let (mut seen, mut worst) = (0, 0.0f64);
            each_voxel(result.dims(), |[x, y, z]| {
                let p = result.affine().point([x as f64, y as f64, z as f64]);
                let index = affine.linear.inverse() * (p - affine.origin);
                // In the middle, which no kernel leaves from here.
                if (index - DVec3::new(14.0, 12.0, 13.0)).abs().max_element() < 1.01 {
                    seen += 1;
                    worst = worst.max((result.value_at(x, y, z) - f64::from(value(p))).abs());
                }
            });
            assert!(seen >= 27 && worst < 500.0 / 65535.0, "{spacing:?} {cap} {smooth}: {worst} of {seen}");
        }
    }
}

/// A Gaussian smoothed by a Gaussian is a Gaussian: variances add up, the peak falls by the ratio of the volumes.
#[test]
fn smoothing_widens_a_gaussian_by_its_sigma() {
    for (spacing, blob, sigma) in
        [([1.0; 3], 2.0, 0.5), ([1.0; 3], 1.5, 1.0), ([0.25; 3], 0.6, 0.5), ([1.0, 1.0, 2.0], 4.0, 0.75)]
    {
        let n = [41, 43, if spacing[2] > spacing[0] { 25 } else { 45 }];
        let affine = Affine::from_spacing(spacing);
        let middle = affine.point(n.map(|n| (n / 2) as f64));
        let volume = Field::new(n, affine)
            .volume(|p| (-(p - middle).length_squared() / (2.0 * blob * blob)).exp() as f32);
        let preparation = Preparation {
            window: Some([0.0, 1.0]),
            cap: true,
            smooth: Some(sigma),
            ..Preparation::default()
        };
        let result = prepared(&volume, &preparation);
        let wide = spacing.into_iter().fold(0.0, f64::max) * sigma;
        let variance = blob * blob + wide * wide;
        let scale = (blob * blob / variance).powf(1.5);
        let (mut mass, mut second, mut worst) = (0.0, DVec3::ZERO, 0.0f64);
        each_voxel(result.dims(), |[x, y, z]| {
            let p = result.affine().point([x as f64, y as f64, z as f64]) - middle;
            let value = result.value_at(x, y, z);
            mass += value;
            second += value * p * p;
            worst = worst.max((value - scale * (-p.length_squared() / (2.0 * variance)).exp()).abs());
        });
        let found = second / mass;
        assert!(
            found.distance(DVec3::splat(variance)) < 0.006 * variance,
            "{spacing:?} {sigma}: {found} {variance}"
        );
        assert!(worst < 0.005, "{spacing:?} {sigma}: {worst}");
    }
}

/// A slow, plain reference: each result voxel by eight nested loops over the source, from the definitions alone.
#[test]
fn every_voxel_is_what_the_definitions_say() {
    let dims = [11, 9, 7];
    let samples: Vec<u8> = (0..dims.iter().product::<usize>() as u64).map(|i| hash(4, i) as u8).collect();
    let volume = Volume::from_vec(dims, [1.0, 1.0, 2.0], samples).unwrap();
    let keys = |x: f64| {
        let x = x.abs();
        match x {
            _ if x < 1.0 => 1.5 * x * x * x - 2.5 * x * x + 1.0,
            _ if x < 2.0 => -0.5 * x * x * x + 2.5 * x * x - 4.0 * x + 2.0,
            _ => 0.0,
        }
    };
    // The result's sigma is one voxel, where a sampled Gaussian is a Gaussian.
    let gauss = |n: i32| (-0.5 * f64::from(n * n)).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let g: Vec<f64> = (-8..=8).map(gauss).collect();
    for cap in [true, false] {
        let preparation = Preparation { window: Some([0.0, 255.0]), cap, ..Preparation::default() };
        let result = prepared(&volume, &preparation);
        let pad = if cap { [3, 3, 6] } else { [0; 3] };
        assert_eq!(result.dims(), [11 + 2 * pad[0], 9 + 2 * pad[1], 13 + 2 * pad[2]]);
        // Along one axis: the weight of source sample j in result voxel k.
        let weight = |axis: usize, k: usize, j: i64| -> f64 {
            let step = if axis == 2 { 0.5 } else { 1.0 };
            (-8i64..=8)
                .map(|t| {
                    g[(t + 8) as usize] * keys((k as i64 - pad[axis] as i64 + t) as f64 * step - j as f64)
                })
                .sum()
        };
        let table = |axis: usize, k: usize| -> Vec<f64> {
            let n = dims[axis] as i64;
            let mut row = vec![0.0; n as usize];
            for j in -12..n + 12 {
                let inside = j.clamp(0, n - 1);
                if inside == j || !cap {
                    row[inside as usize] += weight(axis, k, j);
                }
            }
            row
        };
        let tables: Vec<Vec<Vec<f64>>> =
            (0..3).map(|a| (0..result.dims()[a]).map(|k| table(a, k)).collect()).collect();
        let mut worst = 0.0f64;
        each_voxel(result.dims(), |[x, y, z]| {
            let mut sum = 0.0;
            each_voxel(dims, |[i, j, k]| {
                sum += tables[0][x][i] * tables[1][y][j] * tables[2][z][k] * volume.value_at(i, j, k);
            });
            worst = worst.max((result.value_at(x, y, z) - sum.clamp(0.0, 255.0)).abs());
        });
        // The tails cut off hold a thousandth.
        assert!(worst < 0.35, "{cap}: {worst}");
    }
}

/// Spheres scanned in slices three times as thick as wide come out round and smooth.
#[test]
fn thick_slices_leave_no_terraces() {
    let affine = Affine::from_spacing([1.0, 1.0, 3.0]);
    let radius = 40.0;
    let middle = DVec3::new(48.3, 47.6, 49.1);
    // A scanner's edge, two voxels wide.
    let volume = Field::new([96, 96, 33], affine)
        .volume(|p| (1000.0 / (1.0 + (-(radius - (p - middle).length()) / 1.5).exp())) as u16);
    let judge = |volume: &Volume| {
        let raw = iso(volume, 500.0);
        let (mut worst, mut sum, mut off) = (0.0f64, 0.0, 0.0);
        for (p, n) in raw.positions.iter().zip(&raw.normals) {
            let away = DVec3::from(p.map(f64::from)) - middle;
            let error = away.length() - radius;
            worst = worst.max(error.abs());
            sum += error * error;
            off += away.normalize().angle_between(DVec3::from(n.map(f64::from))).to_degrees().powi(2);
        }
        let n = raw.positions.len() as f64;
        assert!(n > 5000.0);
        (worst, (sum / n).sqrt(), (off / n).sqrt())
    };
    let (_, _, terraces) = judge(&volume);
    for (smooth, most) in [(Some(0.0), [0.1, 0.03, 1.2]), (None, [0.1, 0.09, 0.5])] {
        let result =
            prepared(&volume, &Preparation { window: Some([0.0, 1000.0]), smooth, ..Preparation::default() });
        assert_eq!(result.spacing(), [1.0; 3]);
        let (worst, rms, normals) = judge(&result);
        assert!(worst < most[0] && rms < most[1], "{smooth:?}: {worst} {rms}");
        assert!(normals < most[2] && normals < 0.5 * terraces, "{smooth:?}: {normals} of {terraces} degrees");
    }
}

#[test]
fn the_cap_closes_what_the_border_cuts() {
    // Half a sphere, cut by three faces; and a crop that cuts two more.
    for (affine, crop) in [
        (Affine::from_spacing([1.0; 3]), None),
        (Affine::from_spacing([1.0, 1.0, 2.0]), None),
        (Affine::from_spacing([1.0; 3]), Some([[0.0, 0.4], [0.2, 1.0], [0.0, 1.0]])),
    ] {
        let volume = Field::new([30, 32, 20], affine).volume(|p| (100.0 - 5.0 * p.length()).max(0.0) as f32);
        let open = prepared(&volume, &Preparation { cap: false, crop, ..Preparation::default() });
        assert!(!open_edges(&iso(&open, 30.0).triangles).0.is_empty());
        let closed = prepared(&volume, &Preparation { crop, ..Preparation::default() });
        let raw = iso(&closed, 30.0);
        assert_eq!(open_edges(&raw.triangles), (vec![], 0));
        assert!(mesh_of(raw).closed);
    }
}

#[test]
fn results_lie_where_the_source_lies() {
    let affine = crooked([0.7, 0.7, 2.1]);
    let volume = Field::new([20, 16, 12], affine).volume(|p| p.x as f32);
    for (crop, from, kept) in [
        (None, [0, 0, 0], [20, 16, 12]),
        (Some([[0.25, 0.75], [0.0, 0.5], [0.5, 1.0]]), [5, 0, 6], [10, 8, 6]),
        (Some([[0.0, 0.01], [0.5, 0.51], [0.0, 1.0]]), [0, 8, 0], [1, 1, 12]),
    ] {
        for cap in [false, true] {
            let preparation = Preparation { crop, cap, isotropic: Some(1.0), ..Preparation::default() };
            let result = prepared(&volume, &preparation);
            let thick = kept[0] > 1;
            let step = if thick { 3 } else { 1 };
            let pad = if cap { [3, 3, 3 * step] } else { [0; 3] };
            let ends = [kept[0] - 1, kept[1] - 1, (kept[2] - 1) * step];
            assert_eq!(result.dims(), [0, 1, 2].map(|a| ends[a] + 1 + 2 * pad[a]));
            // The first and the last voxel that is kept, from both sides.
            let first = result.affine().point(pad.map(|p| p as f64));
            assert!(first.distance(affine.point(from.map(|i| i as f64))) < 1e-9);
            let last = result.affine().point([0, 1, 2].map(|a| (pad[a] + ends[a]) as f64));
            assert!(last.distance(affine.point([0, 1, 2].map(|a| (from[a] + kept[a] - 1) as f64))) < 1e-9);
            assert_eq!(result.affine().is_mirrored(), affine.is_mirrored());
            assert!((result.spacing()[2] - 2.1 / step as f64).abs() < 1e-9);
        }
    }
}

#[test]
fn single_slices_become_slabs() {
    let disc = |p: DVec3| if (p - DVec3::new(8.0, 8.0, 0.0)).length() < 5.0 { 200u8 } else { 3 };
    let volume = Field::new([17, 17, 1], Affine::from_spacing([1.0, 1.0, 5.0])).volume(disc);
    let slab = prepared(&volume, &Preparation::default());
    assert_eq!((slab.dims(), slab.spacing()), ([23, 23, 7], [1.0, 1.0, 5.0]));
    assert!(mesh_of(iso(&slab, 100.0)).closed);
    let slice = prepared(&volume, &Preparation { cap: false, ..Preparation::default() });
    assert_eq!(slice.dims(), [17, 17, 1]);
    let Samples::U8(samples) = volume.samples() else { panic!("bytes") };
    // How thick a slice is said to be changes nothing in it.
    for thickness in [1e-9, 0.1, 1.0, 1e6] {
        let volume = Volume::from_vec([17, 17, 1], [1.0, 1.0, thickness], samples.clone()).unwrap();
        let slab = prepared(&volume, &Preparation::default());
        assert_eq!(slab.dims(), [23, 23, 7]);
        assert!((slab.value_at(11, 11, 3) - 200.0).abs() < 0.01, "{thickness}");
    }
    let line = Volume::from_vec([1, 9, 1], [1.0; 3], (0..9u8).collect()).unwrap();
    assert_eq!(prepared(&line, &Preparation::default()).dims(), [7, 15, 7]);
    assert_eq!(prepared(&line, &PLAIN).dims(), [1, 9, 1]);
}

#[test]
fn gaps_count_as_low_and_are_said() {
    let mut samples: Vec<f32> = (0..1000).map(|i| (i % 10) as f32).collect();
    samples[123] = f32::NAN;
    samples[457] = f32::NAN;
    samples[555] = f32::INFINITY;
    samples[556] = f32::NEG_INFINITY;
    let volume = Volume::from_vec([10, 10, 10], [1.0; 3], samples).unwrap();
    let mut warnings = Warnings::new();
    let preparation = Preparation { window: Some([1.0, 8.0]), ..PLAIN };
    let result = prepare(&volume, &preparation, &|_| {}, &mut warnings).unwrap();
    let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        ["2 voxels whose value is not a number (NaN), taken as the low value, first at voxel 3, 2, 1"]
    );
    let value = |i: usize| result.value_at(i % 10, i / 10 % 10, i / 100);
    let near = |i: usize, v: f64| assert!((value(i) - v).abs() < 1e-3, "{i}: {}", value(i));
    for (i, v) in [(123, 1.0), (457, 1.0), (555, 8.0), (556, 1.0), (0, 1.0), (9, 8.0), (4, 4.0)] {
        near(i, v);
    }
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let refused = |volume: &Volume, preparation: &Preparation| {
        let mut warnings = Warnings::new();
        let error = prepare(volume, preparation, &|_| {}, &mut warnings).unwrap_err();
        assert!(warnings.is_empty());
        error.to_string()
    };
    let flat = Volume::from_vec([3, 3, 3], [1.0; 3], vec![7u8; 27]).unwrap();
    let default = Preparation::default();
    assert_eq!(refused(&flat, &default), "all values are 7: there is nothing to draw");
    let nan = Volume::from_vec([3, 3, 3], [1.0; 3], vec![f32::NAN; 27]).unwrap();
    assert_eq!(refused(&nan, &default), "none of the samples is a finite number: there is nothing to draw");
    let ramp = Volume::from_vec([3, 3, 3], [1.0; 3], (0..27u8).collect()).unwrap();
    assert_eq!(
        refused(&ramp, &Preparation { window: Some([30.0, 40.0]), ..default }),
        "the window 30 to 40 shows nothing of values from 0 to 26"
    );
    let crop = Some([[0.0, 1.0], [0.6, 0.4], [0.0, 1.0]]);
    assert_eq!(
        refused(&ramp, &Preparation { crop, ..default }),
        "a crop along y from 0.6 to 0.4 is no part of 0 to 1"
    );
    assert_eq!(
        refused(&ramp, &Preparation { smooth: Some(-1.0), ..default }),
        "smooth is -1, and must be from 0 to 8"
    );
    assert_eq!(
        refused(&ramp, &Preparation { isotropic: Some(f64::NAN), ..default }),
        "isotropic is NaN, and must be at least 1"
    );
    let line = Volume::from_vec([1, 1, 1 << 24], [1.0; 3], (0..1 << 24).map(|i| i as u8).collect()).unwrap();
    assert!(refused(&line, &default).starts_with("there is no room for 7 x 7 x 16777222 prepared voxels"));
    let mut not_prepared = ramp.clone();
    assert_eq!(keep_components(&mut not_prepared, 3.0, Keep::Auto), Err(PrepareError::Unprepared));
    let extremes = Volume::from_vec([2, 1, 1], [1.0; 3], vec![f64::MIN, f64::MAX]).unwrap();
    assert!(refused(&extremes, &default).starts_with("the window"));
}

/// A spacing ratio of 4000 would take 4000 times the memory.
#[test]
fn extreme_spacings_are_resampled_within_bounds() {
    let samples: Vec<u8> = (0..64 * 64 * 64).map(|i| hash(8, i) as u8).collect();
    let volume = Volume::from_vec([64, 64, 64], [1.0, 1.0, 4000.0], samples).unwrap();
    let mut warnings = Warnings::new();
    let result =
        prepare(&volume, &Preparation { cap: false, ..Preparation::default() }, &|_| {}, &mut warnings)
            .unwrap();
    let voxels: usize = result.dims().iter().product();
    assert!(voxels <= 1 << 27 && voxels > 1 << 26, "{voxels}");
    let text = warnings.iter().next().unwrap().to_string();
    assert!(
        text.starts_with("resampled to steps of 7.") && text.contains("times the voxels of the file"),
        "{text}"
    );
    assert!((result.extent()[2] - result.spacing()[2] - 63.0 * 4000.0).abs() < 1e-6);
}

#[test]
fn threads_change_nothing_and_progress_ascends() {
    let samples: Vec<u16> = (0..70 * 90 * 110).map(|i| (hash(6, i) % 4096) as u16).collect();
    let volume = Volume::from_vec([70, 90, 110], [1.0, 1.0, 1.7], samples).unwrap();
    let run = |threads| {
        with_threads(threads, || {
            let heard = Mutex::new(vec![]);
            let progress = |share: f32| heard.lock().unwrap().push(share);
            let mut result =
                prepare(&volume, &Preparation::default(), &progress, &mut Warnings::new()).unwrap();
            let heard = heard.into_inner().unwrap();
            assert!(heard.is_sorted() && heard.last() == Some(&1.0) && heard.len() > 4);
            let report = keep_components(&mut result, 2600.0, Keep::Auto).unwrap();
            (result, report)
        })
    };
    let one = run(1);
    assert!(one.1.found > 30, "{:?}", one.1);
    for threads in [2, 3, 8] {
        assert!(one == run(threads), "{threads}");
    }
}

/// A prepared volume of 0 and 1 from a picture of what is inside.
fn mask(dims: [usize; 3], inside: impl Fn([usize; 3]) -> bool) -> Volume {
    let mut samples = Vec::new();
    each_voxel(dims, |p| samples.push(if inside(p) { 60000u16 } else { 100 }));
    let scaling = Scaling { slope: 1.0 / 65535.0, intercept: 0.0 };
    Volume::new(dims, Samples::U16(samples), scaling, Affine::from_spacing([1.0; 3])).unwrap()
}

fn inside(volume: &Volume) -> Vec<[usize; 3]> {
    let mut found = vec![];
    each_voxel(volume.dims(), |[x, y, z]| {
        if volume.value_at(x, y, z) >= 0.5 {
            found.push([x, y, z]);
        }
    });
    found
}

/// Components by flooding, the slow and plain way: number of each voxel's component, and sizes.
fn flood(volume: &Volume) -> Vec<u64> {
    let mut left: std::collections::HashSet<[usize; 3]> = inside(volume).into_iter().collect();
    let mut sizes = vec![];
    while let Some(&start) = left.iter().next() {
        left.remove(&start);
        let (mut open, mut size) = (vec![start], 0);
        while let Some([x, y, z]) = open.pop() {
            size += 1;
            for d in 0..27 {
                let p = [x + d % 3, y + d / 3 % 3, z + d / 9].map(|c| c.wrapping_sub(1));
                if left.remove(&p) {
                    open.push(p);
                }
            }
        }
        sizes.push(size);
    }
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}

#[test]
fn components_are_those_of_flooding() {
    for (seed, share) in [(1, 3), (2, 6), (3, 10), (4, 25)] {
        let dims = [45, 38, 51];
        let noise = mask(dims, |[x, y, z]| hash(seed, (x + 64 * (y + 64 * z)) as u64) % 100 < share);
        let sizes = flood(&noise);
        for threads in [1, 4] {
            let (report, result) = with_threads(threads, || {
                let mut result = noise.clone();
                (keep_components(&mut result, 0.5, Keep::Largest(3)).unwrap(), result)
            });
            assert_eq!((report.found, report.voxels), (sizes.len(), sizes.iter().sum()), "{seed}");
            let n = sizes.len().min(16);
            assert_eq!((report.sizes.as_slice(), report.kept), (&sizes[..n], sizes.len().min(3)));
            assert_eq!(flood(&result), sizes[..sizes.len().min(3)]);
            assert_eq!(report.dropped_voxels, sizes.iter().skip(3).sum());
        }
    }
}

/// Two spirals wound into each other climb through all slabs; they touch nowhere, and each is one piece.
#[test]
fn spirals_across_slabs_stay_whole() {
    let dims = [48, 48, 100];
    let arm = |[x, y, z]: [usize; 3], turn: f64| {
        let angle = z as f64 * 0.35 + turn;
        let [cx, cy] = [24.0 + 15.0 * angle.cos(), 24.0 + 15.0 * angle.sin()];
        (x as f64 - cx).hypot(y as f64 - cy) < 4.0
    };
    let both = mask(dims, |p| arm(p, 0.0) || arm(p, std::f64::consts::PI));
    let first = mask(dims, |p| arm(p, 0.0));
    let count = inside(&first).len() as u64;
    let mut kept = both.clone();
    let report = keep_components(&mut kept, 0.5, Keep::Auto).unwrap();
    assert_eq!((report.found, report.kept, report.dropped_voxels), (2, 2, 0));
    assert!(kept == both);
    let report = keep_components(&mut kept, 0.5, Keep::Largest(1)).unwrap();
    assert_eq!((report.found, report.kept), (2, 1));
    assert_eq!(report.sizes[0], count.max(report.voxels - count));
    assert_eq!(inside(&kept).len() as u64, report.sizes[0]);
    // A comb that joins only in its last layer.
    let comb = mask([33, 5, 70], |[x, _, z]| z == 69 || x % 4 == 0);
    assert_eq!(keep_components(&mut comb.clone(), 0.5, Keep::Auto).unwrap().found, 1);
    let teeth = mask([33, 5, 70], |[x, _, z]| z < 69 && x % 4 == 0);
    let report = keep_components(&mut teeth.clone(), 0.5, Keep::Auto).unwrap();
    assert_eq!((report.found, report.kept, report.sizes[0]), (9, 9, 5 * 69));
}

#[test]
fn what_is_kept_keeps_its_surface_and_the_rest_leaves_nothing() {
    let blobs = |p: DVec3, parts: &[(DVec3, f64)]| {
        let near = |(c, r): &(DVec3, f64)| 1.0 / (1.0 + ((p - *c).length() - r).exp());
        parts.iter().map(near).sum::<f64>() as f32
    };
    let big = [(DVec3::new(20.0, 20.0, 20.0), 9.0), (DVec3::new(60.0, 20.0, 40.0), 9.0)];
    let speck = (DVec3::new(35.0, 40.0, 20.0), 2.5);
    let affine = Affine::from_spacing([1.0; 3]);
    let field = Field::new([80, 60, 60], affine);
    let with = field.volume(|p| blobs(p, &[big[0], big[1], speck]));
    let without = field.volume(|p| blobs(p, &big));
    let preparation = Preparation { window: Some([0.0, 1.0]), ..Preparation::default() };
    let (mut kept, without) = (prepared(&with, &preparation), prepared(&without, &preparation));
    let before = kept.clone();
    let report = keep_components(&mut kept, 0.5, Keep::Auto).unwrap();
    assert_eq!((report.found, report.kept), (3, 2), "{report:?}");
    let (a, b) = (iso(&kept, 0.5), iso(&without, 0.5));
    assert_eq!(a.triangles.len(), b.triangles.len());
    let all = |report: &Volume, keep| keep_components(&mut report.clone(), 0.5, keep).unwrap().kept;
    assert_eq!(
        (all(&before, Keep::All), all(&before, Keep::Largest(0)), all(&before, Keep::Largest(9))),
        (3, 1, 3)
    );
    // Near the speck, nothing is brighter than the tail of its edge three voxels out.
    let s = kept.affine().linear.inverse() * (speck.0 - kept.affine().origin);
    each_voxel(kept.dims(), |[x, y, z]| {
        if DVec3::new(x as f64, y as f64, z as f64).distance(s) < 9.0 {
            assert!(kept.value_at(x, y, z) < 0.2, "{x} {y} {z}: {}", kept.value_at(x, y, z));
        }
    });
    // Nothing is inside, or everything.
    assert_eq!(keep_components(&mut kept, 2.0, Keep::Auto).unwrap().found, 0);
    assert_eq!(keep_components(&mut kept, f64::NAN, Keep::Auto).unwrap().found, 0);
    let report = keep_components(&mut kept, -1.0, Keep::Auto).unwrap();
    assert_eq!((report.found, report.kept, report.dropped_voxels), (1, 1, 0));
}

#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
#[test]
fn measured_volumes_have_closed_surfaces() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/volumes");
    for (file, dims, at) in
        [("neghip_66x66x66_uint8.raw", [66, 66, 66], 60.5), ("headmr.raw", [48, 62, 42], 60.5)]
    {
        let samples = std::fs::read(format!("{folder}/{file}")).unwrap();
        let volume = Volume::from_vec(dims, [1.0; 3], samples).unwrap();
        let mut result = prepared(&volume, &Preparation::default());
        assert_eq!(result.dims(), dims.map(|n| n + 6), "{file}");
        let report = keep_components(&mut result, at, Keep::Largest(1)).unwrap();
        assert_eq!(report.kept, 1, "{file}");
        let mesh = mesh_of(iso(&result, at));
        assert!(mesh.closed, "{file}");
        // Smoothing by half a voxel moves no face far: the sum of the values stays.
        let sum = |v: &Volume| {
            let n = v.dims().iter().product::<usize>() as f64;
            v.stats().unwrap().mean * n
        };
        let plain = prepared(&volume, &Preparation { smooth: Some(0.5), cap: true, ..PLAIN });
        let clamped = prepared(&volume, &PLAIN);
        let air = plain.scaling().intercept
            * (plain.dims().iter().product::<usize>() - volume.samples().len()) as f64;
        assert!(((sum(&plain) - air) / sum(&clamped) - 1.0).abs() < 1e-3, "{file}");
    }
}
