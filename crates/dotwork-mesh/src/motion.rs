//! Meshes that move: their triangles stay, their vertices go elsewhere.
//!
//! Whoever knows how (a glTF file with its skins and morph targets, a sequence of meshes) is a [`Motion`]: it places all
//! vertices at a time. A [`MovingMesh`] is the mesh in one pose, put in order once; in any other pose only places and
//! normals are made anew, so that whatever sits on a triangle by barycentric coordinates moves along with it (Meruvia
//! Pastor et al. 2003, section V-C).

use std::fmt::Debug;
use std::sync::Arc;

use dotwork_drawing::{Standpoint, Warnings};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::GRAIN;
use crate::{Mesh, MeshError, MeshOptions, RawMesh, normals};

/// One of the animations that a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Its name; its number where the file has none.
    pub name: String,
    /// How long it lasts, seconds.
    pub seconds: f64,
}

/// What moves the vertices of a mesh, and the cameras that come with it.
pub trait Motion: Debug + Send + Sync {
    /// The animations that there are.
    fn clips(&self) -> &[Clip];

    /// Where all vertices of the [`RawMesh`] are at `time` seconds of a clip, or at rest: relative to its origin, in its
    /// order. Before its begin and after its end a clip stands still.
    ///
    /// # Panics
    /// If there is no such clip.
    fn place(&self, clip: Option<usize>, time: f64, positions: &mut Vec<[f32; 3]>);

    /// The names of the cameras that come with it.
    fn cameras(&self) -> &[String] {
        &[]
    }

    /// What a camera sees at a time; `None` if there is no such camera, or it has lost its direction.
    fn standpoint(&self, _camera: usize, _clip: Option<usize>, _time: f64) -> Option<Standpoint> {
        None
    }
}

/// A mesh in order that can take any pose.
#[derive(Clone, Debug)]
pub struct MovingMesh {
    reference: Arc<Mesh>,
    /// The vertex of the raw mesh that each vertex was.
    sources: Vec<u32>,
    fans: Fans,
    /// Area of each triangle in the reference pose, object units squared.
    areas: Vec<f32>,
}

impl MovingMesh {
    /// Puts a mesh in order in the pose that it has: the *reference*.
    ///
    /// # Errors
    /// As [`Mesh::build`].
    pub fn build(
        raw: RawMesh,
        options: &MeshOptions,
        warnings: &mut Warnings,
    ) -> Result<MovingMesh, MeshError> {
        let (reference, sources) = Mesh::build_tracked(raw, options, warnings)?;
        let fans = Fans::new(reference.normals.len(), &reference.corner_normals);
        let areas = areas(&reference);
        Ok(MovingMesh { reference: Arc::new(reference), sources, fans, areas })
    }

    /// The mesh in the pose that it was put in order in.
    pub fn reference(&self) -> &Arc<Mesh> {
        &self.reference
    }

    /// The mesh with the vertices of the raw mesh at `positions`; a place that is no finite number stays that of the
    /// reference.
    ///
    /// # Panics
    /// If there are fewer positions than the raw mesh had.
    pub fn posed(&self, positions: &[[f32; 3]]) -> Mesh {
        let old = &*self.reference;
        let positions: Vec<Vec3> = self.places(positions).collect();
        let normals = self.fans.normals(&positions, &old.triangles, &old.normals);
        Mesh {
            positions,
            normals,
            triangles: old.triangles.clone(),
            corner_normals: old.corner_normals.clone(),
            origin: old.origin,
            closed: old.closed,
            colors: old.colors.clone(),
            paint: old.paint.clone(),
        }
    }

    /// Where the vertices of this mesh are with those of the raw mesh at `positions`, as in [`MovingMesh::posed`].
    ///
    /// # Panics
    /// As there.
    pub fn places<'a>(
        &'a self,
        positions: &'a [[f32; 3]],
    ) -> impl ExactSizeIterator<Item = Vec3> + Clone + 'a {
        self.sources.iter().zip(&self.reference.positions).map(|(&source, &rest)| {
            let p = Vec3::from_array(positions[source as usize]);
            if p.is_finite() { p } else { rest }
        })
    }

    /// How large each triangle is in another pose, as a share of its area in the reference.
    ///
    /// # Panics
    /// If `posed` is not from [`MovingMesh::posed`] of this mesh.
    pub fn stretch(&self, posed: &Mesh) -> Vec<f32> {
        let now = areas(posed);
        assert_eq!(now.len(), self.areas.len(), "the same triangles");
        now.iter().zip(&self.areas).map(|(now, then)| now / then.max(f32::MIN_POSITIVE)).collect()
    }
}

/// Which corners of triangles take each normal.
#[derive(Clone, Debug)]
pub(crate) struct Fans {
    /// The corners (3 · triangle + corner) that take normal `n` are `corners[start[n]..start[n + 1]]`, ascending.
    start: Vec<u32>,
    corners: Vec<u32>,
}

impl Fans {
    /// Turns `corner_normals`, the normal of each corner, round.
    pub(crate) fn new(count: usize, corner_normals: &[[u32; 3]]) -> Fans {
        let mut start = vec![0u32; count + 1];
        let all = corner_normals.as_flattened();
        for &n in all {
            start[n as usize + 1] += 1;
        }
        for n in 1..start.len() {
            start[n] += start[n - 1];
        }
        let mut cursor = start.clone();
        let mut corners = vec![0u32; all.len()];
        for (&n, corner) in all.iter().zip(0u32..) {
            let slot = &mut cursor[n as usize];
            corners[*slot as usize] = corner;
            *slot += 1;
        }
        Fans { start, corners }
    }

