//! Ridges of the gradient: where a boundary is, whatever the values on its two sides.
//!
//! An isosurface lies where the value is half-way between two materials only if they are everywhere the same. Where one
//! of them varies (the bias field of an MR scan, partial volume, dense matter that shares an outline with light matter)
//! the surface leaves the boundary. Across a boundary the gradient is longest in its middle, for any two values: the
//! edges of John Canny, *A Computational Approach to Edge Detection*, 1986. So each vertex of an isosurface is moved
//! along its normal to the place where the derivative in that direction is largest:
//!
//! 1. Uphill in steps of half a voxel to the nearest maximum, which parabolas then place. Newton's method fails on faces
//!    along the voxels. Derivatives are those of cubic B-splines (`spline`): those of an interpolated volume have kinks.
//! 2. A maximum counts by how far the derivative falls on both sides of it within two voxels; noise on a ramp hardly has
//!    any, and a vertex without a maximum in reach has none.
//! 3. The moves are smoothed over the mesh, each kept near to its own as far as it counts; one that counts nothing is
//!    drawn along by its neighbours, and to 0 where they have none either (`settle`).
//! 4. What folds a triangle is taken back.
//!
//! Triangles stay what they are, so the surface keeps its topology. Each vertex is looked at alone and each step reads
//! what the one before has written, so the surface is the same on any number of threads.

mod settle;
mod spline;

use dotwork_mesh::{ClipPlane, ClipRegion, ClipRule, RawMesh};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::samples::Ordered;
use crate::volume::Volume;
use settle::{Move, settle};
use spline::Spline;

/// How far a vertex may move, voxels.
const REACH: f64 = 1.5;

/// A step on the way uphill, voxels.
const STEP: f64 = 0.5;

/// How far on both sides of a ridge its height is looked at, voxels.
const FLANK: f64 = 2.0;

/// A ridge from which the derivative falls by less than this share of its height is noise.
const LEAST_FALL: f64 = 0.2;

/// Cosines between the normals of the field and of the facets: from the first on the field's is taken, up to the second
/// that of the facets.
const AGREEMENT: [f64; 2] = [0.95, 0.8];

/// Up to the first distance from a cut, in voxels, vertices stay where they are; from the second on they move freely.
/// The cut itself follows the box of the surface that has moved, and may lie a move elsewhere.
const CUT_STAYS: [f64; 2] = [2.0, 6.0];

/// Vertices in one task.
const GRAIN: usize = 1024;

/// What [`Volume::snap_to_ridge`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RidgeReport {
    /// Vertices of the surface.
    pub vertices: usize,
    /// Those with a ridge in reach.
    pub found: usize,
    /// Those that moved less than their ridge asked for, since a triangle would have been folded.
    pub held: usize,
    /// The root mean square of the moves, voxels.
    pub moved: f64,
}

/// A volume as the search sees it.
struct Field<'a, T> {
    spline: Spline<'a, T>,
    /// 1 where larger samples are inside, −1 where smaller ones are.
    sign: f64,
    /// From the world to voxel indices.
    inverse: DMat3,
    /// The first voxel in mesh coordinates.
    first: DVec3,
    /// The same in the world.
    origin: DVec3,
    linear: DMat3,
}

impl Volume {
    /// Moves the vertices of an isosurface of this volume along their normals to where the gradient is longest in that
    /// direction, up to 1.5 voxels: onto the boundary of which the iso value is a first guess.
    ///
    /// Vertices that have no such ridge within reach follow their neighbours, or stay. The triangles stay, and none is
    /// turned over; normals become those of the field at the new places. `surface` must be in the coordinates of
    /// [`Volume::isosurface`]. Near the border of `cut`, which is to be clipped away, the surface stays where it is, so
    /// that [`cut_faces`](crate::cut_faces) at its iso value meet it.
    pub fn snap_to_ridge(&self, surface: &mut RawMesh, cut: Option<&ClipRegion>) -> RidgeReport {
        with_samples!(self.samples(), samples => snap(&Field::new(self, samples, surface.origin), surface, cut))
    }
}

fn snap<T: Ordered>(field: &Field<'_, T>, surface: &mut RawMesh, cut: Option<&ClipRegion>) -> RidgeReport {
    let places: Vec<DVec3> =
        surface.positions.par_iter().with_min_len(GRAIN).map(|p| field.index(*p)).collect();
    let along = |n: &[f32; 3]| (field.inverse * DVec3::from_array(n.map(f64::from))).normalize_or_zero();
    let directions: Vec<DVec3> = surface.normals.par_iter().with_min_len(GRAIN).map(along).collect();
    let search = |(&place, &direction)| field.ridge(place, direction);
    let wanted: Vec<Move> = places.par_iter().zip(&directions).with_min_len(GRAIN).map(search).collect();
    let found = wanted.iter().filter(|m| m.weight > 0.0).count();
    let leave = |place: &DVec3| cut.map_or(1.0, |cut| field.leave(*place, cut));
    let leave: Vec<f64> = places.par_iter().with_min_len(GRAIN).map(leave).collect();
    let moves = settle(&places, &directions, &surface.triangles, wanted, &leave);

    let put = |(v, p): (usize, &mut [f32; 3])| {
        if moves.by[v] != 0.0 {
            let place = places[v] + moves.by[v] * directions[v];
            *p = (field.first + field.linear * place).as_vec3().to_array();
        }
    };
    surface.positions.par_iter_mut().with_min_len(GRAIN).enumerate().for_each(put);
    let facing = facing(surface);
    let turn = |(v, n): (usize, &mut [f32; 3])| {
        let place = places[v] + moves.by[v] * directions[v];
        let old = DVec3::from_array(n.map(f64::from));
        let normal = field.normal(place).unwrap_or(old);
        *n = agreed(normal, facing[v].try_normalize().unwrap_or(old)).as_vec3().to_array();
    };
    surface.normals.par_iter_mut().with_min_len(GRAIN).enumerate().for_each(turn);
    let squares: f64 = moves.by.iter().map(|t| t * t).sum();
    RidgeReport {
        vertices: places.len(),
        found,
        held: moves.held,
        moved: (squares / places.len().max(1) as f64).sqrt(),
    }
}

