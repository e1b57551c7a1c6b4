//! Semi-Lagrangian transport of cells and faces.
//!
//! Every value is fetched from the foot of its trajectory: any step is stable. Feet do not cross closed walls; what comes
//! through the others is what the wall lets in, reached linearly from the outermost value. Near solids the cubic is held
//! within the values around the foot.

use cf_grid::{End, FaceField, Layout, Mask, Real, Sides};

use crate::chunk::{LANES, Lanes, Weights, cubic, linear, range};
use crate::fill::Fill;
use crate::lattice::Lattice;
use crate::limit::{beside_walls, hold, near_solids, range_beyond, reverted};
use crate::point;
use crate::trace::{feet, inside};
use crate::wall::FlowWall;

/// How a value is found between others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// First order.
    Linear,
    /// Tensor Lagrange over four points per axis: third order per step.
    Cubic,
    /// Linear, there and back, and half of what does not return is taken off (MacCormack): second order. Near walls and
    /// solids and above CFL 2 it reverts to linear where the result leaves the range of its sources.
    MacCormack,
}

/// Transport by velocities on the faces of one domain.
#[derive(Debug, Clone)]
pub(crate) struct Carry<const D: usize> {
    pub layout: Layout<D>,
    pub faces: [Lattice<D>; D],
    /// Faces within solids are given the values of their neighbours.
    fill: Option<[Fill; D]>,
    /// Cells close to solids, by slot.
    near: Option<Vec<bool>>,
}

impl<const D: usize> Carry<D> {
    pub fn new(layout: &Layout<D>, sides: &Sides<FlowWall<D>, D>, mask: Option<&Mask<D>>) -> Self {
        let faces: [Lattice<D>; D] = std::array::from_fn(|a| Lattice::faces(layout, sides, a));
        let fill = mask.map(|mask| std::array::from_fn(|a| Fill::new(&faces[a], mask)));
        Self { layout: *layout, near: mask.map(|m| near_solids(m, &faces)), fill, faces }
    }

    pub fn bytes(&self) -> usize {
        self.near.as_ref().map_or(0, Vec::len) + self.fill.iter().flatten().map(Fill::bytes).sum::<usize>()
    }

    /// Continues a velocity into solids, a few cells deep, so that what is next to them can be interpolated.
    pub fn fill_solids<T: Real>(&self, u: &mut FaceField<T, D>) {
        if let Some(fill) = &self.fill {
            for a in 0..D {
                fill[a].apply(u.axis_mut(a));
            }
        }
    }

    /// `out` = `from` carried by `by` over dt = `ratio` h. Solids must be filled.
    pub fn carry<T: Real, const K: usize>(
        &self,
        lattice: &Lattice<D>,
        by: &FaceField<T, D>,
        ratio: f64,
        from: &[T],
        out: &mut [T],
    ) {
        let u = by.axes();
        let near = self.near.as_deref();
        self.stretches(
            lattice,
            out,
            #[inline(always)]
            |cell, len, row| {
                let free = feet(lattice, &self.faces, &u, ratio, cell, len);
                let mut shift = free;
                inside(lattice, cell, len, &mut shift);
                let mut value = fetch::<T, D, K>(lattice, from, cell, &shift);
                if K == 4
                    && let Some(near) = near
                {
                    hold::<T, D, K>(lattice, near, from, cell, len, &shift, &mut value);
                }
                let_in(lattice, cell, len, &free, &mut value);
                row.copy_from_slice(&value[..len]);
            },
        );
    }

    /// `out` = `from` carried by `by`; `back` is scratch for MacCormack.
    #[allow(clippy::too_many_arguments)]
    pub fn carry_as<T: Real>(
        &self,
        how: Interpolation,
        lattice: &Lattice<D>,
        by: &FaceField<T, D>,
        ratio: f64,
        from: &[T],
        out: &mut [T],
        back: &mut [T],
    ) {
        match how {
            Interpolation::Linear => self.carry::<T, 2>(lattice, by, ratio, from, out),
            Interpolation::Cubic => self.carry::<T, 4>(lattice, by, ratio, from, out),
            Interpolation::MacCormack => {
                self.carry::<T, 2>(lattice, by, ratio, from, out);
                self.carry::<T, 2>(lattice, by, -ratio, out, back);
                self.correct(lattice, by, ratio, from, back, out);
            }
        }
    }

    /// The MacCormack value from `there` (the field carried forward) and `back` (that carried backward), into `there`.
    pub fn correct<T: Real>(
        &self,
        lattice: &Lattice<D>,
        by: &FaceField<T, D>,
        ratio: f64,
        from: &[T],
        back: &[T],
        there: &mut [T],
    ) {
        let u = by.axes();
        let near = self.near.as_deref();
        let half = T::of(0.5);
        self.stretches(
            lattice,
            there,
            #[inline(always)]
            |cell, len, row| {
                let slot = slot_of(lattice, cell);
                let (from_row, back) = (&from[slot..slot + len], &back[slot..slot + len]);
                let shift = feet(lattice, &self.faces, &u, ratio, cell, len);
                let limited = range_beyond(&shift, 2.0) || beside_walls(lattice, cell, len);
                for i in 0..len {
                    let value = row[i] + half * (from_row[i] - back[i]);
                    if limited || near.is_some_and(|near| near[slot + i]) {
                        let mut own = cell;
                        own[0] += i as i64;
                        let mut foot = [T::ZERO; D];
                        for a in 0..D {
                            foot[a] = shift[a][i];
                        }
                        row[i] = reverted(lattice, from, own, foot, value, row[i]);
                    } else {
                        row[i] = value;
                    }
                }
            },
        );
    }

