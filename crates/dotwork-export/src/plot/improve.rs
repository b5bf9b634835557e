//! A short tour by local improvement: 2-opt and Or-opt moves among near neighbours.
//!
//! The tour is open: it begins at the pen's place (`home`) and ends anywhere. A node without a place, at no distance from
//! everything, closes it into a ring: … last – end – home – first …; the edge end – home is never cut. Where points come in
//! pairs (the two ends of a stroke), the edge within a pair is never cut either.
//!
//! The ring is an array, and a move reverses a part of it, the shorter side (J. Bentley, "Fast algorithms for geometric
//! traveling salesman problems", 1992): for each point from a queue, moves that join it to one of its near neighbours
//! are tried, only while the new edge is shorter than the one given up; the ends of changed edges go back into the
//! queue. Or-opt moves a chain of up to three points to another place, by reversals too. Everything follows from the order
//! of the points, so the result is the same everywhere; the number of array elements moved is bounded.

use super::near::nearest_neighbours;

/// How much is tried.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    /// Near neighbours that a point may be joined to.
    pub(super) neighbours: usize,
    /// Array elements that may be moved, for each point. Dots need some 100, strokes and tight clusters up to 700; the
    /// tour is whole at every time, so that the bound costs length only.
    pub(super) swaps_a_point: usize,
    /// No reversal is longer: half a million points would otherwise move many long parts for little.
    pub(super) longest_reversal: usize,
}

impl Default for Effort {
    fn default() -> Effort {
        Effort { neighbours: 8, swaps_a_point: 2_000, longest_reversal: 50_000 }
    }
}

/// The most points in a chain that Or-opt moves: two strokes have four ends.
const CHAIN: usize = 4;

/// A gain must be larger than this share of the lengths compared, or rounding could go round in circles.
const GAIN: f64 = 1e-9;

/// The cost of an edge that must stay.
const FIXED: f64 = -1e15;

/// The order in which a pen that starts at `home` visits all `points` (finite, less than 10⁹ from the origin).
///
/// `points` should lie in a fair order already: it is the start. If `PAIRED`, points 2k and 2k + 1 are the ends of stroke
/// k and stay neighbours.
pub(super) fn short_tour<const PAIRED: bool>(
    points: &[[f32; 2]],
    home: [f32; 2],
    effort: Effort,
) -> Vec<u32> {
    let n = points.len();
    if n < 2 {
        return (0..n as u32).collect();
    }
    let mut ring = Ring::<PAIRED>::new(points, home);
    let (lists, k) = nearest_neighbours(&ring.points[..=n], effort.neighbours);
    ring.improve(&lists, k, effort);
    ring.order_from_home()
}

struct Ring<const PAIRED: bool> {
    /// The points, then home; the end has no place.
    points: Vec<[f32; 2]>,
    /// Node at each place of the ring.
    node: Vec<u32>,
    /// Place of each node.
    place: Vec<u32>,
    longest: usize,
    swaps_left: usize,
}

/// Nodes whose edges may have become improvable, first in, first out, none twice.
struct Queue {
    nodes: std::collections::VecDeque<u32>,
    waiting: Vec<bool>,
}

impl Queue {
    fn push(&mut self, nodes: impl IntoIterator<Item = u32>) {
        for node in nodes {
            if !std::mem::replace(&mut self.waiting[node as usize], true) {
                self.nodes.push_back(node);
            }
        }
    }

    fn pop(&mut self) -> Option<u32> {
        let node = self.nodes.pop_front()?;
        self.waiting[node as usize] = false;
        Some(node)
    }
}

