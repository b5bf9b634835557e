//! The sums of the regression, row by row.
//!
//! Weights that depend on the absolute offsets alone make the four sums of a voxel share almost everything. The nine
//! rows around a row are first combined across z, then across y, position by position, into six rows; three neighbours
//! along x of those then give value and gradient. That is some 40 operations a voxel where the plain sums have over
//! 150, all of them on whole vectors, in buffers that stay in the first-level cache.

use std::array;

/// Numbers that are handled together; whole vector registers of the baseline processor.
pub(super) const LANES: usize = 8;

/// What the sums are made of: `f32`, or 16-bit integers that wrap (a result that fits is right whatever came before).
pub(super) trait Lane: Copy + Default + Send + Sync {
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
}

impl Lane for f32 {
    #[inline]
    fn plus(self, other: f32) -> f32 {
        self + other
    }
    #[inline]
    fn minus(self, other: f32) -> f32 {
        self - other
    }
    #[inline]
    fn times(self, other: f32) -> f32 {
        self * other
    }
}

impl Lane for u16 {
    #[inline]
    fn plus(self, other: u16) -> u16 {
        self.wrapping_add(other)
    }
    #[inline]
    fn minus(self, other: u16) -> u16 {
        self.wrapping_sub(other)
    }
    #[inline]
    fn times(self, other: u16) -> u16 {
        self.wrapping_mul(other)
    }
}

/// Buffers for the rows of one layer at a time; one for each thread.
pub(super) struct Scratch<L> {
    /// Samples along x.
    nx: usize,
    /// For three neighbouring rows, each with its first and last sample repeated: the middle layer, the sum of the
    /// layers beside it, and their difference.
    ring: [[Vec<L>; 3]; 3],
    /// Rows combined across y and z: the centre and the sides of three-point sums along x, for value and x, y, z.
    partial: [Vec<L>; 6],
    /// Sums for the value and the three components of the gradient.
    sums: [Vec<L>; 4],
}

impl<L: Lane> Scratch<L> {
    pub(super) fn new(nx: usize) -> Scratch<L> {
        // Whole vectors, so that no loop has a rest, and room for the neighbours of the last.
        let row = || vec![L::default(); nx.next_multiple_of(LANES) + LANES];
        Scratch {
            nx,
            ring: array::from_fn(|_| array::from_fn(|_| row())),
            partial: array::from_fn(|_| row()),
            sums: array::from_fn(|_| vec![L::default(); nx.next_multiple_of(LANES)]),
        }
    }

    /// Calls `sink` with the sums of each row of layer `z`: of the weighted values, and of the weighted values times
    /// the offset along x, y and z. Rows have whole vectors; what lies beyond `nx` means nothing.
    ///
    /// `weights` go by absolute offset, x the lowest bit. Beyond the border the outermost sample is repeated, and the
    /// sum along an axis that ends there is doubled: it is a one-sided difference.
    pub(super) fn layer<T: Copy>(
        &mut self,
        [_, ny, nz]: [usize; 3],
        z: usize,
        weights: &[L; 8],
        samples: &[T],
        lane: impl Fn(T) -> L,
        mut sink: impl FnMut(usize, [&[L]; 4]),
    ) {
        let nx = self.nx;
        let fetch = |rows: &mut [Vec<L>; 3], y: usize| {
            let [below, middle, above] =
                [z.saturating_sub(1), z, (z + 1).min(nz - 1)].map(|z| &samples[nx * (y + ny * z)..][..nx]);
            let [c, s, d] = rows.each_mut().map(|row| &mut row[1..=nx]);
            fetch(below, middle, above, &lane, c, s, d);
            for row in rows {
                row[0] = row[1];
                row[nx + 1] = row[nx];
            }
        };
        fetch(&mut self.ring[0], 0);
        fetch(&mut self.ring[1], 0);
        for y in 0..ny {
            fetch(&mut self.ring[(y + 2) % 3], (y + 1).min(ny - 1));
            let [low, middle, high] = [0, 1, 2].map(|i| &self.ring[(y + i) % 3]);
            let ([c0, s0, d0], [c1, s1, d1], [c2, s2, d2]) = (low, middle, high);
            let [p0, p1, qy0, qy1, qz0, qz1] = &mut self.partial;
            across(c0, c1, c2, s0, s1, s2, weights, p0, p1, qy0, qy1);
            across_z(d0, d1, d2, weights, qz0, qz1);
            let [v, gx, gy, gz] = &mut self.sums;
            three(p0, p1, v);
            difference(p1, gx);
            three(qy0, qy1, gy);
            three(qz0, qz1, gz);
            if nx > 1 {
                gx[0] = gx[0].plus(gx[0]);
                gx[nx - 1] = gx[nx - 1].plus(gx[nx - 1]);
            }
            if y == 0 || y + 1 == ny {
                gy.iter_mut().for_each(|g| *g = g.plus(*g));
            }
            if z == 0 || z + 1 == nz {
                gz.iter_mut().for_each(|g| *g = g.plus(*g));
            }
            sink(y, self.sums.each_ref().map(|s| &s[..]));
        }
    }
}

