//! Prolongation P (linear, with the walls' conductances) and restriction R = Pᵀ between two levels.
//!
//! Operators are integrated over cells, so R needs no scaling. Over obstacles P is rescaled per fine cell so that the
//! weights of open coarse cells keep their sum.
//!
//! Passes where a level is not fused: 1 + 2^-D to restrict, 2 + 2^-D to prolong and add, one more each with rescaling.

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

    /// The first part of Pᵀ, before the rim is wrapped: over obstacles `fine` is multiplied by the scale of its rows.
    pub fn weigh(&self, fine: &mut [T]) {
        if let Some(scale) = &self.renormalise {
            self.fine.par_runs(
                self.fine.cells_region(),
                fine,
                #[inline(always)]
                |run, row: &mut [T]| {
                    for (v, &s) in row.iter_mut().zip(run.row(scale)) {
                        *v *= s;
                    }
                },
            );
        }
    }

    /// coarse = Pᵀ fine, for a weighed `fine` whose rim is wrapped along periodic axes and zero elsewhere.
    pub fn restrict(&self, fine: &[T], coarse: &mut [T]) {
        let x = &self.axes[0];
        let n = self.fine.cells()[0];
        self.coarse.par_runs(
            self.coarse.cells_region(),
            coarse,
            #[inline(always)]
            |run, out: &mut [T]| {
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
                            T::of(0.25) * (sum[2 * k] + sum[2 * k + 3])
                                + T::of(0.75) * (sum[2 * k + 1] + sum[2 * k + 2])
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
            },
        );
    }

    /// fine += P coarse. `coarse`'s rim must be wrapped along periodic axes.
    pub fn prolong_add(&self, coarse: &[T], fine: &mut [T]) {
        let x = &self.axes[0];
        let (n, m) = (self.fine.cells()[0], self.coarse.cells()[0]);
        let children = if x.coarsened { 2 } else { 1 };
        let (near, far) = (T::of(0.75), T::of(0.25));
        self.fine.par_runs(
            self.fine.cells_region(),
            fine,
            #[inline(always)]
            |run, out: &mut [T]| {
                let scale = self.renormalise.as_deref().map(|s| run.row(s));
                let (mut sum, mut values) = ([T::ZERO; CHUNK + 2], [T::ZERO; 2 * CHUNK]);
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
                    let (first, last) = (children * start, (children * (start + count)).min(n));
                    let values = &mut values[..last - first];
                    let inner = if x.coarsened { self.inner(start, count) } else { start..start };
                    let parents = sum[inner.start - start..inner.end - start + 2].windows(3);
                    let pairs = values[children * (inner.start - start)..].chunks_exact_mut(2);
                    for (pair, c) in pairs.zip(parents) {
                        pair[0] = near * c[1] + far * c[0];
                        pair[1] = near * c[1] + far * c[2];
                    }
                    for i in (first..children * inner.start).chain(children * inner.end..last) {
                        let k = i / children - start + 1;
                        let neighbour = if i % 2 == 1 { k + 1 } else { k - 1 };
                        values[i - first] = T::of(x.own[i]) * sum[k];
                        if x.other[i] != 0.0 {
                            values[i - first] += T::of(x.other[i]) * sum[neighbour];
                        }
                    }
                    if let Some(scale) = scale {
                        values.iter_mut().zip(&scale[first..last]).for_each(|(v, &s)| *v *= s);
                    }
                    out[first..last].iter_mut().zip(&*values).for_each(|(out, &v)| *out += v);
                    start += count;
                }
            },
        );
    }

    /// Those of `count` coarse cells from `start` on whose children have the weights 3/4 and 1/4.
    fn inner(&self, start: usize, count: usize) -> std::ops::Range<usize> {
        let n = self.fine.cells()[0];
        let end = start + count;
        let from = start.max(1).min(end);
        from..n.saturating_sub(4).div_ceil(2).clamp(from, end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::AxisTable;

    const SIZES: [usize; 11] = [1, 2, 3, 4, 5, 7, 8, 13, 64, 127, 261];

    fn walls() -> [Option<[f64; 2]>; 4] {
        [None, Some([0.0; 2]), Some([2.0, 2.0]), Some([0.0, 0.3])]
    }

    fn transfer<const D: usize>(cells: [usize; D], walls: [Option<[f64; 2]>; D]) -> (Transfer<f64, D>, [bool; D]) {
        let pairs: [_; D] = std::array::from_fn(|a| AxisTable::new(cells[a], 1.0, walls[a]).coarsen());
        let coarse = Layout::new(pairs.each_ref().map(|p| p.0.len())).unwrap();
        let axes = pairs.map(|p| p.1);
        (Transfer { fine: Layout::new(cells).unwrap(), coarse, axes, renormalise: None }, walls.map(|w| w.is_none()))
    }

    fn field<const D: usize>(layout: &Layout<D>, periodic: [bool; D], value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut x = vec![0.0; layout.slots()];
        layout.each_cell(layout.cells_region(), |at| x[at.slot()] = value(at.slot()));
        (0..D).filter(|&a| periodic[a]).for_each(|a| layout.wrap_rim(a, &mut x));
        x
    }

    /// x·P y = Pᵀ x·y for everything at once, and P 1 = 1 away from conducting walls.
    fn check<const D: usize>(cells: [usize; D], walls: [Option<[f64; 2]>; D], scaled: bool) {
        let (mut t, periodic) = transfer(cells, walls);
        if scaled {
            t.renormalise = Some(field(&t.fine, [false; D], |s| (s % 5) as f64 / 3.0));
        }
        let noise = |s: usize| ((s * 7919 + 13) % 1009) as f64 / 1009.0 - 0.4;
        let (mut x, y) = (field(&t.fine, periodic, noise), field(&t.coarse, periodic, noise));
        let original = x.clone();
        let (mut py, mut rx) = (vec![0.0; t.fine.slots()], vec![0.0; t.coarse.slots()]);
        t.prolong_add(&y, &mut py);
        t.weigh(&mut x);
        (0..D).filter(|&a| periodic[a]).for_each(|a| t.fine.wrap_rim(a, &mut x));
        t.restrict(&x, &mut rx);
        let (left, right) = (t.fine.dot(&original, &py), t.coarse.dot(&rx, &y));
        assert!(
            (left - right).abs() <= 1e-12 * (1.0 + left.abs()) * cells[0] as f64,
            "{cells:?} {walls:?}: {left} {right}"
        );
        if !scaled && walls.iter().all(|w| w.is_none_or(|w| w == [0.0; 2])) {
            let one = field(&t.coarse, periodic, |_| 1.0);
            let mut p1 = vec![0.0; t.fine.slots()];
            t.prolong_add(&one, &mut p1);
            t.fine.each_cell(t.fine.cells_region(), |at| {
                assert!((p1[at.slot()] - 1.0).abs() < 1e-15, "{cells:?} {walls:?} at {:?}", at.cell);
            });
        }
    }

    #[test]
    fn restriction_is_the_transpose_of_prolongation() {
        for nx in SIZES {
            for wx in walls() {
                for (ny, wy) in SIZES[..7].iter().flat_map(|&n| walls().map(|w| (n, w))) {
                    check([nx, ny], [wx, wy], false);
                    check([nx, ny], [wx, wy], true);
                }
            }
        }
        for w in walls() {
            for v in walls() {
                check([5, 4, 3], [w, v, None], false);
                check([3, 2, 7], [v, None, w], true);
                check([1, 6, 2], [w, w, v], false);
            }
        }
    }

    /// P is linear between coarse centres: exact for x itself in the interior.
    #[test]
    fn prolongation_is_exact_for_linear_fields() {
        let (t, _) = transfer([33, 18], [Some([0.0; 2]); 2]);
        let (mut coarse, mut fine) = (vec![0.0; t.coarse.slots()], vec![0.0; t.fine.slots()]);
        let centre = |i: usize, n: usize| if 2 * i + 1 == n { n as f64 - 0.5 } else { 2.0 * i as f64 + 1.0 };
        t.coarse.each_cell(t.coarse.cells_region(), |at| {
            coarse[at.slot()] = centre(at.cell[0], 33) - 3.0 * centre(at.cell[1], 18);
        });
        t.prolong_add(&coarse, &mut fine);
        let mut inner = t.fine.cells_region();
        (inner.low, inner.high) = ([1, 1], [32, 17]);
        t.fine.each_cell(inner, |at| {
            let expected = at.cell[0] as f64 + 0.5 - 3.0 * (at.cell[1] as f64 + 0.5);
            assert!((fine[at.slot()] - expected).abs() < 1e-12, "{:?}", at.cell);
        });
    }
}
