//! Phantoms whose surfaces are known in closed form, and one like a machine part.

use glam::{Quat, Vec3, vec3};

use super::distance::{ball, cylinder, rounded_box, union, without};
use super::paint::{Grid, Layer, Noise, paint};
use crate::affine::Space;
use crate::samples::Sample;
use crate::volume::Volume;

/// Radii of the spheres of [`shells`] in millimetres, from the outermost, and the value of what lies within each.
pub const SHELLS: [(f32, f32); 4] = [(56.0, 250.0), (42.0, 500.0), (28.0, 750.0), (14.0, 1000.0)];

/// Half the sides of [`box_phantom`], millimetres.
pub const BOX_HALF: [f32; 3] = [24.0, 16.0, 10.0];

/// The normal of [`plane`], pointing out of the matter: along no axis and no diagonal.
pub const PLANE_NORMAL: [f32; 3] = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];

fn layer<'a>(value: f32, solid: super::paint::Distance<'a>) -> Layer<'a> {
    Layer { value, solid, core: None }
}

/// A cube of `size`³ voxels of 1 mm about the origin.
fn cube(size: usize) -> Grid {
    let half = Vec3::splat(size as f32 / 2.0);
    Grid::within(-half, half, size, Space::Unknown)
}

/// Concentric spheres about the origin, [`SHELLS`], in 128³ voxels of 1 mm, `int16`; 0 outside.
pub fn shells() -> Volume {
    let grid = cube(128);
    let spheres = SHELLS.map(|(radius, value)| (move |p: Vec3| ball(p, radius), value));
    let layers = spheres.each_ref().map(|(sphere, value)| layer(*value, sphere));
    grid.volume(i16::wrap(paint(&grid, 0.0, &layers, Noise::NONE)))
}

/// A box of half sides [`BOX_HALF`] and value 1000 about the origin, turned by `angle` degrees about (1, 1, 1), in
/// 72³ voxels of 1 mm, `int16`; 0 outside. At 0 its faces lie along the grid; an angle that is not finite counts as 0.
pub fn box_phantom(angle: f32) -> Volume {
    let grid = cube(72);
    let angle = if angle.is_finite() { angle } else { 0.0 };
    let back = Quat::from_axis_angle(Vec3::ONE.normalize(), -angle.to_radians());
    let solid = move |p: Vec3| rounded_box(back * p, Vec3::from_array(BOX_HALF), 0.0);
    grid.volume(i16::wrap(paint(&grid, 0.0, &[layer(1000.0, &solid)], Noise::NONE)))
}

/// The half space below the plane through the origin with the normal [`PLANE_NORMAL`], value 1000, in 64³ voxels of
/// 1 mm, `int16`; 0 above.
pub fn plane() -> Volume {
    let grid = cube(64);
    let solid = |p: Vec3| p.dot(Vec3::from_array(PLANE_NORMAL));
    grid.volume(i16::wrap(paint(&grid, 0.0, &[layer(1000.0, &solid)], Noise::NONE)))
}

/// Where the cylinders of the engine stand, x in millimetres.
const BORES: [f32; 3] = [-44.0, 0.0, 44.0];

/// A machine part as an industrial scanner sees it: a cast block with three bores and their dense sleeves, water
/// jacket, flange with bolt holes, bearings and an inlet pipe, in 256 × 146 × 175 voxels of 0.75 mm, `uint8`: air 0,
/// cast metal 120, steel 220. With `haze` over 0 the scanner adds so much to the air around the part, with noise of a
/// third of it, as in the classic engine scan (20 there).
pub fn engine(haze: f32) -> Volume {
    let grid = Grid::within(vec3(-96.0, -48.0, -60.0), vec3(96.0, 61.5, 71.25), 256, Space::Unknown);
    let haze = if haze.is_finite() { haze.clamp(0.0, 255.0) } else { 0.0 };
    let layers = [layer(120.0, &casting), layer(220.0, &steel)];
    let noise = Noise { sigma: haze / 3.0, seed: 1 };
    grid.volume(u8::wrap(paint(&grid, haze, &layers, noise)))
}

/// The distance in x to the nearest bore's axis, with its sign.
fn from_bore(x: f32) -> f32 {
    BORES.map(|bore| x - bore).into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(x)
}

/// A cylinder about an axis through `at` along y.
fn along_y(p: Vec3, at: Vec3, radius: f32, half: f32) -> f32 {
    let q = p - at;
    cylinder(vec3(q.x, q.z, q.y), radius, half, 0.8)
}

/// A cylinder about an axis through `at` along x.
fn along_x(p: Vec3, at: Vec3, radius: f32, half: f32) -> f32 {
    let q = p - at;
    cylinder(vec3(q.y, q.z, q.x), radius, half, 0.8)
}

