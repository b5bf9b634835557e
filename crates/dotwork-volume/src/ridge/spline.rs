//! Value and gradient between the voxels, without kinks.

use glam::DVec3;

use crate::samples::Ordered;

/// The samples as weights of uniform cubic B-splines (a smoothing of 0.58 voxels): twice continuously differentiable,
/// where the gradient of a trilinear interpolation jumps from cell to cell. The border voxels are repeated.
pub(super) struct Spline<'a, T> {
    samples: &'a [T],
    dims: [usize; 3],
}

/// The four weights of a B-spline at `share` of the way from the second to the third, and their derivatives.
#[inline]
fn weights(share: f64) -> [[f64; 4]; 2] {
    let (s, r) = (share, 1.0 - share);
    let sixth = 1.0 / 6.0;
    [
        [
            sixth * r * r * r,
            sixth * (4.0 - 6.0 * s * s + 3.0 * s * s * s),
            sixth * (4.0 - 6.0 * r * r + 3.0 * r * r * r),
            sixth * s * s * s,
        ],
        [-0.5 * r * r, s * (1.5 * s - 2.0), r * (2.0 - 1.5 * r), 0.5 * s * s],
    ]
}

impl<'a, T: Ordered> Spline<'a, T> {
    pub(super) fn new(samples: &'a [T], dims: [usize; 3]) -> Spline<'a, T> {
        Spline { samples, dims }
    }

    /// The gradient of the samples, for a voxel step along each axis, at a place in voxel indices; not finite beside
    /// samples that are not.
    #[inline]
    pub(super) fn gradient(&self, place: DVec3) -> DVec3 {
        let (mut at, mut w) = ([[0; 4]; 3], [[[0.0; 4]; 2]; 3]);
        for a in 0..3 {
            let floor = place[a].floor();
            w[a] = weights(place[a] - floor);
            let last = self.dims[a] as i64 - 1;
            for (k, at) in at[a].iter_mut().enumerate() {
                *at = (floor as i64 + k as i64 - 1).clamp(0, last) as usize;
            }
        }
        let ([nx, ny, _], [[x, dx], [y, dy], [z, dz]]) = (self.dims, w);
        let mut sum = DVec3::ZERO;
        for k in 0..4 {
            for j in 0..4 {
                let row = &self.samples[nx * (at[1][j] + ny * at[2][k])..][..nx];
                let (mut value, mut slope) = (0.0, 0.0);
                for i in 0..4 {
                    let sample = row[at[0][i]].to_f64();
                    value += x[i] * sample;
                    slope += dx[i] * sample;
                }
                sum += DVec3::new(slope * y[j] * z[k], value * dy[j] * z[k], value * y[j] * dz[k]);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_those_of_a_partition_and_their_derivatives() {
        for share in [0.0, 0.25, 0.5, 0.9] {
            let [w, d] = weights(share);
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-12 && d.iter().sum::<f64>().abs() < 1e-12);
            let [[after, _], [before, _]] = [1e-6, -1e-6].map(|step| weights(share + step));
            for i in 0..4 {
                assert!(((after[i] - before[i]) / 2e-6 - d[i]).abs() < 1e-8, "{share} {i}");
            }
        }
    }

    #[test]
    fn gradients_of_linear_fields_are_exact_within() {
        let dims = [6, 5, 7];
        let value = |i: usize| (3 * (i % 6) + 10 * (i / 6 % 5)) as f32 - 2.5 * (i / 30) as f32;
        let samples: Vec<f32> = (0..6 * 5 * 7).map(value).collect();
        let spline = Spline::new(&samples, dims);
        for place in [DVec3::new(2.0, 2.0, 3.0), DVec3::new(1.3, 2.9, 4.01), DVec3::new(3.999, 1.0, 1.5)] {
            assert!(spline.gradient(place).distance(DVec3::new(3.0, 10.0, -2.5)) < 1e-9, "{place}");
        }
        // Beyond the border nothing changes.
        assert_eq!(spline.gradient(DVec3::new(-9.0, 2.0, 3.0)).x, 0.0);
    }
}
