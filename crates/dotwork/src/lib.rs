//! dotwork draws 3D data as stipple illustrations.
mod artist;
mod scene;

pub use artist::Artist;
pub use scene::{MAX_AUTO_STIPPLES, Object, Scene, Stipples};

pub use dotwork_drawing::{self as drawing, Camera, Color, Drawing, Length, Light, LightFrame, Page, UpAxis, Warnings};
pub use dotwork_ink::{self as ink, Style, preset};
pub use dotwork_mesh::{self as mesh, Mesh, MeshError, RawMesh};
pub use dotwork_render::{self as render, Raster, Rasterizer};
