//! Label volumes: which labels there are, and the smooth surface of one of them.
//!
//! A segmentation gives each voxel the number of the thing that it belongs to. Its values cannot be interpolated, so
//! the surface of a label begins as that of a mask of zeros and ones ([`Volume::isosurface`] at ½, every vertex half-way
//! between two voxel centres), with a staircase wherever it is oblique to the grid. [`smooth`] takes the staircase away:
//!
//! * The positions are low-pass filtered over the mesh by a windowed Chebyshev polynomial of its Laplacian (Gabriel
//!   Taubin, Tong Zhang and Gene Golub, *Optimal Surface Smoothing as Filter Design*, 1996), whose response is 1 for
//!   long waves: a shape of some voxels across does not shrink, as it would under plain averaging.
//! * The Laplacian measures edges in the world, and the cut-off is a wavelength in multiples of the *largest* spacing:
//!   slices three times as far apart as pixels leave terraces many pixels wide, and these go too.
//! * No vertex leaves its half voxel (Sarah F. F. Gibson, *Constrained Elastic Surface Nets*, 1998): the surface keeps
//!   to what the labels say, and neighbouring labels keep together. Matter one voxel thick keeps most of its thickness.

mod list;
mod smooth;

pub use list::{Label, MAX_LABELS, labels};

use dotwork_drawing::Warnings;
use dotwork_mesh::RawMesh;
use glam::{DVec3, Vec3A};
use thiserror::Error;

use crate::isosurface::{IsoError, IsoOptions};
use crate::samples::Samples;
use crate::volume::Volume;

/// Layers of outside voxels around the mask: its surface is closed whatever the volume cuts off.
const BORDER: usize = 1;

/// The default of [`LabelOptions::wavelength`].
const WAVELENGTH: f64 = 8.0;

/// How the surface of a label is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LabelOptions {
    /// Waves on the surface shorter than this are smoothed away, in multiples of the largest spacing; 8 by default,
    /// 0 leaves the staircase. Vertices stay in their half voxels whatever the value; at most 100.
    pub wavelength: f64,
}

impl Default for LabelOptions {
    fn default() -> Self {
        LabelOptions { wavelength: WAVELENGTH }
    }
}

/// Why there are no labels, or no surface of one. Each text reads well after the name of the file and a colon.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LabelError {
    /// A value is no whole number, so these are no labels.
    #[error("is no label volume: voxel {}, {}, {} has the value {value}", voxel[0], voxel[1], voxel[2])]
    NotWhole {
        /// The first such voxel.
        voxel: [usize; 3],
        /// Its value.
        value: f64,
    },
    /// More labels than [`MAX_LABELS`].
    #[error("is no label volume: it has more than {MAX_LABELS} different values")]
    TooMany,
    /// The volume has no voxel of these labels.
    #[error("no voxel has {}", asked_text(asked))]
    NoVoxel {
        /// The values asked for.
        asked: Vec<i64>,
    },
    /// [`LabelOptions::wavelength`] is negative, above 100, or not a number.
    #[error("surfaces cannot be smoothed by {0} voxels; 0 to 100 are possible")]
    Wavelength(f64),
    /// The memory for the mask cannot be had.
    #[error("a mask of {} x {} x {} voxels cannot be held", dims[0], dims[1], dims[2])]
    TooLarge {
        /// Its voxels along x, y and z.
        dims: [usize; 3],
    },
    /// There is no surface of the mask.
    #[error(transparent)]
    Surface(#[from] IsoError),
}

fn asked_text(asked: &[i64]) -> String {
    let list: Vec<String> = asked.iter().take(8).map(i64::to_string).collect();
    let more = if asked.len() > 8 { ", …" } else { "" };
    format!("the label {}{more}", list.join(", "))
}

