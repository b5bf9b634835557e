//! The CPU backend: the readable reference that every other backend is compared with.

use std::sync::Arc;

use dotwork_drawing::{Dots, Drawing, Page, View};
use dotwork_ink::lines::{SurfaceLines, VoxelCurves};
use dotwork_ink::{Stock, Style};
use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

use crate::elements::{Asked, Asking, ElementSelector, ask};
use crate::fill::fills;
use crate::hiding::Hiding;
use crate::layers::{Layers, Painter};
use crate::outline::LineDrawer;
use crate::plan::InkPlan;
use crate::select::Selector;

/// Stipples a chunk looks at: enough to be worth a task, few enough to share.
const CHUNK: usize = 4096;

/// Stipples that stand for the whole when a frame is judged: the stock's order makes any first part even.
const SAMPLE: usize = 16_384;

/// Stipples that are asked first whether a frame lacks any, and how many of them must be seen for their word to count.
const FEW_STIPPLES: usize = 4096;
const TELLING: usize = 256;

/// A smaller share of a picture than this may be too light.
const UNSEEN: f64 = 0.005;

/// Bits of an id that belong to the stipple; the object's number stands above.
const STIPPLE_BITS: u32 = 38;

/// One object of a frame. Mesh, lines and curves are shared: what was made from them is kept while they are the same.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its surface, which also hides.
    pub mesh: &'a Arc<Mesh>,
    /// The borders and creases of its surface, drawn with the outline.
    pub lines: &'a Arc<SurfaceLines>,
    /// The voxels of its silhouette curves, which take the place of its outline.
    pub curves: Option<&'a Arc<VoxelCurves>>,
    /// Its stipples.
    pub stock: &'a Stock,
    /// Its style.
    pub style: &'a Style,
    /// The tables made from stock, style and page.
    pub plan: &'a InkPlan,
}

/// What a frame looks at.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    /// The objects; at most 32,768.
    pub subjects: &'a [Subject<'a>],
    /// The view.
    pub view: &'a View,
    /// Unit vector towards the light, object space.
    pub light: Vec3,
    /// The page.
    pub page: &'a Page,
}

/// Draws frames on the CPU. What hides and the lines are kept while view, page and surfaces stay the same, so that a
/// frame in which only light or tone change costs its dots. Memory is kept from frame to frame: after the first frame of
/// a scene no list grows while the number of dots does not; what is left is the thread pool's own hand-over of work, and
/// what lines of sight cross in translucent bodies, which is gathered anew.
#[derive(Default)]
pub struct CpuBackend {
    hiding: Hiding,
    chunks: Vec<Dots>,
    painter: Painter,
    lines: LineDrawer,
    /// What each element of the object at work asks for.
    asked: Vec<Asked>,
}

impl CpuBackend {
    /// A backend with nothing drawn yet.
    pub fn new() -> CpuBackend {
        CpuBackend::default()
    }

    /// Draws a frame into `drawing`. Its layers become: one with a picture for each subject that is filled, from bottom to
    /// top; and above them, for each subject in turn: one; or one for each colour of its dots
    /// (see [`dotwork_ink::ColorTable::colors`]), and one for its lines if there are any and they have a colour of their
    /// own.
    pub fn frame(&mut self, frame: &Frame, drawing: &mut Drawing) {
        self.hiding.draw(frame);
        drawing.page = *frame.page;
        let CpuBackend { hiding, chunks, painter, lines, asked } = self;
        let mut layers = Layers::new(&mut drawing.layers);
        for (k, image) in fills(frame) {
            let subject = &frame.subjects[k];
            layers.add(subject, subject.style.color).image = Some(image);
        }
        for (k, subject) in frame.subjects.iter().enumerate() {
            let id_base = (k as u64) << STIPPLE_BITS;
            // Joining contours to chains is work for one thread: the dots keep the others busy.
            let (count, ()) = rayon::join(
                || select(frame, k, hiding, asked, chunks),
                || lines.update(frame, k, hiding, id_base),
            );
            match &subject.plan.colors {
                None => {
                    let dots = &mut layers.add(subject, subject.style.color).dots;
                    chunks[..count].iter().for_each(|chunk| dots.extend_from(chunk));
                }
                Some(table) => painter.paint(table, subject, frame, &chunks[..count], &mut layers),
            }
            lines.append(k, layers.for_lines(subject));
            layers.close_lines(subject);
        }
        layers.finish();
        lines.forget_after(frame.subjects.len());
    }

