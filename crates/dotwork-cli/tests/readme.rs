//! The documentation is true: its commands run, print what stands below them and draw the pictures beside them.
//!
//! README.md and docs/*.md are read as written. In each of them, from top to bottom and in one fresh folder:
//!
//! * a `sh` block is run line by line, `cargo run --release -- …` as `dotwork …`; nothing may appear on standard error;
//! * a `toml` block whose first line is `# NAME.toml` is written to that file;
//! * a `text` or `csv` block is what the `sh` block before it printed, or the beginning of the file that it wrote;
//! * every picture of docs/images shown in the document has been drawn by its commands.
//!
//! After a change that is meant to show, `DOTWORK_ACCEPT=1 cargo test -p dotwork-cli --test readme` takes the new
//! output and the new pictures into the documents. Look at them before you commit them.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use common::Place;
use dotwork::ink::PRESETS;

/// Share of the pixels that may differ from a stored picture: powers and sines round differently on other processors,
/// and a dot at its threshold may then come or go.
const DIFFERING_PIXELS: f64 = 0.001;

/// Lines of `sh` blocks that are not run here: they build, and the first of them runs this very test.
const NOT_RUN: [&str; 2] = ["cargo test ", "cargo install "];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn accepting() -> bool {
    std::env::var_os("DOTWORK_ACCEPT").is_some_and(|v| v == "1")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// All documents, the README first.
fn documents() -> Vec<PathBuf> {
    let mut pages: Vec<_> = fs::read_dir(root().join("docs"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "md"))
        .collect();
    pages.sort();
    pages.insert(0, root().join("README.md"));
    pages
}

/// A fenced block of a document.
struct Block {
    language: String,
    lines: Vec<String>,
    /// Number of its first line inside the fence, from 0.
    start: usize,
}

fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (number, line) in text.lines().enumerate() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(language), None) => {
                open = Some(Block { language: language.trim().into(), lines: Vec::new(), start: number + 1 });
            }
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (None, Some(block)) => block.lines.push(line.into()),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a fence is left open");
    blocks
}

/// Runs a line as a shell would, with `dotwork` on its path, and gives back what it printed.
fn run(place: &Place, line: &str) -> String {
    let line = line.replace("cargo run --release -- ", "dotwork ");
    assert!(line.starts_with("dotwork "), "'{line}': a kind of command that the documents do not have");
    let bin = Path::new(env!("CARGO_BIN_EXE_dotwork")).parent().unwrap();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path =
        std::env::join_paths([bin.to_path_buf()].into_iter().chain(std::env::split_paths(&path))).unwrap();
    let output = Command::new("sh")
        .args(["-c", &line])
        .current_dir(place.path(""))
        .env("PATH", path)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.is_empty(), "'{line}': {:?} {said}", output.status.code());
    String::from_utf8(output.stdout).unwrap()
}

/// The file after `-o` in a command.
fn output_of(line: &str) -> Option<&str> {
    line.split_whitespace().skip_while(|w| *w != "-o").nth(1)
}

