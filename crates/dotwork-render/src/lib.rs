//! A camera looks at inked objects: visibility, selection, and the CPU backend, which is the readable reference.
//!
//! ```text
//! Subject (mesh, stock, InkPlan) ─┐
//! View, light ────────────────────┼─▶ CpuBackend::frame ──▶ Drawing ──▶ Raster
//! depth prepass ──────────────────┘      tone → select → hide → dots
//! ```
//!
//! Everything here is a pure function of its inputs: the same scene gives the same bytes on any number of threads.

mod backend;
mod bands;
mod covered;
mod depth;
mod elements;
mod fill;
mod hiding;
mod layers;
mod outline;
mod plan;
mod raster;
mod relevance;
mod same;
mod select;
mod veil;

pub use backend::{CpuBackend, Frame, Needed, Subject};
pub use depth::DepthBuffer;
pub use plan::InkPlan;
pub use raster::{Raster, Rasterizer};
