//! Triangle meshes: what readers hand over, how it is put in order, and the built-in demo shapes.
//!
//! A reader fills a [`RawMesh`]; [`Mesh::build`] cleans it (welding, degenerate and duplicate triangles, unused
//! vertices, winding), finds its topology and its normals, and says in [`dotwork_drawing::Warnings`] what it changed.
//! A [`MovingMesh`] takes the poses that a [`Motion`] gives it; its triangles stay.
//! [`Topology`] answers who neighbours whom; [`shapes`] makes analytic shapes for tests and the demos.
//! This crate knows nothing of ink, files or devices.
//!
//! ```
//! use dotwork_drawing::Warnings;
//! use dotwork_mesh::{Mesh, MeshOptions, shapes};
//!
//! let mut warnings = Warnings::new();
//! let mesh = Mesh::build(shapes::sphere(4), &MeshOptions::default(), &mut warnings)?;
//! assert!(mesh.closed && warnings.is_empty());
//! assert!((mesh.area() / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.01);
//! # Ok::<(), dotwork_mesh::MeshError>(())
//! ```

mod borders;
mod clean;
mod clip;
mod creases;
mod geometry;
mod hierarchy;
mod measure;
mod mesh;
mod motion;
mod normals;
mod paint;
pub mod shapes;
pub mod topology;
mod winding;

pub use clip::{ClipBox, ClipError, ClipPlane, ClipRegion, ClipRule, clip};
pub use creases::{Crease, Creases};
pub use hierarchy::{Hierarchy, HierarchySettings, SPREAD, hierarchy};
pub use measure::{Bounds, MeshStats};
pub use mesh::{InOrder, Mesh, MeshError, MeshOptions, RawMesh};
pub use motion::{Clip, Motion, MovingMesh, area_of};
pub use paint::{Alpha, Material, Paint, Picture, Wrap};
pub use topology::Topology;
