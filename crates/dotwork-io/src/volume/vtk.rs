//! Legacy VTK files with structured points (VTK file formats, "simple legacy formats"): five header parts, then
//! attributes of points or cells, in text or big-endian binary. The first attribute is the volume.

use dotwork_drawing::Warnings;
use dotwork_volume::{SampleType, Scaling, Space, Unit};
use glam::DVec3;

use crate::error::{ReadErrorKind, quote};
use crate::volume::Found;
use crate::volume::ascii::read_numbers;
use crate::volume::data::{After, Part, Skip, pour, product};
use crate::volume::facts::Facts;
use crate::volume::fill::Fill;
use crate::volume::format::is_vtk_xml_image;
use crate::volume::grid::{self, usable_spacing};
use crate::volume::reduce::{Reduction, reduce};
use crate::volume::stream::{Packing, Stream};

/// A cursor over the lines of the header.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The number of the line last given.
    line: u64,
}

impl<'a> Lines<'a> {
    /// The next line, whatever is on it.
    fn any(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.at..).filter(|r| !r.is_empty())?;
        let end = rest.iter().position(|&b| b == b'\n');
        self.at += end.map_or(rest.len(), |e| e + 1);
        self.line += 1;
        Some(rest[..end.unwrap_or(rest.len())].trim_ascii())
    }

    /// The words of the next line that has some.
    fn words(&mut self) -> Result<Vec<&'a str>, ReadErrorKind> {
        loop {
            let Some(line) = self.any() else {
                return Err(ReadErrorKind::at_line(self.line, "the file ends within its header"));
            };
            if line.is_empty() {
                continue;
            }
            // Long lines are data where a header was expected.
            return match std::str::from_utf8(&line[..line.len().min(4096)]) {
                Ok(text) => Ok(text.split_ascii_whitespace().collect()),
                Err(_) => Err(self.error(format!("{} is no text", quote(line)))),
            };
        }
    }

    fn error(&self, reason: impl Into<String>) -> ReadErrorKind {
        ReadErrorKind::at_line(self.line, reason)
    }

    fn number<T: std::str::FromStr>(&self, word: Option<&&str>) -> Result<T, ReadErrorKind> {
        let word = word.copied().unwrap_or_default();
        word.parse().map_err(|_| self.error(format!("{} is not the number expected", quote(word.as_bytes()))))
    }

    /// The three numbers behind the first word.
    fn three<T: std::str::FromStr>(&self, words: &[&str]) -> Result<[T; 3], ReadErrorKind> {
        Ok([self.number(words.get(1))?, self.number(words.get(2))?, self.number(words.get(3))?])
    }

    /// Passes over what is said about an array, up to a blank line.
    fn skip_metadata(&mut self) {
        while self.any().is_some_and(|line| !line.is_empty()) {}
    }

    /// Passes over the values of `arrays` arrays of a field that belongs to the whole file: its time, for example.
    fn skip_field(&mut self, arrays: u64, binary: bool) -> Result<(), ReadErrorKind> {
        for _ in 0..arrays {
            let mut words = self.words()?;
            if words[0] == "METADATA" {
                self.skip_metadata();
                words = self.words()?;
            }
            let sample = sample_type(words.get(3).copied().unwrap_or_default(), self)?;
            let values = product([self.number(words.get(1))?, self.number(words.get(2))?])?;
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            let width = if binary { sample.bytes() as u64 } else { 1 };
            // A number of a text takes a character at least.
            if values.checked_mul(width).is_none_or(|n| n > rest.len() as u64) {
                return Err(self.error(format!("a field of {values} values, which are not there")));
            }
            let length = if binary {
                (values * width) as usize
            } else {
                read_numbers(&mut Fill::new(sample, values)?, rest, self.line + 1, values as usize)?
            };
            self.at += length;
            self.line += rest[..length].iter().filter(|&&b| b == b'\n').count() as u64;
        }
        Ok(())
    }
}

/// The attribute that becomes the volume.
struct Array {
    name: String,
    sample: SampleType,
    components: u64,
    how: Reduction,
}

