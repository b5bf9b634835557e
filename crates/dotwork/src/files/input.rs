//! From a path or a demo's name to a scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use dotwork_drawing::{UpAxis, Warnings};
use dotwork_ink::Style;
use dotwork_io::Model;
use dotwork_io::dots::{self, Reader};
use dotwork_io::volume::{
    RawLayout, VolumeFile, VolumeOptions, read_volume, read_volume_bytes, volume_format_of,
};
use dotwork_mesh::{Motion, RawMesh, shapes};
use dotwork_volume::phantom::phantom;
use dotwork_volume::{Affine, Unit, Volume};
use glam::DVec3;

use super::FileError;
use super::outlook::Outlook;
use super::parts::Look;
use super::plate::Plate;
use super::sequence;
use super::volume::VolumeInput;
use super::watch::{Stage, Watch};
use crate::dots_file::read_scene;
use crate::moving::Pose;
use crate::placement::Placement;
use crate::scene::{Object, Scene, Source, World};
use crate::scene_file::{SceneFile, read_scene_file};

/// What an input holds.
pub enum Loaded {
    /// A mesh, not yet put in order.
    Mesh(Box<MeshFile>),
    /// A volume.
    Volume(Box<VolumeInput>),
    /// The complete scene of a `.dots` file, baked.
    Scene {
        /// The input as it was named, for messages.
        input: String,
        /// The scene.
        scene: Box<Scene>,
    },
    /// A picture that dotwork drew, with the settings that it carries.
    Plate(Box<Plate>),
    /// A scene file: objects with their styles, the camera and the page.
    SceneFile(Box<SceneFile>),
}

/// A mesh as its file gives it.
pub struct MeshFile {
    /// Name for the object: the file's stem, or the demo's name.
    pub name: String,
    /// The input as it was named, for messages.
    pub input: String,
    /// The format in words.
    pub format: String,
    /// What else the file says.
    pub facts: Vec<(String, String)>,
    /// Where it came from.
    pub source: Source,
    /// What is known about the space in which it lies.
    pub world: World,
    /// From where it is looked at unless a camera is given.
    pub outlook: Outlook,
    /// What was decided on the way from a volume to this surface, in words.
    pub notes: Vec<String>,
    /// The mesh.
    pub raw: RawMesh,
    /// What moves it, and the origin of the places that this gives.
    pub motion: Option<(Arc<dyn Motion>, [f64; 3])>,
    /// The prepared volume whose surface it is.
    pub volume: Option<Arc<Volume>>,
    /// Lowest and highest corner of the surface of a volume before it was clipped and placed.
    pub whole: Option<[DVec3; 2]>,
    /// What it looks like by the volume's table or transfer function.
    pub look: Look,
}

impl MeshFile {
    /// Puts the mesh in order and takes it as an object.
    ///
    /// # Errors
    /// [`FileError::Mesh`].
    pub fn into_object(self, style: Style, warnings: &mut Warnings) -> Result<Object, FileError> {
        let MeshFile { name, input, source, world, raw, motion, volume, whole, .. } = self;
        let object = match motion {
            Some(motion) => Object::placed(name, raw, motion, &source.placement, style, warnings),
            None => Object::new(name, raw, style, warnings),
        };
        let object = object.map_err(|source| FileError::Mesh { input: input.clone(), source })?;
        let mut object = Object { source: Some(source), world, volume, whole, ..object };
        if let Some(Pose { clip, time }) = object.source.as_ref().and_then(|s| s.pose.clone()) {
            let posed = object.take_pose(clip.as_deref(), time);
            posed.map_err(|reason| FileError::Pose { input, reason })?;
        }
        Ok(object)
    }

    /// Puts the mesh, and the volume that it was found in, elsewhere.
    pub fn place(&mut self, placement: Placement) {
        if placement == Placement::default() {
            return;
        }
        placement.apply(&mut self.raw);
        self.source.placement = placement;
        self.volume = self.volume.take().map(|volume| {
            let (linear, shift) = placement.parts();
            let old = volume.affine();
            let affine = Affine { linear: linear * old.linear, origin: linear * old.origin + shift, ..*old };
            Arc::new(Arc::unwrap_or_clone(volume).with_affine(affine))
        });
    }

    /// Turns the camera of a new scene as this input asks, about `up` if that is given: for a patient to the anterior
    /// view, for what is flat to that face on, and then towards the faces at which `style` cuts it open.
    pub fn turn_camera(&self, style: &Style, up: Option<UpAxis>, scene: &mut Scene) {
        self.outlook.turn(up, &self.cut_sides(style), &mut scene.camera);
    }
}

