//! Why a step of transport is refused.

use crate::medium::MediumError;

/// Why [`Advector::advect`](super::Advector::advect) did nothing. The fields are unchanged then.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AdvectError {
    /// The medium is not usable.
    #[error(transparent)]
    Medium(#[from] MediumError),
    /// A step that is negative, infinite or not a number, or too long for the speeds of `T`.
    #[error("the transport step is {dt:e} s, expected a finite step of 0 s or more")]
    Step {
        /// The step given \[s\].
        dt: f64,
    },
    /// More sub-steps than anyone wants to wait for.
    #[error(
        "transport over {dt:e} s at a Courant number of {courant:.3e} needs {substeps:.0} conservative sub-steps, more than \
         {limit}; shorten the step or use the semi-Lagrangian method (Cubic), which has no limit"
    )]
    TooManySubsteps {
        /// The step given \[s\].
        dt: f64,
        /// max|u_a| dt/h.
        courant: f64,
        /// Sub-steps it would take.
        substeps: f64,
        /// Sub-steps allowed.
        limit: usize,
    },
    /// A field of another layout.
    #[error("the transported field has {found} slots, expected {expected}; make it on the same grid")]
    Layout {
        /// Slots of the grid's layout.
        expected: usize,
        /// Slots of the field.
        found: usize,
    },
}
