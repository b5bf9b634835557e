//! Drawings for this crate's tests.

use dotwork_drawing::{Color, Dots, Drawing, Layer, Page, hash};

/// `n` dots such as a drawing holds.
pub(crate) fn dots(n: usize) -> Dots {
    let random = |stream: u32| (0..n as u32).map(move |i| hash::unit(hash::hash2(i, stream)));
    Dots {
        x: random(0).map(|u| u * 3000.0 - 3.0).collect(),
        y: random(1).map(|u| u * 1024.0).collect(),
        depth: random(2).map(|u| 2.0 + u).collect(),
        radius: random(3).map(|u| 1.5 * u).collect(),
        size: random(4).collect(),
        ink: random(5).collect(),
        id: (0..n as u32).map(|i| u64::from(hash::mix(i)) << 21 | u64::from(i)).collect(),
        stipple: (0..n as u32).rev().collect(),
    }
}

/// Three layers, one of them empty, whose names ask for quotes and escapes.
pub(crate) fn drawing() -> Drawing {
    let mut drawing = Drawing::new(Page::default(), Color::WHITE);
    for (object, n, color) in [
        ("left, \"upper\"\nlobe", 300, Color { r: 200, g: 0, b: 17 }),
        ("empty", 0, Color::WHITE),
        ("Schädel \\ 2", 50, Color::BLACK),
    ] {
        drawing.layers.push(Layer { object: object.into(), color, dots: dots(n), ..Layer::default() });
    }
    drawing
}
