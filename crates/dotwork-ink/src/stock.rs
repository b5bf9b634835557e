//! The stock: the stipples a bake made, ready to be asked for by spacing.

use dotwork_drawing::color::srgb_to_linear;
use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

/// What a bake returns: an order of places, each with the spacing at which it enters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Baked {
    /// Spacing at which the stipple enters, object units, falling along the order.
    pub radius: Vec<f32>,
    /// Stable identity, below 2³⁸: the stage and the candidate, or the vertex.
    pub id: Vec<u64>,
    /// The element that carries the stipple.
    pub element: Vec<u32>,
    /// Barycentric coordinates of the element's second and third vertex.
    pub weights: Vec<[f32; 2]>,
    /// Of each stipple of a `hierarchy`, two to four neighbours among those before it, on all sides, the nearest first;
    /// [`u32::MAX`] for none. Empty for other bakes.
    pub neighbours: Vec<[u32; 4]>,
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

/// Vectors in structure-of-arrays form, for loops that look at many at once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vectors {
    /// First components.
    pub x: Vec<f32>,
    /// Second components.
    pub y: Vec<f32>,
    /// Third components.
    pub z: Vec<f32>,
}

impl Vectors {
    /// The `i`-th vector.
    ///
    /// # Panics
    /// If there are not that many.
    #[inline(always)]
    pub fn at(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Number of vectors.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// The first `n` vectors.
    pub(crate) fn first(&self, n: usize) -> Vectors {
        let part = |v: &[f32]| v[..n].to_vec();
        Vectors { x: part(&self.x), y: part(&self.y), z: part(&self.z) }
    }

    /// Adds `shift` to each.
    pub fn translate(&mut self, shift: Vec3) {
        for (v, shift) in [(&mut self.x, shift.x), (&mut self.y, shift.y), (&mut self.z, shift.z)] {
            v.iter_mut().for_each(|v| *v += shift);
        }
    }

    pub(crate) fn collect(n: usize, at: impl Fn(usize) -> Vec3 + Sync) -> Vectors {
        let component = |k: usize| (0..n).into_par_iter().map(|i| at(i)[k]).collect();
        Vectors { x: component(0), y: component(1), z: component(2) }
    }
}

/// What carries the stipples of a bake that has a list for each element: voxels, in structure-of-arrays form.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Elements {
    /// Centres, object units.
    pub position: Vectors,
    /// Unit normals.
    pub normal: Vectors,
    /// Value over the value window, 0…1.
    pub value: Vec<f32>,
    /// Length of the gradient over a large one, 0…1.
    pub magnitude: Vec<f32>,
    /// Area of the section, object units squared; 0 for elements that carry nothing.
    pub area: Vec<f32>,
    /// Most stipples that an element shows.
    pub n_max: f32,
    /// Most stipples that were asked for: more than `n_max` where lists would have been too long.
    pub wanted: f32,
    /// The three edges of a voxel, object units.
    pub edges: [Vec3; 3],
    /// Distance of the two planes between which stipples lie, in mean edges of a voxel.
    pub slab: f32,
    /// Seed of the bake.
    pub seed: u32,
    /// How far from its element's centre a stipple may lie, object units.
    pub reach: f32,
    /// The scale of the view that `n_max` was made for, see [`crate::bake::reference_scale`]; `None`: every view.
    pub reference: Option<f32>,
}

impl Elements {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.area.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.area.is_empty()
    }
}

/// Stipples with their places in space, in structure-of-arrays form and in the order of the bake.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stock {
    /// The bake.
    pub baked: Baked,
    /// Positions, object units.
    pub position: Vectors,
    /// Unit smooth normals, for light.
    pub normal: Vectors,
    /// Unit facet normals, for scale and facing.
    pub facet: Vectors,
    /// Ink of the surface's own colours, 1 − luminance; empty if it has none.
    pub own: Vec<f32>,
    /// The elements, where the bake has a list for each; then `baked.element` counts these, not triangles.
    pub elements: Option<Elements>,
}

impl Stock {
    /// Puts a bake on its mesh.
    ///
    /// # Panics
    /// If an element is not a triangle of `mesh`; callers that read a bake from a file check it first.
    pub fn on_mesh(baked: Baked, mesh: &Mesh) -> Stock {
        let place = |i: usize| {
            let (t, [v, w]) = (baked.element[i] as usize, baked.weights[i]);
            let [a, b, c] = mesh.triangles[t].map(|i| mesh.positions[i as usize]);
            let [na, nb, nc] = mesh.corner_normals[t].map(|i| mesh.normals[i as usize]);
            let (ab, ac) = (b - a, c - a);
            let facet = ab.cross(ac).normalize_or(na);
            let normal = (na * (1.0 - v - w) + nb * v + nc * w).normalize_or(facet);
            [a + ab * v + ac * w, normal, facet]
        };
        let places: Vec<[Vec3; 3]> = (0..baked.len()).into_par_iter().map(place).collect();
        let part = |k: usize| Vectors::collect(places.len(), |i| places[i][k]);
        let (position, normal, facet) = (part(0), part(1), part(2));
        let own = match mesh.colors[..] {
            [] => Vec::new(),
            _ => (0..baked.len()).into_par_iter().map(|i| own_ink(&baked, mesh, i)).collect(),
        };
        Stock { baked, position, normal, facet, own, elements: None }
    }

    /// Moves all places, as when coordinates become relative to another origin.
    pub fn translate(&mut self, shift: Vec3) {
        self.position.translate(shift);
        if let Some(elements) = &mut self.elements {
            elements.position.translate(shift);
        }
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

/// The ink of a mesh's own colour at stipple `i`: 1 less the luminance of linear light.
fn own_ink(baked: &Baked, mesh: &Mesh, i: usize) -> f32 {
    let [v, w] = baked.weights[i];
    let corners = mesh.triangles[baked.element[i] as usize];
    let luminance = |k: usize| {
        let [r, g, b, _] = mesh.colors[corners[k] as usize];
        0.2126 * srgb_to_linear(r) + 0.7152 * srgb_to_linear(g) + 0.0722 * srgb_to_linear(b)
    };
    1.0 - (luminance(0) * (1.0 - v - w) + luminance(1) * v + luminance(2) * w)
}
