//! Why a flow cannot be set up or stepped.

use cf_diffusion::{MediumError, StepError};
use cf_grid::End;
use cf_linear::SolveError;
use thiserror::Error;

/// A flow that could not be set up or stepped. After a failed step the velocity may be half way; the last output stands.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FlowError {
    /// The time step is not a finite number >= 0.
    #[error("expected a finite time step of 0 s or more, found {0} s")]
    TimeStep(f64),
    /// A setting out of its range.
    #[error("{name} is {found}, expected {expected}")]
    Setting {
        /// Which.
        name: &'static str,
        /// The value given.
        found: f64,
        /// What is accepted.
        expected: &'static str,
    },
    /// A wall velocity that is not finite.
    #[error("the {end:?} wall of axis {axis} has velocity {value} along axis {component}, expected a finite number")]
    Wall {
        /// Axis of the wall.
        axis: usize,
        /// End of the axis.
        end: End,
        /// Component of the velocity.
        component: usize,
        /// The value found \[m/s\].
        value: f64,
    },
    /// A shape whose numbers make no shape.
    #[error("{what} is {found}, expected {expected}")]
    Shape {
        /// Which number.
        what: &'static str,
        /// The value found.
        found: f64,
        /// What is accepted.
        expected: &'static str,
    },
    /// A field or mask of another layout, or a mask file of another size.
    #[error("{what} has {found} entries, expected {expected}; make it for the grid of the flow")]
    Layout {
        /// Which.
        what: &'static str,
        /// Entries expected.
        expected: usize,
        /// Entries found.
        found: usize,
    },
    /// A velocity that is not finite, named by the cell above its face.
    #[error(
        "the velocity along axis {axis} is not finite at the low face of cell {cell:?}; \
         check initial values, forces and the size of the step"
    )]
    NotFinite {
        /// Component.
        axis: usize,
        /// Cell above the face.
        cell: Vec<usize>,
    },
    /// A step begun twice, or finished without having begun.
    #[error("a step must begin, then finish; found {0}")]
    Order(&'static str),
    /// The pressure solve failed.
    #[error("the pressure solve failed: {0}")]
    Pressure(#[from] SolveError),
    /// A prescribed velocity is refused.
    #[error(transparent)]
    Medium(#[from] MediumError),
    /// The transported quantity failed.
    #[error(transparent)]
    Scalar(#[from] StepError),
}
