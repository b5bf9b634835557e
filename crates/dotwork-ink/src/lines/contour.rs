//! Contours: where a smooth surface turns away from the eye.
//!
//! On a mesh with unit normals `g = n · (eye − p)` is given at the vertices and linear between them; the contour is its
//! zero set, a segment in every triangle whose corners differ in sign (Hertzmann and Zorin 2000). It passes through
//! faces, not along edges, so it is as smooth as the normals are. Two triangles share the point on their edge: that
//! is what joins segments to chains, which are long, closed, or end at the surface's border.
//!
//! On the isosurface of a volume this is the curve {v = iso} ∩ {n·E = 0}. Marching tetrahedra trace it through the
//! volume anew for every view; the mesh has the first of the two functions solved once and for all, and the curve lies
//! on the very surface that dots sit on and that hides.
//!
//! Between two vertices a smooth surface bulges over the edge: from the edge to the cubic that the two normals ask for (the
//! boundary curve of a PN triangle: Vlachos et al. 2001). Moved so far, the points of a coarse mesh have the outline of the
//! form that it stands for, and the line lies before its own facets and not behind them. Whoever draws the line says
//! whether there is such a form: at bevels, normals are only means.
//!
//! At sharp edges the normals fall apart, and with them `g`. There a contour is where the values on both sides differ
//! in sign: it runs along the edge, and through a face where one of the two changes its sign. A cube's outline is its
//! edges, that of a cylinder two edges and two lines on its wall, and all of it is one chain.
//!
//! Only where the surface is convex along the line of sight can a contour be seen: `g` grows towards the eye there.
//! Elsewhere the surface itself hides it. That sign costs nothing and needs no depth buffer.

use dotwork_mesh::{Crease, Creases, Mesh};
use glam::Vec3;
use rayon::prelude::*;

/// Triangles a task looks at.
const CHUNK: usize = 8192;

/// Where the eye is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// At a point, object units: perspective.
    At(Vec3),
    /// Infinitely far in this unit direction: parallel projection.
    Towards(Vec3),
}

impl Eye {
    /// A vector from `p` towards the eye, not of unit length.
    #[inline(always)]
    pub(super) fn from(self, p: Vec3) -> Vec3 {
        match self {
            Eye::At(eye) => eye - p,
            Eye::Towards(direction) => direction,
        }
    }
}

/// Chains of points in space, in structure-of-arrays form. A closed chain repeats its first point at the end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chains {
    /// The points, object units, on edges of the mesh.
    pub point: Vec<Vec3>,
    /// How far the form that the normals tell of bulges over the mesh there.
    pub bulge: Vec<Vec3>,
    /// The surface's normals there, of unit length but for what is lost between vertices; zero on sharp edges, which
    /// have none.
    pub normal: Vec<Vec3>,
    /// The length of the mesh's edge on which each point lies, object units: by a share of it the mesh's own outline
    /// may be off.
    pub edge: Vec<f32>,
    /// For each point whether the line can be seen there if nothing else hides it: where this is above 0. Between two
    /// points it changes evenly.
    pub open: Vec<f32>,
    /// One past the last point of each chain.
    pub end: Vec<u32>,
    /// The triangle that each chain begins in.
    pub triangle: Vec<u32>,
}

impl Chains {
    /// Number of chains.
    pub fn len(&self) -> usize {
        self.end.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.end.is_empty()
    }

    /// The points of chain `k`.
    pub fn points(&self, k: usize) -> std::ops::Range<usize> {
        let start = if k == 0 { 0 } else { self.end[k - 1] as usize };
        start..self.end[k] as usize
    }

    fn clear(&mut self) {
        self.point.clear();
        self.bulge.clear();
        self.normal.clear();
        self.edge.clear();
        self.open.clear();
        self.end.clear();
        self.triangle.clear();
    }
}

/// Where the contour crosses an edge of the mesh.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    point: Vec3,
    bulge: Vec3,
    normal: Vec3,
    /// The edge's length.
    length: f32,
}

