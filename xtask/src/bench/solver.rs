//! Our solver on one problem.

use super::problem::{Numbers, Problem, Strength, noise, noise_around};
use super::{numerical, timing};
use crate::failure::Failure;
use crate::pool;
use cf_grid::{Layout, Real};
use cf_linear::{Helmholtz, Kernel, Options, Plan, Precision, SolveError, Solver, Stop};
use std::fmt;

/// From this kappa on the plan is multigrid, whatever [`Plan::choose`] says; a Poisson problem counts as larger.
pub const MULTIGRID_FROM: f64 = 10.0;

/// One solve that was timed, and what was solved.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn {
    pub iterations: usize,
    /// Of the solve \[s\].
    pub seconds: f64,
    /// Of building the solver \[s\].
    pub setup_seconds: f64,
    /// What the first iterations took longer than those that were timed, because the memory was new \[s\].
    pub new_seconds: f64,
    /// Held for the solve: solver, b and x.
    pub bytes: f64,
    /// ‖b - A x‖/‖b‖, formed anew from x; 0 where b is.
    pub residual: f64,
    /// What rounding of x and A x may leave of that: four units in the last place of alpha + 2 D kappa times ‖x‖/‖b‖.
    pub rounding: f64,
    /// 2-norm of x without its mean, by which solutions of different programs are compared.
    pub norm: f64,
    /// Where the method has reasons.
    pub plan: Option<String>,
    /// Sweeps of the solve, where they were asked for and the plan has a preconditioner.
    pub kernels: Vec<Kernel>,
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The residual formed anew is below the tolerance, but for what methods that carry one along lose ([`SLACK`]).
    Met,
    /// It is not, but rounding in these numbers explains it.
    Rounding,
    /// Neither.
    Missed,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Status::Met => "met",
            Status::Rounding => "rounding",
            Status::Missed => "missed",
        })
    }
}

/// How far above the tolerance a residual formed anew may be, since methods stop on one that they carry along.
pub const SLACK: f64 = 2.0;

/// All turns of a method on a problem; at least one.
#[derive(Clone, Debug)]
pub struct Measured {
    pub problem: Problem,
    pub method: String,
    pub turns: Vec<Turn>,
}

impl Measured {
    /// The median over the turns.
    pub fn median(&self, of: impl Fn(&Turn) -> f64) -> f64 {
        timing::median(self.turns.iter().map(of))
    }

    /// How it ended, by the residual that was formed anew.
    pub fn status(&self) -> Status {
        let [residual, rounding] = [self.median(|turn| turn.residual), self.median(|turn| turn.rounding)];
        match residual {
            r if r <= SLACK * self.problem.tolerance.0 => Status::Met,
            r if r <= rounding => Status::Rounding,
            _ => Status::Missed,
        }
    }

    /// Refuses a solution that is none.
    pub fn check(&self) -> Result<(), Failure> {
        if self.status() == Status::Missed {
            let (problem, method, residual) = (&self.problem, &self.method, self.median(|turn| turn.residual));
            return Err(Failure::failed(format!("{problem}: {method} left a residual of {residual:.1e}")));
        }
        Ok(())
    }

    /// Iterations, the same in every turn.
    pub fn iterations(&self) -> usize {
        self.turns.last().map_or(0, |turn| turn.iterations)
    }
}

/// Solves at least `runs` times, short ones until their times add up to something.
pub fn measure(problem: &Problem, runs: usize) -> Result<Measured, Failure> {
    const ENOUGH: f64 = 0.3;
    const MOST: usize = 15;
    let (mut turns, mut spent) = (Vec::new(), 0.0);
    while turns.len() < runs || (spent < ENOUGH && turns.len() < MOST) {
        let turn = turn(problem, 0)?;
        spent += turn.seconds;
        turns.push(turn);
    }
    Ok(Measured { problem: problem.clone(), method: method(&turns), turns })
}

/// What our rows are called.
pub fn method(turns: &[Turn]) -> String {
    let plan = turns.iter().find_map(|turn| turn.plan.as_deref()).unwrap_or_default();
    format!("cf {}", plan.split(':').next().unwrap_or_default())
}

