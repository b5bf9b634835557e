//! NIfTI-1 (348-byte header; nifti.nimh.nih.gov) and NIfTI-2 (540 bytes), in one file (`.nii`) or two (`.hdr` and
//! `.img`), gzipped or not, in either byte order.
//!
//! Voxels reach the world by the sform (an affine), or else by the qform (a quaternion and spacings), both in RAS; if
//! the file codes neither, only the spacings are taken and the space is unknown.

mod header;
mod orientation;

use std::path::{Path, PathBuf};

use dotwork_drawing::Warnings;
use dotwork_volume::{SampleType, Scaling, Unit};

use crate::error::ReadErrorKind;
use crate::gzip::is_gzip;
use crate::volume::Found;
use crate::volume::data::{After, Part, Skip, byte_count, pour, product};
use crate::volume::facts::Facts;
use crate::volume::files::{Files, in_file};
use crate::volume::fill::Fill;
use crate::volume::nifti::header::Header;
use crate::volume::reduce::{Reduction, reduce};
use crate::volume::stream::{Packing, Stream};

pub(super) fn read(files: &mut Files, bytes: &[u8], warnings: &mut Warnings) -> Result<Found, ReadErrorKind> {
    let mut stream = stream_of(bytes);
    let mut start = [0; header::LONGEST];
    let got = stream.read(&mut start)?;
    match header::parse(&start[..got]) {
        Ok(header) if header.single => {
            files.count(bytes);
            // From the start again: a NIfTI-1 file may have its samples before byte 540.
            read_samples(&header, stream.again(), stream.packing != Packing::None, 1, warnings)
        }
        Ok(header) => {
            files.count(bytes);
            let (path, image) = open_other(files, "img")?;
            let read = read_samples(&header, stream_of(&image), is_gzip(&image), 2, warnings);
            in_file(&path, read)
        }
        Err(_) if is_named(files.name, "img") => {
            let (path, head) = open_other(files, "hdr")?;
            let mut start = [0; header::LONGEST];
            let got = in_file(&path, stream_of(&head).read(&mut start))?;
            let header = in_file(&path, header::parse(&start[..got]))?;
            files.count(bytes);
            read_samples(&header, stream_of(bytes), is_gzip(bytes), 2, warnings)
        }
        Err(e) => Err(e),
    }
}

fn stream_of(bytes: &[u8]) -> Stream<'_> {
    Stream::new(bytes, if is_gzip(bytes) { Packing::Gzip } else { Packing::None })
}

fn is_named(path: &Path, extension: &str) -> bool {
    crate::volume::format::extension(path) == extension
}

/// Opens the other file of a pair, gzipped or not, in the case of the first one's extension.
fn open_other(files: &mut Files, extension: &str) -> Result<(PathBuf, Vec<u8>), ReadErrorKind> {
    let name = files.name;
    let is_gz = name.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let inner = if is_gz { PathBuf::from(name.file_stem().unwrap_or_default()) } else { name.to_path_buf() };
    let upper =
        inner.extension().is_some_and(|e| e.to_string_lossy().chars().all(|c| c.is_ascii_uppercase()));
    let extension = if upper { extension.to_ascii_uppercase() } else { extension.to_string() };
    let plain = name.with_file_name(inner.with_extension(&extension).file_name().unwrap_or_default());
    let mut gzipped = plain.clone().into_os_string();
    gzipped.push(if upper { ".GZ" } else { ".gz" });
    let gzipped = PathBuf::from(gzipped);
    let (first, second) = if is_gz { (gzipped, plain) } else { (plain, gzipped) };
    match files.open(&first) {
        Err(ReadErrorKind::DataFile { kind, .. }) if matches!(*kind, ReadErrorKind::Missing) => {
            match files.open(&second) {
                Ok(bytes) => Ok((second, bytes)),
                // The plain name is the one to look for.
                Err(_) => Err(ReadErrorKind::DataFile { file: first, kind }),
            }
        }
        Err(e) => Err(e),
        Ok(bytes) => Ok((first, bytes)),
    }
}

/// How the numbers of a voxel are stored.
struct Voxel {
    sample: SampleType,
    components: usize,
    how: Reduction,
}

fn voxel(datatype: i16) -> Result<Voxel, String> {
    let one = |sample| Voxel { sample, components: 1, how: Reduction::First };
    let several = |sample, components, how| Voxel { sample, components, how };
    Ok(match datatype {
        2 => one(SampleType::U8),
        4 => one(SampleType::I16),
        8 => one(SampleType::I32),
        16 => one(SampleType::F32),
        64 => one(SampleType::F64),
        256 => one(SampleType::I8),
        512 => one(SampleType::U16),
        768 => one(SampleType::U32),
        1024 => one(SampleType::I64),
        1280 => one(SampleType::U64),
        32 => several(SampleType::F32, 2, Reduction::Magnitude),
        1792 => several(SampleType::F64, 2, Reduction::Magnitude),
        128 => several(SampleType::U8, 3, Reduction::Luminance),
        2304 => several(SampleType::U8, 4, Reduction::Luminance),
        1 => return Err("samples of 1 bit are not read".into()),
        1536 | 2048 => return Err("128-bit floats are not read".into()),
        _ => return Err(format!("datatype {datatype} is none of NIfTI's")),
    })
}

