//! Media given by a formula, as velocities on faces without divergence.

use crate::spec::Flow;
use cf_diffusion::MediumError;
use cf_diffusion::medium::{stream_function, vector_potential};
use cf_grid::{FaceField, Grid, Real};
use std::f64::consts::PI;

/// Makes a velocity \[m/s\] at a time \[s\].
pub(super) type MakeFlow<T, const D: usize> = fn(&Grid<D>, &Flow, f64) -> Result<FaceField<T, D>, MediumError>;

/// Whether a flow changes with time.
pub(super) fn changes(flow: &Flow) -> bool {
    matches!(flow, Flow::Deformation { .. })
}

/// In two dimensions, from a stream function.
pub(super) fn plane<T: Real>(grid: &Grid<2>, flow: &Flow, time: f64) -> Result<FaceField<T, 2>, MediumError> {
    match flow {
        Flow::Rotation { center, rate } => {
            stream_function(grid, |x| -0.5 * rate * ((x[0] - center[0]).powi(2) + (x[1] - center[1]).powi(2)))
        }
        Flow::Deformation { period } => {
            let (origin, extent) = (grid.origin(), grid.extent());
            let size = extent[0] * extent[1] / PI * turn(time, *period);
            stream_function(grid, |x| {
                let bump = |axis: usize| (PI * (x[axis] - origin[axis]) / extent[axis]).sin().powi(2);
                size * bump(0) * bump(1)
            })
        }
    }
}

/// In three dimensions, from a vector potential.
pub(super) fn space<T: Real>(grid: &Grid<3>, flow: &Flow, time: f64) -> Result<FaceField<T, 3>, MediumError> {
    match flow {
        Flow::Rotation { center, rate } => vector_potential(grid, |x| {
            let square = (x[0] - center[0]).powi(2) + (x[1] - center[1]).powi(2);
            [0.0, 0.0, -0.5 * rate * square].into()
        }),
        Flow::Deformation { period } => {
            let (origin, extent) = (grid.origin(), grid.extent());
            let size = extent[0] / PI * turn(time, *period);
            vector_potential(grid, |x| {
                let angle = |axis: usize| PI * (x[axis] - origin[axis]) / extent[axis];
                let bump = |axis: usize| angle(axis).sin().powi(2);
                let wave = |axis: usize| (2.0 * angle(axis)).sin();
                [0.0, -size * extent[2] * bump(0) * wave(1) * bump(2), size * extent[1] * bump(0) * bump(1) * wave(2)]
                    .into()
            })
        }
    }
}

/// The factor in time, which returns everything.
fn turn(time: f64, period: f64) -> f64 {
    (PI * time / period).cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cf_diffusion::Medium;
    use cf_grid::{Sides, Wall};

    #[test]
    fn a_rotation_turns_counter_clockwise() {
        let grid = Grid::<2>::new([8, 8], 0.125).unwrap();
        let center = [0.5, 0.5].into_iter().collect();
        let flow = Flow::Rotation { center, rate: 2.0 };
        let u = plane::<f64>(&grid, &flow, 0.0).unwrap();
        // At x = 1, y = 0.5625: u = (-2·0.0625, 2·0.5).
        let slot = grid.layout().slot([8, 4]);
        assert!((u.axis(0)[slot] + 0.125).abs() < 1e-12);
        let slot = grid.layout().slot([7, 4]);
        assert!((u.axis(1)[slot] - 2.0 * 0.4375).abs() < 1e-12);
    }

    #[test]
    fn the_deformation_passes_no_wall_and_is_as_fast_as_said() {
        let closed = Wall::CLOSED;
        let flow = Flow::Deformation { period: 2.0 };
        let grid = Grid::<2>::new([32, 16], 1.0 / 16.0).unwrap();
        let u = Medium::Field(plane::<f64>(&grid, &flow, 0.0).unwrap());
        u.check(&grid, &Sides::all(closed)).unwrap();
        assert!((u.max_speed(&grid, &Sides::all(closed)).unwrap()[0] / 2.0 - 1.0).abs() < 0.05);
        let grid = Grid::<3>::new([16; 3], 1.0 / 16.0).unwrap();
        let u = Medium::Field(space::<f64>(&grid, &flow, 0.0).unwrap());
        u.check(&grid, &Sides::all(closed)).unwrap();
        assert!((u.max_speed(&grid, &Sides::all(closed)).unwrap()[0] / 2.0 - 1.0).abs() < 0.05);
        assert!(u.divergence(&grid, &Sides::all(closed)).unwrap() < 1e-11);
        let still = Medium::Field(plane::<f64>(&Grid::<2>::new([4, 4], 0.25).unwrap(), &flow, 1.0).unwrap());
        assert!(still.max_speed(&Grid::<2>::new([4, 4], 0.25).unwrap(), &Sides::all(closed)).unwrap().max() < 1e-12);
    }
}
