//! Media in uniform motion.

use cf_grid::{Axis, CellField, Grid, Sides, Wall};

use super::*;
use crate::exact::Gaussian;

#[test]
fn a_moving_medium_only_shifts() {
    let (length, sigma, t, u) = (3.2, 0.12, 0.6, [1.5, 0.4]);
    let bump = Gaussian { height: 1.0, sigma };
    let from = |x: SVector<f64, 2>, centre: [f64; 2]| {
        (x - SVector::from(centre)).map(|d| d - (d / length).round() * length).norm()
    };
    let exact = radial(2.4, |r| bump.free(&law(), 2, r, t));
    let errors = [64, 128, 256].map(|n| {
        let grid = Grid::new([n, n], length / n as f64).unwrap();
        let (mut front, mut state) = start::<f64, 2>(&grid, &Sides::periodic(), u, |x| {
            (-from(x, [1.6; 2]).powi(2) / (2.0 * sigma * sigma)).exp()
        });
        let mass = state.mass(&grid);
        advance(&mut front, &mut state, t, 0.5);
        assert!((state.mass(&grid) / mass - 1.0).abs() < 1e-13);
        relative_error(&grid, &state.phi, |x| exact(from(x, u.map(|u| 1.6 + u * t))))
    });
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    assert!(orders[1] >= 1.8, "{errors:?} {orders:?}");
}

/// (k - tau u²) phi' = u phi - F between two values: an exponential layer.
#[test]
fn a_steady_layer_between_values_is_second_order() {
    let (u, length) = (0.5, 1.5);
    let errors = [24, 48, 96].map(|n| {
        let grid = Grid::new([1, n], length / n as f64).unwrap();
        let sides = Sides([Axis::Periodic, Axis::Walls([Wall::Value(1.0), Wall::Value(-0.5)])]);
        let (mut front, mut state) = start::<f64, 2>(&grid, &sides, [0.0, u], |_| 0.0);
        front.step(&mut state, Source::NONE, 40.0).unwrap();
        let steep = u / (1.0 - u * u);
        let share = |y: f64| ((steep * y).exp() - 1.0) / ((steep * length).exp() - 1.0);
        relative_error(&grid, &state.phi, |x| 1.0 - 1.5 * share(x[1]))
    });
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    assert!(orders[1] > 1.7 && errors[2] < 2e-3, "{errors:?} {orders:?}");
}

/// A box source in a flow along y, as in the paper's figure 3.
fn wake(n: usize, hc: f64, t: f64) -> (Grid<2>, FrontState<f64, 2>) {
    let grid = Grid::new([n, 2 * n], 4.0 / n as f64).unwrap();
    let law = Law::from_hc(hc, 0.5, 4.0, 0.0).unwrap();
    let calm = Wall::Absorbing { speed: law.speed().unwrap(), far: 0.0 };
    let mut front = Front::new(&grid, &Sides::all(calm), law, SVector::from([0.0, 0.5])).unwrap();
    let mut state = FrontState::new(&grid);
    let mut rate = CellField::new(grid.layout());
    grid.layout().par_cells(&mut rate, |at| 50.0 * f64::from((grid.centre(at.cell).add_scalar(-2.0)).amax() < 0.0625));
    let report = front.step(&mut state, Source::steady(&rate), t).unwrap();
    let balance = (state.mass(&grid) + report.outflow) / report.emitted;
    assert!((balance - 1.0).abs() < 1e-12, "{balance}");
    (grid, state)
}

#[test]
fn nothing_goes_upstream_at_the_speed_of_sound() {
    for hc in [1.0, 1.3] {
        let (grid, state) = wake(64, hc, 12.5);
        let edge = grid.cells()[1] / 4 - 1; // first row of the source
        grid.layout().each_cell(grid.layout().cells_region(), |at| {
            let slot = at.slot();
            let all = state.phi[slot].abs() + state.flux[0][slot].abs() + state.flux[1][slot].abs();
            assert!(at.cell[1] + 2 > edge || all < 1e-12, "{:?} {all}", at.cell);
        });
        assert!(grid.layout().max_abs(&state.phi) > 1.0);
    }
}

#[test]
fn wakes_have_the_cone_angle() {
    for angle in [60.0f64, 45.0, 30.0] {
        let (grid, state) = wake(64, 1.0 / angle.to_radians().sin(), 12.5);
        let [n, rows] = grid.cells();
        let mut ridge = Vec::new();
        for j in 0..rows {
            let y = grid.centre([0, j])[1] - 2.0;
            if (0.3..=1.0).contains(&y) {
                let phi = |i: usize| state.phi[grid.layout().slot([i, j])];
                let i = (n / 2..n - 1).max_by(|&a, &b| phi(a).total_cmp(&phi(b))).unwrap();
                let (l, m, r) = (phi(i - 1), phi(i), phi(i + 1));
                ridge.push((y, (i as f64 + 0.5 * (l - r) / (l - 2.0 * m + r)) * grid.h()));
            }
        }
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| ridge.iter().map(f).sum::<f64>() / ridge.len() as f64;
        let (y, x) = (mean(&|p| p.0), mean(&|p| p.1));
        let slope = mean(&|p| (p.0 - y) * (p.1 - x)) / mean(&|p| (p.0 - y).powi(2));
        let found = slope.atan().to_degrees();
        assert!((found - angle).abs() < 2.5, "{found} {angle}");
    }
}
