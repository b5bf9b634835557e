//! A human head as a CT scanner would see it, made of some two hundred smooth solids.
//!
//! The frame is the anatomist's: millimetres, x to the left, y backwards, z up, the origin midway between the ear
//! canals, z = 0 the Frankfurt plane (through the ear canals and the lower rims of the orbits). Proportions are those
//! of the mean adult of the anthropometric tables: 228 mm from chin to vertex, 195 mm from glabella to occiput, 155 mm
//! wide, pupils half way up. Values are Hounsfield-like: air −1000, fat −90, soft tissue 40, spongy bone
//! 550, compact bone 1250, enamel 2200. The brain's contrast is raised (fluid 0, white matter 85, grey matter 125), so
//! that it can be told from what surrounds it without a window of a few units.

mod brain;
mod face;
mod skin;
mod skull;
mod teeth;

use glam::{Vec3, vec3};

use super::distance::{ball, capsule, cone, ellipsoid, intersection, mirrored, union};
use super::paint::{Grid, Layer, Noise, paint};
use crate::affine::Space;
use crate::samples::Sample;
use crate::volume::Volume;

/// Values of the tissues, Hounsfield units but for the brain's.
pub(super) mod tissue {
    pub(in crate::phantom) const AIR: f32 = -1000.0;
    pub(in crate::phantom) const FAT: f32 = -90.0;
    pub(in crate::phantom) const SOFT: f32 = 40.0;
    pub(in crate::phantom) const FLUID: f32 = 0.0;
    pub(in crate::phantom) const WHITE: f32 = 85.0;
    pub(in crate::phantom) const GREY: f32 = 125.0;
    pub(in crate::phantom) const SPONGY: f32 = 550.0;
    pub(in crate::phantom) const COMPACT: f32 = 1250.0;
    pub(in crate::phantom) const ENAMEL: f32 = 2200.0;
}

/// Corners of the scanned box: the neck ends 7 mm above its floor, so that every surface is closed.
const BOX: [Vec3; 2] = [vec3(-94.0, -134.0, -154.0), vec3(94.0, 107.0, 132.0)];

/// Thickness of compact bone, millimetres: the tables of the vault, the shell of the jaw.
const TABLE: f32 = 2.0;

/// Sides that [`head`] accepts, voxels.
const SIZES: [usize; 2] = [16, 1024];

/// A CT of a human head in Hounsfield-like values, `int16`, in the patient's space; `size` voxels from below the chin
/// to above the vertex (clamped to 16 … 1024; 286 mm, so that 256 gives voxels of 1.1 mm in a 169 × 216 × 256 grid),
/// with Gaussian noise of standard deviation `noise` (values; what is not finite or negative counts as 0) drawn with
/// `seed`.
///
/// There are skin with nose, lips, ears and closed eyes, a skull with sutures, sinuses, orbits, jaw and 28 teeth,
/// cervical vertebrae, airways, a folded brain with cerebellum, stem and ventricles. Halfway between air and soft
/// tissue, −480, is the skin; 600 is bone.
pub fn head(size: usize, noise: f32, seed: u32) -> Volume {
    let grid = grid(size);
    let sigma = if noise.is_finite() { noise.max(0.0) } else { 0.0 };
    grid.volume(i16::wrap(paint(&grid, tissue::AIR, &layers(), Noise { sigma, seed })))
}

fn grid(size: usize) -> Grid {
    Grid::within(BOX[0], BOX[1], size.clamp(SIZES[0], SIZES[1]), Space::Patient)
}

