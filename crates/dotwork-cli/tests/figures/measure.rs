//! What the figures are measured with.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use dotwork::mesh::RawMesh;

/// A folder that goes away with the test.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a mesh as OBJ, whose numbers read back exactly.
    pub fn mesh(&self, name: &str, mesh: &RawMesh) -> PathBuf {
        let mut text = String::new();
        for [x, y, z] in &mesh.positions {
            text += &format!("v {x} {y} {z}\n");
        }
        for t in &mesh.triangles {
            text += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
        }
        let path = self.path(name);
        fs::write(&path, text).unwrap();
        path
    }
}

pub fn dotwork(arguments: &str, input: &Path, output: &Path) {
    run("render", arguments, input, output);
}

/// Draws a film.
pub fn animate(arguments: &str, input: &Path, output: &Path) {
    run("animate", arguments, input, output);
}

fn run(command: &str, arguments: &str, input: &Path, output: &Path) {
    let run = Command::new(env!("CARGO_BIN_EXE_dotwork"))
        .arg(command)
        .arg(input)
        .arg("-o")
        .arg(output)
        .args(arguments.split_whitespace())
        .output()
        .unwrap();
    assert!(run.status.success(), "dotwork {arguments}: {}", String::from_utf8_lossy(&run.stderr));
}

/// A picture as ink: 1 − linear luminance.
pub struct Ink {
    pub width: usize,
    pub ink: Vec<f64>,
}

impl Ink {
    pub fn read(path: &Path) -> Ink {
        let mut reader =
            png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap())).read_info().unwrap();
        let mut samples = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut samples).unwrap();
        assert_eq!(info.color_type, png::ColorType::Grayscale);
        let linear = |c: u8| 1.0 - f64::from(dotwork::drawing::color::srgb_to_linear(c));
        Ink { width: info.width as usize, ink: samples.iter().map(|&c| linear(c)).collect() }
    }

    /// Mean ink of the pixels that `inside` names, by their centres.
    pub fn mean(&self, inside: impl Fn(f64, f64) -> bool) -> f64 {
        let (mut sum, mut n) = (0.0, 0usize);
        for (i, v) in self.ink.iter().enumerate() {
            if inside((i % self.width) as f64 + 0.5, (i / self.width) as f64 + 0.5) {
                sum += v;
                n += 1;
            }
        }
        assert!(n > 1000, "only {n} pixels measured");
        sum / n as f64
    }
}

/// A drawing table: for each row the columns by name.
pub struct Table {
    pub columns: HashMap<String, usize>,
    pub rows: Vec<Vec<f64>>,
}

impl Table {
    pub fn read(path: &Path) -> Table {
        let text = fs::read_to_string(path).unwrap();
        let mut lines = text.lines();
        let columns = lines.next().unwrap().split(',').enumerate().map(|(i, c)| (c.to_string(), i)).collect();
        // The only word, the object's name, reads as NaN.
        let rows = lines.map(|l| l.split(',').map(|v| v.parse().unwrap_or(f64::NAN)).collect()).collect();
        Table { columns, rows }
    }

    pub fn column(&self, name: &str) -> Vec<f64> {
        let c = self.columns[name];
        self.rows.iter().map(|r| r[c]).collect()
    }
}

/// Root mean square and the value farthest from zero.
pub fn rms_and_worst(errors: &[f64]) -> (f64, f64) {
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    (rms, errors.iter().fold(0.0, |w: f64, &e| if e.abs() > w.abs() { e } else { w }))
}

/// Distance of each point to its nearest neighbour.
pub fn nearest(points: &[[f64; 2]], spacing: f64) -> Vec<f64> {
    let cell = |p: &[f64; 2]| [(p[0] / spacing).floor() as i64, (p[1] / spacing).floor() as i64];
    let mut grid: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    for (i, p) in points.iter().enumerate() {
        grid.entry(cell(p)).or_default().push(i);
    }
    let distance = |i: usize, j: usize| (points[i][0] - points[j][0]).hypot(points[i][1] - points[j][1]);
    points
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let [cx, cy] = cell(p);
            (-2..=2)
                .flat_map(|dx| (-2..=2).map(move |dy| [cx + dx, cy + dy]))
                .filter_map(|c| grid.get(&c))
                .flatten()
                .filter(|&&j| j != i)
                .map(|&j| distance(i, j))
                .fold(f64::MAX, f64::min)
        })
        .collect()
}

/// Minimum and mean nearest-neighbour distance over the hexagonal spacing, for the points inside a rectangle.
pub fn evenness(points: &[[f64; 2]], low: [f64; 2], high: [f64; 2]) -> (usize, f64, f64) {
    let inside = |p: &[f64; 2]| (0..2).all(|k| p[k] >= low[k] && p[k] <= high[k]);
    let n = points.iter().filter(|p| inside(p)).count();
    let density = n as f64 / ((high[0] - low[0]) * (high[1] - low[1]));
    let hexagonal = (2.0 / (3f64.sqrt() * density)).sqrt();
    let distances: Vec<f64> = nearest(points, hexagonal)
        .into_iter()
        .zip(points)
        .filter(|(_, p)| inside(p))
        .map(|(d, _)| d)
        .collect();
    let min = distances.iter().copied().fold(f64::MAX, f64::min);
    (n, min / hexagonal, distances.iter().sum::<f64>() / n as f64 / hexagonal)
}

/// One frame's dots: id to size and place on the page.
pub type FrameDots = HashMap<u64, (f64, [f64; 2])>;

pub fn frame_dots(path: &Path) -> FrameDots {
    let t = Table::read(path);
    let (ids, sizes, x, y) = (t.column("id"), t.column("size"), t.column("x_px"), t.column("y_px"));
    (0..ids.len()).map(|i| (ids[i] as u64, (sizes[i], [x[i], y[i]]))).collect()
}

/// All frames of a table of several.
pub fn all_frame_dots(path: &Path) -> Vec<FrameDots> {
    let t = Table::read(path);
    let [frame, id, size, x, y] = ["frame", "id", "size", "x_px", "y_px"].map(|name| t.columns[name]);
    let mut frames: Vec<FrameDots> = Vec::new();
    for row in &t.rows {
        let n = row[frame] as usize;
        frames.resize_with(frames.len().max(n + 1), FrameDots::new);
        frames[n].insert(row[id] as u64, (row[size], [row[x], row[y]]));
    }
    frames
}

/// Share of dots that are there in one frame at more than 30 % of full size and not at all in the next, or the other
/// way round.
pub fn popping(a: &FrameDots, b: &FrameDots) -> f64 {
    let gone =
        |a: &FrameDots, b: &FrameDots| a.iter().filter(|(id, d)| d.0 > 0.3 && !b.contains_key(id)).count();
    (gone(a, b) + gone(b, a)) as f64 / a.len() as f64
}
