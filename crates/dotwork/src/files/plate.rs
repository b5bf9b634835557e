//! Plates: pictures that dotwork drew, which carry what is needed to draw them again.

use std::path::{Path, PathBuf};

use dotwork_drawing::Warnings;
use dotwork_io::volume::RawLayout;

use super::input::{LoadOptions, load_with};
use super::sequence;
use super::watch::Watch;
use super::{FileError, one_line};
use crate::dots_file::{Described, read_settings};
use crate::scene::{Scene, Source};

/// A picture that dotwork drew.
pub struct Plate {
    path: PathBuf,
    scene: Scene,
    objects: Vec<Described>,
    version: String,
    /// Is told how far reading its inputs is.
    pub(super) watch: Watch,
}

impl Plate {
    /// The plate with these bytes; `None` if they are no picture.
    ///
    /// # Errors
    /// A picture without settings, or with damaged ones.
    pub(super) fn of_bytes(path: &Path, bytes: &[u8]) -> Result<Option<Plate>, FileError> {
        let Some(kind) = dotwork_export::is_plate(bytes) else { return Ok(None) };
        let error = |reason: String| FileError::Plate { path: path.to_path_buf(), reason };
        let Some(settings) = dotwork_export::embedded_settings(bytes) else {
            // Most TIFF files are volumes.
            if kind == "TIFF" {
                return Ok(None);
            }
            return Err(error(format!(
                "is a picture ({kind}) without dotwork's settings: another program made it, or saved it again \
                 without them"
            )));
        };
        let (scene, objects, version) =
            read_settings(&settings, bytes.len()).map_err(|e| error(format!("its {e}")))?;
        Ok(Some(Plate { path: path.to_path_buf(), scene, objects, version, watch: Watch::default() }))
    }

    /// The picture's file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where its inputs are now, as [`Plate::unbaked`] finds them; those that are gone are left out.
    pub fn inputs(&self) -> Vec<PathBuf> {
        self.objects.iter().filter_map(|o| find(&self.path, o.source.as_ref()?)).collect()
    }

    /// The version of dotwork that drew it.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Its settings as a scene without objects.
    pub fn settings(&self) -> &Scene {
        &self.scene
    }

    /// Name, source and style of each object, and how many stipples it had.
    pub fn objects(&self) -> &[Described] {
        &self.objects
    }

    /// Reads the inputs again and bakes as many stipples as the plate was drawn from.
    ///
    /// # Errors
    /// As [`Plate::unbaked`].
    pub fn scene(self, warnings: &mut Warnings) -> Result<Scene, FileError> {
        let (mut scene, counts) = self.unbaked(warnings)?;
        scene.bake_counts(&counts, |_| ());
        Ok(scene)
    }

    /// Reads the inputs again: the scene before it is baked, and for each object the number of stipples that the plate
    /// was drawn from. An input is looked for under the path that was given when the plate was drawn, then under that
    /// path and under its bare name beside the plate. Warnings about an input begin with its name.
    ///
    /// # Errors
    /// [`FileError::Plate`]: an input is gone, or has changed; and what reading it gives.
    pub fn unbaked(self, warnings: &mut Warnings) -> Result<(Scene, Vec<usize>), FileError> {
        let Plate { path, mut scene, objects, version, watch } = self;
        if version != env!("CARGO_PKG_VERSION") {
            warnings.say(format!(
                "was drawn by dotwork {}; this is {}, which may draw it otherwise",
                one_line(&version),
                env!("CARGO_PKG_VERSION")
            ));
        }
        let mut counts = Vec::new();
        for described in objects {
            let error = |reason: String| FileError::Plate { path: path.clone(), reason };
            let Described { name, source, world, style, stipples } = described;
            let shown = one_line(&name);
            if stipples == 0 {
                return Err(error(format!("does not say how many stipples its object '{shown}' has")));
            }
            let source =
                source.ok_or_else(|| error(format!("does not say where its object '{shown}' is from")))?;
            let found = find(&path, &source).ok_or_else(|| {
                let file = one_line(&source.file);
                error(format!("its input {file} is gone (it is neither there nor beside the plate)"))
            })?;
            let raw = source
                .raw
                .as_deref()
                .map(str::parse::<RawLayout>)
                .transpose()
                .map_err(|e| error(e.to_string()))?;
            let mut said = Warnings::new();
            let options = LoadOptions {
                raw,
                series: source.series.clone(),
                label: source.label,
                watch: watch.clone(),
                ..LoadOptions::default()
            };
            let parts = load_with(&found, &options, &mut said)?.into_meshes(&style, source.iso, &mut said)?;
            let Some(mut mesh) = parts.into_iter().find(|part| part.source.cut == source.cut) else {
                return Err(error(format!("its object '{shown}' is no longer a part of its input")));
            };
            if mesh.source.checksum != source.checksum {
                let hex = |c: Option<u64>| c.map_or("none".into(), |c| format!("{c:016x}"));
                return Err(error(format!(
                    "its input {} has changed since the plate was drawn (checksum {}, now {})",
                    one_line(&found.to_string_lossy()),
                    hex(source.checksum),
                    hex(mesh.source.checksum)
                )));
            }
            mesh.place(source.placement);
            let mut object = mesh.into_object(style, &mut said)?;
            if let Some(pose) = &source.pose {
                let posed = object.take_pose(pose.clip.as_deref(), source.baked_at);
                posed.map_err(|reason| error(format!("its object '{shown}': {reason}")))?;
                object.pose(pose.time, scene.density);
            }
            for warning in said.iter() {
                warnings.say(format!("its input {}: {warning}", one_line(&found.to_string_lossy())));
            }
            // As the plate has them, so that the next one is the same to the byte.
            (object.name, object.source, object.world) = (name, Some(source), world);
            scene.push(object);
            counts.push(stipples);
        }
        Ok((scene, counts))
    }
}

/// Where an input of a plate is now.
fn find(plate: &Path, source: &Source) -> Option<PathBuf> {
    let given = PathBuf::from(&source.file);
    if source.checksum.is_none() {
        // A demo.
        return Some(given);
    }
    let beside = plate.parent().unwrap_or(Path::new(""));
    let candidates = [given.clone(), beside.join(&given), beside.join(given.file_name()?)];
    candidates.into_iter().find(|p| p.exists() || sequence::files(p).is_some())
}
