//! `grid`: a box that cubes fill exactly.

use super::Checker;
use crate::error::{Detail, number};
use crate::scene::Grid;
use crate::spec::{Axes, ModelSpec, SceneSpec};

/// The most cells along an axis and in all, far beyond what fits into memory and far below overflow.
const MAX_ALONG: usize = 1 << 24;
const MAX_CELLS: usize = 1 << 40;
/// How far the spacings of the axes may differ, relatively.
const SAME: f64 = 1e-9;

/// Checks the box and finds its spacing.
pub(super) fn grid(check: &mut Checker<'_>, spec: &SceneSpec) -> Grid {
    let (cells, extent) = (&spec.grid.cells, &spec.grid.extent);
    let dimension = cells.len();
    fits_the_model(check, &spec.model, dimension);
    let origin = spec.grid.origin.clone().unwrap_or_else(|| Axes::splat(0.0, dimension));
    for (path, length) in [("grid.extent", extent.len()), ("grid.origin", origin.len())] {
        check.require(length == dimension, path, || {
            Detail::new("the number of axes differs from that of grid.cells")
                .expected(format!("{dimension} numbers"))
                .found(length.to_string())
        });
    }
    for (axis, n) in cells.iter().enumerate() {
        check.require((1..=MAX_ALONG).contains(n), &format!("grid.cells[{axis}]"), || {
            Detail::new("out of range").expected(format!("1 to {MAX_ALONG} cells along an axis")).found(n.to_string())
        });
    }
    let total = cells.iter().try_fold(1usize, |product, n| product.checked_mul(*n));
    check.require(total.is_some_and(|total| total <= MAX_CELLS), "grid.cells", || {
        Detail::new("too many cells").expected(format!("at most {MAX_CELLS} in all"))
    });
    for (axis, length) in extent.iter().enumerate() {
        check.positive(&format!("grid.extent[{axis}]"), *length);
    }
    let spacings: Axes<f64> = extent.iter().zip(cells.iter()).map(|(length, n)| length / *n as f64).collect();
    let spacing = spacings.first().copied().unwrap_or(0.0);
    let equal = spacings.iter().all(|other| (other - spacing).abs() <= SAME * spacing);
    if check.problems.is_empty() {
        check.require(equal, "grid.cells", || {
            Detail::new("the cells are not cubes")
                .expected("equal spacings extent/cells")
                .found(spacings.iter().copied().map(number).collect::<Axes<String>>().to_string())
                .advice("change the cells or the extent along one axis")
        });
        check.require(spacing.is_normal(), "grid.extent", || Detail::new("the cells are too small to compute with"));
    }
    Grid { cells: cells.clone(), spacing, origin, extent: extent.clone() }
}

fn fits_the_model(check: &mut Checker<'_>, model: &ModelSpec, dimension: usize) {
    match model {
        ModelSpec::Diffusion { .. } => check.require(dimension >= 2, "grid.cells", || {
            Detail::new("Diffusion has two or three dimensions")
                .expected("(nx, ny) or (nx, ny, nz)")
                .found("one number")
                .advice("for one dimension take a flat grid such as (400, 1)")
        }),
        ModelSpec::SingleField { .. } => check.require(dimension == 1, "grid.cells", || {
            Detail::new("SingleField has one dimension").expected("(nx)").found(format!("{dimension} numbers"))
        }),
    };
}
