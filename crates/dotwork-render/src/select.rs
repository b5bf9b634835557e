//! Selection: for each stipple the tone of its place, the spacing that the tone asks for, and whether it is drawn.

use dotwork_drawing::{Dots, Page, Projection, View};
use dotwork_ink::tone::Viewing;
use dotwork_ink::{BakeMethod, Fade, Lit, Relevance, Stock, Style, Visibility};
use glam::Vec3;

use crate::depth::GRAZING;
use crate::hiding::Hidden;
use crate::plan::InkPlan;
use crate::relevance::reserve;

/// From [`GRAZING`] on dots come in over this much of the cosine, so that nothing pops at the rim: at half a degree a
/// frame a cosine moves by up to 0.009. The strip is a pixel wide on a page of a thousand; its lost ink is not seen.
const RIM: f32 = 0.03;

/// How far above its own surface a place is looked at through translucent matter, pixels.
pub(crate) const LIFT: f32 = 2.0;

/// Everything that the stipples of one object share in a frame.
pub(crate) struct Selector<'a> {
    pub stock: &'a Stock,
    pub plan: &'a InkPlan,
    pub view: &'a View,
    pub page: &'a Page,
    /// Unit vector towards the light.
    pub light: Vec3,
    /// What hides and thins its places.
    pub hiding: Hidden<'a>,
    /// Back faces are drawn.
    pub two_sided: bool,
    /// Facing away hides.
    pub facing: bool,
    /// Smallest cosine that is drawn.
    pub min_cosine: f32,
    /// What faces away is not drawn.
    pub one_sided: bool,
    /// Ink of the surface's own colours, if it makes a tone.
    pub own: &'a [f32],
    /// Its stipples are, or are to be, drawn by their edges.
    by_edges: bool,
    /// Added to every id: the object's number in the high bits.
    pub id_base: u64,
}

/// A place as projected.
#[derive(Clone, Copy, Default)]
struct Projected {
    x: f32,
    y: f32,
    depth: f32,
    /// Pixels for an object unit at its depth.
    scale: f32,
    /// Cosine between the facet and the eye; negative from behind.
    cosine: f32,
    /// 1 over the distance to the eye.
    inverse_distance: f32,
}

/// A stipple's place as the eye sees it, with the ink that it asks for.
#[derive(Clone, Copy, Default)]
pub(crate) struct Seen {
    at: Projected,
    /// Radius of a whole dot there, pixels.
    radius: f32,
    ink: f32,
}

/// The places of a block, as projected.
struct Block {
    x: [f32; BLOCK],
    y: [f32; BLOCK],
    depth: [f32; BLOCK],
    scale: [f32; BLOCK],
    cosine: [f32; BLOCK],
    inverse_distance: [f32; BLOCK],
}

impl Block {
    fn new() -> Block {
        let zero = [0.0; BLOCK];
        Block { x: zero, y: zero, depth: zero, scale: zero, cosine: zero, inverse_distance: zero }
    }

    #[inline(always)]
    fn at(&self, k: usize) -> Projected {
        Projected {
            x: self.x[k],
            y: self.y[k],
            depth: self.depth[k],
            scale: self.scale[k],
            cosine: self.cosine[k],
            inverse_distance: self.inverse_distance[k],
        }
    }
}

/// Stipples looked at together: few enough to stay in the first cache, enough to fill vector registers.
const BLOCK: usize = 128;

