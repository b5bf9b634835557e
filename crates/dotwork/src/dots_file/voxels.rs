//! The voxels of a bake in a `.dots` file: the stipples follow from them, so that only they are kept.

use dotwork_drawing::Warnings;
use dotwork_ink::bake::{MAX_IN_VOXEL, VoxelSettings, Voxels, voxel};
use dotwork_ink::{Carrier, Elements, MAX_STIPPLES, Stock, Vectors};
use dotwork_io::dots::{DotsError, Reader, Writer};
use glam::Vec3;
use rayon::prelude::*;
use toml::{Table, Value};

use super::settings::number;
use super::{MAX_COORDINATE, ROUNDING};

/// Thickest slab that is let pass; the style's key ends far below.
const MAX_SLAB: f32 = 64.0;

/// Most stipples that can have been asked for in a voxel: shortened lists remember the number.
const MAX_WANTED: f32 = 1e12;

/// Most stipples that the voxels of a file become for each of its bytes, and the size up to which files count alike.
/// While it is made, a stipple takes some 100 bytes: without a limit, a file of a kilobyte could ask for gigabytes.
const STIPPLES_PER_BYTE: usize = 4;
const SMALL_FILE: usize = 256 << 10;

/// How many stipples `voxels` become at most, each of which asks for `n_max`.
fn stipples(voxels: usize, n_max: f32) -> usize {
    voxels.saturating_mul((n_max.ceil() as usize).clamp(1, MAX_IN_VOXEL)).min(MAX_STIPPLES)
}

/// How many stipples the voxels of a file may become.
fn most_stipples(file_length: usize) -> usize {
    file_length.max(SMALL_FILE).saturating_mul(STIPPLES_PER_BYTE)
}

/// The shortest file in which the voxels of `all` may become their stipples, bytes.
pub(super) fn least_length<'a>(all: impl Iterator<Item = &'a Elements>) -> usize {
    let stipples: usize = all.filter(|e| !e.are_faces()).map(|e| stipples(e.len(), e.wanted)).sum();
    if stipples <= most_stipples(0) { 0 } else { stipples.div_ceil(STIPPLES_PER_BYTE) }
}

/// What is left of the stipples that the voxels of a file may become.
pub(super) struct Allowance(usize);

impl Allowance {
    pub(super) fn of(file: &Reader) -> Allowance {
        Allowance(most_stipples(file.length()))
    }

    fn take(&mut self, stipples: usize) -> Option<()> {
        self.0 = self.0.checked_sub(stipples)?;
        Some(())
    }
}

/// Writes the voxels of object `k`, and gives what belongs in the text on its surface.
///
/// # Panics
/// If the elements are no voxels.
pub(super) fn write(file: &mut Writer, k: usize, elements: &Elements) -> Value {
    let Carrier::Voxels { edges, slab } = elements.carrier else {
        unreachable!("written where there are voxels")
    };
    let section = |what: &str| format!("{k}/voxels/{what}");
    let flat = |v: &Vectors| (0..v.len()).flat_map(|i| v.at(i).to_array()).collect::<Vec<f32>>();
    file.section_f32(&section("positions"), &flat(&elements.position));
    file.section_f32(&section("normals"), &flat(&elements.normal));
    file.section_f32(&section("magnitudes"), &elements.magnitude);
    file.section_f32(&section("values"), &elements.value);
    let mut table = Table::new();
    let edges = edges.iter().flat_map(|e| e.to_array()).map(number).collect();
    table.insert("edges".into(), Value::Array(edges));
    table.insert("n_max".into(), number(elements.wanted));
    table.insert("slab".into(), number(slab));
    table.insert("seed".into(), Value::Integer(elements.seed.into()));
    if let Some(reference) = elements.reference {
        table.insert("reference".into(), number(reference));
    }
    Value::Table(table)
}

