//! The artist draws scenes and remembers what one frame has in common with the next.

use std::sync::Arc;

use dotwork_drawing::{Color, Drawing, Layer, Page, View};
use dotwork_ink::lines::SurfaceLines;
use dotwork_ink::{Elements, Stock, Style};
use dotwork_mesh::Mesh;
use dotwork_render::{CpuBackend, Frame, InkPlan, Needed, Subject};
use glam::Vec3;

use crate::endless::Added;
use crate::scene::{Object, Scene, Stipples};

/// Name of the layer with the scale bar.
pub const SCALE_BAR: &str = "scale bar";

/// Draws baked scenes, frame after frame.
#[derive(Default)]
pub struct Artist {
    backend: CpuBackend,
    plans: Vec<Planned>,
}

/// A plan and what it was made from.
struct Planned {
    /// The stock of this frame.
    stock: Arc<Stock>,
    style: Style,
    page: Page,
    /// Made from the stock's bake, which is the same in all poses.
    plan: Arc<InkPlan>,
    /// The surface in which borders and creases were found: the object's, or its reference if it moves.
    mesh: Arc<Mesh>,
    found: Arc<SurfaceLines>,
    /// How they were found.
    edges: Edges,
    /// They in this frame's pose.
    lines: Arc<SurfaceLines>,
    /// That pose.
    pose: Arc<Mesh>,
    /// What was added to the stock for this view.
    added: Added,
}

impl Planned {
    /// The plan of an object, with what still holds of an old one.
    fn new(object: &Object, stock: &Arc<Stock>, page: &Page, old: Option<&Planned>) -> Planned {
        let edges = Edges::of(object);
        let mesh = object.moving.as_ref().map_or(&object.mesh, |moving| moving.reference_mesh());
        let same_plan = old.filter(|p| {
            // The values of voxels are what a plan looks at, too.
            let of_surface = stock.elements.as_ref().is_none_or(Elements::are_faces);
            let same_bake = Arc::ptr_eq(&p.stock.baked, &stock.baked) && of_surface;
            (same_bake || Arc::ptr_eq(&p.stock, stock)) && p.style == object.style && p.page == *page
        });
        let same_lines = old.filter(|p| Arc::ptr_eq(&p.mesh, mesh) && p.edges == edges);
        let found = match same_lines {
            Some(old) => old.found.clone(),
            None => Arc::new(edges.lines(mesh)),
        };
        let lines = match same_lines {
            Some(old) if Arc::ptr_eq(&old.pose, &object.mesh) => old.lines.clone(),
            _ if Arc::ptr_eq(mesh, &object.mesh) => found.clone(),
            _ => found.posed(&object.mesh).map_or(found.clone(), Arc::new),
        };
        Planned {
            stock: stock.clone(),
            style: object.style.clone(),
            page: *page,
            plan: match same_plan {
                Some(old) => old.plan.clone(),
                None => Arc::new(InkPlan::new(stock, &object.style, page)),
            },
            mesh: mesh.clone(),
            found,
            edges,
            lines,
            pose: object.mesh.clone(),
            added: Added::default(),
        }
    }

    fn holds(&self, object: &Object, stock: &Arc<Stock>, page: &Page) -> bool {
        Arc::ptr_eq(&self.stock, stock)
            && Arc::ptr_eq(&self.pose, &object.mesh)
            && self.style == object.style
            && self.page == *page
    }
}

/// How the lines of an object's surface are found.
#[derive(Clone, Copy, PartialEq)]
enum Edges {
    /// From this angle on, degrees, edges are sharp.
    Steep(f32),
    /// In a volume with voxels of this size, with creases or without.
    Rounded(f32, bool),
}

impl Edges {
    fn of(object: &Object) -> Edges {
        match &object.volume {
            None => Edges::Steep(object.style.crease_min.min(object.style.crease_angle)),
            Some(volume) => {
                let voxel = volume.affine().linear.determinant().abs().cbrt() as f32;
                Edges::Rounded(voxel, object.style.outlines && object.style.creases)
            }
        }
    }

    fn lines(self, mesh: &Mesh) -> SurfaceLines {
        match self {
            Edges::Steep(angle) => SurfaceLines::find(mesh, angle),
            Edges::Rounded(voxel, creased) => SurfaceLines::in_volume(mesh, voxel, creased),
        }
    }
}

/// A scene as one frame sees it.
struct Seen<'a> {
    subjects: Vec<Subject<'a>>,
    view: View,
    light: Vec3,
    page: &'a Page,
}

impl Seen<'_> {
    fn frame(&self) -> Frame<'_> {
        Frame { subjects: &self.subjects, view: &self.view, light: self.light, page: self.page }
    }
}

