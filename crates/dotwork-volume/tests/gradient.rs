//! Regression gradients and the Laplacian of Gaussian against fields whose derivatives are known, numbers from another
//! program, and slow plain sums.

mod common;

use common::{Field, hash};
use dotwork_volume::{Affine, MIN_PIECE, Sample, Samples, Scaling, Volume};
use glam::{DMat3, DVec3};

/// A rotated, mirrored grid with three different spacings.
fn oblique() -> Affine {
    let mut affine = Affine::from_spacing([1.0; 3]);
    affine.linear = DMat3::from_rotation_z(0.6)
        * DMat3::from_rotation_x(-0.4)
        * DMat3::from_diagonal(DVec3::new(0.5, -0.7, 1.3));
    affine.origin = DVec3::new(-3.0, 8.0, 1.0);
    affine
}

fn indices([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nx * ny * nz).map(move |i| [i % nx, i / nx % ny, i / nx / ny])
}

/// Two 16-bit steps of the field are allowed for: the gradients of wide types are kept to 1/32767 of the range a step.
fn tolerance(volume: &Volume) -> f64 {
    let (min, max) = volume.value_range().unwrap();
    let spacing = volume.spacing().into_iter().fold(f64::INFINITY, f64::min);
    2.0 * (max - min) / 32767.0 / spacing
}

#[test]
fn linear_fields_are_exact_in_any_grid_up_to_the_border() {
    let slope = DVec3::new(3.0, -2.0, 5.0);
    let mut sheared = oblique();
    sheared.linear.z_axis += 0.3 * sheared.linear.y_axis;
    for affine in [Affine::from_spacing([1.0; 3]), Affine::from_spacing([1.0, 1.0, 4.0]), oblique(), sheared]
    {
        for dims in [[9, 10, 11], [17, 2, 3], [8, 1, 5], [2, 2, 2]] {
            let volume = Field::new(dims, affine).volume(|p| (slope.dot(p) + 7.0) as f32);
            let field = volume.regression().unwrap().field().unwrap();
            for (i, [x, y, z]) in indices(dims).enumerate() {
                // An axis of one voxel tells nothing of the slope along it.
                let by_index = affine.linear.transpose() * slope;
                let known = DVec3::from_array([0, 1, 2].map(|a| if dims[a] > 1 { by_index[a] } else { 0.0 }));
                let known = affine.linear.inverse().transpose() * known;
                let off = (field.gradient(i) - known).length();
                assert!(off < tolerance(&volume), "{dims:?} {x} {y} {z}: {off}");
                let inside = [x, y, z].iter().zip(dims).all(|(&i, n)| i > 0 && i + 1 < n);
                if inside {
                    let (min, max) = volume.value_range().unwrap();
                    let off = field.value(i) - volume.value_at(x, y, z);
                    assert!(off.abs() < (max - min) / 60000.0, "{off}");
                }
            }
        }
    }
}

/// A quadratic is even about each voxel, so the gradient there is exact and only the value is smoothed.
#[test]
fn quadratic_fields_have_exact_gradients_inside() {
    let affine = oblique();
    let q = DMat3::from_cols_array(&[0.4, 0.1, -0.2, 0.1, -0.3, 0.25, -0.2, 0.25, 0.6]);
    let dims = [14, 12, 9];
    let volume = Field::new(dims, affine).volume(|p| p.dot(q * p));
    let field = volume.regression().unwrap().field().unwrap();
    for (i, v) in indices(dims).enumerate() {
        if v.iter().zip(dims).all(|(&i, n)| i > 0 && i + 1 < n) {
            let p = affine.point(v.map(|v| v as f64));
            assert!((field.gradient(i) - 2.0 * (q * p)).length() < tolerance(&volume));
        }
    }
}

