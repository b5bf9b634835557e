//! The outer form: scalp, face, ears and neck.

use glam::{Vec3, vec2, vec3};

use super::super::distance::{
    ball, capsule, cone, ellipsoid, intersection, mirrored, smoothstep, union, union_in_box, without,
    without_in_box,
};
use super::{face, skull};

/// Thickness of the scalp, millimetres.
const SCALP: f32 = 6.0;

/// The plane in which the neck ends, millimetres.
pub(super) const NECK_END: f32 = -147.0;

/// The whole body of soft tissue and what lies in it.
pub(super) fn skin(p: Vec3) -> f32 {
    let m = mirrored(p);
    let mut d = skull::braincase(p) - SCALP;
    d = union(d, neck(m), 22.0);
    d = union_in_box(d, m, vec3(-2.0, -128.0, -112.0), vec3(76.0, 10.0, 50.0), 12.0, visage);
    d = union_in_box(d, m, vec3(58.0, -14.0, -46.0), vec3(96.0, 44.0, 44.0), 5.0, ear);
    without_in_box(d, m, vec3(66.0, -4.0, -16.0), vec3(90.0, 16.0, 14.0), 3.0, ear_bowl)
}

/// Neck with its slanting muscles and the larynx.
fn neck(m: Vec3) -> f32 {
    let column = {
        let q = m / vec3(1.0, 1.06, 1.0);
        cone(q, vec3(0.0, 14.0, -30.0), vec3(0.0, 22.0, -190.0), 50.0, 56.0)
    };
    let muscle = cone(m, vec3(58.0, 16.0, -24.0), vec3(20.0, -30.0, -160.0), 11.0, 12.0);
    let nape = cone(m, vec3(16.0, 46.0, -20.0), vec3(22.0, 52.0, -190.0), 20.0, 28.0);
    let larynx = cone(m, vec3(0.0, -32.0, -116.0), vec3(0.0, -30.0, -150.0), 8.0, 12.0);
    let d = union(union(column, muscle, 10.0), union(nape, larynx, 10.0), 16.0);
    intersection(d, NECK_END - m.z, 3.0)
}

/// The face: what stands before and below the braincase.
fn visage(m: Vec3) -> f32 {
    let middle = ellipsoid(m - vec3(0.0, -48.0, -14.0), vec3(63.0, 47.0, 58.0));
    let lower = ellipsoid(m - vec3(0.0, -48.0, -56.0), vec3(44.0, 47.0, 44.0));
    let cheekbone = ellipsoid(m - vec3(46.0, -66.0, -8.0), vec3(19.0, 16.0, 15.0));
    let jaw = cone(m, vec3(10.0, -80.0, -86.0), vec3(43.0, -16.0, -62.0), 14.5, 11.0);
    let masseter = ellipsoid(m - vec3(48.0, -27.0, -34.0), vec3(13.0, 21.0, 34.0));
    let cheek = ellipsoid(m - vec3(27.0, -71.0, -32.0), vec3(20.0, 21.0, 25.0));
    let chin = ellipsoid(m - vec3(0.0, -87.0, -90.0), vec3(16.0, 15.5, 14.0));
    let muzzle = ellipsoid(m - vec3(0.0, -78.0, -50.0), vec3(32.0, 27.0, 27.0));
    let brow = cone(m, vec3(0.0, -87.5, 30.0), vec3(43.0, -75.0, 31.0), 10.5, 9.0);

    let mut d = union(middle, lower, 26.0);
    d = union(d, union(cheekbone, cheek, 14.0), 14.0);
    d = union(d, union(jaw, masseter, 14.0), 14.0);
    d = union(d, brow, 20.0);
    d = union(d, ellipsoid(m - vec3(48.0, -42.0, 20.0), vec3(14.5, 28.0, 32.0)), 24.0);
    // Nowhere is bone bare.
    d = union_in_box(d, m, face::BOX[0], face::BOX[1], 14.0, |m| face::upper(m) - 2.5);
    d = union_in_box(d, m, face::JAW_BOX[0], face::JAW_BOX[1], 14.0, |m| face::jaw(m) - 3.5);
    d = union(d, muzzle, 14.0);
    d = union(d, chin, 12.0);
    // The fold between lip and chin.
    d = without(d, capsule(m, vec3(0.0, -108.5, -72.5), vec3(16.0, -103.0, -72.0), 4.5), 12.0);
    d = union_in_box(d, m, vec3(-2.0, -120.0, -66.0), vec3(30.0, -84.0, -36.0), 4.0, lips);
    d = union_in_box(d, m, vec3(-2.0, -127.0, -40.0), vec3(24.0, -80.0, 34.0), 8.0, nose);
    d = eyes(d, m);
    without_in_box(d, m, vec3(-2.0, -124.0, -44.0), vec3(16.0, -90.0, -20.0), 2.0, |m| {
        cone(m, vec3(6.8, -111.0, -35.0), vec3(6.4, -108.0, -26.0), 3.8, 2.6)
    })
}

/// The sockets of the eyes, the lids over the eyeballs, the line between the lids.
fn eyes(d: f32, m: Vec3) -> f32 {
    let (min, max) = (vec3(6.0, -112.0, -12.0), vec3(58.0, -60.0, 36.0));
    let d = without_in_box(d, m, min, max, 12.0, |m| {
        let outer = ellipsoid(m - vec3(33.0, -97.0, 11.0), vec3(17.0, 14.5, 11.5));
        let inner = ball(m - vec3(16.0, -99.5, 13.0), 7.5);
        union(outer, inner, 8.0)
    });
    union_in_box(d, m, min, max, 4.0, |m| {
        let lids = ball(m - face::EYE, 14.2);
        // The upper lid lies over the lower one along a shallow arc.
        let line = m.z - (8.0 + 0.012 * (m.x - 31.5).powi(2));
        let upper = intersection(ball(m - face::EYE, 15.2), -line, 0.8);
        let slit = vec2(line, ball(m - face::EYE, 14.8)).length() - 1.2;
        let slit = slit.max((m.x - 32.0).abs() - 15.0);
        // The fold above the lid.
        let fold =
            vec2(m.z - (20.0 - 0.016 * (m.x - 31.0).powi(2)), ball(m - face::EYE, 15.8)).length() - 1.0;
        without(without(union(lids, upper, 1.0), slit, 1.0), fold, 1.5)
    })
}

