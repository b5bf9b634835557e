//! The brain: two folded hemispheres, cerebellum, stem, ganglia and ventricles.

use glam::{Vec3, vec3};

use super::super::distance::{
    capsule, cone, ellipsoid, intersection, mirrored, smoothstep, union, wave, without,
};
use super::skull;

/// Thickness of the cortex, millimetres.
pub(super) const CORTEX: f32 = 3.2;

/// How deep the fluid around the brain is, millimetres.
const FLUID: f32 = 2.4;

/// Height of the tent between cerebrum and cerebellum, falling to the sides and to the back.
fn tent(m: Vec3) -> f32 {
    28.0 - 0.10 * m.x - 0.22 * (m.y - 20.0)
}

/// Directions and phases of the waves whose zeros are the folds, in periods a radian, with no order among them.
const WAVES: [[f32; 4]; 12] = [
    [2.31, 0.42, -0.97, 0.13],
    [-0.64, 2.23, 1.12, 0.71],
    [0.91, -1.35, 1.99, 0.37],
    [1.62, 1.71, 0.83, 0.92],
    [-1.94, 0.77, 1.51, 0.05],
    [0.22, 0.58, -2.49, 0.58],
    [-1.25, -1.88, -1.14, 0.29],
    [2.05, -1.43, 0.41, 0.84],
    [-0.31, 1.52, -2.03, 0.46],
    [1.44, 0.13, 2.08, 0.66],
    [-2.26, -0.92, -0.55, 0.21],
    [0.67, 2.35, -0.48, 0.97],
];

/// The distance to the nearest fold's middle, estimated to first order: the zeros of a sum of waves over the
/// directions from the middle of a hemisphere, whose lines meander at a steady distance as the gyri do.
fn folds(p: Vec3, radius_scale: f32) -> f32 {
    let from = vec3(p.x * 0.95, p.y - 4.0, p.z - 34.0) / vec3(62.0, 84.0, 66.0);
    let radius = from.length().max(0.2);
    // Warped a little, so that no circle is seen.
    let q = from / radius;
    let q = q + 0.10 * vec3(wave(q.y * 0.9 + 0.1), wave(q.z * 0.8 + 0.4), wave(q.x * 0.7 + 0.8));
    let (mut sum, mut slope) = (0.0, Vec3::ZERO);
    for [x, y, z, phase] in WAVES {
        let k = vec3(x, y, z) * 1.45;
        let at = k.dot(q) + phase;
        sum += wave(at);
        slope += k * wave(at + 0.25);
    }
    // Along the sphere of directions only.
    let slope = (slope - q * slope.dot(q) / q.length_squared()) * std::f32::consts::TAU;
    sum.abs() / slope.length().max(9.0) * radius * radius_scale
}

/// The hemispheres with their folds.
pub(super) fn cerebrum(p: Vec3) -> f32 {
    let m = mirrored(p);
    let inside = skull::cavity(p);
    let hull = inside + FLUID;
    // Above the tent, and not where the stem passes.
    // In front of the tent's edge the temporal lobes reach down to the floor.
    let under = (tent(m) - m.z) * 0.9 - 45.0 * (1.0 - smoothstep(-20.0, 24.0, m.y));
    let mut d = intersection(hull, under, 4.0);
    d = without(d, ellipsoid(p - vec3(0.0, 0.0, 4.0), vec3(17.0, 26.0, 20.0)), 4.0);
    if d > 8.0 {
        return d;
    }
    // The fissure between the hemispheres reaches down to the corpus callosum.
    let callosum = ellipsoid(p - vec3(0.0, 4.0, 26.0), vec3(40.0, 44.0, 32.0));
    let fissure = intersection(m.x - 1.4, -callosum, 4.0);
    d = without(d, fissure, 2.0);
    // The lateral fissure over the temporal lobe.
    let lateral = cone(m, vec3(60.0, -40.0, 10.0), vec3(64.0, 34.0, 42.0), 3.4, 1.6).min(cone(
        m,
        vec3(46.0, -30.0, 14.0),
        vec3(44.0, 20.0, 34.0),
        2.0,
        1.2,
    ));
    d = without(d, lateral, 3.0);
    let depth = -inside;
    if d > -24.0 && depth < 26.0 {
        let reach = 14.0 + 4.0 * wave(p.y / 61.0 + p.z / 83.0) + 3.0 * wave(p.x / 47.0 + 0.3);
        let fold = folds(p, 72.0) - (1.4 - 0.04 * depth).max(0.7);
        d = without(d, intersection(fold, depth - reach, 3.0), 2.0);
    }
    d
}

