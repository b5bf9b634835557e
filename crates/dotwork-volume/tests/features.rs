//! Features of volumes whose surfaces are known.

mod common;

use common::{Field, hash};
use dotwork_drawing::Warnings;
use dotwork_volume::{Affine, FeatureError, Features, Preparation, Scaling, Volume, find_features, prepare};
use glam::{DMat3, DVec3};

/// Air, then three nested balls of values 200, 500 and 1000, blurred at their surfaces, with noise.
fn nested(affine: Affine, dims: [usize; 3], noise: f64) -> Volume {
    let middle = affine.point(dims.map(|n| (n - 1) as f64 / 2.0));
    let step = |r: f64, radius: f64| 1.0 / (1.0 + ((r - radius) * 2.5).exp());
    let count = std::cell::Cell::new(0);
    Field::new(dims, affine).volume(|p| {
        let r = (p - middle).length();
        let i = count.replace(count.get() + 1);
        let normal = (0..4).map(|k| hash(9, 4 * i + k) as f64 / 2f64.powi(64)).sum::<f64>() - 2.0;
        let v = 200.0 * step(r, 28.0) + 300.0 * step(r, 20.0) + 500.0 * step(r, 12.0) + noise * normal;
        v as f32
    })
}

const DIMS: [usize; 3] = [64, 64, 64];

fn unit() -> Affine {
    Affine::from_spacing([1.0; 3])
}

fn close(a: &Features, b: &Features, value: impl Fn(f64) -> f64, tolerance: f64) {
    assert_eq!(a.features.len(), b.features.len());
    assert_eq!(a.default, b.default);
    for (a, b) in a.features.iter().zip(&b.features) {
        assert_eq!(a.name, b.name);
        assert!((value(a.iso) - b.iso).abs() < tolerance, "{} {}", value(a.iso), b.iso);
        assert!((value(a.mean) - b.mean).abs() < tolerance, "{} {}", value(a.mean), b.mean);
        assert!((a.share - b.share).abs() < 0.02, "{} {}", a.share, b.share);
    }
}

/// Boundaries lie half-way between what they part: 100, 350 and 750.
#[test]
fn nested_balls_are_three_features() {
    for noise in [0.0, 20.0] {
        let found = find_features(&nested(unit(), DIMS, noise)).unwrap();
        let names: Vec<&str> = found.features.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(names, ["outer", "mid", "dense"]);
        for (feature, known) in found.features.iter().zip([100.0, 350.0, 750.0]) {
            assert!((feature.mean - known).abs() < 25.0, "{noise}: {feature:?}");
            assert!(feature.iso > feature.range[0] && feature.iso < feature.range[1], "{feature:?}");
        }
        // Weights go by area and contrast.
        let weights = [200.0 * 28.0f64.powi(2), 300.0 * 20.0f64.powi(2), 500.0 * 12.0f64.powi(2)];
        let total: f64 = weights.iter().sum();
        for (feature, weight) in found.features.iter().zip(weights) {
            assert!((f64::from(feature.share) - weight / total).abs() < 0.06, "{feature:?}");
        }
        assert!((found.features.iter().map(|f| f.share).sum::<f32>() - 1.0).abs() < 1e-5);
    }
}

#[test]
fn features_do_not_depend_on_unit_orientation_or_type() {
    let volume = nested(unit(), DIMS, 10.0);
    let found = find_features(&volume).unwrap();

    // Another unit of length and another of value.
    let scaling = Scaling { slope: -0.003, intercept: 40.0 };
    let turned = Volume::new(DIMS, volume.samples().clone(), scaling, unit()).unwrap();
    let upside_down = find_features(&turned).unwrap();
    assert_eq!(upside_down.features.len(), 3);
    let scaling = Scaling { slope: 1e-6, intercept: -1.0 };
    let mut affine = Affine::from_spacing([1e-4; 3]);
    let scaled = Volume::new(DIMS, volume.samples().clone(), scaling, affine).unwrap();
    close(&found, &find_features(&scaled).unwrap(), |v| scaling.value(v), 2e-6);

    // Mirrored samples; a mirrored and rotated world.
    let samples: Vec<f32> = (0..DIMS.iter().product())
        .map(|i| volume.samples().get(i % 64 + 64 * (63 - i / 64 % 64) + 64 * 64 * (63 - i / 4096)) as f32)
        .collect();
    let mirrored = Volume::from_vec(DIMS, [1.0; 3], samples).unwrap();
    close(&found, &find_features(&mirrored).unwrap(), |v| v, 2.0);
    affine.linear = DMat3::from_rotation_y(0.7) * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    let rotated = Volume::new(DIMS, volume.samples().clone(), Scaling::default(), affine).unwrap();
    close(&found, &find_features(&rotated).unwrap(), |v| v, 2.0);

    // Rounded to 8 and 16 bits.
    let bytes: Vec<u8> =
        (0..DIMS.iter().product()).map(|i| (volume.samples().get(i) / 5.0 + 10.0) as u8).collect();
    let bytes = Volume::from_vec(DIMS, [1.0; 3], bytes).unwrap();
    close(&found, &find_features(&bytes).unwrap(), |v| v / 5.0 + 10.0, 3.0);
}

