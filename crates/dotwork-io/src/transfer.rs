//! Transfer functions from files, and into them.
//!
//! Three formats are read, told apart by content:
//!
//! * our own, in TOML, which a person can write and [`write_transfer`] writes:
//!
//!   ```toml
//!   name = "bone in skin"           # may be missing
//!   # Points [value, opacity]: straight lines between them, constant beyond.
//!   opacity = [[-500, 0], [-300, 0.1], [200, 0.1], [400, 0.9]]
//!   # Points [value, colour]; may be missing.
//!   color = [[-300, "#d9a066"], [400, "#ffffff"]]
//!   # Points [length of the gradient, factor of the opacity]; may be missing.
//!   gradient = [[0, 0], [90, 1]]
//!   ```
//!
//! * Slicer's volume rendering presets and scenes, XML with elements `<VolumeProperty name="CT-Bone"
//!   scalarOpacity="8 -3024 0 …" gradientOpacity="4 0 1 255 1" colorTransfer="16 -3024 0 0 0 …">`: how many numbers
//!   follow, then value and opacity, or value, red, green and blue, by turns;
//! * Slicer's `.vp` files: nine lines, the last three of which hold the same texts.
//!
//! Slicer's points are put in the order of their values. XML with a DTD is refused, so no entity expands.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use dotwork_volume::TransferFunction;
use toml::de::{DeTable, DeValue};

use crate::error::{ReadError, ReadErrorKind, one_line, quote, shortened};
use crate::file::read_bytes;

/// Bytes of a file at most.
const LARGEST: usize = 16 << 20;

/// Elements, texts and attributes of an XML file at most.
const MOST_NODES: u32 = 200_000;

/// Names of presets that a message lists.
const LISTED: usize = 40;

/// A transfer function and what it is called.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransferFile {
    /// Its name; empty if it has none.
    pub name: String,
    /// The function; its points are checked.
    pub function: TransferFunction,
}

/// Reads a transfer function: TOML, Slicer's XML, or `.vp`. Of several in a file `preset` says which by name, upper and
/// lower case alike; without it there must be only one.
///
/// # Errors
/// [`ReadError`], with file, line and reason. If `preset` is missing or unknown, the message lists those that there are.
pub fn read_transfer(path: &Path, preset: Option<&str>) -> Result<TransferFile, ReadError> {
    let bytes = read_bounded(path)?;
    transfer_from_bytes(path, &bytes, preset)
}

/// Reads a transfer function from the bytes of a file; `name` appears in messages.
///
/// # Errors
/// As [`read_transfer`].
pub fn transfer_from_bytes(
    name: &Path,
    bytes: &[u8],
    preset: Option<&str>,
) -> Result<TransferFile, ReadError> {
    let in_file = |kind| ReadError { path: name.to_path_buf(), kind };
    let text = text_of(bytes).map_err(in_file)?;
    if is_xml(text) {
        return from_xml(text, preset).map_err(in_file);
    }
    let file = if is_vp(text) { from_vp(text) } else { from_toml(text) }.map_err(in_file)?;
    match preset {
        Some(asked) if !asked.eq_ignore_ascii_case(&file.name) => {
            Err(in_file(unknown_preset(asked, std::slice::from_ref(&file.name))))
        }
        _ => Ok(file),
    }
}

/// The names of the transfer functions in a file, in its order; one without a name has an empty one.
///
/// # Errors
/// As [`read_transfer`], but for the points of XML presets, which are not looked at.
pub fn transfer_names(name: &Path, bytes: &[u8]) -> Result<Vec<String>, ReadError> {
    let in_file = |kind| ReadError { path: name.to_path_buf(), kind };
    let text = text_of(bytes).map_err(in_file)?;
    if !is_xml(text) {
        return transfer_from_bytes(name, bytes, None).map(|file| vec![file.name]);
    }
    let document = document(text).map_err(in_file)?;
    Ok(properties(&document).map(name_of).collect())
}

