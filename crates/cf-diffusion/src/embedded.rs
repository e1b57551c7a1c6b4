//! The error of a step of SDIRK2, from its own two stages: no further solve.
//!
//! With K1 = (Y1 - U)/gamma and K2 = (Y2 - R2)/gamma, the changes of the two stages over dt, U + dt K1 is of first order
//! and what the step adds to it is, to leading order, the error of that one:
//!
//! ```text
//! e = 1/2 ||K2 - K1||        ||U||² = sum (phi² + tau/k |q_C|²) h^D = 2 E'
//! ```
//!
//! It is the error of a step of lower order, O(dt²), and therefore an upper estimate of that of SDIRK2 over many steps: at
//! the end of a run the error is below the largest e, on waves just below, on diffusion far below.

use cf_grid::{Grid, Real, Sides, Wall};

use crate::energy;
use crate::law::Law;
use crate::state::State;

/// The scratch of the estimate: one state.
pub(crate) struct Embedded<T, const D: usize> {
    mix: State<T, D>,
}

impl<T: Real, const D: usize> Embedded<T, D> {
    pub fn new(grid: &Grid<D>, law: &Law) -> Self {
        Self { mix: State::new(grid, law) }
    }

    pub fn bytes(&self) -> usize {
        self.mix.bytes()
    }

    /// Before the first stage: keeps U.
    pub fn begin(&mut self, grid: &Grid<D>, sides: &Sides<Wall, D>, state: &State<T, D>) {
        self.combine(grid, sides, state, 0.0, 1.0);
    }

    /// Between the stages, at R2 = U + (1 - gamma) K1: keeps R2/gamma + K1.
    pub fn between(&mut self, grid: &Grid<D>, sides: &Sides<Wall, D>, state: &State<T, D>, gamma: f64) {
        let rest = 1.0 / (1.0 - gamma);
        self.combine(grid, sides, state, -rest, 1.0 / gamma + rest);
    }

    /// After the second stage: e [P m^(D/2)].
    pub fn end(&mut self, grid: &Grid<D>, sides: &Sides<Wall, D>, law: &Law, state: &State<T, D>, gamma: f64) -> f64 {
        self.combine(grid, sides, state, -1.0, 1.0 / gamma);
        0.5 * norm(grid, sides, law, &self.mix)
    }

    /// mix = a mix + b state, on everything that the energy counts.
    fn combine(&mut self, grid: &Grid<D>, sides: &Sides<Wall, D>, state: &State<T, D>, a: f64, b: f64) {
        let layout = grid.layout();
        let (a, b) = (T::of(a), T::of(b));
        let one = |region, mix: &mut [T], from: &[T]| {
            layout.par_runs(
                region,
                mix,
                #[inline(always)]
                |run, mix: &mut [T]| {
                    for (mix, &value) in mix.iter_mut().zip(run.row(from)) {
                        *mix = a * *mix + b * value;
                    }
                },
            );
        };
        one(layout.cells_region(), &mut self.mix.phi, &state.phi);
        let (Some(mix), Some(from)) = (&mut self.mix.slow_flux, &state.slow_flux) else { return };
        for axis in 0..D {
            one(layout.faces_region(axis, sides.is_periodic(axis)), mix.axis_mut(axis), from.axis(axis));
        }
    }
}

/// sqrt(2 E') \[P m^(D/2)\], the norm in which implicit steps are not expansive.
pub(crate) fn norm<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<Wall, D>,
    law: &Law,
    state: &State<T, D>,
) -> f64 {
    (2.0 * energy::lyapunov(grid, sides, law, state)).sqrt()
}