/// Builds a solver, touches its memory, solves once, looks at the solution, and makes every sweep of it `sweeps` times.
pub fn turn(problem: &Problem, sweeps: usize) -> Result<Turn, Failure> {
    let done = pool::within(problem.threads, || match problem.cells.0[..] {
        [x, y] => by_numbers(problem, [x, y], sweeps),
        [x, y, z] => by_numbers(problem, [x, y, z], sweeps),
        _ => Err(numerical("a box has two or three axes")),
    })?;
    done.map_err(|error| match error {
        Failure::Words(exit, words) => Failure::Words(exit, format!("{problem}: {words}")),
        other => other,
    })
}

fn by_numbers<const D: usize>(problem: &Problem, cells: [usize; D], sweeps: usize) -> Result<Turn, Failure> {
    let layout = Layout::new(cells).map_err(numerical)?;
    match problem.numbers {
        Numbers::F64 => solve::<f64, D>(problem, &layout, Precision::Full, sweeps),
        Numbers::Mixed => solve::<f64, D>(problem, &layout, Precision::Single, sweeps),
        Numbers::F32 => solve::<f32, D>(problem, &layout, Precision::Full, sweeps),
    }
    .map_err(numerical)
}

fn solve<T: Real, const D: usize>(
    problem: &Problem,
    layout: &Layout<D>,
    precision: Precision,
    sweeps: usize,
) -> Result<Turn, SolveError> {
    let ((alpha, kappa), tolerance) = (problem.coefficients(), problem.tolerance.0);
    let large = problem.strength == Strength::Poisson || kappa >= MULTIGRID_FROM;
    let options =
        Options { plan: large.then_some(Plan::Multigrid), precision, reduction: tolerance, ..Options::default() };
    let mask = problem.mask(layout);
    let b = &match &mask {
        None => noise::<T, D>(layout),
        Some(mask) => noise_around(mask, &problem.sides()),
    };
    let mut x = vec![T::ZERO; layout.slots()];
    let (solver, setup_seconds) = timing::timed(|| {
        let operator = Helmholtz::new(layout, alpha, kappa, problem.sides());
        let operator = if let Some(mask) = &mask { operator.with_mask(mask) } else { operator };
        Solver::<T, D>::new(&operator, options)
    });
    let mut solver = solver?;
    let (first, first_seconds) = timing::timed(|| solver.solve(b, &mut x, Stop::Relative(0.5)));
    let (done, seconds) = timing::timed(|| solver.solve(b, &mut x, Stop::Relative(tolerance)));
    let (first, iterations) = (first?.iterations, done?.iterations);
    let new_seconds = newness([first, iterations], [first_seconds, seconds]);
    let bytes = (solver.bytes() + (b.len() + x.len()) * size_of::<T>()) as f64;
    let (sum, square) = (layout.sum(&x), layout.dot(&x, &x));
    let norm = (square - sum * sum / layout.count() as f64).max(0.0).sqrt();
    let size = layout.dot(b, b).sqrt();
    let relative = |value: f64| if size > 0.0 { value / size } else { value };
    let diagonal = alpha + 2.0 * D as f64 * kappa;
    let rounding = relative(4.0 * T::EPSILON * diagonal * square.sqrt());
    let residual = relative(residual(&solver, layout, b, &mut x));
    let plan = Some(solver.choice().to_string());
    let kernels = if sweeps > 0 { solver.kernels(b, &mut x, Stop::Relative(tolerance), sweeps)? } else { Vec::new() };
    Ok(Turn { iterations, seconds, setup_seconds, new_seconds, bytes, residual, rounding, norm, plan, kernels })
}

/// What the first iterations took longer than the later ones, at least 0.
pub fn newness(iterations: [usize; 2], seconds: [f64; 2]) -> f64 {
    let [first, later] = [iterations[0] as f64, iterations[1].max(1) as f64];
    (seconds[0] - first * seconds[1] / later).max(0.0)
}

/// ‖b - A x‖; A x is rounded to the precision of `T`.
fn residual<T: Real, const D: usize>(solver: &Solver<T, D>, layout: &Layout<D>, b: &[T], x: &mut [T]) -> f64 {
    let mut r = vec![T::ZERO; layout.slots()];
    solver.apply(x, &mut r);
    layout.par_runs(layout.cells_region(), &mut r[..], |run, row: &mut [T]| {
        row.iter_mut().zip(run.row(b)).for_each(|(r, &b)| *r = T::of(b.f64() - r.f64()));
    });
    layout.dot(&r, &r).sqrt()
}
