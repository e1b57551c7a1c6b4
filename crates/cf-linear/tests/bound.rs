//! For alpha = 1 the error is at most the residual that is reported; what cannot be solved is refused with a reason.

use cf_grid::{Axis, FaceField, Layout, Mask, Sides};
use cf_linear::{Helmholtz, Options, Plan, Precision, SolveError, Solver, Stop};
use proptest::prelude::*;

use crate::common::*;

/// b = A x for a known x of unit size, then max|x - solution| <= max|r| and the same in the 2-norm.
fn check<const D: usize>(case: &Case<D>, stop: Stop, plan: Option<Plan>, precision: Precision) {
    let options = Options { plan, precision, ..Default::default() };
    let mut solver = Solver::<f64, D>::new(&case.helmholtz(), options).unwrap();
    let layout = case.layout;
    let mut known = random_field::<f64, D>(&layout, 5);
    layout.each_cell(layout.cells_region(), |at| {
        if !case.is_fluid(at.cell) {
            known[at.slot()] = 0.0;
        }
    });
    let (mut b, mut x) = (vec![0.0; layout.slots()], vec![0.0; layout.slots()]);
    solver.apply(&mut known, &mut b);
    let s = solver.solve(&b, &mut x, stop).unwrap_or_else(|e| panic!("{:?} {stop:?}: {e}", case.walls));
    let (mut largest, mut square) = (0f64, 0.0);
    layout.each_cell(layout.cells_region(), |at| {
        let error = x[at.slot()] - known[at.slot()];
        largest = largest.max(error.abs());
        square += error * error;
    });
    // Making b and adding the constants rounds.
    let rounding = solver.floor(1.0);
    assert!(largest <= s.largest + rounding, "error {largest:e}, residual {:e}", s.largest);
    let cells = (layout.count() as f64).sqrt();
    assert!(square.sqrt() <= s.residual + rounding * cells, "error {:e}, residual {:e}", square.sqrt(), s.residual);
    let (reached, wanted) = match stop {
        Stop::Largest(t) => (s.largest, t),
        Stop::Relative(t) => (s.residual, t * s.rhs),
    };
    assert_eq!(s.at_floor, reached > wanted, "{s:?}");
    if s.at_floor {
        // Its deviation from the mean may be larger than known's, but by no more than a factor of 2.
        let norm = if matches!(stop, Stop::Largest(_)) { 1.0 } else { cells };
        assert!(reached <= 2.0 * rounding * norm, "{s:?} above the floor {rounding:e}");
    }
    // Recomputed from the solution.
    let mut y = vec![0.0; layout.slots()];
    solver.apply(&mut x, &mut y);
    let mut recomputed = 0f64;
    layout.each_cell(layout.cells_region(), |at| recomputed = recomputed.max((y[at.slot()] - b[at.slot()]).abs()));
    assert!((recomputed - s.largest).abs() <= 2.0 * rounding, "{recomputed:e} reported {:e}", s.largest);
}

fn axis() -> impl Strategy<Value = Mix> {
    prop::sample::select(MIXES.to_vec())
}

/// Any number, among them the ones that break things.
fn number() -> impl Strategy<Value = f64> {
    let special = vec![
        0.0,
        -0.0,
        1.0,
        -1.0,
        f64::NAN,
        f64::INFINITY,
        f64::MAX,
        f64::MIN_POSITIVE,
        f64::from_bits(1),
        1e300,
        1e-300,
    ];
    prop_oneof![any::<f64>(), prop::sample::select(special), -3.0..3f64]
}

