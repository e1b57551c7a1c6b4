//! The door: a solver for one operator, with its plan, its hierarchy and its scratch.

use cf_grid::{CellField, Layout, Pool, Real, once};

use crate::deflate::Deflation;
use crate::engine::Engine;
use crate::error::SolveError;
use crate::helmholtz::Helmholtz;
use crate::kernels::{Clock, Kernel};
use crate::norms::largest;
use crate::pcg::Vectors;
use crate::plan::{Choice, Plan};
use crate::rhs::{Rhs, RightHandSide};
use crate::stop::{Deviation, Statistics, Stop};
use crate::task::{Goal, Scaled, Task};

/// Precision of the preconditioner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// That of the vectors.
    Full,
    /// `f32` V-cycles inside the vectors' precision, half the memory traffic of the cycle: the same iteration counts, but
    /// for mazes and coefficients that differ by many orders of magnitude (docs/solver.md).
    Single,
}

/// How a [`Solver`] is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Overrides [`Plan::choose`], except where kappa = 0 and no wall conducts.
    pub plan: Option<Plan>,
    /// Precision of the V-cycle.
    pub precision: Precision,
    /// Residual reduction the plan is chosen for.
    pub reduction: f64,
    /// Iterations after which PCG gives up; Chebyshev, whose iterations cost a third, makes ten times as many.
    pub limit: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { plan: None, precision: Precision::Full, reduction: 1e-6, limit: 400 }
    }
}

/// Solver of A x = b for one [`Helmholtz`] operator. Vectors are fields of its layout. Everything is allocated here,
/// nothing in a solve. Solvers that take turns can [share](Self::share) the vectors of the iteration.
pub struct Solver<T, const D: usize> {
    layout: Layout<D>,
    alpha: f64,
    scale: f64,
    scaled: Scaled,
    choice: Choice,
    deflation: Deflation,
    fluid: Option<Vec<bool>>,
    engine: Engine<T, D>,
    vectors: Vectors<T>,
    /// Of [`solve`](Self::solve).
    deviation: Deviation,
    pool: Pool<T>,
}

impl<T: Real, const D: usize> Solver<T, D> {
    /// Builds plan, hierarchy and scratch. Fails with [`SolveError::Coefficient`] where a number is negative, not finite
    /// or too large to add up, with [`SolveError::Spread`] where alpha and kappa vanish beside a wall or a share (by more than
    /// eps² of `T`), and with [`SolveError::Length`] where a mask or shares have another layout.
    pub fn new(helmholtz: &Helmholtz<'_, D>, options: Options) -> Result<Self, SolveError> {
        (compiled().make)(helmholtz, options)
    }

    fn make(helmholtz: &Helmholtz<'_, D>, options: Options) -> Result<Self, SolveError> {
        helmholtz.check()?;
        let wall = helmholtz.walls().walls().map(|(_, _, w)| w).fold(0.0, f64::max);
        let share = helmholtz.largest_share();
        let mut choice = Plan::choose(D, helmholtz.alpha(), share * helmholtz.kappa(), share * wall, options.reduction);
        if let Some(plan) = options.plan
            && plan != choice.plan
            && !helmholtz.is_diagonal()
        {
            choice = Choice { plan, reason: format!("as asked (otherwise {choice})") };
        }
        let layout = *helmholtz.layout();
        let (inner, scale) = (helmholtz.inner(), helmholtz.scale());
        if inner < T::EPSILON * T::EPSILON * scale {
            return Err(SolveError::Spread { inner, largest: scale });
        }
        Ok(Self {
            layout,
            alpha: helmholtz.alpha(),
            scale,
            scaled: Scaled {
                alpha: helmholtz.alpha() / scale,
                conductance: helmholtz.conductance() / scale,
                inner: inner / scale,
                limit: options.limit,
            },
            engine: Engine::new(helmholtz, choice.plan, options.precision),
            choice,
            deflation: Deflation::new(helmholtz),
            fluid: helmholtz.mask().map(|m| m.fluid().to_vec()),
            vectors: Vectors::new(&layout),
            deviation: Deviation::default(),
            pool: Pool::default(),
        })
    }

