//! Words that stand for a longer form, written out before a scene is decoded.
//!
//! `accuracy: Draft` means `accuracy: (level: Draft)`, and `Absorbing` and `Open` on a side mean `Absorbing()` and
//! `Open()`. Doing this in the text keeps the types plain and every later position exact.

use super::merged::Merged;
use super::path::{Path, Step};
use super::tree::Shape;
use crate::error::SceneError;

/// Writes out every shorthand of a merged scene.
pub(crate) fn write_out(merged: &mut Merged) -> Result<(), SceneError> {
    accuracy(merged)?;
    for axis in ["x", "y", "z"] {
        for side in ["low", "high"] {
            wall(merged, axis, side)?;
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

fn wall(merged: &mut Merged, axis: &str, side: &str) -> Result<(), SceneError> {
    let Some(node) = merged.tree.get(&keys(&["sides", axis, side])) else { return Ok(()) };
    if matches!(node.shape, Shape::Word) && matches!(node.name.as_deref(), Some("Absorbing" | "Open")) {
        let span = node.span.clone();
        let origin = merged.origin(span.clone());
        merged.replace(span.end..span.end, &[("()", &origin)])?;
    }
    Ok(())
}

fn keys(names: &[&str]) -> Path {
    Path(names.iter().map(|name| Step::Key((*name).to_owned())).collect())
}
