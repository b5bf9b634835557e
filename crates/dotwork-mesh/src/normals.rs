//! Normals: at each vertex the facet normals around it, weighted by the angle each face has there.
//!
//! The weights make the normal independent of how the surface around the vertex is cut into triangles (G. Thürmer and
//! C. A. Wüthrich, "Computing vertex normals from polygonal facets", 1998). Each vertex gathers from its own faces in
//! ascending order, so that threads never meet and the sums are the same on any number of them.
//!
//! Below a crease angle of 180° the faces around a vertex fall into groups: two faces are in one group if a path of
//! manifold edges at the vertex joins them and no edge on it is creased. The group with the lowest face keeps the normal
//! of the vertex; each other group gets one behind those of the vertices.

use dotwork_drawing::Warnings;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::Topology;
use crate::geometry::{GRAIN, corners};
use crate::topology::NONE;

/// Faces whose normals differ by no more than rounding do not make a crease at 0°, nor does a box at 90°.
const CREASE_SLACK: f32 = 1e-6;

/// A sum of facet normals shorter than this part of its weights has cancelled: its direction is noise.
const MIN_SUM: f32 = 1e-4;

/// A face as its vertices see it.
pub(crate) struct Facet {
    normal: Vec3,
    /// The angle at each corner, radians.
    angles: [f32; 3],
}

/// The normals and, for each corner, which one it takes; the form in which [`crate::Mesh`] keeps them.
pub(crate) fn normals(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    topology: &Topology,
    crease_angle: f32,
) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let facets: Vec<Facet> = triangles.par_iter().map(|&t| facet(positions, t)).collect();
    let mut corner_normals = triangles.to_vec();
    // A crease angle that is no number splits nothing.
    if crease_angle.is_nan() || crease_angle >= 180.0 {
        let smooth = |v: u32| gather(v, topology.faces(v).iter().copied(), triangles, &facets);
        let vertices = 0..positions.len() as u32;
        return (vertices.into_par_iter().with_min_len(GRAIN).map(smooth).collect(), corner_normals);
    }
    let min_cosine = crease_angle.max(0.0).to_radians().cos() - CREASE_SLACK;
    let starts: Vec<usize> = (0..positions.len()).step_by(GRAIN).collect();
    let blocks: Vec<Block> = starts
        .into_par_iter()
        .map(|start| {
            let mut block = Block::default();
            let mut groups = Groups::default();
            for v in start..(start + GRAIN).min(positions.len()) {
                groups.find(v as u32, triangles, topology, &facets, min_cosine);
                block.add(v as u32, &groups, triangles, &facets);
            }
            block
        })
        .collect();
    let mut normals = Vec::with_capacity(positions.len());
    let mut split = Vec::new();
    for block in blocks {
        let base = (positions.len() + split.len()) as u32;
        for (t, k, index) in block.corners {
            corner_normals[t as usize][usize::from(k)] = base + index;
        }
        normals.extend(block.vertex_normals);
        split.extend(block.split_normals);
    }
    normals.append(&mut split);
    (normals, corner_normals)
}

/// Given normals, turned at the vertices where most faces were turned between `before` and `after`.
pub(crate) fn turned(given: &[[f32; 3]], before: &[[u32; 3]], after: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals: Vec<Vec3> = given.iter().map(|&n| Vec3::from_array(n)).collect();
    if before == after {
        return normals;
    }
    // Faces kept less faces turned.
    let mut balance = vec![0i32; given.len()];
    for (b, a) in before.iter().zip(after) {
        for &v in a {
            balance[v as usize] += if a == b { 1 } else { -1 };
        }
    }
    for (normal, &balance) in normals.iter_mut().zip(&balance) {
        if balance < 0 {
            *normal = -*normal;
        }
    }
    normals
}

/// Given normals at unit length; those that have no direction are taken from the computed ones.
pub(crate) fn completed(
    mut given: Vec<Vec3>,
    computed: impl FnOnce() -> Vec<Vec3>,
    warnings: &mut Warnings,
) -> Vec<Vec3> {
    let mut computed = Some(computed);
    let mut stand_in: Vec<Vec3> = Vec::new();
    let (mut count, mut first) = (0, None);
    for (v, normal) in given.iter_mut().enumerate() {
        // In double precision, since squares of short normals vanish in single.
        *normal = match normal.as_dvec3().try_normalize() {
            Some(unit) => unit.as_vec3(),
            None => {
                if let Some(computed) = computed.take() {
                    stand_in = computed();
                }
                count += 1;
                first.get_or_insert(v);
                stand_in[v]
            }
        };
    }
    let first = first.map(|v| format!("vertex {v}"));
    warnings.counted("given normals without direction replaced by computed ones", count, first);
    given
}

