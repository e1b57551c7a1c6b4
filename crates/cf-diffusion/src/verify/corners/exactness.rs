//! What holds bit for bit: scaling, constants, pockets, refusals.

use cf_grid::{Axis, Grid, Mask, Sides, Wall};

use super::{implicit, require, same, stiff};
use crate::verify::Measured;
use crate::verify::amplification::Precise;
use crate::verify::case::{Case, Kinds};
use crate::verify::extremes::Check;
use crate::verify::random::Random;
use crate::{Diffusion, Integrator, Law, Medium, Settings, Source, State, StepError, kdk_limit};

/// Every stored number of a state times a power of two.
fn scaled<T: Precise, const D: usize>(state: &State<T, D>, phi: f64, flux: f64) -> State<T, D> {
    let mut out = state.clone();
    out.phi.iter_mut().for_each(|x| *x = T::of(x.f64() * phi));
    let fluxes = out.slow_flux.iter_mut().flat_map(|q| q.axes_mut());
    fluxes.for_each(|q| q.iter_mut().for_each(|x| *x = T::of(x.f64() * flux)));
    out
}

/// Any integrator, the explicit one within its limit.
fn any_integrator<const D: usize>(case: &mut Case<D>, random: &mut Random) -> Measured<()> {
    if random.chance(0.3) {
        case.law = Law::cattaneo(case.law.k(), case.law.tau())?;
        case.settings.integrator = Integrator::Kdk;
        case.dt = random.between(0.3, 2.5) * kdk_limit(&case.law, 4.0 * D as f64 / case.grid.h().powi(2));
    }
    Ok(())
}

/// h from 1e-12 to 1e12.
pub(in crate::verify) struct Spacing;

impl Check for Spacing {
    const NAME: &'static str = "h";
    const EXPECTED: &'static str = "h, sqrt k and q times a power of two: the same phi bit for bit";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let kappa = random.decades(-3.0, 6.0);
        let mut case = stiff::<D>(random, Kinds::Any, kappa)?;
        any_integrator(&mut case, random)?;
        let by = (random.below(81) as f64 - 40.0).exp2();
        let mut other = case.clone();
        other.grid = Grid::new(case.grid.cells(), case.grid.h() * by)?;
        other.law = Law::new(case.law.k() * by * by, case.law.tau(), case.law.fourier_share())?;
        other.sides = case.sides.map(|_, _, wall| match wall {
            Wall::Flux(g) => Wall::Flux(g * by),
            Wall::Absorbing { speed, far } => Wall::Absorbing { speed: speed * by, far },
            wall => wall,
        });
        let mut one = case.random_state::<T>(random, 1.0, case.flux_unit());
        let mut two = scaled(&one, 1.0, by);
        case.run(&mut one, 2)?;
        other.run(&mut two, 2)?;
        // Compared at the smaller of the fluxes, where either may have left the range of normal numbers.
        let (one, two) = if by > 1.0 { (one, scaled(&two, 1.0, 1.0 / by)) } else { (scaled(&one, 1.0, by), two) };
        require(same(&one, &two, &case), "phi depends on h")
    }
}

/// Amplitudes from 1e-30 to 1e30 in f32.
pub(in crate::verify) struct Amplitude;

