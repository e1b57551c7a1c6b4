//! A field between its values, for a stretch of neighbours at once.
//!
//! Where all points of a stretch lie within two cells of each other beyond their regular spacing, which is nearly always, every row of
//! values around them is one contiguous slice for the whole stretch, and no gathering is needed. Where they even lie in
//! one cell beyond it, each of them uses the same few slices: the plain formula in vector registers. Elsewhere weights
//! that are zero outside the own cell replace gathering. A stretch that is torn further apart is done point by point.

use cf_grid::{Real, array, inlined};

use crate::lattice::Lattice;
use crate::point;

/// Values done together.
pub(crate) const LANES: usize = 64;

/// Values done together where a stretch of [`LANES`] is torn too far apart.
pub(crate) const FEW: usize = 16;

/// Begins and lengths of the short stretches of a row from `x` up to `end`. The last one overlaps the one before it where the row, which
/// begins at `low`, is long enough: a whole stretch seldom reaches beyond what is stored.
#[inline(always)]
pub(crate) fn few(low: usize, x: usize, end: usize) -> impl Iterator<Item = (usize, usize)> {
    (x..end).step_by(FEW).map(
        #[inline(always)]
        move |x| {
            let x = if end - x < FEW { x.min(end.saturating_sub(FEW).max(low)) } else { x };
            (x, FEW.min(end - x))
        },
    )
}

/// One number per value of a stretch.
pub(crate) type Lanes<T, const L: usize = LANES> = [T; L];

/// Where a stretch is interpolated along one axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Along<T, const L: usize> {
    /// Index of the cell below the first point relative to each value's own index.
    first: i64,
    /// Whether some points lie in the next cell.
    torn: bool,
    /// Distance from `first` \[cells\]: within \[0, 1\], or \[0, 2\] if torn.
    t: Lanes<T, L>,
}

/// Smallest and largest of a stretch.
#[inline(always)]
pub(crate) fn range<T: Real, const L: usize>(x: &Lanes<T, L>) -> [T; 2] {
    const HALF: usize = LANES / 2;
    let (mut low, mut high) = ([T::ZERO; HALF], [T::ZERO; HALF]);
    let mut width = L / 2;
    for i in 0..width {
        low[i] = x[i].min(x[i + width]);
        high[i] = x[i].max(x[i + width]);
    }
    width /= 2;
    while width > 0 {
        for i in 0..width {
            low[i] = low[i].min(low[i + width]);
            high[i] = high[i].max(high[i + width]);
        }
        width /= 2;
    }
    [low[0], high[0]]
}

/// The same along every axis.
#[inline(always)]
pub(crate) fn ranges<T: Real, const D: usize, const L: usize>(x: &[Lanes<T, L>; D]) -> [[T; 2]; D] {
    let mut bounds = [[T::ZERO; 2]; D];
    for a in 0..D {
        bounds[a] = range(&x[a]);
    }
    bounds
}

impl<T: Real, const L: usize> Along<T, L> {
    /// Nowhere yet.
    pub const NONE: Self = Self { first: 0, torn: false, t: [T::ZERO; L] };

    /// Places points at `shift + by` \[cells\] from each value; `bounds` is the range of `shift`. False where the shifts
    /// differ by more than a cell or are not numbers.
    #[inline(always)]
    pub fn set(&mut self, shift: &Lanes<T, L>, bounds: [T; 2], by: T) -> bool {
        let [low, high] = bounds.map(
            #[inline(always)]
            |x| x + by,
        );
        let below = point::floor(low.f64());
        let base = T::of(below as f64);
        // Of NaN no comparison holds.
        if !(low >= base && high < base + T::of(2.0)) {
            return false;
        }
        self.torn = high > base + T::ONE;
        self.first = below;
        let offset = by - base;
        for i in 0..L {
            self.t[i] = shift[i] + offset;
        }
        true
    }

    /// Linear weights of `first`, `first` + 1, `first` + 2.
    #[inline(always)]
    fn hats(&self) -> [Lanes<T, L>; 3] {
        let mut w = [[T::ZERO; L]; 3];
        for i in 0..L {
            let t = self.t[i];
            w[0][i] = (T::ONE - t).max(T::ZERO);
            w[1][i] = T::ONE - (t - T::ONE).abs();
            w[2][i] = (t - T::ONE).max(T::ZERO);
        }
        w
    }

