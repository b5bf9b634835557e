//! What the fuzz targets share: a reader is given bytes, and whatever it makes of them must be sound.
//!
//! A panic is a finding, and so is an error that is not one line, a mesh with a wrong index, or a volume whose samples
//! do not match its size. Each target stays with its reader: what another one would read is left alone.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use dotwork::io::transfer::{transfer_from_bytes, write_transfer};
use dotwork::io::volume::{
    RawLayout, VolumeFile, VolumeFormat, VolumeOptions, label_table_from_bytes, read_volume_bytes,
    volume_format_of,
};
use dotwork::io::{ReadError, ReadErrorKind, dots, mesh_facts, mesh_format_name, read_mesh_bytes};
use dotwork::mesh::MeshOptions;
use dotwork::volume::IsoOptions;
use dotwork::{Loaded, Mesh, RawMesh, Warnings, load};

/// Voxels up to which the surface of a volume is made too.
const SMALL: usize = 1 << 13;

/// Reads a mesh if its format begins with `format`, with what `info` tells of it, and puts it in order.
pub fn mesh(name: &str, format: &str, data: &[u8]) {
    mesh_if(name, |found| found.starts_with(format), data);
}

/// As [`mesh`], for OFF and its variants: "COFF", "STNOFF", …
pub fn off(data: &[u8]) {
    mesh_if("x.off", |found| found.contains("OFF"), data);
}

fn mesh_if(name: &str, ours: impl Fn(&str) -> bool, data: &[u8]) {
    let name = Path::new(name);
    if !mesh_format_name(name, data).is_some_and(|found| ours(&found)) {
        return;
    }
    for (name, text) in mesh_facts(name, data) {
        let fact = format!("{name}: {text}");
        // A dozen names of sixty characters, each of which may become an escape.
        assert!(!fact.contains('\n') && fact.len() < 10_000, "{fact:?}");
    }
    let mut warnings = Warnings::new();
    match read_mesh_bytes(name, data, &mut warnings) {
        Ok(raw) => build(raw, &mut warnings),
        Err(e) => one_line(&e.to_string()),
    }
    warnings.iter().for_each(|w| one_line(&w.to_string()));
}

/// Checks a raw mesh and puts it in order.
fn build(raw: RawMesh, warnings: &mut Warnings) {
    let count = raw.positions.len();
    assert!(!raw.triangles.is_empty());
    assert!(raw.triangles.iter().flatten().all(|&i| (i as usize) < count));
    assert!(raw.positions.iter().flatten().all(|v| v.is_finite()));
    assert!(raw.origin.iter().all(|v| v.is_finite()));
    assert!(raw.colors.is_empty() || raw.colors.len() == count);
    match Mesh::build(raw, &MeshOptions::default(), warnings) {
        Ok(mesh) => {
            let (positions, normals) = (mesh.positions.len(), mesh.normals.len());
            assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < positions));
            assert!(mesh.corner_normals.iter().flatten().all(|&i| (i as usize) < normals));
            assert_eq!(mesh.triangles.len(), mesh.corner_normals.len());
            assert!(
                mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3),
                "a normal is no unit vector"
            );
            assert!(mesh.area() >= 0.0 && mesh.area().is_finite());
            let (_, radius) = mesh.bounding_sphere();
            assert!(radius > 0.0 && radius.is_finite());
        }
        Err(e) => one_line(&e.to_string()),
    }
}

/// Reads a volume if it is of `format`; counts its values, and makes a surface if it is small.
pub fn volume(name: &str, format: VolumeFormat, data: &[u8]) {
    if volume_format_of(Path::new(name), data) == Some(format) {
        read_volume(name, &VolumeOptions::default(), data);
    }
}

/// As [`volume`], for NIfTI: a header whose magic says so is of a pair of files.
pub fn nifti(data: &[u8]) {
    let pair = data.get(344..347) == Some(b"ni1") || data.get(4..7) == Some(b"ni2");
    volume(if pair { "x.hdr" } else { "x.nii" }, VolumeFormat::Nifti, data);
}

/// Reads raw samples in the layout of the first line.
pub fn raw(data: &[u8]) {
    let end = data.iter().position(|&b| b == b'\n').unwrap_or(data.len());
    let Ok(text) = std::str::from_utf8(&data[..end]) else { return };
    match text.parse::<RawLayout>() {
        Ok(layout) => {
            assert_eq!(layout.to_string().parse(), Ok(layout.clone()));
            read_volume(
                "x.raw",
                &VolumeOptions { raw: Some(layout), ..VolumeOptions::default() },
                data.get(end + 1..).unwrap_or_default(),
            );
        }
        // Quotes the text, which holds no line break here but may hold anything else.
        Err(e) => assert!(!e.to_string().is_empty()),
    }
}

fn read_volume(name: &str, options: &VolumeOptions, data: &[u8]) {
    let mut warnings = Warnings::new();
    match read_volume_bytes(Path::new(name), data, options, &mut sibling, &mut warnings) {
        Ok(file) => survey(&file, data.len().is_multiple_of(2), &mut warnings),
        Err(e) => one_line(&e.to_string()),
    }
    warnings.iter().for_each(|w| one_line(&w.to_string()));
}

