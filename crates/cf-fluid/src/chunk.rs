//! A field between its values, for a stretch of neighbours at once.
//!
//! Where all points of a stretch lie within two cells of each other beyond their regular spacing, which is nearly always, every row of
//! values around them is one contiguous slice for the whole stretch. Weights that are zero outside the own cell then
//! replace gathering: the same loop of multiplications for every value, in vector registers. A stretch that is torn
//! further apart is done point by point.

use cf_grid::{Real, array};

use crate::lattice::Lattice;
use crate::point;

/// Values done together.
pub(crate) const LANES: usize = 32;
/// Longest row around a stretch: two more points than a cubic needs within one cell.
const WINDOW: usize = LANES + 4;

/// One number per value of a stretch.
pub(crate) type Lanes<T> = [T; LANES];

/// Points and weights of a stretch along one axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights<T> {
    /// Index of the first point relative to each value's own index.
    first: i64,
    /// Points with any weight: 2 or 3 linear, 4 or 5 cubic.
    count: usize,
    at: [Lanes<T>; 5],
}

/// Smallest and largest of a stretch.
#[inline(always)]
pub(crate) fn range<T: Real>(x: &Lanes<T>) -> (T, T) {
    let (mut low, mut high) = (*x, *x);
    let mut width = LANES / 2;
    while width > 0 {
        for i in 0..width {
            low[i] = low[i].min(low[i + width]);
            high[i] = high[i].max(high[i + width]);
        }
        width /= 2;
    }
    (low[0], high[0])
}

impl<T: Real> Weights<T> {
    /// No points.
    pub const NONE: Self = Self { first: 0, count: 0, at: [[T::ZERO; LANES]; 5] };

    /// False where the shifts differ by too much.
    #[inline(always)]
    pub fn usable(&self) -> bool {
        self.count > 0
    }
}

/// Weights of `K` = 2 (linear) or 4 (cubic Lagrange) points at `shift` \[cells\] from each value;
/// [`NONE`](Weights::NONE) where the shifts differ by more than a cell.
#[inline(always)]
pub(crate) fn weights<T: Real, const K: usize>(shift: &Lanes<T>) -> Weights<T> {
    let (low, high) = range(shift);
    let below = point::floor(low.f64());
    let base = T::of(below as f64);
    let two = T::of(2.0);
    // Of NaN no comparison holds.
    if !(low >= base && high < base + two) {
        return Weights::NONE;
    }
    let torn = high > base + T::ONE;
    let mut w = Weights { first: below, count: K + usize::from(torn), at: [[T::ZERO; LANES]; 5] };
    if K == 2 {
        for i in 0..LANES {
            let t = shift[i] - base;
            w.at[0][i] = (T::ONE - t).max(T::ZERO);
            w.at[1][i] = T::ONE - (t - T::ONE).abs();
            w.at[2][i] = (t - T::ONE).max(T::ZERO);
        }
        return w;
    }
    w.first -= 1;
    for i in 0..LANES {
        let t = shift[i] - base;
        let upper = if t > T::ONE { T::ONE } else { T::ZERO };
        let own = point::cubic(t - upper);
        let lower = T::ONE - upper;
        w.at[0][i] = lower * own[0];
        for k in 1..4 {
            w.at[k][i] = lower * own[k] + upper * own[k - 1];
        }
        w.at[4][i] = upper * own[3];
    }
    w
}