    /// Cubic weights of `first` - 1 to `first` + 3; the last is 0 if not torn.
    #[inline(always)]
    fn lagrange(&self) -> [Lanes<T, L>; 5] {
        let mut w = [[T::ZERO; L]; 5];
        if !self.torn {
            for i in 0..L {
                let own = point::cubic(self.t[i]);
                for k in 0..4 {
                    w[k][i] = own[k];
                }
            }
            return w;
        }
        for i in 0..L {
            let t = self.t[i];
            let upper = if t > T::ONE { T::ONE } else { T::ZERO };
            let own = point::cubic(t - upper);
            let lower = T::ONE - upper;
            w[0][i] = lower * own[0];
            for k in 1..4 {
                w[k][i] = lower * own[k] + upper * own[k - 1];
            }
            w[4][i] = upper * own[3];
        }
        w
    }
}

/// The values of `field` from x index `start` on, as many as `buffer` has, in the row whose first value has slot `base`.
/// The rim of `field` along x must be as [`Lattice::continue_rows`] leaves it.
#[inline(always)]
fn row<'f, T: Real, const D: usize>(
    lattice: &Lattice<D>,
    field: &'f [T],
    base: usize,
    negative: bool,
    start: i64,
    buffer: &'f mut [T],
) -> &'f [T] {
    let len = buffer.len();
    if !negative && start >= -1 && start + len as i64 - 1 <= lattice.stored() {
        let from = (base as i64 + start) as usize;
        if let Some(row) = field.get(from..from + len) {
            return row;
        }
    }
    outer_row(lattice, field, base, negative, start, buffer);
    buffer
}

/// A row that reaches beyond an end of the axis.
#[inline(never)]
fn outer_row<T: Real, const D: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    base: usize,
    negative: bool,
    start: i64,
    buffer: &mut [T],
) {
    let len = buffer.len() as i64;
    let low = start.saturating_neg().clamp(0, len) as usize;
    let high = (lattice.last(0) + 1).saturating_sub(start).clamp(low as i64, len) as usize;
    if low < high {
        let from = base + (start + low as i64) as usize;
        buffer[low..high].copy_from_slice(&field[from..from + high - low]);
        if negative {
            buffer[low..high].iter_mut().for_each(|v| *v = -*v);
        }
    }
    for i in (0..low).chain(high..buffer.len()) {
        let (index, flip) = lattice.place(0, start.saturating_add(i as i64));
        let v = field[base + index];
        buffer[i] = if flip != negative { -v } else { v };
    }
}

/// Slot of the first value of the row at `index` along the axes other than x, and whether its values change sign.
#[inline(always)]
fn base_of<const D: usize>(lattice: &Lattice<D>, index: [i64; D]) -> (usize, bool) {
    let (mut cell, mut negative) = ([0; D], false);
    for a in 1..D {
        let (place, flip) = lattice.place(a, index[a]);
        cell[a] = place;
        negative ^= flip;
    }
    (lattice.layout.slot(cell), negative)
}

/// The values `LINE` along x from the point below, in all rows around the points of a stretch that is torn along no axis;
/// `None` where some of them are not stored as they are.
#[inline(always)]
fn inner<'f, T: Real, const D: usize, const L: usize>(
    lattice: &Lattice<D>,
    field: &'f [T],
    cell: [i64; D],
    along: [&Along<T, L>; D],
) -> Option<[[&'f Lanes<T, L>; 2]; 4]> {
    let start = cell[0] + along[0].first;
    let mut low = [0; D];
    let mut whole = start >= -1 && start + L as i64 <= lattice.stored() && !along[0].torn;
    for a in 1..D {
        let index = cell[a] + along[a].first;
        whole &= index >= 0 && index < lattice.last(a) && !along[a].torn;
        low[a] = index as usize;
    }
    if !whole {
        return None;
    }
    let base = (lattice.layout.slot(low) as i64 + start) as usize;
    let line = inlined(
        #[inline(always)]
        |at: usize| Some([lanes(field, at)?, lanes(field, at + lattice.layout.stride(0))?]),
    );
    let (y, z) = (lattice.layout.stride(1), if D == 3 { lattice.layout.stride(D - 1) } else { 0 });
    Some([line(base)?, line(base + y)?, line(base + z)?, line(base + y + z)?])
}

/// The values of a stretch from slot `at` on.
#[inline(always)]
pub(crate) fn lanes<T, const L: usize>(field: &[T], at: usize) -> Option<&Lanes<T, L>> {
    field.get(at..).and_then(<[T]>::first_chunk)
}

/// The values at the points of a stretch, linear; `cell` is the index of its first value.
#[inline(always)]
pub(crate) fn linear<T: Real, const D: usize, const L: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    along: [&Along<T, L>; D],
) -> Lanes<T, L> {
    let Some([v, vy, vz, vyz]) = inner(lattice, field, cell, along) else {
        return linear_torn(lattice, field, cell, along);
    };
    let (x, y, z) = (&along[0].t, &along[1].t, &along[D - 1].t);
    let mut total = [T::ZERO; L];
    for i in 0..L {
        let low = v[0][i] + x[i] * (v[1][i] - v[0][i]);
        let high = vy[0][i] + x[i] * (vy[1][i] - vy[0][i]);
        let below = low + y[i] * (high - low);
        total[i] = if D == 3 {
            let low = vz[0][i] + x[i] * (vz[1][i] - vz[0][i]);
            let high = vyz[0][i] + x[i] * (vyz[1][i] - vyz[0][i]);
            let above = low + y[i] * (high - low);
            below + z[i] * (above - below)
        } else {
            below
        };
    }
    total
}

