//! The artist draws scenes and remembers what one frame has in common with the next.

use std::sync::Arc;

use dotwork_drawing::{Color, Drawing, Layer, Page, View};
use dotwork_ink::lines::SurfaceLines;
use dotwork_ink::{Stock, Style};
use dotwork_mesh::Mesh;
use dotwork_render::{CpuBackend, Frame, InkPlan, Subject};
use glam::Vec3;

use crate::scene::{Object, Scene};

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
    stock: Arc<Stock>,
    style: Style,
    page: Page,
    plan: InkPlan,
    /// The borders and creases of the object's surface.
    mesh: Arc<Mesh>,
    lines: Arc<SurfaceLines>,
    /// How they were found.
    edges: Edges,
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
        let seen = see(scene, &self.plans);
        self.backend.frame(&seen.frame(), drawing);
        if let Ok(Some(strokes)) = scene.scale_bar_strokes() {
            let color = scene.objects.first().map_or(Color::BLACK, |o| o.style.color);
            drawing.layers.push(Layer { object: SCALE_BAR.into(), color, strokes, ..Layer::default() });
        }
    }

    /// The share of the objects' page area, 0…1, whose tone the stock is too sparse for. Call it after
    /// [`Artist::draw`] of the same scene.
    pub fn exhausted(&mut self, scene: &Scene) -> f64 {
        self.plan(scene);
        self.backend.exhausted(&see(scene, &self.plans).frame())
    }

    /// How many stipples object `k` needs for this view, judged from the stock it has.
    pub(crate) fn stipples_needed(&mut self, scene: &Scene, k: usize) -> usize {
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
            let old = self.plans.get_mut(count);
            let holds = old.as_ref().is_some_and(|p| {
                Arc::ptr_eq(&p.stock, stock) && p.style == object.style && p.page == scene.page
            });
            if !holds {
                let edges = Edges::of(object);
                let same = old.filter(|p| Arc::ptr_eq(&p.mesh, &object.mesh) && p.edges == edges);
                let planned = Planned {
                    mesh: object.mesh.clone(),
                    lines: match same {
                        Some(old) => std::mem::take(&mut old.lines),
                        None => Arc::new(edges.lines(&object.mesh)),
                    },
                    edges,
                    stock: stock.clone(),
                    style: object.style.clone(),
                    page: scene.page,
                    plan: InkPlan::new(stock, &object.style, &scene.page),
                };
                match self.plans.get_mut(count) {
                    Some(old) => *old = planned,
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
            stock: &planned.stock,
            style: &planned.style,
            plan: &planned.plan,
        })
        .collect();
    Seen { subjects, view, light, page: &scene.page }
}
