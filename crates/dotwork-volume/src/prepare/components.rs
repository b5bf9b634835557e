//! Connected components of what lies inside an isosurface: the object is kept, the specks around it go.
//!
//! Runs of inside voxels along x are found in each row and joined (`runs`), connected by faces, edges and corners. Then
//! a voxel of one component never shares a cell
//! of the grid with another component, so taking one away leaves every triangle of the others where it was; and thin
//! bone, which a scan turns into voxels that touch at edges and corners only, stays in one piece.

use rayon::prelude::*;

use super::PrepareError;
use crate::runs::{LayerRuns, Run, Runs};
use crate::samples::Samples;
use crate::volume::Volume;

/// Samples that are compared at once.
const BLOCK: usize = 32;

/// [`Keep::Auto`] drops components smaller than this …
const SPECK: u64 = 300;

/// … and those smaller than the largest divided by this.
const SMALL: u64 = 200;

/// Sizes that a report holds.
const SIZES: usize = 16;

/// How far the blurred rim of a component reaches beyond its voxels.
const RIM: usize = 2;

/// Which components are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Keep {
    /// All.
    All,
    /// So many of the largest; of equal ones those that come first in the volume. 0 counts as 1.
    Largest(usize),
    /// Those of at least 300 voxels and at least 0.5 % of the largest; always the largest. Two lungs, or two feet,
    /// both stay.
    #[default]
    Auto,
}

/// What [`keep_components`] found and did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ComponentsReport {
    /// Components in the volume.
    pub found: usize,
    /// Those that were kept.
    pub kept: usize,
    /// Voxels of the largest components, the largest first; at most 16 of them.
    pub sizes: Vec<u64>,
    /// Voxels of all components.
    pub voxels: u64,
    /// Voxels of those that were dropped.
    pub dropped_voxels: u64,
}

/// Keeps some of the connected components of `{value >= iso}` in a prepared volume, and takes the others away: their
/// voxels and a rim of 2 voxels around them get the low value. Voxels within 2 of a component that is kept are no rim,
/// so its surface and the gradient there stay as they are.
///
/// Components are connected by faces, edges and corners. Memory is some 20 bytes for each run of voxels along x.
///
/// # Errors
/// [`PrepareError::Unprepared`] if `volume` does not come from [`prepare`](super::prepare).
///
/// ```
/// use dotwork_drawing::Warnings;
/// use dotwork_volume::{Keep, Preparation, Volume, keep_components, prepare};
///
/// // A bar, and a speck.
/// let inside = |x, y, z| (4..28).contains(&x) && y < 12 && z < 12 || [x, y, z] == [20, 20, 20];
/// let samples: Vec<u8> =
///     (0..32 * 32 * 32).map(|i| if inside(i % 32, i / 32 % 32, i / 1024) { 255 } else { 0 }).collect();
/// let volume = Volume::from_vec([32, 32, 32], [1.0; 3], samples)?;
/// let preparation = Preparation { smooth: Some(0.0), ..Preparation::default() };
/// let mut prepared = prepare(&volume, &preparation, &|_| {}, &mut Warnings::new())?;
/// let report = keep_components(&mut prepared, 127.0, Keep::Auto)?;
/// assert_eq!((report.found, report.kept, report.dropped_voxels), (2, 1, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn keep_components(volume: &mut Volume, iso: f64, keep: Keep) -> Result<ComponentsReport, PrepareError> {
    let dims = volume.dims();
    let scaling = volume.scaling();
    let Samples::U16(samples) = volume.samples_mut() else { return Err(PrepareError::Unprepared) };
    if scaling.slope < 0.0 {
        return Err(PrepareError::Unprepared);
    }
    // The smallest sample inside, to the last bit as isosurfaces have it.
    let (mut low, mut high) = (0u32, 1 << 16);
    while low < high {
        let middle = (low + high) / 2;
        if scaling.value(f64::from(middle)) >= iso { high = middle } else { low = middle + 1 }
    }
    let Ok(threshold) = u16::try_from(low) else { return Ok(ComponentsReport::default()) };

    let runs = find(samples, dims, threshold)?;
    let (report, keeps) = choose(&runs, &runs.join(), keep);
    if report.kept < report.found {
        lower(samples, dims, &runs, &keeps);
    }
    Ok(report)
}

