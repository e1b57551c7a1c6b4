//! Chebyshev: the count is the closed form.

use cf_linear::{Options, Plan, Solver, Stop, chebyshev_count};

use crate::common::*;

fn count<const D: usize>(case: &Case<D>, stop: Stop) -> usize {
    let options = Options { plan: Some(Plan::Chebyshev), ..Default::default() };
    let mut solver = Solver::<f64, D>::new(&case.helmholtz(), options).unwrap();
    let (b, mut x) = (random_field::<f64, D>(&case.layout, 7), vec![0.0; case.layout.slots()]);
    let s = solver.solve(&b, &mut x, stop).unwrap_or_else(|e| panic!("{:?} {}: {e}", case.walls, case.kappa));
    assert!(!s.at_floor);
    s.iterations
}

#[test]
fn counts_are_the_closed_form_and_the_table() {
    // kappa, measured in two and three dimensions.
    for (kappa, plane, space) in
        [(0.01, 4, 5), (0.1, 8, 9), (0.3, 12, 15), (1.0, 21, 25), (3.0, 35, 43), (10.0, 65, 78)]
    {
        for mix in [[CLOSED; 2], [HELD, CLOSED], [None; 2]] {
            let case = Case::new([128, 128], mix, 1.0, kappa);
            let n = count(&case, Stop::Relative(1e-6));
            let formula = chebyshev_count(2, 1.0, kappa, 1e-6);
            // Held walls have larger diagonals, so that the bound of the spectrum is a little wider.
            let extra = if mix[0] == HELD { formula / 5 + 1 } else { 0 };
            assert!((formula..=formula + extra).contains(&n), "{mix:?} {kappa}: {n} against {formula}");
            assert!(n.abs_diff(plane) <= 1 + plane / 20 + extra, "{mix:?} {kappa}: {n} against {plane}");
        }
        let n = count(&Case::new([32; 3], [CLOSED; 3], 1.0, kappa), Stop::Relative(1e-6));
        assert_eq!(n, chebyshev_count(3, 1.0, kappa, 1e-6));
        assert!(n.abs_diff(space) <= 1 + space / 20, "{kappa}: {n} against {space}");
    }
}

#[test]
fn it_converges_for_masks_shares_and_all_walls() {
    for kappa in [1e-8, 1e-3, 0.1, 1.0, 10.0] {
        for mix in mixes_2d() {
            let case = Case::new([40, 33], mix, 1.0, kappa);
            let formula = chebyshev_count(2, 1.0, 2.0 * kappa.max(0.5 * kappa.sqrt()), 1e-8);
            for stop in [Stop::Relative(1e-8), Stop::Largest(1e-8)] {
                for case in [case.clone(), case.clone().masked(random_solids(15.0, 2)), case.clone().shared(5, true)] {
                    let n = count(&case, stop);
                    assert!(n <= 2 * formula + 2, "{mix:?} {kappa:e}: {n} against {formula}");
                }
            }
        }
    }
}

#[test]
fn the_count_is_finite_or_saturates() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
        assert!(chebyshev_count(3, 1.0, bad, 1e-6) >= 1);
        assert!(chebyshev_count(3, bad, 1.0, 1e-6) >= 1);
        assert!(chebyshev_count(3, 1.0, 1.0, bad) >= 1);
    }
    assert_eq!(chebyshev_count(2, 0.0, 1.0, 1e-6), usize::MAX);
}
