use super::*;
use crate::testing::dots;
use dotwork_drawing::hash::{hash2, unit};
use dotwork_drawing::{Color, Page, StrokeKind};

/// A page on which a pixel is a millimetre.
fn page(side: u32) -> Page {
    Page { width: side, height: side, dpi: 25.4, margin_px: 0.0 }
}

fn with_dots(side: u32, points: &[[f32; 2]]) -> Drawing {
    let mut drawing = Drawing::new(page(side), Color::WHITE);
    let mut layer = Layer { dots: dots(points.len()), ..Layer::default() };
    for (i, p) in points.iter().enumerate() {
        (layer.dots.x[i], layer.dots.y[i]) = (p[0], p[1]);
    }
    drawing.layers.push(layer);
    drawing
}

fn random(n: u32, side: f32) -> Vec<[f32; 2]> {
    (0..n).map(|i| [unit(hash2(i, 3)) * side, unit(hash2(i, 4)) * side]).collect()
}

/// Each dot once, with all that belongs to it.
fn assert_same_dots(before: &Dots, after: &Dots) {
    let rows = |d: &Dots| {
        let mut rows: Vec<_> = (0..d.len())
            .map(|i| {
                let bits = [d.x[i], d.y[i], d.depth[i], d.radius[i], d.size[i], d.ink[i]].map(f32::to_bits);
                (d.id[i], d.stipple[i], bits)
            })
            .collect();
        rows.sort_unstable();
        rows
    };
    assert_eq!(rows(before), rows(after));
}

fn ordered(drawing: &Drawing) -> (Drawing, Travel) {
    let mut after = drawing.clone();
    let travel = order_for_plotter(&mut after);
    for (before, after) in drawing.layers.iter().zip(&after.layers) {
        assert_same_dots(&before.dots, &after.dots);
    }
    (after, travel)
}

#[test]
fn a_grid_is_nearly_optimal() {
    for n in [2u32, 3, 7, 20, 60] {
        // n² points a millimetre apart: the best way has n² − 1 steps. They come in disorder.
        let mut points: Vec<[f32; 2]> = (0..n * n).map(|i| [(i % n) as f32, (i / n) as f32]).collect();
        points.sort_by_key(|p| hash2(p[0] as u32, p[1] as u32));
        let (_, travel) = ordered(&with_dots(n, &points));
        let best = f64::from(n * n - 1);
        let way = travel.lifted_mm();
        assert!(way > best - 1e-6 && way <= best * 1.1 + 0.5, "{n}: {way} for {best}");
        assert_eq!(travel.lifts(), points.len());
    }
}

/// The best way through n random points of a square of area A is about 0.7124 √(n A) (Beardwood, Halton and
/// Hammersley 1959; the constant by Johnson, McGeoch and Rothberg 1996), a little longer for its edges.
#[test]
fn random_points_are_within_a_tenth_of_the_optimum() {
    let (n, side) = (20_000, 200.0);
    let points = random(n, side);
    let (_, travel) = ordered(&with_dots(200, &points));
    let best = 0.7124 * f64::from(side) * f64::from(n).sqrt();
    let ratio = travel.lifted_mm() / best;
    assert!((0.98..1.1).contains(&ratio), "{ratio}");
    // Without an order: n steps of 0.5214 sides.
    let unordered = travel.unordered_mm() / (f64::from(n) * 0.5214 * f64::from(side));
    assert!((unordered - 1.0).abs() < 0.02, "{unordered}");
}

/// Against 2-opt and Or-opt with twice the neighbours and no bounds, on even and on uneven dots.
#[test]
fn a_long_run_is_hardly_better() {
    let even = random(20_000, 200.0);
    let uneven =
        even.iter().map(|p| [p[0] * p[0] / 200.0, p[1] * p[1] / 200.0 * (0.2 + p[0] / 250.0)]).collect();
    for points in [even, uneven] {
        let drawing = with_dots(200, &points);
        let long = Effort { neighbours: 16, swaps_a_point: 1 << 30, longest_reversal: 1 << 30 };
        let long = order(&mut drawing.clone(), long).lifted_mm();
        let (_, travel) = ordered(&drawing);
        let ratio = travel.lifted_mm() / long;
        assert!((0.98..1.03).contains(&ratio), "{ratio}");
    }
}

