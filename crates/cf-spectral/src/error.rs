//! Why the spectral step is refused.

use cf_grid::{End, Wall};

/// A domain, a medium or a step that transforms cannot do. Nothing of the state has changed, except for `NotFinite`.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpectralError {
    /// Only closed, valued and periodic sides have modes that a transform finds.
    #[error(
        "the {end:?} wall of axis {axis} is {wall:?}, expected Flux(0.0), a finite Value or a periodic axis; \
         use Diffusion for other walls"
    )]
    Wall {
        /// Axis of the wall.
        axis: usize,
        /// End of the axis.
        end: End,
        /// What was found.
        wall: Wall,
    },
    /// The continuous solution is made for walls of value 0.
    #[error(
        "the {end:?} wall of axis {axis} is {wall:?}, expected Flux(0.0), Value(0.0) or a periodic axis; subtract the steady state first"
    )]
    Lifted {
        /// Axis of the wall.
        axis: usize,
        /// End of the axis.
        end: End,
        /// What was found.
        wall: Wall,
    },
    /// An axis has more cells than modes can be numbered.
    #[error("axis {axis} has {cells} cells, expected at most 2^32; use fewer cells")]
    Cells {
        /// The axis.
        axis: usize,
        /// Cells along it.
        cells: usize,
    },
    /// Velocities that vary couple the modes.
    #[error("the medium has a velocity on every face, expected Still or Uniform; use Diffusion for such a medium")]
    Field,
    /// The medium crosses a wall, or does not move at a finite speed.
    #[error(
        "the medium moves at {velocity} m/s along axis {axis}, expected a finite velocity, and 0 where the axis is not \
         periodic"
    )]
    Velocity {
        /// The axis.
        axis: usize,
        /// Velocity found \[m/s\].
        velocity: f64,
    },
    /// A source in a moving medium.
    #[error("there is a source in a moving medium, expected Still with a source or a moving medium without")]
    MovingSource,
    /// The time step is not a finite number >= 0.
    #[error("expected a finite time step >= 0 s, found {0}")]
    TimeStep(f64),
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
    /// The state lacks q_C, or has one the law does not need.
    #[error("the state {} a slow flux, but the law {} one; make it with State::new for this law",
        if *.found { "has" } else { "lacks" }, if *.found { "does not use" } else { "needs" })]
    SlowFlux {
        /// Whether the state has q_C.
        found: bool,
    },
    /// NaN or infinity appeared.
    #[error("phi is not finite after the step; check initial values, sources and walls for NaN and infinity")]
    NotFinite,
}
