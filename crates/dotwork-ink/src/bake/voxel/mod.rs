//! The `voxel` bake of the papers: for each voxel a list of stipples near its tangent plane.
//!
//! Lu et al., "Non-photorealistic volume rendering using stippling techniques" (2002, section 4.3): in every voxel
//! whose gradient is strong enough, N_max points lie about its centre between two planes parallel to the tangent plane
//! and about equally far apart; a frame draws the first of them, as many as the voxel's tone asks for.
//!
//! That is the one rule of all bakes: the k-th stipple of a voxel gets as its radius the hexagonal spacing of `k − ½`
//! points on the voxel's section, `sqrt(2 A / (√3 (k − ½)))`. Where a frame asks for the spacing of `n` points, exactly
//! `n` of the list, rounded, have radii at least as large.
//!
//! The lists of neighbouring voxels know nothing of each other. Where a voxel shows many dots they are even; where it
//! shows one or none they are as good as random, which is the method's own limit.

mod list;
mod resolution;
mod section;

use dotwork_drawing::Warnings;
use dotwork_drawing::hash::{hash2, unit};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::MAX_STIPPLES;
use crate::stock::{Baked, Carrier, Elements, Stock, Vectors};
use list::Scratch;
pub use resolution::{MIN_VOXEL_PX, box_filter, box_filter_level, n_max, reference_scale};
use section::Section;

/// Bits of an id that count the stipples of a voxel.
const RANK_BITS: u32 = 12;

/// Most stipples of one voxel. A voxel covers some 25 to 64 pixels: this is more than its page is black with.
pub const MAX_IN_VOXEL: usize = 128;

/// The voxels that carry stipples: those whose gradient is above the threshold, in structure-of-arrays form.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Voxels {
    /// Centres, object units.
    pub position: Vectors,
    /// Unit normals: against the gradient for what is bright in a dark surround.
    pub normal: Vectors,
    /// Length of the gradient over a large one of the volume, 0…1.
    pub magnitude: Vec<f32>,
    /// Value over the value window, 0…1.
    pub value: Vec<f32>,
    /// The three edges of a voxel, object units.
    pub edges: [Vec3; 3],
}

impl Voxels {
    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
}

/// What a voxel bake is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoxelSettings {
    /// Most stipples that a voxel shows; see [`n_max`].
    pub n_max: f32,
    /// Distance of the two planes between which stipples lie, in mean edges of a voxel.
    pub slab: f32,
    /// Seed of every random choice.
    pub seed: u32,
    /// The scale of the view that `n_max` was made for, from [`reference_scale`]; `None`: every view is its own.
    pub reference: Option<f32>,
}

impl Default for VoxelSettings {
    fn default() -> Self {
        VoxelSettings { n_max: 25.0, slab: 0.5, seed: 0, reference: None }
    }
}

/// The radius of the `k`-th stipple, counted from 0, on a section of this area.
#[inline(always)]
fn radius(area: f32, k: usize) -> f32 {
    spacing_of(area, k as f32 + 0.5)
}

/// The spacing that draws `count` stipples, rounded, of an element with this section: `sqrt(2 A / (√3 count))`.
#[inline(always)]
pub fn spacing_of(area: f32, count: f32) -> f32 {
    const HEXAGONAL: f32 = 1.154_700_5;
    (HEXAGONAL * area / count).sqrt()
}

/// What takes the place in its voxel's list out of an id; see [`Elements::rank_mask`].
pub(crate) const RANK_MASK: u64 = (1 << RANK_BITS) - 1;