/// Writes a transfer function as TOML that [`read_transfer`] reads back: values unchanged, colours in 8 bits.
///
/// # Errors
/// Those of `out`.
pub fn write_transfer(file: &TransferFile, mut out: impl Write) -> io::Result<()> {
    let mut text = String::from(
        "# A transfer function: points [value, opacity], [value, colour], [gradient, factor].\n",
    );
    if !file.name.is_empty() {
        let _ = writeln!(text, "name = {}", toml::Value::String(file.name.clone()));
    }
    let plain = |points: &[(f64, f64)]| -> Vec<String> {
        points.iter().map(|(x, y)| format!("[{}, {}]", number(*x), number(*y))).collect()
    };
    let color = |(x, c): &(f64, [f32; 3])| {
        let [r, g, b] = c.map(|c| (c * 255.0).round() as u8);
        format!("[{}, \"#{r:02x}{g:02x}{b:02x}\"]", number(*x))
    };
    let function = &file.function;
    for (key, points) in [
        ("opacity", plain(&function.opacity)),
        ("color", function.color.iter().map(color).collect()),
        ("gradient", plain(&function.gradient)),
    ] {
        if !points.is_empty() {
            let _ = writeln!(text, "{key} = [\n    {},\n]", points.join(",\n    "));
        }
    }
    out.write_all(text.as_bytes())?;
    out.flush()
}

/// The shortest text that is read back as the same number, a whole one without a point.
fn number(x: f64) -> String {
    // `{:?}` writes exponents for large numbers, where `{}` writes hundreds of digits.
    let text = format!("{x:?}");
    text.strip_suffix(".0").map_or(text.clone(), Into::into)
}

fn read_bounded(path: &Path) -> Result<Vec<u8>, ReadError> {
    let in_path = |kind| ReadError { path: path.to_path_buf(), kind };
    if std::fs::metadata(path).is_ok_and(|m| m.len() > LARGEST as u64) {
        return Err(in_path(too_large()));
    }
    read_bytes(path).map_err(in_path)
}

fn too_large() -> ReadErrorKind {
    ReadErrorKind::TooLarge("is over 16 MiB: no transfer function".into())
}

fn text_of(bytes: &[u8]) -> Result<&str, ReadErrorKind> {
    if bytes.len() > LARGEST {
        return Err(too_large());
    }
    let text = std::str::from_utf8(bytes)
        .map_err(|e| ReadErrorKind::at_line(line_at(bytes, e.valid_up_to()), "is not UTF-8"))?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// The line of a byte, counted from 1.
fn line_at(bytes: &[u8], at: usize) -> u64 {
    1 + bytes[..at.min(bytes.len())].iter().filter(|&&b| b == b'\n').count() as u64
}

fn is_xml(text: &str) -> bool {
    text.trim_start().starts_with('<')
}

/// A `.vp` file begins with a line that is a number, which TOML never does.
fn is_vp(text: &str) -> bool {
    text.lines().next().is_some_and(|line| line.trim().parse::<f64>().is_ok())
}

// --- TOML

fn from_toml(text: &str) -> Result<TransferFile, ReadErrorKind> {
    let wrong = |at: usize, reason: String| ReadErrorKind::at_line(line_at(text.as_bytes(), at), reason);
    let table = DeTable::parse(text).map_err(|e| {
        let reason = e.message().split('\n').collect::<Vec<_>>().join("; ");
        wrong(e.span().map_or(0, |s| s.start), one_line(&reason))
    })?;
    let mut file = TransferFile::default();
    // Where the points of the three curves stand.
    let mut places: [(&str, Vec<usize>); 3] = ["opacity", "color", "gradient"].map(|c| (c, Vec::new()));
    let mut entries: Vec<_> = table.get_ref().iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    for (key, value) in entries {
        let name: &str = key.get_ref();
        if name == "name" {
            let DeValue::String(text) = value.get_ref() else {
                return Err(wrong(value.span().start, "name: takes a string".into()));
            };
            file.name = one_line(text);
            continue;
        }
        let Some((_, places)) = places.iter_mut().find(|(curve, _)| *curve == name) else {
            let reason = format!("{} is none of name, opacity, color, gradient", quote(name.as_bytes()));
            return Err(wrong(key.span().start, reason));
        };
        let DeValue::Array(points) = value.get_ref() else {
            return Err(wrong(value.span().start, format!("{name}: takes a list of points [x, y]")));
        };
        for point in points {
            let at = point.span().start;
            let point = match point.get_ref() {
                DeValue::Array(pair) if pair.len() == 2 => [pair[0].get_ref(), pair[1].get_ref()],
                _ => return Err(wrong(at, format!("{name}: a point is a list of two, [x, y]"))),
            };
            let in_point =
                |reason: String| wrong(at, format!("{name}, point {}: {reason}", places.len() + 1));
            let x = toml_number(point[0]).map_err(in_point)?;
            match name {
                "color" => file.function.color.push((x, hex_color(point[1]).map_err(in_point)?)),
                "opacity" => file.function.opacity.push((x, toml_number(point[1]).map_err(in_point)?)),
                _ => file.function.gradient.push((x, toml_number(point[1]).map_err(in_point)?)),
            }
            places.push(at);
        }
    }
    file.function.check().map_err(|e| {
        let points = places.iter().find(|(curve, _)| *curve == e.curve).map(|(_, places)| places);
        let at = e.point.and_then(|i| points?.get(i).copied());
        wrong(at.unwrap_or(0), e.to_string())
    })?;
    Ok(file)
}

fn toml_number(value: &DeValue) -> Result<f64, String> {
    let number = match value {
        DeValue::Float(f) => f.as_str().replace('_', "").parse().ok(),
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix()).ok().map(|i| i as f64),
        _ => return Err("a number was expected".into()),
    };
    number.ok_or_else(|| "the number is too large".into())
}

