//! The stock: the stipples a bake made, ready to be asked for by spacing.

use std::sync::Arc;

use dotwork_drawing::color::{linear_to_srgb, srgb_to_linear};
use dotwork_mesh::Mesh;
use glam::Vec3;
use rayon::prelude::*;

use crate::bake;

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

/// What carries the stipples of a bake that has a list for each element: voxels of a volume or faces of a mesh, in
/// structure-of-arrays form.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Elements {
    /// Centres, object units.
    pub position: Vectors,
    /// Unit normals; of faces the smooth ones.
    pub normal: Vectors,
    /// Value over the value window, 0…1; of faces 1.
    pub value: Vec<f32>,
    /// Length of the gradient over a large one, 0…1; of faces 1.
    pub magnitude: Vec<f32>,
    /// Area of the section or of the face, object units squared; 0 for elements that carry nothing. Radii follow from
    /// it, so that it stays that of the bake when a mesh is deformed.
    pub area: Vec<f32>,
    /// Most stipples shown: by a voxel; by faces, per object unit squared.
    pub n_max: f32,
    /// Most stipples that were asked for: more than `n_max` where lists would have been too long.
    pub wanted: f32,
    /// What the elements are.
    pub carrier: Carrier,
    /// Seed of the bake.
    pub seed: u32,
    /// How far from the surface of its element a stipple may lie, object units.
    pub reach: f32,
    /// The scale of the view that `n_max` was made for, see [`crate::bake::reference_scale`]; `None`: every view.
    pub reference: Option<f32>,
}

/// What elements are.
#[derive(Clone, Debug, PartialEq)]
pub enum Carrier {
    /// Voxels of a volume.
    Voxels {
        /// The three edges of a voxel, object units.
        edges: [Vec3; 3],
        /// Distance of the two planes between which stipples lie, in mean edges of a voxel.
        slab: f32,
    },
    /// Faces of a mesh, one for each of its triangles.
    Faces {
        /// The number of each face, 0 ≤ u < 1: where each asks for a part of a dot, those with the largest show one.
        number: Vec<f32>,
    },
}

/// What is to be known of the faces of a bake besides their mesh; see [`Elements`].
#[derive(Clone, Debug, PartialEq)]
pub struct Faces {
    /// The number of each, 0 ≤ u < 1; see [`Carrier::Faces`].
    pub number: Vec<f32>,
    /// Their areas when they were baked, object units squared.
    pub area: Vec<f32>,
    /// Most stipples shown, per object unit squared.
    pub n_max: f32,
    /// Most stipples that were asked for, per object unit squared.
    pub wanted: f32,
    /// Seed of the bake.
    pub seed: u32,
    /// The scale of the view that `n_max` was made for.
    pub reference: Option<f32>,
}

impl Default for Carrier {
    fn default() -> Carrier {
        Carrier::Voxels { edges: [Vec3::ZERO; 3], slab: 0.0 }
    }
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

    /// Whether these are faces of a mesh.
    pub fn are_faces(&self) -> bool {
        matches!(self.carrier, Carrier::Faces { .. })
    }

    /// What takes the place in its element's list, counted from 0, out of an id: `id & mask`.
    pub fn rank_mask(&self) -> u64 {
        match self.carrier {
            Carrier::Voxels { .. } => bake::RANK_MASK,
            Carrier::Faces { .. } => bake::rank_mask(self.len()),
        }
    }

    /// Most stipples that element `e` shows, N_max.
    #[inline(always)]
    pub fn n_max_of(&self, e: usize) -> f32 {
        match self.carrier {
            Carrier::Voxels { .. } => self.n_max,
            Carrier::Faces { .. } => self.n_max * self.area[e],
        }
    }
}

/// Stipples with their places in space, in structure-of-arrays form and in the order of the bake.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stock {
    /// The bake; shared by the stocks of all poses of a surface.
    pub baked: Arc<Baked>,
    /// Positions, object units.
    pub position: Vectors,
    /// Unit smooth normals, for light.
    pub normal: Vectors,
    /// Unit facet normals, for scale and facing.
    pub facet: Vectors,
    /// Ink of the surface's own colours, 1 − luminance; empty if it has none.
    pub own: Vec<f32>,
    /// The surface's own colours, sRGB; empty if it has none.
    pub tint: Vec<[u8; 3]>,
    /// The elements, where the bake has a list for each; `baked.element` counts these. Faces are the triangles of the mesh.
    pub elements: Option<Elements>,
    /// For a surface that has moved since it was baked: how many times as large it is around each stipple as it was then.
    /// Empty: as large.
    pub stretch: Vec<f32>,
}

