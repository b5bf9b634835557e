//! What one file says of its images: how samples are stored, where each frame lies, to which series they belong.
//!
//! Of an old-style file the attributes stand in the data set itself; of an enhanced one (PS3.3, C.7.6.16) in functional
//! groups, shared by all frames or per frame.

use dotwork_volume::{SampleType, Scaling};
use glam::DVec3;

use crate::error::ReadErrorKind;
use crate::volume::dicom::set::{Opened, Parsed, PixelElement, Set};
use crate::volume::dicom::syntax::{Codec, Syntax};
use crate::volume::dicom::tags;
use crate::volume::facts::short;

/// More frames than any file has.
const MOST_FRAMES: usize = 1 << 16;

/// Lengths beyond this are no places in a patient, mm.
const FARTHEST: f64 = 1e7;

/// What the samples of a pixel mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Color {
    Gray,
    /// MONOCHROME1: the lowest is white.
    WhiteIsLow,
    Rgb,
    /// Luminance and colour differences.
    Ybr,
}

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) components: usize,
    pub(super) color: Color,
    /// Native pixels lie in planes of one component each.
    pub(super) planar: bool,
    pub(super) sample: SampleType,
    /// Bits of a sample in native pixels: 1, 8, 16, 32 or 64.
    pub(super) allocated: u32,
    /// Bits of a sample that count; the highest of them is `high`.
    pub(super) stored: u32,
    pub(super) high: u32,
}

impl Layout {
    /// Pixels of a frame.
    pub(super) fn pixels(&self) -> usize {
        self.rows * self.columns
    }

    /// Bits of a native frame.
    pub(super) fn frame_bits(&self) -> u64 {
        self.samples() * u64::from(self.allocated)
    }

    /// Samples of a frame with all its components.
    pub(super) fn samples(&self) -> u64 {
        self.pixels() as u64 * self.components as u64
    }

    pub(super) fn is_signed(&self) -> bool {
        matches!(self.sample, SampleType::I8 | SampleType::I16 | SampleType::I32)
    }
}

/// Where a frame lies, mm in the patient's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// The centre of the first pixel.
    pub(super) origin: DVec3,
    /// Unit step to the next column.
    pub(super) across: DVec3,
    /// Unit step to the next row.
    pub(super) down: DVec3,
}

/// One frame.
#[derive(Clone, Debug)]
pub(super) struct Frame {
    pub(super) place: Option<Place>,
    /// Steps along columns and rows, mm.
    pub(super) spacing: Option<[f64; 2]>,
    pub(super) scaling: Scaling,
    /// What tells frames at the same place apart: time, echo, diffusion weighting, acquisition, kind.
    pub(super) pass: (i64, i64, i64, i64, String),
    /// Orders frames of one pass.
    pub(super) instance: i64,
    /// Orders frames without a place, mm.
    pub(super) location: Option<f64>,
}

/// What names a series.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Series {
    pub(super) uid: String,
    pub(super) number: String,
    pub(super) description: String,
    pub(super) modality: String,
    pub(super) manufacturer: String,
}

/// The images of one file.
#[derive(Clone, Debug)]
pub(super) struct Image {
    pub(super) layout: Layout,
    pub(super) syntax: Syntax,
    pub(super) series: Series,
    pub(super) frames: Vec<Frame>,
    /// Stored samples that stand for nothing, from and to.
    pub(super) padding: Option<[f64; 2]>,
    /// The distance of slices if positions do not tell, mm.
    pub(super) distance: Option<f64>,
}

