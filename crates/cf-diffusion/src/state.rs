//! The unknowns: phi on cells and, only where the law has memory, q_C on faces.

use cf_grid::{CellField, FaceField, Grid, Real};

use crate::law::Law;

/// phi \[P\] per cell and the normal component of q_C \[P m/s\] per face.
///
/// `slow_flux` is `None` for laws without memory (tau = 0 or F_T = 1): no memory, no time. Faces on closed, absorbing and
/// open walls hold zero; faces on value walls are unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct State<T, const D: usize> {
    /// The transported quantity.
    pub phi: CellField<T>,
    /// The flux with memory.
    pub slow_flux: Option<FaceField<T, D>>,
}

impl<T: Real, const D: usize> State<T, D> {
    /// phi = 0 and q_C = 0 on a grid, with what `law` needs.
    pub fn new(grid: &Grid<D>, law: &Law) -> Self {
        Self { phi: CellField::new(grid.layout()), slow_flux: law.has_memory().then(|| FaceField::new(grid.layout())) }
    }

    /// Total mass, sum phi h^D \[P m^D\], in `f64`.
    pub fn mass(&self, grid: &Grid<D>) -> f64 {
        grid.layout().sum(&self.phi) * grid.cell_volume()
    }

    /// Bytes of storage.
    pub fn bytes(&self) -> usize {
        self.phi.bytes() + self.slow_flux.as_ref().map_or(0, FaceField::bytes)
    }
}
