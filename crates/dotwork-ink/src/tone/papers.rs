//! The papers' tone: how many dots an element shows, as a product of factors.
//!
//! Lu et al., "Non-photorealistic volume rendering using stippling techniques" (2002, section 5) and "Illustrative
//! interactive stipple rendering" (2003, table 1). An element (a voxel, with value v, gradient G and normal n) shows
//! `N_max · T_b T_s T_r T_l T_d T_i` dots; a factor that is off is 1. Three equations do not stand as they are printed:
//! the resolution's ratio is upside down for depths that grow away from the eye, the distance factor is no number behind
//! the centre, and the lighting factor would thin what faces away from the light.
//!
//! Unlike ink a count belongs to the element, not to the page: two elements behind each other show twice the dots.

use dotwork_drawing::hash::{hash2, unit};
use dotwork_drawing::{Page, View};
use glam::Vec3;
use rayon::prelude::*;

use super::{Table, toon};
use crate::bake::reference_scale;
use crate::params::{Factors, SilhouetteForm, Style, TwoSided, Visibility};
use crate::stock::Elements;

/// The factors in the order of their product (2003, section 5).
pub const FACTORS: [&str; 6] = ["boundary", "silhouette", "resolution", "lighting", "distance", "interior"];

/// Boundary factor (eq 5): `T_b = v (k_gc + k_gs |G|^k_ge)`. It may exceed 1; the product is cut.
pub fn boundary(value: f32, magnitude: f32, k_gc: f32, k_gs: f32, k_ge: f32) -> f32 {
    value * (k_gc + k_gs * magnitude.powf(k_ge))
}

/// Silhouette factor (eq 6): `T_s = v (k_sc + k_ss (1 − |n·E|)^k_se)`, or `1 − |n·E|^k_se` in the last bracket with
/// the form `Inside`. It may exceed 1.
pub fn silhouette(value: f32, n_dot_e: f32, k_sc: f32, k_ss: f32, k_se: f32, form: SilhouetteForm) -> f32 {
    let c = n_dot_e.abs().min(1.0);
    let side = match form {
        SilhouetteForm::Outside => (1.0 - c).powf(k_se),
        SilhouetteForm::Inside => 1.0 - c.powf(k_se),
    };
    value * (k_sc + k_ss * side)
}

/// Resolution factor (eq 7): `T_r = ratio^k_re · |n·E|^k_nz`.
///
/// `ratio` is `(D_near + d_0) / (D_near + d)`: the depth of reference over the element's, or what is the same but holds
/// for zoom and parallel projection too, the element's scale on the page over that of reference. It exceeds 1 in front
/// of the reference. With `k_re` 2 the number of dots per page area is the same at every distance.
pub fn resolution(ratio: f32, n_dot_e: f32, k_re: f32, k_nz: f32) -> f32 {
    ratio.powf(k_re) * n_dot_e.abs().min(1.0).powf(k_nz)
}

/// Lighting factor (eq 10): `T_l = 1 − max(0, n·L)^k_le`; facing away from the light: 1.
pub fn lighting(n_dot_l: f32, k_le: f32) -> f32 {
    if n_dot_l > 0.0 { 1.0 - n_dot_l.min(1.0).powf(k_le) } else { 1.0 }
}

/// Distance factor (eq 8): `T_d = ((1 + z/a) / 2)^k_de` for k_de ≥ 0, `((1 − z/a) / 2)^|k_de|` below.
///
/// `z_over_a`: height over the centre towards the eye, −1…1. Above 0 `k_de` favours the near half, below 0 the far.
pub fn distance(z_over_a: f32, k_de: f32) -> f32 {
    let z = z_over_a.clamp(-1.0, 1.0) * if k_de < 0.0 { -1.0 } else { 1.0 };
    (0.5 * (1.0 + z)).powf(k_de.abs())
}

/// Interior factor (eq 9): `T_i = |G|^k_ie`.
pub fn interior(magnitude: f32, k_ie: f32) -> f32 {
    magnitude.powf(k_ie)
}

/// How small an element is on the page, w₂: 0 from `min_area_px` on, rising to 1 (2003, section 5.2).
pub fn small(area_px: f32, min_area_px: f32) -> f32 {
    (1.0 - area_px / min_area_px).clamp(0.0, 1.0)
}

