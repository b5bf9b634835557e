//! Frames a second as in the table of Lu et al. 2002: stipples alone, and with lines and what hides.
//!
//! A frame is everything from the scene to the picture's samples. While the view stands the light goes on by a degree a
//! frame, so that every tone is made anew and nothing that hides is; while it turns, everything is.

use dotwork::ink::{Factors, Visibility};
use dotwork::{Artist, Color, Drawing, Raster, Rasterizer, Scene, Style};
use serde_json::{Value, json};

use super::{Cost, FRAMES, TURN, median};

/// Turn of the light from frame to frame while the view stands, degrees.
const LIGHT_TURN: f32 = 1.0;

/// What is drawn of a scene.
#[derive(Clone, Copy)]
pub(super) enum Drawn {
    /// Dots, of which only those that face away are left out.
    Stipples,
    /// Every enhancement, lines, and without what is hidden.
    Everything,
}

/// Both, in the order of the table.
pub(super) const DRAWN: [Drawn; 2] = [Drawn::Stipples, Drawn::Everything];

impl Drawn {
    /// Its name in JSON.
    fn key(self) -> &'static str {
        match self {
            Drawn::Stipples => "stipples",
            Drawn::Everything => "everything",
        }
    }

    /// Its name in the table.
    pub fn words(self) -> &'static str {
        match self {
            Drawn::Stipples => "stipples alone",
            Drawn::Everything => "with lines, hiding, everything",
        }
    }

    /// A style in which just this is drawn.
    pub fn style(self, style: &Style) -> Style {
        match self {
            Drawn::Stipples => Style {
                outlines: false,
                curves: false,
                visibility: match style.visibility {
                    Visibility::Through => Visibility::Through,
                    Visibility::Facing | Visibility::Solid => Visibility::Facing,
                },
                ..style.clone()
            },
            Drawn::Everything => everything(style),
        }
    }
}

/// A style with every enhancement, its lines, and with what hides: of the papers' factors those that are off are on.
pub(super) fn everything(style: &Style) -> Style {
    let on = |share: f32| if share > 0.0 { share } else { 1.0 };
    let papers = style.factors == Factors::Papers;
    let style = Style { outlines: true, curves: papers, visibility: Visibility::Solid, ..style.clone() };
    if !papers {
        return style;
    }
    Style {
        boundary: true,
        silhouette: on(style.silhouette),
        resolution: on(style.resolution),
        lighting: true,
        distance: on(style.distance),
        interior: true,
        ..style
    }
}

/// What was measured of one way of drawing, at one size.
pub(super) struct Rate {
    drawn: Drawn,
    dots: usize,
    strokes: usize,
    /// Medians over the frames.
    standing: Cost,
    turning: Cost,
}

impl Rate {
    /// Measures it. The scene is baked.
    pub fn measure(scene: &Scene, drawn: Drawn) -> Rate {
        let mut scene = scene.clone();
        for object in &mut scene.objects {
            object.style = drawn.style(&object.style);
        }
        let (mut artist, mut rasterizer) = (Artist::new(), Rasterizer::new());
        let mut drawing = Drawing::new(scene.page, Color::WHITE);
        let mut raster = Raster::default();
        let mut frame = |scene: &Scene| {
            artist.draw_into(scene, &mut drawing);
            rasterizer.draw(&drawing, &mut raster);
            let strokes = drawing.layers.iter().map(|layer| layer.strokes.len()).sum();
            (drawing.dot_count(), strokes)
        };
        let (dots, strokes) = frame(&scene);
        // What is made once for many frames is made in the second.
        frame(&scene);
        let mut many = |step: fn(&mut Scene)| {
            let cost = |_| {
                step(&mut scene);
                Cost::of(|| frame(&scene)).0
            };
            median((0..FRAMES).map(cost).collect())
        };
        let standing = many(|scene| scene.light.azimuth += LIGHT_TURN);
        let turning = many(|scene| scene.camera.azimuth += TURN);
        Rate { drawn, dots, strokes, standing, turning }
    }

    /// Rows of the table: what, and how much.
    pub fn rows(&self) -> Vec<(String, String)> {
        let rate = |cost: Cost| format!("{:.0}", 1.0 / cost.wall.max(1e-9));
        let name = self.drawn.words();
        vec![
            (format!("  {name}: frames a second, view standing"), rate(self.standing)),
            (format!("  {name}: frames a second, view turning"), rate(self.turning)),
        ]
    }

    pub fn json(&self) -> Value {
        let one = |cost: Cost| {
            let mut value = cost.json();
            value["frames_per_s"] = json!(1.0 / cost.wall.max(1e-9));
            value
        };
        json!({
            "drawn": self.drawn.key(), "dots": self.dots, "strokes": self.strokes,
            "view_standing": one(self.standing), "view_turning": one(self.turning),
        })
    }
}
