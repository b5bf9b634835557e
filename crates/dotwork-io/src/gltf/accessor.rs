//! Accessors: typed, strided, possibly sparse views of buffers.

use super::Document;
use super::json::{Accessor, Shape};
use crate::error::ReadErrorKind;

/// The most elements of an accessor that has no buffer view, and so no bytes to show for them.
const MOST_ZEROS: u64 = 1 << 18;

/// The type of one number.
#[derive(Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn new(code: u32) -> Option<Component> {
        Some(match code {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }
}

impl Shape {
    fn width(self) -> usize {
        match self {
            Shape::Scalar => 1,
            Shape::Vec2 => 2,
            Shape::Vec3 => 3,
            Shape::Vec4 | Shape::Mat2 => 4,
            Shape::Mat3 => 9,
            Shape::Mat4 => 16,
        }
    }
}

/// Elements side by side or a stride apart, all of them inside the buffer.
#[derive(Clone, Copy)]
struct Run<'d> {
    bytes: &'d [u8],
    stride: usize,
}

/// An accessor, checked.
pub(super) struct Elements<'d> {
    /// How many there are.
    pub(super) count: usize,
    component: Component,
    normalized: bool,
    width: usize,
    /// `None`: all zero.
    dense: Option<Run<'d>>,
    /// Elements that are replaced, ascending, and by what.
    sparse: Option<(Vec<u32>, Run<'d>)>,
}

impl<'d> Document<'d> {
    /// The accessor of that number, which must have one of `shapes` and, if given, `expected` elements.
    pub(super) fn elements(
        &self,
        index: u32,
        shapes: &[Shape],
        expected: Option<usize>,
    ) -> Result<Elements<'_>, ReadErrorKind> {
        let index = index as usize;
        let fail = |reason: String| ReadErrorKind::at_item("accessor", index, reason);
        let Some(accessor) = self.json.accessors.get(index) else {
            return Err(fail(format!("does not exist ({} accessors)", self.json.accessors.len())));
        };
        if !shapes.contains(&accessor.shape) {
            return Err(fail(format!(
                "its type is {:?}, but {:?} is needed here",
                accessor.shape, shapes[0]
            )));
        }
        if let Some(expected) = expected
            && accessor.count != expected as u64
        {
            return Err(fail(format!("has {} elements, but {expected} are needed here", accessor.count)));
        }
        let code = accessor.component_type;
        let component = Component::new(code).ok_or_else(|| fail(format!("{code} is no component type")))?;
        let width = accessor.shape.width();
        let size = width * component.size();
        let dense = match accessor.buffer_view {
            Some(view) => Some(
                self.run(view, accessor.byte_offset, accessor.count, size, true)
                    .map_err(|e| e.into_kind(index))?,
            ),
            None if expected.is_none() && accessor.count > MOST_ZEROS => {
                return Err(fail(format!("{} elements without a buffer view", accessor.count)));
            }
            None => None,
        };
        let sparse = self.sparse(accessor, size).map_err(|e| e.into_kind(index))?;
        // Within memory: the run lies in a buffer, and what has no run was limited above.
        let count = accessor.count as usize;
        Ok(Elements { count, component, normalized: accessor.normalized, width, dense, sparse })
    }

    fn sparse(&self, accessor: &Accessor, size: usize) -> Result<Option<(Vec<u32>, Run<'_>)>, Trouble> {
        let Some(sparse) = &accessor.sparse else { return Ok(None) };
        let count = sparse.count;
        if count > accessor.count {
            return Err(Trouble::Here(format!("{count} sparse elements of {}", accessor.count)));
        }
        let code = sparse.indices.component_type;
        let component = Component::new(code)
            .filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
            .ok_or_else(|| Trouble::Here(format!("{code} is no type for sparse indices")))?;
        let run =
            self.run(sparse.indices.buffer_view, sparse.indices.byte_offset, count, component.size(), false)?;
        let elements = Elements {
            count: count as usize,
            component,
            normalized: false,
            width: 1,
            dense: Some(run),
            sparse: None,
        };
        let indices: Vec<u32> = elements.integers::<1>().into_iter().map(|[i]| i).collect();
        if let Some(wrong) = indices.iter().find(|&&i| u64::from(i) >= accessor.count) {
            return Err(Trouble::Here(format!("sparse index {wrong} of {} elements", accessor.count)));
        }
        let values = self.run(sparse.values.buffer_view, sparse.values.byte_offset, count, size, false)?;
        Ok(Some((indices, values)))
    }

    /// All bytes of a buffer view.
    pub(super) fn view(&self, view: u32) -> Result<&[u8], ReadErrorKind> {
        let length = self.json.buffer_views.get(view as usize).map_or(0, |v| v.byte_length);
        match self.run(view, 0, length, 1, false) {
            Ok(run) => Ok(run.bytes),
            Err(trouble) => Err(trouble.into_kind_of("buffer view", view as usize)),
        }
    }

    /// `count` elements of `size` bytes from byte `offset` of a buffer view.
    fn run(
        &self,
        view: u32,
        offset: u64,
        count: u64,
        size: usize,
        strided: bool,
    ) -> Result<Run<'_>, Trouble> {
        let json = &self.json;
        let Some(found) = json.buffer_views.get(view as usize) else {
            let views = json.buffer_views.len();
            return Err(Trouble::Here(format!("buffer view {view} does not exist ({views} views)")));
        };
        let buffer = self.buffers.get(json, found.buffer as usize).map_err(Trouble::There)?;
        let in_view =
            |reason: String| Trouble::There(ReadErrorKind::at_item("buffer view", view as usize, reason));
        let (start, length) = (found.byte_offset, found.byte_length);
        let bytes = start
            .checked_add(length)
            .filter(|&end| end <= buffer.len() as u64)
            .map(|end| &buffer[start as usize..end as usize])
            .ok_or_else(|| {
                in_view(format!("{length} bytes from byte {start}, but the buffer has {}", buffer.len()))
            })?;
        let stride = match found.byte_stride {
            // Other views than those of vertices must not say a stride; those of sparse values are tight.
            Some(stride) if strided && stride > 0 => stride,
            _ => size as u64,
        };
        if stride < size as u64 {
            return Err(in_view(format!("byteStride {stride} is less than the {size} bytes of an element")));
        }
        let length = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride).and_then(|l| l.checked_add(size as u64)),
        };
        let run = length
            .and_then(|length| offset.checked_add(length))
            .filter(|&end| end <= bytes.len() as u64)
            // With no elements the offset may be anything.
            .map(|end| if count == 0 { &[][..] } else { &bytes[offset as usize..end as usize] });
        match run {
            Some(bytes) => Ok(Run { bytes, stride: stride as usize }),
            None => {
                let view_length = bytes.len();
                Err(Trouble::Here(format!(
                    "{count} elements of {size} bytes, {stride} apart from byte {offset}, leave the {view_length} \
                     bytes of buffer view {view}"
                )))
            }
        }
    }
}

