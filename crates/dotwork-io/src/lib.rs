//! Files in and out: mesh readers, mesh writers, and the `.dots` container.
//!
//! * [`read_mesh`] reads PLY (ascii, binary of either byte order) and OBJ, both also gzipped. What a file is is
//!   decided by its content; its name is only asked when the content does not say. [`read_file`] and
//!   [`read_mesh_bytes`] are its two halves, for a caller that also wants the [`checksum`] of the file.
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
mod gather;
mod gzip;
mod number;
mod obj;
mod ply;
mod text;
mod write;

pub use checksum::checksum;
pub use error::{Place, ReadError, ReadErrorKind};
pub use file::{read_file, read_mesh, read_mesh_bytes};
pub use format::{MeshFormat, mesh_format_of};
pub use write::{write_obj, write_ply};
