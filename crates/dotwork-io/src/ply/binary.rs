//! The body of a binary PLY file.
//!
//! Rows without lists have a fixed size, and so have triangles between fixed properties: both are read in plain
//! strides. Polygons, and elements with further lists, are walked property by property.

use dotwork_drawing::Warnings;

use super::header::{Element, Header, Kind, Scalar};
use super::{Body, out_of_range, row_name};
use crate::error::ReadErrorKind;
use crate::gather::{AXES, Colors, Coordinates, Faces, RESTART};

/// Reads the body; `BIG`: numbers are big-endian.
pub(super) fn read<const BIG: bool>(
    bytes: &[u8],
    header: &Header,
    warnings: &mut Warnings,
) -> Result<Body, ReadErrorKind> {
    let mut reader = Reader::<BIG> { bytes, at: header.length };
    let mut coordinates = Coordinates::Single(Vec::new());
    let mut colors = Vec::new();
    let mut faces = Faces::default();
    let vertices = header.element("vertex").map_or(0, |e| e.count as u32);
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => (coordinates, colors) = reader.vertices(element, warnings)?,
            "face" => reader.faces(element, vertices, &mut faces)?,
            "tristrips" => reader.strips(element, vertices, &mut faces)?,
            _ => reader.skip(element)?,
        }
    }
    let left = bytes.len() - reader.at;
    if left > 0 {
        warnings.say(format!("{left} bytes after the last element ignored"));
    }
    Ok(Body { coordinates, colors, faces })
}

