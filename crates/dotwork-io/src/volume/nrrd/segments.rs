//! Segments: Slicer keeps its segmentations in NRRD files (`.seg.nrrd`), each segment in `SegmentN_…` keys of the header.
//!
//! A segment is the voxels that have its `LabelValue` in its `Layer`. Segments that overlap lie in several layers, the
//! entries of a first axis of kind `list`; older files have a layer for each segment, and neither key. All layers become
//! one volume: where segments overlap, the one of the later layer is taken.

use std::collections::{BTreeMap, HashSet};

use dotwork_drawing::Warnings;
use dotwork_volume::{Sample, Samples, with_samples};

use crate::error::{ReadErrorKind, quote};
use crate::volume::label_table::{LabelEntry, LabelTable, short_name};

/// Segments at most; their values then fit 16 bits.
const MOST: usize = 4096;

/// The colour of a segment that has none.
const GREY: [u8; 3] = [128; 3];

/// What the header says of one segment.
#[derive(Default)]
struct Keys {
    line: u64,
    id: Option<String>,
    name: Option<String>,
    color: Option<[u8; 3]>,
    value: Option<i64>,
    layer: Option<usize>,
}

/// A segment and where it is.
struct Segment {
    layer: usize,
    /// Its value in the layer.
    stored: i64,
    entry: LabelEntry,
}

/// The segments of a file, in their order.
pub(super) struct Segments(Vec<Segment>);

/// True for a header key that is about a segment: `Segment12_Name`.
pub(super) fn is_segment_key(key: &str) -> bool {
    split_key(key).is_some()
}

/// The number and the field of a segment's key.
fn split_key(key: &str) -> Option<(&str, &str)> {
    let (number, field) = key.strip_prefix("Segment")?.split_once('_')?;
    (!number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())).then_some((number, field))
}

impl Segments {
    /// The segments that header lines (number, key, value) speak of, in a file of `layers` layers; `None` if there are
    /// none.
    pub(super) fn parse(
        lines: &[(u64, String, String)],
        layers: usize,
        warnings: &mut Warnings,
    ) -> Result<Option<Segments>, ReadErrorKind> {
        let mut found: BTreeMap<u32, Keys> = BTreeMap::new();
        for (line, key, value) in lines {
            let wrong = |reason: String| ReadErrorKind::at_line(*line, format!("{key}: {reason}"));
            let Some((number, field)) = split_key(key) else { continue };
            let number = number.parse().map_err(|_| wrong("the number is too large".into()))?;
            let keys = found.entry(number).or_insert_with(|| Keys { line: *line, ..Keys::default() });
            let text = || quote(value.as_bytes());
            match field {
                "ID" => keys.id = Some(short_name(value)),
                "Name" => keys.name = Some(short_name(value)),
                "Color" => {
                    keys.color = Some(
                        color(value)
                            .ok_or_else(|| wrong(format!("{} is not three numbers within 0 to 1", text())))?,
                    )
                }
                "LabelValue" => {
                    let whole = value.trim().parse();
                    keys.value = Some(whole.map_err(|_| wrong(format!("{} is not a whole number", text())))?);
                }
                "Layer" => {
                    let whole = value.trim().parse();
                    keys.layer = Some(whole.map_err(|_| wrong(format!("{} is no layer", text())))?);
                }
                _ => {}
            }
            if found.len() > MOST {
                return Err(wrong(format!("more than {MOST} segments")));
            }
        }
        let mut segments = Vec::with_capacity(found.len());
        for (i, (number, keys)) in found.into_iter().enumerate() {
            // Files without the key have a layer for each segment.
            let layer = keys.layer.unwrap_or(if layers > 1 { i } else { 0 });
            let stored = keys.value.unwrap_or(1);
            if layer >= layers {
                let place = format!("segment {number} on line {}", keys.line);
                warnings.counted("segments of layers that the file does not have, left out", 1, Some(place));
                continue;
            }
            let name = keys.name.or(keys.id).filter(|n| !n.is_empty());
            let name = name.unwrap_or_else(|| format!("segment {number}"));
            let entry = LabelEntry { value: stored, name, color: keys.color.unwrap_or(GREY), visible: true };
            segments.push(Segment { layer, stored, entry });
        }
        let mut places = HashSet::new();
        segments.retain(|s| {
            let first = places.insert((s.layer, s.stored));
            if !first {
                warnings.counted(
                    "segments that share layer and value with another, left out",
                    1,
                    Some(s.entry.name.clone()),
                );
            }
            first
        });
        if segments.is_empty() {
            return Ok(None);
        }
        let mut values = HashSet::new();
        let fits = |s: &Segment| u16::try_from(s.stored).is_ok_and(|v| v > 0);
        if layers > 1 && !segments.iter().all(|s| fits(s) && values.insert(s.stored)) {
            // Values that mean different segments in different layers.
            (1..).zip(&mut segments).for_each(|(value, s)| s.entry.value = value);
        }
        Ok(Some(Segments(segments)))
    }

    /// Names and colours.
    pub(super) fn table(self) -> LabelTable {
        LabelTable { entries: self.0.into_iter().map(|s| s.entry).collect() }
    }

    /// One volume of the values in the table from voxels that have a sample for each of several layers.
    pub(super) fn compose(
        &self,
        samples: &Samples,
        layers: usize,
        warnings: &mut Warnings,
    ) -> Result<Samples, ReadErrorKind> {
        let mut tables: Vec<Vec<(f64, u16)>> = vec![Vec::new(); layers];
        // 0 is the background, whatever a header says.
        for s in self.0.iter().filter(|s| s.stored != 0) {
            // Entries of composed files fit 16 bits, whether kept or numbered anew.
            let value = u16::try_from(s.entry.value).unwrap_or(u16::MAX);
            tables[s.layer].push((s.stored as f64, value));
        }
        let mut composed = Vec::new();
        let voxels = samples.len() / layers;
        composed
            .try_reserve_exact(voxels)
            .map_err(|_| ReadErrorKind::TooLarge(format!("{voxels} voxels of segments cannot be held")))?;
        let overlaps = with_samples!(samples, v => compose(v, &tables, &mut composed));
        warnings.counted("voxels in several segments: the last is taken", overlaps, None);
        Ok(Samples::U16(composed))
    }
}

/// Fills `composed`; returns in how many voxels there is more than one segment.
fn compose<T: Sample>(samples: &[T], tables: &[Vec<(f64, u16)>], composed: &mut Vec<u16>) -> u64 {
    let mut overlaps = 0;
    // Neighbours mostly have the same value: the last answer of each layer is tried first.
    let mut last = vec![(0.0, None); tables.len()];
    for voxel in samples.chunks_exact(tables.len()) {
        let (mut value, mut count) = (0, 0);
        for ((sample, table), last) in voxel.iter().zip(tables).zip(&mut last) {
            let sample = sample.to_f64();
            if sample != last.0 {
                *last = (sample, table.iter().find(|(stored, _)| *stored == sample).map(|e| e.1));
            }
            if let Some(found) = last.1 {
                value = found;
                count += 1;
            }
        }
        overlaps += u64::from(count > 1);
        composed.push(value);
    }
    overlaps
}

fn color(text: &str) -> Option<[u8; 3]> {
    let mut numbers = text.split_whitespace().map(|w| w.parse::<f64>().ok());
    let mut next = || numbers.next().flatten().filter(|c| (0.0..=1.0).contains(c));
    let color = [next()?, next()?, next()?].map(|c| (c * 255.0).round() as u8);
    numbers.next().is_none().then_some(color)
}
