//! Chebyshev iteration on the diagonally scaled operator: no dot products, the count known beforehand.
//!
//! With J x the Jacobi step and rho its spectral radius bound: x_{k+1} = omega_{k+1} (J x_k - x_{k-1}) + x_{k-1},
//! omega_1 = 1, omega_2 = 2/(2 - rho²), omega_{k+1} = 1/(1 - rho² omega_k/4). Four passes an iteration: x_k, b, x_{k-1},
//! and the store over x_{k-1}.

use cf_grid::Real;

use crate::level::LevelOperator;

/// Makes `count` more iterations on A x = b. `x` is the current and `other` the previous iterate; both are zero at the
/// start, when `omega` is `None`. Leaves the newest iterate in `x` and returns its omega.
pub(crate) fn iterate<T: Real, const D: usize>(
    operator: &LevelOperator<T, D>,
    b: &[T],
    x: &mut [T],
    other: &mut [T],
    radius: f64,
    mut omega: Option<f64>,
    count: usize,
) -> Option<f64> {
    let (mut new, mut old) = (&mut *x, &mut *other);
    for _ in 0..count {
        let next = match omega {
            None => 1.0,
            Some(1.0) => 2.0 / (2.0 - radius * radius),
            Some(w) => 1.0 / (1.0 - 0.25 * radius * radius * w),
        };
        let w = T::of(next);
        operator.jacobi(b, new, old, |j, old| w * (j - old) + old);
        std::mem::swap(&mut new, &mut old);
        omega = Some(next);
    }
    if count % 2 == 1 {
        x.swap_with_slice(other);
    }
    omega
}

/// Bound of the spectral radius of the Jacobi step: W/(alpha + W) with W the largest sum of a cell's conductances.
pub(crate) fn radius(alpha: f64, conductance: f64) -> f64 {
    conductance / (alpha + conductance)
}

/// Iterations that reduce the error by `reduction`: N = acosh(1/reduction)/acosh(1/radius).
pub(crate) fn count(radius: f64, reduction: f64) -> usize {
    if radius == 0.0 {
        return 1;
    }
    let count = (1.0 / reduction.clamp(1e-300, 1.0)).acosh() / (1.0 / radius).acosh();
    if count.is_finite() { (count.ceil() as usize).max(1) } else { usize::MAX }
}
