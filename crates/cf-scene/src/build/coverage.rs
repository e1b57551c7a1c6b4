//! Shapes on cells: the share of a cell that a shape covers, so that sums do not depend on where the grid lies.

use crate::spec::Shape;
use cf_grid::{Grid, Real, Region};
use std::ops::Range;

/// Shares closer than this to 0 or 1 are rounding.
const ROUNDING: f64 = 1e-9;
/// Points along each axis of a cell on the edge of a ball.
const POINTS: usize = 4;

/// Adds `value` times the shape to every cell it touches.
pub(super) fn deposit<T: Real, const D: usize>(grid: &Grid<D>, shape: &Shape, value: f64, cells: &mut [T]) {
    let region = around(grid, shape);
    grid.layout().par_runs(region, cells, |run, row: &mut [T]| {
        for (at, cell) in run.ats().zip(row) {
            *cell += T::of(value * share(grid, shape, at.cell));
        }
    });
}

/// The same into a stretch of slots, from the slot `first` on.
pub(super) fn deposit_within<T: Real, const D: usize>(
    grid: &Grid<D>,
    shape: &Shape,
    value: f64,
    first: usize,
    cells: &mut [T],
) {
    grid.layout().each_cell(around(grid, shape), |at| {
        if let Some(cell) = at.slot().checked_sub(first).and_then(|i| cells.get_mut(i)) {
            *cell += T::of(value * share(grid, shape, at.cell));
        }
    });
}

/// The planes that shapes may touch, as a stretch of slots; empty where there are none.
pub(super) fn planes<'s, const D: usize>(grid: &Grid<D>, shapes: impl Iterator<Item = &'s Shape>) -> Range<usize> {
    let (last, stride) = (D - 1, grid.layout().stride(D - 1));
    let touched = shapes.map(|shape| around(grid, shape)).filter(|region| region.low[last] < region.high[last]);
    let ends = touched.fold(None, |ends: Option<[usize; 2]>, region| {
        let [low, high] = ends.unwrap_or([usize::MAX, 0]);
        Some([low.min(region.low[last]), high.max(region.high[last])])
    });
    // Behind the plane of the rim.
    ends.map_or(0..0, |[low, high]| (low + 1) * stride..(high + 1) * stride)
}

/// The cells that a shape may touch.
pub(super) fn around<const D: usize>(grid: &Grid<D>, shape: &Shape) -> Region<D> {
    let mut region = grid.layout().cells_region();
    for axis in 0..D {
        let (low, high) = shape.bounds(axis);
        // Beyond its bounds only a Gaussian goes on.
        if !matches!(shape, Shape::Gaussian { .. }) {
            let index = |x: f64| ((x - grid.origin()[axis]) / grid.h()).clamp(-1.0, grid.cells()[axis] as f64 + 1.0);
            region.low[axis] = region.low[axis].max((index(low) - 1.0).max(0.0) as usize);
            region.high[axis] = region.high[axis].min((index(high) + 2.0).max(0.0) as usize);
        }
    }
    region
}

/// The share of a cell inside a shape; the value at its centre for shapes without an edge.
fn share<const D: usize>(grid: &Grid<D>, shape: &Shape, cell: [usize; D]) -> f64 {
    let h = grid.h();
    let centre = grid.centre(cell);
    let corner = |axis: usize| centre[axis] - 0.5 * h;
    match shape {
        Shape::Everywhere => 1.0,
        Shape::Box { .. } | Shape::Below { .. } | Shape::Above { .. } => {
            (0..D).map(|axis| overlap(corner(axis), h, shape.bounds(axis))).product()
        }
        Shape::Ball { center, radius } => {
            let distance = (0..D).map(|a| (centre[a] - center[a]).powi(2)).sum::<f64>().sqrt();
            let reach = 0.5 * h * (D as f64).sqrt();
            if distance >= radius + reach {
                0.0
            } else if distance + reach <= *radius {
                1.0
            } else {
                sampled(h, *radius, |axis| corner(axis) - center[axis], D)
            }
        }
        Shape::Gaussian { .. } | Shape::Cosine { .. } => {
            shape.weight(centre.as_slice(), grid.origin().as_slice(), grid.extent().as_slice())
        }
    }
}

/// The share of low..low + h inside an interval. An interval without length counts as the cell it lies in.
fn overlap(low: f64, h: f64, (from, to): (f64, f64)) -> f64 {
    if from == to {
        return if (low..low + h).contains(&from) { 1.0 } else { 0.0 };
    }
    let share = (to.min(low + h) - from.max(low)) / h;
    match share {
        s if s < ROUNDING => 0.0,
        s if s > 1.0 - ROUNDING => 1.0,
        s => s,
    }
}

/// The share of a cell inside a ball by regularly placed points; `corner` is relative to the centre.
fn sampled(h: f64, radius: f64, corner: impl Fn(usize) -> f64, dimension: usize) -> f64 {
    let count = POINTS.pow(dimension as u32);
    let inside = (0..count).filter(|point| {
        let square: f64 = (0..dimension)
            .map(|axis| {
                let i = point / POINTS.pow(axis as u32) % POINTS;
                (corner(axis) + h * (i as f64 + 0.5) / POINTS as f64).powi(2)
            })
            .sum();
        square <= radius * radius
    });
    inside.count() as f64 / count as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use cf_grid::CellField;

    fn total(n: usize, shape: &Shape) -> f64 {
        let grid = Grid::<2>::new([2 * n, n], 1.0 / n as f64).unwrap();
        let mut field = CellField::<f64>::new(grid.layout());
        deposit(&grid, shape, 3.0, &mut field);
        grid.layout().sum(&field) * grid.cell_volume()
    }

    fn two(x: f64, y: f64) -> crate::spec::Axes<f64> {
        [x, y].into_iter().collect()
    }

    #[test]
    fn a_box_has_its_area_on_every_grid() {
        let shape = Shape::Box { low: two(0.31, 0.27), high: two(1.13, 0.66) };
        for n in [5, 8, 13, 40] {
            assert!((total(n, &shape) - 3.0 * 0.82 * 0.39).abs() < 1e-12, "{n}");
        }
        let below = Shape::Below { axis: crate::spec::Axis::Y, at: 0.123 };
        assert!((total(10, &below) - 3.0 * 2.0 * 0.123).abs() < 1e-12);
        assert!((total(10, &Shape::Everywhere) - 6.0).abs() < 1e-12);
    }

    #[test]
    fn a_ball_and_a_gaussian_have_nearly_theirs() {
        let ball = Shape::Ball { center: two(0.9, 0.5), radius: 0.3 };
        assert!((total(40, &ball) / (3.0 * std::f64::consts::PI * 0.09) - 1.0).abs() < 0.01);
        let gaussian = Shape::Gaussian { center: two(1.0, 0.5), width: 0.05 };
        assert!((total(40, &gaussian) / (3.0 * std::f64::consts::TAU * 0.0025) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn rounding_leaves_no_trace_and_a_flat_box_fills_its_cell() {
        assert_eq!(overlap(0.1 + 0.2, 0.1, (0.0, 0.3)), 0.0);
        assert_eq!(overlap(0.0, 0.1, (0.05, 0.05)), 1.0);
        assert_eq!(overlap(0.1, 0.1, (0.05, 0.05)), 0.0);
    }
}
