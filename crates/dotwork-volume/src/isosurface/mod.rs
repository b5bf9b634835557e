//! Isosurfaces: where a volume has one value, as a mesh without cracks.
//!
//! Marching cubes (William E. Lorensen and Harvey E. Cline, *Marching Cubes: A High Resolution 3D Surface
//! Construction Algorithm*, 1987) in the order of work of flying edges (William Schroeder, Rob Maynard and Berk Geveci,
//! *Flying Edges: A High-Performance Scalable Isocontouring Algorithm*, 2015):
//!
//! 1. Samples are compared in their stored type, and become one bit each (`bits`). From now on, runs of 64 cells that
//!    lie on one side are skipped with a few instructions.
//! 2. The vertices and triangles of each layer are counted, so that each knows its place in the mesh (`slab`).
//! 3. Each grid edge between an inside and an outside sample gets one vertex, at the place where linear interpolation
//!    reaches the iso value, with the field's gradient as its normal (`field`).
//! 4. Each cell becomes the triangles of its case (`cases`), which a rule makes; neighbours agree on every face.
//!
//! Each step runs in parallel over layers, or slabs of them, and writes to places of its own; where they are depends
//! on the grid alone, so the mesh is the same on any number of threads. Time is linear in the samples, with a small
//! constant, plus linear in the surface. Memory is that of the mesh and one bit a sample.

mod bits;
mod cases;
mod field;
mod slab;

use dotwork_drawing::Warnings;
use dotwork_mesh::{InOrder, RawMesh};
use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use crate::samples::Ordered;
use crate::volume::Volume;
use bits::Bits;
use field::{Field, Inside};
use slab::{Counts, Grid, Output};

/// Layers that a thread makes in one go.
const SLAB_LAYERS: usize = 8;

/// The most triangles, and more than enough vertices for them: meshes number corners with 32 bits.
const MAX_TRIANGLES: usize = (u32::MAX / 3) as usize;

/// Along the longest side of a grid, samples up to which single precision is sure to keep vertices apart.
const LARGEST_TOLD_APART: usize = 2048;

/// How an isosurface is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IsoOptions {
    /// Close the surface where it meets the border of the volume; off by default.
    ///
    /// The volume then lies within a layer of samples of value −∞. Interpolation puts the caps a thousandth of a voxel
    /// outside the centres of the border voxels, so they are flat, end where the data end, and face straight outwards.
    pub cap: bool,
}

/// Why there is no isosurface. Each text reads well after the name of the file and a colon.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IsoError {
    /// The iso value is beyond all values, or not a finite number.
    #[error("no surface at {iso}: the values run from {min} to {max}")]
    NoSurface {
        /// What was asked for.
        iso: f64,
        /// The smallest finite value.
        min: f64,
        /// The largest finite value.
        max: f64,
    },
    /// Every sample is NaN or infinite.
    #[error("no surface: none of the samples is a finite number")]
    NoValues,
    /// A cell needs two samples along each axis.
    #[error("a surface needs at least 2 voxels each way, and there are {} x {} x {}", dims[0], dims[1], dims[2])]
    TooThin {
        /// Voxels along x, y and z.
        dims: [usize; 3],
    },
    /// Coordinates of vertices are in single precision.
    #[error(
        "no surface: the volume measures {extent:e} units across, and numbers of 32 bits do not reach so far"
    )]
    TooWide {
        /// The longest side of the box around the voxel centres, world units.
        extent: f64,
    },
    /// More triangles than 32-bit numbers can index.
    #[error("the surface at {iso} has too many triangles; try another value or a smaller volume")]
    TooLarge {
        /// What was asked for.
        iso: f64,
    },
}

impl Volume {
    /// The surface where the value is `iso`, in world units.
    ///
    /// Voxels with `value >= iso` are inside. Vertices lie on grid edges, one for each edge that crosses, by linear
    /// interpolation, but never closer than a thousandth of the edge to a sample, so no two coincide. Triangles are
    /// counter-clockwise seen from the low side, whatever the handedness of the voxel axes; normals are those of
    /// the field (central differences at the samples, one-sided at the border, interpolated along the edge) and
    /// point to the low side, out of the denser matter. Every edge of the mesh has two triangles that agree in
    /// winding, except where the surface ends at the border of the volume (see [`IsoOptions::cap`]).
    ///
    /// A NaN counts as −∞ and is warned of. Coordinates are relative to [`RawMesh::origin`]: 0 unless the volume
    /// lies farther away from there than it is large; then its centre.
    ///
    /// # Errors
    /// [`IsoError`]; `warnings` then holds nothing new.
    pub fn isosurface(
        &self,
        iso: f64,
        options: &IsoOptions,
        warnings: &mut Warnings,
    ) -> Result<RawMesh, IsoError> {
        let dims = self.dims();
        if dims.contains(&1) {
            return Err(IsoError::TooThin { dims });
        }
        let none = || match self.value_range() {
            Some((min, max)) => IsoError::NoSurface { iso, min, max },
            None => IsoError::NoValues,
        };
        if !iso.is_finite() {
            return Err(none());
        }
        let [min, max] = self.bounds();
        // No vertex lies farther from the origin than twice that, whichever origin is taken.
        let extent = (max - min).max_element();
        if extent.is_nan() || extent > f64::from(f32::MAX) / 4.0 {
            return Err(IsoError::TooWide { extent });
        }
        let extracted = with_samples!(self.samples(), samples => extract(self, samples, iso, options.cap));
        let (mesh, nans) = extracted.ok_or(IsoError::TooLarge { iso })?;
        if mesh.triangles.is_empty() {
            return Err(none());
        }
        warnings.counted(
            "voxels whose value is not a number (NaN), taken as outside",
            nans,
            (nans > 0).then(|| self.first_nan()).flatten(),
        );
        Ok(mesh)
    }

