//! The `face` bake of the papers: for each face of a mesh a list of stipples, thinned by counting.
//!
//! Lu et al., "Illustrative interactive stipple rendering" (2003, sections 4.2 and 4.3): every polygon has a list of at
//! most `N_max` points, spread to near-Poisson, `N_max` from the area that it covers on the page, so that the pattern
//! does not depend on the tessellation. A frame draws the first of the list, as many as the tone asks for; the fraction
//! of a dot is a probability, the same for a face in every frame (section 5.2).
//!
//! That is the one rule of all bakes. With `u_e`, 0 ≤ u_e < 1, the face's number, the k-th stipple (from 1) of a face of
//! area A gets the radius `sqrt(2 A / (√3 (k − u_e)))`. Where a frame asks for the spacing of `n` stipples a face, exactly
//! those with `k ≤ n + u_e` have radii at least as large: `n + u_e − ½` of them, rounded, which is the papers' weighted sum
//! with all the weight on the face's number. Since the numbers are evenly spread, the mean is `n`
//! whatever the size of the faces. Other weights shift the count; see [`crate::tone::count`].
//!
//! *Points.* Lists that know nothing of each other leave rows of holes or doubled dots along shared edges; the papers do
//! not say what they do about it. Here one farthest-point order runs over the whole mesh ([`blue_noise`]), and a face's
//! list is what falls on it, in that order. Where it falls short, points are added, each the best of some candidates in
//! its face.
//!
//! *Numbers.* Where faces are finer than dots the numbers alone decide, and random ones (the papers') are white noise. So
//! that faces with neighbouring numbers lie far apart, they are ranked by when the farthest-point order first falls on
//! them, in terms of their own share, faces of like areas among each other. [`Rank::Random`] is the papers' own.

mod rank;
mod spare;

use dotwork_drawing::hash::hash2;
use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

use super::blue_noise::{BakeSettings, MAX_STIPPLES, blue_noise};
use super::voxel::spacing_of;
use crate::params::Rank;
use crate::stock::{Baked, Faces, Stock};
use crate::surface::MeshSurface;

/// Bits of a stipple's id.
const ID_BITS: u32 = 38;

/// More than is asked for, so that what is cut off is never missed: as a share, and in square roots of the faces.
const MORE: (f64, f64) = (1.02, 3.0);

/// What a face bake is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceSettings {
    /// Number of stipples; the bake has exactly this many unless the surface is degenerate.
    pub stipples: usize,
    /// Most stipples that faces show, per object unit squared: `N_max` of a face is this times its area.
    pub n_max: f32,
    /// Most stipples that were asked for, per object unit squared: more than `n_max` where there would be too many.
    pub wanted: f32,
    /// How faces get their numbers.
    pub rank: Rank,
    /// 0 looser and hand-like … 1 as even as possible; see [`BakeSettings::regularity`].
    pub regularity: f32,
    /// Seed of every random choice.
    pub seed: u32,
    /// The scale of the view that `n_max` was made for, from [`super::reference_scale`]; `None`: every view is its own.
    pub reference: Option<f32>,
}

/// The radius of the `k`-th stipple, counted from 0, of a face with this area and number.
#[inline(always)]
fn radius(area: f32, k: u32, number: f32) -> f32 {
    spacing_of(area, (k + 1) as f32 - number)
}

/// Bits of an id that count the stipples of a face, where there are `faces`.
fn rank_bits(faces: usize) -> u32 {
    ID_BITS - (usize::BITS - faces.saturating_sub(1).leading_zeros())
}

/// What takes the number of its face's list out of an id; see [`crate::Elements::rank_mask`].
pub(crate) fn rank_mask(faces: usize) -> u64 {
    (1 << rank_bits(faces)) - 1
}

