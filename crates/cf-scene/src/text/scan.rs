//! From text to a tree. Bounded in size and depth; any text gives a tree or a [`Flaw`], never a panic.

use super::Flaw;
use super::lexemes::starts_word;
use super::tree::{Field, Node, Shape};
use crate::error::{Detail, shorten};
use std::collections::HashMap;
use std::ops::Range;

/// The largest scene text, in bytes.
pub const MAX_BYTES: usize = 1 << 20;
/// The deepest nesting of brackets.
pub const MAX_DEPTH: usize = 64;

/// Scans one RON value that fills the text, comments and blanks aside.
pub fn scan(text: &str) -> Result<Node, Flaw> {
    if text.len() > MAX_BYTES {
        let detail = Detail::new(format!("the text has {} bytes", text.len()));
        return Err(Flaw::new(0..0, detail.expected(format!("at most {MAX_BYTES}"))));
    }
    let mut scanner = Scanner { text, at: 0 };
    scanner.skip_blanks()?;
    if scanner.rest().is_empty() {
        return Err(Flaw::new(
            0..0,
            Detail::new("there is nothing here").expected("a value, such as (grid: …, model: …)"),
        ));
    }
    if scanner.rest().starts_with("#!") {
        let detail = Detail::new("attributes such as #![enable(…)] are not used in scenes");
        return Err(scanner.flaw_here(detail.advice("remove the line; implicit Some is always on")));
    }
    let node = scanner.value(0)?;
    scanner.skip_blanks()?;
    if !scanner.rest().is_empty() {
        let found = scanner.here();
        return Err(scanner.flaw_here(Detail::new("text after the end of the value").found(found)));
    }
    Ok(node)
}

/// A position in a text. Its values are read here, its words, strings and comments in `lexemes`.
pub(super) struct Scanner<'a> {
    pub(super) text: &'a str,
    pub(super) at: usize,
}

impl<'a> Scanner<'a> {
    fn value(&mut self, depth: usize) -> Result<Node, Flaw> {
        if depth > MAX_DEPTH {
            return Err(self.flaw_here(Detail::new(format!("brackets are nested more than {MAX_DEPTH} deep"))));
        }
        let start = self.at;
        let node = |scanner: &Self, name, shape| Node { span: start..scanner.at, name, shape };
        match self.peek() {
            Some('(') => {
                let shape = self.round(depth)?;
                Ok(node(self, None, shape))
            }
            Some('[') => {
                let items = self.sequence('[', ']', |s| s.value(depth + 1))?;
                Ok(node(self, None, Shape::List(items)))
            }
            Some('{') => {
                let entries = self.map(depth)?;
                Ok(node(self, None, Shape::Map(entries)))
            }
            Some('"') => {
                let text = self.quoted()?;
                Ok(node(self, None, Shape::Text(text)))
            }
            Some('\'') => {
                self.character()?;
                Ok(node(self, None, Shape::Char))
            }
            Some('r') if self.raw_string_hashes().is_some() => {
                let text = self.raw_string()?;
                Ok(node(self, None, Shape::Text(text)))
            }
            Some('b') if self.rest()[1..].starts_with(['"', '\'']) => {
                Err(self.flaw_here(Detail::new("byte strings are not used in scenes").expected("a plain string")))
            }
            Some('0'..='9' | '+' | '-' | '.') => {
                self.number();
                Ok(node(self, None, Shape::Number))
            }
            Some(c) if starts_word(c) => {
                let name = self.word().to_owned();
                let end = self.at;
                self.skip_blanks()?;
                if self.peek() == Some('(') {
                    let shape = self.round(depth)?;
                    return Ok(node(self, Some(name), shape));
                }
                self.at = end;
                Ok(node(self, Some(name), Shape::Word))
            }
            _ => {
                let found = self.here();
                Err(self.flaw_here(Detail::new("no value starts here").expected("a value").found(found)))
            }
        }
    }

    /// `(…)`: keys with values, or values alone.
    fn round(&mut self, depth: usize) -> Result<Shape, Flaw> {
        let start = self.at;
        self.at += 1;
        self.skip_blanks()?;
        let with_keys = self.key_follows()?;
        self.at = start;
        if !with_keys {
            return Ok(Shape::Items(self.sequence('(', ')', |s| s.value(depth + 1))?));
        }
        let mut seen = HashMap::new();
        let fields = self.sequence('(', ')', |s| {
            if !s.key_follows()? {
                let found = s.here();
                return Err(s.flaw_here(Detail::new("no key starts here").expected("`key: value`").found(found)));
            }
            let key_start = s.at;
            let key = s.word().to_owned();
            let key_span = key_start..s.at;
            s.refuse_duplicate(&mut seen, &key, key_span.clone())?;
            s.skip_blanks()?;
            s.at += 1; // the colon that `key_follows` saw
            s.skip_blanks()?;
            Ok(Field { key, key_span, value: s.value(depth + 1)? })
        })?;
        Ok(Shape::Fields(fields))
    }

    fn map(&mut self, depth: usize) -> Result<Vec<(Node, Node)>, Flaw> {
        let mut seen = HashMap::new();
        self.sequence('{', '}', |s| {
            let key = s.value(depth + 1)?;
            if let Shape::Text(text) = &key.shape {
                s.refuse_duplicate(&mut seen, text, key.span.clone())?;
            }
            s.skip_blanks()?;
            if s.peek() != Some(':') {
                let found = s.here();
                return Err(s.flaw_here(Detail::new("a map holds `key: value`").expected("`:`").found(found)));
            }
            s.at += 1;
            s.skip_blanks()?;
            Ok((key, s.value(depth + 1)?))
        })
    }

    /// Parts between brackets, separated by commas, one comma allowed at the end.
    fn sequence<T>(
        &mut self,
        open: char,
        close: char,
        mut part: impl FnMut(&mut Self) -> Result<T, Flaw>,
    ) -> Result<Vec<T>, Flaw> {
        let start = self.at;
        self.at += 1;
        let mut parts = Vec::new();
        loop {
            self.skip_blanks()?;
            match self.peek() {
                None => return Err(self.unclosed(start, open)),
                Some(c) if c == close => break,
                Some(_) => parts.push(part(self)?),
            }
            self.skip_blanks()?;
            match self.peek() {
                None => return Err(self.unclosed(start, open)),
                Some(',') => self.at += 1,
                Some(c) if c == close => break,
                Some(_) => {
                    let line = super::line_column(self.text, start).0;
                    let detail = Detail::new(format!("the values in the `{open}` of line {line} are not separated"));
                    let found = self.here();
                    return Err(self.flaw_here(detail.expected(format!("`,` or `{close}`")).found(found)));
                }
            }
        }
        self.at += 1;
        Ok(parts)
    }

    /// Whether `word :` stands here.
    fn key_follows(&mut self) -> Result<bool, Flaw> {
        let start = self.at;
        let is_key = self.peek().is_some_and(starts_word) && {
            self.word();
            self.skip_blanks()?;
            self.peek() == Some(':')
        };
        self.at = start;
        Ok(is_key)
    }

    fn refuse_duplicate(&self, seen: &mut HashMap<String, usize>, key: &str, span: Range<usize>) -> Result<(), Flaw> {
        if let Some(first) = seen.insert(key.to_owned(), span.start) {
            let (line, column) = super::line_column(self.text, first);
            let detail = Detail::new(format!("duplicate key `{}`, first given at {line}:{column}", shorten(key)));
            return Err(Flaw::new(span, detail.advice("keep one of the two")));
        }
        Ok(())
    }
}
