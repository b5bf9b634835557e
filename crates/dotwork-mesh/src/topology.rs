//! Topology: which faces meet at a vertex, which across an edge, and what that says about the whole.
//!
//! The faces around each vertex lie one after another in a single array (a compressed sparse row). Edges are found from
//! it without a global map: an edge belongs to its lower vertex, whose few faces are listed and sorted by the other
//! end; faces under the same end share the edge. Time is linear in the triangles but for the sorting of these short
//! lists; a vertex with n faces costs n log n.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use crate::geometry::GRAIN;

/// Stands for "no neighbour" in [`Topology::neighbours`].
pub const NONE: u32 = u32::MAX;

/// Who neighbours whom in a list of triangles.
///
/// Edge `k` of a triangle joins its corners `k` and `(k + 1) % 3`. An edge is *manifold* with exactly two faces, a
/// *boundary* with one, *non-manifold* with more.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    /// The faces of vertex `v` are `faces[face_start[v]..face_start[v + 1]]`.
    face_start: Vec<u32>,
    faces: Vec<u32>,
    neighbours: Vec<[u32; 3]>,
    counts: EdgeCounts,
    vertices: usize,
}

/// Edges by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct EdgeCounts {
    all: usize,
    boundary: usize,
    non_manifold: usize,
    /// Manifold edges that both faces run along in the same direction.
    conflicting: usize,
}

impl EdgeCounts {
    fn plus(self, other: EdgeCounts) -> EdgeCounts {
        EdgeCounts {
            all: self.all + other.all,
            boundary: self.boundary + other.boundary,
            non_manifold: self.non_manifold + other.non_manifold,
            conflicting: self.conflicting + other.conflicting,
        }
    }
}

/// The connected components of a mesh; see [`Topology::components`].
#[derive(Clone, Debug, PartialEq)]
pub struct Components {
    /// How many there are.
    pub count: usize,
    /// For each triangle the number of its component, counted in the order of their first triangles.
    pub labels: Vec<u32>,
}

impl Topology {
    /// Finds the topology of `triangles`, which refer to vertices `0..vertices` and repeat no vertex within a
    /// triangle (see [`crate::Mesh::build`]).
    ///
    /// # Panics
    ///
    /// If a triangle refers to a vertex that does not exist.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Topology {
        let (face_start, faces) = faces_by_vertex(vertices, triangles);
        let mates: Vec<AtomicU32> =
            (0..3 * triangles.len()).into_par_iter().map(|_| AtomicU32::new(NONE)).collect();
        // Each edge slot is written by one task only, the one of the edge's lower vertex, so the order does not show.
        let counts = (0..vertices)
            .into_par_iter()
            .with_min_len(GRAIN)
            .fold(
                || (Vec::with_capacity(64), EdgeCounts::default()),
                |(mut edges, counts), v| {
                    let around = &faces[face_start[v] as usize..face_start[v + 1] as usize];
                    list_edges(v as u32, around, triangles, &mut edges);
                    let here = pair_edges(&edges, &mates);
                    (edges, counts.plus(here))
                },
            )
            .map(|(_, counts)| counts)
            .reduce(EdgeCounts::default, EdgeCounts::plus);
        let neighbours = mates.par_chunks_exact(3).map(|m| [0, 1, 2].map(|k| m[k].load(Ordering::Relaxed)));
        let neighbours = neighbours.collect();
        let used = face_start.windows(2).filter(|w| w[0] < w[1]).count();
        Topology { face_start, faces, neighbours, counts, vertices: used }
    }

    /// The faces around vertex `v`, in ascending order.
    ///
    /// # Panics
    ///
    /// If there is no vertex `v`.
    #[inline]
    pub fn faces(&self, v: u32) -> &[u32] {
        &self.faces[self.face_start[v as usize] as usize..self.face_start[v as usize + 1] as usize]
    }

    /// For each triangle the other face at each of its edges: [`NONE`] at a boundary, and where more than two faces
    /// meet ([`Topology::edge_faces`] lists those).
    #[inline]
    pub fn neighbours(&self) -> &[[u32; 3]] {
        &self.neighbours
    }

    /// All faces at the edge between vertices `a` and `b`, ascending; `triangles` are those given to
    /// [`Topology::new`]. Empty if there is no such edge.
    pub fn edge_faces<'a>(
        &'a self,
        triangles: &'a [[u32; 3]],
        a: u32,
        b: u32,
    ) -> impl Iterator<Item = u32> + use<'a> {
        // The vertex with fewer faces is searched: the hub of a fan may have thousands.
        let (from, to) = if self.faces(a).len() <= self.faces(b).len() { (a, b) } else { (b, a) };
        self.faces(from).iter().copied().filter(move |&t| triangles[t as usize].contains(&to))
    }

    /// Edges of all kinds.
    pub fn edges(&self) -> usize {
        self.counts.all
    }

    /// Edges with one face only.
    pub fn boundary_edges(&self) -> usize {
        self.counts.boundary
    }

    /// Edges with more than two faces.
    pub fn non_manifold_edges(&self) -> usize {
        self.counts.non_manifold
    }

    /// Edges with two faces that disagree in winding: both run along the edge in the same direction.
    pub fn conflicting_edges(&self) -> usize {
        self.counts.conflicting
    }

    /// True if every edge has exactly two faces, which agree in winding.
    pub fn is_closed(&self) -> bool {
        self.counts.boundary == 0 && self.counts.non_manifold == 0 && self.counts.conflicting == 0
    }

    /// The Euler characteristic, vertices − edges + faces, of the vertices in use: 2 − 2g for a closed surface with g
    /// handles, and the sum of these over components.
    pub fn euler_characteristic(&self) -> i64 {
        self.vertices as i64 - self.counts.all as i64 + self.neighbours.len() as i64
    }

    /// The connected components: triangles that share a vertex are in the same one. `triangles` are those given to
    /// [`Topology::new`].
    pub fn components(&self, triangles: &[[u32; 3]]) -> Components {
        let mut labels = vec![NONE; triangles.len()];
        let mut seen = vec![false; self.face_start.len() - 1];
        let mut stack = Vec::new();
        let mut count = 0;
        for first in 0..triangles.len() {
            if labels[first] != NONE {
                continue;
            }
            labels[first] = count;
            stack.push(first as u32);
            while let Some(t) = stack.pop() {
                for v in triangles[t as usize] {
                    if std::mem::replace(&mut seen[v as usize], true) {
                        continue;
                    }
                    for &other in self.faces(v) {
                        if labels[other as usize] == NONE {
                            labels[other as usize] = count;
                            stack.push(other);
                        }
                    }
                }
            }
            count += 1;
        }
        Components { count: count as usize, labels }
    }

    /// Follows triangle `t` being turned over, its corners 1 and 2 exchanged; the caller then recounts.
    pub(crate) fn turn(&mut self, t: u32) {
        self.neighbours[t as usize].swap(0, 2);
    }

    /// Counts again the edges whose faces disagree, after triangles were turned.
    pub(crate) fn recount_conflicts(&mut self, triangles: &[[u32; 3]]) {
        let conflicts = |t: usize| {
            (0..3)
                .filter(|&k| {
                    let other = self.neighbours[t][k];
                    // Each pair is counted from its lower face; `NONE` is higher than all.
                    other != NONE && t < other as usize && same_direction(triangles, t as u32, k, other)
                })
                .count()
        };
        self.counts.conflicting =
            (0..triangles.len()).into_par_iter().with_min_len(GRAIN).map(conflicts).sum();
    }
}

