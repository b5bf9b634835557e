//! The papers' bake of a volume: which of its voxels carry stipples, and how many.
//!
//! Lu et al., "Non-photorealistic volume rendering using stippling techniques" (2002, section 4): the volume is
//! box-filtered until a voxel covers at least 5 × 5 pixels, gradients are found by regression, and each voxel whose
//! gradient is above a threshold gets a list of stipples ([`voxel`]). With the papers' factors the whole volume is drawn;
//! where tone is a sum of ink, only the voxels through which the feature's surface runs, so that both bakes draw the same
//! form.
//!
//! Two things are told from the view alone and not from where it is seen from, or from how finely the page is divided,
//! so that the frames of a turn and the sizes of a print have one bake: a pixel is a thousandth of the page's shorter
//! side, and the rendered area is the mean over all directions, a quarter of the surface of the volume's box (Cauchy).

use dotwork_drawing::{Page, View, Warnings};
use dotwork_ink::bake::{VoxelSettings, Voxels, box_filter, box_filter_level, n_max, reference_scale, voxel};
use dotwork_ink::{Factors, Stock, Style, Vectors};
use dotwork_mesh::ClipRegion;
use dotwork_volume::{
    Affine, MIN_PIECE, Mask, Regression, RegressionRow, Sample, Samples, Scaling, Volume, with_samples,
};
use glam::{DVec3, Vec3};

/// Pixels across the page's shorter side.
const PAGE: f32 = 1000.0;

/// Share of the voxels with stipples whose gradients are weaker than what counts as 1.
const STRONG: f64 = 0.98;

/// How far from a surface the centres of the voxels lie through which it runs, in mean edges.
const SURFACE: f64 = 0.6;

/// What a voxel bake depends on besides the volume.
pub(crate) struct Ask<'a> {
    /// Coordinates are relative to this.
    pub origin: [f64; 3],
    /// Value of the feature's surface.
    pub iso: Option<f64>,
    /// What is clipped away, world units.
    pub removed: Option<ClipRegion>,
    pub style: &'a Style,
    pub view: &'a View,
    pub page: &'a Page,
    pub seed: u32,
}

/// Bakes the voxels of a volume; `None` if it has none that could carry a stipple: all values are the same, or there
/// is no memory for them. `progress` is called with a share 0…1.
pub(crate) fn bake(volume: &Volume, ask: &Ask, progress: &mut dyn FnMut(f32)) -> Option<Stock> {
    let Ask { style, view, page, .. } = *ask;
    // Pixels of this page's thousandth for an object unit.
    let reference = reference_scale(view, page);
    let scale = reference * PAGE;
    let range = volume.regression().map(|r| [r.value(0.0), r.value(1.0)])?;
    let edge = volume.affine().linear.determinant().abs().cbrt() as f32;
    let filtered = filter(volume, box_filter_level(scale * edge));
    progress(0.2);
    let grid = filtered.as_ref().unwrap_or(volume);
    let surface = ask.iso.filter(|_| style.factors == Factors::Sum);
    let voxels = boundaries(grid, range, style.gradient_min.0, surface, ask)?;
    progress(0.4);

    let [a, b, c] = [0, 1, 2].map(|k| voxels.edges[k] * grid.dims()[k] as f32);
    let mean_area = 0.5 * (a.cross(b).length() + b.cross(c).length() + c.cross(a).length());
    let settings = VoxelSettings {
        n_max: n_max(style.k_max, mean_area * scale * scale, grid.dims()),
        slab: style.slab,
        seed: ask.seed,
        reference: Some(reference),
    };
    // What is left out is seen in the stock: `n_max` against `wanted`.
    let stock = voxel(&voxels, &settings, &mut Warnings::new());
    progress(1.0);
    (!stock.is_empty()).then_some(stock)
}

/// The volume with voxels `factor` times as long, each the mean of those in it; `None` if they stay, or where there is
/// no memory for others. Works on as many layers as make one of the result.
fn filter(volume: &Volume, factor: usize) -> Option<Volume> {
    let dims @ [nx, ny, nz] = volume.dims();
    // Fewer than two voxels an axis have no gradient.
    let factor = factor.min(dims.into_iter().filter(|&d| d > 1).min().unwrap_or(1).div_ceil(2));
    if factor < 2 {
        return None;
    }
    let layer = nx * ny;
    let small = dims.map(|d| d.div_ceil(factor));
    let mut out: Vec<f32> = Vec::new();
    out.try_reserve_exact(small.iter().product()).ok()?;
    let mut slab: Vec<f32> = Vec::new();
    slab.try_reserve_exact(layer * factor.min(nz)).ok()?;
    let scaling = volume.scaling();
    for first in (0..nz).step_by(factor) {
        let last = (first + factor).min(nz);
        slab.clear();
        with_samples!(volume.samples(), samples => {
            slab.extend(samples[first * layer..last * layer].iter().map(|s| scaling.value(s.to_f64()) as f32));
        });
        out.extend(box_filter(&slab, [nx, ny, last - first], factor).0);
    }
    let affine = volume.affine();
    let middle = (factor - 1) as f64 / 2.0;
    let affine =
        Affine { linear: affine.linear * factor as f64, origin: affine.point([middle; 3]), ..*affine };
    Volume::new(small, Samples::F32(out), Scaling::default(), affine).ok()
}