/// Runs a document in a fresh folder and holds what it shows against what happens.
fn check(document: &Path) {
    let name = document.file_name().unwrap().to_string_lossy().into_owned();
    let text = read(document);
    let mut lines: Vec<String> = text.lines().map(Into::into).collect();
    let place = Place::new();
    let (mut printed, mut written) = (String::new(), None);
    let mut wrong = Vec::new();
    // Lines of a block replaced, from the last to the first, so that line numbers hold.
    let mut replaced: Vec<(usize, usize, Vec<String>)> = Vec::new();
    for block in blocks(&text) {
        match block.language.as_str() {
            "sh" => {
                printed.clear();
                let commands = block.lines.iter().map(|l| l.split(" #").next().unwrap_or(l).trim_end());
                for line in commands.filter(|l| !l.is_empty() && !NOT_RUN.iter().any(|n| l.starts_with(n))) {
                    printed += &run(&place, line);
                    written = output_of(line).map(|o| place.path(o));
                }
            }
            "toml" => {
                if let Some(file) = block.lines.first().and_then(|l| l.strip_prefix("# ")) {
                    place.write(file, block.lines.join("\n") + "\n");
                }
            }
            "text" | "csv" => {
                let now: Vec<String> = match (&written, printed.is_empty()) {
                    (_, false) => printed.lines().map(|l| l.trim_end().into()).collect(),
                    (Some(file), true) => {
                        read(file).lines().take(block.lines.len()).map(Into::into).collect()
                    }
                    (None, true) => panic!("{name}:{}: nothing was printed or written", block.start),
                };
                if !same_text(&block.lines, &now) {
                    wrong.push(format!("{name}:{}: should now read\n{}", block.start + 1, now.join("\n")));
                    replaced.push((block.start, block.lines.len(), now));
                }
            }
            // Drawings and Rust; the latter is looked at below.
            _ => {}
        }
    }
    for picture in pictures(&text) {
        let new = place.path(&picture);
        assert!(new.is_file(), "{name} shows {picture}, but none of its commands draws it");
        let stored = root().join("docs/images").join(&picture);
        if let Err(difference) = compare(&stored, &new) {
            if accepting() {
                fs::copy(&new, &stored).unwrap();
            } else {
                let beside = Path::new(env!("CARGO_TARGET_TMPDIR")).join(&picture);
                fs::copy(&new, &beside).unwrap();
                wrong.push(format!("{picture} {difference}; the new picture is {}", beside.display()));
            }
        }
    }
    if accepting() {
        for (start, count, now) in replaced.into_iter().rev() {
            lines.splice(start..start + count, now);
        }
        let new = lines.join("\n") + "\n";
        if new != text {
            fs::write(document, new).unwrap();
        }
        return;
    }
    assert!(
        wrong.is_empty(),
        "{}\n\nIf this is meant, look at it and accept it with\n  \
         DOTWORK_ACCEPT=1 cargo test -p dotwork-cli --test readme",
        wrong.join("\n")
    );
}

/// True if the lines agree, numbers to a thousandth: the last digits are the processor's.
fn same_text(shown: &[String], now: &[String]) -> bool {
    let words = |s: &str| s.split([' ', ',']).map(str::to_string).collect::<Vec<_>>();
    let same_word = |a: &str, b: &str| match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 1e-3 * a.abs().max(1e-3),
        _ => a == b,
    };
    let same_line = |a: &str, b: &str| {
        let (a, b) = (words(a), words(b));
        a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| same_word(a, b))
    };
    shown.len() == now.len() && shown.iter().zip(now).all(|(a, b)| same_line(a, b))
}

/// The pictures and films of docs/images that a document shows.
fn pictures(text: &str) -> Vec<String> {
    let named = |ending: &'static str| {
        let parts = text.split("images/").skip(1);
        parts.filter_map(move |rest| Some(format!("{}{ending}", &rest[..rest.find(ending)?])))
    };
    let mut found: Vec<String> = named(".png")
        .chain(named(".gif"))
        .filter(|name| name.bytes().all(|b| b.is_ascii_alphanumeric() || b"-.".contains(&b)))
        .collect();
    found.sort();
    found.dedup();
    found
}

/// A picture's size, colour type and samples.
struct Picture(u32, u32, png::ColorType, Vec<u8>);

impl Picture {
    fn read(path: &Path) -> Option<Picture> {
        let file = std::io::BufReader::new(fs::File::open(path).ok()?);
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut samples).unwrap();
        samples.truncate(info.buffer_size());
        Some(Picture(info.width, info.height, info.color_type, samples))
    }

    /// The share of pixels that differ; all of them if the pictures are of different kinds.
    fn differing(&self, other: &Picture) -> f64 {
        if (self.0, self.1, self.2) != (other.0, other.1, other.2) {
            return 1.0;
        }
        let channels = self.2.samples();
        let pairs = self.3.chunks(channels).zip(other.3.chunks(channels));
        pairs.filter(|(a, b)| a != b).count() as f64 / (f64::from(self.0) * f64::from(self.1))
    }
}

