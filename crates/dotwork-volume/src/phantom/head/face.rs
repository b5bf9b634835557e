//! The bones of the face: orbits, nose, cheekbones, jaws, and the sinuses within. All are given on the left side.

use std::sync::LazyLock;

use glam::{Vec3, vec3};

use super::super::distance::{
    capsule, cone, curve, ellipsoid, flat_capsule, intersection, rounded_box, union, wall, without,
};

/// Where the upper face lies.
pub(super) const BOX: [Vec3; 2] = [vec3(-2.0, -108.0, -50.0), vec3(76.0, 6.0, 46.0)];

/// Where the jaw lies.
pub(super) const JAW_BOX: [Vec3; 2] = [vec3(-2.0, -106.0, -110.0), vec3(66.0, 2.0, 6.0)];

/// Centre of the left eyeball.
pub(super) const EYE: Vec3 = vec3(31.5, -74.0, 12.0);

/// The dental arch from above: `x²/a² + (y − y₀)²/b² = 1`.
pub(super) const ARCH: [f32; 3] = [28.5, 46.0, -46.0];

/// The cone in which the eye lies, from its rim to its apex.
pub(super) fn orbit(m: Vec3) -> f32 {
    // A rounded square in front, a little higher outside than inside.
    let at = vec3(31.0, -82.0, 14.0);
    let q = m - at;
    let q = vec3(q.x * 0.985 + q.z * 0.17, q.y, q.z * 0.985 - q.x * 0.17);
    let depth = (q.y / 43.0).clamp(-0.2, 1.0);
    let axis = vec3(-14.0, 0.0, 4.0) * depth;
    let size = 1.0 - 0.88 * depth.max(0.0);
    let q = q - axis;
    let (x, z) = (q.x / 1.08, q.z * 1.04);
    // A superellipse of exponent 3 between circle and square.
    let around = (x.abs().powi(3) + z.abs().powi(3)).cbrt();
    intersection((around - 17.5 * size) * 0.9, q.y - 43.0, 6.0)
}

/// The frontal sinus, above the inner ends of the brows.
pub(super) fn frontal_sinus(m: Vec3) -> f32 {
    ellipsoid(m - vec3(9.5, -82.5, 36.0), vec3(7.5, 3.4, 8.0))
}

/// Frontal, maxillary, ethmoid and sphenoid sinuses, and the largest air cells of the mastoid.
pub(super) fn sinuses(m: Vec3) -> f32 {
    let maxillary = ellipsoid(m - vec3(28.0, -64.0, -16.0), vec3(10.5, 13.0, 11.5));
    let ethmoid = rounded_box(m - vec3(6.0, -64.0, 15.0), vec3(3.2, 15.0, 6.5), 3.0);
    let sphenoid = ellipsoid(m - vec3(7.0, -27.0, 4.0), vec3(6.0, 10.0, 8.0));
    let cells = ellipsoid(m - vec3(57.0, 14.0, -6.0), vec3(3.0, 4.5, 6.0))
        .min(ellipsoid(m - vec3(55.0, 12.0, -18.0), vec3(2.4, 2.4, 5.0)));
    frontal_sinus(m).min(maxillary).min(ethmoid).min(sphenoid).min(cells)
}

/// What is cut out of the bones: orbits, the nasal aperture and cavity, foramina.
pub(super) fn openings(m: Vec3) -> f32 {
    // A pear: narrow between the nasal bones, wide above the teeth.
    let pear = cone(m, vec3(5.2, -100.0, -20.0), vec3(0.0, -104.0, 0.0), 7.2, 3.4).min(cone(
        m,
        vec3(4.6, -78.0, -18.0),
        vec3(0.0, -80.0, 0.0),
        7.2,
        3.4,
    ));
    let nose = union(pear, ellipsoid(m - vec3(4.0, -80.0, -17.0), vec3(8.5, 34.0, 10.5)), 3.0);
    // The spine below the aperture stays.
    let nose = without(nose, cone(m, vec3(0.0, -88.0, -31.0), vec3(0.0, -101.0, -29.0), 4.0, 1.2), 2.0);
    let infraorbital = capsule(m, vec3(28.0, -95.0, -12.0), vec3(28.0, -74.0, -7.0), 1.9);
    let supraorbital = capsule(m, vec3(25.0, -98.0, 31.0), vec3(25.0, -80.0, 30.0), 1.8);
    // Superior orbital fissure, seen as a dark slit at the back of the orbit.
    let fissure = flat_capsule(m, vec3(18.0, -44.0, 11.0), vec3(23.0, -46.0, 21.0), 1.8, vec3(1.0, 2.0, 1.0));
    orbit(m).min(nose).min(infraorbital).min(supraorbital).min(fissure)
}

