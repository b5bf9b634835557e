//! STL, stereolithography: a soup of triangles, as text or as 50-byte records (3D Systems, 1989).
//!
//! Every facet names its three corners anew; [`dotwork_mesh::Mesh::build`] welds them. Facet normals are passed over
//! (many writers leave them zero), and so are the two attribute bytes of a record, in which some programs hide a
//! colour. A text file may hold several solids; keywords may be upper case, lines indented and ended in any way.
//! Which of the two forms a file has is decided in [`crate::format`]: `solid` begins binary files too.

use dotwork_drawing::Warnings;
use dotwork_mesh::RawMesh;

use crate::error::ReadErrorKind;
use crate::format::{is_text_stl, stl_length};
use crate::gather::{AXES, Coordinates, Faces, check_vertex_count};
use crate::text::{Text, with_newlines};

/// Bytes before the first record: a free text and the count.
const HEADER: usize = 84;
/// Bytes of a record: normal, three corners, attribute.
const RECORD: usize = 50;

/// Reads an STL file of either form.
pub(crate) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<RawMesh, ReadErrorKind> {
    if is_text_stl(bytes, true) { text(bytes, warnings) } else { binary(bytes, warnings) }
}

fn binary(bytes: &[u8], warnings: &mut Warnings) -> Result<RawMesh, ReadErrorKind> {
    let Some(declared) = stl_length(bytes) else {
        return Err(ReadErrorKind::at_byte(bytes.len(), "the file ends in the middle of the STL header"));
    };
    let count = (declared - HEADER as u64) / RECORD as u64;
    let (records, rest) = bytes[HEADER..].as_chunks::<RECORD>();
    let there = records.len() as u64;
    if there < count {
        let how = if rest.is_empty() { "before" } else { "in the middle of" };
        let reason = format!("the file ends {how} triangle {} of {count}", there + 1);
        return Err(ReadErrorKind::at_byte(bytes.len(), reason));
    }
    let left = bytes.len() as u64 - declared;
    if left > 0 {
        warnings.say(format!("{left} bytes after the last triangle ignored"));
    }
    check_vertex_count(3 * count)?;
    let records = &records[..count as usize];
    let mut positions = Vec::with_capacity(3 * records.len());
    for record in records {
        let (corners, _) = record[12..48].as_chunks::<12>();
        positions.extend(corners.iter().map(|corner| {
            let (axes, _) = corner.as_chunks::<4>();
            [axes[0], axes[1], axes[2]].map(f32::from_le_bytes)
        }));
    }
    if let Some(v) = positions.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        let (triangle, corner) = (v / 3, v % 3);
        let axis = positions[v].iter().position(|c| !c.is_finite()).unwrap_or(0);
        let reason = format!("triangle {}: {} is {}", triangle + 1, AXES[axis], positions[v][axis]);
        return Err(ReadErrorKind::at_byte(HEADER + triangle * RECORD + 12 * (corner + 1), reason));
    }
    let mut faces = Faces::default();
    faces.triangles.extend((0..count as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]));
    faces.polygons = records.len();
    faces.into_mesh(Coordinates::Single(positions), Vec::new(), warnings)
}

fn text(bytes: &[u8], warnings: &mut Warnings) -> Result<RawMesh, ReadErrorKind> {
    let bytes = with_newlines(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let mut text = Text::new(&bytes, 1);
    let mut reader = Reader::default();
    while text.next_line_with_token() {
        reader.statement(&mut text)?;
    }
    reader.finish(&text, warnings)
}

#[derive(Default)]
struct Reader {
    positions: Vec<[f64; 3]>,
    faces: Faces,
    facets: u64,
    /// Where the open facet begins: its line, and its first vertex.
    open: Option<(u64, usize)>,
    /// A solid has begun and not ended.
    in_solid: bool,
    unknown: u64,
    first_unknown: u64,
}

impl Reader {
    #[inline]
    fn statement(&mut self, text: &mut Text) -> Result<(), ReadErrorKind> {
        let line = text.line;
        let token = text.token();
        let is = |word: &str| token.eq_ignore_ascii_case(word.as_bytes());
        if is("vertex") {
            return self.vertex(text);
        } else if is("facet") {
            self.end_facet(text)?;
            self.open = Some((line, self.positions.len()));
            self.facets += 1;
            // "normal" and its numbers, which need not be numbers.
            for _ in 0..4 {
                if text.next_in_line() {
                    text.token();
                }
            }
        } else if is("endfacet") {
            self.end_facet(text)?;
        } else if is("solid") || is("endsolid") {
            self.end_facet(text)?;
            self.in_solid = is("solid");
            // A name may hold any words, a backslash at its end too.
            text.skip_line();
        } else if !(is("outer") || is("loop") || is("endloop")) {
            if self.unknown == 0 {
                self.first_unknown = line;
            }
            self.unknown += 1;
            text.skip_line();
        }
        Ok(())
    }

    #[inline]
    fn vertex(&mut self, text: &mut Text) -> Result<(), ReadErrorKind> {
        if self.open.is_none() {
            return Err(text.error("a vertex outside of a facet"));
        }
        let mut position = [0.0; 3];
        for (k, coordinate) in position.iter_mut().enumerate() {
            if !text.next_in_line() {
                return Err(text.error(format!("expected 3 coordinates, found {k}")));
            }
            *coordinate = text.float()?;
            if !coordinate.is_finite() {
                let (axis, facet) = (AXES[k], self.facets);
                return Err(text.error(format!("facet {facet}: {axis} is {coordinate}")));
            }
        }
        self.positions.push(position);
        Ok(())
    }

    /// Makes a face of the vertices since the facet began.
    #[inline]
    fn end_facet(&mut self, text: &Text) -> Result<(), ReadErrorKind> {
        let Some((line, first)) = self.open.take() else { return Ok(()) };
        check_vertex_count(self.positions.len() as u64)?;
        let (first, end) = (first as u32, self.positions.len() as u32);
        if end - first == 3 {
            self.faces.push(&[first, first + 1, first + 2], String::new);
        } else if end - first > 64 {
            return Err(text.error(format!("facet {} has {} vertices", self.facets, end - first)));
        } else {
            let corners: Vec<u32> = (first..end).collect();
            self.faces.push(&corners, || format!("line {line}"));
        }
        Ok(())
    }

    fn finish(self, text: &Text, warnings: &mut Warnings) -> Result<RawMesh, ReadErrorKind> {
        if self.open.is_some() {
            return Err(text.error(format!("the file ends in the middle of facet {}", self.facets)));
        }
        if self.in_solid && self.facets > 0 {
            warnings.say("the file ends without endsolid");
        }
        let first = Some(format!("line {}", self.first_unknown));
        warnings.counted("unknown statements ignored", self.unknown, first);
        self.faces.into_mesh(Coordinates::Double(self.positions), Vec::new(), warnings)
    }
}
