//! What ImageJ and OME say of a stack in its description: which page is which, and where the voxels lie.

use dotwork_drawing::Warnings;
use dotwork_volume::{Affine, Space, Unit};
use glam::DVec3;

use crate::error::ReadErrorKind;
use crate::volume::facts::Facts;
use crate::volume::grid::{self, converted, unit_named, usable_spacing};
use crate::volume::tiff::directory::{Directory, Tag, Tiff};
use crate::volume::tiff::page::{Compression, Page};

/// Who wrote the description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Writer {
    ImageJ,
    Ome,
    Other,
}

/// The description of the first page.
#[derive(Debug)]
pub(super) struct Description {
    writer: Writer,
    text: String,
    software: String,
    /// Distances of pixels by the resolution tags, in the unit that the description names.
    pixel: [Option<f64>; 2],
}

impl Description {
    pub(super) fn of(tiff: &Tiff, directory: &Directory) -> Result<Self, ReadErrorKind> {
        let text = tiff.text(directory, Tag::Description);
        let writer = if text.starts_with("ImageJ=") {
            Writer::ImageJ
        } else if text.trim_start().starts_with('<') && text.contains("<OME") {
            Writer::Ome
        } else {
            Writer::Other
        };
        let pixel = [Tag::XResolution, Tag::YResolution]
            .map(|tag| tiff.fraction(directory, tag).filter(|&r| r > 0.0).map(|r| 1.0 / r));
        Ok(Description { writer, text, software: tiff.text(directory, Tag::Software), pixel })
    }

