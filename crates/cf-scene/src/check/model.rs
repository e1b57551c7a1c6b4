//! `model`: numbers in range, shapes that hit the domain, a medium of the right dimension.

use super::{Checker, law, mask, out_of_range};
use crate::error::{Detail, number};
use crate::scene::{Diffusion, Grid, Law, Model, Scene, SingleField};
use crate::spec::{Axis, AxisSides, Flow, Medium, ModelSpec, Shape, SourceSpec, Wall};

/// The most deposits, sources or obstacles of a scene.
const MAX_SHAPES: usize = 10_000;

/// Checks the model and resolves its law.
pub(super) fn model(check: &mut Checker<'_>, spec: &ModelSpec, grid: &Grid) -> Model {
    match spec {
        ModelSpec::Diffusion { law, medium, initial, sources, obstacles, mask } => {
            check_medium(check, medium, grid);
            let law = law::law(check, law, medium);
            for (key, count) in [("initial", initial.len()), ("sources", sources.len()), ("obstacles", obstacles.len())]
            {
                check.require(count <= MAX_SHAPES, &format!("model.{key}"), || {
                    Detail::new("too many entries").expected(format!("at most {MAX_SHAPES}")).found(count.to_string())
                });
            }
            for (i, deposit) in initial.iter().take(MAX_SHAPES).enumerate() {
                shape(check, &format!("model.initial[{i}].shape"), &deposit.shape, grid);
            }
            for (i, source) in sources.iter().take(MAX_SHAPES).enumerate() {
                let path = format!("model.sources[{i}]");
                shape(check, &format!("{path}.shape"), &source.shape, grid);
                emission(check, &path, source);
                check.not_negative(&format!("{path}.from"), source.from);
                let until = source.until.unwrap_or(f64::INFINITY);
                check.require(until > source.from, &format!("{path}.until"), || {
                    out_of_range(&format!("later than from, which is {}", number(source.from)), until)
                });
            }
            for (i, obstacle) in obstacles.iter().take(MAX_SHAPES).enumerate() {
                let path = format!("model.obstacles[{i}]");
                let solid = !matches!(obstacle, Shape::Everywhere | Shape::Gaussian { .. } | Shape::Cosine { .. });
                if check.require(solid, &path, || {
                    Detail::new("this shape has no solid inside").expected("`Box`, `Ball`, `Below` or `Above`")
                }) {
                    shape(check, &path, obstacle, grid);
                }
            }
            let folder = check.folder();
            let mask = mask.as_ref().and_then(|spec| mask::mask(check, spec, grid, &folder));
            Model::Diffusion(Diffusion {
                law,
                medium: medium.clone(),
                fluid: None,
                initial: initial.clone(),
                sources: sources.clone(),
                obstacles: obstacles.clone(),
                mask,
            })
        }
        ModelSpec::SingleField { form, k, tau, velocity, pulse } => {
            check.not_negative("model.k", *k);
            check.positive("model.tau", *tau);
            let least = 0.25 * grid.spacing;
            check.require(pulse.width >= least, "model.pulse.width", || {
                out_of_range(&format!("at least a quarter of a cell, {}", number(least)), pulse.width)
            });
            let (low, high) = domain(grid, 0);
            check.require((low..=high).contains(&pulse.center), "model.pulse.center", || {
                out_of_range(&format!("inside the domain, {} to {}", number(low), number(high)), pulse.center)
            });
            let law = Law { k: *k, tau: *tau, fourier: 0.0 };
            Model::SingleField(SingleField { form: *form, law, velocity: *velocity, pulse: *pulse })
        }
    }
}

/// Refuses what single precision cannot hold.
pub(super) fn fits_f32(check: &mut Checker<'_>, model: &Model) {
    let Model::Diffusion(model) = model else { return };
    for (i, deposit) in model.initial.iter().enumerate() {
        check.fits_f32(&format!("model.initial[{i}].value"), deposit.value);
    }
    for (i, source) in model.sources.iter().enumerate() {
        for (key, number) in [("rate", source.rate), ("value", source.value)] {
            if let Some(number) = number {
                check.fits_f32(&format!("model.sources[{i}].{key}"), number);
            }
        }
    }
}

/// Notes a scene in which nothing can happen.
pub(super) fn empty(check: &mut Checker<'_>, scene: &Scene) {
    let Model::Diffusion(model) = &scene.model else { return };
    let wall = |wall: &Wall| match wall {
        Wall::Closed => false,
        Wall::Flux(value) | Wall::Value(value) => *value != 0.0,
        Wall::Absorbing { far, .. } => *far != 0.0,
        Wall::Open { inflow } => *inflow != 0.0,
    };
    let walls = scene.sides.iter().any(|axis| match axis {
        AxisSides::Periodic => false,
        AxisSides::Walls { low, high } => wall(low) || wall(high),
    });
    let starts = model.initial.iter().any(|deposit| deposit.value != 0.0);
    if !(walls || starts || model.sources.iter().any(emits)) {
        check.warn("model", Detail::new("no initial value, source or wall puts anything into the box: phi stays zero"));
    }
}

fn emits(source: &SourceSpec) -> bool {
    source.rate.or(source.value).is_some_and(|number| number != 0.0)
}