impl Stock {
    /// Puts a bake on its mesh.
    ///
    /// # Panics
    /// If an element is not a triangle of `mesh`; callers that read a bake from a file check it first.
    pub fn on_mesh(baked: impl Into<Arc<Baked>>, mesh: &Mesh) -> Stock {
        let stock = Stock::placed(baked.into(), mesh);
        if !mesh.is_colored() {
            return stock;
        }
        let color = |i: usize| mesh.color_at(stock.baked.element[i] as usize, stock.baked.weights[i]);
        let tint = |i: usize| {
            let [r, g, b, _] = color(i);
            [r, g, b].map(linear_to_srgb)
        };
        let all = (0..stock.len()).into_par_iter();
        let own = match mesh.paint {
            None => all.clone().map(|i| own_ink(&stock.baked, mesh, i)).collect(),
            Some(_) => all.clone().map(|i| 1.0 - luminance(color(i))).collect(),
        };
        let tint = all.map(tint).collect();
        Stock { own, tint, ..stock }
    }

    /// As [`Stock::on_mesh`], without the surface's own colours.
    fn placed(baked: Arc<Baked>, mesh: &Mesh) -> Stock {
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
        let (own, tint, stretch) = Default::default();
        Stock { baked, position, normal, facet, own, tint, elements: None, stretch }
    }

    /// The same stipples on another pose of their mesh: they ride on their triangles. `stretch` says how many times as
    /// large each triangle is as when it was baked, so that radii follow (the density stays a function of light and
    /// scale); without it they stay, and density shows how the surface is stretched.
    ///
    /// # Panics
    /// As [`Stock::on_mesh`]; if `stretch` has fewer items than the mesh has triangles.
    pub fn posed(&self, mesh: &Mesh, stretch: Option<&[f32]>) -> Stock {
        let of = |&e: &u32| stretch.map_or(1.0, |stretch| stretch[e as usize]);
        let stretch = match stretch {
            Some(_) => self.baked.element.par_iter().map(of).collect(),
            None => Vec::new(),
        };
        let posed = self.following(mesh).unwrap_or_else(|| Stock::on_mesh(self.baked.clone(), mesh));
        Stock { stretch, ..posed }
    }

    /// Takes [`Stock::stretch`] from each stipple's neighbours, where it has some (Meruvia Pastor et al. 2003, section
    /// V-C): they lie around it at the distance at which it enters. `rest` is this stock in the pose of its bake.
    ///
    /// The paper takes the mean of the distances as the new radius. That counts a stretch along one axis twice over: the
    /// edges of a place that becomes twice as long grow by 1.54 in the mean, its area, which is what dots are to fill, by
    /// the square of 1.41. Here it is the areas that edges span, two by two: `J² = Σ |eᵢ × eⱼ|² / Σ |e⁰ᵢ × e⁰ⱼ|²`, which is
    /// the change of area exactly wherever the surface is moved evenly (Cauchy and Binet).
    pub fn stretch_by_neighbours(&mut self, rest: &Stock) {
        let spanned = |stock: &Stock, i: usize| {
            let at = stock.position.at(i);
            let ends = stock.baked.neighbours[i];
            let edge = |k: usize| match ends[k] {
                u32::MAX => Vec3::ZERO,
                n => stock.position.at(n as usize) - at,
            };
            let edges = [0, 1, 2, 3].map(edge);
            let pairs = (0..4).flat_map(|a| (a + 1..4).map(move |b| (a, b)));
            pairs.map(|(a, b)| edges[a].cross(edges[b]).length_squared()).sum::<f32>()
        };
        let (now, then) = (&*self, rest);
        let known = now.baked.neighbours.len();
        let stretch = |i: usize| {
            let by_triangle = now.stretch.get(i).copied().unwrap_or(1.0);
            if i >= known {
                return by_triangle;
            }
            let ratio = (spanned(now, i) / spanned(then, i)).sqrt();
            // Neighbours in a line span nothing.
            if ratio.is_finite() && ratio > 0.0 { ratio } else { by_triangle }
        };
        self.stretch = (0..now.len()).into_par_iter().map(stretch).collect();
    }