fn survey(file: &VolumeFile, cap: bool, warnings: &mut Warnings) {
    let volume = &file.volume;
    let voxels: usize = volume.dims().iter().product();
    assert_eq!(volume.samples().len(), voxels);
    file.facts.iter().for_each(|(name, text)| one_line(&format!("{name}: {text}")));
    one_line(&file.format);
    let range = volume.value_range();
    let stats = volume.stats();
    assert_eq!(range.is_some(), stats.is_some());
    if let Some(histogram) = volume.histogram(64) {
        assert!(!histogram.counts.is_empty() && histogram.counts.len() <= 64);
        assert!(histogram.counts.iter().sum::<u64>() <= voxels as u64);
    }
    let Some((low, high)) = range.filter(|_| voxels <= SMALL) else { return };
    assert!(low <= high, "{low} to {high}");
    match volume.isosurface(low / 2.0 + high / 2.0, &IsoOptions { cap }, warnings) {
        Ok(raw) => build(raw, warnings),
        Err(e) => one_line(&e.to_string()),
    }
}

/// The files beside a header: a ramp for samples and images, the same packed, nothing else.
fn sibling(path: &Path) -> Result<Vec<u8>, ReadError> {
    static RAMP: LazyLock<Vec<u8>> = LazyLock::new(|| (0..54_000u32).map(|i| (i / 7) as u8).collect());
    static PACKED: LazyLock<Vec<u8>> = LazyLock::new(|| {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(&RAMP).expect("a vector takes all");
        encoder.finish().expect("a vector takes all")
    });
    match path.extension().and_then(|e| e.to_str()) {
        Some("raw" | "zraw" | "img") => Ok(RAMP.clone()),
        Some("gz") => Ok(PACKED.clone()),
        _ => Err(ReadError { path: path.to_path_buf(), kind: ReadErrorKind::Missing }),
    }
}

/// A scene from a `.dots` file. Bytes that begin as one have their checksums mended, for a fuzzer does not guess them;
/// all others are taken for a list of sections.
pub fn dots(data: &[u8]) {
    let bytes = if data.starts_with(&dots::MAGIC) { mended(data) } else { boxed(data) };
    match dots::Reader::from_bytes(Path::new("x.dots"), bytes.clone()) {
        Ok(reader) => {
            let names: Vec<String> = reader.names().map(str::to_string).collect();
            for name in &names {
                let (kind, count) = reader.describe(name).expect("a section that it names");
                let length = match kind {
                    dots::Kind::Bytes => reader.bytes(name).map(|v| v.len()),
                    dots::Kind::Text => reader.text(name).map(|v| v.len()),
                    dots::Kind::F32 => reader.f32s(name).map(|v| v.len()),
                    dots::Kind::U32 => reader.u32s(name).map(|v| v.len()),
                    dots::Kind::U64 => reader.u64s(name).map(|v| v.len()),
                };
                match length {
                    Ok(length) => assert_eq!(length as u64, count),
                    Err(e) => one_line(&e.to_string()),
                }
            }
        }
        Err(e) => return one_line(&e.to_string()),
    }
    if let Some(Loaded::Scene { scene, .. }) = loaded("dots", &bytes) {
        // What was read can be written and read again.
        let again = dotwork::encode_dots(&scene);
        assert!(matches!(loaded("dots", &again), Some(Loaded::Scene { .. })));
    }
}

/// A `.dots` file with the right checksums, as far as its table can be followed.
fn mended(data: &[u8]) -> Vec<u8> {
    let mut bytes = data.to_vec();
    mend(&mut bytes);
    bytes
}

fn mend(bytes: &mut [u8]) -> Option<()> {
    let number = |bytes: &[u8], at: usize| {
        let word = bytes.get(at..at.checked_add(8)?)?;
        usize::try_from(u64::from_le_bytes(word.try_into().ok()?)).ok()
    };
    let table = number(bytes, 16)?.checked_add(24).filter(|&end| end.saturating_add(8) <= bytes.len())?;
    let (mut entry, mut stored) = (24, table + 8);
    while entry < table {
        let lengths = entry + 1 + usize::from(bytes[entry]) + 2;
        let end = stored + number(bytes, lengths + 8)?.min(bytes.len() - stored);
        let sum = dotwork::io::checksum(&bytes[stored..end]);
        bytes.get_mut(lengths + 16..lengths + 24)?.copy_from_slice(&sum.to_le_bytes());
        (entry, stored) = (lengths + 24, end);
    }
    let sum = dotwork::io::checksum(&bytes[..table]);
    bytes[table..table + 8].copy_from_slice(&sum.to_le_bytes());
    Some(())
}

