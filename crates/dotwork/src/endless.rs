//! Stocks without end: where a view asks for more stipples than were baked, they are made where it looks.

use std::collections::BTreeSet;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use dotwork_ink::bake::{Brick, Cell, Refinement};
use dotwork_ink::{BakeSettings, Baked, Stock};
use dotwork_mesh::Mesh;
use dotwork_render::{CpuBackend, Frame, InkPlan, Subject};
use glam::Vec3;

use crate::scene::Object;

/// Most stipples that are added for a view.
const MOST_ADDED: usize = 16_000_000;

/// How the stock of an object was baked, so that it can be continued, and how far it has been: shared by all clones of
/// the object.
#[derive(Clone)]
pub(crate) struct Endless {
    settings: BakeSettings,
    refinement: Arc<Mutex<Option<Arc<Refinement>>>>,
}

impl fmt::Debug for Endless {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Endless").field("settings", &self.settings).finish_non_exhaustive()
    }
}

impl Endless {
    /// A stock that was baked with these settings.
    pub fn new(regularity: f32, seed: u32) -> Endless {
        let settings = BakeSettings { stipples: 0, regularity, seed };
        Endless { settings, refinement: Arc::default() }
    }

    /// The refinement of an object's stock; `None` for a stock without stipples.
    fn refinement(&self, object: &Object, stock: &Stock) -> Option<Arc<Refinement>> {
        let known = || self.refinement.lock().unwrap_or_else(PoisonError::into_inner);
        let there = known().clone().filter(|r| r.continues(&stock.baked, &self.settings));
        if there.is_some() {
            return there;
        }
        let mesh = object.moving.as_ref().map_or(&object.mesh, |moving| moving.reference_mesh());
        // Not under the lock: another thread may make the same one meanwhile, which is no harm.
        let made = Arc::new(Refinement::new(mesh.clone(), stock, self.settings)?);
        *known() = Some(made.clone());
        Some(made)
    }
}

/// What is kept of an object from frame to frame.
#[derive(Default)]
pub(crate) struct Added {
    /// The plan of the stock as if it had no end.
    plan: Option<(Arc<InkPlan>, Arc<InkPlan>)>,
    /// What was shown last.
    shown: Option<Shown>,
    /// The stock with what was added for the frame, and its plan; `None`: nothing was.
    pub full: Option<(Arc<Stock>, Arc<InkPlan>)>,
}

/// What a stock was completed with: the bricks by stage, of which stock and in which pose.
struct Shown {
    cells: Vec<Vec<Cell>>,
    of: Arc<Stock>,
    pose: Arc<Mesh>,
}

