//! JPEG-LS (ISO/IEC 14495-1, which is ITU-T T.87), lossless and near-lossless.
//!
//! Of our own: the decoders on offer know one component and no restart intervals (`pure_jpegls` 2.0), or share the
//! state of a run among the lines of several components (`dicom-toolkit-codec` 0.5). This one reads any interleaving,
//! presets and restart intervals; mapping tables (palettes), point transforms and the colour transforms of HP are
//! refused by name.
//!
//! Besides the samples it takes two lines of each component and 367 contexts. Each byte is looked at a few times and
//! each sample is made once, so that a stream cannot take more memory or time than its size, which was checked, allows.

mod coder;

use crate::volume::dicom::codec::{Damage, check, put_at};
use crate::volume::dicom::image::Layout;
use crate::volume::dicom::jpeg_ls::coder::{Coder, Parameters, Preset};

/// What a stream says of all its scans.
#[derive(Default)]
struct Header {
    /// The names of the components, in the order of the samples of a pixel; empty before the frame header.
    components: Vec<u8>,
    precision: u32,
    preset: Preset,
    /// Lines after which coding starts anew; 0 for never.
    interval: usize,
}

/// Unpacks a JPEG-LS frame, samples of a pixel side by side.
///
/// # Errors
/// Data that end early, that are damaged, that declare another size than `layout`, or that need something that is not
/// read.
pub(super) fn jpeg_ls(data: &[u8], layout: &Layout, out: &mut [u8]) -> Result<(), Damage> {
    let mut at = 2;
    if !data.starts_with(b"\xff\xd8") {
        return Err("JPEG-LS data without their mark".into());
    }
    let mut header = Header::default();
    let mut decoded = vec![false; layout.components];
    while decoded.contains(&false) {
        let marker = marker(data, &mut at)?;
        let segment = segment(data, &mut at)?;
        match marker {
            0xf7 => header.frame(segment, layout)?,
            0xf8 => header.parameters(segment)?,
            // Two to four bytes.
            0xdd => {
                header.interval = segment.iter().take(4).fold(0, |n, &b| n << 8 | usize::from(b));
            }
            0xda => {
                let scan = Scan::of(segment, &header)?;
                for &component in &scan.components {
                    if std::mem::replace(&mut decoded[component], true) {
                        return Err("JPEG-LS data with a component twice".into());
                    }
                }
                scan.decode(data, &mut at, header.interval, layout, out)?;
            }
            0xe8 if segment.starts_with(b"mrfx") && segment.get(4) != Some(&0) => {
                return Err("JPEG-LS with a colour transform, which is not read".into());
            }
            // Other frame headers: JPEG, JPEG-LS extended.
            0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf | 0xf9 => {
                return Err(format!("JPEG of another kind (marker {marker:02x}) where JPEG-LS is declared"));
            }
            // Comments, data of applications.
            _ => {}
        }
    }
    Ok(())
}

fn early() -> Damage {
    "the JPEG-LS data end too early".into()
}

/// Steps over a marker and says which; one that ends the data is none.
fn marker(data: &[u8], at: &mut usize) -> Result<u8, Damage> {
    let rest = data.get(*at..).unwrap_or_default();
    // A marker may have more than one 0xff before it.
    let fill = rest.iter().take_while(|&&b| b == 0xff).count();
    let &code = rest.get(fill).ok_or_else(early)?;
    if fill == 0 || code < 0x80 {
        return Err("JPEG-LS data with something else where a marker belongs".into());
    }
    if code == 0xd9 {
        return Err(early());
    }
    *at += fill + 1;
    Ok(code)
}

/// Steps over the segment of a marker; its bytes after the length.
fn segment<'a>(data: &'a [u8], at: &mut usize) -> Result<&'a [u8], Damage> {
    let length = data.get(*at..).and_then(|d| d.first_chunk::<2>()).ok_or_else(early)?;
    let length = usize::from(u16::from_be_bytes(*length));
    let segment = data[*at..].get(2..length.max(2)).ok_or_else(early)?;
    *at += length.max(2);
    Ok(segment)
}

/// Steps to the next marker; the bytes before it. In coded bytes the first bit after 0xff is 0.
fn coded<'a>(data: &'a [u8], at: &mut usize) -> &'a [u8] {
    let rest = &data[*at..];
    let length = rest.windows(2).position(|w| w[0] == 0xff && w[1] >= 0x80).unwrap_or(rest.len());
    *at += length;
    &rest[..length]
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk::<2>().map(|b| u16::from_be_bytes(*b))
}

