//! Grids of quads cut into triangles, the stuff of most shapes.

use glam::Vec3;

use super::raw;
use crate::{RawMesh, clean};

/// Vertices and triangles under construction, in double precision until the end.
#[derive(Default)]
pub(super) struct Patches {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Patches {
    /// Adds a grid of `nu` × `nv` quads over `point(u, v)`, `u` and `v` in 0..=1 and exact at both ends. The side from
    /// which u turns to v counter-clockwise is outside, or the other one if `turned`.
    pub(super) fn add(&mut self, nu: usize, nv: usize, turned: bool, point: impl Fn(f64, f64) -> [f64; 3]) {
        let base = self.positions.len();
        for j in 0..=nv {
            for i in 0..=nu {
                let p = point(i as f64 / nu as f64, j as f64 / nv as f64);
                self.positions.push(p.map(|c| c as f32));
            }
        }
        let at = |i: usize, j: usize| (base + j * (nu + 1) + i) as u32;
        for j in 0..nv {
            for i in 0..nu {
                let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                let [a, b, c, d] = if turned { [quad[0], quad[3], quad[2], quad[1]] } else { quad };
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// The mesh, with equal positions made one vertex and collapsed triangles (at poles) left out.
    pub(super) fn weld(self) -> RawMesh {
        let mut positions: Vec<Vec3> =
            self.positions.into_iter().map(|p| Vec3::from(p) + Vec3::ZERO).collect();
        let mut triangles = self.triangles;
        if let Some(canonical) = clean::weld_map(&positions, &[]) {
            for t in &mut triangles {
                *t = t.map(|v| canonical[v as usize]);
            }
            triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
            let mut used = vec![false; positions.len()];
            triangles.as_flattened().iter().for_each(|&v| used[v as usize] = true);
            clean::compact(&mut positions, &mut triangles, &used);
        }
        raw(positions.iter().map(Vec3::to_array).collect(), triangles)
    }
}
