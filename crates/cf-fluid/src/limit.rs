//! Where interpolation is held back: near walls and solids, and where a step is long.

use std::ops::Range;

use cf_grid::{Mask, Real};

use crate::carry::slot_of;
use crate::chunk::{Lanes, range};
use crate::lattice::Lattice;
use crate::point;

/// Cells between a wall or solid and where it is not felt.
const REACH: usize = 3;

/// Clamps the values near solids to those around their feet.
#[inline(never)]
pub(crate) fn hold<T: Real, const D: usize, const L: usize>(
    lattice: &Lattice<D>,
    near: &[bool],
    field: &[T],
    cell: [i64; D],
    len: usize,
    shift: &[Lanes<T, L>; D],
    value: &mut Lanes<T, L>,
) {
    let slot = slot_of(lattice, cell);
    for i in (0..len).filter(|i| near[slot + i]) {
        let mut own = cell;
        own[0] += i as i64;
        let (_, low, high) = point::sample::<T, D, 2>(lattice, field, own, std::array::from_fn(|a| shift[a][i]));
        value[i] = value[i].max(low).min(high);
    }
}

/// `value`, or `plain` where it leaves the range of the values around the foot.
#[inline(never)]
pub(crate) fn reverted<T: Real, const D: usize>(
    lattice: &Lattice<D>,
    from: &[T],
    own: [i64; D],
    mut foot: [T; D],
    value: T,
    plain: T,
) -> T {
    for a in (0..D).filter(|&a| lattice.walled(a)) {
        let low = -(own[a] as f64) - lattice.half(a);
        let high = low + lattice.layout.cells()[a] as f64;
        // What enters through a wall has no source inside.
        if !(low..=high).contains(&foot[a].f64()) {
            return plain;
        }
        foot[a] = foot[a].max(T::of(low)).min(T::of(high));
    }
    let (_, low, high) = point::sample::<T, D, 2>(lattice, from, own, foot);
    if value >= low && value <= high { value } else { plain }
}

#[inline(always)]
pub(crate) fn range_beyond<T: Real, const D: usize>(shift: &[Lanes<T>; D], most: f64) -> bool {
    let mut largest = T::ZERO;
    for a in 0..D {
        let [low, high] = range(&shift[a]);
        largest = largest.max(low.abs()).max(high.abs());
    }
    // Also where a displacement is not a number.
    largest.f64() > most || !largest.is_finite()
}

/// The values of a stretch that are not close to a wall.
#[inline(always)]
pub(crate) fn away_from_walls<const D: usize>(lattice: &Lattice<D>, cell: [i64; D], len: usize) -> Range<usize> {
    let reach = REACH as i64;
    let mut free = 0..len;
    for a in 0..D {
        if !lattice.walled(a) {
            continue;
        }
        let (first, end) = (reach - cell[a], lattice.last(a) - reach + 1 - cell[a]);
        if a == 0 {
            free = first.clamp(0, len as i64) as usize..end.clamp(0, len as i64) as usize;
        } else if first > 0 || end <= 0 {
            return 0..0;
        }
    }
    free
}

/// Flags of cells with a solid within [`REACH`] cells along every axis.
pub(crate) fn near_solids<const D: usize>(mask: &Mask<D>, faces: &[Lattice<D>; D]) -> Vec<bool> {
    let layout = mask.layout();
    let mut near = vec![false; layout.slots()];
    layout.each_cell(layout.cells_region(), |at| near[at.slot()] = !mask.fluid()[at.slot()]);
    for a in 0..D {
        let from = near.clone();
        let n = layout.cells()[a];
        // Faces on high walls have a slot of their own.
        let mut region = layout.cells_region();
        region.high[a] += 1;
        layout.par_region(region, &mut near, |at| {
            let reach = REACH as i64;
            (-reach..=reach).any(|by| {
                let mut cell = at.cell;
                cell[a] = faces[(a + 1) % D].place(a, (at.cell[a].min(n - 1)) as i64 + by).0;
                from[layout.slot(cell)]
            })
        });
    }
    near
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wall::FlowWall;
    use cf_grid::{Axis, Layout, Sides};

    #[test]
    fn only_values_close_to_walls_are_held_back() {
        let layout = Layout::new([100, 20]).unwrap();
        let mut sides = Sides::all(FlowWall::Closed);
        let free = |sides: &Sides<FlowWall<2>, 2>, cell, len| {
            away_from_walls(&Lattice::cells(&layout, sides, |_, _| 0.0), cell, len)
        };
        assert_eq!((free(&sides, [0, 10], 64), free(&sides, [64, 10], 36)), (3..64, 0..33));
        assert_eq!((free(&sides, [0, 3], 64), free(&sides, [0, 16], 64)), (3..64, 3..64));
        assert!(free(&sides, [10, 2], 64).is_empty() && free(&sides, [10, 17], 64).is_empty());
        sides.0[0] = Axis::Periodic;
        assert_eq!(free(&sides, [0, 10], 64), 0..64);
    }
}
