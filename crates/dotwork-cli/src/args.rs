//! What was typed: the command line, its help, and the checks that need nothing but the words themselves.

use std::path::{Path, PathBuf};

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};
use dotwork::drawing::page::parse_paper_mm;
use dotwork::io::volume::RawLayout;
use dotwork::{
    Camera, Color, Length, Light, LightFrame, Page, ScaleBar, Stipples, Style, UpAxis, resolve_palette,
};

/// The whole command line.
#[derive(Parser)]
#[command(
    name = "dotwork",
    version,
    max_term_width = 80,
    disable_help_flag = true,
    disable_version_flag = true,
    disable_help_subcommand = true,
    about = "draw 3D data as stipple illustrations",
    after_help = "\
Examples:
  dotwork render demo:teapot -o teapot.png
  dotwork render bunny.ply -o plate.png --style hard --camera -30,20
  dotwork render bunny.ply -o plate.png --page A5 --dpi 600 --pen 0.25mm
  dotwork animate fox.glb -o fox.gif --clip Run
  dotwork styles              list the styles
  dotwork styles --keys       every style key: value, range, meaning

Exit code 0: done; 1: the run failed; 2: the command was not understood."
)]
pub struct Cli {
    /// what to do
    #[command(subcommand)]
    pub command: Command,

    /// work with this many threads; the result is the same with any number
    /// [default: one for each core]
    #[arg(long, global = true, value_name = "N", value_parser = parse_threads, help_heading = "Run")]
    pub threads: Option<usize>,

    /// print neither warnings nor progress, only errors
    /// [default: print them]
    #[arg(long, short, global = true, help_heading = "Run")]
    pub quiet: bool,

    /// print this help
    #[arg(long, short, global = true, action = ArgAction::HelpShort, help_heading = "Run")]
    pub help: Option<bool>,

    /// print the version
    #[arg(long, short = 'V', action = ArgAction::Version, help_heading = "Run")]
    pub version: Option<bool>,
}

/// What to do.
#[derive(Subcommand)]
pub enum Command {
    /// draw a picture: png, svg, pdf, tif, csv or json
    Render(RenderArgs),
    /// draw a film: gif, png (animated), mp4, webm, csv, or a file a frame
    Animate(AnimateArgs),
    /// do the expensive half once: write stipples, surface and settings to a .dots file
    Bake(BakeArgs),
    /// say what is in a file
    Info(InfoArgs),
    /// list the styles, or every key of one
    Styles(StylesArgs),
    /// write a built-in shape or volume to a file, or list them
    Demo(DemoArgs),
    /// measure the speed of this machine
    Bench(BenchArgs),
    /// print a completion script for a shell
    #[command(after_help = "\
Example:
  dotwork completions bash > ~/.local/share/bash-completion/completions/dotwork")]
    Completions {
        /// the shell
        shell: clap_complete::Shell,
    },
    /// print the manual page
    #[command(after_help = "\
Examples:
  dotwork man | man -l -
  dotwork man render > dotwork-render.1")]
    Man {
        /// a subcommand [default: the page of dotwork itself]
        command: Option<String>,
    },
}

/// `dotwork render`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  dotwork render bunny.ply -o bunny.png
  dotwork render bunny.ply -o bunny.png --style night --size 1600x1200
  dotwork render scan.obj -o scan.png --up z --camera left --light 30,50
  dotwork render a.ply b.ply -o both.csv --csv full --stipples 200000
  dotwork render bunny.dots -o again.png --set gamma=1.7 --set color=#223344
  dotwork render bunny.ply -o plate.pdf --page A5 --margin 10mm --pen 0.25mm
  dotwork render bunny.ply -o plate.tif --page A5 --dpi 1200 --bilevel
  dotwork render bunny.ply -o plot.svg --page A4 --pens 0.18,0.25,0.35 --plot
  dotwork render head.nii.gz -o head.svg --iso 120 --ortho --scale-bar auto
  dotwork render plate.svg -o again.png

