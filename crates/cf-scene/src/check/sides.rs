//! `sides`: walls for the axes that exist, that suit the law and let the medium pass.

use super::Checker;
use crate::error::Detail;
use crate::scene::{Grid, Model};
use crate::spec::{Axes, AxisSides, Flow, Medium, SidesSpec, Wall};

const NAMES: [&str; 3] = ["x", "y", "z"];

/// One entry per axis.
pub(super) fn sides(check: &mut Checker<'_>, spec: &SidesSpec, grid: &Grid, model: &Model) -> Axes<AxisSides> {
    let written = [Some(&spec.x), spec.y.as_ref(), spec.z.as_ref()];
    let dimension = grid.dimension();
    for (name, axis) in NAMES.iter().zip(&written).skip(dimension) {
        check.require(axis.is_none(), &format!("sides.{name}"), || {
            Detail::new(format!("the grid has {dimension} axes, so there is no side along {name}"))
                .advice(format!("remove `{name}` or give grid.cells {} numbers", dimension + 1))
        });
    }
    let sides: Axes<AxisSides> =
        written.into_iter().take(dimension).map(|axis| axis.cloned().unwrap_or_default()).collect();
    for (axis, ends) in sides.iter().enumerate() {
        match ends {
            AxisSides::Periodic => periodic(check, axis, model),
            AxisSides::Walls { low, high } => {
                wall(check, axis, "low", low, model);
                wall(check, axis, "high", high, model);
            }
        }
    }
    sides
}

fn periodic(check: &mut Checker<'_>, axis: usize, model: &Model) {
    let rotates =
        matches!(model, Model::Diffusion(model) if matches!(model.medium, Medium::Analytic(Flow::Rotation { .. })));
    check.require(!(rotates && axis < 2), &format!("sides.{}", NAMES[axis]), || {
        Detail::new("a rotating medium does not repeat from box to box").expected("walls that let it pass: `Open`")
    });
}

fn wall(check: &mut Checker<'_>, axis: usize, end: &str, wall: &Wall, model: &Model) {
    let path = format!("sides.{}.{end}", NAMES[axis]);
    let Model::Diffusion(model) = model else {
        check.fail(&path, Detail::new("a SingleField pulse has no walls").expected("sides: (x: Periodic)"));
        return;
    };
    if let Wall::Absorbing { speed, .. } = wall {
        match speed {
            Some(speed) => check.positive(&format!("{path}.speed"), *speed),
            None => check.require(model.law.speed().is_some_and(|c| c > 0.0), &path, || {
                Detail::new("a law without waves (tau: 0, fourier: 1 or k: 0) has no speed to absorb")
                    .expected("Absorbing(speed: …)")
            }),
        };
    }
    let blocks = matches!(wall, Wall::Closed | Wall::Flux(_));
    check.require(!(blocks && passes(&model.medium, axis)), &path, || {
        let name = if matches!(wall, Wall::Closed) { "Closed" } else { "Flux" };
        Detail::new(format!("the medium moves through this wall, which is {name}"))
            .expected("`Open`, `Absorbing`, `Value(…)`, or a Periodic axis")
    });
}

/// Refuses what single precision cannot hold.
pub(super) fn fits_f32(check: &mut Checker<'_>, sides: &Axes<AxisSides>) {
    for (name, axis) in NAMES.iter().zip(sides.iter()) {
        let AxisSides::Walls { low, high } = axis else { continue };
        for (end, wall) in [("low", low), ("high", high)] {
            let value = match *wall {
                Wall::Closed => continue,
                Wall::Flux(value) | Wall::Value(value) => value,
                Wall::Absorbing { far, .. } => far,
                Wall::Open { inflow } => inflow,
            };
            check.fits_f32(&format!("sides.{name}.{end}"), value);
        }
    }
}

/// Whether a prescribed medium passes through the walls of an axis.
fn passes(medium: &Medium, axis: usize) -> bool {
    match medium {
        // What a solved fluid passes is checked with its own walls.
        Medium::Still | Medium::Analytic(Flow::Deformation { .. }) | Medium::Solved { .. } => false,
        Medium::Uniform(velocity) => velocity.get(axis).is_some_and(|component| *component != 0.0),
        Medium::Analytic(Flow::Rotation { rate, .. }) => axis < 2 && *rate != 0.0,
    }
}