    /// From now on the vectors of the iteration and of its levels come from `pool` for each solve and go back to it;
    /// preconditioners of single precision in f64 keep their own.
    pub fn share(&mut self, pool: &Pool<T>) {
        self.pool = pool.clone();
        self.each_vector(|_, array| *array = CellField::default());
    }

    /// Calls `f` with r, p, z and the vectors of all levels.
    fn each_vector(&mut self, mut f: impl FnMut(&Layout<D>, &mut CellField<T>)) {
        f(&self.layout, &mut self.vectors.r);
        f(&self.layout, &mut self.vectors.p);
        self.engine.each_vector(f);
    }

    fn fetch(&mut self) {
        let pool = self.pool.clone();
        self.each_vector(|layout, array| pool.fetch(layout, [array]));
    }

    fn release(&mut self) {
        let pool = self.pool.clone();
        self.each_vector(|_, array| pool.release([array]));
    }

    /// The plan and why.
    pub fn choice(&self) -> &Choice {
        &self.choice
    }

    /// Levels of the hierarchy; 1 where there is none.
    pub fn levels(&self) -> usize {
        self.engine.levels()
    }

    /// Bytes held: vectors (those of a pool do not count), hierarchy, stored coefficients, flags of masks and of their
    /// components.
    pub fn bytes(&self) -> usize {
        let flags = self.fluid.as_ref().map_or(0, Vec::len) + self.deflation.bytes();
        self.vectors.r.bytes() + self.vectors.p.bytes() + self.engine.bytes() + flags
    }

    /// y = A x in the units of the caller; the rim of `x` is overwritten along periodic axes. For checks and reports.
    pub fn apply(&self, x: &mut [T], y: &mut [T]) {
        (compiled().apply)(self, x, y);
    }

    fn apply_here(&self, x: &mut [T], y: &mut [T]) {
        self.engine.operator().apply(x, y);
        let scale = self.scale;
        self.layout.par_runs(
            self.layout.cells_region(),
            y,
            #[inline(always)]
            |_, row: &mut [T]| {
                row.iter_mut().for_each(|v| *v = T::of(v.f64() * scale));
            },
        );
    }

    /// z = M r, the preconditioner as an operator, for tests of its symmetry; the identity for plans without one.
    pub fn precondition(&mut self, r: &[T], z: &mut [T]) {
        (compiled().precondition)(self, r, z);
    }

    fn precondition_here(&mut self, r: &[T], z: &mut [T]) {
        self.fetch();
        match &mut self.engine {
            Engine::Plain(_) => z.copy_from_slice(r),
            Engine::Same { multigrid, .. } => {
                multigrid.split().1.run(r, 1.0, z, &Deflation::None);
            }
            Engine::Single { multigrid, z: single, .. } => {
                let size = largest(&self.layout, r);
                let unit = if size > 0.0 { size } else { 1.0 };
                multigrid.split().1.run(r, 1.0 / unit, single, &Deflation::None);
                self.layout.par_cells(z, |at| T::of(f64::from(single[at.slot()]) * unit));
            }
        }
        self.release();
    }

    /// Solves A x = b from a zero guess: x is overwritten, its rim zero behind walls and wrapped along
    /// periodic axes.
    ///
    /// Fails with [`SolveError::NotFinite`] for a right-hand side that is not finite or a solution too large for `T`,
    /// with [`SolveError::NotConverged`] if the criterion is met neither within the limit nor by the rounding floor.
    pub fn solve(&mut self, b: &[T], x: &mut [T], stop: Stop) -> Result<Statistics, SolveError> {
        let mut deviation = std::mem::take(&mut self.deviation);
        let done = self.solve_deviation(&b, x, stop, &mut deviation).and_then(|()| self.finish_checked(x, &deviation));
        self.deviation = deviation;
        done.map(|()| self.deviation.statistics)
    }

    /// Solves, and then makes each sweep of that solve `runs` times against the clock, for benchmarks; `x` is only scratch.
    /// Empty for plans without a preconditioner. Fails as [`solve`](Self::solve) does.
    pub fn kernels(&mut self, b: &[T], x: &mut [T], stop: Stop, runs: usize) -> Result<Vec<Kernel>, SolveError> {
        (compiled().kernels)(self, b, x, stop, runs)
    }

