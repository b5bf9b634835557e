//! The skull: vault and base, and the vertebrae beneath.

use glam::{Vec3, vec3};

use super::super::distance::{
    capsule, cone, ellipsoid, flat_capsule, intersection, mirrored, rounded_box, smoothstep, union,
    union_in_box, wave, without, without_in_box,
};
use super::face;

/// Thickness of the vault, millimetres.
const VAULT: f32 = 7.0;

/// The outline of the braincase from outside: forehead, parietal and occipital eminences, temples.
pub(super) fn braincase(p: Vec3) -> f32 {
    let m = mirrored(p);
    let frontal = ellipsoid(p - vec3(0.0, -26.0, 54.0), vec3(55.0, 65.5, 61.5));
    let parietal = ellipsoid(m - vec3(6.0, 20.0, 50.0), vec3(65.5, 64.0, 69.0));
    let occipital = ellipsoid(p - vec3(0.0, 38.0, 24.0), vec3(58.0, 54.0, 50.0));
    let temporal = ellipsoid(p - vec3(0.0, -6.0, 22.0), vec3(67.0, 52.0, 40.0));
    union(union(frontal, parietal, 26.0), union(occipital, temporal, 20.0), 22.0)
}

/// Height of the floor of the cranial cavity: three fossae, each a step lower than the one before it.
fn floor(m: Vec3) -> f32 {
    let anterior = 28.0 + 8.0 * smoothstep(5.0, 18.0, m.x);
    let middle = -5.0 + 16.0 * (1.0 - smoothstep(10.0, 22.0, m.x));
    let posterior = -50.0;
    let front = anterior + (middle - anterior) * smoothstep(-44.0, -26.0, m.y);
    front + (posterior - front) * smoothstep(2.0, 20.0, m.y)
}

/// How far a point lies below the floor, in the units of a distance: the steps are steep.
fn below_floor(m: Vec3) -> f32 {
    (floor(m) - m.z) * 0.55
}

/// The cranial cavity.
pub(super) fn cavity(p: Vec3) -> f32 {
    cavity_within(braincase(p), p)
}

/// The cranial cavity, given the distance to the outline of the braincase.
fn cavity_within(outline: f32, p: Vec3) -> f32 {
    let m = mirrored(p);
    let inside = intersection(outline + VAULT, below_floor(m), 5.0);
    // The frontal bone is thick where its sinuses are.
    let inside = without_in_box(inside, m, vec3(-1.0, -95.0, 20.0), vec3(26.0, -76.0, 54.0), 5.0, |m| {
        face::frontal_sinus(m) - 3.0
    });
    // Petrous ridges.
    let petrous = cone(m, vec3(58.0, 6.0, 2.0), vec3(14.0, -12.0, 4.0), 12.0, 7.0);
    without(inside, petrous, 5.0)
}

/// Grooves along the sutures of the vault, millimetres deep.
fn sutures(p: Vec3) -> f32 {
    if p.z < 14.0 {
        return 0.0;
    }
    let groove = |away: f32| {
        let t = (1.0 - (away / 1.5).powi(2)).max(0.0);
        1.5 * t * t
    };
    let teeth = |s: f32| 1.6 * wave(s / 9.0) + 1.0 * wave(s / 4.3 + 0.2);
    let x = p.x;
    let coronal = -14.0 - 0.22 * (118.0 - p.z);
    // Lambda, where the sagittal suture meets the two arms of the lambdoid.
    let lambda = 84.0 - 0.85 * x.abs();
    let mut depth = 0f32;
    if p.y < 40.0 {
        depth = depth.max(groove((p.y - coronal + teeth(x) * smoothstep(6.0, 16.0, x.abs())) * 0.97));
    }
    if p.y > coronal && (p.z > lambda || p.y < 30.0) {
        depth = depth.max(groove(x + teeth(p.y - 0.7 * p.z)));
    }
    if p.y > 30.0 {
        depth = depth.max(groove((p.z - lambda + 1.3 * teeth(x * 1.3 + 3.0)) * 0.76));
    }
    // Both run out towards the temples.
    depth * smoothstep(14.0, 34.0, p.z)
}

