//! The nearest neighbours of every point, by a k-d tree: bounded work for clusters and duplicates too.
//!
//! A grid is simpler, but a cell that holds half of all points would make the search quadratic.

use rayon::prelude::*;

/// Points in a leaf.
const LEAF: usize = 8;

/// No lists are longer.
pub(super) const MAX_NEIGHBOURS: usize = 16;

/// A k-d tree over points: `order` is halved at its median again and again, along the longer side of each box.
struct Tree<'a> {
    points: &'a [[f32; 2]],
    order: Vec<u32>,
    /// Axis and coordinate of each split, at the middle of its range.
    cuts: Vec<(u8, f32)>,
}

impl<'a> Tree<'a> {
    fn new(points: &'a [[f32; 2]]) -> Tree<'a> {
        let mut tree =
            Tree { points, order: (0..points.len() as u32).collect(), cuts: vec![(0, 0.0); points.len()] };
        split(points, &mut tree.order, &mut tree.cuts);
        tree
    }

    /// Offers the points of `range` that may be near to `nearest`, the nearer half first.
    fn search(&self, from: usize, to: usize, query: [f32; 2], nearest: &mut Nearest) {
        if to - from <= LEAF {
            for &i in &self.order[from..to] {
                let p = self.points[i as usize];
                nearest.offer(square(p[0] - query[0]) + square(p[1] - query[1]), i);
            }
            return;
        }
        let middle = (from + to) / 2;
        let (axis, cut) = self.cuts[middle];
        let offset = query[usize::from(axis)] - cut;
        let (near, far) =
            if offset < 0.0 { ((from, middle), (middle, to)) } else { ((middle, to), (from, middle)) };
        self.search(near.0, near.1, query, nearest);
        if square(offset) < nearest.worst() {
            self.search(far.0, far.1, query, nearest);
        }
    }
}

fn square(v: f32) -> f32 {
    v * v
}

/// Halves `order` and its halves; the depth is the logarithm of the length.
fn split(points: &[[f32; 2]], order: &mut [u32], cuts: &mut [(u8, f32)]) {
    if order.len() <= LEAF {
        return;
    }
    let mut low = [f32::INFINITY; 2];
    let mut high = [f32::NEG_INFINITY; 2];
    for &i in order.iter() {
        for axis in 0..2 {
            low[axis] = low[axis].min(points[i as usize][axis]);
            high[axis] = high[axis].max(points[i as usize][axis]);
        }
    }
    let axis = usize::from(high[1] - low[1] > high[0] - low[0]);
    let middle = order.len() / 2;
    let key = |i: &u32| points[*i as usize][axis];
    order.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    cuts[middle] = (axis as u8, key(&order[middle]));
    let (left, right) = order.split_at_mut(middle);
    let (left_cuts, right_cuts) = cuts.split_at_mut(middle);
    split(points, left, left_cuts);
    // The right half begins at this cut's place; its own cuts lie further inside.
    split(points, right, right_cuts);
}

/// The nearest points found so far, nearest first.
struct Nearest {
    found: [(f32, u32); MAX_NEIGHBOURS],
    wanted: usize,
    own: u32,
}

impl Nearest {
    fn worst(&self) -> f32 {
        self.found[self.wanted - 1].0
    }

    fn offer(&mut self, distance: f32, index: u32) {
        if distance >= self.worst() || index == self.own {
            return;
        }
        let mut at = self.wanted - 1;
        while at > 0 && (distance, index) < self.found[at - 1] {
            self.found[at] = self.found[at - 1];
            at -= 1;
        }
        self.found[at] = (distance, index);
    }
}

/// The `k` (at most [`MAX_NEIGHBOURS`]) nearest other points of each finite point, nearest first, one list behind the
/// other; all lists have `min(k, points − 1)` entries, and that number is returned too.
pub(super) fn nearest_neighbours(points: &[[f32; 2]], k: usize) -> (Vec<u32>, usize) {
    let k = k.min(MAX_NEIGHBOURS).min(points.len().saturating_sub(1));
    if k == 0 {
        return (Vec::new(), 0);
    }
    let tree = Tree::new(points);
    let mut lists = vec![0; points.len() * k];
    lists.par_chunks_mut(k).enumerate().with_min_len(1024).for_each(|(i, list)| {
        let mut nearest =
            Nearest { found: [(f32::INFINITY, u32::MAX); MAX_NEIGHBOURS], wanted: k, own: i as u32 };
        tree.search(0, points.len(), points[i], &mut nearest);
        for (to, (_, index)) in list.iter_mut().zip(nearest.found) {
            // Only distances beyond all numbers leave a place unfilled.
            *to = if index == u32::MAX { i as u32 } else { index };
        }
    });
    (lists, k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::hash::{hash2, unit};

    fn check(points: &[[f32; 2]], k: usize) {
        let (lists, k) = nearest_neighbours(points, k);
        assert_eq!(lists.len(), points.len() * k);
        for (i, list) in lists.chunks(k.max(1)).enumerate() {
            let distance = |j: u32| {
                let p = points[j as usize];
                square(p[0] - points[i][0]) + square(p[1] - points[i][1])
            };
            let mut all: Vec<f32> =
                (0..points.len() as u32).filter(|&j| j != i as u32).map(distance).collect();
            all.sort_by(f32::total_cmp);
            let found: Vec<f32> = list.iter().map(|&j| distance(j)).collect();
            assert_eq!(found, all[..k], "point {i}");
            let mut unique = list.to_vec();
            unique.sort_unstable();
            unique.dedup();
            assert!(unique.len() == k && !unique.contains(&(i as u32)));
        }
    }

    #[test]
    fn neighbours_are_the_nearest() {
        let random = |i: u32| [unit(hash2(i, 0)), unit(hash2(i, 1)) * 0.1];
        for n in [0, 1, 2, 5, 9, 100, 700] {
            check(&(0..n).map(random).collect::<Vec<_>>(), 8);
        }
        check(&(0..400).map(|i| [(i % 20) as f32, (i / 20) as f32]).collect::<Vec<_>>(), 12);
        // Duplicates, and a line.
        check(&(0..300).map(|i| [(i % 3) as f32, 0.0]).collect::<Vec<_>>(), 8);
    }

    #[test]
    fn many_points_in_one_place_take_bounded_time() {
        let (lists, k) = nearest_neighbours(&vec![[1.0, 1.0]; 100_000], 8);
        assert_eq!(lists.len(), 100_000 * k);
    }
}