impl Volume {
    /// The surface around all voxels of some labels together, in world units: smooth, watertight, its triangles
    /// counter-clockwise seen from outside, with normals that point outwards.
    ///
    /// `labels` are of this volume's [`labels`]: their values are sought in their boxes only. Several make one surface,
    /// without walls between them. Where the label meets the border of the volume the surface is closed half a voxel
    /// outside the outermost voxel centres. Coordinates are relative to [`RawMesh::origin`], as those of
    /// [`Volume::isosurface`]. Memory beside the mesh is a byte for each voxel of the box and some 200 bytes for each
    /// vertex. The result is the same on any number of threads.
    ///
    /// # Errors
    /// [`LabelError`] if there is no such voxel or the memory cannot be had.
    ///
    /// ```
    /// use dotwork_volume::{LabelOptions, Volume, labels};
    ///
    /// let inside = |i: usize| (i % 16).abs_diff(8).pow(2) + (i / 16 % 16).abs_diff(8).pow(2) < 25;
    /// let samples: Vec<u8> = (0..16 * 16 * 16).map(|i| if inside(i) { 7 } else { 0 }).collect();
    /// let volume = Volume::from_vec([16, 16, 16], [1.0, 1.0, 2.0], samples)?;
    /// let found = labels(&volume)?;
    /// assert_eq!((found.len(), found[1].value, found[1].voxels), (2, 7, 16 * 69));
    /// let rod = volume.label_surface(&found[1..], &LabelOptions::default())?;
    /// assert_eq!(rod.normals.len(), rod.positions.len());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn label_surface(&self, labels: &[Label], options: &LabelOptions) -> Result<RawMesh, LabelError> {
        let LabelOptions { wavelength } = *options;
        if !(0.0..=100.0).contains(&wavelength) {
            return Err(LabelError::Wavelength(wavelength));
        }
        let [min, max] = self.bounds();
        let extent = (max - min).max_element();
        if extent.is_nan() || extent > f64::from(f32::MAX) / 4.0 {
            return Err(IsoError::TooWide { extent }.into());
        }
        let (mask, first) = self.mask(labels)?;
        // Samples 0 and 1: no warning can come of them.
        let mut mesh = mask.isosurface(0.5, &IsoOptions::default(), &mut Warnings::new())?;
        let grid: Vec<Vec3A> = mesh.positions.iter().map(|&p| Vec3A::from_array(p)).collect();
        let linear = self.affine().linear;
        let placed = if wavelength > 0.0 {
            let rooms = smooth::rooms(&mask, &grid);
            smooth::smoothed(&grid, &rooms, &mesh.triangles, linear, wavelength)
        } else {
            grid
        };
        // To the world, in double precision, and relative to the origin of meshes of this volume.
        let origin = self.mesh_origin();
        let offset = self.affine().point(first.map(|i| i as f64)) - origin;
        // Moved vertices may meet.
        mesh.in_order = None;
        for (place, p) in mesh.positions.iter_mut().zip(&placed) {
            *place = (linear * DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z)) + offset)
                .as_vec3()
                .to_array();
        }
        if self.affine().is_mirrored() {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        smooth::vertex_normals(&mut mesh, linear.inverse().transpose());
        mesh.origin = origin.to_array();
        Ok(mesh)
    }

    /// Ones where the value is that of a label, in a box with a border of zeros; and the index of its first voxel.
    fn mask(&self, labels: &[Label]) -> Result<(Volume, [i64; 3]), LabelError> {
        let none = || LabelError::NoVoxel { asked: labels.iter().map(|l| l.value).collect() };
        let dims = self.dims();
        let (mut low, mut high) = (dims, [0; 3]);
        for Label { bounds: [from, to], .. } in labels {
            for axis in 0..3 {
                low[axis] = low[axis].min(from[axis]);
                high[axis] = high[axis].max(to[axis].saturating_add(1).min(dims[axis]));
            }
        }
        if (0..3).any(|axis| low[axis] >= high[axis]) {
            return Err(none());
        }
        let sides: [usize; 3] = std::array::from_fn(|axis| high[axis] - low[axis] + 2 * BORDER);
        let too_large = || LabelError::TooLarge { dims: sides };
        let [nx, ny, nz] = sides;
        let voxels = nx.checked_mul(ny).and_then(|xy| xy.checked_mul(nz)).ok_or_else(too_large)?;
        // Zeroed memory comes without a way to fail, so it is asked for twice.
        Vec::<u8>::new().try_reserve_exact(voxels).map_err(|_| too_large())?;
        let mut mask = vec![0u8; voxels];
        let wanted: Vec<i64> = labels.iter().map(|l| l.value).collect();
        with_samples!(self.samples(), samples => {
            list::fill_mask(&mut mask, sides, samples, dims, self.scaling(), [low, high], &wanted);
        });
        if !mask.contains(&1) {
            return Err(none());
        }
        let first = low.map(|i| i as i64 - BORDER as i64);
        let mask = Volume::from_vec(sides, [1.0; 3], mask).map_err(|_| too_large())?;
        Ok((mask, first))
    }
}

/// The mask's byte at a voxel, 0 outside.
fn at(samples: &[u8], [nx, ny, nz]: [usize; 3], [x, y, z]: [i64; 3]) -> u8 {
    let inside = |i: i64, n: usize| usize::try_from(i).ok().filter(|i| *i < n);
    match (inside(x, nx), inside(y, ny), inside(z, nz)) {
        (Some(x), Some(y), Some(z)) => samples[x + nx * (y + ny * z)],
        _ => 0,
    }
}

/// The bytes of a mask.
fn bytes(mask: &Volume) -> &[u8] {
    match mask.samples() {
        Samples::U8(bytes) => bytes,
        _ => &[],
    }
}
