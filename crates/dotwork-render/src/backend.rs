//! The CPU backend: the readable reference that every other backend is compared with.

use dotwork_drawing::{Dots, Drawing, Layer, Page, View};
use dotwork_ink::{Stock, Style, Visibility};
use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

use crate::depth::DepthBuffer;
use crate::elements::{Asked, ElementSelector, ask};
use crate::outline::Outliner;
use crate::plan::InkPlan;
use crate::select::{Selector, two_sided};
use crate::veil::{Body, Veil};

/// Stipples a chunk looks at: enough to be worth a task, few enough to share.
const CHUNK: usize = 4096;

/// Stipples that stand for the whole when a frame is judged: the stock's order makes any first part even.
const SAMPLE: usize = 16_384;

/// Bits of an id that belong to the stipple; the object's number stands above.
const STIPPLE_BITS: u32 = 38;

/// One object of a frame.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its surface, which also hides.
    pub mesh: &'a Mesh,
    /// The borders of its surface, drawn with the outline; see [`Mesh::borders`].
    pub borders: &'a [Vec<u32>],
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

/// Draws frames on the CPU. Memory is kept from frame to frame: after the first frame of a scene no list grows while
/// the number of dots does not; what is left is the thread pool's own hand-over of work.
#[derive(Default)]
pub struct CpuBackend {
    depth: DepthBuffer,
    chunks: Vec<Dots>,
    outliner: Outliner,
    veil: Veil,
    /// What each element of the object at work asks for.
    asked: Vec<Asked>,
}

impl CpuBackend {
    /// A backend with nothing drawn yet.
    pub fn new() -> CpuBackend {
        CpuBackend::default()
    }

    /// Draws a frame into `drawing`, whose layers become one for each subject.
    pub fn frame(&mut self, frame: &Frame, drawing: &mut Drawing) {
        self.prepass(frame);
        drawing.page = *frame.page;
        drawing.layers.truncate(frame.subjects.len());
        for (k, subject) in frame.subjects.iter().enumerate() {
            let mut chunks = std::mem::take(&mut self.chunks);
            let count = match subject.plan.by_elements() {
                true => self.select_elements(frame, k, &mut chunks),
                false => {
                    let selector = self.selector(frame, k);
                    // Stipples that appear at densities no place can ask for need not be looked at.
                    let densest = selector.densest();
                    let end = subject.plan.appears.partition_point(|&d| d <= densest);
                    in_chunks(end, &mut chunks, |range, dots| selector.select(range, dots))
                }
            };
            if drawing.layers.len() <= k {
                drawing.layers.push(Layer {
                    object: subject.name.to_string(),
                    color: subject.style.color,
                    ..Layer::default()
                });
            }
            let layer = &mut drawing.layers[k];
            if layer.object != subject.name {
                layer.object = subject.name.to_string();
            }
            layer.color = subject.style.color;
            layer.dots.clear();
            chunks[..count].iter().for_each(|dots| layer.dots.extend_from(dots));
            self.chunks = chunks;
            layer.strokes.clear();
            if subject.style.outlines {
                let depth = (subject.style.visibility == Visibility::Solid).then_some(&self.depth);
                let veil = depth.and(self.veil.thinning());
                let id_base = (k as u64) << STIPPLE_BITS;
                let Frame { view, page, .. } = *frame;
                self.outliner.draw(
                    subject.mesh,
                    subject.borders,
                    subject.style,
                    view,
                    page,
                    depth,
                    veil,
                    id_base,
                    &mut layer.strokes,
                );
            }
        }
    }

