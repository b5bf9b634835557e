//! How many stipples a voxel holds, and how coarse voxels have to be to hold a pattern of them.
//!
//! A volume whose voxels are smaller than a few pixels prints too dark even with one dot each, so it is box-filtered
//! until a voxel covers about 5 × 5 pixels, and a voxel gets as many stipples as it covers pixels (Lu et al. 2002,
//! section 4.2).

use dotwork_drawing::{Page, View};
use rayon::prelude::*;

/// Side in pixels that a voxel covers at least after [`box_filter_level`].
pub const MIN_VOXEL_PX: f32 = 5.0;

/// Most stipples of a voxel (eq 1): `k_max · A / (X·Y·Z)^(2/3)`.
///
/// `rendered_area_px` is the area in pixels squared that the volume covers on the page, `dims` its numbers of voxels
/// (after the box filter). The exponent makes the divisor the number of voxels of a face of the volume.
pub fn n_max(k_max: f32, rendered_area_px: f32, dims: [usize; 3]) -> f32 {
    let voxels = dims.iter().map(|&d| d as f64).product::<f64>();
    (f64::from(k_max) * f64::from(rendered_area_px) / voxels.powf(2.0 / 3.0)) as f32
}

/// By how much the box filter makes voxels larger along each axis, so that one covers at least [`MIN_VOXEL_PX`] a side:
/// the smallest whole number that does.
///
/// `px_per_voxel`: pixels that a voxel's side covers at the volume's centre, for uneven voxels the cube root of the
/// product of the three.
pub fn box_filter_level(px_per_voxel: f32) -> usize {
    // Casts of what is no number or too large end at a bound.
    ((MIN_VOXEL_PX / px_per_voxel) as f64 - 1e-4).ceil().clamp(1.0, 1024.0) as usize
}

/// The scale of a view, independent of the page's pixels: what [`super::VoxelSettings::reference`] wants of the view
/// that a bake is made for.
pub fn reference_scale(view: &View, page: &Page) -> f32 {
    view.px_per_unit(view.distance) / page.short_side_px()
}

/// Means over boxes of `factor³` values, x fastest; the last boxes of an axis are as large as what is left.
///
/// Voxel `i` of the result has its centre at `factor · i + (factor − 1) / 2` of the source along each axis.
///
/// # Panics
/// If `factor` is 0 or `values` are not as many as `dims` say.
pub fn box_filter(values: &[f32], dims: [usize; 3], factor: usize) -> (Vec<f32>, [usize; 3]) {
    assert_eq!(values.len(), dims.iter().product::<usize>(), "the values fill the grid");
    let small = dims.map(|d| d.div_ceil(factor));
    let mut out = vec![0.0f32; small.iter().product()];
    if out.is_empty() {
        return (out, small);
    }
    let [nx, ny, nz] = dims;
    let [sx, sy, _] = small;
    out.par_chunks_mut(sx * sy).enumerate().for_each(|(k, slice)| {
        for z in k * factor..((k + 1) * factor).min(nz) {
            for (y, row) in values[z * nx * ny..(z + 1) * nx * ny].chunks(nx).enumerate() {
                let sums = &mut slice[y / factor * sx..][..sx];
                for (sum, part) in sums.iter_mut().zip(row.chunks(factor)) {
                    *sum += part.iter().sum::<f32>();
                }
            }
        }
        let depth = ((k + 1) * factor).min(nz) - k * factor;
        for (j, row) in slice.chunks_mut(sx).enumerate() {
            let height = ((j + 1) * factor).min(ny) - j * factor;
            for (i, v) in row.iter_mut().enumerate() {
                let width = ((i + 1) * factor).min(nx) - i * factor;
                *v /= (width * height * depth) as f32;
            }
        }
    });
    (out, small)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::hash::{hash2, unit};

    #[test]
    fn a_voxel_gets_a_stipple_for_each_pixel() {
        // A cube of 64 voxels a side seen face on at 8 pixels a voxel.
        assert!((n_max(1.0, 512.0 * 512.0, [64; 3]) - 64.0).abs() < 1e-3);
        assert!((n_max(0.5, 512.0 * 512.0, [64; 3]) - 32.0).abs() < 1e-3);
        assert!((n_max(1.0, 900.0, [8, 27, 125]) - 1.0).abs() < 1e-5, "the exponent is two thirds");
    }

    #[test]
    fn voxels_grow_until_they_cover_five_pixels() {
        for (px, level) in [(9.0, 1), (5.0, 1), (4.9, 2), (2.5, 2), (1.7, 3), (1.0, 5), (0.3, 17)] {
            assert_eq!(box_filter_level(px), level, "{px}");
        }
        assert_eq!(box_filter_level(0.0), 1024);
        assert_eq!(box_filter_level(f32::INFINITY), 1);
    }

    #[test]
    fn the_filter_is_the_mean_of_each_box() {
        let dims = [7, 5, 4];
        let values: Vec<f32> = (0..140).map(|i| unit(hash2(i, 3))).collect();
        for factor in [1, 2, 3, 5, 9] {
            let (out, small) = box_filter(&values, dims, factor);
            assert_eq!(small, dims.map(|d: usize| d.div_ceil(factor)));
            for (at, &v) in out.iter().enumerate() {
                let cell = [at % small[0], at / small[0] % small[1], at / small[0] / small[1]];
                let inside = |i: usize| [i % 7, i / 7 % 5, i / 35].map(|c| c / factor) == cell;
                let part: Vec<f32> = (0..140).filter(|&i| inside(i)).map(|i| values[i]).collect();
                let mean = part.iter().sum::<f32>() / part.len() as f32;
                assert!((v - mean).abs() < 1e-6, "{factor} {at}");
            }
        }
        assert_eq!(box_filter(&[], [0, 3, 3], 2), (Vec::new(), [0, 2, 2]));
    }
}
