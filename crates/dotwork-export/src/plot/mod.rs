//! For the pen plotter: layers by pen, marks in an order that spares travel, and the travel in words.
//!
//! [`plotter_layers`] gathers what one pen draws in one colour; [`order_for_plotter`] orders each layer: dots, then
//! strokes, each as one tour without return. A tour starts along a Hilbert curve (about 25 % longer than the best) and is
//! improved by 2-opt and Or-opt moves between near neighbours until none is left (about 5 %). A stroke is two places that
//! stay together, so that the same moves also turn it round.
//!
//! ```
//! use dotwork_drawing::{Color, Drawing, Layer, Page, StrokeKind};
//! use dotwork_export::{SvgOptions, assign_pens, plot, write_svg};
//!
//! let mut drawing = Drawing::new(Page::millimetres(100.0, 100.0, 254.0)?, Color::WHITE);
//! let mut layer = Layer::default();
//! layer.strokes.push_line(StrokeKind::Crease, 1, 3.0, [[900.0, 0.0], [100.0, 0.0]]);
//! drawing.layers.push(layer);
//!
//! let (drawing, lost) = assign_pens(&drawing, &[0.18, 0.35])?;
//! let (mut drawing, left_out) = plot::plotter_layers(&drawing);
//! assert!(lost.is_empty() && left_out.is_empty());
//! let travel = plot::order_for_plotter(&mut drawing);
//! // The pen starts at the top left: the stroke is drawn backwards.
//! let line = "pen 0.35 mm #000000: 1 stroke of 0.08 m in all, 0.00 m in the air and 0.01 m to the first \
//!     (unordered 0.09 m)";
//! assert_eq!(travel.to_string(), line);
//! let mut file = Vec::new();
//! write_svg(&mut file, &drawing, &SvgOptions::for_plotter())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod hilbert;
mod improve;
mod layers;
mod near;
mod order;
mod travel;

pub use self::layers::plotter_layers;
pub use self::order::order_for_plotter;
pub use self::travel::{LayerTravel, Travel};
