//! Creases of surfaces that have no sharp edges: ridges of curvature.
//!
//! In the isosurface of a volume every edge is rounded over a voxel or two. It is found as the line along which the
//! larger principal curvature is larger than beside it: the curvature tensor of each triangle follows from the
//! differences of its corners' normals (Rusinkiewicz 2004), vertices take the mean by area, and the line is the zero set
//! of the curvature's derivative along its own direction (Ohtake et al. 2004), traced through triangles as contours are.
//! As in edge detection (Canny 1986), a line begins where the curvature is high and goes on while it is not low; what
//! stays short is noise.

use dotwork_mesh::Mesh;
use glam::{Mat3, Vec3};
use rayon::prelude::*;

/// Rounds in which tensors are averaged with their neighbours'.
const ROUNDS: usize = 3;

/// Rounds in which the points of a line are averaged with their neighbours.
const EVENING: usize = 12;

/// A line goes on while its curvature is above this share of what it begins with.
const LOW: f32 = 0.6;

/// Chains of points on a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ridges {
    /// The points, object units.
    pub point: Vec<Vec3>,
    /// One past the last point of each chain. A closed chain repeats its first point.
    pub end: Vec<u32>,
}

impl Ridges {
    /// The ridges with radii of curvature up to `radius` that are at least `shortest` long, object units.
    pub fn find(mesh: &Mesh, radius: f32, shortest: f32) -> Ridges {
        let field = Field::of(mesh);
        let (high, low) = (1.0 / radius, LOW / radius);
        let segments: Vec<Segment> = (0..mesh.triangles.len())
            .into_par_iter()
            .with_min_len(4096)
            .filter_map(|t| field.segment(mesh, mesh.triangles[t], low))
            .collect();
        let mut ridges = Ridges::default();
        join(&segments, |chain| {
            let length: f32 = chain.windows(2).map(|w| w[0].0.distance(w[1].0)).sum();
            if length >= shortest && chain.iter().any(|p| p.1 >= high) {
                let start = ridges.point.len();
                ridges.point.extend(chain.iter().map(|p| p.0));
                even_out(&mut ridges.point[start..]);
                ridges.end.push(ridges.point.len() as u32);
            }
        });
        ridges
    }

    /// The points of chain `k`.
    pub fn points(&self, k: usize) -> &[Vec3] {
        let start = if k == 0 { 0 } else { self.end[k - 1] as usize };
        &self.point[start..self.end[k] as usize]
    }
}

/// A piece of ridge in a triangle: the edges that it crosses, and where, with the curvature there.
struct Segment {
    edge: [(u32, u32); 2],
    at: [(Vec3, f32); 2],
}

/// What is known of the curvature at each vertex.
struct Field {
    /// The larger principal curvature, its sign aside.
    curvature: Vec<f32>,
    /// Its direction; either of the two.
    direction: Vec<Vec3>,
    /// How the curvature changes over the surface.
    gradient: Vec<Vec3>,
}

impl Field {
    fn of(mesh: &Mesh) -> Field {
        let topology = mesh.topology();
        let vertices = mesh.positions.len() as u32;
        // Twice the area, and the tensor times that.
        let faces: Vec<(f32, Mat3)> =
            mesh.triangles.par_iter().enumerate().map(|(t, _)| tensor(mesh, t)).collect();
        let mut tensors: Vec<Mat3> = (0..vertices)
            .into_par_iter()
            .map(|v| {
                let (mut area, mut sum) = (0.0, Mat3::ZERO);
                for &t in topology.faces(v) {
                    area += faces[t as usize].0;
                    sum += faces[t as usize].1;
                }
                if area > 0.0 { sum * (1.0 / area) } else { Mat3::ZERO }
            })
            .collect();
        for _ in 0..ROUNDS {
            tensors = (0..vertices)
                .into_par_iter()
                .map(|v| {
                    let (mut count, mut sum) = (0.0, Mat3::ZERO);
                    for &t in topology.faces(v) {
                        for w in mesh.triangles[t as usize] {
                            sum += tensors[w as usize];
                            count += 1.0;
                        }
                    }
                    if count > 0.0 { sum * (1.0 / count) } else { Mat3::ZERO }
                })
                .collect();
        }
        let (curvature, direction): (Vec<f32>, Vec<Vec3>) =
            (0..vertices as usize).into_par_iter().map(|v| principal(tensors[v], mesh.normals[v])).unzip();
        let slopes: Vec<(f32, Vec3)> = mesh
            .triangles
            .par_iter()
            .map(|&t| {
                let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
                let [fa, fb, fc] = t.map(|v| curvature[v as usize]);
                let n = (b - a).cross(c - a);
                let area = n.length();
                // The gradient times the area; slivers have none to speak of.
                let slope = n.cross((c - a) * (fa - fb) + (b - a) * (fc - fa));
                if area > 0.0 { (area, slope / area) } else { (0.0, Vec3::ZERO) }
            })
            .collect();
        let gradient = (0..vertices)
            .into_par_iter()
            .map(|v| {
                let (mut area, mut sum) = (0.0, Vec3::ZERO);
                for &t in topology.faces(v) {
                    area += slopes[t as usize].0;
                    sum += slopes[t as usize].1;
                }
                if area > 0.0 { sum / area } else { Vec3::ZERO }
            })
            .collect();
        Field { curvature, direction, gradient }
    }