/// The tissues in the order in which they are painted.
fn layers() -> [Layer<'static>; 15] {
    let layer = |value, solid| Layer { value, solid, core: None };
    let cored = |value, solid, depth, core| Layer { value, solid, core: Some((depth, core)) };
    [
        layer(tissue::SOFT, &skin::skin),
        layer(tissue::FLUID, &|p| union(skull::cavity(p), spinal_canal(p), 4.0)),
        cored(tissue::GREY, &brain::cerebrum, brain::CORTEX, tissue::WHITE),
        cored(tissue::GREY, &brain::cerebellum, 2.5, tissue::WHITE),
        layer(tissue::WHITE, &brain::stem),
        layer(tissue::GREY, &brain::ganglia),
        layer(tissue::FLUID, &brain::ventricles),
        cored(tissue::COMPACT, &skull::bone, TABLE, tissue::SPONGY),
        layer(tissue::ENAMEL, &teeth::teeth),
        layer(tissue::AIR, &airways),
        layer(tissue::SOFT, &turbinates),
        layer(tissue::FAT, &orbital_fat),
        layer(tissue::SOFT, &eyes),
        layer(tissue::GREY, &|p| ellipsoid(mirrored(p) - vec3(31.5, -83.0, 12.0), vec3(4.5, 2.5, 4.5))),
        layer(tissue::WHITE, &|p| capsule(p, vec3(0.0, 16.0, -28.0), vec3(0.0, 29.0, -134.0), 4.5)),
    ]
}

/// What holds the spinal cord, below the foramen magnum.
fn spinal_canal(p: Vec3) -> f32 {
    capsule(p, vec3(0.0, 18.0, -26.0), vec3(0.0, 29.0, -134.0), 7.5)
}

/// What fills the orbits, behind the lids.
fn orbital_fat(p: Vec3) -> f32 {
    let orbit = face::orbit(mirrored(p)) + 1.0;
    // Far from the orbits, even for the coarsest voxels, the skin does not matter.
    if orbit > 24.0 { orbit } else { intersection(orbit, skin::skin(p) + 4.0, 2.0) }
}

/// Eyeballs, their muscles and the optic nerves.
fn eyes(p: Vec3) -> f32 {
    let m = mirrored(p);
    let eyeball = ball(m - face::EYE, 12.0);
    let apex = vec3(15.0, -40.0, 17.0);
    let nerve = capsule(m, vec3(30.0, -62.0, 13.0), apex, 2.2);
    let muscles =
        [vec3(43.0, -66.0, 13.0), vec3(20.5, -66.0, 13.0), vec3(31.0, -64.0, 25.0), vec3(31.0, -64.0, 2.0)];
    muscles.into_iter().fold(eyeball.min(nerve), |d, from| d.min(capsule(m, from, apex, 1.8)))
}

/// Nasal cavity and sinuses, throat, windpipe and ear canals.
fn airways(p: Vec3) -> f32 {
    let m = mirrored(p);
    // Two high, narrow chambers beside the septum, wider below.
    let width = 5.5 - 0.09 * (p.z + 25.0).clamp(0.0, 40.0);
    let chamber =
        ellipsoid((m - vec3(2.0 + width, -70.0, -10.0)) / vec3(width / 5.5, 1.0, 1.0), vec3(5.5, 34.0, 23.0));
    let nostril = cone(m, vec3(6.8, -110.0, -33.0), vec3(6.0, -97.0, -22.0), 3.6, 3.4);
    let throat = cone(p, vec3(0.0, -34.0, -14.0), vec3(0.0, -14.0, -52.0), 8.0, 8.0);
    let pharynx = cone(p / vec3(1.3, 1.0, 1.0), vec3(0.0, -14.0, -50.0), vec3(0.0, -9.0, -112.0), 6.5, 5.0);
    let windpipe = capsule(p, vec3(0.0, -16.0, -108.0), vec3(0.0, -12.0, -134.0), 8.0);
    let canal = cone(m, vec3(73.0, 6.0, -1.0), vec3(46.0, -1.0, 2.0), 3.6, 3.0);
    let way = union(union(chamber, nostril, 3.0), union(throat, pharynx, 6.0), 3.0);
    union(way, windpipe, 5.0).min(canal).min(face::sinuses(m))
}

