//! From merged text to types, with the RON crate's errors rewritten in terms of what the user typed.

use super::merged::Merged;
use super::path::Path;
use super::tree::{Node, Shape};
use crate::error::{Detail, SceneError, shorten};
use crate::suggest::{nearest, one_of};
use ron::error::{Error, Position, SpannedError};
use ron::extensions::Extensions;
use serde::de::DeserializeOwned;

/// Decodes a merged text.
pub(crate) fn decode<T: DeserializeOwned>(merged: &Merged) -> Result<T, SceneError> {
    let options = ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME | Extensions::UNWRAP_NEWTYPES)
        .with_recursion_limit(4 * super::scan::MAX_DEPTH);
    options.from_str(&merged.text).map_err(|error| explain(merged, error))
}

fn explain(merged: &Merged, error: SpannedError) -> SceneError {
    let mut error = describe(merged, error);
    if let Some(form) = form(&error.detail.path) {
        // A name in front of brackets is no help where the form is known.
        if error.detail.expected.as_deref().is_none_or(|words| words.starts_with("round brackets")) {
            error.detail.expected = Some(form);
        } else if error.detail.advice.is_none() {
            error.detail.advice = Some(format!("write {form}"));
        }
    }
    error
}

/// How the value at a path is written, where its parts alone do not tell.
fn form(path: &str) -> Option<String> {
    let inner = path.strip_prefix("model.medium.walls")?;
    let mut steps = inner.split('.').skip(1);
    let wall = "Inflow((1.0, 0.0))";
    Some(match (steps.next(), steps.next()) {
        (None | Some("low" | "high"), _) => format!("walls: (x: (low: {wall}, high: Open), y: (low: Closed))"),
        (Some(axis), None) => format!("{axis}: (low: {wall}, high: Open)"),
        (Some(_), Some(end)) => {
            let end = end.split('[').next().unwrap_or(end);
            format!("{end}: {wall}, {end}: Open or {end}: Closed")
        }
    })
}

fn describe(merged: &Merged, error: SpannedError) -> SceneError {
    let start = byte_of(&merged.text, error.span.start);
    let end = byte_of(&merged.text, error.span.end);
    match error.code {
        Error::NoSuchStructField { expected, found, .. } => {
            let (parent, span) = key_before(merged, end, &found);
            let detail = Detail::new(format!("unknown key `{}`", shorten(&found)))
                .expected(one_of(expected.iter().copied()))
                .nearest(nearest(&found, expected.iter().copied()));
            merged.error(span, detail.at(parent))
        }
        Error::MissingStructField { field, .. } => {
            // The reader stands at the closing bracket of the struct.
            let (path, node) = merged.tree.at(start_of_value(&merged.text, end));
            let detail = Detail::new(format!("the key `{field}` is missing")).at(path.to_string());
            merged.error(opening(merged, node), detail)
        }
        Error::NoSuchEnumVariant { expected, found, .. } => {
            let (path, node) = merged.tree.at(start_of_value(&merged.text, start));
            let detail = Detail::new(format!("`{}` is not one of the choices", shorten(&found)))
                .expected(one_of(expected.iter().copied()))
                .nearest(nearest(&found, expected.iter().copied()));
            let span = node.span.start..node.span.start + found.len().min(node.span.len());
            merged.error(span, detail.at(path.to_string()))
        }
        code => {
            let (path, node) = value_at(merged, start, &code);
            let mut detail = Detail::new(problem(&code, node)).at(path.to_string());
            if let Some(expected) = expectation(&code, node) {
                detail = detail.expected(expected).found(node.describe(&merged.text));
            }
            detail.advice = advice(&code, node);
            merged.error(node.span.clone(), detail)
        }
    }
}

fn problem(code: &Error, node: &Node) -> String {
    match code {
        Error::IntegerOutOfBounds => "this number does not fit here".to_owned(),
        Error::Message(message) => message.clone(),
        Error::ExpectedDifferentLength { .. } => "wrong number of values".to_owned(),
        Error::ExceededRecursionLimit => "brackets are nested too deep".to_owned(),
        Error::Eof => "something is missing at the end".to_owned(),
        Error::ExpectedStructLike | Error::ExpectedNamedStructLike(_) if matches!(node.shape, Shape::Word) => {
            format!("`{}` needs its parts in round brackets", node.name.as_deref().unwrap_or_default())
        }
        Error::ExpectedDifferentStructName { found, .. } => format!("`{}` is not what stands here", shorten(found)),
        code if expectation(code, node).is_some() => "wrong kind of value".to_owned(),
        code => {
            let text = code.to_string();
            text.chars().take(1).flat_map(char::to_lowercase).chain(text.chars().skip(1)).collect()
        }
    }
}

