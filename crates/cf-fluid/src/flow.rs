//! Where the velocity comes from: given, or solved for.

use cf_diffusion::Medium;
use cf_grid::{CellField, Real};

use crate::error::FlowError;
use crate::fluid::Fluid;
use crate::settings::{FlowObserver, FlowReport};

/// The motion that carries a quantity.
pub enum Flow<T, const D: usize> {
    /// A given velocity: at rest, uniform, or a field of the caller's. No pressure exists and nothing is solved.
    Prescribed(Medium<T, D>),
    /// A fluid.
    Solved(Box<Fluid<T, D>>),
}

impl<T: Real, const D: usize> Flow<T, D> {
    /// Bytes of all storage.
    pub fn bytes(&self) -> usize {
        match self {
            Flow::Prescribed(medium) => medium.bytes(),
            Flow::Solved(fluid) => fluid.bytes(),
        }
    }

    /// The fluid, if there is one.
    pub fn fluid(&self) -> Option<&Fluid<T, D>> {
        match self {
            Flow::Prescribed(_) => None,
            Flow::Solved(fluid) => Some(fluid),
        }
    }

    /// Begins a step of `dt` \[s\]: the velocity that carries other quantities over it.
    pub fn begin(
        &mut self,
        dt: f64,
        phi: Option<&CellField<T>>,
        observer: &mut impl FlowObserver,
    ) -> Result<&Medium<T, D>, FlowError> {
        match self {
            Flow::Prescribed(medium) => Ok(medium),
            Flow::Solved(fluid) => fluid.begin(dt, phi, observer),
        }
    }

    /// Ends the step; `None` where nothing was solved.
    pub fn finish(
        &mut self,
        phi: Option<&CellField<T>>,
        observer: &mut impl FlowObserver,
    ) -> Result<Option<FlowReport>, FlowError> {
        match self {
            Flow::Prescribed(_) => Ok(None),
            Flow::Solved(fluid) => fluid.finish(phi, observer).map(Some),
        }
    }
}
