//! Coloured relaxation: rows are changed while their neighbours are read.
//!
//! Within one colour no updated cell is read by another, so any order gives the same bits. Threads get disjoint blocks
//! of planes with a plane between them that is done afterwards, which needs no copies and no `unsafe`.

use crate::simd::{array, inlined, vectorised};
use crate::{Layout, Reduce, Region, Run, join};

/// Rows around the row being changed, each as long as a padded row (`cells[0] + 2`): the rim cells are at its ends.
#[derive(Debug, Clone, Copy)]
pub struct Near<'a, T, const D: usize> {
    /// Low neighbour row per axis; entry 0 repeats entry 1, `x` neighbours are in the row itself.
    pub low: [&'a [T]; D],
    /// High neighbour row per axis; entry 0 repeats entry 1.
    pub high: [&'a [T]; D],
}

const GRAIN: usize = 1 << 14;

impl<const D: usize> Layout<D> {
    /// Calls `body(run, row, near)` for every row of `region`: `row` is the padded row (rim at either end) to change in
    /// place, `run` says which cells of it are meant (`row[run.cell[0] + 1 ..][.. run.len()]`). Rim rows and planes are
    /// only read. The caller's update must not read, from other rows, cells that the same call changes.
    pub fn par_rows_in_place<T: Send + Sync, S: Reduce>(
        &self,
        region: Region<D>,
        x: &mut [T],
        body: impl Fn(Run<'_, D>, &mut [T], Near<'_, T, D>) -> S + Sync,
    ) -> S {
        if region.is_empty() {
            return S::default();
        }
        let outer = D - 1;
        let plane = self.stride(outer);
        let (low, high) = (region.low[outer], region.high[outer]);
        let (below, rest) = x[low * plane..(high + 2) * plane].split_at_mut(plane);
        let (planes, above) = rest.split_at_mut((high - low) * plane);
        self.halve_in_place(region, planes, below, above, &body)
    }

    fn halve_in_place<T: Send + Sync, S: Reduce>(
        &self,
        region: Region<D>,
        planes: &mut [T],
        below: &[T],
        above: &[T],
        body: &(impl Fn(Run<'_, D>, &mut [T], Near<'_, T, D>) -> S + Sync),
    ) -> S {
        let outer = D - 1;
        let plane = self.stride(outer);
        let (low, high) = (region.low[outer], region.high[outer]);
        if high - low < 3 || planes.len() <= GRAIN {
            return vectorised(
                #[inline(always)]
                || {
                    let mut total = S::default();
                    for p in low..high {
                        let (before, rest) = planes.split_at_mut((p - low) * plane);
                        let (current, after) = rest.split_at_mut(plane);
                        let under = if p == low { below } else { &before[before.len() - plane..] };
                        let over = if p + 1 == high { above } else { &after[..plane] };
                        total = total.merge(self.plane_in_place(region, p, current, under, over, body));
                    }
                    total
                },
            );
        }
        let middle = low + (high - low) / 2;
        let (first, rest) = planes.split_at_mut((middle - low) * plane);
        let (between, second) = rest.split_at_mut(plane);
        let (mut region_a, mut region_b) = (region, region);
        region_a.high[outer] = middle;
        region_b.low[outer] = middle + 1;
        let shared: &[T] = between;
        let (a, b) = join(
            || self.halve_in_place(region_a, first, below, shared, body),
            || self.halve_in_place(region_b, second, shared, above, body),
        );
        let under = &first[first.len() - plane..];
        let over = if second.is_empty() { above } else { &second[..plane] };
        let last = vectorised(
            #[inline(always)]
            || self.plane_in_place(region, middle, between, under, over, body),
        );
        a.merge(b).merge(last)
    }

    #[inline(always)]
    fn plane_in_place<T, S: Reduce>(
        &self,
        region: Region<D>,
        p: usize,
        plane: &mut [T],
        below: &[T],
        above: &[T],
        body: &impl Fn(Run<'_, D>, &mut [T], Near<'_, T, D>) -> S,
    ) -> S {
        let len = region.high[0] - region.low[0];
        let row_slots = self.stride(1);
        let mut cell = region.low;
        cell[D - 1] = p;
        if D == 2 {
            return body(Run::new(self, cell, len), plane, Near { low: [below; D], high: [above; D] });
        }
        let mut total = S::default();
        for j in region.low[1]..region.high[1] {
            cell[1] = j;
            let at = (j + 1) * row_slots;
            let (before, rest) = plane.split_at_mut(at);
            let (row, after) = rest.split_at_mut(row_slots);
            let (ahead, behind) = (&before[at - row_slots..], &after[..row_slots]);
            let pick = inlined(
                #[inline(always)]
                |y, z| {
                    array(
                        #[inline(always)]
                        |a| if a < 2 { y } else { z },
                    )
                },
            );
            let near =
                Near { low: pick(ahead, &below[at..at + row_slots]), high: pick(behind, &above[at..at + row_slots]) };
            total = total.merge(body(Run::new(self, cell, len), row, near));
        }
        total
    }

    /// Sets the rim to zero.
    pub fn clear_rim<T: Copy + Default>(&self, x: &mut [T]) {
        for axis in 0..D {
            let stride = self.stride(axis);
            let block = stride * (self.cells()[axis] + 2);
            for part in x.chunks_exact_mut(block) {
                part[..stride].fill(T::default());
                part[block - stride..].fill(T::default());
            }
        }
    }

    /// Copies the cells of the opposite side into the rim along `axis`, so that neighbours of a periodic axis can be
    /// read there.
    pub fn wrap_rim<T: Copy>(&self, axis: usize, x: &mut [T]) {
        let stride = self.stride(axis);
        let block = stride * (self.cells()[axis] + 2);
        for part in x.chunks_exact_mut(block) {
            part.copy_within(block - 2 * stride..block - stride, 0);
            part.copy_within(stride..2 * stride, block - stride);
        }
    }
}

impl<const D: usize> Layout<D> {
    /// Copies each wall cell into the rim beside it along `axis`, so that differences across the wall are zero.
    pub fn mirror_rim<T: Copy>(&self, axis: usize, x: &mut [T]) {
        let stride = self.stride(axis);
        let block = stride * (self.cells()[axis] + 2);
        for part in x.chunks_exact_mut(block) {
            part.copy_within(stride..2 * stride, 0);
            part.copy_within(block - 2 * stride..block - stride, block - stride);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CellField;

    /// A red half sweep of averaging, serial by index arithmetic, against the in-place loop.
    fn check<const D: usize>(cells: [usize; D]) {
        let layout = Layout::new(cells).unwrap();
        let mut x = CellField::<f64>::new(&layout);
        for (s, v) in x.iter_mut().enumerate() {
            *v = ((s * 7919) % 1009) as f64;
        }
        let mut expected = x.clone();
        layout.each_row(layout.cells_region(), |run| {
            for at in run.ats() {
                if at.cell.iter().sum::<usize>() % 2 == 0 {
                    expected[at.slot()] = (0..D).map(|a| x[at.low(a)] + x[at.high(a)]).sum();
                }
            }
        });
        layout.par_rows_in_place(layout.cells_region(), &mut x, |run, row, near| {
            let parity = run.cell.iter().sum::<usize>() % 2;
            for i in (1 + parity..run.len() + 1).step_by(2) {
                let mut sum = row[i - 1] + row[i + 1];
                for a in 1..D {
                    sum += near.low[a][i] + near.high[a][i];
                }
                row[i] = sum;
            }
        });
        assert_eq!(x, expected);
    }

    #[test]
    fn one_colour_in_place_equals_the_copying_sweep() {
        check([5, 4]);
        check([300, 301]);
        check([1, 1]);
        check([40, 30, 50]);
        check([3, 5, 7]);
        check([64, 64, 2]);
    }

    #[test]
    fn the_rim_is_cleared_and_nothing_else() {
        let layout = Layout::new([3, 2, 4]).unwrap();
        let mut x = CellField::<f64>::new(&layout);
        x.fill(1.0);
        layout.clear_rim(&mut x);
        assert_eq!((x.iter().sum::<f64>(), layout.sum(&x)), (24.0, 24.0));
    }

    #[test]
    fn the_rim_wraps() {
        let layout = Layout::new([3, 2, 2]).unwrap();
        let mut x = CellField::<f64>::new(&layout);
        layout.par_cells(&mut x, |at| at.slot() as f64);
        for a in 0..3 {
            layout.wrap_rim(a, &mut x);
        }
        layout.each_row(layout.cells_region(), |run| {
            for at in run.ats() {
                for a in 0..3 {
                    let mut cell = at.cell;
                    cell[a] = (cell[a] + 1) % layout.cells()[a];
                    assert_eq!(x[at.high(a)], layout.slot(cell) as f64);
                }
            }
        });
    }
}
