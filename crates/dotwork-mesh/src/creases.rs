//! Sharp edges: where the faces of a mesh meet at such an angle that no smooth surface is meant.
//!
//! Normals split at an angle say more than the angle of single edges: they fall apart only where creases cut the faces
//! around a vertex into groups. One steep edge in a noisy scan cuts nothing, its faces are still joined around its ends;
//! the rim of a machined part does. So an edge counts as sharp if its two faces take different normals at either end.

use glam::Vec3;
use rayon::prelude::*;

use crate::motion::Fans;
use crate::topology::NONE;
use crate::{Mesh, normals};

/// Sharp edges of a mesh, and the normals that fall apart there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Creases {
    /// The edges, in the order of the first of their triangles.
    pub edges: Vec<Crease>,
    /// Normals that are split at the edges; empty if there are no edges.
    pub normals: Vec<Vec3>,
    /// For each triangle the normals of its corners; empty if there are no edges.
    pub corner_normals: Vec<[u32; 3]>,
    /// For each triangle which of its edges are sharp: bit `k` is the edge from corner `k` to the next; empty if there
    /// are no edges.
    pub sharp: Vec<u8>,
}

/// A sharp edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crease {
    /// Its vertices.
    pub ends: [u32; 2],
    /// Its faces: the first runs along it from the first end to the second, the other one back.
    pub faces: [u32; 2],
    /// The normals of each face at the two ends.
    pub normals: [[u32; 2]; 2],
    /// The angle between the faces' normals, degrees; below 0 where the edge is concave.
    pub angle: f32,
}

