//! How much a scene may expand to.
//!
//! Instances are copied, primitives may share their accessors, and some accessors need no bytes at all: a small file can
//! ask for any amount of memory, or of time for nothing. So all that is drawn is charged, in about the bytes that it
//! takes, and before it is made. A sound file without instances expands to some 14 times its size at most (three
//! bytes of a position, one of an index).

use super::Document;
use crate::error::ReadErrorKind;

/// What any scene may expand to, bytes.
const SMALLEST_LIMIT: u64 = 64 << 20;
/// What a scene may expand to beyond that, in sizes of its files.
const RATIO_LIMIT: u64 = 50;

/// A primitive in one place, even if it draws nothing: time, rather than memory.
pub(super) const PRIMITIVE: u64 = 64;
/// A vertex while a mesh is made: in the mesh's space, in double and in single precision, and its colour.
pub(super) const VERTEX: u64 = 52;
/// A vertex moved by a morph target.
pub(super) const MOVED_VERTEX: u64 = 12;
/// The material of a triangle, and the places of its corners on a picture.
pub(super) const PAINT: u64 = 28;
/// The place of a vertex on a picture.
pub(super) const PLACE: u64 = 8;
/// A pixel of a picture, packed and unpacked.
pub(super) const PIXEL: u64 = 8;
/// A corner of a list of triangles.
pub(super) const LIST_CORNER: u64 = 4;
/// A corner of a strip or fan, which stands for three.
pub(super) const STRIP_CORNER: u64 = 12;
/// A joint of a skin: where it is, twice while the joints are gathered.
pub(super) const JOINT: u64 = 192;
/// Four joints and four weights of a vertex.
pub(super) const INFLUENCES: u64 = 32;
/// A key of an animation: its time and values, four numbers wide.
pub(super) const KEY: u64 = 24;
/// An inverse bind matrix.
pub(super) const MATRIX: u64 = 64;

/// What was charged so far, bytes.
#[derive(Default)]
pub(super) struct Budget(u64);

impl Budget {
    /// Charges `count` things of `each` bytes; refuses them if the scene then is more than its files can mean.
    pub(super) fn charge(
        &mut self,
        document: &Document,
        count: usize,
        each: u64,
    ) -> Result<(), ReadErrorKind> {
        self.0 = self.0.saturating_add((count as u64).saturating_mul(each));
        let files = document.file_length.saturating_add(document.buffers.bytes_read());
        let limit = SMALLEST_LIMIT.max(RATIO_LIMIT.saturating_mul(files));
        if self.0 <= limit {
            return Ok(());
        }
        let limit = limit >> 20;
        Err(ReadErrorKind::TooLarge(format!("what its scene draws expands to more than {limit} MiB")))
    }
}