pub(super) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<Found, ReadErrorKind> {
    if is_vtk_xml_image(bytes) {
        return Err(ReadErrorKind::Refused(
            "is an XML file of VTK (.vti), which is not read; legacy VTK, MetaImage, NRRD and NIfTI are"
                .into(),
        ));
    }
    let mut lines = Lines { bytes, at: 0, line: 0 };
    let mut facts = Facts::default();
    lines.any();
    facts.add("title", String::from_utf8_lossy(lines.any().unwrap_or_default()));
    let binary = match lines.words()?[0].to_ascii_uppercase().as_str() {
        "BINARY" => true,
        "ASCII" => false,
        other => return Err(lines.error(format!("{} is neither ASCII nor BINARY", quote(other.as_bytes())))),
    };
    check_dataset(&mut lines)?;

    let mut points = None;
    let mut spacing = None;
    let mut origin = DVec3::ZERO;
    let (count, cells) = loop {
        let words = lines.words()?;
        match words[0].to_ascii_uppercase().as_str() {
            "DIMENSIONS" => {
                let sides: [u64; 3] = lines.three(&words)?;
                if sides.contains(&0) {
                    return Err(lines.error("a side of 0"));
                }
                points = Some(sides);
            }
            "SPACING" | "ASPECT_RATIO" => spacing = Some(lines.three(&words)?),
            "ORIGIN" => origin = DVec3::from_array(lines.three(&words)?),
            "POINT_DATA" => break (lines.number::<u64>(words.get(1))?, false),
            "CELL_DATA" => break (lines.number::<u64>(words.get(1))?, true),
            "FIELD" => {
                let arrays = lines.number(words.get(2))?;
                lines.skip_field(arrays, binary)?;
            }
            "METADATA" => lines.skip_metadata(),
            other => {
                return Err(lines.error(format!("{} is not expected here", quote(other.as_bytes()))));
            }
        }
    };
    let points = points.ok_or_else(|| lines.error("no DIMENSIONS before the data"))?;
    // A row of n points has n − 1 cells; a flat grid has one layer of them.
    let sides = if cells { points.map(|n| (n - 1).max(1)) } else { points };
    if product(sides)? != count {
        let [x, y, z] = sides;
        return Err(lines.error(format!("{count} values for {x} x {y} x {z} voxels")));
    }
    let array = first_array(&mut lines, count, binary)?;
    facts.add("array", &array.name);
    if cells {
        facts.add("values", "of cells");
    }

    let width = array.sample.bytes() as u64;
    let wanted = product([count, array.components, width])?;
    let mut fill = Fill::new(array.sample, wanted / width)?;
    let end = if binary {
        let part = Part {
            skip: Skip::Bytes(0),
            wanted,
            declared: wanted,
            after: After::Anything,
            one_of_many: false,
        };
        pour(&mut fill, Stream::new(&bytes[lines.at..], Packing::None), lines.at, part, warnings)?;
        lines.at + wanted as usize
    } else {
        let samples = (wanted / width) as usize;
        lines.at + read_numbers(&mut fill, &bytes[lines.at..], lines.line + 1, samples)?
    };
    if more_arrays(&bytes[end..]) {
        warnings.say(format!("the file holds several arrays: the first, '{}', is taken", array.name));
    }
    let mut samples = fill.finish(binary || cfg!(target_endian = "big"));
    if array.components > 1 {
        warnings.say(match array.how {
            Reduction::Luminance => format!("{} colours a voxel: their luminance is taken", array.components),
            _ => format!("{} values a voxel: the first is taken", array.components),
        });
        reduce(&mut samples, 1, array.components as usize, array.how);
    }

    if spacing.is_none() {
        warnings.say("no spacing in the file: 1 x 1 x 1 assumed");
    }
    let spacing = spacing.unwrap_or([1.0; 3]);
    let spacing = [0, 1, 2].map(|i| usable_spacing(spacing[i], i, warnings));
    if cells {
        for axis in 0..3 {
            // The cells of a flat grid lie in its plane.
            if points[axis] > 1 {
                origin[axis] += 0.5 * spacing[axis];
            }
        }
    }
    let steps = [0, 1, 2].map(|i| Some(DVec3::AXES[i] * spacing[i]));
    Ok(Found {
        // Their product fits, as the samples do.
        dims: sides.map(|n| n as usize),
        samples,
        scaling: Scaling::default(),
        affine: grid::affine(steps, origin, Space::Unknown, Unit::Unknown, warnings),
        format: format!("legacy VTK, {}", if binary { "binary" } else { "ascii" }),
        facts,
    })
}

fn check_dataset(lines: &mut Lines) -> Result<(), ReadErrorKind> {
    let words = lines.words()?;
    if !words[0].eq_ignore_ascii_case("DATASET") {
        return Err(lines.error(format!("{} is not DATASET", quote(words[0].as_bytes()))));
    }
    match words.get(1).copied().unwrap_or_default().to_ascii_uppercase().as_str() {
        "STRUCTURED_POINTS" => Ok(()),
        "POLYDATA" => {
            Err(lines.error("holds POLYDATA, a mesh; of VTK's data sets only STRUCTURED_POINTS are read"))
        }
        kind @ ("STRUCTURED_GRID" | "RECTILINEAR_GRID" | "UNSTRUCTURED_GRID" | "FIELD") => {
            Err(lines.error(format!("holds a {kind}; of VTK's data sets only STRUCTURED_POINTS are read")))
        }
        other => Err(lines.error(format!("{} is no data set of VTK", quote(other.as_bytes())))),
    }
}

