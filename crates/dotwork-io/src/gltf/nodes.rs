//! The tree of nodes, and where each of them stands.

use std::collections::HashMap;

use dotwork_drawing::Warnings;
use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::json::{Json, Node};
use crate::error::ReadErrorKind;

/// No node.
const NONE: u32 = u32::MAX;

/// Who stands below whom: a forest, checked.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    parents: Vec<u32>,
    /// All nodes, parents before their children.
    order: Vec<u32>,
}

impl Tree {
    /// Refuses children that do not exist, nodes with two parents, and cycles.
    pub(super) fn new(json: &Json) -> Result<Tree, ReadErrorKind> {
        let nodes = &json.nodes;
        let mut parents = vec![NONE; nodes.len()];
        for (n, node) in nodes.iter().enumerate() {
            for &child in &node.children {
                let Some(parent) = parents.get_mut(child as usize) else {
                    return Err(missing("node", n, "child", child, nodes.len()));
                };
                if *parent != NONE {
                    let reason = format!("is a child of node {parent} and again of node {n}");
                    return Err(ReadErrorKind::at_item("node", child as usize, reason));
                }
                *parent = n as u32;
            }
        }
        let mut order: Vec<u32> = (0..nodes.len() as u32).filter(|&n| parents[n as usize] == NONE).collect();
        let mut next = 0;
        while let Some(&n) = order.get(next) {
            order.extend(&nodes[n as usize].children);
            next += 1;
        }
        if order.len() < nodes.len() {
            // With one parent each, what no root reaches goes round.
            let mut reached = vec![false; nodes.len()];
            order.iter().for_each(|&n| reached[n as usize] = true);
            let first = reached.iter().position(|&r| !r).unwrap_or(0);
            return Err(ReadErrorKind::at_item("node", first, "is below itself: its children form a cycle"));
        }
        Ok(Tree { parents, order })
    }

    /// The nodes to be drawn, depth first: those of the default scene, or all where none is named.
    pub(super) fn drawn(&self, json: &Json, warnings: &mut Warnings) -> Result<Vec<u32>, ReadErrorKind> {
        let mut stack: Vec<u32> = match json.scene {
            Some(scene) => {
                let index = scene as usize;
                let Some(scene) = json.scenes.get(index) else {
                    let reason = format!("does not exist ({} scenes)", json.scenes.len());
                    return Err(ReadErrorKind::at_item("scene", index, reason));
                };
                if let Some(&node) = scene.nodes.iter().find(|&&n| n as usize >= json.nodes.len()) {
                    return Err(missing("scene", index, "node", node, json.nodes.len()));
                }
                let others = json.scenes.len() as u64 - 1;
                warnings.counted("scenes beside the default one not drawn", others, None);
                scene.nodes.iter().rev().copied().collect()
            }
            None => {
                (0..json.nodes.len() as u32).rev().filter(|&n| self.parents[n as usize] == NONE).collect()
            }
        };
        let mut seen = vec![false; json.nodes.len()];
        let mut drawn = Vec::new();
        while let Some(n) = stack.pop() {
            // A scene may name a node and one below it.
            if std::mem::replace(&mut seen[n as usize], true) {
                continue;
            }
            drawn.push(n);
            stack.extend(json.nodes[n as usize].children.iter().rev());
        }
        Ok(drawn)
    }
}

/// The error of an object that refers to another one that does not exist.
pub(super) fn missing(kind: &'static str, at: usize, what: &str, index: u32, count: usize) -> ReadErrorKind {
    ReadErrorKind::at_item(kind, at, format!("{what} {index} does not exist ({count} are there)"))
}

/// Where every node stands, and how far every morph target is applied.
#[derive(Debug)]
pub(super) struct Pose {
    /// From the space of each node to that of the scene.
    pub(super) globals: Vec<DAffine3>,
    /// Weights of morph targets by node, where they differ from those at rest.
    pub(super) weights: HashMap<u32, Vec<f32>>,
}

impl Pose {
    /// The pose that the nodes themselves describe.
    pub(super) fn rest(json: &Json, tree: &Tree) -> Pose {
        tree.rest_pose(&json.nodes.iter().map(Local::of).collect::<Vec<_>>())
    }
}

impl Tree {
    /// The pose in which every node lies as at rest.
    pub(super) fn rest_pose(&self, rest: &[Local]) -> Pose {
        Pose { globals: self.globals(|n| rest[n].affine()), weights: HashMap::new() }
    }

    /// From the space of each node to that of the scene, where `local` leads from node `n` to its parent.
    pub(super) fn globals(&self, local: impl Fn(usize) -> DAffine3) -> Vec<DAffine3> {
        let mut globals = vec![DAffine3::IDENTITY; self.parents.len()];
        for &n in &self.order {
            let parent = self.parents[n as usize];
            let local = local(n as usize);
            globals[n as usize] = if parent == NONE { local } else { globals[parent as usize] * local };
        }
        globals
    }
}

/// The weights of the morph targets of the mesh that `node` shows, at rest.
pub(super) fn rest_weights<'a>(json: &'a Json, node: u32, mesh: usize) -> &'a [f32] {
    match json.nodes[node as usize].weights.is_empty() {
        false => &json.nodes[node as usize].weights,
        true => &json.meshes[mesh].weights,
    }
}

/// How a node lies in its parent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Local {
    Matrix(DAffine3),
    Parts(Parts),
}

/// Translation, rotation and scale: what animations move.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts {
    pub(super) translation: DVec3,
    pub(super) rotation: DQuat,
    pub(super) scale: DVec3,
}

impl Local {
    pub(super) fn of(node: &Node) -> Local {
        if let Some(matrix) = &node.matrix {
            return Local::Matrix(DAffine3::from_mat4(DMat4::from_cols_array(matrix)));
        }
        Local::Parts(Parts {
            translation: node.translation.as_deref().map_or(DVec3::ZERO, |&t| t.into()),
            scale: node.scale.as_deref().map_or(DVec3::ONE, |&s| s.into()),
            rotation: node.rotation.as_deref().map_or(DQuat::IDENTITY, |&r| unit(DQuat::from_array(r))),
        })
    }

    /// From the space of the node to that of its parent.
    pub(super) fn affine(self) -> DAffine3 {
        match self {
            Local::Matrix(matrix) => matrix,
            Local::Parts(p) => DAffine3::from_scale_rotation_translation(p.scale, p.rotation, p.translation),
        }
    }

    /// Its parts; a matrix, which no animation should move, is taken apart.
    pub(super) fn parts(self) -> Parts {
        match self {
            Local::Matrix(matrix) => {
                let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
                Parts { translation, rotation: unit(rotation), scale }
            }
            Local::Parts(parts) => parts,
        }
    }
}

/// A rotation at unit length: rounded in the file; without length it says nothing.
pub(super) fn unit(rotation: DQuat) -> DQuat {
    let length = rotation.length();
    if length > 0.0 && length.is_finite() { rotation / length } else { DQuat::IDENTITY }
}
