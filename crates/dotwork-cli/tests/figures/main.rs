//! The figures by which a picture is judged, measured on what the command writes: PNG and CSV.
//!
//! Each test states its aim. The oracles are analytic: a sphere's shading, a plate's tilt, the hexagonal spacing.

#![allow(clippy::print_stdout, reason = "the figures are for reading: run with --nocapture")]

mod faces;
mod films;
#[path = "../common/gltf.rs"]
mod gltf;
mod hierarchy;
mod measure;
mod surfaces;
mod volumes;
