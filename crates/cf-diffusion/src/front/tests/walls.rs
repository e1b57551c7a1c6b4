//! What walls let through.

use cf_grid::{Axis, Grid, Real, Sides, Wall};

use super::*;

const FLUX: Wall = Wall::Flux(0.3);
const VALUE: Wall = Wall::Value(-0.4);
const WEAK: Wall = Wall::Absorbing { speed: 0.4, far: 0.2 };
const CALM: Wall = Wall::Absorbing { speed: 1.0, far: 0.2 };
const OPEN: Wall = Wall::Open { inflow: 0.7 };

/// Mass plus outflow minus emission is what it was, relative to what there is and passes.
fn balance<T: Real, const D: usize>(cells: [usize; D], sides: Sides<Wall, D>, u: [f64; D], tolerance: f64) {
    let grid = Grid::new(cells, 0.1).unwrap();
    let (mut front, mut state) = start::<T, D>(&grid, &sides, u, |x| 0.5 + (5.0 * x[0] - 3.0 * x[D - 1]).sin());
    state.flux[D - 1] = state.phi.clone();
    let rate = state.phi.clone();
    let before = state.mass(&grid);
    let report = front.step(&mut state, Source::steady(&rate), 0.8).unwrap();
    let after = state.mass(&grid);
    let scale = before.abs() + report.outflow.abs() + report.emitted.abs();
    let error = (after + report.outflow - before - report.emitted).abs() / scale;
    assert!(error < tolerance, "{sides:?} {u:?}: {error:e}");
}

#[test]
fn mass_and_outflow_balance_for_every_mix() {
    let walls = [Wall::CLOSED, FLUX, VALUE, WEAK, CALM, OPEN];
    for low in walls {
        for high in walls {
            let shut = [low, high].iter().any(|w| w.carried_in().is_none());
            for u in if shut { vec![0.0] } else { vec![0.0, 0.6, -1.0, 1.7] } {
                let sides = Sides([Axis::Walls([low, high]), Axis::Walls([high, low])]);
                balance::<f64, 2>([17, 9], sides, [u, -u], 1e-12);
                balance::<f32, 2>([17, 9], sides, [u, -u], 1e-6);
                let sides = Sides([Axis::Walls([low, high]), Axis::Periodic, Axis::Walls([high, low])]);
                balance::<f64, 3>([9, 2, 5], sides, [u, 0.3, -u], 1e-12);
            }
        }
    }
}

#[test]
fn thin_boxes_balance() {
    for cells in [[1, 1], [1, 7], [130, 1], [2, 3], [65, 2]] {
        for wall in [Wall::CLOSED, FLUX, VALUE, WEAK, CALM, OPEN] {
            balance::<f64, 2>(cells, Sides::all(wall), [0.0; 2], 1e-12);
        }
        balance::<f64, 2>(cells, Sides::periodic(), [0.6, 2.0], 1e-12);
        balance::<f64, 2>(cells, Sides::all(OPEN), [0.6, -2.0], 1e-12);
    }
}

#[test]
fn closed_walls_let_exactly_nothing_through() {
    let grid = Grid::new([19, 12], 0.1).unwrap();
    let (mut front, mut state) =
        start::<f64, 2>(&grid, &Sides::all(Wall::CLOSED), [0.0; 2], |x| (x[0] * 9.0).sin() + x[1]);
    assert_eq!(front.step(&mut state, Source::NONE, 2.0).unwrap().outflow, 0.0);
}

