//! The body of an ascii PLY file: one row a line.

use dotwork_drawing::Warnings;

use super::header::{Element, Header, Kind};
use super::{Body, out_of_range, row_name};
use crate::error::ReadErrorKind;
use crate::gather::{Colors, Coordinates, Faces, RESTART};
use crate::number;
use crate::text::{Text, with_newlines};

pub(super) fn read(bytes: &[u8], header: &Header, warnings: &mut Warnings) -> Result<Body, ReadErrorKind> {
    let body = &bytes[header.length..];
    let body = if header.lone_cr { with_newlines(body) } else { body.into() };
    let mut rows = Rows { text: Text::new(&body, header.lines + 1), longer: 0, first_longer: 0 };
    let mut coordinates = Vec::new();
    let mut colors = Colors::default();
    let mut full = None;
    let mut faces = Faces::default();
    let vertices = header.element("vertex").map_or(0, |e| e.count as u32);
    for element in header.elements.iter().filter(|e| !e.properties.is_empty()) {
        match element.name.as_str() {
            "vertex" => {
                full = element.color().and_then(|(kind, _)| kind.full());
                coordinates = rows.vertices(element, &mut colors)?;
            }
            "face" => rows.faces(element, vertices, &mut faces)?,
            "tristrips" => rows.strips(element, vertices, &mut faces)?,
            _ => rows.skip(element)?,
        }
    }
    let longer = Some(format!("line {}", rows.first_longer));
    warnings.counted("lines with more numbers than the header declares", rows.longer, longer);
    if rows.text.next_line_with_token() {
        warnings.say(format!("text after the last element ignored, from line {}", rows.text.line));
    }
    let colors = colors.finish(coordinates.len(), full, warnings);
    Ok(Body { coordinates: Coordinates::Double(coordinates), colors, faces })
}

struct Rows<'a> {
    text: Text<'a>,
    /// Lines that hold more than was declared.
    longer: u64,
    first_longer: u64,
}