/// What the caller knows about inputs that their files do not say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// The layout of a volume without a header.
    pub raw: Option<RawLayout>,
    /// Which series of DICOM files is read: its UID, number or description; `None`: the one with the largest volume.
    pub series: Option<String>,
    /// The values of volumes are labels: those of this table, or `auto` for labels without names.
    pub labels: Option<PathBuf>,
    /// The only label that is drawn, by its value.
    pub label: Option<i64>,
    /// The transfer function through which volumes are seen.
    pub transfer: Option<PathBuf>,
    /// Which of several transfer functions in that file, by its name.
    pub transfer_name: Option<String>,
    /// The pose in which a mesh that moves is drawn; `None`: at rest.
    pub pose: Option<Pose>,
    /// Is told how far reading is, and then how far what is made of what was read.
    pub watch: Watch,
}

impl LoadOptions {
    fn of_volume(&self) -> VolumeOptions {
        VolumeOptions { raw: self.raw.clone(), series: self.series.clone() }
    }
}

/// Reads an input: a mesh file, a volume (a folder of DICOM or TIFF files too), a `.dots` file, a picture that dotwork
/// drew, or a built-in demo, `demo:NAME`.
///
/// What a file is is decided by its content. What was dropped on the way is said in `warnings`.
///
/// # Errors
/// See [`FileError`].
pub fn load(input: impl AsRef<Path>, warnings: &mut Warnings) -> Result<Loaded, FileError> {
    load_with(input, &LoadOptions::default(), warnings)
}

/// As [`load`], with what the caller knows about the input.
///
/// # Errors
/// See [`FileError`].
pub fn load_with(
    input: impl AsRef<Path>,
    options: &LoadOptions,
    warnings: &mut Warnings,
) -> Result<Loaded, FileError> {
    let path = input.as_ref();
    let input = path.to_string_lossy().into_owned();
    options.watch.tell(Stage::Reading, 0.0);
    if let Some(name) = input.strip_prefix("demo:") {
        return match phantom(name) {
            Some(volume) => {
                let mut volume = VolumeInput::demo(name, volume);
                volume.take(options, warnings)?;
                Ok(Loaded::Volume(Box::new(volume)))
            }
            None => demo(name, &input, options).map(|mesh| Loaded::Mesh(Box::new(mesh))),
        };
    }
    if options.raw.is_some() || path.is_dir() {
        let file = read_volume(path, &options.of_volume(), warnings)?;
        return volume(path, file, options, warnings);
    }
    if !path.exists()
        && let Some(files) = sequence::files(path)
    {
        let (model, format) = sequence::read(&files, warnings)?;
        let facts = vec![("sequence".into(), format!("{} files, from {}", files.len(), files[0].display()))];
        return Ok(moving_mesh(path, &files[0], model, format, facts, options));
    }
    let bytes = dotwork_io::read_file(path)?;
    // A file of that name that is none is told so, rather than that it is no mesh.
    if dots::is_dots(&bytes) || named_dots(path) {
        let scene = read_scene(&Reader::from_bytes(path, bytes)?)?;
        return Ok(Loaded::Scene { input, scene: Box::new(scene) });
    }
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        let file = SceneFile { watch: options.watch.clone(), ..read_scene_file(path)? };
        return Ok(Loaded::SceneFile(Box::new(file)));
    }
    if let Some(mut plate) = Plate::of_bytes(path, &bytes)? {
        plate.watch = options.watch.clone();
        return Ok(Loaded::Plate(Box::new(plate)));
    }
    if volume_format_of(path, &bytes).is_some() {
        // Not read again: a pipe gives its bytes once.
        let beside = &mut dotwork_io::read_regular_file;
        let file = read_volume_bytes(path, &bytes, &options.of_volume(), beside, warnings)?;
        return volume(path, file, options, warnings);
    }
    let format = dotwork_io::mesh_format_name(path, &bytes).unwrap_or_default();
    let model = dotwork_io::read_model(path, &bytes, warnings)?;
    let facts = dotwork_io::mesh_facts(path, &bytes);
    Ok(moving_mesh(path, path, model, format, facts, options))
}

