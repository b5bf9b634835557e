//! Signed distances of simple solids, negative inside, and their smooth unions.
//!
//! Capsules, boxes and tori are exact. The ellipsoid's is the first-order estimate `k₀(k₀ − 1)/k₁` (Inigo Quilez,
//! "Ellipsoid SDF", 2008), exact in value and slope at the surface. The union is the quadratic polynomial smooth
//! minimum (Quilez, "Smooth minimum", 2013): it differs from the minimum only where both distances are within `k` of
//! each other, so that a solid whose bounding box is farther than that can be left out without a change.
//! Nothing here calls a transcendental function: all machines compute the same distances.

use glam::{Vec2, Vec3, vec2, vec3};

/// Where the solids of one side of a symmetric body are evaluated: x becomes |x|.
pub(super) fn mirrored(p: Vec3) -> Vec3 {
    vec3(p.x.abs(), p.y, p.z)
}

/// The smooth union of two solids, whose seam is filled over a width of `k`.
pub(super) fn union(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0);
    a.min(b) - h * h / (4.0 * k)
}

/// The smooth intersection of two solids.
pub(super) fn intersection(a: f32, b: f32, k: f32) -> f32 {
    -union(-a, -b, k)
}

/// `a` without `b`, the rim rounded over a width of `k`.
pub(super) fn without(a: f32, b: f32, k: f32) -> f32 {
    intersection(a, -b, k)
}

/// A smooth union with a costly solid inside the box from `min` to `max`, not evaluated where it cannot matter.
pub(super) fn union_in_box(
    d: f32,
    p: Vec3,
    min: Vec3,
    max: Vec3,
    k: f32,
    solid: impl FnOnce(Vec3) -> f32,
) -> f32 {
    if outside(p, min, max) >= d + k { d } else { union(d, solid(p), k) }
}

/// The difference of a costly solid inside a box, not evaluated where it cannot matter.
pub(super) fn without_in_box(
    d: f32,
    p: Vec3,
    min: Vec3,
    max: Vec3,
    k: f32,
    solid: impl FnOnce(Vec3) -> f32,
) -> f32 {
    -union_in_box(-d, p, min, max, k, solid)
}

/// The distance to a box from outside it, else 0.
fn outside(p: Vec3, min: Vec3, max: Vec3) -> f32 {
    (min - p).max(p - max).max(Vec3::ZERO).length()
}

/// An ellipsoid about the origin.
pub(super) fn ellipsoid(p: Vec3, radii: Vec3) -> f32 {
    let q = p / radii;
    let k0 = q.length();
    let k1 = (q / radii).length();
    // No point lies deeper than the smallest radius.
    if k1 < 1e-12 {
        return -radii.min_element();
    }
    (k0 * (k0 - 1.0) / k1).max(-radii.min_element())
}

/// A ball about the origin.
pub(super) fn ball(p: Vec3, radius: f32) -> f32 {
    p.length() - radius
}

/// How far along the segment from `a` to `b` the point nearest to `p` lies, 0 … 1.
fn along(p: Vec3, a: Vec3, b: Vec3) -> f32 {
    let ab = b - a;
    ((p - a).dot(ab) / ab.length_squared()).clamp(0.0, 1.0)
}

/// All points within `radius` of a segment.
pub(super) fn capsule(p: Vec3, a: Vec3, b: Vec3, radius: f32) -> f32 {
    cone(p, a, b, radius, radius)
}

/// Balls along a segment, their radius going from `ra` to `rb`.
pub(super) fn cone(p: Vec3, a: Vec3, b: Vec3, ra: f32, rb: f32) -> f32 {
    let t = along(p, a, b);
    (p - a.lerp(b, t)).length() - (ra + t * (rb - ra))
}

/// A capsule flattened along one axis: `stretch` are the factors by which it is wider than `radius` along x, y, z.
pub(super) fn flat_capsule(p: Vec3, a: Vec3, b: Vec3, radius: f32, stretch: Vec3) -> f32 {
    let away = p - a.lerp(b, along(p / stretch, a / stretch, b / stretch));
    ellipsoid(away, stretch * radius)
}

/// A box about the origin with half sides `half`, rounding of its edges included.
pub(super) fn rounded_box(p: Vec3, half: Vec3, rounding: f32) -> f32 {
    let q = p.abs() - half + Vec3::splat(rounding);
    q.max(Vec3::ZERO).length() + q.max_element().min(0.0) - rounding
}

/// A cylinder about the z axis of half height `half`, its rims rounded.
pub(super) fn cylinder(p: Vec3, radius: f32, half: f32, rounding: f32) -> f32 {
    let q = vec2(p.truncate().length() - radius, p.z.abs() - half) + Vec2::splat(rounding);
    q.max(Vec2::ZERO).length() + q.max_element().min(0.0) - rounding
}