fn stop() -> impl Strategy<Value = Stop> {
    let exponent = -16.0..-1f64;
    prop_oneof![
        exponent.clone().prop_map(|e| Stop::Relative(10f64.powf(e))),
        exponent.prop_map(|e| Stop::Largest(10f64.powf(e))),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn errors_are_below_residuals_in_two_dimensions(
        cells in [1usize..40, 1..40], mix in [axis(), axis()], exponent in -12.0..12f64, stop in stop(), single: bool,
    ) {
        let precision = if single { Precision::Single } else { Precision::Full };
        check(&Case::new(cells, mix, 1.0, 10f64.powf(exponent)), stop, None, precision);
    }

    #[test]
    fn errors_are_below_residuals_in_three_dimensions(
        cells in [1usize..14, 1..14, 1..14], mix in [axis(), axis(), axis()], exponent in -12.0..12f64, stop in stop(),
    ) {
        check(&Case::new(cells, mix, 1.0, 10f64.powf(exponent)), stop, Some(Plan::Multigrid), Precision::Full);
    }

    #[test]
    fn errors_are_below_residuals_around_random_obstacles(
        cells in [1usize..40, 1..40], mix in [axis(), axis()], exponent in -12.0..12f64, stop in stop(), solid in 0.0..16f64,
        seed in 1u64..1000,
    ) {
        let case = Case::new(cells, mix, 1.0, 10f64.powf(exponent)).masked(random_solids(solid, seed));
        check(&case, stop, Some(Plan::Multigrid), Precision::Full);
    }

    #[test]
    fn errors_are_below_residuals_around_random_obstacles_in_three_dimensions(
        cells in [1usize..12, 1..12, 1..12], mix in [axis(), axis(), axis()], exponent in -12.0..6f64, stop in stop(),
        solid in 0.0..16f64, seed in 1u64..1000,
    ) {
        let case = Case::new(cells, mix, 1.0, 10f64.powf(exponent)).masked(random_solids(solid, seed));
        check(&case, stop, Some(Plan::Multigrid), Precision::Full);
    }

    /// Any numbers at all: an answer or an error, and never a value that is not finite.
    #[test]
    fn nothing_panics(
        cells in [1usize..9, 1..9], [alpha, kappa, share, tolerance] in prop::array::uniform4(number()),
        walls in prop::array::uniform4(number()), b in prop::array::uniform3(number()),
        plan in prop::sample::select(vec![None, Some(Plan::Diagonal), Some(Plan::Chebyshev), Some(Plan::Multigrid)]),
        kinds in [0..3, 0..3, 0..3], positive: bool, masked: bool, precise: bool, largest: bool,
    ) {
        let sign = |v: f64| if positive { v.abs() } else { v };
        let layout = Layout::new(cells).unwrap();
        let axis = |i: usize, k: i32| match k {
            0 => Axis::Periodic,
            1 => Axis::Walls([0.0; 2]),
            _ => Axis::Walls([sign(walls[2 * i]), sign(walls[2 * i + 1])]),
        };
        let mut shares = FaceField::new(&layout);
        (0..2).for_each(|a| shares.axis_mut(a).fill(sign(share)));
        let mask = Mask::new(&layout, random_solids(20.0, 1));
        let sides = Sides([axis(0, kinds[0]), axis(1, kinds[1])]);
        let mut operator = Helmholtz::new(&layout, sign(alpha), sign(kappa), sides);
        if masked {
            operator = operator.with_mask(&mask);
        }
        if kinds[2] == 0 {
            operator = operator.with_shares(&shares);
        }
        let stop = if largest { Stop::Largest(tolerance) } else { Stop::Relative(tolerance) };
        let precision = if precise { Precision::Full } else { Precision::Single };
        let options = Options { plan, precision, reduction: tolerance, limit: 20 };
        let values: Vec<f64> = (0..layout.slots()).map(|i| b[i % 3]).collect();
        if let Ok(mut solver) = Solver::<f64, 2>::new(&operator, options) {
            let mut x = vec![0.0; layout.slots()];
            if solver.solve(&values, &mut x, stop).is_ok() {
                prop_assert!(x.iter().all(|v| v.is_finite()));
            }
        }
        let values: Vec<f32> = values.iter().map(|&v| v as f32).collect();
        if let Ok(mut solver) = Solver::<f32, 2>::new(&operator, options) {
            let mut x = vec![0.0; layout.slots()];
            if solver.solve(&values, &mut x, stop).is_ok() {
                prop_assert!(x.iter().all(|v| v.is_finite()));
            }
        }
    }
}

fn refused(alpha: f64, kappa: f64, wall: f64) -> SolveError {
    let layout = Layout::new([8, 8]).unwrap();
    let operator = Helmholtz::new(&layout, alpha, kappa, Sides::all(wall));
    match Solver::<f64, 2>::new(&operator, Options::default()) {
        Ok(_) => panic!("{alpha} {kappa} {wall} accepted"),
        Err(e) => e,
    }
}

#[test]
fn wrong_coefficients_are_named() {
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        assert!(matches!(refused(bad, 1.0, 0.0), SolveError::Coefficient { name: "alpha", .. }));
        assert!(matches!(refused(1.0, bad, 0.0), SolveError::Coefficient { name: "kappa", .. }));
        assert!(matches!(refused(1.0, 1.0, bad), SolveError::Coefficient { name: "wall conductance", .. }));
    }
    assert_eq!(refused(0.0, 0.0, 0.0), SolveError::Empty);
    // Walls hold their own cells alone.
    assert_eq!(refused(0.0, 0.0, 1.0), SolveError::Empty);
    for (alpha, kappa, wall) in [(0.0, 1e-300, 1.0), (1e-40, 0.0, 1.0), (0.0, 1.0, 1e35)] {
        let error = refused(alpha, kappa, wall);
        assert!(matches!(error, SolveError::Spread { .. }), "{alpha:e} {kappa:e} {wall:e}: {error}");
    }
    assert!(matches!(refused(1.0, f64::MAX, 0.0), SolveError::Coefficient { name: "alpha + 2 D kappa", .. }));
    let (layout, other) = (Layout::new([8, 8]).unwrap(), Layout::new([8, 9]).unwrap());
    let mask = Mask::new(&other, |_| true);
    let operator = Helmholtz::new(&layout, 1.0, 1.0, Sides::all(0.0));
    let error = Solver::<f64, 2>::new(&operator.clone().with_mask(&mask), Options::default()).err();
    assert!(matches!(error, Some(SolveError::Length { what: "mask", .. })));
    for (a, slot) in [(0, layout.slot([0, 0])), (1, layout.slot([3, 8]))] {
        let mut shares = FaceField::new(&layout);
        shares.axis_mut(a)[slot] = -1.0;
        let error = Solver::<f64, 2>::new(&operator.clone().with_shares(&shares), Options::default()).err();
        assert!(matches!(error, Some(SolveError::Coefficient { name: "share", value: -1.0 })));
    }
}

