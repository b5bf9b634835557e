//! The stock: the stipples a bake made, ready to be asked for by spacing.

use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

/// What a bake returns: an order of places, each with the spacing at which it enters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Baked {
    /// Spacing at which the stipple enters, object units, falling along the order.
    pub radius: Vec<f32>,
    /// Stable identity, below 2³⁸: the stage and the candidate.
    pub id: Vec<u64>,
    /// The element that carries the stipple.
    pub element: Vec<u32>,
    /// Barycentric coordinates of the element's second and third vertex.
    pub weights: Vec<[f32; 2]>,
    /// Area of the surface, object units squared.
    pub area: f64,
}

impl Baked {
    /// Number of stipples.
    pub fn len(&self) -> usize {
        self.radius.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.radius.is_empty()
    }
}

/// Stipples with their places in space, in structure-of-arrays form and in the order of the bake.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stock {
    /// The bake.
    pub baked: Baked,
    /// Positions, object units.
    pub position: Vec<Vec3>,
    /// Unit smooth normals, for light.
    pub normal: Vec<Vec3>,
    /// Unit facet normals, for scale and facing.
    pub facet: Vec<Vec3>,
}

impl Stock {
    /// Puts a bake on its mesh.
    ///
    /// # Panics
    /// If an element is not a triangle of `mesh`; callers that read a bake from a file check it first.
    pub fn on_mesh(baked: Baked, mesh: &Mesh) -> Stock {
        let ((position, normal), facet) = baked
            .element
            .par_iter()
            .zip(&baked.weights)
            .map(|(&t, &[v, w])| {
                let [a, b, c] = mesh.triangles[t as usize].map(|i| mesh.positions[i as usize]);
                let [na, nb, nc] = mesh.corner_normals[t as usize].map(|i| mesh.normals[i as usize]);
                let (ab, ac) = (b - a, c - a);
                let facet = ab.cross(ac).normalize_or(na);
                let normal = (na * (1.0 - v - w) + nb * v + nc * w).normalize_or(facet);
                ((a + ab * v + ac * w, normal), facet)
            })
            .unzip();
        Stock { baked, position, normal, facet }
    }

    /// Number of stipples.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
}
