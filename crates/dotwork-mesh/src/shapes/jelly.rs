//! The bell of a jellyfish that swims: a shape that moves, for films.

use std::f32::consts::{PI, TAU};

use super::raw;
use crate::{Clip, Motion, RawMesh};

/// Places around, and from the apex to the rim, on each side.
const AROUND: u32 = 144;
const ALONG: u32 = 48;

/// Seconds of a stroke.
const STROKE: f64 = 1.5;

/// How far the bell reaches round from its apex, as a share of half a turn.
const REACH: f32 = 0.58;

/// Lobes of the rim.
const LOBES: f32 = 8.0;

/// A vertex of the bell: how far it is from the apex to the rim, 0…1, around which angle, and how far out of the two
/// skins it lies.
type Spot = (f32, f32, f32);

/// All vertices: the outer skin from its apex down, then the inner one from the rim up.
fn spots() -> Vec<Spot> {
    let row = |share: f32, skin: f32| (0..AROUND).map(move |k| (share, TAU * k as f32 / AROUND as f32, skin));
    let outer = (1..=ALONG).flat_map(|i| row(i as f32 / ALONG as f32, 1.0));
    let inner = (1..ALONG).rev().flat_map(|i| row(i as f32 / ALONG as f32, 0.0));
    std::iter::once((0.0, 0.0, 1.0)).chain(outer).chain(inner).chain([(0.0, 0.0, 0.0)]).collect()
}

/// Where a spot is when the bell is drawn in by `squeeze`, 0…1, at its rim.
fn place((share, around, skin): Spot, squeeze: f32, rise: f32) -> [f32; 3] {
    let angle = REACH * PI * share;
    let thick = 0.82 + (0.18 - 0.12 * share * share) * skin;
    let lobe = 1.0 + 0.07 * share.powi(4) * (LOBES * around).cos();
    let in_ = 1.0 - 0.42 * squeeze * share * share;
    let radius = thick * angle.sin() * lobe * in_;
    let height = 0.95 * thick * angle.cos() - 0.28 * squeeze * share * share + rise;
    let (sin, cos) = around.sin_cos();
    [radius * cos, height, radius * sin]
}

/// The bell at rest, about a unit high.
pub fn jelly() -> RawMesh {
    let positions = spots().into_iter().map(|s| place(s, 0.0, 0.0)).collect();
    let rows = 2 * ALONG - 1;
    let at = |row: u32, k: u32| 1 + row * AROUND + k % AROUND;
    let last = 1 + rows * AROUND;
    let mut triangles = Vec::new();
    for k in 0..AROUND {
        triangles.push([0, at(0, k + 1), at(0, k)]);
        for row in 0..rows - 1 {
            let [a, b, c, d] = [at(row, k), at(row, k + 1), at(row + 1, k), at(row + 1, k + 1)];
            triangles.extend([[a, b, c], [b, d, c]]);
        }
        triangles.push([at(rows - 1, k), at(rows - 1, k + 1), last]);
    }
    raw(positions, triangles)
}

/// What moves the bell.
#[derive(Debug)]
pub(super) struct Swim {
    spots: Vec<Spot>,
    clips: [Clip; 1],
}

impl Swim {
    pub(super) fn new() -> Swim {
        Swim { spots: spots(), clips: [Clip { name: "swim".into(), seconds: STROKE }] }
    }
}

impl Motion for Swim {
    fn clips(&self) -> &[Clip] {
        &self.clips
    }

    fn place(&self, clip: Option<usize>, time: f64, positions: &mut Vec<[f32; 3]>) {
        positions.clear();
        let phase = (TAU as f64 * time.clamp(0.0, STROKE) / STROKE) as f32;
        positions.extend(self.spots.iter().map(|&spot| {
            if clip.is_none() {
                return place(spot, 0.0, 0.0);
            }
            // The rim is drawn in later than the crown, and the bell rises after that.
            let squeeze = 0.5 - 0.5 * (phase - 0.9 * spot.0).cos();
            place(spot, squeeze, 0.14 * (phase - 2.2).sin())
        }));
    }
}

#[cfg(test)]
mod tests {
    use dotwork_drawing::Warnings;

    use super::*;
    use crate::{Mesh, MeshOptions};

    #[test]
    fn the_bell_is_closed_and_swims_in_a_loop() {
        let mut warnings = Warnings::new();
        let mesh = Mesh::build(jelly(), &MeshOptions::default(), &mut warnings).unwrap();
        assert!(mesh.closed && warnings.is_empty() && mesh.volume() > 0.1);
        let (swim, mut first, mut last, mut rest) = (Swim::new(), Vec::new(), Vec::new(), Vec::new());
        swim.place(Some(0), 0.0, &mut first);
        swim.place(Some(0), STROKE, &mut last);
        swim.place(None, 0.7, &mut rest);
        let near = |a: &[f32; 3], b: &[f32; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-5);
        assert!(first.iter().zip(&last).all(|(a, b)| near(a, b)), "it ends as it begins");
        assert_eq!(rest, jelly().positions);
        let mut middle = Vec::new();
        swim.place(Some(0), 0.6 * STROKE, &mut middle);
        let width = |places: &[[f32; 3]]| places.iter().map(|p| p[0].hypot(p[2])).fold(0.0, f32::max);
        assert!(width(&middle) < 0.8 * width(&rest), "it is drawn in: {} {}", width(&middle), width(&rest));
    }
}