/// What is wrong with an accessor itself, or with what it refers to.
enum Trouble {
    Here(String),
    There(ReadErrorKind),
}

impl Trouble {
    fn into_kind(self, accessor: usize) -> ReadErrorKind {
        self.into_kind_of("accessor", accessor)
    }

    fn into_kind_of(self, what: &'static str, index: usize) -> ReadErrorKind {
        match self {
            Trouble::Here(reason) => ReadErrorKind::at_item(what, index, reason),
            Trouble::There(kind) => kind,
        }
    }
}

impl Elements<'_> {
    /// The elements as fractions, at most `N` numbers each; what an element does not have is 1. Normalized integers
    /// become −1…1 or 0…1.
    pub(super) fn floats<const N: usize>(&self) -> Vec<[f32; N]> {
        macro_rules! read {
            ($type:ty, $scale:expr) => {
                self.gather(0.0, 1.0, |b| {
                    let value = <$type>::from_le_bytes(*b) as f32;
                    // The least signed number stands for −1 like its neighbour.
                    if self.normalized { (value / $scale).max(-1.0) } else { value }
                })
            };
        }
        match self.component {
            Component::F32 => self.gather(0.0, 1.0, |b| f32::from_le_bytes(*b)),
            Component::I8 => read!(i8, 127.0),
            Component::U8 => read!(u8, 255.0),
            Component::I16 => read!(i16, 32767.0),
            Component::U16 => read!(u16, 65535.0),
            Component::U32 => read!(u32, u32::MAX as f32),
        }
    }

    /// The elements as whole numbers, `N` each; fractions and negative numbers have none and become the largest.
    pub(super) fn integers<const N: usize>(&self) -> Vec<[u32; N]> {
        match self.component {
            Component::U8 => self.gather(0, 0, |b| u8::from_le_bytes(*b).into()),
            Component::U16 => self.gather(0, 0, |b| u16::from_le_bytes(*b).into()),
            Component::U32 => self.gather(0, 0, |b| u32::from_le_bytes(*b)),
            Component::I8 => {
                self.gather(0, 0, |b| u8::try_from(i8::from_le_bytes(*b)).map_or(u32::MAX, Into::into))
            }
            Component::I16 => {
                self.gather(0, 0, |b| u16::try_from(i16::from_le_bytes(*b)).map_or(u32::MAX, Into::into))
            }
            Component::F32 => self.gather(0, 0, |_: &[u8; 4]| u32::MAX),
        }
    }

    /// The elements, `B` bytes a number; `zero` where the accessor has no bytes, `missing` for what narrow elements
    /// do not have.
    fn gather<T: Copy, const B: usize, const N: usize>(
        &self,
        zero: T,
        missing: T,
        number: impl Fn(&[u8; B]) -> T,
    ) -> Vec<[T; N]> {
        let element = |bytes: &[u8]| {
            let (numbers, _) = bytes[..self.width * B].as_chunks::<B>();
            std::array::from_fn(|k| numbers.get(k).map_or(missing, &number))
        };
        let mut elements: Vec<[T; N]> = match &self.dense {
            // The usual attribute: no bytes between elements, a constant width.
            Some(run) if run.stride == B * N && self.width == N => {
                let (numbers, _) = run.bytes.as_chunks::<B>();
                let (all, _) = numbers.as_chunks::<N>();
                all.iter().map(|e| e.each_ref().map(&number)).collect()
            }
            // The last chunk may lack the bytes between elements.
            Some(run) => run.bytes.chunks(run.stride).map(element).collect(),
            None => {
                let nothing = std::array::from_fn(|k| if k < self.width { zero } else { missing });
                vec![nothing; self.count]
            }
        };
        if let Some((indices, values)) = &self.sparse {
            for (&index, value) in indices.iter().zip(values.bytes.chunks(values.stride)) {
                elements[index as usize] = element(value);
            }
        }
        elements
    }
}
