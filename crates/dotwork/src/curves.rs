//! Which voxels of a volume may be part of its silhouette curves: what needs the volume, once.
//!
//! Lu et al., "Non-photorealistic volume rendering using stippling techniques" (2002, section 5.6); see [`VoxelCurves`]
//! for the criteria. The volume is gone through twice: once for the largest Laplacian and the strongest gradient, of which
//! the thresholds are shares, and once for the voxels, some layers at a time, so that neither is ever kept as a whole.

use dotwork_ink::lines::{Lattice, VoxelCurves};
use dotwork_ink::{Style, Vectors};
use dotwork_mesh::ClipRegion;
use dotwork_volume::{Affine, LaplacianOfGaussian, Regression, RegressionRow, Volume};
use glam::DVec3;

/// Standard deviation of the Gaussian whose Laplacian is taken, in mean edges of a voxel.
const SIGMA: f64 = 1.0;

/// Voxels whose Laplacians are kept at a time; a layer at least.
const AT_A_TIME: usize = 1 << 22;

/// Most voxels that an object keeps for its curves: some 36 bytes each.
pub(crate) const MAX_CURVE_VOXELS: usize = 1 << 22;

/// The voxels that satisfy the criteria of `style` from any side; none for a volume without gradients, or of more than
/// 2³² voxels. Coordinates are relative to `origin`. Of too many, those with the strongest gradients.
///
/// Those whose centres `removed` (world units) takes away are none.
pub(crate) fn bake(
    volume: &Volume,
    origin: [f64; 3],
    style: &Style,
    removed: Option<&ClipRegion>,
) -> VoxelCurves {
    bake_some(volume, origin, style, removed, [MAX_CURVE_VOXELS, AT_A_TIME])
}

/// At most so many voxels are kept, of layers of so many.
fn bake_some(
    volume: &Volume,
    origin: [f64; 3],
    style: &Style,
    removed: Option<&ClipRegion>,
    limits: [usize; 2],
) -> VoxelCurves {
    let affine = volume.affine();
    let lattice = Lattice {
        dims: volume.dims().map(|d| u32::try_from(d).unwrap_or(u32::MAX)),
        origin: affine.point([0.0; 3]) - DVec3::from_array(origin),
        edges: [affine.linear.x_axis, affine.linear.y_axis, affine.linear.z_axis],
    };
    let none = VoxelCurves::none(lattice, style.t_log, style.t_grad);
    let sigma = SIGMA * affine.linear.determinant().abs().cbrt();
    let (Some(laplacian), Some(regression), Some(_)) =
        (volume.laplacian_of_gaussian(sigma), volume.regression(), lattice.voxels())
    else {
        return none;
    };
    let removed = removed.map(|region| (affine, region));
    let search = Search { laplacian, regression, most_bent: 0.0, longest: 0.0, t_log: style.t_log, removed };
    search.measured(volume).map_or(none.clone(), |search| search.collect(volume.dims(), none, limits))
}

/// A volume that is gone through.
struct Search<'a> {
    laplacian: LaplacianOfGaussian<'a>,
    regression: Regression<'a>,
    /// Largest absolute value of the Laplacian.
    most_bent: f32,
    /// Length of the strongest gradient.
    longest: f32,
    t_log: f32,
    /// Where voxels lie, and what is clipped away of them.
    removed: Option<(&'a Affine, &'a ClipRegion)>,
}

/// The voxels of a layer.
#[derive(Default)]
struct Layer {
    voxel: Vec<u32>,
    gradient: Vec<[f32; 3]>,
    magnitude: Vec<f32>,
    laplacian: Vec<f32>,
    lengths: Vec<f32>,
}

