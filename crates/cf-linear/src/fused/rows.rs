//! Half rows: the cells of one colour in one row, side by side.
//!
//! In a row of parity s = (sum of its outer indices) % 2 the red cells are those with x index i ≡ s (mod 2). Cell `m` of
//! a half row with parity q is i = 2 m + q; entry `m + 1` of its padded storage. The x neighbours of a cell are entries
//! m + q - 1 and m + q of the other half of the row, and its other neighbours are entry m of the *other* colour in the
//! neighbour rows, so that every loop here runs over neighbouring numbers and computes nothing in vain.

use cf_grid::{Real, row_sum};

use crate::axis::AxisTable;
use crate::stencil::BoxStencil;

/// Coefficients of one row; rows alike share them.
#[derive(Debug, Clone)]
pub(crate) struct RowOp<T, const D: usize> {
    /// Conductances to the neighbour rows, entries 1.. .
    low: [T; D],
    high: [T; D],
    /// Conductance along x.
    x: T,
    mass: T,
    inverse: T,
    /// Mass and wall conductances along axes 1.. .
    lone: T,
    /// Cells 0, n - 2, n - 1, and those between.
    ends: [End<T>; 4],
}

/// A cell near the end of a row: `scale` is its width against that of the others.
#[derive(Debug, Clone, Copy)]
struct End<T> {
    left: T,
    right: T,
    scale: T,
    inverse: T,
    lone: T,
}

/// The rows of a level by kind.
#[derive(Debug, Clone)]
pub(crate) struct RowTable<T, const D: usize> {
    /// Kind of each index along axes 1.. .
    kinds: [Vec<u16>; D],
    count: [usize; D],
    rows: Vec<RowOp<T, D>>,
}

