//! Why a solve failed. Every variant that ran carries the residual it reached.

use thiserror::Error;

/// A failed solve.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SolveError {
    /// The tolerance was not met.
    #[error(
        "no convergence after {iterations} iterations: residual {residual:.3e}, wanted {wanted:.3e}; \
         loosen the tolerance or shorten the time step"
    )]
    NotConverged {
        /// Iterations made.
        iterations: usize,
        /// Residual reached, in the norm of the criterion.
        residual: f64,
        /// Residual wanted.
        wanted: f64,
    },
    /// NaN or infinity in the data or from overflow.
    #[error("the {what} is not finite after {iterations} iterations; check the input for NaN, infinities or overflow")]
    NotFinite {
        /// What was found not finite.
        what: &'static str,
        /// Iterations made.
        iterations: usize,
    },
    /// A coefficient is out of range.
    #[error("expected a finite {name} >= 0, found {value}")]
    Coefficient {
        /// Which.
        name: &'static str,
        /// The value found.
        value: f64,
    },
    /// alpha = kappa = 0: no cell is joined to another one, and only those at walls to anything.
    #[error("expected alpha > 0 or kappa > 0, found zero for both: nothing determines the solution inside")]
    Empty,
    /// Coefficients too far apart for the number type.
    #[error(
        "alpha and kappa add up to {inner:.3e} inside, but to {largest:.3e} at the strongest wall or share; \
         weaken that, or use f64"
    )]
    Spread {
        /// Diagonal of an inner cell.
        inner: f64,
        /// Bound of the largest diagonal.
        largest: f64,
    },
    /// A field, mask or share of another layout.
    #[error("expected {what} of {expected} slots, found {found}; it must come from the operator's layout")]
    Length {
        /// Which.
        what: &'static str,
        /// Slots of the operator's layout.
        expected: usize,
        /// Slots found.
        found: usize,
    },
}
