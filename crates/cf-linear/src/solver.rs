//! The door: a solver for one operator, with its plan, its hierarchy and its scratch.

use cf_grid::{Axis, Layout, Max, Real, row_dot};

use crate::chebyshev;
use crate::deflate::Deflation;
use crate::error::SolveError;
use crate::helmholtz::Helmholtz;
use crate::level::LevelOperator;
use crate::multigrid::Multigrid;
use crate::pcg::{self, Norms, Preconditioner, Vectors, row_largest};
use crate::plan::{Choice, Plan, chebyshev_count};
use crate::stop::{Statistics, Stop};

/// Precision of the preconditioner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// That of the vectors.
    Full,
    /// `f32` V-cycles inside the vectors' precision (model/diffusion.md 5.6): the same iteration counts, half the
    /// memory traffic.
    Single,
}

/// How a [`Solver`] is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Overrides [`Plan::choose`].
    pub plan: Option<Plan>,
    /// Precision of the V-cycle.
    pub precision: Precision,
    /// Residual reduction the plan is chosen for.
    pub reduction: f64,
    /// Iterations after which PCG gives up.
    pub limit: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { plan: None, precision: Precision::Full, reduction: 1e-6, limit: 100 }
    }
}

/// Solver of A x = b for one [`Helmholtz`] operator. Everything is allocated here; a solve allocates nothing that grows
/// with the grid.
pub struct Solver<T, const D: usize> {
    layout: Layout<D>,
    alpha: f64,
    kappa: f64,
    scale: f64,
    conductance: f64,
    choice: Choice,
    options: Options,
    deflation: Deflation,
    engine: Engine<T, D>,
    vectors: Vectors<T>,
}

enum Engine<T, const D: usize> {
    /// Diagonal and Chebyshev: only the operator.
    Plain(Box<LevelOperator<T, D>>),
    Same(Box<Multigrid<T, D>>),
    Single {
        operator: Box<LevelOperator<T, D>>,
        cycle: Box<SingleCycle<D>>,
    },
}

pub(crate) struct SingleCycle<const D: usize> {
    multigrid: Multigrid<f32, D>,
    b: Vec<f32>,
    x: Vec<f32>,
    scratch: Vec<f32>,
    layout: Layout<D>,
}

/// A solution written as constants plus a scaled deviation: x = constant(component) + factor · y. Conserving operators
/// have one constant per connected component ([`Solver::add_constants`]); others have none.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviation {
    /// Multiplies y.
    pub factor: f64,
    /// mean(b)/alpha per component; zeros for a Poisson problem.
    pub constants: Vec<f64>,
    /// Mean of b per component that a Poisson problem cannot satisfy; it was left out.
    pub removed: Vec<f64>,
    /// What the solve did.
    pub statistics: Statistics,
}

