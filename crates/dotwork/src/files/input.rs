//! From a path or a demo's name to a scene.

use std::path::Path;

use dotwork_drawing::Warnings;
use dotwork_ink::Style;
use dotwork_io::dots::{self, Reader};
use dotwork_mesh::{RawMesh, shapes};

use super::FileError;
use crate::dots_file::read_scene;
use crate::scene::{Object, Scene, Source};

/// What an input holds.
pub enum Loaded {
    /// A mesh, not yet put in order.
    Mesh(MeshFile),
    /// The complete scene of a `.dots` file, baked.
    Scene(Box<Scene>),
}

/// A mesh as its file gives it.
pub struct MeshFile {
    /// Name for the object: the file's stem, or the demo's name.
    pub name: String,
    /// The input as it was named, for messages.
    pub input: String,
    /// Where it came from.
    pub source: Source,
    /// The mesh.
    pub raw: RawMesh,
}

impl MeshFile {
    /// Puts the mesh in order and takes it as an object.
    ///
    /// # Errors
    /// [`FileError::Mesh`].
    pub fn into_object(self, style: Style, warnings: &mut Warnings) -> Result<Object, FileError> {
        let MeshFile { name, input, source, raw } = self;
        let mut object =
            Object::new(name, raw, style, warnings).map_err(|source| FileError::Mesh { input, source })?;
        object.source = Some(source);
        Ok(object)
    }
}

/// Reads a mesh file (PLY or OBJ, gzipped or not), a `.dots` file or a built-in demo, `demo:NAME`.
///
/// What a file is is decided by its content. What was dropped on the way is said in `warnings`.
///
/// # Errors
/// See [`FileError`].
pub fn load(input: impl AsRef<Path>, warnings: &mut Warnings) -> Result<Loaded, FileError> {
    let path = input.as_ref();
    let input = path.to_string_lossy().into_owned();
    if let Some(name) = input.strip_prefix("demo:") {
        let Some(raw) = shapes::demo(name) else {
            return Err(FileError::UnknownDemo { name: name.into() });
        };
        let source = Source { file: input.clone(), checksum: None };
        return Ok(Loaded::Mesh(MeshFile { name: name.into(), input, source, raw }));
    }
    let bytes = dotwork_io::read_file(path)?;
    // A file of that name that is none is told so, rather than that it is no mesh.
    if dots::is_dots(&bytes) || named_dots(path) {
        let scene = read_scene(&Reader::from_bytes(path, bytes)?)?;
        return Ok(Loaded::Scene(Box::new(scene)));
    }
    let raw = dotwork_io::read_mesh_bytes(path, &bytes, warnings)?;
    let file = path.file_name().map_or_else(|| input.clone(), |f| f.to_string_lossy().into_owned());
    let source = Source { file, checksum: Some(dotwork_io::checksum(&bytes)) };
    Ok(Loaded::Mesh(MeshFile { name: object_name(path), input, source, raw }))
}

/// Reads an input as a scene: a mesh file or a demo as one object in `style`, everything else at its default; a `.dots`
/// file with the styles and settings that it holds.
///
/// ```
/// use dotwork::{Style, Warnings, open};
///
/// let mut warnings = Warnings::new();
/// let scene = open("demo:torus", &Style::default(), &mut warnings)?;
/// assert_eq!(scene.objects[0].name, "torus");
/// # Ok::<(), dotwork::FileError>(())
/// ```
///
/// # Errors
/// See [`FileError`].
pub fn open(input: impl AsRef<Path>, style: &Style, warnings: &mut Warnings) -> Result<Scene, FileError> {
    match load(input, warnings)? {
        Loaded::Scene(scene) => Ok(*scene),
        Loaded::Mesh(mesh) => Ok(Scene::of(mesh.into_object(style.clone(), warnings)?)),
    }
}

fn named_dots(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("dots"))
}

/// The file's name without its extension, and without the `.gz` after it.
fn object_name(path: &Path) -> String {
    let gzipped = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let stem = path.file_stem().unwrap_or(path.as_os_str());
    let stem = if gzipped { Path::new(stem).file_stem().unwrap_or(stem) } else { stem };
    stem.to_string_lossy().into_owned()
}
