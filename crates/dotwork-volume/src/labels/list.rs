//! Which labels a volume has.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::LabelError;
use crate::samples::Ordered;
use crate::volume::{Scaling, Volume};

/// A segmentation has no more labels than this.
pub const MAX_LABELS: usize = 4096;

/// One value of a label volume and where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Label {
    /// The value; 0 is the background by custom.
    pub value: i64,
    /// Voxels that have it.
    pub voxels: u64,
    /// Indices of the first and the last voxel of their box along x, y and z, both within.
    pub bounds: [[usize; 3]; 2],
}

impl Label {
    fn merge(&mut self, other: &Label) {
        self.voxels += other.voxels;
        for axis in 0..3 {
            self.bounds[0][axis] = self.bounds[0][axis].min(other.bounds[0][axis]);
            self.bounds[1][axis] = self.bounds[1][axis].max(other.bounds[1][axis]);
        }
    }
}

type Table = BTreeMap<i64, Label>;

/// The labels of a volume by value, in one pass; the background (0) is one of them.
///
/// Values count, not samples; floats are fine as long as every value is a whole number. Memory is a table of at most
/// [`MAX_LABELS`] entries for each layer at work.
///
/// # Errors
/// [`LabelError::NotWhole`] and [`LabelError::TooMany`] if this is no label volume.
pub fn labels(volume: &Volume) -> Result<Vec<Label>, LabelError> {
    let [nx, ny, _] = volume.dims();
    let scaling = volume.scaling();
    let merged = with_samples!(volume.samples(), samples => {
        samples
            .par_chunks_exact(nx * ny)
            .enumerate()
            .map(|(z, layer)| layer_labels(layer, nx, z, scaling))
            .reduce(|| Ok(Table::new()), merge)
    });
    Ok(merged?.into_values().collect())
}

fn merge(a: Result<Table, LabelError>, b: Result<Table, LabelError>) -> Result<Table, LabelError> {
    // Of two errors the one in the earlier layer, so that the message does not depend on threads.
    let (mut a, b) = (a?, b?);
    for (value, label) in b {
        a.entry(value).and_modify(|known| known.merge(&label)).or_insert(label);
    }
    if a.len() > MAX_LABELS { Err(LabelError::TooMany) } else { Ok(a) }
}

/// The labels of one layer, run by run.
fn layer_labels<T: Ordered>(layer: &[T], nx: usize, z: usize, scaling: Scaling) -> Result<Table, LabelError> {
    let mut table = Table::new();
    for (y, row) in layer.chunks_exact(nx).enumerate() {
        for (start, run) in runs(row) {
            let value = scaling.value(run[0].to_f64());
            let voxel = [start, y, z];
            let whole = whole(value).ok_or(LabelError::NotWhole { voxel, value })?;
            let last = [start + run.len() - 1, y, z];
            let label = Label { value: whole, voxels: run.len() as u64, bounds: [voxel, last] };
            table.entry(whole).and_modify(|known| known.merge(&label)).or_insert(label);
            if table.len() > MAX_LABELS {
                return Err(LabelError::TooMany);
            }
        }
    }
    Ok(table)
}

/// Runs of equal samples in a row, each with its place. NaN equals nothing and is a run of its own.
fn runs<T: Ordered>(row: &[T]) -> impl Iterator<Item = (usize, &[T])> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let rest = &row[at..];
        let first = *rest.first()?;
        let length = 1 + rest[1..].iter().position(|s| *s != first).unwrap_or(rest.len() - 1);
        let start = at;
        at += length;
        Some((start, &rest[..length]))
    })
}

/// The whole number that a value is, if `f64` holds it exactly.
fn whole(value: f64) -> Option<i64> {
    const EXACT: f64 = (1u64 << 53) as f64;
    (value.abs() <= EXACT && value.fract() == 0.0).then_some(value as i64)
}

/// Sets the bytes of a mask, whose border is already 0: `sides` voxels around the box of the volume from `low` to
/// before `high`.
pub(super) fn fill_mask<T: Ordered>(
    mask: &mut [u8],
    [sx, sy, _]: [usize; 3],
    samples: &[T],
    [nx, ny, _]: [usize; 3],
    scaling: Scaling,
    [low, high]: [[usize; 3]; 2],
    wanted: &[i64],
) {
    let layers = mask.par_chunks_exact_mut(sx * sy).skip(super::BORDER).take(high[2] - low[2]);
    layers.enumerate().for_each(|(z, layer)| {
        let rows = layer.chunks_exact_mut(sx).skip(super::BORDER);
        for (y, row) in rows.take(high[1] - low[1]).enumerate() {
            let first = low[0] + nx * (low[1] + y + ny * (low[2] + z));
            let row = &mut row[super::BORDER..];
            for (start, run) in runs(&samples[first..first + (high[0] - low[0])]) {
                if whole(scaling.value(run[0].to_f64())).is_some_and(|v| wanted.contains(&v)) {
                    row[start..start + run.len()].fill(1);
                }
            }
        }
    });
}
