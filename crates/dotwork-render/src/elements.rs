//! Selection where elements have counts: each voxel is looked at once, its stipples follow; a face is looked at where its
//! stipples lie.
//!
//! The papers' factors give every element a count (Lu et al. 2002, eq 2); the spacing that draws so many of its list is
//! found, once for a voxel, and a stipple is drawn where its radius is at least that spacing, as everywhere. The fraction
//! of a dot is rounded, taken as a probability or drawn as a weaker dot (2003, section 5.2).

use dotwork_drawing::{Dots, Page, View};
use dotwork_ink::bake::spacing_of;
use dotwork_ink::tone::{ElementTone, Viewing, count, few, random_of, small};
use dotwork_ink::{Carrier, Elements, Fade, Fraction, Stock, TwoSided, Visibility};
use glam::Vec3;
use rayon::prelude::*;

use crate::backend::{Frame, Subject};
use crate::depth::{DepthBuffer, GRAZING};
use crate::hiding::Hidden;
use crate::plan::{InkPlan, Papers};
use crate::select::{LIFT, two_sided};

/// Beyond the smallest cosine that is drawn, counts rise over this much of it, so that nothing pops as elements turn.
const RIM: f32 = 0.03;

/// What an element asks for in a view.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Asked {
    /// Spacing of its stipples, object units; infinite where it asks for none.
    spacing: f32,
    /// Number of whole dots.
    count: f32,
    /// Radius of its dots, pixels.
    radius: f32,
}

/// How the elements of one object are asked.
pub(crate) struct Asking<'a> {
    elements: &'a Elements,
    papers: &'a Papers,
    tone: &'a ElementTone,
    plan: &'a InkPlan,
    viewing: Viewing<'a>,
    hiding: &'a Hidden<'a>,
    view: &'a View,
    /// The number of each face; empty for voxels.
    number: &'a [f32],
    /// Dots that only arrive count by what has arrived of them.
    share: f32,
    /// What is seen from behind is drawn too.
    both: bool,
    /// Smallest cosine that is drawn.
    front: Option<f32>,
}