    /// Draws an object whose elements have counts into `chunks`, and returns how many it filled.
    fn select_elements(&mut self, frame: &Frame, k: usize, chunks: &mut Vec<Dots>) -> usize {
        let subject = &frame.subjects[k];
        let least = ask(subject, frame, &mut self.asked);
        let solid = subject.style.visibility == Visibility::Solid;
        let selector = ElementSelector {
            stock: subject.stock,
            plan: subject.plan,
            view: frame.view,
            page: frame.page,
            depth: solid.then_some(&self.depth),
            asked: &self.asked,
            id_base: (k as u64) << STIPPLE_BITS,
        };
        // The radii fall: what lies beyond the least spacing is not asked for.
        let end = subject.stock.baked.radius.partition_point(|&r| r >= least);
        in_chunks(end, chunks, |range, dots| selector.select(range, dots))
    }

    /// The share of the page area covered by the frame's objects whose tone the stock is too sparse for, 0…1.
    ///
    /// Call it after [`CpuBackend::frame`] with the same frame.
    pub fn exhausted(&self, frame: &Frame) -> f64 {
        let (mut lacking, mut all) = (0.0, 0.0);
        for (k, subject) in frame.subjects.iter().enumerate() {
            // Lists of elements hold all that can be asked of them.
            if subject.plan.by_elements() {
                continue;
            }
            let selector = self.selector(frame, k);
            // The table ends where every stipple has arrived; 3 % less ink is not seen.
            let enough = subject.plan.table.max_density() * 1.03;
            let part = (0..subject.stock.len().min(SAMPLE))
                .into_par_iter()
                .filter_map(|i| selector.see_unhidden(i))
                .map(|seen| {
                    let weight = selector.page_weight(&seen);
                    (if f64::from(selector.demand(&seen).0) > enough { weight } else { 0.0 }, weight)
                })
                .collect::<Vec<_>>();
            // Areas of objects compare by the area a stipple stands for.
            let each = subject.stock.baked.area / subject.stock.len().clamp(1, SAMPLE) as f64;
            lacking += part.iter().map(|p| p.0).sum::<f64>() * each;
            all += part.iter().map(|p| p.1).sum::<f64>() * each;
        }
        if all > 0.0 { lacking / all } else { 0.0 }
    }

    /// The number of stipples that a subject's stock needs for this frame, judged from the stock it has: all but a
    /// thousandth of its visible page area then finds the dots its tone asks for. A stock that has lists for elements
    /// needs what it has.
    pub fn stipples_needed(&mut self, frame: &Frame, subject: usize) -> usize {
        if frame.subjects[subject].plan.by_elements() {
            return frame.subjects[subject].stock.len();
        }
        self.prepass(frame);
        let selector = self.selector(frame, subject);
        let Subject { stock, plan, .. } = frame.subjects[subject];
        let mut demands: Vec<(f64, f64)> = (0..stock.len().min(SAMPLE))
            .into_par_iter()
            .filter_map(|i| selector.see_unhidden(i))
            .map(|seen| (f64::from(selector.demand(&seen).0), selector.page_weight(&seen)))
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
        densest.map_or(0, |d| (d.0 * stock.baked.area * late).ceil() as usize)
    }

    /// Draws what hides: opaque surfaces into the depth buffer, translucent bodies into the veil.
    fn prepass(&mut self, frame: &Frame) {
        self.depth.clear(frame.page.width, frame.page.height);
        let mut bodies = Vec::new();
        for subject in frame.subjects.iter().filter(|s| s.style.visibility == Visibility::Solid) {
            let (mesh, occlusion) = (subject.mesh, subject.style.occlusion);
            if occlusion < 1.0 {
                let opacity = 8.0 * occlusion / (1.0 - occlusion) / frame.view.radius;
                bodies.push(Body { mesh, opacity });
            } else {
                let culled = mesh.closed && !two_sided(subject.style, true);
                self.depth.draw(mesh, frame.view, culled);
            }
        }
        self.veil.draw(&bodies, frame.view, frame.page.width, frame.page.height);
    }

    fn selector<'a>(&'a self, frame: &'a Frame, k: usize) -> Selector<'a> {
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
            &self.depth,
            &self.veil,
            id_base,
        )
    }
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
