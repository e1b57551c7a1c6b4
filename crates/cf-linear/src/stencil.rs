//! The operator of one level, row by row: (A x)_c = mass_c x_c + sum over faces of w_f (x_c - x_n).
//!
//! The difference form makes constants exact: with closed walls the face terms of a constant are zero, not rounding
//! noise. Two coefficient kinds share it: [`BoxStencil`] stores nothing per cell, [`StoredStencil`] has one number per
//! face and cell. Walls are faces whose outer neighbour is the rim, which holds zero; a closed wall has w_f = 0. Rim
//! values along periodic axes are copies of the opposite side.

use cf_grid::{Layout, Real, Run, array};

use crate::axis::AxisTable;

/// Neighbour rows of a run along axes 1.., each as long as the run; entry 0 is not used.
pub(crate) struct Rows<'a, T, const D: usize> {
    pub low: [&'a [T]; D],
    pub high: [&'a [T]; D],
}

impl<'a, T, const D: usize> Rows<'a, T, D> {
    #[inline(always)]
    pub fn of(run: &Run<'_, D>, x: &'a [T]) -> Self {
        Self {
            low: array(
                #[inline(always)]
                |a| run.low(a, x),
            ),
            high: array(
                #[inline(always)]
                |a| run.high(a, x),
            ),
        }
    }
}

/// Row kernels of a level operator.
pub(crate) trait Stencil<T: Real, const D: usize>: Sync {
    /// out = f(A x, out) on a run. `c` is the run with one more value at either end.
    fn apply(&self, run: &Run<'_, D>, c: &[T], near: Rows<'_, T, D>, out: &mut [T], f: impl Fn(T, T) -> T + Copy);

    /// out_c = f(J_c, out_c), J_c = (b_c + Σ w_f x_n)/diagonal_c: the solution of each cell's own equation.
    fn jacobi(
        &self,
        run: &Run<'_, D>,
        c: &[T],
        near: Rows<'_, T, D>,
        b: &[T],
        out: &mut [T],
        f: impl Fn(T, T) -> T + Copy,
    );

    /// out = diagonal · x on a run, `x` its cells.
    fn weigh(&self, run: &Run<'_, D>, x: &[T], out: &mut [T]);

    /// Sets the cells of one colour, (sum of indices) % 2 == `colour`, to the solution of their own equation. `row` is
    /// the padded row of the level: cell `i` is `row[i + 1]`.
    fn relax(&self, run: &Run<'_, D>, row: &mut [T], near: Rows<'_, T, D>, b: &[T], colour: usize);
}

/// Cells whose sums are formed at once on the stack.
const CHUNK: usize = 64;

/// Uniform coefficients on a tensor-product box.
#[derive(Debug, Clone)]
pub(crate) struct BoxStencil<const D: usize> {
    pub alpha: f64,
    pub axes: [AxisTable; D],
}

/// Coefficients of one row of a [`BoxStencil`], x width of the inner cells folded in.
struct RowWeights<T, const D: usize> {
    mass: T,
    x: T,
    low: [T; D],
    high: [T; D],
    diagonal: f64,
    area: f64,
}

impl<const D: usize> BoxStencil<D> {
    #[inline(always)]
    fn row_weights<T: Real>(&self, run: &Run<'_, D>) -> RowWeights<T, D> {
        let inner = self.bulk_width();
        let (mut low, mut high, mut area) = ([0.0; D], [0.0; D], 1.0);
        for a in 1..D {
            let mut across = inner;
            for o in (1..D).filter(|&o| o != a) {
                across *= self.axes[o].width[run.cell[o]];
            }
            let face = &self.axes[a].face;
            (low[a], high[a]) = (face[run.cell[a]] * across, face[run.cell[a] + 1] * across);
            area *= self.axes[a].width[run.cell[a]];
        }
        let mass = self.alpha * inner * area;
        let x = self.axes[0].face.get(1).copied().unwrap_or(0.0) * area;
        let sides: f64 = low.iter().chain(&high).sum();
        RowWeights {
            mass: T::of(mass),
            x: T::of(x),
            low: array(
                #[inline(always)]
                |a| T::of(low[a]),
            ),
            high: array(
                #[inline(always)]
                |a| T::of(high[a]),
            ),
            diagonal: mass + sides,
            area,
        }
    }

    /// Width along x of all cells but the first and the last two.
    #[inline(always)]
    fn bulk_width(&self) -> f64 {
        let width = &self.axes[0].width;
        width[1.min(width.len() - 1)]
    }

    /// Cells whose two x faces and width are those of the bulk.
    #[inline(always)]
    fn inner(&self, run: &Run<'_, D>) -> std::ops::Range<usize> {
        let n = self.axes[0].len();
        let (from, to) = (run.cell[0].max(1), (run.cell[0] + run.len()).min(n.saturating_sub(2)));
        from..to.max(from).min(from.max(to))
    }

    /// Scale of mass and side weights, and the two x weights, of cell `i`.
    #[inline(always)]
    fn edge(&self, i: usize, area: f64) -> (f64, f64, f64) {
        let x = &self.axes[0];
        (x.width[i] / self.bulk_width(), x.face[i] * area, x.face[i + 1] * area)
    }

    /// Solution of the equation of cell `i` (entry `t` of the run) near the ends of a row.
    #[allow(clippy::too_many_arguments)]
    fn own_solution<T: Real>(
        &self,
        w: &RowWeights<T, D>,
        i: usize,
        t: usize,
        b: T,
        left: T,
        right: T,
        near: &Rows<'_, T, D>,
    ) -> T {
        let (scale, wl, wr) = self.edge(i, w.area);
        let diagonal = scale * w.diagonal + wl + wr;
        let mut sides = T::ZERO;
        for a in 1..D {
            sides += w.low[a] * near.low[a][t] + w.high[a] * near.high[a][t];
        }
        let sum = b + T::of(scale) * sides + (T::of(wl) * left + T::of(wr) * right);
        if diagonal > 0.0 { T::of(1.0 / diagonal) * sum } else { T::ZERO }
    }
}

/// out = f(value, out) for a whole run. `bulk` writes the values of some entries from one on, as of cells whose
/// coefficients are those of the bulk; `end` gives that of the first and the last two cells of a row, by index and entry.
#[inline(always)]
fn each<T: Real, const D: usize>(
    run: &Run<'_, D>,
    n: usize,
    out: &mut [T],
    f: impl Fn(T, T) -> T,
    bulk: impl Fn(usize, &mut [T]),
    end: impl Fn(usize, usize) -> T,
) {
    let (first, len) = (run.cell[0], run.len());
    let mut values = [T::ZERO; CHUNK];
    for from in (0..len).step_by(CHUNK) {
        let to = (from + CHUNK).min(len);
        // The compiler does the last cells of a loop one by one, unless it knows their number: the last chunk begins early.
        let start = if len < CHUNK { from } else { to - CHUNK };
        if len < CHUNK {
            bulk(start, &mut values[..to - start]);
        } else {
            bulk(start, &mut values);
        }
        for i in [0, n.saturating_sub(2), n - 1] {
            if (first + from..first + to).contains(&i) {
                values[i - first - start] = end(i, i - first);
            }
        }
        for (out, &value) in out[from..to].iter_mut().zip(&values[from - start..]) {
            *out = f(value, *out);
        }
    }
}

impl<T: Real, const D: usize> Stencil<T, D> for BoxStencil<D> {
    #[inline(always)]
    fn apply(&self, run: &Run<'_, D>, c: &[T], near: Rows<'_, T, D>, out: &mut [T], f: impl Fn(T, T) -> T + Copy) {
        let w = self.row_weights::<T>(run);
        each(
            run,
            self.axes[0].len(),
            out,
            f,
            #[inline(always)]
            |t, values| {
                let n = values.len();
                let (l, x, r) = (&c[t..t + n], &c[t + 1..t + 1 + n], &c[t + 2..t + 2 + n]);
                let low: [&[T]; D] = array(
                    #[inline(always)]
                    |a| &near.low[a][t..t + n],
                );
                let high: [&[T]; D] = array(
                    #[inline(always)]
                    |a| &near.high[a][t..t + n],
                );
                for i in 0..n {
                    let v = x[i];
                    let mut sides = w.mass * v;
                    for a in 1..D {
                        sides += w.low[a] * (v - low[a][i]) + w.high[a] * (v - high[a][i]);
                    }
                    values[i] = sides + w.x * ((v - l[i]) + (v - r[i]));
                }
            },
            #[inline(always)]
            |i, t| {
                let (scale, wl, wr) = self.edge(i, w.area);
                let (scale, wl, wr) = (T::of(scale), T::of(wl), T::of(wr));
                let x = c[t + 1];
                let mut sides = w.mass * x;
                for a in 1..D {
                    sides += w.low[a] * (x - near.low[a][t]) + w.high[a] * (x - near.high[a][t]);
                }
                scale * sides + (wl * (x - c[t]) + wr * (x - c[t + 2]))
            },
        );
    }

    #[inline(always)]
    fn jacobi(
        &self,
        run: &Run<'_, D>,
        c: &[T],
        near: Rows<'_, T, D>,
        b: &[T],
        out: &mut [T],
        f: impl Fn(T, T) -> T + Copy,
    ) {
        let w = self.row_weights::<T>(run);
        let inverse = T::of(1.0 / (w.diagonal + 2.0 * w.x.f64()));
        each(
            run,
            self.axes[0].len(),
            out,
            f,
            #[inline(always)]
            |t, values| {
                let n = values.len();
                let (l, r, b) = (&c[t..t + n], &c[t + 2..t + 2 + n], &b[t..t + n]);
                let low: [&[T]; D] = array(
                    #[inline(always)]
                    |a| &near.low[a][t..t + n],
                );
                let high: [&[T]; D] = array(
                    #[inline(always)]
                    |a| &near.high[a][t..t + n],
                );
                for i in 0..n {
                    let mut sum = b[i] + w.x * (l[i] + r[i]);
                    for a in 1..D {
                        sum += w.low[a] * low[a][i] + w.high[a] * high[a][i];
                    }
                    values[i] = inverse * sum;
                }
            },
            #[inline(always)]
            |i, t| self.own_solution(&w, i, t, b[t], c[t], c[t + 2], &near),
        );
    }

    #[inline(always)]
    fn weigh(&self, run: &Run<'_, D>, x: &[T], out: &mut [T]) {
        let w = self.row_weights::<T>(run);
        let diagonal = T::of(w.diagonal + 2.0 * w.x.f64());
        each(
            run,
            self.axes[0].len(),
            out,
            |v, _| v,
            #[inline(always)]
            |t, values| {
                for (v, &x) in values.iter_mut().zip(&x[t..]) {
                    *v = diagonal * x;
                }
            },
            #[inline(always)]
            |i, t| {
                let (scale, wl, wr) = self.edge(i, w.area);
                T::of(scale * w.diagonal + wl + wr) * x[t]
            },
        );
    }

    #[inline(always)]
    fn relax(&self, run: &Run<'_, D>, row: &mut [T], near: Rows<'_, T, D>, b: &[T], colour: usize) {
        let w = self.row_weights::<T>(run);
        let first = run.cell[0];
        let inner = self.inner(run);
        let others: usize = run.cell[1..].iter().sum();
        let meant = |i: usize| (i + others) % 2 == colour;
        for i in (first..inner.start).chain(inner.end.max(first)..first + run.len()) {
            if meant(i) {
                let t = i - first;
                row[i + 1] = self.own_solution(&w, i, t, b[t], row[i], row[i + 2], &near);
            }
        }
        let inverse = T::of(1.0 / (w.diagonal + 2.0 * w.x.f64()));
        // All sums of a chunk at once, which is faster than every other one; then those of the colour are stored.
        let mut sums = [T::ZERO; CHUNK];
        let mut i = inner.start;
        while i < inner.end {
            let n = CHUNK.min(inner.end - i);
            let t = i - first;
            let sums = &mut sums[..n];
            let beside = row[i..i + n].iter().zip(&row[i + 2..i + 2 + n]);
            for ((sum, &b), (&l, &r)) in sums.iter_mut().zip(&b[t..t + n]).zip(beside) {
                *sum = b + w.x * (l + r);
            }
            for a in 1..D {
                let pairs = near.low[a][t..t + n].iter().zip(&near.high[a][t..t + n]);
                for (sum, (&l, &h)) in sums.iter_mut().zip(pairs) {
                    *sum += w.low[a] * l + w.high[a] * h;
                }
            }
            let phase = usize::from(!meant(i));
            let own = row[i + 1 + phase..i + 1 + n.max(phase)].chunks_mut(2);
            for (pair, sums) in own.zip(sums[phase.min(n)..].chunks(2)) {
                pair[0] = inverse * sums[0];
            }
            i += n;
        }
    }
}

/// One stored weight per face and one stored mass per cell: obstacles and variable coefficients.
#[derive(Debug, Clone)]
pub(crate) struct StoredStencil<T, const D: usize> {
    pub mass: Vec<T>,
    pub face: [Vec<T>; D],
    /// 1/diagonal; zero in cells without a conducting face, solid or lonely, which keeps them at zero: the value of a
    /// lonely fluid cell is a constant, which [`Deflation`](crate::deflate::Deflation) knows.
    pub inverse: Vec<T>,
}

impl<T: Real, const D: usize> StoredStencil<T, D> {
    /// From masses and face weights in f64.
    pub fn new(layout: &Layout<D>, mass: &[f64], face: &[Vec<f64>; D]) -> Self {
        let mut inverse = vec![T::ZERO; layout.slots()];
        layout.par_cells(&mut inverse, |at| {
            let sum: f64 = (0..D).map(|a| face[a][at.slot()] + face[a][at.high(a)]).sum();
            let inverse = T::of(if sum > 0.0 { 1.0 / (mass[at.slot()] + sum) } else { 0.0 });
            if inverse.is_finite() { inverse } else { T::ZERO }
        });
        let round = |v: &[f64]| v.iter().map(|&x| T::of(x)).collect();
        Self { mass: round(mass), face: std::array::from_fn(|a| round(&face[a])), inverse }
    }
}

impl<T: Real, const D: usize> Stencil<T, D> for StoredStencil<T, D> {
    #[inline(always)]
    fn apply(&self, run: &Run<'_, D>, c: &[T], near: Rows<'_, T, D>, out: &mut [T], f: impl Fn(T, T) -> T + Copy) {
        let n = run.len();
        let mass = run.row(&self.mass);
        let (xl, xr) = (run.row(&self.face[0]), run.high(0, &self.face[0]));
        let wl: [&[T]; D] = array(
            #[inline(always)]
            |a| run.row(&self.face[a]),
        );
        let wh: [&[T]; D] = array(
            #[inline(always)]
            |a| run.high(a, &self.face[a]),
        );
        let (low, high) = (near.low, near.high);
        let (l, x, r) = (&c[..n], &c[1..n + 1], &c[2..n + 2]);
        let out = &mut out[..n];
        for i in 0..n {
            let v = x[i];
            let mut sum = mass[i] * v;
            for a in 1..D {
                sum += wl[a][i] * (v - low[a][i]) + wh[a][i] * (v - high[a][i]);
            }
            out[i] = f(sum + (xl[i] * (v - l[i]) + xr[i] * (v - r[i])), out[i]);
        }
    }

    #[inline(always)]
    fn jacobi(
        &self,
        run: &Run<'_, D>,
        c: &[T],
        near: Rows<'_, T, D>,
        b: &[T],
        out: &mut [T],
        f: impl Fn(T, T) -> T + Copy,
    ) {
        let n = run.len();
        let (xl, xr) = (run.row(&self.face[0]), run.high(0, &self.face[0]));
        let wl: [&[T]; D] = array(
            #[inline(always)]
            |a| run.row(&self.face[a]),
        );
        let wh: [&[T]; D] = array(
            #[inline(always)]
            |a| run.high(a, &self.face[a]),
        );
        let (inverse, b) = (run.row(&self.inverse), &b[..n]);
        let (l, r) = (&c[..n], &c[2..n + 2]);
        let out = &mut out[..n];
        for i in 0..n {
            let mut sum = b[i] + (xl[i] * l[i] + xr[i] * r[i]);
            for a in 1..D {
                sum += wl[a][i] * near.low[a][i] + wh[a][i] * near.high[a][i];
            }
            out[i] = f(inverse[i] * sum, out[i]);
        }
    }

    #[inline(always)]
    fn weigh(&self, run: &Run<'_, D>, x: &[T], out: &mut [T]) {
        for ((out, &x), &inverse) in out.iter_mut().zip(x).zip(run.row(&self.inverse)) {
            *out = if inverse > T::ZERO { x / inverse } else { T::ZERO };
        }
    }

    #[inline(always)]
    fn relax(&self, run: &Run<'_, D>, row: &mut [T], near: Rows<'_, T, D>, b: &[T], colour: usize) {
        let n = run.len();
        let (xl, xr) = (run.row(&self.face[0]), run.high(0, &self.face[0]));
        let wl: [&[T]; D] = array(
            #[inline(always)]
            |a| run.row(&self.face[a]),
        );
        let wh: [&[T]; D] = array(
            #[inline(always)]
            |a| run.high(a, &self.face[a]),
        );
        let inverse = run.row(&self.inverse);
        let (low, high) = (near.low, near.high);
        let (b, first) = (&b[..n], run.cell[0]);
        let phase = (run.cell.iter().sum::<usize>() + colour) % 2;
        for i in (phase..n).step_by(2) {
            let mut sum = b[i] + (xl[i] * row[first + i] + xr[i] * row[first + i + 2]);
            for a in 1..D {
                sum += wl[a][i] * low[a][i] + wh[a][i] * high[a][i];
            }
            row[first + i + 1] = inverse[i] * sum;
        }
    }
}
