//! One time step: transport by the medium, diffusion, sources, in the order of the chosen splitting.

use cf_grid::{Grid, Mask, Pool, Real, Sides, Wall, once};
use cf_linear::{Choice, Plan, Precision};

use crate::advect::{Advection, Advector};
use crate::balance::Balance;
use crate::embedded::{self, Embedded};
use crate::explicit;
use crate::implicit::{Implicit, Moved};
use crate::law::Law;
use crate::medium::Medium;
use crate::source::{Rate, Source};
use crate::state::State;
use crate::step_error::StepError;
use crate::walls::Walls;

/// How diffusion is integrated in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Integrator {
    /// Backward Euler, the paper's scheme: first order, one solve.
    PaperBe,
    /// Two stages of backward Euler with gamma = 1 - 1/sqrt 2: second order, L-stable, two solves of one operator.
    #[default]
    Sdirk2,
    /// Explicit kick-drift-kick leapfrog for F_T = 0: second order, no solve, conditionally stable (sub-steps itself).
    Kdk,
}

/// How transport and diffusion alternate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Splitting {
    /// Symmetric, second order: A(dt/2) D(dt) A(dt/2) for implicit, D(dt/2) A(dt) D(dt/2) for explicit diffusion.
    #[default]
    Strang,
    /// The paper's order (eqs. 11 to 14): transport with the source, then diffusion. First order.
    Paper,
}

/// The choices behind a [`Diffusion`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Time integrator of the diffusion.
    pub integrator: Integrator,
    /// Scheme of the transport.
    pub advection: Advection,
    /// Order of operations.
    pub splitting: Splitting,
    /// eta: each implicit solve stops at max|r| <= eta max|phi - mean|, which bounds its error: all eigenvalues of
    /// I - beta Lap are at least 1.
    /// Mass is exact at any eta. That E' never grows is not: a step may add a share of E' of the order of eta². Measured per
    /// step, relative to the first E': 8e-12 at 1e-5, 8e-8 at 1e-3.
    pub tolerance: f64,
    /// Precision of the V-cycles.
    pub precision: Precision,
    /// Overrides the solver plan.
    pub plan: Option<Plan>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            integrator: Integrator::default(),
            advection: Advection::default(),
            splitting: Splitting::default(),
            tolerance: 1e-5,
            precision: Precision::Full,
            plan: None,
        }
    }
}

/// Parts of a step, for observers that measure them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Transport of phi and q_C by the medium.
    Transport,
    /// Diffusion, implicit or explicit.
    Diffusion,
}

/// Told when a phase begins and ends. `()` ignores it.
pub trait Observer {
    /// A phase begins.
    fn begin(&mut self, _phase: Phase) {}
    /// It ends.
    fn end(&mut self, _phase: Phase) {}
}

impl Observer for () {}

/// What a step did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepReport {
    /// Linear solves.
    pub solves: usize,
    /// Solver iterations, all solves together.
    pub iterations: usize,
    /// The most of one solve.
    pub most_iterations: usize,
    /// Largest residual of the solves, max|r| \[P\]: a bound of what they add to the error of phi.
    pub residual: f64,
    /// Explicit diffusion sub-steps.
    pub substeps: usize,
    /// Transport sub-steps.
    pub transport_substeps: usize,
    /// Mass that left through the walls by diffusion and transport \[P m^D\].
    pub outflow: f64,
    /// Mass emitted by the source \[P m^D\].
    pub emitted: f64,
    /// Estimated error of the diffusion in time, in the norm sqrt(2E') \[P m^(D/2)\], where it was asked for:
    /// [`Diffusion::estimate_errors`].
    pub error: Option<f64>,
}

/// A stepper of the C-F equations on one domain: scratch, solver and transport, all made once.
///
/// phi_t + div(u phi) + div q_C - div(k_F grad phi) = W, tau (q_C,t + div(q_C ⊗ u)) + q_C = - k_C grad phi.
pub struct Diffusion<T, const D: usize> {
    grid: Grid<D>,
    law: Law,
    settings: Settings,
    walls: Walls<T, D>,
    implicit: Option<Implicit<T, D>>,
    advector: Option<Advector<T, D>>,
    balance: Balance,
    embedded: Option<Embedded<T, D>>,
    pool: Pool<T>,
}