/// Reads the announcement of the first array, up to its first value.
fn first_array(lines: &mut Lines, count: u64, binary: bool) -> Result<Array, ReadErrorKind> {
    loop {
        let words = lines.words()?;
        let name = || words.get(1).copied().unwrap_or_default().replace("%20", " ");
        return match words[0].to_ascii_uppercase().as_str() {
            "SCALARS" => {
                let sample = sample_type(words.get(2).copied().unwrap_or_default(), lines)?;
                let components = match words.get(3) {
                    None => 1,
                    word => lines.number(word)?,
                };
                if !(1..=4).contains(&components) {
                    return Err(lines.error(format!("{components} components; SCALARS have 1 to 4")));
                }
                // The table that follows is optional in old files.
                let before = (lines.at, lines.line);
                let table = lines.any().unwrap_or_default();
                if !table.get(..12).is_some_and(|t| t.eq_ignore_ascii_case(b"LOOKUP_TABLE")) {
                    (lines.at, lines.line) = before;
                }
                let colours = components >= 3 && sample == SampleType::U8;
                let how = if colours { Reduction::Luminance } else { Reduction::First };
                Ok(Array { name: name(), sample, components, how })
            }
            "COLOR_SCALARS" => {
                let components = lines.number(words.get(2))?;
                if !(1..=4).contains(&components) {
                    return Err(lines.error(format!("{components} components; COLOR_SCALARS have 1 to 4")));
                }
                let sample = if binary { SampleType::U8 } else { SampleType::F32 };
                let how = if components >= 3 { Reduction::Luminance } else { Reduction::First };
                Ok(Array { name: name(), sample, components, how })
            }
            "VECTORS" | "NORMALS" => {
                let sample = sample_type(words.get(2).copied().unwrap_or_default(), lines)?;
                Ok(Array { name: name(), sample, components: 3, how: Reduction::First })
            }
            "FIELD" => {
                if lines.number::<u64>(words.get(2))? == 0 {
                    continue;
                }
                let words = lines.words()?;
                let components = lines.number(words.get(1))?;
                if components == 0 || lines.number::<u64>(words.get(2))? != count {
                    return Err(lines.error("an array that has not one value for each voxel"));
                }
                let sample = sample_type(words.get(3).copied().unwrap_or_default(), lines)?;
                let name = words[0].replace("%20", " ");
                Ok(Array { name, sample, components, how: Reduction::First })
            }
            other => {
                Err(lines
                    .error(format!("begins with {}, of which no volume is made", quote(other.as_bytes()))))
            }
        };
    }
}

fn sample_type(name: &str, lines: &Lines) -> Result<SampleType, ReadErrorKind> {
    Ok(match name.to_ascii_lowercase().as_str() {
        "unsigned_char" => SampleType::U8,
        "char" | "signed_char" => SampleType::I8,
        "unsigned_short" => SampleType::U16,
        "short" => SampleType::I16,
        "unsigned_int" => SampleType::U32,
        // VTK writes its identifiers as int.
        "int" | "vtkidtype" => SampleType::I32,
        "unsigned_long" | "vtktypeuint64" | "unsigned_long_long" => SampleType::U64,
        "long" | "vtktypeint64" | "long_long" => SampleType::I64,
        "float" => SampleType::F32,
        "double" => SampleType::F64,
        "bit" => return Err(lines.error("samples of 1 bit are not read")),
        "string" | "utf8_string" | "variant" => {
            return Err(lines.error(format!("arrays of type {name} are not read")));
        }
        _ => return Err(lines.error(format!("{} is no sample type of VTK", quote(name.as_bytes())))),
    })
}

/// True if another array follows the first one's values.
fn more_arrays(rest: &[u8]) -> bool {
    const KEYWORDS: [&[u8]; 10] = [
        b"SCALARS",
        b"COLOR_SCALARS",
        b"VECTORS",
        b"NORMALS",
        b"TENSORS",
        b"FIELD",
        b"TEXTURE_COORDINATES",
        b"POINT_DATA",
        b"CELL_DATA",
        b"GLOBAL_IDS",
    ];
    rest.split(|&b| b == b'\n')
        // After the values come, at most, a few lines about them.
        .take(32)
        .any(|line| KEYWORDS.iter().any(|k| line.trim_ascii_start().starts_with(k)) || is_field_array(line))
}

/// True for the announcement of a further array of a field: a name, two counts and a type.
fn is_field_array(line: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(&line[..line.len().min(4096)]) else { return false };
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    matches!(words[..], [_, components, tuples, kind]
        if components.parse::<u64>().is_ok() && tuples.parse::<u64>().is_ok()
            && kind.starts_with(|c: char| c.is_ascii_alphabetic()))
}
