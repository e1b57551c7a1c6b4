//! Flows with known solutions, for checks. All are sampled as discrete curls: free of divergence
//! to round-off.

use cf_diffusion::MediumError;
use cf_diffusion::exact::bessel::j0;
use cf_diffusion::medium::{stream_function, vector_potential};
use cf_grid::{FaceField, Grid, Real};
use nalgebra::SVector;

/// Taylor and Green's vortices u = (cos x sin y, -sin x cos y) on a box of 2 pi, carried along by a stream `drift` for a
/// time: u(x - V t) + V. Exact for Euler's equations.
pub fn taylor_green<T: Real>(grid: &Grid<2>, drift: [f64; 2], time: f64) -> Result<FaceField<T, 2>, MediumError> {
    stream_function(grid, |x| {
        let moved = [x[0] - drift[0] * time, x[1] - drift[1] * time];
        -moved[0].cos() * moved[1].cos() + drift[0] * x[1] - drift[1] * x[0]
    })
}

/// The start of the 3D vortices, u = (sin x cos y cos z, -cos x sin y cos z, 0).
pub fn taylor_green_3d<T: Real>(grid: &Grid<3>) -> Result<FaceField<T, 3>, MediumError> {
    vector_potential(grid, |x| SVector::from([0.0, 0.0, x[0].sin() * x[1].sin() * x[2].cos()]))
}

/// The first zero of J1.
const B: f64 = 3.831_705_970_207_512;

/// J1 for |x| up to about 10.
fn j1(x: f64) -> f64 {
    let (mut term, mut sum) = (0.5 * x, 0.5 * x);
    for k in 1..40 {
        term *= -0.25 * x * x / (k as f64 * (k + 1) as f64);
        sum += term;
    }
    sum
}

/// Lamb and Chaplygin's dipole of `radius` \[m\] at `center` \[m\] in fluid at rest, which moves along x at `speed` \[m/s\]
/// without changing its shape.
pub fn lamb_chaplygin<T: Real>(
    grid: &Grid<2>,
    center: [f64; 2],
    radius: f64,
    speed: f64,
) -> Result<FaceField<T, 2>, MediumError> {
    stream_function(grid, |x| {
        let (dx, dy) = (x[0] - center[0], x[1] - center[1]);
        let r = dx.hypot(dy);
        let co_moving = if r < radius {
            // J1(b r/R)/r is finite in the middle.
            let over_r = if r > 0.0 { j1(B * r / radius) / r } else { 0.5 * B / radius };
            -2.0 * speed * radius / (B * j0(B)) * over_r
        } else {
            -speed * (1.0 - (radius / r).powi(2))
        };
        (co_moving + speed) * dy
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bessel_functions_of_tables() {
        assert!((j1(1.0) - 0.440_050_585_744_933_5).abs() < 1e-15);
        assert!(j1(B).abs() < 1e-14);
    }

    #[test]
    fn the_dipole_is_smooth_across_its_edge() {
        let grid = Grid::new([64, 64], 1.0 / 16.0).unwrap();
        let u = lamb_chaplygin::<f64>(&grid, [2.0, 2.0], 1.0, 1.0).unwrap();
        // On the axis: the fluid moves with the edge, u_x = U there.
        let at = |i: usize| 0.5 * (u.axis(0)[grid.layout().slot([i, 31])] + u.axis(0)[grid.layout().slot([i, 32])]);
        assert!((at(48) - 1.0).abs() < 1e-2, "{}", at(48));
        assert!((at(16) - 1.0).abs() < 1e-2, "{}", at(16));
    }
}