    /// The share of the page area covered by the frame's objects whose tone the stock is too sparse for, 0…1.
    ///
    /// Call it after [`CpuBackend::frame`] with the same frame.
    pub fn exhausted(&self, frame: &Frame) -> f64 {
        let (mut lacking, mut all) = (0.0, 0.0);
        for (k, subject) in frame.subjects.iter().enumerate() {
            // Lists of elements hold all that can be asked of them.
            if subject.plan.by_elements() || !subject.style.dots {
                continue;
            }
            let sample = self.lack(frame, k, SAMPLE);
            // Areas of objects compare by the area a stipple stands for.
            let each = subject.stock.baked.area / subject.stock.len().clamp(1, SAMPLE) as f64;
            lacking += sample.lacking * each;
            all += sample.all * each;
        }
        if all > 0.0 { lacking / all } else { 0.0 }
    }

    /// The number of stipples that a subject's stock needs for this frame, judged from the stock it has: all but a
    /// thousandth of its visible page area then finds the dots its tone asks for. A stock that has lists for elements
    /// needs what it has.
    pub fn stipples_needed(&mut self, frame: &Frame, subject: usize) -> Needed {
        if frame.subjects[subject].plan.by_elements() || !frame.subjects[subject].style.dots {
            return Needed { stipples: frame.subjects[subject].stock.len(), seen: 1.0 };
        }
        self.hiding.draw(frame);
        let selector = selector(frame, subject, &self.hiding);
        let Subject { stock, plan, .. } = frame.subjects[subject];
        let sample = stock.len().min(SAMPLE);
        let mut demands: Vec<(f64, f64)> = (0..sample)
            .into_par_iter()
            .filter_map(|i| Some((i, selector.see_unhidden(i)?)))
            .map(|(i, seen)| (selector.needed(i, &seen), selector.page_weight(i, &seen)))
            .collect();
        demands.sort_by(|a, b| b.0.total_cmp(&a.0));
        let all: f64 = demands.iter().map(|d| d.1).sum();
        let mut passed = 0.0;
        let densest = demands.iter().find(|d| {
            passed += d.1;
            passed >= 0.001 * all
        });
        // A stock's own last dots arrive over the width of the fade: that much is kept in hand.
        let late = f64::from(1.0 + plan.arrival.width);
        let stipples = densest.map_or(0, |d| (d.0 * stock.baked.area * late).ceil() as usize);
        Needed { stipples, seen: demands.len() as f64 / sample.max(1) as f64 }
    }
}

/// What a part of a stock, which stands for the whole, finds in a frame.
#[derive(Clone, Copy, Debug, Default)]
struct Sample {
    /// How many of its stipples are seen.
    seen: usize,
    /// The page area of these, and of those whose tone the stock is too sparse for.
    all: f64,
    lacking: f64,
}

/// What a frame needs of a stock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Needed {
    /// So many stipples on the whole of the surface.
    pub stipples: usize,
    /// The share of the surface, 0…1, on which some of them are seen.
    pub seen: f64,
}

impl CpuBackend {
    /// Whether a part of a subject that can be seen asks for more than its stock has.
    pub fn lacks(&mut self, frame: &Frame, subject: usize) -> bool {
        let Subject { plan, style, .. } = frame.subjects[subject];
        let by_stipples = style.dots && !plan.by_elements();
        if !by_stipples || plan.suffices(selector(frame, subject, &self.hiding).densest()) {
            return false;
        }
        // Most frames ask for what the stock was baked for: a few stipples say so. Where few of these are in view, as in
        // a close look, they say nothing.
        self.hiding.draw(frame);
        let Sample { seen, all, lacking } = self.lack(frame, subject, FEW_STIPPLES);
        seen < TELLING || lacking > UNSEEN * all
    }