/// The same where points lie in two cells along some axes, or near an end of one.
#[inline(always)]
fn linear_torn<T: Real, const D: usize, const L: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    along: [&Along<T, L>; D],
) -> Lanes<T, L> {
    let mut weights = [[[T::ZERO; L]; 3]; D];
    let (mut first, mut count) = ([0; D], [0; D]);
    for a in 0..D {
        weights[a] = along[a].hats();
        first[a] = cell[a] + along[a].first;
        count[a] = 2 + usize::from(along[a].torn);
    }
    if along[0].torn {
        sum::<T, D, 3, 3, L>(lattice, field, first, count, &weights)
    } else {
        sum::<T, D, 3, 2, L>(lattice, field, first, count, &weights)
    }
}

/// The same, cubic.
#[inline(always)]
pub(crate) fn cubic<T: Real, const D: usize, const L: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    along: [&Along<T, L>; D],
) -> Lanes<T, L> {
    let mut weights = [[[T::ZERO; L]; 5]; D];
    let (mut first, mut count) = ([0; D], [0; D]);
    for a in 0..D {
        weights[a] = along[a].lagrange();
        first[a] = cell[a] + along[a].first - 1;
        count[a] = 4 + usize::from(along[a].torn);
    }
    if along[0].torn {
        sum::<T, D, 5, 5, L>(lattice, field, first, count, &weights)
    } else {
        sum::<T, D, 5, 4, L>(lattice, field, first, count, &weights)
    }
}

/// Σ weights · values over `count` points per axis from index `first` on, `P` of them along x.
#[inline(always)]
fn sum<T: Real, const D: usize, const W: usize, const P: usize, const L: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    first: [i64; D],
    count: [usize; D],
    weights: &[[Lanes<T, L>; W]; D],
) -> Lanes<T, L> {
    let wx = &weights[0];
    let zero = [T::ZERO; L];
    let mut buffer = [T::ZERO; LANES + 4];
    let buffer = &mut buffer[..L + P - 1];
    let mut total = zero;
    // Slots of the rows, y and z apart.
    let mut rows = [[(0, false); W]; D];
    for a in 1..D {
        for (w, row) in rows[a].iter_mut().enumerate().take(count[a]) {
            let (place, flip) = lattice.place(a, first[a] + w as i64);
            *row = ((place + 1) * lattice.layout.stride(a), flip);
        }
    }
    let planes = if D == 3 { count[D - 1] } else { 1 };
    for z in 0..planes {
        let (above, turned) = if D == 3 { rows[D - 1][z] } else { (0, false) };
        let mut plane = [T::ZERO; L];
        for (y, wy) in weights[1].iter().enumerate().take(count[1]) {
            let (base, negative) = rows[1][y];
            let v = row(lattice, field, above + base + 1, negative != turned, first[0], buffer);
            let mut points = [&zero; P];
            for p in 0..P {
                let Some(v) = lanes(v, p * lattice.layout.stride(0)) else { return total };
                points[p] = v;
            }
            for i in 0..L {
                let mut line = wx[0][i] * points[0][i];
                for p in 1..P {
                    line += wx[p][i] * points[p][i];
                }
                plane[i] += wy[i] * line;
            }
        }
        if D == 3 {
            let wz = &weights[D - 1][z];
            for i in 0..L {
                total[i] += wz[i] * plane[i];
            }
        } else {
            total = plane;
        }
    }
    total
}

