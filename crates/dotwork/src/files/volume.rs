//! From a volume to the surface of one of its features.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use dotwork_drawing::{UpAxis, Warnings};
use dotwork_ink::{FeatureChoice, Keep, Style, SurfaceChoice};
use dotwork_io::volume::LabelTable;
use dotwork_mesh::ClipRegion;
use dotwork_volume::{Features, IsoOptions, Label, Preparation, Volume};

use super::FileError;
use super::clip::bounds;
use super::input::MeshFile;
use super::outlook::Outlook;
use super::parts::{Look, Meaning};
use super::watch::{Stage, Watch};
use crate::scene::{Source, World};

/// A volume as its file gives it.
pub struct VolumeInput {
    /// Name for the object: the file's stem.
    pub name: String,
    /// The input as it was named, for messages.
    pub input: String,
    /// The format in words.
    pub format: String,
    /// What else the file says, in its order.
    pub facts: Vec<(String, String)>,
    /// Where it came from.
    pub source: Source,
    /// The volume.
    pub volume: Volume,
    /// What its values stand for.
    pub meaning: Meaning,
    /// The only label that is drawn, if one was asked for.
    pub label: Option<i64>,
    /// The table of names that its own file has.
    pub(super) own_labels: Option<LabelTable>,
    /// The labels in it, once they have been looked for.
    pub(super) labels: OnceLock<Result<Vec<Label>, String>>,
    /// What has been prepared and is kept for what is prepared alike.
    pub(super) kept: Mutex<Vec<(Preparation, Prepared)>>,
    pub(super) keep: bool,
    /// Is told how far its preparation is.
    pub(super) watch: Watch,
}

/// A volume as it is drawn, and what was found in it.
#[derive(Clone)]
pub(super) struct Prepared {
    volume: Arc<Volume>,
    features: Arc<OnceLock<Result<Features, String>>>,
    /// What was said when it was prepared.
    said: Warnings,
}

impl Prepared {
    fn features(&self) -> Result<&Features, String> {
        let find = || dotwork_volume::find_features(&self.volume).map_err(|e| e.to_string());
        self.features.get_or_init(find).as_ref().map_err(String::clone)
    }
}

/// The preparation that a style asks for.
pub(crate) fn preparation(style: &Style) -> Preparation {
    Preparation {
        window: style.window.0,
        cap: style.cap,
        smooth: Some(f64::from(style.smooth)),
        crop: style.crop.0,
        ..Preparation::default()
    }
}

impl VolumeInput {
    /// A volume of quantities; `input` is what messages and plates call it.
    pub fn new(name: impl Into<String>, input: impl Into<String>, volume: Volume) -> VolumeInput {
        let input = input.into();
        VolumeInput {
            name: name.into(),
            format: String::new(),
            facts: Vec::new(),
            source: Source { file: input.clone(), ..Source::default() },
            input,
            volume,
            meaning: Meaning::Quantities,
            label: None,
            own_labels: None,
            labels: OnceLock::new(),
            kept: Mutex::default(),
            keep: false,
            watch: Watch::default(),
        }
    }

    /// A volume that dotwork makes itself.
    pub(crate) fn demo(name: &str, volume: Volume) -> VolumeInput {
        let format = "built-in volume".into();
        VolumeInput { format, ..VolumeInput::new(name, format!("demo:{name}"), volume) }
    }

    /// Whether what is prepared from now on is kept, with the features found in it, for what is prepared alike: several
    /// surfaces of one volume. What is kept takes 2 bytes a voxel until `false` is said and it is asked for once more,
    /// for the last time.
    pub fn keep_prepared(&mut self, keep: bool) {
        self.keep = keep;
    }

    pub(super) fn keeps(&self) -> bool {
        self.keep
    }

