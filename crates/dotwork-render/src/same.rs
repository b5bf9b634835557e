//! Whether a frame shows what the frame before it showed, so that what hides and the lines can be kept.

use std::sync::{Arc, Weak};

/// Remembers a shared value without keeping it. Nothing else can stand at its place in memory meanwhile, and nobody can
/// change it there.
pub(crate) struct Seen<T>(Weak<T>);

impl<T> Seen<T> {
    pub fn of(value: &Arc<T>) -> Seen<T> {
        Seen(Arc::downgrade(value))
    }

    /// Whether it is this very value.
    pub fn is(&self, value: &Arc<T>) -> bool {
        std::ptr::eq(self.0.as_ptr(), Arc::as_ptr(value))
    }
}