/// The voxels of a layer that carry stipples.
#[derive(Default)]
struct Layer {
    index: Vec<[u32; 2]>,
    value: Vec<f32>,
    length: Vec<f32>,
    gradient: Vec<[f32; 3]>,
    /// Largest length of any gradient in the layer.
    longest: f32,
    lengths: Vec<f32>,
}

/// The voxels of a volume with strong gradients: `share` of the strongest or more, or those that the volume's own
/// threshold keeps; only those through which the surface at the value `surface` runs, if there is one, and whose
/// centres are not clipped away. Values count from 0 to 1 over `range`.
fn boundaries(
    volume: &Volume,
    range: [f64; 2],
    share: Option<f32>,
    surface: Option<f64>,
    ask: &Ask,
) -> Option<Voxels> {
    let regression = volume.regression()?;
    let [nx, _, nz] = volume.dims();
    let mask = match share {
        Some(_) => None,
        None => hysteresis(&regression),
    };
    let longest = |layers: &[Layer]| layers.iter().map(|layer| layer.longest).fold(0.0, f32::max);
    let least = match share {
        None => 0.0,
        Some(share) => share * longest(&layers(&regression, nz, nx, f32::INFINITY, None)),
    };
    let layers = layers(&regression, nz, nx, least, mask.as_ref());
    let strongest = strong(layers.iter().flat_map(|layer| &layer.length).copied().collect())?;

    let (affine, origin) = (volume.affine(), DVec3::from_array(ask.origin));
    let mut voxels = Voxels { edges: edges(affine), ..Voxels::default() };
    let unit = |value: f32| (regression.value(f64::from(value)) - range[0]) / (range[1] - range[0]);
    let push = |vectors: &mut Vectors, v: Vec3| {
        vectors.x.push(v.x);
        vectors.y.push(v.y);
        vectors.z.push(v.z);
    };
    let reach = SURFACE * affine.linear.determinant().abs().cbrt();
    let off_surface = |layer: &Layer, k: usize| {
        surface.is_some_and(|iso| {
            let away = (regression.value(f64::from(layer.value[k])) - iso).abs();
            away > reach * regression.gradient(layer.gradient[k]).length()
        })
    };
    for (z, layer) in layers.iter().enumerate() {
        for (k, &[x, y]) in layer.index.iter().enumerate() {
            if off_surface(layer, k) {
                continue;
            }
            let place = affine.point([f64::from(x), f64::from(y), z as f64]);
            // Only now: what counts as strong, or as an edge, is that of the whole.
            if ask.removed.as_ref().is_some_and(|region| region.removes(place)) {
                continue;
            }
            push(&mut voxels.position, (place - origin).as_vec3());
            let normal = -regression.gradient(layer.gradient[k]).normalize_or_zero();
            push(&mut voxels.normal, normal.as_vec3());
            voxels.magnitude.push((layer.length[k] / strongest).min(1.0));
            voxels.value.push(unit(layer.value[k]).clamp(0.0, 1.0) as f32);
        }
    }
    Some(voxels)
}

/// The length that counts as 1: not the longest, which may be one edge of metal, but that which few pass; `None` if
/// there are none.
fn strong(mut lengths: Vec<f32>) -> Option<f32> {
    let at = ((lengths.len() as f64 * STRONG) as usize).min(lengths.len().checked_sub(1)?);
    Some(*lengths.select_nth_unstable_by(at, f32::total_cmp).1)
}

/// The voxels that the threshold found in the histogram keeps, pieces of all sizes where there are no large ones;
/// `None`: all with a gradient.
fn hysteresis(regression: &Regression<'_>) -> Option<Mask> {
    let threshold = regression.threshold()?;
    [MIN_PIECE, 0]
        .into_iter()
        .find_map(|piece| regression.boundaries(threshold, piece).ok().filter(|mask| mask.count() > 0))
}

fn layers(regression: &Regression<'_>, nz: usize, nx: usize, least: f32, mask: Option<&Mask>) -> Vec<Layer> {
    let row = |layer: &mut Layer, row: RegressionRow<'_>| {
        let Layer { index, value, length, gradient, longest, lengths } = layer;
        regression.magnitudes(&row, lengths);
        let bits = mask.map(|mask| mask.row(row.y, row.z));
        for (x, &l) in lengths.iter().enumerate() {
            // Not so for NaN.
            if l > 0.0 {
                *longest = longest.max(l);
                let kept = bits.is_none_or(|bits| bits[x / 64] >> (x % 64) & 1 == 1);
                if kept && l >= least && row.value[x].is_finite() {
                    index.push([x as u32, row.y as u32]);
                    value.push(row.value[x]);
                    length.push(l);
                    gradient.push(row.gradient.map(|g| g[x]));
                }
            }
        }
    };
    regression.layers(0..nz, |_| Layer { lengths: vec![0.0; nx], ..Layer::default() }, row)
}

/// The three edges of a voxel.
fn edges(affine: &Affine) -> [Vec3; 3] {
    [affine.linear.x_axis, affine.linear.y_axis, affine.linear.z_axis].map(|v| v.as_vec3())
}
