//! From a document and a pose to one mesh in the space of the scene.
//!
//! Primitives of a node that share their vertices share them here too. Instances are copied, within a [`Budget`].

use std::collections::HashMap;

use dotwork_drawing::color::linear_to_srgb;
use dotwork_drawing::{Lens, Warnings};
use dotwork_mesh::RawMesh;
use glam::DVec3;

use super::budget::{Budget, LIST_CORNER, MOVED_VERTEX, PRIMITIVE, STRIP_CORNER, VERTEX};
use super::json::{Attributes, Primitive, Shape, Target};
use super::materials::Painter;
use super::nodes::{Local, Pose, missing, rest_weights};
use super::rig::{Part, PlacedCamera, Rig};
use super::skin::Skin;
use super::{Document, clips};
use crate::error::ReadErrorKind;
use crate::gather::{AXES, Coordinates, Faces, check_vertex_count};

const WHITE: [u8; 4] = [255; 4];

/// Draws all meshes of the scene at rest; with what moves them, if anything can.
pub(super) fn draw(
    document: &Document,
    warnings: &mut Warnings,
) -> Result<(RawMesh, Option<Rig>), ReadErrorKind> {
    let json = &document.json;
    let mut drawing = Drawing::default();
    let mut painter = Painter::new(document);
    // On an account of their own: a clip that is too long leaves the mesh to be drawn.
    let (clips, listed) = clips::read(document, &mut Budget::default(), warnings);
    drawing.moves = !clips.is_empty();
    drawing.skins.resize_with(json.skins.len(), || None);
    let pose = Pose::rest(json, &document.tree);
    let mut cameras = Vec::new();
    for node in document.tree.drawn(json, warnings)? {
        let found = &json.nodes[node as usize];
        if let Some(mesh) = found.mesh {
            drawing.node(document, &pose, node, mesh as usize, &mut painter, warnings)?;
        }
        cameras.extend(found.camera.and_then(|camera| lens(document, camera)).map(|lens| (node, lens)));
    }
    let first = drawing.first_without_surface;
    warnings.counted("primitives of points or lines ignored", drawing.without_surface, first);
    warnings.counted("corners beyond the last whole triangle ignored", drawing.left_over, None);
    let mut tracks = Vec::new();
    if drawing.moves {
        drawing.parts.iter().for_each(|part| part.tracks(&mut tracks));
    }
    let positions = drawing.positions.iter().map(|p| p.to_array()).collect();
    let mesh = drawing.faces.into_mesh(Coordinates::Double(positions), drawing.colors, warnings)?;
    let mesh = RawMesh { tracks, paint: painter.finish(), ..mesh };
    if clips.is_empty() && cameras.is_empty() {
        return Ok((mesh, None));
    }
    let rig = Rig {
        tree: document.tree.clone(),
        rest: json.nodes.iter().map(Local::of).collect(),
        skins: drawing.skins,
        parts: drawing.parts,
        clips,
        listed,
        camera_names: cameras.iter().map(|(_, (name, _))| name.clone()).collect(),
        cameras: cameras.iter().map(|&(node, (_, lens))| PlacedCamera { node, lens }).collect(),
        origin: DVec3::from_array(mesh.origin),
    };
    Ok((mesh, Some(rig)))
}

/// The name and the lens of a camera; `None` if it is not there, or sees nothing.
fn lens(document: &Document, camera: u32) -> Option<(String, Lens)> {
    let found = document.json.cameras.get(camera as usize)?;
    let name = match &found.name {
        Some(name) if !name.0.trim().is_empty() => name.0.to_string(),
        _ => camera.to_string(),
    };
    let lens = match (found.perspective, found.orthographic) {
        (Some(p), _) if p.yfov > 1e-3 && p.yfov < 3.1 => Lens::Perspective((0.5 * p.yfov).tan()),
        (None, Some(o)) if o.ymag.is_normal() => Lens::Parallel(o.ymag.abs()),
        _ => return None,
    };
    Some((name, lens))
}