/// A segment of the contour inside a triangle. Few bytes, since segments are looked at in the order of the chains.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// Where it begins and ends: on an edge, as its pair of vertices, the smaller first; on a side of a sharp edge, in
    /// the order in which that side's face runs along it; at a vertex, as that twice.
    edge: [u64; 2],
    triangle: u32,
    /// How g grows towards the eye: above 0 the surface is convex along the line of sight.
    growth: f32,
}

/// Traces contours. Memory is kept from frame to frame.
#[derive(Default)]
pub struct Contours {
    /// For each vertex whether g is not negative there.
    towards: Vec<bool>,
    found: Vec<Found>,
    /// For each sharp edge whether some of it is contour in this view.
    turned: Vec<bool>,
    /// Those in faces, in the order of their triangles, and then those along sharp edges.
    segments: Vec<Segment>,
    /// Where each segment begins; made in the order of the triangles, whose corners are then at hand.
    begins: Vec<Crossing>,
    /// The segments from this one on are along sharp edges.
    in_faces: usize,
    /// Where each segment along a sharp edge ends.
    ends: Vec<Crossing>,
    /// Ends that have met no other yet, by their place.
    waiting: Waiting,
    /// For each end of each segment, the end that it meets, or `NONE`.
    meets: Vec<u32>,
    used: Vec<bool>,
    /// The ends of segments that are the chains' points, in order.
    order: Vec<u32>,
    chains: Chains,
}

/// What a task has found.
#[derive(Default)]
struct Found {
    /// Triangles in which g changes its sign.
    crossed: Vec<u32>,
    segments: Vec<Segment>,
    begins: Vec<Crossing>,
}

/// No end of a segment.
const NONE: u32 = u32::MAX;

/// Points of chains that a task places.
const POINTS: usize = 1024;

impl Contours {
    /// Finds the contours of `mesh`, whose sharp edges are `creases`, as seen from `eye`. They are in an order that
    /// depends on nothing but the mesh and the eye; the direction of a chain is that in which its first triangle lies.
    /// Chains of which the surface itself hides all are left out.
    ///
    /// Where `hidden` is true for the corners of a triangle, a smooth contour is not traced through it: chains end there.
    pub fn trace(
        &mut self,
        mesh: &Mesh,
        creases: &Creases,
        eye: Eye,
        hidden: impl Fn([Vec3; 3]) -> bool + Sync,
    ) -> &Chains {
        let surface = Smooth::new(mesh, creases);
        self.find(&surface, eye, &hidden);
        self.along_creases(mesh, creases, eye);
        self.join();
        self.chain();
        self.place(&surface, eye);
        &self.chains
    }

    /// Finds the segments in faces, in the order of their triangles.
    fn find(&mut self, surface: &Smooth, eye: Eye, hidden: &(impl Fn([Vec3; 3]) -> bool + Sync)) {
        let mesh = surface.mesh;
        // Where no normal is split, a vertex has one value of g, and most triangles need no more than three signs.
        let smooth = surface.whole;
        if smooth {
            (&mesh.positions, surface.normals)
                .into_par_iter()
                .with_min_len(CHUNK)
                .map(|(&p, &n)| n.dot(eye.from(p)) >= 0.0)
                .collect_into_vec(&mut self.towards);
        }
        let towards = &self.towards;
        let differ = |t: usize, triangle: [u32; 3]| {
            let [a, b, c] = match smooth {
                true => triangle.map(|v| towards[v as usize]),
                false => surface.values(t, triangle, eye).map(|g| g >= 0.0),
            };
            (a != b) | (b != c)
        };
        let look = |(k, triangles): (usize, &[[u32; 3]]), found: &mut Found| {
            // Signs fall as they like: writing each number and keeping some beats a branch.
            found.crossed.resize(CHUNK + 1, 0);
            let mut count = 0;
            for (i, &triangle) in triangles.iter().enumerate() {
                let t = k * CHUNK + i;
                found.crossed[count] = t as u32;
                count += usize::from(differ(t, triangle));
            }
            found.segments.clear();
            found.begins.clear();
            for &t in &found.crossed[..count] {
                if hidden(surface.corners(t as usize)) {
                    continue;
                }
                let face = surface.face(t as usize);
                let g = face.values(eye);
                found.segments.push(face.segment(eye, g));
                found.begins.push(face.cross(Face::crossed(g)[0], g));
            }
        };
        let chunks = mesh.triangles.len().div_ceil(CHUNK);
        self.found.resize_with(chunks.max(self.found.len()), Default::default);
        mesh.triangles
            .par_chunks(CHUNK)
            .enumerate()
            .zip(&mut self.found)
            .for_each(|(chunk, found)| look(chunk, found));
        self.segments.clear();
        self.begins.clear();
        for found in &self.found[..chunks] {
            self.segments.extend_from_slice(&found.segments);
            self.begins.extend_from_slice(&found.begins);
        }
        self.in_faces = self.segments.len();
    }

