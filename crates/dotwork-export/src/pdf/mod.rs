//! PDF: the page in its physical size, every mark an editable path, each layer of the drawing a layer of the file.
//!
//! PDF 1.7 (ISO 32000-1:2008). Layers are optional content groups named after object, colour and pen; settings travel in
//! the XMP packet. The file holds no date and no random identifier: the same drawing gives the same bytes.

mod content;
mod image;
mod metadata;
mod syntax;

use std::io::{self, Write};

use dotwork_drawing::{Color, Drawing, Image, Layer, Page};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;

use self::content::{Content, Paint, Units, color_operator};
use self::syntax::{Id, Objects, real, text_string};

pub(crate) use self::metadata::is_pdf;
pub use self::metadata::pdf_metadata;

/// Level of deflate. 200,000 dots, 6.4 MB of operators, one core (ms, MB): level 2: 86, 2.10; 4: 135, 2.06; 6: 240,
/// 2.05; 9: 725, 2.01.
const DEFLATE_LEVEL: u32 = 4;

/// Points an inch.
const POINTS_PER_INCH: f64 = 72.0;

/// The longest side that readers take, in units of the page.
const LONGEST_SIDE: f64 = 14_400.0;

/// What a PDF carries besides the picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct PdfOptions<'a> {
    /// The settings that made the drawing, for [`pdf_metadata`].
    pub metadata: Option<&'a str>,
    /// The title of the document.
    pub title: Option<&'a str>,
}

/// Writes a drawing as PDF.
///
/// The page has the drawing's physical size. Paper is a filled rectangle, none if it is white. Dots are lines of no
/// length with round caps, no area off by more than 0.2 %; strokes are open paths with round caps and joins, cut into
/// runs where their width varies. Grey inks are `DeviceGray`, others `DeviceRGB` with the sRGB values. Opacities are
/// chosen so that a viewer shows over bare paper what linear light gives. Marks that are not finite, empty or off the
/// page are left out, and so are pictures without a place or with a wrong number of samples.
///
/// # Errors
/// What the writer refuses; [`io::ErrorKind::InvalidInput`] if the page is none
/// ([`Page::checked`](dotwork_drawing::Page::checked)).
///
/// # Panics
/// If the arrays of a layer's dots or strokes differ in length.
pub fn write_pdf<W: Write>(writer: W, drawing: &Drawing, options: &PdfOptions<'_>) -> io::Result<()> {
    let page = drawing.page.checked().map_err(|e| io::Error::new(io::ErrorKind::InvalidInput, e))?;
    let software = crate::SOFTWARE;
    let mut file = Objects::new(writer)?;
    let [catalog, pages, leaf, info, packet] = std::array::from_fn(|_| file.reserve());
    // First in the file, where whoever looks for the settings finds them at once.
    let xmp = metadata::packet(software, options.title, options.metadata);
    file.stream(packet, "/Type /Metadata /Subtype /XML", xmp.as_bytes())?;

    let sheet = Sheet::of(&page);
    let mut content = Content::new(Units::of(&page));
    let layers = draw(&mut file, &mut content, drawing, &sheet)?;
    let deflated: Vec<Vec<u8>> = content.streams.par_iter().map(|s| deflate(s)).collect();
    let mut contents = String::new();
    for stream in &deflated {
        let id = file.reserve();
        file.stream(id, "/Filter /FlateDecode", stream)?;
        contents.push_str(&format!("{id} 0 R "));
    }
    let Sheet { size, user_unit, .. } = &sheet;
    let user_unit = if *user_unit > 1.0 { format!(" /UserUnit {user_unit}") } else { String::new() };
    let resources = resources(&layers, &content);
    file.object(
        leaf,
        format!(
            "<< /Type /Page /Parent {pages} 0 R /MediaBox [0 0 {size}]{user_unit}\n/Resources << {resources}>>\n\
             /Contents [{contents}] >>"
        ),
    )?;
    file.object(pages, format!("<< /Type /Pages /Kids [{leaf} 0 R] /Count 1 >>"))?;
    let mut about = b"<< ".to_vec();
    if let Some(title) = options.title {
        about.extend_from_slice(b"/Title ");
        text_string(&mut about, title);
        about.push(b' ');
    }
    about.extend_from_slice(format!("/Creator ({software}) /Producer ({software}) >>").as_bytes());
    file.object(info, about)?;
    let optional = optional_content(&layers);
    file.object(
        catalog,
        format!("<< /Type /Catalog /Pages {pages} 0 R /Metadata {packet} 0 R{optional} >>"),
    )?;
    file.finish(catalog, info)
}

/// The page in points, or in larger units.
struct Sheet {
    /// Width and height as operands.
    size: String,
    /// Height as an operand.
    height: String,
    /// Points a unit: sheets of more than five metres exceed [`LONGEST_SIDE`].
    user_unit: f64,
}

impl Sheet {
    fn of(page: &Page) -> Sheet {
        let points = |px: u32| f64::from(px) * POINTS_PER_INCH / f64::from(page.dpi);
        let (width, height) = (points(page.width), points(page.height));
        let user_unit = (width.max(height) / LONGEST_SIDE).ceil().max(1.0);
        let [width, height] = [width, height].map(|side| decimals(side / user_unit, 5));
        Sheet { size: format!("{width} {height}"), height, user_unit }
    }
}

/// A layer in the file: its optional content group, and its picture.
struct Group {
    id: Id,
    picture: Option<Id>,
}

