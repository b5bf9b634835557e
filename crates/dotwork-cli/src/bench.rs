//! `dotwork bench`: how fast this machine loads, bakes, draws and writes.

use std::path::{Path, PathBuf};
use std::time::Instant;

use cpu_time::ProcessTime;
use dotwork::{
    Artist, Drawing, Format, Loaded, Page, Raster, Rasterizer, Scene, Stipples, Style, Warnings,
    encode_drawing, load_with, prepare,
};
use serde_json::{Value, json};

use crate::args::BenchArgs;
use crate::options::chosen_style;
use crate::report::{self, Failure, Report};
use crate::words::{grouped, seconds};

mod rates;

use rates::{DRAWN, Rate, everything};

/// Frames drawn after the first one, each with the camera turned a little further; medians are taken over them.
const FRAMES: usize = 20;

/// Turn of the camera from frame to frame, degrees.
const TURN: f32 = 0.5;

/// Wall-clock and CPU seconds of a piece of work.
#[derive(Clone, Copy, Default)]
struct Cost {
    wall: f64,
    cpu: f64,
}

impl Cost {
    /// Runs `work` and measures it.
    fn of<T>(work: impl FnOnce() -> T) -> (Cost, T) {
        let (wall, cpu) = (Instant::now(), ProcessTime::now());
        let result = work();
        (Cost { wall: wall.elapsed().as_secs_f64(), cpu: cpu.elapsed().as_secs_f64() }, result)
    }

    fn json(self) -> Value {
        json!({ "wall_s": self.wall, "cpu_s": self.cpu })
    }

    fn words(self) -> String {
        seconds(self.wall)
    }
}

/// What was measured on one input.
struct Measured {
    input: String,
    vertices: usize,
    triangles: usize,
    load: Cost,
    /// The surface of a volume.
    surface: Option<Cost>,
    clean: Cost,
    bake: Cost,
    stipples: usize,
    frames: Vec<Frames>,
}

