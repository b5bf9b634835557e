//! From slices with positions to a regular grid.
//!
//! Slices are sorted by their position along the normal of their planes, never by name or number. Of several at one
//! place (times, echoes, weightings in one series) one is taken, of the same kind throughout. The grid has the median
//! distance:
//!
//! * distances that are whole multiples of it (within a tenth) leave holes, which are filled by interpolating
//!   linearly between the two slices around them;
//! * where distances are anything else, all slices are interpolated to the grid;
//! * a hole wider than an eighth of the slices (and than two of them) is no missing slice but the end of a stack: the
//!   longest piece is taken.
//!
//! A stack whose slices are shifted along their planes (the tilt of a gantry) keeps its shift: the affine is sheared.

use dotwork_drawing::Warnings;
use dotwork_volume::{Affine, Space, Unit};
use glam::DVec3;

use crate::error::ReadErrorKind;
use crate::volume::dicom::series::{Scan, Slice, place};
use crate::volume::facts::Facts;
use crate::volume::grid;

/// Distances this close to a multiple of the median (in medians) count as that multiple.
const EVEN: f64 = 0.1;

/// Distances that differ from the mean by more than this share of it are said.
const JITTER: f64 = 0.02;

/// A tilt from which it is said, degrees.
const TILTED_DEG: f64 = 0.2;

/// Slices closer than this are at one place, mm.
const SAME_PLACE: f64 = 1e-4;

/// A slice of the grid: of two of the stack, `t` of the way from the first to the second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mix {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) t: f64,
}

/// Slices in order and the grid that they make.
pub(super) struct Grid {
    pub(super) slices: Vec<Slice>,
    /// Empty if the slices are the grid.
    pub(super) mixes: Vec<Mix>,
    pub(super) affine: Affine,
}

/// Puts the slices of a stack in order and finds their grid.
///
/// # Errors
/// More holes than slices.
pub(super) fn arrange(
    mut slices: Vec<Slice>,
    scans: &[Scan],
    facts: &mut Facts,
    warnings: &mut Warnings,
) -> Result<Grid, ReadErrorKind> {
    let first = slices[0].of(scans);
    let spacing = first.spacing.unwrap_or_else(|| {
        warnings.say("DICOM without a pixel spacing: 1 assumed");
        [1.0; 2]
    });
    let distance = scans[slices[0].scan].image.distance;
    let Some(place_of_first) = first.place else {
        return Ok(without_places(slices, scans, spacing, distance, facts, warnings));
    };
    let normal = place_of_first.across.cross(place_of_first.down).normalize_or_zero();
    let origin = |s: Slice| s.of(scans).place.map_or(DVec3::ZERO, |p| p.origin);
    let along = |s: Slice| origin(s).dot(normal);
    slices = distinct(slices, scans, &along, warnings);
    slices = longest_piece(slices, scans, &along, warnings);

    let heights: Vec<f64> = slices.iter().map(|&s| along(s)).collect();
    let n = slices.len();
    let (mixes, count) = regular(&heights, &slices, scans, warnings)?;
    let step = if n > 1 {
        (origin(slices[n - 1]) - origin(slices[0])) / (count - 1) as f64
    } else {
        normal
            * distance.unwrap_or_else(|| {
                warnings.say("a single DICOM slice without a thickness: 1 mm assumed");
                1.0
            })
    };
    check_line(&slices, &heights, &origin, spacing, warnings);
    let tilt = step.angle_between(normal).to_degrees();
    if n > 1 && tilt > TILTED_DEG {
        warnings.say(format!(
            "the slices are stacked {tilt:.1}° off their normal (a tilted gantry): kept as a sheared grid"
        ));
        facts.add("tilt", format!("{tilt:.2}°"));
    }
    facts.add("slices", format!("{n}, {} mm apart", round(step.length())));
    if count > n {
        facts.add("missing slices", (count - n).to_string());
    }
    let steps = [place_of_first.across * spacing[0], place_of_first.down * spacing[1], step];
    let affine = grid::affine(steps.map(Some), origin(slices[0]), Space::Patient, Unit::Millimetre, warnings);
    Ok(Grid { slices, mixes, affine })
}