impl<T: Real, const D: usize> Solver<T, D> {
    /// Builds plan, hierarchy and scratch.
    pub fn new(helmholtz: &Helmholtz<'_, D>, options: Options) -> Result<Self, SolveError> {
        for (name, value) in [("alpha", helmholtz.alpha()), ("kappa", helmholtz.kappa())] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(SolveError::Coefficient { name, value });
            }
        }
        if let Some((_, _, value)) = helmholtz.walls().walls().find(|(_, _, w)| !(w.is_finite() && *w >= 0.0)) {
            return Err(SolveError::Coefficient { name: "wall conductance", value });
        }
        let (alpha, kappa, scale) = (helmholtz.alpha(), helmholtz.kappa(), helmholtz.scale());
        if scale == 0.0 {
            return Err(SolveError::Coefficient { name: "alpha + kappa (must be positive)", value: 0.0 });
        }
        let wall = helmholtz.walls().walls().map(|(_, _, w)| w).fold(0.0, f64::max);
        let mut choice = Plan::choose(D, alpha, kappa, wall, options.reduction);
        if let Some(plan) = options.plan
            && plan != choice.plan
        {
            choice = Choice { plan, reason: format!("as asked (otherwise {})", choice) };
        }
        let layout = *helmholtz.layout();
        let engine = match (choice.plan, options.precision) {
            (Plan::Diagonal | Plan::Chebyshev, _) => Engine::Plain(Box::new(helmholtz.level())),
            (Plan::Multigrid, Precision::Full) => Engine::Same(Box::new(Multigrid::new(helmholtz))),
            (Plan::Multigrid, Precision::Single) => {
                Engine::Single { operator: Box::new(helmholtz.level()), cycle: Box::new(SingleCycle::new(helmholtz)) }
            }
        };
        Ok(Self {
            layout,
            alpha,
            kappa,
            scale,
            conductance: largest_conductance(helmholtz),
            choice,
            options,
            deflation: Deflation::new(helmholtz),
            engine,
            vectors: Vectors::new(&layout),
        })
    }

    /// The plan and why.
    pub fn choice(&self) -> &Choice {
        &self.choice
    }

    /// Levels of the hierarchy; 1 where there is none.
    pub fn levels(&self) -> usize {
        match &self.engine {
            Engine::Plain(_) => 1,
            Engine::Same(m) => m.levels(),
            Engine::Single { cycle, .. } => cycle.multigrid.levels(),
        }
    }

    /// Bytes held: vectors, hierarchy, stored coefficients.
    pub fn bytes(&self) -> usize {
        let own = 4 * self.layout.slots() * size_of::<T>();
        own + match &self.engine {
            Engine::Plain(o) => o.bytes(),
            Engine::Same(m) => m.bytes(),
            Engine::Single { operator, cycle } => {
                operator.bytes() + cycle.multigrid.bytes() + 3 * self.layout.slots() * size_of::<f32>()
            }
        }
    }

    fn operator(&self) -> &LevelOperator<T, D> {
        match &self.engine {
            Engine::Plain(o) => o,
            Engine::Same(m) => m.finest(),
            Engine::Single { operator, .. } => operator,
        }
    }

    /// y = A x in the units of the caller; the rim of `x` is overwritten along periodic axes. For checks and reports.
    pub fn apply(&self, x: &mut [T], y: &mut [T]) {
        self.operator().apply(x, y);
        let scale = T::of(self.scale);
        self.layout
            .par_runs(self.layout.cells_region(), y, |_, row: &mut [T]| row.iter_mut().for_each(|v| *v *= scale));
    }

    /// z = M r, the preconditioner as an operator (for tests of its symmetry).
    pub fn precondition(&mut self, r: &[T], z: &mut [T]) {
        let Self { engine, vectors, layout, .. } = self;
        engine.precondition(r, layout.max_abs(r), z, &mut vectors.ap);
    }

    /// Solves A x = b from a zero guess: x is overwritten; its rim is zero or wrapped.
    pub fn solve(&mut self, b: &[T], x: &mut [T], stop: Stop) -> Result<Statistics, SolveError> {
        let deviation = self.solve_deviation(b, x, stop)?;
        self.finish(x, &deviation);
        Ok(deviation.statistics)
    }

    /// Solves A x = b starting from the content of `x`.
    pub fn improve(&mut self, b: &[T], x: &mut [T], stop: Stop) -> Result<Statistics, SolveError> {
        // The correction satisfies A dx = b - A x; the criterion stays relative to b.
        let mut residual = vec![T::ZERO; self.layout.slots()];
        let mut guess = x.to_vec();
        self.apply(&mut guess, &mut residual);
        self.layout.par_runs(self.layout.cells_region(), &mut residual[..], |run, r: &mut [T]| {
            for (r, &b) in r.iter_mut().zip(run.row(b)) {
                *r = b - *r;
            }
        });
        let stop = match stop {
            Stop::Largest(_) => stop,
            Stop::Relative(tolerance) => {
                let mut projected = b.to_vec();
                self.deflation.project(&self.layout, &mut projected);
                let (all, left) = (self.norm(&projected), self.norm(&residual));
                Stop::Relative(if left > 0.0 { (tolerance * all / left).min(1.0) } else { 1.0 })
            }
        };
        let statistics = self.solve(&residual, &mut guess, stop)?;
        self.layout.par_runs(self.layout.cells_region(), x, |run, x: &mut [T]| {
            for (x, &dx) in x.iter_mut().zip(run.row(&guess)) {
                *x += dx;
            }
        });
        Ok(statistics)
    }

    fn norm(&self, x: &[T]) -> f64 {
        self.layout.dot(x, x).sqrt()
    }

    /// x = constants + factor · y, in place.
    pub fn finish(&self, y: &mut [T], deviation: &Deviation) {
        let factor = deviation.factor;
        self.layout.par_runs(self.layout.cells_region(), &mut *y, |_, row: &mut [T]| {
            row.iter_mut().for_each(|v| *v = T::of(v.f64() * factor));
        });
        self.add_constants(y, deviation);
    }

    /// x += constants, per component.
    pub fn add_constants(&self, x: &mut [T], deviation: &Deviation) {
        if deviation.constants.iter().any(|&c| c != 0.0) {
            self.deflation.shift(&self.layout, x, &deviation.constants);
        }
    }

    /// Solves A x = b for the parts of x = constants + factor · y; `y` is overwritten, its rim is zero or wrapped. The
    /// vectors inside are of unit size, so neither tiny nor huge b and kappa under- or overflow in `f32`.
    pub fn solve_deviation(&mut self, b: &[T], y: &mut [T], stop: Stop) -> Result<Deviation, SolveError> {
        let layout = self.layout;
        let cells = layout.cells_region();
        y.fill(T::ZERO);
        let largest = layout.max_abs(b);
        if !largest.is_finite() {
            return Err(SolveError::NotFinite { what: "right-hand side", iterations: 0 });
        }
        // A power of two, so that scaling is exact.
        let unit = if largest > 0.0 { 2f64.powi(largest.log2().floor() as i32) } else { 1.0 };
        let inverse = 1.0 / unit;
        let load = |r: &mut [T]| {
            layout.par_runs(cells, r, |run, r: &mut [T]| {
                for (r, &b) in r.iter_mut().zip(run.row(b)) {
                    *r = T::of(b.f64() * inverse);
                }
            });
        };
        let Self { engine, vectors: v, deflation, .. } = self;
        load(&mut v.r);
        // Twice: the second mean is what rounding left of the first.
        let mut means = deflation.project(&layout, &mut v.r);
        for (m, left) in means.iter_mut().zip(deflation.project(&layout, &mut v.r)) {
            *m += left;
        }
        let start = norms(&layout, &v.r);
        let factor = unit / self.scale;
        let (mut constants, mut removed) = (vec![0.0; means.len()], vec![0.0; means.len()]);
        let target = if self.alpha > 0.0 { &mut constants } else { &mut removed };
        let divisor = if self.alpha > 0.0 { self.alpha } else { 1.0 };
        target.iter_mut().zip(&means).for_each(|(t, m)| *t = m * unit / divisor);
        let wanted = match stop {
            Stop::Relative(tolerance) => tolerance * start.two,
            Stop::Largest(tolerance) => tolerance / unit,
        };
        let measure = |n: Norms| match stop {
            Stop::Relative(_) => n.two,
            Stop::Largest(_) => n.largest,
        };
        let mut statistics = Statistics { rhs: start.two * unit, ..Default::default() };
        let mut reached = start;
        let limit = self.options.limit;
        // Entries of A/scale are at most about 1, so is the rounding of a residual per unit of y.
        let floor = |layout: &Layout<D>, y: &[T]| 16.0 * T::EPSILON * layout.max_abs(y);
        match (self.choice.plan, engine) {
            _ if start.two == 0.0 || measure(start) <= wanted => {}
            (Plan::Diagonal, Engine::Plain(_)) => {
                let gain = T::of(self.scale / self.alpha);
                let r = &v.r[..];
                layout.par_runs(cells, &mut *y, |run, y: &mut [T]| {
                    for (y, &r) in y.iter_mut().zip(run.row(r)) {
                        *y = gain * r;
                    }
                });
                reached = Norms { two: 0.0, largest: 0.0 };
            }
            (_, Engine::Plain(operator)) => {
                v.p.fill(T::ZERO);
                let radius = chebyshev::radius(self.alpha, self.conductance);
                let mut count =
                    chebyshev_count(D, self.alpha, self.conductance / (2 * D) as f64, wanted / measure(start));
                let mut omega = None;
                for _ in 0..6 {
                    omega = chebyshev::iterate(operator, &v.r, y, &mut v.p, radius, omega, count);
                    statistics.iterations += count;
                    operator.residual(&v.r, y, &mut v.ap);
                    reached = norms(&layout, &v.ap);
                    if measure(reached) <= wanted || !reached.two.is_finite() {
                        break;
                    }
                    count = count / 4 + 1;
                }
            }
            (_, engine) => {
                // The recursion's residual drifts from the true one by rounding: check, and go on if need be.
                for attempt in 0..3 {
                    let (operator, preconditioner) = engine.split();
                    let (iterations, _) = pcg::iterate(
                        operator,
                        &mut { preconditioner },
                        deflation,
                        y,
                        v,
                        reached,
                        |n| measure(n) <= wanted || !n.two.is_finite(),
                        limit.saturating_sub(statistics.iterations),
                    );
                    statistics.iterations += iterations;
                    let (operator, _) = engine.split();
                    load(&mut v.r);
                    let negative: Vec<f64> = means.iter().map(|m| -m).collect();
                    deflation.shift(&layout, &mut v.r, &negative);
                    operator.apply(y, &mut v.ap);
                    let ap = &v.ap[..];
                    let (square, largest): (f64, Max) = layout.par_runs(cells, &mut v.r[..], |run, r: &mut [T]| {
                        for (r, &ap) in r.iter_mut().zip(run.row(ap)) {
                            *r -= ap;
                        }
                        (row_dot(r, r), Max(row_largest(r)))
                    });
                    reached = Norms { two: square.sqrt(), largest: largest.0 };
                    let stuck = iterations == 0 && attempt > 0;
                    if measure(reached) <= wanted || !reached.two.is_finite() || statistics.iterations >= limit || stuck
                    {
                        break;
                    }
                    deflation.project(&layout, &mut v.r);
                }
            }
        }
        statistics.residual = reached.two * unit;
        statistics.largest = reached.largest * unit;
        if !(reached.two.is_finite() && largest.is_finite()) {
            return Err(SolveError::NotFinite { what: "residual", iterations: statistics.iterations });
        }
        if measure(reached) > wanted {
            let cells_root = match stop {
                Stop::Relative(_) => (layout.count() as f64).sqrt(),
                Stop::Largest(_) => 1.0,
            };
            if measure(reached) > floor(&layout, y) * cells_root {
                return Err(SolveError::NotConverged {
                    iterations: statistics.iterations,
                    residual: measure(reached) * unit,
                    wanted: wanted * unit,
                });
            }
            statistics.at_floor = true;
        }
        Ok(Deviation { factor, constants, removed, statistics })
    }

    /// The rounding floor of max|r| for a solution of this size, 8 eps (alpha + 4 D kappa) max|x| (model 5.5).
    pub fn floor(&self, largest: f64) -> f64 {
        8.0 * T::EPSILON * (self.alpha + 4.0 * D as f64 * self.kappa) * largest
    }
}

