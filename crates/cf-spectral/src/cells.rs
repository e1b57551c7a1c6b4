//! Between the padded fields of a state and arrays of cells without a rim, x contiguous.

use cf_grid::{End, FaceField, Grid, Real, Sides, Wall};
use rayon::prelude::*;

/// The cell that a row of x starts with.
fn start_of_row<const D: usize>(cells: [usize; D], row: usize) -> [usize; D] {
    let mut rest = row;
    std::array::from_fn(|a| {
        if a == 0 {
            return 0;
        }
        let i = rest % cells[a];
        rest /= cells[a];
        i
    })
}

/// The place of a cell in an array without a rim.
fn place<const D: usize>(cells: [usize; D], cell: [usize; D]) -> usize {
    (0..D).rev().fold(0, |at, a| at * cells[a] + cell[a])
}

/// phi into `out`.
pub(crate) fn take<T: Real, const D: usize>(grid: &Grid<D>, phi: impl Fn(usize) -> T + Sync, out: &mut [f64]) {
    let (layout, cells) = (grid.layout(), grid.cells());
    out.par_chunks_mut(cells[0]).enumerate().for_each(|(row, out)| {
        let slot = layout.slot(start_of_row(cells, row));
        out.iter_mut().enumerate().for_each(|(i, x)| *x = phi(slot + i).f64());
    });
}

/// `from` into phi, rounded.
pub(crate) fn put<T: Real, const D: usize>(grid: &Grid<D>, from: &[f64], phi: &mut [T]) {
    let (layout, cells) = (grid.layout(), grid.cells());
    layout.par_runs(layout.cells_region(), phi, |run, phi: &mut [T]| {
        let Some(at) = run.ats().next() else { return };
        phi.iter_mut().zip(&from[place(cells, at.cell)..]).for_each(|(p, x)| *p = T::of(*x));
    });
}

/// D = ∇·q_C per cell.
pub(crate) fn divergence<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<Wall, D>,
    q: &FaceField<T, D>,
    out: &mut [f64],
) {
    let (layout, cells) = (grid.layout(), grid.cells());
    let inverse = 1.0 / grid.h();
    out.par_chunks_mut(cells[0]).enumerate().for_each(|(row, out)| {
        let start = start_of_row(cells, row);
        for (i, out) in out.iter_mut().enumerate() {
            let mut cell = start;
            cell[0] = i;
            let here = layout.slot(cell);
            *out = 0.0;
            for (a, q) in q.axes().into_iter().enumerate() {
                let last = cell[a] + 1 == cells[a];
                let high = match sides.is_periodic(a) && last {
                    true => here - (cells[a] - 1) * layout.stride(a),
                    false => here + layout.stride(a),
                };
                *out += inverse * (q[high].f64() - q[here].f64());
            }
        }
    });
}

/// q_C ← `keep` q_C + ∇`potential`, where a wall of value v has the potential `wall(v)`. Closed walls keep their zero.
pub(crate) fn add_gradient<T: Real, const D: usize>(
    grid: &Grid<D>,
    sides: &Sides<Wall, D>,
    keep: f64,
    potential: &[f64],
    wall: impl Fn(f64) -> f64 + Sync,
    q: &mut FaceField<T, D>,
) {
    let (layout, cells) = (grid.layout(), grid.cells());
    let inverse = 1.0 / grid.h();
    for a in 0..D {
        let at_wall = |end| match sides.wall(a, end) {
            Some(Wall::Value(v)) => Some(wall(v)),
            _ => None,
        };
        let walls = End::BOTH.map(at_wall);
        let periodic = sides.is_periodic(a);
        let value = |cell| potential[place(cells, cell)];
        layout.par_runs(layout.faces_region(a, periodic), q.axis_mut(a), |run, q: &mut [T]| {
            for (q, at) in q.iter_mut().zip(run.ats()) {
                let (i, n) = (at.cell[a], cells[a]);
                let beside = |i| {
                    let mut cell = at.cell;
                    cell[a] = i;
                    value(cell)
                };
                let gradient = match i {
                    0 if periodic => beside(0) - beside(n - 1),
                    0 => walls[0].map_or(0.0, |v| 2.0 * (beside(0) - v)),
                    i if i == n => walls[1].map_or(0.0, |v| 2.0 * (v - beside(n - 1))),
                    i => beside(i) - beside(i - 1),
                };
                *q = T::of(keep * q.f64() + inverse * gradient);
            }
        });
    }
}
