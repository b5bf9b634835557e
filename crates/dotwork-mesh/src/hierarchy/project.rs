//! Points beside the input mesh back onto it.

use glam::Vec3;
use rayon::prelude::*;

use crate::topology::NONE;

/// Faces that a walk crosses at most.
const MOST_STEPS: usize = 64;

/// Barycentric coordinates this far outside count as inside.
const ROUNDING: f32 = 1e-5;

/// A face of the input mesh, with all that a walk reads.
#[derive(Clone, Copy)]
pub(super) struct GroundFace {
    pub(super) corners: [Vec3; 3],
    /// The face across edge `k`, between corners `k` and `k + 1`; [`NONE`] at a border.
    pub(super) neighbours: [u32; 3],
}

/// The input mesh, for walks over it.
pub(super) struct Ground {
    pub(super) faces: Vec<GroundFace>,
}

/// A place on a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit {
    pub(super) face: u32,
    /// Barycentric coordinates of the second and third corner.
    pub(super) weights: [f32; 2],
    pub(super) position: Vec3,
}

impl Ground {
    /// The mesh of these triangles, whose neighbours are `neighbours`.
    pub(super) fn new(positions: &[Vec3], triangles: &[[u32; 3]], neighbours: &[[u32; 3]]) -> Ground {
        let face = |(triangle, &neighbours): (&[u32; 3], &[u32; 3])| GroundFace {
            corners: triangle.map(|v| positions[v as usize]),
            neighbours,
        };
        Ground { faces: triangles.par_iter().zip(neighbours).map(face).collect() }
    }

    /// The place on face `face`.
    #[inline]
    pub(super) fn place(&self, face: u32, [v, w]: [f32; 2]) -> Hit {
        let [a, b, c] = self.faces[face as usize].corners;
        Hit { face, weights: [v, w], position: a + (b - a) * v + (c - a) * w }
    }

    /// Where the line through `p` along `normal` meets the mesh, walking from `face` to the neighbour on the side where
    /// the line passes. At a border it is the nearest place of the last face. `None` where the walk comes to faces that
    /// look the other way, or finds no end.
    pub(super) fn walk(&self, p: Vec3, normal: Vec3, face: u32) -> Option<Hit> {
        let mut face = face;
        for _ in 0..MOST_STEPS {
            let GroundFace { corners, neighbours } = self.faces[face as usize];
            let [a, b, c] = corners.map(|corner| corner - p);
            // Volumes of line and edges: the line passes an edge on the outside where one is negative.
            let inside = [normal.dot(b.cross(c)), normal.dot(c.cross(a)), normal.dot(a.cross(b))];
            let all = inside[0] + inside[1] + inside[2];
            if all.is_nan() || all <= 0.0 {
                return None;
            }
            let share = inside.map(|v| v / all);
            let (mut worst, mut k) = (share[0], 0);
            for (j, &v) in share.iter().enumerate() {
                if v < worst {
                    (worst, k) = (v, j);
                }
            }
            // Edge k + 1 lies opposite corner k.
            let next = neighbours[(k + 1) % 3];
            if worst >= -ROUNDING || next == NONE {
                let kept = share.map(|v| v.max(0.0));
                let sum = kept[0] + kept[1] + kept[2];
                return Some(self.place(face, [kept[1] / sum, kept[2] / sum]));
            }
            face = next;
        }
        None
    }
}
