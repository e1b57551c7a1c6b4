//! Why a measurement did not come about.

/// A problem that cannot be posed, or a step that failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TradeoffError {
    /// The grid is impossible.
    #[error(transparent)]
    Grid(#[from] cf_grid::GridError),
    /// The law is impossible.
    #[error(transparent)]
    Law(#[from] cf_diffusion::LawError),
    /// The medium is impossible.
    #[error(transparent)]
    Medium(#[from] cf_diffusion::MediumError),
    /// A step failed.
    #[error(transparent)]
    Step(#[from] cf_diffusion::StepError),
    /// A step of the front scheme failed.
    #[error(transparent)]
    Front(#[from] cf_diffusion::FrontError),
    /// A fluid failed.
    #[error(transparent)]
    Flow(#[from] cf_fluid::FlowError),
    /// Transport failed.
    #[error(transparent)]
    Advect(#[from] cf_diffusion::AdvectError),
    /// The reference failed.
    #[error(transparent)]
    Spectral(#[from] cf_spectral::SpectralError),
    /// No threads.
    #[error("cannot start the threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A setting that has no meaning on a problem.
    #[error("{scheme} cannot do {problem}")]
    Unsuited {
        /// The integrator.
        scheme: crate::Scheme,
        /// The problem.
        problem: String,
    },
}
