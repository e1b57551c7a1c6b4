//! A model of a few cells, built to see whether the numerics take the law, the walls and the medium.

use super::Checker;
use crate::build::{BuildError, build};
use crate::error::Detail;
use crate::pace::Pace;
use crate::scene::{Model, Scene};
use cf_diffusion::StepError;
use cf_diffusion::front::FrontError;

/// Cells along each axis.
const FEW: usize = 4;

/// Reports what the numerics refuse, at the key it is about.
pub(super) fn trial(check: &mut Checker<'_>, scene: &Scene, pace: &Pace) {
    let mut small = scene.clone();
    small.grid.cells = scene.grid.cells.iter().map(|n| (*n).min(FEW)).collect();
    small.grid.extent = small.grid.cells.iter().map(|n| *n as f64 * scene.grid.spacing).collect();
    if let Model::Diffusion(model) = &mut small.model {
        (model.initial, model.sources, model.obstacles) = (Vec::new(), Vec::new(), Vec::new());
        model.mask = None;
        model.fluid.iter_mut().for_each(|fluid| fluid.jets.clear());
    }
    if let Err(error) = build(&small, pace) {
        check.fail(path(&error), Detail::new(error.to_string()));
    }
}

fn path(error: &BuildError) -> &'static str {
    match error {
        BuildError::Grid(_) | BuildError::Dimension { .. } => "grid",
        BuildError::Law(_) => "model.law",
        BuildError::Medium(_) | BuildError::Front(FrontError::Medium(_)) => "model.medium",
        BuildError::Front(FrontError::Wall { .. }) | BuildError::Step(StepError::Wall { .. }) => "sides",
        BuildError::Flow(_) => "model.medium",
        BuildError::Step(StepError::Tolerance(_)) => "accuracy.tolerance",
        BuildError::Front(_) | BuildError::Step(_) => "accuracy.integrator",
    }
}
