//! Preconditioned conjugate gradients on vectors of unit size.
//!
//! Dot products are in `f64`. Constants of a conserving operator are kept out of residuals and corrections. The cycle returns r·z and z·A z; with them p·A p = z·A z - beta² (p·A p before), since
//! successive directions are A-orthogonal (Chronopoulos and Gear 1989), so that neither A p nor its product with p need
//! a sweep of their own. Where beta is less than one, as a multigrid cycle makes it, nothing is lost by cancellation.
//!
//! | sweep | reads | writes | passes |
//! |---|---|---|---|
//! | z = M r | r (twice) | z | 3 and the coarse levels |
//! | p = z + beta p | z, p | p | 3, every other time |
//! | p' = z + beta p, x += alpha p + alpha' p' | z, p, x | p, x | 5, the other times |
//! | r -= alpha A p | p, r | r | 3 |
//!
//! Both steps of two directions are known before the second one is formed, so that x moves every other time.

use cf_grid::{CellField, Layout, Max, Real, array, inlined};

use crate::deflate::Deflation;
use crate::level::LevelOperator;
use crate::multigrid::Cycle;
use crate::norms::{BLOCK, Largest, Norms, row_largest, running_norms};

/// Vectors of an iteration, made once or fetched for each solve.
pub(crate) struct Vectors<T> {
    pub r: CellField<T>,
    pub p: CellField<T>,
}

impl<T: Real> Vectors<T> {
    pub fn new<const D: usize>(layout: &Layout<D>) -> Self {
        Self { r: CellField::new(layout), p: CellField::new(layout) }
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
    // The step along p that x has not made yet.
    let mut owed: Option<f64> = None;
    let mut made = 0;
    while made < limit && !done(norms) {
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
            break;
        }
        let step = rho / curvature;
        let first = last.is_none();
        owed = match owed {
            None => {
                turn(&layout, deflation, z, [unit, mean, beta], first, &mut v.p);
                Some(step)
            }
            Some(before) => {
                let fresh = fresh && made == 1;
                norms.solution = advance(&layout, deflation, z, [unit, mean, beta, before, step], fresh, &mut v.p, x);
                None
            }
        };
        last = Some((rho, curvature));
        let (square, sum, largest) = reduce(operator, step, &mut v.p, &mut v.r);
        norms = Norms { two: square.sqrt(), largest: largest.0, sum, weighted: None, ..norms };
        // Rounding slowly gives the residual a constant part, which no correction can remove.
        let drifted = match deflation {
            Deflation::None => false,
            Deflation::Whole => sum.abs() > MEAN_LEFT * norms.two * (layout.count() as f64).sqrt(),
            Deflation::Components(_) => true,
        };
        if drifted {
            deflation.project(&layout, &mut v.r, |_, _| ());
            norms.sum = 0.0;
        }
        made += 1;
    }
    if let Some(step) = owed {
        move_along(&layout, &v.p, step, fresh && made == 1, x);
    }
    made
}

/// unit z - mean + beta p; the old p counts for nothing at the `first` direction.
#[inline(always)]
fn direction<T: Real, Z: Real>([unit, mean, beta]: [T; 3], first: bool) -> impl Fn(Z, T) -> T + Copy {
    let same = T::NAME == Z::NAME;
    inlined(
        #[inline(always)]
        move |z: Z, p: T| {
            let z = T::of(z.f64());
            let z = if same { z - mean } else { unit * z - mean };
            if first { z } else { z + beta * p }
        },
    )
}

/// r -= step · A p; returns r·r, Σ r and max|r|.
pub(crate) fn reduce<T: Real, const D: usize>(
    operator: &LevelOperator<T, D>,
    step: f64,
    p: &mut [T],
    r: &mut [T],
) -> (f64, f64, Max) {
    let step = T::of(step);
    operator.sweep(
        p,
        r,
        #[inline(always)]
        move |ap, r| r - step * ap,
        #[inline(always)]
        |_, r| running_norms(r),
    )
}

/// p = unit z - mean + beta p.
pub(crate) fn turn<T: Real, Z: Real, const D: usize>(
    layout: &Layout<D>,
    deflation: &Deflation,
    z: &[Z],
    factors: [f64; 3],
    first: bool,
    p: &mut [T],
) {
    let turn = direction(factors.map(T::of), first);
    layout.par_runs(
        layout.cells_region(),
        &mut *p,
        #[inline(always)]
        |run, p: &mut [T]| {
            for (p, &z) in p.iter_mut().zip(run.row(z)) {
                *p = turn(z, *p);
            }
        },
    );
    if let (false, Deflation::Components(_)) = (T::NAME == Z::NAME, deflation) {
        // What single precision left of the constants would stay in x.
        deflation.project(layout, p, |_, _| ());
    }
}

