//! Wavefront OBJ: vertices and faces; everything else is passed over.
//!
//! The format as in "Object Files (.obj)", Advanced Visualizer Manual, Appendix B1. Read are `v` (with three or four
//! numbers after the third, the colour that MeshLab and others put there; a fourth alone is a weight, ignored) and `f`
//! with corners `v`, `v/vt`, `v/vt/vn` or `v//vn`, indices from 1 or negative from the latest vertex, faces before or
//! after the vertices they name, and lines continued by a backslash.
//! Limits: free-form curves and surfaces, lines and points have no faces and are only counted.

use dotwork_drawing::Warnings;
use dotwork_mesh::RawMesh;

use crate::error::ReadErrorKind;
use crate::gather::{Colors, Coordinates, Faces, check_vertex_count};
use crate::number;
use crate::text::{Text, with_newlines};

/// Reads an OBJ file.
pub(crate) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<RawMesh, ReadErrorKind> {
    let bytes = with_newlines(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let mut reader = Reader::default();
    let mut text = Text::new(&bytes, 1);
    while text.next_line_with_token() {
        reader.statement(&mut text)?;
    }
    reader.finish(warnings)
}

#[derive(Default)]
struct Reader {
    positions: Vec<[f64; 3]>,
    colors: Colors,
    faces: Faces,
    face_count: u64,
    /// The corners of the face being read, kept for its memory.
    corners: Vec<u32>,
    /// The largest index that named a vertex before it came: index, face, line.
    ahead: Option<(u32, u64, u64)>,
    without_surface: Counted,
    unknown: Counted,
}

/// A count and the line of the first.
#[derive(Default)]
struct Counted {
    count: u64,
    first: u64,
}

impl Counted {
    fn add(&mut self, line: u64) {
        if self.count == 0 {
            self.first = line;
        }
        self.count += 1;
    }

    fn say(&self, what: &str, warnings: &mut Warnings) {
        warnings.counted(what, self.count, Some(format!("line {}", self.first)));
    }
}

impl Reader {
    #[inline]
    fn statement(&mut self, text: &mut Text) -> Result<(), ReadErrorKind> {
        let line = text.line;
        let start = text.rest();
        if start[0] == b'#' {
            text.skip_line();
            return Ok(());
        }
        match text.token() {
            b"v" => self.vertex(text)?,
            b"f" | b"fo" => self.face(text)?,
            b"vn" | b"vt" | b"vp" | b"s" => {}
            // Names may end in a backslash (a path, say) without meaning that the line goes on.
            b"o" | b"g" | b"mtllib" | b"usemtl" | b"usemap" | b"maplib" => {
                text.skip_line();
                return Ok(());
            }
            b"l" | b"p" | b"curv" | b"curv2" | b"surf" => self.without_surface.add(line),
            b"cstype" | b"deg" | b"bmat" | b"step" | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp"
            | b"end" | b"con" | b"mg" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj"
            | b"trace_obj" | b"ctech" | b"stech" | b"call" | b"csh" => {}
            _ => self.unknown.add(line),
        }
        // The rest of the statement, over continued lines.
        while text.next_in_line() {
            text.token();
        }
        Ok(())
    }

    #[inline]
    fn vertex(&mut self, text: &mut Text) -> Result<(), ReadErrorKind> {
        let mut position = [0.0; 3];
        for (k, coordinate) in position.iter_mut().enumerate() {
            if !text.next_in_line() {
                return Err(text.error(format!("expected 3 coordinates, found {k}")));
            }
            *coordinate = text.float()?;
            if !coordinate.is_finite() {
                return Err(text.not_finite(self.positions.len() as u64 + 1, k, *coordinate));
            }
        }
        self.positions.push(position);
        if text.next_in_line() {
            self.color(text);
        }
        Ok(())
    }

    /// What follows the coordinates of the latest vertex: a colour, if three or four numbers are there.
    fn color(&mut self, text: &mut Text) {
        let mut numbers = [0.0; 4];
        let mut count = 0;
        while count < 4 && text.next_in_line() {
            let Some((value, length)) = number::float(text.rest()) else { break };
            text.advance(length);
            numbers[count] = value as f32;
            count += 1;
        }
        if count >= 3 {
            let [r, g, b, a] = numbers;
            self.colors.set(self.positions.len() - 1, [r, g, b], (count == 4).then_some(a));
        }
    }

    #[inline]
    fn face(&mut self, text: &mut Text) -> Result<(), ReadErrorKind> {
        self.face_count += 1;
        self.corners.clear();
        let face = self.face_count;
        let line = text.line;
        while text.next_in_line() {
            if text.rest()[0] == b'#' {
                text.skip_line();
                break;
            }
            let Some((index, length)) = number::integer(text.rest()) else {
                let token = crate::error::quote(text.token());
                return Err(text.error(format!("face {face}: {token} is not an index")));
            };
            text.advance(length);
            // Texture and normal indices follow in the same token; they are not needed.
            match text.rest().first() {
                Some(b'/') => {
                    text.token();
                }
                Some(&b) if !number::ends_token(b) => {
                    return Err(
                        text.error(format!("face {face}: the index {index} runs on into other characters"))
                    );
                }
                _ => {}
            }
            let corner = self.corner(index, text)?;
            self.corners.push(corner);
        }
        self.faces.push(&self.corners, || format!("line {line}"));
        Ok(())
    }

    /// The vertex that an index names, counted from 0.
    #[inline]
    fn corner(&mut self, index: i64, text: &Text) -> Result<u32, ReadErrorKind> {
        let count = self.positions.len() as i64;
        let from_zero = if index > 0 { index - 1 } else { count + index };
        if index == 0 || from_zero < 0 || from_zero >= i64::from(u32::MAX) {
            return Err(text.error(match index {
                0 => format!("face {}: index 0 (OBJ counts from 1)", self.face_count),
                _ => out_of_range(self.face_count, index, count as u64),
            }));
        }
        let vertex = from_zero as u32;
        if from_zero >= count && self.ahead.is_none_or(|(largest, ..)| vertex > largest) {
            self.ahead = Some((vertex, self.face_count, text.line));
        }
        Ok(vertex)
    }

    fn finish(self, warnings: &mut Warnings) -> Result<RawMesh, ReadErrorKind> {
        let count = self.positions.len() as u64;
        check_vertex_count(count)?;
        if let Some((vertex, face, line)) = self.ahead
            && u64::from(vertex) >= count
        {
            return Err(ReadErrorKind::at_line(line, out_of_range(face, i64::from(vertex) + 1, count)));
        }
        self.without_surface.say("points, lines and free-form curves or surfaces ignored", warnings);
        self.unknown.say("unknown statements ignored", warnings);
        let colors = self.colors.finish(self.positions.len(), None, warnings);
        self.faces.into_mesh(Coordinates::Double(self.positions), colors, warnings)
    }
}

fn out_of_range(face: u64, index: i64, count: u64) -> String {
    format!("face {face}: index {index} is out of range ({count} vertices)")
}
