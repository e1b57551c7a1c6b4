//! What is wrong with a scene, where, and what to do about it.
//!
//! A [`SceneError`] is a [`Place`] and a [`Detail`]. Its `Display` is one line for a terminal or a log; the fields
//! are public so that a program can draw a caret under [`Place::span`] instead.

use std::fmt;
use std::ops::Range;

/// One thing that is wrong with a scene or with a `--set` flag.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError {
    /// Where the offending text was written. Boxed, with the detail, so that a `Result` stays small.
    pub place: Box<Place>,
    /// What is wrong there.
    pub detail: Box<Detail>,
}

/// Where a piece of scene text came from.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// A position in the scene file.
    File {
        /// The file's name as it was given.
        file: String,
        /// Bytes of the file, for a caret.
        span: Range<usize>,
        /// Line, counted from 1.
        line: usize,
        /// Column in characters, counted from 1.
        column: usize,
        /// The override that brought this text in, such as `preset "draft"` or `variant "hc2"`; `None` for the scene itself.
        via: Option<String>,
    },
    /// A flag on the command line.
    Flag {
        /// The flag as it was typed, without `--set`.
        flag: String,
        /// Bytes of `flag`, for a caret.
        span: Range<usize>,
    },
    /// The preset that was asked for.
    Preset {
        /// Its name as it was given.
        name: String,
    },
    /// No particular text: a request that names something that does not exist.
    Whole {
        /// The file's name as it was given.
        file: String,
    },
}

impl Place {
    /// The offending bytes, in the scene file or in the flag; empty where no particular text is at fault.
    pub fn span(&self) -> Range<usize> {
        match self {
            Place::File { span, .. } | Place::Flag { span, .. } => span.clone(),
            Place::Preset { .. } | Place::Whole { .. } => 0..0,
        }
    }
}

/// What is wrong, apart from where.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detail {
    /// The key's path from the top of the scene, such as `model.law.k`; empty at the top itself.
    pub path: String,
    /// The problem, in one clause.
    pub problem: String,
    /// What would have been right.
    pub expected: Option<String>,
    /// What stands there.
    pub found: Option<String>,
    /// The valid name nearest to the one that was written.
    pub nearest: Option<String>,
    /// What to do about it, as a sentence.
    pub advice: Option<String>,
}

impl Detail {
    /// A detail that says only what the problem is.
    pub fn new(problem: impl Into<String>) -> Self {
        Detail { problem: problem.into(), ..Detail::default() }
    }

    /// The same, at a path.
    pub fn at(mut self, path: impl Into<String>) -> Self {
        self.path = path.into();
        self
    }

    /// The same, with what would have been right.
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    /// The same, with what stands there.
    pub fn found(mut self, found: impl Into<String>) -> Self {
        self.found = Some(found.into());
        self
    }

    /// The same, with the nearest valid name, if there is one.
    pub fn nearest(mut self, nearest: Option<String>) -> Self {
        self.nearest = nearest;
        self
    }

    /// The same, with what to do about it.
    pub fn advice(mut self, advice: impl Into<String>) -> Self {
        self.advice = Some(advice.into());
        self
    }
}

impl SceneError {
    /// An error at a place.
    pub fn new(place: Place, detail: impl Into<Box<Detail>>) -> Self {
        SceneError { place: Box::new(place), detail: detail.into() }
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.detail)
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File { file, line, column, via, .. } => {
                write!(f, "{file}:{line}:{column}")?;
                via.iter().try_for_each(|via| write!(f, " ({via})"))
            }
            Place::Flag { flag, .. } => write!(f, "--set {}", shorten(flag)),
            Place::Preset { name } => write!(f, "--preset {}", shorten(name)),
            Place::Whole { file } => f.write_str(file),
        }
    }
}

impl fmt::Display for Detail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.path.is_empty() {
            write!(f, "{}: ", cut(&self.path, LONGEST_PATH))?;
        }
        f.write_str(&self.problem)?;
        match (&self.expected, &self.found) {
            (Some(expected), Some(found)) => write!(f, ": expected {expected}, found {found}")?,
            (Some(expected), None) => write!(f, ": expected {expected}")?,
            (None, Some(found)) => write!(f, ": found {found}")?,
            (None, None) => {}
        }
        self.nearest.iter().try_for_each(|name| write!(f, "; did you mean `{}`?", shorten(name)))?;
        self.advice.iter().try_for_each(|advice| write!(f, "; {advice}"))
    }
}

impl std::error::Error for SceneError {}

/// One or more [`SceneError`]s, in the order in which they were found, each once.
#[derive(Clone, Debug, PartialEq)]
pub struct Problems {
    first: SceneError,
    others: Vec<SceneError>,
}

impl Problems {
    /// The problems of a list, or `None` where the list is empty.
    pub fn from_list(list: Vec<SceneError>) -> Option<Self> {
        let mut list = list.into_iter();
        let mut all = Problems { first: list.next()?, others: Vec::new() };
        list.for_each(|error| all.add(error));
        Some(all)
    }

    /// Adds a problem unless it is already there.
    pub fn add(&mut self, error: SceneError) {
        if !self.iter().any(|known| *known == error) {
            self.others.push(error);
        }
    }

    /// The problem found first.
    pub fn first(&self) -> &SceneError {
        &self.first
    }

    /// All problems.
    pub fn iter(&self) -> impl Iterator<Item = &SceneError> {
        std::iter::once(&self.first).chain(&self.others)
    }
}

impl From<SceneError> for Problems {
    fn from(first: SceneError) -> Self {
        Problems { first, others: Vec::new() }
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.first)?;
        self.others.iter().try_for_each(|error| write!(f, "\n{error}"))
    }
}

impl std::error::Error for Problems {}

/// Characters of a path that are shown; no path of a scene is as long.
const LONGEST_PATH: usize = 120;

/// A quotation short enough for one line: control characters escaped, the end of a long text left out.
pub(crate) fn shorten(text: &str) -> String {
    cut(text, 60)
}

fn cut(text: &str, most: usize) -> String {
    let mut shown: String = text.chars().take(most).flat_map(printable).collect();
    if text.chars().nth(most).is_some() {
        shown.push('…');
    }
    shown
}

/// A number for a message: every digit, but an exponent instead of many zeros.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || (1e-5..1e9).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

fn printable(c: char) -> Vec<char> {
    if c.is_control() { c.escape_default().collect() } else { vec![c] }
}
