//! MetaImage (Insight Toolkit): a text header of `Key = value` lines, the last of which names the data.
//!
//! `ElementDataFile` is `LOCAL` (the samples follow), a file, a pattern with numbers, or `LIST` and a file a line. The
//! rows of `TransformMatrix` are the directions of the axes, in LPS.

use dotwork_drawing::Warnings;
use dotwork_volume::{SampleType, Scaling, Space, Unit};
use glam::DVec3;

use crate::error::{ReadErrorKind, quote};
use crate::gzip::is_gzip;
use crate::volume::Found;
use crate::volume::ascii::read_numbers;
use crate::volume::data::{After, Part, Skip, pour, product, share};
use crate::volume::facts::Facts;
use crate::volume::files::{Files, in_file, listing, numbered};
use crate::volume::fill::Fill;
use crate::volume::grid::{self, unit_named, usable_spacing};
use crate::volume::reduce::{Reduction, reduce};
use crate::volume::stream::{Packing, Stream};

/// More axes than anyone stores.
const MOST_AXES: usize = 10;

#[derive(Default)]
struct Header {
    axes: Option<usize>,
    sizes: Vec<u64>,
    sample: Option<SampleType>,
    big_endian: bool,
    ascii: bool,
    compressed: bool,
    compressed_bytes: Option<usize>,
    header_size: i64,
    channels: u64,
    spacing: Option<Vec<f64>>,
    element_size: Option<Vec<f64>>,
    origin: Option<Vec<f64>>,
    matrix: Option<Vec<f64>>,
    letters: Option<String>,
    unit: Option<String>,
    scaling: [f64; 2],
    facts: Facts,
}

/// Where the data are.
enum Data {
    Local,
    Files { names: Vec<String>, axes: Option<usize> },
}

pub(super) fn read(files: &mut Files, bytes: &[u8], warnings: &mut Warnings) -> Result<Found, ReadErrorKind> {
    let (mut header, data, end, line) = parse(bytes)?;
    let missing = |what: &str| ReadErrorKind::at_line(line, format!("the header has no {what}"));
    let sample = header.sample.ok_or_else(|| missing("ElementType"))?;
    if header.sizes.is_empty() {
        return Err(missing("DimSize"));
    }
    let axes = header.axes.unwrap_or(header.sizes.len());
    if axes != header.sizes.len() {
        return Err(ReadErrorKind::at_line(line, format!("{} sizes for {axes} axes", header.sizes.len())));
    }
    let channels = header.channels.max(1);
    let width = sample.bytes() as u64;
    let first = axes.min(3);
    let wanted = product(header.sizes[..first].iter().copied().chain([channels, width]))?;
    let declared = product(header.sizes.iter().copied().chain([channels, width]))?;
    let volumes = declared / wanted;
    if volumes > 1 {
        warnings.say(format!("the first of {volumes} volumes is taken"));
    }
    if axes != 3 {
        header.facts.add_axes(&header.sizes);
    }
    let mut fill = Fill::new(sample, wanted / width)?;
    let mut packing = Packing::None;
    let detached = matches!(data, Data::Files { .. });
    match data {
        Data::Local => {
            let mut part = Source { bytes, start: end, line: line + 1, declared, many: false };
            // The number counts from the start of the file, text header included.
            if header.header_size > 0 {
                part.start = usize::try_from(header.header_size)
                    .ok()
                    .filter(|&n| n >= end && n <= bytes.len())
                    .ok_or_else(|| {
                        ReadErrorKind::at_line(
                            line,
                            format!("HeaderSize {} is no place after the header", header.header_size),
                        )
                    })?;
                header.header_size = 0;
            }
            packing = take(&mut fill, part, &header, warnings)?;
        }
        Data::Files { names, axes: of_each } => {
            let count = names.len() as u64;
            let share = share(&header.sizes, channels * width, count, of_each)
                .map_err(|reason| ReadErrorKind::at_line(line, reason))?;
            header.facts.add("data files", listing(&names));
            for name in &names {
                if fill.missing() == 0 {
                    break;
                }
                let path = files.path(name);
                let bytes = files.open(&path)?;
                let many = count > 1;
                let part = Source { bytes: &bytes, start: 0, line: 1, declared: share, many };
                packing = in_file(&path, take(&mut fill, part, &header, warnings))?;
            }
        }
    }
    let mut samples = fill.finish(if header.ascii { cfg!(target_endian = "big") } else { header.big_endian });
    if channels > 1 {
        let colours = (channels == 3 || channels == 4) && sample == SampleType::U8;
        let how = if colours { Reduction::Luminance } else { Reduction::First };
        warnings.say(if colours {
            format!("{channels} colours a voxel: their luminance is taken")
        } else {
            format!("{channels} values a voxel: the first is taken")
        });
        reduce(&mut samples, 1, channels as usize, how);
    }
    let mut dims = [1; 3];
    for (dim, &size) in dims.iter_mut().zip(&header.sizes) {
        // Their product fits, as the samples do.
        *dim = size as usize;
    }
    let [slope, intercept] = header.scaling;
    Ok(Found {
        dims,
        samples,
        scaling: Scaling { slope, intercept },
        affine: affine(&header, axes, warnings),
        format: format(&header, sample, packing, detached),
        facts: header.facts,
    })
}