fn casting(p: Vec3) -> f32 {
    let q = vec3(from_bore(p.x), p.y, p.z);
    let mirrored = vec3(p.x.abs(), p.y, p.z);
    // Block, deck, sump flange; barrels bulge through the side wall.
    let block = rounded_box(p - vec3(0.0, 0.0, 8.0), vec3(74.0, 31.0, 40.0), 4.0);
    let barrels = cylinder(q - vec3(0.0, -12.0, 8.0), 22.0, 34.0, 3.0);
    let deck = rounded_box(p - vec3(0.0, 0.0, 52.0), vec3(80.0, 37.0, 6.0), 2.0);
    let sump = rounded_box(p - vec3(0.0, 0.0, -42.0), vec3(84.0, 40.0, 5.0), 2.0);
    let skirt = rounded_box(p - vec3(0.0, 0.0, -36.0), vec3(76.0, 33.0, 12.0), 3.0);
    let mut d = union(union(block, barrels, 6.0), union(union(deck, sump, 1.0), skirt, 4.0), 5.0);
    // Inlet pipe behind, with its flange; bearing bosses at both ends; ribs on the side wall.
    let pipe =
        along_y(p, vec3(22.0, 40.0, 26.0), 12.0, 16.0).min(along_y(p, vec3(22.0, 54.0, 26.0), 18.0, 3.0));
    let boss = along_x(mirrored, vec3(78.0, 0.0, -20.0), 19.0, 9.0);
    let rib = rounded_box(vec3(p.x.abs() - 22.0, p.y + 33.0, p.z - 6.0), vec3(2.5, 4.0, 36.0), 1.5);
    d = union(union(d, pipe, 5.0), union(boss, rib, 0.5), 4.0);
    // Bores and the crank's room beneath them.
    d = without(d, cylinder(q - vec3(0.0, 0.0, 20.0), 16.0, 60.0, 0.5), 1.0);
    let room = rounded_box(vec3(q.x, p.y, p.z + 38.0), vec3(18.0, 25.0, 17.0), 6.0);
    d = without(d, room, 2.0);
    // The water jacket between barrels and walls, closed to the deck but for slots.
    let jacket = rounded_box(p - vec3(0.0, 0.0, 16.0), vec3(69.0, 26.0, 24.0), 4.0);
    let jacket = without(jacket, cylinder(q - vec3(0.0, 0.0, 16.0), 20.5, 60.0, 1.0), 2.0);
    d = without(d, jacket, 2.0);
    let slot = cylinder(vec3((p.x.abs() - 22.0).abs(), p.y.abs() - 22.0, p.z - 52.0), 3.2, 20.0, 0.5);
    d = without(d, slot, 0.5);
    // The pipe's bore and the bearings.
    d = without(d, along_y(p, vec3(22.0, 48.0, 26.0), 8.0, 26.0), 1.0);
    d = without(d, along_x(p, vec3(0.0, 0.0, -20.0), 11.0, 120.0), 1.0);
    // Bolt holes: deck, sump flange, pipe flange.
    let pitch = |x: f32, step: f32, last: f32| x - (x / step).round().clamp(-last, last) * step;
    let deck_bolt = cylinder(vec3(pitch(p.x, 36.5, 2.0), p.y.abs() - 31.5, p.z - 54.0), 2.6, 9.0, 0.4);
    let sump_bolt = cylinder(vec3(pitch(p.x, 26.0, 3.0), p.y.abs() - 36.0, p.z + 42.0), 2.4, 12.0, 0.4);
    let pipe_bolt = along_y(vec3((p.x - 22.0).abs(), p.y, p.z - 26.0), vec3(14.6, 54.0, 0.0), 2.0, 8.0);
    without(d, deck_bolt.min(sump_bolt).min(pipe_bolt), 0.4)
}

