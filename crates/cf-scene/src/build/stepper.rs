//! Who makes a step, with the unknowns it works on. A further scheme is a further variant here and nowhere else.

use super::BuildError;
use super::flow::{self, MakeFlow};
use super::fluid::Carried;
use crate::model::{FlowStep, Number, StepFailure, Values, ValuesMut};
use crate::pace::Pace;
use crate::scene::{self, Numerics};
use crate::spec::{self, Flow, Solver};
use crate::stopwatch::Stopwatch;
use crate::summary::HcSummary;
use cf_diffusion::front::{Front, FrontState};
use cf_diffusion::{AdvectError, Advection, Diffusion, Integrator, Law, Medium, Settings, Source, Splitting, State};
use cf_diffusion::{Observer, Phase, StepReport};
use cf_fluid::Fluid;
use cf_grid::{CellField, FaceField, Grid, Mask, Sides, Wall};
use cf_linear::Plan;
use nalgebra::SVector;

/// A stepper with its unknowns.
pub(super) enum Stepper<T, const D: usize> {
    /// Transport and diffusion alternate; the flux lives on faces.
    Split(Box<Split<T, D>>),
    /// Waves along their characteristics; the flux lives in cells.
    Front(Box<Along<T, D>>),
    /// A solved fluid, and what it carries.
    Coupled(Box<Carried<T, D>>),
}

/// Waves of a medium that is still or uniform.
pub(super) struct Along<T, const D: usize> {
    front: Front<T, D>,
    state: FrontState<T, D>,
    medium: Medium<T, D>,
}

/// Transport and diffusion in turn.
pub(super) struct Split<T, const D: usize> {
    diffusion: Diffusion<T, D>,
    state: State<T, D>,
    medium: Medium<T, D>,
    /// A medium that changes with time, with how to make it.
    changing: Option<(Flow, MakeFlow<T, D>)>,
}

/// What a stepper is made of besides its numerics.
pub(super) struct Domain<'a, T, const D: usize> {
    pub grid: &'a Grid<D>,
    pub sides: Sides<Wall, D>,
    pub mask: Option<Mask<D>>,
    pub law: Law,
    pub medium: &'a spec::Medium,
    pub fluid: Option<&'a scene::Fluid>,
    pub make: MakeFlow<T, D>,
}

/// The velocity of the medium, where it lives.
pub(super) enum Velocity<'a, T, const D: usize> {
    /// There is none.
    None,
    /// The same everywhere.
    Uniform(SVector<f64, D>),
    /// Normal components on faces.
    Faces(&'a FaceField<T, D>),
}

