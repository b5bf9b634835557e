//! Edge collapse from the input mesh down to a few vertices, nearest first.
//!
//! What a collapse needs to know of a mesh is who neighbours whom: contracting an edge of the graph of vertices gives
//! the very neighbours that collapsing it in the mesh gives. So each vertex has one short list of its neighbours, sorted
//! by distance, and faces are not touched. A collapse writes two lists: that of the vertex removed is spliced into that
//! of the survivor; others hear of it when they are next looked at, by a chain of forwards with path halving. Nothing is
//! searched, nothing is allocated, any graph will do: borders, edges with many faces, loose parts.
//!
//! Lists hold the nearest [`LIST`]; a mesh has six neighbours a vertex in the mean, and the hub of a fan does not need
//! its thousands.
//!
//! The shortest edge is found in rounds: distances up to a bound are served in one pass over the vertices that are left,
//! then the bound grows by [`STEP`]. "Nearest first" thereby holds to within that factor.

use dotwork_drawing::hash::{hash2, unit};
use glam::Vec3;
use rayon::prelude::*;

use super::list::{EMPTY, LIST, List, distance, entries, entry, insert, mean, vertex};
use super::queues::Queues;
use super::spread::{SPREAD, spread};
use crate::Topology;
use crate::geometry::GRAIN;
use crate::topology::faces_by_vertex;

/// Bits of a distance that are dropped for its step: 16 steps an octave, 3 to 6 % apart.
const STEP_SHIFT: u32 = 23 - 4;

/// The step of infinity: vertices without neighbours wait for it.
const NEVER: u16 = (f32::INFINITY.to_bits() >> STEP_SHIFT) as u16;

/// Distances count as up to this much longer, by lot.
const CHANCE: f32 = 0.02;

/// Vertices that are left in the end.
const LAST: usize = 4;

/// What the collapses leave behind, in the order in which vertices were removed: nearest first, and the survivors last.
#[derive(Default)]
pub(super) struct Collapsed {
    /// The vertex removed.
    pub vertex: Vec<u32>,
    /// Length of the edge that was collapsed, made non-decreasing, object units.
    pub key: Vec<f32>,
    /// Mean distance to the neighbours just before, object units.
    pub radius: Vec<f32>,
    /// Some of them, well spread; [`NONE`] for none.
    pub neighbours: Vec<[u32; SPREAD]>,
    /// For each vertex the one that it was collapsed into; itself for survivors.
    pub into: Vec<u32>,
}

/// The graph of vertices that are left.
struct Graph<'a> {
    positions: &'a [Vec3],
    near: Vec<List>,
    /// The vertex that took the place of each; itself while it is there.
    forward: Vec<u32>,
}

impl Graph<'_> {
    /// The vertex that stands for `v` now.
    #[inline(always)]
    fn find(&mut self, mut v: u32) -> u32 {
        loop {
            let up = self.forward[v as usize];
            if up == v {
                return v;
            }
            let above = self.forward[up as usize];
            self.forward[v as usize] = above;
            v = above;
        }
    }

    #[inline(always)]
    fn between(&self, v: u32, w: u32) -> f32 {
        self.positions[v as usize].distance(self.positions[w as usize])
    }

    /// Brings the list of `v` up to date: what was removed gives way to what took its place.
    #[inline(always)]
    fn update(&mut self, v: u32) {
        let old = self.near[v as usize];
        if entries(&old).all(|e| self.forward[vertex(e) as usize] == vertex(e)) {
            return;
        }
        let mut new = [EMPTY; LIST];
        for e in entries(&old) {
            let w = self.find(vertex(e));
            if w == vertex(e) {
                insert(&mut new, e);
            } else if w != v {
                insert(&mut new, entry(self.between(v, w), w));
            }
        }
        self.near[v as usize] = new;
    }

    /// Takes `gone` away; `heir` inherits its neighbours.
    #[inline(always)]
    fn contract(&mut self, gone: u32, heir: u32) {
        self.forward[gone as usize] = heir;
        let inherited = self.near[gone as usize];
        let mut list = [EMPTY; LIST];
        for e in entries(&self.near[heir as usize]).filter(|&e| vertex(e) != gone) {
            insert(&mut list, e);
        }
        for w in entries(&inherited).map(vertex).filter(|&w| w != heir) {
            insert(&mut list, entry(self.between(heir, w), w));
        }
        self.near[heir as usize] = list;
    }
}

/// The lists of a mesh: for each vertex those it shares a face with, and those it has a link to.
fn lists(positions: &[Vec3], triangles: &[[u32; 3]], links: &[(u32, u32)]) -> Vec<List> {
    let (start, faces) = faces_by_vertex(positions.len(), triangles);
    (0..positions.len() as u32)
        .into_par_iter()
        .with_min_len(GRAIN)
        .map(|v| {
            let at = positions[v as usize];
            let mut list = [EMPTY; LIST];
            let mut put = |w: u32| insert(&mut list, entry(at.distance(positions[w as usize]), w));
            for &t in &faces[start[v as usize] as usize..start[v as usize + 1] as usize] {
                triangles[t as usize].into_iter().filter(|&w| w != v).for_each(&mut put);
            }
            let from = links.partition_point(|&(a, _)| a < v);
            links[from..].iter().take_while(|&&(a, _)| a == v).for_each(|&(_, w)| put(w));
            list
        })
        .collect()
}

