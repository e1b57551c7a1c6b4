//! Preconditioned conjugate gradients on vectors of unit size.
//!
//! Dot products are in `f64`. Constants of a conserving operator are kept out of residuals and corrections. The cycle returns r·z and z·A z; with them p·A p = z·A z - beta² (p·A p before), since
//! successive directions are A-orthogonal (Chronopoulos and Gear 1989), so that neither A p nor its product with p need
//! a sweep of their own. Where beta is less than one, as a multigrid cycle makes it, nothing is lost by cancellation.
//!
//! | sweep | reads | writes | passes |
//! |---|---|---|---|
//! | z = M r | r (twice) | z | 3 and the coarse levels |
//! | p = z + beta p, x += alpha p | z, p, x | p, x | 5 |
//! | r -= alpha A p | p, r | r | 3 |

use cf_grid::{Layout, Max, Real, array, inlined};

use crate::deflate::Deflation;
use crate::level::LevelOperator;
use crate::multigrid::Cycle;
use crate::norms::{BLOCK, Largest, Norms, residual_norms, row_largest};

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

/// Largest |mean| of a residual, relative to its 2-norm per cell, that is left in it.
const MEAN_LEFT: f64 = 1e-3;

/// Runs from residual `v.r` (norms `start`) and solution `x` until `done` accepts the norms, or `limit` iterations are
/// made. A `fresh` x may hold anything and counts as zero. Returns the iterations. `z` holds M r in the precision of M.
#[allow(clippy::too_many_arguments)]
pub(crate) fn iterate<T: Real, Z: Real, const D: usize>(
    operator: &LevelOperator<T, D>,
    cycle: &mut Cycle<'_, Z, D>,
    deflation: &Deflation,
    alpha: f64,
    x: &mut [T],
    fresh: bool,
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
        let solution = advance(&layout, deflation, z, factors, [last.is_none(), fresh && last.is_none()], &mut v.p, x);
        last = Some((rho, curvature));
        let step = T::of(step);
        let (square, sum, largest) = operator.sweep(
            &mut v.p,
            &mut v.r,
            #[inline(always)]
            move |ap, r| r - step * ap,
            #[inline(always)]
            |_, r| residual_norms(r),
        );
        norms = Norms { two: square.sqrt(), largest: largest.0, sum, solution, weighted: None };
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

/// p = unit z - mean + beta p, x += step p; returns max|x|. The old p and the old x of
/// the first iteration may hold anything.
fn advance<T: Real, Z: Real, const D: usize>(
    layout: &Layout<D>,
    deflation: &Deflation,
    z: &[Z],
    [unit, mean, beta, step]: [f64; 4],
    [first, fresh]: [bool; 2],
    p: &mut [T],
    x: &mut [T],
) -> f64 {
    let cells = layout.cells_region();
    let [unit, mean, beta, step] = [unit, mean, beta, step].map(T::of);
    let same = T::NAME == Z::NAME;
    let turn = inlined(
        #[inline(always)]
        move |z: Z, p: T| {
            let z = T::of(z.f64());
            let z = if same { z - mean } else { unit * z - mean };
            if first { z } else { z + beta * p }
        },
    );
    let go = inlined(
        #[inline(always)]
        move |p: T, x: T| if fresh { step * p } else { x + step * p },
    );
    let largest = if let (false, Deflation::Components(_)) = (same, deflation) {
        // What single precision left of the constants would stay in x.
        layout.par_runs(
            cells,
            &mut *p,
            #[inline(always)]
            |run, p: &mut [T]| {
                for (p, &z) in p.iter_mut().zip(run.row(z)) {
                    *p = turn(z, *p);
                }
            },
        );
        deflation.project(layout, p);
        let p = &*p;
        layout.par_runs(
            cells,
            x,
            #[inline(always)]
            |run, x: &mut [T]| {
                for (x, &p) in x.iter_mut().zip(run.row(p)) {
                    *x = go(p, *x);
                }
                Max(row_largest(x))
            },
        )
    } else {
        layout.par_runs(
            cells,
            (p, x),
            #[inline(always)]
            |run, (p, x): (&mut [T], &mut [T])| {
                let (z, last_z) = run.row(z).as_chunks::<BLOCK>();
                let (p, last_p) = p.as_chunks_mut::<BLOCK>();
                let (x, last_x) = x.as_chunks_mut::<BLOCK>();
                let mut largest = Largest::default();
                for ((z, p), x) in z.iter().zip(p).zip(x) {
                    let (old, at) = (*p, *x);
                    let new: [T; BLOCK] = array(
                        #[inline(always)]
                        |k| turn(z[k], old[k]),
                    );
                    let there: [T; BLOCK] = array(
                        #[inline(always)]
                        |k| go(new[k], at[k]),
                    );
                    (*p, *x) = (new, there);
                    largest.take(&there);
                }
                for ((&z, p), x) in last_z.iter().zip(last_p).zip(&mut *last_x) {
                    *p = turn(z, *p);
                    *x = go(*p, *x);
                }
                Max(largest.end(last_x))
            },
        )
    };
    largest.0
}