/// All bone, teeth apart.
pub(super) fn bone(p: Vec3) -> f32 {
    let m = mirrored(p);
    let outline = braincase(p);
    let mut d = intersection(outline, below_floor(m) - 3.0, 6.0);
    if d.abs() < 4.0 {
        d += sutures(p);
    }
    // Mastoid processes, and the ridge of the nape with its protuberance.
    d = union_in_box(d, m, vec3(40.0, 0.0, -40.0), vec3(70.0, 34.0, 8.0), 8.0, |m| {
        cone(m, vec3(57.0, 16.0, 0.0), vec3(53.0, 11.0, -26.0), 11.0, 5.5)
    });
    d = union_in_box(d, m, vec3(-10.0, 60.0, -10.0), vec3(45.0, 95.0, 22.0), 6.0, |m| {
        let nape = flat_capsule(m, vec3(0.0, 86.0, 8.0), vec3(34.0, 70.0, 2.0), 3.2, vec3(1.0, 1.0, 1.6));
        union(nape, ellipsoid(m - vec3(0.0, 87.0, 7.0), vec3(8.0, 4.5, 5.0)), 4.0)
    });
    // Temporal lines.
    d = union_in_box(d, m, vec3(36.0, -75.0, 28.0), vec3(70.0, 30.0, 80.0), 9.0, |m| {
        let line = |a, b| capsule(m, a, b, 2.6);
        line(vec3(45.0, -68.0, 34.0), vec3(45.5, -50.0, 58.0))
            .min(line(vec3(45.5, -50.0, 58.0), vec3(52.0, -10.0, 75.0)))
    });
    // Base of the skull: clivus and body of the sphenoid, pterygoid processes.
    d = union_in_box(d, m, vec3(-20.0, -50.0, -40.0), vec3(25.0, 14.0, 16.0), 5.0, |m| {
        let clivus = cone(m, vec3(0.0, -24.0, 4.0), vec3(0.0, 2.0, -24.0), 14.0, 6.0);
        let pterygoid =
            flat_capsule(m, vec3(12.0, -32.0, 0.0), vec3(13.0, -30.0, -32.0), 3.0, vec3(1.0, 2.2, 1.0));
        union(clivus, pterygoid, 5.0)
    });
    d = union_in_box(d, m, face::BOX[0], face::BOX[1], 9.0, face::upper);
    d = without(d, cavity_within(outline, p), 1.0);
    d = without_in_box(d, m, face::BOX[0], face::BOX[1], 2.0, face::openings);
    // Foramen magnum and the spinal canal.
    d = without_in_box(d, m, vec3(-18.0, -6.0, -60.0), vec3(18.0, 40.0, 0.0), 4.0, |m| {
        cone(m / vec3(0.85, 1.0, 1.0), vec3(0.0, 19.0, -10.0), vec3(0.0, 18.0, -60.0), 17.0, 15.0)
    });
    d = union_in_box(d, m, face::JAW_BOX[0], face::JAW_BOX[1], 2.0, face::jaw);
    union_in_box(d, m, vec3(-2.0, -4.0, -146.0), vec3(38.0, 72.0, -34.0), 1.0, vertebrae)
}

/// Cervical vertebrae: bodies with discs between, arches, transverse and spinous processes.
fn vertebrae(m: Vec3) -> f32 {
    const PITCH: f32 = 18.0;
    // One vertebra a pitch; the nearest and its neighbours are enough.
    let nearest = ((-44.0 - m.z) / PITCH).round().clamp(0.0, 5.0);
    let mut d = f32::INFINITY;
    for n in [nearest - 1.0, nearest, nearest + 1.0] {
        if !(0.0..=5.0).contains(&n) {
            continue;
        }
        // The column leans backwards as it descends.
        let z = -44.0 - PITCH * n;
        let at = m - vec3(0.0, 20.0 + 0.10 * (-44.0 - z), z);
        let (wide, spine) = if n == 0.0 { (35.0, 20.0) } else { (24.0 + n, 20.0 + 3.0 * n) };
        let body = rounded_box(at - vec3(0.0, -14.5, 0.0), vec3(10.0, 7.5, 7.8), 3.5);
        let ring = {
            let around = (at.truncate() / glam::vec2(1.25, 1.0)).length() - 11.5;
            glam::vec2(around, at.z * 0.45).length() - 2.8
        };
        let process = capsule(at, vec3(10.0, -6.0, 0.0), vec3(wide, -1.0, 0.0), 4.0);
        let spinous =
            flat_capsule(at, vec3(0.0, 10.0, -1.0), vec3(0.0, 10.0 + spine, -6.0), 2.3, vec3(1.1, 1.0, 2.2));
        let solid = union(union(body, ring, 3.0), union(process, spinous, 2.0), 3.0);
        d = d.min(solid);
    }
    // The dens, round which the head turns.
    d.min(capsule(m, vec3(0.0, 5.5, -60.0), vec3(0.0, 4.0, -38.0), 4.5))
}
