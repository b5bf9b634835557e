//! The heart of dotwork: parameters, tones, bakes and calibrated ink, as pure functions over a [`Surface`].
//!
//! The one idea: *a stipple is a point with a radius; a frame asks each place for a spacing*, and a stipple is drawn
//! where its radius is at least the spacing asked for. A [bake] makes the points and their radii, a
//! [`Tone`] answers in ink, and [`DensityTable`] and [`Coverage`] turn ink into spacing.
//!
//! ```text
//! ink ──Coverage──▶ ink area per page area ──·|n·E| / πr²──▶ density on the surface ──DensityTable──▶ spacing
//! ```

pub mod bake;
pub mod calibrate;
pub mod coloring;
mod coverage;
#[allow(clippy::approx_constant, reason = "measured numbers may come close to any constant")]
mod coverage_table;
mod density;
pub mod lines;
mod params;
mod presets;
mod stock;
mod surface;
pub mod tone;

pub use bake::{BakeSettings, HierarchySettings, MAX_STIPPLES, blue_noise, hierarchy};
pub use coloring::ColorTable;
pub use coverage::{Coverage, covered};
pub use density::{Arrival, DensityTable};
pub use params::{
    BakeMethod, Clip, Coloring, Crop, CurvesMethod, Factors, Fade, FeatureChoice, Fill, Fraction,
    GradientMin, Inked, Keep, Kind, LineMethod, OutlineColor, PARAMS, PaletteChoice, Param, Rank, Relevance,
    Role, SilhouetteForm, SizeMax, Style, SurfaceChoice, TwoSided, Visibility, Window, find_param,
};
pub use presets::{PRESETS, Preset, preset};
pub use stock::{Baked, Carrier, Elements, Faces, Stock, Vectors};
pub use surface::{MeshSurface, Place, StageDraw, Surface};
pub use tone::{Lit, PapersTone, Tone};