/// The runs of samples of at least `threshold`.
fn find(samples: &[u16], [nx, ny, nz]: [usize; 3], threshold: u16) -> Result<Runs, PrepareError> {
    let too_many = || PrepareError::TooLarge { dims: [nx, ny, nz] };
    if nx > u32::MAX as usize {
        return Err(too_many());
    }
    let of_layer = |layer: &[u16]| {
        let mut runs = LayerRuns::default();
        layer.chunks_exact(nx).for_each(|row| runs.row(|runs| row_runs(row, threshold, runs)));
        runs
    };
    let layers = samples.par_chunks_exact(nx * ny).map(of_layer).collect();
    Runs::new(ny, layers).ok_or_else(too_many)
}

/// Appends the runs of a row.
fn row_runs(row: &[u16], threshold: u16, runs: &mut Vec<Run>) {
    let mut open: Option<u32> = None;
    let mut flip = |at: usize, inside: bool| match open {
        None if inside => open = Some(at as u32),
        Some(start) if !inside => {
            runs.push(Run { start, end: at as u32 });
            open = None;
        }
        _ => {}
    };
    for (block, samples) in row.chunks(BLOCK).enumerate() {
        let inside = samples.iter().map(|&s| u16::from(s >= threshold)).sum::<u16>();
        let at = block * BLOCK;
        if inside == 0 || usize::from(inside) == samples.len() {
            flip(at, inside > 0);
        } else {
            samples.iter().enumerate().for_each(|(i, &s)| flip(at + i, s >= threshold));
        }
    }
    flip(row.len(), false);
}

/// Decides, and says for each run whether it is kept.
fn choose(runs: &Runs, roots: &[u32], keep: Keep) -> (ComponentsReport, Vec<bool>) {
    // Roots, numbered in order, and their sizes.
    let mut sizes: Vec<(u32, u64)> = Vec::new();
    let mut number = vec![0u32; roots.len()];
    for (run, (&root, extent)) in roots.iter().zip(runs.all()).enumerate() {
        if root as usize == run {
            number[run] = sizes.len() as u32;
            sizes.push((root, 0));
        } else {
            number[run] = number[root as usize];
        }
        sizes[number[run] as usize].1 += extent.voxels().len() as u64;
    }
    let mut order: Vec<u32> = (0..sizes.len() as u32).collect();
    order.sort_unstable_by_key(|&c| (std::cmp::Reverse(sizes[c as usize].1), c));
    let size = |c: &u32| sizes[*c as usize].1;
    let largest = order.first().map_or(0, size);
    let kept = match keep {
        Keep::All => order.len(),
        Keep::Largest(n) => n.clamp(1, order.len().max(1)).min(order.len()),
        Keep::Auto => {
            let least = SPECK.max(largest.div_ceil(SMALL)).min(largest);
            order.partition_point(|c| size(c) >= least)
        }
    };
    let mut keeps = vec![false; sizes.len()];
    order[..kept].iter().for_each(|&c| keeps[c as usize] = true);
    let report = ComponentsReport {
        found: order.len(),
        kept,
        sizes: order.iter().take(SIZES).map(size).collect(),
        voxels: order.iter().map(size).sum(),
        dropped_voxels: order[kept..].iter().map(size).sum(),
    };
    (report, number.into_iter().map(|c| keeps[c as usize]).collect())
}

/// Gives the runs that are not kept, and their rims, the low value.
fn lower(samples: &mut [u16], [nx, ny, nz]: [usize; 3], runs: &Runs, keeps: &[bool]) {
    let around = |at: usize, n: usize| at.saturating_sub(RIM)..n.min(at + RIM + 1);
    samples.par_chunks_exact_mut(nx * ny).enumerate().for_each_init(
        || (vec![false; nx], vec![false; nx]),
        |(dropped, kept), (z, layer)| {
            for (y, row) in layer.chunks_exact_mut(nx).enumerate() {
                let near = || around(z, nz).flat_map(|z| around(y, ny).map(move |y| (y, z)));
                if near().all(|(y, z)| keeps[runs.row(y, z)].iter().all(|kept| *kept)) {
                    continue;
                }
                dropped.fill(false);
                kept.fill(false);
                for run in near().flat_map(|(y, z)| runs.row(y, z)) {
                    let Run { start, end } = runs.all()[run];
                    let reach = (start as usize).saturating_sub(RIM)..nx.min(end as usize + RIM);
                    let mask = if keeps[run] { &mut *kept } else { &mut *dropped };
                    mask[reach].fill(true);
                }
                for ((sample, dropped), kept) in row.iter_mut().zip(&*dropped).zip(&*kept) {
                    if *dropped && !*kept {
                        *sample = 0;
                    }
                }
                // Components may lie within each other's rims.
                for run in runs.row(y, z).filter(|run| !keeps[*run]) {
                    row[runs.all()[run].voxels()].fill(0);
                }
            }
        },
    );
}