/// A wall along a polyline seen from above: `path` holds x, y and the middle height z; the wall is `2 thick` wide and
/// `2 half` high, its edges rounded by `thick`.
pub(super) fn wall(p: Vec3, path: &[Vec3], thick: f32, half: f32) -> f32 {
    let mut nearest = f32::INFINITY;
    let mut middle = 0.0;
    for pair in path.windows(2) {
        let flat = |v: Vec3| v.truncate().extend(0.0);
        let t = along(flat(p), flat(pair[0]), flat(pair[1]));
        let at = pair[0].lerp(pair[1], t);
        let away = (p.truncate() - at.truncate()).length();
        if away < nearest {
            (nearest, middle) = (away, at.z);
        }
    }
    let q = vec2(nearest, ((p.z - middle).abs() - (half - thick)).max(0.0));
    q.length() - thick
}

/// The Catmull–Rom curve through these points as a polyline, `steps` of its pieces from each to the next.
pub(super) fn curve(points: &[Vec3], steps: usize) -> Vec<Vec3> {
    let last = points.len() - 1;
    let mut line = vec![points[0]];
    for i in 0..last {
        let [a, b, c, d] = [i.saturating_sub(1), i, i + 1, (i + 2).min(last)].map(|i| points[i]);
        for step in 1..steps {
            let t = step as f32 / steps as f32;
            let bend = (2.0 * a - 5.0 * b + 4.0 * c - d) * t + (3.0 * (b - c) + d - a) * t * t;
            line.push(b + 0.5 * t * (c - a + bend));
        }
        // The given points themselves, to the bit.
        line.push(c);
    }
    line
}

/// `3t² − 2t³` between `from` and `to`, clamped.
pub(super) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A wave of period 1 close to `sin 2πx` (within 0.06 of it): two parabolas.
pub(super) fn wave(x: f32) -> f32 {
    let t = x - x.floor() - 0.5;
    -8.0 * t * (1.0 - 2.0 * t.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ellipsoids_are_exact_to_first_order_at_their_surface() {
        let r = vec3(3.0, 5.0, 9.0);
        for i in 0..200 {
            let (a, b) = (i as f32 * 0.37, i as f32 * 0.11);
            let on = vec3(a.cos() * b.cos(), a.sin() * b.cos(), b.sin()) * r;
            let normal = (on / (r * r)).normalize();
            assert!(ellipsoid(on, r).abs() < 1e-5);
            for step in [-0.02, 0.02] {
                let d = ellipsoid(on + normal * step, r);
                assert!((d - step).abs() < 0.02 * step.abs(), "{d} at {step}");
            }
        }
        assert_eq!(ellipsoid(Vec3::ZERO, r), -3.0);
    }

    #[test]
    fn boxes_cylinders_and_capsules_have_their_distances() {
        let half = vec3(2.0, 3.0, 4.0);
        assert_eq!(rounded_box(vec3(5.0, 7.0, 0.0), half, 0.0), 5.0);
        assert_eq!(rounded_box(vec3(1.5, 0.0, 0.0), half, 0.0), -0.5);
        assert!((rounded_box(vec3(5.0, 6.0, 0.0), half, 1.0) - (32f32.sqrt() - 1.0)).abs() < 1e-6);
        assert_eq!(cylinder(vec3(0.0, 4.0, 0.0), 1.0, 2.0, 0.0), 3.0);
        assert_eq!(cylinder(vec3(4.0, 0.0, 6.0), 1.0, 2.0, 0.0), 5.0);
        let (a, b) = (vec3(0.0, 0.0, -1.0), vec3(0.0, 0.0, 1.0));
        assert_eq!(capsule(vec3(0.0, 4.0, 4.0), a, b, 1.0), 4.0);
        assert_eq!(flat_capsule(vec3(6.0, 0.0, 0.0), a, b, 1.0, vec3(2.0, 1.0, 1.0)), 4.0);
    }

    #[test]
    fn smooth_unions_differ_only_near_the_seam() {
        assert_eq!(union(1.0, 3.0, 2.0), 1.0);
        assert_eq!(union(1.0, 1.0, 2.0), 0.5);
        assert_eq!(without(-1.0, 5.0, 2.0), -1.0);
        let (min, max) = (Vec3::splat(-1.0), Vec3::ONE);
        for i in 0..100 {
            let p = vec3(i as f32 * 0.05, 0.3, 0.2);
            let d = p.x - 2.0;
            let solid = |p| ball(p, 1.0);
            assert_eq!(union_in_box(d, p, min, max, 0.7, solid), union(d, solid(p), 0.7));
            assert_eq!(without_in_box(d, p, min, max, 0.7, solid), without(d, solid(p), 0.7));
        }
    }

    #[test]
    fn curves_pass_through_their_points_and_keep_lines_straight() {
        let points: Vec<Vec3> = (0..5).map(|i| vec3(i as f32, (i * i) as f32, 1.0)).collect();
        let line = curve(&points, 4);
        assert_eq!(line.len(), 17);
        for (i, p) in points.iter().enumerate() {
            assert_eq!(line[4 * i], *p);
        }
        // Inner pieces reproduce a parabola.
        for p in &line[4..=12] {
            assert!((p.y - p.x * p.x).abs() < 1e-5 && p.z == 1.0, "{p}");
        }
    }

    #[test]
    fn waves_are_near_sines() {
        for i in -50..50 {
            let x = i as f32 * 0.037;
            assert!((wave(x) - (std::f32::consts::TAU * x).sin()).abs() < 0.06);
        }
    }
}