impl<T: Real, const D: usize> Diffusion<T, D> {
    /// A stepper for `law` on `grid` between `sides`, with obstacles where `mask` says solid.
    pub fn new(
        grid: &Grid<D>,
        sides: &Sides<Wall, D>,
        mask: Option<Mask<D>>,
        law: Law,
        settings: Settings,
    ) -> Result<Self, StepError> {
        if settings.integrator == Integrator::Kdk && !(law.tau() > 0.0 && law.fourier_share() == 0.0) {
            return Err(StepError::NeedsWaves { fourier: law.fourier_share(), tau: law.tau() });
        }
        if !(settings.tolerance > 0.0 && settings.tolerance < 1.0) {
            return Err(StepError::Tolerance(settings.tolerance));
        }
        for (axis, end, wall) in sides.walls() {
            let numbers = match wall {
                Wall::Flux(g) => [("flux", g, f64::NEG_INFINITY), ("flux", g, f64::NEG_INFINITY)],
                Wall::Value(v) => [("value", v, f64::NEG_INFINITY); 2],
                Wall::Absorbing { speed, far } => [("speed", speed, 0.0), ("far", far, f64::NEG_INFINITY)],
                Wall::Open { inflow } => [("inflow", inflow, f64::NEG_INFINITY); 2],
            };
            for (what, value, least) in numbers {
                if !value.is_finite() || value < least {
                    let expected = if least == 0.0 { "a finite number >= 0" } else { "a finite number" };
                    return Err(StepError::Wall { axis, end, what, value, expected });
                }
            }
        }
        if let Some(mask) = mask.as_ref().filter(|m| m.layout() != grid.layout()) {
            let (expected, found) = (grid.layout().slots(), mask.layout().slots());
            return Err(StepError::Layout { what: "the mask", expected, found });
        }
        let walls = Walls::new(grid.layout(), sides, mask);
        let implicit = (settings.integrator != Integrator::Kdk)
            .then(|| Implicit::new(grid.h(), settings.tolerance, settings.precision, settings.plan));
        Ok(Self {
            grid: *grid,
            law,
            settings,
            walls,
            implicit,
            advector: None,
            balance: Balance::default(),
            embedded: None,
            pool: Pool::default(),
        })
    }

    /// From now on scratch comes from `pool` and goes back to it within each step, so that others can use it between.
    pub fn share(&mut self, pool: &Pool<T>) {
        self.pool = pool.clone();
        if let Some(implicit) = &mut self.implicit {
            implicit.share(pool);
        }
        if let Some(advector) = &mut self.advector {
            advector.share(pool);
        }
    }

    /// The law.
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// The grid.
    pub fn grid(&self) -> &Grid<D> {
        &self.grid
    }

    /// The walls.
    pub fn sides(&self) -> &Sides<Wall, D> {
        &self.walls.sides
    }