impl Rows<'_> {
    fn start(&mut self, element: &Element, row: u64) -> Result<(), ReadErrorKind> {
        if self.text.next_line_with_token() {
            return Ok(());
        }
        Err(self.text.error(format!("the file ends before {}", row_name(element, row))))
    }

    fn end(&mut self) {
        if self.text.next_in_line() {
            if self.longer == 0 {
                self.first_longer = self.text.line;
            }
            self.longer += 1;
            self.text.skip_line();
        }
    }

    fn vertices(&mut self, element: &Element, colors: &mut Colors) -> Result<Vec<[f64; 3]>, ReadErrorKind> {
        let xyz = element.xyz()?;
        let rgba = element.color().map(|(_, at)| at);
        let channel = |at| rgba.and_then(|rgba| rgba.iter().position(|&k| k == Some(at)));
        let channels: Vec<Option<usize>> = (0..element.properties.len()).map(channel).collect();
        // Three numbers and their blanks take 6 bytes: what a header declares beyond that cannot be there.
        let most = self.text.rest().len() / 6 + 1;
        let mut positions = Vec::with_capacity(element.count.min(most as u64) as usize);
        for row in 0..element.count {
            self.start(element, row)?;
            let mut position = [0.0; 3];
            let mut color = [f32::NAN; 4];
            for (at, property) in element.properties.iter().enumerate() {
                if let Kind::List { .. } = property.kind {
                    self.skip_list(element, row)?;
                    continue;
                }
                if !self.text.next_in_line() {
                    let what = if element.properties.len() == 3 { "coordinates" } else { "numbers" };
                    let expected = element.properties.len();
                    return Err(self.text.error(format!("expected {expected} {what}, found {at}")));
                }
                match xyz.iter().position(|&k| k == at) {
                    Some(axis) => {
                        let value = self.text.float()?;
                        if !value.is_finite() {
                            return Err(self.text.not_finite(row + 1, axis, value));
                        }
                        position[axis] = value;
                    }
                    None => {
                        let token = self.text.token();
                        if let Some(channel) = channels[at] {
                            color[channel] = number::float(token).map_or(f32::NAN, |(value, _)| value as f32);
                        }
                    }
                }
            }
            if rgba.is_some() {
                let [r, g, b, a] = color;
                colors.set(positions.len(), [r, g, b], Some(a));
            }
            positions.push(position);
            self.end();
        }
        Ok(positions)
    }

    fn faces(&mut self, element: &Element, vertices: u32, faces: &mut Faces) -> Result<(), ReadErrorKind> {
        // "3 0 1 2" and its line end take 8 bytes.
        let most = self.text.rest().len() / 8 + 1;
        faces.triangles.reserve(element.count.min(most as u64) as usize);
        self.lists(element, vertices, None, |corners, line| faces.push(corners, || format!("line {line}")))
    }

    fn strips(&mut self, element: &Element, vertices: u32, faces: &mut Faces) -> Result<(), ReadErrorKind> {
        self.lists(element, vertices, Some(-1), |strip, _| faces.push_strip(strip))
    }

    /// Hands the list of vertices of every row to `add`, with its line; the index `restart` as [`RESTART`].
    fn lists(
        &mut self,
        element: &Element,
        vertices: u32,
        restart: Option<i64>,
        mut add: impl FnMut(&[u32], u64),
    ) -> Result<(), ReadErrorKind> {
        let list = element.corner_list()?;
        let mut corners = Vec::new();
        for row in 0..element.count {
            self.start(element, row)?;
            for (at, property) in element.properties.iter().enumerate() {
                match property.kind {
                    Kind::List { .. } if at == list => {
                        self.corners(element, row, vertices, restart, &mut corners)?;
                    }
                    Kind::List { .. } => self.skip_list(element, row)?,
                    Kind::Scalar(_) => self.skip_scalar(element, row)?,
                }
            }
            add(&corners, self.text.line);
            self.end();
        }
        Ok(())
    }

    fn corners(
        &mut self,
        element: &Element,
        row: u64,
        vertices: u32,
        restart: Option<i64>,
        corners: &mut Vec<u32>,
    ) -> Result<(), ReadErrorKind> {
        corners.clear();
        let count = self.list_count(element, row)?;
        for k in 0..count {
            if !self.text.next_in_line() {
                let row = row_name(element, row);
                return Err(self.text.error(format!("{row}: expected {count} indices, found {k}")));
            }
            let index = self.text.integer()?;
            match u32::try_from(index) {
                Ok(i) if i < vertices => corners.push(i),
                _ if restart == Some(index) => corners.push(RESTART),
                _ => return Err(self.text.error(out_of_range(element, row, index.into(), vertices))),
            }
        }
        Ok(())
    }

    fn list_count(&mut self, element: &Element, row: u64) -> Result<u64, ReadErrorKind> {
        if !self.text.next_in_line() {
            return Err(self.short(element, row));
        }
        let count = self.text.integer()?;
        u64::try_from(count)
            .map_err(|_| self.text.error(format!("{}: a list of {count} items", row_name(element, row))))
    }

    fn skip_list(&mut self, element: &Element, row: u64) -> Result<(), ReadErrorKind> {
        for _ in 0..self.list_count(element, row)? {
            self.skip_scalar(element, row)?;
        }
        Ok(())
    }

    #[inline]
    fn skip_scalar(&mut self, element: &Element, row: u64) -> Result<(), ReadErrorKind> {
        if !self.text.next_in_line() {
            return Err(self.short(element, row));
        }
        self.text.token();
        Ok(())
    }

    #[cold]
    fn short(&self, element: &Element, row: u64) -> ReadErrorKind {
        self.text.error(format!("the line ends in the middle of {}", row_name(element, row)))
    }

    fn skip(&mut self, element: &Element) -> Result<(), ReadErrorKind> {
        for row in 0..element.count {
            self.start(element, row)?;
            // What is not used need not be right.
            self.text.skip_line();
        }
        Ok(())
    }
}
