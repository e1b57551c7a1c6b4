//! `model.medium: Solved(…)`: what moves the fluid, and walls that let pass for `phi` what they let pass for the fluid.

use super::model::{axes, shape};
use super::{Checker, out_of_range};
use crate::error::{Detail, number};
use crate::scene::{Buoyancy, Fluid, Grid};
use crate::spec::{Axes, AxisSides, BuoyancySpec, FlowEnds, FlowSides, FlowWall, Grip, JetSpec, Medium, Shape, Wall};

const PATH: &str = "model.medium";
const NAMES: [&str; 3] = ["x", "y", "z"];
/// The most jets of a scene.
const MAX_JETS: usize = 1000;

/// Resolves a solved medium; `None` for any other. `sides` are the walls of `phi`.
pub(super) fn fluid(check: &mut Checker<'_>, medium: &Medium, sides: &Axes<AxisSides>, grid: &Grid) -> Option<Fluid> {
    let Medium::Solved { velocity, walls, force, buoyancy, jets } = medium else { return None };
    let dimension = grid.dimension();
    let mut vector = |name: &str, given: &Option<Axes<f64>>| {
        given.iter().for_each(|given| axes(check, &format!("{PATH}.{name}"), given.len(), grid));
        given.clone().unwrap_or_else(|| Axes::splat(0.0, dimension))
    };
    let (velocity, force) = (vector("velocity", velocity), vector("force", force));
    check.require(jets.len() <= MAX_JETS, &format!("{PATH}.jets"), || {
        Detail::new("too many entries").expected(format!("at most {MAX_JETS}")).found(jets.len().to_string())
    });
    for (i, one) in jets.iter().take(MAX_JETS).enumerate() {
        jet(check, &format!("{PATH}.jets[{i}]"), one, grid);
    }
    let buoyancy = buoyancy.as_ref().map(|one| resolve(check, one, grid));
    let walls = resolve_walls(check, walls, sides, grid);
    if check.problems.is_empty() {
        jets.iter().enumerate().for_each(|(i, jet)| inlet(check, i, jet, sides, grid));
    }
    Some(Fluid { velocity, walls, force, buoyancy, jets: jets.clone() })
}

fn jet(check: &mut Checker<'_>, path: &str, jet: &JetSpec, grid: &Grid) {
    if check.require(matches!(jet.shape, Shape::Box { .. } | Shape::Ball { .. }), &format!("{path}.shape"), || {
        Detail::new("a jet of this shape has no faces to hold").expected("`Box` or `Ball`")
    }) {
        shape(check, &format!("{path}.shape"), &jet.shape, grid);
    }
    axes(check, &format!("{path}.velocity"), jet.velocity.len(), grid);
    check.not_negative(&format!("{path}.from"), jet.from);
    let until = jet.until.unwrap_or(f64::INFINITY);
    check.require(until > jet.from, &format!("{path}.until"), || {
        out_of_range(&format!("later than from, which is {}", number(jet.from)), until)
    });
}

fn resolve(check: &mut Checker<'_>, spec: &BuoyancySpec, grid: &Grid) -> Buoyancy {
    let path = format!("{PATH}.buoyancy.up");
    let along_y = || (0..grid.dimension()).map(|axis| if axis == 1 { 1.0 } else { 0.0 }).collect();
    let up = spec.up.clone().unwrap_or_else(along_y);
    axes(check, &path, up.len(), grid);
    let length = up.iter().map(|v| v * v).sum::<f64>().sqrt();
    check.require(length > 0.0 && length.is_finite(), &path, || {
        Detail::new("this points nowhere").expected("a direction, such as (0, 1, 0)").found(up.to_string())
    });
    Buoyancy { strength: spec.strength, reference: spec.reference, up: up.iter().map(|v| v / length).collect() }
}

/// One pair per axis; a periodic axis has closed walls that nothing meets.
fn resolve_walls(
    check: &mut Checker<'_>,
    spec: &FlowSides,
    sides: &Axes<AxisSides>,
    grid: &Grid,
) -> Vec<[FlowWall; 2]> {
    let written = [&spec.x, &spec.y, &spec.z];
    for (name, ends) in NAMES.iter().zip(written).skip(grid.dimension()) {
        check.require(*ends == FlowEnds::default(), &format!("{PATH}.walls.{name}"), || {
            Detail::new(format!("the grid has {} axes, so there is no wall along {name}", grid.dimension()))
        });
    }
    let mut walls = Vec::new();
    for (axis, (ends, phi)) in written.into_iter().zip(sides.iter()).enumerate() {
        let path = format!("{PATH}.walls.{}", NAMES[axis]);
        let AxisSides::Walls { low, high } = phi else {
            check.require(*ends == FlowEnds::default(), &path, || {
                Detail::new("a periodic axis has no walls").advice("remove it, or give sides walls along this axis")
            });
            walls.push([FlowWall::Closed, FlowWall::Closed]);
            continue;
        };
        let mut one = |end: &str, given: &Option<FlowWall>, phi: &Wall| {
            let default = if blocks(phi) { FlowWall::Closed } else { FlowWall::Open };
            let wall = given.clone().unwrap_or(default);
            wall_of(check, &format!("{path}.{end}"), &wall, phi, axis, grid);
            wall
        };
        walls.push([one("low", &ends.low, low), one("high", &ends.high, high)]);
    }
    walls
}

fn wall_of(check: &mut Checker<'_>, path: &str, wall: &FlowWall, phi: &Wall, axis: usize, grid: &Grid) {
    let passes = match wall {
        FlowWall::Closed => false,
        FlowWall::Open => true,
        FlowWall::Inflow(velocity) => {
            axes(check, path, velocity.len(), grid);
            velocity.get(axis).is_some_and(|normal| *normal != 0.0)
        }
    };
    check.require(!(passes && blocks(phi)), path, || refusal("the fluid passes this wall", phi, axis));
}

/// A jet that holds faces of a wall passes through it.
fn inlet(check: &mut Checker<'_>, index: usize, jet: &JetSpec, sides: &Axes<AxisSides>, grid: &Grid) {
    if jet.how != Grip::Hold {
        return;
    }
    for (axis, phi) in sides.iter().enumerate() {
        let AxisSides::Walls { low, high } = phi else { continue };
        let ((from, to), start) = (jet.shape.bounds(axis), grid.origin[axis]);
        for (wall, place) in [(low, start), (high, start + grid.extent[axis])] {
            let through = (from..=to).contains(&place) && jet.velocity[axis] != 0.0;
            check.require(!(through && blocks(wall)), &format!("{PATH}.jets[{index}]"), || {
                refusal("this jet blows through a wall", wall, axis)
            });
        }
    }
}

fn refusal(what: &str, phi: &Wall, axis: usize) -> Detail {
    let (name, kind) = (NAMES[axis], if matches!(phi, Wall::Closed) { "Closed" } else { "Flux" });
    Detail::new(format!("{what} along {name}, which is {kind} to phi"))
        .expected("a wall in `sides` that lets it pass: `Open`, `Absorbing` or `Value(…)`")
}

/// Whether a wall of `phi` lets nothing pass that is carried.
fn blocks(wall: &Wall) -> bool {
    matches!(wall, Wall::Closed | Wall::Flux(_))
}