/// Writes the objects of the layers, and paper and marks into `content`.
fn draw<W: Write>(
    file: &mut Objects<W>,
    content: &mut Content,
    drawing: &Drawing,
    sheet: &Sheet,
) -> io::Result<Vec<Group>> {
    let Sheet { size, height, user_unit } = sheet;
    content.operators("q\n");
    if drawing.paper != Color::WHITE {
        content.operators(color_operator(drawing.paper, Paint::Fill));
        content.operators(format!("0 0 {size} re f\n"));
    }
    // From here on the drawing's axes, the origin at the top left.
    let scale = decimals(POINTS_PER_INCH / content.units.per_inch / user_unit, 10);
    content.operators(format!("{scale} 0 0 -{scale} 0 {height} cm\n1 J 1 j\n"));
    let mut layers = Vec::new();
    for (index, layer) in drawing.layers.iter().enumerate() {
        let image = layer.image.as_ref().filter(|image| image.is_drawable());
        if layer.dots.is_empty() && layer.strokes.is_empty() && image.is_none() {
            continue;
        }
        let id = file.reserve();
        let mut name = Vec::new();
        text_string(&mut name, &layer_name(layer, index));
        file.object(id, [b"<< /Type /OCG /Name ", &name[..], b" >>"].concat())?;
        let number = layers.len();
        content.operators(format!("/OC /L{number} BDC\nq\n"));
        let picture = image.map(|image| write_image(file, image, drawing.paper)).transpose()?;
        if let Some(image) = image {
            let [left, top, right, bottom] = image.place;
            content.operators("q ");
            content.length(right - left);
            content.operators("0 0 ");
            content.length(top - bottom);
            content.length(left);
            content.length(bottom);
            content.operators(format!("cm /I{number} Do Q\n"));
        }
        content.marks(layer, drawing.paper, &drawing.page);
        content.operators("Q\nEMC\n");
        layers.push(Group { id, picture });
    }
    content.operators("Q\n");
    content.finish();
    Ok(layers)
}

/// The entries of the page's resources: what the content calls by name.
fn resources(layers: &[Group], content: &Content) -> String {
    let (mut groups, mut pictures, mut states) = (String::new(), String::new(), String::new());
    for (number, Group { id, picture }) in layers.iter().enumerate() {
        groups.push_str(&format!("/L{number} {id} 0 R "));
        if let Some(id) = picture {
            pictures.push_str(&format!("/I{number} {id} 0 R "));
        }
    }
    for &opacity in &content.opacities {
        let value = decimals(f64::from(opacity) / 1000.0, 3);
        states.push_str(&format!("/A{opacity} << /CA {value} >> "));
    }
    let kinds = [("Properties", groups), ("XObject", pictures), ("ExtGState", states)];
    let full = kinds.into_iter().filter(|(_, entries)| !entries.is_empty());
    full.map(|(kind, entries)| format!("/{kind} << {entries}>> ")).collect()
}

/// The entry of the catalog that lists the layers.
fn optional_content(layers: &[Group]) -> String {
    if layers.is_empty() {
        return String::new();
    }
    let list = |group: &Group| format!("{} 0 R ", group.id);
    let groups: String = layers.iter().map(list).collect();
    // Panels list the topmost layer first.
    let order: String = layers.iter().rev().map(list).collect();
    format!("\n/OCProperties << /OCGs [{groups}] /D << /Name (Layers) /Order [{order}] >> >>")
}

fn write_image<W: Write>(file: &mut Objects<W>, image: &Image, paper: Color) -> io::Result<Id> {
    let samples = crate::samples::encode(image, paper);
    let mut write = |channels: usize, bytes: &[u8], mask: Option<Id>| -> io::Result<Id> {
        let id = file.reserve();
        let space = if channels == 1 { "DeviceGray" } else { "DeviceRGB" };
        let (width, height) = (image.width, image.height);
        let mask = mask.map(|id| format!("/SMask {id} 0 R ")).unwrap_or_default();
        let entries = format!(
            "/Type /XObject /Subtype /Image /Width {width} /Height {height} /ColorSpace /{space} \
             /BitsPerComponent 8 {mask}/Filter /FlateDecode \
             /DecodeParms << /Predictor 15 /Colors {channels} /BitsPerComponent 8 /Columns {width} >>"
        );
        file.stream(id, &entries, &deflate(&image::filtered(bytes, width as usize * channels)))?;
        Ok(id)
    };
    let mask = samples.mask.as_deref().map(|mask| write(1, mask, None)).transpose()?;
    write(samples.channels, &samples.colors, mask)
}

/// What the layer is called: object, colour, pen.
fn layer_name(layer: &Layer, index: usize) -> String {
    let mut name =
        if layer.object.is_empty() { format!("layer {}", index + 1) } else { layer.object.clone() };
    name.push_str(&format!(", {}", layer.color));
    if let Some(pen) = layer.pen_mm {
        name.push_str(&format!(", {pen} mm"));
    }
    name
}

fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut zlib = ZlibEncoder::new(Vec::with_capacity(bytes.len() / 2), Compression::new(DEFLATE_LEVEL));
    // A vector takes everything.
    let _ = zlib.write_all(bytes);
    zlib.finish().unwrap_or_default()
}

/// A number rounded to at most `places` decimals.
fn decimals(v: f64, places: u32) -> String {
    let mut out = Vec::new();
    real(&mut out, v, places);
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests;
