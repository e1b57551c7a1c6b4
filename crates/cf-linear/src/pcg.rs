//! Preconditioned conjugate gradients on vectors of unit size.
//!
//! Dot products are in `f64`. Constants of a conserving operator are kept out of residuals and corrections
//! (model/diffusion.md 5.6). One iteration costs, besides the preconditioner: A p with p·A p (2 passes), x and r with
//! their norms (6), r·z (2), p (3).

use cf_grid::{Layout, Max, Real, row_dot, row_sum};

use crate::deflate::Deflation;
use crate::level::LevelOperator;

/// Vectors of an iteration, made once.
pub(crate) struct Vectors<T> {
    pub r: Vec<T>,
    pub z: Vec<T>,
    pub p: Vec<T>,
    pub ap: Vec<T>,
}

impl<T: Real> Vectors<T> {
    pub fn new<const D: usize>(layout: &Layout<D>) -> Self {
        let field = || vec![T::ZERO; layout.slots()];
        Self { r: field(), z: field(), p: field(), ap: field() }
    }
}

/// Norms of a residual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Norms {
    /// 2-norm.
    pub two: f64,
    /// Max-norm.
    pub largest: f64,
    /// Max-norm of the solution it belongs to, the measure of the rounding floor.
    pub solution: f64,
}

/// Largest |mean| of a residual, relative to its 2-norm per cell, that is left in it.
const MEAN_LEFT: f64 = 1e-3;

/// z = M r.
pub(crate) trait Preconditioner<T> {
    fn precondition(&mut self, r: &[T], largest: f64, z: &mut [T], scratch: &mut [T]);
}

/// Runs from residual `v.r` (norms `start`) and solution `x` until `done` accepts the norms, or `limit` iterations are
/// made. Returns the iterations.
#[allow(clippy::too_many_arguments)]
pub(crate) fn iterate<T: Real, const D: usize>(
    operator: &LevelOperator<T, D>,
    preconditioner: &mut impl Preconditioner<T>,
    deflation: &Deflation,
    x: &mut [T],
    v: &mut Vectors<T>,
    start: Norms,
    done: impl Fn(Norms) -> bool,
    limit: usize,
) -> usize {
    let layout = operator.layout;
    let cells = layout.cells_region();
    let mut norms = start;
    let mut previous = 0.0;
    for iteration in 0..limit {
        if done(norms) {
            return iteration;
        }
        preconditioner.precondition(&v.r, norms.largest, &mut v.z, &mut v.ap);
        let (rho, means) = inner_product(&layout, deflation, &v.r, &mut v.z);
        if !rho.is_finite() || rho <= 0.0 {
            return iteration;
        }
        let (momentum, mean) = (T::of(if iteration == 0 { 0.0 } else { rho / previous }), T::of(means));
        previous = rho;
        let z = &v.z[..];
        if iteration == 0 {
            // Not multiplied by zero: the old direction may hold anything.
            layout.par_runs(cells, &mut v.p[..], |run, p: &mut [T]| {
                for (p, &z) in p.iter_mut().zip(run.row(z)) {
                    *p = z - mean;
                }
            });
        } else {
            layout.par_runs(cells, &mut v.p[..], |run, p: &mut [T]| {
                for (p, &z) in p.iter_mut().zip(run.row(z)) {
                    *p = (z - mean) + momentum * *p;
                }
            });
        }
        let curvature = operator.apply(&mut v.p, &mut v.ap);
        if !curvature.is_finite() || curvature <= 0.0 {
            return iteration;
        }
        let step = T::of(rho / curvature);
        let (p, ap) = (&v.p[..], &v.ap[..]);
        let (square, sum, (largest, solution)): (f64, f64, (Max, Max)) =
            layout.par_runs(cells, (&mut *x, &mut v.r[..]), |run, (x, r): (&mut [T], &mut [T])| {
                for (x, &p) in x.iter_mut().zip(run.row(p)) {
                    *x += step * p;
                }
                for (r, &ap) in r.iter_mut().zip(run.row(ap)) {
                    *r -= step * ap;
                }
                (row_dot(r, r), row_sum(r), (Max(row_largest(r)), Max(row_largest(x))))
            });
        norms = Norms { two: square.sqrt(), largest: largest.0, solution: solution.0 };
        // Rounding slowly gives the residual a constant part, which no correction can remove.
        let drifted = match deflation {
            Deflation::None => false,
            Deflation::Whole => sum.abs() > MEAN_LEFT * norms.two * (layout.count() as f64).sqrt(),
            Deflation::Components(_) => true,
        };
        if drifted {
            deflation.project(&layout, &mut v.r);
        }
    }
    limit
}

/// Largest absolute value of a row; NaN if any value is NaN.
#[inline(always)]
pub(crate) fn row_largest<T: Real>(r: &[T]) -> f64 {
    // A NaN gets in, and nothing is larger than it.
    let larger = |m: T, v: T| {
        let v = v.abs();
        if v <= m { m } else { v }
    };
    let keep = |m: T, v: T| if m.partial_cmp(&m).is_none() { m } else { larger(m, v) };
    let mut lanes = [T::ZERO; 8];
    let chunks = r.chunks_exact(8);
    let mut largest = chunks.remainder().iter().fold(T::ZERO, |m, &v| keep(m, v));
    for c in chunks {
        for l in 0..8 {
            lanes[l] = keep(lanes[l], c[l]);
        }
    }
    for &l in &lanes {
        largest = keep(largest, l);
    }
    largest.f64()
}

/// Largest absolute value over all cells; NaN if any value is NaN.
pub(crate) fn largest<T: Real, const D: usize>(layout: &Layout<D>, x: &[T]) -> f64 {
    let largest: Max = layout.par_runs(layout.cells_region(), (), |run, ()| Max(row_largest(run.row(x))));
    largest.0
}

/// r·z without the constants of z, and the mean of z to be left out of it (components are projected in place).
fn inner_product<T: Real, const D: usize>(
    layout: &Layout<D>,
    deflation: &Deflation,
    r: &[T],
    z: &mut [T],
) -> (f64, f64) {
    if let Deflation::Components(_) = deflation {
        deflation.project(layout, z);
    }
    let z = &*z;
    let (rz, sum_r, sum_z): (f64, f64, f64) = layout.par_runs(layout.cells_region(), (), |run, ()| {
        let (r, z) = (run.row(r), run.row(z));
        (row_dot(r, z), row_sum(r), row_sum(z))
    });
    match deflation {
        Deflation::Whole => {
            let mean = sum_z / layout.count() as f64;
            (rz - mean * sum_r, mean)
        }
        _ => (rz, 0.0),
    }
}