    /// What mesh coordinates are relative to: single precision must suffice for vertices in a voxel.
    pub(crate) fn mesh_origin(&self) -> DVec3 {
        let [min, max] = self.bounds();
        let center = self.center();
        if center.length() > (max - min).length() { center } else { DVec3::ZERO }
    }

    /// The place of the first NaN, for a warning.
    fn first_nan(&self) -> Option<String> {
        let i = with_samples!(self.samples(), samples => samples.iter().position(|s| Ordered::is_nan(*s)))?;
        let [nx, ny, _] = self.dims();
        Some(format!("voxel {}, {}, {}", i % nx, i / nx % ny, i / (nx * ny)))
    }
}

/// The surface, empty if no sample is inside or all are, and the number of samples that are NaN; `None` if there are
/// too many triangles.
fn extract<T: Ordered>(volume: &Volume, samples: &[T], iso: f64, cap: bool) -> Option<(RawMesh, u64)> {
    let Some(inside) = Inside::find(volume, iso) else {
        return Some((RawMesh::default(), 0));
    };
    let pad = usize::from(cap);
    let mut bits = Bits::new(volume.dims().map(|n| n + 2 * pad))?;
    let tally = classify(&mut bits, samples, volume.dims(), pad, inside);
    // With caps, a volume that is inside everywhere would be a box that shows nothing of the data.
    if tally.inside == samples.len() {
        return Some((RawMesh::default(), 0));
    }
    let origin = volume.mesh_origin();
    let field = Field::new(volume, samples, iso, origin);
    let mesh = make(&Grid { field, bits, pad, turn: volume.affine().is_mirrored() })?;
    Some((RawMesh { origin: origin.to_array(), ..mesh }, tally.nans))
}

/// What a pass over the samples finds.
#[derive(Clone, Copy, Default)]
struct Tally {
    /// Samples inside.
    inside: usize,
    nans: u64,
}

/// Fills the bits of all layers.
fn classify<T: Ordered>(
    bits: &mut Bits,
    samples: &[T],
    [nx, ny, _]: [usize; 3],
    pad: usize,
    inside: Inside<T>,
) -> Tally {
    let words = bits.words();
    let layers: Vec<&mut [u64]> = bits.layers_mut().skip(pad).collect();
    let layer = |(layer, samples): (&mut [u64], &[T])| {
        let mut tally = Tally::default();
        let rows = layer.chunks_exact_mut(words).skip(pad);
        for (row, samples) in rows.zip(samples.chunks_exact(nx)) {
            match inside {
                Inside::From(t) => bits::fill_row(row, pad, samples, |s| s >= t),
                Inside::UpTo(t) => bits::fill_row(row, pad, samples, |s| s <= t),
            }
            tally.inside += row.iter().map(|w| w.count_ones() as usize).sum::<usize>();
            if T::FLOAT {
                tally.nans += samples.iter().map(|s| u64::from(s.is_nan())).sum::<u64>();
            }
        }
        tally
    };
    // The samples end before the upper padding.
    let tallies = layers.into_par_iter().zip(samples.par_chunks_exact(nx * ny)).map(layer);
    tallies.reduce(Tally::default, |a, b| Tally { inside: a.inside + b.inside, nans: a.nans + b.nans })
}

/// Counts, then makes the mesh; `None` if there are too many triangles.
fn make<T: Ordered>(grid: &Grid<'_, T>) -> Option<RawMesh> {
    let layers = grid.bits.layers();
    let counts: Vec<Counts> = (0..layers).into_par_iter().map(|z| slab::count(&grid.bits, z)).collect();
    let vertices: usize = counts.iter().map(|c| c.vertices).sum();
    let triangles: usize = counts.iter().map(|c| c.triangles).sum();
    if vertices.max(triangles) > MAX_TRIANGLES {
        return None;
    }
    let mut mesh = RawMesh {
        positions: vec![[0.0; 3]; vertices],
        normals: vec![[0.0; 3]; vertices],
        triangles: vec![[0; 3]; triangles],
        polygons: triangles,
        ..RawMesh::default()
    };
    // A thousandth of an edge must tell vertices apart in single precision.
    let told_apart = layers.max(grid.bits.rows()).max(grid.bits.words() * bits::WORD) <= LARGEST_TOLD_APART;
    mesh.in_order = told_apart.then(|| InOrder { closed: grid.bits.is_uniform_at_border() });
    let mut outputs = Vec::with_capacity(layers.div_ceil(SLAB_LAYERS));
    let mut first_vertex = 0;
    let (mut positions, mut normals) = (&mut mesh.positions[..], &mut mesh.normals[..]);
    let mut triangles = &mut mesh.triangles[..];
    for slab in counts.chunks(SLAB_LAYERS) {
        let vertices = slab.iter().map(|c| c.vertices).sum();
        outputs.push(Output {
            positions: positions.split_off_mut(..vertices)?,
            normals: normals.split_off_mut(..vertices)?,
            triangles: triangles.split_off_mut(..slab.iter().map(|c| c.triangles).sum())?,
            first_vertex,
        });
        first_vertex += vertices;
    }
    outputs.into_par_iter().enumerate().for_each(|(s, output)| {
        let first = s * SLAB_LAYERS;
        slab::make(grid, first..layers.min(first + SLAB_LAYERS), output);
    });
    Some(mesh)
}
