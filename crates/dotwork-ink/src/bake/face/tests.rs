use std::collections::BTreeSet;

use dotwork_drawing::Warnings;
use dotwork_mesh::{MeshOptions, RawMesh, shapes};

use super::*;
use crate::Carrier;

fn build(raw: RawMesh) -> Mesh {
    Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap()
}

fn settings(stipples: usize) -> FaceSettings {
    FaceSettings {
        stipples,
        n_max: 1.0,
        wanted: 1.0,
        rank: Rank::Even,
        regularity: 1.0,
        seed: 3,
        reference: None,
    }
}

fn numbers(stock: &Stock) -> (&[f32], &[f32]) {
    let elements = stock.elements.as_ref().unwrap();
    match &elements.carrier {
        Carrier::Faces { number } => (number, &elements.area),
        Carrier::Voxels { .. } => panic!("these are faces"),
    }
}

/// Mean and smallest nearest-neighbour distance of the first `count` stipples of a plate of side 1 over the hexagonal
/// spacing, away from its border.
fn evenness(stock: &Stock, count: usize) -> (f32, f32) {
    let hexagonal = (1.1547 / count as f32).sqrt();
    let side = (1.0 / hexagonal) as i32;
    let at: Vec<Vec3> = (0..count).map(|i| stock.position.at(i)).collect();
    let cell = |p: &Vec3| [p.x, p.y].map(|v| (((v + 0.5) * side as f32) as i32).clamp(0, side - 1));
    let mut cells = vec![Vec::new(); (side * side) as usize];
    for (i, p) in at.iter().enumerate() {
        let [x, y] = cell(p);
        cells[(x + side * y) as usize].push(i);
    }
    let (mut mean, mut least, mut counted) = (0.0, f32::MAX, 0);
    for (i, p) in at.iter().enumerate().filter(|(_, p)| p.abs().max_element() < 0.46) {
        let [x, y] = cell(p);
        let near = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| [x + dx, y + dy]));
        let near = near.filter(|c| c.iter().all(|v| (0..side).contains(v)));
        let d = near
            .flat_map(|[x, y]| &cells[(x + side * y) as usize])
            .filter(|j| **j != i)
            .map(|&j| at[j].distance(*p))
            .fold(f32::MAX, f32::min);
        (mean, least, counted) = (mean + d / hexagonal, least.min(d / hexagonal), counted + 1);
    }
    (mean / counted as f32, least)
}

/// Aim: mean ≥ 0.65 and minimum ≥ 0.3 of the hexagonal spacing at tones of 5, 10, 20 and 40 % and above, whatever the
/// tessellation: two triangles; a grid with ten, 2.5 and 0.6 stipples a face; irregular ones with 60 and 4.
#[test]
fn plates_are_even_whatever_their_tessellation() {
    let plates = [
        ("two triangles", shapes::plate(1, 1)),
        ("grid of 10 a face", shapes::plate(100, 100)),
        ("grid of 2.5 a face", shapes::plate(200, 200)),
        ("grid of 0.6 a face", shapes::plate(400, 400)),
        ("irregular, 60 a face", shapes::plate_irregular(40, 3)),
        ("irregular, 4 a face", shapes::plate_irregular(150, 3)),
    ];
    for (name, raw) in plates {
        let mesh = build(raw);
        let stock = face(&mesh, &settings(200_000), |_| ());
        assert_eq!(stock.len(), 200_000, "{name}");
        for tone in [0.05, 0.1, 0.2, 0.4, 0.8, 1.0] {
            let drawn = drawn(&stock, tone * 200_000.0);
            let (mean, least) = evenness(&stock, drawn);
            assert!((drawn as f32 / (tone * 200_000.0) - 1.0).abs() < 0.02, "{name} at {tone}: {drawn}");
            assert!(mean >= 0.7 && least >= 0.3, "{name} at {tone}: {mean} {least}");
        }
    }
}

/// Number of stipples that the spacing of this density draws.
fn drawn(stock: &Stock, density: f32) -> usize {
    let spacing = spacing_of(1.0, density);
    stock.baked.radius.partition_point(|&r| r >= spacing)
}

/// A plate of very unequal faces: strips from a whole side down to a ten thousandth of it, each of two triangles.
fn strips() -> Mesh {
    let mut raw = RawMesh::default();
    let mut y = 0.0f32;
    for k in 0..120 {
        let height = [0.02, 0.001, 0.0001, 0.003][k % 4];
        let first = raw.positions.len() as u32;
        raw.positions.extend([[0.0, y, 0.0], [1.0, y, 0.0], [1.0, y + height, 0.0], [0.0, y + height, 0.0]]);
        raw.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        y += height;
    }
    build(raw)
}

