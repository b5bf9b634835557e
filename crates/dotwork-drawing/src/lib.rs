//! The common ground of dotwork: what every other crate speaks about.
//!
//! * [`Page`] and [`Length`]: how large the picture is, in pixels and in millimetres;
//! * [`Camera`] and [`View`]: where the eye stands, and the projection that follows;
//! * [`Light`]: where the light comes from, relative to the viewer or to the object;
//! * [`Color`]: sRGB colours and linear light; [`ColorSpace`] and [`Palette`]: how they are mixed;
//! * [`Drawing`], [`Layer`], [`Dots`]: the finished picture as marks on a page, which raster, vector, film and
//!   window all consume;
//! * [`hash`]: randomness as a pure function of integers;
//! * [`lettering`]: words in single strokes, for scale bars;
//! * [`Warnings`]: what a library has to say, collected and returned, never printed.
//!
//! This crate knows nothing of meshes, files, devices or windows.

pub mod camera;
pub mod color;
pub mod color_space;
pub mod hash;
pub mod lettering;
pub mod light;
pub mod marks;
pub mod page;
pub mod palette;
pub mod warnings;

pub use camera::{Camera, Lens, Projection, Standpoint, UpAxis, View};
pub use color::Color;
pub use color_space::ColorSpace;
pub use light::{Light, LightFrame};
pub use marks::{Dots, Drawing, Image, Layer, StrokeKind, Strokes};
pub use page::{Length, MAX_SIDE_PX, Page, Unit};
pub use palette::Palette;
pub use warnings::{Warning, Warnings};