/// Forehead's rim, nasal bones, maxilla with palate, cheekbone and its arch.
pub(super) fn upper(m: Vec3) -> f32 {
    // Brow ridge, from the glabella over the orbit to its outer wall.
    let brow = cone(m, vec3(3.0, -86.5, 30.0), vec3(24.0, -83.5, 35.0), 7.5, 6.5).min(cone(
        m,
        vec3(24.0, -83.5, 35.0),
        vec3(47.0, -71.0, 29.0),
        6.5,
        6.0,
    ));
    let lateral = cone(m, vec3(49.5, -71.0, 28.0), vec3(50.0, -70.0, 4.0), 4.8, 6.0);
    let greater_wing =
        flat_capsule(m, vec3(46.0, -60.0, 16.0), vec3(40.0, -40.0, 14.0), 5.0, vec3(1.0, 1.0, 3.2));
    let nasal = cone(m, vec3(3.0, -88.0, 25.0), vec3(3.6, -96.5, 5.0), 5.6, 3.8);
    let frontal_process = cone(m, vec3(8.0, -85.0, 22.0), vec3(14.0, -86.0, -14.0), 4.2, 4.6);
    let nasal = union(nasal, frontal_process, 5.0);
    // The wall between nose and orbit.
    let inner_wall =
        flat_capsule(m, vec3(10.5, -80.0, 26.0), vec3(13.0, -84.0, -6.0), 4.2, vec3(1.0, 1.6, 1.0));
    let ethmoid = rounded_box(m - vec3(0.0, -60.0, 14.0), vec3(13.5, 24.0, 14.0), 5.0);
    // The body of the maxilla, hollowed below the cheekbone.
    let body = ellipsoid(m - vec3(17.0, -66.0, -15.0), vec3(27.0, 25.0, 24.0));
    let canine = cone(m, vec3(17.0, -86.0, -8.0), vec3(17.0, -89.0, -40.0), 6.0, 5.0);
    let fossa = ellipsoid(m - vec3(30.0, -92.0, -21.0), vec3(9.0, 8.0, 10.0));
    let body = without(union(body, canine, 8.0), fossa, 6.0);
    // Cheekbone: its body, the lower rim of the orbit, the root on the maxilla.
    let malar = ellipsoid(m - vec3(46.0, -70.0, -7.0), vec3(12.0, 9.0, 11.5));
    let rim = cone(m, vec3(16.0, -86.0, -5.0), vec3(42.0, -77.0, -4.0), 4.2, 5.0);
    let arch = {
        let bar = |a, b, r| flat_capsule(m, a, b, r, vec3(1.0, 1.0, 1.9));
        let front = bar(vec3(50.0, -67.0, -7.0), vec3(61.5, -44.0, -5.0), 2.7);
        let back = bar(vec3(61.5, -44.0, -5.0), vec3(64.0, -14.0, 1.0), 2.5);
        union(front, back, 3.0).min(bar(vec3(64.0, -14.0, 1.0), vec3(64.0, 2.0, 5.0), 2.8))
    };
    // The tooth-bearing ledge of the maxilla and the palate.
    let [a, b, y] = ARCH;
    let ledge = {
        let q = m - vec3(0.0, y, 0.0);
        let away = ellipsoid(vec3(q.x, q.y, 0.0), vec3(a + 1.0, b + 1.0, b));
        let height = ((m.z + 34.0).abs() - 9.0 + 4.0).max(0.0);
        let ring = glam::vec2(away, height).length() - 6.0;
        intersection(ring, m.y + 44.0, 4.0)
    };
    let palate = {
        let away = ellipsoid(vec3(m.x, m.y - y, 0.0), vec3(a, b, b)) + 2.0;
        intersection(glam::vec2(away.max(0.0), m.z + 30.0).length() - 2.4, m.y + 42.0, 3.0)
    };
    // Thin walls behind the rims.
    let socket = intersection(orbit(m) - 3.0, -(m.y + 69.0 + 0.6 * (30.0 - m.x).max(0.0)), 2.0);
    let mut d = union(union(brow, nasal, 6.0), socket, 3.0);
    d = union(d, union(lateral, greater_wing, 6.0), 7.0);
    d = union(d, union(inner_wall, ethmoid, 4.0), 4.0);
    d = union(d, union(union(body, rim, 6.0), malar, 8.0), 5.0);
    d = union(d, union(ledge, palate, 3.0), 6.0);
    union(d, arch, 5.0)
}

