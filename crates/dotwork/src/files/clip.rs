//! Objects cut open: what is clipped away, and the faces of the cut.

use dotwork_drawing::color::linear_to_srgb;
use dotwork_ink::{Clip, Style};
use dotwork_mesh::{ClipRegion, RawMesh, clip};
use dotwork_volume::{CutFace, CutPlane, cut_faces};
use glam::{DVec3, Vec3};

use super::FileError;
use super::input::MeshFile;
use super::parts::Look;
use crate::scene::Source;

/// Ink of the densest part of a cut, and how much more the least dense has: of the latter, the power.
const CUT: (f64, f64, f64) = (0.02, 0.72, 1.2);

/// How much of a cut's tone follows the rank of its values; the rest follows the values themselves. Tissues that hardly
/// differ, as the gray and the white matter of a brain, but cover much of the cut stand apart by rank; by rank alone the
/// noise within one of them would look like as much.
const BY_RANK: f64 = 0.5;

impl MeshFile {
    /// This surface without what `style` clips away, and after it the faces of the cut, if it is that of a volume.
    ///
    /// # Errors
    /// [`FileError::Clip`]: the clip cannot be understood, or nothing is left.
    pub(crate) fn clipped(mut self, style: &Style) -> Result<Vec<MeshFile>, FileError> {
        let text = &self.outlook.clip(style);
        let whole = bounds(&self.raw);
        self.whole = self.volume.is_some().then_some(whole);
        if text.is_empty() {
            return Ok(vec![self]);
        }
        let error =
            |input: &str, reason: String| FileError::Clip { input: input.into(), clip: text.clone(), reason };
        let region = ClipRegion::parse(text, whole).map_err(|reason| error(&self.input, reason))?;
        self.raw = clip(&self.raw, &region);
        if self.motion.take().is_some() {
            self.notes.push("is cut open and stands still".into());
        }
        let mut all = Vec::new();
        if let (Some(volume), Some(iso)) = (&self.volume, self.source.iso) {
            let cut = cut_faces(volume, iso, &region);
            let inks = inks(&cut);
            for (k, face) in cut.faces.iter().enumerate() {
                all.push(MeshFile {
                    name: format!("{}-cut", self.name),
                    input: self.input.clone(),
                    format: self.format.clone(),
                    facts: Vec::new(),
                    source: Source { cut: Some(k as u32), ..self.source.clone() },
                    world: self.world,
                    outlook: self.outlook,
                    notes: Vec::new(),
                    raw: flat(&cut, face, &inks),
                    motion: None,
                    volume: None,
                    whole: None,
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

    /// The normals of the planes at which `style` cuts; they point to what is removed.
    pub(crate) fn cut_sides(&self, style: &Style) -> Vec<Vec3> {
        // The directions of planes do not depend on the box in which they are placed.
        let region = ClipRegion::parse(&self.outlook.clip(style), [DVec3::ZERO, DVec3::ONE]);
        region.map_or_else(|_| Vec::new(), |r| r.planes().iter().map(|p| p.normal.as_vec3()).collect())
    }

    /// The style of this part of an object that is drawn in `style`: a cut shows its values.
    pub fn style(&self, style: Style) -> Style {
        // What was cut by itself is said, so that it is cut so again.
        let cut = self.outlook.clip(&style);
        let style = if cut.is_empty() { style } else { Style { clip: Clip::Planes(cut), ..style } };
        match self.source.cut {
            None => self.look.over(style),
            Some(_) => Style { texture: 1.0, back: 0.0, ..style },
        }
    }
}

/// The ink of each vertex of a cut, 0…1: dark where values are low, beside the others of all its faces.
fn inks(cut: &CutFace) -> Vec<f64> {
    let [low, high] = cut.range().unwrap_or_default();
    let (base, more, power) = CUT;
    let ink = |(&value, &rank): (&f32, &f32)| {
        let by_value = ((high - f64::from(value)) / (high - low).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let by_rank = 1.0 - f64::from(rank);
        base + more * (by_value + BY_RANK * (by_rank - by_value)).powf(power)
    };
    cut.values.iter().zip(&cut.ranks()).map(ink).collect()
}

/// One face of a cut, its ink as colours.
fn flat(cut: &CutFace, face: &CutPlane, inks: &[f64]) -> RawMesh {
    let first = face.vertices.start as u32;
    let color = |&ink: &f64| {
        let grey = linear_to_srgb((1.0 - ink) as f32);
        [grey, grey, grey, 255]
    };
    RawMesh {
        positions: cut.mesh.positions[face.vertices.clone()].to_vec(),
        normals: cut.mesh.normals[face.vertices.clone()].to_vec(),
        triangles: cut.mesh.triangles[face.triangles.clone()].iter().map(|t| t.map(|v| v - first)).collect(),
        colors: inks[face.vertices.clone()].iter().map(color).collect(),
        origin: cut.mesh.origin,
        polygons: face.triangles.len(),
        in_order: None,
        paint: None,
        tracks: Vec::new(),
    }
}

/// The box of a mesh, world units.
pub(super) fn bounds(raw: &RawMesh) -> [DVec3; 2] {
    let origin = DVec3::from_array(raw.origin);
    let point = |p: &[f32; 3]| origin + DVec3::from_array(p.map(f64::from));
    let finite = raw.positions.iter().map(point).filter(|p| p.is_finite());
    finite.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

#[cfg(test)]
mod tests {
    use dotwork_volume::Volume;

    use super::*;

    #[test]
    fn what_hardly_differs_but_covers_much_stands_apart() {
        // Fluid, gray and white matter side by side, a tenth and two halves of the rest.
        const X: usize = 101;
        let value = |i: usize| match i % X {
            0..=9 => 100u8,
            10..=54 => 190,
            _ => 200,
        };
        let samples: Vec<u8> = (0..X * 21 * 5).map(value).collect();
        let volume = Volume::from_vec([X, 21, 5], [1.0; 3], samples).unwrap();
        let region = ClipRegion::parse("z>0.5", volume.bounds()).unwrap();
        let cut = cut_faces(&volume, 50.0, &region);
        let inks = inks(&cut);
        let of = |tissue: f32| {
            let at = cut.values.iter().position(|&v| v == tissue).unwrap();
            inks[at]
        };
        let [fluid, gray, white] = [100.0, 190.0, 200.0].map(of);
        // By value alone it would be 0.02 + 0.72 * 0.1^1.2 = 0.065 beside 0.02.
        assert!(fluid > gray + 0.3 && gray > white + 0.12, "{fluid} {gray} {white}");
        assert!((0.02..0.1).contains(&white) && (0.65..=0.74).contains(&fluid), "{white} {fluid}");
        // Denser is never darker.
        let mut order: Vec<usize> = (0..inks.len()).collect();
        order.sort_by(|&a, &b| cut.values[a].total_cmp(&cut.values[b]));
        assert!(order.windows(2).all(|w| inks[w[0]] >= inks[w[1]]));
    }
}
