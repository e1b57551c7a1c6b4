//! Pure f32: exact constants, any kappa, any amplitude.

use cf_grid::Layout;
use cf_linear::{Deviation, Options, Plan, Solver, Stop};

use crate::common::*;

fn options() -> Options {
    Options { plan: Some(Plan::Multigrid), ..Default::default() }
}

/// max|x32 - x64|/max|b| as far as f32 goes, and the iterations to 1e-6.
fn error_against_f64<const D: usize>(cells: [usize; D], mix: [Mix; D], kappa: f64) -> (f64, usize) {
    let case = Case::new(cells, mix, 1.0, kappa);
    let b = random_field::<f32, D>(&case.layout, 9);
    let wide: Vec<f64> = b.iter().map(|&v| f64::from(v)).collect();
    let (mut x, mut exact) = (vec![0f32; b.len()], vec![0.0; b.len()]);
    let mut single = Solver::<f32, D>::new(&case.helmholtz(), options()).unwrap();
    let mut double = Solver::<f64, D>::new(&case.helmholtz(), options()).unwrap();
    let s = single.solve(&b, &mut x, Stop::Relative(1e-6)).unwrap_or_else(|e| panic!("{mix:?} {kappa:e}: {e}"));
    single.solve(&b, &mut x, Stop::Relative(1e-8)).unwrap_or_else(|e| panic!("{mix:?} {kappa:e}: {e}"));
    double.solve(&wide, &mut exact, Stop::Relative(1e-13)).unwrap_or_else(|e| panic!("{mix:?} {kappa:e}: {e}"));
    let mut error = 0f64;
    case.layout.each_cell(case.layout.cells_region(), |at| {
        error = error.max((f64::from(x[at.slot()]) - exact[at.slot()]).abs());
    });
    (error / wide.iter().fold(0.0, |m, v| v.abs().max(m)), s.iterations)
}

const KAPPAS: [f64; 8] = [1e-6, 1e-2, 1.0, 100.0, 1e6, 1e12, 1e40, 1e300];

#[test]
fn conserving_boxes_are_right_to_the_last_digits_for_any_kappa() {
    for kappa in KAPPAS {
        for mix in [[CLOSED; 2], [None; 2], [None, CLOSED]] {
            for (cells, allowed) in [([64, 64], 8), ([33, 20], 10), ([61, 97], 10)] {
                let (error, iterations) = error_against_f64(cells, mix, kappa);
                assert!(error <= 2e-7, "{cells:?} {mix:?} {kappa:e}: error {error:e}");
                assert!(iterations <= allowed, "{cells:?} {mix:?} {kappa:e}: {iterations}");
            }
        }
        let (error, iterations) = error_against_f64([24, 24, 24], [CLOSED, None, CLOSED], kappa);
        assert!(error <= 2.5e-7 && iterations <= 8, "3D {kappa:e}: error {error:e}, {iterations}");
    }
}

#[test]
fn held_boxes_need_as_few_iterations() {
    for kappa in KAPPAS {
        for mix in [[HELD; 2], [HELD, CLOSED], [None, MIXES[4]]] {
            let (error, iterations) = error_against_f64([64, 48], mix, kappa);
            // Far beyond the wave walls the constant is all but free, and f32 is at its floor.
            let allowed = if kappa > 1e12 { 15 } else { 8 };
            assert!(error <= 1e-6 && iterations <= allowed, "{mix:?} {kappa:e}: error {error:e}, {iterations}");
        }
    }
}

fn solve(cells: [usize; 2], mix: [Mix; 2], kappa: f64, b: &[f32]) -> Vec<f32> {
    let case = Case::new(cells, mix, 1.0, kappa);
    let mut x = vec![0.0; b.len()];
    for plan in [None, Some(Plan::Multigrid)] {
        let mut solver = Solver::<f32, 2>::new(&case.helmholtz(), Options { plan, ..Default::default() }).unwrap();
        let s = solver.solve(b, &mut x, Stop::Relative(1e-6)).unwrap();
        assert!(s.residual.is_finite() && x.iter().all(|v| v.is_finite()));
    }
    x
}

#[test]
fn constants_are_exact() {
    for cells in [[64, 64], [33, 17], [1, 9], [7, 3]] {
        let layout = Layout::new(cells).unwrap();
        for value in [1.0, 0.1, -3.3e7, 1e-30] {
            let mut b = vec![0f32; layout.slots()];
            layout.par_cells(&mut b, |_| value);
            for kappa in KAPPAS {
                for mix in [[CLOSED; 2], [None, CLOSED]] {
                    let x = solve(cells, mix, kappa, &b);
                    layout
                        .each_cell(layout.cells_region(), |at| assert_eq!(x[at.slot()], value, "{cells:?} {kappa:e}"));
                }
            }
        }
    }
}

