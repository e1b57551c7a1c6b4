//! Prolongation and backward smoothing in one sweep over b and the coarse solution.
//!
//! t_red = b/d + P e, x_black = (b + Σ w t_red)/d, x_red = (b + Σ w x_black)/d. The inner products use that every face
//! joins a red and a black cell: x·A x = Σ mass x² + Σ w (x_red - x_black)², a sum of squares without cancellation.

use std::ops::Range;

use cf_grid::{Real, row_dot, row_sum};

use super::rows::{half, join, padded, seal, split};
use super::tile::{Ring, each_slab, slabs, strip};
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
        each_slab(0..planes, parts, plane, own, sums, scratch, &|planes, out, sums, scratch| {
            sums.fill(Products::default());
            let mut from = 0;
            while from < self.rows() {
                let to = (from + self.ascend_step()).min(self.rows());
                self.ascend_strip(b, scale, coarse, planes.clone(), from..to, out, sums, scratch);
                from = to;
            }
        });
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
        let mut rest = &mut scratch[..];
        let mut b_black = Ring::cut(&mut rest, 2, count, padded);
        let mut b_red = Ring::cut(&mut rest, 3, count, padded);
        let mut red = Ring::cut(&mut rest, 3, count, padded);
        let mut black = Ring::cut(&mut rest, 3, count, padded);
        let (parent, rest) = rest.split_at_mut(padded);
        let last = &mut rest[..padded];
        for v in za - 2..zb + 2 {
            for r in 0..count {
                let (j, s) = (base + r as isize, parity(v, base + r as isize));
                let row = red.row_mut(v, r);
                let Some(cell) = place.cell(v, j) else {
                    row.fill(T::ZERO);
                    continue;
                };
                let at = self.fine.slot(cell);
                let (r_row, b_row) = (b_red.row_mut(v, r), b_black.row_mut(v, r));
                let (even, odd) = if s == 0 { (&mut *r_row, b_row) } else { (b_row, &mut *r_row) };
                split(&b[at..at + n], scale, even, odd);
                self.table.row(cell).divide(n, s, r_row, row);
                let h = half(n, s);
                self.take(cell, [v, j], coarse, parent);
                self.along.prolong_add(s, h, parent, row);
                seal(row, h, self.periodic[0]);
            }
            let v = v - 1;
            if v < za - 1 {
                continue;
            }
            for r in halo..count - halo {
                let (j, q) = (base + r as isize, 1 - parity(v, base + r as isize));
                let row = black.row_mut(v, r);
                let Some(cell) = place.cell(v, j) else {
                    row.fill(T::ZERO);
                    continue;
                };
                let (op, h) = (self.table.row(cell), half(n, q));
                op.gather::<true>(n, q, b_black.row(v, r), &around(&red, v, r), row);
                seal(row, h, self.periodic[0]);
                if planes.contains(&(v as usize)) && (2 * halo..count - 2 * halo).contains(&r) {
                    let sum = &mut sums[v as usize - planes.start];
                    let x = &row[1..1 + h];
                    sum.bx += row_dot(&b_black.row(v, r)[1..1 + h], x);
                    sum.x += row_sum(x);
                    sum.xax += op.lone_energy(n, q, row);
                }
            }
            let v = v - 1;
            if v < za {
                continue;
            }
            let k = v as usize - planes.start;
            for r in 2 * halo..count - 2 * halo {
                let (j, s) = (base + r as isize, parity(v, base + r as isize));
                let Some(cell) = place.cell(v, j) else { continue };
                let (op, h) = (self.table.row(cell), half(n, s));
                let near = around(&black, v, r);
                op.gather::<true>(n, s, b_red.row(v, r), &near, last);
                let x = &last[1..1 + h];
                let sum = &mut sums[k];
                sum.bx += row_dot(&b_red.row(v, r)[1..1 + h], x);
                sum.x += row_sum(x);
                sum.xax += op.energy(n, s, last, &near);
                let at = self.fine.slot(cell) - (planes.start + 1) * self.fine.stride(D - 1);
                let row = &mut out[at..at + n];
                let (even, odd) = if s == 0 { (&*last, near.row) } else { (near.row, &*last) };
                join(even, odd, row);
                if self.periodic[0] {
                    (out[at - 1], out[at + n]) = (out[at + n - 1], out[at]);
                }
            }
        }
    }

    /// The coarse row, padded, that a fine row interpolates along x.
    #[inline(always)]
    fn take(&self, cell: [usize; D], [v, j]: [isize; 2], coarse: &[T], row: &mut [T]) {
        let m = self.coarse.cells();
        let row = &mut row[..m[0] + 2];
        row.fill(T::ZERO);
        let mut add = |at: usize, w: f64| {
            let w = T::of(w);
            for (row, &v) in row.iter_mut().zip(&coarse[at - 1..at + 1 + m[0]]) {
                *row += w * v;
            }
        };
        let wrapped = |a: usize, i: isize| i.rem_euclid(m[a] as isize) as usize;
        for (k, wz) in self.across[D - 1].of(v, cell[D - 1]) {
            if wz == 0.0 {
                continue;
            }
            let mut from = [0; D];
            from[D - 1] = wrapped(D - 1, k);
            if D == 2 {
                add(self.coarse.slot(from), wz);
                continue;
            }
            for (i, wy) in self.across[1].of(j, cell[1]) {
                if wy != 0.0 {
                    from[1] = wrapped(1, i);
                    add(self.coarse.slot(from), wz * wy);
                }
            }
        }
    }
}
