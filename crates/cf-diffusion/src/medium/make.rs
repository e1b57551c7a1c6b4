//! Velocities on faces from functions of place.

use cf_grid::{FaceField, Grid, Real};
use nalgebra::SVector;

use super::MediumError;
use super::survey::all_finite;

/// The velocity u(x) \[m/s\] at the centres x \[m\] of all faces, walls included.
pub fn sample<T: Real, const D: usize>(
    grid: &Grid<D>,
    velocity: impl Fn(SVector<f64, D>) -> SVector<f64, D> + Sync,
) -> Result<FaceField<T, D>, MediumError> {
    on_faces(grid, |axis, cell| velocity(grid.face(axis, cell))[axis])
}

/// A velocity without divergence from a stream function ψ \[m²/s\] sampled at the cell corners x \[m\]:
/// u_x = ∂ψ/∂y, u_y = −∂ψ/∂x, as differences over one cell edge.
///
/// max|div u| is round-off in `T`. On periodic axes ψ must be periodic up to a linear function.
pub fn stream_function<T: Real>(
    grid: &Grid<2>,
    psi: impl Fn(SVector<f64, 2>) -> f64 + Sync,
) -> Result<FaceField<T, 2>, MediumError> {
    let corner = |i: [usize; 2]| psi(grid.origin() + SVector::from(i).map(|i: usize| i as f64 * grid.h()));
    on_faces(grid, |axis, [i, j]| match axis {
        0 => (corner([i, j + 1]) - corner([i, j])) / grid.h(),
        _ => (corner([i, j]) - corner([i + 1, j])) / grid.h(),
    })
}

/// A velocity without divergence from a vector potential A \[m²/s\] sampled at the middles x \[m\] of the cell edges:
/// u = curl A, component by component as the circulation around the face.
///
/// max|div u| is round-off in `T`. On periodic axes A must be periodic up to a linear function.
pub fn vector_potential<T: Real>(
    grid: &Grid<3>,
    potential: impl Fn(SVector<f64, 3>) -> SVector<f64, 3> + Sync,
) -> Result<FaceField<T, 3>, MediumError> {
    // Component `along` at the middle of the edge that starts at a corner and runs along it.
    let edge = |along: usize, corner: [usize; 3]| {
        let mut at = SVector::from(corner).map(|i: usize| i as f64);
        at[along] += 0.5;
        potential(grid.origin() + at * grid.h())[along]
    };
    on_faces(grid, |axis, corner| {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let up = |a: usize| std::array::from_fn(|i| corner[i] + usize::from(i == a));
        ((edge(c, up(b)) - edge(c, corner)) - (edge(b, up(c)) - edge(b, corner))) / grid.h()
    })
}

fn on_faces<T: Real, const D: usize>(
    grid: &Grid<D>,
    value: impl Fn(usize, [usize; D]) -> f64 + Sync,
) -> Result<FaceField<T, D>, MediumError> {
    let layout = grid.layout();
    let mut u = FaceField::new(layout);
    for axis in 0..D {
        let region = layout.faces_region(axis, false);
        layout.par_region(region, u.axis_mut(axis), |at| T::of(value(axis, at.cell)));
        all_finite(layout, region, axis, u.axis(axis))?;
    }
    Ok(u)
}
