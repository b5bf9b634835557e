//! One triangle less a convex region.
//!
//! The removed part is the triangle clipped by all planes (Ivan E. Sutherland and Gary W. Hodgman, *Reentrant Polygon
//! Clipping*, 1974), a convex polygon Q in barycentric coordinates. What is kept is the ring between Q and the
//! triangle: the hull of Q is grown by the triangle's corners, one at a time, each joined to the sides of the hull that
//! it sees.
//!
//! An edge of the mesh meets a convex region in one interval. Its ends depend on the edge alone: they are compared
//! as parameters along the edge, which runs the same way for all its triangles, never as interpolated points. So
//! neighbours agree on them to the last bit, and no vertex lies on an edge that is whole for the neighbour.

use glam::DVec3;

use super::Cutter;

/// Sides of Q that are not on an edge of the triangle.
const INNER: usize = 3;

/// Where a vertex of a piece comes from.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    /// A vertex of the mesh, by its number.
    Old(u32),
    /// On edge `.0` of the triangle, at `.1` of its way.
    Edge(usize, f64),
    Inner,
}

/// A vertex of Q or of its hull.
#[derive(Clone, Copy)]
struct Point {
    /// Barycentric coordinates; those of points on an edge have an exact 0.
    at: [f64; 3],
    place: Place,
    /// The edge of the triangle on which the side to the next point lies, or [`INNER`].
    side: usize,
    position: [f32; 3],
    /// In [`Cut::vertices`], once it is there.
    id: Option<u64>,
}

/// Which edge a new vertex lies on, and where; neighbours make equal ones.
pub(super) type EdgeKey = (u32, u32, u64);

/// A vertex that clipping makes.
pub(super) struct NewVertex {
    /// `None` for vertices in the interior of a triangle.
    pub(super) key: Option<EdgeKey>,
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) color: [u8; 4],
}

/// New vertices are numbered from here in [`Cut::corners`], old ones have their own numbers.
pub(super) const NEW: u64 = 1 << 32;

/// What cut triangles become, and room to work in.
#[derive(Default)]
pub(super) struct Cut {
    /// Corners of the pieces.
    pub(super) corners: Vec<[u64; 3]>,
    /// The new vertices, those of shared edges once for each triangle.
    pub(super) vertices: Vec<NewVertex>,
    hull: Vec<Point>,
    next: Vec<Point>,
}

/// A triangle about to be cut.
struct Triangle<'a> {
    cutter: &'a Cutter<'a>,
    ids: [u32; 3],
    /// The corners between which edge 0, 1, 2 runs, in the direction all its triangles agree on.
    ends: [[usize; 2]; 3],
}

impl Cut {
    /// Appends the pieces of the triangle `ids` that remain without the common part of the planes whose bits are set
    /// in `active`; false if that is all of it.
    pub(super) fn add(&mut self, cutter: &Cutter<'_>, ids: [u32; 3], active: u32) -> bool {
        let triangle = Triangle::new(cutter, ids);
        self.hull.clear();
        self.hull.extend((0..3).map(|c| triangle.corner(c)));
        for plane in (0..cutter.planes.len()).filter(|k| active >> k & 1 == 1) {
            self.intersect(&triangle, ids.map(|v| cutter.distance(plane, v)));
        }
        for point in &mut self.hull {
            triangle.settle(point);
        }
        self.hull.dedup_by(|a, b| is_same_vertex(a, b));
        while self.hull.len() > 1 && is_same_vertex(&self.hull[0], &self.hull[self.hull.len() - 1]) {
            self.hull.pop();
        }
        // Planes that meet the triangle, but not all in one place, or only touch it.
        if self.hull.len() < 3 {
            self.touched(&triangle, active);
            return false;
        }
        for c in 0..3 {
            self.grow(&triangle, c);
        }
        true
    }

    /// Adds a triangle that loses nothing: whole, or split where the region touches its edges, since neighbours that do
    /// lose something have vertices there.
    fn touched(&mut self, triangle: &Triangle<'_>, active: u32) {
        self.hull.clear();
        for e in 0..3 {
            let corner = triangle.corner(e);
            self.hull.push(corner);
            if let Some(t) = triangle.touch(e, active) {
                let mut point = triangle.on_edge(e, t);
                triangle.settle(&mut point);
                self.hull.push(point);
            }
        }
        let Some(first) = self.hull.iter().position(|p| matches!(p.place, Place::Edge(..))) else {
            self.corners.push(triangle.ids.map(u64::from));
            return;
        };
        // No two of the others lie on one edge with this one, but for its neighbours.
        self.hull.rotate_left(first);
        for k in 2..self.hull.len() {
            self.piece(triangle, [0, k - 1, k]);
        }
    }