/// A mesh, with what moves it, named after `file`.
fn moving_mesh(
    path: &Path,
    file: &Path,
    model: Model,
    format: String,
    facts: Vec<(String, String)>,
    options: &LoadOptions,
) -> Loaded {
    let input = path.to_string_lossy().into_owned();
    let Model { mesh: raw, checksum, motion } = model;
    let motion = motion.map(|motion| (motion, raw.origin));
    let up = if format.starts_with("STL") { UpAxis::Z } else { UpAxis::Y };
    let pose = options.pose.clone().filter(|_| motion.is_some());
    let source = Source { file: input.clone(), checksum: Some(checksum), pose, ..Source::default() };
    let name = object_name(file);
    // glTF's lengths are metres; the other formats do not say.
    let unit = if format.starts_with("glTF") { Unit::Metre } else { Unit::Unknown };
    let world = World { unit, ..World::default() };
    Loaded::Mesh(Box::new(MeshFile {
        name,
        input,
        format,
        facts,
        source,
        world,
        outlook: Outlook::of_mesh(up),
        notes: Vec::new(),
        raw,
        motion,
        volume: None,
        whole: None,
        look: Look::default(),
    }))
}

fn demo(name: &str, input: &str, options: &LoadOptions) -> Result<MeshFile, FileError> {
    let Some(raw) = shapes::demo(name) else {
        return Err(FileError::UnknownDemo { name: name.into() });
    };
    Ok(MeshFile {
        name: name.into(),
        input: input.into(),
        format: "built-in shape".into(),
        facts: Vec::new(),
        source: Source {
            file: input.into(),
            pose: options.pose.clone().filter(|_| shapes::motion(name).is_some()),
            ..Source::default()
        },
        world: World::default(),
        outlook: Outlook::of_mesh(UpAxis::Y),
        notes: Vec::new(),
        raw,
        motion: shapes::motion(name).map(|motion| (motion, [0.0; 3])),
        volume: None,
        whole: None,
        look: Look::default(),
    })
}

fn volume(
    path: &Path,
    file: VolumeFile,
    options: &LoadOptions,
    warnings: &mut Warnings,
) -> Result<Loaded, FileError> {
    let input = path.to_string_lossy().into_owned();
    let source = Source {
        file: input.clone(),
        checksum: Some(file.checksum),
        raw: options.raw.as_ref().map(ToString::to_string),
        series: options.series.clone(),
        ..Source::default()
    };
    let mut volume = VolumeInput {
        format: file.format,
        facts: file.facts,
        source,
        own_labels: file.labels,
        ..VolumeInput::new(object_name(path), input, file.volume)
    };
    volume.take(options, warnings)?;
    Ok(Loaded::Volume(Box::new(volume)))
}

/// Reads an input as a scene: a mesh or a demo as one object in `style`, everything else at its default; a scene file, a
/// `.dots` file or a plate with the styles and settings that it holds; of a volume the feature that `style` names.
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
        Loaded::Scene { scene, .. } => Ok(*scene),
        Loaded::Plate(plate) => plate.scene(warnings),
        Loaded::SceneFile(file) => Ok(file.scene(None, &|_| (), warnings)?.0),
        loaded => {
            let mut scene = Scene::default();
            for mesh in loaded.into_meshes(style, None, warnings)? {
                mesh.turn_camera(style, None, &mut scene);
                let style = mesh.style(style.clone());
                scene.add(mesh.into_object(style, warnings)?);
            }
            Ok(scene)
        }
    }
}

impl Loaded {
    /// The mesh, or the surface of the volume: where it has the value `iso`, or of the feature that `style` names;
    /// after it the faces of the cut, if `style` clips it.
    ///
    /// # Errors
    /// As [`VolumeInput::surface`]; [`FileError::Clip`]; [`FileError::WholeScene`]: a `.dots` file or a plate.
    pub fn into_meshes(
        self,
        style: &Style,
        iso: Option<f64>,
        warnings: &mut Warnings,
    ) -> Result<Vec<MeshFile>, FileError> {
        match self {
            Loaded::Mesh(mesh) => mesh.clipped(style),
            Loaded::Volume(volume) => volume.meshes(style, iso, warnings),
            Loaded::Scene { input, .. } => Err(FileError::WholeScene { input }),
            Loaded::SceneFile(file) => {
                Err(FileError::WholeScene { input: file.path.to_string_lossy().into_owned() })
            }
            Loaded::Plate(plate) => {
                Err(FileError::WholeScene { input: plate.path().to_string_lossy().into_owned() })
            }
        }
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
