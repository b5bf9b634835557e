//! Volumes that are more than one thing: segmentations, an object a label, and transfer functions, an object a surface.

use std::path::Path;

use dotwork_drawing::color::{linear_to_srgb, srgb_to_linear};
use dotwork_drawing::{Color, Warnings};
use dotwork_ink::{FeatureChoice, Style};
use dotwork_io::transfer::{TransferFile, read_transfer};
use dotwork_io::volume::{LabelEntry, LabelTable, read_label_table};
use dotwork_volume::{Label, LabelOptions, Volume, labels};

use super::FileError;
use super::input::{LoadOptions, MeshFile};
use super::outlook::Outlook;
use super::volume::VolumeInput;
use super::watch::Stage;
use crate::scene::{Source, World};

/// Ink lighter than this luminance is darkened to it: a table's colours are meant for surfaces, not for dots on paper.
const LIGHTEST: f32 = 0.25;

/// From this opacity on a surface hides all.
const OPAQUE: f64 = 0.95;

/// Places at which the gradient along a surface is looked at.
const PROBES: usize = 4096;

/// What a volume's values stand for, beside measured quantities.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Meaning {
    /// Quantities: a feature's surface is drawn, unless the file says that they are labels.
    #[default]
    Quantities,
    /// Labels, of this table if there is one.
    Labels(Option<LabelTable>),
    /// Quantities, seen through a transfer function.
    Transfer(TransferFile),
}

/// What a part of a volume looks like by its table or transfer function.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Colour of the ink.
    pub color: Option<Color>,
    /// How much it hides.
    pub occlusion: Option<f32>,
}

impl Look {
    /// `style` with this look, where the style says nothing else itself.
    pub(crate) fn over(&self, style: Style) -> Style {
        let plain = Style::default();
        let color = self.color.filter(|_| style.color == plain.color).unwrap_or(style.color);
        let occlusion =
            self.occlusion.filter(|_| style.occlusion == plain.occlusion).unwrap_or(style.occlusion);
        Style { color, occlusion, ..style }
    }
}

impl Meaning {
    /// What options say: the labels' table (`auto` or a file), or a transfer function's file and the preset in it.
    ///
    /// # Errors
    /// What reading these files gives.
    pub(crate) fn read(
        table: Option<&Path>,
        transfer: Option<(&Path, Option<&str>)>,
        warnings: &mut Warnings,
    ) -> Result<Meaning, FileError> {
        Ok(match (table, transfer) {
            (Some(path), _) if path.as_os_str() == "auto" => Meaning::Labels(None),
            (Some(path), _) => Meaning::Labels(Some(read_label_table(path, warnings)?)),
            (None, Some((path, preset))) => Meaning::Transfer(read_transfer(path, preset)?),
            (None, None) => Meaning::Quantities,
        })
    }
}

impl VolumeInput {
    /// Takes what options say of the meaning of its values, or the table that its file has.
    pub(crate) fn take(&mut self, options: &LoadOptions, warnings: &mut Warnings) -> Result<(), FileError> {
        let transfer = options.transfer.as_deref().map(|path| (path, options.transfer_name.as_deref()));
        self.meaning = match Meaning::read(options.labels.as_deref(), transfer, warnings)? {
            // A table of names in the file is what `auto` looks for.
            Meaning::Quantities | Meaning::Labels(None) if self.own_labels.is_some() => {
                Meaning::Labels(self.own_labels.clone())
            }
            meaning => meaning,
        };
        self.label = options.label;
        self.watch = options.watch.clone();
        Ok(())
    }

    /// The surfaces of the volume's labels, those that its table shows: one, if `only` names a value.
    ///
    /// # Errors
    /// [`FileError::Volume`]: the values are no labels, none of them is shown, there is no such label.
    pub(crate) fn label_parts(
        &self,
        table: Option<&LabelTable>,
        only: Option<i64>,
        warnings: &mut Warnings,
    ) -> Result<Vec<MeshFile>, FileError> {
        self.watch.tell(Stage::Surface, 0.0);
        let all = self.labels.get_or_init(|| labels(&self.volume).map_err(|e| e.to_string()));
        let all = all.as_ref().map_err(|e| self.error(e))?;
        let entry = |label: &Label| table.and_then(|t| t.find(label.value));
        let shown = |label: &&Label| match (only, entry(label)) {
            (Some(value), _) => label.value == value,
            (None, Some(entry)) => entry.visible && label.value != 0,
            // What no table mentions is drawn all the same: it is there.
            (None, None) => label.value != 0,
        };
        let shown: Vec<&Label> = all.iter().filter(shown).collect();
        if shown.is_empty() {
            let values: Vec<String> = all.iter().take(20).map(|l| l.value.to_string()).collect();
            let what =
                only.map_or("none of its labels is shown".into(), |v| format!("there is no label {v}"));
            return Err(self.error(format!("{what}; its labels are {}", values.join(", "))));
        }
        let mut parts = Vec::new();
        for (k, &label) in shown.iter().enumerate() {
            self.watch.tell(Stage::Surface, k as f32 / shown.len() as f32);
            let entry = entry(label);
            let options = LabelOptions::default();
            let raw = match self.volume.label_surface(std::slice::from_ref(label), &options) {
                Ok(raw) => raw,
                Err(e) if only.is_some() => return Err(self.error(e)),
                Err(e) => {
                    warnings.say(format!("label {} is left out: {e}", label.value));
                    continue;
                }
            };
            let mut part = self.part(name_of(label, entry), raw);
            part.source.label = Some(label.value);
            part.look.color = entry.map(|e| ink(e.color.map(srgb_to_linear)));
            parts.push(part);
        }
        Ok(parts)
    }

