//! What is refused, and the ends of the ranges.

use cf_grid::{Axis, End, Grid, Real, Sides, Wall};

use super::*;
use crate::MediumError;
use crate::front::FrontError;

fn grid() -> Grid<2> {
    Grid::new([5, 3], 0.1).unwrap()
}

fn refused(law: Law, wall: Wall, u: [f64; 2]) -> FrontError {
    Front::<f32, 2>::new(&grid(), &Sides::all(wall), law, SVector::from(u)).unwrap_err()
}

#[test]
fn laws_without_fronts_are_refused() {
    for law in [Law::fourier(1.0), Law::cattaneo(1.0, 0.0), Law::cattaneo(0.0, 1.0), Law::jeffreys(1.0, 1.0, 0.1)] {
        let error = refused(law.unwrap(), Wall::CLOSED, [0.0; 2]);
        assert!(matches!(error, FrontError::NeedsWaves { .. }));
        assert!(error.to_string().contains("use Diffusion"), "{error}");
    }
    let slow = Law::from_speed(1e-60, 1.0, 0.0).unwrap();
    assert_eq!(refused(slow, Wall::CLOSED, [0.0; 2]), FrontError::Speed { speed: 1e-60, precision: "f32" });
}

#[test]
fn walls_and_media_are_checked() {
    for (wall, name) in [
        (Wall::Flux(f64::NAN), "flux"),
        (Wall::Value(f64::INFINITY), "value"),
        (Wall::Absorbing { speed: -1.0, far: 0.0 }, "speed"),
        (Wall::Absorbing { speed: 1.0, far: f64::NAN }, "far"),
        (Wall::Open { inflow: f64::NAN }, "inflow"),
    ] {
        let error = refused(law(), wall, [0.0; 2]);
        assert!(matches!(error, FrontError::Wall { axis: 0, end: End::Low, what, .. } if what == name), "{error}");
    }
    let crosses = FrontError::Medium(MediumError::CrossesClosedWall { axis: 1, end: End::Low, value: 0.5 });
    assert_eq!(refused(law(), Wall::Flux(0.2), [0.0, -0.5]), crosses);
    let error = refused(law(), Wall::Value(0.0), [0.0, f64::NAN]);
    assert!(matches!(error, FrontError::Medium(MediumError::NotFinite { axis: 1, .. })));
}

#[test]
fn steps_and_fields_are_checked() {
    let sides = Sides([Axis::Periodic, Axis::Walls([Wall::CLOSED, Wall::Value(1.0)])]);
    let (mut front, mut state) = start::<f64, 2>(&grid(), &sides, [3.0, 0.0], |x| x[0]);
    let before = state.clone();
    for dt in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(front.step(&mut state, Source::NONE, dt), Err(FrontError::TimeStep(_))));
    }
    let error = front.step(&mut state, Source::NONE, 1e5).unwrap_err();
    assert!(matches!(error, FrontError::TooManySubsteps { limit: 100_000, .. }), "{error}");
    let rate = vec![0.0; 4];
    let error = front.step(&mut state, Source::steady(&rate), 0.1).unwrap_err();
    assert_eq!(error, FrontError::Layout { what: "the source", expected: 35, found: 4 });
    let mut other = FrontState::new(&Grid::new([5, 4], 0.1).unwrap());
    let error = front.step(&mut other, Source::NONE, 0.1).unwrap_err();
    assert_eq!(error, FrontError::Layout { what: "the flux", expected: 35, found: 42 });
    assert_eq!(front.step(&mut state, Source::NONE, 0.0), Ok(Default::default()));
    assert_eq!(state, before);

    let mut rate = before.phi.clone();
    let slot = grid().layout().slot([3, 2]);
    rate[slot] = f64::NAN;
    let error = front.step(&mut state, Source::steady(&rate), 0.1).unwrap_err();
    assert_eq!(error, FrontError::NotFinite { field: "the source", cell: vec![3, 2] });
    assert_eq!(state, before);
    state.flux[0][slot] = f64::INFINITY;
    let error = front.step(&mut state, Source::NONE, 0.5).unwrap_err();
    assert!(matches!(error, FrontError::NotFinite { field: "phi", .. }), "{error}");
    assert!(error.to_string().starts_with("phi is not finite at cell ["), "{error}");
}

