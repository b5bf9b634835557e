//! A drawing for pens of given sizes.
//!
//! A pen draws one size of dot at full strength. A dot whose ink (area times strength) lies between two pens takes the
//! larger with the probability that keeps the mean: `(a − a₁) / (a₂ − a₁)`, decided by a hash of its id, so that the
//! same stipple has the same pen in every frame. Below the smallest pen a dot is drawn with probability `a / a₁`; above
//! the largest it loses ink, and a warning says how many.

use std::f64::consts::PI;

use dotwork_drawing::hash::{hash3, unit};
use dotwork_drawing::{Dots, Drawing, Layer, Strokes, Warnings};
use thiserror::Error;

/// The stream of random numbers that chooses between pens.
const STREAM: u32 = 0x7065_6e73;

/// A dot larger than the largest pen by less than this share of its area is not worth a warning.
const LARGER: f64 = 1.01;

/// Why a drawing cannot be assigned to pens.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PenError {
    /// The list of pens is empty.
    #[error("no pen is named; write for example 0.18,0.25,0.35")]
    None,
    /// A pen has no usable size.
    #[error("a pen of {mm} mm cannot be used; its diameter is between 0.01 mm and 100 mm")]
    Size {
        /// The diameter asked for.
        mm: f32,
    },
}

/// Assigns every dot and stroke of `drawing` to one of the pens of diameter `pens_mm` (millimetres, any order).
///
/// Each layer becomes one layer a pen, from the smallest to the largest, with [`Layer::pen_mm`] set; layers without marks
/// are left out. All dots have their pen's diameter and full strength, and keep their ids and their order; so does the
/// mean ink. A stroke takes the pen nearest to its mean width times darkness. An image stays on a layer of its own below.
/// Dots without size, ink or finite places are dropped.
///
/// # Errors
/// If there is no pen, or one is not between 0.01 mm and 100 mm.
///
/// # Panics
/// If the arrays of a layer's dots or strokes differ in length.
pub fn assign_pens(drawing: &Drawing, pens_mm: &[f32]) -> Result<(Drawing, Warnings), PenError> {
    if let Some(&mm) = pens_mm.iter().find(|mm| !(0.01..=100.0).contains(*mm)) {
        return Err(PenError::Size { mm });
    }
    let mut pens = pens_mm.to_vec();
    pens.sort_by(f32::total_cmp);
    pens.dedup();
    if pens.is_empty() {
        return Err(PenError::None);
    }
    let mm_per_px = f64::from(drawing.page.mm_per_px());
    let mut assigned = Drawing::new(drawing.page, drawing.paper);
    let mut larger = (0, None);
    for layer in &drawing.layers {
        let blank =
            |pen_mm| Layer { object: layer.object.clone(), color: layer.color, pen_mm, ..Layer::default() };
        if layer.image.is_some() {
            assigned.layers.push(Layer { image: layer.image.clone(), ..blank(None) });
        }
        let mut layers: Vec<Layer> = pens.iter().map(|&mm| blank(Some(mm))).collect();
        assign_dots(&layer.dots, &pens, mm_per_px, &mut layers, |id| {
            larger.0 += 1;
            larger.1.get_or_insert_with(|| format!("dot {id} of {}", layer.object));
        });
        assign_strokes(&layer.strokes, &pens, mm_per_px, &mut layers);
        assigned.layers.extend(layers.into_iter().filter(|l| !l.dots.is_empty() || !l.strokes.is_empty()));
    }
    let mut warnings = Warnings::new();
    let what = if larger.0 == 1 {
        "dot larger than the largest pen: its ink is lost"
    } else {
        "dots larger than the largest pen: their ink is lost"
    };
    warnings.counted(what, larger.0, larger.1);
    Ok((assigned, warnings))
}

fn assign_dots(
    dots: &Dots,
    pens: &[f32],
    mm_per_px: f64,
    layers: &mut [Layer],
    mut too_large: impl FnMut(u64),
) {
    let area = |mm: f64| 0.25 * PI * mm * mm;
    let largest = area(f64::from(pens[pens.len() - 1]));
    for i in 0..dots.len() {
        let radius = dots.radius[i];
        let ink = f64::from(dots.ink[i].min(1.0));
        let wanted = area(2.0 * f64::from(radius) * mm_per_px) * ink;
        let placed = dots.x[i].is_finite() && dots.y[i].is_finite();
        if !(placed && wanted > 0.0 && wanted.is_finite() && radius > 0.0 && dots.ink[i] > 0.0) {
            continue;
        }
        if wanted > largest * LARGER {
            too_large(dots.id[i]);
        }
        // The pens next below (none: a dot of no area) and above.
        let above = pens.partition_point(|&mm| area(f64::from(mm)) <= wanted);
        let below = above.checked_sub(1);
        let pen = if above == pens.len() {
            pens.len() - 1
        } else {
            let a = below.map_or(0.0, |pen| area(f64::from(pens[pen])));
            let share = (wanted - a) / (area(f64::from(pens[above])) - a);
            let random = unit(hash3(dots.id[i] as u32, (dots.id[i] >> 32) as u32, STREAM));
            match below {
                _ if f64::from(random) < share => above,
                Some(below) => below,
                None => continue,
            }
        };
        let drawn = (0.5 * f64::from(pens[pen]) / mm_per_px) as f32;
        let to = &mut layers[pen].dots;
        to.x.push(dots.x[i]);
        to.y.push(dots.y[i]);
        to.depth.push(dots.depth[i]);
        to.radius.push(drawn);
        // Still the radius over the style's full radius.
        to.size.push(dots.size[i] * (drawn / radius));
        to.ink.push(1.0);
        to.id.push(dots.id[i]);
        to.stipple.push(dots.stipple[i]);
    }
}

