//! The vertices of the input mesh, each moved a little within the faces around it, so that grids do not show.

use dotwork_drawing::hash::{hash2, unit};
use glam::Vec3;
use rayon::prelude::*;

use super::project::{Ground, Hit};
use crate::Topology;
use crate::geometry::GRAIN;
use crate::topology::NONE;

/// How far a vertex moves at most at full strength, over its shortest edge: two that move towards each other keep a
/// good third of it, and no face turns over.
const REACH: f32 = 0.32;

/// For each vertex its place.
///
/// A vertex moves into one of its faces, drawn by lot (Meruvia Pastor et al. 2003, section IV-E), uniformly over a
/// small triangle at its corner. It thereby stays on the surface. Those on a border stay where they are.
pub(super) fn randomise(
    ground: &Ground,
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    topology: &Topology,
    strength: f32,
    seed: u32,
) -> Vec<Hit> {
    let neighbours = topology.neighbours();
    let place = |v: u32| {
        let faces = topology.faces(v);
        let first = faces[0];
        let corner = |t: u32| triangles[t as usize].iter().position(|&w| w == v).unwrap_or(0);
        let mut shortest = f32::INFINITY;
        let mut border = false;
        for &t in faces {
            let k = corner(t);
            border |= neighbours[t as usize][k] == NONE || neighbours[t as usize][(k + 2) % 3] == NONE;
            for w in [1, 2].map(|j| triangles[t as usize][(k + j) % 3]) {
                shortest = shortest.min(positions[v as usize].distance(positions[w as usize]));
            }
        }
        let draw = |k: u32| unit(hash2(v, seed ^ k));
        let t = if border { first } else { faces[(draw(1) * faces.len() as f32) as usize % faces.len()] };
        let k = corner(t);
        let mut shares = [0.0f32; 3];
        if !border && strength > 0.0 {
            let (mut x, mut y) = (draw(2), draw(3));
            if x + y > 1.0 {
                (x, y) = (1.0 - x, 1.0 - y);
            }
            for (j, share) in [(1, x), (2, y)] {
                let w = triangles[t as usize][(k + j) % 3];
                let edge = positions[v as usize].distance(positions[w as usize]);
                shares[(k + j) % 3] = REACH * strength * share * (shortest / edge).min(1.0);
            }
        }
        shares[k] = 1.0 - shares[(k + 1) % 3] - shares[(k + 2) % 3];
        ground.place(t, [shares[1], shares[2]])
    };
    (0..positions.len() as u32).into_par_iter().with_min_len(GRAIN).map(place).collect()
}