    /// This stock with `more` stipples at its end, which lie on the same surface in the same pose and have smaller radii.
    pub fn with(&self, more: &Stock) -> Stock {
        fn joined<T: Clone>(a: &[T], b: &[T]) -> Vec<T> {
            [a, b].concat()
        }
        let vectors = |a: &Vectors, b: &Vectors| Vectors {
            x: joined(&a.x, &b.x),
            y: joined(&a.y, &b.y),
            z: joined(&a.z, &b.z),
        };
        let (a, b) = (&self.baked, &more.baked);
        let baked = Baked {
            radius: joined(&a.radius, &b.radius),
            id: joined(&a.id, &b.id),
            element: joined(&a.element, &b.element),
            weights: joined(&a.weights, &b.weights),
            area: a.area,
            neighbours: Vec::new(),
        };
        Stock {
            baked: Arc::new(baked),
            position: vectors(&self.position, &more.position),
            normal: vectors(&self.normal, &more.normal),
            facet: vectors(&self.facet, &more.facet),
            own: joined(&self.own, &more.own),
            tint: joined(&self.tint, &more.tint),
            elements: None,
            stretch: joined(&self.stretch, &more.stretch),
        }
    }

    /// The density in the bake, for each area as it was then, of a density on the surface as it is around stipple `i`.
    #[inline(always)]
    pub fn baked_density(&self, i: usize, density: f32) -> f32 {
        if self.stretch.is_empty() { density } else { density * self.stretch[i] }
    }

    /// The largest of all [`Stock::stretch`]; 1 if nothing is stretched.
    pub fn most_stretched(&self) -> f32 {
        if self.stretch.is_empty() { 1.0 } else { self.stretch.par_iter().copied().reduce(|| 0.0, f32::max) }
    }

    /// The stipples on a mesh that has moved, with the triangles that it had: places and normals follow, radii and
    /// counts stay. `None` for voxels, which do not lie on it.
    ///
    /// # Panics
    /// As [`Stock::on_mesh`].
    pub fn following(&self, mesh: &Mesh) -> Option<Stock> {
        let elements = match &self.elements {
            None => None,
            Some(Elements { carrier: Carrier::Voxels { .. }, .. }) => return None,
            Some(faces) => {
                assert_eq!(faces.len(), mesh.triangles.len(), "faces are those of the mesh");
                let [position, normal] = middles(mesh);
                Some(Elements { position, normal, ..faces.clone() })
            }
        };
        // Colours stay on their triangles.
        let (own, tint) = (self.own.clone(), self.tint.clone());
        Some(Stock { elements, own, tint, ..Stock::placed(self.baked.clone(), mesh) })
    }

    /// A bake of faces on its mesh: what a file keeps of one, with what follows from the mesh.
    ///
    /// # Panics
    /// As [`Stock::on_mesh`], and if there are not as many faces as triangles.
    pub fn of_faces(baked: Baked, mesh: &Mesh, faces: Faces) -> Stock {
        let n = mesh.triangles.len();
        assert_eq!([faces.number.len(), faces.area.len()], [n; 2], "faces are those of the mesh");
        let [position, normal] = middles(mesh);
        let elements = Elements {
            position,
            normal,
            value: vec![1.0; n],
            magnitude: vec![1.0; n],
            area: faces.area,
            n_max: faces.n_max,
            wanted: faces.wanted,
            carrier: Carrier::Faces { number: faces.number },
            seed: faces.seed,
            reach: 0.0,
            reference: faces.reference,
        };
        Stock { elements: Some(elements), ..Stock::on_mesh(baked, mesh) }
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

/// Middles of the faces of a mesh, and unit smooth normals there.
fn middles(mesh: &Mesh) -> [Vectors; 2] {
    let n = mesh.triangles.len();
    let middle = |t: usize| {
        let [a, b, c] = mesh.triangles[t].map(|v| mesh.positions[v as usize]);
        (a + b + c) / 3.0
    };
    let normal = |t: usize| {
        let [a, b, c] = mesh.corner_normals[t].map(|v| mesh.normals[v as usize]);
        (a + b + c).normalize_or_zero()
    };
    [Vectors::collect(n, middle), Vectors::collect(n, normal)]
}

/// Luminance of linear light (IEC 61966-2-1).
fn luminance([r, g, b, _]: [f32; 4]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
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
