//! Whole-field sweeps of the steps: the flux from a gradient, the divergence of a flux. Both read the rims that
//! [`Walls`] fills; wall faces with a value are finished by the caller.

use cf_grid::{FaceField, Real};

use crate::walls::{Parts, Walls};

/// q <- keep q - gain (x_c - x_low) on the low face of every cell, `gain` in units of q per x. Passes: 2 D + 1.
pub(crate) fn update_flux<T: Real, const D: usize>(
    walls: &Walls<T, D>,
    q: &mut FaceField<T, D>,
    x: &[T],
    keep: f64,
    gain: f64,
) {
    let layout = walls.layout;
    let (keep, gain) = (T::of(keep), T::of(gain));
    layout.par_runs(
        layout.cells_region(),
        q.axes_mut(),
        #[inline(always)]
        |run, rows: [&mut [T]; D]| {
            let c = run.row(x);
            for (a, row) in rows.into_iter().enumerate() {
                let low = run.low(a, x);
                match &walls.open {
                    None => {
                        for ((q, &c), &l) in row.iter_mut().zip(c).zip(low) {
                            *q = keep * *q - gain * (c - l);
                        }
                    }
                    Some(open) => {
                        for (((q, &c), &l), &open) in row.iter_mut().zip(c).zip(low).zip(run.row(open.axis(a))) {
                            // Chosen, not multiplied: what a solid cell holds is nobody's business.
                            let step = if open > T::ZERO { c - l } else { T::ZERO };
                            *q = keep * *q - gain * step;
                        }
                    }
                }
            }
        },
    );
}

/// Sum over the axes of q_high - q_low for a row.
#[inline(always)]
pub(crate) fn net_outflow<T: Real, const D: usize>(run: &cf_grid::Run<'_, D>, q: [&[T]; D], out: &mut [T]) {
    for a in 0..D {
        let (low, high) = (run.row(q[a]), run.high(a, q[a]));
        if a == 0 {
            for ((o, &l), &h) in out.iter_mut().zip(low).zip(high) {
                *o = h - l;
            }
        } else {
            for ((o, &l), &h) in out.iter_mut().zip(low).zip(high) {
                *o += h - l;
            }
        }
    }
}

/// Sum over the faces of (x_n - x_c) for a row, open faces only.
#[inline(always)]
pub(crate) fn spread<T: Real, const D: usize>(walls: &Walls<T, D>, run: &cf_grid::Run<'_, D>, x: &[T], out: &mut [T]) {
    let c = run.row(x);
    for a in 0..D {
        let (low, high) = (run.low(a, x), run.high(a, x));
        let first = a == 0;
        match &walls.open {
            None => {
                for (((o, &c), &l), &h) in out.iter_mut().zip(c).zip(low).zip(high) {
                    let s = (l - c) + (h - c);
                    *o = if first { s } else { *o + s };
                }
            }
            Some(open) => {
                let (wl, wh) = (run.row(open.axis(a)), run.high(a, open.axis(a)));
                for (i, o) in out.iter_mut().enumerate() {
                    let s = wl[i] * (low[i] - c[i]) + wh[i] * (high[i] - c[i]);
                    *o = if first { s } else { *o + s };
                }
            }
        }
    }
}

/// Σ of a value over the cells of each part.
pub(crate) fn part_sums<T: Real, const D: usize>(
    walls: &Walls<T, D>,
    parts: &Parts,
    value: impl Fn(usize) -> f64 + Sync,
) -> Vec<f64> {
    let layout = walls.layout;
    let Some(components) = &parts.components else {
        return vec![layout.par_runs(layout.cells_region(), (), |run, ()| {
            (run.slot()..run.slot() + run.len()).map(&value).sum::<f64>()
        })];
    };
    let mut sums = vec![0.0; components.cells.len()];
    layout.each_cell(layout.cells_region(), |at| {
        if let Some(part) = components.label[at.slot()].checked_sub(1) {
            sums[part as usize] += value(at.slot());
        }
    });
    sums
}

/// Shifts each part by a constant to its total, a sum of deviations from `far`; parts held by a wall stay. What a cell
/// rounds off its neighbour in the row gets, so that sums are exact to a rounding per row, not per cell.
pub(crate) fn restore<T: Real, const D: usize>(
    walls: &Walls<T, D>,
    parts: &Parts,
    phi: &mut [T],
    far: f64,
    totals: &[f64],
) {
    let layout = walls.layout;
    let found = part_sums(walls, parts, |slot| phi[slot].f64() - far);
    let missing = |i: usize| if parts.held[i] { 0.0 } else { (totals[i] - found[i]) / parts.cells(i, &layout) };
    let shift: Vec<f64> = (0..totals.len()).map(missing).collect();
    if shift.iter().all(|&s| s == 0.0) {
        return;
    }
    let moved = |v: &mut T, by: f64| {
        let old = v.f64();
        *v = T::of(old + by);
        by - (v.f64() - old)
    };
    layout.par_runs(layout.cells_region(), phi, |run, row: &mut [T]| match &parts.components {
        None => {
            row.iter_mut().fold(0.0, |left, v| moved(v, shift[0] + left));
        }
        Some(components) => {
            let (mut left, mut part) = (0.0, 0);
            for (v, &label) in row.iter_mut().zip(run.row(&components.label)) {
                if label == 0 || parts.held[label as usize - 1] {
                    continue;
                }
                if label != part {
                    (left, part) = (0.0, label);
                }
                left = moved(v, shift[label as usize - 1] + left);
            }
        }
    });
}
