//! Everything at once, and the scheme for fronts.

use cf_grid::{Axis, Sides, Wall};
use nalgebra::SVector;

use super::share;
use crate::front::{Front, FrontState};
use crate::verify::Measured;
use crate::verify::amplification::{Precise, step_for};
use crate::verify::case::{Case, Kinds};
use crate::verify::conservation::mass_error;
use crate::verify::extremes::Check;
use crate::verify::random::Random;
use crate::{Integrator, Law, Medium, Source, kdk_limit};

fn most<const D: usize>() -> usize {
    if D == 2 { 12 } else { 6 }
}

/// Every integrator between every kind of wall, with obstacles and sources.
pub(in crate::verify) struct Budget;

impl Check for Budget {
    const NAME: &'static str = "budget";
    const EXPECTED: &'static str =
        "every integrator, wall, obstacle and source: finite, and mass = start + emitted - outflow";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let integrator = random.pick([Integrator::PaperBe, Integrator::Sdirk2, Integrator::Kdk]);
        let explicit = integrator == Integrator::Kdk;
        let law =
            Law::new(random.decades(-3.0, 3.0), random.decades(-3.0, 3.0), if explicit { 0.0 } else { share(random) })?;
        let h = random.decades(-2.0, 2.0);
        let kappa = random.decades(-6.0, 3.0);
        let dt = if explicit {
            random.between(0.1, 3.0) * kdk_limit(&law, 4.0 * D as f64 / (h * h))
        } else {
            step_for(&law, kappa * h * h)
        };
        let mut case = Case::new([1; D], h, law, integrator, dt)?;
        case.random_box(random, Kinds::Any, most::<D>())?;
        // A step moves kappa times what a cell holds: that much rounds.
        let moved = if explicit { 9.0 } else { 1.0 + case.conductance(kappa) };
        Ok(mass_error::<T, D>(&case, &Medium::Still, random, 3)? / (3.0 * T::MASS * moved))
    }
}

/// Characteristic waves from the finest cells of their range to far beyond it.
pub(in crate::verify) struct Fronts;

impl Check for Fronts {
    const NAME: &'static str = "fronts";
    const EXPECTED: &'static str = "Characteristic between every wall: finite, the mass balances; no new extrema on a line; E' grows by at most 1e-3";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let (h, tau) = (random.decades(-2.0, 2.0), random.decades(-3.0, 3.0));
        let ratio = random.decades(-6.0, 2.0);
        // R_h = h/(c tau).
        let law = Law::from_speed(h / (tau * ratio), tau, 0.0)?;
        let kinds = random.pick([Kinds::Closed, Kinds::Dissipative, Kinds::Any]);
        let mut case = Case::new([1; D], h, law, Integrator::Kdk, 1.0)?;
        case.random_box(random, kinds, most::<D>())?;
        case.mask = None;
        let speed = law.speed().unwrap_or(0.0);
        let moving = random.chance(0.5);
        let mut velocity = SVector::<f64, D>::zeros();
        if moving {
            case.sides = Sides(std::array::from_fn(|_| match random.below(3) {
                0 => Axis::Periodic,
                _ => Axis::Walls([Wall::Open { inflow: random.between(-1.0, 1.0) }; 2]),
            }));
            velocity = SVector::from_fn(|_, _| speed * random.between(-3.0, 3.0));
        }
        let mut front = Front::<T, D>::new(&case.grid, &case.sides, law, velocity)?;
        let layout = *case.grid.layout();
        let mut state = FrontState::<T, D>::new(&case.grid);
        layout.each_cell(layout.cells_region(), |at| state.phi[at.slot()] = T::of(random.between(-1.0, 1.0)));
        let volume = case.grid.cell_volume();
        let dt = front.stable_dt() * random.between(0.1, 3.0);
        let rate: Vec<T> = (0..layout.slots()).map(|_| T::of(random.between(-1.0, 1.0) / dt)).collect();
        let share = if kinds == Kinds::Any { random.pick([0.0, 0.3, 1.0]) } else { 0.0 };
        let energy = |state: &FrontState<T, D>| {
            let flux: f64 = state.flux.iter().map(|q| layout.dot(q, q)).sum();
            0.5 * volume * (layout.dot(&state.phi, &state.phi) + flux / speed / speed)
        };
        let bound = layout.max_abs(&state.phi);
        let (start, mut last, mut growth) = (energy(&state), energy(&state), f64::NEG_INFINITY);
        let (mut expected, mut size) = (state.mass(&case.grid), layout.sum_abs(&state.phi) * volume);
        let (mut passed, mut substeps) = (0.0, 0.0);
        for _ in 0..5 {
            let report = front.step(&mut state, Source::during(&rate, share), dt)?;
            expected += report.emitted - report.outflow;
            passed += report.emitted.abs() + report.outflow.abs();
            size = size.max(layout.sum_abs(&state.phi) * volume);
            substeps += report.substeps as f64;
            let now = energy(&state);
            growth = if now.is_finite() { growth.max((now - last) / start) } else { f64::INFINITY };
            last = now;
        }
        if !layout.max_abs(&state.phi).is_finite() || !state.flux.iter().all(|q| layout.max_abs(q).is_finite()) {
            return Ok(f64::INFINITY);
        }
        // Given fluxes pass through walls in both directions; every sub-step of every axis rounds.
        case.dt = 5.0 * dt;
        let missing = (state.mass(&case.grid) - expected).abs() / (size + passed + case.passing());
        let balance = missing / ((1.0 + substeps * D as f64) * T::MASS);
        if moving || kinds == Kinds::Any {
            return Ok(balance);
        }
        let line = case.grid.cells().into_iter().filter(|&n| n > 1).count() <= 1 && kinds == Kinds::Closed;
        // Waves of a line keep their bounds; phi is their mean.
        let over = if line { (layout.max_abs(&state.phi) / bound - 1.0) / (20.0 * T::EPSILON) } else { 0.0 };
        Ok(balance.max(over).max(growth / 1e-3))
    }
}
