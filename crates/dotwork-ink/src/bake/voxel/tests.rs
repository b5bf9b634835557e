use std::collections::BTreeSet;

use super::*;

/// A flat sheet of unit voxels, `n` a side.
fn sheet(n: usize, normal: Vec3) -> Voxels {
    let at = |i: usize| Vec3::new((i % n) as f32, (i / n) as f32, 0.0);
    Voxels {
        position: Vectors::collect(n * n, at),
        normal: Vectors::collect(n * n, |_| normal),
        magnitude: vec![1.0; n * n],
        value: vec![1.0; n * n],
        edges: [Vec3::X, Vec3::Y, Vec3::Z],
    }
}

fn bake(voxels: &Voxels, n_max: f32) -> Stock {
    let mut warnings = Warnings::new();
    let stock = voxel(voxels, &VoxelSettings { n_max, seed: 3, ..VoxelSettings::default() }, &mut warnings);
    assert!(warnings.is_empty());
    stock
}

/// Mean and smallest nearest-neighbour distance of the dots with radii from `spacing` on, seen along z, over the
/// hexagonal spacing; away from the sheet's border.
fn evenness(stock: &Stock, side: f32, spacing: f32) -> (f32, f32, usize) {
    let drawn = stock.baked.radius.partition_point(|&r| r >= spacing);
    let at: Vec<Vec2> = (0..drawn).map(|i| stock.position.at(i).truncate()).collect();
    let hexagonal = (2.0 * side * side / (3f32.sqrt() * drawn as f32)).sqrt();
    let (mut mean, mut least, mut counted) = (0.0, f32::MAX, 0);
    for (i, p) in at.iter().enumerate() {
        if p.min_element() < 0.5 || p.max_element() > side - 1.5 {
            continue;
        }
        let others = at.iter().enumerate().filter(|(j, _)| *j != i);
        let d = others.map(|(_, q)| p.distance_squared(*q)).fold(f32::MAX, f32::min).sqrt() / hexagonal;
        (mean, least, counted) = (mean + d, least.min(d), counted + 1);
    }
    (mean / counted as f32, least, drawn)
}

#[test]
fn a_sheet_of_voxels_is_even_where_each_shows_many_dots() {
    let stock = bake(&sheet(12, Vec3::Z), 25.0);
    // White noise has a mean of 0.47. The lists know nothing of each other: few dots a voxel are less even.
    for (count, mean, least) in [(25.0, 0.7, 0.3), (12.0, 0.62, 0.1), (4.0, 0.53, 0.0), (1.0, 0.45, 0.0)] {
        let (found, closest, drawn) = evenness(&stock, 12.0, spacing_of(1.0, count));
        assert_eq!(drawn, 144 * count as usize);
        assert!(found > mean && closest > least, "{count}: {found} {closest}");
    }
}

#[test]
fn a_count_draws_that_many_of_each_voxel() {
    let tilted = Vec3::new(0.2, -0.5, 1.0).normalize();
    let stock = bake(&sheet(5, tilted), 30.0);
    let area = stock.elements.as_ref().unwrap().area[0];
    assert!(area > 1.0);
    for count in [0.4, 0.6, 1.0, 1.49, 1.51, 7.3, 22.0, 30.0, 45.0] {
        let spacing = spacing_of(area, count);
        let mut drawn = [0u32; 25];
        for i in 0..stock.len() {
            drawn[stock.baked.element[i] as usize] += u32::from(stock.baked.radius[i] >= spacing);
        }
        assert!(drawn.iter().all(|d| *d == count.round().min(30.0) as u32), "{count}: {drawn:?}");
    }
}

#[test]
fn the_stock_is_an_order_of_voxels_lists() {
    let voxels = sheet(9, Vec3::ONE.normalize());
    let stock = bake(&voxels, 6.5);
    assert_eq!(stock.len(), 81 * 7);
    assert!(stock.baked.radius.is_sorted_by(|a, b| a >= b));
    assert_eq!(stock.baked.id.iter().collect::<BTreeSet<_>>().len(), stock.len());
    let elements = stock.elements.as_ref().unwrap();
    assert!((stock.baked.area - 81.0 * 0.75 * 3f64.sqrt()).abs() < 1e-2);
    for i in 0..stock.len() {
        let (e, id) = (stock.baked.element[i] as usize, stock.baked.id[i]);
        assert_eq!((id >> 12) as usize, e);
        assert!(id < 1 << 38 && id & RANK_MASK < 7);
        assert_eq!(stock.baked.radius[i], radius(elements.area[e], (id & RANK_MASK) as usize));
        // Between the planes, and within the voxel's reach.
        let off = stock.position.at(i) - voxels.position.at(e);
        let height = off.dot(voxels.normal.at(e));
        assert!(height.abs() <= 0.2501 && (off - height * voxels.normal.at(e)).abs().max_element() <= 0.5001);
    }
    // The first stipples are not those of one corner.
    let first: f32 = stock.position.x[..27].iter().sum::<f32>() / 27.0;
    assert!((first - 4.0).abs() < 1.5, "{first}");
}

