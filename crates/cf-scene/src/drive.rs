//! How fast a solved fluid is likely to be before it has moved, for predictions of steps: what is given to it, and what pushes it.
//!
//! A push a moves fluid at rest at a t until it is as fast as free fall over the box along the push, √(2 a L): a force at
//! all of that. Buoyancy pushes what it lifts through fluid that it has to move aside and mixes with, which leaves 0.4 of it.
//! Jets and inflows have 4/3 of their speed at their edges and around what they meet. The steps of a time are the integral of
//! speed/(cfl·h) over it. Both shares are measured on the scenes S1, S2 and 5, at 16 to 64 cells across.

use crate::pace::Leg;
use crate::scene::{Diffusion, Fluid, Grid, Model, Scene};
use crate::spec::{Axes, AxisSides, FlowWall};

/// The speed of a plume or a sinking drop as a share of free fall over the box.
const PLUME: f64 = 0.4;
/// The speed around a jet or in a stream past something, as a share of what is given.
const AROUND: f64 = 4.0 / 3.0;
/// Places at which the speed within a leg is looked at.
const PLACES: u32 = 16;

/// What moves a fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drive {
    /// From the start on \[m/s\].
    given: f64,
    /// The acceleration from rest \[m/s²\].
    push: f64,
    /// The speed at which that ends \[m/s\].
    top: f64,
    /// Steps per second that resolve the edge of what is lifted \[1/s\].
    edge: f64,
    /// What a step may move \[m\].
    reach: f64,
}

impl Drive {
    /// Of a fluid whose steps move it `cfl` cells.
    pub fn of(scene: &Scene, fluid: &Fluid, cfl: f64) -> Drive {
        let grid = &scene.grid;
        let force = loose(fluid, scene);
        let (weak, strong) = (length(&force), lift(scene, fluid));
        let up = fluid.buoyancy.as_ref().map_or_else(|| Axes::splat(0.0, grid.dimension()), |one| one.up.clone());
        let falls = |axis: usize| force[axis] != 0.0 && scene.sides[axis] == AxisSides::Periodic;
        let free =
            if (0..grid.dimension()).any(falls) { f64::INFINITY } else { (2.0 * weak * along(grid, &force)).sqrt() };
        let plume = PLUME * (2.0 * strong * along(grid, &up)).sqrt();
        let stream = fluid.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let blown = fluid.jets.iter().map(|jet| length(&jet.velocity)).chain(inflows(fluid)).fold(0.0, f64::max);
        Drive {
            given: stream.max(AROUND * blown),
            push: weak + strong,
            top: free + plume,
            edge: (strong / grid.spacing).sqrt(),
            reach: cfl * grid.spacing,
        }
    }

    /// The likely speed at a time \[m/s\].
    pub fn speed(&self, time: f64) -> f64 {
        self.given.max((self.push * time).min(self.top))
    }

    /// Steps that a leg is likely to take, none longer than `longest` \[s\].
    pub fn steps(&self, leg: &Leg, longest: f64) -> f64 {
        self.rate(leg.start, leg.end, longest) * (leg.end - leg.start)
    }

    /// Steps per second from one time to another, on average.
    pub fn rate(&self, from: f64, to: f64, longest: f64) -> f64 {
        let place = |i: u32| from + (to - from) * (f64::from(i) + 0.5) / f64::from(PLACES);
        let fewest = self.edge.max(1.0 / longest);
        (0..PLACES).map(|i| (self.speed(place(i)) / self.reach).max(fewest)).sum::<f64>() / f64::from(PLACES)
    }
}

/// The force that no pressure balances \[m/s²\]: one along closed walls or open to somewhere.
fn loose(fluid: &Fluid, scene: &Scene) -> Axes<f64> {
    let open = fluid.walls.iter().flatten().any(|wall| matches!(wall, FlowWall::Open));
    let moves = |axis: usize| open || scene.sides[axis] == AxisSides::Periodic;
    fluid.force.iter().enumerate().map(|(axis, f)| if moves(axis) { *f } else { 0.0 }).collect()
}

fn inflows(fluid: &Fluid) -> impl Iterator<Item = f64> {
    fluid.walls.iter().flatten().filter_map(|wall| match wall {
        FlowWall::Inflow(velocity) => Some(length(velocity)),
        FlowWall::Closed | FlowWall::Open => None,
    })
}

fn length(vector: &Axes<f64>) -> f64 {
    vector.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// The extent of the box along a direction of any length \[m\].
fn along(grid: &Grid, direction: &Axes<f64>) -> f64 {
    let whole = length(direction);
    let part = |(axis, v): (usize, &f64)| if whole > 0.0 { v.abs() / whole * grid.extent[axis] } else { 0.0 };
    direction.iter().enumerate().map(part).sum()
}

/// The acceleration of what differs most from the fluid around it \[m/s²\]: at the start, where it is held, or where it is emitted
/// until its own buoyancy has carried it out of its source.
fn lift(scene: &Scene, fluid: &Fluid) -> f64 {
    let (Some(buoyancy), Model::Diffusion(model)) = (&fluid.buoyancy, &scene.model) else { return 0.0 };
    let strength = buoyancy.strength.abs();
    let reach = strength * differing(model, buoyancy.reference);
    model.sources.iter().fold(reach, |most, source| {
        let Some(rate) = source.rate else { return most };
        let size: f64 = buoyancy.up.iter().enumerate().map(|(a, up)| up.abs() * span(&scene.grid, source, a)).sum();
        // strength·rate·t³/6 = size
        let leaves = (6.0 * size / (strength * rate.abs())).cbrt();
        let acts = source.until.unwrap_or(f64::INFINITY).min(scene.schedule.until) - source.from;
        let time = leaves.min(acts);
        if time > 0.0 { most.max(strength * rate.abs() * time) } else { most }
    })
}

/// The largest |phi − reference| that is known before the run \[P\].
pub(crate) fn differing(model: &Diffusion, reference: f64) -> f64 {
    let held = model.sources.iter().filter_map(|source| source.value);
    let values = model.initial.iter().map(|deposit| deposit.value).chain(held);
    values.map(|value| (value - reference).abs()).fold(0.0, f64::max)
}

/// How much of the box a source takes along an axis \[m\].
fn span(grid: &Grid, source: &crate::spec::SourceSpec, axis: usize) -> f64 {
    let (low, high) = source.shape.bounds(axis);
    let start = grid.origin[axis];
    (high.min(start + grid.extent[axis]) - low.max(start)).max(grid.spacing)
}
