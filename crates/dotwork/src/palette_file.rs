//! Palette files: colours for the style key `palette`, kept beside a style or a scene.
//!
//! Two forms are read, told apart by the first line:
//!
//! * a GIMP palette (`.gpl`): the line `GIMP Palette`, then `Name:` and `Columns:`, comments that begin with `#`, and
//!   lines of three numbers 0…255 that may end in a name;
//! * plain text: one `#rrggbb` a line, which may end in a name; empty lines, and comments that begin with `//`, `;` or
//!   `# ` (with a space), are skipped.
//!
//! A style holds the colours and not the file: plates and `.dots` files then need no other file to be drawn again.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use dotwork_drawing::{Color, Palette};
use dotwork_ink::Style;
use thiserror::Error;

/// Most bytes of a palette file; 64 colours with long names need a few thousand.
const LIMIT: u64 = 1 << 20;

/// Why a palette file cannot be used.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{}{}: {reason}", path.display(), line.map_or(String::new(), |line| format!(", line {line}")))]
pub struct PaletteError {
    /// The file.
    pub path: PathBuf,
    /// The line, counted from 1, where one is to blame.
    pub line: Option<usize>,
    /// What is wrong.
    pub reason: String,
}

/// A value of the style key `palette` as [`Style::set`] reads it: the name of a file (with a dot or a folder in it),
/// looked for from `base_folder`, becomes the list of its colours; all else stays what it is.
///
/// # Errors
/// [`PaletteError`] if the file cannot be read, is no palette, or has not 2 to 64 colours.
pub fn resolve_palette(base_folder: &Path, text: &str) -> Result<String, PaletteError> {
    let name = text.trim();
    let is_file = name.contains(['.', '/', '\\']) && Style::default().set("palette", name).is_err();
    if !is_file {
        return Ok(text.to_string());
    }
    let path = base_folder.join(name);
    let error = |line, reason| PaletteError { path: path.clone(), line, reason };
    let bytes = read(&path).map_err(|reason| error(None, reason))?;
    let colors = parse(&bytes).map_err(|(line, reason)| error(Some(line), reason))?;
    Palette::new(colors).map(|palette| palette.to_string()).map_err(|reason| error(None, reason))
}

fn read(path: &Path) -> Result<Vec<u8>, String> {
    let said = |e: std::io::Error| match e.kind() {
        std::io::ErrorKind::NotFound => "there is no such palette file".to_string(),
        _ => e.to_string(),
    };
    // A pipe or device would block or never end.
    if !std::fs::metadata(path).map_err(said)?.is_file() {
        return Err("is no regular file".into());
    }
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(LIMIT + 1).read_to_end(&mut bytes)).map_err(said)?;
    if bytes.len() as u64 > LIMIT {
        return Err(format!("is larger than {} KiB: no palette", LIMIT >> 10));
    }
    Ok(bytes)
}

/// The colours, or the line and the reason of the first error.
fn parse(bytes: &[u8]) -> Result<Vec<Color>, (usize, String)> {
    // Names may be in any encoding; what is read is ASCII.
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let gimp = text.lines().next().is_some_and(|line| line.trim() == "GIMP Palette");
    let mut colors = Vec::new();
    for (k, line) in text.lines().enumerate().skip(usize::from(gimp)) {
        let line = line.trim();
        let color = if gimp { gimp_color(line) } else { plain_color(line) };
        let Some(color) = color.map_err(|reason| (k + 1, reason))? else { continue };
        if colors.len() == Palette::MOST {
            return Err((k + 1, format!("has more than {} colours", Palette::MOST)));
        }
        colors.push(color);
    }
    Ok(colors)
}

/// The colour of a line of a GIMP palette; `None` if it has none.
fn gimp_color(line: &str) -> Result<Option<Color>, String> {
    let words = ["#", "Name:", "Columns:", "Channels:"];
    if line.is_empty() || words.iter().any(|word| line.starts_with(word)) {
        return Ok(None);
    }
    let mut numbers = line.split_whitespace().map(str::parse::<u8>);
    match [numbers.next(), numbers.next(), numbers.next()] {
        [Some(Ok(r)), Some(Ok(g)), Some(Ok(b))] => Ok(Some(Color { r, g, b })),
        _ => Err(format!("three numbers from 0 to 255 are expected, not '{}'", start(line))),
    }
}

