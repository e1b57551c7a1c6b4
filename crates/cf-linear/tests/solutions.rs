//! Solutions against dense solves by faer; Poisson problems; plans.

use cf_grid::Layout;
use cf_linear::{Deviation, Helmholtz, Options, Plan, Precision, Solver, Stop};
use faer::{Mat, linalg::solvers::Solve};

use crate::common::*;

const PLANS: [Option<Plan>; 3] = [None, Some(Plan::Chebyshev), Some(Plan::Multigrid)];

fn solve<const D: usize>(case: &Case<D>, b: &[f64], plan: Option<Plan>, precision: Precision, what: &str) -> Vec<f64> {
    let options = Options { plan, precision, limit: 300, ..Default::default() };
    let mut solver = Solver::<f64, D>::new(&case.helmholtz(), options).unwrap();
    let mut x = vec![f64::NAN; case.layout.slots()];
    if let Err(e) = solver.solve(b, &mut x, Stop::Relative(1e-14)) {
        panic!("{what} {plan:?} {precision:?}: {e}");
    }
    x
}

/// Dense solve with two steps of refinement.
fn exact<const D: usize>(case: &Case<D>, b: &[f64]) -> Mat<f64> {
    let (a, b) = (case.dense(), case.gather(b));
    let lu = a.partial_piv_lu();
    let mut x = lu.solve(&b);
    for _ in 0..2 {
        x = &x + lu.solve(&b - &a * &x);
    }
    x
}

/// Every plan and precision against the dense solve.
fn check<const D: usize>(case: &Case<D>, tolerance: f64, what: &str) {
    let mut b = random_field::<f64, D>(&case.layout, 11);
    // A right-hand side in solid cells is nobody's business.
    case.layout.each_cell(case.layout.cells_region(), |at| {
        if !case.is_fluid(at.cell) {
            b[at.slot()] = f64::NAN;
        }
    });
    let expected = exact(case, &b);
    let size = largest(&expected);
    for plan in PLANS {
        if plan == Some(Plan::Chebyshev) && case.kappa > 10.0 * case.alpha {
            continue;
        }
        for precision in [Precision::Full, Precision::Single] {
            let x = solve(case, &b, plan, precision, what);
            let error = largest(&(case.gather(&x) - &expected));
            assert!(error <= tolerance * size, "{what} {plan:?} {precision:?}: {:e}", error / size);
            case.layout.each_cell(case.layout.cells_region(), |at| {
                assert!(case.is_fluid(at.cell) || x[at.slot()] == 0.0, "{what}: solid cell touched");
            });
        }
    }
}

/// What the dense solve itself is worth: eps times the condition number.
fn tolerance(kappa: f64) -> f64 {
    1e-12 * (kappa / 1e3).max(1.0)
}

#[test]
fn boxes_equal_dense_solves() {
    for kappa in [1e-6, 1e-2, 1.0, 30.0, 1e3, 1e6] {
        for mix in mixes_2d() {
            check(&Case::new([7, 7], mix, 1.0, kappa), tolerance(kappa), &format!("{mix:?} {kappa:e}"));
        }
    }
    for kappa in [1e-2, 1e3] {
        for mix in mixes_3d() {
            check(&Case::new([7, 7, 7], mix, 1.0, kappa), tolerance(kappa), &format!("{mix:?} {kappa:e}"));
        }
    }
    for cells in [[1, 1], [1, 9], [2, 2], [13, 18]] {
        for mix in mixes_2d() {
            check(&Case::new(cells, mix, 0.7, 20.0), 1e-12, &format!("{cells:?} {mix:?}"));
        }
    }
}

#[test]
fn masks_and_shares_equal_dense_solves() {
    for kappa in [1e-6, 0.3, 1e3] {
        for mix in mixes_2d() {
            let case = Case::new([13, 11], mix, 1.0, kappa);
            let t = tolerance(kappa);
            check(&case.clone().masked(random_solids(15.0, 5)), t, &format!("random {mix:?} {kappa:e}"));
            check(&case.clone().masked(|c| c[0] != 6), t, &format!("wall {mix:?} {kappa:e}"));
            check(&case.clone().masked(pockets), t, &format!("pocket {mix:?} {kappa:e}"));
            check(&case.clone().masked(|c| c == [3, 3]), t, &format!("one cell {mix:?} {kappa:e}"));
            check(&case.masked(random_solids(20.0, 7)).shared(8, true), t, &format!("shares {mix:?} {kappa:e}"));
        }
    }
    for mix in mixes_3d() {
        let case = Case::new([7, 7, 7], mix, 1.0, 1e3);
        check(&case.clone().masked(random_solids(15.0, 5)), 1e-12, &format!("random {mix:?}"));
        check(&case.masked(pockets), 1e-12, &format!("pocket {mix:?}"));
    }
}

#[test]
fn an_all_solid_box_is_left_alone() {
    let case = Case::new([6, 5], [None, HELD], 1.0, 9.0).masked(|_| false);
    let b = random_field::<f64, 2>(&case.layout, 1);
    for plan in PLANS {
        assert!(solve(&case, &b, plan, Precision::Full, "solid").iter().all(|&v| v == 0.0));
    }
}

