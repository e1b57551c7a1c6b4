//! A steady source in a uniform flow: the continuous equations on smooth data, without error in space or time.

use std::f64::consts::PI;

use cf_diffusion::Law;
use cf_diffusion::exact::source::moving;
use cf_grid::{Grid, Real};
use rayon::prelude::*;
use rustdct::rustfft::num_complex::Complex;
use rustdct::rustfft::{Fft, FftPlanner};

use crate::cells;
use crate::error::SpectralError;
use crate::modes::turn;

/// φ at the centres of cells after `t` \[s\], from φ = 0 and q_C = 0 at the start, under the steady source `rate` in a medium
/// of uniform `velocity` \[m/s\], all axes periodic: the solution of
///
/// ```text
/// φ_t + u·∇φ + ∇·q_C − k_F ∇²φ = W              φ [P], q_C [P m/s], k [m²/s], τ [s], u [m/s], W [P/s]
/// τ (q_C,t + u·∇q_C) + q_C = −k_C ∇φ
/// ```
///
/// for the smoothest W through the centres. A wave e^{iK·x} of the source adds A⁻¹(e^{At} − I)(W, 0), where A is the law's
/// matrix of that wave less iK·u ([`moving`](cf_diffusion::exact::source::moving)); the eigenvalue is K², not that of
/// differences. So the error is what the grid cannot show of the source, e.g. e^{−(πs/h)²/2} for a Gaussian of standard
/// deviation s.
///
/// # Errors
/// Fields of another layout; velocities, `t` or values that are not finite; `t` < 0.
pub fn wake<T: Real, const D: usize>(
    grid: &Grid<D>,
    law: &Law,
    velocity: [f64; D],
    rate: &[T],
    t: f64,
    phi: &mut [T],
) -> Result<(), SpectralError> {
    if !(t.is_finite() && t >= 0.0) {
        return Err(SpectralError::TimeStep(t));
    }
    if let Some(axis) = velocity.iter().position(|u| !u.is_finite()) {
        return Err(SpectralError::Velocity { axis, velocity: velocity[axis] });
    }
    let expected = grid.layout().slots();
    for (what, found) in [("the source", rate.len()), ("phi", phi.len())] {
        if found != expected {
            return Err(SpectralError::Layout { what, expected, found });
        }
    }
    let n = grid.cells();
    let count: usize = n.iter().product();
    let mut real = vec![0.0; count];
    cells::take(grid, |slot| rate[slot], &mut real);
    let mut waves: Vec<Complex<f64>> = real.iter().map(|&w| Complex::new(w, 0.0)).collect();
    let mut planner = FftPlanner::new();
    transform(n.map(|n| planner.plan_fft_forward(n)), &mut waves);
    waves.par_iter_mut().enumerate().for_each(|(place, wave)| {
        let (mut rest, mut lambda, mut turning) = (place, 0.0, 0.0);
        for a in 0..D {
            let m = rest % n[a];
            rest /= n[a];
            let signed = if 2 * m > n[a] { m as f64 - n[a] as f64 } else { m as f64 };
            let k = 2.0 * PI * signed / (n[a] as f64 * grid.h());
            lambda += k * k;
            turning += k * velocity[a];
        }
        *wave *= moving(law, lambda, turning, t)[0] / count as f64;
    });
    transform(n.map(|n| planner.plan_fft_inverse(n)), &mut waves);
    // What is imaginary comes from the shortest wave of an even axis alone.
    real.iter_mut().zip(&waves).for_each(|(x, z)| *x = z.re);
    if real.iter().any(|x| !x.is_finite()) {
        return Err(SpectralError::NotFinite);
    }
    cells::put(grid, &real, phi);
    Ok(())
}

/// Every axis in turn, each while its numbers are contiguous.
fn transform<const D: usize>(axes: [std::sync::Arc<dyn Fft<f64>>; D], data: &mut Vec<Complex<f64>>) {
    let mut work = vec![Complex::default(); data.len()];
    for fft in axes {
        let scratch = || vec![Complex::default(); fft.get_inplace_scratch_len()];
        data.par_chunks_mut(fft.len())
            .with_min_len(16)
            .for_each_init(scratch, |scratch, row| fft.process_with_scratch(row, scratch));
        turn(fft.len(), data, &mut work);
        std::mem::swap(data, &mut work);
    }
}
