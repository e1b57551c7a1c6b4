//! The medium in numbers a sweep needs: signed Courant numbers ν = u dt/h on the ends of control volumes.

use cf_grid::{End, FaceField, Real};

use super::sites::{CHUNK, Chunk, Sites, inside, unit};

/// A moving medium over one (sub-)step.
#[derive(Debug, Clone, Copy)]
pub(super) enum Flow<'m, T, const D: usize> {
    /// ν per axis.
    Uniform([T; D]),
    /// ν = ratio u, ratio = dt/h [s/m].
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
                let walls = sites.normal.map_or((false, false), |a| sites.at_walls(a, chunk.cell));
                if sites.normal == Some(0) && !sites.edges.is_periodic(0) {
                    means(sites, axis, chunk, u.axis(axis), ratio, (false, false), low, high);
                    for i in [0, chunk.len - 1] {
                        let one = chunk.one(i);
                        let walls = sites.at_walls(0, one.cell);
                        if walls.0 || walls.1 {
                            let (low, high) = (&mut low[i..=i], &mut high[i..=i]);
                            means(sites, axis, one, u.axis(axis), ratio, walls, low, high);
                        }
                    }
                } else {
                    means(sites, axis, chunk, u.axis(axis), ratio, walls, low, high);
                }
            }
        }
        self.close(sites, axis, chunk, low, high);
    }

    fn close(&self, sites: &Sites<D>, axis: usize, chunk: Chunk<D>, low: &mut [T], high: &mut [T]) {
        if sites.normal.is_none()
            && let Some(fluid) = self.fluid
        {
            let (mut below, mut above) = ([false; CHUNK], [false; CHUNK]);
            let own = chunk.row(&sites.layout, fluid);
            let below = chunk.moved(sites, unit(axis, -1), fluid, &mut below);
            let above = chunk.moved(sites, unit(axis, 1), fluid, &mut above);
            let (first, last) = sites.span(axis);
            let walled = !sites.edges.is_periodic(axis);
            for i in 0..chunk.len {
                let index = chunk.cell[axis] + if axis == 0 { i } else { 0 };
                if !(own[i] && (below[i] || walled && index == first)) {
                    low[i] = T::ZERO;
                }
                if !(own[i] && (above[i] || walled && index == last)) {
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

/// low, high = ratio × the mean velocity on either end.
#[allow(clippy::too_many_arguments)]
fn means<T: Real, const D: usize>(
    sites: &Sites<D>,
    axis: usize,
    chunk: Chunk<D>,
    u: &[T],
    ratio: T,
    walls: (bool, bool),
    low: &mut [T],
    high: &mut [T],
) {
    let (here, next) = (unit(axis, 0), unit(axis, 1));
    let (low_pair, high_pair) = match sites.normal {
        None => ([here; 2], [next; 2]),
        Some(a) if a == axis => ([unit(a, -1), here], [here, next]),
        Some(a) => {
            let mut beside = next;
            beside[a] = -1;
            ([unit(a, -1), here], [beside, next])
        }
    };
    let (low_pair, high_pair) = match sites.normal {
        // Along the normal each end has its own pair, of which the wall takes one away.
        Some(a) if a == axis => (
            inside(low_pair, (walls.0, false)),
            inside(high_pair, (false, walls.1)),
        ),
        _ => (inside(low_pair, walls), inside(high_pair, walls)),
    };
    for (pair, out) in [(low_pair, low), (high_pair, high)] {
        let (mut first, mut second) = ([T::ZERO; CHUNK], [T::ZERO; CHUNK]);
        let a = chunk.moved(sites, pair[0], u, &mut first);
        if pair[0] == pair[1] {
            for (out, &a) in out.iter_mut().zip(a) {
                *out = ratio * a;
            }
            continue;
        }
        let b = chunk.moved(sites, pair[1], u, &mut second);
        let half = ratio * T::of(0.5);
        for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
            *out = half * (a + b);
        }
    }
}