    /// The surfaces that a transfer function shows, the most opaque last.
    ///
    /// # Errors
    /// [`FileError::Volume`]: it shows nothing of this volume; and as [`VolumeInput::prepared`].
    pub(crate) fn transfer_parts(
        &self,
        file: &TransferFile,
        style: &Style,
        warnings: &mut Warnings,
    ) -> Result<Vec<MeshFile>, FileError> {
        let mut parts = Vec::new();
        let surfaces = file.function.surfaces();
        for (k, surface) in surfaces.iter().enumerate() {
            let mut said = Warnings::new();
            let again = self.keeps() || k + 1 < surfaces.len();
            // A surface at a value that the volume does not have is none.
            let Ok(mut part) = self.surface_of(style, Some(surface.value), again, &mut said) else {
                continue;
            };
            let steepness = gradient_along(part.volume.as_deref().unwrap_or(&self.volume), &part);
            let opacity = surface.opacity * file.function.gradient_opacity(steepness);
            part.name = format!("{}-{}", self.name, super::volume::short(surface.value));
            let [r, g, b] = surface.color.map(|c| srgb_to_linear((c * 255.0).round() as u8));
            part.look = Look {
                color: Some(ink([r, g, b])),
                occlusion: Some(if opacity >= OPAQUE { 1.0 } else { opacity as f32 }),
            };
            said.iter().for_each(|w| warnings.say(w.to_string()));
            parts.push((opacity, part));
        }
        if parts.is_empty() {
            return Err(self.error("the transfer function shows none of its values"));
        }
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(parts.into_iter().map(|(_, part)| part).collect())
    }

    /// A part of this volume with a surface of its own.
    fn part(&self, name: String, raw: dotwork_mesh::RawMesh) -> MeshFile {
        let affine = self.volume.affine();
        MeshFile {
            name,
            input: self.input.clone(),
            format: self.format.clone(),
            facts: Vec::new(),
            source: Source { ..self.source.clone() },
            world: World { space: affine.space, unit: affine.unit },
            // Labels and steps have no values to show on a cut.
            outlook: Outlook { slices: false, ..self.outlook() },
            notes: Vec::new(),
            raw,
            motion: None,
            volume: None,
            whole: None,
            look: Look::default(),
        }
    }

    /// What becomes objects of this volume: its labels, the surfaces of a transfer function, or a feature.
    ///
    /// # Errors
    /// As [`VolumeInput::surface`], and for labels and transfer functions that do not fit.
    pub(crate) fn parts(
        &self,
        style: &Style,
        iso: Option<f64>,
        warnings: &mut Warnings,
    ) -> Result<Vec<MeshFile>, FileError> {
        let asked = iso.is_some() || style.feature != FeatureChoice::Auto;
        match &self.meaning {
            _ if self.label.is_some() => {
                let table = match &self.meaning {
                    Meaning::Labels(table) => table.as_ref(),
                    _ => None,
                };
                self.label_parts(table, self.label, warnings)
            }
            Meaning::Labels(table) if !asked => self.label_parts(table.as_ref(), None, warnings),
            Meaning::Transfer(file) if !asked => self.transfer_parts(file, style, warnings),
            _ => Ok(vec![self.surface(style, iso, warnings)?]),
        }
    }
}

fn name_of(label: &Label, entry: Option<&LabelEntry>) -> String {
    match entry {
        Some(entry) if !entry.name.trim().is_empty() => entry.name.trim().into(),
        _ => format!("label-{}", label.value),
    }
}

/// A colour (linear light) as ink: of its hue, and dark enough to make tones on paper.
fn ink([r, g, b]: [f32; 3]) -> Color {
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let factor = if luminance > LIGHTEST { LIGHTEST / luminance } else { 1.0 };
    let [r, g, b] = [r, g, b].map(|c| linear_to_srgb(c * factor));
    Color { r, g, b }
}

/// The median length of the gradient along a surface, values per world unit.
fn gradient_along(volume: &Volume, part: &MeshFile) -> f64 {
    let affine = volume.affine();
    let inverse = affine.linear.inverse();
    let dims = volume.dims();
    let step = part.raw.positions.len().div_ceil(PROBES).max(1);
    let mut lengths: Vec<f64> = part
        .raw
        .positions
        .iter()
        .step_by(step)
        .map(|p| {
            let world = glam::DVec3::from_array([0, 1, 2].map(|k| part.raw.origin[k] + f64::from(p[k])));
            let index = inverse * (world - affine.origin);
            let at = |k: usize| (index[k].round().max(0.0) as usize).min(dims[k] - 1);
            let voxel = [at(0), at(1), at(2)];
            let difference = |k: usize| {
                let (mut low, mut high) = (voxel, voxel);
                low[k] = voxel[k].saturating_sub(1);
                high[k] = (voxel[k] + 1).min(dims[k] - 1);
                let value = |v: [usize; 3]| volume.value_at(v[0], v[1], v[2]);
                (value(high) - value(low)) / (high[k] - low[k]).max(1) as f64
            };
            let along = glam::DVec3::new(difference(0), difference(1), difference(2));
            (inverse.transpose() * along).length()
        })
        .filter(|v| v.is_finite())
        .collect();
    let middle = lengths.len() / 2;
    if lengths.is_empty() { 0.0 } else { *lengths.select_nth_unstable_by(middle, f64::total_cmp).1 }
}