#[test]
fn constants_stay_to_the_bit() {
    fn check<T: Real, const D: usize>(cells: [usize; D], sides: Sides<Wall, D>, u: [f64; D]) {
        let grid = Grid::new(cells, 0.1).unwrap();
        let (mut front, mut state) = start::<T, D>(&grid, &sides, u, |_| 0.7);
        let before = state.clone();
        front.step(&mut state, Source::NONE, 1.0).unwrap();
        let layout = grid.layout();
        layout.each_cell(layout.cells_region(), |at| {
            assert!(state.phi[at.slot()] == before.phi[at.slot()], "{sides:?} {u:?}");
            assert!((0..D).all(|a| state.flux[a][at.slot()] == T::ZERO));
        });
    }
    let calm = Wall::Absorbing { speed: 1.0, far: 0.7 };
    for u in [[0.0; 2], [0.5, -1.0], [3.0, 0.1]] {
        check::<f64, 2>([70, 9], Sides::periodic(), u);
        check::<f32, 2>([7, 9], Sides::all(Wall::Value(0.7)), u);
        check::<f32, 2>([7, 9], Sides::all(calm), u);
        check::<f64, 2>([1, 9], Sides::all(Wall::Open { inflow: 0.7 }), u);
    }
    check::<f64, 3>([5, 3, 1], Sides::all(Wall::CLOSED), [0.0; 3]);
    check::<f64, 2>([1, 1], Sides::all(Wall::Value(0.7)), [0.0; 2]);
}

#[test]
fn a_value_wall_is_a_mirror_of_the_other_sign() {
    // sin(pi x) between values 0 is the same as on a periodic line of twice the length.
    let n = 40;
    let wave = |x: SVector<f64, 2>| (std::f64::consts::PI * x[0]).sin();
    let grid = Grid::new([n, 1], 1.0 / n as f64).unwrap();
    let (mut front, mut state) = start::<f64, 2>(&grid, &Sides::all(Wall::Value(0.0)), [0.0; 2], wave);
    let sides = Sides([Axis::Walls([Wall::Value(0.0); 2]), Axis::Periodic]);
    (front.sides, front.courant) = (sides, 0.9);
    let twice = Grid::new([2 * n, 1], 1.0 / n as f64).unwrap();
    let (mut other, mut whole) = start::<f64, 2>(&twice, &Sides::periodic(), [0.0; 2], wave);
    advance(&mut front, &mut state, 0.7, 0.9);
    advance(&mut other, &mut whole, 0.7, 0.9);
    for i in 0..n {
        let (a, b) = (grid.layout().slot([i, 0]), twice.layout().slot([i, 0]));
        assert!((state.phi[a] - whole.phi[b]).abs() < 1e-13);
    }
}

#[test]
fn a_given_flux_is_what_leaves() {
    let grid = Grid::new([20, 4], 0.1).unwrap();
    let sides = Sides([Axis::Walls([Wall::Flux(0.25), Wall::CLOSED]), Axis::Periodic]);
    let (mut front, mut state) = start::<f64, 2>(&grid, &sides, [0.0; 2], |x| x[0].cos());
    let outflow = front.step(&mut state, Source::NONE, 3.0).unwrap().outflow;
    assert!((outflow - 0.25 * 3.0 * 0.4).abs() < 1e-13, "{outflow}");
}

#[test]
fn sound_leaves_through_absorbing_walls() {
    let grid = Grid::new([200, 1], 0.01).unwrap();
    let run = |wall| {
        let sides = Sides([Axis::Walls([wall; 2]), Axis::Periodic]);
        let law = Law::from_speed(1.0, 1e6, 0.0).unwrap();
        let mut front = Front::new(&grid, &sides, law, SVector::zeros()).unwrap();
        let (_, mut state) = start::<f64, 2>(&grid, &sides, [0.0; 2], |x| (-(x[0] - 1.0).powi(2) * 50.0).exp());
        let report = front.step(&mut state, Source::NONE, 2.5).unwrap();
        (grid.layout().max_abs(&state.phi), report.outflow / grid.h())
    };
    let (left, outflow) = run(Wall::Absorbing { speed: 1.0, far: 0.0 });
    assert!(left < 1e-5 && (outflow / (std::f64::consts::PI / 50.0).sqrt() - 1.0).abs() < 1e-4, "{left:e} {outflow}");
    assert_eq!(run(Wall::Open { inflow: 0.0 }).0, left);
    // Reflected by (c - s)/(c + s).
    let weak = run(Wall::Absorbing { speed: 0.5, far: 0.0 }).0;
    assert!((0.15..0.18).contains(&weak), "{weak}");
}
