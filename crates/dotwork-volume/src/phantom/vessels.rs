//! A tree of vessels with an aneurysm, as an angiogram shows it.
//!
//! Vessels divide by Murray's law, `r³ = r₁³ + r₂³` ("The physiological principle of minimum work", 1926); the
//! thinner branch turns away more. Directions are drawn from a hash, so the tree is always the same.

use dotwork_drawing::hash::{hash2, unit};
use glam::{Vec3, vec3};

use super::distance::{cone, curve, ellipsoid, union};
use super::paint::{Grid, Layer, Noise, paint};
use crate::affine::Space;
use crate::samples::Sample;
use crate::volume::Volume;

/// Half the side of the scanned cube, millimetres.
const HALF: f32 = 64.0;

/// Vessels thinner than this are not followed, millimetres.
const THINNEST: f32 = 0.75;

/// Cells along a side of the grid in which segments are looked up.
const CELLS: usize = 32;

/// Distances are true up to here, millimetres, and beyond it at least this.
const REACH: f32 = 6.0;

/// A stretch of a vessel.
#[derive(Clone, Copy)]
struct Segment {
    from: Vec3,
    to: Vec3,
    radii: [f32; 2],
}

/// Where the aneurysm sits, its half axes and the neck by which it hangs.
const ANEURYSM: [Vec3; 2] = [vec3(10.0, -9.5, 6.0), vec3(9.5, 8.5, 10.5)];

/// Vessels of an angiogram: value 200 in tissue of 30, a main artery that bends and branches, with an aneurysm of
/// 19 × 17 × 21 mm at its first fork; 192³ voxels of 0.67 mm, `uint8`.
pub fn vessels() -> Volume {
    let grid = Grid::within(Vec3::splat(-HALF), Vec3::splat(HALF), 192, Space::Unknown);
    let tree = Tree::grow();
    let solid = |p: Vec3| tree.distance(p);
    let layers = [Layer { value: 200.0, solid: &solid, core: None }];
    grid.volume(u8::wrap(paint(&grid, 30.0, &layers, Noise::NONE)))
}

/// Segments, and which of them can be within [`REACH`] of each cell.
struct Tree {
    segments: Vec<Segment>,
    starts: Vec<u32>,
    near: Vec<u32>,
}

/// A branch yet to be followed.
struct Bud {
    at: Vec3,
    direction: Vec3,
    radius: f32,
    stream: u32,
}

/// A vector in the cube from −1 to 1.
fn draw(stream: u32, index: u32) -> Vec3 {
    let u = |axis| 2.0 * unit(hash2(3 * index + axis, stream)) - 1.0;
    vec3(u(0), u(1), u(2))
}

impl Tree {
    fn grow() -> Tree {
        // The trunk bends like a siphon before it forks.
        let trunk = [
            vec3(-6.0, 10.0, -70.0),
            vec3(-5.0, 10.0, -56.0),
            vec3(-1.0, 6.0, -44.0),
            vec3(6.0, -1.0, -35.0),
            vec3(10.0, -9.0, -26.0),
            vec3(7.0, -15.0, -17.0),
            vec3(1.0, -13.0, -9.0),
            vec3(-1.0, -6.0, -2.0),
            vec3(2.0, -2.0, 6.0),
        ];
        let mut segments: Vec<Segment> = curve(&trunk, 5)
            .windows(2)
            .enumerate()
            .map(|(i, p)| {
                let radius = |i: usize| 4.4 - 0.016 * i as f32;
                Segment { from: p[0], to: p[1], radii: [radius(i), radius(i + 1)] }
            })
            .collect();
        let bud = |at, direction: Vec3, radius, stream| Bud {
            at,
            direction: direction.normalize(),
            radius,
            stream,
        };
        let end = trunk[trunk.len() - 1];
        let mut buds = vec![
            bud(end, vec3(1.0, 0.1, 0.7), 3.0, 11),
            bud(end, vec3(-0.8, 0.3, 1.0), 2.7, 12),
            bud(trunk[7], vec3(-0.6, 1.0, -0.1), 1.9, 13),
            bud(trunk[4], vec3(1.0, -0.3, -0.4), 1.5, 14),
            bud(trunk[2], vec3(-1.0, -0.6, 0.2), 1.4, 15),
        ];
        while let Some(Bud { mut at, mut direction, radius, stream }) = buds.pop() {
            if radius < THINNEST {
                continue;
            }
            // A branch is some twelve radii long and wanders.
            let steps = 4 + hash2(0, stream) % 4;
            let step = 1.6 + 1.5 * radius;
            let mut r = radius;
            for i in 0..steps {
                // Away from the sides of the cube.
                let back = -at * (at.length() / HALF).powi(4) / HALF;
                direction =
                    (direction + 0.36 * draw(stream, i + 1) + 2.2 * back + 0.16 * Vec3::Z).normalize();
                let to = at + direction * step;
                let next = r * 0.985;
                segments.push(Segment { from: at, to, radii: [r, next] });
                (at, r) = (to, next);
            }
            let share = 0.28 + 0.4 * unit(hash2(1, stream));
            let aside = draw(stream, 40);
            let aside =
                (aside - direction * aside.dot(direction)).normalize_or(direction.any_orthonormal_vector());
            for (part, sign, branch) in [(1.0 - share, 1.0, 1), (share, -1.0, 2)] {
                // Murray: the flow, r³, is shared.
                let turn = sign * (1.25 - part);
                buds.push(bud(at, direction + aside * turn, r * part.cbrt(), hash2(branch, stream)));
            }
        }
        Tree::index(segments)
    }

