//! Two and three dimensions at rest.

use cf_grid::{Grid, Sides, Wall};

use super::*;
use crate::exact::Gaussian;

/// Smallest and largest phi of a sharp disc at t = 0.6 tau; its rim cells start with the share of them it covers.
fn disc(n: usize, cfl: f64) -> (f64, f64) {
    let h = 2.4 / n as f64;
    let grid = Grid::new([n, n], h).unwrap();
    let covered = |x: SVector<f64, 2>| {
        let at = |k: usize| ((k as f64 + 0.5) / 16.0 - 0.5) * h - 1.2;
        let inside = |k: usize| (x[0] + at(k % 16)).hypot(x[1] + at(k / 16)) < 0.4;
        (0..256).filter(|&k| inside(k)).count() as f64 / 256.0
    };
    let (front, mut state) = start::<f64, 2>(&grid, &Sides::periodic(), [0.0; 2], covered);
    advance(&mut front.with_courant(0.9).unwrap(), &mut state, 0.6, cfl);
    grid.layout().range(&state.phi)
}

#[test]
fn a_disc_does_not_overshoot() {
    let (coarse, fine) = (disc(128, 0.5), disc(384, 0.5));
    assert!(coarse.1 <= fine.1 * 1.002 && coarse.0 >= fine.0 * 1.002, "{coarse:?} {fine:?}");
    // What Front::COURANT is for.
    assert!(disc(128, 0.9).1 > 1.1 * fine.1);
}

fn gaussian<const D: usize>(n: usize, sigma: f64) -> f64 {
    let length = 2.4;
    let bump = Gaussian { height: 1.0, sigma };
    let grid = Grid::new([n; D], length / n as f64).unwrap();
    let centre = SVector::<f64, D>::repeat(0.5 * length);
    let (mut front, mut state) = start::<f64, D>(&grid, &Sides::periodic(), [0.0; D], |x| {
        (-(x - centre).norm_squared() / (2.0 * sigma * sigma)).exp()
    });
    advance(&mut front, &mut state, 0.5, 0.5);
    let exact = radial(2.1, |r| bump.free(&law(), D as u32, r, 0.5));
    relative_error(&grid, &state.phi, |x| exact((x - centre).norm()))
}

#[test]
fn smooth_data_is_second_order() {
    let errors = [48, 96, 192].map(|n| gaussian::<2>(n, 0.12));
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    assert!(orders[1] > 1.8 && errors[2] < 6e-3, "{errors:?} {orders:?}");
    let errors = [24, 48].map(|n| gaussian::<3>(n, 0.2));
    let order = (errors[0] / errors[1]).log2();
    assert!(order > 1.7 && errors[1] < 4e-2, "{errors:?} {order}");
}

#[test]
fn axes_are_equal() {
    let (n, m) = (21, 30);
    let run = |cells: [usize; 3], swap: [usize; 3], reversed: bool| {
        let grid = Grid::new(cells, 0.1).unwrap();
        let (mut front, mut state) = start::<f64, 3>(&grid, &Sides::all(Wall::CLOSED), [0.0; 3], |x| {
            (x[swap[0]] * 3.0).sin() + x[swap[1]] * x[swap[2]]
        });
        front.set_sweep_reversed(reversed);
        advance(&mut front, &mut state, 0.05, 0.5);
        assert_eq!(front.sweep_reversed(), !reversed);
        (grid, state)
    };
    let (grid, a) = run([n, m, 5], [0, 1, 2], false);
    let (turned, b) = run([5, m, n], [2, 1, 0], true);
    grid.layout().each_cell(grid.layout().cells_region(), |at| {
        let [i, j, k] = at.cell;
        let there = turned.layout().slot([k, j, i]);
        assert!((a.phi[at.slot()] - b.phi[there]).abs() < 1e-14);
        assert!((a.flux[0][at.slot()] - b.flux[2][there]).abs() < 1e-14);
    });
}

#[test]
fn a_source_is_second_order_and_emits_what_it_says() {
    // W = sin x on a periodic line in y: one mode, forced; phi'' + phi' + phi = W(1 + d/dt) from rest.
    let tau = std::f64::consts::TAU;
    let run = |n: usize| {
        let grid = Grid::new([n, 3], tau / n as f64).unwrap();
        let (mut front, mut state) = start::<f64, 2>(&grid, &Sides::periodic(), [0.0; 2], |_| 0.0);
        let rate = start::<f64, 2>(&grid, &Sides::periodic(), [0.0; 2], |x| x[0].sin() + 0.25).1.phi;
        let report = front.step(&mut state, Source::during(&rate, 0.5), 1.5).unwrap();
        // All but the rim before the first cell and behind the last.
        let part = Rate { first: grid.layout().slot([0; 2]), values: &rate[grid.layout().slot([0; 2])..] };
        let (mut front, mut again) = start::<f64, 2>(&grid, &Sides::periodic(), [0.0; 2], |_| 0.0);
        assert_eq!(front.step(&mut again, Source::during(part, 0.5), 1.5), Ok(report));
        assert!(again == state);
        let expected = 0.5 * 1.5 * 0.25 * tau * 3.0 * grid.h();
        assert!((report.emitted / expected - 1.0).abs() < 1e-12);
        assert!((state.mass(&grid) / expected - 1.0).abs() < 1e-12);
        // phi = 1 + e^{-t/2} (-cos wt + sin wt / (2 w)), w² = 3/4, times the amplitude 1/2, plus the mean.
        let (w, t) = (0.75f64.sqrt(), 1.5);
        let mode = 1.0 + (-0.5f64 * t).exp() * (-(w * t).cos() + (w * t).sin() / (2.0 * w));
        relative_error(&grid, &state.phi, |x| 0.5 * (mode * x[0].sin() + 0.25 * t))
    };
    let errors = [run(32), run(64), run(128)];
    assert!(errors[1] / errors[2] > 3.4 && errors[2] < 1e-3, "{errors:?}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let grid = Grid::new([67, 31, 40], 0.05).unwrap();
            let sides = Sides::all(Wall::Open { inflow: 0.5 });
            let (mut front, mut state) =
                start::<f32, 3>(&grid, &sides, [0.3, -1.5, 0.7], |x| (x[0] * x[1] - 2.0 * x[2]).sin());
            let rate = state.phi.clone();
            let report = front.step(&mut state, Source::steady(&rate), 0.2).unwrap();
            (state, report)
        })
    };
    assert!(run(1) == run(2));
}
