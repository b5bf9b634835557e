//! The papers' bake of a mesh: how many stipples its faces show.
//!
//! Lu et al., "Illustrative interactive stipple rendering" (2003, section 4.3): a face has as many stipples as it covers
//! pixels at most, seen face on; here `k_max` times that. As for voxels a pixel is a thousandth of the page's shorter side,
//! and the scale is that of the centre, so that the frames of a turn and the sizes of a print have one bake. Where tone is a
//! sum of ink the number is what that tone needs, as of any bake.

use dotwork_drawing::{Page, View};
use dotwork_ink::bake::{FaceSettings, face, reference_scale};
use dotwork_ink::{Factors, Stock, Style};
use dotwork_mesh::Mesh;

use crate::scene::MAX_AUTO_STIPPLES;

/// Pixels across the page's shorter side.
const PAGE: f32 = 1000.0;

/// Lists go on beyond `N_max` by this share: dots that only arrive count by what has arrived of them, so that it takes
/// more of them.
const BEYOND: f64 = 1.3;

/// Bakes the faces of a mesh: with a sum of ink `count` stipples, with the papers' factors those that the view asks for.
pub(crate) fn bake(
    mesh: &Mesh,
    style: &Style,
    count: usize,
    (view, page): (&View, &Page),
    seed: u32,
    progress: &mut dyn FnMut(f32),
) -> Stock {
    let area = area(mesh);
    let settings = FaceSettings {
        stipples: count,
        n_max: (count as f64 / area) as f32,
        wanted: (count as f64 / area) as f32,
        rank: style.rank,
        regularity: style.regularity,
        seed,
        reference: None,
    };
    let settings = match style.factors {
        Factors::Sum => settings,
        Factors::Papers => {
            let reference = reference_scale(view, page);
            let wanted = f64::from(style.k_max) * f64::from(reference * PAGE).powi(2);
            let n_max = wanted.min(MAX_AUTO_STIPPLES as f64 / (BEYOND * area));
            FaceSettings {
                stipples: (BEYOND * n_max * area).ceil() as usize,
                n_max: n_max as f32,
                wanted: wanted as f32,
                reference: Some(reference),
                ..settings
            }
        }
    };
    face(mesh, &settings, progress)
}

/// Area of a mesh, object units squared.
fn area(mesh: &Mesh) -> f64 {
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize].as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles.iter().map(of).sum::<f64>().max(f64::MIN_POSITIVE)
}
