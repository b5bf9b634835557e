//! Lines in space put on the page: where they run there, how wide they are and what of them is seen.

use dotwork_drawing::{Page, View};
use glam::{Vec2, Vec3};

use super::FAINTEST;
use super::path::{STEP, Sample, fade, hermite, mark_corners, roundness};
use crate::hiding::Hidden;
use crate::veil::Veil;

/// The outline of a coarse mesh lies outside the contour by up to this share of an edge: an arc of 100° and its chord.
const SAGITTA: f32 = 0.2;

/// But no further than this is looked for it, pixels.
const FARTHEST: f32 = 12.0;

/// A place of a line in space.
pub(super) struct Place {
    pub point: Vec3,
    /// How far a smooth form would bulge over it.
    pub bulge: Vec3,
    /// The surface's normal; zero if the line has no outer side.
    pub normal: Vec3,
    /// Length of the mesh's edges there.
    pub edge: f32,
    /// Above 0 where the surface itself does not hide it.
    pub open: f32,
}

impl Place {
    /// A place on an edge.
    pub fn on_edge(point: Vec3) -> Place {
        Place { point, bulge: Vec3::ZERO, normal: Vec3::ZERO, edge: 0.0, open: 1.0 }
    }
}

/// The places of a line on the page.
#[derive(Default)]
pub(super) struct Stops {
    samples: Vec<Sample>,
    places: Vec<Place>,
    /// How round the way to the next one is.
    round: Vec<f32>,
}

/// What lines are drawn on.
pub(super) struct Sheet<'a> {
    pub view: &'a View,
    pub page: &'a Page,
    pub hidden: Hidden<'a>,
    /// Width of a line at the depth of the centre, pixels.
    pub width: f32,
}

impl Sheet<'_> {
    /// Replaces `line` by samples of a line in space, at most [`STEP`] apart.
    pub fn line(&self, places: impl Iterator<Item = Place>, stops: &mut Stops, line: &mut Vec<Sample>) {
        let Sheet { view, page, hidden, width } = *self;
        let Hidden { depth, veil, .. } = hidden;
        stops.samples.clear();
        stops.places.clear();
        for place in places {
            let Place { point, normal, edge, open, .. } = place;
            let (x, y, depth) = view.project(point);
            stops.samples.push(Sample {
                at: Vec2::new(x, y),
                depth,
                // A nearer line is a bolder one, within reason.
                width: width * if view.is_parallel() { 1.0 } else { (view.distance / depth).clamp(0.5, 2.0) },
                outwards: Vec2::new(normal.dot(view.right), -normal.dot(view.up)).normalize_or_zero(),
                reach: (SAGITTA * edge * view.px_per_unit(depth)).min(FARTHEST),
                visible: open > 0.0,
                corner: false,
                darkness: 1.0,
            });
            stops.places.push(place);
        }
        let Stops { samples, places, round } = stops;
        roundness(samples, round);
        let n = samples.len();
        let closed = n > 3 && samples[0].at == samples[n - 1].at;
        for i in 0..n {
            // As round as the flatter one of the ways that meet here.
            let before = if i > 0 {
                round[i - 1]
            } else if closed {
                round[n - 2]
            } else {
                1.0
            };
            let after = if i + 1 < n {
                round[i]
            } else if closed {
                round[0]
            } else {
                1.0
            };
            let bulge = places[i].bulge * before.min(after);
            if bulge != Vec3::ZERO {
                let (x, y, depth) = view.project(places[i].point + bulge);
                (samples[i].at, samples[i].depth) = (Vec2::new(x, y), depth);
            }
        }
        line.clear();
        for i in 0..n {
            let k = i.saturating_sub(1);
            let (here, before) = (samples[i], samples[k]);
            let (open, was_open) = (places[i].open, places[k].open);
            let round = round.get(k).copied().unwrap_or(1.0);
            let steps = ((here.at - before.at).length() / STEP).ceil().clamp(1.0, 4096.0) as u32;
            for s in 1..=steps {
                let t = s as f32 / steps as f32;
                let visible = was_open + (open - was_open) * t > 0.0;
                let at = hermite(before, here, round, t);
                // Along a line on the page, the inverse of the depth changes evenly in perspective.
                let inverse = 1.0 / before.depth + (1.0 / here.depth - 1.0 / before.depth) * t;
                let mixed = Sample::mix(before, here, t);
                let depth = if view.is_parallel() { mixed.depth } else { 1.0 / inverse };
                line.push(Sample { at, visible, depth, ..mixed });
            }
        }
        mark_corners(line);
        let margin = page.margin_px;
        let (right, bottom) = (page.width as f32 - margin, page.height as f32 - margin);
        if hidden.focus.is_some() {
            for p in line.iter_mut() {
                p.darkness = hidden.before_focus(view, p.at.x, p.at.y, p.depth);
            }
            fade(line);
        }
        for p in line {
            let on_page = p.at.x >= margin && p.at.y >= margin && p.at.x <= right && p.at.y <= bottom;
            // Lines do not thin: they end where little comes through.
            let veiled = |v: &Veil| {
                let at = p.at + p.outwards * 2.0;
                v.transmittance(at.x, at.y, p.depth) < FAINTEST
            };
            p.visible = p.visible
                && on_page
                && !veil.is_some_and(veiled)
                && !depth
                    .is_some_and(|d| d.hides_line(view, p.at.into(), p.depth, p.outwards.into(), p.reach));
        }
    }
}