#[test]
fn failed_solves_carry_what_they_reached() {
    let case = Case::new([40, 40], [HELD, CLOSED], 1.0, 100.0);
    let b = random_field::<f64, 2>(&case.layout, 2);
    for plan in [Plan::Multigrid, Plan::Chebyshev] {
        let options = Options { plan: Some(plan), limit: 1, ..Default::default() };
        let mut solver = Solver::<f64, 2>::new(&case.helmholtz(), options).unwrap();
        let mut x = vec![0.0; case.layout.slots()];
        let made = if plan == Plan::Multigrid { 1 } else { 10 };
        match solver.solve(&b, &mut x, Stop::Largest(1e-12)) {
            Err(SolveError::NotConverged { iterations, residual, wanted }) => {
                assert_eq!((iterations, wanted), (made, 1e-12));
                assert!(residual > 1e-12 && residual < 10.0, "{residual}");
            }
            other => panic!("{other:?}"),
        }
    }
    let mut solver = Solver::<f64, 2>::new(&case.helmholtz(), Options::default()).unwrap();
    let mut x = vec![0.0; case.layout.slots()];
    for bad in [f64::NAN, f64::INFINITY] {
        let mut b = b.clone();
        b[case.layout.slot([39, 39])] = bad;
        let error = solver.solve(&b, &mut x, Stop::Relative(1e-6));
        assert_eq!(error, Err(SolveError::NotFinite { what: "right-hand side", iterations: 0 }));
    }
    for bad in [f64::NAN, -1.0] {
        let error = solver.solve(&b, &mut x, Stop::Relative(bad));
        assert!(matches!(error, Err(SolveError::Coefficient { name: "tolerance", .. })), "{error:?}");
    }
    let error = solver.solve(&b[1..], &mut x, Stop::Relative(1e-6));
    assert!(matches!(error, Err(SolveError::Length { .. })));
    // The vectors recovered from all that.
    assert!(solver.solve(&b, &mut x, Stop::Relative(1e-6)).is_ok());
}
