//! Divergence, gradient and sums on the MAC grid: Div = -Gradᵀ, so that the projection is an
//! orthogonal projector.
//!
//! Velocities are in m/s, the potential s in m/s times h: div u = out/h with out = Σ (u_R - u_L), grad s = s - s_low.

use cf_grid::{End, FaceField, Layout, Max, Real, Reduce, Region, Run, Sides, row_dot, vectorised};
use cf_linear::{PIECE, RightHandSide};

use crate::gates::{Gates, wall_faces};

/// Copies the seam of periodic axes into the rim, and the outermost values along walls, so that neighbours of any face
/// can be read without branches. Faces on high walls live in the rim and stay.
pub(crate) fn fill_rims<T: Real, W: Copy, const D: usize>(
    layout: &Layout<D>,
    sides: &Sides<W, D>,
    u: &mut FaceField<T, D>,
) {
    for c in 0..D {
        for a in 0..D {
            if sides.is_periodic(a) {
                layout.wrap_rim(a, u.axis_mut(c));
            } else if a != c {
                layout.mirror_rim(a, u.axis_mut(c));
            }
        }
    }
}

/// The seam of periodic axes alone, which is all that a divergence reads.
pub(crate) fn wrap_seams<T: Real, W: Copy, const D: usize>(
    layout: &Layout<D>,
    sides: &Sides<W, D>,
    u: &mut FaceField<T, D>,
) {
    for a in 0..D {
        if sides.is_periodic(a) {
            layout.wrap_rim(a, u.axis_mut(a));
        }
    }
}

/// Σ (u_R - u_L) of a row into `out`; seams must be wrapped.
#[inline(always)]
fn net<T: Real, const D: usize>(run: &Run<'_, D>, u: &[&[T]; D], out: &mut [T]) {
    for a in 0..D {
        let (low, high) = (run.row(u[a]), run.high(a, u[a]));
        for ((o, &l), &h) in out.iter_mut().zip(low).zip(high) {
            *o = if a == 0 { h - l } else { *o + (h - l) };
        }
    }
}

/// b = -Σ (u_R - u_L) in fluid cells, 0 elsewhere, formed where it is read.
pub(crate) struct NegativeDivergence<'a, T, const D: usize> {
    u: [&'a [T]; D],
    fluid: Option<&'a [bool]>,
}

impl<'a, T: Real, const D: usize> NegativeDivergence<'a, T, D> {
    /// Of `u`, whose seams it wraps.
    pub fn new(layout: &Layout<D>, gates: &Gates<D>, fluid: Option<&'a [bool]>, u: &'a mut FaceField<T, D>) -> Self {
        wrap_seams(layout, gates.sides(), u);
        Self { u: u.axes(), fluid }
    }

    #[inline(always)]
    fn form(&self, run: &Run<'_, D>, b: &mut [T]) {
        net(run, &self.u, b);
        match self.fluid {
            None => b.iter_mut().for_each(|b| *b = -*b),
            Some(fluid) => {
                for (b, &wet) in b.iter_mut().zip(run.row(fluid)) {
                    *b = if wet { -*b } else { T::ZERO };
                }
            }
        }
    }

    /// max|b|; NaN if any velocity is not a number.
    pub fn largest(&self, layout: &Layout<D>) -> f64 {
        let max: Max = layout.par_runs(
            layout.cells_region(),
            (),
            #[inline(always)]
            |run, ()| {
                let mut buffer = [T::ZERO; PIECE];
                let (mut max, mut poison) = (T::ZERO, T::ZERO);
                for first in (0..run.len()).step_by(PIECE) {
                    let piece = run.part(first, PIECE.min(run.len() - first));
                    let b = &mut buffer[..piece.len()];
                    self.form(&piece, b);
                    for &b in b.iter() {
                        max = max.max(b.abs());
                        poison += b * T::ZERO;
                    }
                }
                Max((max + poison).f64())
            },
        );
        max.0
    }
}

impl<T: Real, const D: usize> RightHandSide<T, D> for NegativeDivergence<'_, T, D> {
    fn row<'r>(&'r self, run: &Run<'_, D>, buffer: &'r mut [T]) -> &'r [T] {
        vectorised(
            #[inline(always)]
            || self.form(run, buffer),
        );
        buffer
    }
}

