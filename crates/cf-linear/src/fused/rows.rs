//! Half rows: the cells of one colour in one row, side by side.
//!
//! In a row of parity s = (sum of its outer indices) % 2 the red cells are those with x index i ≡ s (mod 2). Cell `m` of
//! a half row with parity q is i = 2 m + q; entry `m + 1` of its padded storage. The x neighbours of a cell are entries
//! m + q - 1 and m + q of the other half of the row, and its other neighbours are entry m of the *other* colour in the
//! neighbour rows, so that every loop here runs over neighbouring numbers and computes nothing in vain. Rows are in rings, so that none of this is a pass over memory.

use cf_grid::{Real, inlined};

use super::taps::Along;
use super::tile::Lines;

use crate::axis::AxisTable;
use crate::stencil::BoxStencil;

/// Coefficients that all cells of a row share; rows alike share them.
#[derive(Debug, Clone, Copy)]
struct Shared<T, const D: usize> {
    /// Conductances to the neighbour rows, entries 1.. , of a cell of unit width along x.
    low: [T; D],
    high: [T; D],
    /// Area of the faces along x.
    area: T,
    mass: T,
}

/// What varies along a half row of any kind.
#[derive(Debug, Clone)]
struct Varying<T> {
    /// Conductances of the faces along x per unit area.
    left: Lines<T>,
    right: Lines<T>,
    /// Width of each cell along x.
    width: Lines<T>,
}

/// What varies along a half row of one kind.
#[derive(Debug, Clone)]
struct Own<T> {
    inverse: Lines<T>,
    /// Mass and conductances of walls.
    lone: Lines<T>,
}

/// The rows of a level by kind.
#[derive(Debug, Clone)]
pub(crate) struct RowTable<T, const D: usize> {
    /// Kind of each index along axes 1.. .
    kinds: [Vec<u16>; D],
    count: [usize; D],
    varying: [Varying<T>; 2],
    rows: Vec<(Shared<T, D>, [Own<T>; 2])>,
}

/// The coefficients of a half row.
pub(crate) struct RowOp<'t, T, const D: usize> {
    shared: Shared<T, D>,
    left: &'t [[T; BLOCK]],
    right: &'t [[T; BLOCK]],
    width: &'t [[T; BLOCK]],
    inverse: &'t [[T; BLOCK]],
    lone: &'t [[T; BLOCK]],
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

/// Numbers that the loops here take at once: whole registers, and no rest, since rows are padded to blocks. Where a row has
/// no cell its coefficients are zero, and so is every result.
pub(crate) const BLOCK: usize = 16;

/// Blocks of a half row.
#[inline(always)]
fn count(n: usize) -> usize {
    half(n, 0).div_ceil(BLOCK)
}

/// Length of the padded storage of a half row.
pub(crate) fn padded(n: usize) -> usize {
    count(n) * BLOCK + 2
}

/// The blocks of a padded row from entry `first` on.
#[inline(always)]
pub(super) fn blocks<T>(row: &[T], first: usize, count: usize) -> &[[T; BLOCK]] {
    row[first..first + count * BLOCK].as_chunks().0
}

/// The same, to be written.
#[inline(always)]
pub(super) fn blocks_mut<T>(row: &mut [T], first: usize, count: usize) -> &mut [[T; BLOCK]] {
    row[first..first + count * BLOCK].as_chunks_mut().0
}

/// A block of what `value` returns for each entry.
#[inline(always)]
pub(super) fn block<T: Real>(value: impl Fn(usize) -> T) -> [T; BLOCK] {
    let mut block = [T::ZERO; BLOCK];
    for k in 0..BLOCK {
        block[k] = value(k);
    }
    block
}

/// Sets the rim of a half row of `h` cells: zero, or the cells of the other end.
#[inline(always)]
pub(crate) fn seal<T: Real>(row: &mut [T], h: usize, periodic: bool) {
    (row[0], row[h + 1]) = if periodic { (row[h], row[1]) } else { (T::ZERO, T::ZERO) };
}

/// Splits a row into its red half row, of parity `q`, and its black one, times `scale` where the precision changes.
#[inline(always)]
pub(crate) fn split<B: Real, T: Real>(b: &[B], scale: f64, q: usize, red: &mut [T], black: &mut [T]) {
    split_with(
        b,
        scale,
        q,
        red,
        black,
        #[inline(always)]
        |red, _, _| red,
    );
}

