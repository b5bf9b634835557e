//! Warnings are collected and returned; only the outermost program prints them.

use std::fmt;

/// One thing a user should know: what happened, how often, and where first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What happened, as a clause that reads well after a count ("degenerate triangles dropped").
    pub what: String,
    /// How often; 1 for a statement about the whole.
    pub count: u64,
    /// Where it happened first, if there is a place ("triangle 812").
    pub first: Option<String>,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.count > 1 {
            write!(f, "{} ", self.count)?;
        }
        f.write_str(&self.what)?;
        match &self.first {
            Some(place) if self.count > 1 => write!(f, ", first at {place}"),
            Some(place) => write!(f, " ({place})"),
            None => Ok(()),
        }
    }
}

/// A list of warnings in the order in which they arose; repeated ones are counted, not repeated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Warnings(Vec<Warning>);

impl Warnings {
    /// An empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a statement without a count.
    pub fn say(&mut self, what: impl Into<String>) {
        self.counted(what, 1, None);
    }

    /// Adds `count` occurrences of `what`, the first at `first`. A count of 0 adds nothing.
    pub fn counted(&mut self, what: impl Into<String>, count: u64, first: Option<String>) {
        if count == 0 {
            return;
        }
        let what = what.into();
        match self.0.iter_mut().find(|w| w.what == what) {
            // A statement (count 1, no place) said twice is still one statement.
            Some(w) if first.is_none() && w.first.is_none() && count == 1 => w.count = w.count.max(1),
            Some(w) => w.count += count,
            None => self.0.push(Warning { what, count, first }),
        }
    }

    /// Moves all of `other` to the end of this list.
    pub fn append(&mut self, other: Warnings) {
        for w in other.0 {
            self.counted(w.what, w.count, w.first);
        }
    }

    /// The warnings in order.
    pub fn iter(&self) -> impl Iterator<Item = &Warning> {
        self.0.iter()
    }

    /// True if nothing was said.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_places_and_repeats() {
        let mut w = Warnings::new();
        w.counted("degenerate triangles dropped", 2, Some("triangle 812".into()));
        w.counted("degenerate triangles dropped", 1, Some("triangle 900".into()));
        w.say("too light");
        w.say("too light");
        w.counted("nothing", 0, None);
        let lines: Vec<String> = w.iter().map(ToString::to_string).collect();
        assert_eq!(lines, ["3 degenerate triangles dropped, first at triangle 812", "too light"]);
    }
}
