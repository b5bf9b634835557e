//! Skins: vertices that follow joints.
//!
//! A vertex goes where its joints take it, `Σ wᵢ · globalᵢ · inverseBindᵢ · v`, in the space of the scene; where the node
//! with the mesh stands does not matter.

use std::rc::Rc;

use glam::{DAffine3, DMat4, DVec3};

use super::Document;
use super::budget::{Budget, JOINT, MATRIX};
use super::json::{Attributes, Shape};
use super::nodes::{Pose, missing};
use crate::error::ReadErrorKind;

/// Four joints and their weights for each vertex.
type Influences = (Vec<[u32; 4]>, Vec<[f32; 4]>);

/// A skin in a pose, with the influences of a primitive's vertices.
pub(super) struct Skinning {
    /// From the space of the vertices to that of the scene, by joint.
    joints: Rc<[DAffine3]>,
    influences: Vec<Influences>,
}

impl Skinning {
    /// The skinning of a primitive with `vertices` vertices by [`joint_transforms`]; `None` if it names no joints.
    pub(super) fn new(
        document: &Document,
        joints: Rc<[DAffine3]>,
        attributes: &Attributes,
        vertices: usize,
    ) -> Result<Option<Skinning>, ReadErrorKind> {
        let sets = [(attributes.joints_0, attributes.weights_0), (attributes.joints_1, attributes.weights_1)];
        let mut influences = Vec::new();
        for (joint, weight) in sets {
            let (Some(joint), Some(weight)) = (joint, weight) else { continue };
            let indices = document.elements(joint, &[Shape::Vec4], Some(vertices))?.integers::<4>();
            let weights = document.elements(weight, &[Shape::Vec4], Some(vertices))?.floats::<4>();
            let wrong = |(j, w): (&u32, &f32)| *w != 0.0 && *j as usize >= joints.len();
            let first = indices.iter().zip(&weights).position(|(j, w)| j.iter().zip(w).any(wrong));
            if let Some(v) = first {
                let reason = format!("vertex {v}: a joint out of range ({} joints)", joints.len());
                return Err(ReadErrorKind::at_item("accessor", joint as usize, reason));
            }
            influences.push((indices, weights));
        }
        Ok((!influences.is_empty()).then_some(Skinning { joints, influences }))
    }

    /// Where a vertex goes.
    #[inline]
    pub(super) fn place(&self, vertex: usize, position: DVec3) -> DVec3 {
        let mut sum = DVec3::ZERO;
        let mut total = 0.0;
        for (joints, weights) in &self.influences {
            for (&joint, &weight) in joints[vertex].iter().zip(&weights[vertex]) {
                if weight != 0.0 {
                    sum += f64::from(weight) * self.joints[joint as usize].transform_point3(position);
                    total += f64::from(weight);
                }
            }
        }
        if total > 0.0 {
            return sum / total;
        }
        // Nobody pulls: the first joint has it, as in most viewers.
        let first = self.influences[0].0[vertex][0] as usize;
        self.joints.get(first).map_or(position, |joint| joint.transform_point3(position))
    }

    /// True if all joints mirror.
    pub(super) fn mirrors(&self) -> bool {
        !self.joints.is_empty() && self.joints.iter().all(|j| j.matrix3.determinant() < 0.0)
    }
}

/// From the space of skinned vertices to that of the scene, for each joint of a skin.
pub(super) fn joint_transforms(
    document: &Document,
    pose: &Pose,
    skin: u32,
    budget: &mut Budget,
) -> Result<Rc<[DAffine3]>, ReadErrorKind> {
    let index = skin as usize;
    let Some(skin) = document.json.skins.get(index) else {
        let reason = format!("does not exist ({} skins)", document.json.skins.len());
        return Err(ReadErrorKind::at_item("skin", index, reason));
    };
    budget.charge(document, skin.joints.len(), JOINT)?;
    let inverse_binds = match skin.inverse_bind_matrices {
        Some(accessor) => {
            let elements = document.elements(accessor, &[Shape::Mat4], None)?;
            budget.charge(document, elements.count, MATRIX)?;
            Some(elements.floats::<16>())
        }
        None => None,
    };
    if let Some(matrices) = &inverse_binds
        && matrices.len() < skin.joints.len()
    {
        let reason = format!("{} inverse bind matrices for {} joints", matrices.len(), skin.joints.len());
        return Err(ReadErrorKind::at_item("skin", index, reason));
    }
    let joint = |(k, &joint): (usize, &u32)| {
        let Some(&global) = pose.globals.get(joint as usize) else {
            return Err(missing("skin", index, "node", joint, pose.globals.len()));
        };
        Ok(match &inverse_binds {
            Some(matrices) => {
                global * DAffine3::from_mat4(DMat4::from_cols_array(&matrices[k].map(f64::from)))
            }
            None => global,
        })
    };
    skin.joints.iter().enumerate().map(joint).collect()
}