#[test]
fn stipples_lie_within_reach() {
    let mut voxels = sheet(6, Vec3::ZERO);
    let random = |i: usize, k: u32| unit(hash2(i as u32, k)) - 0.5;
    let normal = |i: usize| Vec3::new(random(i, 0), random(i, 1), random(i, 2)).normalize();
    voxels.normal = Vectors::collect(36, normal);
    let skewed = [Vec3::X, Vec3::new(0.6, 1.0, 0.0), Vec3::new(0.1, -0.3, 3.0)];
    for edges in [voxels.edges, skewed] {
        for slab in [0.0, 0.5, 4.0] {
            let voxels = Voxels { edges, ..voxels.clone() };
            let settings = VoxelSettings { n_max: 100.0, slab, ..VoxelSettings::default() };
            let stock = voxel(&voxels, &settings, &mut Warnings::new());
            let reach = stock.elements.as_ref().unwrap().reach;
            let away = |i: usize| {
                let center = voxels.position.at(stock.baked.element[i] as usize);
                stock.position.at(i).distance(center)
            };
            let farthest = (0..stock.len()).map(away).fold(0.0, f32::max);
            assert!(farthest <= reach && farthest > 0.4 * reach, "{edges:?} {slab}: {farthest} {reach}");
        }
    }
}

#[test]
fn voxels_keep_their_stipples_whatever_is_beside_them() {
    let (few, many) = (sheet(4, Vec3::Z), sheet(4, Vec3::Z));
    let mut few = few;
    few.normal.z[7] = f32::NAN;
    few.normal.z[9] = 0.5;
    let (few, many) = (bake(&few, 8.0), bake(&many, 8.0));
    assert_eq!((few.len(), many.len()), (14 * 8, 16 * 8));
    let places = |stock: &Stock| -> std::collections::BTreeMap<u64, [u32; 3]> {
        let bits = |i: usize| stock.position.at(i).to_array().map(f32::to_bits);
        (0..stock.len()).map(|i| (stock.baked.id[i], bits(i))).collect()
    };
    let (few, many) = (places(&few), places(&many));
    assert!(few.iter().all(|(id, place)| many[id] == *place));
    assert!(few.keys().all(|id| ![7, 9].contains(&(id >> 12))));
}

#[test]
fn threads_do_not_matter() {
    let voxels = sheet(30, Vec3::new(0.1, 0.5, -0.3).normalize());
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bake(&voxels, 20.0))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn bounds_are_kept_and_said() {
    let voxels = sheet(2, Vec3::Z);
    let mut warnings = Warnings::new();
    let settings = VoxelSettings { n_max: 1e9, ..VoxelSettings::default() };
    let stock = voxel(&voxels, &settings, &mut warnings);
    assert_eq!((stock.len(), warnings.iter().count()), (4 * MAX_IN_VOXEL, 1));
    for n_max in [0.2, 0.0, -3.0, f32::NAN] {
        assert_eq!(bake(&voxels, n_max).len(), 4, "{n_max}");
    }
    assert!(bake(&Voxels::default(), 5.0).is_empty());
    let mut flat = voxels;
    flat.edges = [Vec3::ZERO; 3];
    assert!(bake(&flat, 5.0).is_empty());
}

#[test]
fn stocks_move_as_a_whole() {
    let mut stock = bake(&sheet(3, Vec3::Z), 4.0);
    let before = stock.clone();
    stock.translate(Vec3::new(1.0, 2.0, 4.0));
    assert_eq!(stock.position.at(5), before.position.at(5) + Vec3::new(1.0, 2.0, 4.0));
    let centers = [&stock, &before].map(|s| s.elements.as_ref().unwrap().position.at(5));
    assert_eq!(centers[0], centers[1] + Vec3::new(1.0, 2.0, 4.0));
    assert_eq!(stock.baked, before.baked);
}