// The loops below are functions of their own, not inlined: arguments that cannot overlap become vector code without
// tests at run time.

/// The middle layer as lanes, the sum of its neighbours and their difference.
#[inline(never)]
fn fetch<T: Copy, L: Lane>(
    below: &[T],
    middle: &[T],
    above: &[T],
    lane: &impl Fn(T) -> L,
    c: &mut [L],
    s: &mut [L],
    d: &mut [L],
) {
    let n = c.len();
    let (below, middle, above) = (&below[..n], &middle[..n], &above[..n]);
    let (s, d) = (&mut s[..n], &mut d[..n]);
    for i in 0..n {
        let (b, t) = (lane(below[i]), lane(above[i]));
        c[i] = lane(middle[i]);
        s[i] = t.plus(b);
        d[i] = t.minus(b);
    }
}

/// Combines rows across y and z for the value and the gradient along x and y.
#[inline(never)]
fn across<L: Lane>(
    c0: &[L],
    c1: &[L],
    c2: &[L],
    s0: &[L],
    s1: &[L],
    s2: &[L],
    w: &[L; 8],
    p0: &mut [L],
    p1: &mut [L],
    q0: &mut [L],
    q1: &mut [L],
) {
    let n = p0.len();
    let (c0, c1, c2, s0, s1, s2) = (&c0[..n], &c1[..n], &c2[..n], &s0[..n], &s1[..n], &s2[..n]);
    let (p1, q0, q1) = (&mut p1[..n], &mut q0[..n], &mut q1[..n]);
    for i in 0..n {
        let (y, yz) = (c0[i].plus(c2[i]), s0[i].plus(s2[i]));
        let sum = |c: L, wy: L, wz: L, wyz: L| {
            (c1[i].times(c).plus(y.times(wy))).plus(s1[i].times(wz).plus(yz.times(wyz)))
        };
        p0[i] = sum(w[0], w[2], w[4], w[6]);
        p1[i] = sum(w[1], w[3], w[5], w[7]);
        let (near, far) = (c2[i].minus(c0[i]), s2[i].minus(s0[i]));
        q0[i] = near.times(w[2]).plus(far.times(w[6]));
        q1[i] = near.times(w[3]).plus(far.times(w[7]));
    }
}

/// Combines differences along z across y for the gradient along z.
#[inline(never)]
fn across_z<L: Lane>(d0: &[L], d1: &[L], d2: &[L], w: &[L; 8], q0: &mut [L], q1: &mut [L]) {
    let n = q0.len();
    let (d0, d1, d2, q1) = (&d0[..n], &d1[..n], &d2[..n], &mut q1[..n]);
    for i in 0..n {
        let far = d0[i].plus(d2[i]);
        q0[i] = d1[i].times(w[4]).plus(far.times(w[6]));
        q1[i] = d1[i].times(w[5]).plus(far.times(w[7]));
    }
}

/// Three-point sums along x; `out[0]` stands at element 1.
#[inline(never)]
fn three<L: Lane>(centre: &[L], sides: &[L], out: &mut [L]) {
    let n = out.len();
    let (centre, left, right) = (&centre[1..=n], &sides[..n], &sides[2..n + 2]);
    for i in 0..n {
        out[i] = centre[i].plus(left[i].plus(right[i]));
    }
}

/// Differences along x of the neighbours of each element.
#[inline(never)]
fn difference<L: Lane>(row: &[L], out: &mut [L]) {
    let n = out.len();
    let (left, right) = (&row[..n], &row[2..n + 2]);
    for i in 0..n {
        out[i] = right[i].minus(left[i]);
    }
}