impl Image {
    /// The images of a parsed file of `length` bytes.
    ///
    /// # Errors
    /// No image, one that is not read (by name), or fewer bytes than it declares.
    pub(super) fn of(opened: &Opened, parsed: &Parsed, length: u64) -> Result<Image, ReadErrorKind> {
        let (set, syntax) = (&parsed.set, opened.syntax);
        let refused = |reason: String| ReadErrorKind::Refused(reason);
        let Some(pixels) = parsed.pixels else {
            return Err(refused("is DICOM without an image".into()));
        };
        syntax.check(&opened.uid)?;
        let layout = layout(set, &pixels, syntax.codec)?;
        let declared = set.text(tags::FRAMES);
        let count = match declared.as_deref() {
            None => Some(1),
            Some(text) => text.split('\\').next().and_then(|n| n.trim().parse::<usize>().ok()),
        };
        let count = count.filter(|&n| n > 0 && n <= MOST_FRAMES).ok_or_else(|| {
            refused(format!("is DICOM with '{}' frames", short(&declared.unwrap_or_default())))
        })?;
        check_length(&layout, &pixels, count, length)?;

        let shared = set.item(tags::SHARED_GROUPS);
        let per_frame = set.items(tags::FRAME_GROUPS);
        let offsets = set.numbers_of_frames(tags::FRAME_OFFSETS, count);
        let distance = set
            .number(tags::SLICE_DISTANCE)
            .or_else(|| shared.and_then(|s| s.item(tags::PIXEL_MEASURES)?.number(tags::SLICE_DISTANCE)))
            .or_else(|| set.number(tags::THICKNESS))
            .or_else(|| shared.and_then(|s| s.item(tags::PIXEL_MEASURES)?.number(tags::THICKNESS)))
            .map(f64::abs)
            .filter(|&d| d > 0.0 && d < FARTHEST);
        let frames = (0..count)
            .map(|i| {
                let mut frame = Groups { set, shared, own: per_frame.get(i) }.frame(i);
                if per_frame.is_empty() && i > 0 {
                    // Frames of one data set share its place: they follow each other along the normal.
                    let from_first = match (offsets.first(), offsets.get(i)) {
                        (Some(first), Some(this)) => Some(this - first),
                        _ => distance.map(|d| d * i as f64),
                    };
                    frame.place = frame.place.zip(from_first).map(|(place, d)| Place {
                        origin: place.origin + place.across.cross(place.down) * d,
                        ..place
                    });
                }
                frame
            })
            .collect();
        let padding = set.short(tags::PADDING).filter(|_| layout.components == 1).map(|from| {
            let number = |n: u16| if layout.is_signed() { f64::from(n as i16) } else { f64::from(n) };
            let to = set.short(tags::PADDING_LIMIT).unwrap_or(from);
            let (a, b) = (number(from), number(to));
            [a.min(b), a.max(b)]
        });
        let text = |tag| short(&set.text(tag).unwrap_or_default());
        let maker = [text(tags::MANUFACTURER), text(tags::MODEL)];
        let series = Series {
            uid: text(tags::SERIES_UID),
            number: text(tags::SERIES_NUMBER),
            description: text(tags::SERIES_DESCRIPTION),
            modality: text(tags::MODALITY),
            manufacturer: maker.join(" ").trim().to_owned(),
        };
        Ok(Image { layout, syntax, series, frames, padding, distance })
    }
}

/// The places where an attribute of a frame may stand, the closest first.
struct Groups<'a> {
    set: &'a Set<'a>,
    shared: Option<&'a Set<'a>>,
    own: Option<&'a Set<'a>>,
}

