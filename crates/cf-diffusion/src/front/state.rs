//! The unknowns of the front scheme: phi and the whole vector q_C, both at cell centres.

use cf_grid::{CellField, Grid, Real};

/// phi \[P\] and q_C \[P m/s\] per cell, collocated: a front is carried by phi and q together.
#[derive(Debug, Clone, PartialEq)]
pub struct FrontState<T, const D: usize> {
    /// The transported quantity.
    pub phi: CellField<T>,
    /// The flux with memory, one field per component.
    pub flux: [CellField<T>; D],
}

impl<T: Real, const D: usize> FrontState<T, D> {
    /// phi = 0 and q_C = 0 on a grid.
    pub fn new(grid: &Grid<D>) -> Self {
        Self { phi: CellField::new(grid.layout()), flux: std::array::from_fn(|_| CellField::new(grid.layout())) }
    }

    /// Total mass, sum phi h^D \[P m^D\], in `f64`.
    pub fn mass(&self, grid: &Grid<D>) -> f64 {
        grid.layout().sum(&self.phi) * grid.cell_volume()
    }

    /// Bytes of storage.
    pub fn bytes(&self) -> usize {
        self.phi.bytes() + self.flux.iter().map(CellField::bytes).sum::<usize>()
    }
}
