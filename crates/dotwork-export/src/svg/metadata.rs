//! The settings that travel inside the file, found again: also after Inkscape or another editor has saved it.
//!
//! The settings stand in an element `settings` of our own namespace inside `<metadata>`. Editors move namespace
//! declarations, rename prefixes, indent and re-escape, so a small scanner reads tags, comments and CDATA sections and
//! looks for that local name in a document that declares the namespace. Anything that is not so gives `None`.

use crate::xml::unescaped;

/// The namespace of dotwork's own elements.
pub(crate) const NAMESPACE: &str = "urn:dotwork:settings";

/// The element that holds the settings.
pub(crate) const ELEMENT: &str = "settings";

/// The settings text inside an SVG that dotwork wrote, or `None` if there is none.
///
/// ```
/// use dotwork_drawing::{Color, Drawing, Page};
/// use dotwork_export::{SvgOptions, svg_metadata, write_svg};
///
/// let mut file = Vec::new();
/// let options = SvgOptions { metadata: Some("tone = 0.3"), ..SvgOptions::default() };
/// write_svg(&mut file, &Drawing::new(Page::default(), Color::WHITE), &options)?;
/// assert_eq!(svg_metadata(&file).as_deref(), Some("tone = 0.3"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn svg_metadata(bytes: &[u8]) -> Option<String> {
    let mut markup = Markup { bytes, at: 0 };
    let mut declared = false;
    loop {
        let Tag { name, attributes, empty } = markup.next_tag()?;
        declared |= contains(attributes, NAMESPACE.as_bytes());
        if declared && !empty && local_name(name) == ELEMENT.as_bytes() {
            return markup.content();
        }
    }
}

/// A start tag.
struct Tag<'a> {
    name: &'a [u8],
    /// What stands between the name and the end of the tag.
    attributes: &'a [u8],
    /// Ends in `/>`.
    empty: bool,
}

/// A reading place in a document.
struct Markup<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Markup<'a> {
    /// The next start tag; the reading place is behind it.
    fn next_tag(&mut self) -> Option<Tag<'a>> {
        loop {
            self.at += find(&self.bytes[self.at..], b"<")?;
            let rest = &self.bytes[self.at..];
            if rest.starts_with(b"<!--") {
                self.skip_past(b"-->")?;
            } else if rest.starts_with(b"<![CDATA[") {
                self.skip_past(b"]]>")?;
            } else if rest.starts_with(b"<?") || rest.starts_with(b"</") || rest.starts_with(b"<!") {
                self.skip_past(b">")?;
            } else {
                let inside = &rest[1..tag_end(rest)?];
                self.at += inside.len() + 2;
                let empty = inside.ends_with(b"/");
                let end = inside.iter().position(|b| b.is_ascii_whitespace() || *b == b'/');
                let (name, attributes) = inside.split_at(end.unwrap_or(inside.len()));
                return Some(Tag { name, attributes, empty });
            }
        }
    }

    /// The text up to the next end tag. Elements inside are not ours: their tags are left out.
    fn content(&mut self) -> Option<String> {
        let mut text = String::new();
        loop {
            let end = find(&self.bytes[self.at..], b"<")?;
            text += &unescaped(str::from_utf8(&self.bytes[self.at..self.at + end]).ok()?);
            self.at += end;
            let rest = &self.bytes[self.at..];
            if rest.starts_with(b"</") {
                return Some(text);
            } else if let Some(verbatim) = rest.strip_prefix(b"<![CDATA[") {
                text += str::from_utf8(&verbatim[..find(verbatim, b"]]>")?]).ok()?;
                self.skip_past(b"]]>")?;
            } else if rest.starts_with(b"<!--") {
                self.skip_past(b"-->")?;
            } else {
                self.skip_past(b">")?;
            }
        }
    }

    fn skip_past(&mut self, end: &[u8]) -> Option<()> {
        self.at += find(&self.bytes[self.at..], end)? + end.len();
        Some(())
    }
}

/// Where the tag that begins `rest` has its `>`: not inside a quoted attribute.
fn tag_end(rest: &[u8]) -> Option<usize> {
    let mut quote = None;
    rest.iter().position(|&b| {
        match (quote, b) {
            (None, b'>') => return true,
            (None, b'"' | b'\'') => quote = Some(b),
            (Some(q), b) if q == b => quote = None,
            _ => {}
        }
        false
    })
}

