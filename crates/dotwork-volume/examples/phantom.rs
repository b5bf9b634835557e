//! Writes a phantom as an NRRD file: `cargo run --release -p dotwork-volume --example phantom -- head head.nrrd`.

use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};

use dotwork_volume::{Samples, Space, phantom};

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let (Some(name), Some(path)) = (args.next(), args.next()) else {
        return Err("usage: phantom NAME FILE.nrrd".into());
    };
    let volume = phantom::phantom(&name).ok_or_else(|| {
        let names: Vec<&str> = phantom::PHANTOMS.iter().map(|&(name, _)| name).collect();
        format!("there is no phantom {name}; there are {}", names.join(", "))
    })?;
    let bytes = match volume.samples() {
        Samples::U8(samples) => samples.clone(),
        Samples::I16(samples) => samples.iter().flat_map(|s| s.to_le_bytes()).collect(),
        other => return Err(format!("{} is not written here", other.sample_type()).into()),
    };
    let space = match volume.affine().space {
        Space::Patient => "space: left-posterior-superior",
        Space::Unknown => "space dimension: 3",
    };
    let ([x, y, z], [sx, sy, sz], o) = (volume.dims(), volume.spacing(), volume.affine().origin);
    let mut file = BufWriter::new(File::create(path)?);
    writeln!(file, "NRRD0004\ntype: {}\ndimension: 3\n{space}", volume.samples().sample_type())?;
    writeln!(file, "sizes: {x} {y} {z}\nspace directions: ({sx},0,0) (0,{sy},0) (0,0,{sz})")?;
    writeln!(file, "space origin: ({},{},{})\nendian: little\nencoding: raw\n", o.x, o.y, o.z)?;
    file.write_all(&bytes)?;
    Ok(file.flush()?)
}
