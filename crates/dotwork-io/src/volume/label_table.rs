//! Label tables: names and colours for the values of a label volume.
//!
//! Three kinds of text file are read, told apart by their lines:
//!
//! * ITK-SNAP's label descriptions, `IDX R G B A VIS MSH "LABEL"`; opacity 0 … 1, visibility 0 or 1;
//! * Slicer's colour tables (`.ctbl`, `.txt`) and FreeSurfer's (`FreeSurferColorLUT.txt`), `index name r g b a`, the
//!   last four 0 … 255. The opacity may be missing. Where it is 0 throughout, as in FreeSurfer's, it says nothing.
//!
//! The tables of Slicer's segmentations are in the header of their NRRD file.

use std::collections::HashSet;
use std::path::Path;

use dotwork_drawing::Warnings;

use crate::error::{ReadError, ReadErrorKind, one_line, quote};
use crate::file::read_bytes;
use crate::text::with_newlines;

/// Entries of a table at most.
const MOST: usize = 65_536;

/// Bytes of a table's file at most.
const LARGEST: usize = 16 << 20;

/// Characters of a name at most.
const LONGEST: usize = 120;

/// Names and colours of labels.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LabelTable {
    /// In the order of the file; no value twice.
    pub entries: Vec<LabelEntry>,
}

/// What a table says of one label.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelEntry {
    /// The value that its voxels have.
    pub value: i64,
    /// Its name, one line.
    pub name: String,
    /// Its colour, sRGB.
    pub color: [u8; 3],
    /// False if the file hides it.
    pub visible: bool,
}

impl LabelTable {
    /// The entry of a value.
    pub fn find(&self, value: i64) -> Option<&LabelEntry> {
        self.entries.iter().find(|e| e.value == value)
    }
}

/// Reads a label table: ITK-SNAP's label descriptions, or a colour table of Slicer or FreeSurfer.
///
/// # Errors
/// [`ReadError`], with file, line and reason.
pub fn read_label_table(path: &Path, warnings: &mut Warnings) -> Result<LabelTable, ReadError> {
    let in_path = |kind| ReadError { path: path.to_path_buf(), kind };
    // Not read at all if it is no table by its size.
    if std::fs::metadata(path).is_ok_and(|m| m.len() > LARGEST as u64) {
        return Err(in_path(too_large()));
    }
    label_table_from_bytes(path, &read_bytes(path).map_err(in_path)?, warnings)
}

/// Reads a label table from the bytes of a file; `name` appears in messages.
///
/// # Errors
/// As [`read_label_table`].
pub fn label_table_from_bytes(
    name: &Path,
    bytes: &[u8],
    warnings: &mut Warnings,
) -> Result<LabelTable, ReadError> {
    parse(bytes, warnings).map_err(|kind| ReadError { path: name.to_path_buf(), kind })
}

fn too_large() -> ReadErrorKind {
    ReadErrorKind::TooLarge("is over 16 MiB: no label table".into())
}

/// A line of a colour table, its opacity not yet judged.
struct Row {
    entry: LabelEntry,
    opacity: Option<f64>,
}

fn parse(bytes: &[u8], warnings: &mut Warnings) -> Result<LabelTable, ReadErrorKind> {
    if bytes.len() > LARGEST {
        return Err(too_large());
    }
    let bytes = with_newlines(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let mut rows: Vec<Row> = Vec::new();
    let mut known = HashSet::new();
    for (number, line) in (1..).zip(bytes.split(|&b| b == b'\n')) {
        let line = line.trim_ascii();
        if line.is_empty() || line[0] == b'#' {
            continue;
        }
        let line = String::from_utf8_lossy(line);
        let row = row(&line).map_err(|reason| ReadErrorKind::at_line(number, reason))?;
        if !known.insert(row.entry.value) {
            let place = format!("{} on line {number}", row.entry.value);
            warnings.counted("labels that the table has twice: the first is taken", 1, Some(place));
            continue;
        }
        if rows.len() == MOST {
            return Err(ReadErrorKind::at_line(number, format!("more than {MOST} labels")));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(ReadErrorKind::Refused("is no label table: it has no labels".into()));
    }
    let told = rows.iter().any(|r| r.opacity.is_some_and(|a| a > 0.0));
    let entry = |row: Row| LabelEntry {
        visible: row.entry.visible && !(told && row.opacity == Some(0.0)),
        ..row.entry
    };
    Ok(LabelTable { entries: rows.into_iter().map(entry).collect() })
}

fn row(line: &str) -> Result<Row, String> {
    if let Some((columns, rest)) = line.split_once('"') {
        let Some((name, _)) = rest.rsplit_once('"') else {
            return Err(format!("{} has no closing quotation mark", quote(line.as_bytes())));
        };
        return itk_snap(columns, name);
    }
    color_table(line)
}

fn itk_snap(columns: &str, name: &str) -> Result<Row, String> {
    let columns: Vec<&str> = columns.split_whitespace().collect();
    let [value, r, g, b, opacity, visible, _mesh] = columns[..] else {
        return Err(format!("{} columns before the name; IDX R G B A VIS MSH are expected", columns.len()));
    };
    let color = [level(r)?, level(g)?, level(b)?];
    let opacity: f64 = opacity
        .parse()
        .ok()
        .filter(|a| (0.0..=1.0).contains(a))
        .ok_or_else(|| format!("the opacity {} is not within 0 to 1", quote(opacity.as_bytes())))?;
    let visible = match visible {
        "0" => false,
        "1" => true,
        _ => return Err(format!("the visibility {} is neither 0 nor 1", quote(visible.as_bytes()))),
    };
    let entry = LabelEntry { value: whole(value)?, name: short_name(name), color, visible };
    Ok(Row { entry, opacity: Some(opacity) })
}

fn color_table(line: &str) -> Result<Row, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let numbers = words.iter().skip(1).rev().take(4).take_while(|w| w.parse::<f64>().is_ok()).count();
    // A name there must be, so of `1 2 10 20 30` the second word is one.
    let numbers = numbers.min(words.len().saturating_sub(2));
    if numbers < 3 {
        return Err(format!(
            "{} is no line of a label table (index name r g b a, or IDX R G B A VIS MSH \"LABEL\")",
            quote(line.as_bytes())
        ));
    }
    let (name, levels) = words[1..].split_at(words.len() - 1 - numbers);
    let color = [level(levels[0])?, level(levels[1])?, level(levels[2])?];
    let opacity = levels.get(3).map(|a| level(a).map(f64::from)).transpose()?;
    let entry =
        LabelEntry { value: whole(words[0])?, name: short_name(&name.join(" ")), color, visible: true };
    Ok(Row { entry, opacity })
}

fn whole(text: &str) -> Result<i64, String> {
    text.parse().map_err(|_| format!("the label {} is not a whole number", quote(text.as_bytes())))
}

fn level(text: &str) -> Result<u8, String> {
    text.parse().map_err(|_| format!("the colour {} is not within 0 to 255", quote(text.as_bytes())))
}

/// A name on one line, not longer than names are.
pub(super) fn short_name(name: &str) -> String {
    one_line(&name.trim().chars().take(LONGEST).collect::<String>())
}
