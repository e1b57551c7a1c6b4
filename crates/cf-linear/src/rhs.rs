//! Right-hand sides: a field, or what forms one row by row, as the solver sees them.

use cf_grid::{Layout, Max, Real, Reduce, Run};

use crate::deflate::Deflation;
use crate::norms::{Norms, norms, residual_norms};

/// A right-hand side b. A slice is one; so is a formula, which then needs no array: a solve reads b three times, at the start
/// and for the true residual at the end.
pub trait RightHandSide<T, const D: usize>: Sync {
    /// b of the cells of `run`, at most [`PIECE`] of them: a slice of its own, or of `buffer`, which is as long and may be
    /// written.
    fn row<'r>(&'r self, run: &Run<'_, D>, buffer: &'r mut [T]) -> &'r [T];

    /// Slots of the field, where it is one.
    fn slots(&self) -> Option<usize> {
        None
    }
}

/// The longest run that a [`RightHandSide`] is asked for.
pub const PIECE: usize = 512;

impl<T: Real, const D: usize> RightHandSide<T, D> for &[T] {
    #[inline(always)]
    fn row<'r>(&'r self, run: &Run<'_, D>, _: &'r mut [T]) -> &'r [T] {
        run.row(self)
    }

    fn slots(&self) -> Option<usize> {
        Some(self.len())
    }
}

/// Calls `f` with pieces of a run and their values.
#[inline(always)]
fn pieces<'l, T: Real, const D: usize>(
    b: &dyn RightHandSide<T, D>,
    run: &Run<'l, D>,
    mut f: impl FnMut(&Run<'l, D>, &[T]),
) {
    let mut buffer = [T::ZERO; PIECE];
    for first in (0..run.len()).step_by(PIECE) {
        let piece = run.part(first, PIECE.min(run.len() - first));
        f(&piece, b.row(&piece, &mut buffer[..piece.len()]));
    }
}

/// A right-hand side as the solver sees it: `unit` times smaller, zero in solid cells, without the constants.
pub(crate) struct Rhs<'a, T, const D: usize> {
    pub b: &'a dyn RightHandSide<T, D>,
    pub fluid: Option<&'a [bool]>,
    /// A power of two, so that scaling is exact.
    pub unit: f64,
    /// Means of the scaled right-hand side, by component.
    pub means: &'a mut [f64],
    /// Sum of b, where it is known and finite.
    sum: Option<f64>,
}

impl<'a, T: Real, const D: usize> Rhs<'a, T, D> {
    /// Chooses the unit; `None` if a value is not finite. `means` is for what is taken out, zeros now.
    pub fn new(
        layout: &Layout<D>,
        b: &'a dyn RightHandSide<T, D>,
        fluid: Option<&'a [bool]>,
        means: &'a mut [f64],
    ) -> Option<Self> {
        let (sum, largest) = match fluid {
            None => {
                let (sum, largest): (f64, Max) = layout.par_runs(
                    layout.cells_region(),
                    (),
                    #[inline(always)]
                    |run, ()| {
                        let mut found = (0.0, Max(0.0));
                        pieces(b, &run, |_, b| {
                            let (_, sum, largest) = residual_norms(b);
                            found = found.merge((sum, largest));
                        });
                        found
                    },
                );
                (Some(sum).filter(|s| s.is_finite()), largest.0)
            }
            Some(fluid) => {
                let largest: Max = layout.par_runs(
                    layout.cells_region(),
                    (),
                    #[inline(always)]
                    |run, ()| {
                        let mut largest = Max(0.0);
                        pieces(b, &run, |piece, b| {
                            let values = b.iter().zip(piece.row(fluid)).filter(|(_, f)| **f);
                            largest = values.fold(largest, |m, (v, _)| m.merge(Max(v.f64().abs())));
                        });
                        largest
                    },
                );
                (None, largest.0)
            }
        };
        largest.is_finite().then(|| Self { b, fluid, unit: unit_of(largest), means, sum })
    }

