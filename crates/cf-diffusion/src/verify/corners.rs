//! The corners: one random case each, in units of what is allowed.

mod bounds;
mod budget;
mod exactness;
mod limits;

pub(super) use bounds::{Explicit, LongRun, Residual, Single, Stiffness, Transport, Walls};
pub(super) use budget::{Budget, Fronts};
pub(super) use exactness::{Amplitude, Input, Offset, Pockets, Spacing};
pub(super) use limits::{Diffusivity, Relaxation, Share, Step};

use cf_grid::Real;

use super::Measured;
use super::amplification::step_for;
use super::case::{Case, Kinds};
use super::random::Random;
use crate::{Integrator, Law, State};

/// An integrator with linear solves.
fn implicit(random: &mut Random) -> Integrator {
    random.pick([Integrator::PaperBe, Integrator::Sdirk2])
}

/// F_T from its edges or between.
fn share(random: &mut Random) -> f64 {
    let between = random.unit();
    random.pick([0.0, 1.0, 1e-12, 1.0 - 1e-12, between])
}

/// A random box and law with a step of the given kappa.
fn stiff<const D: usize>(random: &mut Random, kinds: Kinds, kappa: f64) -> Measured<Case<D>> {
    let law = Law::new(random.decades(-3.0, 3.0), random.decades(-3.0, 3.0), share(random))?;
    let h = random.decades(-2.0, 2.0);
    let mut case = Case::new([1; D], h, law, implicit(random), step_for(&law, kappa * h * h))?;
    case.random_box(random, kinds, if D == 2 { 12 } else { 6 })?;
    Ok(case)
}

/// Whether two states hold the same numbers in cells and on faces. What is too small for `f32` and the sign of a zero do
/// not count.
fn same<T: Real, const D: usize>(one: &State<T, D>, other: &State<T, D>, case: &Case<D>) -> bool {
    let layout = case.grid.layout();
    let mut same = true;
    layout.each_cell(layout.cells_region(), |at| {
        let numbers = |state: &State<T, D>| {
            let q = state.slow_flux.iter().flat_map(|q| q.axes()).map(|q| q[at.slot()].f64());
            std::iter::once(state.phi[at.slot()].f64()).chain(q).collect::<Vec<_>>()
        };
        same &= numbers(one).into_iter().zip(numbers(other)).all(|(a, b)| a == b || (a - b).abs() < 1e-36);
    });
    same
}

/// 0 if a statement holds, else a failure with a reason.
fn require(holds: bool, what: &str) -> Measured {
    if holds { Ok(0.0) } else { Err(what.into()) }
}

fn finite<T: Real, const D: usize>(case: &Case<D>, state: &State<T, D>) -> bool {
    let layout = case.grid.layout();
    let faces = state.slow_flux.iter().flat_map(|q| q.axes());
    std::iter::once(&state.phi[..]).chain(faces).all(|x| layout.max_abs(x).is_finite())
}
