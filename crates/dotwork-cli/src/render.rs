//! `dotwork render`: from inputs to a picture.

use std::time::Instant;

use dotwork::{Artist, Format, Length, Scene, Stipples, Warnings, encode_drawing, prepare};

use crate::args::{CsvColumns, RenderArgs};
use crate::options::Options;
use crate::report::{Failure, Report};
use crate::words::{grouped, seconds};
use crate::{output, scene};

/// More of the picture than this lacks dots: a warning.
const EXHAUSTED: f64 = 0.005;

/// Draws and writes a picture.
pub fn run(args: &RenderArgs, report: &mut Report) -> Result<(), Failure> {
    let start = Instant::now();
    let format = format(args)?;
    let options = Options::with_pose(&args.scene, &args.pose)?;
    output::check(&args.output, &args.inputs)?;

    let mut scene = scene::open(&args.inputs, &args.output, &options, report)?;
    options.check_pose(&scene)?;
    if args.plot {
        take_pens(&mut scene, report)?;
    }
    report.progress("stipples", |progress| scene.bake(progress));
    let mut artist = Artist::new();
    let drawn = artist.draw(&scene);
    let lacking = artist.exhausted(&scene);
    let scene = artist.as_drawn(&scene);
    let mut warnings = Warnings::new();
    let (drawing, travel) = prepare(drawn, format, &scene, &mut warnings);
    output::write(&args.output, |w| encode_drawing(w, format, args.alpha, &drawing, &scene, &mut warnings))?;
    report.warn(None, &warnings);

    report.warn(None, &scene.bake_warnings());

    if lacking > EXHAUSTED {
        let stipples: usize = scene.objects.iter().filter_map(|o| o.stock.as_ref()).map(|s| s.len()).sum();
        let advice = match scene.stipples {
            Stipples::Count(_) => "try --stipples auto or a larger number",
            // Either a .dots file was baked for another view, or auto has come to its limit.
            Stipples::Auto => "bake with these options, or with --stipples N, N larger than that",
        };
        report.warning(&format!(
            "the stock of {} stipples is too small: {:.1} % of the picture is too light ({advice})",
            grouped(stipples),
            100.0 * lacking
        ));
    }
    if let Some(travel) = travel {
        report.say(&travel.to_string())?;
    }
    report.summary(&format!(
        "{}: {} dots, {}",
        args.output.display(),
        grouped(drawing.dot_count()),
        seconds(start.elapsed().as_secs_f64())
    ));
    Ok(())
}

/// A plotter's dots have the size of its pen: objects with free sizes are drawn with one of their dot size.
fn take_pens(scene: &mut Scene, report: &mut Report) -> Result<(), Failure> {
    if !scene.pens.is_empty() {
        return Ok(());
    }
    for object in scene.objects.iter_mut().filter(|o| o.style.pen_mm().is_none()) {
        let mm = object.style.dot_size.to_px(&scene.page) * scene.page.mm_per_px();
        let pen = ((100.0 * mm).round() / 100.0).max(0.01);
        let mut style = object.style.clone();
        style.use_pen(Length::mm(pen));
        object.restyle(style).map_err(|e| Failure::Run(e.to_string()))?;
        report.warning(&format!(
            "{}: drawn for a pen of {pen} mm; --pen or --pens says which pens there are",
            object.name
        ));
    }
    Ok(())
}

fn format(args: &RenderArgs) -> Result<Format, Failure> {
    let format = Format::of(&args.output).ok_or_else(|| {
        let (out, names) = (args.output.display(), Format::NAMES);
        Failure::Usage(format!("{out}: the output's ending is not one of {names}"))
    })?;
    let usage = |text: &str| Err(Failure::Usage(text.into()));
    if args.alpha && (format != Format::Png || args.bilevel) {
        return usage("--alpha is for a .png in shades");
    }
    match (format, args.csv) {
        (Format::Csv, Some(CsvColumns::Full)) => return Ok(Format::CsvFull),
        (Format::Csv, _) | (_, None) => {}
        _ => return usage("--csv is for an output that ends in .csv"),
    }
    match (format, args.bilevel, args.plot) {
        (_, true, true) => usage("--plot is for an .svg, --bilevel for a .png or .tif"),
        (Format::Png, true, _) => Ok(Format::PngBilevel),
        (Format::Tiff, true, _) => Ok(Format::TiffBilevel),
        (_, true, _) => usage("--bilevel is for an output that ends in .png or .tif"),
        (Format::Svg, _, true) => Ok(Format::SvgPlot),
        (_, _, true) => usage("--plot is for an output that ends in .svg"),
        _ => Ok(format),
    }
}
