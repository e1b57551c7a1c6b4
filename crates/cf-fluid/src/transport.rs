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
    faces: FaceField<T, D>,
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
            faces: FaceField::new(layout),
            work: [CellField::new(layout), CellField::new(layout)],
        }
    }

    /// Carries the faces `u` by `by` over `dt` \[s\], both continued into solids first.
    pub fn faces(&mut self, u: &mut FaceField<T, D>, by: &mut FaceField<T, D>, dt: f64, how: Interpolation) {
        self.prepare(by);
        self.prepare(u);
        let lattices = self.carry.faces.each_ref();
        let [_, back] = &mut self.work;
        let ratio = dt / self.grid.h();
        self.carry.carry_as(how, lattices, by, ratio, u.axes(), self.faces.axes_mut(), back);
        std::mem::swap(u, &mut self.faces);
    }

    /// Carries the cells `phi` by `by` over `dt` \[s\].
    pub fn cells(&mut self, phi: &mut CellField<T>, by: &mut FaceField<T, D>, dt: f64, how: Interpolation) {
        self.prepare(by);
        self.cells.continue_rows(phi);
        let [out, back] = &mut self.work;
        self.carry.carry_as(how, [&self.cells], by, dt / self.grid.h(), [phi], [&mut out[..]], back);
        std::mem::swap(phi, out);
    }

    fn prepare(&self, u: &mut FaceField<T, D>) {
        self.carry.fill_solids(u);
        self.carry.continue_faces(u);
    }
}

impl<T: Real> Transport<T, 3> {
    /// Carries the cells `phi` and the faces `u` by `by` over `dt` \[s\] in one sweep.
    pub fn all(
        &mut self,
        phi: &mut CellField<T>,
        u: &mut FaceField<T, 3>,
        by: &mut FaceField<T, 3>,
        dt: f64,
        how: Interpolation,
    ) {
        self.prepare(by);
        self.prepare(u);
        self.cells.continue_rows(phi);
        let [x, y, z] = self.carry.faces.each_ref();
        let [ux, uy, uz] = u.axes();
        let [ox, oy, oz] = self.faces.axes_mut();
        let [out, back] = &mut self.work;
        let ratio = dt / self.grid.h();
        self.carry.carry_as(how, [&self.cells, x, y, z], by, ratio, [phi, ux, uy, uz], [out, ox, oy, oz], back);
        std::mem::swap(phi, out);
        std::mem::swap(u, &mut self.faces);
    }
}
