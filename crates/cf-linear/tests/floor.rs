//! Where coefficients differ by orders of magnitude: the tolerance is met, or what is left is rounding row by row.

use cf_grid::{Axis, FaceField, Real, Sides};
use cf_linear::{Options, Plan, Precision, SolveError, Solver, Stop};
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

use crate::common::*;

/// Solves and compares with the dense solution. Returns whether it converged.
fn check<T: Real, const D: usize>(case: &Case<D>, dense: &Dense, precision: Precision, t: f64, what: &str) -> bool {
    let what = format!("{what} {} {precision:?} to {t:e}", T::NAME);
    let options = Options { plan: Some(Plan::Multigrid), precision, ..Default::default() };
    let mut solver = Solver::<T, D>::new(&case.helmholtz(), options).unwrap();
    let b = random_field::<T, D>(&case.layout, 7);
    let mut x = vec![T::ZERO; b.len()];
    let done = match solver.solve(&b, &mut x, Stop::Relative(t)) {
        Ok(done) => done,
        Err(SolveError::NotConverged { .. }) => return false,
        Err(e) => panic!("{what}: {e}"),
    };
    let (b, x) = (case.gather(&b), case.gather(&x));
    let residual = (&b - &dense.operator * &x).norm_l2();
    let weighted = Mat::from_fn(x.nrows(), 1, |i, _| dense.operator[(i, i)] * x[(i, 0)]);
    let rounding = T::EPSILON * weighted.norm_l2();
    let wanted = t * b.norm_l2();
    // Forming the residual of the rounded x and the constants that are added to it round once more.
    if done.at_floor {
        assert!(residual <= 6.0 * rounding, "{what}: residual {residual:e}, rounding {rounding:e}");
    } else {
        assert!(residual <= wanted + 2.0 * rounding, "{what}: residual {residual:e}, wanted {wanted:e}");
    }
    let exact = dense.factor.solve(&b);
    let error = largest(&(&x - &exact)) / largest(&exact);
    assert!(error <= 10.0 * t.max(30.0 * T::EPSILON.max(1e-11)), "{what}: error {error:e}, {done:?}");
    true
}

struct Dense {
    operator: Mat<f64>,
    factor: Llt<f64>,
}

impl Dense {
    fn new<const D: usize>(case: &Case<D>) -> Self {
        let operator = case.dense();
        Self { factor: operator.llt(Side::Lower).unwrap(), operator }
    }
}

fn check_all<const D: usize>(case: &Case<D>, what: &str) -> [bool; 3] {
    let dense = Dense::new(case);
    let double = [1e-3, 1e-8, 1e-11].map(|t| check::<f64, D>(case, &dense, Precision::Full, t, what));
    let mixed = [1e-3, 1e-8, 1e-11].map(|t| check::<f64, D>(case, &dense, Precision::Single, t, what));
    let single = [1e-2, 3e-4, 1e-5, 1e-6, 1e-9].map(|t| check::<f32, D>(case, &dense, Precision::Full, t, what));
    [double.iter().all(|&c| c), mixed.iter().all(|&c| c), single.iter().all(|&c| c)]
}

#[test]
fn walls_of_any_strength() {
    for cells in [[40, 33], [64, 24]] {
        for kappa in [1.0, 100.0, 1e4] {
            for strength in [1e-3, 1.0, 1e2, 1e4, 1e6] {
                let what = format!("{cells:?} kappa {kappa:e} walls {strength:e}");
                let mut case = Case::new(cells, [CLOSED; 2], 1.0, kappa);
                case.walls = Sides([Axis::Walls([strength * kappa, 0.0]), Axis::Walls([0.0, 2.0 * kappa])]);
                assert_eq!(check_all(&case, &what), [true; 3], "{what}");
                case.walls = Sides::all(strength * kappa);
                assert_eq!(check_all(&case, &what), [true; 3], "all {what}");
                let case = case.masked(random_solids(15.0, 3));
                assert_eq!(check_all(&case, &what), [true; 3], "masked {what}");
            }
        }
    }
    for strength in [1e-3, 1.0, 1e4, 1e6] {
        let mut case = Case::new([9, 8, 7], [CLOSED; 3], 0.0, 1.0);
        case.walls = Sides([Axis::Walls([strength, 0.0]), Axis::Periodic, Axis::Walls([0.3, 0.0])]);
        assert_eq!(check_all(&case, &format!("space, {strength:e}")), [true; 3], "{strength:e}");
    }
}

/// PCG stops on its own residual, from which the true one differs by rounding: it has to go on far enough.
#[test]
fn every_tolerance_above_the_floor_is_met() {
    for (mix, kappa) in [([HELD, CLOSED], 30.0), ([CLOSED; 2], 1e3), ([HELD; 2], 1e4)] {
        let case = Case::new([40, 33], mix, 1.0, kappa);
        let mut solver =
            Solver::<f32, 2>::new(&case.helmholtz(), Options { plan: Some(Plan::Multigrid), ..Default::default() })
                .unwrap();
        let b = random_field::<f32, 2>(&case.layout, 7);
        for i in 0..400 {
            let t = 10f64.powf(-2.0 - f64::from(i) / 80.0);
            let mut x = vec![0.0; b.len()];
            let done =
                solver.solve(&b, &mut x, Stop::Relative(t)).unwrap_or_else(|e| panic!("{mix:?} {kappa} to {t:e}: {e}"));
            assert!(done.residual <= t * done.rhs || done.at_floor && t < 4e-6, "{mix:?} {kappa} to {t:e}: {done:?}");
        }
    }
}

/// Shares 10^s with s in [-digits, digits): by face, or in strips of five cells.
fn contrast<const D: usize>(case: Case<D>, digits: f64, strips: bool) -> Case<D> {
    let (mut random, mut shares) = (noise(5), FaceField::new(&case.layout));
    for a in 0..D {
        let w = shares.axis_mut(a);
        case.layout.each_cell(case.layout.faces_region(a, false), |at| {
            let strip = if (at.cell[0] / 5).is_multiple_of(2) { 1.0 } else { -1.0 };
            w[at.slot()] = 10f64.powf(digits * if strips { strip } else { random() });
        });
    }
    Case { shares: Some(shares), ..case }
}

#[test]
fn shares_of_any_size() {
    for mix in [[HELD, CLOSED], [CLOSED; 2], [HELD; 2]] {
        for kappa in [1.0, 100.0, 1e4] {
            for digits in [0.5, 1.5, 3.0] {
                for strips in [false, true] {
                    let what = format!("{mix:?} kappa {kappa:e} shares {digits} in strips {strips}");
                    let [double, mixed, single] =
                        check_all(&contrast(Case::new([40, 33], mix, 1.0, kappa), digits, strips), &what);
                    // Where conductances differ more than single precision has digits its cycles may give up, and say so.
                    let hard = digits == 3.0;
                    assert!(double && (hard || mixed && single), "{what}: {double} {mixed} {single}");
                }
            }
        }
    }
}
