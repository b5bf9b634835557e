//! Text inside XML 1.0: escaped on the way out, characters that XML cannot hold replaced.

/// `text` as the content of an element or the value of an attribute.
///
/// XML 1.0 forbids most control characters even as references; they become U+FFFD. Carriage returns, and in
/// attributes also tabs and line feeds, are written as references, or a parser would turn them into something else.
pub(crate) fn escaped(text: &str, attribute: bool) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 16);
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' if attribute => out.push_str("&quot;"),
            '\r' => out.push_str("&#13;"),
            '\t' if attribute => out.push_str("&#9;"),
            '\n' if attribute => out.push_str("&#10;"),
            '\t' | '\n' => out.push(c),
            '\0'..' ' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// The text that stands behind `escaped`: the five named references and numbers. An unknown or broken reference stays
/// as it is.
pub(crate) fn unescaped(escaped: &str) -> String {
    let mut out = String::with_capacity(escaped.len());
    let mut rest = escaped;
    while let Some(at) = rest.find('&') {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        // No reference is longer than `&#1114111;` with a few leading zeros.
        let end = rest.bytes().take(16).position(|b| b == b';');
        match end.and_then(|end| Some((end, reference(&rest[1..end])?))) {
            Some((end, c)) => {
                out.push(c);
                rest = &rest[end + 1..];
            }
            None => {
                out.push('&');
                rest = &rest[1..];
            }
        }
    }
    out.push_str(rest);
    out
}

fn reference(name: &str) -> Option<char> {
    Some(match name {
        "amp" => '&',
        "lt" => '<',
        "gt" => '>',
        "quot" => '"',
        "apos" => '\'',
        _ => {
            let number = name.strip_prefix('#')?;
            let code = match number.strip_prefix(['x', 'X']) {
                Some(hex) => u32::from_str_radix(hex, 16),
                None => number.parse(),
            };
            char::from_u32(code.ok()?)?
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_texts() {
        let text = "a < b && \"c\" > 'd'\r\n\t\u{1}\u{fffe}é😀";
        let content = "a &lt; b &amp;&amp; \"c\" &gt; 'd'&#13;\n\t\u{fffd}\u{fffd}é😀";
        assert_eq!(escaped(text, false), content);
        let attribute = "a &lt; b &amp;&amp; &quot;c&quot; &gt; 'd'&#13;&#10;&#9;\u{fffd}\u{fffd}é😀";
        assert_eq!(escaped(text, true), attribute);
        for escaped in [content, attribute] {
            assert_eq!(unescaped(escaped), text.replace(['\u{1}', '\u{fffe}'], "\u{fffd}"));
        }
    }

    #[test]
    fn references() {
        for (escaped, text) in [
            ("&#65;&#x42;&#X43;&apos;", "ABC'"),
            ("&amp;lt;", "&lt;"),
            ("&nbsp; & &; &#; &#x; &#xd800; &#9999999999;", "&nbsp; & &; &#; &#x; &#xd800; &#9999999999;"),
            ("&", "&"),
            ("&é;", "&é;"),
            ("&ééééééééééééééé;", "&ééééééééééééééé;"),
        ] {
            assert_eq!(unescaped(escaped), text);
        }
    }
}
