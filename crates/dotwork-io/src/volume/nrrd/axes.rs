//! Which axes of an NRRD file are space, what becomes of the others, and where the voxels lie.
//!
//! An axis is space if it has a direction, or, where the file gives no directions, if its kind does not say otherwise.
//! The first three of them are x, y and z. Axes before or between them hold several numbers of a voxel and are reduced
//! to one; axes behind them hold further volumes, of which the first is taken.

use dotwork_drawing::Warnings;
use dotwork_volume::{Affine, Space, Unit};
use glam::DVec3;

use crate::error::ReadErrorKind;
use crate::volume::grid::{self, converted, lps_from_ras, unit_named, usable_spacing};
use crate::volume::nrrd::header::Header;
use crate::volume::reduce::Reduction;

/// One axis that is reduced to its first entry or to a luminance.
pub(super) struct Reduce {
    pub(super) inner: usize,
    pub(super) components: usize,
    pub(super) how: Reduction,
}

/// What is read and how.
pub(super) struct Plan {
    pub(super) dims: [usize; 3],
    /// So many axes are read whole, of the rest the first entry.
    pub(super) read_axes: usize,
    pub(super) reductions: Vec<Reduce>,
    pub(super) affine: Affine,
}

pub(super) fn plan(header: &mut Header, warnings: &mut Warnings) -> Result<Plan, ReadErrorKind> {
    let spatial = spatial_axes(header);
    let Some(&last) = spatial.last() else {
        return Err(ReadErrorKind::Refused("has no axis of space".into()));
    };
    let side = |axis: usize| {
        usize::try_from(header.sizes[axis])
            .map_err(|_| ReadErrorKind::TooLarge(format!("an axis of {} samples", header.sizes[axis])))
    };
    let mut read_axes = last + 1;
    // A colour behind the space is read whole: its planes make the luminance.
    if let Some(axis) = (last + 1..header.sizes.len()).find(|&a| header.sizes[a] > 1)
        && colours(header, axis).is_some()
    {
        read_axes = axis + 1;
    }
    let mut reductions = Vec::new();
    let mut inner = 1usize;
    for axis in 0..read_axes {
        let size = side(axis)?;
        if spatial.contains(&axis) || size == 1 {
            inner = inner.saturating_mul(size);
            continue;
        }
        let how = reduction(header, axis);
        let warning = match how {
            Reduction::Luminance => format!("{size} colours a voxel: their luminance is taken"),
            Reduction::Magnitude => "complex samples: their magnitude is taken".into(),
            Reduction::First => {
                format!("{size} values a voxel{}: the first is taken", kind_text(header, axis))
            }
        };
        // Layers of segments become one.
        if !is_layers(header, axis) {
            warnings.say(warning);
        }
        reductions.push(Reduce { inner, components: size, how });
    }
    let volumes: u64 = header.sizes[read_axes..].iter().fold(1, |n, &s| n.saturating_mul(s));
    if volumes > 1 {
        warnings.say(format!("the first of {volumes} volumes is taken"));
    }
    if header.sizes.len() != 3 || volumes > 1 || !reductions.is_empty() {
        header.facts.add_axes(&header.sizes);
    }
    let mut dims = [1; 3];
    for (dim, &axis) in dims.iter_mut().zip(&spatial) {
        *dim = side(axis)?;
    }
    let affine = affine(header, &spatial, warnings);
    Ok(Plan { dims, read_axes, reductions, affine })
}

/// The axes of space: the first three.
fn spatial_axes(header: &Header) -> Vec<usize> {
    let axes = 0..header.sizes.len();
    if !header.directions.is_empty() {
        // A time axis may have a direction whose part in space is 0.
        let has_direction = |a: &usize| {
            header.directions.get(*a).copied().flatten().is_some_and(|d| d != DVec3::ZERO && !d.is_nan())
        };
        let with: Vec<usize> = axes.clone().filter(has_direction).take(3).collect();
        if !with.is_empty() {
            return with;
        }
    }
    const SPACE: [&str; 4] = ["domain", "space", "???", "none"];
    let mut axes: Vec<usize> =
        axes.filter(|&a| header.kinds.get(a).is_none_or(|k| SPACE.contains(&k.as_str()))).collect();
    // Before three axes that have a spacing, one without is no space: the values of a voxel, by custom.
    let spacing = |a: usize| header.spacings.get(a).is_some_and(|s| !s.is_nan());
    if let [first, x, y, z, ..] = axes[..]
        && !spacing(first)
        && [x, y, z].into_iter().all(spacing)
    {
        axes.remove(0);
    }
    axes.truncate(3);
    axes
}

/// True if the entries of an axis are the layers of a segmentation.
pub(super) fn is_layers(header: &Header, axis: usize) -> bool {
    axis == 0 && !header.segments.is_empty() && header.kinds.get(0).is_some_and(|k| k == "list")
}

/// How many colours the kind of an axis says it has.
fn colours(header: &Header, axis: usize) -> Option<u64> {
    match header.kinds.get(axis)?.as_str() {
        "rgb-color" | "3-color" => Some(3),
        "rgba-color" | "4-color" => Some(4),
        _ => None,
    }
    .filter(|&n| n == header.sizes[axis])
}

