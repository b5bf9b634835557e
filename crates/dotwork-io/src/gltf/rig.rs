//! The rig: all that is needed to place the vertices of a scene in any pose, without the file.
//!
//! Morph targets move a vertex in the space of its mesh (positions + Σ weightₖ · targetₖ), then its joints or its node
//! take it into the scene.

use std::hash::Hasher;

use dotwork_drawing::{Lens, Standpoint};
use dotwork_mesh::Motion;
use glam::{DAffine3, DVec3};
use rayon::prelude::*;

use super::clips::Clip;
use super::nodes::{Local, Pose, Tree};
use super::skin::{self, Influences, Skin};

/// Weights that round to the same of so many steps move alike, as far as can be seen.
const WEIGHT_STEPS: f32 = 512.0;

/// Vertices that a task places.
const GRAIN: usize = 4096;

/// The vertices of one primitive in one place.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) node: u32,
    /// Positions in the space of the mesh, not moved.
    pub(super) local: Vec<[f32; 3]>,
    /// How far each morph target moves them at weight 1; empty for targets that never count.
    pub(super) targets: Vec<Vec<[f32; 3]>>,
    /// Weights of the targets at rest.
    pub(super) weights: Vec<f32>,
    /// The skin, and what its joints do; the node where there are none.
    pub(super) skin: u32,
    pub(super) influences: Vec<Influences>,
}

/// A scene that can take poses.
#[derive(Debug)]
pub(super) struct Rig {
    pub(super) tree: Tree,
    pub(super) rest: Vec<Local>,
    pub(super) skins: Vec<Option<Skin>>,
    pub(super) parts: Vec<Part>,
    pub(super) clips: Vec<Clip>,
    /// Names and lengths of the clips.
    pub(super) listed: Vec<dotwork_mesh::Clip>,
    pub(super) cameras: Vec<PlacedCamera>,
    pub(super) camera_names: Vec<String>,
    /// Subtracted from all places.
    pub(super) origin: DVec3,
}

/// A camera and the node that carries it.
#[derive(Debug)]
pub(super) struct PlacedCamera {
    pub(super) node: u32,
    pub(super) lens: Lens,
}

impl Part {
    /// Where its vertices are in a pose: added to `places`, in the scene. Returns whether they are mirrored.
    pub(super) fn place(
        &self,
        pose: &Pose,
        skins: &[Option<Skin>],
        origin: DVec3,
        places: &mut Vec<DVec3>,
    ) -> bool {
        let moved = self.morphed(pose);
        let wide = |p: &[f32; 3]| DVec3::from_array(p.map(f64::from));
        let first = places.len();
        places.resize(first + self.local.len(), DVec3::ZERO);
        let out = &mut places[first..];
        let skin = skins.get(self.skin as usize).and_then(Option::as_ref);
        let local = moved.as_deref().unwrap_or(&self.local);
        match skin.filter(|_| !self.influences.is_empty()) {
            Some(skin) => {
                let transforms = skin.transforms(&pose.globals);
                out.par_iter_mut().zip(local).enumerate().with_min_len(GRAIN).for_each(|(v, (out, p))| {
                    *out = skin::place(&self.influences, &transforms, v, wide(p)) - origin;
                });
                skin::all_mirror(&transforms)
            }
            None => {
                let global = &pose.globals[self.node as usize];
                out.par_iter_mut()
                    .zip(local)
                    .with_min_len(GRAIN)
                    .for_each(|(out, p)| *out = global.transform_point3(wide(p)) - origin);
                global.matrix3.determinant() < 0.0
            }
        }
    }

    /// Positions moved by the morph targets; `None` where none counts.
    pub(super) fn morphed(&self, pose: &Pose) -> Option<Vec<[f32; 3]>> {
        let weights = pose.weights.get(&self.node).unwrap_or(&self.weights);
        let counts: Vec<(&[[f32; 3]], f32)> = self
            .targets
            .iter()
            .zip(weights)
            .filter(|(target, weight)| **weight != 0.0 && !target.is_empty())
            .map(|(target, &weight)| (target.as_slice(), weight))
            .collect();
        if counts.is_empty() {
            return None;
        }
        let moved = |(v, p): (usize, &[f32; 3])| {
            let mut at = *p;
            for (target, weight) in &counts {
                for k in 0..3 {
                    at[k] += weight * target[v][k];
                }
            }
            at
        };
        Some(self.local.par_iter().enumerate().with_min_len(GRAIN).map(moved).collect())
    }

    /// A number for each vertex that is the same for those that move alike from the same place.
    pub(super) fn tracks(&self, tracks: &mut Vec<u64>) {
        let track = |v: usize| {
            let mut hash = std::hash::DefaultHasher::new();
            hash.write_u32(self.node);
            let mut vector = |p: [f32; 3]| p.iter().for_each(|c| hash.write_u32((c + 0.0).to_bits()));
            vector(self.local[v]);
            self.targets.iter().filter(|t| !t.is_empty()).for_each(|t| vector(t[v]));
            // Two vertices at a seam may list their joints in another order, and differ in the last digits.
            let mut pulled = [(u32::MAX, 0i32); 8];
            let all = self.influences.iter().flat_map(|i| i.joints[v].into_iter().zip(i.weights[v]));
            for (place, (joint, weight)) in pulled.iter_mut().zip(all) {
                *place = (joint, (weight * WEIGHT_STEPS).round() as i32);
            }
            pulled.sort_unstable();
            for (joint, weight) in pulled.into_iter().filter(|p| p.1 != 0) {
                hash.write_u32(joint);
                hash.write_i32(weight);
            }
            hash.finish()
        };
        tracks.par_extend((0..self.local.len()).into_par_iter().with_min_len(GRAIN).map(track));
    }
}

impl Rig {
    fn pose(&self, clip: Option<usize>, time: f64) -> Pose {
        match clip {
            Some(clip) => self.clips[clip].pose(&self.tree, &self.rest, time),
            None => self.tree.rest_pose(&self.rest),
        }
    }
}

impl Motion for Rig {
    fn clips(&self) -> &[dotwork_mesh::Clip] {
        &self.listed
    }

    fn place(&self, clip: Option<usize>, time: f64, positions: &mut Vec<[f32; 3]>) {
        let pose = self.pose(clip, time);
        let mut places = Vec::new();
        for part in &self.parts {
            part.place(&pose, &self.skins, self.origin, &mut places);
        }
        positions.clear();
        positions.par_extend(places.par_iter().with_min_len(GRAIN).map(|p| p.as_vec3().to_array()));
    }

    fn cameras(&self) -> &[String] {
        &self.camera_names
    }

    fn standpoint(&self, camera: usize, clip: Option<usize>, time: f64) -> Option<Standpoint> {
        let camera = self.cameras.get(camera)?;
        let global: DAffine3 = self.pose(clip, time).globals[camera.node as usize];
        // It looks along its own −z.
        let back = global.matrix3.z_axis.try_normalize()?;
        let up = global.matrix3.y_axis;
        let up = (up - back * up.dot(back)).try_normalize()?;
        let eye = global.translation;
        eye.is_finite().then(|| Standpoint { eye, back: back.as_vec3(), up: up.as_vec3(), lens: camera.lens })
    }
}
