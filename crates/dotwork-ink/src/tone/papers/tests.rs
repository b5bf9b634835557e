use dotwork_drawing::Camera;

use super::*;
use crate::presets::preset;
use crate::stock::Vectors;

fn near(a: f32, b: f32) {
    assert!((a - b).abs() <= 1e-5 * b.abs().max(1.0), "{a} {b}");
}

#[test]
fn factors_at_values_worked_out_by_hand() {
    // 0.5 (0.39 + 0.51 · 0.25²)
    near(boundary(0.5, 0.25, 0.39, 0.51, 2.0), 0.210_937_5);
    near(boundary(1.0, 1.0, 0.4, 0.9, 3.0), 1.3);
    // 0.8 (0.2 + 0.5 · 0.75²), and 0.8 (0.2 + 0.5 (1 − 0.25²)); the same from behind.
    for c in [0.25, -0.25] {
        near(silhouette(0.8, c, 0.2, 0.5, 2.0, SilhouetteForm::Outside), 0.385);
        near(silhouette(0.8, c, 0.2, 0.5, 2.0, SilhouetteForm::Inside), 0.535);
    }
    // Twice as far: a quarter; half as far: four times. |n·E|^k_nz on top.
    near(resolution(0.5, 1.0, 2.0, 0.0), 0.25);
    near(resolution(2.0, 0.0, 2.0, 0.0), 4.0);
    near(resolution(0.5, -0.6, 1.0, 2.0), 0.18);
    near(lighting(0.6, 2.0), 0.64);
    near(lighting(1.0, 2.0), 0.0);
    // Facing away from the light: the full count, whatever the exponent.
    for k in [0.0, 1.0, 2.0, 3.0] {
        near(lighting(-0.6, k), 1.0);
        near(lighting(0.0, k), 1.0);
    }
    // Near end, centre, far end; a number everywhere.
    for (z, k, t) in [
        (1.0, 2.0, 1.0),
        (0.0, 2.0, 0.25),
        (-1.0, 2.0, 0.0),
        (1.0, -2.0, 0.0),
        (0.0, -2.0, 0.25),
        (-0.5, -0.5, 0.75f32.sqrt()),
        (-0.5, 1.5, 0.125),
        (-1.0, 0.0, 1.0),
        (0.3, 0.0, 1.0),
    ] {
        near(distance(z, k), t);
    }
    near(interior(0.3, 2.0), 0.09);
    near(interior(0.0, 0.0), 1.0);
    near(small(2.0, 5.0), 0.6);
    near(small(7.0, 5.0), 0.0);
    near(small(0.0, 5.0), 1.0);
    near(count(25.0, 0.3, 0.0, 0.9), 7.5);
    near(count(25.0, 0.3, 0.5, 0.9), 7.7);
}

#[test]
fn the_product_takes_what_is_on() {
    let sight = Sight { value: 0.6, magnitude: 0.4, n_dot_e: 0.3, n_dot_l: 0.5, ratio: 0.9, z_over_a: -0.2 };
    let mut style = preset("papers").unwrap();
    style.interior = true;
    (style.k_nz, style.k_re, style.k_de, style.k_ie, style.k_le) = (0.5, 1.5, 0.7, 0.8, 1.3);
    let all = PapersTone::new(&style).factors(&sight);
    near(PapersTone::new(&style).tone(&sight), all.iter().product());
    near(PapersTone::new(&style).size(&sight), 0.4 * all[2] * all[4] * all[5]);
    near(PapersTone::new(&style).surface(&sight), all[2] * all[3] * all[4]);
    for (k, name) in FACTORS.iter().enumerate() {
        assert!(all[k] < 0.999, "{name}");
        let mut without = style.clone();
        without.set(name, "false").unwrap();
        let factors = PapersTone::new(&without).factors(&sight);
        assert_eq!(factors[k], 1.0, "{name}");
        assert_eq!((0..6).filter(|&j| factors[j] != all[j]).collect::<Vec<_>>(), [k], "{name} alone");
        assert!(!PapersTone::new(&without).on()[k]);
    }
    FACTORS.iter().for_each(|name| style.set(name, "false").unwrap());
    style.tone = 0.35;
    near(PapersTone::new(&style).tone(&sight), 0.35);
    near(PapersTone::new(&style).size(&sight), 0.4);
    // Bright and strong: the product is cut.
    style.boundary = true;
    (style.tone, style.k_gc, style.k_gs) = (1.0, 3.0, 3.0);
    assert_eq!(PapersTone::new(&style).tone(&sight), 1.0);
}

/// Elements all over a ball.
fn ball(n: usize) -> Elements {
    let random = |i: usize, k: u32| unit(hash2(i as u32, k));
    let at = |i: usize| {
        let p = Vec3::new(random(i, 0), random(i, 1), random(i, 2)) * 2.0 - 1.0;
        p * 0.57
    };
    Elements {
        position: Vectors::collect(n, at),
        normal: Vectors::collect(n, |i| at(i).normalize()),
        value: (0..n).map(|i| random(i, 3)).collect(),
        magnitude: (0..n).map(|i| random(i, 4)).collect(),
        area: vec![1e-3; n],
        n_max: 10.0,
        reach: 0.03,
        reference: None,
        ..Elements::default()
    }
}

