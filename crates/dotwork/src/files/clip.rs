//! Objects cut open: what is clipped away, and the faces of the cut.

use dotwork_drawing::color::linear_to_srgb;
use dotwork_ink::Style;
use dotwork_mesh::{ClipRegion, RawMesh, clip};
use dotwork_volume::{CutFace, CutPlane, cut_faces};
use glam::DVec3;

use super::FileError;
use super::input::MeshFile;
use super::parts::Look;
use crate::scene::Source;

/// Ink of the densest part of a cut, and how much more the least dense has: of the latter, the power.
const CUT: (f64, f64, f64) = (0.02, 0.62, 1.2);

impl MeshFile {
    /// This surface without what `style` clips away, and after it the faces of the cut, if it is that of a volume.
    ///
    /// # Errors
    /// [`FileError::Clip`]: the clip cannot be understood, or nothing is left.
    pub(crate) fn clipped(mut self, style: &Style) -> Result<Vec<MeshFile>, FileError> {
        let text = &style.clip.0;
        if text.is_empty() {
            return Ok(vec![self]);
        }
        let error =
            |input: &str, reason: String| FileError::Clip { input: input.into(), clip: text.clone(), reason };
        let region =
            ClipRegion::parse(text, bounds(&self.raw)).map_err(|reason| error(&self.input, reason))?;
        self.raw = clip(&self.raw, &region);
        let mut all = Vec::new();
        if let (Some(volume), Some(iso)) = (&self.volume, self.source.iso) {
            let cut = cut_faces(volume, iso, &region);
            let range = cut.range().unwrap_or_default();
            for (k, face) in cut.faces.iter().enumerate() {
                all.push(MeshFile {
                    name: format!("{}-cut", self.name),
                    input: self.input.clone(),
                    format: self.format.clone(),
                    facts: Vec::new(),
                    source: Source { cut: Some(k as u32), ..self.source.clone() },
                    world: self.world,
                    up: self.up,
                    notes: Vec::new(),
                    raw: flat(&cut, face, range),
                    volume: None,
                    look: Look::default(),
                });
            }
        }
        if self.raw.triangles.is_empty() && all.is_empty() {
            return Err(error(&self.input, "nothing is left".into()));
        }
        if !self.raw.triangles.is_empty() {
            all.insert(0, self);
        }
        Ok(all)
    }

    /// The style of this part of an object that is drawn in `style`: a cut shows its values.
    pub fn style(&self, style: Style) -> Style {
        match self.source.cut {
            None => self.look.over(style),
            Some(_) => Style { texture: 1.0, back: 0.0, ..style },
        }
    }
}

/// One face of a cut, its values as colours: dark where they are low.
fn flat(cut: &CutFace, face: &CutPlane, [low, high]: [f64; 2]) -> RawMesh {
    let first = face.vertices.start as u32;
    let (base, more, power) = CUT;
    let color = |&value: &f32| {
        let u = ((high - f64::from(value)) / (high - low).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let grey = linear_to_srgb((1.0 - base - more * u.powf(power)) as f32);
        [grey, grey, grey, 255]
    };
    RawMesh {
        positions: cut.mesh.positions[face.vertices.clone()].to_vec(),
        normals: cut.mesh.normals[face.vertices.clone()].to_vec(),
        triangles: cut.mesh.triangles[face.triangles.clone()].iter().map(|t| t.map(|v| v - first)).collect(),
        colors: cut.values[face.vertices.clone()].iter().map(color).collect(),
        origin: cut.mesh.origin,
        polygons: face.triangles.len(),
    }
}

/// The box of a mesh, world units.
fn bounds(raw: &RawMesh) -> [DVec3; 2] {
    let origin = DVec3::from_array(raw.origin);
    let point = |p: &[f32; 3]| origin + DVec3::from_array(p.map(f64::from));
    let finite = raw.positions.iter().map(point).filter(|p| p.is_finite());
    finite.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}
