//! What the run loop knows of a model: it advances, it can be looked at, and its state can be stored.

use crate::spec::Field;
use crate::stopwatch::Stopwatch;
use crate::summary::{FieldBytes, HcSummary, Range};
use cf_diffusion::{StepError, StepReport};
use cf_output::{Array, OutputError, Scalar, Slice};

/// A running model. Time is kept by whoever runs it.
pub(crate) trait Model {
    /// One step of `dt` \[s\] from time `from` \[s\].
    fn advance(&mut self, from: f64, dt: f64, watch: &mut Stopwatch) -> Result<StepReport, StepFailure>;
    /// What the last step of a solved fluid did.
    fn flow(&self) -> Option<FlowStep> {
        None
    }
    /// A solved fluid as it is now.
    fn flow_state(&self) -> Option<FlowState> {
        None
    }
    /// The longest step \[s\] that a solved fluid may make from a time on, for a Courant number; infinite for what is given.
    fn longest(&mut self, _time: f64, _cfl: f64) -> f64 {
        f64::INFINITY
    }
    /// The largest distance \[m\] of cells with more than a share of the largest |phi| from the shapes that put phi in.
    fn reach(&self, _fraction: f64) -> Option<f64> {
        None
    }
    /// Sums and extremes of `phi`.
    fn totals(&self) -> Totals;
    /// The fields to be written, borrowed; those that the model does not have are left out.
    fn arrays(&self, fields: &[Field]) -> Result<Vec<Array<'_>>, OutputError>;
    /// `phi` cell by cell, x fastest.
    fn phi(&self) -> Vec<f64>;
    /// `phi` and the slow flux at the end, where they are wanted, without a copy beside all else that the model holds.
    fn end(self: Box<Self>, phi: bool, flux: bool) -> (Option<Vec<f64>>, Option<Vec<Vec<f64>>>) {
        (phi.then(|| self.phi()), flux.then(|| self.flux()))
    }
    /// `phi` on a layer of cells, the first remaining axis fastest.
    fn layer(&self, slice: Slice) -> Vec<f64>;
    /// The slow flux, one array per axis; empty without memory.
    fn flux(&self) -> Vec<Vec<f64>>;
    /// What is stored, with its size.
    fn fields(&self) -> Vec<FieldBytes>;
    /// Extremes of every field.
    fn ranges(&self) -> Vec<Range>;
    /// The plan of the linear solver and its reason.
    fn solver(&self) -> (String, String);
    /// A field and a cell that hold no number, if there are such.
    fn not_finite(&self) -> Option<(&'static str, Vec<usize>)>;
    /// The state that a checkpoint keeps.
    fn state(&self) -> Vec<(&'static str, Values<'_>)>;
    /// The same, to be filled.
    fn state_mut(&mut self) -> Vec<(&'static str, ValuesMut<'_>)>;
    /// Whether steps estimate their own error from now on, where the integrator can.
    fn estimate(&mut self, on: bool);
    /// The norm that such estimates are to be compared with; 0 where there are none.
    fn norm(&self) -> f64;
    /// Sums over the cells of (phi - other)² and of phi², of another `phi` as [`state`](Self::state) has it first.
    fn distance(&self, other: Values<'_>) -> [f64; 2];
    /// What the next step depends on besides the state.
    fn reversed(&self) -> bool;
    /// Sets it.
    fn set_reversed(&mut self, reversed: bool);
}

/// Why a step was not made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepFailure {
    /// By transport and diffusion in turn.
    #[error(transparent)]
    Split(#[from] StepError),
    /// By the scheme for fronts.
    #[error(transparent)]
    Front(#[from] cf_diffusion::front::FrontError),
    /// With a solved fluid.
    #[error(transparent)]
    Flow(#[from] cf_fluid::FlowError),
    /// A solved fluid got so fast that its steps would hardly move on.
    #[error("the fluid has become so fast that a step could be no longer than {dt:.3e} s")]
    Runaway {
        /// The longest step \[s\].
        dt: f64,
    },
}

/// What a step of a solved fluid did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlowStep {
    /// As the fluid tells it.
    pub report: cf_fluid::FlowReport,
    /// The larger of max |u| before and afterwards \[m/s\].
    pub speed: f64,
    /// Of buoyancy and force, the mean of before and afterwards \[m^(D+2)/s³\].
    pub power: f64,
}

/// A solved fluid at some time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FlowState {
    /// The plan of the pressure solves, and its reason.
    pub solver: String,
    pub reason: String,
    /// |u|/c over the cells.
    pub hc: Option<HcSummary>,
    /// ∫ u²/2 \[m^(D+2)/s²\].
    pub energy: f64,
}

/// Sums and extremes of `phi`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Totals {
    /// Sum of phi times cell volume \[P m^D\].
    pub mass: f64,
    /// Sum of |phi| times cell volume \[P m^D\].
    pub magnitude: f64,
    pub min: f64,
    pub max: f64,
}

/// Numbers of either precision.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Values<'a> {
    F32(&'a [f32]),
    F64(&'a [f64]),
}

/// Numbers of either precision, to be filled.
#[derive(Debug)]
pub(crate) enum ValuesMut<'a> {
    F32(&'a mut [f32]),
    F64(&'a mut [f64]),
}

/// A precision that can be computed with, written and stored.
pub(crate) trait Number: cf_grid::Real + Scalar {
    fn values(values: &[Self]) -> Values<'_>;
    fn values_mut(values: &mut [Self]) -> ValuesMut<'_>;
    /// Numbers of this precision; `None` for the other.
    fn of_values(values: Values<'_>) -> Option<&[Self]>;
}

impl Number for f32 {
    fn values(values: &[f32]) -> Values<'_> {
        Values::F32(values)
    }
    fn values_mut(values: &mut [f32]) -> ValuesMut<'_> {
        ValuesMut::F32(values)
    }
    fn of_values(values: Values<'_>) -> Option<&[f32]> {
        if let Values::F32(values) = values { Some(values) } else { None }
    }
}

impl Number for f64 {
    fn values(values: &[f64]) -> Values<'_> {
        Values::F64(values)
    }
    fn values_mut(values: &mut [f64]) -> ValuesMut<'_> {
        ValuesMut::F64(values)
    }
    fn of_values(values: Values<'_>) -> Option<&[f64]> {
        if let Values::F64(values) = values { Some(values) } else { None }
    }
}
