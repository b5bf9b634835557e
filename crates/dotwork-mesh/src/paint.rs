//! The surface's own colours: materials with a base colour and a picture, and where on the picture each corner lies.
//!
//! Places on a picture belong to corners of triangles and not to vertices: where a picture is sewn together two corners
//! of one vertex lie in different places of it, and vertices that are welded must not weld those. So a mesh of few
//! triangles keeps all the detail of its picture.

use std::sync::{Arc, LazyLock};

use dotwork_drawing::color::srgb_to_linear;
use glam::Vec3;

use crate::Mesh;

/// What colours the triangles of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paint {
    /// The materials there are.
    pub materials: Arc<Vec<Material>>,
    /// The material of each triangle.
    pub material: Vec<u32>,
    /// Where the corners of each triangle lie on the picture of its material: 0…1 from the left and from the top.
    pub corners: Vec<[[f32; 2]; 3]>,
}

/// A base colour, and a picture that it multiplies.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Red, green, blue and opacity, linear light.
    pub factor: [f32; 4],
    /// What opacity means.
    pub alpha: Alpha,
    /// The picture, if there is one.
    pub picture: Option<Arc<Picture>>,
    /// How it goes on to the left and right, and above and below.
    pub wrap: [Wrap; 2],
    /// Its samples are small squares; they are blended otherwise.
    pub nearest: bool,
}

impl Default for Material {
    fn default() -> Material {
        Material {
            factor: [1.0; 4],
            alpha: Alpha::Opaque,
            picture: None,
            wrap: [Wrap::Repeat; 2],
            nearest: false,
        }
    }
}

/// What the opacity of a material means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Nothing.
    #[default]
    Opaque,
    /// Below this the surface is not there.
    Mask(f32),
    /// What it says.
    Blend,
}

/// How a picture goes on beyond its edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// It begins again.
    #[default]
    Repeat,
    /// It is mirrored.
    Mirror,
    /// Its last samples go on.
    Clamp,
}

impl Wrap {
    /// The sample at `i` of a row of `count`, which may be any number.
    #[inline]
    fn at(self, i: i64, count: usize) -> usize {
        let n = count as i64;
        let i = match self {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror => match i.rem_euclid(2 * n) {
                i if i < n => i,
                i => 2 * n - 1 - i,
            },
        };
        i as usize
    }
}

/// A picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    /// sRGB and opacity, row by row from the top.
    pixels: Vec<[u8; 4]>,
}

/// Linear light of each 8-bit level.
static LIGHT: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|c| srgb_to_linear(c as u8)));

fn linear([r, g, b, a]: [u8; 4]) -> [f32; 4] {
    let light = &*LIGHT;
    [light[usize::from(r)], light[usize::from(g)], light[usize::from(b)], f32::from(a) / 255.0]
}

fn mix<const N: usize>(parts: [([f32; 4], f32); N]) -> [f32; 4] {
    std::array::from_fn(|c| parts.iter().map(|(color, weight)| color[c] * weight).sum())
}

impl Picture {
    /// A picture of these pixels, sRGB and opacity, row by row from the top; `None` if they are not as many as it has, or
    /// none.
    pub fn new(width: usize, height: usize, pixels: Vec<[u8; 4]>) -> Option<Picture> {
        (!pixels.is_empty() && width.checked_mul(height) == Some(pixels.len())).then_some(Picture {
            width,
            height,
            pixels,
        })
    }

