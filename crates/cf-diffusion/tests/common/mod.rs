//! Boxes and comparisons that several tests share.
#![allow(dead_code)]

use cf_diffusion::verify::Case;
use cf_diffusion::{Integrator, Law, State};
use cf_grid::{Axis, Layout, Real, Sides, Wall};

/// A line of `n` cells: one cell wide, between two walls.
pub fn line(n: usize, length: f64, ends: [Wall; 2], law: Law, integrator: Integrator, dt: f64) -> Case<2> {
    let mut case = Case::new([n, 1], length / n as f64, law, integrator, dt).unwrap();
    case.sides = Sides([Axis::Walls(ends), Axis::Periodic]);
    case.settings.tolerance = 1e-12;
    case
}

/// phi along a line.
pub fn profile<T: Real>(case: &Case<2>, state: &State<T, 2>) -> Vec<f64> {
    (0..case.grid.cells()[0]).map(|i| state.phi[case.grid.layout().slot([i, 0])].f64()).collect()
}

/// phi of every cell.
pub fn cells<T: Real, const D: usize>(layout: &Layout<D>, phi: &[T]) -> Vec<f64> {
    let mut all = Vec::new();
    layout.each_cell(layout.cells_region(), |at| all.push(phi[at.slot()].f64()));
    all
}

/// The largest |a - b|.
pub fn largest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// |measured/expected - 1| within `share`.
pub fn assert_about(what: &str, measured: f64, expected: f64, share: f64) {
    assert!((measured / expected - 1.0).abs() <= share, "{what}: {measured:.3e}, expected {expected:.3e}");
}
