//! One solve in unit size: A/scale · y = b/unit - means, whichever way the plan goes.
//!
//! Passes besides the iterations: 3 at the start (b twice, r), 2 for the true residual at the end (b, y), 2 for the result. A b that is
//! formed anew takes what forming it reads instead.

use cf_grid::{Layout, Max, Real};

use crate::chebyshev;
use crate::deflate::Deflation;
use crate::engine::Engine;
use crate::kernels::{self, Clock};
use crate::level::LevelOperator;
use crate::multigrid::Cycle;
use crate::norms::{Norms, norms, residual_norms, row_largest};
use crate::pcg::{self, Vectors};
use crate::rhs::Rhs;

/// When a solve is done, in the units of the caller.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Goal {
    /// ‖r‖₂ against ‖b‖₂.
    Relative(f64),
    /// max|r|.
    Largest(f64),
}

impl Goal {
    pub fn tolerance(self) -> f64 {
        match self {
            Goal::Relative(t) | Goal::Largest(t) => t,
        }
    }

    /// The norm it is about.
    pub fn measure(self, norms: Norms) -> f64 {
        match self {
            Goal::Relative(_) => norms.two,
            Goal::Largest(_) => norms.largest,
        }
    }
}

/// A loaded right-hand side with everything that says how far to go.
pub(crate) struct Task<'a, T, const D: usize> {
    pub layout: Layout<D>,
    pub rhs: Rhs<'a, T, D>,
    pub deflation: &'a Deflation,
    pub goal: Goal,
    /// The goal's norm in units.
    pub wanted: f64,
    pub scaled: Scaled,
}

/// What a solve knows of its operator, divided by the scale, and where it gives up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scaled {
    pub alpha: f64,
    /// Largest sum of a cell's conductances.
    pub conductance: f64,
    /// The diagonal of an inner cell, where shares are 1.
    pub inner: f64,
    /// Iterations.
    pub limit: usize,
}

/// Chebyshev passes without progress after which it stops.
const IDLE: usize = 3;

/// A Chebyshev iteration costs about a third of a PCG iteration, so the limit allows more of them.
const CHEBYSHEV_PER_PCG: usize = 10;

