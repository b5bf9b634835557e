//! The voxels of silhouette curves in a `.dots` file: their places follow from the grid, so that only numbers are kept.

use dotwork_ink::Vectors;
use dotwork_ink::lines::{Lattice, VoxelCurves};
use dotwork_io::dots::{DotsError, Reader, Writer};
use glam::DVec3;
use rayon::prelude::*;
use toml::{Table, Value};

use super::settings::number;
use super::{MAX_COORDINATE, ROUNDING};
use crate::curves::MAX_CURVE_VOXELS;

/// Up to this many voxels files count alike, and larger files may have one for each of their bytes: drawn, each becomes up
/// to some strokes, and a few hundred bytes.
const SMALL_FILE: usize = 256 << 10;

/// The shortest file that may hold the voxels of `all`, bytes.
pub(super) fn least_length<'a>(all: impl Iterator<Item = &'a VoxelCurves>) -> usize {
    let voxels: usize = all.map(VoxelCurves::len).sum();
    if voxels <= SMALL_FILE { 0 } else { voxels }
}

/// What is left of the voxels that a file may hold.
pub(super) struct Allowance(usize);

impl Allowance {
    pub(super) fn of(file: &Reader) -> Allowance {
        Allowance(file.length().max(SMALL_FILE))
    }
}

/// Writes the curves of object `k`, and gives what belongs in the text on its surface.
pub(super) fn write(file: &mut Writer, k: usize, curves: &VoxelCurves) -> Value {
    let section = |what: &str| format!("{k}/curves/{what}");
    let normals: Vec<f32> = (0..curves.len()).flat_map(|i| curves.normal.at(i).to_array()).collect();
    file.section_u32(&section("voxels"), &curves.voxel);
    file.section_f32(&section("normals"), &normals);
    file.section_f32(&section("magnitudes"), &curves.magnitude);
    file.section_f32(&section("laplacians"), &curves.laplacian);
    let Lattice { dims, origin, edges } = curves.lattice;
    let floats = |v: &[DVec3]| Value::Array(v.iter().flat_map(|v| v.to_array()).map(Value::Float).collect());
    let mut table = Table::new();
    table.insert("dims".into(), Value::Array(dims.iter().map(|&d| Value::Integer(d.into())).collect()));
    table.insert("origin".into(), floats(&[origin]));
    table.insert("edges".into(), floats(&edges));
    table.insert("t_log".into(), number(curves.t_log));
    table.insert("t_grad".into(), number(curves.t_grad));
    table.insert("least".into(), number(curves.least));
    Value::Table(table)
}

/// The curves of object `k` of a file.
///
/// # Errors
/// What is missing or impossible, before memory is taken for it.
pub(super) fn read(
    file: &Reader,
    k: usize,
    text: &Value,
    allowance: &mut Allowance,
) -> Result<VoxelCurves, DotsError> {
    let section = |what: &str| format!("{k}/curves/{what}");
    let broken = |what: &str| file.invalid(format!("object {k}: {what}"));
    let share = |key: &str| {
        let v = text.get(key).and_then(Value::as_float).map(|v| v as f32).filter(|v| (0.0..=1.0).contains(v));
        v.ok_or_else(|| broken(&format!("'{key}' of its curves is missing or impossible")))
    };
    let array = |key: &str| text.get(key).and_then(Value::as_array);
    let floats = |key: &str, count: usize| {
        let v: Option<Vec<f64>> = array(key).and_then(|v| v.iter().map(Value::as_float).collect());
        v.filter(|v| v.len() == count && v.iter().all(|v| v.abs() <= f64::from(MAX_COORDINATE))).ok_or_else(
            || broken(&format!("'{key}' of its curves is not {count} numbers of reasonable size")),
        )
    };
    let dims = array("dims").and_then(|v| {
        let v: Option<Vec<u32>> = v.iter().map(|v| u32::try_from(v.as_integer()?).ok()).collect();
        <[u32; 3]>::try_from(v?).ok()
    });
    let dims = dims.ok_or_else(|| broken("'dims' of its curves is not three whole numbers"))?;
    let (origin, edges) = (floats("origin", 3)?, floats("edges", 9)?);
    let three = |v: &[f64], k: usize| DVec3::new(v[k], v[k + 1], v[k + 2]);
    let lattice = Lattice { dims, origin: three(&origin, 0), edges: [0, 3, 6].map(|k| three(&edges, k)) };
    let voxels = lattice.voxels().ok_or_else(|| broken("the grid of its curves has too many voxels"))?;
    let farthest = lattice
        .edges
        .iter()
        .zip(dims)
        .fold(lattice.origin.abs(), |sum, (edge, n)| sum + edge.abs() * f64::from(n));
    if !(farthest.max_element() <= f64::from(MAX_COORDINATE) && lattice.edge().is_finite()) {
        return Err(broken("the grid of its curves is too large"));
    }
    let mut curves = VoxelCurves::none(lattice, share("t_log")?, share("t_grad")?);
    curves.least = share("least")?;

    let (_, count) = file.describe(&section("voxels"))?;
    let count = usize::try_from(count).ok().filter(|count| *count <= MAX_CURVE_VOXELS);
    let count = count.ok_or_else(|| broken("its curves have too many voxels"))?;
    allowance.0 = allowance
        .0
        .checked_sub(count)
        .ok_or_else(|| broken("its curves have more voxels than a file of this size can mean"))?;
    for (what, width) in [("normals", 3), ("magnitudes", 1), ("laplacians", 1)] {
        file.expect_length(&section(what), count.saturating_mul(width))?;
    }
    curves.voxel = file.u32s(&section("voxels"))?;
    let rising = curves.voxel.par_windows(2).all(|v| v[0] < v[1]);
    if !rising || curves.voxel.last().is_some_and(|&last| u64::from(last) >= voxels) {
        return Err(broken("the voxels of its curves are not in order or not in their grid"));
    }
    let normals = file.f32s(&section("normals"))?;
    if !normals.par_iter().all(|v| v.abs() <= 1.0 + ROUNDING) {
        return Err(broken("a normal of its curves is not a unit vector"));
    }
    let part = |k: usize| normals.iter().skip(k).step_by(3).copied().collect();
    curves.normal = Vectors { x: part(0), y: part(1), z: part(2) };
    curves.magnitude = file.f32s(&section("magnitudes"))?;
    curves.laplacian = file.f32s(&section("laplacians"))?;
    let shares = |v: &Vec<f32>| v.par_iter().all(|v| (0.0..=1.0).contains(v));
    if !shares(&curves.magnitude) || !shares(&curves.laplacian) {
        return Err(broken("a gradient or Laplacian of its curves is not a share from 0 to 1"));
    }
    curves.settle();
    Ok(curves)
}