fn assign_strokes(strokes: &Strokes, pens: &[f32], mm_per_px: f64, layers: &mut [Layer]) {
    for k in 0..strokes.len() {
        let points = strokes.points(k);
        let usable = |i: &usize| {
            [strokes.x[*i], strokes.y[*i], strokes.width[*i], strokes.darkness[*i]]
                .iter()
                .all(|v| v.is_finite())
        };
        let (mut sum, mut count) = (0.0, 0.0);
        for i in points.clone().filter(usable) {
            sum += f64::from(strokes.width[i]) * f64::from(strokes.darkness[i].clamp(0.0, 1.0));
            count += 1.0;
        }
        let wanted = sum / count * mm_per_px;
        if wanted.is_nan() || wanted <= 0.0 {
            continue;
        }
        let off = |pen: usize| (f64::from(pens[pen]) - wanted).abs();
        let pen = (1..pens.len()).fold(0, |best, pen| if off(pen) < off(best) { pen } else { best });
        let width = (f64::from(pens[pen]) / mm_per_px) as f32;
        let to = &mut layers[pen].strokes;
        for i in points {
            to.x.push(strokes.x[i]);
            to.y.push(strokes.y[i]);
            to.depth.push(strokes.depth[i]);
            to.width.push(width);
            to.darkness.push(1.0);
        }
        to.end.push(to.x.len() as u32);
        to.id.push(strokes.id[k]);
        to.kind.push(strokes.kind[k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{dots, drawing};
    use dotwork_drawing::{Color, Image, Page, StrokeKind};

    fn one_layer(dots: Dots) -> Drawing {
        let mut drawing = Drawing::new(Page::default(), Color::WHITE);
        drawing.layers.push(Layer { object: "bunny".into(), dots, ..Layer::default() });
        drawing
    }

    /// Sum of area times strength, mm².
    fn ink(drawing: &Drawing) -> f64 {
        let mm_per_px = f64::from(drawing.page.mm_per_px());
        let dots = drawing.layers.iter().map(|l| &l.dots);
        dots.flat_map(|d| d.radius.iter().zip(&d.ink))
            .map(|(&r, &ink)| PI * (f64::from(r) * mm_per_px).powi(2) * f64::from(ink))
            .sum()
    }

    #[test]
    fn mean_ink_is_kept() {
        // Diameters from 0 to 0.254 mm, strengths from 0 to 1.
        let drawing = one_layer(dots(20_000));
        for pens in [vec![0.1, 0.18, 0.26], vec![0.26, 0.05, 0.1, 0.1], vec![0.3]] {
            let (assigned, warnings) = assign_pens(&drawing, &pens).unwrap();
            assert!(warnings.is_empty(), "{warnings:?}");
            let ratio = ink(&assigned) / ink(&drawing);
            // With one pen much larger than the dots a tenth of them is drawn: the mean of 2000 has more noise.
            let tolerance = if pens.len() == 1 { 0.03 } else { 0.01 };
            assert!((ratio - 1.0).abs() < tolerance, "{pens:?}: {ratio}");
            assert_eq!(assign_pens(&drawing, &pens).unwrap().0, assigned);
        }
    }

    #[test]
    fn a_layer_for_each_pen() {
        let drawing = one_layer(dots(5_000));
        let (assigned, _) = assign_pens(&drawing, &[0.25, 0.1, 0.18]).unwrap();
        let pens: Vec<f32> = assigned.layers.iter().map(|l| l.pen_mm.unwrap()).collect();
        assert_eq!(pens, [0.1, 0.18, 0.25]);
        let from = &drawing.layers[0].dots;
        for layer in &assigned.layers {
            assert_eq!(layer.object, "bunny");
            let d = &layer.dots;
            assert!(d.len() > 100);
            let mut rows = 0..from.len();
            for i in 0..d.len() {
                let diameter = 2.0 * d.radius[i] * drawing.page.mm_per_px();
                assert!((diameter - layer.pen_mm.unwrap()).abs() < 1e-6);
                assert_eq!(d.ink[i], 1.0);
                // In drawing order, the same stipple in the same place.
                let row = rows.find(|&row| from.id[row] == d.id[i]).unwrap();
                assert_eq!((d.x[i], d.y[i], d.stipple[i]), (from.x[row], from.y[row], from.stipple[row]));
                let scale = d.radius[i] / from.radius[row];
                assert!((d.size[i] - from.size[row] * scale).abs() <= 1e-5 * d.size[i]);
            }
        }
    }

    #[test]
    fn dots_of_a_pens_size_keep_it() {
        let mut all = dots(500);
        let radius = 0.5 * 0.25 / Page::default().mm_per_px();
        all.radius.fill(radius);
        all.ink.fill(1.0);
        let (assigned, warnings) = assign_pens(&one_layer(all), &[0.18, 0.25]).unwrap();
        assert!(warnings.is_empty());
        // The last place of `f32` may send a stray one to the smaller pen, no more.
        let kept = assigned.layers.iter().find(|l| l.pen_mm == Some(0.25)).unwrap();
        assert!(kept.dots.len() >= 499);
    }

    #[test]
    fn larger_dots_are_counted() {
        let mut all = dots(10);
        all.radius.fill(5.0);
        all.ink.fill(1.0);
        all.ink[3] = 1e-4;
        let (assigned, warnings) = assign_pens(&one_layer(all.clone()), &[0.1]).unwrap();
        let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        let place = format!("first at dot {} of bunny", all.id[0]);
        assert_eq!(said, [format!("9 dots larger than the largest pen: their ink is lost, {place}")]);
        assert!(assigned.dot_count() >= 9);
    }

    #[test]
    fn strokes_take_the_nearest_pen() {
        let mut drawing = drawing();
        drawing.layers.truncate(1);
        drawing.layers[0].dots.clear();
        let strokes = &mut drawing.layers[0].strokes;
        let px = |mm: f32| mm / Page::default().mm_per_px();
        for (id, mm) in [(1, 0.19), (2, 0.9), (3, 0.01), (4, 0.0), (5, 0.4)] {
            strokes.push_line(StrokeKind::Crease, id, px(mm), [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]);
        }
        // Half the darkness is half the width.
        strokes.darkness[12..].fill(0.5);
        drawing.layers[0].image =
            Some(Image { width: 1, height: 1, place: [0.0, 0.0, 1.0, 1.0], samples: vec![[0.0; 4]] });
        let (assigned, _) = assign_pens(&drawing, &[0.18, 0.35, 0.7]).unwrap();
        let ids: Vec<_> = assigned.layers.iter().map(|l| (l.pen_mm, l.strokes.id.clone())).collect();
        assert_eq!(ids, [(None, vec![]), (Some(0.18), vec![1, 3, 5]), (Some(0.7), vec![2])]);
        assert!(assigned.layers[0].image.is_some());
        let strokes = &assigned.layers[1].strokes;
        assert_eq!((strokes.end.as_slice(), strokes.x.len()), ([3, 6, 9].as_slice(), 9));
        assert!(strokes.width.iter().all(|w| (w - px(0.18)).abs() < 1e-6));
        assert!(strokes.darkness.iter().all(|&d| d == 1.0));
    }

    #[test]
    fn pens_that_are_none() {
        assert_eq!(assign_pens(&drawing(), &[]), Err(PenError::None));
        for mm in [0.0, -0.2, f32::INFINITY, 1e9] {
            assert_eq!(assign_pens(&drawing(), &[0.2, mm]), Err(PenError::Size { mm }));
        }
        assert!(matches!(assign_pens(&drawing(), &[f32::NAN]), Err(PenError::Size { mm }) if mm.is_nan()));
    }

    #[test]
    fn hostile_marks_are_dropped() {
        let mut all = dots(6);
        all.ink.fill(1.0);
        all.radius.fill(1.0);
        (all.x[0], all.y[1], all.radius[2], all.ink[3], all.radius[4], all.radius[5]) =
            (f32::NAN, f32::INFINITY, f32::NAN, f32::NAN, -1.0, f32::INFINITY);
        let mut drawing = one_layer(all);
        drawing.layers[0].strokes.push_line(StrokeKind::Border, 1, f32::NAN, [[0.0, 0.0]]);
        drawing.layers[0].strokes.push_line(StrokeKind::Border, 2, 1.0, []);
        let (assigned, warnings) = assign_pens(&drawing, &[0.1]).unwrap();
        assert_eq!((assigned.layers.len(), warnings.is_empty()), (0, true));
    }
}