impl Groups<'_> {
    /// Looks into the functional group `group` of the frame, then into the shared one, then into the data set.
    fn find<T>(&self, group: u32, get: impl Fn(&Set) -> Option<T>) -> Option<T> {
        let within = |set: Option<&Set>| set.and_then(|s| s.item(group)).and_then(&get);
        within(self.own).or_else(|| within(self.shared)).or_else(|| get(self.set))
    }

    fn frame(&self, index: usize) -> Frame {
        let three = |numbers: Vec<f64>| match numbers[..] {
            [x, y, z] if [x, y, z].iter().all(|v| v.abs() < FARTHEST) => Some(DVec3::new(x, y, z)),
            _ => None,
        };
        let detector = self.set.item(tags::DETECTORS);
        let origin = self
            .find(tags::PLANE_POSITION, |s| three(s.numbers(tags::POSITION)))
            .or_else(|| three(detector?.numbers(tags::POSITION)));
        let directions = self
            .find(tags::PLANE_ORIENTATION, |s| directions(&s.numbers(tags::ORIENTATION)))
            .or_else(|| directions(&detector?.numbers(tags::ORIENTATION)));
        let spacing = [
            (tags::PIXEL_MEASURES, tags::PIXEL_SPACING),
            (0, tags::IMAGER_SPACING),
            (0, tags::SCANNED_SPACING),
        ]
        .iter()
        .find_map(|&(group, tag)| self.find(group, |s| spacing(&s.numbers(tag))));
        let slope = self.find(tags::VALUE_TRANSFORMATION, |s| s.number(tags::SLOPE)).unwrap_or(1.0);
        let intercept = self.find(tags::VALUE_TRANSFORMATION, |s| s.number(tags::INTERCEPT)).unwrap_or(0.0);
        // Times in microseconds and the like: whole numbers can be told apart exactly.
        let fine = |v: f64| (v * 1000.0) as i64;
        let whole = |v: f64| v as i64;
        let time = self
            .find(tags::FRAME_CONTENT, |s| s.long(tags::TEMPORAL_INDEX).map(i64::from))
            .or_else(|| self.set.number(tags::TEMPORAL_POSITION).map(whole));
        let echo = self
            .find(tags::ECHO, |s| s.double(tags::EFFECTIVE_ECHO_TIME))
            .or_else(|| self.set.number(tags::ECHO_TIME));
        let weighting = self.find(tags::DIFFUSION, |s| s.double(tags::B_VALUE));
        let acquisition = self.set.number(tags::ACQUISITION_NUMBER).map(whole);
        let kind = short(&self.set.text(tags::IMAGE_TYPE).unwrap_or_default());
        let instance = self.set.number(tags::INSTANCE_NUMBER).map_or(0, whole);
        Frame {
            place: origin.zip(directions).map(|(origin, [across, down])| Place { origin, across, down }),
            spacing,
            scaling: Scaling { slope: if slope == 0.0 { 1.0 } else { slope }, intercept },
            pass: (
                time.unwrap_or(0),
                echo.map_or(0, fine),
                weighting.map_or(0, fine),
                acquisition.unwrap_or(0),
                kind,
            ),
            instance: instance.saturating_add(index as i64),
            location: self.set.number(tags::SLICE_LOCATION).filter(|v| v.abs() < FARTHEST),
        }
    }
}

/// Unit steps along a row and along a column, if that is what they are.
fn directions(numbers: &[f64]) -> Option<[DVec3; 2]> {
    let &[a, b, c, d, e, f] = numbers else { return None };
    let (across, down) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
    let unit = |v: DVec3| (0.9..1.1).contains(&v.length());
    if !unit(across) || !unit(down) {
        return None;
    }
    let (across, down) = (across.normalize(), down.normalize());
    (across.dot(down).abs() < 0.1).then_some([across, down])
}

/// DICOM names the distance of rows first.
fn spacing(numbers: &[f64]) -> Option<[f64; 2]> {
    match *numbers {
        [rows, columns, ..] if rows > 0.0 && columns > 0.0 && rows < FARTHEST && columns < FARTHEST => {
            Some([columns, rows])
        }
        _ => None,
    }
}

