//! One layer for each pen and colour.

use dotwork_drawing::{Drawing, Layer, Strokes, Warnings};

/// Gathers the marks of `drawing` so that each layer is what one pen draws in one colour.
///
/// Colours come in the order in which they first appear, their pens from the smallest to the largest, layers without a
/// pen last. Marks keep their order. Images are left out, with a warning, and marks of partial strength are said to be
/// drawn in full: a pen has one ink. See [`crate::assign_pens`] to choose pens first.
pub fn plotter_layers(drawing: &Drawing) -> (Drawing, Warnings) {
    let mut warnings = Warnings::new();
    let mut plot = Drawing::new(drawing.page, drawing.paper);
    let mut colors = Vec::new();
    for layer in &drawing.layers {
        if layer.image.is_some() {
            let what = "image left out: a pen cannot draw it";
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
            None => plot.layers.push(Layer { image: None, ..layer.clone() }),
        }
    }
    plot.layers.sort_by(|a, b| {
        let key = |l: &Layer| (colors.iter().position(|c| *c == l.color), l.pen_mm.unwrap_or(f32::INFINITY));
        let (a, b) = (key(a), key(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut partial = 0;
    for layer in &mut plot.layers {
        for ink in layer.dots.ink.iter_mut().filter(|ink| **ink > 0.0 && **ink < 1.0) {
            partial += 1;
            *ink = 1.0;
        }
    }
    warnings.counted("dots of partial strength, which a pen draws in full", partial, None);
    (plot, warnings)
}

fn append(to: &mut Layer, layer: &Layer) {
    if !to.object.split(", ").any(|name| name == layer.object) {
        to.object = format!("{}, {}", to.object, layer.object);
    }
    to.dots.extend_from(&layer.dots);
    let base = to.strokes.x.len() as u32;
    let Strokes { x, y, depth, width, darkness, end, id, kind } = &layer.strokes;
    to.strokes.x.extend_from_slice(x);
    to.strokes.y.extend_from_slice(y);
    to.strokes.depth.extend_from_slice(depth);
    to.strokes.width.extend_from_slice(width);
    to.strokes.darkness.extend_from_slice(darkness);
    to.strokes.end.extend(end.iter().map(|end| base + end));
    to.strokes.id.extend_from_slice(id);
    to.strokes.kind.extend_from_slice(kind);
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
                "image left out: a pen cannot draw it (layer of b)",
                "3 dots of partial strength, which a pen draws in full"
            ]
        );
    }
}
