//! Points for lists that the order over the whole mesh left too short.

use dotwork_drawing::hash::{hash2, unit};
use dotwork_mesh::Mesh;
use glam::Vec3;

use super::super::buckets::{Grid, Site};
use super::place;

/// Candidates for each point.
const CANDIDATES: u32 = 12;

/// No point of a list that ends here.
const NONE: u32 = u32::MAX;

/// Points and how they are found again: a chain for each bucket of the grid, to which more can be added.
struct Chains {
    grid: Grid,
    first: Vec<u32>,
    next: Vec<u32>,
    sites: Vec<Site>,
}

impl Chains {
    fn add(&mut self, site: Site) {
        let bucket = self.grid.bucket(self.grid.cell(site.position)) as usize;
        self.next.push(self.first[bucket]);
        self.first[bucket] = self.sites.len() as u32;
        self.sites.push(site);
    }

    /// Squared distance to the nearest point that sees `site`, at most `most`, if it is more than `least`.
    fn nearest(&self, site: &Site, least: f32, most: f32) -> Option<f32> {
        let [x, y, z] = self.grid.cell(site.position);
        let mut nearest = most;
        for dz in [0, -1, 1] {
            for dy in [0, -1, 1] {
                for dx in [0, -1, 1] {
                    let bucket = self.grid.bucket([x + dx, y + dy, z + dz]) as usize;
                    let mut i = self.first[bucket];
                    while i != NONE {
                        let other = &self.sites[i as usize];
                        let d2 = other.distance_squared(site.position);
                        if d2 < nearest && other.compatible(site.normal) {
                            nearest = d2;
                            if nearest <= least {
                                return None;
                            }
                        }
                        i = self.next[i as usize];
                    }
                }
            }
        }
        Some(nearest)
    }
}

/// `kept` points (face, place in its list, weights) and those that are missing from the lists of faces, each the one of
/// some candidates on its face that lies farthest from all that are there. `density`: points for each unit of area.
pub(super) fn fill(
    mesh: &Mesh,
    mut kept: Vec<(u32, u32, [f32; 2])>,
    missing: &[(u32, std::ops::Range<u32>)],
    density: f32,
    seed: u32,
) -> Vec<(u32, u32, [f32; 2])> {
    let spacing = (1.2 / density).sqrt();
    if missing.is_empty() || !spacing.is_finite() {
        return kept;
    }
    let min = mesh.positions.iter().fold(Vec3::MAX, |min, p| min.min(*p));
    let grid = Grid::new(min, spacing, kept.len());
    let mut chains =
        Chains { grid, first: vec![NONE; grid.bucket_count()], next: Vec::new(), sites: Vec::new() };
    for &(e, _, weights) in &kept {
        let (position, normal) = place(mesh, e, weights);
        chains.add(Site::new(position, normal));
    }
    let stream = hash2(7, seed);
    for (e, places) in missing {
        for k in places.clone() {
            let own = hash2(hash2(*e, stream), k);
            let mut best: Option<(f32, [f32; 2], Site)> = None;
            for j in 0..CANDIDATES {
                // Uniform on the triangle.
                let (s, t) = (unit(hash2(2 * j, own)).sqrt(), unit(hash2(2 * j + 1, own)));
                let weights = [s * (1.0 - t), s * t];
                let (position, normal) = place(mesh, *e, weights);
                let site = Site::new(position, normal);
                let least = best.as_ref().map_or(-1.0, |best| best.0);
                if let Some(d2) = chains.nearest(&site, least, spacing * spacing)
                    && d2 > least
                {
                    best = Some((d2, weights, site));
                }
            }
            // The first candidate is always better than none.
            if let Some((_, weights, site)) = best {
                chains.add(site);
                kept.push((*e, k, weights));
            }
        }
    }
    kept
}