/// Weights 12, 6, 5, 4; from scipy 1.17, `ndimage.correlate` (float64) with the four dense kernels, and
/// `ndimage.gaussian_laplace` with sigma 1.5, on 12 × 11 × 10 bytes of noise.
#[test]
fn noise_gives_the_numbers_of_scipy() {
    #[rustfmt::skip]
    let known = [
        ([1, 1, 1], [128.778571, -26.238095, 37.154762, 32.440476], -0.064606),
        ([5, 4, 3], [120.128571, 7.488095, -9.285714, 5.321429], 2.247318),
        ([10, 9, 8], [109.535714, -6.559524, -0.630952, -0.428571], 6.378345),
        ([3, 7, 6], [134.035714, 5.250000, -9.380952, -22.464286], -3.269067),
        ([8, 2, 5], [95.321429, -6.916667, -3.119048, 19.011905], 13.148539),
    ];
    let dims = [12, 11, 10];
    let bytes: Vec<u8> = (0..1320).map(|i| (hash(11, i) % 256) as u8).collect();
    let wide: Vec<i16> = bytes.iter().map(|&b| i16::from(b) * 100 - 9000).collect();
    let real: Vec<f64> = bytes.iter().map(|&b| f64::from(b) * 1e-9 + 4.0).collect();
    for (samples, scale, offset, slack) in
        [(bytes.wrap(), 1.0, 0.0, 1e-6), (wide.wrap(), 100.0, -9000.0, 0.01), (real.wrap(), 1e-9, 4.0, 0.01)]
    {
        let volume = Volume::new(dims, samples, Scaling::default(), Affine::from_spacing([1.0; 3])).unwrap();
        let field = volume.regression().unwrap().field().unwrap();
        let laplacian = volume.laplacian_of_gaussian(1.5).unwrap().field().unwrap();
        for ([x, y, z], [v, gx, gy, gz], log) in known {
            let i = x + 12 * (y + 11 * z);
            assert!(((field.value(i) - offset) / scale - v).abs() < slack);
            let off = field.gradient(i) / scale - DVec3::new(gx, gy, gz);
            assert!(off.abs().max_element() < slack, "{off}");
            // scipy's taps are samples of the derivative, ours are exact on quadratics: on noise, of which the filter
            // leaves a deviation of 8, they differ by up to half a percent of what there is.
            let off = f64::from(laplacian[i]) / scale - log;
            assert!(off.abs() < 0.1, "{x} {y} {z}: {off}");
        }
    }
}

/// The wrapping of a vector so that a table may hold several types.
trait Wrap {
    fn wrap(self) -> Samples;
}

impl<T: Sample> Wrap for Vec<T> {
    fn wrap(self) -> Samples {
        T::wrap(self)
    }
}

/// Rows, whole fields and all sample types tell the same.
#[test]
fn rows_and_fields_agree_for_every_type() {
    let dims = [21, 8, 6];
    let bytes: Vec<u8> = (0..1008).map(|i| (hash(5, i) % 200) as u8 + 20).collect();
    let reference = Volume::from_vec(dims, [1.0, 2.0, 1.5], bytes.clone()).unwrap();
    let reference = reference.regression().unwrap().field().unwrap();
    macro_rules! check {
        ($($type:ident)*) => {$({
            let samples: Vec<$type> = bytes.iter().map(|&b| (i16::from(b) - 110) as $type).collect();
            let scaling = Scaling { slope: -0.5, intercept: 3.0 };
            let affine = Affine::from_spacing([1.0, 2.0, 1.5]);
            let volume = Volume::new(dims, Sample::wrap(samples), scaling, affine).unwrap();
            let regression = volume.regression().unwrap();
            let field = regression.field().unwrap();
            let rows = regression.layers(1..6, |_| Vec::new(), |all: &mut Vec<(f64, DVec3, f64)>, row| {
                let mut lengths = vec![0.0; 21];
                regression.magnitudes(&row, &mut lengths);
                for x in 0..21 {
                    let g = regression.gradient(row.gradient.map(|g| g[x]));
                    let v = regression.value(f64::from(row.value[x]));
                    all.push((v, g, regression.slope(f64::from(lengths[x]))));
                }
            });
            for (i, (v, g, length)) in rows.concat().into_iter().enumerate() {
                let i = i + 21 * 8;
                let known = (3.0 - 0.5 * (reference.value(i) - 110.0), -0.5 * reference.gradient(i));
                assert!((v - known.0).abs() < 1e-4 && (g - known.1).length() < 1e-4);
                assert!((length - g.length()).abs() < 1e-4);
                assert!((field.value(i) - v).abs() < 0.002 && (field.gradient(i) - g).length() < 0.01);
            }
        })*};
    }
    check!(i8 i16 i32 i64 f32 f64);
}