Where options meet: a style (--style, or what a .dots file or a plate holds),
then --set, then --pen and --paper.")]
pub struct RenderArgs {
    /// what to draw: meshes (PLY, OBJ, STL, OFF, glTF), volumes (NRRD,
    /// NIfTI, MetaImage, VTK, TIFF, DICOM, raw), .dots files, demo:NAME, or a
    /// plate that dotwork drew (SVG, PDF, PNG, TIFF)
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,

    /// the file to write; its ending says the format: png, svg, pdf, tif, csv
    /// or json
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// black and white only, one bit a pixel, for print: png and tif
    /// [default: shades]
    #[arg(long, help_heading = "Output")]
    pub bilevel: bool,

    /// order the marks of an .svg for a pen plotter, one layer a pen, and print
    /// the pen's travel [default: drawing order]
    #[arg(long, help_heading = "Output")]
    pub plot: bool,

    /// columns of a .csv output: full adds place and normal, x,y,z,nx,ny,nz
    /// [default: plain]
    #[arg(long, value_enum, value_name = "COLUMNS", help_heading = "Output")]
    pub csv: Option<CsvColumns>,

    /// leave the paper of a .png transparent [default: paper]
    #[arg(long, help_heading = "Output")]
    pub alpha: bool,

    #[command(flatten)]
    pub pose: PoseArgs,

    #[command(flatten)]
    pub scene: SceneArgs,
}

/// `dotwork animate`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  dotwork animate bunny.ply -o bunny.gif --turntable 72 --size 480
  dotwork animate fox.glb -o fox.mp4 --clip Run --size 1280x720
  dotwork animate man.glb -o frames/f-%04d.png --frames 0..48 --resume
  dotwork animate man.glb -o man.svg%04d.svg --on-twos 2 --style hard
  dotwork animate scene.toml -o flight.webm --fps 30

The time of a frame is its number by the frames a second. What moves is the
animation that a glTF file brings, the camera on a turntable, and camera and
light by the keys of a scene file.")]
pub struct AnimateArgs {
    /// what to draw: everything that render draws
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,

    /// the film: .gif, .png (animated), .mp4, .webm, .csv, or with %04d in its
    /// name a picture a frame: png, svg, pdf, tif, json
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,

    /// turn the camera once round in N frames; an animation then plays only if
    /// --clip names it [default: no turning]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), help_heading = "Film")]
    pub turntable: Option<u32>,

    /// the animation to play, by its name or number; dotwork info lists them
    /// [default: the first]
    #[arg(long, value_name = "NAME|N", help_heading = "Film")]
    pub clip: Option<String>,

    /// the frames to draw, B excluded [default: all]
    #[arg(long, value_name = "A..B", value_parser = parse_frames, help_heading = "Film")]
    pub frames: Option<Frames>,

    /// frames a second [default: 24]
    #[arg(long, value_name = "RATE", value_parser = parse_fps, help_heading = "Film")]
    pub fps: Option<f64>,

    /// hold each drawing for N frames, as hand-drawn films do [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000), help_heading = "Film")]
    pub on_twos: Option<u32>,

    /// where a surface is stretched: keep its tone by further dots, or let the
    /// dots follow [default: keep]
    #[arg(long, value_name = "keep|follow", help_heading = "Film")]
    pub density: Option<dotwork::Density>,

    /// see the scene through a camera of a glTF file, by its name or number
    /// [default: --camera; without a value: the first]
    #[arg(long, value_name = "NAME|N", num_args = 0..=1, default_missing_value = "", help_heading = "Film")]
    pub film_camera: Option<String>,

    /// leave the paper transparent: png, gif, webm [default: paper]
    #[arg(long, help_heading = "Output")]
    pub alpha: bool,

    /// leave out frames whose files are there already, drawn with the same
    /// settings [default: draw all]
    #[arg(long, help_heading = "Output")]
    pub resume: bool,

