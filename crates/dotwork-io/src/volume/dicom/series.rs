//! Which of many images make the volume: one series, and of that the images of one size and orientation.

use std::collections::BTreeMap;
use std::path::PathBuf;

use dotwork_drawing::Warnings;

use crate::error::ReadErrorKind;
use crate::volume::dicom::image::{Frame, Image, Layout, Series};
use crate::volume::facts::short;

/// Kinds of images in one series: what is different again is left out.
const MOST_KINDS: usize = 64;

/// Series named in a message.
const MOST_NAMED: usize = 8;

/// Images whose axes differ by less than this lie in one stack (cosines of directions; 0.6°).
const PARALLEL: f64 = 1.0 - 5e-5;

/// A file and its images.
pub(super) struct Scan {
    pub(super) path: PathBuf,
    /// Its bytes.
    pub(super) length: u64,
    pub(super) image: Image,
}

/// A frame of one of the scans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slice {
    pub(super) scan: usize,
    pub(super) frame: usize,
}

impl Slice {
    pub(super) fn of(self, scans: &[Scan]) -> &Frame {
        &scans[self.scan].image.frames[self.frame]
    }
}

/// Images of one size, kind and orientation.
struct Stack {
    slices: Vec<Slice>,
}

impl Stack {
    fn layout<'a>(&self, scans: &'a [Scan]) -> &'a Layout {
        &scans[self.slices[0].scan].image.layout
    }

    /// Slices first, then pixels.
    fn size(&self, scans: &[Scan]) -> (usize, usize) {
        (self.slices.len(), self.layout(scans).pixels())
    }

    fn takes(&self, slice: Slice, scans: &[Scan]) -> bool {
        self.layout(scans) == &scans[slice.scan].image.layout
            && parallel(self.slices[0].of(scans), slice.of(scans))
            && same_spacing(self.slices[0].of(scans), slice.of(scans))
    }
}

fn parallel(a: &Frame, b: &Frame) -> bool {
    match (&a.place, &b.place) {
        (Some(a), Some(b)) => a.across.dot(b.across) > PARALLEL && a.down.dot(b.down) > PARALLEL,
        (None, None) => true,
        _ => false,
    }
}

fn same_spacing(a: &Frame, b: &Frame) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * a;
    match (a.spacing, b.spacing) {
        (Some(a), Some(b)) => near(a[0], b[0]) && near(a[1], b[1]),
        (None, None) => true,
        _ => false,
    }
}

/// One series and its stacks, the largest first.
struct Candidate<'a> {
    series: &'a Series,
    stacks: Vec<Stack>,
    /// Images of still other kinds.
    beyond: u64,
}

impl Candidate<'_> {
    fn add(&mut self, slice: Slice, scans: &[Scan]) {
        match self.stacks.iter().position(|s| s.takes(slice, scans)) {
            Some(i) => self.stacks[i].slices.push(slice),
            None if self.stacks.len() < MOST_KINDS => self.stacks.push(Stack { slices: vec![slice] }),
            None => self.beyond += 1,
        }
    }

    fn images(&self) -> usize {
        self.stacks.iter().map(|s| s.slices.len()).sum()
    }

    /// It in words: "CT 2 'Routine Brain' (4 images)".
    fn name(&self) -> String {
        let Series { number, description, modality, uid, .. } = self.series;
        let mut words: Vec<String> = [modality, number].iter().map(|s| s.to_string()).collect();
        words.retain(|w| !w.is_empty());
        if !description.is_empty() {
            words.push(format!("'{description}'"));
        }
        if words.is_empty() {
            words.push(if uid.is_empty() { "without a name".into() } else { uid.clone() });
        }
        let images = self.images();
        format!("{} ({images} {})", words.join(" "), if images == 1 { "image" } else { "images" })
    }

    fn is_called(&self, wanted: &str) -> bool {
        let Series { number, description, uid, .. } = self.series;
        let wanted = short(wanted);
        *uid == wanted || *number == wanted || description.eq_ignore_ascii_case(&wanted)
    }
}