#[test]
fn tables_say_what_the_equations_say() {
    let elements = ball(3000);
    let page = Page::default();
    let mut style = preset("papers").unwrap();
    style.interior = true;
    for (re, nz, de, form) in
        [(2.0, 0.0, 1.0, "outside"), (0.0, 1.0, -0.5, "inside"), (1.1, 0.7, 3.0, "outside")]
    {
        (style.k_re, style.k_nz, style.k_de) = (re, nz, de);
        style.set("silhouette_form", form).unwrap();
        let (slow, fast) = (PapersTone::new(&style), ElementTone::new(&style, &elements));
        for ortho in [false, true] {
            let view = Camera { ortho, ..Camera::default() }.view(Vec3::ZERO, 1.0, &page);
            let viewing = Viewing::new(&view, &page, view.right, Some(0.4));
            for e in 0..elements.len() {
                let (sight, _) = viewing.element(&elements, e);
                let (tone, size) = fast.at(e, &sight);
                assert!((tone - slow.tone(&sight)).abs() < 2e-3, "{e}: {tone} {}", slow.tone(&sight));
                assert!((size - slow.size(&sight)).abs() < 4e-3, "{e}: {size} {}", slow.size(&sight));
            }
        }
    }
}

#[test]
fn sights_are_measured_against_the_view_of_reference() {
    let page = Page::default();
    let camera = Camera::default();
    let view = camera.view(Vec3::ZERO, 2.0, &page);
    let reference = Some(reference_scale(&view, &page));
    let toward_eye = view.back;
    let (sight, scale) =
        Viewing::new(&view, &page, view.up, reference).sight(Vec3::ZERO, toward_eye, 0.5, 0.5);
    near(sight.ratio, 1.0);
    near(scale, view.px_per_unit(view.distance));
    assert!(sight.n_dot_e > 0.9999 && sight.n_dot_l.abs() < 1e-6 && sight.z_over_a.abs() < 1e-5);
    let (sight, _) = Viewing::new(&view, &page, view.up, reference).sight(toward_eye, toward_eye, 0.5, 0.5);
    near(sight.z_over_a, 0.5);
    near(sight.ratio, view.distance / (view.distance - 1.0));
    // Zoomed in it is larger, on a page of other pixels the same; without a reference every view is its own.
    let zoomed = Camera { zoom: 2.0, ..camera }.view(Vec3::ZERO, 2.0, &page);
    near(
        Viewing::new(&zoomed, &page, view.up, reference).sight(Vec3::ZERO, toward_eye, 0.5, 0.5).0.ratio,
        2.0,
    );
    near(Viewing::new(&zoomed, &page, view.up, None).sight(Vec3::ZERO, toward_eye, 0.5, 0.5).0.ratio, 1.0);
    let large = Page::pixels(3000, 3000).unwrap();
    let view = camera.view(Vec3::ZERO, 2.0, &large);
    near(
        Viewing::new(&view, &large, view.up, reference).sight(Vec3::ZERO, toward_eye, 0.5, 0.5).0.ratio,
        1.0,
    );
}

#[test]
fn histograms_count_every_element() {
    let elements = ball(2000);
    let page = Page::default();
    let view = Camera::default().view(Vec3::ZERO, 1.0, &page);
    let mut style = preset("papers").unwrap();
    style.distance = 0.0;
    (style.k_gc, style.k_gs) = (0.0, 2.0);
    let histograms = factor_histograms(&elements, &style, &view, &page, view.right);
    let of = |name: &str| histograms.iter().find(|h| h.name == name).unwrap();
    assert_eq!(histograms.len(), 8);
    assert!(histograms.iter().all(|h| h.bins.iter().sum::<u64>() == 2000));
    let off = of("distance");
    assert!(!off.on && off.bins[19] == 2000 && off.mean == 1.0 && off.above == 0);
    // T_b = 2 v |G| with v and |G| uniform: mean ½, above 1 with probability ½ (1 − ln 2).
    let boundary = of("boundary");
    assert!(boundary.on && (boundary.mean - 0.5).abs() < 0.03, "{}", boundary.mean);
    assert!((boundary.above as f64 / 2000.0 - 0.1534).abs() < 0.03, "{}", boundary.above);
    // Half of a ball faces the eye, a little less in perspective; half faces away from the light.
    assert!((of("facing").mean - 0.5).abs() < 0.1 && of("facing").bins[0] + of("facing").bins[19] == 2000);
    assert!(of("lighting").bins[19] > 900);
    let tone = PapersTone::new(&style);
    let viewing = Viewing::new(&view, &page, view.right, None);
    let product: f64 = (0..2000)
        .map(|e| viewing.element(&elements, e).0)
        .filter(|s| s.n_dot_e >= 0.0)
        .map(|s| f64::from(tone.tone(&s)))
        .sum();
    assert!((of("product").mean - product / 2000.0).abs() < 1e-6);
}

#[test]
fn front_oriented_elements_only_where_lighting_or_visibility_asks() {
    let mut style = preset("papers").unwrap();
    near(front_limit(&style).unwrap(), 0.0);
    style.front_angle = 60.0;
    near(front_limit(&style).unwrap(), 0.5);
    style.lighting = false;
    assert_eq!(front_limit(&style), None);
    style.visibility = Visibility::Facing;
    near(front_limit(&style).unwrap(), 0.5);
}
