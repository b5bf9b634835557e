//! The tangent-plane section of a voxel: the polygon in which a plane through the voxel's centre cuts it.
//!
//! A voxel is a parallelepiped `s·a + t·b + u·c` with s, t, u in ±½ about its centre. On the plane `n·p = 0` the edge
//! that lies steepest on it, say `c`, follows from the other two, so the section is the unit square of (s, t) cut by
//! the strip |u| ≤ ½: a parallelogram, or a hexagon that is its own point reflection. Either tiles the plane by
//! translations, and so has distances without borders: a point near one edge is near those at the opposite edge.

use glam::{Vec2, Vec3};

/// A section, as coordinates (s, t) in ±½ on two vectors of the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    /// What s and t are measured along.
    along: [Vec3; 2],
    /// Inside: |strip · (s, t)| ≤ ½.
    strip: Vec2,
    /// Area, object units squared.
    pub area: f32,
    /// (s, t) to multiples of the two shortest translations: the rows of a matrix.
    to_lattice: [Vec2; 2],
    /// Dot products of the translations: first with itself, first with second, second with itself.
    gram: [f32; 3],
}

impl Section {
    /// The section of a voxel with these edges across unit vector `normal`; `None` if there is none with an area.
    pub fn new(edges: [Vec3; 3], normal: Vec3) -> Option<Section> {
        let heights = edges.map(|e| e.dot(normal));
        let steepest = (0..3).max_by(|&i, &j| heights[i].abs().total_cmp(&heights[j].abs()))?;
        let [i, j] = [(steepest + 1) % 3, (steepest + 2) % 3];
        let strip = Vec2::new(heights[i], heights[j]) / heights[steepest];
        let along = [edges[i] - strip.x * edges[steepest], edges[j] - strip.y * edges[steepest]];
        // By how much the strip cuts two corners off the square, in units of u.
        let (a, b) = (strip.x.abs(), strip.y.abs());
        let cut = (0.5 * (a + b - 1.0)).max(0.0);
        let (cut_s, cut_t) = if cut > 0.0 { (cut / a, cut / b) } else { (0.0, 0.0) };
        let area = along[0].cross(along[1]).length() * (1.0 - cut_s * cut_t);
        // Not so for what is no number.
        if !(area > 0.0 && area.is_finite()) {
            return None;
        }
        // The translations take each edge to the opposite one.
        let side = if strip.x * strip.y < 0.0 { -1.0 } else { 1.0 };
        let (mut t1, mut t2) = (Vec2::new(1.0, -side * cut_t), Vec2::new(-side * cut_s, 1.0));
        let real = |t: Vec2| t.x * along[0] + t.y * along[1];
        // Gauss's reduction; a handful of rounds even for needles.
        for _ in 0..32 {
            if real(t2).length_squared() < real(t1).length_squared() {
                std::mem::swap(&mut t1, &mut t2);
            }
            let turns = (real(t1).dot(real(t2)) / real(t1).length_squared()).round();
            if turns == 0.0 || !turns.is_finite() {
                break;
            }
            t2 -= turns * t1;
        }
        let (p1, p2) = (real(t1), real(t2));
        let inverse = 1.0 / t1.perp_dot(t2);
        let to_lattice = [Vec2::new(t2.y, -t2.x) * inverse, Vec2::new(-t1.y, t1.x) * inverse];
        Some(Section { along, strip, area, to_lattice, gram: [p1.dot(p1), p1.dot(p2), p2.dot(p2)] })
    }

    /// True if (s, t), each in ±½, lies inside.
    #[inline(always)]
    pub fn contains(&self, st: Vec2) -> bool {
        self.strip.dot(st).abs() <= 0.5
    }

    /// The place of (s, t) relative to the voxel's centre.
    pub fn place(&self, st: Vec2) -> Vec3 {
        st.x * self.along[0] + st.y * self.along[1]
    }

    /// (s, t) as multiples of the translations.
    #[inline(always)]
    pub fn lattice(&self, st: Vec2) -> Vec2 {
        Vec2::new(self.to_lattice[0].dot(st), self.to_lattice[1].dot(st))
    }

