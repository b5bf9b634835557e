//! The point hierarchy of Meruvia Pastor et al. 2003: one seamless order of points on a mesh, from a few to as many as
//! are wanted.
//!
//! Steps (section IV): the vertices of the input are *randomised*; *edge collapses* down to a few vertices order them;
//! *longest-edge splits* make more, each randomised and *projected* onto the input. Read backwards, the collapses go on
//! where the splits leave off: every point lies amid points that came before it.
//!
//! Where this goes beyond the paper: the two sequences are merged by the length of their edges instead of put end to
//! end, so that a mesh whose own triangles differ in size is covered evenly all the same; the split mesh is kept
//! Delaunay around new vertices by flips; and of the two ends of a collapsed edge the more crowded one goes.

mod collapse;
mod list;
mod project;
mod queues;
mod randomise;
mod split;
mod spread;

use dotwork_drawing::hash::hash2;
use glam::Vec3;
use rayon::prelude::*;

use crate::topology::NONE;
use crate::{Mesh, Topology};
use collapse::{Collapsed, collapse, links};
use project::{Ground, Hit};
use randomise::randomise;
use split::{Splits, Splitter};
pub use spread::SPREAD;

/// The key of a collapse over that of a split, where both leave a mesh of the same density: measured on plates.
const SPLIT_SCALE: f32 = 0.45;

/// A split that lies nearer than this share of its key to an earlier point comes later than its edge says.
const NEAREST: f32 = 0.8;

/// Before the collapses, edges longer than this many hexagonal spacings of the input's vertices are split, so that what
/// is collapsed is a mesh of triangles that differ little …
const EVEN: f64 = 2.2;
/// … as if it had so many vertices at least.
const FEWEST: usize = 16_384;

/// Edges are never split below this share of the hexagonal spacing of the points that are wanted.
const FLOOR: f64 = 0.5;

/// What a hierarchy is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HierarchySettings {
    /// Number of points.
    pub points: usize,
    /// How far vertices are moved at random, 0 (not at all) to 1.
    pub randomise: f32,
    /// Seed of every random choice.
    pub seed: u32,
}

/// An order of points on a mesh, in structure-of-arrays form.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    /// Mean distance of each point to its relevant neighbours, made non-increasing along the order, object units;
    /// above 0.
    pub radius: Vec<f32>,
    /// What each point is: a vertex of the mesh, or split `k` as `vertices + k`.
    pub number: Vec<u32>,
    /// The face of the mesh on which it lies.
    pub face: Vec<u32>,
    /// Barycentric coordinates of the face's second and third corner.
    pub weights: Vec<[f32; 2]>,
    /// Its relevant neighbours, well spread, the nearest first, as earlier places of this order; `u32::MAX` for none.
    pub neighbours: Vec<[u32; SPREAD]>,
}

/// Orders the vertices of `mesh` and makes more, until there are `settings.points`; fewer where the mesh cannot be split
/// any further, as rounding ends it. `progress` is called with a share 0…1.
pub fn hierarchy(mesh: &Mesh, settings: &HierarchySettings, mut progress: impl FnMut(f32)) -> Hierarchy {
    let HierarchySettings { points, randomise: strength, seed } = *settings;
    if points == 0 || mesh.triangles.is_empty() {
        return Hierarchy::default();
    }
    let strength = strength.clamp(0.0, 1.0);
    let inner = Inner::new(mesh);
    let topology = Topology::new(inner.positions.len(), &inner.triangles);
    let ground = Ground::new(&inner.positions, &inner.triangles, topology.neighbours());
    let (places, links) = rayon::join(
        || randomise(&ground, &inner.positions, &inner.triangles, &topology, strength, hash2(seed, 1)),
        || links(&topology, &inner.triangles, inner.positions.len()),
    );
    let vertices = places.len();
    progress(0.1);

    let spacing = |points: usize| (2.0 / 3f64.sqrt() * inner.area / points.max(1) as f64).sqrt();
    let even = (EVEN * spacing(vertices.max(FEWEST))) as f32;
    // Steps of the splitter are narrower than this tenth.
    let floor = ((FLOOR * spacing(points)) as f32).min(0.9 * even);
    let mut splitter = Splitter::new(&ground, &inner.triangles, &places, floor, strength, hash2(seed, 2));
    // This depends on the mesh alone: however many points are wanted, the same ones are collapsed.
    splitter.run(|_, length| length < even);
    progress(0.2);
    let base: Vec<Vec3> = (0..splitter.vertices() as u32).map(|v| splitter.position(v)).collect();
    let triangles = splitter.triangles();
    // Whatever the collapses say, that many splits are needed; meanwhile the collapses run.
    let surely = points.saturating_sub(vertices);
    let (collapsed, ()) = rayon::join(
        || collapse(&base, &triangles, &links, hash2(seed, 3)),
        || splitter.run(|splits, _| splits >= surely),
    );
    progress(0.7);
    let mut keys = Keys::new(&collapsed);
    loop {
        keys.extend(&splitter);
        let (have, done) = keys.count(&splitter);
        if done || have >= points {
            break;
        }
        let wanted = splitter.out.key.len() + points - have;
        splitter.run(|splits, _| splits >= wanted);
    }
    progress(0.9);
    let out = merge(&inner, &places, &collapsed, &keys, &splitter.out, points);
    progress(1.0);
    out
}

