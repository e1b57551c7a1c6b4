//! Why a run did not reach its end.

use crate::build::BuildError;
use crate::checkpoint::CheckpointError;
use crate::model::StepFailure;
use cf_diffusion::StepError;
use cf_fluid::FlowError;
use cf_output::OutputError;
use std::path::PathBuf;

/// A run that ended early: which, when, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The scene is valid but no model of it can be built.
    #[error("run `{run}` cannot be built: {source}")]
    Build {
        /// The run.
        run: String,
        /// Why.
        source: BuildError,
    },
    /// The time step is so short that the run would never end.
    #[error(
        "run `{run}`: steps of {dt:e} s would never reach run.until (at least {steps:e} of them); check run.until, accuracy.dt and \
         accuracy.cfl, the speeds in model.medium and model.law, and the cell count"
    )]
    TooManySteps {
        /// The run.
        run: String,
        /// How many.
        steps: f64,
        /// How long \[s\].
        dt: f64,
    },
    /// A step failed.
    #[error("run `{run}`, step {step}, t = {time} s: {source}; {}", advice(source))]
    Step {
        /// The run.
        run: String,
        /// The step that failed, counted from 1.
        step: u64,
        /// Where it began \[s\].
        time: f64,
        /// Why.
        source: StepFailure,
    },
    /// A field holds infinity or no number.
    #[error(
        "run `{run}`, step {step}, t = {time} s: {field} is not finite at cell {cell:?}; \
        shorten the step (accuracy.cfl), use integrator Sdirk2, or check the sizes of sources and initial values"
    )]
    NotFinite {
        /// The run.
        run: String,
        /// The last step made.
        step: u64,
        /// Its end \[s\].
        time: f64,
        /// The field.
        field: &'static str,
        /// The first such cell.
        cell: Vec<usize>,
    },
    /// A file could not be written or read.
    #[error("run `{run}`: {source}")]
    Output {
        /// The run.
        run: String,
        /// Why.
        source: OutputError,
    },
    /// A checkpoint could not be used.
    #[error("run `{run}`: {source}")]
    Checkpoint {
        /// The run.
        run: String,
        /// Why.
        source: CheckpointError,
    },
    /// The watcher asked for a stop.
    #[error("run `{run}` stopped after step {step}, t = {time} s{}", left(checkpoint))]
    Stopped {
        /// The run.
        run: String,
        /// Steps made.
        step: u64,
        /// Time reached \[s\].
        time: f64,
        /// The checkpoint left, if files are written.
        checkpoint: Option<PathBuf>,
    },
}

/// The kinds of [`RunError`], for exit codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The scene asks for something that does not go.
    Input,
    /// The numbers went wrong.
    Numerical,
    /// The file system refused, or a checkpoint is not usable.
    Io,
    /// Stopped on request.
    Interrupted,
}

impl RunError {
    /// What kind of failure it is.
    pub fn failure(&self) -> Failure {
        match self {
            RunError::Build { .. } | RunError::TooManySteps { .. } => Failure::Input,
            RunError::Step { .. } | RunError::NotFinite { .. } => Failure::Numerical,
            RunError::Output { .. } | RunError::Checkpoint { .. } => Failure::Io,
            RunError::Stopped { .. } => Failure::Interrupted,
        }
    }
}

fn advice(error: &StepFailure) -> &'static str {
    match error {
        StepFailure::Split(StepError::Unstable { .. }) => "set accuracy.integrator to Sdirk2, or a shorter accuracy.dt",
        StepFailure::Split(StepError::Solve(_)) => {
            "raise accuracy.tolerance, set accuracy.precision to f64, or shorten accuracy.dt"
        }
        StepFailure::Split(StepError::Advect(_)) => "check the medium, or shorten accuracy.dt",
        StepFailure::Flow(FlowError::Pressure(_)) => {
            "raise accuracy.eta_div, set accuracy.precision to f64, or lower accuracy.cfl"
        }
        StepFailure::Flow(FlowError::NotFinite { .. }) => {
            "lower accuracy.cfl, or check jets, forces and buoyancy in model.medium"
        }
        StepFailure::Runaway { .. } => "lower accuracy.cfl, or take accuracy.flow: Auto",
        StepFailure::Flow(FlowError::Scalar(_)) => "lower accuracy.cfl, or set accuracy.integrator to Sdirk2",
        _ => "check the scene's numbers",
    }
}

fn left(checkpoint: &Option<PathBuf>) -> String {
    checkpoint.as_ref().map_or(String::new(), |path| format!("; go on from {} with --resume", path.display()))
}
