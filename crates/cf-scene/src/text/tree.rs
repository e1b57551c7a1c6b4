//! The tree of a RON text: what stands where.

use super::path::{Path, Step};
use std::ops::Range;

/// A value and the bytes it occupies.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Bytes from the value's first to past its last character, a leading name included.
    pub span: Range<usize>,
    /// The identifier in front of round brackets, or the bare word itself.
    pub name: Option<String>,
    /// What kind of value it is, with its parts.
    pub shape: Shape,
}

/// The kinds of RON values.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// `1`, `-2.5e3`
    Number,
    /// `"text"` or `r#"text"#`, unescaped
    Text(String),
    /// `'c'`
    Char,
    /// A bare identifier, such as `true`, `None` or `Closed`
    Word,
    /// `(key: value, …)`
    Fields(Vec<Field>),
    /// `(value, …)`
    Items(Vec<Node>),
    /// `[value, …]`
    List(Vec<Node>),
    /// `{key: value, …}`
    Map(Vec<(Node, Node)>),
}

/// A key of a struct with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The key.
    pub key: String,
    /// Bytes of the key.
    pub key_span: Range<usize>,
    /// Its value.
    pub value: Node,
}

impl Node {
    /// The value one step further down, if there is one. `Some(x)` counts as `x`.
    pub fn child(&self, step: &Step) -> Option<&Node> {
        match (&self.shape, step) {
            (Shape::Items(items), _) if self.is_some_of() => items.first()?.child(step),
            (Shape::Fields(fields), Step::Key(key)) => fields.iter().find(|f| f.key == *key).map(|f| &f.value),
            (Shape::Map(entries), Step::Key(key)) => {
                entries.iter().find(|(k, _)| matches!(&k.shape, Shape::Text(text) if text == key)).map(|(_, v)| v)
            }
            (Shape::Items(items) | Shape::List(items), Step::Index(index)) => items.get(*index),
            _ => None,
        }
    }

    /// The deepest existing value on the way along `path`, and how many steps lead to it.
    pub fn follow(&self, path: &Path) -> (&Node, usize) {
        let mut node = self;
        for (taken, step) in path.0.iter().enumerate() {
            match node.child(step) {
                Some(next) => node = next,
                None => return (node, taken),
            }
        }
        (node, path.0.len())
    }

    /// The value at `path`, if there is one.
    pub fn get(&self, path: &Path) -> Option<&Node> {
        let (node, taken) = self.follow(path);
        (taken == path.0.len()).then_some(node)
    }

    /// The innermost value around a byte, with its path.
    pub fn at(&self, byte: usize) -> (Path, &Node) {
        let (mut path, mut node) = (Path::default(), self);
        while let Some((step, next)) = node.part_at(byte) {
            if !node.is_some_of() {
                path.0.push(step);
            }
            node = next;
        }
        (path, node)
    }

    fn part_at(&self, byte: usize) -> Option<(Step, &Node)> {
        let inside = |span: &Range<usize>| span.contains(&byte);
        match &self.shape {
            Shape::Fields(fields) => fields
                .iter()
                .find(|f| inside(&(f.key_span.start..f.value.span.end)))
                .map(|f| (Step::Key(f.key.clone()), &f.value)),
            Shape::Items(items) | Shape::List(items) => {
                items.iter().enumerate().find(|(_, n)| inside(&n.span)).map(|(i, n)| (Step::Index(i), n))
            }
            Shape::Map(entries) => {
                let (key, value) = entries.iter().find(|(k, v)| inside(&(k.span.start..v.span.end)))?;
                let name = if let Shape::Text(text) = &key.shape { text.as_str() } else { "" };
                Some((Step::Key(name.to_owned()), if inside(&key.span) { key } else { value }))
            }
            _ => None,
        }
    }

    /// Calls `see` for every value below this one, itself included, with its path.
    pub fn walk(&self, path: &mut Path, see: &mut impl FnMut(&Path, &Node)) {
        see(path, self);
        let mut down = |step: Step, node: &Node| {
            path.0.push(step);
            node.walk(path, see);
            path.0.pop();
        };
        match &self.shape {
            Shape::Fields(fields) => fields.iter().for_each(|f| down(Step::Key(f.key.clone()), &f.value)),
            Shape::Items(items) | Shape::List(items) => {
                items.iter().enumerate().for_each(|(i, node)| down(Step::Index(i), node));
            }
            Shape::Map(entries) => entries.iter().for_each(|(k, v)| {
                let key = if let Shape::Text(text) = &k.shape { text.clone() } else { String::new() };
                down(Step::Key(key), v);
            }),
            _ => {}
        }
    }

    /// What stands here, for a sentence: `the number 3`, `a list`, `the word Closed`.
    pub fn describe(&self, text: &str) -> String {
        let written = || crate::error::shorten(text.get(self.span.clone()).unwrap_or_default());
        match (&self.shape, &self.name) {
            (Shape::Number, _) => format!("the number {}", written()),
            (Shape::Text(_), _) => format!("the string {}", written()),
            (Shape::Char, _) => format!("the character {}", written()),
            (Shape::Word, _) => format!("the word `{}`", written()),
            (Shape::Fields(_) | Shape::Items(_), Some(name)) => format!("`{name}(…)`"),
            (Shape::Fields(_), None) => "a struct `(key: value, …)`".to_owned(),
            (Shape::Items(items), None) => match items.len() {
                0 => "empty round brackets".to_owned(),
                1 => "one value in round brackets".to_owned(),
                n => format!("{n} values in round brackets"),
            },
            (Shape::List(_), _) => "a list `[…]`".to_owned(),
            (Shape::Map(_), _) => "a map `{…}`".to_owned(),
        }
    }

    fn is_some_of(&self) -> bool {
        self.name.as_deref() == Some("Some") && matches!(&self.shape, Shape::Items(items) if items.len() == 1)
    }
}