/// x += before · p, p = unit z - mean + beta p, x += step · p; returns max|x|. A `fresh` x counts as zero.
pub(crate) fn advance<T: Real, Z: Real, const D: usize>(
    layout: &Layout<D>,
    deflation: &Deflation,
    z: &[Z],
    [unit, mean, beta, before, step]: [f64; 5],
    fresh: bool,
    p: &mut [T],
    x: &mut [T],
) -> f64 {
    if let (false, Deflation::Components(_)) = (T::NAME == Z::NAME, deflation) {
        move_along(layout, p, before, fresh, x);
        turn(layout, deflation, z, [unit, mean, beta], false, p);
        return move_along(layout, p, step, false, x);
    }
    let turn = direction([unit, mean, beta].map(T::of), false);
    let [before, step] = [before, step].map(T::of);
    let largest: Max = layout.par_runs(
        layout.cells_region(),
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
                    |k| {
                        let steps = before * old[k] + step * new[k];
                        if fresh { steps } else { at[k] + steps }
                    },
                );
                (*p, *x) = (new, there);
                largest.take(&there);
            }
            for ((&z, p), x) in last_z.iter().zip(last_p).zip(&mut *last_x) {
                let old = *p;
                *p = turn(z, old);
                let steps = before * old + step * *p;
                *x = if fresh { steps } else { *x + steps };
            }
            Max(largest.end(last_x))
        },
    );
    largest.0
}

/// x += step · p; returns max|x|. A `fresh` x counts as zero.
fn move_along<T: Real, const D: usize>(layout: &Layout<D>, p: &[T], step: f64, fresh: bool, x: &mut [T]) -> f64 {
    let step = T::of(step);
    let largest: Max = layout.par_runs(
        layout.cells_region(),
        x,
        #[inline(always)]
        |run, x: &mut [T]| {
            for (x, &p) in x.iter_mut().zip(run.row(p)) {
                *x = if fresh { step * p } else { *x + step * p };
            }
            Max(row_largest(x))
        },
    );
    largest.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::helmholtz::Helmholtz;
    use crate::multigrid::Multigrid;
    use crate::norms::norms;
    use cf_grid::{Mask, Sides};
    use std::cell::Cell;

    /// Four iterations in a closed box, from a residual with a mean. Returns the norms that were told of the residual
    /// left, those that it has, and the mean that it has in the left part.
    fn run(mask: Option<&Mask<2>>, mean: f64) -> (Norms, Norms, f64) {
        let layout = Layout::new([40, 31]).unwrap();
        let operator = Helmholtz::new(&layout, 0.0, 1.0, Sides::all(0.0));
        let operator = if let Some(mask) = mask { operator.with_mask(mask) } else { operator };
        let (mut multigrid, deflation) = (Multigrid::<f64, 2>::new(&operator), Deflation::new(&operator));
        let (mut v, [mut x, mut z]) = (Vectors::new(&layout), [(); 2].map(|()| vec![0.0; layout.slots()]));
        let fluid = |slot: usize| mask.is_none_or(|mask| mask.fluid()[slot]);
        let value = |slot: usize| if fluid(slot) { (0.37 * slot as f64).sin() } else { 0.0 };
        layout.par_cells(&mut v.r, |at| value(at.slot()));
        deflation.project(&layout, &mut v.r, |_, _| ());
        layout.each_cell(layout.cells_region(), |at| v.r[at.slot()] += if fluid(at.slot()) { mean } else { 0.0 });
        let start = norms(&layout, &v.r);
        let (told, calls) = (Cell::new(start), Cell::new(0));
        let done = |norms| {
            told.set(norms);
            calls.replace(calls.get() + 1) == 4
        };
        let (finest, mut cycle) = multigrid.split();
        let made = iterate(finest, &mut cycle, &deflation, 0.0, &mut x, true, &mut v, &mut z, start, done, 9);
        assert_eq!(made, 4);
        let mut left = (0.0, 0.0);
        layout.each_cell(layout.cells_region(), |at| {
            if at.cell[0] < 20 && fluid(at.slot()) {
                left = (left.0 + v.r[at.slot()], left.1 + 1.0);
            }
        });
        (told.get(), norms(&layout, &v.r), left.0 / left.1)
    }

    #[test]
    fn running_norms_are_those_of_the_residual() {
        let (told, found, _) = run(None, 0.0);
        assert!((told.two / found.two - 1.0).abs() < 1e-12 && (told.largest / found.largest - 1.0).abs() < 1e-3);
    }

    /// A correction has no constant part, so that one in the residual would stay.
    #[test]
    fn a_drifted_constant_is_taken_out() {
        let (_, found, _) = run(None, 1e-2);
        assert!(found.sum.abs() < 1e-12 && found.two < 1e-2, "{found:?}");
        let wall = Mask::new(&Layout::new([40, 31]).unwrap(), |cell| cell[0] != 20);
        let (_, found, left) = run(Some(&wall), 1e-2);
        assert!(left.abs() < 1e-12 && found.two < 1e-2, "{left:e} {found:?}");
    }
}