/// The flux with memory, where it lives.
pub(super) enum Flux<'a, T, const D: usize> {
    /// There is none.
    None,
    /// Normal components on faces.
    Faces(&'a FaceField<T, D>),
    /// Components in cells.
    Cells(&'a [CellField<T>; D]),
}

const FLUX: [&str; 3] = ["q_C along x", "q_C along y", "q_C along z"];

impl<T: Number, const D: usize> Stepper<T, D> {
    pub fn new(domain: Domain<'_, T, D>, numerics: &Numerics, pace: &Pace) -> Result<Self, BuildError> {
        if let Some(fluid) = domain.fluid {
            return Ok(Stepper::Coupled(Box::new(Carried::new(domain, fluid, numerics, pace)?)));
        }
        let Domain { grid, sides, mask, law, medium, make, .. } = domain;
        let (medium, changing) = match medium {
            // A fluid that was not resolved does not move.
            spec::Medium::Still | spec::Medium::Solved { .. } => (Medium::Still, None),
            spec::Medium::Uniform(u) => {
                let wrong = BuildError::Dimension { axes: D, what: "such medium" };
                (Medium::Uniform(SVector::from(u.to_array().ok_or(wrong)?)), None)
            }
            spec::Medium::Analytic(flow) => {
                let changing = flow::changes(flow).then(|| (flow.clone(), make));
                (Medium::Field(make(grid, flow, 0.0)?), changing)
            }
        };
        medium.check(grid, &sides)?;
        if pace.integrator == Some(spec::Integrator::Characteristic) {
            let velocity = match &medium {
                Medium::Uniform(u) => *u,
                Medium::Still => SVector::zeros(),
                Medium::Field(_) => {
                    return Err(BuildError::Dimension { axes: D, what: "front scheme in a varying medium" });
                }
            };
            let front = Front::new(grid, &sides, law, velocity)?;
            return Ok(Stepper::Front(Box::new(Along { front, state: FrontState::new(grid), medium })));
        }
        let state = State::new(grid, &law);
        let diffusion = Diffusion::new(grid, &sides, mask, law, settings(numerics, pace))?;
        Ok(Stepper::Split(Box::new(Split { diffusion, state, medium, changing })))
    }

    pub fn step(
        &mut self,
        from: f64,
        dt: f64,
        source: Source<'_, T>,
        watch: &mut Stopwatch,
    ) -> Result<StepReport, StepFailure> {
        let split = match self {
            Stepper::Split(split) => split,
            Stepper::Coupled(carried) => return carried.step(from, dt, source, watch),
            Stepper::Front(along) => {
                watch.begin(Phase::Diffusion);
                let report = along.front.step(&mut along.state, source, dt);
                watch.end(Phase::Diffusion);
                return Ok(report?);
            }
        };
        if let Some((flow, make)) = &split.changing {
            let velocity = make(split.diffusion.grid(), flow, from + 0.5 * dt);
            split.medium = Medium::Field(velocity.map_err(AdvectError::from).map_err(cf_diffusion::StepError::from)?);
        }
        let Split { diffusion, state, medium, .. } = &mut **split;
        Ok(diffusion.step_observed(state, medium, source, dt, watch)?)
    }

    pub fn phi(&self) -> &CellField<T> {
        match self {
            Stepper::Split(split) => &split.state.phi,
            Stepper::Front(along) => &along.state.phi,
            Stepper::Coupled(carried) => &carried.state.phi,
        }
    }

    pub fn phi_mut(&mut self) -> &mut CellField<T> {
        match self {
            Stepper::Split(split) => &mut split.state.phi,
            Stepper::Front(along) => &mut along.state.phi,
            Stepper::Coupled(carried) => &mut carried.state.phi,
        }
    }

    /// phi, with the cells that are not solid.
    pub fn held_mut(&mut self) -> (&mut CellField<T>, Option<&Mask<D>>) {
        match self {
            Stepper::Split(split) => (&mut split.state.phi, split.diffusion.mask()),
            Stepper::Front(along) => (&mut along.state.phi, None),
            Stepper::Coupled(carried) => (&mut carried.state.phi, carried.coupled.diffusion.mask()),
        }
    }

    pub fn flux(&self) -> Flux<'_, T, D> {
        match self {
            Stepper::Split(split) => split.state.slow_flux.as_ref().map_or(Flux::None, Flux::Faces),
            Stepper::Front(along) => Flux::Cells(&along.state.flux),
            Stepper::Coupled(carried) => carried.state.slow_flux.as_ref().map_or(Flux::None, Flux::Faces),
        }
    }

    /// phi and the parts of the flux, out of everything else.
    pub fn into_fields(self) -> (CellField<T>, Vec<CellField<T>>) {
        let of_state = |state: State<T, D>| {
            let flux = state.slow_flux.map(|mut flux| flux.fields_mut().each_mut().map(std::mem::take));
            (state.phi, flux.into_iter().flatten().collect())
        };
        match self {
            Stepper::Split(split) => of_state(split.state),
            Stepper::Front(along) => (along.state.phi, along.state.flux.into_iter().collect()),
            Stepper::Coupled(carried) => of_state(carried.state),
        }
    }

    /// The velocity of the medium.
    pub fn velocity(&self) -> Velocity<'_, T, D> {
        let medium = match self {
            Stepper::Split(split) => &split.medium,
            Stepper::Front(along) => &along.medium,
            Stepper::Coupled(carried) => {
                return carried.fluid().map_or(Velocity::None, |fluid| Velocity::Faces(fluid.velocity()));
            }
        };
        match medium {
            Medium::Still => Velocity::None,
            Medium::Uniform(u) => Velocity::Uniform(*u),
            Medium::Field(u) => Velocity::Faces(u),
        }
    }

    /// The solved fluid.
    pub fn fluid(&self) -> Option<&Fluid<T, D>> {
        if let Stepper::Coupled(carried) = self { carried.fluid() } else { None }
    }

    /// What the last step of a solved fluid did.
    pub fn flow(&self) -> Option<FlowStep> {
        if let Stepper::Coupled(carried) = self { carried.last } else { None }
    }

    /// |u|/c of a solved fluid.
    pub fn hc(&self) -> Option<HcSummary> {
        if let Stepper::Coupled(carried) = self { carried.hc() } else { None }
    }

    /// The longest step \[s\] that a solved fluid may make now for a Courant number.
    pub fn longest(&mut self, time: f64, cfl: f64) -> f64 {
        if let Stepper::Coupled(carried) = self { carried.longest(time, cfl) } else { f64::INFINITY }
    }

    pub fn sides(&self) -> &Sides<Wall, D> {
        match self {
            Stepper::Split(split) => split.diffusion.sides(),
            Stepper::Front(along) => along.front.sides(),
            Stepper::Coupled(carried) => carried.coupled.diffusion.sides(),
        }
    }

    /// Bytes of scratch, solver and transport.
    pub fn bytes(&self) -> usize {
        match self {
            Stepper::Split(split) => split.diffusion.bytes(),
            Stepper::Front(along) => along.front.bytes(),
            Stepper::Coupled(carried) => carried.coupled.diffusion.bytes(),
        }
    }

    /// The plan of the linear solver and its reason.
    pub fn solver(&self) -> (String, String) {
        let choice = match self {
            Stepper::Split(split) => split.diffusion.choice(),
            Stepper::Coupled(carried) => carried.coupled.diffusion.choice(),
            Stepper::Front(_) => None,
        };
        match choice {
            None => ("none".into(), "explicit steps need no solver".into()),
            Some((choice, levels)) if choice.plan == Plan::Multigrid => {
                (format!("Multigrid, {levels} levels"), choice.reason.clone())
            }
            Some((choice, _)) => (format!("{:?}", choice.plan), choice.reason.clone()),
        }
    }

    /// All unknowns by name.
    pub fn unknowns(&self) -> Vec<(&'static str, Values<'_>)> {
        let flux: Vec<&[T]> = match self {
            Stepper::Split(split) => split.state.slow_flux.iter().flat_map(|flux| flux.axes()).collect(),
            Stepper::Front(along) => along.state.flux.iter().map(|axis| &axis[..]).collect(),
            Stepper::Coupled(carried) => carried.state.slow_flux.iter().flat_map(|flux| flux.axes()).collect(),
        };
        let flux = FLUX.into_iter().zip(flux).map(|(name, values)| (name, T::values(values)));
        let flow = if let Stepper::Coupled(carried) = self { carried.unknowns() } else { Vec::new() };
        std::iter::once(("phi", T::values(self.phi()))).chain(flux).chain(flow).collect()
    }

    /// The same, to be filled.
    pub fn unknowns_mut(&mut self) -> Vec<(&'static str, ValuesMut<'_>)> {
        let (phi, flux, flow): (&mut [T], Vec<&mut [T]>, _) = match self {
            Stepper::Split(split) => {
                let flux = split.state.slow_flux.iter_mut().flat_map(|flux| flux.axes_mut());
                (&mut split.state.phi, flux.collect(), Vec::new())
            }
            Stepper::Front(along) => {
                (&mut along.state.phi, along.state.flux.iter_mut().map(|axis| &mut axis[..]).collect(), Vec::new())
            }
            Stepper::Coupled(carried) => {
                let (state, flow) = carried.split_mut();
                let flux = state.slow_flux.iter_mut().flat_map(|flux| flux.axes_mut());
                (&mut state.phi, flux.collect(), flow)
            }
        };
        let flux = FLUX.into_iter().zip(flux).map(|(name, values)| (name, T::values_mut(values)));
        std::iter::once(("phi", T::values_mut(phi))).chain(flux).chain(flow).collect()
    }

    /// Whether steps estimate their own error from now on; only Sdirk2 can.
    pub fn estimate(&mut self, on: bool) {
        // The others say that they cannot, and do not.
        let _ = match self {
            Stepper::Split(split) => split.diffusion.estimate_errors(on),
            Stepper::Coupled(carried) => carried.coupled.diffusion.estimate_errors(on),
            Stepper::Front(_) => Ok(()),
        };
    }

    /// The norm of the state that those estimates are to be compared with.
    pub fn norm(&self) -> f64 {
        match self {
            Stepper::Split(split) => split.diffusion.norm(&split.state),
            Stepper::Coupled(carried) => carried.coupled.diffusion.norm(&carried.state),
            Stepper::Front(_) => 0.0,
        }
    }

    /// The order of the next sweep, which is part of the state.
    pub fn reversed(&self) -> bool {
        match self {
            Stepper::Split(split) => split.diffusion.sweep_reversed(),
            Stepper::Coupled(carried) => carried.coupled.diffusion.sweep_reversed(),
            Stepper::Front(along) => along.front.sweep_reversed(),
        }
    }

    pub fn set_reversed(&mut self, reversed: bool) {
        match self {
            _ if reversed == self.reversed() => {}
            Stepper::Split(split) => split.diffusion.set_sweep_reversed(reversed),
            Stepper::Coupled(carried) => carried.coupled.diffusion.set_sweep_reversed(reversed),
            Stepper::Front(along) => along.front.set_sweep_reversed(reversed),
        }
    }
}

pub(super) fn settings(numerics: &Numerics, pace: &Pace) -> Settings {
    Settings {
        integrator: match pace.integrator {
            Some(spec::Integrator::PaperBe) => Integrator::PaperBe,
            Some(spec::Integrator::Kdk) => Integrator::Kdk,
            Some(spec::Integrator::Sdirk2 | spec::Integrator::Characteristic) | None => Integrator::Sdirk2,
        },
        advection: match numerics.advection {
            spec::Advection::Muscl => Advection::Muscl,
            spec::Advection::Cubic => Advection::Cubic,
            spec::Advection::Linear => Advection::Linear,
        },
        splitting: match numerics.splitting {
            spec::Splitting::Strang => Splitting::Strang,
            spec::Splitting::Lie => Splitting::Paper,
        },
        tolerance: numerics.tolerance,
        precision: numerics.precision.cycles(),
        plan: match numerics.solver {
            Solver::Auto => None,
            Solver::Multigrid => Some(Plan::Multigrid),
            Solver::Chebyshev => Some(Plan::Chebyshev),
        },
    }
}
