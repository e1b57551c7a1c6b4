//! When a solve is good enough, and what it leaves behind.

/// Which residual is measured against what. Residuals are those of A x = b itself, in the units of b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// ‖r‖₂ <= tolerance · ‖b‖₂, b without the constants that are removed exactly.
    Relative(f64),
    /// max|r| <= tolerance. For alpha = 1 this bounds the error: max|x - x_exact| <= max|r|.
    Largest(f64),
}

/// What a solve did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Statistics {
    /// PCG or Chebyshev iterations.
    pub iterations: usize,
    /// ‖b‖₂ of the right-hand side after the constants were removed.
    pub rhs: f64,
    /// ‖r‖₂ reached, of the solution as it is before its constants are added.
    pub residual: f64,
    /// max|r| reached.
    pub largest: f64,
    /// The residual is above the tolerance, but no larger than rounding explains row by row: 4 eps ‖diagonal · x‖ in the
    /// norm of the criterion (of x - mean for conserving operators), so that a strong wall or a large share counts only
    /// where it is.
    pub at_floor: bool,
}

/// A solution written as constants plus a scaled deviation: x = constant(component) + factor · y. Conserving operators
/// have one constant per connected component ([`Solver::finish`](crate::Solver::finish)); others have none. One that is used
/// again for the next solve allocates nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Deviation {
    /// Multiplies y.
    pub factor: f64,
    /// mean(b)/alpha per component, the largest first; zeros for a Poisson problem.
    pub constants: Vec<f64>,
    /// Mean of b per component that a Poisson problem cannot satisfy; it was left out.
    pub removed: Vec<f64>,
    /// What the solve did.
    pub statistics: Statistics,
    /// max|y|.
    pub size: f64,
}
