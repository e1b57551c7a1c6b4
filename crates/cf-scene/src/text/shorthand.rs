//! Words that stand for a longer form, written out before a scene is decoded.
//!
//! `accuracy: Draft` means `accuracy: (level: Draft)`, `Absorbing` and `Open` on a side mean `Absorbing()` and `Open()`,
//! and `medium: Solved` means `Solved()`. Doing this in the text keeps the types plain and every later position exact.

use super::merged::Merged;
use super::path::{Path, Step};
use super::tree::Shape;
use crate::error::SceneError;

/// Writes out every shorthand of a merged scene.
pub(crate) fn write_out(merged: &mut Merged) -> Result<(), SceneError> {
    accuracy(merged)?;
    empty(merged, &["model", "medium"], &["Solved"])?;
    for axis in ["x", "y", "z"] {
        for side in ["low", "high"] {
            empty(merged, &["sides", axis, side], &["Absorbing", "Open"])?;
        }
    }
    Ok(())
}

fn accuracy(merged: &mut Merged) -> Result<(), SceneError> {
    let Some(node) = merged.tree.get(&keys(&["accuracy"])) else { return Ok(()) };
    let is_short = match &node.shape {
        Shape::Word => true,
        Shape::Items(_) => node.name.as_deref() == Some("Target"),
        _ => false,
    };
    if is_short {
        let span = node.span.clone();
        let (word, origin) = (merged.text[span.clone()].to_owned(), merged.origin(span.clone()));
        merged.replace(span, &[("(level: ", &origin), (&word, &origin), (")", &origin)])?;
    }
    Ok(())
}

/// A word of these at a place gets its brackets.
fn empty(merged: &mut Merged, place: &[&str], words: &[&str]) -> Result<(), SceneError> {
    let Some(node) = merged.tree.get(&keys(place)) else { return Ok(()) };
    if matches!(node.shape, Shape::Word) && node.name.as_deref().is_some_and(|name| words.contains(&name)) {
        let span = node.span.clone();
        let origin = merged.origin(span.clone());
        merged.replace(span.end..span.end, &[("()", &origin)])?;
    }
    Ok(())
}

fn keys(names: &[&str]) -> Path {
    Path(names.iter().map(|name| Step::Key((*name).to_owned())).collect())
}