/// The paper's claim, measured: on a ball's distance field with noise, regression errs less in direction than central
/// differences. Root mean square angles at 0.3 to 0.9 of the radius, for noise of 1, 2, 5 and 10 % of the radius:
/// 4.6 against 13.6, 9.1 against 27.7, 23 against 60 and 45 against 78 degrees.
#[test]
fn regression_errs_less_than_central_differences_in_noise() {
    let n = 48;
    let middle = 23.5;
    let known = |v: [usize; 3]| DVec3::from_array(v.map(|v| v as f64 - middle));
    for (noise, least_gain) in [(0.01, 2.8), (0.02, 2.8), (0.05, 2.4), (0.1, 1.6)] {
        let normal = |i: u64| (0..12).map(|k| hash(3, 12 * i + k) as f64 / 2f64.powi(64)).sum::<f64>() - 6.0;
        let samples: Vec<f32> = indices([n; 3])
            .enumerate()
            .map(|(i, v)| (known(v).length() + noise * middle * normal(i as u64)) as f32)
            .collect();
        let volume = Volume::from_vec([n; 3], [1.0; 3], samples).unwrap();
        let field = volume.regression().unwrap().field().unwrap();
        let (mut fitted, mut central, mut count) = (0.0, 0.0, 0.0);
        for (i, [x, y, z]) in indices([n; 3]).enumerate() {
            let known = known([x, y, z]);
            if !(0.3..0.9).contains(&(known.length() / middle)) {
                continue;
            }
            let v = |x, y, z| volume.value_at(x, y, z);
            let differences = DVec3::new(
                v(x + 1, y, z) - v(x - 1, y, z),
                v(x, y + 1, z) - v(x, y - 1, z),
                v(x, y, z + 1) - v(x, y, z - 1),
            );
            fitted += field.gradient(i).angle_between(known).to_degrees().powi(2);
            central += differences.angle_between(known).to_degrees().powi(2);
            count += 1.0;
        }
        let (fitted, central): (f64, f64) = ((fitted / count).sqrt(), (central / count).sqrt());
        assert!(central / fitted > least_gain, "noise {noise}: {fitted:.2} against {central:.2} degrees");
    }
}

/// The Laplacian of a Gaussian blob of deviation s, smoothed by sigma, is that of a wider blob in closed form.
#[test]
fn laplacian_of_a_gaussian_has_its_closed_form() {
    let (s, sigma) = (3.0f64, 1.6f64);
    let t = s * s + sigma * sigma;
    let mut affine = oblique();
    affine.linear *= DMat3::from_diagonal(DVec3::new(1.6, 1.3, 0.8));
    let dims = [41, 37, 35];
    let middle = affine.point([20.0, 18.0, 17.0]);
    let volume =
        Field::new(dims, affine).volume(|p| 1000.0 * (-0.5 * (p - middle).length_squared() / (s * s)).exp());
    let laplacian = volume.laplacian_of_gaussian(sigma).unwrap().field().unwrap();
    let scale = 1000.0 * (s * s / t).powf(1.5);
    for (i, v) in indices(dims).enumerate() {
        if v.iter().zip(dims).any(|(&i, n)| i < 8 || i + 8 >= n) {
            continue;
        }
        let r2 = (affine.point(v.map(|v| v as f64)) - middle).length_squared();
        let known = scale * (r2 / (t * t) - 3.0 / t) * (-0.5 * r2 / t).exp();
        assert!((f64::from(laplacian[i]) - known).abs() < 0.004 * scale * 3.0 / t, "{v:?}");
    }
}

