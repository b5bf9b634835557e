//! Built-in shapes: analytic ones whose areas, normals and curvatures are known in closed form, and the demos.
//!
//! All face outwards (or, where open, towards the side named), share vertices between neighbours, and stand with +y up
//! where they have an up. [`DEMOS`] lists those that the command offers as `demo:NAME`.

mod grid;
mod implicit;
mod jelly;
mod plate;
mod ribbon;
mod solids;
mod teapot;

pub use jelly::jelly;
pub use plate::{plate, plate_irregular};
pub use ribbon::{RIBBON_GENUS, ribbon};
pub use solids::{cylinder, sheet, sphere, torus};
pub use teapot::teapot;

use std::sync::Arc;

use crate::{Motion, RawMesh};

/// A built-in input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Demo {
    /// The name, as in `demo:NAME`.
    pub name: &'static str,
    /// One line that says what it is.
    pub summary: &'static str,
}

/// The built-in inputs, best first.
pub const DEMOS: &[Demo] = &[
    Demo {
        name: "ribbon",
        summary: "a fluted, pierced band of three half turns: folds, openings, every curvature",
    },
    Demo { name: "teapot", summary: "the Utah teapot (Martin Newell, 1975) from its Bezier patches" },
    Demo { name: "jelly", summary: "the bell of a jellyfish; it swims, for films" },
    Demo { name: "sphere", summary: "a sphere of radius 1" },
    Demo { name: "torus", summary: "a torus of radii 1 and 0.4" },
    Demo { name: "plate", summary: "a flat square of side 1 that faces the front view" },
];

/// The demo called `name`, or `None` if there is none. All but the ribbon (about half a second) take milliseconds.
pub fn demo(name: &str) -> Option<RawMesh> {
    match name {
        "ribbon" => Some(ribbon()),
        "teapot" => Some(teapot()),
        "jelly" => Some(jelly()),
        "sphere" => Some(sphere(6)),
        "torus" => Some(torus(1.0, 0.4, 256, 128)),
        "plate" => Some(plate(64, 64)),
        _ => None,
    }
}

/// What moves the demo called `name`, or `None` if nothing does.
pub fn motion(name: &str) -> Option<Arc<dyn Motion>> {
    (name == "jelly").then(|| Arc::new(jelly::Swim::new()) as Arc<dyn Motion>)
}

/// A raw mesh of triangles about the origin.
fn raw(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> RawMesh {
    let polygons = triangles.len();
    RawMesh { positions, triangles, polygons, ..RawMesh::default() }
}
