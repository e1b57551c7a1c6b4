//! Where a transported quantity has its values, and what it meets at the ends of each axis.

use std::ops::Range;

use cf_grid::{End, Layout, Region, Run, Sides, Wall};

/// The end of an axis as the transport sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// What the medium carries in; `None` where nothing passes.
    pub carried: Option<f64>,
    /// Distance from the outermost stored value to the wall \[cells\].
    pub reach: f64,
}

/// The cells, or the stored faces normal to one axis (a face on a `Flux`, `Absorbing` or `Open` wall
/// stores no q_C, one on a `Value` wall does).
#[derive(Debug, Clone)]
pub(super) struct Sites<const D: usize> {
    pub layout: Layout<D>,
    /// `None` for cells, the normal axis for faces.
    pub normal: Option<usize>,
    /// Indices that hold a value.
    pub region: Region<D>,
    pub edges: Sides<Edge, D>,
}

impl<const D: usize> Sites<D> {
    /// The cells: a medium flowing in carries what [`Wall::carried_in`] says.
    pub fn cells(layout: &Layout<D>, sides: &Sides<Wall, D>) -> Self {
        Self {
            layout: *layout,
            normal: None,
            region: layout.cells_region(),
            edges: sides.map(|_, _, wall| Edge { carried: wall.carried_in(), reach: 0.5 }),
        }
    }

    /// The faces normal to `axis`: a medium flowing in carries no flux.
    pub fn faces(layout: &Layout<D>, sides: &Sides<Wall, D>, axis: usize) -> Self {
        let mut region = layout.faces_region(axis, sides.is_periodic(axis));
        let edges = sides.map(|a, end, wall| {
            let stored = matches!(wall, Wall::Value(_));
            if a != axis {
                return Edge { carried: wall.carried_in().map(|_| 0.0), reach: 0.5 };
            }
            if !stored {
                match end {
                    End::Low => region.low[a] += 1,
                    End::High => region.high[a] -= 1,
                }
            }
            Edge { carried: Some(0.0), reach: if stored { 0.0 } else { 1.0 } }
        });
        Self { layout: *layout, normal: Some(axis), region, edges }
    }

    /// First and last index along `axis` that hold a value.
    pub fn span(&self, axis: usize) -> (usize, usize) {
        (self.region.low[axis], self.region.high[axis].saturating_sub(1))
    }

    /// Slot of a cell moved by `shift`; periodic axes wrap.
    pub fn slot(&self, mut cell: [usize; D], shift: [isize; D]) -> usize {
        for a in 0..D {
            let n = self.layout.cells()[a];
            let wraps = self.edges.is_periodic(a);
            cell[a] = match shift[a] {
                -1 if cell[a] == 0 && wraps => n - 1,
                1 if cell[a] + 1 == n && wraps => 0,
                by => cell[a].saturating_add_signed(by),
            };
        }
        self.layout.slot(cell)
    }

    /// Whether the cell `by` cells along `axis` is fluid, and every cell on the way; what lies beyond a wall counts as
    /// fluid.
    pub fn sees(&self, fluid: &[bool], cell: [usize; D], axis: usize, by: isize) -> bool {
        let n = self.layout.cells()[axis] as isize;
        (1..=by.abs()).all(|step| {
            let index = cell[axis] as isize + step * by.signum();
            let mut there = cell;
            there[axis] = index.rem_euclid(n) as usize;
            let beyond = !self.edges.is_periodic(axis) && !(0..n).contains(&index);
            beyond || fluid[self.layout.slot(there)]
        })
    }

