//! What a first guess saves at most: the exact solution on a grid of half as many cells along every axis, which is more
//! than full multigrid has to offer, and the solution of a time step before.

use cf_linear::{Options, Plan, Solver, Stop};

use crate::common::*;

const N: usize = 64;

type Space = Case<3>;

/// A smooth right-hand side without a mean: a wave and a bump that moves with time.
fn smooth(case: &Space, time: f64) -> Vec<f64> {
    let mut b = vec![0.0; case.layout.slots()];
    let wave = |i: usize| (std::f64::consts::TAU * (i as f64 + 0.5) / N as f64).cos();
    case.layout.par_cells(&mut b, |at| {
        let distance: f64 = at.cell.iter().map(|&i| (i as f64 - 30.0 - time).powi(2)).sum();
        at.cell.iter().map(|&i| wave(i)).product::<f64>() + (-distance / 60.0).exp()
    });
    let mean = case.layout.sum(&b) / case.layout.count() as f64;
    case.layout.each_cell(case.layout.cells_region(), |at| b[at.slot()] -= mean);
    b
}

/// Noise, later with a tenth of other noise.
fn rough(case: &Space, time: f64) -> Vec<f64> {
    let (mut b, more) = (random_field::<f64, 3>(&case.layout, 7), random_field::<f64, 3>(&case.layout, 8));
    b.iter_mut().zip(&more).for_each(|(b, v)| *b += 0.1 * time * v);
    b
}

/// P y of the solution y on half as many cells.
fn coarse_guess(fine: &Space, b: &[f64]) -> Vec<f64> {
    let coarse = Case::new([N / 2; 3], [CLOSED; 3], 8.0 * fine.alpha, 2.0 * fine.kappa);
    let mut sums = vec![0.0; coarse.layout.slots()];
    fine.layout.each_cell(fine.layout.cells_region(), |at| {
        sums[coarse.layout.slot(at.cell.map(|i| i / 2))] += b[at.slot()];
    });
    let (mut y, mut guess) = (vec![0.0; sums.len()], vec![0.0; b.len()]);
    solver(&coarse).solve(&sums, &mut y, Stop::Relative(1e-10)).unwrap();
    fine.layout.par_cells(&mut guess, |at| {
        let corner = |bits: usize| {
            let pick = |a: usize| {
                let (i, parent) = (at.cell[a], at.cell[a] / 2);
                let beside = if i % 2 == 1 { (parent + 1).min(N / 2 - 1) } else { parent.saturating_sub(1) };
                if bits >> a & 1 == 0 { (parent, 0.75) } else { (beside, 0.25) }
            };
            let picked: [_; 3] = std::array::from_fn(pick);
            picked.iter().map(|p| p.1).product::<f64>() * y[coarse.layout.slot(picked.map(|p| p.0))]
        };
        (0..8).map(corner).sum()
    });
    guess
}

fn solver(case: &Space) -> Solver<f64, 3> {
    Solver::new(&case.helmholtz(), Options { plan: Some(Plan::Multigrid), ..Default::default() }).unwrap()
}

/// Iterations from a guess to 1e-6 of b.
fn iterations_from(case: &Space, mut guess: Vec<f64>, b: &[f64]) -> usize {
    let mut solver = solver(case);
    let mut r = vec![0.0; b.len()];
    solver.apply(&mut guess, &mut r);
    r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
    let norm = |v: &[f64]| case.layout.dot(v, v).sqrt();
    let mut dx = vec![0.0; b.len()];
    solver.solve(&r, &mut dx, Stop::Relative(1e-6 * norm(b) / norm(&r))).unwrap().iterations
}

#[test]
fn guesses_save_two_iterations_at_most_and_none_for_noise() {
    for (alpha, kappa) in [(1.0, 15.0), (1.0, 1e4), (0.0, 1.0)] {
        let case = Case::new([N; 3], [CLOSED; 3], alpha, kappa);
        for (name, of, allowed) in [("smooth", smooth as fn(&Space, f64) -> Vec<f64>, 2), ("noise", rough, 1)] {
            let (b, next) = (of(&case, 0.0), of(&case, 1.0));
            let mut x = vec![0.0; b.len()];
            let cold = solver(&case).solve(&b, &mut x, Stop::Relative(1e-6)).unwrap().iterations;
            let coarse = iterations_from(&case, coarse_guess(&case, &b), &b);
            let warm = iterations_from(&case, x, &next);
            println!("{name} alpha {alpha} kappa {kappa}: zero {cold}, coarse solution {coarse}, step before {warm}");
            assert!(cold - coarse <= allowed && cold - warm <= 2, "{cold} {coarse} {warm}");
        }
    }
}
