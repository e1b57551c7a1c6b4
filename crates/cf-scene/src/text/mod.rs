//! Scene text: scanned with positions, spliced with overrides, decoded with errors that point at what was typed.

pub(crate) mod decode;
mod lexemes;
pub(crate) mod merged;
pub(crate) mod path;
pub(crate) mod scan;
pub(crate) mod shorthand;
pub(crate) mod splice;
pub(crate) mod tree;

use crate::error::Detail;
use std::ops::Range;

/// A fault in a text that does not know yet which file or flag it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct Flaw {
    /// Bytes of the text.
    pub span: Range<usize>,
    /// What is wrong there.
    pub detail: Box<Detail>,
}

impl Flaw {
    pub(crate) fn new(span: Range<usize>, detail: Detail) -> Self {
        Flaw { span, detail: Box::new(detail) }
    }
}

/// What some editors put before the first character of a file. It says nothing about the text.
pub(crate) const BYTE_ORDER_MARK: char = '\u{feff}';

/// Line and column (in characters) of a byte, both counted from 1.
pub fn line_column(text: &str, byte: usize) -> (usize, usize) {
    let mut end = byte.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    // A byte order mark is no character of the first line.
    let before = before.strip_prefix(BYTE_ORDER_MARK).unwrap_or(before);
    let start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (1 + before.matches('\n').count(), 1 + before[start..].chars().count())
}
