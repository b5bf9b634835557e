//! Scene files: several objects, each with its style, and the camera, the light and the page, as TOML.
//!
//! ```toml
//! include = ["house-style.toml"]   # other scene files; what stands here lies over them
//! style = "soft"                   # of objects that name none
//!
//! [[object]]
//! name = "skull"
//! file = "head.nii.gz"             # relative to this file, or demo:NAME
//! style = "bone"                   # a preset, or a style file relative to this one
//! role = "focus"
//!
//! [[object]]
//! name = "skin"
//! file = "head.nii.gz"             # read once: both objects share the volume
//! feature = "outer"                # every style key may stand here
//! role = "context"
//! color = "#7a4a2a"
//!
//! [camera]
//! direction = "anterior"           # or azimuth, elevation, distance; ortho, zoom, up
//!
//! [page]
//! paper = "A5"                     # or size_px = [1200, 900]; margin, dpi
//! ```
//!
//! Every error names the file and the line.

mod read;

use std::path::PathBuf;

use dotwork_drawing::{UpAxis, Warnings};
use dotwork_ink::Style;

use crate::files::{FileError, LoadOptions, Loaded, MeshFile, VolumeInput, Watch, load_with, preparation};
use crate::placement::Placement;
use crate::scene::Scene;
use crate::settings::Settings;

pub use read::read_scene_file;

/// A scene as its file describes it.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// The file.
    pub path: PathBuf,
    /// The objects that are drawn, in their order.
    pub objects: Vec<SceneObject>,
    /// Camera, light, page and the like.
    pub settings: Settings,
    /// Is told how far reading the objects' files is.
    pub watch: Watch,
}

/// An object as a scene file describes it.
#[derive(Clone, Debug)]
pub struct SceneObject {
    /// Its name; `None`: as its file is called.
    pub name: Option<String>,
    /// The input, as seen from the working folder, or `demo:NAME`.
    pub file: PathBuf,
    /// What its file does not say of itself.
    pub load: LoadOptions,
    /// The value at which a volume has its surface.
    pub iso: Option<f64>,
    /// The style that it names, if it names one, or the scene's.
    pub style: Option<Style>,
    /// Style keys of its own, `key, value`, over any style.
    pub keys: Vec<(String, String)>,
    /// Where it is put.
    pub placement: Placement,
    /// The scene file and the line in which it begins.
    place: (PathBuf, usize),
}

impl SceneFile {
    /// Reads the objects' files and puts the scene together, not yet baked.
    ///
    /// `base` takes the place of the styles that objects name; their own keys stay. `finish` has the last word on each
    /// style. Warnings about an object begin with its name; so do the notes that come with the scene, which say what was
    /// decided on the way from volumes to surfaces.
    ///
    /// # Errors
    /// [`FileError::Scene`] with the line of the object that cannot be read or drawn, or whose settings do not fit.
    pub fn scene(
        &self,
        base: Option<&Style>,
        finish: &dyn Fn(&mut Style),
        warnings: &mut Warnings,
    ) -> Result<(Scene, Vec<String>), FileError> {
        let mut scene = Scene::default();
        let mut notes = Vec::new();
        let styles: Vec<Style> = self
            .objects
            .iter()
            .map(|object| {
                let mut style = object.styled(base);
                finish(&mut style);
                style
            })
            .collect();
        // Volumes that later objects are drawn of too.
        let mut volumes: Vec<(&SceneObject, VolumeInput)> = Vec::new();
        for (k, (object, style)) in self.objects.iter().zip(&styles).enumerate() {
            let (path, line) = &object.place;
            let error = |reason: String| FileError::Scene { path: path.clone(), line: *line, reason };
            let mut said = Warnings::new();
            let later =
                || self.objects[k + 1..].iter().zip(&styles[k + 1..]).filter(|(o, _)| object.shares(o));
            let read = match volumes.iter().position(|(o, _)| o.shares(object)) {
                Some(at) => {
                    let mut volume = volumes.swap_remove(at).1;
                    volume.take(&self.watched(object), &mut said).map(|()| Loaded::Volume(Box::new(volume)))
                }
                None => load_with(&object.file, &self.watched(object), &mut said),
            };
            let parts = read.and_then(|loaded| match loaded {
                Loaded::Volume(mut volume) if later().next().is_some() => {
                    volume.keep_prepared(later().any(|(_, other)| preparation(other) == preparation(style)));
                    let meshes = volume.meshes(style, object.iso, &mut said)?;
                    volumes.push((object, *volume));
                    Ok(meshes)
                }
                Loaded::Volume(mut volume) => {
                    volume.keep_prepared(false);
                    volume.meshes(style, object.iso, &mut said)
                }
                loaded => loaded.into_meshes(style, object.iso, &mut said),
            });
            let name = object.name.clone().unwrap_or_else(|| object.file.display().to_string());
            for part in parts.map_err(|e| error(e.to_string()))? {
                notes.extend(part.notes.iter().map(|note| format!("{name}: {note}")));
                object
                    .add(part, style.clone(), self.settings.up, &mut scene, &mut said)
                    .map_err(|e| error(e.to_string()))?;
            }
            for warning in said.iter() {
                warnings.say(format!("{name}: {warning}"));
            }
        }
        self.settings.apply(&mut scene).map_err(|e| FileError::Scene {
            path: self.path.clone(),
            line: 1,
            reason: e.to_string(),
        })?;
        Ok((scene, notes))
    }

    /// How an object's file is read, and who is told.
    fn watched(&self, object: &SceneObject) -> LoadOptions {
        LoadOptions { watch: self.watch.clone(), ..object.load.clone() }
    }

    /// The files that the scene is made of.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let files = self.objects.iter().map(|o| o.file.clone());
        files.chain(self.objects.iter().map(|o| o.place.0.clone())).collect()
    }
}

impl SceneObject {
    /// The style that the file gives it.
    pub fn own_style(&self) -> Style {
        self.styled(None)
    }

    /// Whether `other` is drawn of the same file, read alike; what its values mean may differ.
    fn shares(&self, other: &SceneObject) -> bool {
        let read = |o: &SceneObject| (o.file.clone(), o.load.raw.clone(), o.load.series.clone());
        read(self) == read(other)
    }

    /// Its keys over `base`, or over the style that the file gives it.
    fn styled(&self, base: Option<&Style>) -> Style {
        let mut style = base.or(self.style.as_ref()).cloned().unwrap_or_default();
        for (key, value) in &self.keys {
            // Tried out when the file was read.
            let _ = style.set(key, value);
        }
        style
    }

    /// Puts one part of the object into the scene, with `up` if the file says so: its surface, or a face of a cut.
    fn add(
        &self,
        mut part: MeshFile,
        style: Style,
        up: Option<UpAxis>,
        scene: &mut Scene,
        warnings: &mut Warnings,
    ) -> Result<(), FileError> {
        if let Some(name) = &self.name {
            part.name = match part.source.cut {
                None => name.clone(),
                Some(_) => format!("{name}-cut"),
            };
        }
        if scene.objects.is_empty() {
            part.turn_camera(&style, up, scene);
        }
        let style = part.style(style);
        part.place(self.placement);
        if !scene.add(part.into_object(style, warnings)?) {
            warnings.say("lies so far from the first object that it is drawn about its own middle instead");
        }
        Ok(())
    }
}