/// The samples of one file: `bytes` from `start` on.
struct Source<'a> {
    bytes: &'a [u8],
    start: usize,
    line: u64,
    declared: u64,
    many: bool,
}

fn take(
    fill: &mut Fill,
    source: Source,
    header: &Header,
    warnings: &mut Warnings,
) -> Result<Packing, ReadErrorKind> {
    let Source { bytes, start, line, declared, many } = source;
    let mut data = &bytes[start..];
    let wanted = declared.min(fill.missing() as u64);
    let mut packing = Packing::None;
    let mut skip = match header.header_size {
        -1 => Skip::ToLast,
        n => Skip::Bytes(u64::try_from(n).unwrap_or_default()),
    };
    if header.ascii {
        let skipped = match skip {
            Skip::Bytes(n) => usize::try_from(n).unwrap_or(usize::MAX).min(data.len()),
            Skip::ToLast => 0,
        };
        let line = line + data[..skipped].iter().filter(|&&b| b == b'\n').count() as u64;
        read_numbers(fill, &data[skipped..], line, wanted as usize / fill.sample.bytes())?;
        return Ok(packing);
    }
    if header.compressed {
        // What is skipped lies before the packed data.
        if let Skip::Bytes(n) = skip {
            data = &data[usize::try_from(n).unwrap_or(usize::MAX).min(data.len())..];
            skip = Skip::Bytes(0);
        }
        if let Some(length) = header.compressed_bytes.filter(|&n| n > 0 && n < data.len() && !many) {
            warnings.say(format!("{} bytes after the packed samples ignored", data.len() - length));
            data = &data[..length];
        }
        packing = if is_gzip(data) { Packing::Gzip } else { Packing::Zlib };
    }
    let part = Part { skip, wanted, declared, after: After::Nothing, one_of_many: many };
    pour(fill, Stream::new(data, packing), start, part, warnings)?;
    Ok(packing)
}

fn format(header: &Header, sample: SampleType, packing: Packing, detached: bool) -> String {
    let mut text = String::from("MetaImage");
    if detached {
        text.push_str(", detached");
    }
    text.push_str(", ");
    text.push_str(if header.ascii { "ascii" } else { packing.name() });
    if sample.bytes() > 1 && !header.ascii {
        text.push_str(if header.big_endian { ", big endian" } else { ", little endian" });
    }
    text
}

/// Reads the header; returns also where the data are, where the header ends, and its last line.
fn parse(bytes: &[u8]) -> Result<(Header, Data, usize, u64), ReadErrorKind> {
    let mut header = Header { scaling: [1.0, 0.0], ..Header::default() };
    let mut at = 0;
    let mut line = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        let end = rest.iter().position(|&b| b == b'\n');
        let text = rest[..end.unwrap_or(rest.len())].trim_ascii();
        at += end.map_or(rest.len(), |e| e + 1);
        line += 1;
        if text.is_empty() {
            continue;
        }
        let owned = String::from_utf8_lossy(text);
        let Some((key, value)) = owned.split_once('=').or_else(|| owned.split_once(':')) else {
            return Err(ReadErrorKind::at_line(line, format!("{} is not 'Key = value'", quote(text))));
        };
        let (key, value) = (key.trim(), value.trim());
        if key.eq_ignore_ascii_case("ElementDataFile") {
            let data = data(value, &bytes[at..]).map_err(|r| ReadErrorKind::at_line(line, r))?;
            return Ok((header, data, at, line));
        }
        header.take(key, value).map_err(|r| ReadErrorKind::at_line(line, format!("{key}: {r}")))?;
    }
    Err(ReadErrorKind::at_line(line, "the header has no ElementDataFile"))
}

