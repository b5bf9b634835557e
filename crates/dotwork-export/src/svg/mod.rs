//! The drawing as SVG: millimetres, layers, and few elements.
//!
//! Page, places and sizes are in millimetres with at most 3 decimals. Each layer is a group that Inkscape shows as a
//! layer, named after object, colour and pen. A layer's dots are round-cap subpaths of no length, gathered in one path
//! for each width: browsers and Inkscape choke on some 20,000 elements, and a path of 10,000 dots is one. Strokes are
//! open paths without fill whose `class` is their kind. Images are embedded. `<metadata>` holds the settings.
//!
//! What programs make of a dot of no length (`M2 5h0`, round caps): resvg 0.49, librsvg 2.54 and Inkscape 1.2 draw it
//! as the specification says; vpype 1.15 drops it. All four keep a line of 1 µm and a circle, but vpype makes of a
//! circle a polygon which the pen would draw round. So files for the eye have dots of no length, and
//! files for the plotter ticks of 1 µm ([`Touch`]).

mod dots;
mod image;
mod metadata;
mod strokes;

use std::io::{self, Write};

use dotwork_drawing::{Color, Drawing, Layer};

pub use self::metadata::svg_metadata;

use self::metadata::{ELEMENT, NAMESPACE};
use crate::SOFTWARE;
use crate::text::TextWriter;
use crate::xml::escaped;

/// How a dot is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Touch {
    /// A round-cap subpath of no length, `M2 5h0`: exactly a disc. Some plotter programs drop it.
    #[default]
    Dot,
    /// A round-cap line of 1 µm, `M2 5h0.001`: every program keeps it, and the pen touches once.
    Tick,
    /// A filled `<circle>`: for programs that know no caps. An element a dot: slow to open beyond 20,000 dots, and a
    /// plotter draws its outline.
    Circle,
}

/// What an SVG holds besides the marks; by default nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct SvgOptions<'a> {
    /// The settings that made the drawing, any text; [`svg_metadata`] reads them back. Characters that XML cannot
    /// hold are replaced by U+FFFD.
    pub metadata: Option<&'a str>,
    /// The title of the document.
    pub title: Option<&'a str>,
    /// How dots are written.
    pub touch: Touch,
    /// For a pen plotter: layers are numbered, marks keep their order (see [`crate::plot`]), all marks of a layer have
    /// its pen's width (without a pen the dots their mean, and each stroke its own) and full strength, no stroke is
    /// cut where its width changes, and paper and images are left out.
    pub plotter: bool,
}

impl<'a> SvgOptions<'a> {
    /// For a pen plotter: [`plotter`](SvgOptions::plotter), and dots as [`Touch::Tick`].
    pub fn for_plotter() -> SvgOptions<'a> {
        SvgOptions { touch: Touch::Tick, plotter: true, ..SvgOptions::default() }
    }
}

/// Writes a drawing as SVG.
///
/// Dots of a layer are united, whatever their order. Sizes are rounded to micrometres so that their mean area is kept;
/// very many different sizes (over some 4000 with strengths counted) are rounded to a few micrometres. Marks that are not
/// finite or have no size or ink are left out, and so are dots that lie wholly off the page and points of strokes more
/// than ten pages away. The same drawing gives the same bytes everywhere.
///
/// # Errors
/// What the writer refuses.
///
/// # Panics
/// If the arrays of a layer's dots or strokes differ in length.
pub fn write_svg<W: Write>(writer: W, drawing: &Drawing, options: &SvgOptions<'_>) -> io::Result<()> {
    let mut text = TextWriter::new(writer);
    header(&mut text, drawing, options);
    let mut number = 0;
    for layer in &drawing.layers {
        let image = layer.image.as_ref().filter(|_| !options.plotter);
        if layer.dots.is_empty() && layer.strokes.is_empty() && image.is_none() {
            continue;
        }
        number += 1;
        let sheet = Sheet::new(drawing, layer, options);
        text.bytes(
            format!("<g id=\"layer{number}\" inkscape:groupmode=\"layer\" inkscape:label=\"").as_bytes(),
        );
        text.bytes(escaped(&label(layer, options.plotter.then_some(number)), true).as_bytes());
        text.bytes(format!("\" fill=\"none\" stroke=\"{}\"", layer.color).as_bytes());
        text.bytes(b" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n");
        if let Some(image) = image {
            image::write_image(&mut text, drawing, image)?;
        }
        dots::write_dots(&mut text, &sheet, &layer.dots)?;
        strokes::write_strokes(&mut text, &sheet, &layer.strokes)?;
        text.bytes(b"</g>\n");
    }
    text.bytes(b"</svg>\n");
    text.pass_all_on()
}

