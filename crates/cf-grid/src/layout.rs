//! The padded box: how a cell index becomes a slot.

use crate::GridError;

/// A box of cells stored with `x` contiguous and a rim of one cell on every side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout<const D: usize> {
    cells: [usize; D],
    stride: [usize; D],
    slots: usize,
}

/// A box of indices `low[a]..high[a]` inside a layout; `high` may reach one past the cells to cover high-wall faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region<const D: usize> {
    /// First index per axis.
    pub low: [usize; D],
    /// One past the last index per axis.
    pub high: [usize; D],
}

impl<const D: usize> Region<D> {
    /// True when no index lies inside.
    pub fn is_empty(&self) -> bool {
        (0..D).any(|a| self.low[a] >= self.high[a])
    }
}

impl<const D: usize> Layout<D> {
    /// A layout of `cells` cells per axis (each at least 1).
    pub fn new(cells: [usize; D]) -> Result<Self, GridError> {
        if !(2..=3).contains(&D) {
            return Err(GridError::Dimension(D));
        }
        let mut stride = [0; D];
        let mut slots = 1usize;
        for a in 0..D {
            if cells[a] == 0 {
                return Err(GridError::Empty { axis: a, cells: cells[a] });
            }
            stride[a] = slots;
            slots = cells[a]
                .checked_add(2)
                .and_then(|n| slots.checked_mul(n))
                .filter(|&n| n <= isize::MAX as usize / 8)
                .ok_or_else(|| GridError::TooLarge(cells.to_vec()))?;
        }
        Ok(Self { cells, stride, slots })
    }

    /// Cells per axis.
    pub fn cells(&self) -> [usize; D] {
        self.cells
    }

    /// Number of cells, rim excluded.
    pub fn count(&self) -> usize {
        self.cells.iter().product()
    }

    /// Length of every field on this layout, rim included.
    pub fn slots(&self) -> usize {
        self.slots
    }

    /// Slot distance between neighbours along `axis`.
    pub fn stride(&self, axis: usize) -> usize {
        self.stride[axis]
    }

    /// Slot of a cell, or of its low face along any axis. Indices up to `cells[a]` (the high rim) are valid.
    #[inline(always)]
    pub fn slot(&self, cell: [usize; D]) -> usize {
        let mut slot = 0;
        for a in 0..D {
            debug_assert!(cell[a] <= self.cells[a]);
            slot += (cell[a] + 1) * self.stride[a];
        }
        slot
    }

    /// All cells.
    pub fn cells_region(&self) -> Region<D> {
        Region { low: [0; D], high: self.cells }
    }

    /// All faces normal to `axis`: `cells[axis] + 1` of them along it, or `cells[axis]` when the axis is periodic.
    pub fn faces_region(&self, axis: usize, periodic: bool) -> Region<D> {
        let mut region = self.cells_region();
        region.high[axis] += usize::from(!periodic);
        region
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_count_the_rim_and_run_along_x() {
        let layout = Layout::new([4, 3, 2]).unwrap();
        assert_eq!(layout.slots(), 6 * 5 * 4);
        assert_eq!(layout.slot([1, 0, 0]), layout.slot([0, 0, 0]) + 1);
        assert_eq!(layout.slot([0, 1, 0]), layout.slot([0, 0, 0]) + 6);
        assert_eq!(layout.slot([0, 0, 1]), layout.slot([0, 0, 0]) + 30);
    }

    #[test]
    fn impossible_boxes_are_refused() {
        assert!(matches!(Layout::new([4, 0]), Err(GridError::Empty { axis: 1, .. })));
        assert!(matches!(Layout::new([usize::MAX, 2]), Err(GridError::TooLarge(_))));
        assert!(matches!(Layout::new([1 << 40, 1 << 40]), Err(GridError::TooLarge(_))));
        assert!(matches!(Layout::new([3]), Err(GridError::Dimension(1))));
    }
}