    /// Pixels a row, and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The pixels, sRGB and opacity, row by row from the top.
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// Linear light and opacity at a place, 0…1 from the left and the top.
    fn at(&self, place: [f32; 2], wrap: [Wrap; 2], nearest: bool) -> [f32; 4] {
        // Doubles: a picture may be repeated thousands of times. What is no number lies at 0, what is far beyond any
        // repetition where integers still hold it.
        let along = |k: usize, count: usize| {
            let at = f64::from(place[k]) * count as f64;
            if at.is_finite() { at.clamp(-1e15, 1e15) } else { 0.0 }
        };
        let (u, v) = (along(0, self.width), along(1, self.height));
        let pixel = |x: i64, y: i64| {
            let (x, y) = (wrap[0].at(x, self.width), wrap[1].at(y, self.height));
            linear(self.pixels[y * self.width + x])
        };
        if nearest {
            return pixel(u.floor() as i64, v.floor() as i64);
        }
        let (u, v) = (u - 0.5, v - 0.5);
        let (x, y) = (u.floor(), v.floor());
        let (s, t) = ((u - x) as f32, (v - y) as f32);
        let (x, y) = (x as i64, y as i64);
        mix([
            (pixel(x, y), (1.0 - s) * (1.0 - t)),
            (pixel(x + 1, y), s * (1.0 - t)),
            (pixel(x, y + 1), (1.0 - s) * t),
            (pixel(x + 1, y + 1), s * t),
        ])
    }
}

impl Paint {
    /// True if it says something of each of `triangles` triangles, and all that it refers to is there.
    pub fn fits(&self, triangles: usize) -> bool {
        let known = |&m: &u32| (m as usize) < self.materials.len();
        self.material.len() == triangles && self.corners.len() == triangles && self.material.iter().all(known)
    }

    /// The paint of some of the triangles, in their order.
    pub(crate) fn retain(&mut self, mut keep: impl FnMut() -> bool) {
        let kept: Vec<bool> = self.material.iter().map(|_| keep()).collect();
        let mut keep = kept.iter();
        self.material.retain(|_| keep.next() == Some(&true));
        let mut keep = kept.iter();
        self.corners.retain(|_| keep.next() == Some(&true));
    }

    /// Follows triangles whose corners were put in another order.
    pub(crate) fn turn(&mut self, before: &[[u32; 3]], after: &[[u32; 3]]) {
        for (corners, (before, after)) in self.corners.iter_mut().zip(before.iter().zip(after)) {
            let old = *corners;
            *corners = after.map(|v| old[before.iter().position(|&b| b == v).unwrap_or(0)]);
        }
    }

    /// The paint of pieces of triangles: for each the triangle that it is of and, where it is not whole, the weights of
    /// that triangle's second and third corner at its own.
    pub(crate) fn cut(&self, pieces: &[(u32, Option<[[f32; 2]; 3]>)]) -> Paint {
        let corners = |&(t, weights): &(u32, Option<[[f32; 2]; 3]>)| {
            let [a, b, c] = self.corners[t as usize];
            match weights {
                None => [a, b, c],
                Some(weights) => {
                    weights.map(|w| [0, 1].map(|k| a[k] + (b[k] - a[k]) * w[0] + (c[k] - a[k]) * w[1]))
                }
            }
        };
        Paint {
            materials: self.materials.clone(),
            material: pieces.iter().map(|(t, _)| self.material[*t as usize]).collect(),
            corners: pieces.iter().map(corners).collect(),
        }
    }

    fn at(&self, triangle: usize, [v, w]: [f32; 2]) -> ([f32; 4], Alpha) {
        let material = &self.materials[self.material[triangle] as usize];
        let mut color = material.factor;
        if let Some(picture) = &material.picture {
            let [a, b, c] = self.corners[triangle];
            let place = [0, 1].map(|k| a[k] + (b[k] - a[k]) * v + (c[k] - a[k]) * w);
            let found = picture.at(place, material.wrap, material.nearest);
            color = std::array::from_fn(|k| color[k] * found[k]);
        }
        (color, material.alpha)
    }
}

/// The weights of the second and third corner of a triangle at a place in its plane.
pub(crate) fn weights_at([a, b, c]: [Vec3; 3], p: Vec3) -> [f32; 2] {
    let [a, b, c, p] = [a, b, c, p].map(|v| v.as_dvec3());
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let square = normal.length_squared();
    let weights = [ap.cross(ac).dot(normal) / square, ab.cross(ap).dot(normal) / square];
    weights.map(|w| if w.is_finite() { w.clamp(0.0, 1.0) as f32 } else { 0.0 })
}

