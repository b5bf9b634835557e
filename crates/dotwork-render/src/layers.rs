//! From the dots of an object to the layers of its drawing: one for each colour.
//!
//! Colours follow from the places of the dots that are drawn (Lu et al. 2003, section 5.7; see
//! [`dotwork_ink::coloring`]), so that those that are not drawn cost nothing, and neither does a style of one colour.

use dotwork_drawing::{Color, Dots, Layer};
use dotwork_ink::{ColorTable, Visibility};
use glam::Vec3;
use rayon::prelude::*;

use crate::backend::{Frame, Subject};

/// The layers of a frame, filled one after another; those of the frame before are used again.
pub(crate) struct Layers<'a> {
    layers: &'a mut Vec<Layer>,
    used: usize,
}

impl<'a> Layers<'a> {
    pub fn new(layers: &'a mut Vec<Layer>) -> Layers<'a> {
        Layers { layers, used: 0 }
    }

    /// An empty layer above all others.
    pub fn add(&mut self, subject: &Subject, color: Color) -> &mut Layer {
        if self.layers.len() == self.used {
            self.layers.push(Layer::default());
        }
        self.used += 1;
        let layer = &mut self.layers[self.used - 1];
        if layer.object != subject.name {
            layer.object = subject.name.to_string();
        }
        (layer.color, layer.pen_mm, layer.image) = (color, subject.style.pen_mm(), None);
        layer.dots.clear();
        layer.strokes.clear();
        layer
    }

    /// The layer for the lines of `subject`, whose dots are drawn: theirs, if they have one, and it has the colour of the
    /// lines.
    pub fn for_lines(&mut self, subject: &Subject) -> &mut Layer {
        let ink = subject.style.color;
        let color = subject.style.outline_color.0.unwrap_or(ink);
        if subject.plan.colors.is_none() && color == ink {
            return &mut self.layers[self.used - 1];
        }
        self.add(subject, color)
    }

    /// Takes the topmost layer away if it is for lines alone and has none.
    pub fn close_lines(&mut self, subject: &Subject) {
        let ink = subject.style.color;
        let own = subject.plan.colors.is_some() || subject.style.outline_color.0.is_some_and(|c| c != ink);
        let top = &self.layers[self.used - 1];
        if own && top.strokes.is_empty() && top.image.is_none() {
            self.used -= 1;
        }
    }

    /// Forgets the layers of the frame before that this one did not need.
    pub fn finish(self) {
        self.layers.truncate(self.used);
    }
}

/// Gives dots their colours; memory is kept from frame to frame.
#[derive(Default)]
pub(crate) struct Painter {
    /// Entry of the colour table of each dot of each chunk.
    entries: Vec<Vec<u8>>,
}

impl Painter {
    /// Puts the dots of `subject`, in order, into a layer for each colour that they have, in the order of `table`.
    pub fn paint(
        &mut self,
        table: &ColorTable,
        subject: &Subject,
        frame: &Frame,
        chunks: &[Dots],
        layers: &mut Layers,
    ) {
        if self.entries.len() < chunks.len() {
            self.entries.resize_with(chunks.len(), Vec::new);
        }
        chunks.par_iter().zip(&mut self.entries).for_each(|(dots, entries)| {
            let entry = |(&stipple, &depth): (&u32, &f32)| {
                if table.is_own() {
                    return table.nearest(subject.stock.tint[stipple as usize]);
                }
                let (n_dot_l, z) = place(subject, frame, stipple as usize, depth);
                table.index(n_dot_l, z)
            };
            entries.clear();
            entries.extend(dots.stipple.iter().zip(&dots.depth).map(entry));
        });
        let entries = &self.entries[..chunks.len()];
        let mut counts = [0usize; ColorTable::MOST];
        for &entry in entries.iter().flatten() {
            counts[entry as usize] += 1;
        }
        // Where the layer of each colour is.
        let mut at = [0usize; ColorTable::MOST];
        let first = layers.used;
        for (k, &color) in table.colors().iter().enumerate().filter(|(k, _)| counts[*k] > 0) {
            at[k] = layers.used - first;
            reserve(&mut layers.add(subject, color).dots, counts[k]);
        }
        let to = &mut layers.layers[first..layers.used];
        for (dots, entries) in chunks.iter().zip(entries) {
            for (i, &entry) in entries.iter().enumerate() {
                push(&mut to[at[entry as usize]].dots, dots, i);
            }
        }
    }
}

/// The cosine between the light and the normal of a stipple that is drawn, on the side that is seen, and its depth, 0 at
/// the near and 1 at the far end of the bounding sphere.
#[inline(always)]
fn place(subject: &Subject, frame: &Frame, i: usize, depth: f32) -> (f32, f32) {
    let (stock, view) = (subject.stock, frame.view);
    let to_eye: Vec3 = if view.is_parallel() { view.back } else { view.eye - stock.position.at(i) };
    // What is seen through has one side.
    let back = subject.style.visibility != Visibility::Through && stock.facet.at(i).dot(to_eye) < 0.0;
    let n_dot_l = stock.normal.at(i).dot(frame.light);
    let z = 0.5 + 0.5 * (depth - view.distance) / view.radius;
    (if back { -n_dot_l } else { n_dot_l }, z)
}

fn reserve(dots: &mut Dots, more: usize) {
    for array in [&mut dots.x, &mut dots.y, &mut dots.depth, &mut dots.radius, &mut dots.size, &mut dots.ink]
    {
        array.reserve(more);
    }
    dots.id.reserve(more);
    dots.stipple.reserve(more);
}

#[inline(always)]
fn push(to: &mut Dots, from: &Dots, i: usize) {
    to.x.push(from.x[i]);
    to.y.push(from.y[i]);
    to.depth.push(from.depth[i]);
    to.radius.push(from.radius[i]);
    to.size.push(from.size[i]);
    to.ink.push(from.ink[i]);
    to.id.push(from.id[i]);
    to.stipple.push(from.stipple[i]);
}
