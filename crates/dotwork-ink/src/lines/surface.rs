//! What the lines of a surface need that does not depend on the eye: its borders and its sharp edges.

use dotwork_mesh::{Creases, Mesh};

use crate::lines::Ridges;

/// The lines that a surface has, from wherever it is seen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceLines {
    /// Chains of vertices where the surface ends; see [`Mesh::borders`].
    pub borders: Vec<Vec<u32>>,
    /// Sharp edges; contours run along them.
    pub creases: Creases,
    /// Chains of sharp edges, to be drawn as creases, as `(edge, reversed)`; see [`Creases::chains`].
    pub chains: Vec<Vec<(u32, bool)>>,
    /// Vertices at which sharp edges meet, in rising order: the ends of chains there are no ends of lines.
    pub joints: Vec<u32>,
    /// Creases of a surface without sharp edges.
    pub ridges: Ridges,
    /// Up to which radius of curvature an edge was looked for, object units; 0 if none was.
    pub radius: f32,
}

/// Largest radius of a ridge that is drawn, in voxels: an edge that is sharp in the body measures two to three, after
/// sampling, the gradient and the mean over neighbours.
const RADIUS: f32 = 3.5;

/// Shortest ridge that is drawn, in voxels.
const SHORTEST: f32 = 12.0;

impl SurfaceLines {
    /// Finds them. Edges of more than `angle` degrees are sharp: normals are not smooth across them. 180 finds none.
    pub fn find(mesh: &Mesh, angle: f32) -> SurfaceLines {
        let creases = mesh.creases(angle);
        let chains = creases.chains(angle);
        let mut ends: Vec<u32> = creases.edges.iter().flat_map(|edge| edge.ends).collect();
        ends.sort_unstable();
        let mut joints: Vec<u32> = ends.windows(2).filter(|w| w[0] == w[1]).map(|w| w[0]).collect();
        joints.dedup();
        SurfaceLines { borders: mesh.borders(), creases, chains, joints, ..SurfaceLines::default() }
    }

    /// The same lines on another pose of their mesh; `None` if they are the very same, as those of a smooth surface are.
    pub fn posed(&self, mesh: &Mesh) -> Option<SurfaceLines> {
        if self.creases.edges.is_empty() {
            return None;
        }
        Some(SurfaceLines { creases: self.creases.posed(mesh), ..self.clone() })
    }

    /// Finds the borders, and if `creased` the creases, of a surface in a volume with voxels of this size, object units.
    /// Steep edges of its triangles say nothing: it is smooth, and its edges are rounded.
    pub fn in_volume(mesh: &Mesh, voxel: f32, creased: bool) -> SurfaceLines {
        let radius = if creased { RADIUS * voxel } else { 0.0 };
        let ridges = if creased { Ridges::find(mesh, radius, SHORTEST * voxel) } else { Ridges::default() };
        SurfaceLines { borders: mesh.borders(), ridges, radius, ..SurfaceLines::default() }
    }
}
