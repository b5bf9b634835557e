//! Twenty-eight teeth, set along the dental arch; the upper bite over the lower.

use glam::{Vec2, Vec3, vec2, vec3};

use super::super::distance::{cone, mirrored, rounded_box, union};
use super::face::ARCH;

/// Width along the arch, depth across it, height of the crown, in millimetres: from the inner incisor to the second
/// molar.
const UPPER: [[f32; 3]; 7] = [
    [8.6, 6.0, 10.5],
    [6.8, 5.8, 9.4],
    [7.7, 7.2, 10.0],
    [7.0, 8.6, 8.2],
    [6.8, 8.8, 7.6],
    [10.2, 10.6, 7.2],
    [9.6, 10.6, 6.8],
];
const LOWER: [[f32; 3]; 7] = [
    [5.6, 5.4, 9.0],
    [6.1, 5.8, 9.2],
    [7.0, 7.0, 10.2],
    [7.0, 7.6, 8.6],
    [7.2, 8.0, 8.0],
    [11.0, 10.0, 7.4],
    [10.4, 9.8, 7.0],
];

/// Height of the plane in which the teeth meet.
const BITE: f32 = -53.0;

/// The point of an arch with half axes `a`, `b` at arc length `s` from its front, and the direction along it.
fn on_arch(a: f32, b: f32, y: f32, s: f32) -> (Vec2, Vec2) {
    // Steps of half a millimetre; the teeth are placed only once.
    let mut at = vec2(0.0, -b);
    let mut along = vec2(1.0, 0.0);
    let steps = (s * 2.0).ceil().max(1.0);
    let step = s / steps;
    for _ in 0..steps as usize {
        at += along * step;
        // Back onto the ellipse.
        at /= (at / vec2(a, b)).length();
        let normal = (at / vec2(a * a, b * b)).normalize();
        along = vec2(-normal.y, normal.x);
    }
    (at + vec2(0.0, y), along)
}

/// A placed tooth.
#[derive(Clone, Copy)]
struct Tooth {
    at: Vec2,
    along: Vec2,
    half: Vec3,
    crown: f32,
    /// 1 for the upper, whose roots point up, −1 for the lower.
    root: f32,
    /// How far the edge reaches beyond the plane of the bite.
    overlap: f32,
    molar: bool,
}

fn placed() -> [Tooth; 14] {
    let [a, b, y] = ARCH;
    let rows = [(UPPER, a, b, y, 1.0), (LOWER, a - 1.6, b - 3.0, y + 0.5, -1.0)];
    let mut teeth = Vec::with_capacity(14);
    for (row, a, b, y, root) in rows {
        let mut s = 0.0;
        for (i, [width, depth, height]) in row.into_iter().enumerate() {
            let (at, along) = on_arch(a, b, y, s + width / 2.0);
            s += width;
            let half = vec3(width / 2.0 - 0.25, depth / 2.0, height / 2.0);
            let molar = i > 2;
            // The upper incisors close in front of the lower ones.
            let overlap = if molar { -0.3 } else { 0.5 + root };
            teeth.push(Tooth { at, along, half, crown: height, root, overlap, molar });
        }
    }
    teeth.try_into().unwrap_or_else(|_| unreachable!("two rows of seven"))
}

/// All teeth: crowns and roots.
pub(super) fn teeth(p: Vec3) -> f32 {
    static PLACED: std::sync::LazyLock<[Tooth; 14]> = std::sync::LazyLock::new(placed);
    let m = mirrored(p);
    // Beyond this box the distance to the box is enough.
    let (min, max) = (vec3(-2.0, -102.0, -76.0), vec3(38.0, -30.0, -28.0));
    let away = (min - m).max(m - max).max(Vec3::ZERO).length();
    if away > 6.0 {
        return away;
    }
    let mut d = f32::INFINITY;
    for tooth in PLACED.iter() {
        let flat = m.truncate() - tooth.at;
        if flat.length_squared() > (d.min(40.0) + 9.0).powi(2) {
            continue;
        }
        // Local frame: along the arch, outwards, from the biting edge to the root.
        let out = vec2(tooth.along.y, -tooth.along.x);
        let q = vec3(flat.dot(tooth.along), flat.dot(out), tooth.root * (m.z - BITE) + tooth.overlap);
        // Incisors narrow to an edge, molars do not.
        let share = (q.z / tooth.crown).clamp(0.0, 1.0);
        let depth = if tooth.molar { 0.86 + 0.14 * share } else { 0.38 + 0.62 * share };
        let width = 1.0 - 0.16 * share;
        let squeezed = vec3(q.x / width, q.y / depth, q.z - tooth.half.z);
        let crown = rounded_box(squeezed, tooth.half, 1.5) * 0.8;
        let root = cone(
            q,
            vec3(0.0, 0.0, tooth.crown - 2.0),
            vec3(0.0, -1.0, tooth.crown + 9.0),
            tooth.half.x * 0.72,
            1.2,
        );
        d = d.min(union(crown, root, 1.5));
    }
    d.min(46.0)
}
