//! Norms and sums of rows, each formed in one pass.

use cf_grid::{Layout, Max, Real, array};

/// Numbers taken at once.
pub(crate) const BLOCK: usize = 16;

/// Norms of a residual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Norms {
    /// 2-norm.
    pub two: f64,
    /// Max-norm.
    pub largest: f64,
    /// Sum of the residual.
    pub sum: f64,
    /// Max-norm of the solution it belongs to.
    pub solution: f64,
    /// 2-norm and max-norm of diagonal · solution, the measure of the rounding floor, where they were formed.
    pub weighted: Option<[f64; 2]>,
}

/// Norms of a residual whose solution is zero.
pub(crate) fn norms<T: Real, const D: usize>(layout: &Layout<D>, r: &[T]) -> Norms {
    let (square, sum, largest): (f64, f64, Max) = layout.par_runs(
        layout.cells_region(),
        (),
        #[inline(always)]
        |run, ()| residual_norms(run.row(r)),
    );
    Norms { two: square.sqrt(), largest: largest.0, sum, solution: 0.0, weighted: None }
}

/// Square, sum and largest entry of a row of a residual.
#[inline(always)]
pub(crate) fn residual_norms<T: Real>(r: &[T]) -> (f64, f64, Max) {
    norms_of_row::<T, true>(r)
}

/// The same with the lanes of a row summed in the precision of `T`, in half the time for `f32`: enough to stop by, and to
/// notice that a constant drifts in.
#[inline(always)]
pub(crate) fn running_norms<T: Real>(r: &[T]) -> (f64, f64, Max) {
    norms_of_row::<T, false>(r)
}

#[inline(always)]
fn norms_of_row<T: Real, const EXACT: bool>(r: &[T]) -> (f64, f64, Max) {
    let (blocks, rest) = r.as_chunks::<BLOCK>();
    let (mut squares, mut sums, mut largest) = ([0.0; BLOCK], [0.0; BLOCK], [T::ZERO; BLOCK]);
    let mut rough = [[T::ZERO; BLOCK]; 2];
    for r in blocks {
        if EXACT {
            for k in 0..BLOCK {
                squares[k] += r[k].f64() * r[k].f64();
                sums[k] += r[k].f64();
            }
        } else {
            for k in 0..BLOCK {
                rough[0][k] += r[k] * r[k];
                rough[1][k] += r[k];
            }
        }
        largest = array(
            #[inline(always)]
            |k| r[k].abs().max(largest[k]),
        );
    }
    let (mut square, mut sum) = (squares.iter().sum::<f64>(), sums.iter().sum::<f64>());
    let [rough_square, rough_sum] = rough.map(|lanes| lanes.iter().map(|v| v.f64()).sum::<f64>());
    (square, sum) = (square + rough_square, sum + rough_sum);
    let mut most = largest.iter().fold(T::ZERO, |m, v| m.max(*v));
    for &v in rest {
        square += v.f64() * v.f64();
        sum += v.f64();
        most = v.abs().max(most);
    }
    // Comparisons pass over a NaN, squares do not.
    let most = if square.is_finite() { most.f64() } else { row_largest(r) };
    (square, sum, Max(most))
}

/// The largest absolute value of what it has taken; NaN if any value was.
#[derive(Clone, Copy)]
pub(crate) struct Largest<T> {
    lanes: [T; BLOCK],
    /// Comparisons pass over a NaN, which the sum of zeros finds: 0 · NaN = 0 · infinity = NaN.
    zeros: [T; BLOCK],
}

impl<T: Real> Default for Largest<T> {
    fn default() -> Self {
        Self { lanes: [T::ZERO; BLOCK], zeros: [T::ZERO; BLOCK] }
    }
}

impl<T: Real> Largest<T> {
    #[inline(always)]
    pub fn take(&mut self, values: &[T; BLOCK]) {
        let (lanes, zeros) = (self.lanes, self.zeros);
        self.lanes = array(
            #[inline(always)]
            |k| values[k].abs().max(lanes[k]),
        );
        self.zeros = array(
            #[inline(always)]
            |k| zeros[k] + T::ZERO * values[k],
        );
    }

    /// With the last, incomplete block.
    #[inline(always)]
    pub fn end(mut self, rest: &[T]) -> f64 {
        for (k, &v) in rest.iter().enumerate() {
            self.lanes[k] = v.abs().max(self.lanes[k]);
            self.zeros[k] += T::ZERO * v;
        }
        let largest = self.lanes.iter().fold(T::ZERO, |m, v| m.max(*v)).f64();
        // Infinity is larger than any number; NaN beside it does not matter.
        let clean = self.zeros.iter().all(|&z| z == T::ZERO);
        if clean || largest == f64::INFINITY { largest } else { f64::NAN }
    }
}

/// Largest absolute value of a row; NaN if any value is NaN and none infinite.
#[inline(always)]
pub(crate) fn row_largest<T: Real>(r: &[T]) -> f64 {
    let (blocks, rest) = r.as_chunks::<BLOCK>();
    let mut largest = Largest::default();
    for r in blocks {
        largest.take(r);
    }
    largest.end(rest)
}

/// Largest absolute value over all cells; NaN if any value is NaN and none infinite.
pub(crate) fn largest<T: Real, const D: usize>(layout: &Layout<D>, x: &[T]) -> f64 {
    let largest: Max = layout.par_runs(
        layout.cells_region(),
        (),
        #[inline(always)]
        |run, ()| Max(row_largest(run.row(x))),
    );
    largest.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_is_found_wherever_it_is_and_nan_is_not_lost() {
        for n in [1, 3, 16, 17, 40, 64] {
            for at in 0..n {
                let mut r = vec![1.0f32; n];
                r[at] = -3.0;
                assert_eq!(row_largest(&r), 3.0);
                let (square, sum, largest) = residual_norms(&r);
                assert_eq!((square, sum, largest.0), (n as f64 + 8.0, n as f64 - 4.0, 3.0));
                r[at] = f32::NAN;
                assert!(row_largest(&r).is_nan() && residual_norms(&r).2.0.is_nan(), "{n} {at}");
                r[at] = f32::NEG_INFINITY;
                assert_eq!((row_largest(&r), residual_norms(&r).2.0), (f64::INFINITY, f64::INFINITY));
            }
        }
        // Squares that overflow are no NaN.
        assert_eq!(residual_norms(&[1e200, -2e200]).2.0, 2e200);
    }
}