/// The mean of the values around each value of a stretch: those at `low` .. `low + 2` along axes where `pair` holds.
#[inline(always)]
pub(crate) fn mean<T: Real, const D: usize, const L: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    low: [i64; D],
    pair: [bool; D],
) -> Lanes<T, L> {
    let zero = [T::ZERO; L];
    let mut total = zero;
    let mut buffer = [T::ZERO; LANES + 1];
    let buffer = &mut buffer[..L + usize::from(pair[0])];
    let mut share = if pair[0] { 0.5 } else { 1.0 };
    for a in 1..D {
        share *= if pair[a] { 0.5 } else { 1.0 };
    }
    let planes = if D == 3 && pair[D - 1] { 2 } else { 1 };
    let mut index = cell;
    for z in 0..planes {
        if D == 3 {
            index[D - 1] = cell[D - 1] + low[D - 1] + z as i64;
        }
        for y in 0..if pair[1] { 2 } else { 1 } {
            index[1] = cell[1] + low[1] + y as i64;
            let (base, negative) = base_of(lattice, index);
            let v = row(lattice, field, base, negative, cell[0] + low[0], buffer);
            if pair[0] {
                let (Some(v), Some(next)) = (lanes::<T, L>(v, 0), lanes::<T, L>(v, lattice.layout.stride(0))) else {
                    return total;
                };
                for i in 0..L {
                    total[i] += v[i] + next[i];
                }
            } else {
                let Some(v) = lanes::<T, L>(v, 0) else { return total };
                for i in 0..L {
                    total[i] += v[i];
                }
            }
        }
    }
    let share = T::of(share);
    array(
        #[inline(always)]
        |i| share * total[i],
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wall::FlowWall;
    use cf_grid::{Axis, Layout, Sides};

    fn check<const K: usize>(spread: f64, offset: f64) {
        let layout = Layout::new([41, 7, 5]).unwrap();
        let mut sides = Sides::all(FlowWall::Closed);
        sides.0[1] = Axis::Periodic;
        for lattice in [Lattice::cells(&layout, &sides, |_, _| 0.0), Lattice::faces(&layout, &sides, 2)] {
            let mut field: Vec<f64> = (0..layout.slots()).map(|s| ((s * 7919) % 101) as f64).collect();
            lattice.continue_rows(&mut field);
            for x0 in [-1, 0, 3, 17, 38] {
                let cell = [x0, 6, 0];
                let shift: [Lanes<f64>; 3] = std::array::from_fn(|a| {
                    std::array::from_fn(|i| offset + spread * ((i * (a + 3)) % 7) as f64 / 7.0)
                });
                let w = shift.map(|s| {
                    let mut w = Along::NONE;
                    assert!(w.set(&s, range(&s), 0.0));
                    w
                });
                let w = [&w[0], &w[1], &w[2]];
                let got = if K == 2 { linear(&lattice, &field, cell, w) } else { cubic(&lattice, &field, cell, w) };
                for i in 0..LANES {
                    let own = [x0 + i as i64, 6, 0];
                    let (want, _, _) = point::sample::<f64, 3, K>(&lattice, &field, own, shift.map(|s| s[i]));
                    assert!((got[i] - want).abs() < 1e-10, "{x0} {i} {} {want}", got[i]);
                }
            }
        }
    }

    #[test]
    fn stretches_equal_points() {
        for offset in [-1.4, -0.3, 0.0, 2.7] {
            for spread in [0.0, 0.2, 1.1] {
                check::<2>(spread, offset);
                check::<4>(spread, offset);
            }
        }
        for torn in [std::array::from_fn(|i| i as f32), [f32::NAN; LANES]] {
            let mut along = Along::NONE;
            assert!(!along.set(&torn, range::<f32, LANES>(&torn), 0.0));
        }
    }

    #[test]
    fn short_stretches_cover_the_rest_of_a_row() {
        for (low, x, end) in
            [(0, 0, 1), (0, 0, 16), (0, 0, 40), (64, 64, 65), (0, 64, 65), (0, 64, 100), (10, 11, 30), (5, 5, 5)]
        {
            let stretches: Vec<_> = few(low, x, end).collect();
            let covered = |i| stretches.iter().any(|(begin, len)| (*begin..begin + len).contains(&i));
            assert!((x..end).all(covered), "{low} {x} {end}: {stretches:?}");
            assert!(stretches.iter().all(|(begin, len)| *begin >= low && begin + len <= end && *len <= FEW));
            // None is short where the row is long enough.
            assert!(end - low < FEW || stretches.iter().all(|(_, len)| *len == FEW), "{low} {x} {end}: {stretches:?}");
        }
    }
}