    /// columns of a .csv output: full adds place and normal, x,y,z,nx,ny,nz
    /// [default: plain]
    #[arg(long, value_enum, value_name = "COLUMNS", help_heading = "Output")]
    pub csv: Option<CsvColumns>,

    #[command(flatten)]
    pub scene: SceneArgs,
}

/// The pose of an input that moves.
#[derive(Args)]
pub struct PoseArgs {
    /// the animation of a glTF file whose pose is drawn, by its name or number
    /// [default: at rest; with --time: the first]
    #[arg(long, value_name = "NAME|N", help_heading = "Input")]
    pub clip: Option<String>,

    /// seconds of that animation [default: 0 with --clip]
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds, help_heading = "Input")]
    pub time: Option<f64>,
}

/// Frames from the first to the one after the last.
pub type Frames = std::ops::Range<u32>;

/// `dotwork bake`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  dotwork bake bunny.ply -o bunny.dots
  dotwork bake bunny.ply -o bunny.dots --stipples 500000 --style engraving
  dotwork render bunny.dots -o front.png --camera front

The file holds everything: render draws it as it would draw the sources. The
options given here become its defaults.")]
pub struct BakeArgs {
    /// what to bake: everything that render draws
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,

    /// the .dots file to write
    #[arg(short, long, value_name = "FILE.dots")]
    pub output: PathBuf,

    #[command(flatten)]
    pub pose: PoseArgs,

    #[command(flatten)]
    pub scene: SceneArgs,
}

/// How inputs are read.
#[derive(Args)]
pub struct InputArgs {
    /// the layout of a volume without a header:
    /// WxHxD:TYPE[:le|be][:SPACING][:header=BYTES], for example 256x256x128:u8 or
    /// 64x64x93:u16:be:3.2,3.2,1.5
    #[arg(long, value_name = "LAYOUT", help_heading = "Input")]
    pub raw: Option<RawLayout>,

    /// the series to read where there are several of DICOM: UID, number or
    /// description [default: the one that makes the largest volume]
    #[arg(long, value_name = "SERIES", help_heading = "Input")]
    pub series: Option<String>,

    /// the values of a volume are labels, each an object: auto, or a table of
    /// their names and colours (ITK-SNAP, Slicer, FreeSurfer) [default: only if
    /// the file says so]
    #[arg(long, value_name = "auto|FILE", help_heading = "Input")]
    pub labels: Option<PathBuf>,

    /// see a volume through a transfer function: FILE.toml, Slicer's .xml or
    /// .vp, or FILE.xml#NAME; each of its steps becomes a surface
    /// [default: none]
    #[arg(long, value_name = "FILE[#NAME]", conflicts_with = "labels", help_heading = "Input")]
    pub transfer: Option<String>,

    /// draw the surface in a volume where its value is V; dotwork info shows the
    /// values [default: that of a feature, see --set feature]
    #[arg(long, value_name = "V", allow_hyphen_values = true, value_parser = parse_iso, help_heading = "Input")]
    pub iso: Option<f64>,
}

/// How objects are drawn.
#[derive(Args)]
pub struct StyleArgs {
    /// a style by name, or a style file (FILE.toml); see dotwork styles
    /// [default: soft]
    #[arg(long, value_name = "NAME|FILE.toml", help_heading = "Style")]
    pub style: Option<String>,

    /// change one key of the style, for example --set tone=0.3; repeatable;
    /// dotwork styles --keys lists the keys
    #[arg(long, value_name = "KEY=VALUE", value_parser = parse_set, help_heading = "Style")]
    pub set: Vec<String>,
}

/// The options that make a scene.
#[derive(Args)]
pub struct SceneArgs {
    #[command(flatten)]
    pub input: InputArgs,

    #[command(flatten)]
    pub style: StyleArgs,

    /// draw with a pen: every dot has this diameter (dot_size = the pen's,
    /// fade = off, foreshorten = 0, grow = 0) [default: no pen]
    #[arg(long, value_name = "0.25mm", value_parser = parse_pen, help_heading = "Style")]
    pub pen: Option<Length>,

