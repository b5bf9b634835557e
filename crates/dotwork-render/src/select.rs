//! Selection: for each stipple the tone of its place, the spacing that the tone asks for, and whether it is drawn.

use dotwork_drawing::{Dots, Page, Projection, View};
use dotwork_ink::{Fade, Lit, Stock, Style, Visibility};
use glam::Vec3;

use crate::depth::DepthBuffer;
use crate::plan::InkPlan;

/// Below this cosine no dots are drawn: the outline carries the rim.
pub(crate) const GRAZING: f32 = 0.05;

/// Everything that the stipples of one object share in a frame.
pub(crate) struct Selector<'a> {
    pub stock: &'a Stock,
    pub plan: &'a InkPlan,
    pub view: &'a View,
    pub page: &'a Page,
    /// Unit vector towards the light.
    pub light: Vec3,
    pub depth: Option<&'a DepthBuffer>,
    /// Back faces are drawn.
    pub two_sided: bool,
    /// Facing away hides.
    pub facing: bool,
    /// Smallest cosine that is drawn.
    pub min_cosine: f32,
    /// Added to every id: the object's number in the high bits.
    pub id_base: u64,
}

/// A stipple's place as the eye sees it.
pub(crate) struct Seen {
    x: f32,
    y: f32,
    depth: f32,
    /// Pixels for an object unit at its depth.
    scale: f32,
    /// Cosine between the facet and the eye.
    cosine: f32,
    /// Facet normal, towards the eye.
    facet: Vec3,
    from_eye: Vec3,
    /// Radius of a whole dot there, pixels.
    radius: f32,
    ink: f32,
}

impl<'a> Selector<'a> {
    pub fn new(
        stock: &'a Stock,
        plan: &'a InkPlan,
        style: &Style,
        closed: bool,
        view: &'a View,
        page: &'a Page,
        light: Vec3,
        depth: &'a DepthBuffer,
        id_base: u64,
    ) -> Selector<'a> {
        Selector {
            stock,
            plan,
            view,
            page,
            light,
            depth: (style.visibility == Visibility::Solid).then_some(depth),
            two_sided: two_sided(style, closed),
            facing: style.visibility != Visibility::Through,
            min_cosine: GRAZING.max(style.front_angle.to_radians().cos()),
            id_base,
        }
    }

    /// The place of stipple `i` and the ink it asks for; `None` if it faces away, lies off the page or asks for none.
    #[inline(always)]
    pub fn see(&self, i: usize) -> Option<Seen> {
        let view = self.view;
        let p = self.stock.position[i];
        let from_eye = p - view.eye;
        let depth = -from_eye.dot(view.back);
        let to_eye = match view.projection {
            Projection::Perspective { .. } => from_eye * -from_eye.length_recip(),
            Projection::Parallel { .. } => view.back,
        };
        let mut facet = self.stock.facet[i];
        let mut cosine = facet.dot(to_eye);
        let back = cosine < 0.0;
        if back {
            if self.facing && !self.two_sided {
                return None;
            }
            (facet, cosine) = (-facet, -cosine);
        }
        if cosine < if self.facing { self.min_cosine } else { GRAZING } {
            return None;
        }
        let scale = view.px_per_unit(depth);
        let x = view.cx + from_eye.dot(view.right) * scale;
        let y = view.cy - from_eye.dot(view.up) * scale;
        let margin = self.page.margin_px;
        let (width, height) = (self.page.width as f32, self.page.height as f32);
        if !(x >= margin && y >= margin && x <= width - margin && y <= height - margin) {
            return None;
        }
        let mut normal = self.stock.normal[i];
        // Seen from behind in `through`, the papers' volumes keep their normals.
        if back && self.facing {
            normal = -normal;
        }
        let n_dot_e = normal.dot(to_eye);
        let ink = self.plan.tone.ink(&Lit {
            n_dot_l: normal.dot(self.light),
            n_dot_e: if self.facing { n_dot_e.clamp(0.0, 1.0) } else { n_dot_e.abs() },
            z: 0.5 + 0.5 * (depth - view.distance) / view.radius,
            relative_depth: if view.is_parallel() { 1.0 } else { depth / view.distance },
            back: back && self.facing,
        });
        if ink <= 0.0 {
            return None;
        }
        // The smooth normal shrinks dots without steps between facets. The facet bounds it: at the coarse outline of a
        // mesh dots would be too small to carry their ink, or stand out from a facet that is hardly seen.
        let radius = self.plan.radius(n_dot_e.clamp(cosine, 3.0 * cosine));
        Some(Seen { x, y, depth, scale, cosine, facet, from_eye, radius, ink })
    }

    /// Density on the surface that a place asks for, per object unit squared, and the growth of its dots.
    #[inline(always)]
    pub fn demand(&self, seen: &Seen) -> (f32, f32) {
        let (density_px, growth) = self.plan.demand(seen.ink, seen.cosine, seen.radius);
        (density_px * seen.scale * seen.scale, growth)
    }

    /// True if something nearer hides the place.
    #[inline(always)]
    pub fn hidden(&self, seen: &Seen) -> bool {
        self.depth.is_some_and(|d| d.hides(self.view, seen.x, seen.y, seen.depth, seen.facet, seen.from_eye))
    }

    /// Area of the page that the place stands for, relative to other places of the stock.
    pub fn page_weight(&self, seen: &Seen) -> f64 {
        f64::from(seen.cosine * seen.scale * seen.scale)
    }

    /// No place of this frame asks for more than this density (per object unit squared), so that no stipple that
    /// appears later need be looked at.
    pub fn densest(&self) -> f32 {
        let nearest = (self.view.distance - self.view.radius).max(f32::MIN_POSITIVE);
        let scale = self.view.px_per_unit(nearest);
        // Demand is largest where the cosine is: radius² falls no faster than c (foreshorten ≤ ½) or at grazing.
        let steps = 64;
        let most = (0..=steps)
            .map(|k| {
                let c = GRAZING + (1.0 - GRAZING) * k as f32 / steps as f32;
                self.plan.demand(1.0, c, self.plan.radius(c)).0
            })
            .fold(0.0f32, f32::max);
        1.01 * most * scale * scale
    }

    /// Draws the stipples of `range` into `dots`.
    pub fn select(&self, range: std::ops::Range<usize>, dots: &mut Dots) {
        let arrival = self.plan.arrival;
        let full = self.plan.dot_radius;
        for i in range {
            let Some(seen) = self.see(i) else { continue };
            let (density, growth) = self.demand(&seen);
            if density < self.plan.appears[i] {
                continue;
            }
            let spacing = self.plan.table.spacing(f64::from(density));
            let arrived = arrival.at(self.stock.baked.radius[i], spacing);
            if arrived == 0.0 || self.hidden(&seen) {
                continue;
            }
            let (size, strength) = if arrival.fade == Fade::Ink { (1.0, arrived) } else { (arrived, 1.0) };
            let radius = seen.radius * growth * size;
            dots.x.push(seen.x);
            dots.y.push(seen.y);
            dots.depth.push(seen.depth);
            dots.radius.push(radius);
            dots.size.push(radius / full);
            dots.ink.push(strength);
            dots.id.push(self.id_base | self.stock.baked.id[i]);
            dots.stipple.push(i as u32);
        }
    }
}

/// Whether a style draws the back faces of a surface.
pub(crate) fn two_sided(style: &Style, closed: bool) -> bool {
    match style.two_sided {
        dotwork_ink::TwoSided::Auto => !closed,
        dotwork_ink::TwoSided::Yes => true,
        dotwork_ink::TwoSided::No => false,
    }
}
