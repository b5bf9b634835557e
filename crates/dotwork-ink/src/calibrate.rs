//! Measures the universal coverage table: draws dots of a baked plate, squashed by a cosine, and counts the covered
//! samples. `examples/measure_coverage.rs` writes `coverage_table.rs` with it; a test measures entries again.

use dotwork_mesh::Mesh;
use glam::Vec3;

use crate::bake::{BakeSettings, blue_noise};
use crate::density::Arrival;
use crate::params::Fade;
use crate::stock::Stock;
use crate::surface::MeshSurface;

/// A baked unit square to measure on.
pub struct Plate {
    stock: Stock,
}

impl Plate {
    /// Bakes `stipples` on the unit square.
    pub fn new(stipples: usize, regularity: f32, seed: u32) -> Plate {
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
            corner_normals: triangles.clone(),
            triangles,
            normals: vec![Vec3::Z; 4],
            origin: [0.0; 3],
            closed: false,
            colors: Vec::new(),
            paint: None,
        };
        let settings = BakeSettings { stipples, regularity, seed };
        let baked = blue_noise(&MeshSurface::new(&mesh), &settings, |_| ());
        Plate { stock: Stock::on_mesh(baked, &mesh) }
    }

    /// The covered share of the page at ink area `x` per page area and cosine `c`, for dots that grow over `width` of
    /// the spacing; the mean over two spacings an uneven part of a stage apart.
    pub fn covered(&self, x: f32, c: f32, width: f32) -> f32 {
        let n = self.stock.len();
        let at =
            |share: f64| self.covered_at(self.stock.baked.radius[(n as f64 * share) as usize], x, c, width);
        0.5 * (at(0.5) + at(0.36))
    }

    fn covered_at(&self, spacing: f32, x: f32, c: f32, width: f32) -> f32 {
        let fade = if width > 0.0 { Fade::Size } else { Fade::Off };
        // A window away from the plate's edges.
        const LOW: f32 = 0.1;
        const HIGH: f32 = 0.9;
        let arrival = Arrival { fade, width: width.max(1e-3), min: 0.0 };
        let dots: Vec<(Vec3, f32)> = self
            .stock
            .baked
            .radius
            .iter()
            .enumerate()
            .map(|(i, &r)| (self.stock.position.at(i), arrival.at(r, spacing)))
            .filter(|(_, a)| *a > 0.0)
            .collect();
        let inside = |p: Vec3| (LOW..HIGH).contains(&p.x) && (LOW..HIGH).contains(&p.y);
        let ink: f64 = dots.iter().filter(|(p, _)| inside(*p)).map(|(_, a)| f64::from(*a).powi(2)).sum();
        let window = f64::from((HIGH - LOW) * (HIGH - LOW) * c);
        // The radius that makes the dots' areas sum to x per page area, and samples fine enough to draw it.
        let radius = (f64::from(x) * window / (std::f64::consts::PI * ink)).sqrt() as f32;
        let scale = (6.0 * (x / 0.5).sqrt()).clamp(2.0, 7.0) / radius;
        let (width, height) = (((HIGH - LOW) * scale) as i32, ((HIGH - LOW) * c * scale) as i32);
        let mut covered = vec![false; (width * height) as usize];
        for (p, a) in dots {
            let (px, py, r) = ((p.x - LOW) * scale, (p.y - LOW) * c * scale, radius * a * scale);
            for y in ((py - r).ceil() as i32).max(0)..=((py + r).floor() as i32).min(height - 1) {
                let half = (r * r - (y as f32 - py).powi(2)).max(0.0).sqrt();
                let from = ((px - half).ceil() as i32).max(0);
                let to = ((px + half).floor() as i32).min(width - 1);
                if from <= to {
                    covered[(y * width + from) as usize..=(y * width + to) as usize].fill(true);
                }
            }
        }
        covered.iter().filter(|c| **c).count() as f32 / covered.len() as f32
    }
}