/// Poisson: A x = b up to the mean of b per component, and x has no mean there.
fn check_poisson<const D: usize>(case: &Case<D>, what: &str) {
    let b = random_field::<f64, D>(&case.layout, 21);
    for precision in [Precision::Full, Precision::Single] {
        let mut solver = Solver::<f64, D>::new(&case.helmholtz(), Options { precision, ..Default::default() }).unwrap();
        let mut y = vec![0.0; case.layout.slots()];
        let mut parts = Deviation::default();
        let done = solver.solve_deviation(&&b[..], &mut y, Stop::Relative(1e-11), &mut parts);
        done.unwrap_or_else(|e| panic!("{what}: {e}"));
        solver.finish(&mut y, &parts);
        let residual = case.gather(&b) - case.dense() * case.gather(&y);
        // The residual is constant on each component, where no wall conducts, and those constants are reported.
        let removed = case.scatter(&residual);
        let values: Vec<f64> = case.cells().iter().map(|&c| removed[case.layout.slot(c)]).collect();
        for v in values {
            let nearest = parts.removed.iter().chain([&0.0]).map(|r| (r - v).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 1e-9, "{what} {precision:?}: residual {v} among {:?}", parts.removed);
        }
        if !parts.removed.is_empty() {
            let floating: f64 = case.gather(&y).col(0).iter().sum();
            let held = case.walls.walls().any(|(_, _, w)| w > 0.0);
            let size = largest(&case.gather(&y));
            assert!(held || floating.abs() <= 1e-12 * size * y.len() as f64, "{what}: mean {floating}");
        }
    }
}

#[test]
fn poisson_problems_lose_the_mean_of_each_component() {
    for mix in mixes_2d() {
        let case = Case::new([21, 18], mix, 0.0, 1.0);
        check_poisson(&case, &format!("box {mix:?}"));
        check_poisson(&case.clone().masked(pockets), &format!("pocket {mix:?}"));
        check_poisson(&case.clone().masked(|c| c[0] % 7 != 5), &format!("strips {mix:?}"));
        check_poisson(&case.clone().masked(random_solids(30.0, 3)), &format!("random {mix:?}"));
        check_poisson(&case.clone().masked(|c| (c[0] + c[1]) % 2 == 0), &format!("chequers {mix:?}"));
        check_poisson(&case.shared(3, true), &format!("shares {mix:?}"));
    }
    for mix in mixes_3d() {
        let case = Case::new([8, 7, 9], mix, 0.0, 1e-8);
        check_poisson(&case, &format!("box {mix:?}"));
        check_poisson(&case.masked(pockets), &format!("pocket {mix:?}"));
    }
    check_poisson(&Case::new([1, 1], [CLOSED; 2], 0.0, 1.0), "one cell");
}

#[test]
fn kappa_zero_is_a_division_whatever_is_asked() {
    let layout = Layout::new([9, 5]).unwrap();
    let b = random_field::<f64, 2>(&layout, 4);
    for plan in [Plan::Diagonal, Plan::Chebyshev, Plan::Multigrid] {
        let operator = Helmholtz::new(&layout, 1.0, 0.0, sides([CLOSED; 2], 0.0));
        let mut solver = Solver::<f64, 2>::new(&operator, Options { plan: Some(plan), ..Default::default() }).unwrap();
        assert_eq!(solver.choice().plan, Plan::Diagonal);
        let mut x = vec![0.0; layout.slots()];
        solver.solve(&b, &mut x, Stop::Relative(0.0)).unwrap();
        assert_eq!(x, b);
    }
    // A division is no answer elsewhere, and says so.
    let operator = Helmholtz::new(&layout, 1.0, 2.0, sides([CLOSED; 2], 0.0));
    let options = Options { plan: Some(Plan::Diagonal), ..Default::default() };
    let mut solver = Solver::<f64, 2>::new(&operator, options).unwrap();
    assert!(solver.solve(&b, &mut vec![0.0; layout.slots()], Stop::Relative(1e-6)).is_err());
}

#[test]
fn what_the_solution_held_before_does_not_matter() {
    for (alpha, kappa) in [(0.0, 1.0), (1.0, 1e-3), (1.0, 1e4), (1.0, 0.0)] {
        for scale in [0.0, 1.0] {
            let case = Case::new([20, 12, 7], [CLOSED, None, CLOSED], alpha, kappa);
            let mut solver = Solver::<f64, 3>::new(&case.helmholtz(), Options::default()).unwrap();
            let mut b = random_field::<f64, 3>(&case.layout, 5);
            b.iter_mut().for_each(|v| *v *= scale);
            let (mut clean, mut dirty) = (vec![0.0; b.len()], vec![f64::NAN; b.len()]);
            solver.solve(&b, &mut clean, Stop::Relative(1e-8)).unwrap();
            solver.solve(&b, &mut dirty, Stop::Relative(1e-8)).unwrap();
            assert_eq!(clean, dirty, "{alpha} {kappa:e} {scale}");
        }
    }
}
