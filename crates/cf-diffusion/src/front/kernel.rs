//! Limited upwind transport of one wave along rows, without branches.
//!
//! With nu = speed dt/h, slopes s of the cells and rows counted against the motion,
//!
//! ```text
//! face = w + (1 - |nu|)/2 s              what reaches a face, a mean over the step
//! loss = |nu| (face_out - face_in)       what a cell loses: w_new = w - loss
//! s    = MC(a, b) = sign(a) max(0, min(|a + b|/2, 2 |a|, 2 |b|))   if a b > 0, else 0
//! ```
//!
//! The loss is formed from differences, so that a constant loses nothing, to the bit.

use cf_grid::Real;

use crate::limiter::slope2;

/// The rows `[second, first, own, down]` a wave meets from upwind on, of the five rows in storage order.
#[inline(always)]
fn upwind_first<R: Copy>(forward: bool, rows: [R; 5]) -> [R; 4] {
    if forward { [rows[0], rows[1], rows[2], rows[3]] } else { [rows[4], rows[3], rows[2], rows[1]] }
}

/// What each cell of the middle row loses. `nu` is signed, `weight` = (1 - |nu|)/4 or 0 for first order.
#[inline(always)]
pub(super) fn losses<T: Real>(nu: T, weight: T, rows: [&[T]; 5], loss: &mut [T]) {
    if nu == T::ZERO {
        loss.fill(T::ZERO);
        return;
    }
    let n = loss.len();
    let [second, first, own, down] = upwind_first(nu > T::ZERO, rows).map(|row| &row[..n]);
    let size = nu.abs();
    for i in 0..n {
        let (a, b, c) = (first[i] - second[i], own[i] - first[i], down[i] - own[i]);
        loss[i] = size * (b + weight * (slope2(b, c) - slope2(a, b)));
    }
}

/// The face value minus the value of the cell upwind of it, from that cell's two neighbours.
#[inline(always)]
pub(super) fn rise<T: Real>(weight: T, behind: T, upwind: T, ahead: T) -> T {
    weight * slope2(upwind - behind, ahead - upwind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_of_one_cell_a_step_are_shifts_and_resting_waves_rest() {
        let v = [3.0, -1.0, 4.0, 1.0, -5.0, 9.0];
        let rows: [&[f64]; 5] = std::array::from_fn(|k| &v[k..k + 2]);
        for (nu, expected) in [(1.0, [-1.0, 4.0]), (-1.0, [1.0, -5.0]), (0.0, [4.0, 1.0])] {
            let mut loss = [f64::NAN; 2];
            losses(nu, 0.25 * (1.0 - f64::abs(nu)), rows, &mut loss);
            assert_eq!([v[2] - loss[0], v[3] - loss[1]], expected);
        }
    }

    #[test]
    fn a_line_moves_exactly() {
        let v: Vec<f64> = (0..12).map(|i| 3.0 + 0.5 * f64::from(i)).collect();
        let rows: [&[f64]; 5] = std::array::from_fn(|k| &v[k..k + 8]);
        for nu in [0.3, -0.7] {
            let mut loss = [0.0; 8];
            losses(nu, 0.25 * (1.0 - f64::abs(nu)), rows, &mut loss);
            assert!(loss.iter().all(|l| (l - 0.5 * nu).abs() < 1e-15));
            assert_eq!(rise(0.25, 3.0, 3.5, 4.0), 0.25);
        }
    }
}