    /// One step of Sutherland and Hodgman; `distances` are those of the corners.
    fn intersect(&mut self, triangle: &Triangle<'_>, distances: [f64; 3]) {
        self.next.clear();
        for (i, u) in self.hull.iter().enumerate() {
            let v = &self.hull[(i + 1) % self.hull.len()];
            let inside = [u, v].map(|p| triangle.is_inside(p, distances));
            if inside[0] {
                self.next.push(*u);
            }
            if inside[0] != inside[1] {
                let side = if inside[0] { INNER } else { u.side };
                self.next.push(Point { side, ..triangle.crossing(u, v, inside[0], distances) });
            }
        }
        std::mem::swap(&mut self.hull, &mut self.next);
    }

    /// Joins corner `c` of the triangle to the hull.
    fn grow(&mut self, triangle: &Triangle<'_>, c: usize) {
        let corner = triangle.corner(c);
        let n = self.hull.len();
        if self.hull.iter().any(|p| is_same_vertex(p, &corner)) {
            return;
        }
        // Twice the area that the corner and side i span; negative where the corner sees the side from without.
        let area = |hull: &[Point], i: usize| {
            let [a, b] = [hull[i].at, hull[(i + 1) % n].at];
            let [next, last] = [(c + 1) % 3, (c + 2) % 3];
            a[next] * b[last] - a[last] * b[next]
        };
        let seen = |hull: &[Point], i: usize| area(hull, i) < 0.0;
        let mut first =
            (0..n).min_by(|&i, &j| area(&self.hull, i).total_cmp(&area(&self.hull, j))).unwrap_or_default();
        if !seen(&self.hull, first) {
            return;
        }
        let mut run = 1;
        while run < n - 1 && seen(&self.hull, (first + run) % n) {
            run += 1;
        }
        while run < n - 1 && seen(&self.hull, (first + n - 1) % n) {
            first = (first + n - 1) % n;
            run += 1;
        }
        self.hull.rotate_left(first);
        self.hull.insert(run, corner);
        // The corner now stands before the end of the last side seen.
        for i in 0..run {
            let end = if i + 1 < run { i + 1 } else { run + 1 };
            self.piece(triangle, [end, i, run]);
        }
        self.hull.drain(1..run);
    }

    /// Adds a piece with these points of the hull as corners, unless two of them coincide in single precision:
    /// welding would make it a line.
    fn piece(&mut self, triangle: &Triangle<'_>, corners: [usize; 3]) {
        let [a, b, c] = corners.map(|i| self.hull[i].position);
        if a == b || b == c || c == a {
            return;
        }
        let ids = corners.map(|i| {
            let point = &mut self.hull[i];
            let id = match (point.id, point.place) {
                (Some(id), _) => id,
                (None, Place::Old(v)) => v.into(),
                (None, _) => {
                    self.vertices.push(triangle.vertex(point));
                    NEW + self.vertices.len() as u64 - 1
                }
            };
            point.id = Some(id);
            id
        });
        self.corners.push(ids);
    }
}

/// True for the same vertex of the mesh, or the same new one.
fn is_same_vertex(a: &Point, b: &Point) -> bool {
    a.place == b.place && (a.place != Place::Inner || a.at == b.at)
}