/// The stock of object `k` of a file, baked again from its voxels.
///
/// # Errors
/// What is missing or impossible, before memory is taken for it.
pub(super) fn read(
    file: &Reader,
    k: usize,
    text: &Value,
    allowance: &mut Allowance,
) -> Result<Stock, DotsError> {
    let section = |what: &str| format!("{k}/voxels/{what}");
    let broken = |what: &str| file.invalid(format!("object {k}: {what}"));
    let float = |key: &str, fits: &dyn Fn(f32) -> bool| {
        let v = text.get(key).and_then(Value::as_float).map(|v| v as f32).filter(|v| fits(*v));
        v.ok_or_else(|| broken(&format!("'{key}' of its voxels is missing or impossible")))
    };
    let reference = match text.get("reference") {
        None => None,
        Some(_) => Some(float("reference", &|v| v > 0.0 && v.is_finite())?),
    };
    let seed = text.get("seed").and_then(Value::as_integer).and_then(|v| u32::try_from(v).ok());
    let settings = VoxelSettings {
        n_max: float("n_max", &|v| v > 0.0 && v <= MAX_WANTED)?,
        slab: float("slab", &|v| (0.0..=MAX_SLAB).contains(&v))?,
        seed: seed.ok_or_else(|| broken("'seed' of its voxels is missing or impossible"))?,
        reference,
    };
    let edges: Option<Vec<f32>> = text
        .get("edges")
        .and_then(Value::as_array)
        .and_then(|edges| edges.iter().map(|v| v.as_float().map(|v| v as f32)).collect());
    let edges = edges.as_deref().and_then(|v| <&[f32; 9]>::try_from(v).ok());
    let edges = edges
        .filter(|v| v.iter().all(|v| v.abs() <= MAX_COORDINATE))
        .map(|v| [0, 3, 6].map(|i| Vec3::new(v[i], v[i + 1], v[i + 2])))
        .ok_or_else(|| broken("the edges of its voxels are not nine numbers of reasonable size"))?;

    let volume = edges[0].cross(edges[1]).dot(edges[2]);
    if !volume.is_finite() {
        return Err(broken("the edges of its voxels are too long"));
    }

    let (_, count) = file.describe(&section("values"))?;
    let count = usize::try_from(count).ok().filter(|count| *count <= MAX_STIPPLES);
    let count = count.ok_or_else(|| broken("it has too many voxels"))?;
    allowance
        .take(stipples(count, settings.n_max))
        .ok_or_else(|| broken("its voxels become more stipples than a file of this size can mean"))?;
    for (what, width) in [("magnitudes", 1), ("positions", 3), ("normals", 3)] {
        file.expect_length(&section(what), count.saturating_mul(width))?;
    }
    let voxels = Voxels {
        position: vectors(&file.f32s(&section("positions"))?),
        normal: vectors(&file.f32s(&section("normals"))?),
        magnitude: file.f32s(&section("magnitudes"))?,
        value: file.f32s(&section("values"))?,
        edges,
    };
    let within =
        |v: &Vectors, max: f32| [&v.x, &v.y, &v.z].into_iter().all(|v| v.par_iter().all(|v| v.abs() <= max));
    if !within(&voxels.position, MAX_COORDINATE) {
        return Err(broken("a voxel's place is not a number of reasonable size"));
    }
    if !within(&voxels.normal, 1.0 + ROUNDING) {
        return Err(broken("a voxel's normal is not a unit vector"));
    }
    let share = |v: &Vec<f32>| v.par_iter().all(|v| (0.0..=1.0).contains(v));
    if !share(&voxels.magnitude) || !share(&voxels.value) {
        return Err(broken("a voxel's gradient or value is not a share from 0 to 1"));
    }
    let stock = voxel(&voxels, &settings, &mut Warnings::new());
    if stock.is_empty() {
        return Err(broken("it has no stipples"));
    }
    if !stock.baked.radius.par_iter().all(|r| *r > 0.0 && r.is_finite()) {
        return Err(broken("the edges of its voxels give stipples without a size"));
    }
    Ok(stock)
}

fn vectors(flat: &[f32]) -> Vectors {
    let part = |k: usize| flat.iter().skip(k).step_by(3).copied().collect();
    Vectors { x: part(0), y: part(1), z: part(2) }
}
