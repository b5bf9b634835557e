//! `dotwork demo`: the built-in shapes.

use dotwork::io::{MeshFormat, mesh_format_of, write_obj, write_ply};
use dotwork::mesh::shapes::{DEMOS, demo};

use crate::args::DemoArgs;
use crate::report::{self, Failure};
use crate::{output, words};

/// Lists the shapes, or writes one.
pub fn run(args: &DemoArgs) -> Result<(), Failure> {
    let (Some(name), Some(path)) = (&args.name, &args.output) else {
        let rows: Vec<_> = DEMOS.iter().map(|d| (d.name, d.summary.to_string())).collect();
        return report::print(&words::list(&rows));
    };
    if !DEMOS.iter().any(|d| d.name == name) {
        let names: Vec<&str> = DEMOS.iter().map(|d| d.name).collect();
        let names = names.join(", ");
        return Err(Failure::Usage(format!("there is no demo '{name}'; the demos are {names}")));
    }
    let format = mesh_format_of(path);
    if !matches!(format, Some(MeshFormat::Ply | MeshFormat::Obj)) {
        let path = path.display();
        return Err(Failure::Usage(format!("{path}: a demo is written to a file that ends in .ply or .obj")));
    }
    output::check(path, &[])?;
    let mesh = demo(name).unwrap_or_default();
    output::write(path, |w| match format {
        Some(MeshFormat::Obj) => write_obj(&mesh, w),
        _ => write_ply(&mesh, w),
    })
}
