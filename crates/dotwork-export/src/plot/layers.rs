//! One layer for each pen and colour.

use dotwork_drawing::{Drawing, Layer, Warnings};

/// Gathers the marks of `drawing` so that each layer is what one pen draws in one colour.
///
/// Colours come in the order in which they first appear, their pens from the smallest to the largest, layers without a
/// pen last. Marks keep their order. Images are left out and marks of partial strength get their full one, each with a
/// warning: a pen has one ink. See [`crate::assign_pens`] to choose pens first.
pub fn plotter_layers(drawing: &Drawing) -> (Drawing, Warnings) {
    let mut warnings = Warnings::new();
    let mut plot = Drawing::new(drawing.page, drawing.paper);
    let mut colors = Vec::new();
    for layer in &drawing.layers {
        if layer.image.is_some() {
            let what = "images left out: a pen cannot draw them";
            warnings.counted(what, 1, Some(format!("layer of {}", layer.object)));
        }
        if layer.dots.is_empty() && layer.strokes.is_empty() {
            continue;
        }
        if !colors.contains(&layer.color) {
            colors.push(layer.color);
        }
        let same = |l: &&mut Layer| l.color == layer.color && l.pen_mm == layer.pen_mm;
        match plot.layers.iter_mut().find(same) {
            Some(to) => append(to, layer),
            // All but the image, which may be large.
            None => plot.layers.push(Layer {
                object: layer.object.clone(),
                color: layer.color,
                pen_mm: layer.pen_mm,
                image: None,
                dots: layer.dots.clone(),
                strokes: layer.strokes.clone(),
            }),
        }
    }
    plot.layers.sort_by(|a, b| {
        let key = |l: &Layer| (colors.iter().position(|c| *c == l.color), l.pen_mm.unwrap_or(f32::INFINITY));
        let (a, b) = (key(a), key(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let (mut dots, mut strokes) = (0, 0);
    for layer in &mut plot.layers {
        for ink in layer.dots.ink.iter_mut().filter(|ink| **ink > 0.0 && **ink < 1.0) {
            dots += 1;
            *ink = 1.0;
        }
        for k in 0..layer.strokes.len() {
            let points = layer.strokes.points(k);
            let darkness = &mut layer.strokes.darkness[points];
            if darkness.iter().any(|&d| d > 0.0) && darkness.iter().any(|&d| d < 1.0) {
                strokes += 1;
                darkness.fill(1.0);
            }
        }
    }
    warnings.counted("dots of partial strength, which a pen draws in full", dots, None);
    warnings.counted("strokes of partial strength, which a pen draws in full", strokes, None);
    (plot, warnings)
}

fn append(to: &mut Layer, layer: &Layer) {
    if !to.object.split(", ").any(|name| name == layer.object) {
        to.object = format!("{}, {}", to.object, layer.object);
    }
    to.dots.extend_from(&layer.dots);
    to.strokes.extend_from(&layer.strokes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::dots;
    use dotwork_drawing::{Color, Image, Page, StrokeKind};

    #[test]
    fn layers_of_one_pen_and_colour_are_one() {
        let red = Color { r: 255, g: 0, b: 0 };
        let mut drawing = Drawing::new(Page::default(), Color::WHITE);
        for (k, (object, color, pen)) in [
            ("a", red, Some(0.3)),
            ("b", Color::BLACK, Some(0.2)),
            ("c", red, None),
            ("c", red, Some(0.2)),
            ("d", red, Some(0.3)),
        ]
        .into_iter()
        .enumerate()
        {
            let mut layer = Layer { object: object.into(), color, pen_mm: pen, ..Layer::default() };
            layer.dots = dots(k + 1);
            layer.dots.ink.fill(if k == 2 { 0.5 } else { 1.0 });
            layer.strokes.push_line(StrokeKind::Crease, k as u64, 1.0, vec![[k as f32, 0.0]; k + 2]);
            drawing.layers.push(layer);
        }
        drawing.layers.push(Layer::default());
        drawing.layers[1].image =
            Some(Image { width: 1, height: 1, place: [0.0, 0.0, 1.0, 1.0], samples: vec![[0.0; 4]] });
        let (plot, warnings) = plotter_layers(&drawing);
        let found: Vec<_> = plot.layers.iter().map(|l| (l.object.as_str(), l.color, l.pen_mm)).collect();
        assert_eq!(
            found,
            [
                ("c", red, Some(0.2)),
                ("a, d", red, Some(0.3)),
                ("c", red, None),
                ("b", Color::BLACK, Some(0.2))
            ]
        );
        let merged = &plot.layers[1];
        assert_eq!((merged.dots.len(), merged.strokes.id.as_slice()), (6, [0, 4].as_slice()));
        assert_eq!((merged.strokes.points(0), merged.strokes.points(1)), (0..2, 2..8));
        assert_eq!(merged.strokes.x[2..], [4.0; 6]);
        assert!(plot.layers.iter().all(|l| l.image.is_none() && l.dots.ink.iter().all(|&ink| ink == 1.0)));
        let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        assert_eq!(
            said,
            [
                "images left out: a pen cannot draw them (layer of b)",
                "3 dots of partial strength, which a pen draws in full"
            ]
        );
    }

    #[test]
    fn strokes_of_partial_strength_are_drawn_in_full() {
        let mut drawing = Drawing::new(Page::default(), Color::WHITE);
        let mut layer = Layer::default();
        for id in 0..4 {
            layer.strokes.push_line(StrokeKind::Crease, id, 1.0, [[1.0, 2.0], [3.0, 4.0]]);
        }
        // Whole, fading out, faint, not there at all.
        layer.strokes.darkness[2..].copy_from_slice(&[1.0, 0.0, 0.5, 0.5, 0.0, 0.0]);
        drawing.layers.push(layer);
        let (plot, warnings) = plotter_layers(&drawing);
        assert_eq!(plot.layers[0].strokes.darkness, [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
        let said: Vec<String> = warnings.iter().map(ToString::to_string).collect();
        assert_eq!(said, ["2 strokes of partial strength, which a pen draws in full"]);
    }
}
