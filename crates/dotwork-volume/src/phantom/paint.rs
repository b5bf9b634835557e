//! From solids to samples: layers of matter painted one over the other.
//!
//! A voxel is the mixture of what its neighbourhood holds, the *partial volume* of a scanner: each layer covers what
//! lies beneath it by a share that falls smoothly from 1 to 0 across its boundary. Space is halved down to blocks of
//! 4³ voxels; a layer whose boundary is farther than the block is large covers it wholly or not at all, so that the
//! distances of most layers are evaluated once for many voxels.

use dotwork_drawing::hash::{hash3, mix};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::affine::{Affine, Space, Unit};
use crate::samples::Samples;
use crate::volume::{Scaling, Volume};

/// Half the width of a boundary, voxels: about one voxel between 25 % and 75 % and more, so that linear interpolation
/// between samples finds the surface without terraces.
const HALF_WIDTH: f32 = 1.2;

/// Edge of the blocks whose layers are decided one by one, voxels.
const LEAF: usize = 4;

/// Edge of the blocks that threads take, voxels.
const ROOT: usize = 16;

/// How much faster a distance may change than a true one: the smooth unions of estimated distances are no exact ones.
const SLOPE: f32 = 1.6;

/// Most layers of a scene: the decisions of a block are kept in place.
const MAX_LAYERS: usize = 32;

/// A signed distance, negative inside, millimetres.
pub(super) type Distance<'a> = &'a (dyn Fn(Vec3) -> f32 + Sync);

/// Matter of one value inside a solid.
#[derive(Clone, Copy)]
pub(super) struct Layer<'a> {
    /// Its value.
    pub(super) value: f32,
    /// The solid.
    pub(super) solid: Distance<'a>,
    /// What lies deeper than a depth (millimetres) inside it, by value: the spongy bone within the compact.
    pub(super) core: Option<(f32, f32)>,
}

/// A grid of samples in the world.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    /// Voxels along x, y and z.
    pub(super) dims: [usize; 3],
    /// Edge of a voxel, millimetres.
    pub(super) spacing: f32,
    /// Centre of the first voxel, millimetres.
    pub(super) origin: Vec3,
    /// What the axes mean.
    pub(super) space: Space,
}

impl Grid {
    /// Cubic voxels in the box from `min` to `max`, `size` of them along its longest side.
    pub(super) fn within(min: Vec3, max: Vec3, size: usize, space: Space) -> Grid {
        let spacing = (max - min).max_element() / size as f32;
        // The tolerance keeps a rounding error from adding a slice.
        let dims = (max - min).to_array().map(|side| ((side / spacing - 1e-3).ceil() as usize).max(1));
        let middle = (min + max) / 2.0;
        let half = Vec3::from_array(dims.map(|n| (n - 1) as f32 / 2.0)) * spacing;
        Grid { dims, spacing, origin: middle - half, space }
    }

    fn point(&self, x: usize, y: usize, z: usize) -> Vec3 {
        self.origin + Vec3::new(x as f32, y as f32, z as f32) * self.spacing
    }

    /// Makes these samples a volume in millimetres.
    pub(super) fn volume(&self, samples: Samples) -> Volume {
        let affine = Affine {
            origin: DVec3::from_array(self.origin.to_array().map(f64::from)),
            space: self.space,
            unit: Unit::Millimetre,
            ..Affine::from_spacing([f64::from(self.spacing); 3])
        };
        Volume::new(self.dims, samples, Scaling::default(), affine).expect("a grid with voxels of some size")
    }
}

