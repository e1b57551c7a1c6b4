//! Escaping for XML and JSON, and numbers that read back to the same bits.

use std::fmt::Write;

/// Shortest decimal that reads back exactly; exponents where they are shorter.
pub(crate) fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Several numbers, separated by spaces.
pub(crate) fn numbers(values: &[f64]) -> String {
    values.iter().map(|&v| number(v)).collect::<Vec<_>>().join(" ")
}

/// Text that stands for itself in XML and HTML, also inside double quotes. Line breaks and tabs survive attribute
/// normalisation; other control characters, which XML cannot say, become U+FFFD.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&apos;"),
            '\n' | '\r' | '\t' => _ = write!(out, "&#{};", c as u32),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// The inverse of [`escape`]; unknown entities stay as they are.
pub(crate) fn unescape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('&') {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let entity = rest.find(';').map(|end| &rest[1..end]);
        let meant = entity.and_then(|e| match e {
            "amp" => Some('&'),
            "lt" => Some('<'),
            "gt" => Some('>'),
            "quot" => Some('"'),
            "apos" => Some('\''),
            _ => e.strip_prefix('#')?.parse().ok().and_then(char::from_u32),
        });
        match (meant, entity) {
            (Some(c), Some(e)) => {
                out.push(c);
                rest = &rest[e.len() + 2..];
            }
            _ => {
                out.push('&');
                rest = &rest[1..];
            }
        }
    }
    out + rest
}

/// A JSON string with its quotes.
pub(crate) fn json(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() => _ = write!(out, "\\u{:04x}", c as u32),
            c => out.push(c),
        }
    }
    out + "\""
}

/// A JSON number; JSON has no word for what is not finite, so that becomes `null`.
pub(crate) fn json_number(value: f64) -> String {
    if value.is_finite() { number(value) } else { "null".into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn numbers_read_back_to_the_same_bits(bits: u64) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            prop_assert_eq!(number(value).parse::<f64>().unwrap().to_bits(), bits);
        }

        #[test]
        fn xml_survives_the_round_trip(text in "[^\\p{Cc}]*") {
            prop_assert_eq!(unescape(&escape(&text)), text);
        }

        #[test]
        fn unescaping_never_fails(text: String) {
            unescape(&text);
        }
    }

    #[test]
    fn markup_is_neutralised() {
        assert_eq!(escape("a<b>&\"c'\n"), "a&lt;b&gt;&amp;&quot;c&apos;&#10;");
        assert_eq!(unescape("&#10;&nope;&"), "\n&nope;&");
        assert_eq!(json("a\"\\\u{1}é"), "\"a\\\"\\\\\\u0001é\"");
        assert_eq!(json_number(f64::NAN), "null");
        assert_eq!(number(1e-7), "1e-7");
    }
}
