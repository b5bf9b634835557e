//! Faces of meshes as elements: counts, fractions, hiding.

use std::collections::BTreeSet;
use std::sync::Arc;

use dotwork_drawing::{Camera, Color, Drawing, Length, Warnings};
use dotwork_ink::bake::{FaceSettings, face, reference_scale};
use dotwork_ink::{Rank, Style, preset};
use dotwork_mesh::{Mesh, MeshOptions, RawMesh, shapes};
use glam::Vec3;

use super::*;
use crate::CpuBackend;

fn build(raw: RawMesh) -> Mesh {
    Mesh::build(raw, &MeshOptions::default(), &mut Warnings::new()).unwrap()
}

/// The faces of a mesh with `n_max` stipples for each unit of area, and lists that go on beyond that.
fn bake(mesh: &Mesh, n_max: f32, reference: Option<f32>) -> Stock {
    let area: f32 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum();
    let stipples = (1.4 * n_max * area).ceil() as usize;
    let settings = FaceSettings {
        stipples,
        n_max,
        wanted: n_max,
        rank: Rank::Even,
        regularity: 1.0,
        seed: 1,
        reference,
    };
    face(mesh, &settings, |_| ())
}

/// The papers' style of surfaces with every factor off and whole dots.
fn plain(tone: f32) -> Style {
    let mut style = preset("papers-surface").unwrap();
    (style.tone, style.fade, style.lighting, style.resolution) = (tone, Fade::Off, false, 0.0);
    (style.dot_size, style.outlines) = (Length::px(2.0), false);
    style
}

fn camera(direction: &str) -> Camera {
    let mut camera = Camera { ortho: true, ..Camera::default() };
    camera.set_direction(direction).unwrap();
    camera
}

fn draw_in(mesh: &Arc<Mesh>, stock: &Stock, style: &Style, camera: &Camera) -> Dots {
    let page = Page::pixels(600, 600).unwrap();
    let view = camera.view(Vec3::ZERO, 1.0, &page);
    let plan = InkPlan::new(stock, style, &page);
    let subject =
        Subject { name: "o", mesh, lines: &Default::default(), curves: None, stock, style, plan: &plan };
    let frame = Frame { subjects: &[subject], view: &view, light: view.up, page: &page };
    let mut drawing = Drawing::new(page, Color::WHITE);
    CpuBackend::new().frame(&frame, &mut drawing);
    drawing.layers.remove(0).dots
}

fn counts(dots: &Dots, stock: &Stock) -> Vec<u32> {
    let mut counts = vec![0; stock.elements.as_ref().unwrap().len()];
    dots.stipple.iter().for_each(|&i| counts[stock.baked.element[i as usize] as usize] += 1);
    counts
}

fn total(dots: &Dots) -> f32 {
    dots.ink.iter().zip(&dots.size).map(|(ink, size)| ink * size * size).sum()
}

/// A plate has area 1: its stipples are as many as its density says, two triangles or 20,000, however it is tilted; with
/// k_nz 1 as many for each area of the page.
#[test]
fn plates_bring_the_ink_of_their_tone_tilted_and_in_any_tessellation() {
    for raw in [shapes::plate(1, 1), shapes::plate(100, 100), shapes::plate_irregular(40, 3)] {
        let mesh = Arc::new(build(raw));
        let stock = bake(&mesh, 60_000.0, None);
        for (direction, cosine) in [("0,0", 1.0), ("45,0", 0.5f32.sqrt()), ("0,60", 0.5)] {
            for tone in [0.02, 0.05, 0.1, 0.2, 0.4, 1.0] {
                for fade in [Fade::Off, Fade::Ink, Fade::Size] {
                    let style = Style { fade, ..plain(tone) };
                    let ink = total(&draw_in(&mesh, &stock, &style, &camera(direction)));
                    let error = ink / (60_000.0 * tone) - 1.0;
                    assert!(error.abs() < 0.03, "{direction} {tone} {fade:?}: off by {error}");
                }
                let style = Style { resolution: 1.0, k_re: 0.0, k_nz: 1.0, ..plain(tone) };
                let dots = draw_in(&mesh, &stock, &style, &camera(direction));
                let error = dots.id.len() as f32 / (60_000.0 * tone * cosine) - 1.0;
                assert!(error.abs() < 0.03, "{direction} {tone} k_nz: off by {error}");
            }
        }
    }
}

