//! The two loop primitives. The outermost axis is halved until a piece is small; sizes alone decide where.

use crate::simd::vectorised;
use crate::{At, Layout, Reduce, Region, Run, Slabs, join};

/// Pieces of at most this many slots run serially: about a third of a core's L2 in f64.
const GRAIN: usize = 1 << 14;

impl<const D: usize> Layout<D> {
    /// Calls `body` with every row of `region` and the same row of everything in `out`, in parallel, and merges what it
    /// returns in a fixed order. `out` is any [`Slabs`]: `()`, `&mut [T]`, arrays and tuples of them.
    pub fn par_runs<O: Slabs, S: Reduce>(
        &self,
        region: Region<D>,
        out: O,
        body: impl Fn(Run<'_, D>, O) -> S + Sync,
    ) -> S {
        if region.is_empty() {
            return S::default();
        }
        self.halve(region, out, 0, &body)
    }

    /// Sets every cell of `out` to what `value` returns for it, in parallel.
    pub fn par_cells<T: Send>(&self, out: &mut [T], value: impl Fn(At<'_, D>) -> T + Sync) {
        self.par_region(self.cells_region(), out, value);
    }

    /// [`par_cells`](Self::par_cells) over any region, for instance the faces of an axis.
    pub fn par_region<T: Send>(&self, region: Region<D>, out: &mut [T], value: impl Fn(At<'_, D>) -> T + Sync) {
        self.par_runs(
            region,
            out,
            #[inline(always)]
            |run, row: &mut [T]| {
                for (at, slot) in run.ats().zip(row) {
                    *slot = value(at);
                }
            },
        );
    }

    fn halve<O: Slabs, S: Reduce>(
        &self,
        region: Region<D>,
        out: O,
        base: usize,
        body: &(impl Fn(Run<'_, D>, O) -> S + Sync),
    ) -> S {
        let outer = D - 1;
        let (low, high) = (region.low[outer], region.high[outer]);
        let plane = self.stride(outer);
        if high - low == 1 || (high - low) * plane <= GRAIN {
            return vectorised(
                #[inline(always)]
                || self.serial(region, out, base, body),
            );
        }
        let middle = low + (high - low) / 2;
        let cut = (middle + 1) * plane;
        let (out_low, out_high) = out.split_at(cut - base);
        let (mut first, mut second) = (region, region);
        first.high[outer] = middle;
        second.low[outer] = middle;
        let (a, b) = join(|| self.halve(first, out_low, base, body), || self.halve(second, out_high, cut, body));
        a.merge(b)
    }

    #[inline(always)]
    fn serial<O: Slabs, S: Reduce>(
        &self,
        region: Region<D>,
        out: O,
        base: usize,
        body: &impl Fn(Run<'_, D>, O) -> S,
    ) -> S {
        let mut total = S::default();
        let (mut rest, mut at) = (Some(out), base);
        self.each_row(
            region,
            #[inline(always)]
            |run| {
                let Some(out) = rest.take() else { return };
                let (row, after) = out.split_at(run.start - at).1.split_at(run.len);
                total = std::mem::take(&mut total).merge(body(run, row));
                (rest, at) = (Some(after), run.start + run.len);
            },
        );
        total
    }

    /// Calls `f` with every cell of a region, serially, in storage order: for set-up work.
    pub fn each_cell(&self, region: Region<D>, mut f: impl FnMut(At<'_, D>)) {
        if !region.is_empty() {
            self.each_row(region, |run| run.ats().for_each(&mut f));
        }
    }

    /// Rows of a region in storage order.
    #[inline(always)]
    pub(crate) fn each_row(&self, region: Region<D>, mut f: impl FnMut(Run<'_, D>)) {
        let len = region.high[0] - region.low[0];
        let mut cell = region.low;
        loop {
            f(Run::new(self, cell, len));
            let mut axis = 1;
            loop {
                if axis == D {
                    return;
                }
                cell[axis] += 1;
                if cell[axis] < region.high[axis] {
                    break;
                }
                cell[axis] = region.low[axis];
                axis += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::CellField;

    #[test]
    fn a_sweep_visits_every_cell_once_and_no_rim() {
        for cells in [[7, 5, 3], [200, 90, 3], [1, 1, 300]] {
            let layout = Layout::new(cells).unwrap();
            let mut seen = CellField::<f64>::new(&layout);
            let n: usize = layout.par_runs(layout.cells_region(), &mut seen[..], |run, row: &mut [f64]| {
                row.iter_mut().for_each(|v| *v += 1.0);
                run.len()
            });
            assert_eq!(n, layout.count());
            assert_eq!(seen.iter().sum::<f64>(), n as f64);
            assert_eq!(layout.sum(&seen), n as f64);
        }
    }

    #[test]
    fn faces_reach_the_high_wall() {
        let layout = Layout::new([3, 4]).unwrap();
        let n: usize = layout.par_runs(layout.faces_region(1, false), (), |run, ()| run.len());
        assert_eq!(n, 3 * 5);
        let n: usize = layout.par_runs(layout.faces_region(0, true), (), |run, ()| run.len());
        assert_eq!(n, 3 * 4);
    }

    #[test]
    fn sums_have_the_same_bits_for_any_thread_count() {
        let layout = Layout::new([301, 257]).unwrap();
        let mut x = CellField::<f64>::new(&layout);
        layout.par_cells(&mut x, |at| ((at.slot() * 2654435761) % 1000003) as f64 / 7e5 - 0.3);
        let sums: Vec<u64> = [1, 2, 3, 5]
            .map(|n| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
                pool.install(|| layout.dot(&x, &x).to_bits())
            })
            .to_vec();
        assert!(sums.windows(2).all(|w| w[0] == w[1]));
    }

    proptest! {
        #[test]
        fn several_outputs_stay_aligned(cells in [1usize..40, 1..40, 1..40]) {
            let layout = Layout::new(cells).unwrap();
            let (mut a, mut b) = (CellField::<f32>::new(&layout), CellField::<f64>::new(&layout));
            layout.par_runs(layout.cells_region(), (&mut a[..], [&mut b[..]]), |run, (ra, [rb])| {
                for (i, at) in run.ats().enumerate() {
                    ra[i] = at.slot() as f32;
                    rb[i] = at.slot() as f64;
                }
            });
            let wrong: usize = layout.par_runs(layout.cells_region(), (), |run, ()| {
                run.ats().filter(|at| a[at.slot()] != at.slot() as f32 || b[at.slot()] != at.slot() as f64).count()
            });
            prop_assert_eq!(wrong, 0);
        }
    }
}