/// The neighbours of the cells of one half row, padded: all of the other colour.
pub(crate) struct Around<'r, T, const D: usize> {
    pub row: &'r [T],
    pub low: [&'r [T]; D],
    pub high: [&'r [T]; D],
}

/// Cells of parity `q` in a row of `n`.
#[inline(always)]
pub(crate) fn half(n: usize, q: usize) -> usize {
    (n + 1 - q) / 2
}

/// Length of the padded storage of a half row.
pub(crate) fn padded(n: usize) -> usize {
    n.div_ceil(2) + 2
}

/// Sets the rim of a half row of `h` cells: zero, or the cells of the other end.
#[inline(always)]
pub(crate) fn seal<T: Real>(row: &mut [T], h: usize, periodic: bool) {
    row[h + 1..].fill(T::ZERO);
    row[0] = T::ZERO;
    if periodic {
        (row[0], row[h + 1]) = (row[h], row[1]);
    }
}

/// Splits a row into its half rows of even and odd cells, times `scale` where the precision changes.
#[inline(always)]
pub(crate) fn split<B: Real, T: Real>(b: &[B], scale: f64, even: &mut [T], odd: &mut [T]) {
    let (he, ho) = (half(b.len(), 0), half(b.len(), 1));
    let (even, odd) = (&mut even[1..1 + he], &mut odd[1..1 + ho]);
    let convert = |v: B| if size_of::<B>() == size_of::<T>() { T::of(v.f64()) } else { T::of(v.f64() * scale) };
    for ((pair, e), o) in b.chunks_exact(2).zip(even.iter_mut()).zip(odd.iter_mut()) {
        *e = convert(pair[0]);
        *o = convert(pair[1]);
    }
    if he > ho {
        even[he - 1] = convert(b[2 * ho]);
    }
}

/// The row whose half rows are `even` and `odd`.
#[inline(always)]
pub(crate) fn join<T: Real>(even: &[T], odd: &[T], row: &mut [T]) {
    let (he, ho) = (half(row.len(), 0), half(row.len(), 1));
    let (even, odd) = (&even[1..1 + he], &odd[1..1 + ho]);
    for ((pair, &e), &o) in row.chunks_exact_mut(2).zip(even).zip(odd) {
        pair[0] = e;
        pair[1] = o;
    }
    if he > ho {
        row[2 * ho] = even[he - 1];
    }
}

/// Cells whose energies are formed at once on the stack.
const CHUNK: usize = 64;

impl<T: Real, const D: usize> RowOp<T, D> {
    fn new(stencil: &BoxStencil<D>, cell: [usize; D]) -> Self {
        let axes = &stencil.axes;
        let (n, inner) = (axes[0].len(), axes[0].width[0]);
        let width = |a: usize| axes[a].width[cell[a]];
        let area: f64 = (1..D).map(width).product();
        let cut = |a: usize, i: usize| axes[a].face[i] * inner * (1..D).filter(|&o| o != a).map(width).product::<f64>();
        let low: [f64; D] = std::array::from_fn(|a| if a == 0 { 0.0 } else { cut(a, cell[a]) });
        let high: [f64; D] = std::array::from_fn(|a| if a == 0 { 0.0 } else { cut(a, cell[a] + 1) });
        let mass = stencil.alpha * inner * area;
        let sides: f64 = low.iter().chain(&high).sum();
        let walls = |a: usize| {
            let at = |wall: bool, w: f64| if wall && !axes[a].periodic { w } else { 0.0 };
            at(cell[a] == 0, low[a]) + at(cell[a] + 1 == axes[a].len(), high[a])
        };
        let lone = mass + (1..D).map(walls).sum::<f64>();
        let invert = |diagonal: f64| T::of(if diagonal > 0.0 { 1.0 / diagonal } else { 0.0 });
        let x = axes[0].face.get(1).copied().unwrap_or(0.0) * area;
        let end = |i: usize| {
            let scale = axes[0].width[i] / inner;
            let (left, right) = (axes[0].face[i] * area, axes[0].face[i + 1] * area);
            let wall = |at: bool, w: f64| if at && !axes[0].periodic { w } else { 0.0 };
            End {
                left: T::of(left),
                right: T::of(right),
                scale: T::of(scale),
                inverse: invert(scale * (mass + sides) + left + right),
                lone: T::of(scale * lone + wall(i == 0, left) + wall(i + 1 == n, right)),
            }
        };
        let (x, inverse) = (T::of(x), invert(mass + sides + 2.0 * x));
        let bulk = End { left: x, right: x, scale: T::ONE, inverse, lone: T::of(lone) };
        let ends = [end(0), end(n.saturating_sub(2)), end(n - 1), bulk];
        Self { low: low.map(T::of), high: high.map(T::of), x, mass: T::of(mass), inverse, lone: T::of(lone), ends }
    }

    #[inline(always)]
    fn end(&self, i: usize, n: usize) -> &End<T> {
        let which = match i {
            0 => 0,
            i if i + 1 == n => 2,
            i if i + 2 == n => 1,
            _ => 3,
        };
        &self.ends[which]
    }

    /// b/diagonal.
    #[inline(always)]
    pub fn divide(&self, n: usize, q: usize, b: &[T], out: &mut [T]) {
        let h = half(n, q);
        for (out, &b) in out[1..1 + h].iter_mut().zip(&b[1..1 + h]) {
            *out = self.inverse * b;
        }
        for m in ends(h) {
            out[m + 1] = self.end(2 * m + q, n).inverse * b[m + 1];
        }
    }

    /// Σ w x over the neighbours, or with `RELAX` the solution (b + Σ w x)/diagonal of each cell's own equation.
    #[inline(always)]
    pub fn gather<const RELAX: bool>(&self, n: usize, q: usize, b: &[T], near: &Around<'_, T, D>, out: &mut [T]) {
        let h = half(n, q);
        for m in ends(h) {
            let end = self.end(2 * m + q, n);
            let mut sides = T::ZERO;
            for a in 1..D {
                sides += self.low[a] * near.low[a][m + 1] + self.high[a] * near.high[a][m + 1];
            }
            let sum = end.scale * sides + (end.left * near.row[m + q] + end.right * near.row[m + q + 1]);
            out[m + 1] = if RELAX { end.inverse * (b[m + 1] + sum) } else { sum };
        }
        if h < 3 {
            return;
        }
        let k = h - 2;
        let (left, right) = (&near.row[q + 1..q + 1 + k], &near.row[q + 2..q + 2 + k]);
        let low: [&[T]; D] = std::array::from_fn(|a| &near.low[a][2..2 + k]);
        let high: [&[T]; D] = std::array::from_fn(|a| &near.high[a][2..2 + k]);
        let (b, out) = (&b[2..2 + k], &mut out[2..2 + k]);
        for m in 0..k {
            let mut sum = self.x * (left[m] + right[m]);
            for a in 1..D {
                sum += self.low[a] * low[a][m] + self.high[a] * high[a][m];
            }
            out[m] = if RELAX { self.inverse * (b[m] + sum) } else { sum };
        }
    }

    /// Σ over the cells of mass x² + Σ w (x - neighbour)².
    #[inline(always)]
    pub fn energy(&self, n: usize, q: usize, x: &[T], near: &Around<'_, T, D>) -> f64 {
        let h = half(n, q);
        let square = |d: T| d * d;
        let mut total = 0.0;
        for m in ends(h) {
            let end = self.end(2 * m + q, n);
            let v = x[m + 1];
            let mut sides = self.mass * square(v);
            for a in 1..D {
                sides += self.low[a] * square(v - near.low[a][m + 1]) + self.high[a] * square(v - near.high[a][m + 1]);
            }
            let along = end.left * square(v - near.row[m + q]) + end.right * square(v - near.row[m + q + 1]);
            total += (end.scale * sides + along).f64();
        }
        let mut from = 1;
        let mut energies = [T::ZERO; CHUNK];
        while from + 1 < h {
            let k = CHUNK.min(h - 1 - from);
            let at = from + 1;
            let (left, right) = (&near.row[from + q..from + q + k], &near.row[at + q..at + q + k]);
            let low: [&[T]; D] = std::array::from_fn(|a| &near.low[a][at..at + k]);
            let high: [&[T]; D] = std::array::from_fn(|a| &near.high[a][at..at + k]);
            let (x, energies) = (&x[at..at + k], &mut energies[..k]);
            for m in 0..k {
                let v = x[m];
                let mut sum = self.mass * square(v) + self.x * (square(v - left[m]) + square(v - right[m]));
                for a in 1..D {
                    sum += self.low[a] * square(v - low[a][m]) + self.high[a] * square(v - high[a][m]);
                }
                energies[m] = sum;
            }
            total += row_sum(energies);
            from += k;
        }
        total
    }

    /// Σ over the cells of (mass + conductances of walls) x²: what [`energy`](Self::energy) of the other colour leaves.
    #[inline(always)]
    pub fn lone_energy(&self, n: usize, q: usize, x: &[T]) -> f64 {
        let h = half(n, q);
        let end = |m: usize| (self.end(2 * m + q, n).lone * x[m + 1] * x[m + 1]).f64();
        let mut total: f64 = ends(h).map(end).sum();
        if h > 2 && self.lone > T::ZERO {
            let x = &x[2..h];
            total += self.lone.f64() * cf_grid::row_dot(x, x);
        }
        total
    }
}

/// First and last cell of a half row.
#[inline(always)]
fn ends(h: usize) -> impl Iterator<Item = usize> {
    (0..h.min(1)).chain(h.max(2) - 1..h)
}

impl<T: Real, const D: usize> RowTable<T, D> {
    pub fn new(stencil: &BoxStencil<D>) -> Self {
        let mut samples: [Vec<usize>; D] = std::array::from_fn(|_| vec![0]);
        let kinds: [Vec<u16>; D] = std::array::from_fn(|a| {
            if a == 0 {
                return Vec::new();
            }
            let axis = &stencil.axes[a];
            let mut known = Vec::new();
            samples[a].clear();
            (0..axis.len())
                .map(|i| {
                    let kind = kind(axis, i);
                    known.iter().position(|k| *k == kind).unwrap_or_else(|| {
                        known.push(kind);
                        samples[a].push(i);
                        known.len() - 1
                    }) as u16
                })
                .collect()
        });
        let count = samples.each_ref().map(Vec::len);
        let rows = (0..count.iter().product())
            .map(|mut code: usize| {
                let cell = std::array::from_fn(|a| {
                    let i = samples[a][code % count[a]];
                    code /= count[a];
                    i
                });
                RowOp::new(stencil, cell)
            })
            .collect();
        Self { kinds, count, rows }
    }

    /// The coefficients of a row, by any of its cells.
    #[inline(always)]
    pub fn row(&self, cell: [usize; D]) -> &RowOp<T, D> {
        let (mut code, mut stride) = (0, 1);
        for a in 1..D {
            code += stride * usize::from(self.kinds[a][cell[a]]);
            stride *= self.count[a];
        }
        &self.rows[code]
    }
}

/// What the coefficients of a row depend on.
fn kind(axis: &AxisTable, i: usize) -> ([u64; 3], [bool; 2]) {
    let wall = [i == 0, i + 1 == axis.len()].map(|at| at && !axis.periodic);
    ([axis.width[i], axis.face[i], axis.face[i + 1]].map(f64::to_bits), wall)
}
