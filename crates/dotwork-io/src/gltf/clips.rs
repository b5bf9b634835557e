//! Animations: which node is moved how, and where it is at a time.
//!
//! A clip that cannot be played is left out, and said so: the mesh at rest is still there to be drawn.

use std::collections::HashMap;

use dotwork_drawing::Warnings;
use glam::{DQuat, DVec3, DVec4};

use super::Document;
use super::budget::{Budget, KEY};
use super::json::{self, Shape};
use super::nodes::{Local, Parts, Pose, Tree, missing, unit};
use crate::error::ReadErrorKind;

/// An animation, ready to be played.
#[derive(Debug)]
pub(super) struct Clip {
    channels: Vec<Channel>,
}

/// What one property of one node does over time.
#[derive(Debug)]
struct Channel {
    node: u32,
    path: Path,
    keys: Keys,
}

/// The property that a channel moves.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Interpolation {
    Step,
    Linear,
    /// Each key has a tangent before and one after its value.
    Cubic,
}

/// Keys of a channel: values of `width` numbers at rising times.
#[derive(Debug)]
struct Keys {
    times: Vec<f32>,
    values: Vec<f32>,
    width: usize,
    interpolation: Interpolation,
}

/// Reads all animations that can be played, with names and lengths in seconds.
pub(super) fn read(
    document: &Document,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> (Vec<Clip>, Vec<dotwork_mesh::Clip>) {
    let mut played = (Vec::new(), Vec::new());
    for (k, animation) in document.json.animations.iter().enumerate() {
        let name = match &animation.name {
            Some(name) if !name.0.trim().is_empty() => name.0.to_string(),
            _ => k.to_string(),
        };
        match Clip::read(document, animation, budget) {
            Ok(clip) => {
                played.1.push(dotwork_mesh::Clip { name, seconds: clip.seconds() });
                played.0.push(clip);
            }
            Err(reason) => warnings.say(format!("animation {k} is left out: {reason}")),
        }
    }
    played
}

impl Clip {
    fn read(
        document: &Document,
        animation: &json::Animation,
        budget: &mut Budget,
    ) -> Result<Clip, ReadErrorKind> {
        let mut channels = Vec::with_capacity(animation.channels.len());
        for (c, channel) in animation.channels.iter().enumerate() {
            let fail = |reason: String| ReadErrorKind::at_item("channel", c, reason);
            // Without a node an extension says what is moved.
            let Some(node) = channel.target.node else { continue };
            let path = match &*channel.target.path.0 {
                "translation" => Path::Translation,
                "rotation" => Path::Rotation,
                "scale" => Path::Scale,
                "weights" => Path::Weights,
                _ => continue,
            };
            let nodes = &document.json.nodes;
            let Some(moved) = nodes.get(node as usize) else {
                return Err(missing("channel", c, "node", node, nodes.len()));
            };
            let Some(sampler) = animation.samplers.get(channel.sampler as usize) else {
                let there = animation.samplers.len();
                return Err(missing("channel", c, "sampler", channel.sampler, there));
            };
            let interpolation = match sampler.interpolation.as_ref().map(|i| &*i.0) {
                None | Some("LINEAR") => Interpolation::Linear,
                Some("STEP") => Interpolation::Step,
                Some("CUBICSPLINE") => Interpolation::Cubic,
                Some(other) => {
                    let other = crate::error::quote(other.as_bytes());
                    return Err(fail(format!("{other} is no interpolation")));
                }
            };
            let input = document.elements(sampler.input, &[Shape::Scalar], None)?;
            budget.charge(document, input.count, KEY)?;
            let times: Vec<f32> = input.floats::<1>().into_iter().map(|[t]| t).collect();
            let rising = times.windows(2).all(|w| w[0] < w[1]) && times.iter().all(|t| t.is_finite());
            if times.is_empty() || !rising {
                return Err(fail("its times do not rise".into()));
            }
            let per_key = if interpolation == Interpolation::Cubic { 3 } else { 1 };
            let width = match path {
                Path::Translation | Path::Scale => 3,
                Path::Rotation => 4,
                Path::Weights => targets_of(document, moved.mesh),
            };
            let values: Vec<f32> = match path {
                Path::Weights => {
                    let output = document.elements(sampler.output, &[Shape::Scalar], None)?;
                    budget.charge(document, output.count, 8)?;
                    output.floats::<1>().into_iter().map(|[v]| v).collect()
                }
                Path::Rotation => {
                    let output = document.elements(sampler.output, &[Shape::Vec4], None)?;
                    budget.charge(document, output.count, KEY)?;
                    output.floats::<4>().into_flattened()
                }
                _ => {
                    let output = document.elements(sampler.output, &[Shape::Vec3], None)?;
                    budget.charge(document, output.count, KEY)?;
                    output.floats::<3>().into_flattened()
                }
            };
            if width == 0 {
                continue;
            }
            let expected = times.len() * per_key * width;
            if values.len() != expected {
                let found = values.len();
                return Err(fail(format!("{} keys need {expected} numbers, not {found}", times.len())));
            }
            if values.iter().any(|v| !v.is_finite()) {
                return Err(fail("a value is not a finite number".into()));
            }
            channels.push(Channel { node, path, keys: Keys { times, values, width, interpolation } });
        }
        Ok(Clip { channels })
    }

    fn seconds(&self) -> f64 {
        let ends = self.channels.iter().filter_map(|c| c.keys.times.last());
        ends.fold(0.0, |longest, &t| f64::from(t).max(longest))
    }

    /// The pose at a time; `rest` are the nodes as they stand at rest.
    pub(super) fn pose(&self, tree: &Tree, rest: &[Local], time: f64) -> Pose {
        let mut moved: HashMap<u32, Parts> = HashMap::new();
        let mut weights: HashMap<u32, Vec<f32>> = HashMap::new();
        for Channel { node, path, keys } in &self.channels {
            if *path == Path::Weights {
                let values = (0..keys.width).map(|k| keys.number(time, k) as f32).collect();
                weights.insert(*node, values);
                continue;
            }
            let parts = moved.entry(*node).or_insert_with(|| rest[*node as usize].parts());
            match path {
                Path::Translation => parts.translation = keys.vector(time),
                Path::Scale => parts.scale = keys.vector(time),
                _ => parts.rotation = keys.rotation(time),
            }
        }
        let local = |n: usize| match moved.get(&(n as u32)) {
            Some(&parts) => Local::Parts(parts).affine(),
            None => rest[n].affine(),
        };
        Pose { globals: tree.globals(local), weights }
    }
}

/// How many morph targets a mesh has.
fn targets_of(document: &Document, mesh: Option<u32>) -> usize {
    let mesh = mesh.and_then(|m| document.json.meshes.get(m as usize));
    mesh.map_or(0, |m| m.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0))
}

