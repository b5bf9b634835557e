//! The drawing table: comma-separated values, one row a dot.
//!
//! Columns: `frame,id,x_px,y_px,depth,radius_px,ink,r,g,b,object,size`, and in full also `x,y,z,nx,ny,nz`. Pixels and
//! radii have at most 4 decimals, as have `ink` and `size`; `depth`, positions and normals have 7 significant digits.
//! Colours are 8-bit sRGB. Object names are quoted as RFC 4180 says when they need it; lines end in a line feed.

use std::io::{self, Write};

use dotwork_drawing::{Dots, Drawing, Layer};

use crate::text::TextWriter;

/// Where the stipples of a drawing lie in space.
pub trait Places {
    /// Position in object units and unit normal of row `stipple` ([`Dots::stipple`]) of layer number `layer`.
    fn place(&self, layer: usize, stipple: u32) -> ([f32; 3], [f32; 3]);
}

/// Any function of layer and stipple is a [`Places`].
impl<F: Fn(usize, u32) -> ([f32; 3], [f32; 3])> Places for F {
    fn place(&self, layer: usize, stipple: u32) -> ([f32; 3], [f32; 3]) {
        self(layer, stipple)
    }
}

/// Writes the drawing table frame by frame.
///
/// ```
/// use dotwork_drawing::{Color, Drawing, Page};
/// use dotwork_export::CsvWriter;
///
/// let mut table = Vec::new();
/// let mut csv = CsvWriter::new(&mut table, false)?;
/// csv.frame(0, &Drawing::new(Page::default(), Color::WHITE), None)?;
/// assert_eq!(table, b"frame,id,x_px,y_px,depth,radius_px,ink,r,g,b,object,size\n");
/// # Ok::<(), std::io::Error>(())
/// ```
pub struct CsvWriter<W: Write> {
    text: TextWriter<W>,
    full: bool,
}

impl<W: Write> CsvWriter<W> {
    /// Writes the header line; `full` adds the columns for position and normal.
    ///
    /// # Errors
    /// What the writer refuses.
    pub fn new(writer: W, full: bool) -> io::Result<CsvWriter<W>> {
        let mut text = TextWriter::new(writer);
        text.bytes(b"frame,id,x_px,y_px,depth,radius_px,ink,r,g,b,object,size");
        if full {
            text.bytes(b",x,y,z,nx,ny,nz");
        }
        text.bytes(b"\n");
        text.pass_all_on()?;
        Ok(CsvWriter { text, full })
    }

    /// A writer of further rows of a table that has its header.
    pub fn without_header(writer: W, full: bool) -> CsvWriter<W> {
        CsvWriter { text: TextWriter::new(writer), full }
    }

    /// Writes one row for each dot, layers from bottom to top, dots in drawing order. `number` is the absolute frame
    /// number. `places` is asked only for the full table. A number that is not finite is written as an empty field.
    ///
    /// All rows have been handed to the writer when this returns.
    ///
    /// # Errors
    /// What the writer refuses; [`io::ErrorKind::InvalidInput`] if the table is full and there are no `places`.
    ///
    /// # Panics
    /// If the arrays of a layer's [`Dots`] differ in length.
    pub fn frame(&mut self, number: u32, drawing: &Drawing, places: Option<&dyn Places>) -> io::Result<()> {
        let places = match (self.full, places) {
            (true, None) => {
                let what = "the full drawing table needs the places of the stipples";
                return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
            }
            (true, places) => places,
            (false, _) => None,
        };
        for (index, layer) in drawing.layers.iter().enumerate() {
            self.layer(number, index, layer, places)?;
        }
        self.text.pass_all_on()
    }

    fn layer(
        &mut self,
        number: u32,
        index: usize,
        layer: &Layer,
        places: Option<&dyn Places>,
    ) -> io::Result<()> {
        let Dots { x, y, depth, radius, size, ink, id, stipple } = &layer.dots;
        let n = x.len();
        let (y, depth, radius, size) = (&y[..n], &depth[..n], &radius[..n], &size[..n]);
        let (ink, id, stipple) = (&ink[..n], &id[..n], &stipple[..n]);
        // Frame, colour and object are the same in every row.
        let before = format!("{number},");
        let c = layer.color;
        let between = format!(",{},{},{},{},", c.r, c.g, c.b, quoted(&layer.object));
        let text = &mut self.text;
        for i in 0..n {
            text.bytes(before.as_bytes());
            text.integer(id[i]);
            for value in [x[i], y[i]] {
                field(text, value, TextWriter::decimals4);
            }
            field(text, depth[i], TextWriter::digits7);
            for value in [radius[i], ink[i]] {
                field(text, value, TextWriter::decimals4);
            }
            text.bytes(between.as_bytes());
            if size[i].is_finite() {
                text.decimals4(size[i]);
            }
            if let Some(places) = places {
                let (position, normal) = places.place(index, stipple[i]);
                for value in position.into_iter().chain(normal) {
                    field(text, value, TextWriter::digits7);
                }
            }
            text.bytes(b"\n");
            text.pass_on()?;
        }
        Ok(())
    }
}

/// A comma and the number, or nothing after the comma.
#[inline]
fn field<W: Write>(text: &mut TextWriter<W>, value: f32, write: impl FnOnce(&mut TextWriter<W>, f32)) {
    text.bytes(b",");
    if value.is_finite() {
        write(text, value);
    }
}

