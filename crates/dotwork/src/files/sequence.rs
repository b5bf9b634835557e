//! Sequences of meshes: files of one topology, numbered, as an animation.
//!
//! Each file holds for a 24th of a second, as a frame of a film does; between two of them vertices move evenly.

use std::path::{Path, PathBuf};

use dotwork_drawing::Warnings;
use dotwork_io::Model;
use dotwork_mesh::{Clip, Motion, RawMesh};

use super::FileError;
use super::film::pattern;

/// Files a second.
const RATE: f64 = 24.0;

/// Most bytes that the places of a sequence may take.
const MOST_BYTES: usize = 4 << 30;

/// A mesh whose vertices are listed for each of its frames.
#[derive(Debug)]
struct Sequence {
    frames: Vec<Vec<[f32; 3]>>,
    clips: [Clip; 1],
}

impl Motion for Sequence {
    fn clips(&self) -> &[Clip] {
        &self.clips
    }

    fn place(&self, clip: Option<usize>, time: f64, positions: &mut Vec<[f32; 3]>) {
        let last = self.frames.len() - 1;
        let at = if clip.is_some() { (time * RATE).clamp(0.0, last as f64) } else { 0.0 };
        let (from, to) = (&self.frames[at as usize], &self.frames[(at as usize + 1).min(last)]);
        let t = at.fract() as f32;
        positions.clear();
        positions.extend(from.iter().zip(to).map(|(a, b)| [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t)));
    }
}

/// The files of a sequence in the order of their numbers, if `path` has a number in its name as `walk-%04d.obj`, and there
/// are any.
pub(super) fn files(path: &Path) -> Option<Vec<PathBuf>> {
    let name = path.file_name()?.to_str()?;
    let (before, _, after) = pattern(name).ok()??;
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let number = |name: &str| {
        let digits = name.strip_prefix(before.as_str())?.strip_suffix(after.as_str())?;
        digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse::<u32>().ok())?
    };
    let entries = std::fs::read_dir(folder).ok()?;
    let mut found: Vec<(u32, PathBuf)> = entries
        .filter_map(|entry| {
            let entry = entry.ok()?;
            Some((number(entry.file_name().to_str()?)?, path.with_file_name(entry.file_name())))
        })
        .collect();
    found.sort();
    (!found.is_empty()).then(|| found.into_iter().map(|f| f.1).collect())
}

/// Reads the files of a sequence as one mesh that moves; the format of the first, in words.
///
/// # Errors
/// A file that cannot be read, or has other triangles than the first.
pub(super) fn read(files: &[PathBuf], warnings: &mut Warnings) -> Result<(Model, String), FileError> {
    let mut first: Option<RawMesh> = None;
    let mut frames: Vec<Vec<[f32; 3]>> = Vec::new();
    let mut sums = Vec::new();
    let mut format = String::new();
    for path in files {
        let bytes = dotwork_io::read_file(path)?;
        // What is wrong with one is wrong with all: the first says it.
        let mut said = Warnings::new();
        let mesh = dotwork_io::read_model(path, &bytes, &mut said)?;
        sums.extend(mesh.checksum.to_le_bytes());
        let mesh = mesh.mesh;
        let error = |reason: String| FileError::Pose { input: path.to_string_lossy().into_owned(), reason };
        match &first {
            None => {
                format = dotwork_io::mesh_format_name(path, &bytes).unwrap_or_default();
                warnings.append(said);
                frames.push(mesh.positions.clone());
                first = Some(mesh);
            }
            Some(one) => {
                if one.positions.len() != mesh.positions.len() || one.triangles != mesh.triangles {
                    return Err(error(format!(
                        "is not of the topology of {}: {} vertices and {} triangles, there {} and {}, or others",
                        files[0].display(),
                        mesh.positions.len(),
                        mesh.triangles.len(),
                        one.positions.len(),
                        one.triangles.len()
                    )));
                }
                if (frames.len() + 1).saturating_mul(12 * mesh.positions.len()) > MOST_BYTES {
                    return Err(error(format!("the sequence takes more than {} GiB", MOST_BYTES >> 30)));
                }
                let shift = [0, 1, 2].map(|k| mesh.origin[k] - one.origin[k]);
                let near = |p: &[f32; 3]| [0, 1, 2].map(|k| (f64::from(p[k]) + shift[k]) as f32);
                frames.push(mesh.positions.iter().map(near).collect());
            }
        }
    }
    let mut mesh = first.unwrap_or_default();
    // Vertices are one only if they are together in every frame.
    let track = |v: usize| {
        let places: Vec<u8> =
            frames.iter().flat_map(|f| f[v]).flat_map(|c| (c + 0.0).to_le_bytes()).collect();
        dotwork_io::checksum(&places)
    };
    mesh.tracks = (0..mesh.positions.len()).map(track).collect();
    let seconds = frames.len() as f64 / RATE;
    let sequence = Sequence { frames, clips: [Clip { name: "sequence".into(), seconds }] };
    let motion: Option<std::sync::Arc<dyn Motion>> = Some(std::sync::Arc::new(sequence));
    let checksum = dotwork_io::checksum(&sums);
    Ok((Model { mesh, checksum, motion }, format))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn files_move_a_mesh_from_one_to_the_next() {
        let folder = tempfile::tempdir().unwrap();
        let at = |n: usize| folder.path().join(format!("w{n:02}.obj"));
        for n in 0..3 {
            // Numbers need not begin at 0; two corners are together at first and part later.
            let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 {n}\nv 1 1 0\nf 1 2 3\nf 4 5 3\n");
            fs::write(at(n + 5), text).unwrap();
        }
        fs::write(folder.path().join("wx.obj"), "no").unwrap();
        let found = files(&folder.path().join("w%02d.obj")).unwrap();
        assert_eq!(found, [at(5), at(6), at(7)]);
        let (model, format) = read(&found, &mut Warnings::new()).unwrap();
        assert_eq!(format, "OBJ");
        let motion = model.motion.unwrap();
        assert_eq!(motion.clips()[0].seconds, 3.0 / 24.0);
        let mut positions = Vec::new();
        for (time, z) in [(0.0, 0.0), (0.5 / 24.0, 0.5), (1.0 / 24.0, 1.0), (2.0 / 24.0, 2.0), (9.0, 2.0)] {
            motion.place(Some(0), time, &mut positions);
            assert_eq!(positions[3], [1.0, 0.0, z], "{time}");
        }
        assert_ne!(model.mesh.tracks[1], model.mesh.tracks[3]);
        fs::write(at(8), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let found = files(&folder.path().join("w%02d.obj")).unwrap();
        let error = read(&found, &mut Warnings::new()).err().unwrap().to_string();
        assert!(error.contains("w08.obj: is not of the topology of") && error.contains("w05.obj"), "{error}");
        assert_eq!(files(&folder.path().join("none-%d.obj")), None);
        assert_eq!(files(&at(5)), None);
    }
}