/// The turbinates: three soft folds in each half of the nose.
fn turbinates(p: Vec3) -> f32 {
    let m = mirrored(p);
    let fold = |z: f32, x: f32, front: f32, radius: f32| {
        capsule(m, vec3(x, front, z), vec3(x - 1.0, -45.0, z - 2.0), radius)
    };
    fold(-21.0, 9.0, -88.0, 3.6).min(fold(-8.0, 8.0, -82.0, 2.9)).min(fold(4.0, 6.0, -76.0, 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phantom::paint::tests::paint_slowly;
    use crate::samples::Samples;

    /// The value of the voxel nearest to a point.
    fn at(volume: &Volume, p: Vec3) -> f32 {
        let index = (p.as_dvec3() - volume.affine().origin) / volume.spacing()[0];
        let [x, y, z] = index.to_array().map(|i| i.round() as usize);
        volume.value_at(x, y, z) as f32
    }

    fn samples(volume: &Volume) -> &[i16] {
        match volume.samples() {
            Samples::I16(samples) => samples,
            other => panic!("{}", other.sample_type()),
        }
    }

    #[test]
    fn blocks_change_nothing() {
        for size in [56, 90] {
            let grid = grid(size);
            let slow = paint_slowly(&grid, tissue::AIR, &layers());
            let fast = head(size, 0.0, 0);
            let differ = samples(&fast).iter().zip(&slow).filter(|(a, b)| a != b).count();
            // A layer that covers a block adds no rounding of its own.
            assert!(differ * 2000 < slow.len(), "{differ} of {} at {size}", slow.len());
            // The distance to a fold of the brain is a rough estimate: a few tips of folds are lost.
            let off = samples(&fast).iter().zip(&slow).map(|(a, b)| (a - b).abs());
            let lost = off.clone().filter(|&d| d > 1).count();
            assert!(lost * 50_000 < slow.len() && off.max() < Some(13), "{lost} lost at {size}");
        }
    }

    #[test]
    fn each_tissue_lies_where_it_belongs() {
        let head = head(200, 0.0, 0);
        let expect = [
            ("air before the face", vec3(0.0, -131.0, 60.0), tissue::AIR),
            ("scalp", vec3(0.0, 20.0, 122.5), tissue::SOFT),
            ("vault, spongy", vec3(0.0, -88.5, 60.0), tissue::SPONGY),
            ("fluid in the lateral ventricle", vec3(14.0, 14.0, 45.0), tissue::FLUID),
            ("white matter", vec3(30.0, 10.0, 62.0), tissue::WHITE),
            ("thalamus", vec3(11.0, 6.0, 31.0), tissue::GREY),
            ("eyeball", vec3(-31.5, -74.0, 12.0), tissue::SOFT),
            ("behind the eye", vec3(26.0, -56.0, 20.0), tissue::FAT),
            ("maxillary sinus", vec3(28.0, -64.0, -16.0), tissue::AIR),
            ("sphenoid sinus", vec3(7.0, -27.0, 4.0), tissue::AIR),
            ("windpipe", vec3(0.0, -14.0, -128.0), tissue::AIR),
            ("tongue", vec3(0.0, -55.0, -55.0), tissue::SOFT),
            ("first molar", vec3(25.6, -64.0, -49.5), tissue::ENAMEL),
            ("body of a vertebra", vec3(0.0, 9.0, -80.0), tissue::SPONGY),
            ("spinal cord", vec3(0.0, 23.0, -84.0), tissue::WHITE),
            ("branch of the jaw", vec3(47.5, -22.0, -45.0), tissue::SPONGY),
        ];
        for (name, p, value) in expect {
            let found = at(&head, p);
            // Thin solids reach their value but for a share.
            assert!((found - value).abs() <= 12.0 + 0.12 * value.abs(), "{name}: {found} and not {value}");
        }
        // Two tables of compact bone with spongy bone between, along a ray through the forehead.
        let ray: Vec<f32> = (0..24).map(|i| at(&head, vec3(0.0, -99.0 + i as f32, 60.0))).collect();
        let peaks = (1..23).filter(|&i| ray[i] > 700.0 && ray[i] >= ray[i - 1] && ray[i] > ray[i + 1]);
        assert_eq!(peaks.count(), 2, "{ray:?}");
    }

    #[test]
    fn the_face_is_symmetric() {
        let head = head(110, 0.0, 0);
        let [nx, ny, nz] = head.dims();
        let below_brain = ((-60.0 - BOX[0].z) / head.spacing()[0] as f32) as usize;
        let mut bone = 0;
        for (z, y, x) in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx / 2).map(move |x| (z, y, x))))
        {
            let (a, b) = (head.value_at(x, y, z), head.value_at(nx - 1 - x, y, z));
            if z < below_brain {
                assert!((a - b).abs() <= 2.0, "{a} and {b} at {x} {y} {z}");
            }
            bone += usize::from(a > 600.0);
        }
        assert!(bone > 1000);
    }

    #[test]
    fn proportions_are_those_of_a_head() {
        let volume = head(128, 0.0, 0);
        let skin = |p: Vec3| at(&volume, p) > -480.0;
        let reach =
            |from: Vec3, step: Vec3| (0..300).find(|&i| !skin(from + step * i as f32)).unwrap() as f32;
        let middle = vec3(0.0, 0.0, 45.0);
        let height = 45.0 + reach(middle, Vec3::Z * 0.4) * 0.4 - 45.0;
        let chin = (0..400).map(|i| -60.0 - 0.2 * i as f32).find(|&z| !skin(vec3(0.0, -88.0, z))).unwrap();
        let height = 45.0 + height - chin;
        let width = (reach(middle + Vec3::Y * 15.0, Vec3::X * 0.3)
            + reach(middle + Vec3::Y * 15.0, Vec3::NEG_X * 0.3))
            * 0.3;
        let depth = (reach(middle, Vec3::Y * 0.35) + reach(middle, Vec3::NEG_Y * 0.35)) * 0.35;
        assert!((width / height - 0.68).abs() < 0.03, "{width} wide, {height} high");
        assert!((depth / height - 0.85).abs() < 0.04, "{depth} deep, {height} high");
        // Half way up.
        let eyes = (face::EYE.z - chin) / height;
        assert!((eyes - 0.5).abs() < 0.03, "eyes at {eyes}");
    }

    #[test]
    fn surfaces_are_closed_and_no_bone_is_bare() {
        let volume = head(100, 0.0, 0);
        let [nx, ny, nz] = volume.dims();
        let mut outside = 0;
        for i in 0..nx * ny * nz {
            let [x, y, z] = [i % nx, i / nx % ny, i / nx / ny];
            if x * y * z == 0 || x + 1 == nx || y + 1 == ny || z + 1 == nz {
                assert_eq!(volume.value_at(x, y, z), f64::from(tissue::AIR), "at {x} {y} {z}");
            }
            let p = volume.affine().point([x, y, z].map(|i| i as f64)).as_vec3();
            if skin::skin(p) > 0.0 {
                outside += 1;
                let bare = skull::bone(p).min(teeth::teeth(p));
                assert!(bare > 0.8, "bone {bare} from air at {p}");
            }
        }
        assert!(outside * 3 > nx * ny * nz);
    }

    #[test]
    fn tissues_are_apart_in_the_histogram() {
        let volume = head(160, 0.0, 0);
        let all = samples(&volume);
        let share = |from: f32, to: f32| {
            all.iter().filter(|&&v| (from..to).contains(&f32::from(v))).count() as f32 / all.len() as f32
        };
        let around = |value: f32| share(value - 10.0, value + 10.0);
        // Peaks against the valleys between them, for windows of the same width.
        for (low, high) in [(tissue::AIR, tissue::SOFT), (tissue::SOFT, tissue::SPONGY)] {
            let valley = around((low + high) / 2.0);
            assert!(around(low).min(around(high)) > 3.0 * valley, "{low} … {high}: {valley}");
        }
        for value in [tissue::FLUID, tissue::WHITE, tissue::GREY] {
            assert!(around(value) > 0.004, "{value}: {}", around(value));
        }
        assert!(share(1900.0, 2300.0) > 1e-4);
    }

    #[test]
    fn threads_change_nothing_and_noise_is_as_asked() {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| head(64, 25.0, 7))
        };
        let one = with(1);
        assert!(one == with(3));
        let clean = head(64, 0.0, 7);
        let n = samples(&one).len() as f64;
        let off = samples(&one).iter().zip(samples(&clean)).map(|(a, b)| f64::from(a - b));
        let variance = off.map(|d| d * d).sum::<f64>() / n;
        assert!((variance.sqrt() - 25.0).abs() < 0.3, "{}", variance.sqrt());
        assert!(one != head(64, 25.0, 8));
        assert!(clean == head(64, f32::NAN, 3));
    }

    #[test]
    fn sizes_are_clamped() {
        assert_eq!(head(0, 0.0, 0).dims()[2], 16);
        let head = head(70, 0.0, 0);
        assert_eq!(head.dims()[2], 70);
        assert_eq!(head.affine().space, Space::Patient);
    }
}
