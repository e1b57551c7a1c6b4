//! A layout placed in space: origin and spacing.

use nalgebra::SVector;

use crate::{GridError, Layout};

/// A box of cubic cells of edge `h` \[m\] whose low corner is at `origin` \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid<const D: usize> {
    layout: Layout<D>,
    origin: SVector<f64, D>,
    h: f64,
}

impl<const D: usize> Grid<D> {
    /// `cells` per axis, spacing `h` \[m\], origin at zero.
    pub fn new(cells: [usize; D], h: f64) -> Result<Self, GridError> {
        if !(h.is_finite() && h > 0.0) {
            return Err(GridError::Spacing(h));
        }
        Ok(Self { layout: Layout::new(cells)?, origin: SVector::zeros(), h })
    }

    /// The same grid with its low corner at `origin` \[m\].
    pub fn with_origin(mut self, origin: [f64; D]) -> Result<Self, GridError> {
        for (axis, &value) in origin.iter().enumerate() {
            if !value.is_finite() {
                return Err(GridError::Origin { axis, value });
            }
        }
        self.origin = SVector::from(origin);
        Ok(self)
    }

    /// The storage layout.
    pub fn layout(&self) -> &Layout<D> {
        &self.layout
    }

    /// Cells per axis.
    pub fn cells(&self) -> [usize; D] {
        self.layout.cells()
    }

    /// Cell edge \[m\].
    pub fn h(&self) -> f64 {
        self.h
    }

    /// Low corner \[m\].
    pub fn origin(&self) -> SVector<f64, D> {
        self.origin
    }

    /// Edge lengths of the box \[m\].
    pub fn extent(&self) -> SVector<f64, D> {
        SVector::from(self.cells()).map(|n: usize| n as f64 * self.h)
    }

    /// Volume of a cell, h^D \[m^D\].
    pub fn cell_volume(&self) -> f64 {
        self.h.powi(D as i32)
    }

    /// Centre of a cell \[m\].
    pub fn centre(&self, cell: [usize; D]) -> SVector<f64, D> {
        self.origin + SVector::from(cell).map(|i: usize| (i as f64 + 0.5) * self.h)
    }

    /// Centre of the low face of a cell along `axis` \[m\].
    pub fn face(&self, axis: usize, cell: [usize; D]) -> SVector<f64, D> {
        let mut x = self.centre(cell);
        x[axis] = self.origin[axis] + cell[axis] as f64 * self.h;
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_of_cells_and_faces() {
        let grid = Grid::new([4, 8], 0.5).unwrap().with_origin([1.0, -1.0]).unwrap();
        assert_eq!(grid.centre([0, 0]).as_slice(), [1.25, -0.75]);
        assert_eq!(grid.face(1, [0, 8]).as_slice(), [1.25, 3.0]);
        assert_eq!(grid.extent().as_slice(), [2.0, 4.0]);
        assert!(matches!(Grid::new([4, 4], f64::NAN), Err(GridError::Spacing(_))));
        assert!(matches!(Grid::new([4, 4], -1.0), Err(GridError::Spacing(_))));
    }
}
