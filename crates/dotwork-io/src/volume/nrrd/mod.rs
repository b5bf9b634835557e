//! NRRD ("nearly raw raster data", versions 1 to 5; Gordon Kindlmann, teem.sourceforge.net/nrrd/format.html).
//!
//! A text header of `field: value` lines ends with a blank line; the samples follow, or lie in files of their own. Up to
//! 16 axes of any meaning are declared; [`axes`] finds the three that are space. The samples come in one of several
//! encodings, after lines and bytes to skip. `byte skip: -1` means that they are the last bytes of the file.

mod axes;
mod header;
mod segments;
mod writer;

pub use writer::write_nrrd;

use dotwork_drawing::Warnings;
use dotwork_volume::Scaling;

use crate::error::ReadErrorKind;
use crate::volume::Found;
use crate::volume::ascii::{read_hex, read_numbers};
use crate::volume::data::{After, Part, Skip, after_samples, pour, product, share};
use crate::volume::files::{Files, in_file, listing};
use crate::volume::fill::Fill;
use crate::volume::nrrd::axes::Plan;
use crate::volume::nrrd::header::{DataFiles, Encoding, Header};
use crate::volume::nrrd::segments::Segments;
use crate::volume::reduce::reduce;
use crate::volume::stream::{Packing, Stream};

pub(super) fn read(files: &mut Files, bytes: &[u8], warnings: &mut Warnings) -> Result<Found, ReadErrorKind> {
    let mut header = header::parse(bytes, warnings)?;
    let plan = axes::plan(&mut header, warnings)?;
    let layers = match plan.reductions.first() {
        Some(r) if r.inner == 1 && axes::is_layers(&header, 0) => r.components,
        _ => 1,
    };
    let segments = Segments::parse(&header.segments, layers, warnings)?;
    let width = header.sample.bytes() as u64;
    let all = product(header.sizes.iter().copied())?;
    let wanted = product(header.sizes[..plan.read_axes].iter().copied())?;
    // Both fit once they fit in bytes.
    let all_bytes = product([all, width])?;
    let mut fill = Fill::new(header.sample, wanted)?;

    match std::mem::take(&mut header.data) {
        DataFiles::Attached => {
            let data = &bytes[header.end..];
            read_part(&mut fill, data, header.end, header.lines, &header, all_bytes, false, warnings)?;
        }
        DataFiles::Named { names, share_axes } => {
            let share = share(&header.sizes, width, names.len() as u64, share_axes)
                .map_err(|reason| ReadErrorKind::at_line(header.data_line, reason))?;
            header.facts.add("data files", listing(&names));
            let many = names.len() > 1;
            for name in &names {
                if fill.missing() == 0 {
                    break;
                }
                let path = files.path(name);
                let data = files.open(&path)?;
                let read = read_part(&mut fill, &data, 0, 1, &header, share, many, warnings);
                in_file(&path, read)?;
            }
        }
    }
    let big_endian = match header.encoding {
        Encoding::Ascii => cfg!(target_endian = "big"),
        _ => header.big_endian.unwrap_or(false),
    };
    let mut samples = fill.finish(big_endian);
    let Plan { dims, reductions, affine, .. } = plan;
    let mut reductions = &reductions[..];
    if let Some(segments) = segments {
        if layers > 1 {
            samples = segments.compose(&samples, layers, warnings)?;
            reductions = &reductions[1..];
        }
        header.facts.labels = Some(segments.table());
    }
    for r in reductions {
        reduce(&mut samples, r.inner, r.components, r.how);
    }
    Ok(Found {
        dims,
        samples,
        scaling: Scaling::default(),
        affine,
        format: header.format(),
        facts: header.facts,
    })
}

/// Takes from one file what is still missing; `declared` bytes of samples should be in it.
fn read_part(
    fill: &mut Fill,
    data: &[u8],
    offset: usize,
    line: u64,
    header: &Header,
    declared: u64,
    many: bool,
    warnings: &mut Warnings,
) -> Result<(), ReadErrorKind> {
    let mut rest = data;
    for _ in 0..header.line_skip {
        let Some(end) = rest.iter().position(|&b| b == b'\n') else {
            return Err(ReadErrorKind::Refused(format!(
                "has fewer lines than the {} to skip before its samples",
                header.line_skip
            )));
        };
        rest = &rest[end + 1..];
    }
    let offset = offset + (data.len() - rest.len());
    let line = line + header.line_skip;
    let wanted = declared.min(fill.missing() as u64);
    let skip = match header.byte_skip {
        -1 => Skip::ToLast,
        n => Skip::Bytes(u64::try_from(n).unwrap_or_default()),
    };
    let packing = match header.encoding {
        Encoding::Packed(packing) => packing,
        Encoding::Ascii | Encoding::Hex => {
            let Skip::Bytes(skip) = skip else {
                return Err(ReadErrorKind::Refused("byte skip -1 goes with binary samples only".into()));
            };
            let skipped = usize::try_from(skip).unwrap_or(usize::MAX).min(rest.len());
            let line = line + rest[..skipped].iter().filter(|&&b| b == b'\n').count() as u64;
            let text = &rest[skipped..];
            let used = if header.encoding == Encoding::Ascii {
                // Samples of whole files: a share is a whole number of samples.
                read_numbers(fill, text, line, wanted as usize / header.sample.bytes())?
            } else {
                read_hex(fill, text, line, wanted as usize)?
            };
            if wanted == declared && !text[used..].trim_ascii().is_empty() {
                warnings.say(after_samples(text.len() - used));
            }
            return Ok(());
        }
    };
    let part = Part { skip, wanted, declared, after: After::NothingElseWrong, one_of_many: many };
    pour(fill, Stream::new(rest, packing), offset, part, warnings)
}

impl Header {
    fn format(&self) -> String {
        let encoding = match self.encoding {
            Encoding::Ascii => "ascii",
            Encoding::Hex => "hex",
            Encoding::Packed(Packing::None) => "raw",
            Encoding::Packed(packing) => packing.name(),
        };
        let order = match (self.sample.bytes(), self.encoding, self.big_endian) {
            (1, ..) | (_, Encoding::Ascii, _) => "",
            (_, _, Some(true)) => ", big endian",
            _ => ", little endian",
        };
        let detached = if self.detached { ", detached" } else { "" };
        format!("NRRD{detached}, {encoding}{order}")
    }
}