/// What was measured at one size.
struct Frames {
    size: [u32; 2],
    dots: usize,
    first: [Cost; 2],
    /// Medians.
    next: [Cost; 2],
    /// Writing the first frame: name, cost, bytes.
    files: Vec<(&'static str, Cost, usize)>,
    /// Ordering its marks for a plotter.
    order: Cost,
    /// Where asked for, the papers' table.
    rates: Vec<Rate>,
}

/// The files that are written, to memory.
const FILES: [(&str, Format); 4] =
    [("png", Format::Png), ("svg", Format::Svg), ("pdf", Format::Pdf), ("tif", Format::Tiff)];

/// Measures and prints.
pub fn run(args: &BenchArgs, report: &mut Report) -> Result<(), Failure> {
    let defaults = [PathBuf::from("demo:teapot"), PathBuf::from("demo:ribbon")];
    let inputs = if args.inputs.is_empty() { &defaults[..] } else { &args.inputs };
    let sizes = if args.size.is_empty() { vec![[512, 512], [1024, 1024]] } else { args.size.clone() };
    let style = chosen_style(&args.style)?;
    // Curves are prepared with the object, dots and hiding may be left out afterwards.
    let style = if args.rates { everything(&style) } else { style };
    let mut measured = Vec::new();
    for input in inputs {
        measured.push(measure(input, args, &style, &sizes, report)?);
    }
    report::print(&if args.json { as_json(&measured, args) } else { as_table(&measured, args) })
}

fn measure(
    input: &Path,
    args: &BenchArgs,
    style: &Style,
    sizes: &[[u32; 2]],
    report: &mut Report,
) -> Result<Measured, Failure> {
    let mut warnings = Warnings::new();
    let options = args.input.load();
    let (load, loaded) = Cost::of(|| load_with(input, &options, &mut warnings));
    let (surface, file) = match loaded? {
        Loaded::Mesh(file) => (None, *file),
        volume @ Loaded::Volume(_) => {
            let (cost, files) = Cost::of(|| volume.into_meshes(style, args.input.iso, &mut warnings));
            // A clip's cut faces come after the surface itself.
            let Some(file) = files?.into_iter().next() else {
                return Err(Failure::Run(format!("{}: nothing to draw", input.display())));
            };
            (Some(cost), file)
        }
        Loaded::Scene { .. } | Loaded::Plate(_) | Loaded::SceneFile(_) => {
            return Err(Failure::Run(format!(
                "{}: is a whole scene; the benchmark starts from meshes and volumes",
                input.display()
            )));
        }
    };
    let (clean, object) = Cost::of(|| file.into_object(style.clone(), &mut warnings));
    report.warn(Some(input), &warnings);
    let mut scene = Scene { stipples: Stipples::Count(args.stipples), ..Scene::of(object?) };
    let (bake, ()) = Cost::of(|| scene.bake(|_| ()));
    let mut frames = Vec::new();
    for &[width, height] in sizes {
        scene.page = Page::pixels(width, height).map_err(Failure::Usage)?;
        let rates = DRAWN.iter().filter(|_| args.rates).map(|&drawn| Rate::measure(&scene, drawn)).collect();
        frames.push(Frames { rates, ..draw(&scene, [width, height]) });
    }
    let object = &scene.objects[0];
    Ok(Measured {
        input: input.display().to_string(),
        vertices: object.mesh.positions.len(),
        triangles: object.mesh.triangles.len(),
        load,
        surface,
        clean,
        bake,
        stipples: object.stock.as_ref().map_or(0, |s| s.len()),
        frames,
    })
}

/// A first frame, and a turntable after it.
fn draw(scene: &Scene, size: [u32; 2]) -> Frames {
    let mut scene = scene.clone();
    let (mut artist, mut rasterizer) = (Artist::new(), Rasterizer::new());
    let mut drawing = Drawing::new(scene.page, dotwork::Color::WHITE);
    let mut raster = Raster::default();
    let mut frame = |scene: &Scene| {
        let (select, ()) = Cost::of(|| artist.draw_into(scene, &mut drawing));
        let (pixels, ()) = Cost::of(|| rasterizer.draw(&drawing, &mut raster));
        (drawing.dot_count(), [select, pixels])
    };
    let (dots, first) = frame(&scene);
    let (files, order) = write(&scene, Artist::new().draw(&scene));
    let mut next = [Vec::new(), Vec::new()];
    for _ in 0..FRAMES {
        scene.camera.azimuth += TURN;
        let (_, costs) = frame(&scene);
        next.iter_mut().zip(costs).for_each(|(all, cost)| all.push(cost));
    }
    Frames { size, dots, first, next: next.map(median), files, order, rates: Vec::new() }
}

/// Writes a drawing in each format.
fn write(scene: &Scene, drawing: Drawing) -> (Vec<(&'static str, Cost, usize)>, Cost) {
    let files = FILES.map(|(name, format)| {
        let mut bytes = Vec::new();
        // Memory refuses nothing.
        let (cost, _) =
            Cost::of(|| encode_drawing(&mut bytes, format, false, &drawing, scene, &mut Warnings::new()));
        (name, cost, bytes.len())
    });
    let (order, _) = Cost::of(|| prepare(drawing, Format::SvgPlot, scene, &mut Warnings::new()));
    (files.to_vec(), order)
}

fn median(costs: Vec<Cost>) -> Cost {
    let middle = |of: fn(&Cost) -> f64| {
        let mut values: Vec<f64> = costs.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    Cost { wall: middle(|c| c.wall), cpu: middle(|c| c.cpu) }
}

/// The most memory this process has held, in bytes, where the system says so.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    Some(1024 * line.trim().trim_end_matches("kB").trim().parse::<u64>().ok()?)
}

fn as_json(measured: &[Measured], args: &BenchArgs) -> String {
    let inputs: Vec<Value> = measured
        .iter()
        .map(|m| {
            let frames: Vec<Value> = m
                .frames
                .iter()
                .map(|f| {
                    let pair = |[select, raster]: [Cost; 2]| json!({ "select_hide": select.json(), "raster": raster.json() });
                    json!({
                        "width_px": f.size[0], "height_px": f.size[1], "dots": f.dots,
                        "first_frame": pair(f.first), "next_frame": pair(f.next),
                        "files": f.files.iter().map(|(name, cost, bytes)| json!({
                            "format": name, "write": cost.json(), "bytes": bytes,
                        })).collect::<Vec<_>>(),
                        "plot_order": f.order.json(),
                        "rates": f.rates.iter().map(Rate::json).collect::<Vec<_>>(),
                    })
                })
                .collect();
            json!({
                "input": m.input, "vertices": m.vertices, "triangles": m.triangles,
                "load": m.load.json(), "isosurface": m.surface.map(Cost::json), "clean": m.clean.json(), "bake": m.bake.json(),
                "stipples": m.stipples, "stipples_per_s": m.stipples as f64 / m.bake.wall,
                "frames": frames,
            })
        })
        .collect();
    let value = json!({
        "dotwork": env!("CARGO_PKG_VERSION"),
        "threads": rayon::current_num_threads(),
        "stipples": args.stipples,
        "next_frames": FRAMES,
        "peak_memory_bytes": peak_memory(),
        "inputs": inputs,
    });
    format!("{value:#}\n")
}

fn as_table(measured: &[Measured], args: &BenchArgs) -> String {
    let mut rows: Vec<(String, Vec<String>)> = Vec::new();
    let mut row = |name: &str, of: &dyn Fn(&Measured) -> String| {
        rows.push((name.to_string(), measured.iter().map(of).collect()));
    };
    row("", &|m| m.input.clone());
    row("vertices", &|m| grouped(m.vertices));
    row("triangles", &|m| grouped(m.triangles));
    row("load", &|m| m.load.words());
    if measured.iter().any(|m| m.surface.is_some()) {
        row("isosurface", &|m| m.surface.map_or(String::new(), Cost::words));
    }
    row("clean", &|m| m.clean.words());
    row("bake", &|m| m.bake.words());
    row("  processor time", &|m| seconds(m.bake.cpu));
    row("  stipples a second", &|m| grouped((m.stipples as f64 / m.bake.wall) as u64));
    for k in 0..measured.first().map_or(0, |m| m.frames.len()) {
        let [width, height] = measured[0].frames[k].size;
        row(&format!("{width} x {height} pixels"), &|_| String::new());
        row("  dots", &|m| grouped(m.frames[k].dots));
        row("  first frame, select and hide", &|m| m.frames[k].first[0].words());
        row("  first frame, raster", &|m| m.frames[k].first[1].words());
        row("  next frame, select and hide", &|m| m.frames[k].next[0].words());
        row("  next frame, raster", &|m| m.frames[k].next[1].words());
        let both = |m: &Measured| m.frames[k].next[0].wall + m.frames[k].next[1].wall;
        row("  frames a second", &|m| format!("{:.0}", 1.0 / both(m).max(1e-9)));
        for (i, (name, _)) in FILES.iter().enumerate() {
            let size = |bytes: usize| format!("{:.2} MB", bytes as f64 / 1e6);
            row(&format!("  write {name}"), &|m| {
                let (_, cost, bytes) = m.frames[k].files[i];
                format!("{}, {}", cost.words(), size(bytes))
            });
        }
        row("  order for a plotter", &|m| m.frames[k].order.words());
        let rates = |m: &Measured| m.frames[k].rates.iter().flat_map(Rate::rows).collect::<Vec<_>>();
        for (i, (name, _)) in rates(&measured[0]).iter().enumerate() {
            row(name, &|m| rates(m)[i].1.clone());
        }
    }
    let names = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let width = |c: usize| rows.iter().map(|(_, v)| v[c].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..measured.len()).map(width).collect();
    let mut text = format!(
        "dotwork {}, {} threads, {} stipples, medians of {FRAMES} frames turned by {TURN} degrees\n\n",
        env!("CARGO_PKG_VERSION"),
        rayon::current_num_threads(),
        grouped(args.stipples),
    );
    for (name, values) in &rows {
        let mut line = format!("{name:names$}");
        for (value, width) in values.iter().zip(&widths) {
            line += &format!("  {value:>width$}");
        }
        text += line.trim_end();
        text.push('\n');
    }
    if let Some(bytes) = peak_memory() {
        text += &format!("\npeak memory {} MiB\n", grouped(bytes >> 20));
    }
    text
}
