//! Forward smoothing of a zero guess, residual and restriction in one sweep over b.
//!
//! x_red = b/d, x_black = (b + Σ w x_red)/d, r_red = Σ w x_black (b = d x_red there), r_black = 0, coarse b = Pᵀ r.
//!
//! Passes: 1 + 2^-D. Reads b, writes coarse b; x and r live in rings that fit the L2 cache.

use std::ops::Range;

use cf_grid::{Real, inlined};

use super::rows::{Sums, half, measure, padded, seal};
use super::tile::{Ring, aligned, each_slab, slabs, strip};
use super::{Fused, Scratch, around, parity};

/// Half planes of the rings: b black (2), x red (3), x black (3).
pub(super) const HALVES: usize = 8;
/// Rows beyond those that give to a strip's coarse rows for which x is needed.
const HALO: usize = 2;

impl<T: Real, const D: usize> Fused<T, D> {
    /// Fine rows of a strip with its surroundings.
    pub(super) fn descend_rows(&self) -> usize {
        let strip = strip::<T>(padded(self.fine.cells()[0]), HALVES, HALO + 1);
        strip.min(self.rows() + 1) + 1 + self.halo(2 * HALO + 1)
    }

    /// coarse = Pᵀ (b - A S b) with the smoother S; `scale` is applied to `b` where its precision is another one.
    pub fn descend<B: Real>(&self, b: &[B], scale: f64, coarse: &mut [T], scratch: &mut [Scratch<T>]) {
        let planes = self.coarse.cells()[D - 1];
        let plane = self.coarse.stride(D - 1);
        let parts = slabs(planes, self.fine.count()).min(scratch.len());
        let mut no_sums = vec![(); planes];
        let own = &mut coarse[plane..(planes + 1) * plane];
        each_slab(
            0..planes,
            parts,
            plane,
            own,
            &mut no_sums,
            scratch,
            #[inline(always)]
            |planes, out, _, scratch| {
                self.descend_slab(b, scale, planes, out, scratch);
            },
        );
    }

    #[inline(always)]
    fn descend_slab<B: Real>(
        &self,
        b: &[B],
        scale: f64,
        planes: Range<usize>,
        out: &mut [T],
        scratch: &mut Scratch<T>,
    ) {
        out.fill(T::ZERO);
        let rows = if D == 3 { self.coarse.cells()[1] } else { 1 };
        let step = strip::<T>(padded(self.fine.cells()[0]), HALVES, HALO + 1).min(self.rows() + 1) / 2;
        let mut from = 0;
        while from < rows {
            let to = (from + step.max(1)).min(rows);
            self.descend_strip(b, scale, planes.clone(), from..to, out, scratch);
            from = to;
        }
    }

    #[inline(always)]
    fn descend_strip<B: Real>(
        &self,
        b: &[B],
        scale: f64,
        planes: Range<usize>,
        rows: Range<usize>,
        out: &mut [T],
        scratch: &mut Scratch<T>,
    ) {
        let (n, m) = (self.fine.cells()[0], self.coarse.cells()[0]);
        let place = self.place();
        let padded = padded(n);
        let (za, zb) = self.across[D - 1].givers(planes.start, planes.end);
        let (ra, rb) = if D == 3 { self.across[1].givers(rows.start, rows.end) } else { (0, 1) };
        let halo = self.halo(1) as isize;
        // The first row that the rings hold.
        let base = ra - 2 * halo;
        let count = (rb + 2 * halo - base) as usize;
        let mut rest = aligned(scratch);
        let mut b_black = Ring::cut(&mut rest, 2, count, padded);
        let mut red = Ring::cut(&mut rest, 3, count, padded);
        let mut black = Ring::cut(&mut rest, 3, count, padded);
        let mut residual = Ring::cut(&mut rest, 1, 1, padded);
        let residual = residual.row_mut(0, 0);
        let mut coarse = Ring::cut(&mut rest, 1, 1, padded);
        let coarse = coarse.row_mut(0, 0);
        let halo = halo as usize;
        // Each stage in a loop of its own: the fewer streams at a time, the better are they fetched ahead.
        for v in za - 2..zb + 2 {
            for r in 0..count {
                let (j, s) = (base + r as isize, parity(v, base + r as isize));
                let row = red.row_mut(v, r);
                let Some(cell) = place.cell(v, j) else {
                    row.fill(T::ZERO);
                    continue;
                };
                let at = self.fine.slot(cell);
                self.table.row(cell, s).split_divided(&b[at..at + n], scale, s, row, b_black.row_mut(v, r));
                seal(row, half(n, s), self.periodic[0]);
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
                let (op, near) = (self.table.row(cell, q), around(&red, v, r));
                op.relax::<{ measure::NONE }>(q, b_black.row(v, r), &near, row, &mut Sums::default());
                seal(row, half(n, q), self.periodic[0]);
            }
            let v = v - 1;
            if v < za {
                continue;
            }
            for j in ra..rb {
                let (r, q) = ((j - base) as usize, parity(v, j));
                let Some(cell) = place.cell(v, j) else { continue };
                self.table.row(cell, q).gather(q, &around(&black, v, r), residual);
                seal(residual, half(n, q), self.periodic[0]);
                self.along.restrict(q, residual, coarse);
                self.give(cell, [v, j], &planes, &rows, &coarse[1..1 + m], out);
            }
        }
    }

    /// Adds a restricted row to those of the coarse rows of the slab and strip that it takes part in.
    #[inline(always)]
    fn give(
        &self,
        cell: [usize; D],
        [v, j]: [isize; 2],
        planes: &Range<usize>,
        rows: &Range<usize>,
        row: &[T],
        out: &mut [T],
    ) {
        let inside = |i: isize, range: &Range<usize>| usize::try_from(i).ok().filter(|i| range.contains(i));
        for (k, wz) in self.across[D - 1].of(v, cell[D - 1]) {
            let Some(k) = inside(k, planes).filter(|_| wz != 0.0) else { continue };
            let start = (k - planes.start) * self.coarse.stride(D - 1) + 1;
            let mut add = inlined(
                #[inline(always)]
                |start: usize, w: f64| {
                    let w = T::of(w);
                    for (out, &v) in out[start..start + row.len()].iter_mut().zip(row) {
                        *out += w * v;
                    }
                },
            );
            if D == 2 {
                add(start, wz);
                continue;
            }
            for (i, wy) in self.across[1].of(j, cell[1]) {
                if let Some(i) = inside(i, rows).filter(|_| wy != 0.0) {
                    add(start + (i + 1) * self.coarse.stride(1), wz * wy);
                }
            }
        }
    }
}