    /// From where it is looked at unless a camera is given.
    pub(super) fn outlook(&self) -> Outlook {
        // What does not say how it lies has its first slice at the top, as images have their first row; but programs that
        // write MetaImage take its axes for the patient's where it does not turn them.
        let up = if self.format.starts_with("MetaImage") { UpAxis::Z } else { UpAxis::NegZ };
        let outlook = Outlook::of_volume(&self.volume, up);
        // The built-in volumes stand along y, as the built-in shapes do, unless they are patients.
        let built_in = !outlook.patient && self.input.starts_with("demo:");
        if built_in { Outlook::of_mesh(UpAxis::Y) } else { outlook }
    }

    pub(super) fn error(&self, reason: impl ToString) -> FileError {
        FileError::Volume { input: self.input.clone(), reason: reason.to_string() }
    }

    /// The volume as it is drawn: windowed, cropped, padded, resampled and smoothed as `style` says. Values keep their
    /// meaning.
    ///
    /// # Errors
    /// [`FileError::Volume`]: all values are the same, the window shows nothing of them.
    pub fn prepared(&self, style: &Style, warnings: &mut Warnings) -> Result<Arc<Volume>, FileError> {
        Ok(self.prepare(style, self.keep, warnings)?.volume)
    }

    /// As [`VolumeInput::prepared`]; kept if it is needed `again`.
    fn prepare(&self, style: &Style, again: bool, warnings: &mut Warnings) -> Result<Prepared, FileError> {
        let preparation = preparation(style);
        // A list that a panic left behind holds whole entries.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let prepared = match kept.iter().position(|(p, _)| *p == preparation) {
            Some(k) => kept.swap_remove(k).1,
            None => {
                let mut said = Warnings::new();
                self.watch.tell(Stage::Preparing, 0.0);
                let watch = |share| self.watch.tell(Stage::Preparing, share);
                let volume = dotwork_volume::prepare(&self.volume, &preparation, &watch, &mut said)
                    .map_err(|e| self.error(e))?;
                Prepared { volume: Arc::new(volume), features: Arc::default(), said }
            }
        };
        if again {
            kept.push((preparation, prepared.clone()));
        }
        warnings.append(prepared.said.clone());
        Ok(prepared)
    }

    /// The features of the volume, prepared as `style` says.
    ///
    /// # Errors
    /// As [`VolumeInput::prepared`], and if the volume has no boundaries.
    pub fn features(&self, style: &Style, warnings: &mut Warnings) -> Result<Features, FileError> {
        let prepared = self.prepare(style, self.keep, warnings)?;
        self.watch.tell(Stage::Surface, 0.0);
        prepared.features().cloned().map_err(|e| self.error(e))
    }

    /// What becomes objects: a surface for each label of a segmentation, for each step of a transfer function, or the one
    /// of [`VolumeInput::surface`]; after each the faces of the cut, if `style` clips it.
    ///
    /// # Errors
    /// As [`VolumeInput::surface`]; [`FileError::Clip`].
    pub fn meshes(
        &self,
        style: &Style,
        iso: Option<f64>,
        warnings: &mut Warnings,
    ) -> Result<Vec<MeshFile>, FileError> {
        let mut all = Vec::new();
        for part in self.parts(style, iso, warnings)? {
            all.extend(part.clipped(style)?);
        }
        Ok(all)
    }

    /// The surface where the volume, prepared as `style` says, has the value `iso`; without one, of the feature that
    /// `style` names. Parts are kept as `style` says.
    ///
    /// # Errors
    /// [`FileError::Volume`]: no value of the volume lies on either side of `iso`, there is no such feature, or what
    /// [`VolumeInput::prepared`] says.
    pub fn surface(
        &self,
        style: &Style,
        iso: Option<f64>,
        warnings: &mut Warnings,
    ) -> Result<MeshFile, FileError> {
        self.surface_of(style, iso, self.keep, warnings)
    }

    /// As [`VolumeInput::surface`]; what is prepared is kept if it is needed `again`.
    pub(super) fn surface_of(
        &self,
        style: &Style,
        iso: Option<f64>,
        again: bool,
        warnings: &mut Warnings,
    ) -> Result<MeshFile, FileError> {
        let prepared = self.prepare(style, again, warnings)?;
        self.watch.tell(Stage::Surface, 0.0);
        let mut notes = Vec::new();
        let iso = match iso {
            Some(iso) => iso,
            None => {
                let features = prepared.features().map_err(|e| self.error(e))?;
                let (name, iso) = choose(features, style.feature).map_err(|e| self.error(e))?;
                notes.push(format!(
                    "feature {name} of {}, its surface at {}",
                    features.features.len(),
                    short(iso)
                ));
                iso
            }
        };
        let keep = match style.keep {
            Keep::Auto => dotwork_volume::Keep::Auto,
            Keep::All => dotwork_volume::Keep::All,
            Keep::Largest(n) => dotwork_volume::Keep::Largest(n as usize),
        };
        let mut volume = prepared.volume;
        if keep != dotwork_volume::Keep::All {
            // Others that share it have parts of their own.
            let (mut own, shared) = match Arc::try_unwrap(volume) {
                Ok(own) => (own, None),
                Err(shared) => (Volume::clone(&shared), Some(shared)),
            };
            let parts = dotwork_volume::keep_components(&mut own, iso, keep).map_err(|e| self.error(e))?;
            if parts.kept < parts.found {
                notes.push(format!(
                    "{} of {} parts kept (keep=all keeps the specks)",
                    parts.kept, parts.found
                ));
            }
            volume = match shared {
                Some(shared) if parts.kept == parts.found => shared,
                _ => Arc::new(own),
            };
        }
        let affine = volume.affine();
        let world = World { space: affine.space, unit: affine.unit };
        let mut raw =
            volume.isosurface(iso, &IsoOptions { cap: style.cap }, warnings).map_err(|e| self.error(e))?;
        if style.surface == SurfaceChoice::Ridge {
            // What cannot be understood is said where it is cut.
            let cut = ClipRegion::parse(&self.outlook().clip(style), bounds(&raw)).ok();
            let report = volume.snap_to_ridge(&mut raw, cut.as_ref());
            let share = 100.0 * report.found as f64 / report.vertices.max(1) as f64;
            notes.push(format!(
                "moved to the ridge, {} voxels in the mean; {share:.0} % has one in reach",
                short(report.moved)
            ));
        }
        let VolumeInput { name, input, format, facts, source, .. } = self;
        let [name, input, format] = [name, input, format].map(String::clone);
        let (facts, source) = (facts.clone(), Source { iso: Some(iso), ..source.clone() });
        let volume = Some(volume);
        Ok(MeshFile {
            name,
            input,
            format,
            facts,
            source,
            world,
            outlook: self.outlook(),
            notes,
            raw,
            motion: None,
            volume,
            whole: None,
            look: Look::default(),
        })
    }
}

/// The feature that a style names, and the value of its surface.
fn choose(features: &Features, choice: FeatureChoice) -> Result<(String, f64), String> {
    let list = &features.features;
    let known = || {
        let each =
            list.iter().enumerate().map(|(i, f)| format!("{} ({}, at {})", i + 1, f.name, short(f.iso)));
        each.collect::<Vec<_>>().join(", ")
    };
    let index = match choice {
        FeatureChoice::Auto => features.default,
        FeatureChoice::Outer => 0,
        FeatureChoice::Dense => list.len() - 1,
        FeatureChoice::Number(n) => n as usize - 1,
        // What is denser than the range lies inside its surface.
        FeatureChoice::Range([lo, hi]) => return Ok((format!("{}..{}", short(lo), short(hi)), lo)),
    };
    match list.get(index) {
        Some(feature) => Ok((feature.name.clone(), feature.iso)),
        None => Err(format!("there is no feature {choice}; its features are {}", known())),
    }
}

/// A value in four significant digits, or more where it has that many before the point.
pub(super) fn short(v: f64) -> String {
    let digits = if v == 0.0 { 0 } else { (3.0 - v.abs().log10().floor()).clamp(0.0, 12.0) as usize };
    let text = format!("{v:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
