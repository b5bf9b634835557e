//! Files in and out: mesh readers, mesh writers, and the `.dots` container.
//!
//! * [`read_mesh`] reads PLY, OBJ, STL, OFF and glTF (`.gltf` and `.glb`, at rest; [`read_model`] also what moves it),
//!   all also gzipped. What a file is
//!   is decided by its content; its name is only asked when the content does not say. [`read_file`] and
//!   [`read_mesh_bytes`] are its two halves, for a caller that also wants the [`checksum`] of the file;
//!   [`mesh_format_name`] says in words what the file is.
//! * [`volume`] reads volumes: NRRD, NIfTI, MetaImage, legacy VTK, TIFF stacks, raw samples by option.
//! * [`transfer`] reads and writes transfer functions.
//! * [`write_ply`] and [`write_obj`] write what the readers read back unchanged.
//! * [`dots`] packs named arrays into one checked, compressed file.
//!
//! Nothing in a file is believed before it is checked: declared sizes are compared with the bytes that are there
//! before memory is taken, and every error names the file, the place and the reason on one line.
//!
//! ```
//! use dotwork_drawing::Warnings;
//! use std::path::Path;
//!
//! let obj = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let mut warnings = Warnings::new();
//! let mesh = dotwork_io::read_mesh_bytes(Path::new("square.obj"), obj, &mut warnings)?;
//! assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
//!
//! let broken = b"v 0 0 0\nv 1 0 0\nf 1 2 3\n";
//! let error = dotwork_io::read_mesh_bytes(Path::new("broken.obj"), broken, &mut warnings).unwrap_err();
//! assert_eq!(error.to_string(), "broken.obj: line 3: face 1: index 3 is out of range (2 vertices)");
//! # Ok::<(), dotwork_io::ReadError>(())
//! ```

mod checksum;
pub mod dots;
mod error;
mod file;
mod format;
#[cfg_attr(
    not(all(feature = "ply", feature = "obj")),
    allow(dead_code, reason = "each reader uses its share")
)]
mod gather;
#[cfg(feature = "gltf")]
mod gltf;
mod gzip;
#[cfg_attr(
    not(all(feature = "ply", feature = "obj")),
    allow(dead_code, reason = "each reader uses its share")
)]
mod number;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "off")]
mod off;
#[cfg(feature = "ply")]
mod ply;
#[cfg(feature = "stl")]
mod stl;
#[cfg_attr(
    not(all(feature = "ply", feature = "obj")),
    allow(dead_code, reason = "each reader uses its share")
)]
mod text;
#[cfg(feature = "transfer")]
pub mod transfer;
#[cfg(feature = "volume")]
pub mod volume;
mod write;

pub use checksum::checksum;
pub use error::{Place, ReadError, ReadErrorKind};
pub use file::{
    Model, mesh_facts, read_file, read_mesh, read_mesh_bytes, read_mesh_checked, read_model,
    read_regular_file,
};
pub use format::{MeshFormat, mesh_format_name, mesh_format_of, mesh_formats};
pub use write::{write_obj, write_ply};
