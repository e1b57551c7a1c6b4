//! Where the fluid of a slab of cells came from, for everything that is carried at once.
//!
//! Trajectories are traced from cell centres, once per cell, and those of faces are the means of their two cells': as accurate as the
//! interpolation of the velocity that both are made from, a third of the work for three components and a quarter with a
//! scalar. Displacements live in a ring of two planes, strip by strip, that stays in the cache.

use cf_grid::{Real, vectorised};

use crate::carry::Carry;
use crate::chunk::{FEW, LANES, Lanes, few, lanes};
use crate::trace::{feet, repeat_last};

/// Cells of a row that are done together.
pub(crate) const TILE: usize = 256;
/// Rows of a strip.
pub(crate) const STRIP: usize = 32;
/// A row of displacements: one value before the first, one behind the last, and lanes that do not matter.
const ROOM: usize = TILE + 2 + LANES;

/// Displacements \[cells\] of a row, by axis.
type Row<T, const D: usize> = [[T; ROOM]; D];

/// Cells whose displacements are known: those of `width` columns from `x` on and rows from `j` on, one more on the low side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tile {
    pub x: usize,
    pub width: usize,
    pub j: usize,
    pub rows: usize,
}

/// Displacements of the cells of two planes: half a megabyte, too much for the stack of a thread.
pub(crate) struct Ring<T, const D: usize>([Vec<Row<T, D>>; 2]);

impl<T: Real, const D: usize> Ring<T, D> {
    pub fn new() -> Self {
        let plane = || vec![[[T::ZERO; ROOM]; D]; STRIP + 1];
        Self([plane(), plane()])
    }

    /// Traces the cells of plane `k`, in place of the plane before the last; planes and rows may lie beyond the box.
    #[inline(always)]
    pub fn trace(&mut self, by: &Tracing<'_, T, D>, k: i64) {
        let tile = by.tile;
        let plane = &mut self.0[k.rem_euclid(2) as usize];
        for (r, row) in plane.iter_mut().enumerate().take(tile.rows + 1) {
            let j = (tile.j + r) as i64 - 1;
            if D == 2 && r == 0 {
                continue;
            }
            by.row(if D == 2 { [0, k] } else { [j, k] }, row);
        }
    }

    /// Displacements of a stretch of `len` values: of cells, or of faces normal to `axis`, from column `x` of row `j`, plane `k`.
    #[inline(always)]
    pub fn of<const L: usize>(
        &self,
        axis: Option<usize>,
        tile: Tile,
        x: usize,
        j: usize,
        k: i64,
        len: usize,
    ) -> [Lanes<T, L>; D] {
        let zero = [T::ZERO; L];
        let (r, at) = (j - tile.j + 1, x - tile.x + 1);
        let here = &self.0[k.rem_euclid(2) as usize][r];
        let (below, low) = match axis {
            None => (here, at),
            Some(0) => (here, at - 1),
            Some(1) if D == 3 => (&self.0[k.rem_euclid(2) as usize][r - 1], at),
            Some(_) => (&self.0[(k - 1).rem_euclid(2) as usize][r], at),
        };
        let half = T::of(0.5);
        let mut shift = [zero; D];
        for a in 0..D {
            // A row has room for both.
            let (Some(d), Some(e)) = (lanes::<T, L>(&here[a], at), lanes::<T, L>(&below[a], low)) else {
                return shift;
            };
            for i in 0..L {
                shift[a][i] = half * (d[i] + e[i]);
            }
        }
        repeat_last(len, &mut shift);
        shift
    }
}

/// A velocity that traces over dt = `ratio` h \[s/m\], and where.
#[derive(Clone, Copy)]
pub(crate) struct Tracing<'a, T, const D: usize> {
    pub carry: &'a Carry<D>,
    pub u: [&'a [T]; D],
    pub ratio: f64,
    pub tile: Tile,
}

impl<T: Real, const D: usize> Tracing<'_, T, D> {
    /// One row of the tile, `[j, k]` its place along the other axes.
    #[inline(always)]
    fn row(&self, [j, k]: [i64; 2], row: &mut Row<T, D>) {
        let Tile { x, width, .. } = self.tile;
        let (cells, n) = (&self.carry.cells, self.carry.layout.cells()[0]);
        let mut cell = [0; D];
        let mut flip = [false; D];
        for (a, index) in [(1, j), (D - 1, k)] {
            cell[a] = cells.place(a, index).0 as i64;
            flip[a] = self.carry.turns(a, index);
        }
        let end = x + width;
        let mut i = self.first();
        while end - i >= LANES {
            self.stretch::<LANES>(cell, i, LANES, row);
            i += LANES;
        }
        if i < end {
            self.rest(cell, i, row);
        }
        for (index, at) in [(-1, 0), (n as i64, width + 1)] {
            if index != -1 && end < n || index == -1 && x > 0 {
                continue;
            }
            let from = cells.place(0, index).0;
            if (x..end).contains(&from) {
                let turns = self.carry.turns(0, index);
                for a in 0..D {
                    let d = row[a][from - x + 1];
                    row[a][at] = if a == 0 && turns { -d } else { d };
                }
            } else {
                let shift: [Lanes<T, FEW>; D] = self.feet(cell, from, 1);
                for a in 0..D {
                    row[a][at] = shift[a][0];
                }
            }
        }
        for a in 1..D {
            if flip[a] {
                row[a].iter_mut().for_each(|d| *d = -*d);
            }
        }
    }

    /// The first column that is traced: a whole periodic row knows what is before it; so does a row at a wall.
    fn first(&self) -> usize {
        self.tile.x.saturating_sub(1)
    }

    /// Displacements from column `x` on; `cell` holds the place along the other axes.
    #[inline(always)]
    fn feet<const L: usize>(&self, mut cell: [i64; D], x: usize, len: usize) -> [Lanes<T, L>; D] {
        cell[0] = x as i64;
        feet(&self.carry.cells, &self.carry.faces, &self.u, self.ratio, cell, len)
    }

    /// `len` cells of a row, at most `L`.
    #[inline(always)]
    fn stretch<const L: usize>(&self, cell: [i64; D], x: usize, len: usize, row: &mut Row<T, D>) {
        let shift: [Lanes<T, L>; D] = self.feet(cell, x, len);
        let at = x + 1 - self.tile.x;
        for a in 0..D {
            row[a][at..at + len].copy_from_slice(&shift[a][..len]);
        }
    }

    /// The end of a row.
    #[inline(never)]
    fn rest(&self, cell: [i64; D], x: usize, row: &mut Row<T, D>) {
        vectorised(
            #[inline(always)]
            || {
                for (x, len) in few(self.first(), x, self.tile.x + self.tile.width) {
                    self.stretch::<FEW>(cell, x, len, row);
                }
            },
        );
    }
}
