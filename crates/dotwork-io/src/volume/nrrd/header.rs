//! The text header of an NRRD file.

use dotwork_drawing::Warnings;
use dotwork_volume::SampleType;
use glam::DVec3;

use crate::error::{ReadErrorKind, quote};
use crate::volume::facts::Facts;
use crate::volume::files::numbered;
use crate::volume::nrrd::segments::is_segment_key;
use crate::volume::stream::Packing;

/// The format's own limit.
const MOST_AXES: usize = 16;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Packed(Packing),
    Ascii,
    Hex,
}

#[derive(Debug, Default)]
pub(super) enum DataFiles {
    #[default]
    Attached,
    Named {
        names: Vec<String>,
        /// How many axes each file has.
        share_axes: Option<usize>,
    },
}

/// A value that its line gave.
#[derive(Clone, Debug, Default)]
pub(super) struct Per<T> {
    pub(super) line: u64,
    pub(super) values: Vec<T>,
}

impl<T> Per<T> {
    pub(super) fn get(&self, axis: usize) -> Option<&T> {
        self.values.get(axis)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) sample: SampleType,
    pub(super) sizes: Vec<u64>,
    pub(super) encoding: Encoding,
    pub(super) big_endian: Option<bool>,
    pub(super) line_skip: u64,
    pub(super) byte_skip: i64,
    pub(super) data: DataFiles,
    pub(super) data_line: u64,
    pub(super) detached: bool,
    pub(super) spacings: Per<f64>,
    pub(super) mins: Per<f64>,
    pub(super) maxs: Per<f64>,
    pub(super) centers: Per<String>,
    pub(super) kinds: Per<String>,
    pub(super) units: Per<String>,
    /// Per axis its step; `None` for an axis that is not space. Components beyond the third are dropped.
    pub(super) directions: Per<Option<DVec3>>,
    pub(super) origin: Option<DVec3>,
    pub(super) space: Option<String>,
    pub(super) space_units: Vec<String>,
    pub(super) facts: Facts,
    /// Line, key and value of what is said of segments.
    pub(super) segments: Vec<(u64, String, String)>,
    /// Bytes of the header, and the line on which attached data begin.
    pub(super) end: usize,
    pub(super) lines: u64,
}

/// Reads the header at the start of `bytes`.
pub(super) fn parse(bytes: &[u8], warnings: &mut Warnings) -> Result<Header, ReadErrorKind> {
    let mut reader = Reader::default();
    let mut at = 0;
    let mut line = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        let end = rest.iter().position(|&b| b == b'\n');
        let text = &rest[..end.unwrap_or(rest.len())];
        at += end.map_or(rest.len(), |e| e + 1);
        line += 1;
        let text = text.strip_suffix(b"\r").unwrap_or(text);
        if line == 1 {
            check_magic(text)?;
        } else if text.is_empty() {
            break;
        } else if text[0] != b'#' {
            reader.line(line, text, warnings)?;
        }
    }
    reader.finish(at, line + 1, warnings)
}

fn check_magic(text: &[u8]) -> Result<(), ReadErrorKind> {
    match text.strip_prefix(b"NRRD") {
        Some([b'0', b'0', b'0', b'1'..=b'5']) => Ok(()),
        Some(version) => Err(ReadErrorKind::at_line(
            1,
            format!("NRRD version {} is not read; 0001 to 0005 are", quote(version)),
        )),
        None => Err(ReadErrorKind::at_line(1, format!("{} is not NRRD000 and a digit", quote(text)))),
    }
}

#[derive(Default)]
struct Reader {
    sample: Option<SampleType>,
    dimension: Option<usize>,
    sizes: Per<u64>,
    encoding: Option<Encoding>,
    big_endian: Option<bool>,
    line_skip: u64,
    byte_skip: i64,
    data: DataFiles,
    data_line: u64,
    /// The rest of the header names data files.
    listing: bool,
    spacings: Per<f64>,
    mins: Per<f64>,
    maxs: Per<f64>,
    centers: Per<String>,
    kinds: Per<String>,
    units: Per<String>,
    directions: Per<Option<DVec3>>,
    origin: Option<DVec3>,
    space: Option<String>,
    space_units: Vec<String>,
    facts: Facts,
    segments: Vec<(u64, String, String)>,
}

