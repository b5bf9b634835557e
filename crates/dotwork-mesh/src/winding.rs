//! Winding: neighbours agree, and what encloses something faces outwards. The rules stand in [`crate::Mesh::build`].
//!
//! Faces are gathered into components by a flood over manifold edges, which also notes which faces run against the
//! first one. Whether a component encloses is read from two integrals: the vector area, zero over a closed surface and
//! otherwise that of the holes; and the volume about the centroid. Both are independent of how fine the mesh is, unlike
//! a count of boundary edges.

use dotwork_drawing::Warnings;
use glam::{DVec3, Vec3};

use crate::geometry::{corners, vector_area};
use crate::topology::{NONE, Topology, same_direction};

/// The most that the holes may take of an enclosing surface, as |vector area| over area. A cube without its lid has
/// 0.2 and may be a room, to be seen from inside.
const MAX_OPENING: f64 = 0.1;

/// The least volume of an enclosing surface, in parts of the ball with the same area. A tube 200 times as long as its
/// radius has 0.15; folded sheets stay near 0.
const MIN_VOLUME: f64 = 0.05;

/// A component is looked for inside so many of the largest others: whatever holds cavities is large.
const MAX_CONTAINERS: usize = 256;

/// Turns faces over as the rules ask, and says so.
pub(crate) fn orient(
    positions: &[Vec3],
    triangles: &mut [[u32; 3]],
    topology: &mut Topology,
    warnings: &mut Warnings,
) {
    let flood = Flood::new(triangles, topology);
    if topology.conflicting_edges() > 0 {
        agree(positions, triangles, topology, &flood, warnings);
    }
    let parts = measure(positions, triangles, &flood);
    let turned = inward(&parts);
    if !turned.contains(&true) {
        return;
    }
    let mut faces = 0;
    for (t, &label) in flood.labels.iter().enumerate() {
        if turned[label as usize] {
            turn(triangles, topology, t);
            faces += 1;
        }
    }
    if faces == triangles.len() {
        warnings.say("winding turned: the surface faced inwards");
    } else {
        let count = turned.iter().filter(|&&t| t).count() as u64;
        let first = flood.labels.iter().position(|&l| turned[l as usize]);
        warnings.counted(
            "inward-facing components turned outwards",
            count,
            first.map(|t| format!("triangle {t}")),
        );
    }
}

fn turn(triangles: &mut [[u32; 3]], topology: &mut Topology, t: usize) {
    triangles[t].swap(1, 2);
    topology.turn(t as u32);
}

/// Components connected by manifold edges.
struct Flood {
    count: usize,
    /// For each face its component.
    labels: Vec<u32>,
    /// For each face whether it runs against the first face of its component.
    against: Vec<bool>,
}

impl Flood {
    fn new(triangles: &[[u32; 3]], topology: &Topology) -> Flood {
        let neighbours = topology.neighbours();
        let conflicts = topology.conflicting_edges() > 0;
        let mut labels = vec![NONE; triangles.len()];
        let mut against = vec![false; triangles.len()];
        let mut stack = Vec::new();
        let mut count = 0;
        for first in 0..triangles.len() {
            if labels[first] != NONE {
                continue;
            }
            labels[first] = count;
            stack.push(first as u32);
            while let Some(t) = stack.pop() {
                for (k, &other) in neighbours[t as usize].iter().enumerate() {
                    if other == NONE || labels[other as usize] != NONE {
                        continue;
                    }
                    labels[other as usize] = count;
                    let disagree = conflicts && same_direction(triangles, t, k, other);
                    against[other as usize] = against[t as usize] ^ disagree;
                    stack.push(other);
                }
            }
            count += 1;
        }
        Flood { count: count as usize, labels, against }
    }
}