fn data(value: &str, rest: &[u8]) -> Result<Data, String> {
    let parts: Vec<&str> = value.split_whitespace().collect();
    let axes = |text: Option<&&str>| {
        text.map(|t| {
            t.trim_end_matches(['D', 'd']).parse().map_err(|_| format!("'{t}' is no number of axes"))
        })
        .transpose()
    };
    match parts[..] {
        [] => Err("no data file is named".into()),
        [word] if word.eq_ignore_ascii_case("local") => Ok(Data::Local),
        [word, ..] if word.eq_ignore_ascii_case("list") && parts.len() <= 2 => {
            let text = String::from_utf8_lossy(rest);
            let names = text.lines().map(str::trim).filter(|l| !l.is_empty()).map(Into::into).collect();
            Ok(Data::Files { names, axes: axes(parts.get(1))? })
        }
        [pattern, first, last, step] if pattern.contains('%') => {
            let number =
                |t: &str| t.parse().map_err(|_| format!("{} is no number of a file", quote(t.as_bytes())));
            let names = numbered(pattern, number(first)?, number(last)?, number(step)?)?;
            Ok(Data::Files { names, axes: None })
        }
        _ => Ok(Data::Files { names: vec![value.into()], axes: None }),
    }
}

impl Header {
    fn take(&mut self, key: &str, value: &str) -> Result<(), String> {
        let whole = || value.parse().map_err(|_| format!("{} is no whole number", quote(value.as_bytes())));
        match key.to_ascii_lowercase().as_str() {
            "ndims" => {
                let n: usize = value.parse().unwrap_or_default();
                if n == 0 || n > MOST_AXES {
                    return Err(format!("{} is no number of axes", quote(value.as_bytes())));
                }
                self.axes = Some(n);
            }
            "dimsize" => {
                self.sizes = value
                    .split_whitespace()
                    .map(|t| t.parse().ok().filter(|&n| n > 0))
                    .collect::<Option<_>>()
                    .ok_or_else(|| format!("{} are no sizes", quote(value.as_bytes())))?;
                if self.sizes.len() > MOST_AXES {
                    return Err(format!("{} axes", self.sizes.len()));
                }
            }
            "elementtype" => self.sample = Some(sample_type(value)?),
            "elementbyteordermsb" | "binarydatabyteordermsb" => self.big_endian = truth(value)?,
            "binarydata" => self.ascii = !truth(value)?,
            "compresseddata" => self.compressed = truth(value)?,
            "compresseddatasize" => self.compressed_bytes = value.parse().ok(),
            "headersize" => {
                self.header_size = whole()?;
                if self.header_size < -1 {
                    return Err(format!("{value}; -1 and more are allowed"));
                }
            }
            "elementnumberofchannels" => {
                self.channels = u64::try_from(whole()?)
                    .ok()
                    .filter(|&n| n > 0)
                    .ok_or_else(|| format!("{} is no number of channels", quote(value.as_bytes())))?;
            }
            "elementspacing" => self.spacing = Some(numbers(value)?),
            "elementsize" => self.element_size = Some(numbers(value)?),
            "offset" | "position" | "origin" => self.origin = Some(numbers(value)?),
            "transformmatrix" | "rotation" | "orientation" => self.matrix = Some(numbers(value)?),
            "anatomicalorientation" => {
                self.facts.add(key, value);
                self.letters = Some(value.to_ascii_uppercase());
            }
            "distanceunits" => self.unit = Some(value.into()),
            "elementtointensityfunctionslope" | "elementtointensityfunctionoffset" => {
                let [number] = numbers(value)?[..] else { return Err("is one number".into()) };
                let slope = key.to_ascii_lowercase().ends_with("slope");
                // A slope of 0 says nothing.
                if number.is_finite() && !(slope && number == 0.0) {
                    self.scaling[usize::from(!slope)] = number;
                }
            }
            "objecttype" if !value.eq_ignore_ascii_case("image") => {
                return Err(format!("{} is no image", quote(value.as_bytes())));
            }
            "objecttype" | "centerofrotation" | "elementmin" | "elementmax" => {}
            _ => self.facts.add(key, value),
        }
        Ok(())
    }
}