impl Search<'_> {
    /// With the largest values; `None` if there are no gradients or no bends.
    fn measured(self, volume: &Volume) -> Option<Self> {
        let [nx, _, nz] = volume.dims();
        let largest = |of: &[f32]| of.iter().fold(0.0f32, |m, v| m.max(v.abs()));
        let bent = |m: &mut f32, _: usize, _: usize, row: &[f32]| *m = m.max(largest(row));
        let most_bent = largest(&self.laplacian.layers(0..nz, |_| 0.0, bent));
        let row = |(m, lengths): &mut (f32, Vec<f32>), row: RegressionRow<'_>| {
            self.regression.magnitudes(&row, lengths);
            *m = m.max(largest(lengths));
        };
        let layers = self.regression.layers(0..nz, |_| (0.0, vec![0.0; nx]), row);
        let longest = layers.iter().fold(0.0f32, |m, layer| m.max(layer.0));
        let fine = |v: f32| v > 0.0 && v.is_finite();
        (fine(most_bent) && fine(longest)).then_some(Search { most_bent, longest, ..self })
    }

    /// The voxels, at most so many.
    fn collect(
        &self,
        [nx, ny, nz]: [usize; 3],
        mut all: VoxelCurves,
        [most, at_a_time]: [usize; 2],
    ) -> VoxelCurves {
        let depth = (at_a_time / (nx * ny)).max(1);
        for first in (0..nz).step_by(depth) {
            let last = (first + depth).min(nz);
            // With a layer before and one behind.
            let (from, to) = (first.saturating_sub(1), (last + 1).min(nz));
            let keep =
                |layer: &mut Vec<f32>, _: usize, _: usize, row: &[f32]| layer.extend_from_slice(&row[..nx]);
            let bent = self.laplacian.layers(from..to, |_| Vec::with_capacity(nx * ny), keep);
            let least = all.least;
            let start = |_| Layer { lengths: vec![0.0; nx], ..Layer::default() };
            let layers = self.regression.layers(first..last, start, |layer, row| {
                let at = |y: usize, z: usize| bent.get(z).and_then(|l| l.get(nx * y..nx * (y + 1)));
                let (y, z) = (row.y, row.z - from);
                let Some(here) = at(y, z) else { return };
                let below = |i: usize| i.checked_sub(1);
                let beside = [
                    below(y).and_then(|y| at(y, z)),
                    if y + 1 < ny { at(y + 1, z) } else { None },
                    below(z).and_then(|z| at(y, z)),
                    at(y, z + 1),
                ];
                self.row(layer, &row, here, beside, [nx, ny], least);
            });
            for layer in layers {
                all.voxel.extend_from_slice(&layer.voxel);
                all.magnitude.extend_from_slice(&layer.magnitude);
                all.laplacian.extend_from_slice(&layer.laplacian);
                for g in layer.gradient {
                    push(&mut all.normal, -self.regression.gradient(g).normalize_or_zero());
                }
            }
            while all.voxel.len() > most {
                thin(&mut all);
            }
        }
        all.settle();
        all
    }

    /// Adds the voxels of a row. `here` are its Laplacians, `beside` those of the rows before and behind along y and z.
    fn row(
        &self,
        layer: &mut Layer,
        row: &RegressionRow<'_>,
        here: &[f32],
        beside: [Option<&[f32]>; 4],
        [nx, ny]: [usize; 2],
        least: f32,
    ) {
        let Layer { voxel, gradient, magnitude, laplacian, lengths } = layer;
        self.regression.magnitudes(row, lengths);
        let share = 1.0 / self.longest;
        let first = nx * (row.y + ny * row.z);
        let removed = |x: usize| {
            self.removed.is_some_and(|(affine, region)| {
                region.removes(affine.point([x as f64, row.y as f64, row.z as f64]))
            })
        };
        for (x, &length) in lengths.iter().enumerate() {
            // Not so for NaN, which is no place of an edge.
            let kept = length * share > least && here[x].is_finite();
            if !kept {
                continue;
            }
            let v = here[x];
            let changes = |other: f32| (v < 0.0) != (other < 0.0) && v.abs() <= other.abs();
            let crossed = (x > 0 && changes(here[x - 1]))
                || here.get(x + 1).is_some_and(|&other| changes(other))
                || beside.iter().flatten().any(|other| changes(other[x]));
            let bent = if crossed { 0.0 } else { (v.abs() / self.most_bent).min(1.0) };
            if bent <= self.t_log && !removed(x) {
                voxel.push((first + x) as u32);
                gradient.push(row.gradient.map(|g| g[x]));
                magnitude.push((length * share).min(1.0));
                laplacian.push(bent);
            }
        }
    }
}

fn push(vectors: &mut Vectors, v: DVec3) {
    vectors.x.push(v.x as f32);
    vectors.y.push(v.y as f32);
    vectors.z.push(v.z as f32);
}