struct Reader<'a, const BIG: bool> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a, const BIG: bool> Reader<'a, BIG> {
    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The rows of an element without lists, all of which must be there.
    fn fixed_rows(&mut self, element: &Element, stride: usize) -> Result<&'a [u8], ReadErrorKind> {
        let whole = (self.left() / stride.max(1)) as u64;
        if stride > 0 && whole < element.count {
            let inside = !self.left().is_multiple_of(stride);
            return Err(self.cut(element, whole, inside));
        }
        // A stride of 0 has no bytes whatever the count; otherwise the product is at most the file.
        let length = if stride == 0 { 0 } else { stride * element.count as usize };
        let rows = &self.bytes[self.at..self.at + length];
        self.at += length;
        Ok(rows)
    }

    #[cold]
    fn cut(&self, element: &Element, row: u64, inside: bool) -> ReadErrorKind {
        let how = if inside { "in the middle of" } else { "before" };
        ReadErrorKind::at_byte(self.bytes.len(), format!("the file ends {how} {}", row_name(element, row)))
    }

    fn skip(&mut self, element: &Element) -> Result<(), ReadErrorKind> {
        if let Some(stride) = element.stride() {
            self.fixed_rows(element, stride)?;
            return Ok(());
        }
        for row in 0..element.count {
            self.walk(element, row, |_, _, _| {})?;
        }
        Ok(())
    }

    /// Walks one row; `see` gets every property's number, the type of its items and its bytes.
    #[inline]
    fn walk(
        &mut self,
        element: &Element,
        row: u64,
        mut see: impl FnMut(usize, Scalar, &'a [u8]),
    ) -> Result<(), ReadErrorKind> {
        let start = self.at;
        for (number, property) in element.properties.iter().enumerate() {
            let (scalar, length) = match property.kind {
                Kind::Scalar(scalar) => (scalar, scalar.size()),
                Kind::List { count, item } => {
                    if self.left() < count.size() {
                        return Err(self.cut(element, row, self.bytes.len() > start));
                    }
                    let items = integer::<BIG>(count, &self.bytes[self.at..]);
                    self.at += count.size();
                    (item, self.list_length(element, row, items, item)?)
                }
            };
            if self.left() < length {
                return Err(self.cut(element, row, self.bytes.len() > start));
            }
            see(number, scalar, &self.bytes[self.at..self.at + length]);
            self.at += length;
        }
        Ok(())
    }

    /// Bytes of a list, if its count can be true.
    #[inline]
    fn list_length(
        &self,
        element: &Element,
        row: u64,
        items: i128,
        item: Scalar,
    ) -> Result<usize, ReadErrorKind> {
        /// Shorter lists that leave the file are a cut file, longer ones a broken count.
        const PLAUSIBLE: i128 = 1000;
        if items < 0 || (items > PLAUSIBLE && items * item.size() as i128 > self.left() as i128) {
            let (row, left) = (row_name(element, row), self.left());
            let reason = format!("{row}: a list of {items} items, but {left} bytes follow");
            return Err(ReadErrorKind::at_byte(self.at, reason));
        }
        Ok(items as usize * item.size())
    }

    fn vertices(
        &mut self,
        element: &Element,
        warnings: &mut Warnings,
    ) -> Result<(Coordinates, Vec<[u8; 4]>), ReadErrorKind> {
        let xyz = element.xyz()?;
        let Some(stride) = element.stride() else {
            return self.vertices_with_lists(element, xyz, warnings);
        };
        let start = self.at;
        let rows = self.fixed_rows(element, stride)?;
        let kinds = xyz.map(|k| element.properties[k].kind);
        let offsets =
            xyz.map(|k| element.properties[..k].iter().map(|p| scalar_of(p.kind).size()).sum::<usize>());
        let coordinates = if kinds == [Kind::Scalar(Scalar::F32); 3] {
            Coordinates::Single(singles::<BIG>(rows, stride, offsets))
        } else {
            let mut positions = Vec::with_capacity(element.count as usize);
            let scalars = kinds.map(scalar_of);
            positions.extend(
                rows.chunks_exact(stride)
                    .map(|row| [0, 1, 2].map(|k| number::<BIG>(scalars[k], &row[offsets[k]..]))),
            );
            Coordinates::Double(positions)
        };
        let place = |row: usize| start + row * stride;
        match &coordinates {
            Coordinates::Single(p) => check_finite(p, place)?,
            Coordinates::Double(p) => check_finite(p, place)?,
        }
        Ok((coordinates, colors::<BIG>(element, rows, stride, warnings)))
    }

    fn vertices_with_lists(
        &mut self,
        element: &Element,
        xyz: [usize; 3],
        warnings: &mut Warnings,
    ) -> Result<(Coordinates, Vec<[u8; 4]>), ReadErrorKind> {
        let rgba = element.color();
        let mut colors = Colors::default();
        let most = (self.left() / element.least_size()) as u64 + 1;
        let mut positions = Vec::with_capacity(element.count.min(most) as usize);
        for row in 0..element.count {
            let start = self.at;
            let mut position = [0.0; 3];
            let mut color = [f32::NAN; 4];
            self.walk(element, row, |property, scalar, bytes| {
                if let Some(axis) = xyz.iter().position(|&k| k == property) {
                    position[axis] = number::<BIG>(scalar, bytes);
                }
                let channel = rgba.and_then(|(_, at)| at.iter().position(|&k| k == Some(property)));
                if let Some(channel) = channel {
                    color[channel] = number::<BIG>(scalar, bytes) as f32;
                }
            })?;
            if !position.iter().all(|v| v.is_finite()) {
                return Err(not_finite(row, axis_not_finite(position), start));
            }
            if rgba.is_some() {
                let [r, g, b, a] = color;
                colors.set(positions.len(), [r, g, b], Some(a));
            }
            positions.push(position);
        }
        let full = rgba.and_then(|(kind, _)| kind.full());
        let colors = colors.finish(positions.len(), full, warnings);
        Ok((Coordinates::Double(positions), colors))
    }

    fn strips(&mut self, element: &Element, vertices: u32, faces: &mut Faces) -> Result<(), ReadErrorKind> {
        let list = element.corner_list()?;
        let mut strip = Vec::new();
        for row in 0..element.count {
            let start = self.at;
            let mut wrong = None;
            self.walk(element, row, |property, scalar, bytes| {
                if property == list {
                    strip.clear();
                    // -1, or the largest number of an unsigned type.
                    let restart = match scalar {
                        Scalar::U8 => u8::MAX.into(),
                        Scalar::U16 => u16::MAX.into(),
                        Scalar::U32 => u32::MAX.into(),
                        Scalar::U64 => u64::MAX.into(),
                        _ => -1,
                    };
                    strip.extend(bytes.chunks_exact(scalar.size()).map(|b| {
                        match integer::<BIG>(scalar, b) {
                            i if i >= 0 && i < i128::from(vertices) => i as u32,
                            i if i == restart => RESTART,
                            i => {
                                wrong.get_or_insert(i);
                                RESTART
                            }
                        }
                    }));
                }
            })?;
            if let Some(index) = wrong {
                return Err(ReadErrorKind::at_byte(start, out_of_range(element, row, index, vertices)));
            }
            faces.push_strip(&strip);
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element, vertices: u32, faces: &mut Faces) -> Result<(), ReadErrorKind> {
        let list = element.corner_list()?;
        let layout = TriangleLayout::of(element, list);
        let start = self.at;
        let first = faces.triangles.len();
        let least = element.least_size() + 3 * scalar_of(element.properties[list].kind).size();
        faces.triangles.reserve(element.count.min((self.left() / least) as u64) as usize);
        let mut corners = Vec::new();
        let mut row = 0;
        while row < element.count {
            if let Some(layout) = &layout {
                let run =
                    layout.run::<BIG>(&self.bytes[self.at..], element.count - row, &mut faces.triangles);
                faces.polygons += run;
                row += run as u64;
                self.at += run * layout.stride;
                if row == element.count {
                    break;
                }
            }
            self.walk(element, row, |property, scalar, bytes| {
                if property == list {
                    corners.clear();
                    // What is no 32-bit index becomes one that is never in range.
                    let index = |b| u32::try_from(integer::<BIG>(scalar, b)).unwrap_or(u32::MAX);
                    corners.extend(bytes.chunks_exact(scalar.size()).map(index));
                }
            })?;
            faces.push(&corners, || row_name(element, row));
            row += 1;
        }
        let largest = faces.triangles[first..].iter().flatten().fold(0, |a, &b| a.max(b));
        if largest >= vertices {
            self.at = start;
            self.find_out_of_range(element, list, vertices)?;
        }
        Ok(())
    }

    /// Walks the faces again, to name the first whose index is out of range.
    #[cold]
    fn find_out_of_range(
        &mut self,
        element: &Element,
        list: usize,
        vertices: u32,
    ) -> Result<(), ReadErrorKind> {
        for row in 0..element.count {
            let start = self.at;
            let mut wrong = None;
            self.walk(element, row, |property, scalar, bytes| {
                if property == list && bytes.len() >= 3 * scalar.size() {
                    let mut indices = bytes.chunks_exact(scalar.size()).map(|b| integer::<BIG>(scalar, b));
                    wrong = indices.find(|&i| i < 0 || i >= i128::from(vertices));
                }
            })?;
            if let Some(index) = wrong {
                return Err(ReadErrorKind::at_byte(start, out_of_range(element, row, index, vertices)));
            }
        }
        Ok(())
    }
}

/// Where a triangle's corners lie, when its list is the only one of the face, its count one byte and its indices four.
struct TriangleLayout {
    before: usize,
    stride: usize,
}

impl TriangleLayout {
    fn of(element: &Element, list: usize) -> Option<TriangleLayout> {
        let Kind::List { count, item } = element.properties[list].kind else { return None };
        let others = |p: &[super::header::Property]| {
            p.iter().try_fold(0, |sum, p| match p.kind {
                Kind::Scalar(scalar) => Some(sum + scalar.size()),
                Kind::List { .. } => None,
            })
        };
        let before = others(&element.properties[..list])?;
        let after = others(&element.properties[list + 1..])?;
        (count.size() == 1 && item.size() == 4)
            .then_some(TriangleLayout { before, stride: before + 13 + after })
    }

    /// Reads triangles until something else comes; how many there were.
    fn run<const BIG: bool>(&self, bytes: &[u8], most: u64, triangles: &mut Vec<[u32; 3]>) -> usize {
        let most = most.min((bytes.len() / self.stride) as u64) as usize;
        let before = triangles.len();
        let corners = |b: &[u8; 13]| {
            let corner = |k: usize| u32_at::<BIG>([b[k], b[k + 1], b[k + 2], b[k + 3]]);
            (b[0] == 3).then(|| [corner(1), corner(5), corner(9)])
        };
        if self.stride == 13 {
            // The usual file: the constant stride is worth its two lines.
            triangles.extend(bytes.as_chunks::<13>().0[..most].iter().map_while(corners));
        } else {
            let rows = bytes.chunks_exact(self.stride).take(most);
            triangles.extend(rows.filter_map(|r| r[self.before..].first_chunk()).map_while(corners));
        }
        triangles.len() - before
    }
}

fn singles<const BIG: bool>(rows: &[u8], stride: usize, offsets: [usize; 3]) -> Vec<[f32; 3]> {
    let value = |b: &[u8], k: usize| f32::from_bits(u32_at::<BIG>([b[k], b[k + 1], b[k + 2], b[k + 3]]));
    if stride == 12 && offsets == [0, 4, 8] {
        return rows.as_chunks::<12>().0.iter().map(|b| [value(b, 0), value(b, 4), value(b, 8)]).collect();
    }
    rows.chunks_exact(stride).map(|b| offsets.map(|k| value(b, k))).collect()
}

/// The colours of rows of fixed size.
fn colors<const BIG: bool>(
    element: &Element,
    rows: &[u8],
    stride: usize,
    warnings: &mut Warnings,
) -> Vec<[u8; 4]> {
    let Some((scalar, at)) = element.color() else { return Vec::new() };
    let offset = |k: usize| element.properties[..k].iter().map(|p| scalar_of(p.kind).size()).sum::<usize>();
    let offsets = at.map(|k| k.map(offset));
    if scalar == Scalar::U8 {
        let row = |b: &[u8]| offsets.map(|o| o.map_or(u8::MAX, |o| b[o]));
        return rows.chunks_exact(stride).map(row).collect();
    }
    let mut colors = Colors::default();
    for (vertex, row) in rows.chunks_exact(stride).enumerate() {
        let [r, g, b, a] = offsets.map(|o| o.map_or(f32::NAN, |o| number::<BIG>(scalar, &row[o..]) as f32));
        colors.set(vertex, [r, g, b], Some(a));
    }
    colors.finish(rows.len() / stride, scalar.full(), warnings)
}

fn check_finite<T: Copy + Into<f64>>(
    positions: &[[T; 3]],
    place: impl Fn(usize) -> usize,
) -> Result<(), ReadErrorKind> {
    match positions.iter().position(|p| !p.iter().all(|&v| v.into().is_finite())) {
        None => Ok(()),
        Some(row) => Err(not_finite(row as u64, axis_not_finite(positions[row].map(Into::into)), place(row))),
    }
}

/// The first coordinate that is not finite, and its value.
fn axis_not_finite(position: [f64; 3]) -> (usize, f64) {
    let axis = position.iter().position(|v| !v.is_finite()).unwrap_or(0);
    (axis, position[axis])
}

fn not_finite(row: u64, (axis, value): (usize, f64), byte: usize) -> ReadErrorKind {
    ReadErrorKind::at_byte(byte, format!("vertex {}: {} is {value}", row + 1, AXES[axis]))
}

fn scalar_of(kind: Kind) -> Scalar {
    match kind {
        Kind::Scalar(scalar) | Kind::List { item: scalar, .. } => scalar,
    }
}

#[inline(always)]
fn u32_at<const BIG: bool>(b: [u8; 4]) -> u32 {
    if BIG { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) }
}

/// The bits of the number at the start of `bytes`, which hold it.
#[inline(always)]
fn bits<const BIG: bool>(size: usize, bytes: &[u8]) -> u64 {
    let bytes = &bytes[..size];
    let push = |bits: u64, &b: &u8| bits << 8 | u64::from(b);
    if BIG { bytes.iter().fold(0, push) } else { bytes.iter().rev().fold(0, push) }
}

#[inline(always)]
fn integer<const BIG: bool>(scalar: Scalar, bytes: &[u8]) -> i128 {
    let bits = bits::<BIG>(scalar.size(), bytes);
    match scalar {
        Scalar::I8 => (bits as i8).into(),
        Scalar::I16 => (bits as i16).into(),
        Scalar::I32 => (bits as i32).into(),
        Scalar::I64 => (bits as i64).into(),
        _ => bits.into(),
    }
}

#[inline(always)]
fn number<const BIG: bool>(scalar: Scalar, bytes: &[u8]) -> f64 {
    match scalar {
        Scalar::F32 => f32::from_bits(bits::<BIG>(4, bytes) as u32).into(),
        Scalar::F64 => f64::from_bits(bits::<BIG>(8, bytes)),
        _ => integer::<BIG>(scalar, bytes) as f64,
    }
}
