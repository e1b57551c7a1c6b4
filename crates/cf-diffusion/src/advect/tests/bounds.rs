//! No new extrema.

use cf_grid::{CellField, FaceField, Grid, Mask, Real, Sides, Wall};
use nalgebra::SVector;

use super::{noise, noisy, noisy_flux, walls_2d};
use crate::advect::{Advection, Advector};
use crate::medium::{Medium, sample};

#[test]
fn one_dimension_has_no_new_extrema_and_no_more_variation() {
    for cells in [[150, 1], [1, 150]] {
        let grid = Grid::new(cells, 0.01).unwrap();
        let axis = usize::from(cells[0] == 1);
        for (speed, dt) in [(1.0, 0.009), (-1.0, 0.004), (0.3, 0.021)] {
            let mut u = SVector::zeros();
            u[axis] = speed;
            let mut advector = Advector::new(&grid, &Sides::periodic(), None, Advection::Muscl);
            let mut phi = noisy::<f64, 2>(&grid);
            let variation = |phi: &CellField<f64>| {
                let v: Vec<f64> =
                    (0..150).map(|i| phi[grid.layout().slot(if axis == 0 { [i, 0] } else { [0, i] })]).collect();
                (0..150).map(|i| (v[i] - v[(i + 1) % 150]).abs()).sum::<f64>()
            };
            let ((low, high), mut before) = (grid.layout().range(&phi), variation(&phi));
            for _ in 0..50 {
                advector.advect(&mut phi, None, &Medium::Uniform(u), dt).unwrap();
                let now = variation(&phi);
                assert!(now <= before * (1.0 + 1e-14), "{now} {before}");
                before = now;
            }
            let after = grid.layout().range(&phi);
            assert!(after.0 >= low - 1e-15 && after.1 <= high + 1e-15);
        }
    }
}

#[test]
fn semi_lagrangian_steps_of_any_length_stay_within_the_old_values() {
    for sides in walls_2d() {
        for cells in [[16, 12], [5, 1], [1, 3], [2, 3], [1, 1]] {
            let grid = Grid::new(cells, 0.125).unwrap();
            for method in [Advection::Cubic, Advection::Linear] {
                for dt in [0.05, 3.0, 1250.0] {
                    let whirl = |x: SVector<f64, 2>| SVector::from([(9.0 * x[1]).sin(), (7.0 * x[0]).cos()]);
                    for medium in [
                        Medium::Uniform(SVector::from([0.9, -1.0])),
                        Medium::Field(sample::<f32, 2>(&grid, whirl).unwrap()),
                    ] {
                        let mut phi = noisy::<f32, 2>(&grid);
                        let mut q = noisy_flux::<f32, 2>(&grid, &sides);
                        let (low, high) = grid.layout().range(&phi);
                        let (low, high) = sides
                            .walls()
                            .filter_map(|w| w.2.carried_in())
                            .fold((low, high), |(l, h), v| (l.min(v), h.max(v)));
                        Advector::new(&grid, &sides, None, method).advect(&mut phi, Some(&mut q), &medium, dt).unwrap();
                        let now = grid.layout().range(&phi);
                        assert!(now.0 >= low - 1e-6 && now.1 <= high + 1e-6, "{now:?} {low} {high}");
                        assert!(q.axes().iter().all(|q| q.iter().all(|v| v.abs() <= 0.5)));
                    }
                }
            }
        }
    }
}

/// ∫|phi| of what moves can only shrink. A hundred cells a step through a medium of random numbers between obstacles once
/// made 1e12 of it, and infinity in single precision.
#[test]
fn a_strongly_divergent_medium_makes_nothing_grow() {
    fn check<T: Real, const D: usize>(cells: [usize; D], sides: Sides<Wall, D>, masked: bool) {
        let grid = Grid::new(cells, 1.0).unwrap();
        let layout = *grid.layout();
        let mask = masked.then(|| Mask::new(&layout, |c| noise(31 * layout.slot(c)) > 0.25));
        let mut u = FaceField::<T, D>::new(&layout);
        for a in 0..D {
            let periodic = sides.is_periodic(a);
            layout.each_cell(layout.faces_region(a, periodic), |at| {
                let on_wall = !periodic && (at.cell[a] == 0 || at.cell[a] == cells[a]);
                let speed = 200.0 * noise(17 * at.slot() + 5 * a) - 100.0;
                u.axis_mut(a)[at.slot()] = T::of(if on_wall { 0.0 } else { speed });
            });
        }
        let medium = Medium::Field(u);
        let mut phi = noisy::<T, D>(&grid);
        phi.iter_mut().for_each(|phi| *phi -= T::of(0.75));
        let mut advector = Advector::new(&grid, &sides, mask.as_ref(), Advection::Muscl);
        let (before, size) = (layout.sum(&phi), layout.sum_abs(&phi));
        for _ in 0..5 {
            advector.advect(&mut phi, None, &medium, 1.0).unwrap();
        }
        let (after, left) = (layout.sum(&phi), layout.sum_abs(&phi));
        assert!(left <= 1.05 * size, "{} {cells:?} {masked}: {size:.2e} became {left:.2e}", T::NAME);
        assert!((after - before).abs() <= 1e4 * T::EPSILON * size, "{} {cells:?}: {:e}", T::NAME, after - before);
    }
    for masked in [false, true] {
        check::<f32, 2>([9, 7], Sides::all(Wall::CLOSED), masked);
        check::<f32, 2>([70, 5], Sides::periodic(), masked);
        check::<f64, 3>([5, 4, 3], Sides::all(Wall::CLOSED), masked);
        check::<f32, 3>([3, 6, 5], Sides::periodic(), masked);
    }
}