impl Mesh {
    /// Whether the surface has colours of its own.
    pub fn is_colored(&self) -> bool {
        !self.colors.is_empty() || self.paint.is_some()
    }

    /// Its own colour at a place of a triangle, given by the weights of the second and third corner: linear light, not
    /// multiplied by the opacity that stands last. White where it has none.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn color_at(&self, triangle: usize, [v, w]: [f32; 2]) -> [f32; 4] {
        let mut color = [1.0; 4];
        if !self.colors.is_empty() {
            let corners = self.triangles[triangle].map(|v| linear(self.colors[v as usize]));
            color = mix([(corners[0], 1.0 - v - w), (corners[1], v), (corners[2], w)]);
        }
        let Some(paint) = &self.paint else { return color };
        let (own, alpha) = paint.at(triangle, [v, w]);
        color = std::array::from_fn(|k| color[k] * own[k]);
        color[3] = match alpha {
            Alpha::Opaque => 1.0,
            Alpha::Mask(least) => f32::from(color[3] >= least),
            Alpha::Blend => color[3],
        };
        color
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red, green; blue, white.
    fn four() -> Picture {
        let pixels = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 0]];
        Picture::new(2, 2, pixels).unwrap()
    }

    #[test]
    fn samples_lie_at_the_middles_of_their_cells() {
        let picture = four();
        for (nearest, wrap) in [(false, Wrap::Repeat), (true, Wrap::Clamp), (false, Wrap::Mirror)] {
            let at = |u: f32, v: f32| picture.at([u, v], [wrap; 2], nearest);
            assert_eq!(at(0.25, 0.25), [1.0, 0.0, 0.0, 1.0]);
            assert_eq!(at(0.75, 0.25), [0.0, 1.0, 0.0, 1.0]);
            assert_eq!(at(0.25, 0.75), [0.0, 0.0, 1.0, 1.0]);
            assert_eq!(at(0.75, 0.75), [1.0, 1.0, 1.0, 0.0]);
        }
        let middle = picture.at([0.5, 0.5], [Wrap::Clamp; 2], false);
        assert_eq!(middle, [0.5, 0.5, 0.5, 0.75]);
    }

    #[test]
    fn pictures_go_on_as_they_are_told() {
        let picture = four();
        let red = |u: f32, wrap: Wrap| picture.at([u, 0.25], [wrap; 2], true)[0];
        for (u, repeat, mirror, clamp) in
            [(-0.25, 0.0, 1.0, 1.0), (1.25, 1.0, 0.0, 0.0), (2.25, 1.0, 1.0, 0.0), (-1.25, 0.0, 0.0, 1.0)]
        {
            let got = [red(u, Wrap::Repeat), red(u, Wrap::Mirror), red(u, Wrap::Clamp)];
            assert_eq!(got, [repeat, mirror, clamp], "{u}");
        }
    }

    #[test]
    fn no_place_is_too_strange() {
        let picture = four();
        for strange in [f32::NAN, f32::INFINITY, f32::MAX, f32::MIN, -0.0, 1e-40] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                for nearest in [false, true] {
                    let color = picture.at([strange, strange], [wrap; 2], nearest);
                    assert!(color.iter().all(|c| (0.0..=1.0).contains(c)), "{strange}");
                }
            }
        }
        assert_eq!(Picture::new(usize::MAX, 2, vec![[0; 4]]), None);
        assert_eq!(Picture::new(0, 0, Vec::new()), None);
    }

    #[test]
    fn weights_are_those_of_the_place() {
        let corners = [Vec3::ZERO, Vec3::X * 4.0, Vec3::new(0.0, 2.0, 1.0)];
        let place = |v: f32, w: f32| corners[1] * v + corners[2] * w;
        let [v, w] = weights_at(corners, place(0.25, 0.5));
        assert!((v - 0.25).abs() < 1e-6 && (w - 0.5).abs() < 1e-6);
        assert_eq!(weights_at([Vec3::ONE; 3], Vec3::ZERO), [0.0; 2]);
    }
}