/// The facets around each vertex, added up by their area.
fn facing(surface: &RawMesh) -> Vec<DVec3> {
    let place = |v: u32| DVec3::from_array(surface.positions[v as usize].map(f64::from));
    let mut sums = vec![DVec3::ZERO; surface.positions.len()];
    for &t in &surface.triangles {
        let [a, b, c] = t.map(place);
        let facet = (b - a).cross(c - a);
        t.iter().for_each(|&v| sums[v as usize] += facet);
    }
    sums
}

/// A normal of the field as far as it agrees with that of the facets. A ridge is no isosurface: where it is weak, or
/// parts from one to another, the gradient does not stand on it, and dots would be toned for a slope that is not there.
fn agreed(field: DVec3, facets: DVec3) -> DVec3 {
    let [most, least] = AGREEMENT;
    let share = ((field.dot(facets) - least) / (most - least)).clamp(0.0, 1.0);
    facets.lerp(field, share).normalize_or(facets)
}

impl<'a, T: Ordered> Field<'a, T> {
    fn new(volume: &Volume, samples: &'a [T], mesh_origin: [f64; 3]) -> Field<'a, T> {
        let affine = volume.affine();
        Field {
            spline: Spline::new(samples, volume.dims()),
            sign: volume.scaling().slope.signum(),
            inverse: affine.linear.inverse(),
            first: affine.origin - DVec3::from_array(mesh_origin),
            origin: affine.origin,
            linear: affine.linear,
        }
    }

    /// A place of the mesh in voxel indices.
    fn index(&self, p: [f32; 3]) -> DVec3 {
        self.inverse * (DVec3::from_array(p.map(f64::from)) - self.first)
    }

    /// How much of its move a place makes beside a cut: none on it, all a few voxels away.
    fn leave(&self, place: DVec3, cut: &ClipRegion) -> f64 {
        let world = self.origin + self.linear * place;
        let voxels = |plane: &ClipPlane| plane.distance(world) * (self.inverse * plane.normal).length();
        let distances = cut.planes().iter().map(voxels);
        // Above 0 in what is cut away.
        let within = match cut.rule() {
            ClipRule::All => distances.fold(f64::INFINITY, f64::min),
            ClipRule::Any => distances.fold(f64::NEG_INFINITY, f64::max),
        };
        let away = within.abs();
        ((away - CUT_STAYS[0]) / (CUT_STAYS[1] - CUT_STAYS[0])).clamp(0.0, 1.0)
    }

    /// The unit normal in the world, out of the denser matter; `None` where there is no gradient.
    fn normal(&self, place: DVec3) -> Option<DVec3> {
        let gradient = self.spline.gradient(place);
        let largest = gradient.abs().max_element();
        let gradient = (largest > 0.0 && largest.is_finite()).then(|| gradient / largest)?;
        (self.inverse.transpose() * (-self.sign * gradient)).try_normalize()
    }

    /// How far from `place` along `direction`, out of the denser matter, the nearest ridge is.
    fn ridge(&self, place: DVec3, direction: DVec3) -> Move {
        // How fast the value falls.
        let fall = |t: f64| -self.sign * self.spline.gradient(place + t * direction).dot(direction);
        let here = fall(0.0);
        let [inwards, outwards] = [-STEP, STEP].map(fall);
        let (mut t, mut height) = (0.0, here);
        let step = if outwards > inwards { STEP } else { -STEP };
        let mut next = outwards.max(inwards);
        while next > height {
            (t, height) = (t + step, next);
            if t.abs() > REACH {
                return Move::default();
            }
            next = fall(t + step);
        }
        // Twice: the first parabola may lean on what is beside the ridge.
        for arm in [1.0, STEP] {
            let [before, middle, after] = [t - arm, t, t + arm].map(fall);
            let bend = before - 2.0 * middle + after;
            if bend < 0.0 {
                t += arm * (0.5 * (before - after) / bend).clamp(-0.5, 0.5);
            }
        }
        let height = fall(t);
        let flank = fall(t - FLANK).max(fall(t + FLANK));
        // Not a number where a sample is none.
        let weight = ((height - flank) / height - LEAST_FALL).clamp(0.0, 1.0);
        if height > 0.0 && weight > 0.0 && t.abs() <= REACH {
            Move { by: t, weight }
        } else {
            Move::default()
        }
    }
}
