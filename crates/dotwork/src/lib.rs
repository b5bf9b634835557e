//! dotwork draws 3D data as stipple illustrations.
//!
//! Ten lines draw a mesh:
//!
//! ```
//! use dotwork::{Page, Scene, Stipples, Warnings, preset};
//!
//! let style = preset("hard").expect("a preset of this name");
//! let mut warnings = Warnings::new();
//! let raw = dotwork::mesh::shapes::demo("teapot").expect("a demo of this name");
//! let object = dotwork::Object::new("teapot", raw, style, &mut warnings)?;
//! let mut scene = Scene { page: Page::pixels(400, 400)?, stipples: Stipples::Count(20_000), ..Scene::of(object) };
//! scene.camera.set_direction("-30,20")?;
//! let drawing = scene.draw();
//! assert!(drawing.dot_count() > 1000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! With files (feature `files`, on by default) the mesh comes from disk and the drawing goes there:
//!
//! ```
//! # #[cfg(feature = "files")] {
//! use dotwork::{Format, Style, Warnings, open, write_drawing};
//!
//! let mut warnings = Warnings::new();
//! let mut scene = open("demo:torus", &Style::default(), &mut warnings)?; // or "bunny.ply", or "bunny.dots"
//! let drawing = scene.draw();
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("torus.png");
//! write_drawing(&path, Format::Png, &drawing, &scene, &mut warnings)?;
//! # }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The one idea
//!
//! A stipple is a point with a radius; a frame asks each place for a spacing; a stipple is drawn where its radius is at
//! least the spacing asked for. [`Scene::bake`] makes the stipples, once; a [`Style`] says how much ink a place asks
//! for; an [`Artist`] draws frame after frame, and what is drawn is a [`Drawing`]: dots on a page, the same for pixels
//! and for tables.
//!
//! ```text
//! open ──▶ Scene ──bake──▶ stipples ──Artist::draw──▶ Drawing ──write_drawing──▶ svg, pdf, png, …
//! ```
//!
//! # Where things are
//!
//! | looking for | see |
//! |---|---|
//! | what is drawn, from where, on what page | [`Scene`], [`Object`], [`Camera`], [`Light`], [`Page`] |
//! | how it is drawn | [`Style`], [`preset()`], [`ink::PARAMS`], the table of all parameters |
//! | more than one picture | [`Artist`], [`Rasterizer`] |
//! | files | `open`, `load`, `save_dots`, `read_style`, `write_drawing` |
//! | the parts | [`drawing`], [`mesh`], [`ink`], [`render`], and with files `io` and `export` |
//!
//! # Features
//!
//! * `files` (default): reads `.dots` files, style files, plates and raw volumes; writes SVG, PDF, PNG, TIFF, CSV and JSON.
//! * `formats` (default): every input format; each is a feature of its own: `ply`, `obj`, `stl`, `off`, `gltf`, `nrrd`,
//!   `bzip2`, `nifti`, `metaimage`, `vtk`, `tiff`.

mod artist;
mod bake_warnings;
mod curves;
#[cfg(feature = "files")]
mod dots_file;
mod endless;
mod faces;
#[cfg(feature = "files")]
mod files;
mod film;
mod moving;
#[cfg(feature = "files")]
mod palette_file;
mod placement;
mod scale_bar;
mod scene;
#[cfg(feature = "files")]
mod scene_file;
#[cfg(feature = "files")]
mod settings;
#[cfg(feature = "files")]
mod style_file;
mod timeline;
mod voxels;

pub use artist::{Artist, SCALE_BAR};
#[cfg(feature = "files")]
pub use dots_file::{Described, encode_dots, save_dots, settings_text};
#[cfg(feature = "files")]
pub use files::{
    FileError, FilmFormat, FilmPath, Format, LoadOptions, Loaded, Look, Meaning, MeshFile, Outlook, Plate,
    Stage, VolumeInput, Watch, draw_film, encode_drawing, encode_film, encode_frames, load, load_with, open,
    prepare, rasterize, write_drawing,
};
pub use film::{Film, FilmOptions, MAX_FRAMES};
pub use moving::{Density, Moving, Pose};
#[cfg(feature = "files")]
pub use palette_file::{PaletteError, resolve_palette};
pub use placement::Placement;
pub use scale_bar::ScaleBar;
pub use scene::{MAX_AUTO_STIPPLES, Object, Scene, Source, Stipples, World, ZOOM};
#[cfg(feature = "files")]
pub use scene_file::{SceneFile, SceneObject, read_scene_file};
#[cfg(feature = "files")]
pub use settings::{Settings, SettingsError};
#[cfg(feature = "files")]
pub use style_file::{StyleFile, read_style};

pub use timeline::{Timeline, Track};

pub use dotwork_drawing::{
    self as drawing, Camera, Color, Drawing, Length, Light, LightFrame, Page, UpAxis, Warnings,
};
#[cfg(feature = "files")]
pub use dotwork_export as export;
pub use dotwork_ink::{self as ink, MAX_STIPPLES, Style, preset};
#[cfg(feature = "files")]
pub use dotwork_io as io;
pub use dotwork_mesh::{self as mesh, Mesh, MeshError, RawMesh};
pub use dotwork_render::{self as render, Raster, Rasterizer};
pub use dotwork_volume::{self as volume, Volume};