impl<'a> Asking<'a> {
    /// # Panics
    /// If the subject has no elements or was not planned for them.
    pub fn new(subject: &'a Subject, frame: &'a Frame, hiding: &'a Hidden<'a>) -> Asking<'a> {
        let Subject { stock, style, plan, mesh, .. } = *subject;
        let (Some(elements), Some(papers)) = (&stock.elements, &plan.papers) else {
            unreachable!("elements are asked where there are some")
        };
        let through = style.visibility == Visibility::Through;
        let (number, both) = match &elements.carrier {
            Carrier::Voxels { .. } => (&[][..], style.two_sided == TwoSided::Yes),
            Carrier::Faces { number } => (&number[..], two_sided(style, mesh.closed)),
        };
        Asking {
            elements,
            papers,
            tone: papers.elements.as_ref().expect("planned for elements"),
            plan,
            viewing: Viewing::new(frame.view, frame.page, frame.light, elements.reference),
            hiding,
            view: frame.view,
            number,
            share: plan.arrival.share(),
            both: both && !through,
            front: match style.visibility {
                // What is nearly seen edge on cannot be compared with the surface before it.
                Visibility::Solid => papers.front.map(|limit| limit.max(GRAZING)),
                _ => papers.front,
            },
        }
    }

    /// What element `e` asks for.
    #[inline(always)]
    fn element(&self, e: usize) -> Asked {
        let normal = self.elements.normal.at(e);
        self.at(e, self.elements.position.at(e), normal, normal, 1.0)
    }

    /// What face `e` asks for at the place of a stipple: its tone is that of the place, so that large faces shade
    /// smoothly.
    #[inline(always)]
    fn stipple(&self, stock: &Stock, i: usize) -> Asked {
        let position = stock.position.at(i);
        let (mut normal, mut facet) = (stock.normal.at(i), stock.facet.at(i));
        if self.both && facet.dot(self.view.to_eye(position)) < 0.0 {
            (normal, facet) = (-normal, -facet);
        }
        let stretch = stock.baked_density(i, 1.0);
        self.at(stock.baked.element[i] as usize, position, normal, facet, stretch)
    }

    /// What element `e` asks for at a place with the normals `normal`, for tone, and `facet`, which must face the eye; it
    /// is `stretch` times as large as when it was baked.
    #[inline(always)]
    fn at(&self, e: usize, position: Vec3, normal: Vec3, facet: Vec3, stretch: f32) -> Asked {
        let Asking { elements, papers, tone, plan, hiding, .. } = *self;
        let none = Asked { spacing: f32::INFINITY, count: 0.0, radius: 0.0 };
        let (sight, scale) = self.viewing.sight(position, normal, elements.value[e], elements.magnitude[e]);
        let faced =
            if self.number.is_empty() { sight.n_dot_e } else { facet.dot(self.view.to_eye(position)) };
        let cosine = if self.both { faced.abs() } else { faced };
        let rim = self.front.map_or(1.0, |limit| ((cosine - limit) * (1.0 / RIM)).min(1.0));
        let area = elements.area[e];
        // Not so for what is no number. Voxels that lie beyond the surface of their feature may lie behind the eye.
        if !(rim > 0.0 && area > 0.0 && scale > 0.0) {
            return none;
        }
        let (share_drawn, size) = tone.at(e, &sight);
        let seen = if hiding.thins() {
            // From a little above its own surface, or a face would thin itself where it is steep.
            let reach = if self.number.is_empty() { elements.reach } else { LIFT / scale };
            let raised = raised(position, normal, reach, self.view.eye);
            let (x, y, depth) = self.view.project(raised);
            let through = hiding.veil.map_or(1.0, |veil| veil.transmittance(x, y, depth));
            through * hiding.before_focus(self.view, x, y, depth)
        } else {
            1.0
        };
        let by_chance = papers.fraction == Fraction::Probability;
        let is_small = if by_chance { small(area * scale * scale, papers.min_area_px) } else { 0.0 };
        let (n_max, share_drawn) = (stretch * elements.n_max_of(e), seen * share_drawn);
        let (count, drawn) = match self.number.get(e) {
            None => {
                let count = rim * count(n_max, share_drawn, is_small, random_of(e));
                (count, count)
            }
            // Radii hold the whole number already.
            Some(&number) => {
                let asked = rim * n_max * share_drawn;
                let weight = if by_chance { is_small.max(few(asked)) } else { 0.0 };
                (asked, count(asked, 1.0, weight - 1.0, number))
            }
        };
        if count <= 0.0 || count.is_nan() {
            return none;
        }
        let number = self.number.get(e).copied().unwrap_or(0.0);
        let drawn = match papers.fraction {
            // Dot ⌈count⌉ is the last.
            Fraction::Ink => count.ceil() - number,
            Fraction::Off | Fraction::Probability => drawn / self.share,
        };
        if drawn <= 0.0 {
            return none;
        }
        let spacing = spacing_of(area, drawn);
        let c = if self.number.is_empty() {
            sight.n_dot_e.abs()
        } else {
            // As on any surface: the facet bounds what the smooth normal makes of a dot.
            sight.n_dot_e.max(cosine.abs()).min(1.5 * cosine.abs())
        };
        let radius = plan.radius(c) * if papers.sized { size } else { 1.0 };
        Asked { spacing, count, radius }
    }
}

/// Works out what the elements of a subject ask for, thinned by what is known of what hides; returns the least of their
/// spacings. Faces are asked where their stipples lie, and not here.
pub(crate) fn ask(asking: &Asking, asked: &mut Vec<Asked>) -> f32 {
    asked.clear();
    if !asking.number.is_empty() {
        return 0.0;
    }
    let count = asking.elements.len();
    (0..count).into_par_iter().with_min_len(1024).map(|e| asking.element(e)).collect_into_vec(asked);
    // Positive floats are ordered as their bits, and so is infinity.
    f32::from_bits(asked.par_iter().map(|a| a.spacing.to_bits()).min().unwrap_or(f32::INFINITY.to_bits()))
}

