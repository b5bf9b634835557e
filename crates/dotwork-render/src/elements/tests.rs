use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use dotwork_drawing::{Camera, Color, Drawing, Length, Warnings};
use dotwork_ink::bake::{VoxelSettings, Voxels, reference_scale, voxel};
use dotwork_ink::tone::FACTORS;
use dotwork_ink::{BakeSettings, MeshSurface, SizeMax, Style, Vectors, blue_noise, preset};
use dotwork_mesh::{Mesh, MeshOptions, shapes};
use glam::Vec3;

use super::*;
use crate::CpuBackend;

const SIDE: usize = 20;

/// A sheet of voxels across the plane z = 0, two units a side, towards +z.
fn sheet() -> Voxels {
    let edge = 2.0 / SIDE as f32;
    let n = SIDE * SIDE;
    let at = |i: usize| ((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5);
    Voxels {
        position: Vectors {
            x: (0..n).map(|i| at(i).0 * edge - 1.0).collect(),
            y: (0..n).map(|i| at(i).1 * edge - 1.0).collect(),
            z: vec![0.0; n],
        },
        normal: Vectors { x: vec![0.0; n], y: vec![0.0; n], z: vec![1.0; n] },
        magnitude: vec![1.0; n],
        value: vec![1.0; n],
        edges: [Vec3::X * edge, Vec3::Y * edge, Vec3::Z * edge],
    }
}

/// The voxels of a lattice that the unit sphere passes through.
fn shell() -> Voxels {
    let edge = 0.1;
    let mut voxels = Voxels { edges: [Vec3::X * edge, Vec3::Y * edge, Vec3::Z * edge], ..Voxels::default() };
    for i in 0..25 * 25 * 25 {
        let p = (Vec3::new((i % 25) as f32, (i / 25 % 25) as f32, (i / 625) as f32) - 12.0) * edge;
        if (p.length() - 1.0).abs() < 0.5 * edge {
            let n = p.normalize();
            for (list, v) in [
                (&mut voxels.position.x, p.x),
                (&mut voxels.position.y, p.y),
                (&mut voxels.position.z, p.z),
                (&mut voxels.normal.x, n.x),
                (&mut voxels.normal.y, n.y),
                (&mut voxels.normal.z, n.z),
                (&mut voxels.magnitude, 0.5 + 0.5 * n.x * n.x),
                (&mut voxels.value, 0.8),
            ] {
                list.push(v);
            }
        }
    }
    voxels
}

fn ball() -> Mesh {
    Mesh::build(shapes::sphere(4), &MeshOptions::default(), &mut Warnings::new()).unwrap()
}

fn bake(voxels: &Voxels, n_max: f32, reference: Option<f32>) -> Stock {
    let settings = VoxelSettings { n_max, reference, ..VoxelSettings::default() };
    voxel(voxels, &settings, &mut Warnings::new())
}

/// The papers' style with every factor off, whole dots and one size.
fn plain(tone: f32) -> Style {
    let mut style = preset("papers").unwrap();
    FACTORS.iter().for_each(|name| style.set(name, "false").unwrap());
    (style.tone, style.fade, style.size_max) = (tone, Fade::Off, SizeMax(None));
    style
}

fn camera(direction: &str) -> Camera {
    let mut camera = Camera::default();
    camera.set_direction(direction).unwrap();
    camera
}

fn draw(stock: &Stock, style: &Style, camera: &Camera) -> Dots {
    let (mesh, page) = (Arc::new(ball()), Page::pixels(600, 600).unwrap());
    let view = camera.view(Vec3::ZERO, 1.5, &page);
    let plan = InkPlan::new(stock, style, &page);
    let subject = Subject {
        name: "o",
        mesh: &mesh,
        lines: &Default::default(),
        curves: None,
        stock,
        style,
        plan: &plan,
    };
    let frame = Frame { subjects: &[subject], view: &view, light: view.up, page: &page };
    let mut drawing = Drawing::new(page, Color::WHITE);
    let mut backend = CpuBackend::new();
    backend.frame(&frame, &mut drawing);
    if stock.elements.is_some() && style.factors == dotwork_ink::Factors::Papers {
        assert_eq!(backend.exhausted(&frame), 0.0);
        assert_eq!(backend.stipples_needed(&frame, 0).stipples, stock.len());
    }
    drawing.layers.remove(0).dots
}

fn ids(dots: &Dots) -> BTreeSet<u64> {
    let ids: BTreeSet<u64> = dots.id.iter().copied().collect();
    assert_eq!(ids.len(), dots.id.len());
    ids
}

/// Dots of each element.
fn counts(dots: &Dots, stock: &Stock) -> Vec<u32> {
    let mut counts = vec![0; stock.elements.as_ref().unwrap().len()];
    dots.stipple.iter().for_each(|&i| counts[stock.baked.element[i as usize] as usize] += 1);
    counts
}

#[test]
fn a_tone_is_a_share_of_every_elements_list() {
    let stock = bake(&sheet(), 25.0, None);
    for (tone, count) in [(1.0, 25), (0.41, 10), (0.05, 1), (0.01, 0)] {
        let dots = draw(&stock, &plain(tone), &camera("0,0"));
        assert!(counts(&dots, &stock).iter().all(|c| *c == count), "{tone}");
    }
}

#[test]
fn tones_are_nested_and_ids_are_the_same_in_every_view() {
    let stock = bake(&shell(), 12.0, None);
    let views =
        ["0,0", "35,20", "180,-70"].map(|direction| ids(&draw(&stock, &plain(0.5), &camera(direction))));
    assert!(views[0].len() > 2000 && views.iter().all(|v| *v == views[0]), "no factor knows the view");
    let mut style = preset("papers").unwrap();
    let all = ids(&draw(&stock, &style, &camera("20,15")));
    style.tone = 0.6;
    let fewer = ids(&draw(&stock, &style, &camera("20,15")));
    assert!(fewer.len() > 100 && fewer.len() < all.len() && fewer.is_subset(&all));
}

#[test]
fn threads_do_not_matter() {
    let stock = bake(&shell(), 12.0, None);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| draw(&stock, &preset("papers").unwrap(), &camera("20,15")))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn lit_volumes_show_their_front_and_all_of_it_in_the_shade() {
    let stock = bake(&shell(), 30.0, None);
    let elements = stock.elements.as_ref().unwrap();
    let mut style = plain(1.0);
    style.lighting = true;
    let camera = Camera { ortho: true, ..camera("0,0") };
    let counts = counts(&draw(&stock, &style, &camera), &stock);
    // The eye on +z, the light on +y.
    let mut shaded = 0;
    for (e, &count) in counts.iter().enumerate() {
        let n = elements.normal.at(e);
        let expected = match n.z {
            z if z < 0.0 => 0.0,
            _ => 30.0 * (1.0 - n.y.max(0.0)),
        };
        if !(0.0..RIM).contains(&n.z) {
            assert!((count as f32 - expected).abs() <= 0.51, "{n}: {count} {expected}");
            shaded += u32::from(n.z > 0.0 && n.y < 0.0 && count == 30);
        }
    }
    assert!(shaded > 100);
    style.front_angle = 45.0;
    let front = draw(&stock, &style, &camera);
    let cosine = |i: &u32| stock.normal.at(*i as usize).z;
    assert!(!front.id.is_empty() && front.stipple.iter().all(|i| cosine(i) >= 0.5f32.sqrt()));
}

#[test]
fn dots_for_each_page_area_stay_as_one_moves_away() {
    let page = Page::pixels(600, 600).unwrap();
    let first = camera("0,0,4");
    let reference = reference_scale(&first.view(Vec3::ZERO, 1.5, &page), &page);
    let stock = bake(&sheet(), 72.0, Some(reference));
    let mut style = plain(1.0);
    style.resolution = 1.0;
    style.k_re = 2.0;
    for (distance, count) in [(4.0, 72), (6.0, 32), (8.0, 18), (12.0, 8)] {
        let moved = camera(&format!("0,0,{distance}"));
        let dots = draw(&stock, &style, &moved);
        assert!(counts(&dots, &stock).iter().all(|c| *c == count), "{distance}: {:?}", dots.id.len());
        // The same dots for each pixel squared.
        let side = moved.view(Vec3::ZERO, 1.5, &page).px_per_unit(distance * 1.5) * 2.0;
        let density = dots.id.len() as f32 / (side * side);
        let scale = first.view(Vec3::ZERO, 1.5, &page).px_per_unit(6.0) * 2.0;
        assert!((density / (400.0 * 72.0 / (scale * scale)) - 1.0).abs() < 0.01, "{distance}");
        // Zoom is distance too; nearer than the reference there are no more than the list has.
        let zoomed = Camera { zoom: 4.0 / distance, ..first };
        assert_eq!(dots.id.len(), draw(&stock, &style, &zoomed).id.len());
    }
    style.resolution = 0.0;
    assert_eq!(draw(&stock, &style, &camera("0,0,12")).id.len(), 400 * 72);
}

#[test]
fn fractions_of_dots_keep_the_mean_ink() {
    let stock = bake(&sheet(), 1.0, None);
    let far = Camera { zoom: 0.02, ..camera("0,0") };
    let ink = |fraction: Fraction, tone: f32, camera: &Camera| {
        let dots = draw(&stock, &Style { fraction, ..plain(tone) }, camera);
        (dots.id.len(), dots.ink.iter().sum::<f32>())
    };
    for tone in [0.1, 0.3, 0.8] {
        // 400 elements: five standard deviations.
        let (dots, strength) = ink(Fraction::Probability, tone, &far);
        assert_eq!(dots as f32, strength);
        assert!(
            (strength - 400.0 * tone).abs() < 5.0 * (400.0 * tone * (1.0 - tone)).sqrt(),
            "{tone}: {dots}"
        );
        let (dots, strength) = ink(Fraction::Ink, tone, &far);
        assert!(dots == 400 && (strength - 400.0 * tone).abs() < 0.1, "{tone}: {dots} {strength}");
        assert_eq!(ink(Fraction::Off, tone, &far).0, if tone < 0.5 { 0 } else { 400 });
        // Large on the page, elements do not need luck.
        assert_eq!(ink(Fraction::Probability, tone, &camera("0,0")).0, if tone < 0.5 { 0 } else { 400 });
    }
}

#[test]
fn arriving_dots_bring_the_ink_of_the_count() {
    let stock = bake(&sheet(), 90.0, None);
    for (fade, fraction) in
        [(Fade::Ink, Fraction::Off), (Fade::Size, Fraction::Off), (Fade::Off, Fraction::Ink)]
    {
        for tone in [0.2, 0.555, 0.8] {
            let style = Style { fade, fraction, ..plain(tone) };
            let dots = draw(&stock, &style, &camera("0,0"));
            let ink: f32 = dots.ink.iter().zip(&dots.size).map(|(ink, size)| ink * size * size).sum();
            assert!((ink / (400.0 * 90.0 * tone) - 1.0).abs() < 0.03, "{fade:?} {fraction:?} {tone}: {ink}");
        }
    }
}

#[test]
fn sizes_follow_the_gradient() {
    let stock = bake(&shell(), 6.0, None);
    let elements = stock.elements.as_ref().unwrap();
    let mut style = plain(1.0);
    style.size_max = SizeMax(Some(Length::px(3.0)));
    let dots = draw(&stock, &style, &camera("20,15"));
    assert!(dots.id.len() > 1000);
    for (k, &i) in dots.stipple.iter().enumerate() {
        let magnitude = elements.magnitude[stock.baked.element[i as usize] as usize];
        assert!((dots.radius[k] - 1.5 * magnitude).abs() < 1e-3 && (dots.size[k] - magnitude).abs() < 1e-3);
    }
    // What lies deeper is smaller.
    style.distance = 1.0;
    style.tone = 20.0;
    let nearer = draw(&stock, &style, &camera("20,15"));
    let radius: BTreeMap<u64, f32> = dots.id.iter().copied().zip(dots.radius).collect();
    let shares: Vec<f32> = nearer.id.iter().zip(&nearer.radius).map(|(id, r)| r / radius[id]).collect();
    assert!(shares.iter().all(|s| (0.1..1.0).contains(s)) && shares.iter().any(|s| *s < 0.3));
}

#[test]
fn solid_hides_what_lies_behind_and_nothing_else() {
    let style = |visibility| Style { visibility, ..plain(1.0) };
    // On the surface of the ball that hides.
    let stock = bake(&shell(), 10.0, None);
    let [facing, solid] = [Visibility::Facing, Visibility::Solid].map(|v| {
        let dots = draw(&stock, &style(v), &camera("20,15"));
        // By the eye's direction at the centre; towards the rim a coarse lattice of voxels is rough.
        let eye = camera("20,15").view(Vec3::ZERO, 1.5, &Page::default()).back;
        let front = dots.stipple.iter().filter(|i| stock.normal.at(**i as usize).dot(eye) > 0.4).count();
        (ids(&dots), front)
    });
    assert!(solid.0.is_subset(&facing.0));
    assert!(solid.1 as f32 > 0.99 * facing.1 as f32, "{} {}", solid.1, facing.1);
    let facing = facing.0;
    let through = draw(&stock, &plain(1.0), &camera("20,15")).id.len();
    assert!(facing.len() > through / 3 && facing.len() < through / 2, "{} {through}", facing.len());
    // Inside it.
    let mut inside = sheet();
    for list in [&mut inside.position.x, &mut inside.position.y] {
        list.iter_mut().for_each(|v| *v *= 0.4);
    }
    let inside = bake(&inside, 10.0, None);
    assert_eq!(draw(&inside, &style(Visibility::Facing), &camera("0,0")).id.len(), 4000);
    assert_eq!(draw(&inside, &style(Visibility::Solid), &camera("0,0")).id.len(), 0);
}

#[test]
fn what_lies_in_translucent_matter_is_thinned() {
    let mut inside = sheet();
    for list in [&mut inside.position.x, &mut inside.position.y] {
        list.iter_mut().for_each(|v| *v *= 0.4);
    }
    let stock = bake(&inside, 100.0, None);
    let elements = stock.elements.as_ref().unwrap();
    let camera = Camera { ortho: true, ..camera("0,0") };
    for (occlusion, k) in [(0.0, 0.0), (0.1, 8.0 / 9.0), (0.2, 2.0)] {
        let style = Style { visibility: Visibility::Solid, occlusion, ..plain(1.0) };
        for (e, &count) in counts(&draw(&stock, &style, &camera), &stock).iter().enumerate() {
            // From the front of the unit ball to where the sheet is looked at; the scene's radius is 1.5.
            let matter = (1.0 - elements.position.at(e).length_squared()).sqrt() - elements.reach;
            let expected = 100.0 * (-k * matter / 1.5).exp();
            assert!(
                (count as f32 - expected).abs() < 0.51 + 0.01 * expected,
                "{occlusion}: {count} {expected}"
            );
        }
    }
}

#[test]
fn what_lies_behind_the_eye_is_not_drawn() {
    let mut behind = sheet();
    behind.position.z.fill(3.0);
    behind.normal.z.fill(-1.0);
    let stock = bake(&behind, 10.0, None);
    // The eye on +z, 1.575 from the centre: a mirror image would lie on the page.
    let camera = camera("0,0,1.05");
    let mut papers = plain(1.0);
    for k_re in [0.0, 0.5, 2.0] {
        (papers.resolution, papers.k_re) = (1.0, k_re);
        assert_eq!(draw(&stock, &papers, &camera).id.len(), 0, "{k_re}");
    }
    let flat = Style { visibility: Visibility::Through, ..preset("flat").unwrap() };
    assert_eq!(draw(&stock, &flat, &camera).id.len(), 0);
    // In parallel projection nothing lies behind it.
    let parallel = Camera { ortho: true, ..camera };
    assert_eq!(draw(&stock, &papers, &parallel).id.len(), 4000);
}

#[test]
fn surfaces_take_the_factors_that_they_have() {
    let mesh = ball();
    let settings = BakeSettings { stipples: 60_000, ..BakeSettings::default() };
    let stock = Stock::on_mesh(blue_noise(&MeshSurface::new(&mesh), &settings, |_| ()), &mesh);
    let style = |tone: f32| Style { dot_size: Length::px(4.0), ..plain(tone) };
    let camera = Camera { ortho: true, ..camera("0,0") };
    let drawn = |style: &Style| draw(&stock, style, &camera).id.len() as f32;
    let whole = drawn(&style(0.2));
    assert!(whole > 1000.0 && (drawn(&style(0.4)) / whole - 2.0).abs() < 0.1);
    // Without elements there is no value and no gradient to go by.
    for (key, acts) in [("boundary", false), ("silhouette", false), ("interior", false), ("distance", true)] {
        let mut changed = style(0.2);
        changed.set(key, "true").unwrap();
        assert_eq!(drawn(&changed) != whole, acts, "{key}");
    }
    let mut lit = style(0.2);
    lit.lighting = true;
    let upper = |dots: Dots| dots.y.iter().filter(|y| **y < 300.0).count() as f32 / dots.y.len() as f32;
    assert!(upper(draw(&stock, &style(0.2), &camera)) > 0.48 && upper(draw(&stock, &lit, &camera)) < 0.4);
}

#[test]
fn voxels_take_a_sum_of_ink_too() {
    let stock = bake(&shell(), 40.0, None);
    let mut style = preset("flat").unwrap();
    style.visibility = Visibility::Facing;
    let drawn = |style: &Style| draw(&stock, style, &camera("0,0")).id.len();
    style.tone = 0.05;
    let light = drawn(&style);
    style.tone = 0.1;
    assert!(light > 200 && (drawn(&style) as f32 / light as f32 - 2.0).abs() < 0.3);
}