impl Header {
    /// Reads the frame header, which must declare what the data set declares.
    fn frame(&mut self, segment: &[u8], layout: &Layout) -> Result<(), Damage> {
        let (Some(&precision), Some(rows), Some(columns), Some(&count)) =
            (segment.first(), word(segment, 1), word(segment, 3), segment.get(5))
        else {
            return Err(early());
        };
        check(layout, [columns.into(), rows.into()], count.into(), "JPEG-LS")?;
        let precision = u32::from(precision);
        // Encoders write more bits than are stored, or as few as the samples need. Where the sign is in fewer bits than
        // are stored is told nowhere.
        let fewest = if layout.is_signed() { layout.stored } else { 2 };
        if precision < fewest || precision > layout.allocated.min(16) {
            return Err(format!(
                "JPEG-LS data of {precision} bits, where {} of {} are declared",
                layout.stored, layout.allocated
            ));
        }
        let components = segment.get(6..6 + 3 * layout.components).ok_or_else(early)?.as_chunks::<3>().0;
        if components.iter().any(|c| c[1] != components[0][1]) {
            return Err("JPEG-LS with components of different resolution, which is not read".into());
        }
        self.components = components.iter().map(|c| c[0]).collect();
        self.precision = precision;
        Ok(())
    }

    /// Reads presets of parameters (T.87, C.2.4).
    fn parameters(&mut self, segment: &[u8]) -> Result<(), Damage> {
        match segment.first() {
            Some(1) => {
                let number = |i: usize| word(segment, 1 + 2 * i).map(i32::from).ok_or_else(early);
                self.preset = Preset {
                    most: number(0)?,
                    thresholds: [number(1)?, number(2)?, number(3)?],
                    reset: number(4)?,
                };
                Ok(())
            }
            // Mapping tables, which only count if a scan names them.
            Some(2 | 3) => Ok(()),
            _ => Err("JPEG-LS with parameters of a kind that is not read".into()),
        }
    }
}

/// A scan: one component, or all of them interleaved.
struct Scan {
    /// Which samples of a pixel.
    components: Vec<usize>,
    /// Pixel by pixel, rather than line by line.
    by_pixel: bool,
    parameters: Parameters,
}

impl Scan {
    fn of(segment: &[u8], header: &Header) -> Result<Scan, Damage> {
        let count = usize::from(*segment.first().ok_or_else(early)?);
        let names = segment.get(1..1 + 2 * count).ok_or_else(early)?.as_chunks::<2>().0;
        let &[near, interleaving, transform, ..] = &segment[1 + 2 * count..] else { return Err(early()) };
        if header.components.is_empty() {
            return Err("JPEG-LS data without a header".into());
        }
        let place = |name: &[u8; 2]| header.components.iter().position(|c| *c == name[0]);
        let components: Option<Vec<usize>> = names.iter().map(place).collect();
        let components =
            components.filter(|c| !c.is_empty() && (c.len() == 1 || matches!(interleaving, 1 | 2)));
        let components = components.ok_or("JPEG-LS data with a scan of unknown components")?;
        if names.iter().any(|n| n[1] != 0) {
            return Err("JPEG-LS with a mapping table, which is not read".into());
        }
        if transform != 0 {
            return Err("JPEG-LS with a point transform, which is not read".into());
        }
        let by_pixel = components.len() > 1 && interleaving == 2;
        let parameters = Parameters::of(header.precision, &header.preset, near.into())?;
        Ok(Scan { components, by_pixel, parameters })
    }

    /// Decodes the bytes at `at`, which moves behind them.
    fn decode(
        &self,
        data: &[u8],
        at: &mut usize,
        interval: usize,
        layout: &Layout,
        out: &mut [u8],
    ) -> Result<(), Damage> {
        let count = self.components.len();
        let width = layout.columns;
        let bytes = layout.sample.bytes();
        // Samples of a line with their neighbours beyond its ends, first those of the line above.
        let empty = || vec![vec![0i32; width + 2]; count];
        let (mut above, mut lines) = (empty(), empty());
        let mut runs = vec![0; count];
        let mut coder = Coder::new(coded(data, at), &self.parameters);
        for row in 0..layout.rows {
            if interval > 0 && row > 0 && row % interval == 0 {
                let number = (row / interval - 1) % 8;
                if marker(data, at)? != 0xd0 + number as u8 {
                    return Err("JPEG-LS data without a restart marker where one belongs".into());
                }
                coder = Coder::new(coded(data, at), &self.parameters);
                above = empty();
                lines = empty();
                runs.fill(0);
            }
            for (above, line) in above.iter().zip(&mut lines) {
                line[0] = above[1];
            }
            if self.by_pixel {
                coder.pixels(&above, &mut lines, &mut runs[0])?;
            } else {
                for ((above, line), run) in above.iter().zip(&mut lines).zip(&mut runs) {
                    coder.line(above, line, run)?;
                }
            }
            for (line, &component) in lines.iter_mut().zip(&self.components) {
                line[width + 1] = line[width];
                let first = row * width * layout.components + component;
                let places = (first..).step_by(layout.components);
                for (place, &sample) in places.zip(&line[1..=width]) {
                    put_at(out, bytes, place, sample.into());
                }
            }
            std::mem::swap(&mut above, &mut lines);
        }
        Ok(())
    }
}