/// The number of dots that an element asks for: `N_max · T + w₂ (u − ½)`, u the element's random number, 0…1.
///
/// A count is drawn rounded. With w₂ = 1 the rounding is fair: the mean over u is `N_max · T`.
pub fn count(n_max: f32, tone: f32, small: f32, u: f32) -> f32 {
    n_max * tone + small * (u - 0.5)
}

/// From how few dots on the rounding of a face's count shows, and from how many on it does not.
const FEW: f32 = 16.0;

/// How few dots a face asks for, 1 up to 16, falling to 0 at 32. A face is small in this way too, whatever its area on the
/// page: rounded, equal faces that ask for 0.4 of a dot would all show none, and the tessellation would make the tone.
pub fn few(count: f32) -> f32 {
    (2.0 - count / FEW).clamp(0.0, 1.0)
}

/// The random number of element `e`, 0…1: the same in every view and every bake.
#[inline(always)]
pub fn random_of(e: usize) -> f32 {
    unit(hash2(e as u32, 0x5eed))
}

/// The smallest `n·E` at which an element is drawn; `None` if all are: with the papers' factors, lighting draws front
/// oriented elements only, and so does any visibility but `through`.
pub fn front_limit(style: &Style) -> Option<f32> {
    let lit = style.factors == Factors::Papers && style.lighting;
    (lit || style.visibility != Visibility::Through).then(|| style.front_angle.to_radians().cos())
}

/// An element as a view sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sight {
    /// Value, 0…1.
    pub value: f32,
    /// Length of the gradient, 0…1.
    pub magnitude: f32,
    /// Cosine between the normal and the eye; negative from behind.
    pub n_dot_e: f32,
    /// Cosine between the normal and the light.
    pub n_dot_l: f32,
    /// Scale on the page over the scale of reference.
    pub ratio: f32,
    /// Height over the centre towards the eye over the radius of the bounding sphere, −1…1.
    pub z_over_a: f32,
}

/// A view with what all elements share in it.
#[derive(Clone, Copy, Debug)]
pub struct Viewing<'a> {
    view: &'a View,
    light: Vec3,
    /// 1 over the pixels of an object unit in the view of reference, at this page's size.
    inverse_reference: f32,
}

impl<'a> Viewing<'a> {
    /// A view of elements whose `n_max` was made for the scale `reference` ([`reference_scale`]; `None`: this view's).
    /// `light`: unit vector towards it.
    pub fn new(view: &'a View, page: &Page, light: Vec3, reference: Option<f32>) -> Viewing<'a> {
        let reference = reference.unwrap_or_else(|| reference_scale(view, page)) * page.short_side_px();
        Viewing { view, light, inverse_reference: 1.0 / reference }
    }

    /// How the view sees a place, and its scale in pixels an object unit.
    #[inline(always)]
    pub fn sight(&self, position: Vec3, normal: Vec3, value: f32, magnitude: f32) -> (Sight, f32) {
        let depth = self.view.depth(position);
        let scale = self.view.px_per_unit(depth);
        let sight = Sight {
            value,
            magnitude,
            n_dot_e: normal.dot(self.view.to_eye(position)),
            n_dot_l: normal.dot(self.light),
            ratio: scale * self.inverse_reference,
            z_over_a: (self.view.distance - depth) / self.view.radius,
        };
        (sight, scale)
    }

    /// How the view sees element `e`, and its scale in pixels an object unit.
    #[inline(always)]
    pub fn element(&self, elements: &Elements, e: usize) -> (Sight, f32) {
        self.sight(elements.position.at(e), elements.normal.at(e), elements.value[e], elements.magnitude[e])
    }
}

/// The factors of one style: the equations as they stand.
#[derive(Clone, Debug)]
pub struct PapersTone(Style);

impl PapersTone {
    /// The factors of a style.
    pub fn new(style: &Style) -> PapersTone {
        PapersTone(style.clone())
    }