impl<'a> Selector<'a> {
    pub fn new(
        stock: &'a Stock,
        plan: &'a InkPlan,
        style: &Style,
        closed: bool,
        view: &'a View,
        page: &'a Page,
        light: Vec3,
        hiding: Hidden<'a>,
        id_base: u64,
    ) -> Selector<'a> {
        // Only the papers' lighting limits what is drawn through.
        let through = style.visibility == Visibility::Through;
        let front = plan.papers.as_ref().and_then(|papers| papers.front).filter(|_| through);
        Selector {
            stock,
            plan,
            view,
            page,
            light,
            hiding,
            two_sided: two_sided(style, closed),
            facing: !through,
            // Among the papers' factors, lighting draws the front only.
            one_sided: if through { front.is_some() } else { !two_sided(style, closed) },
            min_cosine: if through {
                front.map_or(GRAZING, |limit| GRAZING.max(limit))
            } else {
                GRAZING.max(style.front_angle.to_radians().cos())
            },
            own: if style.texture > 0.0 { &stock.own } else { &[] },
            by_edges: style.relevance == Relevance::Edges && style.bake == BakeMethod::Hierarchy,
            id_base,
        }
    }

    /// Projects a place. Free of branches, so that a loop over it becomes vector code.
    #[inline(always)]
    fn project(&self, position: Vec3, facet: Vec3) -> Projected {
        let from_eye = position - self.view.eye;
        let depth = -from_eye.dot(self.view.back);
        let (inverse_distance, cosine, scale) = match self.view.projection {
            Projection::Perspective { focal_px } => {
                let inverse = 1.0 / from_eye.dot(from_eye).sqrt();
                (inverse, -facet.dot(from_eye) * inverse, focal_px / depth)
            }
            Projection::Parallel { px_per_unit } => (1.0, facet.dot(self.view.back), px_per_unit),
        };
        Projected {
            x: self.view.cx + from_eye.dot(self.view.right) * scale,
            y: self.view.cy - from_eye.dot(self.view.up) * scale,
            depth,
            scale,
            cosine,
            inverse_distance,
        }
    }

    /// Projects the `count` stipples from `start` on.
    fn project_block(&self, start: usize, count: usize, block: &mut Block) {
        let part = |v: &'a [f32]| &v[start..start + count];
        let [x, y, z] =
            [&self.stock.position.x, &self.stock.position.y, &self.stock.position.z].map(|v| part(v));
        let [fx, fy, fz] = [&self.stock.facet.x, &self.stock.facet.y, &self.stock.facet.z].map(|v| part(v));
        let Block { x: px, y: py, depth, scale, cosine, inverse_distance } = block;
        for k in 0..count.min(BLOCK) {
            let p = self.project(Vec3::new(x[k], y[k], z[k]), Vec3::new(fx[k], fy[k], fz[k]));
            px[k] = p.x;
            py[k] = p.y;
            depth[k] = p.depth;
            scale[k] = p.scale;
            cosine[k] = p.cosine;
            inverse_distance[k] = p.inverse_distance;
        }
    }

    /// True if a place lies before the eye, faces it enough to be drawn, and lies on the page inside the margins.
    #[inline(always)]
    fn in_view(&self, p: &Projected) -> bool {
        let margin = self.page.margin_px;
        let (right, bottom) = (self.page.width as f32 - margin, self.page.height as f32 - margin);
        let facing = if self.one_sided { p.cosine } else { p.cosine.abs() };
        // Behind the eye, where voxels beyond the scene's sphere may lie, scales are negative.
        (facing >= self.min_cosine)
            & (p.scale > 0.0)
            & (p.x >= margin)
            & (p.y >= margin)
            & (p.x <= right)
            & (p.y <= bottom)
    }

    /// The ink (with the papers' factors, the share of a full count) and the dot radius of a place in view.
    #[inline(always)]
    fn light_up<const PAPERS: bool>(&self, i: usize, at: Projected) -> Seen {
        let view = self.view;
        let to_eye = match view.projection {
            Projection::Perspective { .. } => (view.eye - self.stock.position.at(i)) * at.inverse_distance,
            Projection::Parallel { .. } => view.back,
        };
        // Seen from behind in `through`, the papers' volumes keep their normals.
        let back = self.facing && at.cosine < 0.0;
        let normal = if back { -self.stock.normal.at(i) } else { self.stock.normal.at(i) };
        let n_dot_e = normal.dot(to_eye);
        let ink = if let (true, Some(papers)) = (PAPERS, &self.plan.papers) {
            let viewing = Viewing::new(view, self.page, self.light, None);
            papers.tone.surface(&viewing.sight(self.stock.position.at(i), normal, 1.0, 1.0).0)
        } else {
            self.plan.tone.ink(&Lit {
                n_dot_l: normal.dot(self.light),
                n_dot_e: if self.facing { n_dot_e.clamp(0.0, 1.0) } else { n_dot_e.abs() },
                z: 0.5 + 0.5 * (at.depth - view.distance) / view.radius,
                relative_depth: if view.is_parallel() { 1.0 } else { at.depth / view.distance },
                back,
                own: if self.own.is_empty() { None } else { Some(self.own[i]) },
            })
        };
        let ink = ink * self.hiding.before_focus(view, at.x, at.y, at.depth);
        let ink = match self.hiding.veil {
            None => ink,
            Some(veil) => {
                // From a little above the surface, or it would thin itself where it is steep.
                let lifted = self.stock.position.at(i) + normal * (LIFT / at.scale);
                let (x, y, depth) = view.project(lifted);
                ink * veil.transmittance(x, y, depth)
            }
        };
        let at = Projected { cosine: at.cosine.abs(), ..at };
        // The smooth normal shrinks dots without steps between facets. The facet bounds it: at the coarse outline of a
        // mesh dots would be too small to carry their ink, or stand out from a facet that is hardly seen.
        let radius = self.plan.radius(n_dot_e.clamp(at.cosine, 1.5 * at.cosine));
        Seen { at, radius, ink }
    }

    /// The place of stipple `i` and the ink it asks for; `None` if it faces away, lies off the page or asks for none.
    fn see(&self, i: usize) -> Option<Seen> {
        let at = self.project(self.stock.position.at(i), self.stock.facet.at(i));
        let seen = self.in_view(&at).then(|| match self.plan.papers {
            None => self.light_up::<false>(i, at),
            Some(_) => self.light_up::<true>(i, at),
        });
        seen.filter(|seen| seen.ink > 0.0)
    }

    /// Density in the bake that the place of stipple `i` asks for, per object unit squared as it was baked.
    pub fn demand(&self, i: usize, seen: &Seen) -> f32 {
        let (density, _) = match self.plan.papers {
            None => self.demand_of::<false>(seen),
            Some(_) => self.demand_of::<true>(seen),
        };
        self.stock.baked_density(i, density)
    }

    /// Density on the surface that a place asks for, per object unit squared, and the growth of its dots.
    #[inline(always)]
    fn demand_of<const PAPERS: bool>(&self, seen: &Seen) -> (f32, f32) {
        if let (true, Some(papers)) = (PAPERS, &self.plan.papers) {
            // A count belongs to the surface, whatever its distance and slant.
            let scale = self.view.px_per_unit(self.view.distance);
            return (seen.ink * papers.full * scale * scale, 1.0);
        }
        let (density_px, growth) = self.plan.demand(seen.ink, seen.at.cosine, seen.radius);
        (density_px * seen.at.scale * seen.at.scale, growth)
    }

    /// True if something nearer hides stipple `i`.
    #[inline(always)]
    fn hidden(&self, i: usize, at: &Projected) -> bool {
        self.hiding.depth.is_some_and(|d| {
            d.hides(self.view, at.x, at.y, at.depth, || {
                (self.stock.facet.at(i), self.stock.position.at(i) - self.view.eye)
            })
        })
    }

    /// The place of stipple `i` and the ink it asks for; `None` if it cannot be seen or asks for none.
    pub fn see_unhidden(&self, i: usize) -> Option<Seen> {
        self.see(i).filter(|seen| !self.hidden(i, &seen.at))
    }

    /// The spacing that the place of stipple `i` asks for, object units of the bake: infinite where it faces away, lies off
    /// the page by more than the distance between two stipples of the radius `around`, or is hidden.
    pub fn spacing_asked(&self, i: usize, around: f32) -> f32 {
        let at = self.project(self.stock.position.at(i), self.stock.facet.at(i));
        let margin = 2.0 * around * at.scale;
        let facing = if self.one_sided { at.cosine } else { at.cosine.abs() };
        let (right, bottom) = (self.page.width as f32 + margin, self.page.height as f32 + margin);
        let near =
            (at.scale > 0.0) & (at.x >= -margin) & (at.y >= -margin) & (at.x <= right) & (at.y <= bottom);
        // Round a stipple that faces away a little there may be some that do not.
        if !near || facing < self.min_cosine.min(0.0) - 0.2 {
            return f32::INFINITY;
        }
        let facing = Projected { cosine: at.cosine.abs().max(self.min_cosine).copysign(at.cosine), ..at };
        let seen = match self.plan.papers {
            None => self.light_up::<false>(i, facing),
            Some(_) => self.light_up::<true>(i, facing),
        };
        if seen.ink <= 0.0 || (self.in_view(&at) && self.hidden(i, &at)) {
            return f32::INFINITY;
        }
        self.plan.spacing_of(self.demand(i, &seen))
    }

    /// Density that the stock must have for what the place of stipple `i` asks for, per object unit squared.
    pub fn needed(&self, i: usize, seen: &Seen) -> f64 {
        let density = f64::from(self.demand(i, seen));
        if self.by_edges { density * f64::from(reserve(seen.at.cosine.abs())) } else { density }
    }

    /// Area of the page that the place of stipple `i` stands for, relative to other places of the stock.
    pub fn page_weight(&self, i: usize, seen: &Seen) -> f64 {
        f64::from(self.stock.baked_density(i, seen.at.cosine * seen.at.scale * seen.at.scale))
    }

    /// No place of this frame asks for more than this density in the bake (per object unit squared), so that no stipple
    /// that appears later need be looked at.
    pub fn densest(&self) -> f32 {
        self.densest_on_surface() * self.stock.most_stretched()
    }

    fn densest_on_surface(&self) -> f32 {
        if let Some(papers) = &self.plan.papers {
            let scale = self.view.px_per_unit(self.view.distance);
            return 1.01 * papers.full * scale * scale;
        }
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
    ///
    /// In passes over blocks, each of which leaves fewer: projecting all is vector code, lighting those in view and
    /// drawing those that are asked for have few branches to guess.
    pub fn select(&self, range: std::ops::Range<usize>, dots: &mut Dots) {
        match (&self.plan.papers, &self.plan.edges) {
            (None, None) => self.select_by::<false, false>(range, dots),
            (None, Some(_)) => self.select_by::<false, true>(range, dots),
            (Some(_), None) => self.select_by::<true, false>(range, dots),
            (Some(_), Some(_)) => self.select_by::<true, true>(range, dots),
        }
    }

    fn select_by<const PAPERS: bool, const EDGES: bool>(
        &self,
        range: std::ops::Range<usize>,
        dots: &mut Dots,
    ) {
        let mut block = Block::new();
        let mut asked = [(0usize, Seen::default(), 0.0f32, 0.0f32); BLOCK];
        let mut kept = [0usize; BLOCK];
        let end = range.end;
        for start in range.step_by(BLOCK) {
            let count = BLOCK.min(end - start);
            self.project_block(start, count, &mut block);
            let mut n = 0;
            for k in 0..count {
                kept[n] = k;
                n += usize::from(self.in_view(&block.at(k)));
            }
            if self.two_sided {
                // Most of what is seen from behind is hidden, and not worth a tone.
                let mut visible = 0;
                for j in 0..n {
                    let (k, at) = (kept[j], block.at(kept[j]));
                    kept[visible] = k;
                    visible += usize::from(at.cosine >= 0.0 || !self.hidden(start + k, &at));
                }
                n = visible;
            }
            let mut m = 0;
            for &k in &kept[..n] {
                let i = start + k;
                let seen = self.light_up::<PAPERS>(i, block.at(k));
                let (density, growth) = self.demand_of::<PAPERS>(&seen);
                let density = self.stock.baked_density(i, density);
                asked[m] = (i, seen, density, growth);
                m += usize::from(density >= self.plan.appears[i] && seen.ink > 0.0);
            }
            for (i, seen, density, growth) in &asked[..m] {
                self.draw::<EDGES>(*i, seen, *density, *growth, dots);
            }
        }
    }

    /// Length on the page of the shortest edge from stipple `i` to its relevant neighbours, pixels; without any, of its
    /// radius.
    fn shortest_edge(&self, i: usize, at: &Projected) -> f32 {
        let ends = self.stock.baked.neighbours[i].iter().filter(|&&n| n != u32::MAX);
        let length = |&n: &u32| {
            let end = self.project(self.stock.position.at(n as usize), self.stock.facet.at(n as usize));
            (end.x - at.x).hypot(end.y - at.y)
        };
        let least = ends.map(length).fold(f32::INFINITY, f32::min);
        if least.is_finite() { least } else { self.stock.baked.radius[i] * at.scale }
    }

    /// Draws stipple `i` if it has arrived and nothing hides it.
    #[inline(always)]
    fn draw<const EDGES: bool>(&self, i: usize, seen: &Seen, density: f32, growth: f32, dots: &mut Dots) {
        let arrival = self.plan.arrival;
        let spacing = self.plan.spacing.at(density);
        let arrived = match &self.plan.edges {
            Some(edges) if EDGES => {
                let threshold = spacing * seen.at.scale * edges.shortening(seen.at.cosine.abs());
                arrival.at(self.shortest_edge(i, &seen.at), threshold)
            }
            _ => arrival.at(self.stock.baked.radius[i], spacing),
        };
        if arrived == 0.0 || self.hidden(i, &seen.at) {
            return;
        }
        let rim = ((seen.at.cosine - GRAZING) * (1.0 / RIM)).min(1.0);
        // Off means off at the rim too: a pen draws one size of dot.
        let (size, strength) = match arrival.fade {
            Fade::Size => (arrived * rim, 1.0),
            Fade::Ink => (1.0, arrived * rim),
            Fade::Off => (1.0, 1.0),
        };
        let radius = seen.radius * growth * size;
        if radius * strength <= 0.0 {
            return;
        }
        dots.x.push(seen.at.x);
        dots.y.push(seen.at.y);
        dots.depth.push(seen.at.depth);
        dots.radius.push(radius);
        dots.size.push(radius / self.plan.dot_radius);
        dots.ink.push(strength);
        dots.id.push(self.id_base | self.stock.baked.id[i]);
        dots.stipple.push(i as u32);
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