/// Flat voxels have the same surfaces.
#[test]
fn anisotropic_grids_have_the_same_features() {
    let found = find_features(&nested(unit(), DIMS, 0.0)).unwrap();
    let flat = nested(Affine::from_spacing([1.0, 1.0, 1.25]), [64, 64, 51], 0.0);
    close(&find_features(&flat).unwrap(), &found, |v| v, 20.0);
}

/// Less than a thousandth of the voxels, and so beyond the percentiles.
#[test]
fn small_things_in_much_air_are_features() {
    for noise in [0.0, 10.0] {
        let samples: Vec<f32> = (0..64u64.pow(3))
            .map(|i| {
                let [x, y, z] = [i % 64, i / 64 % 64, i / 4096].map(|v| v as f64 - 31.5);
                let r = DVec3::new(x, y, z).length();
                let air = noise * (hash(7, i) as f64 / 2f64.powi(64));
                (air + 1000.0 / (1.0 + ((r - 3.0) * 2.5).exp())) as f32
            })
            .collect();
        let found = find_features(&Volume::from_vec([64; 3], [1.0; 3], samples).unwrap()).unwrap();
        assert_eq!(found.features.len(), 1, "{noise}: {found:?}");
        assert!((250.0..600.0).contains(&found.features[0].iso), "{noise}: {:?}", found.features);
    }
}

#[test]
fn volumes_without_boundaries_have_no_features() {
    let flat = Volume::from_vec([8; 3], [1.0; 3], vec![3u8; 512]).unwrap();
    assert_eq!(find_features(&flat), Err(FeatureError::Flat));
    let none = Volume::from_vec([8; 3], [1.0; 3], vec![f32::NAN; 512]).unwrap();
    assert_eq!(find_features(&none), Err(FeatureError::NoValues));
    let slice = Volume::from_vec([8, 8, 1], [1.0; 3], (0..64).collect::<Vec<u8>>()).unwrap();
    assert_eq!(find_features(&slice), Err(FeatureError::Flat));
}

#[test]
fn features_are_the_same_on_any_number_of_threads() {
    let volume = nested(unit(), DIMS, 20.0);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let regression = volume.regression().unwrap();
            let threshold = regression.threshold().unwrap();
            let laplacian = volume.laplacian_of_gaussian(1.5).unwrap().field().unwrap();
            let field = regression.field().unwrap();
            (
                find_features(&volume).unwrap(),
                regression.boundaries(threshold, 300).unwrap(),
                laplacian,
                field,
            )
        })
    };
    assert_eq!(with(1), with(3));
}

/// What the same rules, tried beforehand on these files, are known to find.
#[cfg_attr(no_shared_data, ignore = "shared/data is not here")]
#[test]
fn measured_volumes_have_plausible_features() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data/volumes");
    for (file, dims, count, iso) in [
        ("neghip_66x66x66_uint8.raw", [66, 66, 66], 1, 70.0..110.0),
        ("headmr.raw", [48, 62, 42], 3, 10.0..16.0),
    ] {
        let samples = std::fs::read(format!("{folder}/{file}")).unwrap();
        let volume = Volume::from_vec(dims, [1.0; 3], samples).unwrap();
        let volume = prepare(&volume, &Preparation::default(), &|_| (), &mut Warnings::new()).unwrap();
        let found = find_features(&volume).unwrap();
        assert_eq!(found.features.len(), count, "{file}");
        assert!(iso.contains(&found.features[found.default].iso), "{file}: {found:?}");
    }
}