    /// Which factors are on, in the order of [`FACTORS`].
    pub fn on(&self) -> [bool; 6] {
        let s = &self.0;
        [s.boundary, s.silhouette != 0.0, s.resolution != 0.0, s.lighting, s.distance != 0.0, s.interior]
    }

    /// The factors that elements have: of those of faces none that need a value or a gradient (2003, table 1).
    fn of(style: &Style, elements: &Elements) -> PapersTone {
        let mut tone = PapersTone::new(style);
        if elements.are_faces() {
            (tone.0.boundary, tone.0.silhouette, tone.0.interior) = (false, 0.0, false);
        }
        tone
    }

    /// The factors of an element, in the order of [`FACTORS`]; 1 where one is off.
    pub fn factors(&self, sight: &Sight) -> [f32; 6] {
        let (s, on) = (&self.0, self.on());
        let Sight { value, magnitude, n_dot_e, n_dot_l, ratio, z_over_a } = *sight;
        let mut factors = [
            boundary(value, magnitude, s.k_gc, s.k_gs, s.k_ge),
            silhouette(value, n_dot_e, s.k_sc, s.k_ss, s.k_se, s.silhouette_form),
            resolution(ratio, n_dot_e, s.k_re, s.k_nz),
            lighting(n_dot_l, s.k_le),
            distance(z_over_a, s.k_de),
            interior(magnitude, s.k_ie),
        ];
        for (factor, on) in factors.iter_mut().zip(on) {
            *factor = if on { *factor } else { 1.0 };
        }
        factors
    }

    /// The share of its most dots that an element asks for, 0…1: `tone` and the product of the factors, cut to 1.
    pub fn tone(&self, sight: &Sight) -> f32 {
        let tone = (self.0.tone * self.factors(sight).iter().product::<f32>()).min(1.0);
        tone + (1.0 - tone) * toon(sight.n_dot_e, self.0.toon)
    }

    /// The share of its most dots that a place of a surface without elements asks for, 0…1: of the factors only those
    /// that surfaces have (2003, table 1), resolution, lighting and distance.
    pub fn surface(&self, sight: &Sight) -> f32 {
        let [_, _, resolution, lighting, distance, _] = self.factors(sight);
        let tone = (self.0.tone * resolution * lighting * distance).min(1.0);
        tone + (1.0 - tone) * toon(sight.n_dot_e, self.0.toon)
    }

    /// Share of the largest dot that an element's dots have (eq 4), 0…1: `|G|` and, of the factors, resolution,
    /// distance and interior.
    pub fn size(&self, sight: &Sight) -> f32 {
        let [_, _, resolution, _, distance, interior] = self.factors(sight);
        (sight.magnitude * resolution * distance * interior).min(1.0)
    }
}

/// [`PapersTone`] for the elements of one stock, with its powers tabulated and what no view changes worked out.
#[derive(Clone, Debug)]
pub struct ElementTone {
    /// For each element: `tone · T_b · T_i`, and `v` if the silhouette factor is on.
    fixed: Vec<f32>,
    /// For each element: `|G| · T_i`.
    size: Vec<f32>,
    /// The silhouette factor without `v`, times `|n·E|^k_nz`, against `|n·E|`; then the latter alone.
    facing: [Table; 2],
    /// Against `n·L` from −1 to 1.
    lighting: Table,
    /// Against `z/a` from −1 to 1.
    distance: Table,
    k_re: f32,
    toon: f32,
}

impl ElementTone {
    /// The tone of a style on these elements.
    pub fn new(style: &Style, elements: &Elements) -> ElementTone {
        let tone = PapersTone::of(style, elements);
        let [_, by_silhouette, by_resolution, ..] = tone.on();
        let of = |e: usize| {
            let (value, magnitude) = (elements.value[e], elements.magnitude[e]);
            let [boundary, .., interior] = tone.factors(&Sight { value, magnitude, ..Sight::default() });
            let v = if by_silhouette { value } else { 1.0 };
            (style.tone * boundary * interior * v, magnitude * interior)
        };
        let (fixed, size) = (0..elements.len()).into_par_iter().map(of).unzip();
        let sight = |n_dot_e: f32, n_dot_l: f32, z_over_a: f32| {
            tone.factors(&Sight { value: 1.0, magnitude: 1.0, n_dot_e, n_dot_l, ratio: 1.0, z_over_a })
        };
        ElementTone {
            fixed,
            size,
            facing: [
                Table::new(|c| sight(c, 0.0, 0.0)[1] * sight(c, 0.0, 0.0)[2]),
                Table::new(|c| sight(c, 0.0, 0.0)[2]),
            ],
            lighting: Table::new(|u| sight(0.0, 2.0 * u - 1.0, 0.0)[3]),
            distance: Table::new(|u| sight(0.0, 0.0, 2.0 * u - 1.0)[4]),
            k_re: if by_resolution { style.k_re } else { 0.0 },
            toon: style.toon,
        }
    }