/// Bakes a list of stipples for each voxel.
///
/// The result is the same for any number of threads; ids follow from a voxel's place among `voxels` and the stipple's
/// place in its list. Voxels whose normal is no unit vector keep their number but carry nothing. What has to be left
/// out so that no more than [`MAX_STIPPLES`] are baked is said in `warnings`.
///
/// # Panics
/// If the lists of `voxels` differ in length.
pub fn voxel(voxels: &Voxels, settings: &VoxelSettings, warnings: &mut Warnings) -> Stock {
    let lists = [voxels.normal.len(), voxels.magnitude.len(), voxels.value.len()];
    assert_eq!(lists, [voxels.len(); 3], "voxels have as many of everything");
    let count = voxels.len().min(MAX_STIPPLES);
    if count < voxels.len() {
        warnings.say(format!("only the first {count} of {} voxels carry stipples", voxels.len()));
    }
    let wanted = (settings.n_max.ceil() as usize).clamp(1, MAX_IN_VOXEL);
    let length = wanted.min(MAX_STIPPLES / count.max(1));
    if settings.n_max > length as f32 {
        warnings.say(format!(
            "a voxel carries {length} stipples instead of {:.0}: at most {MAX_STIPPLES} are baked, {MAX_IN_VOXEL} in a voxel",
            settings.n_max
        ));
    }

    let edge = voxels.edges[0].cross(voxels.edges[1]).dot(voxels.edges[2]).abs().cbrt();
    let area: Vec<f32> =
        (0..count).into_par_iter().map(|e| section(voxels, e).map_or(0.0, |s| s.area)).collect();
    let places = place(voxels, settings, &area, length, edge * settings.slab);
    let order = order(&area, length, settings.seed);

    // Voxel-major numbers: voxel · length + place in the list.
    let voxel_of = |i: u32| i as usize / length;
    let baked = Baked {
        radius: order.par_iter().map(|&i| radius(area[voxel_of(i)], i as usize % length)).collect(),
        id: order
            .par_iter()
            .map(|&i| (voxel_of(i) as u64) << RANK_BITS | (i as usize % length) as u64)
            .collect(),
        element: order.par_iter().map(|&i| voxel_of(i) as u32).collect(),
        weights: vec![[0.0; 2]; order.len()],
        neighbours: Vec::new(),
        area: area.iter().map(|&a| f64::from(a)).sum(),
    };
    let normal = Vectors::collect(order.len(), |j| voxels.normal.at(voxel_of(order[j])));
    Stock {
        position: Vectors::collect(order.len(), |j| places[order[j] as usize]),
        facet: normal.clone(),
        normal,
        baked: baked.into(),
        own: Vec::new(),
        tint: Vec::new(),
        stretch: Vec::new(),
        elements: Some(Elements {
            position: voxels.position.first(count),
            normal: voxels.normal.first(count),
            value: voxels.value[..count].to_vec(),
            magnitude: voxels.magnitude[..count].to_vec(),
            area,
            n_max: settings.n_max.min(length as f32),
            wanted: settings.n_max,
            carrier: Carrier::Voxels { edges: voxels.edges, slab: settings.slab },
            seed: settings.seed,
            reach: reach(voxels.edges, edge * settings.slab),
            reference: settings.reference,
        }),
    }
}

impl Elements {
    /// The voxels and the settings of which [`voxel`] makes the stock that has these elements; `None` where they are faces.
    pub fn recipe(&self) -> Option<(Voxels, VoxelSettings)> {
        let Carrier::Voxels { edges, slab } = self.carrier else { return None };
        let voxels = Voxels {
            position: self.position.clone(),
            normal: self.normal.clone(),
            magnitude: self.magnitude.clone(),
            value: self.value.clone(),
            edges,
        };
        let Elements { seed, reference, .. } = *self;
        Some((voxels, VoxelSettings { n_max: self.wanted, slab, seed, reference }))
    }
}

/// How far a stipple may lie from its voxel's centre: half the longest diagonal, and half of the slab.
fn reach([a, b, c]: [Vec3; 3], slab: f32) -> f32 {
    let diagonals = [a + b + c, a + b - c, a - b + c, -a + b + c];
    0.5 * (diagonals.map(Vec3::length).into_iter().fold(0.0, f32::max) + slab)
}

fn section(voxels: &Voxels, e: usize) -> Option<Section> {
    let normal = voxels.normal.at(e);
    normal.is_normalized().then(|| Section::new(voxels.edges, normal)).flatten()
}

/// The places of all stipples, voxel after voxel.
fn place(voxels: &Voxels, settings: &VoxelSettings, area: &[f32], length: usize, slab: f32) -> Vec<Vec3> {
    let mut places = vec![Vec3::ZERO; area.len() * length];
    let seeds = [hash2(0, settings.seed), hash2(1, settings.seed)];
    places.par_chunks_mut(length.max(1)).enumerate().with_min_len(16).for_each_init(
        || (Scratch::default(), vec![Vec2::ZERO; length]),
        |(scratch, points), (e, places)| {
            let Some(section) = section(voxels, e) else { return };
            list::fill(&section, hash2(e as u32, seeds[0]), scratch, points);
            let (center, normal) = (voxels.position.at(e), voxels.normal.at(e));
            let stream = hash2(e as u32, seeds[1]);
            for (k, (place, st)) in places.iter_mut().zip(points.iter()).enumerate() {
                let height = slab * (unit(hash2(k as u32, stream)) - 0.5);
                *place = center + section.place(*st) + height * normal;
            }
        },
    );
    places
}

/// The stipples in falling order of their radii, as voxel-major numbers; equal ones in an order of hashes, so that no
/// part of the stock is one part of the volume.
fn order(area: &[f32], length: usize, seed: u32) -> Vec<u32> {
    let stream = hash2(2, seed);
    let mut keyed: Vec<(u64, u32)> = (0..area.len() * length)
        .into_par_iter()
        .filter(|i| area[i / length] > 0.0)
        .map(|i| {
            let falling = u64::from(!radius(area[i / length], i % length).to_bits());
            (falling << 32 | u64::from(hash2(i as u32, stream)), i as u32)
        })
        .collect();
    keyed.par_sort_unstable();
    keyed.into_par_iter().map(|(_, i)| i).collect()
}

#[cfg(test)]
mod tests;
