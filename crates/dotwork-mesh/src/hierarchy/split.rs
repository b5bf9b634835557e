//! Longest-edge splits of the randomised mesh, each new vertex randomised and projected onto the input mesh.

use dotwork_drawing::hash::{hash2, unit};
use glam::Vec3;
use rayon::prelude::*;

use super::list::{EMPTY, LIST, List, entries, entry, insert, mean, vertex};
use super::project::{Ground, Hit};
use super::queues::Queues;
use super::spread::{SPREAD, spread};
use crate::topology::{NONE, same_direction};

/// Bits of a squared length that are dropped for its step: 8 steps an octave, so that lengths within one differ by
/// 6 % at most. More would be more exact, but each step goes once over the whole mesh, and few splits in it then lie
/// near each other in memory.
const STEP_SHIFT: u32 = 23 - 3;

/// Steps in all; long edges wait in low ones.
const STEPS: u16 = (f32::INFINITY.to_bits() >> STEP_SHIFT) as u16;

/// A new vertex lies in the middle of its edge but for this share of the edge to either side, at full strength …
const ALONG: f32 = 0.14;
/// … and this share of the height of one of the two triangles towards its apex.
const ACROSS: f32 = 0.14;

/// Edges are flipped where their faces meet at less than this: the cosine of 45°.
const FLAT: f32 = 0.707;

/// Flips after one split at most.
const MOST_FLIPS: usize = 64;

/// What a split leaves behind, in the order of the splits: longest edges first.
#[derive(Default)]
pub(super) struct Splits {
    /// Length of the edge that was split, made non-increasing, object units.
    pub key: Vec<f32>,
    /// Mean distance of the new vertex to its neighbours.
    pub radius: Vec<f32>,
    /// Some of them, well spread; [`NONE`] for none. Vertices of the input come first, then split `k` is number
    /// `vertices + k`.
    pub neighbours: Vec<[u32; SPREAD]>,
    /// Where it lies.
    pub face: Vec<u32>,
    pub weights: Vec<[f32; 2]>,
}

/// A triangle. Splits jump about in the mesh: what is read together lies together.
#[derive(Clone, Copy)]
struct Face {
    /// A vertex that was made by a split is corner 0 of its triangles while it is new.
    corners: [u32; 3],
    /// The triangle across edge `k`, between corners `k` and `k + 1`.
    neighbours: [u32; 3],
}

#[derive(Clone, Copy)]
struct Vertex {
    position: Vec3,
    /// The face of the input on which it lies.
    host: u32,
}

/// A mesh that is being split.
pub(super) struct Splitter<'a> {
    ground: &'a Ground,
    faces: Vec<Face>,
    /// Squared length of the longest edge; 0 for those that are not to be split.
    longest: Vec<f32>,
    vertices: Vec<Vertex>,
    queues: Queues,
    /// The step at work, and how many of its queue were looked at.
    step: u16,
    next: usize,
    reached: f32,
    /// Triangles below this squared length wait for nothing.
    floor: f32,
    strength: f32,
    seed: u32,
    stack: Vec<u32>,
    pub(super) out: Splits,
}

#[inline(always)]
fn step_of(squared: f32) -> u16 {
    STEPS - (squared.to_bits() >> STEP_SHIFT) as u16
}

/// The longest edge that waits for a step.
#[inline(always)]
fn longest_of(step: u16) -> f32 {
    f32::from_bits(((u32::from(STEPS - step) + 1) << STEP_SHIFT) - 1).min(f32::MAX).sqrt()
}