/// [`split`] with `f` of the red values and their blocks and entries.
#[inline(always)]
fn split_with<B: Real, T: Real>(
    b: &[B],
    scale: f64,
    q: usize,
    red: &mut [T],
    black: &mut [T],
    f: impl Fn(T, usize, usize) -> T,
) {
    let convert = inlined(
        #[inline(always)]
        |v: B| {
            if size_of::<B>() == size_of::<T>() { T::of(v.f64()) } else { T::of(v.f64() * scale) }
        },
    );
    let (pairs, rest) = b.as_chunks::<{ 2 * BLOCK }>();
    let (reds, blacks) = (blocks_mut(red, 1, pairs.len()), blocks_mut(black, 1, pairs.len()));
    for (i, ((pairs, red), black)) in pairs.iter().zip(reds).zip(blacks).enumerate() {
        let even: [T; BLOCK] = block(
            #[inline(always)]
            |k| convert(pairs[2 * k]),
        );
        let odd: [T; BLOCK] = block(
            #[inline(always)]
            |k| convert(pairs[2 * k + 1]),
        );
        let (own, other) = if q == 0 { (even, odd) } else { (odd, even) };
        *red = block(
            #[inline(always)]
            |k| f(own[k], i, k),
        );
        *black = other;
    }
    let done = pairs.len() * BLOCK;
    for (k, &v) in rest.iter().enumerate() {
        let (m, v) = (done + k / 2, convert(v));
        if k % 2 == q { red[1 + m] = f(v, m / BLOCK, m % BLOCK) } else { black[1 + m] = v }
    }
}

/// The row whose half rows are `even` and `odd`.
#[inline(always)]
pub(crate) fn join<T: Real>(even: &[T], odd: &[T], row: &mut [T]) {
    let (pairs, rest) = row.as_chunks_mut::<{ 2 * BLOCK }>();
    let (evens, odds) = (blocks(even, 1, pairs.len()), blocks(odd, 1, pairs.len()));
    let done = 1 + pairs.len() * BLOCK;
    for ((pairs, even), odd) in pairs.iter_mut().zip(evens).zip(odds) {
        let mut both = [T::ZERO; 2 * BLOCK];
        for k in 0..BLOCK {
            both[2 * k] = even[k];
            both[2 * k + 1] = odd[k];
        }
        *pairs = both;
    }
    for (k, v) in rest.iter_mut().enumerate() {
        *v = if k % 2 == 0 { even[done + k / 2] } else { odd[done + k / 2] };
    }
}

/// Sums that are formed in passing, in lanes: of b x, of x A x, and of x.
pub(crate) type Sums = [[f64; BLOCK]; 3];

/// What of [`Sums`] a sweep of relaxation adds to.
pub(crate) mod measure {
    /// Nothing.
    pub const NONE: u8 = 0;
    /// Everything for cells whose neighbours are relaxed later: of x A x what belongs to no face between two cells.
    pub const LONE: u8 = 1;
    /// Everything for cells whose neighbours are relaxed already.
    pub const WHOLE: u8 = 2;
}

