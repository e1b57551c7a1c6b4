//! Solutions have the same bits for any number of threads.

use cf_grid::Real;
use cf_linear::{Options, Plan, Precision, Solver, Stop};

use crate::common::*;

fn solutions<T: Real, const D: usize>(case: &Case<D>, plan: Plan, precision: Precision) {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let options = Options { plan: Some(plan), precision, ..Default::default() };
            let mut solver = Solver::<T, D>::new(&case.helmholtz(), options).unwrap();
            let (b, mut x) = (random_field::<T, D>(&case.layout, 7), vec![T::ZERO; case.layout.slots()]);
            let statistics = solver.solve(&b, &mut x, Stop::Relative(1e-6)).unwrap();
            (x, statistics)
        })
    };
    let one = run(1);
    for threads in [2, 3] {
        let other = run(threads);
        assert_eq!(one.1, other.1, "{plan:?} {precision:?}, {threads} threads");
        assert!(one.0 == other.0, "{plan:?} {precision:?}, {threads} threads");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let plane = Case::new([300, 300], [CLOSED, None], 1.0, 50.0);
    solutions::<f64, 2>(&plane, Plan::Multigrid, Precision::Full);
    solutions::<f64, 2>(&plane, Plan::Multigrid, Precision::Single);
    solutions::<f32, 2>(&plane, Plan::Multigrid, Precision::Full);
    solutions::<f64, 2>(&Case { kappa: 1.0, ..plane.clone() }, Plan::Chebyshev, Precision::Full);
    solutions::<f64, 2>(&plane.masked(random_solids(15.0, 1)), Plan::Multigrid, Precision::Full);
    let space = Case::new([60; 3], [HELD, CLOSED, None], 1.0, 50.0);
    solutions::<f64, 3>(&space, Plan::Multigrid, Precision::Full);
    solutions::<f32, 3>(&space, Plan::Multigrid, Precision::Full);
    solutions::<f64, 3>(&space.masked(random_solids(15.0, 1)), Plan::Multigrid, Precision::Full);
    solutions::<f64, 3>(&Case::new([45, 60, 61], [None; 3], 1.0, 5e3), Plan::Multigrid, Precision::Full);
}
