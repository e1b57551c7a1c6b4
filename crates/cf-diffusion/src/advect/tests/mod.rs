//! Transport as a whole.

mod accuracy;
mod balance;
mod bounds;
mod flux;
mod refusals;

use std::f64::consts::PI;

use cf_grid::{Axis, CellField, FaceField, Grid, Real, Sides, Wall};
use nalgebra::SVector;

use crate::advect::Advection;
use crate::medium::{Medium, stream_function};

const METHODS: [Advection; 3] = [Advection::Muscl, Advection::Cubic, Advection::Linear];

fn noise(seed: usize) -> f64 {
    ((seed.wrapping_mul(2654435761) ^ 0x5bd1) % 100_003) as f64 / 100_003.0
}

fn noisy<T: Real, const D: usize>(grid: &Grid<D>) -> CellField<T> {
    let mut phi = CellField::new(grid.layout());
    grid.layout().par_cells(&mut phi, |at| T::of(noise(at.slot()) + 0.25));
    phi
}

fn noisy_flux<T: Real, const D: usize>(grid: &Grid<D>, sides: &Sides<Wall, D>) -> FaceField<T, D> {
    let mut q = FaceField::new(grid.layout());
    for a in 0..D {
        let sites = crate::advect::Sites::faces(grid.layout(), sides, a);
        grid.layout().par_region(sites.region, q.axis_mut(a), |at| T::of(noise(7 * at.slot() + a) - 0.5));
    }
    q
}

fn mass<T: Real, const D: usize>(grid: &Grid<D>, phi: &CellField<T>) -> f64 {
    grid.layout().sum(phi) * grid.cell_volume()
}

/// A vortex that touches no wall of the unit square, and one that turns in a periodic box.
fn vortex<T: Real>(grid: &Grid<2>) -> Medium<T, 2> {
    let psi = |x: SVector<f64, 2>| (PI * x[0]).sin().powi(2) * (PI * x[1]).sin().powi(2) / PI;
    Medium::Field(stream_function(grid, psi).unwrap())
}

fn walls_2d() -> Vec<Sides<Wall, 2>> {
    let open = Wall::Open { inflow: 0.5 };
    let absorbing = Wall::Absorbing { speed: 1.0, far: -0.25 };
    vec![
        Sides::periodic(),
        Sides::all(open),
        Sides([Axis::Walls([Wall::Value(2.0), open]), Axis::Walls([absorbing, Wall::Value(-1.0)])]),
        Sides([Axis::Periodic, Axis::Walls([absorbing, absorbing])]),
        Sides([Axis::Walls([open, Wall::Value(1.0)]), Axis::Periodic]),
    ]
}

fn difference(grid: &Grid<2>, a: &CellField<f64>, b: &CellField<f64>) -> f64 {
    let mut d = a.clone();
    d.iter_mut().zip(b.iter()).for_each(|(a, b)| *a -= b);
    grid.layout().sum_abs(&d) / grid.layout().sum_abs(b)
}