/// The row of `field` that starts at x index `start`, in the row whose first value has slot `base`.
#[inline(always)]
fn row<'f, T: Real, const D: usize>(
    lattice: &Lattice<D>,
    field: &'f [T],
    base: usize,
    negative: bool,
    start: i64,
    buffer: &'f mut [T; WINDOW],
) -> &'f [T; WINDOW] {
    let last = lattice.last(0);
    if !negative
        && start >= 0
        && start + WINDOW as i64 - 1 <= last
        && let Some(row) = field[base + start as usize..].first_chunk::<WINDOW>()
    {
        return row;
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
    buffer: &mut [T; WINDOW],
) {
    let inner = (-start).clamp(0, WINDOW as i64)..(lattice.last(0) + 1 - start).clamp(0, WINDOW as i64);
    if !inner.is_empty() {
        let from = base + (start + inner.start) as usize;
        let (low, high) = (inner.start as usize, inner.end as usize);
        buffer[low..high].copy_from_slice(&field[from..from + high - low]);
        if negative {
            buffer[low..high].iter_mut().for_each(|v| *v = -*v);
        }
    }
    for i in 0..WINDOW {
        if !inner.contains(&(i as i64)) {
            let (index, flip) = lattice.place(0, start.saturating_add(i as i64));
            let v = field[base + index];
            buffer[i] = if flip != negative { -v } else { v };
        }
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

/// Σ over the points around each value of a stretch; `cell` is the index of its first value.
#[inline(always)]
pub(crate) fn sample<T: Real, const D: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    weights: [&Weights<T>; D],
) -> Lanes<T> {
    match weights[0].count {
        2 => sum::<T, D, 2>(lattice, field, cell, weights),
        3 => sum::<T, D, 3>(lattice, field, cell, weights),
        4 => sum::<T, D, 4>(lattice, field, cell, weights),
        _ => sum::<T, D, 5>(lattice, field, cell, weights),
    }
}

#[inline(always)]
fn sum<T: Real, const D: usize, const P: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    weights: [&Weights<T>; D],
) -> Lanes<T> {
    let start = cell[0] + weights[0].first;
    let mut total = [T::ZERO; LANES];
    let planes = if D == 3 { weights[2].count } else { 1 };
    let mut index = cell;
    for z in 0..planes {
        if D == 3 {
            index[2] = cell[2] + weights[2].first + z as i64;
        }
        let mut plane = [T::ZERO; LANES];
        for y in 0..weights[1].count {
            index[1] = cell[1] + weights[1].first + y as i64;
            let (base, negative) = base_of(lattice, index);
            let mut buffer = [T::ZERO; WINDOW];
            let v = row(lattice, field, base, negative, start, &mut buffer);
            let (wx, wy) = (&weights[0].at, &weights[1].at[y]);
            for i in 0..LANES {
                let mut line = wx[0][i] * v[i];
                for p in 1..P {
                    line += wx[p][i] * v[i + p];
                }
                plane[i] += wy[i] * line;
            }
        }
        if D == 3 {
            let wz = &weights[2].at[z];
            for i in 0..LANES {
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
pub(crate) fn mean<T: Real, const D: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    low: [i64; D],
    pair: [bool; D],
) -> Lanes<T> {
    let mut total = [T::ZERO; LANES];
    let mut share = if pair[0] { 0.5 } else { 1.0 };
    for a in 1..D {
        share *= if pair[a] { 0.5 } else { 1.0 };
    }
    let planes = if D == 3 && pair[2] { 2 } else { 1 };
    let mut index = cell;
    for z in 0..planes {
        if D == 3 {
            index[2] = cell[2] + low[2] + z as i64;
        }
        for y in 0..if pair[1] { 2 } else { 1 } {
            index[1] = cell[1] + low[1] + y as i64;
            let (base, negative) = base_of(lattice, index);
            let mut buffer = [T::ZERO; WINDOW];
            let v = row(lattice, field, base, negative, cell[0] + low[0], &mut buffer);
            if pair[0] {
                for i in 0..LANES {
                    total[i] += v[i] + v[i + 1];
                }
            } else {
                for i in 0..LANES {
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
            let field: Vec<f64> = (0..layout.slots()).map(|s| ((s * 7919) % 101) as f64).collect();
            for x0 in [-1, 0, 3, 17, 38] {
                let cell = [x0, 6, 0];
                let shift: [Lanes<f64>; 3] = std::array::from_fn(|a| {
                    std::array::from_fn(|i| offset + spread * ((i * (a + 3)) % 7) as f64 / 7.0)
                });
                let w = shift.map(|s| weights::<f64, K>(&s));
                let got = sample(&lattice, &field, cell, [&w[0], &w[1], &w[2]]);
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
        assert!(!weights::<f32, 2>(&std::array::from_fn(|i| i as f32)).usable());
        assert!(!weights::<f32, 2>(&[f32::NAN; LANES]).usable());
    }
}