/// Turns the smaller side, by area, of each component that disagrees within itself.
fn agree(
    positions: &[Vec3],
    triangles: &mut [[u32; 3]],
    topology: &mut Topology,
    flood: &Flood,
    warnings: &mut Warnings,
) {
    // Area that runs with the first face, less that against it.
    let mut majority = vec![0.0; flood.count];
    for (t, &triangle) in triangles.iter().enumerate() {
        let area = vector_area(corners(positions, triangle)).length();
        majority[flood.labels[t] as usize] += if flood.against[t] { -area } else { area };
    }
    let mut first = None;
    let mut count = 0;
    for t in 0..triangles.len() {
        let minority = flood.against[t] != (majority[flood.labels[t] as usize] < 0.0);
        if minority {
            turn(triangles, topology, t);
            first = first.or(Some(t));
            count += 1;
        }
    }
    topology.recount_conflicts(triangles);
    let first = first.map(|t| format!("triangle {t}"));
    warnings.counted("triangles turned to agree with their neighbours", count, first);
    if topology.conflicting_edges() > 0 {
        warnings.say("the surface is one-sided: its winding cannot agree everywhere");
    }
}

/// What is measured of a component. Volumes and moments are about the centre of the mesh's bounding box.
#[derive(Clone, Copy)]
struct Part {
    area: f64,
    vector_area: DVec3,
    /// Six times the volume of the cone over the component.
    volume_6: f64,
    /// Three times the integral of the position.
    moment_3: DVec3,
    min: DVec3,
    max: DVec3,
}

impl Part {
    const EMPTY: Part = Part {
        area: 0.0,
        vector_area: DVec3::ZERO,
        volume_6: 0.0,
        moment_3: DVec3::ZERO,
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The signed volume of the cone from the component's centroid over the component.
    fn volume(&self) -> f64 {
        let centroid = self.moment_3 / (3.0 * self.area);
        self.volume_6 / 6.0 - centroid.dot(self.vector_area) / 3.0
    }

    fn encloses(&self) -> bool {
        let ball = self.area.powf(1.5) / (6.0 * std::f64::consts::PI.sqrt());
        self.vector_area.length() <= MAX_OPENING * self.area && self.volume().abs() >= MIN_VOLUME * ball
    }

    fn is_inside(&self, other: &Part) -> bool {
        self.min.cmpgt(other.min).all() && self.max.cmplt(other.max).all()
    }

    fn diagonal(&self) -> f64 {
        (self.max - self.min).length()
    }
}

fn measure(positions: &[Vec3], triangles: &[[u32; 3]], flood: &Flood) -> Vec<Part> {
    let (min, max) = positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), &p| (min.min(p), max.max(p)));
    let center = 0.5 * (min.as_dvec3() + max.as_dvec3());
    let mut parts = vec![Part::EMPTY; flood.count];
    for (&triangle, &label) in triangles.iter().zip(&flood.labels) {
        let [a, b, c] = corners(positions, triangle).map(|p| p - center);
        let part = &mut parts[label as usize];
        let vector = vector_area([a, b, c]);
        let area = vector.length();
        part.area += area;
        part.vector_area += vector;
        part.volume_6 += 2.0 * a.dot(vector);
        part.moment_3 += area * (a + b + c);
        part.min = part.min.min(a).min(b).min(c);
        part.max = part.max.max(a).max(b).max(c);
    }
    parts
}

/// For each component whether it is to be turned outwards.
fn inward(parts: &[Part]) -> Vec<bool> {
    let mut turned = vec![false; parts.len()];
    let mut enclosing: Vec<usize> = (0..parts.len()).filter(|&i| parts[i].encloses()).collect();
    if !enclosing.iter().any(|&i| parts[i].volume() < 0.0) {
        return turned;
    }
    // From the largest down, so that the component around another is decided first; the sort is stable.
    enclosing.sort_by(|&a, &b| parts[b].diagonal().total_cmp(&parts[a].diagonal()));
    for (rank, &i) in enclosing.iter().enumerate() {
        let around = enclosing[..rank.min(MAX_CONTAINERS)].iter().find(|&&o| parts[i].is_inside(&parts[o]));
        turned[i] = match around {
            Some(&outer) => turned[outer],
            None => parts[i].volume() < 0.0,
        };
    }
    turned
}
