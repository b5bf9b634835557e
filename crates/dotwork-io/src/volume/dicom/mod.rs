//! DICOM (PS3.3, PS3.5, PS3.10): a file, a folder of files, or a DICOMDIR, as one volume.
//!
//! The steps:
//!
//! 1. [`scan`]: every file is walked up to its pixels ([`set`]) and becomes an [`Image`] with one or more frames,
//!    old-style or enhanced.
//! 2. [`series`]: the images of one SeriesInstanceUID are taken, the largest stack or the named series; what has
//!    another size, orientation or spacing is left out and said.
//! 3. [`stack`]: slices are sorted by their position along the normal and put on a regular grid; holes are filled,
//!    a gantry's tilt stays as shear.
//! 4. [`pixels`], [`codec`], [`jpeg_ls`]: frames are decoded, each straight into its place.
//! 5. [`values`]: padding becomes low, differing scalings become `float32`, MONOCHROME1 is turned round.
//!
//! World coordinates are the patient's, LPS in millimetres, as DICOM has them. Names and numbers of patients are
//! not read at all.
//!
//! The parser is our own: some hundred lines that borrow from the file and check every length against it. The DICOM
//! crates bring a dictionary and 75 crates to build, and decide for themselves what to allocate. Decoders are taken
//! where they are pure Rust without `unsafe`: `jpeg-decoder` (baseline, extended of 8 bits, lossless to 16 bits) and
//! `hayro-jpeg2000`, which knows no high-throughput blocks; those are left to `dicom-toolkit-jpeg2000`, which began as
//! a copy of it. The decoder of JPEG-LS is our own ([`jpeg_ls`]). JPEG XL is refused by name, as the decoder in Rust,
//! `jxl-oxide`, needs `unsafe`, 40 s of CPU time to build and 2.2 MB; so are lossy JPEG of 12 bits and video.
//!
//! Memory: native pixels take what the files hold, once, and twice more where holes are filled; packed ones may take
//! 16 MiB or 200 times their size, whichever is more, and their decoders 128 MiB or 512 times that size meanwhile (that
//! of JPEG 2000, which computes in `f32`, takes some sixteen bytes for each sample of a frame).

mod codec;
mod image;
mod jpeg_ls;
mod pixels;
mod scan;
mod series;
mod set;
mod stack;
mod syntax;
mod tags;
mod values;

use std::borrow::Cow;
use std::path::Path;

use dotwork_drawing::Warnings;
use rayon::prelude::*;

use crate::error::ReadErrorKind;
use crate::volume::Found;
use crate::volume::dicom::image::{Image, Series};
use crate::volume::dicom::pixels::Pixels;
use crate::volume::dicom::series::{Scan, Slice};
use crate::volume::dicom::stack::Grid;
use crate::volume::dicom::syntax::Codec;
use crate::volume::dicom::values::Meaning;
use crate::volume::facts::Facts;
use crate::volume::files::{Files, in_file};
use crate::volume::fill::{as_bytes_mut, zeroed};
use crate::volume::format::extension;

/// Files that are in memory at one time.
const BATCH: usize = 16;

/// What packed frames may unpack to: this, or so many times their size. JPEG 2000 knows no bound of its own.
const SMALLEST_LIMIT: u64 = 16 << 20;
const RATIO_LIMIT: u64 = 200;

/// What decoders may take meanwhile, in the same way.
const SMALLEST_DECODER_LIMIT: u64 = 128 << 20;
const DECODER_RATIO_LIMIT: u64 = 512;

/// True for the names that DICOM files have.
pub(super) fn is_named_dicom(path: &Path) -> bool {
    matches!(extension(path).as_str(), "dcm" | "dicom" | "ima")
}

/// True if a folder, or one in it, holds a DICOM file.
pub(super) fn holds_dicom_files(folder: &Path) -> bool {
    scan::holds_dicom(folder)
}

/// Reads one file, which the caller has counted, or those that a DICOMDIR names. `series` chooses by UID, number or
/// description.
pub(super) fn read(
    files: &mut Files,
    bytes: &[u8],
    series: Option<&str>,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    let opened = set::open(bytes, true)?;
    let parsed = opened.parse()?;
    if parsed.pixels.is_none() && parsed.set.has(tags::DIRECTORY_RECORDS) {
        let scans = scan::scan_directory(&parsed.set, files, warnings)?;
        return assemble(files, &scans, None, series, "DICOMDIR of ", warnings);
    }
    drop(parsed);
    let scan = scan::scan_file(files.name, bytes)?;
    assemble(files, &[scan], Some(bytes), series, "", warnings)
}

/// Reads the folder that `files` names. `series` chooses by UID, number or description.
pub(super) fn read_folder(
    files: &mut Files,
    series: Option<&str>,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    let scans = scan::scan_folder(files.name, warnings)?;
    assemble(files, &scans, None, series, "folder of ", warnings)
}