impl Reader {
    fn line(&mut self, line: u64, text: &[u8], warnings: &mut Warnings) -> Result<(), ReadErrorKind> {
        let owned = String::from_utf8_lossy(text);
        if self.listing {
            if let DataFiles::Named { names, .. } = &mut self.data {
                names.push(owned.trim().into());
            }
            return Ok(());
        }
        let field = owned.split_once(": ").or_else(|| owned.split_once(':'));
        if let Some((name, value)) = field
            && !value.starts_with('=')
        {
            let name = name.trim().to_ascii_lowercase();
            if self.field(&name, value.trim(), line)? {
                return Ok(());
            }
        }
        if let Some((key, value)) = owned.split_once(":=") {
            if is_segment_key(key.trim()) {
                self.segments.push((line, key.trim().into(), value.into()));
            } else {
                self.facts.add(key.trim(), value);
            }
            return Ok(());
        }
        match field {
            Some((name, _)) => {
                let place = format!("{} on line {line}", quote(name.as_bytes()));
                warnings.counted("unknown NRRD fields ignored", 1, Some(place));
                Ok(())
            }
            None => Err(ReadErrorKind::at_line(
                line,
                format!("{} is neither 'field: value' nor 'key:=value'", quote(text)),
            )),
        }
    }

    /// Takes a field; false if there is none of this name.
    fn field(&mut self, name: &str, value: &str, line: u64) -> Result<bool, ReadErrorKind> {
        let wrong = |reason: String| ReadErrorKind::at_line(line, reason);
        let no_number = || wrong(format!("{} is not a whole number", quote(value.as_bytes())));
        match name {
            "type" => self.sample = Some(sample_type(value).map_err(wrong)?),
            "dimension" => {
                let n = value.parse().map_err(|_| no_number())?;
                if n == 0 || n > MOST_AXES {
                    return Err(wrong(format!("{n} axes; 1 to {MOST_AXES} are allowed")));
                }
                self.dimension = Some(n);
            }
            "sizes" => {
                let sizes: Result<Vec<u64>, _> = value.split_whitespace().map(str::parse).collect();
                let values = sizes.map_err(|_| no_number())?;
                if values.contains(&0) {
                    return Err(wrong("an axis of size 0".into()));
                }
                self.sizes = Per { line, values };
            }
            "encoding" => self.encoding = Some(encoding(value).map_err(wrong)?),
            "endian" => {
                self.big_endian = match value.to_ascii_lowercase().as_str() {
                    "big" => Some(true),
                    "little" => Some(false),
                    _ => return Err(wrong(format!("{} is neither little nor big", quote(value.as_bytes())))),
                }
            }
            "line skip" | "lineskip" => self.line_skip = value.parse().map_err(|_| no_number())?,
            "byte skip" | "byteskip" => {
                self.byte_skip = value.parse().map_err(|_| no_number())?;
                if self.byte_skip < -1 {
                    return Err(wrong(format!("byte skip {value}; -1 and more are allowed")));
                }
            }
            "data file" | "datafile" => {
                self.data_line = line;
                (self.data, self.listing) = data_files(value).map_err(wrong)?;
            }
            "spacings" => self.spacings = Per { line, values: numbers(value).map_err(wrong)? },
            "axis mins" | "axismins" => self.mins = Per { line, values: numbers(value).map_err(wrong)? },
            "axis maxs" | "axismaxs" => self.maxs = Per { line, values: numbers(value).map_err(wrong)? },
            "centers" | "centerings" => self.centers = Per { line, values: words(value) },
            "kinds" => {
                self.kinds = Per { line, values: words(value) };
                let plain = ["domain", "space", "???", "none"];
                if !self.kinds.values.iter().all(|k| plain.contains(&k.as_str())) {
                    self.facts.add("kinds", value);
                }
            }
            "units" => self.units = Per { line, values: strings(value) },
            "space" => {
                self.facts.add("space", value);
                self.space = Some(value.to_ascii_lowercase());
            }
            "space dimension" => self.facts.add("space dimension", value),
            "space units" => self.space_units = strings(value),
            "space directions" => {
                let values = vectors(value).map_err(wrong)?;
                self.directions = Per { line, values };
            }
            "space origin" => {
                self.origin = vectors(value).map_err(wrong)?.first().copied().flatten();
            }
            // What is said of the file, and has no place in a volume.
            "content" | "sample units" | "measurement frame" | "labels" | "thicknesses" | "min" | "max" => {
                self.facts.add(name, value);
            }
            "old min" | "oldmin" => self.facts.add("old min", value),
            "old max" | "oldmax" => self.facts.add("old max", value),
            "sampleunits" => self.facts.add("sample units", value),
            "number" | "block size" | "blocksize" => {}
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn finish(self, end: usize, lines: u64, warnings: &mut Warnings) -> Result<Header, ReadErrorKind> {
        let missing = |what: &str| {
            ReadErrorKind::at_line(lines.saturating_sub(1), format!("the header has no '{what}'"))
        };
        let sample = self.sample.ok_or_else(|| missing("type"))?;
        let dimension = self.dimension.ok_or_else(|| missing("dimension"))?;
        let encoding = self.encoding.ok_or_else(|| missing("encoding"))?;
        if self.sizes.is_empty() {
            return Err(missing("sizes"));
        }
        let mut big_endian = self.big_endian;
        if sample.bytes() > 1 && encoding != Encoding::Ascii && big_endian.is_none() {
            warnings.say("the header does not say the byte order: little endian assumed");
            big_endian = Some(false);
        }
        for (name, line, count) in [
            ("sizes", self.sizes.line, self.sizes.values.len()),
            ("spacings", self.spacings.line, self.spacings.values.len()),
            ("axis mins", self.mins.line, self.mins.values.len()),
            ("axis maxs", self.maxs.line, self.maxs.values.len()),
            ("centers", self.centers.line, self.centers.values.len()),
            ("kinds", self.kinds.line, self.kinds.values.len()),
            ("space directions", self.directions.line, self.directions.values.len()),
        ] {
            if count > 0 && count != dimension {
                return Err(ReadErrorKind::at_line(line, format!("{count} {name} for {dimension} axes")));
            }
        }
        let mut data = self.data;
        let detached = matches!(data, DataFiles::Named { .. });
        if let DataFiles::Named { names, .. } = &mut data {
            names.retain(|n| !n.is_empty());
        }
        Ok(Header {
            sample,
            sizes: self.sizes.values,
            encoding,
            big_endian,
            line_skip: self.line_skip,
            byte_skip: self.byte_skip,
            data,
            data_line: self.data_line,
            detached,
            spacings: self.spacings,
            mins: self.mins,
            maxs: self.maxs,
            centers: self.centers,
            kinds: self.kinds,
            units: self.units,
            directions: self.directions,
            origin: self.origin,
            space: self.space,
            space_units: self.space_units,
            facts: self.facts,
            segments: self.segments,
            end,
            lines,
        })
    }
}

fn sample_type(name: &str) -> Result<SampleType, String> {
    Ok(match name.to_ascii_lowercase().as_str() {
        "signed char" | "int8" | "int8_t" => SampleType::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => SampleType::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => SampleType::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => SampleType::U16,
        "int" | "signed int" | "int32" | "int32_t" => SampleType::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => SampleType::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => SampleType::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            SampleType::U64
        }
        "float" | "float32" => SampleType::F32,
        "double" | "float64" => SampleType::F64,
        "block" => return Err("samples of type block are no numbers".into()),
        _ => return Err(format!("{} is no sample type", quote(name.as_bytes()))),
    })
}

fn encoding(name: &str) -> Result<Encoding, String> {
    Ok(match name.to_ascii_lowercase().as_str() {
        "raw" => Encoding::Packed(Packing::None),
        "txt" | "text" | "ascii" => Encoding::Ascii,
        "hex" => Encoding::Hex,
        "gz" | "gzip" => Encoding::Packed(Packing::Gzip),
        #[cfg(feature = "bzip2")]
        "bz2" | "bzip2" => Encoding::Packed(Packing::Bzip2),
        #[cfg(not(feature = "bzip2"))]
        "bz2" | "bzip2" => return Err("this build of dotwork does not read bzip2".into()),
        _ => return Err(format!("the encoding {} is not read", quote(name.as_bytes()))),
    })
}

/// Names data files; true if the names follow on lines of their own.
fn data_files(value: &str) -> Result<(DataFiles, bool), String> {
    let parts: Vec<&str> = value.split_whitespace().collect();
    let axes = |text: Option<&&str>| match text {
        None => Ok(None),
        Some(text) => text
            .parse()
            .ok()
            .filter(|n| (1..=MOST_AXES).contains(n))
            .map(Some)
            .ok_or_else(|| format!("{} is no number of axes", quote(text.as_bytes()))),
    };
    if parts.first() == Some(&"LIST") && parts.len() <= 2 {
        return Ok((DataFiles::Named { names: Vec::new(), share_axes: axes(parts.get(1))? }, true));
    }
    if value.contains('%') {
        // The pattern may hold spaces: the numbers are the last words.
        let numbers: Vec<i64> = parts.iter().rev().map_while(|p| p.parse().ok()).take(4).collect();
        let (count, share_axes) = match numbers.len() {
            3 => (3, None),
            4 => (4, axes(parts.last())?),
            _ => (0, None),
        };
        if count > 0 && parts.len() > count {
            let mut pattern = value.trim();
            for _ in 0..count {
                pattern = pattern.rsplit_once(char::is_whitespace).map_or(pattern, |(p, _)| p.trim_end());
            }
            let [step, last, first] = [numbers[count - 3], numbers[count - 2], numbers[count - 1]];
            let names = numbered(pattern, first, last, step)?;
            return Ok((DataFiles::Named { names, share_axes }, false));
        }
    }
    if value.is_empty() {
        return Err("no data file is named".into());
    }
    Ok((DataFiles::Named { names: vec![value.into()], share_axes: None }, false))
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("{} is not a number", quote(text.as_bytes())))
}