#[test]
fn fractions_of_dots_are_rounded_drawn_weaker_or_left_to_chance() {
    let mesh = Arc::new(build(shapes::plate(20, 20)));
    // Ten a face at most.
    let stock = bake(&mesh, 8000.0, None);
    let drawn = |fraction: Fraction, tone: f32| {
        draw_in(&mesh, &stock, &Style { fraction, ..plain(tone) }, &camera("0,0"))
    };
    for (tone, asked) in [(0.03, 0.3f32), (0.07, 0.7), (0.24, 2.4), (0.66, 6.6), (0.98, 9.8)] {
        let off = counts(&drawn(Fraction::Off, tone), &stock);
        assert!(off.iter().all(|c| *c == asked.round() as u32), "{tone}: {off:?}");
        let dots = drawn(Fraction::Ink, tone);
        assert!(counts(&dots, &stock).iter().all(|c| *c == asked.ceil() as u32), "{tone}");
        assert!((total(&dots) / (800.0 * asked) - 1.0).abs() < 1e-3, "{tone}");
        let chance = counts(&drawn(Fraction::Probability, tone), &stock);
        assert!(chance.iter().all(|c| (asked.floor() as u32..=asked.ceil() as u32).contains(c)));
        let mean = chance.iter().sum::<u32>() as f32 / 800.0;
        assert!((mean / asked - 1.0).abs() < 0.01, "{tone}: {mean}");
    }
}

/// Where faces ask for many dots they are rounded, unless they are small on the page.
#[test]
fn what_counts_as_small_is_a_matter_of_area_and_of_dots() {
    let mesh = Arc::new(build(shapes::plate(4, 4)));
    // 62.5 a face at tone 0.5.
    let stock = bake(&mesh, 4000.0, None);
    let differ = |camera: &Camera| {
        let counts = counts(&draw_in(&mesh, &stock, &plain(0.5), camera), &stock);
        counts.iter().collect::<BTreeSet<_>>().len()
    };
    assert_eq!(differ(&camera("0,0")), 1);
    assert_eq!(differ(&Camera { zoom: 0.01, ..camera("0,0") }), 2);
}

#[test]
fn tones_are_nested_and_ids_are_the_same_in_every_view() {
    let mesh = Arc::new(build(shapes::sphere(4)));
    let stock = bake(&mesh, 2000.0, None);
    let ids = |style: &Style, direction: &str| -> BTreeSet<u64> {
        let through = Style { visibility: Visibility::Through, ..style.clone() };
        draw_in(&mesh, &stock, &through, &camera(direction)).id.into_iter().collect()
    };
    let (dark, light) = (ids(&plain(0.7), "0,0"), ids(&plain(0.2), "70,30"));
    assert!(light.len() > 3000 && light.is_subset(&dark));
    assert_eq!(ids(&plain(0.2), "0,0"), light);
}

/// Dots lie on the very surface that hides: none is lost, none shines through.
#[test]
fn solid_hides_what_lies_behind_and_nothing_else() {
    for raw in [shapes::sphere(2), shapes::sphere(5), shapes::torus(0.7, 0.28, 60, 30)] {
        let mesh = Arc::new(build(raw));
        let stock = bake(&mesh, 3000.0, None);
        let solid = draw_in(&mesh, &stock, &plain(0.6), &camera("20,15"));
        let facing = Style { visibility: Visibility::Facing, ..plain(0.6) };
        let facing = draw_in(&mesh, &stock, &facing, &camera("20,15"));
        let eye = camera("20,15").view(Vec3::ZERO, 1.0, &Page::default()).back;
        assert!(solid.stipple.iter().all(|&i| stock.facet.at(i as usize).dot(eye) > 0.0));
        // At the rim solid fades dots out.
        let within = |dots: &Dots| {
            let inner = |i: &&u32| stock.facet.at(**i as usize).dot(eye) > 0.1;
            dots.stipple.iter().filter(inner).count() as f32
        };
        let (solid, facing) = (within(&solid), within(&facing));
        // The near side of the torus lies before a part of its far side.
        let hidden = if mesh.positions.iter().any(|p| p.length() < 0.5) { 0.5..0.98 } else { 0.999..1.0001 };
        assert!(solid > 3000.0 && hidden.contains(&(solid / facing)), "{solid} {facing}");
    }
}

#[test]
fn open_surfaces_show_their_backs_lit_from_their_side() {
    let mesh = Arc::new(build(shapes::plate(10, 10)));
    let stock = bake(&mesh, 9000.0, None);
    let lit = Style { lighting: true, ..plain(1.0) };
    // The light comes from above.
    let count = |direction: &str, style: &Style| draw_in(&mesh, &stock, style, &camera(direction)).id.len();
    let (front, back) = (count("0,60", &lit), count("180,60", &lit));
    assert!(front > 3000 && (front as f32 / back as f32 - 1.0).abs() < 0.03, "{front} {back}");
    assert_eq!(count("180,0", &Style { two_sided: TwoSided::No, ..lit }), 0);
}

