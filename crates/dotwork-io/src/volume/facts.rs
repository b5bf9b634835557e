//! What a person wants to know of a file beyond its voxels.

use crate::error::one_line;
use crate::volume::label_table::LabelTable;

/// Longest text of a fact, characters.
const LONGEST: usize = 120;
/// More facts than this are not kept.
const MOST: usize = 64;

/// What a file says.
#[derive(Clone, Debug, Default)]
pub(crate) struct Facts {
    /// Named facts in file order.
    pub(crate) list: Vec<(String, String)>,
    /// What its values mean, if it holds labels.
    pub(crate) labels: Option<LabelTable>,
}

impl Facts {
    /// Adds a fact, shortened to one line; one without a text is dropped.
    pub(crate) fn add(&mut self, name: impl AsRef<str>, text: impl AsRef<str>) {
        let text = short(text.as_ref());
        if !text.is_empty() && self.list.len() < MOST {
            self.list.push((short(name.as_ref()), text));
        }
    }

    /// Adds the sizes of all axes of the file.
    pub(crate) fn add_axes(&mut self, sizes: &[u64]) {
        let sizes: Vec<String> = sizes.iter().map(u64::to_string).collect();
        self.add("axes", sizes.join(" x "));
    }
}

/// One line of text, shortened.
pub(crate) fn short(text: &str) -> String {
    let text = text.trim();
    let mut line = one_line(&text.chars().take(LONGEST).collect::<String>());
    if text.chars().nth(LONGEST).is_some() {
        line.push('…');
    }
    line
}