fn norms<T: Real, const D: usize>(layout: &Layout<D>, r: &[T]) -> Norms {
    let (square, largest): (f64, Max) = layout.par_runs(layout.cells_region(), (), |run, ()| {
        let r = run.row(r);
        (row_dot(r, r), Max(row_largest(r)))
    });
    Norms { two: square.sqrt(), largest: largest.0 }
}

/// The largest sum of the conductances around a cell.
fn largest_conductance<const D: usize>(helmholtz: &Helmholtz<'_, D>) -> f64 {
    (0..D)
        .map(|a| {
            let kappa = helmholtz.kappa();
            match helmholtz.walls().0[a] {
                Axis::Periodic => 2.0 * kappa,
                Axis::Walls([low, high]) if helmholtz.layout().cells()[a] == 1 => low + high,
                Axis::Walls([low, high]) => kappa + kappa.max(low).max(high),
            }
        })
        .sum()
}

impl<T: Real, const D: usize> Engine<T, D> {
    /// The operator and the preconditioner, which PCG needs apart.
    fn split(&mut self) -> (&LevelOperator<T, D>, Cycle<'_, T, D>) {
        match self {
            Engine::Plain(_) => unreachable!("only multigrid plans are preconditioned"),
            Engine::Same(m) => {
                let (operator, below) = m.split();
                (operator, Cycle::Same(below))
            }
            Engine::Single { operator, cycle } => (operator, Cycle::Single(cycle)),
        }
    }

