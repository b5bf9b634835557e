//! `dotwork demo`: the built-in shapes and volumes.

use dotwork::io::volume::write_nrrd;
use dotwork::io::{MeshFormat, mesh_format_of, write_obj, write_ply};
use dotwork::mesh::shapes::{DEMOS, demo};
use dotwork::volume::phantom::{PHANTOMS, phantom};

use crate::args::DemoArgs;
use crate::report::{self, Failure};
use crate::{output, words};

/// Lists the demos, or writes one.
pub fn run(args: &DemoArgs) -> Result<(), Failure> {
    let shapes = DEMOS.iter().map(|d| (d.name, d.summary));
    let all: Vec<(&str, &str)> = shapes.chain(PHANTOMS.iter().copied()).collect();
    let (Some(name), Some(path)) = (&args.name, &args.output) else {
        let rows: Vec<_> = all.iter().map(|&(name, summary)| (name, summary.to_string())).collect();
        return report::print(&words::list(&rows));
    };
    if !all.iter().any(|(known, _)| known == name) {
        let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        let names = names.join(", ");
        return Err(Failure::Usage(format!("there is no demo '{name}'; the demos are {names}")));
    }
    let ends = |with: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(with));
    let refused = |what: &str| Err(Failure::Usage(format!("{}: {what}", path.display())));
    if PHANTOMS.iter().any(|(known, _)| known == name) {
        if !ends("nrrd") {
            return refused("this demo is a volume: it is written to a file that ends in .nrrd");
        }
        output::check(path, &[])?;
        let Some(volume) = phantom(name) else { return Ok(()) };
        return output::write(path, |w| write_nrrd(&volume, w));
    }
    let format = mesh_format_of(path);
    if !matches!(format, Some(MeshFormat::Ply | MeshFormat::Obj)) {
        return refused("a demo is written to a file that ends in .ply or .obj");
    }
    output::check(path, &[])?;
    let mesh = demo(name).unwrap_or_default();
    output::write(path, |w| match format {
        Some(MeshFormat::Obj) => write_obj(&mesh, w),
        _ => write_ply(&mesh, w),
    })
}
