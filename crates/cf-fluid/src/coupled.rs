//! A fluid that carries a diffusing quantity, in symmetric (Strang) order or in the paper's.
//!
//! | | [`Splitting::Strang`](cf_diffusion::Splitting::Strang) with a second-order scheme | [`Splitting::Paper`](cf_diffusion::Splitting::Paper) with [`Scheme::Draft`](crate::Scheme::Draft) |
//! |---|---|---|
//! | 1 | emitters | emitters |
//! | 2 | u of the middle of the step | phi, q_C carried by u^n |
//! | 3 | half of the transport (or diffusion) of phi, q_C | their diffusion |
//! | 4 | all of their diffusion (or transport) | u^n carried by itself |
//! | 5 | the other half | projection |
//! | 6 | u to the end of the step | |
//!
//! Buoyancy acts with phi of the start and of the end of the step, half each: that of the start is carried along with u (trapezoidal rule
//! along trajectories), so that the step is of second order with it too.

use cf_diffusion::{Diffusion, Observer, Source, State, StepReport};
use cf_grid::{CellField, Pool, Real};

use crate::emit::{Emission, Emitter};
use crate::error::FlowError;
use crate::flow::Flow;
use crate::settings::{FlowObserver, FlowReport};

/// A flow, what it carries, and where both enter.
pub struct Coupled<T, const D: usize> {
    /// The motion.
    pub flow: Flow<T, D>,
    /// The law of what is carried.
    pub diffusion: Diffusion<T, D>,
    emitters: Vec<Emitter<D>>,
    rate: Option<CellField<T>>,
    /// Shares of the step for which `rate` was made.
    shares: Vec<f64>,
    time: f64,
    /// Scratch of both, which take turns.
    pool: Pool<T>,
}

/// What a coupled step did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CoupledReport {
    /// Transport and diffusion of phi.
    pub scalar: StepReport,
    /// The flow; `None` where it is prescribed.
    pub flow: Option<FlowReport>,
    /// Mass added where emitters hold values \[P m^D\].
    pub set: f64,
}

impl<T: Real, const D: usize> Coupled<T, D> {
    /// Couples a flow with a diffusion stepper on the same grid, with the same obstacles. The emitters' jets belong to the fluid,
    /// [`Fluid::with_emitters`](crate::Fluid::with_emitters); here they emit phi.
    pub fn new(
        mut flow: Flow<T, D>,
        mut diffusion: Diffusion<T, D>,
        emitters: &[Emitter<D>],
    ) -> Result<Self, FlowError> {
        emitters.iter().try_for_each(Emitter::check)?;
        if let Some(fluid) = flow.fluid() {
            let (expected, found) = (diffusion.grid().layout().slots(), fluid.grid().layout().slots());
            let masks = [diffusion.mask(), fluid.mask()].map(|m| m.map_or(0, |m| m.fluid_cells()));
            if fluid.grid() != diffusion.grid() {
                return Err(FlowError::Layout { what: "the flow's grid", expected, found });
            }
            if diffusion.mask() != fluid.mask() {
                return Err(FlowError::Layout { what: "the flow's mask", expected: masks[0], found: masks[1] });
            }
        }
        let rates = emitters.iter().any(|e| matches!(e.emission, Some(Emission::Rate(_))));
        let rate = rates.then(|| CellField::new(diffusion.grid().layout()));
        let mut pool = Pool::default();
        if let Flow::Solved(fluid) = &mut flow {
            pool = Pool::new();
            fluid.share(&pool);
            diffusion.share(&pool);
        }
        Ok(Self { flow, diffusion, emitters: emitters.to_vec(), rate, shares: Vec::new(), time: 0.0, pool })
    }

    /// Time \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Sets the time \[s\], which only emitters read.
    pub fn set_time(&mut self, time: f64) {
        self.time = time;
        if let Flow::Solved(fluid) = &mut self.flow {
            fluid.set_time(time);
        }
    }

