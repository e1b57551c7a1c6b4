//! Semi-Lagrangian transport of cells and faces.
//!
//! Every value is fetched from the foot of its trajectory: any step is stable. Feet do not cross closed walls; what comes
//! through the others is what the wall lets in, reached linearly from the outermost value. Near solids the cubic is held
//! within the values around the foot.

use cf_grid::{End, FaceField, Layout, Mask, Max, Real, Reduce, Sides, Slabs, join, vectorised};

use crate::calculus::largest;
use crate::chunk::{Along, FEW, LANES, Lanes, cubic, few, linear, ranges};
use crate::fill::Fill;
use crate::lattice::Lattice;
use crate::limit::{away_from_walls, hold, near_solids, range_beyond, reverted};
use crate::paths::{Ring, STRIP, TILE, Tile, Tracing};
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

/// Cells of a step beyond which MacCormack's correction may have to be taken back.
const FAR: f64 = 2.0;

/// Transport by velocities on the faces of one domain.
#[derive(Debug, Clone)]
pub(crate) struct Carry<const D: usize> {
    pub layout: Layout<D>,
    pub cells: Lattice<D>,
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
        let cells = Lattice::cells(layout, sides, |_, _| 0.0);
        Self { layout: *layout, cells, near: mask.map(|m| near_solids(m, &faces)), fill, faces }
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

    /// Prepares a velocity as what carries and is carried: continues its rows beyond their ends.
    pub fn continue_faces<T: Real>(&self, u: &mut FaceField<T, D>) {
        for a in 0..D {
            self.faces[a].continue_rows(u.axis_mut(a));
        }
    }

    /// Whether displacements along `axis` change sign at `index`: behind a closed wall.
    #[inline(always)]
    pub fn turns(&self, axis: usize, index: i64) -> bool {
        let n = self.layout.cells()[axis] as i64;
        let beyond = if index >= n { n + 1 } else { index };
        self.cells.walled(axis) && !(0..n).contains(&index) && self.faces[axis].place(axis, beyond).1
    }

    /// `out` = `from` carried by `by` over dt = `ratio` h, all lattices in one sweep. Solids must be filled, rows continued.
    pub fn carry<T: Real, const K: usize, const N: usize>(
        &self,
        lattices: [&Lattice<D>; N],
        by: &FaceField<T, D>,
        ratio: f64,
        from: [&[T]; N],
        out: [&mut [T]; N],
    ) {
        let planes = lattices.iter().map(|l| l.region.high[D - 1]).max().unwrap_or(0);
        let load = Load::<T, D, K, N> { carry: self, lattices, u: by.axes(), ratio, from };
        load.halve(0, planes, out, 0);
    }