impl<'a> Splitter<'a> {
    /// The mesh with these triangles, its vertices moved to `places` on `ground`. Edges shorter than `floor` will never be split.
    pub(super) fn new(
        ground: &'a Ground,
        triangles: &[[u32; 3]],
        places: &[Hit],
        floor: f32,
        strength: f32,
        seed: u32,
    ) -> Splitter<'a> {
        let vertices: Vec<Vertex> =
            places.par_iter().map(|hit| Vertex { position: hit.position, host: hit.face }).collect();
        // Where neighbours disagree in winding, as on a Möbius strip, the mesh is cut.
        let faces: Vec<Face> = (0..triangles.len())
            .into_par_iter()
            .map(|t| Face {
                corners: triangles[t],
                neighbours: [0, 1, 2].map(|k| match ground.faces[t].neighbours[k] {
                    other if other != NONE && same_direction(triangles, t as u32, k, other) => NONE,
                    other => other,
                }),
            })
            .collect();
        let longest: Vec<f32> = triangles.par_iter().map(|t| longest(&vertices, t).0).collect();
        let floor = floor * floor;
        let steps: Vec<u16> =
            longest.par_iter().map(|&l| if l < floor { STEPS } else { step_of(l) }).collect();
        Splitter {
            queues: Queues::new(STEPS, &steps),
            ground,
            faces,
            longest,
            vertices,
            step: 0,
            next: 0,
            reached: f32::INFINITY,
            floor,
            strength,
            seed,
            stack: Vec::new(),
            out: Splits::default(),
        }
    }

    /// Splits, longest edges first, until `done(splits, length)`, where no edge is longer than that, or nothing is left
    /// to split.
    pub(super) fn run(&mut self, done: impl Fn(usize, f32) -> bool) {
        while self.step < STEPS {
            if done(self.out.key.len(), self.reached.min(longest_of(self.step))) {
                return;
            }
            let Some(t) = self.queues.get(self.step, self.next) else {
                self.queues.clear(self.step);
                self.step += 1;
                self.next = 0;
                continue;
            };
            let length2 = self.longest[t as usize];
            if length2 == 0.0 || step_of(length2) > self.step {
                self.next += 1;
                continue;
            }
            self.next += 1;
            self.split(t);
        }
    }

    /// How many vertices there are: those of the input, then one a split.
    pub(super) fn vertices(&self) -> usize {
        self.vertices.len()
    }

    /// Where vertex `v` is.
    #[inline(always)]
    pub(super) fn position(&self, v: u32) -> Vec3 {
        self.vertices[v as usize].position
    }

    /// The triangles as they now are.
    pub(super) fn triangles(&self) -> Vec<[u32; 3]> {
        self.faces.par_iter().map(|face| face.corners).collect()
    }

    /// No later split has a longer edge than this; `None` if there will be none.
    pub(super) fn next_length(&self) -> Option<f32> {
        (self.step < STEPS).then_some(self.reached)
    }

    /// Splits the longest edge of `t`.
    fn split(&mut self, t: u32) {
        let (length2, k) = longest(&self.vertices, &self.faces[t as usize].corners);
        let [a, b, c] = [0, 1, 2].map(|j| self.faces[t as usize].corners[(k + j) % 3]);
        let other = self.faces[t as usize].neighbours[k];
        let (d, back) = if other == NONE {
            (NONE, 0)
        } else {
            let o = self.faces[other as usize].corners;
            let Some(back) = (0..3).find(|&j| o[j] == b && o[(j + 1) % 3] == a) else {
                self.longest[t as usize] = 0.0;
                return;
            };
            (o[(back + 2) % 3], back)
        };
        let number = self.vertices.len() as u32;
        let Some(hit) = self.place([a, b, c, d], number) else {
            // A fold whatever one does: this triangle is left until a neighbour changes it.
            self.longest[t as usize] = 0.0;
            return;
        };
        self.vertices.push(Vertex { position: hit.position, host: hit.face });
        let p = number;
        let edge = |s: &Self, t: u32, k: usize| s.faces[t as usize].neighbours[k % 3];
        // t = (a, b, c) becomes (p, b, c) and (p, c, a).
        let (bc, ca) = (edge(self, t, k + 1), edge(self, t, k + 2));
        let t2 = self.faces.len() as u32;
        let (o1, o2) = if other == NONE { (NONE, NONE) } else { (other, t2 + 1) };
        // The other one = (b, a, d) becomes (p, a, d) and (p, d, b).
        self.faces[t as usize].corners = [p, b, c];
        self.faces[t as usize].neighbours = [o2, bc, t2];
        self.faces.push(Face { corners: [p, c, a], neighbours: [t, ca, o1] });
        self.longest.push(0.0);
        self.relink(ca, c, a, t2);
        if other != NONE {
            let (ad, db) = (edge(self, other, back + 1), edge(self, other, back + 2));
            self.faces[o1 as usize].corners = [p, a, d];
            self.faces[o1 as usize].neighbours = [t2, ad, o2];
            self.faces.push(Face { corners: [p, d, b], neighbours: [o1, db, t] });
            self.longest.push(0.0);
            self.relink(db, d, b, o2);
        }
        let mut stack = std::mem::take(&mut self.stack);
        stack.clear();
        stack.extend([t, t2, o1, o2].into_iter().filter(|&t| t != NONE));
        for _ in 0..MOST_FLIPS {
            let Some(t) = stack.pop() else { break };
            if let Some(second) = self.flip(t) {
                stack.extend([t, second]);
            }
        }
        self.stack = stack;
        let ring = self.close_star(t, p);
        self.reached = self.reached.min(length2.sqrt());
        self.out.key.push(self.reached);
        self.out.radius.push(mean(&ring));
        let spread = spread(self.position(p), entries(&ring).map(vertex), |v| self.position(v));
        self.out.neighbours.push(spread);
        self.out.face.push(hit.face);
        self.out.weights.push(hit.weights);
    }

    /// Where a new vertex on the edge from `a` to `b` goes, with the apexes `c` and `d` ([`NONE`] at a border).
    fn place(&self, [a, b, c, d]: [u32; 4], number: u32) -> Option<Hit> {
        let at = |v: u32| self.vertices[v as usize].position;
        let (pa, pb, pc) = (at(a), at(b), at(c));
        let middle = (pa + pb) * 0.5;
        let normal = (pb - pa).cross(pc - pa);
        let normal = match d {
            NONE => normal,
            d => normal + (pa - pb).cross(at(d) - pb),
        }
        .normalize_or_zero();
        let draw = |k: u32| 2.0 * unit(hash2(number, self.seed ^ k)) - 1.0;
        let along = (pb - pa) * (ALONG * self.strength * draw(11));
        let across = if d == NONE {
            Vec3::ZERO
        } else {
            let s = draw(12);
            (if s > 0.0 { pc - middle } else { at(d) - middle }) * (ACROSS * self.strength * s.abs())
        };
        let length = pa.distance(pb);
        let rim = [(b, c), (c, a), (a, d), (d, b)];
        let folds = |p: Vec3| {
            rim.iter().filter(|(x, y)| *x != NONE && *y != NONE).any(|&(x, y)| {
                let n = (at(x) - p).cross(at(y) - p);
                n.dot(normal).is_nan() || n.dot(normal) <= 0.0
            })
        };
        [middle + along + across, middle]
            .into_iter()
            .filter_map(|p| self.project(p, normal, length, [a, b, c, d]))
            .find(|hit| !folds(hit.position))
    }

    /// The nearest place of the input along the normal, looked for from where the corners lie.
    fn project(&self, p: Vec3, normal: Vec3, length: f32, corners: [u32; 4]) -> Option<Hit> {
        let mut best: Option<(f32, Hit)> = None;
        for v in corners.into_iter().filter(|&v| v != NONE) {
            let Some(hit) = self.ground.walk(p, normal, self.vertices[v as usize].host) else { continue };
            let far = hit.position.distance(p);
            if best.is_none_or(|(d, _)| far < d) {
                best = Some((far, hit));
            }
            // So near that nothing nearer is worth a search.
            if far <= 0.25 * length {
                break;
            }
        }
        best.map(|(_, hit)| hit).filter(|hit| hit.position.distance(p) <= length)
    }

    /// Tells the triangle `t` that what lies across its edge between `x` and `y` is now `new`.
    #[inline]
    fn relink(&mut self, t: u32, x: u32, y: u32, new: u32) {
        if t == NONE {
            return;
        }
        let corners = self.faces[t as usize].corners;
        for k in 0..3 {
            if corners[k] == y && corners[(k + 1) % 3] == x {
                self.faces[t as usize].neighbours[k] = new;
            }
        }
    }

    /// Flips the edge opposite corner 0 of `t` if the corners opposite it on both sides see it under more than 180°
    /// together (Delaunay), the surface is flat enough there, and nothing folds. Returns the triangle on the other side,
    /// whose corner 0 then is that of `t`.
    fn flip(&mut self, t: u32) -> Option<u32> {
        let [p, x, y] = self.faces[t as usize].corners;
        let other = self.faces[t as usize].neighbours[1];
        if other == NONE {
            return None;
        }
        let o = self.faces[other as usize].corners;
        let back = (0..3).find(|&j| o[j] == y && o[(j + 1) % 3] == x)?;
        let q = o[(back + 2) % 3];
        let [px, yp] = [0, 2].map(|k| self.faces[t as usize].neighbours[k]);
        let [xq, qy] = [1, 2].map(|k| self.faces[other as usize].neighbours[(back + k) % 3]);
        // An edge that is there already must not be made again.
        let meets_q = |n: u32| n != NONE && self.faces[n as usize].corners.contains(&q);
        if q == p || meets_q(px) || meets_q(yp) {
            return None;
        }
        let at = |v: u32| self.vertices[v as usize].position;
        let (x1, y1) = (at(x) - at(p), at(y) - at(p));
        let (x2, y2) = (at(x) - at(q), at(y) - at(q));
        let (n1, n2) = (x1.cross(y1), y2.cross(x2));
        let (s1, s2) = (n1.length(), n2.length());
        let (c1, c2) = (x1.dot(y1), x2.dot(y2));
        if c1 * s2 + s1 * c2 >= -1e-5 * (s1 * s2 + (c1 * c2).abs()) || n1.dot(n2) < FLAT * s1 * s2 {
            return None;
        }
        let across = at(q) - at(p);
        let both = n1 + n2;
        if x1.cross(across).dot(both) <= 0.0 || across.cross(y1).dot(both) <= 0.0 {
            return None;
        }
        self.faces[t as usize].corners = [p, x, q];
        self.faces[t as usize].neighbours = [px, xq, other];
        self.faces[other as usize].corners = [p, q, y];
        self.faces[other as usize].neighbours = [t, qy, yp];
        self.relink(xq, x, q, t);
        self.relink(yp, y, p, other);
        Some(other)
    }

    /// Goes once round the new vertex `p` of triangle `t`: measures its triangles, lets them wait for their turn, and
    /// returns the neighbours of `p`.
    fn close_star(&mut self, t: u32, p: u32) -> List {
        let mut ring = [EMPTY; LIST];
        let at = self.vertices[p as usize].position;
        for clockwise in [false, true] {
            let mut now = t;
            loop {
                let [_, x, y] = self.faces[now as usize].corners;
                for v in [x, y] {
                    insert(&mut ring, entry(at.distance(self.vertices[v as usize].position), v));
                }
                if !(clockwise && now == t) {
                    let (length2, _) = longest(&self.vertices, &self.faces[now as usize].corners);
                    self.longest[now as usize] = length2;
                    if length2 >= self.floor {
                        self.queues.push(step_of(length2).max(self.step), now);
                    }
                }
                now = self.faces[now as usize].neighbours[if clockwise { 0 } else { 2 }];
                if now == NONE || now == t {
                    break;
                }
            }
            if now == t {
                break;
            }
        }
        ring
    }
}

/// The squared length of the longest edge of a triangle, and which edge it is.
#[inline(always)]
fn longest(vertices: &[Vertex], triangle: &[u32; 3]) -> (f32, usize) {
    let [a, b, c] = triangle.map(|v| vertices[v as usize].position);
    let lengths = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
    let mut best = (lengths[0], 0);
    for (k, &length) in lengths.iter().enumerate() {
        if length > best.0 {
            best = (length, k);
        }
    }
    best
}
