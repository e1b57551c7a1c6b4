//! Reductions whose result does not depend on the number of threads: partial results meet in a tree fixed by sizes.

use crate::{Layout, Real};

/// A partial result of a loop. `merge` is called in a fixed order.
pub trait Reduce: Default + Send {
    /// Combines with the partial result of the cells that follow.
    fn merge(self, next: Self) -> Self;
}

impl Reduce for () {
    fn merge(self, _: ()) {}
}

/// A sum.
impl Reduce for f64 {
    fn merge(self, next: f64) -> f64 {
        self + next
    }
}

/// A count.
impl Reduce for usize {
    fn merge(self, next: usize) -> usize {
        self + next
    }
}

/// A maximum of non-negative numbers; NaN wins.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Max(pub f64);

impl Reduce for Max {
    fn merge(self, next: Max) -> Max {
        if next.0 > self.0 || next.0.is_nan() { next } else { self }
    }
}

impl<A: Reduce, B: Reduce> Reduce for (A, B) {
    fn merge(self, next: Self) -> Self {
        (self.0.merge(next.0), self.1.merge(next.1))
    }
}

impl<A: Reduce, B: Reduce, C: Reduce> Reduce for (A, B, C) {
    fn merge(self, next: Self) -> Self {
        (self.0.merge(next.0), self.1.merge(next.1), self.2.merge(next.2))
    }
}

const LANES: usize = 8;

/// Dot product of two rows, accumulated in `f64` in eight fixed lanes.
#[inline(always)]
pub fn row_dot<T: Real>(a: &[T], b: &[T]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (&a[..n], &b[..n]);
    let mut lanes = [0.0; LANES];
    let (ac, bc) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let tail: f64 = ac.remainder().iter().zip(bc.remainder()).map(|(x, y)| x.f64() * y.f64()).sum();
    for (x, y) in ac.zip(bc) {
        for l in 0..LANES {
            lanes[l] += x[l].f64() * y[l].f64();
        }
    }
    lanes.iter().sum::<f64>() + tail
}

/// Sum of a row, accumulated in `f64` in eight fixed lanes.
#[inline(always)]
pub fn row_sum<T: Real>(a: &[T]) -> f64 {
    let mut lanes = [0.0; LANES];
    let chunks = a.chunks_exact(LANES);
    let tail: f64 = chunks.remainder().iter().map(|x| x.f64()).sum();
    for x in chunks {
        for l in 0..LANES {
            lanes[l] += x[l].f64();
        }
    }
    lanes.iter().sum::<f64>() + tail
}

impl<const D: usize> Layout<D> {
    /// Sum over all cells, in `f64`.
    pub fn sum<T: Real>(&self, x: &[T]) -> f64 {
        self.par_runs(self.cells_region(), (), |run, ()| row_sum(run.row(x)))
    }

    /// Dot product over all cells, in `f64`.
    pub fn dot<T: Real>(&self, x: &[T], y: &[T]) -> f64 {
        self.par_runs(self.cells_region(), (), |run, ()| row_dot(run.row(x), run.row(y)))
    }

    /// Largest absolute value over all cells; NaN if any value is NaN.
    pub fn max_abs<T: Real>(&self, x: &[T]) -> f64 {
        let max: Max = self.par_runs(self.cells_region(), (), |run, ()| {
            run.row(x).iter().fold(Max(0.0), |m, v| m.merge(Max(v.f64().abs())))
        });
        max.0
    }

    /// Sum of absolute values over all cells, in `f64`.
    pub fn sum_abs<T: Real>(&self, x: &[T]) -> f64 {
        self.par_runs(self.cells_region(), (), |run, ()| run.row(x).iter().map(|v| v.f64().abs()).sum::<f64>())
    }

    /// Smallest and largest value over all cells; NaN values are passed over.
    pub fn range<T: Real>(&self, x: &[T]) -> (f64, f64) {
        let range: Range = self.par_runs(self.cells_region(), (), |run, ()| {
            run.row(x).iter().fold(Range::default(), |r, v| r.merge(Range(v.f64(), v.f64())))
        });
        (range.0, range.1)
    }
}

struct Range(f64, f64);

impl Default for Range {
    fn default() -> Self {
        Self(f64::INFINITY, f64::NEG_INFINITY)
    }
}

impl Reduce for Range {
    fn merge(self, next: Self) -> Self {
        Self(self.0.min(next.0), self.1.max(next.1))
    }
}