/// Where a place is looked at through other surfaces: elements and their stipples lie off the surface that hides, so it
/// is raised along the normal, towards the eye, by as much as they may.
#[inline(always)]
fn raised(position: Vec3, normal: Vec3, reach: f32, eye: Vec3) -> Vec3 {
    position + normal * reach.copysign(normal.dot(eye - position))
}

/// Everything that the stipples of one object share in a frame.
pub(crate) struct ElementSelector<'a> {
    pub stock: &'a Stock,
    pub plan: &'a InkPlan,
    pub view: &'a View,
    pub page: &'a Page,
    pub depth: Option<&'a DepthBuffer>,
    pub asking: &'a Asking<'a>,
    /// What each element asks for; empty for faces.
    pub asked: &'a [Asked],
    /// Added to every id: the object's number in the high bits.
    pub id_base: u64,
}

impl ElementSelector<'_> {
    /// Draws the stipples of `range` into `dots`.
    pub fn select(&self, range: std::ops::Range<usize>, dots: &mut Dots) {
        match self.plan.papers.as_ref().map(|papers| papers.fraction) {
            Some(Fraction::Ink) => self.select_by::<true>(range, dots),
            _ => self.select_by::<false>(range, dots),
        }
    }

    fn select_by<const BY_INK: bool>(&self, range: std::ops::Range<usize>, dots: &mut Dots) {
        let (baked, arrival) = (&self.stock.baked, self.plan.arrival);
        let (faces, rank_mask) = (!self.asking.number.is_empty(), self.asking.elements.rank_mask());
        let margin = self.page.margin_px;
        let (right, bottom) = (self.page.width as f32 - margin, self.page.height as f32 - margin);
        for i in range {
            let asked = if faces {
                self.asking.stipple(self.stock, i)
            } else {
                self.asked[baked.element[i] as usize]
            };
            // Most stipples end here.
            if baked.radius[i] < asked.spacing {
                continue;
            }
            let (size, strength) = if BY_INK {
                (1.0, (asked.count - (baked.id[i] & rank_mask) as f32).clamp(0.0, 1.0))
            } else {
                let arrived = arrival.at(baked.radius[i], asked.spacing);
                match arrival.fade {
                    Fade::Size => (arrived, 1.0),
                    Fade::Ink | Fade::Off => (1.0, arrived),
                }
            };
            let radius = asked.radius * size;
            if radius * strength <= 0.0 {
                continue;
            }
            let (x, y, depth) = self.view.project(self.stock.position.at(i));
            let before = depth > 0.0 || self.view.is_parallel();
            let on_page = before & (x >= margin) & (y >= margin) & (x <= right) & (y <= bottom);
            if !on_page || self.hidden(i) {
                continue;
            }
            dots.x.push(x);
            dots.y.push(y);
            dots.depth.push(depth);
            dots.radius.push(radius);
            dots.size.push(radius / self.plan.dot_radius);
            dots.ink.push(strength);
            dots.id.push(self.id_base | baked.id[i]);
            dots.stipple.push(i as u32);
        }
    }

    /// True if something nearer hides stipple `i`.
    #[inline(always)]
    fn hidden(&self, i: usize) -> bool {
        self.depth.is_some_and(|buffer| {
            let reach = self.asking.elements.reach;
            let (position, normal) = (self.stock.position.at(i), self.stock.facet.at(i));
            let raised = raised(position, normal, reach, self.view.eye);
            let (x, y, depth) = self.view.project(raised);
            buffer.hides(self.view, x, y, depth, || (normal, raised - self.view.eye))
        })
    }
}

#[cfg(test)]
mod face_tests;
#[cfg(test)]
mod tests;