#[test]
fn dots_for_each_page_area_stay_as_one_moves_away() {
    let mesh = Arc::new(build(shapes::plate(60, 60)));
    let page = Page::pixels(600, 600).unwrap();
    let first = Camera { ortho: false, ..camera("0,0,4") };
    let reference = reference_scale(&first.view(Vec3::ZERO, 1.0, &page), &page);
    let stock = bake(&mesh, 50_000.0, Some(reference));
    let style = Style { resolution: 1.0, k_re: 2.0, ..plain(0.8) };
    for distance in [4.0, 6.0, 8.0, 12.0] {
        let moved = Camera { ortho: false, ..camera(&format!("0,0,{distance}")) };
        let drawn = draw_in(&mesh, &stock, &style, &moved).id.len() as f32;
        let expected = 40_000.0 * (4.0f32 / distance).powi(2);
        assert!((drawn / expected - 1.0).abs() < 0.02, "{distance}: {drawn} {expected}");
    }
}

#[test]
fn surfaces_take_the_factors_that_they_have_and_the_toon_silhouette() {
    let mesh = Arc::new(build(shapes::sphere(5)));
    let stock = bake(&mesh, 4000.0, None);
    let whole = draw_in(&mesh, &stock, &plain(0.2), &camera("0,0"));
    for (key, acts) in [
        ("boundary", false),
        ("silhouette", false),
        ("interior", false),
        ("distance", true),
        ("lighting", true),
    ] {
        let mut changed = plain(0.2);
        changed.set(key, "true").unwrap();
        let drawn = draw_in(&mesh, &stock, &changed, &camera("0,0"));
        assert_eq!(drawn.id != whole.id, acts, "{key}");
    }
    let toon = draw_in(&mesh, &stock, &Style { toon: 0.4, ..plain(0.2) }, &camera("0,0"));
    let count = |dots: &Dots, range: std::ops::Range<f32>| {
        let cosine = |i: &&u32| range.contains(&stock.normal.at(**i as usize).z);
        dots.stipple.iter().filter(cosine).count() as f32
    };
    assert_eq!(count(&toon, 0.45..1.0), count(&whole, 0.45..1.0));
    let times = count(&toon, 0.1..0.39) / count(&whole, 0.1..0.39);
    assert!((times - 5.0).abs() < 0.3, "{times}");
}

/// The radii serve a sum of ink too: a face's share is counted in them.
#[test]
fn faces_take_a_sum_of_ink_too() {
    for raw in [shapes::plate(2, 2), shapes::plate(90, 90)] {
        let mesh = Arc::new(build(raw));
        let stock = bake(&mesh, 60_000.0, None);
        let style = Style { tone: 0.1, dot_size: Length::px(2.0), ..preset("flat").unwrap() };
        let ink = total(&draw_in(&mesh, &stock, &style, &camera("0,0")));
        let side = camera("0,0").view(Vec3::ZERO, 1.0, &Page::pixels(600, 600).unwrap()).px_per_unit(1.0);
        let covered = ink * std::f32::consts::PI / (side * side);
        assert!((covered / 0.1 - 1.0).abs() < 0.03, "{covered}");
    }
}

#[test]
fn threads_do_not_matter() {
    let mesh = Arc::new(build(shapes::sphere(4)));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let stock = bake(&mesh, 2000.0, None);
            draw_in(&mesh, &stock, &preset("papers-surface").unwrap(), &camera("20,15"))
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn translucent_bodies_thin_their_backs_and_not_their_fronts() {
    let mesh = Arc::new(build(shapes::sphere(5)));
    let stock = bake(&mesh, 3000.0, None);
    let eye = camera("20,15").view(Vec3::ZERO, 1.0, &Page::default()).back;
    let sides = |occlusion: f32| {
        let style = Style { occlusion, two_sided: TwoSided::Yes, ..plain(0.6) };
        let dots = draw_in(&mesh, &stock, &style, &camera("20,15"));
        let front = |i: &&u32| stock.facet.at(**i as usize).dot(eye) > 0.1;
        let count = dots.stipple.iter().filter(front).count();
        [count, dots.id.len() - count].map(|n| n as f32)
    };
    let ([opaque, _], [front, back]) = (sides(1.0), sides(0.2));
    assert!((front / opaque - 1.0).abs() < 0.02, "{front} {opaque}");
    assert!(back > 0.02 * front && back < 0.5 * front, "{back} of {front}");
}
