//! Films as files: frames drawn side by side, written one after the other.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use dotwork_drawing::{Color, Drawing, Warnings};
use dotwork_export::{
    ApngWriter, CsvWriter, GifWriter, Pixels, RasterView, SETTINGS_KEYWORD, apng_frame, gif_frame,
    pixels_per_metre,
};
use dotwork_ink::{Coloring, Fill};
use dotwork_render::{Raster, Rasterizer};
use rayon::prelude::*;

use super::output::{Format, SOFTWARE, encode_with, places_of, prepare};
use crate::artist::Artist;
use crate::dots_file::settings_text;
use crate::film::Film;
use crate::scene::Scene;

/// How a film is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmFormat {
    /// A picture a frame.
    Frames(Format),
    /// All frames in one drawing table.
    Csv,
    /// The same with places and normals.
    CsvFull,
    /// An animated GIF.
    Gif,
    /// An animated PNG.
    Apng,
    /// H.264 in MP4, by ffmpeg.
    Mp4,
    /// VP9 in WebM, by ffmpeg.
    Webm,
}

/// Where the frames of a film go.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmPath {
    /// The whole path, as it was given.
    pub path: PathBuf,
    /// How it is written.
    pub format: FilmFormat,
    /// Before and after the number of a frame, and its least number of digits; `None`: one file.
    pattern: Option<(String, usize, String)>,
}

impl FilmPath {
    /// The endings that are understood, as a list for messages.
    pub const NAMES: &str = "gif, png (an animated one), mp4, webm, csv, or a picture a frame: png, svg, pdf, tif or json with a number in \
         its name, as frame-%04d.png";

    /// Understands the path of a film: its ending, and `%d` or `%04d` in its name where each frame is a file of its own.
    ///
    /// # Errors
    /// What is understood.
    pub fn parse(path: &Path) -> Result<FilmPath, String> {
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let pattern = pattern(name)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let unknown = || Err(format!("the output of a film ends in {}", FilmPath::NAMES));
        let format = match (ending.as_str(), &pattern) {
            ("csv", None) => FilmFormat::Csv,
            ("gif", None) => FilmFormat::Gif,
            ("png" | "apng", None) => FilmFormat::Apng,
            ("mp4", None) => FilmFormat::Mp4,
            ("webm", None) => FilmFormat::Webm,
            (_, Some(_)) => match Format::of(path) {
                Some(format) => FilmFormat::Frames(format),
                None => return unknown(),
            },
            ("svg" | "pdf" | "tif" | "tiff" | "json", None) => {
                return Err(format!(
                    "a film of {ending} files has the number of the frame in its name, as %04d"
                ));
            }
            _ => return unknown(),
        };
        let pattern = pattern.map(|(before, digits, after)| {
            (folder.join(before).to_string_lossy().into_owned(), digits, after)
        });
        Ok(FilmPath { path: path.to_path_buf(), format, pattern })
    }

    /// The file of frame `n`.
    pub fn of(&self, n: u32) -> PathBuf {
        match &self.pattern {
            None => self.path.clone(),
            Some((before, digits, after)) => format!("{before}{n:0digits$}{after}").into(),
        }
    }
}

/// What stands before and after `%d` or `%04d` in a name, and how many digits are asked for; `%%` is a percent sign.
pub(super) fn pattern(name: &str) -> Result<Option<(String, usize, String)>, String> {
    let mut found: Option<(String, usize)> = None;
    let mut text = String::new();
    let mut rest = name;
    while let Some(at) = rest.find('%') {
        text.push_str(&rest[..at]);
        rest = &rest[at + 1..];
        if let Some(after) = rest.strip_prefix('%') {
            text.push('%');
            rest = after;
            continue;
        }
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let width = rest[..digits].trim_start_matches('0');
        let width: usize = if width.is_empty() { 1 } else { width.parse().unwrap_or(usize::MAX) };
        let plain = digits == 0 || rest.starts_with('0');
        match rest[digits..].strip_prefix('d') {
            Some(after) if found.is_none() && width <= 9 && plain => {
                found = Some((std::mem::take(&mut text), width));
                rest = after;
            }
            _ => {
                return Err(
                    "the name of a frame has its number as %d or %04d, once; %% is a percent sign".into()
                );
            }
        }
    }
    text.push_str(rest);
    Ok(found.map(|(before, digits)| (before, digits, text)))
}

