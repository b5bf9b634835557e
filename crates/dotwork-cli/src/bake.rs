//! `dotwork bake`: from inputs to a `.dots` file.

use std::time::Instant;

use dotwork::encode_dots;

use crate::args::BakeArgs;
use crate::options::Options;
use crate::report::{Failure, Report};
use crate::words::{grouped, seconds};
use crate::{output, scene};

/// Bakes and writes a `.dots` file.
pub fn run(args: &BakeArgs, report: &mut Report) -> Result<(), Failure> {
    let start = Instant::now();
    if !args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("dots")) {
        let out = args.output.display();
        return Err(Failure::Usage(format!("{out}: a bake is written to a file that ends in .dots")));
    }
    let options = Options::with_pose(&args.scene, &args.pose)?;
    output::check(&args.output, &args.inputs)?;

    let mut scene = scene::open(&args.inputs, &args.output, &options, report)?;
    options.check_pose(&scene)?;
    report.progress("stipples", |progress| scene.bake(progress));
    let bytes = encode_dots(&scene);
    output::write(&args.output, |w| w.write_all(&bytes))?;

    let stipples: usize = scene.objects.iter().filter_map(|o| o.stock.as_ref()).map(|s| s.len()).sum();
    report.summary(&format!(
        "{}: {} stipples, {}",
        args.output.display(),
        grouped(stipples),
        seconds(start.elapsed().as_secs_f64())
    ));
    Ok(())
}