/// The cerebellum: two lobes with fine level folds.
pub(super) fn cerebellum(p: Vec3) -> f32 {
    let m = mirrored(p);
    let lobes = ellipsoid(m - vec3(22.0, 50.0, -1.0), vec3(34.0, 34.0, 27.0));
    let vermis = ellipsoid(m - vec3(0.0, 48.0, 4.0), vec3(12.0, 22.0, 18.0));
    let d = union(lobes, vermis, 4.0);
    let d = intersection(d, skull::cavity(p) + FLUID, 3.0);
    let d = intersection(d, (m.z - tent(m) + 2.0) * 0.9, 3.0);
    if d.abs() > 6.0 {
        return d;
    }
    let arc = (m - vec3(0.0, 30.0, -2.0)) * vec3(0.4, 0.8, 1.0);
    d + 0.7 * wave(arc.z / 5.2 + 0.02 * arc.y + 0.002 * m.x * m.x / 5.2)
}

/// Thalamus, midbrain, pons and medulla.
pub(super) fn stem(p: Vec3) -> f32 {
    let m = mirrored(p);
    let thalamus = ellipsoid(m - vec3(11.0, 6.0, 31.0), vec3(9.0, 15.0, 9.0));
    let midbrain = cone(m, vec3(5.0, 6.0, 26.0), vec3(4.0, 10.0, 10.0), 11.0, 9.0);
    let pons = ellipsoid(p - vec3(0.0, 10.0, -2.0), vec3(16.0, 12.0, 13.0));
    let medulla = cone(p, vec3(0.0, 14.0, -8.0), vec3(0.0, 18.0, -36.0), 9.0, 6.0);
    let peduncle = cone(m, vec3(8.0, 14.0, -1.0), vec3(20.0, 36.0, -3.0), 7.0, 8.0);
    union(union(thalamus, midbrain, 6.0), union(union(pons, medulla, 6.0), peduncle, 5.0), 5.0)
}

/// The grey kernels within the hemispheres: caudate and lentiform nucleus, thalamus.
pub(super) fn ganglia(p: Vec3) -> f32 {
    let m = mirrored(p);
    let lentiform = ellipsoid(m - vec3(24.0, -4.0, 30.0), vec3(6.0, 16.0, 9.0));
    let caudate = cone(m, vec3(12.0, -24.0, 36.0), vec3(17.0, 6.0, 50.0), 6.0, 3.0);
    let thalamus = ellipsoid(m - vec3(11.0, 6.0, 31.0), vec3(7.0, 13.0, 7.5));
    lentiform.min(caudate).min(thalamus)
}

/// Lateral, third and fourth ventricle and the aqueduct.
pub(super) fn ventricles(p: Vec3) -> f32 {
    let m = mirrored(p);
    // A ram's horn: frontal horn, body, atrium, and from it the temporal and occipital horns.
    let frontal = cone(m, vec3(9.0, -36.0, 38.0), vec3(8.0, -6.0, 48.0), 5.0, 5.2);
    let body = cone(m, vec3(8.0, -6.0, 48.0), vec3(20.0, 34.0, 42.0), 5.2, 6.8);
    let temporal = cone(m, vec3(22.0, 34.0, 40.0), vec3(30.0, -8.0, 8.0), 6.0, 2.4);
    let occipital = cone(m, vec3(22.0, 34.0, 40.0), vec3(16.0, 60.0, 36.0), 6.0, 2.2);
    let third = ellipsoid(p - vec3(0.0, 2.0, 30.0), vec3(2.6, 15.0, 11.0));
    let aqueduct = capsule(p, vec3(0.0, 10.0, 26.0), vec3(0.0, 26.0, -2.0), 1.6);
    let fourth = ellipsoid(p - vec3(0.0, 27.0, -2.0), vec3(7.0, 5.0, 10.0));
    let lateral = union(union(frontal, body, 3.0), union(temporal, occipital, 5.0), 4.0);
    lateral.min(union(union(third, aqueduct, 1.5), fourth, 2.0))
}