#[test]
fn each_face_draws_its_share_rounded() {
    for mesh in [build(shapes::plate_irregular(12, 3)), strips(), build(shapes::sphere(3))] {
        let stock = face(&mesh, &settings(30_000), |_| ());
        let (number, area) = numbers(&stock);
        let whole: f32 = area.iter().sum();
        for count in [500.0, 4000.0, 11_000.0, 25_000.0] {
            let drawn = drawn(&stock, count / whole);
            let mut each = vec![0u32; area.len()];
            stock.baked.element[..drawn].iter().for_each(|&e| each[e as usize] += 1);
            for (e, &each) in each.iter().enumerate() {
                let asked = count / whole * area[e] + number[e];
                // A hair from a whole number it may be either.
                let near = (asked - asked.round()).abs() < 1e-4;
                assert!(near || each == asked as u32, "{e}: {each} drawn, {asked} asked for");
            }
            // Faces as different as strips of 1 : 200 are rounded fairly.
            assert!((drawn as f32 / count - 1.0).abs() < 0.03, "{count}: {drawn}");
        }
    }
}

#[test]
fn the_stock_is_an_order_of_lists() {
    let mesh = build(shapes::sphere(3));
    let stock = face(&mesh, &settings(5000), |_| ());
    let (number, area) = numbers(&stock);
    let (baked, mask) = (&stock.baked, stock.elements.as_ref().unwrap().rank_mask());
    assert_eq!((stock.len(), number.len()), (5000, mesh.triangles.len()));
    assert!(baked.radius.is_sorted_by(|a, b| a >= b));
    assert!(number.iter().all(|u| (0.0..1.0).contains(u)));
    let mean = number.iter().sum::<f32>() / number.len() as f32;
    assert!((mean - 0.5).abs() < 0.01, "{mean}");
    let mut next = vec![0u32; area.len()];
    for i in 0..stock.len() {
        let (e, k) = (baked.element[i] as usize, (baked.id[i] & mask) as u32);
        assert_eq!((baked.id[i] >> mask.count_ones()) as usize, e);
        assert_eq!(k, next[e], "lists are drawn from their beginning");
        next[e] += 1;
        assert_eq!(baked.radius[i], radius(area[e], k, number[e]));
        let [v, w] = baked.weights[i];
        assert!(v >= 0.0 && w >= 0.0 && v + w <= 1.0 + 1e-6, "{v} {w}");
    }
    assert_eq!(baked.id.iter().collect::<BTreeSet<_>>().len(), stock.len());
    assert!(baked.id.iter().all(|id| *id < 1 << ID_BITS));
}

#[test]
fn ids_hold_any_number_of_faces() {
    for (faces, bits) in [(1, 38), (2, 37), (3, 36), (1 << 20, 18), ((1 << 20) + 1, 17), (50_000_000, 12)] {
        assert_eq!(rank_bits(faces), bits, "{faces}");
    }
}

#[test]
fn random_numbers_are_the_papers_own() {
    let mesh = build(shapes::plate(100, 100));
    let [even, random] = [Rank::Even, Rank::Random].map(|rank| {
        let stock = face(&mesh, &FaceSettings { rank, ..settings(60_000) }, |_| ());
        // Less than half a dot a face.
        let count = drawn(&stock, 9000.0);
        (count, evenness(&stock, count).0)
    });
    assert!((random.0 as f32 / 9000.0 - 1.0).abs() < 0.05 && (random.1 - 0.5).abs() < 0.08, "{random:?}");
    assert!(even.1 > 0.77, "{even:?}");
}

#[test]
fn threads_do_not_matter() {
    let mesh = build(shapes::plate_irregular(30, 5));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| face(&mesh, &settings(4000), |_| ()))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn stipples_follow_their_mesh() {
    let mesh = build(shapes::sphere(3));
    let stock = face(&mesh, &settings(2000), |_| ());
    assert_eq!(stock.following(&mesh).as_ref(), Some(&stock));
    let mut moved = mesh.clone();
    for p in &mut moved.positions {
        *p = Vec3::new(2.0 * p.x, p.y, p.z + 1.0);
    }
    let after = stock.following(&moved).unwrap();
    assert_eq!(after.baked, stock.baked);
    let areas = [&stock, &after].map(|s| s.elements.as_ref().unwrap().area.clone());
    assert!(areas[0] == areas[1], "counts stay");
    for i in 0..stock.len() {
        let p = stock.position.at(i);
        assert!(after.position.at(i).distance(Vec3::new(2.0 * p.x, p.y, p.z + 1.0)) < 1e-5);
    }
}

#[test]
fn degenerate_faces_carry_nothing_and_do_no_harm() {
    let mut mesh = build(shapes::plate(3, 3));
    // As a deformed mesh may have them, past the cleaning.
    mesh.triangles[4] = [2, 2, 2];
    mesh.positions.push(mesh.positions[0] + Vec3::new(1e-30, 0.0, 0.0));
    mesh.normals.push(Vec3::Z);
    let last = mesh.positions.len() as u32 - 1;
    mesh.triangles[7] = [0, last, 1];
    mesh.corner_normals = mesh.triangles.clone();
    for stipples in [0, 1, 17, 3000] {
        let stock = face(&mesh, &settings(stipples), |_| ());
        assert_eq!(stock.len(), stipples.max(1));
        assert!(stock.baked.element.iter().all(|e| ![4, 7].contains(e)));
        assert!(stock.baked.radius.iter().all(|r| *r > 0.0 && r.is_finite()));
    }
    let positions = vec![Vec3::ZERO; mesh.positions.len()];
    assert!(face(&Mesh { positions, ..mesh }, &settings(50), |_| ()).is_empty());
}