fn hex_color(value: &DeValue) -> Result<[f32; 3], String> {
    let DeValue::String(text) = value else { return Err("a colour \"#rrggbb\" was expected".into()) };
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()));
    let bits = digits.and_then(|d| u32::from_str_radix(d, 16).ok());
    let bits = bits.ok_or_else(|| format!("{} is no colour \"#rrggbb\"", quote(text.as_bytes())))?;
    let [_, r, g, b] = bits.to_be_bytes();
    Ok([r, g, b].map(|c| f32::from(c) / 255.0))
}

// --- Slicer

fn document(text: &str) -> Result<roxmltree::Document<'_>, ReadErrorKind> {
    let options =
        roxmltree::ParsingOptions { allow_dtd: false, nodes_limit: MOST_NODES, ..Default::default() };
    roxmltree::Document::parse_with_options(text, options).map_err(|e| {
        ReadErrorKind::at_line(e.pos().row.into(), format!("XML: {}", shortened(&e.to_string())))
    })
}

fn properties<'a>(document: &'a roxmltree::Document<'a>) -> impl Iterator<Item = roxmltree::Node<'a, 'a>> {
    document.descendants().filter(|n| n.tag_name().name() == "VolumeProperty")
}

fn name_of(node: roxmltree::Node<'_, '_>) -> String {
    one_line(node.attribute("name").or(node.attribute("id")).unwrap_or_default())
}

fn from_xml(text: &str, preset: Option<&str>) -> Result<TransferFile, ReadErrorKind> {
    let document = document(text)?;
    let nodes: Vec<_> = properties(&document).collect();
    let names: Vec<String> = nodes.iter().map(|n| name_of(*n)).collect();
    let found = match (preset, &nodes[..]) {
        (_, []) => {
            return Err(ReadErrorKind::Refused("is XML without a transfer function (VolumeProperty)".into()));
        }
        (None, [one]) => *one,
        (None, several) => {
            let (count, list) = (several.len(), listed(&names));
            return Err(ReadErrorKind::Refused(format!(
                "has {count} presets, of which one must be named: {list}"
            )));
        }
        (Some(asked), _) => {
            let at = names.iter().position(|n| n.eq_ignore_ascii_case(asked));
            nodes[at.ok_or_else(|| unknown_preset(asked, &names))?]
        }
    };
    let curve = |name: &str| match found.attribute_node(name) {
        Some(attribute) => (attribute.value(), document.text_pos_at(attribute.range().start).row.into()),
        None => ("", document.text_pos_at(found.range().start).row.into()),
    };
    let function =
        slicer_function([curve("scalarOpacity"), curve("gradientOpacity"), curve("colorTransfer")])?;
    Ok(TransferFile { name: name_of(found), function })
}

