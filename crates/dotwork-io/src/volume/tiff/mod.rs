//! TIFF 6.0 and BigTIFF: a file of one or several pages as slices of a volume.
//!
//! The pages of scientific stacks are few of the things that TIFF can be: strips or tiles of 8- to 64-bit integers or
//! 32- and 64-bit floats, plain, LZW, deflate or PackBits, with or without prediction. They are decoded here, straight
//! into the samples: the crate `tiff` 0.11 panics on planar tiles, well-formed ones too (an assertion), and in debug
//! builds on sizes whose product overflows.
//!
//! TIFF has no slice distance, and its resolution is about print: only what ImageJ or OME wrote counts as spacing.

mod decode;
mod describe;
mod directory;
mod page;

use dotwork_drawing::Warnings;
use dotwork_volume::{Affine, SampleType, Samples, Scaling, with_samples};

use crate::error::ReadErrorKind;
use crate::volume::Found;
use crate::volume::data::byte_count;
use crate::volume::facts::Facts;
use crate::volume::fill::{Fill, as_bytes_mut, zeroed};
use crate::volume::reduce::{Reduction, reduce};
use crate::volume::tiff::describe::Description;
use crate::volume::tiff::directory::Tiff;
use crate::volume::tiff::page::{Color, Page};

/// How the pages of a volume are alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) sample: SampleType,
    components: usize,
    how: Reduction,
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} x {} {}", self.width, self.height, self.sample.name())?;
        if self.components > 1 {
            write!(f, " of {} components", self.components)?;
        }
        Ok(())
    }
}

/// The pages of a file, their headers read and checked.
pub(super) struct Pages<'a> {
    tiff: Tiff<'a>,
    pages: Vec<Page>,
    pub(super) kind: Kind,
    description: Description,
}

impl<'a> Pages<'a> {
    /// Reads the directories of a file. Thumbnails are left out.
    pub(super) fn of(bytes: &'a [u8], warnings: &mut Warnings) -> Result<Self, ReadErrorKind> {
        let tiff = Tiff::new(bytes)?;
        let directories = tiff.directories()?;
        let description = Description::of(&tiff, &directories[0])?;
        let mut pages = Vec::new();
        let mut thumbnails = 0;
        // Pages that share bytes would make a small file large.
        let mut budget = bytes.len() as u64;
        for directory in &directories {
            if tiff.is_thumbnail(directory)? {
                thumbnails += 1;
                continue;
            }
            let page = Page::of(&tiff, directory)?;
            budget = budget.checked_sub(page.packed_bytes()).ok_or_else(|| {
                ReadErrorKind::at_byte(directory.at, "its pages declare more data than the file holds")
            })?;
            pages.push(page);
        }
        if thumbnails > 0 {
            warnings.say(format!("{thumbnails} pages of reduced size left out"));
        }
        let Some(first) = pages.first() else {
            return Err(ReadErrorKind::Refused("holds thumbnails only".into()));
        };
        let kind = kind(first);
        if let Some((i, other)) = pages.iter().enumerate().find(|(_, p)| self::kind(p) != kind) {
            return Err(ReadErrorKind::at_byte(
                other.at,
                format!("page {} is {}, page 1 is {kind}", i + 1, self::kind(other)),
            ));
        }
        Ok(Pages { tiff, pages, kind, description })
    }

    /// How many pages there are, with those that ImageJ leaves out of the chain.
    pub(super) fn slices(&self) -> usize {
        self.description.slices_of_one_page(&self.pages).unwrap_or(self.pages.len())
    }

    /// Appends a page to `fill`.
    pub(super) fn decode(
        &self,
        index: usize,
        fill: &mut Fill,
        scratch: &mut Vec<u8>,
    ) -> Result<(), ReadErrorKind> {
        let page = &self.pages[index];
        let Kind { width, height, sample, components, how } = self.kind;
        let bytes = byte_count(&[width as u64, height as u64, components as u64], sample.bytes())?;
        if components == 1 {
            return decode::page(&self.tiff, page, fill.room(bytes as usize)?, scratch);
        }
        let mut whole = zeroed(sample, bytes as usize / sample.bytes())?;
        decode::page(&self.tiff, page, as_bytes_mut(&mut whole), scratch)?;
        reduce(&mut whole, 1, components, how);
        append(fill, &mut whole)
    }

