//! One dimension: a line of cells along any axis.

use cf_grid::{Grid, Sides, Wall};
use proptest::prelude::*;

use super::*;
use crate::exact::{Gaussian, Telegraph};

/// A Riemann step on a box of 3 c tau at t = 0.8 tau: phi along the line and its spacing.
fn riemann(n: usize, axis: usize, cfl: f64) -> (Vec<f64>, f64) {
    let h = 3.0 / n as f64;
    let mut cells = [1; 2];
    cells[axis] = n;
    let grid = Grid::new(cells, h).unwrap();
    let (mut front, mut state) =
        start::<f64, 2>(&grid, &Sides::all(Wall::CLOSED), [0.0; 2], |x| f64::from(x[axis] < 1.5));
    advance(&mut front, &mut state, 0.8, cfl);
    let mut line = vec![0.0; n];
    grid.layout().each_cell(grid.layout().cells_region(), |at| line[at.cell[axis]] = state.phi[at.slot()]);
    (line, h)
}

/// Mean |phi - mean of the exact solution over the cell|.
fn mean_error(phi: &[f64], h: f64) -> f64 {
    let exact = Telegraph::new(&law()).unwrap();
    let (n, points) = (phi.len(), 40);
    let mean = |i: usize| {
        let x = |k: usize| (i as f64 + (k as f64 + 0.5) / f64::from(points as u32)) * h - 1.5;
        (0..points).map(|k| exact.riemann_phi(x(k), 0.8)).sum::<f64>() / points as f64
    };
    phi.iter().enumerate().map(|(i, v)| (v - mean(i)).abs()).sum::<f64>() / n as f64
}

/// Cells over which the front falls from 90 to 10 % of its jump.
fn width(phi: &[f64]) -> f64 {
    let jump = Telegraph::new(&law()).unwrap().front(0.8);
    let at = |level: f64| {
        let i = (phi.len() / 2..phi.len() - 1).find(|&i| phi[i] >= level && phi[i + 1] < level).unwrap();
        i as f64 + (phi[i] - level) / (phi[i] - phi[i + 1])
    };
    at(0.1 * jump) - at(0.9 * jump)
}

#[test]
fn a_step_matches_the_table() {
    for (n, cfl, error, cells) in
        [(100, 0.5, 5.1e-3, 3.4), (100, 0.9, 2.9e-3, 2.4), (400, 0.5, 2.0e-3, 4.8), (400, 0.9, 1.2e-3, 3.4)]
    {
        let (phi, h) = riemann(n, 0, cfl);
        let (e, w) = (mean_error(&phi, h), width(&phi));
        assert!((e / error - 1.0).abs() < 0.2 && (w / cells - 1.0f64).abs() < 0.1, "{n} {cfl}: {e:e} {w}");
        let (most, least) = phi.iter().fold((0.0f64, 1.0f64), |(m, l), &v| (m.max(v), l.min(v)));
        assert!(most <= 1.0 + 1e-14 && least >= -1e-14, "{most} {least}");
    }
}

#[test]
fn both_axes_are_the_same() {
    let (x, y) = (riemann(101, 0, 0.9).0, riemann(101, 1, 0.9).0);
    assert_eq!(x, y);
}

#[test]
fn smooth_data_is_second_order() {
    let bump = Gaussian { height: 1.0, sigma: 0.1 };
    let errors = [100, 200, 400].map(|n| {
        let grid = Grid::new([n, 1], 3.0 / n as f64).unwrap();
        let closed = Sides::all(Wall::CLOSED);
        let start = start::<f64, 2>(&grid, &closed, [0.0; 2], |x| bump.free(&law(), 1, x[0] - 1.5, 0.0));
        let (mut front, mut state) = start;
        advance(&mut front, &mut state, 0.8, 0.9);
        relative_error(&grid, &state.phi, |x| bump.free(&law(), 1, (x[0] - 1.5).abs(), 0.8))
    });
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    assert!(orders.iter().all(|o| (1.8..2.6).contains(o)), "{errors:?} {orders:?}");
    assert!(errors[2] < 7e-4, "{errors:?}");
}

proptest! {
    /// c phi ± q >= 0 at the start is kept, and neither wave leaves the bounds of both.
    #[test]
    fn waves_stay_positive(
        values in prop::collection::vec((0.0..1.0f64, -1.0..1.0f64), 1..90),
        cfl in 0.1..0.9f64, axis in 0..2usize,
    ) {
        let mut cells = [1; 2];
        cells[axis] = values.len();
        let grid = Grid::new(cells, 0.1).unwrap();
        let (mut front, mut state) = start::<f64, 2>(&grid, &Sides::all(Wall::CLOSED), [0.0; 2], |_| 0.0);
        for (i, &(phi, share)) in values.iter().enumerate() {
            let mut cell = [0; 2];
            cell[axis] = i;
            let slot = grid.layout().slot(cell);
            (state.phi[slot], state.flux[axis][slot]) = (phi, phi * share);
        }
        let most = values.iter().map(|&(phi, share)| phi * (1.0 + share.abs())).fold(0.0, f64::max);
        advance(&mut front, &mut state, 1.0, cfl);
        grid.layout().each_cell(grid.layout().cells_region(), |at| {
            let (phi, q) = (state.phi[at.slot()], state.flux[axis][at.slot()]);
            assert!(phi - q.abs() >= -1e-14 && phi + q.abs() <= most + 1e-14, "{phi} {q}");
        });
    }
}