    /// H_c = max|u_a|/c of the fluid as it is now; `None` without a finite speed or without a fluid.
    pub fn hc(&self) -> Option<f64> {
        Some(self.flow.fluid()?.max_speed() / self.diffusion.law().speed()?)
    }

    /// Bytes of flow, diffusion and sources.
    pub fn bytes(&self) -> usize {
        self.flow.bytes() + self.diffusion.bytes() + self.pool.bytes() + self.rate.as_ref().map_or(0, CellField::bytes)
    }

    /// Advances flow and `state` by `dt` \[s\].
    pub fn step(&mut self, state: &mut State<T, D>, dt: f64) -> Result<CoupledReport, FlowError> {
        self.step_observed(state, dt, &mut ())
    }

    /// [`step`](Self::step), telling `observer` of the phases.
    pub fn step_observed(
        &mut self,
        state: &mut State<T, D>,
        dt: f64,
        observer: &mut (impl Observer + FlowObserver),
    ) -> Result<CoupledReport, FlowError> {
        if !(dt.is_finite() && dt >= 0.0) {
            return Err(FlowError::TimeStep(dt));
        }
        let (expected, found) = (self.diffusion.grid().layout().slots(), state.phi.len());
        if expected != found {
            return Err(FlowError::Layout { what: "phi", expected, found });
        }
        let mut report = CoupledReport::default();
        for emitter in &self.emitters {
            if dt > 0.0 && emitter.acts(self.time, dt) {
                report.set += emitter.set_value(self.diffusion.grid(), self.diffusion.mask(), &mut state.phi);
            }
        }
        self.prepare_rate(dt);
        let Self { flow, diffusion, rate, .. } = self;
        let source = rate.as_ref().map_or(Source::NONE, |rate| Source::steady(rate));
        (report.scalar, report.flow) = together(flow, diffusion, state, source, dt, observer)?;
        self.time += dt;
        Ok(report)
    }

    /// [`step_observed`](Self::step_observed) with a source of phi of the caller's instead of the emitters' rates and values.
    pub fn step_with(
        &mut self,
        state: &mut State<T, D>,
        source: Source<'_, T>,
        dt: f64,
        observer: &mut (impl Observer + FlowObserver),
    ) -> Result<CoupledReport, FlowError> {
        if !(dt.is_finite() && dt >= 0.0) {
            return Err(FlowError::TimeStep(dt));
        }
        let (scalar, flow) = together(&mut self.flow, &mut self.diffusion, state, source, dt, observer)?;
        self.time += dt;
        Ok(CoupledReport { scalar, flow, set: 0.0 })
    }

    /// The rate of all emitters over a step, made anew when their shares of it change.
    fn prepare_rate(&mut self, dt: f64) {
        let Some(rate) = &mut self.rate else { return };
        let shares: Vec<f64> = self.emitters.iter().map(|e| e.share(self.time, dt)).collect();
        if shares == self.shares {
            return;
        }
        rate.fill(T::ZERO);
        let (grid, mask) = (self.diffusion.grid(), self.diffusion.mask());
        for (emitter, share) in self.emitters.iter().zip(&shares) {
            if let (Some(Emission::Rate(w)), true) = (emitter.emission, *share > 0.0) {
                emitter.each_cell(grid, mask, |slot| rate[slot] += T::of(w * share));
            }
        }
        self.shares = shares;
    }
}

/// The first half of the flow's step, what is carried over it, the second half.
fn together<T: Real, const D: usize>(
    flow: &mut Flow<T, D>,
    diffusion: &mut Diffusion<T, D>,
    state: &mut State<T, D>,
    source: Source<'_, T>,
    dt: f64,
    observer: &mut (impl Observer + FlowObserver),
) -> Result<(StepReport, Option<FlowReport>), FlowError> {
    let medium = flow.begin(dt, Some(&state.phi), observer)?;
    match diffusion.step_observed(state, medium, source, dt, observer) {
        Ok(scalar) => Ok((scalar, flow.finish(Some(&state.phi), observer)?)),
        Err(error) => {
            if let Flow::Solved(fluid) = flow {
                fluid.abandon();
            }
            Err(error.into())
        }
    }
}