    /// Finds for each end of a segment the one that it meets. Where more than two meet (an edge with three faces),
    /// the first two in the order of triangles do.
    fn join(&mut self) {
        self.meets.clear();
        self.meets.resize(2 * self.segments.len(), NONE);
        self.waiting.clear(self.segments.len());
        for (s, segment) in self.segments.iter().enumerate() {
            for (k, &edge) in segment.edge.iter().enumerate() {
                let end = (2 * s + k) as u32;
                if let Some(other) = self.waiting.meet(edge, end) {
                    (self.meets[end as usize], self.meets[other as usize]) = (other, end);
                }
            }
        }
    }

    /// Follows the segments from end to end: first those that begin somewhere, then the closed ones.
    fn chain(&mut self) {
        self.chains.clear();
        self.order.clear();
        self.used.clear();
        self.used.resize(self.segments.len(), false);
        for closed in [false, true] {
            for s in 0..self.segments.len() as u32 {
                if self.used[s as usize] {
                    continue;
                }
                let free = [2 * s, 2 * s + 1].into_iter().find(|&e| closed || self.meets[e as usize] == NONE);
                if let Some(end) = free {
                    self.follow(end);
                }
            }
        }
    }

    /// The chain that begins at this end of a segment.
    fn follow(&mut self, first: u32) {
        let (chains, order) = (&mut self.chains, &mut self.order);
        let start = order.len();
        let growth = |e: u32| self.segments[e as usize / 2].growth;
        let in_faces = |e: u32| (e as usize / 2) < self.in_faces;
        let sign = |growth: f32| if growth > 0.0 { 1.0 } else { -1.0 };
        let mut end = first;
        order.push(first);
        chains.open.push(sign(growth(first)));
        loop {
            self.used[end as usize / 2] = true;
            let other = end ^ 1;
            let next = self.meets[other as usize];
            let ended = next == NONE || self.used[next as usize / 2];
            order.push(other);
            chains.open.push(match (growth(other), if ended { growth(other) } else { growth(next) }) {
                // Between two segments that differ, growth changes evenly from the middle of one to that of the other.
                (a, b) if in_faces(other) && !ended && in_faces(next) && (a > 0.0) != (b > 0.0) => {
                    between(a, b)
                }
                // On a sharp edge nothing changes evenly.
                (a, b) => sign(a.max(b)),
            });
            if ended {
                break;
            }
            end = next;
        }
        if !chains.open[start..].iter().any(|&open| open > 0.0) {
            order.truncate(start);
            chains.open.truncate(start);
            return;
        }
        chains.end.push(order.len() as u32);
        chains.triangle.push(self.segments[first as usize / 2].triangle);
    }