impl<T: Real, const D: usize> Task<'_, T, D> {
    fn measure(&self, norms: Norms) -> f64 {
        self.goal.measure(norms)
    }

    pub fn met(&self, norms: Norms) -> bool {
        self.measure(norms) <= self.wanted
    }

    /// The rounding of A y and of the right-hand side in the goal's norm: that of every row counts by its own diagonal.
    /// Zero where the norms of diagonal · y are not known.
    fn floor(&self, norms: Norms) -> f64 {
        let (cells, offset) = (self.layout.count() as f64, T::EPSILON * 0.125 * self.rhs.offset());
        let [two, largest] = norms.weighted.unwrap_or_default();
        match self.goal {
            Goal::Largest(_) => T::EPSILON * FLOOR * largest + offset,
            Goal::Relative(_) => T::EPSILON * FLOOR * two + offset * cells.sqrt(),
        }
    }

    /// A residual that may be rounding and nothing else.
    pub fn at_floor(&self, norms: Norms) -> bool {
        self.measure(norms) <= self.floor(norms)
    }

    /// Worth going on; not with NaN.
    fn halved(&self, before: Norms, now: Norms) -> bool {
        self.measure(now) < 0.5 * self.measure(before)
    }

    /// x = b/alpha.
    pub fn diagonal(&self, operator: &LevelOperator<T, D>, y: &mut [T], v: &mut Vectors<T>) -> (usize, Norms) {
        let gain = T::of(1.0 / self.scaled.alpha);
        let r = &v.r[..];
        self.layout.par_runs(
            self.layout.cells_region(),
            &mut *y,
            #[inline(always)]
            |run, y: &mut [T]| {
                for (y, &r) in y.iter_mut().zip(run.row(r)) {
                    *y = gain * r;
                }
            },
        );
        (0, self.residual(operator, y, &v.r))
    }

    pub fn chebyshev(
        &self,
        operator: &LevelOperator<T, D>,
        y: &mut [T],
        v: &mut Vectors<T>,
        start: Norms,
    ) -> (usize, Norms) {
        v.p.fill(T::ZERO);
        let limit = CHEBYSHEV_PER_PCG.saturating_mul(self.scaled.limit);
        let radius = chebyshev::radius(self.scaled.alpha, self.scaled.conductance);
        // No use aiming below rounding.
        let reduction = (self.wanted / self.measure(start)).max(0.1 * T::EPSILON);
        let mut count = chebyshev::count(radius, reduction);
        let (mut total, mut omega, mut reached) = (0, None, start);
        // A short pass may leave the max-norm as it is, or even raise it: only several in a row mean the rounding floor.
        let (mut best, mut idle) = (self.measure(start), 0);
        while total < limit {
            count = count.min(limit - total);
            omega = chebyshev::iterate(operator, &v.r, y, &mut v.p, radius, omega, count);
            total += count;
            reached = self.residual(operator, y, &v.r);
            let now = self.measure(reached);
            idle = if now < 0.9 * best { 0 } else { idle + 1 };
            best = best.min(now);
            if self.met(reached) || idle == IDLE || !now.is_finite() {
                break;
            }
            count = (count / 4 + 1).max(chebyshev::count(radius, (self.wanted / now).max(0.1 * T::EPSILON)));
        }
        (total, reached)
    }

    /// The sweeps of a solve by [`conjugate_gradients`](Self::conjugate_gradients) against the clock.
    pub fn time(&self, engine: &mut Engine<T, D>, y: &mut [T], v: &mut Vectors<T>, clock: &mut Clock) {
        match engine {
            Engine::Plain(_) => {}
            Engine::Same { multigrid, z } => {
                let (operator, mut cycle) = multigrid.split();
                kernels::iteration(operator, &mut cycle, self.deflation, y, v, z, clock);
            }
            Engine::Single { multigrid, operator, z } => {
                let (_, mut cycle) = multigrid.split();
                kernels::iteration(&**operator, &mut cycle, self.deflation, y, v, z, clock);
            }
        }
        let operator = engine.operator();
        clock.time("true residual", 0.0, 2.0, || {
            self.true_residual(operator, y, v);
        });
    }

    /// PCG. Its residual drifts from the true one by rounding: that is computed at the end, and PCG goes on from it if
    /// need be. Does nothing without a preconditioner.
    pub fn conjugate_gradients(
        &self,
        engine: &mut Engine<T, D>,
        y: &mut [T],
        v: &mut Vectors<T>,
        start: Norms,
    ) -> (usize, Norms) {
        match engine {
            Engine::Plain(_) => (0, start),
            Engine::Same { multigrid, z } => {
                let (operator, mut cycle) = multigrid.split();
                self.restarted(operator, &mut cycle, z, y, v, start)
            }
            Engine::Single { multigrid, operator, z } => {
                let (_, mut cycle) = multigrid.split();
                self.restarted(operator, &mut cycle, z, y, v, start)
            }
        }
    }

    fn restarted<Z: Real>(
        &self,
        operator: &LevelOperator<T, D>,
        cycle: &mut Cycle<'_, Z, D>,
        z: &mut [Z],
        y: &mut [T],
        v: &mut Vectors<T>,
        start: Norms,
    ) -> (usize, Norms) {
        let (mut total, mut reached) = (0, start);
        // Norm of diagonal · y per max|y|: that of inner cells until the first true residual tells.
        let cells = self.layout.count() as f64;
        let mut weights = [self.scaled.inner * cells.sqrt(), self.scaled.inner];
        for restart in 0..RESTARTS {
            // Below rounding no true residual follows. After a restart a margin is left for what it may stay behind.
            let margin = if restart == 0 { 1.0 } else { 0.5 };
            let done = |n: Norms| {
                let rounding = self.floor(Norms { weighted: Some(weights.map(|w| w * n.solution)), ..n });
                self.measure(n) <= (margin * self.wanted).max(HOPELESS * rounding) || !n.two.is_finite()
            };
            let left = self.scaled.limit.saturating_sub(total);
            let (alpha, deflation) = (self.scaled.alpha, self.deflation);
            let fresh = restart == 0;
            let made = pcg::iterate(operator, cycle, deflation, alpha, y, fresh, v, z, reached, done, left);
            if fresh && made == 0 {
                self.layout.par_cells(y, |_| T::ZERO);
            }
            total += made;
            let before = std::mem::replace(&mut reached, self.true_residual(operator, y, v));
            if let Some(weighted) = reached.weighted {
                weights = weighted.map(|w| w / reached.solution.max(f64::MIN_POSITIVE));
            }
            let ended = self.met(reached) || self.at_floor(reached);
            if ended || total >= self.scaled.limit || !self.halved(before, reached) {
                break;
            }
            self.rhs.load(&self.layout, deflation, &mut v.r);
            operator.sweep(
                y,
                &mut v.r,
                #[inline(always)]
                |ay, b| b - ay,
                |_, _| (),
            );
            deflation.project(&self.layout, &mut v.r, |_, _| ());
            reached = Norms { solution: reached.solution, weighted: reached.weighted, ..norms(&self.layout, &v.r) };
        }
        (total, reached)
    }

    /// Norms of the residual of y, from the right-hand side itself.
    fn true_residual(&self, operator: &LevelOperator<T, D>, y: &mut [T], v: &mut Vectors<T>) -> Norms {
        if let Deflation::Components(_) = self.deflation {
            self.rhs.load(&self.layout, self.deflation, &mut v.r);
            return self.residual(operator, y, &v.r);
        }
        self.norms_of(operator.deficit(
            y,
            #[inline(always)]
            |run, r| self.rhs.fill(self.deflation, run, r),
            measure,
        ))
    }

    /// Norms of b - A y.
    fn residual(&self, operator: &LevelOperator<T, D>, y: &mut [T], b: &[T]) -> Norms {
        self.norms_of(operator.deficit(
            y,
            #[inline(always)]
            |run, r| r.copy_from_slice(run.row(b)),
            measure,
        ))
    }

    fn norms_of(&self, (residual, weighted, solution): Measured) -> Norms {
        let ([(square, sum, largest), (weight, _, heaviest)], solution) = ([residual, weighted], solution.0);
        let weighted = Some([weight.sqrt(), heaviest.0]);
        Norms { two: square.sqrt(), largest: largest.0, sum, solution, weighted }
    }
}

/// Sums for the norms of a residual r and of diagonal · y, and max|y|.
type Measured = ((f64, f64, Max), (f64, f64, Max), Max);

/// What norms take from a row of y, diagonal · y and r.
#[inline(always)]
fn measure<T: Real>([y, weighted, r]: [&[T]; 3]) -> Measured {
    (residual_norms(r), residual_norms(weighted), Max(row_largest(y)))
}

/// The largest true residual that counts as rounding, in units of eps |diagonal · y|. Where PCG cannot go on it ends at
/// a third to a half of that unit (docs/solver.md).
const FLOOR: f64 = 4.0;

/// True residuals end above this part of the floor.
const HOPELESS: f64 = 0.05;

/// Times PCG goes on from the true residual.
const RESTARTS: usize = 4;
