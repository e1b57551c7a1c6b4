//! Goldens: lines of `run key value`, stored and compared with a tolerance each.

use crate::show;

/// One number of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The run, or `claim`.
    pub run: String,
    /// What the number is.
    pub key: String,
    /// The number, or a word that must be the same.
    pub value: String,
    /// How far it may be from the stored one.
    pub allowed: f64,
}

impl Line {
    /// Something that must be the same.
    pub fn exact(run: &str, key: &str, value: impl ToString) -> Self {
        Line { run: word(run), key: word(key), value: value.to_string(), allowed: 0.0 }
    }

    /// A number with a tolerance.
    pub fn near(run: &str, key: &str, value: f64, allowed: f64) -> Self {
        Line { run: word(run), key: word(key), value: format!("{value:.12e}"), allowed }
    }
}

/// One word, so that a line splits at blanks.
fn word(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join("_")
}

/// The text of a golden: a heading, then aligned lines.
pub fn text(heading: &str, lines: &[Line]) -> String {
    // Claims have long names, which would push everything else far to the right.
    let short = || lines.iter().filter(|line| line.run != "claim");
    let width = |part: fn(&Line) -> &String| short().map(|line| part(line).chars().count()).max().unwrap_or(0);
    let (run, key) = (width(|line| &line.run), width(|line| &line.key));
    let body: String =
        lines.iter().map(|line| format!("{:<run$}  {:<key$}  {:>20}\n", line.run, line.key, line.value)).collect();
    format!("# {heading}\n{body}")
}

/// Every line that differs from the stored text, as a table; `None` where all agree.
pub fn differences(stored: &str, now: &[Line]) -> Option<String> {
    let before: Vec<[&str; 3]> = stored
        .lines()
        .filter(|line| !line.starts_with('#') && !line.trim().is_empty())
        .map(|line| {
            let mut words = line.split_whitespace();
            [(); 3].map(|()| words.next().unwrap_or(""))
        })
        .collect();
    let mut rows = Vec::new();
    for line in now {
        match before.iter().find(|[run, key, _]| *run == line.run && *key == line.key) {
            None => rows.push(row(&line.run, &line.key, "(none)", &line.value, line.allowed)),
            Some([_, _, value]) if !agree(value, line) => {
                rows.push(row(&line.run, &line.key, value, &line.value, line.allowed));
            }
            Some(_) => {}
        }
    }
    for [run, key, value] in before {
        if !now.iter().any(|line| line.run == run && line.key == key) {
            rows.push(row(run, key, value, "(none)", 0.0));
        }
    }
    let heads = ["run", "key", "stored", "now", "difference", "allowed"];
    (!rows.is_empty()).then(|| show::table(&heads, &rows))
}

fn row(run: &str, key: &str, stored: &str, now: &str, allowed: f64) -> Vec<String> {
    let difference = match (stored.parse::<f64>(), now.parse::<f64>()) {
        (Ok(a), Ok(b)) => format!("{:.2e}", (a - b).abs()),
        _ => "-".into(),
    };
    vec![run.into(), key.into(), stored.into(), now.into(), difference, format!("{allowed:.1e}")]
}

fn agree(stored: &str, now: &Line) -> bool {
    match (stored.parse::<f64>(), now.value.parse::<f64>()) {
        _ if stored == now.value => true,
        (Ok(a), Ok(b)) => (a - b).abs() <= now.allowed,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines() -> Vec<Line> {
        vec![
            Line::exact("hc_2", "cells", "8x16"),
            Line::exact("hc_2", "steps", 12),
            Line::near("hc_2", "mass", 2.5, 1e-9),
        ]
    }

    #[test]
    fn a_text_agrees_with_the_lines_it_was_made_of() {
        let text = text("a heading", &lines());
        assert!(text.starts_with("# a heading\nhc_2  cells "), "{text}");
        assert_eq!(differences(&text, &lines()), None);
    }

    #[test]
    fn what_differs_is_shown_with_both_values() {
        let stored = text("", &lines());
        let mut now = lines();
        now[2] = Line::near("hc_2", "mass", 2.5 + 1e-10, 1e-9);
        assert_eq!(differences(&stored, &now), None);
        now[2] = Line::near("hc_2", "mass", 2.6, 1e-9);
        now[1].key = "jumps".into();
        let table = differences(&stored, &now).unwrap_or_default();
        for part in ["mass", "2.500000000000e0", "2.600000000000e0", "1.00e-1", "jumps", "steps", "(none)"] {
            assert!(table.contains(part), "{part}\n{table}");
        }
        assert!(!table.contains("cells"));
    }

    #[test]
    fn not_a_number_agrees_with_nothing_else() {
        let stored = text("", &[Line::near("a", "b", f64::NAN, 1.0)]);
        assert_eq!(differences(&stored, &[Line::near("a", "b", f64::NAN, 1.0)]), None);
        assert!(differences(&stored, &[Line::near("a", "b", 0.0, 1.0)]).is_some());
    }
}
