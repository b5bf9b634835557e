//! `dotwork render`: from inputs to a picture.

use std::time::Instant;

use dotwork::{Artist, Format, Stipples, encode_drawing};

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
    let options = Options::new(&args.scene)?;
    output::check(&args.output, &args.inputs)?;

    let mut scene = scene::open(&args.inputs, &options, report)?;
    report.progress("baking", |progress| scene.bake(progress));
    let mut artist = Artist::new();
    let drawing = artist.draw(&scene);
    let lacking = artist.exhausted(&scene);
    output::write(&args.output, |w| encode_drawing(w, format, &drawing, &scene))?;

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
    report.summary(&format!(
        "{}: {} dots, {}",
        args.output.display(),
        grouped(drawing.dot_count()),
        seconds(start.elapsed().as_secs_f64())
    ));
    Ok(())
}

fn format(args: &RenderArgs) -> Result<Format, Failure> {
    let format = Format::of(&args.output).ok_or_else(|| {
        let (out, names) = (args.output.display(), Format::NAMES);
        Failure::Usage(format!("{out}: the output's ending is not one of {names}"))
    })?;
    match (format, args.csv) {
        (Format::Csv, Some(CsvColumns::Full)) => Ok(Format::CsvFull),
        (Format::Csv, _) | (_, None) => Ok(format),
        _ => Err(Failure::Usage("--csv is for an output that ends in .csv".into())),
    }
}
