//! Prolongation and backward smoothing in one sweep over b and the coarse solution.
//!
//! t_red = b/d + P e, x_black = (b + Σ w t_red)/d, x_red = (b + Σ w x_black)/d. The inner products use that every face
//! joins a red and a black cell: x·A x = Σ mass x² + Σ w (x_red - x_black)², a sum of squares without cancellation.
//!
//! Passes: 2 + 2^-D. Reads b and coarse x, writes x.

use std::ops::Range;

use cf_grid::Real;

use super::rows::{BLOCK, Sums, half, join, measure, padded, seal, split};
use super::tile::{Ring, aligned, each_slab, slabs, strip};
use super::{Fused, Products, Scratch, around, parity};

/// Half planes of the rings: b black (2), b red (3), t red (3), x black (3).
pub(super) const HALVES: usize = 11;
/// Rows beyond a strip for which t is needed.
const HALO: usize = 2;

impl<T: Real, const D: usize> Fused<T, D> {
    /// Rows of a strip with its surroundings.
    pub(super) fn ascend_rows(&self) -> usize {
        self.ascend_step() + self.halo(2 * HALO)
    }

    fn ascend_step(&self) -> usize {
        strip::<T>(padded(self.fine.cells()[0]), HALVES, HALO).min(self.rows())
    }

    /// x = M b, given the solution `coarse` of the coarse problem, whose rim along x is wrapped if that is periodic.
    /// `sums` has an entry for every plane.
    pub fn ascend<B: Real>(
        &self,
        b: &[B],
        scale: f64,
        coarse: &[T],
        x: &mut [T],
        sums: &mut [Products],
        scratch: &mut [Scratch<T>],
    ) -> Products {
        let planes = self.fine.cells()[D - 1];
        let plane = self.fine.stride(D - 1);
        let parts = slabs(planes, self.fine.count()).min(scratch.len());
        let own = &mut x[plane..(planes + 1) * plane];
        let sums = &mut sums[..planes];
        each_slab(
            0..planes,
            parts,
            plane,
            own,
            sums,
            scratch,
            #[inline(always)]
            |planes, out, sums, scratch| {
                sums.fill(Products::default());
                let mut from = 0;
                while from < self.rows() {
                    let to = (from + self.ascend_step()).min(self.rows());
                    self.ascend_strip(b, scale, coarse, planes.clone(), from..to, out, sums, scratch);
                    from = to;
                }
            },
        );
        sums.iter().fold(Products::default(), |a, b| Products { bx: a.bx + b.bx, xax: a.xax + b.xax, x: a.x + b.x })
    }

    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn ascend_strip<B: Real>(
        &self,
        b: &[B],
        scale: f64,
        coarse: &[T],
        planes: Range<usize>,
        rows: Range<usize>,
        out: &mut [T],
        sums: &mut [Products],
        scratch: &mut Scratch<T>,
    ) {
        let n = self.fine.cells()[0];
        let place = self.place();
        let padded = padded(n);
        let (za, zb) = (planes.start as isize, planes.end as isize);
        let halo = self.halo(1);
        let base = rows.start as isize - 2 * halo as isize;
        let count = rows.len() + 4 * halo;
        let mut rest = aligned(scratch);
        let mut b_black = Ring::cut(&mut rest, 2, count, padded);
        let mut b_red = Ring::cut(&mut rest, 3, count, padded);
        let mut red = Ring::cut(&mut rest, 3, count, padded);
        let mut black = Ring::cut(&mut rest, 3, count, padded);
        let mut parent = Ring::cut(&mut rest, 1, 1, padded);
        let parent = parent.row_mut(0, 0);
        let mut last = Ring::cut(&mut rest, 1, 1, padded);
        let last = last.row_mut(0, 0);
        // Each stage in a loop of its own: the fewer streams at a time, the better are they fetched ahead.
        for v in za - 2..zb + 2 {
            for r in 0..count {
                let (j, s) = (base + r as isize, parity(v, base + r as isize));
                let Some(cell) = place.cell(v, j) else { continue };
                let at = self.fine.slot(cell);
                split(&b[at..at + n], scale, s, b_red.row_mut(v, r), b_black.row_mut(v, r));
            }
            for r in 0..count {
                let (j, s) = (base + r as isize, parity(v, base + r as isize));
                let row = red.row_mut(v, r);
                let Some(cell) = place.cell(v, j) else {
                    row.fill(T::ZERO);
                    continue;
                };
                self.take(cell, [v, j], coarse, parent);
                self.table.row(cell, s).divide_and_prolong(s, b_red.row(v, r), &self.along, parent, row);
                seal(row, half(n, s), self.periodic[0]);
            }
            let v = v - 1;
            if v < za - 1 {
                continue;
            }
            let mut lanes = Sums::default();
            for r in halo..count - halo {
                let (j, q) = (base + r as isize, 1 - parity(v, base + r as isize));
                let row = black.row_mut(v, r);
                let Some(cell) = place.cell(v, j) else {
                    row.fill(T::ZERO);
                    continue;
                };
                let (op, near) = (self.table.row(cell, q), around(&red, v, r));
                if (2 * halo..count - 2 * halo).contains(&r) {
                    op.relax::<{ measure::LONE }>(q, b_black.row(v, r), &near, row, &mut lanes);
                } else {
                    op.relax::<{ measure::NONE }>(q, b_black.row(v, r), &near, row, &mut Sums::default());
                }
                seal(row, half(n, q), self.periodic[0]);
            }
            if (za..zb).contains(&v) {
                sums[(v - za) as usize].add(&lanes);
            }
            let v = v - 1;
            if v < za {
                continue;
            }
            let mut lanes = Sums::default();
            for r in 2 * halo..count - 2 * halo {
                let (j, s) = (base + r as isize, parity(v, base + r as isize));
                let Some(cell) = place.cell(v, j) else { continue };
                let near = around(&black, v, r);
                self.table.row(cell, s).relax::<{ measure::WHOLE }>(s, b_red.row(v, r), &near, last, &mut lanes);
                let at = self.fine.slot(cell) - (planes.start + 1) * self.fine.stride(D - 1);
                let row = &mut out[at..at + n];
                let (even, odd) = if s == 0 { (&*last, near.row) } else { (near.row, &*last) };
                join(even, odd, row);
                if self.periodic[0] {
                    (out[at - 1], out[at + n]) = (out[at + n - 1], out[at]);
                }
            }
            sums[(v - za) as usize].add(&lanes);
        }
    }

