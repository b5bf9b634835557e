//! The samples of one data file: where they begin, whether they are all there, what follows them.

use dotwork_drawing::Warnings;

use crate::error::ReadErrorKind;
use crate::volume::fill::Fill;
use crate::volume::stream::{Packing, Stream};

/// Where samples begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Skip {
    /// After so many (unpacked) bytes.
    Bytes(u64),
    /// So that the last of them is the last byte of the file.
    ToLast,
}

/// What follows the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum After {
    /// Something the caller reads.
    Anything,
    /// Nothing; what is there is said and ignored.
    Nothing,
    /// Nothing, or the sizes are wrong.
    NothingElseWrong,
}

/// How the samples of one file lie in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) skip: Skip,
    /// Bytes to take.
    pub(crate) wanted: u64,
    /// Bytes that the file should hold: more than `wanted` if only its beginning is taken.
    pub(crate) declared: u64,
    pub(crate) after: After,
    /// The rest of the samples come from other files: take memory as they come.
    pub(crate) one_of_many: bool,
}

/// The product of sides.
///
/// # Errors
/// It does not fit 64 bits.
pub(crate) fn product(sides: impl IntoIterator<Item = u64>) -> Result<u64, ReadErrorKind> {
    sides
        .into_iter()
        .try_fold(1, u64::checked_mul)
        .ok_or_else(|| ReadErrorKind::TooLarge("declares more samples than can be counted".into()))
}

/// The product of `sides` and the bytes of a sample.
///
/// # Errors
/// It does not fit 64 bits.
pub(crate) fn byte_count(sides: &[u64], sample_bytes: usize) -> Result<u64, ReadErrorKind> {
    product(sides.iter().copied().chain([sample_bytes as u64]))
}

/// How many bytes of samples each of `count` files holds that share voxels of `voxel_bytes`. `axes` is how many axes
/// the header says a file has; that of all axes says nothing.
///
/// # Errors
/// They cannot share them evenly, or not as the header says; the text says which.
#[cfg(any(feature = "nrrd", feature = "metaimage"))]
pub(crate) fn share(sizes: &[u64], voxel_bytes: u64, count: u64, axes: Option<usize>) -> Result<u64, String> {
    let bytes =
        |sizes: &[u64]| product(sizes.iter().copied().chain([voxel_bytes])).map_err(|e| e.to_string());
    let all = bytes(sizes)?;
    if count == 0 {
        return Err("no data file is named".into());
    }
    let share = all / count;
    if !all.is_multiple_of(count) || !share.is_multiple_of(voxel_bytes) {
        return Err(format!("{count} data files cannot share {all} bytes of samples evenly"));
    }
    if let Some(axes) = axes.filter(|&n| n < sizes.len())
        && bytes(&sizes[..axes])? != share
    {
        return Err(format!("{count} data files of {axes} axes each do not make what the sizes declare"));
    }
    Ok(share)
}

/// Puts one file's samples into `fill`. `offset` is where `stream` began in its file, for messages.
///
/// # Errors
/// Too few bytes, damaged packing, or bytes after the samples where that is an error.
pub(crate) fn pour(
    fill: &mut Fill,
    mut stream: Stream,
    offset: usize,
    part: Part,
    warnings: &mut Warnings,
) -> Result<(), ReadErrorKind> {
    let skip = match part.skip {
        Skip::Bytes(n) => n,
        Skip::ToLast => {
            let there = match stream.plain() {
                Some(rest) => rest.len() as u64,
                None => {
                    let believed = stream.again().believed();
                    let there = stream.again().skip(believed.saturating_add(1))?;
                    if there > believed {
                        return Err(unbelieved(&stream, "they unpack to more than"));
                    }
                    there
                }
            };
            there
                .checked_sub(part.declared)
                .ok_or_else(|| short(fill, &stream, offset, there, part.declared))?
        }
    };
    if skip.checked_add(part.wanted).is_none_or(|end| end > stream.believed()) {
        return Err(match stream.plain() {
            Some(rest) => short(fill, &stream, offset, (rest.len() as u64).saturating_sub(skip), part.wanted),
            None if stream.most().is_none() => unbelieved(&stream, "the header declares more than"),
            None => ReadErrorKind::TooLarge(format!(
                "declares {} bytes of samples, more than its {} data can unpack to",
                part.wanted,
                stream.packing.name()
            )),
        });
    }
    if stream.skip(skip)? < skip {
        return Err(short(fill, &stream, offset, 0, part.wanted));
    }
    if !part.one_of_many && stream.most().is_some() {
        fill.allocate()?;
    }
    let wanted = usize::try_from(part.wanted)
        .map_err(|_| ReadErrorKind::TooLarge(format!("declares {} bytes of samples", part.wanted)))?;
    let taken = fill.take(&mut stream, wanted)?;
    if taken < wanted {
        return Err(short(fill, &stream, offset, taken as u64, part.wanted));
    }
    check_end(stream, part, warnings)
}

/// The refusal of packed data that may hold what is asked for, as hostile files do and real ones hardly ever.
fn unbelieved(stream: &Stream, what: &str) -> ReadErrorKind {
    ReadErrorKind::TooLarge(format!(
        "{} data: {what} {} MiB, many times their size; if that is meant, unpack them first",
        stream.packing.name(),
        stream.again().believed() >> 20
    ))
}

fn check_end(mut stream: Stream, part: Part, warnings: &mut Warnings) -> Result<(), ReadErrorKind> {
    if part.after == After::Anything {
        return Ok(());
    }
    let rest = part.declared - part.wanted;
    if rest > 0 {
        // Packed data after what is wanted are not unpacked to be counted.
        if let Some(there) = stream.plain()
            && (there.len() as u64) < rest
        {
            warnings.say(format!(
                "the data end early: {} of {} bytes are there; what is taken is complete",
                part.wanted + there.len() as u64,
                part.declared
            ));
        }
        return Ok(());
    }
    // Reading on also compares the checksum of packed data.
    let more = match stream.plain() {
        Some(rest) => rest.len(),
        None => stream.read(&mut [0])?,
    };
    if more == 0 {
        return Ok(());
    }
    if part.after == After::NothingElseWrong && stream.packing != Packing::None {
        return Err(ReadErrorKind::Refused(format!(
            "{} data: unpack to more than the {} bytes declared",
            stream.packing.name(),
            part.declared
        )));
    }
    warnings.say(match stream.plain() {
        Some(rest) => after_samples(rest.len()),
        None => format!("more {} data after the samples ignored", stream.packing.name()),
    });
    Ok(())
}

/// The warning of bytes that nobody asked for.
pub(crate) fn after_samples(bytes: usize) -> String {
    format!("{bytes} {} after the samples ignored", if bytes == 1 { "byte" } else { "bytes" })
}

fn short(fill: &Fill, stream: &Stream, offset: usize, there: u64, wanted: u64) -> ReadErrorKind {
    let width = fill.sample.bytes() as u64;
    let reason = format!(
        "the data end too early: {there} of {wanted} bytes are there ({} of {} {} samples)",
        there / width,
        wanted / width,
        fill.sample.name()
    );
    match stream.packing {
        Packing::None => ReadErrorKind::at_byte(offset.saturating_add(stream_length(stream)), reason),
        packing => ReadErrorKind::Refused(format!("{} data: {reason}", packing.name())),
    }
}

fn stream_length(stream: &Stream) -> usize {
    stream.plain().map_or(0, <[u8]>::len).saturating_add(stream.given as usize)
}
