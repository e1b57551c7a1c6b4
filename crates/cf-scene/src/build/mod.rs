//! From a validated scene to a model that runs. The only place that matches on dimension and precision.

mod coverage;
mod diffusion;
mod flow;
mod fluid;
mod shown;
mod single_field;
mod stepper;

use crate::model::Model;
use crate::pace::Pace;
use crate::scene::{self, Scene};
use crate::spec::Precision;
use cf_diffusion::front::FrontError;
use cf_diffusion::{LawError, MediumError, StepError};
use cf_fluid::FlowError;
use cf_grid::GridError;
use diffusion::DiffusionModel;
pub(crate) use fluid::scheme;
pub(crate) use shown::Shown;
use single_field::SingleFieldModel;

/// Why a valid scene could not be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// The law.
    #[error(transparent)]
    Law(#[from] LawError),
    /// The medium.
    #[error(transparent)]
    Medium(#[from] MediumError),
    /// The integrator.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The scheme for fronts.
    #[error(transparent)]
    Front(#[from] FrontError),
    /// The fluid.
    #[error(transparent)]
    Flow(#[from] FlowError),
    /// A combination that does not exist.
    #[error("a scene of {axes} axes has no {what}")]
    Dimension {
        /// Axes of the grid.
        axes: usize,
        /// What was asked for.
        what: &'static str,
    },
}

/// Builds the model of a scene at its start.
pub(crate) fn build(scene: &Scene, pace: &Pace) -> Result<Box<dyn Model>, BuildError> {
    let model = match &scene.model {
        scene::Model::SingleField(model) => return Ok(Box::new(SingleFieldModel::new(scene, model)?)),
        scene::Model::Diffusion(model) => model,
    };
    let single = scene.numerics.precision == Precision::F32;
    Ok(match (scene.grid.dimension(), single) {
        (2, true) => Box::new(DiffusionModel::<f32, 2>::new(scene, model, pace, flow::plane)?),
        (2, false) => Box::new(DiffusionModel::<f64, 2>::new(scene, model, pace, flow::plane)?),
        (3, true) => Box::new(DiffusionModel::<f32, 3>::new(scene, model, pace, flow::space)?),
        (3, false) => Box::new(DiffusionModel::<f64, 3>::new(scene, model, pace, flow::space)?),
        (axes, _) => return Err(BuildError::Dimension { axes, what: "diffusion model" }),
    })
}
