//! The valid name nearest to a mistyped one.

use crate::error::shorten;

/// The candidate with the fewest edits, if it is near enough to be what was meant: a third of its length, at least one;
/// or one that begins with what was written.
pub fn nearest<'a>(written: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    const LONGEST: usize = 64; // a longer name is not a slip of the finger, and the distance costs its square
    if written.is_empty() || written.chars().nth(LONGEST).is_some() {
        return None;
    }
    candidates
        .into_iter()
        .filter(|candidate| candidate.chars().count() <= LONGEST)
        .map(|candidate| (written.to_lowercase(), candidate.to_lowercase(), candidate))
        .map(|(short, long, candidate)| {
            (distance(&short, &long), short.len() > 2 && long.starts_with(&short), candidate)
        })
        .filter(|(edits, begun, name)| {
            *begun || *edits <= (name.chars().count().max(written.chars().count()) / 3).max(1)
        })
        .map(|(edits, _, candidate)| (edits, candidate))
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate.to_owned())
}

/// A list for a sentence: `` `a`, `b` or `c` ``.
pub(crate) fn one_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{}`", shorten(name))).collect();
    match names.as_slice() {
        [] => "nothing".to_owned(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} or {last}", most.join(", ")),
    }
}

/// Insertions, deletions, replacements and swaps of neighbours (optimal string alignment).
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut before: Vec<usize> = Vec::new();
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, y) in b.iter().enumerate() {
            let mut best = (last[j] + usize::from(x != y)).min(last[j + 1] + 1).min(row[j] + 1);
            if i > 0 && j > 0 && *x == b[j - 1] && a[i - 1] == *y {
                best = best.min(before[j - 1] + 1);
            }
            row.push(best);
        }
        before = std::mem::replace(&mut last, row);
    }
    last.last().copied().unwrap_or(a.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_is_recognised_and_a_stranger_is_not() {
        let keys = ["k", "tau", "c", "hc", "cone_angle", "fourier"];
        assert_eq!(nearest("tua", keys).as_deref(), Some("tau"));
        assert_eq!(nearest("Fourrier", keys).as_deref(), Some("fourier"));
        assert_eq!(nearest("coneangle", keys).as_deref(), Some("cone_angle"));
        assert_eq!(nearest("cone", keys).as_deref(), Some("cone_angle"));
        assert_eq!(nearest("temperature", keys), None);
        assert_eq!(nearest("", keys), None);
        assert_eq!(nearest(&"x".repeat(100_000), keys), None);
    }

    #[test]
    fn lists_read_as_sentences() {
        assert_eq!(one_of([]), "nothing");
        assert_eq!(one_of(["a"]), "`a`");
        assert_eq!(one_of(["a\nb"]), "`a\\nb`");
        assert_eq!(one_of(["a", "b", "c"]), "`a`, `b` or `c`");
    }
}