    /// The coarse row, padded, that a fine row interpolates along x.
    #[inline(always)]
    fn take(&self, cell: [usize; D], [v, j]: [isize; 2], coarse: &[T], row: &mut [T]) {
        let m = self.coarse.cells();
        let wrapped = |a: usize, i: isize| i.rem_euclid(m[a] as isize) as usize;
        let [(near, w_near), (far, w_far)] = self.across[D - 1].of(v, cell[D - 1]);
        // A weight of zero has no row of its own.
        let far = if w_far == 0.0 { near } else { far };
        let mut from = [0; D];
        let mut start = |plane: isize, row: isize| {
            from[1] = wrapped(1, row);
            from[D - 1] = wrapped(D - 1, plane);
            self.coarse.slot(from) - 1
        };
        if D == 2 {
            combine([(start(near, near), w_near), (start(far, far), w_far)], coarse, &mut row[..m[0] + 2]);
            return;
        }
        let [(own, w_own), (beside, w_beside)] = self.across[1].of(j, cell[1]);
        let beside = if w_beside == 0.0 { own } else { beside };
        let rows = [
            (start(near, own), w_near * w_own),
            (start(near, beside), w_near * w_beside),
            (start(far, own), w_far * w_own),
            (start(far, beside), w_far * w_beside),
        ];
        combine(rows, coarse, &mut row[..m[0] + 2]);
    }
}

/// row = Σ weight · (as many entries of `from` from a start on).
#[inline(always)]
fn combine<T: Real, const K: usize>(sources: [(usize, f64); K], from: &[T], row: &mut [T]) {
    let rows = sources.map(
        #[inline(always)]
        |(start, _)| from[start..start + row.len()].as_chunks::<BLOCK>(),
    );
    let weights = sources.map(
        #[inline(always)]
        |(_, w)| T::of(w),
    );
    let (row, rest) = row.as_chunks_mut::<BLOCK>();
    for (i, row) in row.iter_mut().enumerate() {
        let mut sum = [T::ZERO; BLOCK];
        for s in 0..K {
            let from = &rows[s].0[i];
            for k in 0..BLOCK {
                sum[k] += weights[s] * from[k];
            }
        }
        *row = sum;
    }
    for (i, v) in rest.iter_mut().enumerate() {
        *v = T::ZERO;
        for s in 0..K {
            *v += weights[s] * rows[s].1[i];
        }
    }
}