    /// What the first stipples of a subject find; hiding is drawn.
    fn lack(&self, frame: &Frame, subject: usize, count: usize) -> Sample {
        let Subject { stock, plan, .. } = frame.subjects[subject];
        let selector = selector(frame, subject, &self.hiding);
        // The table ends where every stipple has arrived; 3 % less ink is not seen.
        let enough = plan.table.max_density() * 1.03;
        let part = (0..stock.len().min(count))
            .into_par_iter()
            .filter_map(|i| Some((i, selector.see_unhidden(i)?)))
            .map(|(i, seen)| {
                let weight = selector.page_weight(i, &seen);
                (if selector.needed(i, &seen) > enough { weight } else { 0.0 }, weight)
            })
            .collect::<Vec<_>>();
        let sum = |of: fn(&(f64, f64)) -> f64| part.iter().map(of).sum::<f64>();
        Sample { seen: part.len(), lacking: sum(|p| p.0), all: sum(|p| p.1) }
    }

    /// The spacing that the place of each of a subject's stipples asks for, object units of its bake; infinite where it is
    /// not seen. A place off the page by less than two distances of the radius `around` counts as seen.
    pub fn spacings(&mut self, frame: &Frame, subject: usize, around: f32) -> Vec<f32> {
        self.hiding.draw(frame);
        let selector = selector(frame, subject, &self.hiding);
        let stipples = 0..frame.subjects[subject].stock.len();
        stipples.into_par_iter().with_min_len(256).map(|i| selector.spacing_asked(i, around)).collect()
    }
}

/// What chooses the dots of object `k`.
fn selector<'a>(frame: &'a Frame, k: usize, hiding: &'a Hiding) -> Selector<'a> {
    let Subject { mesh, stock, style, plan, .. } = frame.subjects[k];
    let id_base = (k as u64) << STIPPLE_BITS;
    Selector::new(
        stock,
        plan,
        style,
        mesh.closed,
        frame.view,
        frame.page,
        frame.light,
        hiding.of(style),
        id_base,
    )
}

/// Draws the dots of object `k` into `chunks`, and returns how many it filled.
fn select(frame: &Frame, k: usize, hiding: &Hiding, asked: &mut Vec<Asked>, chunks: &mut Vec<Dots>) -> usize {
    let subject = &frame.subjects[k];
    if !subject.style.dots {
        return 0;
    }
    if subject.plan.by_elements() {
        return select_elements(frame, k, hiding, asked, chunks);
    }
    let selector = selector(frame, k, hiding);
    // Stipples that appear at densities no place can ask for need not be looked at.
    let densest = selector.densest();
    let end = subject.plan.appears.partition_point(|&d| d <= densest);
    in_chunks(end, chunks, |range, dots| selector.select(range, dots))
}

/// Draws an object whose elements have counts into `chunks`, and returns how many it filled.
fn select_elements(
    frame: &Frame,
    k: usize,
    hiding: &Hiding,
    asked: &mut Vec<Asked>,
    chunks: &mut Vec<Dots>,
) -> usize {
    let subject = &frame.subjects[k];
    let hidden = hiding.of(subject.style);
    let asking = Asking::new(subject, frame, &hidden);
    let least = ask(&asking, asked);
    let selector = ElementSelector {
        stock: subject.stock,
        plan: subject.plan,
        view: frame.view,
        page: frame.page,
        depth: hidden.depth,
        asking: &asking,
        asked,
        id_base: (k as u64) << STIPPLE_BITS,
    };
    // The radii fall: what lies beyond the least spacing is not asked for.
    let end = subject.stock.baked.radius.partition_point(|&r| r >= least);
    in_chunks(end, chunks, |range, dots| selector.select(range, dots))
}

/// Looks at the stipples up to `end` in chunks, side by side; returns the number of chunks.
fn in_chunks(
    end: usize,
    chunks: &mut Vec<Dots>,
    select: impl Fn(std::ops::Range<usize>, &mut Dots) + Sync,
) -> usize {
    let count = end.div_ceil(CHUNK);
    if chunks.len() < count {
        chunks.resize_with(count, Dots::default);
    }
    chunks[..count].par_iter_mut().enumerate().for_each(|(c, dots)| {
        dots.clear();
        select(c * CHUNK..((c + 1) * CHUNK).min(end), dots);
    });
    count
}

#[cfg(test)]
mod tests;
