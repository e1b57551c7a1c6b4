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

/// One number per value of a stretch.
pub(crate) type Lanes<T> = [T; LANES];

/// Points and weights of a stretch along one axis, at most `W` of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights<T, const W: usize> {
    /// Index of the first point relative to each value's own index.
    first: i64,
    /// Points with any weight: `W` or one less; none where the shifts differ by too much.
    count: usize,
    at: [Lanes<T>; W],
}

/// Smallest and largest of a stretch.
#[inline(always)]
pub(crate) fn range<T: Real>(x: &Lanes<T>) -> [T; 2] {
    let (mut low, mut high) = (*x, *x);
    let mut width = LANES / 2;
    while width > 0 {
        for i in 0..width {
            low[i] = low[i].min(low[i + width]);
            high[i] = high[i].max(high[i + width]);
        }
        width /= 2;
    }
    [low[0], high[0]]
}

impl<T: Real, const W: usize> Weights<T, W> {
    /// No points.
    pub const NONE: Self = Self { first: 0, count: 0, at: [[T::ZERO; LANES]; W] };

    /// False where the shifts differ by too much.
    #[inline(always)]
    pub fn usable(&self) -> bool {
        self.count > 0
    }

    /// Weights of the points around `shift + by` \[cells\] from each value, linear for `W` = 3, cubic Lagrange for `W` = 5;
    /// `bounds` is the range of `shift`. Not usable where the shifts differ by more than a cell.
    #[inline(always)]
    pub fn set(&mut self, shift: &Lanes<T>, bounds: [T; 2], by: T) {
        let [low, high] = bounds.map(
            #[inline(always)]
            |x| x + by,
        );
        let below = point::floor(low.f64());
        let base = T::of(below as f64);
        // Of NaN no comparison holds.
        if !(low >= base && high < base + T::of(2.0)) {
            self.count = 0;
            return;
        }
        let torn = high > base + T::ONE;
        let offset = by - base;
        self.count = W - usize::from(!torn);
        self.first = below;
        if W == 3 {
            for i in 0..LANES {
                let t = shift[i] + offset;
                self.at[0][i] = (T::ONE - t).max(T::ZERO);
                self.at[1][i] = T::ONE - (t - T::ONE).abs();
                self.at[2][i] = (t - T::ONE).max(T::ZERO);
            }
            return;
        }
        self.first -= 1;
        for i in 0..LANES {
            let t = shift[i] + offset;
            let upper = if t > T::ONE { T::ONE } else { T::ZERO };
            let own = point::cubic(t - upper);
            let lower = T::ONE - upper;
            self.at[0][i] = lower * own[0];
            for k in 1..4 {
                self.at[k][i] = lower * own[k] + upper * own[k - 1];
            }
            self.at[W - 1][i] = upper * own[3];
        }
    }
}

/// The `M` values of `field` from x index `start` on, in the row whose first value has slot `base`.
#[inline(always)]
fn row<'f, T: Real, const D: usize, const M: usize>(
    lattice: &Lattice<D>,
    field: &'f [T],
    base: usize,
    negative: bool,
    start: i64,
    buffer: &'f mut [T; M],
) -> &'f [T; M] {
    if !negative
        && start >= 0
        && start + M as i64 - 1 <= lattice.last(0)
        && let Some(row) = field[base + start as usize..].first_chunk::<M>()
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

/// Σ over the points around each value of a stretch, linear; `cell` is the index of its first value.
#[inline(always)]
pub(crate) fn linear<T: Real, const D: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    weights: [&Weights<T, 3>; D],
) -> Lanes<T> {
    if weights[0].count == 2 {
        sum::<T, D, 3, 2, { LANES + 1 }>(lattice, field, cell, weights)
    } else {
        sum::<T, D, 3, 3, { LANES + 2 }>(lattice, field, cell, weights)
    }
}

/// The same, cubic.
#[inline(always)]
pub(crate) fn cubic<T: Real, const D: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    weights: [&Weights<T, 5>; D],
) -> Lanes<T> {
    if weights[0].count == 4 {
        sum::<T, D, 5, 4, { LANES + 3 }>(lattice, field, cell, weights)
    } else {
        sum::<T, D, 5, 5, { LANES + 4 }>(lattice, field, cell, weights)
    }
}

#[inline(always)]
fn sum<T: Real, const D: usize, const W: usize, const P: usize, const M: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    weights: [&Weights<T, W>; D],
) -> Lanes<T> {
    let start = cell[0] + weights[0].first;
    let wx = &weights[0].at;
    let mut buffer = [T::ZERO; M];
    let mut total = [T::ZERO; LANES];
    let planes = if D == 3 { weights[D - 1].count } else { 1 };
    let mut index = cell;
    for z in 0..planes {
        if D == 3 {
            index[D - 1] = cell[D - 1] + weights[D - 1].first + z as i64;
        }
        let mut plane = [T::ZERO; LANES];
        for y in 0..weights[1].count {
            index[1] = cell[1] + weights[1].first + y as i64;
            let (base, negative) = base_of(lattice, index);
            let v = row(lattice, field, base, negative, start, &mut buffer);
            let wy = &weights[1].at[y];
            for i in 0..LANES {
                let mut line = wx[0][i] * v[i];
                for p in 1..P {
                    line += wx[p][i] * v[i + p];
                }
                plane[i] += wy[i] * line;
            }
        }
        if D == 3 {
            let wz = &weights[D - 1].at[z];
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
    let mut buffer = [T::ZERO; LANES + 1];
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

    fn check<const W: usize, const K: usize>(spread: f64, offset: f64) {
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
                let w = shift.map(|s| {
                    let mut w = Weights::<f64, W>::NONE;
                    w.set(&s, range(&s), 0.0);
                    assert!(w.usable());
                    w
                });
                let got = match W {
                    3 => sum::<f64, 3, W, 3, { LANES + 2 }>(&lattice, &field, cell, [&w[0], &w[1], &w[2]]),
                    _ => sum::<f64, 3, W, 5, { LANES + 4 }>(&lattice, &field, cell, [&w[0], &w[1], &w[2]]),
                };
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
                check::<3, 2>(spread, offset);
                check::<5, 4>(spread, offset);
            }
        }
        for torn in [std::array::from_fn(|i| i as f32), [f32::NAN; LANES]] {
            let mut w = Weights::<f32, 3>::NONE;
            w.set(&torn, range(&torn), 0.0);
            assert!(!w.usable());
        }
    }
}