#[derive(Default)]
struct Drawing {
    /// Places at rest.
    positions: Vec<DVec3>,
    parts: Vec<Part>,
    /// One for each position, or none so far.
    colors: Vec<[u8; 4]>,
    faces: Faces,
    without_surface: u64,
    first_without_surface: Option<String>,
    left_over: u64,
    /// The skins met so far.
    skins: Vec<Option<Skin>>,
    budget: Budget,
    /// Something is animated.
    moves: bool,
}

/// The vertices of a primitive in [`Drawing`].
#[derive(Clone, Copy)]
struct Vertices {
    base: u32,
    count: u32,
    /// Their transform mirrors.
    mirrored: bool,
}

impl Drawing {
    fn node(
        &mut self,
        document: &Document,
        pose: &Pose,
        node: u32,
        index: usize,
        painter: &mut Painter,
        warnings: &mut Warnings,
    ) -> Result<(), ReadErrorKind> {
        let json = &document.json;
        let Some(mesh) = json.meshes.get(index) else {
            return Err(missing("node", node as usize, "mesh", index as u32, json.meshes.len()));
        };
        let mut placed: HashMap<(Attributes, &[Target]), Vertices> = HashMap::new();
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            // Targets are compared with those of the primitives before.
            let key_length = size_of_val(&*primitive.targets) as u64;
            self.budget.charge(document, 1, PRIMITIVE + key_length)?;
            let fail =
                |reason: String| ReadErrorKind::at_item("mesh", index, format!("primitive {p}: {reason}"));
            let mode = primitive.mode.unwrap_or(TRIANGLES);
            if mode < TRIANGLES {
                self.without_surface += 1;
                self.first_without_surface.get_or_insert_with(|| format!("mesh {index}, primitive {p}"));
                continue;
            }
            if mode > FAN {
                return Err(fail(format!("{mode} is no mode")));
            }
            // Without positions there is nothing to draw; extensions may have meant something else.
            let Some(position) = primitive.attributes.position else { continue };
            // Where on a picture vertices lie does not part them.
            let attributes = Attributes { texcoord_0: None, texcoord_1: None, ..primitive.attributes };
            let key = (attributes, &*primitive.targets);
            let vertices = match placed.get(&key) {
                Some(&vertices) => vertices,
                None => {
                    let weights = rest_weights(json, node, index);
                    let vertices =
                        self.vertices(document, pose, node, position, primitive, weights, &fail)?;
                    let places: Vec<_> =
                        self.positions[vertices.base as usize..].iter().map(|p| p.to_array()).collect();
                    check_finite(&places, &fail)?;
                    placed.insert(key, vertices);
                    vertices
                }
            };
            let first = self.faces.triangles.len();
            self.triangles(document, primitive, mode, vertices, fail)?;
            let triangles = &self.faces.triangles[first..];
            let (base, count) = (vertices.base, vertices.count as usize);
            painter.paint(primitive, triangles, base, count, &mut self.budget, warnings)?;
        }
        Ok(())
    }

    /// Places the vertices of a primitive.
    fn vertices(
        &mut self,
        document: &Document,
        pose: &Pose,
        node: u32,
        position: u32,
        primitive: &Primitive,
        weights: &[f32],
        fail: &impl Fn(String) -> ReadErrorKind,
    ) -> Result<Vertices, ReadErrorKind> {
        let elements = document.elements(position, &[Shape::Vec3], None)?;
        let count = elements.count;
        self.budget.charge(document, count, VERTEX)?;
        check_vertex_count((self.positions.len() + count) as u64)?;
        let mut targets = Vec::with_capacity(primitive.targets.len());
        for (k, target) in primitive.targets.iter().enumerate() {
            let counts = self.moves || weights.get(k).is_some_and(|w| *w != 0.0);
            let Some(accessor) = target.position.filter(|_| counts) else {
                targets.push(Vec::new());
                continue;
            };
            self.budget.charge(document, count, MOVED_VERTEX)?;
            targets.push(document.elements(accessor, &[Shape::Vec3], Some(count))?.floats::<3>());
        }
        let mut influences = Vec::new();
        let skin = document.json.nodes[node as usize].skin.unwrap_or(u32::MAX);
        if skin != u32::MAX {
            let index = skin as usize;
            if self.skins.get(index).is_none_or(Option::is_none) {
                let nodes = document.json.nodes.len();
                let found = Skin::new(document, index, nodes, &mut self.budget)?;
                self.skins[index] = Some(found);
            }
            if let Some(found) = &self.skins[index] {
                influences = found.influences(document, &primitive.attributes, count, &mut self.budget)?;
            }
        }
        let weights = weights.to_vec();
        let part = Part { node, local: elements.floats::<3>(), targets, weights, skin, influences };
        // Before a transform spreads it over all axes.
        check_finite(part.morphed(pose).as_deref().unwrap_or(&part.local), fail)?;
        let base = self.positions.len() as u32;
        let mirrored = part.place(pose, &self.skins, DVec3::ZERO, &mut self.positions);
        self.parts.push(part);
        self.color(document, primitive.attributes.color, base as usize, count)?;
        Ok(Vertices { base, count: count as u32, mirrored })
    }

    fn color(
        &mut self,
        document: &Document,
        accessor: Option<u32>,
        base: usize,
        count: usize,
    ) -> Result<(), ReadErrorKind> {
        let Some(accessor) = accessor else {
            if !self.colors.is_empty() {
                self.colors.resize(base + count, WHITE);
            }
            return Ok(());
        };
        let linear = document.elements(accessor, &[Shape::Vec4, Shape::Vec3], Some(count))?.floats::<4>();
        self.colors.resize(base, WHITE);
        self.colors.extend(linear.iter().map(|&[r, g, b, a]| {
            let [r, g, b] = [r, g, b].map(linear_to_srgb);
            [r, g, b, (a.clamp(0.0, 1.0) * 255.0).round() as u8]
        }));
        Ok(())
    }

    /// Adds the triangles of a primitive.
    fn triangles(
        &mut self,
        document: &Document,
        primitive: &Primitive,
        mode: u32,
        vertices: Vertices,
        fail: impl Fn(String) -> ReadErrorKind,
    ) -> Result<(), ReadErrorKind> {
        let cost = if mode == TRIANGLES { LIST_CORNER } else { STRIP_CORNER };
        let mut corners: Vec<u32> = match primitive.indices {
            Some(accessor) => {
                let elements = document.elements(accessor, &[Shape::Scalar], None)?;
                self.budget.charge(document, elements.count, cost)?;
                elements.integers::<1>().into_iter().map(|[index]| index).collect()
            }
            None => {
                self.budget.charge(document, vertices.count as usize, cost)?;
                (0..vertices.count).collect()
            }
        };
        if let Some(index) = corners.iter().find(|&&index| index >= vertices.count) {
            return Err(fail(format!("index {index} is out of range ({} vertices)", vertices.count)));
        }
        // In range of 32 bits, since all vertices together are.
        corners.iter_mut().for_each(|index| *index += vertices.base);
        let first = self.faces.triangles.len();
        match mode {
            TRIANGLES => {
                let (triangles, rest) = corners.as_chunks::<3>();
                self.faces.triangles.extend_from_slice(triangles);
                self.faces.polygons += triangles.len();
                self.left_over += rest.len() as u64;
            }
            STRIP => self.faces.push_strip(&corners),
            _ => {
                let fan = corners.get(1..).unwrap_or_default().windows(2).map(|w| [corners[0], w[0], w[1]]);
                self.faces.triangles.extend(fan);
                self.faces.polygons += self.faces.triangles.len() - first;
            }
        }
        if vertices.mirrored {
            self.faces.triangles[first..].iter_mut().for_each(|t| t.swap(1, 2));
        }
        Ok(())
    }
}

/// Names the first coordinate that is not finite.
fn check_finite<T: Copy + Into<f64>>(
    positions: &[[T; 3]],
    fail: &impl Fn(String) -> ReadErrorKind,
) -> Result<(), ReadErrorKind> {
    let finite = |p: &[T; 3]| p.iter().all(|&c| c.into().is_finite());
    let Some(vertex) = positions.iter().position(|p| !finite(p)) else { return Ok(()) };
    let position = positions[vertex].map(Into::<f64>::into);
    let axis = position.iter().position(|c| !c.is_finite()).unwrap_or(0);
    Err(fail(format!("vertex {vertex}: {} is {}", AXES[axis], position[axis])))
}

/// Modes of primitives; lower ones are points and lines.
const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;