/// A length for people.
fn round(mm: f64) -> f64 {
    (mm * 1e4).round() / 1e4
}

/// Slices that lie nowhere: radiographs, photographs, clips.
fn without_places(
    mut slices: Vec<Slice>,
    scans: &[Scan],
    spacing: [f64; 2],
    distance: Option<f64>,
    facts: &mut Facts,
    warnings: &mut Warnings,
) -> Grid {
    // Places where all have one, otherwise numbers; stable, so that equal ones stay in order of their files.
    let located = slices.iter().all(|s| s.of(scans).location.is_some());
    let key = |s: &Slice| {
        let frame = s.of(scans);
        (frame.location.filter(|_| located).unwrap_or(0.0), frame.instance)
    };
    slices.sort_by(|a, b| key(a).0.total_cmp(&key(b).0).then_with(|| key(a).1.cmp(&key(b).1)));
    let n = slices.len();
    if n > 1 {
        warnings.say(format!(
            "the DICOM images have no position: in the order of their {}, {} assumed",
            if located { "slice locations" } else { "numbers" },
            distance.map_or("1 mm apart".into(), |d| format!("{} mm apart", round(d)))
        ));
    }
    facts.add("slices", n.to_string());
    let steps = [DVec3::X * spacing[0], DVec3::Y * spacing[1], DVec3::Z * distance.unwrap_or(1.0)];
    let affine = grid::affine(steps.map(Some), DVec3::ZERO, Space::Unknown, Unit::Millimetre, warnings);
    Grid { slices, mixes: Vec::new(), affine }
}

/// Sorts slices by height and leaves one of each place: of the kind that most slices have.
fn distinct(
    mut slices: Vec<Slice>,
    scans: &[Scan],
    along: &impl Fn(Slice) -> f64,
    warnings: &mut Warnings,
) -> Vec<Slice> {
    let mut passes = std::collections::BTreeMap::new();
    for s in &slices {
        *passes.entry(&s.of(scans).pass).or_insert(0usize) += 1;
    }
    slices.sort_by(|&a, &b| along(a).total_cmp(&along(b)));
    let total = slices.len();
    let mut kept: Vec<Slice> = Vec::with_capacity(total);
    let mut first_dropped = None;
    let rank = |s: Slice| {
        let frame = s.of(scans);
        (std::cmp::Reverse(passes.get(&frame.pass).copied()), &frame.pass, frame.instance)
    };
    for s in slices {
        match kept.last_mut() {
            Some(last) if along(s) - along(*last) < SAME_PLACE => {
                let dropped = if rank(s) < rank(*last) { std::mem::replace(last, s) } else { s };
                first_dropped.get_or_insert(dropped);
            }
            _ => kept.push(s),
        }
    }
    if let Some(first) = first_dropped {
        warnings.counted(
            "DICOM slices at the places of others (times, echoes or copies in one series) left out",
            (total - kept.len()) as u64,
            Some(place(first, scans)),
        );
    }
    kept
}

/// The lower median.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len().saturating_sub(1) / 2;
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

fn gaps(heights: &[f64]) -> Vec<f64> {
    heights.windows(2).map(|w| w[1] - w[0]).collect()
}

