//! When a solve is good enough.

/// Which residual is measured against what. Residuals are those of A x = b itself, in the units of b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// ‖r‖₂ <= tolerance · ‖b‖₂, b without the constants that are removed exactly.
    Relative(f64),
    /// max|r| <= tolerance. For alpha = 1 this bounds the error: max|x - x_exact| <= max|r| (model/diffusion.md 5.5).
    Largest(f64),
}

/// What a solve did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Statistics {
    /// PCG or Chebyshev iterations.
    pub iterations: usize,
    /// ‖b‖₂ of the right-hand side after the constants were removed.
    pub rhs: f64,
    /// ‖r‖₂ reached (as the iteration tracked it).
    pub residual: f64,
    /// max|r| reached.
    pub largest: f64,
    /// The residual stopped at the rounding floor 8 eps (1 + 4 D kappa) max|x| above the tolerance.
    pub at_floor: bool,
}
