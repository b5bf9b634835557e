//! From a document and a pose to one mesh in the space of the scene.
//!
//! Primitives of a node that share their vertices share them here too. Instances are copied, within a [`Budget`].

use std::collections::HashMap;
use std::rc::Rc;

use dotwork_drawing::Warnings;
use dotwork_drawing::color::linear_to_srgb;
use dotwork_mesh::RawMesh;
use glam::{DAffine3, DVec3};

use super::Document;
use super::budget::{Budget, LIST_CORNER, MOVED_VERTEX, PRIMITIVE, STRIP_CORNER, VERTEX};
use super::json::{Attributes, Primitive, Shape, Target};
use super::nodes::{Pose, missing};
use super::skin::{Skinning, joint_transforms};
use crate::error::ReadErrorKind;
use crate::gather::{AXES, Coordinates, Faces, check_vertex_count};

const WHITE: [u8; 4] = [255; 4];

/// Draws all meshes of the scene.
pub(super) fn draw(
    document: &Document,
    pose: &Pose,
    warnings: &mut Warnings,
) -> Result<RawMesh, ReadErrorKind> {
    let mut drawing = Drawing::default();
    for node in document.tree.drawn(&document.json, warnings)? {
        if let Some(mesh) = document.json.nodes[node as usize].mesh {
            drawing.node(document, pose, node, mesh as usize)?;
        }
    }
    let first = drawing.first_without_surface;
    warnings.counted("primitives of points or lines ignored", drawing.without_surface, first);
    warnings.counted("corners beyond the last whole triangle ignored", drawing.left_over, None);
    drawing.faces.into_mesh(Coordinates::Double(drawing.positions), drawing.colors, warnings)
}

#[derive(Default)]
struct Drawing {
    positions: Vec<[f64; 3]>,
    /// One for each position, or none so far.
    colors: Vec<[u8; 4]>,
    faces: Faces,
    without_surface: u64,
    first_without_surface: Option<String>,
    left_over: u64,
    /// Joints of the skins met so far.
    skins: HashMap<u32, Rc<[DAffine3]>>,
    budget: Budget,
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
            let key = (primitive.attributes, &*primitive.targets);
            let vertices = match placed.get(&key) {
                Some(&vertices) => vertices,
                None => {
                    let weights = pose.weights(json, node, index);
                    let vertices =
                        self.vertices(document, pose, node, position, primitive, weights, &fail)?;
                    check_finite(&self.positions[vertices.base as usize..], &fail)?;
                    placed.insert(key, vertices);
                    vertices
                }
            };
            self.triangles(document, primitive, mode, vertices, fail)?;
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
        let mut local = elements.floats::<3>();
        for (target, &weight) in primitive.targets.iter().zip(weights) {
            let Some(accessor) = target.position.filter(|_| weight != 0.0) else { continue };
            self.budget.charge(document, count, MOVED_VERTEX)?;
            let moves = document.elements(accessor, &[Shape::Vec3], Some(count))?.floats::<3>();
            for (position, by) in local.iter_mut().zip(&moves) {
                for k in 0..3 {
                    position[k] += weight * by[k];
                }
            }
        }
        // Before a transform spreads it over all axes.
        check_finite(&local, fail)?;
        let base = self.positions.len() as u32;
        let skinning = match document.json.nodes[node as usize].skin {
            Some(skin) => {
                let joints = match self.skins.get(&skin) {
                    Some(joints) => Rc::clone(joints),
                    None => {
                        let joints = joint_transforms(document, pose, skin, &mut self.budget)?;
                        self.skins.insert(skin, Rc::clone(&joints));
                        joints
                    }
                };
                Skinning::new(document, joints, &primitive.attributes, count)?
            }
            None => None,
        };
        let wide = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
        let mirrored = match skinning {
            Some(skinning) => {
                let place = |(v, p): (usize, &[f32; 3])| skinning.place(v, wide(p)).to_array();
                self.positions.extend(local.iter().enumerate().map(place));
                skinning.mirrors()
            }
            None => {
                let global = &pose.globals[node as usize];
                self.positions.extend(local.iter().map(|p| global.transform_point3(wide(p)).to_array()));
                global.matrix3.determinant() < 0.0
            }
        };
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