/// Cuts a stack where too many slices are missing.
fn longest_piece(
    slices: Vec<Slice>,
    scans: &[Scan],
    along: &impl Fn(Slice) -> f64,
    warnings: &mut Warnings,
) -> Vec<Slice> {
    let heights: Vec<f64> = slices.iter().map(|&s| along(s)).collect();
    let typical = median(gaps(&heights));
    let widest = (slices.len() as f64 / 8.0).max(2.0) + 1.5;
    let mut pieces: Vec<Vec<Slice>> = Vec::new();
    let mut cuts = Vec::new();
    for (i, &s) in slices.iter().enumerate() {
        match pieces.last_mut() {
            Some(piece) if heights[i] - heights[i - 1] <= widest * typical => piece.push(s),
            other => {
                if other.is_some() {
                    cuts.push(i);
                }
                pieces.push(vec![s]);
            }
        }
    }
    let mut longest = Vec::new();
    for piece in pieces {
        if piece.len() > longest.len() {
            longest = piece;
        }
    }
    if let Some(&at) = cuts.first() {
        warnings.counted(
            format!(
                "DICOM slices beyond a gap of {} mm (where {} mm is typical) left out",
                round(heights[at] - heights[at - 1]),
                round(typical)
            ),
            (slices.len() - longest.len()) as u64,
            Some(format!("the gap after {}", place(slices[at - 1], scans))),
        );
    }
    longest
}

/// The mixes of a regular grid (none if the slices make one) and how many slices it has.
fn regular(
    heights: &[f64],
    slices: &[Slice],
    scans: &[Scan],
    warnings: &mut Warnings,
) -> Result<(Vec<Mix>, usize), ReadErrorKind> {
    let n = heights.len();
    if n < 3 {
        return Ok((Vec::new(), n));
    }
    let gaps = gaps(heights);
    let typical = median(gaps.clone());
    let steps: Vec<f64> = gaps.iter().map(|g| (g / typical).round().max(1.0)).collect();
    let whole = |i: usize| (gaps[i] - steps[i] * typical).abs() <= EVEN * typical;
    let even = (0..n - 1).all(whole);
    let extent = heights[n - 1] - heights[0];
    let wanted = 1.0 + if even { steps.iter().sum::<f64>() } else { (extent / typical).round().max(1.0) };
    let after = |i: usize| format!("after {}", place(slices[i], scans));
    if wanted > 2.0 * n as f64 {
        return Err(ReadErrorKind::Refused(format!(
            "its {n} DICOM slices, {} mm apart for the most part, leave more holes than there are slices",
            round(typical)
        )));
    }
    let count = wanted as usize;
    let mean = extent / (count - 1) as f64;
    if !even {
        let (least, most) = gaps.iter().fold((f64::MAX, 0f64), |(a, b), &g| (a.min(g), b.max(g)));
        let odd = (0..n - 1).find(|&i| !whole(i)).map(after);
        warnings.counted(
            format!(
                "the distances of the slices vary from {} to {} mm: interpolated to even ones of {} mm",
                round(least),
                round(most),
                round(mean)
            ),
            1,
            odd,
        );
        let mut mixes = Vec::with_capacity(count);
        let mut from = 0;
        for k in 0..count {
            let height = heights[0] + mean * k as f64;
            while from + 2 < n && heights[from + 1] <= height {
                from += 1;
            }
            let t = ((height - heights[from]) / gaps[from]).clamp(0.0, 1.0);
            mixes.push(nearly_whole(Mix { from, to: from + 1, t }));
        }
        return Ok((mixes, count));
    }
    let worst = gaps.iter().zip(&steps).map(|(g, k)| (g / k / mean - 1.0).abs()).fold(0.0, f64::max);
    if worst > JITTER {
        warnings.say(format!(
            "the distances of the slices vary by {:.0} %: even ones of {} mm assumed",
            100.0 * worst,
            round(mean)
        ));
    }
    let missing = count - n;
    if missing == 0 {
        return Ok((Vec::new(), n));
    }
    let first = steps.iter().position(|&k| k > 1.0).map(after);
    warnings.counted(
        if missing == 1 {
            "slice is missing: interpolated between its neighbours"
        } else {
            "slices are missing: interpolated between their neighbours"
        },
        missing as u64,
        first,
    );
    let mut mixes = Vec::with_capacity(count);
    for (i, &k) in steps.iter().enumerate() {
        let parts = (0..k as usize).map(|j| Mix { from: i, to: i + 1, t: j as f64 / k });
        mixes.extend(parts);
    }
    mixes.push(Mix { from: n - 1, to: n - 1, t: 0.0 });
    Ok((mixes, count))
}

