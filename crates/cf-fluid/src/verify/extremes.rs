//! Random cases at the edges of what a flow can be asked for.

use std::array::from_fn;

use cf_diffusion::verify::{Check, Corner, Edge, Measured, Precise, Random};
use cf_diffusion::{Diffusion, Law, Settings, State};
use cf_grid::{Grid, Mask, Sides, Wall};

use super::{random_faces, random_mask, random_sides};
use crate::coupled::Coupled;
use crate::emit::{Emission, Emitter, Jet};
use crate::flow::Flow;
use crate::fluid::Fluid;
use crate::settings::{FlowReport, FlowSettings, Scheme};
use crate::shape::Shape;
use crate::wall::FlowWall;

/// Steps of any length.
struct Courant;
/// Energy in closed and periodic boxes.
struct Energy;
/// Solid cells at random, and fluid that they enclose.
struct Solids;
/// Emitters that blow against each other.
struct Jets;
/// The mass that a flow with a remaining divergence carries.
struct Carried;

const EDGES: [Edge; 5] =
    [Edge::of::<Courant>(), Edge::of::<Energy>(), Edge::of::<Solids>(), Edge::of::<Jets>(), Edge::of::<Carried>()];

/// Runs `count` cases in all, the same for the same `seed`.
pub fn extremes(count: usize, seed: u64) -> Vec<Corner> {
    Edge::run_all(&EDGES, count, seed)
}

/// The names of the corners.
pub fn corner_names() -> Vec<&'static str> {
    Edge::names(&EDGES)
}

/// Runs `count` cases of one corner; `None` if there is no corner of that name.
pub fn corner(name: &str, count: usize, seed: u64) -> Option<Corner> {
    Edge::run_one(&EDGES, name, count, seed)
}

/// Runs one case of a corner again; `None` if there is no corner of that name.
pub fn repeat(name: &str, seed: u64) -> Option<Measured> {
    Edge::repeat(&EDGES, name, seed)
}

fn random_grid<const D: usize>(random: &mut Random) -> Measured<Grid<D>> {
    let most = if D == 2 { 18 } else { 9 };
    let cells = from_fn(|_| if random.chance(0.1) { 1 } else { 1 + random.below(most) });
    Ok(Grid::new(cells, random.decades(-3.0, 3.0))?)
}

fn semi_lagrangian(random: &mut Random) -> Scheme {
    random.pick([Scheme::Auto, Scheme::Cnp, Scheme::ReflectionExtrapolated, Scheme::Draft])
}

fn tolerance(random: &mut Random) -> f64 {
    random.pick([1e-1, 1e-2, 1e-4])
}

/// What remains of the divergence, in units of eta_div; rounding excuses it.
fn remaining(report: &FlowReport, eta_div: f64) -> f64 {
    if report.at_floor { 0.0 } else { report.divergence / eta_div }
}

/// Infinite if the velocity is not finite.
fn finite<T: Precise, const D: usize>(fluid: &Fluid<T, D>) -> f64 {
    if fluid.max_speed().is_finite() { 0.0 } else { f64::INFINITY }
}

impl Check for Courant {
    const NAME: &'static str = "courant";
    const EXPECTED: &'static str = "CFL_u of 0 to 1e3, one-cell boxes, any walls: finite, max|div u| dt <= eta_div";

    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let (grid, speed) = (random_grid::<D>(random)?, random.decades(-4.0, 4.0));
        let (sides, mask) = (random_sides(speed, false, random), random_mask(grid.layout(), random));
        let settings =
            FlowSettings { scheme: semi_lagrangian(random), eta_div: tolerance(random), ..Default::default() };
        let mut fluid = Fluid::<T, D>::new(&grid, &sides, mask.as_ref(), settings)?;
        fluid.set_velocity(&random_faces(grid.layout(), speed, random))?;
        let mut worst = 0f64;
        for _ in 0..4 {
            let cfl = random.decades(-6.0, 3.0);
            let dt = if random.chance(0.1) { 0.0 } else { fluid.dt_for(cfl).min(cfl * grid.h() / speed) };
            let report = fluid.step(dt)?;
            worst = worst.max(remaining(&report, settings.eta_div)).max(finite(&fluid));
        }
        Ok(worst)
    }
}

impl Check for Energy {
    const NAME: &'static str = "energy";
    const EXPECTED: &'static str = "noise in closed and periodic boxes, 6 steps: kinetic energy grows by less than 10 % at CFL_u up \
        to 5, and is less than three times as large at CFL_u up to 100";

    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let (grid, speed) = (random_grid::<D>(random)?, random.decades(-3.0, 3.0));
        let (sides, mask) = (random_sides(speed, true, random), random_mask(grid.layout(), random));
        let settings = FlowSettings { scheme: semi_lagrangian(random), ..FlowSettings::default() };
        let mut fluid = Fluid::<T, D>::new(&grid, &sides, mask.as_ref(), settings)?;
        fluid.set_velocity(&random_faces(grid.layout(), speed, random))?;
        let start = fluid.kinetic_energy();
        let dt = random.decades(-2.0, 2.0) * grid.h() / speed;
        let mut growth = 0f64;
        for _ in 0..6 {
            fluid.step(dt)?;
            growth = growth.max((fluid.kinetic_energy() - start) / start.max(f64::MIN_POSITIVE)).max(finite(&fluid));
        }
        // No grid resolves noise, and cubic values are not clamped: where neighbours come from far apart, they may add up. Smooth
        // flows keep to 1e-3 a turnover (`flows`).
        Ok(growth / if dt * speed <= 5.0 * grid.h() { 0.1 } else { 2.0 })
    }
}

