//! A few neighbours that stand for a ring: near, and on all sides.

use glam::Vec3;

use crate::topology::NONE;

/// Neighbours that are kept of a ring: Meruvia Pastor et al. 2003, section V-C, take "2 to 4".
pub const SPREAD: usize = 4;

/// Picks up to [`SPREAD`] of `ring` (nearest first): the nearest, then always the one whose direction, as seen from
/// `at`, is farthest from those picked; [`NONE`] where the ring is shorter.
#[inline]
pub(super) fn spread(
    at: Vec3,
    ring: impl Iterator<Item = u32>,
    position: impl Fn(u32) -> Vec3,
) -> [u32; SPREAD] {
    const MOST: usize = 12;
    let (mut who, mut way) = ([NONE; MOST], [Vec3::ZERO; MOST]);
    // Largest cosine to a direction already picked.
    let mut closest = [f32::NEG_INFINITY; MOST];
    let mut n = 0;
    for (w, k) in ring.zip(0..MOST) {
        who[k] = w;
        way[k] = (position(w) - at).normalize_or_zero();
        n = k + 1;
    }
    let mut picked = [NONE; SPREAD];
    let mut next = 0;
    for slot in picked.iter_mut().take(n.min(SPREAD)) {
        *slot = who[next];
        let direction = way[next];
        closest[next] = f32::INFINITY;
        let mut best = f32::INFINITY;
        for k in 0..n {
            closest[k] = closest[k].max(way[k].dot(direction));
            if closest[k] < best {
                (best, next) = (closest[k], k);
            }
        }
    }
    picked
}