    /// The normals with the vertices at `positions`; where facets cancel, as in `rest`.
    pub(crate) fn normals(&self, positions: &[Vec3], triangles: &[[u32; 3]], rest: &[Vec3]) -> Vec<Vec3> {
        let facets: Vec<normals::Facet> =
            triangles.par_iter().with_min_len(GRAIN).map(|&t| normals::facet(positions, t)).collect();
        let normal = |(n, &rest): (usize, &Vec3)| {
            let corners = &self.corners[self.start[n] as usize..self.start[n + 1] as usize];
            normals::weighted(corners.iter().map(|&c| (&facets[c as usize / 3], c as usize % 3)), rest)
        };
        rest.par_iter().with_min_len(GRAIN).enumerate().map(normal).collect()
    }
}

fn areas(mesh: &Mesh) -> Vec<f32> {
    let area = |&t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
        (0.5 * (b - a).cross(c - a).length()) as f32
    };
    mesh.triangles.par_iter().with_min_len(GRAIN).map(area).collect()
}

/// The area of triangles over `positions`, object units squared: what tells one pose of a mesh from another before it is
/// put in order.
pub fn area_of(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
    let at = |v: u32| positions.get(v as usize).map_or(DVec3::ZERO, |&p| Vec3::from_array(p).as_dvec3());
    let area = |&t: &[u32; 3]| {
        let [a, b, c] = t.map(at);
        0.5 * (b - a).cross(c - a).length()
    };
    // In chunks of one size, so that the sum is the same on any number of threads.
    let parts: Vec<f64> = triangles.par_chunks(GRAIN).map(|part| part.iter().map(area).sum()).collect();
    parts.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    fn options(crease_angle: f32) -> MeshOptions {
        MeshOptions { crease_angle, ..MeshOptions::default() }
    }

    #[test]
    fn a_pose_is_what_building_it_would_give() {
        for crease_angle in [180.0, 40.0] {
            let raw = shapes::demo("teapot").unwrap();
            let bent = |p: &[f32; 3]| {
                let angle = 0.3 * p[1];
                let (s, c) = angle.sin_cos();
                [c * p[0] - s * p[2], 1.5 * p[1], s * p[0] + c * p[2]]
            };
            let positions: Vec<[f32; 3]> = raw.positions.iter().map(bent).collect();
            let moving =
                MovingMesh::build(raw.clone(), &options(crease_angle), &mut Warnings::new()).unwrap();
            let same = moving.posed(&raw.positions);
            assert_eq!(same.positions, moving.reference().positions);
            let furthest = |a: &Mesh, b: &Mesh| {
                let differences = a.normals.iter().zip(&b.normals).map(|(a, b)| (*a - *b).length());
                differences.fold(0.0, f32::max)
            };
            assert!(furthest(&same, moving.reference()) < 1e-6);
            let posed = moving.posed(&positions);
            // A crease that opens or closes splits other normals: only a smooth mesh can be compared.
            if crease_angle == 180.0 {
                let built =
                    Mesh::build(RawMesh { positions, ..raw }, &options(crease_angle), &mut Warnings::new())
                        .unwrap();
                assert_eq!(posed.positions, built.positions);
                assert!(furthest(&posed, &built) < 1e-5);
            }
        }
    }

    #[test]
    fn stretch_is_the_change_of_area() {
        let raw = shapes::sphere(2);
        let moving = MovingMesh::build(raw.clone(), &options(180.0), &mut Warnings::new()).unwrap();
        let doubled: Vec<[f32; 3]> = raw.positions.iter().map(|p| p.map(|c| 2.0 * c)).collect();
        let posed = moving.posed(&doubled);
        assert!(moving.stretch(&posed).iter().all(|s| (s - 4.0).abs() < 1e-3));
        assert!((area_of(&doubled, &raw.triangles) - posed.area()).abs() < 1e-3);
    }

    #[test]
    fn what_moves_apart_is_not_welded() {
        // Two squares side by side, with vertices of their own along the seam.
        let raw = RawMesh {
            positions: vec![
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
                [1.0, 0.0, 0.0],
                [2.0, 0.0, 0.0],
                [2.0, 1.0, 0.0],
                [1.0, 1.0, 0.0],
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..RawMesh::default()
        };
        let vertices = |tracks: Vec<u64>| {
            let raw = RawMesh { tracks, ..raw.clone() };
            let moving = MovingMesh::build(raw, &options(180.0), &mut Warnings::new()).unwrap();
            moving.reference().positions.len()
        };
        assert_eq!(vertices(vec![0; 8]), 6);
        assert_eq!(vertices(vec![1, 1, 1, 1, 2, 2, 2, 2]), 8);
        assert_eq!(vertices(vec![1, 1, 1, 1, 2, 2, 2, 1]), 7, "they hang together at one vertex");
    }

    #[test]
    fn places_that_are_no_numbers_stay() {
        let raw = shapes::sphere(1);
        let moving = MovingMesh::build(raw.clone(), &options(180.0), &mut Warnings::new()).unwrap();
        let mut positions = raw.positions.clone();
        positions[0] = [f32::NAN, f32::INFINITY, 0.0];
        let posed = moving.posed(&positions);
        assert!(posed.positions.iter().all(|p| p.is_finite()));
        assert!(posed.normals.iter().all(|n| n.is_normalized()));
    }
}