/// The sections that a `.dots` file of one or two objects has.
const SECTIONS: [&str; 28] = [
    "settings",
    "surfaces",
    "0/positions",
    "0/triangles",
    "0/normals",
    "0/corner_normals",
    "0/colors",
    "0/radius",
    "0/id",
    "0/element",
    "0/weights",
    "0/voxels/positions",
    "0/voxels/normals",
    "0/voxels/magnitudes",
    "0/voxels/values",
    "0/curves/voxels",
    "0/curves/normals",
    "0/curves/magnitudes",
    "0/curves/laplacians",
    "1/positions",
    "1/triangles",
    "1/normals",
    "1/corner_normals",
    "1/colors",
    "1/radius",
    "1/id",
    "1/element",
    "1/weights",
];

/// Sections one after the other (number of the name, kind, length in two bytes, content), in a sound box.
fn boxed(data: &[u8]) -> Vec<u8> {
    let mut writer = dots::Writer::new();
    let mut names = Vec::new();
    let mut rest = data;
    while let [name, kind, low, high, after @ ..] = rest {
        let length = usize::from(u16::from_le_bytes([*low, *high])).min(after.len());
        let (content, after) = after.split_at(length);
        rest = after;
        let name = SECTIONS[usize::from(*name) % SECTIONS.len()];
        if names.contains(&name) {
            continue;
        }
        names.push(name);
        let (words, long) = (content.as_chunks::<4>().0, content.as_chunks::<8>().0);
        match kind % 5 {
            0 => writer.text(name, &String::from_utf8_lossy(content)),
            1 => writer.section_f32(name, &words.iter().map(|w| f32::from_le_bytes(*w)).collect::<Vec<_>>()),
            2 => writer.section_u32(name, &words.iter().map(|w| u32::from_le_bytes(*w)).collect::<Vec<_>>()),
            3 => writer.section_u64(name, &long.iter().map(|w| u64::from_le_bytes(*w)).collect::<Vec<_>>()),
            _ => writer.section(name, content.to_vec()),
        };
    }
    writer.finish()
}

/// A style file.
pub fn style(data: &[u8]) {
    let path = file("toml", data);
    match dotwork::read_style(&path) {
        Ok(file) => {
            for param in dotwork::ink::PARAMS {
                let mut same = file.style.clone();
                same.set(param.name, &param.get(&file.style)).expect("what a style says of itself");
            }
        }
        Err(e) => one_line(&e.to_string()),
    }
}

/// A scene file, without the files that it names.
pub fn scene(data: &[u8]) {
    match dotwork::read_scene_file(file("toml", data)) {
        Ok(scene) => {
            // Its settings fit a scene without objects, or say why not.
            if let Err(e) = scene.settings.apply(&mut dotwork::Scene::default()) {
                one_line(&e.to_string());
            }
            scene.objects.iter().for_each(|o| drop(o.own_style()));
        }
        Err(e) => one_line(&e.to_string()),
    }
}

/// A table of labels, or a transfer function, which is written and read again.
pub fn tables(data: &[u8]) {
    let name = Path::new("x.txt");
    let mut warnings = Warnings::new();
    match label_table_from_bytes(name, data, &mut warnings) {
        Ok(table) => assert!(table.entries.iter().all(|e| table.find(e.value).is_some())),
        Err(e) => one_line(&e.to_string()),
    }
    warnings.iter().for_each(|w| one_line(&w.to_string()));
    match transfer_from_bytes(name, data, None) {
        Ok(found) => {
            let mut again = Vec::new();
            write_transfer(&found, &mut again).expect("a vector takes all");
            let read = transfer_from_bytes(name, &again, None).expect("what was written");
            assert_eq!(read.function.opacity.len(), found.function.opacity.len());
            assert!(found.function.surfaces().iter().all(|s| s.value.is_finite()));
        }
        Err(e) => one_line(&e.to_string()),
    }
}

/// A picture with settings in it: found by the exporter, then understood by the facade.
pub fn plate(data: &[u8]) {
    if dotwork::export::embedded_settings(data).is_some()
        && let Some(Loaded::Plate(plate)) = loaded("png", data)
    {
        let _ = dotwork::settings_text(plate.settings());
        assert!(plate.objects().iter().all(|o| o.stipples <= dotwork::MAX_STIPPLES));
    }
}

/// What `dotwork::load` makes of a file with this content.
fn loaded(extension: &str, data: &[u8]) -> Option<Loaded> {
    let path = file(extension, data);
    let mut warnings = Warnings::new();
    let loaded = load(&path, &mut warnings);
    warnings.iter().for_each(|w| one_line(&w.to_string()));
    loaded.map_err(|e| one_line(&e.to_string())).ok()
}

/// A file of this process, which each run writes anew: put `TMPDIR` into memory.
fn file(extension: &str, data: &[u8]) -> PathBuf {
    let name = format!("dotwork-fuzz-{}.{extension}", std::process::id());
    let path = std::env::temp_dir().join(name);
    std::fs::write(&path, data).expect("the folder for temporary files can be written");
    path
}

fn one_line(message: &str) {
    assert!(!message.contains('\n') && message.len() < 2000, "{message:?}");
}