    fn kernels_here(&mut self, b: &[T], x: &mut [T], stop: Stop, runs: usize) -> Result<Vec<Kernel>, SolveError> {
        self.solve(b, x, stop)?;
        if self.choice.plan != Plan::Multigrid {
            return Ok(Vec::new());
        }
        let layout = self.layout;
        self.fetch();
        let mut clock = Clock { runs, found: Vec::new() };
        let mut means = vec![0.0; self.deflation.count()];
        clock.time("right-hand side", 0.0, 3.0, || {
            if let Some(mut rhs) = Rhs::new(&layout, &b, self.fluid.as_deref(), &mut means) {
                rhs.load_deflated(&layout, &self.deflation, &mut self.vectors.r);
            }
        });
        if let Some(rhs) = Rhs::new(&layout, &b, self.fluid.as_deref(), &mut means) {
            let (goal, deflation, scaled) = (Goal::Largest(0.0), &self.deflation, self.scaled);
            let task = Task { layout, rhs, deflation, goal, wanted: 0.0, scaled };
            task.time(&mut self.engine, x, &mut self.vectors, &mut clock);
        }
        clock.time("x = constants + factor y", 0.0, 2.0, || self.finish_here(x, &self.deviation));
        self.release();
        Ok(clock.found)
    }

    /// Solves A x = b for the parts of x = constants + factor · y; `y` and `found` are overwritten, the rim of y is zero or
    /// wrapped. The vectors inside are of unit size, so neither tiny nor huge b and kappa under- or overflow in `f32`. Fails
    /// as [`solve`](Self::solve) does, and leaves no solution in `found` then.
    pub fn solve_deviation(
        &mut self,
        b: &dyn RightHandSide<T, D>,
        y: &mut [T],
        stop: Stop,
        found: &mut Deviation,
    ) -> Result<(), SolveError> {
        let goal = match stop {
            Stop::Relative(tolerance) => Goal::Relative(tolerance),
            Stop::Largest(tolerance) => Goal::Largest(tolerance),
        };
        (compiled().run)(self, b, y, goal, found)
    }

    /// x = constants + factor · y, in place, with the rim wrapped along periodic axes.
    pub fn finish(&self, y: &mut [T], deviation: &Deviation) {
        (compiled().finish)(self, y, deviation);
    }

    fn finish_here(&self, y: &mut [T], deviation: &Deviation) {
        let constant = |i| deviation.constants.get(i).copied().unwrap_or(0.0);
        self.deflation.scale_and_shift(&self.layout, y, deviation.factor, constant);
        self.engine.operator().wrap(y);
    }

    fn finish_checked(&self, y: &mut [T], deviation: &Deviation) -> Result<(), SolveError> {
        let constant = deviation.constants.iter().fold(0f64, |m, c| m.max(c.abs()));
        let bound = T::of(deviation.size * deviation.factor + constant);
        if !bound.is_finite() {
            return Err(SolveError::NotFinite { what: "solution", iterations: deviation.statistics.iterations });
        }
        self.finish(y, deviation);
        Ok(())
    }

    /// A bound of the rounding of max|r| for any x with max|x| = `largest`: 8 eps (alpha + 2 W) `largest`, W the largest
    /// sum of a cell's conductances, 2 D kappa inside. What a solve accepts as its end is judged row by row instead
    /// ([`Statistics::at_floor`]).
    pub fn floor(&self, largest: f64) -> f64 {
        8.0 * T::EPSILON * (2.0 * self.scale - self.alpha) * largest
    }

    fn check_length(&self, what: &'static str, found: usize) -> Result<(), SolveError> {
        let expected = self.layout.slots();
        if found == expected { Ok(()) } else { Err(SolveError::Length { what, expected, found }) }
    }

    fn run(
        &mut self,
        b: &dyn RightHandSide<T, D>,
        y: &mut [T],
        goal: Goal,
        found: &mut Deviation,
    ) -> Result<(), SolveError> {
        if let Some(slots) = b.slots() {
            self.check_length("the right-hand side", slots)?;
        }
        self.check_length("the solution", y.len())?;
        self.fetch();
        let done = self.run_with_vectors(b, y, goal, found);
        self.release();
        done
    }