#[test]
fn a_small_signal_on_a_large_offset_survives() {
    let (cells, offset) = ([48, 40], 1e6f32);
    let layout = Layout::new(cells).unwrap();
    let signal = random_field::<f32, 2>(&layout, 3);
    let mut sum = signal.clone();
    layout.each_cell(layout.cells_region(), |at| sum[at.slot()] = 50.0 * signal[at.slot()] + offset);
    // What is left of the signal once it stands on the offset.
    let mut rest = vec![0f32; layout.slots()];
    layout.each_cell(layout.cells_region(), |at| rest[at.slot()] = sum[at.slot()] - offset);
    for kappa in [1e-3, 0.5, 30.0] {
        let (with, without) = (solve(cells, [CLOSED; 2], kappa, &sum), solve(cells, [CLOSED; 2], kappa, &rest));
        layout.each_cell(layout.cells_region(), |at| {
            let difference = with[at.slot()] - offset - without[at.slot()];
            assert!(difference.abs() <= offset * f32::EPSILON, "{kappa}: {difference}");
        });
    }
}

#[test]
fn amplitudes_scale_bit_by_bit() {
    for (mix, kappa) in [([CLOSED; 2], 50.0), ([HELD, None], 50.0), ([HELD; 2], 0.01), ([CLOSED; 2], 1e30)] {
        let layout = Layout::new([40, 31]).unwrap();
        let b = random_field::<f32, 2>(&layout, 6);
        let x = solve([40, 31], mix, kappa, &b);
        for power in [-100, -40, -1, 3, 60, 100] {
            let factor = 2f32.powi(power);
            let scaled: Vec<f32> = b.iter().map(|v| v * factor).collect();
            let y = solve([40, 31], mix, kappa, &scaled);
            assert!(x.iter().zip(&y).all(|(x, y)| x * factor == *y || (x * factor).is_subnormal()), "{mix:?} {power}");
        }
        for amplitude in [1e-30f32, 1e30] {
            let scaled: Vec<f32> = b.iter().map(|v| v * amplitude).collect();
            let y = solve([40, 31], mix, kappa, &scaled);
            let size = x.iter().fold(0f32, |m, v| v.abs().max(m));
            assert!(x.iter().zip(&y).all(|(x, y)| (x - y / amplitude).abs() <= 3e-6 * size), "{mix:?} {amplitude}");
        }
    }
}

#[test]
fn zero_gives_zero() {
    for mix in [[CLOSED; 2], [HELD; 2]] {
        for plan in [None, Some(Plan::Chebyshev), Some(Plan::Multigrid)] {
            for alpha in [0.0, 1.0] {
                let case = Case::new([12, 9], mix, alpha, 3.0);
                let options = Options { plan, ..Default::default() };
                let mut solver = Solver::<f32, 2>::new(&case.helmholtz(), options).unwrap();
                let (b, mut x) = (vec![0.0; case.layout.slots()], vec![f32::NAN; case.layout.slots()]);
                for stop in [Stop::Relative(1e-6), Stop::Relative(0.0), Stop::Largest(0.0)] {
                    let s = solver.solve(&b, &mut x, stop).unwrap();
                    assert!(s.iterations == 0 && s.residual == 0.0 && !s.at_floor && x.iter().all(|&v| v == 0.0));
                }
            }
        }
    }
}

/// The smallest and largest numbers there are, in f64.
#[test]
fn extreme_amplitudes_in_double() {
    for (plan, mix) in [(Plan::Multigrid, CLOSED), (Plan::Chebyshev, CLOSED), (Plan::Chebyshev, HELD)] {
        let case = Case::new([20, 20], [mix; 2], 1.0, 1.0);
        let options = Options { plan: Some(plan), ..Default::default() };
        let mut solver = Solver::<f64, 2>::new(&case.helmholtz(), options).unwrap();
        for amplitude in [f64::from_bits(1), 1e-323, 1e-320, 1e-310, 1e-300, 1e300, f64::MAX] {
            let mut b = random_field::<f64, 2>(&case.layout, 4);
            b.iter_mut().for_each(|v| *v *= amplitude);
            let relative = [1e-6, 1e-12].map(Stop::Relative);
            let absolute = [1e-6, 1e-12].map(|t| Stop::Largest(t * amplitude));
            for stop in [relative, absolute].concat() {
                let mut x = vec![0.0; case.layout.slots()];
                let done = solver.solve(&b, &mut x, stop);
                done.unwrap_or_else(|e| panic!("{plan:?} {mix:?} {amplitude:e} to {stop:?}: {e}"));
                assert!(case.layout.max_abs(&x) <= amplitude);
            }
        }
    }
}

/// kappa and walls so small that nothing of them can be added up in single precision.
#[test]
fn tiny_coefficients_are_a_matter_of_units() {
    for kappa in [1e-300, 1e-40, 1e200] {
        let (small, unit) =
            (Case::new([20, 17], [HELD, CLOSED], 0.0, kappa), Case::new([20, 17], [HELD, CLOSED], 0.0, 1.0));
        let b = random_field::<f32, 2>(&small.layout, 4);
        let parts = [small, unit].map(|case| {
            let mut y = vec![0.0; b.len()];
            let mut solver = Solver::<f32, 2>::new(&case.helmholtz(), options()).unwrap();
            let mut parts = Deviation::default();
            solver.solve_deviation(&&b[..], &mut y, Stop::Relative(1e-5), &mut parts).unwrap();
            (y, parts.factor * case.kappa)
        });
        assert!((parts[0].1 / parts[1].1 - 1.0).abs() < 1e-12);
        assert!(parts[0].0.iter().zip(&parts[1].0).all(|(a, b)| (a - b).abs() <= 1e-4), "{kappa:e}");
    }
}