/// The slices of the series that `wanted` names (its UID, number or description), or of the largest.
///
/// # Errors
/// There is no such series; those that there are are named.
pub(super) fn choose(
    scans: &[Scan],
    wanted: Option<&str>,
    warnings: &mut Warnings,
) -> Result<(Series, Vec<Slice>), ReadErrorKind> {
    let mut by_uid: BTreeMap<&str, Candidate> = BTreeMap::new();
    for (i, scan) in scans.iter().enumerate() {
        let series = &scan.image.series;
        let candidate =
            by_uid.entry(&series.uid).or_insert_with(|| Candidate { series, stacks: Vec::new(), beyond: 0 });
        for frame in 0..scan.image.frames.len() {
            candidate.add(Slice { scan: i, frame }, scans);
        }
    }
    let mut candidates: Vec<Candidate> = by_uid.into_values().collect();
    for candidate in &mut candidates {
        // Stable: of equals the first stays.
        candidate.stacks.sort_by_key(|s| std::cmp::Reverse(s.size(scans)));
    }
    let numbered = |c: &Candidate| c.series.number.parse().unwrap_or(i64::MAX);
    candidates.sort_by_key(|c| (std::cmp::Reverse(c.stacks[0].size(scans)), numbered(c)));
    let index = match wanted {
        None => 0,
        Some(wanted) => candidates.iter().position(|c| c.is_called(wanted)).ok_or_else(|| {
            ReadErrorKind::Refused(format!(
                "has no DICOM series '{}'; there are: {}",
                short(wanted),
                listing(&candidates)
            ))
        })?,
    };
    if candidates.is_empty() {
        return Err(ReadErrorKind::Refused("holds no DICOM images".into()));
    }
    let chosen = candidates.remove(index);
    if !candidates.is_empty() {
        let also = match wanted {
            Some(wanted) if candidates.iter().any(|c| c.is_called(wanted)) => {
                " (others have this name too; the UID tells them apart)"
            }
            _ => "",
        };
        warnings.say(format!(
            "of {} DICOM series, {} is read{also}; not read: {}",
            candidates.len() + 1,
            chosen.name(),
            listing(&candidates)
        ));
    }
    let series = chosen.series.clone();
    warnings.counted("DICOM images of still other kinds left out", chosen.beyond, None);
    let mut stacks = chosen.stacks.into_iter();
    let Some(stack) = stacks.next() else {
        return Err(ReadErrorKind::Refused("holds no DICOM images".into()));
    };
    for other in stacks {
        warnings.counted(
            difference(&stack, &other, scans),
            other.slices.len() as u64,
            Some(place(other.slices[0], scans)),
        );
    }
    Ok((series, stack.slices))
}

fn listing(candidates: &[Candidate]) -> String {
    let mut names: Vec<String> = candidates.iter().take(MOST_NAMED).map(Candidate::name).collect();
    if candidates.len() > MOST_NAMED {
        names.push(format!("{} more", candidates.len() - MOST_NAMED));
    }
    names.join(", ")
}

/// Why a stack is not the chosen one.
fn difference(chosen: &Stack, other: &Stack, scans: &[Scan]) -> String {
    let (a, b) = (chosen.layout(scans), other.layout(scans));
    let (first, second) = (chosen.slices[0].of(scans), other.slices[0].of(scans));
    if [a.columns, a.rows] != [b.columns, b.rows] {
        format!("DICOM images of another size ({} x {}) left out", b.columns, b.rows)
    } else if a != b {
        format!("DICOM images of other samples ({}, {} a pixel) left out", b.sample.name(), b.components)
    } else if second.place.is_none() {
        "DICOM images without a position left out".into()
    } else if !parallel(first, second) {
        "DICOM images of another orientation left out".into()
    } else {
        "DICOM images of another pixel spacing left out".into()
    }
}

/// A slice in words.
pub(super) fn place(slice: Slice, scans: &[Scan]) -> String {
    let scan = &scans[slice.scan];
    let name = short(&scan.path.file_name().unwrap_or_default().to_string_lossy());
    if scan.image.frames.len() == 1 { name } else { format!("frame {} of {name}", slice.frame + 1) }
}