/// Sleeves in the bores, bearing shells, two bolts left in the deck.
fn steel(p: Vec3) -> f32 {
    let q = vec3(from_bore(p.x), p.y, p.z);
    let tube = |q: Vec3, outer: f32, inner: f32, half: f32| {
        without(cylinder(q, outer, half, 0.4), cylinder(q, inner, half + 20.0, 0.4), 0.3)
    };
    let sleeve = tube(q - vec3(0.0, 0.0, 16.0), 16.4, 13.2, 42.5);
    let bearing = tube(vec3(p.y, p.z + 20.0, p.x.abs() - 78.0), 11.3, 8.4, 9.5);
    let bolt = {
        let q = vec3(p.x.abs() - 73.0, p.y + 31.5, p.z);
        union(
            cylinder(q - vec3(0.0, 0.0, 50.0), 2.6, 14.0, 0.4),
            cylinder(q - vec3(0.0, 0.0, 60.5), 5.0, 3.0, 0.8),
            0.5,
        )
    };
    sleeve.min(bearing).min(bolt)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sample nearest to a point, by value.
    fn at(volume: &Volume, p: Vec3) -> f64 {
        let index = (p.as_dvec3() - volume.affine().origin) / volume.spacing()[0];
        let [x, y, z] = index.to_array().map(|i| i.round() as usize);
        volume.value_at(x, y, z)
    }

    /// The sum of all values over `full` is the measure of a solid, cubic millimetres: boundaries are painted
    /// without bias.
    fn measure(volume: &Volume, full: f64) -> f64 {
        let cell = volume.spacing().iter().product::<f64>();
        (0..volume.samples().len()).map(|i| volume.samples().get(i)).sum::<f64>() / full * cell
    }

    #[test]
    fn shells_have_their_values_and_volumes() {
        let volume = shells();
        let mut expected = 0.0;
        let mut before = 0.0;
        for (i, (radius, value)) in SHELLS.into_iter().enumerate() {
            let within = SHELLS.get(i + 1).map_or(0.0, |next| next.0);
            for axis in Vec3::AXES {
                assert_eq!(at(&volume, axis * (radius + within) / 2.0), f64::from(value));
            }
            expected +=
                4.0 / 3.0 * std::f64::consts::PI * f64::from(radius).powi(3) * f64::from(value - before);
            before = value;
        }
        assert_eq!(volume.value_at(0, 0, 0), 0.0);
        assert!((measure(&volume, 1.0) / expected - 1.0).abs() < 2e-3);
    }

    #[test]
    fn a_turned_box_keeps_its_volume() {
        let volume = 8.0 * BOX_HALF.map(f64::from).iter().product::<f64>();
        for angle in [0.0, 15.0, 44.0, 90.0, -77.0] {
            let share = measure(&box_phantom(angle), 1000.0) / volume;
            // Along edges the mean over a ramp is not the share of a cube.
            assert!((share - 1.0).abs() < 6e-3, "{share} at {angle}");
        }
        assert_eq!(box_phantom(f32::NAN), box_phantom(0.0));
        // 120 degrees about the diagonal carry each axis to the next.
        let (straight, turned) = (box_phantom(0.0), box_phantom(120.0));
        let n = straight.dims()[0];
        let mut seen = 0.0f64;
        for (x, y, z) in [(36, 40, 30), (20, 36, 36), (50, 41, 30), (59, 36, 30), (60, 36, 36)] {
            let (a, b) = (straight.value_at(x, y, z), turned.value_at(z, x, y));
            assert!((a - b).abs() <= 1.0, "{a} and {b}");
            assert!(x < n);
            seen = seen.max(a);
        }
        assert_eq!(seen, 1000.0);
    }

    #[test]
    fn the_plane_is_where_values_are_half() {
        let volume = plane();
        let normal = Vec3::from_array(PLANE_NORMAL);
        assert!((normal.length() - 1.0).abs() < 1e-6);
        let mut near = 0;
        for i in 0..volume.samples().len() {
            let n = 64;
            let p = volume.affine().point([i % n, i / n % n, i / n / n].map(|i| i as f64)).as_vec3();
            let (d, value) = (p.dot(normal), volume.samples().get(i));
            if d.abs() < 0.2 {
                // The slope of the boundary: 1.5/(2 · 1.2) of the step a millimetre.
                assert!((value - (500.0 - 625.0 * f64::from(d))).abs() < 12.0, "{value} at {d}");
                near += 1;
            }
            assert!(d.abs() < 1.2 || value == if d < 0.0 { 1000.0 } else { 0.0 });
        }
        assert!(near > 500);
    }

    #[test]
    fn the_engine_has_metal_steel_and_air() {
        let volume = engine(0.0);
        assert_eq!(volume.dims(), [256, 146, 175]);
        for bore in BORES {
            assert_eq!(at(&volume, vec3(bore, 0.0, 20.0)), 0.0);
            assert!(at(&volume, vec3(bore, 14.8, 20.0)) > 215.0);
            assert_eq!(at(&volume, vec3(bore, 18.4, 20.0)), 120.0);
        }
        let hazy = engine(20.0);
        let corner: Vec<f64> = (0..4000).map(|i| hazy.value_at(i % 20, i / 20 % 10, i / 200)).collect();
        let mean = corner.iter().sum::<f64>() / 4000.0;
        assert!((mean - 20.0).abs() < 0.5, "{mean}");
    }
}