/// The mesh as it is worked on: in a box of size 1, since products of four lengths must not vanish, and in Morton order,
/// so that neighbours in space are neighbours in memory.
struct Inner {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    /// The mesh's own numbers.
    vertex: Vec<u32>,
    face: Vec<u32>,
    /// How many vertices the mesh has; those without faces are not here.
    vertices: usize,
    size: f32,
    area: f64,
}

impl Inner {
    fn new(mesh: &Mesh) -> Inner {
        let bounds = mesh.bounds();
        let size = bounds.size().max_element().max(f32::MIN_POSITIVE);
        let mut used = vec![false; mesh.positions.len()];
        mesh.triangles.as_flattened().iter().for_each(|&v| used[v as usize] = true);
        let mut order: Vec<u64> = (0..mesh.positions.len())
            .into_par_iter()
            .filter(|&v| used[v])
            .map(|v| {
                let cell = (mesh.positions[v] - bounds.min) / size * 1023.0;
                u64::from(morton(cell.x as u32, cell.y as u32, cell.z as u32)) << 32 | v as u64
            })
            .collect();
        order.par_sort_unstable();
        let vertex: Vec<u32> = order.iter().map(|&key| key as u32).collect();
        let mut inner = vec![NONE; mesh.positions.len()];
        for (i, &v) in vertex.iter().enumerate() {
            inner[v as usize] = i as u32;
        }
        let mut order: Vec<u64> = mesh
            .triangles
            .par_iter()
            .enumerate()
            .map(|(t, corners)| {
                let first = corners.iter().map(|&v| inner[v as usize]).min().unwrap_or(0);
                u64::from(first) << 32 | t as u64
            })
            .collect();
        order.par_sort_unstable();
        let face: Vec<u32> = order.iter().map(|&key| key as u32).collect();
        Inner {
            positions: vertex.par_iter().map(|&v| (mesh.positions[v as usize] - bounds.min) / size).collect(),
            triangles: face
                .par_iter()
                .map(|&t| mesh.triangles[t as usize].map(|v| inner[v as usize]))
                .collect(),
            vertex,
            face,
            vertices: mesh.positions.len(),
            size,
            area: mesh.area() / f64::from(size).powi(2),
        }
    }
}

/// When each point of the hierarchy comes: the larger its key, the earlier. Points are numbered as the splitter does:
/// vertices, then splits.
struct Keys {
    /// Of the vertices and splits that were collapsed, then of later splits.
    of: Vec<f32>,
}

impl Keys {
    fn new(collapsed: &Collapsed) -> Keys {
        let mut of = vec![0.0; collapsed.vertex.len()];
        for (&v, &key) in collapsed.vertex.iter().zip(&collapsed.key) {
            of[v as usize] = key;
        }
        Keys { of }
    }

    /// Gives keys to new splits. Of two points that are too near to each other for their keys the later one has to wait.
    fn extend(&mut self, splitter: &Splitter) {
        let Splits { key, neighbours, .. } = &splitter.out;
        let vertices = splitter.vertices() - key.len();
        for k in self.of.len() - vertices..key.len() {
            let at = splitter.position((vertices + k) as u32);
            let mut own = key[k] * SPLIT_SCALE;
            for &w in neighbours[k].iter().filter(|&&w| w != NONE) {
                let near = at.distance(splitter.position(w)) / NEAREST;
                let of_other = &mut self.of[w as usize];
                if *of_other >= own {
                    own = own.min(near);
                } else {
                    *of_other = of_other.min(near);
                }
            }
            self.of.push(own);
        }
    }

