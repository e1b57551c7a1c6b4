//! Why a step failed.

use cf_linear::SolveError;
use thiserror::Error;

use crate::advect::AdvectError;

/// A step that could not be set up or made. The state may be half way through the step; the last output stands.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum StepError {
    /// The time step is not a finite number >= 0.
    #[error("expected a finite time step >= 0, found {0}")]
    TimeStep(f64),
    /// Kdk integrates the hyperbolic case only.
    #[error(
        "the explicit integrator Kdk needs F_T = 0 and tau > 0, found F_T = {fourier} and tau = {tau:e}; \
         use Sdirk2 or PaperBe"
    )]
    NeedsWaves {
        /// F_T found.
        fourier: f64,
        /// tau found \[s\].
        tau: f64,
    },
    /// An explicit step beyond its stability limit.
    #[error("the explicit step dt = {dt:e} s exceeds its stability limit {limit:e} s; shorten it or use Sdirk2")]
    Unstable {
        /// Step asked for \[s\].
        dt: f64,
        /// k dt tanh(dt/2tau) 4 D/h² = 2 \[s\].
        limit: f64,
    },
    /// A wall number is not usable.
    #[error("the {end:?} wall of axis {axis} has {what} = {value}, expected {expected}")]
    Wall {
        /// Axis of the wall.
        axis: usize,
        /// End of the axis.
        end: cf_grid::End,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is accepted.
        expected: &'static str,
    },
    /// The tolerance is not in (0, 1).
    #[error("expected a solver tolerance between 0 and 1, found {0}")]
    Tolerance(f64),
    /// Only the two stages of Sdirk2 tell their own error.
    #[error("{integrator} has no estimate of its own error, which adaptive steps need; use Sdirk2")]
    NoEstimate {
        /// The integrator.
        integrator: &'static str,
    },
    /// No step, however short, has an error below the tolerance.
    #[error(
        "the tolerance {tolerance} of the steps is out of reach: a step of {dt:e} s still has the error {error:.2e}; \
         loosen it, tighten the solves, or use f64"
    )]
    OutOfReach {
        /// The tolerance asked for.
        tolerance: f64,
        /// The relative error of the last step tried.
        error: f64,
        /// That step \[s\].
        dt: f64,
    },
    /// A field of another layout.
    #[error("{what} has {found} slots, expected {expected}; make it on the grid of the stepper")]
    Layout {
        /// Which field.
        what: &'static str,
        /// Slots of the grid's layout.
        expected: usize,
        /// Slots of the field.
        found: usize,
    },
    /// NaN or infinity appeared.
    #[error("{field} is not finite{}; check initial values, sources and the size of the step", at(.cell))]
    NotFinite {
        /// Which field.
        field: &'static str,
        /// A cell where it happened, empty if unknown.
        cell: Vec<usize>,
    },
    /// The linear solve failed.
    #[error("the implicit diffusion solve failed: {0}")]
    Solve(#[from] SolveError),
    /// The transport failed.
    #[error("the transport by the medium failed: {0}")]
    Advect(#[from] AdvectError),
    /// The state lacks q_C, or has one the law does not need.
    #[error("the state {} a slow flux, but the law {} one; make it with State::new for this law",
        if *.found { "has" } else { "lacks" }, if *.found { "does not use" } else { "needs" })]
    SlowFlux {
        /// Whether the state has q_C.
        found: bool,
    },
}

fn at(cell: &[usize]) -> String {
    if cell.is_empty() { String::new() } else { format!(" at cell {cell:?}") }
}
