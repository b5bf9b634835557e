//! A staircase made smooth: a low-pass filter over a mesh, within bounds.

use dotwork_mesh::RawMesh;
use glam::{DMat3, Vec3, Vec3A};
use rayon::prelude::*;

use super::{at, bytes};
use crate::neighbours::Neighbours;
use crate::volume::Volume;

/// How far a vertex may move along each voxel axis, voxels: less than half, so that triangles keep an area where two
/// walls meet.
const ROOM: f32 = 0.49;

/// How far inwards where the matter is one voxel thick: both walls move.
const THIN_ROOM: f32 = 0.1;

/// The filter runs so often, each time from where the last bounds left it: bounds make kinks, the next run rounds them.
const ROUNDS: usize = 2;

/// Steps of the filter at most; spacings over 15 times as large as others, or wavelengths of hundreds of voxels, would
/// have more, and have a softer cut-off instead.
const MOST_STEPS: usize = 400;

/// How far each vertex may move along the voxel axes, the least and the most, voxels.
pub(super) fn rooms(mask: &Volume, positions: &[Vec3A]) -> Vec<[Vec3A; 2]> {
    let (samples, dims) = (bytes(mask), mask.dims());
    let room = |p: &Vec3A| {
        let axis = edge_axis(*p);
        let voxel = |along: f32| -> [i64; 3] {
            std::array::from_fn(|a| (p[a] + if a == axis { along } else { 0.0 }).round() as i64)
        };
        let mut room = [Vec3A::splat(-ROOM), Vec3A::splat(ROOM)];
        // Inside is the one voxel or the other; beyond it matter goes on, or is one voxel thick.
        let (side, beyond) = if at(samples, dims, voxel(-0.5)) == 1 { (0, -1.5) } else { (1, 1.5) };
        if at(samples, dims, voxel(beyond)) == 0 {
            room[side][axis] *= THIN_ROOM / ROOM;
        }
        room
    };
    positions.par_iter().map(room).collect()
}

/// The axis of the grid edge half-way along which a vertex lies.
fn edge_axis(p: Vec3A) -> usize {
    let off = |axis: usize| (p[axis] - p[axis].round()).abs();
    (0..3).max_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap_or(0)
}

/// The vertices with waves shorter than `wavelength` (in the largest spacing) taken away, within their half voxels.
///
/// All positions are voxel indices; `linear` leads to the world, where edges are measured. `rooms` say how far each
/// vertex may move.
pub(super) fn smoothed(
    start: &[Vec3A],
    rooms: &[[Vec3A; 2]],
    triangles: &[[u32; 3]],
    linear: DMat3,
    wavelength: f64,
) -> Vec<Vec3A> {
    // Lengths in units of the largest spacing.
    let spacing = [linear.x_axis, linear.y_axis, linear.z_axis].map(|s| s.length());
    let largest = spacing[0].max(spacing[1]).max(spacing[2]);
    let metric = (linear * (1.0 / largest)).as_mat3();
    let graph = Graph::new(start, triangles, metric.into());
    let highest = graph.highest();
    let cut_off = (std::f64::consts::TAU / wavelength).powi(2);
    let coefficients = low_pass(cut_off / highest);
    let mut placed = start.to_vec();
    for _ in 0..ROUNDS {
        let moved = graph.filtered_moves(&placed, highest as f32, &coefficients);
        placed.par_iter_mut().enumerate().for_each(|(v, p)| {
            let [low, high] = rooms[v];
            *p = start[v] + (*p + moved[v] - start[v]).clamp(low, high);
        });
    }
    placed
}

/// A graph whose Laplacian is that of the surface: weights are 4 / (n · length²) of `n` neighbours, as a wave `cos qx`
/// then has the eigenvalue q².
struct Graph(Neighbours);

impl Graph {
    /// The graph of a closed mesh; `metric` leads to where edges are measured.
    fn new(positions: &[Vec3A], triangles: &[[u32; 3]], metric: glam::Mat3A) -> Graph {
        let weight = |v: usize, to: usize, count: usize| {
            4.0 / (count as f32 * (metric * (positions[to] - positions[v])).length_squared())
        };
        Graph(Neighbours::new(positions.len(), triangles, weight))
    }

    /// A bound of the eigenvalues (Gershgorin).
    fn highest(&self) -> f64 {
        let row = |v: usize| self.0.of(v).iter().map(|l| l.1).sum::<f32>();
        2.0 * f64::from((0..self.0.len()).into_par_iter().map(row).reduce(|| f32::MIN_POSITIVE, f32::max))
    }

    /// The Laplacian of `field` at a vertex: weighted differences to its neighbours.
    #[inline]
    fn laplacian(&self, field: &[Vec3A], v: usize) -> Vec3A {
        let here = field[v];
        let mut sum = Vec3A::ZERO;
        for &(to, weight) in self.0.of(v) {
            sum += weight * (here - field[to as usize]);
        }
        sum
    }

    /// How far a filter moves each vertex: Σ cₙ Tₙ(y) p − p for y = 1 − 2L/highest, where the cₙ add up to 1.
    ///
    /// What is carried from step to step is dₙ = Tₙ p − p, small numbers that single precision holds well; it obeys
    /// dₙ₊₁ = 2 y dₙ − dₙ₋₁ + 2 d₁.
    fn filtered_moves(&self, positions: &[Vec3A], highest: f32, coefficients: &[f64]) -> Vec<Vec3A> {
        let factor = 2.0 / highest;
        let n = positions.len();
        let mut before = vec![Vec3A::ZERO; n];
        let mut now = vec![Vec3A::ZERO; n];
        now.par_iter_mut().enumerate().for_each(|(v, d)| *d = -factor * self.laplacian(positions, v));
        let first = now.clone();
        let weight = coefficients.get(1).copied().unwrap_or(0.0) as f32;
        let mut sum: Vec<Vec3A> = first.iter().map(|d| weight * *d).collect();
        for &c in coefficients.iter().skip(2) {
            let c = c as f32;
            // The new one takes the place of the one before the last.
            before.par_iter_mut().zip(&mut sum).enumerate().for_each(|(v, (d, sum))| {
                let turned = now[v] - factor * self.laplacian(&now, v);
                *d = 2.0 * (turned + first[v]) - *d;
                *sum += c * *d;
            });
            std::mem::swap(&mut before, &mut now);
        }
        sum
    }
}