impl Keys {
    /// The keys before and after a time, how far it is from the one to the other (0…1), and the seconds between them.
    fn between(&self, time: f64) -> (usize, usize, f64, f64) {
        // In the precision of the keys, so that the time of a frame meets the key that is meant.
        let after = self.times.partition_point(|&t| t <= time as f32);
        if after == 0 {
            return (0, 0, 0.0, 0.0);
        }
        if after == self.times.len() {
            return (after - 1, after - 1, 0.0, 0.0);
        }
        let (a, b) = (f64::from(self.times[after - 1]), f64::from(self.times[after]));
        (after - 1, after, ((time - a) / (b - a)).clamp(0.0, 1.0), b - a)
    }

    /// Number `k` of the value of a key, or of a tangent (0 before it, 1 the value, 2 after it) where there are some.
    fn at(&self, key: usize, which: usize, k: usize) -> f64 {
        let row = if self.interpolation == Interpolation::Cubic { 3 * key + which } else { key };
        f64::from(self.values[row * self.width + k])
    }

    /// Number `k` of the value at a time.
    fn number(&self, time: f64, k: usize) -> f64 {
        let (a, b, t, seconds) = self.between(time);
        let (from, to) = (self.at(a, 1, k), self.at(b, 1, k));
        match self.interpolation {
            Interpolation::Step => from,
            Interpolation::Linear => from + (to - from) * t,
            // A cubic Hermite spline (glTF 2.0, appendix C.4).
            Interpolation::Cubic => {
                let (out, into) = (seconds * self.at(a, 2, k), seconds * self.at(b, 0, k));
                let (t2, t3) = (t * t, t * t * t);
                (2.0 * t3 - 3.0 * t2 + 1.0) * from
                    + (t3 - 2.0 * t2 + t) * out
                    + (3.0 * t2 - 2.0 * t3) * to
                    + (t3 - t2) * into
            }
        }
    }

