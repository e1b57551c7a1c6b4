//! Where the fluid at a stretch of values came from: the midpoint rule backwards in time.

use cf_grid::{Real, vectorised};

use crate::chunk::{Along, FEW, Lanes, linear, mean, range, ranges};
use crate::lattice::Lattice;
use crate::point;

/// Displacements of a stretch from its values to their feet \[cells\]: x_m = x - (dt/2) u(x), foot = x - dt u(x_m), u
/// linear between its faces. `ratio` = dt/h \[s/m\], `cell` the first index, `len` the values that count.
#[inline(always)]
pub(crate) fn feet<T: Real, const D: usize, const L: usize>(
    at: &Lattice<D>,
    faces: &[Lattice<D>; D],
    u: &[&[T]; D],
    ratio: f64,
    cell: [i64; D],
    len: usize,
) -> [Lanes<T, L>; D] {
    let mut shift = [[T::ZERO; L]; D];
    if !together(at, faces, u, ratio, cell, len, &mut shift) {
        in_parts(at, faces, u, ratio, cell, len, &mut shift);
    }
    shift
}

/// A stretch that is torn too far apart, in shorter ones.
#[inline(never)]
fn in_parts<T: Real, const D: usize, const L: usize>(
    at: &Lattice<D>,
    faces: &[Lattice<D>; D],
    u: &[&[T]; D],
    ratio: f64,
    cell: [i64; D],
    len: usize,
    shift: &mut [Lanes<T, L>; D],
) {
    vectorised(
        #[inline(always)]
        || {
            for begin in (0..len).step_by(FEW) {
                let mut own = cell;
                own[0] += begin as i64;
                let mut few = [[T::ZERO; FEW]; D];
                together(at, faces, u, ratio, own, FEW.min(len - begin), &mut few);
                for a in 0..D {
                    shift[a][begin..begin + FEW].copy_from_slice(&few[a]);
                }
            }
        },
    );
    repeat_last(len, shift);
}

/// The same for `L` values. False, and nothing done, where more than [`FEW`] are torn too far apart.
#[inline(always)]
fn together<T: Real, const D: usize, const L: usize>(
    at: &Lattice<D>,
    faces: &[Lattice<D>; D],
    u: &[&[T]; D],
    ratio: f64,
    cell: [i64; D],
    len: usize,
    velocity: &mut [Lanes<T, L>; D],
) -> bool {
    let half = T::of(-0.5 * ratio);
    let mut middle = [[T::ZERO; L]; D];
    for a in 0..D {
        // Neighbours of a value among the faces of axis a: half a cell to either side, or the same place.
        let (mut low, mut pair) = ([0; D], [false; D]);
        for b in 0..D {
            let offset = at.half(b) - faces[a].half(b);
            pair[b] = offset != 0.0;
            low[b] = if offset < 0.0 { -1 } else { 0 };
        }
        let here: Lanes<T, L> = mean(&faces[a], u[a], cell, low, pair);
        for i in 0..L {
            middle[a][i] = half * here[i];
        }
    }
    repeat_last(len, &mut middle);
    let mut bounds = ranges(&middle);
    inside(at, cell, len, &mut middle, &mut bounds);
    // Seen from a value, faces of axis b are offset along b differently than all others.
    let mut both = [[Along::NONE; 2]; D];
    let mut usable = true;
    for b in 0..D {
        for k in 0..2 {
            usable &= both[b][k].set(&middle[b], bounds[b], T::of(at.half(b) - if k == 0 { 0.5 } else { 0.0 }));
        }
    }
    if !usable && L > FEW {
        return false;
    }
    for a in 0..D {
        if usable {
            let mut chosen = [&both[0][0]; D];
            for b in 0..D {
                chosen[b] = &both[b][usize::from(a == b)];
            }
            velocity[a] = linear(&faces[a], u[a], cell, chosen);
        } else {
            velocity[a] = by_points(at, &faces[a], u[a], cell, &middle);
        }
    }
    let full = T::of(-ratio);
    for a in 0..D {
        for i in 0..L {
            velocity[a][i] = full * velocity[a][i];
        }
    }
    repeat_last(len, velocity);
    true
}

#[inline(never)]
fn by_points<T: Real, const D: usize, const L: usize>(
    at: &Lattice<D>,
    faces: &Lattice<D>,
    u: &[T],
    cell: [i64; D],
    shift: &[Lanes<T, L>; D],
) -> Lanes<T, L> {
    std::array::from_fn(|i| {
        let mut own = cell;
        own[0] += i as i64;
        let shift = std::array::from_fn(|b| shift[b][i] + T::of(at.half(b) - faces.half(b)));
        point::sample::<T, D, 2>(faces, u, own, shift).0
    })
}

/// Keeps displaced points of `at` within the box along walled axes; `bounds` are the ranges of `shift`, and stay so.
#[inline(always)]
pub(crate) fn inside<T: Real, const D: usize, const L: usize>(
    at: &Lattice<D>,
    cell: [i64; D],
    len: usize,
    shift: &mut [Lanes<T, L>; D],
    bounds: &mut [[T; 2]; D],
) {
    for a in 0..D {
        if !at.walled(a) {
            continue;
        }
        // Room from the first value to the low wall and to the high wall.
        let low = -(cell[a] as f64) - at.half(a);
        let high = at.layout.cells()[a] as f64 - at.half(a) - cell[a] as f64;
        let along = if a == 0 { (len - 1) as f64 } else { 0.0 };
        let [least, most] = bounds[a];
        if least.f64() >= low && most.f64() + along <= high {
            continue;
        }
        for i in 0..len {
            let own = if a == 0 { i as f64 } else { 0.0 };
            shift[a][i] = shift[a][i].max(T::of(low - own)).min(T::of(high - own));
        }
        let last = shift[a][len - 1];
        shift[a][len..].fill(last);
        bounds[a] = range(&shift[a]);
    }
}

/// Lanes behind the values of a short row follow the last one, so that they neither tear the stretch apart nor matter.
#[inline(always)]
pub(crate) fn repeat_last<T: Real, const D: usize, const L: usize>(len: usize, shift: &mut [Lanes<T, L>; D]) {
    if len < L {
        for a in 0..D {
            let last = shift[a][len - 1];
            shift[a][len..].fill(last);
        }
    }
}