/// The normals of a run of vertices.
#[derive(Default)]
struct Block {
    vertex_normals: Vec<Vec3>,
    split_normals: Vec<Vec3>,
    /// Face, corner, and the index in `split_normals` it takes.
    corners: Vec<(u32, u8, u32)>,
}

impl Block {
    fn add(&mut self, v: u32, groups: &Groups, triangles: &[[u32; 3]], facets: &[Facet]) {
        if groups.members.is_empty() {
            self.vertex_normals.push(Vec3::Z);
        }
        for (rank, group) in groups.members.chunk_by(|a, b| a.0 == b.0).enumerate() {
            let faces = group.iter().map(|&(_, t)| t);
            let normal = gather(v, faces.clone(), triangles, facets);
            if rank == 0 {
                self.vertex_normals.push(normal);
                continue;
            }
            let index = self.split_normals.len() as u32;
            self.split_normals.push(normal);
            self.corners.extend(faces.map(|t| (t, corner_of(triangles[t as usize], v) as u8, index)));
        }
    }
}

/// The groups of faces around one vertex; reused from vertex to vertex.
#[derive(Default)]
struct Groups {
    /// A forest over the places in the list of faces; the root is the lowest place of a group.
    parents: Vec<u32>,
    /// Group and face, sorted.
    members: Vec<(u32, u32)>,
}

impl Groups {
    fn find(
        &mut self,
        v: u32,
        triangles: &[[u32; 3]],
        topology: &Topology,
        facets: &[Facet],
        min_cosine: f32,
    ) {
        let faces = topology.faces(v);
        let parents = &mut self.parents;
        parents.clear();
        parents.extend(0..faces.len() as u32);
        for (i, &t) in faces.iter().enumerate() {
            let k = corner_of(triangles[t as usize], v);
            for edge in [k, (k + 2) % 3] {
                let other = topology.neighbours()[t as usize][edge];
                // Each pair is met twice; once is enough.
                if other == NONE || other < t {
                    continue;
                }
                if facets[t as usize].normal.dot(facets[other as usize].normal) < min_cosine {
                    continue;
                }
                if let Ok(j) = faces.binary_search(&other) {
                    let (a, b) = (root(parents, i as u32), root(parents, j as u32));
                    parents[a.max(b) as usize] = a.min(b);
                }
            }
        }
        self.members.clear();
        self.members.extend(faces.iter().enumerate().map(|(i, &t)| (root(parents, i as u32), t)));
        self.members.sort_unstable();
    }
}

/// The lowest member of the group, halving the paths on the way.
fn root(groups: &mut [u32], mut i: u32) -> u32 {
    while groups[i as usize] != i {
        groups[i as usize] = groups[groups[i as usize] as usize];
        i = groups[i as usize];
    }
    i
}

fn corner_of(triangle: [u32; 3], v: u32) -> usize {
    if triangle[0] == v {
        0
    } else if triangle[1] == v {
        1
    } else {
        2
    }
}

/// The mean of the facet normals of `faces`, weighted by their angles at `v`; that of the first face where they cancel.
fn gather(
    v: u32,
    faces: impl Iterator<Item = u32> + Clone,
    triangles: &[[u32; 3]],
    facets: &[Facet],
) -> Vec3 {
    // A vertex without faces, which a built mesh does not have, still needs some unit vector.
    let first = faces.clone().next().map_or(Vec3::Z, |t| facets[t as usize].normal);
    weighted(faces.map(|t| (&facets[t as usize], corner_of(triangles[t as usize], v))), first)
}

/// The mean of the normals of facets, weighted by their angles at the given corner; `otherwise` where they cancel.
pub(crate) fn weighted<'a>(facets: impl Iterator<Item = (&'a Facet, usize)>, otherwise: Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    let mut weights = 0.0;
    for (facet, corner) in facets {
        let weight = facet.angles[corner];
        sum += weight * facet.normal;
        weights += weight;
    }
    let length = sum.length();
    if length > MIN_SUM * weights { sum / length } else { otherwise }
}

pub(crate) fn facet(positions: &[Vec3], triangle: [u32; 3]) -> Facet {
    let [a, b, c] = corners(positions, triangle);
    let [ab, bc, ca] = [b - a, c - b, a - c].map(DVec3::normalize_or_zero);
    let normal = (b - a).cross(c - a).normalize_or(DVec3::Z).as_vec3();
    let angle = |u: DVec3, v: DVec3| (-u.dot(v) as f32).clamp(-1.0, 1.0).acos();
    Facet { normal, angles: [angle(ca, ab), angle(ab, bc), angle(bc, ca)] }
}