    /// draw with several pens: every dot gets one of these diameters (mm), so that
    /// the tone is kept [default: dots of any size]
    #[arg(long, value_name = "0.18,0.25,0.35", value_delimiter = ',', value_parser = parse_pen_mm, conflicts_with = "pen", help_heading = "Style")]
    pub pens: Vec<f32>,

    /// colour of the paper [default: the style's]
    #[arg(long, value_name = "#rrggbb", help_heading = "Style")]
    pub paper: Option<Color>,

    /// how stipples are placed [default: the style's, blue-noise]
    #[arg(long, value_enum, value_name = "METHOD", help_heading = "Stipples")]
    pub bake: Option<BakeMethod>,

    /// how many stipples: a number for each object, or auto: what the darkest
    /// tone of this page needs [default: auto]
    #[arg(long, value_name = "N|auto", help_heading = "Stipples")]
    pub stipples: Option<Stipples>,

    /// seed of every random choice [default: 0]
    #[arg(long, value_name = "N", help_heading = "Stipples")]
    pub seed: Option<u32>,

    /// size in pixels, WxH or one number for a square [default: 1024x1024]
    #[arg(long, value_name = "WxH", value_parser = parse_size, conflicts_with = "page", help_heading = "Page")]
    pub size: Option<[u32; 2]>,

    /// paper size: A0 to A8, Letter, these with -landscape, or WxHmm
    /// [default: --size]
    #[arg(long, value_name = "A5|WxHmm", value_parser = parse_paper_mm, help_heading = "Page")]
    pub page: Option<(f32, f32)>,

    /// margin on all sides: mm, px, or % of the shorter side [default: 0mm]
    #[arg(long, value_name = "10mm", help_heading = "Page")]
    pub margin: Option<Length>,

    /// resolution in pixels an inch [default: 300]
    #[arg(long, value_name = "N", value_parser = parse_dpi, help_heading = "Page")]
    pub dpi: Option<f32>,

    /// where the eye is: degrees to the right, degrees up, and the distance in
    /// bounding radii (fitted if left out); or front, back, left, right, top,
    /// bottom; volumes with an orientation also take anterior, posterior,
    /// superior, inferior, and their left and right are the patient's
    /// [default: 20,15; such a volume: anterior; thin ones are seen face on, and
    /// what a style cuts open is turned towards the cut]
    #[arg(long, value_name = "AZ,EL[,DIST]", allow_hyphen_values = true, value_parser = parse_camera, help_heading = "View")]
    pub camera: Option<String>,

    /// parallel projection [default: perspective]
    #[arg(long, help_heading = "View")]
    pub ortho: bool,

    /// enlarge about the middle of the page, after fitting [default: 1]
    #[arg(long, value_name = "Z", value_parser = parse_zoom, help_heading = "View")]
    pub zoom: Option<f32>,

    /// where the light is, in degrees to the right and up [default: -40,40]
    #[arg(long, value_name = "AZ,EL", allow_hyphen_values = true, value_parser = Light::parse, help_heading = "View")]
    pub light: Option<Light>,

    /// what the light's angles start from: viewer (it follows the eye) or object
    /// (it stays with the object) [default: viewer]
    #[arg(long, value_name = "FRAME", help_heading = "View")]
    pub light_frame: Option<LightFrame>,

    /// which axis of the data points up: x, y, z, or the other way -x, -y, -z
    /// [default: y; z for STL, volumes with an orientation and MetaImage; -z for
    /// other volumes, and -y for one that is seen as an image]
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true, help_heading = "View")]
    pub up: Option<UpAxis>,

    /// a scale bar: auto, or its length such as 50, 20mm or 100um; needs --ortho
    /// [default: none]
    #[arg(long, value_name = "auto|LENGTH", help_heading = "View")]
    pub scale_bar: Option<ScaleBar>,

    /// what does the work; auto takes the fastest there is, at present cpu
    #[arg(long, value_enum, default_value_t = Backend::Auto, help_heading = "Run")]
    pub backend: Backend,
}

