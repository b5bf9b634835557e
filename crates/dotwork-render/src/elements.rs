//! Selection where elements have counts: each voxel is looked at once, its stipples follow.
//!
//! The papers' factors give every element a count (Lu et al. 2002, eq 2); the spacing that draws so many of its list is
//! found once for the element, and a stipple is drawn where its radius is at least that spacing, as everywhere. The
//! fraction of a dot is rounded, taken as a probability or drawn as a weaker dot (2003, section 5.2).

use dotwork_drawing::{Dots, Page, View};
use dotwork_ink::bake::{rank_of, spacing_of};
use dotwork_ink::tone::{Viewing, count, random_of, small};
use dotwork_ink::{Fade, Fraction, Stock, TwoSided, Visibility};
use glam::Vec3;
use rayon::prelude::*;

use crate::backend::{Frame, Subject};
use crate::depth::{DepthBuffer, GRAZING};
use crate::hiding::Hidden;
use crate::plan::InkPlan;

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

/// Works out what the elements of a subject ask for, thinned by what `hiding` knows; returns the least of their spacings.
///
/// # Panics
/// If the subject has no elements or was not planned for them.
pub(crate) fn ask(subject: &Subject, frame: &Frame, hiding: &Hidden, asked: &mut Vec<Asked>) -> f32 {
    let Subject { stock, style, plan, .. } = *subject;
    let (Some(elements), Some(papers)) = (&stock.elements, &plan.papers) else {
        unreachable!("elements are asked where there are some")
    };
    let tone = papers.elements.as_ref().expect("planned for elements");
    let viewing = Viewing::new(frame.view, frame.page, frame.light, elements.reference);
    // Dots that only arrive count by what has arrived of them.
    let share = plan.arrival.share();
    let both = style.two_sided == TwoSided::Yes && style.visibility != Visibility::Through;
    let front = match style.visibility {
        // What is nearly seen edge on cannot be compared with the surface before it.
        Visibility::Solid => papers.front.map(|limit| limit.max(GRAZING)),
        _ => papers.front,
    };
    let one = |e: usize| {
        let none = Asked { spacing: f32::INFINITY, count: 0.0, radius: 0.0 };
        let (sight, scale) = viewing.element(elements, e);
        let cosine = if both { sight.n_dot_e.abs() } else { sight.n_dot_e };
        let rim = front.map_or(1.0, |limit| ((cosine - limit) * (1.0 / RIM)).min(1.0));
        let area = elements.area[e];
        // Not so for what is no number. Voxels that lie beyond the surface of their feature may lie behind the eye.
        if !(rim > 0.0 && area > 0.0 && scale > 0.0) {
            return none;
        }
        let (share_drawn, size) = tone.at(e, &sight);
        let seen = if hiding.thins() {
            let raised =
                raised(elements.position.at(e), elements.normal.at(e), elements.reach, frame.view.eye);
            let (x, y, depth) = frame.view.project(raised);
            let through = hiding.veil.map_or(1.0, |veil| veil.transmittance(x, y, depth));
            through * hiding.before_focus(frame.view, x, y, depth)
        } else {
            1.0
        };
        let is_small = match papers.fraction {
            Fraction::Probability => small(area * scale * scale, papers.min_area_px),
            Fraction::Off | Fraction::Ink => 0.0,
        };
        let count = rim * count(elements.n_max, seen * share_drawn, is_small, random_of(e));
        if count <= 0.0 || count.is_nan() {
            return none;
        }
        let spacing = match papers.fraction {
            // Dot ⌈count⌉ is the last.
            Fraction::Ink => spacing_of(area, count.ceil()),
            Fraction::Off | Fraction::Probability => spacing_of(area, count / share),
        };
        let radius = plan.radius(sight.n_dot_e.abs()) * if papers.sized { size } else { 1.0 };
        Asked { spacing, count, radius }
    };
    (0..elements.len()).into_par_iter().with_min_len(1024).map(one).collect_into_vec(asked);
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
        let margin = self.page.margin_px;
        let (right, bottom) = (self.page.width as f32 - margin, self.page.height as f32 - margin);
        for i in range {
            let asked = self.asked[baked.element[i] as usize];
            // Most stipples end here.
            if baked.radius[i] < asked.spacing {
                continue;
            }
            let (size, strength) = if BY_INK {
                (1.0, (asked.count - rank_of(baked.id[i]) as f32).clamp(0.0, 1.0))
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
            let reach = self.stock.elements.as_ref().map_or(0.0, |elements| elements.reach);
            let (position, normal) = (self.stock.position.at(i), self.stock.facet.at(i));
            let raised = raised(position, normal, reach, self.view.eye);
            let (x, y, depth) = self.view.project(raised);
            buffer.hides(self.view, x, y, depth, || (normal, raised - self.view.eye))
        })
    }
}

#[cfg(test)]
mod tests;