impl Check for Solids {
    const NAME: &'static str = "solids";
    const EXPECTED: &'static str = "random solids, pockets, inflow that cannot leave: exact no-penetration, finite";

    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let grid = random_grid::<D>(random)?;
        let layout = grid.layout();
        let share = random.pick([0.02, 0.2, 0.5, 0.9]);
        let mut solid = vec![false; layout.slots()];
        layout.each_cell(layout.cells_region(), |at| solid[at.slot()] = random.chance(share));
        let mask = Mask::new(layout, |cell| !solid[layout.slot(cell)]);
        let sides = random_sides(1.0, false, random);
        let settings =
            FlowSettings { scheme: semi_lagrangian(random), eta_div: tolerance(random), ..Default::default() };
        let mut fluid = Fluid::<T, D>::new(&grid, &sides, Some(&mask), settings)?;
        fluid.set_velocity(&random_faces(layout, 1.0, random))?;
        let mut worst = 0f64;
        for _ in 0..3 {
            let report = fluid.step(random.decades(-2.0, 0.5) * grid.h())?;
            worst = worst.max(remaining(&report, settings.eta_div)).max(finite(&fluid));
        }
        for a in 0..D {
            layout.each_cell(layout.cells_region(), |at| {
                let between = at.cell[a] > 0 && (solid[at.slot()] || solid[at.low(a)]);
                if between && fluid.velocity().axis(a)[at.slot()] != T::ZERO {
                    worst = f64::INFINITY;
                }
            });
        }
        Ok(worst)
    }
}

/// A box of a few cells somewhere.
fn random_box<const D: usize>(grid: &Grid<D>, random: &mut Random) -> Shape<D> {
    let (origin, extent) = (grid.origin(), grid.extent());
    let low: [f64; D] = from_fn(|a| origin[a] + random.between(-0.1, 0.9) * extent[a]);
    let high = from_fn(|a| low[a] + random.between(0.0, 0.5) * extent[a]);
    Shape::Box { low, high }
}

impl Check for Jets {
    const NAME: &'static str = "jets";
    const EXPECTED: &'static str = "emitters across each other and walls, with and without exits: finite, |u| bounded";

    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let (grid, speed) = (random_grid::<D>(random)?, random.decades(-2.0, 2.0));
        let (sides, mask) = (random_sides(speed, false, random), random_mask(grid.layout(), random));
        let settings =
            FlowSettings { scheme: semi_lagrangian(random), eta_div: tolerance(random), ..Default::default() };
        let emitters: Vec<Emitter<D>> = (0..1 + random.below(3))
            .map(|_| {
                let u = from_fn(|_| random.between(-speed, speed));
                let jet = if random.chance(0.5) { Jet::Hold(u) } else { Jet::Set(u) };
                Emitter::new(random_box(&grid, random), Some(jet), None)
            })
            .collect();
        let mut fluid = Fluid::<T, D>::new(&grid, &sides, mask.as_ref(), settings)?.with_emitters(&emitters)?;
        let dt = random.decades(-1.0, 1.0) * grid.h() / speed;
        let mut worst = 0f64;
        for _ in 0..6 {
            let report = fluid.step(dt)?;
            worst = worst.max(remaining(&report, settings.eta_div)).max(finite(&fluid));
        }
        // What enters through many faces may leave through one.
        let faces: usize = grid.cells().iter().sum::<usize>().pow(D as u32 - 1);
        Ok(worst.max(fluid.max_speed() / (10.0 * speed * faces as f64)))
    }
}

impl Check for Carried {
    const NAME: &'static str = "carried";
    const EXPECTED: &'static str = "any eta_div in closed boxes: total phi constant to 1e-12 (f64), 1e-6 (f32)";

    fn run<T: Precise, const D: usize>(random: &mut Random) -> Measured {
        let (grid, speed) = (random_grid::<D>(random)?, random.decades(-2.0, 2.0));
        let layout = grid.layout();
        let mask = random_mask(layout, random);
        let settings =
            FlowSettings { scheme: semi_lagrangian(random), eta_div: random.decades(-4.0, 0.0), ..Default::default() };
        let mut fluid = Fluid::<T, D>::new(&grid, &Sides::all(FlowWall::Closed), mask.as_ref(), settings)?;
        fluid.set_velocity(&random_faces(layout, speed, random))?;
        let dt = random.between(0.05, 0.9) * grid.h() / fluid.max_speed().max(1e-3 * speed);
        // kappa up to 100, beyond which rounding grows with it.
        let law =
            Law::new(random.decades(-3.0, 2.0) * grid.h() * grid.h() / dt, random.pick([0.0, 1.0, 10.0]) * dt, 0.0)?;
        let mut state = State::<T, D>::new(&grid, &law);
        layout.each_cell(layout.cells_region(), |at| state.phi[at.slot()] = T::of(random.unit()));
        let diffusion = Diffusion::new(&grid, &Sides::all(Wall::CLOSED), mask.clone(), law, Settings::default())?;
        let puff = Emitter::new(random_box(&grid, random), None, Some(Emission::Rate(random.unit() / dt)));
        let mut coupled = Coupled::new(Flow::Solved(Box::new(fluid)), diffusion, &[puff])?;
        let (mut expected, volume) = (state.mass(&grid), grid.cell_volume());
        for _ in 0..4 {
            expected += coupled.step(&mut state, dt)?.scalar.emitted;
        }
        let size = layout.sum_abs(&state.phi) * volume;
        Ok((state.mass(&grid) - expected).abs() / size / (4.0 * T::MASS))
    }
}