fn truth(value: &str) -> Result<bool, String> {
    match value.chars().next().map(|c| c.to_ascii_lowercase()) {
        Some('t' | 'y' | '1') => Ok(true),
        Some('f' | 'n' | '0') => Ok(false),
        _ => Err(format!("{} is neither True nor False", quote(value.as_bytes()))),
    }
}

fn numbers(value: &str) -> Result<Vec<f64>, String> {
    value
        .split_whitespace()
        .map(|t| t.parse().map_err(|_| format!("{} is no number", quote(t.as_bytes()))))
        .collect()
}

fn sample_type(name: &str) -> Result<SampleType, String> {
    let name = name.to_ascii_uppercase();
    let name = name.strip_suffix("_ARRAY").unwrap_or(&name);
    Ok(match name {
        "MET_CHAR" => SampleType::I8,
        "MET_UCHAR" => SampleType::U8,
        "MET_SHORT" => SampleType::I16,
        "MET_USHORT" => SampleType::U16,
        // Four bytes in MetaIO, whatever the machine.
        "MET_INT" | "MET_LONG" => SampleType::I32,
        "MET_UINT" | "MET_ULONG" => SampleType::U32,
        "MET_LONG_LONG" => SampleType::I64,
        "MET_ULONG_LONG" => SampleType::U64,
        "MET_FLOAT" => SampleType::F32,
        "MET_DOUBLE" => SampleType::F64,
        _ => return Err(format!("samples of type {} are not read", quote(name.as_bytes()))),
    })
}

fn affine(header: &Header, axes: usize, warnings: &mut Warnings) -> dotwork_volume::Affine {
    let space_axes = axes.min(3);
    let spacing = header.spacing.as_ref().or(header.element_size.as_ref()).filter(|s| s.len() >= space_axes);
    if spacing.is_none() {
        warnings.say("no spacing in the file: 1 x 1 x 1 assumed");
    }
    let spacing: Vec<f64> =
        (0..space_axes).map(|i| spacing.map_or(1.0, |s| usable_spacing(s[i], i, warnings))).collect();
    let rows = header.matrix.as_ref().filter(|m| m.len() == axes * axes);
    if header.matrix.is_some() && rows.is_none() {
        warnings.say(format!("the TransformMatrix has not {axes} x {axes} numbers and is ignored"));
    }
    let letters = header.letters.as_ref().and_then(|l| directions(l));
    let direction = |i: usize| match (rows, letters) {
        (Some(m), _) => {
            let mut d = DVec3::ZERO;
            for (c, v) in m[i * axes..][..space_axes].iter().enumerate() {
                d[c] = *v;
            }
            d
        }
        (None, Some(letters)) => letters[i],
        (None, None) => DVec3::AXES[i],
    };
    let mut steps = [None; 3];
    for (i, s) in spacing.iter().enumerate() {
        steps[i] = Some(direction(i) * *s);
    }
    let mut origin = DVec3::ZERO;
    for (i, v) in header.origin.iter().flatten().take(space_axes).enumerate() {
        origin[i] = *v;
    }
    let (unit, factor) = header.unit.as_deref().and_then(unit_named).unwrap_or((Unit::Unknown, 1.0));
    let space = if rows.is_some() || letters.is_some() { Space::Patient } else { Space::Unknown };
    grid::affine(steps.map(|s| s.map(|s: DVec3| s * factor)), origin * factor, space, unit, warnings)
}

/// The directions of axes in LPS by the letters of the sides from which they come: `RAI` runs along +x, +y, +z.
fn directions(letters: &str) -> Option<[DVec3; 3]> {
    let mut steps = [DVec3::ZERO; 3];
    if letters.chars().count() != 3 {
        return None;
    }
    for (step, letter) in steps.iter_mut().zip(letters.chars()) {
        *step = match letter {
            'R' => DVec3::X,
            'L' => -DVec3::X,
            'A' => DVec3::Y,
            'P' => -DVec3::Y,
            'I' => DVec3::Z,
            'S' => -DVec3::Z,
            _ => return None,
        };
    }
    (steps[0].cross(steps[1]).dot(steps[2]) != 0.0).then_some(steps)
}
