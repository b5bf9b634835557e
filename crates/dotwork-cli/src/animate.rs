//! `dotwork animate`: from inputs to a film.

use std::path::Path;
use std::time::Instant;

use dotwork::export::embedded_settings;
use dotwork::{
    Artist, Film, FilmFormat, FilmOptions, FilmPath, Format, Scene, Stipples, Warnings, encode_film,
    encode_frames, settings_text,
};

use crate::args::{AnimateArgs, CsvColumns};
use crate::ffmpeg::Ffmpeg;
use crate::options::Options;
use crate::report::{Failure, Report};
use crate::words::{grouped, seconds};
use crate::{output, scene};

/// More of a frame than this lacks dots: a warning.
const EXHAUSTED: f64 = 0.005;

/// Frames that are asked whether they lack dots.
const ASKED: u32 = 5;

/// Draws and writes a film.
pub fn run(args: &AnimateArgs, report: &mut Report) -> Result<(), Failure> {
    let start = Instant::now();
    let path = film_path(args)?;
    let options = Options::new(&args.scene)?;
    // Where frames are files of their own, the first stands for all.
    output::check(&path.of(0), &args.inputs)?;
    let ffmpeg = matches!(path.format, FilmFormat::Mp4 | FilmFormat::Webm).then(Ffmpeg::find).transpose()?;

    let mut scene = scene::open(&args.inputs, &args.output, &options, report)?;
    scene.density = args.density.unwrap_or_default();
    let asked = FilmOptions {
        fps: args.fps,
        frames: args.frames.clone(),
        hold: args.on_twos.unwrap_or(1),
        turntable: args.turntable,
        clip: args.clip.clone(),
        camera: args.film_camera.clone(),
    };
    let named = |reason: String| match &args.inputs[..] {
        [input] => Failure::Run(format!("{}: {reason}", input.display())),
        _ => Failure::Run(reason),
    };
    let film = Film::new(&asked, &mut scene).map_err(named)?;
    report.progress("stipples", |progress| film.set_up(&mut scene, progress)).map_err(named)?;
    warn_of_exhaustion(&film, &scene, report);
    report.warn(None, &scene.bake_warnings());

    let mut warnings = Warnings::new();
    let count = film.frames().len() as u32;
    let drawing = Instant::now();
    let drawn = match path.format {
        FilmFormat::Frames(format) => frames(&path, format, args, &film, &scene, &mut warnings, report)?,
        _ => {
            report.progress("frames", |progress| {
                let mut told = |done: u32| progress(done as f32 / count as f32);
                let mut encode = |w: &mut dyn std::io::Write| {
                    encode_film(w, path.format, args.alpha, &film, &scene, &mut warnings, &mut told)
                };
                match ffmpeg {
                    None => output::write(&path.path, |w| encode(w)),
                    Some(ffmpeg) => {
                        let page = [scene.page.width, scene.page.height];
                        ffmpeg.write(&path.path, path.format, page, film.fps(), args.alpha, &mut encode)
                    }
                }
            })?;
            count
        }
    };
    report.warn(None, &warnings);
    let took = drawing.elapsed().as_secs_f64();
    report.summary(&format!(
        "{}: {} frames, {}, {:.1} frames a second",
        args.output.display(),
        grouped(drawn as usize),
        seconds(start.elapsed().as_secs_f64()),
        f64::from(drawn) / took.max(1e-9)
    ));
    Ok(())
}