impl Added {
    /// Adds what subject `k` of a frame lacks; `object` is what it shows, `stock` and `plan` what it has.
    pub fn update(
        &mut self,
        backend: &mut CpuBackend,
        frame: &Frame,
        k: usize,
        object: &Object,
        stock: &Arc<Stock>,
        plan: &Arc<InkPlan>,
    ) {
        let endless = object.endless.as_ref().filter(|_| backend.lacks(frame, k));
        let Some(refinement) = endless.and_then(|e| e.refinement(object, stock)) else {
            (self.shown, self.full) = (None, None);
            return;
        };
        let known = self.plan.take().filter(|(of, _)| Arc::ptr_eq(of, plan));
        let endless_plan = match known {
            Some((_, known)) => known,
            None => {
                let last = refinement.reach(*refinement.stages().end());
                let complete = refinement.complete();
                Arc::new(InkPlan::endless(stock, &object.style, frame.page, complete, last))
            }
        };
        self.plan = Some((plan.clone(), endless_plan.clone()));

        // From stage to stage: where do the stipples of one ask for those of the next?
        let stretch = stretch(object, stock);
        let mut cells: Vec<Vec<Cell>> = Vec::new();
        let mut found: Vec<Arc<Brick>> = Vec::new();
        let mut count = 0;
        let mut asked_by = |stock: &Stock, around: f32| {
            let mut subjects: Vec<Subject> = frame.subjects.to_vec();
            (subjects[k].stock, subjects[k].plan) = (stock, &endless_plan);
            let asked = backend.spacings(&Frame { subjects: &subjects, ..*frame }, k, around);
            let place = |i: usize| (asked[i], place(refinement.mesh(), &stock.baked, i));
            (0..stock.len()).filter(|&i| asked[i].is_finite()).map(place).collect::<Vec<_>>()
        };
        let by_stock = asked_by(stock, refinement.complete());
        let mut by_stage: Vec<(f32, Vec3)> = Vec::new();
        for (n, stage) in refinement.stages().enumerate() {
            let reach = refinement.reach(stage);
            // The stock may hold most of its last stage, and few of that are new: it speaks for two stages more.
            let stock_too = if n < 3 { &by_stock[..] } else { &[] };
            let asking = by_stage.iter().chain(stock_too).filter(|(spacing, _)| *spacing < reach);
            let wanted: BTreeSet<Cell> = asking.map(|&(_, place)| refinement.cell(stage, place)).collect();
            if wanted.is_empty() {
                break;
            }
            let wanted: Vec<Cell> = wanted.into_iter().collect();
            let bricks = refinement.bricks(stage, &wanted);
            cells.push(wanted);
            count += bricks.iter().map(|b| b.baked.len()).sum::<usize>();
            if count > MOST_ADDED {
                break;
            }
            by_stage = asked_by(&posed(gathered(&bricks), object, stretch.as_deref()), reach);
            found.extend(bricks);
        }
        let same = self.shown.as_ref().is_some_and(|shown| {
            shown.cells == cells && Arc::ptr_eq(&shown.of, stock) && Arc::ptr_eq(&shown.pose, &object.mesh)
        });
        if found.is_empty() {
            (self.shown, self.full) = (None, None);
        } else if !same || self.full.is_none() {
            let more = posed(in_order(gathered(&found)), object, stretch.as_deref());
            let plan = Arc::new(endless_plan.with(&more.baked.radius));
            self.full = Some((Arc::new(stock.with(&more)), plan));
            self.shown = Some(Shown { cells, of: stock.clone(), pose: object.mesh.clone() });
        }
    }
}

/// How many times as large each triangle is as in the pose of the bake, if that matters.
fn stretch(object: &Object, stock: &Stock) -> Option<Vec<f32>> {
    let moving = object.moving.as_ref().filter(|_| !stock.stretch.is_empty())?;
    Some(moving.stretch(&object.mesh))
}

/// Stipples on an object as it stands.
fn posed(baked: Baked, object: &Object, stretch: Option<&[f32]>) -> Stock {
    let stretch = stretch.map_or(Vec::new(), |s| baked.element.iter().map(|&e| s[e as usize]).collect());
    Stock { stretch, ..Stock::on_mesh(baked, &object.mesh) }
}

/// Where stipple `i` lies on the surface in the pose of the bake.
fn place(mesh: &Mesh, baked: &Baked, i: usize) -> Vec3 {
    let [a, b, c] = mesh.triangles[baked.element[i] as usize].map(|v| mesh.positions[v as usize]);
    let [v, w] = baked.weights[i];
    a + (b - a) * v + (c - a) * w
}

fn gathered(bricks: &[Arc<Brick>]) -> Baked {
    let mut all = Baked::default();
    for Brick { baked, .. } in bricks.iter().map(|b| &**b) {
        all.radius.extend_from_slice(&baked.radius);
        all.id.extend_from_slice(&baked.id);
        all.element.extend_from_slice(&baked.element);
        all.weights.extend_from_slice(&baked.weights);
        all.area = baked.area;
    }
    all
}

/// The stipples by falling radius, then by id.
fn in_order(baked: Baked) -> Baked {
    let mut order: Vec<u32> = (0..baked.len() as u32).collect();
    let key = |i: &u32| (!baked.radius[*i as usize].to_bits(), baked.id[*i as usize]);
    order.sort_unstable_by_key(key);
    Baked {
        radius: order.iter().map(|&i| baked.radius[i as usize]).collect(),
        id: order.iter().map(|&i| baked.id[i as usize]).collect(),
        element: order.iter().map(|&i| baked.element[i as usize]).collect(),
        weights: order.iter().map(|&i| baked.weights[i as usize]).collect(),
        area: baked.area,
        neighbours: Vec::new(),
    }
}