    /// Squared distance without borders of two points `(f, g)` apart in multiples of the translations.
    #[inline(always)]
    pub fn distance_squared(&self, f: f32, g: f32) -> f32 {
        // To the nearest whole number, by the rounding of additions: a call to `round` would keep loops from vectors.
        const MAGIC: f32 = 12_582_912.0;
        let (f, g) = (f - ((f + MAGIC) - MAGIC), g - ((g + MAGIC) - MAGIC));
        // The shortest translations lie at 60° or more, so the nearest image is this one or one step away in either.
        let [a, b, c] = self.gram;
        let square = |f: f32, g: f32| f * f * a + 2.0 * f * g * b + g * g * c;
        let (near, in_f, in_g) =
            (square(f, g), square(f - 1f32.copysign(f), g), square(f, g - 1f32.copysign(g)));
        let near = if in_f < near { in_f } else { near };
        if in_g < near { in_g } else { near }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dotwork_drawing::hash::{hash2, unit};

    const CUBE: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

    fn random(i: u32, k: u32) -> f32 {
        unit(hash2(i, k)) - 0.5
    }

    #[test]
    fn sections_of_a_cube_have_the_areas_of_closed_forms() {
        for (normal, area) in [
            (Vec3::Z, 1.0),
            (-Vec3::X, 1.0),
            (Vec3::new(1.0, 1.0, 0.0), 2f32.sqrt()),
            (Vec3::new(0.0, -1.0, 1.0), 2f32.sqrt()),
            // A regular hexagon.
            (Vec3::ONE, 0.75 * 3f32.sqrt()),
            (Vec3::new(-1.0, 1.0, -1.0), 0.75 * 3f32.sqrt()),
        ] {
            let section = Section::new(CUBE, normal.normalize()).unwrap();
            assert!((section.area - area).abs() < 1e-5, "{normal}: {}", section.area);
        }
        assert!(Section::new(CUBE, Vec3::NAN).is_none());
        assert!(Section::new(CUBE, Vec3::ZERO).is_none());
        assert!(Section::new([Vec3::ZERO; 3], Vec3::Z).is_none());
    }

    /// A skewed, uneven voxel and a random plane: the area by counting, and points that lie where they should.
    #[test]
    fn any_section_is_the_cut_of_its_voxel() {
        for i in 0..40 {
            let edges = [0, 3, 6].map(|k| {
                let axis = CUBE[k as usize / 3];
                axis * (1.5 + random(i, 20 + k))
                    + 0.8 * Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2))
            });
            let normal = Vec3::new(random(i, 9), random(i, 10), random(i, 11)).normalize();
            let section = Section::new(edges, normal).unwrap();
            let inverse = glam::Mat3::from_cols(edges[0], edges[1], edges[2]).inverse();
            let (across, along) = normal.any_orthonormal_pair();
            let (mut inside, tries) = (0, 20_000);
            for j in 0..tries {
                let p = 4.0 * (random(j, 100) * across + random(j, 101) * along);
                inside += u32::from((inverse * p).abs().max_element() <= 0.5);
                let st = Vec2::new(random(j, 102), random(j, 103));
                let place = section.place(st);
                assert!(place.dot(normal).abs() < 1e-4);
                if section.contains(st) {
                    assert!((inverse * place).abs().max_element() <= 0.5 + 1e-4);
                }
            }
            let counted = 16.0 * inside as f32 / tries as f32;
            assert!((section.area / counted - 1.0).abs() < 0.1, "{i}: {} {counted}", section.area);
        }
    }

    #[test]
    fn distances_have_no_borders() {
        let slanted = [Vec3::X, Vec3::new(0.9, 1.0, 0.0), Vec3::new(0.1, -0.3, 2.5)];
        for (edges, normal) in [
            (CUBE, Vec3::Z),
            (CUBE, Vec3::ONE.normalize()),
            (CUBE, Vec3::new(0.3, -0.7, 0.5).normalize()),
            (slanted, Vec3::new(-0.4, 0.5, 0.9).normalize()),
        ] {
            let section = Section::new(edges, normal).unwrap();
            for i in 0..2000 {
                let [p, q] = [0, 2].map(|k| Vec2::new(random(i, k), random(i, k + 1)));
                let apart = section.lattice(p) - section.lattice(q);
                let d = section.distance_squared(apart.x, apart.y).sqrt();
                let straight = section.place(p - q).length();
                // The shortest over all translations.
                let [a, b, c] = section.gram;
                let exact = (-4..=4)
                    .flat_map(|m| (-4..=4).map(move |n| apart + Vec2::new(m as f32, n as f32)))
                    .map(|v| (v.x * v.x * a + 2.0 * v.x * v.y * b + v.y * v.y * c).max(0.0).sqrt())
                    .fold(f32::MAX, f32::min);
                assert!(exact <= straight + 1e-4 && (d - exact).abs() < 1e-4, "{d} {exact}");
                let again = section.distance_squared(apart.x + 1.0, apart.y - 2.0).sqrt();
                assert!((d - again).abs() < 1e-4);
            }
            // The lattice cell is the section.
            let [a, b, c] = section.gram;
            assert!(((a * c - b * b).sqrt() - section.area).abs() < 1e-4);
        }
    }
}
