//! Diffusion in a moving medium of variable velocity: orders by self-convergence.

mod common;

use std::f64::consts::PI;

use cf_diffusion::verify::Case;
use cf_diffusion::{Integrator, Law, Medium, Source, Splitting, State, medium};
use cf_grid::{CellField, Layout};
use common::cells;

/// phi at t = 0.4 on n² cells in a vortex between closed walls, dt in proportion to h.
fn vortex(n: usize, integrator: Integrator, splitting: Splitting) -> (Layout<2>, CellField<f64>) {
    let law = Law::new(0.02, 0.3, if integrator == Integrator::Kdk { 0.0 } else { 0.1 }).unwrap();
    let h = 1.0 / n as f64;
    let steps = n / 2;
    let mut case = Case::new([n, n], h, law, integrator, 0.4 / steps as f64).unwrap();
    (case.settings.splitting, case.settings.tolerance) = (splitting, 1e-9);
    let psi = |x: nalgebra::SVector<f64, 2>| 0.3 * ((PI * x[0]).sin() * (PI * x[1]).sin()).powi(2);
    let medium = Medium::Field(medium::stream_function(&case.grid, psi).unwrap());
    let grid = case.grid;
    let mut state = State::<f64, 2>::new(&grid, &law);
    case.set_phi(&mut state, |c| {
        let x = grid.centre(c);
        2.0 + (PI * x[0]).cos() + 0.5 * (2.0 * PI * x[0]).cos() * (PI * x[1]).cos()
    });
    let mut stepper = case.stepper::<f64>().unwrap();
    for _ in 0..steps {
        stepper.step(&mut state, &medium, Source::NONE, case.dt).unwrap();
    }
    (*grid.layout(), state.phi)
}

/// Mean difference of a solution and the mean of the finer one over each cell.
fn apart(coarse: &(Layout<2>, CellField<f64>), fine: &(Layout<2>, CellField<f64>)) -> f64 {
    let mut means = coarse.1.clone();
    coarse.0.each_cell(coarse.0.cells_region(), |at| {
        let children = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|d| [2 * at.cell[0] + d[0], 2 * at.cell[1] + d[1]]);
        means[at.slot()] = children.map(|c| fine.1[fine.0.slot(c)]).iter().sum::<f64>() / 4.0;
    });
    let (a, b) = (cells(&coarse.0, &coarse.1), cells(&coarse.0, &means));
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64
}

#[test]
fn orders_in_a_vortex() {
    for (integrator, splitting, least, most) in [
        (Integrator::Sdirk2, Splitting::Strang, 1.8, 2.2),
        (Integrator::Kdk, Splitting::Strang, 1.8, 2.2),
        (Integrator::PaperBe, Splitting::Paper, 0.7, 1.35),
    ] {
        let solutions = [32, 64, 128].map(|n| vortex(n, integrator, splitting));
        let order = (apart(&solutions[0], &solutions[1]) / apart(&solutions[1], &solutions[2])).log2();
        assert!(order > least && order < most, "{integrator:?} {splitting:?}: {order:.2}");
    }
}
