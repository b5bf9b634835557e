//! PLY, the Polygon File Format: a text header that declares elements and their properties, then the elements in
//! that order, as text or as binary numbers of either byte order (Greg Turk, "The PLY Polygon File Format", 1994).
//!
//! Read are the x, y, z and the colour of `vertex` (`red`, `green`, `blue` and perhaps `alpha`, also `diffuse_red` and
//! so on, or `r`, `g`, `b`), and the `vertex_indices` (or `vertex_index`) of `face` and of `tristrips`, the triangle
//! strips of Stanford's own models, where −1 begins a new strip. All other properties and elements are stepped over.
//! Messages count vertices and faces from 1, indices from 0 as the format does.

mod ascii;
mod binary;
mod header;

use dotwork_drawing::Warnings;
use dotwork_mesh::RawMesh;

use crate::error::{ReadErrorKind, one_line};
use crate::gather::{Coordinates, Faces, check_vertex_count};
use header::{Element, Encoding, Header};

/// Reads a PLY file.
pub(crate) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<RawMesh, ReadErrorKind> {
    let header = Header::parse(bytes)?;
    check(&header)?;
    let Body { coordinates, colors, faces } = match header.encoding {
        Encoding::Ascii => ascii::read(bytes, &header, warnings)?,
        Encoding::LittleEndian => binary::read::<false>(bytes, &header, warnings)?,
        Encoding::BigEndian => binary::read::<true>(bytes, &header, warnings)?,
    };
    faces.into_mesh(coordinates, colors, warnings)
}

/// Refuses the beginning of a PLY file whose header declares more than `limit` bytes. A beginning that holds no whole
/// header passes.
pub(crate) fn check_declared_size(start: &[u8], limit: u64) -> Result<(), ReadErrorKind> {
    let Ok(header) = Header::parse(start) else { return Ok(()) };
    check(&header)?;
    let least = |e: &Element| match header.encoding {
        // A digit and a blank for every number.
        Encoding::Ascii => e.count.saturating_mul(2 * e.properties.len() as u64),
        _ => e.count.saturating_mul(e.least_size() as u64),
    };
    let declared = header.elements.iter().map(least).fold(0, u64::saturating_add);
    if declared > limit {
        return Err(ReadErrorKind::TooLarge(format!(
            "the PLY header declares at least {declared} bytes, but a file of this size unpacks to {limit} at most"
        )));
    }
    Ok(())
}

/// What can be refused before the body is looked at.
fn check(header: &Header) -> Result<(), ReadErrorKind> {
    let count = |name: &str| header.element(name).map_or(0, |e| e.count);
    check_vertex_count(count("vertex"))?;
    if count("vertex") == 0 || (count("face") == 0 && count("tristrips") == 0) {
        return Err(ReadErrorKind::NoFaces);
    }
    // Said here: a body steps over elements without properties, and faces would refer to vertices that are not there.
    header.element("vertex").map_or(Ok(()), |e| e.xyz().map(|_| ()))
}

/// What a body holds for us.
struct Body {
    coordinates: Coordinates,
    colors: Vec<[u8; 4]>,
    faces: Faces,
}

/// How a row is called in messages: "face 77 of 100".
fn row_name(element: &Element, row: u64) -> String {
    let name: String = element.name.chars().take(40).collect();
    format!("{} {} of {}", one_line(&name), row + 1, element.count)
}

fn out_of_range(element: &Element, row: u64, index: i128, vertices: u32) -> String {
    format!("{}: index {index} is out of range ({vertices} vertices)", row_name(element, row))
}
