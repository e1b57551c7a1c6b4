//! Transport of the slow flux.

use std::f64::consts::TAU;

use cf_grid::{CellField, FaceField, Grid, Mask, Sides};
use nalgebra::SVector;

use super::{METHODS, noisy, noisy_flux, walls_2d};
use crate::advect::{Advection, Advector};
use crate::medium::{Medium, sample};

#[test]
fn faces_without_flux_stay_exactly_zero_and_bounded() {
    for sides in walls_2d() {
        let grid = Grid::new([70, 9], 0.125).unwrap();
        let mask = Mask::new(grid.layout(), |c| !(20..23).contains(&c[0]) || c[1] > 4);
        for mask in [None, Some(&mask)] {
            for method in METHODS {
                let mut q = noisy_flux::<f64, 2>(&grid, &sides);
                if let Some(mask) = mask {
                    for a in 0..2 {
                        let sites = crate::advect::Sites::faces(grid.layout(), &sides, a);
                        let old = q.axis(a).to_vec();
                        grid.layout().par_region(sites.region, q.axis_mut(a), |at| {
                            if sites.open(mask.fluid(), at.cell) { old[at.slot()] } else { 0.0 }
                        });
                    }
                }
                let zeros: Vec<Vec<bool>> = q.axes().iter().map(|q| q.iter().map(|&v| v == 0.0).collect()).collect();
                let mut advector = Advector::new(&grid, &sides, mask, method);
                let whirl = |x: SVector<f64, 2>| SVector::from([0.4 + (9.0 * x[1]).sin(), (7.0 * x[0]).cos()]);
                for medium in
                    [Medium::Uniform(SVector::from([0.9, -1.0])), Medium::Field(sample(&grid, whirl).unwrap())]
                {
                    for _ in 0..3 {
                        advector.advect(&mut noisy(&grid), Some(&mut q), &medium, 0.09).unwrap();
                    }
                }
                for a in 0..2 {
                    for (slot, &v) in q.axis(a).iter().enumerate() {
                        assert!(!zeros[a][slot] || v == 0.0, "{method:?} face {a} slot {slot}: {v}");
                        assert!(v.abs() <= 0.5 + 1e-12, "{method:?} {v}");
                    }
                }
            }
        }
    }
}

#[test]
fn the_flux_moves_with_the_medium() {
    // A bump of q_x and q_y in a periodic box moves as phi does, in both methods of higher order.
    for method in [Advection::Muscl, Advection::Cubic] {
        let grid = Grid::new([40, 30], 0.025).unwrap();
        let shape = |x: SVector<f64, 2>| (TAU * x[0]).sin() * (TAU * x[1] / 0.75).cos();
        let velocity = SVector::from([0.5, -0.25]);
        for medium in [Medium::Uniform(velocity), Medium::Field(sample::<f64, 2>(&grid, |_| velocity).unwrap())] {
            let mut q = FaceField::new(grid.layout());
            let mut phi = CellField::new(grid.layout());
            for a in 0..2 {
                grid.layout().par_cells(q.axis_mut(a), |at| shape(grid.face(a, at.cell)));
            }
            let mut advector = Advector::new(&grid, &Sides::periodic(), None, method);
            for _ in 0..20 {
                advector.advect(&mut phi, Some(&mut q), &medium, 0.02).unwrap();
            }
            for a in 0..2 {
                let mut error: f64 = 0.0;
                for j in 0..30 {
                    for i in 0..40 {
                        let exact = shape(grid.face(a, [i, j]) - velocity * 0.4);
                        error = error.max((q.axis(a)[grid.layout().slot([i, j])] - exact).abs());
                    }
                }
                assert!(error < 0.06, "{method:?} {error}");
            }
        }
    }
}