    /// [`PapersTone::tone`] and [`PapersTone::size`] of element `e`.
    #[inline(always)]
    pub fn at(&self, e: usize, sight: &Sight) -> (f32, f32) {
        let ratio = match self.k_re {
            0.0 => 1.0,
            2.0 => sight.ratio * sight.ratio,
            k => sight.ratio.powf(k),
        };
        let depth = ratio * self.distance.at(0.5 * sight.z_over_a + 0.5);
        let c = sight.n_dot_e.abs();
        let tone = self.fixed[e] * self.facing[0].at(c) * self.lighting.at(0.5 * sight.n_dot_l + 0.5) * depth;
        let tone = tone.min(1.0);
        let tone = tone + (1.0 - tone) * toon(c, self.toon);
        (tone, (self.size[e] * self.facing[1].at(c) * depth).min(1.0))
    }
}

/// Bins of a [`FactorHistogram`].
pub const HISTOGRAM_BINS: usize = 20;

/// How one factor is spread over the elements in a view.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorHistogram {
    /// One of [`FACTORS`], then `facing` (0 or 1) and `product`.
    pub name: &'static str,
    /// Whether the style uses it.
    pub on: bool,
    /// Elements in each twentieth of 0…1; what exceeds 1 stands in the last.
    pub bins: [u64; HISTOGRAM_BINS],
    /// Elements above 1, also in the last bin.
    pub above: u64,
    /// Mean over the elements.
    pub mean: f64,
}

/// What each factor does to the elements in a view: those of [`FACTORS`], then whether an element faces the eye enough
/// to be drawn, then the whole, which is the share of `n_max` that an element shows.
pub fn factor_histograms(
    elements: &Elements,
    style: &Style,
    view: &View,
    page: &Page,
    light: Vec3,
) -> Vec<FactorHistogram> {
    let tone = PapersTone::of(style, elements);
    let viewing = Viewing::new(view, page, light, elements.reference);
    let limit = front_limit(style);
    let both = style.two_sided == TwoSided::Yes && style.visibility != Visibility::Through;
    let [b, s, r, l, d, i] = tone.on();
    let on = [b, s, r, l, d, i, limit.is_some(), true];
    let names = FACTORS.into_iter().chain(["facing", "product"]);
    let mut histograms: Vec<FactorHistogram> = names
        .zip(on)
        .map(|(name, on)| FactorHistogram { name, on, bins: [0; HISTOGRAM_BINS], above: 0, mean: 0.0 })
        .collect();
    let mut carrying = 0u64;
    for e in (0..elements.len()).filter(|&e| elements.area[e] > 0.0) {
        let (sight, _) = viewing.element(elements, e);
        let cosine = if both { sight.n_dot_e.abs() } else { sight.n_dot_e };
        let facing = if limit.is_none_or(|limit| cosine >= limit) { 1.0 } else { 0.0 };
        let values = tone.factors(&sight).into_iter().chain([facing, facing * tone.tone(&sight)]);
        for (histogram, value) in histograms.iter_mut().zip(values) {
            let bin = (value * HISTOGRAM_BINS as f32) as usize;
            histogram.bins[bin.min(HISTOGRAM_BINS - 1)] += 1;
            histogram.above += u64::from(value > 1.0);
            histogram.mean += f64::from(value);
        }
        carrying += 1;
    }
    histograms.iter_mut().for_each(|h| h.mean /= carrying.max(1) as f64);
    histograms
}

#[cfg(test)]
mod tests;