/// Writes the frames of a film whose frames are files of their own; returns how many were drawn.
fn frames(
    path: &FilmPath,
    format: Format,
    args: &AnimateArgs,
    film: &Film,
    scene: &Scene,
    warnings: &mut Warnings,
    report: &mut Report,
) -> Result<u32, Failure> {
    let first = film.frames().start;
    let missing = |n: &u32| !args.resume || !is_there(&path.of(*n), film, scene, *n);
    // Of frames that hold one drawing the first stands for all.
    let all: Vec<u32> = film.frames().filter(|&n| film.shown(n) == n).collect();
    let wanted: Vec<u32> = all.into_iter().filter(|&n| film.held(n).any(|held| missing(&held))).collect();
    let mut failed = None;
    let mut drawn = 0;
    let result = report.progress("frames", |progress| {
        encode_frames(format, args.alpha, film, scene, &wanted, warnings, |n, bytes| {
            for held in film.held(n) {
                let written = output::write(&path.of(held), |w| w.write_all(bytes));
                written.map_err(|e| {
                    failed = Some(e);
                    std::io::Error::other("a frame was not written")
                })?;
                drawn += 1;
            }
            let last = film.frames().end - first;
            progress((film.held(n).end - first) as f32 / last as f32);
            Ok(())
        })
    });
    match (failed, result) {
        (Some(failure), _) => Err(failure),
        (None, Err(e)) => Err(Failure::Run(format!("{}: {e}", args.output.display()))),
        (None, Ok(())) => Ok(drawn),
    }
}

/// Whether the file of a frame is there as it would be drawn: files are written whole or not at all, and carry the
/// settings that made them.
fn is_there(file: &Path, film: &Film, scene: &Scene, n: u32) -> bool {
    let Ok(bytes) = std::fs::read(file) else { return false };
    match Format::of(file) {
        // Drawings as JSON carry none.
        Some(Format::Json) => !bytes.is_empty(),
        _ => embedded_settings(&bytes).is_some_and(|made| made == settings_text(&film.scene_at(scene, n))),
    }
}

/// Says so if frames lack dots.
fn warn_of_exhaustion(film: &Film, scene: &Scene, report: &mut Report) {
    let range = film.frames();
    let length = range.len() as u32;
    let mut artist = Artist::new();
    let lacking = (0..ASKED.min(length)).map(|k| {
        let n = range.start + k * length / ASKED.min(length);
        let now = film.scene_at(scene, n);
        artist.draw(&now);
        (n, artist.exhausted(&now))
    });
    let worst = lacking.fold((0, 0.0), |worst, here| if here.1 > worst.1 { here } else { worst });
    if worst.1 > EXHAUSTED {
        let stipples: usize = scene.objects.iter().filter_map(|o| o.stock.as_ref()).map(|s| s.len()).sum();
        let advice = match scene.stipples {
            Stipples::Count(_) => "try --stipples auto or a larger number",
            Stipples::Auto => "bake with these options, or with --stipples N, N larger than that",
        };
        report.warning(&format!(
            "the stock of {} stipples is too small: at frame {} {:.1} % of the picture is too light ({advice})",
            grouped(stipples),
            worst.0,
            100.0 * worst.1
        ));
    }
}

/// Where the film goes, checked against the other options.
fn film_path(args: &AnimateArgs) -> Result<FilmPath, Failure> {
    let usage = |text: &str| Failure::Usage(text.into());
    let mut path = FilmPath::parse(&args.output)
        .map_err(|e| Failure::Usage(format!("{}: {e}", args.output.display())))?;
    match (path.format, args.csv) {
        (FilmFormat::Csv, Some(CsvColumns::Full)) => path.format = FilmFormat::CsvFull,
        (FilmFormat::Csv, _) | (_, None) => {}
        _ => return Err(usage("--csv is for an output that ends in .csv")),
    }
    let frames = matches!(path.format, FilmFormat::Frames(_));
    if args.resume && !frames {
        return Err(usage("--resume is for frames in files of their own, as frame-%04d.png"));
    }
    let clear = matches!(
        path.format,
        FilmFormat::Gif | FilmFormat::Apng | FilmFormat::Webm | FilmFormat::Frames(Format::Png)
    );
    if args.alpha && !clear {
        return Err(usage("--alpha is for png, gif and webm"));
    }
    Ok(path)
}