/// Draws frames side by side, as many at once as there are threads, and hands them to `each` in their order: what
/// `make` makes of the frame's number, its drawing and the scene as it then is, with a rasteriser of its own.
///
/// # Errors
/// What `each` refuses.
pub fn draw_film<T: Send>(
    film: &Film,
    scene: &Scene,
    frames: &[u32],
    make: impl Fn(&mut Rasterizer, u32, Drawing, &Scene) -> T + Sync,
    mut each: impl FnMut(u32, T) -> io::Result<()>,
) -> io::Result<()> {
    let side_by_side = rayon::current_num_threads().min(frames.len()).max(1);
    let mut artists: Vec<(Artist, Rasterizer)> = Vec::new();
    artists.resize_with(side_by_side, Default::default);
    let mut draw = |batch: &[u32]| -> Vec<T> {
        artists
            .par_iter_mut()
            .zip(batch)
            .map(|((artist, rasterizer), &n)| {
                let now = film.scene_at(scene, n);
                let drawing = artist.draw(&now);
                make(rasterizer, n, drawing, &artist.as_drawn(&now))
            })
            .collect()
    };
    // While some frames are drawn, those before them are written.
    let mut waiting: Vec<(u32, T)> = Vec::new();
    for batch in frames.chunks(side_by_side) {
        let (drawn, written) = std::thread::scope(|scope| {
            let drawing = scope.spawn(|| draw(batch));
            let written = waiting.drain(..).try_for_each(|(n, made)| each(n, made));
            (drawing.join(), written)
        });
        written?;
        let drawn = drawn.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        waiting.extend(batch.iter().copied().zip(drawn));
    }
    waiting.into_iter().try_for_each(|(n, made)| each(n, made))
}

/// A drawing as pixels: grey or colour, as it is; with its paper clear, red, green, blue and opacity.
///
/// The opacities are those that show over white and over black paper just what would be drawn there, in programs that
/// blend the encoded values, as most do.
pub fn rasterize(rasterizer: &mut Rasterizer, drawing: &Drawing, clear: bool) -> Raster {
    let mut raster = Raster::default();
    if !clear {
        rasterizer.draw(drawing, &mut raster);
        return raster;
    }
    let on = |paper: Color| Drawing { paper, ..drawing.clone() };
    let mut black = Raster::default();
    rasterizer.draw(&on(Color::WHITE), &mut raster);
    rasterizer.draw(&on(Color::BLACK), &mut black);
    let n = raster.channels;
    let pixels = raster.samples.chunks_exact(n).zip(black.samples.chunks_exact(n));
    let samples = pixels.flat_map(|(white, black)| {
        let channel = |k: usize| (u32::from(white[k % n]), u32::from(black[k % n]));
        let shown = (0..3).map(|k| channel(k).0.saturating_sub(channel(k).1)).sum::<u32>();
        let opacity = 255 - (shown + 1) / 3;
        let ink = |k: usize| (channel(k).1 * 255 + opacity / 2).checked_div(opacity).unwrap_or(0).min(255);
        [ink(0), ink(1), ink(2), opacity].map(|v| v as u8)
    });
    Raster { channels: 4, samples: samples.collect(), ..raster }
}

/// A raster as the writers take it.
pub(super) fn view(raster: &Raster) -> RasterView<'_> {
    let samples = &raster.samples;
    let pixels = match raster.channels {
        1 => Pixels::Grey(samples),
        3 => Pixels::Rgb(samples),
        _ => Pixels::Rgba(samples),
    };
    RasterView { width: raster.width, height: raster.height, pixels }
}

/// The same in three channels, or in four.
fn in_colors(raster: Raster) -> Raster {
    if raster.channels != 1 {
        return raster;
    }
    let samples = raster.samples.iter().flat_map(|&grey| [grey; 3]).collect();
    Raster { channels: 3, samples, ..raster }
}

/// True if every frame of a scene is grey.
fn stays_grey(scene: &Scene) -> bool {
    let paper = scene.objects.first().is_none_or(|o| o.style.paper.is_grey());
    let ink = |o: &crate::Object| {
        let style = &o.style;
        style.color.is_grey()
            && style.outline_color.0.is_none_or(Color::is_grey)
            && style.coloring == Coloring::None
            && match style.fill {
                Fill::None => true,
                Fill::Own => !o.mesh.is_colored(),
                Fill::Color(color) => color.is_grey(),
            }
    };
    paper && scene.objects.iter().all(ink)
}

