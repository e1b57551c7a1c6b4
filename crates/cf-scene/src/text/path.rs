//! Paths of keys: `model.sources[0].rate`.

use crate::error::Detail;
use std::fmt;

/// A key, or the position of an item in a list or tuple.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Step {
    /// The key of a struct or map.
    Key(String),
    /// The position of an item, counted from 0.
    Index(usize),
}

/// The way from the top of a scene to one of its values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Path(pub Vec<Step>);

impl Path {
    /// Reads `key.key[0].key`. Empty paths and empty keys are refused.
    pub fn parse(text: &str) -> Result<Self, Box<Detail>> {
        let malformed = |problem: String| {
            Box::new(
                Detail::new(problem)
                    .expected("keys joined by dots and positions in brackets, such as model.sources[0].rate"),
            )
        };
        let mut steps = Vec::new();
        for part in text.trim().split('.') {
            let (key, positions) = part.split_at(part.find('[').unwrap_or(part.len()));
            if key.is_empty() || !key.chars().all(|c| c.is_alphanumeric() || c == '_') {
                return Err(malformed(format!("`{}` is not a path of keys", crate::error::shorten(text))));
            }
            steps.push(Step::Key(key.to_owned()));
            for position in positions.split_terminator(']') {
                let index = position.strip_prefix('[').and_then(|digits| digits.trim().parse().ok());
                let index = index.filter(|_| positions.ends_with(']')).ok_or_else(|| {
                    malformed(format!("`{}` does not name a position in a list", crate::error::shorten(part)))
                })?;
                steps.push(Step::Index(index));
            }
        }
        Ok(Path(steps))
    }

    /// The first key.
    pub fn head(&self) -> &str {
        match self.0.first() {
            Some(Step::Key(key)) => key,
            _ => "",
        }
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if key.is_empty() => {}
                Step::Key(key) if key.chars().all(|c| c.is_alphanumeric() || c == '_') => {
                    write!(f, "{}{key}", if i > 0 { "." } else { "" })?;
                }
                Step::Key(key) => write!(f, "[{:?}]", crate::error::shorten(key))?,
                Step::Index(index) => write!(f, "[{index}]")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_prints_as_it_was_read() {
        for text in ["grid", "model.sources[0].rate", "a[1][2].b_c"] {
            assert_eq!(Path::parse(text).map(|path| path.to_string()), Ok(text.to_owned()));
        }
    }

    #[test]
    fn what_is_not_a_path_is_refused() {
        for text in ["", ".", "a.", ".a", "a[", "a[x]", "a[0", "a[-1]", "a b", "a[0]b", "[0]"] {
            assert!(Path::parse(text).is_err(), "{text:?}");
        }
    }
}
