//! A scene text pieced together from a file and its overrides, which remembers where each piece was written.

use super::tree::Node;
use super::{BYTE_ORDER_MARK, Flaw, line_column, scan};
use crate::error::{Detail, Place, SceneError};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A text that somebody wrote: a scene file, or a flag.
#[derive(Debug, PartialEq)]
pub(crate) enum Written {
    /// A scene file, or a part of it that overrides another.
    File { name: String, text: String },
    /// A `--set` flag.
    Flag { text: String },
}

/// Where a piece of merged text was written.
#[derive(Clone, Debug)]
pub(crate) struct Origin {
    pub(crate) written: Arc<Written>,
    /// The preset or variant on whose behalf the piece came in.
    pub(crate) via: Option<Arc<str>>,
    /// Bytes of the written text.
    pub(crate) span: Range<usize>,
}

impl Origin {
    /// The same origin, narrowed to a part of its text.
    pub(crate) fn part(&self, span: Range<usize>) -> Self {
        Origin { span, ..self.clone() }
    }

    /// The place for an error message.
    pub(crate) fn place(&self) -> Place {
        match &*self.written {
            Written::Flag { text } => Place::Flag { flag: text.clone(), span: self.span.clone() },
            Written::File { name, text } => {
                let (line, column) = line_column(text, self.span.start);
                let via = self.via.as_deref().map(str::to_owned);
                Place::File { file: name.clone(), span: self.span.clone(), line, column, via }
            }
        }
    }

    /// An error at this origin.
    pub(crate) fn error(&self, detail: impl Into<Box<Detail>>) -> SceneError {
        SceneError::new(self.place(), detail)
    }
}

/// A run of merged bytes. A piece as long as its origin maps byte by byte; other pieces are glue and map as a whole.
#[derive(Clone, Debug)]
struct Piece {
    length: usize,
    origin: Origin,
}

impl Piece {
    fn is_glue(&self) -> bool {
        self.length != self.origin.span.len()
    }

    /// The part of a piece between two of its own bytes.
    fn cut(&self, part: Range<usize>) -> Piece {
        let at = self.origin.span.start;
        let span = if self.is_glue() { self.origin.span.clone() } else { at + part.start..at + part.end };
        Piece { length: part.len(), origin: self.origin.part(span) }
    }
}

/// The merged text, its tree, and the map back to what was written.
#[derive(Clone, Debug)]
pub(crate) struct Merged {
    pub(crate) text: String,
    pub(crate) tree: Node,
    pieces: Vec<Piece>,
    file: Origin,
}

impl Merged {
    /// A scene file with no override yet.
    pub(crate) fn from_file(name: &str, text: &str) -> Result<Self, SceneError> {
        let written = Arc::new(Written::File { name: name.to_owned(), text: text.to_owned() });
        let scene = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        let start = text.len() - scene.len();
        let origin = Origin { written, via: None, span: start..text.len() };
        let place = |span: Range<usize>| origin.part(start + span.start..start + span.end);
        let tree = scan::scan(scene).map_err(|flaw| place(flaw.span).error(flaw.detail))?;
        let pieces = vec![Piece { length: scene.len(), origin: origin.clone() }];
        Ok(Merged { text: scene.to_owned(), tree, pieces, file: origin })
    }

    /// The origin of a range of merged bytes; where the range spans several pieces, that of its beginning.
    pub(crate) fn origin(&self, span: Range<usize>) -> Origin {
        let mut start = 0;
        for (i, piece) in self.pieces.iter().enumerate() {
            let end = start + piece.length;
            if span.start < end || i + 1 == self.pieces.len() {
                if piece.is_glue() {
                    return piece.origin.clone();
                }
                let last = span.end.clamp(span.start, end.max(span.start)) - start;
                return piece.cut((span.start - start).min(piece.length)..last.min(piece.length)).origin;
            }
            start = end;
        }
        self.file.clone()
    }

    /// The folder that the file lies in, as far as its name says.
    pub(crate) fn folder(&self) -> PathBuf {
        match &*self.file.written {
            Written::File { name, .. } => Path::new(name).parent().map(Path::to_owned).unwrap_or_default(),
            Written::Flag { .. } => PathBuf::new(),
        }
    }

    /// An error at a range of merged bytes.
    pub(crate) fn error(&self, span: Range<usize>, detail: impl Into<Box<Detail>>) -> SceneError {
        self.origin(span).error(detail)
    }

    /// Puts texts in the place of `range`. A text as long as its origin maps byte by byte, others as a whole.
    pub(crate) fn replace(&mut self, range: Range<usize>, parts: &[(&str, &Origin)]) -> Result<(), SceneError> {
        let mut pieces = Vec::with_capacity(self.pieces.len() + 2);
        let (mut start, mut placed) = (0, false);
        let new = parts.iter().map(|(text, origin)| Piece { length: text.len(), origin: (*origin).clone() });
        for piece in &self.pieces {
            let end = start + piece.length;
            if start < range.start {
                pieces.push(piece.cut(0..range.start.min(end) - start));
            }
            if !placed && end >= range.start {
                pieces.extend(new.clone());
                placed = true;
            }
            if end > range.end {
                pieces.push(piece.cut(range.end.max(start) - start..piece.length));
            }
            start = end;
        }
        let mut merged = self.text.clone();
        merged.replace_range(range, &parts.iter().map(|(text, _)| *text).collect::<String>());
        let blamed = parts.last().map_or(&self.file, |(_, origin)| origin);
        self.tree = scan::scan(&merged).map_err(|Flaw { detail, .. }| blamed.error(detail))?;
        (self.text, self.pieces) = (merged, pieces);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_maps_back_to_where_it_was_written() {
        let mut merged = Merged::from_file("s.ron", "(a: 1, b: 22)").unwrap();
        let written = Arc::new(Written::Flag { text: "b=333".to_owned() });
        let origin = Origin { written, via: None, span: 2..5 };
        merged.replace(10..12, &[("333", &origin)]).unwrap();
        assert_eq!(merged.text, "(a: 1, b: 333)");
        assert_eq!(merged.origin(11..12).span, 3..4);
        assert!(matches!(merged.origin(10..13).place(), Place::Flag { span, .. } if span == (2..5)));
        assert!(matches!(merged.origin(4..5).place(), Place::File { span, .. } if span == (4..5)));
        assert!(matches!(merged.origin(13..14).place(), Place::File { span, .. } if span == (12..13)));
        merged.replace(7..7, &[("z: 9, ", &origin)]).unwrap(); // glue: longer than its origin
        assert_eq!(merged.text, "(a: 1, z: 9, b: 333)");
        assert_eq!(merged.origin(8..9).span, 2..5);
        assert_eq!(merged.origin(17..18).span, 3..4);
    }
}