    /// How many points no later split will come before, and whether there are no later ones.
    fn count(&self, splitter: &Splitter) -> (usize, bool) {
        let Some(length) = splitter.next_length() else { return (0, true) };
        let bound = SPLIT_SCALE * length;
        (self.of.par_iter().filter(|&&key| key >= bound).count(), false)
    }
}

/// Merges the collapses, read backwards, with the splits.
fn merge(
    inner: &Inner,
    places: &[Hit],
    collapsed: &Collapsed,
    keys: &Keys,
    splits: &Splits,
    points: usize,
) -> Hierarchy {
    // The first `base` points were collapsed.
    let (vertices, base) = (places.len(), collapsed.vertex.len());
    let point = |i: usize| if i < base { collapsed.vertex[base - 1 - i] } else { i as u32 };
    let mut order: Vec<u64> = (0..keys.of.len())
        .into_par_iter()
        .map(|i| u64::from(!keys.of[point(i) as usize].to_bits()) << 32 | i as u64)
        .collect();
    order.par_sort_unstable();
    order.truncate(points);
    let point = |key: u64| point(key as u32 as usize);
    let mut place = vec![NONE; keys.of.len()];
    for (at, &key) in order.iter().enumerate() {
        place[point(key) as usize] = at as u32;
    }
    // An earlier point that stands for a neighbour: itself, or what it was collapsed into.
    let earlier = |mut of: u32, than: u32| loop {
        let at = place[of as usize];
        if at < than {
            return at;
        }
        match collapsed.into.get(of as usize) {
            Some(&heir) if heir != of => of = heir,
            _ => return NONE,
        }
    };
    let neighbours = order
        .par_iter()
        .enumerate()
        .map(|(at, &key)| {
            let given = match key as u32 as usize {
                i if i < base => collapsed.neighbours[base - 1 - i],
                i => splits.neighbours[i - vertices],
            };
            let mut kept = [NONE; SPREAD];
            let mut n = 0;
            for of in given.into_iter().filter(|&of| of != NONE) {
                let earlier = earlier(of, at as u32);
                if earlier != NONE && !kept[..n].contains(&earlier) {
                    kept[n] = earlier;
                    n += 1;
                }
            }
            kept
        })
        .collect();
    let mut radius: Vec<f32> = order
        .par_iter()
        .map(|&key| {
            let radius = match key as u32 as usize {
                i if i < base => collapsed.radius[base - 1 - i],
                i => splits.radius[i - vertices],
            };
            radius.max(SMALLEST) * inner.size
        })
        .collect();
    // The order is that of the process; the distances, sorted, go along it.
    radius.par_sort_unstable_by(|a, b| b.total_cmp(a));
    let of = |&key: &u64| {
        let point = point(key) as usize;
        let (face, weights) = match point.checked_sub(vertices) {
            Some(k) => (splits.face[k], splits.weights[k]),
            None => (places[point].face, places[point].weights),
        };
        (inner.face[face as usize], weights)
    };
    let (face, weights) = order.par_iter().map(of).unzip();
    let number = order
        .par_iter()
        .map(|&key| match point(key) as usize {
            v if v < vertices => inner.vertex[v],
            k => (k - vertices + inner.vertices) as u32,
        })
        .collect();
    Hierarchy { radius, number, face, weights, neighbours }
}

/// Smallest radius, over the size of the mesh.
const SMALLEST: f32 = 1e-7;

/// Interleaves the low ten bits of three numbers.
fn morton(x: u32, y: u32, z: u32) -> u32 {
    let spread = |v: u32| {
        let v = v & 0x3ff;
        let v = (v | v << 16) & 0x0300_00ff;
        let v = (v | v << 8) & 0x0300_f00f;
        let v = (v | v << 4) & 0x030c_30c3;
        (v | v << 2) & 0x0924_9249
    };
    spread(x) | spread(y) << 1 | spread(z) << 2
}