    /// Places the points of the chains.
    fn place(&mut self, surface: &Smooth, eye: Eye) {
        let Contours { order, segments, begins, in_faces, ends, meets, chains, .. } = self;
        let crossing = |end: u32| {
            let s = end as usize / 2;
            if end.is_multiple_of(2) {
                return begins[s];
            }
            // In faces that agree in winding, the next segment begins where one ends.
            let next = meets[end as usize];
            if next != NONE && next.is_multiple_of(2) {
                return begins[next as usize / 2];
            }
            if s >= *in_faces {
                return ends[s - *in_faces];
            }
            let face = surface.face(segments[s].triangle as usize);
            let g = face.values(eye);
            face.cross(Face::crossed(g)[1], g)
        };
        chains.point.resize(order.len(), Vec3::ZERO);
        chains.bulge.resize(order.len(), Vec3::ZERO);
        chains.normal.resize(order.len(), Vec3::ZERO);
        chains.edge.resize(order.len(), 0.0);
        (
            order.par_chunks(POINTS),
            chains.point.par_chunks_mut(POINTS),
            chains.bulge.par_chunks_mut(POINTS),
            chains.normal.par_chunks_mut(POINTS),
            chains.edge.par_chunks_mut(POINTS),
        )
            .into_par_iter()
            .for_each(|(order, point, bulge, normal, edge)| {
                for (i, &end) in order.iter().enumerate() {
                    let at = crossing(end);
                    (point[i], bulge[i], normal[i], edge[i]) = (at.point, at.bulge, at.normal, at.length);
                }
            });
    }
}

/// Ends of segments that have met no other yet: a table hashed by place, in which an end is found at its place or after it.
#[derive(Default)]
struct Waiting {
    /// Place and end; `NONE` where there is none. A place stays when its end has been met, so that searches pass it.
    table: Vec<(u64, u32)>,
    /// Its length, a power of two, less one.
    mask: usize,
}

impl Waiting {
    /// Empties it, for the ends of so many segments.
    fn clear(&mut self, segments: usize) {
        // Two ends a place, but at borders: at most half full, and at most full at all.
        let length = (2 * segments + 1).next_power_of_two();
        self.mask = length - 1;
        self.table.clear();
        self.table.resize(length, (EMPTY, NONE));
    }

    /// The end that waits at a place; if there is none, `end` does from now on.
    #[inline]
    fn meet(&mut self, place: u64, end: u32) -> Option<u32> {
        // Fibonacci hashing: the high bits depend on all of both vertices.
        let mut slot = (place.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize & self.mask;
        loop {
            let (at, waits) = &mut self.table[slot];
            if *at == place {
                let other = std::mem::replace(waits, NONE);
                if other == NONE {
                    *waits = end;
                    return None;
                }
                return Some(other);
            }
            if *at == EMPTY {
                (*at, *waits) = (place, end);
                return None;
            }
            slot = (slot + 1) & self.mask;
        }
    }
}

/// No place: no mesh has vertices of this number.
const EMPTY: u64 = u64::MAX;

/// A mesh with the normals that contours go by.
struct Smooth<'a> {
    mesh: &'a Mesh,
    creases: &'a Creases,
    normals: &'a [Vec3],
    /// For each triangle corner its normal in `normals`.
    corner_normals: &'a [[u32; 3]],
    /// No normal is split: each is that of the vertex with its number, and `corner_normals` need not be read.
    whole: bool,
}

impl<'a> Smooth<'a> {
    fn new(mesh: &'a Mesh, creases: &'a Creases) -> Smooth<'a> {
        let (normals, corner_normals) = match creases.edges.is_empty() {
            true => (&mesh.normals, &mesh.corner_normals),
            false => (&creases.normals, &creases.corner_normals),
        };
        let whole = normals.len() == mesh.positions.len();
        Smooth { mesh, creases, normals, corner_normals, whole }
    }

    /// The values of g at the corners of triangle `t`.
    #[inline(always)]
    fn values(&self, t: usize, triangle: [u32; 3], eye: Eye) -> [f32; 3] {
        let normals = self.corner_normals[t];
        [0, 1, 2].map(|c| {
            let p = self.mesh.positions[triangle[c] as usize];
            self.normals[normals[c] as usize].dot(eye.from(p))
        })
    }

    /// The corners of triangle `t`.
    #[inline(always)]
    fn corners(&self, t: usize) -> [Vec3; 3] {
        self.mesh.triangles[t].map(|v| self.mesh.positions[v as usize])
    }

    /// Triangle `t`.
    #[inline(always)]
    fn face(&self, t: usize) -> Face {
        let vertices = self.mesh.triangles[t];
        Face {
            t: t as u32,
            vertices,
            corners: self.corners(t),
            normals: match self.whole {
                true => vertices.map(|n| self.normals[n as usize]),
                false => self.corner_normals[t].map(|n| self.normals[n as usize]),
            },
            sharp: self.creases.sharp.get(t).copied().unwrap_or(0),
        }
    }
}