fn expectation(code: &Error, node: &Node) -> Option<String> {
    let is_fraction = matches!(node.shape, Shape::Number);
    let expected = match code {
        Error::ExpectedFloat => "a number",
        Error::ExpectedInteger | Error::InvalidIntegerDigit { .. } => "a whole number",
        Error::IntegerOutOfBounds => "a whole number from 0 up to the largest allowed here",
        // After the digits of `1.5` a list of integers goes on to look for a comma.
        Error::ExpectedComma | Error::ExpectedStructLikeEnd if is_fraction => "a whole number",
        Error::ExpectedBoolean => "`true` or `false`",
        Error::ExpectedString => "a string in double quotes",
        Error::ExpectedArray => "a list in square brackets",
        Error::ExpectedMap => "a map in curly brackets, {\"name\": value}",
        Error::ExpectedStructLike | Error::ExpectedNamedStructLike(_) => "round brackets",
        Error::ExpectedIdentifier => "a key or the name of a choice",
        Error::ExpectedDifferentStructName { expected, .. } => {
            return Some(format!("round brackets with no name in front, or `{expected}(…)`"));
        }
        Error::InvalidValueForType { expected, .. } | Error::ExpectedDifferentLength { expected, .. } => expected,
        _ => return None,
    };
    Some(expected.to_owned())
}

fn advice(code: &Error, node: &Node) -> Option<String> {
    let round = matches!(code, Error::ExpectedStructLike | Error::ExpectedNamedStructLike(_));
    match &node.shape {
        Shape::List(_) if round => Some("write (1, 2), not [1, 2]".to_owned()),
        Shape::Map(_) if round => Some("write (key: value), not {key: value}".to_owned()),
        Shape::Text(_) if matches!(code, Error::ExpectedFloat | Error::ExpectedInteger) => {
            Some("leave out the quotes".to_owned())
        }
        _ => None,
    }
}

/// The struct that holds a key which ends at or before `end`, and the key's bytes.
fn key_before(merged: &Merged, end: usize, key: &str) -> (String, std::ops::Range<usize>) {
    let near = merged.text[..end].rfind(key).unwrap_or(end.saturating_sub(1));
    let (mut path, _) = merged.tree.at(near);
    path.0.pop();
    (path.to_string(), near..near + key.len())
}

/// A struct's opening: its name, or its bracket.
fn opening(merged: &Merged, node: &Node) -> std::ops::Range<usize> {
    let length = merged.text[node.span.clone()].find('(').map_or(1, |bracket| bracket + 1);
    node.span.start..(node.span.start + length).min(node.span.end)
}

/// The first byte of the value the reader stopped at, blanks passed over.
fn start_of_value(text: &str, start: usize) -> usize {
    let rest = &text[start..];
    start + (rest.len() - rest.trim_start_matches(|c: char| c.is_whitespace() || c == ',').len())
}

/// The value the reader stopped at, or the word it has just read when it misses that word's brackets.
fn value_at<'a>(merged: &'a Merged, start: usize, code: &Error) -> (Path, &'a Node) {
    let brackets = matches!(code, Error::ExpectedStructLike | Error::ExpectedNamedStructLike(_));
    let after_word = brackets && start > 0 && merged.text[start..].starts_with([',', ')', ']', '}']);
    merged.tree.at(if after_word { start - 1 } else { start_of_value(&merged.text, start) })
}

/// The byte at a line and column (in characters), both counted from 1.
fn byte_of(text: &str, position: Position) -> usize {
    let line_start = text.split_inclusive('\n').take(position.line.saturating_sub(1)).map(str::len).sum::<usize>();
    let rest = &text[line_start.min(text.len())..];
    line_start + rest.char_indices().nth(position.col.saturating_sub(1)).map_or(rest.len(), |(byte, _)| byte)
}
