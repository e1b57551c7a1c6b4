//! The choices behind a flow, and what a step tells.

use cf_linear::Precision;

use crate::carry::Interpolation;
use crate::error::FlowError;

/// How the velocity is advanced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scheme {
    /// [`Cnp`](Self::Cnp) up to CFL_u = 1, [`ReflectionExtrapolated`](Self::ReflectionExtrapolated) above, step by step.
    #[default]
    Auto,
    /// Half of the pressure gradient is carried along, the advecting velocity extrapolated to the middle of the step:
    /// second order with one projection. For CFL_u up to 1.
    Cnp,
    /// Advection-reflection with extrapolated advecting velocities: second order with two projections, for large steps.
    ReflectionExtrapolated,
    /// Advection by u^n, one projection: first order.
    Draft,
    /// Energy-conserving central differences and RK4 with a projection per stage: for verification, CFL_u below 1.
    CentralRk4,
}

impl Scheme {
    /// Whether the pressure of a step is needed for the next.
    pub fn keeps_pressure(self) -> bool {
        matches!(self, Self::Auto | Self::Cnp)
    }

    /// Whether the velocity before the last is needed for the next.
    pub fn keeps_before(self) -> bool {
        self != Self::Draft
    }

    /// How many potentials are kept as guesses for the next step. The pressure that [`Self::Cnp`] carries is its guess: what is
    /// left to find is the increment.
    pub fn potentials(self) -> usize {
        match self {
            Self::Cnp => 0,
            Self::Draft | Self::CentralRk4 => 1,
            Self::Auto | Self::ReflectionExtrapolated => 2,
        }
    }
}

/// Buoyancy b = strength (phi - reference) up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Buoyancy<const D: usize> {
    /// g beta \[m/s² per P\].
    pub strength: f64,
    /// phi of the fluid that neither rises nor sinks \[P\].
    pub reference: f64,
    /// Unit vector against gravity.
    pub up: [f64; D],
}

/// The choices behind a [`Fluid`](crate::Fluid).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowSettings<const D: usize> {
    /// Time stepping.
    pub scheme: Scheme,
    /// How values are found between others; `None`: cubic, MacCormack for [`Scheme::Draft`].
    pub interpolation: Option<Interpolation>,
    /// Each projection ends with max|div u| dt <= eta_div: 1e-2 for drafts, 1e-4 by default, 1e-7 for references.
    pub eta_div: f64,
    /// Precision of the V-cycles.
    pub precision: Precision,
    /// Whether pressure solves start from the solution of the step before; those of [`Scheme::Cnp`] always start from the pressure.
    pub warm_start: bool,
    /// Body force \[m/s²\].
    pub force: [f64; D],
    /// Force from the transported quantity; `None`: it is passive.
    pub buoyancy: Option<Buoyancy<D>>,
}

impl<const D: usize> Default for FlowSettings<D> {
    fn default() -> Self {
        Self {
            scheme: Scheme::default(),
            interpolation: None,
            eta_div: 1e-4,
            precision: Precision::Full,
            warm_start: true,
            force: [0.0; D],
            buoyancy: None,
        }
    }
}

impl<const D: usize> FlowSettings<D> {
    pub(crate) fn check(&self) -> Result<(), FlowError> {
        let refuse = |name, found, expected| Err(FlowError::Setting { name, found, expected });
        if !(self.eta_div > 0.0 && self.eta_div.is_finite()) {
            return refuse("eta_div", self.eta_div, "a finite number above 0");
        }
        let buoyancy = self.buoyancy.iter().flat_map(|b| b.up.into_iter().chain([b.strength, b.reference]));
        if let Some(found) = self.force.into_iter().find(|f| !f.is_finite()) {
            return refuse("force", found, "a finite acceleration");
        }
        if let Some(found) = buoyancy.into_iter().find(|b| !b.is_finite()) {
            return refuse("buoyancy", found, "finite numbers");
        }
        Ok(())
    }
}

/// What a step of a flow did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FlowReport {
    /// The scheme used; never [`Scheme::Auto`].
    pub scheme: Scheme,
    /// CFL_u = max|u_a| dt/h at the start of the step.
    pub courant: f64,
    /// Projections made.
    pub projections: usize,
    /// Solver iterations, all projections together.
    pub iterations: usize,
    /// The most of one projection.
    pub most_iterations: usize,
    /// Largest max|div u| dt after any projection.
    pub divergence: f64,
    /// Largest mean of div u \[1/s\] that held velocities force on a part of the fluid; 0 where they balance.
    pub imbalance: f64,
    /// A projection ended at the rounding floor of the precision, above eta_div.
    pub at_floor: bool,
}

impl FlowReport {
    pub(crate) fn count(&mut self, done: crate::Projected) {
        self.projections += 1;
        self.iterations += done.iterations;
        self.most_iterations = self.most_iterations.max(done.iterations);
        self.divergence = self.divergence.max(done.divergence);
        self.imbalance = self.imbalance.max(done.imbalance);
        self.at_floor |= done.at_floor;
    }
}

/// Parts of a step, for observers that measure them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlowPhase {
    /// Semi-Lagrangian or central transport of the velocity, and forces.
    Advection,
    /// The pressure solve.
    Projection,
}

/// Told when a phase begins and ends. `()` ignores it.
pub trait FlowObserver {
    /// A phase begins.
    fn begin(&mut self, _phase: FlowPhase) {}
    /// It ends.
    fn end(&mut self, _phase: FlowPhase) {}
}

impl FlowObserver for () {}
