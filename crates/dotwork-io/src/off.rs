//! OFF, the Object File Format: counts, then vertices, then faces, one a line (Geomview's OFF, and what MeshLab, CGAL
//! and the Princeton benchmark write).
//!
//! Letters before the keyword say what follows the coordinates of a vertex: `N` a normal, `C` a colour, `ST` texture
//! coordinates, in this order. Colours are kept, as numbers 0…1 or 0…255, with or without opacity; the rest, and the
//! colours of faces, are passed over. A file may leave the keyword out if its name says `.off`. Comments begin with
//! `#`. Limits: four-dimensional coordinates (`4OFF`, `nOFF`) and the binary form are refused.

use dotwork_drawing::Warnings;
use dotwork_mesh::RawMesh;

use crate::error::{ReadErrorKind, quote};
use crate::format::off_keyword;
use crate::gather::{Colors, Coordinates, Faces, check_vertex_count};
use crate::number;
use crate::text::{Text, with_newlines};

/// Reads an OFF file.
pub(crate) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<RawMesh, ReadErrorKind> {
    let bytes = with_newlines(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let mut reader = Reader { text: Text::new(&bytes, 1) };
    let layout = reader.keyword(off_keyword(&bytes))?;
    let vertices = reader.count("vertices")?;
    let count = reader.count("faces")?;
    // The number of edges is often left out or wrong; nothing needs it.
    reader.text.skip_line();
    check_vertex_count(vertices)?;

    let mut colors = Colors::default();
    let positions = reader.vertices(vertices, layout, &mut colors)?;
    let mut faces = Faces::default();
    reader.faces(count, vertices as u32, &mut faces)?;
    if reader.next_row() {
        warnings.say(format!("text after the last face ignored, from line {}", reader.text.line));
    }
    let colors = colors.finish(positions.len(), None, warnings);
    faces.into_mesh(Coordinates::Double(positions), colors, warnings)
}

/// What a vertex holds beside its coordinates.
#[derive(Clone, Copy, Default)]
struct Layout {
    normal: bool,
    color: bool,
    texture: bool,
}

struct Reader<'a> {
    text: Text<'a>,
}

impl Reader<'_> {
    /// Moves to the next line that holds more than a comment.
    #[inline]
    fn next_row(&mut self) -> bool {
        while self.text.next_line_with_token() {
            if self.text.rest()[0] != b'#' {
                return true;
            }
            self.text.skip_line();
        }
        false
    }

    /// True if a token follows on this line, and no comment.
    #[inline]
    fn next_in_row(&mut self) -> bool {
        self.text.next_in_line() && self.text.rest()[0] != b'#'
    }

    fn keyword(&mut self, keyword: Option<&[u8]>) -> Result<Layout, ReadErrorKind> {
        let mut layout = Layout::default();
        let Some(keyword) = keyword else { return Ok(layout) };
        self.next_row();
        self.text.token();
        let mut letters = &keyword[..keyword.len() - 3];
        while let Some((&letter, rest)) = letters.split_first() {
            letters = match letter {
                b'N' => {
                    layout.normal = true;
                    rest
                }
                b'C' | b'c' => {
                    layout.color = true;
                    rest
                }
                b'S' if rest.first() == Some(&b'T') => {
                    layout.texture = true;
                    &rest[1..]
                }
                _ => {
                    let keyword = quote(keyword);
                    return Err(self.text.error(format!("{keyword}: only OFF in three dimensions is read")));
                }
            };
        }
        if self.next_in_row() && self.text.rest().starts_with(b"BINARY") {
            return Err(self.text.error("the binary form of OFF is not read"));
        }
        Ok(layout)
    }

    fn count(&mut self, what: &str) -> Result<u64, ReadErrorKind> {
        if !self.next_row() {
            return Err(self.text.error(format!("the file ends before the number of {what}")));
        }
        let count = self.text.integer()?;
        u64::try_from(count).map_err(|_| self.text.error(format!("{count} is not a number of {what}")))
    }

    /// Moves to a row that the counts promise.
    #[inline]
    fn start(&mut self, what: &str, row: u64, count: u64) -> Result<(), ReadErrorKind> {
        if self.next_row() {
            return Ok(());
        }
        Err(self.text.error(format!("the file ends before {what} {} of {count}", row + 1)))
    }

    fn vertices(
        &mut self,
        count: u64,
        layout: Layout,
        colors: &mut Colors,
    ) -> Result<Vec<[f64; 3]>, ReadErrorKind> {
        // Three numbers and their blanks take 6 bytes: what the counts declare beyond that cannot be there.
        let most = self.text.rest().len() / 6 + 1;
        let mut positions = Vec::with_capacity(count.min(most as u64) as usize);
        for row in 0..count {
            self.start("vertex", row, count)?;
            let mut position = [0.0; 3];
            for (k, coordinate) in position.iter_mut().enumerate() {
                if !self.next_in_row() {
                    return Err(self.text.error(format!("expected 3 coordinates, found {k}")));
                }
                *coordinate = self.text.float()?;
                if !coordinate.is_finite() {
                    return Err(self.text.not_finite(row + 1, k, *coordinate));
                }
            }
            if layout.color {
                self.color(row as usize, layout, colors);
            }
            positions.push(position);
            self.text.skip_line();
        }
        Ok(positions)
    }

    /// The colour among what follows the coordinates.
    fn color(&mut self, vertex: usize, layout: Layout, colors: &mut Colors) {
        // At most a normal, a colour with opacity, texture coordinates.
        let mut numbers = [0.0; 9];
        let mut found = 0;
        while found < numbers.len() && self.next_in_row() {
            let Some((value, length)) = number::float(self.text.rest()) else { break };
            self.text.advance(length);
            numbers[found] = value as f32;
            found += 1;
        }
        let before = if layout.normal { 3 } else { 0 };
        let after = if layout.texture { 2 } else { 0 };
        let Some(numbers) = found.checked_sub(after).and_then(|end| numbers.get(before..end)) else { return };
        if let &[r, g, b, ref opacity @ ..] = numbers {
            colors.set(vertex, [r, g, b], opacity.first().copied());
        }
    }

    fn faces(&mut self, count: u64, vertices: u32, faces: &mut Faces) -> Result<(), ReadErrorKind> {
        // "3 0 1 2" and its line end take 8 bytes.
        let most = self.text.rest().len() / 8 + 1;
        faces.triangles.reserve(count.min(most as u64) as usize);
        let mut corners = Vec::new();
        for row in 0..count {
            self.start("face", row, count)?;
            let line = self.text.line;
            let size = self.text.integer()?;
            if size < 0 {
                return Err(self.text.error(format!("face {} of {count}: {size} corners", row + 1)));
            }
            corners.clear();
            for k in 0..size {
                if !self.next_in_row() {
                    let face = row + 1;
                    let reason = format!("face {face} of {count}: expected {size} indices, found {k}");
                    return Err(self.text.error(reason));
                }
                let index = self.text.integer()?;
                match u32::try_from(index) {
                    Ok(i) if i < vertices => corners.push(i),
                    _ => {
                        return Err(self.text.error(format!(
                            "face {} of {count}: index {index} is out of range ({vertices} vertices)",
                            row + 1
                        )));
                    }
                }
            }
            faces.push(&corners, || format!("line {line}"));
            // A colour may follow.
            self.text.skip_line();
        }
        Ok(())
    }
}
