//! Nothing is lost: mass, outflow, constants.

use std::f64::consts::TAU;

use cf_grid::{Axis, CellField, End, Grid, Mask, Real, Sides, Wall};
use nalgebra::SVector;
use proptest::prelude::*;

use super::{METHODS, mass, noisy, noisy_flux, vortex, walls_2d};
use crate::advect::{Advection, Advector};
use crate::medium::{Medium, sample, vector_potential};

fn books_balance<T: Real>(
    cells: [usize; 2],
    sides: Sides<Wall, 2>,
    medium: &Medium<T, 2>,
    mask: Option<&Mask<2>>,
    dt: f64,
) {
    let grid = Grid::new(cells, 0.125).unwrap();
    let mut advector = Advector::new(&grid, &sides, mask, Advection::Muscl);
    let mut phi = noisy::<T, 2>(&grid);
    let scale = grid.layout().sum_abs(&phi) * grid.cell_volume();
    let (before, mut left) = (mass(&grid, &phi), 0.0);
    for _ in 0..5 {
        left += advector.advect(&mut phi, None, medium, dt).unwrap().outflow;
    }
    let error = (mass(&grid, &phi) + left - before).abs() / scale;
    let limit = if T::NAME == "f64" { 1e-13 } else { 1e-6 };
    assert!(error < limit, "{} {sides:?} {cells:?}: {error:e}", T::NAME);
}

#[test]
fn mass_and_outflow_balance_on_every_wall_mix() {
    fn check<T: Real>() {
        for sides in walls_2d() {
            for cells in [[16, 16], [67, 3], [3, 70], [1, 9], [9, 1], [1, 1]] {
                let uniform = Medium::<T, 2>::Uniform(SVector::from([1.0, -0.7]));
                books_balance(cells, sides, &uniform, None, 0.3);
                let grid = Grid::new(cells, 0.125).unwrap();
                let wild = |x: SVector<f64, 2>| {
                    SVector::from([(TAU * x[1]).sin() + 0.3 * (TAU * x[0]).cos(), (TAU * x[0]).cos() - 0.2])
                };
                let field = Medium::Field(sample::<T, 2>(&grid, wild).unwrap());
                books_balance(cells, sides, &field, None, 0.2);
                let mask = Mask::new(grid.layout(), |c| (c[0] + 2 * c[1]) % 7 != 3);
                books_balance(cells, sides, &uniform, Some(&mask), 0.2);
                books_balance(cells, sides, &field, Some(&mask), 0.2);
            }
        }
    }
    check::<f64>();
    check::<f32>();
}

#[test]
fn closed_walls_keep_all_mass_in_three_dimensions() {
    for cells in [[3, 5, 7], [8, 1, 4], [1, 1, 1], [70, 4, 3]] {
        let grid = Grid::new(cells, 0.1).unwrap();
        let mut u = vector_potential::<f64>(&grid, |x| SVector::from([x[1], x[2] * x[0], x[0] * 3.0])).unwrap();
        let sides = Sides::all(Wall::Flux(1.0));
        for (axis, end, _) in sides.walls() {
            let mut layer = grid.layout().faces_region(axis, false);
            let at = if end == End::Low { 0 } else { cells[axis] };
            (layer.low[axis], layer.high[axis]) = (at, at + 1);
            grid.layout().par_region(layer, u.axis_mut(axis), |_| 0.0);
        }
        let mut advector = Advector::new(&grid, &sides, None, Advection::Muscl);
        let mut phi = noisy(&grid);
        let (before, mut q) = (mass(&grid, &phi), noisy_flux(&grid, &sides));
        for _ in 0..4 {
            let done = advector.advect(&mut phi, Some(&mut q), &Medium::Field(u.clone()), 0.01).unwrap();
            assert_eq!(done.outflow, 0.0);
        }
        assert!((mass(&grid, &phi) - before).abs() < 1e-14 * before);
    }
}

