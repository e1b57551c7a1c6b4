//! Overrides: a path and a new value, spliced into the text of a scene.

use super::merged::{Merged, Origin, Written};
use super::path::{Path, Step};
use super::tree::{Node, Shape};
use super::{scan, shorthand};
use crate::error::{Detail, SceneError, shorten};
use crate::spec::SECTIONS;
use crate::suggest::{nearest, one_of};
use std::sync::Arc;

/// A value to put in the place of another, or to add.
#[derive(Clone, Debug)]
pub(crate) struct Override {
    pub(crate) path: Path,
    /// Where the path was written.
    pub(crate) path_origin: Origin,
    /// The new value.
    pub(crate) value: String,
    /// Where the value was written; as long as the value.
    pub(crate) value_origin: Origin,
}

/// A `--set` flag: an override for every run of a scene, or for one.
#[derive(Clone, Debug)]
pub struct Set {
    /// The only run it is for.
    pub(crate) run: Option<String>,
    pub(crate) change: Override,
}

impl Set {
    /// Reads `path.to.key=value` or `run:path.to.key=value`; the value is RON.
    pub fn parse(flag: &str) -> Result<Self, SceneError> {
        let written = Arc::new(Written::Flag { text: flag.to_owned() });
        let whole = Origin { written, via: None, span: 0..flag.len() };
        let Some(equals) = flag.find('=') else {
            let detail = Detail::new("there is no `=`").expected("path.to.key=value, such as model.law.k=0.25");
            return Err(whole.error(detail));
        };
        let (left, value) = (&flag[..equals], &flag[equals + 1..]);
        let path_start = left.find(':').map_or(0, |colon| colon + 1);
        let path_origin = whole.part(path_start..equals);
        let path = Path::parse(&left[path_start..]).map_err(|detail| path_origin.error(detail))?;
        let value_start = equals + 1 + (value.len() - value.trim_start().len());
        let value = value.trim();
        let value_origin = whole.part(value_start..value_start + value.len());
        let mut change = Override { path, path_origin, value: value.to_owned(), value_origin };
        let run = left.find(':').map(|colon| left[..colon].trim().to_owned());
        // Without the comments around it, which would swallow what stands behind the value in the scene.
        let bare = change.scanned()?.span;
        change.value_origin = change.value_origin.part(value_start + bare.start..value_start + bare.end);
        change.value = change.value[bare].to_owned();
        Ok(Set { run, change })
    }

    /// An error about the run this flag names.
    pub(crate) fn unknown_run<'a>(&self, written: &str, names: impl Iterator<Item = &'a str> + Clone) -> SceneError {
        let detail = Detail::new(format!("there is no run called `{}`", shorten(written)))
            .expected(one_of(names.clone()))
            .nearest(nearest(written, names));
        let start = self.change.path_origin.span.start;
        self.change.path_origin.part(0..start.saturating_sub(1)).error(detail)
    }
}

impl Override {
    /// The value as a tree.
    fn scanned(&self) -> Result<Node, SceneError> {
        if self.value.is_empty() {
            let detail = Detail::new("there is no value").expected("a value, such as 0.25").at(self.path.to_string());
            return Err(self.path_origin.error(detail));
        }
        let start = self.value_origin.span.start;
        scan::scan(&self.value).map_err(|flaw| {
            let span = start + flaw.span.start..start + flaw.span.end;
            self.value_origin.part(span).error(flaw.detail.at(self.path.to_string()))
        })
    }

    /// Puts the value where the path leads, creating the last keys of the path where they are missing.
    pub(crate) fn apply(&self, merged: &mut Merged) -> Result<(), SceneError> {
        self.scanned()?;
        self.refuse_fixed_sections()?;
        let (node, taken) = merged.tree.follow(&self.path);
        if taken == self.path.0.len() {
            let span = node.span.clone();
            merged.replace(span, &[(&self.value, &self.value_origin)])?;
        } else {
            self.insert(merged, taken)?;
        }
        shorthand::write_out(merged)
    }

    fn refuse_fixed_sections(&self) -> Result<(), SceneError> {
        let refuse = |detail: Detail| Err(self.path_origin.error(detail.at(self.path.to_string())));
        let head = self.path.head();
        if !SECTIONS.contains(&head) {
            let detail = Detail::new(format!("there is no section `{}`", shorten(head)));
            return refuse(detail.expected(one_of(SECTIONS)).nearest(nearest(head, SECTIONS)));
        }
        let names_runs = self.path.0.get(1) == Some(&Step::Key("variants".to_owned()));
        if matches!(head, "about" | "claims") || (head == "run" && (names_runs || self.path.0.len() == 1)) {
            return refuse(Detail::new(
                "an override may not change what the runs are called or what is claimed of them",
            ));
        }
        Ok(())
    }

    /// Adds the steps from `taken` on below the deepest value that exists.
    fn insert(&self, merged: &mut Merged, taken: usize) -> Result<(), SceneError> {
        let refuse = |detail: Detail| Err(self.path_origin.error(detail.at(self.path.to_string())));
        let parent = merged.tree.follow(&self.path).0;
        let missing = &self.path.0[taken..];
        let mut keys = Vec::new();
        for step in missing {
            match step {
                Step::Key(key) => keys.push(key.as_str()),
                Step::Index(index) => {
                    let there = match &parent.shape {
                        Shape::Items(items) | Shape::List(items) if keys.is_empty() => items.len(),
                        _ => 0,
                    };
                    let detail = Detail::new(format!("there is no item [{index}]"));
                    return refuse(detail.found(format!("a list of {there}, counted from [0]")));
                }
            }
        }
        let Some((at, before, after)) = slot(parent, taken == 0, keys.first().copied().unwrap_or_default()) else {
            let place = Path(self.path.0[..taken].to_vec());
            let detail = Detail::new(format!("{place} has no keys")).found(parent.describe(&merged.text));
            return refuse(detail.advice(format!("override {place} as a whole")));
        };
        let opening = format!("{before}{}: ", keys.join(": ("));
        let closing = format!("{}{after}", ")".repeat(keys.len().saturating_sub(1)));
        let glue = &self.path_origin;
        merged.replace(at..at, &[(&opening, glue), (&self.value, &self.value_origin), (&closing, glue)])
    }
}

/// Where a key may be added to a struct, with the text that must go before and after it.
fn slot(parent: &Node, at_top: bool, key: &str) -> Option<(usize, &'static str, &'static str)> {
    let fields = match &parent.shape {
        Shape::Fields(fields) => fields,
        Shape::Items(items) if items.is_empty() => return Some((parent.span.end - 1, "", "")),
        _ => return None,
    };
    let rank = |name: &str| SECTIONS.iter().position(|section| *section == name);
    let next = fields.iter().find(|field| at_top && rank(&field.key) > rank(key));
    match next {
        Some(field) => Some((field.key_span.start, "", ", ")),
        None => Some((fields.last()?.value.span.end, ", ", "")),
    }
}