    fn precondition(&mut self, r: &[T], largest: f64, z: &mut [T], scratch: &mut [T]) {
        match self {
            Engine::Plain(_) => z.copy_from_slice(r),
            Engine::Same(m) => m.cycle(r, z, scratch),
            Engine::Single { cycle, .. } => cycle.precondition(r, largest, z),
        }
    }
}

/// A borrowed preconditioner.
pub(crate) enum Cycle<'a, T, const D: usize> {
    Same(crate::multigrid::Below<'a, T, D>),
    Single(&'a mut SingleCycle<D>),
}

impl<T: Real, const D: usize> Preconditioner<T> for Cycle<'_, T, D> {
    fn precondition(&mut self, r: &[T], largest: f64, z: &mut [T], scratch: &mut [T]) {
        match self {
            Cycle::Same(m) => m.cycle(r, z, scratch),
            Cycle::Single(s) => s.precondition(r, largest, z),
        }
    }
}

impl<const D: usize> SingleCycle<D> {
    fn new(helmholtz: &Helmholtz<'_, D>) -> Self {
        let layout = *helmholtz.layout();
        let field = || vec![0.0; layout.slots()];
        Self { multigrid: Multigrid::new(helmholtz), b: field(), x: field(), scratch: field(), layout }
    }

    fn precondition<T: Real>(&mut self, r: &[T], largest: f64, z: &mut [T]) {
        let cells = self.layout.cells_region();
        let unit = if largest > 0.0 { largest } else { 1.0 };
        let inverse = 1.0 / unit;
        self.layout.par_runs(cells, &mut self.b[..], |run, b: &mut [f32]| {
            for (b, &r) in b.iter_mut().zip(run.row(r)) {
                *b = (r.f64() * inverse) as f32;
            }
        });
        self.multigrid.cycle(&self.b, &mut self.x, &mut self.scratch);
        let x = &self.x[..];
        self.layout.par_runs(cells, z, |run, z: &mut [T]| {
            for (z, &x) in z.iter_mut().zip(run.row(x)) {
                *z = T::of(f64::from(x) * unit);
            }
        });
    }
}