    /// Whether a chunk and two cells on either side of it along `axis` are fluid, so that it meets no solid at all. Where
    /// the chunk comes near a periodic end of x, the answer is no.
    pub fn clear(&self, fluid: &[bool], chunk: Chunk<D>, axis: usize) -> bool {
        let cells = self.layout.cells();
        let around = if axis == 0 { 2 } else { 0 };
        let (first, end) = (chunk.cell[0].saturating_sub(around), chunk.cell[0] + chunk.len + around);
        if axis == 0 && self.edges.is_periodic(0) && (chunk.cell[0] < around || end > cells[0]) {
            return false;
        }
        let len = end.min(cells[0]).saturating_sub(first);
        let reach = if axis == 0 { 0..=0 } else { -2..=2 };
        reach.into_iter().all(|by: isize| {
            let mut cell = chunk.cell;
            cell[0] = first;
            if axis > 0 {
                let (n, index) = (cells[axis] as isize, chunk.cell[axis] as isize + by);
                if !self.edges.is_periodic(axis) && !(0..n).contains(&index) {
                    return true;
                }
                cell[axis] = index.rem_euclid(n) as usize;
            }
            let start = self.layout.slot(cell);
            // Without a way out early, which would go byte by byte.
            fluid[start..start + len].iter().fold(true, |all, &fluid| all & fluid)
        })
    }

    /// Whether the face of these sites at `cell` touches no solid; on a wall only the cell inside counts.
    pub fn open(&self, fluid: &[bool], cell: [usize; D]) -> bool {
        let Some(a) = self.normal else {
            return fluid[self.layout.slot(cell)];
        };
        let walls = self.at_walls(a, cell);
        let above = walls.1 || fluid[self.layout.slot(cell)];
        above && self.sees(fluid, cell, a, -1)
    }

    /// Whether `cell` lies on a wall of `axis`: the low one, the high one.
    pub fn at_walls(&self, axis: usize, cell: [usize; D]) -> (bool, bool) {
        let walls = !self.edges.is_periodic(axis);
        (walls && cell[axis] == 0, walls && cell[axis] == self.layout.cells()[axis])
    }
}

/// Longest chunk; buffers of this length live on the stack.
pub(super) const CHUNK: usize = 64;

/// At most [`CHUNK`] neighbouring values along x.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk<const D: usize> {
    /// Index of the first.
    pub cell: [usize; D],
    /// How many.
    pub len: usize,
}

impl<const D: usize> Chunk<D> {
    /// The chunk of `range` within a run.
    pub fn of(run: &Run<'_, D>, range: &Range<usize>) -> Self {
        let mut cell = run.cell;
        cell[0] += range.start;
        Self { cell, len: range.len() }
    }

    /// A run cut into chunks.
    pub fn ranges(len: usize) -> impl Iterator<Item = Range<usize>> {
        (0..len).step_by(CHUNK).map(move |start| start..(start + CHUNK).min(len))
    }

    /// The chunk's `i`-th value alone.
    pub fn one(mut self, i: usize) -> Self {
        self.cell[0] += i;
        self.len = 1;
        self
    }

    /// The chunk at another index of an axis other than x.
    pub fn at(mut self, axis: usize, index: usize) -> Self {
        self.cell[axis] = index;
        self
    }

    /// The chunk's own values.
    pub fn row<'f, V>(&self, layout: &Layout<D>, field: &'f [V]) -> &'f [V] {
        let start = layout.slot(self.cell);
        &field[start..start + self.len]
    }

    /// Values at the chunk moved by `shift` (-1, 0 or 1 per axis). Periodic axes wrap, except that along x the value
    /// beyond the end of the row is whatever the rim holds.
    pub fn moved<'f, V>(&self, sites: &Sites<D>, shift: [isize; D], field: &'f [V]) -> &'f [V] {
        let mut sideways = shift;
        sideways[0] = 0;
        let start = sites.slot(self.cell, sideways).wrapping_add_signed(shift[0]);
        &field[start..start + self.len]
    }
}

/// One step along `axis`.
pub(super) fn unit<const D: usize>(axis: usize, by: isize) -> [isize; D] {
    std::array::from_fn(|a| if a == axis { by } else { 0 })
}

/// The two cells (or faces) whose mean stands for a place between them, seen from index 0 or n of a wall axis: only
/// the one inside counts there.
pub(super) fn inside<const D: usize>(pair: [[isize; D]; 2], walls: (bool, bool)) -> [[isize; D]; 2] {
    match walls {
        (true, _) => [pair[1]; 2],
        (_, true) => [pair[0]; 2],
        _ => pair,
    }
}