fn numbers(value: &str) -> Result<Vec<f64>, String> {
    value.split_whitespace().map(number).collect()
}

fn words(value: &str) -> Vec<String> {
    value.split_whitespace().map(str::to_ascii_lowercase).collect()
}

/// Quoted strings, or words where there are no quotes.
fn strings(value: &str) -> Vec<String> {
    if !value.contains('"') {
        return value.split_whitespace().map(Into::into).collect();
    }
    value.split('"').skip(1).step_by(2).map(Into::into).collect()
}

/// Vectors "(1,0,0) (0,1,0) none": of one to three components, the missing ones 0, further ones dropped.
fn vectors(value: &str) -> Result<Vec<Option<DVec3>>, String> {
    let mut vectors = Vec::new();
    let mut rest = value.trim_start();
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix('(') {
            let (inside, after) =
                after.split_once(')').ok_or_else(|| format!("{} has no ')'", quote(rest.as_bytes())))?;
            let mut v = DVec3::ZERO;
            for (i, part) in inside.split(',').enumerate() {
                let value = number(part)?;
                if i < 3 {
                    v[i] = value;
                }
            }
            vectors.push(Some(v));
            rest = after.trim_start();
        } else {
            let end = rest.find([' ', '\t', '(']).unwrap_or(rest.len());
            let (word, after) = rest.split_at(end);
            if !word.eq_ignore_ascii_case("none") {
                return Err(format!("{} is neither a vector '(x,y,z)' nor 'none'", quote(word.as_bytes())));
            }
            vectors.push(None);
            rest = after.trim_start();
        }
        if vectors.len() > MOST_AXES {
            return Err(format!("more than {MOST_AXES} vectors"));
        }
    }
    Ok(vectors)
}