/// Reads the samples of `stream`, which begins where its file begins; `parts` is how many files there are.
fn read_samples(
    header: &Header,
    stream: Stream,
    gzipped: bool,
    parts: usize,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    let axes = header.axes()?;
    let voxel = voxel(header.datatype).map_err(|r| ReadErrorKind::at_byte(header.datatype_at, r))?;
    let bits = (voxel.sample.bytes() * voxel.components * 8) as i64;
    if i64::from(header.bitpix) != bits {
        warnings.say(format!("the header says {} bits a voxel; its type has {bits}", header.bitpix));
    }
    let dims = header.dims(&axes)?;
    let wanted_sides = [dims[0] as u64, dims[1] as u64, dims[2] as u64, voxel.components as u64];
    let wanted = byte_count(&wanted_sides, voxel.sample.bytes())?;
    let volumes = product(axes[3..].iter().copied())?;
    let declared = product([wanted, volumes])?;
    if volumes > 1 {
        warnings.say(format!("the first of {volumes} volumes is taken"));
    }
    let part = Part {
        skip: Skip::Bytes(header.data_at()?),
        wanted,
        declared,
        after: After::Nothing,
        one_of_many: false,
    };
    let mut fill = Fill::new(voxel.sample, wanted / voxel.sample.bytes() as u64)?;
    pour(&mut fill, stream, 0, part, warnings)?;
    let mut samples = fill.finish(header.big_endian);
    let scaling = scaling(header, voxel.how, warnings);
    match voxel.how {
        Reduction::First => {}
        Reduction::Luminance => warnings.say("RGB samples: their luminance (Rec. 709) is taken"),
        Reduction::Magnitude => warnings.say("complex samples: their magnitude is taken"),
    }
    reduce(&mut samples, 1, voxel.components, voxel.how);

    let (unit, mut facts) = (header.unit(), Facts::default());
    let affine = orientation::affine(header, dims, unit, &mut facts, warnings);
    header.add_facts(&axes, voxel.how, &mut facts);
    let order = match (voxel.sample.bytes(), header.big_endian) {
        (_, true) => ", big endian",
        (1, false) => "",
        (_, false) => ", little endian",
    };
    let version = if header.second { 2 } else { 1 };
    let pair = if parts == 2 { ", two files" } else { "" };
    let gzip = if gzipped { ", gzip" } else { "" };
    Ok(Found { dims, samples, scaling, affine, format: format!("NIfTI-{version}{pair}{gzip}{order}"), facts })
}

fn scaling(header: &Header, how: Reduction, warnings: &mut Warnings) -> Scaling {
    let [slope, intercept] = header.scaling;
    let none = Scaling::default();
    // A slope of 0 means that there is none; so do, by custom, numbers that are none.
    if slope == 0.0 || slope.is_nan() {
        return none;
    }
    let found = Scaling { slope, intercept: if intercept.is_nan() { 0.0 } else { intercept } };
    if !slope.is_finite() || !found.intercept.is_finite() {
        warnings.say(format!("the scaling {slope} x + {intercept} is not finite and is ignored"));
        return none;
    }
    match how {
        Reduction::First => found,
        // NIfTI scales no colours.
        Reduction::Luminance => none,
        Reduction::Magnitude if found.intercept == 0.0 => Scaling { slope: slope.abs(), intercept: 0.0 },
        Reduction::Magnitude => {
            warnings.say(format!("the scaling {slope} x + {intercept} of complex samples is ignored"));
            none
        }
    }
}

impl Header {
    fn unit(&self) -> Unit {
        match self.units & 7 {
            1 => Unit::Metre,
            2 => Unit::Millimetre,
            3 => Unit::Micrometre,
            _ => Unit::Unknown,
        }
    }

    fn add_facts(&self, axes: &[u64], how: Reduction, facts: &mut Facts) {
        if axes.len() > 3 && axes[3..].iter().any(|&n| n > 1) {
            facts.add_axes(axes);
        }
        match how {
            Reduction::First => {}
            Reduction::Luminance => facts.add("samples", "RGB"),
            Reduction::Magnitude => facts.add("samples", "complex"),
        }
        if self.intent != 0 {
            facts.add("intent", header::intent(self.intent));
        }
        facts.add("intent name", &self.intent_name);
        facts.add("description", &self.description);
        facts.add("auxiliary file", &self.auxiliary);
        let [low, high] = self.display;
        if low.is_finite() && high > low {
            facts.add("display range", format!("{low} to {high}"));
        }
    }
}