    /// Calls `body(first index, length, out)` for stretches of at most [`LANES`] values. In 3D by strips of y, so that the
    /// rows around a value are still in the cache when the next plane needs them.
    fn stretches<T: Real>(&self, lattice: &Lattice<D>, out: &mut [T], body: impl Fn([i64; D], usize, &mut [T]) + Sync) {
        let rows = lattice.region.high[1];
        let strip = if D == 3 { STRIP } else { rows };
        for low in (0..rows).step_by(strip) {
            let mut region = lattice.region;
            region.low[1] = low;
            region.high[1] = (low + strip).min(rows);
            self.layout.par_runs(
                region,
                &mut *out,
                #[inline(always)]
                |run, row: &mut [T]| {
                    let mut done = 0;
                    while done < row.len() {
                        let len = LANES.min(row.len() - done);
                        let mut cell = [0; D];
                        for a in 0..D {
                            cell[a] = run.cell[a] as i64;
                        }
                        cell[0] += done as i64;
                        body(cell, len, &mut row[done..done + len]);
                        done += len;
                    }
                },
            );
        }
    }
}

/// Rows of a strip.
const STRIP: usize = 16;

#[inline(always)]
pub(crate) fn slot_of<const D: usize>(lattice: &Lattice<D>, cell: [i64; D]) -> usize {
    let mut place = [0; D];
    for a in 0..D {
        place[a] = cell[a] as usize;
    }
    lattice.layout.slot(place)
}

/// The values at `shift` from each of a stretch.
#[inline(always)]
fn fetch<T: Real, const D: usize, const K: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    shift: &[Lanes<T>; D],
) -> Lanes<T> {
    if K == 2 {
        let mut w = [Weights::<T, 3>::NONE; D];
        if let Some(chosen) = usable(&mut w, shift) {
            return linear(lattice, field, cell, chosen);
        }
    } else {
        let mut w = [Weights::<T, 5>::NONE; D];
        if let Some(chosen) = usable(&mut w, shift) {
            return cubic(lattice, field, cell, chosen);
        }
    }
    fetch_points::<T, D, K>(lattice, field, cell, shift)
}

#[inline(always)]
fn usable<'w, T: Real, const D: usize, const W: usize>(
    w: &'w mut [Weights<T, W>; D],
    shift: &[Lanes<T>; D],
) -> Option<[&'w Weights<T, W>; D]> {
    let mut all = true;
    for a in 0..D {
        w[a].set(&shift[a], range(&shift[a]), T::ZERO);
        all &= w[a].usable();
    }
    let mut chosen = [&w[0]; D];
    for a in 1..D {
        chosen[a] = &w[a];
    }
    all.then_some(chosen)
}

#[inline(never)]
fn fetch_points<T: Real, const D: usize, const K: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    shift: &[Lanes<T>; D],
) -> Lanes<T> {
    std::array::from_fn(|i| {
        let mut own = cell;
        own[0] += i as i64;
        point::sample::<T, D, K>(lattice, field, own, std::array::from_fn(|a| shift[a][i])).0
    })
}

/// Blends in what walls let in where a foot lies beyond the outermost values.
#[inline(always)]
fn let_in<T: Real, const D: usize>(
    lattice: &Lattice<D>,
    cell: [i64; D],
    len: usize,
    shift: &[Lanes<T>; D],
    value: &mut Lanes<T>,
) {
    for a in 0..D {
        if !lattice.walled(a) {
            continue;
        }
        let [least, most] = range(&shift[a]);
        let along = if a == 0 { (len - 1) as f64 } else { 0.0 };
        let last = lattice.last(a) as f64;
        if cell[a] as f64 + least.f64() < 0.0 || cell[a] as f64 + along + most.f64() > last {
            let_in_axis(lattice, a, cell, len, &shift[a], value);
        }
    }
}

#[inline(never)]
fn let_in_axis<T: Real, const D: usize>(
    lattice: &Lattice<D>,
    a: usize,
    cell: [i64; D],
    len: usize,
    shift: &Lanes<T>,
    value: &mut Lanes<T>,
) {
    for i in 0..len {
        let own = cell[a] as f64 + if a == 0 { i as f64 } else { 0.0 };
        let x = own + shift[i].f64();
        for (end, excess) in [(End::Low, -x), (End::High, x - lattice.last(a) as f64)] {
            let Some((carried, reach)) = lattice.inflow.wall(a, end).flatten() else { continue };
            if excess > 0.0 {
                let share = if excess >= reach { T::ONE } else { T::of(excess / reach) };
                value[i] = value[i] + share * (T::of(carried) - value[i]);
            }
        }
    }
}