    /// The ridge in a triangle.
    fn segment(&self, mesh: &Mesh, triangle: [u32; 3], low: f32) -> Option<Segment> {
        let f = triangle.map(|v| self.curvature[v as usize]);
        if f.iter().any(|&f| f < low) {
            return None;
        }
        let d = triangle.map(|v| self.direction[v as usize]);
        // Directions have no sign: those of the corners are made to agree with the first one's.
        let d = d.map(|v| if v.dot(d[0]) < 0.0 { -v } else { v });
        let e = [0, 1, 2].map(|k| self.gradient[triangle[k] as usize].dot(d[k]));
        if (e[0] >= 0.0) == (e[1] >= 0.0) && (e[1] >= 0.0) == (e[2] >= 0.0) {
            return None;
        }
        let p = triangle.map(|v| mesh.positions[v as usize]);
        // A maximum across: the derivative falls along the direction.
        let (ab, ac) = (p[1] - p[0], p[2] - p[0]);
        let n = ab.cross(ac);
        let slope = n.cross(ac * (e[0] - e[1]) + ab * (e[2] - e[0]));
        if slope.dot(d[0] + d[1] + d[2]) >= 0.0 {
            return None;
        }
        let mut edge = [(0, 0); 2];
        let mut at = [(Vec3::ZERO, 0.0); 2];
        let mut count = 0;
        for k in 0..3 {
            let next = (k + 1) % 3;
            if (e[k] >= 0.0) != (e[next] >= 0.0) {
                let (i, j) = if triangle[k] < triangle[next] { (k, next) } else { (next, k) };
                let s = e[i] / (e[i] - e[j]);
                edge[count] = (triangle[i], triangle[j]);
                at[count] = (p[i] + (p[j] - p[i]) * s, f[i] + (f[j] - f[i]) * s);
                count += 1;
            }
        }
        Some(Segment { edge, at })
    }
}

/// Twice the area of a triangle, and its curvature tensor times that: the symmetric linear map from steps in the triangle
/// to changes of the normal that fits its three edges best.
fn tensor(mesh: &Mesh, t: usize) -> (f32, Mat3) {
    let p = mesh.triangles[t].map(|v| mesh.positions[v as usize]);
    let n = mesh.corner_normals[t].map(|n| mesh.normals[n as usize]);
    let cross = (p[1] - p[0]).cross(p[2] - p[0]);
    let area = cross.length();
    let u = (p[1] - p[0]).normalize_or_zero();
    let v = cross.normalize_or_zero().cross(u);
    // Normal equations for the form [a b; b c]: (a s + b t, b s + c t) = (du, dv) for each edge (s, t).
    let (mut ss, mut st, mut tt) = (0.0, 0.0, 0.0);
    let mut right = Vec3::ZERO;
    for k in 0..3 {
        let (edge, change) = (p[(k + 1) % 3] - p[k], n[(k + 1) % 3] - n[k]);
        let (s, t, du, dv) = (edge.dot(u), edge.dot(v), change.dot(u), change.dot(v));
        (ss, st, tt) = (ss + s * s, st + s * t, tt + t * t);
        right += Vec3::new(s * du, t * du + s * dv, t * dv);
    }
    let matrix = Mat3::from_cols(Vec3::new(ss, st, 0.0), Vec3::new(st, ss + tt, st), Vec3::new(0.0, st, tt));
    // Slivers say nothing across themselves.
    if matrix.determinant() <= 1e-6 * (ss + tt).powi(3) {
        return (0.0, Mat3::ZERO);
    }
    let form = matrix.inverse() * right;
    let outer = |a: Vec3, b: Vec3| Mat3::from_cols(a * b.x, a * b.y, a * b.z);
    let tensor = outer(u, u) * form.x + (outer(u, v) + outer(v, u)) * form.y + outer(v, v) * form.z;
    (area, tensor * area)
}

