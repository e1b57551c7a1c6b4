//! `model.obstacles`: something must be left to simulate, and what emits must reach it.

use super::Checker;
use crate::error::Detail;
use crate::scene::{Grid, Model, Scene};
use crate::solid::Solid;
use crate::spec::Shape;

/// Checks what obstacles leave. Visits cells, so the scene must fit into memory.
pub(super) fn fluid(check: &mut Checker<'_>, scene: &Scene) {
    let Model::Diffusion(model) = &scene.model else { return };
    let solid = Solid::of(scene);
    if solid.is_empty() {
        return;
    }
    let anywhere = |_| (f64::NEG_INFINITY, f64::INFINITY);
    let place = if model.obstacles.is_empty() { "model.mask" } else { "model.obstacles" };
    if !check.require(solid.any_fluid(anywhere, |_| true), place, || {
        Detail::new("the obstacles fill every cell: there is nothing left to simulate")
    }) {
        return;
    }
    let initial = model.initial.iter().enumerate().map(|(i, deposit)| (format!("model.initial[{i}]"), &deposit.shape));
    let sources = model.sources.iter().enumerate().map(|(i, source)| (format!("model.sources[{i}]"), &source.shape));
    let jets = model.fluid.iter().flat_map(|fluid| fluid.jets.iter().enumerate());
    let jets = jets.map(|(i, jet)| (format!("model.medium.jets[{i}]"), &jet.shape));
    for (path, shape) in initial.chain(sources).chain(jets) {
        let reaches = solid.any_fluid(|axis| shape.bounds(axis), |centre| touches(shape, centre, &scene.grid));
        check.require(reaches, &format!("{path}.shape"), || {
            Detail::new("every cell of this shape is solid, so it would do nothing")
                .expected("a shape that reaches out of model.obstacles")
        });
    }
}

/// Whether a shape has a share of the cell around a centre; of a Gaussian, its three widths.
fn touches(shape: &Shape, centre: &[f64], grid: &Grid) -> bool {
    let half = 0.5 * grid.spacing * (1.0 - 1e-9);
    if let Shape::Ball { center, radius } = shape {
        let gap = |(x, c): (&f64, &f64)| ((x - c).abs() - half).max(0.0).powi(2);
        return centre.iter().zip(center.iter()).map(gap).sum::<f64>() < radius * radius;
    }
    centre.iter().enumerate().all(|(axis, x)| {
        let (low, high) = shape.bounds(axis);
        low < x + half && high > x - half
    })
}