#[test]
fn laplacian_is_exact_on_quadratics_and_refuses_no_sigma() {
    let affine = Affine::from_spacing([1.0, 0.5, 2.0]);
    let dims = [32, 60, 20];
    let volume =
        Field::new(dims, affine).volume(|p| 0.25 * p.x * p.x - p.y * p.y + 0.5 * p.z * p.z + 3.0 * p.x);
    for sigma in [0.05, 0.4, 1.5] {
        let laplacian = volume.laplacian_of_gaussian(sigma).unwrap().field().unwrap();
        let middle = laplacian[16 + 32 * (30 + 60 * 10)];
        assert!((middle + 0.5).abs() < 0.01, "{sigma}: {middle}");
    }
    for sigma in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(volume.laplacian_of_gaussian(sigma).is_none());
    }
    // Radii beyond the volume: the mirrored samples average out.
    let tiny = Volume::from_slice([3, 1, 2], [1.0; 3], &[1u8, 5, 9, 2, 4, 6]).unwrap();
    let smooth = tiny.laplacian_of_gaussian(40.0).unwrap().field().unwrap();
    assert!(smooth.iter().all(|v| v.abs() < 1e-4), "{smooth:?}");
}

#[test]
fn gaps_and_flat_volumes_have_no_gradient() {
    let mut samples = vec![0.0f32; 125];
    // Files have NaNs of any bits.
    samples[62] = f32::from_bits(0x7fc1_2345);
    samples[0] = 1.0;
    let volume = Volume::from_vec([5; 3], [1.0; 3], samples).unwrap();
    let field = volume.regression().unwrap().field().unwrap();
    assert_eq!((field.value(62), field.value(63)), (0.0, 0.0));
    assert_eq!(field.gradient(62), DVec3::ZERO);
    assert_eq!(field.gradient(63), DVec3::ZERO);
    assert!(field.gradient(0).length() > 0.1);

    let flat = Volume::from_vec([5; 3], [1.0; 3], vec![-7i16; 125]).unwrap();
    assert!((0..125).all(|i| flat.regression().unwrap().field().unwrap().gradient(i) == DVec3::ZERO));
    assert!(flat.regression().unwrap().threshold().is_none());
    let none = Volume::from_vec([2; 3], [1.0; 3], vec![f64::NAN; 8]).unwrap();
    assert!(none.regression().is_none());
    assert!(none.laplacian_of_gaussian(1.0).unwrap().field().unwrap().iter().all(|v| v.is_nan()));
}

/// A ball's boundary is kept, a speck as strong as it is not.
#[test]
fn boundaries_are_shells_and_not_specks() {
    let affine = Affine::from_spacing([1.0; 3]);
    let ball = |p: DVec3, c: DVec3, r: f64| 1.0 / (1.0 + (3.0 * ((p - c).length() - r)).exp());
    let (ball_at, speck_at) = (DVec3::splat(20.0), DVec3::new(50.0, 20.0, 20.0));
    let volume = Field::new([64, 40, 40], affine)
        .volume(|p| (200.0 * ball(p, ball_at, 12.0) + 200.0 * ball(p, speck_at, 1.5)) as u8);
    let regression = volume.regression().unwrap();
    let threshold = regression.threshold().unwrap();
    assert!(threshold.low < threshold.high && threshold.low > 0.2 * threshold.high);
    let mask = regression.boundaries(threshold, MIN_PIECE).unwrap();
    assert!(mask.contains(32, 20, 20) && mask.contains(20, 8, 20) && !mask.contains(20, 20, 20));
    for [x, y, z] in indices([64, 40, 40]) {
        let away = (DVec3::new(x as f64, y as f64, z as f64) - ball_at).length();
        assert!(!mask.contains(x, y, z) || (away - 12.0).abs() < 5.0, "{x} {y} {z}");
    }
    assert_eq!(
        mask.count(),
        indices([64, 40, 40]).filter(|&[x, y, z]| mask.contains(x, y, z)).count() as u64
    );
    let all = regression.boundaries(threshold, 0).unwrap();
    assert!(all.contains(51, 20, 20) || all.contains(52, 20, 20));
}