/// Writes a film as one file that dotwork writes itself: GIF, APNG or a drawing table; or as the pixels that a video
/// encoder takes, three bytes each, four with a clear paper. `progress` is told after each frame how many are done.
///
/// What a format cannot show is said in `warnings`.
///
/// # Errors
/// What the writer refuses.
pub fn encode_film(
    writer: &mut dyn Write,
    format: FilmFormat,
    clear: bool,
    film: &Film,
    scene: &Scene,
    warnings: &mut Warnings,
    progress: &mut dyn FnMut(u32),
) -> io::Result<()> {
    let range = film.frames();
    let drawn: Vec<u32> = range.clone().filter(|&n| film.held(n).start == n && starts(film, n)).collect();
    let done = |held: &std::ops::Range<u32>| held.end - range.start;
    let ready = |drawing: Drawing, scene: &Scene| {
        let mut said = Warnings::new();
        let (drawing, _) = prepare(drawing, Format::Png, scene, &mut said);
        (drawing, said)
    };
    let times = |held: &std::ops::Range<u32>| (film.time(held.start), film.time(held.end));
    match format {
        FilmFormat::Gif => {
            let mut gif = GifWriter::new(writer, scene.page.width, scene.page.height)?;
            let make = |r: &mut Rasterizer, _, drawing, scene: &Scene| {
                let (drawing, said) = ready(drawing, scene);
                (gif_frame(&view(&rasterize(r, &drawing, clear))), said)
            };
            draw_film(film, scene, &drawn, make, |n, (frame, said)| {
                warnings.append(said);
                let held = film.held(n);
                let (start, end) = times(&held);
                gif.frame(frame?, start, end)?;
                progress(done(&held));
                Ok(())
            })?;
            gif.finish()
        }
        FilmFormat::Apng => {
            let settings = settings_text(scene);
            let text = [("Software", SOFTWARE), (SETTINGS_KEYWORD, settings.as_str())];
            let ppm = pixels_per_metre(scene.page.dpi);
            let mut apng = ApngWriter::new(writer, drawn.len() as u32, ppm, &text);
            let grey = stays_grey(scene);
            let make = |r: &mut Rasterizer, _, drawing, scene: &Scene| {
                let (drawing, said) = ready(drawing, scene);
                let raster = rasterize(r, &drawing, clear);
                let raster = if grey { raster } else { in_colors(raster) };
                (apng_frame(&view(&raster)), said)
            };
            draw_film(film, scene, &drawn, make, |n, (frame, said)| {
                warnings.append(said);
                let held = film.held(n);
                let (start, end) = times(&held);
                apng.frame(frame?, start, end)?;
                progress(done(&held));
                Ok(())
            })?;
            apng.finish()
        }
        FilmFormat::Csv | FilmFormat::CsvFull => {
            let full = format == FilmFormat::CsvFull;
            CsvWriter::new(&mut *writer, full)?;
            let make = |_: &mut Rasterizer, n: u32, drawing, scene: &Scene| {
                let (drawing, said) = ready(drawing, scene);
                let mut rows = Vec::new();
                let places = places_of(scene, &drawing);
                let written = film.held(n).try_for_each(|n| {
                    CsvWriter::without_header(&mut rows, full).frame(n, &drawing, full.then_some(&places))
                });
                (written.map(|()| rows), said)
            };
            draw_film(film, scene, &drawn, make, |n, (rows, said)| {
                warnings.append(said);
                writer.write_all(&rows?)?;
                progress(done(&film.held(n)));
                Ok(())
            })
        }
        FilmFormat::Mp4 | FilmFormat::Webm => {
            let make = |r: &mut Rasterizer, _, drawing, scene: &Scene| {
                let (drawing, said) = ready(drawing, scene);
                (in_colors(rasterize(r, &drawing, clear)), said)
            };
            draw_film(film, scene, &drawn, make, |n, (raster, said)| {
                warnings.append(said);
                for _ in film.held(n) {
                    writer.write_all(&raster.samples)?;
                }
                progress(done(&film.held(n)));
                Ok(())
            })
        }
        FilmFormat::Frames(_) => {
            Err(io::Error::new(io::ErrorKind::InvalidInput, "the frames of this film are files of their own"))
        }
    }
}

/// Whether frame `n` begins a drawing.
fn starts(film: &Film, n: u32) -> bool {
    film.shown(n) == n
}

/// Draws the frames of a film whose frames are files of their own, and hands the bytes of each to `each`; those of
/// `frames` only.
///
/// # Errors
/// What `each` or an encoder refuses.
pub fn encode_frames(
    format: Format,
    clear: bool,
    film: &Film,
    scene: &Scene,
    frames: &[u32],
    warnings: &mut Warnings,
    mut each: impl FnMut(u32, &[u8]) -> io::Result<()>,
) -> io::Result<()> {
    let make = |r: &mut Rasterizer, _, drawing: Drawing, scene: &Scene| {
        let mut said = Warnings::new();
        let (drawing, _) = prepare(drawing, format, scene, &mut said);
        let mut bytes = Vec::new();
        let written = encode_with(r, &mut bytes, format, clear, &drawing, scene, &mut said);
        (written.map(|()| bytes), said)
    };
    draw_film(film, scene, frames, make, |n, (bytes, said)| {
        warnings.append(said);
        each(n, &bytes?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_frames() {
        let of = |path: &str, n: u32| FilmPath::parse(Path::new(path)).map(|p| p.of(n));
        assert_eq!(of("out/f-%04d.png", 7), Ok("out/f-0007.png".into()));
        assert_eq!(of("f%d.svg", 123), Ok("f123.svg".into()));
        assert_eq!(of("100%%-%02d.json", 5), Ok("100%-05.json".into()));
        for wrong in ["f-%04x.png", "%d-%d.png", "f-%12d.png", "f-%099d.png", "f-%.png"] {
            assert!(of(wrong, 1).unwrap_err().contains("%04d"), "{wrong}");
        }
        let format = |path: &str| FilmPath::parse(Path::new(path)).map(|p| p.format);
        assert_eq!(format("f.GIF"), Ok(FilmFormat::Gif));
        assert_eq!(format("f.png"), Ok(FilmFormat::Apng));
        assert_eq!(format("f.csv"), Ok(FilmFormat::Csv));
        assert!(format("f.svg").unwrap_err().contains("%04d"));
        assert!(format("f.avi").unwrap_err().contains("webm"));
        assert!(format("f-%d.gif").is_err());
    }
}
