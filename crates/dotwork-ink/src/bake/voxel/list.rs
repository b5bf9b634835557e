//! The list of a voxel's stipples: an order of points in its section of which every beginning is even.
//!
//! Lu et al. place points at random and move them until they are about equally far apart (2002, 4.3). Here the points
//! are chosen instead: each is, among random candidates, the one farthest from those before it, which gives the same
//! near-Poisson arrangement and an order at once. Distances have no borders, so that the first points of a voxel lie
//! anywhere in it alike and voxels do not repeat as a grid.

use dotwork_drawing::hash::{hash2, unit};
use glam::Vec2;

use super::section::Section;

/// Candidates for each point, for short lists and at least.
const CANDIDATES: usize = 8;
const MIN_CANDIDATES: usize = 64;
const MANY_CANDIDATES: usize = 2048;
const LEAST: usize = 3;

/// From this length on candidates without hope are let go.
const LONG: usize = 32;
const NEAR: f32 = 0.6;

/// The points keep this share of their final distance from the section's border: what lies beyond it belongs to lists
/// that know nothing of this one.
const BORDER: f32 = 0.25;

/// Memory of one list's making, used again for the next.
#[derive(Default)]
pub(super) struct Scratch {
    st: Vec<Vec2>,
    f: Vec<f32>,
    g: Vec<f32>,
    /// Squared distance of each candidate to the nearest point so far.
    nearest: Vec<f32>,
}

/// Fills `points` with (s, t) coordinates of a list, every beginning of which is even.
pub(super) fn fill(section: &Section, seed: u32, scratch: &mut Scratch, points: &mut [Vec2]) {
    let n = points.len();
    let wanted = (CANDIDATES * n).clamp(MIN_CANDIDATES, MANY_CANDIDATES).max(LEAST * n);
    let Scratch { st, f, g, nearest } = scratch;
    st.clear();
    // The hexagonal distance of n points on a square of area 1, on both sides.
    let inside = (1.0 - 2.0 * BORDER * 1.07 / (n as f32).sqrt()).max(0.7);
    // A section is at least three quarters of its square, so this ends.
    for j in 0.. {
        let at = Vec2::new(unit(hash2(2 * j, seed)) - 0.5, unit(hash2(2 * j + 1, seed)) - 0.5);
        if section.contains(at) {
            st.push(inside * at);
            if st.len() == wanted {
                break;
            }
        }
    }
    f.clear();
    f.extend(st.iter().map(|&at| section.lattice(at).x));
    g.clear();
    g.extend(st.iter().map(|&at| section.lattice(at).y));
    nearest.clear();
    nearest.resize(wanted, f32::MAX);
    // Nearer to a point than this a candidate is never the farthest: `NEAR` of the hexagonal distance of n points.
    let hopeless = NEAR * NEAR * 1.1547 * section.area / n as f32;
    let mut chosen = 0;
    for (k, point) in points.iter_mut().enumerate() {
        *point = st[chosen];
        if k + 1 == n {
            break;
        }
        let (f0, g0) = (f[chosen], g[chosen]);
        if n >= LONG && k > 0 && k % (n / 16) == 0 {
            let mut kept = 0;
            for j in 0..nearest.len() {
                if nearest[j] >= hopeless {
                    (st[kept], f[kept], g[kept], nearest[kept]) = (st[j], f[j], g[j], nearest[j]);
                    kept += 1;
                }
            }
            // Where nothing has hope, the best of it has to do.
            if kept > 0 {
                st.truncate(kept);
                f.truncate(kept);
                g.truncate(kept);
                nearest.truncate(kept);
            }
        }
        // Distances are not negative, so their bits are ordered as they are, and integers have a maximum in vectors.
        let mut farthest = 0i32;
        for ((f, g), nearest) in f.iter().zip(g.iter()).zip(nearest.iter_mut()) {
            let d2 = section.distance_squared(f - f0, g - g0).max(0.0);
            *nearest = if d2 < *nearest { d2 } else { *nearest };
            farthest = farthest.max(nearest.to_bits() as i32);
        }
        chosen = nearest.iter().position(|d2| d2.to_bits() as i32 == farthest).unwrap_or(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn beginnings_are_even_in_the_section() {
        let edges = [Vec3::X, Vec3::Y, Vec3::Z];
        let mut scratch = Scratch::default();
        for normal in [Vec3::Z, Vec3::ONE.normalize(), Vec3::new(0.0, 1.0, 1.0).normalize()] {
            let section = Section::new(edges, normal).unwrap();
            for n in [9usize, 25, 100] {
                for beginning in [n / 2, n] {
                    let (mut mean, mut least) = (0.0, f32::MAX);
                    let lists = 100;
                    for seed in 0..lists {
                        let mut points = vec![Vec2::ZERO; n];
                        fill(&section, seed, &mut scratch, &mut points);
                        let hexagonal = (2.0 * section.area / (3f32.sqrt() * beginning as f32)).sqrt();
                        for (i, p) in points[..beginning].iter().enumerate() {
                            let others = points[..beginning].iter().enumerate().filter(|(j, _)| *j != i);
                            let d =
                                others.map(|(_, q)| section.place(p - q).length()).fold(f32::MAX, f32::min);
                            mean += d / hexagonal / (beginning as f32 * lists as f32);
                            least = least.min(d / hexagonal);
                        }
                    }
                    assert!(mean > 0.72 && least > 0.4, "{normal} {beginning} of {n}: {mean} {least}");
                }
            }
        }
    }

    #[test]
    fn the_first_point_lies_anywhere() {
        let section = Section::new([Vec3::X, Vec3::Y, Vec3::Z], Vec3::Z).unwrap();
        let mut scratch = Scratch::default();
        let mut quarters = [0; 16];
        for seed in 0..8000 {
            let mut points = [Vec2::ZERO; 16];
            fill(&section, hash2(seed, 5), &mut scratch, &mut points);
            // Within the border that a list of 16 keeps.
            let inside = 1.0 - 0.5 * 1.07 / 4.0;
            let cell = ((points[0] / inside + 0.5) * 4.0).floor();
            quarters[(cell.x + 4.0 * cell.y) as usize] += 1;
        }
        // 500 each; five standard deviations.
        assert!(quarters.iter().all(|c| (390..=610).contains(c)), "{quarters:?}");
    }
}