impl Mesh {
    /// The edges at which the faces' normals differ by more than `angle` degrees and which part the normals of their
    /// ends; 180 or more finds none. Edges with one face are borders, those with more than two are left out.
    pub fn creases(&self, angle: f32) -> Creases {
        if angle.is_nan() || angle >= 180.0 {
            return Creases::default();
        }
        let topology = self.topology();
        let facet = |t: u32| {
            let [a, b, c] = self.triangles[t as usize].map(|v| self.positions[v as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let cosine = angle.max(0.0).to_radians().cos();
        let steep = |t: u32, other: u32| facet(t).dot(facet(other)) < cosine;
        // Most meshes that are smooth have no steep edge: they are done after one look.
        let neighbours = topology.neighbours();
        let any = neighbours
            .par_iter()
            .enumerate()
            .any(|(t, others)| others.iter().any(|&o| o != NONE && o > t as u32 && steep(t as u32, o)));
        if !any {
            return Creases::default();
        }
        let (normals, corner_normals) = normals::normals(&self.positions, &self.triangles, &topology, angle);
        let mut edges = Vec::new();
        let mut sharp = vec![0u8; self.triangles.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                let other = neighbours[t][k];
                if other == NONE || (other as usize) < t {
                    continue;
                }
                let next = (k + 1) % 3;
                let ends = [triangle[k], triangle[next]];
                let across = self.triangles[other as usize];
                let Some(j) = (0..3).find(|&j| across[j] == ends[1] && across[(j + 1) % 3] == ends[0]) else {
                    continue;
                };
                let (here, there) = (corner_normals[t], corner_normals[other as usize]);
                let normals = [[here[k], here[next]], [there[(j + 1) % 3], there[j]]];
                if normals[0] == normals[1] {
                    continue;
                }
                sharp[t] |= 1 << k;
                sharp[other as usize] |= 1 << j;
                let (a, b) = (facet(t as u32), facet(other));
                let far = self.positions[across[(j + 2) % 3] as usize] - self.positions[ends[0] as usize];
                let angle = a.dot(b).clamp(-1.0, 1.0).acos().to_degrees();
                let angle = if a.dot(far) > 0.0 { -angle } else { angle };
                edges.push(Crease { ends, faces: [t as u32, other], normals, angle });
            }
        }
        match edges.is_empty() {
            true => Creases::default(),
            false => Creases { edges, normals, corner_normals, sharp },
        }
    }
}

impl Creases {
    /// The same edges on another pose of their mesh: which edges are sharp does not change as a surface moves, or lines
    /// would come and go.
    pub fn posed(&self, mesh: &Mesh) -> Creases {
        let fans = Fans::new(self.normals.len(), &self.corner_normals);
        let normals = fans.normals(&mesh.positions, &mesh.triangles, &self.normals);
        Creases { normals, ..self.clone() }
    }

    /// Chains of edges that are creased by more than `angle` degrees, as `(edge, reversed)`: each runs on where exactly
    /// two such edges meet, and ends at corners.
    pub fn chains(&self, angle: f32) -> Vec<Vec<(u32, bool)>> {
        let chosen: Vec<u32> =
            (0..self.edges.len() as u32).filter(|&e| self.edges[e as usize].angle.abs() > angle).collect();
        // The edges at each vertex.
        let mut at: Vec<(u32, u32)> =
            chosen.iter().flat_map(|&e| self.edges[e as usize].ends.map(|v| (v, e))).collect();
        at.sort_unstable();
        let around = |v: u32| {
            let first = at.partition_point(|a| a.0 < v);
            let count = at[first..].iter().take_while(|a| a.0 == v).count();
            &at[first..first + count]
        };
        let mut used = vec![false; self.edges.len()];
        let mut chains = Vec::new();
        for closed in [false, true] {
            for &first in &chosen {
                let ends = self.edges[first as usize].ends;
                let free = (0..2).find(|&k| closed || around(ends[k]).len() != 2);
                let (Some(from), false) = (free, used[first as usize]) else { continue };
                let mut chain = Vec::new();
                let (mut edge, mut reversed) = (first, from == 1);
                loop {
                    used[edge as usize] = true;
                    chain.push((edge, reversed));
                    let end = self.edges[edge as usize].ends[usize::from(!reversed)];
                    let here = around(end);
                    let next = here.iter().map(|a| a.1).find(|&e| !used[e as usize]);
                    match next {
                        Some(next) if here.len() == 2 => {
                            reversed = self.edges[next as usize].ends[1] == end;
                            edge = next;
                        }
                        _ => break,
                    }
                }
                chains.push(chain);
            }
        }
        chains
    }
}

#[cfg(test)]
mod tests {
    use crate::{Mesh, shapes};

    fn mesh(raw: crate::RawMesh) -> Mesh {
        Mesh::from_slices(&raw.positions, &raw.triangles).unwrap()
    }

    #[test]
    fn a_box_has_twelve_and_a_sphere_none() {
        let sheet = mesh(shapes::sheet(0.5, 4));
        let creases = sheet.creases(45.0);
        let length: f32 = creases
            .edges
            .iter()
            .map(|e| sheet.positions[e.ends[0] as usize].distance(sheet.positions[e.ends[1] as usize]))
            .sum();
        assert!((length - 4.0 * 2.5).abs() < 1e-4, "{length}");
        assert!(creases.edges.iter().all(|e| (e.angle - 90.0).abs() < 0.1), "all are convex");
        let chains = creases.chains(45.0);
        assert_eq!(chains.len(), 12, "they end in the corners");
        assert_eq!(chains.iter().map(Vec::len).sum::<usize>(), creases.edges.len());
        assert_eq!(mesh(shapes::sphere(3)).creases(45.0), Default::default());
        assert_eq!(sheet.creases(180.0), Default::default());
    }

    #[test]
    fn the_rims_of_a_cylinder_are_closed() {
        let cylinder = mesh(shapes::cylinder(1.0, 2.0, 48, 3));
        let creases = cylinder.creases(45.0);
        let chains = creases.chains(45.0);
        assert_eq!(chains.iter().map(Vec::len).collect::<Vec<_>>(), [48, 48]);
        for chain in chains {
            // Each edge begins where the last one ended.
            let ends = |&(e, reversed): &(u32, bool)| {
                let [a, b] = creases.edges[e as usize].ends;
                if reversed { [b, a] } else { [a, b] }
            };
            assert!(chain.windows(2).all(|w| ends(&w[0])[1] == ends(&w[1])[0]));
            assert_eq!(ends(&chain[47])[1], ends(&chain[0])[0]);
        }
    }

    #[test]
    fn turned_inside_out_they_are_concave() {
        let mut raw = shapes::sheet(0.5, 2);
        // A sheet with a hole keeps the winding it has.
        raw.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let options = crate::MeshOptions { orient: false, ..Default::default() };
        let room = Mesh::build(raw, &options, &mut dotwork_drawing::Warnings::new()).unwrap();
        let creases = room.creases(45.0);
        assert!(!creases.edges.is_empty() && creases.edges.iter().all(|e| e.angle < -89.0));
    }
}