/// Makes the volume of the chosen series; `whole` holds the bytes of the only file, if there is only one.
fn assemble(
    files: &mut Files,
    scans: &[Scan],
    whole: Option<&[u8]>,
    wanted: Option<&str>,
    prefix: &str,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    let (series, slices) = series::choose(scans, wanted, warnings)?;
    let mut facts = Facts::default();
    describe(&series, &mut facts);
    let first = &scans[slices[0].scan].image;
    facts.add("transfer syntax", first.syntax.name);
    let Grid { slices, mixes, affine } = stack::arrange(slices, scans, &mut facts, warnings)?;
    let layout = first.layout;
    let per_slice = layout.pixels();

    let mut samples = zeroed(layout.sample, checked_count(scans, &slices, per_slice)?)?;
    let slots = as_bytes_mut(&mut samples).chunks_exact_mut(per_slice * layout.sample.bytes());
    decode(files, scans, whole, &slices, slots.collect())?;

    let mut meanings: Vec<Meaning> = slices
        .iter()
        .map(|&s| Meaning { scaling: s.of(scans).scaling, padding: scans[s.scan].image.padding })
        .collect();
    values::turn(&mut samples, &layout, &mut meanings, warnings);
    let (mut samples, scaling) = values::unify(samples, per_slice, &meanings, warnings)?;
    if layout.components > 1 {
        warnings.say("the luminance of colours is taken");
    }
    let mut depth = slices.len();
    if !mixes.is_empty() {
        samples = values::mix(&samples, per_slice, &mixes)?;
        depth = mixes.len();
    }
    let format = format!("{prefix}DICOM, {}", first.syntax.name);
    Ok(Found { dims: [layout.columns, layout.rows, depth], samples, scaling, affine, format, facts })
}

fn describe(series: &Series, facts: &mut Facts) {
    facts.add("modality", &series.modality);
    facts.add("description", &series.description);
    facts.add("series", &series.number);
    facts.add("series UID", &series.uid);
    facts.add("manufacturer", &series.manufacturer);
}

/// The samples of all slices, if the files can hold so many.
fn checked_count(scans: &[Scan], slices: &[Slice], per_slice: usize) -> Result<usize, ReadErrorKind> {
    let Image { layout, .. } = &scans[slices[0].scan].image;
    let too_large = |count: u64| ReadErrorKind::TooLarge(format!("declares {count} samples"));
    let count = (per_slice as u64).saturating_mul(slices.len() as u64);
    // What native pixels need was found to be there.
    let packed = slices.iter().any(|s| scans[s.scan].image.syntax.codec != Codec::Native);
    if packed {
        let mut read: Vec<usize> = slices.iter().map(|s| s.scan).collect();
        read.sort_unstable();
        read.dedup();
        let length = read.iter().fold(0u64, |n, &i| n.saturating_add(scans[i].length));
        let limit = |ratio: u64, smallest: u64| length.saturating_mul(ratio).max(smallest);
        let decoded = (layout.samples() * layout.sample.bytes() as u64).saturating_mul(slices.len() as u64);
        let decoder = slices.iter().map(|s| scans[s.scan].image.syntax.codec.bytes_per_sample()).max();
        // As many frames as files are decoded at one time, or about so many.
        let taken = layout.samples() * slices.len().min(BATCH) as u64 * decoder.unwrap_or(0);
        if decoded > limit(RATIO_LIMIT, SMALLEST_LIMIT)
            || taken > limit(DECODER_RATIO_LIMIT, SMALLEST_DECODER_LIMIT)
        {
            return Err(ReadErrorKind::TooLarge(format!(
                "declares {decoded} bytes of DICOM pixels, many times the size of its files"
            )));
        }
    }
    usize::try_from(count).map_err(|_| too_large(count))
}

/// One file to read and which of its frames go where.
struct Job<'a, 'b> {
    scan: &'a Scan,
    frames: Vec<(usize, &'b mut [u8])>,
}

/// Decodes every slice into its slot, some files at a time.
fn decode(
    files: &mut Files,
    scans: &[Scan],
    whole: Option<&[u8]>,
    slices: &[Slice],
    slots: Vec<&mut [u8]>,
) -> Result<(), ReadErrorKind> {
    // Files in the order of their first slice.
    let mut jobs: Vec<Job> = Vec::new();
    let mut job_of = std::collections::HashMap::new();
    for (slice, slot) in slices.iter().zip(slots) {
        let index = *job_of.entry(slice.scan).or_insert(jobs.len());
        if index == jobs.len() {
            jobs.push(Job { scan: &scans[slice.scan], frames: Vec::new() });
        }
        jobs[index].frames.push((slice.frame, slot));
    }
    for batch in jobs.chunks_mut(BATCH) {
        let mut read = Vec::with_capacity(batch.len());
        for job in batch.iter() {
            read.push(match whole {
                Some(bytes) => Cow::Borrowed(bytes),
                None => Cow::Owned(files.open(&job.scan.path)?),
            });
        }
        // In order, whichever thread is the first to fail.
        let results: Vec<_> =
            batch.par_iter_mut().zip(&read).map(|(job, bytes)| decode_file(job, bytes)).collect();
        for (result, job) in results.into_iter().zip(batch.iter()) {
            if whole.is_some() {
                result?;
            } else {
                in_file(&job.scan.path, result)?;
            }
        }
    }
    Ok(())
}

fn decode_file(job: &mut Job, bytes: &[u8]) -> Result<(), ReadErrorKind> {
    let opened = set::open(bytes, true)?;
    let parsed = opened.parse()?;
    let image = &job.scan.image;
    let changed = || ReadErrorKind::Refused("changed while it was read".into());
    let element = parsed.pixels.filter(|_| opened.syntax == image.syntax).ok_or_else(changed)?;
    let pixels = Pixels::of(&opened.bytes, element, image.syntax, image.layout, image.frames.len())?;
    let results: Vec<_> =
        job.frames.par_iter_mut().map(|(frame, slot)| pixels.decode(*frame, slot)).collect();
    results.into_iter().collect()
}