/// Bakes a list of stipples for each face of a mesh; costs as [`blue_noise`] and a search around each point that is added.
///
/// The result is the same for any number of threads. `baked.element` and `baked.weights` are triangles and barycentric
/// coordinates as of any bake of a mesh; an id is the triangle and the place in its list. Faces without an area carry
/// nothing. `progress` is called with a share 0…1.
pub fn face(mesh: &Mesh, settings: &FaceSettings, mut progress: impl FnMut(f32)) -> Stock {
    let area = areas(mesh);
    let faces = area.len();
    let whole: f64 = area.iter().map(|&a| f64::from(a)).sum();
    let &FaceSettings { n_max, wanted, seed, reference, .. } = settings;
    if whole < f64::from(f32::MIN_POSITIVE) {
        // A mesh that was deformed to nothing.
        let faces = Faces { number: vec![0.0; faces], area, n_max, wanted, seed, reference };
        return Stock::of_faces(Baked::default(), mesh, faces);
    }
    let stipples = settings.stipples.clamp(1, MAX_STIPPLES);
    let many = (stipples as f64 * MORE.0 + MORE.1 * (faces as f64).sqrt()).ceil();
    let order =
        BakeSettings { stipples: many as usize, regularity: settings.regularity, seed: settings.seed };
    let order = blue_noise(&MeshSurface::new(mesh), &order, |share| progress(0.8 * share));
    let lists = Lists::of(&order, faces);

    let density = (many / whole) as f32;
    let number = match settings.rank {
        Rank::Random => rank::random(faces),
        Rank::Even => rank::even(&area, &lists, density, whole, settings.seed),
    };
    progress(0.85);
    // How many of its list each face needs.
    let mask = rank_mask(faces);
    let needed = |e: usize| ((area[e] * density + number[e]) as u64).min(mask) as u32;
    let kept: Vec<(u32, u32, [f32; 2])> = (0..faces)
        .flat_map(|e| {
            let list = lists.of_face(e).iter().take(needed(e) as usize).enumerate();
            list.map(move |(k, &i)| (e as u32, k as u32, i))
        })
        .map(|(e, k, i)| (e, k, order.weights[i as usize]))
        .collect();
    let missing: Vec<(u32, std::ops::Range<u32>)> = (0..faces)
        .map(|e| (e as u32, lists.of_face(e).len() as u32..needed(e)))
        .filter(|(_, places)| !places.is_empty())
        .collect();
    let points = spare::fill(mesh, kept, &missing, density, settings.seed);
    progress(0.95);

    let stream = hash2(4, settings.seed);
    let bits = rank_bits(faces);
    let mut keyed: Vec<(u64, u32)> = points
        .par_iter()
        .enumerate()
        .map(|(i, &(e, k, _))| {
            let falling = u64::from(!radius(area[e as usize], k, number[e as usize]).to_bits());
            (falling << 32 | u64::from(hash2(hash2(e, stream), k)), i as u32)
        })
        .collect();
    keyed.par_sort_unstable();
    keyed.truncate(stipples);
    let at = |&(_, i): &(u64, u32)| points[i as usize];
    let baked = Baked {
        radius: keyed.par_iter().map(|key| f32::from_bits(!((key.0 >> 32) as u32))).collect(),
        id: keyed.par_iter().map(at).map(|(e, k, _)| u64::from(e) << bits | u64::from(k)).collect(),
        element: keyed.par_iter().map(at).map(|(e, ..)| e).collect(),
        weights: keyed.par_iter().map(at).map(|(.., weights)| weights).collect(),
        area: whole,
        neighbours: Vec::new(),
    };
    let stock = Stock::of_faces(baked, mesh, Faces { number, area, n_max, wanted, seed, reference });
    progress(1.0);
    stock
}

/// Areas of the faces of a mesh, 0 for what has none.
fn areas(mesh: &Mesh) -> Vec<f32> {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
        let area = (0.5 * (b - a).cross(c - a).length()) as f32;
        if area.is_finite() { area } else { 0.0 }
    };
    mesh.triangles.par_iter().map(area).collect()
}

/// The place of barycentric `weights` on triangle `t`, and the triangle's normal.
fn place(mesh: &Mesh, t: u32, [v, w]: [f32; 2]) -> (Vec3, Vec3) {
    let [a, b, c] = mesh.triangles[t as usize].map(|i| mesh.positions[i as usize]);
    let (ab, ac) = (b - a, c - a);
    (a + ab * v + ac * w, ab.cross(ac).normalize_or_zero())
}

/// For each face the points of an order that lie on it, in that order.
struct Lists {
    starts: Vec<u32>,
    points: Vec<u32>,
}

impl Lists {
    fn of(order: &Baked, faces: usize) -> Lists {
        let mut starts = vec![0u32; faces + 1];
        for &e in &order.element {
            starts[e as usize + 1] += 1;
        }
        for e in 0..faces {
            starts[e + 1] += starts[e];
        }
        let mut next = starts.clone();
        let mut points = vec![0u32; order.len()];
        for (i, &e) in order.element.iter().enumerate() {
            points[next[e as usize] as usize] = i as u32;
            next[e as usize] += 1;
        }
        Lists { starts, points }
    }

    fn of_face(&self, e: usize) -> &[u32] {
        &self.points[self.starts[e] as usize..self.starts[e + 1] as usize]
    }
}

#[cfg(test)]
mod tests;