/// Links between the loose parts of a mesh, sorted, both ways: without them a part of the size of a speck would keep a
/// vertex to the very end. As vertices are numbered, the one in the middle of each part is linked to the nearest ones
/// before and after it that belong to other parts.
pub(super) fn links(topology: &Topology, triangles: &[[u32; 3]], vertices: usize) -> Vec<(u32, u32)> {
    let components = topology.components(triangles);
    if components.count < 2 {
        return Vec::new();
    }
    let label =
        |v: usize| topology.faces(v as u32).first().map_or(0, |&t| components.labels[t as usize] as usize);
    let mut sizes = vec![0usize; components.count];
    (0..vertices).for_each(|v| sizes[label(v)] += 1);
    let mut seen = vec![0usize; components.count];
    let mut links = Vec::with_capacity(4 * components.count);
    let mut start = 0;
    while start < vertices {
        let own = label(start);
        let end = start + (start..vertices).take_while(|&v| label(v) == own).count();
        let middle = sizes[own] / 2;
        if (seen[own]..seen[own] + end - start).contains(&middle) {
            let at = (start + middle - seen[own]) as u32;
            for other in [start.checked_sub(1), Some(end).filter(|&e| e < vertices)].into_iter().flatten() {
                links.extend([(at, other as u32), (other as u32, at)]);
            }
        }
        seen[own] += end - start;
        start = end;
    }
    links.sort_unstable();
    links
}

/// Collapses edges until [`LAST`] vertices or no edges are left.
///
/// `links` are further edges, sorted, both ways; `positions`, by vertex, should lie in memory as they lie in space.
pub(super) fn collapse(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    links: &[(u32, u32)],
    seed: u32,
) -> Collapsed {
    let n = positions.len();
    let near = lists(positions, triangles, links);
    let mut graph = Graph { positions, near, forward: (0..n as u32).collect() };
    let at = |v: u32| positions[v as usize];
    // A little chance in the distances: where many are equal, as in grids, no direction comes first.
    let chance = |v: u32| 1.0 + CHANCE * unit(hash2(v, seed));
    let step_of = |list: &List, v: u32| match list[0] {
        EMPTY => NEVER,
        e => ((distance(e) * chance(v)).to_bits() >> STEP_SHIFT) as u16,
    };
    let mut step: Vec<u16> = (0..n as u32)
        .into_par_iter()
        .with_min_len(GRAIN)
        .map(|v| step_of(&graph.near[v as usize], v))
        .collect();
    let mut queues = Queues::new(NEVER, &step);
    let mut out = Collapsed {
        vertex: Vec::with_capacity(n),
        key: Vec::with_capacity(n),
        radius: Vec::with_capacity(n),
        neighbours: Vec::with_capacity(n),
        into: (0..n as u32).collect(),
    };
    let mut reached = 0.0f32;
    'steps: for now in 0..NEVER {
        let mut next = 0;
        while let Some(v) = queues.get(now, next) {
            next += 1;
            // Removed since, or waiting elsewhere.
            if graph.forward[v as usize] != v || step[v as usize] != now {
                continue;
            }
            if out.vertex.len() + LAST >= n {
                break 'steps;
            }
            graph.update(v);
            let list = graph.near[v as usize];
            let later = step_of(&list, v);
            if later > now {
                step[v as usize] = later;
                queues.push(later, v);
                continue;
            }
            let u = vertex(list[0]);
            graph.update(u);
            // The more crowded of the two goes.
            let (gone, heir) = if mean(&list) <= mean(&graph.near[u as usize]) { (v, u) } else { (u, v) };
            reached = reached.max(distance(list[0]));
            let ring = graph.near[gone as usize];
            out.vertex.push(gone);
            out.key.push(reached);
            out.radius.push(mean(&ring));
            out.neighbours.push(spread(at(gone), entries(&ring).map(vertex), at));
            out.into[gone as usize] = heir;
            graph.contract(gone, heir);
            let of_heir = step_of(&graph.near[heir as usize], heir).max(now);
            // One that waits for a later step than it should is called earlier; the other way round it finds out itself.
            if heir == v || of_heir < step[heir as usize] {
                step[heir as usize] = of_heir;
                queues.push(of_heir, heir);
            }
        }
        queues.clear(now);
    }
    for v in (0..n as u32).filter(|&v| out.into[v as usize] == v).collect::<Vec<_>>() {
        graph.update(v);
        let list = graph.near[v as usize];
        reached = reached.max(if list[0] == EMPTY { 0.0 } else { distance(list[0]) });
        out.vertex.push(v);
        out.key.push(reached);
        out.radius.push(mean(&list));
        out.neighbours.push(spread(at(v), entries(&list).map(vertex), at));
    }
    debug_assert_eq!(out.vertex.len(), n);
    out
}