/// What of a layer covers a point at this distance, 0 … 1.
fn coverage(distance: f32, half_width: f32) -> f32 {
    let t = (0.5 - distance / (2.0 * half_width)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// What noise is added: Gaussian to within 1 % below three standard deviations, the sum of twelve bytes of a hash.
#[derive(Clone, Copy)]
pub(super) struct Noise {
    /// Standard deviation, in values.
    pub(super) sigma: f32,
    /// Seed of the hash.
    pub(super) seed: u32,
}

impl Noise {
    /// None.
    pub(super) const NONE: Noise = Noise { sigma: 0.0, seed: 0 };

    /// The deviate of a voxel, standard deviation 1.
    fn deviate(&self, x: usize, y: usize, z: usize) -> f32 {
        let first = hash3(x as u32 | (y as u32) << 16, z as u32, self.seed);
        let second = mix(first ^ 0x9e37_79b9);
        let third = mix(second ^ 0x85eb_ca6b);
        let bytes = |h: u32| h.to_le_bytes().into_iter().map(u32::from).sum::<u32>();
        // Twelve bytes: mean 12 · 127.5, variance 12 · (256² − 1)/12.
        (bytes(first) + bytes(second) + bytes(third)) as f32 / 256.0 - 12.0 * 127.5 / 256.0
    }
}

/// Paints the layers in their order over `ground` and rounds to whole samples of type `T`.
pub(super) fn paint<T>(grid: &Grid, ground: f32, layers: &[Layer], noise: Noise) -> Vec<T>
where
    T: Copy + Default + Send + Sync + FromValue,
{
    assert!(layers.len() <= MAX_LAYERS);
    let [nx, ny, nz] = grid.dims;
    let mut samples = vec![T::default(); nx * ny * nz];
    let painter = Painter { grid, ground, layers, half_width: HALF_WIDTH * grid.spacing };
    // A slab of slices for a thread; what a voxel becomes depends on the voxel alone.
    samples.par_chunks_mut(nx * ny * ROOT).enumerate().for_each(|(slab, samples)| {
        let z0 = slab * ROOT;
        let depth = samples.len() / (nx * ny);
        let mut block = [0f32; ROOT * ROOT * ROOT];
        for y0 in (0..ny).step_by(ROOT) {
            for x0 in (0..nx).step_by(ROOT) {
                painter.block(&mut block, [x0, y0, z0]);
                for z in 0..depth {
                    for y in 0..ROOT.min(ny - y0) {
                        let width = ROOT.min(nx - x0);
                        let from = &block[ROOT * (y + ROOT * z)..][..width];
                        let to = &mut samples[x0 + nx * (y0 + y + ny * z)..][..width];
                        if noise.sigma == 0.0 {
                            to.iter_mut().zip(from).for_each(|(to, &from)| *to = T::from_value(from));
                            continue;
                        }
                        for (x, (to, from)) in to.iter_mut().zip(from).enumerate() {
                            let deviate = noise.deviate(x0 + x, y0 + y, z0 + z);
                            *to = T::from_value(from + noise.sigma * deviate);
                        }
                    }
                }
            }
        }
    });
    samples
}

/// Sample types that values are rounded to.
pub(super) trait FromValue {
    /// The nearest sample; values beyond the range become its ends.
    fn from_value(value: f32) -> Self;
}

impl FromValue for u8 {
    fn from_value(value: f32) -> u8 {
        value.round_ties_even() as u8
    }
}

impl FromValue for i16 {
    fn from_value(value: f32) -> i16 {
        value.round_ties_even() as i16
    }
}

/// Layers of a block, undecided ones among them.
#[derive(Clone, Copy)]
struct Active {
    ground: f32,
    count: usize,
    layers: [u8; MAX_LAYERS],
}

struct Painter<'a> {
    grid: &'a Grid,
    ground: f32,
    layers: &'a [Layer<'a>],
    half_width: f32,
}

