//! Everything that must hold before anything is allocated.
//!
//! Each section has a function that takes what was written and gives what it means, reporting every problem it meets.

mod claims;
mod fluid;
mod grid;
mod knobs;
mod law;
mod mask;
pub(crate) mod memory;
mod model;
mod names;
mod numerics;
mod output;
mod schedule;
mod sides;
mod solid;
mod time;
mod trial;

pub(crate) use claims::{claims, front_speed, read};
pub(crate) use knobs::{Use, idle};
pub use memory::{Limits, MemoryRow, MemoryTable};
pub(crate) use names::names;

use crate::error::{Detail, Problems, SceneError, number};
use crate::pace::Pace;
use crate::scene::{Model, Scene};
use crate::spec::{Precision, SceneSpec};
use crate::text::merged::Merged;
use crate::text::path::Path;
use crate::text::tree::Shape;
use std::path::PathBuf;

/// Validates one run and says which knobs it was given. Its name and label are left empty.
pub(crate) fn scene(
    spec: &SceneSpec,
    merged: &Merged,
    preset: Option<&str>,
    limits: &Limits,
) -> Result<(Scene, Vec<Use>), Problems> {
    let mut check = Checker::new(merged);
    check.every_number_is_finite();
    check.stop()?;
    let grid = grid::grid(&mut check, spec);
    check.stop()?;
    let mut model = model::model(&mut check, &spec.model, &grid);
    check.stop()?;
    let sides = sides::sides(&mut check, &spec.sides, &grid, &model);
    if let Model::Diffusion(model) = &mut model {
        model.fluid = fluid::fluid(&mut check, &model.medium, &sides, &grid);
    }
    let numerics = numerics::numerics(&mut check, &spec.accuracy, &grid, &model, preset);
    let schedule = schedule::schedule(&mut check, &spec.run);
    if numerics.precision == Precision::F32 {
        model::fits_f32(&mut check, &model);
        sides::fits_f32(&mut check, &sides);
    }
    let dimension = grid.dimension();
    output::output(&mut check, &spec.output, dimension);
    let (run, label) = (String::new(), String::new());
    let (output, warnings) = (spec.output.clone(), Vec::new());
    let mut scene = Scene { run, label, grid, sides, model, numerics, schedule, output, warnings };
    check.stop()?;
    memory::fits(&mut check, &scene, limits);
    let pace = Pace::of(&scene);
    time::time(&mut check, &scene, &pace);
    check.stop()?;
    trial::trial(&mut check, &scene, &pace);
    solid::fluid(&mut check, &scene);
    model::empty(&mut check, &scene);
    check.stop()?;
    let uses = knobs::uses(&check, &spec.accuracy, &scene, &pace);
    scene.warnings = check.warnings;
    Ok((scene, uses))
}

/// Validates what a size decides: the grid, and the model on it.
pub(crate) fn size(spec: &SceneSpec, merged: &Merged) -> Result<(), Problems> {
    let mut check = Checker::new(merged);
    check.every_number_is_finite();
    check.stop()?;
    let grid = grid::grid(&mut check, spec);
    check.stop()?;
    model::model(&mut check, &spec.model, &grid);
    check.stop()
}

/// The most problems that are reported at once; more help nobody and each costs a look through the text.
const MAX_PROBLEMS: usize = 100;

/// Collects problems at paths of a merged scene.
pub(crate) struct Checker<'a> {
    merged: &'a Merged,
    pub(crate) problems: Vec<SceneError>,
    warnings: Vec<SceneError>,
}

impl<'a> Checker<'a> {
    pub(crate) fn new(merged: &'a Merged) -> Self {
        Checker { merged, problems: Vec::new(), warnings: Vec::new() }
    }

    /// Reports a problem at a path, or at the nearest existing value above it.
    pub(crate) fn fail(&mut self, path: &str, detail: Detail) {
        if self.problems.len() >= MAX_PROBLEMS {
            return;
        }
        self.problems.push(self.error(path, detail));
    }

    /// Notes at a path what is no error.
    pub(crate) fn warn(&mut self, path: &str, detail: Detail) {
        if self.warnings.len() < MAX_PROBLEMS {
            self.warnings.push(self.error(path, detail));
        }
    }

    /// An error at a path, or at the nearest existing value above it.
    pub(crate) fn error(&self, path: &str, detail: Detail) -> SceneError {
        let steps = Path::parse(path).unwrap_or_default();
        let (node, taken) = self.merged.tree.follow(&steps);
        let span = if taken == steps.0.len() { node.span.clone() } else { node.span.start..node.span.start + 1 };
        self.merged.error(span, detail.at(path))
    }

    /// The folder of the scene's file, in which other files are looked for.
    pub(crate) fn folder(&self) -> PathBuf {
        self.merged.folder()
    }

    /// Reports a problem unless something holds, which is returned.
    pub(crate) fn require(&mut self, holds: bool, path: &str, detail: impl FnOnce() -> Detail) -> bool {
        if !holds {
            self.fail(path, detail());
        }
        holds
    }

    pub(crate) fn positive(&mut self, path: &str, value: f64) -> bool {
        self.require(value > 0.0, path, || out_of_range("greater than 0", value))
    }

    pub(crate) fn not_negative(&mut self, path: &str, value: f64) -> bool {
        self.require(value >= 0.0, path, || out_of_range("0 or greater", value))
    }

    pub(crate) fn fits_f32(&mut self, path: &str, value: f64) -> bool {
        self.require((value as f32).is_finite(), path, || {
            Detail::new("does not fit f32").expected("at most 3.4e38").found(number(value)).advice("use precision: f64")
        })
    }

    /// The problems so far, as an error.
    fn stop(&mut self) -> Result<(), Problems> {
        Problems::from_list(std::mem::take(&mut self.problems)).map_or(Ok(()), Err)
    }

    fn every_number_is_finite(&mut self) {
        let mut wrong = Vec::new();
        self.merged.tree.walk(&mut Path::default(), &mut |path, node| {
            let text = &self.merged.text[node.span.clone()];
            let infinite = match node.shape {
                Shape::Number => is_infinite(text),
                Shape::Word => ["inf", "NaN"].iter().any(|start| text.starts_with(start)),
                _ => false,
            };
            if infinite && wrong.len() < MAX_PROBLEMS {
                let detail = Detail::new("not a finite number").found(node.describe(&self.merged.text));
                wrong.push(self.merged.error(node.span.clone(), detail.at(path.to_string())));
            }
        });
        self.problems.extend(wrong);
    }
}

/// `+inf`, `-NaN`, or digits too large for a number.
fn is_infinite(text: &str) -> bool {
    let digits = text.trim_end_matches("f64").trim_end_matches("f32").replace('_', "");
    digits.parse::<f64>().is_ok_and(|value| !value.is_finite())
}

pub(crate) fn out_of_range(expected: &str, found: f64) -> Detail {
    Detail::new("out of range").expected(expected).found(number(found))
}
