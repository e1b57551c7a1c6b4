//! Semi-Lagrangian transport on its own: of velocities by velocities, and of cell values for previews.

use cf_grid::{CellField, End, FaceField, Grid, Mask, Real, Sides};

use crate::carry::{Carry, Interpolation};
use crate::lattice::Lattice;
use crate::wall::FlowWall;

/// Carries cells and faces of one domain by a velocity \[m/s\] on its faces: unconditionally stable, not conservative.
/// For a transport that keeps the mass, see [`cf_diffusion::Advector`].
pub struct Transport<T, const D: usize> {
    grid: Grid<D>,
    carry: Carry<D>,
    cells: Lattice<D>,
    work: [CellField<T>; 2],
}

impl<T: Real, const D: usize> Transport<T, D> {
    /// Storage for transport on `grid`; `inflow` is the cell value that comes in through a wall.
    pub fn new(
        grid: &Grid<D>,
        sides: &Sides<FlowWall<D>, D>,
        mask: Option<&Mask<D>>,
        inflow: impl Fn(usize, End) -> f64,
    ) -> Self {
        let layout = grid.layout();
        Self {
            grid: *grid,
            carry: Carry::new(layout, sides, mask),
            cells: Lattice::cells(layout, sides, inflow),
            work: [CellField::new(layout), CellField::new(layout)],
        }
    }

    /// Carries the faces `u` by `by` over `dt` \[s\], both continued into solids first.
    pub fn faces(&mut self, u: &mut FaceField<T, D>, by: &mut FaceField<T, D>, dt: f64, how: Interpolation) {
        self.carry.fill_solids(by);
        self.carry.fill_solids(u);
        for c in 0..D {
            self.one(Some(c), &mut u.fields_mut()[c], by, dt, how);
        }
    }

    /// Carries the cells `phi` by `by` over `dt` \[s\].
    pub fn cells(&mut self, phi: &mut CellField<T>, by: &mut FaceField<T, D>, dt: f64, how: Interpolation) {
        self.carry.fill_solids(by);
        self.one(None, phi, by, dt, how);
    }

    fn one(
        &mut self,
        axis: Option<usize>,
        field: &mut CellField<T>,
        by: &FaceField<T, D>,
        dt: f64,
        how: Interpolation,
    ) {
        let lattice = axis.map_or(&self.cells, |a| &self.carry.faces[a]);
        let [out, back] = &mut self.work;
        self.carry.carry_as(how, lattice, by, dt / self.grid.h(), field, out, back);
        std::mem::swap(field, out);
    }
}
