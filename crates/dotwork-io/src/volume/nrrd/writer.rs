//! Volumes as NRRD files, gzipped: what every imaging program opens.

use std::io::{self, Write};

use dotwork_volume::{Sample, SampleType, Space, Unit, Volume, with_samples};
use flate2::Compression;
use flate2::write::GzEncoder;

/// Samples that are encoded at once.
const CHUNK: usize = 1 << 14;

/// Writes a volume with its spacing, place and orientation, little endian. Samples keep their type, but NRRD has no
/// scaling: where a volume has one, its values are written as `float`.
///
/// # Errors
/// Those of `out`.
pub fn write_nrrd(volume: &Volume, out: impl Write) -> io::Result<()> {
    let mut out = io::BufWriter::new(out);
    let affine = volume.affine();
    let [x, y, z] = volume.dims();
    let scaling = volume.scaling();
    let kind = match scaling.is_identity() {
        true => volume.samples().sample_type(),
        false => SampleType::F32,
    };
    // Older readers know `float` and `double` only.
    let kind = match kind {
        SampleType::F32 => "float",
        SampleType::F64 => "double",
        other => other.name(),
    };
    writeln!(out, "NRRD0005\ntype: {kind}\ndimension: 3\nsizes: {x} {y} {z}")?;
    match affine.space {
        Space::Patient => writeln!(out, "space: left-posterior-superior")?,
        _ => writeln!(out, "space dimension: 3")?,
    }
    let vector = |v: glam::DVec3| format!("({},{},{})", v.x, v.y, v.z);
    let columns = [affine.linear.x_axis, affine.linear.y_axis, affine.linear.z_axis].map(vector);
    writeln!(out, "space directions: {}\nspace origin: {}", columns.join(" "), vector(affine.origin))?;
    if affine.unit != Unit::Unknown {
        let unit = affine.unit.symbol();
        writeln!(out, "space units: \"{unit}\" \"{unit}\" \"{unit}\"")?;
    }
    writeln!(out, "endian: little\nencoding: gzip\n")?;
    let mut packed = GzEncoder::new(out, Compression::default());
    with_samples!(volume.samples(), samples => {
        let mut bytes = Vec::with_capacity(CHUNK * 8);
        for chunk in samples.chunks(CHUNK) {
            bytes.clear();
            if scaling.is_identity() {
                chunk.iter().for_each(|s| bytes.extend_from_slice(&s.to_le_bytes()));
            } else {
                let value = |s: f64| (scaling.value(s) as f32).to_le_bytes();
                chunk.iter().for_each(|s| bytes.extend_from_slice(&value(s.to_f64())));
            }
            packed.write_all(&bytes)?;
        }
    });
    packed.finish()?.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{VolumeOptions, read_volume_bytes};
    use dotwork_drawing::Warnings;
    use dotwork_volume::{Affine, Samples, Scaling};
    use std::path::Path;

    #[test]
    fn what_is_written_is_read_again() {
        let mut affine = Affine::from_spacing([0.5, -2.0, 1.25]);
        affine.linear.x_axis.z = 0.125;
        affine.origin = glam::DVec3::new(-100.5, 20.0, 1e-3);
        (affine.space, affine.unit) = (Space::Patient, Unit::Millimetre);
        let samples = Samples::I16((0..60).map(|i| i * 500 - 15_000).collect());
        let volume = Volume::new([3, 4, 5], samples, Scaling::default(), affine).unwrap();
        let mut bytes = Vec::new();
        write_nrrd(&volume, &mut bytes).unwrap();
        let mut warnings = Warnings::new();
        let none = &mut |_: &Path| unreachable!("it is one file");
        let file =
            read_volume_bytes(Path::new("a.nrrd"), &bytes, &VolumeOptions::default(), none, &mut warnings);
        assert_eq!(file.unwrap().volume, volume);
        assert!(warnings.is_empty());
    }

    #[test]
    fn scaled_samples_are_written_as_values() {
        let scaling = Scaling { slope: 0.5, intercept: -1000.0 };
        let affine = Affine::from_spacing([1.0; 3]);
        let volume = Volume::new([2, 2, 2], Samples::U8((0..8).collect()), scaling, affine).unwrap();
        let mut bytes = Vec::new();
        write_nrrd(&volume, &mut bytes).unwrap();
        let none = &mut |_: &Path| unreachable!("it is one file");
        let options = VolumeOptions::default();
        let file =
            read_volume_bytes(Path::new("a.nrrd"), &bytes, &options, none, &mut Warnings::new()).unwrap();
        assert_eq!(file.volume.samples(), &Samples::F32((0..8).map(|i| 0.5 * i as f32 - 1000.0).collect()));
        assert_eq!(file.volume.value_at(1, 1, 1), -996.5);
    }
}
