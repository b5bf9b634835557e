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
            let spacing = spacing_of(1.0 / 200_000.0, tone);
            let drawn = stock.baked.radius.partition_point(|&r| r >= spacing);
            let (mean, least) = evenness(&stock, drawn);
            println!("{name} at {tone}: {drawn} dots, mean {mean:.3} min {least:.3}");
        }
    }
}