/// A mix that is nearly one slice is that slice.
fn nearly_whole(mix: Mix) -> Mix {
    const NEARLY: f64 = 0.02;
    match mix.t {
        t if t < NEARLY => Mix { to: mix.from, t: 0.0, ..mix },
        t if t > 1.0 - NEARLY => Mix { from: mix.to, t: 0.0, ..mix },
        _ => mix,
    }
}

/// Says if slices lie beside the line from the first to the last.
fn check_line(
    slices: &[Slice],
    heights: &[f64],
    origin: &impl Fn(Slice) -> DVec3,
    spacing: [f64; 2],
    warnings: &mut Warnings,
) {
    let (Some((&first, &last)), [low, .., high]) = (slices.first().zip(slices.last()), heights) else {
        return;
    };
    let way = origin(last) - origin(first);
    let aside = slices.iter().zip(heights).map(|(&s, h)| {
        let on_line = origin(first) + way * ((h - low) / (high - low));
        on_line.distance(origin(s))
    });
    let most = aside.fold(0.0, f64::max);
    if most > 0.25 * spacing[0].min(spacing[1]) {
        warnings.say(format!(
            "the slices lie up to {} mm beside the line from the first to the last, which is assumed",
            round(most)
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid_of(heights: &[f64]) -> (Vec<Mix>, usize, Vec<String>) {
        let mut warnings = Warnings::new();
        let frame = crate::volume::dicom::image::Frame::of_test();
        let scans = vec![Scan {
            path: "x".into(),
            length: 0,
            image: crate::volume::dicom::image::Image::of_test(vec![frame; heights.len()]),
        }];
        let slices: Vec<Slice> = (0..heights.len()).map(|frame| Slice { scan: 0, frame }).collect();
        let (mixes, count) = regular(heights, &slices, &scans, &mut warnings).unwrap();
        (mixes, count, warnings.iter().map(ToString::to_string).collect())
    }

    #[test]
    fn even_slices_are_the_grid() {
        let (mixes, count, warnings) = grid_of(&[0.0, 2.5, 5.0, 7.5]);
        assert_eq!((mixes, count, warnings), (vec![], 4, vec![]));
        let (mixes, count, warnings) = grid_of(&[0.0, 2.5, 5.1, 7.5]);
        assert_eq!((mixes, count), (vec![], 4));
        assert_eq!(warnings, ["the distances of the slices vary by 4 %: even ones of 2.5 mm assumed"]);
    }

    #[test]
    fn a_hole_is_interpolated() {
        let (mixes, count, warnings) = grid_of(&[0.0, 1.0, 4.0, 5.0, 6.0]);
        let at: Vec<f64> = mixes.iter().map(|m| m.from as f64 + m.t).collect();
        assert_eq!(count, 7);
        assert_eq!(at, [0.0, 1.0, 1.0 + 1.0 / 3.0, 1.0 + 2.0 / 3.0, 2.0, 3.0, 4.0]);
        let expected =
            "2 slices are missing: interpolated between their neighbours, first at after frame 2 of x";
        assert_eq!(warnings, [expected]);
    }

    #[test]
    fn uneven_slices_are_resampled_linearly() {
        // What is linear in the height stays linear.
        let heights = [0.0, 1.0, 2.0, 3.5, 4.5, 5.5, 7.0];
        let (mixes, count, warnings) = grid_of(&heights);
        assert_eq!(count, 8);
        for (k, m) in mixes.iter().enumerate() {
            let height = heights[m.from] * (1.0 - m.t) + heights[m.to] * m.t;
            assert!((height - k as f64).abs() < 1e-9, "{m:?} {height}");
        }
        assert!(warnings[0].starts_with("the distances of the slices vary from 1 to 1.5 mm"), "{warnings:?}");
    }
}