/// True if face `other` runs along edge `k` of face `t` in the same direction as `t` does.
pub(crate) fn same_direction(triangles: &[[u32; 3]], t: u32, k: usize, other: u32) -> bool {
    let (from, to) = (triangles[t as usize][k], triangles[t as usize][(k + 1) % 3]);
    let o = triangles[other as usize];
    (0..3).any(|j| o[j] == from && o[(j + 1) % 3] == to)
}

/// A counting sort of the faces by vertex: where those of each vertex begin, one more than there are vertices, and the
/// faces.
pub(crate) fn faces_by_vertex(vertices: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<u32>) {
    // Counts are kept one place further on, so that filling moves each start to where it belongs.
    let mut start = vec![0u32; vertices + 2];
    for &v in triangles.as_flattened() {
        start[v as usize + 2] += 1;
    }
    for v in 2..vertices + 2 {
        start[v] += start[v - 1];
    }
    let mut faces = vec![0u32; 3 * triangles.len()];
    for (triangle, t) in triangles.iter().zip(0u32..) {
        for &v in triangle {
            let slot = &mut start[v as usize + 1];
            faces[*slot as usize] = t;
            *slot += 1;
        }
    }
    start.pop();
    (start, faces)
}

/// An edge of one face: its higher vertex, the slot `3 · face + edge`, and whether the face runs from low to high.
type HalfEdge = (u32, u32, bool);

/// Lists in `edges` those between `v` and higher vertices, for the faces `around` it, sorted by the higher vertex.
fn list_edges(v: u32, around: &[u32], triangles: &[[u32; 3]], edges: &mut Vec<HalfEdge>) {
    edges.clear();
    for &t in around {
        let triangle = triangles[t as usize];
        for k in 0..3 {
            let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
            if from == v && to > v {
                edges.push((to, 3 * t + k as u32, true));
            } else if to == v && from > v {
                edges.push((from, 3 * t + k as u32, false));
            }
        }
    }
    edges.sort_unstable();
}

/// Tells faces that share a manifold edge of each other, and counts the edges by kind.
fn pair_edges(edges: &[HalfEdge], mates: &[AtomicU32]) -> EdgeCounts {
    let mut counts = EdgeCounts::default();
    for sharing in edges.chunk_by(|a, b| a.0 == b.0) {
        counts.all += 1;
        match *sharing {
            [_] => counts.boundary += 1,
            [(_, a, a_up), (_, b, b_up)] => {
                mates[a as usize].store(b / 3, Ordering::Relaxed);
                mates[b as usize].store(a / 3, Ordering::Relaxed);
                counts.conflicting += usize::from(a_up == b_up);
            }
            _ => counts.non_manifold += 1,
        }
    }
    counts
}