fn local_name(name: &[u8]) -> &[u8] {
    &name[name.iter().position(|&b| b == b':').map_or(0, |colon| colon + 1)..]
}

fn find(bytes: &[u8], what: &[u8]) -> Option<usize> {
    match what {
        [one] => bytes.iter().position(|b| b == one),
        _ => bytes.windows(what.len()).position(|w| w == what),
    }
}

fn contains(bytes: &[u8], what: &[u8]) -> bool {
    find(bytes, what).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::tests::svg;
    use crate::testing::drawing;
    use crate::{SvgOptions, Touch};
    use dotwork_drawing::hash::mix;

    const SETTINGS: &str = "[camera]\nname = \"a < b & c > d ]]> 'é😀'\"\n\n\ttwo = 2  # two  spaces\n";

    fn file() -> Vec<u8> {
        let options = SvgOptions { metadata: Some(SETTINGS), touch: Touch::Tick, ..SvgOptions::default() };
        svg(&drawing(), &options).into_bytes()
    }

    #[test]
    fn settings_come_back() {
        assert_eq!(svg_metadata(&file()).as_deref(), Some(SETTINGS));
        for settings in ["", "\r\n", "<settings>", "</dotwork:settings>"] {
            let options = SvgOptions { metadata: Some(settings), ..SvgOptions::default() };
            assert_eq!(svg_metadata(svg(&drawing(), &options).as_bytes()).as_deref(), Some(settings));
        }
        assert_eq!(svg_metadata(svg(&drawing(), &SvgOptions::default()).as_bytes()), None);
    }

    /// What Inkscape 1.2 makes of the file: the declaration on the root, attributes on lines of their own, quotes
    /// escaped in text, an id on every element.
    #[test]
    fn after_inkscape_has_saved_the_file() {
        let saved = "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"no\"?>\n<svg\n   width=\"10mm\"\n   \
                     xmlns=\"http://www.w3.org/2000/svg\"\n   xmlns:dotwork=\"urn:dotwork:settings\">\n  \
                     <metadata\n     id=\"metadata6\">\n    <dotwork:settings\n       version=\"1\">[a]\n  x = \
                     &quot;1 &lt; 2&quot;\n</dotwork:settings>\n  </metadata>\n</svg>";
        assert_eq!(svg_metadata(saved.as_bytes()).as_deref(), Some("[a]\n  x = \"1 < 2\"\n"));
    }

    #[test]
    fn other_ways_to_write_the_same() {
        for (document, settings) in [
            ("<a xmlns='urn:dotwork:settings'><settings>x</settings></a>", Some("x")),
            (
                "<a xmlns:n='urn:dotwork:settings'><n:settings q='>'>x<![CDATA[<&>]]>y</n:settings>",
                Some("x<&>y"),
            ),
            (
                "<!-- <settings> --><n:settings xmlns:n='urn:dotwork:settings'>a<!-- c -->b</n:settings>",
                Some("ab"),
            ),
            ("<settings>not ours</settings>", None),
            ("<a xmlns='urn:dotwork:settings'><settings/><b/></a>", None),
            ("<a xmlns='urn:dotwork:settings'><settings>never ends", None),
            ("<a xmlns='urn:dotwork:settings", None),
            ("", None),
            ("<", None),
        ] {
            assert_eq!(svg_metadata(document.as_bytes()).as_deref(), settings, "{document}");
        }
        assert_eq!(svg_metadata(b"<a xmlns='urn:dotwork:settings'><settings>\xff</settings></a>"), None);
    }

    #[test]
    fn broken_files_do_not_panic() {
        let file = file();
        let file = &file[..file.len().min(1500)];
        for end in 0..file.len() {
            // Whatever still holds the whole element gives the whole text, and nothing gives a part of it.
            if let Some(text) = svg_metadata(&file[..end]) {
                assert_eq!(text, SETTINGS);
            }
        }
        for round in 0..4000u32 {
            let mut bytes = file.to_vec();
            for k in 0..4 {
                let h = mix(round * 4 + k);
                let at = h as usize % bytes.len();
                bytes[at] = *b"<>&;!-[]?/'\"x\xff\xc3:".get(h as usize >> 16 & 15).unwrap();
            }
            let _ = svg_metadata(&bytes);
        }
    }
}
