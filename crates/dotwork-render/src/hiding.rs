//! What hides what in a frame: opaque surfaces in depth buffers, translucent bodies in the veil.
//!
//! Objects of the role *context* hide themselves and each other, and nothing else. Where a *focus* lies behind them
//! their own ink is thinned, so that one looks through them at what the picture is about.
//!
//! While view, page and surfaces stay the same, so do the buffers: only the first of such frames draws them.

use dotwork_drawing::View;
use dotwork_ink::{Role, Style, Visibility};
use dotwork_mesh::Mesh;

use crate::backend::{Frame, Subject};
use crate::depth::DepthBuffer;
use crate::same::Seen;
use crate::select::two_sided;
use crate::veil::{Body, Veil};

/// The buffers of a frame; memory is kept from frame to frame.
#[derive(Default)]
pub(crate) struct Hiding {
    /// Opaque surfaces but contexts.
    depth: DepthBuffer,
    /// All opaque surfaces; drawn only where there are contexts.
    with_contexts: DepthBuffer,
    /// The surfaces of what the picture is about; drawn only where there are contexts.
    focus: DepthBuffer,
    veil: Veil,
    /// What the buffers show.
    shown: Option<Shown>,
    /// Changes whenever they do.
    version: u64,
}

/// What all that hides depends on.
struct Shown {
    view: View,
    size: [u32; 2],
    surfaces: Vec<Surface>,
}

/// A surface, and what its style says about hiding.
struct Surface {
    mesh: Seen<Mesh>,
    way: Way,
}

/// How a style makes a surface hide.
#[derive(PartialEq)]
struct Way {
    two_sided: bool,
    role: Role,
    visibility: Visibility,
    occlusion: f32,
}

impl Way {
    fn of(style: &Style, closed: bool) -> Way {
        let Style { role, visibility, occlusion, .. } = *style;
        Way { two_sided: two_sided(style, closed), role, visibility, occlusion }
    }
}

impl Shown {
    fn of(frame: &Frame) -> Shown {
        let surface = |subject: &Subject| Surface {
            mesh: Seen::of(subject.mesh),
            way: Way::of(subject.style, subject.mesh.closed),
        };
        Shown {
            view: *frame.view,
            size: [frame.page.width, frame.page.height],
            surfaces: frame.subjects.iter().map(surface).collect(),
        }
    }

    fn is(&self, frame: &Frame) -> bool {
        let same = |(surface, subject): (&Surface, &Subject)| {
            surface.mesh.is(subject.mesh) && surface.way == Way::of(subject.style, subject.mesh.closed)
        };
        self.view == *frame.view
            && self.size == [frame.page.width, frame.page.height]
            && self.surfaces.len() == frame.subjects.len()
            && self.surfaces.iter().zip(frame.subjects).all(same)
    }
}

/// What hides and thins the places of one object.
#[derive(Clone, Copy)]
pub(crate) struct Hidden<'a> {
    /// Opaque surfaces, unless nothing hides.
    pub depth: Option<&'a DepthBuffer>,
    /// Translucent bodies, if there are any.
    pub veil: Option<&'a Veil>,
    /// For a context: where the focus is, and the share of ink that it loses before it.
    pub focus: Option<(&'a DepthBuffer, f32)>,
}

impl Hiding {
    /// Draws what hides, unless it is there already.
    pub fn draw(&mut self, frame: &Frame) {
        if self.shown.as_ref().is_some_and(|shown| shown.is(frame)) {
            return;
        }
        self.shown = Some(Shown::of(frame));
        self.version += 1;
        let contexts = frame.subjects.iter().any(|s| s.style.role == Role::Context);
        let mut bodies = Vec::new();
        let buffers = [&mut self.depth, &mut self.with_contexts, &mut self.focus];
        for buffer in buffers.into_iter().take(if contexts { 3 } else { 1 }) {
            buffer.clear(frame.page.width, frame.page.height);
        }
        for subject in frame.subjects {
            let (mesh, style) = (subject.mesh, subject.style);
            let culled = mesh.closed && !two_sided(style, true);
            if contexts && style.role == Role::Focus {
                self.focus.draw(mesh, frame.view, culled);
            }
            if style.visibility != Visibility::Solid {
                continue;
            }
            let context = style.role == Role::Context;
            if style.occlusion < 1.0 {
                if !context {
                    let opacity = 8.0 * style.occlusion / (1.0 - style.occlusion) / frame.view.radius;
                    bodies.push(Body { mesh, opacity });
                }
                continue;
            }
            if !context {
                self.depth.draw(mesh, frame.view, culled);
            }
            if contexts {
                self.with_contexts.draw(mesh, frame.view, culled);
            }
        }
        self.veil.draw(&bodies, frame.view, frame.page.width, frame.page.height);
    }

    /// A number that stays the same as long as view, page size and all that hides do.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// What hides the places of an object that is drawn in `style`.
    pub fn of(&self, style: &Style) -> Hidden<'_> {
        let solid = style.visibility == Visibility::Solid;
        let context = style.role == Role::Context;
        let depth = if context { &self.with_contexts } else { &self.depth };
        Hidden {
            depth: solid.then_some(depth),
            veil: self.veil.thinning().filter(|_| solid),
            focus: (context && style.context_thin > 0.0).then_some((&self.focus, style.context_thin)),
        }
    }
}

impl Hidden<'_> {
    /// Whether any place is thinned.
    pub fn thins(&self) -> bool {
        self.veil.is_some() || self.focus.is_some()
    }

    /// The share of a place's ink that the focus behind it leaves; the place as projected.
    #[inline(always)]
    pub fn before_focus(&self, view: &View, x: f32, y: f32, depth: f32) -> f32 {
        match self.focus {
            None => 1.0,
            Some((focus, thin)) => 1.0 - thin * focus.covers_behind(view, x, y, depth),
        }
    }
}
