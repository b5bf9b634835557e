//! Closed shapes with known areas, volumes, normals and curvatures.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;

use super::grid::Patches;
use super::raw;
use crate::RawMesh;

/// A sphere of radius 1 about the origin: an icosahedron whose triangles are cut in four `subdivisions` times, 20 · 4ⁿ
/// triangles, vertices on the sphere. More than 10 subdivisions (21 million triangles) count as 10.
pub fn sphere(subdivisions: u32) -> RawMesh {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let (o, i) = (0.0, 1.0);
    let mut points: Vec<DVec3> = [
        [-i, g, o],
        [i, g, o],
        [-i, -g, o],
        [i, -g, o],
        [o, -i, g],
        [o, i, g],
        [o, -i, -g],
        [o, i, -g],
        [g, o, -i],
        [g, o, i],
        [-g, o, -i],
        [-g, o, i],
    ]
    .map(|p| DVec3::from(p).normalize())
    .to_vec();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..subdivisions.min(10) {
        let mut middles = HashMap::with_capacity(3 * triangles.len() / 2);
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    points.push((points[p as usize] + points[q as usize]).normalize());
                    points.len() as u32 - 1
                })
            });
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    raw(points.into_iter().map(|p| p.as_vec3().to_array()).collect(), triangles)
}

/// A torus about the y axis: the circle of radius `r` whose centre runs on the circle of radius `big_r` (> `r`) in the
/// xz plane; `nu` quads along that, `nv` around the tube (at least 3 each). Volume 2π²Rr², area 4π²Rr.
pub fn torus(big_r: f64, r: f64, nu: usize, nv: usize) -> RawMesh {
    let (nu, nv) = (nu.max(3), nv.max(3));
    let mut positions = Vec::with_capacity(nu * nv);
    let mut triangles = Vec::with_capacity(2 * nu * nv);
    for i in 0..nu {
        let (su, cu) = (TAU * i as f64 / nu as f64).sin_cos();
        for j in 0..nv {
            let (sv, cv) = (TAU * j as f64 / nv as f64).sin_cos();
            let ring = big_r + r * cv;
            positions.push([ring * su, r * sv, ring * cu].map(|c| c as f32));
            let at = |i: usize, j: usize| (i % nu * nv + j % nv) as u32;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    raw(positions, triangles)
}

/// A closed thin box: a sheet of side 1 in the xy plane, `thickness` deep in z, centred on the origin, with `n` × `n`
/// cells on the faces (at least one) and one cell across the rim. Both faces are seen through each other if hidden
/// points are not taken away.
pub fn sheet(thickness: f64, n: usize) -> RawMesh {
    let n = n.max(1);
    let h = 0.5 * thickness;
    let mut patches = Patches::default();
    let side = |u: f64| u - 0.5;
    patches.add(n, n, false, |u, v| [side(u), side(v), h]);
    patches.add(n, n, true, |u, v| [side(u), side(v), -h]);
    let z = |v: f64| if v == 0.0 { -h } else { h };
    patches.add(n, 1, false, |u, v| [side(u), -0.5, z(v)]);
    patches.add(n, 1, true, |u, v| [side(u), 0.5, z(v)]);
    patches.add(n, 1, true, |u, v| [-0.5, side(u), z(v)]);
    patches.add(n, 1, false, |u, v| [0.5, side(u), z(v)]);
    patches.weld()
}

/// A closed cylinder about the y axis, centred on the origin: `n` sides (at least 3), its wall cut `rows` times along
/// the axis, its ends fans of triangles about a centre vertex.
pub fn cylinder(radius: f64, height: f64, n: usize, rows: usize) -> RawMesh {
    let (n, rows) = (n.max(3), rows.max(1));
    let circle: Vec<[f64; 2]> = (0..n)
        .map(|i| (TAU * i as f64 / n as f64).sin_cos())
        .map(|(s, c)| [radius * s, radius * c])
        .collect();
    let at = |u: f64| circle[(u * n as f64).round() as usize % n];
    let half = 0.5 * height;
    let level = |v: f64| if v == 0.0 { -half } else { half };
    let mut patches = Patches::default();
    patches.add(n, rows, false, |u, v| [at(u)[0], height * (v - 0.5), at(u)[1]]);
    for (end, turned) in [(0.0, true), (1.0, false)] {
        patches.add(n, 1, turned, |u, v| {
            if v == 0.0 { [at(u)[0], level(end), at(u)[1]] } else { [0.0, level(end), 0.0] }
        });
    }
    patches.weld()
}
