//! What can be wrong with the numbers of a law; failures of a step are in `step_error`.

/// A law that cannot be built. The message names the parameter, the value found and what is expected.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LawError {
    /// One number is outside its range, or is not a number.
    #[error("{parameter} is {found:e}, expected {expected}")]
    OutOfRange {
        /// The parameter's name and unit, as the documentation of [`Law`](crate::law::Law) has it.
        parameter: &'static str,
        /// The value given.
        found: f64,
        /// The range in words.
        expected: &'static str,
    },
    /// A finite speed was asked of a law without memory, for which no diffusivity gives one.
    #[error(
        "a law with tau = {tau:e} s and fourier share {fourier} has no finite speed, expected tau > 0 and a share below 1"
    )]
    NoMemory {
        /// Relaxation time τ \[s\] given.
        tau: f64,
        /// Fourier share F_T given.
        fourier: f64,
    },
}
