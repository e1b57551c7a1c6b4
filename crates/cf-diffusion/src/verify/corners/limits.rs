//! Laws and steps at their ends: tau, dt, F_T, k.

use cf_grid::{Sides, Wall};

use super::{finite, implicit, require, same, share};
use crate::verify::Measured;
use crate::verify::amplification::{Precise, distance, rounded};
use crate::verify::case::{Case, Kinds};
use crate::verify::conservation::{energy_growth, mass_error};
use crate::verify::extremes::Check;
use crate::verify::random::Random;
use crate::{Integrator, Law, Medium};

fn most<const D: usize>() -> usize {
    if D == 2 { 10 } else { 5 }
}

/// tau from 0 to 1e30.
pub(in crate::verify) struct Relaxation;

impl Check for Relaxation {
    const NAME: &'static str = "tau";
    const EXPECTED: &'static str =
        "tau = 0 is F_T = 1 bit for bit; tau = 1e30 changes nothing; between, E' never grows";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let (k, dt) = (random.decades(-3.0, 3.0), random.decades(-6.0, 3.0));
        let integrator = implicit(random);
        match random.below(3) {
            0 => {
                let without = Law::new(k, 0.0, random.unit())?;
                let fourier = Law::new(k, random.decades(-30.0, 30.0), 1.0)?;
                let mut case = Case::new([1; D], 0.1, without, integrator, dt)?;
                case.random_box(random, Kinds::Any, most::<D>())?;
                let start = case.random_state::<T>(random, 1.0, 0.0);
                let (mut one, mut other) = (start.clone(), start);
                case.run(&mut one, 2)?;
                Case { law: fourier, ..case.clone() }.run(&mut other, 2)?;
                require(same(&one, &other, &case), "tau = 0 and F_T = 1 differ")
            }
            1 => {
                // kappa <= k dt²/(tau h²): nothing moves in a human time.
                let law = Law::new(1.0, 1e30, 0.0)?;
                let mut case = Case::new([1; D], 0.1, law, random.pick([integrator, Integrator::Kdk]), dt)?;
                case.random_box(random, Kinds::Closed, most::<D>())?;
                let start = case.random_state::<T>(random, 1.0, 0.0);
                let mut state = start.clone();
                case.run(&mut state, 2)?;
                // The wave has gone c dt of a cell.
                let moved = 8.0 * case.flux_unit() * dt / case.grid.h();
                let reference = rounded::<f64, T, D>(&case, &start);
                Ok(distance(&case, &state, &reference)
                    / case.energy(&start).sqrt().max(1e-300)
                    / (10.0 * T::EPSILON + moved))
            }
            _ => {
                let law = Law::new(k, random.decades(-30.0, 30.0), share(random))?;
                let mut case = Case::new([1; D], 0.1, law, integrator, dt)?;
                case.random_box(random, Kinds::Dissipative, most::<D>())?;
                Ok(energy_growth::<T, D>(&case, random, 4)? / T::ENERGY)
            }
        }
    }
}

/// dt from 0 to 1e15.
pub(in crate::verify) struct Step;

impl Check for Step {
    const NAME: &'static str = "dt";
    const EXPECTED: &'static str =
        "dt = 0 is the identity; a huge step ends at the mean, or at the walls' value; E' never grows";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let law = Law::new(1.0, random.decades(-3.0, 3.0), share(random))?;
        let integrator = implicit(random);
        let mut case = Case::new([1; D], 0.1, law, integrator, random.decades(-15.0, 15.0))?;
        match random.below(4) {
            0 => {
                case.random_box(random, Kinds::Any, most::<D>())?;
                case.dt = 0.0;
                let start = case.random_state::<T>(random, 1.0, 1.0);
                let mut state = start.clone();
                case.run(&mut state, 2)?;
                require(same(&start, &state, &case), "dt = 0 changed something")
            }
            1 => {
                case.random_box(random, Kinds::Closed, most::<D>())?;
                (case.dt, case.mask) = (1e15, None);
                let (level, held) = (T::of(random.between(-1.0, 1.0)).f64(), random.chance(0.5));
                if held {
                    case.sides = Sides::all(Wall::Value(level));
                }
                let mut state = case.random_state::<T>(random, 1.0, case.flux_unit());
                let layout = case.grid.layout();
                let end = if held { level } else { layout.sum(&state.phi) / layout.count() as f64 };
                // Twice: one step of SDIRK2 leaves what R(z) leaves of q, which decays as 1/dt.
                case.run(&mut state, 2)?;
                let mut off: f64 = 0.0;
                layout.each_cell(layout.cells_region(), |at| off = off.max((state.phi[at.slot()].f64() - end).abs()));
                Ok(if finite(&case, &state) { off / (20.0 * T::EPSILON) } else { f64::INFINITY })
            }
            _ => {
                case.random_box(random, Kinds::Dissipative, most::<D>())?;
                Ok(energy_growth::<T, D>(&case, random, 4)? / T::ENERGY)
            }
        }
    }
}