/// The principal curvature that is larger in size, and its direction across the normal.
fn principal(tensor: Mat3, normal: Vec3) -> (f32, Vec3) {
    let (u, v) = normal.any_orthonormal_pair();
    let (tu, tv) = (tensor * u, tensor * v);
    let (a, b, c) = (u.dot(tu), u.dot(tv), v.dot(tv));
    let (middle, spread) = (0.5 * (a + c), (0.25 * (a - c) * (a - c) + b * b).sqrt());
    let k = if middle < 0.0 { middle - spread } else { middle + spread };
    // (form − k) x = 0, by its longer row.
    let (first, second) = ((b, k - a), (k - c, b));
    let long = |r: (f32, f32)| r.0 * r.0 + r.1 * r.1;
    let (x, y) = if long(first) > long(second) { first } else { second };
    (k.abs(), (u * x + v * y).normalize_or(u))
}

/// Takes the steps out of a line; its ends stay.
fn even_out(points: &mut [Vec3]) {
    let last = points.len() - 1;
    let closed = last > 2 && points[0] == points[last];
    for _ in 0..EVENING {
        let mut before = if closed { points[last - 1] } else { points[0] };
        let first = points[0];
        for i in 0..last {
            let here = points[i];
            if i > 0 || closed {
                let next = if closed && i + 1 == last { first } else { points[i + 1] };
                points[i] = (before + here * 2.0 + next) * 0.25;
            }
            before = here;
        }
        if closed {
            points[last] = points[0];
        }
    }
}

/// Follows segments from edge to edge and hands over each chain.
fn join(segments: &[Segment], mut chain_found: impl FnMut(&[(Vec3, f32)])) {
    let mut ends: Vec<((u32, u32), u32)> = Vec::with_capacity(2 * segments.len());
    for (s, segment) in segments.iter().enumerate() {
        ends.extend([(segment.edge[0], 2 * s as u32), (segment.edge[1], 2 * s as u32 + 1)]);
    }
    ends.par_sort_unstable();
    let mut meets = vec![u32::MAX; ends.len()];
    for same in ends.chunk_by(|a, b| a.0 == b.0) {
        for pair in same.chunks_exact(2) {
            (meets[pair[0].1 as usize], meets[pair[1].1 as usize]) = (pair[1].1, pair[0].1);
        }
    }
    let mut used = vec![false; segments.len()];
    let mut chain = Vec::new();
    for closed in [false, true] {
        for s in 0..segments.len() as u32 {
            let free = [2 * s, 2 * s + 1].into_iter().find(|&e| closed || meets[e as usize] == u32::MAX);
            let (Some(mut end), false) = (free, used[s as usize]) else { continue };
            chain.clear();
            chain.push(segments[s as usize].at[end as usize % 2]);
            loop {
                used[end as usize / 2] = true;
                chain.push(segments[end as usize / 2].at[(end ^ 1) as usize % 2]);
                end = meets[(end ^ 1) as usize];
                if end == u32::MAX || used[end as usize / 2] {
                    break;
                }
            }
            chain_found(&chain);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::Warnings;
    use dotwork_mesh::{MeshOptions, shapes};

    #[test]
    fn the_curvature_of_a_torus_is_that_of_its_tube() {
        let raw = shapes::torus(1.0, 0.25, 96, 32);
        let torus = Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap();
        let field = Field::of(&torus);
        for (&k, &d) in field.curvature.iter().zip(&field.direction) {
            assert!((k / 4.0 - 1.0).abs() < 0.1, "{k}");
            assert!((d.length() - 1.0).abs() < 1e-3);
        }
        // Around the tube it is the same everywhere: there is no crease.
        assert_eq!(Ridges::find(&torus, 0.1, 0.5), Ridges::default());
    }

    #[test]
    fn the_rim_of_a_lens_is_one_closed_line() {
        // A sphere pressed flat is curved most along its equator: at radius b² / a.
        let mut raw = shapes::sphere(5);
        raw.positions.iter_mut().for_each(|p| p[1] *= 0.25);
        let lens = Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap();
        let ridges = Ridges::find(&lens, 0.1, 1.0);
        let length: f32 = (0..ridges.end.len())
            .map(|k| ridges.points(k).windows(2).map(|w| w[0].distance(w[1])).sum::<f32>())
            .sum();
        assert!((length / std::f32::consts::TAU - 1.0).abs() < 0.05, "{length}");
        assert!(ridges.point.iter().all(|p| p.y.abs() < 0.02));
        assert_eq!(Ridges::find(&lens, 0.02, 1.0), Ridges::default(), "nothing is as sharp as that");
    }
}
