//! Rest, refusals and solids.

use cf_grid::{Axis, CellField, End, FaceField, Grid, Mask, Sides, Wall};
use nalgebra::SVector;

use super::{METHODS, noisy, noisy_flux};
use crate::advect::{AdvectError, Advection, Advector};
use crate::medium::{Medium, MediumError};

#[test]
fn rest_changes_no_bit() {
    let grid = Grid::new([9, 7], 0.1).unwrap();
    let sides = Sides::all(Wall::Value(4.0));
    for method in METHODS {
        let (mut phi, mut q) = (noisy::<f32, 2>(&grid), noisy_flux(&grid, &sides));
        let before = (phi.clone(), q.clone());
        let mut advector = Advector::new(&grid, &sides, None, method);
        let still = [Medium::Still, Medium::Uniform(SVector::zeros()), Medium::Field(FaceField::new(grid.layout()))];
        for medium in still {
            let done = advector.advect(&mut phi, Some(&mut q), &medium, 1e9).unwrap();
            assert_eq!((done.outflow, done.substeps), (0.0, 0));
            assert_eq!(advector.stable_dt(&medium), None);
        }
        let moving = Medium::Uniform(SVector::from([1.0, 2.0]));
        advector.advect(&mut phi, Some(&mut q), &moving, 0.0).unwrap();
        assert_eq!((phi, q), before);
        assert!(!advector.reversed());
    }
}

#[test]
fn what_cannot_be_carried_is_refused_and_nothing_changes() {
    let grid = Grid::new([8, 8], 0.1).unwrap();
    let sides = Sides([Axis::Walls([Wall::Open { inflow: 0.0 }, Wall::CLOSED]), Axis::Periodic]);
    let mut advector = Advector::<f64, 2>::new(&grid, &sides, None, Advection::Muscl);
    let mut phi = noisy(&grid);
    let before = phi.clone();
    let along = Medium::Uniform(SVector::from([0.0, 1.0]));
    let nan = Medium::Uniform(SVector::from([0.0, f64::NAN]));
    let error = advector.advect(&mut phi, None, &nan, 0.1).unwrap_err();
    assert!(matches!(error, AdvectError::Medium(MediumError::NotFinite { axis: 1, .. })));
    let mut field = FaceField::new(grid.layout());
    field.axis_mut(0)[grid.layout().slot([3, 3])] = f64::NEG_INFINITY;
    let error = advector.advect(&mut phi, None, &Medium::Field(field), 0.1).unwrap_err();
    assert!(matches!(error, AdvectError::Medium(MediumError::NotFinite { axis: 0, cell: [3, 3, 0], .. })));
    let across = Medium::Uniform(SVector::from([1.0, 1.0]));
    let error = advector.advect(&mut phi, None, &across, 0.1).unwrap_err();
    assert!(matches!(error, AdvectError::Medium(MediumError::CrossesClosedWall { axis: 0, end: End::High, .. })));
    for dt in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(advector.advect(&mut phi, None, &along, dt), Err(AdvectError::Step { .. })));
    }
    let error = advector.advect(&mut phi, None, &along, 1e6).unwrap_err();
    assert!(matches!(error, AdvectError::TooManySubsteps { .. }) && error.to_string().contains("semi-Lagrangian"));
    let mut small = CellField::new(Grid::new([3, 3], 0.1).unwrap().layout());
    assert!(matches!(advector.advect(&mut small, None, &along, 0.1), Err(AdvectError::Layout { .. })));
    assert_eq!(phi, before);
    assert!((advector.stable_dt(&along).unwrap() - 0.1).abs() < 1e-15);
    assert_eq!(advector.advect(&mut phi, None, &along, 0.2 * (1.0 + 1e-15)).unwrap().substeps, 2);
    assert_eq!(advector.advect(&mut phi, None, &along, 0.21).unwrap().substeps, 3);
}

#[test]
fn solids_keep_their_values_and_nothing_leaks_through_them() {
    let grid = Grid::new([40, 12], 0.1).unwrap();
    // A full wall at x = 20: what is left of it never reaches the right.
    let mask = Mask::new(grid.layout(), |c| c[0] != 20);
    let sides = Sides([Axis::Walls([Wall::Open { inflow: 1.0 }; 2]), Axis::Periodic]);
    for method in [Advection::Muscl, Advection::Cubic, Advection::Linear] {
        let mut phi = CellField::<f64>::new(grid.layout());
        grid.layout().par_cells(&mut phi, |at| match at.cell[0] {
            20 => 77.0,
            i if i < 20 => 1.0,
            _ => 0.0,
        });
        let mut u = FaceField::new(grid.layout());
        grid.layout().par_region(grid.layout().faces_region(0, false), u.axis_mut(0), |at| {
            if at.cell[0] < 20 { 1.0 } else { 0.0 }
        });
        grid.layout().par_cells(u.axis_mut(1), |at| if at.cell[0] == 20 { 0.0 } else { 0.5 });
        let medium = Medium::Field(u);
        let mut advector = Advector::new(&grid, &sides, Some(&mask), method);
        for _ in 0..10 {
            advector.advect(&mut phi, None, &medium, 0.05).unwrap();
        }
        for j in 0..12 {
            let at = |i| phi[grid.layout().slot([i, j])];
            assert_eq!(at(20), 77.0);
            assert!((21..40).all(|i| at(i) == 0.0), "{method:?}");
            assert!((0..19).all(|i| (at(i) - 1.0).abs() < 1e-12), "{method:?}");
        }
    }
}