/// Columns of the drawing table.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CsvColumns {
    /// what is on the page
    Plain,
    /// with place and normal
    Full,
}

/// Bake methods.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BakeMethod {
    /// exact farthest-point order: evenly spread at every tone
    BlueNoise,
    /// lists of dots in the voxels of a volume (Lu et al. 2002)
    Voxel,
    /// lists of dots in the faces of a mesh (Lu et al. 2003)
    Face,
    /// the mesh's vertices as edges collapse and split (Meruvia Pastor 2003)
    Hierarchy,
}

/// Backends.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// the fastest there is
    Auto,
    /// all cores of the processor
    Cpu,
}

/// `dotwork info`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  dotwork info bunny.ply
  dotwork info head.nii.gz
  dotwork info engine.raw --raw 256x256x128:u8
  dotwork info bunny.dots --json")]
pub struct InfoArgs {
    /// anything that render draws
    pub input: PathBuf,

    /// the layout of a volume without a header:
    /// WxHxD:TYPE[:le|be][:SPACING][:header=BYTES]
    #[arg(long, value_name = "LAYOUT")]
    pub raw: Option<RawLayout>,

    /// the series to read where there are several of DICOM: UID, number or
    /// description [default: the one that makes the largest volume]
    #[arg(long, value_name = "SERIES")]
    pub series: Option<String>,

    #[command(flatten)]
    pub style: StyleArgs,

    /// draw all features of a volume on a contact sheet (.png)
    #[arg(long, value_name = "FILE.png")]
    pub sheet: Option<PathBuf>,

    /// print JSON [default: words]
    #[arg(long)]
    pub json: bool,
}

/// `dotwork styles`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  dotwork styles
  dotwork styles night
  dotwork styles --keys
  dotwork styles --json")]
pub struct StylesArgs {
    /// show every key of this style: a name, or a style file (FILE.toml)
    #[arg(value_name = "NAME|FILE.toml")]
    pub name: Option<String>,

    /// show every key of the style (without a name: of the default one), with
    /// value, default, range and meaning [default: only with a name]
    #[arg(long)]
    pub keys: bool,

    /// print JSON [default: words]
    #[arg(long)]
    pub json: bool,
}

/// `dotwork demo`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  dotwork demo
  dotwork demo teapot -o teapot.ply
  dotwork render demo:teapot -o teapot.png")]
pub struct DemoArgs {
    /// the shape or volume [default: list them]
    #[arg(requires = "output")]
    pub name: Option<String>,

    /// the file to write: .ply or .obj for a shape, .nrrd for a volume
    #[arg(short, long, value_name = "FILE", requires = "name")]
    pub output: Option<PathBuf>,
}

/// `dotwork bench`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  dotwork bench
  dotwork bench bunny.ply dragon.ply.gz --size 1024 --threads 1
  dotwork bench engine.nrrd --iso 60
  dotwork bench engine.nrrd --size 512 --rates --style papers
  dotwork bench teapot.obj --stipples 60000 --set bake=hierarchy
  dotwork bench --size 1024 --stipples 1000000 --set dot_size=1px
  dotwork bench --json > bench.json

The sixth draws, writes and orders about 200,000 dots.")]
pub struct BenchArgs {
    /// meshes and volumes to measure with [default: demo:teapot demo:ribbon]
    #[arg(value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,

    #[command(flatten)]
    pub input: InputArgs,

    #[command(flatten)]
    pub style: StyleArgs,

    /// stipples to bake for each input
    #[arg(long, value_name = "N", default_value_t = 144_000, value_parser = parse_stipple_count)]
    pub stipples: usize,

    /// sizes of the picture in pixels, WxH or one number; repeatable
    /// [default: 512 and 1024]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Vec<[u32; 2]>,

    /// measure frames a second too, as in the table of Lu et al. 2002:
    /// stipples alone, and with lines, hiding and every enhancement; with the
    /// view standing (the light turns) and turning
    #[arg(long)]
    pub rates: bool,