fn compare(stored: &Path, new: &Path) -> Result<(), String> {
    if new.extension().is_some_and(|e| e == "gif") {
        // Frames are those that the films of the figures are measured on: here it is enough that it is this film.
        let [old, new] = [stored, new].map(|path| fs::read(path).unwrap_or_default());
        let alike = old.get(..10) == new.get(..10) && old.len().abs_diff(new.len()) <= new.len() / 20;
        return if alike { Ok(()) } else { Err("is another film".into()) };
    }
    let Some(stored) = Picture::read(stored) else { return Err("is missing".into()) };
    let share = stored.differing(&Picture::read(new).unwrap());
    if share > DIFFERING_PIXELS {
        Err(format!("differs in {:.2} % of its pixels", 100.0 * share))
    } else {
        Ok(())
    }
}

#[test]
#[cfg_attr(not(unix), ignore = "the documents' commands are written for a Unix shell")]
fn the_readme_is_true() {
    check(&documents()[0]);
}

#[test]
#[cfg_attr(not(unix), ignore = "the documents' commands are written for a Unix shell")]
fn the_documents_are_true() {
    documents()[1..].iter().for_each(|d| check(d));
}

#[test]
fn the_readme_begins_with_one_command_that_draws_and_one_that_tests() {
    let text = read(&root().join("README.md"));
    let first = blocks(&text).into_iter().find(|b| b.language == "sh").unwrap();
    assert_eq!(
        first.lines,
        ["cargo run --release -- render demo:teapot -o teapot.png", "cargo test --workspace"],
        ".ci/run takes the two commands from here"
    );
}

/// The facade's documentation runs the example; the README shows its lines.
#[test]
fn the_readme_shows_the_facades_example() {
    let code = |line: &str| line.trim().trim_start_matches("# ").to_string();
    let facade = read(&root().join("crates/dotwork/src/lib.rs"));
    let facade: Vec<String> = facade.lines().filter_map(|l| l.strip_prefix("//!")).map(code).collect();
    let text = read(&root().join("README.md"));
    let example = blocks(&text).into_iter().find(|b| b.language == "rust").unwrap();
    for line in example.lines.iter().filter(|l| !l.trim().is_empty()) {
        assert!(facade.contains(&code(line)), "the facade's documentation does not have: {line}");
    }
}

#[test]
fn every_style_is_described() {
    let text = read(&root().join("docs/styles.md"));
    for preset in PRESETS {
        assert!(text.contains(&format!("### `{}`", preset.name)), "docs/styles.md lacks {}", preset.name);
    }
}

#[test]
fn every_link_and_every_picture_has_its_place() {
    let mut shown = Vec::new();
    for document in documents() {
        let text = read(&document);
        shown.extend(pictures(&text));
        for target in text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next()) {
            let outside = target.is_empty() || target.starts_with("http");
            assert!(
                outside || document.parent().unwrap().join(target).exists(),
                "{}: {target} is not there",
                document.display()
            );
        }
    }
    for entry in fs::read_dir(root().join("docs/images")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(shown.contains(&name), "docs/images/{name} is shown nowhere");
    }
}

/// The comparisons notice what they are there for.
#[test]
fn a_difference_is_noticed() {
    let picture = |grey: u8| Picture(100, 100, png::ColorType::Grayscale, vec![grey; 10_000]);
    let mut other = picture(255);
    assert_eq!(picture(255).differing(&other), 0.0);
    other.3[..11].fill(0);
    assert!(picture(255).differing(&other) > DIFFERING_PIXELS);
    assert_eq!(picture(0).differing(&Picture(50, 200, png::ColorType::Grayscale, vec![0; 10_000])), 1.0);
    let lines = |s: &str| vec![s.to_string()];
    assert!(same_text(&lines("x,1.0000,a"), &lines("x,1.0001,a")));
    assert!(!same_text(&lines("x,1.00,a"), &lines("x,1.01,a")));
    assert!(!same_text(&lines("x,1,a"), &lines("x,1,b")));
    assert!(!same_text(&lines("x"), &[]));
}