#[test]
fn constants_stay_constant() {
    fn check<T: Real, const D: usize>(grid: &Grid<D>, medium: &Medium<T, D>, sides: &Sides<Wall, D>, dt: f64) {
        for method in METHODS {
            let mut advector = Advector::new(grid, sides, None, method);
            let mut phi = CellField::<T>::new(grid.layout());
            phi.fill(T::of(3.0));
            for _ in 0..6 {
                advector.advect(&mut phi, None, medium, dt).unwrap();
            }
            let (low, high) = grid.layout().range(&phi);
            let limit = if matches!(medium, Medium::Uniform(_)) || method != Advection::Muscl {
                0.0
            } else {
                400.0 * T::EPSILON
            };
            assert!(low >= 3.0 - limit && high <= 3.0 + limit, "{method:?} {low:e} {high:e}");
        }
    }
    let open = Sides::all(Wall::Open { inflow: 3.0 });
    let grid = Grid::new([33, 20], 1.0 / 33.0).unwrap();
    check(&grid, &vortex::<f64>(&grid), &open, 0.05);
    check(&grid, &vortex::<f32>(&grid), &open, 0.05);
    check(&grid, &Medium::<f32, 2>::Uniform(SVector::from([0.3, -2.0])), &open, 0.05);
    let grid = Grid::new([12, 9, 10], 0.1).unwrap();
    let swirl = |x: SVector<f64, 3>| SVector::from([(3.0 * x[1]).sin(), (4.0 * x[2]).cos() * x[0], (5.0 * x[0]).sin()]);
    let u = vector_potential::<f64>(&grid, swirl).unwrap();
    check(&grid, &Medium::Field(u), &open_3d(3.0), 0.05);
    check(&grid, &Medium::<f64, 3>::Uniform(SVector::from([1.0, -2.0, 0.5])), &open_3d(3.0), 0.05);
    check(&grid, &Medium::<f64, 3>::Uniform(SVector::from([1.0, -2.0, 0.5])), &Sides::periodic(), 0.05);
}

fn open_3d(inflow: f64) -> Sides<Wall, 3> {
    Sides::all(Wall::Open { inflow })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]
    #[test]
    fn any_box_any_walls_any_velocity(
        cells in [1usize..20, 1..20, 1..8],
        kinds in [0usize..4, 0..4, 0..4],
        u in [-2.0f64..2.0, -2.0..2.0, -2.0..2.0],
        field in any::<bool>(),
        dt in 0.0f64..0.4,
    ) {
        let grid = Grid::new(cells, 0.1).unwrap();
        let axis = |kind| match kind {
            0 => Axis::Periodic,
            1 => Axis::Walls([Wall::Open { inflow: 0.3 }, Wall::Value(0.9)]),
            2 => Axis::Walls([Wall::Absorbing { speed: 1.0, far: 0.4 }, Wall::Open { inflow: 1.0 }]),
            _ => Axis::Walls([Wall::CLOSED, Wall::Flux(2.0)]),
        };
        let sides = Sides(kinds.map(axis));
        let mut velocity = SVector::from(u);
        for a in 0..3 {
            if kinds[a] == 3 { velocity[a] = 0.0 }
        }
        let wavy = |x: SVector<f64, 3>| SVector::<f64, 3>::from_fn(|a, _| velocity[a] * (1.0 + 0.5 * (x[(a + 1) % 3] * 7.0).sin()));
        let medium = if field { Medium::Field(sample::<f64, 3>(&grid, wavy).unwrap()) } else { Medium::Uniform(velocity) };
        for method in METHODS {
            let (mut phi, mut q) = (noisy::<f64, 3>(&grid), noisy_flux(&grid, &sides));
            let before = mass(&grid, &phi);
            let done = Advector::new(&grid, &sides, None, method).advect(&mut phi, Some(&mut q), &medium, dt).unwrap();
            let (low, high) = grid.layout().range(&phi);
            if method == Advection::Muscl {
                prop_assert!((mass(&grid, &phi) + done.outflow - before).abs() < 1e-12 * before.max(done.outflow.abs()));
                prop_assert!(low > -0.3 && high < 2.0, "{} {}", low, high);
            } else {
                prop_assert!(low >= 0.25 - 1e-12 && high <= 1.25 + 1e-12, "{} {}", low, high);
            }
            for q in q.axes() {
                prop_assert!(q.iter().all(|v| v.abs() <= 0.5 + 1e-12));
            }
        }
    }
}
