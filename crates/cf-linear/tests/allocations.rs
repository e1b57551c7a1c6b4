//! A solve allocates nothing, pockets of obstacles or not.

use allocation_counter::measure;
use cf_grid::Real;
use cf_linear::{Options, Plan, Precision, Solver, Stop};

use crate::common::*;

/// Allocations of the second of two solves; of the thread that makes them, so that there is one.
fn allocations<T: Real, const D: usize>(case: &Case<D>, plan: Plan, precision: Precision) -> (usize, u64) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let options = Options { plan: Some(plan), precision, ..Default::default() };
        let mut solver = Solver::<T, D>::new(&case.helmholtz(), options).unwrap();
        let (b, mut x) = (random_field::<T, D>(&case.layout, 7), vec![T::ZERO; case.layout.slots()]);
        let mut iterations = 0;
        let mut solve = || iterations = solver.solve(&b, &mut x, Stop::Relative(1e-5)).unwrap().iterations;
        solve();
        let found = measure(solve).count_total;
        (iterations, found)
    })
}

#[test]
fn a_solve_allocates_nothing() {
    let plane = Case::new([90, 77], [CLOSED; 2], 0.0, 1.0);
    // Random solids leave hundreds of enclosed pockets, each with a constant of its own.
    let pockets = plane.clone().masked(random_solids(45.0, 1));
    let space = Case::new([30, 31, 20], [HELD, CLOSED, None], 1.0, 50.0);
    let strong = Plan::Multigrid;
    for (iterations, allocations) in [
        allocations::<f64, 2>(&plane, strong, Precision::Full),
        allocations::<f64, 2>(&plane, strong, Precision::Single),
        allocations::<f32, 2>(&plane, strong, Precision::Full),
        allocations::<f64, 2>(&pockets, strong, Precision::Full),
        allocations::<f64, 2>(&pockets, strong, Precision::Single),
        allocations::<f64, 3>(&space, strong, Precision::Full),
        allocations::<f32, 3>(&space.clone().masked(random_solids(15.0, 1)), strong, Precision::Full),
        allocations::<f64, 3>(&Case { kappa: 1.0, ..space }, Plan::Chebyshev, Precision::Full),
    ] {
        assert!(iterations > 3 && allocations == 0, "{allocations} allocations in {iterations} iterations");
    }
}