impl<T: Real, const D: usize> RowOp<'_, T, D> {
    /// Splits a row as [`split`] does, into b/diagonal of this half row's cells and b of the others.
    #[inline(always)]
    pub fn split_divided<B: Real>(&self, b: &[B], scale: f64, q: usize, red: &mut [T], black: &mut [T]) {
        split_with(
            b,
            scale,
            q,
            red,
            black,
            #[inline(always)]
            |v, i, k| self.inverse[i][k] * v,
        );
    }

    /// out = b/diagonal + P coarse.
    #[inline(always)]
    pub fn divide_and_prolong(&self, q: usize, b: &[T], along: &Along<T>, coarse: &[T], out: &mut [T]) {
        let count = self.inverse.len();
        let (own, beside) = along.prolongation(q);
        let (parent, side, b) = (blocks(coarse, 1, count), blocks(coarse, 2 * q, count), blocks(b, 1, count));
        for (i, out) in blocks_mut(out, 1, count).iter_mut().enumerate() {
            let (inverse, b) = (&self.inverse[i], &b[i]);
            let (own, beside, parent, side) = (&own[i], &beside[i], &parent[i], &side[i]);
            *out = block(
                #[inline(always)]
                |k| inverse[k] * b[k] + (own[k] * parent[k] + beside[k] * side[k]),
            );
        }
    }

    /// The blocks of the neighbours along x, and of those along the other axes.
    #[inline(always)]
    fn near<'r>(&self, q: usize, near: &Around<'r, T, D>) -> Near<'r, T, D> {
        let count = self.inverse.len();
        let (mut low, mut high) = ([&[][..]; D], [&[][..]; D]);
        for a in 1..D {
            (low[a], high[a]) = (blocks(near.low[a], 1, count), blocks(near.high[a], 1, count));
        }
        Near { left: blocks(near.row, q, count), right: blocks(near.row, q + 1, count), low, high }
    }

    /// Σ w x over the neighbours of block `i`.
    #[inline(always)]
    fn sum(&self, i: usize, near: &Near<'_, T, D>) -> [T; BLOCK] {
        let w = &self.shared;
        let mut sides = [T::ZERO; BLOCK];
        for a in 1..D {
            let (low, high) = (&near.low[a][i], &near.high[a][i]);
            for k in 0..BLOCK {
                sides[k] += w.low[a] * low[k] + w.high[a] * high[k];
            }
        }
        let (left, right, wl, wr) = (&near.left[i], &near.right[i], &self.left[i], &self.right[i]);
        let width = &self.width[i];
        block(
            #[inline(always)]
            |k| width[k] * sides[k] + w.area * (wl[k] * left[k] + wr[k] * right[k]),
        )
    }

    /// out = Σ w x over the neighbours; `q` is the parity of the half row.
    #[inline(always)]
    pub fn gather(&self, q: usize, near: &Around<'_, T, D>, out: &mut [T]) {
        let count = self.inverse.len();
        let near = self.near(q, near);
        let open = self.width;
        for (i, out) in blocks_mut(out, 1, count).iter_mut().enumerate() {
            let (sum, open) = (self.sum(i, &near), &open[i]);
            // Zero where there is no cell.
            *out = block(
                #[inline(always)]
                |k| if open[k] > T::ZERO { sum[k] } else { T::ZERO },
            );
        }
    }

    /// out = (b + Σ w x)/diagonal: each cell's own equation solved. Adds to `sums` what `MEASURE` says.
    #[inline(always)]
    pub fn relax<const MEASURE: u8>(&self, q: usize, b: &[T], near: &Around<'_, T, D>, out: &mut [T], sums: &mut Sums) {
        let count = self.inverse.len();
        let near = self.near(q, near);
        let [mut bx, mut xax, mut total] = *sums;
        let b = blocks(b, 1, count);
        for (i, out) in blocks_mut(out, 1, count).iter_mut().enumerate() {
            let (sum, b, inverse) = (self.sum(i, &near), &b[i], &self.inverse[i]);
            let x = block(
                #[inline(always)]
                |k| inverse[k] * (b[k] + sum[k]),
            );
            *out = x;
            if MEASURE == measure::NONE {
                continue;
            }
            let energy = match MEASURE {
                measure::LONE => {
                    let lone = &self.lone[i];
                    block(
                        #[inline(always)]
                        |k| lone[k] * (x[k] * x[k]),
                    )
                }
                _ => self.energy(i, &x, &near),
            };
            for k in 0..BLOCK {
                bx[k] += b[k].f64() * x[k].f64();
                xax[k] += energy[k].f64();
                total[k] += x[k].f64();
            }
        }
        *sums = [bx, xax, total];
    }

    /// mass x² + Σ w (x - neighbour)² of the cells of block `i`.
    #[inline(always)]
    fn energy(&self, i: usize, x: &[T; BLOCK], near: &Near<'_, T, D>) -> [T; BLOCK] {
        let w = &self.shared;
        let square = inlined(
            #[inline(always)]
            |d: T| d * d,
        );
        let mut sides = block(
            #[inline(always)]
            |k| w.mass * square(x[k]),
        );
        for a in 1..D {
            let (low, high) = (&near.low[a][i], &near.high[a][i]);
            for k in 0..BLOCK {
                sides[k] += w.low[a] * square(x[k] - low[k]) + w.high[a] * square(x[k] - high[k]);
            }
        }
        let (left, right, wl, wr) = (&near.left[i], &near.right[i], &self.left[i], &self.right[i]);
        let width = &self.width[i];
        block(
            #[inline(always)]
            |k| {
                let along = wl[k] * square(x[k] - left[k]) + wr[k] * square(x[k] - right[k]);
                width[k] * sides[k] + w.area * along
            },
        )
    }
}