impl<const PAIRED: bool> Ring<PAIRED> {
    fn new(points: &[[f32; 2]], home: [f32; 2]) -> Self {
        let n = points.len() as u32;
        let mut all = Vec::with_capacity(points.len() + 1);
        all.extend_from_slice(points);
        all.push(home);
        // Home first, end last: neighbours in the ring.
        let node: Vec<u32> = std::iter::once(n).chain(0..n).chain([n + 1]).collect();
        let mut place = vec![0; node.len()];
        for (at, &node) in node.iter().enumerate() {
            place[node as usize] = at as u32;
        }
        Ring { points: all, node, place, longest: 0, swaps_left: 0 }
    }

    fn home(&self) -> u32 {
        self.points.len() as u32 - 1
    }

    /// The length of the edge `a`–`b`.
    #[inline]
    fn length(&self, a: u32, b: u32) -> f64 {
        let home = self.home();
        if a.max(b) > home {
            return if a.min(b) == home { FIXED } else { 0.0 };
        }
        if PAIRED && a ^ 1 == b && a.max(b) < home {
            return FIXED;
        }
        let (a, b) = (self.points[a as usize], self.points[b as usize]);
        let (dx, dy) = (f64::from(a[0] - b[0]), f64::from(a[1] - b[1]));
        (dx * dx + dy * dy).sqrt()
    }

    #[inline]
    fn next(&self, node: u32) -> u32 {
        let at = self.place[node as usize] as usize + 1;
        self.node[if at == self.node.len() { 0 } else { at }]
    }

    #[inline]
    fn previous(&self, node: u32) -> u32 {
        let at = self.place[node as usize] as usize;
        self.node[if at == 0 { self.node.len() - 1 } else { at - 1 }]
    }

    #[inline]
    fn beside(&self, node: u32, forward: bool) -> u32 {
        if forward { self.next(node) } else { self.previous(node) }
    }

    fn improve(&mut self, lists: &[u32], k: usize, effort: Effort) {
        self.longest = effort.longest_reversal;
        self.swaps_left = effort.swaps_a_point.saturating_mul(self.points.len()).max(1 << 20);
        let mut queue = Queue { nodes: Default::default(), waiting: vec![false; self.node.len()] };
        queue.push(self.node.clone().into_iter().filter(|&node| node <= self.home()));
        while let Some(node) = queue.pop() {
            let near = &lists[node as usize * k..][..k];
            while self.improve_at(node, near, &mut queue) {
                if self.swaps_left == 0 {
                    return;
                }
            }
        }
    }

    /// Makes one improving move that joins `node` to one of `near`, if there is one.
    fn improve_at(&mut self, node: u32, near: &[u32], queue: &mut Queue) -> bool {
        for forward in [true, false] {
            if self.two_opt(node, near, forward, queue) || self.or_opt(node, near, forward, queue) {
                return true;
            }
        }
        false
    }

    /// Edges a–b and c–d become a–c and b–d, b beside a and d beside c in one direction.
    fn two_opt(&mut self, a: u32, near: &[u32], forward: bool, queue: &mut Queue) -> bool {
        let b = self.beside(a, forward);
        let ab = self.length(a, b);
        for &c in near {
            let ac = self.length(a, c);
            if ac >= ab {
                return false;
            }
            let d = self.beside(c, forward);
            if c == a || c == b || d == a {
                continue;
            }
            let (given, taken) = (ab + self.length(c, d), ac + self.length(b, d));
            if given - taken > GAIN * ab && self.reversal_fits(b, c) {
                if forward {
                    self.swap_edges(a, b, c, d)
                } else {
                    self.swap_edges(b, a, d, c)
                }
                queue.push([a, b, c, d].into_iter().filter(|&node| node <= self.home()));
                return true;
            }
        }
        false
    }