    /// The obstacles.
    pub fn mask(&self) -> Option<&Mask<D>> {
        self.walls.mask.as_ref()
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The plan of the newest implicit solve with its number of levels; `None` before the first, or without solves.
    pub fn choice(&self) -> Option<(&Choice, usize)> {
        self.implicit.as_ref().and_then(Implicit::choice)
    }

    /// Bytes of scratch, solver and transport held now; what is in a shared pool does not count.
    pub fn bytes(&self) -> usize {
        let open = self.walls.open.as_ref().map_or(0, |o| o.bytes());
        let mask = self.walls.mask.as_ref().map_or(0, |m| m.fluid().len());
        open + mask
            + self.implicit.as_ref().map_or(0, Implicit::bytes)
            + self.advector.as_ref().map_or(0, Advector::bytes)
            + self.embedded.as_ref().map_or(0, Embedded::bytes)
    }

    /// Whether the next transport sweeps the last axis first: with the state, all that a resumed run needs.
    pub fn sweep_reversed(&self) -> bool {
        self.advector.as_ref().is_some_and(Advector::reversed)
    }

    /// Sets the order of the next transport sweep.
    pub fn set_sweep_reversed(&mut self, reversed: bool) {
        self.transport().set_reversed(reversed);
    }

    /// The largest stable explicit diffusion sub-step \[s\]; infinite for implicit integrators.
    pub fn explicit_limit(&self) -> f64 {
        match self.settings.integrator {
            Integrator::Kdk => explicit::limit::<D>(&self.law, self.grid.h()),
            _ => f64::INFINITY,
        }
    }

    /// Whether steps estimate their own error from now on: [`StepReport::error`], e = 1/2 ||K2 - K1|| of the two stages of
    /// Sdirk2. It costs no solve, but one more state of memory and 7 passes for each of its fields.
    ///
    /// # Errors
    /// [`StepError::NoEstimate`] for the other integrators.
    pub fn estimate_errors(&mut self, on: bool) -> Result<(), StepError> {
        match self.settings.integrator {
            _ if !on => self.embedded = None,
            Integrator::Sdirk2 => {
                let (grid, law) = (&self.grid, &self.law);
                self.embedded.get_or_insert_with(|| Embedded::new(grid, law));
            }
            Integrator::PaperBe => return Err(StepError::NoEstimate { integrator: "PaperBe" }),
            Integrator::Kdk => return Err(StepError::NoEstimate { integrator: "Kdk" }),
        }
        Ok(())
    }

    /// The norm sqrt(2E') of a state \[P m^(D/2)\], what [`StepReport::error`] is to be compared with.
    pub fn norm(&self, state: &State<T, D>) -> f64 {
        embedded::norm(&self.grid, &self.walls.sides, &self.law, state)
    }

    fn transport(&mut self) -> &mut Advector<T, D> {
        let (grid, walls, method, pool) = (&self.grid, &self.walls, self.settings.advection, &self.pool);
        self.advector.get_or_insert_with(|| {
            let mut advector = Advector::new(grid, &walls.sides, walls.mask.as_ref(), method);
            advector.share(pool);
            advector
        })
    }

    /// Advances `state` by `dt` \[s\] in `medium`. `dt` = 0 changes nothing.
    pub fn step(
        &mut self,
        state: &mut State<T, D>,
        medium: &Medium<T, D>,
        source: Source<'_, T>,
        dt: f64,
    ) -> Result<StepReport, StepError> {
        self.step_observed(state, medium, source, dt, &mut ())
    }

    /// [`step`](Self::step), telling `observer` of the phases.
    pub fn step_observed(
        &mut self,
        state: &mut State<T, D>,
        medium: &Medium<T, D>,
        source: Source<'_, T>,
        dt: f64,
        observer: &mut impl Observer,
    ) -> Result<StepReport, StepError> {
        let c = &COMPILED;
        once::<Step<T, D>>([&c.0, &c.1, &c.2, &c.3])(self, state, medium, source, dt, observer)
    }

    fn step_here(
        &mut self,
        state: &mut State<T, D>,
        medium: &Medium<T, D>,
        source: Source<'_, T>,
        dt: f64,
        observer: &mut dyn Observer,
    ) -> Result<StepReport, StepError> {
        if !(dt.is_finite() && dt >= 0.0) {
            return Err(StepError::TimeStep(dt));
        }
        self.check(state, source)?;
        let mut report = StepReport::default();
        if dt == 0.0 {
            return Ok(report);
        }
        let moving = !medium.is_still();
        // The semi-Lagrangian methods do not keep the mass: only the diffusion between them can.
        let conserves = !moving || self.settings.advection == Advection::Muscl;
        if conserves {
            self.balance.open(&self.walls, &state.phi, source, dt);
        }
        if moving {
            self.move_and_diffuse(state, medium, source, dt, &mut report, observer)?;
        } else {
            self.diffuse_into(state, source, dt, &mut report, observer)?;
        }
        if conserves {
            let gained = (report.emitted - report.outflow) / self.grid.cell_volume();
            self.balance.settle(&self.walls, &mut state.phi, gained);
        }
        Ok(report)
    }

    /// Transport and diffusion in the order of the splitting.
    fn move_and_diffuse(
        &mut self,
        state: &mut State<T, D>,
        medium: &Medium<T, D>,
        source: Source<'_, T>,
        dt: f64,
        report: &mut StepReport,
        observer: &mut dyn Observer,
    ) -> Result<(), StepError> {
        match (self.settings.splitting, self.settings.integrator) {
            (Splitting::Paper, _) => {
                self.carry_into(state, medium, dt, report, observer)?;
                self.emit_into(state, source, dt, report);
                self.diffuse_into(state, Source::NONE, dt, report, observer)?;
            }
            (Splitting::Strang, Integrator::Kdk) => {
                self.diffuse_into(state, source, 0.5 * dt, report, observer)?;
                self.carry_into(state, medium, dt, report, observer)?;
                self.diffuse_into(state, source, 0.5 * dt, report, observer)?;
            }
            (Splitting::Strang, _) => {
                self.carry_into(state, medium, 0.5 * dt, report, observer)?;
                self.diffuse_into(state, source, dt, report, observer)?;
                self.carry_into(state, medium, 0.5 * dt, report, observer)?;
            }
        }
        Ok(())
    }

    /// Refuses states of another law, and fields of another layout, which the sweeps could not index.
    pub(crate) fn check(&self, state: &State<T, D>, source: Source<'_, T>) -> Result<(), StepError> {
        if state.slow_flux.is_some() != self.law.has_memory() {
            return Err(StepError::SlowFlux { found: state.slow_flux.is_some() });
        }
        let expected = self.grid.layout().slots();
        let flux = state.slow_flux.iter().flat_map(|q| q.axes()).map(|q| ("the slow flux", q.len()));
        let rate = source.rate.iter().map(|rate| ("the source", rate.reach(expected)));
        match flux.chain(rate).chain([("phi", state.phi.len())]).find(|&(_, found)| found != expected) {
            Some((what, found)) => Err(StepError::Layout { what, expected, found }),
            None => Ok(()),
        }
    }

    fn carry_into(
        &mut self,
        state: &mut State<T, D>,
        medium: &Medium<T, D>,
        dt: f64,
        report: &mut StepReport,
        observer: &mut dyn Observer,
    ) -> Result<(), StepError> {
        observer.begin(Phase::Transport);
        let carried = self.transport().advect(&mut state.phi, state.slow_flux.as_mut(), medium, dt)?;
        observer.end(Phase::Transport);
        report.outflow += carried.outflow;
        report.transport_substeps += carried.substeps;
        Ok(())
    }

    /// Whether phi neither spreads nor passes walls by itself: k = 0 without memory, and no wall with a flux of its own.
    fn only_emits(&self) -> bool {
        let quiet = |wall: Wall| match wall {
            Wall::Flux(flux) => flux == 0.0,
            Wall::Value(_) | Wall::Open { .. } => true,
            Wall::Absorbing { .. } => false,
        };
        !self.law.has_memory() && self.law.k() == 0.0 && self.walls.sides.walls().all(|(_, _, wall)| quiet(wall))
    }

    /// phi += dt W, the explicit source of the paper's order.
    fn emit_into(&mut self, state: &mut State<T, D>, source: Source<'_, T>, dt: f64, report: &mut StepReport) {
        let Some(rate) = source.rate else { return };
        let layout = self.grid.layout();
        let amount = T::of(source.share * dt);
        let fluid = self.walls.mask.as_ref().map(|m| m.fluid());
        layout.par_runs(
            layout.cells_region(),
            &mut state.phi[..],
            #[inline(always)]
            |run, phi: &mut [T]| {
                let (skipped, rate) = rate.within(run.slot(), phi.len());
                for (i, (phi, &w)) in phi[skipped..].iter_mut().zip(rate).enumerate() {
                    if fluid.is_none_or(|f| f[run.slot() + skipped + i]) {
                        *phi += amount * w;
                    }
                }
            },
        );
        report.emitted += self.emitted(rate) * source.share * dt;
    }

    /// Mass a rate emits per second into fluid cells \[P m^D/s\].
    fn emitted(&self, rate: Rate<'_, T>) -> f64 {
        let fluid = self.walls.mask.as_ref().map(|m| m.fluid());
        rate.sum(self.grid.layout(), |slot| fluid.is_none_or(|f| f[slot])) * self.grid.cell_volume()
    }

    fn diffuse_into(
        &mut self,
        state: &mut State<T, D>,
        source: Source<'_, T>,
        dt: f64,
        report: &mut StepReport,
        observer: &mut dyn Observer,
    ) -> Result<(), StepError> {
        observer.begin(Phase::Diffusion);
        if self.only_emits() {
            self.emit_into(state, source, dt, report);
            observer.end(Phase::Diffusion);
            return Ok(());
        }
        let volume = self.grid.cell_volume();
        if let Some(rate) = source.rate {
            report.emitted += self.emitted(rate) * source.share * dt;
        }
        let mut count = |moved: Moved, share: f64| {
            report.outflow += share * moved.outflow * volume;
            report.iterations += moved.statistics.iterations;
            report.most_iterations = report.most_iterations.max(moved.statistics.iterations);
            report.residual = report.residual.max(moved.statistics.largest);
        };
        let Self { grid, walls, law, implicit, embedded, .. } = self;
        match implicit {
            None => {
                let limit = explicit::limit::<D>(law, grid.h());
                let substeps = (dt / limit).ceil().max(1.0);
                if substeps > MOST_SUBSTEPS {
                    return Err(StepError::Unstable { dt, limit });
                }
                report.substeps += substeps as usize;
                count(explicit::advance(walls, grid.h(), law, state, source, dt, substeps as usize)?, 1.0);
            }
            Some(stages) if self.settings.integrator == Integrator::PaperBe => {
                count(stages.stage(walls, law, state, source, dt, 1.0)?, 1.0);
                report.solves += 1;
            }
            Some(stages) => {
                // Y1 = BE(gamma dt) U; Y2 = BE(gamma dt) (U + (1-gamma)/gamma (Y1 - U)); the stretch makes the start of
                // the second stage in place.
                let gamma = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
                let stretch = (1.0 - gamma) / gamma;
                if let Some(embedded) = embedded {
                    embedded.begin(grid, &walls.sides, state);
                }
                count(stages.stage(walls, law, state, source, gamma * dt, stretch)?, stretch);
                if let Some(embedded) = embedded {
                    embedded.between(grid, &walls.sides, state, gamma);
                }
                count(stages.stage(walls, law, state, source, gamma * dt, 1.0)?, 1.0);
                report.solves += 2;
                report.error = embedded.as_mut().map(|e| e.end(grid, &walls.sides, law, state, gamma));
            }
        }
        if let Some(stages) = &mut self.implicit {
            stages.release();
        }
        observer.end(Phase::Diffusion);
        Ok(())
    }
}

/// A step of one precision and dimension.
type Step<T, const D: usize> = fn(
    &mut Diffusion<T, D>,
    &mut State<T, D>,
    &Medium<T, D>,
    Source<'_, T>,
    f64,
    &mut dyn Observer,
) -> Result<StepReport, StepError>;

/// Steps are compiled here, once, and not again in every crate that makes some.
static COMPILED: (Step<f32, 2>, Step<f64, 2>, Step<f32, 3>, Step<f64, 3>) =
    (Diffusion::step_here, Diffusion::step_here, Diffusion::step_here, Diffusion::step_here);

/// More explicit sub-steps than this in one step are refused: an implicit integrator is faster by far.
const MOST_SUBSTEPS: f64 = 1e5;