fn layout(set: &Set, pixels: &PixelElement, codec: Codec) -> Result<Layout, ReadErrorKind> {
    let refused = |reason: String| Err(ReadErrorKind::Refused(reason));
    let number = |tag, default: u16| u32::from(set.short(tag).unwrap_or(default));
    let (rows, columns) = (number(tags::ROWS, 0) as usize, number(tags::COLUMNS, 0) as usize);
    if rows == 0 || columns == 0 {
        return refused(format!("is DICOM whose image has {columns} x {rows} pixels"));
    }
    let components = number(tags::COMPONENTS, 1) as usize;
    let photometric = set.text(tags::PHOTOMETRIC).unwrap_or_default();
    let color = match (photometric.as_str(), components) {
        ("MONOCHROME1", 1) => Color::WhiteIsLow,
        ("MONOCHROME2" | "", 1) => Color::Gray,
        ("RGB" | "", 3) => Color::Rgb,
        ("YBR_FULL", 3) => Color::Ybr,
        ("YBR_FULL_422" | "YBR_PARTIAL_422" | "YBR_PARTIAL_420", 3) if codec == Codec::Jpeg => Color::Ybr,
        ("YBR_ICT" | "YBR_RCT", 3) => Color::Ybr,
        (other, n) => {
            let other = short(other);
            return refused(format!("is DICOM in colours ({other}, {n} samples a pixel) that are not read"));
        }
    };
    let allocated = number(tags::BITS_ALLOCATED, 0);
    let stored = number(tags::BITS_STORED, allocated as u16);
    let high = number(tags::HIGH_BIT, (stored as u16).wrapping_sub(1));
    let signed = set.short(tags::PIXEL_REPRESENTATION) == Some(1);
    let (sample, allocated) = match (pixels.tag, allocated, signed) {
        (tags::FLOAT_PIXELS, ..) => (SampleType::F32, 32),
        (tags::DOUBLE_PIXELS, ..) => (SampleType::F64, 64),
        (_, 1, _) if codec == Codec::Native => (SampleType::U8, 1),
        (_, 8, false) => (SampleType::U8, 8),
        (_, 8, true) => (SampleType::I8, 8),
        (_, 16, false) => (SampleType::U16, 16),
        (_, 16, true) => (SampleType::I16, 16),
        (_, 32, false) => (SampleType::U32, 32),
        (_, 32, true) => (SampleType::I32, 32),
        _ => return refused(format!("is DICOM with samples of {allocated} bits, which are not read")),
    };
    let floats = matches!(sample, SampleType::F32 | SampleType::F64);
    let (stored, high) = if floats { (allocated, allocated - 1) } else { (stored, high) };
    if stored == 0 || high >= allocated || high + 1 < stored {
        return refused(format!(
            "is DICOM with {stored} of {allocated} bits stored, the highest in bit {high}"
        ));
    }
    if floats && codec != Codec::Native {
        return refused("is DICOM with packed floats, which are not read".into());
    }
    let planar = components > 1 && set.short(tags::PLANAR) == Some(1);
    Ok(Layout { rows, columns, components, color, planar, sample, allocated, stored, high })
}

/// Compares what is declared with the bytes that are there.
fn check_length(
    layout: &Layout,
    pixels: &PixelElement,
    frames: usize,
    file: u64,
) -> Result<(), ReadErrorKind> {
    let there = file.saturating_sub(pixels.at as u64);
    let Some(length) = pixels.length else {
        // A fragment has a head of eight bytes.
        if frames as u64 > there / 8 {
            return Err(ReadErrorKind::at_byte(
                pixels.at,
                format!("too few bytes for {frames} DICOM frames"),
            ));
        }
        return Ok(());
    };
    let needed = (u128::from(layout.frame_bits()) * frames as u128).div_ceil(8);
    if needed > u128::from(there) {
        return Err(ReadErrorKind::at_byte(
            usize::try_from(file).unwrap_or(usize::MAX),
            format!("the DICOM pixel data end too early: {there} of {needed} bytes are there"),
        ));
    }
    if needed > u128::from(length) {
        return Err(ReadErrorKind::at_byte(
            pixels.at,
            format!("DICOM pixel data of {length} bytes where {needed} are declared"),
        ));
    }
    Ok(())
}

#[cfg(test)]
impl Frame {
    /// A frame without anything.
    pub(super) fn of_test() -> Frame {
        Frame {
            place: None,
            spacing: None,
            scaling: Scaling::default(),
            pass: Default::default(),
            instance: 0,
            location: None,
        }
    }
}

#[cfg(test)]
impl Image {
    /// An image of one pixel.
    pub(super) fn of_test(frames: Vec<Frame>) -> Image {
        let layout = Layout {
            rows: 1,
            columns: 1,
            components: 1,
            color: Color::Gray,
            planar: false,
            sample: SampleType::U8,
            allocated: 8,
            stored: 8,
            high: 7,
        };
        let syntax = Syntax::of("1.2.840.10008.1.2");
        Image { layout, syntax, series: Series::default(), frames, padding: None, distance: None }
    }
}