/// How open the point is between a segment that is open and one that is not, for how g grows in them: so that what is
/// between a neighbouring point and this one is open as far as the growth is above 0, if it has the values of the
/// segments in their middles.
fn between(a: f32, b: f32) -> f32 {
    let (open, shut) = (a.max(b), a.min(b));
    // How far into the segment that is shut the line is open, in its lengths; below 0, how far it is not in the other.
    let over = open / (open - shut) - 0.5;
    if over >= 0.0 { over / (1.0 - over) } else { over / (1.0 + over) }
}

/// Where the values at two places along a line are zero in between, as a share of the way.
#[inline(always)]
fn zero(from: f32, to: f32) -> f32 {
    from / (from - to)
}

/// A triangle in which the contour lies.
struct Face {
    t: u32,
    vertices: [u32; 3],
    corners: [Vec3; 3],
    normals: [Vec3; 3],
    /// Bit `k`: the edge from corner `k` to the next is sharp.
    sharp: u8,
}

impl Face {
    /// The values of g at its corners.
    #[inline(always)]
    fn values(&self, eye: Eye) -> [f32; 3] {
        [0, 1, 2].map(|c| self.normals[c].dot(eye.from(self.corners[c])))
    }

    /// The corners from which the two edges begin that the contour crosses, for the values at the corners, which differ
    /// in sign. Along the first edge, as the face runs along it, the values fall below 0.
    #[inline(always)]
    fn crossed(g: [f32; 3]) -> [usize; 2] {
        let [inside_a, inside_b, inside_c] = g.map(|v| v >= 0.0);
        // The corner whose sign is alone.
        let (alone, inside) = if inside_b == inside_c {
            (0, inside_a)
        } else if inside_a == inside_c {
            (1, inside_b)
        } else {
            (2, inside_c)
        };
        let before = (alone + 2) % 3;
        if inside { [alone, before] } else { [before, alone] }
    }

    /// Its segment, for the values at the corners, which differ in sign.
    #[inline]
    fn segment(&self, eye: Eye, g: [f32; 3]) -> Segment {
        let p = self.corners;
        // The gradient of g in the triangle, times the triangle's squared area, along the line of sight.
        let (ab, ac) = (p[1] - p[0], p[2] - p[0]);
        let n = ab.cross(ac);
        let sight = eye.from((p[0] + p[1] + p[2]) * (1.0 / 3.0));
        let growth = (g[1] - g[0]) * n.cross(-ac).dot(sight) + (g[2] - g[0]) * n.cross(ab).dot(sight);
        let edge = Face::crossed(g).map(|k| self.place_on(k));
        // Neighbours of other sizes are compared with it.
        Segment { triangle: self.t, edge, growth: growth / n.length_squared().max(f32::MIN_POSITIVE) }
    }

    /// The name of the place where the contour crosses the edge from corner `k` to the next.
    #[inline(always)]
    fn place_on(&self, k: usize) -> u64 {
        let (from, to) = (self.vertices[k], self.vertices[(k + 1) % 3]);
        // Each side of a sharp edge has its own place.
        if self.sharp >> k & 1 == 1 { key(from, to) } else { key(from.min(to), from.max(to)) }
    }

