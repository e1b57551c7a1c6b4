//! What the front scheme refuses.

use cf_grid::End;

use crate::medium::MediumError;

/// A front stepper that could not be made, or a step it did not make. Only [`NotFinite`](Self::NotFinite) can leave a
/// state half way through a step; everything else leaves it unchanged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FrontError {
    /// There are no fronts without a finite signal speed.
    #[error(
        "the front scheme needs F_T = 0, tau > 0 and k > 0, found F_T = {fourier}, tau = {tau:e} s and k = {k:e} m²/s; \
         use Diffusion, which takes every law"
    )]
    NeedsWaves {
        /// F_T found.
        fourier: f64,
        /// tau found \[s\].
        tau: f64,
        /// k found \[m²/s\].
        k: f64,
    },
    /// The speed is not representable in the precision of the fields.
    #[error("the speed c = {speed:e} m/s or its inverse is out of the range of {precision}; use f64 or other units")]
    Speed {
        /// c = sqrt(k/tau) \[m/s\].
        speed: f64,
        /// "f32" or "f64".
        precision: &'static str,
    },
    /// Cells too coarse for a front to be visible. A warning: the scheme still runs, with the error stated.
    #[error(
        "the cells are too coarse for fronts: h/(c tau) = {ratio:.3} exceeds {limit}; the front scheme has errors \
         of 2 % at 1 and 14 % at 3, and no front survives that long: use Diffusion, or finer cells"
    )]
    TooCoarse {
        /// R_h = h/(c tau) \[1\].
        ratio: f64,
        /// Largest R_h in the documented range.
        limit: f64,
    },
    /// A Courant limit outside (0, 1].
    #[error("expected a Courant limit above 0 and at most 1, found {0}")]
    Courant(f64),
    /// A wall number is not usable.
    #[error("the {end:?} wall of axis {axis} has {what} = {value}, expected {expected}")]
    Wall {
        /// Axis of the wall.
        axis: usize,
        /// End of the axis.
        end: End,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is accepted.
        expected: &'static str,
    },
    /// The velocity is not finite, or crosses a wall that lets nothing pass.
    #[error(transparent)]
    Medium(#[from] MediumError),
    /// The time step is not a finite number >= 0.
    #[error("expected a finite time step >= 0, found {0}")]
    TimeStep(f64),
    /// More sub-steps than anyone wants to wait for.
    #[error(
        "a step of {dt:e} s needs {substeps:.0} sub-steps of {stable:e} s, more than {limit}; shorten it, or use an \
         implicit integrator of Diffusion, which has no limit"
    )]
    TooManySubsteps {
        /// Step asked for \[s\].
        dt: f64,
        /// Longest sub-step \[s\].
        stable: f64,
        /// Sub-steps it would take.
        substeps: f64,
        /// Sub-steps allowed.
        limit: usize,
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
    #[error("{field} is not finite{}; check initial values, sources and wall values", at(.cell))]
    NotFinite {
        /// Which field.
        field: &'static str,
        /// A cell where it happened, empty if unknown.
        cell: Vec<usize>,
    },
}

fn at(cell: &[usize]) -> String {
    if cell.is_empty() { String::new() } else { format!(" at cell {cell:?}") }
}