fn from_vp(text: &str) -> Result<TransferFile, ReadErrorKind> {
    let mut lines = text.lines().zip(1..).skip(6);
    let mut next = |line: u64| lines.next().unwrap_or(("", line));
    let function = slicer_function([next(7), next(8), next(9)])?;
    Ok(TransferFile { name: String::new(), function })
}

/// A function of Slicer's texts for opacity, gradient and colour, each with the line on which it stands.
fn slicer_function(texts: [(&str, u64); 3]) -> Result<TransferFunction, ReadErrorKind> {
    let [(opacity, line), (gradient, gradient_line), (color, color_line)] = texts;
    let lines = [("opacity", line), ("gradient", gradient_line), ("color", color_line)];
    let numbers = |text, curve: &str, group, line| {
        slicer_numbers(text, group).map_err(|e| ReadErrorKind::at_line(line, format!("{curve}: {e}")))
    };
    let pairs = |numbers: Vec<f64>| -> Vec<(f64, f64)> {
        let mut points: Vec<_> = numbers.chunks_exact(2).map(|p| (p[0], p[1])).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let color = numbers(color, "color", 4, color_line)?;
    let mut colors: Vec<_> =
        color.chunks_exact(4).map(|p| (p[0], [p[1] as f32, p[2] as f32, p[3] as f32])).collect();
    colors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let opacity = pairs(numbers(opacity, "opacity", 2, line)?);
    let gradient = pairs(numbers(gradient, "gradient", 2, gradient_line)?);
    TransferFunction::new(opacity, colors, gradient).map_err(|e| {
        let line = lines.iter().find(|(curve, _)| *curve == e.curve).map_or(line, |(_, line)| *line);
        ReadErrorKind::at_line(line, e.to_string())
    })
}

/// The numbers behind their count, in whole groups; none of an empty text.
fn slicer_numbers(text: &str, group: usize) -> Result<Vec<f64>, String> {
    let mut words = text.split_ascii_whitespace();
    let Some(first) = words.next() else { return Ok(Vec::new()) };
    let most = TransferFunction::MAX_POINTS * group;
    let count: usize =
        first.parse().ok().filter(|n| n % group == 0 && *n <= most).ok_or_else(|| {
            format!("{} is no count of numbers in groups of {group}", quote(first.as_bytes()))
        })?;
    let parsed = |w: &str| w.parse().map_err(|_| format!("{} is not a number", quote(w.as_bytes())));
    let numbers = words.by_ref().take(count).map(parsed).collect::<Result<Vec<f64>, _>>()?;
    if numbers.len() != count || words.next().is_some() {
        return Err(format!(
            "{count} numbers are announced, and there are {}",
            if numbers.len() < count { numbers.len().to_string() } else { "more".into() }
        ));
    }
    Ok(numbers)
}

fn unknown_preset(asked: &str, names: &[String]) -> ReadErrorKind {
    ReadErrorKind::Refused(format!("has no preset {}; there are {}", quote(asked.as_bytes()), listed(names)))
}

fn listed(names: &[String]) -> String {
    let unnamed = |n: &String| if n.is_empty() { "one without a name".into() } else { shortened(n) };
    let list: Vec<String> = names.iter().take(LISTED).map(unnamed).collect();
    let more =
        if names.len() > LISTED { format!(" and {} more", names.len() - LISTED) } else { String::new() };
    list.join(", ") + &more
}