    /// Where the contour crosses the edge from corner `k` to the next.
    #[inline(always)]
    fn cross(&self, k: usize, g: [f32; 3]) -> Crossing {
        let next = (k + 1) % 3;
        // The crossing must be the same point from both of the edge's triangles: taken from the smaller vertex on.
        let (i, j) = if self.vertices[k] < self.vertices[next] { (k, next) } else { (next, k) };
        let s = zero(g[i], g[j]);
        let along = self.corners[j] - self.corners[i];
        let [from, to] = [self.normals[i], self.normals[j]];
        let point = self.corners[i] + along * s;
        let normal = from + (to - from) * s;
        let length = along.length();
        if self.sharp >> k & 1 == 1 {
            // On the edge itself.
            return Crossing { point, bulge: Vec3::ZERO, normal, length };
        }
        let bulge = ((1.0 - s) * s) * (to * (s * along.dot(to)) - from * ((1.0 - s) * along.dot(from)));
        let most = MOST_BULGE * length;
        let bulge = if bulge.length_squared() > most * most { bulge.normalize() * most } else { bulge };
        Crossing { point, bulge, normal, length }
    }
}

/// The name of a place on an edge.
#[inline(always)]
fn key(from: u32, to: u32) -> u64 {
    u64::from(from) << 32 | u64::from(to)
}

/// Largest distance of a crossing from its edge, in lengths of the edge: normals 90° apart ask for 0.18.
const MOST_BULGE: f32 = 0.18;

impl Contours {
    /// Finds the segments that lie on sharp edges.
    fn along_creases(&mut self, mesh: &Mesh, creases: &Creases, eye: Eye) {
        self.turned.clear();
        self.ends.clear();
        for edge in &creases.edges {
            let before = self.segments.len();
            let p = edge.ends.map(|v| mesh.positions[v as usize]);
            let [left, right] = edge
                .normals
                .map(|side| [0, 1].map(|k| creases.normals[side[k] as usize].dot(eye.from(p[k]))));
            let changes = |g: [f32; 2]| ((g[0] >= 0.0) != (g[1] >= 0.0)).then(|| zero_from_smaller(edge, g));
            let Crease { ends: [a, b], .. } = *edge;
            // The pieces into which changes of sign cut the edge, with the names of their ends.
            let mut cuts = [(0.0, key(a, a)), (1.0, key(b, b)), (2.0, 0), (2.0, 0)];
            if let Some(s) = changes(left) {
                cuts[2] = (s, key(a, b));
            }
            if let Some(s) = changes(right) {
                cuts[3] = (s, key(b, a));
            }
            cuts.sort_by(|x, y| x.0.total_cmp(&y.0));
            let (mut left_in, mut right_in) = (left[0] >= 0.0, right[0] >= 0.0);
            for w in cuts.windows(2) {
                let ((from, from_key), (to, to_key)) = (w[0], w[1]);
                left_in ^= from_key == key(a, b) && from > 0.0;
                right_in ^= from_key == key(b, a) && from > 0.0;
                if to > 1.0 || left_in == right_in {
                    continue;
                }
                let at = |s: f32| Crossing {
                    point: p[0] + (p[1] - p[0]) * s,
                    bulge: Vec3::ZERO,
                    normal: Vec3::ZERO,
                    length: 0.0,
                };
                let growth = if edge.angle > 0.0 { 1.0 } else { -1.0 };
                self.segments.push(Segment { triangle: edge.faces[0], edge: [from_key, to_key], growth });
                self.begins.push(at(from));
                self.ends.push(at(to));
            }
            self.turned.push(self.segments.len() > before);
        }
    }

    /// For each sharp edge of the mesh looked at last, whether some of it is part of the contour.
    pub fn turned(&self) -> &[bool] {
        &self.turned
    }
}