    fn vector(&self, time: f64) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|k| self.number(time, k)))
    }

    /// A rotation turns about one axis from key to key, the short way round.
    fn rotation(&self, time: f64) -> DQuat {
        if self.interpolation != Interpolation::Linear {
            return unit(DQuat::from_array([0, 1, 2, 3].map(|k| self.number(time, k))));
        }
        let (a, b, t, _) = self.between(time);
        let at = |key: usize| unit(DQuat::from_array([0, 1, 2, 3].map(|k| self.at(key, 1, k))));
        let (from, to) = (at(a), at(b));
        slerp(from, to, t)
    }
}

/// Spherical interpolation (glTF 2.0, appendix C.3). In full precision also where the rotations nearly agree.
fn slerp(from: DQuat, to: DQuat, t: f64) -> DQuat {
    let (from, mut to) = (DVec4::from_array(from.to_array()), DVec4::from_array(to.to_array()));
    if from.dot(to) < 0.0 {
        to = -to;
    }
    // The half angle by its tangent: exact for small ones too.
    let angle = 2.0 * ((to - from).length()).atan2((to + from).length());
    let sine = angle.sin();
    let mixed = if sine < 1e-9 {
        from + (to - from) * t
    } else {
        from * (((1.0 - t) * angle).sin() / sine) + to * ((t * angle).sin() / sine)
    };
    unit(DQuat::from_array(mixed.to_array()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(interpolation: Interpolation, times: &[f32], width: usize, values: &[f32]) -> Keys {
        Keys { times: times.to_vec(), values: values.to_vec(), width, interpolation }
    }

    #[test]
    fn between_keys() {
        let step = keys(Interpolation::Step, &[1.0, 2.0], 1, &[5.0, 9.0]);
        let at = |k: &Keys, t: f64| k.number(t, 0);
        assert_eq!([0.0, 1.0, 1.99, 2.0, 7.0].map(|t| at(&step, t)), [5.0, 5.0, 5.0, 9.0, 9.0]);
        let linear = keys(Interpolation::Linear, &[1.0, 3.0], 1, &[5.0, 9.0]);
        assert_eq!([0.0, 1.0, 2.0, 3.0, 7.0].map(|t| at(&linear, t)), [5.0, 5.0, 7.0, 9.0, 9.0]);
    }

    #[test]
    fn a_spline_keeps_values_and_tangents() {
        // In-tangent, value, out-tangent; two seconds apart.
        let spline = keys(Interpolation::Cubic, &[0.0, 2.0], 1, &[9.0, 1.0, 3.0, -1.0, 4.0, 9.0]);
        let at = |t: f64| spline.number(t, 0);
        assert_eq!([at(-1.0), at(0.0), at(2.0), at(3.0)], [1.0, 1.0, 4.0, 4.0]);
        let slope = |t: f64| (at(t + 1e-5) - at(t - 1e-5)) / 2e-5;
        assert!((slope(1e-4) - 3.0).abs() < 1e-3 && (slope(2.0 - 1e-4) + 1.0).abs() < 2e-3);
    }

    #[test]
    fn rotations_turn_evenly_the_short_way() {
        let turn = |degrees: f64| DQuat::from_rotation_z(degrees.to_radians());
        for (from, to) in [(10.0, 80.0), (10.0, 10.000001), (350.0, 10.0), (0.0, 179.0)] {
            let shortest = (to - from + 540.0f64).rem_euclid(360.0) - 180.0;
            for t in [0.0, 0.25, 0.5, 1.0] {
                let (found, expected) = (slerp(turn(from), turn(to), t), turn(from + shortest * t));
                assert!(found.dot(expected).abs() > 1.0 - 1e-14, "{from} {to} {t}");
            }
        }
    }
}