/// A field as RFC 4180 writes it: in quotes if it holds a comma, a quote or a line break, quotes doubled.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\r', '\n']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{dots, drawing};
    use dotwork_drawing::{Color, Page};

    fn table(full: bool, drawing: &Drawing) -> String {
        let mut out = Vec::new();
        let mut csv = CsvWriter::new(&mut out, full).unwrap();
        for number in [7, 8] {
            csv.frame(
                number,
                drawing,
                Some(&|layer: usize, s: u32| ([s as f32, layer as f32, -0.0], [0.0, 0.6, -0.8])),
            )
            .unwrap();
        }
        String::from_utf8(out).unwrap()
    }

    /// Splits a table as RFC 4180 says.
    fn parse(table: &str) -> Vec<Vec<String>> {
        let mut rows = vec![vec![String::new()]];
        let mut inside = false;
        let mut chars = table.chars().peekable();
        while let Some(c) = chars.next() {
            let row = rows.last_mut().unwrap();
            match c {
                '"' if inside && chars.peek() == Some(&'"') => {
                    chars.next();
                    row.last_mut().unwrap().push('"');
                }
                '"' => inside = !inside,
                ',' if !inside => row.push(String::new()),
                '\n' if !inside => rows.push(vec![String::new()]),
                c => row.last_mut().unwrap().push(c),
            }
        }
        assert!(!inside);
        assert_eq!(rows.pop(), Some(vec![String::new()]), "the table ends in a line feed");
        rows
    }

    #[test]
    fn one_row_in_full() {
        let layer = Layer {
            object: "bunny".into(),
            color: Color { r: 1, g: 20, b: 255 },
            dots: Dots {
                x: vec![512.25],
                y: vec![0.00001],
                depth: vec![2.345_678_3],
                radius: vec![0.75],
                size: vec![1.0],
                ink: vec![0.333_333_34],
                id: vec![(1 << 53) - 1],
                stipple: vec![42],
            },
            ..Layer::default()
        };
        let mut drawing = Drawing::new(Page::default(), Color::WHITE);
        drawing.layers.push(layer);
        let header = "frame,id,x_px,y_px,depth,radius_px,ink,r,g,b,object,size";
        let row = "9007199254740991,512.25,0,2.345678,0.75,0.3333,1,20,255,bunny,1";
        assert_eq!(table(false, &drawing), format!("{header}\n7,{row}\n8,{row}\n"));
        let (header, row) = (format!("{header},x,y,z,nx,ny,nz"), format!("{row},42,0,0,0,0.6,-0.8"));
        assert_eq!(table(true, &drawing), format!("{header}\n7,{row}\n8,{row}\n"));
    }

    #[test]
    fn tables_parse_back() {
        let drawing = drawing();
        for full in [false, true] {
            let text = table(full, &drawing);
            assert_eq!(text, table(full, &drawing), "the same bytes every time");
            let rows = parse(&text);
            assert_eq!(rows.len(), 1 + 2 * drawing.dot_count());
            assert!(rows.iter().all(|r| r.len() == if full { 18 } else { 12 }));
            let mut row = rows[1..].iter();
            for number in ["7", "8"] {
                for (index, layer) in drawing.layers.iter().enumerate() {
                    let d = &layer.dots;
                    for i in 0..d.len() {
                        let row = row.next().unwrap();
                        assert_eq!(row[0], number);
                        assert_eq!(row[1], d.id[i].to_string());
                        assert_eq!(row[10], layer.object);
                        let c = layer.color;
                        assert_eq!(row[7..10], [c.r, c.g, c.b].map(|c| c.to_string()));
                        let value = |column: usize| row[column].parse::<f64>().unwrap();
                        for (column, v) in
                            [(2, d.x[i]), (3, d.y[i]), (5, d.radius[i]), (6, d.ink[i]), (11, d.size[i])]
                        {
                            assert!(
                                (value(column) - f64::from(v)).abs() <= 0.500_001e-4,
                                "{v} as {}",
                                row[column]
                            );
                        }
                        let depth = f64::from(d.depth[i]);
                        assert!((value(4) - depth).abs() <= depth * 5.000_001e-7, "{depth} as {}", row[4]);
                        if full {
                            let place = [f64::from(d.stipple[i]), index as f64, 0.0, 0.0, 0.6, -0.8];
                            assert_eq!(place, std::array::from_fn(|k| value(12 + k)));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn numbers_that_are_not_finite_leave_a_field_empty() {
        let mut drawing = Drawing::new(Page::default(), Color::WHITE);
        let mut dots = dots(1);
        (dots.x[0], dots.depth[0], dots.size[0]) = (f32::NAN, f32::INFINITY, f32::NEG_INFINITY);
        drawing.layers.push(Layer { dots, ..Layer::default() });
        let rows = parse(&table(false, &drawing));
        for column in [2, 4, 10, 11] {
            assert_eq!(rows[1][column], "");
        }
    }

    #[test]
    fn the_full_table_needs_places() {
        let mut csv = CsvWriter::new(Vec::new(), true).unwrap();
        let error = csv.frame(0, &drawing(), None).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    }

    #[test]
    fn quoting() {
        for (name, field) in [
            ("plain name", "plain name"),
            ("a,b", "\"a,b\""),
            ("5\" disc", "\"5\"\" disc\""),
            ("a\nb", "\"a\nb\""),
        ] {
            assert_eq!(quoted(name), field);
        }
    }
}
