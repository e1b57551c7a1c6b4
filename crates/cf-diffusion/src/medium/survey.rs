//! How fast a medium is and how fast that changes, in one reading of its velocity.

use cf_grid::{End, Layout, Max, Real, Reduce, Region};

use super::MediumError;

/// Largest speeds and their largest changes across a cell, per axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Survey<const D: usize> {
    /// max |u_a| \[m/s\].
    pub speed: [f64; D],
    /// max |u_a(right face) − u_a(left face)| \[m/s\].
    pub change: [f64; D],
    /// The same velocity everywhere.
    pub uniform: bool,
}

/// max |u| and max |u_R − u_L| along `axis`; NaN or infinite where a value is.
pub(super) fn measure<T: Real, const D: usize>(layout: &Layout<D>, periodic: bool, axis: usize, u: &[T]) -> (f64, f64) {
    let last = layout.cells()[axis] - 1;
    let (speed, change): (Max, Max) = layout.par_runs(layout.cells_region(), (), |run, ()| {
        let row = run.row(u);
        if !periodic {
            measure_row(row, run.high(axis, u))
        } else if axis == 0 {
            measure_row(row, &row[1..]).merge(measure_row(&row[row.len() - 1..], row))
        } else if run.cell[axis] == last {
            measure_row(row, run.wrapped(axis, 1).row(u))
        } else {
            measure_row(row, run.high(axis, u))
        }
    });
    let beyond = if periodic { 0.0 } else { on_wall(layout, axis, End::High, u) };
    (speed.merge(Max(beyond)).0, change.0)
}

/// max |low| and max |high − low| of two rows, in fixed lanes; 0 v turns what is not finite into NaN.
fn measure_row<T: Real>(low: &[T], high: &[T]) -> (Max, Max) {
    const LANES: usize = 8;
    let zero = [T::ZERO; LANES];
    let (mut speed, mut change, mut poison) = (zero, zero, zero);
    let n = low.len().min(high.len());
    let (lows, highs) = (low[..n].chunks_exact(LANES), high[..n].chunks_exact(LANES));
    let rest = lows.remainder().iter().zip(highs.remainder());
    for (l, h) in lows.clone().zip(highs.clone()) {
        for i in 0..LANES {
            speed[i] = l[i].abs().max(speed[i]);
            change[i] = (h[i] - l[i]).abs().max(change[i]);
            poison[i] += l[i] * T::ZERO;
        }
    }
    for (&l, &h) in rest {
        speed[0] = l.abs().max(speed[0]);
        change[0] = (h - l).abs().max(change[0]);
        poison[0] += l * T::ZERO;
    }
    let top = |lanes: [T; LANES]| lanes.iter().fold(0.0, |m: f64, v| m.max(v.f64()));
    let poison: f64 = poison.iter().map(|v| v.f64()).sum();
    (Max(top(speed) + poison), Max(top(change) + poison))
}

/// max |u| on the faces of one wall.
pub(super) fn on_wall<T: Real, const D: usize>(layout: &Layout<D>, axis: usize, end: End, u: &[T]) -> f64 {
    let mut layer = layout.faces_region(axis, false);
    match end {
        End::Low => layer.high[axis] = 1,
        End::High => layer.low[axis] = layer.high[axis] - 1,
    }
    let max: Max =
        layout.par_runs(layer, (), |run, ()| run.row(u).iter().fold(Max(0.0), |m, v| m.merge(Max(v.f64().abs()))));
    max.0
}

/// The first offender in storage order.
#[derive(Default)]
struct First(Option<MediumError>);

impl Reduce for First {
    fn merge(self, next: Self) -> Self {
        First(self.0.or(next.0))
    }
}

/// Names the first face whose velocity is not finite.
pub(super) fn all_finite<T: Real, const D: usize>(
    layout: &Layout<D>,
    region: Region<D>,
    axis: usize,
    u: &[T],
) -> Result<(), MediumError> {
    let first: First = layout.par_runs(region, (), |run, ()| {
        First(run.ats().find(|at| !u[at.slot()].is_finite()).map(|at| {
            let cell = std::array::from_fn(|a| at.cell.get(a).copied().unwrap_or(0));
            MediumError::NotFinite { axis, cell, value: u[at.slot()].f64() }
        }))
    });
    first.0.map_or(Ok(()), Err)
}