/// The colour of a line of plain text; `None` if it has none.
fn plain_color(line: &str) -> Result<Option<Color>, String> {
    let comment = line == "#" || ["//", ";", "# ", "#\t"].iter().any(|word| line.starts_with(word));
    if comment || line.is_empty() {
        return Ok(None);
    }
    let word = line.split_whitespace().next().unwrap_or_default();
    let color = word.strip_prefix('#').and_then(|_| word.parse().ok());
    let expected = || format!("a colour as #rrggbb is expected, not '{}'", start(line));
    color.map(Some).ok_or_else(expected)
}

/// The beginning of a line, fit for a message.
fn start(line: &str) -> String {
    line.chars().take(32).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolve(name: &str, bytes: &[u8]) -> Result<String, PaletteError> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), bytes).unwrap();
        resolve_palette(folder.path(), name)
    }

    #[test]
    fn both_forms_give_their_colours() {
        let gimp = b"GIMP Palette\r\nName: Bears \xe9\r\nColumns: 3\r\n#\r\n  8   8   8\tgrey3\r\n255 128  0 orange 2\r\n";
        assert_eq!(resolve("bears.gpl", gimp).unwrap(), "#080808,#ff8000");
        let text =
            "\u{feff}# sea, from deep to shallow\n; old\n// new\n\n#0b1f4b deep blue\n  #8fd0b0\n#fff\n#\n";
        assert_eq!(resolve("sea.txt", text.as_bytes()).unwrap(), "#0b1f4b,#8fd0b0,#ffffff");
    }

    #[test]
    fn what_names_no_file_stays() {
        for text in ["none", " ocean", "#102030,#405060", "oceann", "#10203", "", "1,2"] {
            assert_eq!(resolve_palette(Path::new("/nowhere"), text).unwrap(), text);
        }
    }

    #[test]
    fn what_a_file_gives_is_read_by_the_style() {
        let many: String = (0..64).map(|k| format!("#{k:02x}{k:02x}ff\n")).collect();
        let list = resolve("p.txt", many.as_bytes()).unwrap();
        let mut style = Style::default();
        style.set("palette", &list).unwrap();
        assert_eq!(dotwork_ink::find_param("palette").unwrap().get(&style), list);
    }

    #[test]
    fn errors_name_file_line_and_reason() {
        let many = "#000000\n".repeat(65);
        let large = vec![b'\n'; LIMIT as usize + 1];
        let long = [b"#000000\n".as_slice(), &vec![b'x'; 1 << 19]].concat();
        let cases: [(&str, &[u8], Option<usize>, &str); 12] = [
            ("a.gpl", b"GIMP Palette\n#\n1 2 3\n4 5 256\n", Some(4), "'4 5 256'"),
            ("a.gpl", b"GIMP Palette\n1 2\n", Some(2), "three numbers"),
            ("a.gpl", b"GIMP Palette\n-1 2 3\n", Some(2), "three numbers"),
            ("a.gpl", b"GIMP Palette\n", None, "not 0"),
            ("a.gpl", b"1 2 3\n4 5 6\n", Some(1), "#rrggbb"),
            ("a.txt", b"#102030\n#40506\n", Some(2), "'#40506'"),
            ("a.txt", b"#102030\n", None, "not 1"),
            ("a.txt", b"", None, "not 0"),
            ("a.txt", b"\0\xff\x1b[2J", Some(1), "#rrggbb"),
            ("a.txt", many.as_bytes(), Some(65), "more than 64"),
            ("a.txt", &large, None, "larger than 1024 KiB"),
            ("a.txt", &long, Some(2), "xxx"),
        ];
        for (name, bytes, line, part) in cases {
            let error = resolve(name, bytes).unwrap_err();
            let said = error.to_string();
            assert!(error.line == line && said.contains(name) && said.contains(part), "{said}");
            assert!(line.is_none_or(|line| said.contains(&format!("{name}, line {line}: "))), "{said}");
            assert!(error.reason.len() < 120 && !said.contains(char::is_control), "{said}");
        }
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("d.gpl")).unwrap();
        for (name, part) in [("missing.gpl", "no such palette file"), ("d.gpl", "no regular file")] {
            let error = resolve_palette(folder.path(), name).unwrap_err();
            assert!(error.to_string().contains(part) && error.line.is_none(), "{error}");
        }
    }
}