/// Leaves out the half with the weaker gradients.
fn thin(all: &mut VoxelCurves) {
    let mut lengths = all.magnitude.clone();
    let middle = lengths.len() / 2;
    all.least = *lengths.select_nth_unstable_by(middle, f32::total_cmp).1;
    let kept: Vec<bool> = all.magnitude.iter().map(|&m| m > all.least).collect();
    fn keep<T>(values: &mut Vec<T>, kept: &[bool]) {
        let mut k = kept.iter();
        values.retain(|_| k.next().is_some_and(|&k| k));
    }
    keep(&mut all.voxel, &kept);
    keep(&mut all.magnitude, &kept);
    keep(&mut all.laplacian, &kept);
    for part in [&mut all.normal.x, &mut all.normal.y, &mut all.normal.z] {
        keep(part, &kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const N: usize = 24;

    /// A ball with a dense core, off the grid.
    fn ball() -> Volume {
        let value = |i: usize| {
            let p = DVec3::new((i % N) as f64, (i / N % N) as f64, (i / (N * N)) as f64);
            let away = p.distance(DVec3::new(11.3, 12.1, 11.7));
            ((9.0 - away).clamp(0.0, 1.5) * 200.0 + (4.0 - away).clamp(0.0, 1.5) * 90.0) as f32
        };
        Volume::from_vec([N; 3], [1.0; 3], (0..N * N * N).map(value).collect::<Vec<f32>>()).unwrap()
    }

    fn style(t_log: f32, t_grad: f32) -> Style {
        Style { t_log, t_grad, ..Style::default() }
    }

    #[test]
    fn the_voxels_are_those_of_a_slow_search() {
        let volume = ball();
        let bent = volume.laplacian_of_gaussian(SIGMA).unwrap().field().unwrap();
        let regression = volume.regression().unwrap();
        let mut lengths = Vec::new();
        let row = |of: &mut Vec<f32>, row: RegressionRow<'_>| {
            let mut here = vec![0.0; N];
            regression.magnitudes(&row, &mut here);
            of.extend(here);
        };
        regression.layers(0..N, |_| Vec::new(), row).into_iter().for_each(|layer| lengths.extend(layer));
        let largest = |of: &[f32]| of.iter().fold(0.0f32, |m, v| m.max(v.abs()));
        let (most_bent, longest) = (largest(&bent), largest(&lengths));
        for (t_log, t_grad) in [(0.0, 0.1), (0.05, 0.0), (0.3, 0.4), (1.0, 0.2)] {
            let expected: Vec<u32> = (0..N * N * N)
                .filter(|&i| {
                    let at = [i % N, i / N % N, i / (N * N)];
                    let crossed = (0..3).any(|axis| {
                        [-1, 1].into_iter().any(|step| {
                            let there = at[axis] as isize + step;
                            let other = i as isize + step * [1, N, N * N][axis] as isize;
                            (0..N as isize).contains(&there) && {
                                let (a, b) = (bent[i], bent[other as usize]);
                                (a < 0.0) != (b < 0.0) && a.abs() <= b.abs()
                            }
                        })
                    });
                    lengths[i] / longest > t_grad && (crossed || bent[i].abs() / most_bent <= t_log)
                })
                .map(|i| i as u32)
                .collect();
            // Shares are taken by multiplication there: a voxel right on a limit may differ, and none does here.
            for at_a_time in [1, 5 * N * N, AT_A_TIME] {
                let curves =
                    bake_some(&volume, [0.0; 3], &style(t_log, t_grad), None, [usize::MAX, at_a_time]);
                assert_eq!(curves.voxel, expected, "{t_log} {t_grad}");
            }
            assert!(expected.len() > 300, "{}", expected.len());
        }
    }

    #[test]
    fn places_and_normals_are_those_of_the_ball() {
        let origin = [3.0, -2.0, 1.0];
        let curves = bake(&ball(), origin, &style(0.0, 0.3), None);
        let center = Vec3::new(11.3 - 3.0, 12.1 + 2.0, 11.7 - 1.0);
        for i in 0..curves.len() {
            let from = curves.position.at(i) - center;
            let away = from.length();
            // The slopes run from 7.5 to 9 and from 2.5 to 4.
            assert!((away - 8.25).abs() < 1.5 || (away - 3.25).abs() < 1.5, "{away}");
            assert!(curves.normal.at(i).dot(from / away) > 0.95);
        }
    }

    #[test]
    fn of_too_many_the_strongest_stay() {
        let (volume, style) = (ball(), style(1.0, 0.0));
        let all = bake(&volume, [0.0; 3], &style, None);
        assert_eq!(all.least, 0.0);
        for at_a_time in [1, AT_A_TIME] {
            let some = bake_some(&volume, [0.0; 3], &style, None, [all.len() / 3, at_a_time]);
            assert!(some.least > 0.0 && some.len() <= all.len() / 3 && some.len() > all.len() / 20);
            let strong = |&i: &usize| all.magnitude[i] > some.least;
            let expected: Vec<u32> = (0..all.len()).filter(strong).map(|i| all.voxel[i]).collect();
            assert_eq!(some.voxel, expected);
            assert!([some.position.len(), some.normal.len(), some.laplacian.len()] == [some.len(); 3]);
        }
    }

    #[test]
    fn a_flat_volume_has_no_curves() {
        for value in [7.0, f32::NAN] {
            let flat = Volume::from_vec([4; 3], [1.0; 3], vec![value; 64]).unwrap();
            assert!(bake(&flat, [0.0; 3], &style(1.0, 0.0), None).is_empty());
        }
    }
}