    /// Lists the segments near each cell.
    fn index(segments: Vec<Segment>) -> Tree {
        let mut starts = vec![0];
        let mut near = Vec::new();
        for cell in 0..CELLS * CELLS * CELLS {
            let middle = Tree::middle([cell % CELLS, cell / CELLS % CELLS, cell / CELLS / CELLS]);
            let half_diagonal = 3f32.sqrt() * HALF / CELLS as f32;
            near.extend(
                (0..segments.len() as u32)
                    .filter(|&s| segments[s as usize].distance(middle) < REACH + half_diagonal),
            );
            starts.push(near.len() as u32);
        }
        Tree { segments, starts, near }
    }

    fn middle(cell: [usize; 3]) -> Vec3 {
        Vec3::from_array(cell.map(|i| (i as f32 + 0.5) * 2.0 * HALF / CELLS as f32 - HALF))
    }

    /// The distance to the tree; beyond [`REACH`] no more than that it is farther.
    fn distance(&self, p: Vec3) -> f32 {
        let [x, y, z] =
            p.to_array().map(|v| (((v + HALF) * CELLS as f32 / (2.0 * HALF)) as usize).min(CELLS - 1));
        let cell = x + CELLS * (y + CELLS * z);
        let near = &self.near[self.starts[cell] as usize..self.starts[cell + 1] as usize];
        let d = near.iter().fold(REACH, |d, &s| d.min(self.segments[s as usize].distance(p)));
        union(d, ellipsoid(p - ANEURYSM[0], ANEURYSM[1]), 3.0).min(REACH)
    }
}

impl Segment {
    fn distance(&self, p: Vec3) -> f32 {
        cone(p, self.from, self.to, self.radii[0], self.radii[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_finds_every_segment() {
        let tree = Tree::grow();
        assert!(tree.segments.len() > 150, "{} segments", tree.segments.len());
        for i in 0..20_000 {
            let p = draw(99, i) * HALF;
            let slow = tree.segments.iter().map(|s| s.distance(p)).fold(REACH, f32::min);
            let slow = union(slow, ellipsoid(p - ANEURYSM[0], ANEURYSM[1]), 3.0).min(REACH);
            assert_eq!(tree.distance(p), slow, "at {p}");
        }
    }

    #[test]
    fn the_tree_stays_in_its_cube_and_hangs_together() {
        let tree = Tree::grow();
        // The trunk alone enters from below.
        let mut outside = 0;
        for (i, s) in tree.segments.iter().enumerate() {
            outside += usize::from(s.to.z > -50.0 && s.to.abs().max_element() + s.radii[1] > HALF);
            let joined = |t: &Segment| t.to == s.from || (t.from == s.from && t.from != t.to);
            assert!(i == 0 || tree.segments[..i].iter().any(joined), "segment {i} hangs in the air");
        }
        assert_eq!(outside, 0);
    }

    #[test]
    fn values_are_those_of_blood_and_tissue() {
        let volume = vessels();
        let index = |v: f32| ((v + HALF) / (2.0 * HALF) * 192.0 - 0.5).round() as usize;
        let [x, y, z] = ANEURYSM[0].to_array().map(index);
        assert_eq!(volume.value_at(x, y, z), 200.0);
        assert_eq!(volume.value_at(0, 0, 100), 30.0);
        let full = (0..volume.samples().len()).filter(|&i| volume.samples().get(i) == 200.0).count();
        let empty = (0..volume.samples().len()).filter(|&i| volume.samples().get(i) == 30.0).count();
        let all = volume.samples().len();
        assert!(full * 500 > all && empty * 10 > all * 9, "{full} and {empty} of {all}");
    }
}
