//! One V-cycle is a symmetric positive definite operator, also over masks and odd periodic axes.

use cf_linear::{Options, Plan, Precision, Solver, Stop};
use proptest::prelude::*;

use crate::common::*;

fn check<const D: usize>(case: &Case<D>, what: &str) {
    let layout = case.layout;
    let options = Options { plan: Some(Plan::Multigrid), ..Default::default() };
    let mut solver = Solver::<f64, D>::new(&case.helmholtz(), options).unwrap();
    // Residuals as PCG has them: nothing in solid cells, and no constants where they are removed.
    let poisson = Case { alpha: 0.0, ..case.clone() };
    let projector = Solver::<f64, D>::new(&poisson.helmholtz(), options).unwrap();
    let conserves = case.walls.walls().all(|(_, _, w)| w == 0.0);
    let vector = |seed| {
        let mut x = random_field::<f64, D>(&layout, seed);
        layout.each_cell(layout.cells_region(), |at| {
            if !case.is_fluid(at.cell) {
                x[at.slot()] = 0.0;
            }
        });
        if conserves {
            // The image of a conserving operator has no constants.
            let mut y = vec![0.0; layout.slots()];
            projector.apply(&mut x, &mut y);
            x = y;
        }
        x
    };
    for seed in [1, 2, 3] {
        let (x, y) = (vector(seed), vector(seed + 10));
        let (mut mx, mut my) = (vec![f64::NAN; layout.slots()], vec![f64::NAN; layout.slots()]);
        solver.precondition(&x, &mut mx);
        solver.precondition(&y, &mut my);
        let (xx, yy) = (layout.dot(&x, &mx), layout.dot(&y, &my));
        if layout.dot(&x, &x) == 0.0 {
            assert_eq!(xx, 0.0);
            continue;
        }
        assert!(xx > 0.0 && yy > 0.0, "{what}: not positive definite: {xx} {yy}");
        let (left, right) = (layout.dot(&x, &my), layout.dot(&y, &mx));
        assert!((left - right).abs() <= 1e-12 * (xx * yy).sqrt(), "{what}: {left} against {right}");
        // Solid cells stay out of it.
        layout.each_cell(layout.cells_region(), |at| {
            assert!(case.is_fluid(at.cell) || mx[at.slot()] == 0.0, "{what}: solid cell changed");
        });
    }
}

const KAPPAS: [f64; 4] = [0.2, 3.0, 1e3, 1e8];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn random_masks_are_symmetric(
        cells in [1usize..40, 1..40], mix in prop::array::uniform2(prop::sample::select(MIXES.to_vec())),
        exponent in -2.0..8f64, solid in 0.0..50f64, seed in 1u64..1000,
    ) {
        let case = Case::new(cells, mix, 1.0, 10f64.powf(exponent)).masked(random_solids(solid, seed));
        check(&case, "random");
    }

    #[test]
    fn random_masks_are_symmetric_in_three_dimensions(
        cells in [1usize..14, 1..14, 1..14], mix in prop::array::uniform3(prop::sample::select(MIXES.to_vec())),
        exponent in -2.0..8f64, solid in 0.0..50f64, seed in 1u64..1000,
    ) {
        let case = Case::new(cells, mix, 1.0, 10f64.powf(exponent)).masked(random_solids(solid, seed));
        check(&case, "random");
    }
}

#[test]
fn boxes_are_symmetric() {
    for kappa in KAPPAS {
        for mix in mixes_2d() {
            for cells in [[3, 3], [16, 16], [17, 13], [31, 9], [1, 200], [2, 97]] {
                check(&Case::new(cells, mix, 1.0, kappa), &format!("{cells:?} {mix:?} {kappa:e}"));
            }
        }
        for mix in mixes_3d() {
            for cells in [[3, 3, 3], [8, 8, 8], [9, 7, 5], [3, 16, 11]] {
                check(&Case::new(cells, mix, 1.0, kappa), &format!("{cells:?} {mix:?} {kappa:e}"));
            }
        }
    }
}

#[test]
fn masks_and_shares_are_symmetric() {
    for kappa in KAPPAS {
        for mix in mixes_2d() {
            for cells in [[16, 24], [27, 15]] {
                let case = Case::new(cells, mix, 1.0, kappa);
                check(&case.clone().masked(random_solids(15.0, 4)), &format!("random {cells:?} {mix:?} {kappa:e}"));
                check(&case.clone().masked(random_solids(45.0, 4)), &format!("dense {cells:?} {mix:?} {kappa:e}"));
                check(&case.clone().masked(|c| c[0] != 7), &format!("wall {cells:?} {mix:?} {kappa:e}"));
                check(&case.clone().masked(pockets), &format!("pocket {cells:?} {mix:?} {kappa:e}"));
                check(&case.clone().masked(|_| false), &format!("solid {cells:?} {mix:?} {kappa:e}"));
                check(&case.shared(3, true), &format!("shares {cells:?} {mix:?} {kappa:e}"));
            }
        }
        for mix in mixes_3d() {
            let case = Case::new([9, 8, 7], mix, 1.0, kappa);
            check(&case.clone().masked(random_solids(15.0, 4)), &format!("random {mix:?} {kappa:e}"));
            check(&case.clone().masked(random_solids(45.0, 4)), &format!("dense {mix:?} {kappa:e}"));
            check(&case.masked(pockets), &format!("pocket {mix:?} {kappa:e}"));
        }
    }
}

/// Where no wall conducts, corrections have no constant part once its mean is removed, and M does not blow up on what
/// rounding leaves of the constant in a residual.
#[test]
fn constants_stay_out() {
    for precision in [Precision::Full, Precision::Single] {
        for (alpha, kappa) in [(0.0, 1.0), (1.0, 1e12)] {
            let case = Case::new([33, 20], [CLOSED, None], alpha, kappa).masked(pockets);
            let options = Options { plan: Some(Plan::Multigrid), precision, ..Default::default() };
            let mut solver = Solver::<f64, 2>::new(&case.helmholtz(), options).unwrap();
            let fluid = |x: &mut Vec<f64>, value: f64| {
                case.layout.par_cells(x, |at| if case.is_fluid(at.cell) { value } else { 0.0 });
            };
            let (mut one, mut z) = (vec![0.0; case.layout.slots()], vec![0.0; case.layout.slots()]);
            fluid(&mut one, 1.0);
            solver.precondition(&one, &mut z);
            assert!(case.layout.max_abs(&z) < 1e6, "{alpha} {kappa:e}: {:e}", case.layout.max_abs(&z));
        }
    }
}

#[test]
fn what_is_not_finite_leaves_nothing_behind() {
    for cells in [[70, 16, 11], [134, 8, 17]] {
        let case = Case::new(cells, [CLOSED, None, CLOSED], 0.0, 1.0);
        let options = Options { plan: Some(Plan::Multigrid), ..Default::default() };
        let mut solver = Solver::<f32, 3>::new(&case.helmholtz(), options).unwrap();
        let b = random_field::<f32, 3>(&case.layout, 3);
        let mut solve = |bad: bool| {
            let mut x = vec![0.0; b.len()];
            if bad {
                let mut bad = b.clone();
                case.layout.par_cells(&mut bad, |_| f32::NAN);
                solver.precondition(&bad, &mut x);
                assert!(case.layout.sum(&x).is_nan());
            }
            x.fill(0.0);
            solver.solve(&b, &mut x, Stop::Relative(1e-5)).map(|done| (done.iterations, x)).unwrap()
        };
        assert_eq!(solve(false), solve(true));
    }
}
