//! `Solver::apply` against the operator assembled face by face.

use cf_grid::Real;
use cf_linear::{Options, Plan, Solver};
use faer::Side;
use proptest::prelude::*;

use crate::common::*;

/// Compares in f64 and f32, and checks symmetry, row sums and definiteness of the assembled operator.
fn check<const D: usize>(case: &Case<D>, what: &str) {
    let dense = case.dense();
    let scale = case.helmholtz().scale();
    compare::<f64, D>(case, &dense, 1e-15 * scale, what);
    compare::<f32, D>(case, &dense, 1e-6 * scale, what);
    let n = dense.nrows();
    for i in 0..n {
        let row: f64 = (0..n).map(|j| dense[(i, j)]).sum();
        assert!(row >= case.alpha - 1e-13 * scale, "{what}: row sum {row}");
        assert!((0..n).all(|j| dense[(i, j)] == dense[(j, i)]), "{what}: not symmetric");
        assert!(dense[(i, i)] <= scale * (1.0 + 1e-14), "{what}: diagonal {} above the scale {scale}", dense[(i, i)]);
    }
    assert!(n == 0 || dense.llt(Side::Lower).is_ok(), "{what}: not positive definite");
}

fn compare<T: Real, const D: usize>(case: &Case<D>, dense: &faer::Mat<f64>, tolerance: f64, what: &str) {
    for plan in [Plan::Chebyshev, Plan::Multigrid] {
        let solver =
            Solver::<T, D>::new(&case.helmholtz(), Options { plan: Some(plan), ..Default::default() }).unwrap();
        let mut x = random_field::<T, D>(&case.layout, 3);
        // A closed wall and a solid cell must not look at what lies behind.
        case.layout.each_cell(case.layout.cells_region(), |at| {
            if !case.is_fluid(at.cell) {
                x[at.slot()] = T::of(1e3);
            }
        });
        let mut y = vec![T::ZERO; case.layout.slots()];
        let expected = dense * case.gather(&x);
        solver.apply(&mut x, &mut y);
        let error = largest(&(case.gather(&y) - expected));
        assert!(error <= 4.0 * tolerance, "{what} {}: error {error:e} above {tolerance:e}", T::NAME);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]
    #[test]
    fn random_masks_are_symmetric_and_positive_definite(
        cells in [1usize..14, 1..14], mix in prop::array::uniform2(prop::sample::select(MIXES.to_vec())),
        exponent in -6.0..6f64, solid in 0.0..60f64, seed in 1u64..1000,
    ) {
        let case = Case::new(cells, mix, 1.0, 10f64.powf(exponent)).masked(random_solids(solid, seed));
        check(&case, "random");
    }
}

#[test]
fn all_walls_and_sizes_in_two_dimensions() {
    for cells in [[1, 1], [1, 7], [6, 1], [2, 2], [2, 5], [3, 3], [7, 6], [9, 4]] {
        for mix in mixes_2d() {
            for kappa in [1e-3, 1.0, 1e4] {
                check(&Case::new(cells, mix, 1.0, kappa), &format!("{cells:?} {mix:?} {kappa}"));
            }
        }
    }
    // More cells than one chunk of a row, and several pieces of a parallel loop.
    let case = Case::new([150, 3], [None, HELD], 0.5, 2.0);
    check(&case, "150x3");
}

#[test]
fn all_walls_and_sizes_in_three_dimensions() {
    for cells in [[1, 1, 1], [1, 1, 5], [1, 4, 3], [2, 2, 2], [5, 4, 3], [3, 3, 3], [4, 1, 5]] {
        for mix in mixes_3d() {
            check(&Case::new(cells, mix, 1.0, 3.0), &format!("{cells:?} {mix:?}"));
        }
    }
}

#[test]
fn masks_close_the_faces_of_solid_cells() {
    for mix in mixes_2d() {
        let case = Case::new([9, 8], mix, 1.0, 5.0);
        check(&case.clone().masked(random_solids(15.0, 5)), &format!("random {mix:?}"));
        check(&case.clone().masked(|c| c[0] != 4), &format!("wall {mix:?}"));
        check(&case.clone().masked(pockets), &format!("pocket {mix:?}"));
        check(&case.clone().masked(|_| false), &format!("solid {mix:?}"));
        check(&case.clone().masked(|c| c == [8, 0]), &format!("one cell {mix:?}"));
        check(&case.masked(random_solids(15.0, 6)).shared(2, true), &format!("mask and shares {mix:?}"));
    }
    for mix in mixes_3d() {
        let case = Case::new([5, 6, 4], mix, 0.3, 2.0);
        check(&case.clone().masked(random_solids(15.0, 5)), &format!("random {mix:?}"));
        check(&case.clone().masked(|c| c[2] != 2), &format!("plate {mix:?}"));
        check(&case.masked(pockets).shared(9, true), &format!("pocket {mix:?}"));
    }
}

#[test]
fn shares_multiply_every_face() {
    for mix in mixes_2d() {
        for closing in [false, true] {
            check(&Case::new([7, 5], mix, 1.0, 10.0).shared(1, closing), &format!("{mix:?}"));
            check(&Case::new([1, 5], mix, 1.0, 10.0).shared(1, closing), &format!("{mix:?}"));
        }
    }
    for mix in mixes_3d() {
        check(&Case::new([4, 3, 5], mix, 1.0, 10.0).shared(4, true), &format!("{mix:?}"));
    }
}