impl Artist {
    /// An artist who has drawn nothing yet.
    pub fn new() -> Artist {
        Artist::default()
    }

    /// Draws a scene; objects that are not baked are left out.
    pub fn draw(&mut self, scene: &Scene) -> Drawing {
        let mut drawing = Drawing::new(scene.page, Color::WHITE);
        self.draw_into(scene, &mut drawing);
        drawing
    }

    /// Draws a scene into `drawing`, whose memory is used again.
    pub fn draw_into(&mut self, scene: &Scene, drawing: &mut Drawing) {
        // The paper is one for all: the first object's style knows it.
        drawing.paper = scene.objects.first().map_or(Color::WHITE, |o| o.style.paper);
        self.plan(scene);
        self.refine(scene);
        let seen = see(scene, &self.plans);
        self.backend.frame(&seen.frame(), drawing);
        if let Ok(Some(strokes)) = scene.scale_bar_strokes() {
            let color = scene.objects.first().map_or(Color::BLACK, |o| o.style.color);
            drawing.layers.push(Layer { object: SCALE_BAR.into(), color, strokes, ..Layer::default() });
        }
    }

    /// Adds stipples where the view asks for more than there are; but who asks for a number gets that number.
    fn refine(&mut self, scene: &Scene) {
        if scene.stipples != Stipples::Auto {
            self.plans.iter_mut().for_each(|planned| planned.added = Added::default());
            return;
        }
        let baked: Vec<&Object> = scene.objects.iter().filter(|o| o.stock.is_some()).collect();
        for (k, object) in baked.into_iter().enumerate() {
            let mut added = std::mem::take(&mut self.plans[k].added);
            let Planned { stock, plan, .. } = &self.plans[k];
            let (stock, plan) = (stock.clone(), plan.clone());
            let seen = see(scene, &self.plans);
            added.update(&mut self.backend, &seen.frame(), k, object, &stock, &plan);
            self.plans[k].added = added;
        }
    }

    /// The scene with the very stipples that it was last drawn with: those that were added for the view are in
    /// [`Object::shown`]. Call it after [`Artist::draw`] of the same scene.
    pub fn as_drawn(&self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        let baked = scene.objects.iter_mut().filter(|o| o.stock.is_some());
        for (object, planned) in baked.zip(&self.plans) {
            object.shown = planned.added.full.as_ref().map(|(stock, _)| stock.clone());
        }
        scene
    }

    /// The share of the objects' page area, 0…1, whose tone the stock is too sparse for. Call it after
    /// [`Artist::draw`] of the same scene.
    pub fn exhausted(&mut self, scene: &Scene) -> f64 {
        self.plan(scene);
        self.backend.exhausted(&see(scene, &self.plans).frame())
    }

    /// How many stipples object `k` needs for this view, judged from the stock it has.
    pub(crate) fn stipples_needed(&mut self, scene: &Scene, k: usize) -> Needed {
        self.plan(scene);
        let seen = see(scene, &self.plans);
        // Subjects are the baked objects in order.
        let subject = scene.objects[..k].iter().filter(|o| o.stock.is_some()).count();
        self.backend.stipples_needed(&seen.frame(), subject)
    }

    /// Makes the plans of all baked objects, keeping those that still hold.
    fn plan(&mut self, scene: &Scene) {
        let mut count = 0;
        for object in &scene.objects {
            let Some(stock) = &object.stock else { continue };
            if !self.plans.get(count).is_some_and(|p| p.holds(object, stock, &scene.page)) {
                let mut planned = Planned::new(object, stock, &scene.page, self.plans.get(count));
                match self.plans.get_mut(count) {
                    Some(old) => {
                        std::mem::swap(&mut planned.added, &mut old.added);
                        *old = planned;
                    }
                    None => self.plans.push(planned),
                }
            }
            count += 1;
        }
        self.plans.truncate(count);
    }
}

fn see<'a>(scene: &'a Scene, plans: &'a [Planned]) -> Seen<'a> {
    let view = scene.view();
    let light = scene.light.direction(&view, scene.camera.up);
    let subjects = scene
        .objects
        .iter()
        .filter(|o| o.stock.is_some())
        .zip(plans)
        .map(|(object, planned)| Subject {
            name: &object.name,
            mesh: &object.mesh,
            lines: &planned.lines,
            curves: object.curves.as_ref().filter(|_| object.draws_curves()),
            stock: planned.added.full.as_ref().map_or(&planned.stock, |full| &full.0),
            style: &planned.style,
            plan: planned.added.full.as_ref().map_or(&planned.plan, |full| &full.1),
        })
        .collect();
    Seen { subjects, view, light, page: &scene.page }
}