impl Check for Amplitude {
    const NAME: &'static str = "amplitude";
    const EXPECTED: &'static str = "linear under powers of two bit for bit; zero stays zero";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let kappa = random.decades(-3.0, 6.0);
        let mut case = stiff::<D>(random, Kinds::Any, kappa)?;
        any_integrator(&mut case, random)?;
        let by = if random.chance(0.1) { 0.0 } else { (random.below(131) as f64 - 60.0).exp2() };
        let mut other = case.clone();
        other.sides = case.sides.map(|_, _, wall| match wall {
            Wall::Flux(g) => Wall::Flux(g * by),
            Wall::Absorbing { speed, far } => Wall::Absorbing { speed, far: far * by },
            Wall::Value(v) => Wall::Value(v * by),
            Wall::Open { inflow } => Wall::Open { inflow: inflow * by },
        });
        let mut one = case.random_state::<T>(random, 1.0, case.flux_unit());
        let mut two = scaled(&one, by, by);
        case.run(&mut one, 2)?;
        other.run(&mut two, 2)?;
        if by == 0.0 {
            let most = case.grid.layout().max_abs(&two.phi);
            return require(most == 0.0, "zero did not stay zero");
        }
        // Compared at the smaller of the amplitudes, where either may have left the range of normal numbers.
        let (one, two) = if by > 1.0 { (one, scaled(&two, 1.0 / by, 1.0 / by)) } else { (scaled(&one, by, by), two) };
        require(same(&one, &two, &case), "not linear")
    }
}

/// A large constant under a small signal.
pub(in crate::verify) struct Offset;

impl Check for Offset {
    const NAME: &'static str = "offset";
    const EXPECTED: &'static str =
        "constants stay bit for bit; of 1e6 + signal the signal stays to a few roundings of 1e6";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let kappa = random.decades(-3.0, 8.0);
        let mut case = stiff::<D>(random, Kinds::Closed, kappa)?;
        any_integrator(&mut case, random)?;
        let level = T::of(random.pick([1.0, -1.0]) * random.decades(-3.0, 7.0)).f64();
        if random.chance(0.5) {
            let speed = case.flux_unit();
            case.sides = case.sides.map(|_, _, _| match random.below(4) {
                0 => Wall::CLOSED,
                1 => Wall::Value(level),
                2 => Wall::Open { inflow: 0.0 },
                _ => Wall::Absorbing { speed, far: level },
            });
            let mut state = State::<T, D>::new(&case.grid, &case.law);
            case.set_phi(&mut state, |_| level);
            let start = state.clone();
            case.run(&mut state, 3)?;
            return require(same(&start, &state, &case), "a constant changed");
        }
        let offset = 1e6;
        let mut state = case.random_state::<T>(random, 1.0, 0.0);
        let layout = *case.grid.layout();
        layout.each_cell(layout.cells_region(), |at| state.phi[at.slot()] += T::of(offset));
        // What T stores of it, without the offset, in f64.
        let mut signal = State::<f64, D>::new(&case.grid, &case.law);
        case.set_phi(&mut signal, |cell| state.phi[layout.slot(cell)].f64() - offset);
        case.run(&mut state, 2)?;
        case.run(&mut signal, 2)?;
        let mut off: f64 = 0.0;
        layout.each_cell(layout.cells_region(), |at| {
            off = off.max((state.phi[at.slot()].f64() - offset - signal.phi[at.slot()]).abs());
        });
        Ok(off / (8.0 * T::EPSILON * offset))
    }
}

/// Tiny and odd boxes full of obstacles.
pub(in crate::verify) struct Pockets;

impl Check for Pockets {
    const NAME: &'static str = "pockets";
    const EXPECTED: &'static str = "any box, any obstacles: mass stays in every pocket, solids are untouched";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let kappa = random.decades(-6.0, 12.0);
        let mut case = stiff::<D>(random, Kinds::Closed, kappa)?;
        let cells = std::array::from_fn(|_| random.pick([1, 1, 2, 3, 5, 7, 8]));
        case.grid = Grid::new(cells, case.grid.h())?;
        let layout = *case.grid.layout();
        let solid = random.pick([0.0, 0.3, 0.6, 1.0]);
        let flags: Vec<bool> = (0..layout.slots()).map(|_| !random.chance(solid)).collect();
        let mask = Mask::new(&layout, |cell| flags[layout.slot(cell)]);
        let parts = mask.components(&case.sides);
        case.mask = Some(mask);
        any_integrator(&mut case, random)?;
        let start = case.random_state::<T>(random, 1.0, case.flux_unit());
        let mut state = start.clone();
        case.run(&mut state, 2)?;
        let (mut change, mut size) = (vec![0.0; parts.cells.len()], 0.0);
        let mut untouched = true;
        layout.each_cell(layout.cells_region(), |at| {
            let [old, new] = [&start, &state].map(|s| s.phi[at.slot()].f64());
            size += old.abs().max(new.abs());
            match parts.label[at.slot()] {
                0 => untouched &= old.to_bits() == new.to_bits(),
                part => change[part as usize - 1] += new - old,
            }
        });
        require(untouched, "a solid cell changed")?;
        Ok(change.iter().fold(0.0, |m: f64, c| m.max(c.abs())) / size / T::MASS)
    }
}

