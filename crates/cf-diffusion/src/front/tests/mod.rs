//! Front tests: lines against the telegraph equation, planes, moving media, walls, limits.

mod limits;
mod line;
mod moving;
mod plane;
mod walls;

use cf_grid::{Grid, Real, Sides, Wall};
use nalgebra::SVector;

use super::{Front, FrontState};
use crate::{Law, Rate, Source};

/// c = 1 m/s, tau = 1 s.
fn law() -> Law {
    Law::cattaneo(1.0, 1.0).unwrap()
}

/// A stepper for [`law`] and a state with phi given at the cell centres.
fn start<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<Wall, D>,
    u: [f64; D],
    phi: impl Fn(SVector<f64, D>) -> f64 + Sync,
) -> (Front<T, D>, FrontState<T, D>) {
    let front = Front::new(grid, sides, law(), SVector::from(u)).unwrap();
    let mut state = FrontState::new(grid);
    grid.layout().par_cells(&mut state.phi, |at| T::of(phi(grid.centre(at.cell))));
    (front, state)
}

/// To time `t` in equal steps at Courant number `cfl` of |u|max + c.
fn advance<T: Real, const D: usize>(front: &mut Front<T, D>, state: &mut FrontState<T, D>, t: f64, cfl: f64) {
    let longest = cfl * front.grid.h() / (front.velocity.amax() + front.speed);
    let steps = (t / longest * (1.0 - 1e-12)).ceil();
    for _ in 0..steps as usize {
        let report = front.step(state, Source::NONE, t / steps).unwrap();
        assert_eq!(report.substeps, 1);
    }
}

/// Σ|x - exact| / Σ|exact| over the cells.
fn relative_error<const D: usize>(grid: &Grid<D>, x: &[f64], exact: impl Fn(SVector<f64, D>) -> f64 + Sync) -> f64 {
    let layout = grid.layout();
    let (error, size): (f64, f64) = layout.par_runs(layout.cells_region(), (), |run, ()| {
        run.ats().fold((0.0, 0.0), |(error, size), at| {
            let e = exact(grid.centre(at.cell));
            (error + (x[at.slot()] - e).abs(), size + e.abs())
        })
    });
    error / size
}

/// A radial function by linear interpolation between 4000 values: exact solutions by quadrature are slow.
fn radial(most: f64, f: impl Fn(f64) -> f64) -> impl Fn(f64) -> f64 + Sync {
    let n = 4000;
    let values: Vec<f64> = (0..=n + 1).map(|i| f(most * i as f64 / n as f64)).collect();
    move |r| {
        let x = r / most * n as f64;
        let i = (x as usize).min(n);
        values[i] + (x - i as f64) * (values[i + 1] - values[i])
    }
}
