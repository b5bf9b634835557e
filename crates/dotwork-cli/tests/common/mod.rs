//! Runs the real command in fresh folders.

#![allow(dead_code, reason = "each test file uses its part")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder that goes when the test ends, and the command run in it.
pub struct Place(tempfile::TempDir);

impl Place {
    pub fn new() -> Place {
        Place(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    /// Everything in the folder, hidden files too.
    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = std::fs::read_dir(self.0.path())
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    /// The command, in this folder.
    pub fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_dotwork"));
        command.current_dir(self.0.path());
        command
    }

    /// Runs the command with words parted by spaces.
    pub fn run(&self, line: &str) -> Done {
        Done::of(self.command().args(line.split_whitespace()).output().unwrap(), line)
    }

    /// Draws with a stock that may be too small for the picture: the warning about it is not what is tested.
    #[track_caller]
    pub fn draw(&self, line: &str) {
        self.run(&format!("render {line} --quiet")).ok();
    }

    /// Runs the command from a shell after `first`.
    pub fn run_after(&self, first: &str, line: &str) -> Done {
        let shell = format!("{first}; exec \"$0\" {line}");
        let mut command = Command::new("sh");
        command.current_dir(self.0.path()).args(["-c", &shell, env!("CARGO_BIN_EXE_dotwork")]);
        Done::of(command.output().unwrap(), line)
    }
}

/// How a run ended.
pub struct Done {
    line: String,
    code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Done {
    pub fn of(output: Output, line: &str) -> Done {
        Done {
            line: line.into(),
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// It succeeded and had nothing to say on standard error.
    #[track_caller]
    pub fn ok(self) -> Done {
        assert!(
            self.code == Some(0) && self.stderr.is_empty(),
            "{}: {:?} {}",
            self.line,
            self.code,
            self.stderr
        );
        self
    }

    /// It succeeded with one warning that holds all parts.
    #[track_caller]
    pub fn warned(self, parts: &[&str]) -> Done {
        assert_eq!(self.code, Some(0), "{}: {}", self.line, self.stderr);
        self.one_line("dotwork: warning: ", parts);
        self
    }

    /// It failed with this exit code and one line on standard error that holds all parts.
    #[track_caller]
    pub fn failed(self, code: i32, parts: &[&str]) -> Done {
        assert_eq!(self.code, Some(code), "{}: {}", self.line, self.stderr);
        assert_eq!(self.stdout, "", "{}", self.line);
        self.one_line("dotwork: ", parts);
        self
    }

    #[track_caller]
    fn one_line(&self, start: &str, parts: &[&str]) {
        let lines: Vec<_> = self.stderr.lines().collect();
        assert!(lines.len() == 1 && lines[0].starts_with(start), "{}: {}", self.line, self.stderr);
        for part in parts {
            assert!(lines[0].contains(part), "{}: '{part}' is not in: {}", self.line, self.stderr);
        }
    }

    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{}: {e}: {}", self.line, self.stdout))
    }
}

/// A box with corners at `low` and `high`, as an OBJ file.
pub fn box_obj(low: [f32; 3], high: [f32; 3]) -> String {
    let mut text = String::new();
    for i in 0..8 {
        let [x, y, z] = [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
        text += &format!("v {x} {y} {z}\n");
    }
    text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

/// A PLY file with a triangle for each three of the given vertices.
pub fn ply(vertices: &[[f64; 3]], indices: &[[i64; 3]]) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        indices.len()
    );
    for [x, y, z] in vertices {
        text += &format!("{x} {y} {z}\n");
    }
    for [a, b, c] in indices {
        text += &format!("3 {a} {b} {c}\n");
    }
    text
}

/// A table read back.
pub struct Table {
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub fn read(text: &str) -> Table {
        let mut lines = text.lines().map(|l| l.split(',').map(str::to_string).collect::<Vec<_>>());
        let columns = lines.next().unwrap();
        let rows: Vec<_> = lines.collect();
        assert!(rows.iter().all(|r| r.len() == columns.len()));
        Table { columns, rows }
    }

    fn index(&self, name: &str) -> usize {
        self.columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("no column {name}"))
    }

    pub fn words(&self, name: &str) -> Vec<&str> {
        let k = self.index(name);
        self.rows.iter().map(|r| r[k].as_str()).collect()
    }

    pub fn numbers(&self, name: &str) -> Vec<f64> {
        self.words(name).iter().map(|w| w.parse().unwrap_or_else(|e| panic!("{name}: '{w}': {e}"))).collect()
    }

    pub fn mean(&self, name: &str) -> f64 {
        let v = self.numbers(name);
        v.iter().sum::<f64>() / v.len() as f64
    }
}

/// The shared test data.
pub fn data() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data"))
}