    fn run_with_vectors(
        &mut self,
        b: &dyn RightHandSide<T, D>,
        y: &mut [T],
        goal: Goal,
        found: &mut Deviation,
    ) -> Result<(), SolveError> {
        let (layout, tolerance) = (self.layout, goal.tolerance());
        if tolerance.is_nan() || tolerance < 0.0 {
            return Err(SolveError::Coefficient { name: "tolerance", value: tolerance });
        }
        layout.clear_rim(y);
        let Deviation { constants: means, removed, .. } = found;
        for each in [&mut *means, removed] {
            each.clear();
            each.resize(self.deflation.count(), 0.0);
        }
        let mut rhs = Rhs::new(&layout, b, self.fluid.as_deref(), means).ok_or(NOT_FINITE_RHS)?;
        let start = rhs.load_deflated(&layout, &self.deflation, &mut self.vectors.r);
        let unit = rhs.unit;
        let wanted = match goal {
            Goal::Relative(tolerance) => tolerance * start.two,
            Goal::Largest(tolerance) => tolerance / unit,
        };
        let task = Task { layout, rhs, deflation: &self.deflation, goal, wanted, scaled: self.scaled };
        let v = &mut self.vectors;
        let (iterations, reached) = if task.met(start) || task.at_floor(start) {
            layout.par_cells(y, |_| T::ZERO);
            (0, start)
        } else {
            match self.choice.plan {
                Plan::Diagonal => task.diagonal(self.engine.operator(), y, v),
                Plan::Chebyshev => {
                    layout.par_cells(y, |_| T::ZERO);
                    task.chebyshev(self.engine.operator(), y, v, start)
                }
                Plan::Multigrid => task.conjugate_gradients(&mut self.engine, y, v, start),
            }
        };

        if !(reached.two.is_finite() && reached.solution.is_finite()) {
            return Err(SolveError::NotFinite { what: "residual", iterations });
        }
        let at_floor = !task.met(reached);
        if at_floor && !task.at_floor(reached) {
            let (residual, wanted) = (goal.measure(reached) * unit, wanted * unit);
            return Err(SolveError::NotConverged { iterations, residual, wanted });
        }
        let statistics = Statistics {
            iterations,
            rhs: start.two * unit,
            residual: reached.two * unit,
            largest: reached.largest * unit,
            at_floor,
        };
        for (constant, removed) in found.constants.iter_mut().zip(&mut found.removed) {
            let mean = *constant * unit;
            (*constant, *removed) = if self.alpha > 0.0 { (mean / self.alpha, 0.0) } else { (0.0, mean) };
        }
        (found.factor, found.statistics, found.size) = (unit / self.scale, statistics, reached.solution);
        Ok(())
    }
}

type Run<T, const D: usize> =
    fn(&mut Solver<T, D>, &dyn RightHandSide<T, D>, &mut [T], Goal, &mut Deviation) -> Result<(), SolveError>;
type Kernels<T, const D: usize> = fn(&mut Solver<T, D>, &[T], &mut [T], Stop, usize) -> Result<Vec<Kernel>, SolveError>;
type Make<T, const D: usize> = fn(&Helmholtz<'_, D>, Options) -> Result<Solver<T, D>, SolveError>;

/// What is compiled here, once, and not again in every crate that solves.
struct Compiled<T, const D: usize> {
    make: Make<T, D>,
    run: Run<T, D>,
    apply: fn(&Solver<T, D>, &mut [T], &mut [T]),
    precondition: fn(&mut Solver<T, D>, &[T], &mut [T]),
    finish: fn(&Solver<T, D>, &mut [T], &Deviation),
    kernels: Kernels<T, D>,
}

impl<T: Real, const D: usize> Compiled<T, D> {
    const HERE: Self = Self {
        make: Solver::make,
        run: Solver::run,
        apply: Solver::apply_here,
        precondition: Solver::precondition_here,
        finish: Solver::finish_here,
        kernels: Solver::kernels_here,
    };
}

static COMPILED: (Compiled<f32, 2>, Compiled<f64, 2>, Compiled<f32, 3>, Compiled<f64, 3>) =
    (Compiled::HERE, Compiled::HERE, Compiled::HERE, Compiled::HERE);

fn compiled<T: Real, const D: usize>() -> &'static Compiled<T, D> {
    let c = &COMPILED;
    once([&c.0, &c.1, &c.2, &c.3])
}

const NOT_FINITE_RHS: SolveError = SolveError::NotFinite { what: "right-hand side", iterations: 0 };
