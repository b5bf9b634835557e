//! Skins: vertices that follow joints.
//!
//! A vertex goes where its joints take it, `Σ wᵢ · globalᵢ · inverseBindᵢ · v`, in the space of the scene; where the node
//! with the mesh stands does not matter.

use glam::{DAffine3, DMat4, DVec3};

use super::Document;
use super::budget::{Budget, INFLUENCES, JOINT, MATRIX};
use super::json::{Attributes, Shape};
use super::nodes::missing;
use crate::error::ReadErrorKind;

/// Four joints and their weights for each vertex.
#[derive(Debug)]
pub(super) struct Influences {
    pub(super) joints: Vec<[u32; 4]>,
    pub(super) weights: Vec<[f32; 4]>,
}

/// A skin: the nodes that are its joints.
#[derive(Debug)]
pub(super) struct Skin {
    joints: Vec<u32>,
    /// From the space of the vertices to that of each joint; empty: they are the same.
    inverse_binds: Vec<DAffine3>,
}

impl Skin {
    /// The skin of that number, checked.
    pub(super) fn new(
        document: &Document,
        index: usize,
        nodes: usize,
        budget: &mut Budget,
    ) -> Result<Skin, ReadErrorKind> {
        let Some(skin) = document.json.skins.get(index) else {
            let reason = format!("does not exist ({} skins)", document.json.skins.len());
            return Err(ReadErrorKind::at_item("skin", index, reason));
        };
        let count = skin.joints.len();
        budget.charge(document, count, JOINT)?;
        if let Some(&joint) = skin.joints.iter().find(|&&joint| joint as usize >= nodes) {
            return Err(missing("skin", index, "node", joint, nodes));
        }
        let mut inverse_binds = Vec::new();
        if let Some(accessor) = skin.inverse_bind_matrices {
            let elements = document.elements(accessor, &[Shape::Mat4], None)?;
            budget.charge(document, elements.count, MATRIX)?;
            let matrices = elements.floats::<16>();
            if matrices.len() < count {
                let reason = format!("{} inverse bind matrices for {count} joints", matrices.len());
                return Err(ReadErrorKind::at_item("skin", index, reason));
            }
            let affine = |m: &[f32; 16]| DAffine3::from_mat4(DMat4::from_cols_array(&m.map(f64::from)));
            inverse_binds = matrices[..count].iter().map(affine).collect();
        }
        Ok(Skin { joints: skin.joints.clone(), inverse_binds })
    }

    /// From the space of skinned vertices to that of the scene, for each joint.
    pub(super) fn transforms(&self, globals: &[DAffine3]) -> Vec<DAffine3> {
        let bind = |k: usize| self.inverse_binds.get(k).copied().unwrap_or(DAffine3::IDENTITY);
        self.joints.iter().enumerate().map(|(k, &joint)| globals[joint as usize] * bind(k)).collect()
    }

    /// The influences on the vertices of a primitive; empty if it names no joints.
    pub(super) fn influences(
        &self,
        document: &Document,
        attributes: &Attributes,
        vertices: usize,
        budget: &mut Budget,
    ) -> Result<Vec<Influences>, ReadErrorKind> {
        let sets = [(attributes.joints_0, attributes.weights_0), (attributes.joints_1, attributes.weights_1)];
        let mut influences = Vec::new();
        for (joint, weight) in sets {
            let (Some(joint), Some(weight)) = (joint, weight) else { continue };
            budget.charge(document, vertices, INFLUENCES)?;
            let joints = document.elements(joint, &[Shape::Vec4], Some(vertices))?.integers::<4>();
            let weights = document.elements(weight, &[Shape::Vec4], Some(vertices))?.floats::<4>();
            let count = self.joints.len();
            let wrong = |(j, w): (&u32, &f32)| *w != 0.0 && *j as usize >= count;
            let first = joints.iter().zip(&weights).position(|(j, w)| j.iter().zip(w).any(wrong));
            if let Some(v) = first {
                let reason = format!("vertex {v}: a joint out of range ({count} joints)");
                return Err(ReadErrorKind::at_item("accessor", joint as usize, reason));
            }
            influences.push(Influences { joints, weights });
        }
        Ok(influences)
    }
}

/// Where the joints take a vertex; `influences` are not empty.
#[inline]
pub(super) fn place(
    influences: &[Influences],
    transforms: &[DAffine3],
    vertex: usize,
    position: DVec3,
) -> DVec3 {
    let mut sum = DVec3::ZERO;
    let mut total = 0.0;
    for Influences { joints, weights } in influences {
        for (&joint, &weight) in joints[vertex].iter().zip(&weights[vertex]) {
            if weight != 0.0 {
                sum += f64::from(weight) * transforms[joint as usize].transform_point3(position);
                total += f64::from(weight);
            }
        }
    }
    if total > 0.0 {
        return sum / total;
    }
    // Nobody pulls: the first joint has it, as in most viewers.
    let first = influences[0].joints[vertex][0] as usize;
    transforms.get(first).map_or(position, |joint| joint.transform_point3(position))
}

/// True if all joints mirror.
pub(super) fn all_mirror(transforms: &[DAffine3]) -> bool {
    !transforms.is_empty() && transforms.iter().all(|j| j.matrix3.determinant() < 0.0)
}