/// Where values along an edge are zero, as a share of the way from its first end: computed from the smaller vertex on,
/// as in the faces.
fn zero_from_smaller(edge: &Crease, g: [f32; 2]) -> f32 {
    match edge.ends[0] < edge.ends[1] {
        true => zero(g[0], g[1]),
        false => 1.0 - zero(g[1], g[0]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::Warnings;
    use dotwork_mesh::{MeshOptions, RawMesh, shapes};

    fn mesh(name: &str) -> Mesh {
        let raw: RawMesh = shapes::demo(name).unwrap();
        Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap()
    }

    #[test]
    fn a_sphere_has_one_circle() {
        let sphere = mesh("sphere");
        let center = sphere.positions.iter().sum::<Vec3>() / sphere.positions.len() as f32;
        let radius = (sphere.positions[0] - center).length();
        let mut contours = Contours::default();
        for direction in
            [Vec3::Z, Vec3::new(0.3, -0.5, 0.8).normalize(), Vec3::new(-0.9, 0.1, 0.2).normalize()]
        {
            let chains = contours.trace(&sphere, &Creases::default(), Eye::Towards(direction), |_| false);
            assert_eq!(chains.len(), 1);
            assert_eq!(chains.point[0], chains.point[chains.points(0).end - 1], "it is closed");
            assert!(chains.open.iter().all(|&o| o > 0.0), "a sphere is convex");
            for &p in &chains.point {
                assert!((p - center).dot(direction).abs() < 0.005 * radius, "in the plane across the sight");
                assert!(((p - center).length() / radius - 1.0).abs() < 0.005);
            }
        }
        // Under perspective the circle lies nearer: at radius² / distance.
        let distance = 3.0 * radius;
        let chains =
            contours.trace(&sphere, &Creases::default(), Eye::At(center + Vec3::Z * distance), |_| false);
        assert_eq!(chains.len(), 1);
        for &p in &chains.point {
            assert!(((p - center).z - radius * radius / distance).abs() < 0.01 * radius);
        }
    }

    #[test]
    fn a_torus_seen_from_above_shows_both_circles_and_aslant_hides_the_concave_part() {
        let torus = mesh("torus");
        let mut contours = Contours::default();
        let length = |chains: &Chains, open: bool| -> f32 {
            (0..chains.len())
                .flat_map(|k| chains.points(k).skip(1))
                .filter(|&i| (chains.open[i] > 0.0 && chains.open[i - 1] > 0.0) == open)
                .map(|i| (chains.point[i] - chains.point[i - 1]).length())
                .sum()
        };
        let extent = torus.positions.iter().fold(Vec3::ZERO, |m, p| m.max(p.abs()));
        let axis =
            [Vec3::X, Vec3::Y, Vec3::Z][(0..3).min_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap()];
        let across = if axis == Vec3::X { Vec3::Y } else { Vec3::X };
        let chains = contours.trace(
            &torus,
            &Creases::default(),
            Eye::Towards((axis + across * 1e-3).normalize()),
            |_| false,
        );
        assert_eq!(chains.len(), 2, "the outer and the inner circle");
        let (outer, minor) = (extent.max_element(), extent.dot(axis));
        let expected = std::f32::consts::TAU * (outer + (outer - 2.0 * minor));
        assert!((length(chains, true) / expected - 1.0).abs() < 0.01);
        assert!(length(chains, false) < 0.01 * expected);
        // From the side, the inner rim of the hole is hidden by the torus itself.
        let chains = contours.trace(
            &torus,
            &Creases::default(),
            Eye::Towards((axis * 0.4 + across).normalize()),
            |_| false,
        );
        assert!(length(chains, false) > 0.05 * expected, "{}", length(chains, false));
    }

    #[test]
    fn the_same_chains_on_any_number_of_threads() {
        let teapot = mesh("teapot");
        let eye = Eye::At(Vec3::new(3.0, 5.0, 9.0));
        let many = Contours::default().trace(&teapot, &Creases::default(), eye, |_| false).clone();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(
            pool.install(|| Contours::default().trace(&teapot, &Creases::default(), eye, |_| false).clone()),
            many
        );
        assert!(!many.is_empty());
        assert_eq!(many.point.len(), many.open.len());
    }
}