#[test]
fn clusters_and_duplicates() {
    // A thousand dots in each of ten places a thousandth of a millimetre wide, 500 in one point, a line.
    let mut points = Vec::new();
    for i in 0..10_000 {
        let center = (i % 10) as f32 * 15.0;
        points.push([center + unit(hash2(i, 1)) * 1e-3, center + unit(hash2(i, 2)) * 1e-3]);
    }
    points.extend([[70.0, 10.0]; 500]);
    points.extend((0..100).map(|i| [i as f32, 150.0]));
    let (after, travel) = ordered(&with_dots(160, &points));
    // The way along the diagonal, to the point aside and back, over to the line and along it is no longer than this.
    assert!(travel.lifted_mm() < 520.0, "{travel}");
    let dots = &after.layers[0].dots;
    let first = dots.x.iter().position(|&x| x == 70.0).unwrap();
    assert!(dots.x[first..first + 500].iter().all(|&x| x == 70.0), "dots in one place are drawn together");
}

#[test]
fn one_dot_none_and_those_without_a_place() {
    let (_, travel) = ordered(&with_dots(10, &[]));
    assert_eq!((travel.layers.len(), travel.to_string()), (0, String::new()));
    let (_, travel) = ordered(&with_dots(10, &[[3.0, 4.0]]));
    assert!((travel.lifted_mm() - 5.0).abs() < 1e-6);
    assert_eq!(travel.lifted_mm(), travel.layers[0].approach_mm);
    let nan = f32::NAN;
    let points = [[nan, 1.0], [9.0, 9.0], [f32::INFINITY, 0.0], [1.0, 1.0], [1e30, 1e30]];
    let (after, travel) = ordered(&with_dots(10, &points));
    assert_eq!(after.layers[0].dots.x[..2], [1.0, 9.0]);
    assert!((travel.lifted_mm() - 9.0 * 2f64.sqrt()).abs() < 1e-5);
}

/// The exact best order of a few points.
fn best_way(points: &[[f32; 2]], from: [f32; 2], visited: u32) -> f64 {
    let way = |(i, p): (usize, &[f32; 2])| {
        let step = f64::from(p[0] - from[0]).hypot(f64::from(p[1] - from[1]));
        step + best_way(points, *p, visited | 1 << i)
    };
    let left = points.iter().enumerate().filter(|(i, _)| visited >> i & 1 == 0);
    left.map(way).min_by(f64::total_cmp).unwrap_or(0.0)
}

#[test]
fn a_few_dots_are_ordered_as_well_as_possible() {
    let mut excess = 0.0;
    for round in 0..100 {
        let n = 2 + round % 6;
        let points: Vec<[f32; 2]> =
            (0..n).map(|i| [unit(hash2(i, round)) * 10.0, unit(hash2(i, round + 1000)) * 10.0]).collect();
        let (_, travel) = ordered(&with_dots(10, &points));
        let best = best_way(&points, [0.0; 2], 0);
        assert!(travel.lifted_mm() >= best - 1e-5);
        excess += travel.lifted_mm() / best - 1.0;
    }
    assert!(excess < 100.0 * 0.02, "{excess} in 100");
}

#[test]
fn the_improvement_is_large_against_the_curve_alone() {
    let points = random(3000, 100.0);
    let drawing = with_dots(100, &points);
    let mut along = drawing.clone();
    let curve = order(&mut along, Effort { swaps_a_point: 0, neighbours: 0, ..Effort::default() });
    let best = 0.7124 * 100.0 * 3000f64.sqrt();
    // The curve is about 25 % above the optimum (Platzman and Bartholdi 1989).
    let ratio = curve.lifted_mm() / best;
    assert!((1.15..1.4).contains(&ratio), "{ratio}");
    let (_, travel) = ordered(&drawing);
    assert!(travel.lifted_mm() < 0.9 * curve.lifted_mm());
}