    /// `out` = `from` carried by `by`; `back` is scratch for MacCormack.
    #[allow(clippy::too_many_arguments)]
    pub fn carry_as<T: Real, const N: usize>(
        &self,
        how: Interpolation,
        lattices: [&Lattice<D>; N],
        by: &FaceField<T, D>,
        ratio: f64,
        from: [&[T]; N],
        mut out: [&mut [T]; N],
        back: &mut [T],
    ) {
        match how {
            Interpolation::Linear => self.carry::<T, 2, N>(lattices, by, ratio, from, out),
            Interpolation::Cubic => self.carry::<T, 4, N>(lattices, by, ratio, from, out),
            Interpolation::MacCormack => {
                self.carry::<T, 2, N>(lattices, by, ratio, from, out.each_mut().map(|o| &mut **o));
                for l in 0..N {
                    let (lattice, out) = (lattices[l], &mut *out[l]);
                    lattice.continue_rows(out);
                    self.carry::<T, 2, 1>([lattice], by, -ratio, [out], [&mut *back]);
                    self.correct(lattice, by, ratio, from[l], back, out);
                }
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
        // What is not a number may be anywhere.
        let short = self.fastest(by) * ratio.abs() <= FAR;
        self.stretches(
            lattice,
            there,
            #[inline(always)]
            |cell, len, row| {
                let slot = slot_of(lattice, cell);
                let (from_row, back) = (&from[slot..slot + len], &back[slot..slot + len]);
                let near = near.map(|near| &near[slot..slot + len]).filter(|near| near.contains(&true));
                let free = away_from_walls(lattice, cell, len);
                if short && free.len() == len && near.is_none() {
                    for i in 0..len {
                        row[i] += half * (from_row[i] - back[i]);
                    }
                    return;
                }
                let shift: [Lanes<T>; D] = feet(lattice, &self.faces, &u, ratio, cell, len);
                let long = range_beyond(&shift, FAR);
                for i in 0..len {
                    let value = row[i] + half * (from_row[i] - back[i]);
                    if long || !free.contains(&i) || near.is_some_and(|near| near[i]) {
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

    /// max|u_a| over all faces \[m/s\]; NaN if any is not a number.
    fn fastest<T: Real>(&self, u: &FaceField<T, D>) -> f64 {
        let axes = (0..D).map(|a| largest(&self.layout, self.faces[a].region, u.axis(a)));
        axes.fold(Max(0.0), Max::merge).0
    }

    /// Calls `body(first index, length, out)` for stretches of at most [`LANES`] values.
    fn stretches<T: Real>(&self, lattice: &Lattice<D>, out: &mut [T], body: impl Fn([i64; D], usize, &mut [T]) + Sync) {
        self.layout.par_runs(
            lattice.region,
            out,
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

/// What is carried, and by what.
struct Load<'a, T, const D: usize, const K: usize, const N: usize> {
    carry: &'a Carry<D>,
    lattices: [&'a Lattice<D>; N],
    u: [&'a [T]; D],
    ratio: f64,
    from: [&'a [T]; N],
}

/// Lattice `l` in row `j` of plane `k` of a tile.
#[derive(Clone, Copy)]
struct Line {
    l: usize,
    tile: Tile,
    j: usize,
    k: usize,
}

/// Planes of a slab, which is done serially; the plane before it is traced again.
const SLAB: usize = 16;

impl<T: Real, const D: usize, const K: usize, const N: usize> Load<'_, T, D, K, N> {
    /// Planes `low..high`, in parallel; `out` begins at slot `base`.
    fn halve(&self, low: usize, high: usize, out: [&mut [T]; N], base: usize) {
        if high - low <= SLAB {
            let mut ring = Ring::new();
            vectorised(
                #[inline(always)]
                || self.slab(low, high, out, base, &mut ring),
            );
            return;
        }
        let middle = low + (high - low) / 2;
        let cut = (middle + 1) * self.carry.layout.stride(D - 1);
        let (first, second) = out.split_at(cut - base);
        join(|| self.halve(low, middle, first, base), || self.halve(middle, high, second, cut));
    }

    #[inline(always)]
    fn slab(&self, low: usize, high: usize, out: [&mut [T]; N], base: usize, ring: &mut Ring<T, D>) {
        let cells = self.carry.layout.cells();
        let rows = if D == 3 { self.lattices.iter().map(|l| l.region.high[1]).max().unwrap_or(0) } else { 1 };
        for j in (0..rows).step_by(STRIP) {
            for x in (0..cells[0]).step_by(TILE) {
                let tile = Tile { x, width: TILE.min(cells[0] - x), j, rows: STRIP.min(rows - j) };
                let by = Tracing { carry: self.carry, u: self.u, ratio: self.ratio, tile };
                ring.trace(&by, low as i64 - 1);
                for k in low..high {
                    ring.trace(&by, k as i64);
                    for j in j..j + tile.rows {
                        for l in 0..N {
                            self.row(Line { l, tile, j, k }, ring, out[l], base);
                        }
                    }
                }
            }
        }
    }

    /// What is carried in one row of a tile.
    #[inline(always)]
    fn row(&self, line: Line, ring: &Ring<T, D>, out: &mut [T], base: usize) {
        let Line { l, tile, j, k } = line;
        let region = self.lattices[l].region;
        if k >= region.high[D - 1] || (D == 3 && j >= region.high[1]) {
            return;
        }
        // The face on the high wall belongs to the last tile.
        let last = tile.x + tile.width == self.carry.layout.cells()[0];
        let end = if last { region.high[0] } else { tile.x + tile.width };
        let mut x = tile.x;
        while end - x >= LANES {
            self.stretch::<LANES>(line, ring, x, LANES, out, base);
            x += LANES;
        }
        if x < end {
            self.rest(line, ring, x, end, out, base);
        }
    }

    /// The end of a row, from `x` up to `end`.
    #[inline(never)]
    fn rest(&self, line: Line, ring: &Ring<T, D>, x: usize, end: usize, out: &mut [T], base: usize) {
        vectorised(
            #[inline(always)]
            || {
                for (x, len) in few(line.tile.x, x, end) {
                    self.stretch::<FEW>(line, ring, x, len, out, base);
                }
            },
        );
    }

    /// `len` values, at most `L`, from column `x` on.
    #[inline(always)]
    fn stretch<const L: usize>(
        &self,
        Line { l, tile, j, k }: Line,
        ring: &Ring<T, D>,
        x: usize,
        len: usize,
        out: &mut [T],
        base: usize,
    ) {
        let (lattice, from) = (self.lattices[l], self.from[l]);
        let mut cell = [x as i64; D];
        if D == 3 {
            cell[1] = j as i64;
        }
        cell[D - 1] = k as i64;
        let free = ring.of::<L>(lattice.normal, tile, x, j, k as i64, len);
        let reach = ranges(&free);
        let (mut shift, mut bounds) = (free, reach);
        inside(lattice, cell, len, &mut shift, &mut bounds);
        let mut value = fetch::<T, D, K, L>(lattice, from, cell, len, &shift, &bounds);
        if K == 4
            && let Some(near) = &self.carry.near
        {
            hold::<T, D, L>(lattice, near, from, cell, len, &shift, &mut value);
        }
        let_in(lattice, cell, len, &free, &reach, &mut value);
        let at = slot_of(lattice, cell) - base;
        out[at..at + len].copy_from_slice(&value[..len]);
    }
}

#[inline(always)]
pub(crate) fn slot_of<const D: usize>(lattice: &Lattice<D>, cell: [i64; D]) -> usize {
    let mut place = [0; D];
    for a in 0..D {
        place[a] = cell[a] as usize;
    }
    lattice.layout.slot(place)
}

/// The values at `shift`, which is within `bounds`, from each of a stretch.
#[inline(always)]
fn fetch<T: Real, const D: usize, const K: usize, const L: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    len: usize,
    shift: &[Lanes<T, L>; D],
    bounds: &[[T; 2]; D],
) -> Lanes<T, L> {
    together::<T, D, K, L>(lattice, field, cell, shift, bounds)
        .unwrap_or_else(|| fetch_parts::<T, D, K, L>(lattice, field, cell, len, shift))
}

/// The same for `L` values; `None` where they are torn too far apart.
#[inline(always)]
fn together<T: Real, const D: usize, const K: usize, const L: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    shift: &[Lanes<T, L>; D],
    bounds: &[[T; 2]; D],
) -> Option<Lanes<T, L>> {
    let mut along = [Along::NONE; D];
    let mut usable = true;
    for a in 0..D {
        usable &= along[a].set(&shift[a], bounds[a], T::ZERO);
    }
    if !usable {
        return None;
    }
    let mut chosen = [&along[0]; D];
    for a in 1..D {
        chosen[a] = &along[a];
    }
    Some(if K == 2 { linear(lattice, field, cell, chosen) } else { cubic(lattice, field, cell, chosen) })
}

/// A stretch that is torn too far apart, in shorter ones or point by point.
#[inline(never)]
fn fetch_parts<T: Real, const D: usize, const K: usize, const L: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    len: usize,
    shift: &[Lanes<T, L>; D],
) -> Lanes<T, L> {
    let mut value = [T::ZERO; L];
    vectorised(
        #[inline(always)]
        || {
            for begin in (0..len).step_by(FEW) {
                let mut own = cell;
                own[0] += begin as i64;
                let mut few = [[T::ZERO; FEW]; D];
                for a in 0..D {
                    few[a].copy_from_slice(&shift[a][begin..begin + FEW]);
                }
                let part = together::<T, D, K, FEW>(lattice, field, own, &few, &ranges(&few));
                let part = match part {
                    Some(part) => part,
                    None => fetch_points::<T, D, K>(lattice, field, own, &few),
                };
                value[begin..begin + FEW].copy_from_slice(&part);
            }
        },
    );
    value
}

#[inline(never)]
fn fetch_points<T: Real, const D: usize, const K: usize>(
    lattice: &Lattice<D>,
    field: &[T],
    cell: [i64; D],
    shift: &[Lanes<T, FEW>; D],
) -> Lanes<T, FEW> {
    std::array::from_fn(|i| {
        let mut own = cell;
        own[0] += i as i64;
        point::sample::<T, D, K>(lattice, field, own, std::array::from_fn(|a| shift[a][i])).0
    })
}

/// Blends in what walls let in where a foot lies beyond the outermost values.
#[inline(always)]
fn let_in<T: Real, const D: usize, const L: usize>(
    lattice: &Lattice<D>,
    cell: [i64; D],
    len: usize,
    shift: &[Lanes<T, L>; D],
    bounds: &[[T; 2]; D],
    value: &mut Lanes<T, L>,
) {
    for a in 0..D {
        if !lattice.walled(a) {
            continue;
        }
        let [least, most] = bounds[a];
        let along = if a == 0 { (len - 1) as f64 } else { 0.0 };
        let last = lattice.last(a) as f64;
        if cell[a] as f64 + least.f64() < 0.0 || cell[a] as f64 + along + most.f64() > last {
            let_in_axis(lattice, a, cell, len, &shift[a], value);
        }
    }
}

#[inline(never)]
fn let_in_axis<T: Real, const D: usize, const L: usize>(
    lattice: &Lattice<D>,
    a: usize,
    cell: [i64; D],
    len: usize,
    shift: &Lanes<T, L>,
    value: &mut Lanes<T, L>,
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
