//! The borders of open surfaces, as chains of vertices.

use crate::Mesh;

impl Mesh {
    /// Chains of vertices along edges that have one face only, in the direction of that face; a closed chain repeats
    /// its first vertex. Computed anew on each call; empty for closed surfaces.
    pub fn borders(&self) -> Vec<Vec<u32>> {
        if self.closed {
            return Vec::new();
        }
        let topology = self.topology();
        let mut edges = Vec::new();
        for triangle in &self.triangles {
            for k in 0..3 {
                let (from, to) = (triangle[k], triangle[(k + 1) % 3]);
                if topology.edge_faces(&self.triangles, from, to).count() == 1 {
                    edges.push((from, to));
                }
            }
        }
        edges.sort_unstable();
        let mut used = vec![false; edges.len()];
        let next = |used: &[bool], from: u32| {
            let first = edges.partition_point(|e| e.0 < from);
            (first..edges.len()).take_while(|&i| edges[i].0 == from).find(|&i| !used[i])
        };
        // Chains that begin somewhere first, then the closed ones.
        let mut ends: Vec<u32> = edges.iter().map(|e| e.1).collect();
        ends.sort_unstable();
        let mut chains = Vec::new();
        for closed in [false, true] {
            for i in 0..edges.len() {
                if used[i] || (!closed && ends.binary_search(&edges[i].0).is_ok()) {
                    continue;
                }
                let mut chain = vec![edges[i].0];
                let mut at = Some(i);
                while let Some(i) = at {
                    used[i] = true;
                    chain.push(edges[i].1);
                    at = next(&used, edges[i].1);
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

    #[test]
    fn a_plate_has_one_closed_border_and_a_sphere_none() {
        let plate = shapes::demo("plate").unwrap();
        let plate = Mesh::from_slices(&plate.positions, &plate.triangles).unwrap();
        let borders = plate.borders();
        assert_eq!(borders.len(), 1);
        assert_eq!(borders[0].first(), borders[0].last());
        let length: f32 = borders[0]
            .windows(2)
            .map(|w| plate.positions[w[0] as usize].distance(plate.positions[w[1] as usize]))
            .sum();
        assert!((length - 4.0).abs() < 1e-4, "{length}");
        let sphere = shapes::demo("sphere").unwrap();
        assert!(Mesh::from_slices(&sphere.positions, &sphere.triangles).unwrap().borders().is_empty());
    }

    #[test]
    fn a_tube_has_two_and_a_triangle_is_its_own() {
        let torus = shapes::torus(1.0, 0.4, 24, 12);
        let half: Vec<[u32; 3]> = torus
            .triangles
            .iter()
            .copied()
            .filter(|t| t.iter().all(|&v| torus.positions[v as usize][0] >= -1e-3))
            .collect();
        assert_eq!(Mesh::from_slices(&torus.positions, &half).unwrap().borders().len(), 2);
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(Mesh::from_slices(&corners, &[[0, 1, 2]]).unwrap().borders(), [[0, 1, 2, 0]]);
    }
}