/// Two lips on the curve of the teeth, the line between them, the groove below the nose.
fn lips(m: Vec3) -> f32 {
    // The mouth bends backwards to its corners.
    let q = m + vec3(0.0, -0.011 * m.x * m.x, 0.0);
    let bow = 1.6 * smoothstep(0.0, 6.0, m.x) - 0.007 * m.x * m.x;
    let upper = ellipsoid(q - vec3(0.0, -103.0, -48.5 + bow), vec3(24.0, 6.8, 5.2));
    let lower = ellipsoid(q - vec3(0.0, -101.8, -58.3), vec3(20.0, 7.2, 5.8));
    let line = vec2(q.z - (-53.2 - 0.4 * smoothstep(0.0, 6.0, m.x) + 0.003 * m.x * m.x), (q.y + 110.0) * 0.8)
        .length()
        - 1.4;
    let line = line.max(m.x - 25.0);
    let groove = capsule(q, vec3(0.0, -112.8, -34.0), vec3(0.0, -112.5, -44.0), 2.6);
    let d = union(upper, lower, 1.6);
    // The line reaches in as far as the lips stand out.
    let line = line.min(cone(q, vec3(0.0, -109.5, -53.2), vec3(24.0, -108.0, -52.2), 2.0, 1.0));
    without(without(d, line, 1.6), groove, 2.5)
}

/// Bridge, tip, wings and the pillar between the nostrils.
fn nose(m: Vec3) -> f32 {
    let bridge = cone(m, vec3(0.0, -89.0, 26.0), vec3(0.0, -111.0, -14.0), 8.0, 7.0);
    let flank = cone(m, vec3(7.5, -87.0, 16.0), vec3(10.5, -99.0, -20.0), 6.5, 8.0);
    let tip = ellipsoid(m - vec3(0.0, -115.5, -20.0), vec3(8.5, 8.5, 7.5));
    let wing = ellipsoid(m - vec3(11.5, -104.5, -25.0), vec3(6.4, 10.0, 6.6));
    let pillar = cone(m, vec3(0.0, -116.0, -25.0), vec3(0.0, -102.0, -33.0), 4.0, 4.5);
    let d = union(bridge, flank, 9.0);
    let d = union(d, tip, 9.0);
    union(union(d, wing, 5.0), pillar, 4.0)
}

/// The frame of an ear: u backwards, v up, w outwards, from its middle.
fn in_ear(m: Vec3) -> Vec3 {
    let q = m - vec3(76.0, 15.0, 0.0);
    // Turned 22° outwards about z, leaning 12° backwards.
    let (u, w) = (0.927 * q.y + 0.375 * q.x, 0.927 * q.x - 0.375 * q.y);
    vec3(0.978 * u - 0.208 * q.z, 0.978 * q.z + 0.208 * u, w)
}

/// The ear: a plate with a rolled rim, an inner ridge, the tragus and the lobe.
fn ear(m: Vec3) -> f32 {
    let q = in_ear(m);
    // Narrower below.
    let squeeze = 1.0 - 0.22 * smoothstep(0.0, -32.0, q.y);
    let e = vec3(q.x / squeeze, q.y, q.z);
    let flat = e.truncate();
    let oval = |a: f32, b: f32| {
        let k = (flat / vec2(a, b)).length();
        let slope = (flat / vec2(a * a, b * b)).length().max(1e-6);
        (k * (k - 1.0) / slope).max(-a)
    };
    // The plate bends outwards to its rim.
    let bend = e.z - 0.010 * flat.length_squared() * 0.5;
    let plate = vec2(oval(16.0, 30.0).max(0.0), bend.abs()).length() - 2.0;
    let rim = {
        let ring = vec2(oval(16.5, 30.5), bend - 1.6).length() - 2.5;
        // It ends at the lobe.
        intersection(ring, -(e.y + 22.0) * 0.6, 6.0)
    };
    let antihelix = {
        let ring = vec2(oval(10.5, 20.0), bend - 1.2).length() - 2.0;
        intersection(ring, (-e.x).max(e.y.abs() - 17.0) * 0.6, 4.0)
    };
    let lobe = ellipsoid(q - vec3(-6.0, -25.0, -0.5), vec3(8.5, 9.5, 4.6));
    let tragus = ellipsoid(q - vec3(-12.5, -6.0, 2.2), vec3(3.4, 5.2, 3.4));
    let antitragus = ellipsoid(q - vec3(-2.0, -17.0, 2.6), vec3(5.0, 3.2, 2.8));
    // Its root on the head.
    let root = cone(m, vec3(66.0, 6.0, 10.0), vec3(70.0, 5.0, -20.0), 9.0, 5.0);
    let d = union(plate, rim, 1.5);
    let d = union(d, antihelix, 2.0);
    let d = union(d, union(lobe, antitragus, 3.0), 3.0);
    union(union(d, tragus, 2.0), root, 6.0)
}

/// The hollow before the ear canal.
fn ear_bowl(m: Vec3) -> f32 {
    ellipsoid(in_ear(m) - vec3(-4.5, -4.0, 4.2), vec3(7.5, 11.0, 7.0))
}