#[test]
fn the_range_is_reported() {
    let at = |tau: f64| {
        let law = Law::from_speed(1.0, tau, 0.0).unwrap();
        Front::<f64, 2>::new(&grid(), &Sides::periodic(), law, SVector::zeros()).unwrap().validity()
    };
    assert!((at(1.0).unwrap() - 0.1).abs() < 1e-15);
    let error = at(0.1).unwrap_err();
    assert!(matches!(error, FrontError::TooCoarse { limit: 0.3, .. }));
    assert!(error.to_string().contains("h/(c tau) = 1.000 exceeds 0.3"), "{error}");
}

#[test]
fn sub_steps_are_counted() {
    let (mut front, mut state) = start::<f64, 2>(&grid(), &Sides::periodic(), [-1.5, 0.5], |x| x[0]);
    assert_eq!(front.stable_dt(), 0.5 * 0.1 / 2.5);
    assert_eq!(front.bytes(), 2 * 35 * 8);
    assert_eq!(state.bytes(), 3 * 35 * 8);
    assert_eq!(front.step(&mut state, Source::NONE, 0.02).unwrap().substeps, 1);
    assert_eq!(front.step(&mut state, Source::NONE, 0.021).unwrap().substeps, 2);
    assert!(front.sweep_reversed());
    let mut front = front.with_courant(1.0).unwrap();
    assert_eq!(front.step(&mut state, Source::NONE, 0.04).unwrap().substeps, 1);
    for courant in [0.0, 1.1, f64::NAN] {
        assert!(matches!(front.clone().with_courant(courant), Err(FrontError::Courant(_))));
    }
    let line = start::<f64, 2>(&Grid::new([1, 8], 0.1).unwrap(), &Sides::periodic(), [0.0; 2], |_| 0.0).0;
    assert_eq!(line.stable_dt(), 0.9 * 0.1);
}

/// Powers of two scale a step to the bit, within the range of the precision.
#[test]
fn steps_are_linear() {
    fn check<T: Real>(factor: f64) {
        let run = |size: f64| {
            let (mut front, mut state) = start::<T, 2>(&grid(), &Sides::all(Wall::CLOSED), [0.0; 2], |x| {
                size * (1.0 + (7.0 * x[0] + x[1]).sin())
            });
            front.step(&mut state, Source::NONE, 0.5).unwrap();
            state
        };
        let (one, scaled) = (run(1.0), run(factor));
        grid().layout().each_cell(grid().layout().cells_region(), |at| {
            assert_eq!(one.phi[at.slot()].f64() * factor, scaled.phi[at.slot()].f64());
        });
    }
    check::<f32>(2f64.powi(-70));
    check::<f32>(2f64.powi(90));
    check::<f64>(2f64.powi(-900));
}

#[test]
fn precisions_agree() {
    fn run<T: Real>() -> Vec<f64> {
        let grid = Grid::new([33, 20], 0.05).unwrap();
        let bump = |x: SVector<f64, 2>| (-x.add_scalar(-0.6).norm_squared() * 30.0).exp();
        let (mut front, mut state) = start::<T, 2>(&grid, &Sides::all(Wall::Open { inflow: 0.1 }), [0.4, 1.2], bump);
        front.step(&mut state, Source::NONE, 0.7).unwrap();
        state.phi.iter().map(|v| v.f64()).collect()
    }
    let (single, double) = (run::<f32>(), run::<f64>());
    assert!(single.iter().zip(&double).all(|(a, b)| (a - b).abs() < 2e-6));
}

#[test]
fn extreme_relaxation_times_are_stable() {
    for tau in [1e-12, 1e-3, 1e12] {
        let grid = Grid::new([24, 24], 0.1).unwrap();
        let law = Law::from_speed(1.0, tau, 0.0).unwrap();
        let mut front = Front::new(&grid, &Sides::all(Wall::CLOSED), law, SVector::zeros()).unwrap();
        let (_, mut state) = start::<f64, 2>(&grid, &Sides::all(Wall::CLOSED), [0.0; 2], |x| (x[0] * 5.0).sin());
        front.step(&mut state, Source::NONE, 20.0).unwrap();
        assert!(grid.layout().max_abs(&state.phi) <= 2.0, "{tau}");
    }
}