/// The jaw: body with chin, branches, condyles and coronoid processes.
pub(super) fn jaw(m: Vec3) -> f32 {
    const BODY: [Vec3; 7] = [
        vec3(-4.0, -89.5, -82.0),
        vec3(9.0, -88.5, -82.0),
        vec3(18.5, -82.0, -81.5),
        vec3(26.5, -69.0, -80.0),
        vec3(35.0, -51.0, -77.0),
        vec3(40.5, -34.0, -72.0),
        vec3(45.0, -22.0, -68.0),
    ];
    static CURVE: LazyLock<Vec<Vec3>> = LazyLock::new(|| curve(&BODY, 3));
    let body = wall(m, &CURVE, 5.6, 14.5);
    let chin = ellipsoid(m - vec3(0.0, -91.5, -91.0), vec3(11.0, 5.0, 8.5))
        .min(ellipsoid(m - vec3(10.0, -87.0, -93.0), vec3(7.0, 4.5, 4.5)));
    // The branch: a plate that leans back and a little outwards.
    let branch = {
        let foot = m - vec3(47.8, -21.0, -42.0);
        // Leaning 14 degrees about x, 7 about y.
        let q = vec3(
            foot.x * 0.993 - foot.z * 0.122,
            foot.y * 0.970 - foot.z * -0.2419,
            foot.z * 0.970 + foot.y * -0.2419,
        );
        rounded_box(q, vec3(4.0, 16.0, 33.0), 3.6)
    };
    let angle = ellipsoid(m - vec3(44.5, -17.0, -66.0), vec3(4.5, 13.0, 13.0));
    let condyle = ellipsoid(m - vec3(52.0, -12.0, -7.0), vec3(9.0, 4.8, 5.0));
    let neck = cone(m, vec3(52.0, -12.0, -8.0), vec3(51.0, -15.0, -26.0), 4.0, 5.0);
    let coronoid =
        flat_capsule(m, vec3(51.0, -37.0, -12.0), vec3(50.0, -31.0, -32.0), 3.0, vec3(1.0, 2.0, 1.0));
    let notch = ellipsoid(m - vec3(52.0, -24.0, -9.0), vec3(14.0, 8.5, 17.0));
    let branch = without(union(branch, angle, 6.0), notch, 3.0);
    // The tooth-bearing ledge stands on the body, inside its line behind.
    let [a, b, y] = ARCH;
    let ledge = {
        let q = m - vec3(0.0, y + 1.0, 0.0);
        let away = ellipsoid(vec3(q.x, q.y, 0.0), vec3(a - 1.0, b - 2.0, b));
        let height = ((m.z + 68.5).abs() - 9.5 + 4.0).max(0.0);
        intersection(glam::vec2(away, height).length() - 5.6, m.y + 40.0, 4.0)
    };
    let mental = capsule(m, vec3(26.0, -86.0, -80.0), vec3(24.0, -72.0, -82.0), 1.8);
    let front = without(union(union(body, chin, 12.0), ledge, 7.0), mental, 1.5);
    union(union(front, branch, 9.0), union(union(condyle, neck, 4.0), coronoid, 5.0), 4.0)
}
