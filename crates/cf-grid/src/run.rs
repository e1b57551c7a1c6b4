//! What a loop hands to its body: a row with its neighbour rows, or one cell with its neighbours.

use crate::Layout;

/// A run of consecutive cells (or faces) along `x`. All slices it gives out have the same length.
#[derive(Debug, Clone, Copy)]
pub struct Run<'l, const D: usize> {
    pub(crate) layout: &'l Layout<D>,
    pub(crate) start: usize,
    pub(crate) len: usize,
    /// Index of the first cell of the run.
    pub cell: [usize; D],
}

impl<'l, const D: usize> Run<'l, D> {
    pub(crate) fn new(layout: &'l Layout<D>, cell: [usize; D], len: usize) -> Self {
        Self { layout, start: layout.slot(cell), len, cell }
    }

    /// Cells in the run.
    #[inline(always)]
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Slot of the first cell.
    #[inline(always)]
    pub fn slot(&self) -> usize {
        self.start
    }

    /// The layout the run belongs to.
    pub fn layout(&self) -> &'l Layout<D> {
        self.layout
    }

    /// The run's own values.
    #[inline(always)]
    pub fn row<'f, T>(&self, field: &'f [T]) -> &'f [T] {
        &field[self.start..self.start + self.len]
    }

    /// Values of the low neighbours along `axis`, rim included.
    #[inline(always)]
    pub fn low<'f, T>(&self, axis: usize, field: &'f [T]) -> &'f [T] {
        let start = self.start - self.layout.stride(axis);
        &field[start..start + self.len]
    }

    /// Values of the high neighbours along `axis`, rim included.
    #[inline(always)]
    pub fn high<'f, T>(&self, axis: usize, field: &'f [T]) -> &'f [T] {
        let start = self.start + self.layout.stride(axis);
        &field[start..start + self.len]
    }

    /// The run with one more value at either end of it (`len() + 2` values).
    #[inline(always)]
    pub fn wide<'f, T>(&self, field: &'f [T]) -> &'f [T] {
        &field[self.start - 1..self.start + self.len + 1]
    }

    /// `len` cells of the run from its cell `first` on.
    #[inline(always)]
    pub fn part(&self, first: usize, len: usize) -> Self {
        debug_assert!(first + len <= self.len);
        let mut cell = self.cell;
        cell[0] += first;
        Self { layout: self.layout, start: self.start + first, len, cell }
    }

    /// The run moved by `by` along an axis other than `x`; `None` where it would leave the cells.
    pub fn moved(&self, axis: usize, by: isize) -> Option<Self> {
        debug_assert!(axis > 0);
        let index = self.cell[axis].checked_add_signed(by).filter(|&i| i < self.layout.cells()[axis])?;
        let mut cell = self.cell;
        cell[axis] = index;
        Some(Self::new(self.layout, cell, self.len))
    }

    /// The run moved by `by` along a periodic axis other than `x`.
    pub fn wrapped(&self, axis: usize, by: isize) -> Self {
        debug_assert!(axis > 0);
        let n = self.layout.cells()[axis] as isize;
        let mut cell = self.cell;
        cell[axis] = (cell[axis] as isize + by).rem_euclid(n) as usize;
        Self::new(self.layout, cell, self.len)
    }

    /// The cells of the run one by one.
    pub fn ats(self) -> impl Iterator<Item = At<'l, D>> {
        (0..self.len).map(move |i| {
            let mut cell = self.cell;
            cell[0] += i;
            At { layout: self.layout, slot: self.start + i, cell }
        })
    }
}

/// One cell, or one face named by the cell above it.
#[derive(Debug, Clone, Copy)]
pub struct At<'l, const D: usize> {
    layout: &'l Layout<D>,
    slot: usize,
    /// Index of the cell.
    pub cell: [usize; D],
}

impl<const D: usize> At<'_, D> {
    /// Its slot.
    #[inline(always)]
    pub fn slot(&self) -> usize {
        self.slot
    }

    /// Slot of the low neighbour along `axis` (possibly in the rim).
    #[inline(always)]
    pub fn low(&self, axis: usize) -> usize {
        self.slot - self.layout.stride(axis)
    }

    /// Slot of the high neighbour along `axis` (possibly in the rim).
    #[inline(always)]
    pub fn high(&self, axis: usize) -> usize {
        self.slot + self.layout.stride(axis)
    }
}
