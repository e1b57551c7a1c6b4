//! Preconditioned conjugate gradients on vectors of unit size.
//!
//! Dot products are in `f64`. Constants of a conserving operator are kept out of residuals and corrections
//! (model/diffusion.md 5.6). The cycle returns r·z and z·A z; with them p·A p = z·A z - beta² (p·A p before), since
//! successive directions are A-orthogonal (Chronopoulos and Gear 1989), so that neither A p nor its product with p need
//! a sweep of their own. Where beta is less than one, as a multigrid cycle makes it, nothing is lost by cancellation.
//!
//! | sweep | reads | writes | passes |
//! |---|---|---|---|
//! | z = M r | r (twice) | z | 3 and the coarse levels |
//! | p = z + beta p, x += alpha p | z, p, x | p, x | 5 |
//! | r -= alpha A p | p, r | r | 3 |

use cf_grid::{Layout, Max, Real, row_dot, row_sum};

use crate::deflate::Deflation;
use crate::level::LevelOperator;
use crate::multigrid::Cycle;

/// Vectors of an iteration, made once.
pub(crate) struct Vectors<T> {
    pub r: Vec<T>,
    pub p: Vec<T>,
}

impl<T: Real> Vectors<T> {
    pub fn new<const D: usize>(layout: &Layout<D>) -> Self {
        let field = || vec![T::ZERO; layout.slots()];
        Self { r: field(), p: field() }
    }
}

/// Norms of a residual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Norms {
    /// 2-norm.
    pub two: f64,
    /// Max-norm.
    pub largest: f64,
    /// Sum of the residual.
    pub sum: f64,
    /// Max-norm of the solution it belongs to, the measure of the rounding floor.
    pub solution: f64,
}

/// Largest |mean| of a residual, relative to its 2-norm per cell, that is left in it.
const MEAN_LEFT: f64 = 1e-3;

/// Runs from residual `v.r` (norms `start`) and solution `x` until `done` accepts the norms, or `limit` iterations are
/// made. Returns the iterations. `z` holds M r in the precision of M.
#[allow(clippy::too_many_arguments)]
pub(crate) fn iterate<T: Real, Z: Real, const D: usize>(
    operator: &LevelOperator<T, D>,
    cycle: &mut Cycle<'_, Z, D>,
    deflation: &Deflation,
    alpha: f64,
    x: &mut [T],
    v: &mut Vectors<T>,
    z: &mut [Z],
    start: Norms,
    done: impl Fn(Norms) -> bool,
    limit: usize,
) -> usize {
    let layout = operator.layout;
    let mut norms = start;
    // rho and p·A p of the last iteration.
    let mut last: Option<(f64, f64)> = None;
    for iteration in 0..limit {
        if done(norms) {
            return iteration;
        }
        let unit = if Z::NAME == T::NAME || norms.largest == 0.0 { 1.0 } else { norms.largest };
        let products = cycle.run(&v.r, 1.0 / unit, z, deflation);
        let (mut rho, mut curvature, mut mean) = (unit * unit * products.bx, unit * unit * products.xax, 0.0);
        if let Deflation::Whole = deflation {
            mean = unit * products.x / layout.count() as f64;
            rho -= mean * norms.sum;
            curvature -= alpha * layout.count() as f64 * mean * mean;
        }
        let beta = last.map_or(0.0, |(rho_before, _)| rho / rho_before);
        curvature -= last.map_or(0.0, |(_, before)| beta * beta * before);
        if !rho.is_finite() || rho <= 0.0 || !curvature.is_finite() || curvature <= 0.0 {
            return iteration;
        }
        let step = rho / curvature;
        let factors = [unit, mean, beta, step];
        let solution = advance(&layout, deflation, z, factors, last.is_none(), &mut v.p, x);
        last = Some((rho, curvature));
        let step = T::of(step);
        let (square, sum, largest) =
            operator.sweep(&mut v.p, &mut v.r, |ap, r| r - step * ap, |_, r| residual_norms(r));
        norms = Norms { two: square.sqrt(), largest: largest.0, sum, solution };
        // Rounding slowly gives the residual a constant part, which no correction can remove.
        let drifted = match deflation {
            Deflation::None => false,
            Deflation::Whole => sum.abs() > MEAN_LEFT * norms.two * (layout.count() as f64).sqrt(),
            Deflation::Components(_) => true,
        };
        if drifted {
            deflation.project(&layout, &mut v.r);
            norms.sum = 0.0;
        }
    }
    limit
}

/// p = unit z - mean + beta p, x += step p; returns max|x|. `first`: the old p may hold anything.
fn advance<T: Real, Z: Real, const D: usize>(
    layout: &Layout<D>,
    deflation: &Deflation,
    z: &[Z],
    [unit, mean, beta, step]: [f64; 4],
    first: bool,
    p: &mut [T],
    x: &mut [T],
) -> f64 {
    let cells = layout.cells_region();
    let [unit, mean, beta, step] = [unit, mean, beta, step].map(T::of);
    let same = T::NAME == Z::NAME;
    let turn = |z: &[Z], p: &mut [T]| {
        let new = |z: Z| {
            let z = T::of(z.f64());
            if same { z - mean } else { unit * z - mean }
        };
        if first {
            p.iter_mut().zip(z).for_each(|(p, &z)| *p = new(z));
        } else {
            p.iter_mut().zip(z).for_each(|(p, &z)| *p = new(z) + beta * *p);
        }
    };
    let go = |p: &[T], x: &mut [T]| {
        x.iter_mut().zip(p).for_each(|(x, &p)| *x += step * p);
        Max(row_largest(x))
    };
    let largest = if let (false, Deflation::Components(_)) = (same, deflation) {
        // What single precision left of the constants would stay in x.
        layout.par_runs(cells, &mut *p, |run, p: &mut [T]| turn(run.row(z), p));
        deflation.project(layout, p);
        let p = &*p;
        layout.par_runs(cells, x, |run, x: &mut [T]| go(run.row(p), x))
    } else {
        layout.par_runs(cells, (p, x), |run, (p, x): (&mut [T], &mut [T])| {
            pulp::Arch::new().dispatch(|| {
                turn(run.row(z), p);
                go(p, x)
            })
        })
    };
    largest.0
}

/// Square, sum and largest entry of a row of a residual.
#[inline(always)]
pub(crate) fn residual_norms<T: Real>(r: &[T]) -> (f64, f64, Max) {
    (row_dot(r, r), row_sum(r), Max(row_largest(r)))
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
