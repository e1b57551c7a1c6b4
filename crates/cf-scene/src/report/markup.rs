//! Small pieces of HTML, and numbers for people.

pub(super) use cf_output::escape;
use std::fmt::Write;

/// A link to a file beside the page.
pub(super) fn link(file: &str, words: &str) -> String {
    format!("<a href=\"{}\">{}</a>", address(file), escape(words))
}

/// A relative file name as an address.
pub(super) fn address(file: &str) -> String {
    let mut out = String::new();
    for byte in file.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._/".contains(&byte) {
            out.push(char::from(byte));
        } else {
            let _ = write!(out, "%{byte:02X}");
        }
    }
    out
}

/// Four digits, with an exponent only where it helps.
pub(super) fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || !x.is_finite() {
        format!("{x}")
    } else if (1e-3..1e5).contains(&size) {
        let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{x:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{x:.3e}")
    }
}

/// Seconds, minutes or hours.
pub(super) fn seconds(s: f64) -> String {
    match s {
        s if !s.is_finite() => "unknown".into(),
        s if s < 1e-3 => format!("{:.1} µs", s * 1e6),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s if s < 100.0 => format!("{s:.1} s"),
        s if s < 3600.0 => format!("{} min {} s", s as u64 / 60, s as u64 % 60),
        s => format!("{} h {} min", s as u64 / 3600, s as u64 / 60 % 60),
    }
}

/// Bytes in powers of ten.
pub(super) fn bytes(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1e3 => format!("{b:.0} B"),
        b if b < 1e6 => format!("{:.0} kB", b / 1e3),
        b if b < 1e9 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.2} GB", b / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        let shown = [0.0, 12.5, 29.9876, -0.25, 123456.0, 1.0e-16, 1000.0, f64::NAN].map(number);
        assert_eq!(shown, ["0", "12.5", "29.99", "-0.25", "1.235e5", "1.000e-16", "1000", "NaN"]);
    }

    #[test]
    fn addresses_have_no_special_characters() {
        assert_eq!(address("a b/c\"<é>.png"), "a%20b/c%22%3C%C3%A9%3E.png");
    }
}