    /// print JSON [default: a table]
    #[arg(long)]
    pub json: bool,
}

fn parse_threads(s: &str) -> Result<usize, String> {
    s.parse().ok().filter(|n| (1..=1024).contains(n)).ok_or_else(|| "write a number from 1 to 1024".into())
}

fn parse_frames(s: &str) -> Result<Frames, String> {
    let range = s.split_once("..").and_then(|(a, b)| Some(a.parse().ok()?..b.parse().ok()?));
    range
        .filter(|r: &Frames| r.start < r.end && r.end <= dotwork::MAX_FRAMES)
        .ok_or_else(|| "write A..B, for example 0..48: the first frame and the one after the last".into())
}

fn parse_fps(s: &str) -> Result<f64, String> {
    let fps = s.parse().ok().filter(|fps| (0.01..=1000.0).contains(fps));
    fps.ok_or_else(|| "write a number from 0.01 to 1000".into())
}

fn parse_seconds(s: &str) -> Result<f64, String> {
    let seconds = s.parse().ok().filter(|t| (0.0..=1e6).contains(t));
    seconds.ok_or_else(|| "write seconds, a number from 0".into())
}

fn parse_set(s: &str) -> Result<String, String> {
    let palette = s.split_once('=').filter(|(key, _)| key.trim() == "palette");
    let s = match palette {
        Some((_, value)) => {
            let list = resolve_palette(Path::new(""), value).map_err(|e| e.to_string())?;
            format!("palette={list}")
        }
        None => s.to_string(),
    };
    Style::default().set_pair(&s).map(|()| s)
}

fn parse_pen(s: &str) -> Result<Length, String> {
    let length: Length = s.parse()?;
    if length.value > 0.0 { Ok(length) } else { Err("a pen has a width above 0".into()) }
}

fn parse_size(s: &str) -> Result<[u32; 2], String> {
    let (w, h) = s.split_once('x').unwrap_or((s, s));
    match (w.parse(), h.parse()) {
        (Ok(w), Ok(h)) => Page::pixels(w, h).map(|_| [w, h]),
        _ => Err("write WIDTHxHEIGHT in pixels, for example 1024x768, or one number".into()),
    }
}

fn parse_dpi(s: &str) -> Result<f32, String> {
    let dpi = s.parse().map_err(|_| "write a number of pixels an inch, for example 600")?;
    Page { dpi, ..Page::default() }.checked().map(|_| dpi)
}

fn parse_camera(s: &str) -> Result<String, String> {
    // What left and right mean depends on the input.
    Camera::default().set_patient_direction(s).map(|()| s.to_string())
}

fn parse_iso(s: &str) -> Result<f64, String> {
    s.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| "write a number".into())
}

fn parse_pen_mm(s: &str) -> Result<f32, String> {
    let number = s.trim().trim_end_matches("mm");
    let pen = number.parse().ok().filter(|p| (0.01..=20.0).contains(p));
    pen.ok_or_else(|| "write the pens' diameters in millimetres, for example 0.18,0.25,0.35".into())
}

fn parse_zoom(s: &str) -> Result<f32, String> {
    let (min, max) = dotwork::ZOOM;
    s.parse()
        .ok()
        .filter(|z| (min..=max).contains(z))
        .ok_or_else(|| format!("write a number from {min} to {max}"))
}

fn parse_stipple_count(s: &str) -> Result<usize, String> {
    match s.parse()? {
        Stipples::Count(n) => Ok(n),
        Stipples::Auto => Err("write a number".into()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_definitions_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn help_fits_80_columns() {
        let mut command = Cli::command();
        command.build();
        for sub in command.get_subcommands_mut() {
            let help = sub.render_help().to_string();
            let widest = help.lines().map(|l| l.chars().count()).max();
            assert!(widest <= Some(80), "{}: {widest:?} columns\n{help}", sub.get_name());
        }
    }
}