/// Everything above the layers.
fn header<W: Write>(text: &mut TextWriter<W>, drawing: &Drawing, options: &SvgOptions<'_>) {
    let page = &drawing.page;
    let um = |px: u32| (f64::from(px) * 25_400.0 / f64::from(page.dpi)).round() as i64;
    let size = [um(page.width), um(page.height)];
    text.bytes(b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\"");
    text.bytes(b" xmlns:xlink=\"http://www.w3.org/1999/xlink\"");
    text.bytes(b" xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" version=\"1.1\" width=\"");
    text.thousandths(size[0]);
    text.bytes(b"mm\" height=\"");
    text.thousandths(size[1]);
    text.bytes(b"mm\" viewBox=\"0 0 ");
    text.thousandths(size[0]);
    text.bytes(b" ");
    text.thousandths(size[1]);
    text.bytes(b"\">\n");
    if let Some(title) = options.title {
        text.bytes(format!("<title>{}</title>\n", escaped(title, false)).as_bytes());
    }
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let (dots, strokes) = (count(drawing.dot_count(), "dot"), count(drawing.stroke_count(), "stroke"));
    text.bytes(format!("<desc>{dots}, {strokes}</desc>\n").as_bytes());
    if let Some(settings) = options.metadata {
        let start = format!("dotwork:{ELEMENT} xmlns:dotwork=\"{NAMESPACE}\"");
        text.bytes(format!("<metadata><{start} generator=\"{SOFTWARE}\">").as_bytes());
        text.bytes(escaped(settings, false).as_bytes());
        text.bytes(format!("</dotwork:{ELEMENT}></metadata>\n").as_bytes());
    }
    if drawing.paper != Color::WHITE && !options.plotter {
        text.bytes(b"<rect id=\"paper\" width=\"");
        text.thousandths(size[0]);
        text.bytes(b"\" height=\"");
        text.thousandths(size[1]);
        text.bytes(format!("\" fill=\"{}\"/>\n", drawing.paper).as_bytes());
    }
}

/// What a layer is called: `bunny #000000 0.25 mm`; with a number in front and the pen first for a plotter, whose
/// programs go by the number.
fn label(layer: &Layer, number: Option<usize>) -> String {
    let (object, color) = (&layer.object, layer.color);
    let pen = usable_pen(layer).map(|mm| format!("{mm} mm"));
    let words = match (number, pen) {
        (None, None) => format!("{object} {color}"),
        (None, Some(pen)) => format!("{object} {color} {pen}"),
        (Some(n), None) => format!("{n} {color} {object}"),
        (Some(n), Some(pen)) => format!("{n} {pen} {color} {object}"),
    };
    words.trim().to_owned()
}

/// The layer's pen if it has a size that can be written.
fn usable_pen(layer: &Layer) -> Option<f32> {
    layer.pen_mm.filter(|mm| (0.001..=1000.0).contains(mm))
}

/// What the writers of marks need to know of page and layer.
struct Sheet<'a> {
    /// Micrometres a pixel.
    um_per_px: f64,
    /// Width and height in micrometres.
    size_um: [f64; 2],
    paper: Color,
    color: Color,
    pen_mm: Option<f32>,
    options: &'a SvgOptions<'a>,
}

impl<'a> Sheet<'a> {
    fn new(drawing: &Drawing, layer: &Layer, options: &'a SvgOptions<'a>) -> Sheet<'a> {
        let um_per_px = 25_400.0 / f64::from(drawing.page.dpi);
        Sheet {
            um_per_px,
            size_um: [drawing.page.width, drawing.page.height].map(|px| f64::from(px) * um_per_px),
            paper: drawing.paper,
            color: layer.color,
            pen_mm: usable_pen(layer),
            options,
        }
    }

    /// A coordinate of the page, pixels to micrometres.
    fn um(&self, px: f32) -> f64 {
        f64::from(px) * self.um_per_px
    }

    /// True if something `reach` micrometres round a place (micrometres) touches the page; false for what is not
    /// finite.
    fn touches(&self, x: f64, y: f64, reach: f64) -> bool {
        x > -reach && y > -reach && x < self.size_um[0] + reach && y < self.size_um[1] + reach
    }
}

/// Opacities are written in this many steps: two decimals, and few paths.
const OPACITY_STEPS: f32 = 50.0;

/// ` stroke-opacity="…"`, nothing for full strength. `level` is in [`OPACITY_STEPS`].
fn write_opacity<W: Write>(text: &mut TextWriter<W>, level: u64) {
    if level < OPACITY_STEPS as u64 {
        text.bytes(b" stroke-opacity=\"");
        text.thousandths((level * (1000 / OPACITY_STEPS as u64)) as i64);
        text.bytes(b"\"");
    }
}

#[cfg(test)]
pub(crate) mod tests;