/// Chebyshev coefficients of a low-pass filter with its middle at `cut_off` of the spectrum (0 to 1): an ideal step
/// under a Hamming window, long enough that the step ends at 1.5 times the cut-off frequency, and scaled to a response
/// of 1 at 0.
fn low_pass(cut_off: f64) -> Vec<f64> {
    let angle = (1.0 - 2.0 * cut_off.min(0.5)).acos();
    // A Hamming window makes the step 3.3 · 2π / (2 n + 1) wide.
    let degree = ((10.4 / angle).ceil() as usize).min(MOST_STEPS);
    let mut coefficients: Vec<f64> = (0..=degree)
        .map(|n| {
            let n = n as f64;
            let window = 0.54 + 0.46 * (std::f64::consts::PI * n / (degree as f64 + 1.0)).cos();
            let ideal = if n == 0.0 { angle } else { 2.0 * (n * angle).sin() / n };
            window * ideal
        })
        .collect();
    let sum: f64 = coefficients.iter().sum();
    coefficients.iter_mut().for_each(|c| *c /= sum);
    coefficients
}

/// Normals of the vertices: those of their triangles, each weighted by the sine of its angle over the lengths of its two
/// sides, which is exact for vertices on a sphere (Nelson Max, *Weights for Computing Vertex Normals from Facet
/// Normals*, 1999). A vertex between triangles without area keeps the normal it had, which `covector` leads to the world.
pub(super) fn vertex_normals(mesh: &mut RawMesh, covector: DMat3) {
    let place = |v: u32| Vec3::from_array(mesh.positions[v as usize]);
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for &t in &mesh.triangles {
        for corner in 0..3 {
            let [v, a, b] = [0, 1, 2].map(|k| t[(corner + k) % 3]);
            let (a, b) = (place(a) - place(v), place(b) - place(v));
            let lengths = a.length_squared() * b.length_squared();
            if lengths > 0.0 {
                sums[v as usize] += a.cross(b) / lengths;
            }
        }
    }
    for (normal, sum) in mesh.normals.iter_mut().zip(sums) {
        let kept = || (covector * Vec3::from_array(*normal).as_dvec3()).normalize_or_zero().as_vec3();
        *normal = sum.try_normalize().unwrap_or_else(kept).to_array();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The response of a filter at a part of the spectrum.
    fn response(coefficients: &[f64], part: f64) -> f64 {
        let angle = (1.0 - 2.0 * part).max(-1.0).acos();
        coefficients.iter().enumerate().map(|(n, c)| c * (n as f64 * angle).cos()).sum()
    }

    #[test]
    fn long_waves_pass_and_short_ones_do_not() {
        for cut_off in [0.3, 0.02, 0.001] {
            let filter = low_pass(cut_off);
            assert!((response(&filter, 0.0) - 1.0).abs() < 1e-12);
            // Frequencies go with the root of the spectrum.
            assert!((response(&filter, 0.2 * cut_off) - 1.0).abs() < 0.02);
            assert!((response(&filter, cut_off) - 0.5).abs() < 0.02);
            for part in (0..100).map(|i| 2.5 * cut_off + (1.0 - 2.5 * cut_off) * f64::from(i) / 99.0) {
                assert!(response(&filter, part).abs() < 0.01, "{cut_off} {part}");
            }
        }
    }

    /// The filter over a mesh against the polynomial of the matrix, written out in double precision.
    #[test]
    fn the_recurrence_is_the_polynomial() {
        let mesh = dotwork_mesh::shapes::sphere(1);
        let places: Vec<Vec3A> = mesh.positions.iter().map(|&p| Vec3A::from_array(p)).collect();
        let graph = Graph::new(&places, &mesh.triangles, glam::Mat3A::IDENTITY);
        let (highest, filter) = (graph.highest(), low_pass(0.1));
        let n = places.len();
        let step = |field: &[f64]| -> Vec<f64> {
            let row = |v: usize| {
                let links = graph.0.of(v);
                let sum: f64 =
                    links.iter().map(|&(to, w)| f64::from(w) * (field[v] - field[to as usize])).sum();
                field[v] - 2.0 * sum / highest
            };
            (0..n).map(row).collect()
        };
        let moves = graph.filtered_moves(&places, highest as f32, &filter);
        for axis in 0..3 {
            let start: Vec<f64> = places.iter().map(|p| f64::from(p[axis])).collect();
            let (mut before, mut now) = (start.clone(), step(&start));
            let mut sum: Vec<f64> = (0..n).map(|v| filter[0] * before[v] + filter[1] * now[v]).collect();
            for c in &filter[2..] {
                let turned = step(&now);
                let next: Vec<f64> = (0..n).map(|v| 2.0 * turned[v] - before[v]).collect();
                before = std::mem::replace(&mut now, next);
                (0..n).for_each(|v| sum[v] += c * now[v]);
            }
            for v in 0..n {
                assert!((start[v] + f64::from(moves[v][axis]) - sum[v]).abs() < 1e-5);
            }
        }
    }
}
