//! Numbers and tables for people.

use std::fmt::Write;

/// `3.2 s`, `4 min 10 s`, `2 h 5 min`.
pub fn seconds(s: f64) -> String {
    match s {
        s if !s.is_finite() => "unknown".into(),
        s if s < 1e-3 => format!("{:.0} µs", s * 1e6),
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 10.0 && s.fract() != 0.0 => format!("{s:.1} s"),
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 3600.0 => format!("{} min {} s", s as u64 / 60, s as u64 % 60),
        s => format!("{:.0} h {} min", (s / 3600.0).floor(), (s as u64 / 60) % 60),
    }
}

/// `12 kB`, `3.4 MB`, `2.20 GB`: powers of ten.
pub fn bytes(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1e3 => format!("{b:.0} B"),
        b if b < 1e6 => format!("{:.0} kB", b / 1e3),
        b if b < 1e9 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.2} GB", b / 1e9),
    }
}

/// `256 x 512`.
pub fn cells(cells: &[usize]) -> String {
    cells.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x ")
}

/// Columns as wide as their widest entry, two blanks apart; numbers to the right.
pub fn table(heads: &[&str], rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let entries = rows.iter().filter_map(|row| row.get(column)).map(|entry| entry.chars().count());
        entries.chain([heads[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..heads.len()).map(width).collect();
    let number = |entry: &str| entry.starts_with(|c: char| c.is_ascii_digit() || c == '-') && entry != "-";
    let right: Vec<bool> = (0..heads.len())
        .map(|column| !rows.is_empty() && rows.iter().all(|r| r.get(column).is_none_or(|e| number(e) || e == "-")))
        .collect();
    let mut out = String::new();
    let mut line = |entries: &mut dyn Iterator<Item = &str>| {
        let mut text = String::new();
        for (column, entry) in entries.take(heads.len()).enumerate() {
            let pad = " ".repeat(widths[column] - entry.chars().count());
            let _ = if right[column] { write!(text, "{pad}{entry}  ") } else { write!(text, "{entry}{pad}  ") };
        }
        out.push_str(text.trim_end());
        out.push('\n');
    };
    line(&mut heads.iter().copied());
    for row in rows {
        line(&mut row.iter().map(String::as_str));
    }
    out
}

/// Breaks text into lines of at most `width` characters, each after `indent`.
pub fn wrap(text: &str, indent: &str, width: usize) -> String {
    let mut out = String::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            let _ = writeln!(out, "{indent}{line}");
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    if !line.is_empty() {
        let _ = writeln!(out, "{indent}{line}");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_sizes_have_units_that_fit() {
        let times = [0.0002, 0.25, 3.25, 42.0, 250.0, 7500.0, f64::NAN].map(seconds);
        assert_eq!(times, ["200 µs", "250 ms", "3.2 s", "42 s", "4 min 10 s", "2 h 5 min", "unknown"]);
        assert_eq!([12, 3_400_000, 2_200_000_000].map(bytes), ["12 B", "3.4 MB", "2.20 GB"]);
    }

    #[test]
    fn numbers_stand_to_the_right() {
        let rows = vec![vec!["a".to_owned(), "5".to_owned()], vec!["bcd".to_owned(), "10".to_owned()]];
        assert_eq!(table(&["name", "n"], &rows), "name   n\na      5\nbcd   10\n");
    }

    #[test]
    fn lines_break_between_words() {
        assert_eq!(wrap("one two three", "  ", 8), "  one two\n  three\n");
    }
}
