//! Style files: the parameter table as TOML.
//!
//! ```toml
//! description = "Bone on cream paper"
//! extends = "hard"        # a preset; without it, the default style
//! dot_size = "0.25mm"
//! gamma = 1.7
//! paper = "#f7f0e1"
//! ```
//!
//! The keys are those of `dotwork styles --keys`, flat, without tables. Every error names the file and the line.

use std::path::Path;

use dotwork_ink::{PRESETS, Style, preset};
use toml::de::{DeTable, DeValue};

use crate::files::FileError;
use crate::palette_file::resolve_palette;

/// A style read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct StyleFile {
    /// The style.
    pub style: Style,
    /// What the file says about it; empty if nothing.
    pub description: String,
}

/// Reads a style file.
///
/// # Errors
/// [`FileError::Read`] if it cannot be read, [`FileError::Style`] with the line if it cannot be understood.
pub fn read_style(path: impl AsRef<Path>) -> Result<StyleFile, FileError> {
    let path = path.as_ref();
    let bytes = dotwork_io::read_file(path)?;
    parse(&bytes, path.parent().unwrap_or(Path::new(""))).map_err(|(at, reason)| {
        let line = bytes[..at.min(bytes.len())].iter().filter(|&&b| b == b'\n').count() + 1;
        FileError::Style { path: path.to_path_buf(), line, reason }
    })
}

/// The style, or the byte and the reason of the first error. Files that it names are looked for from `folder`.
fn parse(bytes: &[u8], folder: &Path) -> Result<StyleFile, (usize, String)> {
    let text = std::str::from_utf8(bytes).map_err(|e| (e.valid_up_to(), "is not UTF-8".to_string()))?;
    let table = DeTable::parse(text).map_err(|e| {
        let reason = e.message().split('\n').collect::<Vec<_>>().join("; ");
        (e.span().map_or(0, |s| s.start), reason)
    })?;
    let mut entries: Vec<_> = table.get_ref().iter().collect();
    // In the order of the file, except that what it extends comes first.
    entries.sort_by_key(|(key, _)| (key.get_ref() != "extends", key.span().start));
    let mut file = StyleFile { style: Style::default(), description: String::new() };
    for (key, value) in entries {
        let name: &str = key.get_ref();
        let at_value = |reason| (value.span().start, reason);
        match name {
            "extends" => {
                let base = text_of(value.get_ref()).and_then(|name| {
                    preset(&name).ok_or_else(|| {
                        format!("there is no preset '{name}'; the presets are {}", preset_names())
                    })
                });
                file.style = base.map_err(|e| at_value(format!("extends: {e}")))?;
            }
            "description" => {
                file.description =
                    text_of(value.get_ref()).map_err(|e| at_value(format!("description: {e}")))?;
            }
            _ => {
                dotwork_ink::find_param(name).map_err(|e| (key.span().start, e))?;
                let text = text_of(value.get_ref()).map_err(|e| at_value(format!("{name}: {e}")))?;
                let text = with_palette(folder, name, text).map_err(at_value)?;
                file.style.set(name, &text).map_err(at_value)?;
            }
        }
    }
    Ok(file)
}

/// The value of a style key, with the colours of a palette file in the place of its name.
pub(crate) fn with_palette(folder: &Path, key: &str, text: String) -> Result<String, String> {
    match key {
        "palette" => resolve_palette(folder, &text).map_err(|e| format!("palette: {e}")),
        _ => Ok(text),
    }
}

/// A plain value as the text that [`Style::set`] reads.
pub(crate) fn text_of(value: &DeValue) -> Result<String, String> {
    match value {
        DeValue::String(s) => Ok(s.to_string()),
        DeValue::Boolean(b) => Ok(b.to_string()),
        DeValue::Float(f) => Ok(f.as_str().to_string()),
        DeValue::Integer(i) => i64::from_str_radix(i.as_str(), i.radix())
            .map(|i| i.to_string())
            .map_err(|_| format!("{i} is too large")),
        other => Err(format!("takes a number, true or false, or a string, not {}", kind(other))),
    }
}

fn kind(value: &DeValue) -> &'static str {
    match value {
        DeValue::Table(_) => "a table",
        DeValue::Array(_) => "an array",
        _ => "a date",
    }
}

/// The names of all presets, for messages.
pub(crate) fn preset_names() -> String {
    PRESETS.iter().map(|p| p.name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line_of(text: &str) -> (usize, String) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        std::fs::write(&path, text).unwrap();
        match read_style(&path).unwrap_err() {
            FileError::Style { line, reason, .. } => (line, reason),
            other => panic!("{other}"),
        }
    }

    #[test]
    fn keys_lie_over_what_is_extended_wherever_that_stands() {
        let file = parse(b"gamma = 2\ntone = 0.25\nsolid = true\ncolor = '#102030'\nextends = 'night'\ndescription = 'd'\n", Path::new("")).unwrap();
        let mut expected = preset("night").unwrap();
        for pair in ["gamma=2", "tone=0.25", "solid=true", "color=#102030"] {
            expected.set_pair(pair).unwrap();
        }
        assert_eq!(file, StyleFile { style: expected, description: "d".into() });
    }

    #[test]
    fn palettes_are_looked_for_beside_the_style() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("colours")).unwrap();
        std::fs::write(folder.path().join("colours/sea.gpl"), "GIMP Palette\n1 2 3\n9 8 256\n").unwrap();
        let path = folder.path().join("s.toml");
        std::fs::write(&path, "coloring = 'light'\npalette = 'colours/sea.gpl'\n").unwrap();
        let said = read_style(&path).unwrap_err().to_string();
        assert!(said.contains("s.toml") && said.contains("sea.gpl, line 3: three numbers"), "{said}");
        std::fs::write(folder.path().join("colours/sea.gpl"), "GIMP Palette\n1 2 3\n9 8 255\n").unwrap();
        let mut expected = Style::default();
        expected.set_pair("coloring=light").unwrap();
        expected.set_pair("palette=#010203,#0908ff").unwrap();
        assert_eq!(read_style(&path).unwrap().style, expected);
        let (line, reason) = line_of("tone = 0.5\npalette = 'missing.gpl'\n");
        assert!(line == 2 && reason.contains("missing.gpl: there is no such palette file"), "{reason}");
    }

    #[test]
    fn texts_with_line_breaks_make_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        // Found by fuzzing.
        std::fs::write(&path, "extends = \"a\\nb\"\n").unwrap();
        let message = read_style(&path).unwrap_err().to_string();
        assert!(message.contains(r"there is no preset 'a\nb'") && !message.contains('\n'), "{message}");
    }

    #[test]
    fn errors_name_the_line() {
        for (text, line, part) in [
            ("tone = 0.5\n\ngama = 2\n", 3, "did you mean 'gamma'?"),
            ("# first\ntone = 2\n", 2, "0 to 1"),
            ("tone = 0.5\nextends = \"nihgt\"\n", 2, "the presets are soft, "),
            ("tone = \n", 1, ""),
            ("tone = 0.5\ntone = 0.6\n", 2, "duplicate"),
            ("\n[dots]\nfade = 'size'\n", 2, "dots"),
            ("gamma = [1]\n", 1, "not an array"),
            ("tone = 1\ngamma = nan\n", 2, "gamma"),
            ("tone = 1979-05-27\n", 1, "not a date"),
        ] {
            let (at, reason) = line_of(text);
            assert!(
                at == line && reason.contains(part) && !reason.contains('\n'),
                "{text:?}: {at}: {reason}"
            );
        }
    }
}