    /// The value of `key=value` on a line of its own.
    fn imagej(&self, key: &str) -> Option<&str> {
        self.text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('=')).map(str::trim)
    }

    /// The value of the first `key="value"`.
    fn ome(&self, key: &str) -> Option<&str> {
        self.text.match_indices(key).find_map(|(at, _)| {
            let before = self.text[..at].chars().next_back()?;
            let after = self.text[at + key.len()..].strip_prefix("=\"")?;
            before.is_whitespace().then(|| after.split('"').next())?
        })
    }

    fn count(&self, imagej: &str, ome: &str) -> usize {
        let text = match self.writer {
            Writer::ImageJ => self.imagej(imagej),
            Writer::Ome => self.ome(ome),
            Writer::Other => None,
        };
        text.and_then(|t| t.parse().ok()).filter(|&n| n > 0).unwrap_or(1)
    }

    /// How many slices lie behind the single page of a large ImageJ stack.
    pub(super) fn slices_of_one_page(&self, pages: &[Page]) -> Option<usize> {
        let [page] = pages else { return None };
        let plain = page.compression == Compression::None && page.components == 1 && !page.tiled;
        let images = self.count("images", "");
        // Where the directory follows the samples, other slices do not.
        let slice = (page.width as u64).saturating_mul((page.height * page.sample.bytes()) as u64);
        let start = page.first_offset();
        let block = start..start.saturating_add(slice.saturating_mul(images as u64));
        (self.writer == Writer::ImageJ && plain && !block.contains(&(page.at as u64))).then_some(images)
    }

    /// Which of `pages` pages of `components` samples a pixel are the slices of the first channel and frame.
    pub(super) fn choose(&self, pages: usize, components: usize, warnings: &mut Warnings) -> Vec<usize> {
        let mut channels = self.count("channels", "SizeC");
        if self.writer == Writer::Ome && channels.is_multiple_of(components) {
            // OME counts the colours of a pixel as channels, which share a page.
            channels /= components;
        }
        let frames = self.count("frames", "SizeT");
        let images = if self.writer == Writer::ImageJ { self.count("images", "") } else { 1 };
        if images > pages {
            warnings.say(format!("the description declares {images} images, but the file holds {pages}"));
        }
        let slices = match self.writer {
            Writer::ImageJ => pages / channels.saturating_mul(frames).max(1),
            _ => self.count("slices", "SizeZ"),
        };
        if self.writer == Writer::Other || channels == 1 && frames == 1 {
            return (0..pages).collect();
        }
        if channels.checked_mul(frames).and_then(|n| n.checked_mul(slices)) != Some(pages) {
            warnings.say(format!(
                "{pages} pages are not the {channels} channels and {frames} frames declared: all are taken as slices"
            ));
            return (0..pages).collect();
        }
        // Of two neighbours in the order, the earlier one runs faster.
        let order = if self.writer == Writer::Ome { self.ome("DimensionOrder") } else { None };
        let order = order.unwrap_or("XYCZT");
        let mut stride = 1;
        for axis in order.chars() {
            match axis {
                'Z' => break,
                'C' => stride *= channels,
                'T' => stride *= frames,
                _ => {}
            }
        }
        if channels > 1 {
            warnings.say(format!("the first of {channels} channels is taken"));
        }
        if frames > 1 {
            warnings.say(format!("the first of {frames} frames is taken"));
        }
        (0..slices).map(|z| z * stride).filter(|&page| page < pages).collect()
    }

    pub(super) fn add_facts(&self, facts: &mut Facts) {
        match self.writer {
            Writer::ImageJ => {
                for key in ["ImageJ", "channels", "slices", "frames", "unit", "spacing"] {
                    facts.add(key, self.imagej(key).unwrap_or_default());
                }
            }
            Writer::Ome => {
                for key in ["DimensionOrder", "SizeC", "SizeZ", "SizeT"] {
                    facts.add(format!("OME {key}"), self.ome(key).unwrap_or_default());
                }
            }
            Writer::Other => facts.add("description", &self.text),
        }
        facts.add("software", &self.software);
    }

    pub(super) fn affine(&self, facts: &mut Facts, warnings: &mut Warnings) -> Affine {
        let (spacing, unit) = match self.writer {
            Writer::ImageJ => self.imagej_spacing(warnings),
            Writer::Ome => self.ome_spacing(warnings),
            Writer::Other => None,
        }
        .unwrap_or_else(|| {
            facts.add("spacing", "not given");
            warnings.say("no spacing in the file: 1 x 1 x 1 assumed");
            ([1.0; 3], Unit::Unknown)
        });
        let steps = [0, 1, 2].map(|i| Some(DVec3::AXES[i] * usable_spacing(spacing[i], i, warnings)));
        grid::affine(steps, DVec3::ZERO, Space::Unknown, unit, warnings)
    }

    fn imagej_spacing(&self, warnings: &mut Warnings) -> Option<([f64; 3], Unit)> {
        let slices = self.imagej("spacing").and_then(|t| t.parse::<f64>().ok()).filter(|s| s.is_finite());
        let unit = self.imagej("unit").filter(|u| !u.is_empty() && !u.eq_ignore_ascii_case("pixel"));
        if slices.is_none() && unit.is_none() {
            return None;
        }
        let [x, y] = self.pixel;
        if x.is_none() || y.is_none() {
            warnings.say("no size of pixels in the file: 1 assumed");
        }
        let (x, y) = (x.unwrap_or(1.0), y.or(x).unwrap_or(1.0));
        // ImageJ itself counts slices downwards in some files: the distance matters.
        let z = slices.map(f64::abs).filter(|&z| z > 0.0).unwrap_or_else(|| {
            warnings.say("no distance of slices in the file: that of pixels assumed");
            x
        });
        let (unit, factor) = unit.and_then(unit_named).unwrap_or((Unit::Unknown, 1.0));
        Some(([x * factor, y * factor, z * factor], unit))
    }

    fn ome_spacing(&self, warnings: &mut Warnings) -> Option<([f64; 3], Unit)> {
        let size = |key: &str| {
            let size: f64 = self.ome(key)?.parse().ok()?;
            // Micrometres, unless it says otherwise.
            let named = match self.ome(&format!("{key}Unit")) {
                None => (Unit::Micrometre, 1.0),
                Some(name) => unit_named(name).unwrap_or((Unit::Unknown, 1.0)),
            };
            (size.is_finite() && size > 0.0).then_some((size, named))
        };
        // The unit of x is that of the world.
        let (x, (unit, factor)) = size("PhysicalSizeX")?;
        let x = x * factor;
        let in_unit = |key: &str| size(key).and_then(|(s, named)| Some(s * converted(named, unit)?));
        let y = in_unit("PhysicalSizeY")?;
        let z = in_unit("PhysicalSizeZ").unwrap_or_else(|| {
            warnings.say("no distance of slices in the file: that of pixels assumed");
            x
        });
        Some(([x, y, z], unit))
    }
}