/// A source adds or holds.
fn emission(check: &mut Checker<'_>, path: &str, source: &SourceSpec) {
    match (source.rate, source.value) {
        (Some(_), None) => {}
        (None, Some(_)) => {
            let sharp = !matches!(source.shape, Shape::Gaussian { .. } | Shape::Cosine { .. });
            check.require(sharp, &format!("{path}.shape"), || {
                Detail::new("this shape has no inside in which phi could be held")
                    .expected("`Box`, `Ball`, `Below`, `Above` or `Everywhere`")
            });
        }
        (Some(_), Some(_)) => {
            let detail = Detail::new("a source either adds at a rate or holds a value");
            check.fail(&format!("{path}.value"), detail.advice("remove one of the two, or set it to None"));
        }
        (None, None) => {
            let detail = Detail::new("the key `rate` is missing").expected("rate: … [P/s], or value: … [P]");
            check.fail(path, detail);
        }
    }
}

fn check_medium(check: &mut Checker<'_>, medium: &Medium, grid: &Grid) {
    match medium {
        Medium::Still => {}
        Medium::Uniform(velocity) => axes(check, "model.medium", velocity.len(), grid),
        Medium::Analytic(Flow::Rotation { center, .. }) => axes(check, "model.medium", center.len(), grid),
        Medium::Analytic(Flow::Deformation { period }) => {
            check.positive("model.medium", *period);
        }
        // When the walls are known.
        Medium::Solved { .. } => {}
    }
}

pub(super) fn axes(check: &mut Checker<'_>, path: &str, found: usize, grid: &Grid) {
    let dimension = grid.dimension();
    check.require(found == dimension, path, || {
        Detail::new(format!("the grid has {dimension} axes"))
            .expected(format!("{dimension} numbers"))
            .found(found.to_string())
    });
}

fn domain(grid: &Grid, axis: usize) -> (f64, f64) {
    (grid.origin[axis], grid.origin[axis] + grid.extent[axis])
}

pub(super) fn shape(check: &mut Checker<'_>, path: &str, shape: &Shape, grid: &Grid) {
    let before = check.problems.len();
    match shape {
        Shape::Everywhere => {}
        Shape::Box { low, high } => {
            axes(check, &format!("{path}.low"), low.len(), grid);
            axes(check, &format!("{path}.high"), high.len(), grid);
            for (axis, (low, high)) in low.iter().zip(high.iter()).enumerate() {
                check.require(low <= high, &format!("{path}.low[{axis}]"), || {
                    out_of_range(&format!("at most the high corner's {}", number(*high)), *low)
                });
            }
        }
        Shape::Ball { center, radius: size } | Shape::Gaussian { center, width: size } => {
            axes(check, &format!("{path}.center"), center.len(), grid);
            let key = if matches!(shape, Shape::Ball { .. }) { "radius" } else { "width" };
            check.positive(&format!("{path}.{key}"), *size);
        }
        Shape::Below { axis, .. } | Shape::Above { axis, .. } => {
            let exists = axis.index() < grid.dimension();
            check.require(exists, &format!("{path}.axis"), || {
                let legal = if grid.dimension() == 2 { "`X` or `Y`" } else { "an axis of the grid" };
                Detail::new("the grid has no such axis").expected(legal).found(format!("`{}`", axis_name(*axis)))
            });
        }
        Shape::Cosine { modes } => axes(check, &format!("{path}.modes"), modes.len(), grid),
    }
    if let Shape::Gaussian { width, .. } = shape {
        let least = 0.25 * grid.spacing;
        check.require(*width >= least, &format!("{path}.width"), || {
            out_of_range(&format!("at least a quarter of a cell, {}", number(least)), *width)
        });
    }
    if check.problems.len() == before {
        hits_the_domain(check, path, shape, grid);
    }
}

fn axis_name(axis: Axis) -> &'static str {
    ["X", "Y", "Z"][axis.index()]
}

fn hits_the_domain(check: &mut Checker<'_>, path: &str, shape: &Shape, grid: &Grid) {
    for axis in 0..grid.dimension() {
        let ((low, high), (start, end)) = (shape.bounds(axis), domain(grid, axis));
        if !check.require(low <= end && high >= start, path, || {
            let name = ["x", "y", "z"][axis];
            Detail::new("the shape lies wholly outside the domain")
                .expected(format!("{name} somewhere in {} to {}", number(start), number(end)))
                .found(format!("{} to {}", number(low), number(high)))
        }) {
            return;
        }
    }
    let sharp = !matches!(shape, Shape::Everywhere | Shape::Gaussian { .. } | Shape::Cosine { .. });
    check.require(!sharp || holds_a_cell(shape, grid), path, || {
        Detail::new("the shape is so small that it holds no cell centre, so it would do nothing")
            .expected(format!("at least one cell, {} wide", number(grid.spacing)))
            .advice("enlarge the shape or use more cells")
    });
}

/// Whether the centre of the cell nearest to the middle of the shape, the one most likely to be inside, is inside.
fn holds_a_cell(shape: &Shape, grid: &Grid) -> bool {
    let centre: Vec<f64> = (0..grid.dimension())
        .map(|axis| {
            let ((low, high), (start, end)) = (shape.bounds(axis), domain(grid, axis));
            let middle = 0.5 * (low.max(start) + high.min(end));
            let cell = ((middle - start) / grid.spacing).floor().clamp(0.0, (grid.cells[axis] - 1) as f64);
            start + (cell + 0.5) * grid.spacing
        })
        .collect();
    shape.weight(&centre, &grid.origin, &grid.extent) > 0.0
}
