//! Who is told how far the way from files to surfaces has been gone.

use std::fmt;
use std::sync::Arc;

/// What takes time on the way from a file to a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Files are read; how far is not known.
    Reading,
    /// A volume is windowed, resampled and smoothed.
    Preparing,
    /// The features of a volume are looked for, and a surface is found in it; how far is known for labels.
    Surface,
}

impl Stage {
    /// Its name in lower case, for a progress bar.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Reading => "reading",
            Stage::Preparing => "preparing",
            Stage::Surface => "surface",
        }
    }
}

type Tell = dyn Fn(Stage, f32) + Send + Sync;

/// A callback with the stage that is at work and the share of it, 0…1, that is done: 0 at its beginning, then ascending
/// where it is known. It is called from any thread, one call at a time; by default there is none.
#[derive(Clone, Default)]
pub struct Watch(Option<Arc<Tell>>);

impl Watch {
    /// Calls `tell`.
    pub fn new(tell: impl Fn(Stage, f32) + Send + Sync + 'static) -> Watch {
        Watch(Some(Arc::new(tell)))
    }

    pub(super) fn tell(&self, stage: Stage, share: f32) {
        if let Some(tell) = &self.0 {
            tell(stage, share);
        }
    }
}

/// Who watches makes no difference to what is read.
impl PartialEq for Watch {
    fn eq(&self, _: &Watch) -> bool {
        true
    }
}

impl fmt::Debug for Watch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0.is_some() { "Watch(..)" } else { "Watch(none)" })
    }
}