/// u -= grad s on open faces. The rim of `s` must be wrapped along periodic axes; behind an open wall s = 0 on the face.
pub(crate) fn subtract_gradient<T: Real, const D: usize>(
    layout: &Layout<D>,
    gates: &Gates<D>,
    factor: f64,
    s: &[T],
    u: &mut FaceField<T, D>,
) {
    let w = T::of(factor);
    for a in 0..D {
        let mut inner = layout.faces_region(a, gates.sides().is_periodic(a));
        if !gates.sides().is_periodic(a) {
            inner.low[a] += 1;
            inner.high[a] -= 1;
        } else if layout.cells()[a] == 1 {
            continue;
        }
        let open = gates.open(a);
        layout.par_runs(
            inner,
            u.axis_mut(a),
            #[inline(always)]
            |run, u: &mut [T]| {
                let (low, high) = (run.low(a, s), run.row(s));
                match open {
                    None => {
                        for ((u, &l), &h) in u.iter_mut().zip(low).zip(high) {
                            *u -= w * (h - l);
                        }
                    }
                    Some(open) => {
                        for (((u, &l), &h), &open) in u.iter_mut().zip(low).zip(high).zip(run.row(open)) {
                            *u -= if open { w * (h - l) } else { T::ZERO };
                        }
                    }
                }
            },
        );
        for end in End::BOTH {
            let Some(wall) = gates.sides().wall(a, end).filter(|w| w.conductance() > 0.0) else { continue };
            let w = T::of(-end.sign() * wall.conductance() * factor);
            layout.par_runs(wall_faces(layout, a, end), u.axis_mut(a), |run, u: &mut [T]| {
                let inside = if end == End::Low { run.row(s) } else { run.low(a, s) };
                let open = open.map(|open| run.row(open));
                for (i, (u, &s)) in u.iter_mut().zip(inside).enumerate() {
                    *u -= if open.is_none_or(|o| o[i]) { w * s } else { T::ZERO };
                }
            });
        }
    }
}

/// ∫ u²/2 \[m^(D+2)/s²\] with one control volume per face, half of one at walls.
pub fn kinetic_energy<T: Real, W: Copy, const D: usize>(
    grid: &cf_grid::Grid<D>,
    sides: &Sides<W, D>,
    u: &FaceField<T, D>,
) -> f64 {
    let layout = grid.layout();
    let sum: f64 = (0..D)
        .map(|a| {
            let region = layout.faces_region(a, sides.is_periodic(a));
            let square = |region| -> f64 {
                layout.par_runs(region, (), |run, ()| row_dot(run.row(u.axis(a)), run.row(u.axis(a))))
            };
            let walls = End::BOTH.iter().filter(|&&end| sides.wall(a, end).is_some());
            square(region) - 0.5 * walls.map(|&end| square(wall_faces(layout, a, end))).sum::<f64>()
        })
        .sum();
    0.5 * sum * grid.cell_volume()
}

/// Volume that leaves through the walls per second \[m^D/s\].
pub fn net_outflow<T: Real, W: Copy, const D: usize>(
    grid: &cf_grid::Grid<D>,
    sides: &Sides<W, D>,
    u: &FaceField<T, D>,
) -> f64 {
    let layout = grid.layout();
    let sum: f64 = sides
        .walls()
        .map(|(a, end, _)| {
            let flux: f64 = layout
                .par_runs(wall_faces(layout, a, end), (), |run, ()| run.row(u.axis(a)).iter().map(|v| v.f64()).sum());
            end.sign() * flux
        })
        .sum();
    sum * grid.cell_volume() / grid.h()
}

/// max|u_a| over all faces of the box \[m/s\]; NaN if any is not a number.
pub(crate) fn max_speed<T: Real, W: Copy, const D: usize>(
    layout: &Layout<D>,
    sides: &Sides<W, D>,
    u: &FaceField<T, D>,
) -> f64 {
    let axes = (0..D).map(|a| largest(layout, layout.faces_region(a, sides.is_periodic(a)), u.axis(a)));
    axes.fold(Max(0.0), Max::merge).0
}

/// max|u| over a region; NaN if any is not a number.
pub(crate) fn largest<T: Real, const D: usize>(layout: &Layout<D>, region: Region<D>, u: &[T]) -> Max {
    layout.par_runs(
        region,
        (),
        #[inline(always)]
        |run, ()| {
            let (mut max, mut poison) = (T::ZERO, T::ZERO);
            for &u in run.row(u) {
                max = max.max(u.abs());
                poison += u * T::ZERO;
            }
            Max((max + poison).f64())
        },
    )
}
