//! What several tests need: fields, surfaces, edges.

// Each test binary uses a part of it.
#![allow(dead_code)]

use std::collections::HashMap;

use dotwork_drawing::Warnings;
use dotwork_mesh::{Mesh, MeshOptions, RawMesh};
use dotwork_volume::{Affine, IsoOptions, Sample, Scaling, Volume};
use glam::DVec3;

/// A grid in the world, to be filled by a function of world points.
pub struct Field {
    dims: [usize; 3],
    affine: Affine,
}

impl Field {
    pub fn new(dims: [usize; 3], affine: Affine) -> Field {
        Field { dims, affine }
    }

    /// The function sampled at the centres of all voxels.
    pub fn volume<T: Sample>(&self, value: impl Fn(DVec3) -> T) -> Volume {
        let [nx, ny, nz] = self.dims;
        let at = |i: usize| [i % nx, i / nx % ny, i / nx / ny].map(|v| v as f64);
        let samples = (0..nx * ny * nz).map(|i| value(self.affine.point(at(i)))).collect();
        Volume::new(self.dims, T::wrap(samples), Scaling::default(), self.affine).unwrap()
    }
}

/// The isosurface, which warns of nothing.
pub fn iso(volume: &Volume, iso: f64) -> RawMesh {
    surface(volume, iso, false)
}

/// The same with caps.
pub fn iso_capped(volume: &Volume, iso: f64) -> RawMesh {
    surface(volume, iso, true)
}

fn surface(volume: &Volume, iso: f64, cap: bool) -> RawMesh {
    let mut warnings = Warnings::new();
    let raw = volume.isosurface(iso, &IsoOptions { cap }, &mut warnings).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(raw.positions.len(), raw.normals.len());
    assert_eq!(raw.polygons, raw.triangles.len());
    raw
}

/// The mesh put in order.
pub fn mesh_of(raw: RawMesh) -> Mesh {
    Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap()
}

/// Edges with one triangle, and how many edges have more than two, or two that run along them the same way.
pub fn open_edges(triangles: &[[u32; 3]]) -> (Vec<[u32; 2]>, usize) {
    let mut edges: HashMap<[u32; 2], [usize; 2]> = HashMap::new();
    for &[a, b, c] in triangles {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            edges.entry([p.min(q), p.max(q)]).or_default()[usize::from(p > q)] += 1;
        }
    }
    let open = edges.iter().filter(|(_, uses)| uses[0] + uses[1] == 1).map(|(e, _)| *e).collect();
    (open, edges.values().filter(|uses| uses[0] > 1 || uses[1] > 1).count())
}

/// A number from a seed and an index (splitmix64).
pub fn hash(seed: u64, index: u64) -> u64 {
    let mut z = (seed << 32 | index).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