/// Numbers that are not usable.
pub(in crate::verify) struct Input;

impl Check for Input {
    const NAME: &'static str = "input";
    const EXPECTED: &'static str = "NaN, infinity and negative numbers are refused by an error that names the culprit";
    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let bad = random.pick([f64::NAN, f64::INFINITY, f64::NEG_INFINITY]);
        let kappa = random.decades(-3.0, 3.0);
        let mut case = stiff::<D>(random, Kinds::Closed, kappa)?;
        case.mask = None;
        case.grid = Grid::new([5; D], case.grid.h())?;
        any_integrator(&mut case, random)?;
        let mut state = case.random_state::<T>(random, 1.0, 0.0);
        let mut rate = state.phi.clone();
        let slot = case.grid.layout().slot(std::array::from_fn(|_| random.below(5)));
        let dt = case.dt;
        let step = |state: &mut State<T, D>, rate: &[T], dt| {
            let mut stepper = Diffusion::new(&case.grid, &case.sides, None, case.law, case.settings)?;
            stepper.step(state, &Medium::Still, Source::steady(rate), dt)
        };
        match random.below(6) {
            0 => require(matches!(step(&mut state, &rate, bad), Err(StepError::TimeStep(_))), "dt"),
            1 => require(matches!(step(&mut state, &rate, -dt), Err(StepError::TimeStep(_))), "negative dt"),
            2 => {
                state.phi[slot] = T::of(bad);
                let found = step(&mut state, &rate, dt);
                require(matches!(found, Err(StepError::NotFinite { cell, .. }) if cell.len() == D), "phi")
            }
            3 => {
                rate[slot] = T::of(bad);
                let found = step(&mut state, &rate, dt);
                require(matches!(found, Err(StepError::NotFinite { cell, .. }) if cell.len() == D), "source")
            }
            4 => {
                let wall = random.pick([
                    Wall::Flux(bad),
                    Wall::Value(bad),
                    Wall::Open { inflow: bad },
                    Wall::Absorbing { speed: bad, far: 0.0 },
                    Wall::Absorbing { speed: -1.0, far: 0.0 },
                    Wall::Absorbing { speed: 1.0, far: bad },
                ]);
                let mut axes = Sides::all(Wall::CLOSED).0;
                axes[random.below(D)] = Axis::Walls([Wall::CLOSED, wall]);
                let found = Diffusion::<T, D>::new(&case.grid, &Sides(axes), None, case.law, case.settings);
                require(matches!(found.err(), Some(StepError::Wall { .. })), "wall")
            }
            _ => {
                let law = Law::new(1.0, random.pick([0.0, 1.0]), 0.5)?;
                let settings = Settings { integrator: Integrator::Kdk, ..Settings::default() };
                let explicit = Diffusion::<T, D>::new(&case.grid, &case.sides, None, law, settings);
                require(matches!(explicit.err(), Some(StepError::NeedsWaves { .. })), "Kdk without waves")?;
                let settings = Settings { tolerance: -bad, integrator: implicit(random), ..settings };
                let tolerance = Diffusion::<T, D>::new(&case.grid, &case.sides, None, law, settings);
                require(matches!(tolerance.err(), Some(StepError::Tolerance(_))), "tolerance")
            }
        }
    }
}
