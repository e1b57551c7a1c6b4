//! The sweeps of a solve, each alone and against the clock, beside the passes that the model counts for it.

use std::time::Instant;

use cf_grid::{Layout, Real};

use crate::deflate::Deflation;
use crate::level::LevelOperator;
use crate::multigrid::Cycle;
use crate::pcg::{self, Vectors};

/// A sweep over the finest level, or all that is below it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    /// As in the table of docs/solver.md.
    pub name: &'static str,
    /// Times it is made in an iteration; 0 for what a solve makes once.
    pub per_iteration: f64,
    /// Arrays of the vectors' precision that it reads or writes.
    pub passes: f64,
    /// Shortest of its runs \[s\].
    pub seconds: f64,
}

/// Runs sweeps one after another and keeps the times.
pub(crate) struct Clock {
    pub runs: usize,
    pub found: Vec<Kernel>,
}

impl Clock {
    /// Times `sweep`.
    pub fn time(&mut self, name: &'static str, per_iteration: f64, passes: f64, mut sweep: impl FnMut()) {
        let mut seconds = f64::INFINITY;
        for _ in 0..self.runs.max(1) {
            let begun = Instant::now();
            sweep();
            seconds = seconds.min(begun.elapsed().as_secs_f64());
        }
        self.found.push(Kernel { name, per_iteration, passes, seconds });
    }
}

/// The sweeps of [`pcg::iterate`], on whatever the vectors hold.
pub(crate) fn iteration<T: Real, Z: Real, const D: usize>(
    operator: &LevelOperator<T, D>,
    cycle: &mut Cycle<'_, Z, D>,
    deflation: &Deflation,
    x: &mut [T],
    v: &mut Vectors<T>,
    z: &mut [Z],
    clock: &mut Clock,
) {
    // A step of zero keeps the numbers from growing and costs what another one does.
    const STEP: f64 = 0.0;
    let layout: Layout<D> = operator.layout;
    let size = size_of::<Z>() as f64 / size_of::<T>() as f64;
    cycle.time(&v.r, z, deflation, size, clock);
    clock.time("p = z + beta p", 0.5, 2.0 + size, || {
        pcg::turn(&layout, deflation, z, [1.0, 0.0, 0.5], false, &mut v.p);
    });
    clock.time("p = z + beta p, x += alpha p twice", 0.5, 4.0 + size, || {
        pcg::advance(&layout, deflation, z, [1.0, 0.0, 0.5, STEP, STEP], false, &mut v.p, x);
    });
    clock.time("r -= alpha A p, norms", 1.0, 3.0, || {
        pcg::reduce(operator, STEP, &mut v.p, &mut v.r);
    });
}