fn reduction(header: &Header, axis: usize) -> Reduction {
    if colours(header, axis).is_some() {
        Reduction::Luminance
    } else if header.kinds.get(axis).is_some_and(|k| k == "complex") && header.sizes[axis] == 2 {
        Reduction::Magnitude
    } else {
        Reduction::First
    }
}

fn kind_text(header: &Header, axis: usize) -> String {
    header.kinds.get(axis).map(|k| format!(" ({k})")).unwrap_or_default()
}

fn affine(header: &Header, spatial: &[usize], warnings: &mut Warnings) -> Affine {
    let (space, to_lps) = anatomical(header.space.as_deref());
    let mut steps = [None; 3];
    let mut origin = DVec3::ZERO;
    let directed = header.directions.values.iter().flatten().any(|d| *d != DVec3::ZERO && !d.is_nan());
    if directed {
        for (step, &axis) in steps.iter_mut().zip(spatial) {
            *step = header.directions.get(axis).copied().flatten().map(to_lps);
        }
        if let Some(o) = header.origin {
            if o.is_finite() {
                origin = to_lps(o);
            } else {
                warnings.say("the space origin is not finite: 0 assumed");
            }
        }
    } else {
        if header.origin.is_some() {
            warnings.say("the space origin is ignored, as no axis has a direction");
        }
        let axis_steps: Vec<f64> = spatial
            .iter()
            .enumerate()
            .map(|(i, &axis)| declared_spacing(header, axis).map_or(1.0, |s| usable_spacing(s, i, warnings)))
            .collect();
        let complete = spatial.iter().all(|&a| declared_spacing(header, a).is_some());
        if !complete {
            warnings.say("no spacing in the file: 1 x 1 x 1 assumed");
        }
        for (i, (&axis, &s)) in spatial.iter().zip(&axis_steps).enumerate() {
            steps[i] = Some(DVec3::AXES[i] * s);
            if let Some(&min) = header.mins.get(axis)
                && min.is_finite()
            {
                // The edge of the first voxel, unless samples are said to lie on the nodes of the grid.
                origin[i] = if on_nodes(header, axis) { min } else { min + 0.5 * s };
            }
        }
    }
    let (unit, factors) = unit(header, spatial, directed, warnings);
    let steps = steps.map(|s| s.map(|s: DVec3| s * factors));
    // Without directions nothing says how the axes lie in the declared space.
    let space = if directed { space } else { Space::Unknown };
    grid::affine(steps, origin * factors, space, unit, warnings)
}

/// The unit of the world, that of its first axis, and how many of it make one of the file's along x, y and z.
fn unit(header: &Header, spatial: &[usize], directed: bool, warnings: &mut Warnings) -> (Unit, DVec3) {
    let names: Vec<&String> = if header.space_units.is_empty() {
        // Axes with directions are not those of the world, and the format gives them no units of their own.
        let axes = if directed { 1 } else { 3 };
        spatial.iter().take(axes).map_while(|&a| header.units.get(a)).collect()
    } else {
        header.space_units.iter().take(3).collect()
    };
    let named: Vec<(Unit, f64)> =
        names.iter().map(|name| unit_named(name).unwrap_or((Unit::Unknown, 1.0))).collect();
    let Some(&(unit, factor)) = named.first() else { return (Unit::Unknown, DVec3::ONE) };
    let mut factors = DVec3::splat(factor);
    for (axis, &other) in named.iter().enumerate() {
        match converted(other, unit) {
            Some(factor) => factors[axis] = factor,
            None => warnings.say("the axes have units that cannot be compared: the first is taken for all"),
        }
    }
    (unit, factors)
}

fn on_nodes(header: &Header, axis: usize) -> bool {
    header.centers.get(axis).is_some_and(|c| c == "node")
}

/// The spacing that the file gives an axis, directly or by its two ends.
fn declared_spacing(header: &Header, axis: usize) -> Option<f64> {
    let spacing = header.spacings.get(axis).copied();
    let by_ends = || {
        let (min, max) = (header.mins.get(axis)?, header.maxs.get(axis)?);
        let n = header.sizes[axis] as f64;
        Some((max - min) / if on_nodes(header, axis) { n - 1.0 } else { n })
    };
    // NaN is how the format says that nobody knows.
    spacing.filter(|s| !s.is_nan()).or_else(by_ends).or(spacing)
}

/// The space that a file declares, and how its vectors become LPS.
fn anatomical(space: Option<&str>) -> (Space, fn(DVec3) -> DVec3) {
    match space.unwrap_or_default() {
        "right-anterior-superior" | "ras" | "right-anterior-superior-time" | "rast" => {
            (Space::Patient, lps_from_ras)
        }
        "left-anterior-superior" | "las" | "left-anterior-superior-time" | "last" => {
            (Space::Patient, |v| DVec3::new(v.x, -v.y, v.z) + DVec3::ZERO)
        }
        "left-posterior-superior" | "lps" | "left-posterior-superior-time" | "lpst" => {
            (Space::Patient, |v| v)
        }
        _ => (Space::Unknown, |v| v),
    }
}