    /// Says what is worth knowing of the first page.
    pub(super) fn describe(&self, facts: &mut Facts, warnings: &mut Warnings) {
        let first = &self.pages[0];
        match first.color {
            Color::Gray => {}
            Color::WhiteIsZero => {
                warnings.say("the file says that 0 is white: the samples are taken as they are stored");
            }
            Color::Rgb => warnings.say("RGB samples: their luminance (Rec. 709) is taken"),
            Color::Palette => warnings.say("palette colours: their indices are taken"),
        }
        if first.orientation != 1 {
            let code = first.orientation;
            warnings.say(format!(
                "the file says that its pages are turned (orientation {code}): taken as stored"
            ));
        }
        if self.kind.components > 1 && self.kind.how == Reduction::First {
            warnings.say(format!("{} values a pixel: the first is taken", self.kind.components));
        }
        self.description.add_facts(facts);
    }

    /// Where the voxels lie, as far as the file says.
    pub(super) fn affine(&self, facts: &mut Facts, warnings: &mut Warnings) -> Affine {
        self.description.affine(facts, warnings)
    }

    /// "TIFF, deflate" and the like.
    pub(super) fn format(&self) -> String {
        let mut text = String::from(if self.tiff.big { "BigTIFF" } else { "TIFF" });
        text.push_str(", ");
        text.push_str(self.pages[0].compression.name());
        if self.kind.sample.bytes() > 1 && self.tiff.big_endian {
            text.push_str(", big endian");
        }
        text
    }
}

fn kind(page: &Page) -> Kind {
    let how = if page.color == Color::Rgb { Reduction::Luminance } else { Reduction::First };
    let Page { width, height, sample, components, .. } = *page;
    Kind { width, height, sample, components, how }
}

fn append(fill: &mut Fill, samples: &mut Samples) -> Result<(), ReadErrorKind> {
    let bytes = with_samples!(&*samples, v => v.len()) * fill.sample.bytes();
    fill.room(bytes)?.copy_from_slice(as_bytes_mut(samples));
    Ok(())
}

/// Reads the pages of one file as slices.
pub(super) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<Found, ReadErrorKind> {
    let pages = Pages::of(bytes, warnings)?;
    let mut facts = Facts::default();
    if pages.slices() > pages.pages.len() {
        return read_imagej_block(bytes, &pages, pages.slices(), warnings);
    }
    facts.add("pages", pages.pages.len().to_string());
    pages.describe(&mut facts, warnings);
    let Kind { width, height, sample, components, .. } = pages.kind;
    let chosen = pages.description.choose(pages.pages.len(), components, warnings);
    let count = byte_count(&[width as u64, height as u64, chosen.len() as u64], 1)?;
    let mut fill = Fill::new(sample, count)?;
    // Each page's strips were found long enough to hold what it declares.
    fill.allocate()?;
    let mut scratch = Vec::new();
    for &index in &chosen {
        pages.decode(index, &mut fill, &mut scratch)?;
    }
    let affine = pages.affine(&mut facts, warnings);
    Ok(Found {
        dims: [width, height, chosen.len()],
        samples: fill.finish(cfg!(target_endian = "big")),
        scaling: Scaling::default(),
        affine,
        format: pages.format(),
        facts,
    })
}

/// ImageJ writes large stacks as one page, behind whose samples those of the other slices follow.
fn read_imagej_block(
    bytes: &[u8],
    pages: &Pages,
    images: usize,
    warnings: &mut Warnings,
) -> Result<Found, ReadErrorKind> {
    let mut facts = Facts::default();
    facts.add("pages", format!("1, followed by {} slices without pages of their own", images - 1));
    pages.describe(&mut facts, warnings);
    let Kind { width, height, sample, components, .. } = pages.kind;
    // The page's own samples were found to be there, so that this is a length in memory.
    let slice = byte_count(&[width as u64, height as u64], sample.bytes())? as usize;
    let start = pages.pages[0].first_offset();
    let data = usize::try_from(start).ok().and_then(|s| bytes.get(s..)).unwrap_or_default();
    // The number is checked before a list of so many is made.
    if images > data.len() / slice {
        let cut = data.len() / slice + 1;
        return Err(ReadErrorKind::at_byte(
            bytes.len(),
            format!("the file ends within slice {cut} of the {images} its description declares"),
        ));
    }
    let chosen = pages.description.choose(images, components, warnings);
    let mut fill = Fill::new(sample, byte_count(&[width as u64, height as u64, chosen.len() as u64], 1)?)?;
    fill.allocate()?;
    for &index in &chosen {
        fill.room(slice)?.copy_from_slice(&data[index * slice..][..slice]);
    }
    let affine = pages.affine(&mut facts, warnings);
    Ok(Found {
        dims: [width, height, chosen.len()],
        samples: fill.finish(pages.tiff.big_endian),
        scaling: Scaling::default(),
        affine,
        format: pages.format(),
        facts,
    })
}