impl Painter<'_> {
    /// The values of the block of `ROOT`³ voxels from `corner`; voxels beyond the grid are painted too.
    fn block(&self, block: &mut [f32; ROOT * ROOT * ROOT], corner: [usize; 3]) {
        let mut all = Active { ground: self.ground, count: self.layers.len(), layers: [0; MAX_LAYERS] };
        (0..self.layers.len()).for_each(|i| all.layers[i] = i as u8);
        self.divide(block, corner, [0; 3], ROOT, &all);
    }

    fn divide(
        &self,
        block: &mut [f32; ROOT * ROOT * ROOT],
        corner: [usize; 3],
        at: [usize; 3],
        edge: usize,
        above: &Active,
    ) {
        let first = self.grid.point(corner[0] + at[0], corner[1] + at[1], corner[2] + at[2]);
        let half = (edge - 1) as f32 / 2.0 * self.grid.spacing;
        let reach = half * 3f32.sqrt() * SLOPE + self.half_width;
        let middle = first + Vec3::splat(half);
        let mut active = Active { ground: above.ground, count: 0, layers: [0; MAX_LAYERS] };
        for &i in &above.layers[..above.count] {
            let layer = &self.layers[usize::from(i)];
            let d = (layer.solid)(middle);
            let (depth, inmost) = layer.core.unwrap_or((0.0, layer.value));
            if d < -reach - depth {
                // Covers whatever lies beneath.
                active.ground = inmost;
                active.count = 0;
            } else if d <= reach {
                active.layers[active.count] = i;
                active.count += 1;
            }
        }
        if active.count == 0 || edge == LEAF {
            for z in 0..edge {
                for y in 0..edge {
                    let row = at[0] + ROOT * (at[1] + y + ROOT * (at[2] + z));
                    let row = &mut block[row..row + edge];
                    if active.count == 0 {
                        row.fill(active.ground);
                        continue;
                    }
                    for (x, value) in row.iter_mut().enumerate() {
                        let p = first + Vec3::new(x as f32, y as f32, z as f32) * self.grid.spacing;
                        *value = self.value(p, active.ground, &active.layers[..active.count]);
                    }
                }
            }
            return;
        }
        let edge = edge / 2;
        for child in 0..8 {
            let at = [0, 1, 2].map(|axis| at[axis] + (child >> axis & 1) * edge);
            self.divide(block, corner, at, edge, &active);
        }
    }

    /// The value at a point.
    fn value(&self, p: Vec3, ground: f32, layers: &[u8]) -> f32 {
        let mut value = ground;
        for &i in layers {
            let layer = &self.layers[usize::from(i)];
            let d = (layer.solid)(p);
            value += coverage(d, self.half_width) * (layer.value - value);
            if let Some((depth, core)) = layer.core {
                value += coverage(d + depth, self.half_width) * (core - value);
            }
        }
        value
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::phantom::distance::{ball, rounded_box};

    /// Every layer at every voxel: what [`paint`] has to equal.
    pub(in crate::phantom) fn paint_slowly(grid: &Grid, ground: f32, layers: &[Layer]) -> Vec<i16> {
        let painter = Painter { grid, ground, layers, half_width: HALF_WIDTH * grid.spacing };
        let every: Vec<u8> = (0..layers.len() as u8).collect();
        let [nx, ny, nz] = grid.dims;
        let voxels = (0..nx * ny * nz).into_par_iter();
        voxels
            .map(|i| {
                let p = grid.point(i % nx, i / nx % ny, i / nx / ny);
                i16::from_value(painter.value(p, ground, &every))
            })
            .collect()
    }

    #[test]
    fn blocks_change_nothing() {
        let far = |p: Vec3| ball(p - Vec3::new(3.0, -2.0, 1.0), 14.0);
        let near = |p: Vec3| rounded_box(p, Vec3::new(4.0, 19.0, 6.0), 1.0);
        let layers = [
            Layer { value: 500.0, solid: &far, core: Some((3.0, 700.0)) },
            Layer { value: -200.0, solid: &near, core: None },
        ];
        let grid = Grid::within(Vec3::splat(-20.0), Vec3::new(20.0, 17.0, 19.0), 45, Space::Unknown);
        assert_eq!(grid.dims, [45, 42, 44]);
        let fast: Vec<i16> = paint(&grid, -1000.0, &layers, Noise::NONE);
        assert!(fast.contains(&-1000) && fast.contains(&700) && fast.contains(&-200));
        assert!(fast == paint_slowly(&grid, -1000.0, &layers));
    }

    #[test]
    fn noise_is_gaussian_in_its_moments_and_white() {
        let noise = Noise { sigma: 1.0, seed: 5 };
        let n = 64;
        let deviates: Vec<f64> =
            (0..n * n * n).map(|i| f64::from(noise.deviate(i % n, i / n % n, i / n / n))).collect();
        let mean_of = |f: &dyn Fn(usize) -> f64| {
            (0..deviates.len() - n).map(f).sum::<f64>() / (deviates.len() - n) as f64
        };
        assert!(mean_of(&|i| deviates[i]).abs() < 0.01);
        assert!((mean_of(&|i| deviates[i].powi(2)) - 1.0).abs() < 0.01);
        // A normal distribution has 3; the sum of twelve uniform numbers has 2.9.
        assert!((mean_of(&|i| deviates[i].powi(4)) - 2.9).abs() < 0.05);
        for lag in [1, n] {
            assert!(mean_of(&|i| deviates[i] * deviates[i + lag]).abs() < 0.01);
        }
    }
}
