//! One V(1,1) cycle in two sweeps a level, for uniform coefficients on a box.
//!
//! The cycle starts from a zero guess, so that smoothing forward, red then black, needs the right-hand side b alone, and
//! leaves a residual in the red cells alone. [`descend`](Fused::descend) forms both in passing and stores only the
//! restricted residual: one pass, and 1/2^D of one. On the way up the black values of the first smoothing are never
//! read, since black comes first when colours are reversed: [`ascend`](Fused::ascend) starts again from b at the red
//! cells, adds the prolonged correction, smooths black, then red: it reads b and writes x: two passes. Inner products
//! that conjugate gradients ask for are formed on the way.
//!
//! | sweep | reads | writes | passes |
//! |---|---|---|---|
//! | descend | b | coarse b | 1 + 2^-D |
//! | ascend | b, coarse x | x | 2 + 2^-D |
//!
//! Intermediate results live in rings of half rows ([`tile`], [`rows`]).

mod ascend;
mod descend;
mod rows;
mod taps;
mod tile;

use cf_grid::{Layout, Real};

use self::rows::{Around, RowTable, padded};
use self::taps::{Across, Along};
use self::tile::{Ring, room};
use crate::axis::Interpolation;
use crate::stencil::BoxStencil;

/// What both sweeps know of a level and the next coarser one.
#[derive(Debug, Clone)]
pub(crate) struct Fused<T, const D: usize> {
    fine: Layout<D>,
    coarse: Layout<D>,
    periodic: [bool; D],
    table: RowTable<T, D>,
    along: Along<T>,
    across: [Across; D],
}

/// Scratch of one thread.
pub(crate) type Scratch<T> = Vec<T>;

/// Inner products of b and x = M b, formed while x is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Products {
    /// b·x.
    pub bx: f64,
    /// x·A x.
    pub xax: f64,
    /// Sum of x.
    pub x: f64,
}

impl Products {
    /// Adds what a sweep formed in lanes.
    fn add(&mut self, sums: &rows::Sums) {
        let [bx, xax, x] = sums.each_ref().map(|lanes| lanes.iter().sum::<f64>());
        *self = Self { bx: self.bx + bx, xax: self.xax + xax, x: self.x + x };
    }
}

/// The inside of the box as strips and slabs see it: any plane and row number, whether it exists or not.
#[derive(Clone, Copy)]
struct Place<const D: usize> {
    cells: [usize; D],
    periodic: [bool; D],
}

impl<const D: usize> Place<D> {
    /// The first cell of row `j` of plane `v`; `None` behind a wall.
    #[inline(always)]
    fn cell(&self, v: isize, j: isize) -> Option<[usize; D]> {
        let mut cell = [0; D];
        if D == 3 {
            cell[1] = self.index(1, j)?;
        }
        cell[D - 1] = self.index(D - 1, v)?;
        Some(cell)
    }

    #[inline(always)]
    fn index(&self, a: usize, i: isize) -> Option<usize> {
        let n = self.cells[a];
        if (0..n as isize).contains(&i) {
            Some(i as usize)
        } else if self.periodic[a] {
            Some(i.rem_euclid(n as isize) as usize)
        } else {
            None
        }
    }
}

/// (j + v) % 2: the parity of the red cells of a row.
#[inline(always)]
fn parity(v: isize, j: isize) -> usize {
    (v + j).rem_euclid(2) as usize
}

impl<T: Real, const D: usize> Fused<T, D> {
    /// For a level with more than one cell along x whose periodic axes are even (or single cells): elsewhere two cells
    /// of one colour are neighbours.
    pub fn new(
        stencil: &BoxStencil<D>,
        fine: &Layout<D>,
        coarse: &Layout<D>,
        axes: &[Interpolation; D],
    ) -> Option<Self> {
        let fits = |a: usize| !stencil.axes[a].periodic || fine.cells()[a].is_multiple_of(2) || fine.cells()[a] == 1;
        if fine.cells()[0] == 1 || !(0..D).all(fits) {
            return None;
        }
        let periodic = std::array::from_fn(|a| stencil.axes[a].periodic);
        Some(Self {
            fine: *fine,
            coarse: *coarse,
            periodic,
            table: RowTable::new(stencil),
            along: Along::new(&axes[0], periodic[0]),
            across: std::array::from_fn(|a| Across::new(&axes[a])),
        })
    }

    /// Numbers of scratch a thread needs.
    pub fn scratch(&self) -> usize {
        let halves = (self.descend_rows() * descend::HALVES).max(self.ascend_rows() * ascend::HALVES);
        // Four rings and two rows.
        room::<T>(6, halves + 2, padded(self.fine.cells()[0]))
    }

    /// Planes a sweep has sums for.
    pub fn planes(&self) -> usize {
        self.fine.cells()[D - 1]
    }

    /// Bytes of tables.
    pub fn bytes(&self) -> usize {
        8 * self.fine.cells()[0] * size_of::<T>() + self.table.bytes()
    }

    fn place(&self) -> Place<D> {
        Place { cells: self.fine.cells(), periodic: self.periodic }
    }

    /// Rows of a plane.
    fn rows(&self) -> usize {
        if D == 3 { self.fine.cells()[1] } else { 1 }
    }

    /// Rows a strip reaches beyond itself, per row that a two-dimensional plane has none of.
    fn halo(&self, halo: usize) -> usize {
        if D == 3 { halo } else { 0 }
    }
}

/// The neighbours of row `r` of plane `v`, all from the ring of the other colour.
#[inline(always)]
fn around<'r, T: Real, const D: usize>(ring: &'r Ring<'_, T>, v: isize, r: usize) -> Around<'r, T, D> {
    let row = ring.row(v, r);
    let (mut low, mut high) = ([row; D], [row; D]);
    (low[D - 1], high[D - 1]) = (ring.row(v - 1, r), ring.row(v + 1, r));
    if D == 3 {
        (low[1], high[1]) = (ring.row(v, r.wrapping_sub(1)), ring.row(v, r + 1));
    }
    Around { row, low, high }
}