#[test]
fn strokes_are_turned_and_chained() {
    // The lines of a page, all written from left to right and in disorder: a pen goes to and fro.
    let mut drawing = Drawing::new(page(100), Color::WHITE);
    let mut layer = Layer::default();
    for i in 0..40u32 {
        let row = (i * 7 % 40) as f32;
        let strokes = &mut layer.strokes;
        strokes.push_line(StrokeKind::Crease, u64::from(i), 0.3, [[0.0, row], [5.0, row + 0.1], [90.0, row]]);
        let n = strokes.x.len();
        strokes.width[n - 3..].copy_from_slice(&[0.1, 0.2, 0.3]);
        strokes.depth[n - 3..].copy_from_slice(&[row, row + 1.0, row + 2.0]);
    }
    layer.strokes.kind[3] = StrokeKind::Silhouette;
    drawing.layers.push(layer);
    let (after, travel) = ordered(&drawing);
    assert!((travel.lifted_mm() - 39.0).abs() < 1e-3, "{travel}");
    assert!((travel.drawn_mm() - 40.0 * 90.0).abs() < 1.0);
    let strokes = &after.layers[0].strokes;
    assert_eq!((strokes.len(), strokes.x.len()), (40, 120));
    for k in 0..40 {
        let p = strokes.points(k);
        let row = (strokes.id[k] * 7 % 40) as f32;
        // Down the page, every other line backwards, with all its values.
        assert_eq!(row, k as f32);
        let mut order = [0, 1, 2];
        if k % 2 == 1 {
            order.reverse();
        }
        for (i, j) in p.zip(order) {
            assert_eq!((strokes.x[i], strokes.width[i]), ([0.0, 5.0, 90.0][j], [0.1, 0.2, 0.3][j]));
            assert_eq!(strokes.depth[i], row + j as f32);
        }
        let kind = if strokes.id[k] == 3 { StrokeKind::Silhouette } else { StrokeKind::Crease };
        assert_eq!(strokes.kind[k], kind);
    }
}

#[test]
fn many_strokes_keep_their_points() {
    let mut drawing = Drawing::new(page(100), Color::WHITE);
    let mut layer = Layer { dots: dots(50), ..Layer::default() };
    layer.dots.x.iter_mut().for_each(|x| *x *= 0.03);
    layer.dots.y.iter_mut().for_each(|y| *y *= 0.1);
    let ends = random(4000, 100.0);
    for (i, p) in ends.iter().enumerate() {
        let length = (i % 5) as f32;
        let points = (0..1 + i % 4).map(|k| [p[0] + length * k as f32, p[1] + 0.5 * k as f32]);
        layer.strokes.push_line(StrokeKind::Border, i as u64, 0.2, points);
    }
    layer.strokes.push_line(StrokeKind::Border, 9998, 0.2, []);
    layer.strokes.push_line(StrokeKind::Border, 9999, 0.2, [[f32::NAN, 0.0], [1.0, 1.0]]);
    drawing.layers.push(layer);
    let (after, travel) = ordered(&drawing);
    let (before, after) = (&drawing.layers[0].strokes, &after.layers[0].strokes);
    assert_eq!(before.len(), after.len());
    let mut seen = vec![false; before.len()];
    for k in 0..after.len() {
        let from = before.id.iter().position(|id| *id == after.id[k]).unwrap();
        assert!(!std::mem::replace(&mut seen[from], true));
        let line = |s: &Strokes, k: usize| -> Vec<[u32; 2]> {
            s.points(k).map(|i| [s.x[i].to_bits(), s.y[i].to_bits()]).collect()
        };
        let (mut was, is) = (line(before, from), line(after, k));
        if was != is {
            was.reverse();
        }
        assert_eq!(was, is);
    }
    assert!(travel.lifted_mm() < 0.1 * travel.unordered_mm(), "{travel}");
}

#[test]
fn threads_make_no_difference() {
    let mut drawing = with_dots(100, &random(3000, 100.0));
    drawing.layers.push(drawing.layers[0].clone());
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| ordered(&drawing))
    };
    assert_eq!(with_threads(1), with_threads(3));
}

#[test]
fn a_bounded_effort_still_gives_a_whole_tour() {
    let points = random(5000, 100.0);
    for effort in [
        Effort { longest_reversal: 10, ..Effort::default() },
        Effort { longest_reversal: 0, ..Effort::default() },
        Effort { neighbours: 1, ..Effort::default() },
    ] {
        let drawing = with_dots(100, &points);
        let mut after = drawing.clone();
        let travel = order(&mut after, effort);
        assert_same_dots(&drawing.layers[0].dots, &after.layers[0].dots);
        assert!(travel.lifted_mm() < 0.7124 * 100.0 * 5000f64.sqrt() * 1.4);
    }
}
