//! Prolongation P (linear, with the walls' conductances) and restriction R = Pᵀ between two levels.
//!
//! Operators are integrated over cells, so R needs no scaling. Over obstacles P is rescaled per fine cell so that the
//! weights of open coarse cells keep their sum.

use cf_grid::{Layout, Real};

use crate::axis::Interpolation;

/// The pair P, Pᵀ between a fine and a coarse layout.
#[derive(Debug, Clone)]
pub(crate) struct Transfer<T, const D: usize> {
    pub fine: Layout<D>,
    pub coarse: Layout<D>,
    pub axes: [Interpolation; D],
    /// Per fine cell, only over obstacles.
    pub renormalise: Option<Vec<T>>,
}

/// Coarse cells handled at once.
const CHUNK: usize = 64;

impl<T: Real, const D: usize> Transfer<T, D> {
    /// Coarse rows (or fine rows, for restriction) are combined over the axes other than x: this lists the outer
    /// indices and weights a fine row draws on.
    fn sources(&self, cell: [usize; D]) -> impl Iterator<Item = ([isize; D], f64)> + '_ {
        (0..1usize << (D - 1)).filter_map(move |bits| {
            let mut index = [0isize; D];
            let mut weight = 1.0;
            for a in 1..D {
                let p = &self.axes[a];
                let i = cell[a];
                let parent = if p.coarsened { i / 2 } else { i } as isize;
                if bits >> (a - 1) & 1 == 0 {
                    index[a] = parent;
                    weight *= p.own[i];
                } else {
                    index[a] = if i % 2 == 1 { parent + 1 } else { parent - 1 };
                    weight *= p.other[i];
                }
            }
            (weight != 0.0).then_some((index, weight))
        })
    }

    /// The fine rows a coarse row draws on, with the weights of Pᵀ.
    fn targets(&self, cell: [usize; D]) -> impl Iterator<Item = ([isize; D], f64)> + '_ {
        let n = self.fine.cells();
        (0..1usize << (2 * (D - 1))).filter_map(move |code| {
            let mut index = [0isize; D];
            let mut weight = 1.0;
            for a in 1..D {
                let p = &self.axes[a];
                let which = (code >> (2 * (a - 1)) & 3) as isize;
                if !p.coarsened {
                    index[a] = cell[a] as isize;
                    weight *= if which == 0 { p.own[cell[a]] } else { 0.0 };
                    continue;
                }
                let i = 2 * cell[a] as isize - 1 + which;
                index[a] = i;
                weight *= self.weight_of(a, i, n[a], which);
            }
            (weight != 0.0).then_some((index, weight))
        })
    }

    /// Weight of fine cell `i` (position `which` = 0..4 around a coarse cell: neighbour, own, own, neighbour).
    #[inline(always)]
    fn weight_of(&self, a: usize, i: isize, n: usize, which: isize) -> f64 {
        let p = &self.axes[a];
        let inside = usize::try_from(i).ok().filter(|&i| i < n);
        match (which, inside) {
            (1 | 2, Some(i)) => p.own[i],
            // The left outer neighbour points up (odd), the right one points down (even).
            (0, Some(i)) => p.other[i],
            (3, Some(i)) => p.other[i],
            // Across a periodic seam: the rim holds the cell of the other side.
            (0, None) if i == -1 && n.is_multiple_of(2) => p.other[n - 1],
            (3, None) if i == n as isize && n.is_multiple_of(2) => p.other[0],
            (2, None) if i == n as isize => p.other[0] * f64::from(u8::from(!n.is_multiple_of(2))),
            _ => 0.0,
        }
    }

    fn slot(layout: &Layout<D>, index: [isize; D]) -> usize {
        (0..D).map(|a| (index[a] + 1) as usize * layout.stride(a)).sum()
    }

    /// coarse = Pᵀ fine. `fine`'s rim must be wrapped along periodic axes and zero elsewhere; its values are consumed.
    pub fn restrict(&self, fine: &mut [T], coarse: &mut [T]) {
        if let Some(scale) = &self.renormalise {
            self.fine.par_runs(self.fine.cells_region(), &mut *fine, |run, row: &mut [T]| {
                for (v, &s) in row.iter_mut().zip(run.row(scale)) {
                    *v *= s;
                }
            });
        }
        let fine = &*fine;
        let x = &self.axes[0];
        let n = self.fine.cells()[0];
        self.coarse.par_runs(self.coarse.cells_region(), coarse, |run, out: &mut [T]| {
            let m = run.len();
            let mut sum = [T::ZERO; 2 * CHUNK + 2];
            let mut start = 0;
            while start < m {
                let count = CHUNK.min(m - start);
                // Fine cells 2·start - 1 ..= 2·(start + count), as far as they exist (the rim counts).
                let first = if x.coarsened { 2 * start as isize - 1 } else { start as isize };
                let len = if x.coarsened { (2 * count + 2).min((n as isize + 1 - first) as usize) } else { count };
                let sum = &mut sum[..];
                sum.fill(T::ZERO);
                for (mut index, weight) in self.targets(run.cell) {
                    index[0] = first;
                    let from = Self::slot(&self.fine, index);
                    let weight = T::of(weight);
                    for (s, &v) in sum[..len].iter_mut().zip(&fine[from..from + len]) {
                        *s += weight * v;
                    }
                }
                for (k, out) in out[start..start + count].iter_mut().enumerate() {
                    let coarse = start + k;
                    *out = if !x.coarsened {
                        T::of(x.own[coarse]) * sum[k]
                    } else if coarse > 0 && 2 * coarse + 4 < n {
                        T::of(0.25) * (sum[2 * k] + sum[2 * k + 3]) + T::of(0.75) * (sum[2 * k + 1] + sum[2 * k + 2])
                    } else {
                        let mut total = T::ZERO;
                        for which in 0..4 {
                            let i = 2 * coarse as isize - 1 + which;
                            let weight = self.weight_of(0, i, n, which);
                            if weight != 0.0 {
                                total += T::of(weight) * sum[2 * k + which as usize];
                            }
                        }
                        total
                    };
                }
                start += count;
            }
        });
    }

    /// fine += P coarse. `coarse`'s rim must be wrapped along periodic axes.
    pub fn prolong_add(&self, coarse: &[T], fine: &mut [T]) {
        let x = &self.axes[0];
        let (n, m) = (self.fine.cells()[0], self.coarse.cells()[0]);
        self.fine.par_runs(self.fine.cells_region(), fine, |run, out: &mut [T]| {
            let scale = self.renormalise.as_deref().map(|s| run.row(s));
            let mut sum = [T::ZERO; CHUNK + 2];
            let mut start = 0;
            while start < m {
                let count = CHUNK.min(m - start);
                let sum = &mut sum[..count + 2];
                sum.fill(T::ZERO);
                for (mut index, weight) in self.sources(run.cell) {
                    index[0] = start as isize - 1;
                    let from = Self::slot(&self.coarse, index);
                    let weight = T::of(weight);
                    for (s, &v) in sum.iter_mut().zip(&coarse[from..from + count + 2]) {
                        *s += weight * v;
                    }
                }
                let children = if x.coarsened { 2 } else { 1 };
                let last = (children * (start + count)).min(n);
                for i in children * start..last {
                    let k = i / children - start + 1;
                    let neighbour = if i % 2 == 1 { k + 1 } else { k - 1 };
                    let mut value = if x.coarsened && i > 0 && i + 3 < n {
                        T::of(0.75) * sum[k] + T::of(0.25) * sum[neighbour]
                    } else if x.other[i] != 0.0 {
                        T::of(x.own[i]) * sum[k] + T::of(x.other[i]) * sum[neighbour]
                    } else {
                        T::of(x.own[i]) * sum[k]
                    };
                    if let Some(scale) = scale {
                        value *= scale[i];
                    }
                    out[i] += value;
                }
                start += count;
            }
        });
    }
}
