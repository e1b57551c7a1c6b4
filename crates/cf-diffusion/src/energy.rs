//! The Lyapunov functionals: what must not grow in a medium at rest.

use cf_grid::{Grid, Real, Sides, Wall, row_dot};

use crate::law::Law;
use crate::state::State;

/// E' = 1/2 ∫ phi² + tau/(2 k) ∫ |q_C|² [P² m^D]: finite for every law, non-increasing under every A-stable step with
/// closed, periodic or zero-value walls and no source. Value-wall faces weigh 1/2.
pub fn lyapunov<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<Wall, D>,
    law: &Law,
    state: &State<T, D>,
) -> f64 {
    weighted(grid, sides, state, law.tau() / law.k())
}

/// E = 1/2 ∫ phi² + tau/(2 k_C) ∫ |q_C|² \[P² m^D\], the energy of the exact identity of `PaperBe`; needs F_T < 1.
pub fn cattaneo_energy<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<Wall, D>,
    law: &Law,
    state: &State<T, D>,
) -> f64 {
    weighted(grid, sides, state, law.tau() / law.k_cattaneo())
}

fn weighted<T: Real, const D: usize>(grid: &Grid<D>, sides: &Sides<Wall, D>, state: &State<T, D>, weight: f64) -> f64 {
    let layout = grid.layout();
    let phi = layout.dot(&state.phi, &state.phi);
    let flux =
        state.slow_flux.as_ref().map_or(0.0, |q| (0..D).map(|a| face_square(grid, sides, a, q.axis(a))).sum::<f64>());
    // A law without diffusivity has no flux; 0 · inf is no energy.
    let flux = if flux == 0.0 { 0.0 } else { weight * flux };
    0.5 * (phi + flux) * grid.cell_volume()
}

/// Σ w q² over the faces of an axis, w = 1/2 on walls. Faces that hold no flux are zero.
pub(crate) fn face_square<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<Wall, D>,
    axis: usize,
    q: &[T],
) -> f64 {
    let layout = grid.layout();
    let periodic = sides.is_periodic(axis);
    let all: f64 = layout.par_runs(layout.faces_region(axis, periodic), (), |run, ()| row_dot(run.row(q), run.row(q)));
    let mut on_walls = 0.0;
    if !periodic {
        for end in [0, layout.cells()[axis]] {
            let mut wall = layout.cells_region();
            (wall.low[axis], wall.high[axis]) = (end, end + 1);
            on_walls += layout.par_runs(wall, (), |run, ()| row_dot(run.row(q), run.row(q)));
        }
    }
    all - 0.5 * on_walls
}