/// [`Around`] in blocks.
struct Near<'r, T, const D: usize> {
    left: &'r [[T; BLOCK]],
    right: &'r [[T; BLOCK]],
    low: [&'r [[T; BLOCK]]; D],
    high: [&'r [[T; BLOCK]]; D],
}

/// A table of what `value` gives for each cell of parity `q`, zero up to a whole block.
pub(super) fn table<T: Real>(n: usize, q: usize, value: impl Fn(usize) -> f64) -> Lines<T> {
    let cells = (q..n).step_by(2).map(value);
    cells.chain(std::iter::repeat(0.0)).take(count(n) * BLOCK).collect()
}

/// The blocks of a table.
#[inline(always)]
pub(super) fn of<T: Real>(table: &Lines<T>) -> &[[T; BLOCK]] {
    table.get().as_chunks().0
}

impl<T: Real> Varying<T> {
    fn new(axis: &AxisTable, q: usize) -> Self {
        let n = axis.len();
        Self {
            left: table(n, q, |i| axis.face[i]),
            right: table(n, q, |i| axis.face[i + 1]),
            width: table(n, q, |i| axis.width[i]),
        }
    }
}

impl<T: Real, const D: usize> Shared<T, D> {
    /// The coefficients of the row of `cell`, and what varies along its half rows.
    fn new(stencil: &BoxStencil<D>, cell: [usize; D]) -> (Self, [Own<T>; 2]) {
        let axes = &stencil.axes;
        let width = |a: usize| axes[a].width[cell[a]];
        let area: f64 = (1..D).map(width).product();
        let cut = |a: usize, i: usize| axes[a].face[i] * (1..D).filter(|&o| o != a).map(width).product::<f64>();
        let low: [f64; D] = std::array::from_fn(|a| if a == 0 { 0.0 } else { cut(a, cell[a]) });
        let high: [f64; D] = std::array::from_fn(|a| if a == 0 { 0.0 } else { cut(a, cell[a] + 1) });
        let mass = stencil.alpha * area;
        let sides: f64 = low.iter().chain(&high).sum();
        let wall = |a: usize, at: bool, w: f64| if at && !axes[a].periodic { w } else { 0.0 };
        let walls = |a: usize| wall(a, cell[a] == 0, low[a]) + wall(a, cell[a] + 1 == axes[a].len(), high[a]);
        let lone = mass + (1..D).map(walls).sum::<f64>();
        let x = &axes[0];
        let inverse = |i: usize| {
            let diagonal = x.width[i] * (mass + sides) + area * (x.face[i] + x.face[i + 1]);
            if diagonal > 0.0 { 1.0 / diagonal } else { 0.0 }
        };
        let lone = |i: usize| {
            let ends = wall(0, i == 0, x.face[i]) + wall(0, i + 1 == x.len(), x.face[i + 1]);
            x.width[i] * lone + area * ends
        };
        let own = std::array::from_fn(|q| Own { inverse: table(x.len(), q, inverse), lone: table(x.len(), q, lone) });
        (Self { low: low.map(T::of), high: high.map(T::of), area: T::of(area), mass: T::of(mass) }, own)
    }
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
                Shared::new(stencil, cell)
            })
            .collect();
        let varying = std::array::from_fn(|q| Varying::new(&stencil.axes[0], q));
        Self { kinds, count, varying, rows }
    }

    /// The coefficients of the half row of parity `q` of the row that a cell is in.
    #[inline(always)]
    pub fn row(&self, cell: [usize; D], q: usize) -> RowOp<'_, T, D> {
        let (mut code, mut stride) = (0, 1);
        for a in 1..D {
            code += stride * usize::from(self.kinds[a][cell[a]]);
            stride *= self.count[a];
        }
        let (varying, (shared, own)) = (&self.varying[q], &self.rows[code]);
        RowOp {
            shared: *shared,
            left: of(&varying.left),
            right: of(&varying.right),
            width: of(&varying.width),
            inverse: of(&own[q].inverse),
            lone: of(&own[q].lone),
        }
    }

    /// Bytes of all tables.
    pub fn bytes(&self) -> usize {
        let varying: usize = self.varying.iter().map(|v| v.left.bytes() + v.right.bytes() + v.width.bytes()).sum();
        let own: usize = self.rows.iter().flat_map(|r| &r.1).map(|o| o.inverse.bytes() + o.lone.bytes()).sum();
        varying + own + self.rows.len() * size_of::<Shared<T, D>>()
    }
}

/// What the coefficients of a row depend on.
fn kind(axis: &AxisTable, i: usize) -> ([u64; 3], [bool; 2]) {
    let wall = [i == 0, i + 1 == axis.len()].map(|at| at && !axis.periodic);
    ([axis.width[i], axis.face[i], axis.face[i + 1]].map(f64::to_bits), wall)
}