/// F_T at and near 0 and 1.
pub(in crate::verify) struct Share;

impl Check for Share {
    const NAME: &'static str = "F_T";
    const EXPECTED: &'static str = "continuous in F_T; backward Euler at F_T = 1 makes no new extrema";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let (k, tau, dt) = (random.decades(-2.0, 2.0), random.decades(-2.0, 2.0), random.decades(-3.0, 2.0));
        if random.chance(0.5) {
            let law = Law::new(k, tau, 1.0)?;
            let mut case = Case::new([1; D], 0.1, law, Integrator::PaperBe, dt)?;
            case.random_box(random, Kinds::Closed, most::<D>())?;
            let mut state = case.random_state::<T>(random, 1.0, 0.0);
            let layout = case.grid.layout();
            let (low, high) = layout.range(&state.phi);
            case.run(&mut state, 2)?;
            let (least, most) = layout.range(&state.phi);
            let noise = if T::EPSILON < 1e-10 { 1e-12 } else { 1e-5 };
            return Ok((low - least).max(most - high) / noise);
        }
        let edge = random.pick([0.0, 0.5]);
        let mut case = Case::new([1; D], 0.1, Law::new(k, tau, edge)?, implicit(random), dt)?;
        case.random_box(random, Kinds::Dissipative, most::<D>())?;
        let start = case.random_state::<f64>(random, 1.0, case.flux_unit());
        let (mut one, mut other) = (start.clone(), start.clone());
        case.run(&mut one, 2)?;
        Case { law: Law::new(k, tau, edge + 1e-12)?, ..case.clone() }.run(&mut other, 2)?;
        Ok(distance(&case, &one, &other) / case.energy(&start).sqrt().max(1e-300) / 1e-8)
    }
}

/// k = 0 and k up to 1e30.
pub(in crate::verify) struct Diffusivity;

impl Check for Diffusivity {
    const NAME: &'static str = "k";
    const EXPECTED: &'static str = "k = 0 leaves phi alone; up to k = 1e30 the mass stays and E' never grows";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let (tau, dt) = (random.decades(-3.0, 3.0), random.decades(-3.0, 3.0));
        let k = random.decades(-30.0, 30.0);
        let law = Law::new(if random.chance(0.2) { 0.0 } else { k }, tau, share(random))?;
        let mut case = Case::new([1; D], 0.1, law, implicit(random), dt)?;
        match random.below(2) {
            _ if law.k() == 0.0 => {
                case.random_box(random, Kinds::Dissipative, most::<D>())?;
                let start = case.random_state::<T>(random, 1.0, 0.0);
                let mut state = start.clone();
                case.run(&mut state, 2)?;
                require(same(&start, &state, &case), "k = 0 changed phi")
            }
            0 => {
                case.random_box(random, Kinds::Closed, most::<D>())?;
                let steps = 3;
                Ok(mass_error::<T, D>(&case, &Medium::Still, random, steps)? / (steps as f64 * T::MASS))
            }
            _ => {
                case.random_box(random, Kinds::Dissipative, most::<D>())?;
                Ok(energy_growth::<T, D>(&case, random, 4)? / T::ENERGY)
            }
        }
    }
}
