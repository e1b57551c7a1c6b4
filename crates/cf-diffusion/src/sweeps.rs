//! Whole-field sweeps of the steps: the flux from a gradient, the divergence of a flux. Both read the rims that
//! [`Walls`] fills; wall faces with a value are finished by the caller.

use cf_grid::{FaceField, Real};

use crate::walls::Walls;

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
    layout.par_runs(layout.cells_region(), q.axes_mut(), |run, rows: [&mut [T]; D]| {
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
                        *q = keep * *q - gain * (open * (c - l));
                    }
                }
            }
        }
    });
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
