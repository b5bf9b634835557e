//! The vertices of the input mesh, each moved a little within the faces around it, so that grids do not show.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use dotwork_drawing::hash::{hash2, unit};
use glam::Vec3;
use rayon::prelude::*;

use super::project::{Ground, Hit};
use crate::Topology;
use crate::geometry::GRAIN;
use crate::topology::NONE;

/// How far a vertex moves at most at full strength, over its shortest edge. Places uniform over a disc of radius R leave a
/// grid's frequency k `(2 J₁(kR) / kR)²` of its power: 41 % at a third of the edge, next to nothing at two thirds.
const REACH: f32 = 0.65;

/// A triangle that is left with less than this share of its area, or turned over, is too thin.
const THIN: f32 = 0.15;

/// Corners of triangles that became too thin go back by half, so often; then all the way.
const RETREATS: usize = 3;

/// Where a vertex goes.
#[derive(Clone, Copy)]
struct Move {
    /// One of its faces, and which corner of that it is.
    face: u32,
    corner: u32,
    /// Shares of the two corners after it, at most.
    shares: [f32; 2],
    /// How much of that it goes.
    part: f32,
}

impl Move {
    fn hit(&self, ground: &Ground) -> Hit {
        let [x, y] = self.shares.map(|share| share * self.part);
        let mut all = [1.0 - x - y; 3];
        all[(self.corner as usize + 1) % 3] = x;
        all[(self.corner as usize + 2) % 3] = y;
        ground.place(self.face, [all[1], all[2]])
    }
}

/// For each vertex its place.
///
/// A vertex moves into one of its faces, drawn by lot (Meruvia Pastor et al. 2003, section IV-E), uniformly over a
/// small triangle at its corner. It thereby stays on the surface. Those on a border stay where they are. Where triangles
/// would become too thin, their corners move less.
pub(super) fn randomise(
    ground: &Ground,
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    topology: &Topology,
    strength: f32,
    seed: u32,
) -> Vec<Hit> {
    let vertices = positions.len() as u32;
    let mut moves: Vec<Move> = (0..vertices)
        .into_par_iter()
        .with_min_len(GRAIN)
        .map(|v| draw(positions, triangles, topology, strength, (v, seed)))
        .collect();
    let place = |moves: &[Move]| -> Vec<Hit> { moves.par_iter().map(|m| m.hit(ground)).collect() };
    let mut places = place(&moves);
    if strength == 0.0 {
        return places;
    }
    let thin: Vec<AtomicBool> = moves.par_iter().map(|_| AtomicBool::new(false)).collect();
    for round in 0..=RETREATS {
        let normal = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a);
        triangles.par_iter().with_min_len(GRAIN).for_each(|corners| {
            let before = normal(corners.map(|v| positions[v as usize]));
            let after = normal(corners.map(|v| places[v as usize].position));
            if after.dot(before) < THIN * before.length_squared() {
                // Whoever says so first, it stays said.
                corners.iter().for_each(|&v| thin[v as usize].store(true, Relaxed));
            }
        });
        let part = if round == RETREATS { 0.0 } else { 0.5 };
        moves.par_iter_mut().zip(&thin).for_each(|(m, thin)| {
            if thin.swap(false, Relaxed) {
                m.part *= part;
            }
        });
        places = place(&moves);
    }
    places
}

/// Draws where a vertex would go.
fn draw(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    topology: &Topology,
    strength: f32,
    (v, seed): (u32, u32),
) -> Move {
    let (faces, neighbours) = (topology.faces(v), topology.neighbours());
    let corner = |t: u32| triangles[t as usize].iter().position(|&w| w == v).unwrap_or(0);
    let length = |w: u32| positions[v as usize].distance(positions[w as usize]);
    let mut shortest = f32::INFINITY;
    let mut border = false;
    for &t in faces {
        let k = corner(t);
        border |= neighbours[t as usize][k] == NONE || neighbours[t as usize][(k + 2) % 3] == NONE;
        for j in [1, 2] {
            shortest = shortest.min(length(triangles[t as usize][(k + j) % 3]));
        }
    }
    let chance = |k: u32| unit(hash2(v, seed ^ k));
    let face = faces[(chance(1) * faces.len() as f32) as usize % faces.len()];
    let k = corner(face);
    let (mut x, mut y) = (chance(2), chance(3));
    if x + y > 1.0 {
        (x, y) = (1.0 - x, 1.0 - y);
    }
    let reach = if border { 0.0 } else { REACH * strength };
    let share = |j: usize, chance: f32| {
        reach * chance * (shortest / length(triangles[face as usize][(k + j) % 3])).min(1.0)
    };
    Move { face, corner: k as u32, shares: [share(1, x), share(2, y)], part: 1.0 }
}
