//! The medium in numbers a sweep needs: signed Courant numbers ν = u dt/h on the ends of control volumes.

use cf_grid::{End, FaceField, Real};

use super::sites::{Chunk, Sites, inside, unit};

/// A moving medium over one (sub-)step.
#[derive(Debug, Clone, Copy)]
pub(super) enum Flow<'m, T, const D: usize> {
    /// ν per axis.
    Uniform([T; D]),
    /// ν = ratio u, ratio = dt/h \[s/m\].
    Field { u: &'m FaceField<T, D>, ratio: T },
}

/// A medium and the obstacles in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stream<'m, T, const D: usize> {
    pub flow: Flow<'m, T, D>,
    /// Fluid flags by slot.
    pub fluid: Option<&'m [bool]>,
}

impl<T: Real, const D: usize> Stream<'_, T, D> {
    /// ν along `axis` where it is the same on every face.
    pub fn uniform(&self, axis: usize) -> Option<T> {
        match (self.flow, self.fluid) {
            (Flow::Uniform(nu), None) => Some(nu[axis]),
            _ => None,
        }
    }

    /// ν on the low and the high end, along `axis`, of the control volumes of a chunk.
    ///
    /// Cells have the face velocities themselves, and 0 on faces that touch a solid. The volumes of faces are shifted by
    /// half a cell along their normal and have the means of two neighbours, or the one inside at a wall. Nothing passes
    /// an end whose [`Edge`](super::sites::Edge) carries nothing.
    pub fn speeds(&self, sites: &Sites<D>, axis: usize, chunk: Chunk<D>, low: &mut [T], high: &mut [T]) {
        match self.flow {
            Flow::Uniform(nu) => {
                low.fill(nu[axis]);
                high.fill(nu[axis]);
            }
            Flow::Field { u, ratio } => {
                let u = u.axis(axis);
                rows(sites, axis, chunk, u, ratio, low, high);
                // The ends of a row along x: wrapped, or at a wall.
                let n = sites.layout.cells()[0];
                for i in [0, chunk.len - 1] {
                    let cell = chunk.one(i).cell;
                    if cell[0] == 0 || cell[0] + 1 >= n {
                        (low[i], high[i]) = one(sites, axis, cell, u, ratio);
                    }
                }
            }
        }
        self.close(sites, axis, chunk, low, high);
    }

    fn close(&self, sites: &Sites<D>, axis: usize, chunk: Chunk<D>, low: &mut [T], high: &mut [T]) {
        if sites.normal.is_none()
            && let Some(fluid) = self.fluid
            && !sites.clear(fluid, chunk, axis)
        {
            for i in 0..chunk.len {
                let cell = chunk.one(i).cell;
                let own = fluid[sites.layout.slot(cell)];
                if !(own && sites.sees(fluid, cell, axis, -1)) {
                    low[i] = T::ZERO;
                }
                if !(own && sites.sees(fluid, cell, axis, 1)) {
                    high[i] = T::ZERO;
                }
            }
        }
        let closed = |end| sites.edges.wall(axis, end).is_some_and(|e| e.carried.is_none());
        let (first, last) = sites.span(axis);
        let (start, end) = match axis {
            0 => (chunk.cell[0], chunk.cell[0] + chunk.len - 1),
            _ => (chunk.cell[axis], chunk.cell[axis]),
        };
        let row = |v: &mut [T], i: usize| if axis == 0 { v[i] = T::ZERO } else { v.fill(T::ZERO) };
        if closed(End::Low) && start == first {
            row(low, 0);
        }
        if closed(End::High) && end == last {
            row(high, chunk.len - 1);
        }
    }
}

/// The places whose mean velocity is that on the low and on the high end of a control volume.
fn pairs<const D: usize>(sites: &Sites<D>, axis: usize, cell: [usize; D]) -> [[[isize; D]; 2]; 2] {
    let (here, next) = (unit(axis, 0), unit(axis, 1));
    let Some(normal) = sites.normal else {
        return [[here; 2], [next; 2]];
    };
    let (at_low, at_high) = sites.at_walls(normal, cell);
    if normal == axis {
        return [inside([unit(axis, -1), here], (at_low, false)), inside([here, next], (false, at_high))];
    }
    let mut beside = next;
    beside[normal] = -1;
    [[unit(normal, -1), here], [beside, next]].map(|pair| inside(pair, (at_low, at_high)))
}

/// ν of a chunk; right but for the ends of a row along x.
fn rows<T: Real, const D: usize>(
    sites: &Sites<D>,
    axis: usize,
    chunk: Chunk<D>,
    u: &[T],
    ratio: T,
    low: &mut [T],
    high: &mut [T],
) {
    let mut cell = chunk.cell;
    if sites.normal == Some(0) {
        cell[0] = 1; // away from the walls, as most of the row
    }
    for (pair, out) in pairs(sites, axis, cell).into_iter().zip([low, high]) {
        let a = chunk.moved(sites, pair[0], u);
        if pair[0] == pair[1] {
            for (out, &a) in out.iter_mut().zip(a) {
                *out = ratio * a;
            }
            continue;
        }
        let (b, half) = (chunk.moved(sites, pair[1], u), ratio * T::of(0.5));
        for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
            *out = half * (a + b);
        }
    }
}

/// ν of one control volume.
fn one<T: Real, const D: usize>(sites: &Sites<D>, axis: usize, cell: [usize; D], u: &[T], ratio: T) -> (T, T) {
    let [low, high] = pairs(sites, axis, cell).map(|pair| {
        let [a, b] = pair.map(|shift| u[sites.slot(cell, shift)]);
        if pair[0] == pair[1] { ratio * a } else { ratio * T::of(0.5) * (a + b) }
    });
    (low, high)
}