impl<'a> Triangle<'a> {
    fn new(cutter: &'a Cutter<'a>, ids: [u32; 3]) -> Triangle<'a> {
        // By place first: soups have several vertices in one place, and shall be cut alike too.
        let rank = |c: usize| (cutter.raw.positions[ids[c] as usize].map(|x| (x + 0.0).to_bits()), ids[c]);
        let ends = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| if rank(a) <= rank(b) { [a, b] } else { [b, a] });
        Triangle { cutter, ids, ends }
    }

    fn corner(&self, c: usize) -> Point {
        let mut at = [0.0; 3];
        at[c] = 1.0;
        let position = self.cutter.raw.positions[self.ids[c] as usize];
        Point { at, place: Place::Old(self.ids[c]), side: c, position, id: None }
    }

    /// Where along edge `e` a plane with these distances crosses.
    fn share(&self, e: usize, distances: [f64; 3]) -> f64 {
        let [from, to] = self.ends[e].map(|c| distances[c]);
        from / (from - to)
    }

    fn is_inside(&self, point: &Point, distances: [f64; 3]) -> bool {
        let Place::Edge(e, t) = point.place else {
            return dot(point.at, distances) > 0.0;
        };
        let [from, to] = self.ends[e].map(|c| distances[c]);
        match (from > 0.0, to > 0.0) {
            (false, true) => t > self.share(e, distances),
            (true, false) => t < self.share(e, distances),
            (both, _) => both,
        }
    }

    /// Where the side from `u` to `v` meets the plane; one of them is inside.
    fn crossing(&self, u: &Point, v: &Point, u_is_inside: bool, distances: [f64; 3]) -> Point {
        if u.side != INNER {
            return self.on_edge(u.side, self.share(u.side, distances).clamp(0.0, 1.0));
        }
        let [du, dv] = [u, v].map(|p| match p.place {
            Place::Edge(e, t) if t == self.share(e, distances) => 0.0,
            _ => dot(p.at, distances),
        });
        // Points on edges are judged by their parameter: rounding may have given the distance the other sign.
        let [inner, outer] = if u_is_inside { [du, dv] } else { [dv, du] };
        let [inner, outer] = [inner.max(0.0), outer.min(0.0)];
        // An end that lies on the plane is the crossing itself: an old vertex there must stay one.
        if outer == 0.0 || inner == 0.0 {
            return if u_is_inside == (outer == 0.0) { *v } else { *u };
        }
        let from_inner = inner / (inner - outer);
        let t = if u_is_inside { from_inner } else { 1.0 - from_inner };
        let at = std::array::from_fn(|c| u.at[c] * (1.0 - t) + v.at[c] * t);
        Point { at, place: Place::Inner, ..*u }
    }

    /// The point at `t` of edge `e`.
    fn on_edge(&self, e: usize, t: f64) -> Point {
        let mut at = [0.0; 3];
        let [from, to] = self.ends[e];
        at[from] = 1.0 - t;
        at[to] = t;
        Point { at, place: Place::Edge(e, t), ..self.corner(e) }
    }

    /// Where the region of the planes touches edge `e` between its ends without taking a piece of it.
    fn touch(&self, e: usize, active: u32) -> Option<f64> {
        let (mut first, mut last) = (0.0f64, 1.0f64);
        for plane in (0..self.cutter.planes.len()).filter(|k| active >> k & 1 == 1) {
            let distances = self.ids.map(|v| self.cutter.distance(plane, v));
            let [from, to] = self.ends[e].map(|c| distances[c]);
            match (from > 0.0, to > 0.0) {
                (false, true) => first = first.max(self.share(e, distances)),
                (true, false) => last = last.min(self.share(e, distances)),
                (false, false) => return None,
                (true, true) => {}
            }
        }
        (first == last && first > 0.0 && first < 1.0).then_some(first)
    }

    /// Gives a vertex of Q its position; one at the end of an edge is the vertex of the mesh there.
    fn settle(&self, point: &mut Point) {
        if let Place::Edge(e, t) = point.place {
            let end = if t <= 0.0 { 0 } else { 1 };
            if t <= 0.0 || t >= 1.0 {
                *point = Point { side: point.side, ..self.corner(self.ends[e][end]) };
            }
        }
        if !matches!(point.place, Place::Old(_)) {
            let positions = &self.cutter.raw.positions;
            let mixed = self.mix(point, |v| DVec3::from_array(positions[v].map(f64::from)));
            point.position = mixed.as_vec3().to_array();
        }
    }

    /// Values of the corners mixed for a point; those of an edge do not depend on the triangle.
    fn mix(&self, point: &Point, of: impl Fn(usize) -> DVec3) -> DVec3 {
        let of = |c: usize| of(self.ids[c] as usize);
        match point.place {
            Place::Edge(e, t) => {
                let [from, to] = self.ends[e].map(of);
                from + (to - from) * t
            }
            _ => of(0) * point.at[0] + of(1) * point.at[1] + of(2) * point.at[2],
        }
    }

    fn vertex(&self, point: &Point) -> NewVertex {
        let raw = self.cutter.raw;
        let key = match point.place {
            Place::Edge(e, t) => {
                let [from, to] = self.ends[e].map(|c| self.ids[c]);
                Some((from, to, t.to_bits()))
            }
            _ => None,
        };
        let mut vertex = NewVertex { key, position: point.position, normal: [0.0; 3], color: [0; 4] };
        if raw.normals.len() == raw.positions.len() {
            let given = |v: usize| DVec3::from_array(raw.normals[v].map(f64::from));
            let mixed = self.mix(point, given);
            // Opposite normals leave nothing.
            let first = || given(self.ids[0] as usize);
            vertex.normal = mixed.try_normalize().unwrap_or_else(first).as_vec3().to_array();
        }
        if raw.colors.len() == raw.positions.len() {
            let color = |v: usize| DVec3::from_array([0, 1, 2].map(|i| raw.colors[v][i].into()));
            let opacity = |v: usize| DVec3::splat(raw.colors[v][3].into());
            let [c, o] = [self.mix(point, color), self.mix(point, opacity)];
            vertex.color = [c.x, c.y, c.z, o.x].map(|v| v.round() as u8);
        }
        vertex
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