    /// The chain from `a` to `e`, up to [`CHAIN`] nodes in one direction, goes between `c`, a neighbour of `a`, and a node
    /// beside it.
    fn or_opt(&mut self, a: u32, near: &[u32], forward: bool, queue: &mut Queue) -> bool {
        if self.node.len() < 2 * CHAIN {
            return false;
        }
        let p = self.beside(a, !forward);
        let pa = self.length(p, a);
        let mut chain = [a; CHAIN];
        for length in 1..=CHAIN {
            if length > 1 {
                chain[length - 1] = self.beside(chain[length - 2], forward);
            }
            let chain = &chain[..length];
            let e = chain[length - 1];
            let q = self.beside(e, forward);
            let freed = pa + self.length(e, q) - self.length(p, q);
            // Where a stroke would be cut, nothing is freed.
            if freed <= 0.0 {
                continue;
            }
            for &c in near {
                let ac = self.length(a, c);
                if ac >= freed {
                    break;
                }
                if chain.contains(&c) {
                    continue;
                }
                for side in [true, false] {
                    let f = self.beside(c, side);
                    if chain.contains(&f) {
                        continue;
                    }
                    let taken = ac + self.length(e, f) - self.length(c, f);
                    if freed - taken > GAIN * (pa + ac) && self.reversal_fits(a, c) {
                        self.move_chain([p, a, e, q], [c, f]);
                        queue.push([p, a, e, q, c, f].into_iter().filter(|&node| node <= self.home()));
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Puts the chain a…e, which lies between p and q, between the neighbours c and f, a beside c: two or three
    /// exchanges, each of which moves the shorter part.
    fn move_chain(&mut self, [p, a, e, q]: [u32; 4], [c, f]: [u32; 2]) {
        let forward = self.next(p) == a;
        // In this direction the ring reads p a…e q…u v… and back to p.
        let (u, v) = if self.beside(c, forward) == f { (c, f) } else { (f, c) };
        // p u…q e…a v, then p q…u e…a v.
        self.exchange(p, a, u, v);
        self.exchange(p, u, q, e);
        if c == u {
            // p q…u a…e v.
            self.exchange(u, e, a, v);
        }
    }

    /// Edges a–b and c–d become a–c and b–d. The ring must read a b … c d in one direction.
    fn exchange(&mut self, a: u32, b: u32, c: u32, d: u32) {
        if self.next(a) == b && self.next(c) == d {
            self.swap_edges(a, b, c, d)
        } else {
            self.swap_edges(d, c, b, a)
        }
    }

    /// Nodes after `from` up to `to`, forward.
    fn length_between(&self, from: u32, to: u32) -> usize {
        let (from, to) = (self.place[from as usize] as usize, self.place[to as usize] as usize);
        if to >= from { to - from } else { to + self.node.len() - from }
    }

    /// True if a part between `a` and `b` may be reversed.
    #[inline]
    fn reversal_fits(&self, a: u32, b: u32) -> bool {
        let inner = self.length_between(a, b);
        inner.min(self.node.len() - inner) <= self.longest
    }

    /// The ring reads a b … c d forward: reverses b … c, or what lies outside.
    fn swap_edges(&mut self, a: u32, b: u32, c: u32, d: u32) {
        let n = self.node.len();
        let inner = self.length_between(b, c) + 1;
        let (from, to, count) = if 2 * inner <= n { (b, c, inner) } else { (d, a, n - inner) };
        let mut i = self.place[from as usize] as usize;
        let mut j = self.place[to as usize] as usize;
        for _ in 0..count / 2 {
            let (first, last) = (self.node[i], self.node[j]);
            self.node[i] = last;
            self.place[last as usize] = i as u32;
            self.node[j] = first;
            self.place[first as usize] = j as u32;
            i = if i + 1 == n { 0 } else { i + 1 };
            j = if j == 0 { n - 1 } else { j - 1 };
        }
        self.swaps_left = self.swaps_left.saturating_sub(count / 2 + 1);
    }

    /// The points from home on.
    fn order_from_home(&self) -> Vec<u32> {
        let home = self.home();
        let forward = self.next(home) != home + 1;
        let mut order = Vec::with_capacity(self.points.len() - 1);
        let mut node = self.beside(home, forward);
        while node < home {
            order.push(node);
            node = self.beside(node, forward);
        }
        order
    }
}