    /// Writes a row of it; the mean of a whole box is left out, rounded once.
    #[inline(always)]
    pub fn fill(&self, deflation: &Deflation, run: &Run<'_, D>, r: &mut [T]) {
        let inverse = 1.0 / self.unit;
        let whole = if let (Deflation::Whole, [mean]) = (deflation, &*self.means) { *mean } else { 0.0 };
        pieces(
            self.b,
            run,
            #[inline(always)]
            |piece, b| {
                let first = piece.slot() - run.slot();
                for (r, &b) in r[first..].iter_mut().zip(b) {
                    *r = T::of(b.f64() * inverse - whole);
                }
            },
        );
        if let Some(fluid) = self.fluid {
            for (r, &fluid) in r.iter_mut().zip(run.row(fluid)) {
                *r = if fluid { *r } else { T::ZERO };
            }
        }
    }

    /// Writes it to `r`; `self.means` are left out.
    pub fn load(&self, layout: &Layout<D>, deflation: &Deflation, r: &mut [T]) -> Norms {
        let (square, sum, largest): (f64, f64, Max) = layout.par_runs(
            layout.cells_region(),
            &mut *r,
            #[inline(always)]
            |run, r: &mut [T]| {
                self.fill(deflation, &run, r);
                residual_norms(r)
            },
        );
        if let Deflation::Components(_) = deflation {
            deflation.scale_and_shift(layout, r, 1.0, |i| -self.means[i]);
        }
        Norms { two: square.sqrt(), largest: largest.0, sum, solution: 0.0, weighted: None }
    }

    /// Writes it to `r` after taking the means out of it.
    pub fn load_deflated(&mut self, layout: &Layout<D>, deflation: &Deflation, r: &mut [T]) -> Norms {
        match deflation {
            Deflation::None => self.load(layout, deflation, r),
            Deflation::Whole => {
                let inverse = 1.0 / self.unit;
                let sum = self.sum.map_or_else(
                    || {
                        layout.par_runs(
                            layout.cells_region(),
                            (),
                            #[inline(always)]
                            |run, ()| {
                                let mut sum = 0.0;
                                pieces(self.b, &run, |_, b| sum += scaled_sum(b, inverse));
                                sum
                            },
                        )
                    },
                    |sum| sum * inverse,
                );
                self.means[0] = sum / layout.count() as f64;
                let loaded = self.load(layout, deflation, r);
                // Rounding leaves a mean where the constant is far larger than the rest.
                if loaded.sum.abs() <= f64::EPSILON * loaded.largest * layout.count() as f64 {
                    return loaded;
                }
                deflation.project(layout, r, |i, left| self.means[i] += left);
                norms(layout, r)
            }
            Deflation::Components(_) => {
                self.load(layout, deflation, r);
                // Twice: the second mean is what rounding left of the first.
                for _ in 0..2 {
                    deflation.project(layout, r, |i, mean| self.means[i] += mean);
                }
                norms(layout, r)
            }
        }
    }

    /// Largest constant that was taken out.
    pub fn offset(&self) -> f64 {
        self.means.iter().fold(0.0, |m, v| v.abs().max(m))
    }
}

/// Sum of scale · b: b itself may add up to infinity.
fn scaled_sum<T: Real>(b: &[T], scale: f64) -> f64 {
    let mut lanes = [0.0; 8];
    let chunks = b.chunks_exact(8);
    let tail: f64 = chunks.remainder().iter().map(|v| v.f64() * scale).sum();
    for c in chunks {
        for (lane, v) in lanes.iter_mut().zip(c) {
            *lane += v.f64() * scale;
        }
    }
    lanes.iter().sum::<f64>() + tail
}

/// The largest power of two that is at most `largest`, within the range whose inverse is finite.
fn unit_of(largest: f64) -> f64 {
    if largest > 0.0 { 2f64.powi((largest.log2().floor() as i32).clamp(-1022, 1023)) } else { 1.0 }
}
