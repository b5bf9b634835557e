//! The lines of each object of a frame, kept while nothing that they depend on changes.

use dotwork_drawing::{Color, Image, Layer, Length, Page, Strokes};
use dotwork_ink::lines::{Criteria, SurfaceLines, VoxelCurves};
use dotwork_ink::{CurvesMethod, LineMethod, Role, Style, Visibility};
use dotwork_mesh::Mesh;

use super::image::ImageDrawer;
use super::voxels::CurveDrawer;
use super::{Outliner, line_width};
use crate::backend::{Frame, Subject};
use crate::hiding::Hiding;
use crate::same::Seen;

/// Draws outlines and curves. Memory is kept from frame to frame.
#[derive(Default)]
pub(crate) struct LineDrawer {
    outliner: Outliner,
    curves: CurveDrawer,
    images: ImageDrawer,
    /// The lines of each object.
    kept: Vec<Kept>,
}

/// The lines of an object.
#[derive(Default)]
struct Kept {
    of: Option<Of>,
    strokes: Strokes,
    /// What takes the place of strokes.
    image: Option<Image>,
}

/// What lines depend on.
struct Of {
    /// The version of what hides, and with it the view.
    hiding: u64,
    page: Page,
    mesh: Seen<Mesh>,
    lines: Seen<SurfaceLines>,
    curves: Option<Seen<VoxelCurves>>,
    way: Way,
}

/// How a style draws lines.
#[derive(PartialEq)]
struct Way {
    outlines: bool,
    creases: bool,
    width: Length,
    thin: f32,
    lines: LineMethod,
    /// Pictures have colours; strokes take that of their layer.
    color: Option<Color>,
    shortest: Length,
    method: CurvesMethod,
    criteria: Criteria,
    visibility: Visibility,
    role: Role,
    context_thin: f32,
}

/// The colour in which a style draws lines.
fn line_color(style: &Style) -> Color {
    style.outline_color.0.unwrap_or(style.color)
}

impl Way {
    fn of(style: &Style) -> Way {
        Way {
            outlines: style.outlines,
            creases: style.creases,
            width: style.outline,
            thin: style.outline_thin,
            lines: style.lines,
            color: (style.lines == LineMethod::Image).then(|| line_color(style)),
            shortest: style.outline_min,
            method: style.curves_method,
            criteria: Criteria::of(style),
            visibility: style.visibility,
            role: style.role,
            context_thin: style.context_thin,
        }
    }
}

impl Of {
    fn new(frame: &Frame, subject: &Subject, hiding: u64) -> Of {
        Of {
            hiding,
            page: *frame.page,
            mesh: Seen::of(subject.mesh),
            lines: Seen::of(subject.lines),
            curves: subject.curves.map(Seen::of),
            way: Way::of(subject.style),
        }
    }

    fn is(&self, frame: &Frame, subject: &Subject, hiding: u64) -> bool {
        let curves = match (&self.curves, subject.curves) {
            (Some(seen), Some(curves)) => seen.is(curves),
            (None, None) => true,
            _ => false,
        };
        curves
            && self.hiding == hiding
            && self.page == *frame.page
            && self.mesh.is(subject.mesh)
            && self.lines.is(subject.lines)
            && self.way == Way::of(subject.style)
    }
}

impl LineDrawer {
    /// Draws the lines of object `k`, unless they are there already.
    pub fn update(&mut self, frame: &Frame, k: usize, hiding: &Hiding, id_base: u64) {
        if self.kept.len() <= k {
            self.kept.resize_with(k + 1, Kept::default);
        }
        let subject = &frame.subjects[k];
        let kept = &mut self.kept[k];
        if subject.curves.is_none() && !subject.style.outlines {
            *kept = Kept::default();
            return;
        }
        let version = hiding.version();
        if !kept.of.as_ref().is_some_and(|of| of.is(frame, subject, version)) {
            kept.of = Some(Of::new(frame, subject, version));
            kept.strokes.clear();
            kept.image = None;
            let Frame { view, page, .. } = *frame;
            let hidden = hiding.of(subject.style);
            if let Some(curves) = subject.curves {
                self.curves.draw(curves, subject.style, (view, page), hidden, id_base, &mut kept.strokes);
            } else if subject.style.lines == LineMethod::Image {
                let line = (line_color(subject.style), line_width(subject.style, view, page));
                kept.image = self.images.draw(subject.mesh, line, (view, page), hidden);
            } else {
                let Subject { mesh, lines, style, .. } = *subject;
                self.outliner.draw(mesh, lines, style, view, page, hidden, id_base, &mut kept.strokes);
            }
        }
    }

    /// Puts the lines of object `k` into `layer`, which has no picture yet.
    pub fn append(&self, k: usize, layer: &mut Layer) {
        let Kept { strokes, image, .. } = &self.kept[k];
        layer.strokes.extend_from(strokes);
        layer.image.clone_from(image);
    }

    /// Forgets the lines of all but the first `count` objects.
    pub fn forget_after(&mut self, count: usize) {
        self.kept.truncate(count);
    }
}
